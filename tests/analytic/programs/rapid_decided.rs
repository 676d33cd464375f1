//! RAPID: what the controller, traps, handlers of errors, other tasks and other modules decide.

use detune::notes::{Class, Code, Note};
use detune::program::{Assumed, Dialect, ExternalAxis, Program, SetBy, Setter, Settings, read};

use super::support::{assert_ends, at, module, settings};

pub(super) const MOVE: &str = "MoveL p,v5,fine,tool0;";
pub(super) const NEXT: &str = "MoveL Offs(p,10,0,0),v5,fine,tool0;";

/// Instructions from line 4 on, and data and routines behind them.
pub(super) fn run(body: &str, more: &str, job: &Settings) -> Result<Program, Vec<Note>> {
    let text = module(body).replace("ENDMODULE", &format!("{more}\nENDMODULE"));
    read(text.as_bytes(), Dialect::Rapid, job)
}

fn with(body: &str, more: &str) -> Result<Program, Vec<Note>> {
    run(body, more, &settings())
}

pub(super) fn assuming(name: &str, value: f64) -> Settings {
    Settings { assume: [(name.to_owned(), Assumed::Number(value))].into(), ..settings() }
}

pub(super) fn doubts(program: &Program) -> Vec<(Code, usize)> {
    let is_doubt = |note: &&Note| note.code.class() == Class::Doubt;
    program.warnings.iter().filter(is_doubt).map(|note| (note.code, at(note))).collect()
}

#[track_caller]
fn refused(found: Result<Program, Vec<Note>>, line: usize, said: &[&str]) {
    let found = found.expect_err("it is wrong");
    assert_eq!((at(&found[0]), found.len()), (line, 1), "{found:?}");
    for said in said {
        assert!(found[0].what.contains(said), "{said}: {found:?}");
    }
}

#[test]
fn what_changes_how_the_arm_moves_is_a_doubt_wherever_it_stands() {
    for call in [
        "SoftAct 1,50;",
        "TuneServo ROB_1,1,50;",
        "MotionProcessModeSet LOW_SPEED_STIFF_MODE;",
        "SpeedLimAxis ROB_1,1,10;",
        "SpeedLimCheckPoint 200;",
        "SyncMoveOn s1,tl;",
    ] {
        let found = with(&format!("{MOVE}\n{call}\n{NEXT}"), "").unwrap();
        assert_eq!(doubts(&found), [(Code::ChangeIgnored, 5)], "{call}");
        let found = with(&format!("{MOVE}\nIF di1=1 {call}\n{NEXT}"), "").unwrap();
        assert_eq!(doubts(&found), [(Code::ChangeIgnored, 5)], "{call}");
        let body = format!("{MOVE}\nCONNECT i1 WITH tr;\nISignalDI di1,1,i1;\n{NEXT}");
        let trap = format!("VAR intnum i1;\nTRAP tr\n{call}\nENDTRAP");
        let found = with(&body, &trap).unwrap();
        assert_eq!(doubts(&found), [(Code::MotionLeftOut, 10)], "{call}");
    }
}

/// MultiMove manual: a move that is not synchronised has no \ID, and the one that takes the longest
/// sets the speed of the others.
#[test]
fn a_move_with_an_id_may_wait_for_other_robots() {
    let go = "PROC Go(\\identno id)\nMoveL p\\ID?id,v5,fine,tool0;\nENDPROC";
    assert_eq!(doubts(&with("Go;", go).unwrap()), []);
    assert_eq!(doubts(&with("Go\\id:=10;", go).unwrap()), [(Code::ChangeIgnored, 7)]);
    let found = with(&format!("{MOVE}\nMoveL Offs(p,9,0,0)\\ID:=10,v5,fine,tool0;"), "").unwrap();
    assert_eq!(doubts(&found), [(Code::ChangeIgnored, 5)]);
}

