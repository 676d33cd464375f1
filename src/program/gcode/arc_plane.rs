//! The plane of an arc of Sinumerik's: the axes of its end may name another one than G17 to G19 do
//! (Siemens, SINUMERIK ISO Dialects for Milling, 6FC5398-7BP10-1BA0, "Circular interpolation").

use nalgebra::{Rotation3, Vector3};

use super::block::{Block, OPENING, POLAR_ANGLE, POLAR_RADIUS, RADIUS, TURNS};
use super::frame::ROUNDING_MM;
use super::state::{AXES, CENTRES, Machine};
use crate::notes::Code;
use crate::program::arc::{Arc, Plane, pieces};

impl Machine<'_> {
    /// The plane in which an arc from one place to another lies. A helix whose end leaves out an
    /// axis that stays has the same axes as an arc across the plane: where both are possible, which
    /// is meant is not known.
    pub(super) fn plane_of_arc(
        &mut self,
        line: usize,
        block: &Block,
        [start, end]: [Vector3<f64>; 2],
        clockwise: bool,
    ) -> Result<Plane, String> {
        let own @ Plane([u, v, w]) = self.plane;
        // Helices and opening angles belong to the plane that is chosen.
        let of_own = [OPENING, TURNS, POLAR_ANGLE, POLAR_RADIUS];
        if !self.is_sinumerik || block.has_any(&of_own) {
            return Ok(own);
        }
        let [ends, centres] =
            [AXES, CENTRES].map(|letters| letters.map(|letter| block.word(letter).is_some()));
        let beside_w = |words: [bool; 3]| match (words[w], words[u], words[v]) {
            (true, true, false) => Some(u),
            (true, false, true) => Some(v),
            _ => None,
        };
        let axis = match (beside_w(ends), beside_w(centres)) {
            (Some(of_end), Some(of_centre)) if of_end != of_centre => {
                return Err("the end and the centre of the arc have axes of two planes: write \
                            those of one, and G17, G18 or G19 before it"
                    .to_owned());
            }
            (of_end, of_centre) => of_end.or(of_centre),
        };
        let is_own_end = ends[u] && ends[v] && !ends[w];
        let Some(axis) = axis.filter(|_| !is_own_end) else { return Ok(own) };
        let across = u + v - axis;
        let other = [Plane::YZ, Plane::ZX, Plane::XY][across];
        let stays = |axis: usize| (end[axis] - start[axis]).abs() <= ROUNDING_MM;
        let is_own_centre = block.word(CENTRES[w]).is_none_or(|word| word.value == 0.0);
        let is_named = match (beside_w(ends), beside_w(centres)) {
            // One that goes down may be a helix of that radius.
            (Some(_), None) => block.has_any(&[RADIUS]) && stays(w),
            (Some(_), Some(_)) => true,
            _ => !is_own_centre,
        };
        if is_named && !(ends[across] || centres[across]) {
            return Ok(other);
        }
        let closes = |plane: Plane| {
            let Ok(centre) = self.centre(block, start, plane, self.centre_absolute) else {
                return false;
            };
            let Plane([.., w]) = plane;
            let turn = Rotation3::identity();
            let arc = Arc { start, end, plane, turn, clockwise, centre, more_turns: 0 };
            (plane == own || stays(w)) && pieces(&arc).is_ok()
        };
        match (closes(other), closes(own)) {
            (true, false) => return Ok(other),
            (true, true) => {}
            // A helix: the control stops at an arc that does not close.
            (false, _) => return Ok(own),
        }
        let [own_code, other_code] = [own, other].map(code);
        let what = format!(
            "the axes of the arc may name the plane of {other_code}: it is read in that of \
             {own_code}, which is chosen; write {other_code} before it, or {} and {} of its end",
            char::from(AXES[u]),
            char::from(AXES[v])
        );
        self.cutter.log.warning(Code::MotionLeftOut, line, what);
        Ok(own)
    }
}

/// What chooses a plane.
pub(super) fn code(plane: Plane) -> &'static str {
    match plane {
        Plane::XY => "G17",
        Plane::ZX => "G18",
        _ => "G19",
    }
}
