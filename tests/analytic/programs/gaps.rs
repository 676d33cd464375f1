//! Words of real programs that were once refused or told of for a wrong reason: what of them is
//! read, and what still is not.

use detune::motion::Timing;
use detune::notes::{Code, Note};
use detune::program::{Assumed, Dialect, Program, SetBy, Setter, Settings, Spindle, read};
use nalgebra::Vector3;

use super::support::{assert_ends, at, end, module, pose, settings};

type Read = Result<Program, Vec<Note>>;

const NONE: [usize; 0] = [];

/// Frame 1 stands at x = 1000 mm, its x axis along the robot's y axis.
fn job(assumed: &[(&str, Assumed)]) -> Settings {
    let mut job = settings();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    job.base_frames.insert(1, pose([1000.0, 0.0, 0.0], [half, 0.0, 0.0, half]));
    job.tool_frames.insert(1, pose([0.0, 0.0, 150.0], [1.0, 0.0, 0.0, 0.0]));
    let assumed = assumed.iter().map(|(name, value)| ((*name).to_owned(), *value));
    job.assume.extend(assumed);
    job
}

/// Statements from line 3 on. In frame 1, P[1] is its origin and P[2] lies at (10, 5, 0) mm: in the
/// robot's frame at (1000, 0, 0) and (995, 10, 0). The tool points down, its x axis is the frame's.
fn tp_with(statements: &str, job: &Settings) -> Read {
    let point = |number: u32, x: f64, y: f64| {
        format!(
            "P[{number}]{{\n GP1:\n UF : 1, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n X = {x} mm, Y = \
             {y} mm, Z = 0 mm, W = 180 deg, P = 0 deg, R = 0 deg\n}};\n"
        )
    };
    let points = [point(1, 0.0, 0.0), point(2, 10.0, 5.0)].concat();
    let text = format!("/PROG A\n/MN\n{statements}/POS\n{points}/END\n");
    read(text.as_bytes(), Dialect::Fanuc, job)
}

fn tp(statements: &str) -> Read {
    tp_with(statements, &job(&[]))
}

fn krl(body: &str) -> Read {
    let text = format!("DEF a()\n$VEL.CP=0.1\n{body}\nEND\n");
    read(text.as_bytes(), Dialect::Krl, &settings())
}

fn told(found: &Read, code: Code) -> Vec<usize> {
    let found = found.as_ref().unwrap_or_else(|found| panic!("{found:?}"));
    found.warnings.iter().filter(|note| note.code == code).map(at).collect()
}

#[track_caller]
fn assert_refused(found: &Read, line: usize, said: &str) {
    let Err(found) = found else { panic!("the program is wrong: {found:?}") };
    assert_eq!((at(&found[0]), found.len()), (line, 1), "{found:?}");
    assert!(found[0].what.contains(said), "{said}: {found:?}");
}

const START: &str = "J P[1] 20% FINE ;\n";
const CUT: &str = "L P[2] 9mm/sec FINE ;\n";
const HOME: &str = "J PR[1:HOME] 100% FINE ;\n";

