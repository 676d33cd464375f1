//! Moves behind a statement that ends its routine, or the program, in any case.

use std::collections::HashSet;

use super::instructions::{motion, sounds_like_motion};
use super::interpreter::Interpreter;
use super::syntax::{Statement, What};
use super::walk::blocks_in;
use crate::program::unread::behind;

impl<'a> Interpreter<'a> {
    /// Tells of the first move in the rest of a block that ends by such a statement.
    pub(super) fn doubt_behind(&mut self, end: &'a Statement, rest: &'a [Statement]) {
        let end = match &end.what {
            What::Return(_) => "RETURN",
            What::Call(name, _)
                if matches!(name.key.as_str(), "exit" | "exitcycle" | "systemstopaction") =>
            {
                name.shown.as_str()
            }
            _ => return,
        };
        if let Some(first) = rest.iter().find(|statement| self.moves(&statement.what)) {
            behind(self.log, if first.line > 0 { first.line } else { self.line }, end);
        }
    }

    /// Whether a statement, or what it calls in the files, would move if it ran.
    fn moves(&self, what: &'a What) -> bool {
        let mut seen: HashSet<&str> = HashSet::new();
        let mut open = vec![what];
        while let Some(what) = open.pop() {
            let inner = blocks_in(what).into_iter().flatten();
            open.extend(inner.map(|statement| &statement.what));
            let What::Call(name, _) = what else { continue };
            let key = name.key.as_str();
            match self.file.procedures.get(key) {
                Some(routine) if seen.insert(key) => {
                    open.extend(routine.body.iter().map(|statement| &statement.what));
                }
                Some(_) => {}
                None if motion(key).is_some() || sounds_like_motion(key) => return true,
                None => {}
            }
        }
        false
    }
}
