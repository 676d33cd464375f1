//! G-code whose coordinates are turned (G68) or polar (G16), subprograms by a block number (M97),
//! or a computed one, comments in comments, EXISTS; changes of tool under a turning spindle.

use detune::notes::Code;
use detune::program::{Dialect, NewSpeed, Program, Rewrite, read, rewrite};

use super::support::{Begun, assert_ends, end, settings};

const HEAD: &str = "G21 G17 G90 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z5\nF100\n";

const BEGUN: Begun = Begun { head: HEAD, at_mm: [0.0, 0.0, 5.0], dialect: Dialect::GCode };

fn told(program: &Program, said: &str) -> Vec<Code> {
    let notes = program.warnings.iter().filter(|note| note.what.contains(said));
    notes.map(|note| note.code).collect()
}

#[test]
fn g68_turns_what_follows_about_its_centre() {
    // A right angle about (10, 0): (20, 0) comes to (10, 10), and the arc about (10, 0) goes on
    // from there to (0, 0); then X alone, of a place that is (10, 10) to the program.
    let program = BEGUN.assert_way(
        "G68 X10 Y0 R90\nG1 X20 Y0\nG3 X10 Y10 I-10 J0\nG1 X20\nG69\nX5\n",
        &[
            ('L', [10.0, 10.0, 5.0]),
            ('A', [0.0, 0.0, 5.0]),
            ('L', [0.0, 10.0, 5.0]),
            ('L', [5.0, 10.0, 5.0]),
        ],
    );
    let detune::motion::Target::Arc { via, .. } = &program.moves[2].to else { panic!() };
    // The arc's middle is 10 mm from its centre, at 135°.
    let off = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    let at = via.translation.vector * 1000.0;
    assert!((at.x - (10.0 - off)).abs() < 1e-6 && (at.y - off).abs() < 1e-6, "{at}");
    // About where the tool is, clockwise.
    BEGUN.assert_way(
        "G1 X10\nG68 R-90\nG1 X20 Y0\nG69\n",
        &[('L', [10.0, 0.0, 5.0]), ('L', [10.0, -10.0, 5.0])],
    );
    // A hole at (20, 0), drilled at (10, 10), and the next in line.
    let holes = BEGUN.run("G68 X10 Y0 R90\nG81 X20 Y0 Z-5 R2\nX30\nG80\nG69\n").unwrap();
    let bottoms: Vec<[f64; 2]> = holes
        .moves
        .iter()
        .map(|each| end(each).1.translation.vector * 1000.0)
        .filter(|at| (at.z + 5.0).abs() < 1e-6)
        .map(|at| [at.x.round(), at.y.round()])
        .collect();
    assert_eq!(bottoms, [[10.0, 10.0], [10.0, 20.0]]);
    BEGUN.refused("G68 X0 Y0\n", "without R");
    BEGUN.refused("G68 R30\nG52 X5\n", "under G68");
    BEGUN.refused("G68 R30\nG18\n", "another plane under G68");
    BEGUN.refused("G68 R30\nG55\n", "another work offset under G68");
    BEGUN.refused("G68 R30\nG91 G1 X5\n", "G91 under G68");
    BEGUN.refused("G68 R30\nG28 X0 Y0\n", "under G68");
    BEGUN.refused("G68 X0 Y0 Z0 I1 J0 K0 R30\n", "in the plane alone");
}

