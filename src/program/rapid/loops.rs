//! FOR and WHILE.

use std::collections::HashSet;

use super::constants::predefined;
use super::interpreter::{Flow, Interpreter};
use super::sets::set_within;
use super::syntax::{Block, Expr, Name, What};
use super::value::Value;
use super::walk::{all_of, calls_in, names_in, statements_in};
use crate::notes::Code;
use crate::program::single;

const ENDLESS: &str =
    "an endless loop: read once, without the move from its end back to its beginning";

fn jumps_out(body: &Block) -> bool {
    let mut inside = statements_in(std::iter::once(body));
    inside.any(|what| matches!(what, What::Return(_) | What::Goto(_)))
}

impl<'a> Interpreter<'a> {
    /// `parts`: from, to, step.
    pub(super) fn for_loop(
        &mut self,
        line: usize,
        variable: &'a Name,
        parts: [Option<&'a Expr>; 3],
        body: &'a Block,
    ) -> Flow {
        self.doubt_shared(line, "FOR", parts.into_iter().flatten().collect(), vec![body]);
        let mut numbers = [None; 3];
        for (number, expr) in numbers.iter_mut().zip(parts) {
            match expr.map(|expr| self.eval(expr).num()) {
                None => {}
                Some(Ok(value)) => *number = Some(value),
                Some(Err(why)) => {
                    let parts = parts.into_iter().flatten().collect();
                    self.undecided(line, "FOR", &why, parts, std::iter::once(body));
                    return Flow::Next;
                }
            }
        }
        let [Some(from), Some(to), step] = numbers else { return Flow::Next };
        let step = step.unwrap_or(if to < from { -1.0 } else { 1.0 });
        if step == 0.0 {
            self.log.error(Code::Value, line, "FOR: STEP is 0");
            return Flow::Next;
        }
        let outer = self.frames.last_mut().and_then(|frame| frame.remove(&variable.key));
        let (mut at, mut single) = (from, from as f32);
        let mut flow = Flow::Next;
        loop {
            let is_behind = if step > 0.0 { at > to } else { at < to };
            // The controller counts with seven digits.
            let is_behind_there = if step > 0.0 { single > to as f32 } else { single < to as f32 };
            if is_behind != is_behind_there {
                let why = single::rounded(to);
                self.undecided(line, "FOR", &why, Vec::new(), std::iter::once(body));
                break;
            }
            if is_behind || !self.another_pass(line) {
                break;
            }
            self.declare(&variable.key, "num", Value::Num(at), true);
            flow = self.block(body);
            if !matches!(flow, Flow::Next) {
                break;
            }
            at += step;
            single += step as f32;
        }
        if let Some(frame) = self.frames.last_mut() {
            frame.remove(&variable.key);
            frame.extend(outer.map(|datum| (variable.key.clone(), datum)));
        }
        flow
    }

    /// Loops with empty bodies end, too.
    fn another_pass(&mut self, line: usize) -> bool {
        match self.budget.checked_sub(1) {
            Some(left) => {
                self.budget = left;
                true
            }
            None => {
                self.log.runs_too_long(line);
                false
            }
        }
    }

    pub(super) fn while_loop(&mut self, line: usize, condition: &'a Expr, body: &'a Block) -> Flow {
        if *condition == Expr::Bool(true) {
            let what = match jumps_out(body) {
                false => ENDLESS,
                true => {
                    "WHILE TRUE, which RETURN or GOTO may leave: read once; what further passes \
                     do, and what stands behind the loop, is not read"
                }
            };
            self.log.warning(Code::MotionLeftOut, line, what);
            return match self.block(body) {
                Flow::Next => Flow::Exit,
                flow => flow,
            };
        }
        self.doubt_shared(line, "WHILE", vec![condition], vec![body]);
        let mut passes = 0;
        loop {
            match self.eval(condition).bool() {
                // It is TRUE for good.
                Ok(true) if passes == 1 && self.is_endless(condition, body) => {
                    self.log.warning(Code::MotionLeftOut, line, ENDLESS);
                    return Flow::Exit;
                }
                Ok(true) if self.another_pass(line) => match self.block(body) {
                    Flow::Next => {
                        passes += 1;
                        self.set_anew.clear();
                    }
                    flow => return flow,
                },
                Ok(_) => return Flow::Next,
                Err(why) => {
                    self.undecided(line, "WHILE", &why, vec![condition], std::iter::once(body));
                    return Flow::Next;
                }
            }
        }
    }

    /// Whether a condition stays as it is: it asks for data of the program alone, which nothing in
    /// the loop or in a trap sets, and no jump leaves the loop.
    fn is_endless(&self, condition: &'a Expr, body: &'a Block) -> bool {
        let ends = |key: &str| matches!(key, "exit" | "exitcycle" | "systemstopaction");
        let calls = all_of(vec![condition]).into_iter().any(|own| matches!(own, Expr::Call(_)));
        let names = names_in(vec![condition]);
        if calls || jumps_out(body) || !names.iter().all(|name| self.is_programs(name)) {
            return false;
        }
        let traps = self.file.traps.iter().map(|trap| &trap.body);
        let all = std::iter::once(body).chain(traps);
        let set: HashSet<&str> = all
            .flat_map(|block| set_within(self.file, block))
            .map(|name| name.key.as_str())
            .collect();
        !names.iter().any(|name| set.contains(name.key.as_str()))
            && !calls_in(self.file, &[body]).iter().any(|(name, _)| ends(&name.key))
    }

    /// Whether nothing but the program sets a datum, and by no other name.
    fn is_programs(&self, name: &Name) -> bool {
        let key = name.key.as_str();
        let frame = self.frames.last();
        if let Some(datum) = frame.and_then(|frame| frame.get(key)) {
            return datum.stands_for.is_none() && datum.signal.is_none();
        }
        let mut local = frame.into_iter().flat_map(|frame| frame.values());
        let has_other_name =
            local.any(|datum| datum.stands_for.as_ref().is_some_and(|(own, _)| *own == key));
        match self.file.data.get(key) {
            Some(data) => !data.is_persistent && !has_other_name,
            None => predefined(key).is_some(),
        }
    }
}
