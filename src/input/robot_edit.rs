//! A robot.yaml with corrections and calibration put in: the text is kept, comments and all, but
//! for the two blocks and, where the new file lies in another folder, the path of the URDF.

use std::fmt::Write;
use std::path::Path;

use super::Reading;
use super::calibration::{CalibrationRecord, FittedCorrection, TableName};
use super::files::MAX_ROBOT_BYTES;
use super::posterior;
use super::relocated::relocated;
use super::robot::{described_robot_of_text, read_described_robot};
use crate::formats::text::read_text;
use crate::formats::yaml::Step;
use crate::formats::yaml::splice::{Entry, Splice, entries, quoted};
use crate::model::{Calibration, Carries, CoordinateKind, Damping, Description};
use crate::notes::{Code, Note, Place};

/// The text of the robot file at `path` with these corrections, this calibration and these damping
/// ratios of joints in place of its own, to be written to `output`. `date` is the day of the
/// calibration, as YYYY-MM-DD.
///
/// # Errors
/// The file cannot be read, is written in braces as a whole, or would not be read as what was asked
/// for.
pub fn corrected_robot(
    path: &Path,
    output: &Path,
    corrections: &[FittedCorrection],
    calibration: &CalibrationRecord,
    damping: &[(String, f64)],
    date: &str,
) -> Result<String, Vec<Note>> {
    let text = read_text(path, MAX_ROBOT_BYTES)?;
    let before = read_described_robot(path, &mut Reading::default())?;
    let refused = |what: &str| vec![Note::error(Code::NotRewritten, Place::file(path), what)];
    let (mut urdf, mut old) = (None, [None, None]);
    let mut springs: Vec<(String, String, Entry)> = Vec::new();
    entries(&text, |steps, entry| match steps {
        [Step::Key("urdf")] => urdf = Some(entry()),
        [Step::Key("corrections")] => old[0] = Some(entry()),
        [Step::Key("calibration")] => old[1] = Some(entry()),
        [Step::Key("elasticity"), Step::Key("joints"), Step::Key(joint), Step::Key(key)] => {
            springs.push(((*joint).to_owned(), (*key).to_owned(), entry()));
        }
        _ => {}
    })
    .ok_or_else(|| refused("is not a robot that can be rewritten"))?;
    if urdf.as_ref().is_some_and(|urdf| urdf.in_braces) {
        let what = "is a mapping in braces, which cannot be edited; put one key on each line";
        return Err(refused(what));
    }
    let mut splice = Splice::of(&text);
    let blocks = [corrections_block(corrections), calibration_block(calibration, date)];
    for (entry, block) in old.iter().zip(&blocks) {
        match entry {
            Some(entry) => splice.replace_entry(entry, block),
            None => splice.append(block),
        }
    }
    for (joint, zeta) in damping {
        damp(&mut splice, &springs, joint, *zeta);
    }
    if let Some(urdf) = urdf
        && let Some(name) = relocated(&urdf.text, path, output)
    {
        splice.replace(urdf.value, quoted(&name));
    }
    let text = splice.finish();
    let mut wanted = before.description;
    for spring in &mut wanted.elastic_joints {
        if let Some((_, zeta)) = damping.iter().find(|(joint, _)| *joint == spring.joint) {
            spring.damping = Some(Damping::Ratio(*zeta));
        }
    }
    confirm(&wanted, &text, output, corrections, calibration).map_err(|why| {
        let what = format!(
            "is not written: read again, {why}; {} is written in a manner that cannot be edited, \
             so change it by hand",
            path.display()
        );
        vec![Note::error(Code::NotRewritten, Place::file(output), what)]
    })?;
    Ok(text)
}

/// Puts a joint's damping ratio into its spring: in place of the damping there, else behind the
/// stiffness.
fn damp(splice: &mut Splice<'_>, springs: &[(String, String, Entry)], joint: &str, zeta: f64) {
    let own = |wanted: &dyn Fn(&str) -> bool| {
        springs.iter().find(|(at, key, _)| at == joint && wanted(key)).map(|(.., entry)| entry)
    };
    let new = format!("damping_ratio: {zeta}");
    if let Some(entry) = own(&|key| key.starts_with("damping_")) {
        splice.replace(entry.whole(), new);
    } else if let Some(entry) = own(&|key| key.starts_with("stiffness_")) {
        let stiffness = splice.slice(entry.value.clone());
        let between = splice.between(entry);
        splice.replace(entry.value.clone(), format!("{}{between}{new}", stiffness.trim_end()));
    }
}

