//! Rotary axes of G-code, where the job says what they turn.

use nalgebra::{Isometry3, Point3, Rotation3, Unit, UnitQuaternion, Vector3};

use super::block::{Block, Counts, Word};
use super::frame::Place;
use crate::program::RotaryAxis;
use crate::units::rad_from_deg;

/// Letters of axes beside X, Y and Z.
pub(super) const LETTERS: [u8; 6] = *b"ABCUVW";

const FULL_TURN_DEG: f64 = 360.0;

/// Relative turns add up to whole ones but for rounding, degrees.
const ROUNDING_DEG: f64 = 1e-6;

/// An axis has no share in another up to rounding.
const NO_SHARE: f64 = 1e-12;

/// Between unit vectors of one direction.
const UNTILTED: f64 = 1e-9;

fn is_whole_turn(angle: f64) -> bool {
    let rest = angle.rem_euclid(FULL_TURN_DEG);
    rest.min(FULL_TURN_DEG - rest) <= ROUNDING_DEG
}

pub(super) struct Rotary<'a> {
    /// As the job lists them: from the base to the tool, or to the work that they turn.
    axes: &'a [RotaryAxis],
    /// Angle of each, degrees.
    angles: Vec<f64>,
    /// Whether it has gone to where the program does not say.
    are_away: Vec<bool>,
    /// Tool centre point control: places of the text are those of the tip in the turned work.
    follows_tip: bool,
}

impl<'a> Rotary<'a> {
    pub(super) fn new(axes: &'a [RotaryAxis]) -> Self {
        Self {
            axes,
            angles: vec![0.0; axes.len()],
            are_away: vec![false; axes.len()],
            follows_tip: false,
        }
    }

    /// How far the block turns an axis at most, degrees; one that the job does not name must stay
    /// at zero.
    pub(super) fn turn(&mut self, block: &Block, relative: bool) -> Result<f64, String> {
        let mut turned: f64 = 0.0;
        for word in block.words.iter().filter(|word| LETTERS.contains(&word.letter)) {
            let Some((index, by)) = self.named(word, relative)? else { continue };
            let angle = if by { self.angles[index] + word.value } else { word.value };
            turned = turned.max((angle - self.angles[index]).abs());
            self.angles[index] = angle;
            self.are_away[index] &= by;
        }
        Ok(turned)
    }

    /// Which axis of the job a word turns, and whether it counts from where the axis is; none where
    /// it leaves one at zero that the job does not name.
    fn named(&self, word: &Word, relative: bool) -> Result<Option<(usize, bool)>, String> {
        let of_job = self.axes.iter().position(|axis| axis.letter == word.letter);
        let by = match word.counts {
            Counts::AsModal => relative,
            Counts::Absolute => false,
            Counts::Relative => true,
        };
        match of_job {
            Some(index) => Ok(Some((index, by))),
            None if word.value == 0.0 => Ok(None),
            None => Err(format!(
                "axis {} moves, and the job does not say what it turns; write \
                 path.program.rotary_axes",
                char::from(word.letter)
            )),
        }
    }

    /// Whether the block turns an axis, or may: where it is has to be known.
    pub(super) fn turns_by(&self, block: &Block, relative: bool) -> bool {
        let mut words = block.words.iter().filter(|word| LETTERS.contains(&word.letter));
        words.any(|word| match self.named(word, relative) {
            Ok(None) => false,
            Ok(Some((index, _))) if self.are_away[index] => true,
            Ok(Some((_, true))) => word.value != 0.0,
            Ok(Some((index, false))) => word.value != self.angles[index],
            Err(_) => true,
        })
    }

    /// The axes of a block go to a reference or a place of the machine.
    pub(super) fn leave(&mut self, block: &Block) {
        for (axis, is_away) in self.axes.iter().zip(&mut self.are_away) {
            *is_away |= block.word(axis.letter).is_some();
        }
    }

    /// An axis of which the program does not say where it is.
    pub(super) fn away(&self) -> Option<char> {
        let mut all = self.axes.iter().zip(&self.are_away);
        all.find(|(_, is_away)| **is_away).map(|(axis, _)| char::from(axis.letter))
    }

    /// G92 and the like say anew what an axis has, or shift its zero: but for whole turns, the work
    /// would lie elsewhere than the job says.
    pub(super) fn count_anew(&mut self, block: &Block, is_shift: bool) -> Result<(), String> {
        for word in block.words.iter().filter(|word| LETTERS.contains(&word.letter)) {
            let of_job = self.axes.iter().position(|axis| axis.letter == word.letter);
            match of_job.filter(|_| !is_shift).map(|index| &mut self.angles[index]) {
                Some(angle) if is_whole_turn(*angle - word.value) => *angle = word.value,
                None if word.value == 0.0 => {}
                _ => {
                    let name = char::from(word.letter);
                    return Err(format!("another zero of axis {name} is not supported"));
                }
            }
        }
        Ok(())
    }

