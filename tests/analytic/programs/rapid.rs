//! RAPID: frames, instructions, flow.

use std::f64::consts::FRAC_1_SQRT_2;

use detune::motion::{Move, Target};
use detune::notes::{Code, Note};
use detune::program::{
    Assumed, Companion, Dialect, ExternalAxis, Program, SetBy, Setter, Settings, read,
};
use nalgebra::Vector3;

use super::support::{assert_ends, assert_pose, at, end, lines, module, pose, rapid, settings};

const POCKET: &[u8] = include_bytes!("../../data/programs/pocket_latin1_crlf.mod");

/// The work object stands at (900, 0, 400) mm, a quarter turn about z; the object frame in it at
/// (10, 20, 0). So (x, y, z) of a target is (900 − (y + 20), x + 10, 400 + z) in the base.
#[test]
fn pocket_of_a_latin_1_file_with_crlf() {
    let program = read(POCKET, Dialect::Rapid, &settings()).unwrap();
    assert_eq!(lines(&program), [23, 24, 25, 41, 28, 28, 28, 30, 34, 35]);
    let feeds: Vec<f64> = program.moves.iter().map(|each| each.feed_m_per_s).collect();
    let expected = [0.2, 0.1, 0.0125, 0.0125, 0.008, 0.008, 0.008, 0.0125, 0.005, 0.0125];
    assert_eq!(feeds, expected);

    let Target::Joints(home) = &program.moves[0].to else { panic!("MoveAbsJ goes to joints") };
    let degrees: Vec<f64> = home.iter().map(|rad| rad.to_degrees()).collect();
    assert!(
        degrees.iter().zip([0.0, 20.0, -10.0, 0.0, 60.0, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12)
    );
    assert_pose(&program.moves[0].tcp, &pose([0.0; 3], [1.0, 0.0, 0.0, 0.0]));

    let down = [0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2, 0.0];
    let spindle = pose([0.0, 0.0, 150.0], [FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2, 0.0]);
    let expected = [
        ('T', [880.0, 110.0, 450.0], down),
        ('L', [880.0, 110.0, 448.0], down),
        ('L', [880.0, 160.0, 450.0], down),
        ('L', [870.0, 160.0, 450.0], down),
        ('L', [860.0, 160.0, 450.0], down),
        ('L', [850.0, 160.0, 450.0], down),
        ('L', [840.0, 160.0, 450.0], down),
        ('L', [882.0, 111.0, 447.0], [0.0, 1.0, 0.0, 0.0]),
        ('A', [800.0, 110.0, 450.0], down),
    ];
    for (each, (way, at, turned)) in program.moves[1..].iter().zip(expected) {
        assert_eq!(end(each).0, way);
        assert_pose(&end(each).1, &pose(at, turned));
        assert_pose(&each.tcp, &spindle);
    }
    // The via point's quaternion has three digits and length 0.999004.
    let Target::Arc { via, .. } = &program.moves[9].to else { panic!("MoveC is an arc") };
    let quarter = pose([0.0; 3], [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2]);
    let rounded = pose([0.0; 3], [0.002, 0.999, 0.002, 0.0]);
    let mut expected = quarter * rounded;
    expected.translation = pose([840.0, 160.0, 450.0], [1.0, 0.0, 0.0, 0.0]).translation;
    assert_pose(via, &expected);

    assert_eq!(program.warnings.len(), 1, "{:?}", program.warnings);
    assert_eq!(at(&program.warnings[0]), 22);
    assert!(program.warnings[0].what.contains("looks like a command to the spindle"));
    assert!(program.spindle.is_empty());
}

#[test]
fn a_quaternion_and_its_negative_are_one_rotation_and_come_out_alike() {
    let at = |q: &str| {
        let text = module(&format!(
            "MoveL [[1,2,3],{q},[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;"
        ));
        end(&rapid(&text).moves[0]).1.rotation
    };
    let (positive, negative) = (at("[0.5,0.5,-0.5,0.5]"), at("[-0.5,-0.5,0.5,-0.5]"));
    // Number by number: as rotations the two would be equal anyway.
    assert_eq!(positive.coords, negative.coords);
    assert_eq!((negative.w, negative.i, negative.j, negative.k), (0.5, 0.5, -0.5, 0.5));
}

#[test]
fn tool_axes_and_turns_of_rel_tool() {
    // x first, then the new y: Rx(90)·Ry(90) takes the tool's z axis to the old x axis.
    let program = rapid(&module("MoveL RelTool(p,0,0,10\\Rx:=90\\Ry:=90),v5,fine,tool0;"));
    let found = end(&program.moves[0]).1;
    let z = found.rotation * nalgebra::Vector3::z();
    assert!((z - nalgebra::Vector3::x()).norm() < 1e-12, "{z}");
    let y = found.rotation * nalgebra::Vector3::y();
    assert!((y - nalgebra::Vector3::z()).norm() < 1e-12, "{y}");
    assert_ends(&program, &[('L', [100.0, 200.0, 310.0])]);
}

#[test]
fn the_job_fills_what_the_program_leaves_to_it_and_no_more() {
    let tcp = pose([0.0, 0.0, 100.0], [1.0, 0.0, 0.0, 0.0]);
    let object = pose([1000.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
    let job = Settings { tcp: Some(tcp), work_object: Some(object), ..settings() };
    let text = module(
        "MoveL p,v5,fine,tool0;\nMoveL p,v5,fine,tElse\\WObj:=wobj0;\nMoveL p,vElse,fine,tElse\\WObj:=wElse;\n\
         MoveL p,v5,fine,tHere\\WObj:=wHere;",
    )
    .replace(
        "PROC main",
        "PERS tooldata tHere:=[TRUE,[[0,0,7],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\
         PERS wobjdata wHere:=[FALSE,TRUE,\"\",[[0,5,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];PROC main",
    );
    let program = read(text.as_bytes(), Dialect::Rapid, &job).unwrap();
    assert_ends(
        &program,
        &[
            // The controller's own, beside those for which the job's stand.
            ('L', [100.0, 200.0, 300.0]),
            ('L', [100.0, 200.0, 300.0]),
            ('L', [1100.0, 200.0, 300.0]),
            ('L', [100.0, 205.0, 300.0]),
        ],
    );
    assert_pose(&program.moves[0].tcp, &pose([0.0; 3], [1.0, 0.0, 0.0, 0.0]));
    for each in &program.moves[1..3] {
        assert_pose(&each.tcp, &tcp);
    }
    assert_pose(&program.moves[3].tcp, &pose([0.0, 0.0, 7.0], [1.0, 0.0, 0.0, 0.0]));
    assert_eq!(program.moves[2].feed_m_per_s, 0.01);
    let told: Vec<(usize, &str)> =
        program.warnings.iter().map(|notice| (at(notice), notice.what.as_str())).collect();
    let own = |name: &str, of_job: &str| {
        format!(
            "a line or arc with {name}: that is the controller's own, as the job's {of_job} stands for \
             what no file that is read declares; path.program.files can name the file that does"
        )
    };
    let [tool, object] = [own("tool0", "tcp"), own("wobj0", "work_object")];
    assert_eq!(
        told,
        [
            (4, tool.as_str()),
            (4, object.as_str()),
            (5, "tool: 'tElse' is not declared in this file; the job's tcp is used"),
            (6, "work object: 'wElse' is not declared in this file; the job's work_object is used"),
            (6, "speed: 'vElse' is not declared in this file; the job's feed is used"),
            (7, "the program declares its tool: the job's tcp is not used there"),
            (7, "the program declares its work object: the job's work_object is not used there"),
        ]
    );
}

/// Beside frames that the program declares, the controller's own seldom stand for the job's.
#[test]
fn own_frames_beside_declared_ones_are_doubted() {
    let frame = |z: f64| Some(pose([0.0, 0.0, z], [1.0, 0.0, 0.0, 0.0]));
    let told = |moves: &str, tcp: Option<f64>| -> Vec<(usize, String)> {
        let job = Settings {
            tcp: tcp.and_then(frame),
            work_object: tcp.and_then(|z| frame(2.0 * z)),
            ..settings()
        };
        let text = module(moves).replace(
            "PROC main",
            "PERS tooldata tHere:=[TRUE,[[0,0,7],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\
             PERS wobjdata wHere:=[FALSE,TRUE,\"\",[[0,5,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];PROC main",
        );
        let found = read(text.as_bytes(), Dialect::Rapid, &job).unwrap().warnings;
        let doubts = found.into_iter().filter(|note| note.code == Code::ChangeIgnored);
        doubts.map(|note| (at(&note), note.what)).collect()
    };
    let line = |tool: &str| format!("MoveL p,v5,fine,{tool};\n");
    let both = line("tHere\\WObj:=wHere") + &line("tool0");
    let found = told(&both, Some(100.0));
    assert_eq!(found.iter().map(|(line, _)| *line).collect::<Vec<_>>(), [5, 5]);
    assert!(found[0].1.contains("the job's tcp is taken for it"), "{found:?}");
    assert!(found[1].1.contains("the job's work_object is taken for it"), "{found:?}");
    // Only one kind, joint moves, or frames of the job that are the controller's own.
    for (moves, tcp) in [
        (line("tHere\\WObj:=wHere"), Some(100.0)),
        (line("tool0"), Some(100.0)),
        (format!("{}MoveJ p,v5,fine,tool0;", line("tHere\\WObj:=wHere")), Some(100.0)),
        (both.clone(), None),
        (both.clone(), Some(0.0)),
    ] {
        assert_eq!(told(&moves, tcp), [], "{moves}");
    }
}

/// The move sets the output, whatever has set it before in its line.
#[test]
fn a_move_that_sets_the_spindle_beside_its_setting_is_doubted() {
    let what = Setter::Signal("aoSpindle".to_owned());
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    for (statements, expected) in [
        ("SetAO aoSpindle,8000; MoveLAO p,v5,fine,tool0,aoSpindle,4000;", 1),
        ("SetAO aoSpindle,8000; TriggIO t,0\\AOp:=aoSpindle,0; TriggL p,v5,t,fine,tool0;", 1),
        ("SetAO aoSpindle,8000; MoveLDO p,v5,fine,tool0,doA,1;", 0),
        ("SetAO aoSpindle,8000; MoveL p,v5,fine,tool0; SetAO aoSpindle,4000;", 0),
    ] {
        let found = read(module(statements).as_bytes(), Dialect::Rapid, &job).unwrap().warnings;
        let doubts = found.iter().filter(|note| note.what.contains("nothing that it sets is read"));
        assert_eq!(doubts.count(), expected, "{statements}: {found:?}");
    }
}

/// Technical reference manual, RAISE: with no handler left the program stops; UNDO runs where an
/// error leaves the routine.
#[test]
fn a_handler_behind_which_nothing_goes_on_sets_no_spindle() {
    let what = Setter::Signal("aoSpindle".to_owned());
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1000.0 }), ..settings() };
    for (handler, more, expected) in [
        ("ERROR\nSetAO aoSpindle,0;\nEXIT;", "", 0),
        ("ERROR\nSetAO aoSpindle,0;\nRAISE;", "", 0),
        ("UNDO\nSetAO aoSpindle,0;", "", 0),
        // In its own line, before the handler, the instruction runs.
        ("ERROR SetAO aoSpindle,0;\nEXIT;", "", 1),
        ("ERROR\nSetAO aoSpindle,0;\nUNDO\nEXIT;", "", 1),
        ("ERROR\nSetAO aoSpindle,0;\nTRYNEXT;", "", 1),
        ("ERROR\nSetAO aoSpindle,0;\nRAISE;", "ERROR\nRETURN;", 1),
        ("UNDO\nSetAO aoSpindle,0;", "ERROR\nRETURN;", 1),
        ("ERROR\nSetAO aoSpindle,0;\nExitCycle;", "", 1),
    ] {
        let body = format!(
            "SetAO aoSpindle,3;\nMoveL p,v5,fine,tool0;\nsub;\n{more}\nENDPROC\nPROC sub()\n\
             MoveL Offs(p,9,0,0),v5,fine,tool0;\n{handler}"
        );
        let found = read(module(&body).as_bytes(), Dialect::Rapid, &job).unwrap().warnings;
        let doubts = found.iter().filter(|note| note.what.contains("nothing that it sets is read"));
        assert_eq!(doubts.count(), expected, "{handler} {more}: {found:?}");
    }
}

