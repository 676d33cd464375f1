//! measured.csv → a table of modes.

use std::path::Path;

use super::Reading;
use super::files::MAX_FILE_BYTES;
use super::joint_columns::{self, columns_of, is_of_joint, joint_columns, without_unit};
use crate::formats::table::Table;
use crate::formats::text::read_text;
use crate::identify::pose::{JointColumn, Pose};
use crate::identify::{MeasuredRotation, ModeRow, ModeTable, RotationAxis};
use crate::model::{AngleForm, MovingJoint, Robot};
use crate::notes::{Code, Note, Notes, Part, Place};
use crate::wording::{hint, nearest};

/// More columns of frequencies than this are no table of modes.
const MAX_MODES: usize = 64;

/// More rows than this are not from a hammer.
const MAX_ROWS: usize = 10_000;

/// Nothing on a robot rings higher, Hz.
const MAX_HZ: f64 = 1e6;

/// Reads a table of identified modes: the pose as `beta2_rad` (with `beta1_rad`, if known) or one
/// column `<joint>_rad` or `_deg` per moving joint (`_m` or `_mm` where it slides), `f1_hz`,
/// `f2_hz` … ascending with blanks where a mode was not measured, `mass_<link>_kg` for a mass added
/// at a link's centre of mass, `phi1_<link>` … for how links turn in a mode, and the covariates.
/// `reading` is warned of columns that are not used.
///
/// # Errors
/// Every fault of the table, each with its line.
pub fn read_measured(
    path: &Path,
    robot: &Robot,
    reading: &mut Reading,
) -> Result<ModeTable, Vec<Note>> {
    reading.files.push(path.to_owned());
    let text = read_text(path, MAX_FILE_BYTES)?;
    let mut notes = Notes::about(Place::file(path));
    let mut table = Table::open(path, text.as_bytes())?;
    let Some(columns) = Columns::of(table.header(), table.line(), robot, &mut notes) else {
        return Err(reading.settle(notes));
    };
    let header_line = table.line();
    for what in &columns.unknown {
        notes.warning(Code::Unused, header_line, what);
    }
    let unstated = columns.pose.unstated(robot);
    warn_of_unstated(&unstated, robot, header_line, &mut notes);
    let (mut rows, mut cells) = (Vec::new(), Vec::new());
    loop {
        match table.row(&mut cells) {
            Ok(true) if rows.len() == MAX_ROWS => {
                let what = format!("has more than {MAX_ROWS} rows, the limit");
                notes.push(table.error(Code::TooLong, what));
                break;
            }
            Ok(true) => rows.push(columns.row(&table, &cells, robot, &mut notes)),
            Ok(false) => break,
            Err(note) => {
                notes.push(note);
                break;
            }
        }
    }
    let table = ModeTable { rows, modes: columns.modes.len(), unstated };
    let table = with_rows(table, &mut notes);
    let errors = reading.settle(notes);
    table.ok_or(errors)
}

/// A session's table of modes at a robot's joints, as reading it from a file would give it; with
/// warnings.
///
/// # Errors
/// Joints whose names or number are not the robot's, poses outside of its limits, no modes.
pub fn mode_table_on(
    robot: &Robot,
    named: Option<&[JointColumn]>,
    table: &ModeTable<Pose>,
) -> Result<(ModeTable, Vec<Note>), Vec<Note>> {
    let mut notes = Notes::default();
    let placed = placed(robot, named, table, &mut notes);
    let (errors, warnings) = notes.finish();
    placed.map(|table| (table, warnings)).ok_or(errors)
}

