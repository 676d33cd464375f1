//! G-code: modes, arcs, cycles, units.

use detune::motion::{Target, Timing};
use detune::notes::Code;
use detune::program::{
    Assumed, Dialect, Program, RotaryAxis, Settings, Spindle, SpindleCommand, read,
};
use nalgebra::Vector3;

use super::support::{assert_ends, assert_pose, at, end, ended, faults, lines, pose, settings};

const POCKET: &[u8] = include_bytes!("../../data/programs/pocket.ngc");

fn gcode(text: &str) -> Program {
    read(ended(text, Dialect::GCode).as_bytes(), Dialect::GCode, &settings()).unwrap()
}

#[test]
fn pocket_with_arcs_and_holes() {
    let program = read(POCKET, Dialect::GCode, &settings()).unwrap();
    assert_ends(
        &program,
        &[
            ('L', [0.0, 0.0, 50.0]),
            ('L', [0.0, 0.0, 2.0]),
            ('L', [0.0, 0.0, -2.0]),
            ('L', [40.0, 0.0, -2.0]),
            ('A', [50.0, 10.0, -2.0]),
            ('L', [50.0, 30.0, -2.0]),
            ('A', [30.0, 30.0, -2.0]),
            ('A', [50.0, 30.0, -2.0]),
            ('L', [40.0, 25.0, -2.0]),
            ('L', [40.0, 25.0, 10.0]),
            // G81 with G98: over the hole at 10, to R, to the bottom, R, back to 10.
            ('L', [0.0, 0.0, 10.0]),
            ('L', [0.0, 0.0, 1.0]),
            ('L', [0.0, 0.0, -5.0]),
            ('L', [0.0, 0.0, 1.0]),
            ('L', [0.0, 0.0, 10.0]),
            ('L', [20.0, 0.0, 10.0]),
            ('L', [20.0, 0.0, 1.0]),
            ('L', [20.0, 0.0, -5.0]),
            ('L', [20.0, 0.0, 1.0]),
            ('L', [20.0, 0.0, 10.0]),
            // G83 with G99: two steps of 3 from R = 1 to −5.
            ('L', [40.0, 0.0, 10.0]),
            ('L', [40.0, 0.0, 1.0]),
            ('L', [40.0, 0.0, -2.0]),
            ('L', [40.0, 0.0, 1.0]),
            // 0.254 mm over the last depth.
            ('L', [40.0, 0.0, -1.746]),
            ('L', [40.0, 0.0, -5.0]),
            ('L', [40.0, 0.0, 1.0]),
            ('L', [25.4, 0.0, 1.0]),
        ],
    );
    assert_eq!(
        lines(&program),
        [
            7, 8, 9, 10, 11, 12, 13, 13, 14, 15, 17, 17, 17, 17, 17, 18, 18, 18, 18, 18, 19, 19,
            19, 19, 19, 19, 19, 21
        ]
    );
    let feeds: Vec<f64> = program.moves.iter().map(|each| each.feed_m_per_s * 6e4).collect();
    let expected = [
        30e3, 30e3, 200.0, 600.0, 600.0, 600.0, 600.0, 600.0, 600.0, 30e3, 30e3, 30e3, 100.0, 30e3,
        30e3, 30e3, 30e3, 100.0, 30e3, 30e3, 30e3, 30e3, 100.0, 30e3, 30e3, 100.0, 30e3, 254.0,
    ];
    for (found, expected) in feeds.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{feeds:?}");
    }
    assert_eq!(
        program.spindle,
        [
            SpindleCommand { line: 5, spindle: Spindle::Turns(Some(8000.0)), from_move: 0 },
            SpindleCommand { line: 16, spindle: Spindle::Turns(Some(12000.0)), from_move: 10 },
            SpindleCommand { line: 22, spindle: Spindle::Stands, from_move: 28 },
        ]
    );
    let told: Vec<usize> = program.warnings.iter().map(at).collect();
    // Behind M30 stands a move that does not run.
    assert_eq!(told, [8, 19, 23, 25], "{:?}", program.warnings);
    // See the feeds above.
    assert!(program.warnings[0].what.starts_with("15 rapid moves"), "{:?}", program.warnings);
    // The tool looks down with x along the work object's x.
    for each in &program.moves {
        let turned = pose([0.0; 3], [0.0, 1.0, 0.0, 0.0]).rotation;
        assert!(end(each).1.rotation.angle_to(&turned) < 1e-12);
    }
}

fn via(program: &Program, index: usize) -> [f64; 3] {
    let Target::Arc { via, .. } = &program.moves[index].to else { panic!("no arc") };
    let at = via.translation.vector * 1e3;
    [at.x, at.y, at.z]
}

fn near(found: [f64; 3], expected: [f64; 3]) -> bool {
    found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-6)
}

