//! What programs from other people's cells and CAM systems hold, and was once read wrongly without a
//! word. Expected places and times are worked out by hand.

use detune::motion::Timing;
use detune::notes::Code;
use detune::program::{Dialect, Program, SetBy, Setter, Settings, Spindle, read};

use super::support::{assert_ends, ended, faults, module, settings};

fn of(text: &str, dialect: Dialect) -> Program {
    read(ended(text, dialect).as_bytes(), dialect, &settings()).unwrap()
}

fn codes(program: &Program) -> Vec<Code> {
    let told = program.warnings.iter().map(|note| note.code);
    told.filter(|code| *code != Code::Assumed).collect()
}

#[track_caller]
fn refused(text: &str, dialect: Dialect, said: &str) {
    let found = faults(text, dialect);
    assert!(found.iter().any(|fault| fault.what.contains(said)), "{text}: {found:?}");
}

fn krl(body: &str) -> Program {
    let text = format!("DEF p()\n$VEL.CP=0.1\n{body}\nEND\n");
    of(&text, Dialect::Krl)
}

const START: &str = "PTP {X 0,Y 0,Z 100,A 0,B 0,C 180}";

#[test]
fn a_loop_of_krl_runs_until_it_is_left() {
    let body = format!(
        "DECL INT i\n{START}\ni=0\nLOOP\ni=i+1\nLIN_REL {{X 10}}\nIF i>=3 THEN\nEXIT\nENDIF\n\
         ENDLOOP\nLIN_REL {{Y 30}}"
    );
    assert_ends(
        &krl(&body),
        &[
            ('T', [0.0, 0.0, 100.0]),
            ('L', [10.0, 0.0, 100.0]),
            ('L', [20.0, 0.0, 100.0]),
            ('L', [30.0, 0.0, 100.0]),
            ('L', [30.0, 30.0, 100.0]),
        ],
    );
    // One that nothing leaves is read once.
    let endless = krl(&format!("{START}\nLOOP\nLIN_REL {{X 10}}\nENDLOOP\nLIN_REL {{Y 30}}"));
    assert_eq!((endless.moves.len(), codes(&endless)), (2, vec![Code::MotionLeftOut]));
}

/// bas.src of KSS: CASE #CP_DAT sets VEL_CP(LDAT_ACT.VEL), #PTP_DAT VEL_PTP(PDAT_ACT.VEL), and
/// INITMOV VEL_PTP(100), VEL_CP(DEF_VEL_CP), BASE(0), $TOOL=TOOL_DATA[1].
#[test]
fn speeds_and_frames_of_the_basic_package() {
    let program = krl(&format!(
        "{START}\nLDAT_ACT={{VEL 0.05,ACC 100,APO_DIST 10}}\nBAS(#CP_DAT)\nLIN_REL {{X 10}}\n\
         PDAT_ACT={{VEL 30,ACC 100,APO_DIST 10}}\nBAS(#PTP_DAT)\n{START}\nBAS(#INITMOV,0)\n{START}\n\
         LIN_REL {{X 10}}"
    ));
    assert_eq!(program.moves[1].feed_m_per_s, 0.05);
    let timings = [2, 3].map(|i: usize| program.moves[i].timing);
    assert_eq!(timings, [Timing::Joints(0.3), Timing::Joints(1.0)]);
    // The speed that no file gives is the job's.
    assert_eq!(program.moves[4].feed_m_per_s, 0.01);
    refused(&format!("DEF p()\n{START}\nBAS(#CP_DAT)\nEND\n"), Dialect::Krl, "LDAT_ACT.VEL");
}

