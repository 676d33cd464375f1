//! Work that the arm or a positioner carries: frames, loads, dwells, positions that are read back.

use std::sync::Arc;

use detune::input::{Reading, read_robot};
use detune::motion::{MechanicalUnit, UnitAxis, Work};
use detune::notes::{Code, Note};
use detune::path::{Path, tool_frames};
use detune::program::{Dialect, Program, Settings, read};
use nalgebra::{Isometry3, Point3, Unit, Vector3};

use super::support::{CLOSE_M, assert_pose, at, end, pose, settings};

/// The first instruction is on line 7.
const DATA: &str = "MODULE m\n\
    PERS tooldata grinder:=[FALSE,[[700,-150,500],[1,0,0,0]],[3,[0,0,40],[1,0,0,0],0,0,0]];\n\
    PERS tooldata spindle:=[TRUE,[[0,0,150],[1,0,0,0]],[4,[0,0,50],[1,0,0,0],0,0,0]];\n\
    PERS wobjdata part:=[TRUE,TRUE,\"\",[[0,0,160],[1,0,0,0]],[[10,20,0],[1,0,0,0]]];\n\
    PERS wobjdata table:=[FALSE,FALSE,\"Stn1\",[[9,9,9],[1,0,0,0]],[[0,0,30],[1,0,0,0]]];\n\
    PROC main()\n";

fn run(instructions: &str, settings: &Settings) -> Result<Program, Vec<Note>> {
    let text = format!("{DATA}{instructions}ENDPROC\nENDMODULE\n");
    read(text.as_bytes(), Dialect::Rapid, settings)
}

/// A robtarget with the tool turned half about x.
fn target(x: f64, y: f64, z: f64, axis: &str) -> String {
    format!("[[{x},{y},{z}],[0,1,0,0],[0,0,0,0],[9E9,{axis},9E9,9E9,9E9,9E9]]")
}

/// A table that turns about a vertical axis through (1000, 0), with its frame 200 mm beside it.
fn with_table() -> Settings {
    let axis = UnitAxis {
        name: "eax_b".to_owned(),
        axis: Unit::new_normalize(Vector3::z()),
        origin_m: Point3::new(1.0, 0.0, 0.0),
        slides: false,
    };
    let unit = MechanicalUnit {
        name: "STN1".to_owned(),
        axes: vec![axis],
        frame: Isometry3::translation(1.2, 0.0, 0.4),
    };
    let mut settings = settings();
    settings.mechanical_units.insert("stn1".to_owned(), Arc::new(unit));
    settings
}

fn joints() -> String {
    "[[0,0,0,0,30,0],[9E9,0,9E9,9E9,9E9,9E9]]".to_owned()
}

#[test]
fn a_tool_that_stands_is_where_the_program_has_it() {
    let [a, b] = [target(0.0, 0.0, 10.0, "9E9"), target(40.0, 0.0, 10.0, "9E9")];
    let program = run(
        &format!(
            "MoveAbsJ {},v100,fine,grinder\\WObj:=part;\nMoveJ {a},v100,fine,grinder\\WObj:=part;\n\
             MoveL {b},v10,fine,grinder\\WObj:=part;\nWaitTime 2;\n",
            joints()
        ),
        &settings(),
    );
    let program = program.unwrap();
    assert!(program.moves.iter().all(|each| each.work == Work::Held));
    for each in &program.moves {
        assert_pose(&each.tcp, &pose([700.0, -150.0, 500.0], [1.0, 0.0, 0.0, 0.0]));
    }
    // In the tip frame: the work object lies at (10, 20, 160).
    let [_, first, second, dwell] = &program.moves[..] else { panic!("{program:?}") };
    let at = |x: f64| pose([x, 20.0, 170.0], [0.0, 1.0, 0.0, 0.0]);
    let expected = [(first, 'T', 10.0), (second, 'L', 50.0), (dwell, 'T', 50.0)];
    for (each, way, x) in expected {
        assert_eq!(end(each).0, way);
        assert_pose(&end(each).1, &at(x));
    }
}

