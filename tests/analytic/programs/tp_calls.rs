//! Fanuc TP: programs that others CALL, in the same listing or in further files, with arguments, and what holds behind
//! them. Places and times are worked out by hand from the positions.

use detune::motion::{Spindle, Timing};
use detune::notes::{Class, Note};
use detune::program::{Assumed, Companion, Dialect, Program, SetBy, Setter, Settings, read};

use super::support::{at, end, pose, settings};

type Read = Result<Program, Vec<Note>>;

const NONE: [(usize, String); 0] = [];

fn position(number: u32, frame: u32, [x, y, z]: [f64; 3]) -> String {
    format!(
        "P[{number}]{{\n GP1:\n UF : {frame}, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n X = {x} mm, Y = {y} mm, Z = {z} \
         mm, W = 180 deg, P = 0 deg, R = 0 deg\n}};\n"
    )
}

/// Statements from line 3 on; P[1] at 0, P[2] at X 100 and P[3] at Y 100 of frame 1.
fn listing(name: &str, statements: &str) -> String {
    let points = [[0.0; 3], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0]];
    let points: Vec<String> =
        (1..).zip(points).map(|(number, at)| position(number, 1, at)).collect();
    format!("/PROG  {name}\n/MN\n{statements}/POS\n{}/END\n", points.concat())
}

fn job(files: &[(&str, &str)]) -> Settings {
    let upright = [1.0, 0.0, 0.0, 0.0];
    let mut job = settings();
    for (number, x) in [(1, 1000.0), (2, 2000.0)] {
        job.base_frames.insert(number, pose([x, 0.0, 0.0], upright));
        job.tool_frames.insert(number, pose([0.0, 0.0, 150.0], upright));
    }
    job.companions = files
        .iter()
        .map(|(name, text)| Companion { name: (*name).to_owned(), text: (*text).to_owned() })
        .collect();
    job
}

const START: &str = "UFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nL P[1] 100mm/sec FINE ;\n";

fn with(statements: &str, job: &Settings) -> Read {
    read(listing("MAIN", &format!("{START}{statements}")).as_bytes(), Dialect::Fanuc, job)
}

/// X and Y at the end of each move behind the first, mm, from the origin of frame 1.
#[track_caller]
fn places(found: &Read) -> Vec<[f64; 2]> {
    let found = found.as_ref().unwrap_or_else(|found| panic!("{found:?}"));
    let of = |each| {
        let at = end(each).1.translation;
        [at.x - 1.0, at.y].map(|m| (m * 1e6).round() / 1e3)
    };
    found.moves.iter().skip(1).map(of).collect()
}

fn doubts(found: &Read) -> Vec<(usize, String)> {
    let found = found.as_ref().unwrap_or_else(|found| panic!("{found:?}"));
    let told = found.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    told.map(|note| (at(note), note.what.clone())).collect()
}

#[track_caller]
fn refused(found: Read, line: usize, said: &str) {
    let found = found.expect_err(said);
    assert_eq!(at(&found[0]), line, "{found:?}");
    assert!(found[0].what.contains(said), "{said}: {found:?}");
}

/// P[2] is each program's own; what is behind the call counts where the called one has ended.
#[test]
fn a_called_program_moves_to_its_own_positions() {
    let sub = "L P[3] 50mm/sec FINE ;\nL P[2] 25mm/sec FINE ;\n";
    let own = position(2, 1, [0.0, 0.0, 0.0]);
    let other = listing("SUB", sub).replace(&own, &position(2, 1, [7.0, 8.0, 0.0]));
    let job = job(&[(
        "sub.ls",
        &other.replace(&position(2, 1, [100.0, 0.0, 0.0]), &position(2, 1, [7.0, 8.0, 0.0])),
    )]);
    let found = with("CALL SUB ;\nL P[2] 10mm/sec FINE ;\n", &job);
    assert_eq!(places(&found), [[0.0, 100.0], [7.0, 8.0], [100.0, 0.0]]);
    assert_eq!(doubts(&found), NONE);
    let moves = &found.unwrap().moves;
    let feeds: Vec<f64> = moves[1..].iter().map(|each| each.feed_m_per_s).collect();
    assert_eq!(feeds, [0.05, 0.025, 0.01]);
    // Moves of another file stand at the line that calls them.
    assert_eq!(moves.iter().map(|each| each.line).collect::<Vec<_>>(), [5, 6, 6, 7]);
}

