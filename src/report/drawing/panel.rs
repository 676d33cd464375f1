//! Panels: a frame with two named axes, and what is drawn in it.

use super::canvas::{Anchor, Canvas, Face, Frame, Stroke};
use super::palette::{GRID, INK};
use super::scale::{Scale, label};
use super::thinned::thinned;

/// Distances of ticks along the axes, px, about.
const X_TICK_PX: f64 = 80.0;
const Y_TICK_PX: f64 = 50.0;

/// From the frame to the end of the ticks, and to their numbers, px.
const TICK_PX: f64 = 5.0;
const NUMBER_PX: f64 = 8.0;

/// From the frame up to what stands above it, px.
const ABOVE_PX: f64 = 10.0;

/// From the middle of a line of text to its foot, px.
const TO_FOOT_PX: f64 = 4.5;

/// One side of a panel.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Axis {
    /// With the unit: `frequency [Hz]`; empty for none.
    pub(in crate::report) name: String,
    pub(in crate::report) scale: Scale,
}

impl Axis {
    pub(in crate::report) fn new(name: impl Into<String>, scale: Scale) -> Self {
        Self { name: name.into(), scale }
    }
}

/// A frame with two axes.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Panel {
    pub(in crate::report) frame: Frame,
    pub(in crate::report) x: Axis,
    pub(in crate::report) y: Axis,
}

impl Panel {
    pub(in crate::report) fn px(&self, x: f64) -> f64 {
        self.frame.left + self.frame.width * self.x.scale.share(x)
    }

    pub(in crate::report) fn py(&self, y: f64) -> f64 {
        self.frame.top + self.frame.height * (1.0 - self.y.scale.share(y))
    }

    /// On the canvas; `None` above or below the panel.
    fn point(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        let is_inside = (-1e-9..=1.0 + 1e-9).contains(&self.y.scale.share(y));
        is_inside.then(|| (self.px(x), self.py(y)))
    }

    /// The head of the panel.
    pub(in crate::report) fn title(&self, canvas: &mut Canvas, title: &str) {
        let at = (self.frame.left, self.frame.top - ABOVE_PX);
        canvas.text(at, Anchor::Start, Face::PanelTitle, title);
    }

    /// Grid, ticks and names; the frame itself is drawn by [`Canvas::border`], over the contents.
    pub(in crate::report) fn axes(&self, canvas: &mut Canvas, has_grid: bool) {
        let Frame { left, top, width, height } = self.frame;
        let (right, bottom) = (self.frame.right(), self.frame.bottom());
        let grid = Stroke { colour: GRID, width: 1.0, dashes: "" };
        let ink = Stroke { colour: INK, ..grid };
        for tick in self.x.scale.ticks((width / X_TICK_PX) as usize) {
            let x = self.px(tick);
            if has_grid {
                canvas.line((x, top), (x, bottom), grid);
            }
            canvas.line((x, bottom), (x, bottom + TICK_PX), ink);
            canvas.text((x, bottom + 19.0), Anchor::Middle, Face::Plain, &label(tick));
        }
        let mut widest: f64 = 0.0;
        for tick in self.y.scale.ticks((height / Y_TICK_PX) as usize) {
            let y = self.py(tick);
            if has_grid {
                canvas.line((left, y), (right, y), grid);
            }
            canvas.line((left - TICK_PX, y), (left, y), ink);
            let number = label(tick);
            widest = widest.max(Face::Plain.width_of(&number));
            let at = (left - NUMBER_PX, y + TO_FOOT_PX);
            canvas.text(at, Anchor::End, Face::Plain, &number);
        }
        let below = (left + 0.5 * width, bottom + 39.0);
        canvas.text(below, Anchor::Middle, Face::Plain, &self.x.name);
        let beside = (left - NUMBER_PX - widest - 10.0, top + 0.5 * height);
        canvas.upright_text(beside, (beside.0, top - ABOVE_PX), &self.y.name);
    }

    /// Lets the script of a page answer to the pointer; `more` are attributes of its own.
    pub(in crate::report) fn sense(&self, canvas: &mut Canvas, more: &str) {
        let scales = [("x", &self.x.scale), ("y", &self.y.scale)].map(|(name, scale)| {
            let kind = if scale.is_logarithmic() { "log" } else { "linear" };
            format!(" data-{name}=\"{} {} {kind}\"", scale.low(), scale.high())
        });
        // As XML: a drawing is a file of its own, too.
        let more = if more.is_empty() { String::new() } else { format!(" {more}=\"\"") };
        canvas.sense(self.frame, &format!("{}{}{more}", scales[0], scales[1]));
    }

    /// The points of a curve in the panel's values that the eye tells from a straight line.
    pub(in crate::report) fn thinned(&self, points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let on_canvas: Vec<(f64, f64)> =
            points.iter().map(|(x, y)| (self.px(*x), self.py(*y))).collect();
        thinned(&on_canvas).into_iter().map(|i| points[i]).collect()
    }

    /// Small text to the right of a point.
    pub(in crate::report) fn note(&self, canvas: &mut Canvas, point: (f64, f64), text: &str) {
        if let Some((x, y)) = self.point(point) {
            canvas.text_over((x + 6.0, y + 4.0), Anchor::Start, text);
        }
    }

    /// A line through points in the panel's values; it breaks where it leaves the panel above or
    /// below.
    pub(in crate::report) fn curve(
        &self,
        canvas: &mut Canvas,
        points: &[(f64, f64)],
        stroke: Stroke,
    ) {
        canvas.polyline(points.iter().map(|&point| self.point(point)), stroke);
    }

    /// The inside of an outline in the panel's values; it must lie within the panel.
    pub(in crate::report) fn area(
        &self,
        canvas: &mut Canvas,
        outline: impl Iterator<Item = (f64, f64)>,
        fill: &str,
        opacity: f64,
    ) {
        canvas.polygon(outline.map(|(x, y)| (self.px(x), self.py(y))), fill, opacity);
    }

    /// A dot, unless it lies above or below the panel.
    pub(in crate::report) fn dot(
        &self,
        canvas: &mut Canvas,
        point: (f64, f64),
        radius: f64,
        fill: &str,
    ) {
        if let Some(at) = self.point(point) {
            canvas.dot(at, radius, fill);
        }
    }
}
