//! KUKA KRL and Fanuc TP: frames, partial positions, inline forms, registers; and robot programs
//! rewritten.

use detune::motion::{Sides, Target, Timing};
use detune::notes::{Code, Note};
use detune::path::Path;
use detune::program::{
    Assumed, Companion, Dialect, ExternalAxis, J3From, NewSpeed, Program, Rewrite, SetBy, Setter,
    Settings, Spindle, TipAt, read, rewrite,
};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::arms::six_axis_arm;

use super::support::{assert_ends, assert_pose, at, end, lines, module, pose, settings};

fn behind_the_first(program: &Program) -> Program {
    let mut rest = program.clone();
    rest.moves.remove(0);
    rest
}

fn krl(text: &str) -> Result<Program, Vec<Note>> {
    read(text.as_bytes(), Dialect::Krl, &settings())
}

const POCKET: &str = "&ACCESS RVP\n&REL 12\nDEF  pocket( )\n;FOLD INI\nDECL INT i\nBAS (#INITMOV,0 )\n\
;ENDFOLD (INI)\n$VEL.CP=0.2\n$TOOL={FRAME: X 0,Y 0,Z 150,A 0,B 0,C 0}\n\
$BASE={FRAME: X 900,Y 0,Z 400,A 90,B 0,C 0}\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0}\n\
BAS(#VEL_PTP,30)\nPTP {E6POS: X 10,Y 0,Z 50,A 0,B 90,C 180,S 2,T 10,E1 0} C_PTP\nLIN {Z -2} C_DIS\n\
$VEL.CP=0.01\nLIN {X 30}\nCIRC {X 40,Y 10},{X 30,Y 20}\nWAIT SEC 0.5\nFOR i=1 TO 2\n\
LIN_REL {Z 10}\nENDFOR\nCIRC {X 40,Y 30},{X 30,Y 40},CA 90\n$OUT[3]=TRUE\nEND\n";

/// The base turns (x, y) to (−y, x) and stands at (900, 0, 400); the tool is 150 mm long.
#[test]
fn a_milling_program_of_krl() {
    let program = krl(POCKET).unwrap();
    let half = 10.0 * std::f64::consts::FRAC_1_SQRT_2;
    assert_ends(
        &behind_the_first(&program),
        &[
            ('T', [900.0, 10.0, 450.0]),
            ('L', [900.0, 10.0, 398.0]),
            ('L', [900.0, 30.0, 398.0]),
            ('A', [880.0, 30.0, 398.0]),
            ('T', [880.0, 30.0, 398.0]),
            ('L', [880.0, 30.0, 408.0]),
            ('L', [880.0, 30.0, 418.0]),
            // From (30, 20) about (30, 30): the end is (40, 30), whatever the second point.
            ('A', [870.0, 40.0, 418.0]),
        ],
    );
    let Target::Arc { via, .. } = &program.moves[8].to else { panic!("CIRC is an arc") };
    let expected = Vector3::new(900.0 - (30.0 - half), 30.0 + half, 418.0);
    assert!((via.translation.vector * 1e3 - expected).norm() < 1e-6, "{via}");
    // Ry(90)·Rx(180) takes z to −x, and the base that to −y.
    let z = end(&program.moves[1]).1.rotation * Vector3::z();
    assert!((z + Vector3::y()).norm() < 1e-9, "{z}");
    assert_pose(&program.moves[1].tcp, &pose([0.0, 0.0, 150.0], [1.0, 0.0, 0.0, 0.0]));
    assert_eq!(lines(&program), [11, 13, 14, 16, 17, 18, 20, 20, 22]);
    let Target::Joints(home) = &program.moves[0].to else { panic!("PTP goes to joints") };
    let degrees: Vec<f64> = home.iter().map(|rad| rad.to_degrees().round()).collect();
    assert_eq!(degrees, [0.0, -90.0, 90.0, 0.0, 90.0, 0.0]);
    let timings: Vec<Timing> = program.moves.iter().map(|each| each.timing).collect();
    assert_eq!((timings[1], timings[5]), (Timing::Joints(0.3), Timing::Seconds(0.5)));
    let feeds: Vec<f64> = program.moves[2..5].iter().map(|each| each.feed_m_per_s).collect();
    assert_eq!(feeds, [0.2, 0.01, 0.01]);
}

