//! The output `advice/1`: everything that was found, for programs. Every number is written with all
//! digits of a double; a number that is not finite is refused.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::words;
use crate::advice::{
    self, Binding, Change, ClosedRange, Depth, ModeRange, Objective, OperationAdvice, Remedy,
    Schedule, Vibration,
};
use crate::job::Settings;
use crate::report::json::{NotFinite, Warning, laid_out};
use crate::study::advise::AdvisedJob;
use crate::units::{
    deg_from_rad, mm_from_m, mm_per_min_from_m_per_s, percent_from_ratio, um_per_n_from_m_per_n,
};

/// Objects and lists nested deeper than this stand on one line: an interval, a block.
const DEEPEST_SPREAD: usize = 4;

/// What `detune advise` found, as JSON.
///
/// # Errors
/// If a number is not finite, which would be a fault of the program.
pub fn advice(job: &AdvisedJob) -> Result<String, NotFinite> {
    laid_out(&Advice::from(job), DEEPEST_SPREAD)
}

/// What `detune advise` found for several jobs, in the order given: each as it is alone.
///
/// # Errors
/// As [`advice()`].
pub fn advice_list(jobs: &[&AdvisedJob]) -> Result<String, NotFinite> {
    let jobs = jobs.iter().map(|job| Advice::from(*job)).collect();
    laid_out(&AdviceList { schema: ListName::AdviceList1, jobs }, DEEPEST_SPREAD + 2)
}

/// What `detune advise --format json` writes of several jobs.
#[derive(Debug, Serialize)]
struct AdviceList<'a> {
    schema: ListName,
    jobs: Vec<Advice<'a>>,
}

#[derive(Debug, Serialize)]
enum ListName {
    #[serde(rename = "advice-list/1")]
    AdviceList1,
}

/// What `detune advise --format json` writes of one job.
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
    separation_percent: f64,
    /// How far the model can be trusted.
    model: Model,
    /// What comes from the settings that jobs share; null where nothing does.
    settings: Option<&'a Settings>,
    /// Keys of the policy that the command line sets, KEY=VALUE.
    policy_overrides: &'a [String],
    /// What was asked for: what makes one speed better than another.
    objective: Objective,
    /// What is to be known beside the advice, by code: in what a resonance may hide at the safe
    /// speeds, too, and what the job accepts.
    warnings: Vec<Warning<'a>>,
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
    uncertainty_percent: f64,
}

/// `constant`: run at recommended_rpm. `scheduled`: run the schedule. `infeasible`: no speed is
/// safe.
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
    /// The constant speeds that keep every line out of every widened band at every point of the
    /// path, ascending, each as lowest and highest.
    safe_speeds_rpm: Vec<[f64; 2]>,
    /// The best of them; null where there is none. With status scheduled it is the constant
    /// alternative.
    recommended_rpm: Option<f64>,
    /// The feed that belongs to what the status recommends; null where that is nothing.
    recommended_feed_mm_per_min: Option<f64>,
    /// The least distance of any line to any mode at what is recommended, in percent of the mode's
    /// frequency; null where nothing is recommended or nothing counts.
    separation_percent: Option<f64>,
    /// Spindle speed over s, linear in time between; null where a constant speed is recommended or
    /// none is safe.
    schedule: Option<Vec<Point>>,
    /// More on the schedule; null where there is none, or where it is the programmed one, which is
    /// safe.
    schedule_facts: Option<&'a Schedule>,
    /// Why there is no schedule where one was sought; null where there is one or a constant speed
    /// suffices.
    schedule_missing: Option<&'static str>,
    /// What closes the last gap where no constant speed is safe; null where one is.
    binding: Option<Binding>,
    /// What else could open a gap, the best first; empty where a constant speed is safe. None is
    /// applied.
    levers: Vec<Lever>,
    /// What the cutting force moves the tool tip along the path; null where the job does not say
    /// enough of the cut, see vibration_missing.
    vibration: Option<&'a Vibration>,
    /// Why vibration is null.
    vibration_missing: Option<String>,
    /// When the cut chatters; only where depth is the objective.
    #[serde(skip_serializing_if = "Option::is_none")]
    depth: Option<&'a Depth>,
    /// The programmed speed (the mean over time of a programmed schedule).
    programmed_rpm: f64,
    programmed_feed_mm_per_min: f64,
    /// Whether a program states feeds of its own per minute or second: these are to be scaled like
    /// the feed.
    program_has_own_feeds: bool,
    /// Whether a program states feeds per revolution: they follow the spindle speed by themselves.
    program_has_feeds_per_revolution: bool,
    /// The speeds between the safe ones, and what closes them.
    closed_speeds: &'a [ClosedRange],
    /// Frequencies that each mode covers along the path.
    mode_ranges: &'a [ModeRange],
}

/// A change besides speed and feed, and what it would reach.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Lever {
    /// `tool`: another cutter of tools_on_hand, or the same with equal pitch. `turn_tool`: the tool
    /// turned about its own axis. `move_work_object`: in the base frame. `spindle`: one with
    /// another range. `min_tip_response`: a threshold that leaves out a mode. `separation`: less of
    /// it. `model_uncertainty`: less of it.
    lever: LeverName,
    /// In words.
    change: String,
    /// Whether a constant speed is safe then.
    opens: bool,
    /// The safe speed nearest to the programmed one then; null where there is none.
    rpm: Option<f64>,
    /// The largest distance from every mode that a constant speed keeps then, in percent of the
    /// mode's frequency; null where nothing counts.
    margin_percent: Option<f64>,
    teeth: Option<u32>,
    angle_deg: Option<f64>,
    shift_mm: Option<[f64; 3]>,
    /// The mode that is left out, counted from 1.
    mode: Option<usize>,
    /// What it moves the tool tip at resonance at most.
    tip_response_um_per_n: Option<f64>,
    /// The threshold to write into the policy.
    min_tip_response_um_per_n: Option<f64>,
    separation_percent: Option<f64>,
    model_uncertainty_percent: Option<f64>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
