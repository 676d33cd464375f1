//! Changed files → the jobs that they are about.

use std::path::PathBuf;

use rayon::prelude::*;

use super::advise::read;
use crate::input::Changes;
use crate::notes::Note;
use crate::units::Date;

/// Those of `jobs` that read one of the changed files: the job file itself, its robot and URDF, its
/// programs, its settings. A job that cannot be read may have to do with any file, and a file in a
/// folder that is not there with any job: then there is a warning, too.
pub fn affected(
    jobs: &[PathBuf],
    changed: &[PathBuf],
    today: Date,
) -> (Vec<PathBuf>, Option<Note>) {
    let changes = Changes::of(changed);
    let is_affected = |job: &PathBuf| {
        let read = read(job, today);
        read.value.is_err() || changes.touch(job, &read.files)
    };
    let found: Vec<bool> = jobs.par_iter().map(is_affected).collect();
    let affected = jobs.iter().zip(found).filter(|(_, is_affected)| *is_affected);
    (affected.map(|(job, _)| job.clone()).collect(), changes.nowhere())
}
