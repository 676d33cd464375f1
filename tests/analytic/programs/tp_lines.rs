//! Fanuc TP: lines that are refused or a doubt by their name, and the causes that messages name.

use detune::motion::Target;
use detune::notes::{Class, Code, Note};
use detune::program::{Assumed, Dialect, Program, SetBy, Setter, Settings, TipAt, read};
use nalgebra::Isometry3;

use super::support::{assert_ends, at, pose, settings};

type Read = Result<Program, Vec<Note>>;

const MOVE: &str = "L P[2] 9mm/sec FINE ;\n";

fn point(number: u32, [x, y, z]: [f64; 3], own: &str) -> String {
    format!(
        "P[{number}]{{\n GP1:\n UF : 1, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n {own}X = {x} mm, {own}Y = {y} mm, \
         {own}Z = {z} mm, {own}W = 180 deg, {own}P = 0 deg, {own}R = 0 deg\n}};\n"
    )
}

/// P[1] to P[4] are corners of a square of 100 mm, P[5] is of a stationary tool; statements from
/// line 6 on.
fn with(statements: &str, job: &Settings) -> Read {
    let corners = [(1, 0.0, 0.0), (2, 100.0, 0.0), (3, 100.0, 100.0), (4, 0.0, 100.0)];
    let points = corners.map(|(number, x, y)| point(number, [x, y, 0.0], "")).concat();
    let text = format!(
        "/PROG T\n/MN\nUFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nL P[1] 100mm/sec FINE ;\n{statements}/POS\n{points}{}/END\n",
        point(5, [0.0; 3], "R")
    );
    let mut found = read(text.as_bytes(), Dialect::Fanuc, job)?;
    found.moves.remove(0);
    Ok(found)
}

fn job(assumed: &[(&str, f64)]) -> Settings {
    let mut job = settings();
    let upright = [1.0, 0.0, 0.0, 0.0];
    job.base_frames.insert(1, pose([1000.0, 0.0, 0.0], upright));
    job.tool_frames.insert(1, pose([0.0, 0.0, 150.0], upright));
    let given = assumed.iter().map(|(name, value)| ((*name).to_owned(), Assumed::Number(*value)));
    job.assume.extend(given);
    job
}

fn tp(statements: &str) -> Read {
    with(statements, &job(&[]))
}

#[track_caller]
fn moves(found: &Read) -> usize {
    found.as_ref().unwrap_or_else(|found| panic!("{found:?}")).moves.len()
}

/// The message of the one error.
#[track_caller]
fn refused(found: Read, line: usize, said: &str) -> String {
    let found = found.expect_err(said);
    assert_eq!((at(&found[0]), found.len()), (line, 1), "{found:?}");
    assert!(found[0].what.contains(said), "{said}: {found:?}");
    found[0].what.clone()
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
fn a_line_has_one_instruction() {
    for (line, own) in [
        ("L P[2] 9mm/sec FINE ; L P[3] 9mm/sec FINE ;", "L P[3] 9mm/sec FINE"),
        ("R[1]=1 ; CALL FOO ;", "CALL FOO"),
    ] {
        refused(tp(&format!("{line}\n{MOVE}")), 6, &format!("'{own}' stands behind the ';' of"));
    }
    // A remark goes on to the end of its line.
    for line in [
        "R[1]=1 ; ! sets ; UFRAME_NUM=2 ;",
        "! sets ; UFRAME_NUM=2 ;",
        "! use ; R[1]=5 for speed ;",
        "! x ; OFFSET CONDITION PR[1] ;",
        "//L P[3] 9mm/sec FINE ; L P[4] 9mm/sec FINE ;",
    ] {
        let found = tp(&format!("{line}\n{MOVE}"));
        assert_eq!((moves(&found), told(&found, Code::MotionLeftOut)), (1, vec![6]), "{line}");
    }
    let text = tp(&format!("CALL MSG('Wait; go') ;\nSR[1]='a;b' ;\n{MOVE}"));
    assert!(text.is_ok_and(|found| found.moves.len() == 1));
    for line in [
        "R[1]=1 ; ! sets ; frames",
        "R[1]=1 ; // L P[9] 9mm/sec FINE ;",
        "//R[1]=1 ; //R[2]=2 ;",
        "! a ; b ;",
        "MESSAGE[wait; go] ;",
        "R[1:a;b]=1 ; ;",
    ] {
        let found = tp(&format!("{line}\n{MOVE}"));
        assert_eq!((moves(&found), told(&found, Code::MotionLeftOut)), (1, vec![]), "{line}");
    }
    // A remark behind an instruction holds from nowhere.
    let what = Setter::Comment("SPINDLE".to_owned());
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..job(&[]) };
    let found = with(&format!("R[1]=1 ; ! SPINDLE 9000 ;\n{MOVE}"), &job);
    assert_eq!(told(&found, Code::SpindleCommand), [6]);
}

