//! What looks like a command to the spindle by its name, and the job does not read.

use std::collections::HashSet;

use super::instructions::{Motion, ToolAt, is_ignored, motion};
use super::interpreter::Interpreter;
use super::syntax::{Args, Block, Expr, Name, Optional, Path, Routine, Step, What};
use super::timed::SETS;
use super::walk::{PLAIN, functions_of, names_in, statements_in};
use crate::program::spindle_names::{doubt, is_spindles};

/// Parts of tools, frames and places.
const PARTS: [&str; 9] = ["tframe", "tload", "uframe", "oframe", "trans", "rot", "x", "y", "z"];

/// Whether an instruction waits for a signal or watches one: `WaitDI`, `ISignalDO`, `WaitUntil`.
fn reads_signals(key: &str) -> bool {
    let kind = key.strip_prefix("isignal").or_else(|| key.strip_prefix("wait"));
    kind.is_some_and(|kind| matches!(kind, "ai" | "ao" | "di" | "do" | "gi" | "go" | "until"))
}

/// Types of data that are no signals and hold no speed.
const PLACES: [&str; 5] = ["jointtarget", "loaddata", "robtarget", "tooldata", "wobjdata"];

/// What an instruction may command: names among its arguments, in their order.
fn commanded<'a>(key: &str, args: &'a Args) -> Vec<&'a Name> {
    let positional = args.positional.as_slice();
    let own = match motion(key) {
        // What it waits for, or watches, it does not command.
        None if reads_signals(key) => &[],
        Some(Motion { tool: ToolAt::Index(tool), .. }) => {
            positional.get(tool + 1..).unwrap_or_default()
        }
        Some(Motion { tool: ToolAt::Last, .. }) => &[],
        None => positional,
    };
    let outputs = args.optional.iter().filter_map(|(name, value)| match value {
        Optional::Value(expr) if matches!(name.as_str(), "dop" | "gop" | "aop") => Some(expr),
        _ => None,
    });
    // What an instruction works out to show it is given to nothing.
    let is_whole = SETS.contains(&key) || !is_ignored(key);
    let own = own.iter().filter(|expr| is_whole || matches!(expr, Expr::Ref(_)));
    let mut open: Vec<&Expr> = own.chain(outputs).collect();
    open.reverse();
    // A digital input has no speed to be given on.
    let asked = functions_of(open.clone()).into_iter();
    let asked = asked.filter(|(name, _)| matches!(name.key.as_str(), "dinput" | "testdi"));
    let asked = names_in(asked.flat_map(|(_, args)| &args.positional).collect());
    let mut names = names_in(open);
    names.retain(|name| !asked.iter().any(|own| std::ptr::eq(*own, *name)));
    names
}

/// Whether a list is a place, a tool or a frame.
fn is_place(expr: &Expr) -> bool {
    let Expr::List(parts) = expr else { return false };
    let is_number = |part: &Expr| matches!(part, Expr::Number(..) | Expr::Minus(_));
    parts.iter().any(|part| matches!(part, Expr::List(_)))
        || matches!(parts.len(), 3 | 4) && parts.iter().all(is_number)
}

impl<'a> Interpreter<'a> {
    fn doubt(&mut self, line: usize, name: &str) {
        doubt(self.settings, self.log, line, name);
    }

    /// Of an instruction, or a procedure that is in no file; whether it looks like one.
    pub(super) fn doubt_call(&mut self, line: usize, name: &Name, args: &Args) -> bool {
        let names = [name].into_iter().chain(commanded(&name.key, args));
        let mut names = names.map(|name| self.signal_of(name));
        let found = names.find(|name| is_spindles(&name.shown) && !self.is_place(&name.key));
        if let Some(found) = found {
            self.doubt(line, &found.shown);
        }
        found.is_some()
    }

    /// Whether a name is a tool's, a frame's or a target's.
    fn is_place(&self, key: &str) -> bool {
        let local = self.frames.last().and_then(|frame| frame.get(key)).map(|datum| datum.kind);
        let kind = local.or_else(|| self.file.data.get(key).map(|data| data.kind.as_str()));
        kind.is_some_and(|kind| PLACES.contains(&kind))
    }

    /// Of a procedure of the files: where the job reads nothing, and it sets outputs.
    pub(super) fn doubt_procedure(&mut self, line: usize, routine: &'a Routine) {
        let sets_output =
            |what: &What| matches!(what, What::Call(name, _) if SETS.contains(&name.key.as_str()));
        if self.settings.spindle_from.is_none()
            && is_spindles(&routine.name.shown)
            && statements_in(std::iter::once(&routine.body)).any(sets_output)
        {
            self.doubt(line, &routine.name.shown);
        }
    }

    /// Of data that other tasks may read.
    pub(super) fn doubt_assignment(&mut self, line: usize, path: &Path, expr: Option<&Expr>) {
        // A parameter by reference is another name of the caller's datum.
        let local = self.frames.last().and_then(|frame| frame.get(&path.name.key));
        let module = local.and_then(|datum| datum.stands_for.as_ref()).map(|(key, _)| *key);
        let key = module.unwrap_or(&path.name.key);
        let fields = || {
            path.steps.iter().filter_map(|step| match step {
                Step::Field(field) => Some(field.as_str()),
                Step::Index(_) => None,
            })
        };
        let looks_so =
            is_spindles(&path.name.shown) || is_spindles(key) || fields().any(is_spindles);
        if looks_so
            && self.may_reach_others(key)
            && !fields().any(|field| PARTS.contains(&field))
            && !expr.is_some_and(is_place)
            && !self.given_on.contains(key)
        {
            self.doubt(line, &path.name.shown);
        }
    }

    /// Whether a datum is no place or tool, and not the program's own.
    fn may_reach_others(&self, key: &str) -> bool {
        let is_local = self.frames.last().is_some_and(|frame| frame.contains_key(key));
        let is_plain = |kind: &str| PLAIN.contains(&kind) || self.file.records.contains_key(kind);
        !is_local && self.file.data.get(key).is_none_or(|it| it.is_persistent && is_plain(&it.kind))
    }

    /// Of all that blocks may do, and what they call in the files, if they run.
    pub(super) fn doubt_open(&mut self, line: usize, blocks: &[&'a Block]) {
        let mut seen: HashSet<&str> = HashSet::new();
        let mut open = blocks.to_vec();
        while let Some(block) = open.pop() {
            for what in statements_in(std::iter::once(block)) {
                match what {
                    What::Assign(path, expr) => self.doubt_assignment(line, path, Some(expr)),
                    What::Call(name, args) => match self.file.procedures.get(&name.key) {
                        Some(routine) if seen.insert(&name.key) => {
                            self.doubt_procedure(line, routine);
                            open.push(&routine.body);
                        }
                        Some(_) => {}
                        None => {
                            self.doubt_call(line, name, args);
                        }
                    },
                    _ => {}
                }
            }
        }
        // What may run has to be searched, and costs as much as if it ran.
        self.budget = self.budget.saturating_sub(seen.len());
    }
}
