//! The path of an operation → moves. Waypoints are read from the tree itself: there may be a
//! million.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Isometry3;

use super::Reading;
use super::frame::frame;
use crate::formats::yaml::{Kind, Node};
use crate::model::{JointKind, Robot};
use crate::motion::{Move, Stated, StatedFeeds, Target, Timing};
use crate::notes::{Code, Note, Notes};
use crate::program::{Assumed, ExternalAxis, SpindleCommand};
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
    /// Joints that programs move as external axes, by the axis's name in lower case.
    pub(super) external_axes: &'c BTreeMap<String, ExternalAxis>,
    /// What programs are taken to find, by name in lower case.
    pub(super) assume: &'c BTreeMap<String, Assumed>,
    /// Whether the spindle's speed follows the operation's time.
    pub(super) is_scheduled: bool,
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

pub(super) fn joint_moves(
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

pub(super) fn pose_moves(
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
        let Some(rpy) = pose.get("rpy_deg") else {
            moves.push(context.to(Target::Line(work_object * placed(xyz, [0.0; 3])), pose.line));
            continue;
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
