//! A serial arm of turning joints, as a model of it knows it.

use nalgebra::{Matrix3, Matrix4, Vector3};

/// Acceleration of gravity in the base frame, m/s².
pub(crate) const GRAVITY_M_PER_S2: [f64; 3] = [0.0, 0.0, -9.80665];

/// A rigid body in the frame of its link.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    pub(crate) mass_kg: f64,
    pub(crate) com_m: Vector3<f64>,
    /// About the centre of mass, in the axes of the link.
    pub(crate) inertia_kgm2: Matrix3<f64>,
}

impl Body {
    pub(crate) fn point(mass_kg: f64, com_m: Vector3<f64>) -> Self {
        Self { mass_kg, com_m, inertia_kgm2: Matrix3::zeros() }
    }

    /// A box of even density with the given edges, turned by `turn`.
    pub(crate) fn block(
        mass_kg: f64,
        com_m: Vector3<f64>,
        edges_m: Vector3<f64>,
        turn: Matrix3<f64>,
    ) -> Self {
        let squares = edges_m.map(|edge| edge * edge);
        let about = Vector3::from_fn(|i, _| mass_kg / 12.0 * (squares.sum() - squares[i]));
        Self {
            mass_kg,
            com_m,
            inertia_kgm2: turn * Matrix3::from_diagonal(&about) * turn.transpose(),
        }
    }

    /// ∫ r rᵀ dm about the centre of mass, kg·m².
    pub(crate) fn second_moment(&self) -> Matrix3<f64> {
        Matrix3::identity() * (0.5 * self.inertia_kgm2.trace()) - self.inertia_kgm2
    }

    /// ∫ (r, 1) (r, 1)ᵀ dm about the link's origin.
    pub(crate) fn pseudo_inertia(&self) -> Matrix4<f64> {
        let mut j = Matrix4::zeros();
        let about_origin =
            self.second_moment() + self.com_m * self.com_m.transpose() * self.mass_kg;
        j.fixed_view_mut::<3, 3>(0, 0).copy_from(&about_origin);
        j.fixed_view_mut::<3, 1>(0, 3).copy_from(&(self.com_m * self.mass_kg));
        j.fixed_view_mut::<1, 3>(3, 0).copy_from(&(self.com_m.transpose() * self.mass_kg));
        j[(3, 3)] = self.mass_kg;
        j
    }
}

/// A turning joint with a spring in it, and the link that it carries.
#[derive(Debug, Clone)]
pub(crate) struct Joint {
    pub(crate) name: String,
    /// Name of the link that it carries.
    pub(crate) link: String,
    pub(crate) origin_m: Vector3<f64>,
    pub(crate) rpy_rad: Vector3<f64>,
    /// Of unit length, in the frame of the link.
    pub(crate) axis: Vector3<f64>,
    pub(crate) limits_rad: [f64; 2],
    pub(crate) stiffness_nm_per_rad: f64,
    pub(crate) drive_kgm2: f64,
    /// Body of the link that it carries.
    pub(crate) body: Body,
}

/// What an elastic coordinate does to what it carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Rotation,
    Translation,
}

/// An elastic coordinate beside those of the joints; it moves a whole link and all that it carries.
#[derive(Debug, Clone)]
pub(crate) struct Extra {
    pub(crate) name: String,
    /// 0 is the base, i the link of joint i (counting from 1).
    pub(crate) link: usize,
    pub(crate) kind: Kind,
    /// In the frame of the link.
    pub(crate) axis: Vector3<f64>,
    pub(crate) origin_m: Vector3<f64>,
    pub(crate) stiffness: f64,
}

/// The arm: base, joints, tool frame on the last link.
#[derive(Debug, Clone)]
pub(crate) struct Arm {
    pub(crate) name: String,
    /// Whether it moves in the x–z plane alone.
    pub(crate) planar: bool,
    pub(crate) base: Body,
    pub(crate) joints: Vec<Joint>,
    /// Tool frame in that of the last link.
    pub(crate) tip_m: Vector3<f64>,
    /// In the tool frame.
    pub(crate) payload: Option<Body>,
    pub(crate) extras: Vec<Extra>,
    pub(crate) gravity_stiffness: bool,
}

/// Name of the link that stands on the ground.
pub(crate) const BASE: &str = "base_link";

/// Name of the tool frame.
pub(crate) const TIP: &str = "tool0";

impl Arm {
    /// From the origin of link i (0 is the base) to the next joint or the tool.
    pub(crate) fn reach(&self, link: usize) -> Vector3<f64> {
        self.joints.get(link).map_or(self.tip_m, |next| next.origin_m)
    }

    /// Name of link i.
    pub(crate) fn link_name(&self, link: usize) -> &str {
        if link == 0 { BASE } else { &self.joints[link - 1].link }
    }
}
