//! RAPID: procedures that run in the zone of a move; what the controller stops at; loops that a
//! jump leaves; what the messages advise.

use detune::notes::{Class, Code, Note};
use detune::program::{
    Assumed, Companion, Dialect, Program, SetBy, Setter, Settings, Spindle, read,
};

use super::support::{assert_ends, at, module, settings};

const START: &str = "MoveL p,v100,fine,tool0;";
const GO: &str = "MoveL Offs(p,100,0,0),v100,fine,tool0;";
const BY_N: &str = "MoveL Offs(p,0,n,0),v100,fine,tool0;";
const NEXT: &str = "MoveL Offs(p,0,100,0),v100,fine,tool0;";

/// The body begins on line 8; `more` stands behind the procedure.
fn run(body: &str, more: &str, job: &Settings) -> Result<Program, Vec<Note>> {
    let text = format!(
        "MODULE m\nCONST robtarget p:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
         VAR num n:=0;\nVAR num s:=100;\nVAR robtarget q;\n\
         PERS wobjdata w:=[FALSE,TRUE,\"\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n\
         PROC cut()\n{body}\nENDPROC\n{more}\nENDMODULE\n"
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

/// A synchronised move on line 9, behind the first, and what follows on line 10.
fn synced(zone: &str, procedure: &str, behind: &str) -> Program {
    let body = format!("{START}\nMoveLSync Offs(p,100,0,0),v100,{zone},tool0,\"prc\";\n{behind}");
    read_well(&body, &format!("PROC prc()\n{procedure}\nENDPROC"), &settings())
}

const LEFT_OUT: Code = Code::MotionLeftOut;

/// Technical reference manual, MoveLSync: the procedure is executed when the TCP reaches the middle
/// of the corner path, for which the next move has been worked out.
#[test]
fn a_procedure_in_a_zone_comes_behind_what_the_next_move_asks_for() {
    let end = |y: f64| [('L', [0.0; 3]), ('L', [100.0, 0.0, 0.0]), ('L', [0.0, y, 0.0])];
    for (zone, between, y, told) in [
        ("z10", "", 0.0, vec![(LEFT_OUT, 10)]),
        ("fine", "", 50.0, vec![]),
        ("z10\\Inpos:=inpos50", "", 50.0, vec![]),
        ("z10", "WaitRob\\InPos;\n", 50.0, vec![]),
        ("z10", "Stop;\n", 50.0, vec![]),
        ("z10", "WaitDI di1,1;\n", 0.0, vec![(LEFT_OUT, 11)]),
    ] {
        let found = synced(zone, "n:=50;", &format!("{between}{BY_N}"));
        assert_ends(&found, &end(y));
        assert_eq!(doubts(&found), told, "{zone} {between}");
    }
    // Behind a stop it has run.
    let found = synced("z10", "n:=50;", &format!("{NEXT}\n{BY_N}"));
    assert_ends(&found, &[&end(100.0)[..], &[('L', [0.0, 50.0, 0.0])]].concat());
    assert_eq!(doubts(&found), []);
    // Two in a row: the second counts on from the first.
    let again = "MoveLSync Offs(p,100,100,0),v100,z10,tool0,\"prc\";";
    let found = synced("z10", "n:=n+10;", &format!("{again}\n{NEXT}\n{BY_N}"));
    let y_mm = super::support::end(&found.moves[4]).1.translation.y * 1e3;
    assert!((found.moves.len(), (y_mm - 20.0).abs() < 1e-9) == (5, true), "{y_mm}");
    // By branches, speeds and frames.
    let branch = format!("IF n=50 THEN\n{GO}\nELSE\n{NEXT}\nENDIF");
    let found = synced("z10", "n:=50;", &branch);
    assert_ends(&found, &end(100.0));
    assert_eq!(doubts(&found), [(LEFT_OUT, 10)]);
    let by_s = "MoveL Offs(p,0,100,0),[s,500,5000,1000],fine,tool0;";
    let found = synced("z10", "s:=20;", by_s);
    assert!((found.moves[2].feed_m_per_s - 0.1).abs() < 1e-12);
    assert_eq!(doubts(&found), [(LEFT_OUT, 10)]);
    let in_w = "MoveL Offs(p,0,100,0),v100,fine,tool0\\WObj:=w;";
    let found = synced("z10", "w.oframe.trans.y:=70;", in_w);
    assert_ends(&found, &end(100.0));
    assert_eq!(doubts(&found), [(LEFT_OUT, 10)]);
    assert_ends(&synced("fine", "w.oframe.trans.y:=70;", in_w), &end(170.0));
    // What it uses, and the program sets meanwhile.
    let by_s = "MoveL Offs(p,0,s,0),v100,fine,tool0;";
    let found = synced("z10", "s:=n;", &format!("n:=5;\n{by_s}"));
    assert_eq!(doubts(&found), [(LEFT_OUT, 10), (LEFT_OUT, 11)]);
    assert_eq!(doubts(&synced("z10", "s:=4;", &format!("n:=5;\n{NEXT}"))), []);
}

#[test]
fn how_the_arm_moves_changes_in_a_zone_or_behind_it() {
    for (procedure, feeds) in [("VelSet 50,5000;", [0.1, 0.05]), ("SpeedRefresh 20;", [0.1, 0.02])]
    {
        let found = synced("z10", procedure, &format!("{NEXT}\n{GO}"));
        for (each, feed) in found.moves[2..].iter().zip(feeds) {
            assert!((each.feed_m_per_s - feed).abs() < 1e-12, "{procedure}: {each:?}");
        }
        assert_eq!(doubts(&found), [(LEFT_OUT, 10)], "{procedure}");
        let waits = synced("z10", procedure, &format!("WaitRob\\InPos;\n{NEXT}"));
        assert!((waits.moves[2].feed_m_per_s - feeds[1]).abs() < 1e-12, "{procedure}");
        assert_eq!(doubts(&waits), [], "{procedure}");
        // Which is last the run decides.
        let both = synced("z10", procedure, &format!("VelSet 80,5000;\nWaitRob\\InPos;\n{NEXT}"));
        assert_eq!(doubts(&both), [(LEFT_OUT, 11)], "{procedure}");
    }
    for procedure in ["GripLoad [2,[0,0,50],[1,0,0,0],0,0,0];", "ConfL\\Off;"] {
        assert_eq!(doubts(&synced("z10", procedure, NEXT)), [(LEFT_OUT, 10)], "{procedure}");
    }
    // The arm does not stop for a move in it, and the spindle is set where the move ends.
    assert_eq!(doubts(&synced("z10", GO, NEXT)), [(LEFT_OUT, 9)]);
    let what = Setter::Signal("ao1".to_owned());
    let by = Settings { spindle_from: Some(SetBy { what, per_unit: 10.0 }), ..settings() };
    let of = |behind: &str| {
        let body = format!(
            "SetAO ao1,15;\n{START}\nMoveLSync Offs(p,100,0,0),v100,z10,tool0,\"prc\";\n{behind}"
        );
        read_well(&body, "PROC prc()\nSetAO ao1,200;\nENDPROC", &by)
    };
    let found = of(NEXT);
    assert_eq!(found.spindle[1].spindle, Spindle::Turns(Some(2000.0)));
    assert_eq!((found.spindle[1].from_move, doubts(&found)), (2, vec![]));
    let found = of(&format!("SetAO ao1,100;\n{NEXT}"));
    assert_eq!(doubts(&found), [(Code::SpindleCommand, 11)]);
}

/// Technical reference manual, error handling: ERR_DIVZERO and its like stop the program where no
/// handler is.
#[test]
fn what_the_controller_stops_at_is_told() {
    let text = |statement: &str, handler: &str| {
        format!(
            "MODULE m\nCONST robtarget p:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
             VAR num n:=5;\nVAR num zero:=0;\nVAR num a{{2}};\nCONST num c:=1;\nPERS num k:=0;\n\
             PROC main()\n{START}\n{statement}\n{GO}\n{handler}\nENDPROC\nENDMODULE\n"
        )
    };
    let of = |text: &str, job: &Settings| read(text.as_bytes(), Dialect::Rapid, job);
    for (statement, said) in [
        ("n:=n/zero;", "division by zero: the controller stops here"),
        ("n:=n DIV zero;", "division by zero"),
        ("n:=n MOD zero;", "division by zero"),
        ("IF n/zero>1 TPWrite \"a\";", "division by zero"),
        ("n:=Sqrt(-1);", "Sqrt: the result for -1 is not finite"),
        ("n:=ASin(2);", "ASin"),
        ("n:=ACos(-1.5);", "ACos"),
        ("a{3}:=1;", "an index of 'a' lies beyond its end"),
        ("n:=a{3};", "an index of 'a' lies beyond its end"),
        ("a{zero}:=1;", "index 0 of 'a'"),
        ("c:=2;", "'c' is constant"),
        ("Incr c;", "'c' is constant"),
    ] {
        let found = of(&text(statement, ""), &settings()).expect_err(statement);
        assert_eq!((at(&found[0]), found.len()), (10, 1), "{statement}: {found:?}");
        assert!(found[0].what.contains(said), "{statement}: {found:?}");
    }
    // What may go on is a doubt.
    let part = Settings { procedure: Some("part".to_owned()), ..settings() };
    for (text, job) in [
        (text("n:=n/zero;", "ERROR\nTRYNEXT;"), &settings()),
        (text("n:=n/k;", ""), &settings()),
        (text("zero:=k;n:=n/zero;", ""), &settings()),
        (text("IF zero<>0 AND n/zero>1 TPWrite \"a\";", ""), &settings()),
        (text("n:=n/zero;", "").replace("main()", "part()"), &part),
    ] {
        let found = of(&text, job).unwrap_or_else(|found| panic!("{text}: {found:?}"));
        assert_eq!((found.moves.len(), doubts(&found)), (2, vec![(LEFT_OUT, 10)]), "{text}");
    }
    // Rounding may leave these.
    for statement in ["n:=ASin(1.00001);", "n:=Sqrt(-0.00001);", "n:=a{2};", "a{2}:=c;"] {
        assert_eq!(doubts(&of(&text(statement, ""), &settings()).unwrap()), [], "{statement}");
    }
}

#[test]
fn a_loop_that_a_known_jump_leaves_is_read_to_its_end() {
    let of = |first: &str, counts: &str, leaves: &str, behind: &str| {
        let body = format!(
            "VAR num i:={first};\n{START}\nWHILE TRUE DO\nMoveL Offs(p,0,10*i,0),v100,fine,tool0;\n\
             {counts}\n{leaves}\nENDWHILE\n{behind}"
        );
        let found = read_well(&body, "", &settings());
        let told: Vec<_> = found.warnings.iter().map(|note| note.what.clone()).collect();
        (found.moves.len(), doubts(&found), told.join("\n"))
    };
    for counts in ["Incr i;", "i:=i+1;"] {
        let (moves, told, _) = of("0", counts, "IF i>3 RETURN;", "");
        assert_eq!((moves, told), (5, vec![]), "{counts}");
        let (moves, told, _) = of("0", counts, "IF i>3 GOTO out;", &format!("out:\n{GO}"));
        assert_eq!((moves, told), (6, vec![]), "{counts}");
        let (moves, told, _) = of("0", counts, "IF i>3 EXIT;", "");
        assert_eq!((moves, told), (5, vec![]), "{counts}");
    }
    // Nothing that decides changes, or it comes back to what it was.
    let (moves, told, what) = of("0", "n:=n+1;", "IF i>3 RETURN;", "");
    assert_eq!((moves, told), (2, vec![(LEFT_OUT, 10)]), "{what}");
    assert!(what.contains("read once"), "{what}");
    let (moves, told, what) = of("1", "i:=3-i;", "IF i>3 RETURN;", "");
    assert_eq!((moves, told), (3, vec![(LEFT_OUT, 10)]), "{what}");
    assert!(what.contains("read 2 times"), "{what}");
    let body = format!("{START}\nWHILE TRUE DO\n{GO}\nIF DInput(di1)=1 RETURN;\nENDWHILE");
    let found = run(&body, "", &settings()).unwrap_err();
    assert!(found[0].what.contains("IF decides about motion"), "{found:?}");
}

/// Sockets, files and messages do not move: why nothing moves is the loop before the call.
#[test]
fn a_loop_before_the_moves_is_why_nothing_moves() {
    let sockets = "SocketCreate sock;\nSocketBind sock,\"127.0.0.1\",8080;\nSocketListen sock;";
    let body = format!(
        "VAR socketdev sock;\nVAR string t;\n{sockets}\nWHILE TRUE DO\nSocketReceive sock\\Str:=t;\n\
         WaitTime 1;\nENDWHILE\ngo;"
    );
    let more = format!("PROC go()\n{START}\n{GO}\nENDPROC");
    let found = run(&body, &more, &settings()).unwrap_err();
    assert_eq!((at(&found[0]), found.len()), (13, 1), "{found:?}");
    assert!(found[0].what.contains("an endless loop without a move"), "{found:?}");
    let body = format!("VAR socketdev sock;\n{START}\n{sockets}\nSocketClose sock;\n{GO}");
    assert_eq!(doubts(&read_well(&body, "", &settings())), []);
    // What a socket gives is known only at run time.
    let body =
        format!("VAR socketdev sock;\n{START}\nSocketReceiveFrom sock\\NoRecBytes:=n;\n{BY_N}");
    let found = run(&body, "", &settings()).unwrap_err();
    assert!(found[0].what.contains("SocketReceiveFrom fills in 'n'"), "{found:?}");
}

/// PERS data of one name are one datum of all tasks.
#[test]
fn another_task_gives_persistent_data_their_value() {
    let of = |own: &str, other: &str, assume: &str| {
        let text = module("MoveL p,v5,fine,tool0;\nMoveL Offs(p,a{1,2},0,0),v5,fine,tool0;")
            .replace("PROC main", &format!("PERS num a{{2,3}}{own};PROC main"));
        let companions = match other {
            "" => Vec::new(),
            other => {
                let text = format!("MODULE other\n{other}\nENDMODULE\n");
                vec![Companion { name: "other.mod".to_owned(), text }]
            }
        };
        let assume = match assume {
            "" => [].into(),
            key => [(key.to_owned(), Assumed::Number(50.0))].into(),
        };
        let job = Settings { companions, assume, ..settings() };
        let found = read(text.as_bytes(), Dialect::Rapid, &job).map_err(|found| {
            found.iter().map(|note| note.what.clone()).collect::<Vec<_>>().join("\n")
        })?;
        let unused = found.warnings.iter().filter(|note| note.code == Code::Unused).count();
        let x = super::support::end(&found.moves[1]).1.translation.x * 1e3;
        Ok::<_, String>((x.round() - 100.0, unused))
    };
    let valued = "PERS num a{2,3}:=[[1,2,3],[4,5,6]];";
    assert_eq!(of("", valued, ""), Ok((2.0, 0)));
    assert_eq!(of(":=[[1,2,3],[4,5,6]]", "PERS num a{2,3};", ""), Ok((2.0, 0)));
    let value = ":=[[9,9,9],[9,9,9]]";
    for (own, other) in [
        (value, valued),
        ("", "PERS num a{3,2}:=[[1,2],[3,4],[5,6]];"),
        ("", "PERS dnum a{2,3}:=[[1,2,3],[4,5,6]];"),
        ("", "VAR num a{2,3}:=[[1,2,3],[4,5,6]];"),
        ("", "TASK PERS num a{2,3}:=[[1,2,3],[4,5,6]];"),
    ] {
        let why = of(own, other, "").expect_err(other);
        assert!(why.contains("'a' is declared twice"), "{other}: {why}");
    }
    let why = of("", "", "").unwrap_err();
    assert!(why.contains("path.program.files") && !why.contains("no effect"), "{why}");
    let why = of("", "", "a{1,2}").unwrap_err();
    assert!(why.contains("'a{1,2}' has no effect"), "{why}");
    assert_eq!(of(value, "", "a{1,2}"), Ok((9.0, 1)));
}

#[test]
fn a_number_that_runs_into_a_word_is_told_at_its_line() {
    const MOVES: &str = "MoveL p,v5,fine,tool0;";
    let branch = format!("IF a=1 THEN\n{MOVES}\nELSEIF a=4THEN\n{MOVES}\nENDIF");
    for (body, line) in [
        (format!("VAR num a:=4;\n{MOVES}\n{branch}"), 8),
        (format!("VAR num a:=4;\n{MOVES}\nWHILE TRUE DO\n{branch}\nENDWHILE\n{MOVES}"), 9),
        ("VAR num a:=4;\na:=5mm;".to_owned(), 5),
    ] {
        let found = super::support::faults(&module(&body), Dialect::Rapid);
        let is_it = |note: &Note| note.what.contains("is a number that runs into a word");
        assert!(found.iter().any(|note| at(note) == line && is_it(note)), "{body}: {found:?}");
        assert!(!found.iter().any(|note| note.what.contains("expected END")), "{found:?}");
    }
}

/// What `assume` refuses is not offered.
#[test]
fn assume_is_offered_for_numbers_and_truth_values_alone() {
    for (body, is_offered) in [
        ("VAR iodev f;\nIF ReadStr(f)=\"E\" THEN\nMoveL p,v5,fine,tool0;\nENDIF", false),
        ("VAR robtarget q;\nq:=getPose();\nMoveL q,v5,fine,tool0;", false),
        ("MoveL getPose(),v5,fine,tool0;", false),
        ("MoveL Offs(getPose(),0,0,1),v5,fine,tool0;", false),
        ("VAR num n;\nn:=getNumber();\nMoveL Offs(p,n,0,0),v5,fine,tool0;", true),
        ("MoveL Offs(p,getNumber(),0,0),v5,fine,tool0;", true),
    ] {
        let found = super::support::faults(&module(body), Dialect::Rapid);
        let what = &found[0].what;
        let is_other = what.contains("write the value into a copy of the program")
            || what.contains("path.program.files in the job");
        assert_eq!((what.contains("assume: "), is_other), (is_offered, true), "{what}");
    }
}

/// A datum that the files of two tasks declare, and that the other task sets, has any value.
#[test]
fn what_another_task_sets_of_shared_data_is_not_known() {
    let of = |own: &str, other: &str, body: &str| {
        let text = format!("MODULE other\n{other}\nENDMODULE\n");
        let companions = vec![Companion { name: "other.mod".to_owned(), text }];
        let body = format!("{START}\n{body}");
        run(&body, own, &Settings { companions, ..settings() })
    };
    let by_feed = "MoveL Offs(p,100,0,0),[feed,500,5000,1000],fine,tool0;";
    let by_place = "MoveL Offs(p,feed,0,0),v100,fine,tool0;";
    let branch = format!("IF feed>5 THEN\n{GO}\nENDIF");
    for (first, second) in [("", ":=10"), (":=10", "")] {
        let own = format!("PERS num feed{first};");
        for sets in ["feed:=50;", "feed:=feed+1;", "Incr feed;"] {
            let other = format!("PERS num feed{second};\nPROC bg()\n{sets}\nENDPROC");
            for body in [by_feed, by_place, branch.as_str()] {
                let found = of(&own, &other, body).expect_err(body);
                let said = "'feed': another task sets it";
                assert!(found.iter().any(|note| note.what.contains(said)), "{body}: {found:?}");
            }
            // What the program itself sets just before is a doubt.
            let found = of(&own, &other, &format!("feed:=20;\n{by_feed}")).unwrap();
            assert!((found.moves[1].feed_m_per_s - 0.02).abs() < 1e-12);
            assert_eq!(doubts(&found), [(LEFT_OUT, 10)]);
        }
        let other = format!("PERS num feed{second};");
        assert_eq!(doubts(&of(&own, &other, by_feed).unwrap()), []);
    }
}

#[test]
fn a_wait_in_the_procedure_of_a_zone_takes_no_time_at_the_corner() {
    let job = Settings { is_scheduled: true, ..settings() };
    for (zone, told) in [("z10", vec![(LEFT_OUT, 13)]), ("fine", vec![])] {
        let body = format!("{START}\nMoveLSync Offs(p,100,0,0),v100,{zone},tool0,\"prc\";\n{NEXT}");
        let found = read_well(&body, "PROC prc()\nWaitTime 2;\nENDPROC", &job);
        assert_eq!(doubts(&found), told, "{zone}");
    }
}

#[test]
fn what_a_procedure_in_a_zone_sets_to_what_it_is_counts() {
    for sets in ["VelSet 50,5000;", "SpeedRefresh 50;"] {
        let of = |between: &str| {
            let body = format!(
                "{sets}\n{START}\nMoveLSync Offs(p,100,0,0),v100,z10,tool0,\"prc\";\n{between}\
                 WaitRob\\InPos;\n{NEXT}"
            );
            doubts(&read_well(&body, &format!("PROC prc()\n{sets}\nENDPROC"), &settings()))
        };
        assert_eq!(of(""), [], "{sets}");
        assert_eq!(of(&format!("{}\n", sets.replace("50", "80"))), [(LEFT_OUT, 12)], "{sets}");
    }
    // A signal that it gives to another procedure.
    let what = Setter::Signal("ao1".to_owned());
    let by = Settings { spindle_from: Some(SetBy { what, per_unit: 10.0 }), ..settings() };
    let body = format!(
        "SetAO ao1,15;\n{START}\nMoveLSync Offs(p,100,0,0),v100,z10,tool0,\"prc\";\n\
         SetAO ao1,100;\n{NEXT}"
    );
    let more = "PROC prc()\nsub ao1;\nENDPROC\nPROC sub(VAR signalao s)\nSetAO s,200;\nENDPROC";
    let told = doubts(&read_well(&body, more, &by));
    assert!(told.contains(&(Code::SpindleCommand, 11)), "{told:?}");
}

#[test]
fn waiting_for_what_a_procedure_in_a_zone_sets_reads_its_value() {
    for (wait, dwells) in [("WaitUntil n=50;", 0), ("WHILE n=0 DO\nWaitTime 0.1;\nENDWHILE", 1)] {
        let found = synced("z10", "n:=50;", &format!("{wait}\n{BY_N}"));
        let mut ends = vec![('L', [0.0; 3]), ('L', [100.0, 0.0, 0.0])];
        ends.extend(vec![('T', [100.0, 0.0, 0.0]); dwells]);
        ends.push(('L', [0.0, 50.0, 0.0]));
        assert_ends(&found, &ends);
        assert!(doubts(&found).contains(&(LEFT_OUT, 10)), "{wait}");
    }
}

#[test]
fn the_procedure_of_a_move_is_that_of_the_module_before_its_name() {
    let more = "LOCAL PROC prc()\nn:=20;\nENDPROC\nENDMODULE\nMODULE O\nPROC prc()\nn:=50;\n\
                ENDPROC";
    for (named, y, told) in
        [("O:prc", 50.0, vec![]), ("m:prc", 20.0, vec![]), ("prc", 0.0, vec![(LEFT_OUT, 9)])]
    {
        let body =
            format!("{START}\nMoveLSync Offs(p,100,0,0),v100,fine,tool0,\"{named}\";\n{BY_N}");
        let found = read_well(&body, more, &settings());
        assert_ends(&found, &[('L', [0.0; 3]), ('L', [100.0, 0.0, 0.0]), ('L', [0.0, y, 0.0])]);
        assert_eq!(doubts(&found), told, "{named}");
    }
}
