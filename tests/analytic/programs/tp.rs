//! Fanuc TP: position registers and their arithmetic, numbers that registers give, SELECT, speeds,
//! what acts beside the program.

use detune::motion::Timing;
use detune::notes::{Code, Note};
use detune::program::{Assumed, Dialect, Program, Settings, read};

use super::support::{assert_ends, at, end, lines, pose, settings};

type Read = Result<Program, Vec<Note>>;

const NONE: [usize; 0] = [];

fn point(number: u32, [x, y, z]: [f64; 3], frames: &str) -> String {
    format!(
        "P[{number}]{{\n   GP1:\n\t{frames},\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {x} mm,\tY = {y} \
         mm,\tZ = {z} mm,\n\tW = 180.000 deg,\tP = 0.000 deg,\tR = 0.000 deg\n}};\n"
    )
}

/// The corners of a square of 100 mm, and P[5] in joints.
fn points(frames: &str) -> String {
    let corners = [(1, 0.0, 0.0), (2, 100.0, 0.0), (3, 100.0, 100.0), (4, 0.0, 100.0)];
    let corners = corners.map(|(number, x, y)| point(number, [x, y, 0.0], frames)).concat();
    let joints: String = (1..=6).map(|i| format!(",\n\tJ{i} = {i}0 deg")).collect();
    format!("{corners}P[5]{{\n   GP1:\n\t{frames}{joints}\n}};\n")
}

/// Frames 1 and 2 are 200 mm apart, tools 1 and 2 are 150 and 250 mm long.
fn job() -> Settings {
    let upright = [1.0, 0.0, 0.0, 0.0];
    let mut job = settings();
    job.base_frames.insert(1, pose([1000.0, 0.0, 0.0], upright));
    job.base_frames.insert(2, pose([1200.0, 0.0, 0.0], upright));
    job.tool_frames.insert(1, pose([0.0, 0.0, 150.0], upright));
    job.tool_frames.insert(2, pose([0.0, 0.0, 250.0], upright));
    job
}

/// Statements from line 3 on.
fn whole(statements: &str, points: &str, job: &Settings) -> Read {
    let text = format!("/PROG T\n/MN\n{statements}/POS\n{points}/END\n");
    read(text.as_bytes(), Dialect::Fanuc, job)
}

/// In frame 1 with tool 1 from P[1] on; statements from line 6 on.
fn with(statements: &str, job: &Settings) -> Read {
    let start = "UFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nL P[1] 100mm/sec FINE ;\n";
    let mut found = whole(&format!("{start}{statements}"), &points("UF : 1, UT : 1"), job)?;
    found.moves.remove(0);
    Ok(found)
}

fn tp(statements: &str) -> Read {
    with(statements, &job())
}

fn assuming(name: &str, value: f64) -> Settings {
    let mut job = job();
    job.assume.insert(name.to_owned(), Assumed::Number(value));
    job
}

/// The job gives all six elements of a register.
fn placing(number: u32, elements: [f64; 6]) -> Settings {
    let mut job = job();
    for (index, value) in (1..).zip(elements) {
        job.assume.insert(format!("pr[{number},{index}]"), Assumed::Number(value));
    }
    job
}

/// Ends of lines in frame 1, mm.
#[track_caller]
fn assert_goes(found: &Read, expected: &[[f64; 3]]) {
    let found = found.as_ref().unwrap_or_else(|found| panic!("{found:?}"));
    let expected: Vec<_> = expected.iter().map(|[x, y, z]| ('L', [x + 1000.0, *y, *z])).collect();
    assert_ends(found, &expected);
}

#[track_caller]
fn assert_refused(found: Read, line: usize, said: &[&str]) {
    let found = found.expect_err("the program is wrong");
    assert_eq!((at(&found[0]), found.len()), (line, 1), "{found:?}");
    assert!(said.iter().all(|said| found[0].what.contains(said)), "{said:?}: {found:?}");
}

fn told(found: &Read, code: Code) -> Vec<usize> {
    let found = found.as_ref().unwrap_or_else(|found| panic!("{found:?}"));
    found.warnings.iter().filter(|note| note.code == code).map(at).collect()
}

#[test]
fn a_position_register_counts_in_the_frame_that_is_chosen() {
    let both = "L PR[2] 100mm/sec FINE ;\nUFRAME_NUM=2 ;\nL PR[2] 100mm/sec FINE ;\n";
    assert_goes(&tp(&format!("PR[2]=P[2] ;\n{both}")), &[[100.0, 0.0, 0.0], [300.0, 0.0, 0.0]]);
    let changed = tp(&format!("PR[2]=P[2] ;\nPR[2,2]=5 ;\n{both}"));
    assert_goes(&changed, &[[100.0, 5.0, 0.0], [300.0, 5.0, 0.0]]);
    // What is copied under another frame, from another register, is the same.
    let copied = tp("UFRAME_NUM=2 ;\nPR[3]=P[2] ;\nPR[2]=PR[3] ;\nL PR[2] 100mm/sec FINE ;\n");
    assert_goes(&copied, &[[300.0, 0.0, 0.0]]);
}

#[test]
fn a_position_register_is_of_the_tool_that_is_chosen() {
    let statements =
        "PR[2]=P[2] ;\nL P[2] 100mm/sec FINE ;\nUTOOL_NUM=2 ;\nL PR[2] 9mm/sec FINE ;\n";
    let found = tp(statements);
    assert_goes(&found, &[[100.0, 0.0, 0.0], [100.0, 0.0, 0.0]]);
    let lengths: Vec<f64> =
        found.unwrap().moves.iter().map(|each| each.tcp.translation.vector.z).collect();
    assert_eq!(lengths, [0.15, 0.25]);
}

