//! The output `advice/1`: everything that was found, for programs. Every number is written with all digits
//! of a double; a number that is not finite is refused.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::words;
use crate::advice::{
    self, Change, Coupling, Objective, OperationAdvice, Remedy, Schedule, SolverEnd,
};
use crate::excitation::{ExcitationLine, Source};
use crate::report::json::{NotFinite, Number, laid_out};
use crate::risk::Certainty;
use crate::study::advise::AdvisedJob;
use crate::units::{
    deg_from_rad, mm_from_m, mm_per_min_from_m_per_s, percent_from_ratio, um_from_m,
    um_per_n_from_m_per_n,
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
    /// What was asked for: what makes one speed better than another.
    objective: Objective,
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
    /// The best of them; null where there is none. With status scheduled it is the constant alternative.
    recommended_rpm: Option<Number>,
    /// The feed that belongs to what the status recommends; null where that is nothing.
    recommended_feed_mm_per_min: Option<Number>,
    /// The least distance of any line to any mode at what is recommended, in percent of the mode's frequency;
    /// null where nothing is recommended or nothing counts.
    separation_percent: Option<Number>,
    /// Spindle speed over s, linear in time between; null where a constant speed is recommended or none is safe.
    schedule: Option<Vec<Point>>,
    /// More on the schedule; null where there is none, or where it is the programmed one, which is safe.
    schedule_facts: Option<ScheduleFacts>,
    /// Why there is no schedule where one was sought; null where there is one or a constant speed suffices.
    schedule_missing: Option<&'static str>,
    /// What closes the last gap where no constant speed is safe; null where one is.
    binding: Option<Binding>,
    /// What else could open a gap, the best first; empty where a constant speed is safe. None is applied.
    levers: Vec<Lever>,
    /// What the cutting force moves the tool tip along the path; null where the job does not tell enough of the
    /// cut, see vibration_missing.
    vibration: Option<Vibration>,
    /// Why vibration is null.
    vibration_missing: Option<String>,
    /// The programmed speed (the mean over time of a programmed schedule).
    programmed_rpm: Number,
    programmed_feed_mm_per_min: Number,
    /// Whether a program states feeds of its own per minute or second: these are to be scaled like the feed.
    program_has_own_feeds: bool,
    /// Whether a program states feeds per revolution: they follow the spindle speed by themselves.
    program_has_feeds_per_revolution: bool,
    /// The speeds between the safe ones, and what closes them.
    closed_speeds: Vec<Closed>,
    /// Frequencies that each mode covers along the path.
    mode_ranges: Vec<Range>,
}

/// Two blocks that meet at the speed that comes nearest to being safe.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Binding {
    /// The least distance that this speed keeps, in percent of a mode's frequency; below zero where a mode passes
    /// through the line.
    separation_percent: Number,
    /// The speed that comes nearest; not safe.
    closest_rpm: Number,
    /// What closes in from below; null for the spindle's lowest speed.
    below: Option<Pair>,
    /// What closes in from above; null for the spindle's highest speed.
    above: Option<Pair>,
}

/// A mode and a line.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Pair {
    mode: usize,
    source: Source,
    harmonic: u32,
}

impl From<&advice::Binding> for Binding {
    fn from(bind: &advice::Binding) -> Self {
        let pair = |block: &advice::Block| Pair {
            mode: block.mode,
            source: block.line.source,
            harmonic: block.line.harmonic,
        };
        Self {
            separation_percent: Number(percent_from_ratio(bind.separation)),
            closest_rpm: Number(bind.rpm),
            below: bind.below.as_ref().map(pair),
            above: bind.above.as_ref().map(pair),
        }
    }
}