/// ABB's Technical reference manual, RAPID data types: with a stationary tool tload is the load of
/// the gripper, in the wrist's frame, and the centre of a payload is in the object's frame.
#[test]
fn what_the_gripper_holds_lies_in_the_work_object() {
    let to = format!("{},v10,fine,grinder\\WObj:=part;\n", target(0.0, 0.0, 0.0, "9E9"));
    let grip = "GripLoad [1,[0,0,20],[1,0,0,0],0,0,0];\n";
    let program = run(&format!("MoveJ {to}{grip}MoveJ {to}"), &settings()).unwrap();
    let loads = program.moves.iter().map(|each| each.stated.load.clone().unwrap());
    let loads: Vec<_> = loads.collect();
    assert_eq!([loads[0].mass_kg, loads[1].mass_kg], [3.0, 4.0]);
    assert_eq!(loads[0].com_m, Vector3::new(0.0, 0.0, 0.04));
    // 3 kg at (0, 0, 40) and 1 kg at (10, 20, 160 + 20).
    let expected = Vector3::new(10.0, 20.0, 3.0 * 40.0 + 180.0) / 4000.0;
    assert!((loads[1].com_m - expected).norm() < 1e-12, "{}", loads[1].com_m);
    // Without a work object nothing says where that is.
    let program =
        run(&format!("{grip}MoveAbsJ {},v10,fine,grinder;\n", joints()), &settings()).unwrap();
    let doubts: Vec<_> =
        program.warnings.iter().filter(|w| w.code == Code::ChangeIgnored).collect();
    assert!(doubts[0].what.contains("GripLoad without a work object"), "{doubts:?}");
}

#[test]
fn work_on_a_positioner_turns_with_its_axis() {
    let on =
        |angle: &str| format!("{},v10,fine,spindle\\WObj:=table;\n", target(5.0, 0.0, 0.0, angle));
    let [first, second] = [on("-10"), on("20")];
    let program = run(&format!("MoveJ {first}MoveL {second}WaitTime 1;\n"), &with_table()).unwrap();
    let turns = program.moves.iter().map(|each| match &each.work {
        Work::Moves(unit) => [unit.from[0].to_degrees(), unit.to[0].to_degrees()],
        other => panic!("{other:?}"),
    });
    let turns: Vec<[f64; 2]> = turns.collect();
    let expected = [[-10.0, -10.0], [-10.0, 20.0], [20.0, 20.0]];
    for (found, expected) in turns.iter().flatten().zip(expected.iter().flatten()) {
        assert!((found - expected).abs() < 1e-12, "{turns:?}");
    }
    // In the user frame, 30 mm beneath the work object; the uframe of the program does not count.
    for each in &program.moves {
        assert_pose(&end(each).1, &pose([5.0, 0.0, 30.0], [0.0, 1.0, 0.0, 0.0]));
    }
    let told: Vec<_> = program.warnings.iter().map(|note| note.what.as_str()).collect();
    assert_eq!(told, ["the mechanical unit 'STN1' is taken as rigid"]);
    let off = target(5.0, 0.0, 0.0, "9E9");
    let found = run(&format!("MoveJ {off},v10,fine,spindle\\WObj:=table;\n"), &with_table());
    let found = found.unwrap_err();
    assert!(found[0].what.contains("eax_b is placed by no target so far"), "{found:?}");
    assert_eq!(at(&found[0]), 7);
}

