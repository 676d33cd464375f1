//! The interpreter: statements in the order in which the controller would run them.

use std::collections::{HashMap, HashSet};

use super::constants::VMAX;
use super::effect::{CIR_PATH_MODE, Effect, GRIP};
use super::instructions::{self, Motion, change, is_synced};
use super::interpreter::{Flow, Global, Interpreter, MAX_DEPTH, TOO_DEEP};
use super::modules::{LOADS, Loaded};
use super::number::Number;
use super::sets::CHANGE;
use super::syntax::{Args, Block, Expr, Name, Path, Routine, Statement, What, place_of};
use super::value::Value;
use super::walk::{functions_of, statements_in};
use super::why::{COPY, FILE, hint};
use crate::motion::Turning;
use crate::notes::Code;
use crate::program::cell::Given;
use crate::program::spindle_names::is_spindles;

/// Statements that are searched in the time that one takes to run.
const STATEMENTS_A_STEP: usize = 50;

const DEPENDS: &str = " depends on a condition: ";

/// `CirPathMode \\ObjectFrame;`; the modes of the wrist are not read.
fn turning(args: &Args) -> Option<Turning> {
    match args.optional.first().map(|(name, _)| name.as_str()) {
        None | Some("pathframe") => Some(Turning::WithArc),
        Some("objectframe") => Some(Turning::ToEnd),
        Some("cirpointori") => Some(Turning::ByWay),
        Some(_) => None,
    }
}

impl<'a> Interpreter<'a> {
    pub(super) fn run(mut self, routine: &'a Routine, args: &'a Args) {
        self.starts_at_main = routine.name.key == "main";
        self.warn_of_traps();
        self.doubt_handlers(routine);
        self.doubt_aliases();
        self.doubt_own_frames();
        self.heed_connected_elsewhere(routine);
        self.heed_other_tasks(routine);
        self.frames.push(HashMap::new());
        let flow = self.call_routine(routine, args);
        self.tell_who_moves(routine);
        self.tell_vmax();
        self.tell_led();
        self.doubt_next_cycles(routine, args, &flow);
        self.tell_unheeded();
    }

    pub(super) fn block(&mut self, block: &'a Block) -> Flow {
        let mut next = 0;
        while let Some(statement) = block.get(next) {
            let behind = block.get(next + 1..).unwrap_or_default();
            next += 1;
            match self.statement(statement) {
                Flow::Next => {}
                Flow::Goto { label, line, place } => {
                    let is_here = |own: &Statement| match &own.what {
                        What::Label(name) => name.key == label,
                        _ => false,
                    };
                    self.set_anew.clear();
                    // A jump costs what the search for its label does.
                    self.budget = self.budget.saturating_sub(block.len() / STATEMENTS_A_STEP);
                    self.doubt_behind(statement, behind);
                    match block.iter().position(is_here) {
                        Some(at) => next = at,
                        None => return Flow::Goto { label, line, place },
                    }
                }
                flow => {
                    self.doubt_behind(statement, behind);
                    return flow;
                }
            }
        }
        Flow::Next
    }

    fn statement(&mut self, statement: &'a Statement) -> Flow {
        // A statement of another file counts as the one of this file that leads to it, with its
        // own place in what is told of it.
        let there = statement.there.as_ref();
        let is_placed = statement.line > 0 || there.is_some();
        let outer = is_placed.then(|| self.log.within(place_of(there)));
        let outer_line = self.line;
        if statement.line > 0 {
            self.line = statement.line;
        }
        let flow = self.statement_at(self.line, &statement.what);
        if let Some(place) = outer {
            if !place.is_empty() {
                self.line = outer_line;
            }
            self.log.within(place);
        }
        flow
    }

    fn statement_at(&mut self, line: usize, what: &'a What) -> Flow {
        if self.log.is_full() {
            return Flow::Exit;
        }
        if self.budget == 0 {
            self.runs_too_long(line);
            return Flow::Exit;
        }
        self.budget -= 1;
        self.comments.heed(line, self.log);
        if self.depth >= MAX_DEPTH {
            self.tell_too_deep(line);
            return Flow::Exit;
        }
        self.depth += 1;
        let flow = self.statement_inside(line, what);
        self.depth -= 1;
        flow
    }

