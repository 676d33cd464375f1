//! Universal file format, data set 58 (function at nodal degree of freedom), as text and as binary
//! 58b (SDRC, Universal File Datasets). Time responses become channels, frequency responses
//! functions; other data sets are passed over.

use std::path::Path;

use nalgebra::Complex;

use super::{Channel, Function, Label, MAX_RECORD_BYTES, Recording};
use crate::formats::scalar::Scalar;
use crate::formats::text::read_bytes;
use crate::notes::{Code, Note, Notes, Place};

/// Channels and functions of one file, at most: 300 points hit in three directions are 900.
const MAX_SETS: usize = 4096;

/// Lines of text before the numbers.
const HEADER_LINES: usize = 11;

/// Function types.
const GENERAL: i64 = 0;
const TIME_RESPONSE: i64 = 1;
const FREQUENCY_RESPONSE: i64 = 4;

/// Types of abscissa.
const TIME: i64 = 17;
const FREQUENCY: i64 = 18;

/// What a fault says, and its line.
type Bad = (usize, String);

pub(super) fn read(path: &Path) -> Result<Recording, Vec<Note>> {
    let bytes = read_bytes(path, MAX_RECORD_BYTES)?;
    let mut lines = Lines { bytes: &bytes, at: 0, line: 0 };
    let (mut found, mut notes) = (Found::default(), Notes::about(Place::file(path)));
    while let Some((_, mark)) = lines.next() {
        if mark.trim() != "-1" {
            continue;
        }
        // The mark that opens a data set; its own mark closes it.
        let Some((mut line, mut kind)) = lines.next() else { break };
        while kind.trim() == "-1" {
            // Nothing between two marks: the second one opens the data set.
            let Some(next) = lines.next() else { break };
            (line, kind) = next;
        }
        let words: Vec<&str> = kind.split_whitespace().collect();
        match words.first() {
            Some(&"58") => match data_set(&mut lines, line, None) {
                Ok(set) => found.add(set, &mut notes),
                Err((line, what)) => {
                    notes.error(Code::Syntax, line, what);
                    lines.skip_data_set();
                }
            },
            Some(&"58b") => match binary_head(&words, line)
                .and_then(|head| data_set(&mut lines, line, Some(head)))
            {
                Ok(set) => found.add(set, &mut notes),
                Err((line, what)) => {
                    // Where the numbers end is not known: nothing after them can be trusted.
                    notes.error(Code::Syntax, line, what);
                    break;
                }
            },
            _ => lines.skip_data_set(),
        }
        if notes.errors() > 50 {
            break;
        }
        if found.file.channels.len() + found.file.functions.len() > MAX_SETS {
            let what = format!("holds more than {MAX_SETS} data sets; divide the file");
            notes.error(Code::TooLong, line, what);
            break;
        }
    }
    let file = found.file;
    if notes.errors() == 0 && file.channels.is_empty() && file.functions.is_empty() {
        let what = "holds no time response and no frequency response (data set 58)";
        notes.error(Code::TooLittleData, None, what);
    }
    let (errors, warnings) = notes.finish();
    if errors.is_empty() { Ok(Recording { warnings, ..file }) } else { Err(errors) }
}

/// Lines of a file that may hold bytes that are no text.
struct Lines<'b> {
    bytes: &'b [u8],
    at: usize,
    /// Line that was read last, counted from 1. Binary numbers count as what line ends they happen
    /// to hold.
    line: usize,
}

impl<'b> Lines<'b> {
    fn next(&mut self) -> Option<(usize, String)> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.at += length + 1;
        self.line += 1;
        let text = String::from_utf8_lossy(&rest[..length]);
        Some((self.line, text.trim_end_matches('\r').to_owned()))
    }

    fn is_mark_next(&self) -> bool {
        let mut ahead = Lines { bytes: self.bytes, at: self.at, line: self.line };
        ahead.next().is_none_or(|(_, text)| text.trim() == "-1")
    }

    /// Whether a mark stands behind the next `bytes` bytes, on their line or the next.
    fn is_mark_after(&self, bytes: usize) -> bool {
        let Some(at) = self.at.checked_add(bytes).filter(|at| *at < self.bytes.len()) else {
            return false;
        };
        let mut ahead = Lines { bytes: self.bytes, at, line: self.line };
        let first = ahead.next().map(|(_, text)| text);
        match first.as_deref().map(str::trim) {
            Some("") => ahead.next().is_some_and(|(_, text)| text.trim() == "-1"),
            first => first == Some("-1"),
        }
    }

    /// To the mark that ends a data set.
    fn skip_data_set(&mut self) {
        while let Some((_, text)) = self.next() {
            if text.trim() == "-1" {
                return;
            }
        }
    }

    fn take(&mut self, count: usize) -> Option<&'b [u8]> {
        let taken = self.bytes.get(self.at..self.at.checked_add(count)?)?;
        self.line += taken.iter().filter(|b| **b == b'\n').count();
        self.at += count;
        Some(taken)
    }
}