/// A change besides speed and feed, and what it would reach.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Lever {
    /// `tool`: another cutter of tools_on_hand. `turn_tool`: the tool turned about its own axis.
    /// `move_work_object`: in the base frame. `spindle`: one with another range. `separation`: less of it.
    /// `model_uncertainty`: less of it.
    lever: LeverName,
    /// In words.
    change: String,
    /// Whether a constant speed is safe then.
    opens: bool,
    /// The safe speed nearest to the programmed one then; null where there is none.
    rpm: Option<Number>,
    /// The largest distance from every mode that a constant speed keeps then, in percent of the mode's frequency;
    /// null where nothing counts.
    margin_percent: Option<Number>,
    teeth: Option<u32>,
    angle_deg: Option<Number>,
    shift_mm: Option<[Number; 3]>,
    separation_percent: Option<Number>,
    model_uncertainty_percent: Option<Number>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
enum LeverName {
    Tool,
    TurnTool,
    MoveWorkObject,
    Spindle,
    Separation,
    ModelUncertainty,
}

impl From<&advice::Lever> for Lever {
    fn from(lever: &advice::Lever) -> Self {
        let mut out = Self {
            lever: LeverName::Tool,
            change: words::change(&lever.change),
            opens: lever.rpm.is_some(),
            rpm: lever.rpm.map(Number),
            margin_percent: lever.margin.map(|margin| Number(percent_from_ratio(margin))),
            teeth: None,
            angle_deg: None,
            shift_mm: None,
            separation_percent: None,
            model_uncertainty_percent: None,
        };
        match &lever.change {
            Change::Tool { teeth, .. } => out.teeth = Some(*teeth),
            Change::TurnTool { angle_rad } => {
                out.lever = LeverName::TurnTool;
                out.angle_deg = Some(Number(deg_from_rad(*angle_rad)));
            }
            Change::MoveWorkObject { shift_m } => {
                out.lever = LeverName::MoveWorkObject;
                out.shift_mm = Some(shift_m.map(|m| Number(mm_from_m(m))));
            }
            Change::Spindle { .. } => out.lever = LeverName::Spindle,
            Change::Separation { separation } => {
                out.lever = LeverName::Separation;
                out.separation_percent = Some(Number(percent_from_ratio(*separation)));
            }
            Change::Uncertainty { model_uncertainty } => {
                out.lever = LeverName::ModelUncertainty;
                out.model_uncertainty_percent =
                    Some(Number(percent_from_ratio(*model_uncertainty)));
            }
        }
        out
    }
}

/// Vibration of the tool tip under the cutting force: the root of the sum of the squared amplitudes of its
/// harmonics, without the static deflection; the largest along the path.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Vibration {
    programmed: Tip,
    /// At recommended_rpm; null where that is.
    recommended: Option<Tip>,
    /// At the quietest speed of each safe stretch, ascending in speed.
    quietest: Vec<Tip>,
}

/// The tool tip at one spindle speed.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Tip {
    rpm: Number,
    amplitude_um: Number,
    /// Where it is largest.
    s: Number,
}

impl From<&advice::Vibration> for Vibration {
    fn from(vibration: &advice::Vibration) -> Self {
        Self {
            programmed: (&vibration.programmed).into(),
            recommended: vibration.recommended.as_ref().map(Tip::from),
            quietest: vibration.quietest.iter().map(Tip::from).collect(),
        }
    }
}

impl From<&advice::TipVibration> for Tip {
    fn from(tip: &advice::TipVibration) -> Self {
        Self {
            rpm: Number(tip.rpm),
            amplitude_um: Number(um_from_m(tip.amplitude_m)),
            s: Number(tip.s),
        }
    }
}

/// A corner of a schedule.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Point {
    /// Share of the operation's time, 0 to 1.
    s: Number,
    rpm: Number,
}

