//! The path of an operation → moves. Waypoints are read from the tree itself: there may be a
//! million.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Isometry3;

use super::Reading;
use super::files::{MAX_FILE_BYTES, named_file, relative_to};
use super::frame::frame;
use super::raw::job as raw;
use crate::formats::text::read_bytes;
use crate::formats::yaml::{Apart, Kind, Node, Step};
use crate::model::{JointKind, Robot};
use crate::motion::{Move, Stated, StatedFeeds, Target, Timing};
use crate::notes::{Code, Note, Notes};
use crate::program::{
    self, Dialect, Program, RAPID_M_PER_S, SetBy, Setter, Settings, SpindleCommand,
};
use crate::units::{m_from_mm, rad_from_deg};

/// What the waypoints of one operation have in common.
pub(super) struct OperationContext<'c> {
    /// The operation in messages.
    pub(super) called: &'c str,
    /// The job file.
    pub(super) job: &'c Path,
    /// `None` where the robot has faults: then only what needs no robot is checked.
    pub(super) robot: Option<&'c Robot>,
    /// The job's; `None` where it gives none.
    pub(super) feed_m_per_s: Option<f64>,
    /// What waypoints state beside the motion.
    pub(super) nothing_stated: Arc<Stated>,
    /// In the tip frame; `None` where the job gives none.
    pub(super) tcp: Option<Isometry3<f64>>,
    /// In the base frame; `None` where the job gives none.
    pub(super) work_object: Option<Isometry3<f64>>,
}

impl OperationContext<'_> {
    fn to(&self, target: Target, line: u32) -> Move {
        Move {
            to: target,
            // A feed that is missing was reported; the waypoints are looked at all the same.
            feed_m_per_s: self.feed_m_per_s.unwrap_or(1.0),
            tcp: self.tcp.unwrap_or_default(),
            line: line as usize,
            timing: Timing::Feed,
            spindle_turns: true,
            stated: Arc::clone(&self.nothing_stated),
        }
    }
}

/// What is found in the programs that a job names.
#[derive(Debug, Default)]
pub(super) struct FromPrograms {
    pub(super) errors: Vec<Note>,
    pub(super) reading: Reading,
}

/// The moves of a path and what its program says beside them.
#[derive(Debug)]
pub(super) struct PathMoves {
    pub(super) moves: Vec<Move>,
    /// `None` where the path stands in the job itself.
    pub(super) program: Option<ProgramSays>,
}

/// What a program says beside its moves.
#[derive(Debug)]
pub(super) struct ProgramSays {
    pub(super) file: PathBuf,
    pub(super) spindle: Vec<SpindleCommand>,
    pub(super) feeds: StatedFeeds,
}

/// The moves of a path; `None` where there are faults.
pub(super) fn moves_of(
    context: &OperationContext<'_>,
    raw: &raw::Path,
    operation: &Node,
    notes: &mut Notes,
    programs: &mut FromPrograms,
) -> Option<PathMoves> {
    const KEYS: [&str; 3] = ["joints_deg", "poses", "program"];
    let node = operation.get("path")?;
    let given: Vec<&str> = KEYS
        .into_iter()
        .filter(|key| node.get(key).is_some_and(|value| value.faulty || !value.is_null()))
        .collect();
    let called = context.called;
    match given.as_slice() {
        [] => {
            let what = "path has no waypoints, must have one of joints_deg, poses, program";
            notes.error(
                Code::MissingKey,
                operation.line_at(&[Step::Key("path")]),
                format!("{called}: {what}"),
            );
            None
        }
        [_, second, ..] => {
            let line = node.line_at(&[Step::Key(second)]);
            let what = format!("path has {}, must have one of them", given.join(" and "));
            notes.error(Code::Conflict, line, format!("{called}: {what}"));
            None
        }
        ["joints_deg"] => raw
            .joints_deg
            .and_then(|Apart| joint_moves(context, node.get("joints_deg")?, notes))
            .map(without_program),
        ["poses"] => raw
            .poses
            .and_then(|Apart| pose_moves(context, node.get("poses")?, notes))
            .map(without_program),
        [_] => program_moves(context, raw.program.as_ref()?, node, notes, programs),
    }
}