#[test]
fn flow_as_the_controller_has_it() {
    let text = "MODULE m
VAR num n:=0;
VAR robtarget q;
RECORD hole pos at; num deep; ENDRECORD
CONST hole holes{2}:=[[[10,0,0],5],[[20,0,0],6]];
PERS robtarget p:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
  WHILE n<2 DO
    Incr n;
    go n;
  ENDWHILE
  FOR i FROM 3 TO 1 DO
    IF i=2 THEN
      go 20;
    ELSEIF i>2 AND NOT FALSE THEN
      go 30+i;
    ELSE
      go 10;
    ENDIF
  ENDFOR
  TEST n
  CASE 0,1: go 99;
  CASE 2: go 200 DIV 3;
  DEFAULT: go 98;
  ENDTEST
  q:=p;
  q.trans:=holes{2}.at+[0,0,holes{2}.deep]*2;
  q.trans.y:=Round(1.26\\Dec:=1)*Sqrt(4);
  MoveL q,v10,fine,tool0;
  MoveL CRobT(),v10,fine,tool0;
  twice n;
  go n;
  IF n>3 RETURN;
  go 97;
ERROR
  go 96;
ENDPROC
PROC go(num x)
  MoveL Offs(p,x-1,-2,-3),v10,fine,tool0;
ENDPROC
PROC twice(INOUT num x)
  x:=2*x;
ENDPROC
ENDMODULE";
    let program = rapid(text);
    let x: Vec<f64> =
        program.moves.iter().map(|each| (end(each).1.translation.x * 1e3).round()).collect();
    assert_eq!(x, [1.0, 2.0, 33.0, 20.0, 10.0, 66.0, 20.0, 20.0, 4.0]);
    assert_pose(&end(&program.moves[6]).1, &pose([20.0, 2.6, 12.0], [1.0, 0.0, 0.0, 0.0]));
    assert_pose(&end(&program.moves[7]).1, &end(&program.moves[6]).1);
    assert_eq!(lines(&program), [39, 39, 39, 39, 39, 39, 29, 30, 39]);
}