#[test]
fn arcs_bend_the_right_way_in_all_three_planes() {
    // Each from (0, 0, 0) by a quarter of radius 10; seen from the plane's third axis G2 is clockwise.
    let half = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    let low = 10.0 - half;
    for (block, expected) in [
        ("G17 G2 X10 Y10 I10 J0", [low, half, 0.0]),
        ("G17 G3 X10 Y10 I0 J10", [half, low, 0.0]),
        ("G17 G2 X10 Y10 R10", [low, half, 0.0]),
        ("G17 G3 X10 Y10 R10", [half, low, 0.0]),
        // In ZX, z is the first axis and x the second: clockwise starts along x.
        ("G18 G2 X10 Z10 K10 I0", [half, 0.0, low]),
        ("G18 G3 X10 Z10 K0 I10", [low, 0.0, half]),
        ("G19 G2 Y10 Z10 J10 K0", [0.0, low, half]),
        ("G19 G3 Y10 Z10 J0 K10", [0.0, half, low]),
        ("G90.1 G17 G3 X10 Y10 I0 J10", [half, low, 0.0]),
        ("G91 G17 G3 X10 Y10 J10", [half, low, 0.0]),
    ] {
        let program = gcode(&format!("G0 X0 Y0 Z0\n{block} F100"));
        assert_eq!(program.moves.len(), 2, "{block}");
        assert!(near(via(&program, 1), expected), "{block}: {:?}", via(&program, 1));
    }
}

#[test]
fn a_helix_climbs_evenly_and_stays_on_its_cylinder() {
    let program = gcode("G0 X10 Y0 Z0\nG2 X10 Y0 Z-3 I-10 P2 F100");
    let count = program.moves.len() - 1;
    assert!(count > 4, "{count}");
    for index in 1..=count {
        let [x, y, z] = via(&program, index);
        let turn = (index as f64 - 0.5) / count as f64;
        let angle = -2.0 * std::f64::consts::TAU * turn;
        assert!(near([x, y, z], [10.0 * angle.cos(), 10.0 * angle.sin(), -3.0 * turn]));
    }
    assert_pose(&end(&program.moves[count]).1, &pose([10.0, 0.0, -3.0], [0.0, 1.0, 0.0, 0.0]));
}

#[test]
fn the_path_starts_where_all_three_axes_are_known() {
    let program = gcode("G21 G0 Z5\nG0 X1\nG0 Y2\nG1 X3");
    assert_eq!(lines(&program), [3, 4]);
    assert_ends(&program, &[('L', [1.0, 2.0, 5.0]), ('L', [3.0, 2.0, 5.0])]);
    assert!(program.warnings.is_empty(), "{:?}", program.warnings);
    // No F: the job's feed.
    assert_eq!(program.moves[1].feed_m_per_s, 0.01);
}

/// F counts in the old unit or in the new one.
#[test]
fn a_feed_beside_a_change_of_units_is_refused() {
    for block in ["G1 X2 F100 G20", "G20 G1 X2 F100", "X2 G20 F10 G1"] {
        let found = faults(&format!("G21 G90\nG0 X0 Y0 Z0\n{block}"), Dialect::GCode);
        assert_eq!(at(&found[0]), 3, "{block}");
        assert!(found[0].what.contains("change of units"), "{block}: {found:?}");
    }
    // The first unit is no change.
    let program = gcode("G20 G90 F10\nG0 X0 Y0 Z0\nG1 X1");
    assert!((program.moves[1].feed_m_per_s * 6e4 - 254.0).abs() < 1e-9);
}

#[test]
fn relative_holes_repeat() {
    let program = gcode("G0 X0 Y0 Z10\nG91 G99 G81 X5 Z-4 R-8 L2 F60");
    assert_ends(
        &program,
        &[
            ('L', [0.0, 0.0, 10.0]),
            ('L', [5.0, 0.0, 10.0]),
            ('L', [5.0, 0.0, 2.0]),
            ('L', [5.0, 0.0, -2.0]),
            ('L', [5.0, 0.0, 2.0]),
            ('L', [10.0, 0.0, 2.0]),
            ('L', [10.0, 0.0, -2.0]),
            ('L', [10.0, 0.0, 2.0]),
        ],
    );
}

#[test]
fn feed_per_revolution_and_the_way_to_the_reference() {
    let program = gcode("G0 X0 Y0 Z0\nS3000 M3\nG95 G1 X10 F0.1\nG94 G1 Z0.5\nG4 P2.\nG28 Z20");
    assert_ends(
        &program,
        &[
            ('L', [0.0; 3]),
            ('L', [10.0, 0.0, 0.0]),
            ('L', [10.0, 0.0, 0.5]),
            // The dwell.
            ('T', [10.0, 0.0, 0.5]),
            ('L', [10.0, 0.0, 20.0]),
        ],
    );
    assert_eq!(program.moves[3].timing, Timing::Seconds(2.0));
    assert!((program.moves[1].feed_m_per_s - 0.3 / 60.0).abs() < 1e-15);
    assert_eq!(program.moves[2].feed_m_per_s, 0.01);
}

