//! What a program states, or leaves open, and the reader once took for granted without a word: the
//! spindle that stands, tools of other lengths, the unit of lengths, names that the job assumes.

use detune::notes::{Code, Note};
use detune::program::{
    Assumed, Dialect, LengthUnit, Program, SetBy, Setter, Settings, Spindle, read,
};
use nalgebra::Isometry3;

use super::support::{assert_ends, at, ended, module, settings};

const NONE: [usize; 0] = [];

fn of(text: &str, dialect: Dialect, settings: &Settings) -> Program {
    read(ended(text, dialect).as_bytes(), dialect, settings).unwrap()
}

fn told(program: &Program, code: Code) -> Vec<usize> {
    program.warnings.iter().filter(|note| note.code == code).map(at).collect()
}

#[test]
fn feed_moves_while_the_spindle_stands_are_a_doubt() {
    let gcode = |body: &str| {
        let text = format!("G21 G0 X0 Y0 Z0\nS900 M3\nG1 X9 F400\n{body}");
        told(&of(&text, Dialect::GCode, &settings()), Code::SpindleCommand)
    };
    assert_eq!(gcode("M5\nG1 X0 F9000\nX9\nG0 Z5"), [5]);
    assert_eq!(gcode("S0\nG2 X0 R9"), [5]);
    assert_eq!(gcode("M5\nG93 G1 X0 F2"), [5]);
    assert_eq!(gcode("M5\nG0 X0 Z90"), NONE);
    assert_eq!(gcode("M5\nS800 M3\nG1 X0"), NONE);
    // The spindle stops behind the motion of its block.
    assert_eq!(gcode("G1 X0 M5\nG4 P1."), NONE);
    let apt = "UNITS/MM\nGOTO/0,0,0\nSPINDL/900\nFEDRAT/400\nGOTO/9,0,0\nSPINDL/OFF\nGOTO/0,0,0";
    assert_eq!(told(&of(apt, Dialect::Apt, &settings()), Code::SpindleCommand), [7]);
    let heidenhain = "0 BEGIN PGM A MM\nL X+0 Y+0 Z+5 FMAX\nTOOL CALL 1 Z S900\nL X+9 F400 M3\n\
                      L X+8 FMAX M5\nL X+0 F400\nL Z+50 FMAX\nEND PGM A MM\n";
    assert_eq!(told(&of(heidenhain, Dialect::Heidenhain, &settings()), Code::SpindleCommand), [6]);
    // Nothing turns: that nothing is checked is told elsewhere.
    let text = "G21 M5\nG0 X0 Y0 Z0\nG1 X9 F400";
    assert_eq!(told(&of(text, Dialect::GCode, &settings()), Code::SpindleCommand), NONE);
}

/// A robot's program has no rapid lines: those faster than it mostly moves with the spindle on.
#[test]
fn lines_of_a_robot_that_retract_faster_than_they_cut_are_no_doubt() {
    let what = Setter::Signal("ao_spindle".to_owned());
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    let cut = "MoveL Offs(p,1,0,0),v10,fine,tool0;\nMoveL Offs(p,2,0,0),v10,fine,tool0;";
    let rapid = |speed: &str| {
        let text = module(&format!(
            "MoveL p,v100,fine,tool0;\nSetAO ao_spindle,900;\nMoveL Offs(p,0,0,1),v50,fine,tool0;\n\
             {cut}\nSetAO ao_spindle,0;\nMoveL Offs(p,0,0,9),{speed},fine,tool0;"
        ));
        told(&of(&text, Dialect::Rapid, &job), Code::SpindleCommand)
    };
    assert_eq!(rapid("v50"), NONE);
    assert_eq!(rapid("v10"), [10]);
}

