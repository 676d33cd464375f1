//! What the controllers of KUKA, ABB and Fanuc do with whole numbers, parameters, functions, flags,
//! interrupts and system variables. Expected places are worked out by hand.

use detune::notes::{Code, Note};
use detune::program::{Assumed, Companion, Dialect, Program, Settings, read};

use super::support::{assert_ends, at, end, module, settings};

fn run(text: &str, dialect: Dialect, job: &Settings) -> Result<Program, Vec<Note>> {
    read(text.as_bytes(), dialect, job)
}

const START: &str = "PTP {X 0,Y 0,Z 100,A 0,B 0,C 180}";

fn krl_with(body: &str, behind: &str) -> Result<Program, Vec<Note>> {
    let text = format!("DEF p()\n$VEL.CP=0.1\n{START}\n{body}\nEND\n{behind}");
    run(&text, Dialect::Krl, &settings())
}

/// X of the last target, mm.
#[track_caller]
fn krl_x(body: &str, behind: &str) -> f64 {
    let program = krl_with(body, behind).unwrap_or_else(|found| panic!("{body}: {found:?}"));
    let (_, last) = end(program.moves.last().unwrap());
    (last.translation.x * 1e9).round() / 1e6
}

fn doubts(program: &Program) -> Vec<(Code, usize)> {
    let told = program.warnings.iter().filter(|note| note.code != Code::Assumed);
    told.map(|note| (note.code, at(note))).collect()
}

#[track_caller]
fn refused(found: Result<Program, Vec<Note>>, said: &str) {
    let found = found.expect_err(said);
    assert!(found.iter().any(|note| note.what.contains(said)), "{said}: {found:?}");
}

#[test]
fn whole_numbers_of_krl_divide_to_whole_numbers_and_round() {
    for (body, x) in [
        ("INT N\nN=1\nLIN {X N/2*100}", 0.0),
        ("DECL INT N=7\nLIN {X N/2}", 3.0),
        ("LIN {X 1/2*100.0}", 0.0),
        ("LIN {X -7/2*10}", -30.0),
        ("LIN {X 1/2.0*100}", 50.0),
        ("LIN {X 1.0E0/2*100}", 50.0),
        ("INT N\nN=2.6\nLIN {X N*10}", 30.0),
        ("INT N\nN=3.0\nLIN {X N/2}", 1.0),
        ("REAL R\nR=1\nLIN {X R/2*100}", 50.0),
        ("DECL INT N[3]\nN[2]=5\nLIN {X N[2]/2}", 2.0),
        ("INT I\nFOR I=1 TO 3\nLIN {X I/2*10}\nENDFOR", 10.0),
        ("FRAME F\nF={X 1,Y 2}\nLIN {X F.X/2*100}", 50.0),
        ("FRAME F\nF.X=1\nLIN {X F.X/2*100}", 50.0),
        ("INT N\nN='H0F'\nLIN {X N/2}", 7.0),
        ("GLOBAL INT N=1\nLIN {X N/2*100}", 0.0),
    ] {
        assert_eq!(krl_x(body, ""), x, "{body}");
    }
    let data = "DEFDAT p\nDECL INT N=3\nREAL R=3\nENDDAT\n";
    assert_eq!(krl_x("LIN {X N/2*100}", data), 100.0);
    assert_eq!(krl_x("LIN {X R/2*100}", data), 150.0);
    // Whether a name that no file declares is an INT is not known.
    refused(krl_with("N=1\nLIN {X N/2}", ""), "is declared in no file that is read");
    assert_eq!(krl_x("N=4\nLIN {X N/2}", ""), 2.0);
    refused(krl_with("INT N\nN=2147483647\nLIN {X N+1}", ""), "beyond what an INT holds");
}