#[test]
fn what_is_lost_or_computed_is_refused_with_its_line() {
    for (block, said) in [
        ("G1 X#100", "#100 is read"),
        ("G1 X#<depth>", "#<depth> is read"),
        ("G1 X[1/0]", "division by zero"),
        ("o100 call", "O<100> is not in this file"),
        ("o100 leap", "'LEAP' is not understood"),
        ("G10 L2 P1 X5", "moves the work offset"),
        ("G10 L7 X5", "G10 is understood"),
        ("IF #1 EQ 1 GOTO 5", "a condition must stand in [ ]"),
        ("GOTO 5", "there is no N5"),
        ("WHILE [1 EQ 1]", "WHILE without DO"),
        ("G68.2 R30", "G68.2 is not understood"),
        ("G5.1 X1 Y2", "G5.1 is not understood"),
        ("M98 P1000", "O1000 is not in this file"),
        ("G1 X1 A30", "axis A moves"),
        ("G93 G1 X5", "inverse time"),
        ("G1 X5,R2", "must lie between two lines"),
        ("ROT Z5", "ROT shifts"),
        ("CYCLE800(0,\"\",0,57,0,0,0,0,45,0)", "CYCLE800 shifts"),
        ("G1 X1 F0", "F is 0"),
        ("G1 X1.2.3", "X has no number"),
        ("G2 X5 Y5", "without centre or radius"),
        ("G2 X5 Y5 I1 J0", "from the arc's centre"),
        ("G2 X50 Y0 R3", "too small"),
        ("G81 X1 Z-1", "no R"),
        ("G81 X1 R-2 Z-1", "lies above R"),
        ("G83 X1 R2 Z-1", "no Q"),
        ("G83 X1 R2 Z-1 Q0", "Q is 0 mm"),
        ("G87 X1 R2 Z-1", "G87 is not"),
        ("G18 G81 X1 R2 Z-1", "no Y"),
        ("G20 G1 X1 F9", "change of units"),
        ("G95 G1 X5 F0.1", "speed is not known"),
        ("G1 X5 (open", "not closed"),
        ("G1 X60 X90", "two X words"),
        ("X1 F100 F900", "two F words"),
        ("G0 G1 X5", "G0 and G1 in one block"),
        ("G1 G81 X5 R2 Z-1", "G1 and G81 in one block"),
        ("G81 G80 X5 R2 Z-1", "G80 and G81 in one block"),
        ("G90 G91 X5", "G90 and G91 in one block"),
        ("G17 G18 X5", "G17 and G18 in one block"),
        ("G20 G21 X5", "G20 and G21 in one block"),
        ("G4 P1. G28 Z5", "G4 and G28 in one block"),
        ("M3 M5", "M3 and M5 in one block"),
    ] {
        let text = format!("G0 X0 Y0 Z0 F5\r\n\r\n{block}\r\n");
        let found = faults(&text, Dialect::GCode);
        assert_eq!(found.len(), 1, "{block}: {found:?}");
        assert_eq!(at(&found[0]), 3, "{block}");
        assert!(found[0].what.contains(said), "{block}: {}", found[0].what);
    }
    let huge = format!("G20 G0 X0 Y0 Z{}", "9".repeat(308));
    assert!(faults(&huge, Dialect::GCode)[0].what.contains("too large"));
    assert!(faults("G91 G1 X5", Dialect::GCode)[0].what.contains("relative (G91)"));
    let arc = faults("G0 Z5\nG2 X1 Y1 R3", Dialect::GCode);
    assert!(arc[0].what.contains("while X and Y are not known; state X, Y and Z"), "{arc:?}");
}

#[test]
fn moves_know_whether_the_spindle_turns() {
    // Before the first command nothing is known, so it is taken to turn; S0 stops it as M5 does.
    let text = "G0 X0 Y0 Z0\nX1\nS1100 M3\nG1 X2 F100\nM5\nG0 Z9\nX3\nM3\nG1 X4\nS0\nX5\nM30\n";
    let turns: Vec<bool> = gcode(text).moves.iter().map(|each| each.spindle_turns).collect();
    assert_eq!(turns, [true, true, true, false, false, true, false]);
}

/// A stop as a safety line, and a start that leaves the speed to the cell: the spindle turns.
#[test]
fn a_start_without_a_speed_ends_a_stop() {
    for start in ["M3", "M4", "M13", "M14", "M3 S1100", "S1100 M4"] {
        let program = gcode(&format!("M5\nG0 X0 Y0 Z0\nX1\n{start}\nG1 X2 F100\nX3\n"));
        let turns: Vec<bool> = program.moves.iter().map(|each| each.spindle_turns).collect();
        assert_eq!(turns, [false, false, true, true], "{start}");
    }
    // In the block of a move it stops before it or behind it, as the controller has it.
    let program = gcode("S900 M3\nG0 X0 Y0 Z0\nG1 X2 F100 M5\nX3\n");
    let turns: Vec<bool> = program.moves.iter().map(|each| each.spindle_turns).collect();
    assert_eq!(turns, [true, true, false]);
    let program = gcode("M5\nG0 X0 Y0 Z0\nM3\nG1 X2 F100\n");
    assert_eq!(
        program.spindle,
        [
            SpindleCommand { line: 1, spindle: Spindle::Stands, from_move: 0 },
            SpindleCommand { line: 3, spindle: Spindle::Turns(None), from_move: 1 },
        ]
    );
}

/// The heads that posts write: codes of different groups, a cycle cancelled beside a motion, a code said twice.
#[test]
fn codes_that_go_together_are_read_together() {
    for head in ["G0 G17 G40 G49 G80 G90 G94", "G80 G0", "G0 G80", "G0 G0 G90 G90"] {
        let program = gcode(&format!("{head}\nX0 Y0 Z5\nX1 M8 M9\n"));
        assert_ends(&program, &[('L', [0.0, 0.0, 5.0]), ('L', [1.0, 0.0, 5.0])]);
    }
}

