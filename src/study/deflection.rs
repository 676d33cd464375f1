//! A robot or a job → how far the tool tip gives way at rest.

use std::path::Path;

use nalgebra::{Matrix3, Point3, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use super::map::{Source, outside_warning};
use super::{Read, advise};
use crate::excitation::ForceModel;
use crate::input::{self, FileKind, file_kind};
use crate::job::{Job, Operation, TipMode, Tool};
use crate::map::OutsideLimits;
use crate::model::{JointKind, Placement, Robot};
use crate::modes::{Principal, Statics};
use crate::notes::{Code, Note, Part, Place};
use crate::path::tool_frames;
use crate::process::{DrillMove, InWork, drills, in_work};
use crate::risk::{Paths, about_operation, in_operation};
use crate::units::{Date, hz_from_rpm, rad_per_s_from_hz, written};

/// Most poses.
const MAX_POSES: usize = 1_000_000;

/// Steps along an operation.
const STEPS: usize = 100;

/// What deflections are asked of.
#[derive(Debug)]
pub enum Subject {
    /// A robot, at poses that are named.
    Robot(Box<Robot>),
    /// A job, along its paths.
    Job(Box<Job>),
}

/// What is asked of a robot; a job has the force of its cut where none is given.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Load {
    /// Force on the tool tip in the base frame, N.
    pub force_n: Option<[f64; 3]>,
    /// Moment on the tool in the base frame, N m.
    pub moment_nm: Option<[f64; 3]>,
    /// The tool tip in the tip frame of a robot, m; a job has its own.
    pub tcp_m: [f64; 3],
}

/// The tool tip at one pose.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Deflection {
    /// Of a job: the operation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operation: Option<String>,
    /// Of a job: the place of the path, 0..=1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub s: Option<f64>,
    /// Joint positions, rad or m, base to tip.
    pub joints: Vec<f64>,
    /// How each spring gives way under gravity, rad or m.
    pub sag: Vec<f64>,
    /// How gravity moves the tip, in the base frame.
    #[serde(rename = "gravity_um", serialize_with = "written::um")]
    pub gravity_m: [f64; 3],
    /// Force on the tip, in the base frame; null where it is not known.
    pub force_n: Option<[f64; 3]>,
    /// Moment on the tool, in the base frame: of a job the torque of a drill where it is known;
    /// null where no force is.
    pub moment_nm: Option<[f64; 3]>,
    /// How force and moment move the tip, in the base frame.
    #[serde(rename = "deflection_um", serialize_with = "written::um")]
    pub deflection_m: Option<[f64; 3]>,
    /// Of a job: the same along the feed, across it (y = z × x) and along the spindle, out of the
    /// work.
    #[serde(rename = "in_tool_um", serialize_with = "written::um")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub in_tool_m: Option<[f64; 3]>,
    /// The axes of the compliance ellipsoid, softest first.
    pub principal: [Principal; 3],
}

impl Deflection {
    /// Length of the deflection under force and moment, m.
    pub fn size_m(&self) -> Option<f64> {
        self.deflection_m.map(|moved| Vector3::from(moved).norm())
    }
}

/// All that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Deflections {
    /// Of the robot or the job.
    pub name: String,
    /// Names of the joints, and whether each turns.
    pub joints: Vec<(String, bool)>,
    /// Names of the elastic coordinates.
    pub coordinates: Vec<String>,
    /// Pose after pose.
    pub rows: Vec<Deflection>,
    /// What is left out.
    pub warnings: Vec<Note>,
}

/// A force, N, and a moment, N m, in the base frame.
type Wrench = [Vector3<f64>; 2];

impl Load {
    /// `None` where neither is given.
    fn wrench(&self) -> Option<Wrench> {
        let given = [self.force_n, self.moment_nm];
        let is_any = given.iter().any(Option::is_some);
        is_any.then(|| given.map(|of| Vector3::from(of.unwrap_or_default())))
    }
}

/// Reads a job or a robot.
pub fn read(file: &Path, today: Date) -> Read<Subject> {
    if let Ok(FileKind::Job) = file_kind(file) {
        let Read { value, warnings, files } = advise::read(file, today);
        return Read { value: value.map(|job| Subject::Job(Box::new(job))), warnings, files };
    }
    let read = Read::of(|reading| input::read_robot(file, reading));
    let Read { value, warnings, files } = read;
    Read { value: value.map(|robot| Subject::Robot(Box::new(robot))), warnings, files }
}

fn named(robot: &Robot) -> (Vec<(String, bool)>, Vec<String>) {
    let joints = robot.joints().iter();
    let joints = joints.map(|j| (j.name.clone(), j.kind != JointKind::Prismatic)).collect();
    (joints, robot.coordinates().iter().map(|c| c.name.clone()).collect())
}

/// A robot at poses.
///
/// # Errors
/// Poses that cannot be read, or at which the springs do not hold the arm.
pub fn of_robot(robot: &Robot, source: Source, load: &Load) -> Result<Deflections, Vec<Note>> {
    let mut placement = Placement::new(robot);
    let (mut rows, mut outside) = (Vec::new(), OutsideLimits::default());
    for (index, q) in source.poses(MAX_POSES)?.into_iter().enumerate() {
        let refused =
            |code, what: String| vec![Note::error(code, Place::part(Part::Pose(index)), what)];
        robot.check_pose(&q).map_err(|fault| refused(Code::Value, fault.to_string()))?;
        outside.look_at(robot, &q);
        placement.place(robot, &q);
        let statics = Statics::of(robot, &placement, &Point3::from(load.tcp_m))
            .ok_or_else(|| refused(Code::Singular, no_hold()))?;
        rows.push(row(q, &statics, load.wrench()));
    }
    let (joints, coordinates) = named(robot);
    let name = robot.name().to_owned();
    let warnings = outside_warning(robot, outside, rows.len()).into_iter().collect();
    Ok(Deflections { name, joints, coordinates, rows, warnings })
}

