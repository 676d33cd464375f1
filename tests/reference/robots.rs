//! The robots that come with the crate: what their files promise.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::{Path, PathBuf};

use detune::input::{Reading, read_robot};
use detune::model::{JointKind, Placement, Robot, forward_kinematics};
use detune::modes::{ModalSolver, Modes};

fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(path)
}

fn robot(path: &str) -> Robot {
    let mut reading = Reading::default();
    let robot = read_robot(&file(path), &mut reading);
    assert!(reading.warnings.is_empty(), "{path}: {:?}", reading.warnings);
    robot.unwrap_or_else(|errors| panic!("{path}: {errors:?}"))
}

/// Rows of a table of two modes over β2 at β1 = 2π/3: (β2, f1, f2) where measured.
fn table(path: &str) -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(file(path)).expect("table");
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.filter_map(|row| {
        let cells: Vec<f64> = row.split(',').filter_map(|cell| cell.parse().ok()).collect();
        let [beta1, row @ ..] = <[f64; 4]>::try_from(cells).ok()?;
        assert!((beta1 - 2.0 * PI / 3.0).abs() < 1e-7, "{row:?}");
        Some(row)
    })
    .collect()
}

/// Mass of each link as the URDF says.
fn masses(path: &str) -> BTreeMap<String, f64> {
    let text = std::fs::read_to_string(file(path)).expect("URDF");
    let document = roxmltree::Document::parse(&text).expect("XML");
    document
        .descendants()
        .filter(|node| node.has_tag_name("mass"))
        .map(|node| {
            let link = node.ancestors().find(|a| a.has_tag_name("link")).expect("link");
            let mass = node.attribute("value").expect("value").parse().expect("number");
            (link.attribute("name").expect("name").to_owned(), mass)
        })
        .collect()
}

/// Table 1 of Pietruś & Gierlak (2023) in its Eq. (45); their own Table 2 says otherwise.
#[test]
fn two_link_arm_has_the_frequencies_of_table_1() {
    let robot = robot("two-link/robot.yaml");
    let beta2 = robot.beta2().expect("beta2");
    for (angle, f1, f2) in
        [(0.174, "21.88", "413.24"), (1.571, "25.76", "84.18"), (2.618, "28.77", "144.68")]
    {
        // Not on β1.
        for beta1 in [0.0, 2.0 * PI / 3.0] {
            let q = [beta1, angle];
            assert_eq!(beta2.at(&q), angle);
            let modes = Modes::at(&robot, &q).expect("modes");
            let found: Vec<String> =
                modes.natural_frequencies_hz.iter().map(|f| format!("{f:.2}")).collect();
            assert_eq!(found, [f1, f2], "beta2 = {angle}");
        }
    }
}

/// β1 and β2 count counter-clockwise from the horizontal, with z up.
#[test]
fn two_link_arm_turns_as_the_paper_draws_it() {
    let robot = robot("two-link/robot.yaml");
    let mut placement = Placement::new(&robot);
    placement.place(&robot, &[FRAC_PI_2, -FRAC_PI_2]);
    let tip = forward_kinematics(&robot, &placement).translation.vector;
    assert!((tip - nalgebra::Vector3::new(0.665, 0.0, 0.63)).amax() < 1e-15, "{tip}");
}

#[test]
fn table_2_is_whole() {
    let measured = table("two-link/measured.csv");
    assert_eq!(measured.len(), 20);
    assert_eq!(measured[6], [1.571, 23.195, 39.40]);
    let simulated = table("two-link/simulated.csv");
    assert_eq!(simulated.len(), 21);
    assert_eq!(simulated[20], [-2.269, 25.07, 40.12]);
}

