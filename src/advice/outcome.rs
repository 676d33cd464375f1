//! What is advised.

use schemars::JsonSchema;
use serde::Serialize;

use super::depth::DepthAt;
use super::levers::Lever;
use super::options::Options;
use super::ranges::ModeRange;
use super::ribbons::Ribbon;
use super::schedule::{KeptSchedule, NoSchedule, Schedule};
use super::speeds::{Binding, Block, Constant, SafeSet};
use super::vibration::TipVibration;
use crate::motion::StatedFeeds;
use crate::notes::Note;
use crate::process::{NoForce, Seen};
use crate::stability::LimitOf;

/// Advice for one job.
#[derive(Debug, Clone, PartialEq)]
pub struct JobAdvice {
    /// What was asked for.
    pub options: Options,
    /// Half width of the bands, as a share of each frequency.
    pub separation: f64,
    /// What the model may be wrong by at most, as a share of each mode's frequency, ascending.
    pub uncertainty_by_mode: Vec<f64>,
    /// Whether the model was ever compared with measured frequencies.
    pub calibrated: bool,
    /// One per operation, in order.
    pub operations: Vec<OperationAdvice>,
    /// What does not change the advice, but is to be known.
    pub warnings: Vec<Note>,
}

impl JobAdvice {
    /// What the model may be wrong by at most, as a share of any frequency.
    pub fn model_uncertainty(&self) -> f64 {
        self.uncertainty_by_mode.iter().copied().fold(0.0, f64::max)
    }

    /// Whether every operation can be run clear of every band.
    pub fn is_clear(&self) -> bool {
        self.operations.iter().all(|operation| operation.remedy.is_clear())
    }
}

/// Advice for one operation.
#[derive(Debug, Clone, PartialEq)]
pub struct OperationAdvice {
    /// Name of the operation.
    pub name: String,
    /// The programmed speed, or the mean over time of a programmed schedule, rev/min.
    pub programmed_rpm: f64,
    /// What the model may be wrong by at most, as a share of each mode's frequency, ascending.
    pub uncertainty_by_mode: Vec<f64>,
    /// Whether a schedule is programmed.
    pub is_schedule_programmed: bool,
    /// The programmed feed, m/s.
    pub programmed_feed_m_per_s: f64,
    /// Feeds that a program states itself.
    pub program_feeds: StatedFeeds,
    /// What the modes cover along the path.
    pub mode_ranges: Vec<ModeRange>,
    /// Constant speeds.
    pub set: SafeSet,
    /// The blocks in which the programmed speed lies; empty where it is safe, or not checked.
    pub programmed_blocks: Vec<Block>,
    /// Why nothing was checked, so that no speed is known to be safe; `None` where something was.
    pub unchecked: Option<String>,
    /// What to do.
    pub remedy: Remedy,
    /// The best constant speed, where there is one; the same as the remedy's unless a schedule was
    /// asked for.
    pub constant: Option<Constant>,
    /// Why there is no schedule, where one was sought in vain.
    pub no_schedule: Option<NoSchedule>,
    /// What else could open a gap, the best first; empty where a constant speed is safe.
    pub levers: Vec<Lever>,
    /// The bands along the path, in stretches on which the mode counts.
    pub ribbons: Vec<Ribbon>,
    /// What the cutting force does to the tool tip, or why nothing is said about it.
    pub vibration: Result<Vibration, NoForce>,
    /// When the cut chatters, where that is the objective and is known.
    pub depth: Option<Depth>,
    /// What a reader should know of what is to be run: limits of the policy on the tool tip, joints
    /// that poses leave free.
    pub notes: Vec<Note>,
    /// The speed that would be the best, but for a limit that it exceeds.
    pub exceeding_rpm: Option<f64>,
    /// What stands in the way of a constant speed where none is safe: the speed that comes nearest
    /// to being safe, and the two blocks that close it; `None` where gaps are open but too narrow
    /// to set a speed in them.
    pub bind: Option<Binding>,
}

/// Vibration of the tool tip under the cutting force: the root of the sum of the squared amplitudes
/// of its harmonics, without the static deflection; the largest along the path.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vibration {
    /// At the programmed speed.
    pub programmed: TipVibration,
    /// At recommended_rpm; null where that is.
    pub recommended: Option<TipVibration>,
    /// At the quietest speed of each safe stretch, ascending in speed.
    pub quietest: Vec<TipVibration>,
}

/// The depth at which the cut chatters along the path: a statement beside the advice.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "DepthLimits")]
pub struct Depth {
    /// Which modes it is about.
    pub modes: Seen,
    #[allow(missing_docs, reason = "the schema shows what the type says")]
    pub limit_of: LimitOf,
    /// At the programmed speed.
    pub programmed: DepthAt,
    /// At recommended_rpm; null where that is.
    pub recommended: Option<DepthAt>,
}

/// What to do about an operation.
#[derive(Debug, Clone, PartialEq)]
pub enum Remedy {
    /// Run at one safe speed.
    Constant(Constant),
    /// Run at a speed that varies along the path.
    Scheduled(Box<Schedule>),
    /// Run the programmed schedule: it is safe.
    Kept(KeptSchedule),
    /// No speed is safe.
    Infeasible,
}

impl Remedy {
    /// Whether it keeps clear of every band.
    pub fn is_clear(&self) -> bool {
        match self {
            Self::Constant(_) | Self::Kept(_) => true,
            Self::Scheduled(schedule) => schedule.exposures.is_empty(),
            Self::Infeasible => false,
        }
    }
}
