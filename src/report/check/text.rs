//! What a planner reads in ten seconds: the verdict, the worst crossing of each operation in words,
//! a small drawing, and what to do next.

use super::findings::{Stretch, stretches};
use super::operation::{CheckedOperation, operations};
use super::{cut, plot_text, sentences};
use crate::process::Chatter;
use crate::report::{layout, style, words};
use crate::risk::{Approach, Certainty, Crossing, OperationRisk, Verdict, Warning};
use crate::study::check::CheckedJob;
use crate::units::percent_from_ratio;
use crate::wording::printable;

/// At most so many crossings follow the worst one.
const MAX_FURTHER: usize = 5;

/// At most so many operations of a job are shown one by one.
const MAX_OPERATIONS: usize = 20;

/// At most so many jobs that are not clear are named at the end.
const MAX_NAMED: usize = 10;

/// At most so many operations of a job are drawn.
const MAX_PLOTS: usize = 4;

/// At most so many swaps of modes are shown.
const MAX_EXCHANGES: usize = 3;

/// Indent of the facts of a job, and of an operation.
const JOB_INDENT: usize = 2;
const OPERATION_INDENT: usize = 6;

/// The results of `detune check` as text; with colours for a terminal if `colour`.
pub fn check(jobs: &[CheckedJob], colour: bool) -> String {
    let mut text = String::new();
    for (index, job) in jobs.iter().enumerate() {
        if index > 0 {
            text.push('\n');
        }
        push_job(job, colour, &mut text);
    }
    if jobs.len() > 1 {
        text.push('\n');
        text.push_str(&summary(jobs, colour));
    }
    text
}

fn push_job(job: &CheckedJob, colour: bool, text: &mut String) {
    let mut verdict = verdict_word(job.risk.verdict, colour);
    if let accepted @ 1.. = sentences::accepted_count(job) {
        verdict.push_str(&format!(" ({accepted} accepted)"));
    }
    let name = style::paint(style::STRONG, printable(&job.name), colour);
    text.push_str(&format!("{verdict}  {}  {name}\n", words::path(&job.file)));
    for doubt in sentences::doubts_of_job(job) {
        layout::push_fact(JOB_INDENT, label(job.risk.verdict), &doubt, text);
    }
    let drawn = drawn(job);
    let shown = shown(job);
    for (index, operation) in operations(job).enumerate() {
        if !shown.contains(&index) {
            continue;
        }
        text.push('\n');
        push_operation(&operation, colour, text);
        if drawn.contains(&index) {
            push_plot(&operation, colour, text);
        }
    }
    push_omitted(job, &shown, colour, text);
    text.push('\n');
    for accepted in sentences::accepted(job) {
        layout::push_fact(JOB_INDENT, "accepted", &accepted, text);
    }
    layout::push_fact(JOB_INDENT, "payload", &words::carried(job.risk.payload), text);
    layout::push_fact(JOB_INDENT, "model", &sentences::model(job), text);
    if let Some(settings) = &job.settings {
        layout::push_fact(JOB_INDENT, "settings", &words::settings(settings), text);
    }
    if let Some(overrides) = words::overrides(&job.overrides) {
        layout::push_fact(JOB_INDENT, "policy", &overrides, text);
    }
    if let Some(explain) = sentences::explain(job) {
        layout::push_fact(JOB_INDENT, "explain", &explain, text);
    }
    layout::push_fact(JOB_INDENT, "next", next(job), text);
}

/// Indices of the operations that are shown: the worst of them, ascending.
fn shown(job: &CheckedJob) -> Vec<usize> {
    let operations = &job.risk.operations;
    let mut worst: Vec<usize> = (0..operations.len()).collect();
    worst.sort_by_key(|&index| std::cmp::Reverse(operations[index].verdict));
    worst.truncate(MAX_OPERATIONS);
    worst.sort_unstable();
    worst
}

fn push_omitted(job: &CheckedJob, shown: &[usize], colour: bool, text: &mut String) {
    let operations = &job.risk.operations;
    if let more @ 1.. = operations.len() - shown.len() {
        let omitted = (0..operations.len()).filter(|index| !shown.contains(index));
        let counts = sentences::counts(omitted.map(|index| operations[index].verdict), colour);
        let line = format!("\n  … and {more} more operations: {counts}; --format json lists all\n");
        text.push_str(&line);
    }
}

