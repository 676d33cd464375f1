//! Lines and arcs, and corners between two lines: `,R`, `,C`, RND=, CHR=, CHF=.

use nalgebra::{Rotation3, Vector3};

use super::block::{Block, CHAMFER_LENGTH, CHAMFERED, ROUNDED, TURNS};
use super::state::Machine;
use crate::notes::Code;
use crate::program::Pace;
use crate::program::arc::Arc;
use crate::program::corner::{Corner, Kind};

/// What a block asks for, and the size in mm.
pub(super) fn asked(block: &Block, mm: impl Fn(f64) -> f64) -> Result<Option<(Kind, f64)>, String> {
    let asked =
        [(ROUNDED, Kind::Round), (CHAMFERED, Kind::OffLines), (CHAMFER_LENGTH, Kind::Chamfer)];
    let mut found =
        asked.into_iter().filter_map(|(letter, kind)| Some((kind, mm(block.word(letter)?.value))));
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
        // Fanuc and LinuxCNC count the first turn, Sinumerik does not.
        let more_turns = match block.word(TURNS) {
            Some(word) => word.value,
            None => block.get('P').unwrap_or(1.0) - 1.0,
        };
        if !(0.0..=999.0).contains(&more_turns) || more_turns.fract() != 0.0 {
            return Err("P or TURN= must be a whole number of turns".to_owned());
        }
        let arc = Arc {
            start,
            end: Vector3::new(x, y, z),
            plane: self.plane,
            turn: Rotation3::identity(),
            clockwise,
            centre,
            // Whole and in 0..1000, checked above.
            more_turns: more_turns as u32,
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
        corner: Option<(Kind, f64)>,
    ) -> Result<(), String> {
        self.cut_corner(to)?;
        match corner {
            Some((kind, size)) => {
                let pace_in_corner = pace;
                self.corner = Some(Corner { kind, size, line, to, pace, pace_in_corner });
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
        self.corner.take().map_or(Ok(()), |corner| Err(corner.misplaced()))
    }

    fn cut_corner(&mut self, to: Vector3<f64>) -> Result<(), String> {
        let Some(corner) = self.corner.take() else { return Ok(()) };
        if self.rotary.moves_work() {
            return Err("a corner while a rotary axis of the work is used".to_owned());
        }
        corner.cut(&mut self.cutter, to, self.plane, "G17 to G19")
    }
}
