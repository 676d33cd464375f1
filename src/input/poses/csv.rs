//! Poses as CSV: one column a joint, found by its title.

use std::path::Path;

use super::{DecodedPoses, MAX_ERRORS};
use crate::formats::table::{MAX_ROW_BYTES, beyond, cells_of, number};
#[cfg(feature = "arrow")]
use crate::input::joint_columns::ToSi;
use crate::input::joint_columns::{Column, joint_columns};
use crate::model::Robot;
use crate::notes::{Note, Place};

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
    /// Those of [`joint_columns`]; other columns are passed over.
    pub(super) fn find(
        file: &Path,
        line: Option<usize>,
        header: &[String],
        robot: &Robot,
    ) -> Result<Self, Vec<Note>> {
        let fault = |(code, what)| Note::error(code, Place::line(file, line), what);
        let joints = joint_columns(header, robot)
            .map_err(|faults| faults.into_iter().map(fault).collect::<Vec<_>>())?;
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
