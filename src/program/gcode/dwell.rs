//! How long G-code has the arm stand: controllers differ in the unit of P.

use super::block::{ANGLE, Block, POLAR_ANGLE, POLAR_RADIUS, Word};
use super::state::Machine;
use crate::notes::Code;
use crate::program::DwellUnit;
use crate::units::{hz_from_rpm, s_from_ms};

/// P, X or U without a decimal point from which on nobody waits so many seconds.
const MIN_MILLISECONDS: f64 = 100.0;

impl Machine<'_> {
    /// The time that P, X or U gives, s: seconds with a decimal point, on every controller that
    /// takes one.
    pub(super) fn dwell_s(&mut self, line: usize, p: Word) -> Result<f64, String> {
        let letter = char::from(p.letter);
        if p.value < 0.0 {
            return Err(format!("{letter} is {}, must not be negative", p.value));
        }
        if p.has_point || p.value == 0.0 {
            return Ok(p.value);
        }
        let unit = self.dwell_unit.unwrap_or_else(|| {
            let (unit, shown) = match p.value < MIN_MILLISECONDS {
                true => (DwellUnit::Seconds, "seconds"),
                false => (DwellUnit::Milliseconds, "milliseconds"),
            };
            let what = format!(
                "{letter}{} of a dwell is taken as {shown}: it is in seconds on LinuxCNC and in \
                 milliseconds on Fanuc and Haas; path.program.dwell_unit: s or ms in the job says \
                 which",
                p.value
            );
            // The time matters where the spindle's speed follows it.
            let code = if self.is_scheduled { Code::UnitAssumed } else { Code::Assumed };
            self.cutter.log.warning(code, line, what);
            unit
        });
        Ok(match unit {
            DwellUnit::Seconds => p.value,
            DwellUnit::Milliseconds => s_from_ms(p.value),
        })
    }

    /// G4: P, X or U, or F in seconds, or S in turns of the spindle.
    pub(super) fn dwell(&mut self, line: usize, block: &Block) -> Result<(), String> {
        let mut times = [b'P', b'X', b'U'].into_iter();
        let time = times.find_map(|letter| block.word(letter));
        if moves_beside(block, time) {
            return Err("G4 beside a move: controllers differ in whether the move is made; write \
                        the dwell in a block of its own"
                .to_owned());
        }
        let seconds = if let Some(time) = time {
            self.dwell_s(line, time)?
        } else if let Some(seconds) = block.word(b'F') {
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

/// Whether a block with G4 gives a place besides, or may mean one by what its time is.
fn moves_beside(block: &Block, time: Option<Word>) -> bool {
    let time = time.map(|word| word.letter);
    let of_places = [&b"XYZIJKR"[..], &super::rotary::LETTERS, &[POLAR_ANGLE, POLAR_RADIUS, ANGLE]];
    let is_place = |letter: &u8| of_places.iter().any(|letters| letters.contains(letter));
    let has_motion = block.codes('G').any(|code| matches!(code, 0 | 10 | 20 | 30));
    let mut letters = block.words.iter().map(|word| word.letter);
    letters.any(|letter| is_place(&letter) && (Some(letter) != time || has_motion))
}
