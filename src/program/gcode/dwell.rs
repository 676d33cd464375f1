//! How long G-code has the arm stand: controllers differ in the unit of P.

use super::block::{Block, Word};
use super::state::Machine;
use crate::notes::Code;
use crate::program::log::Log;
use crate::units::{hz_from_rpm, s_from_ms};

/// P without a decimal point from this on is in milliseconds, as Fanuc has it: nobody lets a
/// cutter rub for minutes.
const MILLISECONDS_FROM: f64 = 100.0;

/// The time that P gives, s.
pub(super) fn cycle_dwell_s(log: &mut Log, line: usize, p: Word) -> Result<f64, String> {
    if p.value < 0.0 {
        return Err(format!("P is {}, must not be negative", p.value));
    }
    if p.value < MILLISECONDS_FROM || p.has_point {
        return Ok(p.value);
    }
    let what = format!(
        "P{} of a dwell is read as milliseconds; with a decimal point, or below \
         {MILLISECONDS_FROM}, P is in seconds",
        p.value
    );
    log.warning(Code::Assumed, line, what);
    Ok(s_from_ms(p.value))
}

impl Machine<'_> {
    /// G4: P, or X, U and F in seconds, or S in turns of the spindle.
    pub(super) fn dwell(&mut self, line: usize, block: &Block) -> Result<(), String> {
        let seconds = if let Some(p) = block.word(b'P') {
            cycle_dwell_s(self.cutter.log, line, p)?
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
