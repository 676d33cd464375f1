//! What a planner reads: the speed to run at, why, and what is closed by what.

use super::words;
use crate::advice::{ClosedRange, FeedRule, NoForce, OperationAdvice, Remedy, Schedule};
use crate::job::Levers;
use crate::report::layout::push_fact;
use crate::report::style;
use crate::report::words::{
    self as words_of_all, is_uniform, percent, round_percent, trimmed, uncertainty,
};
use crate::study::advise::AdvisedJob;
use crate::units::mm_per_min_from_m_per_s;
use crate::wording::printable;

/// At most so many safe and closed stretches of speeds are shown each.
const MAX_STRETCHES: usize = 12;

/// At most so many jobs that cannot be run clear are named at the end.
const MAX_NAMED: usize = 10;

/// At most so many pairs of mode and line are named for one closed stretch.
const MAX_BLOCKS: usize = 4;

/// What `detune advise` found, as text; with colours for a terminal if `colour`.
pub fn advice(job: &AdvisedJob, colour: bool) -> String {
    let mut text = format!(
        "{}  {}\n",
        printable(&job.file.to_string_lossy()),
        style::paint(style::STRONG, printable(&job.name), colour)
    );
    for operation in &job.advice.operations {
        text.push('\n');
        push_operation(job, operation, colour, &mut text);
    }
    text.push('\n');
    for (name, fact) in words::warnings(job) {
        push_fact(2, name, &fact, &mut text);
    }
    push_fact(2, "payload", &words_of_all::carried(job.carried), &mut text);
    push_fact(2, "model", &model(job), &mut text);
    if let Some(settings) = &job.settings {
        push_fact(2, "settings", &words_of_all::settings(settings), &mut text);
    }
    let written = [("job", &job.written_job), ("program", &job.written_program)];
    for (what, path) in written {
        if let Some(path) = path {
            push_fact(
                2,
                "written",
                &format!("the {what} as advised, {}", path.display()),
                &mut text,
            );
        }
    }
    if let Some(overrides) = words_of_all::overrides(&job.overrides) {
        push_fact(2, "policy", &overrides, &mut text);
    }
    push_fact(2, "next", &next(job), &mut text);
    text
}

/// The same of several jobs, and how many of them can be run clear of every band.
pub fn advice_list(jobs: &[&AdvisedJob], colour: bool) -> String {
    let mut text: String = jobs.iter().map(|job| advice(job, colour) + "\n").collect();
    let clear = jobs.iter().filter(|job| job.can_be_run()).count();
    text.push_str(&format!(
        "{} jobs: {clear} can be run clear of every band, {} cannot\n",
        jobs.len(),
        jobs.len() - clear
    ));
    for job in jobs.iter().filter(|job| !job.can_be_run()).take(MAX_NAMED) {
        text.push_str(&format!("  {}\n", words_of_all::path(&job.file)));
    }
    if let more @ 1.. = (jobs.len() - clear).saturating_sub(MAX_NAMED) {
        text.push_str(&format!("  … and {more} more; --format json lists all\n"));
    }
    text
}

fn next(job: &AdvisedJob) -> String {
    let operations = &job.advice.operations;
    let is_kept = |operation: &OperationAdvice| match &operation.remedy {
        Remedy::Constant(constant) => constant.is_programmed,
        Remedy::Kept(_) => true,
        Remedy::Scheduled(_) | Remedy::Infeasible => false,
    };
    if operations.iter().any(|operation| operation.unchecked.is_some()) {
        "put right why nothing was checked, then run advise again".to_owned()
    } else if !job.advice.is_clear() {
        apply_a_lever(job)
    } else if job.exceeds_a_limit() {
        "cut less deep or slower, or change the limit of the policy, then run advise again"
            .to_owned()
    } else if let Some(written) = &job.written_job {
        format!("detune check {}; chatter is not checked", written.display())
    } else if operations.iter().all(is_kept) {
        "run the job as it is; chatter is not checked".to_owned()
    } else {
        let program = if job.is_speed_of_program { " --write-program FILE" } else { "" };
        format!(
            "write the advised job with --write JOB2.yaml{program} and check it; chatter is not \
             checked"
        )
    }
}

