//! Blocks of public G-code that were read wrongly in silence, or refused though every control runs them. Expected
//! places and times are worked out by hand.

use detune::motion::Timing;
use detune::notes::{Class, Code};
use detune::program::{Dialect, DwellUnit, Program, Settings, read};

use super::support::{assert_ends, at, end, ended, faults, settings};

fn read_with(text: &str, dialect: Dialect, settings: &Settings) -> Program {
    read(ended(text, dialect).as_bytes(), dialect, settings)
        .unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

fn gcode(text: &str) -> Program {
    read_with(text, Dialect::GCode, &settings())
}

/// Lines behind a head that knows the place, G0 X0 Y0 Z5, on line 3.
fn behind_head(text: &str) -> Program {
    gcode(&format!("G21 G17 G90 G94 G54\nS3000 M3\nG0 X0 Y0 Z5\n{text}"))
}

fn seconds(program: &Program) -> f64 {
    let of = |timing: &Timing| if let Timing::Seconds(seconds) = timing { *seconds } else { 0.0 };
    program.moves.iter().map(|each| of(&each.timing)).sum()
}

fn doubts(program: &Program) -> Vec<(Code, usize)> {
    let told = program.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    told.map(|note| (note.code, at(note))).collect()
}

#[test]
fn axes_that_are_not_named_behind_a_corner_are_those_of_the_corner() {
    let expected = [
        ('L', [0.0, 0.0, 5.0]),
        ('L', [40.0, 0.0, 5.0]),
        ('L', [50.0, 10.0, 5.0]),
        ('L', [50.0, 50.0, 5.0]),
        ('L', [0.0, 50.0, 5.0]),
    ];
    assert_ends(&behind_head("G1 X50 F600 ,C10\nY50\nX0"), &expected);
    assert_ends(&behind_head("G91 G1 X50 F600 ,C10\nY50\nX-50"), &expected);
    // Two corners in a row.
    assert_ends(
        &behind_head("G1 X50 F600 ,C10\nY50 ,C10\nX0"),
        &[
            ('L', [0.0, 0.0, 5.0]),
            ('L', [40.0, 0.0, 5.0]),
            ('L', [50.0, 10.0, 5.0]),
            ('L', [50.0, 40.0, 5.0]),
            ('L', [40.0, 50.0, 5.0]),
            ('L', [0.0, 50.0, 5.0]),
        ],
    );
    for between in ["M5", "S900", "G4 P1.", "G92 X0", "M6 T1", "G43 H1"] {
        let text = format!("G0 X0 Y0 Z5\nG1 X50 F600 ,C10\n{between}\nY50");
        let found = faults(&text, Dialect::GCode);
        assert!(found[0].what.contains("corner of line 2"), "{between}: {found:?}");
    }
}

#[test]
fn where_g92_states_the_place_the_path_starts_there() {
    for set in ["G92 X0 Y0 Z0", "G10 L20 P1 X0 Y0 Z0"] {
        let program = gcode(&format!("G21 G90\n{set}\nM3 S1000\nG1 X10 F600\nG1 X20"));
        let ends = [('L', [0.0; 3]), ('L', [10.0, 0.0, 0.0]), ('L', [20.0, 0.0, 0.0])];
        assert_ends(&program, &ends);
        let arc = gcode(&format!("G21 G90\n{set}\nM3 S1000\nG2 X10 Y0 I5 J0 F600"));
        assert_ends(&arc, &[('L', [0.0; 3]), ('A', [10.0, 0.0, 0.0])]);
    }
    // Behind a way to where the program does not say, nothing says that the work has not moved.
    let behind =
        gcode("G21 G90 M3 S900\nG0 X0 Y0 Z5\nG1 Z-1 F100\nM5\nG28 Z0\nG92 Z50\nM3\nG1 Z-1");
    assert_eq!(doubts(&behind), [(Code::ChangeIgnored, 6)], "{:?}", behind.warnings);
    // The place was known: nothing moves.
    assert_ends(
        &behind_head("G92 X100\nG1 X110 F600"),
        &[('L', [0.0, 0.0, 5.0]), ('L', [10.0, 0.0, 5.0])],
    );
}

#[test]
fn a_cut_before_the_first_tool_change_is_with_a_tool_that_nobody_states() {
    let cut = "G90 G21 G0 X0 Y0 Z5 S1200 M3 T2\nG43 Z5 H1\nG1 X50 F500\n";
    let program = gcode(&format!("{cut}M6\nM3\nG0 X0"));
    assert_eq!(doubts(&program), [(Code::ChangeIgnored, 3)], "{:?}", program.warnings);
    // An M6 that no line runs loads nothing.
    let never = gcode("T1\nG90 G21 S900 M3\nG0 X0 Y0 Z5\nG1 X9 F100\nM30\nO2\nM6\nM99");
    assert_eq!(doubts(&never), [(Code::ChangeIgnored, 4)], "{:?}", never.warnings);
    // Without an M6, T itself changes; before a cut nothing is in doubt.
    assert_eq!(doubts(&gcode(cut)), []);
    assert_eq!(doubts(&gcode("G90 G21 G0 X0 Y0 Z5\nT2 M6\nS900 M3\nG1 X50 F500")), []);
}

#[test]
fn pecks_stop_short_of_the_last_depth_and_break_chips() {
    let ends = |code: &str| -> Vec<f64> {
        let program = behind_head(&format!("G98 {code} X0 Y0 Z-4 F60 Q3 R1"));
        program.moves[1..]
            .iter()
            .map(|each| (1e6 * super::support::end(each).1.translation.z).round() / 1e3)
            .collect()
    };
    // R is 1: 3 mm to −2, out, to 0.254 over it, on to −4, out.
    assert_eq!(ends("G83"), [1.0, -2.0, 1.0, -1.746, -4.0, 1.0, 5.0]);
    assert_eq!(ends("G73"), [1.0, -2.0, -1.746, -4.0, 1.0, 5.0]);
    let told = |code: &str| {
        let program = behind_head(&format!("G98 {code} X0 Y0 Z-4 F60 Q3 R1"));
        program.warnings.iter().any(|note| note.what.contains("0.254 mm"))
    };
    assert!(told("G83") && told("G73") && !told("G81"));
}

#[test]
fn cycles_without_a_dwell_do_not_dwell() {
    let all = seconds(&behind_head("G82 X10 Z-5 R2 F600 P0.6\nG81 X20\nG85 X30"));
    assert!((all - 0.6).abs() < 1e-12, "{all}");
    assert_eq!(seconds(&behind_head("G81 X10 Z-5 R2 F600 P0.6")), 0.0);
    let all = seconds(&behind_head("G89 X10 Z-5 R2 F600 P0.5\nX20"));
    assert!((all - 1.0).abs() < 1e-12, "{all}");
}

/// What a cycle was given in G90 it keeps in G91: levels that Fanuc and Haas hold.
#[test]
fn levels_of_a_cycle_stay_where_the_mode_changes() {
    let program = behind_head("G0 Z20\nG99 G81 X10 Z-5 R2 F300\nG91 X10 L2");
    let hole = |x: f64| [[x, 2.0], [x, -5.0], [x, 2.0]].map(|[x, z]| ('L', [x, 0.0, z]));
    assert_eq!(doubts(&program), [(Code::ChangeIgnored, 6)], "{:?}", program.warnings);
    let mut ends = vec![('L', [0.0, 0.0, 5.0]), ('L', [0.0, 0.0, 20.0]), ('L', [10.0, 0.0, 20.0])];
    ends.extend(hole(10.0));
    for x in [20.0, 30.0] {
        ends.extend(hole(x));
    }
    assert_ends(&program, &ends);
    // Given in G91, they count from where the cycle was called.
    let program = behind_head("G91 G99 G81 X10 Z-7 R-3 F300\nG90 X30");
    assert_eq!(doubts(&program), [(Code::ChangeIgnored, 5)], "{:?}", program.warnings);
    // In one mode nothing is in doubt.
    assert_eq!(doubts(&behind_head("G91 G98 G81 X10 Z-7 R-3 F300\nX30\nX5 R-2")), []);
    let mut ends = vec![('L', [0.0, 0.0, 5.0]), ('L', [10.0, 0.0, 5.0])];
    for x in [10.0, 30.0] {
        ends.extend(hole(x));
    }
    assert_ends(&program, &ends);
}

/// Under G91, R counts from the initial level (Fanuc) or from where the tool is (LinuxCNC).
#[test]
fn levels_under_g91_are_a_doubt_where_the_tool_is_elsewhere() {
    for (text, line) in [
        ("G91 G99 G81 X10 Z-7 R-3 F300\nX30", Some(5)),
        ("G99 G81 X10 Y10 Z-5 R2 F300\nG91 G81 X5 Z-3 R-1 L2", Some(5)),
        // R over the initial level, where the tool is left.
        ("G91 G98 G81 X10 Z-7 R3 F300\nX30", Some(5)),
        ("G91 G99 G81 X10 Z-7 R-3 L3 F300", None),
        ("G91 G99 G81 X10 Z-7 R-3 F300\nG80\nG81 X30 Z-7 R3", None),
    ] {
        let expected: Vec<_> = line.map(|line| (Code::ChangeIgnored, line)).into_iter().collect();
        assert_eq!(doubts(&behind_head(text)), expected, "{text}");
    }
}

/// The closing mark is no end of a subprogram: the rest of the program that calls it would be lost.
#[test]
fn a_subprogram_that_ends_at_the_mark_is_refused() {
    let text = "G21 G90 S900 M3\nG0 X0 Y0 Z5\nM98 P2\nG1 X50 F100\nM30\nO2\nG1 X5 F100\n";
    assert_eq!(gcode(&format!("{text}M99\n%\n")).moves.len(), 3);
    let found = faults(&format!("{text}%\n"), Dialect::GCode);
    assert!(found[0].what.contains("without M99"), "{found:?}");
    assert_eq!((at(&found[0]), found.len()), (3, 1), "{found:?}");
}

/// On Fanuc and Haas an O number begins another program, in which the one before does not go on.
#[test]
fn a_program_does_not_run_on_into_another() {
    let two = |end: &str, head: &str| {
        format!(
            "O5\nG21 G90 S900 M3\nG0 X0 Y0 Z5\nM98 P6\nG0 Z50\n{end}{head}\nG91 G1 X20 F300\nG90\nM99\n"
        )
    };
    for end in ["M30\n", "M99\n"] {
        assert_eq!(gcode(&two(end, "O6 (HOLE)")).moves.len(), 3, "{end}");
    }
    let uncalled = two("", "O6").replace("M98 P6\n", "");
    let called = two("M30\n", "O6").replace("M99\n", "O7\nG1 X9\nM99\n");
    for (text, line, head) in [
        (two("", "O6"), 6, "O6"),
        (two("", ":6"), 6, "O6"),
        (uncalled, 5, "O6"),
        (called, 10, "O7"),
    ] {
        let found = faults(&text, Dialect::GCode);
        let said = format!("{head} begins another program here");
        assert!(at(&found[0]) == line && found[0].what.starts_with(&said), "{text}: {found:?}");
        assert_eq!(found.len(), 1, "{found:?}");
    }
    // A main block of ISO, unless its number is called.
    let words = two("", ":6").replace(":6\n", ":6 ");
    let found = faults(&words, Dialect::GCode);
    assert_eq!((at(&found[0]), found.len()), (6, 1), "{found:?}");
    assert!(found[0].what.starts_with("O6 begins another program here"), "{found:?}");
    assert_eq!(gcode(&words.replace("M98 P6\n", "")).moves.len(), 3);
    assert_eq!(gcode(&words.replace(":6", "M30\n:6")).moves.len(), 3);
    for text in ["G21 G90 S900 M3\nO5\nG0 X0 Y0 Z5\nG1 X9 F100", "N1 G21\nN2 O5\nG0 X0 Y0 Z5"] {
        let found = faults(text, Dialect::GCode);
        let said = "O5 begins a program here, and blocks stand before it: write O5 before them";
        assert!(at(&found[0]) == 2 && found[0].what.starts_with(said), "{text}: {found:?}");
        assert_eq!(found.len(), 1, "{found:?}");
    }
    // The number before each block.
    let each = "O0000 N1 G21 G90 S900 M3\nO0000 N2 G0 X0 Y0 Z5\nO0000 N3 G1 X9 F100\nO0000 N4 M30";
    assert_eq!(gcode(each).moves.len(), 2);
}

/// LinuxCNC's `@` and `^`. The feed of the block that is refused is no second fault.
#[test]
fn polar_words_of_linuxcnc_are_refused_alone() {
    let text = "G20 G0 X0 Y0 Z1\nG1 @2.5^30 F60\nG1 X1\nM2\n";
    let job = Settings { feed_m_per_s: None, ..settings() };
    let found = read(text.as_bytes(), Dialect::GCode, &job).unwrap_err();
    assert_eq!((at(&found[0]), found.len()), (2, 1), "{found:?}");
    assert!(found[0].what.contains("by @ and ^"), "{found:?}");
}

#[test]
fn shifts_that_controls_differ_in_are_doubts() {
    let both = behind_head("G92 X5\nG52 X10\nG1 X0 F99");
    assert_eq!(doubts(&both), [(Code::ChangeIgnored, 5)], "{:?}", both.warnings);
    let ended = gcode("G21 G90 M3 S900\nG92 X0 Y0 Z10\nG1 X20 F99\nG92.1\nG1 X0");
    assert_eq!(doubts(&ended), [(Code::ChangeIgnored, 4)], "{:?}", ended.warnings);
    assert_eq!(doubts(&behind_head("G92 X5\nG1 X9 F99\nG92.1\nG1 X0")), []);
    // Nothing moves behind it.
    assert_eq!(doubts(&gcode("G21 G90 M3 S900\nG92 X0 Y0 Z10\nG1 X20 F99\nG92.1\nM5")), []);
}

/// Fanuc and Haas: what is printed moves nothing.
#[test]
fn output_statements_are_left_out() {
    let text = "POPEN\nDPRNT[X#1[53]*Y#[#2+1][53]] (TO THE PORT)\nBPRNT [A]\nPCLOS\nG1 X5 F100";
    let program = behind_head(text);
    assert_ends(&program, &[('L', [0.0, 0.0, 5.0]), ('L', [5.0, 0.0, 5.0])]);
    let told = program.warnings.iter().filter(|note| note.what.contains("only sends data"));
    let told: Vec<_> = told.map(|note| (note.code, at(note))).collect();
    assert_eq!(told, [4, 5, 6, 7].map(|line| (Code::LeftOut, line)));
    let cut = behind_head("PO\nDP[A]\nbp[#1] (A)\nPC (B)\nG1 X5 F100");
    assert_ends(&cut, &[('L', [0.0, 0.0, 5.0]), ('L', [5.0, 0.0, 5.0])]);
    for (text, said) in [
        ("DPRNT[X#1", "DPRNT: a bracket is not closed"),
        ("DPRNT[X#1[53] G1 X50", "a bracket is not closed"),
        ("BPRNT[[[[]", "BPRNT: a bracket is not closed"),
        ("DPRNT", "in [ ] behind it"),
        ("DPRNT(A)", "in [ ] behind it"),
    ] {
        let text = format!("G21 G90 S900 M3\nG0 X0 Y0 Z5\nG1 Z-1 F600\n{text}\nX5");
        let found = faults(&text, Dialect::GCode);
        assert!(at(&found[0]) == 4 && found[0].what.contains(said), "{text}: {found:?}");
    }
}

#[test]
fn the_axis_that_no_move_knows_is_named() {
    let calls = "BEGIN PGM A MM\nTOOL CALL 1 Z S900\nL Z+200 R0 FMAX M3\nEND PGM A MM\n";
    for (text, dialect, line, axes) in [
        ("G21 G90\nG0 X5 Y5\nX10", Dialect::GCode, 3, "Z is"),
        ("G21 G90\nG28 X0\nG0 Y5", Dialect::GCode, 3, "X and Z are"),
        ("G710 G90\nSUPA G0 Z500 D0\nG0 X5 Y5", Dialect::Sinumerik, 3, "Z is"),
        (calls, Dialect::Heidenhain, 3, "X and Y are"),
    ] {
        let found = faults(text, dialect);
        let said = format!("{axes} not known up to here");
        assert!(at(&found[0]) == line && found[0].what.starts_with(&said), "{found:?}");
        assert_eq!(found.len(), 1, "{found:?}");
    }
    // In a loop, of the first pass alone.
    for (block, axes) in [("G1 X9 F100", "Y and Z"), ("G2 X9 I3 F100", "X and Y and Z")] {
        let text = format!("G21 G90\n#1=0\nWHILE [#1 LT 3] DO1\n{block}\nG0 Y5\n#1=[#1+1]\nEND1");
        let found = faults(&text, Dialect::GCode);
        let said = format!("while {axes} are not known");
        assert!(found[0].what.contains(&said), "{found:?}");
        assert_eq!(found.iter().map(at).collect::<Vec<_>>(), [4], "{found:?}");
    }
    let lost = faults("G21 G90\nG0 X5 Y5\nG28 X5 Y5 Z5\nG0 Z5", Dialect::GCode);
    assert!(lost[0].what.contains("up to here (G28/G30 in line 3 goes"), "{lost:?}");
}

#[test]
fn a_dwell_by_x_or_u_is_in_the_unit_of_p() {
    let in_ms = Settings { dwell_unit: Some(DwellUnit::Milliseconds), ..settings() };
    for time in ["P#1", "P[1500.]"] {
        let text = format!("G21 G90\n#1=1500\nG0 X0 Y0 Z5\nG4 {time}\nG1 X9 F600");
        let program = read_with(&text, Dialect::GCode, &settings());
        assert!((seconds(&program) - 1.5).abs() < 1e-12, "{time}");
        assert!(program.warnings.iter().any(|note| note.what.starts_with("P1500 of a dwell")));
    }
    for time in ["X1500", "U1500", "P1500"] {
        let text = format!("G21 G90\nG0 X0 Y0 Z5\nG4 {time}\nG1 X9 F600");
        let program = read_with(&text, Dialect::GCode, &in_ms);
        assert!((seconds(&program) - 1.5).abs() < 1e-12, "{time}");
        let assumed = read_with(&text, Dialect::GCode, &settings());
        assert!(
            assumed
                .warnings
                .iter()
                .any(|note| note.what.starts_with(&format!("{time} of a dwell")))
        );
    }
    assert!((seconds(&behind_head("G4 X1.5\nG1 X9 F600")) - 1.5).abs() < 1e-12);
}

#[test]
fn what_controls_read_differently_is_refused() {
    for (block, said) in [
        ("#1=[4 OR 1]", "4 OR 1"),
        ("#1=[6 AND 3]", "6 AND 3"),
        ("G1 X50 F600 R10", "beside G0 or G1"),
        ("G1 X50 F600 K2", "beside G0 or G1"),
        ("G10 L20 P2 X0 Y0 Z0", "another offset"),
        ("G10 L2 P1 R45", "turns the work"),
        ("#0=1", "#0 cannot be set"),
        ("G2 X20 Y20 I20 J0 F99 ,R3", "end of an arc"),
        ("G1 X40 F99 ,R5\nZ-5", "does not lie in the plane"),
        ("G1 X5 F600\nG81 X9 Z-2 R1 F90\nG80\nX20", "axes without"),
    ] {
        let found = faults(&format!("G21 G90\nG0 X0 Y0 Z5\n{block}"), Dialect::GCode);
        assert!(found[0].what.contains(said), "{block}: {found:?}");
    }
    // Conditions are 0 or 1 to both.
    assert_ends(
        &behind_head("#1=[[2 GT 1] AND [1 LT 3]]\nG0 X#1"),
        &[('L', [0.0, 0.0, 5.0]), ('L', [1.0, 0.0, 5.0])],
    );
}

#[test]
fn behind_g80_the_rapid_of_before_holds() {
    let hole = [
        ('L', [0.0, 0.0, 5.0]),
        ('L', [9.0, 0.0, 5.0]),
        ('L', [9.0, 0.0, 1.0]),
        ('L', [9.0, 0.0, -2.0]),
        ('L', [9.0, 0.0, 1.0]),
        ('L', [9.0, 0.0, 5.0]),
        ('L', [9.0, 0.0, 15.0]),
    ];
    for end in ["G80\nZ15.", "G80 Z15."] {
        let program = behind_head(&format!("G98 G81 X9 Z-2 R1 F90\n{end}"));
        assert_ends(&program, &hole);
        assert_eq!(program.moves[6].timing, Timing::Rapid);
    }
}

#[test]
fn a_cycle_goes_to_its_first_hole_where_the_height_is_known() {
    assert_ends(
        &gcode("G21 G90 S900 M3\nG0 Z5\nG98 G81 X1 Y2 Z-4 F60 R3"),
        &[
            ('L', [1.0, 2.0, 5.0]),
            ('L', [1.0, 2.0, 3.0]),
            ('L', [1.0, 2.0, -4.0]),
            ('L', [1.0, 2.0, 3.0]),
            ('L', [1.0, 2.0, 5.0]),
        ],
    );
    for unknown in
        ["G98 G81 X1 Y2 Z-4 F60 R3", "G0 Z5\nG81 X1 Z-4 F60 R3", "G0 Z5\nG91 G81 X1 Y2 Z-4 F60 R3"]
    {
        faults(&format!("G21 G90 S900 M3\n{unknown}"), Dialect::GCode);
    }
}

/// Names without an underscore belong to the call, and numbers that it does not give are zero, as LinuxCNC 2.9 has it
/// (`rs274` of Debian's linuxcnc-uspace: X10.5, 20.5 and 30.5 to Z-3, then X0 to Z-1).
#[test]
fn names_belong_to_the_call_of_a_subroutine() {
    let program = gcode(
        "G21 G90 S900 M3\nG0 X0 Y0 Z5\no<hole> sub\n#<x>=#1\n#<depth>=#2\n#<_last>=#<x>\n\
         G0 X[#<x>] Y[#3]\nG1 Z[0-#<depth>] F300\nG0 Z5\no<hole> endsub\n#<x>=10\n#<depth>=1\n\
         o1 while [#<x> LE 20]\no<hole> call [#<x>+0.5] [3]\n#<x>=[#<x>+10]\no1 endwhile\n\
         G0 X[#<_last>+1]\nG1 Z[0-#<depth>] F300\nM2\n",
    );
    let ends = [
        ('L', [0.0, 0.0, 5.0]),
        ('L', [10.5, 0.0, 5.0]),
        ('L', [10.5, 0.0, -3.0]),
        ('L', [10.5, 0.0, 5.0]),
        ('L', [20.5, 0.0, 5.0]),
        ('L', [20.5, 0.0, -3.0]),
        ('L', [20.5, 0.0, 5.0]),
        ('L', [21.5, 0.0, 5.0]),
        ('L', [21.5, 0.0, -1.0]),
    ];
    assert_ends(&program, &ends);
}

/// A letter that a macro call does not give is vacant, as #0 is.
#[test]
fn letters_that_a_macro_call_does_not_give_are_vacant() {
    let text = |call: &str| {
        format!(
            "O1\nG21 G90 S900 M3\nG0 X0 Y0 Z5\n{call}\nM30\n\
             O2\nIF[#1EQ#0]THEN #1=40\nIF[#2NE#0]GOTO9\n#2=3\nN9 G0 X#1 Y#2\nM99\n%"
        )
    };
    let ends = |call: &str, x: f64, y: f64| {
        assert_ends(&gcode(&text(call)), &[('L', [0.0, 0.0, 5.0]), ('L', [x, y, 5.0])]);
    };
    ends("G65 P2", 40.0, 3.0);
    ends("G65 P2 A7 B0", 7.0, 0.0);
    // A word by a vacant one is left out (Fanuc), where the block says no other thing without it.
    let left = |block: &str| {
        let text = text("G65 P2").replace("#2=3\nN9 G0 X#1 Y#2", block);
        gcode(&text.replace("X0 Y0 Z5", "X1 Y2 Z5"))
    };
    for (block, [x, y, z]) in [
        ("G0 X#1 Y#2", [40.0, 2.0, 5.0]),
        ("G1 Z#2Y7 F900", [1.0, 7.0, 5.0]),
        ("G90 G54 G0 X#2 Y#1 S#2", [1.0, 40.0, 5.0]),
        ("G1 F600 X#1\nY9 F#2", [40.0, 9.0, 5.0]),
    ] {
        let program = left(block);
        let last = end(program.moves.last().unwrap()).1.translation;
        let found = [last.x, last.y, last.z].map(|m| m * 1e3);
        assert!((0..3).all(|i| (found[i] - [x, y, z][i]).abs() < 1e-9), "{block}: {found:?}");
    }
    assert_eq!(left("G1 F600 X#1\nY9 F#2").moves.last().unwrap().feed_m_per_s, 0.01);
    for block in ["G28 X#2", "G52 X#2", "G0 X-#2", "G0 X[#2]", "G0 X#0", "M98 P#2", "G81 Z#2 R1"] {
        let found = faults(&text("G65 P2").replace("#2=3\nN9 G0 X#1 Y#2", block), Dialect::GCode);
        assert!(found[0].what.contains("no value"), "{block}: {found:?}");
    }
    ends("G65 P2 U5", 40.0, 3.0);
    let skipped = text("G65 P2 U5").replace("#2=3\n", "IF[#21EQ#0]GOTO9\n#2=8\n");
    let program = gcode(&skipped);
    assert_ends(&program, &[('L', [0.0, 0.0, 5.0]), ('L', [40.0, 8.0, 5.0])]);
    for (line, said) in [("GOTO#5", "no value"), ("#7=ATAN[#6]", "no value")] {
        let found = faults(&text("G65 P2").replace("#2=3", line), Dialect::GCode);
        assert!(found[0].what.contains(said), "{line}: {found:?}");
    }
    let found = faults("O1 REPEAT [#0]\nG0 X1\nO1 ENDREPEAT", Dialect::GCode);
    assert!(found[0].what.contains("no value"), "{found:?}");
    // Of other calls nothing says what the caller's letters are.
    let found = faults(&text("M98 P2"), Dialect::GCode);
    assert!(found[0].what.contains("#1 is read"), "{found:?}");
}

#[test]
fn comments_and_subprogram_ends_of_other_controls_change_nothing() {
    let straight = [('L', [0.0, 0.0, 5.0]), ('L', [7.0, 0.0, 5.0]), ('L', [7.0, 3.0, 5.0])];
    assert_ends(&behind_head("#1=(seven)7(mm)\nG0 X#1\nM17\nY3"), &straight);
    let text = "N10 DEF REAL _home\nN20 DEF REAL _x=7, _y\n_home=5 _y=_x-4\nG71 G90\n\
                G0 X0 Y0 Z=_home\nX=_x\nY=_y";
    assert_ends(&read_with(text, Dialect::Sinumerik, &settings()), &straight);
    for (text, said) in [("_100", "_100"), ("DEF REAL _d=5 mm\nG0 X0", "behind DEF")] {
        let found = faults(text, Dialect::Sinumerik);
        assert!(found[0].what.contains(said), "{text}: {found:?}");
    }
    let unset = faults("DEF STRING[9] _name\nG0 X=_name", Dialect::Sinumerik);
    assert!(unset[0].what.contains("_name"), "{unset:?}");
}

#[test]
fn heidenhain_parameters_that_are_constants_are_read() {
    let text = |feed: &str| {
        format!(
            "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S2000\n2 {feed}\n3 L X+0 Y+0 Z+Q4 R0 FMAX M3\n4 L X+60 FQ2\n5 END PGM A MM\n"
        )
    };
    let program = read_with(&text("FN 0: Q2=+600\n2 Q4 = 5"), Dialect::Heidenhain, &settings());
    assert_ends(&program, &[('L', [0.0, 0.0, 5.0]), ('L', [60.0, 0.0, 5.0])]);
    assert!((program.moves[1].feed_m_per_s - 0.01).abs() < 1e-12);
    let negative = read_with(
        &text("FN 0: Q2=+600\n2 Q5=-5\n2 FN 0: Q4=-Q5"),
        Dialect::Heidenhain,
        &settings(),
    );
    assert_ends(&negative, &[('L', [0.0, 0.0, 5.0]), ('L', [60.0, 0.0, 5.0])]);
    for unset in [
        "FN 0: Q2=+600",
        "FN 0: Q2=+600\n2 Q4=5\n2 CYCL DEF 9.0 Q4=2",
        "FN 1: Q2=+Q3+5",
        "Q2 = Q3 * 5",
    ] {
        let found = read(text(unset).as_bytes(), Dialect::Heidenhain, &settings()).unwrap_err();
        assert!(
            found.iter().any(|note| note.what.contains("the program has")),
            "{unset}: {found:?}"
        );
    }
}

/// Cycle 203 breaks chips Q213 times by Q256 before it comes out.
#[test]
fn heidenhain_breaks_chips() {
    let text = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S2000\n2 CYCL DEF 203 UNIVERSAL-DRILLING ~\nQ200=+2 ~\nQ201=-6 ~\n\
                Q206=+150 ~\nQ202=+2 ~\nQ210=+0 ~\nQ203=+0 ~\nQ204=+10 ~\nQ212=+0 ~\nQ213=+1 ~\nQ205=+2 ~\nQ211=+0 ~\n\
                Q208=+99999 ~\nQ256=+0.5\n3 L X+0 Y+0 Z+10 FMAX M3\n4 CYCL CALL\n5 END PGM A MM\n";
    let program = read_with(text, Dialect::Heidenhain, &settings());
    let heights = [10.0, 2.0, -2.0, -1.5, -4.0, 2.0, -2.0, -6.0, 2.0, 10.0];
    let ends: Vec<_> = heights.iter().map(|z| ('L', [0.0, 0.0, *z])).collect();
    assert_ends(&program, &ends);
}

/// A cycle reads its parameters where it is called: one that is changed behind its definition is refused.
#[test]
fn heidenhain_parameters_of_a_defined_cycle_are_not_changed() {
    let text = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S2000\n2 CYCL DEF 200 DRILLING Q200=+2 Q201=-6 Q206=+150 Q202=+6 Q203=+0\n\
                3 L X+0 Y+0 Z+10 FMAX M3\n4 FN 0: Q203=-10\n5 CYCL CALL\n6 END PGM A MM\n";
    let found = read(text.as_bytes(), Dialect::Heidenhain, &settings()).unwrap_err();
    assert!(found[0].what.contains("Q203 of a cycle"), "{found:?}");
}