/// Joint positions of the IRB 1600 at the paper's β1 = 120° and a β2, wrist straight.
fn measured_pose(beta2: f64) -> [f64; 6] {
    [0.0, FRAC_PI_2 - 2.0 * PI / 3.0, -beta2 - FRAC_PI_2, 0.0, 0.0, 0.0]
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn irb_1600_weighs_what_its_data_sheet_says() {
    let total: f64 = masses("irb1600/irb1600.urdf").values().sum();
    assert!((total - 250.0).abs() < 1e-9, "{total} kg");
}

#[test]
fn irb_1600_has_its_published_kinematics() {
    let robot = robot("irb1600/robot.yaml");
    assert_eq!(robot.joints().len(), 6);
    assert_eq!(robot.coordinates().len(), 6);
    let mut placement = Placement::new(&robot);
    placement.place(&robot, &[0.0; 6]);
    let tip = forward_kinematics(&robot, &placement);
    let expected = nalgebra::Vector3::new(0.15 + 0.6 + 0.065, 0.0, 0.4865 + 0.7);
    assert!((tip.translation.vector - expected).amax() < 1e-15, "{tip}");
    assert!((tip.rotation * nalgebra::Vector3::z() - nalgebra::Vector3::x()).amax() < 1e-15);
    for beta2 in [2.618, -2.269] {
        let q = measured_pose(beta2);
        assert!((robot.beta2().expect("beta2").at(&q) - beta2).abs() < 1e-15);
        assert!((robot.beta1().expect("beta1").at(&q) - 2.0 * PI / 3.0).abs() < 1e-15);
        for (joint, value) in robot.joints().iter().zip(q) {
            let [low, high] = joint.limit.expect("limit");
            assert!((low..=high).contains(&value), "{}: {value}", joint.name);
        }
    }
}

/// `robots/irb1600/fit.py` attains 3.998 % over 20 poses and two modes; the best that two springs with the
/// paper's stiffness can do, whatever the bodies, is 3.997 %.
#[test]
fn planar_section_of_the_irb_1600_reproduces_the_measured_frequencies() {
    let robot = robot("irb1600/planar.yaml");
    let mut solver = ModalSolver::new(&robot);
    let mut errors = Vec::new();
    for [beta2, f1, f2] in table("two-link/measured.csv") {
        let found = solver.frequencies_hz(&measured_pose(beta2)).expect("modes");
        assert_eq!(found.len(), 2);
        errors.extend([found[0] / f1 - 1.0, found[1] / f2 - 1.0]);
    }
    let percent = 100.0 * rms(&errors);
    assert_eq!(format!("{percent:.3}"), "3.998");
}

/// With all six joints elastic the two modes in the arm's plane stay where they are.
#[test]
fn six_axes_of_the_irb_1600_keep_the_modes_of_the_section() {
    let robot = robot("irb1600/robot.yaml");
    let (mut solver, mut errors) = (ModalSolver::new(&robot), Vec::new());
    for [beta2, f1, f2] in table("two-link/measured.csv") {
        solver.solve(&measured_pose(beta2)).expect("modes");
        let modes = solver.modes();
        let in_plane: Vec<f64> = (0..6)
            .filter(|&r| {
                let share = solver.strain_energy_shares(r);
                share[1] + share[2] + share[4] > 0.5
            })
            .map(|r| modes.natural_frequencies_hz[r])
            .collect();
        errors.extend([in_plane[0] / f1 - 1.0, in_plane[1] / f2 - 1.0]);
    }
    let percent = 100.0 * rms(&errors);
    assert_eq!(format!("{percent:.3}"), "3.999");
}

#[test]
fn rail_mill_is_no_six_axis_arm() {
    let robot = robot("rail-mill/robot.yaml");
    let kinds: Vec<JointKind> = robot.joints().iter().map(|joint| joint.kind).collect();
    assert_eq!(kinds[0], JointKind::Prismatic);
    assert_eq!(kinds.len(), 7);
    assert_eq!(robot.coordinates().len(), 10);
    let modes = Modes::at(&robot, &[0.4, 0.3, -0.2, 0.3, 0.1, 0.7, 0.0]).expect("modes");
    // The scale of measured milling robots: first modes at 7 to 11 Hz, all below some hundred Hz.
    let f = &modes.natural_frequencies_hz;
    assert!((5.0..15.0).contains(&f[0]) && f[9] < 500.0, "{f:?}");
    assert!(
        modes.damping_ratios.iter().all(|z| (0.005..0.3).contains(z)),
        "{:?}",
        modes.damping_ratios
    );
}
