//! Fanuc TP: what others set, programs in no file and whoever a WAIT waits for; branches that only
//! the run decides; inputs by the number of a register; errors that follow from others.

use detune::motion::Timing;
use detune::notes::{Code, Note};
use detune::program::{Assumed, Dialect, Program, SetBy, Setter, Settings, Spindle, read};

use super::support::{at, pose, settings};

type Read = Result<Program, Vec<Note>>;

const NONE: [usize; 0] = [];

const MOVE: &str = "L P[2] 9mm/sec FINE ;\n";

/// Four corners, from P[1] on; statements from line 6 on.
fn whole(statements: &str, job: &Settings) -> Read {
    let corners = [(1, 0.0, 0.0), (2, 100.0, 0.0), (3, 100.0, 100.0), (4, 0.0, 100.0)];
    let points = corners.map(|(number, x, y)| {
        format!(
            "P[{number}]{{\n GP1:\n UF : 1, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n X = {x} mm, Y = \
             {y} mm, Z = 0 mm, W = 180 deg, P = 0 deg, R = 0 deg\n}};\n"
        )
    });
    let text = format!(
        "/PROG T\n/MN\nUFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nL P[1] 100mm/sec FINE ;\n{statements}/POS\n\
         {}/END\n",
        points.concat()
    );
    read(text.as_bytes(), Dialect::Fanuc, job)
}

/// Without the first move.
fn with(statements: &str, job: &Settings) -> Read {
    let mut found = whole(statements, job)?;
    found.moves.remove(0);
    Ok(found)
}

fn job(assumed: &[(&str, Assumed)]) -> Settings {
    let mut job = settings();
    let upright = [1.0, 0.0, 0.0, 0.0];
    job.base_frames.insert(1, pose([1000.0, 0.0, 0.0], upright));
    job.tool_frames.insert(1, pose([0.0, 0.0, 150.0], upright));
    job.assume.extend(assumed.iter().map(|(name, value)| ((*name).to_owned(), *value)));
    job
}

fn tp(statements: &str) -> Read {
    with(statements, &job(&[]))
}

#[track_caller]
fn moves(found: &Read) -> usize {
    found.as_ref().unwrap_or_else(|found| panic!("{found:?}")).moves.len()
}

#[track_caller]
fn assert_refused(found: &Read, line: usize, said: &[&str]) {
    let found = found.as_ref().expect_err("the program is wrong");
    assert_eq!((at(&found[0]), found.len()), (line, 1), "{found:?}");
    assert!(said.iter().all(|said| found[0].what.contains(said)), "{said:?}: {found:?}");
}

#[track_caller]
fn told(found: &Read, code: Code) -> Vec<usize> {
    let found = found.as_ref().unwrap_or_else(|found| panic!("{found:?}"));
    found.warnings.iter().filter(|note| note.code == code).map(at).collect()
}

/// A move that is made unless a condition holds.
fn unless(condition: &str) -> String {
    format!("IF {condition},JMP LBL[1] ;\n{MOVE}LBL[1] ;\n")
}

