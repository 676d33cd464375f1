//! Branches and loops of TP programs: IF, SELECT, JMP, FOR.

use std::collections::HashMap;
use std::ops::RangeInclusive;

use super::registers::names_asked;
use super::run::{BEHIND_ERROR, Run, SIGNALS, is_harmless};
use super::text::{Statement, is_motion, is_remark};
use super::why::both;
use super::words::{register, split_outside, starts_with};
use crate::notes::Code;
use crate::program::single;

impl<'a> Run<'a> {
    /// `JMP LBL[1]`: on from there. An endless loop is read once.
    pub(super) fn jump(&mut self, text: &str, line: usize) -> Result<(), String> {
        let target = text.get(text.find("LBL").unwrap_or(0)..).unwrap_or("");
        let found = self.registers.numbered(target, "LBL")?;
        let (number, behind) = found.ok_or("JMP without LBL[ ]")?;
        if !behind.trim().is_empty() {
            return Err(format!("'{}' behind JMP LBL[{number}] is not understood", behind.trim()));
        }
        let lines = |at: usize| self.source.statements.get(at).map_or(0, |own| own.line);
        let at = match self.source.labels.get(&number).map_or(&[][..], Vec::as_slice) {
            [] => return Err(format!("LBL[{number}] is not in this program")),
            [at] => *at,
            [first, second, ..] => {
                return Err(format!(
                    "LBL[{number}] stands in lines {} and {}: which is meant is not known; number \
                     the labels apart",
                    lines(*first),
                    lines(*second)
                ));
            }
        };
        // A loop that is left is over.
        let own = &self.source.loops;
        let ends = |first: usize| own.iter().find(|[start, _]| start + 1 == first);
        self.loops
            .retain(|(first, ..)| ends(*first).is_none_or(|[_, end]| (*first..*end).contains(&at)));
        let runs = |start: usize| self.loops.iter().any(|(first, ..)| *first == start + 1);
        if let Some([start, _]) =
            own.iter().find(|[start, end]| (start + 1..*end).contains(&at) && !runs(*start))
        {
            return Err(format!(
                "JMP LBL[{number}] leads into the FOR of line {}, which does not run there: not \
                 supported",
                lines(*start)
            ));
        }
        if at < self.next && self.is_lost {
            // Which way it goes is not known: the errors are all told.
            self.next = self.source.statements.len();
        } else if at < self.next && text.starts_with("JMP") && self.is_endless(at) {
            self.tell_endless(line, at);
            self.next = self.source.statements.len();
        } else {
            self.next = at + 1;
        }
        Ok(())
    }

