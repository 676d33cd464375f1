//! A sheet for each record: above, the measured spectrum and the fit; below, the stabilisation diagram.

use super::{kind_words, pose_words};
use crate::identify::record_modes::{FittedSpectrum, Identified};
use crate::identify::session::IdentifiedSession;
use crate::identify::{Kind, Stability};
use crate::report::svg::{Anchor, Axis, Frame, Panel, Sheet, Stroke, curve_style, label};

const WIDTH: f64 = 900.0;
const SHEET_HEIGHT: f64 = 640.0;
const LEFT: f64 = 85.0;
const PANEL_WIDTH: f64 = WIDTH - 130.0;

/// Names of modes: width of a letter, distance of rows.
const NAME_PX_PER_LETTER: f64 = 6.6;
const NAME_ROW_PX: f64 = 13.0;

const TITLE: &str = "font-size=\"16\" font-weight=\"bold\"";

/// Nothing that lies further below the peak is drawn.
const MOST_DECADES: f64 = 6.0;

/// This share of the lines may lie below the panel.
const BELOW_PANEL: f64 = 0.02;

/// Fits are dashed like this.
const FIT_DASHES: &str = "7 4";

/// More points than this make no finer curve.
const MOST_POINTS: usize = 3000;

const STEADY: &str = "#009e73";
const FREQUENCY: &str = "#e69f00";
const NEW: &str = "#bbbbbb";
const MODE: &str = "#cc79a7";

/// All records, one below the other.
pub fn identification_svg(found: &IdentifiedSession) -> String {
    let height = SHEET_HEIGHT * found.records.len().max(1) as f64;
    let mut sheet = Sheet::new(WIDTH, height);
    for (index, record) in found.records.iter().enumerate() {
        let pose = found
            .rows
            .iter()
            .find(|row| row.modes.iter().flat_map(|m| &m.members).any(|(r, _)| *r == index))
            .map_or_else(String::new, |row| format!(", {}", pose_words(&row.pose)));
        let title = format!("{}: {}{pose}", record.record, kind_words(record.kind));
        draw(&mut sheet, record, &title, SHEET_HEIGHT * index as f64);
    }
    sheet.finish()
}

fn draw(sheet: &mut Sheet, record: &Identified, title: &str, top: f64) {
    sheet.text(LEFT, top + 28.0, Anchor::Start, TITLE, title);
    let lines = || record.spectra.iter().flat_map(|s| &s.frequencies_hz);
    let high = lines().fold(0.0_f64, |a, &b| a.max(b));
    let peak = record.spectra.iter().flat_map(|s| &s.measured).fold(0.0_f64, |a, &b| a.max(b));
    if !(high > 0.0 && peak > 0.0 && peak.is_finite()) {
        sheet.text(LEFT, top + 60.0, Anchor::Start, "", "nothing to draw");
        return;
    }
    let x = Axis { label: String::new(), low: 0.0, high, is_logarithmic: false };
    let what = match record.kind {
        Kind::FreeDecay => "spectrum, relative",
        _ => "response over force, relative",
    };
    let spectrum = Panel {
        frame: Frame { left: LEFT, top: top + 45.0, width: PANEL_WIDTH, height: 270.0 },
        x: x.clone(),
        y: Axis { label: what.into(), low: lowest(record, peak), high: 2.0, is_logarithmic: true },
    };
    sheet.axes(&spectrum, true);
    for (index, response) in record.spectra.iter().enumerate() {
        let (colour, _) = curve_style(index);
        let stroke = |width, dashes| Stroke { colour, width, dashes };
        sheet.curve(&spectrum, &points(response, &response.measured, peak), stroke(0.8, ""));
    }
    for (index, response) in record.spectra.iter().enumerate() {
        let (colour, _) = curve_style(index);
        let stroke = Stroke { colour, width: 2.2, dashes: FIT_DASHES };
        sheet.curve(&spectrum, &points(response, &response.fitted, peak), stroke);
    }
    mark_modes(sheet, &spectrum, record, true);
    sheet.border(spectrum.frame);
    legend(sheet, record, &spectrum);
    let orders = record.stabilisation.iter().map(|point| point.order).max().unwrap_or(0);
    let stabilisation = Panel {
        frame: Frame { left: LEFT, top: top + 360.0, width: PANEL_WIDTH, height: 210.0 },
        x: Axis { label: "frequency [Hz]".into(), ..x },
        y: Axis {
            label: "order".into(),
            low: 0.0,
            high: orders.max(2) as f64 + 1.0,
            is_logarithmic: false,
        },
    };
    sheet.axes(&stabilisation, true);
    mark_modes(sheet, &stabilisation, record, false);
    for point in record.stabilisation.iter().filter(|point| point.frequency_hz <= high) {
        let (radius, colour) = match point.stability {
            Stability::Pole => (3.0, STEADY),
            Stability::Frequency => (2.4, FREQUENCY),
            Stability::New => (1.6, NEW),
        };
        sheet.dot(&stabilisation, point.frequency_hz, point.order as f64, radius, colour);
    }
    sheet.border(stabilisation.frame);
    let words =
        "poles by order: green keeps frequency and damping, orange frequency only, grey is new";
    sheet.text(LEFT, top + 352.0, Anchor::Start, "font-size=\"12\"", words);
}

