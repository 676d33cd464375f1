//! The geometric stiffness of gravity was left out: K + K_g.

use super::{Arm, Candidate, Cause, CauseText};

pub(super) const TEXT: CauseText = CauseText {
    description: "the geometric stiffness of gravity was left out",
    confounded_with: "the stiffness of a soft joint, a load-dependent spring",
    test: "measure the arm pointing up and hanging down",
};

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    if arm.has_gravity_stiffness {
        return Vec::new();
    }
    let candidate = Candidate::new(Cause::GravityStiffness, "", Vec::new());
    vec![Candidate { at: None, ..candidate }]
}
