//! Pure functions from results to text: one renderer a file. Nothing here computes an engineering
//! quantity, reads a file, prints, or knows the model; the same results give the same bytes.

pub mod diagnosis;
mod findings;
pub mod github;
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

use std::path::{Path, PathBuf};

use crate::job::{Job, Policy};
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
    /// Where each operation stands, in the order of `risk.operations`.
    pub places: Vec<OperationPlace>,
    /// What was found.
    pub risk: JobRisk,
}

/// Where an operation stands in its files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OperationPlace {
    /// Line of the job file where it starts, counted from 1.
    pub line: usize,
    /// The program that the lines of its crossings refer to, as the job names it; `None` where they refer
    /// to the job file.
    pub program: Option<PathBuf>,
}

impl CheckedJob {
    /// Puts together what was asked and what was found.
    pub fn new(job: &Job, risk: JobRisk) -> Self {
        Self {
            name: job.name.clone(),
            file: job.file.clone(),
            policy: job.policy.clone(),
            places: job
                .operations
                .iter()
                .map(|operation| OperationPlace {
                    line: operation.line,
                    program: operation.program.clone(),
                })
                .collect(),
            risk,
        }
    }

    /// The operations in order, each with where it stands.
    fn operations(&self) -> impl Iterator<Item = CheckedOperation<'_>> {
        self.risk.operations.iter().enumerate().map(|(index, risk)| CheckedOperation {
            job: self,
            place: self.places.get(index),
            risk,
        })
    }
}

/// One operation of a checked job.
#[derive(Debug, Clone, Copy)]
struct CheckedOperation<'a> {
    job: &'a CheckedJob,
    place: Option<&'a OperationPlace>,
    risk: &'a OperationRisk,
}

impl<'a> CheckedOperation<'a> {
    /// The program, as the job names it.
    fn program(&self) -> Option<&'a Path> {
        self.place?.program.as_deref()
    }

    /// The file that the lines of the crossings refer to, seen from where the caller stands.
    fn lines_file(&self) -> PathBuf {
        match self.program() {
            Some(program) => paths::beside(&self.job.file, program),
            None => paths::tidied(&self.job.file),
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