/// Where the reference and the machine's zero are is not in the program. Before the first place that is known
/// and behind the last nothing is lost but the way there; in between the way is wrong.
#[test]
fn ways_to_the_machine_s_own_places_are_refused_between_moves() {
    let away = ["G53 G0 Z0", "G0 G53 X0 Y0", "G91 G28 Z0\nG90", "G30 Z0", "G28"];
    for way in away {
        let found = faults(&format!("G0 X0 Y0 Z5\n{way}\nG1 X5 Y0 Z0 F100\nX6\n"), Dialect::GCode);
        assert_eq!((at(&found[0]), found.len()), (2, 1), "{way}: {found:?}");
        assert!(found[0].what.contains("split the program"), "{way}: {}", found[0].what);

        let program = gcode(&format!("G21 {way}\nG1 X5 Y0 Z0 F100\nX6\n{way}\nM30\n"));
        assert_ends(&program, &[('L', [5.0, 0.0, 0.0]), ('L', [6.0, 0.0, 0.0])]);
        assert_eq!(at(&program.warnings[0]), 1, "{way}: {:?}", program.warnings);
    }
    // Behind the retract the height is not known, so this is no move through the part.
    let program = gcode("G21 G0 X0 Y0 Z5\nG1 Z0 F100\nG53 G0 Z0\nX9 Y9\nM30\n");
    assert_ends(&program, &[('L', [0.0, 0.0, 5.0]), ('L', [0.0, 0.0, 0.0])]);
    let told: Vec<usize> = program.warnings.iter().map(at).collect();
    assert_eq!(told, [3], "{:?}", program.warnings);
    // What is known of x is no longer so.
    let program = gcode("G0 X1 Y2\nG53 X0\nZ5\nX3\n");
    assert_ends(&program, &[('L', [3.0, 2.0, 5.0])]);
}

/// The speeds and the ends of the moves of a program.
fn cut(text: &str) -> Vec<(f64, [f64; 3])> {
    let program = gcode(&format!("G21 G90 G94\nM3 S3000\nG0 X0 Y0 Z0\n{text}"));
    let mut rpm = 0.0;
    let of = |each: &detune::motion::Move| {
        if let Some(Spindle::Turns(Some(told))) = each.stated.spindle {
            rpm = told;
        }
        let mm = end(each).1.translation.vector * 1000.0;
        (rpm, [mm.x, mm.y, mm.z].map(f64::round))
    };
    program.moves.iter().map(of).skip(1).collect()
}

/// Fanuc: M99 P jumps, from a subprogram into the program that called it.
#[test]
fn m99_with_p_jumps() {
    let jumps = cut("G1 X100 F600\nM99 P50\nG1 X0\nM30\nN50 S3600\nG1 Y50\nM30");
    assert_eq!(jumps, [(3000.0, [100.0, 0.0, 0.0]), (3600.0, [100.0, 50.0, 0.0])]);
    let back = cut(
        "G1 X100 F600\nM98 P2 L3\nG1 X0\nN50 G1 Y50\nM30\nO2\nG1 X110\nM99 P50\nN50 G1 X0\nM99",
    );
    let ends: Vec<[f64; 3]> = back.iter().map(|one| one.1).collect();
    assert_eq!(ends, [[100.0, 0.0, 0.0], [110.0, 0.0, 0.0], [110.0, 50.0, 0.0]]);
    for text in ["G1 X100 F600\nM99", "N5 G1 X100 F600\nM99 P5"] {
        let program = gcode(&format!("G21 G90 G94\nM3 S3000\nG0 X0 Y0 Z0\n{text}"));
        assert_eq!(program.moves.len(), 2, "{text}");
        let [note] = &program.warnings[..] else { panic!("{:?}", program.warnings) };
        assert!(note.what.contains("read once"), "{note}");
    }
}

/// GOTO seeks in its own program, forward first.
#[test]
fn goto_stays_in_its_program() {
    let sub = "O2\n#1=1\nIF [#1 EQ 1] GOTO 10\nG1 X100\nN10 S3600\nG1 X50\nM99";
    let found = cut(&format!("G1 X10 F600\nM98 P2\nN10 G1 Y40\nM30\n{sub}"));
    let expected =
        [(3000.0, [10.0, 0.0, 0.0]), (3600.0, [50.0, 0.0, 0.0]), (3600.0, [50.0, 40.0, 0.0])];
    assert_eq!(found, expected);
}

/// A speed, or a limit of it: controllers differ.
#[test]
fn a_speed_beside_g92_or_g50_is_refused() {
    for code in ["G92", "G50"] {
        let found = faults(&format!("{code} S3000\nG0 X0 Y0 Z0"), Dialect::GCode);
        assert!(found[0].what.contains("or its limit"), "{code}: {found:?}");
    }
}

