//! The output `diagnosis/1`.

use schemars::JsonSchema;
use serde::Serialize;

use crate::diagnosis::{self, Diagnosis};

/// What `detune diagnose --format json` writes.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune diagnosis/1")]
pub(in crate::report) struct Document {
    schema: SchemaName,
    verdict: Verdict,
    /// Number of poses with a measured frequency.
    poses: usize,
    /// The model as it is.
    baseline: Errors,
    /// Causes that earned their place, the one that explains most first; empty unless `explained`.
    findings: Vec<Finding>,
    /// The model with the findings put in.
    extended: Errors,
    /// What the findings gain at poses left out, percentage points.
    gain: Gain,
    /// The level of the noise, %: the best that any model can do.
    noise_floor_percent: f64,
    /// Poses worth measuring next, each with the two causes that it separates.
    next_poses: Vec<NextPose>,
    /// Pairs of causes that no pose separates, each with a test that does.
    next_tests: Vec<NextTest>,
    /// Causes one by one with how far they lie behind the best (difference of BIC).
    ranking: Vec<Suspect>,
    /// What the residual of the model as it is follows; null if it is noise.
    structure: Option<Structure>,
    /// What is left after the findings follows; null if it is noise.
    structure_left: Option<Structure>,
    /// Every measured frequency with what the models say.
    residuals: Vec<Residual>,
}

#[derive(Debug, Serialize, JsonSchema)]
enum SchemaName {
    #[serde(rename = "diagnosis/1")]
    Diagnosis1,
}

/// What was found, in a word.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Verdict {
    Explained,
    Consistent,
    Unexplained,
}