const DATA: &str = "DEFDAT P PUBLIC\nDECL E6POS XP1={X 1,Y 2,Z 3,A 0,B 0,C 0,S 2,T 35,E1 0}\n\
DECL E6POS XP2={X 11,Y 2,Z 3,A 0,B 0,C 0,S 2,T 35,E1 0}\n\
DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,POINT2[] \" \"}\n\
DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 100.0}\nENDDAT\n";

const INLINE: &str = "DEF p()\n;FOLD PTP P1 Vel=50 % PDAT1 Tool[1] Base[2];%{PE}%R 5.4\n\
$BWDSTART=FALSE\nPDAT_ACT=PPDAT1\nFDAT_ACT=FP1\nBAS(#PTP_PARAMS,50)\nPTP XP1\n;ENDFOLD\n\
FDAT_ACT=FP1\nBAS(#CP_PARAMS,0.5)\nLIN XP2 C_DIS C_DIS\nSPLINE WITH $VEL.CP=0.02\nSLIN XP1\n\
ENDSPLINE\nSLIN XP2 WITH $VEL=SVEL_CP(0.008,,LCPDAT1), $TOOL=STOOL2(FP1), $BASE=SBASE(FP1.BASE_NO), \
$ACC=SACC_CP(LCPDAT1), $APO=SAPO(LCPDAT1)\nEND\n";

#[test]
fn inline_forms_take_frames_and_data_from_the_cell() {
    let frame = |x: f64, z: f64| pose([x, 0.0, z], [1.0, 0.0, 0.0, 0.0]);
    let data = Companion::new("p.dat".to_owned(), DATA.as_bytes()).unwrap();
    let mut job = Settings { companions: vec![data], ..settings() };
    let refused = read(INLINE.as_bytes(), Dialect::Krl, &job).unwrap_err();
    assert_eq!(at(&refused[0]), 6, "{refused:?}");
    assert!(refused[0].what.contains("tool_frames: {1: …}"), "{refused:?}");
    job.tool_frames.insert(1, frame(0.0, 200.0));
    job.base_frames.insert(2, frame(500.0, 0.0));
    let program = read(INLINE.as_bytes(), Dialect::Krl, &job).unwrap();
    assert_ends(
        &program,
        &[
            ('T', [501.0, 2.0, 3.0]),
            ('L', [511.0, 2.0, 3.0]),
            ('L', [501.0, 2.0, 3.0]),
            ('L', [511.0, 2.0, 3.0]),
        ],
    );
    let feeds: Vec<f64> = program.moves.iter().map(|each| each.feed_m_per_s).collect();
    assert_eq!(feeds, [0.5, 0.5, 0.02, 0.008]);
    for each in &program.moves {
        assert_pose(&each.tcp, &frame(0.0, 200.0));
    }
    // $CONFIG.DAT instead of the job.
    let config = "DEFDAT $CONFIG\nTOOL_DATA[1]={X 0.0,Y 0.0,Z 200.0,A 0.0,B 0.0,C 0.0}\n\
                  LOAD_DATA[1]={M 5.5,CM {X 0.0,Y 0.0,Z 80.0,A 0.0,B 0.0,C 0.0},J {X 0.01,Y 0.01,Z 0.02}}\n\
                  BASE_DATA[2]={X 500.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}\nENDDAT\n";
    let config = Companion::new("config.dat".to_owned(), config.as_bytes()).unwrap();
    job.companions.push(config);
    (job.tool_frames, job.base_frames) = Default::default();
    let again = read(INLINE.as_bytes(), Dialect::Krl, &job).unwrap();
    assert!(again.moves.iter().zip(&program.moves).all(|(a, b)| a.to == b.to && a.tcp == b.tcp));
    let load = again.moves[1].stated.load.clone().unwrap();
    assert_eq!((load.mass_kg, load.com_m.z, load.inertia_kgm2[(2, 2)]), (5.5, 0.08, 0.02));
}

