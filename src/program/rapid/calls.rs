//! Procedures and functions of the files, with what they are given.

use std::collections::{HashMap, HashSet};

use super::constants::predefined;
use super::interpreter::{Datum, Flow, Interpreter};
use super::sets::given_to;
use super::syntax::{Args, Expr, Name, Optional, Parameter, Path, Routine, What};
use super::value::Value;
use super::walk::{expressions_in, names_in, own_names, routines_in, statements_in};
use super::why::FILE;
use crate::notes::Code;

/// Names that are told.
const SHOWN: usize = 4;

impl<'a> Interpreter<'a> {
    /// Calls are in one another deeper than is read.
    pub(super) fn tell_too_deep(&mut self, line: usize) {
        let last = self.running.last();
        let own = last.filter(|last| {
            self.running.iter().filter(|own| std::ptr::eq(**own, **last)).count() > 1
        });
        let Some(own) = own else {
            return self.log.error(Code::TooLong, line, "calls are nested too deep here");
        };
        let mut assumed: Vec<String> = self.heeded.borrow().iter().cloned().collect();
        assumed.sort_unstable();
        assumed.truncate(SHOWN);
        let (under, help) = match assumed.is_empty() {
            true => (String::new(), ""),
            false => {
                let under = format!(" under what assume says of '{}'", assumed.join("', '"));
                (under, "give another value, or ")
            }
        };
        let what = format!(
            "calls are nested too deep here: '{}' calls itself more often than is read{under}; \
             {help}let path.program.procedure in the job name a procedure that does not",
            own.name.shown
        );
        self.log.error(Code::TooLong, line, what);
    }

    /// Why a datum that no file declares is not known where a routine has it for a parameter, too,
    /// and uses it by another name: what is set by one name does not show by the other.
    fn why_two_names(
        &mut self,
        routine: &'a Routine,
        path: &Path,
        is_given_twice: bool,
    ) -> Option<String> {
        let key = path.name.key.as_str();
        let is_elsewhere = !self.is_declared(key) && predefined(key).is_none();
        if !is_elsewhere || !is_given_twice && !self.uses(routine, key) {
            return None;
        }
        let why = format!(
            "'{}' sets '{}' by an argument and uses it by another name, too: {FILE}",
            routine.name.shown, path.name.shown
        );
        self.log.warning(Code::MotionLeftOut, self.line, why.clone());
        Some(why)
    }

    /// Whether a routine, or what it calls, uses a datum that is not its own by this name.
    fn uses(&mut self, routine: &'a Routine, key: &str) -> bool {
        let mut seen: HashSet<&str> = HashSet::from([routine.name.key.as_str()]);
        let mut open = vec![routine];
        let mut is_used = false;
        while let (Some(routine), false) = (open.pop(), is_used) {
            let is_own = own_names(routine).contains(key);
            for what in statements_in(std::iter::once(&routine.body)) {
                let is_set = matches!(what, What::Assign(path, _) if path.name.key == key);
                let asks = || names_in(expressions_in(what)).iter().any(|name| name.key == key);
                is_used |= !is_own && (is_set || asks());
                let called = routines_in(self.file, what).into_iter();
                open.extend(called.filter(|own| seen.insert(&own.name.key)));
            }
        }
        // What may run has to be searched, and costs as much as if it ran.
        self.budget = self.budget.saturating_sub(seen.len());
        is_used
    }

    /// The signal that a call gives, and the line that names it.
    fn signal_given(&self, name: &'a Name) -> (&'a Name, usize) {
        let own = self.frames.last().and_then(|frame| frame.get(&name.key));
        own.and_then(|datum| datum.signal).unwrap_or((name, self.line))
    }

