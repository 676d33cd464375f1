//! Fanuc TP programs (.ls) → motions.
//!
//! Read: J, L, C and A to P[] and PR[], positions in both layouts as poses or joints, speeds in
//! mm/sec, cm/min, inch/min, deg/sec, %, sec and registers, WAIT, R[] and PR[] with arithmetic,
//! LPOS and JPOS, numbers that registers give, FOR, IF, SELECT, JMP, CALL by name. User frames and
//! tools are the job's, by number; frame 0 is the robot's base frame. The third joint of most Fanuc
//! arms counts from the horizontal, so it is J3 + J2 in the robot's description; the job says so.
//! The arm configuration follows from the start of the path; a J that asks for another one by
//! CONFIG is an error.

mod arcs;
mod assign;
mod expressions;
mod flow;
mod frames;
mod hints;
mod motion;
mod open;
mod others;
mod pace;
mod position;
mod registers;
mod run;
mod shifts;
mod text;
mod vision;
mod why;
mod words;

use super::Settings;
use super::cell::set_by_comment;
use super::log::Log;
use super::unread::behind_end;
use crate::notes::Code;

/// Reads a TP program into the log.
pub(super) fn read(source: &str, settings: &Settings, log: &mut Log) {
    let source = text::parse(source);
    if let Some((line, name)) = &source.translated {
        let what = format!(
            "'{name}' instead of DEFAULT_GROUP: the listing is in another language than English, \
             which is not read; set the language to English where the listing is written, and \
             write it again"
        );
        log.error(Code::Syntax, *line, what);
        return;
    }
    for (line, what) in &source.faults {
        log.error(Code::Syntax, *line, what.clone());
    }
    for (line, what) in &source.doubts {
        log.warning(Code::MotionLeftOut, *line, what.clone());
    }
    for (line, remark) in &source.remarks_behind {
        // It begins with ';': no number is read from it, which is told where the job asks for one.
        set_by_comment(settings, log, *line, remark, |_| None);
    }
    if !source.has_end {
        let what = "the program ends without /END: is the file whole?";
        log.error(Code::Syntax, source.lines.max(1), what);
        return;
    }
    if let Some(line) = source.moves_behind_end {
        behind_end(log, line);
    }
    let moves = |own: &&text::Statement| text::is_motion(own.text.trim());
    if let (Some(groups), Some(first)) = (&source.without_arm, source.statements.iter().find(moves))
    {
        let what = format!(
            "{groups}: the program moves other groups, and the arm (group 1) stands: check a \
             program that moves the arm"
        );
        log.error(Code::Motion, first.line, what);
    }
    if let Some((line, schedule)) = &source.tracks {
        let what = format!(
            "LINE_TRACK_SCHEDULE_NUMBER is {schedule}: the positions move with a conveyor, which \
             is not supported"
        );
        log.error(Code::Motion, *line, what);
    }
    let mut run = run::Run::new(&source, settings, log);
    run.given_on = hints::given_on(&source, settings);
    run.run();
}
