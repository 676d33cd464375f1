//! Sensitivities against differences, fits against what was put in.

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::super::candidate::{Candidate, Parameter, Scale};
use super::super::data::{Data, Load, Point, Row};
use super::super::hypothesis::Hypothesis;
use super::super::problem::{Evaluation, Problem};
use crate::model::{
    Carries, Cause, Conditions, CoordinateKind, Description, ElasticJoint, Hinge, Inertial, Joint,
    JointKind, Link,
};

/// A planar arm of three links.
pub(in crate::diagnosis) fn arm() -> Description {
    let link = |name: &str, mass_kg: f64| Link {
        name: name.into(),
        inertial: Some(Inertial {
            mass_kg,
            com_m: Vector3::new(0.25, 0.02, 0.03),
            inertia_kgm2: Matrix3::from_diagonal(&Vector3::new(0.3, 0.8, 0.7)),
        }),
        ..Link::default()
    };
    let joint = |i: usize, x: f64| Joint {
        name: format!("j{i}"),
        kind: JointKind::Revolute,
        parent: if i == 1 { "base".into() } else { format!("l{}", i - 1) },
        child: format!("l{i}"),
        origin: Isometry3::translation(x, 0.0, 0.1),
        axis: if i == 1 { Vector3::z() } else { Vector3::y() },
        position_limit: None,
        velocity_limit: None,
        mimics: None,
    };
    let spring = |i: usize, stiffness: f64| ElasticJoint {
        joint: format!("j{i}"),
        stiffness,
        is_linear: false,
        std: None,
        damping: None,
    };
    Description {
        name: "arm".into(),
        links: vec![link("base", 50.0), link("l1", 30.0), link("l2", 20.0), link("l3", 8.0)],
        joints: vec![joint(1, 0.0), joint(2, 0.5), joint(3, 0.6)],
        base: None,
        tip: None,
        elastic_joints: vec![spring(1, 4e5), spring(2, 2e5), spring(3, 6e4)],
        extra: vec![],
        default_damping_ratio: 0.02,
        gravity_m_per_s2: Vector3::new(0.0, 0.0, -9.81),
        gravity_stiffness: false,
        drives: vec![],
        payload: None,
        beta1: None,
        beta2: None,
        calibration: None,
        corrections: vec![],
    }
}

pub(in crate::diagnosis) fn data(rows: usize) -> Data {
    let rows: Vec<Row> = (0..rows)
        .map(|i| Row {
            q: (0..3).map(|j| (1.3 * (i + 1) as f64 * (j + 1) as f64).sin() * 2.0).collect(),
            conditions: Conditions {
                temperature_c: Some(15.0 + i as f64),
                amplitude_nm: Some(5.0 + 3.0 * i as f64),
            },
            load: Load::NOMINAL,
            sample_rate_hz: Some(40.0),
            rotations: Vec::new(),
            damping: Vec::new(),
            index: i,
        })
        .collect();
    let points = (0..3 * rows.len())
        .map(|i| Point {
            row: i / 3,
            column: i % 3,
            ln_f: 3.0,
            unit: 1.0,
            stated: 1.0,
            rounding: 0.0,
            index: i,
        })
        .collect();
    let mut data = Data::at(rows[0].clone(), 3);
    data.order_of_last = rows.len() - 1;
    (data.rows, data.points) = (rows, points);
    data
}

fn parameter(name: &'static str, scale: Scale) -> Parameter {
    let bounds = [-1e9, 1e9];
    Parameter { name, scale, nominal: None, bounds, starts: vec![], expected: None }
}

