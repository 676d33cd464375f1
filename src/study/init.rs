//! A URDF → the first files for it: a robot with guessed springs, marked as such, a job, and
//! a CI workflow.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Vector3};
use serde_json::Value;

use super::{Output, Read};
pub use crate::input::{GuessedSpring, NewRobot};
use crate::input::{
    UrdfParts, new_job_text, new_robot_text, read_urdf_alone, repository_of, whole_place,
};
use crate::model::{Inertial, Joint, JointKind};
use crate::notes::{Code, Note, Place};
use crate::paths::{folder_of, from_folder};
use crate::units::{deg_from_rad, mm_from_m};

/// What arms have that were measured or fitted: reach up to which a row is taken, m; springs of the
/// joints up to the elbow and of the wrist, N·m/rad, lowest and highest; where the figures come
/// from. The guide has the same table (`src/guide/your_robot.md`).
const TYPICAL: [(f64, [f64; 2], [f64; 2], &str); 3] = [
    (1.25, [3e4, 9e5], [3e4, 5e4], "KUKA KR10 R1100, fitted"),
    (
        2.0,
        [1.4e5, 5.6e5],
        [3e4, 5e5],
        "joints 2 and 3 of the ABB IRB 1600, load test; wrists between KUKA KR10 and KR210",
    ),
    (f64::INFINITY, [2e6, 9e6], [2e5, 3e6], "KUKA KR210, fitted, and KR500 MT, modal test"),
];

/// Joints from the base that carry the arm; those behind them are the wrist.
const ARM_JOINTS: usize = 3;

/// What `std_percent` holds at most.
const MAX_STD_PERCENT: f64 = 100.0;

/// How far the first job moves, rad.
const SWING_RAD: f64 = 0.1;

/// Axes are level or parallel within this, rad.
const LEVEL: f64 = 1e-3;

/// What CI checks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ci {
    /// A workflow of GitHub Actions.
    Github,
    /// A job of GitLab CI.
    Gitlab,
    /// Nothing.
    None,
}

/// The first files for a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Scaffold {
    /// robot.yaml and the job.
    pub files: Vec<Output>,
    /// The file of the CI.
    pub ci: Option<Output>,
    /// The folder of the jobs, as the CI names it.
    pub jobs: PathBuf,
    /// What was guessed, for people.
    pub guessed: NewRobot,
}

/// A URDF, with what it lacks.
#[derive(Debug, Clone, PartialEq)]
pub struct Urdf {
    file: PathBuf,
    parts: UrdfParts,
    chain: Vec<Joint>,
}

/// Reads a URDF.
///
/// # Errors
/// Its faults, and that no joint of it moves.
pub fn read(file: &Path) -> Read<Urdf> {
    Read::of(|reading| {
        let parts = read_urdf_alone(file, reading)?;
        let chain = chain(&parts);
        if chain.is_empty() {
            let what = "no joint moves, so there is no arm";
            return Err(vec![Note::error(Code::Tree, Place::file(file), what)]);
        }
        Ok(Urdf { file: file.to_owned(), parts, chain })
    })
}

impl Urdf {
    /// Whether nothing that moves has a mass.
    pub fn lacks_mass(&self) -> bool {
        self.mass_kg() == 0.0
    }

    fn mass_kg(&self) -> f64 {
        let moves = |link: &str| self.chain.iter().any(|joint| joint.child == link);
        let links = self.parts.links.iter().filter(|link| moves(&link.name));
        links.filter_map(|link| link.inertial.as_ref()).map(|own| own.mass_kg).sum()
    }
}

