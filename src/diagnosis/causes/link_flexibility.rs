//! A link itself bends: about one axis across it, about both, or about both and along it; over its
//! length, where its body bends with it, or at one place. There a hinge carries the whole link and
//! what follows, or only what follows (where the link's mass sits, near its end or its start), or
//! parts the link's body.

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

/// Where the middle of the link's compliance is: about halfway. Over a length it lies in the middle
/// third, as compliance is nowhere below zero.
fn position(bounds: [f64; 2]) -> Parameter {
    Parameter {
        name: "position",
        scale: Scale::Linear(0.2),
        nominal: None,
        bounds,
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
        let own = arm.description.links.iter().find(|link| link.name == body.name);
        let has_mass = own.and_then(|own| own.inertial).is_some_and(|own| own.mass_kg > 0.0);
        let mut ends = arm.description.joints.iter().filter(|joint| joint.parent == body.name);
        // A hinge within the tip's own link would leave the tool behind.
        let is_tip = body.name == arm.tip;
        let is_beam =
            has_mass && !is_tip && ends.any(|end| end.origin.translation.vector.norm() > 0.0);
        for axes in [vec![one], vec![other], vec![one, other], vec![one, other, along]] {
            let ratios = ["ratio_2", "ratio_3"].into_iter().take(axes.len() - 1).map(unlike);
            let parameters = |bounds: [f64; 2]| -> Vec<Parameter> {
                [spring(), position(bounds)].into_iter().chain(ratios.clone()).collect()
            };
            let mut add = |carries, parameters, fixed| {
                let mut candidate = Candidate::new(Cause::LinkFlexibility, &body.name, parameters);
                candidate.is_refinement = axes.len() > 1;
                candidate.fixed = fixed;
                candidate.hinge = Some(Hinge {
                    kind: CoordinateKind::Rotation,
                    axes: axes.clone(),
                    origin_m: Vector3::zeros(),
                    carries,
                });
                candidates.push(candidate);
            };
            if is_beam {
                add(Carries::Part, parameters([0.34, 0.66]), vec![("length", 1.0)]);
            }
            for carries in [Carries::Link, Carries::Part, Carries::Rest] {
                let is_twice = is_beam && carries == Carries::Part && axes.len() > 1;
                let is_far = carries == Carries::Rest && (!body.carries_joint || axes.len() > 1);
                if !is_twice && !is_far && (carries == Carries::Link || !is_tip) {
                    add(carries, parameters([0.1, 0.9]), Vec::new());
                }
            }
        }
    }
    candidates
}
