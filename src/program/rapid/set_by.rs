//! What the cell agrees on beside the language: which signal, procedure or comment sets the speed
//! of the spindle or the number of the tool.

use super::comments::{Sets, all};
use super::interpreter::Interpreter;
use super::syntax::{Args, Expr, Name};
use crate::notes::Code;
use crate::program::{SetBy, Setter, Spindle, tool_number};

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
    /// Runs what comments before this instruction set.
    pub(super) fn heed_comments(&mut self, line: usize) {
        for (line, sets, value) in self.comments.get(&line).cloned().unwrap_or_default() {
            self.set(line, sets, Ok(value));
        }
    }

    /// Whether the call sets something; then it is done.
    pub(super) fn sets(&mut self, line: usize, name: &Name, args: &'a Args) -> bool {
        let settings = self.settings;
        let mut done = false;
        for (sets, by) in all(settings) {
            if let Some(value) = value_set(by, name, args) {
                let value = self.eval(value).num().map(|value| value * by.per_unit);
                self.set(line, sets, value);
                done = true;
            }
        }
        done
    }

    /// Whether a call would set something.
    pub(super) fn would_set(&self, name: &Name, args: &Args) -> bool {
        all(self.settings).any(|(_, by)| value_set(by, name, args).is_some())
    }

    fn set(&mut self, line: usize, sets: Sets, value: Result<f64, String>) {
        match (sets, value) {
            (Sets::Spindle, Ok(rpm)) if rpm >= 0.0 => {
                self.log.spindle(line, Spindle::at(Some(rpm)));
            }
            (Sets::Spindle, Ok(rpm)) => {
                let what = format!("the spindle's speed is {rpm} rpm, must not be negative");
                self.log.error(Code::Value, line, what);
            }
            (Sets::Spindle, Err(why)) => {
                let what = format!("the spindle's speed is known only at run time: {why}");
                self.log.warning(Code::SpindleCommand, line, what);
                self.log.spindle(line, Spindle::Turns(None));
            }
            (Sets::Tool, value) => match value.and_then(tool_number) {
                Ok(number) => self.log.tool(number),
                Err(why) => self.log.error(Code::Value, line, format!("tool: {why}")),
            },
        }
    }
}