fn placed(
    robot: &Robot,
    named: Option<&[JointColumn]>,
    table: &ModeTable<Pose>,
    notes: &mut Notes,
) -> Option<ModeTable> {
    let joints = table.rows.iter().find_map(|row| match &row.pose {
        Pose::Joints(joints) => Some(JointColumn::list(named, joints.len())),
        Pose::Angles { .. } => None,
    });
    let has_beta1 =
        table.rows.iter().any(|row| matches!(row.pose, Pose::Angles { beta1: Some(_), .. }));
    let titles: Vec<String> = match &joints {
        Some(columns) => columns.iter().map(|column| column.title.clone()).collect(),
        None if has_beta1 => vec!["beta2_rad".to_owned(), "beta1_rad".to_owned()],
        None => vec!["beta2_rad".to_owned()],
    };
    let columns = pose_columns(&titles, None, robot, notes)?;
    let mut rows = Vec::new();
    for (index, row) in table.rows.iter().enumerate() {
        let mut cell = |column: usize| match (&row.pose, &joints) {
            (Pose::Angles { beta1, beta2 }, _) => [Some(*beta2), *beta1][column],
            (Pose::Joints(joints), Some(columns)) => {
                joints.get(column).map(|&si| columns[column].in_unit(si))
            }
            (Pose::Joints(_), None) => None,
        };
        let joints = columns.joints(&mut cell, robot);
        for violation in robot.limit_violations(&joints) {
            let place = Place::part(Part::Pose(index));
            notes.push(Note::error(Code::JointLimit, place, violation.to_string()));
        }
        rows.push(row.clone().at(joints));
    }
    let unstated = columns.unstated(robot);
    warn_of_unstated(&unstated, robot, None, notes);
    with_rows(ModeTable { rows, modes: table.modes, unstated }, notes)
}

/// The table, if it has a frequency and nothing is wrong with it.
fn with_rows(table: ModeTable, notes: &mut Notes) -> Option<ModeTable> {
    if notes.errors() > 0 {
        return None;
    }
    let what = match table.count() {
        0 if table.rows.is_empty() => "has no rows, must have at least one below the header",
        0 => "has no frequency in any row",
        _ => return Some(table),
    };
    notes.error(Code::TooLittleData, None, what);
    None
}

/// Where a pose stands.
enum PoseColumns {
    /// One column a joint.
    Joints(Vec<joint_columns::Column>),
    /// Angles of the two-link model.
    Angles(Vec<AngleColumn>),
}

/// The column of an angle of the two-link model.
struct AngleColumn {
    index: usize,
    form: AngleForm,
    /// The joint that is put where the angle says, and its factor.
    joint: usize,
    scale: f64,
}

struct Columns {
    pose: PoseColumns,
    modes: Vec<usize>,
    deviations: Vec<Option<usize>>,
    damping: Vec<Option<usize>>,
    temperature: Option<usize>,
    amplitude: Option<usize>,
    payload: Option<usize>,
    /// Links with the columns of masses added to them.
    added: Vec<(String, usize)>,
    rotations: Vec<RotationColumn>,
    sample_rate: Option<usize>,
    id: Option<usize>,
    unknown: Vec<String>,
}

