//! robot.yaml and its URDF → the model.

use std::path::Path;

use nalgebra::Vector3;

use super::calibration::{CalibrationRecord, FittedCorrection, FittedTable, TableName};
use super::files::{MAX_ROBOT_BYTES, named_file};
use super::inertials::{links, tensor};
use super::kind::{FileKind, document_of};
use super::posterior::posterior;
use super::raw::robot as raw;
use super::urdf::{Urdf, read_urdf};
use super::{Reading, schema};
use crate::formats::text::read_text;
use crate::formats::yaml::{Node, Step};
use crate::model::{
    ArmAngle, Calibration, Carries, Cause, CoordinateKind, Correction, Damping, Description, Drive,
    ElasticJoint, ExtraCoordinate, Hinge, Inertial, JointKind, Payload, Robot, doubts,
};
use crate::notes::{Code, Note, Notes, Part, Place};
use crate::units::{STANDARD_GRAVITY_M_PER_S2, ratio_from_percent};
use crate::wording::hint;

/// Reads a robot.yaml and the URDF that it names.
///
/// # Errors
/// Every fault of both files, each with its line: first those of the YAML, then those of the URDF.
pub fn read_robot(path: &Path, reading: &mut Reading) -> Result<Robot, Vec<Note>> {
    read_described_robot(path, reading).map(|described| described.robot)
}

/// A robot and the description that it was built from.
#[derive(Debug, Clone, PartialEq)]
pub struct DescribedRobot {
    /// The model.
    pub robot: Robot,
    /// What it was built from, which a diagnosis varies.
    pub description: Description,
    /// The corrections of the description, each with where it comes from.
    pub corrections: Vec<FittedCorrection>,
    /// What the file says of its calibration.
    pub calibration: Option<CalibrationRecord>,
}

/// As [`read_robot`], keeping the description.
///
/// # Errors
/// As [`read_robot`].
pub fn read_described_robot(
    path: &Path,
    reading: &mut Reading,
) -> Result<DescribedRobot, Vec<Note>> {
    let text = read_text(path, MAX_ROBOT_BYTES).map_err(|note| {
        reading.files.push(path.to_owned());
        vec![note]
    })?;
    described_robot_of_text(path, &text, reading)
}

/// The robot that `text` would be if it stood in the file `path`.
pub(super) fn described_robot_of_text(
    path: &Path,
    text: &str,
    reading: &mut Reading,
) -> Result<DescribedRobot, Vec<Note>> {
    reading.files.push(path.to_owned());
    let mut notes = Notes::about(Place::file(path));
    let schema = schema::of::<raw::Robot>();
    let Some((tree, raw)) = document_of::<raw::Robot>(FileKind::Robot, text, &schema, &mut notes)
    else {
        return Err(reading.settle(notes));
    };
    let named = raw.urdf.as_deref().and_then(|name| {
        let line = tree.line_at(&[Step::Key("urdf")]);
        named_file(path, "urdf", name, line, &mut notes)
    });
    let Some(urdf_path) = named else {
        // The faults that need no URDF all the same.
        describe(&raw, &tree, None, &mut notes);
        return Err(reading.settle(notes));
    };
    reading.files.push(urdf_path.clone());
    let mut urdf_notes = Notes::about(Place::file(&urdf_path));
    let Some(urdf) = read_urdf(&urdf_path, &mut urdf_notes) else {
        describe(&raw, &tree, None, &mut notes);
        let mut errors = reading.settle(notes);
        errors.extend(reading.settle(urdf_notes));
        return Err(errors);
    };
    let mut description = describe(&raw, &tree, Some(&urdf), &mut notes);
    let sound = notes.errors() == 0 && urdf_notes.errors() == 0;
    let mut files = Files { tree: &tree, urdf: &urdf, yaml: notes, xml: urdf_notes };
    let shared = raw.total_mass_kg.filter(|_| sound).map(|total| description.share_mass(total));
    if let Some(Ok(note) | Err(note)) = &shared {
        files.add(note);
    }
    let unshared = tree.get("total_mass_kg").is_some() && !matches!(shared, Some(Ok(_)));
    let built = Robot::new(&description);
    match &built {
        Ok(robot) => {
            // A stand-in for what is at fault is no figure of the files.
            let doubts = if sound { doubts(&description, robot, rigid(&raw)) } else { Vec::new() };
            let guessed = assumed_springs(&raw);
            let own = robot.warnings().iter().chain(&doubts).chain(&guessed);
            own.for_each(|warning| files.add(warning));
        }
        Err(faults) => {
            let own = faults
                .iter()
                .filter(|f| sound || !follows_from_others(f, urdf.damaged))
                .filter(|f| !(unshared && f.code == Code::NotElastic));
            own.for_each(|fault| files.add(fault));
        }
    }
    let Files { yaml, xml, .. } = files;
    let mut errors = reading.settle(yaml);
    errors.extend(reading.settle(xml));
    match built {
        Ok(robot) if errors.is_empty() => {
            let corrections = fitted_corrections(&raw, &description);
            let calibration = raw
                .calibration
                .as_ref()
                .zip(description.calibration.clone())
                .map(|(raw, model)| calibration_record(raw, model));
            Ok(DescribedRobot { robot, description, corrections, calibration })
        }
        _ => Err(errors),
    }
}