/// The first files for a URDF, to be written into a folder. Nothing stands for a mass that nobody
/// gives.
///
/// # Errors
/// A mass that is needed, or not.
pub fn scaffold(
    urdf: &Urdf,
    folder: &Path,
    total_mass_kg: Option<f64>,
    ci: Ci,
) -> Result<Scaffold, Note> {
    match (urdf.lacks_mass(), total_mass_kg) {
        (true, None) => {
            let what = "no link that moves has a mass; give that of the whole arm, from its data \
                        sheet, with --total-mass-kg";
            return Err(Note::error(Code::MissingKey, Place::file(&urdf.file), what));
        }
        (false, Some(_)) => {
            let what = format!(
                "--total-mass-kg: the URDF has masses, {:.1} kg in all; correct links under \
                 inertials instead",
                urdf.mass_kg()
            );
            return Err(Note::usage(what));
        }
        (_, Some(kg)) if !(kg > 0.0 && kg.is_finite()) => {
            return Err(Note::usage(format!("--total-mass-kg: is {kg}, must be above 0")));
        }
        _ => {}
    }
    // A total mass is distributed over all links.
    let carries = |joint: &str| total_mass_kg.is_some() || carries_mass(&urdf.parts, joint);
    let (springs, massless): (Vec<_>, Vec<_>) =
        springs(&urdf.chain).into_iter().partition(|spring| carries(&spring.joint));
    let robot = NewRobot {
        name: urdf.parts.name.clone().unwrap_or_else(|| "My arm".to_owned()),
        urdf: beside(folder, &urdf.file),
        tip: tip(&urdf.parts, &urdf.chain),
        springs,
        sliding: sliding(&urdf.chain),
        massless: massless.into_iter().map(|spring| spring.joint).collect(),
        total_mass_kg,
        arm_angles: arm_angles(&urdf.chain),
    };
    let [start, end] = motion(&urdf.chain);
    let outputs = vec![
        Output::new(&folder.join("robot.yaml"), new_robot_text(&robot).into_bytes()),
        Output::new(
            &folder.join("jobs/first.yaml"),
            new_job_text("../robot.yaml", &start, &end).into_bytes(),
        ),
    ];
    let place = whole_place(folder);
    let repository = repository_of(&place);
    let from_top = |top: &PathBuf| from_folder(top, &place.join("jobs"));
    let jobs = repository.as_ref().and_then(from_top).unwrap_or_else(|| PathBuf::from("jobs"));
    let text = |template: &str| {
        let jobs = jobs.to_string_lossy().replace('\\', "/");
        template.replace("{jobs}", &Value::from(jobs).to_string()).into_bytes()
    };
    // GitHub reads the workflows at the top of a repository alone.
    let top = repository.as_deref().filter(|top| *top != place).unwrap_or(folder);
    let ci = match ci {
        Ci::Github => Some(Output::new(&top.join(".github/workflows/detune.yml"), text(GITHUB))),
        Ci::Gitlab => Some(Output::new(&folder.join("detune.gitlab-ci.yml"), text(GITLAB))),
        Ci::None => None,
    };
    Ok(Scaffold { files: outputs, ci, jobs, guessed: robot })
}

const GITHUB: &str = "\
name: resonance
on: [push, pull_request]
permissions: {contents: read}
env:
  DETUNE: https://example.org/detune  # fill in: the repository of detune
  JOBS: {jobs}
jobs:
  check:
    runs-on: ubuntu-latest
    steps:
      - uses: actions/checkout@v4
      - run: cargo install --locked --git \"$DETUNE\" detune
      - run: detune check --format github -- \"$JOBS\"
";

const GITLAB: &str = "\
resonance:
  image: rust:1
  variables:
    DETUNE: https://example.org/detune  # fill in: the repository of detune
    JOBS: {jobs}
  script:
    - cargo install --locked --git \"$DETUNE\" detune
    - detune check --format gitlab --output gl-code-quality-report.json -- \"$JOBS\"
  artifacts:
    when: always
    reports: {codequality: gl-code-quality-report.json}
";

/// The URDF as a file in a folder names it: a whole path that leads elsewhere stays whole.
fn beside(folder: &Path, urdf: &Path) -> String {
    let from_place = || {
        let file = whole_place(folder_of(urdf)).join(urdf.file_name().unwrap_or_default());
        from_folder(&whole_place(folder), &file).unwrap_or(file)
    };
    let named = match urdf.strip_prefix(folder) {
        Ok(below) => below.to_owned(),
        Err(_) if urdf.is_absolute() => urdf.to_owned(),
        Err(_) => from_place(),
    };
    named.to_string_lossy().replace('\\', "/")
}

