//! RAPID that must not be read as if it were understood, and bytes that are no program.

use detune::program::{Companion, Dialect, Settings, read};

use super::support::{at, faults, module, settings};

/// Each stands on line 4, after the declarations of `module`.
#[test]
fn motion_that_is_not_understood_is_refused_with_its_line() {
    for (instruction, said) in [
        ("MoveL pElse,v5,fine,tool0;", "target: 'pElse' is not declared in this file"),
        ("MoveL p,v5,fine,tElse;", "'tElse' is not declared in this file; give the tcp in the job"),
        ("MoveL p,v5,fine,tool0\\WObj:=wElse;", "give the work_object in the job"),
        ("MoveL p,v5,fine;", "the tool is missing"),
        ("MoveL p,v5,fine,tool0", "expected ',' or ';'"),
        ("MoveL p,[0,1,1,1],fine,tool0;", "speed is 0 mm/s"),
        ("MoveL [[1,2],[1,0,0,0],[0,0,0,0]],v5,fine,tool0;", "3 numbers"),
        ("MoveL [[1,2,3],[0,0,0,0],[0,0,0,0]],v5,fine,tool0;", "has length 0.0000"),
        ("MoveL [[1,2,1E999],[1,0,0,0],[0,0,0,0]],v5,fine,tool0;", "'1E999'"),
        ("MoveL Offs(p,1/0,0,0),v5,fine,tool0;", "division by zero"),
        ("MoveL Offs(p,Sqrt(-1),0,0),v5,fine,tool0;", "not finite"),
        ("MoveL CRobT(),v5,fine,tool0;", "known only at run time"),
        ("MoveL Offs(p,GInput(g),0,0),v5,fine,tool0;", "known only at run time"),
        ("MoveAbsJ [[1,2,3],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;", "6 numbers"),
        ("SearchL di1,p,p,v5,tool0;", "'SearchL' moves"),
        ("ArcL p,v5,seam1,weld1,fine,tool0;", "'ArcL' moves"),
        ("ArcMoveL p,v5,fine,tool0;", "'ArcMoveL' moves and is not understood"),
        ("PaintL p,v5,bd,z10,tool0;", "'PaintL' moves and is not understood"),
        ("SpotJ p,v5,gun1,spot1,tool0;", "'SpotJ' moves and is not understood"),
        ("DispL\\On,p,v5,bead1,fine,tool0;", "'DispL' moves and is not understood"),
        ("GluePath Offs(p,0,0,1),5;", "'GluePath' moves"),
        ("GluePath [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];", "'GluePath' moves"),
        ("PDispSet dispA;", "program displacement"),
        ("GOTO again;", "no block around it has this label"),
        ("%\"proc\"+x%;", "by a name in a string"),
        ("<SMT>;", "unfinished"),
        ("IF DInput(di1)=1 MoveL p,v5,fine,tool0;", "IF decides about motion at run time"),
        (
            "IF x>1 THEN\nmain;\nENDIF\nMoveL p,v5,fine,tool0;",
            "IF decides about motion at run time",
        ),
        ("WHILE DInput(di1)=1 DO\nMoveL p,v5,fine,tool0;\nENDWHILE", "WHILE decides"),
        ("FOR i FROM 1 TO n DO\nMoveL p,v5,fine,tool0;\nENDFOR", "FOR decides"),
        ("TEST n\nCASE 1: MoveL p,v5,fine,tool0;\nENDTEST", "TEST decides"),
        (
            "TEST 1\nCASE kElse:\nDEFAULT: MoveL p,v5,fine,tool0;\nENDTEST",
            "'kElse' is not declared",
        ),
        ("TEST 1\nCASE kElse: MoveL p,v5,fine,tool0;\nCASE 1:\nENDTEST", "TEST decides"),
        ("IF x>1 x:=2; ENDIF MoveL p,v5,fine,tool0;", "ENDIF without its beginning"),
        ("ELSE MoveL p,v5,fine,tool0;", "ELSE without its beginning"),
        ("FOR i FROM 1 TO 2 STEP 0 DO\nENDFOR", "STEP is 0"),
        ("FOR i FROM 1 TO 1E12 DO\nENDFOR", "a loop without an end"),
        ("MoveL MirPos(p,p),v5,fine,tool0;", "write the value into a copy of the program"),
        ("MoveL Offs(p,StrLen(NumToStr(0.125,2)),0,0),v5,fine,tool0;", "write the string itself"),
        ("IF 0.7*10<7 MoveL p,v5,fine,tool0;", "rounding to seven digits decides"),
        ("WHILE reg1<1 DO reg1:=reg1-1; ENDWHILE", "a loop without an end"),
        ("VelSet 0,100;", "both positive"),
        ("main;", "nested too deep"),
        ("RAISE;", "outside an error handler"),
    ] {
        let found = faults(&module(instruction), Dialect::Rapid);
        assert_eq!(found.len(), 1, "{instruction}: {found:?}");
        assert_eq!(at(&found[0]), 4, "{instruction}: {}", found[0].what);
        assert!(found[0].what.contains(said), "{instruction}: {}", found[0].what);
    }
}

