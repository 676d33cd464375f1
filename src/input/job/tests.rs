//! Jobs: what is read, what may be absent, what is refused.

use nalgebra::Isometry3;

use super::*;
use crate::input::robot::tests as robot;
use crate::job::{Carried, CarriedBy, CuttingDirection, SpindleSpeed};
use crate::motion::Target;

const JOB: &str = include_str!("../../../tests/data/bad/job.yaml");

fn load(job: &str, robot_yaml: &str) -> Result<(Job, Vec<Note>), Vec<String>> {
    let (folder, _) = robot::folder(robot_yaml, robot::URDF);
    let path = folder.path().join("job.yaml");
    std::fs::write(&path, job).unwrap();
    let prefix = format!("{}/", folder.path().display());
    let mut reading = Reading::default();
    read_job(&path, &mut reading)
        .map(|job| (job, reading.warnings))
        .map_err(|notes| notes.iter().map(|f| f.to_string().replace(&prefix, "")).collect())
}

#[test]
fn every_key_arrives_in_si() {
    let (job, warnings) = load(JOB, robot::YAML).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(job.name, "Pocket");
    assert_eq!(job.robot.name(), "Two-link section");
    let tool = job.operations[0].tool.clone();
    assert_eq!((tool.teeth, tool.diameter_m), (2, Some(0.012)));
    let pitch = tool.pitch_rad.unwrap();
    assert!((pitch.iter().sum::<f64>() - std::f64::consts::TAU).abs() < 1e-12);
    assert_eq!(job.spindle.max_acceleration_rpm_per_s, Some(500.0));
    let [rough, finish] = &job.operations[..] else { panic!() };
    assert_eq!((rough.name.as_str(), rough.line), ("rough", 10));
    assert_eq!(rough.speed, SpindleSpeed::Constant(1100.0));
    assert_eq!(rough.feed_m_per_s, 0.01);
    assert_eq!(rough.cutting.as_ref().unwrap().direction, CuttingDirection::Climb);
    assert_eq!(rough.moves.iter().map(|m| m.line).collect::<Vec<_>>(), [16, 17, 18]);
    let Target::Joints(q) = &rough.moves[1].to else { panic!() };
    assert!((q[0] - 10_f64.to_radians()).abs() < 1e-15);
    assert_eq!(rough.moves[0].tcp.translation.z, 0.15);
    assert_eq!(finish.speed, SpindleSpeed::Schedule(vec![(0.0, 1200.0), (1.0, 1350.0)]));
    assert_eq!(finish.moves.iter().map(|m| m.line).collect::<Vec<_>>(), [25, 26]);
    // The work object is turned by 90° about z: its x is the base's y.
    let Target::Line(pose) = &finish.moves[0].to else { panic!() };
    let expected = nalgebra::Vector3::new(0.9, 0.1, 0.4);
    assert!((pose.translation.vector - expected).norm() < 1e-12);
    assert!((pose.rotation * nalgebra::Vector3::z() + nalgebra::Vector3::z()).norm() < 1e-12);
    assert!((finish.start_near.as_ref().unwrap()[1] - 10_f64.to_radians()).abs() < 1e-15);
    let policy = job.policy;
    assert_eq!((policy.tooth_passing_harmonics, policy.spindle_harmonics), (3, 0));
    assert_eq!(policy.separation, 0.08);
    assert_eq!((policy.model_uncertainty, policy.confidence), (None, 0.95));
    assert_eq!(policy.ignore_hz, [[49.0, 51.0], [99.0, 101.0]]);
    assert!((policy.min_tip_response_m_per_n.unwrap() - 0.5e-6).abs() < 1e-20);
}