fn push_operation(operation: &CheckedOperation<'_>, colour: bool, text: &mut String) {
    let risk = operation.risk;
    text.push_str(&format!(
        "  {}  {}  {}, {} s\n",
        style::paint(style::STRONG, printable(&risk.name), colour),
        verdict_word(risk.verdict, colour),
        sentences::speed(operation) + &tool(operation),
        words::trimmed(risk.duration_s, 1)
    ));
    for breach in sentences::breaches(operation) {
        push_fact("limit", &breach, text);
    }
    for doubt in sentences::doubts(operation) {
        push_fact(label(risk.verdict), &doubt, text);
    }
    let stretches = stretches(&risk.crossings);
    match stretches.split_first() {
        Some((worst, further)) => {
            push_worst(operation, worst, text);
            push_further(operation, further, text);
        }
        None => match risk.closest {
            Some(approach) => push_closest(operation, &approach, text),
            None => push_fact("closest", "no excitation line or no mode counts", text),
        },
    }
    if operation.risk.payload != operation.job.risk.payload {
        push_fact("payload", &words::carried(operation.risk.payload), text);
    }
    if let Some(left_out) = sentences::left_out(operation) {
        push_fact("left out", &left_out, text);
    }
    push_exchanges(risk, text);
    for (label, what) in cut::facts(risk) {
        push_fact(label, &what, text);
    }
}

fn push_worst(operation: &CheckedOperation<'_>, stretch: &Stretch<'_>, text: &mut String) {
    let crossing = stretch.crossing;
    let risk = operation.risk;
    let file = operation.lines_file();
    let file = file.to_string_lossy();
    text.push_str(&format!(
        "    {} meets {}\n",
        words::mode(crossing.mode, crossing.natural_frequency_hz),
        words::line_at(&crossing.line, crossing.excitation_hz)
    ));
    let apart = words::apart(crossing.separation);
    let place = sentences::place_in_band(operation, crossing);
    push_fact("apart", &format!("{apart}, {place}"), text);
    push_fact("interval", &sentences::interval(operation, crossing), text);
    if let Some(probability) = sentences::probability(crossing) {
        push_fact("risk", &probability, text);
    }
    let moves = sentences::moves(crossing);
    if !moves.is_empty() {
        push_fact("moves", &moves, text);
    }
    let mut place = sentences::stretch(risk, crossing.from_s, crossing.to_s);
    if let Some((from_s, to_s)) = stretch.flanks() {
        let percents = words::range(percent_from_ratio(from_s), percent_from_ratio(to_s));
        place.push_str(&format!("; uncertain {percents} %"));
    }
    push_fact("where", &place, text);
    push_fact("closest", &format!("at {}", sentences::point(risk, crossing.closest_s)), text);
    push_fact("lines", &words::lines(&file, crossing.from_line, crossing.to_line), text);
    let tip = words::um_per_n(crossing.tip_response_m_per_n);
    push_fact("tool tip", &format!("{tip} µm/N at resonance"), text);
    if let Some(terms) = &crossing.accepted {
        push_fact("accepted", &terms.to_string(), text);
    }
}

/// What a warning is to a verdict: the reason for it, or something beside it.
fn label(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Uncertain | Verdict::Unchecked => "because",
        Verdict::Clear | Verdict::Resonance => "doubt",
    }
}

