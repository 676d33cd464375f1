//! What the cell agrees on beside the language: which signal, procedure or comment sets the speed
//! of the spindle or the number of the tool.

use std::collections::HashMap;

use super::interpreter::Interpreter;
use super::syntax::{Args, Expr, Name};
use crate::notes::Code;
use crate::program::{SetBy, Setter, Settings, Spindle, tool_number};

/// What a number sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sets {
    Spindle,
    Tool,
}

/// Numbers in comments, by the line of the instruction that follows.
pub(super) type Comments = HashMap<usize, Vec<(usize, Sets, f64)>>;

fn all(settings: &Settings) -> impl Iterator<Item = (Sets, &SetBy)> {
    let spindle = settings.spindle_from.as_ref().map(|by| (Sets::Spindle, by));
    spindle.into_iter().chain(settings.tool_from.as_ref().map(|by| (Sets::Tool, by)))
}

/// The comments of a program that set something.
pub(super) fn comments(text: &str, settings: &Settings) -> Comments {
    let mut found = Comments::new();
    let mut open = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some(comment) = line.strip_prefix('!') {
            open.extend(all(settings).filter_map(|(sets, by)| {
                let Setter::Comment(start) = &by.what else { return None };
                let value = number(comment.trim_start().strip_prefix(start.as_str())?)?;
                Some((index + 1, sets, value * by.per_unit))
            }));
        } else if !line.is_empty() && !open.is_empty() {
            found.insert(index + 1, std::mem::take(&mut open));
        }
    }
    found
}

/// The number at the start of a text, behind blanks and `=` or `:`.
fn number(text: &str) -> Option<f64> {
    let text = text.trim_start_matches([' ', '\t', '=', ':']);
    let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    text.get(..end)?.parse().ok()
}

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

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_behind_the_start_of_a_comment() {
        for (text, expected) in
            [(" 12000 rpm", Some(12000.0)), ("=800.5;", Some(800.5)), (" off", None), ("", None)]
        {
            assert_eq!(number(text), expected, "{text}");
        }
    }
}