/// How binary numbers are stored.
#[derive(Debug, Clone, Copy)]
struct BinaryHead {
    is_big_endian: bool,
    bytes: usize,
}

fn binary_head(words: &[&str], line: usize) -> Result<BinaryHead, Bad> {
    let number = |index: usize, name: &str| -> Result<i64, Bad> {
        let word = words.get(index).copied().unwrap_or("");
        word.parse().map_err(|_| {
            (line, format!("{name} of data set 58b is '{word}', must be a whole number"))
        })
    };
    let order = number(1, "byte order")?;
    let floats = number(2, "float format")?;
    let text_lines = number(3, "number of text lines")?;
    let bytes = number(4, "number of bytes")?;
    if !matches!(order, 1 | 2) || floats != 2 || text_lines != HEADER_LINES as i64 {
        return Err((
            line,
            format!(
                "byte order {order}, float format {floats}, {text_lines} text lines: must be 1 or \
                    2, 2 (IEEE), {HEADER_LINES}"
            ),
        ));
    }
    let bytes = usize::try_from(bytes).map_err(|_| (line, format!("{bytes} bytes of data")))?;
    Ok(BinaryHead { is_big_endian: order == 2, bytes })
}

/// A data set 58.
struct DataSet {
    line: usize,
    function: i64,
    label: Label,
    reference: String,
    step: f64,
    first: f64,
    /// Abscissas where they are uneven.
    uneven: Option<Vec<f64>>,
    values: Vec<Complex<f64>>,
}

impl DataSet {
    /// The time step, also where times are written out and happen to be even.
    fn even_step(&self) -> Option<f64> {
        let Some(times) = &self.uneven else { return Some(self.step) };
        let (first, last) = (times.first()?, times.last()?);
        let step = (last - first) / (times.len().max(2) - 1) as f64;
        let is_even =
            |(k, time): (usize, &f64)| (time - first - k as f64 * step).abs() < 0.05 * step;
        (step > 0.0 && times.iter().enumerate().all(is_even)).then_some(step)
    }
}

fn data_set(
    lines: &mut Lines<'_>,
    first_line: usize,
    binary: Option<BinaryHead>,
) -> Result<DataSet, Bad> {
    let mut header = Vec::with_capacity(HEADER_LINES);
    for _ in 0..HEADER_LINES {
        match lines.next() {
            Some((line, text)) if binary.is_some() || text.trim() != "-1" => {
                header.push((line, text))
            }
            _ => return Err((first_line, "data set 58 ends within its header".to_owned())),
        }
    }
    let (line, text) = &header[5];
    let whole = |from: usize, to: usize, name: &str| {
        whole(text, from, to).ok_or((
            *line,
            format!("{name} is '{}', must be a whole number", cut(text, from, to).trim()),
        ))
    };
    let function = match (whole(0, 5, "function type")?, first_whole(&header[7].1)) {
        (GENERAL, Some(TIME)) => TIME_RESPONSE,
        (GENERAL, Some(FREQUENCY)) => FREQUENCY_RESPONSE,
        (function, _) => function,
    };
    let name = freedom(cut(text, 41, 51), cut(text, 51, 55));
    let reference = freedom(cut(text, 66, 76), cut(text, 76, 80));
    let Layout { is_double, is_complex, is_even, first, step, count } = layout(&header[6])?;
    let per_value = 1 + usize::from(is_complex) + usize::from(!is_even);
    let wanted = count.checked_mul(per_value).ok_or((header[6].0, "too many data".to_owned()))?;
    let numbers = match binary {
        Some(head) => binary_numbers(lines, first_line, head, wanted, is_double)?,
        None => text_numbers(lines, first_line, wanted)?,
    };
    if let Some(bad) = numbers.iter().position(|v| !v.is_finite()) {
        return Err((first_line, format!("number {} of data set 58 is not finite", bad + 1)));
    }
    let offset = usize::from(!is_even);
    let values = numbers
        .chunks_exact(per_value)
        .map(|v| Complex::new(v[offset], if is_complex { v[offset + 1] } else { 0.0 }))
        .collect();
    let uneven = (!is_even).then(|| numbers.chunks_exact(per_value).map(|v| v[0]).collect());
    let (unit, data_type) = ordinate(&header[8].1);
    let label = Label { name, alias: header[0].1.trim().to_owned(), unit, data_type };
    Ok(DataSet { line: first_line, function, label, reference, step, first, uneven, values })
}

