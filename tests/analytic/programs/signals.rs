//! Outputs of KRL by the names that SIGNAL gives them: an output and its names are one to the job that reads it.

use detune::notes::Code;
use detune::program::{
    Assumed, Companion, Dialect, Program, SetBy, Setter, Settings, Spindle, read,
};

use super::support::{at, settings};

/// The statements of `body` begin at line 5, behind `declared` on line 2.
fn program(declared: &str, body: &str, signal: &str, data: &str) -> Program {
    let text = format!(
        "DEF p()\n{declared}\n$VEL.CP=0.1\nPTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\n{body}\n\
         LIN_REL {{X 1}}\nEND\n"
    );
    let what = Setter::Signal(signal.to_owned());
    let spindle_from = Some(SetBy { what, per_unit: 1.0 });
    let companions = match data {
        "" => Vec::new(),
        data => vec![Companion { name: "config.dat".to_owned(), text: data.to_owned() }],
    };
    let job = Settings { spindle_from, companions, ..settings() };
    read(text.as_bytes(), Dialect::Krl, &job).unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

fn speeds(program: &Program) -> Vec<(usize, Option<f64>)> {
    let of = |spindle| match spindle {
        Spindle::Turns(rpm) => rpm,
        other => panic!("{other:?}"),
    };
    program.spindle.iter().map(|it| (it.line, of(it.spindle))).collect()
}

fn doubts(program: &Program) -> Vec<usize> {
    program.warnings.iter().filter(|it| it.code == Code::SpindleCommand).map(at).collect()
}

#[test]
fn an_output_and_its_name_are_one() {
    const NAMED: &str = "SIGNAL SPIN $ANOUT[1]";
    const OF_DATA: &str =
        "DEFDAT config\nGLOBAL SIGNAL SPIN $ANOUT[1]\nSIGNAL COOL $OUT[3]\nENDDAT\n";
    for signal in ["SPIN", "$ANOUT[1]", "$anout[1]"] {
        for (declared, data) in [(NAMED, ""), (";", OF_DATA)] {
            let body = "SPIN=900\nLIN_REL {X 1}\n$ANOUT[1]=1400";
            let found = program(declared, body, signal, data);
            let expected = [(5, Some(900.0)), (7, Some(1400.0))];
            assert_eq!(speeds(&found), expected, "{signal} {declared}");
            assert!(doubts(&found).is_empty(), "{:?}", found.warnings);
            // By the number of a variable, too.
            let body = "I=1\n$ANOUT[I]=700";
            let declared = format!("DECL INT I\n{declared}");
            assert_eq!(speeds(&program(&declared, body, signal, data)), [(7, Some(700.0))]);
        }
    }
    // What only the run decides is told of by whichever name.
    for (signal, name) in [("SPIN", "$ANOUT[1]"), ("$ANOUT[1]", "SPIN")] {
        for body in [
            format!("TRIGGER WHEN DISTANCE=0 DELAY=0 DO {name}=5"),
            format!("ANOUT ON {name}=0.5*$VEL_ACT+0.1 DELAY=0"),
        ] {
            let found = program(NAMED, &format!("SPIN=900\n{body}"), signal, "");
            assert_eq!(doubts(&found), [6], "{body}");
        }
    }
}

#[test]
fn a_row_of_outputs_and_its_parts() {
    const ROW: &str = "SIGNAL SPEED $OUT[1] TO $OUT[16]";
    let found = program(ROW, "SPEED=900\n$OUT[17]=TRUE", "SPEED", "");
    assert_eq!((speeds(&found), doubts(&found)), (vec![(5, Some(900.0))], Vec::new()));
    // A bit of the number, and another row over it.
    assert_eq!(doubts(&program(ROW, "SPEED=900\n$OUT[16]=TRUE", "SPEED", "")), [6]);
    let two = format!("{ROW}\nSIGNAL PART $OUT[9] TO $OUT[24]");
    assert_eq!(doubts(&program(&two, "SPEED=900\nPART=3", "SPEED", "")), [7]);
    let two = format!("{ROW}\nSIGNAL SAME $OUT[1] TO $OUT[16]");
    let found = program(&two, "SPEED=900\nSAME=300", "SPEED", "");
    assert_eq!(speeds(&found), [(6, Some(900.0)), (7, Some(300.0))]);
    // Likewise where only the run decides whether or when.
    for body in ["TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[2]=TRUE", "PULSE($OUT[2],TRUE,0.5)"] {
        assert_eq!(
            doubts(&program(ROW, &format!("SPEED=900\n{body}"), "SPEED", "")),
            [6],
            "{body}"
        );
    }
    let body = "SPEED=900\nIF $IN[7] THEN\n$OUT[2]=TRUE\nENDIF";
    assert_eq!(doubts(&program(ROW, body, "SPEED", "")).len(), 1);
    // What a bit was is not known behind the number.
    let body = "$OUT[2]=TRUE\nSPEED=900\nIF $OUT[2] THEN\nLIN_REL {X 5}\nENDIF";
    let text = format!("DEF p()\n{ROW}\nPTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\n{body}\nEND\n");
    let refused = read(text.as_bytes(), Dialect::Krl, &settings()).unwrap_err();
    assert_eq!(refused.iter().map(at).collect::<Vec<_>>(), [6]);
}

/// Which output a name is that no file declares is not known.
#[test]
fn a_name_that_no_file_declares_may_be_the_output() {
    for body in [
        "SPIN=5",
        "ANOUT ON SPIN=0.5*$VEL_ACT+0.1 DELAY=0",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO SPIN=5",
    ] {
        let body = format!("$ANOUT[1]=900\n{body}");
        assert_eq!(doubts(&program(";", &body, "$ANOUT[1]", "")), [6], "{body}");
        let found = program("SIGNAL SPIN $ANOUT[2]", &body, "$ANOUT[1]", "");
        assert!(doubts(&found).is_empty(), "{body}: {:?}", found.warnings);
    }
    for (declared, body) in [
        ("SIGNAL SPIN $ANOUT[1]", "N=5"),
        (";", "TRIGGER WHEN DISTANCE=0 DELAY=0 DO GRIP=TRUE"),
        (";", "PART_OK=$IN[3] AND $IN[4]"),
        (";", "FLAGX=$IN[3]"),
        ("DECL INT N", "N=5"),
        (";", "XP1={X 1,Y 2,Z 3,A 0,B 0,C 180}"),
        (";", "FDAT_ACT=FP1"),
        (";", "RPM=5\n$ANOUT[1]=RPM"),
    ] {
        let found = program(declared, body, "$ANOUT[1]", "");
        assert!(doubts(&found).is_empty(), "{body}: {:?}", found.warnings);
    }
    let given_on = program(";", "SPIN=900\n$ANOUT[1]=SPIN/24000", "SPIN", "");
    assert!(given_on.warnings.iter().all(|it| !it.what.contains("may be")), "{given_on:?}");
    let body = "SPIN=900\n$ANOUT[1]=5";
    assert_eq!(doubts(&program(";", body, "SPIN", "")), [6]);
    assert!(doubts(&program("SIGNAL SPIN $ANOUT[2]", body, "SPIN", "")).is_empty());
}

/// A row that belongs to no output of the path: what the files call an output decides which moves are read.
#[test]
fn a_named_output_decides_by_what_the_job_assumes_until_it_is_set() {
    let moves = |body: &str| {
        let text = format!(
            "DEF p()\nSIGNAL PART_OK $IN[5]\nSIGNAL GRIP $OUT[1] TO $OUT[2]\nDECL INT I\n\
             PTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\n{body}\nEND\n"
        );
        let mut job = settings();
        job.assume.insert("part_ok".to_owned(), Assumed::Truth(true));
        job.assume.insert("grip".to_owned(), Assumed::Number(1.0));
        read(text.as_bytes(), Dialect::Krl, &job).map(|program| program.moves.len())
    };
    assert_eq!(moves("IF PART_OK THEN\nLIN_REL {X 5}\nENDIF"), Ok(2));
    assert_eq!(moves("IF $IN[5] THEN\nLIN_REL {X 5}\nENDIF"), Ok(2));
    const BRANCH: &str = "IF GRIP==1 THEN\nLIN_REL {X 5}\nENDIF";
    assert_eq!(moves(BRANCH), Ok(2));
    for set in [
        "GRIP=1\nPULSE($OUT[2],TRUE,0.5)",
        "$OUT[2]=TRUE",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[I]=TRUE\nGRIP=1",
    ] {
        let found = moves(&format!("{set}\n{BRANCH}")).expect_err(set);
        assert_eq!(found.iter().map(at).collect::<Vec<_>>(), [6 + set.lines().count()], "{set}");
    }
}

/// What another file, an index that only the run knows, or a name of two outputs sets.
#[test]
fn what_the_job_reads_is_not_set_in_silence() {
    const NAMED: &str = "SIGNAL SPIN $ANOUT[1]";
    for body in ["IF $IN[1] THEN\nSPIN=3\nENDIF", "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $ANOUT[1]=3"]
    {
        let other = format!("DEF SLOW()\n{body}\nEND\n");
        let found = program(NAMED, "SPIN=900\nSLOW()", "SPIN", &other);
        assert_eq!(doubts(&found), [6], "{body}");
    }
    const ROW: &str = "SIGNAL SPEED $OUT[1] TO $OUT[16]\nDECL INT I";
    for body in ["I=$POS\n$OUT[I]=TRUE", "I=$POS\nPULSE($OUT[I],TRUE,0.5)"] {
        let found = program(ROW, &format!("SPEED=900\n{body}"), "SPEED", "");
        assert_eq!(doubts(&found), [8], "{body}");
    }
    let two = "DEF SLOW()\nSIGNAL SPIN $ANOUT[2]\nSPIN=3\nEND\n";
    let found = program(NAMED, "$ANOUT[1]=900\nSLOW()", "$ANOUT[1]", two);
    assert_eq!(doubts(&found), [6]);
    // A local datum of one routine is not that of another.
    let text = "DEF p()\nDECL INT I\nPTP {X 0,Y 0,Z 100,A 0,B 0,C 180}\nFLAG=1\n\
                TRIGGER WHEN DISTANCE=0 DELAY=0 DO BOTH()\nIF FLAG==1 THEN\nLIN_REL {X 5}\nENDIF\n\
                END\nDEF BOTH()\nA()\nB()\nEND\nDEF A()\nDECL INT FLAG\nFLAG=2\nEND\n\
                DEF B()\nFLAG=3\nEND\n";
    let refused = read(text.as_bytes(), Dialect::Krl, &settings()).unwrap_err();
    assert_eq!(refused.iter().map(at).collect::<Vec<_>>(), [6]);
}
