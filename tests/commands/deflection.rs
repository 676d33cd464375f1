//! `detune deflection` as a user runs it.

use std::process::Output;

use serde_json::Value;

use crate::program::{repository, run};

fn deflection(arguments: &str) -> Output {
    let arguments: Vec<&str> =
        std::iter::once("deflection").chain(arguments.split_whitespace()).collect();
    run(repository(), &arguments)
}

fn told(arguments: &str) -> String {
    let ran = deflection(arguments);
    assert!(ran.status.success(), "{arguments}: {}", String::from_utf8_lossy(&ran.stderr));
    String::from_utf8(ran.stdout).unwrap()
}

fn json(arguments: &str) -> Value {
    serde_json::from_str(&told(&format!("{arguments} --format json"))).unwrap()
}

fn three(value: &Value) -> [f64; 3] {
    std::array::from_fn(|i| value[i].as_f64().unwrap())
}

/// The compliance ellipsoid and the deflection under a force are one matrix: C F from the axes.
#[test]
fn a_pose_has_its_ellipsoid_and_the_force_its_deflection() {
    let robot = "robots/irb1600 --at joint_2=20 --at joint_3=-15 --tcp-m 0,0,0.15";
    let found = json(&format!("{robot} --force-n 100,-50,-300"));
    assert_eq!(found["schema"], "deflection/1");
    let pose = &found["poses"][0];
    let force = three(&pose["force_n"]);
    assert_eq!(force, [100.0, -50.0, -300.0]);
    let mut expected = [0.0; 3];
    for axis in pose["principal"].as_array().unwrap() {
        let direction = three(&axis["direction"]);
        let along: f64 = direction.iter().zip(force).map(|(d, f)| d * f).sum();
        let compliance = axis["compliance_um_per_n"].as_f64().unwrap();
        (0..3).for_each(|i| expected[i] += compliance * along * direction[i]);
    }
    for (found, expected) in three(&pose["deflection_um"]).iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9 * expected.abs().max(1.0), "{found} {expected}");
    }
    // Gravity pulls down.
    assert!(three(&pose["gravity_um"])[2] < -1.0);
    let without = json(robot);
    assert!(without["poses"][0]["deflection_um"].is_null());
    assert_eq!(without["poses"][0]["gravity_um"], pose["gravity_um"]);
    let text = told(robot);
    assert!(text.contains("gravity") && text.contains("µm/N along"), "{text}");
}

#[test]
fn a_job_gives_way_along_its_path_under_the_mean_cutting_force() {
    let ran = deflection("jobs/pocket.yaml --format csv");
    assert!(ran.status.success());
    let said = String::from_utf8(ran.stderr).unwrap();
    assert!(said.contains("mean cutting force is not known"), "{said}");
    let text = String::from_utf8(ran.stdout).unwrap();
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let at = |name: &str| names.iter().position(|known| known == name).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 2 * 101);
    for row in &rows {
        let number = |name: &str| row[at(name)].parse::<f64>().ok();
        let lengths = [
            ["deflection_x_um", "deflection_y_um", "deflection_z_um"],
            ["in_tool_feed_um", "in_tool_across_um", "in_tool_axial_um"],
        ]
        .map(|names| names.map(number));
        if &row[at("operation")] == "finish" {
            assert!(lengths.iter().flatten().all(Option::is_none));
            continue;
        }
        // The same vector in two frames.
        let [base, tool] = lengths.map(|v| v.iter().map(|x| x.unwrap().powi(2)).sum::<f64>());
        assert!(base > 0.0 && (base / tool - 1.0).abs() < 1e-9, "{base} {tool}");
    }
    let ran = deflection("jobs/pocket.yaml --at joint_1=3");
    assert_eq!(ran.status.code(), Some(2));
    let ran = deflection("robots/irb1600 --force-n 1,2");
    assert_eq!(ran.status.code(), Some(2));
    let ran = deflection("robots/irb1600 --at joint_9=3");
    let said = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.code() == Some(2) && said.contains("--at"), "{said}");
}