/// v_leax and v_reax bound how fast external axes go; a joint move is as long as the tool's way in
/// the work.
#[test]
fn external_axes_take_their_time() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/irb1600/robot.yaml");
    let robot = read_robot(&file, &mut Reading::default()).unwrap();
    let duration = |instruction: &str| {
        let start = target(5.0, 0.0, 0.0, "0");
        let text = format!("MoveJ {start},v10,fine,spindle\\WObj:=table;\n{instruction}\n");
        let program = run(&text, &with_table()).unwrap();
        Path::plan(&robot, &program.moves, None).unwrap().duration_s()
    };
    let [far, near] = [target(65.0, 0.0, 0.0, "12"), target(65.0, 0.0, 0.0, "1")];
    for (end, speed, seconds) in [
        // 60 mm at 10 mm/s; 12° at 1°/s; 1° at 1°/s.
        (&far, "[10,500,5000,1000]", 6.0),
        (&far, "[10,500,5000,1]", 12.0),
        (&near, "[10,500,5000,1]", 6.0),
    ] {
        for way in ["MoveL", "MoveC"] {
            let via = target(35.0, 0.01, 0.0, "3");
            let via = if way == "MoveC" { format!("{via},") } else { String::new() };
            let found = duration(&format!("{way} {via}{end},{speed},fine,spindle\\WObj:=table;"));
            assert!((found - seconds).abs() < 1e-4, "{way} {speed}: {found}");
        }
    }
    // The table turns by 90° beneath the tool, which stands 200 mm from its axis in the base: its
    // way in the work is a quarter of that circle, and a straight way of joints comes near to it.
    let still = "MoveJ [[0,0,0],[0,1,0,0],[0,0,0,0],[9E9,0,9E9,9E9,9E9,9E9]],[10,500,5000,1000],fine,spindle\\WObj:=table;\n";
    let turn = "MoveJ [[-200,-200,0],[0,0.70710678,-0.70710678,0],[0,0,0,0],[9E9,90,9E9,9E9,9E9,9E9]],[10,500,5000,1000],fine,spindle\\WObj:=table;";
    let (both, one) = (duration(&format!("{still}{turn}")), duration(still));
    let expected = std::f64::consts::FRAC_PI_2 * 200.0 / 10.0;
    assert!((both - one - expected).abs() < 1e-3 * expected, "{} {expected}", both - one);
}

/// Work that turns once round is where it was, and the arm has followed it; joints that stand are
/// led by work that turns.
#[test]
fn the_arm_follows_a_whole_turn() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/irb1600/robot.yaml");
    let robot = read_robot(&file, &mut Reading::default()).unwrap();
    let plan = |text: &str| {
        let program = run(&format!("ConfL \\Off;\n{text}"), &with_table()).unwrap();
        let path = Path::plan(&robot, &program.moves, None).unwrap();
        (path.duration_s(), path.knots_s().len(), detune::path::tcp_poses(&path, &[0.5]).unwrap())
    };
    let on = |angle: &str| {
        let start = target(0.0, 0.0, 0.0, angle);
        format!("MoveL {start},[10,500,5000,10],fine,spindle\\WObj:=table;\n")
    };
    let (seconds, knots, half) = plan(&format!("{}{}", on("0"), on("360")));
    // 360° at 10°/s; the table turns by 2° at most between two knots.
    assert!((seconds - 36.0).abs() < 1e-9 && knots > 180, "{seconds} {knots}");
    let expected = Vector3::new(0.8, 0.0, 0.43);
    assert!((half[0].translation.vector - expected).norm() < 1e-6, "{half:?}");
    let joints = |angle: &str| {
        format!(
            "MoveAbsJ [[0,0,0,0,30,0],[9E9,{angle},9E9,9E9,9E9,9E9]],[10,500,5000,1000],fine,\
             spindle\\WObj:=table;\n"
        )
    };
    // The flange of the arm so: the tool is somewhere off the axis, and its way is an arc about it.
    let (seconds, _, at) = plan(&format!("{}{}", joints("0"), joints("90")));
    let off = at[0].translation.vector - Vector3::new(1.0, 0.0, 0.0);
    let expected = std::f64::consts::FRAC_PI_2 * off.xy().norm() / 0.01;
    assert!((seconds - expected).abs() < 1e-6 * expected, "{seconds} {expected}");
    // Where it was before is not known.
    let start = target(0.0, 0.0, 0.0, "9E9");
    let found = run(&format!("MoveL {start},v10,fine,spindle;\n{}", on("90")), &with_table());
    let found = found.unwrap_err();
    assert!(found[0].what.contains("do not say where external axis eax_b is"), "{found:?}");
}