fn push_further(operation: &CheckedOperation<'_>, further: &[Stretch<'_>], text: &mut String) {
    if further.is_empty() {
        return;
    }
    let heads = ["mode", "Hz", "meets", "Hz", "apart", "s %", "lines", "µm/N", "certainty"];
    let mut rows = vec![heads.map(str::to_owned)];
    rows.extend(further.iter().take(MAX_FURTHER).map(|stretch| {
        let crossing = stretch.crossing;
        [
            crossing.mode.to_string(),
            words::hz(crossing.natural_frequency_hz),
            words::line(&crossing.line),
            words::hz(crossing.excitation_hz),
            words::apart_in_column(crossing.separation),
            words::range(percent_from_ratio(crossing.from_s), percent_from_ratio(crossing.to_s)),
            words::line_range(crossing.from_line, crossing.to_line),
            words::um_per_n(crossing.tip_response_m_per_n),
            certainty(crossing),
        ]
    }));
    push_fact("further", &further_count(operation, further), text);
    push_table(&rows, text);
    if further.len() > MAX_FURTHER {
        let more = further.len() - MAX_FURTHER;
        text.push_str(&format!("      … and {more} more; --format json lists all\n"));
    }
}

fn certainty(crossing: &Crossing) -> String {
    match crossing.accepted {
        Some(_) => "accepted".to_owned(),
        None => words::spelled(crossing.certainty),
    }
}

fn further_count(operation: &CheckedOperation<'_>, further: &[Stretch<'_>]) -> String {
    let certain = further.iter().filter(|s| s.crossing.certainty == Certainty::Certain).count();
    let file = operation.lines_file();
    format!(
        "{certain} certain, {} uncertain; lines of {}",
        further.len() - certain,
        words::path(&file)
    )
}

/// Columns of the table with words, which start at the left; numbers end at the right.
const WORDS: [bool; 9] = [false, false, true, false, false, false, false, false, true];

