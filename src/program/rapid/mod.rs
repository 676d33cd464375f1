//! RAPID → motions: tokens, syntax tree, and an interpreter that runs the program from its first
//! instruction as the controller would, as far as that is known before the run.
//!
//! Read: data of all types with records and arrays, expressions and functions on them, procedures
//! and functions with arguments, IF, FOR, WHILE, TEST, `VelSet`, the Move and Trigg instructions.
//! An endless loop (`WHILE TRUE`) is read once, with a notice. Error handlers, traps and zones are
//! left out. A robtarget's configuration counts where the program monitors it: real programs carry
//! arbitrary ones under `ConfL \Off`. The world frame is taken to be the base frame.

mod active;
mod assumed;
mod bits;
mod by_name;
mod calls;
mod carried;
mod constants;
mod cursor;
mod cycles;
mod effect;
mod ends;
mod eval;
mod faults;
mod filled;
mod frames;
mod functions;
mod handlers;
mod hints;
mod instructions;
mod interpreter;
mod late;
mod lexer;
mod load;
mod loaded;
mod loops;
mod modules;
mod moves;
mod number;
mod offered;
mod operators;
mod outputs;
mod own_frame;
mod parser;
mod run;
mod set_by;
mod sets;
mod shared;
mod stops;
mod synced;
mod syntax;
mod texts;
mod timed;
mod traps;
mod twice;
mod undeclared;
mod units;
mod value;
mod walk;
mod why;

use std::collections::HashSet;
use std::ops::RangeInclusive;

use super::cell::Comments;
use super::log::Log;
use super::{Dialect, Settings, unread};
use crate::notes::Code;
use interpreter::Interpreter;
use syntax::{Args, File, Routine};

/// Reads a RAPID file into the log.
pub(super) fn read(text: &str, settings: &Settings, log: &mut Log) {
    let file = parser::parse(text, settings, log);
    let arguments = match parser::arguments(&settings.arguments) {
        Ok(arguments) => Args { positional: arguments, optional: Vec::new() },
        Err(what) => {
            log.error(Code::Value, 1, format!("path.program.arguments: {what}"));
            return;
        }
    };
    match entry(&file, settings, log) {
        Ok(routine) => {
            let comments = Comments::of(text, '!', settings);
            comments.tell('!', settings, log);
            let mut interpreter = Interpreter::new(&file, settings, comments, log);
            interpreter.given_on = set_by::given_on(&file, settings);
            interpreter.setter_outputs = set_by::setter_outputs(&file, settings);
            let reached = walk::reached(&file, routine);
            interpreter.stands_for = walk::undeclared_frames(&file, reached.as_ref());
            interpreter.run(routine, &arguments);
            let mut idle = idle(&file, reached.as_ref(), log);
            idle.extend(handlers::last_lines(&file, routine));
            unread::setters(text, Dialect::Rapid, settings, &idle, log);
        }
        // What was not read may have it.
        Err(_) if log.has_errors() => {}
        Err(what) => log.error(Code::Reference, 1, what),
    }
}

/// The lines of procedures that nothing calls. Where the program moves before it has set the
/// spindle none count: another may have set it.
fn idle(file: &File, reached: Option<&HashSet<&str>>, log: &Log) -> Vec<RangeInclusive<usize>> {
    let Some(reached) = reached.filter(|_| log.starts_under_speed()) else {
        return Vec::new();
    };
    let idle = file.procedures.iter().filter(|(key, _)| !reached.contains(key.as_str()));
    idle.map(|(_, routine)| routine.line..=routine.end).filter(|own| *own.start() > 0).collect()
}

/// The procedure to start with.
fn entry<'a>(file: &'a File, settings: &Settings, log: &mut Log) -> Result<&'a Routine, String> {
    let startable = || {
        file.procedure_order.iter().filter_map(|key| file.procedures.get(key)).filter(|routine| {
            let wanted = routine.parameters.iter().filter(|parameter| !parameter.optional);
            wanted.count() == settings.arguments.len()
        })
    };
    let all = || {
        let names: Vec<_> =
            startable().map(|routine| format!("'{}'", routine.name.shown)).take(10).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    };
    let wanted = settings.procedure.as_deref().unwrap_or("main");
    let found = startable().find(|routine| routine.name.key == wanted.to_lowercase());
    if let Some(routine) = found {
        return Ok(routine);
    }
    if settings.procedure.is_some() {
        let own = file.procedures.get(&wanted.to_lowercase());
        if let Some(routine) = own {
            let wanted = routine.parameters.iter().filter(|parameter| !parameter.optional);
            let names: Vec<&str> = wanted.map(|parameter| parameter.name.shown.as_str()).collect();
            return Err(format!(
                "procedure '{}' takes {}; give path.program.arguments: [{}] in the job",
                routine.name.shown,
                names.join(", "),
                vec!["…"; names.len()].join(", ")
            ));
        }
        return Err(format!(
            "no procedure '{wanted}' without arguments in this file; there are: {}",
            all()
        ));
    }
    match (startable().next(), startable().nth(1)) {
        (Some(only), None) => {
            let what = format!("no procedure 'main'; '{}' is read instead", only.name.shown);
            log.warning(Code::Assumed, only.line, what);
            Ok(only)
        }
        (None, _) => Err("no procedure without arguments in this file".to_owned()),
        (Some(_), Some(_)) => Err(format!("no procedure 'main'; name one of: {}", all())),
    }
}