#[test]
fn krl_that_is_not_understood_is_refused_with_its_line() {
    for (statement, said) in [
        ("LIN XP9", "'xp9' is declared in no file"),
        ("LIN {X 1}", "position before is known only at run time"),
        ("PTP {A1 0}", "A2 is not known"),
        ("IF $IN[1] THEN\nPTP XP1\nENDIF", "IF decides about motion at run time"),
        ("GOTO again", "there is no label 'again'"),
        ("MOVE_TO_START()", "'move_to_start' is in no file that is read and moves by its name"),
        ("GLUE({X 1,Y 2,Z 3})", "'glue' is in no file that is read and is given a position"),
        ("$BASE=EK($ROBROOT,#EASYS,$BASE)", "lays the base on an external kinematic"),
        ("$IPO_MODE=#TCP", "stationary tool"),
        ("LIN {X 1 Y 2}", "expected '}'"),
        ("$VEL.CP=0", "must be positive"),
        ("@", "'@' is not understood"),
        (
            "LIN {X 0,Y 0,Z 0,A 0,B 0,C 0,E1 5}\nLIN {X 1,E1 9}",
            "external axis e1 moves from 5 to 9",
        ),
    ] {
        let found = krl(&format!("DEF a()\n\n{statement}\nEND\n")).unwrap_err();
        assert!((3..=4).contains(&at(&found[0])), "{statement}: {found:?}");
        assert!(found[0].what.contains(said), "{statement}: {found:?}");
    }
    let mut job = settings();
    job.assume.insert("$in[1]".to_owned(), Assumed::Truth(true));
    let text = "DEF a()\nIF $IN[1] THEN\nPTP {A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}\nENDIF\nEND\n";
    assert_eq!(read(text.as_bytes(), Dialect::Krl, &job).unwrap().moves.len(), 1);
}

const TP: &str = "/PROG  CUT\n/ATTR\nOWNER = MNEDITOR;\n/MN\n   1:  UFRAME_NUM=1 ;\n   2:  UTOOL_NUM=1 ;\n\
   3:  !SPINDLE 9000 ;\n   4:J P[1:home] 20% FINE    ;\n   5:L P[2] 100mm/sec CNT50 ACC80    ;\n   6:  DO[1]=ON ;\n\
   7:  WAIT   1.50(sec) ;\n   8:L P[3] 60cm/min FINE COORD PTH    ;\n   9:C P[4]\n    :  P[5] 10mm/sec FINE    ;\n\
  10:  FOR R[1]=1 TO 2 ;\n  11:L P[3] R[2]mm/sec FINE    ;\n  12:  ENDFOR ;\n  13:L P[2] 4sec FINE    ;\n/POS\n\
P[1:\"home\"]{\n   GP1:\n\tUF : 1, UT : 1,\n\tJ1=    10.000 deg,\tJ2=    20.000 deg,\tJ3=    30.000 deg,\n\
\tJ4= 0 deg, J5= -90 deg, J6= 0 deg\n};\n";

fn tp_pose(number: u32, x: f64, y: f64, group_2: f64) -> String {
    format!(
        "P[{number}] {{\n   GP1:\n UF : 1, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n X = {x} mm, Y = {y} mm, Z = 50.000 \
         mm,\n W = 180.000 deg, P = 0.000 deg, R = 90.000 deg\n   GP2:\n UF : 1, UT : 1,\n J1= {group_2} deg\n}};\n"
    )
}

fn tp(group_2: f64) -> String {
    let points = [(2, 0.0, 0.0), (3, 10.0, 0.0), (4, 20.0, 10.0), (5, 10.0, 20.0)];
    let points = points.map(|(n, x, y)| tp_pose(n, x, y, if n == 5 { group_2 } else { 0.0 }));
    format!("{TP}{}/END\n", points.concat())
}

fn tp_settings() -> Settings {
    let mut job = settings();
    job.base_frames.insert(1, pose([900.0, 0.0, 400.0], [1.0, 0.0, 0.0, 0.0]));
    job.tool_frames.insert(1, pose([0.0, 0.0, 150.0], [1.0, 0.0, 0.0, 0.0]));
    job.assume.insert("r[2]".to_owned(), Assumed::Number(25.0));
    job.j3_from = Some(J3From::Horizontal);
    job.spindle_from = Some(SetBy { what: Setter::Comment("SPINDLE".to_owned()), per_unit: 1.0 });
    job
}

