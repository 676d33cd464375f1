//! The spring changes with the level of excitation: k (1 + c A), k (factor + c (A − A_0)), or by a
//! power of A/A_0, A_0 the table's median.

use super::{Arm, CONTAINS_PLAIN, Candidate, Cause, CauseText, Parameter, Scale, factor};

pub(super) const TEXT: CauseText = CauseText {
    description: "the stiffness depends on the level of excitation",
    confounded_with: "the joint's constant stiffness, if all levels are similar",
    test: "excite one pose at several levels",
};

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let Some([_, typical, highest]) = arm.amplitudes_nm else { return Vec::new() };
    arm.springs
        .iter()
        .flat_map(|spring| {
            let unit = 1.0 / highest;
            let change = Parameter {
                name: "change_per_nm",
                scale: Scale::Linear(0.3 * unit),
                nominal: Some(0.0),
                bounds: [-0.95 * unit, 6.0 * unit],
                starts: [0.0, -0.6, -0.3, -0.1, 0.1, 0.3, 0.8].iter().map(|s| s * unit).collect(),
                expected: None,
            };
            let exponent = Parameter {
                name: "exponent",
                scale: Scale::Linear(0.1),
                nominal: Some(0.0),
                bounds: [-1.0, 1.0],
                starts: vec![0.0, -0.2, -0.1, -0.04, 0.04, 0.1],
                expected: None,
            };
            let reference = vec![("reference_nm", typical)];
            let forms = [
                (vec![change.clone()], 0.0, Vec::new()),
                (vec![change, factor()], CONTAINS_PLAIN, reference.clone()),
                (vec![exponent, factor()], CONTAINS_PLAIN, reference),
            ];
            forms.map(|(parameters, plausibility, fixed)| {
                let candidate =
                    Candidate::new(Cause::AmplitudeDependence, &spring.joint, parameters);
                Candidate { plausibility, fixed, ..candidate }
            })
        })
        .collect()
}