/// Whether a fault of the model may be the consequence of what was left out for another fault.
fn follows_from_others(fault: &Note, damaged: bool) -> bool {
    match (&fault.place.part, fault.place.key) {
        (Some(Part::Robot | Part::Correction(_)), _) => true,
        (Some(Part::Link(_) | Part::Joint(_) | Part::Payload), key) => {
            damaged && !matches!(key, "mass" | "com" | "inertia" | "axis" | "origin" | "limit")
        }
        (_, key) => damaged && (key.is_empty() || matches!(key, "base" | "tip" | "link" | "terms")),
    }
}

/// Both files of a robot, to turn symbolic places into file and line.
struct Files<'r> {
    tree: &'r Node,
    urdf: &'r Urdf,
    yaml: Notes,
    xml: Notes,
}

impl Files<'_> {
    fn add(&mut self, fault: &Note) {
        if self.xml.is_full() || self.yaml.is_full() {
            // Counted only: to find each line takes time.
            self.xml.error(Code::Value, None, "");
            return;
        }
        let (in_urdf, line) = self.locate(fault);
        let what = self.message(fault);
        let notes = if in_urdf { &mut self.xml } else { &mut self.yaml };
        notes.push(notes.make(fault.severity, fault.code, line, what));
    }

    fn message(&self, fault: &Note) -> String {
        let name = match fault.place.part {
            Some(Part::Extra(index)) => {
                use Step::{Index, Key};
                let steps = [Key("elasticity"), Key("extra"), Index(index), Key("name")];
                self.tree.at(&steps).and_then(Node::text)
            }
            _ => None,
        };
        match (&fault.place.part, name) {
            (_, Some(name)) => format!("extra coordinate '{name}': {}", fault.what),
            (Some(Part::Robot), _) => fault.what.clone(),
            _ => fault.to_string(),
        }
    }

    /// Whether it lies in the URDF, and its line.
    fn locate(&self, fault: &Note) -> (bool, usize) {
        use Step::{Index, Key};
        let yaml = |steps: &[Step<'_>]| (false, self.tree.line_at(steps));
        let key = fault.place.key;
        // As robot.yaml spells it.
        let body_key = match key {
            "mass" => "mass_kg",
            "com" => "com_m",
            "inertia" => "inertia_kgm2",
            key => key,
        };
        let Some(part) = &fault.place.part else { return yaml(&[]) };
        match part {
            Part::Link(name) => match self.tree.at(&[Key("inertials"), Key(name)]) {
                Some(own) if own.get(body_key).is_some() => (false, own.line_at(&[Key(body_key)])),
                _ => (true, self.urdf.link_line(name, key)),
            },
            Part::Joint(name) => (true, self.urdf.joint_line(name, key)),
            Part::Robot if key.is_empty() => (true, self.urdf.line()),
            Part::Robot => yaml(&[Key(key)]),
            Part::Base => yaml(&[Key("base")]),
            Part::Tip => yaml(&[Key("tip")]),
            Part::ElasticJoint(name) => {
                yaml(&[Key("elasticity"), Key("joints"), Key(name), Key(key)])
            }
            Part::Extra(index) => yaml(&[Key("elasticity"), Key("extra"), Index(*index), Key(key)]),
            Part::Damping | Part::Gravity => yaml(&[Key("elasticity"), Key(key)]),
            Part::Drive(name) => yaml(&[Key("drives"), Key(name), Key(key)]),
            Part::Payload => yaml(&[Key("payload"), Key(body_key)]),
            Part::ArmAngle(angle) => yaml(&[Key("arm_angles"), Key(angle), Key(key)]),
            Part::Correction(index) => {
                let own = [Key("corrections"), Index(*index)];
                // A parameter's name, or a key of the correction itself.
                let found = self.tree.at(&own).and_then(|own| own.get(key)).is_some();
                let steps = if found { &[Key(key)][..] } else { &[Key("parameters"), Key(key)] };
                if key.is_empty() { yaml(&own) } else { yaml(&[&own[..], steps].concat()) }
            }
            _ => yaml(&[]),
        }
    }
}

