//! A load test: known moments and the angles by which they turn a joint, as they were computed or
//! as a workshop reads them: masses on a lever and a dial gauge.

use std::path::Path;

use super::Reading;
use super::files::MAX_FILE_BYTES;
use crate::formats::table::Table;
use crate::formats::text::read_text;
use crate::notes::{Code, Note, Notes, Place};
use crate::units::{STANDARD_GRAVITY_M_PER_S2, m_from_mm, rad_from_deg, rad_from_mrad};

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

/// Columns of angles.
const ANGLES: [(&str, ToSi); 3] = [
    ("angle_rad", std::convert::identity),
    ("angle_mrad", rad_from_mrad),
    ("angle_deg", rad_from_deg),
];

/// Columns of forces at the end of a lever, in N.
const FORCES: [(&str, ToSi); 2] =
    [("force_n", std::convert::identity), ("mass_kg", |kg| kg * STANDARD_GRAVITY_M_PER_S2)];

const LEVER: &str = "lever_mm";
const GAUGE: &str = "gauge_mm";
const GAUGE_LEVER: &str = "gauge_lever_mm";

/// A gauge that moves by more of its lever shows no small angle: the lever of a hanging mass
/// shortens by half the square of it, 0.5 %.
const MAX_GAUGE_SHARE: f64 = 0.1;

/// Reads a table of load tests: CSV with a header; for the load `moment_nm`, or `lever_mm` with
/// one of `mass_kg` and `force_n`; for what gave way one of `angle_rad`, `angle_mrad` and
/// `angle_deg`, or `gauge_mm` with `gauge_lever_mm`; and optionally `joint`. Levers are measured
/// from the joint's axis, square to the force and to the stem of the gauge. Other columns are
/// passed over, and so are lines that begin with `#`.
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

/// How a table states the moment.
enum Load {
    Moment(usize),
    /// A force in N by `to_n`, and its lever.
    OnLever {
        force: usize,
        to_n: ToSi,
        lever: usize,
    },
}

/// How a table states the angle.
enum Deflection {
    Angle {
        angle: usize,
        to_rad: ToSi,
    },
    /// A dial gauge, and its lever.
    Gauge {
        gauge: usize,
        lever: usize,
    },
}

struct Columns {
    load: Load,
    deflection: Deflection,
    joint: Option<usize>,
}

impl Columns {
    fn of(table: &Table<&[u8]>, notes: &mut Notes) -> Option<Self> {
        let (header, line) = (table.header(), table.line());
        let find = |name: &str| header.iter().position(|title| title == name);
        let load = load(&find, line, notes);
        let deflection = deflection(&find, line, notes);
        Some(Self { load: load?, deflection: deflection?, joint: find("joint") })
    }

    fn row(
        &self,
        table: &Table<&[u8]>,
        cells: &[String],
        notes: &mut Notes,
    ) -> Option<LoadTestRow> {
        let moment_nm = self.moment_nm(table, cells, notes);
        let angle_rad = self.angle_rad(table, cells, notes);
        let line = table.line();
        let joint = match self.joint.map(|column| cells.get(column).map_or("", String::as_str)) {
            Some("") => {
                notes.error(Code::Value, line, "joint is empty, must be the name of a joint");
                return None;
            }
            joint => joint.map(str::to_owned),
        };
        Some(LoadTestRow { joint, moment_nm: moment_nm?, angle_rad: angle_rad?, line })
    }

    fn moment_nm(&self, table: &Table<&[u8]>, cells: &[String], notes: &mut Notes) -> Option<f64> {
        match self.load {
            Load::Moment(moment) => number(table, cells, moment, notes),
            Load::OnLever { force, to_n, lever } => {
                let given = number(table, cells, force, notes);
                let lever = positive(table, cells, lever, notes);
                let is_mass = table.header()[force] == "mass_kg";
                if let Some(kg) = given.filter(|kg| is_mass && *kg < 0.0) {
                    let what = format!(
                        "mass_kg is {kg}, must be 0 or more; a load the other way is a negative \
                         force_n"
                    );
                    notes.error(Code::Value, table.line(), what);
                    return None;
                }
                Some(to_n(given?) * m_from_mm(lever?))
            }
        }
    }

    /// The face that the stem touches tilts with the joint: tan of the angle is reading over lever.
    fn angle_rad(&self, table: &Table<&[u8]>, cells: &[String], notes: &mut Notes) -> Option<f64> {
        match self.deflection {
            Deflection::Angle { angle, to_rad } => {
                Some(to_rad(number(table, cells, angle, notes)?))
            }
            Deflection::Gauge { gauge, lever } => {
                let reading = number(table, cells, gauge, notes);
                let lever = positive(table, cells, lever, notes);
                let (reading, lever) = (reading?, lever?);
                if reading.abs() > MAX_GAUGE_SHARE * lever {
                    let what = format!(
                        "gauge_mm is {reading} at a lever of {lever} mm, must be at most a tenth \
                         of it: a small angle"
                    );
                    notes.error(Code::Value, table.line(), what);
                    return None;
                }
                Some((reading / lever).atan())
            }
        }
    }
}

