//! A corner between two lines → what is left of the first, and the arc or the chamfer. Lengths in
//! mm.

use nalgebra::{Unit, Vector3};

use super::Pace;
use super::arc::{Arc, Plane};
use super::cutter::Cutter;

/// Directions this nearly alike make no corner.
const STRAIGHT_RAD: f64 = 1e-6;

/// What a corner becomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// An arc of this radius.
    Round,
    /// A chamfer that takes so much off each line.
    OffLines,
    /// A chamfer of this length.
    Chamfer,
}

/// A line whose end waits for the next to be cut off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corner {
    pub(super) kind: Kind,
    /// mm.
    pub(super) size: f64,
    pub(super) line: usize,
    pub(super) to: Vector3<f64>,
    pub(super) pace: Pace,
    /// Of the arc or the chamfer.
    pub(super) pace_in_corner: Pace,
}

impl Corner {
    pub(super) fn misplaced(&self) -> String {
        format!("the corner of line {} must lie between two lines", self.line)
    }

    /// Draws the line up to the corner and what cuts it off, on the way to `to`; `name` is that of
    /// the plane.
    pub(super) fn cut(
        &self,
        cutter: &mut Cutter<'_>,
        to: Vector3<f64>,
        Plane([.., w]): Plane,
        name: &str,
    ) -> Result<(), String> {
        let Self { kind, size, line, to: tip, pace, pace_in_corner } = *self;
        let from = cutter.place().ok_or("a corner from an unknown position")?;
        let (before, behind) = (tip - from, to - tip);
        let [Some(a), Some(b)] = [before, behind].map(|way| way.try_normalize(1e-9)) else {
            return Err(self.misplaced());
        };
        if a[w].abs().max(b[w].abs()) > STRAIGHT_RAD {
            return Err(format!("the corner of line {line} does not lie in the plane of {name}"));
        }
        let turn = a.angle(&b);
        let off = match kind {
            Kind::Round => size * (turn / 2.0).tan(),
            Kind::OffLines => size,
            Kind::Chamfer => size / (2.0 * (turn / 2.0).cos()),
        };
        if turn < STRAIGHT_RAD || !off.is_finite() {
            cutter.line_to(line, tip, pace);
            return Ok(());
        }
        if off > before.norm() || off > behind.norm() {
            return Err(format!("the corner of line {line} ({size} mm) is larger than its lines"));
        }
        let (start, end) = (tip - a * off, tip + b * off);
        cutter.line_to(line, start, pace);
        if kind != Kind::Round {
            cutter.line_to(line, end, pace_in_corner);
            return Ok(());
        }
        let axis = Unit::new_normalize(a.cross(&b));
        let centre = start + axis.cross(&a) * size;
        cutter.arc(line, &Arc::about(start, end, centre, axis), pace_in_corner)
    }
}
