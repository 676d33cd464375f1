//! As text: a table of modes for each pose, then warnings.

use super::{kind_words, mode_name, pose_words, record_and_channel, shape_words};
use crate::identify::session::{IdentifiedSession, PoseMode, PoseModes};
use crate::report::words::trimmed;
use crate::units::percent_from_ratio;
use crate::wording::{printable, wrapped};

/// The modes of a session.
pub fn identification_text(found: &IdentifiedSession) -> String {
    let mut out = String::new();
    for at in &found.poses {
        pose(&mut out, found, at);
    }
    let mut warnings =
        found.records.iter().flat_map(|record| &record.warnings).chain(&found.warnings).peekable();
    if warnings.peek().is_some() {
        out.push_str("Warnings\n");
    }
    for note in warnings {
        let (record, channel) = record_and_channel(note);
        let place: Vec<&str> = [record, channel].into_iter().flatten().collect();
        let place = match place.is_empty() {
            true => String::new(),
            false => format!("{}: ", printable(&place.join(", "))),
        };
        wrapped(&mut out, "  - ", &format!("{place}{} ({})", note.what, note.code));
    }
    out
}

fn pose(out: &mut String, found: &IdentifiedSession, at: &PoseModes) {
    let id = at.id.as_ref().map_or_else(String::new, |id| format!("{}: ", printable(id)));
    let pose = pose_words(&at.pose, found.joint_columns.as_deref());
    wrapped(out, "", &format!("{id}{pose} ({})", facts(found, at)));
    if at.modes.is_empty() {
        out.push_str("  no modes\n\n");
        return;
    }
    out.push_str("  mode       frequency ± std [Hz]  damping ± std [%]  shape\n");
    for mode in &at.modes {
        let name = mode_name(mode);
        let head = format!(
            "  {name:<10} {:<21} {:<18} ",
            with_deviation(mode.frequency_hz, mode.frequency_std_hz),
            with_deviation(
                percent_from_ratio(mode.damping_ratio),
                percent_from_ratio(mode.damping_std)
            )
        );
        wrapped(out, &head, &words(found, mode));
    }
    out.push('\n');
}

/// How the records of a pose were taken, and under which conditions.
fn facts(found: &IdentifiedSession, at: &PoseModes) -> String {
    let mut records: Vec<usize> =
        at.modes.iter().flat_map(|mode| &mode.members).map(|(record, _)| *record).collect();
    records.sort_unstable();
    records.dedup();
    let mut facts = Vec::new();
    let kinds: Vec<&str> = records.iter().map(|&i| kind_words(found.records[i].kind)).collect();
    match kinds.as_slice() {
        [] => {}
        [one] => facts.push((*one).to_owned()),
        [first, ..] => facts.push(format!("{} records, {first}", kinds.len())),
    }
    facts.extend(at.sample_rate_hz.map(|rate| format!("{} samples/s", trimmed(rate, 3))));
    let conditions = &at.conditions;
    facts.extend(conditions.temperature_c.map(|t| format!("{t} °C")));
    facts.extend(conditions.amplitude_nm.map(|a| format!("{a} N·m")));
    facts.extend(conditions.payload_kg.map(|m| format!("{m} kg")));
    facts.extend(conditions.added_kg.iter().map(|(link, m)| format!("{m} kg added to {link}")));
    facts.join(", ")
}

/// The shape as the first record shows it, with coherence and support.
fn words(found: &IdentifiedSession, mode: &PoseMode) -> String {
    let Some(&(record, index)) = mode.members.first() else { return String::new() };
    let of = &found.records[record].modes[index];
    let coherence = of.coherence.map_or_else(String::new, |c| format!("; coherence {c:.2}"));
    let support = percent_from_ratio(of.support);
    format!("{}{coherence}; in {support:.0} % of orders", printable(&shape_words(of)))
}

/// Value and standard deviation, with two digits of the latter.
fn with_deviation(value: f64, std: f64) -> String {
    let digits = if std > 0.0 && std.is_finite() { 1.0 - std.log10().floor() } else { 6.0 };
    let digits = digits.clamp(0.0, 9.0) as usize;
    format!("{value:.digits$} ± {std:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_have_two_digits() {
        assert_eq!(with_deviation(23.004_56, 0.004_321), "23.0046 ± 0.0043");
        assert_eq!(with_deviation(2.0, 0.31), "2.00 ± 0.31");
        assert_eq!(with_deviation(200.0, 12.0), "200 ± 12");
        assert_eq!(with_deviation(2.0, 0.0), "2.000000 ± 0.000000");
    }
}