#[test]
fn tools_under_one_tcp_are_a_doubt_unless_the_job_measures_them() {
    let frame = |z: f64| Isometry3::translation(0.0, 0.0, z);
    let job = Settings { tcp: Some(frame(0.15)), ..settings() };
    let measured = |numbers: &[u32]| Settings {
        tool_frames: numbers.iter().map(|n| (*n, frame(0.1 * f64::from(*n)))).collect(),
        ..job.clone()
    };
    let doubts = |text: &str, dialect: Dialect, job: &Settings| {
        told(&of(text, dialect, job), Code::ChangeIgnored)
    };
    let two = "G21 T1 M6\nG0 X0 Y0 Z0\nG1 X9 F400\nT2 M6\nG0 X0\nG1 X9\nG1 X5\nT1 M6\nG1 X0";
    assert_eq!(doubts(two, Dialect::GCode, &job), [6]);
    assert_eq!(doubts(two, Dialect::GCode, &measured(&[1])), NONE);
    assert_eq!(doubts(two, Dialect::GCode, &measured(&[1, 2])), NONE);
    let program = of(two, Dialect::GCode, &measured(&[1, 2]));
    let lengths: Vec<f64> = program.moves.iter().map(|m| m.tcp.translation.z).collect();
    assert_eq!(lengths, [0.1, 0.1, 0.2, 0.2, 0.2, 0.1]);
    // The same without any tcp; of some tools alone they are an error.
    assert_eq!(doubts(two, Dialect::GCode, &settings()), [6]);
    let some = Settings { tcp: None, ..measured(&[1]) };
    let found = read(ended(two, Dialect::GCode).as_bytes(), Dialect::GCode, &some).unwrap_err();
    assert!(found[0].what.contains("tool 2 is not among path.program.tool_frames"), "{found:?}");
    assert_eq!(at(&found[0]), 4);
    // One tool; another that only travels; none.
    for one in [
        "G21 T1 M6\nG43 H1 G0 X0 Y0 Z0\nG1 X9 F400\nG49\nT1 M6\nG43 H1 G1 X0",
        "G21 T1 M6\nG0 X0 Y0 Z0\nG1 X9 F400\nT2 M6\nG0 X0",
        "G21 T1 M6\nG0 X0 Y0 Z0\nG1 X9 F400\nT0 M6\nG1 X0",
        "G21 G0 X0 Y0 Z0\nG1 X9 F400",
    ] {
        assert_eq!(doubts(one, Dialect::GCode, &job), NONE, "{one}");
        assert_eq!(doubts(one, Dialect::GCode, &settings()), NONE, "{one}");
    }
    // Lengths without a tool, and two of one tool.
    let lengths = "G21 G43 H1 G0 X0 Y0 Z0\nG1 X9 F400\nG43 H2\nG1 X0";
    assert_eq!(doubts(lengths, Dialect::GCode, &job), [4]);
    assert_eq!(doubts(lengths, Dialect::GCode, &settings()), [4]);
    assert_eq!(doubts(lengths, Dialect::GCode, &measured(&[1, 2])), NONE);
    let edges = "G21 T1 M6\nG43 H1 G0 X0 Y0 Z0\nG1 X9 F400\nG43 H11\nG1 X0";
    assert_eq!(doubts(edges, Dialect::GCode, &measured(&[1])), [4]);
    let apt = "UNITS/MM\nLOADTL/1\nGOTO/0,0,0\nFEDRAT/400\nGOTO/9,0,0\nLOADTL/2\nGOTO/0,0,0";
    assert_eq!(doubts(apt, Dialect::Apt, &job), [7]);
    assert_eq!(doubts(apt, Dialect::Apt, &settings()), [7]);
    let heidenhain = "0 BEGIN PGM A MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+5 FMAX\nL X+9 F400\n\
                      TOOL CALL 2 Z S900\nL X+0 F400\nEND PGM A MM\n";
    assert_eq!(doubts(heidenhain, Dialect::Heidenhain, &job), [6]);
    assert_eq!(doubts(heidenhain, Dialect::Heidenhain, &settings()), [6]);
    assert_eq!(doubts(heidenhain, Dialect::Heidenhain, &measured(&[1, 2])), NONE);
    let krl = "DEF p()\nBAS(#VEL_CP,0.1)\nBAS(#TOOL,1)\nPTP {X 0,Y 0,Z 100,A 0,B 0,C 180}\n\
               LIN {X 9}\nBAS(#TOOL,2)\nLIN {X 0}\nEND\n";
    assert_eq!(doubts(krl, Dialect::Krl, &job), [7]);
    assert_eq!(doubts(krl, Dialect::Krl, &measured(&[1, 2])), NONE);
    // Two tools that are declared in no file.
    let rapid = module("MoveL p,v5,fine,tA;\nMoveL p,v5,fine,tA;\nMoveL p,v5,fine,tB;");
    assert_eq!(doubts(&rapid, Dialect::Rapid, &job), [6]);
}

