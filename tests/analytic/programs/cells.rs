//! What public programs of KUKA and ABB cells do across their files, and what they set beside motion, that was passed
//! over in silence or refused for a wrong reason. Expected figures are worked out by hand.

use detune::motion::{Target, Timing};
use detune::notes::{Class, Code};
use detune::program::{Companion, Dialect, Program, SetBy, Setter, Settings, Spindle, read};
use nalgebra::{UnitQuaternion, Vector3};

use super::support::{assert_ends, at, end, settings};

fn job(files: &[(&str, &str)]) -> Settings {
    let companion =
        |(name, text): &(&str, &str)| Companion { name: (*name).into(), text: (*text).into() };
    Settings { companions: files.iter().map(companion).collect(), ..settings() }
}

#[track_caller]
fn of(text: &str, dialect: Dialect, job: &Settings) -> Program {
    read(text.as_bytes(), dialect, job).unwrap_or_else(|found| panic!("{text}: {found:?}"))
}

/// Where each line of the main program goes, mm along an axis, and how fast, mm/s; the first move apart.
fn along(program: &Program, axis: usize) -> Vec<(f64, f64)> {
    let of = |each| {
        let (_, pose): (char, nalgebra::Isometry3<f64>) = end(each);
        let round = |value: f64| (value * 1e6).round() / 1e3;
        (round(pose.translation.vector[axis]), round(each.feed_m_per_s))
    };
    program.moves.iter().skip(1).map(of).collect()
}

fn doubts(program: &Program) -> Vec<(Code, usize)> {
    let told = program.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    told.map(|note| (note.code, at(note))).collect()
}

const START: &str = "PTP {X 0,Y 0,Z 500,A 0,B 0,C 180}";

fn krl(body: &str) -> Program {
    of(&format!("DEF p()\n$VEL.CP=0.1\n{START}\n{body}\nEND\n"), Dialect::Krl, &settings())
}

#[track_caller]
fn krl_refused(body: &str, why: &str) {
    let text = format!("DEF p()\n{START}\n{body}\nEND\n");
    let found = read(text.as_bytes(), Dialect::Krl, &settings()).expect_err(body);
    assert!(found.iter().any(|note| note.what.contains(why)), "{why}: {found:?}");
}

/// Two modules with data and routines of one name, each LOCAL; and one that hides a name of all.
#[test]
fn local_names_of_rapid_modules_are_their_own() {
    let target = |x: u32| format!("[[{x},0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let main = format!(
        "MODULE One\nLOCAL CONST robtarget p10:={};\nCONST robtarget p20:={};\n\
         PROC main()\nMoveL p10,v100,fine,tool0;\nstep;\ntwo;\nMoveL p20,v100,fine,tool0;\nENDPROC\n\
         LOCAL PROC step()\nVAR num x:=0;\nMoveL Offs(p10,0,5,0),v100,fine,tool0;\nENDPROC\nENDMODULE\n",
        target(100),
        target(200)
    );
    let other = format!(
        "MODULE Two\nLOCAL CONST robtarget p10:={};\nLOCAL PERS robtarget P20:={};\n\
         PROC two()\nMoveL p10,v100,fine,tool0;\nstep;\nMoveL p20,v100,fine,tool0;\nENDPROC\n\
         LOCAL PROC step()\nMoveL Offs(p10,0,7,0),v100,fine,tool0;\nENDPROC\nENDMODULE\n",
        target(300),
        target(400)
    );
    let program = read(main.as_bytes(), Dialect::Rapid, &job(&[("two.mod", &other)])).unwrap();
    assert_ends(
        &program,
        &[
            ('L', [100.0, 0.0, 0.0]),
            ('L', [100.0, 5.0, 0.0]),
            ('L', [300.0, 0.0, 0.0]),
            ('L', [300.0, 7.0, 0.0]),
            ('L', [400.0, 0.0, 0.0]),
            ('L', [200.0, 0.0, 0.0]),
        ],
    );
    // A routine's own names are its own, whatever modules have.
    let named = |text: &str| {
        text.replace("MoveL p10", "step;\nMoveL p10").replace(
            "LOCAL PROC step()",
            "LOCAL VAR num x:=9;\nPROC other(\\num x)\nIF Present(x) MoveL Offs(p10,0,x,0),v100,fine,tool0;\n\
             ENDPROC\nLOCAL PROC step()",
        )
    };
    let one = main
        .replace("two;", "Other \\x:=1;")
        .replace("LOCAL PROC", "LOCAL VAR num x:=3;\nLOCAL PROC");
    let two = named(&other);
    let program = of(&one, Dialect::Rapid, &job(&[("two.mod", &two)]));
    let last = program.moves.iter().map(|each| end(each).1.translation.vector * 1e3);
    let last: Vec<[f64; 2]> = last.map(|at| [at.x.round(), at.y.round()]).collect();
    assert!(last.contains(&[300.0, 1.0]), "{last:?}");
    // Records, too.
    let record = |fields: &str| format!("LOCAL RECORD hole\n{fields}\nENDRECORD\n");
    let use_it = "PROC main()\nVAR hole h;\nh:=[5,9];\nMoveL Offs(p10,0,h.a,0),v100,fine,tool0;\n";
    let one = main.replace("PROC main()\n", &format!("{}{use_it}", record("num a;num b;")));
    let two = other.replace("PROC two()", &format!("{}PROC two()", record("num b;num a;")));
    let program = of(&one, Dialect::Rapid, &job(&[("two.mod", &two)]));
    assert!((end(&program.moves[0]).1.translation.y - 0.005).abs() < 1e-9);
    let [one, two] = [&one, &two].map(|text| text.replace("LOCAL RECORD", "RECORD"));
    let found = read(one.as_bytes(), Dialect::Rapid, &job(&[("two.mod", &two)])).unwrap_err();
    assert!(
        found.iter().any(|note| note.what.contains("record 'hole' is declared twice")),
        "{found:?}"
    );
    // Without LOCAL they are one name, declared twice.
    let plain = other.replace("LOCAL ", "");
    let found = read(main.as_bytes(), Dialect::Rapid, &job(&[("two.mod", &plain)])).unwrap_err();
    assert!(found.iter().any(|note| note.what.contains("'P20' is declared twice")), "{found:?}");
    let of_one = main.replace("LOCAL ", "");
    let hides = read(of_one.as_bytes(), Dialect::Rapid, &job(&[("two.mod", &other)])).unwrap();
    assert_eq!(hides.moves.len(), 6);
}