/// The controller stops at positions of a frame that is not chosen, so theirs is.
#[test]
fn the_frame_of_the_positions_is_chosen_where_the_program_says_none() {
    let statements = "PR[2]=P[2] ;\nL PR[2] 9mm/sec FINE ;\nL P[1] 9mm/sec FINE ;\n";
    let found = whole(statements, &points("UF : 2, UT : 2"), &job());
    assert_goes(&found, &[[300.0, 0.0, 0.0], [200.0, 0.0, 0.0]]);
    let two = [points("UF : 1, UT : 1"), point(6, [0.0; 3], "UF : 2, UT : 1")].concat();
    let said = ["UFRAME_NUM is not set before", "write UFRAME_NUM=… before the move"];
    assert_refused(whole(statements, &two, &job()), 4, &said);
    // The one of the last position, and not that of a later choice.
    let behind = "L P[6] 9mm/sec FINE ;\nPR[2]=P[2] ;\nL PR[2] 9mm/sec FINE ;\n";
    assert_goes(&whole(behind, &two, &job()), &[[200.0, 0.0, 0.0], [300.0, 0.0, 0.0]]);
    let later = format!("{statements}UFRAME_NUM=2 ;\nL P[1] 9mm/sec FINE ;\n").replacen(
        "L P[1] 9mm/sec FINE ;\n",
        "",
        1,
    );
    assert_refused(whole(&later, &points("UF : 2, UT : 2"), &job()), 4, &said);
}

#[test]
fn override_slows_motion_in_given_time() {
    let found = tp(
        "OVERRIDE=10% ;\nL P[2] 2.0sec FINE ;\nL P[1] 2000msec FINE ;\nL P[2] 50mm/sec FINE ;\n\
         WAIT 1.50(sec) ;\nJ P[1] 50% FINE ;\n",
    );
    let found = found.unwrap();
    let timings: Vec<Timing> = found.moves.iter().map(|each| each.timing).collect();
    let [slow, wait, joints] = [Timing::Seconds(20.0), Timing::Seconds(1.5), Timing::Joints(0.05)];
    assert_eq!(timings, [slow, slow, Timing::Feed, wait, joints]);
    assert!((found.moves[2].feed_m_per_s - 0.005).abs() < 1e-12);
}

#[test]
fn an_override_that_is_not_known_is_an_error_of_the_move_behind() {
    assert_eq!(tp("L P[2] 9mm/sec FINE ;\nOVERRIDE=R[50] ;\n").unwrap().moves.len(), 1);
    assert_eq!(
        tp("OVERRIDE=R[50] ;\nOVERRIDE=50% ;\nL P[2] 9mm/sec FINE ;\n").unwrap().moves.len(),
        1
    );
    let said = ["OVERRIDE of line 6: R[50] is known only at run time; assume: {\"R[50]\": …}"];
    for pace in ["9mm/sec", "2sec", "max_speed"] {
        assert_refused(tp(&format!("OVERRIDE=R[50] ;\nL P[2] {pace} FINE ;\n")), 7, &said);
    }
}

#[test]
fn positions_that_a_conveyor_moves_are_refused() {
    let text = |schedule: &str| {
        format!(
            "/PROG T\n/ATTR\n/APPL\n\nLINE_TRACK;\n  LINE_TRACK_SCHEDULE_NUMBER      : {schedule};\n  \
             LINE_TRACK_BOUNDARY_NUMBER      : 0;\n/MN\nL P[1] 9mm/sec FINE ;\n/POS\n{}/END\n",
            points("UF : 1, UT : 1")
        )
    };
    let of = |schedule: &str| read(text(schedule).as_bytes(), Dialect::Fanuc, &job());
    assert_eq!(of("0").unwrap().moves.len(), 1);
    for schedule in ["1", "2 "] {
        assert_refused(of(schedule), 6, &["the positions move with a conveyor"]);
    }
}

#[test]
fn conditions_that_are_watched_are_a_doubt() {
    let found = tp("MONITOR SPMON ;\nL P[2] 9mm/sec FINE ;\nMONITOR END SPMON ;\n");
    assert_eq!(told(&found, Code::MotionLeftOut), [6]);
    assert!(found.unwrap().warnings.iter().any(|note| note.what.starts_with("MONITOR SPMON: ")));
    let ended = tp("MONITOR END SPMON ;\nL P[2] 9mm/sec FINE ;\n");
    assert_eq!(told(&ended, Code::MotionLeftOut), NONE);
}

