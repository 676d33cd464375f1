//! Channels as they are in a file → what they measure, from their names and labels.

use std::path::Path;

use crate::formats::records::{Channel, Function, Label, Recording, read_record};
use crate::identify::record::Quantity;
use crate::notes::{Code, Note, Place};
use crate::units::{m_from_cm, m_from_mm, m_from_um, m_per_s2_from_g, n_from_kn};

/// What a channel's values mean, and how they become SI.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meaning {
    pub(super) quantity: Quantity,
    pub(super) to_si: fn(f64) -> f64,
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
pub(super) fn meaning_of_unit(unit: &str) -> Option<Meaning> {
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

/// The meaning of a label: by its unit if that is known, else the type of data in SI units.
pub(super) fn meaning_of(label: &Label) -> Option<Meaning> {
    meaning_of_unit(&label.unit).or_else(|| {
        let quantity = match label.data_type? {
            8 => Quantity::Displacement,
            11 => Quantity::Velocity,
            12 => Quantity::Acceleration,
            9 | 13 => Quantity::Force,
            _ => return None,
        };
        Some(Meaning { quantity, to_si: std::convert::identity })
    })
}

/// Reads a file of raw data, in which `time` may be what time is called. Columns of a table and
/// variables are called by their titles with and without unit; a column that only counts the rows
/// is passed over.
///
/// # Errors
/// Every fault of the file with its line.
pub(super) fn read_recording(path: &Path, time: Option<&str>) -> Result<Recording, Vec<Note>> {
    let mut file = read_record(path, time)?;
    if file.is_titled {
        let place = || match file.header_line {
            Some(line) => Place::line(path, line),
            None => Place::file(path),
        };
        file.channels.retain_mut(|Channel { label, samples }| {
            let titled = label.alias.clone();
            let (unit, bare) = unit_of_name(&titled);
            (label.unit, label.alias) = (unit.to_owned(), bare.to_owned());
            let counts = unit.is_empty()
                && !is_frequency(&label.name)
                && samples.windows(2).all(|pair| pair[1] - pair[0] == 1.0);
            if counts {
                let what = format!("column '{}' counts the rows; it is skipped", label.name);
                file.warnings.push(Note::warning(Code::Unused, place(), what));
            }
            !counts
        });
        for Function { label, .. } in &mut file.functions {
            let titled = label.name.clone();
            let (unit, bare) = unit_of_name(&titled);
            if label.unit.is_empty() && !unit.is_empty() {
                (label.unit, label.alias) = (unit.to_owned(), bare.to_owned());
            }
            label.unit = without_force(&label.unit).to_owned();
        }
        if file.channels.is_empty() && file.functions.is_empty() {
            let what = "has no channel: there is no column beside time and a count of rows";
            return Err(vec![Note::error(Code::MissingKey, Place::file(path), what)]);
        }
        // A name that two columns share means neither.
        let aliases: Vec<String> = file.channels.iter().map(|c| c.label.alias.clone()).collect();
        for Channel { label, .. } in &mut file.channels {
            if aliases.iter().filter(|alias| **alias == label.alias).count() > 1 {
                label.alias = label.name.clone();
            }
        }
    }
    Ok(file)
}

/// The unit of a response, of what is that unit per newton: `m/s2/N`, `m_per_s2_per_n`.
fn without_force(unit: &str) -> &str {
    let unit = unit.trim();
    let per = ["/n", "_per_n", " per n"].into_iter().find(|per| {
        let start = unit.len().checked_sub(per.len()).and_then(|at| unit.get(at..));
        start.is_some_and(|end| end.eq_ignore_ascii_case(per))
    });
    per.map_or(unit, |per| &unit[..unit.len() - per.len()])
}

/// Whether a column is called as the frequencies of a frequency response are.
pub(super) fn is_frequency(name: &str) -> bool {
    let name = name.trim().to_lowercase();
    ["frequency", "freq", "f_hz", "f [hz]", "f (hz)"].iter().any(|start| name.starts_with(start))
}

/// The unit in which a name ends, and the name without it: `x_mm`, `hammer_n`, `tip [mm/s]`,
/// `acc (g)`, `F/N`, `x, mm`.
fn unit_of_name(name: &str) -> (&str, &str) {
    let name = name.trim();
    let ends = "_ ,/";
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(rest) = name.strip_suffix(close)
            && let Some((before, unit)) = rest.rsplit_once(open)
            && meaning_of_unit(unit).is_some()
        {
            return (unit, before.trim_end_matches(|c| ends.contains(c)));
        }
    }
    // The longest ending that is a unit: that of `v_mm/s` is not `s`, nor that of `a_m_per_s2`
    // `s2`.
    for (at, mark) in name.char_indices().filter(|(at, c)| *at > 0 && ends.contains(*c)) {
        let unit = &name[at + mark.len_utf8()..];
        if meaning_of_unit(unit).is_some() {
            return (unit, name[..at].trim_end_matches(|c| ends.contains(c)));
        }
    }
    ("", name)
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
            let (unit, bare) = unit_of_name(name);
            let found = meaning_of_unit(unit).unwrap();
            assert_eq!((found.quantity, bare), (quantity, plain), "{name}");
            assert!(((found.to_si)(1.0) - one).abs() < 1e-12 * one, "{name}");
        }
        for name in ["hammer", "arm", "g", "x [furlong]", "", "_", "rpm/s", "x_1"] {
            assert_eq!(unit_of_name(name), ("", name), "{name}");
        }
        assert_eq!(meaning_of_unit("M/S^2").unwrap().quantity, Quantity::Acceleration);
    }

    #[test]
    fn columns_are_called_by_their_titles_with_and_without_unit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        let told = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read_recording(&path, None)
        };
        let mut text = String::from("# rig 3\n#frame, t [ms],acc (m/s^2),x_mm,x_g\r\n");
        let mut bare = String::from("frame,t [ms]\n");
        for k in 0..20 {
            text += &format!("{k},{},{},{},1\r\n", 5 * k, k % 3, k % 7);
            bare += &format!("{k},{}\n", 5 * k);
        }
        let found = told(&text).unwrap();
        let names: Vec<_> = found
            .channels
            .iter()
            .map(|c| (c.label.name.as_str(), c.label.alias.as_str()))
            .collect();
        // Of two columns called x each goes by its full name alone.
        assert_eq!(names, [("acc (m/s^2)", "acc"), ("x_mm", "x_mm"), ("x_g", "x_g")]);
        let notices: Vec<_> =
            found.warnings.iter().map(|n| (n.place.line, n.what.as_str())).collect();
        assert_eq!(notices[0], (Some(2), "the header is a comment; it is read as the header"));
        assert_eq!(notices[1].0, Some(2));
        assert!(notices[1].1.starts_with("column 'frame' counts the rows"), "{notices:?}");
        assert!(told(&bare).unwrap_err()[0].what.starts_with("has no channel"));
    }

    #[test]
    fn what_a_data_set_says_of_its_unit_is_understood() {
        let label = |unit: &str, data_type| Label {
            unit: unit.to_owned(),
            data_type: Some(data_type),
            ..Label::default()
        };
        for (unit, data_type, quantity, one) in [
            ("NONE", 8, Quantity::Displacement, 1.0),
            ("", 11, Quantity::Velocity, 1.0),
            ("g", 12, Quantity::Acceleration, 9.80665),
            ("mm", 12, Quantity::Displacement, 1e-3),
            ("", 13, Quantity::Force, 1.0),
        ] {
            let found = meaning_of(&label(unit, data_type)).unwrap();
            assert_eq!((found.quantity, (found.to_si)(1.0)), (quantity, one));
        }
        assert!(meaning_of(&label("", 0)).is_none());
    }
}