    /// Tells of a loop back to a label that nothing in it ends. Without a move it waits for what
    /// others set.
    fn tell_endless(&mut self, line: usize, label: usize) {
        const ONCE: &str = "an endless loop: read once, without the move from its end back to its \
                            beginning";
        let (jump, all) = (self.next - 1, &self.source.statements);
        let body = all.get(label..jump).unwrap_or_default();
        let exits = body.iter().filter(|own| leads_out(own, &self.source.labels, label..=jump));
        let exits: Vec<&Statement> = exits.collect();
        let simple = exits.iter().filter_map(|own| action_of(own.text.trim().strip_prefix("IF")?));
        let simple: Vec<(&str, &str)> = simple.map(|(asked, does)| (asked.trim(), does)).collect();
        let asked: Vec<&str> = simple.iter().map(|(asked, _)| *asked).collect();
        // Another exit may lead past what stands behind the loop.
        let on = simple.iter().find(|(_, does)| self.leads_right_behind(does));
        let moves = |own: &&Statement| is_motion(own.text.trim());
        let left = all.iter().skip(self.next).find(moves).map_or_else(String::new, |own| {
            format!("; what stands behind it, from the move of line {} on, is not read", own.line)
        });
        let may_move = |own: &Statement| moves(&own) || own.text.contains("CALL ");
        let what = match asked.join(" or ") {
            _ if exits.is_empty() => ONCE.to_owned(),
            asked if asked.is_empty() => format!("{ONCE}{left}"),
            asked if body.iter().any(may_move) => {
                format!("{ONCE}; nothing in it leads to {asked}{left}")
            }
            asked => {
                let on = on.map_or_else(String::new, |(asked, _)| {
                    format!(": in the file that is checked write WAIT {asked} in place of the loop")
                });
                format!(
                    "the loop waits for {asked}, which only another program or the cell can \
                     set{left}{on}"
                )
            }
        };
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    /// Whether `JMP LBL[2]` leads to what stands next, past labels and remarks alone.
    fn leads_right_behind(&self, action: &str) -> bool {
        let target = self.label_ahead(action);
        let between = target.and_then(|at| self.source.statements.get(self.next..at));
        between.is_some_and(|between| {
            let mut texts = between.iter().map(|own| own.text.trim());
            texts.all(|text| is_remark(text) || text.starts_with("LBL["))
        })
    }

    /// Whether the jump that has just run goes back to a label that has run for nothing: nothing
    /// leads out of there, or nothing that conditions there ask for has changed.
    fn is_endless(&mut self, label: usize) -> bool {
        let jump = self.next - 1;
        let Some(before) = self.passed.get(&label) else { return false };
        let asked = self.asked.entry([label, jump]).or_insert_with(|| {
            let body = self.source.statements.get(label..jump).unwrap_or_default();
            let leaves = is_in_branch(body)
                || body.iter().any(|own| leads_out(own, &self.source.labels, label..=jump));
            leaves.then(|| body.iter().flat_map(|own| names_asked(own.text.trim())).collect())
        });
        let now = self.registers.state();
        asked.as_ref().is_none_or(|asked| before.is_same(&now, asked))
    }

    /// `IF cond,JMP LBL[1]`, `IF cond,CALL x`, `IF (cond) THEN`.
    pub(super) fn condition(&mut self, statement: &'a Statement) -> Result<(), String> {
        let (text, line) = (statement.text.trim(), self.line_of(statement));
        let rest = text.get(2..).unwrap_or("").trim();
        if let Some(condition) = rest.strip_suffix("THEN") {
            return match self.registers.truth(condition.trim().trim_end_matches(',')) {
                Ok(true) => Ok(()),
                Ok(false) => {
                    let otherwise = self.behind("ELSE", &["IF"]);
                    let end = self.behind("ENDIF", &["IF"])?;
                    if self.behind("ELSEIF", &["IF"]).is_ok_and(|at| at < end) {
                        self.next = end;
                        return Err("ELSEIF is not understood: write an IF within ELSE".to_owned());
                    }
                    self.next = otherwise.ok().filter(|at| *at < end).unwrap_or(end);
                    Ok(())
                }
                Err(why) => {
                    let end = self.behind("ENDIF", &["IF"])?;
                    self.leave_open(end, &why.to_string())
                }
            };
        }
        let (condition, action) = action_of(rest).ok_or("IF without an action")?;
        let truth = self.registers.truth(condition).map_err(String::from);
        match truth {
            Ok(false) => Ok(()),
            Ok(true) if starts_with(action, "JMP") || starts_with(action, "CALL") => {
                self.branch(statement, action)
            }
            Ok(true) if action.starts_with('$') => self.system_variable(action, line),
            Ok(true) if SIGNALS.iter().any(|start| action.starts_with(start)) => {
                self.set_signal(action, statement);
                Ok(())
            }
            Ok(true) if action.starts_with("R[") => self.assign(line, action, statement),
            Ok(true) if action.starts_with("PR[") => self.assign_position(line, action),
            Ok(true) | Err(_) if starts_with(action, "PULSE") => {
                self.pulse(line, action);
                Ok(())
            }
            Ok(true) => Err(format!("'{action}' is not understood behind IF")),
            Err(_) if action.starts_with('$') && !action.contains("OVERRIDE") => {
                self.system_variable(action, line)
            }
            Err(why) if self.forget_assigned(line, action, &why) => Ok(()),
            // A signal that is set or not moves nothing.
            Err(why) if is_harmless(action) || ends(action) => {
                self.may_do(statement, action, &why);
                Ok(())
            }
            // Nor does a program that moves nothing.
            Err(why) if starts_with(action, "CALL") && self.moves_nothing(action) => {
                if self.may_do(statement, action, &why) { Ok(()) } else { Err(decides(&why)) }
            }
            Err(why) => match self.label_ahead(action) {
                Some(label) => self.leave_open(label, &why),
                None => Err(decides(&why)),
            },
        }
    }

    /// Where `JMP LBL[1]` goes on, if it passes over something.
    fn label_ahead(&self, action: &str) -> Option<usize> {
        let target = action.get(3..).filter(|_| starts_with(action, "JMP"))?.trim();
        let (number, _) = self.registers.numbered(target, "LBL").ok()??;
        self.source.labels.get(&number)?.first().copied().filter(|at| *at >= self.next)
    }

    /// `SELECT R[1]=1,JMP LBL[1]` with the cases behind it, `=2,CALL x` and `ELSE,JMP LBL[9]`, each
    /// a statement.
    pub(super) fn select(&mut self, statement: &'a Statement) -> Result<(), String> {
        let rest = statement.text.trim().get(6..).unwrap_or("");
        let (subject, first) = split_outside(rest, "=").ok_or("SELECT without '='")?;
        let mut cases = vec![(statement, first)];
        for (index, own) in self.source.statements.iter().enumerate().skip(self.next) {
            let text = own.text.trim();
            match text.strip_prefix('=') {
                Some(case) => cases.push((own, case)),
                None if is_else_of_select(text) => cases.push((own, text)),
                None if text.starts_with(['!', '/']) || text.is_empty() => continue,
                None => break,
            }
            // Cases that are not gone to are passed over, whether or not the register is known.
            self.next = index + 1;
        }
        let at_run_time = |why: String| format!("SELECT decides at run time: {why}");
        let value = self.registers.value(subject).map_err(|why| at_run_time(why.into()))?;
        for (own, case) in cases {
            let (wanted, action) = split_outside(case, ",").ok_or("a case without an action")?;
            let is_value = |own| single::is_same(own, value);
            let is_it = is_else_of_select(case)
                || self
                    .registers
                    .value(wanted)
                    .map_err(String::from)
                    .and_then(is_value)
                    .map_err(at_run_time)?;
            if is_it {
                return self.branch(own, action.trim());
            }
        }
        Ok(())
    }

    /// What a branch does that is taken: JMP or CALL.
    fn branch(&mut self, statement: &Statement, action: &str) -> Result<(), String> {
        let target = action.get(3..).filter(|_| starts_with(action, "JMP"));
        match target {
            Some(target) => self.jump(target.trim(), self.line_of(statement)),
            None if starts_with(action, "CALL") => {
                self.call(action, statement);
                Ok(())
            }
            None => Err(format!("'{action}' is not understood as a branch")),
        }
    }

    /// The statement behind the one that closes what is open here, past nested ones.
    pub(super) fn behind(&self, end: &str, opens: &[&str]) -> Result<usize, String> {
        let mut depth = 0_usize;
        for (index, statement) in self.source.statements.iter().enumerate().skip(self.next) {
            let text = statement.text.trim();
            let word = text.split([' ', '(']).next().unwrap_or("");
            let opens_block = opens.contains(&word) && (word != "IF" || text.ends_with("THEN"));
            if opens_block {
                depth += 1;
            } else if word == end && depth == 0 {
                return Ok(index + 1);
            } else if matches!(word, "ENDIF" | "ENDFOR") && depth > 0 {
                depth -= 1;
            }
        }
        Err(format!("{end} is missing"))
    }

    /// `FOR R[1]=1 TO 3`, or DOWNTO.
    pub(super) fn for_loop(&mut self, text: &str) -> Result<(), String> {
        let rest = text.get(3..).unwrap_or("").trim();
        let (number, rest) = self.registers.numbered(rest, "R")?.ok_or("FOR without R[ ]")?;
        let rest = rest.trim_start().strip_prefix('=').ok_or("expected '='")?;
        let (from, to, step) = match split_outside(rest, "DOWNTO") {
            Some((from, to)) => (from, to, -1.0),
            None => {
                let (from, to) = split_outside(rest, "TO").ok_or("FOR without TO")?;
                (from, to, 1.0)
            }
        };
        let ends = both(self.registers.value(from), self.registers.value(to));
        let (from, to) = match ends {
            Ok(ends) => ends,
            Err(why) => {
                // What stands in it is read once.
                self.registers.set_unread(number, BEHIND_ERROR);
                self.loops.push((self.next, number, f64::NAN, step));
                return Err(why.into());
            }
        };
        self.doubt_limit(rest);
        self.registers.set(number, Ok(from));
        if (to - from) * step < 0.0 {
            self.next = self.behind("ENDFOR", &["FOR"])?;
        } else {
            self.loops.push((self.next, number, to, step));
        }
        Ok(())
    }

    /// A loop that changes its own limit may end by the new one or by that of its beginning.
    fn doubt_limit(&mut self, ends: &str) {
        let limit = ends.rfind("TO").and_then(|at| register(ends.get(at + 2..)?.trim(), "R"));
        let Some((limit, _)) = limit else { return };
        let end = self.behind("ENDFOR", &["FOR"]).unwrap_or(self.next);
        let sets = |own: &&Statement| {
            let set = register(own.text.trim(), "R");
            set.is_some_and(|(own, rest)| own == limit && rest.trim_start().starts_with('='))
        };
        let body = self.source.statements.get(self.next..end).unwrap_or_default();
        if let Some(own) = body.iter().find(sets) {
            let what = format!(
                "R[{limit}] is the limit of the FOR around it: the passes are those of the value \
                 at the FOR"
            );
            self.log.warning(Code::MotionLeftOut, self.line_of(own), what);
        }
    }

    pub(super) fn end_for(&mut self) -> Result<(), String> {
        let Some(&(start, number, to, step)) = self.loops.last() else { return Ok(()) };
        let at = self.registers.value(&format!("R[{number}]")).map(|at| at + step);
        match at {
            Ok(at) if (to - at) * step >= 0.0 => {
                self.registers.set(number, Ok(at));
                self.next = start;
                Ok(())
            }
            at => {
                self.loops.pop();
                at.map(drop).map_err(|why| format!("ENDFOR decides about motion: {why}"))
            }
        }
    }
}

/// `DI[1]=ON,JMP LBL[1]` behind IF: the condition and what is done.
pub(super) fn action_of(rest: &str) -> Option<(&str, &str)> {
    let parts = split_outside(rest, ",").or_else(|| rest.rsplit_once(','));
    parts.map(|(condition, action)| (condition, action.trim()))
}

/// Whether a statement ends the program.
pub(super) fn ends(text: &str) -> bool {
    matches!(text, "END" | "ABORT")
}

/// That a branch which the run decides is not read.
pub(super) fn decides(why: &str) -> String {
    format!("IF decides about motion at run time: {why}")
}

/// Whether a statement may leave a part of the program.
fn leads_out(
    own: &Statement,
    labels: &HashMap<i64, Vec<usize>>,
    part: RangeInclusive<usize>,
) -> bool {
    let text = own.text.trim();
    let Some(behind) = text.find("JMP").and_then(|at| text.get(at..)) else {
        return matches!(text, "END" | "ABORT");
    };
    let target = behind.find("LBL").and_then(|at| register(behind.get(at..)?, "LBL"));
    // A label by a register may be any.
    let at = target.and_then(|(number, _)| labels.get(&number)?.first());
    at.is_none_or(|at| !part.contains(at))
}

/// Whether what follows stands in a branch that statements have begun: another may go on behind it.
fn is_in_branch(statements: &[Statement]) -> bool {
    let mut depth = 0_usize;
    for statement in statements {
        match statement.text.trim() {
            text if starts_with(text, "IF") && text.ends_with("THEN") => depth += 1,
            "ENDIF" => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    depth > 0
}

/// `ELSE,JMP LBL[9]`, the last case of a SELECT; ELSE of an IF stands alone.
fn is_else_of_select(text: &str) -> bool {
    text.strip_prefix("ELSE").is_some_and(|rest| rest.trim_start().starts_with(','))
}