/// Two taught programs have a point XP1, a speed V and a routine of their own under the same names.
#[test]
fn data_and_routines_of_krl_belong_to_their_module() {
    let point = |x: u16| format!("DECL E6POS XP1={{X {x},Y 0,Z 500,A 0,B 0,C 180}}");
    let list = |name: &str, x: u16, v: &str| format!("DEFDAT {name}\n{}\n{v}\nENDDAT\n", point(x));
    let (own, other) = (list("a", 100, "REAL V=0.05"), list("b", 200, "REAL V=0.01"));
    let main = format!(
        "DEF a()\n{START}\n$VEL.CP=V\nLIN XP1\nb()\nfeed()\nLIN XP1\nEND\nDEF feed()\n$VEL.CP=0.02\nEND\n"
    );
    let sub =
        "DEF b()\n$VEL.CP=V\nLIN XP1\nfeed()\nLIN {X 250}\nEND\nDEF feed()\n$VEL.CP=0.03\nEND\n";
    let mut files = vec![("b.src", sub), ("a.dat", &*own), ("b.dat", &*other)];
    for _ in 0..3 {
        files.rotate_left(1);
        let program = of(&main, Dialect::Krl, &job(&files));
        assert_eq!(
            along(&program, 0),
            [(100.0, 50.0), (200.0, 10.0), (250.0, 30.0), (100.0, 20.0)]
        );
    }
    // The program's own hides a GLOBAL one, which others see.
    let global = list("b", 200, "DECL GLOBAL REAL V=0.01").replace("DEFDAT b", "DEFDAT b PUBLIC");
    for files in [[("a.dat", &*own), ("b.dat", &*global)], [("b.dat", &*global), ("a.dat", &*own)]]
    {
        let main = format!("DEF a()\n{START}\n$VEL.CP=V\nLIN XP1\nEND\n");
        assert_eq!(along(&of(&main, Dialect::Krl, &job(&files)), 0), [(100.0, 50.0)]);
    }
    // What every data list of a controller has is no module's own.
    let stock = "EXT BAS (BAS_COMMAND :IN,REAL :IN )\nSIGNAL SPD $ANOUT[1]";
    let lists = ["a", "b"].map(|name| format!("DEFDAT {name}\n{stock}\nENDDAT\n"));
    let sub = "DEF b()\nBAS(#VEL_CP,0.2)\n$ANOUT[1]=0.9\nLIN {X 9}\nEND\n";
    let mut cell = job(&[("b.src", sub), ("a.dat", &lists[0]), ("b.dat", &lists[1])]);
    let what = Setter::Signal("$ANOUT[1]".to_owned());
    cell.spindle_from = Some(SetBy { what, per_unit: 1e4 });
    let program = of(&format!("DEF a()\n{START}\nb()\nEND\n"), Dialect::Krl, &cell);
    assert_eq!(along(&program, 0), [(9.0, 200.0)]);
    assert_eq!(program.moves[1].stated.spindle, Some(Spindle::Turns(Some(9000.0))));
    let files = [("b.dat", &*global)];
    let main = format!("DEF a()\n{START}\n$VEL.CP=V\nLIN {{X 9}}\nEND\n");
    assert_eq!(along(&of(&main, Dialect::Krl, &job(&files)), 0), [(9.0, 10.0)]);
}

