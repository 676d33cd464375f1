//! What a diagnosis says: plain data, as `diagnosis/1` has it.

use schemars::JsonSchema;
use serde::{Serialize, Serializer};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::causes::CauseText;
use super::gaussian_process::{Predicted, Process};
use crate::model::{Carries, Cause, Correction, Hinge, Posterior};
use crate::notes::Note;
use crate::units::written;

/// What was found, in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "schemars writes a plain enum if no variant has a description")]
pub enum Verdict {
    // Causes explain what the model gets wrong.
    Explained,
    // Nothing beyond noise.
    Consistent,
    // Causes are surely right, and something else is wrong, too.
    PartlyExplained,
    // The residual is structured, but no cause explains it.
    Unexplained,
}

/// Errors relative to what was measured, %.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Errors {
    /// Root mean square over all frequencies.
    pub rms_percent: f64,
    /// The same at held-out poses; the choice of causes is repeated in each fold.
    pub heldout_rms_percent: f64,
    /// The model's own share of that: without the noise of the measurement, as far as that is
    /// known.
    pub model_error_percent: f64,
    /// Root mean square mode by mode.
    pub per_mode_rms_percent: Vec<f64>,
}

/// The noise of a table, standard deviations in per cent of the frequency.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NoiseFound {
    /// Of each mode alone.
    pub per_mode_percent: Vec<f64>,
    /// What all modes of a row have in common.
    pub common_percent: f64,
    /// Drift of all modes over the rows, root mean square.
    pub drift_percent: f64,
    /// What the table states, median of all frequencies; null where it states none.
    pub stated_percent: Option<f64>,
}

/// What a table of damping ratios teaches about a joint.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LearnedDamping {
    /// The joint.
    pub joint: String,
    /// Share of critical damping of a mode whose strain energy sits all in this joint.
    pub damping_ratio: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// A cause at a place.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Suspect {
    /// The cause.
    #[serde(serialize_with = "by_name")]
    #[schemars(with = "String")]
    pub cause: Cause,
    /// Joint, link or mode; null where the cause has no place.
    pub at: Option<String>,
    /// Difference of BIC to the finding or to the best cause.
    pub behind_bic: f64,
}

/// A parameter of a finding.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename = "Parameter")]
pub struct Estimate {
    /// With its unit.
    pub name: String,
    /// In the robot's file; null where no finite value stands for "no effect".
    pub nominal: Option<f64>,
    /// In the unit of the name.
    pub estimate: f64,
    /// 95 % interval; it may reach beyond what was searched.
    pub ci95: [f64; 2],
    /// Whether the estimate lies at an end of what was searched.
    pub at_bound: bool,
}

/// The evidence for a finding.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// BIC with the finding minus BIC without it.
    pub delta_bic: f64,
    /// p-value, corrected for the number of candidates.
    pub p_value: f64,
}

/// A cause that the data justify.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Finding {
    /// The cause.
    #[serde(serialize_with = "by_name")]
    #[schemars(with = "String")]
    pub cause: Cause,
    /// Joint, link or mode; null where the cause has no place.
    pub at: Option<String>,
    /// Alternatives that fit the data about as well, most plausible first.
    pub indistinguishable_from: Vec<Suspect>,
    /// How many more fit about as well.
    pub further_alternatives: usize,
    /// What was fitted.
    pub parameters: Vec<Estimate>,
    /// Axes of the added elastic coordinate, for causes that add one.
    #[serde(serialize_with = "by_names")]
    #[schemars(with = "Option<HingeFields>")]
    pub hinge: Option<Hinge>,
    /// The evidence for it.
    pub evidence: Evidence,
    /// Increase of the error without this finding, percentage points.
    pub gain_percent_points: f64,
    /// What people read about the cause.
    #[serde(skip)]
    pub text: CauseText,
}

/// Axes of an elastic coordinate.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename = "Hinge")]
struct HingeFields {
    /// rotation or translation.
    kind: &'static str,
    /// In the link's frame.
    axes: Vec<[f64; 3]>,
    /// In the link's frame, m, before `depth_m` (down) and `position` (along the link) move it.
    origin_m: [f64; 3],
    /// What of the link's own body moves: "link", "part" (beyond the hinge) or "rest" (nothing).
    carries: &'static str,
}

/// What the findings gain at held-out poses.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gain {
    /// Held-out error of the model minus that with the findings, percentage points.
    pub percent_points: f64,
    /// 95 % interval over resampled poses.
    pub ci95: [f64; 2],
}

/// A correction of the frequencies without a cause: one process a mode.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WithoutCause {
    /// Root mean square error at states left out, %; the processes are fitted in each fold anew.
    pub heldout_rms_percent: f64,
    /// What that gains over the model as it is.
    pub gain: Gain,
    /// By mode; `None` where the table has too few frequencies of it.
    #[serde(skip)]
    pub(super) processes: Vec<Option<Process>>,
}

