//! What handlers of errors set, which are not read: they run where an error comes.

use std::ops::RangeInclusive;

use super::interpreter::{Handled, Interpreter};
use super::sets::{given_to, set_within};
use super::syntax::{Expr, File, Routine, What};
use super::traps::{calls, goes_on};
use super::walk::{
    functions_in, functions_of, names_in, own_names, reached, reached_from, statements_in,
};

/// The lines of handlers behind which nothing goes on: no error of the program is taken up.
pub(super) fn last_lines(file: &File, entry: &Routine) -> Vec<RangeInclusive<usize>> {
    let reached = reached_from(file, vec![&entry.name.key]);
    let Some(reached) = reached else { return Vec::new() };
    let procedures = file.procedures.iter().filter(|(key, _)| reached.contains(key.as_str()));
    let all = procedures.map(|(_, own)| own).chain(file.functions.values());
    let handling: Vec<&Routine> = all.filter(|own| !own.handlers.is_empty()).collect();
    let is_last = |own: &Routine| {
        // Which of its statements are in which of them is not kept.
        let of = ["error", "undo", "backward"].map(|word| own.in_handlers.contains(word));
        of == [false, true, false] || of == [true, false, false] && !goes_on(&own.handlers)
    };
    // Another cycle begins behind it.
    let again = |what: &What| calls(what, &["exitcycle"]);
    let traps = file.traps.iter().map(|trap| &trap.body);
    let blocks = file.procedures.values().chain(file.functions.values());
    let blocks = blocks.flat_map(|own| [&own.body, &own.handlers]).chain(traps);
    let mut handled = statements_in(handling.iter().map(|own| &own.handlers));
    if !handling.iter().all(|own| is_last(own))
        || handled.any(|what| matches!(what, What::NotUnderstood(_)))
        || statements_in(blocks).any(again)
    {
        return Vec::new();
    }
    // What stands before the handler in its line runs.
    let lines = handling.iter().filter(|own| own.there.is_none());
    lines.map(|own| own.handlers_from + 1..=own.end).collect()
}

impl<'a> Handled<'a> {
    /// Of the routines that may run.
    fn of(file: &'a File, entry: Option<&&'a Routine>) -> Self {
        let reached = entry.and_then(|entry| reached(file, entry));
        let may_run = |own: &&Routine| {
            reached.as_ref().is_none_or(|reached| reached.contains(own.name.key.as_str()))
        };
        let procedures = file.procedures.values().filter(may_run);
        let routines: Vec<_> = procedures.chain(file.functions.values()).collect();
        let mut found = Self::default();
        for routine in &routines {
            for name in set_within(file, &routine.handlers) {
                found.keep(file, routine, &name.key);
            }
            for what in statements_in(std::iter::once(&routine.handlers)) {
                match what {
                    What::Return(Some(_)) => {
                        found.functions.insert(&routine.name.key);
                    }
                    What::Call(name, args) if name.key == "setdataval" => {
                        let named = match args.positional.first() {
                            Some(Expr::Text(text)) => text.trim().to_lowercase(),
                            _ => continue,
                        };
                        let own = file.data.get_key_value(&named);
                        found.data.extend(own.map(|(key, _)| key.as_str()));
                    }
                    _ => {}
                }
            }
        }
        loop {
            let mut is_new = false;
            for routine in &routines {
                for what in statements_in([&routine.body, &routine.handlers].into_iter()) {
                    is_new |= found.follow(file, routine, what);
                }
            }
            if !is_new {
                return found;
            }
        }
    }

    /// What a statement makes of it; whether anything is new.
    fn follow(&mut self, file: &'a File, routine: &'a Routine, what: &'a What) -> bool {
        let functions = functions_in(what).into_iter();
        let functions =
            functions.filter_map(|(name, args)| Some((file.functions.get(&name.key)?, args)));
        let procedure = match what {
            What::Call(name, args) => file.procedures.get(&name.key).map(|own| (own, args)),
            _ => None,
        };
        let mut is_new = false;
        for (called, args) in functions.chain(procedure) {
            for (parameter, path) in given_to(called, args) {
                if parameter.by_reference && self.is_own(called, &parameter.name.key) {
                    is_new |= self.keep(file, routine, &path.name.key);
                }
            }
        }
        let is_by_handlers = |own: &Self, expr: &Expr| {
            let mut functions = functions_of(vec![expr]).into_iter();
            functions.any(|(name, _)| own.functions.contains(name.key.as_str()))
        };
        match what {
            What::Assign(path, expr) if is_by_handlers(self, expr) => {
                is_new |= self.keep(file, routine, &path.name.key);
            }
            What::Return(Some(expr))
                if is_by_handlers(self, expr)
                    || names_in(vec![expr]).iter().any(|name| self.is_in(routine, &name.key)) =>
            {
                is_new |= self.functions.insert(&routine.name.key);
            }
            _ => {}
        }
        is_new
    }

    /// A handler sets what a routine knows by this name; whether that is new.
    fn keep(&mut self, file: &File, routine: &'a Routine, key: &'a str) -> bool {
        if own_names(routine).contains(key) {
            return self.own.entry(&routine.name.key).or_default().insert(key);
        }
        let is_constant = file.data.get(key).is_some_and(|own| own.is_constant);
        !is_constant && self.data.insert(key)
    }

    fn is_own(&self, routine: &Routine, key: &str) -> bool {
        self.own.get(routine.name.key.as_str()).is_some_and(|own| own.contains(key))
    }

    /// Whether handlers set what a routine knows by this name.
    fn is_in(&self, routine: &Routine, key: &str) -> bool {
        match own_names(routine).contains(key) {
            true => self.is_own(routine, key),
            false => self.data.contains(key),
        }
    }
}

impl<'a> Interpreter<'a> {
    /// Whether a handler of errors sets a datum, or a function gives what one says.
    pub(super) fn is_by_handlers(&self, key: &str) -> bool {
        let handled = self.handled.get_or_init(|| Handled::of(self.file, self.running.first()));
        let is_set = match (self.is_local(key), self.running.last()) {
            (true, Some(routine)) => handled.is_own(routine, key),
            _ => handled.data.contains(key),
        };
        is_set || handled.functions.contains(key)
    }
}
