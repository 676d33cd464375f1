//! A reduced map as a picture: how often each mode is where, with its extremes and quantiles.

use super::plot::{PANEL_TITLE, TITLE};
use crate::map::{Head, Reduced, ReducedMode, SHARES};
use crate::report::svg::{Anchor, Axis, Frame, Panel, Sheet, Stroke, curve_style, label};

const PANEL_HEIGHT: f64 = 210.0;

/// Draws the histogram of each mode, as poses per Hz, with the median and the quantiles beside it.
pub fn reduced_svg(head: &Head, reduced: &Reduced) -> String {
    let (width, count) = (860.0, reduced.modes.len());
    let mut sheet = Sheet::new(width, 70.0 + count as f64 * PANEL_HEIGHT);
    let title = format!("Natural frequencies of {} poses: {}", reduced.poses, head.robot);
    sheet.text(80.0, 30.0, Anchor::Start, TITLE, &title);
    sheet.text(width - 60.0, 30.0, Anchor::End, "", "dashed: 5, 25, 50, 75, 95 %");
    for (i, mode) in reduced.modes.iter().enumerate() {
        let frame = Frame {
            left: 80.0,
            top: 75.0 + i as f64 * PANEL_HEIGHT,
            width: width - 140.0,
            height: PANEL_HEIGHT - 85.0,
        };
        panel(&mut sheet, frame, i, mode);
    }
    sheet.finish()
}

fn panel(sheet: &mut Sheet, frame: Frame, index: usize, mode: &ReducedMode) {
    let ends = |f: fn(f64, f64) -> f64, start: f64, value: fn(&crate::map::Bin) -> f64| {
        mode.histogram.iter().map(value).fold(start, f)
    };
    let low = ends(f64::min, f64::INFINITY, |bin| bin.from_hz);
    let high = ends(f64::max, f64::NEG_INFINITY, |bin| bin.to_hz);
    let density = |bin: &crate::map::Bin| bin.poses as f64 / (bin.to_hz - bin.from_hz);
    let most = mode.histogram.iter().map(density).fold(0.0, f64::max);
    let axis =
        |label: &str, low, high| Axis { label: label.into(), low, high, is_logarithmic: false };
    // Shares of the fullest band: what counts is the shape.
    let panel = Panel { frame, x: axis("frequency [Hz]", low, high), y: axis("density", 0.0, 1.0) };
    let title = format!(
        "f{}: {} to {} Hz",
        index + 1,
        label(mode.min.frequency_hz),
        label(mode.max.frequency_hz)
    );
    sheet.text(frame.left, frame.top - 8.0, Anchor::Start, PANEL_TITLE, &title);
    sheet.axes(&panel, false);
    // Each mode has a panel to itself: dashes need not distinguish them.
    let (colour, _) = curve_style(index);
    for bin in &mode.histogram {
        let (left, right) = (panel.px(bin.from_hz), panel.px(bin.to_hz));
        let top = panel.py(density(bin) / most);
        let height = frame.top + frame.height - top;
        sheet.rect(Frame { left, top, width: right - left, height }, colour);
    }
    for (share, quantile) in SHARES.iter().zip(mode.quantiles_hz) {
        let width = if *share == 0.5 { 2.0 } else { 1.0 };
        let ends = [(quantile, 0.0), (quantile, 1.0)];
        sheet.curve(&panel, &ends, Stroke { colour: "#222222", width, dashes: "7 5" });
    }
    sheet.border(frame);
}
