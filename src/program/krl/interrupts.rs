//! Interrupts and triggers of KRL: the run decides when they come. What they move is not read, so
//! that it is a doubt; what they set is not known afterwards.

use std::collections::HashSet;

use super::run::{Beside, Run};
use super::syntax::{Block, Expr, Path, Routine, What};
use super::walk::{blocks_in, expressions, functions_in};
use super::words::{fills, is_harmless, is_own_function, sets_motion};
use crate::notes::Code;

/// What an interrupt or a trigger does that is not read.
#[derive(Default)]
pub(super) struct Unread<'a> {
    /// With motion, or with what motion depends on.
    motion: Option<String>,
    /// What it sets beside what its own routines declare, and to what.
    pub(super) sets: Vec<Set<'a>>,
}

#[derive(Clone, Copy)]
pub(super) struct Set<'a> {
    pub(super) path: &'a Path,
    pub(super) expr: Option<&'a Expr>,
    /// Whether a routine that is called sets it: the name is none of the program that is read.
    is_called: bool,
}

impl<'a> Run<'a> {
    pub(super) fn declare_interrupt(&mut self, number: &'a Expr, action: Option<&'a What>) {
        // One of which the number is not known may be any.
        let number = self.eval(number).num().map(|number| number.to_string()).unwrap_or_default();
        self.interrupts.insert(number, action);
    }

    pub(super) fn interrupt_on(&mut self, line: usize, number: Option<&'a Expr>) {
        let number = number.and_then(|expr| self.eval(expr).num().ok()).map(|n| n.to_string());
        if let Some(number) = &number
            && !["", number].iter().any(|key| self.interrupts.contains_key(*key))
        {
            let what = format!(
                "INTERRUPT ON {number}: it is declared in no file that is read; if it moves, its \
                 motion is not read"
            );
            self.log.warning(Code::MotionLeftOut, line, what);
        }
        let is_on = |key: &str| key.is_empty() || number.as_deref().is_none_or(|own| own == key);
        let on = self.interrupts.iter().filter(|(key, _)| is_on(key));
        let actions: Vec<_> = on.map(|(key, action)| (key.clone(), *action)).collect();
        for (key, action) in actions {
            let key = Some(key).filter(|key| !key.is_empty());
            self.leave_out(line, "an interrupt", key, action);
        }
    }

    /// What the program sets from here on holds.
    pub(super) fn interrupt_off(&mut self, number: Option<&'a Expr>) {
        match number.map(|expr| self.eval(expr).num()) {
            None => self.beside.retain(|own| own.interrupt.is_none()),
            Some(Ok(number)) => {
                let number = Some(number.to_string());
                self.beside.retain(|own| own.interrupt != number);
            }
            Some(Err(_)) => {}
        }
    }

    pub(super) fn trigger(&mut self, line: usize, action: Option<&'a What>) {
        self.leave_out(line, "a TRIGGER", None, action);
    }

    fn leave_out(
        &mut self,
        line: usize,
        by: &str,
        interrupt: Option<String>,
        action: Option<&'a What>,
    ) {
        let unread = match action {
            Some(what) => self.unread(what),
            None => {
                let motion = Some("does what is not understood".to_owned());
                Unread { motion, ..Unread::default() }
            }
        };
        if let Some(motion) = unread.motion {
            let what = format!("{by} {motion} when it comes: this is not read");
            self.log.warning(Code::MotionLeftOut, line, what);
        }
        for set in unread.sets {
            // What data lists declare hides behind data of the routine that runs.
            let is_for_all = set.is_called && self.types.contains_key(&set.path.name);
            let hidden = if is_for_all { std::mem::take(&mut self.frames) } else { Vec::new() };
            self.set_beside(line, by, interrupt.as_ref(), set);
            self.frames.extend(hidden);
        }
    }

    fn set_beside(&mut self, line: usize, by: &str, interrupt: Option<&String>, set: Set<'a>) {
        let Set { path, expr, .. } = set;
        self.doubt_set(line, path);
        self.doubt_undeclared(line, path, expr);
        expr.into_iter().for_each(|expr| self.doubt_beside_spindle(line, path, expr));
        let why = format!("'{}' is set by {by}: known only at run time", path.name);
        // By other numbers it may then be any element.
        let is_fixed = path.indices.iter().all(|index| matches!(index, Expr::Number(..)));
        let key = match self.key(path) {
            Ok(key) if is_fixed => {
                self.forget(path, &why);
                key
            }
            _ => {
                self.forget_element(path, &why);
                path.name.clone()
            }
        };
        let scope = self.scope(&key);
        let own = Beside { interrupt: interrupt.cloned(), key, scope, why };
        if !self.beside.contains(&own) {
            self.beside.push(own);
        }
    }

