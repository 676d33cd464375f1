//! What a reader once passed over without a word: commands to the spindle by other names, moves
//! behind an end in mid-program, frames that do not agree, words of a machine, blocks to skip.

use detune::motion::Move;
use detune::notes::{Code, Note};
use detune::program::{
    Assumed, Companion, Dialect, Program, SetBy, Setter, Settings, Spindle, SpindleCommand, read,
};

use super::support::{assert_ends, at, ended, module, settings};

const NONE: [usize; 0] = [];

fn of(text: &str, dialect: Dialect, settings: &Settings) -> Program {
    let read = read(ended(text, dialect).as_bytes(), dialect, settings);
    read.unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

fn told(program: &Program, code: Code) -> Vec<usize> {
    program.warnings.iter().filter(|note| note.code == code).map(at).collect()
}

/// A job whose signal, variable or register sets the speed.
fn signal(name: &str) -> Settings {
    let what = Setter::Signal(name.to_owned());
    Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() }
}

fn rpm(program: &Program) -> Vec<(usize, Spindle)> {
    program.spindle.iter().map(|SpindleCommand { line, spindle, .. }| (*line, *spindle)).collect()
}

fn of_krl(body: &str, job: &Settings) -> Program {
    let text = format!(
        "DEF p()\n$VEL.CP=0.1\nPTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\n{body}\nLIN_REL {{X 1}}\nEND\n"
    );
    of(&text, Dialect::Krl, job)
}

fn tp_text(body: &str, numbers: &str) -> String {
    format!(
        "/PROG A\n/MN\nL P[1] 9mm/sec FINE ;\n{body} ;\nL P[1] 9mm/sec FINE ;\n/POS\nP[1]{{\n \
         GP1:\n {numbers}, CONFIG : 'N U T, 0, 0, 0',\n X = 0 mm, Y = 0 mm, Z = 0 mm, W = 180 deg, \
         P = 0 deg, R = 0 deg\n}};\n/END\n"
    )
}

fn of_tp(body: &str, job: &Settings) -> Program {
    of(&tp_text(body, "UF : 0, UT : 0"), Dialect::Fanuc, job)
}

#[test]
fn commands_of_rapid_to_the_spindle_by_other_names_are_a_doubt() {
    let text = |body: &str| {
        module(&format!("MoveL p,v5,fine,tool0;\n{body}\nMoveL Offs(p,1,0,0),v5,fine,tool0;"))
    };
    let doubts = |body: &str, job: &Settings| {
        told(&of(&text(body), Dialect::Rapid, job), Code::SpindleCommand)
    };
    for call in [
        "SetAO aoDrehzahl,3000;",
        "SetAO aoSPINDEL,3000;",
        "SetGO goRPM,3000;",
        "SetGO nrpm_soll,3000;",
        "Reset doSpindle;",
        "SetAO ao1,nRPM;",
        "SetAO aoSpndl,80;",
        "SetAO ao1,nMaxRpm*0.5;",
        "nSpindleSpeed:=3000;",
        "Incr nSpindleSpeed;",
        "MoveLDO p,v5,fine,tool0,doSpindle,0;",
        "TriggIO gun,5\\DOp:=doSpindle,0;",
        "IF DInput(di1)=1 SetAO aoDrehzahl,0;",
        "IF DInput(di1)=1 nDrehzahl:=0;",
    ] {
        assert_eq!(doubts(call, &settings()), [5], "{call}");
    }
    for call in
        ["SetDO doCarpman,1;", "SetAO aoInterpm,3;", "nInterPM:=3;", "nLayer:=3;", "SetAO ao1,n;"]
    {
        assert_eq!(doubts(call, &settings()), NONE, "{call}");
    }
    // One note of a name, and what the job reads is known.
    let twice = "SetAO aoDrehzahl,3000;\nSetAO aoDrehzahl,4000;\nSetAO ao1,nRPM;";
    assert_eq!(doubts(twice, &settings()), [5, 7]);
    assert_eq!(doubts(twice, &signal("aodrehzahl")), [7]);
    let program = of(&text("nSpindleSpeed:=3000;"), Dialect::Rapid, &signal("nSpindleSpeed"));
    assert_eq!(rpm(&program), [(5, Spindle::Turns(Some(3000.0)))]);
    assert!(program.warnings.is_empty(), "{:?}", program.warnings);
    let found = read(
        text("IF DInput(di1)=1 nSpindleSpeed:=3000;").as_bytes(),
        Dialect::Rapid,
        &signal("nSpindleSpeed"),
    );
    assert_eq!(at(&found.unwrap_err()[0]), 5);
}

