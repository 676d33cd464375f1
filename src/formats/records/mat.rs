//! A record as MATLAB's .mat of level 5 (`save -v6` and `-v7`; MathWorks, MAT-File Format), with or
//! without compression, in either order of bytes. A variable that is a vector is a channel of its
//! name; of a matrix of samples × channels each column is one (`acc_1`, `acc_2`, …). A variable `t`
//! or `time`, with its unit if it has one (`t_ms`), is time; a single value `fs` is the sampling
//! rate, `dt` the time between samples in seconds. Where there is no time, but frequencies (`f`,
//! `freq_hz`), complex variables are frequency responses, as are pairs of `tip_re` and `tip_im` and
//! whatever else a table may have. What is no channel is told.
//!
//! Not by the crate matfile 0.5: a file that is cut off is read as far as it goes without a word,
//! compressed variables are unpacked without a limit, dimensions are multiplied until they
//! overflow, it prints to the terminal, and it brings a second implementation of DEFLATE.

mod elements;

use std::path::Path;

use self::elements::{DEEP, Kind, Variable, variables};
use super::clock::{Clock, clock, time_among};
use super::responses::{Columns, frequency, functions};
use super::{Channel, Function, Label, MAX_RECORD_BYTES, MIN_SAMPLES, Recording};
use crate::formats::text::read_bytes;
use crate::notes::{Code, Note, Notes, Place};

/// Variables that are told of in one message, at most.
const MAX_TOLD: usize = 8;

/// What a variable with one value is called that is samples per second.
const RATES: [&str; 2] = ["fs", "sample_rate_hz"];

/// What a variable with one value is called that is seconds between samples.
const STEPS: [&str; 2] = ["dt", "dt_s"];

/// `named` is the variable that is time, where the session says so.
pub(super) fn read(path: &Path, named: Option<&str>) -> Result<Recording, Vec<Note>> {
    let bytes = read_bytes(path, MAX_RECORD_BYTES)?;
    let mut notes = Notes::about(Place::file(path));
    let found = variables(&bytes).map_err(|(code, what)| {
        notes.error(code, None, what);
    });
    let file = found.ok().map(|found| recording(found, named, &mut notes)).unwrap_or_default();
    let (errors, warnings) = notes.finish();
    if errors.is_empty() { Ok(Recording { warnings, ..file }) } else { Err(errors) }
}

/// A vector, or a column of a matrix.
struct Column {
    name: String,
    variable: String,
    values: Vec<f64>,
    /// Imaginary parts of complex ones.
    imaginary: Option<Vec<f64>>,
}

