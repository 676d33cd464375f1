//! One job → what a page shows of it: check, advice, and the arm along its paths.

use std::path::PathBuf;

use super::advise::{AdvisedJob, Options, WriteTo, advise};
use super::arm::{MovingArm, moving_arm};
use super::check::{CheckedJob, check};
pub use crate::input::Meshes;
use crate::job::Job;
use crate::notes::Note;
use crate::progress::Progress;

/// All that a page shows of a job.
#[derive(Debug, Clone, PartialEq)]
pub struct Reported {
    /// What a check found.
    pub checked: CheckedJob,
    /// What is advised.
    pub advised: AdvisedJob,
    /// The arm along the paths.
    pub moving: MovingArm,
}

/// Reports on a job of which `files` were read.
///
/// # Errors
/// What cannot be run.
pub fn report(job: &Job, files: &[PathBuf], progress: Progress) -> Result<Reported, Vec<Note>> {
    let advised = advise(job, files, &Options::default(), WriteTo::default(), progress)?.job;
    about(job, advised, &Meshes::default(), progress)
}

/// The same with advice that is there already, and meshes that may have been read.
///
/// # Errors
/// What cannot be run.
pub fn about(
    job: &Job,
    advised: AdvisedJob,
    meshes: &Meshes,
    progress: Progress,
) -> Result<Reported, Vec<Note>> {
    let checked = check(job, progress)?;
    let moving = moving_arm(job, &checked, meshes)?;
    Ok(Reported { checked, advised, moving })
}
