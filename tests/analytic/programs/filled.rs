//! Data that only the run knows: answers of an operator, what a channel gives, what another task sets; and what KUKA's
//! basic package makes of a speed.

use detune::notes::Code;
use detune::program::{
    Assumed, Companion, Dialect, NewSpeed, Program, Rewrite, SetBy, Setter, Settings, Spindle,
    read, rewrite,
};

use super::support::settings;

fn rapid(body: &str, assume: &[(&str, Assumed)]) -> Result<Program, Vec<String>> {
    let text = format!(
        "MODULE M\nPERS tooldata t:=[TRUE,[[0,0,150],[1,0,0,0]],[4,[0,0,70],[1,0,0,0],0,0,0]];\n\
         CONST robtarget p0:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
         VAR num n:=1;\nVAR bool late:=FALSE;\nPERS bool go:=FALSE;\nVAR dnum dn:=1;\n\
         PROC main()\nConfL\\Off;\nMoveL p0,v100,fine,t;\n{body}\nMoveL Offs(p0,100,0,0),v100,fine,t;\n\
         ENDPROC\nENDMODULE\n"
    );
    let assume = assume.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let job = Settings { assume, ..settings() };
    read(text.as_bytes(), Dialect::Rapid, &job)
        .map_err(|found| found.iter().map(ToString::to_string).collect())
}

fn krl(data: &str, body: &str) -> Result<Program, Vec<String>> {
    let text = format!(
        "DEF p()\nDECL INT N\nDECL BOOL B\nDECL CHAR S[9]\nN=1\nB=FALSE\n$VEL.CP=0.1\n\
         PTP {{X 0,Y 0,Z 100,A 0,B 0,C 180}}\n{body}\nLIN_REL {{X 100}}\nEND\n"
    );
    let text_of_data = format!("DEFDAT $CONFIG PUBLIC\n{data}\nENDDAT\n");
    let companions = vec![Companion { name: "config.dat".to_owned(), text: text_of_data }];
    let job = Settings { companions, ..settings() };
    read(text.as_bytes(), Dialect::Krl, &job)
        .map_err(|found| found.iter().map(ToString::to_string).collect())
}

#[test]
fn a_branch_on_what_the_run_fills_in_is_refused() {
    const MOVE: &str = "MoveL Offs(p0,0,200,0),v20,fine,t; ENDIF";
    for (fills, asked, of) in [
        ("TPReadFK n,\"Cut?\",\"Yes\",\"No\",stEmpty,stEmpty,stEmpty;", "n=2", "TPReadFK"),
        ("TPReadNum n,\"how many\";", "n>1", "TPReadNum"),
        ("TPReadDnum dn,\"how many\";", "dn>1", "TPReadDnum"),
        ("ReadAnyBin ch,n;", "n=2", "ReadAnyBin"),
        ("WaitAI ai1\\GT,5\\MaxTime:=1\\ValueAtTimeout:=n;", "n>1", "WaitAI"),
        ("WaitDI di1,1\\MaxTime:=5\\TimeFlag:=late;", "late", "WaitDI"),
        ("late:=StrToVal(ReadStr(ch),n);", "n=2", "StrToVal"),
        ("WaitUntil go;", "go", "another task"),
        ("WaitUntil n>1;", "n=2", "another task"),
    ] {
        let faults =
            rapid(&format!("{fills}\nIF {asked} THEN {MOVE}"), &[]).unwrap_err().join("\n");
        assert!(faults.contains("at run time") && faults.contains(of), "{fills}: {faults}");
        // Without the instruction the file decides.
        let found = rapid(&format!("IF {asked} THEN {MOVE}"), &[]).unwrap();
        assert_eq!(found.moves.len(), 2, "{fills}");
    }
    // The job says what the operator answers, at every question.
    let ask = "TPReadNum n,\"how many\";\nIF n=2 THEN MoveL Offs(p0,0,200,0),v20,fine,t; ENDIF\n";
    let found = rapid(&ask.repeat(2), &[("n", Assumed::Number(2.0))]).unwrap();
    assert_eq!(found.moves.len(), 4);
    // What holds already is waited for by nobody.
    let found = rapid("go:=TRUE;\nWaitUntil go;\nIF go THEN n:=1; ENDIF", &[]).unwrap();
    assert_eq!(found.moves.len(), 2);
}