#[test]
fn what_may_be_absent_has_the_contract_s_defaults() {
    let job = "robot: robot.yaml\ntool: {teeth: 2}\nspindle: {min_rpm: 500, max_rpm: \
        6000}\noperations: \
               [{name: a, spindle_rpm: 600, feed_mm_per_min: 60, path: {poses: [{xyz_mm: [1, \
               2, 3]}]}}]\n";
    let uncalibrated: String = robot::YAML
        .lines()
        .filter(|l| !l.starts_with("calibration"))
        .collect::<Vec<_>>()
        .join("\n");
    let job = load(job, &uncalibrated).unwrap().0;
    assert_eq!(job.name, "job");
    assert_eq!(
        job.policy,
        Policy {
            tooth_passing_harmonics: 2,
            spindle_harmonics: 1,
            separation: 0.1,
            model_uncertainty: None,
            confidence: 0.95,
            ignore_hz: Vec::new(),
            min_tip_response_m_per_n: None,
            max_deflection_m: None,
            max_vibration_m: None,
        }
    );
    let operation = &job.operations[0];
    assert_eq!((operation.line, &operation.start_near, &operation.program), (4, &None, &None));
    assert_eq!(operation.moves[0].tcp, Isometry3::identity());
    let Target::Line(pose) = &operation.moves[0].to else { panic!() };
    assert!((pose.translation.vector - nalgebra::Vector3::new(1e-3, 2e-3, 3e-3)).norm() < 1e-15);
}

#[test]
fn faults_of_job_and_robot_are_told_at_once() {
    let job = JOB
        .replace("spindle_rpm: 1100", "spindle_rpm: 400")
        .replace("feed_mm_per_min: 300", "feed_mm_per_min: 0")
        .replace("separation_percent: 8", "seperation_percent: 8");
    let robot = robot::YAML.replace("138000", "-1");
    assert_eq!(
        load(&job, &robot).unwrap_err(),
        [
            "job.yaml:11: operation 'rough': spindle_rpm is 400, must lie in the spindle's \
                range 500..6000",
            "job.yaml:21: operation 'finish': feed_mm_per_min is 0, must be positive and \
                finite",
            "job.yaml:30: policy: unknown key 'seperation_percent'; did you mean \
                'separation_percent'?",
            "robot.yaml:11: joint 'joint_2': stiffness_nm_per_rad is -1, must be positive and \
                finite",
        ]
    );
}

/// A job with `operation` and a program beside it, and its notices; or the errors.
fn read_of(operation: &str, file: &str, program: &str) -> Result<(Job, Vec<String>), Vec<String>> {
    let (folder, _) = robot::folder(robot::YAML, robot::URDF);
    let path = folder.path().join("job.yaml");
    let tool = if operation.contains("\ntools:") { "" } else { "tool: {teeth: 2}\n" };
    let job = format!(
        "robot: robot.yaml\n{tool}spindle: {{min_rpm: 500, max_rpm: 20000}}\n\
         operations:\n  - name: rough\n{operation}"
    );
    std::fs::write(&path, job).unwrap();
    // The end that a whole program has.
    let end = match file.rsplit_once('.') {
        Some((_, "nc")) => "M30\n",
        Some((_, "cls")) => "FINI\n",
        _ => "",
    };
    std::fs::write(folder.path().join(file), format!("{program}{end}")).unwrap();
    let prefix = format!("{}/", folder.path().display());
    let shown = |notes: Vec<Note>| -> Vec<String> {
        notes.iter().map(|note| note.to_string().replace(&prefix, "")).collect()
    };
    let mut reading = Reading::default();
    let job = read_job(&path, &mut reading);
    job.map(|job| (job, shown(reading.warnings))).map_err(shown)
}

fn notices_of(operation: &str, file: &str, program: &str) -> Vec<String> {
    read_of(operation, file, program).unwrap().1
}

const GCODE: &str = "    path: {program: {file: a.nc}}\n";