/// The number of vmax is the robot's.
#[test]
fn a_cut_at_vmax_is_a_doubt() {
    const FAST: &str = "MoveL Offs(p,9,0,0),vmax,fine,tool0;";
    const GO: &str = "PROC Go(speeddata s)\nMoveL Offs(p,9,0,0),s,fine,tool0;\nENDPROC";
    let of = |body: &str, is_scheduled: bool| {
        let found = run(body, GO, &Settings { is_scheduled, ..settings() }).unwrap();
        let is_told = found.warnings.iter().any(|note| note.what.contains("vmax is taken"));
        (doubts(&found), is_told)
    };
    let doubt = |line: usize| (vec![(Code::ChangeIgnored, line)], true);
    assert_eq!(of(&format!("{MOVE}\n{FAST}"), false), doubt(5));
    assert_eq!(of(&format!("{MOVE}\nGo vmax;"), false), doubt(8));
    assert_eq!(of(&format!("{MOVE}\nSpeedRefresh 1;\n{FAST}\nSpeedRefresh 100;"), false), doubt(6));
    // In the air.
    let air = format!("{MOVE}\n{FAST}\n{NEXT}");
    assert_eq!(of(&air, false), (vec![], true));
    assert_eq!(of(&air, true), doubt(5));
    assert_eq!(of(&format!("{MOVE}\nMoveJ p,vmax,fine,tool0;"), false), (vec![], true));
    // Nothing is assumed.
    for stated in ["vmax\\V:=50", "vmax\\T:=2"] {
        let body = format!("{MOVE}\n{}", FAST.replace("vmax", stated));
        assert_eq!(of(&body, false), (vec![], false), "{stated}");
    }
    assert_eq!(of(&format!("VelSet 100,50;\n{MOVE}\n{FAST}"), false), (vec![], false));
    let stated = FAST.replace("vmax", "v5000");
    assert_eq!(of(&format!("{MOVE}\n{stated}"), false), (vec![], false));
    // A limit of what vmax is taken as does not say that it is so fast.
    assert_eq!(of(&format!("VelSet 100,5000;\n{MOVE}\n{FAST}"), false), doubt(6));
    // Shares.
    for share in
        ["[vmax.v_tcp/10,500,5000,1000]", "v5\\V:=vmax.v_tcp*0.02", "v5\\V:=Sqrt(vmax.v_tcp)"]
    {
        let body = format!("{MOVE}\n{}", FAST.replace("vmax", share));
        assert_eq!(of(&body, false), doubt(5), "{share}");
    }
    // No cut: it goes nowhere, or turns alone.
    for still in ["Offs(p,9,0,0)", "RelTool(p,9,0,0\\Rz:=20)"] {
        let body = format!("{MOVE}\n{FAST}\nMoveL {still},v5,fine,tool0;");
        assert_eq!(of(&body, false), doubt(5), "{still}");
    }
}

/// The number of vmax is the robot's, and what it decides is not known; its other parts are.
#[test]
fn a_comparison_with_vmax_is_known_where_the_robot_does_not_decide() {
    let of = |condition: &str| {
        let body = format!("sp:=vmax;\n{MOVE}\nIF {condition} {NEXT}");
        with(&body, "VAR speeddata sp;").map(|found| found.moves.len())
    };
    for (condition, moves) in
        [("sp.v_ori=500", 2), ("v100=vmax", 1), ("sp=vmax", 2), ("sp.v_tcp>100", 2)]
    {
        assert_eq!(of(condition), Ok(moves), "{condition}");
    }
    for condition in ["sp.v_tcp=5000", "sp.v_tcp>6000"] {
        let found = of(condition).expect_err(condition);
        assert!(found[0].what.contains("vmax is depends on the robot"), "{found:?}");
    }
}

#[test]
fn a_turning_speed_of_no_file_is_a_doubt() {
    let found = with(&format!("{MOVE}\n{}", NEXT.replace("v5", "[5,vElse,9,9]")), "").unwrap();
    assert_eq!(doubts(&found), [(Code::ChangeIgnored, 5)]);
}

#[test]
fn data_of_no_file_are_what_the_program_has_set_them_to() {
    for body in [
        "flag:=TRUE;\nIF flag THEN\nNEXT\nENDIF",
        "n:=0;\nIncr n;\nIF n=1 THEN\nNEXT\nENDIF",
        "s:=\"a\";\nIF s=\"a\" THEN\nNEXT\nENDIF",
        "n:=0;\nTwo n;\nIF n=2 THEN\nNEXT\nENDIF",
        "flag:=TRUE;\nWHILE flag DO\nNEXT\nflag:=FALSE;\nENDWHILE",
    ] {
        let two = "PROC Two(INOUT num m)\nm:=m+2;\nENDPROC";
        let found = with(&format!("{MOVE}\n{}", body.replace("NEXT", NEXT)), two).expect(body);
        // Others may set them, too.
        assert_eq!((found.moves.len(), doubts(&found).len()), (2, 1), "{:?}", found.warnings);
        assert!(found.warnings[0].what.contains("taken as the program has set it"));
    }
    let asked = format!("IF flag THEN\n{NEXT}\nENDIF");
    // What the job says of it comes too late.
    let job =
        Settings { assume: [("flag".to_owned(), Assumed::Truth(false))].into(), ..settings() };
    let found = run(&format!("{MOVE}\nflag:=TRUE;\n{asked}"), "", &job).unwrap();
    let told: Vec<_> = found.warnings.iter().map(|note| (note.code, at(note))).collect();
    assert_eq!((found.moves.len(), told), (2, vec![(Code::MotionLeftOut, 6), (Code::Unused, 6)]));
    // Who sets it besides is in no file either.
    let lost = with(&format!("{MOVE}\nflag:=TRUE;\nAsk;\n{asked}"), "");
    refused(lost, 7, &["'Ask' may set 'flag'", "path.program.files"]);
    let open = with(&format!("{MOVE}\nflag:=TRUE;\nIF di1=1 flag:=FALSE;\n{asked}"), "");
    refused(open, 7, &["'flag' depends on a condition"]);
    let waited = with(&format!("{MOVE}\nflag:=FALSE;\nWaitUntil flag;\n{asked}"), "");
    refused(waited, 7, &["another task sets it while WaitUntil waits"]);
    let found = with(&format!("{MOVE}\nflag:=TRUE;\nWHILE flag DO\n{NEXT}\nENDWHILE\n{MOVE}"), "");
    let found = found.unwrap();
    assert_eq!((found.moves.len(), doubts(&found)), (3, vec![(Code::MotionLeftOut, 6); 2]));
    // The next cycle starts with it.
    let found = run(&format!("{MOVE}\nIF n=0 {NEXT}\nn:=1;"), "", &assuming("n", 0.0)).unwrap();
    assert_eq!((found.moves.len(), doubts(&found)), (2, vec![(Code::MotionLeftOut, 3)]));
}

