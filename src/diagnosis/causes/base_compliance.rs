//! The foundation gives: the root link turns about or shifts along an axis, against a spring.

use nalgebra::Vector3;

use super::{Arm, Candidate, Cause, Words, new_spring};
use crate::model::{CoordinateKind, Hinge};

pub(super) const WORDS: Words = Words {
    what: "the foundation gives",
    rivals: "uniform stiffness of the joints, the stiffness of the first joint",
    test: "put an accelerometer on the pedestal and hit the arm again",
};

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
            let spring = match kind {
                CoordinateKind::Rotation => new_spring("stiffness_nm_per_rad", turning),
                CoordinateKind::Translation => new_spring("stiffness_n_per_m", shifting),
            };
            let mut candidate = Candidate::new(Cause::BaseCompliance, &arm.root, vec![spring]);
            candidate.hinge = Some(Hinge { kind, axes, origin_m: Vector3::zeros(), beyond: false });
            candidate
        })
        .collect()
}