    fn statement_inside(&mut self, line: usize, what: &'a What) -> Flow {
        match what {
            What::Declare(declaration) => {
                let value = self.initial_value(declaration);
                let is_constant = declaration.is_constant;
                self.declare(&declaration.name.key, &declaration.kind, value, is_constant);
            }
            What::Assign(path, expr) => {
                let span = self.literal(expr);
                let value = self.eval(expr);
                self.refuse_constant(line, path);
                let sets = self.assigns_setter(line, path, Given::any(value.num(), span));
                if sets {
                    self.doubt_order_of_setters(line, &path.name.shown);
                } else {
                    self.doubt_assignment(line, path, Some(expr));
                }
                self.assign(path, value, (!sets).then_some(line));
            }
            What::Call(name, args) => {
                let flow = self.call(line, name, args);
                self.pass_time(&name.key);
                return flow;
            }
            What::If(branches, otherwise) => return self.branches(line, branches, otherwise),
            What::For { variable, from, to, step, body } => {
                return self.for_loop(line, variable, [Some(from), Some(to), step.as_ref()], body);
            }
            What::While(condition, body) => return self.while_loop(line, condition, body),
            What::Test(tested, cases, otherwise) => {
                let blocks = cases.iter().map(|(_, body)| body).chain([otherwise]);
                self.doubt_shared(line, "TEST", vec![tested], blocks.collect());
                return self.test(line, tested, cases, otherwise);
            }
            What::CallByName(name, args, among) => {
                return self.call_by_name(line, name, args, among);
            }
            What::Return(value) => {
                return Flow::Return(value.as_ref().map(|expr| self.eval(expr)));
            }
            What::Goto(label) => {
                let place = self.log.place().to_owned();
                return Flow::Goto { label: label.key.clone(), line, place };
            }
            What::Label(_) => {}
            What::NotUnderstood(why) => self.log.error(Code::Syntax, line, why.clone()),
        }
        Flow::Next
    }

    fn branches(
        &mut self,
        line: usize,
        branches: &'a [(Expr, Block)],
        otherwise: &'a Block,
    ) -> Flow {
        let conditions = branches.iter().map(|(condition, _)| condition).collect();
        let blocks = branches.iter().map(|(_, body)| body).chain([otherwise]);
        self.doubt_shared(line, "IF", conditions, blocks.collect());
        for (index, (condition, body)) in branches.iter().enumerate() {
            match self.eval(condition).bool() {
                Ok(true) => return self.block(body),
                Ok(false) => {}
                Err(why) => {
                    let rest = || branches.iter().skip(index);
                    let conditions = rest().skip(1).map(|(condition, _)| condition).collect();
                    let blocks = rest().map(|(_, body)| body).chain([otherwise]);
                    return self.undecided(line, "IF", &why, conditions, blocks);
                }
            }
        }
        self.block(otherwise)
    }