/// As `PTP XHOME` of KRL: a way that the rest of the path does not need is skipped.
#[test]
fn tp_goes_to_a_register_that_the_controller_alone_knows() {
    let out = HOME.replace("1:HOME", "2");
    let whole = tp(&format!("{HOME}{START}{CUT}{out}"));
    assert_eq!(told(&whole, Code::LeftOut), [3, 6]);
    assert_eq!(told(&whole, Code::MotionLeftOut), NONE);
    let whole = whole.unwrap();
    assert_ends(&whole, &[('T', [1000.0, 0.0, 0.0]), ('L', [995.0, 10.0, 0.0])]);
    assert!(whole.warnings[0].what.contains("J PR[1]: the place is not in the program"));
    // A cut from there is no part of the path, and neither is an arc from anywhere.
    assert_eq!(told(&tp(&format!("{HOME}{CUT}{START}")), Code::MotionLeftOut), [4]);
    assert_eq!(told(&tp(&format!("{CUT}{START}")), Code::MotionLeftOut), NONE);
    let arc = "C P[1] P[2] 9mm/sec FINE ;\n";
    assert_eq!(told(&tp(&format!("{arc}{START}")), Code::MotionLeftOut), [3]);
    assert_eq!(told(&tp(&format!("{START}{arc}")), Code::MotionLeftOut), NONE);
    // Between moves the arm is taken to go straight in the joints to the next place.
    let between = tp(&format!("{START}{CUT}{HOME}{START}"));
    assert_eq!(told(&between, Code::MotionLeftOut), [5]);
    assert_eq!(between.unwrap().moves.len(), 3);
    assert_refused(&tp(&format!("{START}{HOME}{CUT}")), 4, "motion at feed follows from there");
    // A line at feed to there may cut.
    let line = "L PR[R[1]:out] 9mm/sec FINE ;\n";
    let set = "R[1]=7 ;\n";
    let last = tp(&format!("{set}{START}{CUT}{line}{HOME}"));
    assert_eq!((told(&last, Code::MotionLeftOut), told(&last, Code::LeftOut)), (vec![6], vec![7]));
    let first = tp(&format!("{set}{line}{START}{CUT}"));
    assert_eq!(told(&first, Code::MotionLeftOut), [4]);
    assert_eq!(first.unwrap().moves.len(), 2);
    let within = tp(&format!("{set}{START}{line}{START}"));
    assert_refused(&within, 5, "PR[7] is known only at run time");
    // What the program sets in part, or to what the run knows, is no place of the controller's.
    assert_refused(&tp(&format!("PR[1,3]=5 ;\n{START}{HOME}")), 5, "does not set its element 1");
    assert_refused(&tp(&format!("PR[1]=PR[2] ;\n{HOME}{START}")), 4, "PR[1] is known only at run");
    assert_refused(&tp("C PR[1]\n: PR[2] 9mm/sec FINE ;\n"), 3, "PR[1] is known only at run time");
    let none = tp(&format!("{HOME}{line}").replace("R[R[1]:out]", "R[2]"));
    assert_refused(&none, 3, "no motion that is read: it moves to PR[1], PR[2], which it does not");
    assert!(none.unwrap_err()[0].what.contains("{\"PR[1,1]\": …, …, \"PR[1,6]\": …}"));
    // What stands behind the move is done, and its options are read.
    let beside = HOME.replace("FINE", "FINE TA .50sec,CALL FOO");
    assert_eq!(told(&tp(&format!("{beside}{START}")), Code::MotionLeftOut), [3]);
    let hop = tp(&format!("{}{START}", HOME.replace("FINE", "FINE HOP")));
    assert_refused(&hop, 3, "'HOP' behind the target");
}

#[test]
fn dashes_end_what_runs_beside_a_move_of_tp() {
    let text = "J P[1] 100% CNT100 TB   0.00sec,P-SPS    ;\n   1:  TC_ONLINE (DI[76]) ;\n   \
                2:  F[4]=(ON) ;\n           ------ ;\n  4:  ---- ;\nL P[2] 9mm/sec FINE ;\n";
    assert_eq!(tp(text).unwrap().moves.len(), 2);
    // With text they are a remark.
    assert_eq!(tp(&format!("{START}--- P ;\n")).unwrap().moves, tp(START).unwrap().moves);
}