#[test]
fn parameters_frames_by_number_and_relative_motion_of_krl() {
    let text = format!(
        "DEF p()\n$VEL.CP=0.1\n{START}\nGo(25)\nLIN_REL {{Y 5}} C_VEL #BASE\nEND\n\
         DEF Go(d :IN)\nDECL REAL d\nLIN_REL {{X d}}\nEND\n"
    );
    let ends = [[0.0, 0.0, 100.0], [25.0, 0.0, 100.0], [25.0, 5.0, 100.0]];
    assert_ends(&of(&text, Dialect::Krl), &[('T', ends[0]), ('L', ends[1]), ('L', ends[2])]);
    let text = format!("DEF p()\n{START}\nPTP_REL {{Y 5}} #TOOL\nEND\n");
    refused(&text, Dialect::Krl, "relative to the tool (#TOOL)");
    let mut job = settings();
    let at = nalgebra::Isometry3::translation(0.0, 0.0, 0.2);
    job.tool_frames.insert(3, at);
    job.base_frames.insert(2, nalgebra::Isometry3::translation(1.0, 0.0, 0.0));
    let text = format!("DEF p()\n$TOOL=TOOL_DATA[3]\n$BASE=BASE_DATA[2]\n{START}\nEND\n");
    let program = read(text.as_bytes(), Dialect::Krl, &job).unwrap();
    assert_ends(&program, &[('T', [1000.0, 0.0, 100.0])]);
    assert_eq!((program.moves[0].tcp, program.warnings.len()), (at, 0));
}

#[test]
fn an_unread_call_in_an_open_branch_is_a_doubt_and_loads_in_parts_are() {
    let program = krl(&format!("IF $IN[5] THEN\nA20(INI)\nENDIF\n$LOAD.M=20\n{START}"));
    assert_eq!(codes(&program), [Code::MotionLeftOut, Code::ChangeIgnored]);
    let text = format!("DEF p()\nIF $IN[5] THEN\nmove_out()\nENDIF\n{START}\nEND\n");
    refused(&text, Dialect::Krl, "decides about motion at run time");
    let text = format!("DEF p()\n{START}\nLIN {{X 1,E1 500}}\nEND\n");
    refused(&text, Dialect::Krl, "targets before do not say where it is");
}

/// A signal that the job names and the reader has made nothing of is never passed over.
#[test]
fn signals_that_are_set_where_they_are_not_read_are_doubts() {
    let by = |name: &str| Settings {
        spindle_from: Some(SetBy { what: Setter::Signal(name.to_owned()), per_unit: 1.0 }),
        ..settings()
    };
    let target = "[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let set = format!("SetAO aoS,900;\nMoveL {target},v5,fine,tool0;\n");
    for (more, doubts) in [
        ("", 0),
        ("! aoS,1400", 0),
        ("TriggIO t,0\\AOp:=aoS,1400;", 1),
        ("IF 1=2 THEN\nSetAO aoS,1400;\nENDIF", 1),
    ] {
        let text = module(&format!("{set}{more}"));
        let program = read(text.as_bytes(), Dialect::Rapid, &by("aoS")).unwrap();
        let found = codes(&program).iter().filter(|c| **c == Code::SpindleCommand).count();
        assert_eq!(found, doubts, "{more}: {:?}", program.warnings);
        assert_eq!(program.spindle[0].spindle, Spindle::Turns(Some(900.0)));
    }
    let text = format!(
        "DEF p()\nSIGNAL SPN $ANOUT[1]\n$ANOUT[1]=900\n{START}\nSPN=1400\n\
         TRIGGER WHEN DISTANCE=0 DELAY=0 DO $ANOUT[1]=1400\nLIN_REL {{X 1}}\nEND\n"
    );
    let program = read(text.as_bytes(), Dialect::Krl, &by("$ANOUT[1]")).unwrap();
    assert_eq!(codes(&program), [Code::SpindleCommand], "{:?}", program.warnings);
    assert_eq!(program.warnings[0].place.line, Some(6));
    // SPN is that output.
    let rpm: Vec<_> = program.spindle.iter().map(|it| (it.line, it.spindle)).collect();
    assert_eq!(rpm, [(3, Spindle::Turns(Some(900.0))), (5, Spindle::Turns(Some(1400.0)))]);
}

