//! KUKA KRL: what others may set while the program waits, loops that end by what the job assumes, and components that
//! are left out where two orientations are one.

use detune::notes::{Class, Code, Note};
use detune::program::{Assumed, Companion, Dialect, Program, Settings, read};

use super::support::{at, end, settings};

type Read = Result<Program, Vec<Note>>;

const START: &str = "PTP {X 0,Y 0,Z 500,A 0,B 0,C 180}";

/// Statements from line 3 on.
fn with(body: &str, job: &Settings) -> Read {
    read(format!("DEF p()\n$VEL.CP=0.1\n{body}\nEND\n").as_bytes(), Dialect::Krl, job)
}

fn listed(list: &str, data: &str) -> Settings {
    let text = format!("DEFDAT {list} PUBLIC\n{data}\nENDDAT\n");
    Settings { companions: vec![Companion { name: "p.dat".to_owned(), text }], ..settings() }
}

fn assuming(name: &str, value: bool) -> Settings {
    Settings { assume: [(name.to_owned(), Assumed::Truth(value))].into(), ..settings() }
}

#[track_caller]
fn doubts(found: &Read) -> Vec<(Code, usize)> {
    let program = found.as_ref().unwrap_or_else(|found| panic!("{found:?}"));
    let told = program.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    told.map(|note| (note.code, at(note))).collect()
}

/// X at the end of each move, mm.
#[track_caller]
fn x(found: &Read) -> Vec<f64> {
    let program = found.as_ref().unwrap_or_else(|found| panic!("{found:?}"));
    let of = |each| (end(each).1.translation.x * 1e9).round() / 1e6;
    program.moves.iter().map(of).collect()
}

const BRANCH: &str = "IF N==1 THEN\nLIN {X 9}\nENDIF";

/// The SUBMIT interpreter, or a computer of the cell, sets N and then the flag.
#[test]
fn what_others_may_set_during_a_wait_is_a_doubt_where_it_decides() {
    let of = |wait: &str, behind: &str, job: &Settings| {
        doubts(&with(&format!("{START}\nN=2\n{wait}\n{behind}"), job))
    };
    let waited = |behind: &str| of("WAIT FOR $FLAG[20]", behind, &settings());
    for (behind, line) in [
        (BRANCH, 6),
        ("SWITCH N\nCASE 1\nLIN {X 9}\nENDSWITCH", 6),
        ("WHILE N==1\nLIN {X 9}\nENDWHILE", 6),
        ("IF N==1 THEN\nRETURN\nENDIF\nLIN {X 5}", 6),
        ("IF N==1 THEN\n$VEL.CP=0.2\nENDIF\nLIN {X 5}", 6),
        ("IF N==1 THEN\nA()\nENDIF\nEND\nDEF A()\nLIN {X 9}", 6),
        ("M=N\nIF M==1 THEN\nLIN {X 9}\nENDIF", 7),
        ("M=0\nIF N==1 THEN\nM=1\nENDIF\nIF M==1 THEN\nLIN {X 9}\nENDIF", 10),
        ("Q[1]=0\nIF N==1 THEN\nQ[1]=1\nENDIF\nIF Q[1]==1 THEN\nLIN {X 9}\nENDIF", 10),
        ("$VEL.CP=0.1*N", 6),
        ("LIN {X N}", 6),
    ] {
        assert_eq!(waited(behind), [(Code::MotionLeftOut, line)], "{behind}");
    }
    for behind in [
        "LIN {X 9}",
        "N=2\nLIN {X N}",
        "IF N==1 THEN\n$FLAG[3]=TRUE\nENDIF\nLIN {X 9}",
        "$FLAG[3]=N==1\nLIN {X 9}",
        "FOR K=1 TO 2\nWAIT FOR $IN[1]\nLIN {X K}\nENDFOR",
    ] {
        assert_eq!(waited(behind), [], "{behind}");
    }
    // The job's word for the flag does not say that nobody waits for it.
    let job = assuming("$flag[20]", true);
    assert_eq!(of("WAIT FOR $FLAG[20]", BRANCH, &job), [(Code::MotionLeftOut, 6)]);
    for wait in ["WAIT FOR TRUE", "WAIT SEC 1", "$FLAG[20]=TRUE\nWAIT FOR $FLAG[20]"] {
        assert_eq!(of(wait, BRANCH, &settings()), [], "{wait}");
    }
    // A flag that the program has set, and a datum of its own.
    let flag = "$FLAG[1]=FALSE\nWAIT FOR $IN[1]\nIF $FLAG[1] THEN\nLIN {X 9}\nENDIF";
    assert_eq!(of("", flag, &settings()), [(Code::MotionLeftOut, 8)]);
    let own = format!("INT N\n{START}\nN=2\nWAIT FOR $FLAG[20]\n{BRANCH}");
    assert_eq!(doubts(&with(&own, &settings())), []);
}

