//! APT and cutter location files: continuation, tool axes, cycles, units.

use detune::motion::Target;
use detune::notes::Code;
use detune::program::{Dialect, Program, Settings, Spindle, SpindleCommand, read};
use nalgebra::Vector3;

use super::support::{assert_ends, assert_pose, at, end, ended, faults, lines, pose, settings};

const CONTOUR: &[u8] = include_bytes!("../../data/programs/contour.apt");

fn apt(text: &str) -> Program {
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
        ("CYCLE/BORE,14,0,0,2,85,1,355,ON,0,0,1000", "behind them ON and more"),
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
    assert_eq!(told, [1, 5, 6, 7, 8], "{:?}", program.warnings);
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

/// CATIA gives the tool axis behind the three ways, as GOTO does; it holds from there on.
#[test]
fn a_relative_move_may_turn_the_tool() {
    let to = |step: &str| {
        format!("UNITS/MM\nMULTAX\nFROM/0,0,0,0,0,1\nFEDRAT/500,MMPM\n{step}\nGOTO/20,0,0")
    };
    let program = apt(&to("GODLTA/10,0,0,0.6,0,0.8"));
    assert_ends(
        &program,
        &[('L', [0.0, 0.0, 0.0]), ('L', [10.0, 0.0, 0.0]), ('L', [20.0, 0.0, 0.0])],
    );
    for (index, axis) in [(0, [0.0, 0.0, 1.0]), (1, [0.6, 0.0, 0.8]), (2, [0.6, 0.0, 0.8])] {
        // The tool points along its −z.
        let found = end(&program.moves[index]).1.rotation * -Vector3::z();
        assert!((found - Vector3::from(axis)).norm() < 1e-9, "{index}: {found}");
    }
    let along = apt(&to("GOTO/0,0,0,0.6,0,0.8\nGODLTA/10"));
    let found = end(&along.moves[2]).1.translation.vector;
    assert!((found - Vector3::new(0.006, 0.0, 0.008)).norm() < 1e-12, "{found}");
    for (step, said) in [
        ("GODLTA/10,0,0,0.6,0,0.9", "length 1.0817"),
        ("GODLTA/10,0", "or one number, along the tool axis"),
        ("GODLTA/10,0,0,0.6", "or one number, along the tool axis"),
        ("GODLTA/10,0,0,0.6,0,0.8,1", "or one number, along the tool axis"),
        ("GODLTA", "or one number, along the tool axis"),
    ] {
        let found = faults(&to(step), Dialect::Apt);
        assert_eq!((at(&found[0]), found.len()), (5, 1), "{step}: {found:?}");
        assert!(found[0].what.contains(said), "{step}: {found:?}");
    }
    // The axis of MULTAX/OFF is not asked for where the move gives its own.
    let off = "GOTO/0,0,0,0.6,0,0.8\nMULTAX/OFF\nGODLTA/10,0,0";
    assert_eq!(told(&apt(&to(off)), Code::ChangeIgnored), [6]);
    assert_eq!(told(&apt(&to(&format!("{off},0,0,1"))), Code::ChangeIgnored), NONE);
}

const NONE: [usize; 0] = [];

/// The lines of the notes of a kind.
fn told(program: &Program, code: Code) -> Vec<usize> {
    program.warnings.iter().filter(|note| note.code == code).map(at).collect()
}

/// The title of Creo's files, as the first line.
const CREO: &str = "$$*          Pro/CLfile  Version 8.0 - 8.0.3.0\n";

/// From 50 mm over two holes, each with its x, the heights below in mm.
fn assert_holes(cycle: &str, heights: [&[f64]; 2]) -> Program {
    let text = format!("UNITS/MM\nFROM/10,0,50\n{cycle}\nGOTO/10,0,0\nGOTO/20,0,0");
    let program = apt(&format!("{CREO}{text}"));
    let places = [(10.0, heights[0]), (20.0, heights[1])].into_iter().flat_map(|(x, heights)| {
        heights.iter().map(move |z| ('L', [x, 0.0, *z])).collect::<Vec<_>>()
    });
    let start = [('L', [10.0, 0.0, 50.0])];
    assert_ends(&program, &start.into_iter().chain(places).collect::<Vec<_>>());
    program
}

/// PTC, CL Output for Holemaking Cycles: RAPTO is a further rapid way as measured from CLEAR toward
/// the point of the hole; RETURN programmed at 0 is back to the retract plane.
#[test]
fn rapto_of_creo_counts_from_clear_and_return_0_goes_to_the_retract_plane() {
    let drill = |words: &str| format!("CYCLE/DRILL,DEPTH,10,MMPM,100,CLEAR,25,RAPTO,22{words}");
    let out = [3.0, -10.0, 3.0];
    let plane = [&out[..], &[50.0]].concat();
    let program = assert_holes(&drill(",RETURN,0"), [&plane, &[&[50.0], &plane[..]].concat()]);
    assert_eq!(told(&program, Code::UnitAssumed), NONE);
    assert_eq!(told(&program, Code::ChangeIgnored), NONE);
    // The feed begins 3 mm over the point.
    let feeds = program.moves.iter().map(|own| (own.feed_m_per_s * 6e4).round() < 101.0);
    assert_eq!(feeds.filter(|is_feed| *is_feed).count(), 2);
    let clear = [&out[..], &[25.0]].concat();
    assert_holes(&drill(""), [&clear, &[&[25.0], &clear[..]].concat()]);
    let deep = "CYCLE/DEEP,DEPTH,10,STEP,6,MMPM,100,CLEAR,25,RAPTO,22,RETURN,0";
    let pecks = [3.0, -6.0, 3.0, -6.0, -10.0, 3.0, 50.0];
    assert_holes(deep, [&pecks, &[&[50.0], &pecks[..]].concat()]);
}

#[test]
fn where_rapto_and_return_are_not_sure_they_are_doubts() {
    let read = |head: &str, cycle: &str| {
        let holes = "GOTO/10,0,0\nCYCLE/OFF";
        apt(&format!(
            "{head}UNITS/MM\nFROM/10,0,50\nCYCLE/DRILL,DEPTH,10,MMPM,100,{cycle}\n{holes}"
        ))
    };
    let doubts = |head: &str, cycle: &str| {
        let program = read(head, cycle);
        (told(&program, Code::UnitAssumed), told(&program, Code::ChangeIgnored))
    };
    let none = NONE.to_vec();
    assert_eq!(doubts(CREO, "CLEAR,25,RAPTO,22,RETURN,0"), (none.clone(), none.clone()));
    // Of another system, or below the point.
    assert_eq!(doubts("", "CLEAR,25,RAPTO,22"), (vec![3], none.clone()));
    assert_eq!(doubts("", "CLEAR,25,RETURN,0"), (none.clone(), vec![3]));
    assert_eq!(doubts("", "RAPTO,22,RTRCTO,25"), (none.clone(), none.clone()));
    assert_eq!(doubts(CREO, "RAPTO,22"), (vec![4], none.clone()));
    assert_eq!(doubts(CREO, "CLEAR,2,RAPTO,3"), (vec![4], none.clone()));
    // The tool comes from below CLEAR, so that this is not the retract plane.
    assert_eq!(doubts(CREO, "CLEAR,60,RETURN,0"), (none.clone(), vec![5]));
    // Behind another cycle the retract plane is its own, or not known.
    let second = |words: &str| {
        format!("CLEAR,25{words}\nGOTO/10,0,0\nCYCLE/OFF\nCYCLE/DRILL,DEPTH,10,CLEAR,25,RETURN,0")
    };
    assert_eq!(doubts(CREO, &second("")), (none.clone(), vec![7]));
    assert_eq!(doubts(CREO, &second(",RETURN,0")), (none.clone(), none));
    let text = "UNITS/MM\nFROM/0,0,50\nCYCLE/DRILL,DEPTH,10,CLEAR,5,RAPTO,15\nGOTO/0,0,0";
    let found = faults(&format!("{CREO}{text}"), Dialect::Apt);
    assert_eq!((at(&found[0]), found.len()), (4, 1), "{found:?}");
    assert!(found[0].what.contains("leads to the bottom"), "{found:?}");
}

/// `CYCLE/type,z,f,units,r,i`: the depth, the feed, its unit, rapid to r, the depth of a peck.
#[test]
fn the_fixed_format_of_creo_is_read_as_a_doubt() {
    let cycle = "CYCLE/DEEP,10,100,MMPM,5,4";
    let pecks = [5.0, -4.0, 5.0, -4.0, -8.0, 5.0, -8.0, -10.0, 5.0];
    let program = assert_holes(cycle, [&pecks, &pecks]);
    assert_eq!(told(&program, Code::UnitAssumed), [4]);
    for (head, cycle) in [("", cycle), (CREO, "CYCLE/DRILL,10,100,MMPM,5,4")] {
        let text = format!("{head}UNITS/MM\nFROM/0,0,50\n{cycle}\nGOTO/0,0,0");
        let found = faults(&text, Dialect::Apt);
        assert!(found[0].what.contains("in a file with Creo's header"), "{found:?}");
    }
}

/// PTC, CL Output for Circular Interpolation: the GOTO statements behind CIRCLE specify the points
/// on the arc, the last one its end. Start and end are tangent to lines.
#[test]
fn further_points_on_the_arc_are_of_it_in_creo_s_files_and_a_doubt_elsewhere() {
    let text = |head: &str, behind: &str| {
        format!(
            "{head}UNITS/MM\nFROM/100,-30,0\nFEDRAT/500,MMPM\nGOTO/100,0,0\n\
             CIRCLE/0,0,0,0,0,1,100\nGOTO/0,100,0\n{behind}"
        )
    };
    let ways =
        |program: &Program| -> String { program.moves.iter().map(|own| end(own).0).collect() };
    let points = "GOTO/-100,0,0\nGOTO/-100,-30,0";
    let creo = apt(&text(CREO, points));
    assert_ends(
        &creo,
        &[
            ('L', [100.0, -30.0, 0.0]),
            ('L', [100.0, 0.0, 0.0]),
            ('A', [0.0, 100.0, 0.0]),
            ('A', [-100.0, 0.0, 0.0]),
            ('L', [-100.0, -30.0, 0.0]),
        ],
    );
    let Target::Arc { via, .. } = &creo.moves[3].to else { panic!("an arc") };
    let half = 0.1 * std::f64::consts::FRAC_1_SQRT_2;
    assert!((via.translation.vector - Vector3::new(-half, half, 0.0)).norm() < 1e-9, "{via}");
    // It may be a D; three points show how the file is written.
    assert_eq!(told(&creo, Code::MotionLeftOut), [8]);
    let two = "CIRCLE/-200,-30,0,0,0,-1,100\nGOTO/-200,-130,0\nGOTO/-300,-30,0";
    assert_eq!(told(&apt(&text(CREO, &format!("{points}\n{two}"))), Code::MotionLeftOut), [8]);
    let three = format!("{two}\nGOTO/-200,70,0\nGOTO/-200,99,0");
    let both = apt(&text(CREO, &format!("{points}\n{three}")));
    assert_eq!(ways(&both), "LLAALAAAL");
    assert_eq!(told(&both, Code::MotionLeftOut), NONE);
    assert_eq!(told(&both, Code::UnitAssumed), NONE);
    // A longer arc has one point alone: that behind the first may be a line.
    let longer = "CIRCLE/-200,100,0,0,0,1,1\nGOTO/-200,99,0\nGOTO/-200,90,0";
    let mixed = apt(&text(CREO, &format!("{points}\n{three}\n{longer}")));
    assert_eq!(ways(&mixed), "LLAALAAALAAL");
    assert_eq!(told(&mixed, Code::MotionLeftOut), [8]);
    // Elsewhere it is a line.
    let other = apt(&text("", points));
    assert_eq!(ways(&other), "LLALL");
    assert_eq!(told(&other, Code::MotionLeftOut), [7]);
    // At another height it may be one of a helix.
    assert_eq!(told(&apt(&text("", "GOTO/-100,0,-1")), Code::MotionLeftOut), [7]);
    assert_eq!(told(&apt(&text(CREO, "GOTO/-100,0,-1")), Code::MotionLeftOut), [8]);
    let helix = text("", "GOTO/-100,0,-2").replace("GOTO/0,100,0", "GOTO/0,100,-1");
    assert_eq!(told(&apt(&helix), Code::MotionLeftOut), [7]);
    // One of 2°, which is 0.015 mm off the arc; off the circle; at another height; behind a feed;
    // further than once round.
    let (sin, cos) = 2.0_f64.to_radians().sin_cos();
    for behind in [
        format!("GOTO/{},{},0", -100.0 * sin, 100.0 * cos),
        "GOTO/-99,0,0".to_owned(),
        "GOTO/0,100,1".to_owned(),
        "FEDRAT/400,MMPM\nGOTO/-100,0,0".to_owned(),
        format!("GOTO/{},{},0", 100.0 * sin, 100.0 * cos),
    ] {
        let program = apt(&text("", &behind));
        assert_eq!(ways(&program), "LLAL", "{behind}");
        assert_eq!(told(&program, Code::MotionLeftOut), NONE, "{behind}");
    }
}

/// END is M2 or M30.
#[test]
fn moves_behind_end_are_a_doubt_as_behind_fini() {
    for stop in ["END", "end", "FINI"] {
        let text =
            format!("UNITS/MM\nFROM/0,0,0\nFEDRAT/300,MMPM\nGOTO/10,0,0\n{stop}\nGOTO/20,0,0");
        let program = apt(&text);
        assert_ends(&program, &[('L', [0.0, 0.0, 0.0]), ('L', [10.0, 0.0, 0.0])]);
        assert_eq!(told(&program, Code::MotionLeftOut), [6], "{stop}");
    }
    let program = apt("UNITS/MM\nFROM/0,0,0\nFEDRAT/300,MMPM\nGOTO/10,0,0\nEND");
    assert!(
        program.warnings.iter().all(|note| note.code == Code::Assumed),
        "{:?}",
        program.warnings
    );
    let found = faults("UNITS/MM\nFROM/0,0,0\nEND GOTO/20,0,0", Dialect::Apt);
    assert_eq!((at(&found[0]), found.len()), (3, 1), "{found:?}");
}

#[test]
fn a_rapid_move_within_a_cycle_may_be_no_hole() {
    let lines = |before: &str, within: &str| {
        let cycle = "CYCLE/DRILL,DEPTH,10,MMPM,100,CLEAR,2";
        let text = format!(
            "UNITS/MM\nFROM/0,0,20\n{before}{cycle}\nGOTO/10,0,0\n{within}GOTO/40,0,0\nCYCLE/OFF\n\
             RAPID\nGOTO/40,0,50"
        );
        told(&apt(&text), Code::MotionLeftOut)
    };
    assert_eq!(lines("", "RAPID\n"), [6]);
    assert_eq!(lines("", "FEDRAT/RAPID\n"), [6]);
    assert_eq!(lines("", ""), NONE);
    assert_eq!(lines("RAPID\n", ""), NONE);
    assert_eq!(lines("", "RAPID\nCYCLE/ON\n"), NONE);
}

/// As behind M6 and TOOL CALL.
#[test]
fn a_cut_behind_another_tool_with_the_spindle_as_before_is_a_doubt() {
    let lines = |load: &str| {
        let text = format!(
            "UNITS/MM\nLOADTL/1\nSPINDL/3000,RPM,CLW\nFROM/0,0,20\nFEDRAT/300,MMPM\nGOTO/10,0,20\n\
             {load}\nRAPID\nGOTO/15,0,20\nGOTO/20,0,20"
        );
        told(&apt(&text), Code::SpindleCommand)
    };
    assert_eq!(lines("LOADTL/2"), [10]);
    assert_eq!(lines("LOAD/TOOL,2"), [10]);
    for load in [
        "LOADTL/1",
        "TURRET/2",
        "LOADTL/2\nSPINDL/900,RPM,CLW",
        "LOADTL/2\nSPINDL/ON",
        "LOADTL/2\nSPINDL/90,SMM",
        "LOADTL/2\nAUXFUN/3",
        "LOADTL/2,SPINDL,3000",
    ] {
        assert_eq!(lines(load), NONE, "{load}");
    }
}

/// `depth, feed, clearance, unit`, or with the clearance first, as posts are set up.
#[test]
fn which_of_two_bare_numbers_is_the_feed_may_be_a_doubt() {
    let lines = |words: &str| {
        let text =
            format!("UNITS/MM\nSPINDL/3000,CLW\nGOTO/0,0,100\nCYCLE/DRILL,{words}\nGOTO/9,0,0");
        told(&apt(&text), Code::UnitAssumed)
    };
    for words in ["3,0.2,MMPR", "0.2,3,MMPR", "3,120,MMPM", "3,MMPM,120", "100,80,MMPM"] {
        assert_eq!(lines(&format!("20,{words}")), [4], "{words}");
    }
    // No feed a minute is so small, none in a turn so large: 0.1 in/min are 2.54 mm/min.
    for words in ["100,3,MMPM", "100,MMPM,3", "0.2,6,MMPR", "100,0,MMPM", "4,0.1,IPM"] {
        assert_eq!(lines(&format!("20,{words}")), NONE, "{words}");
    }
}

/// It says that tool axes do not count.
#[test]
fn a_tilted_axis_behind_multax_off_is_a_doubt() {
    let lines = |between: &str, to: &str| {
        let text = format!(
            "UNITS/MM\nMULTAX/OFF\nFEDRAT/300,MMPM\nGOTO/0,0,10,0,0,1\n{between}{to}\nGOTO/20,0,10"
        );
        told(&apt(&text), Code::ChangeIgnored)
    };
    for to in ["GOTO/10,0,10,0.6,0,0.8", "GODLTA/10,0,0,0.6,0,0.8", "TLAXIS/0.6,0,0.8"] {
        assert_eq!(lines("", to), [5], "{to}");
        assert_eq!(lines("MULTAX/ON\n", to), NONE, "{to}");
    }
    assert_eq!(lines("", "GOTO/10,0,10,0,0,1"), NONE);
}

#[test]
fn what_stands_behind_the_mark_of_continuation_is_a_remark() {
    let program = apt("UNITS/MM\nGOTO/0,0,10\nGOTO/20,$ to the corner\n0,10\nGOTO/20,5,$\n10");
    let ends = [[0.0, 0.0, 10.0], [20.0, 0.0, 10.0], [20.0, 5.0, 10.0]];
    assert_ends(&program, &ends.map(|at| ('L', at)));
    // A name may begin with it.
    let found = faults("GOTO/0,0,0\nTOOL PATH/OP1,TOOL,$MILL\nRAPID\nGOTO/5,0,0", Dialect::Apt);
    assert!(found[0].what.starts_with("TOOL: a '$' behind ',' or '/' ends the line"), "{found:?}");
    assert_eq!(found.iter().map(at).collect::<Vec<_>>(), [2], "{found:?}");
    let found = faults("GOTO/0,0,0\n0,10", Dialect::Apt);
    assert!(found[0].what.starts_with("the statement begins with no word"), "{found:?}");
    assert_eq!(found.iter().map(at).collect::<Vec<_>>(), [2], "{found:?}");
}
