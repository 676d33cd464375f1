//! What the renderers of a check say in common: a finding in one sentence.

use super::findings::{Finding, Stretch, findings};
use super::operation::{CheckedOperation, operations};
use crate::notes::{Code, Note};
use crate::report::style;
use crate::report::words::{
    apart, hz, line, line_at, mode, number, percent, range, round_percent, spelled, trimmed,
    um_per_n, uncertainty,
};
use crate::risk::{Approach, Certainty, Crossing, OperationRisk, Sample, Verdict, Warning};
use crate::study::check::CheckedJob;
use crate::units::{deg_from_rad, percent_from_ratio};
use crate::wording::printable;

/// A coordinate that carries less of a mode than this is not named, unless it carries the most.
const MIN_SHARE_NAMED: f64 = 0.1;

/// At most so many doubts, or accepted warnings, are listed.
const MAX_LISTED: usize = 4;

/// At most so many coordinates are named.
const MAX_SHARES_NAMED: usize = 3;

/// `joint_3 71 %, joint_2 24 %, turning against each other`; empty where shares are not known.
pub(in crate::report) fn moves(crossing: &Crossing) -> String {
    let moves = &crossing.moves;
    let named = moves.iter().take_while(|m| m.share >= MIN_SHARE_NAMED).count();
    let named = named.clamp(1, MAX_SHARES_NAMED).min(moves.len());
    let mut text = moves[..named]
        .iter()
        .map(|m| format!("{} {:.0} %", printable(&m.coordinate), percent_from_ratio(m.share)))
        .collect::<Vec<_>>()
        .join(", ");
    if named >= 2 {
        match crossing.leading_turn_together {
            Some(true) if named == 2 => text.push_str(", turning together"),
            Some(false) if named == 2 => text.push_str(", turning against each other"),
            Some(true) => text.push_str(", the first two turning together"),
            Some(false) => text.push_str(", the first two turning against each other"),
            None => {}
        }
    }
    text
}

/// `spindle × 1 (ignored 49–51 Hz), modes 5, 6 (below 0.5 µm/N)`, and what of it hangs on a tcp
/// that nobody states; `None` where everything counts.
pub(in crate::report) fn left_out(operation: &CheckedOperation<'_>) -> Option<String> {
    let (left_out, policy) = (&operation.risk.left_out, &operation.job.policy);
    if left_out.is_empty() {
        return None;
    }
    let mut parts = Vec::new();
    if !left_out.lines.is_empty() {
        let lines: Vec<String> = left_out.lines.iter().map(line).collect();
        let bands: Vec<String> =
            policy.ignore_hz.iter().map(|[from, to]| format!("{from}–{to}")).collect();
        parts.push(format!("{} (ignored {} Hz)", lines.join(", "), bands.join(", ")));
    }
    if !left_out.modes.is_empty() {
        let modes: Vec<String> = left_out.modes.iter().map(usize::to_string).collect();
        let s = if modes.len() == 1 { "" } else { "s" };
        let least = um_per_n(operation.risk.min_tip_response_m_per_n);
        parts.push(format!("mode{s} {} (below {least} µm/N)", modes.join(", ")));
    }
    let warnings = operation.job.risk.warnings.iter();
    let own =
        warnings.filter(|w| w.note.code == Code::TcpAssumed && w.is_about(&operation.risk.name));
    parts.extend(own.map(|warning| warning.note.what.clone()));
    Some(parts.join("; "))
}

/// β2 at the sample next to `s`, `β2 68.2°`, if the robot defines it.
pub(in crate::report) fn beta2(operation: &OperationRisk, s: f64) -> Option<String> {
    let beta2 = sample_next_to(operation, s)?.beta2_rad?;
    Some(format!("β2 {}°", number(deg_from_rad(beta2), 1)))
}

fn sample_next_to(operation: &OperationRisk, s: f64) -> Option<&Sample> {
    operation.samples.iter().min_by(|a, b| (a.s - s).abs().total_cmp(&(b.s - s).abs()))
}

/// `12.0–31.0 % of the path (1.5–3.8 s)`.
pub(in crate::report) fn stretch(operation: &OperationRisk, from_s: f64, to_s: f64) -> String {
    format!(
        "{} % of the path ({} s)",
        range(percent_from_ratio(from_s), percent_from_ratio(to_s)),
        range(from_s * operation.duration_s, to_s * operation.duration_s)
    )
}

/// `20.0 % (2.46 s, β2 68.2°)`.
pub(in crate::report) fn point(operation: &OperationRisk, s: f64) -> String {
    let beta2 = beta2(operation, s).map_or(String::new(), |beta2| format!(", {beta2}"));
    format!("{} % ({} s{beta2})", percent(s), trimmed(s * operation.duration_s, 2))
}

