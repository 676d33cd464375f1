//! What a job leaves open is a doubt where the verdict is read.

use std::fs;

use serde_json::Value;

use crate::program::{code, json, repository, run};

/// A job on a robot of the repository: its verdict, and the warnings with their codes.
fn checked(robot: &str, job: &str) -> (String, Vec<(String, String)>) {
    let folder = tempfile::tempdir().unwrap();
    let robot = repository().join("robots").join(robot).join("robot.yaml");
    fs::write(folder.path().join("job.yaml"), format!("robot: {}\n{job}", robot.display()))
        .unwrap();
    let ran = run(folder.path(), &["check", "job.yaml", "--format", "json"]);
    let found = json(&ran);
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let job = &found["jobs"][0];
    let warnings = job["warnings"].as_array().unwrap().iter();
    let warnings = warnings.map(|one| (text(&one["code"]), text(&one["text"])));
    (text(&job["verdict"]), warnings.collect())
}

fn codes(warnings: &[(String, String)]) -> Vec<&str> {
    warnings.iter().map(|(code, _)| code.as_str()).collect()
}

const ON_RAIL: &str = "tool: {teeth: 4, diameter_mm: 10}
tcp: {xyz_m: [0, 0, 0.12]}
spindle: {min_rpm: 200, max_rpm: 30000}
policy: {min_tip_response_um_per_n: 0, tooth_passing_harmonics: 1, spindle_harmonics: 0}
operations:
  - name: edge
    spindle_rpm: 29000
    feed_mm_per_min: 3000
";

/// A rail and six joints: a pose leaves the place on the rail to the controller, joints do not.
#[test]
fn poses_of_an_arm_with_seven_joints_are_doubtful() {
    let joints =
        "    path: {joints_deg: [[200, 0, -60, 80, 0, 70, 0], [400, 0, -60, 80, 0, 70, 0]]}\n";
    let (verdict, warnings) = checked("rail-mill", &format!("{ON_RAIL}{joints}"));
    assert_eq!((verdict.as_str(), codes(&warnings)), ("clear", vec![]), "{warnings:?}");
    let poses = "    start_near_deg: [200, 0, -60, 80, 0, 70, 0]
    path:
      poses:
        - {xyz_mm: [1900, 0, 1500], rpy_deg: [0, 90, 0]}
        - {xyz_mm: [2000, 0, 1500], rpy_deg: [0, 90, 0]}
";
    let (verdict, warnings) = checked("rail-mill", &format!("{ON_RAIL}{poses}"));
    assert_eq!((verdict.as_str(), codes(&warnings)), ("uncertain", vec!["redundant_arm"]));
    assert!(warnings[0].1.contains("a pose fixes six of the 7 joints"), "{warnings:?}");
}

/// A program that states where the rail stands leaves nothing open, if the job says which axis it is.
#[test]
fn an_external_axis_that_is_mapped_leaves_no_choice() {
    let folder = tempfile::tempdir().unwrap();
    let point = |x: i32| {
        format!(
            "[[{x},0,1500],[0.7071067811865476,0,0.7071067811865476,0],[0,0,0,0],[200,9E9,9E9,9E9,9E9,9E9]]"
        )
    };
    let program = format!(
        "MODULE M\nPERS tooldata t1 := [TRUE,[[0,0,120],[1,0,0,0]],[85,[0,40,180],[1,0,0,0],1.6,1.6,0.6]];\n\
         PROC main()\nConfL\\Off;ConfJ\\Off;\nMoveJ {}, v50, fine, t1;\nMoveL {}, v50, fine, t1;\nENDPROC\nENDMODULE\n",
        point(1900),
        point(2000)
    );
    fs::write(folder.path().join("p.mod"), program).unwrap();
    let robot = repository().join("robots/rail-mill/robot.yaml");
    let verdict = |mapped: &str| {
        let job = format!(
            "robot: {}\n{mapped}{}    start_near_deg: [200, 0, -60, 80, 0, 70, 0]\n    path: {{program: {{file: \
             p.mod}}}}\n",
            robot.display(),
            ON_RAIL.replace("tcp: {xyz_m: [0, 0, 0.12]}\n", "")
        );
        fs::write(folder.path().join("job.yaml"), job).unwrap();
        let found = json(&run(folder.path(), &["check", "job.yaml", "--format", "json"]));
        let job = &found["jobs"][0];
        let all = job["warnings"].as_array().unwrap().clone();
        let is_open = all.iter().any(|one| one["code"] == "redundant_arm");
        (job["verdict"].as_str().unwrap().to_owned(), is_open)
    };
    assert_eq!(verdict(""), ("uncertain".to_owned(), true));
    assert!(!verdict("external_axes: {eax_a: track}\n").1);
}

const QUIET: &str = "spindle: {min_rpm: 500, max_rpm: 24000}
tool: {teeth: 2}
operations:
  - {name: a, spindle_rpm: 24000, feed_mm_per_min: 400, path: {joints_deg: [[0, 20, -10, 0, 60, 0], [5, 22, -12, 0, 60, 0]]}}
policy: {tooth_passing_harmonics: 1, spindle_harmonics: 0, min_tip_response_um_per_n: 0}
";

