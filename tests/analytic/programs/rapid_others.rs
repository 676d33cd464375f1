//! RAPID: what the controller, other tasks and the run give: frames, loops that wait, functions, data by name.

use detune::notes::{Code, Note};
use detune::program::{Assumed, Companion, Dialect, ExternalAxis, Program, Settings, read};
use nalgebra::Isometry3;

use super::support::{assert_ends, at, lines, module, settings};

const MOVE: &str = "MoveL p,v5,fine,tool0;";
const NEXT: &str = "MoveL Offs(p,10,0,0),v5,fine,tool0;";

fn run(text: &str, job: &Settings) -> Result<Program, Vec<Note>> {
    read(text.as_bytes(), Dialect::Rapid, job)
}

/// Instructions from line 4 on, and data and routines behind them.
fn with(body: &str, more: &str) -> Result<Program, Vec<Note>> {
    run(&module(body).replace("ENDMODULE", &format!("{more}\nENDMODULE")), &settings())
}

fn doubts(program: &Program) -> Vec<(Code, usize)> {
    let is_doubt = |note: &&Note| note.code.class() == detune::notes::Class::Doubt;
    program.warnings.iter().filter(is_doubt).map(|note| (note.code, at(note))).collect()
}

#[track_caller]
fn refused(found: Result<Program, Vec<Note>>, line: usize, said: &[&str]) {
    let found = found.expect_err("it is wrong");
    assert_eq!((at(&found[0]), found.len()), (line, 1), "{found:?}");
    for said in said {
        assert!(found[0].what.contains(said), "{said}: {found:?}");
    }
}

/// A name of the module hides the controller's own, as for v100 and reg1. System modules declare
/// tool0 and wobj0 as they are.
#[test]
fn declarations_of_tool0_and_wobj0_are_used() {
    let of = |class: &str, tool: &str, object: &str, tcp: Option<Isometry3<f64>>| {
        let text = format!(
            "MODULE m\n{class} PERS tooldata tool0:=[TRUE,[[0,0,{tool}],[1,0,0,0]],[0.001,[0,0,0.001],\
             [1,0,0,0],0,0,0]];\n{class} PERS wobjdata wobj0:=[FALSE,TRUE,\"\",[[{object},0,0],[1,0,0,0]],\
             [[0,0,0],[1,0,0,0]]];\nPROC main()\nMoveL p,v5,fine,tool0\\WObj:=wobj0;\n\
             MoveL p,v5,fine,tool0;\nENDPROC\nCONST robtarget p:=[[100,200,300],[1,0,0,0],[0,0,0,0],\
             [9E9,9E9,9E9,9E9,9E9,9E9]];\nENDMODULE\n"
        );
        let program = run(&text, &Settings { tcp, ..settings() }).unwrap();
        // Without \WObj the controller's own counts.
        let x = 100.0 + object.parse::<f64>().unwrap();
        assert_ends(&program, &[('L', [x, 200.0, 300.0]), ('L', [100.0, 200.0, 300.0])]);
        let z_mm = (program.moves[1].tcp.translation.z * 1e3).round();
        (z_mm, doubts(&program))
    };
    let own = Some(Isometry3::translation(0.0, 0.0, 0.08));
    assert_eq!(of("LOCAL", "150", "60", None), (150.0, vec![]));
    assert_eq!(of("LOCAL", "150", "60", own), (150.0, vec![]));
    for class in ["LOCAL", "", "TASK"] {
        assert_eq!(of(class, "0", "0", None), (0.0, vec![]));
        assert_eq!(of(class, "0", "0", own), (80.0, vec![]));
    }
    let told = vec![(Code::ChangeIgnored, 2), (Code::ChangeIgnored, 3)];
    for class in ["", "TASK"] {
        assert_eq!(of(class, "150", "60", None), (150.0, told.clone()));
        assert_eq!(of(class, "150", "0", None), (150.0, told[..1].to_vec()));
    }
}

#[test]
fn the_programs_own_vmax_is_not_taken_as_the_controllers() {
    let of = |data: &str| {
        let found = with("MoveL p,vmax,fine,tool0;", data).unwrap();
        let is_told = found.warnings.iter().any(|note| note.what.contains("vmax is taken"));
        (found.moves[0].feed_m_per_s, is_told)
    };
    assert_eq!(of("CONST speeddata vmax:=[20,500,5000,1000];"), (0.02, false));
    assert_eq!(of(""), (5.0, true));
}

/// One of the axes is set, the others are those of the run.
#[test]
fn external_axes_of_the_run_that_the_job_does_not_map_are_a_doubt() {
    let text = module(
        "VAR robtarget q;\nq:=CRobT();\nq.extax.eax_b:=0;\n\
         MoveAbsJ [[0,0,0,0,30,0],q.extax],v200,fine,tool0;",
    );
    let found = run(&text, &settings()).unwrap();
    assert_eq!((lines(&found), doubts(&found)), (vec![7], vec![(Code::AxisIgnored, 7)]));
    let mut job = Settings { joint_count: 7, ..settings() };
    job.external_axes.insert("eax_a".to_owned(), ExternalAxis { joint: 0, slides: true });
    refused(run(&text, &job), 7, &["external axes", "known only at run time"]);
}