/// The description that raw YAML and URDF make together. What an error is about is replaced by
/// a harmless stand-in, so that the model can still be asked for further faults.
fn describe(raw: &raw::Robot, tree: &Node, urdf: Option<&Urdf>, notes: &mut Notes) -> Description {
    let none = raw::Elasticity::default();
    let elasticity = raw.elasticity.as_ref().unwrap_or(&none);
    let gravity = elasticity.gravity_m_per_s2.unwrap_or([0.0, 0.0, -STANDARD_GRAVITY_M_PER_S2]);
    Description {
        name: raw
            .name
            .clone()
            .or_else(|| urdf.and_then(|urdf| urdf.name.clone()))
            .unwrap_or_else(|| "robot".to_owned()),
        links: urdf.map_or_else(Vec::new, |urdf| links(raw, tree, &urdf.links, notes)),
        joints: urdf.map_or_else(Vec::new, |urdf| urdf.joints.clone()),
        base: raw.base.clone(),
        tip: raw.tip.clone(),
        elastic_joints: elastic_joints(elasticity, tree, urdf, notes),
        extra: extras(elasticity, tree, urdf, notes),
        default_damping_ratio: elasticity.damping_ratio.unwrap_or(0.02),
        gravity_m_per_s2: gravity.into(),
        gravity_stiffness: elasticity.gravity.unwrap_or(false),
        drives: raw
            .drives
            .iter()
            .flatten()
            .map(|(joint, drive)| Drive {
                joint: joint.clone(),
                reflected_inertia_kgm2: drive.reflected_inertia_kgm2.unwrap_or(0.0),
                std: drive.std_percent.map(ratio_from_percent),
            })
            .collect(),
        payload: raw.payload.as_ref().and_then(payload),
        beta1: raw.arm_angles.as_ref().and_then(|angles| arm_angle(angles.beta1.as_ref()?)),
        beta2: raw.arm_angles.as_ref().and_then(|angles| arm_angle(angles.beta2.as_ref()?)),
        corrections: corrections(raw, tree, notes),
        calibration: raw.calibration.as_ref().and_then(|calibration| {
            let joints = urdf
                .map_or(0, |urdf| urdf.joints.iter().filter(|joint| joint.kind.moves()).count());
            let learned = calibration.posterior.as_ref();
            Some(Calibration {
                poses: usize::try_from(calibration.poses?).ok()?,
                heldout_rms_percent: calibration.heldout_rms_percent?,
                is_doubtful: calibration.doubtful.unwrap_or(false),
                posterior: learned.and_then(|learned| posterior(learned, joints, tree, notes)),
            })
        }),
    }
}