/// `inside the band of ±10 %`.
pub(in crate::report) fn place_in_band(
    operation: &CheckedOperation<'_>,
    crossing: &Crossing,
) -> String {
    let band = round_percent(operation.job.risk.separation);
    match crossing.certainty {
        Certainty::Certain => format!("inside the band of ±{band} %"),
        Certainty::Uncertain if crossing.driver.is_some() => {
            format!("outside the band of ±{band} % but within that of the interval")
        }
        Certainty::Uncertain => format!(
            "outside the band of ±{band} % but within the model uncertainty of ±{} %",
            round_percent(operation.job.risk.model_uncertainty)
        ),
    }
}

/// `38.4–46.7 Hz with 95 % confidence; 81 % of its variance is due to stiffness of joint_2`.
pub(in crate::report) fn interval(operation: &CheckedOperation<'_>, crossing: &Crossing) -> String {
    let [low, high] = crossing.natural_frequency_ci95_hz.map(hz);
    let confidence = round_percent(operation.job.policy.confidence);
    let driver = crossing.driver.as_ref().map_or_else(String::new, |driver| {
        let share = round_percent(driver.share);
        format!("; {share} % of its variance is due to {}", printable(&driver.parameter))
    });
    format!("{low}–{high} Hz with {confidence} % confidence{driver}")
}

/// `40 % that the line lies in the band on this stretch`; `None` where nobody asked.
pub(in crate::report) fn probability(crossing: &Crossing) -> Option<String> {
    let probability = crossing.probability?;
    let shown = match percent_from_ratio(probability) {
        percent if percent < 0.1 => "below 0.1".to_owned(),
        percent if percent < 10.0 => number(percent, 1),
        percent => number(percent, 0),
    };
    Some(format!("{shown} % that the line lies in the band on this stretch"))
}

/// `2 resonance, 1 uncertain, 9 clear`: how many there are of each verdict, the worst first.
pub(in crate::report) fn counts(verdicts: impl Iterator<Item = Verdict>, colour: bool) -> String {
    let verdicts: Vec<Verdict> = verdicts.collect();
    let counts: Vec<String> =
        [Verdict::Resonance, Verdict::Unchecked, Verdict::Uncertain, Verdict::Clear]
            .into_iter()
            .filter_map(|of| {
                let count = verdicts.iter().filter(|verdict| **verdict == of).count();
                let text = format!("{count} {}", spelled(of));
                (count > 0).then(|| style::paint(style::of(of), text, colour))
            })
            .collect();
    counts.join(", ")
}

/// The jobs that are not clear, the worst first, else in their order.
pub(in crate::report) fn worst_jobs(jobs: &[CheckedJob]) -> Vec<&CheckedJob> {
    let mut worst: Vec<_> = jobs.iter().filter(|job| job.risk.verdict > Verdict::Clear).collect();
    worst.sort_by_key(|job| std::cmp::Reverse(job.risk.verdict));
    worst
}

/// A doubt in one sentence, with what it does to the verdict or why it does nothing.
pub(in crate::report) fn doubt(warning: &Warning) -> String {
    let message = warning.note.message();
    let what = match &warning.accepted {
        Some(terms) => format!("accepted {terms}"),
        None => {
            format!("so the verdict is no better than {}", spelled(warning.best_verdict()))
        }
    };
    printable(&format!("{message}; {what}"))
}

/// What says more of a job's warnings: one command with their codes.
pub(super) fn explain(job: &CheckedJob) -> Option<String> {
    let open = job.risk.warnings.iter().filter(|warning| warning.accepted.is_none());
    let mut codes: Vec<&str> = open.map(|warning| warning.note.code.name()).collect();
    codes.sort_unstable();
    codes.dedup();
    (!codes.is_empty()).then(|| format!("detune explain {}", codes.join(" ")))
}

/// What leaves the verdicts on all operations in doubt: warnings on the job as a whole.
pub(in crate::report) fn doubts_of_job(job: &CheckedJob) -> Vec<String> {
    let doubts = job.risk.warnings.iter().filter(|w| w.leaves_doubt() && w.operation.is_none());
    listed(doubts.map(|warning| warning.note.to_string()))
}

/// What leaves the verdict on this operation alone in doubt.
pub(in crate::report) fn doubts(operation: &CheckedOperation<'_>) -> Vec<String> {
    let name = Some(operation.risk.name.as_str());
    let own = operation.job.risk.warnings.iter();
    let own = own.filter(|w| w.leaves_doubt() && w.operation.as_deref() == name);
    listed(own.filter(|w| !w.is_open_breach()).map(at_its_place))
}

/// Limits of the policy that are exceeded in this operation.
pub(in crate::report) fn breaches(operation: &CheckedOperation<'_>) -> Vec<String> {
    let own = operation.job.risk.warnings.iter();
    let own = own.filter(|w| w.is_open_breach() && w.is_about(&operation.risk.name));
    own.map(at_its_place).collect()
}