#[test]
fn an_endless_loop_is_read_once_and_told() {
    let program =
        rapid(&module("MoveL p,v5,fine,tool0;\nWHILE TRUE DO\nMoveJ p,v5,fine,tool0;\nENDWHILE"));
    assert_eq!(lines(&program), [4, 6]);
    assert_eq!(program.warnings.len(), 1);
    assert_eq!(at(&program.warnings[0]), 5);
}

/// A condition that stays TRUE is no other than TRUE; what may change it is not left out.
#[test]
fn a_loop_whose_condition_stays_true_is_read_once() {
    let of = |data: &str, condition: &str, more: &str| {
        let body = format!(
            "{data}\nMoveL p,v5,fine,tool0;\nWHILE {condition} DO\n\
             MoveL Offs(p,9,0,0),v5,fine,tool0;\n{more}\nENDWHILE\nMoveL p,v5,fine,tool0;"
        );
        let text = module(&body).replace(
            "ENDMODULE",
            "PERS bool go:=TRUE;\nVAR bool on:=TRUE;\nPROC sets(INOUT bool b)\nb:=FALSE;\n\
             ENDPROC\nPROC stops()\non:=FALSE;\nENDPROC\nENDMODULE",
        );
        read(text.as_bytes(), Dialect::Rapid, &settings())
    };
    for (data, condition) in [
        ("VAR bool a:=TRUE;", "a=TRUE"),
        ("VAR bool a:=TRUE;", "a"),
        ("", "1=1"),
        ("", "NOT FALSE"),
        ("VAR num n:=1;", "n<2 AND on"),
    ] {
        let found = of(data, condition, "WaitTime 0;").unwrap();
        assert_eq!(lines(&found), [5, 7], "{condition}");
        let told: Vec<_> = found.warnings.iter().map(|note| (note.code, at(note))).collect();
        assert_eq!(told, [(Code::MotionLeftOut, 6)], "{condition}: {:?}", found.warnings);
    }
    // What the loop, or what it calls, sets ends it.
    for (data, condition, more) in [
        ("VAR bool a:=TRUE;", "a=TRUE", "a:=FALSE;"),
        ("VAR bool a:=TRUE;", "a=TRUE", "sets a;"),
        ("", "on", "sets on;"),
        ("", "on", "stops;"),
        ("VAR num n:=1;", "n<2", "Incr n;"),
    ] {
        let found = of(data, condition, more).unwrap();
        let is_endless = found.warnings.iter().any(|note| note.what.contains("an endless loop"));
        assert_eq!((lines(&found), is_endless), (vec![5, 7, 10], false), "{more}");
    }
    // It may end where RETURN, another task or the run says.
    let found = of("VAR num n:=1;", "TRUE=TRUE", "n:=n+1;\nIF n=3 RETURN;").unwrap();
    assert_eq!(lines(&found), [5, 7, 7]);
    let waits = module("WHILE go DO\nWaitTime 0;\nENDWHILE\nMoveL p,v5,fine,tool0;")
        .replace("PROC main", "PERS bool go:=TRUE;\nPROC main");
    let found = read(waits.as_bytes(), Dialect::Rapid, &settings()).unwrap();
    assert_eq!(lines(&found), [8]);
}

