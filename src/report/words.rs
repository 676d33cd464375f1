//! What the renderers say in common: numbers as they are read, and a finding in one sentence.

use std::path::Path;

use super::findings::Stretch;
use super::{CheckedJob, CheckedOperation, style};
use crate::excitation::{ExcitationLine, Source};
use crate::risk::{Certainty, Crossing, OperationRisk, Sample, Verdict};
use crate::units::{deg_from_rad, percent_from_ratio, rpm_from_hz, um_per_n_from_m_per_n};
use crate::wording::printable;

/// A coordinate that carries less of a mode than this is not named, unless it carries the most.
const LEAST_SHARE_NAMED: f64 = 0.1;

/// At most so many coordinates are named.
const MOST_SHARES_NAMED: usize = 3;

/// Numbers from here on are written with a power of ten.
const LARGE: f64 = 1e7;

/// Numbers other than zero below this are written with a power of ten.
const SMALL: f64 = 1e-3;

/// Line and mode that are nearer than this share of the frequency meet: the rest is rounding.
const MEETING: f64 = 1e-8;

/// A number in a width that is bounded whatever its size: with so many decimals, or more (up to three) where
/// those would show a zero that it is not; with a power of ten beyond 1e7 and below 1e-3.
pub(crate) fn number(value: f64, decimals: usize) -> String {
    if value != 0.0 && !(SMALL..LARGE).contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let shows = |&decimals: &usize| {
        value == 0.0 || format!("{value:.decimals$}").contains(|c| ('1'..='9').contains(&c))
    };
    let decimals = (decimals..3).find(shows).unwrap_or(decimals.max(3));
    format!("{value:.decimals$}")
}

/// A path as it is printed.
pub(super) fn path(path: &Path) -> String {
    printable(&path.to_string_lossy())
}

/// The verdict as JSON and messages spell it.
pub(super) fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Clear => "clear",
        Verdict::Uncertain => "uncertain",
        Verdict::Resonance => "resonance",
    }
}

/// The certainty as JSON spells it.
pub(super) fn certainty(certainty: Certainty) -> &'static str {
    match certainty {
        Certainty::Certain => "certain",
        Certainty::Uncertain => "uncertain",
    }
}

/// The source as JSON spells it.
pub(super) fn source_key(source: Source) -> &'static str {
    match source {
        Source::ToothPassing => "tooth_passing",
        Source::Spindle => "spindle",
    }
}

/// `tooth passing × 2`.
pub(super) fn line(line: &ExcitationLine) -> String {
    let source = match line.source {
        Source::ToothPassing => "tooth passing",
        Source::Spindle => "spindle",
    };
    format!("{source} × {}", line.harmonic)
}

/// `tooth passing × 2 of 1100 rpm (73.3 Hz)`.
pub(super) fn line_at(of: &ExcitationLine, excitation_hz: f64) -> String {
    let rpm = rpm_from_hz(excitation_hz) / f64::from(of.order.max(1));
    format!("{} of {} rpm ({} Hz)", line(of), trimmed(rpm, 1), hz(excitation_hz))
}

/// A frequency in Hz: one decimal, none from 1000 Hz.
pub(super) fn hz(frequency_hz: f64) -> String {
    number(frequency_hz, usize::from(frequency_hz.abs() < 999.95))
}

/// A place on the path in percent with one decimal, without the sign.
pub(super) fn percent(ratio: f64) -> String {
    format!("{:.1}", percent_from_ratio(ratio))
}

/// The distance of line and mode in percent of the mode's frequency: nothing that is there is called zero.
pub(super) fn apart(separation: f64) -> String {
    if separation < MEETING {
        format!("less than {:e} %", percent_from_ratio(MEETING))
    } else {
        format!("{} %", number(percent_from_ratio(separation), 1))
    }
}

/// The same as short as a column wants it.
pub(super) fn apart_in_column(separation: f64) -> String {
    apart(separation).replace("less than ", "<")
}

/// A ratio in percent with as many decimals as it needs, up to two, without the sign.
pub(super) fn round_percent(ratio: f64) -> String {
    trimmed(percent_from_ratio(ratio), 2)
}

