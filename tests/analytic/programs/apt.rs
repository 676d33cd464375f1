//! APT and cutter location files: continuation, tool axes, cycles, units.

use detune::motion::Target;
use detune::notes::Code;
use detune::program::{Dialect, Settings, Spindle, SpindleCommand, read};
use nalgebra::Vector3;

use super::support::{assert_ends, assert_pose, at, end, ended, faults, lines, pose, settings};

const CONTOUR: &[u8] = include_bytes!("../../data/programs/contour.apt");

fn apt(text: &str) -> detune::program::Program {
    read(ended(text, Dialect::Apt).as_bytes(), Dialect::Apt, &settings()).unwrap()
}

#[test]
fn contour_with_holes() {
    let program = read(CONTOUR, Dialect::Apt, &settings()).unwrap();
    assert_ends(
        &program,
        &[
            ('L', [0.0, 0.0, 100.0]),
            ('L', [10.0, 20.0, 5.0]),
            ('L', [10.0, 20.0, -1.0]),
            ('L', [30.0, 20.0, -1.0]),
            ('L', [30.0, 25.0, -1.0]),
            ('L', [30.0, 25.0, 50.0]),
            // RTRCTO is 20 mm: level at the height where the tool is, as that is higher.
            ('L', [50.0, 0.0, 50.0]),
            ('L', [50.0, 0.0, 3.0]),
            // Five pecks of 2 mm.
            ('L', [50.0, 0.0, -2.0]),
            ('L', [50.0, 0.0, 3.0]),
            ('L', [50.0, 0.0, -2.0]),
            ('L', [50.0, 0.0, -4.0]),
            ('L', [50.0, 0.0, 3.0]),
            ('L', [50.0, 0.0, -4.0]),
            ('L', [50.0, 0.0, -6.0]),
            ('L', [50.0, 0.0, 3.0]),
            ('L', [50.0, 0.0, -6.0]),
            ('L', [50.0, 0.0, -8.0]),
            ('L', [50.0, 0.0, 3.0]),
            ('L', [50.0, 0.0, -8.0]),
            ('L', [50.0, 0.0, -10.0]),
            ('L', [50.0, 0.0, 3.0]),
            ('L', [50.0, 0.0, 20.0]),
            ('L', [60.0, 0.0, 2.0]),
            ('L', [60.0, 0.0, -4.0]),
            ('L', [60.0, 0.0, 2.0]),
            ('L', [25.4, 0.0, 25.4]),
        ],
    );
    let of_pecks = [21; 17];
    let expected = [&[8, 10, 11, 15, 17, 18], &of_pecks[..], &[23, 23, 23, 28]].concat();
    assert_eq!(lines(&program), expected);
    // 0.1 mm a revolution at 3500 rev/min is 350 mm/min; 10 in/min is 254 mm/min.
    let mm_per_min = [
        &[30e3, 30e3, 300.0, 300.0, 350.0, 350.0, 30e3, 30e3][..],
        &[250.0, 30e3, 30e3].repeat(4),
        &[250.0, 30e3, 30e3, 30e3, 350.0, 350.0, 254.0],
    ]
    .concat();
    for (each, expected) in program.moves.iter().zip(mm_per_min) {
        assert!((each.feed_m_per_s * 6e4 - expected).abs() < 1e-9, "{each:?}");
    }
    assert_eq!(
        program.spindle,
        [
            SpindleCommand { line: 6, spindle: Spindle::Turns(Some(3500.0)), from_move: 0 },
            SpindleCommand { line: 25, spindle: Spindle::Stands, from_move: 26 },
        ]
    );
    // Fourteen after the first, see the feeds above.
    let [notice, retract, stands, behind] = program.warnings.as_slice() else {
        panic!("{:?}", program.warnings)
    };
    assert_eq!((at(notice), at(retract), at(stands), at(behind)), (10, 22, 28, 31));
    assert!(retract.what.contains("RTRCTO without a length"), "{retract}");
    assert!(stands.what.contains("with the spindle stopped (by line 25)"), "{stands}");
    assert!(notice.what.starts_with("14 rapid moves"), "{notice}");
    assert_eq!(behind.code, Code::MotionLeftOut);
}

#[test]
fn the_tool_looks_against_its_axis_and_turns_least() {
    let program = read(CONTOUR, Dialect::Apt, &settings()).unwrap();
    let turned = |index: usize| end(&program.moves[index]).1.rotation;
    // Down with x along the work object's x: half a turn about x.
    assert_pose(&end(&program.moves[0]).1, &pose([0.0, 0.0, 100.0], [0.0, 1.0, 0.0, 0.0]));
    // 45° towards y: the tool turns about x alone, so x stays and z is −(0, 1, 1)/√2.
    assert!((turned(3) * Vector3::x() - Vector3::x()).norm() < 1e-8);
    let z = Vector3::new(0.0, -1.0, -1.0).normalize();
    assert!((turned(3) * Vector3::z() - z).norm() < 1e-8);
    // The axis stays for GODLTA, and the way back ends where it began.
    assert!(turned(4).angle_to(&turned(3)) < 1e-12);
    assert!(turned(5).angle_to(&turned(0)) < 1e-8);
}

