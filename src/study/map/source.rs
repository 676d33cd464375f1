//! Where the poses of a map come from.

use std::f64::consts::PI;
use std::io::Read;
use std::path::Path;

use super::wrong;
use crate::input::{DecodedPoses, PoseDecoder, PoseTable, RawPoses};
use crate::map::{Generator, Grid, GridAxis, RandomPoses};
use crate::model::{JointKind, MovingJoint, Robot};
use crate::notes::{Code, Note, Part, Place};
use crate::units::{m_from_mm, rad_from_deg};
use crate::wording::nearest;

/// In what a joint's positions are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// rad for a joint that turns, m for one that slides.
    RadOrM,
    /// Degrees for a joint that turns, mm for one that slides.
    DegOrMm,
    /// Degrees; the joint must turn.
    Deg,
    /// mm; the joint must slide.
    Mm,
}

/// Evenly spaced positions of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Positions {
    /// URDF name of the joint.
    pub joint: String,
    /// The first.
    pub from: f64,
    /// The last.
    pub to: f64,
    /// How many, both ends included; one stays at `from`.
    pub steps: usize,
    /// Of `from` and `to`.
    pub unit: Unit,
}

/// Poses that are asked for without a table. Joints in `at` stay at a position, by name and in
/// degrees or mm.
#[derive(Debug, Clone, PartialEq)]
pub enum Request {
    /// All combinations of these, the last running fastest; other joints stay at zero.
    Grid {
        /// The joints that move.
        axes: Vec<Positions>,
        /// The joints that stand elsewhere than at zero.
        at: Vec<(String, f64)>,
    },
    /// Evenly spread at random within the joints' limits; a continuous joint within half a turn to
    /// either side.
    Random {
        /// How many.
        count: usize,
        /// The same seed gives the same poses.
        seed: u64,
        /// The joints that do not move.
        at: Vec<(String, f64)>,
    },
}

/// Poses from somewhere, piece by piece.
#[derive(Debug)]
pub struct Source {
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    /// The poses from `done` up to `end`.
    Made {
        generator: Generator,
        end: usize,
        done: usize,
    },
    Table(Box<PoseTable>),
}

impl Source {
    /// Poses for `robot`.
    ///
    /// # Errors
    /// Joints that the robot does not have, that are named twice or have no limits to be random in;
    /// positions in the wrong unit. The key in a note's place is `grid`, `random` or `at`.
    pub fn new(request: &Request, robot: &Robot) -> Result<Self, Vec<Note>> {
        let generator = match request {
            Request::Grid { axes, at } => Generator::Grid(grid(robot, axes, at)?),
            Request::Random { count, seed, at } => {
                Generator::Random(random(robot, *count, *seed, at)?)
            }
        };
        let count = generator.count();
        let count = count.ok_or_else(|| vec![wrong("grid", "the poses are too many to count")])?;
        Ok(Self { kind: Kind::Made { generator, end: count, done: 0 } })
    }

    /// The poses of a table, CSV or NumPy's .npy (or, as a feature, Apache Arrow).
    ///
    /// # Errors
    /// As [`PoseTable::open`].
    pub fn open(path: &Path, robot: &Robot) -> Result<Self, Vec<Note>> {
        PoseTable::open(path, robot).map(Self::of_table)
    }

    /// The same of a table that streams in; `name` stands for it in errors.
    ///
    /// # Errors
    /// As [`PoseTable::from_reader`].
    pub fn from_reader(
        reader: Box<dyn Read>,
        name: &Path,
        robot: &Robot,
    ) -> Result<Self, Vec<Note>> {
        PoseTable::from_reader(reader, name, robot).map(Self::of_table)
    }

    fn of_table(table: PoseTable) -> Self {
        Self { kind: Kind::Table(Box::new(table)) }
    }

    /// How many poses there are, where that is known before they are read.
    pub fn count(&self) -> Option<usize> {
        match &self.kind {
            Kind::Made { end, done, .. } => Some(end.saturating_sub(*done)),
            Kind::Table(table) => table.count(),
        }
    }

    /// The only joint that moves, by its index from base to tip, where one is known to.
    pub fn swept(&self) -> Option<usize> {
        match &self.kind {
            Kind::Made { generator: Generator::Grid(grid), .. } => match grid.axes.as_slice() {
                [axis] => Some(axis.joint),
                _ => None,
            },
            _ => None,
        }
    }