#[test]
fn a_register_that_a_wait_waits_for_is_set_by_another() {
    for (wait, asked, value) in [
        ("WAIT R[1]>0", "R[1]=2", 2.0),
        ("WAIT (R[1:a b]<>0)", "R[1]=2", 2.0),
        ("WAIT R[1]=R[2]", "R[1]=7", 2.0),
        ("WAIT R[R[3]]>0", "R[1]=2", 2.0),
        ("WAIT R[1]=1 OR DI[2]=ON", "R[1]=1", 2.0),
        ("WAIT R[1]=1,TIMEOUT,LBL[1]", "R[1]=1", 1.0),
    ] {
        let text = format!("R[1]=0 ;\nR[2]=7 ;\nR[3]=1 ;\n{wait} ;\n{}", unless(asked));
        let why = "R[1] is known only at run time: another may set it while WAIT of line 9 waits";
        assert_refused(&tp(&text), 10, &[why, "assume: {\"R[1]\": …}"]);
        // What the job gives settles it.
        let given = with(&text, &job(&[("r[1]", Assumed::Number(value))]));
        assert!(given.is_ok(), "{wait}: {given:?}");
    }
    // But not where the program waits for the end of it.
    let text = format!("WAIT R[1]>0 ;\n{}", unless("R[1]=2"));
    let found = with(&text, &job(&[("r[1]", Assumed::Number(0.0))]));
    assert_refused(&found, 7, &["R[1] is known only at run time: another may set it"]);
    // Equal to a number it is that number.
    for wait in ["WAIT R[1]=1", "WAIT (R[1:part]=1)", "WAIT (R[R[3]]=(1))"] {
        let of = |asked: &str| tp(&format!("R[1]=0 ;\nR[3]=1 ;\n{wait} ;\n{}", unless(asked)));
        assert_eq!((moves(&of("R[1]=1")), moves(&of("R[1]=0"))), (0, 1), "{wait}");
    }
    // What it is already the program does not wait for.
    assert_eq!(moves(&tp(&format!("R[1]=3 ;\nWAIT R[1]>2 ;\n{}", unless("R[1]=3")))), 0);
    // Speeds and numbers of positions likewise.
    let awaited = "R[1]=2 ;\nWAIT R[1]<>2 ;\n";
    assert_refused(&tp(&format!("{awaited}L P[R[1]] 9mm/sec FINE ;\n")), 8, &["while WAIT"]);
    assert_eq!(moves(&tp(&format!("{awaited}R[1]=3 ;\nL P[R[1]] 9mm/sec FINE ;\n"))), 1);
}

#[test]
fn an_element_that_a_wait_waits_for_is_set_by_another() {
    let text = "PR[1]=P[2] ;\nWAIT (PR[1,1]>200) ;\nL PR[1] 9mm/sec FINE ;\n";
    let said = ["PR[1] is known only at run time", "while WAIT of line 7 waits", "\"PR[1,1]\": …"];
    assert_refused(&tp(text), 8, &said);
    assert_eq!(moves(&with(text, &job(&[("pr[1,1]", Assumed::Number(250.0))]))), 1);
    assert_eq!(moves(&tp(&text.replace(">200", ">20"))), 1);
    // The job's word is of before, where the program waits for its end.
    let text = "PR[1,2]=5 ;\nWAIT PR[1,1]>200 ;\nR[1]=PR[1,1] ;\nL P[R[1]] 9mm/sec FINE ;\n";
    let found = with(text, &job(&[("pr[1,1]", Assumed::Number(2.0))]));
    assert_refused(&found, 9, &["R[1] is set to what is known only at run time"]);
}

/// An input keeps what the job says of it, unless the program waits for the end of that.
#[test]
fn an_input_behind_a_wait_for_it() {
    let text = format!("WAIT DI[1:part]=ON ;\n{}", unless("DI[1]=ON"));
    assert_refused(&tp(&text), 7, &["DI[1] is known only at run time; assume: {\"DI[1]\": …}"]);
    let of = |value| with(&text, &job(&[("di[1]", Assumed::Truth(value))]));
    assert_eq!(moves(&of(true)), 0);
    assert_refused(&of(false), 7, &["DI[1] is known only at run time: another may set it while"]);
}

/// What it has set counts as the program has left it, which is a doubt, unless the job says what it is.
#[test]
fn a_program_in_no_file_may_set_what_the_program_has_set() {
    for call in ["CALL READ", "RUN READ", "CALL READ(1)", "L P[1] 9mm/sec FINE TB .10sec,CALL READ"]
    {
        let left = usize::from(call.starts_with('L'));
        let [one, on] = [Assumed::Number(1.0), Assumed::Truth(true)];
        for (set, name, asked, given) in [
            ("R[1]=0", "R[1]", "R[1]=1", one),
            ("DO[1]=OFF", "DO[1]", "DO[1]=ON", on),
            ("F[2]=(OFF)", "F[2]", "F[2]=ON", on),
        ] {
            let text = format!("{set} ;\n{call} ;\n{}", unless(asked));
            let found = tp(&text);
            assert_eq!((moves(&found), told(&found, Code::ChangeIgnored)), (left + 1, vec![7]));
            let what = &found.unwrap().warnings;
            assert!(what.iter().any(|note| note.what.contains(&format!("may set {name},"))));
            let lower = name.to_lowercase();
            let settled = with(&text, &job(&[(lower.as_str(), given)]));
            assert_eq!((moves(&settled), told(&settled, Code::ChangeIgnored)), (left, vec![]));
        }
    }
    let many = "R[1]=1 ;\nR[2]=2 ;\nR[3]=3 ;\nPR[1]=P[1] ;\nPR[2]=P[1] ;\nCALL READ ;\n";
    let warnings = tp(&format!("{many}{MOVE}")).unwrap().warnings;
    assert!(warnings.iter().any(|note| note.what.contains("PR[1], PR[2], R[1], R[2] and 1 more")));
}

