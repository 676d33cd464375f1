//! The tracks over time: above to the right, below up.

use crate::report::drawing::{
    Axis, Canvas, Entry, Frame, Panel, Scale, Stroke, Swatch, bounds, column, curve_style,
};
use crate::study::trace::{Traced, TracedMark};
use crate::units::mm_from_m;

const WIDTH: f64 = 1060.0;
const HEIGHT: f64 = 640.0;
const LEFT: f64 = 85.0;
const PANEL_WIDTH: f64 = 770.0;
const PANEL_HEIGHT: f64 = 230.0;
const TOPS: [f64; 2] = [45.0, 340.0];

/// Where the legend starts, beside the panels, and its width.
const LEGEND_LEFT: f64 = LEFT + PANEL_WIDTH + 15.0;
const LEGEND_WIDTH: f64 = WIDTH - LEGEND_LEFT - 10.0;

/// More marks do not fit into the legend.
const MAX_ENTRIES: usize = 30;

/// Stretches of a curve that are drawn by their extremes.
const MAX_STRETCHES: usize = 2000;

/// Displacements of all marks; curves break where a mark is lost.
pub fn tracks_drawing(traced: &Traced) -> Canvas {
    let mut canvas = Canvas::new(WIDTH, HEIGHT);
    let (first, last) = bounds(traced.times_s.iter().copied());
    for (axis, (top, name)) in TOPS.into_iter().zip(["x", "y"]).enumerate() {
        let all = traced.marks.iter().flat_map(|mark| mark.displacements_m.iter().flatten());
        let (low, high) = bounds(all.map(|moved| mm_from_m(moved[axis])));
        let panel = Panel {
            frame: Frame { left: LEFT, top, width: PANEL_WIDTH, height: PANEL_HEIGHT },
            x: Axis::new(if axis == 1 { "time [s]" } else { "" }, Scale::linear(first, last)),
            y: Axis::new(format!("{name} [mm]"), Scale::linear(low, high)),
        };
        panel.axes(&mut canvas, true);
        for (index, mark) in traced.marks.iter().enumerate() {
            let (colour, dashes) = curve_style(index);
            for points in pieces(traced, mark, axis) {
                panel.curve(&mut canvas, &points, Stroke { colour, width: 1.0, dashes });
            }
        }
        canvas.border(panel.frame);
    }
    let entries: Vec<Entry> = traced
        .marks
        .iter()
        .enumerate()
        .take(MAX_ENTRIES)
        .map(|(index, mark)| {
            let (colour, dashes) = curve_style(index);
            Entry::new(Swatch::Line(Stroke { colour, width: 2.2, dashes }), mark.name.as_str())
        })
        .collect();
    column(&mut canvas, (LEGEND_LEFT, TOPS[0]), LEGEND_WIDTH, &entries);
    canvas
}

/// The curve of a mark along an axis, between the frames in which it is lost, thinned to the
/// extremes of each stretch.
fn pieces(traced: &Traced, mark: &TracedMark, axis: usize) -> Vec<Vec<(f64, f64)>> {
    let rows: Vec<Option<(f64, f64)>> = traced
        .times_s
        .iter()
        .zip(&mark.displacements_m)
        .map(|(time, moved)| Some((*time, mm_from_m(moved.as_ref()?[axis]))))
        .collect();
    let stretch = rows.len().div_ceil(MAX_STRETCHES).max(1);
    let seen = rows.split(Option::is_none).filter(|piece| !piece.is_empty());
    seen.map(|piece| piece.chunks(stretch).flat_map(extremes).collect()).collect()
}

fn extremes(stretch: &[Option<(f64, f64)>]) -> Vec<(f64, f64)> {
    let seen = || stretch.iter().flatten().copied();
    let low = seen().min_by(|a, b| a.1.total_cmp(&b.1));
    let high = seen().max_by(|a, b| a.1.total_cmp(&b.1));
    let mut points: Vec<(f64, f64)> = low.into_iter().chain(high).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.dedup();
    points
}