/// A frequency as a model with its correction has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrectedFrequency {
    /// Hz.
    pub hz: f64,
    /// 95 % interval of the frequency itself, without the noise of a measurement.
    pub ci95_hz: [f64; 2],
}

impl WithoutCause {
    /// What the correction makes of a frequency of the model in Hz: mode `mode` from 0 at joint
    /// positions `q` in rad or m; `None` where the table has too little of that mode.
    pub fn corrected(&self, mode: usize, q: &[f64], model_hz: f64) -> Option<CorrectedFrequency> {
        let Predicted { mean, deviation, freedom } = self.processes.get(mode)?.as_ref()?.at(q);
        let reach = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975);
        let hz = |ln: f64| model_hz * ln.exp();
        let ends = [-reach, reach].map(|reach| hz(mean + reach * deviation));
        Some(CorrectedFrequency { hz: hz(mean), ci95_hz: ends })
    }
}

/// A measured frequency, what it was measured under, and what the models predict.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename = "Residual")]
pub struct ResidualRow {
    /// Row of the table, from 0.
    pub row: usize,
    /// Mode column, from 0; written from 1.
    #[serde(serialize_with = "written::from_one")]
    pub mode: usize,
    /// Hz.
    pub measured_hz: f64,
    /// Hz; null where the model has no such mode.
    #[serde(rename = "model_hz")]
    pub before_hz: Option<f64>,
    /// With the findings, Hz.
    #[serde(rename = "extended_hz")]
    pub after_hz: Option<f64>,
    /// As the written robot has it: with the findings, and with all springs, links and drives
    /// fitted within what they may be off by. Null also where the instrument shows the mode
    /// otherwise.
    pub calibrated_hz: Option<f64>,
    /// As the model with its correction without a cause has it, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_cause_hz: Option<f64>,
    /// 95 % interval of that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_cause_ci95_hz: Option<[f64; 2]>,
    /// Joint positions, rad or m.
    #[serde(skip)]
    pub joints: Vec<f64>,
    /// Temperature, °C.
    #[serde(skip)]
    pub temperature_c: Option<f64>,
    /// Level of excitation, N·m.
    #[serde(skip)]
    pub amplitude_nm: Option<f64>,
}

/// A pose to measure next.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NextPose {
    /// Joint positions from base to tip, rad or m.
    #[serde(rename = "joints_rad")]
    pub joints: Vec<f64>,
    /// The two causes that it separates, each as "cause at place".
    pub separates: [String; 2],
    /// How far it separates them beyond the poses before it, whatever their parameters, in standard
    /// deviations of the noise.
    pub apart_sigmas: f64,
}

/// A test for two causes that no pose separates.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NextTest {
    /// The two causes, each as "cause at place".
    pub separates: [String; 2],
    /// What to do.
    pub test: String,
}

/// Which shape a residual follows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shape {
    /// Each mode has a constant relative error.
    ModeByMode,
    /// All modes follow a joint's position.
    Joint {
        /// From the base, from 0.
        joint: usize,
    },
    /// One mode follows a joint's position.
    ModeOverJoint {
        /// From 0.
        mode: usize,
        /// From the base, from 0.
        joint: usize,
    },
    /// One mode follows the pose as a whole.
    ModeOverPose {
        /// From 0.
        mode: usize,
    },
    /// A spring varies with a joint's position.
    SpringOverJoint {
        /// Its elastic coordinate, by its name in the model that leaves the residual.
        coordinate: String,
        /// From the base, from 0.
        joint: usize,
    },
    /// A spring varies from pose to pose.
    SpringByPose {
        /// Its elastic coordinate, by its name in the model that leaves the residual.
        coordinate: String,
    },
    /// The inertia of an elastic coordinate varies from pose to pose.
    InertiaByPose {
        /// Its elastic coordinate, by its name in the model that leaves the residual.
        coordinate: String,
    },
    /// All modes of a pose are off together.
    PoseByPose,
    /// It follows what the arm carries: its inertia is another with each load.
    Load,
    /// It follows the order of the rows.
    Order,
    /// It follows the temperature.
    Temperature,
    /// It follows the level of excitation.
    Amplitude,
    /// It follows the frequency.
    Frequency,
}

/// The shape that a residual follows most clearly.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// The shape.
    pub shape: Shape,
    /// p-value, corrected for the number of shapes.
    pub p_value: f64,
    /// Share of the residual's variance that the shape explains beyond chance.
    pub share: f64,
    /// Degrees of freedom of the shape.
    pub freedom: usize,
    /// Gain of ln likelihood.
    pub gain: f64,
}

/// Where frequencies mirror.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mirror {
    /// The angle, rad.
    pub centre_rad: f64,
    /// 95 % interval.
    pub ci95_rad: [f64; 2],
}