/// An argument by reference is another name of the same datum.
#[test]
fn a_datum_of_no_file_that_a_procedure_knows_by_two_names_is_a_doubt() {
    let of = |body: &str, inside: &str| {
        let more = format!(
            "PROC Cut(INOUT num d)\n{inside}\nENDPROC\nPROC SetUp()\nn:=9;\nENDPROC\n\
             PROC Two(INOUT num a,INOUT num b)\na:=7;\nENDPROC"
        );
        with(&format!("{MOVE}\nn:=2;\n{body}\n"), &more)
    };
    let moves = format!("{}\n", NEXT.replace("10", "n"));
    for inside in ["IF DInput(di1)=1 n:=5;", "n:=5;", "WaitUntil n=3;", "SetUp;"] {
        refused_both(of(&format!("Cut n;\n{moves}"), inside));
    }
    refused_both(of("Cut n;", &format!("d:=5;\n{moves}")));
    refused_both(of("Cut n;", &format!("n:=5;\n{}", NEXT.replace("10", "d"))));
    refused_both(of(&format!("Two n,n;\n{moves}"), ""));
    // What is told does not depend on whether the number counts.
    assert_eq!(doubts(&of("Cut n;", "n:=5;").unwrap()), [(Code::MotionLeftOut, 6)]);
    // By one name it is known.
    for (inside, told) in [("d:=5;", vec![6]), ("n1:=5;\nd:=n1;", vec![6, 13])] {
        let found = of(&format!("Cut n;\n{moves}"), inside).unwrap();
        let told = told.into_iter().map(|line| (Code::MotionLeftOut, line)).collect::<Vec<_>>();
        assert_eq!((found.moves.len(), doubts(&found)), (2, told), "{inside}");
    }
    let own = "PROC Cut(INOUT num n)\nn:=5;\nENDPROC";
    let found = with(&format!("{MOVE}\nn:=2;\nCut n;\n{moves}"), own).unwrap();
    assert_eq!(doubts(&found), [(Code::MotionLeftOut, 6)]);
    assert_ends(&found, &[('L', [100.0, 200.0, 300.0]), ('L', [105.0, 200.0, 300.0])]);
}

#[track_caller]
fn refused_both(found: Result<Program, Vec<Note>>) {
    let found = found.expect_err("it is not known");
    assert!(found[0].what.contains("uses it by another name, too"), "{found:?}");
}

/// A parameter that a procedure passes on as it has it is the same datum.
#[test]
fn an_optional_parameter_passed_on_comes_back() {
    let more = "PROC A(\\INOUT num d)\nB\\d?d;\nENDPROC\nPROC B(\\INOUT num d)\nd:=5;\nENDPROC";
    let body = format!("{MOVE}\nn:=2;\nA\\d:=n;\n{}", NEXT.replace("10", "n"));
    let found = with(&body, more).unwrap();
    assert_ends(&found, &[('L', [100.0, 200.0, 300.0]), ('L', [105.0, 200.0, 300.0])]);
}

/// `assume` gives no elements and no strings.
#[test]
fn what_the_job_says_of_an_array_of_other_tasks_settles_nothing() {
    for (data, asks) in [
        ("PERS num a{3}:=[1,2,3];", "a{1}=1"),
        ("PERS string a:=\"x\";", "a=\"x\""),
        ("PERS pos a:=[1,2,3];", "a.x=1"),
    ] {
        let body = format!("{MOVE}\nIF {asks} {NEXT}");
        let found = run(&body, data, &assuming("a", 7.0)).unwrap();
        assert_eq!(doubts(&found), [(Code::MotionLeftOut, 5)], "{data}");
        let told = found.warnings.iter().find(|note| note.code == Code::MotionLeftOut).unwrap();
        assert!(told.what.contains("declare it CONST in a copy"), "{told:?}");
    }
}

#[test]
fn an_array_that_others_set_is_given_by_its_file_or_a_copy() {
    let body = format!("{MOVE}\nGetSol a;\nMoveL Offs(p,a{{2}},0,0),v5,fine,tool0;");
    let said = ["GetSol", "path.program.files", "write the value into a copy"];
    for data in ["PERS num a{2};", "PERS num a{2}:=[1,2];"] {
        refused(with(&body, data), 6, &said);
        refused(run(&body, data, &assuming("a", 1.0)), 6, &said);
    }
}

