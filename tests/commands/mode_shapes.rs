//! Mode shapes part models that frequencies cannot. Two sets of inertia give the simulated columns of the paper's
//! Table 2, M = [[a1 + 2 a2 c, a3 + a2 c], [·, a3]] about the joints with the springs of Table 1: a1, a3 = 26.63, 2.19
//! and 15.89, 4.87 kg·m². They part in how far the links turn against each other.

use std::fs;
use std::path::Path;

use detune::input::{Reading, read_described_robot};
use detune::model::{Placement, Robot, link_rotation};
use detune::modes::Modes;
use nalgebra::{Matrix2, Vector2};
use serde_json::Value;

use crate::program::{self, err, repository};

const SPRINGS: [f64; 2] = [555_000.0, 138_000.0];

/// Rotations of both links against the ground in both modes, for a row of the table.
fn rotations([a1, a3]: [f64; 2], [f1, f2]: [f64; 2]) -> [[f64; 2]; 2] {
    let [x1, x2] = [f1, f2].map(|f| (std::f64::consts::TAU * f).powi(2));
    let [k1, k2] = SPRINGS;
    // The sum of both ω² gives a2 c.
    let a2c = (k1 * k2 * (1.0 / x1 + 1.0 / x2) - k1 * a3 - k2 * a1) / (2.0 * k2);
    let mass = Matrix2::new(a1 + 2.0 * a2c, a3 + a2c, a3 + a2c, a3);
    let root = Matrix2::from_diagonal(&Vector2::new(k1, k2).map(|k| k.sqrt().recip()));
    let eigen = (root * mass * root).symmetric_eigen();
    let first = usize::from(eigen.eigenvalues[1] > eigen.eigenvalues[0]);
    [first, 1 - first].map(|mode| {
        let shape = root * eigen.eigenvectors.column(mode);
        [shape[0], shape[0] + shape[1]]
    })
}

/// The diagnosis of the simulated columns, with the shapes of a model beside them, and the robot that it writes.
fn diagnosed(model: [f64; 2], folder: &Path) -> (Value, Robot) {
    let two_link = repository().join("robots/two-link");
    let mut text = String::from(
        "beta1_rad,beta2_rad,f1_hz,f2_hz,phi1_link_1,phi1_link_2,phi2_link_1,phi2_link_2\n",
    );
    let table = fs::read_to_string(two_link.join("simulated.csv")).unwrap();
    for line in table.lines().filter(|line| line.starts_with("2.09")).step_by(3) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [one, two] = rotations(model, [cells[2], cells[3]]);
        text += &format!("{line},{},{},{},{}\n", one[0], one[1], two[0], two[1]);
    }
    let file = folder.join("with_shapes.csv");
    fs::write(&file, text).unwrap();
    let written = folder.join("arm.yaml");
    let [table, arm] = [&file, &written].map(|path| path.to_str().unwrap());
    let arguments = ["diagnose", "robots/two-link", table, "--format", "json", "--write", arm];
    let output = program::run(repository(), &arguments);
    assert!(output.status.success(), "{}", err(&output));
    let robot = read_described_robot(&written, &mut Reading::default()).unwrap();
    fs::remove_file(written).unwrap();
    (program::json(&output), robot.robot)
}

#[test]
fn shapes_part_the_two_models_of_the_simulated_columns() {
    let folder = tempfile::tempdir().unwrap();
    // Where the second link stands square to the first, 0.73 : 1 and 0.27 : 1.
    for (model, expected) in [([26.63, 2.19], 0.73), ([15.89, 4.87], 0.27)] {
        let [[one, two], _] = rotations(model, [23.33, 41.60]);
        assert!((one / two - expected).abs() < 0.03, "{}", one / two);
        let (found, robot) = diagnosed(model, folder.path());
        let q = [2.0943951, 1.571];
        let modes = Modes::at(&robot, &q).unwrap();
        let mut placement = Placement::new(&robot);
        placement.place(&robot, &q);
        let [one, two] = ["link_1", "link_2"].map(|link| {
            let turns = link_rotation(&robot, &placement, link, None).unwrap();
            turns.iter().zip(modes.shapes.column(0).iter()).map(|(t, phi)| t * phi).sum::<f64>()
        });
        println!("{model:?}: {:.3} : 1, {}", one / two, found["findings"]);
        assert!((one / two - expected).abs() < 0.1, "{} for {model:?}", one / two);
        assert!(found["extended"]["heldout_rms_percent"].as_f64().unwrap() < 3.0);
    }
}