#[test]
fn what_the_job_assumes_of_inputs_of_tp_counts_in_expressions() {
    let number = Assumed::Number;
    let known = job(&[("gi[6]", number(250.0)), ("ai[2]", number(3.0))]);
    // 250 / 10 = 25 mm/s; 2·3 − 1 = 5 mm up.
    let text = "R[2]=GI[6:speed]/10 ;\nPR[1]=P[1] ;\nPR[1,3]=2*AI[2]-1 ;\nJ P[2] 20% FINE ;\n\
                L PR[1] R[2]mm/sec FINE ;\n";
    let found = tp_with(text, &known).unwrap();
    assert_ends(&found, &[('T', [995.0, 10.0, 0.0]), ('L', [1000.0, 0.0, 5.0])]);
    assert!((found.moves[1].feed_m_per_s - 0.025).abs() < 1e-12);
    assert_refused(&tp(text), 7, "assume: {\"AI[2]\": …}");

    let branch = |job: &Settings| {
        tp_with(&format!("{START}IF (!DI[113:part] OR F[1]) THEN\n;\n{CUT}ENDIF ;\n"), job)
    };
    let truth = Assumed::Truth;
    let moves = |job: &Settings| branch(job).unwrap().moves.len();
    assert_eq!(moves(&job(&[("di[113]", truth(false))])), 2);
    let both = [("di[113]", truth(true)), ("f[1]", truth(false))];
    assert_eq!(moves(&job(&both)), 1);
    let open = branch(&job(&both[..1])).unwrap_err();
    assert!(open[0].what.contains("assume: {\"F[1]\": …} in the job"), "{open:?}");
    let open = branch(&job(&[])).unwrap_err();
    assert!(open[0].what.contains("assume: {\"DI[113]\": …, \"F[1]\": …} in the job"), "{open:?}");
}

/// 7 mm along the frame's x axis is the robot's y axis; along the tool's z axis it is down.
#[test]
fn an_offset_condition_of_tp_shifts_what_names_no_register() {
    let zero = job(&[("pr[5]", Assumed::Number(0.0)), ("pr[6]", Assumed::Number(0.0))]);
    let shifted = |text: &str| tp_with(&format!("PR[5,1]=7 ;\nPR[6,3]=7 ;\n{START}{text}"), &zero);
    let both = "OFFSET CONDITION PR[5:by]    ;\nTOOL_OFFSET CONDITION PR[6] ;\n";
    let text = format!(
        "{both}L P[2] 9mm/sec FINE Offset    ;\n{CUT}L P[2] 9mm/sec FINE Tool_Offset ;\n\
         L P[2] 9mm/sec CNT50 Offset ACC80 Tool_Offset ;\n"
    );
    assert_ends(
        &shifted(&text).unwrap(),
        &[
            ('T', [1000.0, 0.0, 0.0]),
            ('L', [995.0, 17.0, 0.0]),
            ('L', [995.0, 10.0, 0.0]),
            ('L', [995.0, 10.0, -7.0]),
            ('L', [995.0, 17.0, -7.0]),
        ],
    );
    let offset = "L P[2] 9mm/sec FINE Offset ;\n";
    assert_refused(&shifted(offset), 6, "behind no OFFSET CONDITION");
    let other = shifted(&format!("TOOL_OFFSET CONDITION PR[6] ;\n{offset}"));
    assert_refused(&other, 7, "behind no OFFSET CONDITION");
    let changed = shifted(&format!("{both}PR[5,1]=8 ;\n{offset}"));
    assert_refused(&changed, 9, "PR[5] has changed since OFFSET CONDITION");
    for text in ["OFFSET CONDITION PR[5],UTOOL[1]", "OFFSET CONDITION PR[5],UFRAME[1],2"] {
        let said = "expected OFFSET CONDITION PR[n] or OFFSET CONDITION PR[n],UFRAME[m]";
        assert_refused(&shifted(&format!("{text} ;\n")), 6, said);
    }
    let unknown = tp(&format!("OFFSET CONDITION PR[5] ;\n{START}{offset}"));
    assert_refused(&unknown, 5, "assume: {\"PR[5]\": 0}");
}

