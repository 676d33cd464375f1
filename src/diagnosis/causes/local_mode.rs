//! A part on a link has a natural frequency of its own, which the table has among the arm's: a
//! mass on a spring, too light for the arm to feel it or not.

use nalgebra::Vector3;

use super::{Arm, CONTAINS_PLAIN, Candidate, Cause, CauseText, Parameter, Scale};
use crate::model::{Carries, Hinge};

pub(super) const TEXT: CauseText = CauseText {
    description: "a part on the arm (gripper, dress pack, cable) has a natural frequency of its \
                  own, and the table has it among the arm's",
    confounded_with: "a missed mode, the flexibility of the link that carries the part",
    test: "tap the part itself, or take it off, and measure again",
};

/// Arms have fewer such parts than springs, masses and bearings.
const SELDOM: f64 = -3.0;

/// From where the part is taken to be: the origin of the tip, the middle of a link.
fn offset(name: &'static str) -> Parameter {
    const SPREAD_M: f64 = 0.15;
    Parameter {
        name,
        scale: Scale::Linear(0.1),
        nominal: Some(0.0),
        bounds: [-4.0 * SPREAD_M, 4.0 * SPREAD_M],
        starts: vec![0.0],
        expected: Some([0.0, SPREAD_M]),
    }
}

/// Parts whose mass the file has already, as that of a link or of the payload: they hang from
/// there.
fn contained(arm: &Arm<'_>, frequency: &Parameter) -> Vec<Candidate> {
    let payload = arm.description.payload.as_ref();
    let carried = payload.map(|payload| (&payload.link, payload.inertial));
    let chain = arm.bodies.iter().filter(|body| body.on_chain && body.name != arm.root);
    let own = chain.flat_map(|body| {
        let names = std::iter::once(&body.name).chain(&body.welded);
        names.filter_map(|name| {
            let link = arm.description.links.iter().find(|link| link.name == *name)?;
            Some((name, link.inertial?))
        })
    });
    let mut candidates = Vec::new();
    for (place, inertial) in own.chain(carried).filter(|(_, body)| body.mass_kg > 0.0) {
        let most_kg = inertial.mass_kg;
        let mass = Parameter {
            name: "mass_kg",
            scale: Scale::Log,
            nominal: None,
            bounds: [1e-3 * most_kg, 0.98 * most_kg],
            starts: vec![0.3 * most_kg],
            expected: None,
        };
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            let origin_m = inertial.com_m;
            candidates.push(Candidate {
                hinge: Some(Hinge { origin_m, carries: Carries::Part, ..Hinge::shift(axis) }),
                plausibility: SELDOM + CONTAINS_PLAIN,
                ..Candidate::new(Cause::LocalMode, place, vec![frequency.clone(), mass.clone()])
            });
        }
    }
    candidates
}

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    // It takes a column of the table, at most poses or at some.
    let medians = &arm.median_of_column_hz;
    let between = medians.windows(2).map(|pair| (pair[0] * pair[1]).sqrt());
    let starts: Vec<f64> = medians.iter().copied().chain(between).collect();
    if starts.is_empty() {
        return Vec::new();
    }
    let frequency = Parameter {
        name: "frequency_hz",
        scale: Scale::Log,
        nominal: None,
        // What stands beyond the table is not among the arm's.
        bounds: [0.98 * arm.lowest_hz, 1.02 * arm.highest_hz],
        starts,
        expected: None,
    };
    let light = Candidate {
        at: None,
        plausibility: SELDOM,
        ..Candidate::new(Cause::LocalMode, "", vec![frequency.clone()])
    };
    let total_kg = arm.moving_mass_kg.max(1e-3);
    let mass = Parameter {
        name: "mass_kg",
        scale: Scale::Log,
        nominal: None,
        bounds: [1e-4 * total_kg, 0.3 * total_kg],
        starts: [0.004, 0.0005, 0.03].map(|share| share * total_kg).to_vec(),
        expected: None,
    };
    let mut candidates = vec![light];
    candidates.extend(contained(arm, &frequency));
    for body in arm.bodies.iter().filter(|body| body.on_chain && body.name != arm.root) {
        let holds_tip = body.name == arm.tip || body.welded.contains(&arm.tip);
        let (place, origin_m) =
            if holds_tip { (&arm.tip, Vector3::zeros()) } else { (&body.name, 0.5 * body.reach_m) };
        let plain = vec![frequency.clone(), mass.clone()];
        // Its mass shows where it is.
        let aside = ["com_x_m", "com_y_m", "com_z_m"].map(offset);
        let forms = [plain.clone(), [plain, aside.to_vec()].concat()];
        for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
            candidates.extend(forms.iter().map(|parameters| Candidate {
                hinge: Some(Hinge { origin_m, ..Hinge::shift(axis) }),
                // It holds the light part as a special case.
                plausibility: SELDOM + CONTAINS_PLAIN,
                ..Candidate::new(Cause::LocalMode, place, parameters.clone())
            }));
        }
    }
    candidates
}