/// A variable commands nothing but through what it is given to; a tool is no speed.
#[test]
fn data_of_rapid_with_a_spindles_name() {
    let doubts = |kind: &str, body: &str, job: &Settings| {
        let text = format!(
            "MODULE m\n{kind}\nPROC main()\nMoveL [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,\
             9E9,9E9]],v5,fine,tool0;\n{body}\nENDPROC\nPROC SpindleOn(num rpm)\nSetDO do5,1;\n\
             SetAO ao2,rpm;\nENDPROC\nPROC SpindleFace()\nWaitTime 1;\nENDPROC\nENDMODULE\n"
        );
        told(&of(&text, Dialect::Rapid, job), Code::SpindleCommand)
    };
    let none = settings();
    assert_eq!(doubts("VAR num nRPM:=0;", "nRPM:=3000;", &none), NONE);
    assert_eq!(doubts("VAR num nRPM:=0;", "nRPM:=3000;\nSetAO ao1,nRPM;", &none), [6]);
    assert_eq!(doubts("PERS num nRPM:=0;", "nRPM:=3000;", &none), [5]);
    assert_eq!(doubts("PERS num nRPM:=0;", "nRPM:=3000;\nSetAO ao1,nRPM;", &signal("ao1")), NONE);
    let tool = "PERS tooldata tSpindle:=[TRUE,[[0,0,1],[1,0,0,0]],[4,[0,0,70],[1,0,0,0],0,0,0]];";
    assert_eq!(doubts(tool, "tSpindle.tframe.trans.z:=2;", &none), NONE);
    assert_eq!(doubts("", "pSpindle:=[1,2,3];", &none), NONE);
    assert_eq!(doubts("", "rSpindle:=[3000,TRUE];", &none), [5]);
    // A procedure of the file that sets an output, and one that sets none.
    assert_eq!(doubts("", "SpindleOn 3000;", &none), [5, 9]);
    assert_eq!(doubts("", "SpindleFace;", &none), NONE);
    let what = Setter::Procedure("SpindleOn".to_owned(), 1);
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    // What it commands need not be what it is given: the job can name the signal.
    assert_eq!(doubts("", "SpindleOn 3000;", &job), [9]);
    assert_eq!(doubts("", "SpindleOn 3000;", &signal("ao2")), NONE);
}

#[test]
fn commands_of_krl_to_the_spindle_by_other_names_are_a_doubt() {
    let doubts = |body: &str, job: &Settings| told(&of_krl(body, job), Code::SpindleCommand);
    for body in [
        "SPINDLE_RPM=3000",
        "DREHZAHL=3000",
        "NRPM=3000",
        "SPINDEL.DREHZAHL=3000",
        "SPINDEL={SPEED 3000,ON TRUE}",
        "SPINDLE_ON(3000)",
        "FRAESEN(1,SPINDLE_RPM)",
        "PULSE(SPINDLE_ON,TRUE,1.0)",
        "ANOUT ON SPINDLE_SIG=0.5*V+0.1",
        "$ANOUT[1]=RPM/24000",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO SPINDLE_ON=FALSE",
    ] {
        assert_eq!(doubts(body, &settings()), [4], "{body}");
    }
    assert_eq!(doubts("IF $IN[1] THEN\nSPINDLE_RPM=0\nENDIF", &settings()), [5]);
    for body in
        ["CARPMAN=1", "INTERPM=2", "LAYER=3", "SPINDLE_TCP={X 0,Y 0,Z 1}", "SPINDLE_TCP.Z=9"]
    {
        assert_eq!(doubts(body, &settings()), NONE, "{body}");
    }
    assert_eq!(doubts("SPINDLE_RPM=3000\nSPINDLE_RPM=4000", &settings()), [4]);
    assert_eq!(doubts("SPINDLE_RPM=3000", &signal("SPINDLE_RPM")), NONE);
    assert_eq!(doubts("SPINDLE_RPM=3000\n$ANOUT[1]=SPINDLE_RPM", &signal("$ANOUT[1]")), NONE);
    // What a routine declares is its own.
    let local = |body: &str, job: &Settings| {
        let text = format!(
            "DEF p()\nDECL INT RPM\nPTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\nRPM=3000\n{body}\nEND\n\
             DEF SPINDLE_ON(SPEED:IN)\n$OUT[1]=TRUE\nSPINDLE_SET=SPEED\nEND\n"
        );
        told(&of(&text, Dialect::Krl, job), Code::SpindleCommand)
    };
    assert_eq!(local("", &settings()), NONE);
    assert_eq!(local("$ANOUT[1]=RPM*0.0001", &settings()), [5]);
    assert_eq!(local("SPINDLE_ON(900)", &settings()), [5, 9]);
    let what = Setter::Procedure("SPINDLE_ON".to_owned(), 1);
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    assert_eq!(local("SPINDLE_ON(900)", &job), [9]);
    assert_eq!(local("SPINDLE_ON(900)", &signal("spindle_set")), NONE);
}