/// What a specific data type of data set 58 measures.
fn quantity(data_type: Option<i64>) -> Option<&'static str> {
    match data_type? {
        8 => Some("displacement"),
        9 | 13 => Some("force"),
        11 => Some("velocity"),
        12 => Some("acceleration"),
        _ => None,
    }
}

/// How the numbers of a data set are laid out: its record 7.
struct Layout {
    is_double: bool,
    is_complex: bool,
    is_even: bool,
    first: f64,
    step: f64,
    count: usize,
}

fn layout((line, text): &(usize, String)) -> Result<Layout, Bad> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let number = |index: usize, name: &str| -> Result<f64, Bad> {
        words.get(index).and_then(|word| float(word)).ok_or((
            *line,
            format!("{name} is '{}', must be a number", words.get(index).unwrap_or(&"")),
        ))
    };
    let bad = |what: String| Err((*line, what));
    let (data_type, count) = (number(0, "ordinate data type")?, number(1, "number of data")?);
    let (is_even, first, step) = (
        number(2, "abscissa spacing")? == 1.0,
        number(3, "abscissa minimum")?,
        number(4, "abscissa increment")?,
    );
    let (is_double, is_complex) = match data_type {
        2.0 => (false, false),
        4.0 => (true, false),
        5.0 => (false, true),
        6.0 => (true, true),
        other => return bad(format!("ordinate data type is {other}, must be 2, 4, 5 or 6")),
    };
    if !(count >= 1.0 && count.fract() == 0.0 && count <= MAX_RECORD_BYTES as f64) {
        return bad(format!("number of data is {count}, must be a whole number of at least 1"));
    }
    if is_even && step <= 0.0 {
        return bad(format!("abscissa increment is {step}, must be positive"));
    }
    Ok(Layout { is_double, is_complex, is_even, first, step, count: count as usize })
}

/// Columns of a line, as far as they are there.
fn cut(text: &str, from: usize, to: usize) -> &str {
    let to = to.min(text.len());
    text.get(from.min(to)..to).unwrap_or("")
}

/// Type of data on a line of axis characteristics.
fn first_whole(text: &str) -> Option<i64> {
    text.split_whitespace().next()?.parse().ok()
}

fn whole(text: &str, from: usize, to: usize) -> Option<i64> {
    cut(text, from, to).trim().parse().ok()
}

/// "12+X": node and direction.
fn freedom(node: &str, direction: &str) -> String {
    let names = ["", "X", "Y", "Z", "RX", "RY", "RZ"];
    let direction: i64 = direction.trim().parse().unwrap_or(0);
    let sign = match direction {
        0 => "",
        d if d > 0 => "+",
        _ => "-",
    };
    let name = usize::try_from(direction.abs()).ok().and_then(|d| names.get(d)).unwrap_or(&"");
    format!("{}{sign}{name}", node.trim())
}

/// A number as FORTRAN writes it.
fn float(word: &str) -> Option<f64> {
    let plain = word.replace(['D', 'd'], "E");
    plain.parse::<f64>().ok().filter(|v| v.is_finite())
}

/// Label of units (of the response, where it is one over a force in N) and type of data from the
/// line of ordinate characteristics.
fn ordinate(text: &str) -> (String, Option<i64>) {
    let label = cut(text, 47, text.len()).trim();
    let over_force = label.rsplit_once('/').filter(|(_, by)| by.trim().eq_ignore_ascii_case("n"));
    (over_force.map_or(label, |(unit, _)| unit).to_owned(), first_whole(text))
}

