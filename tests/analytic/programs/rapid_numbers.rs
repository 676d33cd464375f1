//! RAPID: a num has single precision, and what that decides. Each number here is worked out by hand from IEEE 754
//! single precision: 2.4 is 2.40000010, 0.8 is 0.80000001, their quotient 3.00000007, and rounded 3.

use detune::notes::Note;
use detune::program::{Dialect, Program, read};

use super::support::{end, faults, module, settings};

fn rapid(body: &str) -> Result<Program, Vec<Note>> {
    read(module(body).as_bytes(), Dialect::Rapid, &settings())
}

/// What is added to the x of a target, mm.
#[track_caller]
fn x(before: &str, number: &str) -> f64 {
    let text = format!("{before}\nMoveL Offs(p,{number},0,0),v5,fine,tool0;");
    let found = rapid(&text).unwrap_or_else(|found| panic!("{text}: {found:?}"));
    ((end(&found.moves[0]).1.translation.x - 0.1) * 1e9).round() / 1e6
}

#[test]
fn functions_that_jump_give_what_single_precision_gives() {
    for (number, expected) in [
        ("Trunc(2.4/0.8)", 3.0),
        ("Trunc(0.3/0.1)", 3.0),
        ("0.6 DIV 0.2", 3.0),
        ("2.4 MOD 0.8", 0.0),
        // 3.6 is 3.59999990 and 1.2 is 1.20000005.
        ("Trunc(3.6/1.2)", 2.0),
        ("3.6 DIV 1.2", 2.0),
        ("Trunc(7/2)", 3.0),
        ("Trunc(-7/2)", -3.0),
        ("7 DIV 2", 3.0),
        ("7 MOD 4", 3.0),
        // A quotient of whole numbers is exact: 4194302.75 has too many digits for a num.
        ("16777211 DIV 4-4194300", 2.0),
        ("16777211 MOD 4", 3.0),
        ("Round(2.5)", 3.0),
        ("Round(-2.5)", -3.0),
        ("Round(0.125\\Dec:=2)", 0.13),
        ("Trunc(1.26\\Dec:=1)", 1.2),
        ("Trunc(Sqrt(9))", 3.0),
        ("Max(Abs(-1.5),0.5)", 1.5),
    ] {
        assert_eq!(x("", number), expected, "{number}");
    }
    // What a num keeps is rounded: 28.9999992 to 29.
    assert_eq!(x("VAR num n;\nn:=0.29*100;", "Trunc(n)"), 29.0);
    let count = |last: &str| {
        let body = format!("FOR i FROM 1 TO {last} DO\nMoveL p,v5,fine,tool0;\nENDFOR");
        rapid(&body).unwrap().moves.len()
    };
    assert_eq!([count("2.4/0.8"), count("3.6/1.2"), count("Trunc(2.4/0.8)")], [3, 2, 3]);
    let row = "VAR num a{3}:=[10,20,30];\nVAR num h:=2.4;\nVAR num s:=0.8;";
    assert_eq!(x(row, "a{h/s}"), 30.0);
    let test = "TEST Trunc(2.4/0.8)\nCASE 3: MoveL p,v5,fine,tool0;\nENDTEST";
    assert_eq!(rapid(test).unwrap().moves.len(), 1);
}

/// 0.29 is 0.28999999, and a hundred times that 28.9999992, which single precision rounds to 29.
#[test]
fn where_a_function_jumps_by_what_is_rounded_between_the_result_is_not_known() {
    for number in [
        "Trunc(0.29*100)",
        "0.29*100 DIV 1",
        "0.29*100 MOD 1",
        "Trunc(0.7*10)",
        "Round(1.005*100)",
        "Round(1.005\\Dec:=2)",
        "Trunc(3*Cos(0.001))",
        // More whole numbers than a num has digits.
        "16777216+1-16777215",
    ] {
        let found =
            faults(&module(&format!("MoveL Offs(p,{number},0,0),v5,fine,tool0;")), Dialect::Rapid);
        let said = "rounding decides about a number near";
        assert!(found[0].what.contains(said), "{number}: {found:?}");
    }
    let index = "VAR num a{3}:=[10,20,30];\nMoveL Offs(p,a{3.6/1.2},0,0),v5,fine,tool0;";
    assert!(rapid(index).unwrap_err()[0].what.contains("count in whole numbers"));
    let count = "FOR i FROM 1 TO 0.29*100 DO\nMoveL p,v5,fine,tool0;\nENDFOR";
    let found = rapid(count).unwrap_err();
    assert!(found[0].what.contains("FOR decides about motion at run time"), "{found:?}");
    assert!(!found[0].what.contains("assume"), "{found:?}");
}

