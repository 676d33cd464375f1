//! Branches that only the run decides, and that neither move nor decide about motion: what they
//! may set is known no longer, and the program goes on behind them.

use super::flow::{action_of, decides, ends};
use super::others::awaited;
use super::run::{Run, SIGNALS, assignment, drives_hand, is_harmless};
use super::text::{Source, Statement};
use super::words::starts_with;
use crate::notes::Code;
use crate::program::Setter;
use crate::program::cell::all;

/// Behind a branch: why what it sets is not known.
const MAY_SET: &str = " may set it: ";

impl<'a> Run<'a> {
    /// Goes on at a statement, past those that the run does or not; `why` that is not known.
    pub(super) fn leave_open(&mut self, to: usize, why: &str) -> Result<(), String> {
        let between = self.source.statements.get(self.next..to).unwrap_or_default();
        self.budget = self.budget.saturating_sub(between.len());
        if !between.iter().all(|own| self.moves_nothing(own.text.trim())) {
            return Err(decides(why));
        }
        // Of branches in which conditions of others are set the cause is told.
        let cause = why.rsplit(MAY_SET).next().unwrap_or(why);
        let by = format!("a branch of line {}{MAY_SET}{cause}", self.line_before());
        for own in between {
            if !self.may_do(own, own.text.trim(), &by) {
                return Err(decides(why));
            }
        }
        self.next = to;
        Ok(())
    }

    /// Whether a statement neither moves nor chooses what motion depends on, nor leads elsewhere.
    pub(super) fn moves_nothing(&self, text: &str) -> bool {
        if let Some(comment) = text.strip_prefix('!') {
            return !self.sets_by_comment(comment);
        }
        if let Some(rest) = text.strip_prefix("IF") {
            return text.ends_with("THEN")
                || action_of(rest).is_some_and(|(_, action)| {
                    !action.starts_with("IF") && self.moves_nothing(action)
                });
        }
        let is_structure = matches!(text, "" | "ELSE" | "ENDIF") || text.starts_with("//");
        let is_label = starts_with(text, "LBL[");
        let called = self.program_called(text);
        let is_quiet = |own: &Statement| {
            let text = own.text.trim();
            // No further calls: one may lead back.
            !starts_with(text, "CALL") && !text.contains(",CALL") && self.moves_nothing(text)
        };
        is_structure
            || is_label
            || called.is_some_and(|source| source.statements.iter().all(is_quiet))
            || ends(text)
            || is_set(text)
            || is_harmless(text)
            || drives_hand(text)
    }

    /// Whether a comment is one that sets the spindle or the tool, by the job's word.
    pub(super) fn sets_by_comment(&self, comment: &str) -> bool {
        let comment = comment.to_lowercase();
        all(self.settings).any(|(_, by)| {
            matches!(&by.what, Setter::Comment(start) if comment.contains(&start.to_lowercase()))
        })
    }

    /// Takes up what a statement does that the run may pass over; false where that is not read.
    pub(super) fn may_do(&mut self, statement: &Statement, text: &str, by: &str) -> bool {
        let line = self.line_of(statement);
        if let Some(rest) = text.strip_prefix("IF") {
            return text.ends_with("THEN")
                || action_of(rest).is_some_and(|(_, action)| self.may_do(statement, action, by));
        }
        if starts_with(text, "CALL") {
            return self.may_call(statement, text, by);
        }
        if starts_with(text, "WAIT") {
            self.may_wait(line, text.get(4..).unwrap_or("").trim(), by);
        } else if starts_with(text, "PULSE") {
            self.pulse(line, text);
        } else if drives_hand(text) {
            self.drive_hand(line, text);
        } else if is_set(text) {
            return self.forget_assigned(line, text, by);
        } else if ends(text) {
            self.tell_end(line, text);
        } else {
            self.bends_path(line, text);
        }
        true
    }

    /// What a program does that the run may call.
    fn may_call(&mut self, statement: &Statement, text: &str, by: &str) -> bool {
        let Some(source) = self.program_called(text) else { return false };
        let (line, (_, given)) = (self.line_of(statement), self.called(text, statement));
        let arguments = given.into_iter().map(|given| given.value).collect();
        self.within_program(source, line, arguments, |run| {
            let last = source.statements.len().saturating_sub(1);
            source.statements.iter().enumerate().all(|(index, own)| {
                let text = own.text.trim();
                index == last && ends(text) || run.may_do(own, text, by)
            })
        })
    }

    /// The program that a CALL runs, if it is read.
    pub(super) fn program_called(&self, text: &str) -> Option<&'a Source> {
        let name = text.get(4..).filter(|_| starts_with(text, "CALL"))?;
        let name = name.split('(').next().unwrap_or(name).trim();
        self.programs.named(name).ok()?.filter(|_| !self.is_setter(name))
    }

    /// How long the run stands there, or not, is not known.
    fn may_wait(&mut self, line: usize, rest: &str, by: &str) {
        if Self::time_of(rest).is_some() {
            let what = format!("WAIT {rest} in a branch that only the run decides is left out");
            self.log.warning(Code::LeftOut, line, what);
            return;
        }
        let (condition, label) = awaited(rest);
        self.registers.lose_named(condition, by);
        if let Some(label) = label {
            self.doubt_timeout(condition, label, line);
        }
    }

    /// The end of the program under a condition: what stands behind it is read.
    pub(super) fn tell_end(&mut self, line: usize, text: &str) {
        let what = format!(
            "{text} in a branch that only the run decides: the program is read as if it went on"
        );
        self.log.warning(Code::LeftOut, line, what);
    }

    /// The line of the statement that runs.
    fn line_before(&self) -> usize {
        let own = self.next.checked_sub(1).and_then(|at| self.source.statements.get(at));
        own.map_or(1, |own| self.line_of(own))
    }
}

/// Whether a statement sets a register, a position or a signal.
fn is_set(text: &str) -> bool {
    let starts = SIGNALS.iter().chain(&["R[", "PR["]).any(|own| text.starts_with(own));
    starts && assignment(text).is_some()
}