#[test]
fn a_position_register_behind_a_call() {
    let text = "PR[1]=P[2] ;\nCALL VISION ;\nL PR[1] 9mm/sec FINE ;\n";
    let found = tp(text);
    assert_eq!((moves(&found), told(&found, Code::ChangeIgnored)[0]), (1, 7));
    let given = ["pr[1,1]", "pr[1,2]", "pr[1,3]", "pr[1,4]", "pr[1,5]", "pr[1,6]"];
    let given = given.map(|name| (name, Assumed::Number(0.0)));
    assert_eq!(moves(&with(text, &job(&given))), 1);
    // What the job alone says stays.
    let assumed = job(&[("pr[1]", Assumed::Number(0.0)), ("pr[1,3]", Assumed::Number(70.0))]);
    let only = "CALL GRIP ;\nL P[2] 9mm/sec FINE Offset,PR[1] ;\n";
    assert_eq!(moves(&with(only, &assumed)), 1);
    // Unless the program has changed it.
    let raised = format!("PR[1,3]=PR[1,3]+10 ;\n{only}");
    let found = with(&raised, &assumed);
    assert_eq!((moves(&found), told(&found, Code::ChangeIgnored)), (1, vec![7]));
}

/// A start that the program counts on from is not what the register holds behind a call.
#[test]
fn a_start_by_the_job_that_the_program_has_changed() {
    let text = format!("R[1]=R[1]+1 ;\nCALL GRIP ;\n{}", unless("R[1]=1"));
    let found = with(&text, &job(&[("r[1]", Assumed::Number(0.0))]));
    assert_eq!((moves(&found), told(&found, Code::ChangeIgnored)), (0, vec![7]));
    let unchanged = format!("R[2]=R[1]+1 ;\nCALL GRIP ;\n{}", unless("R[1]=1"));
    assert_eq!(moves(&with(&unchanged, &job(&[("r[1]", Assumed::Number(0.0))]))), 1);
}

#[test]
fn a_frame_that_the_program_has_set_behind_a_call() {
    let set = "PR[9]=P[2] ;\nUFRAME[1]=PR[9] ;\n";
    let behind = tp(&format!("{set}CALL FRAMES ;\n{MOVE}"));
    assert_eq!((moves(&behind), told(&behind, Code::ChangeIgnored)), (1, vec![8]));
    let before = tp(&format!("CALL FRAMES ;\n{set}{MOVE}"));
    assert_eq!((moves(&before), told(&before, Code::ChangeIgnored)), (1, vec![]));
    // Which is chosen, a position with its own tells.
    let chosen = |between: &str| {
        let text = format!("CALL FRAMES ;\n{between}PR[1]=P[2] ;\nL PR[1] 9mm/sec FINE ;\n");
        told(&tp(&text), Code::ChangeIgnored)
    };
    assert_eq!(chosen(""), [8, 8]);
    assert_eq!(chosen("UFRAME_NUM=1 ;\n"), [9]);
    assert_eq!(chosen(MOVE), NONE);
    // It is the number of the position even where the program has chosen another before the call.
    let other = "UFRAME_NUM=2 ;\nUTOOL_NUM=2 ;\n";
    let behind = "PR[1]=P[2] ;\nL PR[1] 9mm/sec FINE ;\n";
    let ends = |text: &str| {
        tp(text).map(|found| found.moves.iter().map(|own| own.to.clone()).collect::<Vec<_>>())
    };
    let expected = ends(&format!("{MOVE}{behind}")).unwrap();
    assert_eq!(ends(&format!("{other}CALL FRAMES ;\n{MOVE}{behind}")).unwrap(), expected);
    assert_refused(&tp(&format!("{other}{MOVE}")), 8, &["the controller stops"]);
    assert_refused(&tp(&format!("CALL FRAMES ;\n{other}{MOVE}")), 9, &["the controller stops"]);
}

