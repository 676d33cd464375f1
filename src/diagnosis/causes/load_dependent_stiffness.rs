//! The spring stiffens or softens with the gravity torque that it carries: k (1 + c |τ|), or bent:
//! k (1 + c |τ| / (1 + |τ|/τ_s)), about another constant than the file's, or in the three slopes of
//! a gear.

use super::{Arm, CONTAINS_PLAIN, Candidate, Cause, CauseText, Parameter, Scale, factor, ratio};

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
            let torque = |name, share: f64| Parameter {
                name,
                scale: Scale::Log,
                nominal: None,
                bounds: [0.05 * largest, 1.2 * largest],
                starts: vec![share * largest],
                expected: Some([share * largest, 0.6 * share * largest]),
            };
            let (low, high) = (ratio("ratio_1", 0.6), ratio("ratio_3", 0.6));
            let slopes =
                vec![low, high, torque("torque_1_nm", 0.25), torque("torque_2_nm", 0.6), factor()];
            let middle = 0.5 * (spring.min_gravity_torque_nm + largest);
            let forms = [
                (vec![change.clone()], 0.0, None),
                (vec![steep.clone(), saturation.clone()], 0.0, None),
                (vec![change, factor()], CONTAINS_PLAIN, Some(middle)),
                (vec![steep, saturation, factor()], CONTAINS_PLAIN, Some(middle)),
                (slopes, CONTAINS_PLAIN, None),
            ];
            forms.map(|(parameters, plausibility, reference)| {
                let candidate =
                    Candidate::new(Cause::LoadDependentStiffness, &spring.joint, parameters);
                let fixed = reference.map(|nm| ("reference_nm", nm)).into_iter().collect();
                Candidate { plausibility, fixed, ..candidate }
            })
        })
        .collect()
}
