//! Phase, coherence and shapes of a record.

use crate::identify::mode::Mode;
use crate::identify::record::Marker;
use crate::identify::record_modes::IdentifiedRecord;
use crate::identify::spectra::Averaged;
use crate::report::drawing::{
    Axis, Canvas, Entry, Frame, GREY, INK, Panel, Scale, Stroke, Swatch, bounds, column,
    curve_style, labels_on_top,
};
use crate::units::{deg_from_rad, mm_from_m};

use super::svg::{LEFT, LEGEND_LEFT, LEGEND_WIDTH, MAX_POINTS, PANEL_WIDTH, WIDTH, modes};

/// At most so many responses are drawn, as the legend has room for no more.
const MAX_RESPONSES: usize = 8;

/// Phase of H1 of each response over frequency, where a force was measured.
pub(super) fn phase(record: &IdentifiedRecord) -> Option<Canvas> {
    let averaged = record.averaged.as_ref()?;
    let y = Axis::new("phase [°]", Scale::linear(-180.0, 180.0));
    let degrees = |response: usize, line: usize| {
        averaged.h1.get(response)?.get(line).map(|h| deg_from_rad(h.arg()))
    };
    over_frequency(record, averaged, y, 190.0, &degrees)
}

/// γ² of each response over frequency, where several records were averaged.
pub(super) fn coherence(record: &IdentifiedRecord) -> Option<Canvas> {
    let averaged = record.averaged.as_ref().filter(|averaged| !averaged.coherence.is_empty())?;
    let y = Axis::new("coherence γ²", Scale::linear(0.0, 1.0));
    let of = |response: usize, line: usize| averaged.coherence.get(response)?.get(line).copied();
    over_frequency(record, averaged, y, 150.0, &of)
}

fn over_frequency(
    record: &IdentifiedRecord,
    averaged: &Averaged,
    y: Axis,
    height: f64,
    of: &dyn Fn(usize, usize) -> Option<f64>,
) -> Option<Canvas> {
    let lines = &averaged.frequencies_hz;
    let (low, high) = bounds(lines.iter().copied());
    if lines.len() < 2 || low >= high {
        return None;
    }
    let frame = Frame { left: LEFT, top: 20.0, width: PANEL_WIDTH, height };
    let panel = Panel { frame, x: Axis::new("frequency [Hz]", Scale::linear(0.0, high)), y };
    let mut canvas = Canvas::new(WIDTH, height + 75.0);
    panel.axes(&mut canvas, true);
    labels_on_top(&mut canvas, &panel, &modes(record, false));
    let step = lines.len().div_ceil(MAX_POINTS).max(1);
    let mut entries = Vec::new();
    for (index, response) in record.spectra.iter().enumerate().take(MAX_RESPONSES) {
        let (colour, dashes) = curve_style(index);
        let stroke = Stroke { colour, width: 1.2, dashes };
        let point = |line: usize| Some((*lines.get(line)?, of(index, line)?));
        let points: Vec<(f64, f64)> = (0..lines.len()).step_by(step).filter_map(point).collect();
        panel.curve(&mut canvas, &points, stroke);
        entries.push(Entry::new(Swatch::Line(stroke), response.response.as_str()));
    }
    canvas.border(frame);
    column(&mut canvas, (LEGEND_LEFT, frame.top), LEGEND_WIDTH, &entries);
    Some(canvas)
}

/// Each mode's shape on the marked points: the links at rest and displaced, an arrow at each point,
/// the largest a fifth of the picture; both axes alike. `None` without marked points that moved.
pub(super) fn arrows(record: &IdentifiedRecord) -> Option<Canvas> {
    let points: Vec<[f64; 2]> =
        record.links.iter().flat_map(|link| &link.markers).map(|marker| marker.at_m).collect();
    let (left, right) = bounds(points.iter().map(|p| mm_from_m(p[0])));
    let (low, high) = bounds(points.iter().map(|p| mm_from_m(p[1])));
    let extent = (right - left).max(high - low);
    if record.modes.is_empty() || !(extent > 0.0 && extent.is_finite()) {
        return None;
    }
    const SIDE: f64 = 330.0;
    const COLUMN: f64 = 470.0;
    let half = 0.75 * extent;
    let around = |low: f64, high: f64| {
        let middle = 0.5 * (low + high);
        Scale::linear(middle - half, middle + half)
    };
    let lines = record.modes.len().div_ceil(2);
    let mut canvas = Canvas::new(WIDTH, (SIDE + 95.0) * lines as f64);
    for (index, mode) in record.modes.iter().enumerate() {
        let frame = Frame {
            left: LEFT + COLUMN * (index % 2) as f64,
            top: 30.0 + (SIDE + 95.0) * (index / 2) as f64,
            width: SIDE,
            height: SIDE,
        };
        let panel = Panel {
            frame,
            x: Axis::new("x [mm]", around(left, right)),
            y: Axis::new("y [mm]", around(low, high)),
        };
        panel.title(&mut canvas, &format!("Mode {}, {:.2} Hz", index + 1, mode.frequency_hz));
        panel.axes(&mut canvas, true);
        let (colour, _) = curve_style(index);
        draw_arrows(&mut canvas, &panel, record, mode, 0.3 * extent, colour);
        canvas.border(frame);
    }
    Some(canvas)
}

