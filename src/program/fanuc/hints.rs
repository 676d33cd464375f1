//! What looks like a command to the spindle by its comment, and the job does not read; moves behind
//! an end in mid-program.

use std::collections::HashSet;

use super::programs::Programs;
use super::run::{Run, assignment, signal_key};
use super::text::{Statement, is_motion};
use super::words::{brackets, register, starts_with};
use crate::program::cell::all;
use crate::program::spindle_names::{doubt, is_spindles};
use crate::program::unread::behind;
use crate::program::{Setter, Settings};

/// What stands in the brackets of each register in a text: `R[5:speed]`.
fn registers_in(text: &str) -> impl Iterator<Item = &str> {
    text.split("R[").skip(1).filter_map(|rest| rest.split(']').next())
}

/// Registers in what the program gives to what the job reads the spindle or the tool from.
pub(super) fn given_on(programs: &Programs, settings: &Settings) -> HashSet<i64> {
    let mut found = HashSet::new();
    for (_, by) in all(settings) {
        for statement in programs.all().flat_map(|source| &source.statements) {
            let text = statement.text.trim();
            let given = match &by.what {
                Setter::Signal(own) => {
                    let parts = assignment(text);
                    parts.filter(|(name, _)| signal_key(name) == own.to_lowercase())
                }
                Setter::Procedure(own, _) => {
                    let called = text.get(4..).filter(|_| starts_with(text, "CALL"));
                    let called = called.and_then(|rest| rest.split_once('('));
                    called.filter(|(name, _)| name.trim().eq_ignore_ascii_case(own))
                }
                Setter::Comment(_) => None,
            };
            let Some((_, given)) = given else { continue };
            let numbers = registers_in(given).filter_map(|inside| inside.split(':').next());
            found.extend(numbers.filter_map(|number| number.trim().parse::<i64>().ok()));
        }
    }
    found
}

impl Run<'_> {
    /// Of an output or a flag by its comment, or by that of the register that it is set to.
    pub(super) fn doubt_signal(&mut self, line: usize, name: &str, value: &str) {
        if is_spindles(name) || registers_in(value).any(is_spindles) {
            doubt(self.settings, self.log, line, name.trim());
        }
    }

    /// Of a register that a text assigns, by its comment.
    pub(super) fn doubt_register(&mut self, line: usize, number: i64, text: &str) {
        if !self.given_on.contains(&number) {
            let end = brackets(text, "R").map_or(text.len(), |(_, rest)| text.len() - rest.len());
            self.doubt_name(line, text.get(..end).unwrap_or(text));
        }
    }

    pub(super) fn doubt_name(&mut self, line: usize, name: &str) {
        if is_spindles(name) {
            doubt(self.settings, self.log, line, name);
        }
    }

    /// Tells of the first move behind a statement that has ended the program, or goes elsewhere in
    /// any case: up to a label that is gone to, or the end of a branch.
    pub(super) fn doubt_behind(&mut self, end: &Statement) {
        let all = &self.source.statements;
        let is_gone_to = |label: i64| {
            all.iter().map(|statement| statement.text.trim()).any(|text| {
                let mut labels = text.split("LBL[").skip(1).filter(|_| !text.starts_with("LBL["));
                labels.any(|rest| {
                    rest.starts_with(['R', 'A', 'G'])
                        || register(&format!("LBL[{rest}"), "LBL")
                            .is_some_and(|(own, _)| own == label)
                })
            })
        };
        let mut depth = 0_usize;
        for statement in all.iter().skip(self.next) {
            let text = statement.text.trim();
            let word = text.split([' ', '(']).next().unwrap_or("");
            let is_outer = depth == 0 && matches!(word, "ELSE" | "ENDIF" | "ENDFOR");
            match word {
                "FOR" => depth += 1,
                "IF" if text.ends_with("THEN") => depth += 1,
                "ENDIF" | "ENDFOR" => depth = depth.saturating_sub(1),
                _ => {}
            }
            let ends =
                is_outer || register(text, "LBL").is_some_and(|(label, _)| is_gone_to(label));
            if ends {
                return;
            }
            if is_motion(text) {
                return behind(self.log, self.line_of(statement), end.text.trim());
            }
        }
    }
}
