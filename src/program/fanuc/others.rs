//! What others set: programs that are in no file which is read, and whoever a WAIT waits for.

use std::collections::HashMap;

use super::examine::examine;
use super::position::OffsetCondition;
use super::registers::{Asked, State};
use super::run::Run;
use super::text::{Source, Statement};
use super::words::{split_outside, starts_with};
use crate::notes::Code;
use crate::program::cell::{Given, set_by_call};

/// What of a program waits for the end of one that it calls.
struct Standing<'a> {
    source: &'a Source,
    called_at: Option<usize>,
    next: usize,
    passed: HashMap<usize, State>,
    asked: HashMap<[usize; 2], Option<Vec<Asked>>>,
    loops: Vec<(usize, i64, f64, f64)>,
    offsets: HashMap<&'static str, OffsetCondition>,
    arguments: Option<Vec<Result<f64, String>>>,
}

/// Why what a program sets is not known that runs beside a motion.
const BESIDE: &str = "it is set beside a motion";

impl<'a> Run<'a> {
    /// `CALL A(1, R[2])`: runs a program that is read, unless the job says what the call sets.
    pub(super) fn call(&mut self, text: &str, statement: &Statement) {
        let line = self.line_of(statement);
        let (name, given) = self.called(text, statement);
        if set_by_call(self.settings, self.log, line, &name.to_lowercase(), &given) {
            return;
        }
        match self.programs.named(name) {
            Ok(Some(source)) => {
                let arguments = given.into_iter().map(|given| given.value).collect();
                self.run_called(source, line, arguments);
            }
            Ok(None) => self.tell_unread(line, name),
            Err(why) => self.log.error(Code::Motion, line, why),
        }
    }

    /// The same beside a motion, a little before or behind its end: what it sets is known no
    /// longer.
    pub(super) fn call_beside(&mut self, text: &str, statement: &Statement) {
        let line = self.line_of(statement);
        let (name, given) = self.called(text, statement);
        if set_by_call(self.settings, self.log, line, &name.to_lowercase(), &given) {
            return;
        }
        if self.program_called(text).is_none() {
            self.tell_unread(line, name);
        } else if !(self.moves_nothing(text) && self.may_do(statement, text, BESIDE)) {
            let what = format!("CALL {name} beside a motion: if it moves, its motion is not read");
            self.log.warning(Code::MotionLeftOut, line, what);
            self.others_set(line, &format!("CALL {name}"));
        }
    }

