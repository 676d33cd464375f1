//! The spring of one joint or of all changes with temperature: k (1 + c (T − 20 °C)), or
//! k (factor + c (T − T_0)), T_0 the table's median.

use super::{Arm, CONTAINS_PLAIN, Candidate, Cause, CauseText, Parameter, Scale, factor};
use crate::model::{ALL_JOINTS, REFERENCE_TEMPERATURE_C};

pub(super) const TEXT: CauseText = CauseText {
    description: "the stiffness depends on temperature",
    confounded_with: "the joint's constant stiffness, if all temperatures are similar",
    test: "measure one pose cold and warm",
};

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let Some([lowest, typical, highest]) = arm.temperatures_c else { return Vec::new() };
    let largest = [lowest, highest].map(|t| (t - REFERENCE_TEMPERATURE_C).abs());
    let unit = 1.0 / largest[0].max(largest[1]).max(highest - lowest);
    let all = (arm.springs.len() > 1).then_some(ALL_JOINTS);
    let places = arm.springs.iter().map(|spring| spring.joint.as_str()).chain(all);
    places
        .flat_map(|place| {
            let change = Parameter {
                name: "change_per_k",
                scale: Scale::Linear(0.3 * unit),
                nominal: Some(0.0),
                bounds: [-3.0 * unit, 3.0 * unit],
                starts: [0.0, -0.6, -0.3, -0.1, 0.1, 0.3, 0.6].iter().map(|s| s * unit).collect(),
                expected: None,
            };
            let forms = [
                (vec![change.clone()], 0.0, Vec::new()),
                (vec![change, factor()], CONTAINS_PLAIN, vec![("reference_c", typical)]),
            ];
            forms.map(|(parameters, plausibility, fixed)| {
                let candidate = Candidate::new(Cause::TemperatureDrift, place, parameters);
                Candidate { plausibility, fixed, ..candidate }
            })
        })
        .collect()
}
