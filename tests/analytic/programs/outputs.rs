//! Outputs that decide which moves are read, and what may move or set them beside the way of the
//! program.

use detune::notes::{Code, Note};
use detune::program::{Assumed, Dialect, Program, SetBy, Setter, Settings, read};

use super::rapid_decided::{MOVE, NEXT, assuming, doubts, run};
use super::support::{at, faults, module, settings};

type Read = Result<Program, Vec<Note>>;

/// Lines of what may move and is not read.
fn left_out(program: &Program) -> Vec<usize> {
    program.warnings.iter().filter(|note| note.code == Code::MotionLeftOut).map(at).collect()
}

/// Instructions from line 4 on, behind the routines of a module of RAPID.
fn rapid(body: &str, routines: &str, assumed: &[(&str, Assumed)]) -> Read {
    let text = format!(
        "MODULE m\nCONST robtarget p:=[[100,200,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
         PROC main()\n{body}\nENDPROC\n{routines}\nENDMODULE\n"
    );
    let mut job = settings();
    job.assume.extend(assumed.iter().map(|(name, value)| ((*name).to_owned(), *value)));
    read(text.as_bytes(), Dialect::Rapid, &job)
}

const NONE: [usize; 0] = [];

/// A line that decides by an output whether the arm moves.
fn decide(body: &str) -> String {
    format!("{MOVE}\n{body}\nIF DOutput(do1)=1 {MOVE}")
}

/// FUNC that moves, and one that sets an output.
const FUNCTIONS: &str = "FUNC num f()\nMoveL p,v5,fine,tool0;\nRETURN 1;\nENDFUNC\n\
                         FUNC num g()\nSet do1;\nRETURN 1;\nENDFUNC";

#[test]
fn an_output_of_rapid_that_the_run_may_set_decides_nothing() {
    let off = [("do1", Assumed::Truth(false))];
    for body in [
        "SetDO do1,0; n:=Prepare();",
        "SetDO do1,0; Prepare;",
        "TriggIO t,0\\DOp:=do1,1; SetDO do1,0; TriggL p,v5,t,fine,tool0;",
        "TriggEquip t,0,0\\DOp:=do1,1; SetDO do1,0; TriggL p,v5,t,fine,tool0;",
        "MoveLDO p,v5,fine,tool0,do1,1; SetDO do1,0;",
        "SetDO \\SDelay:=2,do1,1; SetDO do1,0;",
        "PulseDO do1; SetDO do1,0;",
        "SetDO do1,0; IF DInput(di9)=1 Set do1;",
    ] {
        for assumed in [&[], &off[..]] {
            let found = rapid(&decide(body), "", assumed).expect_err(body);
            assert_eq!((at(&found[0]), found.len()), (6, 1), "{body}: {found:?}");
        }
    }
    // Others than those that a trigger sets are as before.
    let trigger = |signal: &str| decide(&format!("TriggIO t,0\\DOp:={signal},1; SetDO do1,0;"));
    assert_eq!(rapid(&trigger("do2"), "VAR triggdata t;", &[]).unwrap().moves.len(), 1);
    // Which one another name is may be any.
    let own = "PROC q(VAR signaldo s)\nTriggIO t,0\\DOp:=s,1;\nENDPROC";
    let named = rapid(&decide("q do1; SetDO do1,0;"), own, &[]);
    assert_eq!(named.map_err(|notes| at(&notes[0])).err(), Some(6));
}

#[test]
fn a_function_that_is_in_no_file_is_a_doubt() {
    let lines = |body: &str| left_out(&rapid(&format!("{MOVE}\n{body}"), "", &[]).unwrap());
    assert_eq!(lines("n:=Prepare();"), [5]);
    assert_eq!(lines("TPWrite \"a\"\\Num:=Prepare();"), [5]);
    assert_eq!(lines("n:=Dim(p,1); TPWrite ValToStr(ClkRead(c));"), NONE);
    let krl_lines = |body: &str| left_out(&krl(body).unwrap());
    assert_eq!(krl_lines("x=foo()"), [4]);
    assert_eq!(krl_lines("IF foo() THEN\n$OUT[1]=TRUE\nENDIF"), [4]);
    assert_eq!(krl_lines("IF $IN[1] THEN\nx=foo()\nENDIF"), [5]);
    assert_eq!(krl_lines("x=STRLEN(a)"), NONE);
}