#[test]
fn what_program_and_job_say_differently_is_an_error_unless_it_is_settled() {
    // Nothing moves under 9000 and 5000 rpm.
    let speeds =
        "G0 X0 Y0 Z0\nS1100 M3\nG1 X1 F100\nS12000\nX2\nS9000\nS8000\nX3\nM5\nX4\nS5000 M3\n";
    let of_job = format!("    spindle_rpm: 1100\n{GCODE}");
    let errors = read_of(&of_job, "a.nc", speeds).unwrap_err();
    assert_eq!(
        errors,
        ["job.yaml:6: operation 'rough': spindle_rpm is 1100, a.nc:4 commands 12000 rpm, and \
          one more speed; make them agree, or write speeds_from: program or speeds_from: job"]
    );
    let rpm = |operation: &str| -> Vec<SpindleSpeed> {
        let (job, _) = read_of(operation, "a.nc", speeds).unwrap();
        job.operations.into_iter().map(|operation| operation.speed).collect()
    };
    let three = [1100.0, 12_000.0, 8000.0].map(SpindleSpeed::Constant);
    assert_eq!(rpm(GCODE), three);
    assert_eq!(rpm(&format!("{of_job}speeds_from: program\n")), three);
    assert_eq!(rpm(&format!("{of_job}speeds_from: job\n")), three[..1]);
    let schedule = "    spindle_schedule: [{s: 0, rpm: 1100}]\n";
    let errors = read_of(&format!("{schedule}{GCODE}"), "a.nc", speeds).unwrap_err();
    assert!(errors[0].contains("has a spindle_schedule, a.nc:2 commands 1100 rpm"), "{errors:?}");
    let feed = format!("    feed_mm_per_min: 60\n{GCODE}");
    let errors = read_of(&feed, "a.nc", speeds).unwrap_err();
    assert!(
        errors[0].contains("feed_mm_per_min is 60, a.nc:3 runs at 100 mm/min, and no move"),
        "{errors:?}"
    );
    let (job, notices) =
        read_of(GCODE, "a.nc", "G21 S30000 M3\nG0 X0 Y0 Z0\nG1 X1 F120\n").unwrap();
    assert_eq!(job.operations[0].feed_m_per_s, 0.002);
    assert_eq!(
        notices,
        ["a.nc:1: commands 30000 rpm, outside the spindle's range 500..20000 (operation \
          'rough')"]
    );
}

#[test]
fn what_neither_program_nor_job_says_is_missing() {
    let errors = read_of(GCODE, "a.nc", "G0 X0 Y0 Z0\nG1 X1\n").unwrap_err();
    assert_eq!(
        errors,
        ["a.nc:2: moves at a feed that the program does not state: write feed_mm_per_min in \
          the job's operation"]
    );
    let errors = read_of(GCODE, "a.nc", "G0 X0 Y0 Z0\nG1 X1 F100\n").unwrap_err();
    assert_eq!(
        errors,
        ["job.yaml:5: operation 'rough': missing key 'spindle_rpm' (or 'spindle_schedule'): \
          a.nc:1 runs at a speed that the program does not state"]
    );
}

#[test]
fn each_tool_of_the_program_is_one_of_the_job_s() {
    let program = "T1 M6\nS12000 M3\nG1 X0 Y0 Z0 F100\nX1\nT2\nX2\nM5\nX3\nM6\nX4\nS800 M3\nX5\n";
    let errors = read_of(GCODE, "a.nc", program).unwrap_err();
    assert_eq!(
        errors,
        ["job.yaml:2: operation 'rough': the program loads tool 1 and, from a.nc:10 on, tool 2: \
          write tools: {1: {teeth: …}, 2: {teeth: …}} instead of tool"]
    );
    let tools = format!("{GCODE}tools: {{1: {{teeth: 3}}, 2: {{teeth: 1, payload: none}}}}\n");
    let (job, _) = read_of(&tools, "a.nc", program).unwrap();
    let found: Vec<_> = job
        .operations
        .iter()
        .map(|o| (o.name.as_str(), o.tool.teeth, o.tool_number, o.speed.rpm_at(0.0)))
        .collect();
    assert_eq!(found, [("rough", 3, Some(1), 12_000.0), ("rough/2", 1, Some(2), 800.0)]);
    let stretches: Vec<_> = job.operations.iter().map(|o| o.stretch.clone()).collect();
    assert_eq!(stretches, [0..4, 4..6]);
    let carried: Vec<_> = job.operations.iter().map(|o| o.carried.source).collect();
    assert_eq!(carried, [CarriedBy::Robot, CarriedBy::None]);
    let masses: Vec<_> = job.operations.iter().map(|o| o.robot.moving_mass_kg()).collect();
    assert!((masses[0] - masses[1] - 1.5).abs() < 1e-12, "{masses:?}");
    let one = format!("{GCODE}tools: {{1: {{teeth: 3}}}}\n");
    assert_eq!(
        read_of(&one, "a.nc", program).unwrap_err(),
        ["a.nc:10: operation 'rough': tool 2 is loaded, which is not among tools in the job (1)"]
    );
}