    /// What a statement and all that it calls would do.
    pub(super) fn unread(&self, action: &'a What) -> Unread<'a> {
        let mut found = Unread::default();
        let mut seen = HashSet::new();
        // Each with the routine that it stands in, where that is called.
        let mut open: Vec<(&'a What, Option<&'a Routine>)> = vec![(action, None)];
        while let Some((what, routine)) = open.pop() {
            let mut set = |path: &'a Path, expr| {
                if routine.is_none_or(|own| !own.declares(&path.name)) {
                    found.sets.push(Set { path, expr, is_called: routine.is_some() });
                }
            };
            let mut bodies = vec![];
            let not_read =
                |name| Some(format!("calls '{name}', which is in no file that is read,"));
            let mut unread = None;
            for (name, path) in self.by_reference(what) {
                if sets_motion(&path.name) {
                    let shown = path.name.to_uppercase();
                    found.motion.get_or_insert_with(|| format!("lets '{name}' set {shown}"));
                } else {
                    set(path, None);
                }
            }
            for (name, _) in functions_in(expressions(what)) {
                match self.file.functions.get(name) {
                    Some(routine) if seen.insert(name) => bodies.push(routine),
                    None if !is_own_function(name) => unread = not_read(name),
                    _ => {}
                }
            }
            let motion = match what {
                What::Move(_) | What::Spline(..) => Some("moves the robot".to_owned()),
                What::Assign(path, _) if sets_motion(&path.name) => {
                    Some(format!("sets {}", path.name.to_uppercase()))
                }
                What::Assign(path, expr) => {
                    set(path, Some(expr));
                    None
                }
                What::For(path, ..) => {
                    set(path, None);
                    None
                }
                What::Call(name, args) if name == "pulse" => {
                    if let Some(Some(Expr::Ref(path))) = args.first() {
                        set(path, None);
                    }
                    None
                }
                What::Call(name, _) => match self.file.routine(name) {
                    Some(routine) => {
                        if seen.insert(name) {
                            bodies.push(routine);
                        }
                        None
                    }
                    None if is_harmless(name) => None,
                    None => not_read(name),
                },
                What::NotUnderstood(_) | What::Trigger(None) => {
                    Some("does what is not understood".to_owned())
                }
                What::Trigger(Some(action)) => {
                    open.push((action, routine));
                    None
                }
                _ => None,
            };
            found.motion = found.motion.or(motion).or(unread);
            let inner = blocks_in(what).into_iter().map(|block| (block, routine));
            let called = bodies.into_iter().map(|own| (&own.body, Some(own)));
            for (block, of) in inner.chain(called) {
                open.extend(block.iter().map(|statement| (&statement.what, of)));
            }
        }
        found
    }

    /// Data that a statement gives by reference to routines of the files, with their names, and
    /// that CREAD and the like fill in.
    fn by_reference(&self, what: &'a What) -> Vec<(&'a str, &'a Path)> {
        let mut calls = functions_in(expressions(what));
        if let What::Call(name, args) = what {
            calls.push((name, args));
        }
        let mut found = Vec::new();
        for (name, args) in calls {
            let parameters = self.file.routine(name).map(|own| own.parameters.as_slice());
            for (index, arg) in args.iter().enumerate() {
                let parameter = parameters.map(|all| all.get(index));
                let may_be_set = match parameter {
                    Some(parameter) => parameter.is_some_and(|own| !own.is_by_value),
                    None => fills(name),
                };
                if let (true, Some(Expr::Ref(path))) = (may_be_set, arg) {
                    found.push((name, path));
                }
            }
        }
        found
    }

    /// Signals that triggers, interrupts and pulses set, one alone where its number is known: the
    /// run decides when, and what the program sets them to may hold or not.
    pub(super) fn timed_signals(&self) -> HashSet<String> {
        let mut found = HashSet::new();
        let routines = self.file.routines.values().chain(self.file.functions.values());
        let mut open: Vec<&Block> = routines.map(|routine| &routine.body).collect();
        while let Some(block) = open.pop() {
            for statement in block {
                let what = &statement.what;
                open.extend(blocks_in(what));
                let action = match what {
                    What::Trigger(Some(action)) | What::InterruptDecl(_, Some(action)) => action,
                    What::Call(name, _) if name == "pulse" => what,
                    _ => continue,
                };
                let sets = self.unread(action).sets.into_iter();
                let signals = &self.file.signals;
                for set in sets {
                    let key = signals.key(fixed_key(set.path));
                    found.extend(signals.shared_with(&key));
                    found.extend(key.starts_with('$').then_some(key));
                }
            }
        }
        found
    }

    /// Whether expressions call functions of the files.
    pub(super) fn calls_a_routine(&self, open: Vec<&'a Expr>) -> bool {
        functions_in(open).into_iter().any(|(name, _)| self.file.functions.contains_key(name))
    }
}

/// The key of an element by its number, else of its list.
pub(super) fn fixed_key(path: &Path) -> String {
    let mut key = path.name.clone();
    for index in &path.indices {
        let Expr::Number(number, ..) = index else { return path.name.clone() };
        key.push_str(&format!("[{number}]"));
    }
    key
}