#[test]
fn a_tp_program_with_frames_of_the_job() {
    let program = read(tp(0.0).as_bytes(), Dialect::Fanuc, &tp_settings()).unwrap();
    let Target::Joints(home) = &program.moves[0].to else { panic!("J1 to J6 are joints") };
    let degrees: Vec<f64> = home.iter().map(|rad| rad.to_degrees().round()).collect();
    // J3 counts from the horizontal.
    assert_eq!(degrees, [10.0, 20.0, 50.0, 0.0, -90.0, 0.0]);
    assert_ends(
        &behind_the_first(&program),
        &[
            ('L', [900.0, 0.0, 450.0]),
            ('T', [900.0, 0.0, 450.0]),
            ('L', [910.0, 0.0, 450.0]),
            ('A', [910.0, 20.0, 450.0]),
            ('L', [910.0, 0.0, 450.0]),
            ('L', [910.0, 0.0, 450.0]),
            ('L', [900.0, 0.0, 450.0]),
        ],
    );
    // Rz(90)·Rx(180): z down, x along y.
    let turned = end(&program.moves[1]).1.rotation;
    assert!((turned * Vector3::z() + Vector3::z()).norm() < 1e-9);
    assert!((turned * Vector3::x() - Vector3::y()).norm() < 1e-9);
    assert_eq!(program.moves[0].timing, Timing::Joints(0.2));
    assert_eq!(program.moves[2].timing, Timing::Seconds(1.5));
    assert_eq!(program.moves[7].timing, Timing::Seconds(4.0));
    let feeds: Vec<f64> = program.moves.iter().map(|each| each.feed_m_per_s).collect();
    assert_eq!(feeds[1..7], [0.1, 0.1, 0.01, 0.01, 0.025, 0.025]);
    assert_eq!(lines(&program), [8, 9, 11, 12, 13, 16, 16, 18]);
    assert_eq!(program.spindle[0].spindle, Spindle::Turns(Some(9000.0)));
    // A positioner that moves is refused, and so is a frame that nobody gives.
    let found = read(tp(15.0).as_bytes(), Dialect::Fanuc, &tp_settings()).unwrap_err();
    assert!(found[0].what.contains("gp2_j1 moves from 0 to 15"), "{found:?}");
    let found = read(tp(0.0).as_bytes(), Dialect::Fanuc, &settings()).unwrap_err();
    assert!(found[0].what.contains("tool_frames: {1: …}"), "{found:?}");
}

/// Of the arm of [`six_axis_arm`], frame by frame.
fn tip(q: &[f64]) -> Isometry3<f64> {
    let turned = |axis: Vector3<f64>, [x, y, z]: [f64; 3], q: f64| {
        Isometry3::from_parts([x, y, z].into(), UnitQuaternion::from_scaled_axis(axis * q))
    };
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    turned(z, [0.0; 3], q[0])
        * turned(y, [0.15, 0.0, 0.4865], q[1])
        * turned(y, [0.0, 0.0, 0.7], q[2])
        * turned(x, [0.3, 0.0, 0.0], q[3])
        * turned(y, [0.3, 0.0, 0.0], q[4])
        * turned(x, [0.065, 0.0, 0.0], q[5])
}

