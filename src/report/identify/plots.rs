//! Phase, coherence and shapes of a record.

use crate::identify::record_modes::IdentifiedRecord;
use crate::identify::spectra::Averaged;
use crate::report::drawing::{
    Axis, Canvas, Entry, Frame, GREY, INK, Panel, Scale, Stroke, Swatch, bounds, column,
    curve_style, labels_on_top,
};
use crate::units::deg_from_rad;

use super::svg::{LEFT, LEGEND_LEFT, LEGEND_WIDTH, MAX_POINTS, PANEL_WIDTH, WIDTH, modes};

/// At most so many responses are drawn, as the legend has room for no more.
const MAX_RESPONSES: usize = 8;

/// Phase of H1 of each response over frequency, where a force was measured.
pub(super) fn phase(record: &IdentifiedRecord) -> Option<String> {
    let averaged = record.averaged.as_ref()?;
    let y = Axis::new("phase [°]", Scale::linear(-180.0, 180.0));
    let degrees = |response: usize, line: usize| {
        averaged.h1.get(response)?.get(line).map(|h| deg_from_rad(h.arg()))
    };
    over_frequency(record, averaged, y, 190.0, &degrees)
}

/// γ² of each response over frequency, where several records were averaged.
pub(super) fn coherence(record: &IdentifiedRecord) -> Option<String> {
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
) -> Option<String> {
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
    Some(canvas.finish())
}

/// Each mode's shape: the real part of each response as a bar from zero, with its standard
/// deviation, in the order of the channels.
pub(super) fn shapes(record: &IdentifiedRecord) -> Option<String> {
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
            x: Axis::new("", Scale::linear(0.5, responses as f64 + 0.5)),
            y: Axis::new("", Scale::linear(-1.1, 1.1)),
        };
        panel.title(&mut canvas, &format!("Mode {}, {:.2} Hz", index + 1, mode.frequency_hz));
        panel.axes(&mut canvas, true);
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
    Some(canvas.finish())
}
