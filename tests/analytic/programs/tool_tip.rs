//! Rotary axes of G-code with tool centre point control and without, and arcs below the resolution
//! of controls.

use detune::notes::Code;
use detune::program::{Dialect, Program, RotaryAxis, Settings, read};
use nalgebra::Vector3;

use super::support::{assert_ends, at, ended, settings};

/// Axes A about x and C about z.
fn of(text: &str, dialect: Dialect, turns_work: bool) -> Program {
    let axis = |letter, axis| RotaryAxis { letter, axis, turns_work, origin_mm: Vector3::zeros() };
    let rotary_axes = vec![axis(b'A', Vector3::x_axis()), axis(b'C', Vector3::z_axis())];
    let job = Settings { rotary_axes, ..settings() };
    read(ended(text, dialect).as_bytes(), dialect, &job).unwrap()
}

fn told(program: &Program, said: &str) -> Vec<(Code, usize)> {
    let notes = program.warnings.iter().filter(|note| note.what.contains(said));
    notes.map(|note| (note.code, at(note))).collect()
}

/// By A90, (x, y, z) of the text is (x, z, -y) of the work.
#[test]
fn another_length_compensation_ends_tool_centre_point_control() {
    for end in ["G43 H1", "G44 H1", "G43.1 H1", "G49"] {
        let text = format!("G0 X10 Y0 Z50 A90\nG43.4 H1\n{end}\nG1 Z60 F300");
        let program = of(&text, Dialect::GCode, true);
        assert_ends(&program, &[('L', [10.0, 50.0, 0.0]), ('L', [10.0, 60.0, 0.0])]);
    }
    let still_on = of("G0 X10 Y0 Z50 A90\nG43.4 H1\nG1 Z60 F300", Dialect::GCode, true);
    assert_ends(&still_on, &[('L', [10.0, 50.0, 0.0]), ('L', [10.0, 50.0, 60.0])]);
}

/// F is a feed of the tip, which does not move.
#[test]
fn a_turn_at_feed_while_the_tip_stays_is_a_doubt() {
    for (control, dialect) in [("TRAORI", Dialect::Sinumerik), ("G43.4 H1", Dialect::GCode)] {
        for (block, lines) in [
            ("G1 A30 F200", vec![(Code::MotionLeftOut, 3)]),
            ("G1 X0 A30 F200", vec![(Code::MotionLeftOut, 3)]),
            ("G1 X0.001 A170 F200", vec![(Code::MotionLeftOut, 3)]),
            ("G1 A9 F200", vec![]),
            ("G1 X5 A30 F200", vec![]),
            ("G0 A30", vec![]),
        ] {
            let program = of(&format!("G0 X0 Y0 Z5 A0\n{control}\n{block}"), dialect, false);
            assert_eq!(told(&program, "while the tool tip stays"), lines, "{control} {block}");
        }
    }
}

/// The time of a turn does not depend on how many blocks it stands in.
#[test]
fn small_turns_on_end_while_the_tip_stays_add_up() {
    let said = "while the tool tip stays";
    for (control, dialect) in [("TRAORI", Dialect::Sinumerik), ("G43.4 H1", Dialect::GCode)] {
        for (blocks, lines) in [
            ("G1 A3 F200\nA6\nA9\nA12\nA15", vec![(Code::MotionLeftOut, 6)]),
            ("G1 A5 F200\nA0\nA5", vec![(Code::MotionLeftOut, 5)]),
            ("G1 X0.004 A6 F200\nX0.008 A12", vec![(Code::MotionLeftOut, 4)]),
            ("G1 A3 F200\nA6\nA9\nX5 A12\nA15\nA18\nA21", vec![]),
            ("G1 A6 F200\nG0 A12\nG1 A18", vec![(Code::MotionLeftOut, 5)]),
            ("G1 A6 F200\nG0 X0\nG1 A12", vec![(Code::MotionLeftOut, 5)]),
            ("G1 A6 F200\nG0 X5\nG1 A12", vec![]),
        ] {
            let program = of(&format!("G0 X0 Y0 Z5 A0\n{control}\n{blocks}"), dialect, false);
            assert_eq!(told(&program, said), lines, "{control} {blocks}");
        }
    }
    // By directions: to 4.6°, 9.1° and 13.5°.
    let by_vectors = "G0 X0 Y0 Z5\nTRAORI\nG1 F200\nX0 A3=0.08 C3=1\nX0 A3=0.16 C3=1\n\
                      X0 A3=0.24 C3=1";
    let program = of(by_vectors, Dialect::Sinumerik, false);
    assert_eq!(told(&program, said), [(Code::MotionLeftOut, 6)]);
}

