//! The rotary inertia of a link about its centre of mass, by a factor; or with the mass spread by
//! another factor along each axis, which gives each axis an inertia of its own; or mass and inertia
//! alike.

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale, ratio};

pub(super) const TEXT: CauseText = CauseText {
    description: "the inertia of the link is different",
    confounded_with: "a payload or drive inertia on the same joint, \
                      the stiffness of the joint above it",
    test: "weigh the link, or add a known mass to it and measure again",
};

/// How unlike the factors about the axes are, as their logarithms.
const UNLIKE: f64 = 1.0;

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for body in &arm.bodies {
        let Some(inertial) = body.inertial.filter(|_| body.name != arm.root) else { continue };
        let principal = inertial.inertia_kgm2.trace() / 3.0;
        // A link cannot be harder to turn than its mass at both ends of twice its length.
        let length = body.reach_m.norm().max(inertial.com_m.norm()).max(0.3 * arm.length_m);
        let most = inertial.mass_kg * length * length;
        if principal > 0.0 {
            let top = (4.0 * most / principal).max(20.0);
            let mut starts = vec![1.0, 0.2, 0.5, 0.8, 1.3, 2.0];
            let mut start = 4.0;
            while start < top {
                starts.push(start);
                start *= 3.0;
            }
            let parameter = Parameter {
                name: "inertia_factor",
                scale: Scale::Log,
                nominal: Some(1.0),
                bounds: [0.01, top],
                starts,
                expected: None,
            };
            let about = ["x_factor", "y_factor", "z_factor"].map(|name| ratio(name, UNLIKE));
            let unlike = std::iter::once(parameter.clone()).chain(about).collect();
            candidates.push(Candidate::new(Cause::LinkInertia, &body.name, vec![parameter]));
            candidates.push(Candidate::new(Cause::LinkInertia, &body.name, unlike).refining());
        }
        let parameter = Parameter {
            name: "mass_factor",
            scale: Scale::Log,
            nominal: Some(1.0),
            bounds: [0.05, 20.0],
            starts: vec![1.0, 0.3, 0.6, 0.85, 1.2, 1.7, 3.0],
            expected: None,
        };
        candidates.push(Candidate::new(Cause::LinkInertia, &body.name, vec![parameter]));
    }
    candidates
}
