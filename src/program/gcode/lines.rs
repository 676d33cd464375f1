//! Lines and arcs, and corners between two lines: `,R`, `,C`, RND=, CHR=.

use nalgebra::{Rotation3, Vector3};

use super::block::{Block, CHAMFERED, ROUNDED};
use super::state::{Corner, Machine};
use crate::notes::Code;
use crate::program::Pace;
use crate::program::arc::{Arc, Plane};

/// Directions this nearly alike make no corner.
const STRAIGHT_RAD: f64 = 1e-6;

/// What a block asks for: round or not, and the size in mm.
pub(super) fn asked(block: &Block, mm: impl Fn(f64) -> f64) -> Result<Option<(bool, f64)>, String> {
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

impl Machine<'_> {
    pub(super) fn straight(
        &mut self,
        line: usize,
        block: &Block,
        pace: Pace,
    ) -> Result<(), String> {
        self.turn(block)?;
        let end = self.end_of(block)?;
        let corner = asked(block, |length| self.mm(length))?;
        match end {
            [Some(x), Some(y), Some(z)] => self.line_to(line, Vector3::new(x, y, z), pace, corner),
            _ if pace == Pace::Rapid => {
                self.cutter.at = end;
                Ok(())
            }
            _ => {
                self.cutter.at = end;
                Err(self.cutter.unknown())
            }
        }
    }

    pub(super) fn arc(
        &mut self,
        line: usize,
        block: &Block,
        clockwise: bool,
    ) -> Result<(), String> {
        self.turn(block)?;
        if asked(block, |length| length)?.is_some() {
            return Err("a corner at the end of an arc is not supported".to_owned());
        }
        let pace = self.cutter.pace()?;
        let start = self.cutter.place().ok_or("an arc from an unknown position")?;
        let [Some(x), Some(y), Some(z)] = self.end_of(block)? else {
            return Err("an arc to an unknown position".to_owned());
        };
        let centre = self.centre(block, start)?;
        let turns = block.get('P').unwrap_or(1.0);
        if !(1.0..=1000.0).contains(&turns) || turns.fract() != 0.0 {
            return Err(format!("P is {turns}, must be a whole number of turns"));
        }
        let arc = Arc {
            start,
            end: Vector3::new(x, y, z),
            plane: self.plane,
            turn: Rotation3::identity(),
            clockwise,
            centre,
            // Whole and in 0..1000, checked above.
            more_turns: turns as u32 - 1,
        };
        self.no_corner()?;
        if self.rotary.moves_work() {
            return Err("an arc while a rotary axis of the work is used".to_owned());
        }
        self.cutter.arc(line, &arc, pace)
    }

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

    /// G92 or G10 L20: where the tool stands has these coordinates. Where the place was not known,
    /// the path starts there.
    pub(super) fn stand_at(
        &mut self,
        line: usize,
        axes: [Option<f64>; 3],
        is_of_offset: bool,
    ) -> Result<(), String> {
        self.no_corner()?;
        let was_known = self.cutter.place().is_some();
        self.shift.set_here(&mut self.cutter.at, axes, is_of_offset);
        self.starts_by_g92 |= !was_known;
        if !was_known && self.shift.has_started() {
            let what = "states coordinates at a place that is not known behind moves: the work is \
                        taken to stay where it was";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        match self.cutter.place() {
            Some(place) if !was_known => self.line_to(line, place, Pace::Rapid, None),
            _ => Ok(()),
        }
    }

    /// G92.1 and G92.2: where G92 said where the path starts, what they go back to is not stated.
    pub(super) fn end_g92(&mut self, line: usize, keep: bool) {
        if self.starts_by_g92 {
            let what = "ends the G92 that states where the path starts: where the work is then, \
                        nothing says";
            self.cutter.log.warning(Code::ChangeIgnored, line, what);
        }
        self.shift.reset(keep);
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
        if self.rotary.moves_work() {
            return Err("a corner while a rotary axis of the work is used".to_owned());
        }
        let from = self.cutter.place().ok_or("a corner from an unknown position")?;
        let (before, behind) = (tip - from, to - tip);
        let [Some(a), Some(b)] = [before, behind].map(|way| way.try_normalize(1e-9)) else {
            return Err(format!("the corner of line {line} must lie between two lines"));
        };
        let Plane([.., w]) = self.plane;
        if a[w].abs().max(b[w].abs()) > STRAIGHT_RAD {
            return Err(format!(
                "the corner of line {line} does not lie in the plane of G17 to G19"
            ));
        }
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
