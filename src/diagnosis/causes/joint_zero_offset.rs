//! The angle that the model takes for zero is not zero: q + δ in place of q, everywhere.

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale};

pub(super) const TEXT: CauseText = CauseText {
    description: "the joint has a zero offset",
    confounded_with: "a centre of mass off its axis",
    test: "check the joint's zero marks or a known pose with a level",
};

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    arm.joints
        .iter()
        .map(|(joint, slides)| {
            let (name, unit) = if *slides { ("offset_m", 0.1) } else { ("offset_rad", 0.1) };
            let parameter = Parameter {
                name,
                scale: Scale::Linear(unit),
                nominal: Some(0.0),
                bounds: [-0.8, 0.8],
                starts: vec![0.0, -0.4, -0.15, -0.05, 0.05, 0.15, 0.4],
                expected: None,
            };
            Candidate::new(Cause::JointZeroOffset, joint, vec![parameter])
        })
        .collect()
}
