//! Frequency responses in the columns of a table: a frequency, and of every response the real and
//! the imaginary part (`tip_re`, `tip_im`; `Re(tip)`, `Im(tip)`), or magnitude and phase (`tip_mag`
//! or, in decibels, `tip_db`, and `tip_phase_deg` or `tip_phase_rad`).

use nalgebra::Complex;

use super::{Function, Label};
use crate::notes::{Code, Notes};
use crate::units::{hz_from_khz, hz_from_rad_per_s, rad_from_deg};

/// The columns of a table, and the line of its header where it has one.
pub(super) struct Columns<'t> {
    pub(super) titles: &'t [String],
    pub(super) values: &'t [Vec<f64>],
    pub(super) header_line: Option<usize>,
}

/// What a column is of a response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Real,
    Imaginary,
    Magnitude,
    Decibels,
    Phase,
    Degrees,
    Radians,
    Coherence,
}

/// A column that is part of a response.
struct Column {
    at: usize,
    /// Of the response; empty where the title has no other word.
    name: String,
    /// As it is written behind the part; empty where it is not.
    unit: String,
    part: Part,
}

/// Words of titles. A unit of phase says more than the word before it.
const PARTS: [(&str, Part); 19] = [
    ("re", Part::Real),
    ("real", Part::Real),
    ("im", Part::Imaginary),
    ("imag", Part::Imaginary),
    ("imaginary", Part::Imaginary),
    ("mag", Part::Magnitude),
    ("magnitude", Part::Magnitude),
    ("abs", Part::Magnitude),
    ("amplitude", Part::Magnitude),
    ("modulus", Part::Magnitude),
    ("db", Part::Decibels),
    ("phase", Part::Phase),
    ("angle", Part::Phase),
    ("arg", Part::Phase),
    ("deg", Part::Degrees),
    ("°", Part::Degrees),
    ("rad", Part::Radians),
    ("coh", Part::Coherence),
    ("coherence", Part::Coherence),
];

/// What a response is called whose columns have no other word.
const UNNAMED: &str = "response";

/// Steps from line to line above this, or a range below it, tell degrees from radians.
const TURN_RAD: f64 = 6.4;

/// The frequency responses of a table; `None` where it has no column of frequencies, or none that
/// says it is part of one.
pub(super) fn functions(table: &Columns<'_>, notes: &mut Notes) -> Option<Vec<Function>> {
    let (frequency, to_hz) =
        (0..table.titles.len()).find_map(|at| Some((at, frequency(&table.titles[at])?)))?;
    let of_titles = table.titles.iter().enumerate().filter(|(at, _)| *at != frequency);
    let columns: Vec<Column> = of_titles
        .filter_map(|(at, title)| column(at, title))
        .filter(|column| column.part != Part::Coherence)
        .collect();
    if columns.is_empty() {
        return None;
    }
    let line = table.header_line;
    for (at, title) in table.titles.iter().enumerate() {
        if at != frequency && columns.iter().all(|column| column.at != at) {
            let what =
                format!("column '{title}' is no part of a frequency response; it is skipped");
            notes.warning(Code::Unused, line, what);
        }
    }
    let frequencies_hz: Vec<f64> = table.values[frequency].iter().map(|f| to_hz(*f)).collect();
    let rises = frequencies_hz.windows(2).all(|pair| pair[0] < pair[1]);
    if !rises || frequencies_hz.first().is_some_and(|f| *f < 0.0) {
        let what = format!("column '{}' does not rise from zero on", table.titles[frequency]);
        notes.error(Code::Value, line, what);
        return Some(Vec::new());
    }
    let mut functions: Vec<Function> = Vec::new();
    for Column { name, .. } in &columns {
        let name = if name.is_empty() { UNNAMED } else { name };
        if functions.iter().any(|function| function.label.name == name) {
            continue;
        }
        let is_own =
            |column: &&Column| column.name == name || column.name.is_empty() && name == UNNAMED;
        let own: Vec<&Column> = columns.iter().filter(is_own).collect();
        let values = values(table, &own).unwrap_or_else(|what| {
            notes.error(Code::Value, line, format!("response '{name}': {what}"));
            Vec::new()
        });
        let unit = own.iter().map(|column| &column.unit).find(|unit| !unit.is_empty());
        functions.push(Function {
            label: Label {
                name: name.to_owned(),
                alias: name.to_owned(),
                unit: unit.cloned().unwrap_or_default(),
                data_type: None,
            },
            reference: String::new(),
            frequencies_hz: frequencies_hz.clone(),
            values,
            line: line.unwrap_or_default(),
        });
    }
    Some(functions)
}