/// How a schedule came about, and what it crosses.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ScheduleFacts {
    /// Time from s = 0 to s = 1 at the recommended feed.
    duration_s: Number,
    /// What became of the feed. `mean_chip_load`: it keeps the mean chip load. Otherwise it stays as
    /// programmed: `asked` for; the program has feeds of its own (`own_feeds`); its rapid moves (`rapids`) or turns
    /// on the spot (`stands_still`) take their time whatever the feed; a slower one would draw out the crossing of
    /// a band (`crosses`); the duration did not settle (`not_settled`).
    feed: FeedName,
    /// How often it was solved until the duration settled; null where the feed stays.
    feed_rounds: Option<usize>,
    /// Lowest and highest chip load along the path, in percent of the programmed one.
    chip_load_percent: [Number; 2],
    /// The acceleration that is kept, and whether the job gives none, so that it is assumed.
    acceleration_rpm_per_s: Number,
    acceleration_is_assumed: bool,
    /// The objective that it follows: what was asked for, but `nearest` where vibration was, or where a band is
    /// crossed and margin was.
    follows: Objective,
    /// The speed that it stays near to.
    target_rpm: Number,
    /// Half width of the bands that it keeps out of, in percent of each frequency: the policy's and the model's, or
    /// the widest that leave a way where it follows the margin.
    half_width_percent: Number,
    /// What was minimised: mean square of the distance from target_rpm as a share of the programmed speed, plus 1e-3
    /// times the mean square of the speed's slope over s.
    objective: Number,
    /// The duration for which it was minimised: where a band is crossed it is duration_s within 0.01 %, so the
    /// acceleration is used to the full.
    solved_for_s: Number,
    /// Ways between the bands for which it was minimised.
    corridors_tried: usize,
    solver: SolverEnd,
    /// Where bands are crossed because they must be; empty where the schedule keeps out of all of them.
    exposures: Vec<Exposure>,
    /// The exposures, one for each time that a line goes through a mode's band.
    passages: Vec<Passage>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
enum FeedName {
    MeanChipLoad,
    Asked,
    OwnFeeds,
    Rapids,
    StandsStill,
    Crosses,
    NotSettled,
}

/// A stretch on which a line crosses a mode's widened band.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Exposure {
    mode: usize,
    source: Source,
    harmonic: u32,
    /// Whether the line also lies in the band itself.
    #[schemars(with = "&'static str")]
    certainty: Certainty,
    from_s: Number,
    to_s: Number,
    seconds: Number,
    /// Teeth that enter the work in that time.
    tooth_impacts: Number,
    /// Whether the whole of it is run in the air: at more than twice the operation's feed.
    in_air: bool,
    /// What the mode moves the tool tip at resonance where the line is closest.
    tip_response_um_per_n: Number,
    /// What the cutting force moves the tool tip there; null where the job does not tell enough of the cut.
    tip_amplitude_um: Option<Number>,
}

/// A line going once through a mode's widened band.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Passage {
    mode: usize,
    source: Source,
    harmonic: u32,
    /// Where it enters and leaves the band, and at which speeds.
    from_s: Number,
    to_s: Number,
    from_rpm: Number,
    to_rpm: Number,
    seconds: Number,
    /// Of this, seconds in the band itself, not only in what the model's uncertainty adds to it.
    certain_seconds: Number,
    tooth_impacts: Number,
    in_air: bool,
    tip_response_um_per_n: Number,
    tip_amplitude_um: Option<Number>,
}