fn corrections(raw: &raw::Robot, tree: &Node, notes: &mut Notes) -> Vec<Correction> {
    let mut corrections = Vec::new();
    for (index, raw) in raw.corrections.iter().flatten().enumerate() {
        let line = tree.line_at(&[Step::Key("corrections"), Step::Index(index)]);
        let owner = format!("correction {}", index + 1);
        let Some(name) = &raw.cause else { continue };
        let Some(cause) = Cause::named(name) else {
            let hint = hint(name, Cause::ALL.map(Cause::name));
            notes.error(
                Code::Reference,
                line,
                format!("{owner}: cause is '{name}', which is not known{hint}"),
            );
            continue;
        };
        let known = Correction::parameter_names(cause);
        for parameter in raw.parameters.iter().flatten().map(|(name, _)| name) {
            if !known.contains(&parameter.as_str()) {
                let of = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                let what =
                    format!("{owner}: '{parameter}' is no parameter of {cause}; it has {of}");
                notes.error(Code::UnknownKey, line, what);
            }
        }
        let hinge = raw.axes.as_ref().map(|axes| Hinge {
            kind: match raw.kind {
                Some(raw::ExtraKind::Translation) => CoordinateKind::Translation,
                None if cause == Cause::LocalMode => CoordinateKind::Translation,
                _ => CoordinateKind::Rotation,
            },
            axes: axes.iter().map(|&axis| axis.into()).collect(),
            origin_m: raw.origin_m.map_or(Vector3::zeros(), Vector3::from),
            carries: match raw.carries {
                None | Some(raw::HingeCarries::Link) => Carries::Link,
                Some(raw::HingeCarries::Part) => Carries::Part,
                Some(raw::HingeCarries::Rest) => Carries::Rest,
            },
        });
        let parameters =
            raw.parameters.iter().flatten().map(|(name, &value)| (name.clone(), value)).collect();
        corrections.push(Correction { cause, at: raw.at.clone(), parameters, hinge });
    }
    corrections
}

/// The corrections of a sound file, each with where it comes from.
fn fitted_corrections(raw: &raw::Robot, description: &Description) -> Vec<FittedCorrection> {
    let both = raw.corrections.iter().flatten().zip(&description.corrections);
    both.map(|(raw, correction)| FittedCorrection {
        correction: correction.clone(),
        ci95: raw.ci95.iter().flatten().map(|(name, &ci95)| (name.clone(), ci95)).collect(),
        table: raw.table.clone(),
        note: raw.note.clone(),
    })
    .collect()
}

fn calibration_record(raw: &raw::Calibration, model: Calibration) -> CalibrationRecord {
    let table = |file: &Option<String>, digest: &Option<String>| {
        Some(TableName { file: file.clone().unwrap_or_default(), digest: digest.clone()? })
    };
    let fitted_to = raw.fitted_to.iter().flatten().filter_map(|fitted| {
        let table = table(&fitted.file, &fitted.digest)?;
        Some(FittedTable { table, joints: fitted.joints.clone()? })
    });
    CalibrationRecord {
        model,
        table: raw.table.as_ref().and_then(|named| table(&named.file, &named.digest)),
        fitted_to: fitted_to.collect(),
    }
}

fn elastic_joints(
    elasticity: &raw::Elasticity,
    tree: &Node,
    urdf: Option<&Urdf>,
    notes: &mut Notes,
) -> Vec<ElasticJoint> {
    check_rigid(elasticity, tree, urdf, notes);
    let mut springs = Vec::new();
    for (name, spring) in elasticity.joints.iter().flatten() {
        let steps = [Step::Key("elasticity"), Step::Key("joints"), Step::Key(name)];
        let Some(node) = tree.at(&steps) else { continue };
        let line = tree.line_at(&steps);
        let slides = urdf
            .and_then(|urdf| urdf.joints.iter().find(|joint| joint.name == *name))
            .map(|joint| joint.kind == JointKind::Prismatic);
        let owner = format!("joint '{name}'");
        let given = [
            given(node, "stiffness_nm_per_rad", spring.stiffness_nm_per_rad),
            given(node, "stiffness_n_per_m", spring.stiffness_n_per_m),
        ];
        match given {
            [true, true] => {
                let what = "has both stiffness_nm_per_rad and stiffness_n_per_m, must have one";
                notes.error(Code::Conflict, line, format!("{owner}: {what}"));
            }
            [false, false] => {
                let key =
                    if slides == Some(true) { "stiffness_n_per_m" } else { "stiffness_nm_per_rad" };
                notes.error(Code::MissingKey, line, format!("{owner}: missing key '{key}'"));
            }
            _ => {}
        }
        springs.push(ElasticJoint {
            joint: name.clone(),
            stiffness: spring.stiffness_nm_per_rad.or(spring.stiffness_n_per_m).unwrap_or(1.0),
            is_linear: match given {
                [true, false] => false,
                [false, true] => true,
                _ => slides.unwrap_or(false),
            },
            std: spring.std_percent.map(ratio_from_percent),
            damping: damping(
                &owner,
                node,
                line,
                [spring.damping_ratio, spring.damping_nms_per_rad, spring.damping_ns_per_m],
                slides,
                notes,
            ),
        });
    }
    springs
}