/// The values of one response by its columns. Where it has both, real and imaginary part count.
fn values(table: &Columns<'_>, own: &[&Column]) -> Result<Vec<Complex<f64>>, String> {
    let column = |at: usize| table.values[at].iter().copied();
    let title = |at: usize| &table.titles[at];
    let of = |wanted: &[Part]| -> Result<Option<(usize, Part)>, String> {
        let mut all = own.iter().filter(|column| wanted.contains(&column.part));
        match (all.next(), all.next()) {
            (Some(first), Some(second)) => Err(format!(
                "columns '{}' and '{}' are the same",
                title(first.at),
                title(second.at)
            )),
            (first, _) => Ok(first.map(|column| (column.at, column.part))),
        }
    };
    let real = of(&[Part::Real])?;
    let imaginary = of(&[Part::Imaginary])?;
    let size = of(&[Part::Magnitude, Part::Decibels])?;
    let phase = of(&[Part::Phase, Part::Degrees, Part::Radians])?;
    match (real, imaginary, size, phase) {
        (Some((re, _)), Some((im, _)), ..) => {
            Ok(column(re).zip(column(im)).map(|(re, im)| Complex::new(re, im)).collect())
        }
        (None, None, Some((size, kind)), Some((at, unit))) => {
            let to_rad = radians(&table.values[at], unit)
                .map_err(|why| format!("column '{}' {why}", title(at)))?;
            if kind == Part::Magnitude && column(size).any(|v| v < 0.0) {
                let why = "has negative values: decibels must be called so (mag_db)";
                return Err(format!("column '{}' {why}", title(size)));
            }
            let plain = |v: f64| if kind == Part::Decibels { 10f64.powf(v / 20.0) } else { v };
            let both = column(size).zip(column(at));
            Ok(both.map(|(v, angle)| Complex::from_polar(plain(v), angle * to_rad)).collect())
        }
        (Some((at, _)), ..) => {
            Err(format!("column '{}' has no imaginary part beside it (_im)", title(at)))
        }
        (_, Some((at, _)), ..) => {
            Err(format!("column '{}' has no real part beside it (_re)", title(at)))
        }
        (_, _, Some((at, _)), None) => {
            Err(format!("column '{}' has no phase beside it (_phase_deg)", title(at)))
        }
        _ => Err("has no magnitude beside its phase (_mag or _db)".to_owned()),
    }
}

/// Radians in one of a column of phases; a unit that the values cannot have is a fault.
fn radians(values: &[f64], unit: Part) -> Result<f64, String> {
    let step = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    let most = values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    match unit {
        Part::Degrees if most > 0.0 && most < TURN_RAD => {
            Err(format!("is in degrees and reaches {most:.3} at most: is it in radians?"))
        }
        Part::Degrees => Ok(rad_from_deg(1.0)),
        Part::Radians if step > TURN_RAD => {
            Err(format!("is in radians and jumps by {step:.1}: is it in degrees?"))
        }
        Part::Radians => Ok(1.0),
        _ => Err("must say its unit: _phase_deg or _phase_rad".to_owned()),
    }
}

/// How a column of frequencies becomes Hz: `frequency`, `freq_hz`, `f [Hz]`, `Hz`, `f_khz`,
/// `omega_rad_per_s`.
pub(crate) fn frequency(title: &str) -> Option<fn(f64) -> f64> {
    const NAMES: [&str; 4] = ["frequency", "freq", "f", "omega"];
    let words: Vec<String> = words(title).map(|(_, word)| word.to_lowercase()).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let (name, unit) = match words.as_slice() {
        ["hz"] => ("f", words.as_slice()),
        [name, unit @ ..] if NAMES.contains(name) => (*name, unit),
        _ => return None,
    };
    match (name, unit) {
        ("omega", ["rad", "s"] | ["rad", "per", "s"]) => Some(hz_from_rad_per_s),
        ("omega", _) => None,
        (_, [] | ["hz"]) => Some(std::convert::identity),
        (_, ["khz"]) => Some(hz_from_khz),
        (_, ["rad", "s"] | ["rad", "per", "s"]) => Some(hz_from_rad_per_s),
        _ => None,
    }
}

/// The words of a title and where they begin.
fn words(title: &str) -> impl Iterator<Item = (usize, &str)> {
    let mark = |c: char| " _,/()[]{}|-:.".contains(c);
    let start = move |word: &str| word.as_ptr() as usize - title.as_ptr() as usize;
    title.split(mark).filter(|word| !word.is_empty()).map(move |word| (start(word), word))
}

/// A column by its title; `None` for what is no part of a response.
fn column(at: usize, title: &str) -> Option<Column> {
    let of_word = |word: &str| PARTS.iter().find(|(known, _)| *known == word.to_lowercase());
    let known: Vec<(usize, &str, Part)> = words(title)
        .filter_map(|(start, word)| of_word(word).map(|(_, part)| (start, word, *part)))
        .collect();
    let (first, word, part) = *known.first()?;
    let (last, last_word, _) = *known.last()?;
    // `phase_deg`, `mag_db`: the last one is the unit.
    let part = match (part, known.last()?.2) {
        (Part::Phase, unit @ (Part::Degrees | Part::Radians)) => unit,
        (Part::Magnitude, Part::Decibels) => Part::Decibels,
        (part, last) if part == last => part,
        _ => return None,
    };
    let trim = |text: &str| text.trim_matches(|c: char| " _,/()[]{}|-:.".contains(c)).to_owned();
    let before = trim(&title[..first]);
    if !before.is_empty() {
        let unit = trim(&title[last + last_word.len()..]);
        return Some(Column { at, name: before, unit, part });
    }
    // `Re(tip) [m/s2/N]`, `real_tip`.
    let behind = &title[first + word.len()..];
    let (name, unit) = match behind.split_once(')') {
        Some((name, unit)) if behind.trim_start().starts_with('(') => (name, unit),
        _ => match behind.split_once('[') {
            Some((name, unit)) => (name, unit),
            None => (behind, ""),
        },
    };
    let is_unit = |text: &str| words(text).all(|(_, word)| of_word(word).is_some());
    let plain = |text: &str| if is_unit(text) { String::new() } else { trim(text) };
    Some(Column { at, name: plain(name), unit: plain(unit), part })
}