/// H chooses the length while G43 holds, also in a block of its own.
#[test]
fn another_length_without_g43_is_a_doubt() {
    let doubts = |text: &str| {
        let text = format!("G21 T1 M6\nG43 H1 G0 X0 Y0 Z5\nG1 X9 F400\n{text}");
        told(&of(&text, Dialect::GCode, &settings()), Code::ChangeIgnored)
    };
    assert_eq!(doubts("X10 H2\nZ0"), [4]);
    assert_eq!(doubts("X10 H1\nZ0"), NONE);
    assert_eq!(doubts("G0 G49 Z50\nX10 H2"), NONE);
}

/// Behind a change between inches and mm, F without a new number is the same feed or the same number.
#[test]
fn a_feed_that_is_kept_in_another_unit_is_a_doubt() {
    let doubts = |text: &str, dialect| {
        let text = format!("G21 G90 G94\nS900 M3\nG0 X0 Y0 Z5\nG1 X10 F200\n{text}");
        told(&of(&text, dialect, &settings()), Code::UnitAssumed)
    };
    for (text, lines) in [
        ("G20\nX1", vec![6]),
        // Back in its own unit the feed is what it was.
        ("G20\nX1\nG21\nX2", vec![6]),
        ("G20 X1\nX2", vec![5]),
        ("G20\nG0 X1\nG2 X2 R1", vec![7]),
        ("G20\nG99 G81 X1 Z-1 R0.1", vec![6]),
        ("G21\nX1", vec![]),
        ("G20\nG21\nX1", vec![]),
        ("G20\nF8\nX1", vec![]),
        ("G20\nG0 X1\nG1 X2 F8\nG0 X3", vec![]),
        ("G20\nG93 X1 F8", vec![]),
    ] {
        assert_eq!(doubts(text, Dialect::GCode), lines, "{text}");
    }
    assert_eq!(doubts("G700\nX1", Dialect::Sinumerik), [6]);
    assert_eq!(doubts("G700\nX1 FB=8\nX2", Dialect::Sinumerik), [7]);
}

/// Sinumerik's G70 is of lengths alone: feeds are in the unit of MD10240. 9.8 inches are 248.92 mm.
#[test]
fn feeds_under_g70_are_a_doubt_where_nothing_says_the_unit_of_the_machine() {
    let found = |head: &str, body: &str, unit: Option<LengthUnit>| {
        let text = format!("{head} G90 G94\nS900 M3\nG0 X0 Y0 Z1\n{body}");
        of(&text, Dialect::Sinumerik, &Settings { unit, ..settings() })
    };
    let doubts = |head: &str, body: &str| told(&found(head, body, None), Code::UnitAssumed);
    let cut = "G1 X2 F9.8\nX3";
    assert_eq!(doubts("G70", cut), [4]);
    assert_eq!(doubts("F9.8 G70", "G1 X2"), [4]);
    assert_eq!(doubts("G70", "G95 G1 X2 F0.01"), [4]);
    assert_eq!(doubts("G70", "CYCLE85(1,0,.1,-1,,0,80,200)"), [4]);
    // The unit is that of where F stands.
    for other in ["G710", "G71"] {
        assert_eq!(doubts("G70 F9.8", &format!("{other} G1 X2")), [4], "{other}");
    }
    assert_eq!(doubts("G70 F9.8", "G710\nG1 X2 F100"), NONE);
    let kept = found("G700 F9.8", "G70 G1 X2", None);
    assert_eq!(told(&kept, Code::UnitAssumed), [4]);
    assert!(!kept.warnings.iter().any(|note| note.what.contains("taken as mm")), "{kept:?}");
    assert!((kept.moves[1].feed_m_per_s * 6e4 - 248.92).abs() < 1e-9);
    for (head, body) in [("G700", cut), ("G71", cut), ("G70", "G1 X2"), ("G70", "G93 G1 X2 F5")] {
        assert_eq!(doubts(head, body), NONE, "{head} {body}");
    }
    for (unit, mm_per_min) in [(LengthUnit::Mm, 9.8), (LengthUnit::Inch, 248.92)] {
        let program = found("G70", cut, Some(unit));
        assert_eq!(told(&program, Code::UnitAssumed), NONE);
        assert!((program.moves[1].feed_m_per_s * 6e4 - mm_per_min).abs() < 1e-9);
    }
}