    /// One of the blocks may run or not: harmless if they do not move; what they assign is lost. So
    /// is what a function gives that one of them may leave, and what it assigns at all.
    pub(super) fn undecided(
        &mut self,
        line: usize,
        keyword: &str,
        why: &str,
        conditions: Vec<&'a Expr>,
        blocks: impl Iterator<Item = &'a Block>,
    ) -> Flow {
        let mut blocks: Vec<&'a Block> = blocks.collect();
        let returns = |what: &What| matches!(what, What::Return(_));
        let may_return = statements_in(blocks.iter().copied()).any(returns);
        let functions = &self.file.functions;
        let is_function = |own: &&Routine| {
            functions.get(&own.name.key).is_some_and(|other| std::ptr::eq(*own, other))
        };
        let left = self.running.last().copied().filter(|own| may_return && is_function(own));
        if let Some(function) = left {
            blocks = vec![&function.body];
        }
        // Of conditions that depend on conditions the cause is told.
        let cause = why.rsplit(DEPENDS).next().unwrap_or(why);
        self.doubt_open(line, &blocks);
        self.heed_open(line, &blocks);
        let asked = self.effect_of_functions(functions_of(conditions), &mut HashSet::new());
        let effects =
            blocks.into_iter().map(|own| self.effect(own, left.is_some(), &mut HashSet::new()));
        for effect in [asked].into_iter().chain(effects).collect::<Vec<_>>() {
            match effect {
                Effect::Motion if why.contains(TOO_DEEP) => {
                    self.tell_too_deep(line);
                    return Flow::Exit;
                }
                Effect::Motion => {
                    let what =
                        format!("{keyword} decides about motion at run time: {why}{}", hint(why));
                    self.log.error(Code::Motion, line, what);
                    return Flow::Next;
                }
                Effect::Data(names) => {
                    for name in names {
                        let what = format!("'{}'{DEPENDS}{cause}", name.shown);
                        self.forget(name, &Value::unknown(what));
                    }
                }
            }
        }
        left.map_or(Flow::Next, |function| {
            let what = format!("function '{}'{DEPENDS}{cause}", function.name.shown);
            Flow::Return(Some(Value::unknown(what)))
        })
    }

    /// A datum, of the routine or of the module, is no longer known.
    pub(super) fn forget(&mut self, name: &'a Name, value: &Value) {
        match (name.key.as_str(), value) {
            (GRIP, Value::Unknown(why)) => self.gripped = Err(why.to_string()),
            (CIR_PATH_MODE, _) => self.turning = None,
            (key, _) if LOADS.contains(&key) => self.loaded = Loaded::unknown(),
            _ => {}
        }
        self.forget_name(&name.key);
        let own = self.frames.last().and_then(|frame| frame.get(&name.key));
        match own.map(|datum| datum.stands_for.as_ref().map(|(key, _)| *key)) {
            None => self.doubt_order(&name.key, name),
            Some(Some(key)) => self.doubt_order(key, name),
            Some(None) => {}
        }
        if let Some(datum) = self.frames.last_mut().and_then(|frame| frame.get_mut(&name.key)) {
            datum.value = value.clone();
            if let Some((key, _)) = &datum.stands_for {
                self.written.insert(key);
                self.globals.insert(key, Global::Known(value.clone()));
            }
        }
        if self.file.data.contains_key(&name.key) {
            self.written.insert(&name.key);
            self.globals.insert(&name.key, Global::Known(value.clone()));
        }
        let is_open = matches!(value, Value::Unknown(_));
        let is_kept = is_open || self.assigned.contains_key(name.key.as_str());
        if is_kept && !self.is_declared(&name.key) {
            self.assigned.insert(&name.key, value.clone());
        }
    }

    /// Sets a datum or a part of one; `line`: where it is told that this is left out.
    pub(super) fn assign(&mut self, path: &'a Path, value: Value, line: Option<usize>) {
        let Err(why) = self.write(path, value.clone()) else { return };
        // Data of another module: what depends on it here is reported where it matters.
        if let (false, Some(line)) = (self.assign_elsewhere(path, value), line) {
            self.log.warning(Code::LeftOut, line, format!("assignment left out: {why}"));
        }
    }

