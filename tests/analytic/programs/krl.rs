//! KUKA KRL: what the basic package (bas.src of KSS) makes of inline forms, frames by number and by component, what
//! types of positions lose, where the robot is behind joints, and what the job gives of data and functions.

use detune::motion::Timing;
use detune::notes::{Class, Code, Note};
use detune::program::{Assumed, Companion, Dialect, Program, Settings, TipAt, read};
use nalgebra::Isometry3;

use super::support::{at, end, pose, settings};

type Read = Result<Program, Vec<Note>>;

const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

const START: &str = "PTP {X 0,Y 0,Z 500,A 0,B 0,C 180}";

/// Statements from line 3 on.
fn with(body: &str, job: &Settings) -> Read {
    read(format!("DEF p()\n$VEL.CP=0.1\n{body}\nEND\n").as_bytes(), Dialect::Krl, job)
}

fn krl(body: &str) -> Program {
    with(body, &settings()).unwrap_or_else(|found| panic!("{body}: {found:?}"))
}

/// With a data list that all see.
fn listed(data: &str) -> Settings {
    let text = format!("DEFDAT $CONFIG PUBLIC\n{data}\nENDDAT\n");
    Settings { companions: vec![Companion { name: "config.dat".to_owned(), text }], ..settings() }
}

fn assuming(name: &str, value: f64) -> Settings {
    Settings { assume: [(name.to_owned(), Assumed::Number(value))].into(), ..settings() }
}

/// The job's work object lies at x = 700 mm.
fn placed() -> Settings {
    Settings { work_object: Some(pose([700.0, 0.0, 0.0], UPRIGHT)), ..settings() }
}

fn doubts(program: &Program) -> Vec<(Code, usize)> {
    let told = program.warnings.iter().filter(|note| note.code.class() == Class::Doubt);
    told.map(|note| (note.code, at(note))).collect()
}

/// X at the end of each move, mm.
fn x(program: &Program) -> Vec<f64> {
    let of = |each| (end(each).1.translation.x * 1e9).round() / 1e6;
    program.moves.iter().map(of).collect()
}

#[track_caller]
fn refused(found: Read, said: &str) {
    let found = found.expect_err(said);
    assert!(found.iter().any(|note| note.what.contains(said)), "{said}: {found:?}");
}

/// By how much the last move turns the tool from the first, degrees.
fn turned(program: &Program) -> f64 {
    let [first, last] = [program.moves.first(), program.moves.last()].map(|it| end(it.unwrap()).1);
    first.rotation.angle_to(&last.rotation).to_degrees().round()
}

/// CP_DAT: $ORI_TYPE=LDAT_ACT.ORI_TYP, or #VAR where that is not set, and $CIRC_TYPE likewise.
#[test]
fn forms_say_how_the_tool_turns() {
    const LINE: &str = "LIN {X 100,A 40}";
    for (form, expected, is_doubt) in [
        ("{VEL 0.1,ORI_TYP #CONSTANT,CIRC_TYP #BASE}", 0.0, false),
        ("{VEL 0.1,ORI_TYP #VAR,CIRC_TYP #BASE}", 40.0, false),
        ("{VEL 0.1}", 40.0, false),
        ("{VEL 0.1,ORI_TYP #JOINT}", 40.0, true),
    ] {
        for bas in ["BAS(#CP_PARAMS,0.25)", "BAS(#CP_DAT)"] {
            let before = ["#VAR", "#CONSTANT"][usize::from(expected > 0.0)];
            let set = format!("{START}\n$ORI_TYPE={before}\nLDAT_ACT={form}\n{bas}");
            let program = krl(&format!("{set}\n{LINE}"));
            let told = if is_doubt { vec![(Code::AxisIgnored, 7)] } else { vec![] };
            assert_eq!((turned(&program), doubts(&program)), (expected, told), "{form} {bas}");
        }
    }
    // Data of a form that no file declares may say either.
    let unknown = format!("{START}\nLDAT_ACT=LCP1\nBAS(#CP_PARAMS,0.25)\n");
    assert_eq!(doubts(&krl(&format!("{unknown}{LINE}"))), [(Code::AxisIgnored, 6)]);
    assert_eq!(doubts(&krl(&format!("{unknown}LIN {{X 100}}"))), []);

    let arc = "CIRC {X 50,Y 50},{X 100,Y 0}";
    let form = |form: &str| format!("{START}\nLDAT_ACT={form}\nBAS(#CP_PARAMS,0.25)\n{arc}");
    let path = "{ORI_TYP #VAR,CIRC_TYP #PATH}";
    assert_eq!(doubts(&krl(&form(path))), [(Code::AxisIgnored, 6)]);
    assert_eq!(doubts(&krl(&form(&path.replace("PATH", "BASE")))), []);
    let usual = with(&form("{ORI_TYP #VAR}"), &listed("DECL CIRC_TYPE DEF_CIRC_TYP=#PATH"));
    assert_eq!(doubts(&usual.unwrap()), [(Code::AxisIgnored, 6)]);
}