#[test]
fn a_procedure_that_calls_itself_without_end_is_told_where_it_does() {
    let ask = "TPReadFK n,\"?\",\"a\",\"b\",\"\",\"\",\"\";";
    let more = format!("VAR num n;\nPROC A()\n{MOVE}\n{ask}\nIF n=1 A;\nENDPROC");
    let said = ["'A' calls itself more often than is read under what", "'n'", "another value"];
    refused(run("A;", &more, &assuming("n", 1.0)), 8, &said);
    assert_eq!(run("A;", &more, &assuming("n", 2.0)).unwrap().moves.len(), 1);
    let down =
        "PROC R(num i)\nIF i>0 THEN\nMoveL Offs(p,i,0,0),v5,fine,tool0;\nR i-1;\nENDIF\nENDPROC";
    assert_eq!(with("R 50;", down).unwrap().moves.len(), 50);
    refused(with("R 80;", down), 8, &["'R' calls itself more often than is read"]);
    // Nothing depends on the end.
    let still = "PROC R(num i)\nIF i>0 R i-1;\nENDPROC";
    assert_eq!(with(&format!("R 80;\n{MOVE}"), still).unwrap().moves.len(), 1);
}

/// Technical reference manual, ReadStr: at the end of the file it gives EOF, a constant string.
#[test]
fn what_a_channel_gives_ends_a_loop_up_to_eof() {
    let body = format!("{MOVE}\nWHILE s<>EOF DO\ns:=ReadStr(f);\n{NEXT}\nENDWHILE");
    refused(with(&body, "VAR string s:=\"\";"), 5, &["function 'ReadStr' is known only at run"]);
    let found = with(&format!("{MOVE}\nIF s<>EOF {NEXT}"), "VAR string s:=\"EOF\";").unwrap();
    assert_eq!(found.moves.len(), 1);
}

#[test]
fn a_loop_that_data_of_other_tasks_end_names_them() {
    let body = format!("{MOVE}\nWHILE d=FALSE DO\nn:=n+1;\nRd;\nENDWHILE\n{NEXT}");
    let more = "PERS num st:=0;\nVAR num n;\nVAR bool d;\nPROC Rd()\nIF st<>0 d:=TRUE;\nENDPROC";
    let found = with(&body, more).unwrap_err();
    assert_eq!((found.len(), found[0].code), (1, Code::TooLong));
    assert!(found[0].what.contains("assume: {\"st\": …}"), "{found:?}");
    assert_eq!(run(&body, more, &assuming("st", 1.0)).unwrap().moves.len(), 2);
}

/// Technical reference manual: it waits until the bool is FALSE, and sets it.
#[test]
fn wait_test_and_set_sets_its_bool() {
    for condition in ["", "IF b "] {
        let body = format!("WaitTestAndSet b;\n{condition}{NEXT}\nb:=FALSE;");
        for data in ["PERS bool b:=FALSE;", ""] {
            let found = with(&format!("{MOVE}\n{body}"), data).unwrap();
            // Of a bool of no file others may be the ones who set it.
            let told = usize::from(data.is_empty() && !condition.is_empty());
            let doubts = doubts(&found).len();
            assert_eq!((found.moves.len(), doubts), (2, told), "{:?}", found.warnings);
        }
    }
}

#[test]
fn a_record_in_a_string_is_read() {
    let data = "VAR robtarget r:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
                VAR num a{2};\nVAR bool ok;";
    let body = |text: &str, to: &str| format!("ok:=StrToVal(\"{text}\",{to});\n");
    let there = "MoveL r,v5,fine,tool0;";
    let found = with(&format!("{}{there}", body("[820,50,-620]", "r.trans")), data).unwrap();
    assert_ends(&found, &[('L', [820.0, 50.0, -620.0])]);
    let found = with(&format!("{}r.trans.y:=a{{2}};\n{there}", body("[5,6]", "a")), data).unwrap();
    assert_ends(&found, &[('L', [1.0, 6.0, 3.0])]);
    // What has to be worked out is no value, nor is a byte beyond 255.
    for text in ["5!c", "(5)", "--5", "0x10"] {
        let data = "VAR num n;\nVAR bool ok;";
        let body = format!("{}MoveL Offs(p,n,0,0),v5,fine,tool0;", body(text, "n"));
        refused(with(&body, data), 5, &["StrToVal"]);
    }
    let byte = format!("{}MoveL Offs(p,n,0,0),v5,fine,tool0;", body("300", "n"));
    refused(with(&byte, "VAR byte n;\nVAR bool ok;"), 5, &["StrToVal"]);
    for text in ["[820,50]", "[820,50,TRUE]", "820", "[820,50,x]"] {
        refused(with(&format!("{}{there}", body(text, "r.trans")), data), 5, &["StrToVal"]);
    }
}

