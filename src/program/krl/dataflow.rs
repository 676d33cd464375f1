//! Data that rest on others, followed as the program runs: a doubt where they matter.

use std::collections::HashMap;

use super::hints::{all_in, statements_in};
use super::interrupts::fixed_key;
use super::open::names_set;
use super::rests::{Rests, Uses, Waits};
use super::run::{Run, leaves};
use super::signals::named_by;
use super::syntax::{Block, Expr, File, Path, Statement, What};
use super::value::{Value, base};
use super::walk::{blocks_in, expressions, functions_in, paths_in};
use super::words::{fills, is_harmless, is_own_function, is_without_effect};
use crate::notes::Code;
use crate::program::cell::all;
use crate::program::{Assumed, Setter};

impl<'a> Uses<'a> {
    pub(super) fn of(file: &'a File) -> Self {
        let mut found = Self::default();
        let routines = file.routines.values().chain(file.functions.values());
        for what in statements_in(routines.map(|routine| &routine.body)) {
            let mut calls = functions_in(expressions(what));
            match what {
                What::Call(name, args) => calls.push((name, args)),
                What::Assign(path, _) => drop(found.set.insert(&path.name)),
                What::For(variable, ..) => drop(found.counters.insert(&variable.name)),
                _ => {}
            }
            for (name, args) in calls {
                let routine = file.routine(name);
                if routine.is_none() && is_own_function(name) && !fills(name) {
                    continue;
                }
                let parameters = routine.map_or(&[][..], |own| &own.parameters);
                for (index, arg) in args.iter().enumerate() {
                    let is_by_value = parameters.get(index).is_some_and(|own| own.is_by_value);
                    if let (Some(Expr::Ref(path)), false) = (arg, is_by_value) {
                        found.set.insert(&path.name);
                    }
                }
            }
        }
        found
    }
}

/// A datum and a component of it.
fn whole(key: &str, fields: &[String]) -> String {
    fields.iter().fold(key.to_owned(), |name, field| format!("{name}.{field}"))
}

/// Whether it may be any element of a list.
fn is_any_element(path: &Path) -> bool {
    !path.indices.is_empty() && fixed_key(path) == path.name
}

/// What stands for any element of a list.
fn any_of(name: &str) -> String {
    format!("{name}[]")
}

impl<'a> Run<'a> {
    /// What data rest on, of the routine that runs or for all, as the datum is.
    pub(super) fn resting(&mut self, key: &str) -> &mut HashMap<String, Rests> {
        match self.frames.last_mut().filter(|frame| frame.has(key)) {
            Some(frame) => &mut frame.resting,
            None => &mut self.resting,
        }
    }

    /// The statement that runs asks for a datum or a component of it; whether what the job says of
    /// it counts before its value.
    pub(super) fn asks_for(&mut self, key: &str, fields: &[String]) -> bool {
        if self.is_said(key, fields) {
            return true;
        }
        let resting = self.resting(key);
        let list = || resting.get(&any_of(base(key)));
        let found = match resting.is_empty() {
            true => None,
            false => resting.get(key).or_else(list).cloned(),
        };
        let found = found.or_else(|| self.set_by_others(key, fields));
        self.rests_too(found);
        false
    }

    /// The statement that runs rests on this, too: what matters more is told.
    pub(super) fn rests_too(&mut self, on: Option<Rests>) {
        if on.is_some() && self.rests_on.as_ref().is_none_or(Rests::is_of_cell) {
            self.rests_on = on;
        }
    }

    /// The program sets a datum or a component of it.
    pub(super) fn sets_anew(&mut self, key: &str, fields: &[String]) {
        let resting = self.resting(key);
        if fields.is_empty() && !resting.is_empty() {
            resting.remove(key);
            resting.remove(&any_of(key));
        }
        if !self.is_own(key) {
            self.waits.set_since.insert(whole(key, fields));
        }
    }

