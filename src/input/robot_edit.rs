//! A robot.yaml with corrections and calibration put in: the text is kept, comments and all, but for the
//! two blocks and, where the new file lies in another folder, the path of the URDF.

use crate::notes::{Code, Note, Notes, Place};
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

use super::text::{LARGEST_ROBOT_BYTES, read_text, without_detours};
use super::yaml::{Node, parse};
use crate::model::{Carries, CoordinateKind, Correction};

/// A correction with how sure it is.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedCorrection {
    /// What the model takes.
    pub correction: Correction,
    /// 95 % interval of each parameter, by name; none for what was there before.
    pub ci95: Vec<(String, [f64; 2])>,
}

/// What the calibration block says.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrated {
    /// Number of poses.
    pub poses: usize,
    /// Held-out error, %.
    pub heldout_rms_percent: f64,
    /// Day, as YYYY-MM-DD.
    pub date: String,
}

/// The text of the robot file at `path` with these corrections and this calibration in place of its own,
/// to be written to `output`.
///
/// # Errors
/// The file cannot be read, or is written in braces as a whole.
pub fn corrected_robot(
    path: &Path,
    output: &Path,
    corrections: &[FittedCorrection],
    calibration: &Calibrated,
) -> Result<String, Vec<Note>> {
    let text = read_text(path, LARGEST_ROBOT_BYTES).map_err(|fault| vec![fault])?;
    let mut notes = Notes::about(Place::file(path));
    let Some(tree) = parse(&text, &mut notes) else { return Err(notes.finish().0) };
    let lines: Vec<&str> = text.lines().collect();
    if lines.iter().any(|line| line.starts_with('{')) {
        let what = "is written in braces, which cannot be edited; write its keys one a line";
        return Err(vec![Note::error(Code::NotRewritten, Place::line(path, 1), what)]);
    }
    let replaced: Vec<std::ops::Range<usize>> =
        ["corrections", "calibration"].iter().filter_map(|key| span(&tree, &lines, key)).collect();
    let urdf =
        tree.entry("urdf").and_then(|entry| Some((entry.line as usize - 1, entry.value.text()?)));
    let mut out = String::new();
    for (i, line) in lines.iter().enumerate() {
        if replaced.iter().any(|range| range.contains(&i)) {
            continue;
        }
        match &urdf {
            Some((at, name)) if *at == i => match moved(path, output, name) {
                Some(moved) => out.push_str(&with_value(line, name, &moved).ok_or_else(|| {
                    let what = format!(
                        "urdf is '{name}', written in a way that cannot be edited; write it on one line, as it is"
                    );
                    vec![Note::error(Code::NotRewritten, Place::line(path, *at + 1), what)]
                })?),
                None => out.push_str(line),
            },
            _ => out.push_str(line),
        }
        out.push('\n');
    }
    while out.ends_with("\n\n") {
        out.pop();
    }
    out.push_str(&blocks(corrections, calibration));
    Ok(out)
}

/// A line "key: value" with another value, quoted where it must be; `None` if the value does not stand there as it is.
fn with_value(line: &str, old: &str, new: &str) -> Option<String> {
    let colon = line.find(':')? + 1;
    let (key, value) = line.split_at(colon);
    let at = value.find(old)?;
    let (before, rest) = value.split_at(at);
    let after = &rest[old.len()..];
    let mark = before.chars().next_back().filter(|mark| matches!(mark, '\'' | '"'));
    let (before, after) = match mark {
        Some(mark) => (before.strip_suffix(mark)?, after.strip_prefix(mark)?),
        None => (before, after),
    };
    Some(format!("{key}{before}{}{after}", quoted(new)))
}

/// The lines of a top-level key and its value, without the comments and blank lines after it.
fn span(tree: &Node, lines: &[&str], key: &str) -> Option<std::ops::Range<usize>> {
    let start = tree.entry(key)?.line as usize - 1;
    let is_own = |line: &str| line.starts_with([' ', '\t', '-']) && !line.trim().is_empty();
    let mut end = start + 1;
    for (i, line) in lines.iter().enumerate().skip(start + 1) {
        if is_own(line) {
            end = i + 1;
        } else if !line.trim().is_empty() {
            break;
        }
    }
    Some(start..end)
}

