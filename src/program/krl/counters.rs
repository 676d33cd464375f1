//! FOR loops of KRL, and their counters behind them: that these are one step behind the end value
//! no manual of the maker says, so that it is a doubt where it matters.

use std::collections::HashMap;

use super::run::{Flow, Run};
use super::syntax::{Block, Expr, Path, What};
use super::value::{Sort, Value, base};
use super::words::{is_harmless, is_without_effect};
use crate::notes::Code;

impl<'a> Run<'a> {
    pub(super) fn for_loop(
        &mut self,
        line: usize,
        variable: &'a Path,
        parts: [Option<&'a Expr>; 3],
        body: &'a Block,
    ) -> Flow {
        let mut numbers = [None; 3];
        for (number, expr) in numbers.iter_mut().zip(parts) {
            match expr.map(|expr| self.eval(expr).num()) {
                None => {}
                Some(Ok(value)) => *number = Some(value),
                Some(Err(why)) => {
                    const NONE: &Block = &Block::new();
                    self.forget_under(variable, &why);
                    self.undecided(line, "FOR", &why, [body, NONE]);
                    return Flow::Next;
                }
            }
        }
        let [Some(from), Some(to), step] = numbers else { return Flow::Next };
        let step = step.unwrap_or(1.0);
        if step == 0.0 {
            self.log.error(Code::Value, line, "FOR: STEP is 0");
            return Flow::Next;
        }
        let mut at = from;
        while (if step > 0.0 { at <= to } else { at >= to }) && self.another(line) {
            // The counter is an INT.
            let sort = if at.fract() == 0.0 { Sort::Whole } else { Sort::Real };
            let count = Value::Num(at, None, sort);
            let Some(key) = self.key(variable).ok().filter(|_| variable.fields.is_empty()) else {
                self.log.error(Code::Value, line, "FOR: what counts is not a name");
                return Flow::Next;
            };
            self.counted(&key).remove(&key);
            self.store(&key).insert(key.clone(), count.clone());
            match self.block(body) {
                Flow::Next if self.store(&key).get(&key) != Some(&count) => {
                    let what = format!(
                        "FOR: the loop sets {}, which it counts by, and how often it then runs is \
                         not read: use WHILE",
                        variable.name.to_uppercase()
                    );
                    self.log.error(Code::Value, line, what);
                    return Flow::Next;
                }
                Flow::Next => {}
                Flow::Exit => return Flow::Next,
                flow => return flow,
            }
            at += step;
        }
        if let Ok(key) = self.key(variable) {
            let name = variable.name.to_uppercase();
            if at == to + step && at.fract() == 0.0 {
                // A number as a whole cannot fail.
                drop(self.write_at(key.clone(), &[], Value::Num(at, None, Sort::Whole)));
                self.rests(key, name);
                return Flow::Next;
            }
            let why = format!(
                "{name} has counted a FOR loop, and where it ends is read only of whole numbers \
                 whose steps meet the end value: set {name} anew"
            );
            self.store(&key).insert(key, Value::unknown(why));
        }
        Flow::Next
    }

    /// What rests on counters, of the routine that runs or for all, as the datum is.
    pub(super) fn counted(&mut self, key: &str) -> &mut HashMap<String, String> {
        match self.frames.last_mut().filter(|frame| frame.has(key)) {
            Some(frame) => &mut frame.counted,
            None => &mut self.counted,
        }
    }

    /// The statement that runs asks for a datum.
    pub(super) fn asks_for(&mut self, key: &str) {
        if let Some(counter) = self.counted(key).get(key).cloned() {
            self.rests_on = Some(counter);
        }
    }

    /// A datum, and the list that it is an element of, rest on a counter.
    pub(super) fn rests(&mut self, key: String, counter: String) {
        let list = base(&key).to_owned();
        let counted = self.counted(&key);
        counted.insert(list, counter.clone());
        counted.insert(key, counter);
    }

    /// A statement rests on a counter behind its loop: what it sets does so, too, and where it
    /// moves, branches or sets what motion depends on, that is a doubt.
    pub(super) fn tell_counter(&mut self, line: usize, what: &'a What, counter: String) {
        match what {
            What::Assign(path, expr) => {
                let key = self.key(path);
                // Which element it sets may be another, and a function may do anything.
                let is_open = self.rests_on.take().is_some() || self.calls_a_routine(vec![expr]);
                let is_of_motion = path.name.starts_with('$') && !is_without_effect(&path.name);
                if let (Ok(key), false) = (key, is_open || is_of_motion)
                    && !self.is_read_by_job(&key)
                {
                    self.rests(key, counter);
                    return;
                }
            }
            What::Call(name, _)
                if is_harmless(name) && !matches!(name.as_str(), "anout" | "pulse") =>
            {
                return;
            }
            _ => {}
        }
        let what = format!(
            "{counter} has counted a FOR loop, and is taken here as its end value plus one step: \
             set {counter} anew behind the loop"
        );
        self.log.warning(Code::MotionLeftOut, line, what);
    }
}