#[test]
fn g16_reads_radius_and_angle() {
    let root = 75.0_f64.sqrt();
    let program = BEGUN.assert_way(
        "G16\nG1 X10 Y30\nY90\nG15\nX0 Y0\n",
        &[('L', [root, 5.0, 5.0]), ('L', [0.0, 10.0, 5.0]), ('L', [0.0, 0.0, 5.0])],
    );
    assert_eq!(told(&program, "G16"), []);
    // Mach3 counts from where the tool is.
    let elsewhere = BEGUN.run("G1 X5\nG16\nX10 Y90\nG15\n").unwrap();
    assert_eq!(told(&elsewhere, "Mach3"), [Code::ChangeIgnored]);
    let holes = BEGUN.run("G16\nG81 X40 Y0 Z-10 R2\nY60\nG15 G80\n").unwrap();
    let down = holes.moves.iter().map(|each| end(each).1.translation.vector * 1000.0);
    let down: Vec<_> = down.filter(|at| at.z < -9.0).collect();
    let second = nalgebra::Vector3::new(20.0, 1200.0_f64.sqrt(), -10.0);
    assert!(down.len() == 2 && (down[1] - second).norm() < 1e-6, "{down:?}");
    BEGUN.refused("G16\nG1 X10\n", "without a radius");
    BEGUN.refused("G16\nG91 G1 X10 Y30\n", "relative polar");
    BEGUN.refused("G16\nG2 X10 Y30 I5\n", "centre under G16");
    BEGUN.refused("G16\nG92 X0\n", "under G16");
}

#[test]
fn m97_runs_from_a_block_number_to_m99() {
    let text = format!("{HEAD}G91\nM97 P100 L2\nG1 X10\nM30\nN100 G1 X1\nM99\n");
    let program = read(text.as_bytes(), Dialect::GCode, &settings()).unwrap();
    let expected = [0.0, 1.0, 2.0, 12.0].map(|x| ('L', [x, 0.0, 5.0]));
    assert_ends(&program, &expected);
    assert!(program.warnings.iter().all(|note| note.code != Code::MotionLeftOut));
    BEGUN.refused("M97 P7\n", "no N7");
    BEGUN.refused("M97\n", "M97 without P");
}

#[test]
fn comments_in_comments_end_where_every_controller_ends_them() {
    let second = [('L', [1.0, 0.0, 5.0])];
    BEGUN.assert_way("( Drilling at (1, 2) )\nG1 X1\n", &second);
    BEGUN.assert_way("(a (b (c) ) ) G1 X1 (end)\n", &second);
    BEGUN.refused("(a (b) X5)\nG1 X1\n", "a comment in a comment");
    BEGUN.refused("(a (b) G1 X1\n", "a comment in a comment");
    // Nothing stands behind it.
    BEGUN.assert_way("(C:\\A(B\\X.NC)\nG1 X1\n", &second);
    BEGUN.assert_way("G1 X1 (a (b (c) ) \n", &second);
    BEGUN.assert_way("G1 X1 (a (b) ; c\n", &second);
    // In expressions, too.
    BEGUN.assert_way("#1=1 (a (b))\nG1 X#1 (a (b)\n", &second);
    for text in [
        "(a (b) ; ) G1 X9",
        "#1=5 (a (b) ; ) + 40",
        "#1=5 (a (b) + 1",
        "#1=[5 (a (b) + 1]",
        "#1=5 + (a (1) + 2) 1",
    ] {
        BEGUN.refused(&format!("{text}\nG1 X1\n"), "a comment in a comment");
    }
}

/// LinuxCNC: `o#1 call`.
#[test]
fn a_subroutine_by_a_computed_number() {
    const SUB: &str = "O200 SUB\nG1 X[#1+20]\nO200 ENDSUB\n#1=200\n";
    let ends = [('L', [30.0, 0.0, 5.0]), ('L', [40.0, 0.0, 5.0])];
    BEGUN.assert_way(&format!("{SUB}O#1 CALL [10]\no [#1 - 1 + 1] call [#1/10]\n"), &ends);
    // 2.01 times 100 is 200.99999999999997.
    BEGUN.refused("O[2.01*100] CALL [10]\n", "O<201> is not in this file");
    BEGUN.refused(&format!("{SUB}O[#1+1] CALL [10]\n"), "O<201> is not in this file");
    BEGUN.refused(&format!("{SUB}O[#1+0.5] CALL [10]\n"), "O200.5 CALL: expected a whole number");
    BEGUN.refused(&format!("{SUB}O#1 IF [1]\nO#1 ENDIF\n"), "with CALL alone");
    BEGUN.refused("O#2 CALL [10]\n", "#2 is read, and the program has not set it");
}