/// Errors relative to what was measured, %.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Errors {
    /// Root mean square over all frequencies.
    rms_percent: f64,
    /// The same at poses left out, the whole choice of causes repeated in each fold.
    heldout_rms_percent: f64,
    /// Root mean square mode by mode.
    per_mode_rms_percent: Vec<f64>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Finding {
    /// Of the vocabulary.
    cause: &'static str,
    /// Joint, link or mode; null where the cause has no place.
    at: Option<String>,
    /// What the data cannot tell from it, most plausible first.
    indistinguishable_from: Vec<Suspect>,
    parameters: Vec<Parameter>,
    /// Where something gives, for causes that add an elastic coordinate.
    hinge: Option<Hinge>,
    evidence: Evidence,
    /// What the error would be more without it, percentage points.
    gain_percent_points: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Suspect {
    cause: &'static str,
    at: Option<String>,
    /// How far it lies behind, difference of BIC.
    behind_bic: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Parameter {
    /// With its unit.
    name: String,
    /// In the robot's file; null where no finite value stands for "no effect".
    nominal: Option<f64>,
    /// In the unit of the name.
    estimate: f64,
    /// 95 % interval.
    ci95: [f64; 2],
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Hinge {
    /// rotation or translation.
    kind: &'static str,
    /// In the link's frame.
    axes: Vec<[f64; 3]>,
    /// In the link's frame, m, before `depth_m` (down) and `position` (along the link) move it.
    origin_m: [f64; 3],
    /// What of the link's own body moves: "link", "part" (beyond the hinge) or "rest" (nothing).
    carries: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Evidence {
    /// BIC with the finding less BIC without it.
    delta_bic: f64,
    /// How often chance does as well with any candidate.
    p_value: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Gain {
    /// Held-out error of the model less that with the findings.
    percent_points: f64,
    /// 95 % interval over resampled poses.
    ci95: [f64; 2],
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct NextPose {
    /// Joint positions from base to tip, rad or m.
    joints_rad: Vec<f64>,
    /// "cause at place", twice.
    separates: [String; 2],
    /// What the pose adds to telling them apart, in standard deviations of the noise, beyond the poses before it.
    apart_sigmas: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct NextTest {
    /// "cause at place", twice.
    separates: [String; 2],
    /// What to do.
    test: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Structure {
    follows: String,
    p_value: f64,
    /// Of the squared residual.
    share: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Residual {
    /// Row of the table, from 0.
    row: usize,
    /// From 1.
    mode: usize,
    measured_hz: f64,
    /// Null where the model has no such mode.
    model_hz: Option<f64>,
    extended_hz: Option<f64>,
}

/// A diagnosis as JSON, numbers with all digits.
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub fn diagnosis(diagnosis: &Diagnosis) -> serde_json::Result<String> {
    Ok(serde_json::to_string_pretty(&Document::from(diagnosis))? + "\n")
}

impl From<&Diagnosis> for Document {
    fn from(d: &Diagnosis) -> Self {
        let structure = |s: &Option<diagnosis::Structure>| {
            s.as_ref().map(|s| Structure {
                follows: super::words::structure(s, d),
                p_value: s.p_value,
                share: s.share,
            })
        };
        Self {
            schema: SchemaName::Diagnosis1,
            verdict: match d.verdict {
                diagnosis::Verdict::Explained => Verdict::Explained,
                diagnosis::Verdict::Consistent => Verdict::Consistent,
                diagnosis::Verdict::Unexplained => Verdict::Unexplained,
            },
            poses: d.poses,
            baseline: (&d.baseline).into(),
            findings: d.findings.iter().map(Finding::from).collect(),
            extended: (&d.extended).into(),
            gain: Gain { percent_points: d.gain.percent_points, ci95: d.gain.ci95 },
            noise_floor_percent: d.noise_floor_percent,
            next_poses: d
                .next_poses
                .iter()
                .map(|next| NextPose {
                    joints_rad: next.joints.clone(),
                    separates: next.separates.clone(),
                    apart_sigmas: next.apart,
                })
                .collect(),
            next_tests: d
                .next_tests
                .iter()
                .map(|next| NextTest { separates: next.separates.clone(), test: next.test })
                .collect(),
            ranking: d.ranking.iter().map(Suspect::from).collect(),
            structure: structure(&d.structure_before),
            structure_left: structure(&d.structure_after),
            residuals: d
                .residuals
                .iter()
                .map(|r| Residual {
                    row: r.row,
                    mode: r.mode + 1,
                    measured_hz: r.measured_hz,
                    model_hz: r.before_hz,
                    extended_hz: r.after_hz,
                })
                .collect(),
        }
    }
}

impl From<&diagnosis::Errors> for Errors {
    fn from(errors: &diagnosis::Errors) -> Self {
        Self {
            rms_percent: errors.rms_percent,
            heldout_rms_percent: errors.heldout_rms_percent,
            per_mode_rms_percent: errors.per_mode_rms_percent.clone(),
        }
    }
}

impl From<&diagnosis::Suspect> for Suspect {
    fn from(suspect: &diagnosis::Suspect) -> Self {
        Self { cause: suspect.cause.name(), at: suspect.at.clone(), behind_bic: suspect.behind }
    }
}

impl From<&diagnosis::Finding> for Finding {
    fn from(finding: &diagnosis::Finding) -> Self {
        Self {
            cause: finding.cause.name(),
            at: finding.at.clone(),
            indistinguishable_from: finding
                .indistinguishable_from
                .iter()
                .map(Suspect::from)
                .collect(),
            parameters: finding
                .parameters
                .iter()
                .map(|p| Parameter {
                    name: p.name.clone(),
                    nominal: p.nominal,
                    estimate: p.estimate,
                    ci95: p.ci95,
                })
                .collect(),
            hinge: finding.hinge.as_ref().map(|hinge| Hinge {
                kind: if hinge.turns() { "rotation" } else { "translation" },
                axes: hinge.axes.iter().map(|&axis| axis.into()).collect(),
                origin_m: hinge.origin_m.into(),
                carries: hinge.carries.name(),
            }),
            evidence: Evidence {
                delta_bic: finding.evidence.delta_bic,
                p_value: finding.evidence.p_value,
            },
            gain_percent_points: finding.gain_percent_points,
        }
    }
}