#[test]
fn lengths_without_a_unit_are_a_doubt_where_they_look_like_inches() {
    let found = |body: &str| {
        let program = of(&format!("G0 X0 Y0 Z0\n{body}"), Dialect::GCode, &settings());
        let unit = |note: &&Note| note.what.contains("nothing says their unit");
        program.warnings.iter().find(unit).map(|note| (note.code, at(note)))
    };
    let (doubt, remark) = (Some((Code::UnitAssumed, 1)), Some((Code::Assumed, 1)));
    // Small at a feed of inches; slow; of four decimals, as posts write inches.
    assert_eq!(found("G1 X3 F12\nX0"), doubt);
    assert_eq!(found("G1 X100 F40"), doubt);
    assert_eq!(found("G1 X100.1255 F400"), doubt);
    assert_eq!(found("G1 X30.1255 F400"), doubt);
    assert_eq!(found("G1 X100.125 F400"), remark);
    assert_eq!(found("G1 X100.125 F150"), remark);
    assert_eq!(found("G1 X30 F400"), remark);
    // 240 in are beyond any arm.
    assert_eq!(found("G1 X240 F40"), None);
    for stated in ["G21", "G20"] {
        let text = format!("{stated} G0 X0 Y0 Z0\nG1 X3.1255 F12");
        assert_eq!(of(&text, Dialect::GCode, &settings()).warnings.len(), 0, "{stated}");
    }
    // Behind the first moves.
    assert_eq!(found("G21\nG1 X3 F12"), None);
    assert_eq!(found("G20\nG1 X3 F12"), doubt);
    let text = "G0 X0 Y0 Z0\nG1 X3 F12";
    for (unit, x_mm) in [(LengthUnit::Mm, 3.0), (LengthUnit::Inch, 76.2)] {
        let job = Settings { unit: Some(unit), ..settings() };
        let program = of(text, Dialect::GCode, &job);
        assert_ends(&program, &[('L', [0.0; 3]), ('L', [x_mm, 0.0, 0.0])]);
        assert!((program.moves[1].feed_m_per_s - x_mm * 4.0 / 6e4).abs() < 1e-12);
        assert!(program.warnings.is_empty(), "{:?}", program.warnings);
    }
    // The program's own word holds.
    let job = Settings { unit: Some(LengthUnit::Inch), ..settings() };
    assert_ends(&of("G21 G0 X9 Y0 Z0", Dialect::GCode, &job), &[('L', [9.0, 0.0, 0.0])]);
    // In APT the job's word holds where the program has none.
    let job = Settings { unit: Some(LengthUnit::Inch), ..settings() };
    assert_ends(&of("GOTO/1,0,0", Dialect::Apt, &job), &[('L', [25.4, 0.0, 0.0])]);
    assert_ends(&of("UNITS/MM\nGOTO/1,0,0", Dialect::Apt, &job), &[('L', [1.0, 0.0, 0.0])]);
}