/// d ln f by every kind of parameter, against differences of solved frequencies.
#[test]
fn sensitivities_are_the_differences_of_solved_frequencies() {
    let description = arm();
    let data = data(6);
    let problem = Problem { description: &description, data: &data };
    let log = |name| parameter(name, Scale::Log);
    let linear = |name| parameter(name, Scale::Linear(0.1));
    let hinge = Hinge {
        kind: CoordinateKind::Rotation,
        axes: vec![Vector3::y()],
        origin_m: Vector3::new(0.2, 0.0, 0.0),
        carries: Carries::Rest,
    };
    let mut bends = Candidate::new(Cause::LinkFlexibility, "l1", vec![log("stiffness_nm_per_rad")]);
    let mut cut = Candidate::new(
        Cause::LinkFlexibility,
        "l2",
        vec![log("stiffness_nm_per_rad"), linear("position")],
    );
    let origin_m = Vector3::zeros();
    cut.hinge = Some(Hinge { carries: Carries::Part, origin_m, ..hinge.clone() });
    let mut rocks = Candidate::new(
        Cause::BaseCompliance,
        "base",
        vec![log("stiffness_nm_per_rad"), linear("depth_m")],
    );
    rocks.hinge = Some(Hinge { carries: Carries::Link, origin_m, ..hinge.clone() });
    let mut unlike = Candidate::new(
        Cause::BaseCompliance,
        "base",
        vec![
            log("stiffness_nm_per_rad"),
            log("stiffness_n_per_m"),
            log("ratio_2"),
            log("shift_ratio_3"),
            linear("turn_rad"),
        ],
    );
    unlike.hinge = Some(Hinge {
        carries: Carries::Link,
        origin_m,
        axes: vec![Vector3::y(), Vector3::x()],
        ..hinge.clone()
    });
    bends.hinge = Some(hinge);
    let spread = ["inertia_factor", "x_factor", "z_factor"].map(log).to_vec();
    let waves = ["cos_1", "sin_3", "factor"].map(linear).to_vec();
    let slopes = vec![log("ratio_1"), log("ratio_3"), log("torque_1_nm"), log("torque_2_nm")];
    let all = vec![log("factor"), log("ratio_2")];
    let warm = vec![linear("change_per_k")];
    let mut centred = Candidate::new(Cause::TemperatureDrift, "all", warm);
    centred.fixed = vec![("reference_c", 31.0)];
    let mut hung = Candidate::new(
        Cause::LocalMode,
        "l2",
        vec![log("frequency_hz"), log("mass_kg"), linear("com_x_m")],
    );
    hung.hinge = Some(Hinge { origin_m, ..Hinge::shift(Vector3::z()) });
    let mut own = Candidate::new(Cause::LocalMode, "l2", vec![log("frequency_hz"), log("mass_kg")]);
    own.hinge = Some(Hinge { origin_m, carries: Carries::Part, ..Hinge::shift(Vector3::z()) });
    let cases = [
        (own, vec![2.5, 1.0]),
        (hung, vec![2.5, 1.0, 2.0]),
        (unlike, vec![14.0, 15.0, 0.4, -0.3, 3.0]),
        (Candidate::new(Cause::LinkInertia, "l2", spread), vec![0.2, 0.3, -0.2]),
        (Candidate::new(Cause::PositionDependentStiffness, "j2", waves), vec![1.0, -2.0, 11.0]),
        (Candidate::new(Cause::JointCoupling, "j2", vec![linear("ratio")]), vec![3.0]),
        (Candidate::new(Cause::LoadDependentStiffness, "j2", slopes), vec![-0.4, 0.3, 3.0, 4.5]),
        (Candidate::new(Cause::JointStiffness, "all", all), vec![-0.2, 0.1]),
        (centred, vec![0.1]),
        (
            Candidate::new(Cause::JointStiffness, "j2", vec![log("stiffness_nm_per_rad")]),
            vec![12.0],
        ),
        (Candidate::new(Cause::LinkInertia, "l2", vec![log("inertia_factor")]), vec![0.2]),
        (Candidate::new(Cause::LinkInertia, "l1", vec![log("mass_factor")]), vec![-0.2]),
        (
            Candidate::new(Cause::ComOffset, "l3", vec![linear("dx_m"), linear("dz_m")]),
            vec![0.3, -0.4],
        ),
        (Candidate::new(Cause::JointZeroOffset, "j3", vec![linear("offset_rad")]), vec![0.7]),
        (
            Candidate::new(Cause::Payload, "l3", vec![linear("mass_kg"), linear("com_x_m")]),
            vec![30.0, 1.0],
        ),
        (bends, vec![12.5]),
        (cut, vec![12.5, 4.0]),
        (rocks, vec![14.0, 3.0]),
        (
            Candidate::new(
                Cause::LoadDependentStiffness,
                "j2",
                vec![linear("change_per_nm"), log("saturation_nm")],
            ),
            vec![0.05, 3.0],
        ),
        (
            Candidate::new(
                Cause::AmplitudeDependence,
                "j2",
                vec![linear("exponent"), linear("factor")],
            ),
            vec![-1.0, 11.0],
        ),
        (
            Candidate::new(Cause::DriveInertia, "j1", vec![linear("reflected_inertia_kgm2")]),
            vec![20.0],
        ),
        (
            Candidate::new(Cause::LoadDependentStiffness, "j2", vec![linear("change_per_nm")]),
            vec![0.02],
        ),
        (
            Candidate::new(
                Cause::TemperatureDrift,
                "j2",
                vec![linear("change_per_k"), linear("factor")],
            ),
            vec![0.1, 9.0],
        ),
    ];
    // With gravity's stiffness and rows under several loads every way of working out the change is
    // taken.
    let mut loaded = data.clone();
    for (i, row) in loaded.rows.iter_mut().enumerate() {
        row.load = Load { more_kg: [0.0, 3.0, 7.0][i % 3], ..Load::NOMINAL };
    }
    let heavy = Description { gravity_stiffness: true, ..arm() };
    let heavy = Problem { description: &heavy, data: &loaded };
    for (problem, (candidate, inner)) in
        [problem, heavy].iter().flat_map(|problem| cases.iter().map(move |case| (problem, case)))
    {
        let at = |inner: Vec<f64>| Hypothesis { effects: vec![(candidate, inner)] };
        let here = problem.evaluate(&at(inner.clone())).unwrap();
        for k in 0..inner.len() {
            let shifted = |by: f64| {
                let mut inner = inner.clone();
                inner[k] += by;
                problem.compare(&at(inner)).unwrap().left.residuals
            };
            let (below, above) = (shifted(-1e-5), shifted(1e-5));
            for i in 0..data.points.len() {
                // The residual falls where the prediction rises.
                let difference = (below[i].unwrap() - above[i].unwrap()) / 2e-5;
                let slope = here.left.slopes[i][k];
                let error = (slope - difference).abs();
                assert!(
                    error < 1e-6 + 1e-4 * difference.abs(),
                    "{} {k} point {i}: {slope} {difference}",
                    candidate.cause
                );
            }
        }
    }
}

