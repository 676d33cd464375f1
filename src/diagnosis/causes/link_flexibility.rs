//! A link itself bends: a hinge halfway along it, about an axis across it. The hinge carries the whole
//! link and what follows, or only what follows: where the link's mass sits, near its end or its start.

use super::{Arm, Candidate, Cause, Words, across, new_spring};
use crate::model::{CoordinateKind, Hinge};

pub(super) const WORDS: Words = Words {
    what: "the link itself bends",
    rivals: "the stiffness or transverse compliance of the joints at its ends",
    test: "put accelerometers on both ends of the link and compare how they turn",
};

/// A link shorter than this share of the typical one does not bend.
const SHORTEST: f64 = 0.25;

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for body in arm.bodies.iter().filter(|body| body.on_chain && body.name != arm.root) {
        if body.reach_m.norm() < SHORTEST * arm.length_m {
            continue;
        }
        let soft = arm.rotation_stiffness();
        for axis in across(&body.reach_m) {
            for beyond in [false, true] {
                if beyond && !body.carries_joint {
                    continue;
                }
                let spring = new_spring("stiffness_nm_per_rad", soft);
                let mut candidate =
                    Candidate::new(Cause::LinkFlexibility, &body.name, vec![spring]);
                candidate.hinge = Some(Hinge {
                    kind: CoordinateKind::Rotation,
                    axes: vec![axis],
                    origin_m: 0.5 * body.reach_m,
                    beyond,
                });
                candidates.push(candidate);
            }
        }
    }
    candidates
}
