//! What a robot's model gets wrong, by a table of measured modes; and the corrections and the
//! calibration that its file should hold.

use std::path::{Path, PathBuf};

use super::calibration::{digest, fitted_to_table};
use super::{Output, Read};
pub use crate::diagnosis::Settings;
use crate::diagnosis::{self, Diagnosis, Verdict, label};
use crate::identify::ModeTable;
use crate::input::{
    CalibrationRecord, DescribedRobot, FittedCorrection, FittedTable, TableName, corrected_robot,
    read_described_robot, read_measured,
};
use crate::model::{Calibration, Description};
use crate::notes::{Code, Note, Place};
use crate::progress::Progress;

/// A calibration never claims more than this, which robot.yaml does not take, % of the frequency.
const MAX_HELDOUT_PERCENT: f64 = 100.0;

/// A model whose error is larger says nothing about which speeds are safe, % of the frequency.
const MAX_USEFUL_PERCENT: f64 = 25.0;

/// Joint positions are recorded to a millionth of a rad or m: no robot repeats a pose better.
const POSES_PER_UNIT: f64 = 1e6;

/// A diagnosis with all that is shown of it and what is to be written back.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosed {
    /// Name of the robot.
    pub robot: String,
    /// The table's file.
    pub table: PathBuf,
    /// What was found.
    pub diagnosis: Diagnosis,
    /// Corrections of the robot's file that were fitted to poses of this table, each as "cause at
    /// place": the diagnosis starts without them.
    pub fitted_again: Vec<String>,
    /// Warnings about the table and the robot's calibration.
    pub notes: Vec<Note>,
    /// What the robot's file should hold.
    pub update: RobotUpdate,
}

/// Corrections and calibration for a robot's file, in place of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotUpdate {
    /// Those that the diagnosis started from, then what it found.
    pub corrections: Vec<FittedCorrection>,
    /// How good the model is with them.
    pub calibration: CalibrationRecord,
    /// Damping ratios of joints.
    pub damping: Vec<(String, f64)>,
    /// Warnings about that file, without its name.
    pub notes: Vec<Note>,
    /// Why the table cannot be what it is taken for; then nothing is written.
    pub doubt: Option<String>,
}

/// A robot and the table of modes that were measured on it.
#[derive(Debug)]
pub struct MeasuredRobot {
    /// The robot.
    pub robot: DescribedRobot,
    /// The table, at the robot's joints.
    pub table: ModeTable,
}

/// Reads a robot.yaml, its URDF and a table of measured modes.
pub fn read(robot_file: &Path, table_file: &Path) -> Read<MeasuredRobot> {
    Read::of(|reading| {
        let robot = read_described_robot(robot_file, reading)?;
        let table = read_measured(table_file, &robot.robot, reading)?;
        Ok(MeasuredRobot { robot, table })
    })
}

impl RobotUpdate {
    /// The robot's file with the update, for the file `to`, read back and compared; `date` as
    /// YYYY-MM-DD.
    ///
    /// # Errors
    /// The file is written in a manner that cannot be edited, or the table is in another unit.
    pub fn output(&self, robot_file: &Path, to: &Path, date: &str) -> Result<Output, Vec<Note>> {
        let Self { corrections, calibration, damping, doubt, .. } = self;
        if let Some(why) = doubt {
            let what = format!("nothing is written: {why}");
            return Err(vec![Note::error(Code::NotRewritten, Place::file(to), what)]);
        }
        let text = corrected_robot(robot_file, to, corrections, calibration, damping, date)?;
        Ok(Output::new(to, text.into_bytes()))
    }
}

/// Diagnoses a robot by a table that was read from `file`. Corrections that were fitted to poses of
/// this table are left out and fitted again, so that held-out errors are measured at poses that
/// nothing was fitted to.
///
/// # Errors
/// As [`diagnosis::diagnose`], with the table's file, behind the warnings that came up before.
pub fn diagnose(
    measured: &MeasuredRobot,
    file: &Path,
    settings: Settings,
    progress: Progress<'_>,
) -> Result<Diagnosed, Vec<Note>> {
    let MeasuredRobot { robot, table } = measured;
    let in_file =
        |note: Note| Note { place: Place { file: Some(file.into()), ..note.place }, ..note };
    let digest = digest(table);
    let (fitted, kept) = fitted_to_table(robot, table, &digest);
    let description = Description {
        corrections: kept.iter().map(|kept| kept.correction.clone()).collect(),
        // What was learned is learned again, from the values of the files.
        calibration: None,
        ..robot.description.clone()
    };
    let labels: Vec<String> = fitted
        .iter()
        .map(|fitted| label(fitted.correction.cause, fitted.correction.at.as_deref()))
        .collect();
    let unknown = unknown_origin_note(robot, &kept);
    let floor_percent = if unknown.is_some() { earlier_heldout_percent(robot) } else { 0.0 };
    let notes = fitted_note(&labels).into_iter().chain(unknown);
    let mut notes: Vec<Note> = notes.map(in_file).collect();
    let found = match diagnosis::diagnose(&description, table, settings, progress) {
        Ok(found) => found,
        Err(error) => {
            notes.push(in_file(error));
            return Err(notes);
        }
    };
    notes.extend(found.notes.iter().cloned().map(in_file));
    Ok(Diagnosed {
        robot: robot.robot.name().to_owned(),
        table: file.to_owned(),
        update: update(
            robot,
            table,
            TableName { file: name_of(file), digest },
            kept,
            &found,
            floor_percent,
        ),
        diagnosis: found,
        fitted_again: labels,
        notes,
    })
}