    /// The name and the arguments of a call.
    pub(super) fn called<'t>(&self, text: &'t str, statement: &Statement) -> (&'t str, Vec<Given>) {
        let rest = text.get(4..).unwrap_or("").trim();
        let (name, args) = match rest.split_once('(') {
            Some((name, args)) => (name.trim(), args.trim_end().trim_end_matches(')')),
            None => (rest, ""),
        };
        let args = args.split(',').map(str::trim).filter(|arg| !arg.is_empty());
        (name, args.map(|arg| self.given(arg, statement)).collect())
    }

    fn tell_unread(&mut self, line: usize, name: &str) {
        self.doubt_name(line, name);
        let what = format!(
            "CALL {name}: in no file that is read; if it moves, its motion is not read (name its \
             listing under files)"
        );
        self.log.warning(Code::MotionLeftOut, line, what);
        self.others_set(line, &format!("CALL {name}"));
    }

    /// Runs another program, and goes on behind the call.
    fn run_called(&mut self, source: &'a Source, line: usize, arguments: Vec<Result<f64, String>>) {
        /// A program that calls itself is cut off there.
        const MAX_DEPTH: usize = 30;
        if self.depth >= MAX_DEPTH {
            let what = format!("CALL {}: calls are nested too deep here", source.name);
            self.log.error(Code::TooLong, line, what);
            self.is_over = true;
            return;
        }
        self.within_program(source, line, arguments, Self::statements);
    }

    /// Does something as a program that is called, and goes on as the one that calls it.
    pub(super) fn within_program<T>(
        &mut self,
        source: &'a Source,
        line: usize,
        arguments: Vec<Result<f64, String>>,
        act: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let line = self.called_at.unwrap_or(line);
        let called_at = source.file.as_ref().map(|_| line);
        let place = self.log.place().to_owned();
        let own = source.file.as_ref().map_or_else(String::new, |file| format!("{file}: "));
        self.log.within(own);
        if self.examined.insert(source.index) && source.index > 0 {
            examine(source, |own| called_at.unwrap_or(own), self.settings, self.log);
        }
        // An OFFSET CONDITION holds until its program ends.
        let outer = Standing {
            source: std::mem::replace(&mut self.source, source),
            called_at: std::mem::replace(&mut self.called_at, called_at),
            next: std::mem::take(&mut self.next),
            passed: std::mem::take(&mut self.passed),
            asked: std::mem::take(&mut self.asked),
            loops: std::mem::take(&mut self.loops),
            offsets: std::mem::take(&mut self.offsets),
            arguments: self.registers.replace_arguments(Some(arguments)),
        };
        self.depth += 1;
        let done = act(self);
        self.depth -= 1;
        (self.source, self.called_at, self.next) = (outer.source, outer.called_at, outer.next);
        (self.passed, self.asked, self.loops) = (outer.passed, outer.asked, outer.loops);
        self.offsets = outer.offsets;
        self.registers.replace_arguments(outer.arguments);
        self.log.within(place);
        done
    }

    /// `RUN B`: runs beside the program from here on.
    pub(super) fn run_beside(&mut self, text: &str, line: usize) {
        let name = text.get(3..).unwrap_or("").trim();
        let what = format!(
            "RUN {name}: starts a program that is not in this file; if it moves, its motion is \
             not read, nor is what it sets from here on, at any time"
        );
        self.log.warning(Code::MotionLeftOut, line, what);
        self.others_set(line, &format!("RUN {name}"));
    }

    /// What a program that is not read may set: the job's word counts, and all else is taken as
    /// this program has left it, which is a doubt.
    fn others_set(&mut self, line: usize, who: &str) {
        const SHOWN: usize = 4;
        let who = format!("{who} of line {line}, which is not in this file,");
        self.registers.may_be_set_by(&who);
        let mut names = self.registers.left_to_the_job(&format!("{who} may set it"));
        names.extend(self.frames.keys().map(|(list, number)| format!("{list}[{number}]")));
        let more = names.len().saturating_sub(SHOWN);
        names.truncate(SHOWN);
        if !names.is_empty() {
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            let what = format!(
                "{who} may set {}{more}, and what this program has left there is taken; assume: in \
                 the job can say what is there behind it",
                names.join(", ")
            );
            self.log.warning(Code::ChangeIgnored, line, what);
        }
        self.chosen_by = [Some(who.clone()), Some(who)];
        self.config = None;
    }

    /// Tells of registers and outputs that the job's word has served for on both sides of what may
    /// set them.
    pub(super) fn tell_served_twice(&mut self, statement: &Statement) {
        for (name, who) in self.registers.served_twice() {
            let what = format!(
                "{who} may set {name}, and what the job assumes of it is taken before and behind"
            );
            self.log.warning(Code::ChangeIgnored, self.line_of(statement), what);
        }
    }

    /// The time of a WAIT with its unit in seconds; `None` where it waits for a condition.
    pub(super) fn time_of(rest: &str) -> Option<(&str, f64)> {
        const UNITS: [(&str, f64); 4] =
            [("(msec)", 1e-3), ("msec", 1e-3), ("(sec)", 1.0), ("sec", 1.0)];
        let stated =
            UNITS.into_iter().find_map(|(unit, s)| Some((rest.strip_suffix(unit)?.trim(), s)));
        // A register alone is a time, too.
        let is_register = ["R", "AR"].iter().any(|list| starts_with(rest, &format!("{list}[")))
            && !rest.contains(['=', '<', '>']);
        stated.or(is_register.then_some((rest, 1.0)))
    }

    pub(super) fn wait(&mut self, text: &str, line: usize) {
        let rest = text.get(4..).unwrap_or("").trim();
        let seconds = match Self::time_of(rest) {
            Some((time, unit)) => self.registers.value(time).map(|time| time * unit),
            None if rest.parse::<f64>().is_ok() => Err(format!("{rest} has no unit").into()),
            None => return self.wait_for(rest, line),
        };
        match seconds {
            Ok(seconds) => self.log.dwell(line, seconds),
            Err(why) => {
                let what = format!("WAIT: {why}; the time is left out");
                self.log.warning(Code::LeftOut, line, what);
            }
        }
    }

    /// For a signal or a register: how long is known only at run time. One that the program itself
    /// has set otherwise is set by somebody else; `TIMEOUT,LBL[1]` goes elsewhere when it does not
    /// come.
    fn wait_for(&mut self, rest: &str, line: usize) {
        let (condition, label) = awaited(rest);
        if self.registers.truth(condition) == Ok(true) {
            return;
        }
        let by = format!("another may set it while WAIT of line {line} waits");
        self.registers.lose_awaited(condition, &by);
        match label {
            Some(label) => self.doubt_timeout(condition, label, line),
            None => self.registers.set_awaited(condition),
        }
    }

    pub(super) fn doubt_timeout(&mut self, condition: &str, label: &str, line: usize) {
        let what = format!(
            "WAIT {condition}: when that does not come in time, the program goes on at {label}, \
             which is not read"
        );
        self.log.warning(Code::MotionLeftOut, line, what);
    }
}

/// What a WAIT waits for, and the label of its TIMEOUT.
pub(super) fn awaited(rest: &str) -> (&str, Option<&str>) {
    let (condition, label) = match split_outside(rest, "TIMEOUT") {
        Some((condition, label)) => (condition, Some(label.trim_matches([',', ' ']))),
        None => (rest, None),
    };
    (condition.trim().trim_end_matches(','), label)
}
