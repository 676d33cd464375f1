//! FOR and WHILE.

use std::collections::HashSet;

use super::constants::predefined;
use super::filled::filled;
use super::interpreter::{Flow, Interpreter};
use super::number::{Count, Number};
use super::outputs::references;
use super::sets::{CHANGE, set_within};
use super::syntax::{Block, Expr, Name, What};
use super::timed::SETS;
use super::traps::calls;
use super::value::Value;
use super::walk::{
    all_of, blocks_in, blocks_within, calls_in, expressions_in, functions_of, names_in,
    statements_in,
};
use super::why::COPY;
use crate::notes::Code;

const ENDLESS: &str =
    "an endless loop: read once, without the move from its end back to its beginning";

const STILL: &str = "an endless loop without a move: what stands behind it is never reached, or \
                     only where something that is not read ends the loop";

/// Statements of a `WHILE TRUE` that are read until a pass leaves it, and of another WHILE until it
/// may count as endless.
const MAX_STATEMENTS: usize = 100_000;

/// Passes of a WHILE before it may count as endless: those that end by themselves rarely have more,
/// and to look what each may change would take longer than to run it.
const MANY_PASSES: usize = 1000;

fn jumps_out(body: &Block) -> bool {
    let mut inside = statements_in(std::iter::once(body));
    inside.any(|what| matches!(what, What::Return(_) | What::Goto(_)))
}