#[test]
fn cuts_with_a_tilted_tool_may_be_of_its_axis() {
    let said = "places of the axis and not of the tool tip";
    let start = "G0 X0 Y0 Z5";
    for (text, turns_work, lines) in [
        (format!("{start} A30\nG1 X10 F200\nX20"), false, vec![(Code::UnitAssumed, 2)]),
        (format!("{start} A30\nG0 X10\nG0 A0\nG1 X20 F200"), false, vec![]),
        (format!("{start} A30\nG43.4 H1\nG1 X10 F200"), false, vec![]),
        // About itself the tool may turn, and whole turns are none.
        (format!("{start} C90\nG1 X10 F200"), false, vec![]),
        (format!("{start} A360\nG1 X10 F200"), false, vec![]),
        (format!("{start} A30\nG1 X10 F200"), true, vec![]),
    ] {
        let program = of(&text, Dialect::GCode, turns_work);
        assert_eq!(told(&program, said), lines, "{text}");
    }
    let behind = format!("{start}\nTRAORI\nG0 A30\nG1 X10 F200\nTRAFOOF\nG1 X20");
    let behind = of(&behind, Dialect::Sinumerik, false);
    assert_eq!(told(&behind, said), [(Code::UnitAssumed, 6)]);
}

/// About (5, 0), from (0, 0): to points of the circle that rounding to 0.001 mm makes the same.
#[test]
fn an_arc_below_the_resolution_of_controls_may_be_a_circle() {
    for (arc, lines) in [
        ("G3 X0 Y-0.0003 I5", vec![(Code::MotionLeftOut, 2)]),
        ("G2 X0 Y0.0003 I5", vec![(Code::MotionLeftOut, 2)]),
        ("G2 X0 Y-0.0003 I5", vec![]),
        ("G3 X0 Y0 I5", vec![]),
        ("G3 X0 Y-0.002 I5", vec![]),
        ("G3 X0 Y-0.0003 R5", vec![]),
    ] {
        let program = of(&format!("G0 X0 Y0 Z0\n{arc} F200"), Dialect::GCode, false);
        assert_eq!(told(&program, "controls that round places"), lines, "{arc}");
    }
    let text = "BEGIN PGM A MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+0 FMAX M3\nCC X+5 Y+0\n\
                C X+0 Y-0.0003 DR+ F200\nEND PGM A MM\n";
    let program = read(text.as_bytes(), Dialect::Heidenhain, &settings()).unwrap();
    assert_eq!(told(&program, "controls that round places"), [(Code::MotionLeftOut, 5)]);
}

/// H of a call is an argument, and beside G41 the number of a radius.
#[test]
fn h_is_a_length_where_it_stands_for_one() {
    let start = "G0 X0 Y0\nG43 H1 Z5";
    for (block, lines) in [
        ("G1 X10 H2 F200", vec![(Code::ChangeIgnored, 3)]),
        ("G41 H2 G1 X10 F200", vec![]),
        ("M98 P2 H2", vec![]),
        ("G65 P2 H2", vec![]),
    ] {
        let text = format!("{start}\n{block}\nM30\nO2\nG1 X9 F200\nM99");
        let program = of(&format!("T1 M6\n{text}").replacen("\n", " ", 1), Dialect::GCode, false);
        assert_eq!(told(&program, "the tcp stays the same"), lines, "{block}");
    }
}