    /// Of a datum that no file declares the program knows what it has set it to as a whole, but for
    /// the rounding; whether it does.
    pub(super) fn assign_elsewhere(&mut self, path: &'a Path, value: Value) -> bool {
        let key = path.name.key.as_str();
        self.forget_name(key);
        if self.is_declared(key) {
            // It is no longer what another file says.
            let own = self.frames.last().and_then(|frame| frame.get(key));
            let module = own.and_then(|own| own.stands_for.as_ref()).map(|(module, _)| *module);
            self.written.insert(module.unwrap_or(key));
            return false;
        }
        self.doubt_order(key, &path.name);
        if key == VMAX {
            if self.predefined_part(path).as_ref() == Some(&value) {
                return true;
            }
            let what = "vmax is set here: whether the controller takes that depends on its \
                        version; from here on it is read as set";
            self.log.warning(Code::ChangeIgnored, self.line, what);
        }
        let trapped = self.trapped.get(key).cloned();
        let value = trapped.unwrap_or(value);
        let value = match (path.is_whole(), value) {
            (true, Value::Absent) => return false,
            (true, value) => value.clone().worked_out([&value]),
            (false, _) => Value::unknown(format!(
                "the program sets a part of '{}', which is declared in no file that is read: {}",
                path.name.shown,
                if key == VMAX { COPY } else { FILE }
            )),
        };
        self.assigned.insert(key, value);
        path.is_whole()
    }

    pub(super) fn is_declared(&self, key: &str) -> bool {
        self.frames.last().is_some_and(|frame| frame.contains_key(key))
            || self.file.data.contains_key(key)
    }

    fn test(
        &mut self,
        line: usize,
        tested: &'a Expr,
        cases: &'a [(Vec<Expr>, Block)],
        otherwise: &'a Block,
    ) -> Flow {
        let known = self.eval(tested);
        for (index, (values, body)) in cases.iter().enumerate() {
            let mut unknown = None;
            for value in values {
                match self.is_case(value, (&known, tested)) {
                    Ok(true) => return self.block(body),
                    Ok(false) => {}
                    Err(why) => unknown = Some(why),
                }
            }
            if let Some(why) = unknown {
                let rest = || cases.iter().skip(index);
                let values = rest().flat_map(|(values, _)| values).collect();
                let blocks = rest().map(|(_, body)| body).chain([otherwise]);
                return self.undecided(line, "TEST", &why, values, blocks);
            }
        }
        self.block(otherwise)
    }

    fn call(&mut self, line: usize, name: &'a Name, args: &'a Args) -> Flow {
        let key = name.key.as_str();
        let sets = self.sets(line, name, args);
        if sets {
            self.doubt_order_of_setters(line, &name.shown);
        }
        if let Some(routine) = self.file.procedures.get(key) {
            self.doubt_procedure(line, routine);
            self.in_setters += usize::from(sets);
            let flow = self.call_routine(routine, args);
            self.in_setters -= usize::from(sets);
            return match flow {
                Flow::Exit => Flow::Exit,
                _ => Flow::Next,
            };
        }
        if let Some(motion) = instructions::motion(key) {
            return self.move_by(line, motion, name, args);
        }
        self.set_output(line, key, args);
        match key {
            "waittime" => self.wait_time(line, args),
            "waitrob" | "stop" => self.arrive(),
            "exit" | "systemstopaction" => return Flow::Exit,
            "exitcycle" => {
                self.starts_again = true;
                return Flow::Exit;
            }
            "raise" | "errraise" | "trynext" | "retry" => {
                let what =
                    format!("{} outside an error handler: what those do is not read", name.shown);
                self.log.error(Code::Motion, line, what);
                return Flow::Exit;
            }
            "velset" => self.velset(line, args),
            "speedrefresh" => {
                self.doubt_beside(Code::ChangeIgnored, line, &name.shown);
                self.speed_refresh(line, args);
            }
            GRIP => {
                self.doubt_beside(Code::ChangeIgnored, line, &name.shown);
                self.grip(line, args);
            }
            "mechunitload" => self.load_of_unit(line, args),
            CIR_PATH_MODE => self.turning = turning(args),
            "confj" | "confl" => {
                let is_off = args.optional.iter().any(|(name, _)| name == "off");
                self.monitors[usize::from(key == "confl")] = !is_off;
            }
            "bitset" | "bitclear" => self.change_bit(line, key, args),
            _ if CHANGE.contains(&key) => self.count(line, key, args),
            "setsysdata" => self.set_sys_data(line, args),
            "setdataval" => self.set_named(line, name, args),
            "loadid" => self.identify_load(line, args),
            _ if instructions::displaces(key) => {
                let what = format!("{}: {}", name.shown, instructions::why_displaced(key));
                self.log.error(Code::Motion, line, what);
            }
            _ if instructions::sounds_like_motion(key)
                || !instructions::copies(key) && self.passes_a_target(args) =>
            {
                let what = instructions::why_not_read(key, &name.shown);
                self.log.error(Code::Motion, line, what);
                self.fill_found(name, args);
            }
            _ if sets => {}
            "connect" => self.connect(line, args),
            "idelete" => self.disconnect(args),
            _ => {
                // `WaitUntil\InPos` and its like: the arm has come to stand.
                if key.starts_with("wait") && args.optional.iter().any(|(own, _)| own == "inpos") {
                    self.arrive();
                }
                match key {
                    "waituntil" => self.waited(args),
                    "actunit" => self.switch_on(args),
                    "deactunit" => self.switch_off(args, true),
                    _ if LOADS.contains(&key) => self.heed_load(key, args),
                    _ => self.run_functions(key, args),
                }
                self.heed_stop(line, name);
                self.fill(name, args);
                self.note_what_is_left_out(line, name, args);
            }
        }
        Flow::Next
    }

