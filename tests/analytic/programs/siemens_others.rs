//! Sinumerik: arcs across the plane, and calls of subprograms with what they know of the caller.

use detune::motion::Target;
use detune::notes::{Code, Note};
use detune::program::{Assumed, Companion, Dialect, Program, Settings, read};
use nalgebra::Vector3;

use super::support::{Begun, assert_ends, at, end, settings};

const BEGUN: Begun = Begun {
    head: "G710 G17 G90 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z0\nF600\n",
    at_mm: [0.0; 3],
    dialect: Dialect::Sinumerik,
};

fn doubts(program: &Program) -> usize {
    program.warnings.iter().filter(|note| note.code == Code::MotionLeftOut).count()
}

/// Middle of the last arc, mm.
fn middle(program: &Program) -> Vector3<f64> {
    let Some(Target::Arc { via, .. }) = program.moves.last().map(|each| &each.to) else {
        panic!("{:?}", program.moves);
    };
    via.translation.vector * 1000.0
}

/// Seen from the right, G2 in Z/X and G3 in Y/Z go below the line from start to end.
#[test]
fn axes_of_the_end_name_the_plane_of_an_arc() {
    let off = 6.0 * std::f64::consts::FRAC_1_SQRT_2;
    for (text, via) in [
        ("G2 X12 Z0 CR=6\n", [6.0, 0.0, -6.0]),
        ("G2 X12 Z0 I6 K0\n", [6.0, 0.0, -6.0]),
        ("G3 Y10 Z0 CR=5\n", [0.0, 5.0, -5.0]),
        ("G2 Z-8 I0 K-4\n", [-4.0, 0.0, -4.0]),
        ("G0 Y6 Z-2\nG2 X6 Z-8 I6 K0\n", [6.0 - off, 6.0, -2.0 - off]),
    ] {
        let program = BEGUN.run(text).unwrap();
        let found = middle(&program);
        assert!((found - Vector3::from(via)).norm() < 1e-6, "{text}: {found}");
        assert_eq!(doubts(&program), 0, "{text}: {:?}", program.warnings);
    }
    // It may be an arc in X/Y, or a helix, whose Y stays.
    for text in ["G2 X12 Z0 I6 J0\n", "G2 X12 I6 K0\n"] {
        let program = BEGUN.run(text).unwrap();
        assert!((middle(&program) - Vector3::new(6.0, 6.0, 0.0)).norm() < 1e-6, "{text}");
        assert_eq!(doubts(&program), 1, "{text}: {:?}", program.warnings);
    }
    for (text, count) in [
        ("G2 X12 Z-1 I6\n", 0),
        // It closes in X/Z, too.
        ("G2 X12 Z-1 CR=9\n", 1),
        ("G2 X12 Z-1 I6 J0\n", 0),
        ("G2 X12 Y0 Z-1 I6 J0\n", 0),
        ("G2 X12 Y0 Z-1 CR=6\n", 0),
        ("G2 X12 Y0 I6 K0\nG1 Z-1\n", 0),
    ] {
        let program = BEGUN.run(text).unwrap();
        let found = end(program.moves.last().unwrap()).1.translation.vector * 1000.0;
        assert!((found - Vector3::new(12.0, 0.0, -1.0)).norm() < 1e-6, "{text}: {found}");
        assert_eq!(doubts(&program), count, "{text}: {:?}", program.warnings);
    }
    BEGUN.refused("G2 X12 Z0 J6 K0\n", "axes of two planes");
    BEGUN.refused("G2 X6 Z-8 I6 K0\n", "in the plane of G18 that its axes name");
    // Elsewhere it is a helix.
    let head = "G21 G17 G90 G94\nS3000 M3\nG0 X0 Y0 Z0\nF600\n";
    let begun = Begun { head, dialect: Dialect::GCode, ..BEGUN };
    let program = begun.run("G2 X12 Z0 R6\n").unwrap();
    assert!((middle(&program) - Vector3::new(6.0, 6.0, 0.0)).norm() < 1e-6);
}

/// A program that calls SUB.spf, behind `BEGUN`.
fn with(sub: &str, text: &str) -> Result<Program, Vec<Note>> {
    let companions = vec![Companion { name: "SUB.spf".to_owned(), text: sub.to_owned() }];
    let job = Settings { companions, ..settings() };
    read(format!("{}{text}M30\n", BEGUN.head).as_bytes(), Dialect::Sinumerik, &job)
}

#[track_caller]
fn refused(sub: &str, text: &str, said: &str) {
    let found = with(sub, text).expect_err(text);
    assert!(found[0].what.contains(said), "{text}: {found:?}");
}