/// The decade below which nearly nothing lies, against the peak.
fn lowest(record: &Identified, peak: f64) -> f64 {
    let mut sizes: Vec<f64> =
        record.spectra.iter().flat_map(|s| &s.measured).map(|size| size / peak).collect();
    sizes.sort_by(f64::total_cmp);
    let low = sizes.get((BELOW_PANEL * sizes.len() as f64) as usize).copied().unwrap_or(0.0);
    let decade = low.max(f64::MIN_POSITIVE).log10().floor().clamp(-MOST_DECADES, -1.0);
    10.0_f64.powf(decade)
}

/// Points of a curve, thinned to the loudest of each stretch.
fn points(response: &FittedSpectrum, values: &[f64], peak: f64) -> Vec<(f64, f64)> {
    let stretch = values.len().div_ceil(MOST_POINTS).max(1);
    values
        .chunks(stretch)
        .zip(response.frequencies_hz.chunks(stretch))
        .filter_map(|(values, frequencies)| {
            let (k, value) = values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
            Some((*frequencies.get(k)?, value / peak))
        })
        .collect()
}

fn mark_modes(sheet: &mut Sheet, panel: &Panel, record: &Identified, is_named: bool) {
    let Frame { left, top, width, height } = panel.frame;
    // Where the last name in each row ends: a name that would run into another goes a row down.
    let mut ends: Vec<f64> = Vec::new();
    for mode in &record.modes {
        let x = panel.px(mode.frequency_hz);
        sheet.line(x, top, x, top + height, MODE);
        if is_named {
            let name = format!("{} Hz", label((mode.frequency_hz * 1e3).round() / 1e3));
            let room = NAME_PX_PER_LETTER * name.len() as f64;
            // At the right end of the panel names stand before their lines.
            let is_last = x + room > left + width;
            let (from, anchor) = if is_last { (x - room, Anchor::End) } else { (x, Anchor::Start) };
            let row = ends.iter().position(|end| *end <= from).unwrap_or(ends.len());
            if row == ends.len() {
                ends.push(0.0);
            }
            ends[row] = from + room;
            let beside = if is_last { x - 3.0 } else { x + 3.0 };
            let y = top + 14.0 + NAME_ROW_PX * row as f64;
            sheet.text(beside, y, anchor, "font-size=\"11\"", &name);
        }
    }
}

fn legend(sheet: &mut Sheet, record: &Identified, panel: &Panel) {
    let right = panel.frame.left + panel.frame.width - 8.0;
    for (index, response) in record.spectra.iter().enumerate().take(8) {
        let (colour, _) = curve_style(index);
        let style = format!("font-size=\"12\" style=\"fill:{colour}\"");
        let y = panel.frame.top + 32.0 + 15.0 * index as f64;
        let text = format!("{} (fit dashed)", response.response);
        sheet.text(right, y, Anchor::End, &style, &text);
    }
}
