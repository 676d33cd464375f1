//! KUKA KRL: branches and loops that only the run decides, what they call, and what routines, loops and the job may
//! have set.

use detune::notes::{Class, Code, Note};
use detune::program::{Assumed, Companion, Dialect, Program, SetBy, Setter, Settings, read};
use nalgebra::Isometry3;

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

/// A branch that only the run decides, from line 6 on, and one that asks for what it may set; `n` is the program's own.
fn open(branch: &str, asked: &str, routines: &str) -> Read {
    let body = format!(
        "{START}\nn=5\n$OUT[1]=FALSE\nIF $IN[3] THEN\n{branch}\nENDIF\nIF {asked} THEN\nLIN {{X 9}}\n\
         ENDIF{routines}"
    );
    let text = "DEFDAT p\nINT n\nENDDAT\n".into();
    let companions = vec![Companion { name: "p.dat".to_owned(), text }];
    with(&body, &Settings { companions, ..settings() })
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
    // One step behind the end value, where the steps meet that.
    let behind = format!("{}LIN {{X 10*N}}", counted("LIN {X N}"));
    let of = |range: &str| with(&behind.replace("1 TO 3", range), &settings());
    assert_eq!(x(&of("1 TO 3").unwrap()), [0.0, 1.0, 2.0, 3.0, 40.0]);
    assert_eq!(x(&of("5 TO 1 STEP -2").unwrap()), [0.0, 5.0, 3.0, 1.0, -10.0]);
    for range in ["1 TO 4 STEP 2", "0.5 TO 1.5"] {
        refused(of(range), "read only of whole numbers whose steps meet the end value");
    }
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

/// What an interrupt or a trigger gives a routine by reference it may set at any time.
#[test]
fn what_an_interrupt_gives_by_reference_may_be_set() {
    let by = |action: &str| {
        [
            (format!("INTERRUPT DECL 3 WHEN $IN[2] DO {action}\nINTERRUPT ON 3"), 5),
            (format!("TRIGGER WHEN DISTANCE=0 DELAY=0 DO {action} PRIO=-1"), 4),
        ]
    };
    let routine = |way: &str| format!("\nEND\nDEF A(x:{way})\nREAL x\nx=10\nEND\nDEF B()\nA(K)");
    for name in ["$OV_PRO", "$VEL.CP", "$BASE", "$TOOL"] {
        for (text, line) in by(&format!("A({name})")) {
            let of = |way| {
                let body = format!("{START}\n{text}\nLIN {{X 9}}{}", routine(way));
                doubts(&with(&body, &settings()).unwrap_or_else(|found| panic!("{found:?}")))
            };
            assert_eq!(of("OUT"), [(Code::MotionLeftOut, line)], "{text}");
            assert_eq!(of("IN"), [], "{text}");
        }
    }
    for action in ["A(K)", "B()"] {
        for (text, _) in by(action) {
            let of = |way| {
                let body = format!("{START}\nK=5\n{text}\nLIN {{X K}}{}", routine(way));
                with(&body, &settings())
            };
            refused(of("OUT"), "'k' is set by");
            assert_eq!(x(&of("IN").unwrap()), [0.0, 5.0], "{text}");
        }
    }
}

#[test]
fn what_a_channel_fills_in_the_job_gives_where_it_is_a_number() {
    let of = |asked: &str, job: &Settings| {
        let read = "DECL STATE_T ST\nCREAD(H,ST,M,T,O,\"%f\",N)";
        with(&format!("{START}\n{read}\nIF {asked} THEN\nLIN {{X 9}}\nENDIF"), job)
    };
    refused(of("N==2", &settings()), "assume: {\"N\": …} in the job can give it");
    assert_eq!(x(&of("N==2", &assuming("n", 2.0)).unwrap()), [0.0, 9.0]);
    let found = of("ST.RET1==#CMD_TIMEOUT", &settings()).unwrap_err();
    let what = &found[0].what;
    assert!(what.contains("CREAD fills in 'ST'") && what.contains("set ST in place of"), "{what}");
    assert!(!what.contains("can settle it"), "{what}");
}

/// That it is one step behind the end value no manual says.
#[test]
fn the_counter_of_a_loop_is_a_doubt_where_it_matters_behind_it() {
    let of = |behind: &str| {
        let counted = "INT N,M\nREAL Q[9]\nFOR N=1 TO 3\n$FLAG[N]=TRUE\nENDFOR";
        let body = format!("{START}\n{counted}\n{behind}");
        doubts(&with(&body, &settings()).unwrap_or_else(|found| panic!("{behind}: {found:?}")))
    };
    let routine = "\nEND\nDEF A(k:IN)\nINT k\nLIN {X k}";
    let function = "\nEND\nDEFFCT INT F(k:IN)\nINT k\nLIN {X k}\nRETURN 1\nENDFCT\nDEF B()";
    let by_reference = "\nEND\nDEF A(k:OUT)\nINT k,J\nFOR J=1 TO 3\nENDFOR\nk=J";
    for (behind, line) in [
        ("LIN {X N}".to_owned(), 9),
        ("LIN {X 5} WITH $VEL.CP=0.01*N".to_owned(), 9),
        ("$VEL.CP=0.01*N".to_owned(), 9),
        ("IF N==4 THEN\nLIN {X 5}\nENDIF".to_owned(), 9),
        ("WHILE N<6\nN=N+1\nENDWHILE".to_owned(), 9),
        ("SWITCH N\nCASE 4\nLIN {X 5}\nENDSWITCH".to_owned(), 9),
        ("WAIT SEC N".to_owned(), 9),
        ("M=2*N\nLIN {X M}".to_owned(), 10),
        ("N=N+1\nLIN {X N}".to_owned(), 10),
        ("Q[4]=N\nLIN {X Q[4]}".to_owned(), 10),
        ("Q[N]=7".to_owned(), 9),
        ("$OUT[2]=FALSE\n$OUT[N]=TRUE\nIF $OUT[2] THEN\nLIN {X 5}\nENDIF".to_owned(), 11),
        ("BAS(#VEL_CP,0.01*N)".to_owned(), 9),
        (format!("A(N){routine}"), 13),
        (format!("M=F(N){function}"), 13),
        (format!("A(M)\nLIN {{X M}}{by_reference}"), 10),
    ] {
        assert_eq!(of(&behind), [(Code::MotionLeftOut, line)], "{behind}");
    }
    for behind in [
        "LIN {X 5}",
        "N=7\nLIN {X N}",
        "M=N\nM=7\nLIN {X M}",
        "$OUT[3]=N==4",
        "$OUT[N]=TRUE\nLIN {X 5}",
        "Q[4]=N\nQ[5]=1\nLIN {X Q[5]}",
        "FOR N=5 TO 6\nLIN {X N}\nENDFOR",
        "FOR N=5 TO 6\nIF N==6 THEN\nEXIT\nENDIF\nENDFOR\nLIN {X N}",
    ] {
        assert_eq!(of(behind), [], "{behind}");
    }
}

/// A name that routines of an interrupt declare for themselves is another datum in the routines
/// that they call, and in the program.
#[test]
fn what_the_routines_of_an_interrupt_declare_is_their_own() {
    let job = |list: &str| {
        let text = format!("DEFDAT $CONFIG PUBLIC\nDECL REAL GV=5\n{list}ENDDAT\n");
        let companions = vec![Companion { name: "config.dat".to_owned(), text }];
        Settings { companions, ..settings() }
    };
    let of = |own: &str, routines: &str, job: &Settings| {
        let text = format!(
            "{own}{START}\nINTERRUPT DECL 3 WHEN $IN[2] DO B()\nINTERRUPT ON 3\nGV=5\nLIN {{X GV}}\n\
             END\n{routines}"
        );
        with(&text, job)
    };
    let sets = "\nEND\nDEF A(x:OUT)\nREAL x\nx=10";
    for routines in [
        "DEF B()\nC(GV)\nEND\nDEF C(GV:OUT)\nREAL GV\nGV=4".to_owned(),
        "DEF B()\nDECL REAL GV\nGV=1\nG()\nEND\nDEF G()\nGV=10".to_owned(),
        format!("DEF B()\nDECL REAL GV\nA(GV)\nG()\nEND\nDEF G()\nA(GV){sets}"),
    ] {
        refused(of("", &routines, &job("")), "'gv' is set by an interrupt");
    }
    let alone = format!("DEF B()\nDECL REAL GV\nA(GV){sets}");
    for own in ["", "DECL REAL GV\n"] {
        let found = of(own, &alone, &job("")).unwrap_or_else(|found| panic!("{found:?}"));
        assert_eq!((x(&found), doubts(&found)), (vec![0.0, 5.0], vec![]), "{own}");
    }
    // Which element its index chooses only the run knows.
    let listed = job("DECL REAL L[3]\nL[3]=7\n");
    let list = "I=2\nINTERRUPT DECL 3 WHEN $IN[2] DO B()\nINTERRUPT ON 3\nLIN {X L[3]}\nEND\n\
                DEF B()\nDECL INT I\nI=3\nL[I]=9";
    refused(with(&format!("DECL INT I\n{START}\n{list}"), &listed), "'l' is set by an interrupt");
}

/// The flange to the controller, whatever the job's tcp is.
#[test]
fn tool_0_under_the_tcp_of_the_job_is_a_doubt() {
    let mut job = settings();
    let of = |body: &str, job: &Settings| {
        let found = with(body, job).unwrap_or_else(|found| panic!("{body}: {found:?}"));
        (found.moves[0].tcp.translation.z, doubts(&found))
    };
    let chosen = ["$TOOL=$NULLFRAME", "$TOOL=TOOL_DATA[0]", "BAS(#TOOL,0)"];
    let axes = "PTP {A1 0,A2 0,A3 0,A4 0,A5 9,A6 0}";
    for tool in chosen {
        assert_eq!(of(&format!("{tool}\n{START}"), &job), (0.0, vec![]), "{tool}");
    }
    job.tcp = Some(Isometry3::translation(0.0, 0.0, 0.2));
    let told = |line| vec![(Code::ChangeIgnored, line)];
    for tool in chosen {
        assert_eq!(of(&format!("{tool}\n{START}"), &job), (0.2, told(4)), "{tool}");
        // Only where a place counts with it.
        assert_eq!(of(&format!("{tool}\n{axes}"), &job), (0.2, vec![]), "{tool}");
        let other = "$TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0}";
        assert_eq!(of(&format!("{tool}\n{other}\n{START}"), &job), (0.1, vec![]), "{tool}");
    }
    let copied = format!("FRAME T\nT=TOOL_DATA[0]\n$TOOL=T\n{START}");
    assert_eq!(of(&copied, &job), (0.2, told(6)));
    let once = format!("S{START} WITH $TOOL=$NULLFRAME\nLIN {{X 9}}");
    assert_eq!(of(&once, &job), (0.2, told(3)));
    // The job says that its tcp is meant, or that the flange is.
    for z in [0.2, 0.0] {
        job.tool_frames.insert(0, Isometry3::translation(0.0, 0.0, z));
        for tool in chosen {
            assert_eq!(of(&format!("{tool}\n{START}"), &job), (z, vec![]), "{tool}");
        }
    }
}

/// Inline forms call their points alike in every program: what another's list declares is not this one's.
#[test]
fn data_of_another_programs_list_are_a_doubt() {
    let of = |list: &str, body: &str| {
        let companions = vec![Companion { name: "b.dat".to_owned(), text: list.to_owned() }];
        doubts(&with(&format!("{START}\n{body}"), &Settings { companions, ..settings() }).unwrap())
    };
    const POINT: &str = "E6POS XP1={X 30,Y 0,Z 500,A 0,B 0,C 180}\nENDDAT\n";
    let list = |head: &str, declares: &str| format!("DEFDAT {head}\n{declares} {POINT}");
    assert_eq!(of(&list("sub", "DECL"), "LIN XP1"), [(Code::ChangeIgnored, 4)]);
    assert_eq!(of(&list("sub PUBLIC", "DECL"), "LIN XP1\nLIN XP1"), [(Code::ChangeIgnored, 4)]);
    for (list, body) in [
        (list("p", "DECL"), "LIN XP1"),
        (list("sub PUBLIC", "DECL GLOBAL"), "LIN XP1"),
        (list("$CONFIG", "DECL"), "LIN XP1"),
        // A component has its own names.
        ("DEFDAT sub\nREAL X=5\nENDDAT\n".to_owned(), "LIN {X 9}"),
    ] {
        assert_eq!(of(&list, body), [], "{list}");
    }
}

/// BAS(#INITMOV) takes tool 1 (bas.src, INITMOV), which a program with a tool of its own need not state.
#[test]
fn a_tool_that_is_kept_in_place_of_tool_1_is_a_doubt() {
    let of = |behind: &str| {
        let body = format!(
            "$TOOL={{X 0,Y 0,Z 250,A 0,B 0,C 0}}\nBAS(#INITMOV,0)\n$VEL.CP=0.1\n{behind}LIN {{X 9,Y 0,Z 500,A 0,B 0,C 180}}"
        );
        doubts(&with(&body, &settings()).unwrap())
    };
    assert_eq!(of(""), [(Code::ChangeIgnored, 6)]);
    assert_eq!(of("$TOOL={X 0,Y 0,Z 250,A 0,B 0,C 0}\n"), []);
}

/// A move that a line break was lost before is not left out.
#[test]
fn what_stands_behind_the_end_of_a_block_or_statement_is_refused() {
    for (body, said) in [
        ("SPLINE\nSLIN {X 5}\nENDSPLINE SLIN {X 9}", "behind ENDSPLINE in its line"),
        ("FOR n=1 TO 3\nk=n\nENDFOR LIN {X 9}", "behind ENDFOR in its line"),
        ("FOR n=1 TO 3 LIN {X 9}\nk=n\nENDFOR", "is not understood"),
        ("WHILE k<1 LIN {X 9}\nk=k+1\nENDWHILE", "is not understood"),
        ("LOOP LIN {X 9}\nEXIT\nENDLOOP", "is not understood"),
        ("REPEAT\nk=k+1\nUNTIL k>3 LIN {X 9}", "is not understood"),
        ("WAIT SEC 1 LIN {X 9}", "is not understood"),
        ("GOTO a LIN {X 9}\na:", "is not understood"),
    ] {
        let found = with(&format!("INT n,k\nk=0\n{START}\n{body}\nLIN {{X 1}}"), &settings());
        refused(found, said);
    }
}

/// The job reads the speed that SPIN is given; what it sets has another speed elsewhere.
#[test]
fn what_the_procedure_of_the_spindle_sets_is_a_doubt_elsewhere() {
    let what = Setter::Procedure("SPIN".to_owned(), 1);
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    let routines = "END\nDEF SPIN(N:IN)\nINT N\nRAISE(N)\n$OUT[5]=TRUE\nSETPOINT=N/10\nEND\n\
                    DEF RAISE(N:IN)\nINT N\n$ANOUT[1]=N/24000.0";
    for (line, routine, is_doubt) in [
        ("SPIN(2000)", "", false),
        ("$ANOUT[1]=0.1", "", true),
        ("RAISE(2000)", "", true),
        ("SETPOINT=200", "", true),
        ("$OUT[5]=TRUE", "", true),
        ("TRIGGER WHEN DISTANCE=0 DELAY=0 DO $ANOUT[1]=0.1", "", true),
        ("IF $IN[3] THEN\n$ANOUT[1]=0.1\nENDIF", "", true),
        ("SPINDLE_SLOW()", "END\nDEF SPINDLE_SLOW()\n$OUT[6]=FALSE", true),
        ("SPINDLE_OFF()", "END\nDEF SPINDLE_OFF()\n$OUT[6]=TRUE", true),
        // Off is no other speed, and what SPIN does not set has none.
        ("SPINDLE_OFF()", "END\nDEF SPINDLE_OFF()\n$OUT[5]=FALSE\n$ANOUT[1]=0", false),
        ("$OUT[5]=FALSE", "", false),
        ("$ANOUT[2]=0.1", "", false),
    ] {
        let text =
            format!("{START}\nSPIN(3000)\nLIN {{X 5}}\n{line}\nLIN {{X 9}}\n{routines}\n{routine}");
        let found = with(&text, &job).unwrap();
        let told = doubts(&found).into_iter().map(|(code, _)| code).collect::<Vec<_>>();
        let expected = if is_doubt { vec![Code::SpindleCommand] } else { vec![] };
        assert_eq!(told, expected, "{line}");
    }
}
