//! The foundation gives: the root link turns about or shifts along an axis, against a spring; or
//! about and along several, against unlike ones.

use nalgebra::Vector3;

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale, new_spring, ratio};
use crate::model::{Carries, CoordinateKind, Hinge};

pub(super) const TEXT: CauseText = CauseText {
    description: "the foundation is compliant",
    confounded_with: "uniform stiffness of the joints, the stiffness of the first joint",
    test: "put an accelerometer on the pedestal and repeat an impact test",
};

/// How unlike the directions are, as logarithms of their stiffness.
const UNLIKE: f64 = 0.8;

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
    let [turn, shift] = [CoordinateKind::Rotation, CoordinateKind::Translation];
    let spring = || new_spring("stiffness_nm_per_rad", turning);
    let shifts = || new_spring("stiffness_n_per_m", shifting);
    let unlike = |name| ratio(name, UNLIKE);
    let direction = Parameter {
        name: "turn_rad",
        scale: Scale::Linear(0.3),
        nominal: Some(0.0),
        bounds: [-0.9, 0.9],
        starts: vec![0.0],
        expected: Some([0.0, 0.4]),
    };
    let tilts = || vec![spring(), depth()];
    let forms = [
        (turn, vec![x], tilts()),
        (turn, vec![y], tilts()),
        (turn, vec![z], vec![spring()]),
        (turn, vec![x, y], tilts()),
        (turn, vec![x, y], vec![spring(), unlike("ratio_2"), direction, depth()]),
        (turn, vec![x, y, z], vec![spring(), unlike("ratio_2"), unlike("ratio_3"), depth()]),
        (
            turn,
            vec![x, y, z],
            vec![spring(), shifts(), unlike("ratio_2"), unlike("ratio_3"), depth()],
        ),
        (
            turn,
            vec![x, y, z],
            vec![
                spring(),
                shifts(),
                unlike("ratio_2"),
                unlike("ratio_3"),
                unlike("shift_ratio_2"),
                unlike("shift_ratio_3"),
                depth(),
            ],
        ),
        (shift, vec![x], vec![shifts()]),
        (shift, vec![y], vec![shifts()]),
        (shift, vec![z], vec![shifts()]),
        (shift, vec![x, y], vec![shifts()]),
        (shift, vec![x, y], vec![shifts(), unlike("ratio_2")]),
    ];
    forms
        .into_iter()
        .map(|(kind, axes, parameters)| {
            let is_refinement = parameters.iter().any(|p| p.name == "ratio_2");
            let mut candidate = Candidate::new(Cause::BaseCompliance, &arm.root, parameters);
            candidate.is_refinement = is_refinement;
            candidate.hinge =
                Some(Hinge { kind, axes, origin_m: Vector3::zeros(), carries: Carries::Link });
            candidate
        })
        .collect()
}