/// Technical reference manual: bit 1 is the lowest of a byte's 8 and of a dnum's 52.
#[test]
fn bits_are_set_cleared_and_asked_for() {
    let ends = |statements: &str, x: &str| {
        let body = format!(
            "VAR byte b:=0;\nVAR dnum d:=0;\nMoveL p,v5,fine,tool0;\n{statements}\n\
             MoveL Offs(p,{x},0,0),v5,fine,tool0;"
        );
        let found = read(module(&body).as_bytes(), Dialect::Rapid, &settings());
        found.map(|found| (end(&found.moves[1]).1.translation.x * 1e3).round() - 100.0)
    };
    for (statements, x, expected) in [
        ("BitSet b,1;\nBitSet b,3;", "b", 5.0),
        ("b:=255;\nBitClear b,8;\nBitClear b,8;", "b", 127.0),
        ("BitSet d,10;", "d", 512.0),
        ("b:=12;", "BitAnd(b,10)", 8.0),
        ("b:=12;", "BitOr(b,10)", 14.0),
        ("b:=12;", "BitXOr(b,10)", 6.0),
        ("b:=12;", "BitNeg(b)", 243.0),
        ("b:=193;", "BitLSh(b,1)", 130.0),
        ("b:=193;", "BitRSh(b,6)", 3.0),
        ("d:=512;", "BitRShDnum(d,8)", 2.0),
        ("b:=4;\nIF BitCheck(b,3) AND NOT BitCheck(b,2) d:=7;", "d", 7.0),
    ] {
        assert_eq!(ends(statements, x).unwrap(), expected, "{statements} {x}");
    }
    for (statements, x, said) in [
        ("BitSet b,9;", "b", "expected a whole number from 1 to 8, found 9"),
        ("BitSet b,GInput(g);", "b", "known only at run time"),
        ("b:=300;", "BitAnd(b,1)", "expected a whole number from 0 to 255, found 300"),
    ] {
        let told = ends(statements, x).expect_err(statements);
        assert!(told[0].what.contains(said), "{statements}: {told:?}");
    }
}

