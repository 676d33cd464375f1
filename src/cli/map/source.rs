//! Where the poses of a map come from.

use std::io;
use std::path::Path;

use super::MapArgs;
use crate::input::{DecodedPoses, PoseDecoder, PoseTable, RawPoses};
use crate::map::{Generator, Grid, GridAxis, RandomPoses};
use crate::model::{JointKind, Robot};
use crate::notes::Note;
use crate::units::{m_from_mm, rad_from_deg};
use crate::wording::nearest;

/// Poses that are made at a time.
const PIECE_POSES: usize = 1024;

/// Where a continuous joint's random positions end to either side.
const HALF_TURN_RAD: f64 = std::f64::consts::PI;

/// Poses from somewhere, piece by piece.
pub(super) enum Source {
    Made { generator: Generator, count: usize, done: usize },
    Table(Box<PoseTable>),
}

/// What a piece is taken apart from.
#[derive(Debug, Clone, Default)]
pub(super) struct Raw {
    first: usize,
    count: usize,
    table: RawPoses,
}

/// Takes pieces of a source apart, on any thread.
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

    /// A fault at a place (a line, a row, a pose), counted from the source's first, from zero.
    pub(super) fn fault(&self, place: usize, what: &str) -> Note {
        match self {
            Self::Made(_) => usage(format!("pose {}: {what}", place + 1)),
            Self::Table(decoder) => decoder.fault(place, what),
        }
    }
}

impl Source {
    pub(super) fn new(args: &MapArgs, robot: &Robot) -> Result<Self, Vec<Note>> {
        if let Some(path) = &args.poses {
            let table = if path == Path::new("-") {
                PoseTable::from_reader(Box::new(io::stdin().lock()), path, robot)?
            } else {
                PoseTable::open(path, robot)?
            };
            return Ok(Self::Table(Box::new(table)));
        }
        let generator = match args.random {
            Some(count) => Generator::Random(random(args, robot, count)?),
            None => Generator::Grid(grid(args, robot)?),
        };
        let Some(count) = generator.count() else {
            return Err(vec![usage("--grid: the poses are too many to be counted".into())]);
        };
        Ok(Self::Made { generator, count, done: 0 })
    }

    /// How many poses there are, where that is known before they are read.
    pub(super) fn count(&self) -> Option<usize> {
        match self {
            Self::Made { count, .. } => Some(*count),
            Self::Table(table) => table.count(),
        }
    }

    pub(super) fn decoder(&self) -> Decoder {
        match self {
            Self::Made { generator, .. } => Decoder::Made(generator.clone()),
            Self::Table(table) => Decoder::Table(table.decoder().clone()),
        }
    }

    /// Reads the next piece, in place of what `raw` holds; `false` at the end.
    pub(super) fn read(&mut self, raw: &mut Raw) -> Result<bool, Note> {
        match self {
            Self::Made { count, done, .. } => {
                (raw.first, raw.count) = (*done, PIECE_POSES.min(*count - *done));
                *done += raw.count;
                Ok(raw.count > 0)
            }
            Self::Table(table) => table.read(&mut raw.table),
        }
    }

    /// The joint that is swept, if one is.
    pub(super) fn swept(&self) -> Option<usize> {
        match self {
            Self::Made { generator: Generator::Grid(grid), .. } => match grid.axes.as_slice() {
                [axis] => Some(axis.joint),
                _ => None,
            },
            Self::Made { .. } | Self::Table(_) => None,
        }
    }
}

/// Poses one by one, for maps of few poses.
pub(super) struct RowByRow {
    source: Source,
    decoder: Decoder,
    raw: Raw,
    piece: DecodedPoses,
    joints: usize,
    /// Poses of the piece that were given out, and the place of its first.
    given: usize,
    before: usize,
}

/// Poses, and the place of each in its source.
pub(super) type Chunk = (Vec<Vec<f64>>, Vec<usize>);

