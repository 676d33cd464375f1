//! Names that are declared twice.

use super::syntax::{Declaration, Expr, Routine};
use super::walk::same_literal;
use crate::notes::Code;
use crate::program::log::Log;

/// What helps where two tasks declare a datum.
const OF_TASKS: &str = ": PERS data that tasks share have one type and one value; give the value \
                        in one file alone";

/// What helps where parts of the program share a name.
const OF_PARTS: &str = ": of parts that are loaded one after the other, declare it LOCAL in each, \
                        call %\"module:name\"%, or check each part in an operation of its own";

/// What helps, by whether the program loads parts, and whether the datum is of several tasks.
pub(super) fn help(loads: bool, is_of_tasks: bool) -> &'static str {
    match (loads, is_of_tasks) {
        (true, _) => OF_PARTS,
        (false, true) => OF_TASKS,
        (false, false) => "",
    }
}

/// Tells of a name, by the lines of its declarations in the main file and their places in others.
pub(super) fn tell(
    shown: &str,
    [(first_line, first), (line, here)]: [(usize, Option<String>); 2],
    help: &str,
    log: &mut Log,
) {
    let (at, head, other) = match (first, here) {
        (None, None) => (line, String::new(), format!("line {first_line}")),
        (None, Some(here)) => (first_line, String::new(), here),
        (Some(first), None) => (line, String::new(), first),
        (Some(first), Some(here)) => (1, format!("{here}: "), first),
    };
    let what = format!("{head}{shown} is declared twice, here and at {other}{help}");
    log.error(Code::Conflict, at.max(1), what);
}

/// Tells of a routine in whose place another has stood.
pub(super) fn tell_routines(kind: &str, both: [Option<&Routine>; 2], help: &str, log: &mut Log) {
    let [Some(first), Some(second)] = both else { return };
    let place = |own: &Routine| {
        let there = own.there.as_ref();
        (own.line, there.map(|(file, line)| format!("{file}:{line}")))
    };
    let shown = format!("{kind} '{}'", second.name.shown);
    tell(&shown, [place(first), place(second)], help, log);
}

/// Whether two declarations are of the datum that two tasks share: of the same type, with the same
/// value, or with a value in one of them.
pub(super) fn is_of_both(first: &Declaration, second: &Declaration) -> bool {
    let both = [first, second];
    let sizes = both.map(|own| {
        let sizes = own.dimensions.iter().map(|size| match size {
            Expr::Number(number, _) => Some(*number),
            _ => None,
        });
        sizes.collect::<Vec<_>>()
    });
    let is_same = match (&first.value, &second.value) {
        (Some(first), Some(second)) => same_literal(first, second),
        _ => true,
    };
    both.iter().all(|own| own.is_persistent && !own.is_of_task)
        && is_same
        // Of the main file both would be one task's.
        && both.iter().any(|own| own.line == 0)
        && first.kind == second.kind
        && sizes[0] == sizes[1]
}