    /// The tool axis in the work.
    pub(super) fn tool_axis(&self) -> Unit<Vector3<f64>> {
        Unit::new_normalize(self.turned_back(self.tool_in_machine()))
    }

    /// Whether axes of the tool turn it away from the Z of the machine.
    pub(super) fn tilts_tool(&self) -> bool {
        (self.tool_in_machine() - Vector3::z()).norm() > UNTILTED
    }

    fn tool_in_machine(&self) -> Vector3<f64> {
        let of_tool = self.axes.iter().zip(&self.angles).filter(|(axis, _)| !axis.turns_work);
        let turns = of_tool
            .map(|(axis, angle)| Rotation3::from_axis_angle(&axis.axis, rad_from_deg(*angle)));
        turns.fold(Rotation3::identity(), |whole, next| whole * next) * Vector3::z()
    }

    /// The tool axis in the work while no axis turns the tool.
    pub(super) fn untilted(&self) -> Vector3<f64> {
        self.turned_back(Vector3::z())
    }

    /// Tool centre point control on or off.
    pub(super) fn follow_tip(&mut self, follows: bool) {
        self.follows_tip = follows;
    }

    /// A place of the text under tool centre point control as it is without, or the other way
    /// round. What would depend on an axis that is not known is not known, either.
    pub(super) fn told_otherwise(&self, place: Place) -> Place {
        let to_work = self.of_work().fold(Isometry3::identity(), |whole, (axis, angle)| {
            let turn = UnitQuaternion::from_axis_angle(&axis.axis, -rad_from_deg(angle));
            Isometry3::rotation_wrt_point(turn, axis.origin_mm.into()) * whole
        });
        let to = if self.follows_tip { to_work.inverse() } else { to_work };
        let end = to * Point3::from(place.map(|at| at.unwrap_or(0.0)));
        let turn = to.rotation.to_rotation_matrix();
        [0, 1, 2].map(|row| {
            let mut all = place.iter().enumerate();
            let is_known = all.all(|(axis, at)| at.is_some() || turn[(row, axis)].abs() < NO_SHARE);
            is_known.then_some(end[row])
        })
    }

    /// Whether it is on.
    pub(super) fn follows_tip(&self) -> bool {
        self.follows_tip
    }

    /// Whether the job names any.
    pub(super) fn is_named(&self) -> bool {
        !self.axes.is_empty()
    }

    /// Whether an axis turns the tool away from the Z of the text.
    pub(super) fn turns_tool(&self) -> bool {
        let mut all = self.axes.iter().zip(&self.angles);
        all.any(|(axis, angle)| (self.follows_tip || !axis.turns_work) && *angle != 0.0)
    }

    /// Whether an axis turns the work, so that lines of the text are none in the work.
    pub(super) fn moves_work(&self) -> bool {
        !self.follows_tip && self.is_work_turned()
    }

    /// Whether an axis of the work is off zero.
    pub(super) fn is_work_turned(&self) -> bool {
        self.of_work().any(|(_, angle)| angle != 0.0)
    }

    fn of_work(&self) -> impl Iterator<Item = (&RotaryAxis, f64)> {
        let all = self.axes.iter().zip(&self.angles);
        all.filter(|(axis, _)| axis.turns_work).map(|(axis, angle)| (axis, *angle))
    }

    /// A place of the text, mm, in the work.
    pub(super) fn in_work(&self, at: Vector3<f64>) -> Vector3<f64> {
        if self.follows_tip {
            return at;
        }
        self.of_work().fold(at, |at, (axis, angle)| {
            let turn = Rotation3::from_axis_angle(&axis.axis, -rad_from_deg(angle));
            axis.origin_mm + turn * (at - axis.origin_mm)
        })
    }

    /// A direction of the text in the work.
    pub(super) fn way_in_work(&self, way: Vector3<f64>) -> Vector3<f64> {
        if self.follows_tip { way } else { self.turned_back(way) }
    }

    /// A direction of the machine in the work.
    fn turned_back(&self, way: Vector3<f64>) -> Vector3<f64> {
        self.of_work().fold(way, |way, (axis, angle)| {
            Rotation3::from_axis_angle(&axis.axis, -rad_from_deg(angle)) * way
        })
    }
}