impl From<&advice::Passage> for Passage {
    fn from(passage: &advice::Passage) -> Self {
        Self {
            mode: passage.mode,
            source: passage.line.source,
            harmonic: passage.line.harmonic,
            from_s: Number(passage.ends_s[0]),
            to_s: Number(passage.ends_s[1]),
            from_rpm: Number(passage.ends_rpm[0]),
            to_rpm: Number(passage.ends_rpm[1]),
            seconds: Number(passage.seconds),
            certain_seconds: Number(passage.certain_s),
            tooth_impacts: Number(passage.tooth_impacts),
            in_air: passage.is_in_air,
            tip_response_um_per_n: Number(um_per_n_from_m_per_n(passage.tip_response_m_per_n)),
            tip_amplitude_um: passage.tip_amplitude_m.map(|m| Number(um_from_m(m))),
        }
    }
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
    source: Source,
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
            objective: advice.options.objective,
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
        safe_speeds_rpm: operation
            .set
            .safe
            .iter()
            .map(|gap| [Number(gap.low_rpm), Number(gap.high_rpm)])
            .collect(),
        recommended_rpm: operation.constant.map(|constant| Number(constant.rpm)),
        recommended_feed_mm_per_min: feed_m_per_s.map(|feed| Number(mm_per_min_from_m_per_s(feed))),
        separation_percent: separation.map(|apart| Number(percent_from_ratio(apart))),
        schedule: points.map(|points| points.iter().map(Point::from).collect()),
        schedule_facts: schedule.map(facts),
        schedule_missing: operation.no_schedule.map(words::no_schedule),
        binding: operation.bind.as_ref().map(Binding::from),
        levers: operation.levers.iter().map(Lever::from).collect(),
        vibration: operation.vibration.as_ref().ok().map(Vibration::from),
        vibration_missing: operation.vibration.as_ref().err().map(ToString::to_string),
        programmed_rpm: Number(operation.programmed_rpm),
        programmed_feed_mm_per_min: Number(mm_per_min_from_m_per_s(
            operation.programmed_feed_m_per_s,
        )),
        program_has_own_feeds: operation.program_feeds.per_time,
        program_has_feeds_per_revolution: operation.program_feeds.per_revolution,
        closed_speeds: operation.set.closed.iter().map(Closed::from).collect(),
        mode_ranges: operation.mode_ranges.iter().map(Range::from).collect(),
    }
}

fn facts(plan: &Schedule) -> ScheduleFacts {
    let rounds = match plan.coupling {
        Coupling::MeanChipLoad { rounds } => Some(rounds),
        Coupling::Asked
        | Coupling::OwnFeeds
        | Coupling::Rapids
        | Coupling::StandsStill
        | Coupling::Crosses
        | Coupling::NotSettled => None,
    };
    let [low, high] = plan.chip_load_ratios;
    ScheduleFacts {
        duration_s: Number(plan.duration_s),
        feed: match plan.coupling {
            Coupling::MeanChipLoad { .. } => FeedName::MeanChipLoad,
            Coupling::Asked => FeedName::Asked,
            Coupling::OwnFeeds => FeedName::OwnFeeds,
            Coupling::Rapids => FeedName::Rapids,
            Coupling::StandsStill => FeedName::StandsStill,
            Coupling::Crosses => FeedName::Crosses,
            Coupling::NotSettled => FeedName::NotSettled,
        },
        feed_rounds: rounds,
        chip_load_percent: [low, high].map(|ratio| Number(percent_from_ratio(ratio))),
        acceleration_rpm_per_s: Number(plan.acceleration_rpm_per_s),
        acceleration_is_assumed: plan.is_acceleration_assumed,
        follows: plan.follows,
        target_rpm: Number(plan.target_rpm),
        half_width_percent: Number(percent_from_ratio(plan.half_width)),
        objective: Number(plan.objective),
        solved_for_s: Number(plan.solved_for_s),
        corridors_tried: plan.corridors_tried,
        solver: plan.solver,
        exposures: plan.exposures.iter().map(Exposure::from).collect(),
        passages: plan.passages.iter().map(Passage::from).collect(),
    }
}

impl From<&(f64, f64)> for Point {
    fn from(&(s, rpm): &(f64, f64)) -> Self {
        Self { s: Number(s), rpm: Number(rpm) }
    }
}

impl From<&advice::Exposure> for Exposure {
    fn from(exposure: &advice::Exposure) -> Self {
        let crossing = &exposure.crossing;
        Self {
            mode: crossing.mode,
            source: crossing.line.source,
            harmonic: crossing.line.harmonic,
            certainty: crossing.certainty,
            from_s: Number(crossing.from_s),
            to_s: Number(crossing.to_s),
            seconds: Number(exposure.seconds),
            tooth_impacts: Number(exposure.tooth_impacts),
            in_air: exposure.is_in_air,
            tip_response_um_per_n: Number(um_per_n_from_m_per_n(crossing.tip_response_m_per_n)),
            tip_amplitude_um: exposure.tip_amplitude_m.map(|m| Number(um_from_m(m))),
        }
    }
}

impl From<&advice::ClosedRange> for Closed {
    fn from(closure: &advice::ClosedRange) -> Self {
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
            source,
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
