//! RAPID: programs of several files: names of modules, and places of what is told.

use detune::notes::{Class, Code, Note};
use detune::program::{Companion, Dialect, Program, Settings, read};

use super::support::{assert_ends, at, module, settings};

const MOVE: &str = "MoveL p,v5,fine,tool0;";
const NEXT: &str = "MoveL Offs(p,10,0,0),v5,fine,tool0;";

fn doubts(program: &Program) -> Vec<(Code, usize)> {
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

/// Instructions from line 4 on, beside another file.
fn with_file(body: &str, other: String) -> Result<Program, Vec<Note>> {
    let companions = vec![Companion { name: "b.mod".to_owned(), text: other }];
    read(module(body).as_bytes(), Dialect::Rapid, &Settings { companions, ..settings() })
}

/// RAPID overview, late binding: a name in a string may have its module before it, which reaches what is LOCAL there.
#[test]
fn a_name_in_a_string_with_its_module_is_that_of_the_module() {
    let other = "MODULE b\nLOCAL PROC doit()\nMoveL Offs(p,10,0,0),v5,fine,tool0;\nENDPROC\n\
                 LOCAL PROC main()\nMoveL Offs(p,20,0,0),v5,fine,tool0;\nENDPROC\nENDMODULE\n";
    for (call, x) in [
        ("%\"b:doit\"%;", 110.0),
        ("%\"B:main\"%;", 120.0),
        ("%\"b:\"+name%;", 110.0),
        ("%\"m:own\"%;", 130.0),
        // As the run has put it together.
        ("name:=\"b:doit\";\n%name%;", 110.0),
        ("name:=\"B:main\";\n%name%;", 120.0),
        ("%file+\":doit\"%;", 110.0),
        ("%\"b: \"+name%;", 110.0),
    ] {
        let body = format!(
            "VAR string name:=\"doit\";VAR string file:=\"b\";\n{MOVE}\n{call}\nENDPROC\nPROC own()\n\
             MoveL Offs(p,30,0,0),v5,fine,tool0;"
        );
        let found = with_file(&body, other.to_owned()).unwrap();
        assert_ends(&found, &[('L', [100.0, 200.0, 300.0]), ('L', [x, 200.0, 300.0])]);
        assert_eq!(doubts(&found), [], "{call}");
    }
    // The module has none of this name.
    for call in ["%\"b:own\"%;", "%\"c:doit\"%;"] {
        let found = with_file(&format!("{MOVE}\n{call}"), other.to_owned()).unwrap();
        assert_eq!(doubts(&found), [(Code::MotionLeftOut, 5)], "{call}");
    }
}

#[test]
fn what_stands_in_another_file_is_told_with_its_place_there() {
    let of = |call: &str| format!("MODULE b\n\nPROC go()\n{call}\nENDPROC\nENDMODULE\n");
    let search = "SearchL di1,p,p,v5,tool0;";
    for (call, said) in [
        (search, "b.mod:4: instruction 'SearchL' moves"),
        ("<SMT>;", "b.mod:4: a placeholder"),
        ("MoveL pElse,v5,fine,tool0;", "b.mod:4: MoveL: target: 'pElse'"),
    ] {
        let found = with_file(&format!("{MOVE}\ngo;"), of(call));
        assert!(found.as_ref().is_err_and(|own| own[0].what.starts_with(said)), "{found:?}");
        refused(found, 5, &[said]);
    }
    let found = with_file(&format!("{MOVE}\ngo;\ngo;"), of("gone;")).unwrap();
    assert_eq!(doubts(&found), [(Code::MotionLeftOut, 5)]);
    let is_told = |note: &Note| note.what.starts_with("b.mod:4: 'gone' is not in this file");
    assert!(found.warnings.iter().any(is_told), "{:?}", found.warnings);
    // Behind the call it is the main file again.
    let found = with_file(&format!("{MOVE}\ngo;\n{search}"), of("TPWrite \"a\";"));
    assert!(found.as_ref().is_err_and(|own| own[0].what.starts_with("instruction")), "{found:?}");
    refused(found, 6, &["'SearchL' moves"]);
}

/// It may be that of the other module, which the handler calls.
#[test]
fn a_handler_that_calls_by_a_name_that_only_the_run_knows_is_a_doubt() {
    let of = |what: &str| {
        let other = format!("MODULE b\nLOCAL PROC h()\n{what}\nENDPROC\nENDMODULE\n");
        let body = format!("{MOVE}\ngo;\nENDPROC\nPROC go()\n{NEXT}\nERROR\n%s%;\nRETURN;");
        doubts(&with_file(&format!("VAR string s;\n{body}"), other).unwrap())
    };
    assert_eq!(of("VelSet 50,100;"), [(Code::MotionLeftOut, 8)]);
    assert_eq!(of("TPWrite \"a\";"), []);
}

#[test]
fn the_procedure_of_the_job_may_be_local_in_another_module_too() {
    let other =
        "MODULE b\nLOCAL PROC start()\nMoveL Offs(p,20,0,0),v5,fine,tool0;\nENDPROC\nENDMODULE\n";
    let companions = vec![Companion { name: "b.mod".to_owned(), text: other.to_owned() }];
    let job = Settings { companions, procedure: Some("start".to_owned()), ..settings() };
    let text = module(MOVE).replace("PROC main", "PROC start");
    let found = read(text.as_bytes(), Dialect::Rapid, &job).unwrap();
    assert_ends(&found, &[('L', [100.0, 200.0, 300.0])]);
}

#[test]
fn places_in_another_file_are_those_of_the_statement_that_is_told() {
    let of = |body: &str| format!("MODULE b\n\nPROC go()\n{body}\nENDPROC\nENDMODULE\n");
    let search = "SearchL di1,p,p,v5,tool0;";
    // Behind what that file calls in the main one.
    let back = format!("{MOVE}\ngo;\nENDPROC\nPROC back()\n{NEXT}");
    let found = with_file(&back, of(&format!("back;\n{search}")));
    assert!(found.as_ref().is_err_and(|own| own[0].what.starts_with("b.mod:5: ")), "{found:?}");
    refused(found, 5, &["'SearchL' moves"]);
    let endless = "FOR i FROM 1 TO 1E7 DO\nreg1:=1;\nENDFOR";
    for (body, said) in [
        ("TPWrite \"a\";\nGOTO nowhere;", "b.mod:5: GOTO nowhere: no block"),
        ("TPWrite \"a\";\nWaitTime -1;", "b.mod:5: the arm is to stand"),
    ] {
        refused(with_file(&format!("{MOVE}\ngo;"), of(body)), 5, &[said]);
    }
    let found = with_file(&format!("{MOVE}\ngo;"), of(endless)).unwrap_err();
    assert!(found[0].what.starts_with("b.mod:"), "{found:?}");
    // A warning is told once, an error with all its lines.
    let found = with_file(&format!("{MOVE}\ngo;"), of("WaitTime nE;\nWaitTime nE;")).unwrap();
    let told: Vec<&str> = found.warnings.iter().map(|note| note.what.as_str()).collect();
    let told: Vec<&&str> = told.iter().filter(|own| own.contains("WaitTime")).collect();
    assert!(told.len() == 1 && told[0].starts_with("b.mod:4: WaitTime"), "{told:?}");
    let found = with_file(&format!("{MOVE}\ngo;"), of(&format!("{search}\n{search}")));
    assert!(found.as_ref().is_err_and(|own| own[0].what.starts_with("b.mod:4: ")), "{found:?}");
    refused(found, 5, &["; line 5 likewise"]);
}

/// Instructions from line 4 on, beside parts that the program loads.
fn with_parts(body: &str, parts: &[(&str, &str)]) -> Result<Program, Vec<Note>> {
    let parts = parts
        .iter()
        .map(|(name, text)| Companion { name: (*name).to_owned(), text: (*text).to_owned() });
    let companions = parts.collect();
    read(module(body).as_bytes(), Dialect::Rapid, &Settings { companions, ..settings() })
}

/// A part with data and a procedure of names that the others have, too.
fn part(module: &str, x: i32) -> String {
    format!(
        "MODULE {module}\nVAR num x:={x};\nPROC Cut()\nStep;\nENDPROC\nPROC Step()\n\
         MoveL Offs(p,x,0,0),v5,fine,tool0;\nIncr x;\nENDPROC\nPROC main()\nCut;\nENDPROC\n\
         ENDMODULE\n"
    )
}

fn cuts(found: &Program) -> Vec<f64> {
    let ends = found.moves.iter().skip(1).map(|each| super::support::end(each).1);
    ends.map(|pose| (pose.translation.x * 1e3).round()).collect()
}

/// Technical reference manual, Load and UnLoad: a module, and what it declares, counts while it is loaded.
#[test]
fn parts_that_are_loaded_one_after_the_other_may_share_names() {
    let load = |file: &str, call: &str| {
        let file = format!("\"HOME:/job/{file}\"");
        format!("Load \\Dynamic, {file};\n{call}\nUnLoad {file};\n")
    };
    let (a, b) = (part("pa", 10), part("pb", 20));
    let files = [("parts/a.mod", a.as_str()), ("parts/b.mod", b.as_str())];
    for [first, second] in [
        ["%\"pa:main\"%;", "%\"pb:main\"%;"],
        ["%\"pa:Cut\"%;", "%\"PB:cut\"%;"],
        ["%\"Cut\"%;", "%\"Cut\"%;"],
        ["%\"C\"+s%;", "%\"C\"+s%;"],
        ["Cut;", "Cut;"],
    ] {
        let (first, second) = (load("A.MOD", first), load("b.mod", second));
        let head = format!("VAR string s:=\"ut\";\n{MOVE}\n");
        let found = with_parts(&format!("{head}{first}{second}{first}"), &files).unwrap();
        // What the first has counted is gone where it is loaded again.
        assert_eq!(cuts(&found), [110.0, 120.0, 110.0], "{first}");
        assert_eq!(doubts(&found), [], "{first}: {:?}", found.warnings);
    }
    // Parts of one name of the module, under a name and a folder that the program works out.
    let (a, b) = (part("cut", 10), part("cut", 20));
    let files = [("a1.mod", a.as_str()), ("a2.mod", b.as_str())];
    let body = format!(
        "VAR string f;\n{MOVE}\nFOR i FROM 1 TO 2 DO\nf:=\"a\"+ValToStr(i)+\".mod\";\n\
         StartLoad \\Dynamic, \"HOME:\" \\File:=f, ls;\nWaitLoad ls;\n%\"cut:main\"%;\n\
         UnLoad \"HOME:\" \\File:=f;\nENDFOR"
    );
    let found = with_parts(&body, &files).unwrap();
    assert_eq!((cuts(&found), doubts(&found)), (vec![110.0, 120.0], vec![]));
}

#[test]
fn which_of_the_parts_of_one_name_is_meant_must_be_known() {
    let (a, b) = (part("pa", 10), part("pb", 20));
    let files = [("a.mod", a.as_str()), ("b.mod", b.as_str())];
    let [load_a, load_b] = ["a", "b"].map(|own| format!("Load \\Dynamic, \"{own}.mod\";"));
    for (body, line, said) in [
        (format!("{load_a}\n{load_b}\n%\"Cut\"%;"), 7, "more than one of them is loaded"),
        (format!("{load_a}\nUnLoad \"a.mod\";\n%\"Cut\"%;"), 7, "none of them is loaded"),
        ("Load \\Dynamic, f;\n%\"Cut\"%;".to_owned(), 6, "only the run knows which of them"),
        (format!("IF DInput(di1)=1 {load_a}\n%\"Cut\"%;"), 6, "only the run knows which of them"),
    ] {
        refused(with_parts(&format!("{MOVE}\n{body}"), &files), line, &[said, "module:Cut"]);
    }
    // Without a Load all files are there at once; data may be meant by another module.
    let said = ["o.mod:3: procedure 'Cut' is declared twice, here and at a.mod:3"];
    let files = [("a.mod", a.as_str()), ("o.mod", b.as_str())];
    let found = with_parts(MOVE, &files).unwrap_err();
    assert!(found.iter().any(|note| note.what.contains(said[0])), "{found:?}");
    let found = with_parts(&format!("{load_a}\nMoveL Offs(p,x,0,0),v5,fine,tool0;"), &files);
    refused(found, 1, &["'x' is declared twice, here and at a.mod:2: of parts", "LOCAL in each"]);
    let function = "MODULE b\nFUNC num one()\nRETURN 1;\nENDFUNC\nENDMODULE\n";
    let files = [("a.mod", function), ("b.mod", function)];
    refused(with_parts(MOVE, &files), 1, &["b.mod:2: function 'one' is declared twice, here"]);
}