    /// All poses, joint positions in rad or m, pose after pose.
    ///
    /// # Errors
    /// Every fault of the table; more than `most` poses.
    pub(in crate::study) fn poses(mut self, most: usize) -> Result<Vec<Vec<f64>>, Vec<Note>> {
        let decoder = self.decoder();
        let (mut raw, mut decoded) = (Raw::default(), DecodedPoses::default());
        let (mut poses, mut errors, mut places) = (Vec::new(), Vec::new(), 0);
        while self.read(1024, &mut raw).map_err(|error| vec![error])? {
            decoder.decode(&raw, &mut decoded);
            for (place, what) in &decoded.faults {
                let error = Note::error(Code::Value, Place::default(), what);
                errors.push(decoder.locate(places + place, &error));
            }
            places += decoded.places;
            let joints = decoded.values.len() / decoded.count.max(1);
            poses.extend(decoded.values.chunks(joints.max(1)).map(<[f64]>::to_vec));
            if poses.len() > most {
                let what = format!("there are more than {most} poses");
                return Err(vec![Note::error(Code::TooLong, Place::default(), what)]);
            }
        }
        if errors.is_empty() { Ok(poses) } else { Err(errors) }
    }

    /// One of `of` parts of the poses, counted from 1, in pieces of so many poses: the parts, one
    /// behind the other, are the whole, piece by piece. `None` of a table, which is not made.
    pub(super) fn part(self, part: usize, of: usize, piece: usize) -> Option<Self> {
        let Kind::Made { generator, end, .. } = self.kind else { return None };
        let pieces = end.div_ceil(piece) as u128;
        let place = |part: usize| {
            let before = pieces * part as u128 / of.max(1) as u128;
            usize::try_from(before * piece as u128).map_or(end, |place| place.min(end))
        };
        let (done, end) = (place(part.saturating_sub(1)), place(part));
        Some(Self { kind: Kind::Made { generator, end, done } })
    }

    /// The place of its first pose in the whole, from zero.
    pub(super) fn first(&self) -> usize {
        match &self.kind {
            Kind::Made { done, .. } => *done,
            Kind::Table(_) => 0,
        }
    }

    /// The poses in words that are the same for the same poses; `None` of a table.
    pub(super) fn described(&self) -> Option<String> {
        match &self.kind {
            Kind::Made { generator, .. } => Some(format!("{generator:?}")),
            Kind::Table(_) => None,
        }
    }

    pub(super) fn decoder(&self) -> Decoder {
        match &self.kind {
            Kind::Made { generator, .. } => Decoder::Made(generator.clone()),
            Kind::Table(table) => Decoder::Table(table.decoder().clone()),
        }
    }

    /// Reads the next piece of about so many poses, in place of what `raw` holds; `false` at the
    /// end.
    pub(super) fn read(&mut self, poses: usize, raw: &mut Raw) -> Result<bool, Note> {
        match &mut self.kind {
            Kind::Made { end, done, .. } => {
                (raw.first, raw.count) = (*done, poses.min(*end - *done));
                *done += raw.count;
                Ok(raw.count > 0)
            }
            Kind::Table(table) => table.read(poses, &mut raw.table),
        }
    }
}

/// What a piece is decoded from.
#[derive(Debug, Clone, Default)]
pub(super) struct Raw {
    first: usize,
    count: usize,
    table: RawPoses,
}

/// Decodes pieces of a source, on any thread.
#[derive(Debug, Clone)]
pub(super) enum Decoder {
    Made(Generator),
    Table(PoseDecoder),
}

impl Decoder {
    /// The poses of a piece, in place of what `out` holds.
    pub(super) fn decode(&self, raw: &Raw, out: &mut DecodedPoses) {
        match self {
            Self::Made(generator) => {
                out.clear();
                generator.append(raw.first..raw.first + raw.count, &mut out.values);
                (out.count, out.places) = (raw.count, raw.count);
            }
            Self::Table(decoder) => decoder.decode(&raw.table, out),
        }
    }

    /// What is wrong at a place (a line, a row, a pose), counted from the source's first, from
    /// zero.
    pub(super) fn locate(&self, place: usize, note: &Note) -> Note {
        match self {
            Self::Made(_) => Note { place: Place::part(Part::Pose(place)), ..note.clone() },
            Self::Table(decoder) => Note { code: note.code, ..decoder.fault(place, &note.what) },
        }
    }
}

