//! The output `advice/1`: everything that was found, for programs. Every number is written with all digits
//! of a double; a number that is not finite is refused.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::{AdvisedJob, words};
use crate::advice::{self, OperationAdvice, Remedy};
use crate::excitation::ExcitationLine;
use crate::report::json::{NotFinite, Number, SourceName, written};
use crate::units::{mm_per_min_from_m_per_s, percent_from_ratio};

/// Objects and lists nested deeper than this stand on one line: an interval, a block.
const DEEPEST_SPREAD: usize = 4;

/// What `detune advise` found, as JSON.
///
/// # Errors
/// If a number is not finite, which would be a fault of the program.
pub fn advice(job: &AdvisedJob) -> Result<String, NotFinite> {
    written(&Advice::from(job), DEEPEST_SPREAD)
}

/// What `detune advise --format json` writes.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune advice/1")]
pub(in crate::report) struct Advice<'a> {
    schema: SchemaName,
    /// The job file, as it was named on the command line.
    job: Cow<'a, str>,
    /// What the job is called.
    name: &'a str,
    /// Half width of a mode's band, in percent of its frequency.
    separation_percent: Number,
    /// How far the model can be trusted.
    model: Model,
    /// One entry an operation, in the order of the job.
    operations: Vec<Operation<'a>>,
}

#[derive(Debug, Serialize, JsonSchema)]
enum SchemaName {
    #[serde(rename = "advice/1")]
    Advice1,
}

/// How far the model can be trusted.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Model {
    /// Whether it was compared with measured frequencies.
    calibrated: bool,
    /// What it may be wrong by, in percent of each frequency.
    uncertainty_percent: Number,
}

/// `constant`: run at recommended_rpm. `scheduled`: run the schedule. `infeasible`: no speed is safe.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
enum Status {
    Constant,
    Scheduled,
    Infeasible,
}

/// Advice for one operation.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Operation<'a> {
    /// What it is called in the job.
    name: &'a str,
    status: Status,
    /// Why, in one sentence.
    reason: String,
    /// The constant speeds that keep every line out of every widened band at every point of the path,
    /// ascending, each as lowest and highest.
    safe_speeds_rpm: Vec<[Number; 2]>,
    /// The best of them; null where there is none.
    recommended_rpm: Option<Number>,
    /// The feed that belongs to it; null where there is none.
    recommended_feed_mm_per_min: Option<Number>,
    /// The least distance of any line to any mode at what is recommended, in percent of the mode's frequency;
    /// null where nothing is recommended or nothing counts.
    separation_percent: Option<Number>,
    /// Spindle speed over s, linear in time between; null where a constant speed is recommended or none is safe.
    schedule: Option<Vec<Point>>,
    /// The programmed speed (the mean over time of a programmed schedule).
    programmed_rpm: Number,
    programmed_feed_mm_per_min: Number,
    /// The speeds between the safe ones, and what closes them.
    closed_speeds: Vec<Closed>,
    /// Frequencies that each mode covers along the path.
    mode_ranges: Vec<Range>,
}

/// A corner of a schedule.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Point {
    /// Share of the operation's time, 0 to 1.
    s: Number,
    rpm: Number,
}

/// Speeds without a safe one among them.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Closed {
    from_rpm: Number,
    to_rpm: Number,
    /// What closes them, ascending in from_rpm.
    blocks: Vec<Block>,
}

/// Speeds at which one line lies in one mode's widened band somewhere along the path.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Block {
    /// Counted from 1 in ascending frequency.
    mode: usize,
    source: SourceName,
    /// Which multiple of the source's own frequency, counted from 1.
    harmonic: u32,
    from_rpm: Number,
    to_rpm: Number,
}

/// Frequencies that a mode covers on the stretches of the path where it counts.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Range {
    /// Counted from 1 in ascending frequency.
    mode: usize,
    lowest_hz: Number,
    lowest_s: Number,
    highest_hz: Number,
    highest_s: Number,
}

impl<'a> From<&'a AdvisedJob> for Advice<'a> {
    fn from(job: &'a AdvisedJob) -> Self {
        let advice = &job.advice;
        Self {
            schema: SchemaName::Advice1,
            job: job.file.to_string_lossy(),
            name: &job.name,
            separation_percent: Number(percent_from_ratio(advice.separation)),
            model: Model {
                calibrated: advice.calibrated,
                uncertainty_percent: Number(percent_from_ratio(advice.model_uncertainty)),
            },
            operations: advice.operations.iter().map(|operation| of(job, operation)).collect(),
        }
    }
}

fn of<'a>(job: &AdvisedJob, operation: &'a OperationAdvice) -> Operation<'a> {
    let constant = match &operation.remedy {
        Remedy::Constant(constant) => Some(constant),
        Remedy::Infeasible(_) => None,
    };
    Operation {
        name: &operation.name,
        status: match operation.remedy {
            Remedy::Constant(_) => Status::Constant,
            Remedy::Infeasible(_) => Status::Infeasible,
        },
        reason: words::reason(job, operation),
        safe_speeds_rpm: operation
            .set
            .safe
            .iter()
            .map(|gap| [Number(gap.low_rpm), Number(gap.high_rpm)])
            .collect(),
        recommended_rpm: constant.map(|c| Number(c.rpm)),
        recommended_feed_mm_per_min: constant
            .map(|c| Number(mm_per_min_from_m_per_s(c.feed_m_per_s))),
        separation_percent: constant
            .and_then(|c| c.separation)
            .map(|separation| Number(percent_from_ratio(separation))),
        schedule: None,
        programmed_rpm: Number(operation.programmed_rpm),
        programmed_feed_mm_per_min: Number(mm_per_min_from_m_per_s(
            operation.programmed_feed_m_per_s,
        )),
        closed_speeds: operation.set.closed.iter().map(Closed::from).collect(),
        mode_ranges: operation.mode_ranges.iter().map(Range::from).collect(),
    }
}

impl From<&advice::Closure> for Closed {
    fn from(closure: &advice::Closure) -> Self {
        Self {
            from_rpm: Number(closure.speeds.low_rpm),
            to_rpm: Number(closure.speeds.high_rpm),
            blocks: closure.blocks.iter().map(Block::from).collect(),
        }
    }
}

impl From<&advice::Block> for Block {
    fn from(block: &advice::Block) -> Self {
        let ExcitationLine { source, harmonic, .. } = block.line;
        Self {
            mode: block.mode,
            source: source.into(),
            harmonic,
            from_rpm: Number(block.speeds.low_rpm),
            to_rpm: Number(block.speeds.high_rpm),
        }
    }
}

impl From<&advice::ModeRange> for Range {
    fn from(range: &advice::ModeRange) -> Self {
        Self {
            mode: range.mode,
            lowest_hz: Number(range.low_hz),
            lowest_s: Number(range.low_s),
            highest_hz: Number(range.high_hz),
            highest_s: Number(range.high_s),
        }
    }
}
