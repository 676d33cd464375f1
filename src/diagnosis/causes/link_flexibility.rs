//! A link itself bends: a hinge on the way along it, about an axis across it, or about both, and
//! about the link. The hinge carries the
//! whole link and what follows, or only what follows (where the link's mass sits, near its end or
//! its start), or parts the link's body.

use nalgebra::Vector3;

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale, across, new_spring, ratio};
use crate::model::{Carries, CoordinateKind, Hinge};

pub(super) const TEXT: CauseText = CauseText {
    description: "the link is flexible",
    confounded_with: "the stiffness or transverse compliance of the joints at its ends",
    test: "put accelerometers on both ends of the link and compare the rotations",
};

/// How unlike bending and torsion are, as logarithms of their stiffness.
const UNLIKE: f64 = 0.8;

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
        let across = across(&body.reach_m);
        let spring = || new_spring("stiffness_nm_per_rad", soft);
        let unlike = |name| ratio(name, UNLIKE);
        let mut forms: Vec<(Vec<Vector3<f64>>, Vec<Parameter>)> =
            across.iter().map(|axis| (vec![*axis], vec![spring(), position()])).collect();
        if let [one, other, ..] = across[..] {
            let mut parameters = vec![spring(), unlike("ratio_2"), position()];
            forms.push((vec![one, other], parameters.clone()));
            parameters.push(unlike("ratio_3"));
            let along = body.reach_m.normalize();
            forms.push((vec![one, other, along], parameters));
        }
        for (axes, parameters) in forms {
            for carries in [Carries::Link, Carries::Part, Carries::Rest] {
                if carries == Carries::Rest && (!body.carries_joint || axes.len() > 1) {
                    continue;
                }
                let mut candidate =
                    Candidate::new(Cause::LinkFlexibility, &body.name, parameters.clone());
                candidate.is_refinement = axes.len() > 1;
                candidate.hinge = Some(Hinge {
                    kind: CoordinateKind::Rotation,
                    axes: axes.clone(),
                    origin_m: Vector3::zeros(),
                    carries,
                });
                candidates.push(candidate);
            }
        }
    }
    candidates
}
