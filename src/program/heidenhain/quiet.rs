//! Blocks that move nothing: which of those with `/` matter, and what M codes that are not known
//! may do to the blocks behind them.

use super::Reader;
use super::block::{Block, Parameters, Word, content, parse};
use crate::notes::Code;

/// Stops and coolant.
const IDLE: [f64; 5] = [0.0, 1.0, 7.0, 8.0, 9.0];

/// M codes that start the spindle, change the tool or call a cycle.
const ACTS: [f64; 8] = [3.0, 4.0, 6.0, 13.0, 14.0, 89.0, 99.0, 140.0];

fn ends(code: f64) -> bool {
    code == 2.0 || code == 30.0
}

/// Whether a cycle of this number does nothing where it is defined: shifts and turns of the work,
/// tolerance, the preset, and those that a call runs.
fn is_still(number: &Word<'_>) -> bool {
    let number = number.value.map(|number| number.floor() as i64);
    matches!(number, Some(1 | 7 | 8 | 10 | 19 | 32 | 200..=208 | 247))
}

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

    /// Whether the program ends by it.
    pub(super) fn ends_program(&self) -> bool {
        self.all("M").any(ends)
    }

    /// Whether the program ends by it, and does nothing else.
    fn is_end(&self) -> bool {
        self.m_codes_alone().is_some_and(|mut all| all.any(ends))
            && self.all("M").all(|code| ends(code) || IDLE.contains(&code))
    }
}

impl Reader<'_, '_> {
    /// Whether nothing that stands behind the block of the end moves, or leads to what does.
    fn is_still_behind(&self, block: usize) -> bool {
        let none = Parameters::new();
        let mut behind = self.blocks.iter().skip(block + 1);
        self.calls.is_empty()
            && behind.all(|text| {
                let part = text.parts[0].1;
                let words = parse(part, 0, &none);
                match words.name(0) {
                    "LBL" | "END" => true,
                    "CYCL" => words.name(1) == "DEF" && words.words.get(2).is_some_and(is_still),
                    "PLANE" => words.has("STAY"),
                    "FN" => part.split_once("GOTO LBL").is_none_or(|(_, label)| {
                        self.labels
                            .get(label.trim().trim_matches('"'))
                            .is_some_and(|at| *at > block)
                    }),
                    name => name.starts_with('Q') || words.is_idle(),
                }
            })
    }

    /// The line of the first block with `/` that has run, or a label to which something has come,
    /// and without which the program is another.
    pub(super) fn first_to_skip(&self) -> Option<usize> {
        let none = Parameters::new();
        let ran = |block: usize| self.ran.get(block) == Some(&true);
        let matters = |text: &str, block: usize| {
            let words = parse(text, 0, &none);
            let changes = || !(words.is_end() && self.is_still_behind(block));
            ran(block) && !words.is_idle() && changes()
                || content(text).starts_with("LBL") && ran(block + 1)
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