#[test]
fn how_the_tool_turns_on_lines_and_arcs() {
    let a_deg = |program: &Program| -> Vec<f64> {
        let first = end(&program.moves[0]).1.rotation;
        let turned = |each| (end(each).1.rotation.angle_to(&first).to_degrees()).round();
        program.moves.iter().skip(1).map(turned).collect()
    };
    let turn = "LIN {X 50,A 90}";
    assert_eq!(a_deg(&krl(turn)), [90.0]);
    let constant = krl(&format!("$ORI_TYPE=#CONSTANT\n{turn}\n$ORI_TYPE=#VAR\nLIN {{X 0,A 90}}"));
    assert_eq!(a_deg(&constant), [0.0, 90.0]);
    let form = krl(&format!("LDAT_ACT={{VEL 0.1,ORI_TYP #CONSTANT}}\nBAS(#CP_DAT)\n{turn}"));
    assert_eq!(a_deg(&form), [0.0]);
    let with = krl("SLIN {X 50,A 90} WITH $ORI_TYPE=#CONSTANT\nSLIN {X 0,A 90}");
    assert_eq!(a_deg(&with), [0.0, 90.0]);
    assert!([&constant, &form, &with].into_iter().all(|program| doubts(program).is_empty()));
    // Forms of KSS 8 name it by their data.
    let data = "LDAT LCP1\nLCP1={VEL 0.1,ORI_TYP #CONSTANT}";
    let with = format!("{data}\nS{turn} WITH $ORI_TYPE=SORI_TYP(LCP1)\nSLIN {{X 0,A 90}}");
    assert_eq!(a_deg(&krl(&with)), [0.0, 90.0]);
    let var = krl(&with.replace("CONSTANT", "VAR"));
    assert_eq!((a_deg(&var), doubts(&var)), (vec![90.0, 90.0], vec![]));
    let axes =
        "PTP {A1 0,A2 0,A3 0,A4 0,A5 9,A6 0}\n$ORI_TYPE=#CONSTANT\nLIN {X 9,Y 0,Z 9,A 9,B 0,C 0}";
    assert_eq!(doubts(&krl(axes)), [(Code::AxisIgnored, 6)]);
    let unread = krl(&format!("SPLINE\nS{turn} WITH $ORI_TYPE=#IGNORE\nENDSPLINE"));
    assert_eq!(doubts(&unread), [(Code::AxisIgnored, 5)]);
    let arc = "CIRC {X 50,Y 50},{X 100,Y 0}";
    assert_eq!(doubts(&krl(&format!("$CIRC_TYPE=#PATH\n{arc}"))), [(Code::AxisIgnored, 5)]);
    assert_eq!(doubts(&krl(&format!("$CIRC_TYPE=#BASE\n{arc}"))), []);
}