#[test]
fn commands_of_tp_to_the_spindle_by_comments_are_a_doubt() {
    let doubts = |body: &str, job: &Settings| told(&of_tp(body, job), Code::SpindleCommand);
    for body in [
        "AO[1:SPINDLE RPM]=3000",
        "DO[5:Spindle on]=OFF",
        "DO[5:Spindle on]=PULSE,1.0sec",
        "GO[2:Drehzahl]=3000",
        "R[5:SpindleRPM]=3000",
        "R[5:nRPM]=3000",
        "AO[1]=R[5:Spindle RPM]",
        "IF DI[1]=ON,DO[5:Spindle on]=OFF",
        "CALL SPINDLE_ON(3000)",
        "L P[1] 9mm/sec FINE TA .50sec,DO[5:Spindle on]=OFF",
    ] {
        assert_eq!(doubts(body, &settings()), [4], "{body}");
    }
    for body in ["AO[1:FEED]=3", "R[1:feed]=9", "DO[1:Carpman]=ON", "PR[5:spindle]=P[1]"] {
        assert_eq!(doubts(body, &settings()), NONE, "{body}");
    }
    for name in ["AO[1]", "R[5]"] {
        let body = format!("{}:SPINDLE RPM]=3000", name.trim_end_matches(']'));
        let program = of_tp(&body, &signal(name));
        assert_eq!(told(&program, Code::SpindleCommand), NONE, "{body}");
        assert_eq!(rpm(&program), [(4, Spindle::Turns(Some(3000.0)))]);
    }
    let given_on = "R[5:SPINDLE RPM]=3000 ;\nAO[1]=R[5:SPINDLE RPM]";
    assert_eq!(doubts(given_on, &signal("AO[1]")), NONE);
    assert_eq!(doubts("R[15:SPINDLE RPM]=3000 ;\nAO[1]=R[5]", &signal("AO[1]")), [4, 5]);
}

#[test]
fn moves_behind_an_end_in_mid_program_are_a_doubt() {
    let rapid = |body: &str| {
        let text = module(&format!("MoveL p,v5,fine,tool0;\n{body}"));
        let cut = "PROC cut()\nMoveL p,v5,fine,tool0;\nENDPROC\nENDMODULE";
        let text = text.replace("ENDMODULE", cut);
        told(&of(&text, Dialect::Rapid, &settings()), Code::MotionLeftOut)
    };
    let cut = "MoveL Offs(p,1,0,0),v5,fine,tool0;";
    for end in ["RETURN;", "EXIT;", "ExitCycle;"] {
        assert_eq!(rapid(&format!("{end}\n{cut}")), [6], "{end}");
        assert_eq!(
            rapid(&format!("{end}\nSetDO do1,1;\nIF TRUE THEN\n{cut}\nENDIF")),
            [7],
            "{end}"
        );
        assert_eq!(rapid(&format!("{end}\ncut;")), [6], "{end}");
        assert_eq!(rapid(&format!("{end}\nSetDO do1,1;")), NONE, "{end}");
        // The next cycle of ExitCycle may find another branch.
        let in_branch = if end == "ExitCycle;" { vec![8] } else { Vec::new() };
        assert_eq!(rapid(&format!("IF 1=1 THEN\n{end}\nENDIF\n{cut}")), in_branch, "{end}");
    }
    assert_eq!(rapid(&format!("Stop;\n{cut}")), NONE);
    let krl = |body: &str| {
        let mut job = settings();
        job.assume.insert("n".to_owned(), Assumed::Number(0.0));
        told(&of_krl(body, &job), Code::MotionLeftOut)
    };
    assert_eq!(krl("RETURN"), [5]);
    assert_eq!(krl("HALT"), NONE);
    assert_eq!(krl("IF TRUE THEN\nRETURN\nENDIF"), NONE);
    assert_eq!(krl("IF N==1 THEN\nGOTO MORE\nENDIF\nRETURN\nMORE:"), NONE);
    assert_eq!(krl("LOOP\nLIN_REL {X 1}\nEXIT\nLIN_REL {X 2}\nENDLOOP"), [7]);
    let tp = |body: &str| told(&of_tp(body, &settings()), Code::MotionLeftOut);
    assert_eq!(tp("END"), [5]);
    assert_eq!(tp("ABORT ;\nLBL[9:more]"), [6]);
    assert_eq!(tp("R[1]=0 ;\nIF R[1]=1,JMP LBL[9] ;\nEND ;\nLBL[9:more]"), NONE);
    assert_eq!(tp("IF (1=1) THEN ;\nEND ;\nENDIF"), NONE);
    assert_eq!(tp("END ;\n!comment"), [6]);
    assert_eq!(tp("END ;\nIF (R[1]=1) THEN ;\nDO[1]=ON ;\nELSE ;\nENDIF"), [9]);
}