/// FOR counts on, which is a doubt.
#[test]
fn a_call_in_a_for_loop() {
    let found = tp("FOR R[1]=2 TO 4 ;\nL P[R[1]] 9mm/sec FINE ;\nCALL GRIP ;\nENDFOR ;\n");
    assert_eq!((moves(&found), told(&found, Code::ChangeIgnored)), (3, vec![8]));
    let set = "FOR R[1]=2 TO 4 ;\nIF DI[1]=ON,R[1]=(4) ;\nENDFOR ;\n";
    assert_refused(&tp(set), 8, &["ENDFOR", "R[1] is set to what is known only at run time"]);
}

/// What the job reads the spindle from is no program that sets other things.
#[test]
fn a_call_that_the_job_names_sets_nothing_else() {
    let text = format!("R[1]=0 ;\nCALL SPIN(900) ;\n{}", unless("R[1]=0"));
    let what = Setter::Procedure("SPIN".to_owned(), 1);
    let named = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..job(&[]) };
    assert_eq!(moves(&with(&text, &named)), 0);
}

const OPEN: &str = "IF (DI[7]) THEN ;\nGO[1]=102 ;\nWAIT .25(sec) ;\nWAIT DI[7]=ON ;\nR[2]=1 ;\n\
                    !stop ;\nELSE ;\nIF R[2]=1,PR[3]=P[1] ;\nMESSAGE[x] ;\nENDIF ;\n";

#[test]
fn a_branch_without_motion_is_read_on() {
    let found = tp(&format!("R[2]=0 ;\nR[3]=1 ;\n{OPEN}{}", unless("R[3]=2")));
    assert_eq!((moves(&found), told(&found, Code::MotionLeftOut)), (1, vec![]));
    assert_eq!(told(&found, Code::LeftOut), [10]);
    let stands = found.unwrap().moves.iter().any(|own| matches!(own.timing, Timing::Seconds(_)));
    assert!(!stands);
    // What it may set is known no longer, in either of the branches.
    for (set, asked) in [("R[2]=0", "R[2]=1"), ("GO[1]=0", "GO[1]=102")] {
        let text = format!("{set} ;\n{OPEN}{}", unless(asked));
        assert_refused(&tp(&text), 17, &["is set to what is known only at run time"]);
    }
    let text = format!("PR[3]=P[2] ;\n{OPEN}L PR[3] 9mm/sec FINE ;\n");
    assert_refused(&tp(&text), 17, &["PR[3] is known only at run time", "DI[7]"]);
    // Statements that are jumped over likewise, and the end of the program among them.
    let jump = "IF DI[7]=OFF,JMP LBL[5] ;\nDO[1]=ON ;\nUALM[1] ;\nABORT ;\nLBL[5] ;\n";
    let found = tp(&format!("DO[1]=OFF ;\n{jump}{MOVE}"));
    assert_eq!((moves(&found), told(&found, Code::LeftOut)), (1, vec![10]));
    assert_refused(
        &tp(&format!("DO[1]=OFF ;\n{jump}{}", unless("DO[1]=ON"))),
        12,
        &["DO[1] is set to what is known only at run time"],
    );
}

#[test]
fn a_branch_that_may_decide_about_motion_is_refused() {
    for own in [
        MOVE,
        "CALL GRIP ;\n",
        "RUN GRIP ;\n",
        "JMP LBL[1] ;\n",
        "IF R[1]=1,JMP LBL[1] ;\n",
        "UFRAME_NUM=1 ;\n",
        "OVERRIDE=50% ;\n",
        "PAYLOAD[2] ;\n",
        "UTOOL[1]=PR[1] ;\n",
        "R[R[8]]=1 ;\n",
        "FOR R[1]=1 TO 2 ;\nENDFOR ;\n",
    ] {
        let text = format!("IF (DI[7]) THEN ;\nDO[1]=ON ;\n{own}ENDIF ;\n{MOVE}LBL[1] ;\n");
        for text in [&text, &text.replace("DO[1]=ON ;\n", "ELSE ;\n")] {
            let found = tp(text).expect_err(own);
            assert_eq!(at(&found[0]), 6, "{own}: {found:?}");
            assert!(found[0].what.starts_with("IF decides about motion at run time: DI[7]"));
        }
    }
}