/// A tool that the program calls by a name has the number under which the job lists it.
#[test]
fn tools_by_name_are_those_that_the_job_lists() {
    let program = "T=\"MILL2\"\nM6\nG71 G90 G94 S9000 M3\nG0 X0 Y0 Z0\nG1 X10 F100\n\
                   T=\"MILL5\"\nM6\nS800 M3\nX20\nM30\n";
    let job = |second: &str| {
        format!(
            "    path: {{program: {{file: a.mpf}}}}\n\
             tools: {{3: {{name: MILL2, teeth: 3}}, 4: {{name: {second}, teeth: 1}}}}\n"
        )
    };
    let (read, notices) = read_of(&job("MILL5"), "a.mpf", program).unwrap();
    let found: Vec<_> = read
        .operations
        .iter()
        .map(|o| (o.tool.teeth, o.tool_number, o.speed.rpm_at(0.0)))
        .collect();
    assert_eq!(found, [(3, Some(3), 9000.0), (1, Some(4), 800.0)]);
    assert!(notices.iter().all(|notice| !notice.contains("has a name")), "{notices:?}");
    let (_, notices) = read_of(&job("MILL6"), "a.mpf", program).unwrap();
    assert!(notices.iter().any(|notice| notice.contains("\"MILL5\" has a name")), "{notices:?}");
    let by_name = job("MILL5").replace("{3: ", "{MILL2: ");
    let errors = read_of(&by_name, "a.mpf", program).unwrap_err();
    assert!(errors.iter().any(|error| error.contains("{1: {name: …")), "{errors:?}");
}

/// An empty spindle cuts nothing; where it would, its tool is asked for.
#[test]
fn tool_0_is_an_empty_spindle() {
    let tools = format!("{GCODE}tools: {{1: {{teeth: 3}}}}\n");
    let program = |end: &str| format!("T1 M6\nS9000 M3\nG1 X0 Y0 Z0 F100\nX1\nM5\nT0 M6\n{end}\n");
    for end in ["G0 Z9", "G1 Z9", "S900 M3\nG0 Z9"] {
        let (job, _) = read_of(&tools, "a.nc", &program(end)).unwrap();
        let found: Vec<_> = job.operations.iter().map(|o| o.tool_number).collect();
        assert!(found.iter().all(|number| *number == Some(1)), "{end}: {found:?}");
    }
    for end in ["S900 M3\nG1 Z9", "S900 M3\nG93\nG1 Z9 F2"] {
        let errors = read_of(&tools, "a.nc", &program(end)).unwrap_err();
        assert!(errors[0].contains("tool 0 is loaded, which is not among tools"), "{errors:?}");
    }
}

