//! How long G-code has the arm stand: controllers differ in the unit of P.

use super::block::{Block, Word};
use super::state::Machine;
use crate::program::DwellUnit;
use crate::units::{hz_from_rpm, s_from_ms};

/// The time that P gives, s: seconds with a decimal point, on every controller that takes one.
pub(super) fn dwell_s(p: Word, unit: Option<DwellUnit>) -> Result<f64, String> {
    match unit {
        _ if p.value < 0.0 => Err(format!("P is {}, must not be negative", p.value)),
        _ if p.has_point || p.value == 0.0 => Ok(p.value),
        Some(DwellUnit::Seconds) => Ok(p.value),
        Some(DwellUnit::Milliseconds) => Ok(s_from_ms(p.value)),
        None => Err(format!(
            "P{} of a dwell is in seconds on LinuxCNC and in milliseconds on Fanuc and Haas; write \
             path.program.dwell_unit: s or ms in the job",
            p.value
        )),
    }
}

impl Machine<'_> {
    /// G4: P, or X, U and F in seconds, or S in turns of the spindle.
    pub(super) fn dwell(&mut self, line: usize, block: &Block) -> Result<(), String> {
        let seconds = if let Some(p) = block.word(b'P') {
            dwell_s(p, self.dwell_unit)?
        } else if let Some(seconds) =
            [b'X', b'U', b'F'].into_iter().find_map(|letter| block.word(letter))
        {
            seconds.value
        } else if let Some(turns) = block.word(b'S') {
            match self.cutter.rpm {
                Some(rpm) if rpm > 0.0 => turns.value / hz_from_rpm(rpm),
                _ => return Err("a dwell in turns of a spindle that stands".to_owned()),
            }
        } else {
            return Err("G4 without a time".to_owned());
        };
        self.cutter.log.dwell(line, seconds);
        Ok(())
    }
}