/// `longest` is the length, mm in the picture, of the largest displacement.
fn draw_arrows(
    canvas: &mut Canvas,
    panel: &Panel,
    record: &IdentifiedRecord,
    mode: &Mode,
    longest: f64,
    colour: &str,
) {
    let part = |name: &str| {
        let part = mode.shape.iter().find(|part| part.response == name);
        part.map_or(0.0, |part| part.value.re)
    };
    let moved = |marker: &Marker| -> [f64; 2] {
        marker.channels.as_ref().map_or([0.0; 2], |[x, y]| [part(x), part(y)])
    };
    let all = record.links.iter().flat_map(|link| &link.markers);
    let largest = all.map(|marker| moved(marker)[0].hypot(moved(marker)[1])).fold(0.0, f64::max);
    if largest <= 0.0 {
        return;
    }
    let rest = Stroke { colour: GREY, width: 3.0, dashes: "" };
    let bent = Stroke { colour, width: 2.0, dashes: "7 4" };
    let arrow = Stroke { colour, width: 2.4, dashes: "" };
    for link in &record.links {
        let at = |marker: &Marker| (mm_from_m(marker.at_m[0]), mm_from_m(marker.at_m[1]));
        let to = |marker: &Marker| {
            let ((x, y), [dx, dy]) = (at(marker), moved(marker));
            (x + longest * dx / largest, y + longest * dy / largest)
        };
        let still: Vec<(f64, f64)> = link.markers.iter().map(at).collect();
        let displaced: Vec<(f64, f64)> = link.markers.iter().map(to).collect();
        panel.curve(canvas, &still, rest);
        panel.curve(canvas, &displaced, bent);
        for (from, to) in still.into_iter().zip(displaced) {
            panel.dot(canvas, from, 4.0, INK);
            panel.curve(canvas, &[from, to], arrow);
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            let length = dx.hypot(dy);
            if length > 0.02 * longest {
                let head = 0.12 * longest / length;
                let side =
                    |turn: f64| (to.0 - head * (dx - turn * dy), to.1 - head * (dy + turn * dx));
                panel.curve(canvas, &[side(0.5), to, side(-0.5)], arrow);
            }
        }
    }
}

/// Each mode's shape: the real part of each response as a bar from zero, with its standard
/// deviation, in the order of the channels.
pub(super) fn shapes(record: &IdentifiedRecord) -> Option<Canvas> {
    let responses = record.modes.iter().map(|mode| mode.shape.len()).max().filter(|n| *n > 0)?;
    const ROW: f64 = 120.0;
    let height = ROW * record.modes.len() as f64;
    let mut canvas = Canvas::new(WIDTH, height + 40.0);
    for (index, mode) in record.modes.iter().enumerate() {
        let (colour, _) = curve_style(index);
        let frame =
            Frame { left: LEFT, top: 26.0 + ROW * index as f64, width: PANEL_WIDTH, height: 64.0 };
        let panel = Panel {
            frame,
            x: Axis::new("", Scale::places(responses)),
            y: Axis::new("", Scale::linear(-1.1, 1.1)),
        };
        panel.title(&mut canvas, &format!("Mode {}, {:.2} Hz", index + 1, mode.frequency_hz));
        panel.axes(&mut canvas, false);
        let zero = [(0.5, 0.0), (responses as f64 + 0.5, 0.0)];
        panel.curve(&mut canvas, &zero, Stroke { colour: GREY, width: 1.0, dashes: "" });
        for (place, part) in mode.shape.iter().enumerate() {
            let x = place as f64 + 1.0;
            let value = part.value.re.clamp(-1.1, 1.1);
            panel.curve(
                &mut canvas,
                &[(x, 0.0), (x, value)],
                Stroke { colour, width: 4.0, dashes: "" },
            );
            panel.dot(&mut canvas, (x, value), 4.0, colour);
            let ends = [value - part.std, value + part.std].map(|y| (x, y.clamp(-1.1, 1.1)));
            panel.curve(&mut canvas, &ends, Stroke { colour: INK, width: 1.2, dashes: "" });
        }
        canvas.border(frame);
    }
    let names = record.modes.first().map_or(&[][..], |mode| mode.shape.as_slice());
    let names = names.iter().enumerate().take(MAX_RESPONSES).map(|(place, part)| {
        Entry::new(Swatch::Dot(INK), format!("{}: {}", place + 1, part.response))
    });
    let names: Vec<Entry> = names.collect();
    column(&mut canvas, (LEGEND_LEFT, 26.0), LEGEND_WIDTH, &names);
    Some(canvas)
}
