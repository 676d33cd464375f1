//! What of a text a reader has not read. Signals and procedures that set the spindle or the tool by
//! the job's word, where the program names them and the reader has made nothing of it: triggers,
//! interrupts, branches that only the run decides. Moves behind the end of the program or of a
//! routine. Blocks that may be skipped.

use std::collections::HashSet;

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
    warn_of_lines_naming(&names.collect::<Vec<_>>(), text, dialect, log);
}

/// Warns of every line of code that names one of these, in lower case, and has set nothing.
pub(super) fn warn_of_lines_naming(names: &[String], text: &str, dialect: Dialect, log: &mut Log) {
    if names.is_empty() {
        return;
    }
    for (index, whole) in text.lines().enumerate() {
        let line = index + 1;
        let code = code_of(whole, dialect).to_lowercase();
        if is_definition(&code, dialect) || log.has_set(line) {
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

/// A line without its comment.
fn code_of(line: &str, dialect: Dialect) -> &str {
    let mark = if dialect == Dialect::Krl { ';' } else { '!' };
    let end = line.find(mark).unwrap_or(line.len());
    line.get(..end).unwrap_or(line)
}

/// The head of the procedure itself, or a declaration.
fn is_definition(code: &str, dialect: Dialect) -> bool {
    let mut words = code.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let first: Vec<&str> = words.by_ref().take(3).collect();
    first.iter().any(|word| matches!(*word, "proc" | "func" | "def" | "deffct"))
        || first.first().is_some_and(|word| matches!(*word, "var" | "pers"))
        // `GLOBAL SIGNAL SPIN $ANOUT[1]`.
        || dialect == Dialect::Krl
            && code.split_whitespace().find(|word| *word != "global") == Some("signal")
}

/// Whether a name stands in a line as a word of its own; an output of TP also where a register
/// gives its number.
fn is_named(code: &str, name: &str, dialect: Dialect) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '$';
    let own = code.match_indices(name).any(|(at, _)| {
        let before = code.get(..at).and_then(|head| head.chars().next_back());
        let behind = code.get(at + name.len()..).and_then(|tail| tail.chars().next());
        // `ao[1]` ends by its bracket.
        let ends = name.ends_with(']') || !behind.is_some_and(is_part);
        ends && !before.is_some_and(is_part)
    });
    let list = name.split('[').next().unwrap_or(name);
    let by_register =
        dialect == Dialect::Fanuc && name.ends_with(']') && code.contains(&format!("{list}[r["));
    // `ao[1:speed]` is AO[1].
    let with_comment =
        name.strip_suffix(']').is_some_and(|head| code.contains(&format!("{head}:")));
    own || by_register || with_comment
}