/// The end of a cut completes the place: what it cuts on the way is not on the path.
#[test]
fn a_first_cut_from_an_unknown_height_is_a_doubt() {
    let told = |text: &str, dialect: Dialect| {
        let text = ended(text, dialect);
        let program = read(text.as_bytes(), dialect, &settings()).unwrap();
        let starts = |note: &&detune::notes::Note| {
            note.what.contains("a move at feed from where ") && note.what.contains(" not known")
        };
        program.warnings.iter().filter(starts).map(at).collect::<Vec<usize>>()
    };
    let plunge = "S3000 M3\nG0 X0 Y0\nG1 Z-20 F50\nG0 Z5\n";
    assert_eq!(told(plunge, Dialect::GCode), [3]);
    let sideways = "S3000 M3\nG0 X0 Z-2\nG1 Y20 F50\nG0 Z5\n";
    assert_eq!(told(sideways, Dialect::GCode), [3]);
    // The same in one block. Nothing is cut at rapid, or with the spindle stopped.
    let whole = "S3000 M3\nG1 X0 Y0 Z-20 F50\nG0 Z5\n";
    assert_eq!(told(whole, Dialect::GCode), [2]);
    assert_eq!(told(whole, Dialect::Sinumerik), [2]);
    assert!(told(&whole.replace("G1", "G0"), Dialect::GCode).is_empty());
    assert!(told(&plunge.replace("G1 Z", "G0 Z"), Dialect::GCode).is_empty());
    assert!(told(&plunge.replace("S3000 M3", "M5"), Dialect::GCode).is_empty());
    // A change of tool stops it, up to the start that follows, if one does.
    let changed = "T1 M6\nG1 X0 Y0 Z50 F9000\nS3000 M3\nG1 Z-2 F50\n";
    assert!(told(changed, Dialect::GCode).is_empty());
    for start in ["S3000", "M5\nS3000 M3", "T2 M6\nS3000 M3"] {
        assert_eq!(told(&changed.replace("S3000 M3", start), Dialect::GCode), [2], "{start}");
    }
    assert_eq!(told(&changed.replace("M6", "M6 M3"), Dialect::GCode), [2]);
    let heidenhain = "BEGIN PGM A MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 R0 FMAX M3\nL Z-20 F50\n\
                      L Z+5 FMAX\nEND PGM A MM\n";
    assert_eq!(told(heidenhain, Dialect::Heidenhain).len(), 1);
}

/// R is a place, and with G99 the tool goes back there: no height before the cycle is needed.
#[test]
fn a_cycle_with_g99_needs_no_height_before_it() {
    let text = |cycle: &str| {
        format!("G21 G90 G17\nT1 M6\nG0 X5 Y6 S900 M3\n{cycle} Z-5 R2 F100\nX30\nG80")
    };
    let hole = |x: f64| [2.0, -5.0, 2.0].map(|z| ('L', [x, 20.0, z]));
    let program = gcode(&text("G99 G81 X10 Y20"));
    assert_ends(&program, &[hole(10.0), hole(30.0)].concat());
    let told = program.warnings.iter().map(|note| note.code);
    assert!(told.eq([Code::Assumed]), "{:?}", program.warnings);
    let refused = |text: &str, line: usize, said: &str| {
        let found = faults(text, Dialect::GCode);
        assert_eq!(at(&found[0]), line, "{text}: {found:?}");
        assert!(found[0].what.contains(said), "{text}: {found:?}");
    };
    let or_g99 = "Z is not known before the cycle: program Z by a rapid move before it, or G99";
    refused(&text("G98 G81 X10 Y20"), 4, or_g99);
    refused(&text("G91 G99 G81 X10 Y20"), 4, "Z is relative (G91) to no position");
    refused(&text("G99 G81 X10 Y20").replace("X30", "G98 X30"), 5, or_g99);
    let without_x = "G21 G90 G0 Y6 Z9\nG99 G81 Y20 Z-5 R2 F100\nG80";
    refused(without_x, 2, "X is not known before the cycle: program X");
}

/// P is of the codes that dwell, and of others where it stands with them.
#[test]
fn a_dwell_of_g82_is_none_of_other_cycles() {
    let program = gcode(
        "G21 G90 G99\nG0 X0 Y0 Z2 S900 M3\nG82 Z-5 R2 P1. F100\nG83 X5 Q9.\nG73 X6\nG81 X7\n\
         G82 X8\nG83 X9 P2.\nX10\nG80",
    );
    let dwells = program.moves.iter().filter_map(|each| match each.timing {
        Timing::Seconds(seconds) => Some((each.line, seconds)),
        _ => None,
    });
    assert_eq!(dwells.collect::<Vec<_>>(), [(3, 1.0), (7, 1.0), (8, 2.0), (9, 2.0)]);
}

/// LinuxCNC: CONTINUE of a DO goes to its WHILE, BREAK behind it; loops around count on.
#[test]
fn loops_are_left_and_gone_on_with() {
    let start = "G21 G17 G90\nG0 X0 Y0 Z5 S1000 M3\nG1 F100\n#<a>=3\n";
    let run_of = |way: &str| {
        let text = format!(
            "{start}o20 do\n#<a>=[#<a>-1]\no21 if [#<a> EQ 1]\no20 {way}\no21 endif\n\
             Y[#<a>*10+1]\no20 while [#<a> GT 0]\nX7"
        );
        gcode(&text)
    };
    let place = |x: f64, y: f64| ('L', [x, y, 5.0]);
    assert_ends(
        &run_of("continue"),
        &[place(0.0, 0.0), place(0.0, 21.0), place(0.0, 1.0), place(7.0, 1.0)],
    );
    assert_ends(&run_of("break"), &[place(0.0, 0.0), place(0.0, 21.0), place(7.0, 21.0)]);
    let nested = "o1 repeat [3]\n#<a>=[#<a>+1]\no2 while [1]\no2 break\no2 endwhile\nX#<a>\n\
                  o1 endrepeat";
    let found = gcode(&format!("{start}{nested}"));
    assert_ends(&found, &[0.0, 4.0, 5.0, 6.0].map(|x| place(x, 0.0)));
    let outside = faults(&format!("{start}o3 continue"), Dialect::GCode);
    assert!(outside[0].what.contains("CONTINUE outside of a loop"), "{outside:?}");
}