/// 7 mm along x of frame 1 are along y of the robot, and along x of frame 0 are along x. Tool 2 is turned by 90° about
/// z: its x axis is y of tool 1, which points down with its y axis against that of the frame, along x of the robot.
#[test]
fn an_offset_condition_of_tp_may_name_its_frame_or_tool() {
    let mut job = job(&[("pr[5]", Assumed::Number(0.0))]);
    let shifted = |condition: &str, job: &Settings| {
        let own = if condition.starts_with('T') { "Tool_Offset" } else { "Offset" };
        let text = format!("{condition} ;\n{START}L P[2] 9mm/sec FINE {own} ;\n");
        tp_with(&format!("PR[5,1]=7 ;\n{text}"), job)
    };
    let ends = |condition: &str, job: &Settings, at_mm: [f64; 3]| {
        let expected = [('T', [1000.0, 0.0, 0.0]), ('L', at_mm)];
        assert_ends(&shifted(condition, job).unwrap(), &expected);
    };
    ends("OFFSET CONDITION PR[5],UFRAME[1]", &job, [995.0, 17.0, 0.0]);
    ends("OFFSET CONDITION PR[5:by],UFRAME[0:base]", &job, [1002.0, 10.0, 0.0]);
    ends("TOOL_OFFSET CONDITION PR[5],UTOOL[1]", &job, [995.0, 17.0, 0.0]);
    for (condition, key) in [
        ("OFFSET CONDITION PR[5],UFRAME[2]", "path.program.base_frames: {2: …}"),
        ("TOOL_OFFSET CONDITION PR[5],UTOOL[2]", "path.program.tool_frames: {2: …}"),
    ] {
        assert_refused(&shifted(condition, &job), 6, key);
    }
    let half = std::f64::consts::FRAC_1_SQRT_2;
    job.base_frames.insert(2, pose([0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]));
    job.tool_frames.insert(2, pose([0.0, 0.0, 250.0], [half, 0.0, 0.0, half]));
    ends("OFFSET CONDITION PR[5],UFRAME[2]", &job, [1002.0, 10.0, 0.0]);
    ends("TOOL_OFFSET CONDITION PR[5],UTOOL[2]", &job, [1002.0, 10.0, 0.0]);
    // A frame that is set anew may be the old one there, or the new one.
    let set = "PR[7]=UFRAME[1] ;\nOFFSET CONDITION PR[5],UFRAME[2] ;\nUFRAME[2]=PR[7] ;\n";
    let found = tp_with(&format!("{set}{START}L P[2] 9mm/sec FINE Offset ;\n"), &job);
    assert_refused(&found, 7, "behind no OFFSET CONDITION");
}

#[test]
fn a_limit_of_speed_of_tp_is_a_doubt_where_a_move_is_faster() {
    let limited = |limit: &str| told(&tp(&format!("{limit} ;\n{START}{CUT}")), Code::ChangeIgnored);
    assert_eq!(limited("LINEAR_MAX_SPEED=2000"), NONE);
    assert_eq!(limited("LINEAR_MAX_SPEED = 9"), NONE);
    assert_eq!(limited("LINEAR_MAX_SPEED=8.9"), [5]);
    assert_eq!(limited("LINEAR_MAX_SPEED=R[9]"), [5]);
    assert_eq!(limited("JOINT_MAX_SPEED[5]=200"), [5]);
    // 9 mm/s at half the speed.
    assert_eq!(limited("OVERRIDE=50% ;\nLINEAR_MAX_SPEED=4.5"), NONE);
    // The way alone says how fast a move of so many seconds is.
    let timed = tp(&format!("LINEAR_MAX_SPEED=2000 ;\n{START}L P[2] 2sec FINE ;\n"));
    assert_eq!(told(&timed, Code::ChangeIgnored), [5]);
    assert_eq!(timed.unwrap().moves[1].timing, Timing::Seconds(2.0));
}

const AT: &str = "PTP {X 0,Y 0,Z 100,A 90,B 0,C 180}";

#[test]
fn the_home_of_krl_needs_nothing_of_what_stands_behind_with() {
    let home = "SPTP XHOME WITH $VEL_AXIS[1]=SVEL_JOINT(10.0), $TOOL=STOOL2(FHOME), \
                $BASE=SBASE(FHOME.BASE_NO), $IPO_MODE=SIPO_MODE(FHOME.IPO_FRAME), \
                $LOAD=SLOAD(FHOME.TOOL_NO), $ACC_AXIS[1]=SACC_JOINT(PDEFAULT), \
                $APO=SAPO_PTP(PDEFAULT)";
    let out = home.replace("XHOME", "XHOME1");
    let found = krl(&format!("{home}\n{AT}\nLIN {{X 9}}\n{out}"));
    assert_eq!(
        (told(&found, Code::LeftOut), told(&found, Code::MotionLeftOut)),
        (vec![3, 6], vec![])
    );
    let found = found.unwrap();
    assert_ends(&found, &[('T', [0.0, 0.0, 100.0]), ('L', [9.0, 0.0, 100.0])]);
    assert_eq!(found.moves[0].timing, Timing::Rapid);
    // Where it moves, what stands behind WITH counts.
    let known = home.replace("XHOME", "{X 1}");
    assert!(krl(&format!("{AT}\n{known}")).is_err());
}