#[test]
fn what_a_list_declares_for_all_may_be_set_during_a_wait() {
    const GLOBAL: &str = "DECL GLOBAL INT N=2";
    let of = |behind: &str, job: &Settings| {
        doubts(&with(&format!("{START}\nWAIT FOR $IN[1]\n{behind}"), job))
    };
    let doubt = |line: usize| [(Code::MotionLeftOut, line)];
    let called = "A(N)\nEND\nDEF A(k:IN)\nINT k\nIF k==1 THEN\nLIN {X 9}\nENDIF";
    for job in [listed("p", GLOBAL), listed("$CONFIG", "INT N=2")] {
        assert_eq!(of(BRANCH, &job), doubt(5));
        assert_eq!(of(called, &job), doubt(9));
        // A number that the program never sets is one of the cell.
        assert_eq!(of("$VEL.CP=0.1*N\nLIN {X N}", &job), []);
        let set = format!("{START}\nN=2\nWAIT FOR $IN[1]\n$VEL.CP=0.1*N");
        assert_eq!(doubts(&with(&set, &job)), doubt(6));
    }
    for job in [listed("p", "DECL INT N=2"), listed("p", "DECL GLOBAL CONST INT N=2")] {
        assert_eq!(of(BRANCH, &job), []);
    }
}

#[test]
fn what_the_program_sets_anew_behind_a_wait_is_known() {
    let of = |behind: &str| {
        doubts(&with(&format!("{START}\nN=2\nWAIT FOR $IN[1]\n{behind}"), &settings()))
    };
    for behind in [
        "IF N==1 THEN\nM=1\nENDIF\nM=5\nLIN {X M}",
        "IF N==1 THEN\nQ[1]=1\nENDIF\nQ[1]=5\nLIN {X Q[1]}",
        "IF N==1 THEN\nP.X=1\nENDIF\nP={X 5}\nLIN P",
        "A(N)\nLIN {X N}\nEND\nDEF A(k:OUT)\nINT k\nk=7",
        "$FLAG[7]=F()\nLIN {X 9}\nEND\nDEFFCT BOOL F()\nRETURN N==1\nENDFCT\nDEF A()",
    ] {
        assert_eq!(of(behind), [], "{behind}");
    }
    for (behind, line) in [
        ("IF F() THEN\nLIN {X 9}\nENDIF\nEND\nDEFFCT BOOL F()\nRETURN N==1\nENDFCT\nDEF A()", 6),
        ("A(N)\nLIN {X 9}\nEND\nDEF A(k:OUT)\nINT k\nIF k==1 THEN\nLIN {X 5}\nENDIF", 11),
        ("M=0\nA(M)\nLIN {X M}\nEND\nDEF A(k:OUT)\nINT k\nIF N==1 THEN\nk=1\nENDIF", 8),
    ] {
        assert_eq!(of(behind), [(Code::MotionLeftOut, line)], "{behind}");
    }
}

#[test]
fn others_may_set_components_and_positions() {
    let of = |body: &str, job: &Settings| doubts(&with(&format!("{START}\n{body}"), job));
    let wait = "WAIT FOR $IN[1]";
    let asks = format!("J.TYP=2\n{wait}\nIF J.TYP==1 THEN\nLIN {{X 9}}\nENDIF");
    let list = listed("p", "STRUC JT INT TYP,REAL Z\nDECL GLOBAL JT J={TYP 2,Z 5.0}");
    for job in [settings(), list] {
        assert_eq!(of(&asks, &job), [(Code::MotionLeftOut, 6)]);
    }
    for set in ["XN={X 5}", "XN.X=5"] {
        let found =
            of(&format!("{set}\n{wait}\nLIN XN"), &listed("p", "DECL GLOBAL FRAME XN={X 1}"));
        assert_eq!(found, [(Code::MotionLeftOut, 6)], "{set}");
    }
    assert_eq!(of(&format!("XN={{X 5}}\n{wait}\nXN={{X 7}}\nLIN XN"), &settings()), []);
    let job = listed("p", "DECL GLOBAL FRAME XN={X 5}");
    assert_eq!(of(&format!("{wait}\nLIN XN\nA(XN)\nEND\nDEF A(k:IN)\nFRAME k\nLIN k"), &job), []);
}