/// Puts into the table what an arm with these causes shows.
fn measured_on(description: &Description, truth: &Hypothesis<'_>, data: &mut Data) {
    let shown = Problem { description, data }.compare(truth).unwrap();
    for (point, residual) in data.points.iter_mut().zip(shown.left.residuals) {
        point.ln_f -= residual.unwrap();
    }
}

/// A fit from afar finds what was put in, where nothing disturbs it.
#[test]
fn a_fit_finds_what_was_put_in() {
    let description = arm();
    let mut data = data(8);
    let log = parameter("stiffness_nm_per_rad", Scale::Log);
    let stiffness = Candidate::new(Cause::JointStiffness, "j2", vec![log]);
    let mass = parameter("mass_kg", Scale::Linear(1.0));
    let payload = Candidate::new(Cause::Payload, "l3", vec![mass]);
    let truth =
        Hypothesis { effects: vec![(&stiffness, vec![1.4e5_f64.ln()]), (&payload, vec![4.0])] };
    measured_on(&description, &truth, &mut data);
    let problem = Problem { description: &description, data: &data };
    let start =
        Hypothesis { effects: vec![(&stiffness, vec![2e5_f64.ln()]), (&payload, vec![0.5])] };
    let found = problem.optimise(start).unwrap().hypothesis.inner();
    assert!(
        (found[0].exp() / 1.4e5 - 1.0).abs() < 1e-3 && (found[1] - 4.0).abs() < 1e-2,
        "{found:?}"
    );
}

/// Two springs in a row that do nearly the same, one of which wants to be softer than it may: the
/// fit ends at that bound, with the other as soft as is best there.
#[test]
fn a_fit_ends_at_the_bound_that_it_would_cross() {
    let description = arm();
    let mut data = data(8);
    let spring = |at: &str, bounds: [f64; 2]| {
        let parameter = Parameter { bounds, ..parameter("stiffness_nm_per_rad", Scale::Log) };
        Candidate::new(Cause::JointStiffness, at, vec![parameter])
    };
    let free = [spring("j2", [1e3, 1e9]), spring("j3", [1e3, 1e9])];
    let truth = Hypothesis {
        effects: vec![(&free[0], vec![1.1e5_f64.ln()]), (&free[1], vec![3e4_f64.ln()])],
    };
    measured_on(&description, &truth, &mut data);
    let problem = Problem { description: &description, data: &data };
    let held = spring("j2", [1.5e5, 1e9]);
    let at = |a: f64, b: f64| Hypothesis { effects: vec![(&held, vec![a]), (&free[1], vec![b])] };
    let found = problem.optimise(at(4e5_f64.ln(), 4e5_f64.ln())).unwrap();
    let inner = found.hypothesis.inner();
    assert!((inner[0].exp() / 1.5e5 - 1.0).abs() < 1e-9, "{inner:?}");
    // Against a scan of the other along the bound.
    let scores = (0..4000).map(|i| {
        let b = 9.5 + 0.0005 * f64::from(i);
        (problem.compare(&at(inner[0], b)).unwrap().score, b)
    });
    let (best, at_best) = scores.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    assert!((inner[1] - at_best).abs() < 2e-2, "{inner:?} {at_best}");
    assert!(found.evaluation.score > best - 1e-2, "{} {best}", found.evaluation.score);
}

/// A mode above half the rate shows as its alias, sorted among the others.
#[test]
fn a_folded_mode_takes_its_place() {
    let description = arm();
    let data = data(4);
    let problem = Problem { description: &description, data: &data };
    let plain = problem.compare(&Hypothesis::default()).unwrap();
    let aliased = Candidate::new(Cause::AliasedMode, "3", vec![]);
    let seen = problem.compare(&Hypothesis { effects: vec![(&aliased, vec![])] }).unwrap();
    for row in 0..4 {
        let of = |e: &Evaluation| -> Vec<f64> {
            (0..3).map(|m| (3.0 - e.left.residuals[3 * row + m].unwrap()).exp()).collect()
        };
        let mut expected = of(&plain);
        assert!(expected[2] > 20.0, "{expected:?}");
        expected[2] = (expected[2] - 40.0 * (expected[2] / 40.0).round()).abs();
        expected.sort_by(f64::total_cmp);
        for (a, b) in of(&seen).iter().zip(&expected) {
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }
}