#[test]
fn what_may_change_path_or_speed_is_a_doubt() {
    for set in ["$VEL_PTP=10", "$RED_VEL=10", "$XYZ_SPEED=1"] {
        assert_eq!(
            doubts(&krl(&format!("{set}\nLIN {{X 9}}"))),
            [(Code::ChangeIgnored, 4)],
            "{set}"
        );
    }
    let weave = "$TECH[1].MODE=#CYCLE\nLIN {X 9}";
    assert_eq!(doubts(&krl(weave)), [(Code::MotionLeftOut, 4)]);
    assert_eq!(doubts(&krl(&weave.replace("CYCLE", "OFF"))), []);
    // Each way over a place that no file gives.
    let twice = krl("SPTP XHOME\nPTP {X 9,Y 0,Z 500,A 0,B 0,C 180}\nPTP XHOME2\n\
         PTP {X 0,Y 0,Z 500,A 0,B 0,C 180}");
    assert_eq!(doubts(&twice), [(Code::MotionLeftOut, 4), (Code::MotionLeftOut, 6)]);
    // The inline form's data are in no file.
    krl_refused("FDAT_ACT=FP1\nBAS(#CP_PARAMS,0.1)\nLIN {X 9}", "'fp1' is declared in no file");
    let home = "PDAT_ACT=PDEFAULT\nFDAT_ACT=FHOME\nBAS(#PTP_PARAMS,100)\nPTP XHOME";
    let form = "FDAT_ACT={TOOL_NO 0,BASE_NO 0}\nBAS(#CP_PARAMS,0.1)\nLIN {X 9}";
    assert_eq!(along(&krl(&format!("{form}\n{home}")), 0), [(9.0, 100.0)]);
    // A frame for one move does not stand for the form's.
    let once = "FDAT_ACT=FP1\nBAS(#CP_PARAMS,0.1)\nSLIN {X 9} WITH $TOOL=$NULLFRAME,$BASE=$NULLFRAME\nLIN {X 0}";
    krl_refused(once, "'fp1' is declared in no file");
    let axes = "FDAT_ACT=FP1\nBAS(#PTP_PARAMS,50)\nPTP {A1 0,A2 0,A3 0,A4 0,A5 9,A6 0}";
    assert_eq!(doubts(&krl(axes)), [(Code::ChangeIgnored, 6)]);
    krl_refused("LDAT_ACT=LCP1\nBAS(#CP_DAT)\nLIN {X 9}", "'lcp1' is declared in no file");
}

#[test]
fn krl_that_was_refused_for_a_wrong_reason() {
    let dwell = krl("WAIT SEC .15\nLIN {X .5}");
    assert_eq!(dwell.moves[1].timing, Timing::Seconds(0.15));
    assert_eq!(along(&dwell, 0)[1].0, 0.5);
    for endless in ["WHILE TRUE\nLIN {X 9}\nENDWHILE", "REPEAT\nLIN {X 9}\nUNTIL FALSE"] {
        let program = krl(endless);
        assert_eq!((program.moves.len(), doubts(&program)), (2, vec![(Code::MotionLeftOut, 4)]));
    }
    let later = krl("PDAT_ACT=PCP1\nBAS(#PTP_DAT)\nBAS(#VEL_PTP,10)\nPTP {X 9}");
    assert_eq!(later.moves[1].timing, Timing::Joints(0.1));
    assert_eq!(doubts(&later), []);
    let unset = krl("PDAT_ACT=PCP1\nBAS(#PTP_DAT)\nPTP {X 9}");
    assert_eq!(doubts(&unset), [(Code::ChangeIgnored, 6)]);
    krl_refused(
        "PTP {A1 0,A2 0,A3 0,A4 0,A5 9,A6 0}\nLIN_REL {X 9}",
        "the point before is given by axes",
    );
    krl_refused("STOP WHEN PATH=5", "STOP is no statement");
}

