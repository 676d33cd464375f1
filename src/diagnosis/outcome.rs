//! What a diagnosis says: plain data.

use std::fmt;

use super::data::{FEWEST_POINTS, FEWEST_ROWS};
use super::next_poses::NextPose;
use super::unknown::Structure;
use crate::model::{Cause, Correction, Hinge};

/// Why there is no diagnosis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DiagnosisFault {
    /// Too few poses or frequencies.
    TooLittle {
        /// Poses with at least one frequency.
        poses: usize,
        /// Frequencies.
        frequencies: usize,
    },
    /// A row that no table of this robot can have.
    Row {
        /// Of the table, from 0.
        row: usize,
        /// What is wrong with it.
        what: String,
    },
    /// The robot has no modes at a pose of the table, or cannot be built.
    NoModes,
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

impl fmt::Display for DiagnosisFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLittle { poses, frequencies } => write!(
                f,
                "too little data for a diagnosis: {} at {}, must be at least {FEWEST_POINTS} at \
                 {FEWEST_ROWS}; measure more poses",
                counted(*frequencies, "frequency", "frequencies"),
                counted(*poses, "pose", "poses"),
            ),
            Self::Row { row, what } => write!(f, "row {}: {what}", row + 1),
            Self::NoModes => write!(
                f,
                "the model has no modes at a pose of the table; check its stiffness and masses with \
                 detune map"
            ),
        }
    }
}

impl std::error::Error for DiagnosisFault {}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Causes explain what the model gets wrong.
    Explained,
    /// Nothing beyond noise.
    Consistent,
    /// The residual is structured, but no cause earns its place.
    Unexplained,
}

/// Errors of a model, relative to what was measured, %.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// Root mean square over all frequencies.
    pub rms_percent: f64,
    /// The same at poses left out.
    pub heldout_rms_percent: f64,
    /// Root mean square mode by mode.
    pub per_mode_rms_percent: Vec<f64>,
}

/// A cause at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Suspect {
    /// The cause.
    pub cause: Cause,
    /// Joint, link or mode; `None` where the cause has no place.
    pub at: Option<String>,
    /// 2 ln of how much likelier the finding is, parameters paid for (difference of BIC).
    pub behind: f64,
}

/// A parameter of a finding.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Its name, with the unit.
    pub name: String,
    /// In the robot's file; `None` where no finite value stands for "no effect".
    pub nominal: Option<f64>,
    /// As found.
    pub estimate: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
}

/// Why a finding is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// BIC with the finding less BIC without it.
    pub delta_bic: f64,
    /// How often chance does as well with any candidate.
    pub p_value: f64,
}

/// A cause that earned its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The cause.
    pub cause: Cause,
    /// Joint, link or mode; `None` where the cause has no place.
    pub at: Option<String>,
    /// Causes that the data cannot tell from it, most plausible first.
    pub indistinguishable_from: Vec<Suspect>,
    /// What was fitted.
    pub parameters: Vec<Estimate>,
    /// Where something gives, for causes that add an elastic coordinate.
    pub hinge: Option<Hinge>,
    /// Why it is believed.
    pub evidence: Evidence,
    /// What the error would be more without it, percentage points.
    pub gain_percent_points: f64,
}

/// What the findings gain at poses left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Percentage points of held-out error.
    pub percent_points: f64,
    /// 95 % interval over resampled poses.
    pub ci95: [f64; 2],
}

/// A measured frequency, what it was measured under, and what the models say.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualRow {
    /// Row of the table, from 0.
    pub row: usize,
    /// Mode column, from 0.
    pub mode: usize,
    /// Hz.
    pub measured_hz: f64,
    /// Hz; `None` where the model has no such mode.
    pub before_hz: Option<f64>,
    /// With the findings, Hz.
    pub after_hz: Option<f64>,
    /// Joint positions, rad or m.
    pub joints: Vec<f64>,
    /// Temperature, °C.
    pub temperature_c: Option<f64>,
    /// Level of excitation, N·m.
    pub amplitude_nm: Option<f64>,
}

/// What to do where no pose separates two causes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NextTest {
    /// The two causes, each with its place.
    pub separates: [String; 2],
    /// The test that does.
    pub test: &'static str,
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
    /// Errors with the findings put in.
    pub extended: Errors,
    /// What the findings gain.
    pub gain: Gain,
    /// The level of the noise: the best that any model can do.
    pub noise_floor_percent: f64,
    /// What the model as it is leaves.
    pub structure_before: Option<Structure>,
    /// What the findings leave, if it is more than noise.
    pub structure_after: Option<Structure>,
    /// Poses worth measuring.
    pub next_poses: Vec<NextPose>,
    /// Pairs that no pose separates, with the test that does.
    pub next_tests: Vec<NextTest>,
    /// The best causes one by one, most plausible first, with the difference of BIC to the best.
    pub ranking: Vec<Suspect>,
    /// Every measured frequency.
    pub residuals: Vec<ResidualRow>,
    /// What `robot.yaml` needs to hold.
    pub corrections: Vec<Correction>,
    /// Elastic coordinates of the model as it is, for shapes that name one.
    pub coordinates: Vec<String>,
    /// Joints from base to tip, each with whether it slides.
    pub joints: Vec<(String, bool)>,
}

impl Suspect {
    /// "payload at tool0".
    pub fn label(&self) -> String {
        label(self.cause, self.at.as_deref())
    }
}

/// "payload at tool0".
pub(super) fn label(cause: Cause, at: Option<&str>) -> String {
    at.map_or_else(|| cause.to_string(), |at| format!("{cause} at {at}"))
}
