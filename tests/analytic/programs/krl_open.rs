//! KUKA KRL: branches and loops that only the run decides, what they call, and what routines, loops and the job may
//! have set.

use detune::notes::{Class, Code, Note};
use detune::program::{Assumed, Dialect, Program, SetBy, Setter, Settings, read};

use super::support::{at, end, settings};

type Read = Result<Program, Vec<Note>>;

const START: &str = "PTP {X 0,Y 0,Z 500,A 0,B 0,C 180}";

/// Statements from line 3 on.
fn with(body: &str, job: &Settings) -> Read {
    read(format!("DEF p()\n$VEL.CP=0.1\n{body}\nEND\n").as_bytes(), Dialect::Krl, job)
}

fn assuming(name: &str, value: f64) -> Settings {
    Settings { assume: [(name.to_owned(), Assumed::Number(value))].into(), ..settings() }
}

fn doubts(program: &Program) -> Vec<(Code, usize)> {
    let told = program.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    told.map(|note| (note.code, at(note))).collect()
}

/// X at the end of each move, mm.
fn x(program: &Program) -> Vec<f64> {
    let of = |each| (end(each).1.translation.x * 1e9).round() / 1e6;
    program.moves.iter().map(of).collect()
}

#[track_caller]
fn refused(found: Read, said: &str) {
    let found = found.expect_err(said);
    assert!(found.iter().any(|note| note.what.contains(said)), "{said}: {found:?}");
}

/// A branch that only the run decides, from line 6 on, and one that asks for what it may set.
fn open(branch: &str, asked: &str, routines: &str) -> Read {
    let body = format!(
        "{START}\nn=5\n$OUT[1]=FALSE\nIF $IN[3] THEN\n{branch}\nENDIF\nIF {asked} THEN\nLIN {{X 9}}\n\
         ENDIF{routines}"
    );
    with(&body, &settings())
}

/// A function that sets what it is given.
const BY_REFERENCE: &str = "\nEND\nDEFFCT BOOL F(x:OUT)\nINT x\nx=5\nRETURN TRUE\nENDFCT\nDEF A()";

