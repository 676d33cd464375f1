//! The spring stiffens or softens with the gravity torque that it carries: k (1 + c |τ|), or bent:
//! k (1 + c |τ| / (1 + |τ|/τ_s)).

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale};

pub(super) const TEXT: CauseText = CauseText {
    description: "the stiffness depends on the gravity torque on the joint",
    confounded_with: "the joint's constant stiffness, a payload, gravity's geometric stiffness",
    test: "measure one pose with a known mass added and without it",
};

/// A torque that varies by less than this share of its largest says nothing of a law.
const MIN_VARIATION: f64 = 0.05;

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    arm.springs
        .iter()
        .filter(|spring| !spring.slides)
        .filter(|spring| {
            let [low, high] = [spring.min_gravity_torque_nm, spring.gravity_torque_nm];
            high > 1e-3 && high - low > MIN_VARIATION * high
        })
        .flat_map(|spring| {
            let largest = spring.gravity_torque_nm;
            let unit = 1.0 / largest;
            let change = Parameter {
                name: "change_per_nm",
                scale: Scale::Linear(0.3 * unit),
                nominal: Some(0.0),
                bounds: [-0.95 * unit, 6.0 * unit],
                starts: [0.0, -0.6, -0.3, -0.1, 0.1, 0.3, 0.8, 2.0]
                    .iter()
                    .map(|s| s * unit)
                    .collect(),
                expected: None,
            };
            // Down to a tenth of the largest torque the law bends within the table.
            let saturation = Parameter {
                name: "saturation_nm",
                scale: Scale::Log,
                nominal: None,
                bounds: [0.1 * largest, 30.0 * largest],
                starts: vec![largest],
                expected: None,
            };
            // What is bent may be steeper where it begins.
            let steep = Parameter { bounds: [-9.5 * unit, 20.0 * unit], ..change.clone() };
            [vec![change], vec![steep, saturation]].map(|parameters| {
                Candidate::new(Cause::LoadDependentStiffness, &spring.joint, parameters)
            })
        })
        .collect()
}
