//! What a listing says beside its statements: whether it is whole, in which language it is, which
//! groups it moves.

use super::text::{Source, Statement, is_motion};
use crate::notes::Code;
use crate::program::Settings;
use crate::program::cell::set_by_comment;
use crate::program::log::Log;
use crate::program::unread::behind_end;

/// Tells what a listing has beside its statements, at the line of the file that is checked for one
/// of its own; whether it can be run.
pub(super) fn examine(
    source: &Source,
    at: impl Fn(usize) -> usize,
    settings: &Settings,
    log: &mut Log,
) -> bool {
    if let Some((line, name)) = &source.translated {
        let what = format!(
            "'{name}' instead of DEFAULT_GROUP: the listing is in another language than English, \
             which is not read; set the language to English where the listing is written, and \
             write it again"
        );
        log.error(Code::Syntax, at(*line), what);
        return false;
    }
    for (line, what) in &source.faults {
        log.error(Code::Syntax, at(*line), what.clone());
    }
    for (line, what) in &source.doubts {
        log.warning(Code::MotionLeftOut, at(*line), what.clone());
    }
    for (line, remark) in &source.remarks_behind {
        // It begins with ';': no number is read from it, which is told where the job asks for one.
        set_by_comment(settings, log, at(*line), remark, |_| None);
    }
    if !source.has_end {
        let what = "the program ends without /END: is the file whole?";
        log.error(Code::Syntax, at(source.lines.max(1)), what);
        return false;
    }
    if let Some(line) = source.moves_behind_end {
        behind_end(log, at(line));
    }
    let moves = |own: &&Statement| is_motion(own.text.trim());
    if let (Some(groups), Some(first)) = (&source.without_arm, source.statements.iter().find(moves))
    {
        let what = format!(
            "{groups}: the program moves other groups, and the arm (group 1) stands: check a \
             program that moves the arm"
        );
        log.error(Code::Motion, at(first.line), what);
    }
    if let Some((line, schedule)) = &source.tracks {
        let what = format!(
            "LINE_TRACK_SCHEDULE_NUMBER is {schedule}: the positions move with a conveyor, which \
             is not supported"
        );
        log.error(Code::Motion, at(*line), what);
    }
    true
}