fn extras(
    elasticity: &raw::Elasticity,
    tree: &Node,
    urdf: Option<&Urdf>,
    notes: &mut Notes,
) -> Vec<ExtraCoordinate> {
    let steps = [Step::Key("elasticity"), Step::Key("extra")];
    let nodes = tree.at(&steps).map_or(&[][..], Node::items);
    let any_link = urdf.and_then(|urdf| urdf.links.first()).map_or("", |link| link.name.as_str());
    elasticity
        .extra
        .iter()
        .flatten()
        .zip(nodes)
        .enumerate()
        .map(|(index, (extra, node))| {
            let name = extra.name.clone().unwrap_or_else(|| format!("extra {}", index + 1));
            let slides = extra.kind.map(|kind| matches!(kind, raw::ExtraKind::Translation));
            let owner = format!("extra coordinate '{name}'");
            let damping = damping(
                &owner,
                node,
                node.line as usize,
                [extra.damping_ratio, extra.damping_nms_per_rad, extra.damping_ns_per_m],
                slides,
                notes,
            );
            ExtraCoordinate {
                name,
                link: extra.link.clone().unwrap_or_else(|| any_link.to_owned()),
                kind: if slides == Some(true) {
                    CoordinateKind::Translation
                } else {
                    CoordinateKind::Rotation
                },
                axis: extra.axis.map_or(Vector3::x(), Vector3::from),
                origin_m: extra.origin_m.map_or(Vector3::zeros(), Vector3::from),
                stiffness: extra.stiffness.unwrap_or(1.0),
                std: extra.std_percent.map(ratio_from_percent),
                damping,
            }
        })
        .collect()
}

/// Each of `rigid` is a moving joint without a spring.
fn check_rigid(elasticity: &raw::Elasticity, tree: &Node, urdf: Option<&Urdf>, notes: &mut Notes) {
    for (index, name) in elasticity.rigid.iter().flatten().enumerate() {
        let line = tree.line_at(&[Step::Key("elasticity"), Step::Key("rigid"), Step::Index(index)]);
        let mut error = |code, what: String| {
            notes.error(code, line, format!("elasticity.rigid: '{name}' {what}"));
        };
        if elasticity.joints.iter().flatten().any(|(joint, _)| joint == name) {
            error(Code::Conflict, "has a spring under elasticity.joints, must have one".to_owned());
        }
        let moving = || {
            let joints = urdf.into_iter().flat_map(|urdf| &urdf.joints);
            joints.filter(|joint| joint.kind.moves()).map(|joint| joint.name.as_str())
        };
        if urdf.is_some() && !moving().any(|joint| joint == name) {
            let hint = hint(name, moving());
            error(Code::Reference, format!("is no moving joint of the URDF{hint}"));
        }
    }
}

/// Springs that the file itself calls a guess, and that no measurement has judged since.
fn assumed_springs(raw: &raw::Robot) -> Option<Note> {
    let joints = raw.elasticity.as_ref()?.joints.as_ref()?;
    /// What people write for a source that is none.
    const NO_SOURCES: [&str; 8] =
        ["assumed", "assumption", "guess", "guessed", "estimate", "estimated", "unknown", "tbd"];
    let is_none = |source: &String| {
        let plain = source.trim().trim_end_matches('.').to_lowercase();
        NO_SOURCES.contains(&plain.as_str())
    };
    let guessed = joints.iter().filter(|(_, spring)| {
        spring.assumed.unwrap_or_else(|| spring.source.as_ref().is_some_and(is_none))
    });
    let names: Vec<&str> = guessed.map(|(name, _)| name.as_str()).collect();
    // A figure alone measures no spring.
    let is_measured = raw.calibration.as_ref().is_some_and(|own| own.posterior.is_some());
    if names.is_empty() || is_measured {
        return None;
    }
    let what = format!(
        "springs that are guesses: {}; put in your own numbers and delete 'assumed'",
        names.join(", ")
    );
    let place = Place::key(Part::Robot, "elasticity");
    Some(Note::warning(Code::AssumedSpring, place, what))
}

