//! Corners between two lines that are rounded or chamfered: `,R`, `,C`, RND=, CHR=.

use nalgebra::Vector3;

use super::block::{Block, CHAMFERED, ROUNDED};
use super::state::Machine;
use crate::program::Pace;
use crate::program::arc::Arc;

/// Directions this nearly alike make no corner.
const STRAIGHT_RAD: f64 = 1e-6;

/// A line whose end waits for the next to be cut off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corner {
    is_round: bool,
    /// Radius, or length that is cut off each line, mm.
    size: f64,
    line: usize,
    to: Vector3<f64>,
    pace: Pace,
}

impl Corner {
    /// The line that asks for it.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// What a block asks for: round or not, and the size in mm.
    pub(super) fn of(
        block: &Block,
        mm: impl Fn(f64) -> f64,
    ) -> Result<Option<(bool, f64)>, String> {
        let asked = [(ROUNDED, true), (CHAMFERED, false)];
        let mut found = asked
            .into_iter()
            .filter_map(|(letter, is_round)| Some((is_round, mm(block.word(letter)?.value))));
        match (found.next(), found.next()) {
            (Some(_), Some(_)) => Err("a corner is both rounded and chamfered".to_owned()),
            (Some((_, size)), None) if size < 0.0 => {
                Err(format!("the size of a corner is {size} mm, must not be negative"))
            }
            (found, _) => Ok(found.filter(|(_, size)| *size > 0.0)),
        }
    }
}

impl Machine<'_> {
    /// A line, with the corner before it cut off, and the one behind it to be.
    pub(super) fn line_to(
        &mut self,
        line: usize,
        to: Vector3<f64>,
        pace: Pace,
        corner: Option<(bool, f64)>,
    ) -> Result<(), String> {
        self.cut_corner(to)?;
        match corner {
            Some((is_round, size)) => {
                self.corner = Some(Corner { is_round, size, line, to, pace });
                Ok(())
            }
            None => {
                let at = self.rotary.in_work(to);
                self.cutter.line_to(line, at, pace);
                // Where the text has it.
                self.cutter.at = [Some(to.x), Some(to.y), Some(to.z)];
                self.shift.start();
                Ok(())
            }
        }
    }

    /// What comes now does not go on from a corner.
    pub(super) fn no_corner(&mut self) -> Result<(), String> {
        match self.corner.take() {
            None => Ok(()),
            Some(Corner { line, .. }) => {
                Err(format!("the corner of line {line} must lie between two lines"))
            }
        }
    }

    fn cut_corner(&mut self, to: Vector3<f64>) -> Result<(), String> {
        let Some(Corner { is_round, size, line, to: tip, pace }) = self.corner.take() else {
            return Ok(());
        };
        let from = self.cutter.place().ok_or("a corner from an unknown position")?;
        let (before, behind) = (tip - from, to - tip);
        let [Some(a), Some(b)] = [before, behind].map(|way| way.try_normalize(1e-9)) else {
            return Err(format!("the corner of line {line} must lie between two lines"));
        };
        let turn = a.angle(&b);
        let off = if is_round { size * (turn / 2.0).tan() } else { size };
        if turn < STRAIGHT_RAD || !off.is_finite() {
            self.cutter.line_to(line, tip, pace);
            return Ok(());
        }
        if off > before.norm() || off > behind.norm() {
            return Err(format!("the corner of line {line} ({size} mm) is larger than its lines"));
        }
        let (start, end) = (tip - a * off, tip + b * off);
        self.cutter.line_to(line, start, pace);
        if !is_round {
            self.cutter.line_to(line, end, pace);
            return Ok(());
        }
        let axis = nalgebra::Unit::new_normalize(a.cross(&b));
        let centre = start + axis.cross(&a) * size;
        self.cutter.arc(line, &Arc::about(start, end, centre, axis), pace)
    }
}
