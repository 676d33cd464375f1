//! Whether the text of a job that is to be written says what was advised, and nothing else than
//! before.

use std::path::{Path, PathBuf};

use super::Reading;
use super::files::is_one_place;
use super::job::job_of_text;
use crate::job::{CuttingDirection, Job, Operation, SpindleSpeed};
use crate::notes::{Code, Note, Place};

/// What an operation of the job that is written must have.
#[derive(Debug, Clone, PartialEq)]
pub struct Advised {
    /// Its speed.
    pub speed: SpindleSpeed,
    /// Its feed, m/s; `None` where only the program states it.
    pub feed_m_per_s: Option<f64>,
}

/// Reads `text` as the job that it will be in the file `to` and compares it with `job`, of which
/// `files` were read and of which `program` is about to be written: speed and feed must be as
/// `advised`, one for each operation, all else must be as before.
///
/// # Errors
/// It is no job there, or another one.
pub fn confirm_rewritten(
    job: &Job,
    files: &[PathBuf],
    text: &str,
    to: &Path,
    advised: &[Advised],
    program: Option<(&Path, &[u8])>,
) -> Result<(), Note> {
    let pending = program.map(|(path, bytes)| (path.to_owned(), bytes.to_vec()));
    let mut reading = Reading { pending, ..Reading::default() };
    let found = job_of_text(to, text.to_owned(), &mut reading)
        .map_err(|notes| {
            let Some(fault) = notes.first() else { return String::new() };
            match fault.place.file.as_deref() == Some(to) && fault.code != Code::Conflict {
                true => format!("{}; {}", fault.what, by_hand(job)),
                false => fault.what.clone(),
            }
        })
        .and_then(|again| match difference(job, &again, advised) {
            Some(what) => Err(format!("{what} would differ from the advice; {}", by_hand(job))),
            None => Ok(()),
        });
    let found = found.and_then(|()| {
        let is_new = |file: &PathBuf| program.is_some_and(|(path, _)| is_one_place(path, file));
        let old = files.get(1..).unwrap_or_default();
        let is_known = |file: &PathBuf| is_new(file) || old.iter().any(|o| is_one_place(o, file));
        match reading.files.iter().find(|file| !is_known(file)) {
            Some(other) => Err(format!("it would read a different file, {}", other.display())),
            None => Ok(()),
        }
    });
    found.map_err(|why| {
        let what = format!("is not written: read again, {why}");
        Note::error(Code::NotRewritten, Place::file(to), what)
    })
}

fn by_hand(job: &Job) -> String {
    format!(
        "{} is written in a manner that cannot be edited, so change it by hand",
        job.file.display()
    )
}

/// What is not as it must be. Stretches of a program that come to run alike are one when it is read
/// again, so operations are compared where they share moves.
fn difference(before: &Job, after: &Job, advised: &[Advised]) -> Option<String> {
    let entries = |job: &Job| job.operations.last().map(|last| last.entry);
    let levers = |job: &Job| (job.levers.tools_on_hand.clone(), job.levers.work_object_shift_m);
    let rest = [
        ("spindle", before.spindle == after.spindle),
        ("policy", before.policy == after.policy),
        ("what may be changed", levers(before) == levers(after)),
        ("the number of operations", entries(before) == entries(after)),
    ];
    if let Some((what, _)) = rest.iter().find(|(_, is_same)| !is_same) {
        return Some((*what).to_owned());
    }
    after.operations.iter().find_map(|after| {
        let shares = |each: &Operation| {
            each.entry == after.entry
                && each.stretch.start < after.stretch.end
                && after.stretch.start < each.stretch.end
        };
        let own = before.operations.iter().zip(advised).filter(|(each, _)| shares(each));
        own.into_iter().find_map(|(before, advised)| {
            let what = operation_difference(before, after, advised)?;
            Some(format!("operation '{}': {what}", before.name))
        })
    })
}

fn operation_difference(
    before: &Operation,
    after: &Operation,
    advised: &Advised,
) -> Option<&'static str> {
    let is_divided = before.is_divided() || after.is_divided();
    // The whole path is compared with its first stretch.
    let is_same_path = before.stretch.start > 0
        || before.moves.len() == after.moves.len()
            && before
                .moves
                .iter()
                .zip(after.moves.iter())
                .all(|(a, b)| a.to == b.to && a.tcp == b.tcp && a.work == b.work);
    let all = [
        ("name", before.name == after.name || is_divided),
        ("tool", before.tool == after.tool && before.tool_number == after.tool_number),
        ("payload", before.carried == after.carried),
        ("speed", is_same_speed(&after.speed, &advised.speed)),
        ("feed", advised.feed_m_per_s.is_none_or(|feed| after.feed_m_per_s == feed)),
        ("cutting", is_same_cut(before, after)),
        ("start_near_deg", before.start_near == after.start_near),
        ("path", is_same_path),
    ];
    all.iter().find(|(_, is_same)| !is_same).map(|(what, _)| *what)
}

/// A program's numbers may be of another unit than rev/min, and are written with few digits.
fn is_same_speed(after: &SpindleSpeed, advised: &SpindleSpeed) -> bool {
    const SLACK_RPM: f64 = 1e-3;
    match (after, advised) {
        (SpindleSpeed::Constant(after), SpindleSpeed::Constant(advised)) => {
            (after - advised).abs() <= SLACK_RPM
        }
        _ => after == advised,
    }
}

/// The feed at which a drill was measured is that of the speeds before where the job did not say
/// it, and is written in its digits then.
fn is_same_cut(before: &Operation, after: &Operation) -> bool {
    const ROUNDING: f64 = 1e-9;
    let (Some(before), Some(after)) = (&before.cutting, &after.cutting) else {
        return before.cutting == after.cutting;
    };
    let mut after = after.clone();
    if let (CuttingDirection::Drill(old), CuttingDirection::Drill(new)) =
        (before.direction, &mut after.direction)
        && let (Some(a), Some(b)) = (old.measured_at, new.measured_at)
        && ((a.m_per_rev() - b.m_per_rev()).abs() <= ROUNDING * a.m_per_rev() || !old.is_measured())
    {
        new.measured_at = Some(a);
    }
    *before == after
}