/// The controller stops with an alarm where a point's frames are not the chosen ones.
#[test]
fn frames_of_a_point_of_tp_are_the_chosen_ones() {
    let found = |body: &str, numbers: &str| -> Vec<Note> {
        let frame = nalgebra::Isometry3::identity();
        let frames = || [1, 2].map(|number| (number, frame)).into();
        let job = Settings { tool_frames: frames(), base_frames: frames(), ..settings() };
        let text = tp_text(body, numbers);
        let text = text.replacen("L P[1] 9mm/sec FINE ;\n", "", 1);
        read(text.as_bytes(), Dialect::Fanuc, &job).err().unwrap_or_default()
    };
    let numbers = "UF : 1, UT : 1";
    for (body, said) in [
        ("UTOOL_NUM=2", "P[1] has UT : 1, and UTOOL_NUM is 2"),
        ("UFRAME_NUM=2", "P[1] has UF : 1, and UFRAME_NUM is 2"),
        ("UFRAME_NUM=0", "P[1] has UF : 1, and UFRAME_NUM is 0"),
    ] {
        let found = found(body, numbers);
        assert_eq!(found.iter().map(at).collect::<Vec<_>>(), [4], "{body}: {found:?}");
        assert!(found[0].what.contains(said), "{body}: {found:?}");
        assert!(found[0].what.contains("unless $FRM_CHKTYP = -1"), "{found:?}");
    }
    for body in ["UTOOL_NUM=1 ;\nUFRAME_NUM=1", "R[1]=1"] {
        assert!(found(body, numbers).is_empty(), "{body}");
    }
    assert!(found("UTOOL_NUM=2 ;\nUFRAME_NUM=2", "UF : F, UT : F").is_empty());
    // Not of a position register.
    let register = "UTOOL_NUM=1 ;\nUFRAME_NUM=1 ;\nPR[1]=P[1] ;\nL P[1] 9mm/sec FINE ;\n\
                    UTOOL_NUM=2 ;\nL PR[1] 9mm/sec FINE ;\nUTOOL_NUM=1";
    assert!(found(register, numbers).is_empty());
}

#[test]
fn words_of_apt_for_the_machine_are_a_doubt() {
    let doubts = |word: &str| {
        let text = format!("UNITS/MM\nGOTO/0,0,0\nFEDRAT/400\n{word}\nGOTO/9,0,0");
        told(&of(&text, Dialect::Apt, &settings()), Code::MotionLeftOut)
    };
    for word in [
        "INSERT/S3000",
        "SELECT/SPINDL,2",
        "select/head,2",
        "PPFUN/3,3000",
        "THREAD/TURN",
        "PREFUN/96",
    ] {
        assert_eq!(doubts(word), [4], "{word}");
    }
    for word in ["SELECT/TOOL,5", "SELCTL/5", "COOLNT/ON"] {
        assert_eq!(doubts(word), NONE, "{word}");
    }
}

#[test]
fn blocks_of_heidenhain_that_may_be_skipped_are_a_doubt() {
    for (skip, text) in [
        ("/L X+9 F400", "L X+8\nL X+7"),
        ("/ L X+9 F400", "/L X+8\nL X+7"),
        ("/5 L X+9 F400", "/6 L X+8\nL X+7"),
        ("5 /L X+9 F400", "6 /L X+8\nL X+7"),
    ] {
        let text = format!(
            "BEGIN PGM A MM\nTOOL CALL 1 Z S3000\nL X+0 Y+0 Z+0 R0 FMAX M3\n{skip}\n{text}\n\
             END PGM A MM\n"
        );
        let program = of(&text, Dialect::Heidenhain, &settings());
        assert_eq!(told(&program, Code::MotionLeftOut), [4], "{skip}");
        assert!(program.warnings[0].what.contains("blocks with '/' are read as if they ran"));
        let ends = [0.0, 9.0, 8.0, 7.0].map(|x| ('L', [x, 0.0, 0.0]));
        assert_ends(&program, &ends);
    }
    let text = "BEGIN PGM A MM\n/TOOL CALL 1 Z S3000\nL X+0 Y+0 Z+0 R0 FMAX M3\nCALL LBL 1\n\
                L X+1 F400\nM30\n/LBL 1\nL X+5 F400\nLBL 0\nEND PGM A MM\n";
    let program = of(text, Dialect::Heidenhain, &settings());
    assert_eq!(told(&program, Code::MotionLeftOut), [2]);
    assert_eq!(program.moves.len(), 3);
}

#[test]
fn moves_that_an_unconditional_jump_passes_over_are_a_doubt() {
    let passed = |body: &str| told(&of_krl(body, &settings()), Code::MotionLeftOut);
    assert_eq!(passed("GOTO E\nLIN_REL {X 5}\nE:"), [5]);
    assert_eq!(passed("GOTO E\nWAIT SEC 1\nE:"), NONE);
    assert_eq!(passed("IF 1==1 THEN\nGOTO E\nLIN_REL {X 5}\nENDIF\nE:"), [6]);
    // Another way leads to what is passed over.
    assert_eq!(passed("IF 1==2 THEN\nGOTO M\nENDIF\nGOTO E\nM:\nLIN_REL {X 5}\nE:"), NONE);
    let passed = |body: &str| told(&of_tp(body, &settings()), Code::MotionLeftOut);
    assert_eq!(passed("JMP LBL[1] ;\nL P[1] 5mm/sec FINE ;\nLBL[1]"), [5]);
    assert_eq!(passed("JMP LBL[1] ;\nWAIT 1.00(sec) ;\nLBL[1]"), NONE);
    let other = "IF R[1]=1,JMP LBL[2] ;\nJMP LBL[1] ;\nLBL[2] ;\nL P[1] 5mm/sec FINE ;\nLBL[1]";
    assert_eq!(passed(&format!("R[1]=0 ;\n{other}")), NONE);
}