    /// Whether others may set a datum while the program waits: what no file declares, what is
    /// declared for all, and flags.
    fn is_shared(&self, key: &str) -> bool {
        // Numbered frames and loads, and the data of inline forms, are the controller's own.
        const NUMBERED: [&str; 3] = ["tool_data", "base_data", "load_data"];
        let name = base(key);
        let is_for_all = match name.starts_with('$') {
            true => name == "$flag",
            false => !self.types.contains_key(name) || self.file.for_all.contains(name),
        };
        let is_fixed = self.file.constants.contains(name) || self.uses.counters.contains(name);
        let is_controllers = NUMBERED.contains(&name) || name.ends_with("_act");
        is_for_all && !is_fixed && !is_controllers && !self.is_own(key)
    }

    /// Whether the job says what others may have set a datum to that no statement sets.
    fn is_said(&self, key: &str, fields: &[String]) -> bool {
        let is_open = !self.settings.assume.is_empty()
            && !self.uses.set.contains(base(key))
            && !self.forgotten.contains(key)
            && self.is_shared(key);
        if !is_open {
            return false;
        }
        let names = self.names(key);
        let is_assumed = |name: &String| self.settings.assume.contains_key(&whole(name, fields));
        let is_it = |(_, is): &(&str, Assumed)| *is == Assumed::Truth(true);
        names.iter().any(is_assumed)
            || fields.is_empty() && self.names_given(&names).iter().any(is_it)
    }

    /// Others may have set a datum since the program has.
    fn set_by_others(&self, key: &str, fields: &[String]) -> Option<Rests> {
        if !self.waits.any || !self.is_shared(key) {
            return None;
        }
        let mut names = (0..=fields.len()).map(|count| whole(key, &fields[..count]));
        if names.any(|name| self.waits.set_since.contains(&name)) {
            return None;
        }
        let is_known = match self.globals.get(key)? {
            Value::Unknown(_) => self.components.contains_key(&whole(key, fields)),
            _ => true,
        };
        let name = base(key);
        let is_system = name.starts_with('$');
        let shown = self.names(key).pop().unwrap_or_default();
        is_known.then(|| Rests::Others {
            name: whole(&shown, fields).to_uppercase(),
            is_set: is_system || self.uses.set.contains(name),
            is_declared: is_system || self.types.contains_key(name),
        })
    }

    /// Whether the job reads the spindle or the tool from an element of a list.
    pub(super) fn is_list_of_job(&self, name: &str) -> bool {
        let mut keys = named_by(self.settings).map(|own| self.file.signals.key(own));
        keys.any(|key| base(&key) == name)
    }

    /// A datum, and the list that it is an element of, rest on another.
    pub(super) fn rests(&mut self, key: String, on: Rests) {
        let list = base(&key).to_owned();
        let resting = self.resting(&key);
        resting.insert(list, on.clone());
        resting.insert(key, on);
    }

    /// While WAIT FOR waits for what is not known to hold, others may set what is there for all.
    pub(super) fn others_may_set(&mut self, condition: &'a [Option<Expr>], value: &Value) {
        let condition: Vec<&Expr> = condition.iter().flatten().collect();
        if value.bool() != Ok(true) || !self.has_all(condition) {
            self.waits = Waits { any: true, ..Waits::default() };
        }
    }

    /// A loop has ended: one without a move waits, unless the program itself ends it.
    pub(super) fn polled(&mut self, body: &'a Block, mut asked: Vec<&'a Expr>) {
        let ends = |own: &&Statement| leaves(std::slice::from_ref(own), true);
        asked.extend(body.iter().filter(ends).flat_map(|own| expressions(&own.what)));
        if !self.has_all(asked) && !body.iter().any(|own| self.moves(&own.what)) {
            self.waits = Waits { any: true, ..Waits::default() };
        }
    }

    /// Whether the program itself has set all data that expressions name, since the last wait where
    /// others may set them.
    fn has_all(&mut self, open: Vec<&'a Expr>) -> bool {
        paths_in(open).into_iter().all(|path| {
            let Ok(key) = self.key(path) else { return false };
            let name = whole(&key, &path.fields);
            let set = [&key, &name].map(|own| self.waits.set_since.contains(own));
            let is_known = match self.globals.get(&key) {
                None => false,
                Some(Value::Unknown(_)) => self.components.contains_key(&name),
                Some(_) => true,
            };
            self.is_own(&key) || is_known && (!self.is_shared(&key) || set.contains(&true))
        })
    }

