//! Units of channels, from their names and labels.

use crate::identify::record::Quantity;
use crate::units::{m_from_cm, m_from_mm, m_from_um, m_per_s2_from_g, n_from_kn};

/// What a channel's values mean, and how they become SI.
#[derive(Debug, Clone, Copy)]
pub(in crate::input) struct Meaning {
    pub(in crate::input) quantity: Quantity,
    pub(in crate::input) to_si: fn(f64) -> f64,
}

impl PartialEq for Meaning {
    fn eq(&self, other: &Self) -> bool {
        self.quantity == other.quantity && (self.to_si)(1.0) == (other.to_si)(1.0)
    }
}

type Row = (&'static str, Quantity, fn(f64) -> f64);

/// Unit as it is written plainly, quantity, conversion.
const UNITS: [Row; 13] = [
    ("mm/s2", Quantity::Acceleration, m_from_mm),
    ("m/s2", Quantity::Acceleration, std::convert::identity),
    ("g", Quantity::Acceleration, m_per_s2_from_g),
    ("um/s", Quantity::Velocity, m_from_um),
    ("mm/s", Quantity::Velocity, m_from_mm),
    ("m/s", Quantity::Velocity, std::convert::identity),
    ("um", Quantity::Displacement, m_from_um),
    ("mm", Quantity::Displacement, m_from_mm),
    ("cm", Quantity::Displacement, m_from_cm),
    ("m", Quantity::Displacement, std::convert::identity),
    ("kn", Quantity::Force, n_from_kn),
    ("n", Quantity::Force, std::convert::identity),
    ("newton", Quantity::Force, std::convert::identity),
];

/// How else people write the units of speed and acceleration, after a length.
const PER_SECOND: [&str; 5] = ["_per_s", "ps", "_s", "s-1", "/sec"];
const PER_SECOND_SQUARED: [&str; 10] =
    ["_per_s2", "_per_s_per_s", "ps2", "_s2", "s-2", "s2", "/s/s", "/sec2", "/ss", "ps/s"];

const LENGTHS: [&str; 3] = ["mm", "um", "m"];

/// The meaning of a unit as people write it: `mm`, `m/s^2`, `m/s²`, `m s^-2`, `m_per_s2`, `µm`,
/// `g`, `N`.
pub(in crate::input) fn meaning_of_unit(unit: &str) -> Option<Meaning> {
    let plain: String = unit
        .trim()
        .to_lowercase()
        .chars()
        .filter(|c| !matches!(c, '^' | ' ' | '*' | '(' | ')' | '[' | ']' | '.' | '·'))
        .map(|c| match c {
            '²' => '2',
            '⁻' | '−' => '-',
            'µ' | 'μ' => 'u',
            c => c,
        })
        .collect();
    let found = |plain: &str| UNITS.iter().find(|(label, ..)| *label == plain);
    let respelt = || {
        let length = LENGTHS.iter().find(|length| plain.starts_with(*length))?;
        let rest = &plain[length.len()..];
        let per = if PER_SECOND.contains(&rest) {
            "/s"
        } else if PER_SECOND_SQUARED.contains(&rest) {
            "/s2"
        } else {
            return None;
        };
        found(&format!("{length}{per}"))
    };
    let (_, quantity, to_si) = found(&plain).or_else(respelt)?;
    Some(Meaning { quantity: *quantity, to_si: *to_si })
}

/// The meaning of a name that ends in a unit: `x_mm`, `hammer_n`, `tip [mm/s]`, `acc (g)`, `F/N`,
/// `x, mm`; and the name without it.
pub(in crate::input) fn meaning_of_name(name: &str) -> (Option<Meaning>, &str) {
    let name = name.trim();
    let ends = "_ ,/";
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(rest) = name.strip_suffix(close)
            && let Some((before, unit)) = rest.rsplit_once(open)
            && let Some(meaning) = meaning_of_unit(unit)
        {
            return (Some(meaning), before.trim_end_matches(|c| ends.contains(c)));
        }
    }
    // The longest ending that is a unit: that of `v_mm/s` is not `s`, nor that of `a_m_per_s2`
    // `s2`.
    for (at, mark) in name.char_indices().filter(|(at, c)| *at > 0 && ends.contains(*c)) {
        if let Some(meaning) = meaning_of_unit(&name[at + mark.len_utf8()..]) {
            return (Some(meaning), name[..at].trim_end_matches(|c| ends.contains(c)));
        }
    }
    (None, name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_names_and_labels() {
        for (name, quantity, one, plain) in [
            ("x_mm", Quantity::Displacement, 1e-3, "x"),
            ("tip [µm]", Quantity::Displacement, 1e-6, "tip"),
            ("tip x [mm]", Quantity::Displacement, 1e-3, "tip x"),
            ("x, cm", Quantity::Displacement, 1e-2, "x"),
            ("x/mm", Quantity::Displacement, 1e-3, "x"),
            ("a_m_per_s2", Quantity::Acceleration, 1.0, "a"),
            ("a_x_ms2", Quantity::Acceleration, 1.0, "a_x"),
            ("acc_m/s^2", Quantity::Acceleration, 1.0, "acc"),
            ("acc [m s^-2]", Quantity::Acceleration, 1.0, "acc"),
            ("acc (mm/s/s)", Quantity::Acceleration, 1e-3, "acc"),
            ("v_mm_per_s", Quantity::Velocity, 1e-3, "v"),
            ("v_mm/s", Quantity::Velocity, 1e-3, "v"),
            ("acc (g)", Quantity::Acceleration, 9.80665, "acc"),
            ("hammer_N", Quantity::Force, 1.0, "hammer"),
            ("F [kN]", Quantity::Force, 1e3, "F"),
            ("F/N", Quantity::Force, 1.0, "F"),
            ("a (m/s^2)", Quantity::Acceleration, 1.0, "a"),
        ] {
            let (found, bare) = meaning_of_name(name);
            let found = found.unwrap();
            assert_eq!((found.quantity, bare), (quantity, plain), "{name}");
            assert!(((found.to_si)(1.0) - one).abs() < 1e-12 * one, "{name}");
        }
        for name in ["hammer", "arm", "g", "x [furlong]", "", "_", "rpm/s", "x_1"] {
            assert_eq!(meaning_of_name(name), (None, name), "{name}");
        }
        assert_eq!(meaning_of_unit("m/s²"), meaning_of_unit("M/S^2"));
    }
}