/// VEL_CP and SVEL_CP take DEF_VEL_CP for what is beyond it; VEL_PTP and SVEL_JOINT shares of DEF_VEL_PTP.
#[test]
fn forms_run_no_faster_than_the_controller_says() {
    let line = "SLIN {X 9} WITH $VEL=SVEL_CP(25,,LCP1)";
    for (body, told) in [("BAS(#VEL_CP,25)\nLIN {X 9}", 4), (line, 4)] {
        let body = format!("{START}\n{body}");
        let program = krl(&body);
        assert_eq!(program.moves[1].feed_m_per_s, 3.0);
        assert_eq!(doubts(&program), [(Code::ChangeIgnored, told)]);
        let program = with(&body, &listed("DECL GLOBAL REAL DEF_VEL_CP=2.0")).unwrap();
        let told = vec![(Code::ChangeIgnored, told)];
        assert_eq!((program.moves[1].feed_m_per_s, doubts(&program)), (2.0, told));
    }
    assert_eq!(doubts(&krl(&format!("{START}\nBAS(#VEL_CP,3)\nLIN {{X 9}}"))), []);
    let half = listed("DECL GLOBAL INT DEF_VEL_PTP=50");
    let form = "SPTP {X 9} WITH $VEL_AXIS[1]=SVEL_JOINT(40)";
    for (body, share) in
        [("BAS(#VEL_PTP,40)\nPTP {X 9}", 0.2), (form, 0.2), ("BAS(#INITMOV,0)\nPTP {X 9}", 0.5)]
    {
        let program = with(&format!("{START}\n{body}"), &half).unwrap();
        assert_eq!(program.moves[1].timing, Timing::Joints(share), "{body}");
    }
}

/// FRAME has X, Y, Z, A, B, C alone, POS S and T beside them, AXIS no external axes.
#[test]
fn types_of_positions_lose_components() {
    let asked = |declared: &str, name: &str| {
        let program = krl(&format!(
            "DECL {declared} F\nDECL E6POS X2\n{START}\nX2={{X 100,Y 0,Z 500,A 0,B 0,C 180,S 2,T \
             32}}\nF=X2\nPTP {name}"
        ));
        assert_eq!(x(&program), [0.0, 100.0]);
        program.moves[1].stated.configuration.is_some()
    };
    assert!(asked("FRAME", "X2") && asked("POS", "F") && asked("E6POS", "F"));
    assert!(!asked("FRAME", "F"));
    // At 0 in the first, and elsewhere in the second.
    let rail = |declared: &str, first: &str, then: &str| {
        let body = format!("DECL {declared} F\nPTP {{{first},E1 0}}\nF={{{then},E1 500}}\nPTP F");
        with(&body, &settings())
    };
    let poses = ["X 0,Y 0,Z 500,A 0,B 0,C 180", "X 9,Y 0,Z 500,A 0,B 0,C 180"];
    let axes = ["A1 0,A2 0,A3 0,A4 0,A5 9,A6 0", "A1 5,A2 0,A3 0,A4 0,A5 9,A6 0"];
    for (all, less, [first, then]) in
        [("E6POS", "POS", poses), ("E6POS", "FRAME", poses), ("E6AXIS", "AXIS", axes)]
    {
        refused(rail(all, first, then), "external axis e1 moves from 0 to 500");
        assert_eq!(rail(less, first, then).unwrap().moves.len(), 2, "{less}");
    }
}

/// INITMOV ends with BASE(0), which is $WORLD: a job that has its work object elsewhere says which counts.
#[test]
fn coordinates_in_the_world_are_a_doubt_under_a_work_object() {
    let init = |between: &str| format!("BAS(#INITMOV,0)\n{between}{START}\nLIN {{X 9}}");
    let doubted = with(&init(""), &placed()).unwrap();
    assert_eq!(
        (x(&doubted), doubts(&doubted)),
        (vec![700.0, 709.0], vec![(Code::ChangeIgnored, 4)])
    );
    // The job says where $WORLD is, or has its work object there.
    let mut stated = placed();
    stated.base_frames.insert(0, pose([20.0, 0.0, 0.0], UPRIGHT));
    let at_world = Settings { work_object: Some(Isometry3::identity()), ..settings() };
    for (job, first) in [(stated, 20.0), (at_world, 0.0), (settings(), 0.0)] {
        let program = with(&init(""), &job).unwrap();
        assert_eq!((x(&program)[0], doubts(&program)), (first, vec![]));
    }
    // A base that is chosen, for all that follows or for a move.
    for chosen in ["BAS(#BASE,1)\n", "FDAT_ACT={BASE_NO 1}\nBAS(#FRAMES)\n"] {
        let program = with(&init(chosen), &placed()).unwrap();
        assert_eq!((x(&program), doubts(&program)), (vec![700.0, 709.0], vec![]), "{chosen}");
    }
    for chosen in ["BAS(#BASE,0)\n", "$BASE=BASE_DATA[0]\n", "$BASE=SBASE(0)\n"] {
        let world = with(&init(chosen), &placed()).unwrap();
        assert_eq!((x(&world), doubts(&world)), (vec![0.0, 9.0], vec![]));
        let is_told = |note: &Note| note.what.contains("(base 0), the robot's base");
        assert!(world.warnings.iter().any(is_told), "{chosen}");
    }
    let once = format!("BAS(#INITMOV,0)\nS{START} WITH $BASE=SBASE(1)\nLIN {{X 9}}");
    assert_eq!(doubts(&with(&once, &placed()).unwrap()), [(Code::ChangeIgnored, 5)]);
}

