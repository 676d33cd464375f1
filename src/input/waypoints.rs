//! The path of an operation → moves. Waypoints are read from the tree itself: there may be a
//! million.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Isometry3;

use super::Reading;
use super::frame::frame;
use crate::formats::yaml::{Kind, Node};
use crate::model::{JointKind, Robot};
use crate::motion::{Move, Stated, StatedFeeds, Target, Timing, Work};
use crate::notes::{Code, Note, Notes};
use crate::program::{Assumed, Dialect, ExternalAxis, SpindleCommand};
use crate::units::{deg_from_rad, m_from_mm, rad_from_deg};
use crate::wording::rounded;

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
    /// Numbers of the job's tools by their names.
    pub(super) tool_names: &'c BTreeMap<String, u32>,
    /// Diameters of the job's tools by their numbers, mm; `None` is the only one.
    pub(super) tool_diameters_mm: &'c BTreeMap<Option<u32>, f64>,
    /// The job's, where it states one for the whole operation, rev/min.
    pub(super) spindle_rpm: Option<f64>,
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
            work: Work::Stands,
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
    /// What `assume` gives and a program names.
    pub(super) assumed: BTreeSet<String>,
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
    /// As the job names it: of a list or a folder, the file in which it starts.
    pub(super) called: PathBuf,
    pub(super) file: PathBuf,
    pub(super) dialect: Dialect,
    pub(super) spindle: Vec<SpindleCommand>,
    pub(super) speed_step_rpm: Option<f64>,
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
    joints_in_radians(context, robot, &moves, rows, notes);
    (notes.errors() == before && !moves.is_empty()).then_some(moves)
}

/// Fewest joints of which all positions are small by chance.
const MIN_JOINTS: usize = 4;

/// Whether a number has more than two decimal places, as radians and metres mostly have.
fn is_fine(value: f64) -> bool {
    (value * 1e2 - (value * 1e2).round()).abs() > 1e-6
}

/// Doubts an arm of which all joints stay within two turns' worth of radians, as degrees.
fn joints_in_radians(
    context: &OperationContext<'_>,
    robot: &Robot,
    moves: &[Move],
    rows: &Node,
    notes: &mut Notes,
) {
    let turning: Vec<usize> = (0..robot.joints().len())
        .filter(|&joint| robot.joints()[joint].kind != JointKind::Prismatic)
        .collect();
    let degrees = || {
        let positions = moves.iter().filter_map(|each| match &each.to {
            Target::Joints(q) => Some(q),
            _ => None,
        });
        positions.flat_map(|q| turning.iter().map(|&joint| deg_from_rad(q[joint])))
    };
    let is_small = degrees().all(|deg| deg.abs() <= std::f64::consts::TAU);
    if turning.len() >= MIN_JOINTS && moves.len() > 1 && is_small && degrees().any(is_fine) {
        let most = degrees().fold(0.0, |most: f64, deg| most.max(deg.abs()));
        let what = format!(
            "{}: no joint is farther than {}° from zero anywhere; are joints_deg in radians?",
            context.called,
            rounded(most, 3)
        );
        notes.warning(Code::CadUnits, rows.line as usize, what);
    }
}

/// Doubts a path of a few millimetres about the origin.
fn poses_in_metres(
    context: &OperationContext<'_>,
    points_mm: &[[f64; 3]],
    poses: &Node,
    notes: &mut Notes,
) {
    /// No arm reaches farther than so many metres; no cut is so short in millimetres.
    const REACH: f64 = 3.5;
    let apart = |pair: &[[f64; 3]]| {
        pair[0].iter().zip(pair[1]).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let length_mm: f64 = points_mm.windows(2).map(apart).sum();
    let mut values = points_mm.iter().flatten();
    let is_near = values.clone().all(|v| v.abs() <= REACH);
    if length_mm > 0.0 && length_mm <= REACH && is_near && values.any(|v| is_fine(*v)) {
        let what = format!(
            "{}: the whole path is {} mm long and within {REACH} mm of the work object's origin; \
             is xyz_mm in metres?",
            context.called,
            rounded(length_mm, 3)
        );
        notes.warning(Code::CadUnits, poses.line as usize, what);
    }
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
    let mut points_mm = Vec::with_capacity(poses.items().len());
    for pose in poses.items() {
        // What a pose lacks or has wrong was reported when the file was checked against its schema.
        let Some(xyz) = pose.get("xyz_mm").and_then(triple) else { continue };
        points_mm.push(xyz);
        let Some(rpy) = pose.get("rpy_deg") else {
            moves.push(context.to(Target::Line(work_object * placed(xyz, [0.0; 3])), pose.line));
            continue;
        };
        let Some(rpy) = triple(rpy) else { continue };
        moves.push(context.to(Target::Line(work_object * placed(xyz, rpy)), pose.line));
    }
    poses_in_metres(context, &points_mm, poses, notes);
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
