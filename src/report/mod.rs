//! Pure functions from results to text: one renderer a file. Nothing here computes an engineering
//! quantity, reads a file, prints, or knows the model; the same results give the same bytes.

pub mod advice;
pub mod diagnosis;
pub use self::advice::AdvisedJob;

mod findings;
pub mod github;
pub mod identify;
pub mod json;
pub mod junit;
pub mod map;
mod paths;
pub mod plot_text;
pub mod sarif;
pub mod schema;
pub mod stiffness;
mod style;
mod svg;
pub mod text;
mod words;

pub(crate) use words::{number, trimmed};

use std::path::{Path, PathBuf};

use crate::job::{Job, Policy, SpindleSpeed};
use crate::risk::{Crossing, JobRisk, OperationRisk, Verdict};

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

    /// The operations in order, each with where it stands.
    fn operations(&self) -> impl Iterator<Item = CheckedOperation<'_>> {
        self.risk.operations.iter().enumerate().map(|(index, risk)| CheckedOperation {
            job: self,
            asked: self.asked.get(index),
            risk,
        })
    }
}

/// One operation of a checked job.
#[derive(Debug, Clone, Copy)]
struct CheckedOperation<'a> {
    job: &'a CheckedJob,
    asked: Option<&'a AskedOperation>,
    risk: &'a OperationRisk,
}

impl<'a> CheckedOperation<'a> {
    /// The program, as the job names it.
    fn program(&self) -> Option<&'a Path> {
        self.asked?.program.as_deref()
    }

    /// The file that the lines of the crossings refer to, seen from where the caller stands.
    fn lines_file(&self) -> PathBuf {
        match self.program() {
            Some(program) => paths::beside(&self.job.file, program),
            None => paths::tidied(&self.job.file),
        }
    }

    /// Lowest and highest programmed spindle speed, rev/min.
    fn rpm_range(&self) -> [f64; 2] {
        self.asked.map_or([self.risk.spindle_rpm; 2], |asked| asked.speed.range_rpm())
    }

    /// The programmed (s, rev/min) where the speed is scheduled.
    fn schedule(&self) -> Option<&'a [(f64, f64)]> {
        match &self.asked?.speed {
            SpindleSpeed::Constant(_) => None,
            SpindleSpeed::Schedule(points) => Some(points),
        }
    }

    /// Share of a mode's strain energy in each coordinate, largest first.
    fn moves(&self, crossing: &Crossing) -> Vec<(&'a str, f64)> {
        let names = self.job.risk.coordinates.iter().map(String::as_str);
        let mut moves: Vec<_> = names.zip(crossing.strain_energy_shares.iter().copied()).collect();
        moves.sort_by(|a, b| b.1.total_cmp(&a.1));
        moves
    }
}

/// The worst verdict of several jobs; clear if there is none.
pub fn verdict(jobs: &[CheckedJob]) -> Verdict {
    jobs.iter().map(|job| job.risk.verdict).max().unwrap_or(Verdict::Clear)
}
