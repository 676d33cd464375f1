//! What was once read wrongly without a word: cutting before the place is known, units and speeds in
//! the forms of CAM systems, files that were cut off, dwells, codes that start the spindle unseen.

use detune::motion::Timing;
use detune::notes::{Class, Code, Note};
use detune::program::{
    Dialect, DwellUnit, NewSpeed, Program, Rewrite, Settings, Spindle, read, rewrite,
};

use super::support::{assert_ends, at, ended, faults, module, rapid, settings};

fn of(text: &str, dialect: Dialect) -> Program {
    read(ended(text, dialect).as_bytes(), dialect, &settings()).unwrap()
}

#[test]
fn cutting_before_the_place_is_known_is_a_fault_and_rapids_are_silent() {
    let found = faults("G0 X0 Y0\nG1 X300 F100\nX0\nG0 Z5\n", Dialect::GCode);
    assert_eq!((at(&found[0]), found.len()), (2, 1), "{found:?}");
    assert!(found[0].what.contains("while Z is not known"), "{}", found[0].what);
    assert!(found[0].what.ends_with("line 3 likewise"), "{}", found[0].what);
    let program = of("G21 G90\nG0 Z5\nG0 X1 Y2\nG1 Z0 F100\n", Dialect::GCode);
    assert_ends(&program, &[('L', [1.0, 2.0, 5.0]), ('L', [1.0, 2.0, 0.0])]);
    assert!(program.warnings.is_empty(), "{:?}", program.warnings);
}

#[test]
fn external_axes_that_stand_are_silent_and_those_that_move_are_refused() {
    let target = |x: f64, track: f64| {
        format!("[[{x},0,500],[0,0,1,0],[0,0,0,0],[{track},9E9,9E9,9E9,9E9,9E9]]")
    };
    let program = |second: f64| {
        let (a, b) = (target(500.0, 3400.0), target(510.0, second));
        module(&format!("MoveL {a},v5,fine,tool0;\nMoveL {b},v5,fine,tool0;"))
    };
    assert!(rapid(&program(3400.0)).warnings.is_empty());
    let found = faults(&program(738.0), Dialect::Rapid);
    assert_eq!((at(&found[0]), found.len()), (5, 1), "{found:?}");
    let said = "external axis eax_a moves from 3400 to 738; write external_axes: {eax_a: …}";
    assert!(found[0].what.contains(said), "{}", found[0].what);
}

#[test]
fn units_and_speeds_in_the_forms_of_cam_systems() {
    for unit in ["UNIT/INCHES", "UNITS/INCHES", "UNIT/INCH"] {
        let program = of(&format!("{unit}\nGOTO/1,0,0"), Dialect::Apt);
        assert_ends(&program, &[('L', [25.4, 0.0, 0.0])]);
    }
    for form in [
        "SPINDL/780,RPM,CLW",
        "SPINDL/RPM,780,CLW",
        "SPINDL/RANGE,2,RPM,780,CLW",
        "SPINDL/RPM, 780.0, CLW, RANGE, LOW",
        "SPINDL/780,CLW,MAXRPM,5000",
        "SPINDL/MAXRPM,5000,RPM,780",
    ] {
        let program = of(&format!("{form}\nGOTO/1,0,0"), Dialect::Apt);
        assert_eq!(program.spindle[0].spindle, Spindle::Turns(Some(780.0)), "{form}");
    }
    // A quarter turn about z, and 100 mm along x: the same place by other coordinates.
    let systems = |coordinates| {
        let text = "CSYS/1,0,0,0,0,1,0,0,0,0,1,0\nGOTO/10,20,30\n\
                    CSYS/0,-1,0,100,1,0,0,0,0,0,1,0\nGOTO/10,20,30";
        let settings = Settings { coordinates, ..settings() };
        read(ended(text, Dialect::Apt).as_bytes(), Dialect::Apt, &settings)
    };
    let found = systems(None).unwrap_err();
    assert_eq!((at(&found[0]), found.len()), (3, 1), "{found:?}");
    let world = systems(Some(detune::program::Coordinates::World)).unwrap();
    assert_ends(&world, &[('L', [10.0, 20.0, 30.0]), ('L', [10.0, 20.0, 30.0])]);
    let local = systems(Some(detune::program::Coordinates::Local)).unwrap();
    assert_ends(&local, &[('L', [10.0, 20.0, 30.0]), ('L', [80.0, 10.0, 30.0])]);
}

