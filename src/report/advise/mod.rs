//! Advice as text, JSON and a picture.

pub mod json;
pub mod svg;
pub mod text;
mod words;

use std::path::PathBuf;

use crate::advice::{JobAdvice, NoVibration};
use crate::job::{Job, Levers, Operation, Spindle};

/// A job and what to do about it: all that the renderers need, without the model.
#[derive(Debug, Clone, PartialEq)]
pub struct AdvisedJob {
    /// What the job is called.
    pub name: String,
    /// The job file, as it was named by the caller.
    pub file: PathBuf,
    /// The spindle.
    pub spindle: Spindle,
    /// What the job offers to be changed.
    pub levers: Levers,
    /// Per operation, whether its path is one of poses alone, which can be turned and moved.
    pub has_poses: Vec<bool>,
    /// What to do.
    pub advice: JobAdvice,
}

impl AdvisedJob {
    /// Puts together what was asked and what was found.
    pub fn new(job: &Job, advice: JobAdvice) -> Self {
        Self {
            name: job.name.clone(),
            file: job.file.clone(),
            spindle: job.spindle,
            levers: job.levers.clone(),
            has_poses: job.operations.iter().map(Operation::has_poses).collect(),
            advice,
        }
    }
}

/// Why nothing is said on the vibration of the tool tip, as a lower-case fragment.
pub fn no_vibration(why: NoVibration) -> &'static str {
    words::no_vibration(why)
}
