//! For people: a table of modes for each pose, then what must be known.

use std::fmt::Write;

use super::{kind_words, pose_words, shape_words};
use crate::identify::notice::Notice;
use crate::identify::session::{IdentifiedSession, PoseMode, PoseRow};
use crate::units::percent_from_ratio;
use crate::wording::printable;

/// The modes of a session.
pub fn identification_text(found: &IdentifiedSession) -> String {
    let mut out = String::new();
    for row in &found.rows {
        pose(&mut out, found, row);
    }
    let notices: Vec<&Notice> =
        found.records.iter().flat_map(|record| &record.notices).chain(&found.notices).collect();
    if !notices.is_empty() {
        out.push_str("Notices\n");
    }
    for notice in notices {
        let place: Vec<&str> =
            [&notice.record, &notice.channel].into_iter().flatten().map(String::as_str).collect();
        let place = if place.is_empty() {
            String::new()
        } else {
            format!("{}: ", printable(&place.join(", ")))
        };
        // Writing to a string does not fail.
        let _ = writeln!(out, "  {place}{} ({})", notice.what, notice.kind.code());
    }
    out
}

fn pose(out: &mut String, found: &IdentifiedSession, row: &PoseRow) {
    let mut records: Vec<usize> =
        row.modes.iter().flat_map(|mode| &mode.members).map(|(record, _)| *record).collect();
    records.sort_unstable();
    records.dedup();
    let mut facts = Vec::new();
    let kinds: Vec<&str> = records.iter().map(|&i| kind_words(found.records[i].kind)).collect();
    match kinds.as_slice() {
        [] => {}
        [one] => facts.push((*one).to_owned()),
        [first, ..] => facts.push(format!("{} records, {first}", kinds.len())),
    }
    facts.extend(row.sample_rate_hz.map(|rate| format!("{rate} samples/s")));
    let conditions = &row.conditions;
    facts.extend(conditions.temperature_c.map(|t| format!("{t} °C")));
    facts.extend(conditions.amplitude_nm.map(|a| format!("{a} N·m")));
    facts.extend(conditions.payload_kg.map(|m| format!("{m} kg")));
    let id = row.id.as_ref().map_or_else(String::new, |id| format!("{}: ", printable(id)));
    let _ = writeln!(out, "{id}{} ({})", pose_words(&row.pose), facts.join(", "));
    if row.modes.is_empty() {
        out.push_str("  no modes\n\n");
        return;
    }
    let _ = writeln!(out, "  mode  frequency ± std [Hz]  damping ± std [%]   shape");
    let mut number = 0;
    for mode in &row.modes {
        let name = match mode.suspicion {
            Some(kind) => kind.code().to_owned(),
            None => {
                number += 1;
                number.to_string()
            }
        };
        let _ = writeln!(
            out,
            "  {name:<5} {:<21} {:<19} {}",
            with_deviation(mode.frequency_hz, mode.frequency_std_hz),
            with_deviation(
                percent_from_ratio(mode.damping_ratio),
                percent_from_ratio(mode.damping_std)
            ),
            words(found, mode)
        );
    }
    out.push('\n');
}

/// The shape as the first record shows it, and how much bears it out.
fn words(found: &IdentifiedSession, mode: &PoseMode) -> String {
    let Some(&(record, index)) = mode.members.first() else { return String::new() };
    let of = &found.records[record].modes[index];
    let coherence = of.coherence.map_or_else(String::new, |c| format!("; coherence {c:.2}"));
    let support = percent_from_ratio(of.support);
    format!("{}{coherence}; in {support:.0} % of orders", printable(&shape_words(of)))
}

/// Value and deviation with two digits of the deviation.
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
