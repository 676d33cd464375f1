//! Jobs → verdicts.

use std::path::PathBuf;

use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::{Read, advise};
use crate::job::{Job, Policy};
use crate::notes::{Code, Note, Place};
use crate::progress::Progress;
pub use crate::risk::Verdict;
pub use crate::risk::Warning;
use crate::risk::{JobRisk, assess};
use crate::units::Date;

/// Measured arms have their first mode at 7 to 26 Hz: less than half of that, or eight times as
/// much, is a mistake in the model.
const FIRST_FREQUENCY_HZ: [f64; 2] = [3.0, 200.0];

/// A job and what a check found in it: all that a renderer needs, without the model.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedJob {
    /// What the job is called.
    pub name: String,
    /// The job file, as it was named by the caller.
    pub file: PathBuf,
    /// When a crossing counts.
    pub policy: Policy,
    /// What was found.
    pub risk: JobRisk,
}

impl CheckedJob {
    /// Puts together what was asked and what was found.
    pub fn new(job: &Job, risk: JobRisk) -> Self {
        Self { name: job.name.clone(), file: job.file.clone(), policy: job.policy.clone(), risk }
    }

    /// The worst verdict of several jobs; clear if there is none.
    pub fn worst(jobs: &[Self]) -> Verdict {
        jobs.iter().map(|job| job.risk.verdict).max().unwrap_or(Verdict::Clear)
    }
}

/// What fails.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gate {
    /// Nothing.
    Never,
    /// This verdict or a worse one.
    From(Verdict),
    /// A line that lies in a mode's band somewhere with this probability or a higher one, and what
    /// was not checked.
    Probability(f64),
}

impl Gate {
    /// Whether an operation or a job with this verdict and probability fails.
    pub fn fails(self, verdict: Verdict, probability: f64) -> bool {
        match self {
            Self::Never => false,
            Self::From(mildest) => verdict >= mildest,
            Self::Probability(most) => verdict == Verdict::Unchecked || probability >= most,
        }
    }

    /// Whether any of these jobs fails.
    pub fn fails_any(self, jobs: &[CheckedJob]) -> bool {
        let operations = || jobs.iter().flat_map(|job| &job.risk.operations);
        jobs.iter().any(|job| self.fails(job.risk.verdict, job.risk.probability.probability))
            || operations().any(|one| self.fails(one.verdict, one.probability))
    }
}

/// Checks one job.
///
/// # Errors
/// What cannot be run, for every operation.
pub fn check(job: &Job, progress: Progress) -> Result<CheckedJob, Vec<Note>> {
    let mut checked = CheckedJob::new(job, assess(job, progress)?);
    let doubt = implausible_frequency(job, &checked.risk);
    checked.risk.warnings.extend(doubt);
    Ok(checked)
}

/// A first frequency that no arm has: the stiffness or the masses are wrong by far.
fn implausible_frequency(job: &Job, risk: &JobRisk) -> Option<Note> {
    let samples = risk.operations.iter().flat_map(|operation| {
        operation.samples.iter().map(move |sample| (operation.name.as_str(), sample))
    });
    let first = samples.filter_map(|(name, sample)| {
        Some((name, sample.s, *sample.natural_frequencies_hz.first()?))
    });
    let [least_hz, most_hz] = FIRST_FREQUENCY_HZ;
    let (name, s, lowest_hz) = first.min_by(|a, b| a.2.total_cmp(&b.2))?;
    if (least_hz..=most_hz).contains(&lowest_hz) {
        return None;
    }
    let what = format!(
        "the first natural frequency is {lowest_hz:.3} Hz at its lowest (operation '{name}', s = \
         {s:.3}), where arms have {least_hz} to {most_hz} Hz; check stiffness (N·m/rad), masses \
         and the units of both"
    );
    Some(Note::warning(Code::FirstFrequency, Place::file(&job.file), what))
}

/// Several job files as they were read, in the order given.
#[derive(Debug)]
pub struct ReadJobs(Vec<Read<Job>>);

/// What came of several jobs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Checked {
    /// The jobs that could be checked, in the order given.
    pub jobs: Vec<CheckedJob>,
    /// Warnings on all jobs, those included that could not be checked.
    pub warnings: Vec<Warning>,
    /// Why the others could not be checked.
    pub errors: Vec<Note>,
}

impl ReadJobs {
    /// Reads job files, with what they accept on a day.
    pub fn read(files: &[PathBuf], today: Date) -> Self {
        Self(files.par_iter().map(|file| advise::read(file, today)).collect())
    }

    /// Every file that was read.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.0.iter().flat_map(|read| &read.files)
    }

    /// Checks those that could be read.
    pub fn check(self, progress: Progress) -> Checked {
        let one = |Read { value: job, warnings, .. }: Read<Job>| {
            (job.and_then(|job| check(&job, progress)), warnings)
        };
        let mut all = Checked::default();
        for (checked, read) in self.0.into_par_iter().map(one).collect::<Vec<_>>() {
            match checked {
                Ok(job) => {
                    all.warnings.extend(job.risk.warnings.iter().cloned());
                    all.jobs.push(job);
                }
                Err(errors) => {
                    all.warnings.extend(read.into_iter().map(Warning::from));
                    all.errors.extend(errors);
                }
            }
        }
        all
    }
}