/// Two listings in one file: the second keeps its own lines, and its numbers can be written.
#[test]
fn a_second_listing_of_the_file_is_called_too() {
    let main = listing("MAIN", &format!("{START}CALL sub(50) ;\n"));
    let text =
        format!("{main}{}", listing("SUB", "L P[2] AR[1]mm/sec FINE ;\nL P[3] 20mm/sec FINE ;\n"));
    let found = read(text.as_bytes(), Dialect::Fanuc, &job(&[]));
    assert_eq!(places(&found), [[100.0, 0.0], [0.0, 100.0]]);
    assert_eq!(doubts(&found), NONE);
    let before = main.lines().count();
    let lines: Vec<usize> = found.unwrap().moves.iter().map(|each| each.line).collect();
    assert_eq!(lines, [5, before + 3, before + 4]);
    // One that nothing calls is a doubt.
    let text = format!("{}{}", listing("MAIN", START), listing("SUB", "L P[2] 9mm/sec FINE ;\n"));
    let found = read(text.as_bytes(), Dialect::Fanuc, &job(&[]));
    assert_eq!(doubts(&found).len(), 1, "{:?}", doubts(&found));
}

/// Registers, frames and the override stay as a called program leaves them; labels, loops, arguments and its
/// OFFSET CONDITION are its own.
#[test]
fn what_holds_behind_a_call_is_what_the_called_program_left() {
    let sub = "R[1]=AR[1]*2 ;\nPR[7]=LPOS ;\nPR[7,1]=AR[2] ;\nPR[7,2]=R[2] ;\nLBL[1] ;\nR[3]=R[3]+1 ;\n\
               IF R[3]<3,JMP LBL[1] ;\nOVERRIDE=50% ;\nEND ;\nL P[3] 1mm/sec FINE ;\n";
    let files = [("a/sub.ls", listing("SUB", sub))];
    let job = job(&files.each_ref().map(|(name, text)| (*name, text.as_str())));
    let found = with(
        "R[2]=4 ;\nR[3]=0 ;\nCALL SUB(10,R[2]+1) ;\nLBL[1] ;\nL PR[7] R[1]mm/sec FINE ;\n\
         WAIT R[3](sec) ;\n",
        &job,
    );
    // The wait stands where the move has ended.
    assert_eq!(places(&found), [[5.0, 4.0]; 2]);
    // What stands behind END in it is told, with its own line.
    let told = doubts(&found);
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(
        told[0].0 == 8 && told[0].1.starts_with("a/sub.ls:11: ") || told[0].1.contains("END"),
        "{told:?}"
    );
    let moves = &found.unwrap().moves;
    assert_eq!(moves[1].feed_m_per_s, 0.01);
    assert!(moves.iter().any(|each| each.timing == Timing::Seconds(3.0)), "{moves:?}");

    let shifts = listing(
        "SHIFT",
        "PR[1]=LPOS ;\nPR[1,1]=0 ;\nPR[1,2]=0 ;\nPR[1,3]=9 ;\nOFFSET CONDITION PR[1] ;\n",
    );
    let job = self::job(&[("shift.ls", &shifts)]);
    refused(
        with("CALL SHIFT ;\nL P[2] 9mm/sec FINE Offset ;\n", &job),
        7,
        "behind no OFFSET CONDITION",
    );
}

/// A feed in another file is not written there, and what is wrong in it is told with its place.
#[test]
fn faults_of_another_file_are_told_at_the_line_that_calls() {
    let sub = listing("SUB", "R[1]=1 ;\nL P[9] 9mm/sec FINE ;\n");
    let job = job(&[("sub.ls", &sub)]);
    let found = with("CALL SUB ;\n", &job).unwrap_err();
    assert_eq!((at(&found[0]), found[0].what.as_str()), (6, "sub.ls:4: P[9] is not in /POS"));
    for (text, said) in [
        (sub.replace("/END", ""), "sub.ls: the program ends without /END"),
        (sub.replace("R[1]=1 ;", "FOR R[1]=1 TO 3 ;"), "sub.ls: FOR has no ENDFOR"),
        (listing("SUB", "CALL SUB ;\n"), "calls are nested too deep"),
    ] {
        refused(with("CALL SUB ;\n", &self::job(&[("sub.ls", &text)])), 6, said);
    }
    let twice = [("a.ls", sub.as_str()), ("b.ls", sub.as_str())];
    refused(with("CALL SUB ;\n", &self::job(&twice)), 6, "a.ls and b.ls have that name");
    // The call gives two arguments at most.
    let asks = listing("SUB", "L P[2] AR[3]mm/sec FINE ;\n");
    let asks = Settings { feed_m_per_s: None, ..self::job(&[("sub.ls", &asks)]) };
    refused(with("CALL SUB(1,2) ;\n", &asks), 6, "the call gives no AR[3], of 2 arguments");
}