#[test]
fn speeds_by_time_override_and_limit() {
    // 30 mm in 2 s; half of 100 mm/s; limited to 20 mm/s; a half circle of radius 10 mm in 1 s.
    let program = rapid(&module(
        "MoveL p,v100,fine,tool0;\nMoveL Offs(p,30,0,0),v100\\T:=2,fine,tool0;\n\
         VelSet 50,5000;\nMoveL p,v100,fine,tool0;\nVelSet 100,20;\nMoveJ p,v100,fine,tool0;\n\
         MoveC Offs(p,10,10,0),Offs(p,20,0,0),v100\\T:=1,fine,tool0;",
    ));
    let feeds: Vec<f64> = program.moves.iter().map(|each| each.feed_m_per_s).collect();
    let expected = [0.1, 0.015, 0.05, 0.02, 0.01 * std::f64::consts::PI];
    for (found, expected) in feeds.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{feeds:?}");
    }
}

#[test]
fn the_procedure_is_chosen_by_name_in_any_case() {
    let text = "MODULE m\nPROC a()\nMoveAbsJ [[1,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;\nENDPROC\n\
                PROC b(\\switch s)\nMoveAbsJ [[2,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;\nENDPROC\nENDMODULE";
    let named = |name: &str| {
        let settings = Settings { procedure: Some(name.to_owned()), ..settings() };
        read(text.as_bytes(), Dialect::Rapid, &settings)
    };
    assert_eq!(lines(&named("B").unwrap()), [6]);
    assert_eq!(lines(&named("a").unwrap()), [3]);
    let missing = named("c").unwrap_err();
    assert_eq!(
        missing[0].what,
        "no procedure 'c' without arguments in this file; there are: 'a', 'b'"
    );
    let none = super::support::faults(text, Dialect::Rapid);
    assert_eq!(none[0].what, "no procedure 'main'; name one of: 'a', 'b'");
}

#[test]
fn a_condition_of_the_run_is_harmless_where_nothing_moves() {
    let program = rapid(&module(
        "VAR num x:=1;\nIF DInput(di1)=1 THEN\nTPWrite \"a\";\nx:=2;\nENDIF\nMoveL p,v5,fine,tool0;",
    ));
    assert_eq!(lines(&program), [9]);
}

#[test]
fn things_beside_the_motion_are_told_once_and_left_out() {
    let program = rapid(&module(
        "MoveL p,v5,fine,tool0;\nCalibWrist;\nCalibWrist;\nSpindleOn 12000;\n\
         MoveL [[1,2,3],[1,0,0,0],[0,0,0,0],[0,9E9,9E9,9E9,9E9,9E9]],vmax,fine,tool0;",
    ));
    let told: Vec<_> = program.warnings.iter().map(at).collect();
    assert_eq!(told, [5, 7, 8], "{:?}", program.warnings);
    assert_eq!(program.moves[1].feed_m_per_s, 5.0);
}

/// The first tool ends 100 mm before the flange's z, the second 40 mm: at the change the centre point goes
/// back by 60 mm without a move. From there to the next target it is 80 mm in y: 100 mm in all.
#[test]
fn a_time_is_for_the_way_of_the_tool_that_moves() {
    let tool = |name: &str, z: f64| {
        format!("PERS tooldata {name}:=[TRUE,[[0,0,{z}],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];")
    };
    let text = module("MoveL p,v5,fine,long;\nMoveL Offs(p,0,80,0),v5\\T:=4,fine,short;")
        .replace("PROC main", &(tool("long", 100.0) + &tool("short", 40.0) + "\nPROC main"));
    let program = rapid(&text);
    let feed = program.moves[1].feed_m_per_s;
    assert!((feed - 0.1 / 4.0).abs() < 1e-12, "{feed}");
}

#[test]
fn wobj0_by_name_is_the_job_s_and_says_so() {
    let work_object = pose([900.0, 0.0, 400.0], [1.0, 0.0, 0.0, 0.0]);
    let job = Settings { work_object: Some(work_object), ..settings() };
    let named = module("MoveL p,v5,fine,tool0;\nMoveL p,v5,fine,tool0\\WObj:=wobj0;");
    let program = read(named.as_bytes(), Dialect::Rapid, &job).unwrap();
    assert_ends(&program, &[('L', [1000.0, 200.0, 700.0]), ('L', [1000.0, 200.0, 700.0])]);
    assert_eq!(program.warnings.len(), 1, "{:?}", program.warnings);
    assert_eq!(at(&program.warnings[0]), 5);
    assert!(program.warnings[0].what.contains("job's work_object is used"));
    // Without a frame in the job there is nothing to choose between.
    assert!(rapid(&named).warnings.is_empty());
}