#[test]
fn what_set_data_val_sets_is_known_only_at_run_time() {
    let data = "VAR num k:=10;\nVAR string nm:=\"k\";\nCONST num c:=1;";
    let body = |head: &str| format!("{MOVE}\n{head}\nMoveL Offs(p,k,0,0),v5,fine,tool0;");
    for head in ["SetDataVal \"k\",5;", "SetDataVal nm,5;"] {
        refused(with(&body(head), data), 6, &["SetDataVal sets 'k'"]);
    }
    for head in ["SetDataVal ReadStr(f),5;", "SetDataVal \"elsewhere\",5;", "SetDataVal \"c\",5;"] {
        assert_eq!(doubts(&with(&body(head), data).unwrap()), [(Code::MotionLeftOut, 5)], "{head}");
    }
}

/// Handlers are left out, and what they set may decide.
#[test]
fn a_condition_on_what_a_handler_sets_is_a_doubt_where_it_decides_about_moves() {
    let of = |body: &str, handler: &str| {
        let get =
            format!("VAR num n:=0;\nPROC Get()\nSet do1;\nERROR\n{handler}\nTRYNEXT;\nENDPROC");
        doubts(&with(&format!("{MOVE}\nGet;\n{body}"), &get).unwrap())
    };
    let decides = format!("IF n<1 {NEXT}");
    for handler in ["n:=2;", "IF ERRNO=ERR_X THEN\nn:=2;\nENDIF", "Incr n;"] {
        assert_eq!(of(&decides, handler), [(Code::MotionLeftOut, 6)], "{handler}");
    }
    assert_eq!(of(&decides, "TPWrite \"n\"\\Num:=n;"), []);
    assert_eq!(of("IF n<1 SetDO do2,1;", "n:=2;"), []);
    // Its own.
    let own = format!("VAR num m:=0;\n{decides}\nERROR\nm:=2;\nRETRY;").replace("n<1", "m<1");
    assert_eq!(doubts(&with(&format!("{MOVE}\n{own}"), "").unwrap()), [(Code::MotionLeftOut, 6)]);
    assert_eq!(of(&own[..own.find("\nERROR").unwrap()], "m:=2;"), []);
}

#[test]
fn what_a_handler_sets_is_followed_through_calls_and_its_own_names() {
    let of = |body: &str, more: &str| doubts(&with(&format!("{MOVE}\n{body}"), more).unwrap());
    let asks = |condition: &str| format!("ok:=TRUE;\nT;\nIF {condition} {NEXT}");
    let handler = |head: &str, handler: &str| {
        format!("VAR bool ok;\n{head}\nSet do1;\nERROR\n{handler}\nTRYNEXT;\nENDPROC")
    };
    let doubt = [(Code::MotionLeftOut, 7)];
    for set in ["Fail;", "Put ok;", "Ext ok;", "SetDataVal \"ok\",FALSE;"] {
        let more = format!(
            "{}\nPROC Fail()\nok:=FALSE;\nENDPROC\nPROC Put(INOUT bool b)\nb:=FALSE;\nENDPROC",
            handler("PROC T()", set)
        );
        assert_eq!(of(&asks("ok"), &more), doubt, "{set}");
    }
    let by_argument = handler("PROC T(INOUT bool b)", "b:=FALSE;");
    assert_eq!(of(&asks("ok").replace("T;", "T ok;"), &by_argument), doubt);
    // A function.
    for function in [
        "FUNC bool F()\nRETURN TRUE;\nERROR\nRETURN FALSE;\nENDFUNC",
        "FUNC bool F()\nVAR bool a:=TRUE;\nRETURN a;\nERROR\na:=FALSE;\nTRYNEXT;\nENDFUNC",
    ] {
        assert_eq!(of(&format!("IF F() {NEXT}"), function), [(Code::MotionLeftOut, 5)]);
        let more = format!("VAR bool ok;\n{function}");
        let body = format!("ok:=F();\nIF ok {NEXT}");
        assert_eq!(of(&body, &more), [(Code::MotionLeftOut, 6)]);
    }
    // The handler's own, a constant, a procedure that never runs.
    let own = handler("PROC T()\nVAR bool ok;", "ok:=FALSE;");
    assert_eq!(of(&asks("ok"), &own), []);
    let constant = handler("PROC T()", "k:=2;").replace("VAR bool ok;", "CONST num k:=1;");
    assert_eq!(of(&format!("T;\nIF k=1 {NEXT}"), &constant), []);
    let never = handler("PROC Never()", "ok:=FALSE;");
    assert_eq!(of(&asks("ok").replace("T;\n", ""), &never), []);
}

