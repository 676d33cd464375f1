//! Changes of a turning spindle's speed, for which a spindle of a stated acceleration needs time.
//!
//! From 20 000 rpm on, two teeth pass at 667 Hz and more, where the IRB 1600 has no mode: without a warning the
//! verdict is clear.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{err, json, out, repository, run};

const ACCELERATION: &str = ", max_acceleration_rpm_per_s: 500";

fn job(acceleration: &str, operation: &str) -> String {
    let robot = repository().join("robots/irb1600/robot.yaml");
    format!(
        "robot: {}
tool: {{teeth: 2}}
payload: none
tcp: {{xyz_m: [0, 0, 0.15]}}
work_object: {{xyz_m: [0.72, -0.12, 0.42]}}
spindle: {{min_rpm: 500, max_rpm: 24000{acceleration}}}
operations:
  - {{name: rough, {operation}}}
policy: {{tooth_passing_harmonics: 1, spindle_harmonics: 0}}
",
        robot.display()
    )
}

fn bench(job: &str, file: &str, program: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(file), program).unwrap();
    fs::write(folder.path().join("job.yaml"), job).unwrap();
    folder
}

/// The verdicts of the operations, and what is doubted: the operation and the text.
fn doubts(folder: &TempDir) -> (Vec<String>, Vec<(String, String)>) {
    let ran = run(folder.path(), &["check", "job.yaml", "--format", "json"]);
    assert!(!out(&ran).is_empty(), "{}", err(&ran));
    let found = json(&ran)["jobs"][0].clone();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let verdicts = found["operations"].as_array().unwrap().iter().map(|o| text(&o["verdict"]));
    let told = found["warnings"].as_array().unwrap().iter().filter(|w| w["hides_clear"] == true);
    let told = told.map(|w| {
        assert!(w["code"] == "spindle_acceleration" || w["code"] == "schedule_timing", "{w}");
        (text(&w["operation"]), text(&w["text"]))
    });
    (verdicts.collect(), told.collect())
}

/// A milling program that goes on behind a cut at 20 000 rpm.
fn milled(acceleration: &str, behind: &str) -> TempDir {
    let program =
        format!("G21\nS20000 M3\nG0 X0 Y0 Z0\nG1 X120 F400\n{behind}\nG1 Y40 Z0 F400\nX0\nM30\n");
    let operation = "feed_mm_per_min: 400, path: {program: {file: rough.nc}}";
    bench(&job(acceleration, operation), "rough.nc", &program)
}

#[track_caller]
fn doubted(folder: &TempDir, operation: &str, parts: &[&str]) {
    let (verdicts, told) = doubts(folder);
    let [(about, text)] = told.as_slice() else { panic!("{told:?}") };
    assert_eq!(about, operation, "{text}");
    for part in parts {
        assert!(text.contains(part), "{part}: {text}");
    }
    let uncertain = verdicts.iter().filter(|verdict| *verdict == "uncertain").count();
    let clear = verdicts.iter().filter(|verdict| *verdict == "clear").count();
    assert_eq!((uncertain, clear), (1, verdicts.len() - 1), "{verdicts:?}");
}

#[track_caller]
fn clear(folder: &TempDir, operations: usize) {
    let (verdicts, told) = doubts(folder);
    assert_eq!((verdicts, told), (vec!["clear".to_owned(); operations], Vec::new()));
}

#[test]
fn a_cut_before_the_spindle_has_its_speed_is_doubted() {
    let folder = milled(ACCELERATION, "S24000");
    doubted(
        &folder,
        "rough/2",
        &[
            "rough.nc:6: ",
            "the spindle takes 8.0 s from 20000 to 24000 rpm",
            "max_acceleration_rpm_per_s is 500",
            "of which 0.0 s pass before the next cut: the speeds between are not checked",
        ],
    );
    let ran = run(folder.path(), &["check", "job.yaml"]);
    assert!(out(&ran).starts_with("UNCERTAIN"), "{}", out(&ran));
    let mut lines = out(&ran).lines().skip_while(|line| !line.contains("rough/2  UNCERTAIN"));
    let because = lines.nth(1).unwrap_or_default().trim_start();
    assert!(because.starts_with("because  rough.nc:6: the spindle takes 8.0 s"), "{}", out(&ran));
    // Slower again; the verdict is that of what follows.
    let slower = milled(ACCELERATION, "S24000\nG4 P8.0\nG1 X100\nS22000");
    doubted(&slower, "rough/3", &["takes 4.0 s from 24000 to 22000 rpm"]);
    // Without the figure nothing is known.
    clear(&milled("", "S24000"), 2);
}

#[test]
fn time_before_the_next_cut_counts() {
    clear(&milled(ACCELERATION, "S24000\nG4 P8.0"), 2);
    clear(&milled(ACCELERATION, "S24000\nG4 P5.0\nG0 Z5\nG4 P3.0"), 2);
    doubted(&milled(ACCELERATION, "S24000\nG4 P7.9"), "rough/2", &["takes 8.0 s", "which 7.9 s"]);
    // Before the command it does not.
    doubted(&milled(ACCELERATION, "G4 P8.0\nS24000"), "rough/2", &["which 0.0 s"]);
    // 80 mm at 0.5 m/s, 0.16 s, in the air.
    let air = "S24000\nG0 Z40\nG0 Z0";
    clear(&milled(", max_acceleration_rpm_per_s: 26000", air), 2);
    let slow = milled(", max_acceleration_rpm_per_s: 20000", air);
    doubted(&slow, "rough/2", &["takes 0.20 s", "which 0.16 s"]);
    // A second change starts from where the first has come to: 10 rpm in 0.02 s.
    let twice = milled(ACCELERATION, "S22000\nG0 Z10\nS24000");
    doubted(&twice, "rough/3", &["takes 8.0 s from 20010 to 24000 rpm", "which 0.0 s"]);
}

