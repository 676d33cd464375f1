//! One operation → its advice.

use super::choice::choose;
use super::depth::DepthModel;
use super::levers::levers;
use super::limits::Limits;
use super::options::{FeedRule, Objective, Options};
use super::outcome::{Depth, JobAdvice, OperationAdvice, Remedy, Vibration};
use super::ranges::{Counting, ModeRange, mode_ranges};
use super::ribbons::ribbons;
use super::schedule::{NoSchedule, Schedule, Task, kept, schedule};
use super::speeds::{Constant, SafeSet, SpeedProblem, feed_at};
use super::vibration::{Chip, TipModel, TipVibration};
use crate::excitation::lines;
use crate::job::{Job, Operation, SpindleSpeed};
use crate::notes::{Code, Note};
use crate::path::{Path, Survey, grid};
use crate::process::Seen;
use crate::progress::Progress;
use crate::risk::{
    Counted, Paths, Rules, SpindleProfile, about_operation, chosen_joints, crossings_under, detail,
    in_operation, nothing_checked, warnings,
};
use crate::uncertainty::{Trust, largest_by_mode};
use crate::units::hz_from_rpm;
use crate::wording::plain;

/// A speed that a check would deny shows frequencies that the first looks missed: they are taken in
/// and the speeds divided anew, so often at most.
const MAX_REVISIONS: usize = 5;

