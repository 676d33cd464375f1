//! The arm of a job as it moves and vibrates along its paths: what a picture of it needs, without
//! the model. Every length is in m, every frame in that of the part that carries it.

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Matrix6xX, Point3, SymmetricEigen, Vector3};
use serde::Serialize;

use super::check::CheckedJob;
pub use crate::input::Surface;
use crate::input::{MAX_MESHES, Meshes};
use crate::job::{Job, Operation};
use crate::map::{Block, Row};
use crate::model::{
    CoordinateKind, NodeMotion, PlacedMesh, PoseFault, Robot, UncertainBody, elastic_jacobian,
    forward_kinematics,
};
use crate::modes::{ModalSolver, peak_tip_compliances_m_per_n};
use crate::notes::Note;
use crate::path::{Path, Surveyor};
use crate::risk::{OperationRisk, Paths, Sample, closest_approach, in_operation};
use crate::units::written;

/// At most so many numbers about places are kept for a job, some 20 bytes each when written.
const MAX_NUMBERS: usize = 20_000;

/// An operation keeps so many places at least, and at most.
const PLACES: [usize; 2] = [8, 400];

/// An arm and where it stands along the operations of a job.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MovingArm {
    /// The arm at rest, all joints at zero.
    pub arm: Arm,
    /// Per operation, some places of its path, ascending in s.
    pub places: Vec<Vec<Place>>,
    /// The surfaces of its meshes.
    #[serde(skip)]
    pub surfaces: Vec<Arc<Surface>>,
}

/// A chain of rigid parts with joints and elastic axes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Arm {
    /// Names of the joints, in the order of a pose.
    pub joints: Vec<String>,
    /// Rigid parts, parents before children.
    pub parts: Vec<Part>,
    /// Elastic coordinates, in the order of a shape.
    pub axes: Vec<ElasticAxis>,
    /// The part that carries the tip.
    pub tip_part: usize,
    /// The tip in that part's frame.
    pub tip: Frame,
    /// Meshes that could not be drawn; capsules stand for their parts.
    pub missing_meshes: Vec<MissingMesh>,
}

/// A mesh that could not be drawn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MissingMesh {
    /// The link that it shows.
    pub link: String,
    /// As the URDF names it.
    pub file: String,
    /// What is wrong with it.
    pub why: String,
}

/// A mesh of a part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PartMesh {
    /// The link that it shows.
    pub link: String,
    /// The key of its surface.
    pub surface: String,
    /// Its frame in the part's.
    pub frame: Frame,
    /// Factors along its own axes.
    pub scale: [f64; 3],
}

/// All links that never move against each other.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// The part that carries it.
    pub parent: Option<usize>,
    /// Its frame in the parent's, with the joint at zero.
    pub frame: Frame,
    /// How it moves with the pose.
    pub joint: Option<JointMotion>,
    /// Elastic coordinates that move it, outermost first: the first, and the one behind the last.
    pub axes: [usize; 2],
    /// Its bodies.
    pub bodies: Vec<Ellipsoid>,
    /// Its meshes; empty where there is none, or where one could not be read.
    pub meshes: Vec<PartMesh>,
}

/// A place and an orientation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Frame {
    /// Origin.
    pub xyz_m: [f64; 3],
    /// Rotation matrix, row by row.
    pub rotation: [f64; 9],
}

/// A joint that a pose sets.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointMotion {
    /// Place in the pose.
    pub index: usize,
    /// Whether it slides instead of turning.
    pub slides: bool,
    /// In the part's frame.
    pub axis: [f64; 3],
}

/// What an elastic coordinate turns about, or slides along.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElasticAxis {
    /// Name of the coordinate.
    pub name: String,
    /// Whether it slides instead of turning.
    pub slides: bool,
    /// In the part's frame.
    pub axis: [f64; 3],
    /// A point of the axis in the part's frame.
    pub origin_m: [f64; 3],
}

/// The solid ellipsoid with a body's mass and inertia.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Ellipsoid {
    /// The link that it belongs to.
    pub link: String,
    /// Mass of the body.
    pub mass_kg: f64,
    /// Centre of mass and principal axes, in the part's frame.
    pub frame: Frame,
    /// Along the principal axes.
    pub semi_axes_m: [f64; 3],
}

/// The arm at one place of a path.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Place {
    /// What the check says of it.
    #[serde(flatten)]
    pub sample: Sample,
    /// The line of the program, or of the job, that is run there; of a map the pose, from 1.
    pub line: usize,
    /// Distance to the nearest line of excitation, in percent of the mode's frequency; null where
    /// none counts.
    #[serde(rename = "margin_percent", serialize_with = "written::percent")]
    pub margin: Option<f64>,
    /// Tool centre point in the tip frame.
    pub tool_m: [f64; 3],
    /// Tool centre point in the base frame.
    pub tcp_m: [f64; 3],
    /// Per mode, the share of critical damping.
    pub damping_ratios: Vec<f64>,
    /// Per mode, the mass-normalised shape over the elastic coordinates.
    pub shapes: Vec<Vec<f64>>,
}

