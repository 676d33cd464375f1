//! Pure functions from results to text: one renderer a file. Nothing here computes an engineering
//! quantity, reads a file, prints, or knows the model; the same results give the same bytes.

pub mod advise;
pub mod check;
pub mod diagnosis;
pub mod identify;
mod json;
pub mod map;
mod paths;
pub mod schema;
pub mod stiffness;
mod style;
mod svg;
mod words;

pub use self::advise::AdvisedJob;

use std::path::PathBuf;

use crate::job::{Job, Policy, SpindleSpeed};
use crate::risk::JobRisk;

/// A job and what a check found in it: all that the renderers need, without the model.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedJob {
    /// What the job is called.
    pub name: String,
    /// The job file, as it was named by the caller.
    pub file: PathBuf,
    /// When a crossing counts.
    pub policy: Policy,
    /// What was asked of each operation, in the order of `risk.operations`.
    pub asked: Vec<AskedOperation>,
    /// What was found.
    pub risk: JobRisk,
    /// Remarks on the job, its robot and its programs that do not change the verdict, each with its place.
    pub notices: Vec<String>,
}

/// What was asked of an operation, and where it stands in its files.
#[derive(Debug, Clone, PartialEq)]
pub struct AskedOperation {
    /// Line of the job file where it starts, counted from 1.
    pub line: usize,
    /// The program that the lines of its crossings refer to, as the job names it; `None` where they refer
    /// to the job file.
    pub program: Option<PathBuf>,
    /// Programmed spindle speed.
    pub speed: SpindleSpeed,
}

impl CheckedJob {
    /// Puts together what was asked and what was found.
    pub fn new(job: &Job, risk: JobRisk) -> Self {
        Self {
            name: job.name.clone(),
            file: job.file.clone(),
            policy: job.policy.clone(),
            asked: job
                .operations
                .iter()
                .map(|operation| AskedOperation {
                    line: operation.line,
                    program: operation.program.clone(),
                    speed: operation.speed.clone(),
                })
                .collect(),
            risk,
            notices: Vec::new(),
        }
    }
}