/// A line to a position in joints goes where the robot has the tool there, and ends in these joints.
#[test]
fn tp_lines_and_arcs_to_positions_in_joints() {
    let robot = six_axis_arm(true);
    let job = Settings {
        j3_from: Some(J3From::UpperArm),
        tip_at: Some(TipAt::new(|q| Some(tip(q)))),
        ..tp_settings()
    };
    let points = |all: &[[f64; 6]]| -> String {
        let point = |(i, q): (usize, &[f64; 6])| {
            let joints: Vec<String> =
                q.iter().enumerate().map(|(k, q)| format!("J{}= {q} deg", k + 1)).collect();
            format!("P[{}]{{\n GP1:\n UF : 1, UT : 1,\n {}\n}};\n", i + 1, joints.join(", "))
        };
        all.iter().enumerate().map(point).collect()
    };
    let run = |statements: &str, all: &[[f64; 6]]| {
        let text = format!(
            "/PROG T\n/MN\nUFRAME_NUM=1 ;\nUTOOL_NUM=1 ;\nJ P[1] 20% FINE ;\n{statements}/POS\n{}/END\n",
            points(all)
        );
        read(text.as_bytes(), Dialect::Fanuc, &job).unwrap().moves
    };
    let rad = |q: &[f64; 6]| q.map(f64::to_radians);
    let tool = |q: &[f64; 6]| tip(&rad(q)) * pose([0.0, 0.0, 150.0], [1.0, 0.0, 0.0, 0.0]);
    let (a, b) = ([5.0, 20.0, 10.0, 3.0, 40.0, -8.0], [15.0, 30.0, 2.0, 9.0, 50.0, 4.0]);
    let line = "L P[2] 100mm/sec FINE ;\n";
    let moves = run(line, &[a, b]);
    let Target::Line(to) = moves[1].to else { panic!("{moves:?}") };
    assert!((to.inverse() * tool(&b)).to_homogeneous().relative_eq(
        &nalgebra::Matrix4::identity(),
        1e-12,
        0.0
    ));
    let path = Path::plan(&robot, &moves, None).unwrap();
    let way = (tool(&b).translation.vector - tool(&a).translation.vector).norm();
    assert!((path.duration_s() - way / 0.1).abs() < 1e-9);
    let mut q = [0.0; 6];
    path.reader().at(path.duration_s(), &mut q).unwrap();
    assert!(q.iter().zip(rad(&b)).all(|(q, b)| (q - b).abs() < 1e-6), "{q:?}");
    // The same place with the wrist turned over: the arm cannot end so on a line from here.
    let over = [b[0], b[1], b[2], b[3] + 180.0, -b[4], b[5] - 180.0];
    let refused = Path::plan(&robot, &run(line, &[a, over]), None).unwrap_err();
    assert!(refused[0].what.contains("J1 to J6 at 15.0°"), "{refused:?}");
    // Another elbow is less than a quadrant off: the forearm of 0.6 m bends 20° off the upper arm of
    // 0.7 m, to one side and to the other.
    let (from, b): (_, [f64; 6]) =
        ([5.0, 20.0, -65.0, 0.0, 40.0, -8.0], [15.0, 30.0, -70.0, 0.0, 50.0, 4.0]);
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let upper = 30.0 + 2.0 * (0.6 * sin).atan2(0.7 + 0.6 * cos).to_degrees();
    let over = [15.0, upper, -110.0, 0.0, 30.0 - 70.0 + 50.0 - (upper - 110.0), 4.0];
    assert!((tool(&b).inverse() * tool(&over)).translation.vector.norm() < 1e-12);
    Path::plan(&robot, &run(line, &[from, b]), None).unwrap();
    let refused = Path::plan(&robot, &run(line, &[from, over]), None).unwrap_err();
    assert!(refused[0].what.contains("the arm comes with joint 'joint_2' at"), "{refused:?}");
    // On an arc likewise.
    let b = [15.0, 30.0, 2.0, 9.0, 50.0, 4.0];
    let via = [10.0, 26.0, 6.0, 3.0, 40.0, -8.0];
    let moves = run("C P[2] P[3] 100mm/sec FINE ;\n", &[a, via, b]);
    let Target::Arc { via: on, end, .. } = moves[1].to else { panic!("{moves:?}") };
    for (found, expected) in [(on, tool(&via)), (end, tool(&b))] {
        assert!((found.translation.vector - expected.translation.vector).norm() < 1e-12);
    }
}

#[test]
fn tp_that_is_not_understood_is_refused_with_its_line() {
    for (statement, said) in [
        ("L P[9] 5mm/sec FINE", "P[9] is not in /POS"),
        ("A PR[9] 5mm/sec FINE", "known only at run time"),
        ("L P[2] 5mm/sec FINE Offset,PR[1]", "shifts the target"),
        ("L P[2] 5mm/sec FINE HOP", "'HOP' behind the target"),
        ("L P[1] 5mm/sec FINE", "a line or arc to joint positions"),
        ("IF DI[1]=ON,JMP LBL[1]", "IF decides about motion"),
        ("UFRAME[1]=PR[1]", "which is not known as a pose"),
        ("DANCE", "'DANCE' is not understood"),
        ("S P[2] 5mm/sec FINE", "S (spline)"),
    ] {
        let text = tp(0.0).replace("3:  !SPINDLE 9000 ;", &format!("3:  {statement} ;"));
        let found = read(text.as_bytes(), Dialect::Fanuc, &tp_settings()).unwrap_err();
        assert_eq!(at(&found[0]), 7, "{statement}: {found:?}");
        assert!(found[0].what.contains(said), "{statement}: {found:?}");
    }
    let cut = tp(0.0);
    let found =
        read(&cut.as_bytes()[..cut.len() - 40], Dialect::Fanuc, &tp_settings()).unwrap_err();
    assert!(found.iter().any(|note| note.what.contains("is the file whole?")), "{found:?}");
}