#[test]
fn a_start_is_no_change_and_a_turn_the_other_way_round_is() {
    clear(&milled(ACCELERATION, "M5\nG0 Z40\nS24000 M3\nG0 Z0"), 2);
    clear(&milled(ACCELERATION, "S20000 M3"), 1);
    let parts = ["takes 80.0 s from 20000 rpm to 20000 rpm the other way round"];
    doubted(&milled(ACCELERATION, "M4"), "rough", &parts);
    clear(&milled(ACCELERATION, "G0 Z5\nM4\nG4 P80.0"), 1);
}

#[test]
fn robot_programs_wait_for_the_spindle() {
    let target = |x: u32| format!("[[{x},0,0],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let robot = |behind: &str| {
        let program = format!(
            "MODULE Rough\nPERS tooldata t:=[TRUE,[[0,0,150],[1,0,0,0]],[4.2,[0,0,70],[1,0,0,0],0,0,0]];\n\
             PERS wobjdata w:=[FALSE,TRUE,\"\",[[760,-50,430],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n\
             CONST robtarget p1:={};\nCONST robtarget p2:={};\nPROC main()\nSetAO aoSpeed,20000;\n\
             MoveJ p1,v200,fine,t\\WObj:=w;\nMoveL p2,v10,fine,t\\WObj:=w;\n{behind}\n\
             MoveL p1,v10,fine,t\\WObj:=w;\nENDPROC\nENDMODULE\n",
            target(20),
            target(140)
        );
        let operation = "feed_mm_per_min: 600, path: {program: {file: rough.mod, spindle_from: \
                         {signal: aoSpeed, rpm_per_unit: 1}}}";
        let job = job(ACCELERATION, operation).replace("payload: none\n", "");
        bench(&job, "rough.mod", &program)
    };
    doubted(&robot("SetAO aoSpeed,24000;"), "rough/2", &["takes 8.0 s", "which 0.0 s"]);
    doubted(&robot("SetAO aoSpeed,24000;\nWaitTime 4;"), "rough/2", &["which 4.0 s"]);
    clear(&robot("SetAO aoSpeed,24000;\nWaitTime 8;"), 2);
}

/// 7000 rpm in 0.35 of 40 s: 500 rpm/s but for rounding, which was doubted.
#[test]
fn a_schedule_at_the_limit_is_not_beyond_it() {
    let pose = |x: u32| format!("{{xyz_mm: [{x}, 0, 0], rpy_deg: [0, 180, 0]}}");
    let operation = format!(
        "feed_mm_per_min: 300, spindle_schedule: [{{s: 0, rpm: 17000}}, {{s: 0.5, rpm: 17000}}, \
         {{s: 0.85, rpm: 24000}}, {{s: 1, rpm: 24000}}], path: {{poses: [{}, {}, {}]}}",
        pose(0),
        pose(100),
        pose(0)
    );
    clear(&bench(&job(ACCELERATION, &operation), "none.nc", ""), 1);
    let less = job(", max_acceleration_rpm_per_s: 499.9", &operation);
    let (verdicts, told) = doubts(&bench(&less, "none.nc", ""));
    assert_eq!((verdicts, told.len()), (vec!["uncertain".to_owned()], 1));
    assert!(told[0].1.contains("requires 500.0 rpm/s"), "{told:?}");
}

/// Without a stated acceleration a schedule is held against an assumed one, as advice is.
#[test]
fn a_schedule_is_held_against_an_assumed_acceleration() {
    let operation = |seconds: f64| {
        format!(
            "feed_mm_per_min: {}, spindle_schedule: [{{s: 0, rpm: 17000}}, {{s: 1, rpm: 24000}}], \
             path: {{joints_deg: [[0, 20, -10, 0, 60, 0], [20, 20, -10, 0, 60, 0]]}}",
            16000.0 / seconds
        )
    };
    let (verdicts, told) = doubts(&bench(&job("", &operation(1.0)), "none.nc", ""));
    assert_eq!(verdicts, ["uncertain"]);
    assert!(told[0].1.contains("is not given, and assumed to be 500"), "{told:?}");
    clear(&bench(&job("", &operation(60.0)), "none.nc", ""), 1);
}

/// A joint that is slower than its feed comes later than the schedule thinks.
#[test]
fn a_schedule_of_a_feed_that_no_joint_keeps_is_doubted() {
    let operation = |feed: u32| {
        format!(
            "feed_mm_per_min: {feed}, spindle_schedule: [{{s: 0, rpm: 20000}}, {{s: 1, rpm: 20001}}], \
             path: {{joints_deg: [[-90, 20, -10, 0, 60, 0], [90, 20, -10, 0, 60, 0]]}}"
        )
    };
    clear(&bench(&job(ACCELERATION, &operation(60_000)), "none.nc", ""), 1);
    let (verdicts, told) = doubts(&bench(&job(ACCELERATION, &operation(600_000)), "none.nc", ""));
    assert_eq!((verdicts, told.len()), (vec!["uncertain".to_owned()], 1));
    assert!(told[0].1.contains("the spindle schedule runs in time"), "{told:?}");
}