/// KUKA, like Siemens, may have comparisons behind AND, EXOR and OR: where that changes nothing the
/// program runs, and else it has to say what it means.
#[test]
fn comparisons_beside_and_count_where_their_order_changes_nothing() {
    let x = |given: &str, condition: &str| {
        let body = format!(
            "INT N\nBOOL A,B,C\n{given}\nIF {condition} THEN\nLIN {{X 1}}\nELSE\nLIN {{X 2}}\nENDIF"
        );
        krl_with(&body, "")
    };
    let all = "N=3\nA=FALSE\nB=FALSE\nC=TRUE";
    for (condition, expected) in [
        // A number beside AND makes no sense, so that no controller reads it so.
        ("N==3 AND C", 1.0),
        ("C AND N<>3", 2.0),
        ("N>1 AND N<5", 1.0),
        ("NOT A==C", 1.0),
        ("(A==B) AND C==TRUE", 1.0),
        ("A OR B EXOR C", 1.0),
        ("C OR B EXOR C", 1.0),
        ("NOT (A OR B) AND C", 1.0),
    ] {
        let program = x(all, condition).unwrap_or_else(|found| panic!("{condition}: {found:?}"));
        let (_, last) = end(program.moves.last().unwrap());
        assert_eq!(last.translation.x, expected / 1e3, "{condition}");
    }
    // (FALSE = TRUE) and (FALSE = FALSE): no; FALSE = (TRUE and FALSE) = FALSE: no, as well.
    // FALSE = FALSE and TRUE = TRUE: yes; FALSE = (FALSE and TRUE) = TRUE: yes.
    // TRUE = FALSE and FALSE = FALSE: no; TRUE = (FALSE and FALSE) = FALSE: yes.
    for (condition, is_open) in
        [("A==C AND B==FALSE", false), ("A==B AND C==TRUE", false), ("C==A AND B==FALSE", true)]
    {
        assert_eq!(x(all, condition).is_err(), is_open, "{condition}");
    }
    refused(x(all, "C==A AND B==FALSE"), "put parentheses");
    refused(x("N=3\nC=TRUE", "N==3 AND A==C"), "'a'");
}

#[test]
fn parameters_of_krl_by_value_and_by_reference() {
    for (head, x) in [("A:IN", 10.0), ("A :OUT", 99.0), ("A", 99.0)] {
        let behind = format!("DEF SUB({head})\nREAL A\nA=99\nEND\n");
        assert_eq!(krl_x("REAL Q\nQ=10\nSUB(Q)\nLIN {X Q}", &behind), x, "{head}");
    }
    let behind = "DEF SUB(A:IN,B:OUT)\nINT A\nREAL B\nB=A/2\nA=0\nEND\n";
    assert_eq!(krl_x("REAL P,Q\nP=7\nSUB(P,Q)\nLIN {X P+Q}", behind), 10.0);
    // An array as a whole, and one of the routine's own.
    let behind = "DEF SUB(A[]:OUT)\nREAL A[]\nREAL B[2]\nB[1]=5\nA[1]=A[2]+1\nEND\n";
    let body = "REAL B[2],Q[2]\nB[1]=1\nQ[1]=2\nQ[2]=40\nSUB(Q[])\nLIN {X Q[1]+B[1]}";
    assert_eq!(krl_x(body, behind), 42.0);
}

const ISRS: &str = "DEF ISR()\nLIN_REL {Z 50}\nEND\nDEF OUTER()\nISR()\nEND\n\
                    DEF QUIET()\n$OUT[3]=TRUE\nWAIT SEC 0.1\nEND\n\
                    DEF LOST()\nNOWHERE()\nEND\nDEF SPEEDS()\n$VEL.CP=1.5\nEND\n";

/// Components beside the one that the program sets are not those of the position before.
#[test]
fn positions_that_are_set_in_part_stay_unknown_elsewhere() {
    refused(krl_with("P.X=5\nLIN P", ""), "'p' is declared in no file that is read");
    let unknown = "FRAME P\nP=$IN[1]\nP.X=5\nLIN P";
    refused(krl_with(unknown, ""), "'$IN[1]' is known only at run time");
    let all = "P.X=5\nP.Y=0\nP.Z=9\nP.A=0\nP.B=0\nP.C=180\nLIN P";
    assert_eq!(krl_x(all, ""), 5.0);
    assert_eq!(krl_x("FRAME P\nP.X=5\nLIN P", ""), 5.0);
    let element = "REAL A[2]\nA[1]=5\nA[$ANIN[1]]=7\nLIN {X A[1]}";
    refused(krl_with(element, ""), "an element of 'a' was set");
}

