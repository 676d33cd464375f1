//! The centre of mass of a link lies elsewhere: along one of the link's axes, or anywhere.

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale};

pub(super) const TEXT: CauseText = CauseText {
    description: "the centre of mass is somewhere else",
    confounded_with: "a payload, a joint's zero, the inertia of the link",
    test: "weigh the link at both ends, or look up its drawing",
};

/// However short a link is, what is bolted to it may lie this far off, m.
const MIN_REACH_M: f64 = 0.35;

const NAMES: [&str; 3] = ["dx_m", "dy_m", "dz_m"];

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for body in &arm.bodies {
        let Some(inertial) = body.inertial.filter(|_| body.name != arm.root) else { continue };
        let length = body.reach_m.norm().max(inertial.com_m.norm()).max(0.3 * arm.length_m);
        let along = |name: &'static str, expected: Option<[f64; 2]>| Parameter {
            name,
            scale: Scale::Linear(0.3 * length),
            nominal: Some(0.0),
            bounds: [-1.2 * length.max(MIN_REACH_M), 1.2 * length.max(MIN_REACH_M)],
            starts: [0.0, -0.4, -0.15, 0.15, 0.4].iter().map(|s| s * length).collect(),
            expected,
        };
        for name in NAMES {
            candidates.push(Candidate::new(Cause::ComOffset, &body.name, vec![along(name, None)]));
        }
        let anywhere = NAMES.map(|name| along(name, Some([0.0, 0.3 * length]))).to_vec();
        candidates.push(Candidate::new(Cause::ComOffset, &body.name, anywhere));
    }
    candidates
}