#[test]
fn the_most_specific_payload_wins_and_is_told() {
    let program = |mass: &str| {
        format!(
            "MODULE m\n  PERS tooldata \
                tMill:=[TRUE,[[0,0,7],[1,0,0,0]],\
                [{mass},[0,0,70],[0.7071068,0.7071068,0,0],1,2,2.5]];\n\
             PROC main()\n MoveL \
             [[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tMill;\n\
             MoveL [[1,2,4],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tMill;\n\
             ENDPROC\nENDMODULE\n"
        )
    };
    let job = "    spindle_rpm: 1100\n    path: {program: {file: a.mod}}\n";
    let carried = |job: &str, mass: &str| {
        let (job, notices) = read_of(job, "a.mod", &program(mass)).unwrap();
        let carried = job.operations[0].carried;
        (carried.mass_kg, carried.source, notices)
    };
    let not_used = |whose: &str, kg: f64| {
        let check = if whose == "the job's" { "; put right the one that is wrong" } else { "" };
        format!(
            "a.mod:2: tooldata tMill declares 4.2 kg, which is what the model carries; {whose} \
             payload of {kg} kg is not used{check}"
        )
    };
    let of_job = format!("{job}payload: {{mass_kg: 3, com_m: [0, 0, 0]}}\n");
    let near = format!("{job}payload: {{mass_kg: 4, com_m: [0, 0, 0]}}\n");
    let code = |job: &str| {
        let (job, _) = read_of(job, "a.mod", &program("4.2")).unwrap();
        job.review.warnings[0].code
    };
    assert_eq!([code(&of_job), code(&near)], [Code::ToolMassConflict, Code::ToolMass]);
    let none = format!("{job}payload: none\n");
    assert_eq!(
        [carried(job, "4.2"), carried(&of_job, "4.2"), carried(&none, "4.2")],
        [
            (4.2, CarriedBy::Program, vec![not_used("the robot file's", 1.5)]),
            (4.2, CarriedBy::Program, vec![not_used("the job's", 3.0)]),
            (4.2, CarriedBy::Program, vec![not_used("the job's", 0.0)]),
        ]
    );
    // ABB's placeholders say nothing.
    for mass in ["-1", "0.001"] {
        assert_eq!(carried(job, mass), (1.5, CarriedBy::Robot, vec![]));
        assert_eq!(carried(&of_job, mass), (3.0, CarriedBy::Job, vec![]));
        assert_eq!(carried(&none, mass), (0.0, CarriedBy::None, vec![]));
    }
    assert_eq!(carried(job, "1.5"), (1.5, CarriedBy::Program, vec![]));
    // The moments are given in axes turned by 90° about x, so y and z change places.
    let (read, _) = read_of(job, "a.mod", &program("4.2")).unwrap();
    let body = read.operations[0].robot.carried().unwrap().inertial;
    assert_eq!(body.com_m, nalgebra::Vector3::new(0.0, 0.0, 0.07));
    let expected = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 2.5, 2.0));
    assert!((body.inertia_kgm2 - expected).norm() < 1e-6, "{}", body.inertia_kgm2);
    // What is not a mapping is not taken for one.
    let errors = read_of(&format!("{job}payload: nothing\n"), "a.mod", &program("1")).unwrap_err();
    assert_eq!(
        errors,
        ["job.yaml:8: payload is nothing, must be a mapping of keys to values, or none"]
    );
    let odd = format!("{job}payload: {{mass_kg: 3, inertia_kgm2: {{ixx: 9, iyy: 1, izz: 1}}}}\n");
    let errors = read_of(&odd, "a.mod", &program("0")).unwrap_err();
    assert!(errors[0].starts_with("job.yaml:8: operation 'rough': payload: "), "{errors:?}");
}

#[test]
fn a_load_that_nobody_states_is_told() {
    let bare = robot::YAML.lines().filter(|l| !l.starts_with("payload")).collect::<Vec<_>>();
    let (job, notices) = load(JOB, &bare.join("\n")).unwrap();
    assert_eq!(job.operations[0].carried, Carried::UNKNOWN);
    assert_eq!((notices.len(), notices[0].code), (1, Code::PayloadUnknown));
    let (job, notices) = load(&format!("{JOB}payload: none\n"), &bare.join("\n")).unwrap();
    assert_eq!((job.operations[0].carried, notices.len()), (Carried::NOTHING, 0));
    let (_, notices) = load(&format!("{JOB}payload: {{mass_kg: 3}}\n"), robot::YAML).unwrap();
    let [note] = &notices[..] else { panic!("{notices:?}") };
    assert_eq!(note.code, Code::Assumed);
    assert!(note.what.starts_with("payload has no com_m, so its centre of mass"), "{note}");
}

