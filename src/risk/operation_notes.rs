//! What a planner should know of operations beside their crossings.

use super::about::{about_operation, in_operation};
use super::verdict::OperationRisk;
use crate::job::{Job, Operation, SpindleSpeed};
use crate::notes::{Code, Note, Place};
use crate::path::Path;
use crate::units::um_per_n_read_as;

/// Measured arms have their first mode at 7 to 26 Hz: less than half of that, or eight times as
/// much, is a mistake in the model.
pub const FIRST_FREQUENCY_HZ: [f64; 2] = [3.0, 200.0];

/// What a planner should know of an operation beside its crossings.
pub(super) fn on_operation(
    job: &Job,
    operation: &Operation,
    path: &Path,
    risk: &OperationRisk,
) -> Vec<Note> {
    /// A path of no length takes what rounding leaves of it, s.
    const NO_TIME_S: f64 = 1e-9;
    let nothing = match path.duration_s() > NO_TIME_S {
        true => nothing_checked(job, &Counted::new(path, risk)),
        false => Some("nothing was checked: nothing moves on the path".to_owned()),
    };
    let nothing = nothing.map(|what| (Code::NothingChecked, what));
    let sudden = too_sudden(job, operation, path).map(|what| (Code::SpindleAcceleration, what));
    let mut warnings: Vec<Note> = nothing
        .into_iter()
        .chain(sudden)
        .map(|(code, what)| about_operation(job, operation, code, what))
        .collect();
    warnings.extend(chosen_joints(job, operation, path));
    if let Some(start) = path.found_start() {
        let what = format!(
            "the arm starts at {start}: nearer positions reach the first target and cannot run the \
             path; start_near_deg chooses"
        );
        warnings.push(about_operation(job, operation, Code::Assumed, what));
    }
    if let Some((line, said, start)) = path.open_start() {
        let what = format!(
            "the arm starts at {start}; other arm configurations reach the first target, too, and \
             {said} is not compared with them: write start_near_deg in the job's operation, these \
             or others"
        );
        let place = Place { line: Some(line), ..Place::default() };
        warnings.push(in_operation(
            job,
            operation,
            Note::warning(Code::ChangeIgnored, place, what),
        ));
    }
    if let Some((line, what, others)) = path.beside_configuration() {
        let others = match others {
            0 => String::new(),
            1 => "; the same at one further target".to_owned(),
            more => format!("; the same at {more} further targets"),
        };
        let (code, taken) = match path.misses_configuration() {
            true => (Code::ChangeIgnored, "the nearest are taken, and the controller takes others"),
            false => (Code::Assumed, "those in the quadrant beside it are taken"),
        };
        let what = format!(
            "no joint positions reach the target in the arm configuration that the program asks \
             for; {taken} ({what}){others}; check tcp and work_object"
        );
        let place = Place { line: Some(line), ..Place::default() };
        warnings.push(in_operation(job, operation, Note::warning(code, place, what)));
    }
    if let Some(line) = path.open_configuration() {
        let what = "several joint positions reach the target about as near to the arm \
                    configuration that the program asks for: the nearest are taken";
        let place = Place { line: Some(line), ..Place::default() };
        warnings.push(in_operation(
            job,
            operation,
            Note::warning(Code::ChangeIgnored, place, what),
        ));
    }
    if let Some((line, asked)) = path.open_sides() {
        let what = format!(
            "other joint positions reach the target, too, and which of them {asked} asks for is \
             not known: the nearest are taken; teach the position in joints"
        );
        let place = Place { line: Some(line), ..Place::default() };
        let note = Note::warning(Code::ChangeIgnored, place, what);
        warnings.push(in_operation(job, operation, note));
    }
    if let Some(overspeed) = path.worst_joint_overspeed() {
        let what = format!(
            "{overspeed}; the robot will be slower there than assumed{}",
            if overspeed.is_reorientation {
                ", as reorientations are timed by the mean speed of their slowest joint"
            } else {
                "; lower the feed"
            }
        );
        let place = Place { line: Some(path.line_at(overspeed.s)), ..Place::default() };
        if matches!(operation.speed, SpindleSpeed::Schedule(_)) {
            let what = "the spindle schedule runs in time, and the arm comes later than its feed \
                        says: the speeds are checked at other places than they will run";
            let note = Note::warning(Code::ScheduleTiming, place.clone(), what);
            warnings.push(in_operation(job, operation, note));
        }
        warnings.push(in_operation(job, operation, Note::warning(Code::FeedLimit, place, what)));
    }
    warnings
}

