//! Statements of public CL files, and of the posts that read them, that were passed over in silence or refused for a
//! wrong reason. Expected places and times are worked out by hand.

use detune::notes::{Class, Code};
use detune::program::{Dialect, Program, read};

use super::support::{assert_ends, at, ended, faults, settings};

fn of(text: &str) -> Program {
    read(ended(text, Dialect::Apt).as_bytes(), Dialect::Apt, &settings())
        .unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

#[track_caller]
fn assert_doubts(text: &str, expected: &[(Code, usize)]) {
    let program = of(text);
    let told = program.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    let told: Vec<_> = told.map(|note| (note.code, at(note))).collect();
    assert_eq!(told, expected, "{text}: {:?}", program.warnings);
}

#[test]
fn a_tool_that_is_named_and_not_loaded_is_a_doubt() {
    let two = |first: &str, second: &str| {
        format!(
            "UNITS/MM\n{first}\nFEDRAT/500,MMPM\nGOTO/0,0,0\nGOTO/80,0,0\n{second}\nGOTO/80,80,0"
        )
    };
    let paths = ["TOOL PATH/A,TOOL,D10", "TOOL PATH/B,TOOL,D8"];
    for [first, second] in [paths, ["CUTTER/10", "CUTTER/50"], ["TOOLNO/1,10.0", "TOOLNO/2,50.0"]] {
        assert_doubts(&two(first, second), &[(Code::ChangeIgnored, 6)]);
        assert_doubts(&two(first, first), &[]);
        // Loaded before or behind: the number says which.
        assert_doubts(&two(first, &format!("LOADTL/2\n{second}")), &[]);
        assert_doubts(&two(first, &format!("{second}\nLOAD/TOOL,2")), &[]);
    }
    assert_doubts(&two("TOOL/1", "TOOL/2"), &[(Code::ChangeIgnored, 6)]);
    assert_doubts(&two("LOADTL/1", "LOAD/HEAD,7"), &[(Code::ChangeIgnored, 6)]);
}

#[test]
fn a_speed_that_loadtl_states_is_borne_out_or_a_doubt() {
    let load = "LOADTL/1,ADJUST,1,SPINDL,1000.0,MILL";
    let text = |before: &str, behind: &str| {
        format!("UNITS/MM\n{before}{load}\n{behind}FEDRAT/500,MMPM\nGOTO/0,0,0\nGOTO/80,0,0")
    };
    let spindl = |rpm: i32| format!("SPINDL/{rpm},RPM,CLW\n");
    assert_doubts(&text("", &spindl(9000)), &[]);
    assert_doubts(&text(&spindl(1000), ""), &[]);
    assert_doubts(&text(&spindl(9000), ""), &[(Code::SpindleCommand, 3)]);
    assert_doubts(&text("", ""), &[(Code::SpindleCommand, 2)]);
}

#[test]
fn words_that_posts_read_differently_are_doubts() {
    let two = |first: &str, second: &str| {
        format!("UNITS/MM\nFEDRAT/500,MMPM\n{first}\n{second}\nGOTO/9,0,0")
    };
    let tilted = "MULTAX/ON\nGOTO/0,0,0,0.6,0,0.8";
    assert_doubts(&two(tilted, "MULTAX/OFF"), &[(Code::ChangeIgnored, 5)]);
    assert_doubts(&two(tilted, "MULTAX/OFF\nGOTO/5,0,0,0,0,1"), &[]);
    assert_doubts(&two("GOTO/0,0,0", "MULTAX/OFF"), &[]);
    assert_doubts(&two("GOTO/0,0,0", "RAPID\nFEDRAT/100,MMPM"), &[(Code::MotionLeftOut, 5)]);
    assert_doubts(&two("GOTO/0,0,0", "FEDRAT/100,MMPM\nRAPID"), &[]);
    assert_doubts(&two("GOTO/0,0,0", "PPWORD/S1000 M03"), &[(Code::MotionLeftOut, 4)]);

    let system = |name: &str, x: &str, origin: &str| {
        format!(
            "$$*CATIA0\n$$ {name}\n$$ {x} 0.0 {origin}\n$$ 0.0 1.0 0.0 0.0\n$$ 0.0 0.0 1.0 0.0\n"
        )
    };
    let first = system("Manufacturing Program.1", "1.0 0.0", "0.0");
    let moves = "FEDRAT/500,MMPM\nGOTO/0,0,0\nGOTO/80,0,0\n";
    let both = |second: &str| format!("{first}{moves}{second}GOTO/0,0,0");
    assert_doubts(&both(&system("Program.2", "1.0 0.0", "300.0")), &[(Code::ChangeIgnored, 9)]);
    assert_doubts(&both(&first), &[]);
}

#[test]
fn units_behind_moves_are_a_doubt() {
    let text = |unit: &str| format!("FEDRAT/500\nGOTO/0,0,0\nGOTO/100,0,0\n{unit}\nGOTO/9,0,0");
    assert_doubts(&text("UNITS/INCHES"), &[(Code::UnitAssumed, 2)]);
    assert_doubts(&text("UNITS/MM"), &[]);
    assert_doubts(&format!("UNITS/MM\n{}", text("UNITS/INCHES")), &[]);
    // At zero both units are one.
    assert_doubts("FEDRAT/500\nGOTO/0,0,0\nUNITS/INCHES\nGOTO/1,0,0", &[]);
    let drill = "RAPID\nGOTO/1,2,2,0,0,1\nCYCLE/DRILL,RAPTO,0.1,FEDTO,-0.75,IPM,10\nGOTO/1,2,1";
    assert_doubts(drill, &[(Code::UnitAssumed, 3)]);
    assert_doubts(&format!("UNITS/INCHES\n{drill}"), &[]);
}

#[test]
fn cycles_are_taken_up_again_and_change() {
    let first = "UNITS/MM\nRAPID\nGOTO/0,0,50\nCYCLE/DRILL,DEPTH,20,MMPM,100,CLEAR,2\nGOTO/0,0,0\nCYCLE/OFF\nRAPID\n\
                 GOTO/90,0,50";
    let hole = |depth: f64| -> Vec<(char, [f64; 3])> {
        [2.0, -depth, 2.0].map(|z| ('L', [90.0, 0.0, z])).to_vec()
    };
    for (on, depth) in [("CYCLE/ON", 20.0), ("CYCLE/ON,DEPTH,30", 30.0)] {
        let mut program = of(&format!("{first}\n{on}\nGOTO/90,0,0"));
        program.moves.drain(..program.moves.len() - 3);
        assert_ends(&program, &hole(depth));
    }
    let refused = |text: &str, why: &str| {
        let found = faults(text, Dialect::Apt);
        assert!(found.len() == 1 && found[0].what.contains(why), "{text}: {found:?}");
    };
    refused("UNITS/MM\nGOTO/0,0,0\nCYCLE/ON\nGOTO/9,0,0", "without a cycle before");
    refused(
        "UNITS/MM\nGOTO/0,0,9\nCYCLE/DRILL,DEPTH,20,MMPM,100\nGOTO/0,0,0\nGODLTA/50,0,0",
        "relative move within a cycle",
    );
    // The holes of a cycle that is refused have their feed there.
    refused("UNITS/MM\nGOTO/0,0,9\nCYCLE/MILL,DEPTH,20,MMPM,100\nGOTO/0,0,0\nGOTO/9,0,0", "'MILL'");
    refused("UNITS/MM\nGOTO/0,0,9\nPROBE/POINT,0,0,0", "may move the tool");
}

#[test]
fn words_within_cycles() {
    let drill = |cycle: &str| of(&format!("UNITS/MM\nGOTO/0,0,50\nCYCLE/{cycle}\nGOTO/0,0,0"));
    for word in ["MANUAL", "AUTO"] {
        let program = drill(&format!("DRILL,RAPTO,3,FEDTO,-33,RTRCTO,4,{word},MMPM,250"));
        assert_ends(&program, &[50.0, 3.0, -33.0, 3.0, 4.0].map(|z| ('L', [0.0, 0.0, z])));
    }
    // 20 strokes of 2 mm, 19 of them followed by a way out and one back in; and the hole's own ways.
    assert_eq!(
        drill("THRU,DEPTH,40,STEP,2,MMPM,2000,CLEAR,2").moves.len(),
        1 + 1 + 20 + 2 * 19 + 1
    );
    assert_eq!(drill("THRU,DEPTH,40,MMPM,2000,CLEAR,2").moves.len(), 1 + 3);
    let turns = "CYCLE/DRILL,DEPTH,20,MMPM,100,CLEAR,2,DWELL,REV,300\nGOTO/0,0,0";
    assert_doubts(
        &format!("SPINDL/ON\nUNITS/MM\nGOTO/0,0,9\n{turns}"),
        &[(Code::MotionLeftOut, 4)],
    );
    let known = of(&format!("SPINDL/9000\nUNITS/MM\nGOTO/0,0,9\n{turns}"));
    // 300 turns at 150 in a second.
    let dwells = known.moves.iter().filter_map(|motion| match motion.timing {
        detune::motion::Timing::Seconds(seconds) => Some(seconds),
        _ => None,
    });
    assert_eq!(dwells.collect::<Vec<_>>(), [2.0]);
}
