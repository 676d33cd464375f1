//! A place in space with its rotation as a matrix.

use nalgebra::{Isometry3, Matrix3, Vector3};

/// Position and orientation of a node in another frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) rotation: Matrix3<f64>,
    pub(crate) origin: Vector3<f64>,
}

impl From<Isometry3<f64>> for Frame {
    fn from(pose: Isometry3<f64>) -> Self {
        Self {
            rotation: *pose.rotation.to_rotation_matrix().matrix(),
            origin: pose.translation.vector,
        }
    }
}