#[test]
fn poses_stand_in_the_job_s_work_object_and_carry_its_tcp() {
    // A quarter turn about z at (1000, 0, 500) mm: (10, 0, 0) stands at (1000, 10, 500).
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let job = Settings {
        work_object: Some(pose([1000.0, 0.0, 500.0], [half, 0.0, 0.0, half])),
        tcp: Some(pose([0.0, 0.0, 120.0], [1.0, 0.0, 0.0, 0.0])),
        ..settings()
    };
    let program = read(b"GOTO/10,0,0\nFINI\n", Dialect::Apt, &job).unwrap();
    assert_pose(&end(&program.moves[0]).1, &pose([1000.0, 10.0, 500.0], [0.0, half, half, 0.0]));
    assert_pose(&program.moves[0].tcp, &pose([0.0, 0.0, 120.0], [1.0, 0.0, 0.0, 0.0]));
    // No FEDRAT: the job's feed.
    assert_eq!(program.moves[0].feed_m_per_s, 0.01);
}

#[test]
fn what_is_lost_or_computed_is_refused_with_its_line() {
    for (statement, said) in [
        ("CIRCLE/0,0,0,0,0,1,5", "the radius is 5 mm"),
        ("CIRCLE/5,0,0,0,0,1,5", "no GOTO follows"),
        ("CIRCLE/5,0,0,0,0,2,5", "length 2.0000"),
        ("CIRCLE/5,0,0,5", "expected x, y, z, i, j, k"),
        ("TLON,GOFWD/(CIRCLE/0,0,0,$\n5),ON,(LINE/0,0,0,1,1,1)", "INDIRV is missing"),
        ("FOO/1", "is not understood and may move"),
        ("TRACUT/MX1", "GOTO points"),
        ("GOTO/P1", "as numbers"),
        ("GOTO/1,2", "as numbers"),
        ("GOTO/1,2,3,4", "or x, y, z, i, j, k"),
        ("GOTO/1,2,3,0,0,2", "length 2.0000"),
        ("GOTO/1,2,inf", "as numbers"),
        ("FEDRAT/0,MMPM", "must be positive"),
        ("FEDRAT/5,FURLONG", "unit of feed"),
        ("FEDRAT/A,B,3", "a number and a unit"),
        ("SPINDL/-5,RPM", "must not be negative"),
        ("SPINDL/RPM,5,FAST", "'FAST' is not understood"),
        ("SPINDL/5,RPM,7", "which of them"),
        ("SPINDL/3721,RPM,CLW,MAXRPM,3700", "3721 rpm is above the largest speed there, 3700 rpm"),
        ("UNITS/CM", "CM is not supported"),
        ("CYCLE/DRILL,10,100,2,9,MMPM", "numbers without keywords"),
        ("CYCLE/DRILL,CLEAR,2", "depth is missing"),
        ("CYCLE/MILL,DEPTH,2", "'MILL' is not understood"),
        ("GOABS/1,2,3", "GOTO points"),
        ("LCS/ON", "GOTO points"),
        ("MSYS/0,0,500,1,0,0,0,1,0", "MSYS: a coordinate system behind motion"),
        ("GOHOME/1,2", "as numbers"),
    ] {
        let found = faults(&format!("GOTO/0,0,0\r\n\r\n{statement}\r\n"), Dialect::Apt);
        assert_eq!(found.len(), 1, "{statement}: {found:?}");
        assert_eq!(at(&found[0]), 3, "{statement}");
        assert!(found[0].what.contains(said), "{statement}: {}", found[0].what);
    }
    let relative = faults("GODLTA/1,0,0", Dialect::Apt);
    assert!(relative[0].what.contains("before any position"));
    let per_turn = faults("FEDRAT/0.1,MMPR\nGOTO/1,2,3", Dialect::Apt);
    assert_eq!((at(&per_turn[0]), per_turn.len()), (2, 1));
}

