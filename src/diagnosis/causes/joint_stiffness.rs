//! The spring constant of a joint: K_jj; of a joint that the file lists as rigid; or of all joints
//! by one factor.

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale, new_spring, ratio};
use crate::model::{ALL_JOINTS, SPRING_RATIOS};

pub(super) const TEXT: CauseText = CauseText {
    description: "the stiffness is different",
    confounded_with: "the inertia behind the joint, payload, \
                      uniform stiffness of the other joints, base compliance",
    test: "load the joint with known moments and measure its angle (detune stiffness)",
};

/// How unlike joints are that are all off, as logarithms of their stiffness.
const UNLIKE: f64 = 0.1;

/// A joint is listed as rigid for a reason.
const RIGID: f64 = -1.0;

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let elastic = arm.springs.iter().map(|spring| {
        let k = spring.stiffness;
        let name = if spring.slides { "stiffness_n_per_m" } else { "stiffness_nm_per_rad" };
        Candidate::new(Cause::JointStiffness, &spring.joint, vec![scaled(name, k)])
    });
    let has_spring = |joint: &String| arm.springs.iter().any(|spring| spring.joint == *joint);
    let rigid = arm.joints.iter().filter(|(joint, _)| !has_spring(joint)).map(|(joint, slides)| {
        let turning = arm.rotation_stiffness();
        let spring = if *slides {
            new_spring("stiffness_n_per_m", turning / arm.length_m.powi(2))
        } else {
            new_spring("stiffness_nm_per_rad", turning)
        };
        let candidate = Candidate::new(Cause::JointStiffness, joint, vec![spring]);
        Candidate { plausibility: RIGID, ..candidate }
    });
    let alike = vec![scaled("factor", 1.0)];
    let ratios = SPRING_RATIOS.iter().take(arm.springs.len()).map(|name| ratio(name, UNLIKE));
    let unlike = alike.iter().cloned().chain(ratios).collect();
    let of_all = |parameters| Candidate::new(Cause::JointStiffness, ALL_JOINTS, parameters);
    let all = [of_all(alike), of_all(unlike).refining()];
    elastic.chain(rigid).chain(all.into_iter().filter(|_| arm.springs.len() > 1)).collect()
}

/// Times what the file says.
fn scaled(name: &'static str, own: f64) -> Parameter {
    Parameter {
        name,
        scale: Scale::Log,
        nominal: Some(own),
        bounds: [own / 40.0, own * 40.0],
        starts: [1.0, 0.3, 0.6, 0.85, 1.2, 1.7, 3.5].iter().map(|s| s * own).collect(),
        expected: None,
    }
}