/// What the program sets to what only the run knows is no longer what the job assumes.
#[test]
fn what_is_assumed_holds_until_the_program_sets_it() {
    let lines = |text: &str, dialect, name: &str, value| {
        let mut job = settings();
        job.assume.insert(name.to_owned(), value);
        let read = read(text.as_bytes(), dialect, &job);
        read.map(|program| program.moves.len())
            .map_err(|found| found.iter().map(at).collect::<Vec<usize>>())
    };
    let one = Assumed::Number(1.0);
    // Data of a module that is not read, and outputs.
    let rapid = |set: &str, condition: &str, name: &str| {
        let text = module(&format!(
            "MoveL p,v5,fine,tool0;\n{set}\nIF {condition} MoveL Offs(p,1,0,0),v5,fine,tool0;"
        ));
        lines(&text, Dialect::Rapid, name, one)
    };
    assert_eq!(rapid("", "nLayer=1", "nlayer"), Ok(2));
    // 2 by then.
    assert_eq!(rapid("nLayer:=nLayer+1;", "nLayer=1", "nlayer"), Ok(1));
    assert_eq!(rapid("nLayer:=nLayer+1;", "nLayer=2", "nlayer"), Ok(2));
    for set in [
        "nLayer:=AInput(ai1);",
        "Incr nLayer;",
        "IF DInput(di9)=1 nLayer:=2;",
        "WHILE DInput(di9)=1 DO\nnLayer:=nLayer+1;\nENDWHILE",
    ] {
        let behind = 6 + set.matches('\n').count();
        assert_eq!(rapid(set, "nLayer=1", "nlayer"), Err(vec![behind]), "{set}");
    }
    assert_eq!(rapid("SetDO do1,DInput(di9);", "DOutput(do1)=1", "do1"), Err(vec![6]));
    let krl = |set: &str, condition: &str, name: &str| {
        let text = format!(
            "DEF p()\n$VEL.CP=0.1\nPTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\n{set}\nIF {condition} THEN\n\
             LIN_REL {{X 1}}\nENDIF\nEND\n"
        );
        lines(&text, Dialect::Krl, name, one)
    };
    assert_eq!(krl("", "N==1", "n"), Ok(2));
    assert_eq!(krl("N=$ANIN[1]", "N==1", "n"), Err(vec![5]));
    assert_eq!(krl("IF $IN[1] THEN\nN=2\nENDIF", "N==1", "n"), Err(vec![7]));
    assert_eq!(krl("N[I]=2", "N[1]==1", "n[1]"), Err(vec![5]));
    let tp = |set: &str, condition: &str, name: &str| {
        let text = format!(
            "/PROG A\n/MN\nL P[1] 9mm/sec FINE ;\n{set} ;\nIF {condition},JMP LBL[1] ;\n\
             L P[1] 9mm/sec FINE ;\nLBL[1] ;\n/POS\nP[1]{{\n GP1:\n UF : 0, UT : 0, CONFIG : 'N U \
             T, 0, 0, 0',\n X = 0 mm, Y = 0 mm, Z = 0 mm, W = 180 deg, P = 0 deg, R = 0 deg\n}};\n\
             /END\n"
        );
        lines(&text, Dialect::Fanuc, name, one)
    };
    assert_eq!(tp("R[2]=5", "R[1]=1", "r[1]"), Ok(1));
    assert_eq!(tp("R[1]=AI[1]", "R[1]=1", "r[1]"), Err(vec![5]));
    assert_eq!(tp("IF DI[1]=ON,R[1]=4", "R[1]=1", "r[1]"), Err(vec![5]));
    assert_eq!(tp("DO[3]=DI[7]", "DO[3]=ON", "do[3]"), Err(vec![5]));
    assert_eq!(tp("DO[R[9]]=ON", "DO[3]=ON", "do[3]"), Err(vec![5]));
    // What it sets to a number is that.
    assert_eq!(tp("R[1]=AI[1] ;\nR[1]=1", "R[1]=1", "r[1]"), Ok(1));
}

#[test]
fn a_spindle_of_speed_zero_stands() {
    let program = of("G21 S0 M3\nG0 X0 Y0 Z0\nG1 X9 F400", Dialect::GCode, &settings());
    assert_eq!(program.moves[1].stated.spindle, Some(Spindle::Stands));
    assert!(!program.moves[1].spindle_turns);
}

