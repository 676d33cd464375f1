//! The geometric stiffness of gravity was left out: K + K_g.

use super::{Arm, Candidate, Cause, Words};

pub(super) const WORDS: Words = Words {
    what: "the geometric stiffness of gravity was left out",
    rivals: "the stiffness of a soft joint, a spring that changes with its load",
    test: "measure the arm upright and hanging",
};

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    if arm.has_gravity_stiffness {
        return Vec::new();
    }
    let candidate = Candidate::new(Cause::GravityStiffness, "", Vec::new());
    vec![Candidate { at: None, ..candidate }]
}
