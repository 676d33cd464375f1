//! A record as CSV: a header, then one row a sample. A column `time_s`, `t_s`, `time_ms`, `t_ms`, `time` or `t`
//! (the last two in seconds) is time; all others are channels.

use std::path::Path;

use super::super::faults::Faults;
use super::super::table::Table;
use super::super::text::read_text;
use super::{Fault, LARGEST_RECORD_BYTES, RawChannel, RawFile, meaning_of_name};
use crate::units::s_from_ms;

/// How far a sample may lie from its place in even steps, as a share of a step: times are printed with few
/// digits (7 ms for 1/140 s), while a lost sample moves all that follow by a whole step.
const UNEVEN: f64 = 0.12;

/// Fewest samples of a record.
const FEWEST_SAMPLES: usize = 8;

type ToSeconds = fn(f64) -> f64;

const TIMES: [(&str, ToSeconds); 6] = [
    ("time_s", std::convert::identity),
    ("t_s", std::convert::identity),
    ("time_ms", s_from_ms),
    ("t_ms", s_from_ms),
    ("time", std::convert::identity),
    ("t", std::convert::identity),
];

pub(super) fn read(path: &Path) -> Result<RawFile, Vec<Fault>> {
    let text = read_text(path, LARGEST_RECORD_BYTES).map_err(|fault| vec![fault])?;
    let mut faults = Faults::of(path);
    let mut table = Table::open(path, text.as_bytes()).map_err(|fault| vec![fault])?;
    let header: Vec<String> = table.header().to_vec();
    check_header(&header, table.line(), &mut faults);
    let time = header
        .iter()
        .enumerate()
        .find_map(|(i, title)| Some((i, TIMES.iter().find(|(name, _)| name == title)?.1)));
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); header.len()];
    let mut lines = Vec::new();
    let mut cells = Vec::new();
    loop {
        match table.row(&mut cells) {
            Ok(true) => {}
            Ok(false) => break,
            Err(fault) => return Err(faults.finish_with(fault)),
        }
        if cells.len() > header.len() {
            let what = format!("has {} cells, the header has {}", cells.len(), header.len());
            faults.add(table.line(), what);
        }
        lines.push(table.line());
        for (index, column) in columns.iter_mut().enumerate() {
            match table.number(&cells, index) {
                Ok(value) => column.push(value),
                Err(fault) => {
                    faults.add(fault.line, fault.what);
                    column.push(0.0);
                }
            }
        }
    }
    if lines.len() < FEWEST_SAMPLES && faults.count() == 0 {
        let what = format!("has {} samples, must have at least {FEWEST_SAMPLES}", lines.len());
        faults.add(None, what);
    }
    let sample_rate_hz = match time {
        Some((index, to_s)) if faults.count() == 0 => {
            let times: Vec<f64> = columns[index].iter().map(|t| to_s(*t)).collect();
            rate(&times, &lines, &header[index], &mut faults)
        }
        _ => None,
    };
    if faults.count() > 0 {
        return Err(faults.finish());
    }
    let channels = header
        .iter()
        .zip(columns)
        .enumerate()
        .filter(|(index, _)| time.is_none_or(|(time, _)| time != *index))
        .map(|(_, (name, samples))| RawChannel {
            name: name.clone(),
            alias: name.clone(),
            meaning: meaning_of_name(name),
            samples,
        })
        .collect();
    Ok(RawFile { sample_rate_hz, channels, ..RawFile::default() })
}

fn check_header(header: &[String], line: usize, faults: &mut Faults) {
    for (index, title) in header.iter().enumerate() {
        if title.is_empty() {
            faults.add(line, format!("column {} has no name", index + 1));
        } else if header[..index].contains(title) {
            faults.add(line, format!("two columns are called '{title}'"));
        } else if title.parse::<f64>().is_ok() {
            let what = format!("column {} is called '{title}': is the header missing?", index + 1);
            faults.add(line, what);
        }
    }
}

/// Samples per second, from times in even steps.
fn rate(times: &[f64], lines: &[usize], title: &str, faults: &mut Faults) -> Option<f64> {
    let (&first, &last) = (times.first()?, times.last()?);
    let step = (last - first) / (times.len() - 1) as f64;
    if step <= 0.0 || !step.is_finite() {
        faults.add(*lines.last()?, format!("{title} does not rise from the first row to the last"));
        return None;
    }
    for (k, (time, line)) in times.iter().zip(lines).enumerate() {
        let even = first + k as f64 * step;
        if (time - even).abs() > UNEVEN * step {
            let what = format!(
                "{title} is {time} s, must be {even:.6} s for even steps of {step:.6} s; resample the record, or \
                 look for lost samples"
            );
            faults.add(*line, what);
            return None;
        }
    }
    Some(step.recip())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(text: &str) -> Result<RawFile, Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).unwrap();
        read(&path).map_err(|faults| {
            faults.iter().map(|f| format!("{}: {}", f.line.unwrap_or(0), f.what)).collect()
        })
    }

    fn rows(time: impl Fn(u32) -> f64) -> String {
        (0..20).map(|k| format!("{:.3},{}\n", time(k), k % 3)).collect()
    }

    #[test]
    fn rounded_times_are_even_and_a_lost_sample_is_not() {
        let even =
            told(&format!("# rig\ntime_s,x_mm\n{}", rows(|k| f64::from(k) / 140.0))).unwrap();
        assert!((even.sample_rate_hz.unwrap() - 140.0).abs() < 1.0);
        assert_eq!((even.channels.len(), even.channels[0].samples.len()), (1, 20));
        let lost = rows(|k| f64::from(if k < 9 { k } else { k + 1 }) / 140.0);
        let told = told(&format!("time_s,x_mm\n{lost}")).unwrap_err();
        assert!(told[0].contains("even steps"), "{told:?}");
    }

    #[test]
    fn every_fault_has_its_line() {
        for (text, expected) in [
            ("", "0: is empty"),
            ("x,x\n1,2\n", "1: two columns are called 'x'"),
            ("1.0,2.0\n1,2\n", "1: column 1 is called '1.0': is the header missing?"),
            ("x,y\n1,2\n1,a\n", "3: y is 'a', must be a finite number"),
            ("x,y\n1,2\n1\n", "3: y is empty"),
            ("x,y\n1,2,3\n", "2: has 3 cells, the header has 2"),
            ("x\n1\n2\n", "0: has 2 samples"),
        ] {
            let faults = told(text).unwrap_err();
            assert!(faults[0].starts_with(expected), "{text:?}: {faults:?}");
        }
    }
}