#[test]
fn tools_and_work_objects_that_do_not_fit_together_are_refused() {
    let with = |tool_held: &str, object_held: &str, fixed: &str| {
        let declarations = format!(
            "PERS tooldata t:=[{tool_held},[[0,0,7],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\
             PERS wobjdata w:=[{object_held},{fixed},\"\",[[0,5,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\
             PROC main"
        );
        let text = module("MoveL p,v5,fine,t\\WObj:=w;").replace("PROC main", &declarations);
        read(text.as_bytes(), Dialect::Rapid, &settings()).map_err(|all| all[0].what.clone())
    };
    assert!(with("TRUE", "FALSE", "TRUE").is_ok());
    assert!(with("FALSE", "TRUE", "TRUE").is_ok());
    for (tool, object, fixed, said) in [
        ("FALSE", "FALSE", "TRUE", "the tool stands (robhold FALSE)"),
        ("TRUE", "TRUE", "TRUE", "holds the work object (robhold TRUE), and the tool"),
        ("TRUE", "FALSE", "FALSE", "ufmec names no mechanical unit"),
        ("FALSE", "TRUE", "FALSE", "ufmec names no mechanical unit"),
    ] {
        let why = with(tool, object, fixed).unwrap_err();
        assert!(why.contains(said), "{why}");
    }
}

#[test]
fn what_depends_on_the_run_is_unknown_afterwards() {
    let found = faults(
        &module(
            "VAR num x:=1;\nIF DInput(di1)=1 THEN\nx:=2;\nENDIF\nMoveL Offs(p,x,0,0),v5,fine,tool0;",
        ),
        Dialect::Rapid,
    );
    assert_eq!(at(&found[0]), 8);
    assert!(found[0].what.contains("'x' depends on a condition"), "{}", found[0].what);
    // By way of a procedure that changes its argument, too.
    let text = module("VAR num x:=1;\nIF DInput(di1)=1 up x;\nMoveL Offs(p,x,0,0),v5,fine,tool0;")
        .replace("ENDMODULE", "PROC up(INOUT num a)\na:=a+1;\nENDPROC\nENDMODULE");
    let found = faults(&text, Dialect::Rapid);
    assert_eq!(at(&found[0]), 6);
    assert!(found[0].what.contains("'x' depends on a condition"), "{}", found[0].what);
}

#[test]
fn structure_that_is_broken_is_refused() {
    for (text, line, said) in [
        ("", 1, "no procedure without arguments"),
        ("MODULE m\nENDMODULE", 1, "no procedure without arguments"),
        ("MODULE m\nPROC main()\nENDPROC\nENDMODULE", 1, "contains no motion"),
        (
            "MODULE m\nPROC main()\nMoveL p,v5,fine,tool0;\nENDMODULE",
            4,
            "expected ENDPROC of 'main'",
        ),
        ("MODULE m\nPROC main()\nENDPROC\nPROC MAIN()\nENDPROC\nENDMODULE", 4, "declared twice"),
        ("MODULE m\nVAR num x:=;\nPROC main()\nENDPROC\nENDMODULE", 2, "expected a value"),
        ("MoveL p,v5,fine,tool0;", 1, "expected MODULE, PROC or a declaration"),
        // A file that was cut off.
        ("MODULE m\nPROC main()\nWaitTime 1;\nENDPROC\n", 4, "expected ENDMODULE of 'm'"),
        ("MODULE m\nVAR num x;\nMODULE k\nENDMODULE", 3, "expected ENDMODULE of 'm'"),
        ("PROC main()\nWaitTime 1;\nERROR\nRETRY;\n", 4, "expected ENDPROC of 'main'"),
        (
            "MODULE m\nPROC main()\nERROR\nRETRY;\nPROC a()\nENDPROC\nENDMODULE",
            5,
            "expected ENDPROC of 'main'",
        ),
    ] {
        let found = faults(text, Dialect::Rapid);
        assert!(
            found.iter().any(|fault| at(fault) == line && fault.what.contains(said)),
            "{text}: {found:?}"
        );
    }
    // One cut is one error, and a module that another follows is none.
    for (text, cut) in [
        ("MODULE m\nPROC main()\nWaitTime 1;\nERROR\nRETRY;\n", true),
        ("MODULE m\nPROC main()\nENDPROC\nPROC z()\nMoveL", true),
        ("MODULE m\nPROC main()\nENDPROC\nMODULE k\nENDMODULE", false),
    ] {
        let found = faults(text, Dialect::Rapid);
        let said = found.iter().filter(|fault| fault.what.contains("the file is cut off"));
        assert_eq!(said.count(), usize::from(cut), "{found:?}");
        assert!(!cut || found.len() == 1, "{found:?}");
    }
    let text = module("MoveL p,v5,fine,tool0;");
    let companions = vec![Companion { name: "data.sys".to_owned(), text: "MODULE d".to_owned() }];
    let job = Settings { companions, ..settings() };
    let cut = read(text.as_bytes(), Dialect::Rapid, &job).expect_err("data.sys is cut off");
    assert!(cut[0].what.starts_with("data.sys:1: expected ENDMODULE of 'd'"), "{cut:?}");
    // Procedures alone need no module.
    let bare = text.lines().filter(|line| !line.contains("MODULE")).collect::<Vec<_>>().join("\n");
    assert!(read(bare.as_bytes(), Dialect::Rapid, &settings()).is_ok());
    let open = faults(&module("IF 1<2 THEN\nMoveL p,v5,fine,tool0;"), Dialect::Rapid);
    assert!(open.iter().any(|fault| fault.what.contains("expected ENDIF")), "{open:?}");
}