/// The arm of a job that was checked, at some of the samples of each operation.
///
/// # Errors
/// What the check would have found already.
pub fn moving_arm(
    job: &Job,
    checked: &CheckedJob,
    meshes: &Meshes,
) -> Result<MovingArm, Vec<Note>> {
    let operations = &checked.risk.operations;
    let count = places_of(&job.robot, operations.len());
    let mut paths = Paths::of(job);
    let mut places = Vec::new();
    for (operation, risk) in job.operations.iter().zip(operations) {
        let path = paths.plan(operation)?;
        let of_path = along(job, operation, &path, risk, count);
        places.push(of_path.map_err(|note| vec![in_operation(job, operation, note)])?);
    }
    let mut arm = arm(&job.robot);
    let surfaces = dress(&mut arm, &job.robot, meshes);
    Ok(MovingArm { arm, places, surfaces })
}

/// The arm at poses of a map, as one operation whose s counts them from 0 to 1: evenly some of
/// them.
///
/// # Errors
/// The arm has no modes at a pose.
pub fn arm_at_poses(robot: &Robot, block: &Block, meshes: &Meshes) -> Result<MovingArm, PoseFault> {
    let step = block.count.div_ceil(places_of(robot, 1)).max(1);
    let last = block.count.saturating_sub(1).max(1) as f64;
    let mut solver = ModalSolver::new(robot);
    let mut jacobian = Matrix6xX::zeros(robot.coordinates().len());
    let mut place = |(index, row): (usize, Row)| {
        let modes = solver.solve(row.joints)?.clone();
        let tip = forward_kinematics(robot, solver.placement());
        elastic_jacobian(robot, solver.placement(), &Point3::origin(), &mut jacobian);
        let count = modes.natural_frequencies_hz.len();
        let mut tip_response_m_per_n = vec![0.0; count];
        peak_tip_compliances_m_per_n(robot, &modes, &jacobian, &mut tip_response_m_per_n);
        // As the map has them, to the last digit; those of spectra are other ones.
        let frequencies = match row.nonlinear {
            None => row.frequencies_hz.to_vec(),
            Some(_) => modes.natural_frequencies_hz.clone(),
        };
        let interval = |(r, hz): (usize, &f64)| match row.intervals_hz.get(2 * r..2 * r + 2) {
            Some(ends) => [ends[0], ends[1]],
            None => [*hz; 2],
        };
        let sample = Sample {
            s: index as f64 / last,
            joints: row.joints.to_vec(),
            beta1_rad: None,
            beta2_rad: row.beta2_rad.first().copied(),
            rpm: 0.0,
            natural_frequencies_ci95_hz: frequencies.iter().enumerate().map(interval).collect(),
            natural_frequencies_hz: frequencies,
            tip_response_m_per_n,
            families: (0..count).map(Some).collect(),
        };
        let shapes = modes.shapes.column_iter().map(|shape| shape.iter().copied().collect());
        Ok(Place {
            sample,
            line: index + 1,
            margin: None,
            tool_m: [0.0; 3],
            tcp_m: tip.translation.vector.into(),
            damping_ratios: modes.damping_ratios,
            shapes: shapes.collect(),
        })
    };
    let places: Result<Vec<Place>, PoseFault> =
        block.rows().enumerate().step_by(step).map(&mut place).collect();
    let mut arm = arm(robot);
    let surfaces = dress(&mut arm, robot, meshes);
    Ok(MovingArm { arm, places: vec![places?], surfaces })
}

/// So many places an operation, of so many operations.
fn places_of(robot: &Robot, operations: usize) -> usize {
    let (n, joints) = (robot.coordinates().len(), robot.joints().len());
    let numbers = n * n + 5 * n + joints + 12;
    (MAX_NUMBERS / numbers / operations.max(1)).clamp(PLACES[0], PLACES[1])
}

fn along(
    job: &Job,
    operation: &Operation,
    path: &Path,
    risk: &OperationRisk,
    count: usize,
) -> Result<Vec<Place>, Note> {
    let mut surveyor = Surveyor::new(path);
    let mut reader = path.reader();
    let mut place = |sample: &Sample| {
        let s = sample.s;
        let modes = surveyor.modes(s)?.clone();
        let mut q = surveyor.joints().to_vec();
        // Read a moment ago, so the path is known to be reached.
        let tool = reader.at(s, &mut q).map(|tcp| tcp.translation.vector).unwrap_or_default();
        let tip = forward_kinematics(&operation.robot, surveyor.solver().placement());
        let least = risk.min_tip_response_m_per_n;
        let nearest =
            closest_approach(std::slice::from_ref(sample), &risk.lines, &job.policy, least);
        let shapes = modes.shapes.column_iter().map(|shape| shape.iter().copied().collect());
        Ok(Place {
            sample: sample.clone(),
            line: path.line_at(s),
            margin: nearest.map(|approach| approach.separation),
            tool_m: tool.into(),
            tcp_m: tip.transform_point(&tool.into()).coords.into(),
            damping_ratios: modes.damping_ratios.clone(),
            shapes: shapes.collect(),
        })
    };
    chosen(risk, count).into_iter().map(|i| place(&risk.samples[i])).collect()
}