fn recording(found: Vec<Variable>, named: Option<&str>, notes: &mut Notes) -> Recording {
    let mut sample_rate_hz = None;
    let mut others: Vec<String> = Vec::new();
    let mut columns: Vec<Column> = Vec::new();
    for Variable { name, kind } in found {
        let (rows, wide, values, imaginary) = match kind {
            Kind::Numbers { rows, columns, values, imaginary } => {
                (rows, columns, values, imaginary)
            }
            Kind::Other(what) => {
                others.push(format!("{name} ({what})"));
                continue;
            }
        };
        match (rows, wide) {
            (_, _) if values.is_empty() => others.push(format!("{name} (empty)")),
            (1, 1) if RATES.contains(&name.to_lowercase().as_str()) => {
                sample_rate_hz = values.first().copied();
            }
            (1, 1) if STEPS.contains(&name.to_lowercase().as_str()) => {
                sample_rate_hz = values.first().map(|step| step.recip());
            }
            (1, 1) => others.push(format!("{name} (a single value)")),
            (1, _) | (_, 1) => {
                columns.push(Column { variable: name.clone(), name, values, imaginary });
            }
            _ if wide > rows => {
                let wanted = match imaginary {
                    Some(_) => "lines × responses",
                    None => "samples × channels",
                };
                let what = format!("{rows} × {wide}, must be {wanted}; save it transposed");
                others.push(format!("{name} ({what})"));
            }
            _ => columns.extend((0..wide).map(|at| {
                let own = |all: &Vec<f64>| all[at * rows..(at + 1) * rows].to_vec();
                Column {
                    name: format!("{name}_{}", at + 1),
                    variable: name.clone(),
                    values: own(&values),
                    imaginary: imaginary.as_ref().map(own),
                }
            })),
        }
    }
    let names: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
    if let Some(twice) = names.iter().enumerate().find(|(at, name)| names[..*at].contains(name)) {
        notes.error(Code::Conflict, None, format!("two channels are called '{}'", twice.1));
    }
    if time_among(&names, named).is_none()
        && let Some(responses) = responses(&columns, &mut others, notes)
    {
        if notes.errors() == 0 && !others.is_empty() {
            let what = format!("is read without {}: no responses", told(&others));
            notes.warning(Code::Unused, None, what);
        }
        return Recording { functions: responses, is_titled: true, ..Recording::default() };
    }
    let has_frequencies = columns.iter().any(|own| frequency(&own.name).is_some());
    if sample_rate_hz.is_none()
        && time_among(&names, named).is_none()
        && let Some(deep) = others.iter().find(|other| has_frequencies && other.contains(DEEP))
    {
        let what = format!(
            "holds frequencies, but no responses on them: {deep}, must be lines × responses; save \
             the responses to each reference as a matrix of its own, in a file of its own, or all \
             of them as UFF 58"
        );
        notes.error(Code::TooLittleData, None, what);
        return Recording::default();
    }
    let is_complex = |column: &mut Column| column.imaginary.is_some();
    others.extend(columns.extract_if(.., is_complex).map(|own| format!("{} (complex)", own.name)));
    let names: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
    let time = time_among(&names, named);
    let samples = match time {
        Some((at, _)) => columns[at].values.len(),
        None => columns.iter().map(|column| column.values.len()).max().unwrap_or(0),
    };
    let is_time = |at: usize| time.is_some_and(|(time, _)| time == at);
    let mut channels = Vec::new();
    let (mut times, mut name_of_time) = (None, None);
    for (at, Column { name, variable, values, .. }) in columns.into_iter().enumerate() {
        if values.len() != samples {
            others.push(format!("{name} ({} samples, not {samples})", values.len()));
            continue;
        }
        if let Some(bad) = values.iter().position(|value| !value.is_finite()) {
            notes.error(Code::Value, None, format!("{name}: sample {} is not finite", bad + 1));
        }
        if is_time(at) {
            (times, name_of_time) = (Some(values), Some(name));
        } else {
            let label = Label { name, alias: variable, ..Label::default() };
            channels.push(Channel { label, samples: values });
        }
    }
    let told = told(&others);
    if channels.is_empty() {
        let what = match others.is_empty() {
            true => "holds no variable that is a channel".to_owned(),
            false => format!(
                "holds no variable that is a channel, but {told}; save vectors of numbers, those \
                 of a structure by save('-struct', …)"
            ),
        };
        notes.error(Code::TooLittleData, None, what);
    } else if samples < MIN_SAMPLES {
        let what = format!("has {samples} samples, must have at least {MIN_SAMPLES}");
        notes.error(Code::TooLittleData, None, what);
    } else if !others.is_empty() {
        notes.warning(Code::Unused, None, format!("is read without {told}: no channels"));
    }
    let mut times_s = None;
    if let (Some((_, to_s)), Some(times), Some(name)) = (time, times, &name_of_time)
        && notes.errors() == 0
    {
        let times = times.into_iter().map(to_s).collect();
        match clock(times, name).map(Clock::parts) {
            // Vectors of time say more than a rounded rate.
            Ok((rate_hz, uneven)) => (sample_rate_hz, times_s) = (rate_hz, uneven),
            Err((at, what)) => {
                notes.error(Code::Value, None, format!("{what} (sample {})", at + 1));
            }
        }
    }
    Recording {
        sample_rate_hz,
        times_s,
        time: name_of_time,
        channels,
        is_titled: true,
        ..Recording::default()
    }
}

/// The frequency responses; `None` where there are no frequencies, or nothing else of their length.
fn responses(
    columns: &[Column],
    others: &mut Vec<String>,
    notes: &mut Notes,
) -> Option<Vec<Function>> {
    let of_lines =
        columns.iter().find(|own| own.imaginary.is_none() && frequency(&own.name).is_some())?;
    let lines = of_lines.values.len();
    let (mut titles, mut values) = (Vec::new(), Vec::new());
    let mut left = Vec::new();
    for Column { name, values: own, imaginary, .. } in columns {
        if own.len() != lines {
            left.push(format!("{name} ({} values, not {lines})", own.len()));
            continue;
        }
        let parts = match imaginary {
            Some(imaginary) => vec![(format!("{name}_re"), own), (format!("{name}_im"), imaginary)],
            None => vec![(name.clone(), own)],
        };
        for (title, own) in parts {
            if let Some(bad) = own.iter().position(|value| !value.is_finite()) {
                notes.error(Code::Value, None, format!("{name}: value {} is not finite", bad + 1));
            }
            titles.push(title);
            values.push(own.clone());
        }
    }
    let table = Columns { titles: &titles, values: &values, header_line: None };
    let found = functions(&table, notes)?;
    if lines < MIN_SAMPLES {
        let what = format!("has {lines} lines, must have at least {MIN_SAMPLES}");
        notes.error(Code::TooLittleData, None, what);
    }
    others.extend(left);
    Some(found)
}

fn told(others: &[String]) -> String {
    let named = others.iter().take(MAX_TOLD).map(String::as_str).collect::<Vec<_>>().join(", ");
    match others.len().saturating_sub(MAX_TOLD) {
        0 => named,
        more => format!("{named} and {more} more"),
    }
}

#[cfg(test)]
mod tests;