#[test]
fn a_branch_that_sets_the_spindle_leaves_it_open() {
    let branch = "IF (DI[7]) THEN ;\nAO[1]=3000 ;\nENDIF ;\n";
    let by = |what| Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..job(&[]) };
    let signal = by(Setter::Signal("AO[1]".to_owned()));
    let found = with(&format!("AO[1]=900 ;\n{branch}{MOVE}"), &signal);
    assert_eq!(told(&found, Code::SpindleCommand), [8]);
    assert_eq!(found.unwrap().spindle.last().map(|own| own.spindle), Some(Spindle::Turns(None)));
    // Of an output of which the job says nothing two values are told.
    let found = tp(&format!("AO[1]=50 ;\n{branch}{MOVE}"));
    assert_eq!(told(&found, Code::SpindleCommand), [8]);
    let named = branch.replace("AO[1]=3000", "DO[1:Spindle]=ON");
    assert_eq!(told(&tp(&format!("{named}{MOVE}")), Code::SpindleCommand), [7]);
    // A comment that the job reads is not passed over.
    let comment = by(Setter::Comment("SPINDLE".to_owned()));
    let text = branch.replace("AO[1]=3000", "!SPINDLE 3000");
    assert_refused(&with(&format!("{text}{MOVE}"), &comment), 6, &["IF decides about motion"]);
}

#[test]
fn inputs_by_the_number_of_a_register() {
    let branch = |condition: &str| format!("IF ({condition}) THEN ;\n{MOVE}ENDIF ;\n");
    let number = ("r[96]", Assumed::Number(7.0));
    for condition in ["DI[R[96]]", "DI[R[96:part no]:there]", "!DI[R[96]]=OFF", "GI[R[96]]=3"] {
        let text = branch(condition);
        assert_refused(&tp(&text), 6, &["R[96] is known only", "assume: {\"R[96]\": …}"]);
        let own = format!("{}[7]", &condition.trim_start_matches('!')[..2]);
        let hint = format!("assume: {{\"{own}\": …}}");
        assert_refused(&with(&text, &job(&[number])), 6, &[&hint]);
        assert_refused(&tp(&format!("R[96]=7 ;\n{text}")), 7, &[&hint]);
        for (value, expected) in [(3.0, 1), (0.0, 0)] {
            let known = match condition.starts_with('G') {
                true => Assumed::Number(value),
                false => Assumed::Truth(value > 0.0),
            };
            let found = with(&text, &job(&[number, (&*own.to_lowercase(), known)]));
            assert_eq!(moves(&found), expected, "{condition}");
        }
    }
}

#[test]
fn a_share_of_joint_speed_is_for_joint_moves() {
    let said = ["% is a share of joint speed, which J alone takes"];
    for statement in [
        "L P[2] 100% CNT100 ;\n",
        "R[1]=5 ;\nL P[2] R[1]% FINE ;\n",
        "C P[2]\n : P[3] 50% FINE ;\n",
    ] {
        let line = 5 + statement.matches(";\n").count();
        assert_refused(&tp(statement), line, &said);
    }
    assert_eq!(moves(&tp("J P[2] 100% CNT100 ;\n")), 1);
}

#[test]
fn an_offset_of_an_arc_says_why_it_is_not_read() {
    for own in ["Offset", "Tool_Offset"] {
        let set = "PR[1]=P[2]-P[1] ;\n";
        let text = format!("{set}C P[2]\n : P[3] 9mm/sec FINE {own},PR[1] ;\n");
        assert_refused(&tp(&text), 7, &[&format!("whether {own} of C shifts both of its points")]);
    }
}

/// An option behind the first point of an arc is of that point.
#[test]
fn an_offset_of_the_first_point_of_an_arc_is_named() {
    for own in ["Offset,PR[1]", "Tool_Offset,PR[1:out]", "Offset"] {
        let text = format!("C P[2] {own}\n : P[3] 9mm/sec FINE ;\n");
        let said =
            format!("{} of the first point of C is not read", own.split(',').next().unwrap());
        assert_refused(&tp(&text), 6, &[&said]);
    }
}