const DATA: &str = "CONST robtarget p1:=[[800,0,800],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
                    CONST robtarget p2:=[[800,200,800],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
                    PERS wobjdata w1:=[FALSE,TRUE,\"\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n\
                    PERS tooldata t1:=[TRUE,[[0,0,50],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n\
                    VAR num n:=0;\n";

/// The body begins on line 9, behind a move to p1; `more` stands behind the procedure.
fn abb(body: &str, more: &str, job: &Settings) -> Program {
    of(&module(body, more), Dialect::Rapid, job)
}

fn module(body: &str, more: &str) -> String {
    format!(
        "MODULE m\n{DATA}PROC main()\nMoveJ p1,v100,fine,t1;\n{body}\nENDPROC\n{more}\nENDMODULE\n"
    )
}

#[track_caller]
fn abb_refused(body: &str, more: &str, why: &str) {
    let found = read(module(body, more).as_bytes(), Dialect::Rapid, &settings()).expect_err(body);
    assert!(found.len() == 1 && found[0].what.contains(why), "{why}: {found:?}");
}

#[test]
fn a_synchronised_procedure_runs_where_its_move_ends() {
    let body = "MoveLSync p2,v100,fine,t1,\"prc\";\nMoveL p1,v100,fine,t1;";
    let procedure = "PROC prc()\nVelSet 10,5000;\nMoveL Offs(p2,0,0,-200),v100,fine,t1;\nENDPROC";
    let program = abb(body, procedure, &settings());
    assert_eq!(along(&program, 2), [(800.0, 100.0), (600.0, 10.0), (800.0, 10.0)]);
    let missing = abb(body, "", &settings());
    assert_eq!(doubts(&missing), [(Code::MotionLeftOut, 9)]);
}

/// The job's frames stand for those that no file declares; tool0 and wobj0 beside them are the
/// controller's own.
#[test]
fn tool0_and_wobj0_beside_frames_that_no_file_declares() {
    let mut job = settings();
    job.work_object = Some(nalgebra::Isometry3::translation(1.0, 0.0, 0.0));
    job.tcp = Some(nalgebra::Isometry3::translation(0.0, 0.0, 0.2));
    let ends = |body: &str| -> Vec<(f64, f64)> {
        let program = abb(body, "", &job);
        let of = |each: &detune::motion::Move| (end(each).1.translation.x, each.tcp.translation.z);
        program.moves.iter().skip(1).map(of).collect()
    };
    let [own, other] =
        ["MoveL p1,v100,fine,tool0\\WObj:=wobj0;", "MoveL p1,v100,fine,tX\\WObj:=wX;"];
    let alone = ends(own);
    let both = ends(&format!("{own}\n{other}\n{own}"));
    assert_eq!((alone[0].1, both[0].1, both[1].1, both[2].1), (0.2, 0.0, 0.2, 0.0));
    assert!((alone[0].0 - both[0].0 - 1.0).abs() < 1e-12, "{alone:?} {both:?}");
    assert!((both[1].0 - both[0].0 - 1.0).abs() < 1e-12, "{both:?}");
    // It is told where a path depends on it, and what nothing runs has no part in it.
    let told = doubts(&abb(&format!("{own}\n{other}"), "", &job));
    assert!(told.contains(&(Code::ChangeIgnored, 9)), "{told:?}");
    let idle = format!("PROC home()\n{other}\nENDPROC");
    let of_idle = abb(own, &idle, &job);
    assert_eq!(of_idle.moves[1].tcp.translation.z, 0.2);
    // An argument, and a copy.
    let routine = "PROC cut(PERS tooldata t)\nMoveL p1,v100,fine,t;\nENDPROC";
    let given = abb(&format!("{own}\ncut tX;"), routine, &job);
    assert_eq!((given.moves[1].tcp.translation.z, given.moves[2].tcp.translation.z), (0.0, 0.2));
    let flange = doubts(&abb(&format!("{other}\ncut tool0;"), routine, &job));
    assert!(flange.iter().any(|(code, _)| *code == Code::ChangeIgnored), "{flange:?}");
}

/// A base by number that no file gives matters to what moves in it alone.
#[test]
fn a_base_of_krl_that_is_replaced_before_anything_moves() {
    let base = "BAS(#BASE,1)\n$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}\n$BASE={X 100,Y 0,Z 0,A 0,B 0,C 0}\n";
    let program = krl(&format!("{base}LIN {{X 10,Y 0,Z 500,A 0,B 0,C 180}}"));
    assert_eq!(along(&program, 0), [(110.0, 100.0)]);
    krl_refused("BAS(#BASE,1)\nLIN {X 10,Y 0,Z 500,A 0,B 0,C 180}", "BASE_DATA[1] is in no file");
    let with = "BAS(#BASE,1)\nLIN {X 10,Y 0,Z 500,A 0,B 0,C 180} WITH $BASE={X 9,Y 0,Z 0,A 0,B 0,C 0}\n\
                LIN {X 10,Y 0,Z 500,A 0,B 0,C 180}";
    krl_refused(with, "BASE_DATA[1] is in no file");
}

#[test]
fn copies_and_parts_of_tool0_and_wobj0() {
    let heights = |body: &str| -> Vec<f64> {
        along(&abb(body, "", &settings()), 2).into_iter().map(|(z, _)| z).collect()
    };
    let to = "MoveL p2,v100,fine,t1\\WObj:=w1;";
    assert_eq!(heights(&format!("w1:=wobj0;\nw1.oframe.trans.z:=-300;\n{to}")), [500.0]);
    assert_eq!(
        heights(&format!("w1.uframe.trans.z:=-100;\nw1.oframe:=wobj0.oframe;\n{to}")),
        [700.0]
    );
    let tool = "t1:=tool0;\nt1.tframe.trans.z:=200;\nt1.tload.mass:=12;\nMoveL p2,v100,fine,t1;";
    let program = abb(tool, "", &settings());
    assert!((program.moves[1].tcp.translation.z - 0.2).abs() < 1e-12);
    assert_eq!(program.moves[1].stated.load.as_ref().map(|load| load.mass_kg), Some(12.0));
    // The job's tcp stands for tool0, also where a copy gets a load alone; so does its work object.
    let at = |x: f64| Some(nalgebra::Isometry3::translation(x, 0.0, 0.0));
    let job = Settings { tcp: at(0.03), work_object: at(0.5), ..settings() };
    let loaded = "t1:=tool0;\nt1.tload.mass:=12;\nw1:=wobj0;\nw1.oframe.trans.z:=-300;";
    let program = abb(&format!("{loaded}\nMoveL p2,v100,fine,t1\\WObj:=w1;"), "", &job);
    assert_eq!(program.moves[1].tcp, at(0.03).unwrap());
    assert_eq!((along(&program, 0)[0].0, along(&program, 2)[0].0), (1300.0, 500.0));
}

#[test]
fn data_of_other_files_that_the_program_sets() {
    let go = "MoveL p2,v100,fine,t1\\WObj:=wAct;";
    let job = Settings { work_object: Some(nalgebra::Isometry3::identity()), ..settings() };
    // As a whole they are what the program says.
    let known = abb(&format!("w1.oframe.trans.z:=-300;\nwAct:=w1;\n{go}"), "", &job);
    assert_eq!((along(&known, 2)[0].0, doubts(&known)), (500.0, vec![]));
    // Of a part that is set the rest is not known, and the job does not stand in.
    let part = abb(&format!("wAct:=w1;\nwAct.oframe.trans:=[0,0,-300];\n{go}"), "", &job);
    assert_eq!(doubts(&part), [(Code::ChangeIgnored, 11)]);
    assert_eq!(doubts(&abb(go, "", &job)), []);
    // Nor where a routine, a branch that the run decides or a trap may have set it.
    let set = "PROC setw(INOUT wobjdata w)\nw.oframe.trans.z:=-300;\nENDPROC";
    let trap = "TRAP tr\nwAct:=w1;\nENDTRAP";
    for (body, more) in [
        ("setw wAct;", set),
        ("IF di1=1 THEN\nwAct:=w1;\nENDIF", ""),
        ("CONNECT i1 WITH tr;\nwAct:=w1;", trap),
    ] {
        let program = abb(&format!("{body}\n{go}"), more, &job);
        let at = 9 + body.matches('\n').count() + 1;
        assert_eq!(doubts(&program), [(Code::ChangeIgnored, at)], "{body}: {:?}", program.warnings);
    }
}

/// VAR, PERS and INOUT parameters are other names of the caller's data.
#[test]
fn parameters_by_reference_are_other_names() {
    let layer = |kind: &str| {
        format!(
            "PROC layer({kind} num k)\nMoveL Offs(p2,0,0,-50*n),v100,fine,t1;\nn:=n+1;\nENDPROC"
        )
    };
    for kind in ["INOUT", "VAR"] {
        let program = abb("layer n;\nlayer n;", &layer(kind), &settings());
        assert_eq!(along(&program, 2).iter().map(|it| it.0).collect::<Vec<_>>(), [800.0, 750.0]);
    }
    let set = "PROC go(INOUT num k)\nk:=-100;\nMoveL Offs(p2,0,0,n),v100,fine,t1;\nENDPROC";
    assert_eq!(along(&abb("go n;", set, &settings()), 2)[0].0, 700.0);
    // By value the caller's stays.
    assert_eq!(along(&abb("go n;", &set.replace("INOUT ", ""), &settings()), 2)[0].0, 800.0);
    let inner = "PROC outer(INOUT num k)\ngo k;\nENDPROC\n";
    assert_eq!(along(&abb("outer n;", &format!("{inner}{set}"), &settings()), 2)[0].0, 700.0);
    let option = set.replace("go(INOUT", "go(\\INOUT");
    assert_eq!(along(&abb("go \\k:=n;", &option, &settings()), 2)[0].0, 700.0);
    let handed = format!("PROC outer(\\INOUT num k)\ngo \\k?k;\nENDPROC\n{option}");
    assert_eq!(along(&abb("outer \\k:=n;", &handed, &settings()), 2)[0].0, 700.0);
    // A datum with a spindle's name is that by any other.
    let spin = "PERS num nSpindleRpm:=0;\nPROC foo(INOUT num k)\nk:=90000;\nENDPROC";
    assert_eq!(doubts(&abb("foo nSpindleRpm;", spin, &settings())).len(), 1);
    let field =
        "PROC sink(INOUT pose f)\nf.trans.z:=-70;\nMoveL p2,v100,fine,t1\\WObj:=w1;\nENDPROC";
    assert_eq!(along(&abb("sink w1.oframe;", field, &settings()), 2)[0].0, 730.0);
}

#[test]
fn times_traps_and_half_turns() {
    let timed = abb("VelSet 50,5000;\nMoveL p2,v100\\T:=5,fine,t1;", "", &settings());
    assert_eq!(timed.moves[1].timing, Timing::Seconds(10.0));
    let connect = "CONNECT i1 WITH tr;\nMoveL p2,v100,fine,t1;";
    assert_eq!(doubts(&abb(connect, "", &settings())), [(Code::MotionLeftOut, 9)]);
    assert_eq!(doubts(&abb(connect, "TRAP tr\nTPWrite \"x\";\nENDTRAP", &settings())), []);

    let half = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI);
    let turned =
        (half * UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(0., 0., 1., 0.))).coords;
    let to = format!(
        "MoveL [[800,200,800],[{},{},{},{}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,t1;",
        turned.w, turned.x, turned.y, turned.z
    );
    assert_eq!(doubts(&abb(&to, "", &settings())), [(Code::AxisIgnored, 9)]);
    // Joints go the way that they go.
    assert_eq!(doubts(&abb(&to.replace("MoveL", "MoveJ"), "", &settings())), []);
}

