//! Poses from a CSV, chunk by chunk: a table of any length in bounded memory.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::{fault, nearest, slides};
use crate::input::Fault;
use crate::model::Robot;
use crate::units::{m_from_mm, rad_from_deg};

/// Faults of one chunk that are told; the rest is counted.
const MOST_TOLD: usize = 20;

/// Reads poses of one robot.
pub(super) struct PoseReader<R: Read> {
    file: PathBuf,
    reader: csv::Reader<R>,
    columns: Vec<Column>,
}

/// Where a joint's value stands, and how it turns into rad or m.
struct Column {
    name: String,
    place: usize,
    convert: fn(f64) -> f64,
}

impl<R: Read> PoseReader<R> {
    /// Reads the header and finds the joints in it.
    pub(super) fn new(robot: &Robot, file: &Path, input: R) -> Result<Self, Vec<Fault>> {
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(input);
        let header = reader
            .headers()
            .map_err(|error| fault(Some(file), None, format!("cannot be read: {error}")))?
            .clone();
        let line = header.position().map(|at| at.line() as usize);
        let names: Vec<&str> =
            header.iter().map(|name| name.trim_start_matches('\u{feff}')).collect();
        let mut faults = Vec::new();
        let mut used = vec![false; names.len()];
        let mut columns = Vec::new();
        for (index, joint) in robot.joints().iter().enumerate() {
            let units: [(&str, fn(f64) -> f64); 2] = if slides(robot, index) {
                [("m", |v| v), ("mm", m_from_mm)]
            } else {
                [("rad", |v| v), ("deg", rad_from_deg)]
            };
            let mut found = Vec::new();
            for (unit, convert) in units {
                let wanted = format!("{}_{unit}", joint.name);
                for (place, _) in names.iter().enumerate().filter(|(_, name)| **name == wanted) {
                    used[place] = true;
                    found.push(Column { name: wanted.clone(), place, convert });
                }
            }
            match found.len() {
                0 => {
                    let [(a, _), (b, _)] = units;
                    let what = format!("no column '{0}_{a}' or '{0}_{b}'", joint.name);
                    faults.extend(fault(Some(file), line, what));
                }
                1 => columns.extend(found),
                _ => {
                    let what = format!("joint '{}' has more than one column", joint.name);
                    faults.extend(fault(Some(file), line, what));
                }
            }
        }
        let known: Vec<String> = robot
            .joints()
            .iter()
            .flat_map(|joint| ["rad", "deg"].map(|unit| format!("{}_{unit}", joint.name)))
            .collect();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        for (name, used) in names.iter().zip(used) {
            if !used && !is_beside_the_pose(name) {
                let hint = nearest(name, &known)
                    .map_or_else(String::new, |n| format!("; did you mean '{n}'?"));
                faults.extend(fault(Some(file), line, format!("unknown column '{name}'{hint}")));
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        Ok(Self { file: file.to_owned(), reader, columns })
    }

    /// Up to `chunk` further poses, and the line of each.
    pub(super) fn next(&mut self, chunk: usize) -> Result<(Vec<Vec<f64>>, Vec<usize>), Vec<Fault>> {
        let (mut poses, mut lines) = (Vec::new(), Vec::new());
        let mut faults: Vec<Fault> = Vec::new();
        let mut untold = 0;
        let mut record = csv::StringRecord::new();
        while poses.len() < chunk {
            let row = match self.reader.read_record(&mut record) {
                Ok(false) => break,
                Ok(true) => self.pose(&record),
                Err(error) => {
                    let line = error.position().map(|at| at.line() as usize);
                    Err(fault(Some(&self.file), line, told(&error)))
                }
            };
            match row {
                Ok((pose, line)) => {
                    poses.push(pose);
                    lines.push(line);
                }
                Err(more) if faults.len() < MOST_TOLD => {
                    let is_stuck = more.iter().any(|fault| fault.line.is_none());
                    faults.extend(more);
                    if is_stuck {
                        break;
                    }
                }
                Err(_) if untold < chunk => untold += 1,
                Err(_) => break,
            }
        }
        if faults.is_empty() {
            return Ok((poses, lines));
        }
        if untold > 0 {
            faults.extend(fault(Some(&self.file), None, format!("{untold} further bad rows")));
        }
        Err(faults)
    }

    fn pose(&self, record: &csv::StringRecord) -> Result<(Vec<f64>, usize), Vec<Fault>> {
        let line = record.position().map_or(0, |at| at.line() as usize);
        let mut pose = Vec::with_capacity(self.columns.len());
        for column in &self.columns {
            let text = record.get(column.place).unwrap_or_default();
            match text.parse::<f64>() {
                Ok(value) if value.is_finite() => pose.push((column.convert)(value)),
                Ok(_) | Err(_) => {
                    let what = format!("{} is '{text}', must be a finite number", column.name);
                    return Err(fault(Some(&self.file), Some(line), what));
                }
            }
        }
        Ok((pose, line))
    }
}

/// Columns that maps and tables of measured modes have beside the pose.
fn is_beside_the_pose(name: &str) -> bool {
    let numbered = |rest: &str| rest.starts_with(|c: char| c.is_ascii_digit());
    ["id", "beta1_rad", "beta2_rad", "energy_drift"].contains(&name)
        || name.strip_prefix('f').is_some_and(numbered)
}

fn told(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("row has {len} fields, must have {expected_len} as the header")
        }
        csv::ErrorKind::Utf8 { .. } => "row is not UTF-8".to_owned(),
        _ => format!("cannot be read: {error}"),
    }
}