#[test]
fn a_tool_that_a_form_names_by_its_number_is_the_jobs() {
    let forms = "DECL FDAT FA={TOOL_NO 1,BASE_NO 0}\nDECL FDAT FB={TOOL_NO 2,BASE_NO 0}";
    let job = Settings { tcp: Some(pose([0.0, 0.0, 150.0], UPRIGHT)), ..listed(forms) };
    let slin = |x: u32, form: &str| {
        format!("SLIN {{X {x},Y 0,Z 500,A 0,B 0,C 180}} WITH $TOOL=STOOL2({form})\n")
    };
    let one = with(&[slin(0, "FA"), slin(9, "FA")].concat(), &job).unwrap();
    assert_eq!((one.moves[1].tcp, doubts(&one)), (pose([0.0, 0.0, 150.0], UPRIGHT), vec![]));
    assert!(!one.warnings.iter().any(|note| note.what.contains("declares its tool")));
    // Two tools of one length are seldom.
    let two = with(&[slin(0, "FA"), slin(9, "FB")].concat(), &job).unwrap();
    assert_eq!(doubts(&two), [(Code::ChangeIgnored, 4)]);
}

#[test]
fn frames_are_set_by_component() {
    let base = "$BASE={X 700,Y 0,Z 400,A 0,B 0,C 0}";
    let program =
        krl(&format!("{base}\n{START}\n$BASE.X=750\nLIN {{X 100,Y 0,Z 500,A 0,B 0,C 180}}"));
    assert_eq!(x(&program), [700.0, 850.0]);
    let tool = krl(&format!("$TOOL={{X 0,Y 0,Z 100,A 0,B 0,C 0}}\n$TOOL.Z=$TOOL.Z+20\n{START}"));
    assert!((tool.moves[0].tcp.translation.z - 0.12).abs() < 1e-12);
    let unknown = "BAS(#BASE,1)\n$BASE.X=750";
    refused(with(unknown, &settings()), "its other components are not known: BASE_DATA[1]");
    refused(with("$BASE.M=7", &settings()), "a frame has no M");
}

/// The robot of the job has its tip at x = 1 m + A1 and z = 0.5 m.
#[test]
fn the_position_behind_joints_is_that_of_the_jobs_robot() {
    let tip = |q: &[f64]| Some(Isometry3::translation(1.0 + q[0], 0.0, 0.5));
    let mut job = Settings { tip_at: Some(TipAt::new(tip)), ..settings() };
    let axes = "PTP {A1 0,A2 0,A3 0,A4 0,A5 9,A6 0}";
    let program = with(&format!("{axes}\nLIN {{Z 600}}"), &job).unwrap();
    let [at_x, at_z] = [0, 2].map(|axis| end(&program.moves[1]).1.translation.vector[axis]);
    assert!((at_x - 1.0).abs() < 1e-12 && (at_z - 0.6).abs() < 1e-12);
    let asks = "DECL INT N\nN=$POS_ACT.X/500\nIF N==2 THEN\nLIN {Z 600}\nENDIF";
    assert_eq!(with(&format!("{axes}\n{asks}"), &job).unwrap().moves.len(), 2);
    // A place that no file gives is not where the robot was before.
    let home = format!("{axes}\nPTP XHOME\n{asks}");
    refused(with(&home, &job), "path.program.files in the job can name its file");
    // Before the first move the job says where the robot stands: 1200 / 500 is 2 as INT.
    refused(with(asks, &job), "{\"$POS_ACT.Z\": …} gives a component");
    let whole = asks.replace("{Z 600}", "{X 0,Y 0,Z 600,A 0,B 0,C 180}");
    job.assume.insert("$pos_act.x".to_owned(), Assumed::Number(1200.0));
    assert_eq!(with(&whole, &job).unwrap().moves.len(), 1);
}

/// Its numbers are others in a base elsewhere.
#[test]
fn a_position_in_the_world_is_a_doubt_under_a_work_object() {
    let tip = |_: &[f64]| Some(Isometry3::translation(1.0, 0.0, 0.5));
    let job = Settings { tip_at: Some(TipAt::new(tip)), ..placed() };
    let asked = |chosen: &str, asks: &str| {
        let body = format!(
            "DECL E6POS P\nBAS(#INITMOV,0)\n{chosen}PTP {{A1 0,A2 0,A3 0,A4 0,A5 9,A6 0}}\n{asks}"
        );
        doubts(&with(&body, &job).unwrap())
    };
    for asks in [
        "P=$POS_ACT\n$BASE=$NULLFRAME\nP.Y=P.Y+100\nLIN P",
        "IF $POS_ACT.X>200 THEN\n$BASE=$NULLFRAME\nLIN {X 9}\nENDIF",
    ] {
        assert_eq!(asked("", asks), [(Code::ChangeIgnored, 6)], "{asks}");
        assert_eq!(asked("BAS(#BASE,1)\n", asks), [], "{asks}");
    }
}

#[test]
fn what_the_job_gives_of_the_position_ends_with_a_move_or_in_another_frame() {
    let mut job = assuming("$pos_act.z", 700.0);
    job.tool_frames.insert(2, pose([0.0, 0.0, 300.0], UPRIGHT));
    let asks = format!("IF $POS_ACT.Z>600 THEN\n{START}\nENDIF");
    let base = "$BASE={X 0,Y 0,Z 100,A 0,B 0,C 0}\n";
    for before in ["", base] {
        assert_eq!(with(&format!("{before}{asks}"), &job).unwrap().moves.len(), 1, "{before}");
    }
    for home in ["HOME", "XHOME"] {
        let said = "path.program.files in the job can name its file";
        refused(with(&format!("PTP {home}\n{asks}"), &job), said);
    }
    for chosen in [base, "BAS(#TOOL,2)\n"] {
        let twice = format!("IF $POS_ACT.Z>600 THEN\nENDIF\n{chosen}{asks}");
        refused(with(&twice, &job), "where the program asks for the position first");
    }
}