/// As `WaitUntil done` does; the arm stands for the one pass that is read.
#[test]
fn a_loop_that_waits_for_what_another_task_sets_ends() {
    let of = |condition: &str, inside: &str, behind: &str, assume: &[(&str, Assumed)]| {
        let body = format!(
            "{MOVE}\ndone:=FALSE;\nWHILE {condition} DO\n{inside}\nENDWHILE\n{behind}\n{NEXT}"
        );
        let data = "PERS bool done:=FALSE;\nVAR num n:=0;\nENDMODULE";
        let assume = assume.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        run(&module(&body).replace("ENDMODULE", data), &Settings { assume, ..settings() })
    };
    let said = |value: bool| [("done", Assumed::Truth(value))];
    let wait = "WaitTime 0.1;";
    for assume in [&[][..], &said(true), &said(false)] {
        let found = of("NOT done", wait, "", assume).unwrap();
        assert_eq!((lines(&found), doubts(&found)), (vec![4, 7, 10], vec![]), "{assume:?}");
        let unused = found.warnings.iter().any(|note| note.code == Code::Unused);
        assert!(!unused, "{:?}", found.warnings);
    }
    // What it is behind the loop.
    let asks = "IF done MoveL Offs(p,50,0,0),v5,fine,tool0;";
    assert_eq!(lines(&of("NOT done", wait, asks, &said(true)).unwrap()), [4, 7, 9, 10]);
    let why = ["IF decides about motion", "another task sets it while WHILE waits"];
    refused(of("NOT done", wait, asks, &[]), 9, &why);
    // How often it has run.
    let counts = "WaitTime 0.1;n:=n+1;";
    let asks = "IF n>1 MoveL Offs(p,50,0,0),v5,fine,tool0;";
    refused(of("NOT done", counts, asks, &[]), 9, &["'n' is set in a loop that others end"]);
    // An input that the job has as it is while the loop runs.
    let input = [("di1", Assumed::Truth(false))];
    assert_eq!(lines(&of("di1=0", wait, "", &input).unwrap()), [4, 7, 10]);
    // Another task does not end it alone: what stands behind it is never reached.
    let found = of("n=0 OR NOT done", wait, "", &[]).unwrap();
    assert_eq!(lines(&found).last(), Some(&7));
    assert_eq!(doubts(&found), [(Code::MotionLeftOut, 6)]);
    // Other tasks do not have it.
    for class in ["TASK PERS", "LOCAL PERS", "VAR"] {
        let body = format!("{MOVE}\nWHILE NOT done DO\n{wait}\nENDWHILE\n{NEXT}");
        let found = with(&body, &format!("{class} bool done:=FALSE;")).unwrap();
        let told = vec![(Code::MotionLeftOut, 5)];
        assert_eq!((lines(&found), doubts(&found)), (vec![4, 6], told), "{class}");
    }
}

/// A loop that asks for a flag of its own, which none of its passes sets.
#[test]
fn a_loop_in_which_nothing_changes_is_a_doubt_that_names_what_it_may_call() {
    let of = |inside: &str| {
        let begin = format!("flag:=0;n:=0;{MOVE}");
        let body = format!("{begin}\nWHILE flag>-1 DO\n{inside}\nENDWHILE\n{MOVE}");
        let more = format!("VAR num flag:=0;\nVAR num n:=0;\nPROC go()\n{NEXT}\nflag:=0;\nENDPROC");
        with(&body, &more)
    };
    let found = of("IF flag=1 go;").unwrap();
    assert_eq!((lines(&found), doubts(&found)), (vec![4], vec![(Code::MotionLeftOut, 5)]));
    let told = found.warnings.iter().find(|note| note.code == Code::MotionLeftOut).unwrap();
    assert!(told.what.contains("path.program.procedure: go"), "{}", told.what);
    // However much one pass runs.
    let found = of("FOR i FROM 1 TO 2000 DO\nn:=i;\nENDFOR\nIF flag=1 go;").unwrap();
    assert_eq!((lines(&found), doubts(&found)), (vec![4], vec![(Code::MotionLeftOut, 5)]));
    // What a pass changes starts others.
    let found = of("n:=n+1;\nIF n=9 go;\nIF n=12 flag:=-1;").unwrap();
    assert_eq!((lines(&found), doubts(&found)), (vec![4, 15, 10], vec![]));
    // So does what the condition itself sets.
    let ready = "VAR num m:=0;\nFUNC bool ready()\nm:=m+1;\nRETURN m>5;\nENDFUNC";
    let found = with(&format!("m:=0;\nWHILE NOT ready() DO\nENDWHILE\n{MOVE}"), ready).unwrap();
    assert_eq!((lines(&found), doubts(&found)), (vec![7], vec![]));
    // What it changes for ever is an error, at its own line alone.
    for head in ["WHILE n>=0 DO\nn:=n+1;\nENDWHILE", "FOR i FROM 1 TO 1E7 DO\nn:=1;\nENDFOR"] {
        let found = with(&format!("VAR num n;\n{MOVE}\n{head}\n{MOVE}"), "").unwrap_err();
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            (6..=7).contains(&at(&found[0])) && !found[0].what.contains("likewise"),
            "{found:?}"
        );
    }
}