/// Numbers that only look like speeds stay, and those that are speeds in another form are found.
#[test]
fn what_is_rewritten_is_what_was_read() {
    let rewritten = |text: &str, dialect| {
        let to = Rewrite {
            speeds: vec![NewSpeed { end: usize::MAX, rpm: 984.0, job_rpm: None }],
            keeps_chip_load: false,
        };
        let found = rewrite(text.as_bytes(), dialect, &settings(), &to).unwrap();
        String::from_utf8(found.bytes).unwrap()
    };
    for (text, dialect) in [
        ("G0 X0 Y0 Z0\nM3\nG4 P1. S780\nG1 X9 F100\nM30\n", Dialect::GCode),
        ("M3 S[700+80]\nS 78 (0) 0\nG0 X0 Y0 Z0\nG1 X9 F100\nM30\n", Dialect::GCode),
        ("O100 SUB\nS780 M3\nO100 ENDSUB\nO100 CALL\nG0 X0 Y0 Z0\nG1 X9 F1\nM30\n", Dialect::GCode),
        ("SPINDL/RANGE,780,RPM,780,CLW\nGOTO/0,0,0\nGOTO/1,0,0\nFINI\n", Dialect::Apt),
        (
            "PPRINT SPINDL/780 $\nSPINDL/ $\n 780 ,RPM,RANGE,780\nINSERT S780/F780\nGOTO/0,0,0\n\
             GOTO/1,0,0\nFINI\n",
            Dialect::Apt,
        ),
    ] {
        let expected = match dialect {
            Dialect::Apt if text.starts_with("PPRINT") => text.replace("$\n 780 ", "$\n 984 "),
            Dialect::Apt => text.replace("RPM,780", "RPM,984"),
            _ if text.contains("78 (0) 0") => text.replace("78 (0) 0", "984"),
            _ => text.replace("S780", "S984"),
        };
        assert_eq!(rewritten(text, dialect), expected);
    }
}

#[test]
fn files_that_were_cut_off_are_refused_and_what_follows_the_end_is_not_read() {
    let read = |text: &str, dialect| read(text.as_bytes(), dialect, &settings());
    for (text, dialect) in [
        ("G0 X0 Y0 Z0\nG1 X9 F1\n", Dialect::GCode),
        ("%\nG0 X0 Y0 Z0\nG1 X9 F1\n", Dialect::GCode),
        ("G0 X0 Y0 Z0\nG1 X9 F1\nG1 X", Dialect::GCode),
        ("GOTO/0,0,0\nGOTO/1,0,0\n", Dialect::Apt),
        ("GOTO/0,0,0\nGOTO/1,0,$\n", Dialect::Apt),
        ("DEF a()\nPTP {A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}\n", Dialect::Krl),
    ] {
        let found = read(text, dialect).unwrap_err();
        assert!(found.iter().any(|note| note.what.contains("is the file whole?")), "{found:?}");
    }
    for text in [
        "%\nG0 X0 Y0 Z0\nG1 X9 F1\n%\nG1 X99\n",
        "G0 X0 Y0 Z0\nG1 X9 F1\n%\nG1 X99\n",
        "G0 X0 Y0 Z0\nG1 X9 F1\nM2\nG1 X99\n",
    ] {
        assert_eq!(read(text, Dialect::GCode).unwrap().moves.len(), 2, "{text}");
    }
    assert_eq!(read("GOTO/0,0,0\nFINI\nGOTO/1,0,0\n", Dialect::Apt).unwrap().moves.len(), 1);
}

