//! What the renderers say in common: numbers as they are read, and short names.

use std::path::Path;

use serde::Serialize;
use serde_json::Value;

use crate::excitation::{ExcitationLine, Source};
use crate::job::{Carried, CarriedBy, Settings};
use crate::units::{percent_from_ratio, rpm_from_hz, um_per_n_from_m_per_n};
use crate::wording::printable;

/// Numbers from here on are written with a power of ten.
const LARGE: f64 = 1e7;

/// Numbers other than zero below this are written with a power of ten.
const SMALL: f64 = 1e-3;

/// Line and mode that are nearer than this share of the frequency meet: the rest is rounding.
const MEETING: f64 = 1e-8;

/// A number in a width that is bounded whatever its size: with so many decimals, or more (up to
/// three) where those would show a zero that it is not; with a power of ten beyond 1e7 and below
/// 1e-3.
pub(crate) fn number(value: f64, decimals: usize) -> String {
    // Without the sign of a negative zero.
    let value = value + 0.0;
    if value != 0.0 && !(SMALL..LARGE).contains(&value.abs()) {
        return format!("{value:.2e}");
    }
    let shows = |&decimals: &usize| {
        value == 0.0 || format!("{value:.decimals$}").contains(|c| ('1'..='9').contains(&c))
    };
    let decimals = (decimals..3).find(shows).unwrap_or(decimals.max(3));
    format!("{value:.decimals$}")
}

/// `detune.toml gives robot, policy.separation_percent`.
pub(super) fn settings(settings: &Settings) -> String {
    format!("{} gives {}", path(&settings.file), printable(&settings.keys.join(", ")))
}

/// `--policy sets separation_percent=8`; `None` where it sets nothing.
pub(super) fn overrides(given: &[String]) -> Option<String> {
    let given = printable(&given.join(", "));
    (!given.is_empty()).then(|| format!("--policy sets {given}"))
}

/// A path as it is printed.
pub(super) fn path(path: &Path) -> String {
    printable(&path.to_string_lossy())
}

/// A field of CSV, in quotes where it must be; CSV has no other way to spell what steers terminals
/// and build servers than [`printable`].
pub(super) fn csv_field(text: &str) -> String {
    let text = printable(text);
    if text.contains([',', '"']) || text.starts_with('#') {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text
    }
}

/// A word of a closed list, as JSON spells it.
pub(super) fn spelled(word: impl Serialize) -> String {
    match serde_json::to_value(word) {
        Ok(Value::String(text)) => text,
        other => format!("{other:?}"),
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

/// The distance of line and mode in percent of the mode's frequency: nothing that is there is
/// called zero.
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

/// Whether the model may be wrong by one share of every mode's frequency.
pub(super) fn is_uniform(uncertainty_by_mode: &[f64]) -> bool {
    uncertainty_by_mode.windows(2).all(|pair| pair[0] == pair[1])
}

/// What the model may be wrong by: `±10 %`, or `±1.52 % (mode 1) to ±9.2 % (mode 5)`.
pub(super) fn uncertainty(by_mode: &[f64]) -> String {
    let of = |(mode, share): (usize, &f64)| {
        let share = round_percent(*share);
        if is_uniform(by_mode) {
            format!("±{share} %")
        } else {
            format!("±{share} % (mode {})", mode + 1)
        }
    };
    let ascending = |a: &(usize, &f64), b: &(usize, &f64)| a.1.total_cmp(b.1);
    let least = by_mode.iter().enumerate().min_by(ascending).map(of);
    let most = by_mode.iter().enumerate().max_by(ascending).map(of);
    match (least, most) {
        (Some(least), Some(most)) if !is_uniform(by_mode) => format!("{least} to {most}"),
        (Some(least), _) => least,
        (None, _) => "not known".to_owned(),
    }
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

/// Three significant digits down to 0.001, with a power of ten below; `0` for zero.
pub(crate) fn significant(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = match value.abs() {
        size if size >= 99.95 => 0,
        size if size >= 9.995 => 1,
        size if size >= 0.9995 => 2,
        size if size >= 0.09995 => 3,
        size if size >= 0.009995 => 4,
        _ => 5,
    };
    number(value, decimals)
}

/// Compliance in µm/N with three significant digits, without the unit.
pub(super) fn um_per_n(compliance_m_per_n: f64) -> String {
    significant(um_per_n_from_m_per_n(compliance_m_per_n))
}

/// `mode 2 (38.4 Hz)`.
pub(super) fn mode(number: usize, frequency_hz: f64) -> String {
    format!("mode {number} ({} Hz)", hz(frequency_hz))
}

/// Lines of a file as they are read: `pocket.mod:41–58`.
pub(super) fn lines(file: &str, from: usize, to: usize) -> String {
    format!("{}:{}", printable(file), line_range(from, to))
}

/// `41–58`, or `41` alone.
pub(super) fn line_range(from: usize, to: usize) -> String {
    if from == to { from.to_string() } else { format!("{from}–{to}") }
}

/// What the tip carries; what nobody says, with what to write.
pub(super) fn carried(carried: Carried) -> String {
    let from = match carried.source {
        CarriedBy::Program => "from the tool data of the program",
        CarriedBy::Job => "from the job",
        CarriedBy::Robot => "from the robot file",
        CarriedBy::None => return "none, as the job says".to_owned(),
        CarriedBy::Unknown => {
            return "not known: write payload: {mass_kg: …, com_m: […]} or payload: none in the job"
                .to_owned();
        }
    };
    format!("{} kg, {from}", trimmed(carried.mass_kg, 3))
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
    fn small_numbers_keep_three_digits() {
        let found = [0.00045, 0.0123, 0.00876, 0.0999, 0.45, 12.34, 123.4].map(significant);
        assert_eq!(found, ["4.50e-4", "0.0123", "0.00876", "0.0999", "0.450", "12.3", "123"]);
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