/// What was passed over as harmless and is not.
#[test]
fn words_that_change_place_speed_or_stiffness_are_not_passed_over() {
    let gcode = |block: &str| {
        let text = format!("G21 G0 X0 Y0 Z0\n{block}\nG1 X9 F400\nM2\n");
        read(text.as_bytes(), Dialect::GCode, &settings())
    };
    assert!(gcode("G50").unwrap().warnings.is_empty());
    let found = gcode("G50 X100").unwrap_err();
    assert!(found[0].what.contains("G50 with axes") && at(&found[0]) == 2, "{found:?}");
    let rapid = |call: &str| {
        let text = module(&format!("MoveL p,v5,fine,tool0;\n{call}\nMoveL p,v5,fine,tool0;"));
        told(&of(&text, Dialect::Rapid, &settings()), Code::ChangeIgnored)
    };
    for call in ["SoftAct 3,90;", "TuneServo ROB_1,1,110\\Type:=TUNE_KP;", "SpeedLimAxis 1,3,10;"] {
        assert_eq!(rapid(call), [5], "{call}");
    }
    assert_eq!(rapid("SoftDeact;"), NONE);
    let tp = "/PROG A\n/MN\nL P[1] 9mm/sec FINE ;\nJOINT_MAX_SPEED[5]=5 ;\nL P[1] 9mm/sec FINE ;\n/POS\n\
              P[1]{\n GP1:\n UF : 0, UT : 0, CONFIG : 'N U T, 0, 0, 0',\n X = 0 mm, Y = 0 mm, Z = 0 mm, \
              W = 180 deg, P = 0 deg, R = 0 deg\n};\n/END\n";
    let found = read(tp.as_bytes(), Dialect::Fanuc, &settings()).unwrap();
    assert_eq!(told(&found, Code::ChangeIgnored), [5]);
    let what = found.warnings.iter().find(|note| at(note) == 5).unwrap().what.clone();
    assert!(what.contains("JOINT_MAX_SPEED of line 4 may slow this move"), "{what}");
}

/// RoboDK writes frames by the components of a position register.
#[test]
fn frames_that_a_tp_program_sets_are_its_own() {
    let tp = |sets: &str| {
        let text = format!(
            "/PROG A\n/MN\n{sets}UFRAME_NUM=9 ;\nUTOOL_NUM=9 ;\nL P[1] 9mm/sec FINE ;\n/POS\nP[1]{{\n \
             GP1:\n UF : 9, UT : 9, CONFIG : 'N U T, 0, 0, 0',\n X = 5 mm, Y = 0 mm, Z = 0 mm, W = 0 \
             deg, P = 0 deg, R = 0 deg\n}};\n/END\n"
        );
        let job = Settings { tcp: Some(Isometry3::translation(0.0, 0.0, 0.3)), ..settings() };
        read(text.as_bytes(), Dialect::Fanuc, &job)
    };
    let component = |index: usize, value: &str| format!("PR[9,{index}]={value} ;\n");
    let all: String =
        (1..=6).map(|i| component(i, ["720", "(-120)", "420", "0", "0", "90"][i - 1])).collect();
    let sets = format!("{all}UFRAME[9]=PR[9] ;\nPR[9,6]=0 ;\nUTOOL[9]=PR[9] ;\n");
    let program = tp(&sets).unwrap();
    assert_ends(&program, &[('L', [720.0, -115.0, 420.0])]);
    assert!((program.moves[0].tcp.translation.vector.norm() - 0.84_f64).abs() < 0.01);
    // What is not known of it is no frame.
    for (sets, said) in [
        (format!("{}UFRAME[9]=PR[9] ;\n", component(1, "720")), "not known as a pose"),
        (format!("{all}PR[9]=LPOS ;\nUFRAME[9]=PR[9] ;\n"), "not known as a pose"),
        (format!("{all}PR[9,1]=R[5] ;\nUFRAME[9]=PR[9] ;\n"), "not known as a pose"),
        (format!("{all}IF DI[1]=ON,PR[9]=P[1] ;\nUFRAME[9]=PR[9] ;\n"), "not known as a pose"),
        ("UFRAME[9]=UFRAME[1] ;\n".to_owned(), "is set to what is not PR[n]"),
    ] {
        let found = tp(&sets).unwrap_err();
        assert!(found.iter().any(|note| note.what.contains(said)), "{sets}: {found:?}");
    }
}