fn load(find: &dyn Fn(&str) -> Option<usize>, line: usize, notes: &mut Notes) -> Option<Load> {
    let moment = find("moment_nm");
    let forces: Vec<(usize, ToSi)> =
        FORCES.iter().filter_map(|&(name, to_n)| Some((find(name)?, to_n))).collect();
    match (moment, forces.as_slice(), find(LEVER)) {
        (Some(moment), [], None) => Some(Load::Moment(moment)),
        (None, &[(force, to_n)], Some(lever)) => Some(Load::OnLever { force, to_n, lever }),
        (None, [_], None) => {
            notes.error(Code::MissingKey, line, "no column 'lever_mm' beside the load");
            None
        }
        (None, [], _) => {
            let what = "no column 'moment_nm', and neither 'mass_kg' nor 'force_n' with 'lever_mm'";
            notes.error(Code::MissingKey, line, what);
            None
        }
        _ => {
            let what = "has several loads, must have moment_nm alone, or lever_mm with one of \
                        mass_kg, force_n";
            notes.error(Code::Conflict, line, what);
            None
        }
    }
}

fn deflection(
    find: &dyn Fn(&str) -> Option<usize>,
    line: usize,
    notes: &mut Notes,
) -> Option<Deflection> {
    let angles: Vec<(usize, ToSi)> =
        ANGLES.iter().filter_map(|&(name, to_rad)| Some((find(name)?, to_rad))).collect();
    match (angles.as_slice(), find(GAUGE), find(GAUGE_LEVER)) {
        (&[(angle, to_rad)], None, None) => Some(Deflection::Angle { angle, to_rad }),
        ([], Some(gauge), Some(lever)) => Some(Deflection::Gauge { gauge, lever }),
        ([], Some(_), None) => {
            let what = "no column 'gauge_lever_mm', the distance of the gauge from the axis";
            notes.error(Code::MissingKey, line, what);
            None
        }
        ([], None, _) => {
            let what = "no column 'angle_rad', 'angle_mrad' or 'angle_deg', and no 'gauge_mm' \
                        with 'gauge_lever_mm'";
            notes.error(Code::MissingKey, line, what);
            None
        }
        _ => {
            let what = "has several columns of angles, must have one of angle_rad, angle_mrad, \
                        angle_deg, or gauge_mm with gauge_lever_mm";
            notes.error(Code::Conflict, line, what);
            None
        }
    }
}

fn number(table: &Table<&[u8]>, cells: &[String], column: usize, notes: &mut Notes) -> Option<f64> {
    table.number(cells, column).map_err(|fault| notes.push(fault)).ok()
}

/// A lever.
fn positive(
    table: &Table<&[u8]>,
    cells: &[String],
    column: usize,
    notes: &mut Notes,
) -> Option<f64> {
    let value = number(table, cells, column, notes)?;
    if value > 0.0 {
        return Some(value);
    }
    let what = format!("{} is {value}, must be positive", table.header()[column]);
    notes.error(Code::Value, table.line(), what);
    None
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

    /// By hand: 10 kg on 0.5 m are 49.03325 N·m; 0.3 mm at 600 mm are 0.5 mrad, less a third of its
    /// cube, 4.2e-11.
    #[test]
    fn a_workshop_s_readings_are_moments_and_angles() {
        let head = "mass_kg,lever_mm,gauge_mm,gauge_lever_mm";
        let rows = read(&format!("{head}\n0,500,0,600\n10,500,0.3,600\n")).unwrap();
        assert_eq!((rows[0].moment_nm, rows[0].angle_rad), (0.0, 0.0));
        assert!((rows[1].moment_nm - 49.03325).abs() < 1e-12, "{}", rows[1].moment_nm);
        assert!((rows[1].angle_rad - (5e-4 - 4.16667e-11)).abs() < 1e-15, "{}", rows[1].angle_rad);
        let rows = read("force_n,lever_mm,angle_mrad\n-20,250,-1\n").unwrap();
        assert!((rows[0].moment_nm + 5.0).abs() < 1e-12 && rows[0].angle_rad < 0.0);
    }

    #[test]
    fn every_fault_is_told() {
        for (text, expected) in [
            (
                "moment,angle_rad,angle_deg\n",
                vec!["t.csv:1: no column 'moment_nm'", "t.csv:1: has several columns of angles"],
            ),
            (
                "mass_kg,gauge_mm\n1,1\n",
                vec!["t.csv:1: no column 'lever_mm'", "t.csv:1: no column 'gauge_lever_mm'"],
            ),
            (
                "mass_kg,force_n,lever_mm,gauge_mm,gauge_lever_mm,angle_deg\n",
                vec!["t.csv:1: has several loads", "t.csv:1: has several columns of angles"],
            ),
            ("moment_nm,lever_mm,angle_deg\n1,1,1\n", vec!["t.csv:1: has several loads"]),
            (
                "mass_kg,lever_mm,gauge_mm,gauge_lever_mm\n-1,9,0,9\n1,0,0,-9\n1,9,1,9\n",
                vec![
                    "t.csv:2: mass_kg is -1, must be 0 or more",
                    "t.csv:3: lever_mm is 0, must be positive",
                    "t.csv:3: gauge_lever_mm is -9, must be positive",
                    "t.csv:4: gauge_mm is 1 at a lever of 9 mm, must be at most a tenth",
                ],
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
