//! `detune stiffness`: joint stiffness from a load test.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Failure, Outcome, Warnings, of_option};
use crate::notes::{Note, Place};
use crate::report::stiffness::{stiffness_json, stiffness_text};
use crate::study::Read;
use crate::study::stiffness::{read, stiffness};

/// Find the stiffness of joints from known moments and measured angles.
#[derive(Debug, Args)]
#[command(
    after_help = "The table has the columns moment_nm, or lever_mm with mass_kg or force_n; one of \
    angle_rad, angle_mrad and angle_deg, or gauge_mm with gauge_lever_mm (a dial gauge); and \
    optionally joint.\n\nExample:\n  detune stiffness loads.csv --confidence 99"
)]
pub(super) struct StiffnessArgs {
    /// Table of the load test.
    #[arg(value_name = "LOADS.csv")]
    loads: PathBuf,
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Confidence of the interval, %.
    #[arg(long, value_name = "PERCENT", default_value_t = 95.0)]
    confidence: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Readable text.
    Text,
    /// JSON.
    Json,
}

/// Fits each joint of the table; if one cannot be fitted, reports all that cannot and writes
/// nothing.
pub(super) fn run(
    args: &StiffnessArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let Read { value: rows, warnings, .. } = read(&args.loads);
    shown.show(&warnings);
    let found = stiffness(&rows?, args.confidence)
        .map_err(|errors| errors.into_iter().map(|note| at(args, note)).collect::<Vec<_>>())?;
    found.iter().for_each(|joint| shown.shown_elsewhere(&joint.warnings));
    let text = match args.format {
        Format::Text => stiffness_text(&found),
        Format::Json => {
            stiffness_json(&found).map_err(|error| Failure::Internal(error.to_string()))?
        }
    };
    out.write_all(text.as_bytes())?;
    Ok(Outcome::Pass)
}

/// An error with the file that its line is in, or the option at fault.
fn at(args: &StiffnessArgs, mut note: Note) -> Note {
    if note.place.line.is_some() {
        note.place = Place { file: Some(args.loads.clone()), ..note.place };
        note
    } else {
        of_option(note)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stiffness(table: &str, format: Format, confidence: f64) -> Result<String, Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        let loads = folder.path().join("loads.csv");
        std::fs::write(&loads, table).unwrap();
        let mut out = Vec::new();
        let file = format!("{}:", loads.display());
        match run(&StiffnessArgs { loads, format, confidence }, &mut out, &Warnings::default()) {
            Ok(_) => Ok(String::from_utf8(out).unwrap()),
            Err(Failure::Input(errors)) => {
                Err(errors.iter().map(|error| error.to_string().replace(&file, "")).collect())
            }
            Err(other) => panic!("{other:?}"),
        }
    }

    /// Two joints, rows mixed. Joint a: (0,0), (1,2), (2,4), (3,6) exactly; joint b by hand: angles
    /// 0 1 2, moments 0 3 3: k = 1.5, residuals −0.5 1 −0.5, s = √1.5, SE = √0.75.
    #[test]
    fn each_joint_has_its_line() {
        let table = "joint,angle_rad,moment_nm\na,0,0\nb,0,0\na,1,2\nb,1,3\na,2,4\nb,2,3\na,3,6\n";
        let json: serde_json::Value =
            serde_json::from_str(&stiffness(table, Format::Json, 95.0).unwrap()).unwrap();
        assert_eq!(json["schema"], "stiffness/1");
        assert_eq!(json["joints"][0]["joint"], "a");
        assert_eq!(json["joints"][0]["stiffness_nm_per_rad"], 2.0);
        let b = &json["joints"][1];
        let number = |key: &str| b[key].as_f64().unwrap();
        assert!((number("stiffness_nm_per_rad") - 1.5).abs() < 1e-12);
        assert!((number("standard_error_nm_per_rad") - 0.75_f64.sqrt()).abs() < 1e-12);
        // t(0.975; 1) = 12.7062.
        let high = b["interval_nm_per_rad"][1].as_f64().unwrap();
        assert!((high - 1.5 - 12.7062 * 0.75_f64.sqrt()).abs() < 1e-3);
        let text = stiffness(table, Format::Text, 95.0).unwrap();
        assert!(text.contains("a: k = 2 N·m/rad") && text.contains("includes zero"), "{text}");
    }

    /// Joint 2 of the paper, 138 000 N·m/rad, as a workshop would load it: masses at 0.9 m, a gauge
    /// at 1.2 m that shows the tangent of the angle, and starts at 0.05 mm.
    #[test]
    fn masses_and_a_dial_gauge_give_the_stiffness_that_bent_them() {
        let mut table = "mass_kg,lever_mm,gauge_mm,gauge_lever_mm\n".to_owned();
        for mass in [0.0, 10.0, 20.0, 30.0, 40.0] {
            let angle: f64 = mass * 9.80665 * 0.9 / 138_000.0;
            table += &format!("{mass},900,{:.9},1200\n", 1200.0 * angle.tan() + 0.05);
        }
        let json: serde_json::Value =
            serde_json::from_str(&stiffness(&table, Format::Json, 95.0).unwrap()).unwrap();
        let found = json["joints"][0]["stiffness_nm_per_rad"].as_f64().unwrap();
        assert!((found / 138_000.0 - 1.0).abs() < 1e-5, "{found}");
    }

    #[test]
    fn a_falling_line_is_no_spring_and_small_springs_keep_their_digits() {
        let table = "angle_rad,moment_nm\n0,0\n1,-2\n2,-4.1\n";
        let faults = stiffness(table, Format::Text, 95.0).unwrap_err();
        assert!(faults[0].starts_with("2: k is -2.0500e0 N·m/rad, must be positive"), "{faults:?}");
        let small = "angle_rad,moment_nm\n0,0\n1,0.000123456\n2,0.000246913\n3,0.000370367\n";
        let text = stiffness(small, Format::Text, 95.0).unwrap();
        assert!(text.contains("k = 0.000123456 N·m/rad"), "{text}");
    }

    #[test]
    fn faults_have_their_line() {
        let table = "joint,angle_rad,moment_nm\na,0,0\na,1,2\nb,1,1\nb,1,2\nb,1,3\n";
        let faults = stiffness(table, Format::Text, 95.0).unwrap_err();
        assert!(faults[0].starts_with("2: joint 'a': 2 rows, must have at least 3"), "{faults:?}");
        assert!(faults[1].starts_with("4: joint 'b': all angles"), "{faults:?}");
        let faults = stiffness(table, Format::Text, 100.0).unwrap_err();
        assert_eq!(
            faults,
            ["--confidence: the confidence is 100 %, must be above 0 and below 100 %"]
        );
    }
}