/// It runs few passes at a time, and may call much.
#[test]
fn a_loop_that_ends_runs_as_often_as_it_is_reached() {
    let body = format!(
        "FOR i FROM 1 TO 400 DO\nfin:=FALSE;\nn:=0;\nWHILE NOT fin DO\nn:=n+1;\nIF n=5 fin:=TRUE;\n\
         IF k=99 big;\nENDWHILE\nENDFOR\n{MOVE}"
    );
    let big = format!("PROC big()\n{}ENDPROC", "IF k=9 n:=1;\n".repeat(1000));
    let found = with(&body, &format!("VAR bool fin;\nVAR num n;\nVAR num k:=0;\n{big}")).unwrap();
    assert_eq!((lines(&found), doubts(&found)), (vec![13], vec![]));
}

/// RETURN of a function decides what it gives, and no move.
#[test]
fn a_function_that_the_run_decides_gives_what_is_not_known() {
    let of = |function: &str, behind: &str| {
        let body = format!("{MOVE}\nr:=sg(DInput(di1));\n{behind}\n{NEXT}");
        with(&body, &format!("VAR num r;\nVAR num k:=0;\nFUNC num sg(num a)\n{function}\nENDFUNC"))
    };
    let sign = "IF a>0 THEN\nRETURN 1;\nENDIF\nk:=5;\nRETURN -1;";
    let found = of(sign, "TPWrite \"r\"\\Num:=r;").unwrap();
    assert_eq!((lines(&found), doubts(&found)), (vec![4, 7], vec![]));
    let there = |name: &str| format!("MoveL Offs(p,{name},0,0),v5,fine,tool0;");
    refused(of(sign, &there("r")), 6, &["function 'sg' depends on a condition", "'DInput'"]);
    // Set behind the RETURN, or not.
    refused(of(sign, &there("k")), 6, &["'k' depends on a condition"]);
    refused(of(sign, &format!("IF r=1 {NEXT}")), 6, &["IF decides about motion"]);
    let loops = "FOR i FROM 1 TO a DO\nRETURN i;\nENDFOR\nRETURN 0;";
    assert_eq!(lines(&of(loops, "").unwrap()), [4, 7]);
    // A function that moves behind it.
    let moves = format!("IF a>0 THEN\nRETURN 1;\nENDIF\n{MOVE}\nRETURN 2;");
    assert!(of(&moves, "").unwrap_err()[0].what.contains("IF decides about motion"));
}

/// PERS data of two tasks are one datum where both declare it alike.
#[test]
fn persistent_data_that_two_tasks_declare_alike_are_one() {
    let of = |own: &str, other: &str, more: &str| {
        let text = module(&format!("MoveL Offs(p,k,0,0),v5,fine,tool0;\n{NEXT}"))
            .replace("ENDMODULE", &format!("{own}\nENDMODULE"));
        let text_of_other = format!("MODULE T2\n{other}\n{more}\nENDMODULE\n");
        let companion = Companion::new("t2.mod".to_owned(), text_of_other.as_bytes()).unwrap();
        run(&text, &Settings { companions: vec![companion], ..settings() })
    };
    let found = of("PERS num k:=20;", "PERS num k:=20;", "").unwrap();
    assert_ends(&found, &[('L', [120.0, 200.0, 300.0]), ('L', [110.0, 200.0, 300.0])]);
    let sets = "PROC other()\nk:=90;\nENDPROC";
    refused(of("PERS num k:=20;", "PERS num k:=20;", sets), 4, &["another task sets it"]);
    for other in ["PERS num k:=30;", "PERS dnum k:=20;", "VAR num k:=20;", "TASK PERS num k:=20;"] {
        let said = ["'k' is declared twice, here and at t2.mod:2"];
        refused(of("PERS num k:=20;", other, ""), 7, &said);
    }
    refused(of("PERS num k:=20;\nPERS num k:=20;", "", ""), 8, &["here and at line 7"]);
}

/// Technical reference manual, GetDataVal: it copies the datum that a text names.
#[test]
fn data_by_name_are_copied_and_move_nothing() {
    let constant = "CONST robtarget p2:=[[500,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];";
    let of = |copies: &str, data: &str| {
        with(&format!("{copies}\nMoveL q,v5,fine,tool0;"), &format!("{data}\nVAR robtarget q;"))
    };
    let found = of("GetDataVal \"p2\",q;", constant).unwrap();
    assert_ends(&found, &[('L', [500.0, 0.0, 0.0])]);
    let why = ["GetDataVal fills in 'q': known only at run time", "write the value into a copy"];
    for (copies, data) in [
        ("GetDataVal \"p2\",q;", constant.replace("CONST", "VAR")),
        ("GetDataVal \"p2\"\\Block:=b,q;", constant.to_owned()),
        ("GetDataVal \"p3\",q;", constant.to_owned()),
        // The routine or another module has its own.
        ("VAR robtarget p2;GetDataVal \"p2\",q;", constant.to_owned()),
        ("GetDataVal \"p2\",q;", format!("{constant}\nENDMODULE\nMODULE m2\nLOCAL {constant}")),
    ] {
        refused(of(copies, &data), 5, &why);
    }
    for own in ["MToolTCPCalib j,j,j,j,t,max,mean;", "SyncToSensor cnv,p;"] {
        let found = with(own, "VAR jointtarget j;").unwrap_err();
        assert!(found[0].what.contains("is an instruction of the controller"), "{found:?}");
        assert!(!found[0].what.contains("path.program.files"), "{found:?}");
    }
}