fn without_program(moves: Vec<Move>) -> PathMoves {
    PathMoves { moves, program: None }
}

fn joint_moves(
    context: &OperationContext<'_>,
    rows: &Node,
    notes: &mut Notes,
) -> Option<Vec<Move>> {
    let robot = context.robot?;
    let before = notes.errors();
    let mut moves = Vec::with_capacity(rows.items().len());
    let mut values = Vec::new();
    for (index, row) in rows.items().iter().enumerate() {
        if row.faulty {
            continue;
        }
        numbers_into(row, &mut values);
        let waypoint = index + 1;
        match joint_position(robot, &values) {
            Ok(q) => {
                for violation in robot.limit_violations(&q) {
                    let what = format!("{}: waypoint {waypoint}: {violation}", context.called);
                    notes.error(Code::JointLimit, row.line as usize, what);
                }
                moves.push(context.to(Target::Joints(q), row.line));
            }
            Err(what) => {
                let what = format!("{}: waypoint {waypoint} {what}", context.called);
                notes.error(Code::Value, row.line as usize, what);
            }
        }
    }
    (notes.errors() == before && !moves.is_empty()).then_some(moves)
}

/// Joint positions in rad and m from a row in degrees and millimetres.
pub(super) fn joint_position(robot: &Robot, row: &[f64]) -> Result<Vec<f64>, String> {
    let joints = robot.joints();
    if row.len() != joints.len() {
        let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
        let (given, expected) = (row.len(), joints.len());
        let s = if given == 1 { "" } else { "s" };
        return Err(format!("has {given} value{s}, must have {expected}: {}", names.join(", ")));
    }
    Ok(joints
        .iter()
        .zip(row)
        .map(|(joint, &value)| match joint.kind {
            JointKind::Prismatic => m_from_mm(value),
            _ => rad_from_deg(value),
        })
        .collect())
}

fn pose_moves(
    context: &OperationContext<'_>,
    poses: &Node,
    notes: &mut Notes,
) -> Option<Vec<Move>> {
    let before = notes.errors();
    let work_object = context.work_object.unwrap_or_default();
    let mut moves = Vec::with_capacity(poses.items().len());
    for pose in poses.items() {
        // What a pose lacks or has wrong was reported when the file was checked against its schema.
        let Some(xyz) = pose.get("xyz_mm").and_then(triple) else { continue };
        let rpy = match pose.get("rpy_deg") {
            Some(rpy) if !rpy.is_null() => rpy,
            _ => {
                moves
                    .push(context.to(Target::Line(work_object * placed(xyz, [0.0; 3])), pose.line));
                continue;
            }
        };
        let Some(rpy) = triple(rpy) else { continue };
        moves.push(context.to(Target::Line(work_object * placed(xyz, rpy)), pose.line));
    }
    let whole = moves.len() == poses.items().len();
    (notes.errors() == before && whole && !moves.is_empty()).then_some(moves)
}

fn placed(xyz_mm: [f64; 3], rpy_deg: [f64; 3]) -> Isometry3<f64> {
    frame(xyz_mm.map(m_from_mm), rpy_deg.map(rad_from_deg))
}

fn triple(node: &Node) -> Option<[f64; 3]> {
    if node.faulty {
        return None;
    }
    let mut values = Vec::new();
    numbers_into(node, &mut values);
    values.try_into().ok()
}

/// The numbers of a list in which every item is one, whether on one line or not.
fn numbers_into(node: &Node, values: &mut Vec<f64>) {
    values.clear();
    match &node.kind {
        Kind::Numbers(numbers) => values.extend_from_slice(numbers),
        _ => values.extend(node.items().iter().filter_map(Node::number)),
    }
}

