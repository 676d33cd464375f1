//! Load tests → the stiffness of each joint.

use std::path::Path;

use serde::{Serialize, Serializer};

use super::Read;
use crate::identify::stiffness::{Jump, StiffnessFault, StiffnessFit, fit_stiffness, jump};
use crate::input::{LoadTestRow, read_load_test};
use crate::notes::{Code, Note, Part, Place};
use crate::units::ratio_from_percent;

/// The stiffness of one joint.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointStiffness {
    /// Name, where the table has one.
    pub joint: Option<String>,
    /// What was found.
    #[serde(flatten)]
    pub fit: StiffnessFit,
    /// How far the number holds.
    #[serde(rename = "hints", serialize_with = "in_words")]
    pub warnings: Vec<Note>,
}

fn in_words<S: Serializer>(warnings: &[Note], to: S) -> Result<S::Ok, S::Error> {
    to.collect_seq(warnings.iter().map(|warning| &warning.what))
}

/// Warnings on how far a stiffness holds.
fn warnings(joint: Option<&String>, fit: &StiffnessFit, jump: Option<Jump>) -> Vec<Note> {
    let mut warnings = Vec::new();
    let mut warn = |code, what: String| {
        let place =
            joint.map_or_else(Place::default, |joint| Place::part(Part::Joint(joint.clone())));
        warnings.push(Note::warning(code, place, what));
    };
    if let Some(curvature) = fit.curvature.filter(|curvature| curvature.is_significant) {
        let how = if curvature.stiffens { "stiffens" } else { "softens" };
        warn(
            Code::LoadDependent,
            format!(
                "the joint {how} with load (p-value {:.1e}), so one k holds only near these \
                 loads; test near the loads of the job",
                curvature.p_value
            ),
        );
    }
    if let Some(Jump { size_rad, stiffness }) = jump {
        let what = format!(
            "the angle jumps by {size_rad:.2e} where the load changes its direction, as play makes \
             it, and lowers k; on either side the line has k = {stiffness:.4e}"
        );
        warn(Code::LoadDependent, what);
    }
    let inverse = fit.stiffness / fit.r_squared;
    if fit.r_squared > 0.0 && inverse > fit.interval[1] {
        let what = format!(
            "k and its interval hold where the moments scatter; if the angles do, k is \
             {inverse:.4e} (1/R² times as much); load more, or measure the angle more finely"
        );
        warn(Code::TooLittleData, what);
    }
    if fit.interval[0] <= 0.0 {
        let what = "the interval includes zero, so the stiffness is not known; check signs and \
                    columns, or load in more steps";
        warn(Code::TooLittleData, what.to_owned());
    }
    warnings
}

/// Reads the table of a load test.
pub fn read(file: &Path) -> Read<Vec<LoadTestRow>> {
    Read::of(|reading| read_load_test(file, reading))
}

/// Fits each joint of a load test, in the order in which joints first appear.
///
/// # Errors
/// A confidence outside of 0..100 %; every joint that cannot be fitted, at its first row or the row
/// at fault.
pub fn stiffness(
    rows: &[LoadTestRow],
    confidence_percent: f64,
) -> Result<Vec<JointStiffness>, Vec<Note>> {
    let confidence = ratio_from_percent(confidence_percent);
    if !(confidence > 0.0 && confidence < 1.0) {
        let what =
            format!("the confidence is {confidence_percent} %, must be above 0 and below 100 %");
        let place = Place { key: "confidence", ..Place::default() };
        return Err(vec![Note::error(Code::Usage, place, what)]);
    }
    let mut found = Vec::new();
    let mut errors = Vec::new();
    for (joint, rows) in by_joint(rows) {
        let angles: Vec<f64> = rows.iter().map(|row| row.angle_rad).collect();
        let moments: Vec<f64> = rows.iter().map(|row| row.moment_nm).collect();
        match fit_stiffness(&angles, &moments, confidence) {
            Ok(fit) => {
                let warnings = warnings(joint.as_ref(), &fit, jump(&angles, &moments));
                found.push(JointStiffness { joint, fit, warnings });
            }
            Err(fault) => {
                let index = match fault {
                    StiffnessFault::NotFinite(row) => row,
                    _ => 0,
                };
                let place = Place {
                    line: rows.get(index).map(|row| row.line),
                    part: joint.map(Part::Joint),
                    ..Place::default()
                };
                errors.push(Note::error(code(&fault), place, fault.to_string()));
            }
        }
    }
    if errors.is_empty() { Ok(found) } else { Err(errors) }
}