/// The datum that a statement sets: assigned or counted.
fn set_by(what: &What) -> Option<&str> {
    match what {
        What::Assign(path, _) => Some(&path.name.key),
        What::Call(name, args) if CHANGE.contains(&name.key.as_str()) => {
            names_in(args.positional.iter().take(1).collect()).first().map(|own| own.key.as_str())
        }
        _ => None,
    }
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
        let mut numbers: [Option<Number>; 3] = [None; 3];
        for (number, expr) in numbers.iter_mut().zip(parts) {
            match expr.map(|expr| self.eval(expr).number()) {
                None => {}
                Some(Ok(value)) => *number = Some(value),
                Some(Err(why)) => {
                    let parts = parts.into_iter().flatten().collect();
                    return self.undecided(line, "FOR", &why, parts, std::iter::once(body));
                }
            }
        }
        let [Some(from), Some(to), step] = numbers else { return Flow::Next };
        let Some(mut count) = Count::new(from, to, step) else {
            self.log.error(Code::Value, line, "FOR: STEP is 0");
            return Flow::Next;
        };
        let outer = self.frames.last_mut().and_then(|frame| frame.remove(&variable.key));
        let mut flow = Flow::Next;
        loop {
            match count.is_behind() {
                Ok(false) if self.another_pass(line) => {}
                Ok(false) => {
                    flow = Flow::Exit;
                    break;
                }
                Ok(true) => break,
                Err(why) => {
                    let body = std::iter::once(body);
                    flow = self.undecided(line, "FOR", &why, Vec::new(), body);
                    break;
                }
            }
            self.declare(&variable.key, "num", Value::Num(count.now()), true);
            flow = self.block(body);
            if !matches!(flow, Flow::Next) {
                break;
            }
            count.advance();
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
                self.runs_too_long(line);
                false
            }
        }
    }

    pub(super) fn while_loop(&mut self, line: usize, condition: &'a Expr, body: &'a Block) -> Flow {
        if *condition == Expr::Bool(true) {
            return match self.deciding(body) {
                Some(deciding) => self.until_left(line, &deciding, body),
                None => self.once(line, body),
            };
        }
        self.doubt_shared(line, "WHILE", vec![condition], vec![body]);
        let mut first = Some(self.eval(condition));
        if first == Some(Value::Bool(true))
            && let Some(name) = self.ended_by_others(condition, body)
        {
            let what = format!(
                "WHILE asks for '{}', which the loop does not set: it is read once, with what \
                 stands behind it; how often it runs others decide",
                name.shown
            );
            self.log.warning(Code::MotionLeftOut, line, what);
            let flow = self.block(body);
            self.set_anew.clear();
            return flow;
        }
        let least = self.budget.saturating_sub(MAX_STATEMENTS);
        let (mut passes, mut watched, mut before) = (0, 0, String::new());
        loop {
            let value = first.take().unwrap_or_else(|| self.eval(condition));
            match value.bool() {
                Ok(true)
                    if passes == 1
                        && self.only_waits(condition, body)
                        && self.waits_for_late(line, "WHILE", condition) => {}
                // It is TRUE for good.
                Ok(true) if passes == 1 && self.is_endless(condition, body) => {
                    let what = self.endless(body);
                    self.log.warning(Code::MotionLeftOut, line, what);
                    return Flow::Exit;
                }
                Ok(true) if passes == 1 && self.waits_for_others(condition, body) => {
                    return Flow::Next;
                }
                Ok(true) if self.is_stuck(watched, &mut before, condition, body) => {
                    self.doubt_stuck(line, body);
                    return Flow::Exit;
                }
                Ok(true) if self.another_pass(line) => match self.block(body) {
                    Flow::Next => {
                        passes += 1;
                        if passes >= MANY_PASSES || self.budget <= least {
                            watched += 1;
                        }
                        self.set_anew.clear();
                    }
                    flow => return flow,
                },
                Ok(true) => return Flow::Exit,
                Ok(false) => return Flow::Next,
                Err(why) => {
                    let body = std::iter::once(body);
                    return self.undecided(line, "WHILE", &why, vec![condition], body);
                }
            }
        }
    }

    /// What a loop that moves asks for and neither sets nor leaves by a jump: what the job alone
    /// settles, or data of all tasks. The condition is TRUE; the loop ends when that changes.
    fn ended_by_others(&mut self, condition: &'a Expr, body: &'a Block) -> Option<&'a Name> {
        let mut functions = functions_of(vec![condition]).into_iter().map(|(name, _)| name);
        let names = names_in(vec![condition]);
        let asked = names.iter().copied().chain(functions.clone());
        let of_job: Vec<&'a Name> = asked.filter(|name| self.is_of_job(name)).collect();
        let shared = names.iter().copied().find(|name| self.is_shared(&name.key));
        if of_job.is_empty() && shared.is_none()
            || functions.any(|name| self.file.functions.contains_key(&name.key))
            || self.may_leave(body)
            || !body.iter().any(|own| self.moves(&own.what))
        {
            return None;
        }
        let (set, calls) = (set_within(self.file, body), calls_in(self.file, &[body]));
        let is_set = |name: &Name| {
            let key = self.signal_of(name).key.as_str();
            set.iter().any(|own| own.key == name.key)
                || calls.iter().any(|(_, args)| references(args).any(|own| own == key))
        };
        if names.iter().any(|name| is_set(name)) {
            return None;
        }
        let keys: Vec<String> =
            of_job.iter().map(|name| self.signal_of(name).key.clone()).collect();
        let mut calls = functions_of(vec![condition]).into_iter();
        // A function that sets data runs once.
        let sets = calls.any(|(name, args)| !filled(name, args).is_empty());
        let known = self.forgotten.clone();
        self.forgotten.extend(keys);
        let is_by_job = sets || self.eval(condition).bool().is_err();
        self.forgotten = known;
        of_job.first().copied().filter(|_| is_by_job).or(shared)
    }

    /// Whether the job says what is called so, and no file.
    fn is_of_job(&self, name: &Name) -> bool {
        let key = self.signal_of(name).key.as_str();
        let is_said = self.settings.assume.contains_key(key) && !self.forgotten.contains(key);
        let has_own = self.outputs.contains_key(key) || self.file.data.contains_key(key);
        is_said && !has_own && !self.is_local(key)
    }

    /// Whether others set a datum of the module at any time, or may, as no file declares it.
    fn is_shared(&self, key: &str) -> bool {
        let is_open = match self.file.data.get(key) {
            Some(data) => data.is_persistent || self.trapped.contains_key(key),
            None => self.assigned.contains_key(key),
        };
        is_open && !self.is_local(key)
    }

    pub(super) fn is_local(&self, key: &str) -> bool {
        self.frames.last().is_some_and(|frame| frame.contains_key(key))
    }

    /// Whether a loop neither moves nor sets what it asks for.
    fn only_waits(&self, condition: &'a Expr, body: &'a Block) -> bool {
        let set = set_within(self.file, body);
        let is_set = |name: &Name| set.iter().any(|own| own.key == name.key);
        !body.iter().any(|own| self.moves(&own.what))
            && !names_in(vec![condition]).into_iter().any(is_set)
    }

    /// Whether a condition asks a function of the program, which may set data.
    pub(super) fn asks_own_function(&self, condition: &'a Expr) -> bool {
        let mut functions = functions_of(vec![condition]).into_iter();
        functions.any(|(name, _)| self.file.functions.contains_key(&name.key))
    }

    /// Whether a loop waits for what others set, and neither sets what it asks for nor leaves by a
    /// jump. Behind it that is as behind `WaitUntil`; what the loop sets is not known.
    fn waits_for_others(&mut self, condition: &'a Expr, body: &'a Block) -> bool {
        let file = self.file;
        let calls = calls_in(file, &[body]);
        if !self.only_waits(condition, body)
            || self.may_leave(body)
            || self.asks_own_function(condition)
            || calls.iter().any(|(name, _)| SETS.contains(&name.key.as_str()))
        {
            return false;
        }
        let is_of_tasks = |name: &Name| {
            let is_open = match file.data.get(&name.key) {
                Some(data) => data.is_of_tasks(),
                None => self.assigned.contains_key(name.key.as_str()),
            };
            is_open && !self.is_local(&name.key)
        };
        let mut others = names_in(vec![condition]);
        others.retain(|name| is_of_tasks(name) || self.is_of_job(name));
        // What the job says may be what keeps the loop.
        for heeds_job in [true, false] {
            for name in others.iter().copied() {
                self.set_while(name, "WHILE", heeds_job);
            }
            if self.eval(condition).bool() != Ok(true) {
                for name in set_within(file, body) {
                    let what = format!("'{}' is set in a loop that others end: {COPY}", name.shown);
                    self.forget(name, &Value::unknown(what));
                }
                return true;
            }
        }
        false
    }

    /// Whether a loop has come to go on without end: the third pass of those watched, before which
    /// the condition was as before, has moved nothing and changed nothing that another would go by.
    fn is_stuck(
        &mut self,
        watched: usize,
        before: &mut String,
        condition: &'a Expr,
        body: &'a Block,
    ) -> bool {
        if self.asks_own_function(condition) {
            return false;
        }
        let now = match watched {
            1 => self.values_of(names_in(vec![condition])),
            2 if *before == self.values_of(names_in(vec![condition])) => self.situation(body),
            3 if !before.is_empty() => self.situation(body),
            _ => String::new(),
        };
        let is_stuck = watched == 3 && !now.is_empty() && now == *before;
        *before = now;
        is_stuck
    }

    /// What a loop may change.
    fn situation(&mut self, body: &'a Block) -> String {
        let blocks = blocks_within(self.file, &[body]);
        // Their search costs what running them does.
        let count = statements_in(blocks.iter().copied()).count();
        self.budget = self.budget.saturating_sub(count);
        let mut names = set_within(self.file, body);
        let waits = |what: &&'a What| matches!(what, What::Call(own, _) if own.key == "waituntil");
        let waits = statements_in(blocks.into_iter()).filter(waits);
        names.extend(waits.flat_map(|what| names_in(expressions_in(what))));
        let values = self.values_of(names);
        format!("{} {} {:?} {values}", self.motions, self.forgotten.len(), self.outputs)
    }

    /// What data are, known or not.
    fn values_of(&mut self, mut names: Vec<&'a Name>) -> String {
        names.sort_unstable_by_key(|name| &name.key);
        names.dedup_by_key(|name| &name.key);
        let mut shown = String::new();
        for key in names.into_iter().map(|name| name.key.as_str()) {
            let value = self.parameter(key).or_else(|| self.datum_now(key));
            self.budget = self.budget.saturating_sub(value.as_ref().map_or(0, Value::size));
            let value = format!("{value:?};");
            shown.push_str(&value);
        }
        shown
    }

    fn doubt_stuck(&mut self, line: usize, body: &'a Block) {
        let file = self.file;
        let reads = |what: &'a What| match what {
            What::Call(name, _) => file
                .procedures
                .get(&name.key)
                .filter(|own| own.parameters.iter().all(|own| own.optional) && self.moves(what)),
            _ => None,
        };
        let hint = statements_in(std::iter::once(body)).find_map(reads).map(|own| {
            format!("; path.program.procedure: {0} in the job reads '{0}' alone", own.name.shown)
        });
        let what = format!(
            "WHILE goes on without end, as no pass changes what it asks for: what another task, an \
             operator or a trap would start in it, and what stands behind it, is not read{}",
            hint.unwrap_or_default()
        );
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    /// What an endless loop is told as.
    fn endless(&self, body: &'a Block) -> &'static str {
        let moves = body.iter().any(|own| self.moves(&own.what));
        if moves { ENDLESS } else { STILL }
    }

    /// One pass of `WHILE TRUE`.
    fn once(&mut self, line: usize, body: &'a Block) -> Flow {
        if jumps_out(body) {
            self.doubt_further_passes(line, 1);
        } else {
            let what = self.endless(body);
            self.log.warning(Code::MotionLeftOut, line, what);
        }
        match self.block(body) {
            Flow::Next => Flow::Exit,
            flow => flow,
        }
    }

    fn doubt_further_passes(&mut self, line: usize, passes: usize) {
        let read = if passes == 1 { "once".to_owned() } else { format!("{passes} times") };
        let what = format!(
            "WHILE TRUE, which RETURN, GOTO or EXIT may leave: read {read}; what further passes \
             do, and what stands behind the loop, is not read"
        );
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    /// Passes of `WHILE TRUE` until one leaves it, or what decides about that is as it was before
    /// an earlier one, or is not known.
    fn until_left(&mut self, line: usize, deciding: &HashSet<&'a str>, body: &'a Block) -> Flow {
        let least = self.budget.saturating_sub(MAX_STATEMENTS);
        let mut seen: HashSet<String> = HashSet::new();
        let mut passes = 0;
        loop {
            let is_new = self.state(deciding).is_some_and(|state| seen.insert(state));
            if passes > 0 && (!is_new || self.budget <= least) {
                self.doubt_further_passes(line, passes);
                return Flow::Exit;
            }
            if !self.another_pass(line) {
                return Flow::Exit;
            }
            match self.block(body) {
                Flow::Next => passes += 1,
                flow => return flow,
            }
            self.set_anew.clear();
        }
    }

    /// The data that decide whether a jump leaves a loop, with those by which the loop sets them;
    /// `None` where no jump does, or the program alone does not decide.
    fn deciding(&self, body: &'a Block) -> Option<HashSet<&'a str>> {
        let inside = || statements_in(std::iter::once(body));
        let labels: HashSet<&str> = inside()
            .filter_map(|what| match what {
                What::Label(name) => Some(name.key.as_str()),
                _ => None,
            })
            .collect();
        let jumps = |what: &'a What| match what {
            What::Return(_) => true,
            What::Goto(label) => !labels.contains(label.key.as_str()),
            _ => false,
        };
        // What ends the program counts where nothing else ends the loop.
        let has_jump = inside().any(jumps);
        let leaves = |what: &'a What| match has_jump {
            true => jumps(what),
            false => calls(what, &["exit", "systemstopaction"]),
        };
        let holds = |what: &'a What, is_it: &dyn Fn(&'a What) -> bool| {
            statements_in(blocks_in(what).into_iter()).any(is_it)
        };
        if !inside().any(leaves) {
            return None;
        }
        let mut asked: Vec<&'a Name> = Vec::new();
        for what in inside() {
            if holds(what, &leaves) {
                let conditions = expressions_in(what);
                if all_of(conditions.clone()).iter().any(|own| matches!(own, Expr::Call(_))) {
                    return None;
                }
                asked.extend(names_in(conditions));
            }
        }
        if !asked.iter().all(|name| self.is_programs(name)) {
            return None;
        }
        let mut found: HashSet<&'a str> = asked.iter().map(|name| name.key.as_str()).collect();
        let blocks = blocks_within(self.file, &[body]);
        loop {
            let before = found.len();
            for what in statements_in(blocks.clone().into_iter()) {
                let sets = |what: &'a What| set_by(what).is_some_and(|key| found.contains(key));
                if sets(what) || holds(what, &sets) {
                    let used = names_in(expressions_in(what)).into_iter();
                    let used: Vec<&'a str> = used.map(|name| name.key.as_str()).collect();
                    found.extend(used);
                }
            }
            if found.len() == before {
                return Some(found);
            }
        }
    }

    /// What these data are, if they are known.
    fn state(&mut self, names: &HashSet<&'a str>) -> Option<String> {
        let mut names: Vec<&'a str> = names.iter().copied().collect();
        names.sort_unstable();
        let mut state = String::new();
        for key in names {
            let local = self.frames.last().and_then(|frame| frame.get(key));
            let value = match (local, self.file.data.get(key)) {
                (Some(datum), _) if datum.is_constant => continue,
                (Some(datum), _) => Some(datum.value.clone()),
                (None, Some(data)) if data.is_constant => continue,
                (None, Some(_)) if self.trapped.contains_key(key) => return None,
                (None, Some(_)) => self.datum_now(key),
                (None, None) => continue,
            };
            let shown = format!("{:?};", value?);
            if shown.contains("Unknown(") {
                return None;
            }
            state.push_str(&shown);
        }
        Some(state)
    }

    /// Whether a condition stays as it is: it asks for data of the program alone, which nothing in
    /// the loop or in a trap sets, and no jump leaves the loop.
    fn is_endless(&self, condition: &'a Expr, body: &'a Block) -> bool {
        let calls = all_of(vec![condition]).into_iter().any(|own| matches!(own, Expr::Call(_)));
        let names = names_in(vec![condition]);
        if calls || self.may_leave(body) || !names.iter().all(|name| self.is_programs(name)) {
            return false;
        }
        let traps = self.file.traps.iter().map(|trap| &trap.body);
        let all = std::iter::once(body).chain(traps);
        let set: HashSet<&str> = all
            .flat_map(|block| set_within(self.file, block))
            .map(|name| name.key.as_str())
            .collect();
        !names.iter().any(|name| set.contains(name.key.as_str()))
    }

    /// Whether a jump, or the end of the program, may leave a loop.
    fn may_leave(&self, body: &'a Block) -> bool {
        let ends = |key: &str| matches!(key, "exit" | "exitcycle" | "systemstopaction");
        jumps_out(body) || calls_in(self.file, &[body]).iter().any(|(name, _)| ends(&name.key))
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
            Some(data) => !data.is_of_tasks() && !has_other_name,
            None => predefined(key).is_some(),
        }
    }
}
