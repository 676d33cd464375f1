//! What a check finds: plain data that holds nothing of the model. Each type is also what
//! `check/1` has of it: order and names of the keys are part of that format.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use super::certainty::Certainty;
use super::tool_tip::ToolTip;
use crate::excitation::{ExcitationLine, WithoutOrder};
use crate::job::{Accepted, Carried};
use crate::notes::{Class, Code, Note, Part};
use crate::process::Chatter;
use crate::uncertainty::Estimate;
use crate::units::written;

/// The answer for an operation, a job or a set of jobs; the worst of its parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
pub enum Verdict {
    /// No line comes near any mode.
    Clear,
    /// A line comes nearer than the model is accurate.
    Uncertain,
    /// Nothing, or nothing that counts, was checked.
    Unchecked,
    /// A line lies inside a mode's band.
    Resonance,
}

/// A stretch of path on which one line stays inside one mode's band, with one certainty.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Crossing {
    /// Counted from 1 in ascending frequency.
    pub mode: usize,
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub certainty: Certainty,
    /// The line.
    #[serde(flatten, with = "WithoutOrder")]
    pub line: ExcitationLine,
    /// The line's frequency at closest_s.
    pub excitation_hz: f64,
    /// The mode's frequency at closest_s.
    pub natural_frequency_hz: f64,
    /// Where it starts, 0 to 1.
    pub from_s: f64,
    /// Where it ends, 0 to 1.
    pub to_s: f64,
    /// Where line and mode are closest.
    pub closest_s: f64,
    /// Distance of line and mode at closest_s, in percent of the mode's frequency.
    #[serde(rename = "separation_percent", serialize_with = "written::percent")]
    pub separation: f64,
    /// What the mode alone moves the tool tip at resonance at closest_s.
    #[serde(rename = "tip_response_um_per_n", serialize_with = "written::um")]
    pub tip_response_m_per_n: f64,
    /// What moves in the mode at closest_s: shares of its strain energy, largest first.
    pub moves: Vec<Move>,
    /// Whether the first two of them turn together; null where that has no meaning.
    pub leading_turn_together: Option<bool>,
    /// In which the mode's frequency lies at closest_s, with the confidence of the policy, Hz.
    pub natural_frequency_ci95_hz: [f64; 2],
    /// That the line lies in the mode's band somewhere on the stretch; never below one over the
    /// number of draws. Null where nobody asked.
    pub probability: Option<f64>,
    /// What most of the doubt about the frequency comes from; null where one figure says it.
    pub driver: Option<Driver>,
    /// Why it counts no more, where the job accepts it.
    pub accepted: Option<Accepted>,
    /// The file that the lines refer to: the program as the job names it, else the job file as it
    /// was named on the command line.
    #[serde(serialize_with = "written::path")]
    pub file: PathBuf,
    /// The lowest line that is run between from_s and to_s, counted from 1.
    pub from_line: usize,
    /// The highest line that is run between from_s and to_s.
    pub to_line: usize,
}

/// The parameter of the model with the largest part in the variance of a frequency.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Driver {
    /// What it is.
    pub parameter: String,
    /// Its part, 0 to 1.
    pub share: f64,
}

/// A coordinate's part in a mode.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Move {
    /// Name of the elastic coordinate.
    pub coordinate: String,
    /// Share of the mode's strain energy, 0 to 1.
    pub share: f64,
}

/// The arm at one place of the path.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sample {
    /// Share of the operation's time, 0 to 1.
    pub s: f64,
    /// Joint positions from base to tip (m for a prismatic joint).
    #[serde(rename = "joints_rad")]
    pub joints: Vec<f64>,
    /// Null where the robot does not define it.
    pub beta1_rad: Option<f64>,
    /// Null where the robot does not define it.
    pub beta2_rad: Option<f64>,
    /// 0 where the program has stopped the spindle.
    #[serde(rename = "spindle_rpm")]
    pub rpm: f64,
    /// Ascending.
    pub natural_frequencies_hz: Vec<f64>,
    /// Per mode, in which its frequency lies, with the confidence of the policy.
    pub natural_frequencies_ci95_hz: Vec<[f64; 2]>,
    /// Per mode, what it alone moves the tool tip at resonance, in its strongest direction.
    #[serde(rename = "tip_response_um_per_n", serialize_with = "written::um")]
    pub tip_response_m_per_n: Vec<f64>,
    /// Per mode, the index (from 0) that it had at s = 0, followed by shape; null where it was
    /// lost.
    pub families: Vec<Option<usize>>,
}