fn code(fault: &StiffnessFault) -> Code {
    match fault {
        StiffnessFault::TooFewRows(_) | StiffnessFault::NothingVaries => Code::TooLittleData,
        _ => Code::Value,
    }
}

/// The rows of each joint, joints in the order in which they first appear.
fn by_joint(rows: &[LoadTestRow]) -> Vec<(Option<String>, Vec<&LoadTestRow>)> {
    let mut joints: Vec<(Option<String>, Vec<&LoadTestRow>)> = Vec::new();
    for row in rows {
        match joints.iter_mut().find(|(joint, _)| *joint == row.joint) {
            Some((_, of_joint)) => of_joint.push(row),
            None => joints.push((row.joint.clone(), vec![row])),
        }
    }
    joints
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(joint: &str, angle_rad: f64, moment_nm: f64, line: usize) -> LoadTestRow {
        LoadTestRow { joint: Some(joint.into()), angle_rad, moment_nm, line }
    }

    /// k = 500 000 N·m/rad, loads from 50 to 500 N·m both ways, angles as they are, with play of
    /// 0.3 mrad to either side, and with noise of 0.4 mrad.
    #[test]
    fn play_and_noise_of_angles_are_told() {
        const K: f64 = 5e5;
        let told = |angle: &dyn Fn(usize, f64) -> f64| -> Vec<String> {
            let loads =
                (0..40).map(|i| (25.0 + 25.0 * f64::from(i / 2)) * [1.0, -1.0][i as usize % 2]);
            let rows = loads.enumerate().map(|(i, m)| row("a", m / K + angle(i, m), m, i + 2));
            let found = stiffness(&rows.collect::<Vec<_>>(), 95.0).unwrap().remove(0);
            found.warnings.into_iter().map(|note| note.what).collect()
        };
        let noise =
            |std: f64| move |i: usize, _| std * (2.4 * (i as f64).powi(2)).sin() * 2_f64.sqrt();
        assert_eq!(told(&noise(1e-6)), Vec::<String>::new());
        let play = told(&|i, m: f64| 3e-4 * m.signum() + noise(1e-6)(i, m));
        let k: f64 = play[0].rsplit("k = ").next().unwrap().parse().unwrap();
        assert!(play[0].contains("jumps by 6.00e-4") && (k / K - 1.0).abs() < 1e-3, "{play:?}");
        let scatter = told(&noise(4e-4));
        assert!(scatter.iter().any(|what| what.contains("if the angles do")), "{scatter:?}");
    }

    /// Rows of two joints, mixed: joint b cannot be fitted, and says so at its first line.
    #[test]
    fn joints_are_fitted_apart_and_errors_have_their_line() {
        let mut rows = vec![
            row("a", 0.0, 0.0, 2),
            row("b", 1.0, 0.0, 3),
            row("a", 1.0, 2.0, 4),
            row("a", 2.0, 4.0, 5),
        ];
        let errors = stiffness(&rows, 95.0).unwrap_err();
        assert_eq!(errors.len(), 1);
        assert_eq!(errors[0].place.line, Some(3));
        assert!(errors[0].to_string().starts_with("line 3: joint 'b': 1 row"), "{}", errors[0]);
        rows.remove(1);
        let found = stiffness(&rows, 95.0).unwrap();
        assert_eq!((found.len(), found[0].fit.stiffness), (1, 2.0));
        assert!(found[0].warnings.is_empty());
        assert_eq!(stiffness(&rows, 100.0).unwrap_err()[0].code, Code::Usage);
    }
}
