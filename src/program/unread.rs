//! What of a text a reader has not read. Signals and procedures that set the spindle or the tool by
//! the job's word, where the program names them and the reader has made nothing of it: triggers,
//! interrupts, branches that only the run decides. Moves behind the end of the program or of a
//! routine. Blocks that may be skipped.

use std::collections::HashSet;
use std::ops::RangeInclusive;

use super::cell::all;
use super::log::Log;
use super::{Dialect, Setter, Settings};
use crate::notes::Code;

/// Warns of every line of code that names such a signal or procedure and has set nothing, but for
/// lines of what does not run.
pub(super) fn setters(
    text: &str,
    dialect: Dialect,
    settings: &Settings,
    idle: &[RangeInclusive<usize>],
    log: &mut Log,
) {
    let names = all(settings).filter_map(|(_, by)| match &by.what {
        Setter::Signal(name) | Setter::Procedure(name, _) => Some(name.to_lowercase()),
        Setter::Comment(_) => None,
    });
    warn_of_lines(&names.collect::<Vec<_>>(), text, (dialect, idle), log);
}

/// What is said where data are read that a refused block would have set.
pub(super) fn read_of_lost(shown: &str) -> String {
    format!("{shown} is read, and the block that would set it is refused")
}

/// Warns of every line of code that names one of these, in lower case, and has set nothing.
pub(super) fn warn_of_lines_naming(names: &[String], text: &str, dialect: Dialect, log: &mut Log) {
    warn_of_lines(names, text, (dialect, &[]), log);
}

fn warn_of_lines(
    names: &[String],
    text: &str,
    (dialect, idle): (Dialect, &[RangeInclusive<usize>]),
    log: &mut Log,
) {
    if names.is_empty() {
        return;
    }
    for (index, whole) in text.lines().enumerate() {
        let line = index + 1;
        let code = code_of(whole, dialect, names);
        let is_idle = idle.iter().any(|own| own.contains(&line));
        if is_idle || is_definition(&code, dialect) {
            continue;
        }
        // Beside a statement that has set it, a move that sets it stands in the same line.
        let with_moves = match log.has_set(line) {
            true if dialect == Dialect::Rapid => moves_that_set(&code),
            true => continue,
            false => code,
        };
        if let Some(name) = names.iter().find(|name| is_named(&with_moves, name, dialect)) {
            let what = format!(
                "'{name}' stands here, and nothing that it sets is read: the run decides whether \
                 and when it is done"
            );
            log.warning(Code::SpindleCommand, line, what);
        }
    }
}

/// The statements of a line of RAPID, in lower case, that set an output while the arm moves.
fn moves_that_set(code: &str) -> String {
    let sets = |word: &str| {
        let of_output = ["do", "go", "ao"].iter().any(|kind| word.ends_with(kind));
        word.starts_with("trigg") || word.starts_with("move") && of_output
    };
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let own = code.split(';').filter(|own| own.split(|c| !is_part(c)).any(sets));
    own.collect::<Vec<_>>().join(";")
}

/// Whether a line names a parameter: letter case does not count.
pub(super) fn names(line: &str, parameter: &str) -> bool {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let (line, parameter) = (line.to_lowercase(), parameter.to_lowercase());
    line.split(&parameter).skip(1).any(|rest| !rest.starts_with(is_part))
}

/// Tells of what the job assumes in vain, where it stands in the program; `others` says what may be
/// assumed, where this may not.
pub(super) fn tell_unheeded(log: &mut Log, line: usize, parameter: &str, others: Option<&str>) {
    let why = others.unwrap_or("the program sets it before it reads it");
    let what = format!("the job assumes '{parameter}', which has no effect on this program: {why}");
    log.warning(Code::Unused, line, what);
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

/// What stands before and behind a name wherever it is a word of its own; `r[1]` also as
/// `r[1:comment]`.
fn stands_alone<'c>(code: &'c str, name: &'c str) -> impl Iterator<Item = (&'c str, &'c str)> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '$';
    let head = name.strip_suffix(']').unwrap_or(name);
    code.match_indices(head).filter_map(move |(at, _)| {
        let (before, behind) = code.split_at(at);
        let behind = behind.get(head.len()..).unwrap_or("");
        let behind = match name.ends_with(']') {
            true => behind.starts_with([']', ':']).then(|| behind.split_once(']'))??.1,
            false => Some(behind).filter(|behind| !behind.starts_with(is_part))?,
        };
        (!before.ends_with(is_part)).then_some((before, behind))
    })
}

/// A line in lower case without its comment, and in RAPID and KRL without texts, unless they are
/// one of the names.
pub(super) fn code_of(line: &str, dialect: Dialect, names: &[String]) -> String {
    let mark = if dialect == Dialect::Krl { ';' } else { '!' };
    let has_texts = dialect != Dialect::Fanuc;
    let mut code = String::with_capacity(line.len());
    let mut parts = line.split('"').map(str::to_lowercase);
    let mut in_text = false;
    loop {
        let Some(part) = parts.next() else { return code };
        if in_text && has_texts {
            if names.contains(&part) {
                code.push_str(&part);
            }
        } else if let Some((head, _)) = part.split_once(mark) {
            code.push_str(head);
            return code;
        } else {
            code.push_str(&part);
        }
        code.push('"');
        in_text = !in_text;
    }
}

/// The head of the procedure itself, or a declaration.
pub(super) fn is_definition(code: &str, dialect: Dialect) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let mut words = code.split(|c| !is_part(c)).filter(|word| !word.is_empty());
    let first: Vec<&str> = words.by_ref().take(3).collect();
    let begins = |known: &[&str]| {
        let own = first.iter().find(|word| !matches!(**word, "local" | "task" | "global"));
        own.is_some_and(|word| known.contains(word))
    };
    first.iter().any(|word| matches!(*word, "proc" | "func" | "def" | "deffct"))
        || match dialect {
            Dialect::Rapid => begins(&["var", "pers", "const"]),
            // `GLOBAL SIGNAL SPIN $ANOUT[1]`, `DECL INT RPM`.
            Dialect::Krl => {
                begins(&["signal"])
                    || begins(&["decl", "int", "real", "bool", "char"]) && !code.contains('=')
            }
            // `12: WAIT R[1]`.
            Dialect::Fanuc => first.iter().take(2).any(|word| *word == "wait"),
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
    let is_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | ']' | '}');
    before.ends_with('=')
        && head.ends_with(is_name)
        && !head.trim_end_matches(is_name).ends_with('\\')
}

/// Whether a name stands in a line as a word of its own, where it is more than read; an output of
/// TP also where a register gives its number.
fn is_named(code: &str, name: &str, dialect: Dialect) -> bool {
    let mut alone = stands_alone(code, name);
    let own = alone.any(|(before, behind)| !is_read(before, behind, dialect));
    let list = name.split('[').next().unwrap_or(name);
    let by_register =
        dialect == Dialect::Fanuc && name.ends_with(']') && code.contains(&format!("{list}[r["));
    own || by_register
}