/// HandlingTool's own macros drive outputs, of which the cell says which.
#[test]
fn hands_are_outputs() {
    for hand in ["Close hand 1", "OPEN HAND 2", "Relax hand 1"] {
        let found = tp(&format!("{hand} ;\n{MOVE}"));
        assert_eq!(
            (moves(&found), told(&found, Code::MotionLeftOut)),
            (1, NONE.to_vec()),
            "{hand}"
        );
        let asked = tp(&format!("RO[1]=ON ;\n{hand} ;\n{}", unless("RO[1]=ON")));
        assert_refused(&asked, 8, &[&format!("'{hand}' of line 7 may set it")]);
        let within = format!("IF DI[1]=ON,JMP LBL[2] ;\n{hand} ;\nLBL[2] ;\n{MOVE}");
        assert_eq!(moves(&tp(&within)), 1);
    }
    let twice = tp(&format!("Close hand 1 ;\nOpen hand R[2] ;\n{MOVE}")).unwrap();
    let is_told = |note: &&Note| note.what.starts_with("hands are taken");
    assert_eq!(twice.warnings.iter().filter(is_told).map(at).collect::<Vec<_>>(), [6]);
    for other in ["OPEN HANDLE", "OPEN HAND AND MOVE HOME", "Open hand", "Open hand 1 slow"] {
        assert_refused(&tp(&format!("{other} ;\n{MOVE}")), 6, &["if it is a macro, write CALL"]);
    }
}

/// What the job assumes of an output is for where the program asks first.
#[test]
fn a_hand_ends_what_the_job_assumes_of_an_output() {
    let job = job(&[("ro[1]", Assumed::Truth(true))]);
    let asks = |label: u8| format!("IF RO[1]=ON,JMP LBL[{label}] ;\n{MOVE}LBL[{label}] ;\n");
    let twice = |between: &str| with(&format!("{}{between}{}", asks(1), asks(2)), &job);
    assert_eq!(moves(&twice("")), 0);
    assert_refused(&twice("Close hand 1 ;\n"), 10, &["'Close hand 1' of line 9 may set it"]);
    assert_eq!(moves(&with(&format!("Close hand 1 ;\n{}", asks(1)), &job)), 0);
}

/// Where the path is planned it is known whether other arm configurations reach the start.
#[test]
fn the_configuration_at_the_start_is_left_to_the_path() {
    let found = whole(MOVE, &job(&[])).unwrap();
    let said = found.moves.iter().map(|each| each.stated.uncompared.as_deref());
    assert_eq!(said.collect::<Vec<_>>(), [Some("CONFIG 'N U T'"), None]);
}

/// Which of two labels of one number a jump finds, no manual says.
#[test]
fn a_jump_to_a_label_that_stands_twice_is_refused() {
    let twice = format!("JMP LBL[1] ;\nLBL[1] ;\n{MOVE}LBL[1] ;\nLBL[2] ;\nLBL[2] ;\n");
    assert_refused(&tp(&twice), 6, &["LBL[1] stands in lines 7 and 9"]);
    assert_eq!(moves(&tp(&twice.replace("JMP LBL[1]", "R[1]=1"))), moves(&tp(MOVE)));
}

#[test]
fn errors_that_follow_from_others_are_not_told() {
    // A loop that an undecided branch does not leave.
    let looped = format!("LBL[1] ;\nIF DI[1]=ON,JMP LBL[9] ;\n{MOVE}R[1]=R[1]+1 ;\nJMP LBL[1] ;\n");
    let start = format!("R[1]=0 ;\n{looped}LBL[9] ;\n{MOVE}");
    assert_refused(&tp(&start), 8, &["IF decides about motion at run time: DI[1]"]);
    // Where the arm is behind a move that is not read.
    let failed = "L P[9] 9mm/sec FINE ;\nPR[1]=LPOS ;\nL PR[1] 9mm/sec FINE ;\n";
    assert_refused(&tp(failed), 6, &["P[9] is not in /POS"]);
    // A frame and a counter that are not read.
    let frame = format!("UFRAME[1]=PR[1] ;\n{MOVE}");
    assert_refused(&tp(&frame), 6, &["UFRAME[1] is set to PR[1]"]);
    let counted = "FOR R[1]=1 TO R[2] ;\nL P[R[1]] 9mm/sec FINE ;\nENDFOR ;\n";
    assert_refused(&tp(counted), 6, &["R[2] is known only at run time"]);
    // A loop that has no end by itself is still told.
    let endless = "R[1]=0 ;\nLBL[1] ;\nR[1]=R[1]+1 ;\nIF R[1]>0,JMP LBL[1] ;\n";
    assert!(tp(endless).unwrap_err()[0].what.contains("runs too long"));
}