#[test]
fn functions_in_expressions_of_rapid_count_where_they_stand() {
    // On the main way they run; where the run decides it is refused.
    for (body, expected) in [
        ("WaitUntil f()=1;", Ok(2)),
        ("TPWrite \"a\"\\Num:=f();", Ok(2)),
        ("SetGO go1,f();", Ok(2)),
        ("IF DInput(di1)=1 THEN\nx:=f();\nENDIF", Err(5)),
        ("IF DInput(di1)=1 THEN\nTPWrite \"a\"\\Num:=f();\nENDIF", Err(5)),
        ("IF DInput(di1)=1 THEN\nWHILE f()=2 DO\nENDWHILE\nENDIF", Err(5)),
        ("IF DInput(di1)=1 THEN\nELSEIF f()=2 THEN\nENDIF", Err(5)),
        ("IF DInput(di1)=1 THEN\nx:=Abs(2);\nENDIF", Ok(1)),
        // What such a function sets is not known behind it.
        ("Reset do1;\nIF DInput(di1)=1 x:=g();\nIF DOutput(do1)=1 x:=f();", Err(7)),
        ("Reset do1;\nWaitUntil g()=1;\nIF DOutput(do1)=1 x:=f();", Ok(2)),
    ] {
        let found = rapid(&format!("{MOVE}\n{body}"), FUNCTIONS, &[]);
        let found = found.map(|program| program.moves.len()).map_err(|notes| at(&notes[0]));
        assert_eq!(found, expected, "{body}");
    }
}

#[test]
fn a_turning_speed_of_rapid_that_is_not_known_is_told() {
    let told = |turning: &str| -> Vec<usize> {
        let body = format!("VAR speeddata s;\ns:=[5,{turning},5,5];\nMoveL p,s,fine,tool0;");
        let program = rapid(&body, "", &[]).unwrap();
        program.warnings.iter().filter(|note| note.code == Code::Assumed).map(at).collect()
    };
    assert_eq!(told("AInput(ai1)"), [6]);
    assert_eq!(told("9"), NONE);
}

fn krl(body: &str) -> Read {
    let text = format!("DEF p()\n$VEL.CP=0.1\nPTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\n{body}\nEND\n");
    read(text.as_bytes(), Dialect::Krl, &settings())
}

#[test]
fn an_output_of_krl_that_the_run_may_set_decides_nothing() {
    let body = |set: &str| format!("{set}\nIF $OUT[1] THEN\nLIN_REL {{X 1}}\nENDIF");
    let on = "INTERRUPT DECL 3 WHEN $IN[1]==TRUE DO $OUT[1]=TRUE\nINTERRUPT ON 3";
    for set in [
        "$OUT[1]=FALSE\nx=foo()",
        "$OUT[1]=FALSE\nfoo()",
        "$OUT[1]=FALSE\nPULSE($OUT[1],TRUE,2.0)",
        "PULSE($OUT[1],TRUE,2.0)\n$OUT[1]=FALSE",
        "$OUT[1]=FALSE\nIF $IN[2] THEN\nPULSE($OUT[1],TRUE,2.0)\nENDIF",
        "$OUT[1]=FALSE\nTRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE\n$OUT[1]=FALSE",
        &format!("$OUT[1]=FALSE\n{on}"),
        &format!("{on}\n$OUT[1]=FALSE"),
    ] {
        let found = krl(&body(set)).expect_err(set);
        let expected = 4 + set.lines().count();
        assert_eq!((at(&found[0]), found.len()), (expected, 1), "{set}: {found:?}");
    }
    let other = "$OUT[1]=FALSE\nPULSE($OUT[2],TRUE,2.0)";
    assert_eq!(krl(&body(other)).unwrap().moves.len(), 1);
}

/// P[1] to P[3] at x of 0, 10 and 20 mm, the second beside the line of the others; PR[1] is 7 mm in
/// z.
fn tp(statements: &str) -> Read {
    let point = |number: u32, x: f64, y: f64| {
        format!(
            "P[{number}]{{\n GP1:\n UF : 0, UT : 0, CONFIG : 'N U T, 0, 0, 0',\n X = {x} mm, Y = {y} \
             mm, Z = 0 mm, W = 180 deg, P = 0 deg, R = 0 deg\n}};\n"
        )
    };
    let points = [point(1, 0.0, 0.0), point(2, 10.0, 5.0), point(3, 20.0, 0.0)].concat();
    let mut job = settings();
    job.assume.insert("pr[1]".to_owned(), Assumed::Number(0.0));
    let text = format!(
        "/PROG A\n/MN\nPR[1,3]=7 ;\nL P[1] 9mm/sec FINE ;\n{statements}/POS\n{points}/END\n"
    );
    read(text.as_bytes(), Dialect::Fanuc, &job)
}

const LINE: &str = "L P[2] 9mm/sec CNT100";