#[test]
fn a_loop_without_a_move_waits_like_wait_for() {
    let of =
        |wait: &str, job: &Settings| doubts(&with(&format!("{START}\nN=2\n{wait}\n{BRANCH}"), job));
    let job = assuming("$in[1]", true);
    for wait in [
        "WHILE NOT $IN[1]\n$FLAG[2]=TRUE\nENDWHILE",
        "REPEAT\n$FLAG[2]=TRUE\nUNTIL $IN[1]",
        "WHILE $IN[1]==FALSE\nENDWHILE",
    ] {
        let line = 6 + wait.lines().count() - 1;
        for job in [&settings(), &job] {
            assert_eq!(of(wait, job), [(Code::MotionLeftOut, line)], "{wait}");
        }
    }
    let left = "LOOP\nIF $IN[1] THEN\nEXIT\nENDIF\nWAIT SEC 0.1\nENDLOOP";
    assert_eq!(of(left, &job), [(Code::MotionLeftOut, 11)]);
    for not in ["K=0\nWHILE K<3\nK=K+1\nENDWHILE", "WHILE NOT $IN[1]\nLIN {X 3}\nENDWHILE"] {
        assert_eq!(of(not, &job), [], "{not}");
    }
    // What a list says of it does not hold for sure.
    let ready = listed("p", "DECL GLOBAL BOOL READY=TRUE\nDECL GLOBAL INT N=2");
    let text = format!("{START}\nWAIT FOR READY\n{BRANCH}");
    assert_eq!(doubts(&with(&text, &ready)), [(Code::MotionLeftOut, 5)]);
}

#[test]
fn the_job_says_what_others_have_set_that_no_statement_sets() {
    let assume = [("n".to_owned(), Assumed::Number(1.0))].into();
    let told = Settings { assume, ..listed("p", "DECL GLOBAL INT N=2") };
    let text = format!("{START}\nWAIT FOR $IN[1]\n{BRANCH}");
    let found = with(&text, &told);
    assert_eq!((x(&found), doubts(&found)), (vec![0.0, 9.0], vec![]));
    let hints = |job: &Settings, text: &str| {
        let told = with(text, job).unwrap().warnings;
        told.iter().any(|note| note.what.contains("give it by assume: {\"N\": …}"))
    };
    assert!(hints(&listed("p", "DECL GLOBAL INT N=2"), &text));
    // A datum that the program sets is not what the job assumes of its beginning.
    let set = format!("{START}\nN=2\nWAIT FOR $IN[1]\n{BRANCH}");
    assert!(!hints(&told, &set));
    assert_eq!(doubts(&with(&set, &told)), [(Code::MotionLeftOut, 6)]);
}

#[test]
fn a_program_that_others_let_move_says_what_it_waits_for() {
    let text = "DEF p()\nN=0\nLOOP\nWAIT FOR $FLAG[20]\nIF N==1 THEN\nP1()\nENDIF\nENDLOOP\nEND\n";
    let found = read(text.as_bytes(), Dialect::Krl, &settings()).unwrap_err();
    assert_eq!((at(&found[0]), found.len()), (5, 1), "{found:?}");
    for said in
        ["contains no motion that is read: N is declared in no file", "no file that is read: 'p1'"]
    {
        assert!(found[0].what.contains(said), "{said}: {found:?}");
    }
}

