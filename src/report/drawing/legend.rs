//! Legends with swatches, and labels beside what they name that keep off each other.

use super::canvas::{Anchor, Canvas, Face, Frame, Stroke};
use super::panel::Panel;

/// Width of a swatch and of the gap to its text, px.
const SWATCH_PX: f64 = 26.0;
const GAP_PX: f64 = 7.0;

/// Distance of entries, px: below and beside each other.
const ENTRY_PX: f64 = 18.0;
const BESIDE_PX: f64 = 18.0;

/// Distance of labels beside a panel, px, and length of the line that leads to them.
const LABEL_PX: f64 = 14.0;
const LEADER_PX: f64 = 16.0;

/// Distance of rows of labels at the top of a panel, px.
const TOP_LABEL_PX: f64 = 13.0;

/// From the middle of small text to its foot, px.
const TO_FOOT_PX: f64 = 4.0;

/// How an entry of a legend looks in the drawing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::report) enum Swatch<'a> {
    Line(Stroke<'a>),
    /// Fill and opacity.
    Area(&'a str, f64),
    Dot(&'a str),
}

/// One entry of a legend.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Entry<'a> {
    pub(in crate::report) swatch: Swatch<'a>,
    pub(in crate::report) text: String,
}

impl<'a> Entry<'a> {
    pub(in crate::report) fn new(swatch: Swatch<'a>, text: impl Into<String>) -> Self {
        Self { swatch, text: text.into() }
    }

    fn draw(&self, canvas: &mut Canvas, left: f64, middle: f64, text: &str) {
        canvas.entry(|canvas| self.parts(canvas, left, middle, text));
    }

    fn parts(&self, canvas: &mut Canvas, left: f64, middle: f64, text: &str) {
        match self.swatch {
            Swatch::Line(stroke) => {
                canvas.line((left, middle), (left + SWATCH_PX, middle), stroke);
            }
            Swatch::Area(fill, opacity) => {
                let frame = Frame { left, top: middle - 6.0, width: SWATCH_PX, height: 12.0 };
                canvas.rect(frame, fill, opacity);
            }
            Swatch::Dot(fill) => canvas.dot((left + 0.5 * SWATCH_PX, middle), 4.0, fill),
        }
        let at = (left + SWATCH_PX + GAP_PX, middle + 4.5);
        canvas.text(at, Anchor::Start, Face::Plain, text);
    }
}

/// Entries below each other, from a corner downwards; texts that are wider than `width` allows are
/// cut.
pub(in crate::report) fn column(
    canvas: &mut Canvas,
    (left, top): (f64, f64),
    width: f64,
    entries: &[Entry],
) {
    for (index, entry) in entries.iter().enumerate() {
        let text = Face::Plain.elided(&entry.text, width - SWATCH_PX - GAP_PX);
        entry.draw(canvas, left, top + ENTRY_PX * (index as f64 + 0.5), &text);
    }
}

/// Entries beside each other on one line, the last one ending at `right`.
pub(in crate::report) fn row(canvas: &mut Canvas, (right, middle): (f64, f64), entries: &[Entry]) {
    let mut left = right;
    for entry in entries.iter().rev() {
        left -= SWATCH_PX + GAP_PX + Face::Plain.width_of(&entry.text);
        entry.draw(canvas, left, middle, &entry.text);
        left -= BESIDE_PX;
    }
}

/// A text that names something at a place of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Label<'a> {
    /// In the panel's values: y for labels beside a panel, x for those at its top.
    pub(in crate::report) at: f64,
    pub(in crate::report) colour: &'a str,
    pub(in crate::report) text: String,
}

/// Height of so many labels beside a panel, px.
pub(in crate::report) fn height_beside(labels: usize) -> f64 {
    LABEL_PX * labels as f64
}

/// Labels to the right of a panel, each led to by a line from its height; they move apart where
/// they would lie on each other.
pub(in crate::report) fn labels_beside(canvas: &mut Canvas, panel: &Panel, labels: &[Label]) {
    let Frame { top, .. } = panel.frame;
    let (right, bottom) = (panel.frame.right(), panel.frame.bottom());
    let mut placed: Vec<(f64, &Label)> =
        labels.iter().map(|l| (panel.py(l.at), l)).filter(|(y, _)| y.is_finite()).collect();
    placed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let wanted: Vec<f64> = placed.iter().map(|(y, _)| *y).collect();
    for (y, (from, label)) in apart(&wanted, LABEL_PX, (top, bottom)).into_iter().zip(placed) {
        let stroke = Stroke { colour: label.colour, width: 1.2, dashes: "" };
        canvas.line((right, from), (right + LEADER_PX, y), stroke);
        let at = (right + LEADER_PX + 4.0, y + TO_FOOT_PX);
        canvas.text(at, Anchor::Start, Face::Small, &label.text);
    }
}

/// Ascending places moved so that neighbours are at least `distance` apart, within the range where
/// they fit.
fn apart(wanted: &[f64], distance: f64, (low, high): (f64, f64)) -> Vec<f64> {
    let mut places = wanted.to_vec();
    let mut free = low;
    for place in &mut places {
        *place = place.max(free);
        free = *place + distance;
    }
    let mut free = high.max(low + distance * places.len().saturating_sub(1) as f64);
    for place in places.iter_mut().rev() {
        *place = place.min(free);
        free = *place - distance;
    }
    places
}

/// Labels of vertical lines at the top of a panel: one that would run into another goes a row down.
/// At the right end of the panel they stand before their lines.
pub(in crate::report) fn labels_on_top(canvas: &mut Canvas, panel: &Panel, labels: &[Label]) {
    let Frame { top, .. } = panel.frame;
    let mut ends: Vec<f64> = Vec::new();
    for label in labels {
        let x = panel.px(label.at);
        canvas.line(
            (x, top),
            (x, panel.frame.bottom()),
            Stroke { colour: label.colour, width: 1.0, dashes: "" },
        );
        let room = Face::Small.width_of(&label.text) + 6.0;
        let is_last = x + room > panel.frame.right();
        let (from, anchor) = if is_last { (x - room, Anchor::End) } else { (x, Anchor::Start) };
        let row = ends.iter().position(|end| *end <= from).unwrap_or(ends.len());
        if row == ends.len() {
            ends.push(0.0);
        }
        ends[row] = from + room;
        let beside = if is_last { x - 3.0 } else { x + 3.0 };
        let y = top + 14.0 + TOP_LABEL_PX * row as f64;
        canvas.text_over((beside, y), anchor, &label.text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_lie_on_each_other() {
        let ends = (0.0, 100.0);
        assert_eq!(apart(&[10.0, 50.0, 90.0], 14.0, ends), [10.0, 50.0, 90.0]);
        assert_eq!(apart(&[10.0, 11.0, 12.0], 14.0, ends), [10.0, 24.0, 38.0]);
        assert_eq!(apart(&[98.0, 99.0, 99.5], 14.0, ends), [72.0, 86.0, 100.0]);
        assert_eq!(apart(&[-5.0, 300.0], 14.0, ends), [0.0, 100.0]);
        // More than fit still keep their distance.
        let many = apart(&[50.0; 20], 14.0, ends);
        assert!(many.windows(2).all(|pair| pair[1] - pair[0] >= 14.0 - 1e-9), "{many:?}");
        assert!(apart(&[], 14.0, ends).is_empty());
    }
}
