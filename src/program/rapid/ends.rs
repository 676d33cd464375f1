//! Moves that are not read: behind a statement that ends its routine, or the program, in any case;
//! in procedures that nothing calls, where the one that starts does not move.

use std::collections::HashSet;

use super::instructions::{motion, sounds_like_motion};
use super::interpreter::Interpreter;
use super::syntax::{Block, Routine, Statement, What};
use super::walk::blocks_in;
use crate::notes::Code;
use crate::program::unread::behind;

impl<'a> Interpreter<'a> {
    /// Tells of the first move in the rest of a block that ends by such a statement.
    pub(super) fn doubt_behind(&mut self, end: &'a Statement, rest: &'a [Statement]) {
        let end = match &end.what {
            What::Return(_) => "RETURN",
            What::Goto(_) => "GOTO",
            What::Call(name, _)
                if matches!(name.key.as_str(), "exit" | "exitcycle" | "systemstopaction") =>
            {
                name.shown.as_str()
            }
            _ if self.starts_again => return self.doubt_next_cycle(end, rest),
            _ => return,
        };
        // A label may be jumped to from elsewhere.
        let dead = rest.iter().take_while(|own| !matches!(own.what, What::Label(_)));
        if let Some(first) = dead.into_iter().find(|statement| self.moves(&statement.what)) {
            behind(self.log, if first.line > 0 { first.line } else { self.line }, end);
        }
    }

    /// `main` is often empty, and the path stands in a procedure of its own.
    pub(super) fn tell_who_moves(&mut self, start: &'a Routine) {
        const SHOWN: usize = 10;
        // What was walked without a move needs no second walk.
        let mut still: HashSet<&str> = HashSet::new();
        let mut moves = |body: &'a Block| {
            let mut seen = still.clone();
            let found = body.iter().any(|own| self.moves_beyond(&own.what, &mut seen));
            if !found {
                still = seen;
            }
            found
        };
        if self.log.has_moved() || !self.is_still(&start.body) {
            return;
        }
        let procedures =
            self.file.procedure_order.iter().filter_map(|key| self.file.procedures.get(key));
        let names: Vec<&str> = procedures
            .filter(|routine| moves(&routine.body))
            .map(|routine| routine.name.shown.as_str())
            .take(SHOWN)
            .collect();
        if let Some(first) = names.first() {
            let what = format!(
                "'{}' does not move; these procedures do: '{}'; path.program.procedure: {first} in \
                 the job reads one",
                start.name.shown,
                names.join("', '")
            );
            self.log.error(Code::Motion, start.line.max(1), what);
        }
    }

    /// Whether a statement, or what it calls in the files, would move if it ran.
    pub(super) fn moves(&self, what: &'a What) -> bool {
        self.moves_beyond(what, &mut HashSet::new())
    }

    /// The same, but for the procedures that were seen.
    fn moves_beyond(&self, what: &'a What, seen: &mut HashSet<&'a str>) -> bool {
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
