//! What others decide: persistent data that no file sets, and what the next cycle finds.

use std::collections::{HashMap, HashSet};

use super::effect::{Effect, STAND_FOR};
use super::filled::filled;
use super::instructions::is_ignored;
use super::interpreter::Interpreter;
use super::outputs::WHOLE;
use super::sets::set_within;
use super::syntax::{Block, Expr, File, Name, Optional, Path, Routine, Statement, What};
use super::walk::{
    blocks_in, expressions_in, functions_in, functions_of, names_in, reached_from, statements_in,
};
use crate::notes::Code;

/// What helps where `assume` cannot.
const CONST: &str = "declare it CONST in a copy of the program, with the value that it has then";

impl<'a> Interpreter<'a> {
    /// Of branches that move, leave the routine, or set what later moves need, and of which data
    /// decide that only others set, or that handlers of errors set, too.
    pub(super) fn doubt_shared(
        &mut self,
        line: usize,
        keyword: &str,
        conditions: Vec<&'a Expr>,
        blocks: Vec<&'a Block>,
    ) {
        // A loop asks often.
        let place = conditions.first().map(|first| std::ptr::from_ref(*first));
        if place.is_none_or(|place| !self.asked_of_others.insert(place)) {
            return;
        }
        let asked = functions_of(conditions.clone());
        let names = names_in(conditions);
        let is_by_others = |name: &&Name| {
            self.set_by_others.contains(name.key.as_str())
                && !self.is_local(&name.key)
                && !(self.is_single(&name.key) && self.assumed(&name.key).is_some())
        };
        let others = names.iter().copied().find(is_by_others);
        let handled = || {
            let all = names.into_iter().chain(asked.into_iter().map(|(name, _)| name));
            all.into_iter().find(|name| self.is_by_handlers(&name.key))
        };
        let Some(name) = others.or_else(handled) else { return };
        let all: Effect<'a> =
            blocks.iter().map(|block| self.effect(block, false, &mut HashSet::new())).collect();
        let decided = match all {
            Effect::Motion => "which moves are read".to_owned(),
            Effect::Data(set) => match set.into_iter().find(|own| self.is_of_motion(own)) {
                Some(own) => format!("what '{}' is", own.shown),
                None => return,
            },
        };
        let (shown, key) = (&name.shown, name.shown.to_lowercase());
        let what = match others {
            Some(_) => {
                let help = match self.is_single(&name.key) {
                    true => format!("assume: {{{key}: …}} in the job can settle it"),
                    false => format!("{WHOLE}: {CONST}"),
                };
                self.decided_by.insert(shown);
                format!(
                    "{keyword} asks for '{shown}', which is PERS and which no file that is read \
                     sets: the value of its declaration decides {decided}; {help}"
                )
            }
            None => format!(
                "{keyword} asks for '{shown}', which a handler of errors sets or answers for, and \
                 those are not read: its value where no error comes decides {decided}"
            ),
        };
        self.log.warning(Code::MotionLeftOut, line, what);
    }

    /// More statements run than any program has, which what others set may end.
    pub(super) fn runs_too_long(&mut self, line: usize) {
        if self.decided_by.is_empty() {
            return self.log.runs_too_long(line);
        }
        let all: Vec<&str> = self.decided_by.iter().copied().collect();
        let mut singles = all.iter().filter(|own| self.is_single(&own.to_lowercase()));
        let help = match singles.next() {
            Some(own) => format!("assume: {{\"{own}\": …}} in the job gives another value"),
            None => format!("{WHOLE}: {CONST}"),
        };
        let what = format!(
            "the program runs too long here: a loop without an end, or one that ends by what \
             another task sets; of '{}', PERS that no file that is read sets, the declaration \
             counts: {help}",
            all.join("', '")
        );
        self.log.error(Code::TooLong, line, what);
    }

    /// Data that two tasks share, and that procedures set to which the program does not lead: the
    /// other task sets them, at any time.
    pub(super) fn heed_other_tasks(&mut self, entry: &'a Routine) {
        let file = self.file;
        if file.shared.is_empty() {
            return;
        }
        let mut from = vec![entry.name.key.as_str()];
        // The `main` of another file is the other task's.
        let is_own = |own: &Routine| own.line > 0;
        from.extend(file.procedures.get("main").filter(|own| is_own(own)).map(|_| "main"));
        let reached = reached_from(file, from);
        for (key, routine) in &file.procedures {
            let is_reached = match &reached {
                Some(reached) => reached.contains(key.as_str()),
                None => std::ptr::eq(routine, entry),
            };
            if is_reached {
                continue;
            }
            let mut set: HashSet<&str> = HashSet::new();
            set.extend(set_within(file, &routine.body).into_iter().map(|own| own.key.as_str()));
            let is_set = |own: &String| set.contains(own.as_str());
            let may_be = |own: &&String| is_set(own) || routine.in_handlers.contains(*own);
            for data in file.shared.iter().filter(may_be).filter_map(|own| file.data.get(own)) {
                self.set_beside.insert(&data.name.key);
                self.set_at_any_time(&data.name, "another task sets it");
            }
        }
    }

