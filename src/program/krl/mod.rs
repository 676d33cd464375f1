//! KUKA KRL (.src with .dat) → motions: lines, tokens, syntax tree, and an interpreter that runs
//! the program as the controller would, as far as that is known before the run.
//!
//! Read: data lists, positions with components left out, PTP, LIN, CIRC and their relatives, SPLINE
//! with its segments, inline forms with BAS, frames of $CONFIG.DAT where the job names the file,
//! expressions, functions, IF, FOR, WHILE, REPEAT, SWITCH, GOTO, WAIT SEC. T of a position counts
//! on PTP; S is left out. The world frame is taken to be the base frame.

mod calls;
mod counters;
mod cursor;
mod dataflow;
mod eval;
mod forms;
mod frames;
mod hints;
mod interrupts;
mod lexer;
mod lines;
mod modules;
mod moves;
mod open;
mod operators;
mod orientation;
mod pace;
mod parser;
mod passes;
mod rests;
mod run;
mod shares;
mod signals;
mod syntax;
mod targets;
mod turns;
mod unmoved;
mod value;
mod walk;
mod words;

use super::cell::{Comments, named_by_job};
use super::log::Log;
use super::unread::warn_of_lines_naming;
use super::{Dialect, Settings};
use crate::notes::Code;
use run::Run;
use syntax::{File, Routine};

/// Reads a KRL file, with the others that the job names, into the log.
pub(super) fn read(text: &str, settings: &Settings, log: &mut Log) {
    let mut file = File::default();
    let others = settings.companions.iter().map(|companion| &*companion.text);
    let texts: Vec<&str> = std::iter::once(text).chain(others).collect();
    file.for_all = modules::for_all(&texts);
    let renamed = modules::renamed(&texts, &named_by_job(settings));
    let names = |number: usize| renamed.get(number).cloned().unwrap_or_default();
    parser::parse(text, &mut file, 0, &names(0));
    if let Some(line) = file.is_cut {
        let what = "the routine that begins here has no END: is the file whole?";
        log.error(Code::Syntax, line, what);
        return;
    }
    let own = std::mem::take(&mut file.data);
    for (index, companion) in settings.companions.iter().enumerate() {
        parser::parse(&companion.text, &mut file, index + 1, &names(index + 1));
        if file.is_cut.take().is_some() {
            let what = format!("{} ends within a routine: is the file whole?", companion.name);
            log.error(Code::Syntax, 1, what);
            return;
        }
    }
    file.data.extend(own);
    for (line, name, list) in modules::borrowed(&texts) {
        if !named_by_job(settings).contains(&name) {
            let what = format!(
                "'{name}' is taken from the data list {list}, which belongs to the program of that \
                 name and declares it without GLOBAL: the controller takes it from this program's \
                 own list or from $config.dat; name that file under path.program.files"
            );
            log.warning(Code::ChangeIgnored, line, what);
        }
    }
    match entry(&file, settings) {
        Ok(routine) => {
            let comments = Comments::of(text, ';', settings);
            comments.tell(';', settings, log);
            let lines = hints::lines_of(&file);
            comments.tell_unheeded(|line| lines.contains(&line), log);
            let mut run = Run::new(&file, settings, comments, log);
            run.given_on = hints::given_on(&file, settings);
            run.run(routine);
            let others = file.signals.further_names(settings);
            warn_of_lines_naming(&others, text, Dialect::Krl, log);
        }
        Err(what) => log.error(Code::Reference, 1, what),
    }
}

/// The routine to start with: the one of the job, else the file's first.
fn entry<'a>(file: &'a File, settings: &Settings) -> Result<&'a Routine, String> {
    let named = settings.procedure.as_ref().map(|name| name.to_lowercase());
    let key = named.or_else(|| file.order.first().cloned());
    let found = key.and_then(|key| file.routines.get(&key));
    found.ok_or_else(|| match &settings.procedure {
        Some(name) => format!("no routine '{name}' in this file"),
        None => "no DEF in this file".to_owned(),
    })
}