#[test]
fn a_pulse_and_a_wait_of_tp_leave_the_signal_unknown() {
    let refuses = |body: &str| {
        let body = format!("{body} ;\nIF DO[1]=ON,JMP LBL[1] ;\nL P[1] 5mm/sec FINE ;\nLBL[1]");
        read(tp_text(&body, "UF : 0, UT : 0").as_bytes(), Dialect::Fanuc, &settings()).is_err()
    };
    assert!(!refuses("DO[1]=OFF"));
    assert!(!refuses("DO[1]=OFF ;\nPULSE DO[2],0.5sec"));
    assert!(!refuses("DO[1]=OFF ;\nWAIT DO[1]=OFF"));
    assert!(!refuses("DO[1]=OFF ;\nWAIT DI[3]=ON"));
    let set = ["PULSE DO[1],0.5sec", "DO[1]=PULSE,0.5sec"];
    let awaited = ["WAIT DO[1]=ON", "WAIT DO[1:a AND b]=ON", "WAIT (!DI[2] AND DO[1]=ON)"];
    for body in set.into_iter().chain(awaited) {
        assert!(refuses(&format!("DO[1]=OFF ;\n{body}")), "{body}");
    }
    let timeout = |body: &str, job: &Settings| {
        let body = format!("{body} TIMEOUT,LBL[1] ;\nLBL[1]");
        told(&of_tp(&body, job), Code::MotionLeftOut)
    };
    assert_eq!(timeout("WAIT DI[3]=ON", &settings()), [4]);
    let named = told(&of_tp("WAIT DI[3:TIMEOUT]=ON", &settings()), Code::MotionLeftOut);
    assert_eq!(named, NONE);
    let assume = [("di[3]".to_owned(), Assumed::Truth(true))].into();
    assert_eq!(timeout("WAIT DI[3]=ON", &Settings { assume, ..settings() }), NONE);
    let pulsed = told(&of_tp("PULSE DO[5:Spindle on],1.0sec", &settings()), Code::SpindleCommand);
    assert_eq!(pulsed, [4]);
}

#[test]
fn an_analog_output_that_is_set_to_two_speeds_is_a_doubt() {
    let rapid = |body: &str, job: &Settings| {
        let body = format!("MoveL p,v5,fine,tool0;\n{body}\nMoveL Offs(p,1,0,0),v5,fine,tool0;");
        told(&of(&module(&body), Dialect::Rapid, job), Code::SpindleCommand).len()
    };
    let krl = |body: &str, job: &Settings| told(&of_krl(body, job), Code::SpindleCommand).len();
    let tp = |body: &str, job: &Settings| told(&of_tp(body, job), Code::SpindleCommand).len();
    for (body, expected) in [("3000", 0), ("3000;0;3000;0", 0), ("0;3000;5000;3000", 1)] {
        let all = |before: &str, end: &str| {
            let each = body.split(';').map(|value| format!("{before}{value}{end}"));
            each.collect::<Vec<_>>().join("\n")
        };
        let two = all("SetAO ao1,", ";");
        let three = all("AO[1]=", " ;");
        let three = three.trim_end_matches(" ;");
        assert_eq!(rapid(&two, &settings()), expected, "{two}");
        assert_eq!(krl(&all("$ANOUT[1]=", ""), &settings()), expected, "{body}");
        assert_eq!(tp(three, &settings()), expected, "{three}");
        assert_eq!(rapid(&two, &signal("ao2")), 0);
    }
    assert_eq!(rapid("SetAO ao1,3;\nSetAO ao2,5;", &settings()), 0);
    // A value as speeds have, and another than the job's.
    let stated = Settings { spindle_rpm: Some(3000.0), ..settings() };
    for (value, expected) in [("3000", 0), ("9000", 1), ("10", 0), ("100", 0)] {
        assert_eq!(rapid(&format!("SetAO ao1,{value};"), &stated), expected, "{value}");
        assert_eq!(krl(&format!("$ANOUT[1]={value}"), &stated), expected, "{value}");
        assert_eq!(tp(&format!("AO[1]={value}"), &stated), expected, "{value}");
    }
    assert_eq!(rapid("SetAO ao1,3;\nSetAO ao1,AInput(ai1);", &settings()), 1);
}

fn refused(text: &str, dialect: Dialect, job: &Settings) -> String {
    let found = read(ended(text, dialect).as_bytes(), dialect, job).expect_err(text);
    found[0].what.clone()
}