#[test]
fn interrupts_and_triggers_of_krl_that_move_are_doubts() {
    let head = "GLOBAL INTERRUPT DECL 3 WHEN $STOPMESS==TRUE DO IR_STOPM ( )\nINTERRUPT ON 3\n\
                BAS (#INITMOV,0 )";
    let of = |body: &str| {
        let program = krl_with(&format!("{body}\nLIN_REL {{X 10}}"), ISRS).unwrap();
        doubts(&program)
    };
    assert_eq!(of(head), []);
    let decl = |isr: &str| format!("GLOBAL INTERRUPT DECL 21 WHEN $IN[3]==TRUE DO {isr}");
    for (isr, told) in [
        ("ISR()", true),
        ("OUTER()", true),
        ("LOST()", true),
        ("ELSEWHERE()", true),
        ("SPEEDS()", true),
        ("QUIET()", false),
        ("$OUT[5]=TRUE", false),
    ] {
        // Declared alone, it does not run.
        assert_eq!(of(&decl(isr)), [], "{isr}");
        let expected = if told { vec![(Code::MotionLeftOut, 5)] } else { vec![] };
        assert_eq!(of(&format!("{}\nINTERRUPT ON 21", decl(isr))), expected, "{isr}");
        assert_eq!(of(&format!("{}\nINTERRUPT ON", decl(isr))), expected, "{isr}");
        assert_eq!(of(&format!("{}\nINTERRUPT ON 20", decl(isr))).len(), 1, "{isr}");
        for when in ["DISTANCE=0 DELAY=0", "PATH=-20.0 DELAY=$TIMER[1]"] {
            let expected = if told { vec![(Code::MotionLeftOut, 4)] } else { vec![] };
            let trigger = format!("TRIGGER WHEN {when} DO {isr} PRIO=-1");
            assert_eq!(of(&trigger), expected, "{isr}");
            let spline = format!("SPLINE\n{trigger}\nSLIN {{X 5}}\nENDSPLINE");
            assert_eq!(of(&spline).len(), expected.len(), "{isr}");
        }
    }
    // Within a branch that only the run decides, too.
    let branch = format!("{}\nIF $IN[1] THEN\nINTERRUPT ON 21\nENDIF", decl("ISR()"));
    assert_eq!(of(&branch), [(Code::MotionLeftOut, 6)]);
    // What a trigger sets is not known afterwards.
    let body = "REAL D\nD=10\nTRIGGER WHEN DISTANCE=1 DELAY=0 DO D=20\nLIN_REL {X 1}\nLIN {X D}";
    refused(krl_with(body, ""), "'d' is set by a TRIGGER");
}

