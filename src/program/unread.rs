//! What of a text a reader has not read. Signals and procedures that set the spindle or the tool by
//! the job's word, where the program names them and the reader has made nothing of it: triggers,
//! interrupts, branches that only the run decides. Moves behind the end of the program or of a
//! routine. Blocks that may be skipped.

use std::collections::{HashMap, HashSet};

use super::cell::all;
use super::log::Log;
use super::{Dialect, Setter, Settings};
use crate::notes::Code;

/// Warns of every line of code that names such a signal or procedure and has set nothing.
pub(super) fn setters(text: &str, dialect: Dialect, settings: &Settings, log: &mut Log) {
    let names = all(settings).filter_map(|(_, by)| match &by.what {
        Setter::Signal(name) | Setter::Procedure(name, _) => Some(name.to_lowercase()),
        Setter::Comment(_) => None,
    });
    let names: Vec<String> = names.collect();
    let idle = match dialect {
        Dialect::Rapid if !names.is_empty() && settings.companions.is_empty() => {
            idle(text, log.entry())
        }
        _ => HashSet::new(),
    };
    warn_of_lines(&names, text, (dialect, &idle), log);
}

/// Warns of every line of code that names one of these, in lower case, and has set nothing.
pub(super) fn warn_of_lines_naming(names: &[String], text: &str, dialect: Dialect, log: &mut Log) {
    warn_of_lines(names, text, (dialect, &HashSet::new()), log);
}

/// The same but for procedures that are `idle`.
fn warn_of_lines(
    names: &[String],
    text: &str,
    (dialect, idle): (Dialect, &HashSet<String>),
    log: &mut Log,
) {
    if names.is_empty() {
        return;
    }
    let mut is_idle = false;
    for (index, whole) in text.lines().enumerate() {
        let line = index + 1;
        let code = code_of(whole, dialect).to_lowercase();
        if dialect == Dialect::Rapid {
            is_idle = procedure_of(&code).map_or(is_idle, |name| idle.contains(name));
        }
        if is_idle || is_definition(&code, dialect) || log.has_set(line) {
            continue;
        }
        if let Some(name) = names.iter().find(|name| is_named(&code, name, dialect)) {
            let what = format!(
                "'{name}' stands here, and nothing that it sets is read: the run decides whether \
                 and when it is done"
            );
            log.warning(Code::SpindleCommand, line, what);
        }
    }
}

/// Warns of moves at a line behind the end of the program.
pub(super) fn behind_end(log: &mut Log, line: usize) {
    let what = "moves stand here, behind the end of the program, and nothing calls them: \
                they are not read";
    log.warning(Code::MotionLeftOut, line, what);
}

/// Warns of blocks that the operator may have skipped, the first at this line.
pub(super) fn read_as_run(log: &mut Log, line: usize) {
    let what = "blocks with '/' are read as if they ran: with block skip on the program is \
                another, which is not looked at";
    log.warning(Code::MotionLeftOut, line, what);
}

/// Warns of moves at a line behind a statement that ends the routine or the program there in any
/// case.
pub(super) fn behind(log: &mut Log, line: usize, end: &str) {
    let what = format!("moves stand here, behind {end}: they are not read");
    log.warning(Code::MotionLeftOut, line, what);
}

/// The blocks from `end` on that have not run, but for those of a subprogram of which any has.
pub(super) fn left_over(ran: &[bool], end: usize, heads: &HashSet<usize>) -> Vec<usize> {
    let (mut left, mut of_head, mut is_called) = (Vec::new(), Vec::new(), false);
    for (block, ran) in ran.iter().enumerate().skip(end) {
        if heads.contains(&block) {
            left.append(&mut of_head);
            is_called = false;
        }
        is_called |= ran;
        of_head.push(block);
        if is_called {
            of_head.clear();
        }
    }
    left.append(&mut of_head);
    left
}

/// A line without its comment and what stands between quotes.
fn code_of(line: &str, dialect: Dialect) -> String {
    let mark = if dialect == Dialect::Krl { ';' } else { '!' };
    let mut in_text = false;
    let code = line.chars().take_while(|c| {
        in_text ^= *c == '"';
        in_text || *c != mark
    });
    let mut in_text = false;
    code.filter(|c| {
        in_text ^= *c == '"';
        !in_text
    })
    .collect()
}