#[test]
fn a_loop_that_the_job_does_not_end_is_read_as_far_as_it_changes() {
    let of = |body: &str, value: bool| {
        with(&format!("{START}\n{body}\nLIN {{X 7}}"), &assuming("$in[2]", value))
    };
    let exit = "LOOP\nIF $IN[2] THEN\nEXIT\nENDIF\nLIN {X 100}\nLIN {X 0}\nENDLOOP";
    let endless = of(exit, false);
    assert_eq!(x(&endless), [0.0, 100.0, 0.0]);
    assert_eq!(doubts(&endless), [(Code::MotionLeftOut, 4)]);
    let told = endless.unwrap().warnings;
    let is_it = |note: &Note| {
        note.what.contains("read once (nothing in it, and nothing that assume: gives, ends it")
    };
    assert!(told.iter().any(is_it), "{told:?}");
    let left = of(exit, true);
    assert_eq!((x(&left), doubts(&left)), (vec![0.0, 7.0], vec![]));
    let run = of("WHILE $IN[2]\nLIN {X 5}\nENDWHILE", true);
    assert_eq!((x(&run), doubts(&run)), (vec![0.0, 5.0], vec![(Code::MotionLeftOut, 4)]));
    // What it asks for changes in its first pass alone, or in each.
    let first =
        "LOOP\nIF $IN[2] THEN\nEXIT\nENDIF\nN=1\nIF N==1 THEN\nLIN_REL {X 5}\nENDIF\nENDLOOP";
    let found = of(first, false);
    assert_eq!(x(&found), [0.0, 5.0, 10.0]);
    assert!(found.unwrap().warnings.iter().any(|note| note.what.contains("read 2 times")));
    let counted = "N=0\nLOOP\nN=N+1\nIF $IN[2] OR (N==3) THEN\nEXIT\nENDIF\nLIN {X N}\nENDLOOP";
    let found = of(counted, false);
    assert_eq!((x(&found), doubts(&found)), (vec![0.0, 1.0, 2.0, 7.0], vec![]));
}

#[test]
fn a_loop_that_speed_or_frame_ends_is_read_to_its_end() {
    for (asked, set) in [
        ("$VEL.CP>0.25", "$VEL.CP=$VEL.CP+0.1"),
        ("$TOOL.Z>15", "$TOOL.Z=$TOOL.Z+10"),
        ("$BASE.Y>15", "$BASE.Y=$BASE.Y+10"),
    ] {
        let text = format!(
            "{START}\nLOOP\nIF $IN[2] THEN\nEXIT\nENDIF\nLIN_REL {{X 5}}\nIF {asked} THEN\nEXIT\nENDIF\n\
             {set}\nENDLOOP\nLIN {{X 7}}"
        );
        let found = with(&text, &assuming("$in[2]", false));
        assert_eq!(
            (x(&found), doubts(&found)),
            (vec![0.0, 5.0, 10.0, 15.0, 7.0], vec![]),
            "{asked}"
        );
    }
}

/// Another program ends it.
#[test]
fn a_loop_that_sets_nothing_of_what_ends_it_is_read_once() {
    let job = listed("p", "DECL GLOBAL BOOL STOP=FALSE");
    let found = with(&format!("{START}\nWHILE NOT STOP\nLIN {{X 5}}\nENDWHILE\nLIN {{X 7}}"), &job);
    assert_eq!((x(&found), doubts(&found)), (vec![0.0, 5.0], vec![(Code::MotionLeftOut, 4)]));
}

/// At B 90 A and C turn about one axis: what the program states is kept, as no other split is known.
#[test]
fn components_left_out_are_those_that_the_program_has_stated() {
    let start = "PTP {X 100,Y 0,Z 300,A 0,B 90,C 0}";
    for (moves, by) in [
        ("LIN {A 20}", 20.0),
        ("LIN {A 20}\nLIN {X 101,A 0}", 0.0),
        ("LIN {A 20}\nLIN_REL {A -5}", 15.0),
        ("CIRC {X 110,Y 10,A 5},{X 120,Y 0,A 40}\nLIN {X 130,A 10}", 10.0),
    ] {
        let found = with(&format!("{start}\n{moves}"), &settings()).unwrap();
        let [first, last] = [&found.moves[0], found.moves.last().unwrap()].map(|each| end(each).1);
        let turned = first.rotation.angle_to(&last.rotation).to_degrees();
        assert!((turned - by).abs() < 1e-6, "{moves}: {turned}");
    }
}