#[test]
fn a_code_that_is_not_known_and_has_a_speed_starts_the_spindle() {
    let program = of("M5\nG0 X0 Y0 Z0\nM103 S780\nG1 X9 F1", Dialect::GCode);
    assert_eq!(program.spindle.last().unwrap().spindle, Spindle::Turns(Some(780.0)));
    assert!(program.moves[1].spindle_turns);
    let note = program.warnings.iter().find(|note| note.what.contains("M103")).unwrap();
    assert_eq!((note.code, at(note)), (Code::SpindleCommand, 3));
    // Without a speed it may start it, too: a doubt, not a remark.
    let program = of("G21 M5\nG0 X0 Y0 Z0\nM103\nG1 X9 F1", Dialect::GCode);
    assert_eq!(program.warnings[0].code, Code::SpindleCommand);
    // A speed without a start: nothing has stopped it.
    let program = of("S780\nG0 X0 Y0 Z0\nG1 X9 F1", Dialect::GCode);
    assert_eq!(program.moves[1].stated.spindle, Some(Spindle::Turns(Some(780.0))));
}

#[test]
fn dwells_take_their_time() {
    let rapid = module(
        "MoveL p,v5,fine,tool0;\nWaitTime 1.5;\nWaitTime\\InPos,.25;\nMoveL p,v5,fine,tool0;",
    );
    let seconds = |text: &str, dialect| -> Vec<f64> {
        let moves = of(text, dialect).moves;
        let dwells = moves.iter().filter_map(|each| match each.timing {
            Timing::Seconds(seconds) => Some(seconds),
            _ => None,
        });
        dwells.collect()
    };
    assert_eq!(seconds(&rapid, Dialect::Rapid), [1.5, 0.25]);
    let gcode = "G4 P9.\nG0 X0 Y0 Z9\nS600 M3\nG4 P2.\nG4 P0\nG4 X0.5\nG4 P150.\nG4 S20\n\
                 G82 X1 Z-1 R1 P0.3 F50\nG80\n";
    assert_eq!(seconds(gcode, Dialect::GCode), [2.0, 0.5, 150.0, 2.0, 0.3]);
    let heidenhain = "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n2 CYCL DEF 9.0 DWELL TIME\n\
                      3 CYCL DEF 9.1 DWELL 0,5\n4 END PGM A MM\n";
    let moves = read(heidenhain.as_bytes(), Dialect::Heidenhain, &settings()).unwrap().moves;
    assert_eq!(moves[1].timing, Timing::Seconds(0.5));
    let apt = "GOTO/0,0,0\nDELAY/2\nSPINDL/600\nDELAY/5,REV\nCYCLE/DRILL,DEPTH,5,CLEAR,1,DWELL,.5\n\
               GOTO/1,0,0\nCYCLE/OFF\n";
    assert_eq!(seconds(apt, Dialect::Apt), [2.0, 0.5, 0.5]);
}

/// LinuxCNC dwells and then moves, on Fanuc X beside G4 is the time: what is meant is not clear.
#[test]
fn a_dwell_beside_a_move_is_refused() {
    for block in [
        "G4 P.5 G1 X50 Y50",
        "G1 X50 G4 P.5",
        "G4 P.5 X50",
        "G4 X.5 Y50",
        "G4 X.5 G0",
        "G2 I9 G4 P1.",
    ] {
        let found = faults(&format!("G0 X0 Y0 Z0\n{block}\nG1 X0\n"), Dialect::GCode);
        assert_eq!((at(&found[0]), found.len()), (2, 1), "{block}: {found:?}");
        assert!(found[0].what.contains("G4 beside a move"), "{block}: {}", found[0].what);
    }
}