/// Axes A about x and C about z, of which A carries C where they turn the work.
fn with_axes(turns_work: bool) -> Settings {
    let axis = |letter, axis| RotaryAxis { letter, axis, turns_work, origin_mm: Vector3::zeros() };
    let rotary_axes = vec![axis(b'A', Vector3::x_axis()), axis(b'C', Vector3::z_axis())];
    Settings { rotary_axes, ..settings() }
}

fn turned(text: &str) -> Program {
    read(ended(text, Dialect::GCode).as_bytes(), Dialect::GCode, &with_axes(true)).unwrap()
}

/// Which way the tool points in the work.
fn tool(program: &Program, index: usize) -> Vector3<f64> {
    end(&program.moves[index]).1.rotation * Vector3::z()
}

/// A turns the work by -90°: (x, y, z) of the text is (x, z, -y) of the work; at 180°, (x, -y, -z).
#[test]
fn rotary_axes_turn_between_the_holes_of_a_cycle() {
    let hole = |x: f64| [50.0, 2.0, -5.0, 2.0, 50.0].map(|z| ('L', [x, 0.0, z]));
    let turned_by = |by: fn(f64) -> [f64; 2]| {
        move |(way, [x, _, z]): (char, [f64; 3])| {
            let [y, z] = by(z);
            (way, [x, y, z])
        }
    };
    let (quarter, half) = (turned_by(|z| [z, 0.0]), turned_by(|z| [0.0, -z]));
    let start = "G0 X10 Y0 Z50 A0\n";
    let first = hole(10.0).to_vec();
    let expected = |second: f64, third: f64| {
        [&first[..], &hole(second).map(quarter), &hole(third).map(half)].concat()
    };
    // In blocks of positions, with a place and alone; the axis stays where it is behind G80.
    let program = turned(&format!("{start}G81 Z-5 R2 F300\nA90\nX20 A180\nG80\nG0 Z60"));
    assert_ends(&program, &[&expected(10.0, 20.0)[..], &[('L', [20.0, 0.0, -60.0])]].concat());
    assert_eq!(lines(&program)[5..], [3, 3, 3, 3, 3, 4, 4, 4, 4, 4, 6]);
    assert!((tool(&program, 0) - Vector3::new(0.0, 0.0, -1.0)).norm() < 1e-9);
    assert!((tool(&program, 5) - Vector3::new(0.0, -1.0, 0.0)).norm() < 1e-9);
    assert!((tool(&program, 9) - Vector3::new(0.0, -1.0, 0.0)).norm() < 1e-9);
    assert!((tool(&program, 14) - Vector3::new(0.0, 0.0, 1.0)).norm() < 1e-9);
    assert!(program.warnings.iter().all(|note| note.code != Code::MotionLeftOut));
    // In the block of the cycle, and by relative words in each of its repeats.
    let relative = turned(&format!(
        "{start}G81 Z-5 R2 A0 F300\nG80\nG91 G81 X5 A90 Z-7 R-48 L2\nG80\nG90 G0 Z60"
    ));
    assert_ends(&relative, &[&expected(15.0, 20.0)[..], &[('L', [20.0, 0.0, -60.0])]].concat());
    // Behind the last hole the work is turned back.
    let back = turned(&format!("{start}G81 Z-5 R2 A90 F300\nA0\nG80"));
    let holes = [hole(10.0).map(quarter), hole(10.0)].concat();
    assert_ends(&back, &[&first[..1], &holes[..]].concat());
    // The path starts over the hole.
    let begun = turned("G0 Z50\nG81 X10 Y0 Z-5 R2 A90 F300\nG80");
    assert_ends(&begun, &hole(10.0).map(quarter));
    // From below R the tool comes up before it turns.
    let low = turned("G0 X10 Y0 Z1\nG81 Z-5 R2 A90 F300\nG80");
    let up = [('L', [10.0, 0.0, 1.0]), ('L', [10.0, 0.0, 2.0])];
    let turned_hole = [2.0, -5.0, 2.0].map(|y| ('L', [10.0, y, 0.0]));
    assert_ends(&low, &[&up[..], &turned_hole[..]].concat());
    // More than half a turn may be either way round.
    let far = turned(&format!("{start}G81 Z-5 R2 F300\nA200\nG80"));
    let doubts = far.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
    assert_eq!(doubts.map(at).collect::<Vec<_>>(), [3]);
}