#[test]
fn functions_of_krl_run() {
    let twice = "DEFFCT REAL F(A:IN)\nREAL A\nRETURN A*2\nENDFCT\n";
    assert_eq!(krl_x("REAL X\nX=F(3)\nLIN {X X+F(10)}", twice), 26.0);
    let whole = "DEFFCT INT F(A:IN)\nREAL A\nIF A>2 THEN\nRETURN A*1.3\nENDIF\nRETURN 0\nENDFCT\n";
    assert_eq!(krl_x("LIN {X F(3)/3*10}", whole), 10.0);
    // By reference, and a position.
    let counts =
        "DEFFCT E6POS F(N:OUT)\nINT N\nN=N+1\nRETURN {X 5,Y 6,Z 7,A 0,B 0,C 180}\nENDFCT\n";
    assert_eq!(krl_x("INT N\nN=1\nLIN F(N)\nLIN {X N}", counts), 2.0);
    // Motions of a function are run, once each.
    let moves = "DEFFCT BOOL F(A)\nREAL A\nLIN_REL {X A}\nRETURN TRUE\nENDFCT\n\
                 DEF G(B:IN)\nBOOL B\nLIN_REL {Y 1}\nEND\n";
    let program = krl_with("IF F(10) THEN\nG(F(20))\nENDIF", moves).unwrap();
    let ends = [[0.0, 0.0, 100.0], [10.0, 0.0, 100.0], [30.0, 0.0, 100.0], [30.0, 1.0, 100.0]];
    assert_ends(&program, &[('T', ends[0]), ('L', ends[1]), ('L', ends[2]), ('L', ends[3])]);
    let branch = "IF $IN[1] THEN\nB=F(10)\nENDIF";
    refused(krl_with(branch, moves), "IF decides about motion at run time");
    let endless = "DEFFCT REAL F(A)\nREAL A\nRETURN F(A)+1\nENDFCT\n";
    refused(krl_with("LIN {X F(1)}", endless), "calls are nested too deep");
    let silent = "DEFFCT REAL F(A)\nREAL A\nENDFCT\n";
    refused(krl_with("LIN {X F(1)}", silent), "'F' ends without RETURN");
}

#[test]
fn traps_of_rapid_that_call_motion_are_doubts() {
    let target = "[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let of = |body: &str| {
        let text = module(&format!("MoveL {target},v5,fine,tool0;")).replace(
            "ENDMODULE",
            &format!(
                "TRAP t\n{body}\nENDTRAP\nPROC away()\nMoveL {target},v5,fine,tool0;\nENDPROC\n\
                 PROC outer()\nIF DInput(di1)=1 away;\nENDPROC\nPROC quiet()\nSetDO do1,1;\n\
                 TPWrite \"x\";\nENDPROC\nFUNC num f()\naway;\nRETURN 1;\nENDFUNC\nENDMODULE"
            ),
        );
        doubts(&run(&text, Dialect::Rapid, &settings()).unwrap())
    };
    for body in [
        "away;",
        "outer;",
        "nowhere 5;",
        "MoveJ p,v5,fine,tool0;",
        "SearchL di1,p,p,v5,tool0;",
        "IF a=1 THEN\nnowhere;\nENDIF",
        "%\"away\"%;",
        "x:=f();",
        "SpeedRefresh 300;",
        "RETURN;\nERROR\naway;",
    ] {
        assert_eq!(of(body), [(Code::MotionLeftOut, 6)], "{body}");
    }
    for body in [
        "",
        "quiet;",
        "StopMove;\nStorePath;\nWaitTime 1;\nRestoPath;\nStartMove;\nRETURN;",
        "n:=n+1;\nIF n>3 THEN\nSet do2;\nISleep i1;\nENDIF\nTEST n\nCASE 1:\nquiet;\nENDTEST",
    ] {
        assert_eq!(of(body), [], "{body}");
    }
}

fn tp(statements: &str, assumed: &[(&str, Assumed)]) -> Result<Program, Vec<Note>> {
    let point = |number: u32, x: f64| {
        format!(
            "P[{number}]{{\n GP1:\n UF : 0, UT : 0, CONFIG : 'N U T, 0, 0, 0',\n X = {x} mm, Y = 0 \
             mm, Z = 0 mm, W = 0 deg, P = 0 deg, R = 0 deg\n}};\n"
        )
    };
    let mut job = settings();
    job.assume.extend(assumed.iter().map(|(name, value)| ((*name).to_owned(), *value)));
    let points = [point(1, 100.0), point(2, 0.0)].concat();
    let text = format!("/PROG A\n/MN\nL P[2] 9mm/sec FINE ;\n{statements}/POS\n{points}/END\n");
    run(&text, Dialect::Fanuc, &job)
}