#[test]
fn registers_give_the_numbers_of_others() {
    const MOVE: &str = "100mm/sec FINE ;\n";
    let corner = [100.0, 0.0, 0.0];
    for statements in [
        format!("R[1]=2 ;\nPR[2]=P[2] ;\nL PR[R[1:no]:there] {MOVE}"),
        format!("R[1]=2 ;\nPR[2]=P[R[1]] ;\nL PR[2] {MOVE}"),
        format!("R[1]=2 ;\nPR[R[1]]=P[2] ;\nL PR[2] {MOVE}"),
        format!("R[1]=2 ;\nL P[R[1]:there] {MOVE}"),
        format!("R[1]=3 ;\nR[R[1]]=2 ;\nL P[R[R[1]]] {MOVE}"),
        format!("R[40]=1 ;\nPR[1]=P[1] ;\nPR[1,R[40:axis]:x]=100 ;\nL PR[1] {MOVE}"),
        format!("R[1]=3 ;\nPR[R[1]]=P[1] ;\nPR[R[1],1]=PR[3,R[1]]+100 ;\nL PR[3] {MOVE}"),
        "R[1]=7 ;\nPR[7]=P[2]-P[1] ;\nL P[1] 9mm/sec FINE Offset,PR[R[1]] ;\n".to_owned(),
    ] {
        let found = tp(&statements);
        assert_goes(&found, &[corner]);
    }
    let loops = tp(&format!("FOR R[1]=2 TO 4 ;\nL P[R[1]] {MOVE}ENDFOR ;\n"));
    assert_goes(&loops, &[corner, [100.0, 100.0, 0.0], [0.0, 100.0, 0.0]]);
    // What the job assumes gives numbers, too.
    let assumed = with(&format!("L P[R[1]] {MOVE}"), &assuming("r[1]", 2.0));
    assert_goes(&assumed, &[corner]);
    let hint = ["R[1] is known only at run time; assume: {\"R[1]\": …} in the job"];
    for statement in ["L PR[R[1]] 9mm/sec FINE", "L P[R[1]] 9mm/sec FINE", "PR[R[1]]=P[2]"] {
        assert_refused(tp(&format!("{statement} ;\n")), 6, &hint);
    }
    for statement in ["PR[1,R[1]]=50", "R[R[1]]=50", "UFRAME[R[1]]=PR[1]"] {
        assert_refused(tp(&format!("{statement} ;\n")), 6, &hint);
    }
    // A position of that number is not taught.
    assert_refused(tp("R[1]=8 ;\nL P[R[1]] 9mm/sec FINE ;\n"), 7, &["P[8] is not in /POS"]);
    assert_refused(tp("R[1]=1.5 ;\nL P[R[1]] 9mm/sec FINE ;\n"), 7, &["expected a whole number"]);
}

/// Sets elements of PR[1] one by one.
fn elements(values: &[f64]) -> String {
    let each = |(index, value): (usize, &f64)| format!("PR[1,{}]={value} ;\n", index + 1);
    values.iter().enumerate().map(each).collect()
}

#[test]
fn six_elements_make_a_position() {
    let shift = elements(&[10.0, 20.0, 5.0, 0.0, 0.0, 0.0]);
    let found = tp(&format!(
        "{shift}L P[2] 9mm/sec FINE Offset,PR[1] ;\nL P[3] 9mm/sec FINE Tool_Offset,PR[1] ;\n"
    ));
    // The tool looks down: its y and z axes are those of the frame turned over.
    assert_goes(&found, &[[110.0, 20.0, 5.0], [110.0, 80.0, -5.0]]);
    assert_eq!(told(&found, Code::Assumed).last(), Some(&12));
    let target = elements(&[10.0, 20.0, 5.0, 180.0, 0.0, 0.0]);
    let found = tp(&format!("{target}L PR[1] 9mm/sec FINE ;\n"));
    assert_goes(&found, &[[10.0, 20.0, 5.0]]);
    let up = end(&found.as_ref().unwrap().moves[0]).1.rotation * nalgebra::Vector3::z();
    assert!((up + nalgebra::Vector3::z()).norm() < 1e-9, "{up}");
    assert_eq!(told(&found, Code::AxisIgnored), NONE);
    // In joints it would be another place.
    assert_eq!(told(&found, Code::UnitAssumed), [12]);
    // How the arm stands there in the joints is not said.
    let found = tp(&format!("{target}J PR[1] 9% FINE ;\n"));
    assert_eq!(told(&found, Code::AxisIgnored), [12]);
    let five = elements(&[10.0, 20.0, 5.0, 180.0, 0.0]);
    let found = tp(&format!("{five}L PR[1] 9mm/sec FINE ;\n"));
    assert_refused(found, 11, &["PR[1] is known only at run time", "does not set its element 6"]);
    let found = tp(&format!("{five}PR[1,6]=R[9] ;\nL PR[1] 9mm/sec FINE ;\n"));
    assert_refused(found, 12, &["PR[1] is known only at run time", "R[9] is known only"]);
    // Joints stay joints.
    let found = tp(&format!("PR[1]=JPOS ;\n{target}L PR[1] 9mm/sec FINE ;\n"));
    assert_refused(found, 13, &["a line or arc to joint positions"]);
    let found = tp(&format!("PR[1]=JPOS ;\n{target}J PR[1] 9% FINE ;\n")).unwrap();
    assert_eq!(end(&found.moves[0]).0, 'J');
}

/// What the job assumes of a register is zero for offsets, not a place to go to.
#[test]
fn a_target_is_not_what_is_assumed() {
    let job = assuming("pr[1]", 0.0);
    let said = ["counts for offsets only", "the job gives them: assume: {\"PR[1,1]\""];
    assert_refused(with("L PR[1] 9mm/sec FINE ;\n", &job), 6, &said);
    let one = "PR[1,1]=PR[1,1]+100 ;\n";
    assert_refused(with(&format!("{one}L PR[1] 9mm/sec FINE ;\n"), &job), 7, &said);
    assert_refused(
        with(&format!("{one}PR[2]=PR[1] ;\nL PR[2] 9mm/sec FINE ;\n"), &job),
        8,
        &["PR[2] comes of PR[1]: ", "assume: {\"PR[1,1]\""],
    );
    let offset = with(&format!("{one}L P[1] 9mm/sec FINE Offset,PR[1] ;\n"), &job);
    assert_goes(&offset, &[[100.0, 0.0, 0.0]]);
    // Added to what is known, and where the program sets all of it.
    let sum = with(&format!("{one}PR[2]=P[3]+PR[1] ;\nL PR[2] 9mm/sec FINE ;\n"), &job);
    assert_goes(&sum, &[[200.0, 100.0, 0.0]]);
    // Nor a frame.
    let frame = with(&format!("{one}UFRAME[1]=PR[1] ;\n"), &job);
    assert_refused(frame, 7, &["UFRAME[1] is set to PR[1]", said[0]]);
    let all = elements(&[1.0, 2.0, 3.0, 180.0, 0.0, 0.0]);
    assert_goes(&with(&format!("{all}L PR[1] 9mm/sec FINE ;\n"), &job), &[[1.0, 2.0, 3.0]]);
}

