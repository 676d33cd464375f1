//! G-code → motions.
//!
//! Read: G0–G3 (centre and radius form, full turns, helices), G4, G10, G17–G19, G20/G21, G52,
//! G90/G91, G90.1/G91.1, G92, G93–G95, corners, drilling by G73, G81–G86 and G89 with G98/G99, F,
//! S, M3–M5, G16, G68, subprograms (also of files beside the program), loops, conditions,
//! parameters and expressions, and Sinumerik's words and drilling cycles as milling posts write
//! them. The work offset under which the path starts is the job's work object. Reported and left
//! out: radius compensation (the path is read as programmed), M codes that are not known. Errors:
//! everything else that moves, shifts or computes motion; two words of one letter or two codes of
//! one modal group in a block. Until X, Y and Z are all given the place is not known: the path
//! starts where they are, and a move at feed before is an error. Reference and machine positions
//! (G28, G30, G53) are not in the program, so behind them axes are not known, either, until rapid
//! moves set them again.

mod abbreviated;
mod addresses;
mod arc_plane;
mod assumed;
mod block;
mod by_value;
mod called;
mod codes;
mod comments;
mod compensation;
mod cycle;
mod dwell;
mod expression;
mod files;
mod flow;
mod frame;
mod functions;
mod lengths;
mod lines;
mod macro_call;
mod names;
mod o_statements;
mod o_words;
mod parameters;
mod patterns;
mod places;
mod predefined;
mod quiet;
mod rotary;
mod running;
mod shift;
mod siemens;
mod state;
mod structure;
mod structured;
mod variables;
mod words;

use std::vec::Drain;

use super::Settings;
use super::log::Log;
use super::unread::{behind_end, read_as_run};
use crate::notes::Code;
use assumed::Given;
use block::Block;
use files::Files;
use flow::Flow;
use parameters::{Key, Parameters, Set};
use state::Machine;

/// Reads a G-code file into the log.
pub(super) fn read(text: &str, settings: &Settings, log: &mut Log, is_sinumerik: bool) {
    let files = Files::new(text, &settings.companions);
    let lines = files.main();
    let first = lines.iter().position(|(_, content)| !content.trim().is_empty());
    if let Some(first) = first.filter(|first| is_of_heidenhain(lines[*first].1)) {
        let what = "BEGIN PGM begins a program of Heidenhain's: name its file .h";
        log.error(Code::Syntax, first + 1, what);
        return;
    }
    log.expect_lines(lines.len());
    let mut machine = Machine::new(settings, log, changes_tools(&files.lines));
    machine.is_sinumerik = is_sinumerik;
    let given = Given::new(&settings.assume, is_sinumerik, &files.lines);
    let mut flow = Flow::new(&files, Parameters::new(is_sinumerik, given));
    flow.parameters.diameter = machine.diameter();
    let mut block = Block::default();
    let mut has_begun = false;
    // Of the program itself: of a file beside it, where it is called.
    let mut line = 1;
    while let Some(index) = flow.next_line(machine.cutter.log) {
        let (offset, content) = files.lines[index];
        let beside = files.beside(index);
        let is_beside = beside.is_some();
        if !is_beside {
            line = index + 1;
        }
        machine.cutter.log.within(beside.unwrap_or_default());
        // They have names alone, `#<_x>`.
        if !is_sinumerik && content.contains('<') {
            flow.parameters.predefined = machine.predefined();
        }
        let controls = flow.control(content, index);
        tell_read_of_main(&mut machine, &flow.parameters, line);
        if controls != Ok(false) && content.trim_start().starts_with('/') {
            read_as_run(machine.cutter.log, line);
        }
        match controls {
            Ok(true) => {
                machine.tell_unknown();
                set_parameters(&mut machine, &mut flow.parameters, line, flow.sets.drain(..));
                continue;
            }
            Ok(false) => {}
            Err(what) => {
                machine.cutter.log.error(Code::Syntax, line, what);
                flow.sets.drain(..).for_each(|(key, ..)| flow.parameters.lose(key));
                continue;
            }
        }
        let offset = (!is_beside).then_some(offset);
        let parsed = block::parse(content, offset, &mut block, &flow.parameters);
        if block.optional && !(parsed.is_ok() && block.is_idle()) {
            read_as_run(machine.cutter.log, line);
        }
        match parsed {
            Ok(()) if block.mark && is_beside => {}
            // What stands behind the closing mark is not part of the program.
            Ok(()) if block.mark && has_begun => {
                flow.end_at_mark(machine.cutter.log);
                break;
            }
            Ok(()) => {
                has_begun |= !block.words.is_empty() || !block.names.is_empty();
                codes::run(&mut machine, &mut flow, line, &block);
                set_parameters(&mut machine, &mut flow.parameters, line, block.sets.drain(..));
                block.texts.drain(..).for_each(|name| flow.parameters.declare_text(name));
            }
            Err(what) => {
                has_begun = true;
                machine.cutter.log.error(Code::Syntax, line, what);
                block.sets.drain(..).for_each(|(key, ..)| flow.parameters.lose(key));
            }
        }
        tell_read_of_main(&mut machine, &flow.parameters, line);
        if machine.cutter.log.is_full() {
            return;
        }
    }
    machine.end_unknown();
    machine.cutter.log.within(String::new());
    let given = &flow.parameters.given;
    given.tell_unheeded(&settings.assume, is_sinumerik, lines, machine.cutter.log);
    given.tell_unread(&files, machine.cutter.log);
    machine.tell_cuts_before_change();
    machine.cutter.tell_not_started();
    if !is_sinumerik {
        machine.cutter.unit.tell_without_point(machine.cutter.log);
    }
    let open = machine.corner.map(|corner| corner.line);
    if let (Some(line), Err(what)) = (open, machine.no_corner()) {
        machine.cutter.log.error(Code::Motion, line, what);
    }
    if !flow.has_ended() {
        let what = "the program ends without M2, M30 or a closing %: is the file whole?";
        machine.cutter.log.error(Code::Syntax, lines.len().max(1), what);
    }
    let words = if is_sinumerik { "G70, G71, G700 or G710" } else { "G20 or G21" };
    machine.cutter.unit.tell(machine.cutter.log, words, false);
    let moves = |line: &usize| {
        // What cannot be parsed is no block: remarks behind the closing mark.
        let is_block = block::parse(lines[*line].1, None, &mut block, &flow.parameters).is_ok();
        is_block && block.has_place()
    };
    if let Some(line) = flow.left_over().into_iter().find(moves) {
        behind_end(machine.cutter.log, line + 1);
    }
}