/// The procedures of RAPID, in lower case, that neither the first one nor a trap names, directly or
/// by others; none where a name may be worked out.
fn idle(text: &str, entry: &str) -> HashSet<String> {
    let mut named: HashMap<String, HashSet<String>> = HashMap::new();
    let mut current = String::new();
    for line in text.lines() {
        let code = code_of(line, Dialect::Rapid).to_lowercase();
        if code.starts_with("%%%") {
            continue;
        }
        if code.contains('%') || code.contains("callbyvar") {
            return HashSet::new();
        }
        let begun = procedure_of(&code);
        if let Some(name) = begun {
            name.clone_into(&mut current);
            named.entry(current.clone()).or_default();
            continue;
        }
        let words = code.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        named.entry(current.clone()).or_default().extend(words.map(str::to_owned));
    }
    // Outside of procedures: functions and traps.
    let mut open = vec![String::new(), entry.to_owned()];
    while let Some(name) = open.pop() {
        let found = named.remove(&name).unwrap_or_default();
        open.extend(found.into_iter().filter(|word| named.contains_key(word)));
    }
    named.into_keys().collect()
}

/// The first procedure of RAPID that nothing runs and that names a datum, and the line.
pub(super) fn used_in_idle(text: &str, entry: &str, name: &str) -> Option<(String, usize)> {
    let (idle, name) = (idle(text, entry), name.to_lowercase());
    let mut current = String::new();
    for (index, line) in text.lines().enumerate() {
        let code = code_of(line, Dialect::Rapid).to_lowercase();
        if let Some(begun) = procedure_of(&code) {
            begun.clone_into(&mut current);
        }
        let mut words = code.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        if idle.contains(&current) && words.any(|word| word == name) {
            return Some((current, index + 1));
        }
    }
    None
}

/// The procedure that a line of RAPID begins or, without a name, ends.
fn procedure_of(code: &str) -> Option<&str> {
    let mut words = code.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    match words.by_ref().find(|word| !matches!(*word, "" | "local"))? {
        "proc" => words.find(|word| !word.is_empty()),
        "endproc" => Some(""),
        _ => None,
    }
}

/// The head of the procedure itself, or a declaration.
fn is_definition(code: &str, dialect: Dialect) -> bool {
    let mut words = code.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let first: Vec<&str> = words.by_ref().take(3).collect();
    let begins = |known: &[&str]| {
        let own = first.iter().find(|word| !matches!(**word, "local" | "task" | "global"));
        own.is_some_and(|word| known.contains(word))
    };
    first.iter().any(|word| matches!(*word, "proc" | "func" | "def" | "deffct"))
        || match dialect {
            // `12: WAIT R[1]`.
            Dialect::Fanuc => first.iter().take(2).any(|word| *word == "wait"),
            Dialect::Rapid => begins(&["var", "pers", "const"]),
            // `GLOBAL SIGNAL SPIN $ANOUT[1]`, `DECL INT RPM`.
            Dialect::Krl => begins(&["signal", "decl", "int", "real", "bool", "char"]),
            _ => false,
        }
}

/// Whether what stands on both sides of a name says that it is read there and no more: an operator
/// of arithmetic or of a comparison, or the sign behind which a value stands.
fn is_read(before: &str, behind: &str, dialect: Dialect) -> bool {
    let (before, behind) = (before.trim_end(), behind.trim_start());
    let computes = |c: char| matches!(c, '+' | '-' | '*' | '/' | '<' | '>');
    // In KRL and TP `=` behind a name may set it.
    let compares = behind.starts_with("==") || dialect == Dialect::Rapid && behind.starts_with('=');
    if behind.starts_with(computes) || compares || before.ends_with(computes) {
        return true;
    }
    // `\AOp:=aoSpindle` names an output.
    let head = before.trim_end_matches([':', '=']).trim_end();
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    before.ends_with('=') && !head.trim_end_matches(is_name).ends_with('\\')
}

/// Whether a name stands in a line as a word of its own, where it is more than read; an output of
/// TP also where a register gives its number.
fn is_named(code: &str, name: &str, dialect: Dialect) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '$';
    let own = code.match_indices(name).any(|(at, _)| {
        let (before, behind) = code.split_at(at);
        let behind = behind.get(name.len()..).unwrap_or("");
        // `ao[1]` ends by its bracket.
        let ends = name.ends_with(']') || !behind.starts_with(is_part);
        ends && !before.ends_with(is_part) && !is_read(before, behind, dialect)
    });
    let list = name.split('[').next().unwrap_or(name);
    let by_register =
        dialect == Dialect::Fanuc && name.ends_with(']') && code.contains(&format!("{list}[r["));
    // `ao[1:speed]` is AO[1].
    let with_comment =
        name.strip_suffix(']').is_some_and(|head| code.contains(&format!("{head}:")));
    own || by_register || with_comment
}