    /// A motion instruction by its name, with what belongs to the move.
    pub(super) fn move_by(
        &mut self,
        line: usize,
        motion: Motion,
        name: &Name,
        args: &'a Args,
    ) -> Flow {
        self.set_output(line, &name.key, args);
        self.doubt_modes(line);
        // What the controller stops at is told already.
        match self.motion(line, motion, args) {
            Err(why) if why.contains(TOO_DEEP) => {
                self.tell_too_deep(line);
                return Flow::Exit;
            }
            Err(why) if self.fault_at != Some(line) => {
                self.log.error(Code::Motion, line, format!("{}: {why}", name.shown));
            }
            _ => {}
        }
        if self.has_arrived {
            self.settle();
        }
        self.doubt_call(line, name, args);
        match is_synced(&name.key) {
            true => self.synced(line, name, args),
            false => Flow::Next,
        }
    }

    /// `MechUnitLoad` says what an external unit carries, which counts where the job has it as a
    /// joint of the robot.
    fn load_of_unit(&mut self, line: usize, args: &Args) {
        if let (Some(Expr::Ref(unit)), false) =
            (args.positional.first(), self.settings.external_axes.is_empty())
        {
            let shown = &unit.name.shown;
            let what = format!("MechUnitLoad: what {shown} carries is not counted");
            self.log.warning(Code::ChangeIgnored, line, what);
        }
    }

    fn note_what_is_left_out(&mut self, line: usize, name: &Name, args: &'a Args) {
        self.heed_change(line, name, args);
        self.doubt_call(line, name, args);
        match instructions::is_ignored(&name.key) {
            true => {}
            // What it may set is the spindle.
            false if is_spindles(&name.shown) => {
                self.forget_all_outputs();
                self.lose_arguments(name, args);
            }
            false => {
                self.not_in_file(line, &name.shown);
                self.lose_arguments(name, args);
            }
        }
    }

    /// Of what changes how the arm moves and is not read, or ends that.
    pub(super) fn heed_change(&mut self, line: usize, name: &Name, args: &Args) {
        match change(name, args) {
            Some((changed, true)) => self.doubt_change(line, &name.shown, changed),
            Some((changed, false)) => self.doubt_end(line, &name.shown, changed),
            None => {}
        }
    }

    /// Of a change that begins.
    pub(super) fn doubt_change(&mut self, line: usize, shown: &str, changed: &'static str) {
        self.begun.insert(changed);
        let used = match changed.starts_with(instructions::WHERE) {
            true => "the path is checked as it is programmed",
            false => "the robot file's stiffness and the programmed speeds are used throughout",
        };
        let what = format!("{shown} changes {changed}, which is not read: {used}");
        self.log.warning(Code::ChangeIgnored, line, what);
    }