#[test]
fn what_assume_cannot_give_is_not_asked_of_it() {
    let hint = "assume: in the job can settle it";
    let branch = |condition: &str| format!("IF {condition} {MOVE}");
    let of = |body: &str| {
        let found = with(body, "VAR string s;\nVAR num n;").expect_err(body);
        found[0].what.clone()
    };
    let text = of(&format!("SocketReceive so\\Str:=s;\n{}", branch("s=\"x\"")));
    assert!(!text.contains(hint) && text.contains("write the value into a copy"), "{text}");
    let number = of(&format!("SocketReceiveFrom so\\NoRecBytes:=n;\n{}", branch("n=1")));
    assert!(!number.contains(hint) && number.contains("assume: {\"n\": …}"), "{number}");
    // It is told where a move needs the number, too.
    let text = of(&format!("TPReadNum n,\"?\";\n{}", MOVE.replace("p,", "Offs(p,n,0,0),")));
    assert!(text.contains("'n': known only at run time; assume: {\"n\": …} in the job"), "{text}");
    let array = of(&format!("FOR i FROM 1 TO Dim(list,1) DO\n{MOVE}\nENDFOR"));
    assert!(!array.contains(hint) && array.contains("path.program.files"), "{array}");
}

/// The job's feed stands for data of other files, and not for what the run decides.
#[test]
fn a_speed_that_a_condition_decides_is_no_feed_of_the_job_without_a_doubt() {
    const DATA: &str = "VAR speeddata v:=v100;\nVAR speeddata vs{2}:=[v100,v50];";
    let slow = NEXT.replace("v5", "v");
    let of = |set: &str, moved: &str, feed_m_per_s: Option<f64>| {
        let text = module(&format!("{MOVE}\n{set}\n{moved}\nv:=v100;"));
        let text = text.replace("ENDMODULE", &format!("{DATA}\nENDMODULE"));
        run(&text, &Settings { feed_m_per_s, ..settings() })
    };
    let of_run = [
        ("IF di1=1 v:=v50;", slow.as_str(), "'v' depends on a condition: 'di1' is not declared"),
        ("IF di1=1 v.v_tcp:=20;", &slow, "'v' depends on a condition: 'di1' is not declared"),
        ("IF di1=1 v.v_ori:=20;", &slow, "'v' depends on a condition: 'di1' is not declared"),
        ("GetDataVal \"vElse\",v;", &slow, "GetDataVal fills in 'v'"),
        ("", "MoveL Offs(p,10,0,0),vs{nElse},fine,tool0;", "index of 'vs': 'nElse'"),
        ("", "MoveL Offs(p,10,0,0),vFar{nElse},fine,tool0;", "index of 'vFar': 'nElse'"),
    ];
    for (set, moved, why) in of_run {
        let found = of(set, moved, Some(0.5)).unwrap();
        assert_eq!(doubts(&found), [(Code::ChangeIgnored, 6)], "{set}");
        assert_eq!(found.moves[1].feed_m_per_s, 0.5);
        refused(of(set, moved, None), 6, &["MoveL: speed: ", why, "feed_mm_per_min"]);
    }
    let found = of(of_run[0].0, &slow, None).unwrap_err();
    assert!(found[0].what.contains("assume: in the job can settle it"), "{found:?}");
    // One of another file.
    let elsewhere = NEXT.replace("v5", "vElse");
    assert_eq!(doubts(&of("", &elsewhere, Some(0.5)).unwrap()), []);
    let said = ["speed: 'vElse' is not declared in this file", "path.program.files", "feed_mm"];
    refused(of("", &elsewhere, None), 6, &said);
    // The first move has no way.
    let first = with(&format!("IF di1=1 v:=v50;\n{slow}\n{MOVE}\nv:=v100;"), DATA).unwrap();
    assert_eq!(doubts(&first), []);
}

/// As of a speed.
#[test]
fn a_tool_that_a_condition_decides_is_not_the_jobs_without_a_doubt() {
    let text = module("IF di1=1 t:=u;\nMoveL p,v5,fine,t;").replace(
        "ENDMODULE",
        "PERS tooldata t:=[TRUE,[[0,0,7],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n\
         PERS tooldata u:=[TRUE,[[0,0,9],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\nENDMODULE",
    );
    let tcp = Some(Isometry3::translation(0.0, 0.0, 0.08));
    let found = run(&text, &Settings { tcp, ..settings() }).unwrap();
    assert!(doubts(&found).contains(&(Code::ChangeIgnored, 5)), "{:?}", found.warnings);
}

