//! Mass that the model does not know: a point on a link, at its frame's origin, near it or along
//! the link.

use nalgebra::Vector3;

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale};

pub(super) const TEXT: CauseText = CauseText {
    description: "the link carries mass that is not in the model",
    confounded_with: "uniform or outer joint stiffness, \
                      the inertia or centre of mass of the link that carries it",
    test: "take the payload off, or add a known mass, and measure again",
};

/// Links other than the tip's are less often loaded: dress packs, feeders, valves.
const NOT_AT_TIP: f64 = -1.0;

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let mut candidates = Vec::new();
    for body in arm.bodies.iter().filter(|body| body.on_chain && body.name != arm.root) {
        let holds_tip = body.name == arm.tip || body.welded.contains(&arm.tip);
        let (place, also) = if holds_tip && body.name != arm.tip {
            let others = body.welded.iter().filter(|name| **name != arm.tip).cloned();
            (arm.tip.clone(), std::iter::once(body.name.clone()).chain(others).collect())
        } else {
            (body.name.clone(), body.welded.clone())
        };
        let total = arm.moving_mass_kg.max(1e-3);
        // What the file hangs on it may be missing.
        let own_kg = arm
            .description
            .payload
            .as_ref()
            .filter(|payload| payload.link == body.name || body.welded.contains(&payload.link))
            .map_or(0.0, |payload| payload.inertial.mass_kg);
        let less = (own_kg > 0.0).then(|| [-0.3 * own_kg, -0.8 * own_kg]);
        let mass = Parameter {
            name: "mass_kg",
            scale: Scale::Linear(0.05 * total),
            nominal: Some(0.0),
            bounds: [-own_kg, 3.0 * total],
            starts: [0.01, 0.03, 0.08, 0.2, 0.5, 1.0]
                .iter()
                .map(|s| s * total)
                .chain(less.into_iter().flatten())
                .collect(),
            expected: None,
        };
        // A tool hangs near the tip's frame, a feeder anywhere along the link.
        let (middle_m, spread_m) = if holds_tip {
            (Vector3::zeros(), 0.15)
        } else {
            (0.5 * body.reach_m, 0.15_f64.max(0.3 * body.reach_m.norm()))
        };
        let at = |name: &'static str, middle_m: f64| Parameter {
            name,
            scale: Scale::Linear(0.1),
            nominal: Some(0.0),
            bounds: [middle_m - 4.0 * spread_m, middle_m + 4.0 * spread_m],
            starts: vec![middle_m, middle_m + 0.8 * spread_m, middle_m - 0.8 * spread_m],
            expected: Some([middle_m, spread_m]),
        };
        let names = ["com_x_m", "com_y_m", "com_z_m"];
        let com = names.iter().zip(middle_m.iter()).map(|(name, middle)| at(name, *middle));
        // A spindle has an inertia of its own, too.
        let gyration = Parameter {
            name: "gyration_m",
            scale: Scale::Linear(0.05),
            nominal: Some(0.0),
            bounds: [0.0, 0.5],
            starts: vec![0.05],
            expected: Some([0.0, 0.1]),
        };
        let around = com.chain(std::iter::once(gyration));
        let forms = [vec![mass.clone()], std::iter::once(mass).chain(around).collect()];
        for parameters in forms {
            let mut candidate = Candidate::new(Cause::Payload, &place, parameters);
            candidate.also = also.clone();
            if !holds_tip {
                candidate.plausibility = NOT_AT_TIP;
            }
            candidates.push(candidate);
        }
    }
    candidates
}
