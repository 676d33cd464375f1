//! Jobs → verdicts.

use std::path::PathBuf;

use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::{PolicyOverrides, Read, advise};
use crate::job::{Job, Policy, Settings};
use crate::notes::Note;
use crate::progress::Progress;
pub use crate::risk::Verdict;
pub use crate::risk::Warning;
use crate::risk::{JobRisk, OperationRisk, assess};
use crate::units::Date;

/// A job and what a check found in it: all that a renderer needs, without the model.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedJob {
    /// What the job is called.
    pub name: String,
    /// The job file, as it was named by the caller.
    pub file: PathBuf,
    /// When a crossing counts.
    pub policy: Policy,
    /// What comes from the settings that jobs share.
    pub settings: Option<Settings>,
    /// Keys of the policy that the run sets: `separation_percent=8`.
    pub overrides: Vec<String>,
    /// What was found.
    pub risk: JobRisk,
}

impl CheckedJob {
    /// Puts together what was asked and what was found.
    pub fn new(job: &Job, risk: JobRisk) -> Self {
        Self {
            name: job.name.clone(),
            file: job.file.clone(),
            policy: job.policy.clone(),
            settings: job.review.settings.clone(),
            overrides: job.review.overrides.clone(),
            risk,
        }
    }

    /// The worst verdict of several jobs; clear if there is none.
    pub fn worst(jobs: &[Self]) -> Verdict {
        jobs.iter().map(|job| job.risk.verdict).max().unwrap_or(Verdict::Clear)
    }
}

/// How many of the poses that were looked at a result keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Samples {
    /// All that the check holds.
    All,
    /// So many that neighbours are no more than [`THIN_GAP`] apart in s where they were so before,
    /// with both ends and the poses next to the ends and the closest points of crossings.
    Thin,
    /// None.
    None,
}

/// The largest gap in s between samples of a thinned result.
pub const THIN_GAP: f64 = 0.01;

impl Samples {
    /// Leaves out the others. What is found stays as it is.
    pub fn keep(self, jobs: &mut [CheckedJob]) {
        for operation in jobs.iter_mut().flat_map(|job| &mut job.risk.operations) {
            match self {
                Self::All => {}
                Self::Thin => thin_out(operation),
                Self::None => operation.samples = Vec::new(),
            }
        }
    }
}

fn thin_out(operation: &mut OperationRisk) {
    let places: Vec<f64> = operation.samples.iter().map(|sample| sample.s).collect();
    let crossings = operation.crossings.iter();
    let marks = crossings.flat_map(|c| [c.from_s, c.closest_s, c.to_s]);
    let marks = marks.chain(operation.closest.map(|approach| approach.s));
    let mut stays = vec![false; places.len()];
    for mark in marks {
        let after = places.partition_point(|s| *s < mark).min(places.len().saturating_sub(1));
        let before = after.saturating_sub(1);
        for near in [before, after] {
            if let Some(stay) = stays.get_mut(near) {
                *stay = true;
            }
        }
    }
    let mut last = f64::NEG_INFINITY;
    for (i, s) in places.iter().enumerate() {
        // The next one would leave too wide a gap.
        let next = places.get(i + 1).copied().unwrap_or(f64::INFINITY);
        stays[i] |= next - last > THIN_GAP;
        if stays[i] {
            last = *s;
        }
    }
    let mut stays = stays.into_iter();
    operation.samples.retain(|_| stays.next().unwrap_or(true));
}

/// What fails.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gate {
    /// Nothing.
    Never,
    /// This verdict or a worse one.
    From(Verdict),
    /// A line that lies in a mode's band somewhere with this probability or a higher one, a limit
    /// of the policy that is exceeded, and what was not checked.
    Probability(f64),
}

impl Gate {
    /// Whether an operation or a job with this verdict and probability fails; `exceeds` tells
    /// whether a limit of the policy is exceeded in it, which the job does not accept.
    pub fn fails(self, verdict: Verdict, probability: f64, exceeds: bool) -> bool {
        match self {
            Self::Never => false,
            Self::From(mildest) => verdict >= mildest,
            Self::Probability(most) => {
                verdict == Verdict::Unchecked || exceeds || probability >= most
            }
        }
    }

    /// Whether any of these jobs fails.
    pub fn fails_any(self, jobs: &[CheckedJob]) -> bool {
        let operations = || jobs.iter().flat_map(|job| &job.risk.operations);
        let exceeds = |job: &CheckedJob| job.risk.warnings.iter().any(Warning::is_open_breach);
        let of_job = |job: &CheckedJob| {
            self.fails(job.risk.verdict, job.risk.probability.probability, exceeds(job))
        };
        jobs.iter().any(of_job)
            || operations().any(|one| self.fails(one.verdict, one.probability, false))
    }
}

/// Checks one job.
///
/// # Errors
/// What cannot be run, for every operation.
pub fn check(job: &Job, progress: Progress) -> Result<CheckedJob, Vec<Note>> {
    Ok(CheckedJob::new(job, assess(job, progress)?))
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
        Self::read_under(files, today, &PolicyOverrides::default())
    }

    /// The same with keys of the policy that win over those of the files.
    pub fn read_under(files: &[PathBuf], today: Date, policy: &PolicyOverrides) -> Self {
        Self(files.par_iter().map(|file| advise::read_under(file, today, policy)).collect())
    }

    /// Every file that was read.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.0.iter().flat_map(|read| &read.files)
    }

    /// Checks those that could be read.
    pub fn check(self, progress: Progress) -> Checked {
        self.check_with(progress, |_, _| Ok(())).0
    }

    /// The same, with something more about each of those that could be checked.
    pub fn check_with<T: Send>(
        self,
        progress: Progress,
        more: impl Fn(&Job, &CheckedJob) -> Result<T, Vec<Note>> + Sync,
    ) -> (Checked, Vec<T>) {
        let one = |Read { value: job, warnings, .. }: Read<Job>| {
            let both = |job: Job| {
                let checked = check(&job, progress)?;
                let more = more(&job, &checked)?;
                Ok((checked, more))
            };
            (job.and_then(both), warnings)
        };
        let (mut all, mut more) = (Checked::default(), Vec::new());
        for (checked, read) in self.0.into_par_iter().map(one).collect::<Vec<_>>() {
            match checked {
                Ok((job, of_job)) => {
                    all.warnings.extend(job.risk.warnings.iter().cloned());
                    all.jobs.push(job);
                    more.push(of_job);
                }
                Err(errors) => {
                    all.warnings.extend(read.into_iter().map(Warning::from));
                    all.errors.extend(errors);
                }
            }
        }
        (all, more)
    }
}
