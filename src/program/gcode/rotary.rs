//! Rotary axes of G-code, where the job says what they turn.

use nalgebra::{Rotation3, Unit, Vector3};

use super::block::{Block, Counts};
use crate::program::RotaryAxis;
use crate::units::rad_from_deg;

/// Letters of axes beside X, Y and Z.
pub(super) const LETTERS: [u8; 6] = *b"ABCUVW";

pub(super) struct Rotary<'a> {
    /// From the base to the tool, as the job lists them.
    axes: &'a [RotaryAxis],
    /// Angle of each, degrees.
    angles: Vec<f64>,
}

impl<'a> Rotary<'a> {
    pub(super) fn new(axes: &'a [RotaryAxis]) -> Self {
        Self { axes, angles: vec![0.0; axes.len()] }
    }

    /// How far the block turns an axis at most, degrees; one that the job does not name must stay
    /// at zero.
    pub(super) fn turn(&mut self, block: &Block, relative: bool) -> Result<f64, String> {
        let mut turned: f64 = 0.0;
        for word in block.words.iter().filter(|word| LETTERS.contains(&word.letter)) {
            let of_job = self.axes.iter().position(|axis| axis.letter == word.letter);
            let Some(index) = of_job else {
                if word.value == 0.0 {
                    continue;
                }
                return Err(format!(
                    "axis {} moves, and the job does not say what it turns; write \
                     path.program.rotary_axes",
                    char::from(word.letter)
                ));
            };
            let by = match word.counts {
                Counts::AsModal => relative,
                Counts::Absolute => false,
                Counts::Relative => true,
            };
            let angle = if by { self.angles[index] + word.value } else { word.value };
            turned = turned.max((angle - self.angles[index]).abs());
            self.angles[index] = angle;
        }
        Ok(turned)
    }

    /// The tool axis in the work.
    pub(super) fn tool_axis(&self) -> Unit<Vector3<f64>> {
        let turn = |(axis, &angle): (&RotaryAxis, &f64)| {
            let angle = rad_from_deg(angle);
            Rotation3::from_axis_angle(&axis.axis, if axis.turns_work { -angle } else { angle })
        };
        let turns = self.axes.iter().zip(&self.angles).map(turn);
        let tool = turns.fold(Rotation3::identity(), |whole, next| whole * next);
        Unit::new_normalize(tool * Vector3::z())
    }

    /// Whether the job names any.
    pub(super) fn is_named(&self) -> bool {
        !self.axes.is_empty()
    }

    /// Whether an axis turns the work, so that lines of the text are none in the work.
    pub(super) fn moves_work(&self) -> bool {
        self.axes.iter().zip(&self.angles).any(|(axis, angle)| axis.turns_work && *angle != 0.0)
    }

    /// A place of the text, mm, in the work.
    pub(super) fn in_work(&self, at: Vector3<f64>) -> Vector3<f64> {
        let of_work = self.axes.iter().zip(&self.angles).filter(|(axis, _)| axis.turns_work);
        of_work.fold(at, |at, (axis, angle)| {
            let turn = Rotation3::from_axis_angle(&axis.axis, -rad_from_deg(*angle));
            axis.origin_mm + turn * (at - axis.origin_mm)
        })
    }
}