#[test]
fn what_stands_behind_an_action_of_tp_is_read() {
    for options in [
        "Arc Start[1,2] Offset,PR[1]",
        "Weave Figure 8[1] Offset,PR[1]",
        "Track TAST[2] Offset,PR[1]",
        "Spray Start[1] Offset,PR[1]",
        "TA .50sec,CALL W1 Offset,PR[1]",
        "TB .50sec,CALL W1(1, 2) Offset,PR[1]",
        "DB 5.0mm,DO[1:a b]=ON Offset,PR[1]",
        "Offset,PR[1] Weld End[1]",
    ] {
        let program = tp(&format!("{LINE} {options} ;\n")).unwrap_or_else(|e| panic!("{e:?}"));
        let end = super::support::end(program.moves.last().unwrap()).1.translation.vector;
        assert!((end.z - 0.007).abs() < 1e-9, "{options}: {end}");
    }
    for options in [
        "Arc Start[1,2] Skip,LBL[9]",
        "TA .1sec,R[1]=1 Skip,LBL[9]",
        "Weld Start[1] VOFFSET,VR[1]",
        "Spray INC",
        // That of OFFSET CONDITION, whatever the option behind it takes.
        "Offset Tool_Offset,PR[1]",
        "Arc End Offset",
    ] {
        let found = tp(&format!("{LINE} {options} ;\n")).expect_err(options);
        assert_eq!((at(&found[0]), found.len()), (5, 1), "{options}: {found:?}");
    }
    let calls = tp(&format!("{LINE} TB .50sec,CALL FOO ;\n")).unwrap();
    assert_eq!(left_out(&calls), [5]);
}

#[test]
fn an_arc_point_of_tp_is_not_shifted() {
    let arc = |option: &str| {
        let points = [2, 3].map(|n| format!("A P[{n}] 9mm/sec CNT100 {option};\n")).concat();
        tp(&format!("A P[1] 9mm/sec FINE ;\n{points}"))
    };
    assert_eq!(arc("").unwrap().moves.len(), 4);
    let found = arc("Offset,PR[1] ").unwrap_err();
    assert!(found[0].what.contains("an offset of an arc"), "{found:?}");
    assert_eq!(at(&found[0]), 6);
}

/// What programs write for a shift along one axis, of a register of which they know nothing.
#[test]
fn a_pose_less_itself_is_no_shift() {
    let shifted = |set: &str| tp(&format!("{set}{LINE} Offset,PR[2] ;\n"));
    let zeroed = "PR[2]=LPOS ;\nPR[2]=PR[2]-PR[2] ;\nPR[2,3]=20 ;\n";
    let open = zeroed.replace("PR[2]=LPOS ;\n", "");
    for zeroed in [zeroed, &open] {
        let end = super::support::end(shifted(zeroed).unwrap().moves.last().unwrap()).1;
        assert!((end.translation.vector.z - 0.02).abs() < 1e-9, "{end}");
    }
    // Of joints, and of another register.
    for (set, said) in [
        ("PR[2]=JPOS ;\nPR[2]=PR[2]-PR[2] ;\nPR[2,3]=20 ;\n", "by joints is not read"),
        ("PR[2]=LPOS ;\nPR[2]=PR[2]-PR[3] ;\nPR[2,3]=20 ;\n", "assume: {\"PR[3]\": 0}"),
    ] {
        let found = shifted(set).expect_err(set);
        assert_eq!(at(&found[0]), 5 + set.lines().count(), "{found:?}");
        assert!(found[0].what.contains(said), "{found:?}");
    }
}

#[test]
fn an_output_of_tp_that_a_motion_sets_decides_nothing() {
    let text = |option: &str| {
        format!("DO[1]=OFF ;\n{LINE} {option} ;\nIF DO[1]=ON,JMP LBL[2] ;\n{LINE} ;\nLBL[2] ;\n")
    };
    for option in ["TA .50sec,DO[1]=ON", "DB 5.0mm,DO[1]=ON", "TB .1sec,DO[1]=PULSE,0.5sec"] {
        let found = tp(&text(option)).expect_err(option);
        assert_eq!((at(&found[0]), found.len()), (7, 1), "{option}: {found:?}");
    }
    assert_eq!(tp(&text("TA .50sec,DO[2]=ON")).unwrap().moves.len(), 3);
}