/// The two blocks as YAML.
fn blocks(corrections: &[FittedCorrection], calibration: &Calibrated) -> String {
    let mut out = String::new();
    // Writing to a string does not fail.
    if corrections.is_empty() {
        out.push_str("corrections: []\n");
    } else {
        out.push_str("corrections:\n");
    }
    for FittedCorrection { correction, ci95 } in corrections {
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
    }
    let _ = writeln!(
        out,
        "calibration: {{poses: {}, heldout_rms_percent: {}, date: {}}}",
        calibration.poses, calibration.heldout_rms_percent, calibration.date
    );
    out
}

/// A name as a YAML scalar that stays a string.
fn quoted(name: &str) -> String {
    let begins = name.starts_with(|c: char| c.is_ascii_alphabetic())
        || ["/", "./", "../"].iter().any(|start| name.starts_with(start));
    let plain = begins
        && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-./".contains(c))
        && !matches!(
            name.to_ascii_lowercase().as_str(),
            "true" | "false" | "null" | "yes" | "no" | "on" | "off" | "y" | "n"
        );
    if plain { name.to_owned() } else { format!("'{}'", name.replace('\'', "''")) }
}

/// The URDF that `path` calls `name`, as `output` must call it; `None` where the name stays.
fn moved(path: &Path, output: &Path, name: &str) -> Option<String> {
    if Path::new(name).is_absolute() {
        return None;
    }
    let folder = |file: &Path| -> Option<PathBuf> {
        let folder = file.parent().filter(|f| !f.as_os_str().is_empty());
        folder.unwrap_or(Path::new(".")).canonicalize().ok()
    };
    let (from, to) = (folder(path)?, folder(output)?);
    if from == to {
        return None;
    }
    let target = without_detours(&from.join(name));
    let (there, here): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (target.components().collect(), to.components().collect());
    let shared = there.iter().zip(&here).take_while(|(a, b)| a == b).count();
    let mut relative = PathBuf::new();
    here[shared..].iter().for_each(|_| relative.push(".."));
    there[shared..].iter().for_each(|part| relative.push(part));
    // A file of another platform reads forward slashes, too.
    Some(relative.to_string_lossy().replace('\\', "/"))
}

#[cfg(test)]
mod tests {
    use super::super::Reading;
    use super::super::robot::{DescribedRobot, read_described_robot, tests as two_link};
    use super::*;
    use crate::model::{Cause, Hinge};
    use nalgebra::Vector3;

    /// A robot's file without corrections.
    fn plain() -> String {
        two_link::YAML.replace("corrections: []\n", "")
    }

    fn load(path: &Path) -> Result<DescribedRobot, Vec<Note>> {
        read_described_robot(path, &mut Reading::default())
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
        }
    }

    #[test]
    fn a_value_is_replaced_where_it_stands() {
        for (line, old, new, expected) in [
            ("urdf: urdf", "urdf", "../urdf", "urdf: ../urdf"),
            ("urdf: arm.urdf # mine", "arm.urdf", "a/arm.urdf", "urdf: a/arm.urdf # mine"),
            ("urdf: 'my arm.urdf'", "my arm.urdf", "../my arm.urdf", "urdf: '../my arm.urdf'"),
            ("urdf: \"a.urdf\"", "a.urdf", "../a.urdf", "urdf: ../a.urdf"),
            ("urdf: a.urdf", "a.urdf", "../x: #1/a.urdf", "urdf: '../x: #1/a.urdf'"),
        ] {
            assert_eq!(with_value(line, old, new).as_deref(), Some(expected));
        }
        assert_eq!(with_value("urdf: >-", "arm.urdf", "../arm.urdf"), None);
        assert_eq!(with_value("urdf: 'it''s.urdf'", "it's.urdf", "../it's.urdf"), None);
    }

    #[test]
    fn names_that_yaml_reads_as_something_else_are_quoted() {
        for name in ["True", "null", "Yes", "n", ".5", ".inf", "1e3", "a b", "x: y", ""] {
            assert!(quoted(name).starts_with('\''), "{name}");
        }
        for name in ["link_1", "../a-b/c.urdf", "./a", "/abs/a.urdf"] {
            assert_eq!(quoted(name), name);
        }
    }

    /// What is written is read again, from another folder, with comments kept and the blocks replaced.
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
        let corrections = [correction(Cause::Payload, "tool0", "mass_kg", 4.9), bends];
        let calibrated =
            Calibrated { poses: 12, heldout_rms_percent: 1.25, date: "2026-11-21".to_owned() };
        let text = corrected_robot(&path, &output, &corrections, &calibrated).unwrap();
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
        // Twice the same: nothing piles up.
        let again = corrected_robot(&output, &output, &corrections, &calibrated).unwrap();
        assert_eq!(again, text);
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