#[test]
fn all_faults_are_told_and_a_flood_is_cut() {
    let found = faults(&module(&"MoveL no,v5,fine,tool0;\n".repeat(350)), Dialect::Rapid);
    assert_eq!(found.len(), 2, "{found:?}");
    assert_eq!(at(&found[0]), 4);
    assert!(found[0].what.ends_with("199 more lines likewise (5, 6, 7, 8, …, 203)"), "{found:?}");
    assert_eq!(found[1].what, "and 150 more");
}

#[test]
fn joints_must_fit_the_robot() {
    let text = module("MoveAbsJ [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;");
    let seven = Settings { joint_count: 7, ..settings() };
    let found = read(text.as_bytes(), Dialect::Rapid, &seven).unwrap_err();
    assert!(found[0].what.contains("the robot has 7 moving joints"), "{}", found[0].what);
}

#[test]
fn bytes_that_are_no_text_are_refused() {
    for dialect in [Dialect::Rapid, Dialect::Apt, Dialect::GCode] {
        assert!(faults("GOTO/\n\0", dialect)[0].what.contains("not a text"));
        assert!(!faults("", dialect).is_empty());
    }
}

#[test]
fn extensions_tell_the_dialect() {
    for (extension, dialect) in [
        ("mod", Some(Dialect::Rapid)),
        ("MOD", Some(Dialect::Rapid)),
        ("prg", Some(Dialect::Rapid)),
        ("sys", Some(Dialect::Rapid)),
        ("aptsource", Some(Dialect::Apt)),
        ("CLS", Some(Dialect::Apt)),
        ("tap", Some(Dialect::GCode)),
        ("ngc", Some(Dialect::GCode)),
        ("txt", None),
    ] {
        assert_eq!(Dialect::from_extension(extension), dialect, "{extension}");
    }
}

/// Strings of RAPID have 80 characters at most, and data keep their size: a short text must not ask for all
/// memory or for a stack that is too deep.
#[test]
fn data_that_grow_without_end_are_refused() {
    for (declared, grows, passes, said) in [
        ("string s:=\"ab\"", "s:=s+s;", 60, "80 characters"),
        ("num s{2}:=[1,2]", "s:=[s,s];", 18, "too large"),
        ("num s{2}:=[1,2]", "s:=[s,s];", 60, "found 2 values"),
        (
            "num s{9};\nVAR num t{9}",
            "t:=s;\nFOR j FROM 1 TO 9 DO\ns{j}:=t;\nENDFOR",
            60,
            "too large",
        ),
        ("num s{1}:=[1]", "s:=[s];", 20, "nested too deep"),
        ("num s{1}:=[1]", "s:=[s];", 100_000, "found 1 values"),
        ("num s{1}:=[1]", "s{1}:=s;", 20, "nested too deep"),
        ("num s{1}:=[1]", "s{1}:=s;", 100_000, "nested too deep"),
    ] {
        let text = format!(
            "VAR {declared};\nFOR i FROM 1 TO {passes} DO\n{grows}\nENDFOR\nMoveL s,v5,fine,tool0;"
        );
        let found = faults(&module(&text), Dialect::Rapid);
        assert!(found.iter().any(|fault| fault.what.contains(said)), "{grows} {passes}: {found:?}");
    }
}