#[test]
fn signs_and_brackets_without_end_are_no_overflow() {
    const COUNT: usize = 100_000;
    let [minus, not] = ["-", "!"].map(|sign| sign.repeat(COUNT));
    let even = format!(
        "R[1]={minus}2 ;\nF[1]=({not}ON) ;\nIF R[1]=2 AND F[1]=ON,JMP LBL[2] ;\n{LINE} ;\nLBL[2] ;\n"
    );
    assert_eq!(tp(&even).unwrap().moves.len(), 1);
    let odd = even.replace("]=-", "]=--").replace("=(!", "=(!!");
    assert_eq!(tp(&odd).unwrap().moves.len(), 2);
    let joined = format!(
        "F[1]=({}ON) ;\nIF F[1]=OFF,JMP LBL[2] ;\n{LINE} ;\nLBL[2] ;\n",
        "OFF OR ".repeat(COUNT)
    );
    assert_eq!(tp(&joined).unwrap().moves.len(), 2);
    let nested = format!(
        "IF {}1{}=ON,JMP LBL[2] ;\n{LINE} ;\nLBL[2] ;\n",
        "F[".repeat(COUNT),
        "]".repeat(COUNT)
    );
    assert_eq!(at(&tp(&nested).unwrap_err()[0]), 5);
}

/// NX's own arcs have 11 values; of others nothing says which way they run.
#[test]
fn an_arc_of_an_nx_file_without_its_values_is_a_doubt() {
    let text = |values: &str, behind: &str| {
        format!(
            "TOOL PATH/MILL,TOOL,T1\nUNITS/MM\nFEDRAT/MMPM,600\nGOTO/0,0,0\nGOTO/10,-5,0\n\
             GOTO/10,0,3\nGOTO/10,0,0\nCIRCLE/10,10,0,0,0,1,10{values}\nGOTO/20,10,0\n{behind}\n"
        )
    };
    let doubts = |values: &str, behind: &str| -> Vec<usize> {
        let text = super::support::ended(&text(values, behind), Dialect::Apt);
        let program = read(text.as_bytes(), Dialect::Apt, &settings()).unwrap();
        let told = program.warnings.iter().filter(|note| note.code == Code::UnitAssumed);
        told.map(at).collect()
    };
    let eleven = ",0.06,0.5,20,0";
    assert_eq!(doubts("", "GOTO/20,10,5"), [8]);
    assert_eq!(doubts(eleven, "GOTO/20,10,5"), NONE);
    // A line that is tangent to it shows the way.
    assert_eq!(doubts("", "GOTO/20,20,0"), NONE);
    let found = faults(&text("", "GOTO/20,0,0"), Dialect::Apt);
    assert!(found[0].what.contains("taken to run counterclockwise"), "{found:?}");
}

fn told(program: &Program, code: Code) -> Vec<usize> {
    program.warnings.iter().filter(|note| note.code == code).map(at).collect()
}

/// The job reads the spindle from a procedure, whose output another sets as well.
#[test]
fn an_output_by_which_a_procedure_sets_the_spindle_is_set_nowhere_else() {
    let speeds = |body: &str| {
        let text = module(&format!("MoveL p,v5,fine,tool0;\nSpindle 300;\n{body}"));
        let end = text.rfind("ENDMODULE").unwrap();
        let text = format!(
            "{}PROC Spindle(num r)\nSetGO goS,r;\nSet doOn;\nENDPROC\nPROC Fast()\n\
             SetGO goS,970;\nENDPROC\nENDMODULE\n",
            &text[..end]
        );
        let what = Setter::Procedure("Spindle".to_owned(), 1);
        let spindle_from = Some(SetBy { what, per_unit: 1.0 });
        let job = Settings { spindle_from, ..settings() };
        let found = read(text.as_bytes(), Dialect::Rapid, &job).unwrap();
        told(&found, Code::SpindleCommand).len()
    };
    const THERE: &str = "MoveL Offs(p,9,0,0),v5,fine,tool0;";
    assert_eq!(speeds(&format!("{THERE}\nSpindle 500;\n{THERE}\nReset doOn;\nSetGO goS,0;")), 0);
    assert_eq!(speeds(&format!("Fast;\n{THERE}")), 1);
    assert_eq!(speeds(&format!("SetGO goS,970;\n{THERE}")), 1);
}