/// Elements that the job gives, mm; the others are zero by its word.
#[test]
fn the_job_gives_elements_of_a_register() {
    let mut job = assuming("pr[14]", 0.0);
    job.assume.insert("pr[14,3]".to_owned(), Assumed::Number(70.0));
    job.assume.insert("pr[14,2]".to_owned(), Assumed::Number(-30.0));
    let shift = "L P[2] 100mm/sec FINE Offset,PR[14:offset] ;\n";
    assert_goes(&with(shift, &job), &[[100.0, -30.0, 70.0]]);
    job.assume.remove("pr[14]");
    assert_refused(with(shift, &job), 6, &["assume: {\"PR[14]\": 0}", "{\"PR[14,3]\": …}"]);
    // All six make a place.
    for (index, value) in (1..).zip([100.0, 0.0, 0.0, 180.0, 0.0, 0.0]) {
        job.assume.insert(format!("pr[5,{index}]"), Assumed::Number(value));
    }
    assert_goes(&with("L PR[5] 100mm/sec FINE ;\n", &job), &[[100.0, 0.0, 0.0]]);
}

/// A label by an argument may be any: what stands behind such a jump may be gone to.
#[test]
fn a_jump_to_a_label_by_an_argument() {
    let statements = "JMP LBL[AR[1]] ;\nLBL[1] ;\nL P[2] 100mm/sec FINE ;\n";
    let found = with(statements, &assuming("ar[1]", 1.0));
    assert_goes(&found, &[[100.0, 0.0, 0.0]]);
    assert_eq!(told(&found, Code::MotionLeftOut), NONE);
}

#[test]
fn select_goes_where_the_register_says() {
    let select = "SELECT R[1:part]=1,JMP LBL[1] ;\n       =2,JMP LBL[2] ;\n!other ;\n       \
                  =R[3],CALL OTHER ;\n       ELSE,JMP LBL[9] ;\n";
    let branches = "L P[4] 9mm/sec FINE ;\nJMP LBL[9] ;\nLBL[1] ;\nL P[2] 9mm/sec FINE ;\n\
                    JMP LBL[9] ;\nLBL[2] ;\nL P[3] 9mm/sec FINE ;\nLBL[9] ;\n";
    let of = |value: f64| tp(&format!("R[3]=7 ;\nR[1]={value} ;\n{select}{branches}"));
    let [second, third, fourth] = [[100.0, 0.0, 0.0], [100.0, 100.0, 0.0], [0.0, 100.0, 0.0]];
    assert_goes(&of(1.0), &[second]);
    assert_goes(&of(2.0), &[third]);
    assert_goes(&of(7.0), &[fourth]);
    assert!(of(7.0).unwrap().warnings.iter().any(|n| n.what.starts_with("CALL OTHER: ")));
    let last = "L P[2] 9mm/sec FINE ;\n";
    assert_goes(&tp(&format!("R[3]=7 ;\nR[1]=5 ;\n{select}{branches}{last}")), &[second]);
    // No case, and none of the others.
    let without = "R[1]=3 ;\nSELECT R[1]=1,JMP LBL[9] ;\n=2,JMP LBL[9] ;\n";
    assert_goes(&tp(&format!("{without}{last}LBL[9] ;\n")), &[second]);
    // One error, whatever the cases say.
    let hint = ["SELECT decides at run time: R[1] is known only", "assume: {\"R[1]\": …}"];
    assert_refused(tp(&format!("R[3]=7 ;\n{select}{branches}")), 7, &hint);
}

#[test]
fn a_loop_that_select_or_an_element_ends_is_run() {
    let next = "L P[2] 9mm/sec FINE ;\nR[1]=R[1]+1 ;\n";
    let counted = format!(
        "R[1]=0 ;\nLBL[1] ;\n{next}SELECT R[1]=3,JMP LBL[9] ;\n=4,JMP LBL[9] ;\nJMP LBL[1] ;\nLBL[9] ;\n"
    );
    let found = tp(&counted);
    assert_eq!(
        (found.as_ref().unwrap().moves.len(), told(&found, Code::MotionLeftOut)),
        (3, vec![])
    );
    let raised = "PR[1]=P[1] ;\nLBL[1] ;\nPR[1,3]=PR[1,3]+10 ;\nL PR[1] 9mm/sec FINE ;\n\
                  IF PR[1,3]>=30,JMP LBL[9] ;\nJMP LBL[1] ;\nLBL[9] ;\n";
    assert_goes(&tp(raised), &[[0.0, 0.0, 10.0], [0.0, 0.0, 20.0], [0.0, 0.0, 30.0]]);
}

#[test]
fn frames_of_the_job_are_known_to_registers() {
    let moved =
        "PR[1]=UFRAME[1] ;\nPR[1,1]=PR[1,1]+10 ;\nUFRAME[1]=PR[1] ;\nL P[2] 9mm/sec FINE ;\n";
    assert_goes(&tp(moved), &[[110.0, 0.0, 0.0]]);
    let longer = "PR[1]=UTOOL[1] ;\nPR[1,3]=PR[1,3]+5 ;\nUTOOL[1]=PR[1] ;\nL P[2] 9mm/sec FINE ;\n";
    let tcp = tp(longer).unwrap().moves[0].tcp;
    assert!((tcp.translation.vector.z - 0.155).abs() < 1e-12, "{tcp}");
    // Turned frames come back as they were.
    let turned = pose([1000.0, 0.0, 0.0], [0.9, 0.1, -0.3, 0.3]);
    let mut job = job();
    job.base_frames.insert(1, turned);
    let found = with("PR[1]=UFRAME[1] ;\nUFRAME[1]=PR[1] ;\nL P[2] 9mm/sec FINE ;\n", &job);
    let straight = with("L P[2] 9mm/sec FINE ;\n", &job).unwrap();
    let [found, straight] = [found.unwrap(), straight].map(|found| end(&found.moves[0]).1);
    super::support::assert_pose(&found, &straight);
    let said = ["UFRAME[3] is in no file that is read", "base_frames: {3: …}"];
    assert_refused(tp("PR[1]=UFRAME[3] ;\nUFRAME[1]=PR[1] ;\n"), 7, &said);
}