#[test]
fn a_blank_in_a_binary_number_of_krl_says_nothing() {
    let with = |s: &str, t: &str| {
        let found = krl(&format!("PTP {{X 0,Y 0,Z 100,A 0,B 0,C 180,S {s},T {t}}}")).unwrap();
        found.moves[0].stated.configuration.as_ref().map(|own| own.shown.clone())
    };
    assert_eq!(with("'B 110'", "'B 1'").as_deref(), Some("S 6, T 1"));
    assert_eq!(with("'B 110'", "'B 1'"), with("'B110'", "'B1'"));
    assert!(krl("PTP {X 0,Y 0,Z 100,A 0,B 0,C 180,S 'B 1 0',T 'B1'}").is_err());
}

/// With A 90 and C 180 the tool's x axis is y, its y axis x, and its z axis −z.
#[test]
fn relative_motion_of_krl_counts_in_the_tool_or_in_the_base() {
    let moved = |relative: &str| krl(&format!("{AT}\n{relative}"));
    for (relative, expected) in [
        ("LIN_REL {X 10,Y 20,Z -30} #TOOL", [20.0, 10.0, 130.0]),
        ("LIN_REL {X 10,Y 20,Z -30} #BASE", [10.0, 20.0, 70.0]),
        ("SLIN_REL {X 10} #TOOL", [0.0, 10.0, 100.0]),
        ("LIN_REL {X 10,E1 0} C_DIS #TOOL", [0.0, 10.0, 100.0]),
    ] {
        let found = moved(relative).unwrap_or_else(|found| panic!("{relative}: {found:?}"));
        assert_ends(&found, &[('T', [0.0, 0.0, 100.0]), ('L', expected)]);
    }
    // A quarter turn about the tool's z axis: its x axis goes to where its y axis was.
    let turned = moved("LIN_REL {A 90} #TOOL").unwrap();
    let x = end(&turned.moves[1]).1.rotation * Vector3::x();
    assert!((x - Vector3::x()).norm() < 1e-9, "{x}");
    assert_refused(&moved("LIN_REL {A 9,C 9} #TOOL"), 4, "two of A, B and C");
    assert_refused(&moved("PTP_REL {X 9} #TOOL"), 4, "(#TOOL) is not supported");
    assert_refused(&moved("LIN_REL {E1 5} #BASE"), 4, "E1 of a relative motion");
    let joints = "PTP {A1 0,A2 0,A3 0,A4 0,A5 9,A6 0}\nLIN_REL {X 9} #TOOL";
    assert_refused(&krl(joints), 4, "not known as a pose");
}

/// A tool of the cell is 150 mm long by the job.
#[test]
fn crobt_of_rapid_takes_the_job_for_tools_that_no_file_declares() {
    let mut job = settings();
    let text = module(
        "MoveJ p,v200,fine,tGrip;\nMoveL Offs(CRobT(\\Tool:=tGrip \\WObj:=wobj0),0,0,50),v100,fine,\
         tGrip;",
    );
    let found = read(text.as_bytes(), Dialect::Rapid, &job).unwrap_err();
    assert!(found.iter().all(|note| note.what.contains("give the tcp in the job")), "{found:?}");
    job.tcp = Some(pose([0.0, 0.0, 150.0], [1.0, 0.0, 0.0, 0.0]));
    let found = read(text.as_bytes(), Dialect::Rapid, &job);
    assert_eq!(told(&found, Code::Assumed), [4]);
    assert_ends(&found.unwrap(), &[('T', [100.0, 200.0, 300.0]), ('L', [100.0, 200.0, 350.0])]);
    // Of another tool the place is another: tool0 ends 100 mm above the tip of the first.
    let text = "MODULE m\nCONST tooldata t1:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,\
                0]];\nPROC main()\nMoveJ [[0,0,500],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],\
                v5,fine,t1;\nMoveL CRobT(\\Tool:=tool0),v5,fine,tool0;\nENDPROC\nENDMODULE\n";
    let found = read(text.as_bytes(), Dialect::Rapid, &settings()).unwrap();
    assert_ends(&found, &[('T', [0.0, 0.0, 500.0]), ('L', [0.0, 0.0, 400.0])]);
}