/// A doubt where poses leave the arm a choice: frequencies depend on where the controller goes.
pub fn chosen_joints(job: &Job, operation: &Operation, path: &Path) -> Option<Note> {
    path.leaves_choice().then(|| {
        let what = format!(
            "a pose fixes six of the {} joints: the way on which they move least is checked, and \
             the controller's may be another; give joint waypoints, or map the axes that the \
             program states under external_axes",
            path.robot().joints().len()
        );
        about_operation(job, operation, Code::RedundantArm, what)
    })
}

/// Whether there is anything that a verdict could be about.
#[derive(Debug, Clone, Copy)]
pub struct Counted {
    /// Whether the spindle turns anywhere.
    pub spindle_turns: bool,
    /// Whether any excitation line counts.
    pub lines: bool,
    /// Whether any mode counts.
    pub modes: bool,
}

impl Counted {
    /// Of an operation that was checked.
    pub(super) fn new(path: &Path, risk: &OperationRisk) -> Self {
        Self {
            spindle_turns: path.spindle_turns(),
            lines: risk.left_out.lines.len() < risk.lines.len(),
            modes: risk.left_out.modes.len() < path.robot().coordinates().len(),
        }
    }
}

/// A clear verdict means nothing where the spindle stands all along, or the policy leaves every
/// line or every mode out.
pub fn nothing_checked(job: &Job, counted: &Counted) -> Option<String> {
    if !counted.spindle_turns {
        return Some(
            "nothing was checked: the program has stopped the spindle on the whole path".to_owned(),
        );
    }
    if !counted.lines {
        return Some(
            "nothing was checked: every excitation line lies in policy.ignore_hz".to_owned(),
        );
    }
    if !counted.modes {
        return Some(format!(
            "nothing was checked: every mode moves the tool tip less than \
             policy.min_tip_response_um_per_n, {}",
            um_per_n_read_as(job.policy.min_tip_response_m_per_n.unwrap_or(0.0))
        ));
    }
    None
}

/// The steepest piece of a schedule that asks more of the spindle than it can.
fn too_sudden(job: &Job, operation: &Operation, path: &Path) -> Option<String> {
    /// A schedule at the limit is not beyond it: rounding.
    const ROUNDING: f64 = 1e-9;
    let most = job.spindle.acceleration_rpm_per_s();
    let SpindleSpeed::Schedule(points) = &operation.speed else { return None };
    let pieces = points.windows(2).enumerate().map(|(index, pair)| {
        let seconds = (pair[1].0 - pair[0].0) * path.duration_s();
        (index, pair, (pair[1].1 - pair[0].1).abs() / seconds)
    });
    let limit = most * (1.0 + ROUNDING);
    let beyond = pieces.filter(|&(_, pair, rate)| pair[0].1 != pair[1].1 && rate > limit);
    let (index, pair, rate) = beyond.max_by(|a, b| a.2.total_cmp(&b.2))?;
    let ([(_, from), (_, to)], next) = ([pair[0], pair[1]], index + 1);
    let asked = if rate.is_finite() { format!("{rate:.1} rpm/s") } else { "a jump".to_owned() };
    let is_assumed = job.spindle.max_acceleration_rpm_per_s.is_none();
    let who = if is_assumed { "is not given, and assumed to be" } else { "is" };
    Some(format!(
        "spindle_schedule[{index}] to [{next}], from {from} to {to} rpm, requires {asked}; \
         spindle.max_acceleration_rpm_per_s {who} {most}"
    ))
}

/// A first frequency that no arm has: the stiffness or the masses are wrong by far.
pub(super) fn implausible_frequency(job: &Job, operations: &[OperationRisk]) -> Option<Note> {
    let samples = operations.iter().flat_map(|operation| {
        operation.samples.iter().map(move |sample| (operation.name.as_str(), sample))
    });
    let first = samples.filter_map(|(name, sample)| {
        Some((name, sample.s, *sample.natural_frequencies_hz.first()?))
    });
    let [least_hz, most_hz] = FIRST_FREQUENCY_HZ;
    let (name, s, lowest_hz) = first.min_by(|a, b| a.2.total_cmp(&b.2))?;
    if (least_hz..=most_hz).contains(&lowest_hz) {
        return None;
    }
    let what = format!(
        "the first natural frequency is {lowest_hz:.3} Hz at its lowest (operation '{name}', s = \
         {s:.3}), where arms have {least_hz} to {most_hz} Hz; check stiffness (N·m/rad), masses \
         and the units of both"
    );
    Some(Note::warning(Code::FirstFrequency, Place::file(&job.file), what))
}
