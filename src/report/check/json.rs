//! The output `check/1`: everything that a check found, for programs. Every number is written with
//! all digits of a double; a number that is not finite is refused.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use crate::job::{Carried, Settings};
use crate::report::json::{self, NotFinite, Warning, laid_out};
use crate::risk::{OperationRisk, Verdict};
use crate::study::check::CheckedJob;
use crate::units::written;

/// Objects and lists nested deeper than this stand on one line: a sample, a crossing.
const DEEPEST_SPREAD: usize = 6;

/// The results of `detune check` as JSON, one entry a job, in the order given, with all samples of
/// the results: every pose that was looked at, or, beyond 5000 of them in an operation, so many
/// that neighbours are no more than 1/2000 apart in s.
///
/// # Errors
/// If a number is not finite, which would be an internal error.
pub fn check(jobs: &[CheckedJob]) -> Result<String, NotFinite> {
    let output = Check {
        schema: SchemaName::Check1,
        verdict: CheckedJob::worst(jobs),
        jobs: jobs.iter().map(Job::from).collect(),
    };
    laid_out(&output, DEEPEST_SPREAD)
}

/// What `detune check --format json` writes.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune check/1")]
pub(in crate::report) struct Check<'a> {
    schema: SchemaName,
    /// The worst verdict of the jobs.
    verdict: Verdict,
    /// One entry a job, in the order given.
    jobs: Vec<Job<'a>>,
}

#[derive(Debug, Serialize, JsonSchema)]
enum SchemaName {
    #[serde(rename = "check/1")]
    Check1,
}

/// One job.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Job<'a> {
    /// The job file, as it was named on the command line.
    job: Cow<'a, str>,
    /// What the job is called.
    name: &'a str,
    /// The worst verdict of its operations.
    verdict: Verdict,
    /// Half width of a mode's band, in percent of its frequency.
    #[serde(rename = "separation_percent", serialize_with = "written::stated_percent")]
    separation: f64,
    /// How far the model can be trusted.
    model: Model<'a>,
    /// What comes from the settings that jobs share; null where nothing does.
    settings: Option<&'a Settings>,
    /// Keys of the policy that the command line sets, KEY=VALUE.
    policy_overrides: &'a [String],
    /// That a line lies in a mode's band somewhere in any operation, what is accepted left out;
    /// never below one over the number of draws.
    probability: f64,
    /// Its standard error.
    probability_std_error: f64,
    /// What is to be known beside the verdict, as on standard error.
    notices: Vec<String>,
    /// The same by code: which leave the verdict in doubt, and which the job accepts.
    warnings: Vec<Warning<'a>>,
    /// One entry an operation, in the order of the job.
    operations: &'a [OperationRisk],
}

/// How far the model can be trusted.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Model<'a> {
    /// Whether it was compared with measured frequencies.
    calibrated: bool,
    /// What it may be wrong by at most, in percent of any frequency.
    #[serde(rename = "uncertainty_percent", serialize_with = "written::stated_percent")]
    uncertainty: f64,
    /// The same of each mode alone, ascending.
    #[serde(rename = "uncertainty_by_mode_percent", serialize_with = "written::percent")]
    uncertainty_by_mode: Vec<f64>,
    /// Names of its elastic coordinates.
    coordinates: &'a [String],
    /// What the tip carries: in the first operation, or in one of which nobody says it.
    payload: Carried,
}

impl<'a> From<&'a CheckedJob> for Job<'a> {
    fn from(job: &'a CheckedJob) -> Self {
        Self {
            job: job.file.to_string_lossy(),
            name: &job.name,
            verdict: job.risk.verdict,
            separation: job.risk.separation,
            model: Model {
                calibrated: job.risk.calibrated,
                uncertainty: job.risk.model_uncertainty,
                uncertainty_by_mode: job.risk.uncertainty_by_mode.clone(),
                coordinates: &job.risk.coordinates,
                payload: job.risk.payload,
            },
            settings: job.settings.as_ref(),
            policy_overrides: &job.overrides,
            probability: job.risk.probability.probability,
            probability_std_error: job.risk.probability.std_error,
            notices: json::notices(&job.risk.warnings),
            warnings: job.risk.warnings.iter().map(Warning::from).collect(),
            operations: &job.risk.operations,
        }
    }
}
