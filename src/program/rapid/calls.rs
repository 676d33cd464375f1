//! Procedures and functions of the files, with what they are given.

use std::collections::HashMap;

use super::interpreter::{Datum, Flow, Interpreter};
use super::syntax::{Args, Expr, Name, Optional, Routine};
use super::value::Value;
use crate::notes::Code;

impl<'a> Interpreter<'a> {
    /// The signal that a call gives, and the line that names it.
    fn signal_given(&self, name: &'a Name) -> (&'a Name, usize) {
        let own = self.frames.last().and_then(|frame| frame.get(&name.key));
        own.and_then(|datum| datum.signal).unwrap_or((name, self.line))
    }

    /// Runs a procedure or function with these arguments.
    pub(super) fn call_routine(&mut self, routine: &'a Routine, args: &'a Args) -> Flow {
        let options = self.options(args);
        let mut given = args.positional.iter();
        let mut frame: HashMap<String, Datum<'a>> = HashMap::new();
        let mut back = Vec::new();
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
        let own = self.file.functions.get(&routine.name.key);
        let own = own.filter(|own| std::ptr::eq(*own, routine));
        let outer = std::mem::replace(&mut self.function, own);
        let flow = match self.block(&routine.body) {
            Flow::Goto(label) => {
                let what = format!("GOTO {label}: no block around it has this label");
                self.log.error(Code::Motion, self.line, what);
                Flow::Exit
            }
            flow => flow,
        };
        self.handlers -= handles;
        self.function = outer;
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
        flow
    }
}