/// Advises every operation of a job.
///
/// # Errors
/// What cannot be run, for every operation.
pub fn advise(job: &Job, options: &Options, progress: Progress) -> Result<JobAdvice, Vec<Note>> {
    let mut faults = Vec::new();
    let mut operations = Vec::new();
    let mut paths = Paths::of(job);
    for index in 0..job.operations.len() {
        match advise_operation(job, index, &mut paths, options, progress) {
            Ok(advice) => operations.push(advice),
            Err(found) => faults.extend(found),
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut notes = Vec::new();
    for (operation, advice) in job.operations.iter().zip(&mut operations) {
        let nothing = nothing(job, operation, advice);
        let not_followed = not_followed(job, operation, advice, options.objective);
        if let Some(why) = nothing {
            let note = about_operation(job, operation, Code::NothingChecked, why.clone());
            if warnings(job, [note.clone()]).iter().all(|warning| warning.accepted.is_none()) {
                leave_unchecked(advice, why);
            }
            notes.push(note);
        }
        notes.extend(not_followed.into_iter().chain(advice.notes.iter().cloned()));
    }
    Ok(JobAdvice {
        warnings: notes,
        options: *options,
        separation: job.policy.separation,
        uncertainty_by_mode: largest_by_mode(
            operations.iter().map(|o| o.uncertainty_by_mode.as_slice()),
        ),
        calibrated: job.robot.calibration().is_some(),
        operations,
    })
}

/// No speed is known to be safe where nothing was checked.
fn leave_unchecked(advice: &mut OperationAdvice, why: String) {
    advice.unchecked = Some(why);
    advice.remedy = Remedy::Infeasible;
    advice.set = SafeSet { safe: Vec::new(), closed: Vec::new() };
    (advice.constant, advice.no_schedule, advice.bind) = (None, None, None);
    advice.levers.clear();
    if let Ok(vibration) = &mut advice.vibration {
        vibration.recommended = None;
        vibration.quietest.clear();
    }
    if let Some(depth) = &mut advice.depth {
        depth.recommended = None;
    }
}

/// Why a safe speed means nothing, where nothing counts.
fn nothing(job: &Job, operation: &Operation, advice: &OperationAdvice) -> Option<String> {
    let separation = match &advice.remedy {
        Remedy::Constant(constant) => constant.separation,
        Remedy::Kept(kept) => kept.separation,
        Remedy::Scheduled(schedule) => schedule.separation,
        Remedy::Infeasible => return None,
    };
    let counted = Counted {
        spindle_turns: operation.own_moves().iter().any(|m| m.spindle_turns),
        lines: separation.is_some() || advice.mode_ranges.is_empty(),
        modes: !advice.mode_ranges.is_empty(),
    };
    nothing_checked(job, &counted)
}

/// A remark where the program can set a share of the speeds alone.
fn steps(job: &Job, operation: &Operation) -> Option<Note> {
    let step = operation.speed_step_rpm.filter(|step| *step > 1.0)?;
    let what = format!(
        "what sets the spindle takes whole numbers of {} rpm each: no speed between them is \
         advised",
        plain(step)
    );
    Some(about_operation(job, operation, Code::SpeedSteps, what))
}

/// A warning where a schedule cannot follow the objective.
fn not_followed(
    job: &Job,
    operation: &Operation,
    advice: &OperationAdvice,
    objective: Objective,
) -> Option<Note> {
    let Remedy::Scheduled(plan) = &advice.remedy else { return None };
    if plan.follows == objective {
        return None;
    }
    let near = match (advice.constant, objective) {
        (Some(_), Objective::Vibration) => "the quietest safe constant speed",
        (Some(_), Objective::Depth) => "the safe constant speed with the largest limit of chatter",
        _ => "the programmed speed",
    };
    let why = match objective {
        Objective::Vibration => "tool-tip vibration is no convex function of a varying speed",
        Objective::Depth => "the limit of chatter is no convex function of a varying speed",
        Objective::Nearest | Objective::Margin | Objective::Highest => {
            "a schedule that must cross a band keeps no margin"
        }
    };
    let what = format!(
        "the schedule does not follow the objective: {why}; it stays near {near}, {} rpm",
        plan.target_rpm
    );
    Some(about_operation(job, operation, Code::ObjectiveNotFollowed, what))
}

fn advise_operation<'j>(
    job: &'j Job,
    index: usize,
    paths: &mut Paths<'j>,
    options: &Options,
    progress: Progress,
) -> Result<OperationAdvice, Vec<Note>> {
    let operation = &job.operations[index];
    let path = paths.plan(operation)?;
    advise_path(job, index, &path, options, progress)
        .map_err(|note| vec![in_operation(job, operation, note)])
}

fn advise_path(
    job: &Job,
    index: usize,
    path: &Path,
    options: &Options,
    progress: Progress,
) -> Result<OperationAdvice, Note> {
    let operation = &job.operations[index];
    let lines = lines(&operation.tool, &job.policy);
    let programmed_rpm = mean_rpm(&operation.speed);
    let tip = TipModel::new(operation, path)?;
    let chip = chip(operation, programmed_rpm, options.feed);
    let stations = grid(path, operation.speed.corners());
    let survey = Survey::take(path, stations, detail(&job.policy), progress)?;
    let trust = Trust::of(&operation.robot, job.policy.model_uncertainty);
    let rules = Rules::new(&job.policy, &trust, path, &survey)?;
    let counting = Counting { rules: &rules, spindle: SpindleProfile::new(&operation.speed, path) };
    let quietest_of =
        |set: &SafeSet| tip.as_ref().map_or_else(|_| Vec::new(), |tip| tip.quietest(set, chip));
    let depth = match options.objective {
        Objective::Depth => DepthModel::new(operation, path)?,
        _ => None,
    };
    let deepest_of =
        |set: &SafeSet| depth.as_ref().map_or_else(Vec::new, |depth| depth.deepest(set));
    let wish = Wish {
        objective: options.objective,
        programmed_rpm,
        quietest_of: &quietest_of,
        deepest_of: &deepest_of,
    };
    let Choice { ranges, set, rpm, quietest, survey } =
        settled(job, operation, path, &counting, &wish, survey)?;
    let problem = SpeedProblem::of((job, operation), &rules, &ranges, &lines);
    let limits = Limits {
        job,
        operation,
        path,
        rules: &rules,
        stations: survey.stations().map(|station| station.s).collect(),
        programmed_rpm,
        feed: options.feed,
    };
    let best_rpm = rpm;
    let rpm = best_rpm.map(|rpm| limits.kept_near(rpm, &problem, &set)).transpose()?;
    let constant = rpm.map(|rpm| Constant {
        rpm,
        feed_m_per_s: match options.feed {
            FeedRule::ChipLoad => feed_at(operation.feed_m_per_s, programmed_rpm, rpm),
            FeedRule::Programmed => operation.feed_m_per_s,
        },
        separation: problem.separation(rpm),
        is_programmed: operation.speed == SpindleSpeed::Constant(rpm),
    });
    let bind = if constant.is_none() { problem.widest() } else { None };
    let task = Task {
        job,
        operation,
        path,
        survey: &survey,
        counting: &counting,
        lines: &lines,
        programmed_rpm,
        objective: options.objective,
        constant_rpm: rpm,
        feed: options.feed,
        tip: tip.as_ref().ok(),
    };
    let (remedy, no_schedule) = remedy_of(&task, constant, options.schedule)?;
    let mut notes = limits.of(&remedy)?;
    notes.extend(chosen_joints(job, operation, path));
    notes.extend(steps(job, operation));
    let levers = match constant {
        Some(_) => Vec::new(),
        None => {
            levers(job, (operation, index, path), &rules, &ranges, bind.as_ref(), programmed_rpm)?
        }
    };
    Ok(OperationAdvice {
        name: operation.name.clone(),
        programmed_rpm,
        uncertainty_by_mode: rules.uncertainty_by_mode(path.robot().coordinates().len()),
        is_schedule_programmed: matches!(operation.speed, SpindleSpeed::Schedule(_)),
        programmed_feed_m_per_s: operation.feed_m_per_s,
        program_feeds: operation.program_feeds,
        remedy,
        no_schedule,
        vibration: tip.as_ref().map_err(|why| *why).map(|tip| Vibration {
            programmed: tip.at(programmed_rpm, chip),
            recommended: constant.map(|constant| tip.at(constant.rpm, chip)),
            quietest,
        }),
        depth: depth.map(|model| Depth {
            modes: if operation.tool.modes.is_empty() { Seen::Arm } else { Seen::ArmAndTool },
            limit_of: model.limit_of(),
            programmed: model.at(programmed_rpm),
            recommended: constant.map(|constant| model.at(constant.rpm)),
        }),
        notes,
        exceeding_rpm: best_rpm.filter(|best| rpm.is_some_and(|rpm| rpm != *best)),
        ribbons: ribbons(&survey, &counting, &lines),
        programmed_blocks: set.blocks_at(programmed_rpm),
        unchecked: None,
        set,
        levers,
        constant,
        bind,
        mode_ranges: ranges,
    })
}

/// What to run, and why no schedule was found where one was looked for: in place of a safe constant
/// speed only if that is asked for.
fn remedy_of(
    task: &Task,
    constant: Option<Constant>,
    always_schedule: bool,
) -> Result<(Remedy, Option<NoSchedule>), Note> {
    if let Objective::Nearest = task.objective
        && let Some(kept) = kept(task)?
    {
        return Ok((Remedy::Kept(kept), None));
    }
    if constant.is_some() && !always_schedule {
        return Ok((remedy(None, constant), None));
    }
    Ok(match schedule(task)? {
        Ok(found) => (remedy(Some(found), constant), None),
        Err(why) => (remedy(None, constant), Some(why)),
    })
}

/// How fast the tool goes through the work when the speed changes.
fn chip(operation: &Operation, programmed_rpm: f64, feed: FeedRule) -> Chip {
    match feed {
        FeedRule::ChipLoad => {
            let teeth_per_s = f64::from(operation.tool.teeth) * hz_from_rpm(programmed_rpm);
            Chip::PerTooth(operation.feed_m_per_s / teeth_per_s)
        }
        FeedRule::Programmed => Chip::Feed(operation.feed_m_per_s),
    }
}

/// A schedule, unless a constant speed does as well.
fn remedy(schedule: Option<Schedule>, constant: Option<Constant>) -> Remedy {
    match (schedule, constant) {
        (Some(schedule), Some(constant))
            if schedule.is_constant(constant.rpm) || schedule.gains_nothing_on(&constant) =>
        {
            Remedy::Constant(constant)
        }
        (Some(schedule), _) => Remedy::Scheduled(Box::new(schedule)),
        (None, Some(constant)) => Remedy::Constant(constant),
        (None, None) => Remedy::Infeasible,
    }
}

/// Which of the safe speeds is wanted.
struct Wish<'a> {
    objective: Objective,
    programmed_rpm: f64,
    quietest_of: &'a dyn Fn(&SafeSet) -> Vec<TipVibration>,
    deepest_of: &'a dyn Fn(&SafeSet) -> Vec<f64>,
}