    /// Runs a procedure or function with these arguments.
    pub(super) fn call_routine(&mut self, routine: &'a Routine, args: &'a Args) -> Flow {
        let mut given = args.positional.iter();
        let mut frame: HashMap<String, Datum<'a>> = HashMap::new();
        let mut back: Vec<(&'a Path, &'a str)> = Vec::new();
        // Parameters that the caller has itself as parameters.
        let mut passed: Vec<(&'a Name, &'a str)> = Vec::new();
        let mut lost: Vec<(&'a Path, Value)> = Vec::new();
        for path in by_reference(routine, args) {
            let same = by_reference(routine, args).filter(|own| own.name.key == path.name.key);
            let is_given_twice = same.count() > 1;
            if let Some(why) = self.why_two_names(routine, path, is_given_twice) {
                let value = Value::unknown(why);
                self.forget(&path.name, &value);
                lost.push((path, value));
            }
        }
        let options = self.options(args);
        for parameter in &routine.parameters {
            let mut stands_for = None;
            let is_signal = parameter.kind.starts_with("signal");
            let mut signal = None;
            let value = if parameter.optional {
                let named = options.iter().find(|(name, _)| *name == parameter.name.key);
                let own = args.optional.iter().find(|(name, _)| *name == parameter.name.key);
                match own.filter(|_| parameter.by_reference) {
                    Some((_, Optional::Value(Expr::Ref(path)))) if is_signal => {
                        signal = Some(self.signal_given(&path.name));
                    }
                    Some((_, Optional::Value(Expr::Ref(path)))) => {
                        stands_for = self.of_module(path);
                        if stands_for.is_none() {
                            back.push((&**path, parameter.name.key.as_str()));
                        }
                    }
                    Some((_, Optional::IfPresent(outer))) => {
                        passed.push((outer, &parameter.name.key));
                        let outer = self.frames.last().and_then(|frame| frame.get(&outer.key));
                        stands_for = outer.and_then(|datum| datum.stands_for.clone());
                        signal = outer.and_then(|datum| datum.signal);
                    }
                    _ => {}
                }
                named.map_or(Value::Absent, |(_, value)| value.clone())
            } else {
                match given.next() {
                    Some(expr) => {
                        if let (true, Expr::Ref(path)) = (is_signal, expr) {
                            signal = Some(self.signal_given(&path.name));
                        } else if let (true, Expr::Ref(path)) = (parameter.by_reference, expr) {
                            stands_for = self.of_module(path);
                            if stands_for.is_none() {
                                back.push((&**path, parameter.name.key.as_str()));
                            }
                        }
                        self.eval(expr)
                    }
                    None => Value::unknown(format!(
                        "'{}' is called without its argument '{}'",
                        routine.name.shown, parameter.name.shown
                    )),
                }
            };
            let kind = parameter.kind.as_str();
            let datum = Datum { kind, value, stands_for, signal, is_constant: false };
            frame.insert(parameter.name.key.clone(), datum);
        }
        self.frames.push(frame);
        let handles = usize::from(routine.in_handlers.contains("error"));
        self.handlers += handles;
        self.running.push(routine);
        let flow = match self.block(&routine.body) {
            Flow::Goto { label, line, place } => {
                let what = format!("GOTO {label}: no block around it has this label");
                let outer = self.log.within(place);
                self.log.error(Code::Motion, line, what);
                self.log.within(outer);
                Flow::Exit
            }
            flow => flow,
        };
        self.handlers -= handles;
        self.running.pop();
        let frame = self.frames.pop().unwrap_or_default();
        for (path, key) in back {
            if let Some(datum) = frame.get(key) {
                // Predefined data and those of other modules cannot be written and stay as they
                // are.
                if self.write(path, datum.value.clone()).is_err() {
                    self.assign_elsewhere(path, datum.value.clone());
                }
            }
        }
        for (outer, key) in passed {
            let own = self.frames.last_mut().and_then(|frame| frame.get_mut(&outer.key));
            if let (Some(own), Some(datum)) = (own, frame.get(key)) {
                own.value.clone_from(&datum.value);
            }
        }
        for (path, value) in lost {
            self.forget(&path.name, &value);
        }
        flow
    }
}

/// Data, and parts of them, that a call gives to parameters by which they may be set.
fn by_reference<'a>(routine: &'a Routine, args: &'a Args) -> impl Iterator<Item = &'a Path> {
    let given = given_to(routine, args).into_iter();
    let is_datum = |own: &Parameter| own.by_reference && !own.kind.starts_with("signal");
    given.filter(move |(parameter, _)| is_datum(parameter)).map(|(_, path)| path)
}