/// A FRAME within a structure keeps no more than any other.
#[test]
fn components_of_structures_have_types() {
    let place = "{X 100,Y 0,Z 500,A 0,B 0,C 180,S 2,T 32}";
    let found = |strucs: &str, set: &str| {
        let data = format!("{strucs}\nDECL T1 S1\nDECL E6POS X2={place}");
        with(&format!("{START}\n{set}\nPTP S1.G"), &listed(&data))
    };
    for set in ["S1.G=X2".to_owned(), format!("S1={{K 1,G {place}}}")] {
        for (strucs, keeps) in [
            ("STRUC T1 INT K,FRAME F,G", false),
            ("GLOBAL STRUC T1 FRAME G,INT K", false),
            ("STRUC T1 INT K,E6POS F,G", true),
        ] {
            let program = found(strucs, &set).unwrap();
            assert_eq!(x(&program), [0.0, 100.0]);
            let is_kept = program.moves[1].stated.configuration.is_some();
            assert_eq!(is_kept, keeps, "{strucs} {set}");
        }
        let two = "STRUC T1 INT K,FRAME G\nSTRUC T2 E6POS G";
        refused(found(two, &set), "G is a component of several STRUC");
    }
}

#[test]
fn the_job_gives_the_value_of_a_function() {
    let asks = format!("{START}\nIF Foo() == 1 THEN\nLIN {{X 9}}\nENDIF");
    refused(with(&asks, &settings()), "assume: {\"FOO\": …} in the job can give it");
    // Of a function of the controller, through a datum, too.
    let length = format!("{START}\nN=STRLEN(T[])\nIF N > 3 THEN\nLIN {{X 9}}\nENDIF");
    refused(with(&length, &settings()), "assume: {\"STRLEN\": …} in the job can give it");
    assert_eq!(with(&length, &assuming("strlen", 5.0)).unwrap().moves.len(), 2);
    for (value, moves) in [(1.0, 2), (2.0, 1)] {
        let program = with(&asks, &assuming("foo", value)).unwrap();
        assert_eq!(
            (program.moves.len(), doubts(&program)),
            (moves, vec![(Code::MotionLeftOut, 4)])
        );
    }
    // What the program sets itself the job does not give.
    let set = with(&format!("{START}\nrc=Foo()\nWAIT SEC rc"), &assuming("rc", 1.0)).unwrap();
    let unused = |note: &&Note| note.code == Code::Unused && note.what.contains("assume: 'rc'");
    assert_eq!(set.warnings.iter().filter(unused).map(at).collect::<Vec<_>>(), [5]);
}

#[test]
fn refusals_of_krl_say_what_to_do() {
    for (call, why) in [("MoveSettings()", "moves by its name"), ("Glue({X 1})", "is given a pos")]
    {
        let found = with(call, &settings()).unwrap_err();
        let said = &found[0].what;
        assert!(said.contains(why) && said.contains("path.program.files"), "{found:?}");
    }
    let rail = Settings { joint_count: 7, ..settings() };
    refused(with("PTP {A1 0,A2 0,A3 0,A4 0,A5 9,A6 0}", &rail), "external_axes in the job names");
}

/// KSS 5 has VEL_CP(LDAT_ACT.VEL) in CP_DAT and VEL_PTP(PDAT_ACT.VEL) in PTP_DAT, KSS 8 neither.
#[test]
fn a_speed_of_data_that_only_older_controllers_take_is_a_doubt() {
    let line = "BAS(#CP_DAT)\nLIN {X 9}";
    let path = |form: &str, rest: &str| krl(&format!("{START}\nLDAT_ACT={{{form}}}\n{rest}"));
    let told = vec![(Code::ChangeIgnored, 6)];
    let other = path("VEL 0.05", line);
    assert_eq!((other.moves[1].feed_m_per_s, doubts(&other)), (0.05, told));
    // The speed from before is 0.1 m/s.
    assert_eq!(doubts(&path("VEL 0.1", line)), []);
    for set in ["BAS(#VEL_CP,0.2)", "$VEL.CP=0.2"] {
        let later = path("VEL 0.05", &format!("BAS(#CP_DAT)\n{set}\nLIN {{X 9}}"));
        assert_eq!((later.moves[1].feed_m_per_s, doubts(&later)), (0.2, vec![]), "{set}");
    }
    let once = path("VEL 0.05", &line.replace("LIN {X 9}", "SLIN {X 9} WITH $VEL.CP=0.2"));
    assert_eq!(doubts(&once), []);
    let refers = "BAS(#CP_DAT)\n$VEL.CP=$VEL.CP/2\nLIN {X 9}";
    let found = with(&format!("{START}\nLDAT_ACT={{VEL 0.05}}\n{refers}"), &settings());
    refused(found, "BAS(#CP_DAT) of line 5");

    let joints = |rest: &str| {
        let set = "BAS(#INITMOV,0)\nPDAT_ACT={VEL 50}\nBAS(#PTP_DAT)";
        krl(&format!("{START}\n{set}\n{rest}PTP {{X 9,Y 0,Z 500,A 0,B 0,C 180}}"))
    };
    let other = joints("");
    assert_eq!(other.moves[1].timing, Timing::Joints(0.5));
    assert_eq!(doubts(&other), [(Code::ChangeIgnored, 7)]);
    for set in ["BAS(#VEL_PTP,50)\n", "FOR N=1 TO 6\n$VEL_AXIS[N]=20\nENDFOR\n"] {
        assert_eq!(doubts(&joints(set)), [], "{set}");
    }
    assert_eq!(doubts(&joints("PDAT_ACT={VEL 100}\nBAS(#VEL_PTP,100)\nBAS(#PTP_DAT)\n")), []);
}