#[test]
fn what_is_in_no_file_that_is_read_is_told_with_the_file_as_the_remedy() {
    const FILES: &str = "path.program.files";
    for (body, said) in [
        ("MoveL turned(p,30),v5,fine,tool0;", "function 'turned' is in no file that is read"),
        ("IF picked(1) MoveL p,v5,fine,tool0;", "or assume: {\"picked\": …} can give it"),
        ("IF tray.n=1 MoveL p,v5,fine,tool0;", "the type 'dice_tray' of 'tray' is in no file"),
        ("MoveJ_Request 1,p,v5,fine,tool0;", "'MoveJ_Request' moves by its name, and is in no"),
        ("MoveHome;", "'MoveHome' moves by its name, and is in no"),
    ] {
        let found = with(body, "VAR dice_tray tray;").expect_err(body);
        let what = &found[0].what;
        assert!(at(&found[0]) == 4 && what.contains(said) && what.contains(FILES), "{found:?}");
        assert!(!what.contains("assume: in the job"), "{what}");
    }
    // The controller's own, and components that a type does not have.
    for (body, said) in [
        ("MoveExtJ j,v5,fine;", "'MoveExtJ' moves and is not understood"),
        ("IF p.n=1 MoveL p,v5,fine,tool0;", "'p' (robtarget) has no component 'n'"),
        ("IF EGMGetState(e)=2 MoveL p,v5,fine,tool0;", "'EGMGetState' is known only at run time"),
    ] {
        let found = with(body, "").expect_err(body);
        assert!(found[0].what.contains(said) && !found[0].what.contains(FILES), "{found:?}");
    }
}

/// Application manual, Externally Guided Motion: EGMRunJoint and EGMRunPose move the arm to what a sensor sends.
#[test]
fn motion_from_outside_is_refused() {
    for sent in ["EGMRunPose e,EGM_STOP_HOLD\\x\\CondTime:=5;", "EGMRunJoint e,EGM_STOP_HOLD\\J1;"]
    {
        let found = with(&format!("{MOVE}\n{sent}"), "VAR egmident e;");
        refused(found, 5, &["moves the robot by what comes from outside"]);
        let found = with(&format!("IF di1=1 {sent}"), "VAR egmident e;");
        refused(found, 4, &["IF decides about motion at run time"]);
    }
    // What only makes it ready, or sends where the arm is.
    let ready = "EGMReset e;\nEGMGetId e;\nEGMSetupUC ROB_1,e,\"a\",\"b\"\\Pose;\n\
                 EGMActPose e\\Tool:=tool0,p0,EGM_FRAME_BASE,p0,EGM_FRAME_BASE;\n\
                 EGMStreamStart e\\SampleRate:=4;\nEGMStreamStop e;\nActEventBuffer;\n\
                 DeactEventBuffer;\nEraseModule \"b\";";
    let found = with(&format!("{MOVE}\n{ready}\n{NEXT}"), "VAR egmident e;VAR pose p0;");
    assert_eq!(doubts(&found.unwrap()), []);
}

/// An index that nothing of the job can change.
#[test]
fn an_index_of_zero_is_told_without_assume() {
    let text = "MODULE m\nVAR bool full{2}:=[FALSE,FALSE];\nVAR num kind;\nVAR num i:=1;\n\
                CONST robtarget p:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
                PROC place()\nWHILE full{kind} DO\ni:=i+1;\nENDWHILE\nIF i=1 MoveL p,v5,fine,tool0;\n\
                ENDPROC\nENDMODULE\n";
    let assume = [("kind".to_owned(), Assumed::Number(1.0))].into();
    let job = Settings { procedure: Some("place".to_owned()), assume, ..settings() };
    let said = ["index 0 of 'full' is not a whole number from 1: write the value into a copy"];
    let found = run(text, &job);
    assert!(!format!("{found:?}").contains("assume: in the job"), "{found:?}");
    refused(found, 10, &said);
}

/// Technical reference manual, TPReadFK: without an error the \BreakFlag is 0, and ERR_ numbers are not.
#[test]
fn numbers_of_errors_are_the_controllers_and_never_zero() {
    let of = |asked: &str, errvar: Option<f64>| {
        let ask = "TPReadFK n,\"?\",\"a\",\"\",\"\",\"\",\"\"\\MaxTime:=9\\BreakFlag:=errvar;";
        let text = module(&format!("{MOVE}\n{ask}\n{asked}\n{NEXT}"))
            .replace("ENDMODULE", "VAR errnum errvar;\nVAR num n;\nENDMODULE");
        let assume = errvar.map(|own| ("errvar".to_owned(), Assumed::Number(own)));
        run(&text, &Settings { assume: assume.into_iter().collect(), ..settings() })
    };
    for (asked, expected) in [
        ("IF errvar=ERR_TP_MAXTIME EXIT;", vec![4, 7]),
        ("IF ERR_TP_DIBREAK=errvar EXIT;", vec![4, 7]),
        ("IF errvar<>ERR_TP_MAXTIME EXIT;", vec![4]),
        ("TEST errvar CASE ERR_TP_MAXTIME: EXIT; DEFAULT: ENDTEST", vec![4, 7]),
        ("TEST ERR_TP_MAXTIME CASE errvar: EXIT; DEFAULT: ENDTEST", vec![4, 7]),
        ("IF errvar=ERR_COLL_STOP EXIT;", vec![4, 7]),
    ] {
        assert_eq!(lines(&of(asked, Some(0.0)).unwrap()), expected, "{asked}");
    }
    let asked = "IF errvar=ERR_TP_MAXTIME EXIT;";
    let own = ["'ERR_TP_MAXTIME' is a constant of the controller", "{\"ERR_TP_MAXTIME\": …}"];
    refused(of(asked, Some(3.0)), 6, &own);
    refused(of(asked, None), 6, &["TPReadFK fills in 'errvar'"]);
    // One of the program may have any number.
    for name in ["ERR_NONE", "ERR_GRIPPER_FREE"] {
        let asked = format!("IF errvar={name} EXIT;");
        refused(of(&asked, Some(0.0)), 6, &[&format!("'{name}' is not declared")]);
    }
    let body = format!("{MOVE}\nIF 0=ERR_TP_MAXTIME EXIT;\n{NEXT}");
    assert_eq!(lines(&with(&body, "VAR num ERR_TP_MAXTIME;").unwrap()), [4]);
    refused(with("IF 1=SOCKET_CLOSED EXIT;", ""), 4, &["'SOCKET_CLOSED' is a constant of the"]);
}

