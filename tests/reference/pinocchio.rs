//! M(q), gravity's stiffness, modes, damping and the tip against an independent computation, through the
//! robot files: expected numbers from `tests/data/reference/make.py` (Pinocchio, and forty digits by
//! mpmath), see SOURCES.md there. Robots: UR10 (6 axes), Panda (7), eight random trees, and two of ours.

use std::fs;
use std::path::{Path, PathBuf};

use detune::input::{Reading, read_robot};
use detune::model::{elastic_jacobian, forward_kinematics, gravity_stiffness};
use detune::modes::ModalSolver;
use nalgebra::{DMatrix, Matrix6xX, Point3};
use serde_json::Value;

/// M and K_g: rounding of some hundred operations; 5e-15 was the worst seen.
const MATRIX: f64 = 1e-13;

/// Pose and Jacobian of the tip, m and rad per unit: 2e-15 was the worst seen.
const TIP: f64 = 1e-13;

/// Frequencies and damping ratios: rounding of M times the condition of the scaled matrix; 1.3e-14 was
/// the worst seen.
const MODAL: f64 = 1e-12;

/// Shapes: the same over the relative distance to the nearest other mode; 4e-15 was the
/// worst seen.
const SHAPE: f64 = 1e-13;

#[derive(Default)]
struct Worst {
    mass: f64,
    gravity: f64,
    tip: f64,
    frequency: f64,
    damping: f64,
    shape: f64,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reference")
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().expect("rows").iter().map(numbers).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

fn keep_worst(worst: &mut f64, error: f64) {
    assert!(error.is_finite(), "a result is not a number");
    *worst = worst.max(error);
}

/// Compares one case at all its poses.
fn compare(name: &str) -> Worst {
    let text = fs::read_to_string(folder().join(format!("{name}.json"))).expect("reference");
    let reference: Value = serde_json::from_str(&text).expect("JSON");
    let file = folder().join(reference["robot"].as_str().expect("robot file"));
    let robot = read_robot(&file, &mut Reading::default())
        .unwrap_or_else(|errors| panic!("{name}: {errors:?}"));
    let joints: Vec<&str> = robot.joints().iter().map(|j| j.name.as_str()).collect();
    assert_eq!(serde_json::json!(joints), reference["joints"], "{name}: moving joints");

    // The reference may count the coordinates of a branching tree in another order.
    let listed: Vec<&str> = reference["coordinates"]
        .as_array()
        .expect("names")
        .iter()
        .filter_map(Value::as_str)
        .collect();
    assert_eq!(listed.len(), robot.coordinates().len(), "{name}: elastic coordinates");
    let at: Vec<usize> = robot
        .coordinates()
        .iter()
        .map(|c| listed.iter().position(|l| *l == c.name).expect("coordinate"))
        .collect();
    let n = at.len();
    let tcp = Point3::from_slice(&numbers(&reference["tcp_m"]));

    let mut worst = Worst::default();
    let mut solver = ModalSolver::new(&robot);
    for pose in reference["poses"].as_array().expect("poses") {
        let q: Vec<f64> = joints.iter().map(|j| pose["q"][j].as_f64().expect("joint")).collect();
        let modes = solver.solve(&q).unwrap_or_else(|fault| panic!("{name}: {fault}")).clone();

        let expected = matrix(&pose["mass"]);
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let scale = (expected[(at[i], at[i])] * expected[(at[j], at[j])]).sqrt();
            let error = (solver.mass()[(i, j)] - expected[(at[i], at[j])]).abs() / scale;
            keep_worst(&mut worst.mass, error);
        }

        assert_eq!(
            robot.has_gravity_stiffness(),
            pose.get("gravity_stiffness").is_some(),
            "{name}"
        );
        if let Some(expected) = pose.get("gravity_stiffness").map(matrix) {
            let mut found = DMatrix::zeros(n, n);
            gravity_stiffness(&robot, solver.placement(), &mut found);
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let error = (found[(i, j)] - expected[(at[i], at[j])]).abs() / expected.amax();
                keep_worst(&mut worst.gravity, error);
            }
        }