impl Columns {
    fn of(header: &[String], line: usize, robot: &Robot, notes: &mut Notes) -> Option<Self> {
        let find = |name: &str| header.iter().position(|title| title == name);
        for (i, title) in header.iter().enumerate() {
            if !title.is_empty() && header[..i].contains(title) {
                notes.error(Code::Conflict, line, format!("column '{title}' is there twice"));
            }
        }
        let pose = pose_columns(header, line, robot, notes);
        let modes: Vec<usize> =
            (1..=MAX_MODES).map_while(|mode| find(&format!("f{mode}_hz"))).collect();
        if modes.is_empty() {
            // The column of another mode is not meant.
            let is_mode = |title: &&str| {
                let number = title.strip_prefix('f').and_then(|rest| rest.strip_suffix("_hz"));
                number.is_some_and(|number| number.parse::<usize>().is_ok())
            };
            let others = header.iter().map(String::as_str).filter(|title| !is_mode(title));
            let hint = nearest("f1_hz", others)
                .map_or_else(String::new, |near| format!("; did you mean '{near}' for it?"));
            notes.error(Code::MissingKey, line, format!("no column 'f1_hz'{hint}"));
        }
        let later = (modes.len() + 2..=MAX_MODES).find(|m| find(&format!("f{m}_hz")).is_some());
        if let (false, Some(later)) = (modes.is_empty(), later) {
            let missing = modes.len() + 1;
            notes.error(
                Code::MissingKey,
                line,
                format!("no column 'f{missing}_hz' before 'f{later}_hz'"),
            );
        }
        let of_modes = |title: &dyn Fn(usize) -> String| -> Vec<Option<usize>> {
            (1..=modes.len()).map(|m| find(&title(m))).collect()
        };
        let deviations = of_modes(&|m| format!("f{m}_std_hz"));
        let damping = of_modes(&|m| format!("zeta{m}"));
        let added = added_columns(header, line, robot, notes);
        let rotations = rotation_columns(header, line, modes.len(), robot, notes);
        let known = |title: &str| {
            [
                "temperature_c",
                "amplitude_nm",
                "payload_kg",
                "sample_rate_hz",
                "id",
                "beta1_rad",
                "beta2_rad",
                "",
            ]
            .contains(&title)
                || is_of_joint(title, robot)
                || added.iter().any(|(_, index)| header[*index] == title)
                || RotationColumn::mode_of(title).is_some()
                || numbered(title, "f", "_hz")
                || numbered(title, "f", "_std_hz")
                || numbered(title, "zeta", "")
        };
        // Beside an angle of the two-link model, which stands for all joints.
        if matches!(pose, Some(PoseColumns::Angles(_))) {
            for what in robot.joints().iter().filter_map(|joint| without_unit(header, joint)) {
                notes.error(Code::MissingKey, line, what);
            }
        }
        let names = ["temperature_c", "amplitude_nm", "payload_kg", "sample_rate_hz", "id"];
        let unknown = header
            .iter()
            .filter(|title| !known(title))
            .map(|title| format!("column '{title}' is not used{}", hint(title, names)))
            .collect();
        (notes.errors() == 0).then_some(())?;
        Some(Self {
            pose: pose?,
            modes,
            deviations,
            damping,
            temperature: find("temperature_c"),
            amplitude: find("amplitude_nm"),
            payload: find("payload_kg"),
            added,
            rotations,
            sample_rate: find("sample_rate_hz"),
            id: find("id"),
            unknown,
        })
    }

    fn row(
        &self,
        table: &Table<&[u8]>,
        cells: &[String],
        robot: &Robot,
        notes: &mut Notes,
    ) -> ModeRow {
        let line = table.line();
        let before = notes.errors();
        let mut row = ModeRow::default();
        if cells.len() != table.header().len() {
            let what = format!("has {} cells, must have {}", cells.len(), table.header().len());
            notes.error(Code::Value, line, what);
            return row;
        }
        let mut number = |column: usize| match table.number(cells, column) {
            Ok(value) => Some(value),
            Err(fault) => {
                notes.push(fault);
                None
            }
        };
        row.pose = self.pose.joints(&mut number, robot);
        let mut optional = |column: Option<usize>| {
            let column = column.filter(|&c| cells.get(c).is_some_and(|cell| !cell.is_empty()))?;
            number(column)
        };
        row.frequencies_hz = self.modes.iter().map(|&column| optional(Some(column))).collect();
        row.deviations_hz = self.deviations.iter().map(|&column| optional(column)).collect();
        row.damping_ratios = self.damping.iter().map(|&column| optional(column)).collect();
        row.temperature_c = optional(self.temperature);
        row.amplitude_nm = optional(self.amplitude);
        row.payload_kg = optional(self.payload);
        row.added_kg = self
            .added
            .iter()
            .filter_map(|(link, column)| Some((link.clone(), optional(Some(*column))?)))
            .collect();
        row.rotations = vec![Vec::new(); self.modes.len()];
        for column in &self.rotations {
            let Some(value) = optional(Some(column.index)) else { continue };
            row.rotations[column.mode].push(MeasuredRotation {
                link: column.link.clone(),
                about: column.about,
                value,
                std: optional(column.std),
            });
        }
        row.sample_rate_hz = optional(self.sample_rate);
        row.id = self.id.and_then(|column| cells.get(column)).filter(|id| !id.is_empty()).cloned();
        if notes.errors() == before {
            check(&row, (table.header(), line), self, robot, notes);
        }
        row
    }
}

