//! A robot placed at a pose: where every body and every elastic axis is, in the base frame.

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::body::Composite;
use super::description::CoordinateKind;
use super::frame::Frame;
use super::products::{product, turned};
use super::robot::{NodeMotion, Robot};

/// Where the elastic coordinates are.
#[derive(Clone, Copy)]
enum Elastic<'a> {
    /// At rest, and their axes are not asked for.
    Unplaced,
    AtRest,
    /// rad or m.
    At(&'a [f64]),
}

/// Axis of a coordinate in the base frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    /// Unit direction.
    pub(super) direction: Vector3<f64>,
    /// A point of the axis.
    pub(super) point: Vector3<f64>,
    pub(super) kind: CoordinateKind,
}

impl Axis {
    /// Velocity of a body-fixed point at `p` per unit rate of the coordinate.
    pub(super) fn velocity_at(&self, p: &Vector3<f64>) -> Vector3<f64> {
        match self.kind {
            CoordinateKind::Rotation => self.direction.cross(&(p - self.point)),
            CoordinateKind::Translation => self.direction,
        }
    }

    /// Angular velocity per unit rate of the coordinate.
    pub(super) fn angular_velocity(&self) -> Vector3<f64> {
        match self.kind {
            CoordinateKind::Rotation => self.direction,
            CoordinateKind::Translation => Vector3::zeros(),
        }
    }
}

/// A robot at one pose. Its buffers are made once and filled again for every pose.
#[derive(Debug, Clone)]
pub struct Placement {
    pub(super) frames: Vec<Frame>,
    /// The pose, rad or m.
    pub(super) positions: Vec<f64>,
    /// Joint axes, in the order of a pose.
    pub(super) joint_axes: Vec<Axis>,
    /// Elastic axes, in the order of the coordinates.
    pub(super) elastic_axes: Vec<Axis>,
    /// Each node with all that it carries.
    pub(super) composites: Vec<Composite>,
}

impl Placement {
    /// Buffers for `robot`; [`Self::place`] fills them.
    pub fn new(robot: &Robot) -> Self {
        let frame = Frame { rotation: Matrix3::identity(), origin: Vector3::zeros() };
        let axis = Axis {
            direction: Vector3::zeros(),
            point: Vector3::zeros(),
            kind: CoordinateKind::Rotation,
        };
        Self {
            frames: vec![frame; robot.nodes.len()],
            positions: vec![0.0; robot.joints.len()],
            joint_axes: vec![axis; robot.joints.len()],
            elastic_axes: vec![axis; robot.coordinates.len()],
            composites: vec![Composite::default(); robot.nodes.len()],
        }
    }

    /// Places the robot at pose `q` (one value per moving joint, rad or m), elastic coordinates at
    /// rest.
    ///
    /// `q` must be a pose of the robot that the buffers were made for ([`Robot::check_pose`]).
    pub fn place(&mut self, robot: &Robot, q: &[f64]) {
        self.place_frames(robot, q, Elastic::AtRest);
        self.collect_composites(robot);
    }

    /// Places the bodies of `robot` in the frames of `other`, a robot that [stands
    /// like](Robot::stands_like) it.
    pub(crate) fn place_bodies(&mut self, robot: &Robot, other: &Self) {
        self.frames.copy_from_slice(&other.frames);
        self.positions.copy_from_slice(&other.positions);
        self.joint_axes.copy_from_slice(&other.joint_axes);
        self.elastic_axes.copy_from_slice(&other.elastic_axes);
        self.collect_composites(robot);
    }

    /// Places frames and joint axes alone: enough for
    /// [`forward_kinematics`](super::forward_kinematics) and
    /// [`joint_jacobian`](super::joint_jacobian), while bodies and elastic axes stay where they
    /// were.
    pub fn place_joints(&mut self, robot: &Robot, q: &[f64]) {
        self.place_frames(robot, q, Elastic::Unplaced);
    }

    /// Cosine of the angle between the axes of the elastic coordinates `i` and `j` as placed;
    /// `None` unless both turn.
    pub fn cosine_between(&self, i: usize, j: usize) -> Option<f64> {
        let (a, b) = (&self.elastic_axes[i], &self.elastic_axes[j]);
        let both_turn = [a, b].iter().all(|axis| axis.kind == CoordinateKind::Rotation);
        both_turn.then(|| a.direction.dot(&b.direction))
    }

    /// Places the robot at pose `q` with the elastic coordinates at `alpha` (rad or m).
    pub fn place_deflected(&mut self, robot: &Robot, q: &[f64], alpha: &[f64]) {
        self.place_frames(robot, q, Elastic::At(alpha));
        self.collect_composites(robot);
    }

    fn place_frames(&mut self, robot: &Robot, q: &[f64], elastic: Elastic<'_>) {
        self.positions.copy_from_slice(q);
        for (index, node) in robot.nodes.iter().enumerate() {
            let mut frame = match node.parent {
                None => node.fixed,
                Some(parent) => {
                    let parent = &self.frames[parent];
                    Frame {
                        rotation: product(&parent.rotation, &node.fixed.rotation),
                        origin: parent.origin + turned(&parent.rotation, &node.fixed.origin),
                    }
                }
            };
            match node.motion {
                NodeMotion::Fixed => {}
                NodeMotion::Revolute { joint, axis } => {
                    self.joint_axes[joint] = Axis {
                        direction: turned(&frame.rotation, &axis),
                        point: frame.origin,
                        kind: CoordinateKind::Rotation,
                    };
                    let turn = Rotation3::from_axis_angle(&axis, q[joint]);
                    frame.rotation = product(&frame.rotation, turn.matrix());
                }
                NodeMotion::Prismatic { joint, axis } => {
                    let direction = turned(&frame.rotation, &axis);
                    self.joint_axes[joint] =
                        Axis { direction, point: frame.origin, kind: CoordinateKind::Translation };
                    frame.origin += direction * q[joint];
                }
            }
            let coordinates = match elastic {
                Elastic::Unplaced => 0..0,
                Elastic::AtRest | Elastic::At(_) => node.coordinates.clone(),
            };
            for index in coordinates {
                let coordinate = &robot.coordinates[index];
                let direction = turned(&frame.rotation, &coordinate.axis);
                let point = frame.origin + turned(&frame.rotation, &coordinate.origin.coords);
                self.elastic_axes[index] = Axis { direction, point, kind: coordinate.kind };
                let Elastic::At(alpha) = elastic else { continue };
                let alpha = alpha[index];
                match coordinate.kind {
                    CoordinateKind::Rotation => {
                        let turn = Rotation3::from_axis_angle(&coordinate.axis, alpha);
                        frame.rotation *= turn.matrix();
                        frame.origin = point - frame.rotation * coordinate.origin.coords;
                    }
                    CoordinateKind::Translation => frame.origin += direction * alpha,
                }
            }
            self.frames[index] = frame;
        }
    }

    fn collect_composites(&mut self, robot: &Robot) {
        for (index, node) in robot.nodes.iter().enumerate() {
            let Frame { rotation, origin } = &self.frames[index];
            self.composites[index] = Composite::placed(&node.body, rotation, origin);
        }
        for (index, node) in robot.nodes.iter().enumerate().rev() {
            if let Some(parent) = node.parent {
                let carried = self.composites[index];
                self.composites[parent].add(&carried);
            }
        }
    }
}
