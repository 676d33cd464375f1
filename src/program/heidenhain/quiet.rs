//! Blocks that move nothing: which of those with `/` matter, and what M codes that are not known
//! may do to the blocks behind them.

use super::Reader;
use super::block::{Block, Parameters, content, parse};
use crate::notes::Code;

/// Stops and coolant.
const IDLE: [f64; 5] = [0.0, 1.0, 7.0, 8.0, 9.0];

/// M codes that start the spindle, change the tool or call a cycle.
const ACTS: [f64; 8] = [3.0, 4.0, 6.0, 13.0, 14.0, 89.0, 99.0, 140.0];

impl Block<'_> {
    /// A stop or M codes alone, and which.
    fn m_codes_alone(&self) -> Option<impl Iterator<Item = f64> + '_> {
        let is_of_m = |name: &str| matches!(name, "M" | "STOP");
        self.words.iter().all(|word| is_of_m(word.name)).then(|| self.all("M"))
    }

    /// Whether the program is the same without it.
    fn is_idle(&self) -> bool {
        let does_nothing = |code| IDLE.contains(&code);
        self.name(0) == "BLK" || self.m_codes_alone().is_some_and(|mut all| all.all(does_nothing))
    }

    /// Whether nothing moves by it, and the spindle does not start: codes that are not known apart.
    pub(super) fn is_quiet(&self) -> bool {
        let acts = |code| ACTS.contains(&code);
        self.name(0) == "END" || self.m_codes_alone().is_some_and(|mut all| !all.any(acts))
    }
}

impl Reader<'_, '_> {
    /// The line of the first block with `/` that has run, or a label to which something has come,
    /// and without which the program is another.
    pub(super) fn first_to_skip(&self) -> Option<usize> {
        let none = Parameters::new();
        let ran = |block: usize| self.ran.get(block) == Some(&true);
        let matters = |text: &str, block: usize| {
            let words = parse(text, 0, &none);
            ran(block) && !words.is_idle() || content(text).starts_with("LBL") && ran(block + 1)
        };
        let mut marked = self.blocks.iter().enumerate().filter(|(_, text)| text.may_be_skipped);
        let (_, first) =
            marked.find(|(block, text)| text.parts.iter().any(|part| matters(part.1, *block)))?;
        Some(first.line)
    }

    /// Something that may move or start the spindle follows codes that are not known.
    pub(super) fn tell_unknown(&mut self) {
        self.leave_out_unknown(Code::SpindleCommand);
    }

    /// Nothing follows them, or the spindle turns already.
    pub(super) fn end_unknown(&mut self) {
        self.leave_out_unknown(Code::LeftOut);
    }

    fn leave_out_unknown(&mut self, note: Code) {
        for (line, code) in std::mem::take(&mut self.unknown_codes) {
            let what = format!("M{code} is not understood and left out");
            self.cutter.log.warning(note, line, what);
        }
    }
}