#[test]
fn the_place_of_the_last_move_is_known_behind_a_stop() {
    let retract = "PR[5]=LPOS ;\nPR[5,3]=PR[5,3]+50 ;\nL PR[5] 9mm/sec FINE ;\n";
    let to = "L P[2] 9mm/sec FINE ;\n";
    let there = [100.0, 0.0, 0.0];
    let found = tp(&format!("{to}{retract}"));
    assert_goes(&found, &[there, [100.0, 0.0, 50.0]]);
    let [from, up] = [0, 1].map(|i| end(&found.as_ref().unwrap().moves[i]).1.rotation);
    assert!(from.angle_to(&up) < 1e-9);
    // In the frames that are chosen where it is read.
    // A tool that is 100 mm longer and looks down ends 100 mm lower.
    let other = format!("{to}UFRAME_NUM=2 ;\nUTOOL_NUM=2 ;\n{retract}");
    assert_goes(&tp(&other), &[there, [100.0, 0.0, -50.0]]);
    let value =
        format!("{to}UFRAME_NUM=2 ;\nPR[5]=LPOS ;\nUFRAME_NUM=1 ;\nL PR[5] 9mm/sec FINE ;\n");
    assert_goes(&tp(&value), &[there, [-100.0, 0.0, 0.0]]);
    for (before, why) in [
        ("L P[2] 9mm/sec CNT100 ;\n", "behind a move without FINE"),
        ("J P[5] 9% FINE ;\n", "behind a move to joints"),
    ] {
        let mut job = job();
        job.j3_from = Some(detune::program::J3From::UpperArm);
        let found = with(&format!("{before}{retract}"), &job);
        assert_refused(found, 9, &["PR[5] is known only at run time", "LPOS", why]);
    }
    let first = whole(&format!("UFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\n{retract}"), "", &job());
    assert_refused(first, 7, &["LPOS before the first move"]);
}

#[test]
fn joints_are_known_behind_a_move_to_joints() {
    let mut job = job();
    job.j3_from = Some(detune::program::J3From::Horizontal);
    let back = "PR[6]=JPOS ;\nPR[6,6]=PR[6,6]-15 ;\nJ PR[6] 9% FINE ;\n";
    let found = with(&format!("J P[5] 9% FINE ;\n{back}"), &job).unwrap();
    let degrees = found.moves.iter().map(|each| match &each.to {
        detune::motion::Target::Joints(q) => q.iter().map(|q| q.to_degrees().round()).collect(),
        _ => vec![],
    });
    let expected = [[10.0, 20.0, 50.0, 40.0, 50.0, 60.0], [10.0, 20.0, 50.0, 40.0, 50.0, 45.0]];
    assert_eq!(degrees.collect::<Vec<_>>(), expected);
    let found = with(&format!("L P[2] 9mm/sec FINE ;\n{back}"), &job);
    assert_refused(found, 9, &["JPOS behind a move to a pose is known only at run time"]);
}

#[test]
fn positions_are_added_element_by_element() {
    let sum = |set: &str| tp(&format!("{set} ;\nL PR[3] 9mm/sec FINE ;\n"));
    let copies = "PR[1]=P[3] ;\nPR[2]=P[2] ;\n";
    assert_goes(&sum(&format!("{copies}PR[3]=PR[1]+PR[2]")), &[[200.0, 100.0, 0.0]]);
    assert_goes(&sum(&format!("{copies}PR[3]=PR[1]-PR[2]+P[4]")), &[[0.0, 200.0, 0.0]]);
    // Angles add up, too: twice half a turn about x is none.
    let end = end(&sum(&format!("{copies}PR[3]=PR[1]+PR[2]")).unwrap().moves[0]).1;
    assert!(end.rotation.angle() < 1e-9, "{end}");
    // As an offset a full turn is none, and half a one is refused.
    let offset = |set: &str| tp(&format!("{set} ;\nL P[1] 9mm/sec FINE Offset,PR[3] ;\n"));
    assert_goes(&offset("PR[3]=P[2]+P[3]"), &[[200.0, 100.0, 0.0]]);
    assert_goes(&offset("PR[3]=P[3]-P[2]"), &[[0.0, 100.0, 0.0]]);
    assert_refused(offset("PR[3]=P[2]"), 7, &["turns the target"]);
    // Of what is not known, the same less itself is zero.
    assert_goes(&offset("PR[3]=PR[8]-PR[8] ;\nPR[3,1]=4"), &[[4.0, 0.0, 0.0]]);
    assert_goes(
        &offset("L P[1] 9mm/sec CNT9 ;\nPR[3]=LPOS-LPOS ;\nPR[3,1]=4"),
        &[[0.0; 3], [4.0, 0.0, 0.0]],
    );
    for (set, why) in [
        ("PR[3]=PR[8]+P[1]", "assume: {\"PR[8]\": 0}"),
        ("PR[3]=P[1]+P[5]", "adds a pose and joints"),
        ("PR[3]=P[1]*2", "'*2' is not understood"),
        ("PR[3]=VR[1].OFFSET", "VR[1].OFFSET is what vision finds; assume: {\"VR[1]\": 0}"),
    ] {
        assert_refused(sum(set), 7, &["PR[3] is known only at run time", why]);
    }
    // Joints likewise.
    let mut job = job();
    job.j3_from = Some(detune::program::J3From::UpperArm);
    let found = with("PR[3]=P[5]-P[5]+P[5]+P[5] ;\nJ PR[3] 9% FINE ;\n", &job).unwrap();
    let detune::motion::Target::Joints(q) = &found.moves[0].to else { panic!("joints") };
    assert!((q[5].to_degrees() - 120.0).abs() < 1e-9, "{q:?}");
}