#[test]
fn frames_0_are_fixed_and_a_bare_frame_sets_nothing() {
    let set = |list: &str| tp(&format!("PR[1]=P[2] ;\n{list}=PR[1] ;\n"));
    refused(set("UTOOL[0]"), 7, "UTOOL[0] cannot be set: it is the flange");
    refused(set("UFRAME[0]"), 7, "UFRAME[0] cannot be set: it is the robot's base frame");
    assert!(set("UTOOL[2]").is_ok());
    refused(tp("UTOOL[2] ;\n"), 6, "UTOOL[2] sets nothing: expected UTOOL[2]=PR[n]");
}

#[test]
fn a_stationary_tool_is_refused_by_its_name() {
    let said = "a stationary tool (remote TCP) is not supported";
    refused(tp("L P[2] 9mm/sec FINE RTCP ;\n"), 6, said);
    refused(tp("L P[5] 9mm/sec FINE ;\n"), 6, said);
}

#[test]
fn soft_servos_and_variables_of_motion_are_doubts() {
    let doubts = |line: &str| {
        let found = tp(&format!("{line} ;\n{MOVE}")).unwrap_or_else(|found| panic!("{found:?}"));
        let all = found.warnings.into_iter().filter(|note| at(note) == 6);
        all.map(|note| (note.code, note.code.class() == Class::Doubt)).collect::<Vec<_>>()
    };
    assert_eq!(doubts("SOFTFLOAT[1]"), [(Code::MotionLeftOut, true)]);
    assert_eq!(doubts("SOFTFLOAT [1]"), [(Code::MotionLeftOut, true)]);
    assert_eq!(doubts("SOFTFLOAT[2] END"), [(Code::MotionLeftOut, true)]);
    assert_eq!(doubts("SOFTFLOAT END"), []);
    for name in ["$SCR_GRP[1].$X", "$MCR.$X", "$GROUP[1].$X"] {
        assert_eq!(doubts(&format!("{name}=1")), [(Code::ChangeIgnored, true)], "{name}");
    }
    assert_eq!(doubts("$SHELL_CFG.$X=1"), [(Code::LeftOut, false)]);
    assert_eq!(doubts("$WAITTMOUT=200"), []);
}

/// Three points in a row are one circle, whatever is said between them.
#[test]
fn remarks_between_the_points_of_an_arc_change_nothing() {
    let arc = |between: &str| {
        let text = format!(
            "A P[2] 9mm/sec CNT100 ;\n{between}A P[3] 9mm/sec CNT100 ;\n{between}A P[4] 9mm/sec FINE ;\n"
        );
        let found = tp(&text).unwrap_or_else(|found| panic!("{found:?}"));
        found.moves.into_iter().map(|own| own.to).collect::<Vec<_>>()
    };
    let whole = arc("");
    assert!(matches!(whole[1..], [Target::Arc { .. }, Target::Arc { .. }]), "{whole:?}");
    for between in ["! on ;\n", " ;\n", "// A P[1] 9mm/sec CNT100 ;\n"] {
        assert_eq!(arc(between), whole, "{between}");
    }
}

