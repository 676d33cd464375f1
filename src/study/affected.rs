//! Changed files → the jobs that they are about.

use std::path::PathBuf;

use rayon::prelude::*;

use super::advise::read;
use crate::input::Changes;
use crate::units::Date;

/// Those of `jobs` that read one of the changed files: the job file itself, its robot and URDF, its
/// programs, its settings. A job that cannot be read may have to do with any file.
pub fn affected(jobs: &[PathBuf], changed: &[PathBuf], today: Date) -> Vec<PathBuf> {
    let changes = Changes::of(changed);
    let is_affected = |job: &PathBuf| {
        let read = read(job, today);
        read.value.is_err() || changes.touch(job, &read.files)
    };
    let found: Vec<bool> = jobs.par_iter().map(is_affected).collect();
    jobs.iter()
        .zip(found)
        .filter(|(_, is_affected)| *is_affected)
        .map(|(job, _)| job.clone())
        .collect()
}