fn rapid(instructions: &str) -> Read {
    read(module(instructions).as_bytes(), Dialect::Rapid, &settings())
}

#[test]
fn rapid_says_what_settles_a_signal_and_who_moves() {
    const MOVE: &str = "MoveL p,v5,fine,tool0;";
    for (asked, hint) in [
        ("DOutput(doX)=1", "assume: {\"doX\": …}"),
        ("GInputDnum(giProg)=3", "assume: {\"giProg\": …}"),
    ] {
        let text = format!("{MOVE}\nIF {asked} {MOVE}");
        let found = rapid(&text).unwrap_err();
        assert_eq!((at(&found[0]), found.len()), (5, 1), "{found:?}");
        assert_eq!(found[0].what.matches("assume:").count(), 1, "{found:?}");
        assert!(found[0].what.contains(hint), "{found:?}");
        let mut job = settings();
        let name = hint.split('"').nth(1).unwrap().to_lowercase();
        job.assume.insert(name, Assumed::Number(1.0));
        assert!(read(module(&text).as_bytes(), Dialect::Rapid, &job).is_ok());
    }
    // What the program sets, to what only the run knows, the job cannot say.
    let set = rapid(&format!("{MOVE}\nSetDO doX,DInput(di1);\nIF DOutput(doX)=1 {MOVE}"));
    assert!(!set.unwrap_err()[0].what.contains("doX\": …"));

    let paths = "PROC Path_10()\nPath_20;\nENDPROC\nPROC Path_20()\nMoveL p,v5,fine,tool0;\nENDPROC\n\
                 PROC Wait()\nWaitTime 1;\nENDPROC\n";
    let text = module("WaitTime 1;").replace("ENDMODULE", &format!("{paths}ENDMODULE"));
    let found = read(text.as_bytes(), Dialect::Rapid, &settings());
    assert_refused(&found, 3, "these procedures do: 'Path_10', 'Path_20'");
    assert_refused(&found, 3, "path.program.procedure: Path_10");
    // What is in no file may be what moves.
    let calls = text.replace("WaitTime 1;\nENDPROC\nPROC Path", "Cut;\nENDPROC\nPROC Path");
    assert_ne!(calls, text);
    let found = read(calls.as_bytes(), Dialect::Rapid, &settings());
    assert_refused(&found, 4, "'Cut' is not in this file");
    let job = Settings { procedure: Some("Path_10".to_owned()), ..settings() };
    assert_eq!(read(text.as_bytes(), Dialect::Rapid, &job).unwrap().moves.len(), 1);
}

#[test]
fn what_rapid_reads_commands_no_spindle() {
    let doubts = |instruction: &str| {
        told(&rapid(&format!("MoveL p,v5,fine,tool0;\n{instruction}")), Code::SpindleCommand)
    };
    for instruction in [
        "WaitDI diSpindleAtSpeed,1\\MaxTime:=10;",
        "WaitGI giSpindle,3;",
        "WaitUntil diSpindleReady;",
        "ISignalDI diSpindleFault,1,intno1;",
        "SetDO doReady,DInput(diSpindleReady);",
    ] {
        assert_eq!(doubts(instruction), NONE, "{instruction}");
    }
    for instruction in [
        "SetDO doSpindleOn,1;",
        "SetDO doSpindleOn,DInput(di1);",
        "SetAO ao1,AInput(aiSpindleRpm);",
        "PulseDO doSpindle;",
    ] {
        assert_eq!(doubts(instruction), [5], "{instruction}");
    }
}