/// 1/41 is 0.0243902430, and 41 times that 0.99999996, which single precision rounds to 0.99999994; in double it is
/// 1.
const BELOW_ONE: &str = "VAR num a{3}:=[10,20,30];\nVAR robtarget q;\nVAR num y;\ny:=1/41;\ny:=y*41;\nq:=p;\n\
                         q.trans.x:=0;\nq:=Offs(q,y,0,0);";

#[test]
fn what_functions_give_is_no_more_exact_than_what_they_are_given() {
    assert_eq!([x(BELOW_ONE, "Trunc(y)"), x(BELOW_ONE, "Trunc(q.trans.x)")], [0.0; 2]);
    // Of exact numbers the result is exact.
    assert_eq!(x("VAR num n:=3;", "Trunc(Sqrt(n*n))+Trunc(VectMagn([0,n,4]))"), 8.0);
    for last in [
        "MoveL Offs(p,Trunc(Sqrt(y)),0,0),v5,fine,tool0;",
        "MoveL Offs(p,Pow(y,1) DIV 1,0,0),v5,fine,tool0;",
        "MoveL Offs(p,Trunc(VectMagn([y,0,0])),0,0),v5,fine,tool0;",
        "MoveL Offs(p,Trunc(DnumToNum(SqrtDnum(NumToDnum(Sqrt(y))))),0,0),v5,fine,tool0;",
        "MoveL Offs(p,a{Sqrt(y)},0,0),v5,fine,tool0;",
        "IF Sqrt(y)<1 MoveL p,v5,fine,tool0;",
        "IF Sqrt(y)=1 MoveL p,v5,fine,tool0;",
        "FOR i FROM 1 TO Sqrt(y) DO\nMoveL p,v5,fine,tool0;\nENDFOR",
    ] {
        let found = rapid(&format!("{BELOW_ONE}\n{last}")).expect_err(last);
        assert!(found[0].what.contains("count in whole numbers"), "{last}: {found:?}");
    }
}

/// A num has whole numbers up to 2^24, a dnum up to 2^53.
#[test]
fn whole_numbers_beyond_those_of_a_num() {
    assert_eq!(x("VAR num n;\nn:=16777217;\nn:=n-16777210;", "n"), 6.0);
    assert_eq!(x("VAR num n;\nn:=16777217;", "10*(n-16777000)"), 2160.0);
    assert_eq!(x("VAR num n:=16777216;\nIncr n;", "n-16777215"), 1.0);
    let dnum = "VAR dnum d;\nd:=16777217;\nd:=d-16777210;";
    assert_eq!(x(dnum, "DnumToNum(d)"), 7.0);
    assert_eq!(x("VAR dnum d:=2.4;\nd:=d/0.8;", "DnumToNum(TruncDnum(d))"), 2.0);
    assert_eq!(x("VAR num n:=3;\nVAR dnum d;\nd:=NumToDnum(n)*10;", "DnumToNum(d)"), 30.0);
    // 9E9 is one number, whoever has it.
    let absent = "IF p.extax.eax_a=9E9 THEN\nMoveL p,v5,fine,tool0;\nENDIF";
    assert_eq!(rapid(absent).unwrap().moves.len(), 1);
}

