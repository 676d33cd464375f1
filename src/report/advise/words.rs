//! What text and JSON say in common: why this speed, and why none.

use crate::advice::{
    Block, Change, Constant, Coupling, Depth, DepthAt, Lever, NoSchedule, Objective,
    OperationAdvice, Pair, Passage, Remedy, Schedule, SolverEnd, Speeds, TipVibration,
};
use crate::excitation::ExcitationLine;
use crate::job::{Acceptable, Acceptance};
use crate::notes::Code;
use crate::process::Seen;
use crate::report::words::{
    is_uniform, line, percent, round_percent, significant, spelled, trimmed, um_per_n, uncertainty,
};
use crate::risk::Warning;
use crate::study::advise::AdvisedJob;
use crate::units::{deg_from_rad, mm_from_m, percent_from_ratio, um_from_m, um_per_n_from_m_per_n};
use crate::wording::printable;

/// `1312.4 rpm`, with one decimal at most.
pub(in crate::report) fn rpm(rpm: f64) -> String {
    format!("{} rpm", trimmed(rpm, 2))
}

/// `mode 2 with tooth passing × 1`.
pub(super) fn pair(mode: usize, of: &ExcitationLine) -> String {
    format!("mode {mode} with {}", line(of))
}

/// Blocks in one list, each pair of mode and line once.
fn blocks(blocks: &[Block]) -> String {
    let mut names: Vec<String> = blocks.iter().map(|block| pair(block.mode, &block.line)).collect();
    names.dedup();
    names.join(", ")
}

/// In what a resonance may hide at every speed, and what the job accepts.
pub(super) fn warnings(job: &AdvisedJob) -> Vec<(&'static str, String)> {
    let one = |warning: &Warning| match &warning.accepted {
        Some(terms) => Some(("accepted", printable(&format!("{terms}; {}", warning.note)))),
        None if warning.is_open_breach() => Some(("limit", warning.note.to_string())),
        None if is_of_limit(warning) => {
            Some(("doubt", format!("{}; so at the advised speed", warning.note)))
        }
        None if warning.leaves_doubt() => {
            let best = spelled(warning.best_verdict());
            let text =
                format!("{}; the verdict at any speed is no better than {best}", warning.note);
            Some(("doubt", text))
        }
        None => None,
    };
    let crossing = |entry: &Acceptance| {
        let mode = match entry.kind {
            Acceptable::Crossing { mode: Some(mode) } => format!("of mode {mode}"),
            _ => "of any mode".to_owned(),
        };
        let operation = entry.operation.as_ref();
        let within = operation.map_or(String::new(), |name| format!(" in operation '{name}'"));
        let text = format!("{}; crossings {mode}{within}", entry.terms);
        ("accepted", printable(&format!("{text}, which advice avoids all the same")))
    };
    let crossings = job.accepted_crossings.iter().map(crossing);
    let mut all: Vec<_> = job.warnings.iter().filter_map(one).chain(crossings).collect();
    all.dedup();
    all
}

/// Why this advice, in one sentence.
pub(super) fn reason(job: &AdvisedJob, operation: &OperationAdvice) -> String {
    let parts: Vec<String> = reasons(job, operation).into_iter().map(|(_, part)| part).collect();
    let all = parts.join("; ");
    let Remedy::Infeasible = operation.remedy else { return all };
    if operation.unchecked.is_some() {
        return format!("operation '{}': {all}", operation.name);
    }
    let levers = match operation.levers.first() {
        Some(best) if best.rpm.is_some() => format!("to open a gap: {}", lever(best)),
        _ => "no remedy that the job allows opens a gap".to_owned(),
    };
    format!("operation '{}': {all}; {levers}", operation.name)
}

/// Why this advice, fact by fact, each with the name under which a column shows it.
pub(in crate::report) fn reasons(
    job: &AdvisedJob,
    operation: &OperationAdvice,
) -> Vec<(&'static str, String)> {
    if let Some(why) = &operation.unchecked {
        return vec![("why", format!("{why}; so no speed is known to be safe"))];
    }
    let mut facts = Vec::new();
    match &operation.remedy {
        Remedy::Constant(constant) => {
            facts.push(("why", constant_reason(job, operation, constant)));
        }
        Remedy::Scheduled(schedule) => facts.push(("why", scheduled_reason(schedule))),
        Remedy::Kept(_) => {
            let why = "the programmed schedule is safe along the whole path";
            facts.push(("why", why.to_owned()));
        }
        Remedy::Infeasible => {}
    }
    if let (Remedy::Scheduled(_) | Remedy::Kept(_), Some(constant)) =
        (&operation.remedy, operation.constant)
    {
        facts
            .push(("constant", format!("{} is also safe along the whole path", rpm(constant.rpm))));
    }
    if operation.constant.is_none() {
        let is_all = matches!(operation.remedy, Remedy::Infeasible);
        facts.push((if is_all { "why" } else { "constant" }, no_constant(job)));
        facts.push(("binding", binding(operation)));
    }
    facts.extend(operation.no_schedule.map(|why| ("varying", no_schedule(why).to_owned())));
    facts
}

