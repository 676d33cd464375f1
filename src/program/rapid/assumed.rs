//! What the job assumes: of which data, and for how long.

use std::collections::HashSet;

use super::effect::Effect;
use super::interpreter::{Filled, Interpreter};
use super::shared::acts;
use super::syntax::{Block, Expr, Name, Operator, Routine, What};
use super::value::Value;
use super::walk::{
    blocks_in, blocks_within, expressions_in, functions_of, names_in, statements_in,
};
use super::why::COPY;
use crate::notes::Code;

impl<'a> Interpreter<'a> {
    /// Data of one name in several routines, of which the job can assume one thing alone.
    pub(super) fn doubt_namesake(&mut self, name: &'a Name) {
        let key = name.key.as_str();
        let datum = self.frames.last().and_then(|frame| frame.get(key));
        let of_module = match datum {
            Some(datum) => datum.stands_for.as_ref().map(|(module, _)| *module),
            None => Some(key),
        };
        let own = self.running.last().copied().filter(|_| datum.is_some());
        let routine = own.map(|own| own.name.shown.as_str());
        let before = self.filled_in.get(key).map_or(&[][..], Vec::as_slice);
        let is_it = |it: &Filled| (it.routine, it.of_module) == (routine, of_module);
        if before.iter().any(is_it) {
            return;
        }
        let decides = own.is_none_or(|own| self.decides_in(own, key));
        let is_other = |it: &&Filled| {
            it.decides
                && it.routine != routine
                && (of_module.is_none() || it.of_module != of_module)
        };
        if let Some(other) = before.iter().find(is_other).filter(|_| decides) {
            let shown = |routine: Option<&str>| match routine {
                Some(routine) => format!("'{}' of '{routine}'", name.shown),
                None => format!("'{}'", name.shown),
            };
            let what = format!(
                "{} and {} are two data, and assume gives both the same: give one of them another \
                 name in a copy of the program",
                shown(other.routine),
                shown(routine)
            );
            self.log.warning(Code::MotionLeftOut, self.line, what);
        }
        let filled = Filled { routine, of_module, decides };
        self.filled_in.entry(key).or_default().push(filled);
    }

    /// Whether a routine does more with a datum of its own than show it, or stop by it.
    fn decides_in(&self, routine: &'a Routine, key: &str) -> bool {
        let is_still = |block: &'a Block| match self.effect(block, false, &mut HashSet::new()) {
            Effect::Data(set) => set.is_empty(),
            Effect::Motion => false,
        };
        let decides = |what: &'a What| match what {
            What::Call(name, _) => acts(&name.key),
            What::If(..) | What::Test(..) => !blocks_in(what).into_iter().all(is_still),
            _ => true,
        };
        let asks = |what: &'a What| names_in(expressions_in(what)).iter().any(|own| own.key == key);
        let mut given = routine.parameters.iter();
        given.any(|own| own.by_reference && own.name.key == key)
            || statements_in(std::iter::once(&routine.body)).any(|what| asks(what) && decides(what))
    }

    /// What the job assumes, and the program has waited for otherwise: each side of AND has come
    /// to hold.
    pub(super) fn lose_awaited(&mut self, condition: &'a Expr) {
        match condition {
            Expr::Binary(Operator::And, left, right) => {
                self.lose_awaited(left);
                self.lose_awaited(right);
            }
            _ if self.assumed_in(condition).is_empty() => {}
            // What its NOT is over changes what it waits for.
            Expr::TwoWays(_) if self.eval(condition).bool() != Ok(true) => {
                self.lose_assumed(condition);
            }
            _ if self.eval(condition).bool() == Ok(false) => self.lose_assumed(condition),
            _ => {}
        }
    }

    /// Names that an expression, or the functions of the files that it calls, ask for and of which
    /// the job assumes something.
    fn assumed_in(&self, expr: &'a Expr) -> Vec<&'a Name> {
        let file = self.file;
        let calls = functions_of(vec![expr]);
        let own = calls.iter().filter_map(|(name, _)| file.functions.get(&name.key));
        let bodies: Vec<&'a Block> = own.map(|routine| &routine.body).collect();
        let inside = statements_in(blocks_within(file, &bodies).into_iter());
        let mut open: Vec<&'a Expr> = inside.flat_map(expressions_in).collect();
        open.push(expr);
        let called = functions_of(open.clone()).into_iter().map(|(name, _)| name);
        let mut names: Vec<&'a Name> = called.chain(names_in(open)).collect();
        names.retain(|name| self.settings.assume.contains_key(&self.signal_of(name).key));
        names
    }

    pub(super) fn lose_assumed(&mut self, condition: &'a Expr) {
        for name in self.assumed_in(condition) {
            let key = name.key.as_str();
            if !self.is_declared(key) && !self.assigned.contains_key(key) {
                let signal = self.signal_of(name).key.clone();
                let is_first = !self.forgotten.contains(&signal);
                self.forget_name(key);
                if is_first {
                    self.awaited.insert(signal);
                }
            } else if self.file.data.get(key).is_none_or(|own| !own.is_constant) {
                let what = format!(
                    "'{}': WaitUntil waits for another value than the job assumes; {COPY}",
                    name.shown
                );
                let value = Value::unknown(what);
                self.forget(name, &value);
                // Of what a trap sets that stands for its own value.
                if let Some(trapped) = self.trapped.get_mut(key) {
                    *trapped = value;
                }
            }
        }
    }
}