#[test]
fn a_value_that_is_not_known_names_what_it_rests_on() {
    for (set, asked, hint) in [
        ("R[10]=GI[2]", "R[10]<170", "{\"GI[2]\": …} in the job can give it"),
        (
            "R[10]=GI[2]*2+AI[3]",
            "R[10]<170",
            "{\"GI[2]\": …, \"AI[3]\": …} in the job can give them",
        ),
        ("R[9]=GI[2] ;\nR[10]=R[9]+R[9]", "R[10]<170", "{\"GI[2]\": …} in the job can give it"),
        ("R[10]=R[R[5]]", "R[10]<170", "{\"R[5]\": …}"),
        ("F[1]=(DI[9] AND R[3]=1)", "F[1]", "{\"DI[9]\": …, \"R[3]\": …}"),
        ("GO[1]=R[5]+1", "GO[1]=3", "{\"R[5]\": …}"),
        ("R[1]=5", "R[2]>R[3]", "{\"R[2]\": …, \"R[3]\": …}"),
        ("R[1]=5 ;\nIF DI[7],R[1]=3", "R[1]=3", "{\"DI[7]\": …}"),
    ] {
        let line = 7 + set.lines().count() - 1;
        refused(tp(&format!("{set} ;\n{}", unless(asked))), line, &format!("assume: {hint}"));
    }
    let text = format!("R[10]=GI[2] ;\n{}", unless("R[10]<170"));
    let of = |value| moves(&with(&text, &job(&[("gi[2]", value)])));
    assert_eq!((of(338.0), of(100.0)), (1, 0));
    // One that nothing in the job settles is told alone.
    let text = format!("DO[1]=PULSE,0.5sec ;\nR[1]=GI[1]+DO[1] ;\n{}", unless("R[1]=3"));
    let what = refused(tp(&text), 8, "R[1] is set to what is known only at run time: it is pulsed");
    assert!(!what.contains("assume"), "{what}");
    refused(tp(&format!("R[1]=GI[1]/0 ;\n{}", unless("R[1]=3"))), 7, "division by zero");
    let what = refused(tp(&format!("R[1]=R[2]+SIN[ ;\n{}", unless("R[1]=3"))), 7, "has no ']'");
    assert!(!what.contains("assume"), "{what}");
    let number = with(&unless("DI[1]"), &job(&[("di[1]", 1.0)]));
    refused(number, 6, "DI[1] is the number 1, expected ON or OFF");
}

#[test]
fn an_offset_that_is_not_known_names_what_it_rests_on() {
    let zero: String = (2..=6).map(|index| format!("PR[10,{index}]=0 ;\n")).collect();
    let text = format!("PR[10,1]=R[1]*R[4] ;\n{zero}L P[2] 9mm/sec FINE Offset,PR[10] ;\n");
    let hint = "assume: {\"R[1]\": …, \"R[4]\": …} in the job can give them";
    refused(tp(&text), 12, hint);
    refused(with(&text, &job(&[("pr[10]", 0.0)])), 12, hint);
    let given = with(&text, &job(&[("r[1]", 2.0), ("r[4]", 15.0)])).unwrap();
    assert_ends(&given, &[('L', [1130.0, 0.0, 0.0])]);
    // With what the program does not set, and through a copy.
    let part = "PR[10,1]=R[1] ;\nL P[2] 9mm/sec FINE Offset,PR[10] ;\n";
    refused(tp(part), 7, "{\"R[1]\": …, \"PR[10,2]\": …, \"PR[10,3]\": …, \"PR[10,4]\": …");
    let copied = text.replace("PR[10] ;", "PR[11] ;").replace("L P", "PR[11]=PR[10] ;\nL P");
    refused(tp(&copied), 13, hint);
    let part = "PR[10,1]=R[1] ;\nPR[11]=PR[10] ;\nL P[2] 9mm/sec FINE Offset,PR[11] ;\n";
    refused(tp(part), 8, "{\"R[1]\": …, \"PR[10,2]\": …, \"PR[10,3]\": …");
}

/// The message does not grow with every pass.
#[test]
fn registers_that_are_set_to_each_other_in_a_loop_have_one_cause() {
    let pass = "PR[1]=PR[2] ;\nPR[2]=PR[1] ;\nIF R[2]>0,R[2]=3 ;\nR[3]=R[2] ;\nR[2]=R[3] ;\n";
    let text = format!("FOR R[1]=1 TO 50 ;\n{pass}ENDFOR ;\n");
    let what = refused(tp(&format!("{text}L PR[1] 9mm/sec FINE ;\n")), 13, "PR[2] is known only");
    assert!(what.len() < 400, "{what}");
    let what = refused(tp(&format!("{text}{}", unless("R[3]>0"))), 13, "R[3] is set to what");
    assert!(what.len() < 400, "{what}");
}

