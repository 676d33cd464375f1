//! The spring changes with temperature: k (1 + c (T − 20 °C)), or k (factor + c (T − 20 °C)).

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale};
use crate::model::REFERENCE_TEMPERATURE_C;

pub(super) const TEXT: CauseText = CauseText {
    description: "the stiffness depends on temperature",
    confounded_with: "the joint's constant stiffness, if all temperatures are similar",
    test: "measure one pose cold and warm",
};

/// A law with a factor holds the plain stiffness as a special case, so it is an alternative of that
/// only where the law itself shows.
pub(super) const WITH_FACTOR: f64 = -1.0;

/// The share of the spring at the reference: the file's, unless the reference is another or the law
/// is bent.
pub(super) fn factor() -> Parameter {
    Parameter {
        name: "factor",
        scale: Scale::Linear(0.2),
        nominal: Some(1.0),
        bounds: [0.1, 4.0],
        starts: vec![1.0, 0.75, 1.3],
        expected: Some([1.0, 0.05]),
    }
}

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let Some(range) = arm.temperatures_c else { return Vec::new() };
    let largest =
        range.map(|t| (t - REFERENCE_TEMPERATURE_C).abs()).into_iter().fold(0.0, f64::max);
    arm.springs
        .iter()
        .flat_map(|spring| {
            let unit = 1.0 / largest.max(range[1] - range[0]);
            let change = Parameter {
                name: "change_per_k",
                scale: Scale::Linear(0.3 * unit),
                nominal: Some(0.0),
                bounds: [-3.0 * unit, 3.0 * unit],
                starts: [0.0, -0.6, -0.3, -0.1, 0.1, 0.3, 0.6].iter().map(|s| s * unit).collect(),
                expected: None,
            };
            [vec![change.clone()], vec![change, factor()]].map(|parameters| {
                let nests_stiffness = parameters.len() > 1;
                let mut candidate =
                    Candidate::new(Cause::TemperatureDrift, &spring.joint, parameters);
                if nests_stiffness {
                    candidate.plausibility = super::temperature_drift::WITH_FACTOR;
                }
                candidate
            })
        })
        .collect()
}
