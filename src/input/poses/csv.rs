//! Poses as CSV: one column a joint, found by its title.

use std::path::Path;

use super::{DecodedPoses, MAX_ERRORS};
use crate::formats::table::{MAX_ROW_BYTES, beyond, cells_of, number};
use crate::model::{JointKind, Robot};
use crate::notes::{Code, Note, Place};
use crate::units::{m_from_mm, rad_from_deg};
use crate::wording::nearest;

type ToSi = fn(f64) -> f64;

/// Where the value of one joint stands.
#[derive(Debug, Clone, Copy)]
struct Column {
    index: usize,
    to_si: ToSi,
}

/// Which columns of a table hold the joints.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    header: Vec<String>,
    /// One a joint, base to tip.
    joints: Vec<Column>,
    /// The joint that each column holds, up to the last that holds one.
    holds: Vec<Option<usize>>,
}

impl Columns {
    /// For each moving joint one column `<joint name>_rad` or `_deg` (a prismatic joint: `_m` or
    /// `_mm`; `_rad` is read as m), in any order; other columns are passed over.
    pub(super) fn find(
        file: &Path,
        line: Option<usize>,
        header: &[String],
        robot: &Robot,
    ) -> Result<Self, Vec<Note>> {
        let mut faults = Vec::new();
        let mut fault = |what: String| {
            faults.push(Note::error(Code::MissingKey, Place::line(file, line), what));
        };
        let mut joints = Vec::new();
        for joint in robot.joints() {
            let units: &[(&str, ToSi)] = match joint.kind {
                // Tables made for any robot call every SI column `_rad`.
                JointKind::Prismatic => &[
                    ("m", std::convert::identity),
                    ("mm", m_from_mm),
                    ("rad", std::convert::identity),
                ],
                _ => &[("rad", std::convert::identity), ("deg", rad_from_deg)],
            };
            let found: Vec<Column> = units
                .iter()
                .flat_map(|&(unit, to_si)| {
                    let wanted = format!("{}_{unit}", joint.name);
                    let matching =
                        header.iter().enumerate().filter(move |(_, title)| **title == wanted);
                    matching.map(move |(index, _)| Column { index, to_si }).collect::<Vec<_>>()
                })
                .collect();
            match found.as_slice() {
                [column] => joints.push(*column),
                [] => {
                    let wanted = format!("{}_{}", joint.name, units[0].0);
                    // The column of another joint is not meant.
                    let of_another = |title: &str| {
                        robot.joints().iter().any(|other| {
                            let unit = title.strip_prefix(other.name.as_str());
                            matches!(unit, Some("_rad" | "_deg" | "_m" | "_mm"))
                        })
                    };
                    let free = header.iter().map(String::as_str).filter(|title| !of_another(title));
                    let hint = nearest(&wanted, free).map_or_else(String::new, |near| {
                        format!("; did you mean '{near}' for it?")
                    });
                    fault(format!("no column '{wanted}' or '{}_{}'{hint}", joint.name, units[1].0));
                }
                _ => fault(format!(
                    "joint '{}' has {} columns, must have one",
                    joint.name,
                    found.len()
                )),
            }
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let last = joints.iter().map(|column| column.index + 1).max().unwrap_or(0);
        let mut holds = vec![None; last];
        for (joint, column) in joints.iter().enumerate() {
            holds[column.index] = Some(joint);
        }
        Ok(Self { header: header.to_vec(), joints, holds })
    }

    /// Column and way to rad or m of each joint, base to tip.
    #[cfg(feature = "arrow")]
    pub(super) fn places(&self) -> impl Iterator<Item = (usize, ToSi)> {
        self.joints.iter().map(|column| (column.index, column.to_si))
    }

    /// Takes whole lines apart.
    pub(super) fn decode(&self, bytes: &[u8], out: &mut DecodedPoses) {
        // A piece of plain ASCII without quotes is read in place; whatever that cannot make sense
        // of, and every other piece, is read cell by cell.
        let plain = match std::str::from_utf8(bytes) {
            Ok(text) if text.is_ascii() && memchr::memchr(b'"', bytes).is_none() => Some(text),
            _ => None,
        };
        let mut cells = Vec::new();
        let mut start = 0;
        for end in memchr::memchr_iter(b'\n', bytes).chain([bytes.len()]) {
            if start == bytes.len() {
                break;
            }
            let is_read = plain.is_some_and(|text| self.quickly(&text[start..end], out));
            if !is_read {
                self.cell_by_cell(&bytes[start..end], &mut cells, out);
            }
            out.places += 1;
            if out.faults.len() >= MAX_ERRORS {
                break;
            }
            start = (end + 1).min(bytes.len());
        }
    }

    /// Reads a row of plain numbers; `false` and nothing read if it is anything else.
    fn quickly(&self, row: &str, out: &mut DecodedPoses) -> bool {
        if row.len() > MAX_ROW_BYTES || row.trim_ascii_start().starts_with('#') {
            return false;
        }
        if memchr::memchr_iter(b',', row.as_bytes()).count() >= self.header.len() {
            return false;
        }
        let before = out.values.len();
        out.values.resize(before + self.joints.len(), 0.0);
        let mut cells = row.split(',');
        for &joint in &self.holds {
            let Some(cell) = cells.next() else {
                out.values.truncate(before);
                return false;
            };
            let Some(joint) = joint else { continue };
            match cell.trim_ascii().parse::<f64>() {
                Ok(value) if value.is_finite() => {
                    out.values[before + joint] = (self.joints[joint].to_si)(value);
                }
                _ => {
                    out.values.truncate(before);
                    return false;
                }
            }
        }
        // A blank line is no pose of a robot without joints.
        if self.holds.is_empty() && row.trim_ascii().is_empty() {
            return false;
        }
        out.push_place();
        true
    }

    fn cell_by_cell(&self, line: &[u8], cells: &mut Vec<String>, out: &mut DecodedPoses) {
        match cells_of(line, cells) {
            Ok(true) => {}
            Ok(false) => return,
            Err(what) => return out.faults.push((out.places, what.to_owned())),
        }
        if let Some(what) = beyond(&self.header, cells) {
            return out.faults.push((out.places, what));
        }
        let before = out.values.len();
        for column in &self.joints {
            match number(&self.header, cells, column.index) {
                Ok(value) => out.values.push((column.to_si)(value)),
                Err(what) => {
                    out.values.truncate(before);
                    return out.faults.push((out.places, what));
                }
            }
        }
        out.push_place();
    }
}