fn binary_numbers(
    lines: &mut Lines<'_>,
    line: usize,
    head: BinaryHead,
    wanted: usize,
    is_double: bool,
) -> Result<Vec<f64>, Bad> {
    let scalar = match (is_double, head.is_big_endian) {
        (true, true) => Scalar::F64Big,
        (true, false) => Scalar::F64Little,
        (false, true) => Scalar::F32Big,
        (false, false) => Scalar::F32Little,
    };
    let bytes = wanted.saturating_mul(scalar.bytes());
    // Some writers count complex numbers as if they were real; then the mark tells where the
    // numbers end.
    let length = if lines.is_mark_after(bytes) { bytes } else { head.bytes };
    if length < bytes {
        let what = format!(
            "data set 58b announces {} bytes, its {wanted} numbers need {bytes}",
            head.bytes
        );
        return Err((line, what));
    }
    let Some(taken) = lines.take(length) else {
        return Err((line, format!("the file ends within the {length} bytes of data set 58b")));
    };
    lines.skip_data_set();
    let mut numbers = Vec::with_capacity(wanted);
    scalar.decode(&taken[..bytes], &mut numbers);
    Ok(numbers)
}

/// Numbers to the end of the data set, apart by blanks or, where they touch, by their signs.
fn text_numbers(lines: &mut Lines<'_>, first_line: usize, wanted: usize) -> Result<Vec<f64>, Bad> {
    // Never more than the file can hold, whatever the header announces.
    let mut numbers = Vec::with_capacity(wanted.min(lines.bytes.len()));
    while numbers.len() < wanted {
        if lines.is_mark_next() {
            let what = format!("data set 58 ends after {} of {wanted} numbers", numbers.len());
            return Err((first_line, what));
        }
        let Some((line, text)) = lines.next() else { break };
        let words: Option<Vec<f64>> = text.split_whitespace().map(float).collect();
        match words.or_else(|| touching(&text)) {
            Some(words) => numbers.extend(words),
            None => {
                let bad = text.split_whitespace().find(|word| float(word).is_none()).unwrap_or("");
                let bad: String = bad.chars().take(40).flat_map(char::escape_debug).collect();
                return Err((line, format!("'{bad}' must be a number")));
            }
        }
    }
    numbers.truncate(wanted);
    lines.skip_data_set();
    Ok(numbers)
}

/// Numbers of which the sign of one touches the last digit of the one before.
fn touching(text: &str) -> Option<Vec<f64>> {
    let mut apart = String::with_capacity(text.len());
    let mut before = ' ';
    for c in text.chars() {
        if matches!(c, '+' | '-') && before.is_ascii_digit() {
            apart.push(' ');
        }
        apart.push(c);
        before = c;
    }
    apart.split_whitespace().map(float).collect()
}

/// Why a frequency response is none that can be fitted.
fn no_complex_response(set: &DataSet) -> Option<&'static str> {
    if set.label.unit.to_lowercase().starts_with("db") {
        return Some("is in decibels");
    }
    let is_real = set.values.len() > 1 && set.values.iter().all(|value| value.im == 0.0);
    is_real.then_some("has no imaginary part, as a magnitude without phase")
}

/// The file as its data sets come.
#[derive(Default)]
struct Found {
    file: Recording,
    step: Option<f64>,
}

