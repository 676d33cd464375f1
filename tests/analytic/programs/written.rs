//! What is written back: numbers that take whole values, speeds at which nothing turns, speeds of
//! RAPID by name, registers; and which lines that name the spindle leave a doubt.

use detune::notes::Code;
use detune::program::{
    Dialect, NewSpeed, Program, Rewrite, SetBy, Setter, Settings, Spindle, read, rewrite,
};

use super::support::{at, settings};

/// The job says that a signal sets the spindle, in so many rev/min a unit.
fn by_signal(name: &str, per_unit: f64) -> Settings {
    let what = Setter::Signal(name.to_owned());
    Settings { spindle_from: Some(SetBy { what, per_unit }), ..settings() }
}

fn written(
    text: &str,
    dialect: Dialect,
    job: &Settings,
    rpm: &[(usize, f64)],
) -> Result<String, String> {
    let speed = |&(end, rpm)| NewSpeed { end, rpm, job_rpm: None };
    let to = Rewrite { speeds: rpm.iter().map(speed).collect(), keeps_chip_load: true };
    let found = rewrite(text.as_bytes(), dialect, job, &to).map_err(|note| note.what)?;
    Ok(String::from_utf8(found.bytes).unwrap())
}

const ALL: usize = usize::MAX;

const DATA: &str = "CONST robtarget p:=[[100,200,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
                    CONST robtarget q:=[[150,200,300],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n";

fn rapid(body: &str, more: &str) -> String {
    format!(
        "MODULE m\n{DATA}PROC main()\nMoveL p,v20,fine,tool0;\n{body}\nENDPROC\n{more}ENDMODULE\n"
    )
}

fn krl(head: &str, body: &str) -> String {
    format!(
        "DEF p()\n{head}$VEL.CP=0.02\nPTP {{X 0,Y 0,Z 500,A 0,B 0,C 180}}\n{body}\
         LIN {{X 50,Y 0,Z 500,A 0,B 0,C 180}}\nEND\n"
    )
}

fn tp(statements: &str) -> String {
    let point = |number: u32, x: f64| {
        format!(
            "P[{number}]{{\n   GP1:\n\tUF : 1, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {x} mm,\tY = 0 \
             mm,\tZ = 0 mm,\n\tW = 180.000 deg,\tP = 0.000 deg,\tR = 0.000 deg\n}};\n"
        )
    };
    let points = point(1, 0.0) + &point(2, 50.0);
    format!(
        "/PROG T\n/MN\n   1:UFRAME_NUM=1 ;\n   2:UTOOL_NUM=1 ;\n   3:L P[1] 20mm/sec FINE ;\n\
         {statements}   9:L P[2] 20mm/sec FINE ;\n/POS\n{points}/END\n"
    )
}

fn of_tp(by: Settings) -> Settings {
    let at = nalgebra::Isometry3::identity();
    Settings { base_frames: [(1, at)].into(), tool_frames: [(1, at)].into(), ..by }
}

/// A group output, an INT and GO take whole numbers: 2780 rpm is none of 100 rpm each, 2700 is.
#[test]
fn what_takes_whole_numbers_is_given_one_or_nothing_is_written() {
    let go = rapid("SetGO goS,30;\nMoveL q,v10,fine,tool0;", "");
    let int = krl("INT RPM\n", "RPM=30\n");
    let row = krl("SIGNAL SPEED $OUT[1] TO $OUT[5]\n", "SPEED=30\n");
    let group = tp("   4:  GO[1]=30 ;\n");
    for (text, dialect, job, old) in [
        (&go, Dialect::Rapid, by_signal("goS", 100.0), "SetGO goS,30"),
        (&int, Dialect::Krl, by_signal("RPM", 100.0), "RPM=30"),
        (&row, Dialect::Krl, by_signal("SPEED", 100.0), "SPEED=30"),
        (&group, Dialect::Fanuc, of_tp(by_signal("GO[1]", 100.0)), "GO[1]=30"),
    ] {
        let program = read(text.as_bytes(), dialect, &job).unwrap();
        assert_eq!(program.speed_step_rpm(), Some(100.0), "{old}");
        let refused = written(text, dialect, &job, &[(ALL, 2780.0)]).unwrap_err();
        assert!(refused.contains("2800 rpm, not 2780"), "{refused}");
        let found = written(text, dialect, &job, &[(ALL, 2700.0)]).unwrap();
        assert!(found.contains(&old.replace("30", "27")), "{found}");
        // An INT rounds a fraction; what else takes whole numbers does what its maker chose.
        let fraction = text.replace(old, &old.replace("30", "30.4"));
        let program = read(fraction.as_bytes(), dialect, &job).unwrap();
        let expected = (old == "RPM=30").then_some(3000.0);
        assert_eq!(program.spindle[0].spindle, Spindle::Turns(expected), "{old}");
        assert_eq!(doubts(&program).is_empty(), expected.is_some(), "{:?}", program.warnings);
    }
    // Analog outputs and REAL take any.
    let analog = rapid("SetAO aoS,0.3;\nMoveL q,v10,fine,tool0;", "");
    let job = by_signal("aoS", 10_000.0);
    assert_eq!(read(analog.as_bytes(), Dialect::Rapid, &job).unwrap().speed_step_rpm(), None);
    let found = written(&analog, Dialect::Rapid, &job, &[(ALL, 2780.0)]).unwrap();
    assert!(found.contains("SetAO aoS,0.278;") && found.contains("v10\\V:=9.26667"), "{found}");
    let again = read(found.as_bytes(), Dialect::Rapid, &job).unwrap();
    assert_eq!(again.spindle[0].spindle, Spindle::Turns(Some(2780.0)));
    let real = krl("REAL RPM\n", "RPM=3000\n");
    let found = written(&real, Dialect::Krl, &by_signal("RPM", 1.0), &[(ALL, 2780.5)]).unwrap();
    assert!(found.contains("RPM=2780.5\n"), "{found}");
}

/// Steps to warm the spindle up, and what the next program finds, are no speeds of the path.
#[test]
fn speeds_at_which_nothing_turns_stay() {
    let gcode =
        "G21 G90\nS1000 M3\nS3000\nG0 X0 Y0 Z0\nG1 X50 F600\nS6000\nX90 F500\nS3000\nT2\nM5\nM30\n";
    let found = written(gcode, Dialect::GCode, &settings(), &[(2, 2780.0), (ALL, 6000.0)]);
    assert_eq!(found.unwrap(), gcode.replacen("S3000", "S2780", 1).replace("F600", "F556"));
    // One that is stated again before anything moves follows.
    let twice = "G21 G90\nT1 M6 S3000\nS3000 M3\nG0 X0 Y0 Z0\nG1 X50 F600\nM30\n";
    let found = written(twice, Dialect::GCode, &settings(), &[(ALL, 2780.0)]).unwrap();
    assert_eq!(found, twice.replace("S3000", "S2780").replace("F600", "F556"));
    let body =
        "SetAO aoS,1000;\nWaitTime 2;\nSetAO aoS,3000;\nMoveL q,v10,fine,tool0;\nSetAO aoS,4500;";
    // The wait stands on the path, and keeps its own speed.
    let found = written(
        &rapid(body, ""),
        Dialect::Rapid,
        &by_signal("aoS", 1.0),
        &[(2, 1000.0), (ALL, 2780.0)],
    );
    let expected = rapid(body, "").replace("3000", "2780").replace("v10,", "v10\\V:=9.26667,");
    assert_eq!(found.unwrap(), expected);
}

/// `\V` stands behind the speed of MoveL, MoveJ, MoveC and MoveAbsJ alone (RAPID reference).
#[test]
fn speeds_of_rapid_by_name() {
    let job = by_signal("aoS", 1.0);
    let run = |body: &str, more: &str| {
        written(
            &rapid(&format!("SetAO aoS,3000;\n{body}"), more),
            Dialect::Rapid,
            &job,
            &[(ALL, 2700.0)],
        )
    };
    for (from, to) in [
        ("MoveL q,v10,fine,tool0;", "MoveL q,v10\\V:=9,fine,tool0;"),
        ("TriggL q,v10,t,fine,tool0;", "TriggL q,[9,500,5000,1000],t,fine,tool0;"),
        ("MoveLDO q,v10,z1,tool0,d,1;", "MoveLDO q,[9,500,5000,1000],z1,tool0,d,1;"),
        ("MoveLSync q,v10,z1,tool0,\"r\";", "MoveLSync q,[9,500,5000,1000],z1,tool0,\"r\";"),
    ] {
        let found = run(from, "PROC r()\nENDPROC\n").unwrap();
        assert!(found.contains(to), "{found}");
    }
    // A parameter has the speed of each call.
    let routine = "PROC go(robtarget a,speeddata v)\nMoveL a,v,fine,tool0;\nENDPROC\n";
    let refused = run("go q,v10;", routine).unwrap_err();
    assert!(refused.contains("the feed of line") && refused.contains("is computed"), "{refused}");
    // A local datum is not the one of the module that it hides.
    let hidden = "PERS num n:=3000;\nPROC cut()\nVAR num n:=3000;\nSetAO aoS,n;\nMoveL q,v10,fine,tool0;\nENDPROC\n";
    let text = rapid("cut;", hidden);
    let refused = written(&text, Dialect::Rapid, &job, &[(ALL, 2700.0)]).unwrap_err();
    assert!(refused.contains("the spindle's speed at line 11 is computed"), "{refused}");
}

/// Digits are those of the new number: at a tenth of the speed a feed has as many.
#[test]
fn a_feed_keeps_its_digits_at_a_small_ratio() {
    let text = krl("", "SPIN(3000)\n$VEL.CP=0.5\n");
    let what = Setter::Procedure("SPIN".to_owned(), 1);
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    let found = written(&text, Dialect::Krl, &job, &[(ALL, 701.0)]).unwrap();
    // 0.5 · 701/3000 = 0.116833…
    assert!(found.contains("SPIN(701)") && found.contains("$VEL.CP=0.1168333\n"), "{found}");
}

/// Where the job's speed holds, feeds follow that, and not the one that the program states.
#[test]
fn feeds_follow_the_speed_that_held() {
    let text = "G21 G90\nS3000 M3\nG0 X0 Y0 Z0\nG1 X50 F600\nM30\n";
    let speeds = vec![NewSpeed { end: ALL, rpm: 4200.0, job_rpm: Some(3500.0) }];
    let to = Rewrite { speeds, keeps_chip_load: true };
    let found = rewrite(text.as_bytes(), Dialect::GCode, &settings(), &to).unwrap();
    let expected = text.replace("S3000", "S4200").replace("F600", "F720");
    assert_eq!(String::from_utf8(found.bytes).unwrap(), expected);
}

/// `R[1]=3000`, `AO[1]=R[1]`, `R[2]mm/sec`: the numbers stand where the registers are set.
#[test]
fn numbers_that_registers_pass_on() {
    let job = of_tp(by_signal("AO[1]", 1.0));
    let own = "   4:  R[1]=3000 ;\n   5:  R[2]=20 ;\n   6:  AO[1]=R[1] ;\n";
    let text = tp(own).replace("P[2] 20mm", "P[2] R[2]mm");
    let found = written(&text, Dialect::Fanuc, &job, &[(ALL, 2700.0)]).unwrap();
    let expected = text.replace("=3000", "=2700").replace("R[2]=20", "R[2]=18");
    // The way to the first place belongs to the first stretch.
    assert_eq!(found, expected.replace("P[1] 20mm", "P[1] 18mm"));
    // One that is worked out stands nowhere.
    let sum = tp("   4:  R[1]=1500 ;\n   5:  R[1]=R[1]*2 ;\n   6:  AO[1]=R[1] ;\n");
    let refused = written(&sum, Dialect::Fanuc, &job, &[(ALL, 2700.0)]).unwrap_err();
    assert!(refused.contains("the spindle's speed at line 8 is computed"), "{refused}");
    // A wait that takes its time from the same register.
    let wait = tp("   4:  R[1]=3 ;\n   5:  AO[1]=R[1] ;\n   6:  WAIT R[1] ;\n");
    let job = of_tp(by_signal("AO[1]", 1000.0));
    let refused = written(&wait, Dialect::Fanuc, &job, &[(ALL, 2000.0)]).unwrap_err();
    assert!(refused.contains("the time at line 8 would no longer be 3 s"), "{refused}");
}

fn doubts(program: &Program) -> Vec<usize> {
    let told = program.warnings.iter().filter(|note| note.code == Code::SpindleCommand);
    told.map(at).collect()
}

#[test]
fn lines_that_set_nothing_leave_no_doubt() {
    let job = by_signal("nS", 1.0);
    let of = |body: &str, more: &str| {
        let text = rapid(&format!("nS:=900;\n{body}\nMoveL q,v10,fine,tool0;"), more);
        doubts(&read(text.as_bytes(), Dialect::Rapid, &job).unwrap())
    };
    let data = "PERS num nS:=900;\n";
    for body in [
        "TPWrite \"nS:=5000;\";",
        "WaitTime nS/1000;",
        "x:=nS;",
        "IF nS>2900 x:=1;",
        "IF nS=2900 x:=1;",
        "x:=2*nS;",
    ] {
        let more = format!("{data}VAR num x:=0;\n");
        assert_eq!(of(body, &more), [] as [usize; 0], "{body}");
    }
    // Another procedure, which nothing here calls; line 12 sets the speed in it.
    let other = "PROC two()\nnS:=5000;\nENDPROC\n";
    assert_eq!(of("", &format!("{data}{other}")), [] as [usize; 0]);
    // But for one that may be called: by a trap, a handler of errors, a text, or main.
    for caller in [
        "TRAP t\ntwo;\nENDTRAP\n",
        "FUNC num f()\nRETURN 1;\nERROR\ntwo;\nENDFUNC\n",
        "TRAP t\nMoveLSync q,v10,z1,tool0,\"two\";\nENDTRAP\n",
    ] {
        let found = of("", &format!("{data}{other}{caller}"));
        assert!(found.contains(&12), "{caller}: {found:?}");
    }
    let cut = |body: &str| {
        let text = rapid(
            "Prepare;\ncut;",
            &format!(
                "PROC Prepare()\nSetAO aoS,5000;\nENDPROC\nPROC cut()\nMoveL p,v20,fine,tool0;\n{body}MoveL q,v20,fine,tool0;\nENDPROC\n"
            ),
        );
        let job = Settings { procedure: Some("cut".to_owned()), ..by_signal("aoS", 1.0) };
        doubts(&read(text.as_bytes(), Dialect::Rapid, &job).unwrap())
    };
    assert_eq!(cut("SetAO aoS,3000;\n"), [10]);
    // One that is in no call, as routines of events are: where the program sets no speed itself.
    let event = rapid("MoveL q,v10,fine,tool0;", "PROC evStart()\nSetAO aoS,5000;\nENDPROC\n");
    let program = read(event.as_bytes(), Dialect::Rapid, &by_signal("aoS", 1.0)).unwrap();
    assert_eq!(doubts(&program), [9]);
    // A text that is the name itself, and a name on a line of its own.
    let handler =
        rapid("nS:=900;\nMoveL q,v10,fine,tool0;\nERROR\nSetDataVal \"nS\",5000;\nRETRY;", data);
    let program = read(handler.as_bytes(), Dialect::Rapid, &by_signal("nS", 1.0)).unwrap();
    assert_eq!(doubts(&program), [9], "{:?}", program.warnings);
    let split = rapid(
        "SetAO aoS,900;\nTriggIO t,0\\AOp\n:=aoS,5;\nMoveL q,v10,fine,tool0;",
        "VAR triggdata t;\n",
    );
    let program = read(split.as_bytes(), Dialect::Rapid, &by_signal("aoS", 1.0)).unwrap();
    assert_eq!(doubts(&program), [8], "{:?}", program.warnings);
    let late = "SetAO \\SDelay:=1,aoS,5;";
    let job = by_signal("aoS", 1.0);
    for body in [late, "TriggIO t,0\\AOp:=aoS,5;"] {
        let text = rapid(
            &format!("SetAO aoS,900;\n{body}\nMoveL q,v10,fine,tool0;"),
            "VAR triggdata t;\n",
        );
        let program = read(text.as_bytes(), Dialect::Rapid, &job).unwrap();
        assert_eq!(doubts(&program), [7], "{body}: {:?}", program.warnings);
    }
    // Names that begin as a type does are no declarations.
    let text = krl("REAL REAL_RPM\n", "REAL_RPM=900\nIF $IN[1] THEN\nREAL_RPM=5000\nENDIF\n");
    let program = read(text.as_bytes(), Dialect::Krl, &by_signal("REAL_RPM", 1.0)).unwrap();
    assert!(doubts(&program).contains(&7), "{:?}", program.warnings);
    // KRL: a declaration, and values that depend on it.
    let body =
        "RPM=300\n$VEL.CP=RPM/30000.0\nWAIT SEC RPM/100\nIF RPM>2900 THEN\n$VEL.CP=0.5\nENDIF\n";
    let text = krl("DECL INT RPM\n", body);
    let program = read(text.as_bytes(), Dialect::Krl, &by_signal("RPM", 10.0)).unwrap();
    assert_eq!(doubts(&program), [] as [usize; 0], "{:?}", program.warnings);
    assert_eq!(program.spindle[0].spindle, Spindle::Turns(Some(3000.0)));
    // 0.01 m/s behind a wait of 3 s.
    let last = program.moves.last().unwrap();
    assert!((last.feed_m_per_s - 0.01).abs() < 1e-12, "{last:?}");
    assert_eq!(program.moves.len(), 3);
}

/// What changes with a number beside the path, and is told.
#[test]
fn what_else_a_number_means_is_told() {
    let beside = |text: &str, dialect, job: &Settings, rpm: f64| {
        let speeds = vec![NewSpeed { end: ALL, rpm, job_rpm: None }];
        let to = Rewrite { speeds, keeps_chip_load: true };
        rewrite(text.as_bytes(), dialect, job, &to).unwrap().beside
    };
    let own = "   4:  AO[1]=3000 ;\n   5:  R[2]=20 ;\n";
    let text = tp(own).replace("P[2] 20mm", "P[2] R[2:feed]mm");
    let job = of_tp(by_signal("AO[1]", 1.0));
    assert_eq!(beside(&text, Dialect::Fanuc, &job, 2700.0), []);
    let more = text.replace("/POS", "  10:  AO[2]=R[2] ;\n/POS");
    let [(line, what)] = &beside(&more, Dialect::Fanuc, &job, 2700.0)[..] else { panic!() };
    assert!(*line == 7 && what.contains("'R[2]' changes for line 9, too"), "{line} {what}");

    let data = "PERS num nS:=3000;\n";
    let body = "SetAO aoS,nS;\nMoveL q,v10,fine,tool0;";
    let job = by_signal("aoS", 1.0);
    assert_eq!(beside(&rapid(body, data), Dialect::Rapid, &job, 2700.0), []);
    let also = format!("{body}\nSetAO aoCoolant,nS;");
    let [(line, what)] = &beside(&rapid(&also, data), Dialect::Rapid, &job, 2700.0)[..] else {
        panic!()
    };
    assert!(*line == 10 && what.contains("'nS' changes for line 8, too"), "{line} {what}");

    let form =
        ";FOLD LIN P2 Vel=0.02 m/s CPDAT1;%{PE}\n;FOLD Parameters ;%{h}\n;ENDFOLD\n$VEL.CP=0.02\n";
    let text = krl("", &format!("SPIN(3000)\n{form}")).replace("\nEND\n", "\n;ENDFOLD\nEND\n");
    let what = Setter::Procedure("SPIN".to_owned(), 1);
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    let [(line, what)] = &beside(&text, Dialect::Krl, &job, 2700.0)[..] else { panic!() };
    assert!(*line == 8 && what.contains("inline form"), "{line} {what}");
}

/// A parameter stands for the number that it was last set to in the text.
#[test]
fn numbers_that_parameters_pass_on() {
    let path = "G90 G0 X0 Y0 Z10";
    let gcode = |body: &str| format!("%\nG21\n{path}\n{body}\nG1 X50 F600\nM30\n%\n");
    let read_back = |old: &str, new: &str, dialect| {
        let found = written(old, dialect, &settings(), &[(ALL, 1500.0)]);
        assert_eq!(found.as_deref(), Ok(new), "{old}");
    };
    for (old, new) in [
        ("#1=3000\nS#1 M3", "#1=1500\nS#1 M3"),
        ("#<speed> = 3000. (rpm)\nS #<speed> M3", "#<speed> = 1500. (rpm)\nS #<speed> M3"),
        ("#1=200\n#1=3000\nS#1 M3\n#1=7", "#1=200\n#1=1500\nS#1 M3\n#1=7"),
        (
            "#1=3000\nS#1 M3\nG1 X1 F200\n#1=20\nG1 X2 F#1",
            "#1=1500\nS#1 M3\nG1 X1 F100\n#1=10\nG1 X2 F#1",
        ),
    ] {
        let (old, new) = (gcode(old), gcode(new).replace("F600", "F300"));
        read_back(&old, &new, Dialect::GCode);
    }
    // The feed by a parameter, too.
    let [old, new] = [600, 300].map(|feed| {
        format!("%\nG21\n#101={}\n#102={feed}\n{path}\nS#101 M3\nG1 X50 F#102\nM30\n%\n", 5 * feed)
    });
    read_back(&old, &new, Dialect::GCode);
    let mpf = |speed: u32, feed: u32| {
        format!("R1={speed} R2={feed}\n{path}\nS=R1 M3\nG1 X50 F=R2\nM30\n")
    };
    read_back(&mpf(3000, 600), &mpf(1500, 300), Dialect::Sinumerik);
    let h = |speed: u32, feed: u32| {
        format!(
            "BEGIN PGM P MM\nFN 0: Q1 = +{speed}\nQ2 = {feed} ;FEED\nTOOL CALL 1 Z S+Q1\nL X+0 Y+0 Z+10 R0 FMAX M3\n\
             L X+50 FQ2\nEND PGM P MM\n"
        )
    };
    read_back(&h(3000, 600), &h(1500, 300), Dialect::Heidenhain);
    // What is worked out is no number of the text, and one that places a move is not changed.
    for (body, said) in [
        ("#1=1000\n#1=#1+2000\nS#1 M3", "is computed"),
        ("#1=1000\nS[#1*3] M3", "is computed"),
        ("#1=30\nS#1 M3\nG1 X#1", "places it, too"),
    ] {
        let found = written(&gcode(body), Dialect::GCode, &settings(), &[(ALL, 1500.0)]);
        let why = found.expect_err(body);
        assert!(why.contains(said), "{body}: {why}");
    }
}
