//! What others decide while a program runs: other tasks, timers, routines of other files, the next cycle; and what
//! rounding or the order of operators decides. All of it was once read as the program alone would have it.

use detune::notes::{Class, Code, Note};
use detune::program::{Assumed, Dialect, Program, Settings, read};
use nalgebra::Isometry3;

use super::support::{at, end, settings};

/// A module with data, whose `main` moves to x = 0 in line 5 and then does more.
fn module(data: &str, body: &str) -> String {
    format!(
        "MODULE m\nCONST robtarget p0:=[[0,0,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n{data}\n\
         PROC main()\nMoveL p0,v100,fine,tool0;\n{body}\nENDPROC\nENDMODULE\n"
    )
}

fn rapid_with(data: &str, body: &str, job: &Settings) -> Result<Program, Vec<Note>> {
    read(module(data, body).as_bytes(), Dialect::Rapid, job)
}

fn rapid(data: &str, body: &str) -> Result<Program, Vec<Note>> {
    rapid_with(data, body, &settings())
}

fn krl_with(body: &str, job: &Settings) -> Result<Program, Vec<Note>> {
    let start = "PTP {X 0,Y 0,Z 500,A 0,B 0,C 180}";
    read(format!("DEF p()\n$VEL.CP=0.1\n{start}\n{body}\nEND\n").as_bytes(), Dialect::Krl, job)
}

fn krl(body: &str) -> Result<Program, Vec<Note>> {
    krl_with(body, &settings())
}

/// X of the moves behind the first, mm.
#[track_caller]
fn x(found: Result<Program, Vec<Note>>) -> Vec<f64> {
    let program = found.unwrap_or_else(|found| panic!("{found:?}"));
    let of = |each| (end(each).1.translation.x * 1e9).round() / 1e6;
    program.moves.iter().skip(1).map(of).collect()
}

#[track_caller]
fn doubts(found: Result<Program, Vec<Note>>) -> Vec<(Code, usize)> {
    let program = found.unwrap_or_else(|found| panic!("{found:?}"));
    let told = program.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    told.map(|note| (note.code, at(note))).collect()
}

#[track_caller]
fn refused(found: Result<Program, Vec<Note>>, said: &str) {
    let found = found.expect_err(said);
    assert!(found.iter().any(|note| note.what.contains(said)), "{said}: {found:?}");
}

fn assuming(names: &[(&str, Assumed)]) -> Settings {
    let assume = names.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    Settings { assume, ..settings() }
}

const BRANCH: &str = "MoveL Offs(p0,1,0,0),v100,fine,tool0;\nELSE\n\
                      MoveL Offs(p0,2,0,0),v100,fine,tool0;\nENDIF";

/// RAPID's grammar has `[NOT] term {OR term}`, and a term is joined by AND.
#[test]
fn not_before_and_counts_where_its_reach_changes_nothing() {
    let data = "VAR bool a:=FALSE;VAR bool b:=FALSE;VAR bool c:=TRUE;";
    for (condition, expected) in [
        ("NOT a AND c", 1.0),
        ("NOT c AND c", 2.0),
        ("(NOT a) AND b", 2.0),
        ("NOT (a AND b)", 1.0),
        ("NOT a AND c OR b", 1.0),
        ("c AND NOT a", 1.0),
    ] {
        assert_eq!(
            x(rapid(data, &format!("IF {condition} THEN\n{BRANCH}"))),
            [expected],
            "{condition}"
        );
    }
    // NOT (FALSE AND FALSE) is TRUE, (NOT FALSE) AND FALSE is not.
    for condition in ["NOT a AND b", "NOT a AND b OR a", "NOT c AND b"] {
        refused(rapid(data, &format!("IF {condition} THEN\n{BRANCH}")), "put parentheses");
    }
    let nested = (0..15).fold("a".to_owned(), |inner, _| format!("NOT ({inner} AND c) AND c"));
    // Both ways of each would be kept in both of the next.
    assert!(rapid(data, &format!("IF {nested} THEN\n{BRANCH}")).is_err());
}