#[test]
fn functions_and_operators_of_known_data() {
    let offs = |z: &str| {
        along(&abb(&format!("MoveL Offs(p2,0,0,{z}),v100,fine,t1;"), "", &settings()), 2)[0].0
    };
    assert_eq!(offs("Max(3,Min(9,7))"), 807.0);
    assert_eq!(offs("StrLen(StrPart(\"abcdef\",2,4))"), 804.0);
    assert_eq!(offs("DotProd([1,2,3],[4,5,6])"), 832.0);
    let cross = "n:=DotProd([1,0,0]*[0,1,0],[0,0,5]);\nMoveL Offs(p2,0,0,n),v100,fine,t1;";
    assert_eq!(along(&abb(cross, "", &settings()), 2)[0].0, 805.0);
    let turned =
        "VAR robtarget p3;\np3:=p2;\np3.rot:=p3.rot*OrientZYX(10,0,0);\nMoveL p3,v100,fine,t1;";
    let program = abb(turned, "", &settings());
    let [from, to] = [0, 1].map(|i| end(&program.moves[i]).1.rotation);
    assert!((from.angle_to(&to).to_degrees() - 10.0).abs() < 1e-6);
    let text = "VAR string s:=\"12\";\nVAR bool ok;\nok:=StrToVal(s,n);\nMoveL Offs(p2,0,0,StrLen(s)),v100,fine,t1;";
    assert_eq!(along(&abb(text, "", &settings()), 2)[0].0, 802.0);
    let array = "VAR num a{2,3};\nMoveL Offs(p2,0,0,Dim(a,2)),v100,fine,t1;";
    assert_eq!(along(&abb(array, "", &settings()), 2)[0].0, 803.0);
    let Target::Line(_) = &program.moves[1].to else { panic!("a line") };
}