#[test]
fn a_line_that_begins_with_a_slash_begins_a_section() {
    let said = "a line that begins with '/' begins a section";
    for line in [
        "/ remark of the operator",
        "   / remark",
        "/ 5:L P[3] 9mm/sec FINE ;",
        "/APPL",
        "/MN",
        "/ END",
        "/END of part 1",
        "/POS 1",
        "/WORK",
    ] {
        refused(tp(&format!("{line}\n{MOVE}")), 6, said);
    }
    let two = [point(1, [0.0; 3], ""), point(1, [9.0, 0.0, 0.0], "")];
    let text = |between: &str, behind: &str| {
        let [first, second] = &two;
        let second = if between.is_empty() { "" } else { second };
        let head = "/PROG T Macro\n/ATTR\n/APPL\n/APPL\n/MN\nL P[1] 9mm/sec FINE ;\n";
        format!("{head}/POS\n{first}{between}{second}/END\n{behind}")
    };
    // The positions behind it are read: the second P[1] stands on line 14.
    let found = read(text("/ spare\n", "").as_bytes(), Dialect::Fanuc, &job(&[])).unwrap_err();
    assert_eq!(found.iter().map(at).collect::<Vec<_>>(), [13, 14], "{found:?}");
    // What stands behind the end is another program.
    let doubts = |behind: &str| {
        let found = read(text("", behind).as_bytes(), Dialect::Fanuc, &job(&[]));
        told(&found, Code::MotionLeftOut)
    };
    assert!(doubts("\nnotes\n").is_empty());
    assert_eq!(doubts("/PROG U\n/MN\n   1:L P[1] 9mm/sec FINE ;\n"), [16]);
}

/// The faceplate to the controller, whatever the job's tcp is.
#[test]
fn tool_0_under_the_tcp_of_the_job_is_a_doubt() {
    let point = point(1, [0.0; 3], "").replace("UT : 1", "UT : 0");
    for choice in ["UTOOL_NUM=0 ;", ""] {
        let body = format!("UFRAME_NUM=1 ;\n{choice}\nL P[1] 9mm/sec FINE ;");
        let text = format!("/PROG T\n/MN\n{body}\n/POS\n{point}/END\n");
        let of = |job: &Settings| {
            let found = read(text.as_bytes(), Dialect::Fanuc, job);
            let doubts = told(&found, Code::ChangeIgnored);
            (found.unwrap().moves[0].tcp.translation.z, doubts)
        };
        let mut job = job(&[]);
        assert_eq!(of(&job), (0.0, vec![]));
        job.tcp = Some(pose([0.0, 0.0, 200.0], [1.0, 0.0, 0.0, 0.0]));
        assert_eq!(of(&job), (0.2, vec![5]));
        job.tool_frames.insert(0, pose([0.0; 3], [1.0, 0.0, 0.0, 0.0]));
        assert_eq!(of(&job), (0.0, vec![]));
    }
    // A joint move to joints ends there with any tool; a line to them, and LPOS, depend on it.
    let mut job = job(&[]);
    job.tcp = Some(pose([0.0, 0.0, 200.0], [1.0, 0.0, 0.0, 0.0]));
    job.tip_at = Some(TipAt::new(|q| Some(Isometry3::translation(1.0 + q[0], 0.0, 0.5))));
    let joints = "P[1]{\n GP1:\n UF : 1, UT : 0,\n J1= 0 deg, J2= 0 deg, J3= 0 deg, J4= 0 deg, \
                  J5= 9 deg, J6= 0 deg\n};\n";
    for (body, doubts) in [("J P[1] 9% FINE ;", vec![]), ("L P[1] 9mm/sec FINE ;", vec![5])] {
        let head = "UFRAME_NUM=1 ;\nUTOOL_NUM=0 ;";
        let text = format!("/PROG T\n/MN\n{head}\n{body}\n/POS\n{joints}/END\n");
        let found = read(text.as_bytes(), Dialect::Fanuc, &job);
        assert!(found.is_ok(), "{found:?}");
        assert_eq!(told(&found, Code::ChangeIgnored), doubts, "{body}");
    }
    let at = point.replace("UT : 0", "UT : 1");
    let body = "UFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nL P[1] 9mm/sec FINE ;\nUTOOL_NUM=0 ;\nPR[1]=LPOS ;\n\
                UTOOL_NUM=1 ;\nL PR[1] 9mm/sec FINE ;";
    let text = format!("/PROG T\n/MN\n{body}\n/POS\n{at}/END\n");
    let doubts = told(&read(text.as_bytes(), Dialect::Fanuc, &job), Code::ChangeIgnored);
    assert!(doubts.contains(&7), "{doubts:?}");
}