/// Under tool centre point control X, Y and Z are in the turned work and the tool tips as without it.
#[test]
fn places_are_in_the_turned_work_under_tool_centre_point_control() {
    let moves = "G1 X20 Y5 Z50 A-90 C90 F300\nG1 X30 Z40\n";
    let start = "G0 X10 Y0 Z50 A0 C0\n";
    let places = [[10.0, 0.0, 50.0], [20.0, 5.0, 50.0], [30.0, 5.0, 40.0]].map(|at| ('L', at));
    let of = |text: &str, dialect| {
        let text = ended(text, dialect);
        read(text.as_bytes(), dialect, &with_axes(true)).unwrap()
    };
    let plain = of(&format!("{start}{moves}"), Dialect::GCode);
    // By hand: A takes (x, y, z) to (x, -z, y) of the work, then C to (-z, -x, y).
    assert_ends(&plain, &[places[0], ('L', [-50.0, -20.0, 5.0]), ('L', [-40.0, -30.0, 5.0])]);
    let controlled = of(&format!("{start}G43.4 H1\n{moves}"), Dialect::GCode);
    let siemens = of(&format!("{start}TRAORI\n{moves}"), Dialect::Sinumerik);
    for program in [&controlled, &siemens] {
        assert_ends(program, &places);
        for index in 0..3 {
            assert!((tool(program, index) - tool(&plain, index)).norm() < 1e-9, "{index}");
        }
        assert!(program.warnings.iter().all(|note| note.code != Code::MotionLeftOut));
    }
    // A parameter of Fanuc's may have it otherwise.
    let doubts = |program: &Program| {
        let all = program.warnings.iter().filter(|note| note.what.contains("19696"));
        all.map(at).collect::<Vec<_>>()
    };
    assert_eq!((doubts(&controlled), doubts(&siemens)), (vec![3], vec![]));
    // On turned work the tool has other coordinates than before, and stays where it is.
    let switched = "G0 X10 Y0 Z50 A90\nG43.4 H1\n";
    let stated = of(&format!("{switched}G0 X20 Y5 Z50\nG1 X30 F300"), Dialect::GCode);
    let [first, again, last] = [[10.0, 50.0, 0.0], [20.0, 5.0, 50.0], [30.0, 5.0, 50.0]];
    assert_ends(&stated, &[('L', first), ('L', again), ('L', last)]);
    let kept = of(&format!("{switched}G1 X20 F300"), Dialect::GCode);
    assert_ends(&kept, &[('L', first), ('L', [20.0, 50.0, 0.0])]);
    // (30, 5, 40) of the work is (-5, 40, -30) of the text, by hand as above.
    for (text, dialect) in [
        (format!("{start}G43.4 H1\n{moves}G49\nG1 X20 F300"), Dialect::GCode),
        (format!("{start}TRAORI\n{moves}TRAFOOF\nG1 X20 F300"), Dialect::Sinumerik),
    ] {
        assert_ends(&of(&text, dialect), &[&places[..], &[('L', [30.0, -20.0, 40.0])]].concat());
    }
    // Under C alone, X and Y are known without Z; under A, Y of the work is the Z of the text.
    let level = of("G0 X10 Y0 C90\nG43.4 H1 Z20\nG1 X5 F300", Dialect::GCode);
    assert_ends(&level, &[('L', [0.0, -10.0, 20.0]), ('L', [5.0, -10.0, 20.0])]);
    let found = |text: &str, dialect| {
        read(ended(text, dialect).as_bytes(), dialect, &with_axes(true)).unwrap_err()
    };
    let open = found("G0 X10 Y0 A90\nG43.4 H1\nG1 X20 F300", Dialect::GCode);
    assert!(open[0].what.contains("while Y is not known"), "{open:?}");
    // Where the work is tipped, a hole along the Z of the text would go across the tool.
    let across = found(&format!("{start}G43.4 H1\nG0 A90\nG81 Z-5 R2 F300"), Dialect::GCode);
    assert!(across[0].what.contains("across the tool"), "{across:?}");
}

#[test]
fn rotary_axes_that_no_hole_follows_are_refused() {
    let start = "G0 X10 Y0 Z50\n";
    for text in ["G81 Z-5 R2 F300\nA45", "G81 Z-5 R2 F300\nX20 A45", "G83 A45 Z-5 R2 Q1 F300"] {
        let found = faults(&format!("{start}{text}"), Dialect::GCode);
        assert!(found[0].what.contains("axis A moves"), "{text}: {found:?}");
        assert_eq!(at(&found[0]), 1 + text.lines().count());
    }
    assert_eq!(gcode(&format!("{start}G81 Z-5 R2 A0 F300\nX20 A0")).moves.len(), 10);
    let refused = |text: &str, turns_work: bool, said: &str| {
        let text = ended(&format!("{start}{text}"), Dialect::GCode);
        let found = read(text.as_bytes(), Dialect::GCode, &with_axes(turns_work)).unwrap_err();
        assert!(found[0].what.contains(said), "{text}: {found:?}");
    };
    refused("G81 Z-5 R2 A45 F300", false, "across the tool");
    refused("G0 A45\nG81 Z-5 R2 F300", false, "across the tool");
    refused("G81 Z-5 R2 A45 L0 F300", true, "L0 or K0");
    refused("G28 A0\nG81 Z-5 R2 A0 K0 F300", true, "L0 or K0");
    // Where it turns nothing, it may stand there; nothing moves, from an unknown place, too.
    for text in
        ["G0 X10 Y0 Z50\nG81 Z-5 R2 A0 K0 F300\nX20", "G0 Z50\nG81 X9 Y3 Z-5 R2 K0 F300\nX20 Y0"]
    {
        let program = turned(&format!("{text}\nG80"));
        let begun = if text.contains("X10") { vec![('L', [10.0, 0.0, 50.0])] } else { vec![] };
        let hole = [50.0, 2.0, -5.0, 2.0, 50.0].map(|z| ('L', [20.0, 0.0, z]));
        assert_ends(&program, &[&begun[..], &hole[..]].concat());
    }
}