/// Modal in the manuals of posts, per minute in some.
#[test]
fn a_feed_without_a_unit_behind_one_per_revolution_is_a_doubt() {
    let program = apt(
        "UNITS/MM\nSPINDL/1000,RPM,CLW\nGOTO/0,0,0\nFEDRAT/0.2,MMPR\nGOTO/1,0,0\nFEDRAT/0.4\nGOTO/2,0,0\n\
         FEDRAT/300,MMPM\nGOTO/3,0,0\nFEDRAT/600\nGOTO/4,0,0",
    );
    let feeds = program.moves[1..].iter().map(|own| (own.feed_m_per_s * 6e4).round());
    assert_eq!(feeds.collect::<Vec<_>>(), [200.0, 400.0, 300.0, 600.0]);
    let told: Vec<usize> =
        program.warnings.iter().filter(|note| note.code == Code::UnitAssumed).map(at).collect();
    assert_eq!(told, [6]);
}

/// It counts from the last hole; the tool stands above that.
#[test]
fn a_relative_move_behind_a_cycle_is_refused() {
    let cycle = "FEDRAT/100,MMPM\nGOTO/0,0,50\nCYCLE/DRILL,DEPTH,20,MMPM,150,CLEAR,3\nGOTO/10,0,0\nCYCLE/OFF\n";
    let found = faults(&format!("{cycle}GODLTA/10,0,0"), Dialect::Apt);
    assert!(found[0].what.contains("counts from its last hole"), "{found:?}");
    let program = apt(&format!("{cycle}GOTO/10,0,50\nGODLTA/10,0,0"));
    let last = end(program.moves.last().unwrap()).1.translation.vector;
    assert!((last - Vector3::new(0.02, 0.0, 0.05)).norm() < 1e-12, "{last}");
}

#[test]
fn things_beside_the_motion_are_told() {
    let program = apt(
        "FEDRAT/5,IPM\nLOADTL/1\nGOTO/0,0,0\nLOADTL/2\nHEAD/2\nCUTCOM/LEFT\nSPINDL/100,SFM\nGOTO/1,0,0",
    );
    let told: Vec<usize> = program.warnings.iter().map(at).collect();
    assert_eq!(told, [1, 5, 6, 7], "{:?}", program.warnings);
    // What may be skipped.
    let program = apt("FEDRAT/5,IPM\nGOTO/0,0,0\nOPSKIP/ON\nGOTO/1,0,0\nOPSKIP/OFF");
    let told: Vec<(usize, Code)> =
        program.warnings.iter().map(|note| (at(note), note.code)).collect();
    let expected = [(1, Code::UnitAssumed), (3, Code::MotionLeftOut)];
    assert_eq!(told, expected, "{:?}", program.warnings);
}

/// AUXFUN/3 is M3: what follows is cut with the spindle on.
#[test]
fn auxiliary_functions_start_the_spindle() {
    for (start, turns) in [("AUXFUN/3", true), ("AUXFUN/5", false), ("AUXFUN/8", false)] {
        let text = format!("SPINDL/RPM,3600,CLW\nSPINDL/OFF\n{start}\nGOTO/0,0,0");
        let expected = if turns { Spindle::Turns(Some(3600.0)) } else { Spindle::Stands };
        assert_eq!(apt(&text).moves[0].stated.spindle, Some(expected), "{start}");
    }
}

#[test]
fn a_start_without_a_speed_ends_a_stop() {
    for (start, rpm) in [
        ("SPINDL/ON", None),
        ("SPINDL/CLW", None),
        ("SPINDL/300,SFM,CLW", None),
        ("SPINDL/SMM,90,CCLW", None),
        ("SPINDL/900,RPM,CLW", Some(900.0)),
    ] {
        let program = apt(&format!("SPINDL/OFF\nGOTO/0,0,0\nGOTO/1,0,0\n{start}\nGOTO/2,0,0\n"));
        let turns: Vec<bool> = program.moves.iter().map(|each| each.spindle_turns).collect();
        assert_eq!(turns, [false, false, true], "{start}");
        assert_eq!(program.spindle[1].spindle, Spindle::Turns(rpm), "{start}");
    }
}

/// A surface speed takes the place of the speed before it: a feed per revolution is no longer known.
#[test]
fn a_feed_per_revolution_of_a_surface_speed_is_refused() {
    let text = "SPINDL/900,RPM\nFEDRAT/0.1,MMPR\nGOTO/0,0,0\nSPINDL/300,SFM\nGOTO/1,0,0\n";
    let found = faults(text, Dialect::Apt);
    assert_eq!((at(&found[0]), found.len()), (5, 1), "{found:?}");
}

#[test]
fn one_coordinate_system_throughout() {
    let system = |z: f64| format!("MSYS/0,0,{z},1,0,0,0,1,0\nGOTO/1,2,3\n");
    let same = apt(&("UNITS/MM\n".to_owned() + &system(500.0) + &system(500.0)));
    assert_ends(&same, &[('L', [1.0, 2.0, 3.0]), ('L', [1.0, 2.0, 3.0])]);
    assert!(same.warnings.is_empty(), "{:?}", same.warnings);
    let found = faults(&(system(0.0) + &system(500.0) + &system(0.0)), Dialect::Apt);
    assert_eq!((at(&found[0]), found.len()), (3, 1), "{found:?}");
    assert!(found[0].what.contains("line 1"), "{}", found[0].what);
}