#[test]
fn what_is_refused_says_why() {
    let found = read(
        b"MODULE m\nPROC main()\nmotion_A;\nENDPROC\nENDMODULE\n",
        Dialect::Rapid,
        &settings(),
    );
    let found = found.expect_err("nothing moves");
    assert!(
        at(&found[0]) == 3 && found[0].what.contains("'motion_A' is not in this file"),
        "{found:?}"
    );
    let ask = "FUNC bool Ask()\nIF di1=1 THEN\nRETURN TRUE;\nELSE\nRETURN FALSE;\nENDIF\nENDFUNC";
    let text = module("IF Ask() MoveL p2,v100,fine,t1;", ask);
    let found = read(text.as_bytes(), Dialect::Rapid, &settings()).expect_err("it asks");
    assert!(found.iter().all(|note| !note.what.contains("returns nothing")), "{found:?}");
    abb_refused("RAISE 10;", "", "outside an error handler");
}

/// With `\SDelay` an output keeps its old value for a while, so that the moves behind it may run at either.
#[test]
fn outputs_that_are_set_after_a_delay_are_doubts() {
    let by = SetBy { what: Setter::Signal("goS".to_owned()), per_unit: 1.0 };
    let job = Settings { spindle_from: Some(by), ..settings() };
    let go = "MoveL p2,v100,fine,t1;";
    let (old, new) = (Spindle::Turns(Some(3000.0)), Spindle::Turns(Some(9000.0)));
    let doubt = vec![(Code::SpindleCommand, 10)];
    let called = "PROC later(\\num t,num k)\nSetGO \\SDelay?t,goS,k;\nENDPROC";
    for (set, spindle, expected) in [
        ("SetGO goS,9000;", vec![old, new], vec![]),
        ("SetGO \\SDelay:=8,goS,9000;", vec![old], doubt.clone()),
        ("SetGO\\SDelay:=tWait,goS,9000;", vec![old], doubt.clone()),
        ("SetGO \\SDelay:=0,goS,9000;", vec![old, new], vec![]),
        ("SetGO \\SDelay:=n,goS,9000;", vec![old, new], vec![]),
        // Beside one that is read, on its line.
        ("SetGO goS,9000; SetGO \\SDelay:=8,goS,3000;", vec![old, new], doubt.clone()),
        ("later 9000;", vec![old, new], vec![]),
        ("later\\t:=8,9000;", vec![old], vec![(Code::SpindleCommand, 14)]),
        ("SetGO \\SDelay:=8,goElse,9000;", vec![old], vec![]),
    ] {
        let more = if set.starts_with("later") { called } else { "" };
        let program = abb(&format!("SetGO goS,3000;\n{set}\n{go}"), more, &job);
        let found: Vec<_> = program.spindle.iter().map(|it| it.spindle).collect();
        assert_eq!((found, doubts(&program)), (spindle, expected), "{set}: {:?}", program.warnings);
    }
    let by = SetBy { what: Setter::Signal("goT".to_owned()), per_unit: 1.0 };
    let job = Settings { tool_from: Some(by), ..settings() };
    let program = abb(&format!("SetGO \\SDelay:=8,goT,2;\n{go}"), "", &job);
    assert_eq!(doubts(&program), [(Code::ChangeIgnored, 9)]);
    // Of what decides about moves: set at once where the delay is zero.
    let decide = |set: &str| format!("{set}\nIF DOutput(do1)=1 MoveL p2,v100,fine,t1;");
    let at_once = abb(&decide("SetDO \\SDelay:=0,do1,1;"), "", &settings());
    assert_eq!(at_once.moves.len(), 2);
    abb_refused(&decide("SetDO \\SDelay:=1,do1,1;"), "", "decides about motion");
}