/// Why there is no schedule.
pub(super) fn no_schedule(why: NoSchedule) -> &'static str {
    match why {
        NoSchedule::NoTime => "the path takes no time, so no speed can vary along it",
        NoSchedule::NoWay => {
            "no speed schedule within the spindle's range and acceleration stays clear either"
        }
        NoSchedule::Solver(SolverEnd::Infeasible) => {
            "the solver reports that no speed schedule between the bands is feasible"
        }
        NoSchedule::Solver(SolverEnd::OutOfSteps) => {
            "the solver reached its iteration limit before it found a speed schedule"
        }
        NoSchedule::Solver(SolverEnd::Stuck) => {
            "the solver stalled before it found a speed schedule"
        }
        NoSchedule::Solver(SolverEnd::Solved | SolverEnd::AlmostSolved | SolverEnd::Unexpected) => {
            "the solver stopped for an unexpected reason"
        }
        NoSchedule::Contact => "speed schedules were found, but every one failed the final check",
    }
}

/// Whether a warning holds at one speed only: limits of the policy do.
fn is_of_limit(warning: &Warning) -> bool {
    matches!(warning.note.code, Code::LimitInDoubt | Code::LimitUnchecked)
}

fn constant_reason(job: &AdvisedJob, operation: &OperationAdvice, constant: &Constant) -> String {
    if let Some(best) = operation.exceeding_rpm {
        let best = rpm(best);
        return format!(
            "the safe speed nearest to {best}, which would be best but exceeds a limit of the \
             policy"
        );
    }
    if constant.is_programmed {
        return format!("the programmed {} is safe along the whole path", rpm(constant.rpm));
    }
    let programmed = match operation.is_schedule_programmed {
        true => format!("mean of the programmed schedule, {}", rpm(operation.programmed_rpm)),
        false => format!("programmed {}", rpm(operation.programmed_rpm)),
    };
    let best = match job.advice.options.objective {
        Objective::Nearest => format!("the safe speed nearest to the {programmed}"),
        Objective::Margin => "the speed with the largest margin".to_owned(),
        Objective::Highest => "the highest safe speed".to_owned(),
        Objective::Vibration => "the safe speed at which the tool tip vibrates least".to_owned(),
        Objective::Depth => {
            let what = operation.depth.as_ref().map(|depth| depth.limit_of.short_name());
            let what = what.unwrap_or("depth");
            format!("the safe speed at which the cut stays stable to the largest {what}")
        }
    };
    match operation.programmed_blocks.as_slice() {
        closing @ [_, ..] => {
            let by = blocks(closing);
            match job.advice.options.objective {
                Objective::Nearest => format!("{best}, which is blocked by {by}"),
                _ => format!("{best}; the {programmed} is blocked by {by}"),
            }
        }
        [] if operation.is_schedule_programmed => best,
        [] if !operation.set.holds(operation.programmed_rpm) => {
            format!("{best}; at the {programmed} nothing is checked")
        }
        [] => match job.advice.options.objective {
            Objective::Nearest => format!("{best}, which is also safe"),
            _ => format!("{best}; the {programmed} is also safe"),
        },
    }
}