#[test]
fn a_loop_that_waits_for_another_says_what_for() {
    let told_by = |statements: &str, line: usize, said: &[&str]| {
        let found = tp(statements).unwrap_or_else(|found| panic!("{found:?}"));
        let left_out = found.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
        let notes: Vec<&Note> = left_out.collect();
        assert_eq!(notes.iter().map(|note| at(note)).collect::<Vec<_>>(), [line], "{notes:?}");
        assert!(said.iter().all(|said| notes[0].what.contains(said)), "{said:?}: {notes:?}");
        found.moves.len()
    };
    let looped = |exits: &str, body: &str| {
        format!("R[1]=0 ;\nLBL[1] ;\n{exits}{body}JMP LBL[1] ;\nLBL[2] ;\n{MOVE}")
    };
    let done = "IF R[1]=10,JMP LBL[2] ;\n";
    let failed = "IF R[1]=(-1),JMP LBL[2] ;\n";
    let waits =
        ["waits for R[1]=10", "from the move of line 11 on, is not read", "write WAIT R[1]=10"];
    assert_eq!(told_by(&looped(done, ""), 9, &waits), 0);
    assert_eq!(
        told_by(&looped(&format!("{done}{failed}"), ""), 10, &["waits for R[1]=10 or R[1]=(-1)"]),
        0
    );
    let stays =
        ["read once", "nothing in it leads to R[1]=10", "from the move of line 12 on, is not read"];
    assert_eq!(told_by(&looped(done, MOVE), 10, &stays), 1);
    // The exit that leads to what stands behind the loop, not the one to the end of the program.
    let fails = "IF R[1]=(-1),JMP LBL[99] ;\n";
    let aborts = format!("{}LBL[99] ;\n", looped(&format!("{fails}{done}"), ""));
    assert_eq!(told_by(&aborts, 10, &["R[1]=(-1) or R[1]=10", "write WAIT R[1]=10 in"]), 0);
    // None leads there, or not by itself: no WAIT stands for the loop.
    let from_line_12 = "from the move of line 12 on, is not read";
    for (statements, line, said) in [
        (format!("LBL[5] ;\n{}", looped("IF R[1]=10,JMP LBL[5] ;\n", "")), 10, from_line_12),
        (looped("IF (R[1]=10) THEN ;\nJMP LBL[2] ;\nENDIF ;\n", ""), 11, "of line 13 on"),
        (looped("SELECT R[1]=10,JMP LBL[2] ;\n", ""), 9, "of line 11 on"),
        (format!("{}LBL[99] ;\n", looped(fails, "")), 9, "of line 11 on"),
    ] {
        let found = tp(&statements).unwrap_or_else(|found| panic!("{found:?}"));
        let of = |note: &&Note| note.code == Code::MotionLeftOut;
        let notes: Vec<&Note> = found.warnings.iter().filter(of).collect();
        // Where nothing else leads to the moves behind the loop, they are told as well.
        assert_eq!(at(notes[0]), line, "{notes:?}");
        let what = &notes[0].what;
        assert!(what.contains(said) && !what.contains("WAIT"), "{what}");
    }
    // As the message advises.
    assert_eq!(moves(&tp(&format!("R[1]=0 ;\nWAIT R[1]=10 ;\n{MOVE}"))), 1);
}

#[test]
fn a_list_or_a_number_that_is_missing_is_refused_where_it_stands() {
    let said = "'[R80]' is not understood";
    for value in ["[R80]/2", "2*[R80]", "(R[1]+[R80])"] {
        refused(
            tp(&format!("R[1]=6 ;\nR[80:n]={value} ;\nL P[2] R[80:n]mm/sec FINE ;\n")),
            7,
            said,
        );
    }
    refused(tp(&unless("[R80]=3")), 6, said);
    for line in ["J PR[...] 9% FINE", "R[...]=1", "L P[2] R[...]mm/sec FINE Offset,PR[...]"] {
        refused(tp(&format!("{line} ;\n")), 6, "never filled in");
    }
}

