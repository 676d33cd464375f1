//! Where the controller stops as it works something out, or does not load the program: a division
//! by zero, an index beyond an array, a function of what it is not defined for, a constant that is
//! set. And the numbers of its errors.

use std::collections::HashSet;

use super::constants::{VMAX, is_error, predefined};
use super::eval::{Scope, beyond};
use super::interpreter::Interpreter;
use super::operators::equal;
use super::syntax::{Declaration, Expr, File, Path, Step, What};
use super::value::Value;
use super::walk::{names_in, statements_in};
use crate::notes::Code;

impl<'a> Interpreter<'a> {
    /// The statement that runs stops the controller, by what `of` are: an error, and a doubt where
    /// that is not certain.
    pub(super) fn stops_at(&mut self, what: &str, of: Vec<&'a Expr>) {
        let all = names_in(of);
        let others = self.of_others.get_or_init(|| of_others(self.file, &self.set_by_others));
        let name_in = |keys: &HashSet<&str>| {
            all.iter().find(|name| keys.contains(name.key.as_str())).map(|name| &name.shown)
        };
        let unless = match (name_in(&self.set_by_others), name_in(others)) {
            (Some(shown), _) => format!("another task has set '{shown}'"),
            (None, Some(shown)) => format!("another task has set what '{shown}' is worked out of"),
            (None, None) => return self.stops_alone_at(what),
        };
        self.doubt_stop(what, &unless);
    }

    /// The same where nothing of another task decides.
    fn stops_alone_at(&mut self, what: &str) {
        if self.guarded > 0 {
            self.doubt_stop(what, "it leaves out the second side of AND or OR");
        } else if self.handlers > 0 {
            self.doubt_stop(what, "a handler of errors, not read, goes on");
        } else if !self.starts_at_main {
            self.doubt_stop(what, "what has run before has set the data");
        } else {
            let what = format!("{what}: the controller stops here");
            self.fault_at = Some(self.line);
            self.log.error(Code::Value, self.line, what);
        }
    }

    fn doubt_stop(&mut self, what: &str, unless: &str) {
        let what = format!(
            "{what}: the controller stops here unless {unless}; it is read as if it went on"
        );
        self.log.warning(Code::MotionLeftOut, self.line, what);
    }

    /// Whether a value is 0, and what it is compared with the number of an error, which never is.
    pub(super) fn is_no_error(&self, value: &Value, of: &Expr, other: &Expr) -> bool {
        let Expr::Ref(path) = other else { return false };
        let key = path.name.key.as_str();
        value.num() == Ok(0.0)
            && is_error(key)
            && !self.is_declared(key)
            && !self.settings.assume.contains_key(key)
            && !names_in(vec![of]).iter().any(|name| self.may_be_set_in_handlers(&name.key))
    }

    /// Whether handlers of errors, which are not read, name a datum.
    fn may_be_set_in_handlers(&self, key: &str) -> bool {
        let mut routines = self.file.procedures.values().chain(self.file.functions.values());
        routines.any(|own| own.in_handlers.contains(key))
    }

    /// Whether a value of CASE is the one that is tested.
    pub(super) fn is_case(
        &mut self,
        value: &'a Expr,
        (tested, of): (&Value, &Expr),
    ) -> Result<bool, String> {
        let own = self.eval(value);
        let is_no_error = self.is_no_error(tested, of, value) || self.is_no_error(&own, value, of);
        if is_no_error { Ok(false) } else { equal(&own, tested) }
    }

    /// Tells of an index beyond the end of an array.
    pub(super) fn heed_end(&mut self, scope: Scope, key: &str, way: &[usize], path: &'a Path) {
        let mut value = self.own_root(scope, key).filter(|_| !path.is_whole());
        let mut is_beyond = false;
        for (level, index) in way.iter().enumerate() {
            let Some(Value::List(items)) = value else { break };
            value = items.get(*index);
            is_beyond = value.is_none() && is_element(path, way.len() - level);
        }
        if is_beyond {
            let indices = path.steps.iter().flat_map(|step| match step {
                Step::Index(indices) => indices.as_slice(),
                Step::Field(_) => &[],
            });
            self.stops_at(&beyond(&path.name), indices.collect());
        }
    }

    /// Of an assignment to a constant, which no controller loads.
    pub(super) fn refuse_constant(&mut self, line: usize, path: &Path) {
        let key = path.name.key.as_str();
        let local = self.frames.last().and_then(|frame| frame.get(key));
        let is_constant = match (local, self.file.data.get(key)) {
            (Some(datum), _) => datum.is_constant,
            (None, Some(data)) => data.is_constant,
            // Some controllers take it.
            (None, None) => key != VMAX && predefined(key).is_some(),
        };
        if is_constant {
            let what = format!(
                "'{}' is constant and is set here: the controller does not load the program",
                path.name.shown
            );
            self.log.error(Code::Conflict, line, what);
        }
    }
}

/// Data that assignments work out of those that others set; names in several routines are as one.
fn of_others<'a>(file: &'a File, others: &HashSet<&'a str>) -> HashSet<&'a str> {
    let routines = || file.procedures.values().chain(file.functions.values());
    let bodies = || routines().map(|own| &own.body);
    let mut found = others.clone();
    loop {
        let before = found.len();
        for what in statements_in(bodies()) {
            let (name, value) = match what {
                What::Assign(path, value) => (&path.name, value),
                What::Declare(Declaration { name, value: Some(value), .. }) => (name, value),
                _ => continue,
            };
            if names_in(vec![value]).iter().any(|own| found.contains(own.key.as_str())) {
                found.insert(&name.key);
            }
        }
        if found.len() == before {
            return found;
        }
    }
}

/// Whether the part so many levels above the last one is an element of an array.
fn is_element(path: &Path, from_end: usize) -> bool {
    let mut levels = path.steps.iter().rev().flat_map(|step| match step {
        Step::Index(indices) => vec![true; indices.len()],
        Step::Field(_) => vec![false],
    });
    levels.nth(from_end.saturating_sub(1)).unwrap_or(false)
}