    /// Whether motion may depend on a datum, or on what an instruction of this name sets.
    fn is_of_motion(&self, name: &Name) -> bool {
        let key = name.key.as_str();
        self.of_motion().contains(key) || STAND_FOR.contains(&key)
    }

    /// The data on which motion may depend.
    pub(super) fn of_motion(&self) -> &HashSet<&'a str> {
        self.of_motion.get_or_init(|| of_motion(self.file))
    }

    /// `ExitCycle` in a branch runs `main` again with the data of the modules as they are: another
    /// branch may run then, or what stands behind it.
    pub(super) fn doubt_next_cycle(&mut self, end: &'a Statement, rest: &'a [Statement]) {
        let is_exit = |what: &What| matches!(what, What::Call(name, _) if name.key == "exitcycle");
        let other = |block: &&'a Block| !statements_in(std::iter::once(*block)).any(is_exit);
        let branches = match &end.what {
            What::If(..) | What::Test(..) | What::CallByName(..) => blocks_in(&end.what),
            _ => Vec::new(),
        };
        let others = branches.into_iter().filter(other).flatten();
        let first = others.chain(rest).find(|statement| self.moves(&statement.what));
        if let Some(first) = first {
            let line = if first.line > 0 { first.line } else { self.line };
            let what = "ExitCycle starts the program again before this: what the next cycle does \
                        is not read";
            self.log.warning(Code::MotionLeftOut, line, what);
        }
    }
}

/// The names of data on which motion, outputs, or which statements run may depend. Data of one name
/// in several routines count as one.
fn of_motion(file: &File) -> HashSet<&str> {
    let mut open: Vec<&str> = Vec::new();
    // What a datum is worked out of.
    let mut sources: HashMap<&str, Vec<&str>> = HashMap::new();
    for (key, data) in &file.data {
        sources.entry(key).or_default().extend(keys_in(data.value.iter().collect()));
    }
    let routines = file.procedures.values().chain(file.functions.values());
    let bodies = routines.map(|own| &own.body).chain(file.traps.iter().map(|trap| &trap.body));
    for what in statements_in(bodies) {
        let used = keys_in(expressions_in(what));
        for own in set_in(what, file) {
            sources.entry(&own.key).or_default().extend(used.iter().copied());
        }
        match what {
            What::Declare(own) => sources.entry(&own.name.key).or_default().extend(used),
            What::Call(name, args) => match file.procedures.get(&name.key) {
                Some(own) => {
                    let required = own.parameters.iter().filter(|own| !own.optional);
                    for (parameter, given) in required.zip(&args.positional) {
                        let (own, given) = (parameter.name.key.as_str(), keys_in(vec![given]));
                        if parameter.by_reference {
                            given.iter().for_each(|key| sources.entry(key).or_default().push(own));
                        }
                        sources.entry(own).or_default().extend(given);
                    }
                    open.extend(args.optional.iter().flat_map(|(_, value)| match value {
                        Optional::Value(value) => keys_in(vec![value]),
                        _ => Vec::new(),
                    }));
                }
                // A signal is no datum.
                None if sets_output(&name.key) => {
                    open.extend(keys_in(args.positional.iter().skip(1).collect()));
                }
                None if acts(&name.key) => open.extend(used),
                None => {}
            },
            What::Return(_) => open.extend(used),
            _ if statements_in(blocks_in(what).into_iter()).any(decides) => open.extend(used),
            // Blocks that only set data.
            _ => {
                let inside = statements_in(blocks_in(what).into_iter());
                for own in inside.flat_map(|inner| set_in(inner, file)) {
                    sources.entry(&own.key).or_default().extend(used.iter().copied());
                }
            }
        }
    }
    let mut found = HashSet::new();
    while let Some(key) = open.pop() {
        if found.insert(key) {
            open.extend(sources.get(key).into_iter().flatten());
        }
    }
    found
}

/// The data that a statement may set: assigned, counted, filled in. What procedures of the files do
/// is told by their own statements.
fn set_in<'a>(what: &'a What, file: &File) -> Vec<&'a Name> {
    let functions = functions_in(what).into_iter();
    let mut found: Vec<&Path> = functions.flat_map(|(name, args)| filled(name, args)).collect();
    match what {
        What::Assign(path, _) => found.push(path),
        What::Call(name, args) if !file.procedures.contains_key(&name.key) => {
            found.extend(filled(name, args));
            found.extend(args.positional.iter().filter_map(|arg| match arg {
                Expr::Ref(path) => Some(&**path),
                _ => None,
            }));
        }
        _ => {}
    }
    found.into_iter().map(|path| &path.name).collect()
}

fn keys_in(open: Vec<&Expr>) -> Vec<&str> {
    names_in(open).into_iter().map(|name| name.key.as_str()).collect()
}

/// Whether an instruction that no file declares moves, or sets outputs.
pub(super) fn acts(key: &str) -> bool {
    !is_ignored(key) || sets_output(key)
}

fn sets_output(key: &str) -> bool {
    is_ignored(key) && (key.starts_with("set") || key.starts_with("trigg"))
}

/// Whether a statement in a branch makes its condition one of motion.
fn decides(what: &What) -> bool {
    match what {
        What::Call(name, _) => acts(&name.key),
        What::Return(_) | What::Goto(_) | What::NotUnderstood(_) => true,
        _ => false,
    }
}
