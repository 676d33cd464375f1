//! Drilling cycles of Fanuc and Haas: patterns of holes, repeats, and words that the two read
//! differently.

use detune::notes::Code;
use detune::program::Dialect;

use super::support::{Begun, at, end};

const BEGUN: Begun = Begun {
    head: "G21 G17 G90 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z10\n",
    at_mm: [0.0, 0.0, 10.0],
    dialect: Dialect::GCode,
};

/// Where holes are drilled, in order: X and Y of the moves down to Z = -5 mm.
#[track_caller]
fn assert_holes(text: &str, expected: &[[f64; 2]]) {
    let program = BEGUN.run(text).unwrap();
    let ends = program.moves.iter().map(|each| end(each).1.translation.vector * 1000.0);
    let found: Vec<_> = ends.filter(|at| (at.z + 5.0).abs() < 1e-6).collect();
    assert_eq!(found.len(), expected.len(), "{text}: {found:?}");
    for (found, [x, y]) in found.iter().zip(expected) {
        assert!((found.x - x).hypot(found.y - y) < 1e-6, "{text}: {found}, expected {x}, {y}");
    }
}

/// Lines of doubts about motion.
fn told(text: &str) -> Vec<usize> {
    let program = BEGUN.run(text).unwrap();
    let notes = program.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
    notes.map(at).collect()
}

/// Haas' G70 and G71: counterclockwise from X, about where the tool is or X and Y.
#[test]
fn circles_and_arcs_of_holes() {
    let hole = |x, y| [10.0, 2.0, -5.0, 2.0, 10.0].map(|z| ('L', [x, y, z]));
    let holes = [hole(0.0, 20.0), hole(-20.0, 0.0), hole(0.0, -20.0), hole(20.0, 0.0)].concat();
    let program = BEGUN.assert_way(
        "G81 G98 Z-5. R2. F100. L0\nG70 I20. J90. L4\nG80\nG0 X1.\n",
        &[&holes[..], &[('L', [1.0, 0.0, 10.0])]].concat(),
    );
    assert!((program.moves[3].feed_m_per_s * 6e4 - 100.0).abs() < 1e-9);
    let root = 75.0_f64.sqrt();
    assert_holes(
        "G81 Z-5 R2 F100 L0\nG71 X5 Y5 I10 J30 K-60 L3\n",
        &[[5.0 + root, 10.0], [5.0 + root, 0.0], [5.0, -5.0]],
    );
    // In the block of the cycle; behind a hole in the middle; under G91.
    assert_holes("G81 G70 X5 Y0 Z-5 R2 I10 L2 F100\n", &[[15.0, 0.0], [-5.0, 0.0]]);
    assert_holes("G81 Z-5 R2 F100\nG70 I10 L1\n", &[[0.0, 0.0], [10.0, 0.0]]);
    assert_holes("G81 Z-5 R2 F100 L0\nG91 G70 X3 Y4 I10 L1\n", &[[13.0, 4.0]]);
    // Without these words it is a unit.
    assert_holes("G81 X5 Z-5 R2 F100\nG71 X8\n", &[[5.0, 0.0], [8.0, 0.0]]);
    BEGUN.refused("G70 I5 L4\n", "needs a drilling cycle");
    BEGUN.refused("G81 Z-5 R2 F100 L0\nG80\nG71 I5 K9 L4\n", "needs a drilling cycle");
    BEGUN.refused("G81 Z-5 R2 F100 L0\nG70 L4\n", "G70 has no I");
    BEGUN.refused("G81 Z-5 R2 F100 L0\nG71 I5 L4\n", "G71 has no K");
    BEGUN.refused("G81 Z-5 R2 F100 L0\nG70 I5 L2.5\n", "whole number");
    BEGUN.refused("G81 Z-5 R2 F100 L0\nG72 I5 J0 L4\n", "G72 is not understood");
    for forgotten in ["I5 J15 L4\n", "L4\n", "K3\n"] {
        BEGUN.refused(&format!("G81 X1 Z-5 R2 F100\n{forgotten}"), "without an axis");
    }
}

/// Whether the tool has gone to the X and Y of L0, and where a pattern leaves its centre.
#[test]
fn holes_that_count_from_an_unclear_place_are_a_doubt() {
    for (text, lines) in [
        ("G81 X10 Y0 Z-5 R2 F100 L0\nG70 I5 L4\n", vec![6]),
        ("G81 X10 Y0 Z-5 R2 F100 L0\nY5\n", vec![6]),
        ("G81 Z-5 R2 F100 L0\nG70 I5 L4\nG70 I8 L4\n", vec![7]),
        ("G81 X10 Y0 Z-5 R2 F100 L0\nG70 X10 Y0 I5 L4\n", vec![]),
        ("G81 X0 Y0 Z-5 R2 F100 L0\nG70 I5 L4\n", vec![]),
        ("G81 X10 Y0 Z-5 R2 F100 L0\nX5 Y5\nX6\n", vec![]),
        ("G81 Z-5 R2 F100 L0\nG70 I5 L4\nG70 X0 Y0 I8 L4\n", vec![]),
    ] {
        assert_eq!(told(text), lines, "{text}");
    }
}

/// K is a number of repeats on Fanuc, and in G73 and G83 a depth on Haas.
#[test]
fn repeats_that_controls_read_otherwise_are_a_doubt() {
    for (text, lines) in [
        ("G83 X10. Y0. Z-20. R2. Q4. K8. F100.\n", vec![5]),
        ("G91 G73 X10 Z-20 R-8 Q4 K2 F100\n", vec![5]),
        ("G83 X10 Z-20 R2 Q4 L1 K12 F100\n", vec![5]),
        ("G81 X10 Z-5 R2 L3 F100\n", vec![5]),
        ("G81 X10 Z-5 R2 K3 F100\n", vec![5]),
        ("G91 G81 X10 Z-5 R-8 K3 F100\n", vec![]),
        ("G83 X10 Z-20 R2 Q4 F100\n", vec![]),
        ("G81 X10 Z-5 R2 K1 F100\n", vec![]),
    ] {
        assert_eq!(told(text), lines, "{text}");
    }
    BEGUN.refused("G83 X10 Z-20 R2 Q4 K0.5 F100\n", "a depth on Haas");
    BEGUN.refused("G83 X10 Z-20 R2 I4 J1 K2 F100\n", "I and J in a cycle");
    BEGUN.refused("G73 X10 Z-20 R2 I4 J1 K2 F100\n", "I and J in a cycle");
}

#[test]
fn a_peck_of_a_parameter_may_have_a_point() {
    let doubts = |text: &str| {
        let program = BEGUN.run(text).unwrap();
        let said = program.warnings.iter().filter(|note| note.what.contains("decimal point"));
        said.map(at).collect::<Vec<_>>()
    };
    assert_eq!(doubts("#9=.5\nG83 X5 Z1.8 R2 Q#9 F100\n"), [0; 0]);
    assert_eq!(doubts("#9=5\nG83 X5 Z1.8 R2 Q#9 F100\n"), [6]);
    assert_eq!(doubts("G83 X5 Z1.8 R2 Q5 F100\n"), [5]);
}