/// Technical reference manual, DefFrame: x from p1 through p2, p3 on the side of y, the origin in p1, in p2, or
/// on the line of both so that p3 lies on the y axis. Here x is +Y, y is -X and z is +Z of the work object.
#[test]
fn a_frame_of_three_targets_is_worked_out() {
    let of = |origin: &str| {
        with(
            &format!(
                "VAR pose f;\nVAR robtarget q;\nf:=DefFrame(p,Offs(p,0,50,0),Offs(p,-30,10,0){origin});\n\
                 q:=p;\nq.trans:=PoseVect(f,[5,2,1]);\nMoveL q,v5,fine,tool0;"
            ),
            "",
        )
        .unwrap()
    };
    for (origin, y) in
        [("", 205.0), ("\\Origin:=1", 205.0), ("\\Origin:=2", 255.0), ("\\Origin:=3", 215.0)]
    {
        assert_ends(&of(origin), &[('L', [98.0, y, 301.0])]);
    }
    for (points, why) in [
        ("p,p,Offs(p,0,0,9)", "the first two points are one"),
        ("p,Offs(p,5,0,0),Offs(p,9,0,0)", "the three points lie on a line"),
        ("p,Offs(p,5,0,0),Offs(p,0,9,0)\\Origin:=4", "\\Origin is 4, expected 1, 2 or 3"),
        ("p,Offs(p,5,0,0),Offs(p,0,9,0)\\Origin:=0", "\\Origin is 0, expected 1, 2 or 3"),
        ("p,Offs(p,5,0,0),Offs(p,0,9,0)\\Origin:=1.5", "\\Origin is 1.5, expected 1, 2 or 3"),
    ] {
        let body = format!(
            "VAR pose f;\nf:=DefFrame({points});\nMoveL Offs(p,f.trans.x,0,0),v5,fine,tool0;"
        );
        refused(with(&body, ""), 6, &["DefFrame: ", why]);
    }
}

/// The tool turns as slowly as the run says.
#[test]
fn a_turning_speed_that_only_the_run_knows_is_a_doubt() {
    for set in ["TPReadNum n,\"?\"; v.v_ori:=n;", "IF di1=1 n:=10; v.v_ori:=n;"] {
        let turned = "MoveL RelTool(p,0,9,0\\Rz:=120),v,fine,tool0;\nv:=v100; n:=0;";
        let data = "VAR speeddata v:=v100;\nVAR num n;";
        let found = with(&format!("{MOVE}\n{set}\n{turned}"), data).unwrap();
        assert_eq!(doubts(&found), [(Code::ChangeIgnored, 6)], "{set}");
        // The first move has no way.
        let found = with(&format!("{set}\n{turned}"), data).unwrap();
        assert_eq!(doubts(&found), [], "{set}");
    }
}

/// Doubts about two moves with these tools and the job's tcp.
fn with_tools(first: &str, second: &str, more: &str) -> Vec<(Code, usize)> {
    let moves = format!("MoveL p,v5,fine,{first};\nMoveL Offs(p,10,0,0),v5,fine,{second};");
    let text = module(&moves).replace("ENDMODULE", &format!("{more}\nENDMODULE"));
    let tcp = Some(Isometry3::translation(0.0, 0.0, 0.08));
    doubts(&run(&text, &Settings { tcp, ..settings() }).unwrap())
}

/// Elements and parts of data of another file are different data.
#[test]
fn one_tcp_of_the_job_stands_for_two_elements_or_parts_with_a_doubt() {
    const TWO: [(Code, usize); 1] = [(Code::ChangeIgnored, 5)];
    assert_eq!(with_tools("tG{1}", "tG{1}", ""), []);
    assert_eq!(with_tools("tG{1}", "tG{2}", ""), TWO);
    assert_eq!(with_tools("st.a", "st.b", ""), TWO);
    assert_eq!(with_tools("tP{1}", "tP{1}", "PERS tooldata tP{2};"), []);
    assert_eq!(with_tools("tP{1}", "tP{2}", "PERS tooldata tP{2};"), TWO);
    // Which one it is the run knows.
    assert_eq!(with_tools("tG{n}", "tG{n}", ""), [(Code::ChangeIgnored, 4)]);
}

#[test]
fn a_part_of_a_type_of_another_file_is_the_jobs_unless_the_program_sets_it() {
    assert_eq!(with_tools("st.t", "st.t", "VAR station st;"), []);
    assert_eq!(with_tools("st.t", "st.t", "PERS station st;"), []);
    let set = with_tools("tool0;\nst.t:=tool0", "st.t", "VAR station st;");
    assert!(set.contains(&(Code::ChangeIgnored, 6)), "{set:?}");
    let stated = with_tools("st.t", "st.t", "CONST station st:=[1,2];");
    assert_eq!(stated, [(Code::ChangeIgnored, 4)]);
    let found = with(&format!("{MOVE}\n{}", NEXT.replace("v5", "st.v")), "VAR station st;");
    assert_eq!(doubts(&found.unwrap()), []);
}