/// As [`number`], without zeros at the end.
pub(crate) fn trimmed(value: f64, decimals: usize) -> String {
    let text = number(value, decimals);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Two ends with a dash between, with just so many decimals (one to three) that they differ.
pub(super) fn range(from: f64, to: f64) -> String {
    let size = from.abs().max(to.abs());
    if size != 0.0 && !(SMALL..LARGE).contains(&size) {
        return format!("{}–{}", number(from, 1), number(to, 1));
    }
    let decimals = (1..3)
        .find(|&decimals| format!("{from:.decimals$}") != format!("{to:.decimals$}"))
        .unwrap_or(if from == to { 1 } else { 3 });
    format!("{from:.decimals$}–{to:.decimals$}")
}

/// Compliance in µm/N with three significant digits, without the unit.
pub(super) fn um_per_n(compliance_m_per_n: f64) -> String {
    let value = um_per_n_from_m_per_n(compliance_m_per_n);
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = match value.abs() {
        size if size >= 99.95 => 0,
        size if size >= 9.995 => 1,
        size if size >= 0.9995 => 2,
        _ => 3,
    };
    number(value, decimals)
}

/// `mode 2 (38.4 Hz)`.
pub(super) fn mode(number: usize, frequency_hz: f64) -> String {
    format!("mode {number} ({} Hz)", hz(frequency_hz))
}

/// `joint_3 71 %, joint_2 24 %, turning against each other`; empty where shares are not known.
pub(super) fn moves(operation: &CheckedOperation<'_>, crossing: &Crossing) -> String {
    let moves = operation.moves(crossing);
    let named = moves.iter().take_while(|m| m.1 >= LEAST_SHARE_NAMED).count();
    let named = named.clamp(1, MOST_SHARES_NAMED).min(moves.len());
    let mut text = moves[..named]
        .iter()
        .map(|(name, share)| format!("{} {:.0} %", printable(name), percent_from_ratio(*share)))
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

/// `spindle × 1 (ignored 49–51 Hz), modes 5, 6 (below 0.5 µm/N)`; `None` where everything counts.
pub(super) fn left_out(operation: &CheckedOperation<'_>) -> Option<String> {
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
        let least = trimmed(um_per_n_from_m_per_n(policy.min_tip_response_m_per_n), 6);
        parts.push(format!("mode{s} {} (below {least} µm/N)", modes.join(", ")));
    }
    Some(parts.join("; "))
}

/// β2 at the sample next to `s`, `β2 68.2°`, if the robot defines it.
pub(super) fn beta2(operation: &OperationRisk, s: f64) -> Option<String> {
    let beta2 = sample_next_to(operation, s)?.beta2_rad?;
    Some(format!("β2 {}°", number(deg_from_rad(beta2), 1)))
}

fn sample_next_to(operation: &OperationRisk, s: f64) -> Option<&Sample> {
    operation.samples.iter().min_by(|a, b| (a.s - s).abs().total_cmp(&(b.s - s).abs()))
}

/// `12.0–31.0 % of the path (1.5–3.8 s)`.
pub(super) fn stretch(operation: &OperationRisk, from_s: f64, to_s: f64) -> String {
    format!(
        "{} % of the path ({} s)",
        range(percent_from_ratio(from_s), percent_from_ratio(to_s)),
        range(from_s * operation.duration_s, to_s * operation.duration_s)
    )
}

/// `20.0 % (2.46 s, β2 68.2°)`.
pub(super) fn point(operation: &OperationRisk, s: f64) -> String {
    let beta2 = beta2(operation, s).map_or(String::new(), |beta2| format!(", {beta2}"));
    format!("{} % ({} s{beta2})", percent(s), trimmed(s * operation.duration_s, 2))
}

/// `1.3 % apart, inside the band of ±10 %`.
pub(super) fn nearness(operation: &CheckedOperation<'_>, crossing: &Crossing) -> String {
    let apart = apart(crossing.separation);
    let band = round_percent(operation.job.risk.separation);
    match crossing.certainty {
        Certainty::Certain => format!("{apart} apart, inside the band of ±{band} %"),
        Certainty::Uncertain => format!(
            "{apart} apart, outside the band of ±{band} % by less than the model's uncertainty of ±{} %",
            round_percent(operation.job.risk.model_uncertainty)
        ),
    }
}

/// Lines of a file as they are read: `pocket.mod:41–58`.
pub(super) fn lines(file: &str, from: usize, to: usize) -> String {
    format!("{}:{}", printable(file), line_range(from, to))
}

/// `41–58`, or `41` alone.
pub(super) fn line_range(from: usize, to: usize) -> String {
    if from == to { from.to_string() } else { format!("{from}–{to}") }
}

/// `2 resonance, 1 uncertain, 9 clear`: how many there are of each verdict, the worst first.
pub(super) fn counts(verdicts: impl Iterator<Item = Verdict>, colour: bool) -> String {
    let verdicts: Vec<Verdict> = verdicts.collect();
    let counts: Vec<String> = [Verdict::Resonance, Verdict::Uncertain, Verdict::Clear]
        .into_iter()
        .filter_map(|of| {
            let count = verdicts.iter().filter(|verdict| **verdict == of).count();
            let told = format!("{count} {}", verdict(of));
            (count > 0).then(|| style::paint(style::of(of), told, colour))
        })
        .collect();
    counts.join(", ")
}

/// The jobs that are not clear, the worst first, else in their order.
pub(super) fn worst_jobs(jobs: &[CheckedJob]) -> Vec<&CheckedJob> {
    let mut worst: Vec<_> = jobs.iter().filter(|job| job.risk.verdict > Verdict::Clear).collect();
    worst.sort_by_key(|job| std::cmp::Reverse(job.risk.verdict));
    worst
}

/// A stretch in one sentence, for those who see nothing else.
pub(super) fn sentence(operation: &CheckedOperation<'_>, stretch: &Stretch<'_>) -> String {
    let crossing = stretch.crossing;
    let risk = operation.risk;
    let moves = match moves(operation, crossing) {
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
    format!(
        "operation '{}': {} meets {}: {}, at {}{flanks}, closest at {}{moves}; {} µm/N at the tool tip at \
         resonance",
        printable(&risk.name),
        mode(crossing.mode, crossing.natural_frequency_hz),
        line_at(&crossing.line, crossing.excitation_hz),
        nearness(operation, crossing),
        self::stretch(risk, crossing.from_s, crossing.to_s),
        point(risk, crossing.closest_s),
        um_per_n(crossing.tip_response_m_per_n),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(hz(73.333), "73.3");
        assert_eq!(hz(999.94), "999.9");
        assert_eq!(hz(999.96), "1000");
        assert_eq!(trimmed(1100.0, 1), "1100");
        assert_eq!(trimmed(1234.56, 1), "1234.6");
        assert_eq!(trimmed(100.0, 0), "100");
        assert_eq!(round_percent(0.088), "8.8");
        assert_eq!(um_per_n(0.8e-6), "0.800");
        assert_eq!(um_per_n(12.345e-6), "12.3");
        assert_eq!(um_per_n(1234.5e-6), "1234");
        assert_eq!(um_per_n(1e-12), "1.00e-6");
        assert_eq!(um_per_n(0.0), "0");
        assert_eq!(hz(0.0), "0.0");
        assert_eq!(apart_in_column(0.0), "<1e-6 %");
        assert_eq!(apart(0.0127), "1.3 %");
        assert_eq!(apart(3e-4), "0.03 %");
        assert_eq!(
            [apart(3e-7), apart(1e-11), apart(0.0)].join(" "),
            "3.00e-5 % less than 1e-6 % less than 1e-6 %"
        );
    }

    #[test]
    fn numbers_of_any_size_are_short() {
        // Up to what still is a number in µm/N.
        for exponent in -320..=300 {
            for digits in ["1", "-9.9999", "4.7183"] {
                let value: f64 = format!("{digits}e{exponent}").parse().unwrap();
                let all =
                    [hz(value), trimmed(value, 1), um_per_n(value), number(value, 1), apart(value)];
                for text in all.iter().chain([&range(value, 2.0 * value)]) {
                    assert!(text.chars().count() <= 21, "{value:e}: {text}");
                    let shows = text.contains(|c| ('1'..='9').contains(&c));
                    assert!(shows || value == 0.0, "{value:e}: {text}");
                }
            }
        }
        assert_eq!(trimmed(4.0e300, 1), "4.00e300");
        assert_eq!([trimmed(0.04, 1), trimmed(0.0, 1)], ["0.04", "0"]);
        assert_eq!(range(0.0, 31.0), "0.0–31.0");
    }

    #[test]
    fn a_range_shows_that_its_ends_differ() {
        assert_eq!(range(12.0, 31.0), "12.0–31.0");
        assert_eq!(range(12.01, 12.04), "12.01–12.04");
        assert_eq!(range(12.001, 12.0015), "12.001–12.002");
        assert_eq!(range(12.0, 12.0), "12.0–12.0");
    }
}
