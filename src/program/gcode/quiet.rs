//! Blocks that move nothing, and what M codes that are not known may do to the blocks behind them.

use super::block::Block;
use super::codes::shown;
use super::state::Machine;
use crate::notes::Code;

/// Stops and coolant: M codes that do nothing to a path.
const STOPS: [i64; 2] = [0, 10];
const COOLANT: [i64; 3] = [70, 80, 90];

/// M codes that start the spindle, change the tool or lead to other blocks.
const ACTS: [i64; 9] = [30, 40, 60, 130, 140, 170, 970, 980, 990];
const CALLS_FILE: i64 = 1980;

/// Ways to places of the machine, at rapid.
const TO_MACHINE: [i64; 3] = [280, 300, 530];

/// G codes that say how later blocks are read, and move nothing by themselves.
const MODES: [i64; 13] = [170, 180, 190, 200, 210, 400, 490, 540, 690, 800, 900, 910, 940];

impl Block {
    fn has_only(&self, letters: &[u8]) -> bool {
        self.names.is_empty() && self.words.iter().all(|word| letters.contains(&word.letter))
    }

    /// Whether the program is the same without it: a comment, a stop, coolant.
    pub(super) fn is_idle(&self) -> bool {
        let does_nothing = |code| STOPS.contains(&code) || COOLANT.contains(&code);
        self.sets.is_empty() && self.has_only(b"NM") && self.codes('M').all(does_nothing)
    }

    /// Whether nothing moves by it, and the spindle does not start: codes that are not known apart.
    fn is_quiet(&self) -> bool {
        let acts = |code| ACTS.contains(&code) || code == CALLS_FILE;
        let to_machine = self.codes('G').any(|code| TO_MACHINE.contains(&code));
        let letters: &[u8] = if to_machine { b"NGMXYZABC" } else { b"NGM" };
        let is_mode =
            |code| MODES.contains(&code) || to_machine && (code == 0 || TO_MACHINE.contains(&code));
        self.has_only(letters) && !self.codes('M').any(acts) && self.codes('G').all(is_mode)
    }
}

impl Machine<'_> {
    /// An M code that is not known; true where it is taken to start the spindle.
    pub(super) fn unknown(
        &mut self,
        line: usize,
        code: i64,
        block: &Block,
        has_speed: bool,
    ) -> bool {
        let name = shown('M', code);
        if has_speed {
            let what = format!("{name} is not understood; with S it is taken to start the spindle");
            self.cutter.log.warning(Code::SpindleCommand, line, what);
            self.cutter.turn_spindle(line, true);
            return true;
        }
        if code == 660 && !self.is_sinumerik && block.has_any(b"PE") {
            let what = "M66 waits for an input: how long is not known, and left out";
            self.tell_time(line, what);
            return false;
        }
        // To LinuxCNC outputs by number, to Haas some of the user's own.
        let is_output = matches!(code, 620 | 630 | 640 | 650) && !self.is_sinumerik;
        let is = match is_output {
            true => "switches an output and is left out",
            false => "is not understood and left out",
        };
        let (note, more) = match code {
            610 => (Code::ChangeIgnored, ": on LinuxCNC it says which tool is in the spindle"),
            700 | 720 | 730 => (
                Code::ChangeIgnored,
                ": on LinuxCNC it keeps or restores units, feed and G90 or G91, and on Sinumerik \
                 M70 makes the spindle an axis",
            ),
            _ if self.cutter.is_on == Some(false) => {
                // Told when it is known whether anything follows.
                self.unknown_codes.push((line, format!("{name} {is}")));
                self.tell_unknown_before(block);
                return false;
            }
            _ => (Code::LeftOut, ""),
        };
        let what = format!("{name} {is}{more}");
        self.cutter.log.warning(note, line, what);
        false
    }

    /// A block that may move, start the spindle or call another follows codes that are not known.
    pub(super) fn tell_unknown_before(&mut self, block: &Block) {
        if !block.is_quiet() {
            self.tell_unknown();
        }
    }

    pub(super) fn tell_unknown(&mut self) {
        for (line, what) in std::mem::take(&mut self.unknown_codes) {
            let what = format!("{what}; if it starts the spindle, what follows is not checked");
            self.cutter.log.warning(Code::SpindleCommand, line, what);
        }
    }

    /// The program ends: nothing follows codes that are not known.
    pub(super) fn end_unknown(&mut self) {
        for (line, what) in std::mem::take(&mut self.unknown_codes) {
            self.cutter.log.warning(Code::LeftOut, line, what);
        }
    }
}