fn rewritten(text: &str, dialect: Dialect, job: &Settings) -> Result<String, String> {
    let speeds = vec![NewSpeed { end: usize::MAX, rpm: 11_250.0, job_rpm: None }];
    let to = Rewrite { speeds, keeps_chip_load: true };
    let found = rewrite(text.as_bytes(), dialect, job, &to);
    found.map(|out| String::from_utf8(out.bytes).unwrap()).map_err(|note| note.what)
}

/// Speeds by 5/4, feeds with them, every other byte as it was.
#[test]
fn robot_programs_are_rewritten_where_they_state_speeds() {
    let text = tp(0.0).replace("R[2]mm/sec", "12mm/sec");
    let expected = text
        .replace("!SPINDLE 9000", "!SPINDLE 11250")
        .replace("100mm/sec", "125mm/sec")
        .replace("60cm/min", "75cm/min")
        .replace("10mm/sec FINE", "12.5mm/sec FINE")
        .replace(" 12mm/sec", " 15mm/sec")
        .replace("4sec", "3.2sec");
    assert_eq!(rewritten(&text, Dialect::Fanuc, &tp_settings()).unwrap(), expected);

    // An output, 90 to the count, which is whole; set under a condition of the run, its speed is not
    // known.
    let mut job = tp_settings();
    let what = Setter::Signal("AO[1]".to_owned());
    job.spindle_from = Some(SetBy { what: what.clone(), per_unit: 90.0 });
    let [of_output, expected] = [(text, "AO[1]=100 "), (expected, "AO[1]=125 ")]
        .map(|(text, set)| text.replace("!SPINDLE 9000 ", set).replace("!SPINDLE 11250 ", set));
    assert_eq!(rewritten(&of_output, Dialect::Fanuc, &job).unwrap(), expected);
    let by_100 = Settings { spindle_from: Some(SetBy { what, per_unit: 100.0 }), ..job.clone() };
    let refused = rewritten(&of_output, Dialect::Fanuc, &by_100).unwrap_err();
    assert!(refused.contains("11300 rpm, not 11250"), "{refused}");
    let decided = of_output.replace("AO[1]=100", "IF DI[1]=ON,AO[1]=100");
    let found = read(decided.as_bytes(), Dialect::Fanuc, &job).unwrap();
    assert_eq!(found.spindle[0].spindle, Spindle::Turns(None));
    assert!(found.warnings.iter().any(|note| note.what.contains("only at run time")));

    let mut job = settings();
    job.spindle_from =
        Some(SetBy { what: Setter::Procedure("SPINDEL".to_owned(), 2), per_unit: 1.0 });
    let text = POCKET.replace("$OUT[3]=TRUE\n", "").replace(";ENDFOLD (INI)", "SPINDEL(1, 9000)");
    let expected = text
        .replace("(1, 9000)", "(1, 11250)")
        .replace("$VEL.CP=0.2", "$VEL.CP=0.25")
        .replace("$VEL.CP=0.01", "$VEL.CP=0.0125");
    assert_eq!(rewritten(&text, Dialect::Krl, &job).unwrap(), expected);

    job.spindle_from =
        Some(SetBy { what: Setter::Signal("aoSpindle".to_owned()), per_unit: 1500.0 });
    let text = module(
        "SetAO aoSpindle, nVolt;\nMoveL p,v5,fine,tool0;\nMoveL Offs(p,9,0,0),v100,fine,tool0;\n\
         MoveL p,vCut,fine,tool0;\nMoveL Offs(p,9,0,0),v5\\V:=8,fine,tool0;\n\
         MoveL p,[40,500,5000,1000],fine,tool0;\nMoveL Offs(p,9,0,0),v100\\T:=2,fine,tool0;",
    )
    .replace("PROC main", "CONST num nVolt:=6; CONST speeddata vCut:=[10,500,5000,1000];PROC main");
    let expected = text
        .replace("nVolt:=6", "nVolt:=7.5")
        .replace("vCut:=[10,", "vCut:=[12.5,")
        .replace("MoveL p,v5,", "MoveL p,v5\\V:=6.25,")
        .replace("v100,fine", "v100\\V:=125,fine")
        .replace("\\V:=8", "\\V:=10")
        .replace("[40,500", "[50,500")
        .replace("\\T:=2", "\\T:=1.6");
    assert_eq!(rewritten(&text, Dialect::Rapid, &job).unwrap(), expected);
}

