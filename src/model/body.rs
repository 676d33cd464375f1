//! Mass properties of rigid bodies: seen from other frames, put together.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::description::Inertial;
use super::products::{rotated, turned};

impl Inertial {
    /// A box of density 1 kg/m³ about its frame's origin, m along x, y and z.
    pub fn cuboid([x, y, z]: [f64; 3]) -> Self {
        Self::about_origin(x * y * z, [y * y + z * z, z * z + x * x, x * x + y * y], 12.0)
    }

    /// A cylinder of density 1 kg/m³ about its frame's origin, along z.
    pub fn cylinder(radius_m: f64, length_m: f64) -> Self {
        let round = radius_m * radius_m;
        let across = 3.0 * round + length_m * length_m;
        Self::about_origin(PI * round * length_m, [across, across, 6.0 * round], 12.0)
    }

    /// A sphere of density 1 kg/m³ about its frame's origin.
    pub fn sphere(radius_m: f64) -> Self {
        let volume_m3 = 4.0 / 3.0 * PI * radius_m.powi(3);
        Self::about_origin(volume_m3, [2.0 * radius_m * radius_m; 3], 5.0)
    }

    fn about_origin(mass_kg: f64, moments: [f64; 3], over: f64) -> Self {
        let moments = Vector3::from(moments) * (mass_kg / over);
        Self { mass_kg, com_m: Vector3::zeros(), inertia_kgm2: Matrix3::from_diagonal(&moments) }
    }

    /// A body of the same shape that is `factor` times as heavy.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self { mass_kg: self.mass_kg * factor, inertia_kgm2: self.inertia_kgm2 * factor, ..*self }
    }

    /// A body without mass.
    pub(super) fn none() -> Self {
        Self { mass_kg: 0.0, com_m: Vector3::zeros(), inertia_kgm2: Matrix3::zeros() }
    }

    /// The same body seen from the frame in which its own frame is `pose`.
    pub(crate) fn transformed(&self, pose: &Isometry3<f64>) -> Self {
        let r = pose.rotation.to_rotation_matrix().into_inner();
        Self {
            mass_kg: self.mass_kg,
            com_m: pose.transform_point(&self.com_m.into()).coords,
            inertia_kgm2: rotated(&self.inertia_kgm2, &r),
        }
    }

    /// Two bodies of the same frame as one.
    pub(crate) fn combined(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        if mass_kg == 0.0 {
            return Self { inertia_kgm2: self.inertia_kgm2 + other.inertia_kgm2, ..*self };
        }
        let apart = other.com_m - self.com_m;
        let reduced = self.mass_kg * other.mass_kg / mass_kg;
        Self {
            mass_kg,
            com_m: self.com_m + apart * (other.mass_kg / mass_kg),
            inertia_kgm2: self.inertia_kgm2 + other.inertia_kgm2 + point_inertia(reduced, &apart),
        }
    }
}

/// Inertia of a point mass at `r` about the origin: m (r·r 1 − r rᵀ).
pub(super) fn point_inertia(mass: f64, r: &Vector3<f64>) -> Matrix3<f64> {
    let entry = |i: usize, j: usize| {
        let own = if i == j { mass * r.norm_squared() } else { 0.0 };
        own - mass * r[i] * r[j]
    };
    Matrix3::from_fn(entry)
}

/// A rigid body in the base frame: mass, centre of mass, rotary inertia about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Composite {
    pub(super) mass: f64,
    pub(super) com: Vector3<f64>,
    pub(super) inertia: Matrix3<f64>,
}

impl Default for Composite {
    fn default() -> Self {
        Self { mass: 0.0, com: Vector3::zeros(), inertia: Matrix3::zeros() }
    }
}

impl Composite {
    pub(super) fn placed(body: &Inertial, r: &Matrix3<f64>, origin: &Vector3<f64>) -> Self {
        Self {
            mass: body.mass_kg,
            com: origin + turned(r, &body.com_m),
            inertia: rotated(&body.inertia_kgm2, r),
        }
    }

    pub(super) fn add(&mut self, other: &Self) {
        let mass = self.mass + other.mass;
        if mass > 0.0 {
            let apart = other.com - self.com;
            self.inertia += other.inertia + point_inertia(self.mass * other.mass / mass, &apart);
            self.com += apart * (other.mass / mass);
        }
        self.mass = mass;
    }
}