/// LinuxCNC's M70, M72 and M73 bring back units, feed and G91; G53 keeps the feed there, and
/// SUPA and M91 everywhere. To Haas and Fanuc most of these are other things, so they leave a doubt.
#[test]
fn what_other_controllers_read_otherwise_leaves_a_doubt() {
    let heidenhain = |word: &str| {
        format!(
            "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n2 L X+9 F600\n3 L X+50 {word}\n4 END PGM A MM\n"
        )
    };
    let gcode = |block: &str| format!("G0 X0 Y0 Z0\nG1 X9 F600\n{block}\n");
    let sinumerik = |block: &str| format!("G710 G90 G17\nG0 X0 Y0 Z0\nG1 X9 F600\n{block}\n");
    for (text, dialect, code) in [
        (gcode("M70\nX0\nM72"), Dialect::GCode, Code::ChangeIgnored),
        (gcode("M73"), Dialect::GCode, Code::ChangeIgnored),
        (gcode("G53 X100"), Dialect::GCode, Code::MotionLeftOut),
        (sinumerik("SUPA X50"), Dialect::Sinumerik, Code::MotionLeftOut),
        (sinumerik("G153 X50"), Dialect::Sinumerik, Code::MotionLeftOut),
        (heidenhain("M91"), Dialect::Heidenhain, Code::MotionLeftOut),
        (heidenhain("M92"), Dialect::Heidenhain, Code::MotionLeftOut),
    ] {
        let found = of(&text, dialect).warnings;
        let is_doubt = |note: &Note| note.code == code && code.class() == Class::Doubt;
        assert!(found.iter().any(is_doubt), "{text}{found:?}");
    }
    for (text, dialect) in [
        (gcode("G53 G0 Z0"), Dialect::GCode),
        (sinumerik("SUPA G0 Z50"), Dialect::Sinumerik),
        (heidenhain("FMAX M91"), Dialect::Heidenhain),
    ] {
        let found = of(&text, dialect).warnings;
        assert!(found.iter().all(|note| note.code.class() != Class::Doubt), "{text}{found:?}");
    }
    let found = faults(&gcode("M98 P1000 Q5"), Dialect::GCode);
    assert!(found[0].what.contains("M98 with Q"), "{}", found[0].what);
}

/// LinuxCNC's manual has P of G4 in seconds, Fanuc's and Haas's in milliseconds without a point.
#[test]
fn a_dwell_without_a_decimal_point_takes_its_unit_from_the_job() {
    let text = "G0 X0 Y0 Z0\nG4 P500\nX1\nM2\n";
    for (p, seconds, unit) in [("P500", 0.5, "milliseconds"), ("P2", 2.0, "seconds")] {
        let text = text.replace("P500", p);
        let program = read(text.as_bytes(), Dialect::GCode, &settings()).unwrap();
        assert_eq!(program.moves[1].timing, Timing::Seconds(seconds));
        let told = |note: &Note| note.what.contains(&format!("{p} of a dwell is taken as {unit}"));
        assert!(program.warnings.iter().any(told), "{:?}", program.warnings);
        // A spindle's schedule runs by that time.
        for (is_scheduled, class) in [(false, Class::Remark), (true, Class::Doubt)] {
            let job = Settings { is_scheduled, ..settings() };
            let notes = read(text.as_bytes(), Dialect::GCode, &job).unwrap().warnings;
            assert!(notes.iter().any(|note| told(note) && note.code.class() == class), "{notes:?}");
        }
    }
    for (unit, seconds) in [(DwellUnit::Seconds, 500.0), (DwellUnit::Milliseconds, 0.5)] {
        let job = Settings { dwell_unit: Some(unit), ..settings() };
        let moves = read(text.as_bytes(), Dialect::GCode, &job).unwrap().moves;
        assert_eq!(moves[1].timing, Timing::Seconds(seconds));
    }
}

