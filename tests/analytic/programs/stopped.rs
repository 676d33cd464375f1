//! RAPID: moves that the program runs on beside, stops or drops on their way; units that it
//! switches off; data of which it has set a part alone; what every controller has; what the job
//! says in vain.

use std::sync::Arc;

use detune::motion::{MechanicalUnit, Timing, UnitAxis, Work};
use detune::notes::{Class, Code, Note};
use detune::program::{
    Assumed, Dialect, ExternalAxis, Program, SetBy, Setter, Settings, Spindle, read,
};
use nalgebra::{Isometry3, Point3, Unit, Vector3};

use super::support::{assert_ends, at, settings};

const START: &str = "MoveL p,v100,fine,tool0;";
const GO: &str = "MoveL Offs(p,100,0,0),v100,fine,tool0;";
/// Past its end without a stop, and with the program ahead.
const PAST: &str = "MoveL Offs(p,100,100,0),v10,z50,tool0;";
const BESIDE: &str = "MoveL\\Conc,Offs(p,100,100,0),v10,fine,tool0;";
const BACK: &str = "MoveL Offs(p,0,100,0),v100,fine,tool0;";

/// The body begins on line 9; `more` stands behind the procedure, two lines behind the body.
fn run(body: &str, more: &str, job: &Settings) -> Result<Program, Vec<Note>> {
    let text = format!(
        "MODULE m\nCONST robtarget p:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
         VAR robtarget q;\nVAR jointtarget h;\nPERS num x{{3}};\n\
         PERS wobjdata w:=[FALSE,FALSE,\"STN1\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n\
         PERS tooldata t;\nPROC cut()\n{body}\nENDPROC\n{more}\nENDMODULE\n"
    );
    let job = Settings { procedure: Some("cut".to_owned()), ..job.clone() };
    read(text.as_bytes(), Dialect::Rapid, &job)
}

#[track_caller]
fn read_well(body: &str, more: &str, job: &Settings) -> Program {
    run(body, more, job).unwrap_or_else(|found| panic!("{body}: {found:?}"))
}

fn doubts(program: &Program) -> Vec<(Code, usize)> {
    let told = program.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    told.map(|note| (note.code, at(note))).collect()
}

#[track_caller]
fn refused(body: &str, job: &Settings, line: usize, said: &str) {
    let found = run(body, "", job).expect_err(body);
    assert_eq!((at(&found[0]), found.len()), (line, 1), "{body}: {found:?}");
    assert!(found[0].what.contains(said), "{said}: {found:?}");
}

fn assuming(names: &[(&str, f64)]) -> Settings {
    let of = |(name, value): &(&str, f64)| ((*name).to_owned(), Assumed::Number(*value));
    Settings { assume: names.iter().map(of).collect(), ..settings() }
}

fn by_signal(name: &str, per_unit: f64) -> Settings {
    let what = Setter::Signal(name.to_owned());
    Settings { spindle_from: Some(SetBy { what, per_unit }), ..settings() }
}

/// A table that turns about the z axis of the base.
fn with_table() -> Settings {
    let axis = UnitAxis {
        name: "eax_b".to_owned(),
        axis: Unit::new_normalize(Vector3::z()),
        origin_m: Point3::origin(),
        slides: false,
    };
    let frame = Isometry3::identity();
    let unit = MechanicalUnit { name: "STN1".to_owned(), axes: vec![axis], frame };
    let mut job = settings();
    job.mechanical_units.insert("stn1".to_owned(), Arc::new(unit));
    job
}

/// Where the table is at the end of a move, degrees.
#[track_caller]
fn table_at(program: &Program, index: usize) -> f64 {
    match &program.moves[index].work {
        Work::Moves(unit) => unit.to[0].to_degrees().round(),
        other => panic!("{other:?}"),
    }
}

/// Technical reference manual, ClearPath: what is executed in RAPID and not performed is deleted.
#[test]
fn what_drops_the_rest_of_the_path_is_a_doubt() {
    let told = |before: &str, drops: &str| {
        let body = format!("{START}\n{before}\n{drops}\n{BACK}");
        doubts(&read_well(&body, "", &settings()))
    };
    for (drops, lines) in [
        ("StopMove;\nClearPath;\nStartMove;", &[12][..]),
        ("StopMove\\Quick;\nStopMoveReset;", &[12]),
        ("StopMove;\nStorePath;\nRestoPath;\nStartMove;", &[12, 13]),
        // There it stands on its way.
        ("StopMove;\nWaitRob\\ZeroSpeed;\nClearPath;\nStartMove;", &[13]),
        ("IF DInput(di1)=1 THEN\nStopMove;\nClearPath;\nStartMove;\nENDIF", &[11]),
        ("IF DInput(di1)=1 drop;", &[]),
        // A pause.
        ("StopMove;\nWaitTime 1;\nStartMove;", &[]),
    ] {
        let expected: Vec<_> = lines.iter().map(|line| (Code::MotionLeftOut, *line)).collect();
        let is_call = drops.ends_with("drop;");
        for before in [PAST, BESIDE] {
            if is_call {
                let body = format!("{START}\n{before}\n{drops}\n{BACK}");
                let found = read_well(&body, "PROC drop()\nClearPath;\nENDPROC", &settings());
                assert_eq!(doubts(&found), [(Code::MotionLeftOut, 11)]);
            } else {
                assert_eq!(told(before, drops), expected, "{before} {drops}");
            }
        }
        if !is_call {
            assert_eq!(told(GO, drops), [], "{drops}");
        }
    }
}

#[test]
fn a_trap_that_stops_or_drops_the_path_is_a_doubt() {
    let told = |of_trap: &str| {
        let more = format!("TRAP t1\n{of_trap}\nENDTRAP\nPROC drop()\nClearPath;\nENDPROC");
        doubts(&read_well(&format!("{START}\n{GO}"), &more, &settings()))
    };
    for of_trap in [
        "StopMove;\nClearPath;\nStartMove;",
        "ExitCycle;",
        "StopMove;",
        "StorePath;",
        "IF n>3 drop;",
        "StopMoveReset;",
        // They end what is read as if it went on.
        "EXIT;",
        "IF n>3 RAISE 3;",
        "SetSysData w;",
    ] {
        assert_eq!(told(of_trap), [(Code::MotionLeftOut, 12)], "{of_trap}");
    }
    for of_trap in ["StopMove;\nStorePath;\nWaitTime 1;\nRestoPath;\nStartMove;", "Stop;"] {
        assert_eq!(told(of_trap), [], "{of_trap}");
    }
}

/// Technical reference manual, StopMove: movement stays stopped until StartMove.
#[test]
fn an_arm_that_nothing_starts_again_is_a_doubt() {
    let told =
        |between: &str| doubts(&read_well(&format!("{START}\n{between}\n{BACK}"), "", &settings()));
    assert_eq!(told("StopMove;"), [(Code::MotionLeftOut, 11)]);
    assert_eq!(told("StopMove; WaitTime 1; IF DInput(di1)=1 StartMove;").len(), 1);
    assert_eq!(told("IF DInput(di1)=1 StopMove;").len(), 1);
    for between in [
        "StopMove; WaitTime 1; StartMove;",
        "StopMove; StopMoveReset;",
        "IF DInput(di1)=1 THEN StopMove; WaitTime 1; StartMove; ENDIF",
    ] {
        assert_eq!(told(between), [], "{between}");
    }
}

/// Technical reference manual, SetSysData: the tool or work object is the active one from there
/// on, which CRobT and CPos take without arguments; moves name their own.
#[test]
fn what_set_sys_data_activates_counts_until_the_next_move() {
    let more = "PERS wobjdata w1:=[FALSE,TRUE,\"\",[[50,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n\
                PERS tooldata t1:=[TRUE,[[0,0,20],[1,0,0,0]],[2,[0,0,1],[1,0,0,0],0,0,0]];\n\
                PERS loaddata l1:=[3,[0,0,1],[1,0,0,0],0,0,0];";
    let end = |sets: &str| {
        let body = format!("{GO}\n{sets}\nq:=CRobT();\nMoveL q,v100,fine,tool0;");
        let found = read_well(&body, more, &settings());
        let last = found.moves.last().unwrap();
        let at = super::support::end(last).1.translation.vector * 1e3;
        [at.x.round(), at.y.round(), at.z.round()]
    };
    assert_eq!(end(""), [100.0, 0.0, 0.0]);
    assert_eq!(end("SetSysData w1;"), [50.0, 0.0, 0.0]);
    assert_eq!(end("SetSysData t1;"), [100.0, 0.0, 20.0]);
    assert_eq!(end("SetSysData t1; SetSysData w1;"), [50.0, 0.0, 20.0]);
    assert_eq!(end(&format!("SetSysData w1;\n{GO}")), [100.0, 0.0, 0.0]);
    for sets in ["SetSysData w;", "SetSysData t;", "IF DInput(di1)=1 SetSysData w1;"] {
        let body = format!("{START}\n{sets}\nq:=CRobT();\nMoveL q,v100,fine,tool0;");
        let found = run(&body, more, &settings()).expect_err(sets);
        assert!(found[0].what.contains("SetSysData sets what is not known"), "{sets}: {found:?}");
    }
    // A load counts as that of GripLoad.
    let body = format!("MoveL p,v100,fine,t1;\nSetSysData l1;\n{}", GO.replace("tool0", "t1"));
    let found = read_well(&body, more, &settings());
    assert_eq!(found.moves[1].stated.load.as_ref().unwrap().mass_kg, 5.0);
}

/// A signal that a procedure is given is the job's by another name.
#[test]
fn the_signal_of_the_job_is_followed_through_arguments() {
    let more = "PROC speed(VAR signalao s,num v)\nSetAO s,v;\nENDPROC\n\
                PROC outer(VAR signalao a)\nspeed a,150;\nENDPROC\n\
                PROC option(\\VAR signalao s)\nSetAO s,90;\nENDPROC";
    let by = by_signal("ao1", 10.0);
    for (sets, rpm) in
        [("speed ao1,150;", 1500.0), ("outer ao1;", 1500.0), ("option \\s:=ao1;", 900.0)]
    {
        let found = read_well(&format!("{START}\n{sets}\n{GO}"), more, &by);
        let told: Vec<_> = found.spindle.iter().map(|it| it.spindle).collect();
        assert_eq!(told, [Spindle::Turns(Some(rpm))], "{sets}");
        assert_eq!(doubts(&found), [], "{sets}");
    }
    let found = read_well(&format!("{START}\nspeed ao2,5;\n{GO}"), more, &by);
    assert_eq!((found.spindle.len(), doubts(&found)), (0, vec![]));
    let found = run(&format!("{START}\nIF DInput(di1)=1 outer ao1;\n{GO}"), more, &by);
    assert!(found.unwrap_err()[0].what.contains("IF decides about motion"));
    // One that looks like the spindle's, and the job does not read.
    let found = read_well(&format!("{START}\nspeed aoSpindle,9;\n{GO}"), more, &settings());
    assert_eq!(doubts(&found).len(), 1);
}

/// Technical reference manual, MoveL \Conc: what follows is executed while the robot moves.
#[test]
fn what_is_done_beside_a_move_is_a_doubt() {
    let by = by_signal("ao1", 10.0);
    let told = |between: &str, job: &Settings| {
        let body = format!("{START}\nSetAO ao1,15;\n{GO}\n{BESIDE}\n{between}\n{BACK}");
        doubts(&read_well(&body, "", job))
    };
    assert_eq!(told("SetAO ao1,100;", &by), [(Code::SpindleCommand, 13)]);
    assert_eq!(told("WaitTime 1;\nSetAO ao1,100;", &by), [(Code::SpindleCommand, 14)]);
    for waits in ["WaitRob\\InPos;", "WaitTime\\InPos,0;", GO] {
        assert_eq!(told(&format!("{waits}\nSetAO ao1,100;"), &by), [], "{waits}");
    }
    assert_eq!(told("SetDO doAir,1;", &by), []);
    assert_eq!(told("SpeedRefresh 50;", &by), [(Code::ChangeIgnored, 13)]);
    let ask = "WaitTime 1;\nq:=CRobT(\\Tool:=tool0\\WObj:=wobj0);";
    assert_eq!(told(ask, &by), [(Code::MotionLeftOut, 14)]);
    // The first of all moves goes to where the path starts.
    let body = format!("{BESIDE}\nSetAO ao1,15;\n{GO}");
    assert_eq!(doubts(&read_well(&body, "", &by)), []);
    // The wait is over before the arm is there.
    let body = format!("{START}\n{BESIDE}\nWaitTime 1;\n{BACK}");
    let found = read_well(&body, "", &settings());
    let places = [[0.0; 3], [100.0, 100.0, 0.0], [0.0, 100.0, 0.0]];
    assert_ends(&found, &places.map(|place| ('L', place)));
    assert_eq!(doubts(&found), []);
    assert_eq!((found.warnings[0].code, at(&found.warnings[0])), (Code::LeftOut, 11));
    let scheduled = Settings { is_scheduled: true, ..settings() };
    assert_eq!(doubts(&read_well(&body, "", &scheduled)), [(Code::MotionLeftOut, 11)]);
}

/// Technical reference manual, extjoint: an axis that is not activated makes no movement.
#[test]
fn a_unit_that_is_switched_off_stays() {
    let on = |angle: &str| {
        format!(
            "MoveL [[100,0,0],[1,0,0,0],[0,0,0,0],[9E9,{angle},9E9,9E9,9E9,9E9]],v100,fine,\
             tool0\\WObj:=w;"
        )
    };
    let of = |between: &str, last: &str| {
        let body = format!("{}\n{}\n{between}\n{}", on("0"), on("90"), on(last));
        let found = read_well(&body, "", &with_table());
        (table_at(&found, 2), doubts(&found))
    };
    let doubt = vec![(Code::AxisIgnored, 12)];
    assert_eq!(of("DeactUnit STN1;", "0"), (90.0, doubt.clone()));
    assert_eq!(of("DeactUnit STN1;", "90"), (90.0, vec![]));
    assert_eq!(of("DeactUnit STN1; ActUnit STN1;", "0"), (0.0, vec![]));
    assert_eq!(of("IF DInput(di1)=1 DeactUnit STN1;", "0"), (0.0, doubt.clone()));
    // Where it stood before is in no text.
    let first = read_well(&format!("DeactUnit STN1;\n{}", on("90")), "", &with_table());
    assert_eq!((table_at(&first, 0), doubts(&first).len()), (90.0, 1));
    // Of another unit that the job does not know the axis is not.
    assert_eq!(of("DeactUnit STN2;", "0"), (0.0, vec![]));
    let track = |last: &str| {
        let place = |x: &str| format!("[[500,0,0],[1,0,0,0],[0,0,0,0],[{x},9E9,9E9,9E9,9E9,9E9]]");
        let mut job = Settings { joint_count: 7, ..settings() };
        job.external_axes.insert("eax_a".to_owned(), ExternalAxis { joint: 0, slides: true });
        let [a, b] = ["0", last].map(|x| format!("MoveL {},v100,fine,tool0;", place(x)));
        doubts(&read_well(&format!("{a}\nWaitTime 0;\nDeactUnit TRACK;\n{b}"), "", &job))
    };
    assert_eq!((track("1000"), track("0")), (doubt, vec![]));
}

/// Behind a motion to joints the place is not known, and where the external axes are is.
#[test]
fn where_external_axes_are_is_known_behind_joints() {
    let joints = |at: &str, external: &str| {
        format!("MoveAbsJ [[{at},0,0,0,0,0],[9E9,{external},9E9,9E9,9E9]],v100,fine,tool0;")
    };
    let body = |external: &str, to: &str, last: &str| {
        format!(
            "{}\n{}\nq:=CRobT();\nq.extax.eax_b:={to};\nh:=[[0,0,0,0,0,0],q.extax];\n\
             MoveAbsJ h,v100,fine,tool0;\n{last}",
            joints("0", external),
            joints("9", external)
        )
    };
    let last = START.replace("tool0", "tool0\\WObj:=w");
    let found = read_well(&body("30,9E9", "90", &last), "", &with_table());
    assert_eq!((found.moves.len(), table_at(&found, 3), doubts(&found)), (4, 90.0, vec![]));
    let said = "external axis eax_b moves from 30 to 0";
    refused(&body("30,40", "0", ""), &settings(), 14, said);
    let body = format!("{}\nq:=CRobT();\nMoveL q,v100,fine,tool0;", joints("0", "30,9E9"));
    refused(&body, &settings(), 11, "the pose behind a motion to joints");
    let (ask, go) = ("h:=CJointT();", "MoveAbsJ h,v100,fine,tool0;");
    refused(&format!("{START}\n{ask}\n{go}"), &settings(), 11, "CJointT: the joints are known");
    let body = format!("{START}\n{ask}\nh.robax:=[0,0,0,0,30,0];\n{go}");
    let found = read_well(&body, "", &settings());
    assert_eq!((found.moves.len(), doubts(&found)), (2, vec![]));
}

#[test]
fn of_what_is_not_known_as_a_whole_each_part_is_known_once_it_is_set() {
    let body = |parts: &[&str]| format!("{START}\nq:=pElse;\n{}\n{GO}", parts.join("\n"));
    let go = "MoveL q,v100,fine,tool0;";
    let (at, turned) = ("q.trans:=[100,0,0];", "q.rot:=[1,0,0,0];");
    let (found, external) = ("q.robconf:=[0,0,0,0];", "q.extax:=[9E9,9E9,9E9,9E9,9E9,9E9];");
    let of = |parts: &[&str]| doubts(&read_well(&body(parts), "", &settings()));
    assert_eq!(of(&[at, turned, found, external, go]), []);
    assert_eq!(of(&[at, turned, found, go]), [(Code::AxisIgnored, 14)]);
    assert_eq!(of(&[at, turned, external, go]), [(Code::AxisIgnored, 14)]);
    assert_eq!(of(&["ConfL\\Off;", at, turned, external, go]), []);
    refused(&body(&["q.trans.x:=100;", turned, go]), &settings(), 13, "'pElse' is not declared");
    refused(&body(&[at, go]), &settings(), 12, "'pElse' is not declared");
    let part = "q.extax.eax_a:=0;";
    assert_eq!(of(&[at, turned, found, part, go]), [(Code::AxisIgnored, 15)]);
    refused(&body(&[at, turned, found, part, go]), &with_table(), 15, "external axes: 'pElse'");
    refused(&body(&[at, turned, found, go]), &with_table(), 14, "external axes: 'pElse'");
    // A move that has them from there.
    let joints = "h:=[[0,0,0,0,30,0],q.extax];\nMoveAbsJ h,v100,fine,tool0;";
    assert_eq!(of(&[joints]), [(Code::AxisIgnored, 12)]);
    // Elements, and a tool of another task.
    let row = format!("{START}\nx{{1}}:=5;\nMoveL Offs(p,x{{1}},50,0),v100,fine,tool0;");
    assert_ends(&read_well(&row, "", &settings()), &[('L', [0.0; 3]), ('L', [5.0, 50.0, 0.0])]);
    refused(&row.replace("p,x{1}", "p,x{2}"), &settings(), 11, "another task has it");
    let tool = "t.tframe.trans:=[0,0,150];\nMoveL p,v100,fine,t;";
    refused(tool, &settings(), 10, "another task has it");
    let job = Settings { tcp: Some(Isometry3::translation(0.0, 0.0, 0.1)), ..settings() };
    let told = read_well(tool, "", &job);
    assert_eq!(told.moves[0].tcp, job.tcp.unwrap());
    let is_it = |note: &&Note| note.what.ends_with("the job's tcp is used");
    let note = told.warnings.iter().find(is_it).unwrap();
    assert_eq!((note.code, super::support::at(note)), (Code::ChangeIgnored, 10));
}

#[test]
fn what_the_job_assumes_in_vain_is_told() {
    let ask = "TPReadFK reg4,\"?\",\"a\",\"b\",\"c\",\"d\",stEmpty;";
    let body = |before: &str| format!("{START}\n{before}\nTEST reg4\nCASE 3:\n{GO}\nENDTEST");
    let of = |before: &str| {
        let found = read_well(&body(before), "", &assuming(&[("reg4", 3.0)]));
        let told = found.warnings.iter().filter(|note| note.code == Code::Unused);
        (found.moves.len(), told.map(at).collect::<Vec<_>>())
    };
    assert_eq!(of(&format!("IF FALSE THEN\n{ask}\nENDIF")), (1, vec![13]));
    assert_eq!(of("reg4:=3;"), (2, vec![11]));
    assert_eq!(of(ask), (2, vec![]));
    // One that no file declares is what the job says, as the message has it.
    let undeclared = body(ask).replace("reg4", "reg6");
    let found = read_well(&undeclared, "", &assuming(&[("reg6", 3.0)]));
    assert_eq!((found.moves.len(), found.warnings.len()), (2, 0), "{:?}", found.warnings);
    refused(&undeclared, &settings(), 11, "TPReadFK fills in 'reg6'");
}

#[test]
fn what_every_controller_has_needs_no_declaration() {
    let ask = "UIMsgBox \"x\"\\Buttons:=btnOKCancel\\Result:=reg2;";
    for (condition, expected) in [
        ("OpMode()=OP_AUTO", 2),
        ("OpMode()=OP_MAN_PROG", 1),
        ("reg2=resOK", 2),
        ("reg2=resCancel", 1),
        ("RunMode()=RUN_CONT_CYCLE", 2),
    ] {
        let job = assuming(&[("opmode", 1.0), ("reg2", 1.0), ("runmode", 1.0)]);
        let body = format!("{START}\n{ask}\nIF {condition} THEN\n{GO}\nENDIF");
        assert_eq!(read_well(&body, "", &job).moves.len(), expected, "{condition}");
        // The program's own.
        let own = "CONST num resOK:=5;\nCONST num resCancel:=1;";
        if condition.starts_with("reg2") {
            assert_eq!(read_well(&body, own, &job).moves.len(), 3 - expected, "{condition}");
        }
    }
}

#[test]
fn outputs_that_are_on_or_off_set_the_spindle() {
    let by = by_signal("doSpin", 6000.0);
    const FAST: &str = "MoveL Offs(p,0,100,0),v500,fine,tool0;";
    let of =
        |on: &str, off: &str| read_well(&format!("{START}\n{on}\n{GO}\n{off}\n{FAST}"), "", &by);
    for (on, off) in [
        ("Set doSpin;", "Reset doSpin;"),
        ("SetDO doSpin,1;", "SetDO doSpin,0;"),
        ("SetDO doSpin,high;", "SetDO doSpin,low;"),
    ] {
        let found = of(on, off);
        let told: Vec<_> = found.spindle.iter().map(|it| (it.line, it.spindle)).collect();
        let expected = [(10, Spindle::Turns(Some(6000.0))), (12, Spindle::Stands)];
        assert_eq!(told, expected, "{on}");
        assert_eq!(doubts(&found), [], "{on}");
    }
    for (off, said) in [
        ("PulseDO doSpin;", "PulseDO switches"),
        ("InvertDO doSpin;", "InvertDO switches"),
        ("SetDO\\SDelay:=1,doSpin,0;", "later than its instruction"),
    ] {
        let found = of("Set doSpin;", off);
        assert_eq!(doubts(&found), [(Code::SpindleCommand, 12)], "{off}");
        assert!(found.warnings.iter().any(|note| note.what.contains(said)), "{found:?}");
    }
    // Its own value of an output decides, and the line sets nothing else.
    let by = by_signal("ao1", 10.0);
    let asked = |before: &str, branch: &str| {
        let body = format!(
            "{START}\nSetAO ao1,100;\n{GO}\n{before}\nIF AOutput(ao1)=100 THEN\n{branch}\nENDIF\n\
             {BACK}"
        );
        run(&body, "", &by)
    };
    let found = asked("WaitTime 1;", "SetAO ao1,50;").unwrap();
    let told: Vec<_> = found.spindle.iter().map(|it| it.spindle).collect();
    assert_eq!(told, [1000.0, 500.0].map(|rpm| Spindle::Turns(Some(rpm))));
    assert_eq!(doubts(&found), []);
    assert!(asked("Elsewhere;", "SetAO ao1,50;").is_err());
    let found = asked("Elsewhere;", "TPWrite \"a\";").unwrap();
    assert!(doubts(&found).contains(&(Code::SpindleCommand, 13)), "{:?}", found.warnings);
}

#[test]
fn a_stop_point_of_a_time_is_a_dwell() {
    let of = |data: &str, more: &str| {
        let body = format!(
            "{START}\nMoveL Offs(p,100,0,0),v100,z10\\Inpos:={data},tool0;\nq:=CRobT();\n{BACK}"
        );
        let found = read_well(&body, more, &settings());
        let dwell = found.moves.iter().find_map(|each| match each.timing {
            Timing::Seconds(seconds) => Some(seconds),
            _ => None,
        });
        let left_out = found.warnings.iter().filter(|note| note.code == Code::LeftOut).count();
        (dwell, left_out, doubts(&found).len())
    };
    let own = |data: &str| format!("VAR stoppointdata s:=[{data},\"\",0,0];");
    assert_eq!(of("s", &own("2,FALSE,[0,0,0,0],2.5,0")), (Some(2.5), 0, 1));
    assert_eq!(of("s", &own("stoptime,TRUE,[0,0,0,0],2.5,0")), (Some(2.5), 0, 0));
    assert_eq!(of("stoptime0_5", ""), (Some(0.5), 0, 1));
    assert_eq!(of("s", &own("3,TRUE,[0,0,0,0],0,2.5")), (None, 1, 0));
    assert_eq!(of("sElse", ""), (None, 1, 1));
    assert_eq!(of("inpos50", ""), (None, 0, 0));
    // mintime: the least time there.
    assert_eq!(of("s", &own("1,TRUE,[50,50,2,10],0,0")), (Some(2.0), 0, 0));
    assert_eq!(of("s", &own("1,TRUE,[50,50,-1,10],0,0")), (None, 0, 0));
}

/// Which element of an array is set only the run knows: none is known behind it.
#[test]
fn an_element_that_only_the_run_knows_leaves_none_known() {
    let more = "PROC set(INOUT num k)\nk:=900;\nENDPROC\nPROC to(num x)\n\
                MoveL Offs(p,x,0,0),v100,fine,tool0;\nENDPROC";
    for between in ["n{GInput(gi1)}:=900;", "i:=GInput(gi1);\nset n{i};", "Incr n{GInput(gi1)};"] {
        let body = format!("VAR num n{{2}}:=[10,20];\nVAR num i;\n{START}\n{between}\nto n{{2}};");
        let found = run(&body, more, &settings());
        let told = found.expect_err(between);
        assert!(told[0].what.contains("an element of 'n' was set"), "{between}: {told:?}");
    }
}

/// Where the job's speed follows the time, a time that is left out is a doubt.
#[test]
fn a_time_that_is_left_out_counts_where_the_speed_follows_it() {
    let follows = "MoveL Offs(p,100,0,0),v100,fine\\Inpos:=fllwtime0_5,tool0;";
    for between in [follows, "WaitTime GInput(gi1);"] {
        for is_scheduled in [false, true] {
            let job = Settings { is_scheduled, ..settings() };
            let found = read_well(&format!("{START}\n{between}\n{BACK}"), "", &job);
            let is_told = |note: &&Note| note.what.contains("is left out");
            let told: Vec<&Note> = found.warnings.iter().filter(is_told).collect();
            let is_doubt = told.iter().any(|note| note.code.class() == Class::Doubt);
            assert_eq!((told.len(), is_doubt), (1, is_scheduled), "{between}: {told:?}");
        }
    }
}
