//! The output `check/1`: everything that a check found, for programs. Every number is written with all
//! digits of a double; a number that is not finite is refused.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

use super::operation::{CheckedOperation, operations};
use crate::excitation::{ExcitationLine, Source};
use crate::notes::Note;
use crate::report::json::{NotFinite, Number, laid_out};
use crate::risk::{self, Certainty, LeftOut, Verdict};
use crate::study::check::CheckedJob;
use crate::units::{percent_from_ratio, um_per_n_from_m_per_n};

/// Objects and lists nested deeper than this stand on one line: a sample, a crossing.
const DEEPEST_SPREAD: usize = 6;

/// The results of `detune check` as JSON, one entry a job, in the order given, with all samples of the
/// results: every pose that was looked at, or, beyond 5000 of them in an operation, so many that
/// neighbours are no more than 1/2000 apart in s.
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
    separation_percent: Number,
    /// How far the model can be trusted.
    model: Model<'a>,
    /// Remarks that do not change the verdict, such as a verdict about nothing, as on standard error.
    notices: Vec<String>,
    /// One entry an operation, in the order of the job.
    operations: Vec<Operation<'a>>,
}

/// How far the model can be trusted.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Model<'a> {
    /// Whether it was compared with measured frequencies.
    calibrated: bool,
    /// What it may be wrong by, in percent of each frequency.
    uncertainty_percent: Number,
    /// Names of its elastic coordinates.
    coordinates: &'a [String],
}

/// One operation.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Operation<'a> {
    /// What it is called in the job.
    name: &'a str,
    /// The worst of its crossings.
    verdict: Verdict,
    /// Programmed spindle speed at s = 0.
    spindle_rpm: Number,
    /// Lowest programmed spindle speed.
    spindle_min_rpm: Number,
    /// Highest programmed spindle speed.
    spindle_max_rpm: Number,
    /// The programmed speeds, linear in s between; null where one speed holds.
    spindle_schedule: Option<Vec<SpeedPoint>>,
    /// Time from s = 0 to s = 1.
    duration_s: Number,
    /// The excitation lines that were looked at, ascending.
    lines: &'a [ExcitationLine],
    /// What does not count on the whole path, by policy.
    left_out: &'a LeftOut,
    /// Where some line comes nearest to some mode among the samples; null where nothing counts.
    closest: Option<Closest>,
    /// Poses at which the eigenproblem was solved to find the crossings.
    poses_solved: usize,
    /// The arm along the path, ascending in s, both ends included: at every pose that was looked at, or,
    /// beyond 5000 of them, at so many that neighbours are no more than 1/2000 apart in s.
    samples: Vec<Sample<'a>>,
    /// Stretches on which a line lies inside a mode's band, ascending in from_s.
    crossings: Vec<Crossing<'a>>,
    /// Where neighbouring modes change places in the order of frequency.
    mode_exchanges: Vec<Exchange>,
}

/// A programmed spindle speed at one place of the path.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct SpeedPoint {
    /// Share of the operation's time, 0 to 1.
    s: Number,
    rpm: Number,
}

/// A mode and a line at one place of the path.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Closest {
    /// Counted from 1 in ascending frequency.
    mode: usize,
    source: Source,
    harmonic: u32,
    excitation_hz: Number,
    natural_frequency_hz: Number,
    /// Share of the operation's time, 0 to 1.
    s: Number,
    /// Distance of line and mode, in percent of the mode's frequency.
    separation_percent: Number,
}

/// The arm at one place of the path.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Sample<'a> {
    /// Share of the operation's time, 0 to 1.
    s: Number,
    /// Joint positions from base to tip (m for a prismatic joint).
    joints_rad: Vec<Number>,
    /// Null where the robot does not define it.
    beta1_rad: Option<Number>,
    /// Null where the robot does not define it.
    beta2_rad: Option<Number>,
    /// 0 where the program has stopped the spindle.
    spindle_rpm: Number,
    /// Ascending.
    natural_frequencies_hz: Vec<Number>,
    /// Per mode, what it alone moves the tool tip at resonance, in its strongest direction.
    tip_response_um_per_n: Vec<Number>,
    /// Per mode, the index (from 0) that it had at s = 0, followed by shape; null where it was lost.
    families: &'a [Option<usize>],
}

/// A stretch of path on which one line stays inside one mode's band, with one certainty.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Crossing<'a> {
    /// Counted from 1 in ascending frequency.
    mode: usize,
    certainty: Certainty,
    source: Source,
    /// Which multiple of the source's own frequency, counted from 1.
    harmonic: u32,
    /// The line's frequency at closest_s.
    excitation_hz: Number,
    /// The mode's frequency at closest_s.
    natural_frequency_hz: Number,
    from_s: Number,
    to_s: Number,
    /// Where line and mode are closest.
    closest_s: Number,
    /// Distance of line and mode at closest_s, in percent of the mode's frequency.
    separation_percent: Number,
    /// What the mode alone moves the tool tip at resonance at closest_s.
    tip_response_um_per_n: Number,
    /// What moves in the mode at closest_s: shares of its strain energy, largest first.
    moves: Vec<Move<'a>>,
    /// Whether the first two of them turn together; null where that has no meaning.
    leading_turn_together: Option<bool>,
    /// The file that the lines refer to: the program as the job names it, else the job file as it was named
    /// on the command line.
    file: Cow<'a, str>,
    /// The lowest line that is run between from_s and to_s, counted from 1.
    from_line: usize,
    /// The highest line that is run between from_s and to_s.
    to_line: usize,
}

