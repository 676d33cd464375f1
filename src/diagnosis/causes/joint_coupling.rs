//! Two joints are coupled, as by a belt or a parallelogram: the spring of a joint feels its own
//! deflection and a share of that of the joint before, ½ k (α + ratio · α_before)².

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale};

pub(super) const TEXT: CauseText = CauseText {
    description: "the joint is coupled with the joint before (belt, parallelogram)",
    confounded_with: "the stiffness of both joints, the flexibility of the link between",
    test: "load the joint with a known moment and measure the angle of the joint before",
};

/// Few arms have such a drive.
const UNUSUAL: f64 = -1.0;

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    arm.springs
        .iter()
        .filter(|spring| spring.before.is_some() && !spring.slides)
        .map(|spring| {
            let parameter = Parameter {
                name: "ratio",
                scale: Scale::Linear(0.2),
                nominal: Some(0.0),
                bounds: [-2.0, 2.0],
                starts: vec![0.0, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0],
                expected: None,
            };
            let candidate = Candidate::new(Cause::JointCoupling, &spring.joint, vec![parameter]);
            Candidate { plausibility: UNUSUAL, ..candidate }
        })
        .collect()
}