/// Technical reference manual, WaitUntil: it waits until the condition is met.
#[test]
fn behind_wait_until_what_the_job_assumes_holds_no_longer_where_it_waits_for_another_value() {
    let truth = |name: &str, value: bool| (name.to_owned(), Assumed::Truth(value));
    let number = |name: &str, value: f64| (name.to_owned(), Assumed::Number(value));
    let assume =
        [truth("di1", true), truth("di2", false), number("gi1", 1.0), number("opmode", 1.0)];
    let job = Settings { assume: assume.into(), ..settings() };
    let more = "FUNC bool IsOff()\nRETURN di1=0;\nENDFUNC";
    let of = |wait: &str, asks: &str| {
        run(&format!("{MOVE}\nWaitUntil {wait};\nIF {asks} {NEXT}"), more, &job)
    };
    for wait in [
        "di1=0",
        "0=di1",
        "di1=low",
        "di1<>1",
        "NOT di1=1",
        "di1=0 AND di2=0",
        "di1=0 OR di2=1",
        "DInput(di1)=0",
        "TestDI(di1)=FALSE",
        "\\InPos,di1=0",
        "di1=0\\MaxTime:=5",
        "IsOff()",
    ] {
        refused(of(wait, "di1=0"), 6, &["'di1' is not known here", "waits for another value"]);
    }
    for wait in ["GInput(gi1)=3", "gi1>2"] {
        refused(of(wait, "GInput(gi1)=3"), 6, &["'gi1' is not known here"]);
    }
    refused(of("OpMode()=2", "OpMode()=2"), 6, &["'OpMode' is not known here"]);
    // What it does not wait for otherwise holds.
    for (wait, asks, moves) in
        [("di1=1", "di1=1", 2), ("di1=0 AND di2=0", "di2=0", 2), ("gi1<2", "gi1=1", 2)]
    {
        let found = of(wait, asks).unwrap();
        assert_eq!((found.moves.len(), doubts(&found)), (moves, vec![]), "{wait}");
    }
    // Data of all tasks, which the job has otherwise.
    let job = Settings { assume: [truth("go", false)].into(), ..settings() };
    let body = format!("{MOVE}\nWaitUntil go;\nIF go {NEXT}");
    let found = run(&body, "PERS bool go:=FALSE;", &job).unwrap_err();
    assert!(found[0].what.contains("WaitUntil waits for another value"), "{found:?}");
    // And what a trap sets.
    let body = body.replace("WaitUntil", "CONNECT i1 WITH tr;\nWaitUntil");
    let trap = "VAR bool go;\nVAR intnum i1;\nTRAP tr\ngo:=TRUE;\nENDTRAP";
    refused(run(&body, trap, &job), 7, &["WaitUntil waits for another value"]);
    // The next cycle starts as the first.
    let job = Settings { assume: [truth("di1", true)].into(), ..settings() };
    let body = format!("{MOVE}\nb:=di1=1;\nWaitUntil di1=0;\nIF b {NEXT}");
    let found = run(&body, "VAR bool b;", &job).unwrap();
    assert_eq!((found.moves.len(), doubts(&found)), (2, vec![]));
}

/// The controller loads no program that compares a string with a number.
#[test]
fn what_is_compared_with_a_string_assume_does_not_give() {
    // What it is written from.
    refused(
        with(&format!("{MOVE}\nIF NumToStr(n,0)=\"1\" {NEXT}"), ""),
        5,
        &["assume: in the job"],
    );
    let asks = [
        format!("IF sMode=\"auto\" {NEXT}"),
        format!("TEST sMode\nCASE \"auto\": {NEXT}\nDEFAULT:\nENDTEST"),
        format!("IF \"auto\"<>sMode {NEXT}"),
    ];
    for asks in &asks {
        let body = format!("{MOVE}\n{asks}");
        let found = with(&body, "").expect_err(asks);
        assert!(found[0].what.contains("path.program.files"), "{found:?}");
        assert!(!found[0].what.contains("assume: "), "{found:?}");
        let said = ["expected a string, found 1", "write the value into a copy"];
        refused(run(&body, "", &assuming("smode", 1.0)), 5, &said);
        let called = body.replace("sMode", "GetMode()");
        let found = with(&called, "").expect_err(asks);
        assert!(!found[0].what.contains("assume: "), "{found:?}");
        refused(run(&called, "", &assuming("getmode", 1.0)), 5, &said);
    }
}

#[test]
fn the_feed_of_the_job_for_two_speeds_of_no_file_is_a_doubt() {
    let of = |speeds: [&str; 2]| {
        let [first, second] = speeds.map(|speed| NEXT.replace("v5", speed));
        doubts(&with(&format!("{MOVE}\n{first}\n{}", second.replace("10", "20")), "").unwrap())
    };
    assert_eq!(of(["v75", "v25"]), [(Code::ChangeIgnored, 6)]);
    assert_eq!(of(["v75", "v75"]), []);
    assert_eq!(of(["v75", "v10"]), []);
    // Of the second cycle, in which both have stood before, nothing more is told.
    let [first, second] = ["10", "20"].map(|x| NEXT.replace("v5", "s").replace("10", x));
    let body = format!("{MOVE}\ns:=v75;\n{first}\ns:=v25;\n{second}");
    let found = with(&body, "VAR speeddata s;");
    assert_eq!(doubts(&found.unwrap()), [(Code::ChangeIgnored, 8)]);
}