impl Found {
    fn add(&mut self, set: DataSet, notes: &mut Notes) {
        let mut bad = |what: String| notes.error(Code::Value, set.line, what);
        match set.function {
            TIME_RESPONSE => {
                let (step, name) = (set.even_step(), &set.label.name);
                let Some(step) = step else {
                    let what = format!("response {name} has uneven time steps; resample it");
                    return bad(what);
                };
                if let Some(before) =
                    // Steps are printed with six digits.
                    self.step.filter(|before| (before / step - 1.0).abs() > 1e-4)
                {
                    let what = format!(
                        "response {name} has time steps of {step} s, those before {before} s; must \
                         be the same"
                    );
                    return bad(what);
                }
                if let Some(first) = self.file.channels.first()
                    && first.samples.len() != set.values.len()
                {
                    let what = format!(
                        "response {name} has {} samples, those before {}; must be the same",
                        set.values.len(),
                        first.samples.len()
                    );
                    return bad(what);
                }
                // Where nodes were not filled in, data sets differ by their first line.
                let channels = &self.file.channels;
                let title = &set.label.alias;
                let is_new = |name: &str| channels.iter().all(|c| c.label.name != name);
                let is_other = |label: &Label| {
                    let mut same = channels.iter().filter(|c| c.label.name == label.name);
                    same.all(|c| c.label.data_type != label.data_type)
                };
                let is_new_title = channels.iter().all(|c| c.label.alias != *title);
                let name = match (is_new(name), is_new_title && is_new(title)) {
                    (true, _) => name.clone(),
                    (false, true) if !matches!(title.as_str(), "" | "NONE") => title.clone(),
                    // Force and acceleration of a driving point.
                    _ => match quantity(set.label.data_type).map(|own| format!("{name} {own}")) {
                        Some(own) if is_other(&set.label) && is_new(&own) => own,
                        _ => return bad(format!("response {name} comes twice")),
                    },
                };
                self.step = Some(step);
                self.file.sample_rate_hz = Some(step.recip());
                self.file.channels.push(Channel {
                    label: Label { name, ..set.label },
                    samples: set.values.iter().map(|v| v.re).collect(),
                });
            }
            FREQUENCY_RESPONSE => {
                if let Some(why) = no_complex_response(&set) {
                    let name = &set.label.name;
                    return bad(format!(
                        "frequency response {name} {why}: export real and imaginary part"
                    ));
                }
                let even = |k: usize| set.first + k as f64 * set.step;
                let frequencies_hz: Vec<f64> =
                    set.uneven.unwrap_or_else(|| (0..set.values.len()).map(even).collect());
                if !frequencies_hz.windows(2).all(|pair| pair[0] < pair[1])
                    || frequencies_hz[0] < 0.0
                {
                    let name = &set.label.name;
                    return bad(format!("frequencies of response {name} do not rise from zero on"));
                }
                self.file.functions.push(Function {
                    label: set.label,
                    reference: set.reference,
                    frequencies_hz,
                    values: set.values,
                    line: set.line,
                });
            }
            other => {
                let what = "is passed over: neither a time nor a frequency response";
                notes.warning(Code::Unused, set.line, format!("function type {other} {what}"));
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    fn header(
        function: i64,
        node: i64,
        data_type: i64,
        count: usize,
        step: f64,
        quantity: i64,
    ) -> String {
        format!(
            "point {node}\nNONE\nNONE\nNONE\nNONE\n{function:5}{:10}{:5}{:10} {:<10}{node:10}{:4} \
                {:<10}{:10}{:4}\n\
             {data_type:10}{count:10}{:10}{:13.5e}{step:13.5e}{:13.5e}\n\
             {:10}{:5}{:5}{:5} {:<20} {:<20}\n{quantity:10}{:5}{:5}{:5} {:<20} \
             {:<20}\n{:10}\n{:10}\n",
            0,
            1,
            0,
            "NONE",
            1,
            "NONE",
            7,
            -3,
            1,
            0.0,
            0.0,
            17,
            0,
            0,
            0,
            "Time",
            "s",
            0,
            0,
            0,
            "NONE",
            "NONE",
            0,
            0
        )
    }

    fn text_set(node: i64, samples: &[f64], quantity: i64) -> String {
        let mut text =
            format!("    -1\n    58\n{}", header(1, node, 2, samples.len(), 0.01, quantity));
        for chunk in samples.chunks(6) {
            for v in chunk {
                text.push_str(&format!("{v:13.5e}"));
            }
            text.push('\n');
        }
        text + "    -1\n"
    }

    fn reported(bytes: &[u8]) -> Result<Recording, Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.uff");
        std::fs::write(&path, bytes).unwrap();
        read(&path).map_err(|notes| {
            notes.iter().map(|f| format!("{}: {}", f.place.line.unwrap_or(0), f.what)).collect()
        })
    }

    #[test]
    fn text_and_binary_give_the_same_numbers() {
        let samples: Vec<f64> = (0..20).map(|k| f64::from(k) - 9.5).collect();
        let text = text_set(3, &samples, 12);
        let found = reported(format!("    -1\n   151\nany\n    -1\n{text}").as_bytes()).unwrap();
        assert_eq!(found.channels[0].samples, samples);
        assert_eq!(found.channels[0].label.name, "3+X");
        assert_eq!(found.channels[0].label.alias, "point 3");
        assert_eq!(found.channels[0].label.data_type, Some(12));
        assert!((found.sample_rate_hz.unwrap() - 100.0).abs() < 1e-9);
        for (big, data_type) in [(false, 4), (true, 4), (false, 2), (true, 2)] {
            let mut data = Vec::new();
            for v in &samples {
                match (data_type, big) {
                    (4, true) => data.extend(v.to_be_bytes()),
                    (4, false) => data.extend(v.to_le_bytes()),
                    (_, true) => data.extend((*v as f32).to_be_bytes()),
                    (_, false) => data.extend((*v as f32).to_le_bytes()),
                }
            }
            let order = if big { 2 } else { 1 };
            let mut bytes = format!(
                "    -1\n    58b{order:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}\n{}",
                2,
                11,
                data.len(),
                0,
                0,
                0,
                0,
                header(1, 3, data_type, samples.len(), 0.01, 12)
            )
            .into_bytes();
            bytes.extend(&data);
            bytes.extend(b"\n    -1\n");
            bytes.extend(text_set(4, &samples, 8).bytes());
            let found = reported(&bytes).unwrap();
            assert_eq!(found.channels.len(), 2);
            assert_eq!(found.channels[0].samples, samples);
            assert_eq!(found.channels[1].label.data_type, Some(8));
        }
    }

    /// As other writers have them: two marks in a row, a general function over time, nodes that are
    /// not filled in, times that are written out.
    #[test]
    fn other_writers_are_understood() {
        let samples: Vec<f64> = (0..20).map(|k| f64::from(k) - 9.5).collect();
        let first = text_set(0, &samples, 12).replacen("point 0", "left", 1);
        let second = text_set(0, &samples, 12).replacen("point 0", "right", 1);
        let general = second.replacen("    1         0    1", "    0         0    1", 1);
        assert_ne!(general, second);
        let found = reported(format!("    -1\n{first}{general}").as_bytes()).unwrap();
        let names: Vec<&str> = found.channels.iter().map(|c| c.label.name.as_str()).collect();
        assert_eq!(names, ["0+X", "right"]);
        let head =
            header(1, 3, 4, 4, 0.0, 12).replacen("         4         1", "         4         0", 1);
        let pairs = |times: [f64; 4]| -> String {
            let pairs: String =
                times.iter().map(|t| format!("{t:13.5e}{:20.11e}", 2.0 * t)).collect();
            format!("    -1\n    58\n{head}{pairs}\n    -1\n")
        };
        let even = reported(pairs([0.0, 0.5, 1.0, 1.5]).as_bytes()).unwrap();
        assert_eq!(
            (even.sample_rate_hz, &even.channels[0].samples[..]),
            (Some(2.0), &[0.0, 1.0, 2.0, 3.0][..])
        );
        assert!(
            reported(pairs([0.0, 0.5, 1.0, 1.7]).as_bytes()).unwrap_err()[0]
                .contains("uneven time steps")
        );
    }

    #[test]
    fn a_frequency_response_has_its_reference() {
        let mut text = format!("    -1\n    58\n{}", header(4, 2, 5, 3, 0.5, 12));
        text.push_str(
            " 1.00000E+00 2.00000E+00-3.00000E+00-4.00000E+00 5.00000E+00 6.00000E+00\n    -1\n",
        );
        let found = reported(text.as_bytes()).unwrap();
        let function = &found.functions[0];
        assert_eq!(function.reference, "7-Z");
        assert_eq!(function.frequencies_hz, [0.0, 0.5, 1.0]);
        assert_eq!(function.values[1], Complex::new(-3.0, -4.0));
    }

    #[test]
    fn damage_is_told_with_its_line_and_never_panics() {
        let samples = [1.0; 20];
        let good = text_set(3, &samples, 12);
        for (from, to, expected) in [
            (" 1e0", " x e0", "14: 'x'"),
            ("   20         1", "    0         1", "9: number of data is 0"),
            ("   20         1", "   99         1", "2: data set 58 ends after 20 of 99"),
            ("         2        20", "         3        20", "9: ordinate data type is 3"),
            ("    58\n", "    59\n", "0: holds no time response"),
            ("1.00000e-2", "0.00000e00", "9: abscissa increment is 0"),
        ] {
            let broken = good.replacen(from, to, 1);
            let broken = if from == " 1e0" { good.replacen("1.00000e0", "x", 1) } else { broken };
            let notes = reported(broken.as_bytes()).unwrap_err();
            assert!(notes[0].starts_with(expected), "{from}: {notes:?}");
        }
        // A driving point has a force and an acceleration.
        let force = text_set(3, &samples, 13).replace("point 3", "NONE");
        let both = reported((good.replace("point 3", "NONE") + &force).as_bytes()).unwrap();
        let names: Vec<&str> = both.channels.iter().map(|c| c.label.name.as_str()).collect();
        assert_eq!(names, ["3+X", "3+X force"]);
        let twice = good.clone() + &good;
        assert!(reported(twice.as_bytes()).unwrap_err()[0].contains("comes twice"));
        for cut in (0..good.len()).step_by(7) {
            let _ = reported(&good.as_bytes()[..cut]);
            let mut broken = good.clone().into_bytes();
            broken[cut] = 0xF7;
            let _ = reported(&broken);
        }
        let huge = good.replacen("        20         1", " 999999999         1", 1);
        assert!(reported(huge.as_bytes()).is_err());
    }
}