/// A coordinate's part in a mode.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Move<'a> {
    coordinate: &'a str,
    /// Share of the mode's strain energy, 0 to 1.
    share: Number,
}

/// A place where two neighbouring modes change places in the order of frequency.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Exchange {
    s: Number,
    /// The lower of the two, counted from 1.
    lower_mode: usize,
}

impl<'a> From<&'a CheckedJob> for Job<'a> {
    fn from(job: &'a CheckedJob) -> Self {
        Self {
            job: job.file.to_string_lossy(),
            name: &job.name,
            verdict: job.risk.verdict,
            separation_percent: Number(percent_from_ratio(job.risk.separation)),
            model: Model {
                calibrated: job.risk.calibrated,
                uncertainty_percent: Number(percent_from_ratio(job.risk.model_uncertainty)),
                coordinates: &job.risk.coordinates,
            },
            notices: job.notices.iter().map(Note::to_string).collect(),
            operations: operations(job).map(Operation::from).collect(),
        }
    }
}

impl<'a> From<CheckedOperation<'a>> for Operation<'a> {
    fn from(operation: CheckedOperation<'a>) -> Self {
        let risk = operation.risk;
        let [spindle_min_rpm, spindle_max_rpm] = operation.rpm_range().map(Number);
        let point = |&(s, rpm): &(f64, f64)| SpeedPoint { s: Number(s), rpm: Number(rpm) };
        Self {
            name: &risk.name,
            verdict: risk.verdict,
            spindle_rpm: Number(risk.spindle_rpm),
            spindle_min_rpm,
            spindle_max_rpm,
            spindle_schedule: operation.schedule().map(|points| points.iter().map(point).collect()),
            duration_s: Number(risk.duration_s),
            lines: &risk.lines,
            left_out: &risk.left_out,
            closest: risk.closest.map(Closest::from),
            poses_solved: risk.poses_solved,
            samples: risk.samples.iter().map(Sample::from).collect(),
            crossings: risk
                .crossings
                .iter()
                .map(|crossing| crossing_of(&operation, crossing))
                .collect(),
            mode_exchanges: risk
                .exchanges
                .iter()
                .map(|exchange| Exchange { s: Number(exchange.s), lower_mode: exchange.lower_mode })
                .collect(),
        }
    }
}

impl From<risk::Approach> for Closest {
    fn from(approach: risk::Approach) -> Self {
        Self {
            mode: approach.mode,
            source: approach.line.source,
            harmonic: approach.line.harmonic,
            excitation_hz: Number(approach.excitation_hz),
            natural_frequency_hz: Number(approach.natural_frequency_hz),
            s: Number(approach.s),
            separation_percent: Number(percent_from_ratio(approach.separation)),
        }
    }
}

impl<'a> From<&'a risk::Sample> for Sample<'a> {
    fn from(sample: &'a risk::Sample) -> Self {
        let numbers = |values: &[f64]| values.iter().copied().map(Number).collect();
        Self {
            s: Number(sample.s),
            joints_rad: numbers(&sample.joints),
            beta1_rad: sample.beta1_rad.map(Number),
            beta2_rad: sample.beta2_rad.map(Number),
            spindle_rpm: Number(sample.rpm),
            natural_frequencies_hz: numbers(&sample.natural_frequencies_hz),
            tip_response_um_per_n: sample
                .tip_response_m_per_n
                .iter()
                .map(|&response| Number(um_per_n_from_m_per_n(response)))
                .collect(),
            families: &sample.families,
        }
    }
}

fn crossing_of<'a>(operation: &CheckedOperation<'a>, crossing: &'a risk::Crossing) -> Crossing<'a> {
    Crossing {
        mode: crossing.mode,
        certainty: crossing.certainty,
        source: crossing.line.source,
        harmonic: crossing.line.harmonic,
        excitation_hz: Number(crossing.excitation_hz),
        natural_frequency_hz: Number(crossing.natural_frequency_hz),
        from_s: Number(crossing.from_s),
        to_s: Number(crossing.to_s),
        closest_s: Number(crossing.closest_s),
        separation_percent: Number(percent_from_ratio(crossing.separation)),
        tip_response_um_per_n: Number(um_per_n_from_m_per_n(crossing.tip_response_m_per_n)),
        moves: operation
            .moves(crossing)
            .into_iter()
            .map(|(coordinate, share)| Move { coordinate, share: Number(share) })
            .collect(),
        leading_turn_together: crossing.leading_turn_together,
        file: operation.program().unwrap_or(&operation.job.file).to_string_lossy(),
        from_line: crossing.from_line,
        to_line: crossing.to_line,
    }
}