/// Samples that stand for all: even in s, with those next to where lines come closest.
fn chosen(risk: &OperationRisk, count: usize) -> BTreeSet<usize> {
    let samples = &risk.samples;
    let next_to = |s: f64| {
        let after = samples.partition_point(|sample| sample.s < s);
        let apart = |i: &usize| (samples[*i].s - s).abs();
        let near = [after.saturating_sub(1), after].into_iter().filter(|i| *i < samples.len());
        near.min_by(|a, b| apart(a).total_cmp(&apart(b)))
    };
    let even = (0..count).map(|k| k as f64 / (count - 1) as f64);
    let closest = risk.crossings.iter().take(count / 4).map(|crossing| crossing.closest_s);
    even.chain(closest).chain(risk.closest.map(|approach| approach.s)).filter_map(next_to).collect()
}

fn arm(robot: &Robot) -> Arm {
    let (tip_part, tip) = robot.tip();
    let parts = robot.nodes().iter().enumerate().map(|(index, node)| Part {
        parent: node.parent,
        frame: Frame { xyz_m: node.fixed.origin.into(), rotation: rows(&node.fixed.rotation) },
        joint: match node.motion {
            NodeMotion::Fixed => None,
            NodeMotion::Revolute { joint, axis } => {
                Some(JointMotion { index: joint, slides: false, axis: axis.into_inner().into() })
            }
            NodeMotion::Prismatic { joint, axis } => {
                Some(JointMotion { index: joint, slides: true, axis: axis.into_inner().into() })
            }
        },
        axes: [node.coordinates.start, node.coordinates.end],
        bodies: robot.bodies().iter().filter(|b| b.node == index).map(ellipsoid).collect(),
        meshes: Vec::new(),
    });
    let axes = robot.coordinates().iter().map(|coordinate| ElasticAxis {
        name: coordinate.name.clone(),
        slides: coordinate.kind == CoordinateKind::Translation,
        axis: coordinate.axis.into_inner().into(),
        origin_m: coordinate.origin.coords.into(),
    });
    Arm {
        joints: robot.joints().iter().map(|joint| joint.name.clone()).collect(),
        parts: parts.collect(),
        axes: axes.collect(),
        tip_part,
        tip: frame(tip),
        missing_meshes: Vec::new(),
    }
}

/// Gives the parts their meshes.
fn dress(arm: &mut Arm, robot: &Robot, meshes: &Meshes) -> Vec<Arc<Surface>> {
    let mut surfaces: Vec<Arc<Surface>> = Vec::new();
    let mut bare = BTreeSet::new();
    for (index, PlacedMesh { link, node, mesh }) in robot.meshes().iter().enumerate() {
        let surface = if index < MAX_MESHES {
            meshes.surface(mesh)
        } else {
            Err(format!("only {MAX_MESHES} meshes of a robot are drawn"))
        };
        match surface {
            Ok(surface) => {
                if let Some(part) = arm.parts.get_mut(*node) {
                    part.meshes.push(PartMesh {
                        link: link.clone(),
                        surface: surface.key.clone(),
                        frame: frame(&mesh.frame),
                        scale: mesh.scale,
                    });
                }
                if surfaces.iter().all(|known| known.key != surface.key) {
                    surfaces.push(surface);
                }
            }
            Err(why) => {
                bare.insert(*node);
                let (link, file) = (link.clone(), mesh.file.clone());
                arm.missing_meshes.push(MissingMesh { link, file, why });
            }
        }
    }
    for part in bare {
        arm.parts[part].meshes.clear();
    }
    surfaces
}

fn frame(pose: &Isometry3<f64>) -> Frame {
    let rotation = pose.rotation.to_rotation_matrix();
    Frame { xyz_m: pose.translation.vector.into(), rotation: rows(rotation.matrix()) }
}

fn rows(matrix: &Matrix3<f64>) -> [f64; 9] {
    let mut rows = [0.0; 9];
    rows.copy_from_slice(matrix.transpose().as_slice());
    rows
}

/// An ellipsoid of mass m has I_x = m (b² + c²) / 5, so a² = 5 (I_y + I_z − I_x) / 2m.
fn ellipsoid(of: &UncertainBody) -> Ellipsoid {
    let body = &of.body;
    let principal = SymmetricEigen::new(body.inertia_kgm2);
    let [x, y, z]: [f64; 3] = principal.eigenvalues.into();
    let semi_axis = |own: f64, others: f64| {
        let square = 2.5 * (others - own) / body.mass_kg;
        if square.is_finite() { square.max(0.0).sqrt() } else { 0.0 }
    };
    let mut turn = principal.eigenvectors;
    if turn.determinant() < 0.0 {
        turn.set_column(2, &-turn.column(2).into_owned());
    }
    let center: Vector3<f64> = body.com_m;
    Ellipsoid {
        link: of.link.clone(),
        mass_kg: body.mass_kg,
        frame: Frame { xyz_m: center.into(), rotation: rows(&turn) },
        semi_axes_m: [semi_axis(x, y + z), semi_axis(y, x + z), semi_axis(z, x + y)],
    }
}
