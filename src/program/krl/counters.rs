//! FOR loops of KRL, and their counters behind them: that these are one step behind the end value
//! no manual of the maker says, so that it is a doubt where it matters.

use super::rests::Rests;
use super::run::{Flow, Run};
use super::syntax::{Block, Expr, Path};
use super::value::{Sort, Value};
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
            self.resting(&key).remove(&key);
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
                self.rests(key, Rests::Counter(name));
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
}