/// A place where two neighbouring modes change places in the order of frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Exchange")]
pub struct ModeExchange {
    /// Where, 0 to 1.
    pub s: f64,
    /// The lower of the two, counted from 1.
    pub lower_mode: usize,
}

/// A mode and a line at one place of the path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Closest")]
pub struct Approach {
    /// Counted from 1 in ascending frequency.
    pub mode: usize,
    /// The line.
    #[serde(flatten, with = "WithoutOrder")]
    pub line: ExcitationLine,
    /// The line's frequency there.
    pub excitation_hz: f64,
    /// The mode's frequency there.
    pub natural_frequency_hz: f64,
    /// Share of the operation's time, 0 to 1.
    pub s: f64,
    /// Distance of line and mode, in percent of the mode's frequency.
    #[serde(rename = "separation_percent", serialize_with = "written::percent")]
    pub separation: f64,
}

/// A programmed spindle speed at one place of the path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedPoint {
    /// Share of the operation's time, 0 to 1.
    pub s: f64,
    /// Speed, linear in s between such points.
    pub rpm: f64,
}

/// What the policy leaves out: a verdict says nothing about it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LeftOut {
    /// Lines that lie in ignored bands all along the path.
    pub lines: Vec<ExcitationLine>,
    /// Modes that nowhere move the tool tip enough to count, counted from 1.
    pub modes: Vec<usize>,
}

impl LeftOut {
    /// Whether everything was considered.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty() && self.modes.is_empty()
    }
}

/// One operation.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Operation")]
pub struct OperationRisk {
    /// What it is called in the job.
    pub name: String,
    /// The program that the lines of its crossings refer to, as the job names it; `None` where they
    /// refer to the job file.
    #[serde(skip)]
    pub program: Option<PathBuf>,
    /// The worst of its crossings that are not accepted, and no better than its warnings leave it.
    pub verdict: Verdict,
    /// Number of the tool in the program; null where there is none.
    pub tool: Option<u32>,
    /// What the tip carries.
    pub payload: Carried,
    /// Programmed spindle speed at s = 0.
    pub spindle_rpm: f64,
    /// Lowest programmed spindle speed.
    pub spindle_min_rpm: f64,
    /// Highest programmed spindle speed.
    pub spindle_max_rpm: f64,
    /// The programmed speeds, linear in s between; null where one speed holds.
    pub spindle_schedule: Option<Vec<SpeedPoint>>,
    /// Time from s = 0 to s = 1.
    pub duration_s: f64,
    /// That a line lies in a mode's band somewhere, what is accepted left out; never below one over
    /// the number of draws.
    pub probability: f64,
    /// Its standard error.
    pub probability_std_error: f64,
    /// What the model may be wrong by at most, in percent of any frequency.
    #[serde(rename = "uncertainty_percent", serialize_with = "written::stated_percent")]
    pub model_uncertainty: f64,
    /// The same of each mode alone, ascending.
    #[serde(rename = "uncertainty_by_mode_percent", serialize_with = "written::percent")]
    pub uncertainty_by_mode: Vec<f64>,
    /// What a mode must move the tool tip at resonance to count.
    #[serde(rename = "min_tip_response_um_per_n", serialize_with = "written::stated_um_per_n")]
    pub min_tip_response_m_per_n: f64,
    /// The excitation lines that were looked at, ascending.
    pub lines: Vec<ExcitationLine>,
    /// What does not count on the whole path, by policy.
    pub left_out: LeftOut,
    /// Where some line comes nearest to some mode among the samples; null where nothing counts.
    pub closest: Option<Approach>,
    /// Poses at which the eigenproblem was solved to find the crossings.
    pub poses_solved: usize,
    /// The arm along the path, ascending in s, both ends included: at every pose that was looked
    /// at, or, beyond 5000 of them, at so many that neighbours are no more than 1/2000 apart in s.
    pub samples: Vec<Sample>,
    /// Stretches on which a line lies inside a mode's band, ascending in from_s.
    pub crossings: Vec<Crossing>,
    /// Where neighbouring modes change places in the order of frequency.
    pub mode_exchanges: Vec<ModeExchange>,
    /// What the cut does at the tool tip; only where its force is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool_tip: Option<ToolTip>,
    /// When the cut chatters, beside the verdict; only where its coefficients are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stability: Option<Chatter>,
}