/// A program that moves nothing may be called in a branch that only the run decides: what it sets is known no longer.
#[test]
fn a_quiet_program_may_be_called_or_not() {
    let sub = listing("GRIP", "DO[5]=ON ;\nWAIT DI[6]=ON ;\nR[4]=7 ;\nEND ;\n");
    let files = [("grip.ls", sub.as_str())];
    let text = "R[4]=5 ;\nIF DI[1]=ON,CALL GRIP ;\nL P[2] 9mm/sec FINE ;\n";
    let found = with(text, &job(&files));
    assert_eq!((places(&found), doubts(&found)), (vec![[100.0, 0.0]], NONE.to_vec()));
    let asked = format!("{text}IF R[4]=5,JMP LBL[1] ;\nL P[3] 9mm/sec FINE ;\nLBL[1] ;\n");
    refused(with(&asked, &job(&files)), 9, "R[4] is set to what is known only at run time: DI[1]");
    // Beside a motion likewise.
    let beside = "R[4]=5 ;\nL P[2] 9mm/sec FINE TB .5sec,CALL GRIP ;\n";
    assert_eq!(doubts(&with(beside, &job(&files))), NONE);
    refused(
        with(
            &format!("{beside}L P[3] R[4]mm/sec FINE ;\n"),
            &Settings { feed_m_per_s: None, ..job(&files) },
        ),
        8,
        "R[4]",
    );
    // One that moves is a branch that decides.
    let moves = listing("GRIP", "L P[3] 9mm/sec FINE ;\n");
    refused(with(text, &job(&[("grip.ls", &moves)])), 7, "IF decides about motion at run time");
    let told = doubts(&with(beside, &job(&[("grip.ls", &moves)])));
    assert!(
        told.iter().any(|(line, what)| *line == 7 && what.contains("CALL GRIP beside a motion")),
        "{told:?}"
    );
}

/// A called program starts the spindle; a macro that the job names says it itself.
#[test]
fn the_spindle_is_what_a_called_program_makes_of_it() {
    let sub = listing("SPIN", "GO[1]=AR[1] ;\n");
    let by = |what| Some(SetBy { what, per_unit: 1.0 });
    let speeds = |job: &Settings| {
        let found = with("CALL SPIN(9000) ;\nL P[2] 9mm/sec FINE ;\n", job).unwrap();
        found.moves.last().unwrap().stated.spindle
    };
    let signal = Settings {
        spindle_from: by(Setter::Signal("GO[1]".to_owned())),
        ..job(&[("spin.ls", &sub)])
    };
    assert_eq!(speeds(&signal), Some(Spindle::Turns(Some(9000.0))));
    let named = Settings {
        spindle_from: by(Setter::Procedure("SPIN".to_owned(), 1)),
        ..job(&[("spin.ls", &sub)])
    };
    assert_eq!(speeds(&named), Some(Spindle::Turns(Some(9000.0))));
}

/// One answer of the job cannot be what a register holds before and behind a program that may set it.
#[test]
fn what_the_job_assumes_of_a_register_on_both_sides_of_an_unread_call_is_a_doubt() {
    let mut job = job(&[]);
    let numbers = [("r[6]", 20.0), ("di[3]", 1.0)]
        .map(|(name, value)| (name.to_owned(), Assumed::Number(value)));
    job.assume.extend(numbers);
    let said = |statements: &str| {
        let told = doubts(&with(statements, &job));
        let of =
            |(line, what): &(usize, String)| what.contains("before and behind").then_some(*line);
        told.iter().filter_map(of).collect::<Vec<_>>()
    };
    let by = "L P[2] R[6]mm/sec FINE ;\n";
    assert_eq!(said(&format!("{by}CALL SPD(2) ;\n{by}{by}")), [8]);
    assert_eq!(said(&format!("CALL SPD(1) ;\n{by}{by}")), Vec::<usize>::new());
    assert_eq!(said(&format!("{by}{by}CALL SPD(1) ;\n")), Vec::<usize>::new());
}