    /// A statement rests on another datum: what it sets does so, too, and where it moves, branches
    /// or sets what motion depends on, that is a doubt.
    pub(super) fn tell_resting(&mut self, line: usize, what: &'a What, on: Rests) {
        match what {
            What::Assign(path, expr) if !self.calls_a_routine(vec![expr]) => {
                let key = self.key(path);
                // Which element it sets may be another.
                let is_any = self.rests_on.take().is_some();
                let is_of_motion = path.name.starts_with('$') && !is_without_effect(&path.name);
                if let (Ok(key), false) = (&key, is_any || is_of_motion)
                    && !self.is_read_by_job(key)
                {
                    self.rests(key.clone(), on);
                    return;
                }
                // Of outputs and flags it may be any.
                let is_plain = is_without_effect(&path.name) && !self.is_list_of_job(&path.name);
                if is_any && is_plain {
                    self.resting(&path.name).insert(any_of(&path.name), on);
                    return;
                }
            }
            What::Call(name, _)
                if is_harmless(name) && !matches!(name.as_str(), "anout" | "pulse") =>
            {
                return;
            }
            _ if matches!(on, Rests::Others { .. }) && !self.may_matter(what) => {
                self.all_rest(what, &on);
                return;
            }
            _ => {}
        }
        if on.is_of_cell() && blocks_in(what).is_empty() {
            return;
        }
        let told = on.told();
        if matches!(on, Rests::Others { .. }) {
            self.unmoved.rests.get_or_insert_with(|| (line, told.clone()));
        }
        self.log.warning(Code::MotionLeftOut, line, told);
    }

    /// All that a statement may set, in any of its branches and what they call, rests on this.
    fn all_rest(&mut self, what: &'a What, on: &Rests) {
        for set in self.reached(vec![what]) {
            let fixed = match set {
                What::Assign(path, _) if !is_any_element(path) => Some(path),
                _ => None,
            };
            for name in names_set(set) {
                if let Some(path) = fixed.filter(|path| path.name == name) {
                    let own = fixed_key(path);
                    let key = if self.is_own(&own) { own } else { self.file.signals.key(own) };
                    self.rests(key, on.clone());
                    continue;
                }
                let resting = self.resting(name);
                resting.insert(any_of(name), on.clone());
                resting.insert(name.to_owned(), on.clone());
            }
        }
    }

    /// Whether a statement does more than set data, in any of its branches and what they call.
    fn may_matter(&mut self, what: &'a What) -> bool {
        let place = std::ptr::from_ref(what);
        if let Some(known) = self.uses.matter.get(&place) {
            return *known;
        }
        // EXIT in a loop ends that.
        let is_loop = matches!(what, What::While(..) | What::Repeat(..) | What::For(..));
        let calls = matches!(what, What::Call(..)) || self.calls_a_routine(expressions(what));
        let is_data = matches!(what, What::Call(..) | What::Assign(..) | What::Declare(..));
        let is_plain = blocks_in(what).is_empty() && !(calls && is_data);
        let matters = is_plain
            || blocks_in(what).into_iter().any(|block| leaves(block, !is_loop))
            || all_in(blocks_in(what).into_iter())
                .into_iter()
                .any(|own| own.file == 0 && self.comments.set_at(own.line))
            || self.reached(vec![what]).into_iter().any(|own| self.does_more(own));
        self.uses.matter.insert(place, matters);
        matters
    }

    /// Whether a statement moves, or may, or sets what motion or the job depends on.
    fn does_more(&self, what: &What) -> bool {
        match what {
            What::Move(_) | What::Spline(..) | What::NotUnderstood(_) => true,
            What::Assign(path, _) => {
                let is_of_motion = path.name.starts_with('$') && !is_without_effect(&path.name);
                is_of_motion
                    || self.is_read_by_job(&fixed_key(path))
                    || is_any_element(path) && self.is_list_of_job(&path.name)
            }
            What::Call(name, _) => {
                let is_of_job = |by: &Setter| match by {
                    Setter::Procedure(own, _) => own.to_lowercase() == *name,
                    Setter::Comment(_) | Setter::Signal(_) => false,
                };
                self.file.routine(name).is_none() && !is_harmless(name)
                    || all(self.settings).any(|(_, by)| is_of_job(&by.what))
            }
            _ => false,
        }
    }
}
