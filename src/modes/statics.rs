//! What the tool tip does under a force that stands still.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix6xX, Point3, SymmetricEigen, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use crate::model::{
    Conditions, Placement, Robot, elastic_jacobian, potential_gradient, stiffness_matrix,
};
use crate::units::written;

/// Cap of nalgebra's QR iteration; a 3 × 3 matrix takes a few.
const MAX_QR_STEPS: usize = 1000;

/// How far the tip gives way in one direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Principal {
    /// Displacement for a unit force along the direction, which is along it.
    #[serde(rename = "compliance_um_per_n", serialize_with = "written::um")]
    pub compliance_m_per_n: f64,
    /// In the base frame, of length 1.
    pub direction: [f64; 3],
}

/// The arm at rest at one pose: what the springs give, K α = f, with K as for its modes.
#[derive(Debug, Clone, PartialEq)]
pub struct Statics {
    /// α under gravity, rad or m: Eqs. (12)–(13) of the paper for its arm.
    pub sag: Vec<f64>,
    /// How gravity moves the tip, m, in the base frame.
    pub sag_m: Vector3<f64>,
    /// Displacement of the tip for a force on it, m/N, both in the base frame.
    pub compliance_m_per_n: Matrix3<f64>,
    /// The same for a moment on it, 1/N.
    pub compliance_m_per_nm: Matrix3<f64>,
    /// The axes of the ellipsoid of `compliance_m_per_n`, softest first.
    pub principal: [Principal; 3],
}

impl Statics {
    /// Of a robot as placed, at the point `tcp_m` of its tip frame; `None` where K is not positive
    /// definite.
    pub fn of(robot: &Robot, placement: &Placement, tcp_m: &Point3<f64>) -> Option<Self> {
        let n = robot.coordinates().len();
        let mut stiffness = DMatrix::zeros(n, n);
        stiffness_matrix(robot, placement, &Conditions::default(), &mut stiffness);
        let factor = stiffness.cholesky()?;
        let mut gradient = vec![0.0; n];
        potential_gradient(robot, placement, &mut gradient);
        let sag = factor.solve(&-DVector::from_vec(gradient));
        let mut jacobian = Matrix6xX::zeros(n);
        elastic_jacobian(robot, placement, tcp_m, &mut jacobian);
        let moved = jacobian.fixed_rows::<3>(0);
        let sag_m: Vector3<f64> = moved * &sag;
        let turned = jacobian.fixed_rows::<3>(3);
        let compliance: Matrix3<f64> = moved * factor.solve(&moved.transpose());
        let compliance_m_per_nm = moved * factor.solve(&turned.transpose());
        let compliance_m_per_n = (compliance + compliance.transpose()) * 0.5;
        let principal = principal(&compliance_m_per_n)?;
        let sag = sag.as_slice().to_vec();
        Some(Self { sag, sag_m, compliance_m_per_n, compliance_m_per_nm, principal })
    }

    /// The same with what else gives way between arm and tip, m/N.
    pub fn with(self, compliance_m_per_n: &Matrix3<f64>) -> Option<Self> {
        let compliance_m_per_n = self.compliance_m_per_n + compliance_m_per_n;
        let principal = principal(&compliance_m_per_n)?;
        Some(Self { compliance_m_per_n, principal, ..self })
    }
}

/// The axes of a compliance's ellipsoid, softest first.
fn principal(compliance_m_per_n: &Matrix3<f64>) -> Option<[Principal; 3]> {
    let found = SymmetricEigen::try_new(*compliance_m_per_n, f64::EPSILON, MAX_QR_STEPS)?;
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| found.eigenvalues[b].total_cmp(&found.eigenvalues[a]));
    Some(order.map(|i| Principal {
        // What no spring moves is rounding about zero.
        compliance_m_per_n: found.eigenvalues[i].max(0.0),
        direction: upright(found.eigenvectors.column(i).into_owned()).into(),
    }))
}

/// Either direction of an axis: the one whose largest component is positive.
fn upright(axis: Vector3<f64>) -> Vector3<f64> {
    if axis[axis.iamax()] < 0.0 { -axis } else { axis }
}