/// Registers have seven digits: ten times 0.7 is 6.999999 there, and 7 with sixteen.
#[test]
fn what_the_rounding_of_registers_decides_is_not_known() {
    let step = |step: &str, condition: &str| {
        format!("R[1]=0 ;\nLBL[2] ;\nR[1]=R[1]+{step} ;\n{MOVE}IF R[1]{condition},JMP LBL[2] ;\n")
    };
    let said = ["rounding to seven digits decides"];
    for (by, condition) in [(".7", "<7"), (".1", "<1"), (".1", "<>.3"), (".7", "<=2.1")] {
        assert_refused(&tp(&step(by, condition)), 10, &said);
    }
    assert_eq!(moves(&tp(&step(".5", "<3"))), 6);
    assert_eq!(moves(&tp(&step(".7", "<3"))), 5);
    let down = format!("R[1]=.3 ;\nLBL[2] ;\n{MOVE}R[1]=R[1]-.1 ;\nIF R[1]>0,JMP LBL[2] ;\n");
    assert_refused(&tp(&down), 10, &said);
    // Numbers as the text has them are rounded alike.
    assert_eq!(moves(&tp(&format!("R[1]=2.4 ;\n{}", unless("R[1]<=2.4")))), 0);
    assert_eq!(moves(&tp(&format!("R[1]=2.4 ;\nR[2]=2.4 ;\n{}", unless("R[1]>=R[2]")))), 0);
    assert_refused(&tp(&format!("R[1]=.1+.2 ;\n{}", unless("R[1]=.3"))), 7, &said);
    assert_refused(
        &tp("R[1]=.1+.2 ;\nSELECT R[1]=.3,JMP LBL[1] ;\n       =1,JMP LBL[1] ;\nLBL[1] ;\n"),
        7,
        &said,
    );
    assert_eq!(moves(&tp(&format!("R[1]=.3 ;\n{}", unless("R[1]=.3")))), 0);
}

/// Ends of moves, mm, in the frame of the job.
fn corners(found: &Read) -> Vec<[f64; 3]> {
    let moves = &found.as_ref().unwrap_or_else(|found| panic!("{found:?}")).moves;
    let of = |own| {
        let at = super::support::end(own).1.translation.vector * 1e3;
        [at.x - 1000.0, at.y, at.z].map(f64::round)
    };
    moves.iter().map(of).collect()
}

#[test]
fn inc_counts_from_the_position_before() {
    let shift = "PR[1]=P[2] ;\nPR[1,4]=0 ;\n";
    let found = tp(&format!("{shift}L PR[1] 9mm/sec FINE INC ;\nL PR[1] 9mm/sec FINE INC ;\n"));
    assert_eq!(corners(&found), [[100.0, 0.0, 0.0], [200.0, 0.0, 0.0]]);
    // With an offset beside it, and in a frame that is turned by a quarter about z: x is y.
    let other = "PR[2]=P[1]-P[1] ;\nPR[2,3]=5 ;\n";
    let found = tp(&format!("{shift}{other}L PR[1] 9mm/sec FINE INC Offset,PR[2] ;\n"));
    assert_eq!(corners(&found), [[100.0, 0.0, 5.0]]);
    let mut turned = job(&[]);
    let quarter = std::f64::consts::FRAC_1_SQRT_2;
    turned.base_frames.insert(2, pose([0.0, 0.0, 0.0], [quarter, 0.0, 0.0, quarter]));
    let text = format!("{shift}UFRAME_NUM=2 ;\nL PR[1] 9mm/sec FINE INC ;\n");
    assert_eq!(corners(&with(&text, &turned)), [[0.0, 100.0, 0.0]]);
    // P[2] turns the tool by half a turn.
    assert_refused(&tp("L P[2] 9mm/sec FINE INC ;\n"), 6, &["INC that turns the tool"]);
    assert_refused(&tp("C P[2] P[3] 9mm/sec FINE INC ;\n"), 6, &["INC of an arc"]);
}