/// One value of a CASE that matches is enough; those behind it are not looked at.
#[test]
fn a_test_that_is_decided_needs_no_other_value() {
    for cases in [
        "CASE kElse,2: MoveL p,v5,fine,tool0;",
        "CASE 2: MoveL p,v5,fine,tool0;\nCASE kElse: RAISE;",
    ] {
        let program = rapid(&module(&format!("TEST 2\n{cases}\nDEFAULT: Stop;\nENDTEST")));
        assert_eq!(program.moves.len(), 1, "{cases}");
    }
}

/// As many targets as a controller holds, written out, are no growth.
#[test]
fn a_long_table_of_targets_is_read() {
    let target = "[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let table = vec![target; 3000].join(",");
    let text = module("FOR i FROM 1 TO 3000 DO\nMoveL t{i},v5,fine,tool0;\nENDFOR")
        .replace("PROC main", &format!("CONST robtarget t{{3000}}:=[{table}];PROC main"));
    assert_eq!(rapid(&text).moves.len(), 3000);
}

const LOADS: &str = "MODULE m
CONST robtarget p:=[[100,200,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PERS tooldata t:=[TRUE,[[0,0,100],[0,1,0,0]],[4,[0,0,50],[1,0,0,0],0,0,0]];
PERS tooldata bare:=[TRUE,[[0,0,100],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];
PERS loaddata part:=[1,[0,0,-50],[1,0,0,0],0.1,0.2,0.3];
PERS loaddata both:=[9,[0,0,70],[1,0,0,0],0,0,0];
PROC main()
";

fn loads(instructions: &str) -> Program {
    let text = format!("{LOADS}{instructions}\nENDPROC\nENDMODULE\n");
    read(text.as_bytes(), Dialect::Rapid, &settings()).unwrap()
}

fn masses(program: &Program) -> Vec<Option<f64>> {
    let load = |each: &Move| each.stated.load.as_ref().map(|load| load.mass_kg);
    program.moves.iter().map(load).collect()
}

/// ABB's Technical reference manual, RAPID instructions: GripLoad specifies the payload that the
/// robot holds, load0 lets it go; the centre of a payload is in the tool's frame, that of a tool in
/// the wrist's; \TLoad is the total load, tool and payload, unless it is load0.
#[test]
fn what_the_gripper_holds_counts_with_the_tool() {
    let move_t = "MoveL p,v5,fine,t;\n";
    let program = loads(&format!(
        "{move_t}GripLoad part;\n{move_t}MoveL p,v5,fine,t\\TLoad:=both;\n\
         MoveL p,v5,fine,t\\TLoad:=load0;\nGripLoad load0;\n{move_t}"
    ));
    assert_eq!(masses(&program), [4.0, 5.0, 9.0, 5.0, 4.0].map(Some));
    // The tool's frame is half a turn about x, 100 mm out: the part lies at 100 + 50 mm.
    let held = program.moves[1].stated.load.clone().unwrap();
    assert!((held.com_m - Vector3::new(0.0, 0.0, (4.0 * 0.05 + 0.15) / 5.0)).norm() < 1e-12);
    // Two points 100 mm apart, reduced mass 0.8 kg, about x and y.
    let apart = 0.8 * 0.1 * 0.1;
    let found = [held.inertia_kgm2[(0, 0)], held.inertia_kgm2[(1, 1)], held.inertia_kgm2[(2, 2)]];
    for (found, expected) in found.into_iter().zip([0.1 + apart, 0.2 + apart, 0.3]) {
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
    assert!(program.warnings.is_empty(), "{:?}", program.warnings);
}

#[test]
fn a_load_that_is_not_known_is_a_doubt() {
    for (instructions, line, said) in [
        ("GripLoad elsewhere;\nMoveL p,v5,fine,t;", 9, "elsewhere"),
        ("GripLoad part;\nMoveL p,v5,fine,bare;", 9, "adds 1 kg to a tool whose load"),
        ("IF DInput(di)=1 GripLoad part;\nMoveL p,v5,fine,t;", 9, "depends on a condition"),
        ("MoveL p,v5,fine,t\\TLoad:=elsewhere;", 8, "TLoad"),
    ] {
        let program = loads(instructions);
        assert_eq!(masses(&program), [None], "{instructions}");
        let doubts: Vec<_> =
            program.warnings.iter().filter(|w| w.code == Code::ChangeIgnored).collect();
        assert_eq!(doubts.len(), 1, "{instructions}: {:?}", program.warnings);
        assert!(doubts[0].what.contains(said), "{instructions}: {doubts:?}");
        assert_eq!(at(doubts[0]), line, "{instructions}");
    }
    // What a unit beside the robot carries does not count, unless it is a joint of the robot.
    let text =
        format!("{LOADS}MechUnitLoad STN1,1,part;\nMoveL p,v5,fine,t;\nENDPROC\nENDMODULE\n");
    let mut job = settings();
    assert!(read(text.as_bytes(), Dialect::Rapid, &job).unwrap().warnings.is_empty());
    job.external_axes.insert("eax_a".to_owned(), ExternalAxis { joint: 0, slides: true });
    let warnings = read(text.as_bytes(), Dialect::Rapid, &job).unwrap().warnings;
    assert!(warnings[0].what.contains("STN1 carries"), "{warnings:?}");
}

/// A jump goes to a label of a block around it; moves that it passes over for good are a doubt.
#[test]
fn jumps_go_to_labels() {
    let at = |x: f64| format!("MoveL Offs(p,{x},0,0),v5,fine,tool0;");
    let text = module(&format!(
        "VAR num n:=0;\n{}\nagain:\nIF n=2 THEN\nGOTO out;\nENDIF\nn:=n+1;\n{}\nGOTO again;\n\
         out:\nWaitTime .5;\n{}",
        at(0.0),
        at(1.0),
        at(2.0)
    ));
    let program = rapid(&text);
    // The first, twice the second, the wait and the last.
    assert_eq!(lines(&program), [5, 11, 11, 14, 15]);
    assert_eq!(program.moves[3].timing, detune::motion::Timing::Seconds(0.5));
    let passed = rapid(&module(&format!("{}\nGOTO out;\n{}\nout:\n{}", at(0.0), at(1.0), at(2.0))));
    assert_eq!(passed.moves.len(), 2);
    assert!(passed.warnings.iter().any(|note| note.code == Code::MotionLeftOut), "{passed:?}");
}

/// Instructions from line 4 on, data and routines behind them, and what the job assumes.
fn assuming(body: &str, more: &str, assumed: &[(&str, Assumed)]) -> Result<Program, Vec<Note>> {
    let text = module(body).replace("ENDMODULE", &format!("{more}\nENDMODULE"));
    let assume = assumed.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    read(text.as_bytes(), Dialect::Rapid, &Settings { assume, ..settings() })
}

/// Lines of what may move and is not read.
fn left_out(program: &Program) -> Vec<usize> {
    program.warnings.iter().filter(|note| note.code == Code::MotionLeftOut).map(at).collect()
}

/// A loop that moves until an input, a clock or another task changes: the job says of one moment what it is.
#[test]
fn a_loop_that_others_end_is_read_once() {
    const MOVE: &str = "MoveL p,v5,fine,tool0;";
    let of = |condition: &str, inside: &str, assumed: &[(&str, Assumed)]| {
        let body = format!("{MOVE}\nWHILE {condition} DO\n{inside}\nENDWHILE\n{MOVE}");
        assuming(&body, "PERS bool run:=TRUE;\nVAR num n:=0;", assumed)
    };
    let said = |name: &'static str, value: bool| [(name, Assumed::Truth(value))];
    for (condition, assumed) in [
        ("di1=0", &said("di1", false)[..]),
        ("DInput(di1)=0", &said("di1", false)),
        ("n=0 AND di1=0", &said("di1", false)),
        ("di1=0 AND StrToVal(\"2\",n)", &said("di1", false)),
        ("ClkRead(c)<5", &[("clkread", Assumed::Number(3.0))]),
        ("run", &[]),
        ("run", &said("run", true)),
    ] {
        let found = of(condition, MOVE, assumed).unwrap();
        assert_eq!(lines(&found), [4, 6, 8], "{condition}");
        assert!(left_out(&found).contains(&5), "{condition}: {:?}", found.warnings);
    }
    // What decides without the job, what the job says is not so, and waiting.
    for (condition, inside, assumed) in [
        ("di1=0", MOVE, said("di1", true)),
        ("DInput(di1)=0", MOVE, said("di1", true)),
        ("ClkRead(c)<5", MOVE, [("clkread", Assumed::Number(9.0))]),
        ("n>0 AND di1=0", MOVE, said("di1", false)),
        ("run", MOVE, said("run", false)),
        ("di1=0", "WaitTime 0.1;", said("di1", true)),
    ] {
        let found = of(condition, inside, &assumed).unwrap();
        assert_eq!((lines(&found), left_out(&found)), (vec![4, 8], vec![]), "{condition}");
    }
    // What the loop sets, or leaves.
    let counted = of("n<2 AND di1=0", &format!("{MOVE}\nn:=n+1;"), &said("di1", false)).unwrap();
    assert_eq!(lines(&counted), [4, 6, 6, 9]);
    let left = of("run", &format!("{MOVE}\nn:=n+1;\nIF n=2 RETURN;"), &said("run", true));
    assert_eq!(lines(&left.unwrap()), [4, 6, 6]);
}

/// `WaitDI di1,0` goes on where the input is no longer what the job says.
#[test]
fn behind_a_wait_the_message_says_that_assume_holds_no_longer() {
    for asked in ["di1=1", "DInput(di1)=1"] {
        let body = format!("WaitDI di1,0;\nIF {asked} MoveL p,v5,fine,tool0;");
        let found = assuming(&body, "", &[("di1", Assumed::Truth(true))]).unwrap_err();
        assert_eq!(at(&found[0]), 5, "{found:?}");
        assert!(found[0].what.contains("holds until something sets it or waits"), "{found:?}");
        assert!(!found[0].what.contains("assume: "), "{found:?}");
    }
}

/// Technical reference manual: CallByVar "proc",2 calls proc2; %"proc2"% does so, too.
#[test]
fn procedures_are_called_by_names_in_strings() {
    let at = |x: f64| format!("MoveL Offs(p,{x},0,0),v5,fine,tool0;");
    let more = format!(
        "CONST string named:=\"GO2\";\nPROC go1()\n{}\nENDPROC\nPROC Go2()\n{}\nENDPROC\n\
         PROC there(num x)\nMoveL Offs(p,x,0,0),v5,fine,tool0;\nENDPROC",
        at(1.0),
        at(2.0)
    );
    let of = |call: &str, assumed: &[(&str, Assumed)]| {
        assuming(&format!("VAR num n:=2;\n{}\n{call}", at(0.0)), &more, assumed)
    };
    for (call, expected) in [
        ("%\"go1\"%;", 1.0),
        ("%\"Go\"+ValToStr(n)%;", 2.0),
        ("%\"go\"+NumToStr(n-1,0)%;", 1.0),
        ("%named%;", 2.0),
        ("%\"there\"% 7;", 7.0),
        ("%\"the\"+\"re\"% n+1;", 3.0),
        ("CallByVar \"go\",n;", 2.0),
        ("FOR i FROM 1 TO n DO\nCallByVar \"go\",i;\nENDFOR", 2.0),
    ] {
        let found = of(call, &[]).unwrap_or_else(|found| panic!("{call}: {found:?}"));
        let last = end(found.moves.last().unwrap()).1.translation.x * 1e3 - 100.0;
        assert!((last - expected).abs() < 1e-6, "{call}: {last}");
        assert_eq!(left_out(&found), [0; 0], "{call}: {:?}", found.warnings);
    }
    // One that is in no file is a doubt, as where it is named in the text.
    for call in ["gone;", "%\"gone\"%;", "%\"gone\"+ValToStr(n)%;", "CallByVar \"go\",n+1;"] {
        let found = of(call, &[]).unwrap();
        assert_eq!((found.moves.len(), left_out(&found)), (1, vec![6]), "{call}");
        assert!(!format!("{:?}", found.warnings).contains("CallByVar"), "{:?}", found.warnings);
    }
    let found = of("%\"gone\"+ValToStr(n)%;", &[]).unwrap();
    assert!(found.warnings[0].what.starts_with("'gone2' is not in this file"), "{found:?}");
    // A signal is 1 or 0, and a bool TRUE or FALSE.
    let asked = "CallByVar \"go\",di1;";
    let found = of(asked, &[("di1", Assumed::Truth(true))]).unwrap_err();
    assert!(found[0].what.contains("assume: {\"di1\": 1} in the job says that"), "{found:?}");
    assert_eq!(of(asked, &[("di1", Assumed::Number(1.0))]).unwrap().moves.len(), 2);
    // Which one only the run knows.
    let asked = "CallByVar \"go\",GInput(gi1);";
    let found = of(asked, &[]).unwrap_err();
    let said = "a call by a name in a string decides about motion at run time";
    assert!(found[0].what.contains(said), "{found:?}");
    assert!(found[0].what.contains("assume: {\"gi1\": …}"), "{found:?}");
    assert_eq!(of(asked, &[("gi1", Assumed::Number(2.0))]).unwrap().moves.len(), 2);
}

/// A LOCAL procedure is seen in its module alone, by a name in a string, too.
#[test]
fn a_name_in_a_string_is_no_local_procedure_of_another_module() {
    const MOVE: &str = "MoveL p,v5,fine,tool0;";
    let other = format!(
        "MODULE b\nLOCAL PROC lo2()\n{MOVE}\nENDPROC\nPROC inside()\n%\"lo\"+\"2\"%;\nENDPROC\nENDMODULE"
    );
    let of = |call: &str| {
        let companions = vec![Companion { name: "b.mod".to_owned(), text: other.clone() }];
        let text = module(&format!("{MOVE}\n{call}"));
        read(text.as_bytes(), Dialect::Rapid, &Settings { companions, ..settings() }).unwrap()
    };
    for call in ["lo2;", "%\"lo2\"%;", "%\"lo\"+\"2\"%;", "CallByVar \"lo\",2;"] {
        let found = of(call);
        assert_eq!((found.moves.len(), left_out(&found)), (1, vec![5]), "{call}");
        assert!(found.warnings[0].what.starts_with("'lo2' is not in"), "{call}: {found:?}");
    }
    let found = of("inside;");
    assert_eq!((found.moves.len(), left_out(&found)), (2, vec![]));
}
