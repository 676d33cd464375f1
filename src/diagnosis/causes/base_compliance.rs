//! The foundation gives: the root link turns about or shifts along an axis, against a spring.

use nalgebra::Vector3;

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale, new_spring};
use crate::model::{Carries, CoordinateKind, Hinge};

pub(super) const TEXT: CauseText = CauseText {
    description: "the foundation is compliant",
    confounded_with: "uniform stiffness of the joints, the stiffness of the first joint",
    test: "put an accelerometer on the pedestal and repeat an impact test",
};

/// How far below the root link's frame it rocks: at its feet, or under a pedestal.
fn depth() -> Parameter {
    Parameter {
        name: "depth_m",
        scale: Scale::Linear(0.2),
        nominal: Some(0.0),
        bounds: [-0.2, 1.5],
        starts: vec![0.0],
        expected: Some([0.0, 0.3]),
    }
}

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
    let turning = arm.rotation_stiffness();
    let reach = 2.0 * arm.length_m;
    let shifting = turning / (reach * reach);
    let forms = [
        (CoordinateKind::Rotation, vec![x]),
        (CoordinateKind::Rotation, vec![y]),
        (CoordinateKind::Rotation, vec![z]),
        (CoordinateKind::Rotation, vec![x, y]),
        (CoordinateKind::Translation, vec![x]),
        (CoordinateKind::Translation, vec![y]),
        (CoordinateKind::Translation, vec![z]),
        (CoordinateKind::Translation, vec![x, y]),
    ];
    forms
        .into_iter()
        .map(|(kind, axes)| {
            let parameters = match kind {
                CoordinateKind::Rotation if axes[0] != z => {
                    vec![new_spring("stiffness_nm_per_rad", turning), depth()]
                }
                CoordinateKind::Rotation => vec![new_spring("stiffness_nm_per_rad", turning)],
                CoordinateKind::Translation => vec![new_spring("stiffness_n_per_m", shifting)],
            };
            let mut candidate = Candidate::new(Cause::BaseCompliance, &arm.root, parameters);
            candidate.hinge =
                Some(Hinge { kind, axes, origin_m: Vector3::zeros(), carries: Carries::Link });
            candidate
        })
        .collect()
}