/// Technical reference manual, CTool and CWObj: the tool and the work object that are used now.
#[test]
fn the_current_tool_and_work_object_are_the_jobs_where_nothing_else_was_used() {
    assert_eq!(with_tools("CTool()", "CTool()", ""), []);
    let own = "PERS tooldata t:=[TRUE,[[0,0,7],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];";
    assert_eq!(with_tools("t", "CTool()", own), []);
    for (between, z) in [("", 0.007), ("SetSysData u;", 0.005)] {
        let own = format!("{own}\n{}", own.replace(" t:", " u:").replace(",7]", ",5]"));
        let moves = format!("MoveL p,v5,fine,t;\n{between}\nMoveL p,v5,fine,CTool();");
        let text = module(&moves).replace("ENDMODULE", &format!("{own}\nENDMODULE"));
        let found = run(&text, &settings()).unwrap();
        assert_eq!((found.moves[1].tcp.translation.z, doubts(&found)), (z, vec![]), "{between}");
    }
    let unknown = with_tools("t;\nIF DInput(di1)=1 SetSysData t", "CTool()", own);
    assert!(unknown.contains(&(Code::ChangeIgnored, 6)), "{unknown:?}");
    let object = "tool0\\WObj:=CWObj();";
    let text = module(&[MOVE, NEXT].map(|each| each.replace("tool0;", object)).join("\n"));
    let work_object = Some(Isometry3::translation(0.0, 0.0, 0.1));
    let found = run(&text, &Settings { work_object, ..settings() }).unwrap();
    assert_eq!(doubts(&found), [], "{:?}", found.warnings);
}

/// errnum is num by another name, and handlers of errors are not read.
#[test]
fn what_a_handler_may_set_is_not_known_to_be_no_error() {
    let asked = format!("{MOVE}\nIF e=ERR_WAIT_MAXTIME EXIT;\n{NEXT}");
    for data in ["VAR errnum e;", "VAR errnum e:=0;"] {
        assert_eq!(lines(&with(&asked, data).unwrap()), [4, 6]);
        let handled = format!("{asked}\nERROR\ne:=ERRNO;\nTRYNEXT;");
        refused(with(&handled, data), 5, &["'ERR_WAIT_MAXTIME' is a constant of the controller"]);
        let assume = [("err_wait_maxtime".to_owned(), Assumed::Number(0.0))].into();
        let text = module(&asked).replace("ENDMODULE", &format!("{data}\nENDMODULE"));
        assert_eq!(lines(&run(&text, &Settings { assume, ..settings() }).unwrap()), [4]);
    }
}

/// Technical reference manual, MoveL, CorrCon, CorrWrite: under \Corr the controller adds to the path what a sensor
/// gives.
#[test]
fn a_path_that_a_sensor_corrects_is_a_doubt() {
    for way in [
        "MoveL Offs(p,10,0,0),v5,fine,tool0\\Corr;",
        "MoveC Offs(p,5,2,0),Offs(p,10,0,0),v5,fine,tool0\\Corr;",
        "TriggL Offs(p,10,0,0),v5,t1,fine,tool0\\Corr;",
    ] {
        let of = |way: &str| with(&format!("{MOVE}\n{way}\nCorrClear;"), "VAR triggdata t1;");
        assert_eq!(doubts(&of(&way.replace("\\Corr", "")).unwrap()), [], "{way}");
        assert_eq!(doubts(&of(way).unwrap()), [(Code::MotionLeftOut, 5)], "{way}");
    }
    let go = "PROC Go(\\switch Corr)\nMoveL Offs(p,10,0,0),v5,fine,tool0\\Corr?Corr;\nENDPROC";
    for (call, expected) in [("Go;", vec![]), ("Go\\Corr;", vec![(Code::MotionLeftOut, 8)])] {
        assert_eq!(doubts(&with(&format!("{MOVE}\n{call}"), go).unwrap()), expected, "{call}");
    }
    let said = ["CorrCon: a correction of the path by a sensor", "out of a copy of the program"];
    refused(with(&format!("{MOVE}\nCorrCon z;"), "VAR corrdescr z;"), 5, &said);
}

/// Application manuals, Controller software (SoftMove, Path Recovery, Independent Axes, Conveyor tracking).
#[test]
fn instructions_of_options_that_move_or_soften_the_arm_are_known() {
    for call in [
        "CSSAct\\RefFrame:=CSS_REFFRAME_TOOL,CSS_Z\\StiffnessNonSoftDir:=50\\Stiffness:=10\\AllowMove;",
        "SetLeadThrough\\On;",
        "WaitWObj w\\RelDist:=50;",
        "DropWObj w;",
    ] {
        let found = with(&format!("{MOVE}\n{call}\n{NEXT}"), "PERS wobjdata w;").unwrap();
        assert_eq!(doubts(&found), [(Code::ChangeIgnored, 5)], "{call}");
    }
    for (call, how) in [
        ("CSSDeactMoveL p,v5,tool0;", "moves and is not understood: put the moves"),
        ("PathRecMoveBwd\\ID:=id1;", "moves the arm back or forth along its path"),
        ("IndCMove STN_A,2,20;", "moves an axis beside the moves of the robot"),
    ] {
        refused(with(&format!("{MOVE}\n{call}\n{NEXT}"), ""), 5, &[how, "a copy of the program"]);
    }
}