/// WITH $LOAD holds for its motion; SLOAD(n) is LOAD_DATA[n], which the job's payload stands for
/// where no file has any.
#[test]
fn a_load_of_one_motion_of_krl_counts() {
    let data = "DECL LOAD LOAD_DATA[16]\nLOAD_DATA[2]={M 80,CM {X 0,Y 0,Z 100,A 0,B 0,C 0},J {X 1,Y 1,Z 1}}\n";
    let masses = |body: &str, files: &[&str]| {
        let mut job = settings();
        let file = |text: &&str| {
            Companion::new("config.dat".to_owned(), format!("DEFDAT C\n{text}ENDDAT\n").as_bytes())
        };
        job.companions = files.iter().map(|text| file(text).unwrap()).collect();
        let program = of_krl(body, &job);
        let load = |each: &Move| each.stated.load.as_ref().map(|load| load.mass_kg);
        let masses: Vec<_> = program.moves.iter().map(load).collect();
        (masses, told(&program, Code::ChangeIgnored).len())
    };
    for body in [
        "LIN {X 9} WITH $LOAD=LOAD_DATA[2]",
        "LIN {X 9} WITH $LOAD=SLOAD(2)",
        "SPLINE WITH $LOAD=SLOAD(2)\nSLIN {X 9}\nENDSPLINE",
    ] {
        assert_eq!(masses(body, &[data]), (vec![None, Some(80.0), None], 0), "{body}");
        assert_eq!(masses(body, &[]), (vec![None; 3], 0), "{body}");
    }
    let (found, doubts) = masses("LIN {X 9} WITH $LOAD=SLOAD(3)", &[data]);
    assert_eq!((found, doubts), (vec![None; 3], 1));
}

/// A comment that has the job's text and a number that is not read, or that stands in another file,
/// is a doubt.
#[test]
fn comments_whose_number_is_not_read_are_a_doubt() {
    let job = || Settings {
        spindle_from: Some(SetBy { what: Setter::Comment("SPEED".to_owned()), per_unit: 1.0 }),
        ..settings()
    };
    let own = ["SPEED 900", "SPEED=900 rpm", "speed limits are off", "SPEED off", "x"];
    let open =
        ["Speed: 900", "SPEED(900)", "SPEED S900", "T1 SPEED 900", "SPEED 12,000", "SPEED 1.2E4"];
    for (comments, doubts) in [(&own[..], 0), (&open[..], 1)] {
        for comment in comments {
            let krl = of_krl(&format!("; {comment}\nLIN {{X 9}}"), &job());
            let tp = of_tp(&format!("! {comment}"), &job());
            let rapid = module(&format!("! {comment}\nMoveL p,v5,fine,tool0;"));
            for program in [krl, tp, of(&rapid, Dialect::Rapid, &job())] {
                assert_eq!(told(&program, Code::SpindleCommand).len(), doubts, "{comment}");
            }
        }
    }
    let mut job = job();
    let other = "DEF other()\n; SPEED 900\nEND\n";
    job.companions = vec![Companion::new("other.src".to_owned(), other.as_bytes()).unwrap()];
    assert_eq!(told(&of_krl("", &job), Code::SpindleCommand).len(), 1);
}

/// F is the frame that is selected at run time; stars are what nobody has taught; turns of axes.
#[test]
fn what_a_point_of_tp_leaves_to_the_controller() {
    let at = nalgebra::Isometry3::identity();
    let of_numbers =
        Settings { base_frames: [(1, at)].into(), tool_frames: [(1, at)].into(), ..settings() };
    for (numbers, said) in [("UF : F, UT : 1", "UF : F"), ("UF : 1, UT : F", "UT : F")] {
        let why = refused(&tp_text("", numbers), Dialect::Fanuc, &of_numbers);
        assert!(why.contains(said), "{why}");
    }
    let of_cell = Settings { tcp: Some(at), work_object: Some(at), ..of_numbers };
    of(&tp_text("", "UF : F, UT : F"), Dialect::Fanuc, &of_cell);
    // A point that no move goes to.
    let spare = "P[2]{\n GP1:\n UF : 0, UT : 0, CONFIG : 'N U T, 0, 0, 0',\n X = ********  mm, Y = \
                 ********  mm, Z = 0 mm, W = 0 deg, P = 0 deg, R = 0 deg\n};\n/END";
    let text = tp_text("", "UF : 0, UT : 0").replace("/END", spare);
    of(&text, Dialect::Fanuc, &settings());
    let used = text.replacen("L P[1] 9mm/sec FINE", "L P[2] 9mm/sec FINE", 1);
    assert!(refused(&used, Dialect::Fanuc, &settings()).contains("neither X to R nor J1 to J6"));
    // Joint moves end within half a turn, or it is told.
    let joint = |turns: &str| {
        let text = tp_text("J P[1] 50% FINE", "UF : 0, UT : 0").replace("0, 0, 0'", turns);
        of(&text, Dialect::Fanuc, &settings())
    };
    let program = joint("0, 0, 0'");
    let asked = |each: &Move| {
        let asked = each.stated.configuration.as_ref();
        asked.is_some_and(|asked| !asked.joints.is_empty())
    };
    assert_eq!(program.moves.iter().map(asked).collect::<Vec<_>>(), [false, true, false]);
    assert_eq!(told(&joint("0, 0, 1'"), Code::AxisIgnored).len(), 1);
}