        let expected = matrix(&pose["tip_jacobian"]);
        let mut jacobian = Matrix6xX::zeros(n);
        elastic_jacobian(&robot, solver.placement(), &tcp, &mut jacobian);
        for (row, i) in (0..6).flat_map(|row| (0..n).map(move |i| (row, i))) {
            keep_worst(&mut worst.tip, (jacobian[(row, i)] - expected[(row, at[i])]).abs());
        }
        let tip = forward_kinematics(&robot, solver.placement());
        let rotation = tip.rotation.to_rotation_matrix();
        let expected = matrix(&pose["tip_rotation"]);
        let position = numbers(&pose["tip_position_m"]);
        for row in 0..3 {
            keep_worst(&mut worst.tip, (tip.translation.vector[row] - position[row]).abs());
            for column in 0..3 {
                let error = rotation[(row, column)] - expected[(row, column)];
                keep_worst(&mut worst.tip, error.abs());
            }
        }

        let frequencies = numbers(&pose["frequencies_hz"]);
        let damping = numbers(&pose["damping_ratios"]);
        let shapes = matrix(&pose["shapes"]);
        for r in 0..n {
            let f = frequencies[r];
            keep_worst(&mut worst.frequency, (modes.natural_frequencies_hz[r] / f - 1.0).abs());
            keep_worst(&mut worst.damping, (modes.damping_ratios[r] / damping[r] - 1.0).abs());
            // Every coordinate on one scale: the root of its part in the strain energy.
            let omega = f * std::f64::consts::TAU;
            let weigh = |i: usize, phi: f64| phi * robot.coordinates()[i].stiffness.sqrt() / omega;
            let pairs: Vec<(f64, f64)> = (0..n)
                .map(|i| (weigh(i, modes.shapes[(i, r)]), weigh(i, shapes[(at[i], r)])))
                .collect();
            let sign = pairs.iter().map(|(a, b)| a * b).sum::<f64>().signum();
            let apart = (0..n)
                .filter(|&s| s != r)
                .map(|s| (frequencies[s] / f - 1.0).abs())
                .fold(1.0, f64::min);
            for (found, expected) in pairs {
                keep_worst(&mut worst.shape, (found - sign * expected).abs() * apart);
            }
        }
    }
    worst
}

fn check(names: &[&str]) {
    for name in names {
        let worst = compare(name);
        println!(
            "{name}: M {:.1e}, K_g {:.1e}, tip {:.1e}, f {:.1e}, zeta {:.1e}, shapes {:.1e}",
            worst.mass, worst.gravity, worst.tip, worst.frequency, worst.damping, worst.shape
        );
        for (what, error, limit) in [
            ("mass matrix", worst.mass, MATRIX),
            ("gravity stiffness", worst.gravity, MATRIX),
            ("tip", worst.tip, TIP),
            ("frequency", worst.frequency, MODAL),
            ("damping ratio", worst.damping, MODAL),
            ("mode shape", worst.shape, SHAPE),
        ] {
            assert!(error <= limit, "{name}: {what} differs by {error:e}, allowed {limit:e}");
        }
    }
}

#[test]
fn six_axes_of_a_ur10() {
    check(&["ur10-payload-base-drives", "ur10-rigid-wrist-on-a-wall"]);
}

#[test]
fn seven_axes_of_a_panda() {
    check(&["panda-seven-axes-gravity", "panda-upper-part"]);
}

#[test]
fn random_trees() {
    check(&[
        "random-1-3-axes",
        "random-2-5-axes",
        "random-3-6-axes",
        "random-4-6-axes",
        "random-5-7-axes",
        "random-6-7-axes",
        "random-7-8-axes",
        "random-8-9-axes",
    ]);
}

#[test]
fn robots_of_this_repository() {
    check(&["irb1600", "rail-mill"]);
}

/// No reference file is left out of the tests above.
#[test]
fn every_reference_is_used() {
    let this = include_str!("pinocchio.rs");
    let mut found = 0;
    for entry in fs::read_dir(folder()).expect("folder") {
        let path = entry.expect("entry").path();
        if path.extension().is_some_and(|e| e == "json") {
            let name = path.file_stem().expect("name").to_string_lossy().into_owned();
            assert!(
                name == "summary" || this.contains(&format!("\"{name}\"")),
                "{name} is not used"
            );
            found += 1;
        }
    }
    assert_eq!(found, 15);
}