impl PoseColumns {
    /// Positions of all joints, from the cells of one row.
    fn joints(&self, number: &mut impl FnMut(usize) -> Option<f64>, robot: &Robot) -> Vec<f64> {
        match self {
            Self::Joints(columns) => {
                columns.iter().map(|at| number(at.index).map_or(0.0, at.to_si)).collect()
            }
            Self::Angles(angles) => {
                let mut q: Vec<f64> = robot.joints().iter().map(at_rest).collect();
                for column in angles {
                    if let Some(angle) = number(column.index) {
                        q[column.joint] += (angle - column.form.at(&q)) / column.scale;
                    }
                }
                q
            }
        }
    }

    /// Joints that no column determines.
    fn unstated(&self, robot: &Robot) -> Vec<String> {
        let Self::Angles(angles) = self else { return Vec::new() };
        let is_stated = |joint: &usize| angles.iter().any(|column| column.joint == *joint);
        let unstated = (0..robot.joints().len()).filter(|joint| !is_stated(joint));
        unstated.map(|joint| robot.joints()[joint].name.clone()).collect()
    }
}

fn warn_of_unstated(
    unstated: &[String],
    robot: &Robot,
    line: impl Into<Option<usize>>,
    notes: &mut Notes,
) {
    let [first, others @ ..] = unstated else { return };
    let beta1 = robot.beta1().and_then(|form| form.terms().next());
    let beta1 = beta1.map(|(joint, _)| &robot.joints()[joint].name);
    let remedy = if others.is_empty() && beta1 == Some(first) {
        "give beta1_rad, too".to_owned()
    } else {
        format!("give the positions of all joints, such as '{first}_deg', instead of beta2_rad")
    };
    let (verb, are) = if others.is_empty() { ("is", "it is") } else { ("are", "they are") };
    let what = format!(
        "{} {verb} not stated: {are} taken as 0, or the nearest that the limits allow; {remedy}",
        unstated.join(", ")
    );
    notes.warning(Code::UnstatedJoint, line, what);
}

/// Where a joint stands that a table does not mention: at zero, or as near to it as it can, rad or
/// m.
fn at_rest(joint: &MovingJoint) -> f64 {
    joint.limit.map_or(0.0, |[low, high]| 0.0_f64.max(low).min(high))
}

