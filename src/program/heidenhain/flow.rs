//! Jumps, subprograms and repeats: LBL, CALL LBL with REP, FN 9 to FN 12.

use std::collections::HashSet;

use super::Reader;
use super::block::content;

/// Calls in one another.
const MAX_CALLS: usize = 10;

impl Reader<'_, '_> {
    /// `IF +Q1 EQU +5 GOTO LBL 3`.
    pub(super) fn jump(&mut self, text: &str) -> Result<(), String> {
        let wrong = "a jump is IF, two values with EQU, NE, GT or LT between, and GOTO LBL";
        let (condition, label) = text.split_once("GOTO").ok_or(wrong)?;
        let condition = condition.trim().strip_prefix("IF").ok_or(wrong)?;
        let label = label.trim().strip_prefix("LBL").ok_or(wrong)?.trim();
        let words = ["EQU", "NE", "GT", "LT"].into_iter();
        let mut split = words.filter_map(|word| condition.split_once(word).map(|two| (word, two)));
        let (word, (left, right)) = split.next().ok_or(wrong)?;
        let [left, right] = [self.value_of(left)?, self.value_of(right)?];
        let is_true = match word {
            "EQU" => left == right,
            "NE" => left != right,
            "GT" => left > right,
            _ => left < right,
        };
        if is_true {
            self.next = self.label(label)?;
        }
        Ok(())
    }

    /// The blocks of subprograms, up to LBL 0, that stand behind the last end of the program and
    /// that nothing in it calls, as templates leave them.
    pub(super) fn uncalled(&self) -> HashSet<usize> {
        let texts = || self.blocks.iter().map(|block| content(block.parts[0].1));
        let mut called = HashSet::new();
        for text in texts().filter(|text| !text.starts_with("LBL")) {
            let leads = text.starts_with("CALL") || text.contains("GOTO");
            match text.split_once("LBL") {
                Some((_, label)) if leads => {
                    let label = label.trim_start();
                    let named = label.strip_prefix('"').and_then(|name| name.split('"').next());
                    let number = || label.split(|c: char| !c.is_ascii_alphanumeric()).next();
                    called.extend(named.or_else(number));
                }
                // Contours by their labels.
                _ if text.contains("LABEL") => return HashSet::new(),
                _ => {}
            }
        }
        let has_computed = called.iter().any(|label| label.starts_with('Q'));
        let (mut found, mut open, mut is_called) = (HashSet::new(), None, false);
        for (index, block) in self.blocks.iter().enumerate().skip(self.next) {
            let label = content(block.parts[0].1).strip_prefix("LBL");
            match label.map(|label| label.trim().trim_matches('"')) {
                Some("0") => {
                    let heads = open.take().filter(|_| !is_called).into_iter();
                    found.extend(heads.flat_map(|head| head..index));
                    is_called = false;
                }
                Some(label) => {
                    open.get_or_insert(index);
                    is_called |= has_computed || called.contains(label);
                }
                None if self.parsed(block).ends_program() => {
                    (found, open) = (HashSet::new(), None);
                }
                None => {}
            }
        }
        found
    }

    fn label(&self, label: &str) -> Result<usize, String> {
        let head = self.labels.get(label.trim_matches('"')).copied();
        head.ok_or_else(|| format!("LBL {label} is not in this program"))
    }

    /// LBL 0: the end of a subprogram that was called.
    pub(super) fn back(&mut self) {
        if let Some((back, head, left)) = self.calls.pop() {
            if left > 1 {
                self.calls.push((back, head, left - 1));
                self.next = head + 1;
            } else {
                self.next = back;
            }
        }
    }

    /// `CALL LBL 1`, or `CALL LBL 1 REP 3`: the part from there to here again.
    pub(super) fn call(&mut self) -> Result<(), String> {
        let index = self.next - 1;
        let text = content(self.blocks[index].parts[0].1);
        let rest = text.trim_start_matches("CALL").trim_start().trim_start_matches("LBL").trim();
        // A label's name may hold REP, too.
        let quoted = rest.rfind('"').map_or(0, |end| end + 1);
        let at = rest.get(quoted..).and_then(|behind| behind.find("REP"));
        let parts = at.and_then(|at| rest.split_at_checked(quoted + at));
        let (label, repeats) = match parts.map(|(label, behind)| (label, behind[3..].trim())) {
            // The prompt without an answer: a subprogram.
            Some((label, "")) => (label.trim(), None),
            Some((label, repeats)) => {
                // `REP 3/3` shows what is left.
                let count = repeats.split('/').next().unwrap_or("").trim();
                let count =
                    self.value_of(count).map_err(|why| format!("REP without a number: {why}"))?;
                if !(0.0..=65534.0).contains(&count) || count.fract() != 0.0 {
                    return Err(format!("REP is {count}, expected a whole number"));
                }
                // Whole and in 0..=65534, checked above.
                (label.trim(), Some(count as u32))
            }
            None => (rest, None),
        };
        let head = self.label(label)?;
        match repeats {
            Some(count) => {
                let left = self.repeats.entry(index).or_insert(count);
                if *left > 0 {
                    *left -= 1;
                    self.next = head + 1;
                } else {
                    self.repeats.remove(&index);
                }
            }
            None => {
                if self.calls.len() >= MAX_CALLS {
                    return Err("calls are nested too deep".to_owned());
                }
                self.calls.push((self.next, head, 1));
                self.next = head + 1;
            }
        }
        Ok(())
    }
}