#[test]
fn words_of_sinumerik_that_mean_something_else() {
    let start = "G90 G94 G0 X0 Y0 Z0\n";
    refused(&format!("{start}L100 P2\nG1 X10 F100\n"), Dialect::Sinumerik, "'L100' calls");
    refused(&format!("{start}L10\nG1 X10 F100\n"), Dialect::GCode, "L calls");
    refused(&format!("{start}G58 X10\n"), Dialect::Sinumerik, "G58 with axes shifts");
    refused(&format!("{start}MCALL CYCLE86(10,0,2,-5)\n"), Dialect::Sinumerik, "CYCLE86");
    // G70 is of lengths alone, G700 of feeds, too.
    let feed = |code: &str, dialect| {
        of(&format!("{start}{code}\nG1 X1 F10\n"), dialect).moves[1].feed_m_per_s * 6e4
    };
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
    close(feed("G70", Dialect::Sinumerik), 10.0);
    close(feed("G700", Dialect::Sinumerik), 254.0);
    close(feed("G70", Dialect::GCode), 254.0);
    let header = "G40 G17 G710 G94 G90 G60 G601 FNORM\nG642 ADIS=0.01 DIAMOF G500\n";
    let program = of(&format!("{header}{start}G1 X10 F100\n"), Dialect::Sinumerik);
    assert_eq!((program.moves.len(), codes(&program).len()), (2, 0), "{:?}", program.warnings);
}

#[test]
fn offsets_lengths_and_calls_of_g_code() {
    let start = "G21 G90 G94 G0 X0 Y0 Z0\nG1 X10 F100\n";
    for other in ["G54.1 P2", "G154 P2", "G55"] {
        let program = of(&format!("G54.1 P1\n{start}{other}\nX20\n"), Dialect::GCode);
        assert_eq!(codes(&program), [Code::ChangeIgnored], "{other}");
    }
    assert!(of(&format!("G54.1 P1\n{start}G54.1 P1\nX20\n"), Dialect::GCode).warnings.is_empty());
    // LinuxCNC: the axes of G43.1 are a tool's length, no way.
    let program = of(&format!("{start}G43.1 Z5\nX20\n"), Dialect::GCode);
    assert_eq!(program.moves.len(), 3);
    refused(&format!("{start}#5221=100\n"), Dialect::GCode, "sets a work offset");
    refused(&format!("{start}G13 I10\n"), Dialect::GCode, "G13 with words of a pocket");
    refused(&format!("{start}M198 P50\n"), Dialect::GCode, "M198");
    refused(&format!("{start}G60 X20\n"), Dialect::GCode, "G60 with axes at feed");
    for harmless in ["G60", "G60 G0 X20", "G0 X20\nG60 X30"] {
        let program = of(&format!("{start}{harmless}\n"), Dialect::GCode);
        assert!(codes(&program).iter().all(|code| *code == Code::Assumed), "{harmless}");
    }
    for block in ["/S1400", "/GOTO 5\nN5 X30", "/M30"] {
        let program = of(&format!("{start}{block}\n"), Dialect::GCode);
        assert!(codes(&program).contains(&Code::MotionLeftOut), "{block}");
    }
    for harmless in ["G05.1 Q1", "G05 P10000", "G08 P1", "G187 P3", "G103 P1", "G62"] {
        let program = of(&format!("<OP_10>\n{harmless}\n{start}"), Dialect::GCode);
        assert!(program.warnings.is_empty(), "{harmless}");
    }
}

#[test]
fn tools_by_name_stay_the_first_with_a_doubt() {
    let start = "G71 G90 G94 G0 X0 Y0 Z0\nG1 X10 F100\n";
    let text = |second: &str| format!("T=\"MILL2\"\n{start}T=\"{second}\"\nX20\n");
    assert_eq!(codes(&of(&text("MILL2"), Dialect::Sinumerik)), [Code::LeftOut]);
    let changed = codes(&of(&text("MILL5"), Dialect::Sinumerik));
    assert_eq!(changed, [Code::LeftOut, Code::ChangeIgnored]);
}

