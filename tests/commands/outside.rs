//! Faults that others found from outside, each as they met it.

use std::fs;

use serde_json::Value;

use crate::program::{code, err, json, repository, run};

/// A job of the six-axis arm between two poses, with pieces of it replaced.
fn job(replaced: &[(&str, &str)]) -> tempfile::TempDir {
    let robot = repository().join("robots/irb1600/robot.yaml");
    let mut text = format!(
        "robot: {}\ntool: {{teeth: 1}}\npayload: none\ntcp: {{xyz_m: [0, 0, 0.15]}}\n\
         spindle: {{min_rpm: 1000, max_rpm: 12000}}\noperations:\n  - name: a\n    spindle_rpm: 1280\n    \
         feed_mm_per_min: 400\n    path:\n      joints_deg:\n        - [0, 20, -10, 0, 60, 0]\n        \
         - [10, 25, -12, 0, 60, 0]\npolicy: {{tooth_passing_harmonics: 1}}\n",
        robot.display()
    );
    for (from, to) in replaced {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("job.yaml"), text).unwrap();
    folder
}

/// Pitches of 93, 87, 92 and 88°: the second multiple of the spindle has 4 % of what even teeth put on
/// the fourth, and a mode with 2 % damping makes 25 times of it. It was neither a line nor left out.
#[test]
fn a_weak_line_of_uneven_teeth_is_a_line() {
    let folder = job(&[
        ("{teeth: 1}", "{teeth: 4, pitch_deg: [93, 87, 92, 88]}"),
        ("tooth_passing_harmonics: 1", "tooth_passing_harmonics: 2, model_uncertainty_percent: 5"),
    ]);
    let at = |rpm: f64| -> Value {
        let text = fs::read_to_string(folder.path().join("job.yaml")).unwrap();
        let text = text.replace("spindle_rpm: 1280", &format!("spindle_rpm: {rpm}"));
        fs::write(folder.path().join("at.yaml"), text).unwrap();
        let ran = run(folder.path(), &["check", "at.yaml", "--format", "json"]);
        json(&ran)["jobs"][0]["operations"][0].clone()
    };
    let third = at(1280.0)["samples"][0]["natural_frequencies_hz"][2].as_f64().unwrap();
    let operation = at(third / 2.0 * 60.0);
    assert_eq!(operation["verdict"], "resonance");
    let crossings = operation["crossings"].as_array().unwrap();
    let is_it = |c: &&Value| c["source"] == "spindle" && c["harmonic"] == 2 && c["mode"] == 3;
    assert!(crossings.iter().any(|c| is_it(&c)), "{crossings:?}");
}

/// The only line was advised into a band that the policy ignores: nothing is checked there.
#[test]
fn advice_keeps_out_of_speeds_at_which_nothing_counts() {
    let folder =
        job(&[("tooth_passing_harmonics: 1", "tooth_passing_harmonics: 1, ignore_hz: [[48, 52]]")]);
    for objective in ["margin", "nearest"] {
        let to = format!("{objective}.yaml");
        let advise = ["advise", "job.yaml", "--objective", objective, "--format", "json"];
        let ran = run(folder.path(), &[&advise[..], &["--write", &to]].concat());
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        let checked = run(folder.path(), &["check", &to]);
        assert_eq!(code(&checked), 0, "{objective}: {}", err(&checked));
        let told = json(&ran).to_string();
        let safe = told.split("\"safe_speeds_rpm\":").nth(1).expect("safe speeds");
        let safe: Vec<[f64; 2]> =
            serde_json::Deserializer::from_str(safe).into_iter().next().unwrap().unwrap();
        assert!(!safe.is_empty());
        for [low, high] in safe {
            assert!(high <= 2880.0 || low >= 3120.0, "{low} to {high}");
        }
    }
}

/// `assume: {"R[6]": 3}`, as the guide has it, was "must be true or false".
#[test]
fn numbers_can_be_assumed() {
    let program = "/PROG A\n/MN\n1: R[1]=R[6]*2 ;\n2: L P[1] 100mm/sec FINE ;\n3: IF R[1]=6,JMP LBL[1] ;\n\
                   4: L P[9] 100mm/sec FINE ;\n5: LBL[1] ;\n6: L P[2] 100mm/sec FINE ;\n/POS\n\
                   P[1]{GP1: UF : 0, UT : 1, X = 800 mm, Y = 0 mm, Z = 500 mm, W = 180 deg, P = 0 deg, R = 0 deg};\n\
                   P[2]{GP1: UF : 0, UT : 1, X = 810 mm, Y = 0 mm, Z = 500 mm, W = 180 deg, P = 0 deg, R = 0 deg};\n/END\n";
    let text = |assumed: &str| {
        let folder = job(&[
            (
                "joints_deg:\n        - [0, 20, -10, 0, 60, 0]\n        - [10, 25, -12, 0, 60, 0]",
                "program: {file: a.ls}",
            ),
            ("feed_mm_per_min: 400", "feed_mm_per_min: 6000"),
            ("payload: none", &format!("payload: none\nassume: {{\"R[6]\": {assumed}}}")),
        ]);
        fs::write(folder.path().join("a.ls"), program).unwrap();
        let ran =
            run(folder.path(), &["check", "job.yaml", "--format", "json", "--fail-on", "never"]);
        (code(&ran), err(&ran).to_string())
    };
    let (found, said) = text("3");
    assert_eq!(found, 0, "{said}");
    let (found, said) = text("often");
    assert_eq!(found, 2, "{said}");
    assert!(
        said.contains("assume.R[6] is often, must be true or false, or a finite number"),
        "{said}"
    );
}

/// A key without a value would accept every crossing where one was meant.
#[test]
fn an_empty_key_of_an_acceptance_is_an_error() {
    for key in ["mode", "operation"] {
        let accept = format!(
            "policy: {{tooth_passing_harmonics: 1}}\naccept:\n  - {{code: crossing, {key}: , reason: x, until: \
             2999-01-01}}\n"
        );
        let folder = job(&[("policy: {tooth_passing_harmonics: 1}\n", &accept)]);
        let ran = run(folder.path(), &["check", "job.yaml"]);
        assert_eq!(code(&ran), 2, "{}", err(&ran));
        assert!(err(&ran).contains(&format!("{key} is empty")), "{}", err(&ran));
    }
}

/// A planner who lists the cutter where only programs look for it is told.
#[test]
fn keys_for_programs_are_told_where_there_is_none() {
    let keys = "payload: none\ntools: {1: {teeth: 3}}\nassume: {x: 1}\nspeeds_from: job";
    let folder = job(&[("payload: none", keys)]);
    let ran = run(folder.path(), &["check", "job.yaml"]);
    for key in ["tools", "assume", "speeds_from"] {
        let told = format!("{key} has no effect: no operation runs a program");
        assert!(err(&ran).contains(&told), "{}", err(&ran));
    }
}

/// A job may name the folder of a robot.
#[test]
fn a_robot_may_be_named_by_its_folder() {
    let file = repository().join("robots/irb1600/robot.yaml");
    let file = file.display().to_string();
    let folder = file.trim_end_matches("/robot.yaml").to_owned();
    let verdict = |text: &tempfile::TempDir| {
        let ran = run(text.path(), &["check", "job.yaml", "--format", "json"]);
        json(&ran)["jobs"][0]["operations"].clone()
    };
    assert_eq!(verdict(&job(&[(&file, &folder)])), verdict(&job(&[])));
}
