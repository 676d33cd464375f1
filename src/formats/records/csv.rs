//! A record as CSV: a header, then one row a sample, with commas between the cells, or with tabs or
//! semicolons and then also decimal commas. A column `time` or `t`, in seconds or with its unit
//! (`time_s`, `t [ms]`), is time; all others are channels. A header that was written as a comment,
//! as numpy does, is taken for the header. Times may be uneven, as a telephone's are; a jump by far
//! more than they usually vary is a loss of samples. Without a time, columns may be frequency
//! responses.

use std::io::Read;
use std::path::Path;

use super::clock::{Clock, clock, time_among};
use super::responses::{Columns, functions};
use super::{Channel, Label, MAX_RECORD_BYTES, MIN_SAMPLES, Recording};
use crate::formats::table::Table;
use crate::formats::text::read_text;
use crate::notes::{Code, Note, Notes, Place};
use crate::wording::counted;

/// `named` is the title of the column that is time, where the session says so.
pub(super) fn read(path: &Path, named: Option<&str>) -> Result<Recording, Vec<Note>> {
    let mut text = read_text(path, MAX_RECORD_BYTES)?;
    if let Some(separated) = with_commas(&text) {
        text = separated;
    }
    let mut notes = Notes::about(Place::file(path));
    if let Some((line, at)) = header_as_comment(&text) {
        text.replace_range(at..=at, " ");
        notes.warning(Code::Remark, line, "the header is a comment; it is read as the header");
    }
    let mut table = Table::open(path, text.as_bytes())?;
    let header: Vec<String> = table.header().to_vec();
    let header_line = table.line();
    check_header(&header, header_line, &mut notes);
    let time = time_among(&header, named);
    let Some((columns, lines)) = columns(&mut table, header.len(), &mut notes) else {
        return Err(notes.finish().0);
    };
    if lines.len() < MIN_SAMPLES && notes.errors() == 0 {
        let what = format!("has {} samples, must have at least {MIN_SAMPLES}", lines.len());
        notes.error(Code::TooLittleData, None, what);
    }
    if notes.errors() == 0 && time.is_none() {
        let header_line = Some(header_line);
        let table = Columns { titles: &header, values: &columns, header_line };
        if let Some(functions) = functions(&table, &mut notes) {
            let is_sound = notes.errors() == 0;
            let warnings = notes.finish();
            let is_titled = true;
            return if is_sound {
                let warnings = warnings.1;
                Ok(Recording {
                    functions,
                    is_titled,
                    header_line,
                    warnings,
                    ..Recording::default()
                })
            } else {
                Err(warnings.0)
            };
        }
    }
    let clock = match time {
        Some((index, to_s)) if notes.errors() == 0 => {
            let times = columns[index].iter().map(|t| to_s(*t)).collect();
            let clock = clock(times, &header[index]);
            clock.map_err(|(at, what)| notes.error(Code::Value, lines[at], what)).ok()
        }
        _ => None,
    };
    if notes.errors() > 0 {
        return Err(notes.finish().0);
    }
    let (sample_rate_hz, times_s) = clock.map_or((None, None), Clock::parts);
    let name_of_time = time.map(|(index, _)| header[index].clone());
    let is_time = |index: usize| time.is_some_and(|(time, _)| time == index);
    let of_channels =
        header.into_iter().zip(columns).enumerate().filter(|&(index, _)| !is_time(index));
    let channels = of_channels.map(|(_, (name, samples))| {
        let label = Label { alias: name.clone(), name, ..Label::default() };
        Channel { label, samples }
    });
    Ok(Recording {
        sample_rate_hz,
        times_s,
        time: name_of_time,
        channels: channels.collect(),
        is_titled: true,
        header_line: Some(header_line),
        warnings: notes.finish().1,
        ..Recording::default()
    })
}

/// The columns of a table and the line of each row; `None` where a row cannot be read at all.
fn columns<R: Read>(
    table: &mut Table<R>,
    count: usize,
    notes: &mut Notes,
) -> Option<(Vec<Vec<f64>>, Vec<usize>)> {
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); count];
    let (mut lines, mut cells) = (Vec::new(), Vec::new());
    // The first fault of each column, and how many like it come: a mark that is lost, or a sensor
    // that was not connected, leaves one in many rows.
    let mut faults: Vec<Option<(Note, usize)>> = vec![None; count];
    loop {
        match table.row(&mut cells) {
            Ok(true) => {}
            Ok(false) => {
                for (mut fault, more) in faults.into_iter().flatten() {
                    if more > 0 {
                        fault.what += &format!(", and so in {}", counted(more, "further row"));
                    }
                    notes.push(fault);
                }
                return Some((columns, lines));
            }
            Err(note) => {
                notes.push(note);
                return None;
            }
        }
        if cells.len() > count {
            let what = format!("has {} cells, the header has {count}", cells.len());
            notes.error(Code::Value, table.line(), what);
        }
        lines.push(table.line());
        for (index, column) in columns.iter_mut().enumerate() {
            match table.number(&cells, index) {
                Ok(value) => column.push(value),
                Err(fault) => {
                    match &mut faults[index] {
                        Some((first, more)) if first.what == fault.what => *more += 1,
                        Some(_) => notes.push(fault),
                        first => *first = Some((fault, 0)),
                    }
                    column.push(0.0);
                }
            }
        }
    }
}