/// What a call takes as a value, and a signal that is waited for, stays what the job says.
#[test]
fn what_nothing_sets_keeps_the_word_of_the_job() {
    let assumed = [("mode", Assumed::Number(1.0)), ("din", Assumed::Truth(true))];
    let decided = "IF mode=1 AND din=1 THEN\nMoveL Offs(p,9,0,0),v5,fine,tool0;\nENDIF";
    let routines = "PROC Start(num m)\nm:=0;\nENDPROC\nPROC Set0(INOUT num m)\nm:=0;\nENDPROC\n\
                    PROC Onward(INOUT num m)\nElsewhere m;\nENDPROC";
    for before in [
        "Start mode;",
        "WaitDI din,1;",
        "ISignalDI din,1,i1;",
        // What an instruction fills in is what the job says.
        "WaitDI din,1\\TimeFlag:=mode;",
    ] {
        let found = rapid(&format!("{before}\n{decided}"), routines, &assumed);
        assert_eq!(found.unwrap().moves.len(), 1, "{before}");
    }
    for before in [
        "Set0 mode;",
        "Elsewhere mode;",
        "Onward mode;",
        // What is waited for is not what the job says.
        "WaitDI din,0;",
        "WaitDI din,later;",
    ] {
        let found = rapid(&format!("{before}\n{decided}"), routines, &assumed);
        assert!(found.is_err(), "{before}");
    }
}

/// CRobT in the target of a move asks where the arm is before it.
#[test]
fn a_target_that_asks_where_the_arm_is_asks_before_its_move() {
    let doubts = |zones: [&str; 2]| {
        let body = format!(
            "MoveL p,v5,{},tool0;\nMoveL Offs(CRobT(),0,9,0),v5,{},tool0;",
            zones[0], zones[1]
        );
        let found = rapid(&body, "", &[]).unwrap();
        found.warnings.iter().filter(|note| note.what.contains("CRobT asks")).count()
    };
    assert_eq!(doubts(["fine", "z50"]), 0);
    assert_eq!(doubts(["z50", "fine"]), 1);
}

/// Technical reference manual, AliasIO: a signal is used by another name, too.
#[test]
fn a_second_name_of_a_signal_moves_nothing() {
    let of = |before: &str, job: &Settings| {
        run(&format!("{MOVE}\n{before}\n{NEXT}"), "", job).map(|found| doubts(&found))
    };
    assert_eq!(of("AliasIO do_x,do_y;", &settings()), Ok(vec![]));
    for own in ["do_x", "do_y"] {
        let told = Ok(vec![(Code::MotionLeftOut, 5)]);
        assert_eq!(of("AliasIO do_x,do_y;", &assuming(own, 1.0)), told, "{own}");
        assert_eq!(of("AliasIO \"do_x\",do_y;", &assuming(own, 1.0)), told, "{own}");
    }
    let of_handler = "Get;\nSet do_x;";
    for alias in ["Set do_x;\nAliasIO do_x,do_y;", "Set do_x;\nAliasIO \"do_x\",do_y;", of_handler]
    {
        let body = format!("{MOVE}\n{alias}\nReset do_y;\nIF DOutput(do_x)=1 {NEXT}");
        let get = "PROC Get()\nSet do1;\nERROR\nAliasIO do_x,do_y;\nTRYNEXT;\nENDPROC";
        assert_eq!(at(&run(&body, get, &settings()).unwrap_err()[0]), 8, "{alias}");
    }
}

/// It may be a signal that the job has.
#[test]
fn a_second_name_of_a_signal_that_is_not_known_is_a_doubt() {
    let what = Setter::Signal("goS".to_owned());
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    let told = |body: &str, more: &str, job: &Settings, code: Code| {
        let found = run(&format!("{body}\n{NEXT}"), more, job).unwrap();
        let told = found.warnings.iter().filter(|note| note.what.contains("AliasIO gives"));
        told.filter(|note| note.code == code).map(at).collect::<Vec<_>>()
    };
    let set = format!("SetGO goS,3000;\n{MOVE}");
    for (of, lines) in [("s1", 1), ("ReadStr(f)", 1), ("\"go1\"", 1), ("goS", 1), ("go1", 0)] {
        let more = "VAR string s1;\nVAR signalgo al;";
        let body = format!("{set}\nAliasIO {of},al;\nSetGO al,100;");
        assert_eq!(told(&body, more, &job, Code::SpindleCommand), vec![6; lines], "{of}");
        let body = format!("{MOVE}\nAliasIO {of},al;\nWaitDI al,0;");
        let lines = if of == "goS" { 0 } else { lines };
        let found = told(&body, more, &assuming("di1", 1.0), Code::MotionLeftOut);
        assert_eq!(found, vec![5; lines], "{of}");
        assert_eq!(told(&body, more, &settings(), Code::MotionLeftOut), vec![0; 0], "{of}");
    }
    // In the procedure of an event.
    let event = "VAR signalgo al;\nPROC Ev()\nAliasIO goS,al;\nENDPROC";
    let body = format!("{set}\nSetGO al,100;");
    assert_eq!(told(&body, event, &job, Code::SpindleCommand), [11]);
}