/// What to do where a job cannot be run clear: apply a lever that is listed, or allow one that the
/// job does not yet.
fn apply_a_lever(job: &AdvisedJob) -> String {
    let Levers { tools_on_hand, free_axis_rad, work_object_shift_m } = &job.levers;
    let operations = job.advice.operations.iter().enumerate();
    // Joint positions are neither turned nor moved.
    let movable: Vec<usize> = operations
        .filter(|(i, o)| !o.remedy.is_clear() && job.has_poses.get(*i) == Some(&true))
        .map(|(i, _)| i)
        .collect();
    let is_fixed = |i: &usize| free_axis_rad.get(*i).is_none_or(Option::is_none);
    let offers = [
        (tools_on_hand.is_empty(), "tools_on_hand"),
        (work_object_shift_m.is_none() && !movable.is_empty(), "work_object_shift"),
        (movable.iter().any(is_fixed), "free_axis_deg in the operation"),
    ];
    let missing: Vec<&str> =
        offers.iter().filter(|(is_missing, _)| *is_missing).map(|(_, key)| *key).collect();
    let apply = "apply one of the remedies, then run advise again";
    if missing.is_empty() {
        return apply.to_owned();
    }
    format!("{apply}; the job could also allow {}", missing.join(", "))
}

/// What to do about an operation: a word, its colour, and the speed and feed that belong to it.
pub(in crate::report) fn head(operation: &OperationAdvice) -> (&'static str, &'static str, String) {
    let (word, tone) = match &operation.remedy {
        Remedy::Constant(constant) if constant.is_programmed => ("KEEP", style::CLEAR),
        Remedy::Kept(_) => ("KEEP", style::CLEAR),
        Remedy::Constant(_) => ("CHANGE", style::UNCERTAIN),
        Remedy::Scheduled(plan) if plan.exposures.is_empty() => ("SCHEDULE", style::UNCERTAIN),
        Remedy::Scheduled(_) => ("CROSSES", style::RESONANCE),
        Remedy::Infeasible => ("NO SAFE SPEED", style::RESONANCE),
    };
    let head = match &operation.remedy {
        Remedy::Constant(constant) => format!(
            "{}, feed {} mm/min",
            words::rpm(constant.rpm),
            trimmed(mm_per_min_from_m_per_s(constant.feed_m_per_s), 1)
        ),
        Remedy::Scheduled(plan) => format!(
            "{}–{}, feed {} mm/min",
            trimmed(plan.range_rpm.low_rpm, 1),
            words::rpm(plan.range_rpm.high_rpm),
            trimmed(mm_per_min_from_m_per_s(plan.feed_m_per_s), 1)
        ),
        Remedy::Kept(kept) => format!(
            "the programmed schedule, feed {} mm/min",
            trimmed(mm_per_min_from_m_per_s(kept.feed_m_per_s), 1)
        ),
        Remedy::Infeasible => format!("programmed {}", words::rpm(operation.programmed_rpm)),
    };
    (word, tone, head)
}

fn push_operation(job: &AdvisedJob, operation: &OperationAdvice, colour: bool, text: &mut String) {
    let (word, tone, head) = head(operation);
    let name = style::paint(style::STRONG, printable(&operation.name), colour);
    text.push_str(&format!("  {name}  {}  {head}\n", style::paint(tone, word, colour)));
    for (name, fact) in words::reasons(job, operation) {
        push_fact(4, name, &fact, text);
    }
    let separation = match &operation.remedy {
        Remedy::Constant(constant) => Some(constant.separation),
        Remedy::Scheduled(plan) if plan.exposures.is_empty() => Some(plan.separation),
        Remedy::Kept(kept) => Some(kept.separation),
        // What goes through a band keeps no distance.
        Remedy::Scheduled(_) | Remedy::Infeasible => None,
    };
    if let Some(separation) = separation {
        let margin = match separation {
            Some(separation) => format!("{} % from the nearest mode and line", percent(separation)),
            None => "no excitation line or no mode counts".to_owned(),
        };
        push_fact(4, "margin", &margin, text);
    }
    match &operation.remedy {
        Remedy::Scheduled(plan) => push_schedule(operation, plan, text),
        Remedy::Constant(constant)
            if job.advice.options.feed == FeedRule::Programmed && !constant.is_programmed =>
        {
            let ratio = operation.programmed_rpm / constant.rpm;
            let feed =
                format!("as programmed; chip load {} % of the programmed one", percent(ratio));
            push_fact(4, "feed", &feed, text);
        }
        Remedy::Constant(constant) if operation.program_feeds.any() && !constant.is_programmed => {
            let ratio = constant.feed_m_per_s / operation.programmed_feed_m_per_s;
            push_fact(4, "feed", &words::program_feeds(operation, ratio), text);
        }
        Remedy::Constant(_) | Remedy::Kept(_) | Remedy::Infeasible => {}
    }
    for lever in &operation.levers {
        push_fact(4, "remedy", &words::lever(lever), text);
    }
    match &operation.vibration {
        Ok(vibration) => {
            let mut tips = vec![words::tip(&vibration.programmed)];
            tips.extend(vibration.recommended.iter().map(words::tip));
            tips.dedup();
            push_fact(4, "tool tip", &format!("vibrates by {}", tips.join(", ")), text);
        }
        Err(NoForce::NoCutting) => {}
        Err(why @ NoForce::Steady) => push_fact(4, "tool tip", &why.to_string(), text),
        Err(why) => push_fact(4, "tool tip", &format!("unknown: {why}"), text),
    }
    if let Some(depth) = &operation.depth {
        push_fact(4, "chatter", &words::depth(depth), text);
    }
    push_stretches(operation, text);
}