fn grid(robot: &Robot, axes: &[Positions], at: &[(String, f64)]) -> Result<Grid, Vec<Note>> {
    let mut errors = Vec::new();
    let mut placed: Vec<GridAxis> = Vec::new();
    for axis in axes {
        match grid_axis(robot, axis) {
            Ok(found) if placed.iter().any(|other| other.joint == found.joint) => {
                errors.push(wrong("grid", format!("joint '{}' is given twice", axis.joint)));
            }
            Ok(found) => placed.push(found),
            Err(error) => errors.push(error),
        }
    }
    let mut q = vec![0.0; robot.joints().len()];
    for (joint, value) in fixed(robot, at, &mut errors) {
        if placed.iter().any(|axis| axis.joint == joint) {
            let name = &robot.joints()[joint].name;
            errors
                .push(wrong("at", format!("joint '{name}' is swept and cannot be fixed as well")));
        }
        q[joint] = value;
    }
    if errors.is_empty() { Ok(Grid { at: q, axes: placed }) } else { Err(errors) }
}

fn grid_axis(robot: &Robot, axis: &Positions) -> Result<GridAxis, Note> {
    let joint = joint_named(robot, "grid", &axis.joint)?;
    let [from, to] = [axis.from, axis.to].map(|value| si(&robot.joints()[joint], value, axis.unit));
    let (Some(from), Some(to)) = (from, to) else {
        let (does, given, needed) = match axis.unit {
            Unit::Mm => ("turns", "mm", "degrees"),
            _ => ("slides", "degrees", "mm"),
        };
        let what = format!(
            "joint '{}' {does}: positions in {given} do not fit, give {needed}",
            axis.joint
        );
        return Err(wrong("grid", what));
    };
    if !(from.is_finite() && to.is_finite()) {
        let what = format!("joint '{}': positions must be finite", axis.joint);
        return Err(wrong("grid", what));
    }
    Ok(GridAxis { joint, from, to, steps: axis.steps })
}

fn random(
    robot: &Robot,
    count: usize,
    seed: u64,
    at: &[(String, f64)],
) -> Result<RandomPoses, Vec<Note>> {
    let mut errors = Vec::new();
    let mut ranges: Vec<Option<[f64; 2]>> = robot
        .joints()
        .iter()
        .map(|joint| joint.limit.or((!slides(joint)).then_some([-PI, PI])))
        .collect();
    for (joint, value) in fixed(robot, at, &mut errors) {
        ranges[joint] = Some([value; 2]);
    }
    for (joint, range) in robot.joints().iter().zip(&ranges) {
        if range.is_none() {
            let name = &joint.name;
            let what = format!("joint '{name}' slides without limits; give it a position");
            errors.push(wrong("random", what));
        }
    }
    let ranges = ranges.into_iter().flatten().collect();
    if errors.is_empty() { Ok(RandomPoses { ranges, count, seed }) } else { Err(errors) }
}

/// The joints that stay at a position, rad or m.
fn fixed(robot: &Robot, at: &[(String, f64)], errors: &mut Vec<Note>) -> Vec<(usize, f64)> {
    let mut fixed = Vec::new();
    for (name, value) in at {
        match joint_named(robot, "at", name) {
            Ok(joint) if fixed.iter().any(|(other, _)| *other == joint) => {
                errors.push(wrong("at", format!("joint '{name}' is given twice")));
            }
            Ok(joint) => {
                let value = si(&robot.joints()[joint], *value, Unit::DegOrMm);
                fixed.extend(value.map(|value| (joint, value)));
            }
            Err(error) => errors.push(error),
        }
    }
    fixed
}

/// A position in rad or m; `None` if the unit does not fit the joint.
fn si(joint: &MovingJoint, value: f64, unit: Unit) -> Option<f64> {
    match (unit, slides(joint)) {
        (Unit::RadOrM, _) => Some(value),
        (Unit::DegOrMm | Unit::Deg, false) => Some(rad_from_deg(value)),
        (Unit::DegOrMm | Unit::Mm, true) => Some(m_from_mm(value)),
        (Unit::Deg, true) | (Unit::Mm, false) => None,
    }
}

fn slides(joint: &MovingJoint) -> bool {
    joint.kind == JointKind::Prismatic
}

fn joint_named(robot: &Robot, key: &'static str, name: &str) -> Result<usize, Note> {
    let names: Vec<&str> = robot.joints().iter().map(|joint| joint.name.as_str()).collect();
    names.iter().position(|known| *known == name).ok_or_else(|| {
        let hint = nearest(name, names.iter().copied()).map_or_else(
            || format!("; it has {}", names.join(", ")),
            |near| format!("; did you mean '{near}'?"),
        );
        wrong(key, format!("the robot has no moving joint '{name}'{hint}"))
    })
}