fn name_of(file: &Path) -> String {
    file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn fitted_note(labels: &[String]) -> Option<Note> {
    let (noun, verb) = match labels.len() {
        0 => return None,
        1 => ("correction", "was"),
        _ => ("corrections", "were"),
    };
    let what = format!(
        "the robot's {noun} {} {verb} fitted to poses of this table, or after one that was: the \
         diagnosis starts without them and fits them again",
        labels.join("; ")
    );
    Some(Note::warning(Code::Calibration, Place::default(), what))
}

/// Corrections that may have been fitted to this very table: nothing says which poses they were
/// fitted to.
fn unknown_origin_note(robot: &DescribedRobot, kept: &[FittedCorrection]) -> Option<Note> {
    let fitted_to = robot.calibration.iter().flat_map(|calibration| &calibration.fitted_to);
    let known: Vec<&String> = fitted_to.map(|fitted| &fitted.table.digest).collect();
    let is_unknown = |correction: &&FittedCorrection| match &correction.table {
        Some(digest) => !known.contains(&digest),
        None => true,
    };
    let unknown: Vec<String> = kept
        .iter()
        .filter(is_unknown)
        .map(|kept| label(kept.correction.cause, kept.correction.at.as_deref()))
        .collect();
    if unknown.is_empty() {
        return None;
    }
    let what = format!(
        "the robot's file does not say which poses {} was fitted to; if it was fitted to this \
         table, the errors below are not held out, so the calibration claims no less than before: \
         remove it from the corrections and run again",
        unknown.join("; ")
    );
    Some(Note::warning(Code::Calibration, Place::default(), what))
}

/// What a calibration may claim at best where errors may not be held out: what it claimed before,
/// or what check assumes of a robot that was never calibrated (half of 10 %).
fn earlier_heldout_percent(robot: &DescribedRobot) -> f64 {
    robot.calibration.as_ref().map_or(5.0, |old| old.model.heldout_rms_percent)
}

/// The corrections that were kept and what was found, each with the table that it was fitted to.
fn update(
    robot: &DescribedRobot,
    table: &ModeTable,
    name: TableName,
    kept: Vec<FittedCorrection>,
    found: &Diagnosis,
    floor_percent: f64,
) -> RobotUpdate {
    let old_tables = robot.calibration.iter().flat_map(|calibration| &calibration.fitted_to);
    let is_kept = |fitted: &&FittedTable| {
        kept.iter().any(|kept| kept.table.as_ref() == Some(&fitted.table.digest))
    };
    let mut fitted_to: Vec<FittedTable> = old_tables.filter(is_kept).cloned().collect();
    if !found.corrections.is_empty() {
        let measured =
            table.rows.iter().filter(|row| row.frequencies_hz.iter().any(Option::is_some));
        let rounded = |q: &f64| (q * POSES_PER_UNIT).round() / POSES_PER_UNIT;
        let joints = measured.map(|row| row.pose.iter().map(rounded).collect()).collect();
        fitted_to.push(FittedTable { table: name.clone(), joints });
    }
    let new = found.corrections.iter().map(|correction| {
        let own = found
            .findings
            .iter()
            .filter(|finding| finding.cause == correction.cause && finding.at == correction.at);
        FittedCorrection {
            ci95: own.flat_map(|f| f.parameters.iter().map(|p| (p.name.clone(), p.ci95))).collect(),
            table: Some(name.digest.clone()),
            note: None,
            correction: correction.clone(),
        }
    });
    let heldout = found.extended.heldout_rms_percent.max(floor_percent);
    RobotUpdate {
        corrections: kept.into_iter().chain(new).collect(),
        calibration: CalibrationRecord {
            model: Calibration {
                poses: found.poses,
                heldout_rms_percent: heldout
                    .clamp(Calibration::MIN_HELDOUT_PERCENT, MAX_HELDOUT_PERCENT),
                is_doubtful: !found.predicts,
                posterior: Some(found.posterior.clone()),
            },
            table: Some(name),
            fitted_to,
        },
        damping: found.damping.iter().map(|own| (own.joint.clone(), own.damping_ratio)).collect(),
        notes: update_notes(found),
        doubt: found.notes.iter().find(|note| note.code == Code::Units).map(|n| n.what.clone()),
    }
}

fn update_notes(found: &Diagnosis) -> Vec<Note> {
    let mut notes = Vec::new();
    let mut warn = |what: String| {
        notes.push(Note::warning(Code::Calibration, Place::default(), what));
    };
    let heldout = found.extended.heldout_rms_percent;
    if !found.predicts {
        warn(format!(
            "the causes predict states left out with an error of {heldout:.2} %, far larger than \
             that of their fit: the calibration is marked doubtful, and no verdict with it is \
             better than uncertain; measure more poses"
        ));
    }
    if heldout > MAX_USEFUL_PERCENT {
        warn(format!(
            "the held-out error of the model is {heldout:.0} %: with this calibration, check \
             cannot separate safe speeds from unsafe ones"
        ));
    }
    if found.verdict == Verdict::Unexplained {
        warn(
            "no cause explains the error: no correction was added, only the calibration".to_owned(),
        );
    }
    notes
}