#[test]
fn tools_by_name_that_the_job_lists_have_its_numbers() {
    let job = Settings {
        tool_names: [("MILL2".to_owned(), 3), ("MILL5".to_owned(), 4)].into(),
        tool_frames: [3, 4].map(|number| (number, nalgebra::Isometry3::identity())).into(),
        ..settings()
    };
    let sinumerik = "G71 G90 G94\nT=\"MILL2\" M6\nS900 M3\nG0 X0 Y0 Z0\nG1 X10 F100\n\
                     T=\"MILL5\"\nX20\nM6 M3\nX30\nM30\n";
    let calls = "BEGIN PGM A MM\nTOOL CALL \"MILL2\" Z S5000\nL X+0 Y+0 Z+5 FMAX M3\n\
                 L X+5 F500\nL X+6\nTOOL CALL \"MILL5\" Z S900 M3\nL X+9\nEND PGM A MM\n";
    for (text, dialect) in [(sinumerik, Dialect::Sinumerik), (calls, Dialect::Heidenhain)] {
        let program = read(text.as_bytes(), dialect, &job).unwrap();
        let found: Vec<_> = program.moves.iter().map(|each| each.stated.tool).collect();
        assert_eq!(found, [Some(3), Some(3), Some(3), Some(4)], "{text}");
        assert!(codes(&program).is_empty(), "{:?}", program.warnings);
    }
}

/// A spindle that turns through a change of tool, which most controls stop; told where it cuts.
#[test]
fn a_spindle_that_nothing_starts_behind_a_change_of_tool_is_told() {
    let gcode = |change: &str| {
        format!("G21 G90 G94 G0 X0 Y0 Z0\nT1 M6\nS900 M3\nG1 X10 F100\n{change}X20\nM30\n")
    };
    for (change, told) in [
        ("T2 M6\n", true),
        ("T2 M6 M3\n", false),
        ("T2 M3 M6\n", false),
        ("T2 M6\nM13\n", false),
        ("T2 M6\nM5\nM3\n", false),
        ("T2 M6\nG2 X30 I10 J0\nG1 ", true),
        ("T2 M6\nG81 X5 Z-5 R2 F90\nG80\nG1 ", true),
        ("T2 M6\nG0 ", false),
    ] {
        let program = of(&gcode(change), Dialect::GCode);
        assert_eq!(codes(&program).contains(&Code::SpindleCommand), told, "{change}");
    }
    for (call, told) in [
        ("TOOL CALL 2 Z S900\nL X+5 F500", true),
        ("TOOL CALL 2 Z S900\nL X+5 F500 M3", false),
        ("TOOL CALL 1 Z S900\nL X+5 F500", false),
        ("TOOL CALL S900\nL X+5 F500", false),
        ("TOOL CALL 2 Z S900\nL X+5 FMAX", false),
    ] {
        let program = of(&heidenhain(&format!("L Z+5 F500\n{call}")), Dialect::Heidenhain);
        assert_eq!(codes(&program).contains(&Code::SpindleCommand), told, "{call}");
    }
}

fn heidenhain(body: &str) -> String {
    format!(
        "BEGIN PGM A MM\nTOOL CALL 1 Z S5000 F350\nL X+0 Y+0 Z+50 R0 FMAX M3\n{body}\nEND PGM A MM\n"
    )
}

/// SEQ+ of a PLANE that turns nothing is no Q parameter, and REP may be one that the program sets.
#[test]
fn words_of_heidenhain_that_hold_a_q() {
    let plane = heidenhain("PLANE SPATIAL SPA+0 SPB+0 SPC+0 TURN FMAX SEQ+\nL X+50 F200");
    assert_eq!(of(&plane, Dialect::Heidenhain).moves.len(), 2);
    for times in ["REP Q3/Q3", "REP Q3", "REP 2/2"] {
        let text = format!("Q3 = 2\nLBL 1\nL IX+5 F200\nCALL LBL 1 {times}");
        assert_eq!(of(&heidenhain(&text), Dialect::Heidenhain).moves.len(), 4, "{times}");
    }
    let unset = heidenhain("LBL 1\nL IX+5 F200\nCALL LBL 1 REP Q3");
    refused(&unset, Dialect::Heidenhain, "REP without a number: Q3 is read");
}

/// The length's number may stand in a parameter that the controller keeps; the way is the same.
#[test]
fn a_length_by_a_parameter_that_is_not_set() {
    let of = |length: &str| {
        let text = format!("G21 G90 G94 G0 X0 Y0 Z50\nG43 H{length} Z5\nG1 X10 F100\n");
        let program = of(&text, Dialect::GCode);
        (program.moves.len(), codes(&program))
    };
    for length in ["#518", "[#518+1]", "#4120"] {
        assert_eq!(of(length), (3, vec![Code::ChangeIgnored]), "{length}");
    }
    assert_eq!(of("18"), (3, vec![]));
    // Elsewhere it is a fault: as an argument it would be a vacant one.
    let call = "G21 G90 G94 G0 X0 Y0 Z50\nG65 P9 H#518\nM30\nO9\nG1 X100 F500\nM99\n";
    refused(call, Dialect::GCode, "#518 is read, and the program has not set it");
    refused("G21 G90 G0 X0 Y0 Z50\nG43 H[1/0] Z5\n", Dialect::GCode, "division by zero");
}