/// Where two axes turn the work, the first of the list carries the second.
#[test]
fn places_and_tool_turn_alike_by_two_axes_of_the_work() {
    // A by 90°: (10, 50, 0); then C: (50, -10, 0).
    let program = turned("G0 X10 Y0 Z50 A90 C90\nG81 Z-5 R2 F300\nG80");
    let ends = [50.0, 2.0, -5.0, 2.0, 50.0].map(|x| ('L', [x, -10.0, 0.0]));
    assert_ends(&program, &ends);
    assert!((tool(&program, 0) - Vector3::new(-1.0, 0.0, 0.0)).norm() < 1e-9);
}

/// The reference of a rotary axis is not in the program, and another zero would be another place.
#[test]
fn a_rotary_axis_goes_to_its_reference_or_counts_anew() {
    let told = |text: &str| -> Vec<usize> {
        let program = turned(&format!("G0 X10 Y0 Z50 A90\n{text}"));
        program.warnings.iter().filter(|note| note.code == Code::AxisIgnored).map(at).collect()
    };
    assert_eq!(told("G28 A0\nG0 X10 Y0 Z50\nX20"), [3]);
    assert_eq!(told("G53 Z0 A0\nG0 Z50\nA0"), [3]);
    assert!(told("G28 A0\nG0 X10 Y0 Z50 A0\nX20").is_empty());
    // By way of (20, 60, 0), on the work as it is turned.
    let by_way = turned("G0 X10 Y0 Z50 A90\nG28 X20 Y0 Z60");
    assert_ends(&by_way, &[('L', [10.0, 50.0, 0.0]), ('L', [20.0, 60.0, 0.0])]);
    // Turns that add up to a whole one but for rounding.
    let thirds = "G91\n".to_owned() + &"G0 A0.1\n".repeat(3);
    let summed = format!("G0 X10 Y0 Z50 A359.7\n{thirds}G90\nG92 A0\nG0 X20");
    let last = turned(&summed).moves.last().map(|each| end(each).1);
    assert_pose(&last.unwrap(), &pose([20.0, 0.0, 50.0], [0.0, 1.0, 0.0, 0.0]));
    // 360° is 0°, from where the work turns by 90°.
    let unwound = turned("G0 X10 Y0 Z50 A360\nG92 A0\nG81 Z-5 R2 A90 F300\nG80");
    let hole = [50.0, 2.0, -5.0, 2.0, 50.0].map(|y| ('L', [10.0, y, 0.0]));
    assert_ends(&unwound, &[&[('L', [10.0, 0.0, 50.0])], &hole[..]].concat());
    assert!(unwound.warnings.iter().all(|note| note.code != Code::MotionLeftOut));
    for block in ["G92 A30", "G10 L20 P1 A30", "G52 A5", "G10 L2 P1 A5"] {
        let text = ended(&format!("G0 X10 Y0 Z50 A0\n{block}\nX20"), Dialect::GCode);
        let found = read(text.as_bytes(), Dialect::GCode, &with_axes(true)).unwrap_err();
        assert!(found[0].what.contains("another zero of axis A"), "{block}: {found:?}");
    }
}

/// LinuxCNC's word for the spindle: 0 is the main one, -1 are all.
#[test]
fn the_main_spindle_may_be_named() {
    for number in ["$0", "$-1"] {
        let program = gcode(&format!(
            "S1200 {number}\nM3 {number}\nG0 X0 Y0 Z5\nG1 X20 F100\nM5 {number}\nG0 X0"
        ));
        let spindle = |index: usize| program.moves[index].stated.spindle;
        assert_eq!(spindle(1), Some(Spindle::Turns(Some(1200.0))), "{number}");
        assert_eq!(spindle(2), Some(Spindle::Stands), "{number}");
    }
    for block in ["S500 $1", "M3 $1", "M19 R30 $2"] {
        let text = format!("S1200 M3\nG0 X0 Y0 Z5\n{block}\nG1 X20 F100");
        let found = faults(&text, Dialect::GCode);
        assert!(found[0].what.contains("another spindle"), "{block}: {found:?}");
    }
}

#[test]
fn what_the_job_assumes_in_vain_is_told() {
    let assume = [("#1", Assumed::Number(2.0)), ("di_1", Assumed::Truth(true))];
    let assume = assume.map(|(name, value)| (name.to_owned(), value)).into();
    let settings = Settings { assume, ..settings() };
    let text = "G0 X0 Y0 Z5\n#1=3\nX#1\nM2\n";
    let program = read(text.as_bytes(), Dialect::GCode, &settings).unwrap();
    let told = program.warnings.iter().filter(|note| note.code == Code::Unused);
    assert_eq!(told.map(at).collect::<Vec<_>>(), [2]);
}