/// Blocks that do not close stop the controller.
#[test]
fn blocks_go_in_pairs() {
    const MOVE: &str = "L P[2] 9mm/sec FINE ;\n";
    for (text, line, said) in [
        (format!("FOR R[1]=1 TO 3 ;\n{MOVE}"), 6, "FOR has no ENDFOR"),
        (format!("FOR R[1]=1 TO 3 ;\n{MOVE}//ENDFOR ;\n"), 6, "FOR has no ENDFOR"),
        (format!("{MOVE}ENDFOR ;\n"), 7, "ENDFOR has no FOR"),
        (format!("IF (R[1]=1) THEN ;\n{MOVE}"), 6, "IF has no ENDIF"),
        (format!("{MOVE}ELSE ;\n{MOVE}ENDIF ;\n"), 7, "ELSE has no IF"),
        (format!("{MOVE}ENDIF ;\n"), 7, "ENDIF has no IF"),
        (
            format!("JMP LBL[1] ;\nFOR R[1]=1 TO 3 ;\nLBL[1] ;\n{MOVE}ENDFOR ;\n"),
            6,
            "leads into the FOR of line 7",
        ),
    ] {
        refused(with(&text, &job(&[])), line, said);
    }
    let whole = format!(
        "FOR R[1]=1 TO 2 ;\nIF (R[1]=1) THEN ;\n{MOVE}ELSE ;\n{MOVE}{MOVE}ENDIF ;\nENDFOR ;\n"
    );
    assert_eq!(places(&with(&whole, &job(&[]))).len(), 3);
}

/// The controller has one frame throughout, and stops at the point of another.
#[test]
fn points_of_unlike_frames_without_a_selection_are_refused() {
    let text = listing("A", "L P[1] 9mm/sec FINE ;\nL P[2] 9mm/sec FINE ;\n");
    let other =
        text.replace(&position(2, 1, [100.0, 0.0, 0.0]), &position(2, 2, [100.0, 0.0, 0.0]));
    assert!(read(text.as_bytes(), Dialect::Fanuc, &job(&[])).is_ok());
    refused(
        read(other.as_bytes(), Dialect::Fanuc, &job(&[])),
        4,
        "P[2] has UF : 2, the target before has UF : 1",
    );
}

#[test]
fn units_of_positions_are_read() {
    let in_inch = listing("A", "L P[2] 9mm/sec FINE ;\n").replace("X = 100 mm", "X = 3.937 in");
    let found = read(in_inch.as_bytes(), Dialect::Fanuc, &job(&[])).unwrap_err();
    let is_told = |note: &Note| note.what == "P[2]: X is '3.937 in', expected a number in mm";
    assert!(found.iter().any(is_told), "{found:?}");
}

/// Flags are set to (ON) on the pendant; the logic of a point that changes nothing of the motion is no doubt.
#[test]
fn forms_of_assignments_and_of_the_logic_of_points() {
    let what = Setter::Signal("DO[1]".to_owned());
    let job = Settings {
        spindle_from: Some(SetBy { what, per_unit: 1.0 }),
        spindle_rpm: Some(900.0),
        ..job(&[])
    };
    let found =
        with("DO[1]=(ON) ;\nL P[2] 9mm/sec FINE ;\nDO[1]=(OFF) ;\nL P[3] 9mm/sec FINE ;\n", &job);
    // The last move is at feed with the spindle stopped.
    assert_eq!(doubts(&found).iter().map(|(line, _)| *line).collect::<Vec<_>>(), [9]);
    let spindle: Vec<_> =
        found.unwrap().moves[1..].iter().map(|each| each.stated.spindle).collect();
    assert!(
        matches!(spindle[0], Some(Spindle::Turns(_))) && spindle[1] == Some(Spindle::Stands),
        "{spindle:?}"
    );

    let logic = |inside: &str| {
        let text = format!(
            "L P[2] 9mm/sec CNT0 TB .10sec,P-SPS ;\n{inside} ;\n  ------ ;\nL P[3] 9mm/sec FINE ;\n"
        );
        doubts(&with(&text, &job)).iter().filter(|(_, what)| what.contains("P-SPS")).count()
    };
    assert_eq!(
        ["DO[4]=ON", "R[3]=5", "DO[1]=ON", "CALL X", "OVERRIDE=50%"].map(logic),
        [0, 0, 1, 1, 1]
    );
}