/// The cut with the tool of no stated load is checked with the other's: a doubt at its line; with
/// the job's, where that has one.
#[test]
fn a_load_that_only_a_neighbour_has_is_doubted() {
    let tool = |name: &str, mass: &str| {
        format!(
            "PERS tooldata {name}:=[TRUE,[[0,0,7],[1,0,0,0]],[{mass},[0,0,70],[1,0,0,0],0,0,0]];\n"
        )
    };
    let way = |z: u8, tool: &str| {
        format!("MoveL [[1,2,{z}],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,{tool};\n")
    };
    let read = |mass: &str, payload: &str| {
        let tools = tool("tA", mass) + &tool("tB", "4.2");
        let cuts = [way(3, "tA"), way(4, "tA"), way(5, "tB"), way(6, "tB")].concat();
        let program = format!("MODULE m\n{tools}PROC main()\n{cuts}ENDPROC\nENDMODULE\n");
        let job = "    spindle_rpm: 1100\n    path: {program: {file: a.mod}}\n";
        let (job, notices) = read_of(&format!("{job}{payload}"), "a.mod", &program).unwrap();
        let told = notices.into_iter().filter(|what| what.contains("neighbour"));
        let carried = job.operations.iter().map(|own| own.carried.mass_kg);
        (carried.collect::<Vec<_>>(), told.collect::<Vec<_>>())
    };
    let own = "payload: {mass_kg: 3, com_m: [0, 0, 0]}\n";
    assert_eq!(read("-1", own), (vec![3.0, 4.2], vec![]));
    assert_eq!(read("-1", "payload: none\n"), (vec![0.0, 4.2], vec![]));
    let told = |mass: &str| read(mass, "").1;
    assert_eq!(told("2"), Vec::<String>::new());
    let [one] = &told("-1")[..] else { panic!("{:?}", told("-1")) };
    assert!(one.starts_with("a.mod:6: operation 'rough': the program states the load"), "{one}");
}

/// RobotStudio's load of a new tool: the payload that somebody stated counts, and beside `none` it
/// is a doubt; another tool's load never stands in for it.
#[test]
fn the_load_of_a_new_tool_gives_way_to_what_is_stated() {
    let of_new = "[1,[0,0,1],[1,0,0,0],0,0,0]";
    let way = |z: u8, tool: &str| {
        format!("MoveL [[1,2,{z}],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,{tool};\n")
    };
    let program = format!(
        "MODULE m\nPERS tooldata tA:=[TRUE,[[0,0,7],[1,0,0,0]],{of_new}];\nPERS tooldata \
         tB:=[TRUE,[[0,0,7],[1,0,0,0]],[4.2,[0,0,70],[1,0,0,0],0,0,0]];\nPROC \
         main()\n{}ENDPROC\nENDMODULE\n",
        [way(3, "tA"), way(4, "tA"), way(5, "tB"), way(6, "tB")].concat()
    );
    let read = |payload: &str| {
        let job =
            format!("    spindle_rpm: 1100\n    path: {{program: {{file: a.mod}}}}\n{payload}");
        let (job, _) = read_of(&job, "a.mod", &program).unwrap();
        let warnings = job.review.warnings.iter();
        let of_new = warnings.filter(|own| own.what.contains("placeholder")).map(|own| own.code);
        (job.operations.iter().map(|own| own.carried.mass_kg).collect::<Vec<_>>(), of_new.collect())
    };
    assert_eq!(read(""), (vec![1.5, 4.2], vec![Code::Assumed]));
    assert_eq!(
        read("payload: {mass_kg: 3, com_m: [0, 0, 0]}\n"),
        (vec![3.0, 4.2], vec![Code::Assumed])
    );
    assert_eq!(read("payload: none\n"), (vec![0.0, 4.2], vec![Code::ToolMassConflict]));
}

