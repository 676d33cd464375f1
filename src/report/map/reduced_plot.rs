//! A reduced map as a picture: how often each mode is where, with its extremes and quantiles.

use crate::map::{Bin, Head, Reduced, ReducedMode, SHARES};
use crate::report::drawing::{
    Anchor, Axis, Canvas, Entry, Face, Frame, INK, Panel, Scale, Stroke, Swatch, bounds,
    curve_style, label, row,
};
use crate::units::percent_from_ratio;

const WIDTH: f64 = 860.0;
const LEFT: f64 = 85.0;
const PANEL_HEIGHT: f64 = 210.0;

const MEDIAN: Stroke = Stroke { colour: INK, width: 2.0, dashes: "7 5" };
const QUANTILE: Stroke = Stroke { width: 1.0, ..MEDIAN };

/// Draws the histogram of each mode, as poses per Hz, with the median and the other quantiles over
/// it.
pub fn reduced_drawing(head: &Head, reduced: &Reduced) -> Canvas {
    let count = reduced.modes.len();
    let mut canvas = Canvas::new(WIDTH, 75.0 + count as f64 * PANEL_HEIGHT);
    let title = format!("Natural frequencies of {} poses: {}", reduced.poses, head.robot);
    canvas.text((LEFT, 30.0), Anchor::Start, Face::Title, &title);
    let others: Vec<String> = SHARES
        .iter()
        .filter(|share| **share != 0.5)
        .map(|share| label(percent_from_ratio(*share)))
        .collect();
    let entries = [
        Entry::new(Swatch::Line(MEDIAN), "median"),
        Entry::new(Swatch::Line(QUANTILE), format!("quantiles {} %", others.join(", "))),
    ];
    row(&mut canvas, (WIDTH - 60.0, 52.0), &entries);
    for (i, mode) in reduced.modes.iter().enumerate() {
        let frame = Frame {
            left: LEFT,
            top: 80.0 + i as f64 * PANEL_HEIGHT,
            width: WIDTH - LEFT - 60.0,
            height: PANEL_HEIGHT - 85.0,
        };
        draw(&mut canvas, frame, i, mode);
    }
    canvas
}

fn draw(canvas: &mut Canvas, frame: Frame, index: usize, mode: &ReducedMode) {
    let (low, high) = bounds(mode.histogram.iter().flat_map(|bin| [bin.from_hz, bin.to_hz]));
    let density = |bin: &Bin| bin.poses as f64 / (bin.to_hz - bin.from_hz);
    let (_, most) = bounds(mode.histogram.iter().map(density));
    let panel = Panel {
        frame,
        x: Axis::new("frequency [Hz]", Scale::linear(low, high)),
        // What counts is the shape.
        y: Axis::new("density / peak", Scale::linear(0.0, 1.0)),
    };
    let [from, to] = [mode.min.frequency_hz, mode.max.frequency_hz].map(label);
    panel.title(canvas, &format!("f{}: {from} to {to} Hz", index + 1));
    panel.axes(canvas, false);
    // Each mode has a panel to itself: dashes need not distinguish them.
    let (colour, _) = curve_style(index);
    for bin in &mode.histogram {
        let (left, right) = (panel.px(bin.from_hz), panel.px(bin.to_hz));
        let top = panel.py(density(bin) / most);
        let bar = Frame { left, top, width: right - left, height: frame.bottom() - top };
        canvas.rect(bar, colour, 1.0);
    }
    for (share, quantile) in SHARES.iter().zip(mode.quantiles_hz) {
        let stroke = if *share == 0.5 { MEDIAN } else { QUANTILE };
        panel.curve(canvas, &[(quantile, 0.0), (quantile, 1.0)], stroke);
    }
    canvas.border(frame);
}