/// ABB's manual of CRobT: the active work object where none is named; the external axes are those
/// of the place, and CJointT has those of a jointtarget.
#[test]
fn what_is_read_back_is_of_the_motion_before() {
    let place = target(5.0, 6.0, 7.0, "30");
    let there = target(5.0, 6.0, 7.0, "60");
    let program = run(
        &format!(
            "VAR robtarget back;\nVAR jointtarget j;\nMoveJ {place},v10,fine,spindle\\WObj:=table;\n\
             back:=CRobT();\nMoveL {there},v10,fine,spindle\\WObj:=table;\n\
             IF back.extax.eax_b<40 MoveL back,v10,fine,spindle\\WObj:=table;\n\
             MoveAbsJ [[0,0,0,0,30,0],[9E9,0,9E9,9E9,9E9,9E9]],v10,fine,spindle;\n\
             j:=CJointT();\nj.robax.rax_5:=40;\nMoveAbsJ j,v10,fine,spindle;\n"
        ),
        &with_table(),
    );
    let moves = program.unwrap().moves;
    assert_eq!(moves.len(), 5);
    assert_pose(&end(&moves[2]).1, &end(&moves[0]).1);
    let Work::Moves(unit) = &moves[2].work else { panic!("{:?}", moves[2]) };
    assert!((unit.to[0].to_degrees() - 30.0).abs() < 1e-12);
    let detune::motion::Target::Joints(joints) = &moves[4].to else { panic!() };
    assert!((joints[4].to_degrees() - 40.0).abs() < 1e-12 && joints[0] == 0.0);
}

/// ABB's manual of CirPathMode: a tool turns with the arc unless it says otherwise.
#[test]
fn arcs_turn_as_cirpathmode_says() {
    use detune::motion::{Target, Turning};
    let [a, b, c] = [(0.0, 0.0), (10.0, 5.0), (20.0, 0.0)].map(|(x, y)| target(x, y, 0.0, "9E9"));
    for (mode, turning, doubts) in [
        ("", Turning::WithArc, 0),
        ("CirPathMode \\CirPointOri;\nCirPathMode;", Turning::WithArc, 0),
        ("CirPathMode \\ObjectFrame;", Turning::ToEnd, 0),
        ("CirPathMode \\CirPointOri;", Turning::ByWay, 0),
        ("CirPathMode \\Wrist45;", Turning::WithArc, 1),
        ("IF DInput(di)=1 CirPathMode \\ObjectFrame;", Turning::WithArc, 1),
    ] {
        let text =
            format!("{mode}\nMoveJ {a},v10,fine,spindle;\nMoveC {b},{c},v10,fine,spindle;\n");
        let program = run(&text, &settings()).unwrap();
        let Target::Arc { turning: found, .. } = program.moves[1].to else { panic!() };
        assert_eq!(found, turning, "{mode}");
        let told = program.warnings.iter().filter(|note| note.code == Code::AxisIgnored);
        assert_eq!(told.count(), doubts, "{mode}: {:?}", program.warnings);
    }
    // Half a circle: as it was, as the arc goes, and turned over with it; what the circle point says
    // of the way round.
    let pose = |x: f64, y: f64, turn: &str| {
        format!("[[{x},{y},0],[{turn}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]")
    };
    let (same, with) = ("0,1,0,0", "0,0,1,0");
    for (via, end, doubts) in [
        (same, same, 0),
        ("0,0.70710678,-0.70710678,0", with, 0),
        ("0,0.70710678,-0.70710678,0", same, 1),
        ("0,0.70710678,0.70710678,0", with, 0),
    ] {
        let [a, b, c] = [pose(0.0, 0.0, same), pose(10.0, 10.0, via), pose(20.0, 0.0, end)];
        let text = format!("MoveJ {a},v10,fine,spindle;\nMoveC {b},{c},v10,fine,spindle;\n");
        let program = run(&text, &settings()).unwrap();
        let told = program.warnings.iter().filter(|note| note.code == Code::AxisIgnored);
        assert_eq!(told.count(), doubts, "{via} {end}");
    }
}