/// The joints that are meant to be rigid.
fn rigid(raw: &raw::Robot) -> &[String] {
    raw.elasticity.as_ref().and_then(|elasticity| elasticity.rigid.as_deref()).unwrap_or(&[])
}

/// The damping of a coordinate from [ratio, viscous of a rotation, viscous of a translation].
fn damping(
    owner: &str,
    node: &Node,
    line: usize,
    values: [Option<f64>; 3],
    slides: Option<bool>,
    notes: &mut Notes,
) -> Option<Damping> {
    const KEYS: [&str; 3] = ["damping_ratio", "damping_nms_per_rad", "damping_ns_per_m"];
    let given: Vec<&str> = KEYS
        .into_iter()
        .zip(values)
        .filter(|&(key, value)| given(node, key, value))
        .map(|(key, _)| key)
        .collect();
    if given.len() > 1 {
        notes.error(
            Code::Conflict,
            line,
            format!("{owner}: has {}, must have one of them", given.join(" and ")),
        );
    }
    let misfit = match slides {
        Some(true) => Some((KEYS[1], KEYS[2], "moves along its axis")),
        Some(false) => Some((KEYS[2], KEYS[1], "turns about its axis")),
        None => None,
    };
    if let Some((wrong, right, motion)) = misfit
        && given.contains(&wrong)
    {
        let line = node.line_at(&[Step::Key(wrong)]);
        notes.error(
            Code::Conflict,
            line,
            format!("{owner}: {wrong} given, must be {right}, as it {motion}"),
        );
    }
    let [ratio, turning, sliding] = values;
    ratio.map(Damping::Ratio).or(turning.or(sliding).map(Damping::Viscous))
}

/// Whether a key has a value, be it a faulty one.
fn given(node: &Node, key: &str, value: Option<f64>) -> bool {
    value.is_some() || node.get(key).is_some_and(|value| value.faulty)
}

fn payload(raw: &raw::Payload) -> Option<Payload> {
    Some(Payload { link: raw.link.clone()?, inertial: inertial(&raw.body) })
}

/// A body as files give it; what is missing was reported.
pub(super) fn inertial(body: &raw::Body) -> Inertial {
    Inertial {
        mass_kg: body.mass_kg.unwrap_or(1.0),
        com_m: body.com_m.map_or(Vector3::zeros(), Vector3::from),
        inertia_kgm2: body.inertia_kgm2.as_ref().and_then(tensor).unwrap_or_default(),
    }
}

fn arm_angle(raw: &raw::ArmAngle) -> Option<ArmAngle> {
    let terms = raw.terms.as_ref()?;
    Some(ArmAngle {
        terms: terms.iter().map(|(joint, &factor)| (joint.clone(), factor)).collect(),
        offset_rad: raw.offset_rad.unwrap_or(0.0),
    })
}

#[cfg(test)]
pub(super) mod tests {
    use std::path::PathBuf;

    use super::*;

    /// The two-link arm of Pietruś & Gierlak (2023), Table 1.
    pub(in crate::input) const URDF: &str = include_str!("../../tests/data/bad/two-link.urdf");
    pub(in crate::input) const YAML: &str = include_str!("../../tests/data/bad/robot.yaml");

