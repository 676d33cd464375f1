//! The spring varies with the joint's own position, as gears mesh: k (factor + Σ a_n cos n q +
//! b_n sin n q), n = 1 to 3.

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale, factor};

pub(super) const TEXT: CauseText = CauseText {
    description: "the stiffness varies with the joint's own position",
    confounded_with: "a load-dependent spring, a joint zero, a base that gives in one direction",
    test: "measure at a dozen positions of this joint with the others at rest",
};

/// A joint that turns by less than this shows no wave, rad.
const MIN_TRAVEL: f64 = 1.0;

/// Waves are less common than plain faults.
const UNUSUAL: f64 = -2.0;

const NAMES: [[&str; 2]; 3] = [["cos_1", "sin_1"], ["cos_2", "sin_2"], ["cos_3", "sin_3"]];

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let wave = |n: usize| {
        NAMES[n].map(|name| Parameter {
            name,
            scale: Scale::Linear(0.1),
            nominal: Some(0.0),
            bounds: [-0.9, 0.9],
            starts: vec![0.0, -0.3, -0.1, 0.1, 0.3],
            expected: Some([0.0, 0.3]),
        })
    };
    let forms: [&[usize]; 5] = [&[0], &[1], &[2], &[0, 1], &[0, 1, 2]];
    arm.springs
        .iter()
        .filter(|spring| !spring.slides && spring.travel > MIN_TRAVEL)
        .flat_map(|spring| {
            forms.map(|waves| {
                let mut parameters: Vec<Parameter> = waves.iter().flat_map(|&n| wave(n)).collect();
                parameters.push(factor());
                let candidate =
                    Candidate::new(Cause::PositionDependentStiffness, &spring.joint, parameters);
                Candidate { plausibility: UNUSUAL, ..candidate }.refining()
            })
        })
        .collect()
}