/// What numbers that can be read may still get wrong.
fn check(
    row: &ModeRow,
    (header, line): (&[String], usize),
    columns: &Columns,
    robot: &Robot,
    notes: &mut Notes,
) {
    let title = |column: usize| header.get(column).map_or("", String::as_str);
    let mut last: Option<(usize, f64)> = None;
    for (&column, frequency) in columns.modes.iter().zip(&row.frequencies_hz) {
        let Some(f) = *frequency else { continue };
        if !(f > 0.0 && f < MAX_HZ) {
            let what = format!("{} is {f}, must be positive and below {MAX_HZ:.0}", title(column));
            notes.error(Code::Value, line, what);
        } else if let Some((before, lower)) = last.filter(|&(_, lower)| f < lower) {
            let (name, before) = (title(column), title(before));
            let what = format!("{name} is {f}, must not be less than {before}, which is {lower}");
            notes.error(Code::Value, line, what);
        }
        last = Some((column, f));
    }
    for (column, deviation) in columns.deviations.iter().zip(&row.deviations_hz) {
        if let (Some(column), Some(deviation)) = (column, deviation)
            && *deviation <= 0.0
        {
            notes.error(
                Code::Value,
                line,
                format!("{} is {deviation}, must be positive", title(*column)),
            );
        }
    }
    for (name, value, positive) in [
        ("amplitude_nm", row.amplitude_nm, false),
        ("payload_kg", row.payload_kg, false),
        ("sample_rate_hz", row.sample_rate_hz, true),
    ] {
        if let Some(value) = value.filter(|&value| value < 0.0 || (positive && value == 0.0)) {
            let wanted = if positive { "must be positive" } else { "must not be negative" };
            notes.error(Code::Value, line, format!("{name} is {value}, {wanted}"));
        }
    }
    for (link, kg) in row.added_kg.iter().filter(|(_, kg)| *kg < 0.0) {
        let what = format!("mass_{link}_kg is {kg}, must not be negative");
        notes.error(Code::Value, line, what);
    }
    for column in &columns.rotations {
        let own = row.rotations.get(column.mode).into_iter().flatten();
        let mut own = own.filter(|r| r.link == column.link && r.about == column.about);
        if let Some(std) = own.find_map(|rotation| rotation.std).filter(|std| *std <= 0.0) {
            let what = format!("{}_std is {std}, must be positive", title(column.index));
            notes.error(Code::Value, line, what);
        }
    }
    for violation in robot.limit_violations(&row.pose) {
        notes.error(Code::JointLimit, line, violation.to_string());
    }
}

/// A column of how a link turns in a mode.
struct RotationColumn {
    /// From 0.
    mode: usize,
    link: String,
    about: RotationAxis,
    index: usize,
    std: Option<usize>,
}

impl RotationColumn {
    /// The mode, from 1, and what follows it in `phi<mode>_<what>`.
    fn mode_of(title: &str) -> Option<(usize, &str)> {
        let (digits, what) = title.strip_prefix("phi")?.split_once('_')?;
        Some((digits.parse().ok()?, what))
    }

    /// The link and the axis that `<link>` or `<link>_x` names.
    fn place_of(what: &str, links: &[&str]) -> Option<(String, RotationAxis)> {
        let is_link = |name: &str| links.contains(&name);
        if is_link(what) {
            return Some((what.to_owned(), RotationAxis::Joint));
        }
        let (link, axis) = what.rsplit_once('_').filter(|(link, _)| is_link(link))?;
        let axis = ["x", "y", "z"].iter().position(|own| *own == axis)?;
        Some((link.to_owned(), RotationAxis::Base(axis)))
    }
}

/// The columns `phi<mode>_<link>` (about the axis of the link's joint) and `phi<mode>_<link>_x`,
/// `_y`, `_z` (of the base), each with that of its deviation.
fn rotation_columns(
    header: &[String],
    line: usize,
    modes: usize,
    robot: &Robot,
    notes: &mut Notes,
) -> Vec<RotationColumn> {
    let bodies = robot.bodies().iter().filter(|body| !body.is_payload);
    let links: Vec<&str> = bodies.map(|body| body.link.as_str()).collect();
    let mut columns = Vec::new();
    for (index, title) in header.iter().enumerate() {
        let Some((mode, what)) = RotationColumn::mode_of(title) else { continue };
        let of_std = what.strip_suffix("_std").filter(|_| !links.contains(&what));
        let is_numbered = (1..=modes).contains(&mode);
        match RotationColumn::place_of(of_std.unwrap_or(what), &links) {
            Some((link, about)) if is_numbered => {
                if of_std.is_none() {
                    let std = header.iter().position(|other| *other == format!("{title}_std"));
                    columns.push(RotationColumn { mode: mode - 1, link, about, index, std });
                }
            }
            Some(_) => {
                let what = format!("column '{title}' is of mode {mode}, but f{mode}_hz is missing");
                notes.error(Code::MissingKey, line, what);
            }
            None => {
                let what = format!(
                    "column '{title}' is not used: '{what}' is no link with mass, nor such a link \
                     with _x, _y, _z or _std; these are {}{}",
                    links.join(", "),
                    hint(what, links.iter().copied())
                );
                notes.warning(Code::Unused, line, what);
            }
        }
    }
    columns
}