#[test]
fn a_load_that_no_tool_has_and_frames_in_degrees_are_doubted() {
    let body = |inertia: &str, com: &str| {
        format!(
            "payload: {{mass_kg: 6, com_m: [0, 0, {com}], inertia_kgm2: {{ixx: {inertia}, iyy: {inertia}, izz: {inertia}}}}}\n"
        )
    };
    for (keys, told) in [
        (body("0.02", "0.1"), None),
        (body("20", "0.1"), Some("radius of gyration is 1.826 m")),
        (body("0.02", "100"), Some("centre of mass is 100 m")),
        (body("0.02", "0.1") + "tcp: {rpy_rad: [0, 0, 45]}\n", Some("tcp: rpy_rad is [0, 0, 45]")),
        (
            body("0.02", "0.1") + "work_object: {rpy_rad: [0, -90, 0]}\n",
            Some("work_object: rpy_rad"),
        ),
        (body("0.02", "0.1") + "tcp: {rpy_rad: [0, 0, -6.28]}\n", None),
    ] {
        let (verdict, warnings) = checked("irb1600", &format!("{keys}{QUIET}"));
        let found =
            warnings.iter().find(|(code, _)| code == "inertia_extent" || code == "cad_units");
        match told {
            None => assert_eq!((verdict.as_str(), found), ("clear", None), "{keys}"),
            Some(told) => {
                assert!(found.is_some_and(|(_, what)| what.contains(told)), "{keys} {warnings:?}");
                assert_ne!(verdict, "clear", "{keys}");
            }
        }
    }
}

/// A dip of the speed of 6e-5 of the path meets a mode: the gate sees it, as the verdict does.
#[test]
fn a_short_crossing_has_its_probability() {
    let folder = tempfile::tempdir().unwrap();
    let robot = repository().join("robots/irb1600/robot.yaml");
    let job = |s: f64, low_rpm: f64| {
        format!(
            "robot: {}\npayload: none\ntool: {{teeth: 2}}\nspindle: {{min_rpm: 200, max_rpm: 24000, max_acceleration_rpm_per_s: 1e9}}\npolicy: \
             {{tooth_passing_harmonics: 1, spindle_harmonics: 0, min_tip_response_um_per_n: 0}}\noperations:\n  \
             - name: a\n    feed_mm_per_min: 400\n    spindle_schedule: [{{s: 0, rpm: 24000}}, {{s: 0.5, rpm: \
             24000}}, {{s: {}, rpm: {low_rpm}}}, {{s: {}, rpm: 24000}}, {{s: 1, rpm: 24000}}]\n    path: \
             {{joints_deg: [[0, 20, -10, 0, 60, 0], [5, 22, -12, 0, 60, 0]]}}\n",
            robot.display(),
            0.5 + s,
            0.5 + 2.0 * s
        )
    };
    let gated = |s: f64, low_rpm: f64| {
        fs::write(folder.path().join("job.yaml"), job(s, low_rpm)).unwrap();
        let gate = ["check", "job.yaml", "--fail-on", "probability=0.5", "--format", "json"];
        let ran = run(folder.path(), &gate);
        (json(&ran)["jobs"][0]["verdict"].as_str().unwrap().to_owned(), code(&ran))
    };
    for s in [3e-6, 3e-5, 1e-3] {
        assert_eq!(gated(s, 300.0), ("resonance".to_owned(), 1), "{s}");
    }
    assert_eq!(gated(3e-5, 23990.0), ("clear".to_owned(), 0));
}

/// Waypoints in radians and metres are paths of some degrees and of a millimetre: a verdict about another path.
#[test]
fn waypoints_in_other_units_are_doubted() {
    let job = |path: &str| {
        format!(
            "tool: {{teeth: 2}}\npayload: none\ntcp: {{xyz_m: [0, 0, 0.15]}}\n\
             work_object: {{xyz_m: [0.72, -0.12, 0.42]}}\n\
             spindle: {{min_rpm: 200, max_rpm: 30000}}\n\
             policy: {{tooth_passing_harmonics: 1, spindle_harmonics: 0}}\noperations:\n  \
             - {{name: edge, spindle_rpm: 29000, feed_mm_per_min: 300, path: {{{path}}}}}\n"
        )
    };
    let pose = |x: f64, y: f64| format!("{{xyz_mm: [{x}, {y}, 0.0], rpy_deg: [0, 180, 0]}}");
    let poses = |a: String, b: String| job(&format!("poses: [{a}, {b}]"));
    for (path, says) in [
        (
            job("joints_deg: [[0, 0.3491, -0.1745, 0, 1.0472, 0], [0.1, 0.4, -0.2, 0, 1.1, 0]]"),
            "in radians?",
        ),
        (poses(pose(0.04, 0.0), pose(0.125, 0.03)), "in metres?"),
    ] {
        let (verdict, warnings) = checked("irb1600", &path);
        assert_eq!(
            (verdict.as_str(), codes(&warnings)),
            ("uncertain", vec!["cad_units"]),
            "{path}"
        );
        assert!(warnings[0].1.contains(says), "{warnings:?}");
    }
    for path in [
        job("joints_deg: [[0, 20, -10, 0, 60, 0], [0.1, 20.4, -9.8, 0, 60.1, 0]]"),
        job("joints_deg: [[0, 2, -1, 0, 6, 0], [1, 2, -1, 0, 5, 0]]"),
        poses(pose(40.0, 0.0), pose(125.0, 30.0)),
        poses(pose(0.0, 0.0), pose(2.0, 1.5)),
    ] {
        let (verdict, warnings) = checked("irb1600", &path);
        assert_eq!((verdict.as_str(), codes(&warnings)), ("clear", vec![]), "{path}");
    }
}