/// The index counts 1, 2: 10 mm at 50 mm/s, then at 5 mm/s.
#[test]
fn a_function_in_the_index_of_a_speed_runs_once_for_a_move() {
    let speeds = "VAR speeddata s{2}:=[[50,500,5000,1000],[5,500,5000,1000]];";
    let more = format!("VAR num k;\n{speeds}\nFUNC num Nx()\nk:=k+1;\nRETURN k;\nENDFUNC");
    let next = NEXT.replace("v5", "s{Nx()}");
    let body = format!("{MOVE}\nk:=0;\n{next}\n{}", next.replace("10", "20"));
    let found = with(&body, &more).unwrap();
    let feeds: Vec<f64> = found.moves.iter().map(|each| each.feed_m_per_s).collect();
    assert_eq!(feeds[1..], [0.05, 0.005]);
}

/// 30° take 3 s at 10 °/s, and the feed of the job is 10 mm/s.
#[test]
fn a_turn_at_a_speed_of_no_file_is_a_doubt_where_the_way_takes_less_time() {
    let of = |x: &str, speed: &str| {
        let turn = format!("MoveL RelTool(p,{x},0,0\\Rz:=30),{speed},fine,tool0;");
        doubts(&with(&format!("{MOVE}\n{turn}"), "").unwrap())
    };
    for (x, speed) in [("0", "v75"), ("20", "v75"), ("20", "v75\\V:=10")] {
        assert_eq!(of(x, speed), [(Code::ChangeIgnored, 5)], "{x} {speed}");
    }
    for (x, speed) in [("50", "v75"), ("20", "v75\\V:=5"), ("0", "v75\\T:=2"), ("0", "v80")] {
        assert_eq!(of(x, speed), [], "{x} {speed}");
    }
    // Between joints that are known.
    let of = |turned: &str, speed: &str| {
        let to = |at: &str, speed: &str| {
            format!("MoveAbsJ [[0,0,0,0,30,{at}],[9E9,9E9,9E9,9E9,9E9,9E9]],{speed},fine,tool0;")
        };
        doubts(&with(&format!("{}\n{}", to("0", "v5"), to(turned, speed)), "").unwrap())
    };
    assert_eq!(of("180", "v75"), [(Code::ChangeIgnored, 5)]);
    assert_eq!(of("0", "v75"), []);
    assert_eq!(of("180", "v80"), []);
    // An external axis.
    let mut job = Settings { joint_count: 7, ..settings() };
    job.external_axes.insert("eax_a".to_owned(), ExternalAxis { joint: 0, slides: true });
    let rail = |at: &str, speed: &str| {
        format!(
            "MoveL [[100,200,300],[1,0,0,0],[0,0,0,0],[{at},9E9,9E9,9E9,9E9,9E9]],{speed},fine,tool0;"
        )
    };
    let slid = |speed: &str| {
        let found = run(&format!("{}\n{}", rail("0", "v5"), rail("50", speed)), "", &job).unwrap();
        doubts(&found)
    };
    assert_eq!(slid("v75"), [(Code::ChangeIgnored, 5)]);
    assert_eq!(slid("v80"), []);
}

/// v7000 is 7000 mm/s.
#[test]
fn vmax_that_the_program_sets_is_a_doubt() {
    let body = format!("{MOVE}\nvmax:=v7000;\n{}", NEXT.replace("v5", "vmax"));
    let found = with(&body, "").unwrap();
    assert_eq!(doubts(&found), [(Code::ChangeIgnored, 5)]);
    assert_eq!(found.moves[1].feed_m_per_s, 7.0);
    refused(with(&body.replace("vmax", "v100"), ""), 5, &["is constant and is set here"]);
    // By reference.
    let set = |sets: &str| format!("PROC Sv(INOUT speeddata s)\n{sets}\nENDPROC");
    let body = body.replace("vmax:=v7000", "Sv vmax");
    let found = with(&body, &set("s:=v7000;")).unwrap();
    let codes: Vec<Code> = doubts(&found).into_iter().map(|(code, _)| code).collect();
    assert_eq!((codes, found.moves[1].feed_m_per_s), (vec![Code::ChangeIgnored], 7.0));
    let slow = format!("{body}\n{}", NEXT.replace("10", "20"));
    let found = with(&slow, &set("TPWrite \"s\";")).unwrap();
    assert_eq!((doubts(&found), found.moves[1].feed_m_per_s), (vec![], 5.0));
}

#[test]
fn an_array_that_a_trap_sets_a_copy_gives() {
    let body = format!("{MOVE}\nCONNECT i1 WITH tr;\nIF n{{1}}=0 {NEXT}");
    let more = "VAR num n{2};\nVAR intnum i1;\nTRAP tr\nn{1}:=1;\nENDTRAP";
    let found = run(&body, more, &assuming("n", 0.0)).unwrap_err();
    assert!(found[0].what.contains("write the value into a copy"), "{found:?}");
    assert!(!found[0].what.contains("assume: in the job"), "{found:?}");
}

#[test]
fn a_move_by_a_name_in_a_string_is_that_move() {
    let call = NEXT.replace("MoveL", "%s%");
    let found = with(&format!("s:=\"MoveL\";\n{MOVE}\n{call}"), "VAR string s;").unwrap();
    assert_ends(&found, &[('L', [100.0, 200.0, 300.0]), ('L', [110.0, 200.0, 300.0])]);
    assert_eq!(doubts(&found), []);
}