/// ErrRaise goes to the handler of errors, as RAISE does: what stands behind it is not reached.
#[test]
fn an_error_that_the_program_raises_itself_is_refused() {
    let raise = "ErrRaise \"ERR_I\",4800,\"t\",ERRSTR_TASK,\"s\",ERRSTR_CONTEXT,ERRSTR_EMPTY;";
    let found = with(&format!("{MOVE}\n{raise}\n{NEXT}\nERROR\nRETURN;"), "");
    refused(found, 5, &["ErrRaise outside an error handler"]);
}

#[test]
fn a_number_in_a_string_that_only_the_run_knows_is_told_by_that() {
    let data = "VAR socketdev c;VAR string s;VAR num n;VAR bool ok;";
    let found = with(&format!("SocketReceive c\\Str:=s;\nok:=StrToVal(s,n);\nIF ok {MOVE}"), data);
    assert!(!format!("{found:?}").contains("is not read"), "{found:?}");
    refused(found, 6, &["StrToVal: SocketReceive fills in 's'"]);
}

/// A datum that no file declares, and that the program sets before a trap may: what the job says of it counts, as of
/// one that is declared.
#[test]
fn what_the_job_says_of_what_a_trap_sets_counts_without_a_declaration() {
    let body = format!("{MOVE}\nnM:=1;\nCONNECT i1 WITH tr;\nISignalDI di1,1,i1;\nIF nM=2 {NEXT}");
    for declared in ["VAR num nM;", ""] {
        let trap = format!("VAR intnum i1;{declared}\nTRAP tr\nnM:=nC;\nENDTRAP\nENDMODULE");
        let assume = [("nm".to_owned(), Assumed::Number(2.0))].into();
        let text = module(&body).replace("ENDMODULE", &trap);
        let found = run(&text, &Settings { assume, ..settings() }).unwrap();
        assert_eq!((lines(&found), doubts(&found)), (vec![4, 8], vec![]), "{declared}");
        assert!(!format!("{:?}", found.warnings).contains("no effect"), "{:?}", found.warnings);
    }
}

/// Technical reference manual, SoftDeact, TuneReset; application manual, Force control: what they end may hold since
/// before the procedure of the job.
#[test]
fn an_end_of_softness_that_nothing_begins_is_a_doubt() {
    for (begin, end) in [
        ("SoftAct 3,50;", "SoftDeact;"),
        ("TuneServo ROB_1,1,110;", "TuneReset;"),
        ("CSSAct\\RefFrame:=CSS_REFFRAME_TOOL,CSS_Z;", "CSSDeact;"),
        ("FCAct tool0;", "FCDeact;"),
        ("FCSpdChgAct 200;", "FCSpdChgDeact;"),
        ("SetLeadThrough\\On;", "SetLeadThrough\\Off;"),
    ] {
        let of = |body: String| doubts(&with(&body, "").unwrap());
        assert_eq!(of(format!("{MOVE}\n{NEXT}\n{end}")), [(Code::ChangeIgnored, 6)], "{end}");
        let open = format!("{MOVE}\n{NEXT}\nIF di1=1 {end}");
        assert_eq!(of(open), [(Code::ChangeIgnored, 6)], "{end}");
        // The first move goes to where the path starts.
        assert_eq!(of(format!("{end}\n{MOVE}\n{end}\n{NEXT}")), [], "{end}");
        let whole = format!("{MOVE}\n{begin}\n{NEXT}\n{end}");
        assert_eq!(of(whole), [(Code::ChangeIgnored, 5)], "{begin}");
    }
    let found = with(&format!("{MOVE}\nSetLeadThrough\\On;\n{NEXT}"), "").unwrap();
    let is_told = |note: &Note| note.what.ends_with("the path is checked as it is programmed");
    assert!(found.warnings.iter().any(is_told), "{:?}", found.warnings);
}

/// They use the tool and the work object, and do not set them.
#[test]
fn what_changes_the_arm_under_a_condition_leaves_its_arguments_as_they_are() {
    let data = "PERS wobjdata w:=[FALSE,TRUE,\"\",[[10,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n\
                PERS tooldata t:=[TRUE,[[0,0,50],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];";
    let way = "MoveL p,v5,fine,t\\WObj:=w;";
    for call in ["FCAct t;", "DropWObj w;"] {
        let found = with(&format!("{way}\nIF di1=1 {call}\n{way}"), data).unwrap();
        assert_ends(&found, &[('L', [110.0, 200.0, 300.0]), ('L', [110.0, 200.0, 300.0])]);
        assert!(found.moves.iter().all(|own| (own.tcp.translation.z - 0.05).abs() < 1e-12));
        assert_eq!(doubts(&found), [(Code::ChangeIgnored, 5)], "{call}");
    }
}

/// `assume` gives no strings.
#[test]
fn a_string_of_no_file_is_to_be_written_into_the_program() {
    let body = format!("ok:=StrToVal(s,n);\nIF ok {MOVE}");
    let found = with(&body, "VAR num n;VAR bool ok;");
    assert!(!format!("{found:?}").contains("assume"), "{found:?}");
    refused(found, 5, &["StrToVal: ", "write the value into a copy of the program"]);
}