#[test]
fn the_way_home_is_read_where_it_is_given_and_refused_between_moves() {
    let program = apt("UNITS/MM\nGOTO/0,0,0\nGOHOME/1,2,90,0,0,1\nGOTO/3,0,0\nGOHOME\nFINI\n");
    assert_ends(
        &program,
        &[('L', [0.0, 0.0, 0.0]), ('L', [1.0, 2.0, 90.0]), ('L', [3.0, 0.0, 0.0])],
    );
    assert_eq!(program.moves[1].feed_m_per_s, 0.5);
    let told: Vec<usize> = program.warnings.iter().map(at).collect();
    assert_eq!(told, [3, 5], "{:?}", program.warnings);
    for away in ["GOHOME", "GOCLER"] {
        let text = format!("GOTO/0,0,0\n{away}\nGOTO/1,0,0\nGOTO/2,0,0\n");
        let found = faults(&text, Dialect::Apt);
        assert_eq!((at(&found[0]), found.len()), (2, 1), "{found:?}");
        assert!(found[0].what.contains("split the program"), "{}", found[0].what);
        // Nothing came before.
        assert_eq!(lines(&apt(&format!("{away}\nGOTO/1,0,0\n"))), [2]);
    }
}

/// Two holes and an arc from below as CAMWorks writes them (the words of public files): TRNTYP says
/// that coordinates are those of the world behind another CSYS, too; the arc is clockwise seen from
/// above, about the axis as the right hand turns; pecks of 5 mm, then of 2 mm.
#[test]
fn camworks_writes_coordinates_of_the_world_and_pecks() {
    let text = "PARTNO/1\nUNIT/MM\nCSI_SET_FLUTE_LENGTH/4.\nCSI_SET_EXTENSION_LENGTH/31.5\n\
                SPINDL/3500,RPM,CLW\nTRNTYP/WORLD,0,0,0\nCSYS/1.,0,0,0,0,1.,0,0,0,0,1.,0\nRAPID/\n\
                GOTO/20.,125.,25.\nCYCLE/INIT\n\
                CYCLE/DEEP2,FEDTO,8.,1STPECK,5.,SUBPECK,2.,MMPM,382.27,RAPTO,3.,RTRCTO,25.\n\
                GOTO/20.,125.,0\nCYCLE/OFF\nTRNTYP/WORLD,0,0,0\n\
                CSYS/-1.,0,0,0,0,1.,0,0,0,0,-1.,0\nRAPID/\nGOTO/387.602084,145.,-12.5,0,0,-1.\n\
                FEDRAT/444.5,MMPM\nCIRCLE/387.602084,145.1,-12.5,0,0,-1.\n\
                GOTO/387.502171,145.104167,-12.5,0,0,-1.\nFINI\n";
    let program = read(text.as_bytes(), Dialect::Apt, &settings()).unwrap();
    assert_ends(
        &program,
        &[
            ('L', [20.0, 125.0, 25.0]),
            ('L', [20.0, 125.0, 3.0]),
            ('L', [20.0, 125.0, -5.0]),
            ('L', [20.0, 125.0, 3.0]),
            ('L', [20.0, 125.0, -5.0]),
            ('L', [20.0, 125.0, -7.0]),
            ('L', [20.0, 125.0, 3.0]),
            ('L', [20.0, 125.0, -7.0]),
            ('L', [20.0, 125.0, -8.0]),
            ('L', [20.0, 125.0, 3.0]),
            ('L', [20.0, 125.0, 25.0]),
            ('L', [387.602084, 145.0, -12.5]),
            ('A', [387.502171, 145.104167, -12.5]),
        ],
    );
    let Target::Arc { via, .. } = &program.moves[12].to else { panic!("an arc") };
    // A quarter and 2.4° from below the centre: halfway at −136.2°.
    let angle = (-136.19_f64).to_radians();
    let expected = [387.602084 + 0.1 * angle.cos(), 145.1 + 0.1 * angle.sin(), -12.5];
    let off = via.translation.vector * 1e3 - nalgebra::Vector3::from(expected);
    assert!(off.norm() < 1e-3, "{off}");
    let mixed = text.replacen("TRNTYP/WORLD,0,0,0\nCSYS/-1", "TRNTYP/LOCAL,0,0,0\nCSYS/-1", 1);
    let found = read(mixed.as_bytes(), Dialect::Apt, &settings()).unwrap_err();
    assert!(found[0].what.contains("between WORLD and LOCAL"), "{found:?}");
}