    /// Where nothing has begun such a change, the moves before its end may have been under it.
    fn doubt_end(&mut self, line: usize, shown: &str, changed: &'static str) {
        if !self.log.has_way() || self.begun.contains(changed) {
            return;
        }
        let what = format!(
            "{shown} ends a change of {changed}, and nothing before it that is read begins one: \
             the moves before it are checked without; let path.program.procedure in the job name \
             the procedure that begins it, or leave {shown} out of a copy of the program where \
             none does"
        );
        self.log.warning(Code::ChangeIgnored, line, what);
    }

    /// A procedure or function that may do anything.
    pub(super) fn not_in_file(&mut self, line: usize, shown: &str) {
        let what = format!(
            "'{shown}' is not in this file: if it moves, or sets frames or data, that is not read"
        );
        self.forget_all_outputs();
        self.lose_undeclared(shown);
        self.called_elsewhere = Some(shown.to_owned());
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    /// Whether an argument is a target: then the instruction goes there, known or not.
    fn passes_a_target(&self, args: &Args) -> bool {
        args.positional.iter().any(|arg| match arg {
            Expr::Call(call) => matches!(call.0.key.as_str(), "offs" | "reltool" | "crobt"),
            Expr::Ref(path) => {
                let local = self.frames.last().and_then(|frame| frame.get(&path.name.key));
                let kind = local.map(|datum| datum.kind).or_else(|| {
                    self.file.data.get(&path.name.key).map(|datum| datum.kind.as_str())
                });
                path.steps.iter().all(|step| matches!(step, super::syntax::Step::Index(_)))
                    && matches!(kind, Some("robtarget" | "jointtarget"))
            }
            Expr::List(parts) => match parts.as_slice() {
                [Expr::List(at), Expr::List(turned), ..] => {
                    matches!((at.len(), turned.len()), (3, 4) | (6, 6))
                }
                _ => false,
            },
            _ => false,
        })
    }

    fn count(&mut self, line: usize, key: &str, args: &'a Args) {
        let Some(Expr::Ref(path)) = args.positional.first() else { return };
        self.refuse_constant(line, path);
        self.doubt_assignment(line, path, None);
        let by = match (key, args.positional.get(1)) {
            ("incr", _) => Ok(Number::of(1.0)),
            ("decr", _) => Ok(Number::of(-1.0)),
            ("add", Some(expr)) => self.eval(expr).number(),
            _ => Ok(Number::of(0.0)),
        };
        let keep = if key == "clear" { 0.0 } else { 1.0 };
        let sum = self
            .read(path)
            .number()
            .and_then(|number| Ok(number.with(by?, |number, by| number * keep + by)));
        let value = sum.map_or_else(Value::unknown, Value::Num);
        self.assign(path, value, Some(line));
    }

    /// `SpeedRefresh 50;`: the override from here on.
    fn speed_refresh(&mut self, line: usize, args: &'a Args) {
        match args.positional.first().map(|expr| self.eval(expr).num()) {
            Some(Ok(percent)) if percent > 0.0 && percent <= 100.0 => {
                self.over = crate::units::ratio_from_percent(percent);
            }
            Some(Err(why)) => self.log.error(Code::Value, line, format!("SpeedRefresh: {why}")),
            _ => self.log.error(Code::Value, line, "SpeedRefresh: expected 1 to 100 %"),
        }
    }

    fn velset(&mut self, line: usize, args: &'a Args) {
        let numbers: Result<Vec<f64>, String> =
            args.positional.iter().map(|arg| self.eval(arg).num()).collect();
        match numbers.as_deref() {
            Ok([percent, limit]) if *percent > 0.0 && *limit > 0.0 => {
                self.velocity = (crate::units::ratio_from_percent(*percent), *limit);
            }
            Ok(_) => self.log.error(
                Code::Value,
                line,
                "VelSet: expected a percentage and a limit, both positive",
            ),
            Err(why) => self.log.error(Code::Value, line, format!("VelSet: {why}")),
        }
    }
}