/// Where the robot stands is read back in the frame of the work as it lies there.
#[test]
fn a_position_that_is_read_back_is_one_in_the_work() {
    let place = target(5.0, 6.0, 7.0, "90");
    for (tool, object) in [("spindle", "table"), ("grinder", "part")] {
        let program = run(
            &format!(
                "VAR robtarget here;\nMoveJ {place},v10,fine,{tool}\\WObj:={object};\n\
                 here:=CRobT(\\Tool:={tool}\\WObj:={object});\n\
                 MoveL Offs(here,0,0,1),v10,fine,{tool}\\WObj:={object};\n\
                 here:=CRobT(\\WObj:={object});\n\
                 MoveL Offs(here,0,0,1),v10,fine,{tool}\\WObj:={object};\n"
            ),
            &with_table(),
        );
        let program = program.unwrap();
        let ends: Vec<_> =
            program.moves.iter().map(|each| end(each).1.translation.vector).collect();
        for (step, before) in ends.iter().skip(1).zip(&ends) {
            assert!((step - before - Vector3::z() * 0.001).norm() < CLOSE_M, "{tool}: {ends:?}");
        }
    }
    // A table at 90° has its frame at (1000, 200): in the base (1000 − 6, 200 + 5, 400 + 30 + 7).
    let program = run(
        &format!(
            "VAR robtarget here;\nMoveJ {place},v10,fine,spindle\\WObj:=table;\n\
             here:=CRobT(\\Tool:=spindle\\WObj:=wobj0);\nMoveL here,v10,fine,spindle;\n"
        ),
        &with_table(),
    );
    let found = end(&program.unwrap().moves[1]).1.translation.vector;
    assert!((found - Vector3::new(0.994, 0.205, 0.437)).norm() < CLOSE_M, "{found}");
}

/// Work that is led along a tool that stands: the feed is that of the tool in the work.
#[test]
fn the_feed_of_a_tool_that_stands_is_that_in_the_work() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/irb1600/robot.yaml");
    let robot = read_robot(&file, &mut Reading::default()).unwrap();
    let to = |x: f64, y: f64, z: f64| {
        format!("MoveL {},v10,fine,grinder\\WObj:=part;\n", target(x, y, z, "9E9"))
    };
    // The tool's axes in the work are x, −y and −z; it stands upright in the base.
    for (end, across, into_work, x) in [
        (to(20.0, 0.0, 0.0), true, 0.0, Vector3::x()),
        (to(0.0, 20.0, 0.0), true, 0.0, -Vector3::y()),
        (to(0.0, 0.0, -20.0), false, 1.0, Vector3::x()),
        (to(0.0, 0.0, 20.0), false, -1.0, Vector3::x()),
    ] {
        let program = run(&format!("{}{end}", to(0.0, 0.0, 0.0)), &settings()).unwrap();
        let path = Path::plan(&robot, &program.moves, None).unwrap();
        // 20 mm at 10 mm/s.
        assert!((path.duration_s() - 2.0).abs() < 1e-9);
        for (axes, feed) in tool_frames(&path, &[0.0, 0.5, 1.0]).unwrap() {
            assert_eq!(feed.is_across, across, "{end}");
            assert!((feed.into_work - into_work).abs() < 1e-6, "{end} {feed:?}");
            assert!((axes[0] - x).norm() < 1e-6, "{end} {axes:?}");
            assert!((axes[2] + Vector3::z()).norm() < 1e-6, "{axes:?}");
        }
    }
}