/// About which angle the frequencies of a table that varies just one joint are the same on both
/// sides.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Symmetry {
    /// beta2 or beta1, or the joint where the robot's file names no such angle for it.
    pub angle: String,
    /// The joint that varies.
    pub joint: String,
    /// The measured frequencies.
    pub measured: Mirror,
    /// Those of the model as it is; null if they mirror about no angle.
    pub model: Option<Mirror>,
    /// Whether the two angles differ by more than their intervals.
    pub differ: bool,
    /// The zero offset of the joint that would make them the same, rad; null if they are or if no
    /// zero is so far off.
    pub zero_offset_rad: Option<f64>,
}

/// A cause that was not tested.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Untested {
    /// The cause.
    #[serde(serialize_with = "by_name")]
    #[schemars(with = "String")]
    pub cause: Cause,
    /// Joint, link or mode; null where the cause has no place.
    pub at: Option<String>,
    /// Joints that its effect depends on and that the table does not state.
    pub joints: Vec<String>,
    /// Whether some of its forms do not depend on them, and were tested.
    pub in_part: bool,
}

/// A whole diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// What was found, in a word.
    pub verdict: Verdict,
    /// Number of poses.
    pub poses: usize,
    /// Errors of the model as it is.
    pub baseline: Errors,
    /// Causes, the one that explains most first.
    pub findings: Vec<Finding>,
    /// Errors of the model with the findings.
    pub extended: Errors,
    /// What the findings gain.
    pub gain: Gain,
    /// Whether the findings predict states left out about as well as they fit the table.
    pub predicts: bool,
    /// Of an unexplained error: what a correction without a cause gains, if it surely does.
    pub without_cause: Option<WithoutCause>,
    /// The level of the noise, %: no model can do better.
    pub noise_floor_percent: f64,
    /// How the noise is made.
    pub noise: NoiseFound,
    /// Joints whose damping the table tells.
    pub damping: Vec<LearnedDamping>,
    /// Rows that fit nothing and were set aside, counted from 1 as in the table.
    pub suspect_rows: Vec<usize>,
    /// What the table teaches about all numbers of the model, with the findings.
    pub posterior: Posterior,
    /// Structure of the residual of the model as it is.
    pub structure_before: Option<Structure>,
    /// Structure of the remaining residual, if it is more than noise.
    pub structure_after: Option<Structure>,
    /// About which angle the frequencies mirror, where the table shows it.
    pub symmetry: Option<Symmetry>,
    /// Causes that depend on joints that the table does not state.
    pub untested: Vec<Untested>,
    /// Poses to measure next.
    pub next_poses: Vec<NextPose>,
    /// Pairs that no pose separates, with the test that does.
    pub next_tests: Vec<NextTest>,
    /// The best single causes, most plausible first, with the difference of BIC to the best.
    pub ranking: Vec<Suspect>,
    /// Every measured frequency.
    pub residuals: Vec<ResidualRow>,
    /// What `robot.yaml` needs to hold.
    pub corrections: Vec<Correction>,
    /// Joints from base to tip, each with whether it slides.
    pub joints: Vec<(String, bool)>,
    /// Warnings about the table.
    pub notes: Vec<Note>,
}

impl Suspect {
    /// "payload at tool0".
    pub fn label(&self) -> String {
        label(self.cause, self.at.as_deref())
    }
}

impl Untested {
    /// "payload at tool0", and whether that is all of it.
    pub fn label(&self) -> String {
        let label = label(self.cause, self.at.as_deref());
        if self.in_part { format!("{label} (in part)") } else { label }
    }
}

impl Finding {
    /// "payload at tool0".
    pub fn label(&self) -> String {
        label(self.cause, self.at.as_deref())
    }

    /// How a part with a frequency of its own moves in the frame of its link: along which axis,
    /// from where, m, and whether the robot file has its mass already. `None` of other causes, and
    /// of a part without a place.
    pub fn hangs(&self) -> Option<([f64; 3], [f64; 3], bool)> {
        let hinge = self.hinge.as_ref().filter(|_| self.cause == Cause::LocalMode)?;
        let axis = hinge.axes.first().filter(|_| self.at.is_some())?;
        Some(((*axis).into(), hinge.origin_m.into(), hinge.carries == Carries::Part))
    }
}

/// "payload at tool0".
pub fn label(cause: Cause, at: Option<&str>) -> String {
    at.map_or_else(|| cause.to_string(), |at| format!("{cause} at {at}"))
}

fn by_name<S: Serializer>(cause: &Cause, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(cause.name())
}

fn by_names<S: Serializer>(hinge: &Option<Hinge>, serializer: S) -> Result<S::Ok, S::Error> {
    let fields = hinge.as_ref().map(|hinge| HingeFields {
        kind: if hinge.turns() { "rotation" } else { "translation" },
        axes: hinge.axes.iter().map(|&axis| axis.into()).collect(),
        origin_m: hinge.origin_m.into(),
        carries: Carries::name(hinge.carries),
    });
    fields.serialize(serializer)
}