/// 150 mm in metres; a tool of 1.5 m there is.
#[test]
fn a_tool_that_ends_far_from_the_arm_is_doubted() {
    let with = |z: &str| {
        let job = format!("{JOB}payload: none\n").replace("[0, 0, 0.15]", &format!("[0, 0, {z}]"));
        load(&job, robot::YAML).unwrap().1
    };
    let notices = with("150");
    let [note] = &notices[..] else { panic!("{notices:?}") };
    assert_eq!(note.code, Code::CadUnits);
    assert!(note.what.contains("150 m from the robot's tip"), "{note}");
    assert_eq!(with("1.5"), []);
}

#[test]
fn rapid_sets_speed_and_tool_as_the_job_says() {
    let to = |x: u32| {
        format!("MoveL [[{x},0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;")
    };
    let [a, b, c, d] = [0, 1, 2, 3].map(to);
    let cases = [
        (
            "signal: aoSpindle, rpm_per_unit: 100",
            "signal: goTool",
            ["SetGO goTool, 1;\nSetAO aoSpindle, 9;", "SetAO aospindle, 8;", "SetGO goTool, 2;"],
        ),
        (
            "procedure: SpindleOn, argument: 2, rpm_per_unit: 100",
            "procedure: LoadTool",
            ["LoadTool 1;\nSpindleOn TRUE, 9;", "SpindleOn TRUE, 8;", "LoadTool 2;"],
        ),
        (
            "comment: SPINDLE, rpm_per_unit: 100",
            "comment: T",
            ["! T1\n! SPINDLE: 9 x100", "!SPINDLE 8", "\n! T 2"],
        ),
    ];
    for (spindle, tool, [first, second, third]) in cases {
        let program = format!(
            "MODULE m\nPROC main()\n{first}\n{a}\n{b}\n{second}\n{c}\n{third}\n{d}\n\
             ENDPROC\nENDMODULE\n"
        );
        let job = format!(
            "    path:\n      program: {{file: a.mod, spindle_from: {{{spindle}}}, tool_from: \
             {{{tool}}}}}\ntools: {{1: {{teeth: 3}}, 2: {{teeth: 2}}}}\n"
        );
        let (job, _) = read_of(&job, "a.mod", &program).unwrap();
        let found: Vec<_> = job
            .operations
            .iter()
            .map(|o| (o.stretch.clone(), o.speed.rpm_at(0.0), o.tool_number))
            .collect();
        let expected = [(0..2, 900.0, Some(1)), (2..3, 800.0, Some(1)), (3..4, 800.0, Some(2))];
        assert_eq!(found, expected, "{spindle}");
    }
}

#[test]
fn a_procedure_without_effect_and_rapid_moves_are_told() {
    let operation = "    feed_mm_per_min: 60\n    spindle_rpm: 1100\n    path:\n      \
                     program:\n        file: a.nc\n        procedure: main\n";
    assert_eq!(
        notices_of(operation, "a.nc", "G21 G0 X0 Y0 Z0\nG1 X1 F60\nG0 X2\nZ5\nG1 X3\n"),
        [
            "job.yaml:11: operation 'rough': path.program.procedure 'main' has no effect: \
                G-code has no procedures",
            "a.nc:3: 2 rapid moves, of which this is the first, run at the assumed 0.5 m/s",
        ]
    );
    let apt =
        "    feed_mm_per_min: 60\n    spindle_rpm: 1100\n    path: {program: {file: a.cls}}\n";
    assert_eq!(
        notices_of(apt, "a.cls", "GOTO/1,2,3\nRAPID\nGOTO/1,2,4\nGOTO/1,2,5\n"),
        ["a.cls:3: a rapid move runs at the assumed 0.5 m/s"]
    );
}

#[test]
fn a_start_for_joints_has_no_effect_and_says_so() {
    let job = JOB.replace("    cutting: {", "    start_near_deg: [0, 0]\n    cutting: {");
    let (_, notices) = load(&job, robot::YAML).unwrap();
    assert_eq!((notices.len(), notices[0].place.line), (1, Some(13)));
}