/// A table with tabs or semicolons between its cells, and with decimal commas or points, as one
/// with commas and points; `None` where it has neither. Lines stay lines.
fn with_commas(text: &str) -> Option<String> {
    let is_row = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let header = text.trim_start_matches('\u{feff}').lines().find(is_row)?;
    let mark = ['\t', ';'].into_iter().find(|mark| header.contains(*mark))?;
    let ends_in_mark = header.trim_end_matches('\r').ends_with(mark);
    let mut separated = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let row = line.trim_end_matches(['\r', '\n']);
        let row = if ends_in_mark { row.strip_suffix(mark).unwrap_or(row) } else { row };
        let is_comment = row.trim_start().starts_with('#');
        for (index, cell) in row.split(mark).enumerate() {
            if index > 0 {
                separated.push(',');
            }
            let cell = cell.trim();
            let pointed = cell.replace(',', ".");
            if !cell.contains(',') {
                separated.push_str(cell);
            } else if pointed.parse::<f64>().is_ok() {
                separated.push_str(&pointed);
            } else if is_comment || cell.starts_with('"') {
                separated.push_str(&cell.replace(',', " "));
            } else {
                separated.push_str(&format!("\"{cell}\""));
            }
        }
        if line.ends_with('\n') {
            separated.push('\n');
        }
    }
    Some(separated)
}

/// Line and place of the mark that makes a comment of what must be the header: the first row is all
/// numbers, and the comment before it has as many cells that are not.
fn header_as_comment(text: &str) -> Option<(usize, usize)> {
    let mut comment: Option<(usize, usize, &str)> = None;
    let mut at = 0;
    for (index, line) in text.split_inclusive('\n').enumerate() {
        let row = line.trim();
        if let Some(cells) = row.strip_prefix('#') {
            comment = Some((index + 1, at + line.find('#')?, cells));
        } else if !row.is_empty() {
            let is_number = |cell: &str| cell.trim().parse::<f64>().is_ok();
            let (line, at, cells) = comment?;
            let is_header = row.split(',').all(is_number)
                && cells.split(',').count() == row.split(',').count()
                && !cells.split(',').any(|cell| is_number(cell) || cell.trim().is_empty());
            return is_header.then_some((line, at));
        }
        at += line.len();
    }
    None
}

