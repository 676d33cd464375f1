//! A robot's files → what is doubtful about them, and the robot's frequencies at a few poses beside
//! those of arms that somebody has measured.

use std::path::{Path, PathBuf};

use super::Read;
use crate::input::read_robot;
use crate::map::{Block, FrequencyMap, Generator, Method, RandomPoses};
use crate::model::{CoordinateKind, JointKind, Robot};
use crate::notes::{Code, Note, Place};
use crate::progress::silent;
use crate::risk::FIRST_FREQUENCY_HZ;
use crate::uncertainty::{Scales, Trust};

/// Random poses among which the softest and the stiffest are sought.
const POSES: usize = 1024;

/// Natural frequencies of measured arms, Hz.
pub const MEASURED_ARMS: [(&str, &str); 3] = [
    ("KUKA KR210 with a spindle", "11, 18, 27"),
    ("a milling robot, 13 modes", "7.1, 10.3, 16.0, 18.5, 34.4, 37.8, 72.7, 107.8 … 253"),
    ("an arm of the class of the Fanuc S-430", "8 to 107"),
];

/// A robot as its files have it, with figures that somebody who knows it can judge.
#[derive(Debug, Clone, PartialEq)]
pub struct Examined {
    /// What it is called.
    pub name: String,
    /// Its file.
    pub file: PathBuf,
    /// Mass of what moves when the joints do, kg.
    pub moving_mass_kg: f64,
    /// The moving joints, base to tip, and whether each slides.
    pub joints: Vec<(String, bool)>,
    /// The springs, base first.
    pub springs: Vec<Spring>,
    /// Frequencies at a few poses.
    pub poses: Vec<ExaminedPose>,
    /// Whether it was compared with measured frequencies.
    pub calibrated: bool,
    /// Every frequency f lies within f (1 ± this) for a check; `None` where springs, masses and
    /// what was measured say it mode by mode.
    pub within: Option<f64>,
    /// What is doubtful about it.
    pub warnings: Vec<Note>,
}

/// A spring of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// Of which joint, or the name of the extra coordinate.
    pub name: String,
    /// N·m/rad, or N/m of one that shifts.
    pub stiffness: f64,
    /// Whether it shifts.
    pub shifts: bool,
    /// What a check takes the constant to be off by, one standard deviation of its logarithm: what
    /// the calibration learned, or what the file states; `None` where it takes none.
    pub std: Option<f64>,
    /// Whether nobody stated that.
    pub is_assumed: bool,
}

/// A pose with its frequencies.
#[derive(Debug, Clone, PartialEq)]
pub struct ExaminedPose {
    /// Why this one.
    pub which: Which,
    /// Joint positions, rad or m.
    pub joints: Vec<f64>,
    /// Ascending, Hz.
    pub frequencies_hz: Vec<f64>,
}

/// Which pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// All joints at zero.
    Zero,
    /// All joints in the middle of their limits.
    Middle,
    /// The lowest first frequency of random poses.
    Softest,
    /// The highest first frequency of random poses.
    Stiffest,
}

/// Reads a robot and examines it.
///
/// # Errors
/// Faults of its files.
pub fn examine(file: &Path) -> Read<Examined> {
    let Read { value, warnings, files } = Read::of(|reading| read_robot(file, reading));
    let value = value.map(|robot| examined(file, &robot, &warnings));
    Read { value, warnings, files }
}