impl RowByRow {
    pub(super) fn new(source: Source, robot: &Robot) -> Self {
        let decoder = source.decoder();
        let joints = robot.joints().len();
        let (raw, piece) = (Raw::default(), DecodedPoses::default());
        Self { source, decoder, raw, piece, joints, given: 0, before: 0 }
    }

    /// Up to `chunk` poses; none at the end.
    pub(super) fn next(&mut self, chunk: usize) -> Result<Chunk, Vec<Note>> {
        let (mut poses, mut places) = (Vec::new(), Vec::new());
        while poses.len() < chunk {
            if self.given == self.piece.count && !self.refill()? {
                break;
            }
            let wanted = (chunk - poses.len()).min(self.piece.count - self.given);
            for pose in self.given..self.given + wanted {
                poses
                    .push(self.piece.values[pose * self.joints..(pose + 1) * self.joints].to_vec());
                places.push(self.before + self.piece.place_of(pose));
            }
            self.given += wanted;
        }
        Ok((poses, places))
    }

    fn refill(&mut self) -> Result<bool, Vec<Note>> {
        self.before += self.piece.places;
        self.piece.clear();
        self.given = 0;
        if !self.source.read(&mut self.raw).map_err(|fault| vec![fault])? {
            return Ok(false);
        }
        self.decoder.decode(&self.raw, &mut self.piece);
        let faults = &self.piece.faults;
        let told = faults.iter().map(|(at, what)| self.fault(self.before + at, what));
        if faults.is_empty() { Ok(true) } else { Err(told.collect()) }
    }

    /// How many poses there are, where that is known before they are read.
    pub(super) fn count(&self) -> Option<usize> {
        self.source.count()
    }

    /// A fault at a place.
    pub(super) fn fault(&self, place: usize, what: &str) -> Note {
        self.decoder.fault(place, what)
    }

    /// The joint that is swept, if one is.
    pub(super) fn swept(&self) -> Option<usize> {
        self.source.swept()
    }
}

/// One joint from end to end, or all combinations of several.
fn grid(args: &MapArgs, robot: &Robot) -> Result<Grid, Vec<Note>> {
    let mut axes = Vec::new();
    let mut faults = Vec::new();
    if let Some(name) = &args.joint {
        let joint = joint_named(robot, "--joint", name).map_err(|fault| vec![fault])?;
        let (from, to) = ends(args, slides(robot, joint), name)?;
        let Some(steps) = args.steps else {
            return Err(vec![usage("--steps must be given with --joint".into())]);
        };
        axes.push(GridAxis { joint, from, to, steps: steps as usize });
    }
    for range in &args.grid {
        match joint_named(robot, "--grid", &range.joint) {
            Ok(joint) if axes.iter().any(|axis| axis.joint == joint) => {
                faults.push(usage(format!("--grid: joint '{}' is given twice", range.joint)));
            }
            Ok(_) if range.steps == 1 && range.from != range.to => faults.push(usage(format!(
                "--grid {}: one position has one end; give {}={}:{}:1, or 2 positions and more",
                range.joint, range.joint, range.from, range.from
            ))),
            Ok(joint) => {
                let (from, to) = (si(robot, joint, range.from), si(robot, joint, range.to));
                axes.push(GridAxis { joint, from, to, steps: range.steps });
            }
            Err(fault) => faults.push(fault),
        }
    }
    let mut at = vec![0.0; robot.joints().len()];
    for (joint, value) in placed(args, robot, &mut faults) {
        if axes.iter().any(|axis| axis.joint == joint) {
            let name = &robot.joints()[joint].name;
            faults.push(usage(format!("--at: joint '{name}' is the one that is swept")));
        }
        at[joint] = value;
    }
    if axes.is_empty() && faults.is_empty() {
        faults.push(usage("--joint, --grid, --random or --poses must be given".into()));
    }
    if faults.is_empty() { Ok(Grid { at, axes }) } else { Err(faults) }
}