/// E1 is a value of the position, too.
#[test]
fn external_axes_go_with_registers() {
    let rail = |number: u32, x: f64, e1: f64| {
        point(number, [x, 0.0, 0.0], "UF : 1, UT : 1")
            .replace("\n};", &format!(",\n\tE1 = {e1} mm\n}};"))
    };
    let points = [rail(1, 0.0, 100.0), rail(2, 50.0, 300.0)].concat();
    let mut job = job();
    let axis = detune::program::ExternalAxis { joint: 0, slides: true };
    job.external_axes.insert("e1".to_owned(), axis);
    job.joint_count = 7;
    let at_rail = |statements: &str| -> Vec<f64> {
        let found = whole(&format!("L P[1] 9mm/sec FINE ;\n{statements}"), &points, &job);
        let found = found.unwrap_or_else(|found| panic!("{statements}: {found:?}"));
        found.moves.iter().map(|each| each.stated.external[0].1).collect()
    };
    // An assignment moves nothing; the move does.
    let copied = "PR[1]=P[2] ;\nL P[1] 9mm/sec FINE ;\nL PR[1] 9mm/sec FINE ;\n";
    assert_eq!(at_rail(copied), [0.1, 0.1, 0.3]);
    let added = "PR[1]=LPOS ;\nPR[1,7]=PR[1,7]+50 ;\nL PR[1] 9mm/sec FINE ;\n";
    assert_eq!(at_rail(added), [0.1, 0.15]);
    let six = elements(&[1.0, 2.0, 3.0, 180.0, 0.0, 0.0]);
    let text = format!("L P[1] 9mm/sec FINE ;\n{six}L PR[1] 9mm/sec FINE ;\n");
    let found = whole(&text, &points, &job);
    assert_eq!(told(&found, Code::AxisIgnored), [10]);
    let shifted = "L P[1] 9mm/sec FINE ;\nPR[1]=P[2]-P[1] ;\nL P[1] 9mm/sec FINE Offset,PR[1] ;\n";
    assert_refused(whole(shifted, &points, &job), 5, &["shifts external axis e1"]);
}

#[test]
fn call_is_read_in_any_letters() {
    for call in ["CALL SUB(1)", "Call SUB(1)", "call SUB(1)", "IF (1=1),Call SUB(1)"] {
        let found = tp(&format!("{call} ;\nL P[2] 9mm/sec FINE ;\n"));
        assert_eq!(told(&found, Code::MotionLeftOut), [6], "{call}");
        assert!(found.unwrap().warnings.iter().any(|n| n.what.starts_with("CALL SUB: ")), "{call}");
    }
}

#[test]
fn speeds_that_are_not_read_say_why() {
    let mut silent = job();
    silent.feed_m_per_s = None;
    let of = |speed: &str| with(&format!("L P[2] {speed} FINE ;\n"), &silent);
    for speed in ["6000mm/min", "R[6]mm/min", "5m/sec"] {
        let unit = speed.trim_start_matches(|c: char| !c.is_lowercase());
        assert_refused(of(speed), 6, &[&format!("'{unit}' is no unit of TP")]);
    }
    let said = ["speed: R[6] is known only at run time", "feed_mm_per_min"];
    assert_refused(of("R[R[6]]mm/sec"), 6, &said);
    let assumed = tp("L P[2] R[R[6]]mm/sec FINE ;\n");
    assert_eq!(told(&assumed, Code::Assumed).last(), Some(&6));
    let known = tp("R[6]=7 ;\nR[7]=25 ;\nL P[2] R[R[6]]mm/sec FINE ;\n").unwrap();
    assert!((known.moves[0].feed_m_per_s - 0.025).abs() < 1e-12);
    assert_refused(of("9deg/sec"), 6, &["the tool does not turn"]);
}

#[test]
fn the_end_may_have_a_dot_or_blanks() {
    for end in ["/END.", "/END  ", " /END. ", "/end."] {
        let text = format!(
            "/PROG T\n/MN\nL P[1] 9mm/sec FINE ;\n/POS\n{}{end}\n",
            points("UF : 1, UT : 1")
        );
        assert_eq!(read(text.as_bytes(), Dialect::Fanuc, &job()).unwrap().moves.len(), 1, "{end}");
    }
}

#[test]
fn branches_leave_an_element_open() {
    let open = "PR[1]=P[2] ;\nIF DI[1]=ON,PR[1,3]=(2) ;\n";
    let said = ["PR[1] is known only at run time", "DI[1]"];
    assert_refused(tp(&format!("{open}L PR[1] 9mm/sec FINE ;\n")), 8, &said);
    // What the program sets behind it is known again.
    assert_goes(&tp(&format!("{open}PR[1,3]=7 ;\nL PR[1] 9mm/sec FINE ;\n")), &[[100.0, 0.0, 7.0]]);
    assert_eq!(lines(&tp("R[1]=2 ;\nL P[R[1]] 9mm/sec FINE ;\n").unwrap()), [7]);
}

#[test]
fn a_position_that_stands_twice_is_refused() {
    let twice = |x: f64| {
        let all = points("UF : 1, UT : 1") + &point(2, [x, 0.0, 0.0], "UF : 1, UT : 1");
        whole("UFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nL P[1] 9mm/sec FINE ;\n", &all, &job())
    };
    assert_refused(twice(50.0), 41, &["P[2] stands twice in /POS"]);
    assert_eq!(twice(100.0).unwrap().moves.len(), 1);
}