/// VEL_CP has DEF_VEL_CP for what is beyond it in KSS 5, $VEL_MA.CP in KSS 8.
#[test]
fn a_speed_above_what_the_cell_declares_is_a_doubt() {
    let job = listed("REAL DEF_VEL_CP=1.0");
    for (speed, taken, told) in [("2.5", 1.0, vec![(Code::ChangeIgnored, 4)]), ("0.5", 0.5, vec![])]
    {
        for command in ["CP_PARAMS", "VEL_CP"] {
            let body = format!("{START}\nBAS(#{command},{speed})\nLIN {{X 9}}");
            let found = with(&body, &job).unwrap();
            let read = (found.moves[1].feed_m_per_s, doubts(&found));
            assert_eq!(read, (taken, told.clone()), "{body}");
        }
    }
}

/// $VEL.CP is in m/s, and no robot has 50.
#[test]
fn a_speed_that_no_robot_has_is_a_doubt() {
    for set in ["$VEL.CP=50", "$VEL={CP 50,ORI1 200}"] {
        let found = krl(&format!("{START}\n{set}\nLIN {{X 9}}"));
        assert_eq!(doubts(&found), [(Code::ChangeIgnored, 4)], "{set}");
    }
    let once = krl(&format!("{START}\nSLIN {{X 9}} WITH $VEL.CP=50"));
    assert_eq!(doubts(&once), [(Code::ChangeIgnored, 4)]);
    let init = format!("{START}\nBAS(#INITMOV,0)\nLIN {{X 9}}");
    let found = with(&init, &listed("REAL DEF_VEL_CP=250")).unwrap();
    assert_eq!(doubts(&found), [(Code::ChangeIgnored, 4)]);
    assert_eq!(doubts(&krl(&format!("{START}\n$VEL.CP=3\nLIN {{X 9}}"))), []);
}

/// SVEL_CP: RET_VEL.ORI1=DEF_VEL_ORIS.
#[test]
fn lines_of_splines_turn_at_the_speed_of_splines() {
    let data = "REAL DEF_VEL_CP=2.0\nREAL DEF_VEL_ORI1=200.0\nREAL DEF_VEL_ORI2=200.0";
    let line = "SLIN {X 1,A 90} WITH $VEL=SVEL_CP(0.2, ,LCP)\nLIN {X 2,A 0}";
    let body = format!("BAS(#INITMOV,0)\n{START}\n{line}");
    let turning = |data: &str| {
        let found = with(&body, &listed(data)).unwrap();
        let of = |each: &detune::motion::Move| each.stated.turning_rad_per_s.unwrap().to_degrees();
        [1, 2].map(|at: usize| of(&found.moves[at]).round())
    };
    assert_eq!(turning(&format!("{data}\nREAL DEF_VEL_ORIS=20.0")), [20.0, 200.0]);
    assert_eq!(turning(data), [200.0, 200.0]);
}

#[test]
fn commands_that_the_basic_package_lacks_are_refused() {
    refused(with("BAS(#OV_PRO,50)", &settings()), "#OV_PRO is no command of bas.src");
    refused(with("BAS(#FOO,50)", &settings()), "#FOO is not understood");
    for line in ["BAS(#ACC_GLUE,50)", "BAS(#GROUP,1)", "ON_ERROR_PROCEED", "ERR_CLEAR($ERR)"] {
        assert_eq!(doubts(&krl(&format!("{START}\n{line}\nLIN {{X 9}}"))), [], "{line}");
    }
}

/// bas.src, FRAMES: an external kinematic carries the base where MACHINE_FRAME_DAT names one, unless that is the robot;
/// BAS(#BASE,n) takes BASE_DATA[n].
#[test]
fn a_base_on_an_external_kinematic_is_refused() {
    let of = |index: u8, kind: &str, choice: &str| {
        let data = format!(
            "BASE_DATA[2]={{X 700,Y 0,Z 0,A 0,B 0,C 0}}\n\
             MACHINE_FRAME_DAT[2]={{MACH_DEF_INDEX {index},PARENT[] \"DKP400\"}}\n\
             MACHINE_DEF[2]={{NAME[] \"DKP400\",MECH_TYPE {kind}}}"
        );
        let form = "FDAT_ACT={TOOL_NO 0,BASE_NO 2,IPO_FRAME #BASE}";
        with(&format!("{form}\n{choice}\n{START}"), &listed(&data))
    };
    for (index, kind, choice) in [
        (0, "#EASYS", "BAS(#FRAMES)"),
        (2, "#ROBOT", "BAS(#CP_PARAMS,0.2)"),
        (2, "#EASYS", "BAS(#BASE,2)"),
        (2, "#EASYS", "BAS(#FRAMES)\n$BASE={X 700,Y 0,Z 0,A 0,B 0,C 0}"),
    ] {
        assert_eq!(x(&of(index, kind, choice).unwrap()), [700.0], "{index} {kind} {choice}");
    }
    for choice in ["BAS(#FRAMES)", "BAS(#PTP_PARAMS,50)", "BAS(#CP_PARAMS,0.2)"] {
        let said = "MACH_DEF_INDEX 2 of MACHINE_FRAME_DAT[2] lays the base on an external";
        refused(of(2, "#EASYS", choice), said);
    }
    let eko = "$BASE=EK(K_ROOT(2),K_TYPE(2),K_OFFS(2))";
    refused(of(0, "#EASYS", eko), "EK(…) lays the base on an external kinematic");
}