enum LeverName {
    Tool,
    TurnTool,
    MoveWorkObject,
    Spindle,
    MinTipResponse,
    Separation,
    ModelUncertainty,
}

impl From<&advice::Lever> for Lever {
    fn from(lever: &advice::Lever) -> Self {
        let mut out = Self {
            lever: LeverName::Tool,
            change: words::change(&lever.change),
            opens: lever.rpm.is_some(),
            rpm: lever.rpm,
            margin_percent: lever.margin.map(percent_from_ratio),
            teeth: None,
            angle_deg: None,
            shift_mm: None,
            mode: None,
            tip_response_um_per_n: None,
            min_tip_response_um_per_n: None,
            separation_percent: None,
            model_uncertainty_percent: None,
        };
        match &lever.change {
            Change::Tool { teeth, .. } => out.teeth = Some(*teeth),
            Change::TurnTool { angle_rad } => {
                out.lever = LeverName::TurnTool;
                out.angle_deg = Some(deg_from_rad(*angle_rad));
            }
            Change::MoveWorkObject { shift_m } => {
                out.lever = LeverName::MoveWorkObject;
                out.shift_mm = Some(shift_m.map(mm_from_m));
            }
            Change::Spindle { .. } => out.lever = LeverName::Spindle,
            Change::Threshold { mode, tip_response_m_per_n, min_tip_response_m_per_n } => {
                out.lever = LeverName::MinTipResponse;
                out.mode = Some(*mode);
                out.tip_response_um_per_n = Some(um_per_n_from_m_per_n(*tip_response_m_per_n));
                out.min_tip_response_um_per_n =
                    Some(um_per_n_from_m_per_n(*min_tip_response_m_per_n));
            }
            Change::Separation { separation } => {
                out.lever = LeverName::Separation;
                out.separation_percent = Some(percent_from_ratio(*separation));
            }
            Change::Uncertainty { model_uncertainty } => {
                out.lever = LeverName::ModelUncertainty;
                out.model_uncertainty_percent = Some(percent_from_ratio(*model_uncertainty));
            }
        }
        out
    }
}

/// A corner of a schedule.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Point {
    /// Share of the operation's time, 0 to 1.
    s: f64,
    rpm: f64,
}

impl<'a> From<&'a AdvisedJob> for Advice<'a> {
    fn from(job: &'a AdvisedJob) -> Self {
        let advice = &job.advice;
        Self {
            schema: SchemaName::Advice1,
            job: job.file.to_string_lossy(),
            name: &job.name,
            separation_percent: percent_from_ratio(advice.separation),
            model: Model {
                calibrated: advice.calibrated,
                uncertainty_percent: percent_from_ratio(advice.model_uncertainty()),
            },
            settings: job.settings.as_ref(),
            policy_overrides: &job.overrides,
            objective: advice.options.objective,
            warnings: job.warnings.iter().map(Warning::from).collect(),
            operations: advice.operations.iter().map(|operation| of(job, operation)).collect(),
        }
    }
}

fn of<'a>(job: &AdvisedJob, operation: &'a OperationAdvice) -> Operation<'a> {
    let (schedule, feed_m_per_s, separation) = match &operation.remedy {
        Remedy::Constant(constant) => (None, Some(constant.feed_m_per_s), constant.separation),
        Remedy::Scheduled(plan) => (Some(&**plan), Some(plan.feed_m_per_s), plan.separation),
        Remedy::Kept(kept) => (None, Some(kept.feed_m_per_s), kept.separation),
        Remedy::Infeasible => (None, None, None),
    };
    let points = match &operation.remedy {
        Remedy::Kept(kept) => Some(&kept.points),
        _ => schedule.map(|plan| &plan.points),
    };
    Operation {
        name: &operation.name,
        status: match operation.remedy {
            Remedy::Constant(_) => Status::Constant,
            Remedy::Scheduled(_) | Remedy::Kept(_) => Status::Scheduled,
            Remedy::Infeasible => Status::Infeasible,
        },
        reason: words::reason(job, operation),
        safe_speeds_rpm: operation.set.safe.iter().map(|gap| [gap.low_rpm, gap.high_rpm]).collect(),
        recommended_rpm: operation.constant.map(|constant| constant.rpm),
        recommended_feed_mm_per_min: feed_m_per_s.map(mm_per_min_from_m_per_s),
        separation_percent: separation.map(percent_from_ratio),
        schedule: points.map(|points| points.iter().map(Point::from).collect()),
        schedule_facts: schedule,
        schedule_missing: operation.no_schedule.map(words::no_schedule),
        binding: operation.bind,
        levers: operation.levers.iter().map(Lever::from).collect(),
        vibration: operation.vibration.as_ref().ok(),
        vibration_missing: operation.vibration.as_ref().err().map(ToString::to_string),
        depth: operation.depth.as_ref(),
        programmed_rpm: operation.programmed_rpm,
        programmed_feed_mm_per_min: mm_per_min_from_m_per_s(operation.programmed_feed_m_per_s),
        program_has_own_feeds: operation.program_feeds.per_time,
        program_has_feeds_per_revolution: operation.program_feeds.per_revolution,
        closed_speeds: &operation.set.closed,
        mode_ranges: &operation.mode_ranges,
    }
}

impl From<&(f64, f64)> for Point {
    fn from(&(s, rpm): &(f64, f64)) -> Self {
        Self { s, rpm }
    }
}
