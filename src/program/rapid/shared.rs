//! What others decide: persistent data that no file sets, and what the next cycle finds.

use super::interpreter::Interpreter;
use super::syntax::{Block, Expr, Statement, What};
use super::walk::{blocks_in, names_in, statements_in};
use crate::notes::Code;

impl<'a> Interpreter<'a> {
    /// Of branches of which some move and some do not as data decide that only others set.
    pub(super) fn doubt_shared(
        &mut self,
        line: usize,
        keyword: &str,
        conditions: Vec<&'a Expr>,
        blocks: Vec<&'a Block>,
    ) {
        // A loop asks often.
        let place = conditions.first().map(|first| std::ptr::from_ref(*first));
        if place.is_none_or(|place| !self.asked_of_others.insert(place)) {
            return;
        }
        let mut names = names_in(conditions).into_iter();
        let others = names.find(|name| {
            self.set_by_others.contains(name.key.as_str())
                && !self.frames.last().is_some_and(|frame| frame.contains_key(&name.key))
                && self.assumed(&name.key).is_none()
        });
        let Some(name) = others.filter(|_| !blocks.iter().all(|block| self.is_still(block))) else {
            return;
        };
        let (shown, key) = (&name.shown, &name.key);
        let what = format!(
            "{keyword} asks for '{shown}', which is PERS and which no file that is read sets: the \
             value of its declaration decides which moves are read; assume: {{{key}: …}} in the \
             job can settle it"
        );
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    /// `ExitCycle` in a branch runs `main` again with the data of the modules as they are: another
    /// branch may run then, or what stands behind it.
    pub(super) fn doubt_next_cycle(&mut self, end: &'a Statement, rest: &'a [Statement]) {
        let is_exit = |what: &What| matches!(what, What::Call(name, _) if name.key == "exitcycle");
        let other = |block: &&'a Block| !statements_in(std::iter::once(*block)).any(is_exit);
        let branches = match &end.what {
            What::If(..) | What::Test(..) => blocks_in(&end.what),
            _ => Vec::new(),
        };
        let others = branches.into_iter().filter(other).flatten();
        let first = others.chain(rest).find(|statement| self.moves(&statement.what));
        if let Some(first) = first {
            let line = if first.line > 0 { first.line } else { self.line };
            let what = "ExitCycle starts the program again before this: what the next cycle does \
                        is not read";
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }
}