fn no_hold() -> String {
    "the stiffness matrix is not positive definite: the springs do not hold the arm".to_owned()
}

fn row(joints: Vec<f64>, statics: &Statics, wrench: Option<Wrench>) -> Deflection {
    let moved = |[force, moment]: Wrench| {
        statics.compliance_m_per_n * force + statics.compliance_m_per_nm * moment
    };
    Deflection {
        operation: None,
        s: None,
        joints,
        sag: statics.sag.clone(),
        gravity_m: statics.sag_m.into(),
        force_n: wrench.map(|[force, _]| force.into()),
        moment_nm: wrench.map(|[_, moment]| moment.into()),
        deflection_m: wrench.map(|wrench| moved(wrench).into()),
        in_tool_m: None,
        principal: statics.principal,
    }
}

/// A job along its paths: under a force and a moment that are given, else under the mean cutting
/// force of every operation that says how it cuts, and the torque of a drill.
///
/// # Errors
/// A path that cannot be run; a pose at which the springs do not hold the arm.
pub fn of_job(job: &Job, load: &Load) -> Result<Deflections, Vec<Note>> {
    let (joints, coordinates) = named(&job.robot);
    let (mut rows, mut warnings, mut errors) = (Vec::new(), Vec::new(), Vec::new());
    let mut paths = Paths::of(job);
    for operation in &job.operations {
        let model = operation.cutting.as_ref().and_then(|c| ForceModel::new(&operation.tool, c));
        if load.wrench().is_none() && model.is_none() {
            let what = "the mean cutting force is not known (cutting with material or \
                        coefficients, tool.diameter_mm), so its deflection is not told";
            warnings.push(about_operation(job, operation, Code::Remark, what.to_owned()));
        }
        let found = paths
            .plan(operation)
            .and_then(|path| along(job, operation, &path, model.as_ref(), load));
        match found {
            Ok(found) => rows.extend(found),
            Err(found) => errors.extend(found),
        }
    }
    let name = job.name.clone();
    if errors.is_empty() {
        Ok(Deflections { name, joints, coordinates, rows, warnings })
    } else {
        Err(errors)
    }
}

fn along(
    job: &Job,
    operation: &Operation,
    path: &crate::path::Path<'_>,
    model: Option<&ForceModel>,
    load: &Load,
) -> Result<Vec<Deflection>, Vec<Note>> {
    let s: Vec<f64> = (0..=STEPS).map(|i| i as f64 / STEPS as f64).collect();
    let at_fault = |note| vec![in_operation(job, operation, note)];
    let frames = tool_frames(path, &s).map_err(at_fault)?;
    let robot = path.robot();
    let (mut reader, mut placement) = (path.reader(), Placement::new(robot));
    let mut rows = Vec::new();
    let stops = path.spindle_stops();
    for (s, (frame, feed)) in s.into_iter().zip(frames) {
        let mut q = vec![0.0; robot.joints().len()];
        let at = Place::part(Part::Operation(operation.name.clone()));
        let refused =
            |code, what: String| vec![Note::error(code, at.clone(), format!("at s = {s}: {what}"))];
        let tcp = reader.at(s, &mut q).map_err(|f| refused(Code::Unreachable, f.to_string()))?;
        placement.place(robot, &q);
        let statics = Statics::of(robot, &placement, &tcp.translation.vector.into())
            .and_then(|arm| arm.with(&compliance_of_tool(&operation.tool, &frame)))
            .ok_or_else(|| refused(Code::Singular, no_hold()))?;
        let mean = || {
            let rpm = operation.speed.rpm_at(s);
            let turns = rpm > 0.0 && !stops.iter().any(|[from, to]| (from..=to).contains(&&s));
            let may_cut = matches!(in_work(operation, path, s), InWork::Cuts | InWork::TakenForAir)
                && drills(operation, &feed).is_none_or(|how| how == DrillMove::Into);
            let per_tooth =
                path.feed_m_per_s_at(s) / (hz_from_rpm(rpm) * f64::from(operation.tool.teeth));
            let model = model.filter(|_| turns && may_cut)?;
            let force = frame.iter().zip(model.mean_n(per_tooth)).map(|(axis, n)| axis * n).sum();
            let torque = model.drilling().and_then(|drill| drill.torque_nm(per_tooth));
            Some([force, frame[2] * torque.unwrap_or(0.0)])
        };
        let mut found = row(q, &statics, load.wrench().or_else(mean));
        let moved = found.deflection_m.map(Vector3::from);
        found.in_tool_m = moved.map(|moved| frame.map(|axis| axis.dot(&moved)));
        rows.push(Deflection { operation: Some(operation.name.clone()), s: Some(s), ..found });
    }
    Ok(rows)
}

/// How far the tool itself gives way, by its own modes, in the base frame, m/N.
fn compliance_of_tool(tool: &Tool, frame: &[Vector3<f64>; 3]) -> Matrix3<f64> {
    let [x, y, z] = frame;
    let of = |mode: &TipMode| {
        let axis = x * mode.axis.x + y * mode.axis.y + z * mode.axis.z;
        let stiffness = mode.mass_kg * rad_per_s_from_hz(mode.frequency_hz).powi(2);
        axis * axis.transpose() / stiffness
    };
    tool.modes.iter().map(of).sum()
}
