//! A sheet for each record: above, the measured spectrum and the fit; below, the stabilisation
//! diagram.

use super::{kind_words, pose_words};
use crate::identify::record_modes::{FittedSpectrum, IdentifiedRecord};
use crate::identify::session::IdentifiedSession;
use crate::identify::{RecordKind, Stability};
use crate::report::drawing::{
    Anchor, Axis, Canvas, Entry, Face, Frame, GREY, INK, Label, Panel, Scale, Stroke, Swatch,
    bounds, column, curve_style, label, labels_on_top,
};

pub(super) const WIDTH: f64 = 1060.0;
const SHEET_HEIGHT: f64 = 640.0;
pub(super) const LEFT: f64 = 85.0;
pub(super) const PANEL_WIDTH: f64 = 770.0;

/// Where legends start, beside the panels, and their width.
pub(super) const LEGEND_LEFT: f64 = LEFT + PANEL_WIDTH + 15.0;
pub(super) const LEGEND_WIDTH: f64 = WIDTH - LEGEND_LEFT - 10.0;

/// Nothing that lies further below the peak is drawn.
const MAX_DECADES: f64 = 6.0;

/// This share of the lines may lie below the panel.
const BELOW_PANEL: f64 = 0.02;

/// More points than this make no finer curve.
pub(super) const MAX_POINTS: usize = 3000;

/// At most so many responses stand in the legend.
const MAX_ENTRIES: usize = 12;

/// Fits are dashed like this.
const FIT_DASHES: &str = "7 4";

const STABLE_POLE: &str = "#009e73";
const STABLE_FREQUENCY: &str = "#e69f00";
const MODE: &str = "#cc79a7";

/// All records, one below the other.
pub fn identification_drawing(found: &IdentifiedSession) -> Canvas {
    let height = SHEET_HEIGHT * found.records.len().max(1) as f64;
    let mut canvas = Canvas::new(WIDTH, height);
    for (index, record) in found.records.iter().enumerate() {
        let pose = found
            .poses
            .iter()
            .find(|at| at.modes.iter().flat_map(|m| &m.members).any(|(r, _)| *r == index))
            .map_or_else(String::new, |at| {
                format!(", {}", pose_words(&at.pose, found.joint_columns.as_deref()))
            });
        let title = format!("{}: {}{pose}", record.name, kind_words(record.kind));
        draw(&mut canvas, record, &title, SHEET_HEIGHT * index as f64);
    }
    canvas
}

/// One record without a title.
pub(super) fn sheet(record: &IdentifiedRecord) -> Canvas {
    let mut canvas = Canvas::new(WIDTH, SHEET_HEIGHT);
    draw(&mut canvas, record, "", 0.0);
    canvas
}

fn draw(canvas: &mut Canvas, record: &IdentifiedRecord, title: &str, top: f64) {
    canvas.text((LEFT, top + 28.0), Anchor::Start, Face::Title, title);
    let (_, high) = bounds(record.spectra.iter().flat_map(|s| s.frequencies_hz.iter().copied()));
    let (_, peak) = bounds(record.spectra.iter().flat_map(|s| s.measured.iter().copied()));
    if !(high > 0.0 && peak > 0.0 && high.is_finite()) {
        canvas.text((LEFT, top + 60.0), Anchor::Start, Face::Plain, "nothing to draw");
        return;
    }
    spectra(canvas, record, peak, Scale::linear(0.0, high), top + 45.0);
    stabilisation(canvas, record, Scale::linear(0.0, high), top + 370.0);
}