fn scheduled_reason(plan: &Schedule) -> String {
    let Speeds { low_rpm, high_rpm } = plan.range_rpm;
    let range = format!("{} to {}", trimmed(low_rpm, 1), rpm(high_rpm));
    let aim = match plan.follows {
        Objective::Nearest | Objective::Vibration | Objective::Depth => {
            format!("near {}", rpm(plan.target_rpm))
        }
        Objective::Highest => "as high as it can be".to_owned(),
        Objective::Margin => {
            format!(
                "the widest bands that leave a corridor between them, ±{} %",
                percent(plan.half_width)
            )
        }
    };
    if plan.exposures.is_empty() {
        return match plan.follows {
            Objective::Margin => {
                format!("a speed that varies along the path, {range}, stays clear of {aim}")
            }
            _ => format!(
                "a speed that varies along the path, {range}, {aim}, stays clear of every band"
            ),
        };
    }
    let bands = match plan.passages.as_slice() {
        [_] => "one band".to_owned(),
        _ => format!("{} bands", plan.passages.len()),
    };
    format!(
        "every speed, constant or varying, crosses a band; this schedule, {range}, crosses {bands} \
         as fast as the spindle can and stays clear of all others, {} s in total",
        significant(plan.exposed_s)
    )
}

/// `mode 1 with tooth passing × 1: speed enters the band at 20.01 % of the time with 480.1 rpm,
/// leaves it at 20.39 % with 540.2 rpm; 0.15 s (0.12 s certain), 3 tooth impacts, in the cut,
/// program lines 41–58; …`.
pub(super) fn passage(passage: &Passage) -> String {
    let [enters, leaves] = [passage.from_s, passage.to_s].map(place);
    let [before, after] = [passage.from_rpm, passage.to_rpm].map(|at| trimmed(at, 1));
    let effect = match (passage.is_in_air, passage.tip_amplitude_m) {
        (true, _) => "in the air".to_owned(),
        (false, Some(m)) => {
            format!("in the cut, at most {} µm at the tool tip", significant(um_from_m(m)))
        }
        (false, None) => {
            let tip = um_per_n(passage.tip_response_m_per_n);
            format!("in the cut, {tip} µm/N at the tool tip")
        }
    };
    let lines = match passage.lines {
        [from, to] if from == to => format!("line {from}"),
        [from, to] => format!("lines {from}–{to}"),
    };
    format!(
        "mode {} with {}: enters the band at {enters} % of the time ({before} rpm), leaves it at \
         {leaves} % ({after} rpm), {lines}; {} s, {} tooth impacts, {effect}",
        passage.mode,
        line(&passage.line),
        significant(passage.seconds),
        trimmed(passage.tooth_impacts, 1),
    )
}

/// Place along the path in percent of the time.
fn place(s: f64) -> String {
    trimmed(percent_from_ratio(s), 3)
}

/// What becomes of the feeds that a program states, at this share of them.
pub(super) fn program_feeds(operation: &OperationAdvice, ratio: f64) -> String {
    let own = |what: &str| {
        format!(
            "{what} at {} % keep the chip load (--write-program, or the override)",
            percent(ratio)
        )
    };
    let follow = "follow the speed once the program states it";
    let feeds = operation.program_feeds;
    match (feeds.per_time, feeds.per_revolution) {
        (true, true) => {
            format!("{}; those per revolution {follow}", own("the program's feeds per minute"))
        }
        (false, true) => {
            format!("the program's feeds, all per revolution, {follow}: keep the override at 100 %")
        }
        (_, false) => own("the program's own feeds"),
    }
}

/// What a lever changes: `a tool with 3 teeth (8 mm 3-flute)`.
pub(super) fn change(change: &Change) -> String {
    match change {
        Change::Tool { name, teeth } => {
            let name = name.as_ref().map_or(String::new(), |name| format!(" ({name})"));
            let teeth = if *teeth == 1 { "1 tooth".to_owned() } else { format!("{teeth} teeth") };
            format!("a tool with {teeth}{name}")
        }
        Change::TurnTool { angle_rad } => {
            format!("turn the tool about its axis by {:.1}°", deg_from_rad(*angle_rad))
        }
        Change::MoveWorkObject { shift_m } => {
            let [x, y, z] = shift_m.map(|m| trimmed(mm_from_m(m), 1));
            format!("move the work object by [{x}, {y}, {z}] mm")
        }
        Change::Spindle { rpm: at } => format!("a spindle that can run at {}", rpm(*at)),
        Change::Threshold { mode, tip_response_m_per_n, min_tip_response_m_per_n } => format!(
            "leave out mode {mode}, which moves the tool tip by {} µm/N at most \
             (policy.min_tip_response_um_per_n: {})",
            um_per_n(*tip_response_m_per_n),
            trimmed(um_per_n_from_m_per_n(*min_tip_response_m_per_n), 6)
        ),
        Change::Separation { separation } => {
            format!("a separation of {} %", round_percent(*separation))
        }
        Change::Uncertainty { model_uncertainty } => format!(
            "a model uncertainty of {} % (calibrate with measured frequencies)",
            round_percent(*model_uncertainty)
        ),
    }
}