/// What is copied or worked out from a register is told by the register that the job can give.
#[test]
fn a_place_that_is_not_known_names_the_register_that_it_comes_of() {
    let all = "{\"PR[1,1]\": …, …, \"PR[1,6]\": …}";
    for copies in ["PR[2]=PR[1] ;\n", "PR[3]=PR[1] ;\nPR[2]=PR[3] ;\n"] {
        let text = format!("{copies}L PR[2] 9mm/sec FINE ;\n");
        let line = 6 + copies.lines().count();
        assert_refused(tp(&text), line, &["PR[1] is known only at run time", all]);
        assert_refused(with(&text, &assuming("pr[1]", 0.0)), line, &["PR[2] comes of PR[1]", all]);
        let mut job = job();
        for (index, value) in (1..).zip([100.0, 0.0, 0.0, 180.0, 0.0, 0.0]) {
            job.assume.insert(format!("pr[1,{index}]"), Assumed::Number(value));
        }
        assert_goes(&with(&text, &job), &[[100.0, 0.0, 0.0]]);
    }
    let element = "PR[2]=PR[1] ;\nPR[2,1]=PR[1,1]+5 ;\nL PR[2] 9mm/sec FINE ;\n";
    assert_refused(tp(element), 8, &["PR[1] is known only at run time", all]);
    let one = "PR[2,3]=PR[1,3] ;\nL PR[2] 9mm/sec FINE ;\n";
    assert_refused(tp(one), 7, &["PR[2] is known only at run time", "\"PR[2,6]\": …}"]);
}

#[test]
fn remarks_with_dashes_and_semicolons_in_comments() {
    let text = "-- Version: 1.1; of 2024 ;\n--eg:Go to 2 ;\nR[1:Cur;Row]=40 ;\n\
                L P[2:a;b] R[1:Cur;Row]mm/sec FINE ;\n";
    let found = tp(text);
    assert_goes(&found, &[[100.0, 0.0, 0.0]]);
    assert!((found.unwrap().moves[0].feed_m_per_s - 0.04).abs() < 1e-12);
    for remark in ["--- text --- ;", "--- a: b; c ;", "---- ;", "   9:  ---- "] {
        let text = format!("{remark}\n  10:  L P[2] 100mm/sec FINE ;\n");
        assert_goes(&tp(&text), &[[100.0, 0.0, 0.0]]);
    }
    let wrapped = "--eg:Go to\n    :  L P[3] 9mm/sec FINE ;\nL P[2] 9mm/sec FINE ;\n";
    assert_goes(&tp(wrapped), &[[100.0, 0.0, 0.0]]);
}

#[test]
fn an_offset_of_vision_is_what_the_job_says() {
    let text = "VISION RUN_FIND 'A' ;\nVISION GET_OFFSET 'A' VR[3] JMP LBL[9] ;\n\
                L P[2] 100mm/sec FINE VOFFSET,VR[3] ;\nLBL[9] ;\n";
    let found = tp(text).unwrap_err();
    assert_eq!(found.iter().map(at).collect::<Vec<_>>(), [7, 8]);
    let hint = "assume: {\"VR[3]\": 0} in the job";
    assert!(found.iter().all(|note| note.what.contains(hint)), "{found:?}");
    assert_goes(&with(text, &assuming("vr[3]", 0.0)), &[[100.0, 0.0, 0.0]]);
    assert!(with(text, &assuming("vr[3]", 5.0)).is_err());
    // Taken over by a register.
    let taken = "PR[8]=VR[3].OFFSET ;\nL P[2] 100mm/sec FINE Offset,PR[8] ;\n";
    assert_refused(tp(taken), 7, &["VR[3].OFFSET is what vision finds", hint]);
    for text in [taken, &taken.replace("OFFSET", "offset")] {
        assert_goes(&with(text, &assuming("vr[3]", 0.0)), &[[100.0, 0.0, 0.0]]);
    }
    assert_refused(tp(&taken.replace("OFFSET", "offset")), 7, &["is what vision finds", hint]);
    let mut job = assuming("pr[8]", 0.0);
    assert_goes(&with(taken, &job), &[[100.0, 0.0, 0.0]]);
    job.assume.insert("pr[8,3]".to_owned(), Assumed::Number(5.0));
    assert_goes(&with(taken, &job), &[[100.0, 0.0, 5.0]]);
    let found = "PR[8]=VR[3].FOUND_POS[1] ;\nL PR[8] 100mm/sec FINE ;\n";
    let said = ["VR[3].FOUND_POS[1] is what vision finds; assume: {\"PR[8,1]\": …"];
    assert_refused(tp(found), 7, &said);
    assert_goes(&with(found, &placing(8, [9.0, 0.0, 5.0, 180.0, 0.0, 0.0])), &[[9.0, 0.0, 5.0]]);
    let passed = "VISION GET_PASSFAIL 'A' R[1] ;\n";
    assert_refused(tp(passed), 6, &["what vision gives is known only at run time"]);
}

#[test]
fn a_listing_in_another_language_is_told_once() {
    let head = "/PROG T\n/ATTR\nEIGN. = AUROM;\nDEFAULT_GRUP = 1,*,*,*,*;\n/MN\n";
    let text = format!(
        "{head}   1:  WKZ_NUM=1 ;\n   2:  BENUTZER_NUM=0 ;\n   3:L P[1] 9mm/sek CNT0 ;\n/POS\n{}/END\n",
        points("UF : 1, UT : 1")
    );
    let found = read(text.as_bytes(), Dialect::Fanuc, &job()).unwrap_err();
    assert_eq!((found.len(), at(&found[0])), (1, 4), "{found:?}");
    assert!(found[0].what.contains("another language than English"), "{found:?}");
    let english = head.replace("DEFAULT_GRUP", "DEFAULT_GROUP");
    let english = english.replace("/MN", "LOCK_GROUP = 1,*,*,*,*;\n/MN");
    let text = format!("{english}L P[1] 9mm/sec FINE ;\n/POS\n{}/END\n", points("UF : 1, UT : 1"));
    assert_eq!(read(text.as_bytes(), Dialect::Fanuc, &job()).unwrap().moves.len(), 1);
}