/// What a check finds for one job.
#[derive(Debug, Clone, PartialEq)]
pub struct JobRisk {
    /// The worst of the operations.
    pub verdict: Verdict,
    /// Whether the model was ever compared with measured frequencies.
    pub calibrated: bool,
    /// What the tip carries: in the first operation, or in one of which nobody says it.
    pub payload: Carried,
    /// What the model may be wrong by at most, as a share of any frequency.
    pub model_uncertainty: f64,
    /// The same of each mode alone, ascending.
    pub uncertainty_by_mode: Vec<f64>,
    /// That a line lies in a mode's band somewhere in any operation, what is accepted left out.
    pub probability: Estimate,
    /// Half width of the bands, as a share of each frequency.
    pub separation: f64,
    /// Names of the elastic coordinates.
    pub coordinates: Vec<String>,
    /// One per operation, in order.
    pub operations: Vec<OperationRisk>,
    /// On the files that were read, then in the order of the operations.
    pub warnings: Vec<Warning>,
}

/// A warning on a job or on one of its operations.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// What is to be known.
    pub note: Note,
    /// The operation that it is about; `None` for the job as a whole.
    pub operation: Option<String>,
    /// Why it counts no more, where the job accepts it.
    pub accepted: Option<Accepted>,
}

impl Warning {
    /// The best verdict that it leaves.
    pub fn best_verdict(&self) -> Verdict {
        match (self.note.code.class(), &self.accepted) {
            // What nobody looked at is not clear because somebody accepts that.
            (_, Some(_)) if self.note.code == Code::NothingChecked => Verdict::Uncertain,
            (_, Some(_)) | (Class::Remark | Class::Error, None) => Verdict::Clear,
            (Class::Doubt, None) if self.note.code == Code::NothingChecked => Verdict::Unchecked,
            (Class::Doubt, None) => Verdict::Uncertain,
            (Class::Breach, None) => Verdict::Resonance,
        }
    }

    /// Whether a resonance may hide in what it is about.
    pub fn leaves_doubt(&self) -> bool {
        self.best_verdict() > Verdict::Clear
    }

    /// Whether it is more than a remark: a doubt, or a limit that is exceeded.
    pub fn counts(&self) -> bool {
        matches!(self.note.code.class(), Class::Doubt | Class::Breach)
    }

    /// Whether a limit of the policy is exceeded, which the job does not accept.
    pub fn is_open_breach(&self) -> bool {
        self.accepted.is_none() && self.note.code.class() == Class::Breach
    }

    /// Whether it would count, had the job not accepted it.
    pub fn is_accepted_doubt(&self) -> bool {
        self.accepted.is_some() && self.counts()
    }

    /// Whether it takes part in the verdict on an operation.
    pub fn is_about(&self, operation: &str) -> bool {
        self.operation.as_deref().is_none_or(|name| name == operation)
    }
}

impl From<Note> for Warning {
    fn from(note: Note) -> Self {
        let operation = match &note.place.part {
            Some(Part::Operation(name)) => Some(name.clone()),
            _ => None,
        };
        Self { note, operation, accepted: None }
    }
}
