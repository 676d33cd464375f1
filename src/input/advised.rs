//! Whether the text of a job that is to be written says what was advised, and nothing else than
//! before.

use std::path::{Path, PathBuf};

use super::files::is_one_place;
use super::job::job_of_text;
use super::{OperationEdit, Reading};
use crate::job::{Job, Operation};
use crate::notes::{Code, Note, Place};
use crate::units::m_per_s_from_mm_per_min;

/// Reads `text` as the job that it will be in the file `to` and compares it with `job`, of which
/// `files` were read and of which `program` is about to be written: speed and feed must be those of
/// the edits, all else must be as before.
///
/// # Errors
/// It is no job there, or another one.
pub fn confirm_rewritten(
    job: &Job,
    files: &[PathBuf],
    text: &str,
    to: &Path,
    edits: &[OperationEdit],
    program: Option<(&Path, &[u8])>,
) -> Result<(), Note> {
    let pending = program.map(|(path, bytes)| (path.to_owned(), bytes.to_vec()));
    let mut reading = Reading { pending, ..Reading::default() };
    let found = job_of_text(to, text.to_owned(), &mut reading)
        .map_err(|notes| notes.first().map_or_else(String::new, |fault| fault.what.clone()))
        .and_then(|again| match difference(job, &again, edits) {
            Some(what) => Err(format!("{what} would differ from the advice")),
            None => Ok(()),
        });
    let found = found.and_then(|()| {
        let is_new = |file: &PathBuf| edits.iter().any(|edit| is_one(edit.program.as_ref(), file));
        let old = files.get(1..).unwrap_or_default();
        let is_known = |file: &PathBuf| is_new(file) || old.iter().any(|o| is_one(Some(o), file));
        match reading.files.iter().find(|file| !is_known(file)) {
            Some(other) => Err(format!("it would read a different file, {}", other.display())),
            None => Ok(()),
        }
    });
    found.map_err(|why| {
        let what = format!(
            "is not written: read again, {why}; {} is written in a manner that cannot be edited, \
             so change it by hand",
            job.file.display()
        );
        Note::error(Code::NotRewritten, Place::file(to), what)
    })
}

fn is_one(a: Option<&PathBuf>, b: &Path) -> bool {
    a.is_some_and(|a| is_one_place(a, b))
}

/// What is not as it must be.
fn difference(before: &Job, after: &Job, edits: &[OperationEdit]) -> Option<String> {
    let rest = [
        ("tool", before.tool == after.tool),
        ("spindle", before.spindle == after.spindle),
        ("policy", before.policy == after.policy),
        ("what may be changed", before.levers == after.levers),
        ("the number of operations", before.operations.len() == after.operations.len()),
    ];
    if let Some((what, _)) = rest.iter().find(|(_, is_same)| !is_same) {
        return Some((*what).to_owned());
    }
    before.operations.iter().zip(&after.operations).zip(edits).find_map(
        |((before, after), edit)| {
            let what = operation_difference(before, after, edit)?;
            Some(format!("operation '{}': {what}", before.name))
        },
    )
}

fn operation_difference(
    before: &Operation,
    after: &Operation,
    edit: &OperationEdit,
) -> Option<&'static str> {
    let feed_m_per_s = edit.feed_mm_per_min.map_or(before.feed_m_per_s, m_per_s_from_mm_per_min);
    let is_same_path = before.moves.len() == after.moves.len()
        && before.moves.iter().zip(&after.moves).all(|(a, b)| a.to == b.to && a.tcp == b.tcp);
    let all = [
        ("name", before.name == after.name),
        ("speed", after.speed == *edit.speed.as_ref().unwrap_or(&before.speed)),
        ("feed", after.feed_m_per_s == feed_m_per_s),
        ("cutting", before.cutting == after.cutting),
        ("start_near_deg", before.start_near == after.start_near),
        ("path", is_same_path || edit.program.is_some()),
    ];
    all.iter().find(|(_, is_same)| !is_same).map(|(what, _)| *what)
}