#[test]
fn corrections_of_the_basic_package_are_a_doubt() {
    for name in ["BASE_CORR_ON", "M_BAS_COR_ON", "TOOL_CORR_ON", "TOOL_CORR_W_ON"] {
        for (value, told) in [("TRUE", vec![(Code::ChangeIgnored, 4)]), ("FALSE", vec![])] {
            let found = krl(&format!("{START}\n{name}={value}\nLIN {{X 9}}"));
            assert_eq!(doubts(&found), told, "{name} {value}");
        }
    }
    let open = krl(&format!("{START}\nIF $IN[1] THEN\nBASE_CORR_ON=TRUE\nENDIF\nLIN {{X 9}}"));
    assert_eq!(doubts(&open), [(Code::ChangeIgnored, 5)]);
}

/// What ran before has chosen it.
#[test]
fn a_tool_or_base_that_no_line_chooses_is_a_doubt_where_there_are_several() {
    const TOOL: &str = "TOOL_DATA[1]={X 0,Y 0,Z 150,A 0,B 0,C 0}";
    const BASE: &str = "BASE_DATA[1]={X 700,Y 0,Z 0,A 0,B 0,C 0}";
    let is_told = |body: &str, job: &Settings| match doubts(&with(body, job).unwrap()).as_slice() {
        [] => false,
        told => {
            assert!(told.iter().all(|(code, _)| *code == Code::ChangeIgnored), "{told:?}");
            true
        }
    };
    let frame = Isometry3::translation(0.0, 0.0, 0.1);
    let (tools, bases) = (listed(TOOL), listed(BASE));
    let by_number = |number| Settings { base_frames: [(number, frame)].into(), ..settings() };
    assert!(!is_told(START, &settings()));
    assert!(is_told(START, &tools) && is_told(START, &bases) && is_told(START, &by_number(1)));
    assert!(is_told(START, &Settings { tool_frames: [(1, frame)].into(), ..settings() }));
    // $WORLD alone, or what the job gives in its place.
    assert!(!is_told(START, &by_number(0)));
    assert!(!is_told(START, &Settings { tcp: Some(frame), ..tools.clone() }));
    assert!(!is_told(START, &Settings { work_object: Some(frame), ..bases.clone() }));
    assert!(!is_told("PTP {A1 0,A2 -90,A3 90,A4 0,A5 9,A6 0}", &tools));
    for (choice, job) in [
        ("$TOOL=TOOL_DATA[1]", &tools),
        ("BAS(#TOOL,1)", &tools),
        ("BAS(#INITMOV,0)", &tools),
        ("$BASE=BASE_DATA[1]", &bases),
        ("$BASE=$WORLD", &bases),
        ("BAS(#INITMOV,0)", &bases),
    ] {
        assert!(!is_told(&format!("{choice}\n{START}"), job), "{choice}");
    }
    // For one move alone.
    let once = format!("{START} WITH $TOOL=TOOL_DATA[1]");
    assert!(!is_told(&once, &tools) && is_told(&format!("{once}\nLIN {{X 9}}"), &tools));
}

#[test]
fn a_move_to_the_axes_of_the_start_goes_nowhere() {
    for own in ["$AXIS_ACT", "$AXIS_ACT_MEAS"] {
        for to in ["A", own] {
            let read = format!("E6AXIS A\nA={own}\nPTP {to}\n{START}");
            assert_eq!(krl(&read).moves.len(), 1, "{own} {to}");
        }
        let late = format!("E6AXIS A\nA={own}\n{START}\nPTP A\nLIN {{X 9}}");
        refused(with(&late, &settings()), "where the axes are before the first move");
        let other = format!("E6AXIS A\nA={own}\nA.A1=A.A1+5\nPTP A\n{START}");
        refused(with(&other, &settings()), "where the axes are before the first move");
    }
}

#[test]
fn characters_bits_and_the_null_position() {
    for (set, expected) in [
        ("S=\"A\"\nN=S", 65.0),
        // -6 + 10, and 12 without the bit of 8.
        ("N=B_NOT 5+10", 4.0),
        ("N=12 B_AND B_NOT(8)", 4.0),
        ("P=$NULLPOS\nP.X=7\nN=P.X", 7.0),
    ] {
        let found = krl(&format!("CHAR S\nINT N\nE6POS P\n{START}\n{set}\nLIN {{X N}}"));
        assert_eq!((x(&found)[1], doubts(&found)), (expected, vec![]), "{set}");
    }
    let start = format!("E6POS P\n{START}\nP=$NULLPOS\nP.X=7\nP.C=180");
    assert_eq!(doubts(&krl(&format!("{start}\nLIN P"))), []);
    assert_eq!(doubts(&krl(&format!("{start}\nPTP P"))), [(Code::MotionLeftOut, 8)]);
    let speed = "SPLINE\nCONST_VEL START=0\nSLIN {X 9}\nCONST_VEL END=0\nENDSPLINE";
    assert_eq!(x(&krl(&format!("{START}\n{speed}"))), [0.0, 9.0]);
    refused(with("INT A=2, B=3", &settings()), "of one variable alone");
}

