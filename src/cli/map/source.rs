//! Where the poses of a map come from.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::MapArgs;
use crate::input::{Fault, Poses, load_poses};
use crate::map::sweep;
use crate::model::{JointKind, Robot};
use crate::units::{m_from_mm, rad_from_deg};

/// Faults of a table that are told in one go.
const MOST_TOLD: usize = 20;

/// Names less alike than this are no suggestion.
const LEAST_LIKENESS: f64 = 0.6;

/// Poses and, where they are from a table, their lines.
pub(super) type Chunk = (Vec<Vec<f64>>, Vec<usize>);

/// Where the poses come from.
pub(super) enum Source {
    Sweep { joint: usize, at: Vec<f64>, from: f64, to: f64, steps: usize, done: usize },
    Table(Poses<Box<dyn Read>>),
}

impl Source {
    pub(super) fn new(args: &MapArgs, robot: &Robot) -> Result<Self, Vec<Fault>> {
        if let Some(path) = &args.poses {
            let input: Box<dyn Read> = if path == Path::new("-") {
                Box::new(io::stdin().lock())
            } else {
                let file = File::open(path)
                    .map_err(|error| fault(Some(path), None, format!("cannot be read: {error}")))?;
                Box::new(file)
            };
            return Ok(Self::Table(load_poses(input, path, robot)?));
        }
        let Some(name) = &args.joint else {
            return Err(fault(None, None, "--joint or --poses must be given".into()));
        };
        let joint = joint_named(robot, "--joint", name)?;
        let mut at = vec![0.0; robot.joints().len()];
        for (name, value) in &args.at {
            let index = joint_named(robot, "--at", name)?;
            if index == joint {
                let what = format!("--at: joint '{name}' is the one that is swept");
                return Err(fault(None, None, what));
            }
            at[index] = if slides(robot, index) { m_from_mm(*value) } else { rad_from_deg(*value) };
        }
        let (from, to) = ends(args, slides(robot, joint), name)?;
        let Some(steps) = args.steps else {
            return Err(fault(None, None, "--steps must be given with --joint".into()));
        };
        Ok(Self::Sweep { joint, at, from, to, steps: steps as usize, done: 0 })
    }

    /// Up to `chunk` poses and, from a table, their lines.
    pub(super) fn next(&mut self, chunk: usize) -> Result<Chunk, Vec<Fault>> {
        match self {
            Self::Table(table) => next_rows(table, chunk),
            Self::Sweep { joint, at, from, to, steps, done } => {
                let first = *done;
                *done = (first + chunk).min(*steps);
                let poses = sweep(at, *joint, *from, *to, *steps, first..*done);
                Ok((poses, Vec::new()))
            }
        }
    }

    pub(super) fn swept(&self) -> Option<usize> {
        match self {
            Self::Sweep { joint, .. } => Some(*joint),
            Self::Table(_) => None,
        }
    }
}

/// The next rows of a table and their lines; all faults among them at once.
fn next_rows<R: Read>(table: &mut Poses<R>, chunk: usize) -> Result<Chunk, Vec<Fault>> {
    let (mut poses, mut lines, mut faults) = (Vec::new(), Vec::new(), Vec::new());
    while poses.len() < chunk && faults.len() < MOST_TOLD {
        let mut pose = Vec::new();
        let before = table.line();
        match table.read_into(&mut pose) {
            Ok(true) => {
                poses.push(pose);
                lines.push(table.line());
            }
            Ok(false) => break,
            Err(fault) => {
                let row = fault.line;
                faults.push(fault);
                // A table that cannot be read any further stays where it is.
                if row.is_none() || table.line() == before {
                    break;
                }
            }
        }
    }
    if faults.is_empty() { Ok((poses, lines)) } else { Err(faults) }
}

/// Both ends of the sweep in rad or m, from the options that fit the joint.
fn ends(args: &MapArgs, slides: bool, name: &str) -> Result<(f64, f64), Vec<Fault>> {
    let (wanted, unwanted, unit) = if slides {
        ((args.from_mm, args.to_mm), (args.from_deg, args.to_deg), "mm")
    } else {
        ((args.from_deg, args.to_deg), (args.from_mm, args.to_mm), "deg")
    };
    let (does, others) = if slides { ("slides", "deg") } else { ("turns", "mm") };
    if unwanted.0.is_some() || unwanted.1.is_some() {
        let what = format!(
            "joint '{name}' {does}: --from-{others} and --to-{others} do not fit, give \
             --from-{unit} and --to-{unit}"
        );
        return Err(fault(None, None, what));
    }
    let (Some(from), Some(to)) = wanted else {
        let what = format!("joint '{name}' {does}: --from-{unit} and --to-{unit} must be given");
        return Err(fault(None, None, what));
    };
    if !(from.is_finite() && to.is_finite()) {
        let what = format!("--from-{unit} and --to-{unit} are {from} and {to}, must be finite");
        return Err(fault(None, None, what));
    }
    let convert = if slides { m_from_mm } else { rad_from_deg };
    Ok((convert(from), convert(to)))
}

fn slides(robot: &Robot, joint: usize) -> bool {
    robot.joints()[joint].kind == JointKind::Prismatic
}

fn joint_named(robot: &Robot, option: &str, name: &str) -> Result<usize, Vec<Fault>> {
    let names: Vec<&str> = robot.joints().iter().map(|joint| joint.name.as_str()).collect();
    names.iter().position(|known| *known == name).ok_or_else(|| {
        let hint = nearest(name, &names).map_or_else(
            || format!("; it has {}", names.join(", ")),
            |n| format!("; did you mean '{n}'?"),
        );
        fault(None, None, format!("{option}: the robot has no moving joint '{name}'{hint}"))
    })
}

/// The known name most like `name`, if one is like it.
fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    known
        .iter()
        .map(|known| (strsim::jaro_winkler(name, known), *known))
        .filter(|(likeness, _)| *likeness >= LEAST_LIKENESS)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, known)| known)
}

pub(super) fn named_value(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.rsplit_once('=').ok_or("must be NAME=VALUE, e.g. joint_2=45")?;
    match value.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok((name.trim().to_owned(), number)),
        Ok(_) | Err(_) => Err(format!("'{value}' is not a finite number")),
    }
}

pub(super) fn fault(file: Option<&Path>, line: Option<usize>, what: String) -> Vec<Fault> {
    vec![Fault { file: file.map(Path::to_owned), line, what }]
}