#[test]
fn what_machines_do_otherwise_is_refused_or_a_doubt() {
    let head = "G21 G90\nG0 X0 Y0 Z10\n";
    for (body, said) in [
        ("G16\nG0 X50 Y30\nG91 G81 Y120 Z-7 R-8 F200 K2\nG80 G15", "relative polar"),
        ("#1=5\nIF[#1EQ5]THEN#2=10 ELSE#2=20\nG1 X#2 F100", "ELSE in the block"),
        ("#1=5\nIF[#1EQ5]THEN#3000=1\nG1 X9 F100", "#3000 raises an alarm"),
        ("#3000=1(BAD)\nG1 X9 F100", "#3000 raises an alarm"),
        ("M98 P1002 K5", "M98 with K"),
    ] {
        let why = refused(&format!("{head}{body}"), Dialect::GCode, &settings());
        assert!(why.contains(said), "{body}: {why}");
    }
    let peck =
        |q: &str| of(&format!("{head}G83 Z-5 R2 {q} F100\nG80"), Dialect::GCode, &settings());
    assert_eq!(told(&peck("Q3000"), Code::ChangeIgnored).len(), 1);
    assert!(told(&peck("Q3."), Code::ChangeIgnored).is_empty());
    // Limits of travel move nothing; a word may stand behind the number of a program.
    let calls = format!("{head}G23\nM98 P8000\nM30\nO8000 T4 (CUT)\nG1 X9 F100\nM99\n");
    let program = read(calls.as_bytes(), Dialect::GCode, &settings()).unwrap();
    assert_eq!((program.moves.len(), program.moves[1].stated.tool), (2, Some(4)));
    let master = of(&format!("{head}SETMS(1)\nG1 X9 F100"), Dialect::Sinumerik, &settings());
    assert_eq!(master.moves.len(), 2);
    let cycle = "UNITS/MM\nRAPID\nGOTO/0,0,50\nCYCLE/DRILL,RAPTO,3,FEDTO,-9,RTRCTO,AUTO,MMPM,100\n\
                 GOTO/0,0,0\nGOTO/20,0,0\nCYCLE/OFF";
    assert_eq!(told(&of(cycle, Dialect::Apt, &settings()), Code::ChangeIgnored).len(), 1);
}

/// Behind G49, Z is that of the spindle: a change of tool brings no length back, as D0 has it.
#[test]
fn cuts_under_g49_are_a_doubt() {
    let doubts = |body: &str| {
        let head = "G21 G90 G17 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z50\nG43 H1 Z5\n";
        told(&of(&format!("{head}{body}"), Dialect::GCode, &settings()), Code::ChangeIgnored)
    };
    for (body, lines) in [
        ("G1 Z-1 F100\nG0 Z5\nG49\nG1 Z-2\nX20", vec![9]),
        ("G49 G1 Z-1 F100", vec![6]),
        ("G49\nG81 X5 Z-5 R2 F90", vec![7]),
        ("G0 G49 Z9\nT1 M6\nM3\nG1 Z-1 F100", vec![9]),
        ("G43 H0\nG1 Z-1 F100", vec![7]),
        ("H0\nG1 Z-1 F100", vec![7]),
        ("G1 X5 F100\nG49\nG0 Z9\nX20", vec![]),
        ("G49\nG0 Z9\nG43 H1 Z5\nG1 X5 F100", vec![]),
    ] {
        assert_eq!(doubts(body), lines, "{body}");
    }
    let head = "G21 G90 G40 G49\nT1 M6\nG0 X0 Y0 Z5\nG1 X9 F100";
    assert_eq!(told(&of(head, Dialect::GCode, &settings()), Code::ChangeIgnored), NONE);
}

/// Nothing follows that the spindle could cut in.
#[test]
fn a_code_that_is_not_known_before_the_end_is_no_doubt() {
    let read = |body: &str| {
        let head = "G21 G90 G17 G94\nS3000 M3\nG0 X0 Y0 Z5\nG1 X9 F100\nM5\n";
        of(&format!("{head}{body}"), Dialect::GCode, &settings())
    };
    for body in ["M33", "M33\n(done)\nM9\nG40 G80 G90", "N1 M33 M9\n/M1\n%"] {
        let program = read(body);
        assert_eq!(told(&program, Code::SpindleCommand), NONE, "{body}");
        assert_eq!(told(&program, Code::LeftOut), [6], "{body}");
    }
    for home in ["M33\nG91 G28 Z0", "M33\nG53 G0 Z0"] {
        assert_eq!(told(&read(home), Code::SpindleCommand), NONE, "{home}");
    }
    for body in ["M33\nG0 X20", "G0 X20 M33", "M33\nM3\nG1 X20", "M33\nG4 P1.5"] {
        assert_eq!(told(&read(body), Code::SpindleCommand), [6], "{body}");
    }
    // In a subprogram, and before a call of one.
    for body in ["M98 P7\nG0 X20\nM30\nO7\nM33\nM99", "M33\nM98 P7\nM30\nO7\nG0 X20\nM99"] {
        assert_eq!(told(&read(body), Code::SpindleCommand).len(), 1, "{body}");
    }
}