#[test]
fn times_to_wait_that_the_run_decides_are_told() {
    for (wait, line, read) in [
        ("IF $IN[1] THEN\nWAIT SEC 5\nENDIF", 5, "under IF that only the run decides is left"),
        ("WHILE $IN[1]\nWAIT SEC 5\nENDWHILE", 5, "under WHILE that only the run"),
        ("REPEAT\nWAIT SEC 5\nUNTIL $IN[1]", 5, "under UNTIL that only the run decides counts"),
    ] {
        let found = krl(&format!("{START}\n{wait}\nLIN {{X 9}}"));
        let told = found.warnings.iter().filter(|note| note.code == Code::LeftOut);
        let told: Vec<_> = told.map(|note| (at(note), note.what.contains(read))).collect();
        assert_eq!((told, doubts(&found)), (vec![(line, true)], vec![]), "{wait}");
    }
}

#[test]
fn the_speed_that_the_program_has_set_is_known() {
    let body = "$VEL.CP=0.5\nLIN {X 100}\n$VEL.CP=$VEL.CP/2\nLIN {X 0}";
    let found = krl(&format!("{START}\n{body}"));
    assert_eq!([1, 2].map(|at: usize| found.moves[at].feed_m_per_s), [0.5, 0.25]);
    let turns = krl(&format!("$VEL.ORI1=40\n{START}\n$VEL.ORI1=$VEL.ORI1/2\nLIN {{X 9,A 9}}"));
    let speed = turns.moves[1].stated.turning_rad_per_s.unwrap();
    assert!((speed.to_degrees() - 20.0).abs() < 1e-9);
    let unset = format!("{START}\nIF $VEL.ORI1>9 THEN\nLIN {{X 9}}\nENDIF");
    refused(with(&unset, &settings()), "'$VEL.ORI1' is known only at run time");
}

/// A number is no name of an enumeration.
#[test]
fn the_job_says_which_name_of_an_enumeration_a_datum_has() {
    let asks = format!("{START}\nIF $MODE_OP==#T1 THEN\nLIN {{X 9}}\nENDIF");
    let hint = "assume: {\"$MODE_OP==#T1\": true}";
    refused(with(&asks, &settings()), hint);
    refused(with(&asks, &assuming("$mode_op", 1.0)), hint);
    let switch = "SWITCH $MODE_OP\nCASE #T1,#T2\nLIN {X 9}\nDEFAULT\nENDSWITCH";
    for (name, moves) in [("#t1", 2), (" #ex", 1)] {
        let assume = [(format!("$mode_op=={name}"), Assumed::Truth(true))].into();
        let job = Settings { assume, ..settings() };
        for body in [&asks, &format!("{START}\n{switch}")] {
            assert_eq!(with(body, &job).unwrap().moves.len(), moves, "{name} {body}");
        }
    }
}

#[test]
fn the_job_says_which_name_of_an_enumeration_a_datum_has_not() {
    let job = |said: &[(&str, bool)]| {
        let given = said.iter().map(|(name, is)| ((*name).to_owned(), Assumed::Truth(*is)));
        Settings { assume: given.collect(), ..settings() }
    };
    let asks = |what: &str| format!("{START}\nIF {what} THEN\nLIN {{X 9}}\nENDIF");
    let switch = |name: &str| {
        format!(
            "{START}\nSWITCH $MODE_OP\nCASE {name}\nLIN {{X 9}}\nDEFAULT\nLIN {{X 5}}\nENDSWITCH"
        )
    };
    let not = job(&[("$mode_op == #t1", false)]);
    for (what, moves) in [("$MODE_OP==#T1", 1), ("#T1 == $MODE_OP", 1), ("$MODE_OP<>#T1", 2)] {
        assert_eq!(with(&asks(what), &not).unwrap().moves.len(), moves, "{what}");
    }
    assert_eq!(x(&with(&switch("#T1"), &not).unwrap()), [0.0, 5.0]);
    // Other names stay open.
    refused(with(&asks("$MODE_OP==#T2"), &not), "'$MODE_OP' is known only at run time");
    refused(with(&switch("#T1,#T2"), &not), "'$MODE_OP' is known only at run time");
    let body = asks("$MODE_OP==#T1");
    let both = job(&[("$mode_op==#t1", true), ("$mode_op==#ex", true)]);
    let found = with(&body, &both).unwrap_err();
    assert!(found.iter().any(|own| own.code == Code::Conflict && at(own) == 4), "{found:?}");
    let both = job(&[("$mode_op==#t1", true), ("$mode_op == #t1", false)]);
    refused(with(&body, &both), "\"$MODE_OP==#T1\" true and false");
    let agree = job(&[("$mode_op==#t1", false), ("$mode_op==#ex", true)]);
    assert_eq!(with(&body, &agree).unwrap().moves.len(), 1);
}