/// The constant speeds of an operation and the one to run at.
struct Choice {
    ranges: Vec<ModeRange>,
    set: SafeSet,
    /// One that a check passes; `None` where there is none.
    rpm: Option<f64>,
    /// The quietest speed of each gap, where vibration is known.
    quietest: Vec<TipVibration>,
    survey: Survey,
}

/// Divides the speeds and chooses among them until a check passes what was chosen.
fn settled(
    job: &Job,
    operation: &Operation,
    path: &Path,
    counting: &Counting,
    wish: &Wish,
    mut survey: Survey,
) -> Result<Choice, Note> {
    let rules = counting.rules;
    let lines = &lines(&operation.tool, &job.policy);
    let mut look = 0;
    loop {
        let (ranges, refined) = mode_ranges(path, counting, survey)?;
        let problem = SpeedProblem::of((job, operation), rules, &ranges, lines);
        let set = problem.divide(rules.half_width());
        let quietest = (wish.quietest_of)(&set);
        let best_first = match wish.objective {
            Objective::Vibration => quietest_first(&quietest),
            Objective::Depth => (wish.deepest_of)(&set),
            Objective::Nearest | Objective::Margin | Objective::Highest => Vec::new(),
        };
        let chosen = choose(&problem, &set, wish.objective, wish.programmed_rpm, &best_first);
        let Some(rpm) = chosen else {
            return Ok(Choice { ranges, set, rpm: None, quietest, survey: refined });
        };
        let speed = SpindleSpeed::Constant(rpm);
        let (found, closer) = crossings_under(job, operation, rules, &speed, path, refined)?;
        survey = closer;
        if found.is_empty() || look == MAX_REVISIONS {
            let rpm = chosen.filter(|_| found.is_empty());
            return Ok(Choice { ranges, set, rpm, quietest, survey });
        }
        look += 1;
    }
}

fn quietest_first(quietest: &[TipVibration]) -> Vec<f64> {
    let mut best: Vec<&TipVibration> = quietest.iter().collect();
    best.sort_by(|a, b| a.amplitude_m.total_cmp(&b.amplitude_m));
    best.iter().map(|tip| tip.rpm).collect()
}

/// Mean over time.
fn mean_rpm(speed: &SpindleSpeed) -> f64 {
    let ends: Vec<f64> = std::iter::once(0.0)
        .chain(speed.corners().filter(|s| *s > 0.0 && *s < 1.0))
        .chain([1.0])
        .collect();
    let pieces = ends
        .windows(2)
        .map(|end| 0.5 * (speed.rpm_at(end[0]) + speed.rpm_at(end[1])) * (end[1] - end[0]));
    match speed {
        SpindleSpeed::Constant(rpm) => *rpm,
        SpindleSpeed::Schedule(_) => pieces.sum(),
    }
}