fn at_its_place(warning: &Warning) -> String {
    // The part stands above.
    let Note { place, what, .. } = &warning.note;
    if place.file.is_some() { format!("{place}: {what}") } else { what.clone() }
}

/// What the job accepts: warnings, each once.
pub(in crate::report) fn accepted(job: &CheckedJob) -> Vec<String> {
    let one = |warning: &Warning| {
        let terms = warning.accepted.as_ref()?;
        Some(printable(&format!("{terms}; {}: {}", warning.note.code, warning.note)))
    };
    let mut all: Vec<String> = job.risk.warnings.iter().filter_map(one).collect();
    all.dedup();
    listed(all.into_iter())
}

/// What stands between the model and the truth.
pub(in crate::report) fn model(job: &CheckedJob) -> String {
    let uncertainty = uncertainty(&job.risk.uncertainty_by_mode);
    if job.risk.calibrated {
        format!("calibrated with measured frequencies; uncertainty {uncertainty}")
    } else {
        format!("not calibrated; assumed uncertainty {uncertainty}")
    }
}

/// Where nothing meets: the line that comes nearest to a mode, and how far it stays away.
pub(in crate::report) fn closest(approach: &Approach) -> String {
    format!(
        "{} stays {} away from {}",
        line_at(&approach.line, approach.excitation_hz),
        apart(approach.separation),
        mode(approach.mode, approach.natural_frequency_hz),
    )
}

/// `1100 rpm`, or `1200–1350 rpm` under a schedule.
pub(in crate::report) fn speed(operation: &CheckedOperation<'_>) -> String {
    let [low, high] = [operation.risk.spindle_min_rpm, operation.risk.spindle_max_rpm];
    if low < high {
        format!("{}–{} rpm", trimmed(low, 1), trimmed(high, 1))
    } else {
        format!("{} rpm", trimmed(low, 1))
    }
}

/// How many findings the job accepts: crossings, and doubts.
pub(in crate::report) fn accepted_count(job: &CheckedJob) -> usize {
    let of_crossings = |operation: CheckedOperation<'_>| {
        let found = findings(&operation).into_iter();
        found.filter(|finding| finding.worst.crossing.accepted.is_some()).count()
    };
    let mut doubts: Vec<&Note> = Vec::new();
    for warning in job.risk.warnings.iter().filter(|warning| warning.is_accepted_doubt()) {
        if !doubts.contains(&&warning.note) {
            doubts.push(&warning.note);
        }
    }
    operations(job).map(of_crossings).sum::<usize>() + doubts.len()
}

/// The first of them, and how many more there are.
fn listed(texts: impl Iterator<Item = String>) -> Vec<String> {
    let mut all: Vec<String> = texts.collect();
    let more = all.len().saturating_sub(MAX_LISTED);
    if more > 1 {
        all.truncate(MAX_LISTED);
        all.push(format!("… and {more} more; --format json lists all"));
    }
    all
}

/// A finding in one sentence: its worst stretch, and on how many more it comes back.
pub(in crate::report) fn finding(
    operation: &CheckedOperation<'_>,
    finding: &Finding<'_>,
) -> String {
    let text = sentence(operation, &finding.worst);
    match finding.others.len() {
        0 => text,
        1 => text + "; also on one more stretch",
        more => format!("{text}; also on {more} more stretches"),
    }
}

/// A stretch in one sentence, for those who see nothing else.
pub(in crate::report) fn sentence(
    operation: &CheckedOperation<'_>,
    stretch: &Stretch<'_>,
) -> String {
    let crossing = stretch.crossing;
    let risk = operation.risk;
    let moves = match moves(crossing) {
        empty if empty.is_empty() => String::new(),
        moves => format!("; it moves {moves}"),
    };
    let flanks = match stretch.flanks() {
        Some((from_s, to_s)) => {
            format!(
                " (uncertain {} %)",
                range(percent_from_ratio(from_s), percent_from_ratio(to_s))
            )
        }
        None => String::new(),
    };
    let terms = crossing.accepted.as_ref();
    let terms = terms
        .map_or_else(String::new, |terms| format!("; accepted {}", printable(&terms.to_string())));
    format!(
        "operation '{}': {} meets {}: {} apart, {}, at {}{flanks}, closest at {}{moves}; {} µm/N \
         at the tool tip at resonance{terms}",
        printable(&risk.name),
        mode(crossing.mode, crossing.natural_frequency_hz),
        line_at(&crossing.line, crossing.excitation_hz),
        apart(crossing.separation),
        place_in_band(operation, crossing),
        self::stretch(risk, crossing.from_s, crossing.to_s),
        point(risk, crossing.closest_s),
        um_per_n(crossing.tip_response_m_per_n),
    )
}
