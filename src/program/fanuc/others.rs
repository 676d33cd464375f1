//! What others set: programs that are in no file which is read, and whoever a WAIT waits for.

use super::run::Run;
use super::text::Statement;
use super::words::{split_outside, starts_with};
use crate::notes::Code;
use crate::program::cell::{Given, set_by_call};

impl Run<'_> {
    pub(super) fn call(&mut self, text: &str, statement: &Statement) {
        let (line, rest) = (statement.line, text.get(4..).unwrap_or("").trim());
        let (name, args) = match rest.split_once('(') {
            Some((name, args)) => (name.trim(), args.trim_end().trim_end_matches(')')),
            None => (rest, ""),
        };
        let args = args.split(',').map(str::trim).filter(|arg| !arg.is_empty());
        let given: Vec<Given> = args.map(|arg| self.given(arg, statement)).collect();
        if set_by_call(self.settings, self.log, line, &name.to_lowercase(), &given) {
            return;
        }
        self.doubt_name(line, name);
        let what = format!("CALL {name}: not in this file; if it moves, its motion is not read");
        self.log.warning(Code::MotionLeftOut, line, what);
        self.others_set(line, &format!("CALL {name}"));
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