#[test]
fn krl_reads_channels_and_waits_for_others() {
    for (fills, asked) in [
        ("SREAD(S[],STAT,OFF,\"%d\",N)", "N==2"),
        ("ANIN ON N=1.0*$ANIN[1]", "N==2"),
        ("CREAD(H,STAT,MODE,TIME,OFF,\"%d\",N)", "N==2"),
        ("WAIT FOR N==2", "N==2"),
        ("WAIT FOR B", "B"),
    ] {
        let branch = format!("IF {asked} THEN\nLIN_REL {{Y 200}}\nENDIF");
        let faults = krl("", &format!("{fills}\n{branch}")).unwrap_err().join("\n");
        assert!(faults.contains("about motion at run time"), "{fills}: {faults}");
        assert_eq!(krl("", &branch).unwrap().moves.len(), 2, "{fills}");
    }
}

/// bas.src of KSS: a speed above DEF_VEL_CP becomes that, another is multiplied by DEF_VEL_FACT; joints asked for more
/// than 100 % run at DEF_VEL_PTP.
#[test]
fn the_basic_package_limits_speeds() {
    let speed = |data: &str, body: &str| -> f64 {
        let found = krl(data, body).unwrap_or_else(|faults| panic!("{faults:?}"));
        found.moves.last().unwrap().feed_m_per_s
    };
    const LIMIT: &str = "DECL GLOBAL REAL DEF_VEL_CP=0.2";
    for (data, body, expected) in [
        (LIMIT, "BAS(#VEL_CP,0.4)", 0.2),
        (LIMIT, "BAS(#CP_PARAMS,0.4)", 0.2),
        (LIMIT, "BAS(#VEL_CP,0.15)", 0.15),
        ("", "BAS(#VEL_CP,0.4)", 0.4),
        (
            "DECL GLOBAL REAL DEF_VEL_CP=2\nDECL GLOBAL REAL DEF_VEL_FACT=0.5",
            "BAS(#VEL_CP,0.1)",
            0.05,
        ),
        // The variable itself has no such limit.
        (LIMIT, "$VEL.CP=0.4", 0.4),
    ] {
        let found = speed(data, body);
        assert!((found / expected - 1.0).abs() < 1e-6, "{data} {body}: {found}");
    }
    // What takes the place of more than 100 % is a doubt where no file says it.
    let doubts = |data: &str| {
        let found = krl(data, "BAS(#VEL_PTP,150)").unwrap();
        found.warnings.iter().map(|it| it.code).collect::<Vec<_>>()
    };
    assert_eq!(doubts(""), [Code::ChangeIgnored]);
    assert!(doubts("DECL GLOBAL INT DEF_VEL_PTP=50").is_empty());
}

/// `assume` is what the message advises: it says what a channel gives, and what is waited for, too.
#[test]
fn what_the_job_assumes_settles_what_is_filled_in() {
    let text = "DEF p()\nDECL INT N\nN=1\n$VEL.CP=0.1\nPTP {X 0,Y 0,Z 100,A 0,B 0,C 180}\n\
                FILLS\nIF N==2 THEN\nLIN_REL {Y 200}\nENDIF\nLIN_REL {X 100}\nEND\n";
    for fills in ["SREAD(S[],STAT,OFF,\"%d\",N)", "WAIT FOR N==2"] {
        let text = text.replace("FILLS", fills);
        let moves = |value: f64| {
            let assume = [("n".to_owned(), Assumed::Number(value))].into();
            let job = Settings { assume, ..settings() };
            read(text.as_bytes(), Dialect::Krl, &job).unwrap().moves.len()
        };
        assert_eq!([moves(2.0), moves(1.0)], [3, 2], "{fills}");
    }
    let asked = "WaitUntil n>1;\nIF n=2 THEN MoveL Offs(p0,0,200,0),v20,fine,t; ENDIF";
    assert_eq!(rapid(asked, &[("n", Assumed::Number(2.0))]).unwrap().moves.len(), 3);
}

/// Also under a condition that only the run decides, which may be met or not.
#[test]
fn what_may_be_filled_in_is_not_known_either() {
    const MOVE: &str = "MoveL Offs(p0,0,200,0),v20,fine,t; ENDIF";
    for (fills, asked) in [
        ("TPReadNum n,\"how many\";", "n=2"),
        ("WaitDI di1,1\\MaxTime:=5\\TimeFlag:=late;", "late"),
        ("go:=StrToVal(\"2\",n);", "n=2"),
        ("WaitUntil n>1;", "n=2"),
    ] {
        let body = format!("IF DInput(di2)=1 THEN {fills} ENDIF\nIF {asked} THEN {MOVE}");
        let faults = rapid(&body, &[]).unwrap_err().join("\n");
        assert!(faults.contains("about motion at run time"), "{fills}: {faults}");
    }
    for (fills, asked) in [
        ("SREAD(S[],STAT,OFF,\"%d\",N)", "N==2"),
        ("B=STRTOINT(S[],N)", "N==2"),
        ("WAIT FOR N==2", "N==2"),
    ] {
        let branch = format!("IF {asked} THEN\nLIN_REL {{Y 200}}\nENDIF");
        let body = format!("IF $IN[1] THEN\n{fills}\nENDIF\n{branch}");
        let faults = krl("", &body).unwrap_err().join("\n");
        assert!(faults.contains("about motion at run time"), "{fills}: {faults}");
    }
}