#[test]
fn components_of_position_registers_are_worked_out() {
    for (value, place) in [
        ("PR[1,2]=PR[1,1]*2", [100.0, 200.0, 0.0]),
        ("PR[1,1]=PR[1,1]/2", [50.0, 0.0, 0.0]),
        ("PR[1,1:x]=PR[1,1:x]+R[3]*2", [120.0, 0.0, 0.0]),
        ("PR[1,3]=5*(PR[1,1]-R[3])", [100.0, 0.0, 450.0]),
        ("PR[1,1]=PR[1,1]-PR[1,1]", [0.0, 0.0, 0.0]),
        ("PR[1,1]=(-PR[1,1]) DIV 3", [-33.0, 0.0, 0.0]),
        ("R[4]=PR[1,1] ;\nPR[1,2]=R[4]", [100.0, 100.0, 0.0]),
    ] {
        let text = format!("R[3]=10 ;\nPR[1]=P[1] ;\n{value} ;\nL PR[1] 9mm/sec FINE ;\n");
        let program = tp(&text, &[]).unwrap_or_else(|found| panic!("{value}: {found:?}"));
        assert_ends(&program, &[('L', [0.0; 3]), ('L', place)]);
    }
    for value in ["PR[1,1]=PR[1,1]^2", "PR[1,1]=PR[2,1]*2", "PR[1,1]=PR[1,9]"] {
        let text = format!("PR[1]=P[1] ;\n{value} ;\nL PR[1] 9mm/sec FINE ;\n");
        refused(tp(&text, &[]), "PR[1] is known only at run time");
    }
}

#[test]
fn system_variables_of_tp_that_motion_depends_on() {
    for name in [
        "$MNUFRAME[1,1]=PR[5]",
        "$MNUTOOL[1,2]=PR[6]",
        "$MNUFRAMENUM[1]=2",
        "$GROUP[1].$UTOOL=PR[1]",
        "$MCR_GRP[1].$PRGOVERRIDE=50",
        "$PARAM_GROUP[1].$SPEEDLIMJNT=50",
        "IF DI[1]=ON,$MNUFRAME[1,1]=PR[5]",
    ] {
        let found = tp(&format!("{name} ;\nL P[1] 9mm/sec FINE ;\n"), &[]).expect_err(name);
        assert_eq!((at(&found[0]), found.len()), (4, 1), "{name}: {found:?}");
    }
    let slow = tp("$MCR.$GENOVERRIDE=10 ;\nL P[1] 9mm/sec FINE ;\n", &[]).unwrap();
    assert!((slow.moves[1].feed_m_per_s - 0.0009).abs() < 1e-12, "{:?}", slow.moves);
    let unknown = "$MCR.$GENOVERRIDE=R[1] ;\nL P[1] 9mm/sec FINE ;\n";
    refused(tp(unknown, &[]), "R[1] is known only at run time");
    let payload = tp("$PAYLOAD=3 ;\nL P[1] 9mm/sec FINE ;\n", &[]).unwrap();
    assert_eq!(doubts(&payload), [(Code::ChangeIgnored, 4)]);
    for (set, told) in [
        ("$WAITTMOUT=200", vec![]),
        ("IF DI[1]=ON,$WAITTMOUT=200", vec![]),
        // A remark.
        ("$SHELL_CFG.$X=1", vec![(Code::LeftOut, 4)]),
    ] {
        let program = tp(&format!("{set} ;\nL P[1] 9mm/sec FINE ;\n"), &[]).unwrap();
        assert_eq!((doubts(&program), program.moves.len()), (told, 2), "{set}");
    }
}

#[test]
fn a_program_that_another_starts_is_a_doubt() {
    for call in ["CALL OTHER", "RUN OTHER"] {
        let program = tp(&format!("{call} ;\nL P[1] 9mm/sec FINE ;\n"), &[]).unwrap();
        assert_eq!(doubts(&program), [(Code::MotionLeftOut, 4)], "{call}");
        assert!(program.warnings.iter().any(|note| note.what.starts_with(call)), "{call}");
    }
    refused(tp("IF DI[1]=ON,RUN OTHER ;\n", &[]), "IF decides about motion");
}