/// A loop whose condition cannot be read is told once, and its body is passed over.
#[test]
fn a_loop_with_a_condition_that_is_not_known() {
    for text in
        ["WHILE [#2001 LT 5] DO1\n#2001=#2001+1\nEND1\n", "O1 WHILE [#2001 LT 5]\nO1 ENDWHILE\n"]
    {
        let found = BEGUN.run(text).unwrap_err();
        assert!(found.len() == 1 && found[0].what.contains("#2001 is read"), "{found:?}");
    }
}

#[test]
fn exists_tells_what_is_set() {
    let fifth = [('L', [5.0, 0.0, 5.0])];
    BEGUN.assert_way("#<a>=0\n#1=[EXISTS[#<a>]*5]\nG1 X#1\n", &fifth);
    BEGUN.assert_way("#1=[5-EXISTS[#<b>]]\nG1 X#1\n", &fifth);
    BEGUN.refused("#1=EXISTS[#<_vmajor>]\nG1 X1\n", "one of the controller's");
}

#[test]
fn a_spindle_that_turned_before_the_change_of_tool_is_a_doubt() {
    let lines = |text: &str| {
        let program = BEGUN.run(text).unwrap();
        let notes = program.warnings.into_iter();
        let notes = notes.filter(|note| note.what.contains("before the change of tool"));
        notes.map(|note| (note.code, note.place.line)).collect::<Vec<_>>()
    };
    assert_eq!(lines("G1 X5\nT2 M6\nG0 X9\nG1 Y5\n"), [(Code::SpindleCommand, Some(9))]);
    for restart in ["T2 M6\nM3\n", "T2 M6 M3\n", "M5\nT2 M6\nM3\n", "T2 M6\nM5\nM4\n"] {
        assert_eq!(lines(&format!("G1 X5\n{restart}G1 Y5\n")), [], "{restart}");
    }
}

#[test]
fn turned_programs_are_rewritten() {
    let text = format!("{HEAD}G68 X0 Y0 R30\nG1 X20 F600\nG69\nG16\nX10 Y30\nG15\nM30\n");
    let speeds = vec![NewSpeed { end: usize::MAX, rpm: 6000.0, job_rpm: None }];
    let to = Rewrite { speeds, keeps_chip_load: true };
    let found = rewrite(text.as_bytes(), Dialect::GCode, &settings(), &to).unwrap();
    let expected = text.replace("S3000", "S6000").replace("F100", "F200").replace("F600", "F1200");
    assert_eq!(String::from_utf8(found.bytes).unwrap(), expected);
}

/// Fanuc (B-62764EN) asks for an absolute command behind G69; behind either, controls differ in what
/// an axis that is not stated counts from.
#[test]
fn places_behind_g68_and_g69_are_to_be_stated() {
    let doubts = |text: &str, code: &str| {
        let said = format!("the first move in the plane behind {code}");
        told(&BEGUN.run(text).unwrap(), &said)
    };
    let turned = "G68 X10 Y0 R90\nG1 X20 Y0\n";
    assert_eq!(doubts(&format!("{turned}G69\nG91 X10\nG90\n"), "G69"), [Code::ChangeIgnored]);
    assert_eq!(doubts(&format!("{turned}G69\nX5\n"), "G69"), [Code::ChangeIgnored]);
    assert_eq!(doubts("G68 X10 Y0 R90\nG1 X20\n", "G68"), [Code::ChangeIgnored]);
    assert_eq!(doubts(&format!("{turned}G69\nG92 X0\nG0 X5\n"), "G69"), [Code::ChangeIgnored]);
    let stated = format!("{turned}G69\nG0 Z9\nX0 Y0\nX5\nG91 X1\n");
    let set = format!("{turned}G69\nG92 X0 Y0\nG0 X5\n");
    // The tool stands at the centre, which has the same coordinates.
    for text in [stated.as_str(), &set, "G1 X10\nG68 R-90\nG1 X20\n"] {
        assert!(doubts(text, "G6").is_empty(), "{text}");
    }
}