/// A trap sets data whenever its interrupt comes; what it has for itself is its own.
#[test]
fn what_traps_set_is_known_only_at_run_time() {
    let text = |of_trap: &str, asked: &str| {
        format!(
            "MODULE M\nVAR intnum i1;\nVAR num n:=1;\nVAR bool late:=FALSE;\n\
             CONST robtarget p0:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
             PROC main()\nCONNECT i1 WITH tStop;\nISignalDI di1,1,i1;\nn:=1;\n\
             MoveL p0,v100,fine,tool0;\nIF {asked} THEN MoveL Offs(p0,0,200,0),v20,fine,tool0; ENDIF\n\
             MoveL Offs(p0,100,0,0),v100,fine,tool0;\nENDPROC\n\
             PROC mark()\nlate:=TRUE;\nENDPROC\nPROC put(\\INOUT num to)\nto:=2;\nENDPROC\nTRAP tStop\n{of_trap}\nENDTRAP\nENDMODULE\n"
        )
    };
    let of = |of_trap: &str, asked: &str, assume: &[(&str, Assumed)]| {
        let assume = assume.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        read(text(of_trap, asked).as_bytes(), Dialect::Rapid, &Settings { assume, ..settings() })
    };
    for (of_trap, asked) in [
        ("n:=2;", "n=2"),
        ("mark;", "late"),
        ("Incr n;", "n=2"),
        // What the trap does besides says nothing of that.
        ("StorePath;\nn:=2;\nRestoPath;", "n=2"),
        ("IF n>3 RAISE 3;\nn:=2;", "n=2"),
        // By a parameter of its routine.
        ("put \\to:=n;", "n=2"),
        ("VAR num n;\nput \\to:=n;\nmark;", "late"),
        // The trap's own of that name is another than the routine's.
        ("VAR bool late;\nmark;\nlate:=FALSE;", "late"),
    ] {
        let faults = of(of_trap, asked, &[]).unwrap_err();
        assert!(faults[0].what.contains("a TRAP sets it"), "{faults:?}");
    }
    assert_eq!(of("n:=2;", "n=2", &[("n", Assumed::Number(2.0))]).unwrap().moves.len(), 3);
    assert_eq!(of("n:=2;", "late", &[]).unwrap().moves.len(), 2);
    assert_eq!(of("VAR num n;\nn:=2;", "n=2", &[]).unwrap().moves.len(), 2);
}

/// What a trap sets that the program does not connect is a doubt; behind CONNECT, what the program
/// itself sets right before its use is one, and behind IDelete it is its own again.
#[test]
fn a_trap_sets_data_from_its_connect_on() {
    let of = |body: &str| {
        let text = format!(
            "MODULE M\nVAR intnum i1;\nVAR num n:=5;\nVAR robtarget q;\n\
             CONST robtarget p0:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
             PROC part()\n{body}\nENDPROC\nPROC start()\nCONNECT i1 WITH tr;\nENDPROC\n\
             TRAP tr\nn:=9;\nq:=p0;\nENDTRAP\nENDMODULE\n"
        );
        let job = Settings { procedure: Some("part".to_owned()), ..settings() };
        read(text.as_bytes(), Dialect::Rapid, &job)
    };
    const START: &str = "MoveL p0,v100,fine,tool0;";
    const BY_N: &str = "MoveL Offs(p0,n,0,0),v100,fine,tool0;";
    const BY_Q: &str = "q:=Offs(p0,7,0,0);\nMoveL q,v100,fine,tool0;";
    for (body, x, doubts) in [
        // `start` may have run before.
        (format!("{START}\n{BY_N}"), 5.0, vec![8]),
        (format!("{START}\n{BY_Q}"), 7.0, vec![9]),
        (format!("start;\n{START}\n{BY_Q}"), 7.0, vec![10]),
        (format!("start;\n{START}\nn:=3;\nSetDO do1,1;\n{BY_N}"), 3.0, vec![11]),
        (format!("IF DInput(d)=1 start;\n{START}\nn:=3;\n{BY_N}"), 3.0, vec![10]),
        (format!("start;\nIDelete i1;\nn:=3;\n{START}\n{BY_N}"), 3.0, vec![]),
    ] {
        let found = of(&body).unwrap_or_else(|found| panic!("{body}: {found:?}"));
        let end = super::support::end(&found.moves[1]).1.translation.x * 1e3;
        assert_eq!(end.round(), x, "{body}");
        let told = found.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
        assert_eq!(told.map(super::support::at).collect::<Vec<_>>(), doubts, "{body}");
    }
    // Nobody says that a trap which no file connects never runs.
    let text = "MODULE M\nVAR num n:=5;\nCONST robtarget p0:=[[0,0,0],[0,0,1,0],[0,0,0,0],\
                [9E9,9E9,9E9,9E9,9E9,9E9]];\nPROC main()\nMoveL p0,v100,fine,tool0;\n\
                MoveL Offs(p0,n,0,0),v100,fine,tool0;\nENDPROC\nTRAP tr\nn:=9;\nENDTRAP\nENDMODULE\n";
    let found = read(text.as_bytes(), Dialect::Rapid, &settings()).unwrap();
    let told = found.warnings.iter().filter(|note| note.code == Code::MotionLeftOut);
    assert_eq!(told.map(super::support::at).collect::<Vec<_>>(), [6]);
    for body in [
        format!("start;\n{START}\n{BY_N}"),
        // The interrupt may come on the move before.
        format!("start;\nn:=3;\n{START}\n{BY_N}"),
        format!("IF DInput(d)=1 start;\n{START}\n{BY_N}"),
        format!("start;\nIDelete i1;\n{START}\n{BY_N}"),
    ] {
        let found = of(&body).expect_err(&body);
        assert!(found[0].what.contains("a TRAP sets it"), "{body}: {found:?}");
    }
}