/// Technical reference manual: the examples of StrFind, StrMatch, NumToStr and ValToStr; a num has six digits there.
#[test]
fn strings_and_numbers() {
    for (number, expected) in [
        ("StrFind(\"Robotics\",1,\"aeiou\")", 2.0),
        ("StrFind(\"Robotics\",1,\"aeiou\"\\NotInSet)", 1.0),
        ("StrFind(\"Robotics\",5,\"xyz\")", 9.0),
        ("StrMatch(\"Robotics\",1,\"bo\")", 3.0),
        ("StrMatch(\"Robotics\",4,\"bo\")", 9.0),
        ("StrMatch(\"0.385\",1,NumToStr(0.3852138754,3))", 1.0),
        ("StrMatch(\"2.40\",1,NumToStr(2.4,2))", 1.0),
        ("StrMatch(\"1.23457\",1,ValToStr(1.234567890123))", 1.0),
        ("StrMatch(\"-12.5\",1,ValToStr(-12.5))", 1.0),
        ("StrMatch(\"3\",1,ValToStr(2.4/0.8))", 1.0),
        ("StrLen(ValToStr(TRUE))", 4.0),
        ("StrLen(\"go\"+ValToStr(10))", 4.0),
        ("StrFind(\"ab3\",1,STR_DIGIT)", 3.0),
        // A quote and a backslash are written twice, and characters by their codes.
        ("StrLen(\"say \"\"x\"\"\")", 7.0),
        ("StrLen(\"\\0D\")", 1.0),
        ("StrMatch(\"C:\\\\cut\",1,\"cut\")", 4.0),
        ("StrFind(\"AB c\",1,STR_WHITE)", 3.0),
        ("StrFind(\"ABc\",1,STR_UPPER\\NotInSet)", 3.0),
        ("StrFind(\"ABc\",1,STR_LOWER)", 3.0),
    ] {
        assert_eq!(x("", number), expected, "{number}");
    }
    assert_eq!(x("VAR num n;\nVAR bool ok;\nok:=StrToVal(\"2.5\",n);", "n"), 2.5);
    // A dnum has more digits.
    assert_eq!(x("VAR dnum d:=1234567;", "StrLen(ValToStr(d))"), 7.0);
    // Of functions that are not read assume says nothing.
    for asked in ["StrOrder(\"a\",\"b\",STR_UPPER)", "StrDigCmp(\"1\",EQ,\"2\")"] {
        let found = rapid(&format!("IF {asked} MoveL p,v5,fine,tool0;")).unwrap_err();
        assert!(found[0].what.contains("is not read: write the value"), "{found:?}");
        assert!(!found[0].what.contains("assume"), "{found:?}");
    }
}

/// The second side of AND or OR need not be worked out where the first decides.
#[test]
fn strtoval_behind_and_or_or_may_set_its_datum_or_not() {
    let of = |condition: &str| format!("VAR num n:=3;\nIF {condition} THEN\nTPErase;\nENDIF");
    for condition in
        ["FALSE AND StrToVal(\"7\",n)", "TRUE OR StrToVal(\"7\",n)", "di1=1 OR StrToVal(\"7\",n)"]
    {
        let body = format!("{}\nMoveL Offs(p,n,0,0),v5,fine,tool0;", of(condition));
        let found = rapid(&body).expect_err(condition);
        assert!(found[0].what.contains("set by StrToVal behind AND or OR"), "{found:?}");
    }
    assert_eq!(x(&of("TRUE AND StrToVal(\"7\",n)"), "n"), 7.0);
    assert_eq!(x(&of("StrToVal(\"7\",n) OR TRUE"), "n"), 7.0);
}

#[test]
fn strtoval_sets_no_constant() {
    for body in [
        "CONST num k:=5;\nVAR bool ok;\nok:=StrToVal(\"7\",k);\nMoveL p,v5,fine,tool0;",
        "VAR bool ok;\nFOR i FROM 1 TO 2 DO\nok:=StrToVal(\"7\",i);\nMoveL p,v5,fine,tool0;\nENDFOR",
    ] {
        let found = rapid(body).expect_err(body);
        assert!(found[0].what.contains("is constant and is set here"), "{found:?}");
    }
}