fn push_schedule(operation: &OperationAdvice, plan: &Schedule, text: &mut String) {
    for passage in &plan.passages {
        push_fact(4, "crosses", &words::passage(passage), text);
    }
    let [low, high] = plan.chip_load_ratios;
    let chip_load = if operation.program_feeds.per_revolution {
        "the program's feeds per revolution would follow the speed and shift the schedule along \
         the path; state feeds per minute to run it"
            .to_owned()
    } else {
        format!("chip load {}–{} % of the programmed one", round_percent(low), round_percent(high))
    };
    push_fact(4, "feed", &format!("{}; {chip_load}", words::coupling(plan)), text);
    let origin = if plan.is_acceleration_assumed {
        " (assumed: spindle.max_acceleration_rpm_per_s is not given)"
    } else {
        ""
    };
    let spindle = format!("within {} rpm/s{origin}", trimmed(plan.acceleration_rpm_per_s, 1));
    push_fact(4, "spindle", &spindle, text);
}

fn push_stretches(operation: &OperationAdvice, text: &mut String) {
    let ends = |low: f64, high: f64| format!("{}–{} rpm", trimmed(low, 1), trimmed(high, 1));
    let mut safe: Vec<String> = operation
        .set
        .safe
        .iter()
        .take(MAX_STRETCHES)
        .map(|gap| ends(gap.low_rpm, gap.high_rpm))
        .collect();
    if operation.set.safe.len() > MAX_STRETCHES {
        safe.push(format!("and {} more", operation.set.safe.len() - MAX_STRETCHES));
    }
    let safe = if safe.is_empty() { "none".to_owned() } else { safe.join(", ") };
    push_fact(4, "safe", &safe, text);
    for closure in operation.set.closed.iter().take(MAX_STRETCHES) {
        let ClosedRange { speeds, blocks } = closure;
        let mut names: Vec<String> = Vec::new();
        for block in blocks {
            let name = words::pair(block.mode, &block.line);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let more = names.len().saturating_sub(MAX_BLOCKS);
        names.truncate(MAX_BLOCKS);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let by = format!("{} by {}{more}", ends(speeds.low_rpm, speeds.high_rpm), names.join(", "));
        push_fact(4, "blocked", &by, text);
    }
    if operation.set.closed.len() > MAX_STRETCHES {
        let more = operation.set.closed.len() - MAX_STRETCHES;
        push_fact(4, "blocked", &format!("and {more} more stretches"), text);
    }
}

fn model(job: &AdvisedJob) -> String {
    let advice = &job.advice;
    let bands = round_percent(advice.separation + advice.model_uncertainty());
    let trust = uncertainty(&advice.uncertainty_by_mode);
    let origin = match advice.calibrated {
        true => "calibrated with measured frequencies; uncertainty",
        false => "not calibrated; assumed uncertainty",
    };
    let up_to = if is_uniform(&advice.uncertainty_by_mode) { "" } else { "up to " };
    format!("{origin} {trust}, so bands are {up_to}±{bands} % wide")
}
