//! M, and what gravity does, from homogeneous matrices and the product rule.
//!
//! Along the chain T is the frame reached so far, D_j = ∂T/∂α_j and H_jk = ∂²T/∂α_j∂α_k, all at α = 0. A rigid
//! step F carries all three along (T F, D_j F, H_jk F). A spring exp(Ξ α) leaves T and adds D = T Ξ,
//! H_kj = D_k Ξ, H_jj = T Ξ². A body with pseudo-inertia J then adds
//!
//! ```text
//! M_jk += tr(D_j J D_kᵀ)      ∂V/∂α_j −= gᵀ D_j J e₄      ∂²V/∂α_j∂α_k −= gᵀ H_jk J e₄
//! ```

use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, Vector3, Vector4};

/// A piece of the chain, from the ground outward.
#[derive(Debug, Clone)]
pub(crate) enum Element {
    Step(Matrix4<f64>),
    /// The generator Ξ of an elastic coordinate.
    Spring(Matrix4<f64>),
    /// A pseudo-inertia.
    Body(Matrix4<f64>),
}

/// What a chain gives over its elastic coordinates.
#[derive(Debug, Clone)]
pub(crate) struct Motion {
    pub(crate) mass: DMatrix<f64>,
    /// ∂V/∂α, N·m.
    pub(crate) gravity_torque: DVector<f64>,
    /// ∂²V/∂α∂α, N·m/rad.
    pub(crate) gravity_stiffness: DMatrix<f64>,
    /// ∂p/∂α of the last frame's origin, 3 × n.
    pub(crate) tip: DMatrix<f64>,
}

/// Walks the chain.
pub(crate) fn motion(chain: &[Element], gravity_m_per_s2: [f64; 3]) -> Motion {
    let n = chain.iter().filter(|element| matches!(element, Element::Spring(_))).count();
    let [gx, gy, gz] = gravity_m_per_s2;
    let g = Vector4::new(gx, gy, gz, 0.0);
    let mut mass = DMatrix::zeros(n, n);
    let mut gravity_torque = DVector::zeros(n);
    let mut gravity_stiffness = DMatrix::zeros(n, n);
    let mut t = Matrix4::identity();
    let mut d: Vec<Matrix4<f64>> = Vec::new();
    let mut h: Vec<Vec<Matrix4<f64>>> = Vec::new();
    for element in chain {
        match element {
            Element::Step(step) => {
                t *= step;
                d.iter_mut().for_each(|first| *first *= step);
                h.iter_mut().flatten().for_each(|second| *second *= step);
            }
            Element::Spring(generator) => {
                let mut row: Vec<_> = d.iter().map(|first| first * generator).collect();
                row.push(t * generator * generator);
                d.push(t * generator);
                h.push(row);
            }
            Element::Body(j) => {
                let moment: Vector4<f64> = j.column(3).into();
                for a in 0..d.len() {
                    let along = d[a] * j;
                    gravity_torque[a] -= g.dot(&(d[a] * moment));
                    for b in 0..=a {
                        let entry = along.component_mul(&d[b]).sum();
                        let bend = g.dot(&(h[a][b] * moment));
                        mass[(a, b)] += entry;
                        gravity_stiffness[(a, b)] -= bend;
                        if a != b {
                            mass[(b, a)] += entry;
                            gravity_stiffness[(b, a)] -= bend;
                        }
                    }
                }
            }
        }
    }
    let tip = DMatrix::from_fn(3, n, |i, j| d[j][(i, 3)]);
    Motion { mass, gravity_torque, gravity_stiffness, tip }
}

/// The matrix of the cross product with `v`.
fn cross(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// Rodrigues' rotation about a unit axis.
pub(crate) fn rotation(axis: &Vector3<f64>, angle_rad: f64) -> Matrix3<f64> {
    let (sin, cos) = angle_rad.sin_cos();
    let hat = cross(axis);
    Matrix3::identity() + hat * sin + hat * hat * (1.0 - cos)
}

/// A frame at `origin`, turned.
pub(crate) fn frame(turn: &Matrix3<f64>, origin: &Vector3<f64>) -> Matrix4<f64> {
    let mut f = Matrix4::identity();
    f.fixed_view_mut::<3, 3>(0, 0).copy_from(turn);
    f.fixed_view_mut::<3, 1>(0, 3).copy_from(origin);
    f
}

/// URDF's roll, pitch, yaw.
pub(crate) fn roll_pitch_yaw(rpy_rad: &Vector3<f64>) -> Matrix3<f64> {
    rotation(&Vector3::z(), rpy_rad.z)
        * rotation(&Vector3::y(), rpy_rad.y)
        * rotation(&Vector3::x(), rpy_rad.x)
}

/// Generator of a turn about an axis through a point.
pub(crate) fn turn(axis: &Vector3<f64>, origin_m: &Vector3<f64>) -> Matrix4<f64> {
    let mut generator = Matrix4::zeros();
    let hat = cross(axis);
    generator.fixed_view_mut::<3, 3>(0, 0).copy_from(&hat);
    generator.fixed_view_mut::<3, 1>(0, 3).copy_from(&(-hat * origin_m));
    generator
}

/// Generator of a shift along an axis.
pub(crate) fn shift(axis: &Vector3<f64>) -> Matrix4<f64> {
    let mut generator = Matrix4::zeros();
    generator.fixed_view_mut::<3, 1>(0, 3).copy_from(axis);
    generator
}