/// A new tool of RobotStudio has 1 kg at 1 mm: nobody has stated what it weighs.
#[test]
fn the_load_of_a_new_tool_counts_as_none() {
    let of_new = "[1,[0,0,1],[1,0,0,0],0,0,0]";
    assert!(DATA.contains(of_new));
    let go = "MoveL p2,v100,fine,t1;";
    let mass = |load: &str, body: &str| {
        let text = module(&format!("{body}{go}"), "").replace(of_new, load);
        let program = of(&text, Dialect::Rapid, &settings());
        let stated = |load: &&std::sync::Arc<detune::motion::Load>| !load.is_placeholder;
        let load = program.moves[1].stated.load.as_ref().filter(stated).map(|load| load.mass_kg);
        (load, doubts(&program))
    };
    assert_eq!(mass(of_new, ""), (None, vec![]));
    assert_eq!(mass("[-1,[0,0,1],[1,0,0,0],0,0,0]", ""), (None, vec![]));
    for stated in [
        "[1,[0,0,2],[1,0,0,0],0,0,0]",
        "[1,[0,0,1],[1,0,0,0],0.01,0,0]",
        "[1,[0,0,1],[0,1,0,0],0,0,0]",
    ] {
        assert_eq!(mass(stated, ""), (Some(1.0), vec![]), "{stated}");
    }
    assert_eq!(mass("[1.1,[0,0,1],[1,0,0,0],0,0,0]", "").0, Some(1.1));
    // A part that is gripped adds to a tool that nobody has weighed; the next cycle begins with it.
    let (load, found) = mass(of_new, "GripLoad [2,[0,0,1],[1,0,0,0],0,0,0];\n");
    assert_eq!((load, found.len()), (None, 2));
    let codes: Vec<Code> = found.iter().map(|(code, _)| *code).collect();
    assert!(codes.contains(&Code::ChangeIgnored) && codes.contains(&Code::MotionLeftOut));
}
