//! The output `diagnosis/1`.

use schemars::JsonSchema;
use serde::Serialize;

use super::words::{notices, structure};
use crate::diagnosis::{
    self, Diagnosis, Errors, Finding, Gain, LearnedDamping, NextPose, NextTest, NoiseFound,
    ResidualRow, Suspect, Symmetry, Untested, Verdict, WithoutCause,
};
use crate::report::json::{WHOLE, spread};
use crate::study::diagnose::Diagnosed;

/// What `detune diagnose --format json` writes.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune diagnosis/1")]
pub(in crate::report) struct Document<'d> {
    schema: SchemaName,
    verdict: Verdict,
    /// What is to be known beside the verdict.
    notices: Vec<&'d str>,
    /// Corrections of the robot's file that were fitted to poses of this table, as "cause at
    /// place": the diagnosis starts without them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    fitted_again: Vec<String>,
    /// Number of poses with a measured frequency.
    poses: usize,
    /// The model as it is.
    baseline: &'d Errors,
    /// Causes that the data justify, the one that explains most first; empty unless `explained` or
    /// `partly_explained`.
    findings: &'d [Finding],
    /// The model with the findings.
    extended: &'d Errors,
    /// What the findings gain at held-out poses.
    gain: Gain,
    /// Of an unexplained error: what a Gaussian process of the residual over the joints gains, a
    /// correction without a cause; null where none surely does.
    without_cause: Option<&'d WithoutCause>,
    /// The level of the noise, %: no model can do better.
    noise_floor_percent: f64,
    /// How the noise is made.
    noise: &'d NoiseFound,
    /// Damping of the joints whose damping the table tells.
    damping: &'d [LearnedDamping],
    /// Rows that fit nothing and were set aside, counted from 1 as in the table.
    suspect_rows: &'d [usize],
    /// Poses to measure next, each with the two causes that it separates.
    next_poses: &'d [NextPose],
    /// Pairs of causes that no pose separates, each with a test that does.
    next_tests: &'d [NextTest],
    /// The best single causes, each with its difference of BIC to the best.
    ranking: &'d [Suspect],
    /// Structure of the residual of the model as it is; null if it is noise.
    structure: Option<Structure>,
    /// Structure of the remaining residual; null if it is noise.
    structure_left: Option<Structure>,
    /// About which angle the frequencies mirror; absent where the table does not show it.
    #[serde(skip_serializing_if = "Option::is_none")]
    symmetry: Option<&'d Symmetry>,
    /// Causes that were not tested, since their effect depends on joints that the table does not
    /// state.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    untested: &'d [Untested],
    /// Every measured frequency with the predictions.
    residuals: &'d [ResidualRow],
}

#[derive(Debug, Serialize, JsonSchema)]
enum SchemaName {
    #[serde(rename = "diagnosis/1")]
    Diagnosis1,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Structure {
    follows: String,
    p_value: f64,
    /// Of the squared residual.
    share: f64,
}

impl Structure {
    fn of(found: &diagnosis::Structure, d: &Diagnosis) -> Self {
        Self { follows: structure(found, d), p_value: found.p_value, share: found.share }
    }
}

/// A diagnosis as JSON, numbers with all digits.
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub fn diagnosis(diagnosed: &Diagnosed) -> serde_json::Result<String> {
    let d = &diagnosed.diagnosis;
    let structure =
        |found: &Option<diagnosis::Structure>| found.as_ref().map(|found| Structure::of(found, d));
    let document = Document {
        schema: SchemaName::Diagnosis1,
        verdict: d.verdict,
        notices: notices(diagnosed).collect(),
        fitted_again: diagnosed.fitted_again.clone(),
        poses: d.poses,
        baseline: &d.baseline,
        findings: &d.findings,
        extended: &d.extended,
        gain: d.gain,
        without_cause: d.without_cause.as_ref(),
        noise_floor_percent: d.noise_floor_percent,
        noise: &d.noise,
        damping: &d.damping,
        suspect_rows: &d.suspect_rows,
        next_poses: &d.next_poses,
        next_tests: &d.next_tests,
        ranking: &d.ranking,
        structure: structure(&d.structure_before),
        structure_left: structure(&d.structure_after),
        symmetry: d.symmetry.as_ref(),
        untested: &d.untested,
        residuals: &d.residuals,
    };
    spread(&document, WHOLE)
}