/// `[GPn]` is of one group alone: of the arm, or of a positioner.
#[test]
fn frames_of_another_group_are_not_the_arms() {
    let mut job = job(&[]);
    let upright = [1.0, 0.0, 0.0, 0.0];
    job.base_frames.insert(2, pose([-400.0, 0.0, 0.0], upright));
    job.tool_frames.insert(2, pose([0.0, 0.0, 400.0], upright));
    let other = "UTOOL_NUM[GP2]=2 ;\nUFRAME_NUM [GP2]=2 ;\nPR[6]=P[2] ;\n";
    let moves = "L PR[6] 9mm/sec FINE ;\nL P[3] 9mm/sec FINE ;\n";
    let found = with(&format!("{other}{moves}"), &job).unwrap();
    assert_ends(&found, &[('L', [1100.0, 0.0, 0.0]), ('L', [1100.0, 100.0, 0.0])]);
    let both = other.replace("GP2", "gp2, GP1");
    assert_eq!(
        with(&format!("{both}{moves}"), &job).unwrap_err(),
        with(&format!("{}{moves}", other.replace("GP2", "GP1")), &job).unwrap_err()
    );
    let found = with(&format!("{}{moves}", other.replace("GP2", "GP1")), &job).unwrap_err();
    let is_it = |note: &Note| note.what.contains("P[3] has UF : 1, and UFRAME_NUM is 2 here");
    assert!(found.iter().any(is_it), "{found:?}");
    refused(tp("UTOOL_NUM[2]=1 ;\n"), 6, "expected UTOOL_NUM=n, or UTOOL_NUM[GP1]=n");
    // The frame of the positions counts where the program chooses none for the arm.
    let text = format!(
        "/PROG T\n/MN\nUFRAME_NUM[GP2]=2 ;\nUTOOL_NUM[GP2]=2 ;\nPR[6]=P[2] ;\nL PR[6] 9mm/sec FINE ;\n/POS\n{}/END\n",
        point(2, [100.0, 0.0, 0.0], "")
    );
    let found = read(text.as_bytes(), Dialect::Fanuc, &job).unwrap();
    assert_ends(&found, &[('L', [1100.0, 0.0, 0.0])]);
}

/// P[1], P[2] and an increment P[4], whose values may be changed.
fn increment(change: impl Fn(String) -> String) -> Read {
    let points = [1.0, 2.0].map(|n| point(n as u32, [100.0 * n, 0.0, 0.0], "")).concat();
    let last = change(point(4, [0.0, 0.0, -2.0], "").replace("W = 180", "W = 0"));
    let text = format!(
        "/PROG T\n/MN\nUFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nL P[1] 9mm/sec FINE ;\nL P[4] 9mm/sec FINE INC ;\n\
         L P[2] 9mm/sec FINE ;\n/POS\n{points}{last}/END\n"
    );
    read(text.as_bytes(), Dialect::Fanuc, &job(&[]))
}

#[test]
fn the_configuration_of_an_increment_does_not_count() {
    for config in ["N U T", "N D B"] {
        let found = increment(|point| point.replace("N U T", config)).unwrap();
        let expected = [[1100.0, 0.0, 0.0], [1100.0, 0.0, -2.0], [1200.0, 0.0, 0.0]];
        assert_ends(&found, &expected.map(|at| ('L', at)));
    }
}

#[test]
fn a_second_robot_that_moves_is_refused_as_one() {
    let group = |x: f64| {
        format!(
            "\n GP3:\n UF : 1, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n X = {x} mm, Y = 0 mm, Z = 0 mm, \
             W = 0 deg, P = 0 deg, R = 0 deg,\n E1 = {x} mm\n}};"
        )
    };
    let both = |second: f64| {
        let points = [(1, 50.0), (2, second)].map(|(number, x)| {
            point(number, [100.0 * f64::from(number), 0.0, 0.0], "").replace("\n};", &group(x))
        });
        let text = format!(
            "/PROG T\n/MN\nUFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nL P[1] 9mm/sec FINE ;\n{MOVE}/POS\n{}/END\n",
            points.concat()
        );
        read(text.as_bytes(), Dialect::Fanuc, &job(&[]))
    };
    refused(both(60.0), 6, "GP3 is a second robot, and it moves");
    assert_eq!(moves(&both(50.0)), 2);
}

#[test]
fn a_program_without_motion_is_told_as_that() {
    let text = "/PROG T\n/MN\nIF R[47]>=5,JMP LBL[2] ;\nJMP LBL[3] ;\nLBL[2] ;\nR[1]=1 ;\nLBL[3] ;\n/POS\n/END\n";
    let found = read(text.as_bytes(), Dialect::Fanuc, &settings()).unwrap_err();
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].what.contains("the program contains no motion"), "{found:?}");
}

