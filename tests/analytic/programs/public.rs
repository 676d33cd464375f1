//! What public programs of cells and CAM systems hold that was read wrongly, in silence, or refused in
//! more words than it needs. Expected places are worked out by hand.

use detune::motion::Target;
use detune::notes::{Class, Code, Note};
use detune::program::{Assumed, Dialect, Program, read};
use nalgebra::Vector3;

use super::support::{assert_ends, at, ended, faults, lines, module, settings};

fn of(text: &str, dialect: Dialect) -> Program {
    read(ended(text, dialect).as_bytes(), dialect, &settings())
        .unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

fn doubts(program: &Program) -> Vec<(Code, usize)> {
    let told = program.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    told.map(|note| (note.code, at(note))).collect()
}

#[track_caller]
fn assert_via(program: &Program, index: usize, expected_mm: [f64; 3]) {
    let Target::Arc { via, .. } = &program.moves[index].to else { panic!("an arc") };
    let off = via.translation.vector * 1e3 - Vector3::from(expected_mm);
    assert!(off.norm() < 1e-3, "found {via}, expected {expected_mm:?}");
}

/// A lead-in of a quarter, as NX writes it: 11 values, and the axis from which the arc is seen to run
/// clockwise.
fn nx(axis: i32) -> String {
    format!(
        "TOOL PATH/BOK_7,TOOL,R390\nTLDATA/MILL,25,0,75,0,0\nFEDRAT/MMPM,1000\n\
         GOTO/-6.7496,25.462,70,0,0,1\nGOTO/-7.1838,23,70\n\
         CIRCLE/5.3162,23,70,0,0,{axis},12.5,.06,.5,25,0\nGOTO/5.3162,10.5,70\n\
         GOTO/256.4468,10.5,70\nEND-OF-PATH"
    )
}

#[test]
fn arcs_of_nx_run_clockwise_about_their_axis() {
    let program = of(&nx(-1), Dialect::Apt);
    // From 180° to 270° about (5.3162, 23): halfway at 225°, 12.5/√2 = 8.8388 mm to either side.
    assert_via(&program, 2, [5.3162 - 8.8388, 23.0 - 8.8388, 70.0]);
    assert_eq!(doubts(&program), []);
    // The other way round it would be three quarters, which neither line is tangent to.
    let found = faults(&nx(1), Dialect::Apt);
    assert_eq!((at(&found[0]), found.len()), (6, 1), "{found:?}");
    assert!(found[0].what.contains("tangent"), "{found:?}");
}

/// NX counts a helix's turns with the last one, which is not whole: 90° and twice 360°, 6 mm down.
#[test]
fn a_helix_of_nx_turns_so_many_times() {
    let helix = nx(-1).replace(",25,0\nGOTO/5.3162,10.5,70", ",25,0,TIMES,3\nGOTO/5.3162,10.5,64");
    let program = of(&helix.replace("256.4468,10.5,70", "256.4468,10.5,64"), Dialect::Apt);
    let (mut from, mut turned, mut lowest) = (None, 0.0, f64::INFINITY);
    for motion in &program.moves {
        let (Target::Arc { end, .. } | Target::Line(end)) = &motion.to else { panic!("a line") };
        let end = end.translation.vector * 1e3;
        if let (Target::Arc { via, .. }, Some(start)) = (&motion.to, from) {
            let via: Vector3<f64> = via.translation.vector * 1e3;
            let half = |a: Vector3<f64>, b: Vector3<f64>| {
                2.0 * ((a - b).xy().norm() / 25.0).min(1.0).asin()
            };
            turned += half(start, via) + half(via, end);
            lowest = end.z.min(lowest);
        }
        from = Some(end);
    }
    assert!((turned.to_degrees() - 810.0).abs() < 0.01, "{}", turned.to_degrees());
    assert!((lowest - 64.0).abs() < 1e-6, "{lowest}");
    for turns in ["0", "1.5", "-2", "1E9"] {
        let found = faults(&helix.replace("TIMES,3", &format!("TIMES,{turns}")), Dialect::Apt);
        assert!(found[0].what.contains("TIMES"), "{turns}: {found:?}");
    }
}

/// A second statement on a line would be lost, and the rapid move with it.
#[test]
fn two_statements_of_apt_on_one_line_are_a_fault() {
    for line in [
        "RAPID,GOTO/100,0,3",
        "RAPID GOTO/100,0,3",
        "RAPID,GODLTA/0,0,5",
        "RAPID,GOHOME",
        "RAPID,FEDRAT/100",
        "COOLNT/ON,GOTO/100,0,3",
        "COOLNT/OFF;GOTO/100,0,3",
        "STOP,GOTO/100,0,3",
        "RAPID,GO/PAST,L1,(PLANE/0,0,1,0),L3",
        "RAPID,GOFWD/L1,PAST,L3",
        "COOLNT/ON,CALL/SUB1",
        "RAPID,100,0,3",
        "RAPID/100,0,3",
    ] {
        let text = format!("FEDRAT/MMPM,600\nGOTO/0,0,3\n{line}\nGOTO/50,0,3");
        let found = faults(&text, Dialect::Apt);
        assert_eq!((at(&found[0]), found.len()), (3, 1), "{line}: {found:?}");
        assert!(found[0].what.contains("line of its own"), "{line}: {found:?}");
    }
    // Names of values are none.
    let program = of(
        "TOOL PATH/CYCLE,TOOL,RAPID\nTDATA/MILL,38,0\nFEDRAT/MMPM,600\nGOTO/0,0,3\nGOTO/50,0,3",
        Dialect::Apt,
    );
    assert_eq!(program.moves.len(), 2);
}

/// A word and a name are no declaration unless the word is a type.
#[test]
fn what_is_no_statement_of_krl_is_a_fault() {
    let text = |line: &str| {
        format!(
            "DEF A()\nINT mode\nE6POS far\nDECL my_type t\nmode=2\n$VEL.CP=0.1\n\
             PTP {{A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}}\n{line}\nEND"
        )
    };
    for line in [
        "LINREL P1",
        "SLINE P1",
        "GO P1",
        "GLIN mode {X 3}",
        "INT a b",
        "mode=2 3",
        "IF mode==1 THEN\nmode=3\nELSEIF mode==2 THEN\nmode=4\nENDIF",
        "IF mode==1 THEN\nmode=3\nELSE IF mode==2 THEN\nmode=4\nENDIF",
        "IF mode==2 THEN\nmode=3\nELSEIF (mode==2) THEN\nmode=4\nENDIF",
        "DECL INT c d",
    ] {
        let found = faults(&text(line), Dialect::Krl);
        assert_eq!(found.len(), 1, "{line}: {found:?}");
        assert_eq!(at(&found[0]), 8, "{line}: {found:?}");
    }
    of(&text("IF mode==1 THEN\nmode=3\nELSE\nmode=4\nENDIF"), Dialect::Krl);
}

#[test]
fn an_arc_that_only_the_other_way_round_is_tangent_is_not_read_in_silence() {
    let arc = |centre: [f64; 2], axis: i32, to: [f64; 2]| {
        let ([x, y], [u, v]) = (centre, to);
        format!("CIRCLE/{x},{y},0,0,0,{axis},10\nGOTO/{u},{v},0\n")
    };
    // Counterclockwise from below the centre to its right, and on.
    let turn = |axis| arc([10.0, 10.0], axis, [20.0, 10.0]) + "GOTO/20,20,0\n";
    let start = "GOTO/0,0,0\nGOTO/10,0,0\n";
    let right = of(&format!("{start}{}", turn(1)), Dialect::Apt);
    assert_eq!(doubts(&right), []);
    // −45° about (10, 10): 10/√2 = 7.0711 mm to the right and below.
    assert_via(&right, 2, [17.0711, 2.9289, 0.0]);
    let found = faults(&format!("{start}{}", turn(-1)), Dialect::Apt);
    assert_eq!((at(&found[0]), found.len()), (3, 1), "{found:?}");
    // One cusp among arcs that are tangent: back from (20, 20) along its own line.
    let cusp = arc([10.0, 20.0], -1, [10.0, 10.0]);
    let mixed = format!("{start}{}{cusp}GOTO/50,50,0\n", turn(1));
    assert_eq!(doubts(&of(&mixed, Dialect::Apt)), [(Code::UnitAssumed, 6)]);
    // Nothing says which way it runs: neither the lines beside it nor what wrote it.
    let bare = "GOTO/0,0,0\nGOTO/10,-5,0\nGOTO/10,0,3\nGOTO/10,0,0\n".to_owned()
        + &arc([10.0, 10.0], 1, [20.0, 10.0])
        + "GOTO/20,10,5\n";
    assert_eq!(doubts(&of(&bare, Dialect::Apt)), [(Code::UnitAssumed, 5)]);
    let camworks = "TRNTYP/WORLD,0,0,0\n".to_owned() + &bare;
    assert_eq!(doubts(&of(&camworks, Dialect::Apt)), []);
}

/// RTRCTO is where the tool goes from hole to hole: level, then down.
#[test]
fn holes_of_apt_are_gone_to_at_the_height_that_the_tool_is_left_at() {
    let cycle =
        "CYCLE/DRILL,FEDTO,10,MMPM,100,RAPTO,3,RTRCTO,63\nGOTO/0,0,0\nGOTO/20,0,5\nCYCLE/OFF";
    let hole = |x: f64, z: f64| {
        [63.0, 3.0, -10.0, 3.0, 63.0].map(|height| ('L', [x, 0.0, z + height])).to_vec()
    };
    let program = of(&format!("GOTO/0,0,63\n{cycle}"), Dialect::Apt);
    // 5 mm higher the second time, so that 63 mm over the first hole are lifted to 68.
    let lifted = vec![('L', [0.0, 0.0, 68.0])];
    assert_ends(&program, &[hole(0.0, 0.0), lifted, hole(20.0, 5.0)].concat());
    // From below it is lifted first, from above it goes level at its own height.
    let cycle = cycle.replace("GOTO/20,0,5\n", "");
    for (from, level) in [(4.0, 63.0), (80.0, 80.0)] {
        let program = of(&format!("GOTO/-9,0,{from}\n{cycle}"), Dialect::Apt);
        let lifted =
            [('L', [-9.0, 0.0, from]), ('L', [-9.0, 0.0, level]), ('L', [0.0, 0.0, level])];
        let lifted = &lifted[usize::from(level == from)..];
        let down = [('L', [0.0, 0.0, 3.0]), ('L', [0.0, 0.0, -10.0])];
        let out = [('L', [0.0, 0.0, 3.0]), ('L', [0.0, 0.0, 63.0])];
        assert_ends(&program, &[lifted, &down, &out].concat());
    }
}

#[test]
fn a_deep_hole_of_apt_without_pecks_is_a_doubt() {
    let drill =
        |cycle: &str| doubts(&of(&format!("GOTO/0,0,50\n{cycle}\nGOTO/0,0,0"), Dialect::Apt));
    let expected = [(Code::MotionLeftOut, 2)];
    assert_eq!(drill("CYCLE/DRILL,DEEP,RAPTO,3,FEDTO,-40,MMPM,250"), expected);
    assert_eq!(drill("CYCLE/DEEP2,FEDTO,40,MMPM,250,RAPTO,3"), expected);
    assert_eq!(drill("CYCLE/DEEPHL,40,250,MMPM,3"), expected);
    assert_eq!(drill("CYCLE/DRILL,DEEP,STEP,9,RAPTO,3,FEDTO,-40,MMPM,250"), []);
    let plain = "CYCLE/DRILL,RAPTO,3,FEDTO,-40,MMPM,250";
    assert_eq!(drill(plain), []);
    assert_eq!(drill(&format!("{plain}\nCYCLE/ON,DEEP")), [(Code::MotionLeftOut, 3)]);
}

#[test]
fn two_coordinate_systems_in_the_comments_of_creo_are_a_doubt() {
    let first =
        "$$-> CSYS / 1.0, 0.0, 0.0, 0.0,  $\n 0.0, 1.0, 0.0, 0.0,  $\n 0.0, 0.0, 1.0, 0.0\n";
    let other = first.replacen("0.0\n", "40.0\n", 1);
    let text = |second: &str| format!("{first}GOTO / 1, 2, $\n 3\n{second}GOTO/4,5,6");
    assert_eq!(doubts(&of(&text(first), Dialect::Apt)), []);
    let program = of(&text(&other), Dialect::Apt);
    assert_eq!(doubts(&program), [(Code::ChangeIgnored, 6)]);
    assert_ends(&program, &[('L', [1.0, 2.0, 3.0]), ('L', [4.0, 5.0, 6.0])]);
}

/// P[1] at x = 100 mm with the tool's z axis down, P[2] in the origin.
fn tp(statements: &str, assumed: &[(&str, Assumed)]) -> Result<Program, Vec<Note>> {
    let point = |number: u32, x: f64| {
        format!(
            "P[{number}]{{\n GP1:\n UF : 0, UT : 0, CONFIG : 'N U T, 0, 0, 0',\n X = {x} mm, Y = 0 \
             mm, Z = 0 mm, W = 180 deg, P = 0 deg, R = 0 deg\n}};\n"
        )
    };
    let mut job = settings();
    job.assume.extend(assumed.iter().map(|(name, value)| ((*name).to_owned(), *value)));
    let points = [point(1, 100.0), point(2, 0.0)].concat();
    let text = format!("/PROG A\n/MN\nL P[2] 9mm/sec FINE ;\n{statements}/POS\n{points}/END\n");
    read(text.as_bytes(), Dialect::Fanuc, &job)
}

const L: &str = "L P[1] 9mm/sec FINE";

/// What the job assumes of a register is what it holds before the program sets it.
#[test]
fn offsets_of_tp_are_what_the_program_has_set() {
    let zero = [("pr[5]", Assumed::Number(0.0))];
    let text = format!(
        "{L} Tool_Offset,PR[5:Offset] ;\nPR[5,3:Offset]=(-50) ;\n{L} Tool_Offset,PR[5:Offset] ;\n\
         PR[5,3:Offset]=(-200) ;\n{L} Tool_Offset,PR[5:Offset] ;\nPR[5,1]=PR[5,1]+7 ;\n\
         {L} Offset,PR[5] ;\n"
    );
    // Along the tool's z axis, which looks down; then along the frame's axes.
    let places = [[0.0; 3], [100.0, 0.0, 0.0], [100.0, 0.0, 50.0], [100.0, 0.0, 200.0]];
    let expected: Vec<_> =
        places.into_iter().chain([[107.0, 0.0, -200.0]]).map(|at| ('L', at)).collect();
    assert_ends(&tp(&text, &zero).unwrap(), &expected);
    let refused = |text: &str, said: &str| {
        let found = tp(text, &zero).expect_err(text);
        assert!(found[0].what.contains(said), "{text}: {found:?}");
    };
    refused(&format!("{L} Offset,PR[6] ;\n"), "assume: {\"PR[6]\": 0} in the job");
    refused(&format!("PR[5,6]=9 ;\n{L} Offset,PR[5] ;\n"), "turns");
    refused(&format!("PR[5,1]=R[9] ;\n{L} Offset,PR[5] ;\n"), "shifts the target");
    // The tool looks down there.
    refused(&format!("PR[5]=LPOS ;\n{L} Tool_Offset,PR[5] ;\n"), "turns the target");
}

#[test]
fn registers_and_branches_of_tp_in_parentheses() {
    let known = [("r[95]", Assumed::Number(1.0)), ("r[1]", Assumed::Number(2.0))];
    let moves = |statements: &str| {
        let program = tp(statements, &known).unwrap_or_else(|found| panic!("{found:?}"));
        lines(&program)
    };
    let jump = format!("IF ((R[1]>0)),JMP LBL[R[1]] ;\n{L} ;\nLBL[2:there] ;\n{L} ;\n");
    assert_eq!(moves(&jump), [3, 7]);
    let both = "IF ((R[1]=1 OR R[1]=2) AND (R[95]=(1))),JMP LBL[2] ;\n";
    assert_eq!(moves(&format!("{both}{L} ;\nLBL[2] ;\n{L} ;\n")), [3, 7]);
    // 45 · (2 + 1) / 9 = 15 mm.
    let text = "IF (R[95]=(1)),R[3]=(45) ;\nIF (R[95]=(2)),R[3]=(7) ;\nPR[1]=P[1] ;\n\
                IF (R[95]=(1)),PR[1,2]=((R[3]*(R[1]+1))/9) ;\nL PR[1] 9mm/sec FINE ;\n";
    let program = tp(text, &known).unwrap();
    assert_ends(&program, &[('L', [0.0; 3]), ('L', [100.0, 15.0, 0.0])]);
    // What only the run decides to set is not known behind it.
    let open =
        format!("R[3]=1 ;\nIF DI[1]=ON,R[3]=(2) ;\nIF R[3]=1,JMP LBL[2] ;\n{L} ;\nLBL[2] ;\n");
    let found = tp(&open, &[]).unwrap_err();
    assert_eq!((at(&found[0]), found.len()), (6, 1), "{found:?}");
    let open = "PR[1]=P[1] ;\nIF DI[1]=ON,PR[1,2]=(2) ;\nL PR[1] 9mm/sec FINE ;\n";
    assert_eq!(at(&tp(open, &[]).unwrap_err()[0]), 6);
    let group = tp("PR[GP1:1,7:Trolley]=PR[GP1:1,7:Trolley]-R[1] ;\n", &known).unwrap_err();
    assert!(group[0].what.contains("elements of a group are not supported"), "{group:?}");
}

#[test]
fn what_bends_the_path_of_tp_is_a_doubt() {
    let text = format!(
        "Weave Sine[1] ;\n{L} ;\nTrack TAST[2] ;\n{L} ;\nTrack End ;\nWeave End ;\n{L} Weave L[3] ;\n"
    );
    let expected = [4, 6, 10].map(|line| (Code::MotionLeftOut, line));
    assert_eq!(doubts(&tp(&text, &[]).unwrap()), expected);
}

/// Outputs are what the program has set them to, whatever they were before.
#[test]
fn outputs_of_rapid_are_what_the_program_has_set() {
    let moves = |set: &str, condition: &str, assumed: &[(&str, Assumed)]| {
        let text = module(&format!(
            "MoveL p,v5,fine,tool0;\n{set}\nIF {condition} THEN\nMoveL Offs(p,1,0,0),v5,fine,tool0;\nENDIF"
        ));
        let mut job = settings();
        job.assume.extend(assumed.iter().map(|(name, value)| ((*name).to_owned(), *value)));
        let read = read(text.as_bytes(), Dialect::Rapid, &job);
        read.map(|program| program.moves.len()).map_err(|found| at(&found[0]))
    };
    let off = [("do1", Assumed::Truth(false)), ("go1", Assumed::Number(3.0))];
    for (set, condition, expected) in [
        ("", "DOutput(do1)=1", Ok(1)),
        ("Set do1;", "DOutput(do1)=1", Ok(2)),
        ("SetDO do1,1;", "do1=1", Ok(2)),
        // Later than the instruction behind it.
        ("SetDO \\SDelay:=0.2,do1,high;", "DOutput(do1)=high", Err(6)),
        ("Set do1;\nReset do1;", "DOutput(do1)=1", Ok(1)),
        ("Set do1;\nInvertDO do1;", "DOutput(do1)=1", Ok(1)),
        ("SetGO go1,7;", "GOutput(go1)=7", Ok(2)),
        ("SetAO ao1,2.5;", "AOutput(ao1)>2", Ok(2)),
        // What only the run decides is known no longer, whatever was assumed.
        ("Set do1;\nIF DInput(di9)=1 Reset do1;", "DOutput(do1)=1", Err(7)),
    ] {
        assert_eq!(moves(set, condition, &off), expected, "{set} {condition}");
    }
    assert_eq!(moves("SetDO do1,1;", "DOutput(do1)=1", &[]), Ok(2));
    let open = "Set do1;\nIF DInput(di9)=1 Reset do1;";
    assert_eq!(moves(open, "DOutput(do1)=1", &[]), Err(7));
}

fn krl(body: &str) -> Result<Program, Vec<Note>> {
    let text = format!("DEF p()\n$VEL.CP=0.1\nPTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\n{body}\nEND\n");
    read(text.as_bytes(), Dialect::Krl, &settings())
}

#[test]
fn an_output_of_krl_that_a_condition_may_set_is_not_known_behind_it() {
    let body =
        "$OUT[1]=FALSE\nIF $IN[1] THEN\n$OUT[1]=TRUE\nENDIF\nIF $OUT[1] THEN\nLIN_REL {X 1}\nENDIF";
    let found = krl(body).unwrap_err();
    assert_eq!((at(&found[0]), found.len()), (8, 1), "{found:?}");
    assert_eq!(krl("$OUT[1]=FALSE\nIF $OUT[1] THEN\nLIN_REL {X 1}\nENDIF").unwrap().moves.len(), 1);
}

#[test]
fn errors_of_one_cause_are_one() {
    // A loop that only the run leaves: each place once, with the cause and not the way to it.
    let body = "LOOP\nLIN {X 1,Y TIER}\nNUM=NUM+1\nIF NUM>2 THEN\nTIER=TIER+1\nENDIF\n\
                IF TIER>2 THEN\nTIER=1\nNUM=1\nEXIT\nENDIF\nENDLOOP";
    let found = krl(body).unwrap_err();
    let told: Vec<_> = found.iter().map(at).collect();
    assert_eq!(told, [5, 10], "{found:?}");
    let whole = "IF decides about motion at run time: 'tier' depends on a condition: 'num' is \
                 declared in no file that is read; assume: in the job can settle it";
    assert_eq!(found[1].what, whole);
    // Numbers alone tell them apart.
    let found = krl("INT I\nFOR I=1 TO 200\nLIN XP[I]\nENDFOR").unwrap_err();
    assert_eq!((at(&found[0]), found.len()), (6, 1), "{found:?}");
    let said = "'xp[1]' is declared in no file that is read; 199 more of this line differ from it in \
                numbers alone";
    assert!(found[0].what.contains(said), "{found:?}");
    // One axis that the job does not know.
    let target =
        |track: i32| format!("[[9,0,5],[0,0,1,0],[0,0,0,0],[{track},9E9,9E9,9E9,9E9,9E9]]");
    let moves: Vec<String> =
        (0..4).map(|i| format!("MoveL {},v5,fine,tool0;", target(i * 10))).collect();
    let found = faults(&module(&moves.join("\n")), Dialect::Rapid);
    assert_eq!((at(&found[0]), found.len()), (5, 1), "{found:?}");
    let said = "eax_a moves from 0 to 10; write external_axes: {eax_a: …} in the job";
    assert!(found[0].what.contains(said), "{found:?}");
    assert!(found[0].what.ends_with("; lines 6, 7 likewise"), "{found:?}");
    // A cycle that is not read is told once, not where it is called.
    let text = "0 BEGIN PGM A MM\nL X+0 Y+0 Z+5 FMAX\nCYCL DEF 209 TAPPING ~\n Q200=+5\n\
                CYCL CALL\nL X+1 FMAX M99\nEND PGM A MM\n";
    let found = faults(text, Dialect::Heidenhain);
    assert_eq!((at(&found[0]), found.len()), (3, 1), "{found:?}");
    let bare = "0 BEGIN PGM A MM\nL X+0 Y+0 Z+5 FMAX\nCYCL CALL\nEND PGM A MM\n";
    assert!(faults(bare, Dialect::Heidenhain)[0].what.contains("without a drilling cycle"));
}

#[test]
fn moves_behind_the_end_that_nothing_calls_are_a_doubt() {
    let start = "G21 G90\nG0 X0 Y0 Z0\nG1 X10 F100\n";
    let lines = |text: &str, dialect| -> Vec<usize> {
        let program = read(text.as_bytes(), dialect, &settings()).unwrap();
        let told = program.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
        told.map(at).collect()
    };
    for (text, expected) in [
        ("M30\nG1 X20\n", vec![5]),
        // The second program of a file, behind the mark that ends the first.
        ("M30\n%\nO2\nG1 X20\nM30\n%\n", vec![7]),
        ("M98 P7\nM30\nO7\n#1=1\nIF [#1 EQ 1] GOTO 5\nG1 X20\nN5 M99\n", vec![]),
        ("M98 P7\nM30\nO7\nG1 X20\nM99\nO8\nG1 X30\nM99\n", vec![10]),
        ("M30\n%\nprinted 2026, 3 copies\n", vec![]),
    ] {
        assert_eq!(lines(&format!("{start}{text}"), Dialect::GCode), expected, "{text}");
    }
    let apt = "UNITS/MM\nFEDRAT/100,MMPM\nGOTO/0,0,0\nGOTO/10,0,0\nFINI\n";
    assert!(lines(apt, Dialect::Apt).is_empty());
    assert_eq!(lines(&format!("{apt}PARTNO/B\nGOTO/20,0,0\nFINI\n"), Dialect::Apt), [7]);
    let heidenhain = "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n2 L X+10 F100\n3 CALL LBL 1\n4 M30\n\
                      5 LBL 1\n6 L X+20\n7 LBL 0\n";
    assert!(lines(&format!("{heidenhain}8 END PGM A MM\n"), Dialect::Heidenhain).is_empty());
    let more = format!("{heidenhain}8 LBL 2\n9 L X+30\n10 LBL 0\n11 END PGM A MM\n");
    assert!(lines(&more, Dialect::Heidenhain).is_empty());
}

/// As the posts of Autodesk write them. Times by hand: rapids aside, a quarter of a circle of 10 mm, and a hole of 20 mm
/// at 150 mm/min from 2 mm above.
#[test]
fn movarc_and_the_unit_before_the_feed() {
    const START: &str = "UNITS/MM\nFEDRAT/500,MMPM\nGOTO/10,0,0\nGOTO/10,0,5\nGOTO/10,0,0\n";
    let arc = |words: &str, behind: &str| format!("{START}MOVARC/0,0,0,0,0,1,10{words}\n{behind}");
    let to = |words: &str| of(&arc(words, "GOTO/0,10,0"), Dialect::Apt);
    assert_via(&to(",ANGLE,90"), 3, [10.0 * 0.5_f64.sqrt(), 10.0 * 0.5_f64.sqrt(), 0.0]);
    assert_eq!(doubts(&to(",ANGLE,90")), []);
    // Without an angle, and of half a turn, nothing says which way round.
    assert_eq!(doubts(&to("")), [(Code::UnitAssumed, 6)]);
    let half = of(&arc(",ANGLE,180", "GOTO/-10,0,0"), Dialect::Apt);
    assert_eq!(doubts(&half), [(Code::UnitAssumed, 6)]);
    let whole = of(&arc(",ANGLE,360", "GOTO/10,0,0"), Dialect::Apt);
    // In two halves.
    assert_via(&whole, 3, [0.0, 10.0, 0.0]);
    for (words, behind, said) in [
        (",ANGLE,80", "GOTO/0,10,0", "the angle is 80.00°, and its points are 90.00° apart"),
        (",ANGLE,450", "GOTO/0,10,0", "the angle is 450.00°"),
        (",TURNS,2", "GOTO/0,10,0", "'TURNS' is not understood"),
        (",ANGLE,90", "FEDRAT/9", "no GOTO follows"),
    ] {
        let found = faults(&arc(words, behind), Dialect::Apt);
        assert!(found[0].what.contains(said), "{words}: {found:?}");
        assert!(matches!(at(&found[0]), 6 | 7), "{found:?}");
    }
    // A small arc, against the axis, is not the rest of the circle.
    let (sin, cos) = 0.5_f64.to_radians().sin_cos();
    let small =
        of(&arc(",ANGLE,0.5", &format!("GOTO/{},{},0", 10.0 * cos, -10.0 * sin)), Dialect::Apt);
    assert_eq!(small.moves.len(), 4);
    let (sin, cos) = 0.25_f64.to_radians().sin_cos();
    assert_via(&small, 3, [10.0 * cos, -10.0 * sin, 0.0]);
    // Where an angle says that axes do not tell the way, a half turn stays a doubt.
    let both = "GOTO/0,-10,0\nMOVARC/0,0,0,0,0,1,10,ANGLE,180\nGOTO/0,10,0";
    assert_eq!(doubts(&of(&arc(",ANGLE,90", both), Dialect::Apt)), [(Code::UnitAssumed, 8)]);
    let axes =
        both.replace("GOTO/0,-10,0", "GOTO/0,10,0").replace("\nGOTO/0,10,0", "\nGOTO/0,-10,0");
    assert_eq!(doubts(&of(&arc(",ANGLE,90", &axes), Dialect::Apt)), []);
    for words in ["20,MMPM,150,2", "20,MMPM,150,RAPTO,2", "20,MMPM,150,RAPTO,2,DWELL,0"] {
        let program = of(&format!("{START}CYCLE/DRILL,{words}\nGOTO/0,0,0\n"), Dialect::Apt);
        let drilled: Vec<_> = program.moves[3..]
            .iter()
            .map(|it| (super::support::end(it).1.translation.vector.z * 1e3, it.feed_m_per_s * 6e4))
            .filter(|(z, _)| *z < 1.9)
            .collect();
        let [(z, feed)] = drilled[..] else { panic!("{words}: {drilled:?}") };
        assert!((z + 20.0).abs() < 1e-9 && (feed - 150.0).abs() < 1e-9, "{words}: {z} {feed}");
        // Whether GOTO is the hole's top differs among these posts.
        assert_eq!(doubts(&program), [(Code::UnitAssumed, 6)], "{words}");
    }
    let pecks = |words: &str| {
        of(&format!("{START}CYCLE/DEEP,20,{words}\nGOTO/0,0,0\n"), Dialect::Apt).moves.len()
    };
    assert_eq!(pecks("MMPM,150,STEP,5,RAPTO,2"), pecks("INCR,5,MMPM,150,RAPTO,2"));
    assert!(pecks("MMPM,150,STEP,5,RAPTO,2") > pecks("MMPM,150,STEP,20,RAPTO,2"));
    let unit = faults(&format!("{START}CYCLE/DRILL,20,RAPTO,2,3\nGOTO/0,0,0"), Dialect::Apt);
    assert!(unit[0].what.contains("numbers without keywords"), "{unit:?}");
    let both = format!("{START}CYCLE/DRILL,12,MMPM,200,15,RAPTO,10\nGOTO/0,0,0");
    let found = faults(&both, Dialect::Apt);
    assert!(found[0].what.contains("which is the clearance is not known"), "{found:?}");
}

#[test]
fn a_part_program_of_apt_is_named_as_one() {
    let text = "PARTNO SQUARE\nL1=LINE/0,0,10,0\nC1 = CIRCLE/0,0,5\nGOTO/0,0,0";
    let found = faults(text, Dialect::Apt);
    assert_eq!(found.iter().map(at).collect::<Vec<_>>(), [2], "{found:?}");
    assert!(found[0].what.contains("run it through the APT processor"), "{found:?}");
}