/// Where the arm stands before its first move only the run knows; behind a corner the job may mean
/// another place.
#[test]
fn the_job_gives_a_register_that_is_set_to_where_the_arm_is() {
    let start = |statements: &str, job: &Settings| {
        let text = format!("UFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\n{statements}");
        whole(&text, &points("UF : 1, UT : 1"), job)
    };
    let lowered = "PR[6]=LPOS ;\nPR[6,3]=PR[6,3]-85 ;\nL PR[6] 100mm/sec FINE ;\n";
    let given = placing(6, [100.0, 0.0, 90.0, 180.0, 0.0, 0.0]);
    assert_goes(&start(lowered, &given), &[[100.0, 0.0, 5.0]]);
    let all = "assume: {\"PR[6,1]\": …, …, \"PR[6,6]\": …} in the job gives the place: ";
    let said = ["LPOS before the first move is known only at run time; ", all, "X, Y, Z in mm"];
    assert_refused(start(lowered, &job()), 7, &said);
    // What the program knows counts, and what has served before does not serve again.
    assert_goes(&with("PR[6]=LPOS ;\nL PR[6] 9mm/sec FINE ;\n", &given), &[[0.0; 3]]);
    let corner = "L P[2] 9mm/sec CNT50 ;\nPR[6]=LPOS ;\nL PR[6] 9mm/sec FINE ;\n";
    let unstopped = with(corner, &given).unwrap_err();
    assert!(unstopped[0].what.contains("LPOS behind a move without FINE"), "{unstopped:?}");
    assert!(!unstopped[0].what.contains("assume"), "{unstopped:?}");
    for before in ["PR[6]=LPOS", "R[5]=PR[6,1]", "PR[6,1]=5"] {
        let again = format!("{before} ;\nPR[6]=LPOS ;\nL PR[6] 9mm/sec FINE ;\n");
        let said = ["what assume: in the job gives of PR[6] has served before"];
        assert_refused(start(&again, &given), 7, &said);
    }
    let sum = start("PR[6]=LPOS+PR[7] ;\nL PR[6] 9mm/sec FINE ;\n", &job());
    assert_refused(sum, 6, &["set a PR[n] to LPOS alone", "assume: {\"PR[n,1]\""]);
    // Joints are joints.
    let turned = "PR[6]=JPOS ;\nPR[6,6]=PR[6,6]-15 ;\nJ PR[6] 9% FINE ;\n";
    let mut given = placing(6, [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]);
    given.j3_from = Some(detune::program::J3From::UpperArm);
    let found = start(turned, &given).unwrap();
    let detune::motion::Target::Joints(q) = &found.moves[0].to else { panic!("joints") };
    let degrees: Vec<f64> = q.iter().map(|q| q.to_degrees().round()).collect();
    assert_eq!(degrees, [10.0, 20.0, 30.0, 40.0, 50.0, 45.0]);
    assert_refused(start(turned, &job()), 7, &["JPOS before", all, "J1 to J6 in degrees"]);
}

#[test]
fn options_that_turn_the_wrist_otherwise_are_a_doubt() {
    let doubted = |text: &str| told(&tp(&format!("{text} ;\n")), Code::AxisIgnored);
    for text in [
        "L P[2] 9mm/sec FINE Wjnt",
        "L P[2] 9mm/sec FINE WJNT,ACC50",
        "C P[2]\n : P[3] 9mm/sec CNT50 WJNT ACC50",
    ] {
        assert_eq!(doubted(text), [6], "{text}");
    }
    for text in [
        "L P[2] 9mm/sec FINE",
        "J P[2] 9% FINE Wjnt",
        "J P[5] 9% FINE MROT",
        // The tool does not turn.
        "J P[2] 9% FINE MROT",
    ] {
        assert_eq!(doubted(text), NONE, "{text}");
    }
    let turned = points("UF : 1, UT : 1").replacen("R = 0.000", "R = 90.000", 1);
    let found = whole("L P[1] 9mm/sec FINE ;\nJ P[2] 9% FINE MROT ;\n", &turned, &job());
    assert_eq!(told(&found, Code::AxisIgnored), [4]);
    // Behind joints it is not known whether it does.
    assert_eq!(doubted("J P[5] 9% FINE ;\nJ P[2] 9% FINE MROT"), [7]);
    // On the way to where the path starts nothing is checked.
    let first = whole("L P[1] 9mm/sec FINE Wjnt ;\n", &points("UF : 1, UT : 1"), &job());
    assert_eq!(told(&first, Code::AxisIgnored), NONE);
    let asks = |text: &str| {
        let asked = tp(text).unwrap().moves[0].stated.configuration.clone();
        asked.is_some_and(|asked| !asked.joints.is_empty())
    };
    assert!(asks("J P[2] 9% FINE ;\n") && !asks("J P[2] 9% FINE MROT ;\n"));
}

#[test]
fn a_move_that_a_condition_may_end_is_refused() {
    let skipped = tp("L P[2] 9mm/sec FINE Skip,LBL[9] ;\nLBL[9] ;\n");
    let said = ["SKIP CONDITION may end the move before its target", "without Skip"];
    assert_refused(skipped, 6, &said);
}