/// By machine data 11120 variables of the main program hold in its subprograms, or not.
#[test]
fn variables_of_the_main_program_in_a_subprogram_are_a_doubt() {
    let program = with("G1 X=DEEP\nRET\n", "DEF REAL DEEP\nDEEP=7\nSUB\nX=DEEP+1\n").unwrap();
    assert_ends(&program, &[0.0, 7.0, 8.0].map(|x| ('L', [x, 0.0, 0.0])));
    let told = |note: &&Note| note.what.contains("'deep' is read in a subprogram");
    let told: Vec<_> = program.warnings.iter().filter(told).collect();
    assert!(told.len() == 1 && told[0].code == Code::ChangeIgnored, "{told:?}");
    assert_eq!(at(told[0]), 8);
    // Its own is another.
    let own = with("DEF REAL DEEP=3\nG1 X=DEEP\nRET\n", "DEF REAL DEEP=7\nSUB\n").unwrap();
    assert_ends(&own, &[0.0, 3.0].map(|x| ('L', [x, 0.0, 0.0])));
    assert!(!own.warnings.iter().any(|note| note.code == Code::ChangeIgnored));
    refused("DEEP=9\nRET\n", "DEF REAL DEEP\nSUB\n", "that a subprogram sets it is not read");
}

#[test]
fn a_text_that_nothing_reads_is_left_out() {
    let text = "DEF STRING[80] MODE, _other\nMODE=\"FIXED; OLD\"\n_other=\"\"\nG1 X5\n";
    let program = with("", text).unwrap();
    assert_ends(&program, &[0.0, 5.0].map(|x| ('L', [x, 0.0, 0.0])));
    let read = "DEF STRING[80] MODE\nMODE=\"A\"\nIF MODE==\"A\"\nG1 X5\nENDIF\n";
    refused("", read, "'mode' is a text (STRING)");
    refused("", "DEF STRING[80] MODE\nMODE=R5\n", "sets a text (STRING)");
    for length in ["[ 80 ]", " [80]"] {
        let text = text.replace("[80]", length);
        with("", &text).unwrap_or_else(|why| panic!("{text}: {why:?}"));
    }
}

/// As other variables, a text belongs to the program that declares it.
#[test]
fn a_text_of_a_subprogram_is_none_of_its_caller() {
    let sub = "DEF STRING[9] MODE\nMODE=\"A\"\nRET\n";
    refused(sub, "SUB\nMODE=\"B\"\n", "'MODE=' is not understood");
    let own = with(sub, "DEF STRING[9] MODE\nSUB\nMODE=\"B\"\nG1 X5\n").unwrap();
    assert_ends(&own, &[0.0, 5.0].map(|x| ('L', [x, 0.0, 0.0])));
    let companions = vec![Companion { name: "SUB.spf".to_owned(), text: sub.to_owned() }];
    let assume = [("mode".to_owned(), Assumed::Number(3.0))].into_iter().collect();
    let job = Settings { companions, assume, ..settings() };
    let text = format!("{}SUB\nG1 X=MODE\nM30\n", BEGUN.head);
    let program = read(text.as_bytes(), Dialect::Sinumerik, &job).unwrap();
    assert_ends(&program, &[0.0, 3.0].map(|x| ('L', [x, 0.0, 0.0])));
}

#[test]
fn other_ways_to_write_a_call() {
    for text in [
        "SUB\n",
        "_N_SUB_SPF\n",
        "CALL \"SUB\"\n",
        "call \"_N_SUB_SPF\" ; by its text\n",
        "CALL \"/_N_SPF_DIR/_N_SUB_SPF\"\n",
    ] {
        let program = with("G1 X20\nRET\n", text).unwrap_or_else(|why| panic!("{text}: {why:?}"));
        assert_ends(&program, &[0.0, 20.0].map(|x| ('L', [x, 0.0, 0.0])));
    }
    refused("RET\n", "CALL \"SUB\n", "not closed");
}

#[test]
fn parameters_of_proc_may_have_a_value_of_their_own() {
    let sub = |head: &str| format!("PROC SUB({head})\nG1 X=-DEEP\nRET\n");
    for (head, text, x) in [
        ("REAL DEEP=2", "SUB\n", -2.0),
        ("REAL DEEP = 2.5", "SUB()\n", -2.5),
        ("REAL DEEP=2", "SUB(3)\n", -3.0),
        ("INT COUNT, REAL DEEP=2", "SUB(1)\n", -2.0),
        ("REAL DEEP=2, INT COUNT=1", "SUB(,4)\n", -2.0),
        ("BOOL FLAG=TRUE, REAL DEEP=2", "SUB\n", -2.0),
    ] {
        let program = with(&sub(head), text).unwrap_or_else(|why| panic!("{text}: {why:?}"));
        assert_ends(&program, &[0.0, x].map(|x| ('L', [x, 0.0, 0.0])));
    }
    refused(&sub("INT COUNT, REAL DEEP=2"), "SUB\n", "0 values for the 2 parameters");
    refused(&sub("REAL DEEP=R1"), "SUB\n", "a number, TRUE or FALSE alone");
}