/// Every joint within its limits, a continuous one within half a turn to either side.
fn random(args: &MapArgs, robot: &Robot, count: u32) -> Result<RandomPoses, Vec<Note>> {
    let mut faults = Vec::new();
    let mut ranges: Vec<Option<[f64; 2]>> = robot
        .joints()
        .iter()
        .map(|joint| match joint.kind {
            JointKind::Prismatic => joint.limit,
            _ => Some(joint.limit.unwrap_or([-HALF_TURN_RAD, HALF_TURN_RAD])),
        })
        .collect();
    for (joint, value) in placed(args, robot, &mut faults) {
        ranges[joint] = Some([value; 2]);
    }
    for (joint, range) in robot.joints().iter().zip(&ranges) {
        if range.is_none() {
            let name = &joint.name;
            faults.push(usage(format!(
                "--random: joint '{name}' slides without limits; place it with --at {name}=MM"
            )));
        }
    }
    let ranges = ranges.into_iter().flatten().collect();
    let random = RandomPoses { ranges, count: count as usize, seed: args.seed };
    if faults.is_empty() { Ok(random) } else { Err(faults) }
}

/// The joints that `--at` places, rad or m.
fn placed(args: &MapArgs, robot: &Robot, faults: &mut Vec<Note>) -> Vec<(usize, f64)> {
    let mut placed = Vec::new();
    for (name, value) in &args.at {
        match joint_named(robot, "--at", name) {
            Ok(joint) if placed.iter().any(|(other, _)| *other == joint) => {
                faults.push(usage(format!("--at: joint '{name}' is placed twice")));
            }
            Ok(joint) => placed.push((joint, si(robot, joint, *value))),
            Err(fault) => faults.push(fault),
        }
    }
    placed
}

/// Both ends of the sweep in rad or m, from the options that fit the joint.
fn ends(args: &MapArgs, slides: bool, name: &str) -> Result<(f64, f64), Vec<Note>> {
    let (wanted, unwanted, unit) = if slides {
        ((args.from_mm, args.to_mm), (args.from_deg, args.to_deg), "mm")
    } else {
        ((args.from_deg, args.to_deg), (args.from_mm, args.to_mm), "deg")
    };
    let (does, others) = if slides { ("slides", "deg") } else { ("turns", "mm") };
    if unwanted.0.is_some() || unwanted.1.is_some() {
        return Err(vec![usage(format!(
            "joint '{name}' {does}: --from-{others} and --to-{others} do not fit, give \
             --from-{unit} and --to-{unit}"
        ))]);
    }
    let (Some(from), Some(to)) = wanted else {
        let what = format!("joint '{name}' {does}: --from-{unit} and --to-{unit} must be given");
        return Err(vec![usage(what)]);
    };
    if !(from.is_finite() && to.is_finite()) {
        let what = format!("--from-{unit} and --to-{unit} are {from} and {to}, must be finite");
        return Err(vec![usage(what)]);
    }
    let convert = if slides { m_from_mm } else { rad_from_deg };
    Ok((convert(from), convert(to)))
}

/// A position on the command line, degrees or mm, in rad or m.
fn si(robot: &Robot, joint: usize, value: f64) -> f64 {
    if slides(robot, joint) { m_from_mm(value) } else { rad_from_deg(value) }
}

fn slides(robot: &Robot, joint: usize) -> bool {
    robot.joints()[joint].kind == JointKind::Prismatic
}

fn joint_named(robot: &Robot, option: &str, name: &str) -> Result<usize, Note> {
    let names: Vec<&str> = robot.joints().iter().map(|joint| joint.name.as_str()).collect();
    names.iter().position(|known| *known == name).ok_or_else(|| {
        let hint = nearest(name, names.iter().copied()).map_or_else(
            || format!("; it has {}", names.join(", ")),
            |n| format!("; did you mean '{n}'?"),
        );
        usage(format!("{option}: the robot has no moving joint '{name}'{hint}"))
    })
}

/// A fault of the command line.
pub(super) fn usage(what: String) -> Note {
    Note::usage(what)
}