/// Whether `text`, in the file `output`, is the same robot with these corrections and this
/// calibration.
fn confirm(
    before: &Description,
    text: &str,
    output: &Path,
    corrections: &[FittedCorrection],
    calibration: &CalibrationRecord,
) -> Result<(), String> {
    let again = described_robot_of_text(output, text, &mut Reading::default())
        .map_err(|errors| errors.first().map_or_else(String::new, Note::message))?;
    if again.calibration.as_ref() != Some(calibration) {
        return Err("its calibration would be different".to_owned());
    }
    let by_name = |fitted: &FittedCorrection| {
        let mut sorted = fitted.clone();
        sorted.correction.parameters.sort_by(|a, b| a.0.cmp(&b.0));
        sorted.ci95.sort_by(|a, b| a.0.cmp(&b.0));
        sorted
    };
    if !again.corrections.iter().map(by_name).eq(corrections.iter().map(by_name)) {
        return Err("its corrections would be different".to_owned());
    }
    let wanted = Description {
        corrections: again.description.corrections.clone(),
        calibration: again.description.calibration.clone(),
        ..before.clone()
    };
    if again.description != wanted {
        return Err("it would be another robot".to_owned());
    }
    Ok(())
}

/// The block of corrections as YAML.
fn corrections_block(corrections: &[FittedCorrection]) -> String {
    let mut out = String::new();
    // Writing to a string does not fail.
    if corrections.is_empty() {
        out.push_str("corrections: []\n");
    } else {
        out.push_str("corrections:\n");
    }
    for FittedCorrection { correction, ci95, table, note } in corrections {
        let _ = writeln!(out, "  - cause: {}", correction.cause);
        if let Some(at) = &correction.at {
            let _ = writeln!(out, "    at: {}", quoted(at));
        }
        if !correction.parameters.is_empty() {
            let values: Vec<String> = correction
                .parameters
                .iter()
                .map(|(name, value)| format!("{name}: {value}"))
                .collect();
            let _ = writeln!(out, "    parameters: {{{}}}", values.join(", "));
        }
        if !ci95.is_empty() {
            let values: Vec<String> =
                ci95.iter().map(|(name, [low, high])| format!("{name}: [{low}, {high}]")).collect();
            let _ = writeln!(out, "    ci95: {{{}}}", values.join(", "));
        }
        if let Some(hinge) = &correction.hinge {
            let kind = match hinge.kind {
                CoordinateKind::Rotation => "rotation",
                CoordinateKind::Translation => "translation",
            };
            let axes: Vec<String> =
                hinge.axes.iter().map(|a| format!("[{}, {}, {}]", a.x, a.y, a.z)).collect();
            let origin = hinge.origin_m;
            let _ = writeln!(out, "    kind: {kind}");
            let _ = writeln!(out, "    axes: [{}]", axes.join(", "));
            let _ = writeln!(out, "    origin_m: [{}, {}, {}]", origin.x, origin.y, origin.z);
            if hinge.carries != Carries::Link {
                let _ = writeln!(out, "    carries: {}", hinge.carries.name());
            }
        }
        for (key, value) in [("table", table), ("note", note)] {
            if let Some(value) = value {
                let _ = writeln!(out, "    {key}: {}", quoted(value));
            }
        }
    }
    out
}

fn calibration_block(calibration: &CalibrationRecord, date: &str) -> String {
    let CalibrationRecord { model, table, fitted_to } = calibration;
    let Calibration { poses, heldout_rms_percent, is_doubtful, posterior } = model;
    let mut out = format!(
        "calibration: {{poses: {poses}, heldout_rms_percent: {heldout_rms_percent}, date: {date}"
    );
    if *is_doubtful {
        out.push_str(", doubtful: true");
    }
    let named = |table: &TableName| {
        format!("file: {}, digest: {}", quoted(&table.file), quoted(&table.digest))
    };
    // Writing to a string does not fail.
    if let Some(table) = table {
        let _ = write!(out, ",\n  table: {{{}}}", named(table));
    }
    let entries: Vec<String> = fitted_to
        .iter()
        .map(|fitted| {
            let poses: Vec<String> = fitted.joints.iter().map(|q| pose(q)).collect();
            format!(
                "    {{{}, joints: [\n      {}]}}",
                named(&fitted.table),
                poses.join(",\n      ")
            )
        })
        .collect();
    if !entries.is_empty() {
        let _ = write!(out, ",\n  fitted_to: [\n{}]", entries.join(",\n"));
    }
    if let Some(posterior) = posterior {
        posterior::write(&mut out, posterior, &|text| quoted(text).to_string());
    }
    out + "}\n"
}