/// The centre (0, 0), the radius 10: a quarter, three quarters, and half a turn by CATIA's form.
#[test]
fn arcs_of_cam_systems_bend_the_right_way() {
    let half = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    for (text, vias) in [
        ("CIRCLE/0,0,0,0,0,1,10,0.06,0.5\nGOTO/0,10,0", vec![[half, half, 0.0]]),
        ("MOVARC/0,0,0,0,0,1,10,ANGLE,90\nGOTO/0,10,0", vec![[half, half, 0.0]]),
        ("MOVARC/0,0,0,0,0,1,10,90\nGOTO/0,10,0", vec![[half, half, 0.0]]),
        ("MOVARC/CENTER,0,0,0,AXIS,0,0,1,RADIUS,10,ANGLE,90\nGOTO/0,10,0", vec![[half, half, 0.0]]),
        // Some posts leave the axis as it is where the arc runs clockwise: the angle tells.
        ("MOVARC/0,0,0,0,0,1,10,ANGLE,90\nGOTO/0,-10,0", vec![[half, -half, 0.0]]),
        // Three quarters in two pieces: by −67.5° and −202.5°.
        (
            "CIRCLE/0,0,0,0,0,-1,10\nGOTO/0,10,0",
            vec![
                [10.0 * 67.5_f64.to_radians().cos(), -10.0 * 67.5_f64.to_radians().sin(), 0.0],
                [-10.0 * 22.5_f64.to_radians().cos(), 10.0 * 22.5_f64.to_radians().sin(), 0.0],
            ],
        ),
        (
            "INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,$\n 10),ON,(LINE/0,0,0,$\n 0,10,0)",
            vec![[half, half, 0.0]],
        ),
        (
            "INDIRV/0,-1,0\nTLON,GOFWD/ CIRCLE/0,0,0,10,ON,LINE/0,0,0,0,-10,0",
            vec![[half, -half, 0.0]],
        ),
    ] {
        let program = of(&format!("GOTO/10,0,0\n{text}"), Dialect::Apt);
        let found: Vec<_> = program.moves[1..]
            .iter()
            .map(|each| match &each.to {
                detune::motion::Target::Arc { via, .. } => via.translation.vector * 1e3,
                other => panic!("{text}: {other:?}"),
            })
            .collect();
        assert_eq!(found.len(), vias.len(), "{text}");
        for (found, via) in found.iter().zip(vias) {
            assert!((found - nalgebra::Vector3::from(via)).norm() < 1e-6, "{text} {found:?}");
        }
    }
}

/// A position that is in no file leaves nothing for components that are left out to stay at.
#[test]
fn components_left_out_behind_a_skipped_motion_are_refused() {
    let krl = |behind: &str| {
        format!(
            "DEF p()\n$VEL.CP=0.1\nPTP {{X 500,Y 0,Z 500,A 0,B 90,C 0}}\nLIN {{X 510}}\n\
             PTP XHOME\n{behind}\nLIN {{X 510}}\nEND\n"
        )
    };
    let whole = of(&krl("PTP {X 9,Y 0,Z 500,A 0,B 90,C 0}"), Dialect::Krl);
    assert_eq!(whole.moves.len(), 4);
    for behind in ["PTP {X 9}", "PTP_REL {X 9}"] {
        let found = faults(&krl(behind), Dialect::Krl);
        assert_eq!(at(&found[0]), 6, "{found:?}");
        assert!(found[0].what.contains("a position that is in no file"), "{found:?}");
    }
}

#[test]
fn pecks_of_a_cycle_that_is_not_deep_are_a_doubt() {
    let told = |kind: &str| {
        let text = format!("GOTO/0,0,9\nCYCLE/{kind},DEPTH,20,MMPM,100,CLEAR,2,STEP,5\nGOTO/5,0,0");
        let program = of(&text, Dialect::Apt);
        let notes = program.warnings.iter().filter(|note| note.what.contains("STEP"));
        notes.map(|note| (note.code, at(note))).collect::<Vec<_>>()
    };
    assert_eq!(told("DRILL"), [(Code::MotionLeftOut, 2)]);
    assert_eq!(told("BRKCHP"), [(Code::MotionLeftOut, 2)]);
    assert_eq!(told("DEEP"), []);
}

/// Controllers differ in how fast a bore is left above R.
#[test]
fn the_way_out_of_a_bore_is_told() {
    let told = |text: &str| {
        let program = of(&format!("G21 G90\nG0 X0 Y0 Z10\n{text}"), Dialect::GCode);
        program.warnings.iter().filter(|note| note.what.contains("G85 and G89")).count()
    };
    assert_eq!(told("G98 G85 X5 Y0 Z-5 R2 F100\n"), 1);
    assert_eq!(told("G98 G89 X5 Y0 Z-5 R2 F100 P1.5\n"), 1);
    assert_eq!(told("G99 G85 X5 Y0 Z-5 R2 F100\n"), 0);
    assert_eq!(told("G98 G81 X5 Y0 Z-5 R2 F100\n"), 0);
}
