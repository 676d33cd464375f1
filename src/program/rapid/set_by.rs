//! Signals: what the cell agrees on beside the language, which of them (or which procedure or
//! comment) sets the speed of the spindle or the number of the tool.

use super::interpreter::Interpreter;
use super::syntax::{Args, Expr, Name};
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

    /// Whether a call would set something.
    pub(super) fn would_set(&self, name: &Name, args: &Args) -> bool {
        all(self.settings).any(|(_, by)| value_set(by, name, args).is_some())
    }
}