fn spectra(canvas: &mut Canvas, record: &IdentifiedRecord, peak: f64, hz: Scale, top: f64) {
    let what = match record.kind {
        RecordKind::FreeDecay | RecordKind::RandomResponse => "spectrum / peak",
        _ => "response per force / peak",
    };
    let panel = Panel {
        frame: Frame { left: LEFT, top, width: PANEL_WIDTH, height: 270.0 },
        x: Axis::new("", hz),
        y: Axis::new(what, Scale::logarithmic(lowest(record, peak), 2.0)),
    };
    panel.axes(canvas, true);
    let stroke = |index: usize, width, dashes| {
        let (colour, _) = curve_style(index);
        Stroke { colour, width, dashes }
    };
    for (index, response) in record.spectra.iter().enumerate() {
        let points = points(response, &response.measured, peak);
        panel.curve(canvas, &points, stroke(index, 0.8, ""));
    }
    for (index, response) in record.spectra.iter().enumerate() {
        let points = points(response, &response.fitted, peak);
        panel.curve(canvas, &points, stroke(index, 2.2, FIT_DASHES));
    }
    labels_on_top(canvas, &panel, &modes(record, true));
    canvas.border(panel.frame);
    let mut entries = vec![
        Entry::new(Swatch::Line(Stroke { colour: INK, width: 0.8, dashes: "" }), "measured"),
        Entry::new(Swatch::Line(Stroke { colour: INK, width: 2.2, dashes: FIT_DASHES }), "fitted"),
        Entry::new(Swatch::Line(Stroke { colour: MODE, width: 1.0, dashes: "" }), "mode"),
    ];
    for (index, response) in record.spectra.iter().enumerate().take(MAX_ENTRIES) {
        entries.push(Entry::new(Swatch::Line(stroke(index, 2.2, "")), response.response.as_str()));
    }
    column(canvas, (LEGEND_LEFT, top), LEGEND_WIDTH, &entries);
}

fn stabilisation(canvas: &mut Canvas, record: &IdentifiedRecord, hz: Scale, top: f64) {
    let orders = record.stabilisation.iter().map(|point| point.order).max().unwrap_or(0);
    let panel = Panel {
        frame: Frame { left: LEFT, top, width: PANEL_WIDTH, height: 210.0 },
        x: Axis::new("frequency [Hz]", hz),
        y: Axis::new("model order", Scale::linear(0.0, orders.max(2) as f64 + 1.0)),
    };
    panel.title(canvas, "Stabilisation diagram");
    panel.axes(canvas, true);
    labels_on_top(canvas, &panel, &modes(record, false));
    let high = panel.x.scale.high();
    for point in record.stabilisation.iter().filter(|point| point.frequency_hz <= high) {
        let (radius, colour) = match point.stability {
            Stability::Pole => (3.0, STABLE_POLE),
            Stability::Frequency => (2.4, STABLE_FREQUENCY),
            Stability::New => (1.6, GREY),
        };
        panel.dot(canvas, (point.frequency_hz, point.order as f64), radius, colour);
    }
    canvas.border(panel.frame);
    let entries = [
        Entry::new(Swatch::Dot(STABLE_POLE), "stable pole"),
        Entry::new(Swatch::Dot(STABLE_FREQUENCY), "stable frequency"),
        Entry::new(Swatch::Dot(GREY), "new pole"),
    ];
    column(canvas, (LEGEND_LEFT, top), LEGEND_WIDTH, &entries);
}

/// The identified frequencies as labels of vertical lines.
pub(super) fn modes(record: &IdentifiedRecord, is_named: bool) -> Vec<Label<'static>> {
    let text = |hz: f64| match is_named {
        true => format!("{} Hz", label((hz * 1e3).round() / 1e3)),
        false => String::new(),
    };
    let frequencies = record.modes.iter().map(|mode| mode.frequency_hz);
    frequencies.map(|hz| Label { at: hz, colour: MODE, text: text(hz) }).collect()
}

/// The decade below which nearly nothing lies, against the peak.
fn lowest(record: &IdentifiedRecord, peak: f64) -> f64 {
    let mut sizes: Vec<f64> =
        record.spectra.iter().flat_map(|s| &s.measured).map(|size| size / peak).collect();
    sizes.sort_by(f64::total_cmp);
    let low = sizes.get((BELOW_PANEL * sizes.len() as f64) as usize).copied().unwrap_or(0.0);
    let decade = low.max(f64::MIN_POSITIVE).log10().floor().clamp(-MAX_DECADES, -1.0);
    10.0_f64.powf(decade)
}

/// Points of a curve, thinned to the loudest of each stretch.
fn points(response: &FittedSpectrum, values: &[f64], peak: f64) -> Vec<(f64, f64)> {
    let stretch = values.len().div_ceil(MAX_POINTS).max(1);
    values
        .chunks(stretch)
        .zip(response.frequencies_hz.chunks(stretch))
        .filter_map(|(values, frequencies)| {
            let (k, value) = values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
            Some((*frequencies.get(k)?, value / peak))
        })
        .collect()
}
