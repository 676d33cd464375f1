//! Reflected rotor inertia that takes part in the joint's own elastic motion: M_jj.

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale};

pub(super) const TEXT: CauseText = CauseText {
    description: "the rotor's reflected inertia is missing or wrong",
    confounded_with: "the inertia of the links behind the joint, the joint's stiffness",
    test: "apply the joint's brake and measure again: the rotor then stands still",
};

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    arm.springs
        .iter()
        // A point mass on the axis has no inertia to measure a rotor's by.
        .filter(|spring| spring.inertia > 0.0 || spring.reflected_inertia > 0.0)
        .map(|spring| {
            let (nominal, inertia) = (spring.reflected_inertia, spring.inertia);
            let parameter = Parameter {
                name: "reflected_inertia_kgm2",
                scale: Scale::Linear(0.1 * inertia + 0.2 * nominal),
                nominal: Some(nominal),
                bounds: [0.0, 10.0 * inertia + 20.0 * nominal],
                starts: [0.02, 0.08, 0.2, 0.5, 1.2]
                    .iter()
                    .map(|share| nominal + share * inertia)
                    .chain((nominal > 0.0).then_some(0.5 * nominal))
                    .collect(),
                expected: None,
            };
            Candidate::new(Cause::DriveInertia, &spring.joint, vec![parameter])
        })
        .collect()
}