/// The first offset holds until the program chooses another: a choice behind its moves is a change.
#[test]
fn a_work_offset_chosen_behind_moves_is_a_change() {
    let changed = |body: &str| {
        let text = format!("G21 G0 X0 Y0 Z0\nG1 X50 F400\n{body}\nG1 X60");
        told(&of(&text, Dialect::GCode, &settings()), Code::ChangeIgnored)
    };
    assert_eq!(changed("G55"), [3]);
    assert_eq!(changed("G54"), NONE);
    assert_eq!(changed("G55\nX70\nG54"), [3]);
    // Before any move, it is the one that the job's work object stands for.
    let text = "G21 G55\nG0 X0 Y0 Z0\nG1 X50 F400";
    assert_eq!(told(&of(text, Dialect::GCode, &settings()), Code::ChangeIgnored), NONE);
}

/// The offset under which the path starts is the job's work object, whatever was chosen before; but
/// axes that were given under another one are elsewhere.
#[test]
fn a_work_offset_chosen_before_the_path_starts_is_no_change() {
    let cut = "G0 X0 Y0 Z5\nG1 X9 F100";
    for (text, dialect, lines) in [
        (format!("G21 G90 G55\nG54\n{cut}"), Dialect::GCode, vec![]),
        (format!("G71 G90 G500\nT1 M6\nD1 G54\n{cut}"), Dialect::Sinumerik, vec![]),
        (format!("G21 G90 G54\nG53 G0 Z0\nG55\n{cut}"), Dialect::GCode, vec![]),
        (format!("G21 G90 G54 G0 Z50\nG55\nG0 X0 Y0\n{cut}"), Dialect::GCode, vec![3]),
        ("G21 G90 G54 G0 Z50\nG55\nX0 Y0 Z5\nG1 X9 F100".to_owned(), Dialect::GCode, vec![]),
        ("G21 G90 G54 G0 Z50 X0\nG55\nX9 Z5\nY0\nG1 X9 F100".to_owned(), Dialect::GCode, vec![]),
        (format!("G21 G90 G0 Z50\nG55 X0 Y0\n{cut}"), Dialect::GCode, vec![2]),
        (format!("G21 G90 G55\nG54\n{cut}\nG55\nX20"), Dialect::GCode, vec![5]),
    ] {
        let program = of(&text, dialect, &settings());
        assert_eq!(told(&program, Code::ChangeIgnored), lines, "{text}");
    }
}

#[test]
fn tapping_passes_speeds_that_are_not_checked() {
    for code in ["G84", "G74"] {
        let text = format!("G21 G0 X0 Y0 Z9\nS900 M3\nG95\n{code} X5 Z-4 R2 F1\nG80\nG0 Z9");
        let program = of(&text, Dialect::GCode, &settings());
        assert_eq!(told(&program, Code::SpindleCommand), [4], "{code}");
    }
    let bored = "G21 G0 X0 Y0 Z9\nS900 M3\nG85 X5 Z-4 R2 F90\nG80\nG0 Z9";
    assert_eq!(told(&of(bored, Dialect::GCode, &settings()), Code::SpindleCommand), NONE);
    let apt = "UNITS/MM\nSPINDL/900\nFEDRAT/90\nGOTO/0,0,9\n\
               CYCLE/TAP,DEPTH,4,MMPR,1,CLEAR,2\nGOTO/5,0,0\nCYCLE/OFF";
    assert_eq!(told(&of(apt, Dialect::Apt, &settings()), Code::SpindleCommand), [6]);
}

/// As in G-code; all numbers of APT have many decimals, so that these say nothing.
#[test]
fn apt_without_a_unit_is_a_doubt_where_it_looks_like_inches() {
    let told = |head: &str, feed: &str, to: &str| {
        let text = format!("{head}\nFEDRAT/{feed}\nGOTO/0,0,0\nGOTO/{to},0,0");
        let program = of(&text, Dialect::Apt, &settings());
        told(&program, Code::UnitAssumed)
    };
    assert_eq!(told("", "20", "3.1250"), [3]);
    assert_eq!(told("", "40", "100.0"), [3]);
    assert_eq!(told("", "400", "100.1255"), NONE);
    assert_eq!(told("UNITS/MM", "20", "3.1250"), NONE);
    assert_eq!(told("UNITS/INCHES", "20", "3.1250"), NONE);
    assert_eq!(told("", "20,MMPM", "3.1250"), NONE);
}