#[test]
fn a_speed_by_name_is_asked_for_with_its_unit() {
    let found = tp("L P[2] WELD_SPEED FINE ;\n").unwrap();
    let told =
        |note: &Note| note.what.contains("{\"WELD_SPEED\": …} in the job can give it, in mm/sec");
    assert!(found.warnings.iter().any(told), "{:?}", found.warnings);
}

/// The mask of a program names the groups that it moves, whatever its positions have.
#[test]
fn a_program_that_leaves_out_the_arm_is_refused_where_it_moves() {
    let of = |groups: &str, statements: &str| {
        let point = point(1, [0.0; 3], "");
        let text = format!(
            "/PROG T\n/ATTR\nDEFAULT_GROUP = {groups};\n/MN\nUFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\n{statements}/POS\n{point}/END\n"
        );
        read(text.as_bytes(), Dialect::Fanuc, &job(&[]))
    };
    let line = "L P[1] 100mm/sec FINE ;\n";
    assert_eq!(moves(&of("1,*,*,*,*", line)), 1);
    assert_eq!(moves(&of("1,1,*,*,*", line)), 1);
    for groups in ["*,1,*,*,*", "*,*,*,*,*"] {
        refused(of(groups, line), 7, "and the arm (group 1) stands");
        let still = of(groups, "DO[1]=ON ;\n").unwrap_err();
        assert!(!still[0].what.contains("stands"), "{still:?}");
    }
}

/// A number and a colon begin a statement: one that is open there lacks its ';'.
#[test]
fn a_line_that_is_not_ended_swallows_none() {
    for open in ["DO[1]=ON", "R[1]=5", "WAIT .50(sec)", "MESSAGE[ON]"] {
        let text = format!("   4:  {open}\n   5:{MOVE}   6:{MOVE}");
        refused(tp(&text), 6, "has no ';' before the next line");
    }
    // Listings have the last case of a SELECT so.
    let select = |value: u32| {
        format!(
            "   4:  R[1]={value} ;\n   5:  SELECT R[1]=1,JMP LBL[1] ;\n   6:         ELSE,JMP LBL[2]\n   7:{MOVE}\
             8:  LBL[1] ;\n   9:L P[3] 9mm/sec FINE ;\n  10:  LBL[2] ;\n  11:L P[4] 9mm/sec FINE ;\n"
        )
    };
    assert_eq!([1, 2].map(|value| moves(&tp(&select(value)))), [2, 1]);
    let last = select(3).replace("ELSE,JMP LBL[2]", "=2,JMP LBL[2]");
    assert_eq!(moves(&tp(&last)), 3);
    let arc = "   4:C P[2]\n    :  P[3] 9mm/sec FINE ;\n   5:L P[4] 9mm/sec FINE ;\n";
    assert_eq!(moves(&tp(arc)), 2);
}

#[test]
fn branches_and_limits_that_are_not_certain_are_told() {
    let branch = format!(
        "R[1]=2 ;\nIF (R[1]=1) THEN ;\n{MOVE}ELSEIF (R[1]=2) THEN ;\n{MOVE}ENDIF ;\n{MOVE}"
    );
    refused(tp(&branch), 7, "ELSEIF is not understood");
    let of_loop = |body: &str| {
        tp(&format!(
            "R[2]=2 ;\nFOR R[1]=1 TO R[2] ;\n{MOVE}{body}L P[3] 9mm/sec FINE ;\nENDFOR ;\n"
        ))
    };
    assert_eq!(told(&of_loop("R[2]=5 ;\n"), Code::MotionLeftOut), [9]);
    assert!(told(&of_loop("R[3]=5 ;\n"), Code::MotionLeftOut).is_empty());
    assert_eq!(moves(&of_loop("")), 4);
}

/// A digital output that is on counts as one unit.
#[test]
fn a_digital_output_turns_the_spindle() {
    let what = Setter::Signal("DO[5]".to_owned());
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 8000.0 }), ..job(&[]) };
    let found = with(&format!("DO[5]=ON ;\n{MOVE}DO[5]=OFF ;\nJ P[3] 9% FINE ;\n"), &job).unwrap();
    let set = found.spindle.iter().map(|it| (it.line, it.spindle.rpm())).collect::<Vec<_>>();
    assert_eq!(set, [(6, Some(8000.0)), (8, None)]);
    assert!(
        found.warnings.iter().all(|it| it.code != Code::SpindleCommand),
        "{:?}",
        found.warnings
    );
}