/// The joints that move, from the base to the one behind which no other moves: the longest such
/// chain.
fn chain(parts: &UrdfParts) -> Vec<Joint> {
    // The first of several into one link.
    let into: HashMap<&str, &Joint> =
        parts.joints.iter().rev().map(|joint| (joint.child.as_str(), joint)).collect();
    let way_to = |last| {
        let mut way: Vec<&Joint> = Vec::new();
        let mut next = Some(last);
        // A loop has no base.
        while let Some(joint) = next.filter(|_| way.len() <= parts.joints.len()) {
            way.push(joint);
            next = into.get(joint.parent.as_str()).copied();
        }
        way.reverse();
        way
    };
    let moving = |way: &[&Joint]| way.iter().filter(|joint| is_driven(joint)).count();
    let ways = parts.joints.iter().filter(|joint| is_driven(joint)).map(way_to);
    let longest = ways.fold(
        Vec::new(),
        |best: Vec<&Joint>, way| {
            if moving(&way) > moving(&best) { way } else { best }
        },
    );
    longest.into_iter().cloned().collect()
}

/// The link that the tool is fixed to: of those fixed behind the last moving joint, the one that is
/// named like one, else the only one at which nothing else hangs.
fn tip(parts: &UrdfParts, chain: &[Joint]) -> Option<String> {
    const NAMES: [&str; 5] = ["tool0", "tcp", "tool", "ee_link", "flange"];
    let mut fixed = vec![chain.last()?.child.as_str()];
    let mut next = 0;
    while let Some(link) = fixed.get(next).copied() {
        let own = parts.joints.iter().filter(|j| j.parent == link && j.kind == JointKind::Fixed);
        let own = own.map(|joint| joint.child.as_str());
        let new: Vec<&str> = own.filter(|child| !fixed.contains(child)).collect();
        fixed.extend(new);
        next += 1;
    }
    let fixed = &fixed[1..];
    let is_named = |name: &&str| fixed.iter().find(|link| link.eq_ignore_ascii_case(name)).copied();
    let is_last = |link: &&&str| !parts.joints.iter().any(|joint| joint.parent == **link);
    let mut last = fixed.iter().filter(is_last);
    let only = last.next().filter(|_| last.next().is_none()).copied();
    NAMES.iter().find_map(is_named).or(only).map(str::to_owned)
}

/// Whether a link behind a joint has a mass.
fn carries_mass(parts: &UrdfParts, joint: &str) -> bool {
    let links = || parts.links.iter();
    let mut behind: Vec<&Joint> = parts.joints.iter().filter(|own| own.name == joint).collect();
    let mut next = 0;
    while let Some(&at) = behind.get(next) {
        let is_heavy = |own: &Inertial| own.mass_kg > 0.0;
        if links().any(|link| link.name == at.child && link.inertial.as_ref().is_some_and(is_heavy))
        {
            return true;
        }
        let own = parts.joints.iter().filter(|joint| joint.parent == at.child);
        // A loop ends where it began.
        let new: Vec<&Joint> =
            own.filter(|own| !behind.iter().any(|known| known.name == own.name)).collect();
        behind.extend(new);
        next += 1;
    }
    false
}

fn is_driven(joint: &Joint) -> bool {
    joint.kind.moves() && joint.mimics.is_none()
}

fn turning(chain: &[Joint]) -> impl Iterator<Item = &Joint> {
    chain.iter().filter(|joint| is_driven(joint) && joint.kind != JointKind::Prismatic)
}

fn sliding(chain: &[Joint]) -> Vec<String> {
    let sliding = chain.iter().filter(|joint| joint.kind == JointKind::Prismatic);
    sliding.map(|joint| joint.name.clone()).collect()
}

