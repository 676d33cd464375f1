//! A load test: known moments and the angles by which they turn a joint.

use std::path::Path;

use super::Reading;
use super::files::MAX_FILE_BYTES;
use crate::formats::table::Table;
use crate::formats::text::read_text;
use crate::notes::{Code, Note, Notes, Place};
use crate::units::{rad_from_deg, rad_from_mrad};

/// One loading.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadTestRow {
    /// The joint that was loaded, where the table has a column `joint`.
    pub joint: Option<String>,
    /// Moment about the joint's axis, N·m.
    pub moment_nm: f64,
    /// Angle by which the joint gave way, rad.
    pub angle_rad: f64,
    /// Line of the table, counted from 1.
    pub line: usize,
}

type ToSi = fn(f64) -> f64;

const ANGLES: [(&str, ToSi); 3] = [
    ("angle_rad", std::convert::identity),
    ("angle_mrad", rad_from_mrad),
    ("angle_deg", rad_from_deg),
];

/// Reads a table of load tests: CSV with a header, the columns `moment_nm`, one of `angle_rad`,
/// `angle_mrad` and `angle_deg`, and optionally `joint`. Other columns are passed over, and so are
/// lines that begin with `#`.
///
/// # Errors
/// Every fault of the table, each with its line; a table without rows.
pub fn read_load_test(path: &Path, reading: &mut Reading) -> Result<Vec<LoadTestRow>, Vec<Note>> {
    reading.files.push(path.to_owned());
    let text = read_text(path, MAX_FILE_BYTES)?;
    let mut notes = Notes::about(Place::file(path));
    let mut table = Table::open(path, text.as_bytes())?;
    let Some(columns) = Columns::of(&table, &mut notes) else { return Err(notes.finish().0) };
    let (mut rows, mut cells) = (Vec::new(), Vec::new());
    loop {
        match table.row(&mut cells) {
            Ok(true) => rows.extend(columns.row(&table, &cells, &mut notes)),
            Ok(false) => break,
            Err(note) => {
                notes.push(note);
                break;
            }
        }
    }
    if rows.is_empty() && notes.errors() == 0 {
        notes.error(
            Code::TooLittleData,
            None,
            "has no rows, must have at least one below the header",
        );
    }
    let errors = reading.settle(notes);
    if errors.is_empty() { Ok(rows) } else { Err(errors) }
}

struct Columns {
    moment: usize,
    angle: usize,
    to_rad: ToSi,
    joint: Option<usize>,
}

impl Columns {
    fn of(table: &Table<&[u8]>, notes: &mut Notes) -> Option<Self> {
        let (header, line) = (table.header(), table.line());
        let find = |name: &str| header.iter().position(|title| title == name);
        let moment = find("moment_nm");
        if moment.is_none() {
            notes.error(Code::MissingKey, line, "no column 'moment_nm'");
        }
        let angles: Vec<(usize, ToSi)> =
            ANGLES.iter().filter_map(|&(name, to_rad)| Some((find(name)?, to_rad))).collect();
        match angles.as_slice() {
            &[(angle, to_rad)] => {
                Some(Self { moment: moment?, angle, to_rad, joint: find("joint") })
            }
            [] => {
                notes.error(
                    Code::MissingKey,
                    line,
                    "no column 'angle_rad', 'angle_mrad' or 'angle_deg'",
                );
                None
            }
            _ => {
                let what = "has several columns of angles, must have one of angle_rad, angle_mrad, \
                    angle_deg";
                notes.error(Code::Conflict, line, what);
                None
            }
        }
    }

    fn row(
        &self,
        table: &Table<&[u8]>,
        cells: &[String],
        notes: &mut Notes,
    ) -> Option<LoadTestRow> {
        let line = table.line();
        let mut number = |column| match table.number(cells, column) {
            Ok(value) => Some(value),
            Err(fault) => {
                notes.push(fault);
                None
            }
        };
        let (moment_nm, angle) = (number(self.moment), number(self.angle));
        let joint = match self.joint.map(|column| cells.get(column).map_or("", String::as_str)) {
            Some("") => {
                notes.error(Code::Value, line, "joint is empty, must be the name of a joint");
                return None;
            }
            joint => joint.map(str::to_owned),
        };
        Some(LoadTestRow { joint, moment_nm: moment_nm?, angle_rad: (self.to_rad)(angle?), line })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<LoadTestRow>, Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).unwrap();
        let prefix = format!("{}/", folder.path().display());
        read_load_test(&path, &mut Reading::default())
            .map_err(|notes| notes.iter().map(|f| f.to_string().replace(&prefix, "")).collect())
    }

    #[test]
    fn rows_arrive_in_si_with_their_lines() {
        let rows =
            read("# rig\njoint,moment_nm,angle_mrad\njoint_1,555,1\n\njoint_2,-138,-1\n").unwrap();
        assert_eq!(rows[0].joint.as_deref(), Some("joint_1"));
        assert_eq!((rows[0].moment_nm, rows[0].line), (555.0, 3));
        assert!((rows[1].angle_rad + 1e-3).abs() < 1e-18);
        assert_eq!(rows[1].line, 5);
        let rows = read("angle_deg,moment_nm\n180,1\n").unwrap();
        assert!((rows[0].angle_rad - std::f64::consts::PI).abs() < 1e-15);
        assert_eq!(rows[0].joint, None);
    }

    #[test]
    fn every_fault_is_told() {
        for (text, expected) in [
            (
                "moment,angle_rad,angle_deg\n",
                vec!["t.csv:1: no column 'moment_nm'", "t.csv:1: has several"],
            ),
            ("moment_nm\n1\n", vec!["t.csv:1: no column 'angle_rad'"]),
            ("moment_nm,angle_rad\n", vec!["t.csv: has no rows"]),
            (
                "moment_nm,angle_rad,joint\n1,x,a\n2,inf,\n",
                vec![
                    "t.csv:2: angle_rad is 'x'",
                    "t.csv:3: angle_rad is 'inf'",
                    "t.csv:3: joint is empty",
                ],
            ),
        ] {
            let notes = read(text).unwrap_err();
            assert_eq!(notes.len(), expected.len(), "{notes:?}");
            for (fault, expected) in notes.iter().zip(expected) {
                assert!(fault.starts_with(expected), "{fault}");
            }
        }
    }
}