/// Technical reference manual: what these write is not what the program has set before; LoadId
/// moves the axes until it has the load.
#[test]
fn what_services_write_is_known_only_at_run_time() {
    const BRANCH: &str = "IF n=2 THEN MoveL Offs(p0,0,200,0),v20,fine,t; ENDIF";
    for (fills, of) in [
        ("IVarValue \"dev\",1,n,i1;", "IVarValue"),
        ("GetJointData ROB_1,1\\Position:=n;", "GetJointData"),
        ("FricIdEvaluate n;", "FricIdEvaluate"),
        ("SetDataVal \"n\",5;", "SetDataVal"),
        ("late:=ParIdPosValid(1,n);", "ParIdPosValid"),
        ("Elsewhere n;", "Elsewhere, which is in no file that is read, may set"),
    ] {
        let faults = rapid(&format!("{fills}\n{BRANCH}"), &[]).unwrap_err().join("\n");
        assert!(faults.contains("at run time") && faults.contains(of), "{fills}: {faults}");
    }
    // A constant, and what is only read.
    for reads in ["Elsewhere p0.trans.x;", "IPers n,i1;", "WriteVar dev,1,n;"] {
        let found = rapid(&format!("{reads}\n{BRANCH}"), &[]);
        assert_eq!(found.unwrap().moves.len(), 2, "{reads}");
    }
    let found = rapid("LoadId 1,1,t;", &[]).unwrap();
    let told: Vec<_> = found
        .warnings
        .iter()
        .filter(|note| note.what.contains("LoadId"))
        .map(|note| (note.code, super::support::at(note)))
        .collect();
    assert_eq!(told, [(Code::MotionLeftOut, 11), (Code::ChangeIgnored, 12)]);
    assert!(found.moves[1].stated.load.is_none() && found.moves[0].stated.load.is_some());
    let found = rapid("IF DInput(di2)=1 LoadId 1,1,t;", &[]).unwrap_err().join("\n");
    assert!(found.contains("IF decides about motion at run time"), "{found}");
}

/// A speed with a sign turns the spindle the other way round.
#[test]
fn a_spindle_that_turns_the_other_way_has_its_speed() {
    let what = Setter::Signal("ao_spindle".to_owned());
    let job = Settings { spindle_from: Some(SetBy { what, per_unit: 1.0 }), ..settings() };
    let text = "MODULE M\nCONST robtarget p0:=[[0,0,0],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
                PROC main()\nMoveL p0,v100,fine,tool0;\nSetAO ao_spindle,-6000;\n\
                MoveL Offs(p0,100,0,0),v100,fine,tool0;\nENDPROC\nENDMODULE\n";
    let found = read(text.as_bytes(), Dialect::Rapid, &job).unwrap();
    assert_eq!(found.moves[1].stated.spindle, Some(Spindle::Turns(Some(6000.0))));
    // The sign is not the number's: it is not written anew.
    let speeds = vec![NewSpeed { end: usize::MAX, rpm: 900.0, job_rpm: None }];
    let to = Rewrite { speeds, keeps_chip_load: false };
    let why = rewrite(text.as_bytes(), Dialect::Rapid, &job, &to).unwrap_err();
    assert!(why.what.contains("not rewritten"), "{why:?}");
}