fn examined(file: &Path, robot: &Robot, warnings: &[Note]) -> Examined {
    let poses = poses(robot);
    let mut warnings = warnings.to_vec();
    warnings.extend(first_frequency(file, &poses));
    let trust = Trust::of(robot, None);
    let believed = |at: usize| match &trust {
        Trust::Share(_) => None,
        Trust::Belief(belief) => {
            let mut all = belief.parameters.iter();
            let own = all.find(|one| one.scales == Scales::Spring(at));
            // A parameter that is exact is none.
            Some(own.map_or((0.0, false), |one| (one.std, one.is_assumed)))
        }
    };
    let springs = robot.coordinates().iter().enumerate().map(|(at, coordinate)| Spring {
        name: coordinate.name.clone(),
        stiffness: coordinate.stiffness,
        shifts: coordinate.kind == CoordinateKind::Translation,
        std: believed(at).map(|(std, _)| std),
        is_assumed: believed(at).is_some_and(|(_, is_assumed)| is_assumed),
    });
    let slides = |kind: JointKind| kind == JointKind::Prismatic;
    Examined {
        name: robot.name().to_owned(),
        file: file.to_owned(),
        moving_mass_kg: robot.moving_mass_kg(),
        joints: robot.joints().iter().map(|j| (j.name.clone(), slides(j.kind))).collect(),
        springs: springs.collect(),
        poses,
        calibrated: robot.calibration().is_some(),
        within: match trust {
            Trust::Share(share) => Some(share),
            Trust::Belief(_) => None,
        },
        warnings,
    }
}

/// The poses that have frequencies, of those that are looked at.
fn poses(robot: &Robot) -> Vec<ExaminedPose> {
    let map = FrequencyMap::new(robot, Method::Linear);
    let solved = |poses: Vec<f64>, count: usize| {
        let mut block = Block { count, poses, ..Block::default() };
        map.solve(&mut block, &silent).is_ok().then_some(block)
    };
    let pose = |which: Which, block: &Block, at: usize| {
        let row = block.rows().nth(at)?;
        let (joints, frequencies_hz) = (row.joints.to_vec(), row.frequencies_hz.to_vec());
        Some(ExaminedPose { which, joints, frequencies_hz })
    };
    let alone = |which, joints| pose(which, &solved(joints, 1)?, 0);
    let ranges: Vec<[f64; 2]> = robot
        .joints()
        .iter()
        .map(|joint| match (joint.limit, joint.kind) {
            (Some(limit), _) => limit,
            (None, JointKind::Prismatic) => [0.0; 2],
            (None, _) => [-std::f64::consts::PI, std::f64::consts::PI],
        })
        .collect();
    let middle = ranges.iter().map(|[low, high]| 0.5 * (low + high)).collect();
    let mut found: Vec<ExaminedPose> = Vec::new();
    found.extend(alone(Which::Zero, vec![0.0; ranges.len()]));
    found.extend(alone(Which::Middle, middle));
    let random = Generator::Random(RandomPoses { ranges, count: POSES, seed: 1 });
    let mut values = Vec::new();
    random.append(0..POSES, &mut values);
    if let Some(block) = solved(values, POSES) {
        let first = |at: &usize| block.frequencies_hz[at * map.modes()];
        let by_first = |a: &usize, b: &usize| first(a).total_cmp(&first(b));
        let ends = [
            (Which::Softest, (0..POSES).min_by(by_first)),
            (Which::Stiffest, (0..POSES).max_by(by_first)),
        ];
        found.extend(ends.into_iter().filter_map(|(which, at)| pose(which, &block, at?)));
    }
    found
}

/// A first frequency that no arm has at its softest pose.
fn first_frequency(file: &Path, poses: &[ExaminedPose]) -> Option<Note> {
    let [least_hz, most_hz] = FIRST_FREQUENCY_HZ;
    let lowest = poses.iter().filter_map(|pose| pose.frequencies_hz.first().copied());
    let lowest_hz = lowest.min_by(f64::total_cmp)?;
    (!(least_hz..=most_hz).contains(&lowest_hz)).then(|| {
        let what = format!(
            "the first natural frequency is {lowest_hz:.3} Hz at its lowest, where arms have \
             {least_hz} to {most_hz} Hz; check stiffness (N·m/rad), masses and the units of both"
        );
        Note::warning(Code::FirstFrequency, Place::file(file), what)
    })
}