#[test]
fn loops_and_calls_without_motion_are_read_in_an_open_branch() {
    for (branch, routines) in [
        ("FOR k=1 TO 3\n$FLAG[k]=TRUE\nENDFOR", ""),
        ("WHILE $IN[4]\n$FLAG[1]=TRUE\nENDWHILE", ""),
        ("REPEAT\n$FLAG[1]=TRUE\nUNTIL $IN[4]", ""),
        ("LOOP\nIF $IN[4] THEN\nEXIT\nENDIF\nENDLOOP", ""),
        ("SWITCH k\nCASE 1\n$FLAG[1]=TRUE\nDEFAULT\n$FLAG[2]=TRUE\nENDSWITCH", ""),
        ("A()", "\nEND\nDEF A()\nINT n\nn=2\nIF $IN[4] THEN\nRETURN\nENDIF\n$FLAG[1]=TRUE"),
        ("A(n)", "\nEND\nDEF A(x:IN)\nINT x\nx=2"),
        ("A()", "\nEND\nDEF A()\nB()\nEND\nDEF B()\nA()"),
        ("k=F()", "\nEND\nDEFFCT INT F()\nRETURN 1\nENDFCT\nDEF A()"),
    ] {
        let found = open(branch, "n==5", routines).unwrap_or_else(|found| panic!("{found:?}"));
        assert_eq!((x(&found), doubts(&found)), (vec![0.0, 9.0], vec![]), "{branch}");
    }
    // What they may set is not known behind them, an element of which the index may change in none.
    for (branch, asked, routines) in [
        ("FOR n=1 TO 3\nk=n\nENDFOR", "n==5", ""),
        ("A(n)", "n==5", "\nEND\nDEF A(x)\nINT x\nx=2"),
        ("A()", "n==5", "\nEND\nDEF A()\nn=2"),
        ("k=F()", "n==5", "\nEND\nDEFFCT INT F()\nn=2\nRETURN 1\nENDFCT\nDEF A()"),
        ("FOR n=1 TO 3\n$OUT[n]=TRUE\nENDFOR", "$OUT[1]", ""),
        ("WHILE n>0\n$OUT[n]=TRUE\nn=n-1\nENDWHILE", "$OUT[1]", ""),
        ("IF $IN[4] THEN\nn=1\nENDIF\n$OUT[n]=TRUE", "$OUT[1]", ""),
        ("WHILE $IN[4]\nA($OUT[n])\nn=n-1\nENDWHILE", "$OUT[1]", "\nEND\nDEF A(x)\nBOOL x\nx=TRUE"),
        ("WHILE $IN[4]\nPULSE($OUT[n],TRUE,1)\nn=n-1\nENDWHILE", "$OUT[1]", ""),
        ("A(1)", "$OUT[1]", "\nEND\nDEF A(x)\nINT x\n$OUT[x]=TRUE"),
        ("WAIT FOR F(n)", "n==5", BY_REFERENCE),
        ("WAIT FOR F(k) AND (n==4)", "n==5", BY_REFERENCE),
    ] {
        let found = open(branch, asked, routines).expect_err(branch);
        assert!(found.len() == 1 && at(&found[0]) > 8, "{branch}: {found:?}");
        let is_pulsed = branch.contains("PULSE") && found[0].what.contains("is pulsed");
        let why = "depends on a condition: '$IN[3]'";
        assert!(is_pulsed || found[0].what.contains(why), "{found:?}");
    }
    for (branch, routines) in [
        ("A()", "\nEND\nDEF A()\nB()\nEND\nDEF B()\nLIN_REL {X 1}"),
        ("FOR k=1 TO 3\nA()\nENDFOR", "\nEND\nDEF A()\n$VEL.CP=1"),
        ("RETURN", ""),
        ("EXIT", ""),
    ] {
        let found = open(branch, "n==5", routines).expect_err(branch);
        assert_eq!((at(&found[0]), found.len()), (6, 1), "{branch}: {found:?}");
        assert!(found[0].what.contains("IF decides about motion"), "{branch}: {found:?}");
    }
    let counted = format!("{START}\nn=5\nFOR n=1 TO q\n$FLAG[n]=TRUE\nENDFOR\n");
    let asks = format!("{counted}IF n==5 THEN\nLIN {{X 9}}\nENDIF");
    refused(with(&asks, &settings()), "'n' depends on a condition: 'q' is declared in no file");
}

/// It has run before, so that its line has been read.
#[test]
fn a_routine_of_the_spindle_in_an_open_branch() {
    let text = format!(
        "{START}\nSPIN(3)\nLIN {{X 5}}\nIF $IN[3] THEN\nSPIN(4)\nENDIF\nLIN {{X 9}}\nEND\n\
         DEF SPIN(s:IN)\nINT s\n$ANOUT[1]=0.5"
    );
    let by = |what| Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    let found = with(&text, &by(Setter::Signal("$ANOUT[1]".to_owned()))).unwrap();
    assert_eq!(doubts(&found), [(Code::SpindleCommand, 13)]);
    let called = by(Setter::Procedure("SPIN".to_owned(), 1));
    refused(with(&text, &called), "IF decides about motion");
    // A comment counts with the instruction that it stands before.
    let job = by(Setter::Comment("SPEED".to_owned()));
    let spun = text.replace("LIN {X 5}", ";SPEED 9000\nLIN {X 5}");
    assert!(with(&spun, &job).is_ok());
    for (branch, routine) in [
        (";SPEED 3000\n$FLAG[1]=TRUE", ""),
        ("FOR N=1 TO 3\n;SPEED 3000\n$FLAG[1]=TRUE\nENDFOR", ""),
        ("A()", "\nEND\nDEF A()\n;SPEED 3000\n$FLAG[1]=TRUE"),
    ] {
        let text = format!(
            "{START}\n;SPEED 9000\nLIN {{X 5}}\nIF $IN[3] THEN\n{branch}\nENDIF\n\
             LIN {{X 9}}{routine}"
        );
        refused(with(&text, &job), "IF decides about motion");
    }
    let text = format!("{START}\nIF $IN[3] THEN\n$FLAG[1]=TRUE\n;SPEED 3000\nENDIF\nLIN {{X 9}}");
    assert_eq!(doubts(&with(&text, &job).unwrap()), [(Code::SpindleCommand, 6)]);
}