/// A num has seven digits: three times 0.1 is 0.3 or a little more.
#[test]
fn what_the_rounding_of_num_decides_is_not_known() {
    let body = |condition: &str, step: &str| {
        format!(
            "x:=0;\nWHILE {condition} DO\nMoveL Offs(p0,10*x,0,0),v100,fine,tool0;\nx:=x+{step};\nENDWHILE"
        )
    };
    let data = "VAR num x;";
    let down = "x:=0.3;\nWHILE x>0 DO\nMoveL Offs(p0,x,0,0),v100,fine,tool0;\nx:=x-0.1;\nENDWHILE";
    refused(rapid(data, down), "rounding to seven digits decides");
    // Seven times 0.1 is 0.7 with sixteen digits.
    for (condition, step) in
        [("x<=0.3", "0.1"), ("x<1", "0.1"), ("x<>0.3", "0.1"), ("x<=0.7", "0.1")]
    {
        refused(rapid(data, &body(condition, step)), "rounding to seven digits decides");
    }
    // 0.1 + 6 · 0.1 is 0.7 with sixteen digits and more with seven.
    let way = |from: &str, to: &str, step: &str| {
        let body = "MoveL Offs(p0,i,0,0),v100,fine,tool0;";
        rapid(data, &format!("FOR i FROM {from} TO {to} STEP {step} DO\n{body}\nENDFOR"))
    };
    refused(way("0.1", "0.7", "0.1"), "rounding to seven digits decides");
    assert_eq!(x(way("0", "1", "0.25")).len(), 5);
    refused(
        rapid(data, "FOR i FROM 0 TO 1 STEP 0.1 DO\nMoveL Offs(p0,i,0,0),v100,fine,tool0;\nENDFOR"),
        "rounding to seven digits decides",
    );
    assert_eq!(x(rapid(data, &body("x<0.35", "0.1"))), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(x(rapid(data, &body("x<=1", "0.5"))), [0.0, 5.0, 10.0]);
    assert_eq!(x(rapid(data, &body("x<3", "1"))), [0.0, 10.0, 20.0]);
}

/// REAL of KRL and registers of TP have seven digits, too; INT are whole.
#[test]
fn what_the_rounding_of_reals_decides_is_not_known() {
    let krl_loop = |condition: &str, step: &str| {
        format!("REAL D\nD=0\nWHILE {condition}\nLIN {{X D}}\nD=D+{step}\nENDWHILE")
    };
    // Ten times 0.7 is 6.999999 with seven digits.
    for (condition, step) in [("D<7", "0.7"), ("D<>2.1", "0.7"), ("D<=0.3", "0.1")] {
        refused(krl(&krl_loop(condition, step)), "rounding to seven digits decides");
    }
    assert_eq!(x(krl(&krl_loop("D<1.6", "0.7"))), [0.0, 0.7, 1.4]);
    let counted =
        "INT N\nFOR N=20000001 TO 20000003\nIF N<20000003 THEN\nLIN {X N-20000000}\nENDIF\nENDFOR";
    assert_eq!(x(krl(counted)), [1.0, 2.0]);
}

/// Persistent data belong to all tasks.
#[test]
fn persistent_data_that_no_file_sets_are_set_by_others() {
    let asked = format!("IF go THEN\n{BRANCH}");
    refused(rapid("PERS bool go;", &asked), "another task has it");
    let off = "PERS bool go:=FALSE;";
    assert_eq!(doubts(rapid(off, &asked)), [(Code::MotionLeftOut, 6)]);
    for (value, expected) in [(true, 1.0), (false, 2.0)] {
        let job = assuming(&[("go", Assumed::Truth(value))]);
        for data in [off, "PERS bool go;"] {
            assert_eq!(x(rapid_with(data, &asked, &job)), [expected]);
            assert_eq!(doubts(rapid_with(data, &asked, &job)), []);
        }
    }
    // Loops ask, too.
    let count = "PERS num n:=2;";
    let move_there = "MoveL Offs(p0,1,0,0),v100,fine,tool0;";
    for head in ["FOR i FROM 1 TO n", "WHILE n<1"] {
        let end = if head.starts_with('F') { "ENDFOR" } else { "ENDWHILE" };
        let body = format!("{head} DO\n{move_there}\n{end}");
        assert_eq!(doubts(rapid(count, &body)), [(Code::MotionLeftOut, 6)], "{head}");
    }
    // To show it, and to take it back, is not to set it.
    let shown = format!("TPWrite \"go\" \\Bool:=go;\n{asked}");
    assert_eq!(doubts(rapid(off, &shown)), [(Code::MotionLeftOut, 7)]);
    let answered = format!("{asked}\ngo:=FALSE;");
    assert_eq!(doubts(rapid(off, &answered)), [(Code::MotionLeftOut, 6)]);
    // What later moves need, by way of other data and routines; what they do not need.
    let speed = "PERS bool go:=FALSE;\nVAR speeddata v:=v100;\nVAR num n:=0;";
    let last = "MoveL p0,v,fine,tool0;";
    for branch in ["v:=v200;", "n:=1;", "Incr n;", "RETURN;", "CirPathMode\\ObjectFrame;"] {
        let body = format!("IF go THEN\n{branch}\nENDIF\nIF n>0 v:=v50;\n{last}");
        assert_eq!(doubts(rapid(speed, &body)), [(Code::MotionLeftOut, 8)], "{branch}");
        let job = assuming(&[("go", Assumed::Truth(false))]);
        assert_eq!(doubts(rapid_with(speed, &body, &job)), [], "{branch}");
    }
    // By way of what the branches of others set.
    let by_way = format!("{speed}\nVAR num m;VAR num z;VAR bool ok;VAR string t:=\"\";");
    for next in [
        "IF m=1 Incr n;",
        "IF m=1 THEN\nIF z=0 Add n,1;\nENDIF",
        "Add n,m;",
        "IF m=1 t:=\"1\";\nok:=StrToVal(t,n);",
    ] {
        let body = format!("IF go m:=1;\n{next}\nIF n>0 v:=v50;\n{last}");
        let job = assuming(&[("n", Assumed::Number(0.0))]);
        let found = doubts(rapid_with(&by_way, &body, &job));
        assert_eq!(found, [(Code::MotionLeftOut, 9)], "{next}");
    }
    let counted = format!("IF go n:=1;\nTPWrite \"n\" \\Num:=n;\n{last}");
    assert_eq!(doubts(rapid(speed, &counted)), []);
    // What the program sets, and what decides about no move.
    assert_eq!(doubts(rapid(off, &format!("go:=TRUE;\n{asked}"))), []);
    assert_eq!(doubts(rapid(off, "IF go THEN\nSetDO lamp,1;\nENDIF")), []);
    let mode = "PERS num mode:=2;";
    let test = "TEST mode\nCASE 1:\nMoveL Offs(p0,1,0,0),v100,fine,tool0;\nDEFAULT:\nENDTEST";
    assert_eq!(doubts(rapid(mode, test)), [(Code::MotionLeftOut, 6)]);
    let job = assuming(&[("mode", Assumed::Number(1.0))]);
    assert_eq!(x(rapid_with(mode, test, &job)), [1.0]);
}

#[test]
fn exit_cycle_in_a_branch_leaves_the_moves_behind_it_to_the_next_cycle() {
    let last = "MoveL Offs(p0,3,0,0),v100,fine,tool0;";
    let data = "VAR num n:=0;";
    assert_eq!(
        doubts(rapid(data, &format!("n:=n+1;\nIF n<3 ExitCycle;\n{last}"))),
        [(Code::MotionLeftOut, 8)]
    );
    // In the fourth cycle it does, as n counts on.
    assert_eq!(
        doubts(rapid(data, &format!("n:=n+1;\nIF n>3 ExitCycle;\n{last}"))),
        [(Code::MotionLeftOut, 4)]
    );
    assert_eq!(doubts(rapid(data, &format!("n:=1;\nIF n>3 ExitCycle;\n{last}"))), []);
    assert_eq!(doubts(rapid(data, &format!("{last}\nIF n<3 ExitCycle;"))), []);
    let other = format!("IF n<3 THEN\nn:=n+1;\nExitCycle;\nELSE\n{last}\nENDIF");
    assert_eq!(doubts(rapid(data, &other)), [(Code::MotionLeftOut, 10)]);
    assert_eq!(doubts(rapid(data, &format!("{last}\nExitCycle;"))), []);
}

/// At its end `main` starts again, and the data of the modules stay.
#[test]
fn a_cycle_that_leaves_other_data_is_not_the_last_word() {
    let data = "VAR num n:=0;\nVAR bool first:=TRUE;\nPERS num made:=0;\nVAR robtarget at;";
    let there = |x: &str| format!("MoveL Offs(p0,{x},0,0),v100,fine,tool0;");
    let again = [(Code::MotionLeftOut, 7)];
    for body in [
        // One stage a cycle; a way that only the first has; a row of parts; stages of three.
        format!("TEST n\nCASE 0:\n{}\nn:=1;\nCASE 1:\n{}\nENDTEST", there("1"), there("2")),
        format!("IF first THEN\n{}\nfirst:=FALSE;\nENDIF", there("1")),
        format!("{}\nn:=n+10;", there("n")),
        format!("IF n=2 THEN\n{}\nENDIF\nIncr n;", there("1")),
    ] {
        assert_eq!(doubts(rapid(data, &body)), again, "{body}");
        // A procedure of another name is a part of a cycle.
        let text = module(data, &body).replace("main()", "part()");
        assert_eq!(doubts(read(text.as_bytes(), Dialect::Rapid, &settings())), [], "{body}");
    }
    // What outputs, the load and speeds are then.
    for (body, line) in [
        (format!("IF DOutput(doX)=1 THEN\n{}\nENDIF\nSetDO doX,1;", there("1")), 7),
        (format!("{}\nVelSet 50,1000;", there("1")), 7),
        (format!("{}\nGripLoad part;", there("1")), 7),
        (format!("IF n>0 ToolChange;\n{}\nn:=1;", there("1")), 7),
    ] {
        let job = assuming(&[("dox", Assumed::Truth(false))]);
        let data = format!("{data} PERS loaddata part:=[3,[0,0,1],[1,0,0,0],0,0,0];");
        let told = doubts(rapid_with(&data, &body, &job));
        assert!(told.contains(&(Code::MotionLeftOut, line)), "{body}: {told:?}");
    }
    for body in [
        format!("{}\nSetDO doX,1;\nConfL\\Off;", there("1")),
        format!("n:=0;\nWHILE n<3 DO\n{}\nn:=n+1;\nENDWHILE", there("n")),
        format!("{}\nmade:=made+1;\nTPWrite \"made\" \\Num:=made;", there("1")),
        "at:=Offs(p0,1,0,0);\nMoveL at,v100,fine,tool0;\nfirst:=FALSE;".to_owned(),
        format!("{}\nn:=n+1;\nEXIT;", there("n")),
    ] {
        assert_eq!(doubts(rapid(data, &body)), [], "{body}");
    }
    // A local datum starts anew.
    let text =
        module("", &format!("n:=n+10;\n{}", there("n"))).replace("main()", "main()\nVAR num n:=0;");
    assert_eq!(doubts(read(text.as_bytes(), Dialect::Rapid, &settings())), []);
}

/// CRobT reads where the arm is, not where it goes.
#[test]
fn where_the_arm_is_is_known_behind_a_stop() {
    let data = "VAR robtarget at;\nVAR zonedata stop:=[TRUE,0,0,0,0,0,0];";
    let ask = "at:=CRobT(\\Tool:=tool0\\WObj:=wobj0);\nMoveL Offs(at,0,5,0),v100,fine,tool0;";
    let doubt = [(Code::MotionLeftOut, 8)];
    for (zone, expected) in [
        ("z50", &doubt[..]),
        ("z0", &doubt),
        ("fine", &[]),
        ("stop", &[]),
        ("z50\\Inpos:=inpos20", &[]),
    ] {
        let found = doubts(rapid(data, &format!("MoveL Offs(p0,1,0,0),v100,{zone},tool0;\n{ask}")));
        assert_eq!(found, expected, "{zone}");
    }
    let moving = "MoveL Offs(p0,1,0,0),v100,z50,tool0;";
    let wrapped = module(data, &format!("mv fine;\n{ask}")).replace(
        "ENDMODULE",
        "PROC mv(zonedata z)\nMoveL Offs(p0,1,0,0),v100,z,tool0;\nENDPROC\nENDMODULE",
    );
    assert_eq!(doubts(read(wrapped.as_bytes(), Dialect::Rapid, &settings())), []);
    for wait in ["WaitTime \\InPos,0;", "WaitRob \\InPos;", "Stop;"] {
        assert_eq!(doubts(rapid(data, &format!("{moving}\n{wait}\n{ask}"))), [], "{wait}");
    }
    assert_eq!(
        doubts(rapid(data, &format!("{moving}\nWaitTime 1;\n{ask}"))),
        [(Code::MotionLeftOut, 9)]
    );
}

/// What is LOCAL in another module is not seen, in one file or in two, whichever comes first.
#[test]
fn local_data_are_seen_in_their_own_module_alone() {
    let user = "MODULE a\nPROC main()\nMoveL p0,v100,fine,tool0;\nMoveL Offs(p0,1,0,0),v100,fine,tool0;\n\
                ENDPROC\nENDMODULE\n";
    let owner = |local: &str| {
        format!(
            "MODULE b\n{local}CONST robtarget p0:=[[0,0,500],[0,1,0,0],[0,0,0,0],\
             [9E9,9E9,9E9,9E9,9E9,9E9]];\nENDMODULE\n"
        )
    };
    let all = |local: &str| [format!("{user}{}", owner(local)), format!("{}{user}", owner(local))];
    for text in all("LOCAL ") {
        let found = read(text.as_bytes(), Dialect::Rapid, &settings());
        refused(found, "'p0' is not declared in this file");
    }
    for text in all("") {
        assert_eq!(x(read(text.as_bytes(), Dialect::Rapid, &settings())), [1.0]);
    }
}

/// Functions that only the run knows have what the job assumes of them.
#[test]
fn what_the_job_assumes_of_a_function() {
    let asked = format!("IF OpMode()=1 THEN\n{BRANCH}");
    refused(rapid("", &asked), "assume: {\"OpMode\": …}");
    let job = assuming(&[("opmode", Assumed::Number(1.0))]);
    assert_eq!(x(rapid_with("", &asked, &job)), [1.0]);
    let by_way = format!("n:=OpMode();\nIF n=1 THEN\n{BRANCH}");
    assert_eq!(x(rapid_with("VAR num n;", &by_way, &job)), [1.0]);
}

#[test]
fn one_work_object_of_the_job_does_not_stand_for_two() {
    let job = Settings { work_object: Some(Isometry3::translation(0.1, 0.0, 0.0)), ..settings() };
    let body = |second: &str| {
        format!(
            "MoveL p0,v100,fine,tool0\\WObj:=wA;\nMoveL Offs(p0,1,0,0),v100,fine,tool0\\WObj:=wA;\n\
             MoveL p0,v100,fine,tool0\\WObj:={second};"
        )
    };
    let text = |second: &str| module("", &body(second)).replace("MoveL p0,v100,fine,tool0;\n", "");
    let run = |second: &str| read(text(second).as_bytes(), Dialect::Rapid, &job);
    assert_eq!(doubts(run("wA")), []);
    assert_eq!(doubts(run("WA")), []);
    assert_eq!(doubts(run("wB")), [(Code::ChangeIgnored, 7)]);
    let listed = text("w{2}").replace("wA", "w{1}");
    let listed = read(listed.as_bytes(), Dialect::Rapid, &job);
    assert_eq!(doubts(listed), [(Code::ChangeIgnored, 7)]);
}

/// A joint that slides has its position in mm.
#[test]
fn sliding_joints_of_the_arm_are_in_mm() {
    let body = "MoveAbsJ [[200,0,0,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;";
    let job = Settings { sliding: vec![0], ..settings() };
    let program = rapid_with("", body, &job).unwrap();
    let detune::motion::Target::Joints(q) = &program.moves[1].to else { panic!() };
    assert!(
        (q[0] - 0.2).abs() < 1e-12 && (q[4] - 0.5 * std::f64::consts::PI).abs() < 1e-12,
        "{q:?}"
    );
}

#[test]
fn functions_that_are_not_read_are_not_called_run_time() {
    let frame = "VAR pose f;\nf:=DefDFrame(p0,p0,p0,p0,p0,p0);\nMoveL Offs(p0,f.trans.x,0,0),v100,fine,tool0;";
    refused(rapid("", frame), "function 'DefDFrame' is not read");
    let together = doubts(rapid("", "SyncMoveOn s1,tasks;\nMoveL Offs(p0,1,0,0),v100,fine,tool0;"));
    assert_eq!(together, [(Code::ChangeIgnored, 6)]);
}

/// Timers run, cyclical flags are worked out all the time.
#[test]
fn timers_and_cyclical_flags_of_krl_change_by_themselves() {
    let branch =
        |condition: &str| format!("IF {condition} THEN\nLIN {{X 1}}\nELSE\nLIN {{X 2}}\nENDIF");
    let timer =
        format!("$TIMER[1]=0\n$TIMER_STOP[1]=FALSE\nWAIT SEC 10\n{}", branch("$TIMER[1]>5000"));
    refused(krl(&timer), "'$TIMER[1]' is known only at run time");
    let job = assuming(&[("$timer[1]", Assumed::Number(10_000.0))]);
    assert_eq!(x(krl_with(&timer, &job)).last(), Some(&1.0));
    let flag = format!("INT N\nN=1\n$CYCFLAG[1]=(N==1)\nN=2\n{}", branch("$CYCFLAG[1]"));
    refused(krl(&flag), "'$CYCFLAG[1]' is known only at run time");
    let plain = format!("INT N\nN=1\n$FLAG[1]=(N==1)\nN=2\n{}", branch("$FLAG[1]"));
    assert_eq!(x(krl(&plain)), [1.0]);
}

/// KRL hands variables over by reference.
#[test]
fn a_routine_that_is_not_read_may_set_what_it_is_given() {
    let body = |call: &str| format!("INT N\nN=1\n{call}\nIF N==1 THEN\nLIN {{X 1}}\nENDIF");
    refused(krl(&body("MEAS(N)")), "'meas' is in no file that is read and may set it");
    let job = assuming(&[("n", Assumed::Number(1.0))]);
    assert_eq!(x(krl_with(&body("MEAS(N)"), &job)), [1.0]);
    assert_eq!(x(krl(&body("MEAS(N+0)"))), [1.0]);
    refused(krl(&body("OK=MEAS(N)")), "'meas' is in no file that is read and may set it");
}

#[test]
fn a_base_of_the_job_is_shifted_by_a_component() {
    let base = Isometry3::translation(0.1, 0.0, 0.0);
    let job = Settings { base_frames: [(2, base)].into(), ..settings() };
    let body = "BASE_DATA[2].X=BASE_DATA[2].X+50\n$BASE=BASE_DATA[2]\n\
                LIN {X 1,Y 0,Z 500,A 0,B 0,C 180}";
    assert_eq!(x(krl_with(body, &job)), [151.0]);
    refused(krl(body), "BASE_DATA[2] is in no file");
}

#[test]
fn bits_of_whole_numbers_are_joined() {
    for (expression, expected) in
        [("255 B_AND 15", 15.0), ("8 B_OR 3", 11.0), ("12 B_EXOR 10", 6.0), ("1 + 2 B_AND 2", 2.0)]
    {
        assert_eq!(
            x(krl(&format!("INT N\nN={expression}\nLIN {{X N}}"))),
            [expected],
            "{expression}"
        );
    }
    refused(krl("REAL R\nR=1.5 B_AND 1\nLIN {X R}"), "is no INT");
}

/// What an interrupt that is on sets, it may set behind an assignment, too; so may a trigger.
#[test]
fn interrupts_of_krl_come_at_any_time() {
    let asked = "WAIT SEC 0\nIF GV==3 THEN\nLIN {X 1}\nELSE\nLIN {X 2}\nENDIF";
    let with = |first: &str, then: &str| {
        format!(
            "INT GV\nGV=0\nINTERRUPT DECL 20 WHEN $IN[5] DO GV=5\n{first}\nGV=3\nLIN {{X 9}}\n{then}\n{asked}"
        )
    };
    let said = "'gv' is set by an interrupt: known only at run time";
    refused(krl(&with("INTERRUPT ON 20", "")), said);
    refused(krl(&with("INTERRUPT ON 20", "INTERRUPT OFF 20")), said);
    refused(krl(&with("INTERRUPT ON 20", "INTERRUPT OFF 21\nGV=3")), said);
    refused(krl(&with("INTERRUPT ON", "INTERRUPT OFF")), said);
    for own in [
        with("INTERRUPT ON 20", "INTERRUPT OFF 20\nGV=3"),
        with("INTERRUPT ON", "INTERRUPT OFF\nGV=3"),
        with("", ""),
    ] {
        assert_eq!(x(krl(&own)), [9.0, 1.0], "{own}");
    }
    // An element whose number the routine of the interrupt has; a datum of a routine's own.
    let list = "INT NA[3]\nNA[2]=0\nINTERRUPT DECL 20 WHEN $IN[5] DO HIT()\nINTERRUPT ON 20\nNA[2]=0\n\
                LIN {X 9}\nIF NA[2]==0 THEN\nLIN {X 1}\nENDIF\nEND\nDEF HIT()\nINT K\nK=2\nNA[K]=7";
    refused(krl(list), "is set by an interrupt");
    let trigger = with("TRIGGER WHEN DISTANCE=0 DELAY=0 DO GV=5", "");
    refused(krl(&trigger), "'gv' is set by a TRIGGER");
    let feed =
        "INTERRUPT DECL 20 WHEN $IN[5] DO V=0.01\nINTERRUPT ON 20\nV=0.1\n$VEL.CP=V\nLIN {X 1}";
    refused(krl(&format!("REAL V\n{feed}")), "'v' is set by an interrupt");
}

/// A routine in no file may set what the program has set; of other signals the job's word counts.
#[test]
fn signals_behind_a_routine_that_is_not_read() {
    let asked = "IF $OUT[99]==FALSE THEN\nLIN {X 1}\nELSE\nLIN {X 2}\nENDIF";
    let job = assuming(&[("$out[99]", Assumed::Truth(false))]);
    assert_eq!(x(krl_with(&format!("USER_GRP()\n{asked}"), &job)), [1.0]);
    let set = format!("$OUT[99]=TRUE\nUSER_GRP()\n{asked}");
    refused(krl_with(&set, &job), "path.program.files in the job can name its file");
}

#[test]
fn functions_of_krl() {
    // atan2(1, -1) is 135°.
    assert_eq!(x(krl("LIN {X ATAN2(1.0,-1.0)}")), [135.0]);
    refused(krl("LIN {X ATAN2(-1.0,1.0)}"), "ATAN2 of a negative Y");
    let state = |set: &str| {
        format!("{set}IF VARSTATE(\"N\")==#INITIALIZED THEN\nLIN {{X 1}}\nELSE\nLIN {{X 2}}\nENDIF")
    };
    assert_eq!(x(krl(&state("INT N\nN=1\n"))), [1.0]);
    refused(krl(&state("INT N\n")), "'varstate' is known only at run time");
    let asked = krl("PTP {X 1,Y 0,Z 500,A 0,B 0,C 180,S 6}");
    assert_eq!(doubts(asked), [(Code::MotionLeftOut, 4)]);
}