/// A lever in one phrase, with what it reaches.
pub(super) fn lever(lever: &Lever) -> String {
    let margin = match lever.margin {
        Some(margin) if margin > 0.0 => format!("keeps up to {} %", percent(margin)),
        Some(_) => "no speed has any margin".to_owned(),
        None => "at some speed no counted line meets a mode".to_owned(),
    };
    let opens = match lever.rpm {
        Some(_) if matches!(lever.change, Change::Spindle { .. }) => "is safe".to_owned(),
        Some(at) => format!("opens {}", rpm(at)),
        None => "opens no gap".to_owned(),
    };
    format!("{}: {opens}, {margin}", change(&lever.change))
}

/// When the cut chatters, with what that is about.
pub(super) fn depth(depth: &Depth) -> String {
    let limit_of = depth.limit_of.short_name();
    let one = |at: &DepthAt| match at.smallest.and_then(|at| at.depth_m) {
        Some(limit) => {
            format!("from {:.3} mm of {limit_of} at {}", mm_from_m(limit), rpm(at.rpm))
        }
        None => format!("at no {limit_of} found below 1 m at {}", rpm(at.rpm)),
    };
    let mut all = vec![one(&depth.programmed)];
    all.extend(depth.recommended.iter().map(one));
    all.dedup();
    let whose = match depth.modes {
        Seen::Arm => {
            "; the arm's modes alone (no tool.modes): at milling speeds the tool chatters first"
        }
        Seen::ArmAndTool => "",
    };
    format!("{}{whose}", all.join(", "))
}

/// `12.3 µm at 1100 rpm`.
pub(super) fn tip(tip: &TipVibration) -> String {
    format!("{} µm at {}", significant(um_from_m(tip.amplitude_m)), rpm(tip.rpm))
}

/// What became of the feed under a schedule.
pub(super) fn coupling(plan: &Schedule) -> String {
    match plan.coupling {
        Coupling::MeanChipLoad => match plan.feed_rounds {
            Some(rounds @ 2..) => format!(
                "keeps the mean chip load; solved {rounds} times until the duration settled"
            ),
            _ => "keeps the mean chip load; solved once".to_owned(),
        },
        Coupling::Asked => "as programmed, as asked".to_owned(),
        Coupling::OwnFeeds => "as programmed: the program has feeds of its own".to_owned(),
        Coupling::StandsStill => {
            "as programmed: the time of turns on the spot does not depend on the feed".to_owned()
        }
        Coupling::Rapids => {
            "as programmed: the time of the program's rapid moves does not depend on the feed"
                .to_owned()
        }
        Coupling::Crosses => {
            "as programmed: a slower one, as the chip load asks for, would prolong the crossing"
                .to_owned()
        }
        Coupling::NotSettled => {
            "as programmed: with the mean chip load kept, the duration did not settle".to_owned()
        }
    }
}

fn no_constant(job: &AdvisedJob) -> String {
    let advice = &job.advice;
    let up_to = if is_uniform(&advice.uncertainty_by_mode) { "" } else { "up to " };
    format!(
        "no constant spindle speed in {}..{} rpm stays {up_to}{} % (separation {} %, model \
         uncertainty {}) away from every mode along the whole path",
        trimmed(job.spindle.min_rpm, 2),
        trimmed(job.spindle.max_rpm, 2),
        round_percent(advice.separation + advice.model_uncertainty()),
        round_percent(advice.separation),
        uncertainty(&advice.uncertainty_by_mode),
    )
}

/// What stands in the way of a constant speed.
fn binding(operation: &OperationAdvice) -> String {
    let Some(bind) = &operation.bind else {
        return "the remaining gaps are too narrow to set a speed in them".to_owned();
    };
    let named = |end: &Option<Pair>, or: &str| {
        end.as_ref().map_or(or.to_owned(), |end| pair(end.mode, &end.line))
    };
    let below = named(&bind.below, "the spindle's lowest speed");
    let above = named(&bind.above, "the spindle's highest speed");
    let closest = if bind.separation > 0.0 {
        format!("closest: {}, {} %", rpm(bind.rpm), percent(bind.separation))
    } else {
        format!("no speed has any margin; closest: {}", rpm(bind.rpm))
    };
    format!("{below} from below and {above} from above ({closest})")
}