#[test]
fn rapid_over_several_modules_with_arguments_and_assumptions() {
    let main = "MODULE a\nPROC cut(num deep, bool twice)\nMoveL Offs(pElse,0,0,-deep),v5,fine,tool0;\n\
                IF twice AND NOT bDone THEN\n  Again;\nENDIF\nIF DInput(di_more)=1 OR di_more=high Again;\n\
                ENDPROC\nENDMODULE\n";
    let other = "MODULE b\nCONST robtarget pElse:=[[.1,-.5,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n\
                 PROC Again()\nMoveL pElse,v5,fine,tool0;\nENDPROC\nENDMODULE\n";
    let mut job = Settings {
        procedure: Some("cut".to_owned()),
        arguments: vec!["2.5".to_owned(), "TRUE".to_owned()],
        companions: vec![Companion::new("b.mod".to_owned(), other.as_bytes()).unwrap()],
        ..settings()
    };
    let found = read(main.as_bytes(), Dialect::Rapid, &job).unwrap_err();
    assert_eq!(at(&found[0]), 4, "{found:?}");
    assert!(found[0].what.contains("assume:"), "{found:?}");
    job.assume.insert("bdone".to_owned(), Assumed::Truth(false));
    job.assume.insert("di_more".to_owned(), Assumed::Truth(true));
    let program = read(main.as_bytes(), Dialect::Rapid, &job).unwrap();
    let point = [0.1, -0.5, 3.0];
    assert_ends(&program, &[('L', [0.1, -0.5, 0.5]), ('L', point), ('L', point)]);
    // Moves of the other module count as those of the line that calls them.
    assert_eq!(lines(&program), [3, 5, 7]);
    job.arguments.pop();
    let found = read(main.as_bytes(), Dialect::Rapid, &job).unwrap_err();
    assert!(found[0].what.contains("takes deep, twice"), "{found:?}");
}

#[test]
fn external_axes_are_joints_where_the_job_says_so() {
    let mut job = Settings { joint_count: 7, ..settings() };
    let rail = ExternalAxis { joint: 0, slides: true };
    job.external_axes.insert("eax_a".to_owned(), rail);
    let text = module(
        "MoveAbsJ [[10,0,0,0,90,0],[1500,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;\n\
         MoveL [[1,2,3],[1,0,0,0],[0,0,0,0],[2500,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;",
    );
    let program = read(text.as_bytes(), Dialect::Rapid, &job).unwrap();
    let Target::Joints(q) = &program.moves[0].to else { panic!("MoveAbsJ goes to joints") };
    assert_eq!((q.len(), q[0]), (7, 1.5));
    assert!(
        (q[1] - 10_f64.to_radians()).abs() < 1e-12 && (q[5] - 90_f64.to_radians()).abs() < 1e-12
    );
    assert_eq!(program.moves[1].stated.external, [(0, 2.5)]);
}

fn tp_program(statements: &str, positions: &str, job: &Settings) -> Result<Program, Vec<Note>> {
    let text = format!("/PROG A\n/MN\n{statements}/POS\n{positions}/END\n");
    read(text.as_bytes(), Dialect::Fanuc, job)
}

fn tp_at(number: u32, frame: &str, config: &str) -> String {
    format!(
        "P[{number}]{{\n GP1:\n UF : {frame}, UT : 1, CONFIG : '{config}',\n X = {number} mm, \
         Y = 0 mm, Z = 0 mm, W = 0 deg, P = 0 deg, R = 0 deg\n}};\n"
    )
}

/// ros-industrial/fanuc, issue 186: the pendant shows J3 with the part of J2 in it on most arms.
#[test]
fn j3_is_counted_as_the_job_says() {
    let positions = "P[1]{\n GP1:\n UF : 0, UT : 1,\n J1= 0 deg, J2= 20 deg, J3= 30 deg,\n J4= 0 \
                     deg, J5= 0 deg, J6= 0 deg\n};\n";
    let mut job = tp_settings();
    for (from, third) in [(J3From::Horizontal, 50.0), (J3From::UpperArm, 30.0)] {
        job.j3_from = Some(from);
        let program = tp_program("J P[1] 20% FINE ;\n", positions, &job).unwrap();
        let Target::Joints(q) = &program.moves[0].to else { panic!("joints") };
        assert!((q[2].to_degrees() - third).abs() < 1e-9, "{from:?}");
    }
    job.j3_from = None;
    let program = tp_program("J P[1] 20% FINE ;\n", positions, &job).unwrap();
    let Target::Joints(q) = &program.moves[0].to else { panic!("joints") };
    assert!((q[2].to_degrees() - 30.0).abs() < 1e-9);
    let told = |note: &Note| note.code == Code::UnitAssumed && note.what.contains("j3_from");
    assert!(program.warnings.iter().any(told), "{:?}", program.warnings);
}