#[test]
fn stops_of_g_code_that_may_be_skipped_are_no_doubt() {
    let doubts = |block: &str| {
        let text = format!("G21 G90 G94\nG0 X0 Y0 Z0\nG1 X10 F100\n{block}\nX20");
        told(&of(&text, Dialect::GCode, &settings()), Code::MotionLeftOut)
    };
    for block in ["/M1", "/M0", "N10 /M1", "/2 M1 (look)", "/N20 M8", "/(a comment)"] {
        assert_eq!(doubts(block), NONE, "{block}");
    }
    for block in ["/M3", "/X15", "/M1 G0", "/#1=5", "/GOTO 5\nN5 X30", "X15 /M1"] {
        assert_eq!(doubts(block), [4], "{block}");
    }
}

/// LinuxCNC: what a subroutine gives back, and whether it does.
#[test]
fn subroutines_give_values_back() {
    const NESTED: &str = "o2 if [#1 LT 5]\no1 return [#1]\no2 endif\no1 call [#1-6]\n\
                          o1 endsub [#<_value>]";
    let text = |body: &str| {
        format!(
            "G21 G90 G94\nG0 X0 Y0 Z5\no1 sub\n{body}\no1 call [10]\n\
             G1 X[#<_value> + 100 * #<_value_returned> + 1] F100"
        )
    };
    for (body, x) in [
        ("o1 return [#1+1]\no1 endsub", 112.0),
        ("o1 endsub [#1 * 2]", 121.0),
        ("o1 return\no1 endsub [5]", 1.0),
        ("o1 endsub", 1.0),
        (NESTED, 105.0),
    ] {
        let program = of(&text(body), Dialect::GCode, &settings());
        assert_ends(&program, &[('L', [0.0, 0.0, 5.0]), ('L', [x, 0.0, 5.0])]);
    }
    let within = text("G1 X#<_value> F100\no1 endsub [5]");
    let why = refused(&within, Dialect::GCode, &settings());
    assert!(why.contains("'_value' is read, and the program has not set it"), "{why}");
}

/// G96 is about the speed; G97 ends it; E of G187 says how much corners are rounded.
#[test]
fn codes_beside_the_motion_say_what_they_are() {
    let head = "G21 G90 G17 G94\nT1 M6\nG97 S3000 M3\nG0 X0 Y0 Z5\n";
    let why = refused(&format!("{head}G96 S90\nG1 X9 F100"), Dialect::GCode, &settings());
    assert!(why.contains("G96 keeps the cutting speed"), "{why}");
    let ignored = |block: &str| {
        let program = of(&format!("{head}{block}\nG1 X9 F100"), Dialect::GCode, &settings());
        assert!((program.moves[1].feed_m_per_s * 6e4 - 100.0).abs() < 1e-9, "{block}");
        told(&program, Code::AxisIgnored)
    };
    assert_eq!(ignored("G187 P3 E0.01"), NONE);
    assert_eq!(ignored("G187 E.02"), NONE);
    assert_eq!(ignored("G1 X5 E2 F100\nX0"), [5]);
}

/// LinuxCNC: M61 says which tool is in the spindle, M62 to M65 switch outputs, M66 waits.
#[test]
fn codes_of_linuxcnc_for_the_tool_and_for_signals() {
    let text =
        |block: &str| format!("G21 G90 G17 G94\nT1 M6\nS3000 M3\nG0 X0 Y0 Z5\n{block}\nG1 X9 F100");
    let of = |block: &str| of(&text(block), Dialect::GCode, &settings());
    let tool = of("M61 Q7");
    assert_eq!(tool.moves[1].stated.tool, Some(7));
    assert!(tool.warnings.is_empty(), "{:?}", tool.warnings);
    assert!(told(&of("M61"), Code::ChangeIgnored).contains(&5));
    let output = of("M64 P1");
    assert_eq!(told(&output, Code::LeftOut), [5]);
    assert!(output.warnings[0].what.contains("M64 switches an output"), "{:?}", output.warnings);
    // Where the spindle stands, the output may start it.
    let stopped = of("M5\nM64 P1");
    let doubt = |note: &Note| {
        note.code == Code::SpindleCommand && note.what.contains("M64 switches an output")
    };
    assert!(stopped.warnings.iter().any(doubt), "{:?}", stopped.warnings);
    for wait in ["M66 P0 L3 Q5", "M66 E1 L0"] {
        let program = of(wait);
        assert_eq!(told(&program, Code::Assumed), [5], "{wait}");
        assert_eq!((program.moves.len(), program.warnings.len()), (2, 1), "{wait}");
    }
}