#[test]
fn lines_that_need_what_the_file_lacks_say_so() {
    for line in ["PTP P1 Vel=80% PDAT1 Tool[1]", "LIN P2 Vel=0.5 m/s CPDAT1", "PTP HOME VEL=50"] {
        refused(with(line, &settings()), "what the pendant shows of an inline form");
    }
    for line in
        ["OUT 1 'gripper_open' State=FALSE", "SYN OUT 2 '' State= TRUE at START Delay= 0 ms"]
    {
        refused(with(line, &settings()), "$OUT[n]=… of an output");
    }
    let compares = format!("DECL BOOL OUT\nDECL INT STATE\nSTATE=1\nOUT = STATE==1\n{START}");
    assert_eq!(with(&compares, &settings()).unwrap().moves.len(), 1);
    refused(with("LIN {X 1} $VEL=5", &settings()), "behind the target is not understood");
    refused(with("RSI_MOVECORR()", &settings()), "sensors move the robot there");
}

/// A proxy sets a datum from outside: what the loop does then is not in its first pass.
#[test]
fn an_endless_loop_names_what_it_waits_for() {
    const LOOP: &str = "LOOP\nSWITCH COM\nCASE 3\nLIN {X 9}\nENDSWITCH\nENDLOOP";
    let told = |program: &Program| {
        let own = program.warnings.iter().find(|note| note.what.starts_with("an endless loop"));
        own.map(|note| (at(note), note.what.clone())).unwrap()
    };
    let program = krl(&format!("{START}\nCOM=0\n{LOOP}"));
    let (line, what) = told(&program);
    assert_eq!((program.moves.len(), line, doubts(&program).len()), (1, 5, 1));
    for said in ["what moves from line 8 on depends on COM", "assume: {\"COM\": …} in the job"] {
        assert!(what.contains(said), "{what}");
    }
    let given = with(&format!("{START}\n{LOOP}"), &assuming("com", 3.0)).unwrap();
    assert_eq!(x(&given), [0.0, 9.0]);
    // Others do not see what the routine declares.
    let own = krl(&format!("DECL INT COM\n{START}\nCOM=0\n{LOOP}"));
    assert!(!told(&own).1.contains("depends on"));
    // Nor do they change constants, nor where the robot is; a component is named as such.
    let of = |condition: &str| {
        format!("{START}\nLOOP\nIF {condition} THEN\nLIN {{X 9}}\nENDIF\nENDLOOP")
    };
    let data = listed("DECL CONST INT MAXC=3\nDECL INT COM=3");
    let what = told(&with(&of("COM==MAXC"), &data).unwrap()).1;
    assert!(what.contains("from line 6 on depends on COM, "), "{what}");
    assert!(!told(&krl(&of("$POS_ACT.X<5"))).1.contains("depends on"));
    let what = told(&with(&of("ST.MODE==2"), &assuming("st.mode", 2.0)).unwrap()).1;
    assert!(what.contains("assume: {\"ST.MODE\": …}"), "{what}");
    // In a routine that the loop calls, and around GOTO.
    let called = |own: &str| {
        let work = format!("DEF WORK()\n{own}SWITCH COM\nCASE 3\nLIN {{X 9}}\nENDSWITCH");
        told(&krl(&format!("{START}\nCOM=0\nLOOP\nWORK()\nENDLOOP\nEND\n{work}")))
    };
    let (line, what) = called("");
    assert!(line == 5 && what.contains("from line 12 on depends on COM, "), "{what}");
    assert!(!called("DECL INT COM\nCOM=0\n").1.contains("depends on"));
    let back = "AGAIN:\nIF COM==3 THEN\nLIN {X 9}\nENDIF\nGOTO AGAIN";
    let (line, what) = told(&krl(&format!("{START}\nCOM=0\n{back}")));
    assert!(line == 9 && what.contains("from line 7 on depends on COM, "), "{what}");
    // Nothing that moves behind a position that no file declares.
    let input = LOOP.replace("SWITCH COM\nCASE 3", "IF $IN[1] THEN").replace("SWITCH", "IF");
    let assume = [("$in[1]".to_owned(), Assumed::Truth(false))].into();
    let found = with(&format!("INI\nPTP HOME\n{input}"), &Settings { assume, ..settings() });
    let found = found.unwrap_err();
    assert_eq!((at(&found[0]), found.len()), (5, 1), "{found:?}");
    assert!(found[0].what.contains("no motion that is read: an endless loop"), "{found:?}");
    assert!(found[0].what.contains("from line 7 on depends on $IN[1]"), "{found:?}");
}

#[test]
fn a_program_without_motion_names_all_that_is_in_no_file() {
    let found = with("INI\nMYJOB()", &settings()).unwrap_err();
    assert_eq!((at(&found[0]), found.len()), (3, 1), "{found:?}");
    let said = "no motion that is read: 'ini', 'myjob' are in no file that is read";
    assert!(found[0].what.contains(said), "{found:?}");
}

#[test]
fn a_path_of_home_positions_alone_names_them() {
    let homes = "PTP XHOME\nWAIT SEC 0.5\nPTP XHOME";
    let of = |body: &str| {
        let found = with(body, &settings()).unwrap_err();
        (found.iter().map(at).collect::<Vec<_>>(), found[0].what.clone())
    };
    let (line, what) = of(&format!("INI\n{homes}"));
    assert_eq!(line, [4]);
    let said =
        "PTP XHOME is skipped, as no file that is read gives XHOME, and nothing of 'ini' is read";
    assert!(what.contains(said), "{what}");
    let (line, what) = of(homes);
    assert_eq!(line, [3]);
    assert!(what.contains("gives XHOME; path.program.files in the job"), "{what}");
}