#[test]
fn a_target_that_a_procedure_of_no_file_may_set_names_it() {
    let body = format!("{MOVE}\nCalcX;\nMoveL q,v5,fine,tool0;");
    let said = ["'CalcX', which is in no file", "path.program.files"];
    refused(with(&body, "VAR robtarget q;"), 6, &said);
}

#[test]
fn a_shift_by_a_number_of_no_file_is_given_by_the_job() {
    for shifted in [
        "Offs(p,nUp,0,0)",
        "Offs(p,-nUp,0,0)",
        "Offs(p,2*nUp,0,0)",
        "RelTool(p,0,0,nUp)",
        "RelTool(p,0,0,0\\Rz:=nUp)",
    ] {
        let body = format!("MoveL {shifted},v5,fine,tool0;");
        refused(with(&body, ""), 4, &["assume: {\"nUp\": …} in the job can give it"]);
        assert_eq!(run(&body, "", &assuming("nup", 5.0)).unwrap().moves.len(), 1);
    }
}

#[test]
fn data_of_one_name_in_two_procedures_to_which_assume_gives_one_answer_are_a_doubt() {
    let asks = format!("VAR num k;\nTPReadNum k,\"?\";\nIF k=1 {NEXT}\nENDPROC");
    let more = format!("PROC A()\n{asks}\nPROC B()\n{asks}");
    let of = |calls: &str| {
        doubts(&run(&format!("{MOVE}\n{calls}"), &more, &assuming("k", 1.0)).unwrap())
    };
    assert_eq!(of("A;\nB;"), [(Code::MotionLeftOut, 15)]);
    assert_eq!(of("A;\nA;"), []);
    // One that is only shown, and one datum by two names.
    let shows = more.replacen(&format!("IF k=1 {NEXT}"), "IF k=1 TPWrite \"\"\\Num:=k;", 1);
    let of = |calls: &str, more: &str| {
        doubts(&run(&format!("{MOVE}\n{calls}"), more, &assuming("k", 1.0)).unwrap())
    };
    assert_eq!(of("A;\nB;", &shows), []);
    let given = format!("VAR num n1;\nVAR num n2;\n{}", more.replace("VAR num k;", ""))
        .replace("A()", "A(INOUT num k)")
        .replace("B()", "B(INOUT num k)");
    assert_eq!(of("A n1;\nB n1;", &given), []);
    assert_eq!(of("A n1;\nB n2;", &given).len(), 1);
}

#[test]
fn what_a_trap_or_a_handler_sets_for_later_moves_is_a_doubt() {
    let what = Setter::Signal("goS".to_owned());
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    let left_out = |body: &str, more: &str| {
        let found = run(&format!("SetGO goS,3000;\n{MOVE}\n{body}\n{NEXT}"), more, &job).unwrap();
        let told = found.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
        told.map(at).collect::<Vec<_>>()
    };
    const NONE: [usize; 0] = [];
    for (sets, told) in [
        ("SetGO goS,500;", true),
        ("Reset goS;", true),
        ("VelSet 50,500;", true),
        ("vmax:=v100;", true),
        ("Give goS;", true),
        ("PDispSet [[0,0,1],[1,0,0,0]];", true),
        ("Reset do1;", false),
        ("n:=1;", false),
    ] {
        let give = "VAR num n;\nPROC Give(VAR signalgo s)\nSetGO s,5;\nENDPROC";
        let trap = format!("VAR intnum i1;\nTRAP tr\n{sets}\nENDTRAP\n{give}");
        let found = left_out("CONNECT i1 WITH tr;", &trap);
        assert_eq!(found, if told { vec![10] } else { vec![] }, "{sets}");
        for (end, goes_on) in [
            ("TRYNEXT;", true),
            ("", true),
            ("IF n=5 EXIT;", true),
            ("RAISE;", false),
            ("Off;\nRAISE;", false),
            ("EXIT;", false),
        ] {
            let give = format!("{give}\nPROC Off()\nIF n=1 RETURN;\nENDPROC");
            let get = format!("PROC Get()\nSet do1;\nERROR\n{sets}\n{end}\nENDPROC\n{give}");
            let found = left_out("Get;", &get);
            assert_eq!(found, if told && goes_on { vec![9] } else { vec![] }, "{sets} {end}");
        }
    }
    assert_eq!(left_out("", ""), NONE);
    let more = "PROC Get(VAR signalgo s)\nSet do1;\nERROR\nSetGO s,5;\nTRYNEXT;\nENDPROC";
    assert_eq!(left_out("Get goS;", more), [9]);
    // The caller goes on.
    let more = "PROC Get()\nSub;\nERROR\nTRYNEXT;\nENDPROC\n\
                PROC Sub()\nSet do1;\nERROR\nVelSet 50,500;\nRAISE;\nENDPROC";
    assert_eq!(left_out("Get;", more), [14]);
}