#[test]
fn frame_0_is_the_world_and_an_arm_that_turns_over_is_refused() {
    let mut job = tp_settings();
    job.work_object = Some(pose([900.0, 0.0, 400.0], [1.0, 0.0, 0.0, 0.0]));
    let nut = "N U T, 0, 0, 0";
    let both = [tp_at(1, "0", nut), tp_at(2, "F", nut)].concat();
    let program =
        tp_program("L P[1] 9mm/sec FINE ;\nL P[2] 9mm/sec FINE ;\n", &both, &job).unwrap();
    assert_ends(&program, &[('L', [1.0, 0.0, 0.0]), ('L', [902.0, 0.0, 400.0])]);
    let told = |said: &str| program.warnings.iter().any(|warning| warning.what.contains(said));
    assert!(told("UFRAME 0 is the robot's base frame") && told("CONFIG 'N U T' is not compared"));

    let positions = [tp_at(1, "1", nut), tp_at(2, "1", "F U T, 0, 0, 1")].concat();
    let turned = tp_program("J P[1] 9% FINE ;\nJ P[2] 9% FINE ;\n", &positions, &job).unwrap_err();
    assert!(at(&turned[0]) == 4 && turned[0].what.contains("to 'F U T'"), "{turned:?}");
}

/// The letters of CONFIG name shoulder, elbow and wrist for the path, whatever the turn numbers are and however the
/// arm gets there; an increment has those that hold, and a position in joints has none.
#[test]
fn the_letters_of_config_name_the_arm_configuration() {
    let named = |config: &str, motion: &str| -> Vec<Option<Sides>> {
        let joints = "P[3]{\n GP1:\n UF : 1, UT : 1,\n J1= 0 deg, J2= 0 deg, J3= 0 deg, J4= 0 deg, J5= 9 deg, J6= 0 \
                      deg\n};\n";
        let first = tp_at(1, "1", "N U T, 0, 0, 0");
        let positions = [&first, &tp_at(2, "1", config), joints].concat();
        let statements =
            format!("J P[1] 9% FINE ;\n{motion} ;\nJ P[3] 9% FINE ;\nJ P[2] 9% FINE ;\n");
        let program = tp_program(&statements, &positions, &tp_settings()).unwrap();
        let asked = program.moves.iter().map(|each| each.stated.configuration.as_ref());
        asked.map(|asked| asked?.sides.clone()).collect()
    };
    let sides = |name: &str, as_at_zero: bool| {
        Some(Sides { name: name.to_owned(), as_at_zero: [Some(as_at_zero); 2] })
    };
    let all = |last: &str, as_at_zero: bool| {
        let nut = sides("N U T", true);
        [nut.clone(), nut, None, sides(last, as_at_zero)]
    };
    for (config, motion) in [
        ("N U T, 0, 0, 0", "J P[2] 9% FINE"),
        ("N U T, 1, 0, 0", "J P[2] 9% FINE"),
        ("N U T, 0, 0, 0", "L P[2] 9mm/sec FINE"),
        ("N U T, 0, 0, 0", "J P[2] 9% FINE INC"),
    ] {
        assert_eq!(named(config, motion), all("N U T", true), "{config} {motion}");
    }
    assert_eq!(named("F D B, 0, 0, 0", "J P[2] 9% FINE INC"), all("F D B", false));
}

#[test]
fn a_payload_that_changes_is_a_doubt() {
    let job = tp_settings();
    let positions = tp_at(1, "1", "N U T, 0, 0, 0");
    let doubts = |statements: &str| -> Vec<usize> {
        let program = tp_program(statements, &positions, &job).unwrap();
        program.warnings.iter().filter(|w| w.code == Code::ChangeIgnored).map(at).collect()
    };
    let moves = "L P[1] 9mm/sec FINE ;\n";
    assert!(doubts(&format!("PAYLOAD[2] ;\n{moves}PAYLOAD[2] ;\n")).is_empty());
    assert_eq!(doubts(&format!("PAYLOAD[2] ;\n{moves}PAYLOAD[1:part] ;\n")), [5]);
    assert_eq!(doubts(&format!("{moves}PAYLOAD[2] ;\n")), [4]);
}