fn pose(joints: &[f64]) -> String {
    let joints = joints.iter().map(f64::to_string);
    format!("[{}]", joints.collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::super::calibration::FittedTable;
    use super::super::robot::{DescribedRobot, read_described_robot, tests as two_link};
    use super::*;
    use crate::model::Correction;
    use crate::model::{Cause, Hinge};
    use nalgebra::Vector3;

    /// A robot's file without corrections.
    fn plain() -> String {
        two_link::YAML.replace("corrections: []\n", "")
    }

    fn load(path: &Path) -> Result<DescribedRobot, Vec<Note>> {
        read_described_robot(path, &mut Reading::default())
    }

    const DATE: &str = "2026-11-21";

    fn calibrated(poses: usize, heldout_rms_percent: f64) -> CalibrationRecord {
        let model = Calibration { poses, heldout_rms_percent, is_doubtful: false, posterior: None };
        CalibrationRecord { model, table: None, fitted_to: Vec::new() }
    }

    fn correction(cause: Cause, at: &str, name: &str, value: f64) -> FittedCorrection {
        FittedCorrection {
            correction: Correction {
                cause,
                at: Some(at.to_owned()),
                parameters: vec![(name.to_owned(), value)],
                hinge: None,
            },
            ci95: vec![(name.to_owned(), [0.5 * value, 2.0 * value])],
            table: Some("fnv1a-0123456789abcdef".to_owned()),
            note: None,
        }
    }

    /// What is written is read again, from another folder, with comments kept and the blocks
    /// replaced.
    #[test]
    fn what_is_written_is_read_again() {
        let yaml = format!("# my arm\n{}corrections: []\n", plain());
        let (folder, path) = two_link::folder(&yaml, two_link::URDF);
        let elsewhere = folder.path().join("a/b");
        std::fs::create_dir_all(&elsewhere).unwrap();
        let output = elsewhere.join("out.yaml");
        let mut bends = correction(Cause::LinkFlexibility, "link_1", "stiffness_nm_per_rad", 2e5);
        bends.correction.hinge = Some(Hinge {
            kind: CoordinateKind::Rotation,
            axes: vec![Vector3::y()],
            origin_m: Vector3::new(0.3, 0.0, 0.0),
            carries: Carries::Rest,
        });
        bends.table = None;
        bends.note = Some("by hand: it's soft".to_owned());
        let corrections = [correction(Cause::Payload, "tool0", "mass_kg", 4.9), bends];
        let table =
            TableName { file: "my table.csv".into(), digest: "fnv1a-0123456789abcdef".into() };
        let joints = vec![vec![0.0, 2.0 * std::f64::consts::FRAC_PI_3], vec![-0.5, 1.0]];
        let mut record = CalibrationRecord {
            table: Some(table.clone()),
            fitted_to: vec![FittedTable { table, joints }],
            ..calibrated(12, 1.25)
        };
        record.model.is_doubtful = true;
        let text = corrected_robot(&path, &output, &corrections, &record, &[], DATE).unwrap();
        assert!(
            text.starts_with("# my arm\n") && text.contains("urdf: ../../two-link.urdf"),
            "{text}"
        );
        assert_eq!(text.matches("corrections:").count(), 1);
        assert_eq!(text.matches("calibration:").count(), 1);
        std::fs::write(&output, &text).unwrap();
        let read = load(&output).unwrap();
        let expected: Vec<Correction> = corrections.iter().map(|c| c.correction.clone()).collect();
        assert_eq!(read.description.corrections, expected);
        let calibration = read.robot.calibration().unwrap();
        assert_eq!((calibration.poses, calibration.heldout_rms_percent), (12, 1.25));
        // Intervals, tables, notes and poses are read as they were written.
        assert_eq!(read.corrections, corrections);
        assert_eq!(read.calibration, Some(record.clone()));
        // Twice the same: nothing piles up.
        let again =
            corrected_robot(&output, &output, &read.corrections, &record, &[], DATE).unwrap();
        assert_eq!(again, text);
    }

    /// Where corrections stand in the file, and with which comments: the file stays YAML, the
    /// comments stay.
    #[test]
    fn comments_and_line_ends_stay() {
        let calibrated = calibrated(7, 2.5);
        let old = "corrections:   # by hand\n# in column 0\n  - cause: payload\n    at: tool0\n# \
            within\n    parameters: {mass_kg: 1.5} # kg\n# behind\n";
        let braces = "calibration: {\n  poses: 3, heldout_rms_percent: 1\n}\n";
        let own = |line: &str| !line.starts_with("calibration");
        let rest: String = plain().lines().filter(|l| own(l)).map(|l| format!("{l}\n")).collect();
        for end in ["\n", "\r\n"] {
            let yaml = format!("{braces}{rest}{old}").replace('\n', end);
            let (_folder, path) = two_link::folder(&yaml, two_link::URDF);
            let new = [correction(Cause::Payload, "tool0", "mass_kg", 4.9)];
            let text = corrected_robot(&path, &path, &new, &calibrated, &[], DATE).unwrap();
            for comment in ["# by hand", "# in column 0", "# within", "# kg", "# behind"] {
                assert_eq!(text.matches(comment).count(), 1, "{comment}: {text}");
            }
            assert_eq!(text.matches('\n').count(), text.matches(end).count(), "{text:?}");
            std::fs::write(&path, &text).unwrap();
            let read = load(&path).unwrap();
            assert_eq!(read.description.corrections, [new[0].correction.clone()]);
            assert_eq!(read.robot.calibration().unwrap().poses, 7);
        }
    }

    /// In braces and on lines of their own, in place of what was there and beside it.
    #[test]
    fn damping_goes_to_the_springs() {
        let learned = [("joint_1".to_owned(), 0.041), ("joint_2".to_owned(), 0.0175)];
        let at = plain().find("  joints:").unwrap();
        let end = at + plain()[at..].find("joint_2: ").unwrap();
        let end = end + plain()[end..].find('\n').unwrap() + 1;
        let lines = "  joints:\n    joint_1:\n      stiffness_nm_per_rad: 555000 # load test\n    \
                     joint_2:\n      stiffness_nm_per_rad: 138000\n      damping_ratio: 0.3\n";
        let on_lines = format!("{}{lines}{}", &plain()[..at], &plain()[end..]);
        for yaml in [plain(), on_lines] {
            let (_folder, path) = two_link::folder(&yaml, two_link::URDF);
            let text =
                corrected_robot(&path, &path, &[], &calibrated(7, 2.5), &learned, DATE).unwrap();
            std::fs::write(&path, &text).unwrap();
            let springs = load(&path).unwrap().description.elastic_joints;
            for (spring, (joint, zeta)) in springs.iter().zip(&learned) {
                assert_eq!((&spring.joint, spring.damping), (joint, Some(Damping::Ratio(*zeta))));
            }
        }
    }

    /// What cannot be edited is refused, not damaged.
    #[test]
    fn a_file_that_would_not_be_read_as_asked_is_not_written() {
        let calibrated = calibrated(7, 2.5);
        let (_folder, path) = two_link::folder(&format!("{}...\n", plain()), two_link::URDF);
        let notes = corrected_robot(&path, &path, &[], &calibrated, &[], DATE).unwrap_err();
        assert!(notes[0].what.starts_with("is not written: read again, "), "{}", notes[0]);
    }

    #[test]
    fn faults_of_corrections_have_their_line() {
        let yaml = format!(
            "{}corrections:\n  - {{cause: paylaod, at: tool0}}\n  - {{cause: payload, at: tool0, \
             parameters: {{mas_kg: 1}}}}\n",
            plain()
        );
        let (_folder, path) = two_link::folder(&yaml, two_link::URDF);
        let first = 1 + yaml.lines().position(|l| l.contains("paylaod")).unwrap();
        let notes = load(&path).unwrap_err();
        assert_eq!(notes[0].place.line, Some(first));
        assert!(notes[0].what.ends_with("did you mean 'payload'?"), "{}", notes[0]);
        assert_eq!(notes[1].place.line, Some(first + 1));
        assert!(notes[1].what.contains("'mas_kg' is no parameter of payload"), "{}", notes[1]);
        let yaml = format!(
            "{}corrections:\n  - {{cause: payload, at: nowhere, parameters: {{mass_kg: 1}}}}\n",
            plain()
        );
        let (_folder, path) = two_link::folder(&yaml, two_link::URDF);
        let notes = load(&path).unwrap_err();
        assert!(notes[0].what.contains("at is 'nowhere'"), "{}", notes[0]);
    }
}
