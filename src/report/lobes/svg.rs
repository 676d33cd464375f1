//! Stability lobes as a picture: depth over speed, the frequency below it.

use crate::report::drawing::{
    Anchor, Axis, Canvas, Face, Frame, Panel, Scale, Stroke, bounds, curve_style,
};
use crate::study::lobes::{Lobes, Rows};
use crate::units::mm_from_m;

const WIDTH: f64 = 860.0;
const LEFT: f64 = 85.0;

/// A row as points of the two panels.
struct Point {
    rpm: f64,
    above: Option<f64>,
    below: Option<f64>,
}

/// The limit and the frequency of the vibration over the speed, or the growth at a depth.
pub fn lobes_drawing(lobes: &Lobes) -> Canvas {
    let limit = format!("{} [mm]", lobes.limit_of.name());
    let (points, names): (Vec<Point>, [&str; 2]) = match &lobes.rows {
        Rows::Limits(rows) => {
            let point = |row: &crate::study::lobes::LimitAt| Point {
                rpm: row.rpm,
                above: row.limit.map(|limit| mm_from_m(limit.depth_m)),
                below: row.limit.map(|limit| limit.frequency_hz),
            };
            (rows.iter().map(point).collect(), [&limit, "chatter [Hz]"])
        }
        Rows::Radii(rows) => {
            let point = |row: &crate::study::lobes::RadiusAt| Point {
                rpm: row.rpm,
                above: Some(row.spectral_radius),
                below: None,
            };
            (rows.iter().map(point).collect(), ["growth per tooth", ""])
        }
    };
    let has_below = !names[1].is_empty();
    let mut canvas = Canvas::new(WIDTH, if has_below { 620.0 } else { 400.0 });
    canvas.text((LEFT, 30.0), Anchor::Start, Face::Title, &lobes.title);
    let said = if lobes.has_tool_modes { "" } else { "the arm's modes alone" };
    canvas.text((WIDTH - 60.0, 30.0), Anchor::End, Face::Plain, said);
    let (low, high) = bounds(points.iter().map(|point| point.rpm));
    let draw = |canvas: &mut Canvas, top: f64, height: f64, name: &str, below: bool| {
        let value = |point: &Point| if below { point.below } else { point.above };
        let values: Vec<f64> = points.iter().filter_map(value).collect();
        let frame = Frame { left: LEFT, top, width: WIDTH - LEFT - 60.0, height };
        if values.is_empty() {
            let what = "no limit below 1 m";
            canvas.text((LEFT, top + 20.0), Anchor::Start, Face::Plain, what);
            return;
        }
        let (_, most) = bounds(values.into_iter());
        let panel = Panel {
            frame,
            x: Axis::new("spindle speed [rpm]", Scale::linear(low, high.max(low + 1.0))),
            y: Axis::new(name, Scale::linear(0.0, 1.05 * most)),
        };
        panel.axes(canvas, true);
        let (colour, _) = curve_style(0);
        let mut curve: Vec<(f64, f64)> = Vec::new();
        let stroke = Stroke { colour, width: 1.6, dashes: "" };
        for point in &points {
            match value(point) {
                Some(value) => curve.push((point.rpm, value)),
                None => panel.curve(canvas, &std::mem::take(&mut curve), stroke),
            }
        }
        panel.curve(canvas, &curve, stroke);
        canvas.border(frame);
    };
    draw(&mut canvas, 60.0, 280.0, names[0], false);
    if has_below {
        draw(&mut canvas, 410.0, 150.0, names[1], true);
    }
    canvas
}