/// `0 BEGIN PGM PART MM`.
fn is_of_heidenhain(line: &str) -> bool {
    let words = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit());
    words.trim_start().starts_with("BEGIN PGM ")
}

/// What a subprogram has read of the main program's own variables (Siemens, machine data 11120).
fn tell_read_of_main(machine: &mut Machine<'_>, parameters: &Parameters, line: usize) {
    for name in parameters.take_read_of_main() {
        let what = format!(
            "'{name}' is read in a subprogram that does not declare it: it is taken as the main \
             program has it, as with $MN_LUD_EXTENDED_SCOPE=1, and without that the control stops \
             here or has one of its own (GUD); have the value handed over by PROC"
        );
        machine.cutter.log.warning(Code::ChangeIgnored, line, what);
    }
}

fn set_parameters(
    machine: &mut Machine<'_>,
    parameters: &mut Parameters,
    line: usize,
    sets: Drain<'_, Set>,
) {
    for (key, value, span) in sets {
        if key == Key::Number(3000) {
            let what = "#3000 raises an alarm: the machine stops here";
            machine.cutter.log.error(Code::Motion, line, what);
        }
        if matches!(key, Key::Number(5201..=5400 | 7001..=7960)) {
            let what = "sets a work offset, which is not supported: the job's work_object says it";
            machine.cutter.log.error(Code::Motion, line, what);
        }
        if let Key::Number(number) = key {
            machine.set_parameter_of_tool(line, number, value);
            machine.set_parameter_of_work(line, number);
        }
        if let Err(what) = parameters.set(key, value, span) {
            machine.cutter.log.error(Code::Value, line, what);
        }
    }
}

/// Whether any line has M6: then T alone only selects.
fn changes_tools(lines: &[(usize, &str)]) -> bool {
    let mut block = Block::default();
    let none = Parameters::default();
    lines.iter().any(|(_, line)| {
        let may = line.bytes().zip(line.bytes().skip(1)).any(|(a, b)| {
            matches!(a, b'M' | b'm') && (b == b'6' || b == b'0' || b == b' ' || b == b'=')
        });
        // A line that cannot be parsed is an error elsewhere.
        may && {
            let _ = block::parse(line, None, &mut block, &none);
            block.codes('M').any(|code| code == 60)
        }
    })
}