/// Springs as arms of similar reach have them: the middle of their range, on a scale of powers.
fn springs(chain: &[Joint]) -> Vec<GuessedSpring> {
    let turns: Vec<&Joint> = turning(chain).collect();
    let first = chain.iter().position(is_driven).unwrap_or(0);
    let reach_m: f64 =
        chain.iter().skip(first + 1).map(|joint| joint.origin.translation.vector.norm()).sum();
    let row = TYPICAL.iter().find(|(up_to_m, ..)| reach_m <= *up_to_m).unwrap_or(&TYPICAL[2]);
    let (_, arm, wrist, origin) = row;
    let guess = |(index, joint): (usize, &&Joint)| {
        let [low, high] = if index < ARM_JOINTS { *arm } else { *wrist };
        let middle = (low * high).sqrt();
        // Two digits: more would pretend to know.
        let step = 10_f64.powf(middle.log10().floor() - 1.0);
        GuessedSpring {
            joint: joint.name.clone(),
            stiffness: (middle / step).round() * step,
            std_percent: (50.0 * (high / low).ln()).round().min(MAX_STD_PERCENT),
            source: format!("guess: {low:e} to {high:e} in arms of similar reach ({origin})"),
        }
    };
    turns.iter().enumerate().map(guess).collect()
}

/// β1 and β2 as two level, parallel axes have them: the link between them above the horizon, and
/// the next one against it.
fn arm_angles(chain: &[Joint]) -> Option<[(String, f64, f64); 2]> {
    // Frames at zero, with the axis of each joint that moves.
    let mut frame = Isometry3::identity();
    let mut placed: Vec<(&Joint, Vector3<f64>, Vector3<f64>)> = Vec::new();
    for joint in chain {
        frame *= joint.origin;
        if is_driven(joint) {
            let axis = frame.rotation * joint.axis.try_normalize(0.0)?;
            placed.push((joint, frame.translation.vector, axis));
        }
    }
    let is_level = |axis: &Vector3<f64>| axis.z.abs() < LEVEL;
    let turns = |joint: &Joint| joint.kind != JointKind::Prismatic;
    let shoulder = placed.iter().position(|(joint, _, axis)| turns(joint) && is_level(axis))?;
    let (elbow_joint, elbow, elbow_axis) = placed.get(shoulder + 1)?;
    let (shoulder_joint, place, axis) = &placed[shoulder];
    let parallel = axis.dot(elbow_axis);
    if !turns(elbow_joint) || parallel.abs() < 1.0 - LEVEL {
        return None;
    }
    // The wrist is where the forearm ends: the next joint that does not lie on the elbow's axis.
    let across = |from: &Vector3<f64>, to: &Vector3<f64>| {
        let way = to - from;
        way - axis * axis.dot(&way)
    };
    let mut behind = placed.iter().skip(shoulder + 2).map(|(_, place, _)| across(elbow, place));
    let forearm = behind.next_back().filter(|way| way.norm() > LEVEL)?;
    let upper = across(place, elbow);
    if upper.norm() < LEVEL {
        return None;
    }
    // Angles from forward towards up: turning about the axis lowers what lies forward of it.
    let (up, forward) = (Vector3::z(), axis.cross(&Vector3::z()));
    let angle = |way: &Vector3<f64>| way.dot(&up).atan2(way.dot(&forward));
    let (beta1, beta2) = (angle(&upper), angle(&forearm) - angle(&upper));
    Some([
        (shoulder_joint.name.clone(), -1.0, beta1),
        (elbow_joint.name.clone(), -parallel.signum(), beta2),
    ])
}

/// A small motion about the middle of the joints' limits, in degrees and mm.
fn motion(chain: &[Joint]) -> [Vec<f64>; 2] {
    let moving: Vec<&Joint> = chain.iter().filter(|joint| is_driven(joint)).collect();
    let at = |share: f64| {
        let position = |(index, joint): (usize, &&Joint)| {
            let limit = joint.position_limit.filter(|_| joint.kind != JointKind::Continuous);
            let [low, high] = limit.unwrap_or([-0.5, 0.5]);
            let swing = SWING_RAD.min(0.25 * (high - low)) * if index < 2 { share } else { 0.0 };
            let value = 0.5 * (low + high) + swing;
            let slides = joint.kind == JointKind::Prismatic;
            let shown = if slides { mm_from_m(value) } else { deg_from_rad(value) };
            (shown * 1e3).round() / 1e3 + 0.0
        };
        moving.iter().enumerate().map(position).collect()
    };
    [at(-1.0), at(1.0)]
}