    /// A folder with robot.yaml and two-link.urdf in it.
    pub(in crate::input) fn folder(yaml: &str, urdf: &str) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("two-link.urdf"), urdf).unwrap();
        let path = folder.path().join("robot.yaml");
        std::fs::write(&path, yaml).unwrap();
        (folder, path)
    }

    fn load(yaml: &str, urdf: &str) -> Result<(Robot, Vec<Note>), Vec<String>> {
        let (folder, path) = folder(yaml, urdf);
        let prefix = format!("{}/", folder.path().display());
        let mut reading = Reading::default();
        read_robot(&path, &mut reading)
            .map(|robot| (robot, reading.warnings))
            .map_err(|notes| notes.iter().map(|f| f.to_string().replace(&prefix, "")).collect())
    }

    #[test]
    fn the_two_link_arm_is_read_with_all_it_says() {
        let (robot, warnings) = load(YAML, URDF).unwrap();
        assert!(warnings.is_empty(), "{warnings:?}");
        assert_eq!(robot.name(), "Two-link section");
        assert_eq!(robot.tip_link(), "tool0");
        let springs: Vec<f64> = robot.coordinates().iter().map(|c| c.stiffness).collect();
        assert_eq!(springs, [555_000.0, 138_000.0]);
        assert_eq!(robot.coordinates()[1].damping, Damping::Viscous(12.5));
        assert_eq!(robot.coordinates()[0].damping, Damping::Ratio(0.03));
        assert_eq!(robot.beta2().unwrap().at(&[0.0, 1.5]), 1.75);
        let calibration = robot.calibration().unwrap();
        assert_eq!((calibration.poses, calibration.heldout_rms_percent), (20, 4.4));
    }

    #[test]
    fn faults_of_both_files_are_told_at_once() {
        let yaml = YAML
            .replace("stiffness_nm_per_rad: 555000", "stiffness_nm_per_rad: -1.2e5")
            .replace("joint_2: {stiff", "joint_3: {stiff")
            .replace("payload:", "paylaod:");
        let urdf =
            URDF.replace("iyy=\"0.30\"", "iyy=\"3.0\"").replace("xyz=\"0 -1 0\"", "xyz=\"0 y 0\"");
        let line = |text: &str, of: &str| 1 + text.lines().position(|l| l.contains(of)).unwrap();
        let notes = load(&yaml, &urdf).unwrap_err();
        let expected = [
            format!(
                "robot.yaml:{}: joint 'joint_1': stiffness_nm_per_rad is -1.2e5, must be positive \
                    and finite",
                line(&yaml, "-1.2e5")
            ),
            format!(
                "robot.yaml:{}: joint 'joint_3': the URDF has no such joint; it has joint_1, \
                    joint_2; did you mean 'joint_2'?",
                line(&yaml, "joint_3:")
            ),
            format!(
                "robot.yaml:{}: unknown key 'paylaod'; did you mean 'payload'?",
                line(&yaml, "paylaod")
            ),
            format!(
                "two-link.urdf:{}: link 'link_1': inertia fails the triangle inequality (ixx 0.005 \
                    + izz 0.3 < iyy 3 kg·m²); check the units of the CAD export",
                line(&urdf, "iyy=\"3.0\"")
            ),
        ];
        for part in &expected {
            assert!(notes.contains(part), "{part}\nnot in\n{}", notes.join("\n"));
        }
        let axes = notes.iter().filter(|fault| fault.contains("<axis> xyz is \"0 y 0\"")).count();
        assert_eq!((axes, notes.len()), (2, 6), "{}", notes.join("\n"));
    }

    #[test]
    fn a_faulty_urdf_does_not_hide_the_faults_of_the_yaml() {
        let yaml = YAML.replace("damping_nms_per_rad", "damping_ratio: 0.1, damping_nms_per_rad");
        let notes = load(&yaml, "<robot>").unwrap_err();
        assert_eq!(notes.len(), 2, "{notes:?}");
        assert!(notes[0].contains("has damping_ratio and damping_nms_per_rad"), "{notes:?}");
        assert!(notes[1].starts_with("two-link.urdf:1: not valid XML"), "{notes:?}");
    }

    #[test]
    fn notices_have_a_place_in_a_file() {
        let urdf = URDF.replace("lower=\"-3.2\" upper=\"3.2\"", "");
        let (_, notices) = load(YAML, &urdf).unwrap();
        assert_eq!(notices.len(), 2);
        let line = 1 + urdf.lines().position(|l| l.contains("<limit")).unwrap();
        assert_eq!(notices[0].place.line, Some(line));
        assert!(notices[0].what.contains("joint 'joint_1': has no <limit>"), "{}", notices[0]);
    }
}