/// A centre that is written as a place.
#[test]
fn a_centre_that_fits_as_a_place() {
    let arc = "G21 G90 G94 G0 X100 Y0 Z0\nG2 X0 Y-100 I0 J0 F100\n";
    refused(arc, Dialect::GCode, "as places (G90.1) I, J and K fit");
    // About a centre far away any short way nearly closes.
    let spiral = "G21 G90 G94 G0 X200 Y0 Z0\nG3 X199.5 Y0 I-5.4 J0 F100\n";
    let found = faults(spiral, Dialect::GCode);
    assert!(!found[0].what.contains("G90.1"), "{found:?}");
}

/// Of a direction, components that are not given are zero (Siemens, SINUMERIK 840D sl, Job planning).
#[test]
fn a_direction_of_which_components_are_left_out() {
    let text = "G71 G90 G94\nTRAORI\nG0 X0 Y0 Z0\nG1 X10 A3=0.6 C3=0.8 F100\n";
    let program = of(text, Dialect::Sinumerik);
    let axis = super::support::end(&program.moves[1]).1.rotation * nalgebra::Vector3::z();
    assert!((axis + nalgebra::Vector3::new(0.6, 0.0, 0.8)).norm() < 1e-12, "{axis}");
}

#[test]
fn feeds_of_heidenhain_in_all_their_words() {
    let program = of(
        &heidenhain(
            "L Z+5 F500\nL X+100 F MAX\nL X+0 FAUTO\nL X+100 F300\nL X+0 F AUTO\nL X+100 FU0.2",
        ),
        Dialect::Heidenhain,
    );
    let feeds: Vec<f64> = program.moves.iter().map(|m| (m.feed_m_per_s * 6e4).round()).collect();
    // 0.2 mm in each of 5000 turns a minute.
    assert_eq!([feeds[1], feeds[3], feeds[4], feeds[5], feeds[6]], [500., 350., 300., 350., 1000.]);
    assert_eq!(program.moves[2].timing, Timing::Rapid);
    for (word, said) in
        [("FT5", "'FT'"), ("FZ0.3", "'FZ'"), ("FXYZ", "'FXYZ'"), ("F+", "'F +' has a sign")]
    {
        refused(&heidenhain(&format!("L Z+5 F500\nL X+100 {word}")), Dialect::Heidenhain, said);
    }
    let none = heidenhain("L Z+5 F500").replace(" F350", "").replace("F500", "FAUTO");
    refused(&none, Dialect::Heidenhain, "the last TOOL CALL has no F");
    for (call, said) in
        [("TOOL CALL 1 Z SQ1", "Q parameters in words"), ("TOOL CALL 1 Z S", "S without a number")]
    {
        refused(&heidenhain(call), Dialect::Heidenhain, said);
    }
    let named =
        of(&heidenhain("L Z+5 F500\nTOOL CALL \"FACE50\" Z S900\nL X+5"), Dialect::Heidenhain);
    assert!(codes(&named).contains(&Code::ChangeIgnored), "{:?}", named.warnings);
}