/// RoboDK calls the tool as its users do, and the signal, too.
#[test]
fn a_tool_of_rapid_is_no_signal() {
    let text = |instructions: &str| {
        format!(
            "MODULE m\nPERS tooldata Spindle:=[TRUE,[[0,0,200],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,\
             0,0]];\nCONST robtarget p:=[[100,200,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,\
             9E9]];\nPROC main()\n{instructions}\nENDPROC\nENDMODULE\n"
        )
    };
    let mut job = settings();
    let what = Setter::Signal("SPINDLE".to_owned());
    job.spindle_from = Some(SetBy { what, per_unit: 1.0 });
    let of = |instructions: &str, job: &Settings| {
        read(text(instructions).as_bytes(), Dialect::Rapid, job)
    };
    let found = of("SetAO SPINDLE,12000;\nMoveL p,v5,fine,Spindle;", &job);
    assert_eq!(told(&found, Code::SpindleCommand), NONE);
    assert_eq!(found.unwrap().spindle[0].spindle, Spindle::Turns(Some(12_000.0)));
    // A second time on the line it is the signal.
    let found = of("MoveL p,v5,fine,Spindle;\nMoveLAO p,v5,fine,Spindle,Spindle,900;", &job);
    assert_eq!(told(&found, Code::SpindleCommand), [6]);
    // One that is given to a procedure of another file.
    let found = of("MoveL p,v5,fine,Spindle;\nCheckTool Spindle;", &settings());
    assert_eq!(told(&found, Code::SpindleCommand), NONE);
}

#[test]
fn what_a_search_of_rapid_finds_is_no_wrong_target() {
    let text = "MODULE m\nVAR robtarget pFound;\nCONST robtarget p:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,\
                9E9,9E9,9E9,9E9,9E9]];\nPROC main()\nMoveJ p,v5,fine,tool0;\nSearchL\\Stop,di1,pFound,\
                p,v20,tool0;\nMoveL Offs(pFound,0,0,9),v20,fine,tool0;\nENDPROC\nENDMODULE\n";
    let found = read(text.as_bytes(), Dialect::Rapid, &settings()).unwrap_err();
    let said: Vec<(usize, bool)> =
        found.iter().map(|note| (at(note), note.what.contains("quaternion"))).collect();
    assert_eq!(said, [(6, false), (7, false)], "{found:?}");
    assert!(found[0].what.contains("'SearchL' moves"), "{found:?}");
    assert!(found[1].what.contains("'pFound' is what SearchL finds"), "{found:?}");
}

#[test]
fn statements_of_apt_that_shift_nothing() {
    let apt = |head: &str| {
        let text =
            format!("UNITS/MM\n{head}\nRAPID\nGOTO/0,0,10\nFEDRAT/300,MMPM\nGOTO/30,0,0\nFINI\n");
        read(text.as_bytes(), Dialect::Apt, &settings())
    };
    for head in [
        "MCS/1,0,0,$\n0,1,0,$\n0,0,1,$\n0,0,0",
        "ORIGIN/0,0,0",
        "TRANS/0,0,0.0",
        "DISPLY/ON",
        // The first system is the job's work object, wherever it stands.
        "MCS/0,1,0,-1,0,0,0,0,1,50,60,70",
    ] {
        let found = apt(head).unwrap_or_else(|found| panic!("{head}: {found:?}"));
        assert_ends(&found, &[('L', [0.0, 0.0, 10.0]), ('L', [30.0, 0.0, 0.0])]);
        assert!(found.warnings.iter().all(|note| note.code == Code::Assumed), "{found:?}");
    }
    for (head, said) in [
        ("ORIGIN/0,0,5", "moves or shifts motion"),
        ("ORIGIN/0,0,0,5", "moves or shifts motion"),
        ("TRANS/1,0,0", "moves or shifts motion"),
        ("MCS/1,0,0,0,1,0,0,0,2,0,0,0", "unit vectors"),
        ("RETRCT", "is not understood"),
        ("SET/HOLDER,0", "is not understood"),
    ] {
        assert_refused(&apt(head), 2, said);
    }
    // A second one says no more than a second CSYS.
    let second = "MCS/1,0,0,0,1,0,0,0,1,0,0,0\nRAPID\nGOTO/0,0,9\nMCS/1,0,0,0,1,0,0,0,1,0,0,5";
    assert_refused(&apt(second), 5, "another coordinate system");
}