fn push_table(rows: &[[String; WORDS.len()]], text: &mut String) {
    let widths: Vec<usize> = (0..WORDS.len())
        .map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
        .collect();
    for row in rows {
        let mut line = String::from("     ");
        for ((cell, &width), words) in row.iter().zip(&widths).zip(WORDS) {
            if words {
                line.push_str(&format!(" {cell:<width$} "));
            } else {
                line.push_str(&format!(" {cell:>width$} "));
            }
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
}

fn push_closest(operation: &CheckedOperation<'_>, approach: &Approach, text: &mut String) {
    let job = operation.job;
    let of_mode = operation.risk.uncertainty_by_mode.get(approach.mode - 1);
    let uncertainty = of_mode.copied().unwrap_or(operation.risk.model_uncertainty);
    push_fact("closest", &sentences::closest(approach), text);
    push_fact("where", &format!("at {}", sentences::point(operation.risk, approach.s)), text);
    let required = format!(
        "{} % (band {} %, model {} %)",
        words::round_percent(job.risk.separation + uncertainty),
        words::round_percent(job.risk.separation),
        words::round_percent(uncertainty),
    );
    push_fact("required", &required, text);
}

fn push_exchanges(risk: &OperationRisk, text: &mut String) {
    for exchange in risk.mode_exchanges.iter().take(MAX_EXCHANGES) {
        let what = format!(
            "modes {} and {} swap order at {} % of the path",
            exchange.lower_mode,
            exchange.lower_mode + 1,
            words::percent(exchange.s)
        );
        push_fact("note", &what, text);
    }
    if let more @ 1.. = risk.mode_exchanges.len().saturating_sub(MAX_EXCHANGES) {
        push_fact("note", &format!("… and {more} more swaps of modes"), text);
    }
}

fn push_fact(name: &str, fact: &str, text: &mut String) {
    // Names of files and coordinates stand in the facts.
    layout::push_fact(OPERATION_INDENT, name, &printable(fact), text);
}

fn push_plot(operation: &CheckedOperation<'_>, colour: bool, text: &mut String) {
    let risk = operation.risk;
    let mut focus: Vec<_> = risk.crossings.iter().map(|c| (c.mode, c.line)).collect();
    if focus.is_empty() {
        focus.extend(risk.closest.map(|closest| (closest.mode, closest.line)));
    }
    let plot = plot_text::frequencies(risk, &focus, colour);
    if !plot.is_empty() {
        text.push('\n');
        text.push_str(&plot);
    }
}

/// Indices of the operations to draw: those that are not clear, or the one with the smallest
/// margin.
fn drawn(job: &CheckedJob) -> Vec<usize> {
    let operations = &job.risk.operations;
    let found: Vec<usize> = (0..operations.len())
        .filter(|&index| operations[index].verdict != Verdict::Clear)
        .take(MAX_PLOTS)
        .collect();
    if !found.is_empty() {
        return found;
    }
    let margin = |index: &usize| {
        operations[*index].closest.map_or(f64::INFINITY, |approach| approach.separation)
    };
    (0..operations.len()).min_by(|a, b| margin(a).total_cmp(&margin(b))).into_iter().collect()
}

/// The tool of a program that loads it by number.
fn tool(operation: &CheckedOperation<'_>) -> String {
    operation.risk.tool.map_or_else(String::new, |number| format!(", tool {number}"))
}

fn verdict_word(verdict: Verdict, colour: bool) -> String {
    style::paint(style::of(verdict), words::spelled(verdict).to_uppercase(), colour)
}

/// What to do.
pub(in crate::report) fn next(job: &CheckedJob) -> &'static str {
    let crossings = job.risk.operations.iter().flat_map(|operation| &operation.crossings);
    let has_open = crossings.into_iter().any(|crossing| crossing.accepted.is_none());
    match (job.risk.verdict, job.risk.calibrated) {
        (Verdict::Uncertain, _) if !has_open && !job.risk.payload.is_known() => {
            "state what the arm carries, then check again; without it no speed counts as clear"
        }
        (Verdict::Resonance, _) if !has_open => {
            "cut less deep, or use another spindle speed, feed or arm pose where a limit is \
             exceeded; then check again"
        }
        (Verdict::Resonance, _) => {
            "use another spindle speed or arm pose on these stretches, then check again"
        }
        (Verdict::Uncertain, _)
            if !has_open && job.risk.warnings.iter().any(Warning::leaves_doubt) =>
        {
            "settle what the verdict is uncertain because of, or accept it in the job with a \
             reason; then check again"
        }
        (Verdict::Uncertain, true) => {
            "keep more distance from the mode, or measure the arm near this pose, then check again"
        }
        (Verdict::Uncertain, false) => {
            "keep more distance from the mode, or calibrate the model with measured frequencies"
        }
        (Verdict::Unchecked, _) => {
            "see the warning for why nothing was checked; put it right, then check again"
        }
        (Verdict::Clear, _) if sentences::accepted_count(job) > 0 => {
            "clear but for what is accepted, which counts again from the day after it ends"
        }
        (Verdict::Clear, _) if any_cut(job, |chatter| chatter.is_beyond) => {
            "no change needed for the arm's resonances, but the cut chatters: cut less deep, or \
             see detune lobes for a speed at which this depth is stable"
        }
        (Verdict::Clear, _) if any_cut(job, |chatter| chatter.may_be_beyond) => {
            "no change needed for the arm's resonances, but with the model's uncertainty the cut \
             may chatter: cut less deep, or see detune lobes for a speed at which this depth is \
             stable"
        }
        (Verdict::Clear, _) if tells_stability(job) => {
            "no change needed for the arm's resonances; what the cut does stands beside the verdict"
        }
        (Verdict::Clear, _) => "no change needed for the arm's resonances; chatter is not checked",
    }
}

fn any_cut(job: &CheckedJob, is_so: impl Fn(&Chatter) -> bool) -> bool {
    let mut all = job.risk.operations.iter().filter_map(|operation| operation.stability.as_ref());
    all.any(is_so)
}

fn tells_stability(job: &CheckedJob) -> bool {
    job.risk.operations.iter().all(|operation| operation.stability.is_some())
}

fn summary(jobs: &[CheckedJob], colour: bool) -> String {
    let counts = sentences::counts(jobs.iter().map(|job| job.risk.verdict), colour);
    let mut text = format!("{} jobs: {counts}\n", jobs.len());
    let worst = sentences::worst_jobs(jobs);
    for job in worst.iter().take(MAX_NAMED) {
        let verdict = verdict_word(job.risk.verdict, colour);
        text.push_str(&format!("  {verdict}  {}\n", words::path(&job.file)));
    }
    if worst.len() > MAX_NAMED {
        let more = worst.len() - MAX_NAMED;
        text.push_str(&format!("  … and {more} more; --format json lists all\n"));
    }
    text
}