#[test]
fn flags_of_tp_are_what_the_program_sets() {
    let jumps = |set: &str, condition: &str| {
        let text =
            format!("{set} ;\nIF {condition},JMP LBL[1] ;\nL P[1] 9mm/sec FINE ;\nLBL[1] ;\n");
        let assumed = [("f[1]", Assumed::Truth(false)), ("di[4]", Assumed::Truth(true))];
        tp(&text, &assumed).unwrap_or_else(|found| panic!("{set}: {found:?}")).moves.len() == 1
    };
    assert!(!jumps("DO[7]=ON", "F[1]=ON"));
    for (set, condition, expected) in [
        ("F[1]=(ON)", "F[1]=ON", true),
        ("F[1:x]=ON", "F[1]=ON", true),
        ("F[1]=(OFF)", "F[1]=ON", false),
        ("F[1]=(DI[4])", "F[1:part]=ON", true),
        ("F[2]=(!DI[4] OR F[1])", "F[2]=ON", false),
        ("DO[3]=ON", "DO[3]=OFF", false),
        ("R[5]=1 ;\nF[R[5]]=(ON)", "(F[1])", true),
        ("IF DI[4]=ON,F[1]=(ON)", "F[1]=ON", true),
    ] {
        assert_eq!(jumps(set, condition), expected, "{set} {condition}");
    }
    // What only the run knows is no longer what was assumed.
    for set in ["F[1]=(DI[9])", "IF DI[9]=ON,F[1]=(DI[9])"] {
        let text = format!(
            "F[1]=(ON) ;\n{set} ;\nIF F[1]=ON,JMP LBL[1] ;\nL P[1] 9mm/sec FINE ;\nLBL[1] ;\n"
        );
        let said = "F[1] is set to what is known only at run time";
        refused(tp(&text, &[("f[1]", Assumed::Truth(false))]), said);
    }
}

#[test]
fn jumps_of_krl() {
    let body = "INT N\nN=0\nAGAIN:\nN=N+1\nLIN_REL {X 10}\nIF N<3 THEN\nGOTO AGAIN\nENDIF\n\
                GOTO DONE\nLIN_REL {Y 99}\nDONE:";
    let program = krl_with(body, "").unwrap();
    assert_eq!(program.moves.len(), 4);
    assert_eq!((krl_x(body, ""), doubts(&program)), (30.0, vec![(Code::MotionLeftOut, 13)]));
    let out = "LOOP\nLIN_REL {X 10}\nGOTO DONE\nENDLOOP\nDONE:\nLIN_REL {X 1}";
    assert_eq!(krl_x(out, ""), 11.0);
    let endless = krl_with("AGAIN:\nLIN_REL {X 10}\nGOTO AGAIN\nLIN_REL {X 1}", "").unwrap();
    let told = vec![(Code::MotionLeftOut, 6), (Code::MotionLeftOut, 7)];
    assert_eq!((endless.moves.len(), doubts(&endless)), (2, told));
    let branch = "IF $IN[1] THEN\nGOTO DONE\nENDIF\nLIN_REL {X 1}\nDONE:";
    refused(krl_with(branch, ""), "IF decides about motion");
    refused(krl_with("GOTO ELSEWHERE", "DEF q()\nELSEWHERE:\nEND\n"), "no label 'elsewhere'");
    let spins = "INT N\nAGAIN:\nIF TRUE THEN\nGOTO AGAIN\nENDIF";
    refused(krl_with(spins, ""), "a loop without an end");
}

#[test]
fn faults_in_a_second_file_of_krl_name_it() {
    let mut job = settings();
    let other = "DEF SUB()\n\nLIN {X Q}\nWHAT @ IS\nEND\n";
    job.companions.push(Companion::new("sub.src".to_owned(), other.as_bytes()).unwrap());
    let text = format!("DEF p()\n{START}\n\n\nSUB()\nEND\n");
    let found = run(&text, Dialect::Krl, &job).unwrap_err();
    assert!(found.iter().all(|note| at(note) == 5), "{found:?}");
    let told = |said: &str| found.iter().any(|note| note.what.starts_with(said));
    assert!(told("sub.src:3: ") && told("sub.src:4: "), "{found:?}");
}
