//! Signals: what the cell agrees on beside the language, which of them (or which procedure or
//! comment) sets the speed of the spindle or the number of the tool, and outputs that the program
//! sets and asks for.

use super::interpreter::Interpreter;
use super::syntax::{Args, Expr, Name, Optional};
use super::value::Value;
use crate::program::cell::{all, set};
use crate::program::{SetBy, Setter};

/// The argument that a call sets something to.
fn value_set<'a>(by: &SetBy, name: &Name, args: &'a Args) -> Option<&'a Expr> {
    match (&by.what, args.positional.as_slice()) {
        (Setter::Signal(signal), [Expr::Ref(path), value, ..])
            if matches!(name.key.as_str(), "setao" | "setgo")
                && path.name.key == signal.to_lowercase() =>
        {
            Some(value)
        }
        (Setter::Procedure(procedure, argument), values)
            if name.key == procedure.to_lowercase() =>
        {
            values.get(argument.checked_sub(1)?)
        }
        _ => None,
    }
}

impl<'a> Interpreter<'a> {
    /// Whether the call sets something; then it is done.
    pub(super) fn sets(&mut self, line: usize, name: &Name, args: &'a Args) -> bool {
        let settings = self.settings;
        let mut done = false;
        for (sets, by) in all(settings) {
            if let Some(value) = value_set(by, name, args) {
                let span = self.literal(value);
                let value = self.eval(value).num();
                set(self.log, line, sets, value, span, by.per_unit);
                done = true;
            }
        }
        done
    }

    /// Keeps what an output is set to; one that an instruction names otherwise is no longer known.
    pub(super) fn set_output(&mut self, key: &str, args: &'a Args) {
        const SETS: [&str; 7] = ["set", "reset", "invertdo", "setdo", "setgo", "setao", "pulsedo"];
        let (true, Some(Expr::Ref(signal))) = (SETS.contains(&key), args.positional.first()) else {
            return self.forget_outputs(args);
        };
        let name = signal.name.key.as_str();
        // Another name of a signal, or one of a trap's: it may be any.
        let is_local = self.frames.last().is_some_and(|frame| frame.contains_key(name));
        if is_local || self.file.data.contains_key(name) || !self.file.traps.is_empty() {
            return self.forget_all_outputs();
        }
        let value = match key {
            "set" => Some(1.0),
            "reset" => Some(0.0),
            "invertdo" => self.outputs.get(name).map(|value| f64::from(u8::from(*value == 0.0))),
            "setdo" | "setgo" | "setao" => {
                let value = args.positional.get(1).map(|expr| self.eval(expr));
                value.and_then(|value| match value {
                    Value::Bool(truth) => Some(f64::from(u8::from(truth))),
                    other => other.num().ok(),
                })
            }
            _ => None,
        };
        match value {
            Some(value) => drop(self.outputs.insert(name.to_owned(), value)),
            None => self.forget_outputs(args),
        }
    }

    /// What a call names may be set by it.
    pub(super) fn forget_outputs(&mut self, args: &Args) {
        let optional = args.optional.iter().filter_map(|(_, value)| match value {
            Optional::Value(expr) => Some(expr),
            _ => None,
        });
        for expr in args.positional.iter().chain(optional) {
            if let Expr::Ref(path) = expr {
                self.forget_name(&path.name.key);
            }
        }
    }

    /// Whether a call would set something.
    pub(super) fn would_set(&self, name: &Name, args: &Args) -> bool {
        all(self.settings).any(|(_, by)| value_set(by, name, args).is_some())
    }
}