fn check_header(header: &[String], line: usize, notes: &mut Notes) {
    for (index, title) in header.iter().enumerate() {
        if title.is_empty() {
            notes.error(Code::MissingKey, line, format!("column {} has no name", index + 1));
        } else if header[..index].contains(title) {
            notes.error(Code::Conflict, line, format!("two columns are called '{title}'"));
        } else if title.parse::<f64>().is_ok() {
            let what = format!("column {} is called '{title}': is the header missing?", index + 1);
            notes.error(Code::MissingKey, line, what);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::clock::time;
    use super::*;

    fn reported(text: &str) -> Result<Recording, Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).unwrap();
        read(&path, None).map_err(|notes| {
            notes.iter().map(|n| format!("{}: {}", n.place.line.unwrap_or(0), n.what)).collect()
        })
    }

    fn rows(time: impl Fn(u32) -> f64) -> String {
        (0..20).map(|k| format!("{:.3},{}\n", time(k), k % 3)).collect()
    }

    #[test]
    fn rounded_times_are_even_and_a_lost_sample_is_not() {
        let even =
            reported(&format!("# rig\ntime_s,x_mm\n{}", rows(|k| f64::from(k) / 140.0))).unwrap();
        assert!((even.sample_rate_hz.unwrap() - 140.0).abs() < 1.0);
        assert_eq!((even.channels.len(), even.channels[0].samples.len()), (1, 20));
        let lost = rows(|k| f64::from(if k < 9 { k } else { k + 1 }) / 140.0);
        let reported = reported(&format!("time_s,x_mm\n{lost}")).unwrap_err();
        assert!(
            reported[0].contains("steps of about 0.007")
                && reported[0].contains("a sample is lost"),
            "{reported:?}"
        );
        // Below the head and nine rows.
        assert!(reported[0].starts_with("11: "), "{reported:?}");
    }

    /// Off by up to a third of a step, as a telephone's are; a gap of three steps is a loss, and
    /// times that go back are a fault.
    #[test]
    fn uneven_times_are_kept_and_gaps_in_them_are_losses() {
        let shift = |k: u32| 0.3 * (f64::from(k * k) * 0.7).sin();
        let uneven = |k: u32| (f64::from(k) + shift(k)) * 0.01;
        let found = reported(&format!("t,x\n{}", rows(uneven))).unwrap();
        let times = found.times_s.unwrap();
        assert_eq!((found.sample_rate_hz, times.len()), (None, 20));
        assert!(times.iter().zip(0..).all(|(t, k)| (t - uneven(k)).abs() < 1e-3));
        let lost = |k: u32| uneven(k) + if k < 9 { 0.0 } else { 0.03 };
        let told = reported(&format!("t,x\n{}", rows(lost))).unwrap_err();
        assert!(told[0].starts_with("11: ") && told[0].contains("samples are lost"), "{told:?}");
        let back = |k: u32| uneven(k) - if k == 9 { 0.02 } else { 0.0 };
        let told = reported(&format!("t,x\n{}", rows(back))).unwrap_err();
        assert!(told[0].starts_with("11: ") && told[0].contains("must rise"), "{told:?}");
    }

    #[test]
    fn tabs_and_semicolons_with_decimal_commas_are_read() {
        for (mark, end) in [(';', "\r\n"), ('\t', "\n")] {
            let mut text = format!("# rig; 3{end}Zeit, unsinn{mark}t [s]{mark}x, mm{mark}{end}");
            for k in 0..20 {
                let time = format!("{:.3}", f64::from(k) * 0.005).replace('.', ",");
                text += &format!("1,5{mark}{time}{mark}-{k},25e-1{mark}{end}");
            }
            let found = reported(&text).unwrap();
            assert!((found.sample_rate_hz.unwrap() - 200.0).abs() < 1e-9);
            let names: Vec<_> = found.channels.iter().map(|c| c.label.name.as_str()).collect();
            assert_eq!(names, ["Zeit, unsinn", "x, mm"]);
            assert_eq!(found.channels[1].samples[7], -0.725);
            let told = reported(&text.replacen("1,5", "1,5,5", 1)).unwrap_err();
            assert!(told[0].starts_with("3: Zeit, unsinn is '1,5,5'"), "{told:?}");
        }
    }

    #[test]
    fn titles_are_read_as_people_write_them() {
        for title in ["t", "Time [s]", "time_s", "t / s", "TIME (sec)"] {
            assert_eq!(time(title).unwrap()(2.0), 2.0, "{title}");
        }
        assert_eq!(time("Time (ms)").unwrap()(2.0), 2e-3);
        for title in ["x", "time_x", "timer", "", "t_s_x"] {
            assert!(time(title).is_none(), "{title}");
        }
        let mut text = String::from("# rig 3\n#frame, t [ms],acc (m/s^2),x_mm,x_g\r\n");
        for k in 0..20 {
            text += &format!("{k},{},{},{},1\r\n", 5 * k, k % 3, k % 7);
        }
        let found = reported(&text).unwrap();
        assert!((found.sample_rate_hz.unwrap() - 200.0).abs() < 1e-9);
        let names: Vec<_> = found.channels.iter().map(|c| c.label.name.as_str()).collect();
        assert_eq!(names, ["frame", "acc (m/s^2)", "x_mm", "x_g"]);
        assert_eq!(found.warnings[0].place.line, Some(2));
        assert_eq!(found.warnings[0].what, "the header is a comment; it is read as the header");
        assert!(reported("# 1,2\n1,2\n").is_err() && reported("# a,b\n1,2,3\n").is_err());
    }

    #[test]
    fn every_fault_has_its_line() {
        for (text, expected) in [
            ("", "0: is empty"),
            ("x,x\n1,2\n", "1: two columns are called 'x'"),
            ("1.0,2.0\n1,2\n", "1: column 1 is called '1.0': is the header missing?"),
            ("x,y\n1,2\n1,a\n", "3: y is 'a', must be a finite number"),
            ("x,y\n1,2\n1\n", "3: y is empty, must be a finite number"),
            (
                "x,y\n1,\n1,2\n3,\n4,\n",
                "2: y is empty, must be a finite number, and so in 2 further rows",
            ),
            ("x,y\n1,2,3\n", "2: has 3 cells, the header has 2"),
            ("x\n1\n2\n", "0: has 2 samples"),
        ] {
            let notes = reported(text).unwrap_err();
            assert!(notes[0].starts_with(expected), "{text:?}: {notes:?}");
        }
        assert_eq!(reported("x,y\n1,\n1,2\n3,\n4,\n").unwrap_err().len(), 1);
    }
}
