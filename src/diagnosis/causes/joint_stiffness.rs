//! The spring constant of a joint: K_jj.

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale};

pub(super) const TEXT: CauseText = CauseText {
    description: "the stiffness is different",
    confounded_with: "the inertia behind the joint, payload, \
                      uniform stiffness of the other joints, base compliance",
    test: "load the joint with known moments and measure its angle (detune stiffness)",
};

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    arm.springs
        .iter()
        .map(|spring| {
            let k = spring.stiffness;
            let parameter = Parameter {
                name: if spring.slides { "stiffness_n_per_m" } else { "stiffness_nm_per_rad" },
                scale: Scale::Log,
                nominal: Some(k),
                bounds: [k / 40.0, k * 40.0],
                starts: [1.0, 0.3, 0.6, 0.85, 1.2, 1.7, 3.5].iter().map(|s| s * k).collect(),
                expected: None,
            };
            Candidate::new(Cause::JointStiffness, &spring.joint, vec![parameter])
        })
        .collect()
}
