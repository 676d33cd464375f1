//! Units of channels, from their names and labels.

use crate::measured::record::Quantity;
use crate::units::{m_from_mm, m_from_um, m_per_s2_from_g, n_from_kn};

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

type Row = (&'static str, &'static str, Quantity, fn(f64) -> f64);

/// Label, ending of a name, quantity, conversion. Longer endings stand before those that they end in.
const UNITS: [Row; 12] = [
    ("mm/s2", "mm_per_s2", Quantity::Acceleration, m_from_mm),
    ("m/s2", "m_per_s2", Quantity::Acceleration, std::convert::identity),
    ("um/s", "um_per_s", Quantity::Velocity, m_from_um),
    ("mm/s", "mm_per_s", Quantity::Velocity, m_from_mm),
    ("m/s", "m_per_s", Quantity::Velocity, std::convert::identity),
    ("um", "um", Quantity::Displacement, m_from_um),
    ("mm", "mm", Quantity::Displacement, m_from_mm),
    ("m", "m", Quantity::Displacement, std::convert::identity),
    ("g", "g", Quantity::Acceleration, m_per_s2_from_g),
    ("kn", "kn", Quantity::Force, n_from_kn),
    ("n", "n", Quantity::Force, std::convert::identity),
    ("ms2", "ms2", Quantity::Acceleration, std::convert::identity),
];

/// The meaning of a unit as people write it: `mm`, `m/s^2`, `m/s²`, `µm`, `g`, `N`.
pub(in crate::input) fn meaning_of_unit(unit: &str) -> Option<Meaning> {
    let plain: String = unit
        .trim()
        .to_lowercase()
        .chars()
        .filter(|c| !matches!(c, '^' | ' ' | '*' | '(' | ')' | '[' | ']'))
        .map(|c| match c {
            '²' => '2',
            'µ' | 'μ' => 'u',
            c => c,
        })
        .collect();
    let found = UNITS.iter().find(|(label, ..)| *label == plain)?;
    Some(Meaning { quantity: found.2, to_si: found.3 })
}

/// The meaning of a name that ends in a unit: `x_mm`, `hammer_n`, `tip [mm/s]`, `acc (g)`.
pub(in crate::input) fn meaning_of_name(name: &str) -> Option<Meaning> {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(rest) = name.strip_suffix(close)
            && let Some((_, unit)) = rest.rsplit_once(open)
        {
            return meaning_of_unit(unit);
        }
    }
    let lower = name.to_lowercase();
    let ends = |ending: &str| lower.strip_suffix(ending).is_some_and(|rest| rest.ends_with('_'));
    let found = UNITS.iter().find(|(_, ending, ..)| ends(ending))?;
    Some(Meaning { quantity: found.2, to_si: found.3 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_names_and_labels() {
        for (name, quantity, one) in [
            ("x_mm", Quantity::Displacement, 1e-3),
            ("tip [µm]", Quantity::Displacement, 1e-6),
            ("a_m_per_s2", Quantity::Acceleration, 1.0),
            ("v_mm_per_s", Quantity::Velocity, 1e-3),
            ("acc (g)", Quantity::Acceleration, 9.80665),
            ("hammer_N", Quantity::Force, 1.0),
            ("F [kN]", Quantity::Force, 1e3),
            ("a (m/s^2)", Quantity::Acceleration, 1.0),
        ] {
            let found = meaning_of_name(name).unwrap();
            assert_eq!(found.quantity, quantity, "{name}");
            assert!(((found.to_si)(1.0) - one).abs() < 1e-12 * one, "{name}");
        }
        for name in ["hammer", "arm", "g", "x [furlong]", ""] {
            assert_eq!(meaning_of_name(name), None, "{name}");
        }
        assert_eq!(meaning_of_unit("m/s²"), meaning_of_unit("M/S^2"));
    }
}
