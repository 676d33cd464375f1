//! A joint also bends across its axis: its child link turns about an axis across it, against a
//! spring.

use nalgebra::Vector3;

use super::{Arm, Candidate, Cause, CauseText, across, new_spring};
use crate::model::{Carries, CoordinateKind, Hinge};

pub(super) const TEXT: CauseText = CauseText {
    description: "the joint's bearing is compliant across its axis",
    confounded_with: "the flexibility of the adjacent links, base compliance",
    test: "put accelerometers on both sides of the joint and compare the rotations",
};

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
        forms.push(across);
        for axes in forms {
            let spring = new_spring("stiffness_nm_per_rad", soft);
            let mut candidate = Candidate::new(Cause::TransverseCompliance, joint, vec![spring]);
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
