//! `main` starts again at its end, with the data of the modules as the cycle has left them.

use std::collections::HashMap;

use super::interpreter::{Flow, Global, Interpreter, budget};
use super::syntax::{Args, Routine};
use super::value::Value;
use crate::motion::Turning;
use crate::notes::Code;
use crate::program::log::Log;

/// Names that are told.
const SHOWN: usize = 4;

impl<'a> Interpreter<'a> {
    /// Runs a second cycle beside the first, of which nothing is kept: where it moves otherwise, or
    /// leaves other data that a third may move by, that is told.
    pub(super) fn doubt_next_cycles(&mut self, start: &'a Routine, args: &'a Args, flow: &Flow) {
        let ends = matches!(flow, Flow::Next | Flow::Return(_));
        if start.name.key != "main" || !ends || !self.log.has_moved() || self.log.has_errors() {
            return;
        }
        self.settle();
        let first = self.changed();
        let has_set = !self.outputs.is_empty()
            || self.over != 1.0
            || self.velocity != (1.0, f64::INFINITY)
            || self.turning != Some(Turning::WithArc)
            || self.gripped != Ok(None)
            || !self.off.is_empty()
            || !self.connected.is_empty();
        if first.is_empty() && !has_set {
            return;
        }
        self.budget = budget(self.file);
        // What the job says holds at its start as at that of the first.
        for key in std::mem::take(&mut self.awaited) {
            self.forgotten.remove(&key);
        }
        self.speeds_of_job.clear();
        self.objects_of_job.clear();
        let log = self.log.beside();
        let of_first = std::mem::replace(&mut *self.log, log);
        self.call_routine(start, args);
        let of_second: Log = std::mem::replace(&mut *self.log, of_first);
        let second = self.changed();
        let moves_alike = self.log.moves_like(&of_second);
        let all = first.keys().chain(second.keys());
        let mut others: Vec<&str> = all
            .filter(|key| !moves_alike || first.get(*key) != second.get(*key))
            .map(|key| self.file.data.get(*key).map_or(*key, |own| own.name.shown.as_str()))
            .collect();
        others.sort_unstable();
        others.dedup();
        if moves_alike && others.is_empty() {
            return;
        }
        let more = others.len().saturating_sub(SHOWN);
        others.truncate(SHOWN);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let kept = match others.is_empty() {
            true => "outputs and settings".to_owned(),
            false => format!("'{}'{more}", others.join("', '")),
        };
        let what = format!(
            "at its end main starts again, with {kept} as they are then: what later cycles do is \
             not read"
        );
        self.log.warning(Code::MotionLeftOut, start.line.max(1), what);
    }

    /// Data of the modules on which motion may depend and which the program has changed.
    fn changed(&mut self) -> HashMap<&'a str, Value> {
        let is_of_motion = |key: &&&'a str| self.of_motion().contains(*key);
        let written: Vec<&'a str> = match self.written.is_empty() {
            true => Vec::new(),
            false => self.written.iter().filter(is_of_motion).copied().collect(),
        };
        let file = self.file;
        let mut changed = HashMap::new();
        for key in written {
            let declared = file.data.get(key).map(|own| self.initial_value(own));
            if let (Some(Global::Known(now)), Some(declared)) = (self.globals.get(key), declared)
                && *now != declared
            {
                changed.insert(key, now.clone());
            }
        }
        // Nothing says what those that no file declares are before.
        let known = self.assigned.iter().filter(|(_, now)| !matches!(now, Value::Unknown(_)));
        let known = known.filter(|(key, _)| self.of_motion().contains(*key));
        changed.extend(known.map(|(key, now)| (*key, now.clone())));
        changed
    }
}