/// The moves that a robot or CAM program asks for.
fn program_moves(
    context: &OperationContext<'_>,
    raw: &raw::Program,
    path: &Node,
    notes: &mut Notes,
    programs: &mut FromPrograms,
) -> Option<PathMoves> {
    let name = raw.file.as_deref()?;
    let line = path.line_at(&[Step::Key("program")]);
    let file = relative_to(context.job, name);
    let pending = programs.reading.pending_at(&file).map(<[u8]>::to_vec);
    let file = match &pending {
        Some(_) => file,
        None => named_file(context.job, "path.program.file", name, line, notes)?,
    };
    let extension = file.extension().unwrap_or_default().to_string_lossy();
    let Some(dialect) = Dialect::from_extension(&extension) else {
        let what = format!(
            "path.program.file '{name}': extension '{extension}' is not one of RAPID (.mod, .prg), \
                APT (.apt, .cls) and G-code (.nc, .gcode, .ngc)"
        );
        notes.error(Code::Unreadable, line, format!("{}: {what}", context.called));
        return None;
    };
    if let (Some(procedure), Dialect::Apt | Dialect::GCode) = (&raw.procedure, dialect) {
        let line = path.line_at(&[Step::Key("program"), Step::Key("procedure")]);
        let what = format!(
            "{}: path.program.procedure '{procedure}' has no effect: {dialect} has no procedures",
            context.called
        );
        notes.warning(Code::Unused, line, what);
    }
    for (key, given) in
        [("spindle_from", raw.spindle_from.is_some()), ("tool_from", raw.tool_from.is_some())]
    {
        if given && dialect != Dialect::Rapid {
            let line = path.line_at(&[Step::Key("program"), Step::Key(key)]);
            let what = format!(
                "{}: path.program.{key} has no effect: {dialect} has words of its own for it",
                context.called
            );
            notes.warning(Code::Unused, line, what);
        }
    }
    programs.reading.files.push(file.clone());
    let bytes = match pending.map_or_else(|| read_bytes(&file, MAX_FILE_BYTES), Ok) {
        Ok(bytes) => bytes,
        Err(fault) => {
            programs.errors.push(fault);
            return None;
        }
    };
    let settings = Settings {
        procedure: raw.procedure.clone(),
        tcp: context.tcp,
        work_object: context.work_object,
        feed_m_per_s: context.feed_m_per_s,
        rapid_m_per_s: RAPID_M_PER_S,
        joint_count: context.robot?.joints().len(),
        spindle_from: raw.spindle_from.as_ref().and_then(|from| {
            let raw::SpindleFrom { signal, procedure, argument, comment, rpm_per_unit } = from;
            let what = [signal, procedure, comment];
            setter(context, path, "spindle_from", what, *argument, *rpm_per_unit, notes)
        }),
        tool_from: raw.tool_from.as_ref().and_then(|from| {
            let raw::ToolFrom { signal, procedure, argument, comment } = from;
            setter(context, path, "tool_from", [signal, procedure, comment], *argument, None, notes)
        }),
        ..Settings::default()
    };
    programs.reading.programs.push((file.clone(), settings.clone()));
    let located = |mut note: Note| {
        note.place.file = Some(file.clone());
        note
    };
    match program::read(&bytes, dialect, &settings) {
        Ok(Program { moves, spindle, feeds, warnings, .. }) => {
            programs.reading.warnings.extend(warnings.into_iter().map(located));
            Some(PathMoves { moves, program: Some(ProgramSays { file, spindle, feeds }) })
        }
        Err(found) => {
            programs.errors.extend(found.into_iter().map(located));
            None
        }
    }
}

/// What of a RAPID program sets a number: a signal, a procedure or a comment.
fn setter(
    context: &OperationContext<'_>,
    path: &Node,
    key: &str,
    what: [&Option<String>; 3],
    argument: Option<u32>,
    per_unit: Option<f64>,
    notes: &mut Notes,
) -> Option<SetBy> {
    let what = match what {
        [Some(signal), None, None] => Setter::Signal(signal.clone()),
        [None, Some(procedure), None] => {
            Setter::Procedure(procedure.clone(), argument.unwrap_or(1) as usize)
        }
        [None, None, Some(comment)] => Setter::Comment(comment.clone()),
        _ => {
            let line = path.line_at(&[Step::Key("program"), Step::Key(key)]);
            let what = "must have one of signal, procedure, comment";
            notes.error(
                Code::Conflict,
                line,
                format!("{}: path.program.{key} {what}", context.called),
            );
            return None;
        }
    };
    Some(SetBy { what, per_unit: per_unit.unwrap_or(1.0) })
}
