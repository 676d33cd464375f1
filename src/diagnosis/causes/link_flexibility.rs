//! A link itself bends: a hinge on the way along it, about an axis across it. The hinge carries the
//! whole link and what follows, or only what follows (where the link's mass sits, near its end or
//! its start), or parts the link's body.

use nalgebra::Vector3;

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale, across, new_spring};
use crate::model::{Carries, CoordinateKind, Hinge};

pub(super) const TEXT: CauseText = CauseText {
    description: "the link is flexible",
    confounded_with: "the stiffness or transverse compliance of the joints at its ends",
    test: "put accelerometers on both ends of the link and compare the rotations",
};

/// A link shorter than this share of the typical one does not bend.
const MIN_LENGTH: f64 = 0.25;

/// Where the link bends: about halfway.
fn position() -> Parameter {
    Parameter {
        name: "position",
        scale: Scale::Linear(0.2),
        nominal: None,
        bounds: [0.1, 0.9],
        starts: vec![0.5],
        expected: Some([0.5, 0.15]),
    }
}

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for body in arm.bodies.iter().filter(|body| body.on_chain && body.name != arm.root) {
        if body.reach_m.norm() < MIN_LENGTH * arm.length_m {
            continue;
        }
        let soft = arm.rotation_stiffness();
        for axis in across(&body.reach_m) {
            for carries in [Carries::Link, Carries::Part, Carries::Rest] {
                if carries == Carries::Rest && !body.carries_joint {
                    continue;
                }
                let parameters = vec![new_spring("stiffness_nm_per_rad", soft), position()];
                let mut candidate = Candidate::new(Cause::LinkFlexibility, &body.name, parameters);
                candidate.hinge = Some(Hinge {
                    kind: CoordinateKind::Rotation,
                    axes: vec![axis],
                    origin_m: Vector3::zeros(),
                    carries,
                });
                candidates.push(candidate);
            }
        }
    }
    candidates
}