/// What a routine sets through its parameter: tool, base, speed, outputs of the spindle.
#[test]
fn what_motion_depends_on_is_not_given_by_reference() {
    let routine = "\nEND\nDEF A(x:OUT)\nREAL x\nx=0.05";
    for name in ["$VEL.CP", "$OV_PRO", "$BASE", "$TOOL"] {
        for text in [format!("A({name})"), format!("IF $IN[3] THEN\nA({name})\nENDIF")] {
            let all = format!("{START}\n{text}\nLIN {{X 9}}{routine}");
            assert!(with(&all, &settings()).is_err(), "{text}");
        }
    }
    let shared = "SIGNAL SPIN $OUT[7] TO $OUT[12]\nSIGNAL OTH $OUT[9]\n";
    let what = Setter::Signal("SPIN".to_owned());
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    for name in ["OTH", "SPIN"] {
        let all = format!("{shared}{START}\nSPIN=30\nA({name})\nLIN {{X 9}}{routine}");
        let found = with(&all, &job).unwrap_or_else(|found| panic!("{found:?}"));
        assert!(doubts(&found).contains(&(Code::SpindleCommand, 7)), "{name}: {found:?}");
    }
}

#[test]
fn a_tool_that_the_program_may_have_set_is_not_the_jobs() {
    let set = "TOOL_DATA[2]={X 0,Y 0,Z 100,A 0,B 0,C 0}\n";
    for (may_set, routine) in [
        ("IF $IN[3] THEN\nTOOL_DATA[2].Z=200\nENDIF", ""),
        ("IF $IN[3] THEN\nA()\nENDIF", "\nEND\nDEF A()\nTOOL_DATA[2].Z=200"),
        ("TOOL_DATA[2]=zz", ""),
    ] {
        for (list, choose) in [
            ("TOOL", "$TOOL=TOOL_DATA[2]"),
            ("TOOL", "BAS(#TOOL,2)"),
            ("BASE", "$BASE=BASE_DATA[2]"),
        ] {
            let text = format!("{START}\n{set}{may_set}\n{choose}\nLIN {{X 9}}{routine}");
            let found = with(&text.replace("TOOL_DATA[", &format!("{list}_DATA[")), &settings());
            refused(found, &format!("the program sets {list}_DATA[2] to what is not known"));
        }
    }
    let any = format!("{START}\nTOOL_DATA[q].Z=200\n$TOOL=TOOL_DATA[2]\nLIN {{X 9}}");
    refused(with(&any, &settings()), "the program sets an element of TOOL_DATA");
}

#[test]
fn the_counter_of_a_loop_behind_it_and_in_it() {
    let counted = |body: &str| format!("{START}\nINT N\nFOR N=1 TO 3\n{body}\nENDFOR\n");
    let asks = format!("{}IF N==3 THEN\nLIN {{X 9}}\nENDIF", counted("LIN {X N}"));
    refused(with(&asks, &settings()), "N has counted a FOR loop");
    refused(with(&counted("N=N+1"), &settings()), "the loop sets N, which it counts by");
}

#[test]
fn what_the_job_gives_of_a_component_ends_where_the_program_sets_it() {
    let asked = "IF INFO.CMD==3 THEN\nLIN {X 9}\nENDIF";
    let job = assuming("info.cmd", 3.0);
    assert_eq!(x(&with(&format!("{START}\n{asked}"), &job).unwrap()), [0.0, 9.0]);
    let set = format!("{START}\nINFO.CMD=0\n");
    assert_eq!(x(&with(&format!("{set}{asked}"), &job).unwrap()), [0.0]);
    // Behind a WAIT FOR that the program's own value does not end, the job's counts again.
    let waits = format!("{set}WAIT FOR INFO.CMD<>0\n{asked}");
    assert_eq!(x(&with(&waits, &job).unwrap()), [0.0, 9.0]);
    let waits = format!("{set}WAIT FOR INFO.CMD==0\n{asked}");
    assert_eq!(x(&with(&waits, &job).unwrap()), [0.0]);
    // Where a routine may set it, it is not known.
    let routine = "\nEND\nDEF A(x:OUT)\nx.CMD=3";
    let given = format!("{set}A(INFO)\n{asked}{routine}");
    assert!(with(&given, &job).is_err());
}