/// Pecks of 5 mm to 20 mm, from 2 mm above the surface: cycle 200 begins each 2 mm over the last;
/// 203 with one break of the chip by 1 mm between two retracts, and out at Q208.
#[test]
fn pecks_of_heidenhain() {
    let cycle = |number: u32, more: &str| {
        heidenhain(&format!(
            "CYCL DEF {number} DRILLING Q200=+2 Q201=-20 Q206=+300 Q202=+5 Q203=+0 Q204=+20 {more}\n\
             CYCL CALL"
        ))
    };
    let heights = |text: &str| -> Vec<f64> {
        let program = of(text, Dialect::Heidenhain);
        let moves = program.moves[1..].iter().map(super::support::end);
        moves.map(|(_, pose)| (pose.translation.z * 1e3).round()).collect()
    };
    assert_eq!(
        heights(&cycle(200, "")),
        [2., -5., 2., -3., -10., 2., -8., -15., 2., -13., -20., 2., 20.]
    );
    let broken = cycle(203, "Q213=+1 Q256=+1 Q208=+1000");
    assert_eq!(heights(&broken), [2., -5., -4., -10., 2., -8., -15., -14., -20., 2., 20.]);
    let out = of(&broken, Dialect::Heidenhain).moves[10].feed_m_per_s * 6e4;
    assert!((out - 1000.0).abs() < 1e-9, "{out}");
    // 8, 6, 4 and the rest of 20 mm.
    let less = cycle(203, "Q212=+2 Q205=+1 Q208=+0").replace("Q202=+5", "Q202=+8");
    assert_eq!(heights(&less)[1], -8.0);
    assert_eq!(heights(&less).iter().filter(|z| **z == -14.0 || **z == -18.0).count(), 2);
}

#[test]
fn axes_pecks_and_ends_of_apt() {
    let tilted = "MULTAX\nGOTO/10,0,0,0.6,0,0.8\n";
    let axis = |text: &str| {
        let program = of(text, Dialect::Apt);
        super::support::end(program.moves.last().unwrap()).1.rotation * -nalgebra::Vector3::z()
    };
    // The tool points along its −z.
    let z = axis(&format!("{tilted}MULTAX/OFF\nGOTO/20,0,0"));
    assert!((z - nalgebra::Vector3::z()).norm() < 1e-9, "{z}");
    let kept = axis(&format!("{tilted}GOTO/20,0,0"));
    assert!((kept - nalgebra::Vector3::new(0.6, 0.0, 0.8)).norm() < 1e-9, "{kept}");

    let drill = |cycle: &str| of(&format!("GOTO/0,0,50\n{cycle}\nGOTO/0,0,0\n"), Dialect::Apt);
    let pecks = drill("CYCLE/DRILL,DEEP,STEP,3,FEDTO,-9,RAPTO,2,MMPM,100");
    // Over the hole, three pecks with two ways out and back in, and out.
    assert_eq!(pecks.moves.len(), 1 + 1 + 3 + 4 + 1);
    let units = |cycle: &str| codes(&drill(cycle));
    assert_eq!(units("CYCLE/DRILL,10,100"), [Code::UnitAssumed]);
    assert!(units("CYCLE/DRILL,10,100,MMPM,3").is_empty());
    refused("GOTO/0,0,50\nCYCLE/DRILL,126,85,1,MMPR\nGOTO/0,0,0", Dialect::Apt, "85 in a turn");

    for end in ["END-OF-PATH", "REWIND/0\nEND"] {
        let text = format!("GOTO/0,0,0\nGOTO/10,0,0\n{end}\n");
        assert_eq!(read(text.as_bytes(), Dialect::Apt, &settings()).unwrap().moves.len(), 2);
    }
    let creo = "$$-> CSYS / 1.0, 0.0, $\n0.0, 0.0\nGOTO/0,0,0\nGOTO/10,0,0";
    assert_eq!(of(creo, Dialect::Apt).moves.len(), 2);
    assert_eq!(Dialect::of_file("part.ncl.12".as_ref()), Some(Dialect::Apt));
    let inserted = of("GOTO/0,0,0\nINSERT/S1400 M3\nGOTO/10,0,0", Dialect::Apt);
    assert_eq!(codes(&inserted), [Code::MotionLeftOut]);
}

#[test]
fn traps_that_move_are_a_doubt_and_monitors_are_none() {
    let target = "[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let text = module(&format!("MoveL {target},v5,fine,tool0;\nMotionSup \\On;\nWZFree w;"));
    assert!(of(&text, Dialect::Rapid).warnings.is_empty());
    let trap = format!("TRAP t\nMoveL {target},v5,fine,tool0;\nENDTRAP\nENDMODULE");
    let text = text.replace("ENDMODULE", &trap);
    assert_eq!(codes(&of(&text, Dialect::Rapid)), [Code::MotionLeftOut]);
}
