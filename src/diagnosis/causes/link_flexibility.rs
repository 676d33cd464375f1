//! A link itself bends over its length: about one axis across it, about both, or about both and
//! along it; or at one place about one axis. The end of the link carries the whole link and what
//! follows, or only what follows (where the link's mass sits, near its end or its start), or the
//! link's body is parted where it bends.

use nalgebra::Vector3;

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale, new_spring, ratio};
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

/// Where the middle of the link's compliance is: about halfway.
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

/// Two axes square to the link and to each other: the frame's own axis that lies most across it, as
/// far as it does, and another.
fn square_to(along: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let mut axes = [Vector3::y(), Vector3::z(), Vector3::x()];
    axes.sort_by(|a, b| a.dot(along).abs().total_cmp(&b.dot(along).abs()));
    let one = (axes[0] - along * axes[0].dot(along)).normalize();
    [one, along.cross(&one)]
}

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for body in arm.bodies.iter().filter(|body| body.on_chain && body.name != arm.root) {
        if body.reach_m.norm() <= MIN_LENGTH * arm.length_m {
            continue;
        }
        let soft = arm.rotation_stiffness();
        let along = body.reach_m.normalize();
        let [one, other] = square_to(&along);
        let spring = || new_spring("stiffness_nm_per_rad", soft);
        let unlike = |name| ratio(name, UNLIKE);
        let of_both = vec![spring(), unlike("ratio_2"), position()];
        let of_all = [&of_both[..], &[unlike("ratio_3")]].concat();
        let of_one = || vec![spring(), position()];
        let beam = || vec![("length", 1.0)];
        let hinge = Vec::new;
        let forms = [
            (vec![one], of_one(), beam()),
            (vec![other], of_one(), beam()),
            (vec![one], of_one(), hinge()),
            (vec![other], of_one(), hinge()),
            (vec![one, other], of_both, beam()),
            (vec![one, other, along], of_all, beam()),
        ];
        for (axes, parameters, fixed) in forms {
            for carries in [Carries::Link, Carries::Part, Carries::Rest] {
                if carries == Carries::Rest && (!body.carries_joint || axes.len() > 1) {
                    continue;
                }
                let mut candidate =
                    Candidate::new(Cause::LinkFlexibility, &body.name, parameters.clone());
                candidate.is_refinement = axes.len() > 1;
                candidate.fixed.clone_from(&fixed);
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