#[test]
fn a_turn_without_a_way_takes_no_time() {
    let found = tp("L P[1] 50deg/sec FINE ;\nL P[2] 9mm/sec FINE ;\n");
    assert_eq!(moves(&found), 2);
    assert_refused(&tp("L P[2] 50deg/sec FINE ;\n"), 6, &["does not turn"]);
    let mut text = with("L P[2] 9mm/sec FINE ;\n", &job(&[]));
    assert_eq!(moves(&text), 1);
    text = tp("R[1]=50 ;\nL P[1] R[1]deg/sec FINE ;\n");
    assert_eq!(moves(&text), 1);
}

#[test]
fn times_of_wait_and_functions_of_numbers() {
    let seconds = |text: &str, job: &Settings| -> Vec<f64> {
        let found = with(text, job);
        let moves = &found.as_ref().unwrap_or_else(|found| panic!("{found:?}")).moves;
        let of = |own: &detune::motion::Move| match own.timing {
            Timing::Seconds(s) => Some(s),
            _ => None,
        };
        moves.iter().filter_map(of).collect()
    };
    let given = job(&[("ar[1]", Assumed::Number(3.0))]);
    for (time, expected) in
        [("AR[1]", 3.0), ("250(msec)", 0.25), ("500msec", 0.5), (".5(sec)", 0.5), ("R[1]", 2.0)]
    {
        assert_eq!(seconds(&format!("R[1]=2 ;\nWAIT {time} ;\n"), &given), [expected], "{time}");
    }
    assert_eq!(told(&tp("WAIT .5 ;\n"), Code::LeftOut), [6]);
    // 30° and 60°, 3-4-5.
    for (value, expected) in [
        ("SIN[30]*100", 50.0),
        ("COS[60]*10", 5.0),
        ("SQRT[R[1]*R[1]+16]", 5.0),
        ("ROUND[2.6]+TRUNC[2.6]+ABS[-1]", 6.0),
        ("ATAN[1]", 45.0),
    ] {
        let text = format!("R[1]=3 ;\nR[2]={value} ;\nWAIT R[2] ;\n");
        let found = seconds(&text, &given);
        assert!((found[0] - expected).abs() < 1e-9, "{value}: {found:?}");
    }
}

#[test]
fn what_stands_behind_a_jump_is_not_passed_over() {
    let text = "R[1]=7 ;\nIF R[1]=7,JMP LBL[1] R[2]=5 ;\nLBL[1] ;\n";
    assert_refused(&tp(text), 7, &["'R[2]=5' behind JMP LBL[1]"]);
    assert_refused(&tp("TOOL CHANGE(2) ;\n"), 6, &["if it is a macro, write CALL"]);
}

/// A register alone behind WAIT is a time.
#[test]
fn a_wait_for_a_register_is_a_time() {
    let waits = |statement: &str| {
        let found =
            tp(&format!("R[1]=2 ;\nL P[1] 9mm/sec FINE ;\n{statement} ;\nL P[2] 9mm/sec FINE ;\n"));
        let program = found.unwrap();
        let stands = program.moves.iter().filter_map(|each| match each.timing {
            Timing::Seconds(seconds) => Some(seconds),
            _ => None,
        });
        (
            stands.sum::<f64>(),
            program.warnings.iter().any(|note| note.what.starts_with("WAIT: R[2]")),
        )
    };
    assert_eq!(waits("WAIT R[1]"), (2.0, false));
    assert_eq!(waits("WAIT R[1:dwell]"), (2.0, false));
    assert_eq!(waits("WAIT R[2]"), (0.0, true));
    assert_eq!(waits("WAIT R[1]=1"), (0.0, false));
}