/// The columns `mass_<link>_kg`, each with its link; a link that the robot lacks is a fault.
fn added_columns(
    header: &[String],
    line: usize,
    robot: &Robot,
    notes: &mut Notes,
) -> Vec<(String, usize)> {
    let bodies = robot.bodies().iter().filter(|body| !body.is_payload);
    let links: Vec<&str> = bodies.map(|body| body.link.as_str()).collect();
    let mut columns = Vec::new();
    for (index, title) in header.iter().enumerate() {
        let link = title.strip_prefix("mass_").and_then(|rest| rest.strip_suffix("_kg"));
        let Some(link) = link else { continue };
        if links.contains(&link) {
            columns.push((link.to_owned(), index));
        } else {
            let what = format!(
                "column '{title}': '{link}' is no link with mass; these are {}{}",
                links.join(", "),
                hint(link, links.iter().copied())
            );
            notes.error(Code::Reference, line, what);
        }
    }
    columns
}

/// Whether `title` is `prefix`, a number, `suffix`.
fn numbered(title: &str, prefix: &str, suffix: &str) -> bool {
    let digits = title.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(suffix));
    digits.is_some_and(|d| !d.is_empty() && d.bytes().all(|b| b.is_ascii_digit()))
}

fn pose_columns(
    header: &[String],
    line: impl Into<Option<usize>>,
    robot: &Robot,
    notes: &mut Notes,
) -> Option<PoseColumns> {
    let line = line.into();
    let find = |name: &str| header.iter().position(|title| title == name);
    let any_joint = robot.joints().iter().any(|joint| !columns_of(header, joint).is_empty());
    if !any_joint && find("beta2_rad").is_some() {
        let mut angles: Vec<AngleColumn> = Vec::new();
        for (name, form) in [("beta2", robot.beta2()), ("beta1", robot.beta1())] {
            let Some(index) = find(&format!("{name}_rad")) else { continue };
            let is_free = |(joint, _): &(usize, f64)| angles.iter().all(|a| a.joint != *joint);
            let Some((form, (joint, scale))) =
                form.and_then(|form| Some((form, form.terms().find(is_free)?)))
            else {
                let what = format!(
                    "column '{name}_rad' needs arm_angles.{name} in the robot's file; or give one \
                     column per moving joint"
                );
                if name == "beta1" {
                    notes.warning(Code::Unused, line, what);
                    continue;
                }
                notes.error(Code::Reference, line, what);
                return None;
            };
            angles.push(AngleColumn { index, form: form.clone(), joint, scale });
        }
        return Some(PoseColumns::Angles(angles));
    }
    match joint_columns(header, robot) {
        Ok(columns) => Some(PoseColumns::Joints(columns)),
        Err(faults) => {
            faults.into_iter().for_each(|(code, what)| notes.error(code, line, what));
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::robot::{read_robot, tests as two_link};
    use super::*;

    fn read(text: &str) -> Result<(ModeTable, Reading), Vec<String>> {
        let (folder, path) = two_link::folder(two_link::YAML, two_link::URDF);
        let robot = read_robot(&path, &mut Reading::default()).unwrap();
        let table = folder.path().join("m.csv");
        std::fs::write(&table, text).unwrap();
        let prefix = format!("{}/", folder.path().display());
        let mut reading = Reading::default();
        read_measured(&table, &robot, &mut reading)
            .map(|table| (table, reading))
            .map_err(|notes| notes.iter().map(|f| f.to_string().replace(&prefix, "")).collect())
    }

    #[test]
    fn rows_arrive_in_si_with_blanks_and_covariates() {
        let text = "# c\njoint_2_deg,joint_1_rad,f1_hz,f2_hz,f1_std_hz,zeta1,temperature_c,id,\
                    extra\n\
                    90,0.5,10.5,,0.1,0.02,31,a,x\n";
        let (table, reading) = read(text).unwrap();
        let row = &table.rows[0];
        assert_eq!((row.pose[0], table.modes), (0.5, 2));
        assert!((row.pose[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!(row.frequencies_hz, [Some(10.5), None]);
        assert_eq!(row.deviations_hz, [Some(0.1), None]);
        assert_eq!(row.damping_ratios, [Some(0.02), None]);
        assert_eq!((row.temperature_c, row.id.as_deref()), (Some(31.0), Some("a")));
        assert_eq!(reading.warnings.len(), 1);
        assert!(reading.warnings[0].what.contains("column 'extra'"));
    }

    #[test]
    fn added_masses_are_those_of_links() {
        let text = "joint_1_rad,joint_2_rad,f1_hz,mass_link_1_kg\n1,1,9,2.5\n1,1,10,\n";
        let (table, _) = read(text).unwrap();
        assert_eq!(table.rows[0].added_kg, [("link_1".to_owned(), 2.5)]);
        assert!(table.rows[1].added_kg.is_empty());
        for (text, expected) in [
            ("joint_1_rad,joint_2_rad,f1_hz,mass_link_7_kg\n1,1,9,2\n", "'link_7' is no link"),
            ("joint_1_rad,joint_2_rad,f1_hz,mass_link_1_kg\n1,1,9,-2\n", "mass_link_1_kg is -2"),
        ] {
            let notes = read(text).unwrap_err();
            assert!(notes[0].contains(expected), "{notes:?}");
        }
    }

    /// beta2 = joint_2 + 0.25 in this robot's file.
    #[test]
    fn a_pose_may_come_as_an_angle_of_the_two_link_model() {
        let (table, _) = read("beta2_rad,f1_hz\n1.5,10\n").unwrap();
        assert_eq!(table.rows[0].pose, [0.0, 1.25]);
    }

    #[test]
    fn every_fault_is_told_with_its_line() {
        for (text, expected) in [
            ("joint_1_rad,f1_hz\n", vec!["m.csv:1: no column 'joint_2_rad'"]),
            (
                "joint_1,joint_2_rad,beta2_rad,f1_hz\n1,1,1,9\n",
                vec!["m.csv:1: column 'joint_1' has no unit; name it joint_1_rad or joint_1_deg"],
            ),
            ("joint_1_rad,joint_2_rad\n", vec!["m.csv:1: no column 'f1_hz'"]),
            ("joint_1_rad,joint_2_rad,f1_hz,f3_hz\n", vec!["m.csv:1: no column 'f2_hz'"]),
            ("joint_1_rad,joint_2_rad,f1_hz\n", vec!["m.csv: has no rows"]),
            ("joint_1_rad,joint_2_rad,f1_hz\n1,1,\n", vec!["m.csv: has no frequency"]),
            (
                "joint_1_rad,joint_2_rad,f1_hz,f2_hz\n1,1,20,10\n9,1,-3,5\n1,x,1,2\n",
                vec![
                    "m.csv:2: f2_hz is 10, must not be less than f1_hz, which is 20",
                    "m.csv:3: f1_hz is -3, must be positive",
                    "m.csv:3: joint 'joint_1' is 515.662 deg",
                    "m.csv:4: joint_2_rad is 'x'",
                ],
            ),
            ("joint_1_rad,joint_2_rad,f1_hz\n1,1\n", vec!["m.csv:2: has 2 cells, must have 3"]),
        ] {
            let notes = read(text).unwrap_err();
            assert_eq!(notes.len(), expected.len(), "{notes:?}");
            for (fault, expected) in notes.iter().zip(expected) {
                assert!(fault.starts_with(expected), "{fault}");
            }
        }
    }
}
