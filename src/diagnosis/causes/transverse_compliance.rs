//! A joint also bends across its axis: its child link turns about an axis across it, against a
//! spring, or about two, against like or unlike ones.

use nalgebra::Vector3;

use super::{Arm, Candidate, Cause, CauseText, across, new_spring, ratio};
use crate::model::{Carries, CoordinateKind, Hinge};

pub(super) const TEXT: CauseText = CauseText {
    description: "the joint's bearing is compliant across its axis",
    confounded_with: "the flexibility of the adjacent links, base compliance",
    test: "put accelerometers on both sides of the joint and compare the rotations",
};

/// How unlike the two directions are, as logarithms of their stiffness.
const UNLIKE: f64 = 1.0;

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for (joint, _) in &arm.joints {
        let Some(child) = child_of(arm, joint) else { continue };
        let Some(body) = arm.bodies.iter().find(|body| body.name == child) else { continue };
        let Some(axis) = body.joint_axis else { continue };
        let soft = arm
            .springs
            .iter()
            .find(|spring| spring.joint == *joint && !spring.slides)
            .map_or(arm.rotation_stiffness(), |spring| spring.stiffness);
        let across = across(&axis);
        let mut forms: Vec<Vec<Vector3<f64>>> = across.iter().map(|axis| vec![*axis]).collect();
        forms.push(across.clone());
        let is_unlike = [vec![false; forms.len()], vec![true]].concat();
        forms.push(across);
        for (axes, is_unlike) in forms.into_iter().zip(is_unlike) {
            let mut parameters = vec![new_spring("stiffness_nm_per_rad", soft)];
            parameters.extend(is_unlike.then(|| ratio("ratio_2", UNLIKE)));
            let mut candidate = Candidate::new(Cause::TransverseCompliance, joint, parameters);
            candidate.is_refinement = is_unlike;
            candidate.hinge = Some(Hinge {
                kind: CoordinateKind::Rotation,
                axes,
                origin_m: Vector3::zeros(),
                carries: Carries::Link,
            });
            candidates.push(candidate);
        }
    }
    candidates
}

fn child_of<'a>(arm: &'a Arm<'_>, joint: &str) -> Option<&'a str> {
    let found = arm.description.joints.iter().find(|j| j.name == joint);
    found.map(|joint| joint.child.as_str())
}
