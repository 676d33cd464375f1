//! Intervals and probabilities as a user meets them.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::program::{code, err, flat, json, out, repository, run};

/// An arm with one spring whose load slides out: f = √(k/I)/2π falls from 42.3 to 38.0 Hz.
fn sliding(folder: &Path) {
    let k = 1e5;
    let inertia = |hz: f64| k / (2.0 * std::f64::consts::PI * hz).powi(2);
    // 1.001 kg·m² and 10 kg at x.
    let x_mm = |hz: f64| 1e3 * ((inertia(hz) - 1.001) / 10.0).sqrt();
    let body = |name: &str, mass: f64, about: f64| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"{about}\" iyy=\"{about}\" \
             izz=\"{about}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>"
        )
    };
    let urdf = format!(
        "<robot name=\"r\"><link name=\"base\"/>{}{}<link name=\"tool0\"/>\
         <joint name=\"j1\" type=\"revolute\"><parent link=\"base\"/><child link=\"a\"/><axis xyz=\"0 1 0\"/>\
         <limit lower=\"-3\" upper=\"3\" velocity=\"2\" effort=\"1\"/></joint>\
         <joint name=\"j2\" type=\"prismatic\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"1 0 0\"/>\
         <limit lower=\"0\" upper=\"2\" velocity=\"2\" effort=\"1\"/></joint>\
         <joint name=\"f\" type=\"fixed\"><parent link=\"b\"/><child link=\"tool0\"/><origin xyz=\"0.1 0 0\"/></joint>\
         </robot>",
        body("a", 10.0, 1.0),
        body("b", 10.0, 0.001)
    );
    fs::write(folder.join("r.urdf"), urdf).unwrap();
    fs::write(
        folder.join("robot.yaml"),
        format!(
            "name: one spring\nurdf: r.urdf\nelasticity:\n  joints:\n    j1: {{stiffness_nm_per_rad: {k}, \
             std_percent: 10}}\n  rigid: [j2]\ninertials:\n  a: {{std_percent: 0}}\n  b: {{std_percent: 0}}\n"
        ),
    )
    .unwrap();
    fs::write(
        folder.join("job.yaml"),
        format!(
            "name: exact\nrobot: robot.yaml\ntool: {{teeth: 2}}\npayload: none\nspindle: {{min_rpm: 100, max_rpm: \
             6000}}\noperations:\n  - name: a\n    spindle_rpm: 1350\n    feed_mm_per_min: 100\n    path: \
             {{joints_deg: [[0, {}], [0, {}]]}}\npolicy: {{tooth_passing_harmonics: 1, spindle_harmonics: 0, \
             separation_percent: 5, min_tip_response_um_per_n: 0}}\n",
            x_mm(42.3),
            x_mm(38.0)
        ),
    )
    .unwrap();
}

/// σ(ln k) = 0.10, the line at 45 Hz, the band ±5 %: P = Φ(ln(47.368/38)/0.05) − Φ(ln(42.857/42.3)/0.05) =
/// 0.39676929.
#[test]
fn the_probability_of_one_spring_is_exact() {
    let folder = tempfile::tempdir().unwrap();
    sliding(folder.path());
    let ran = run(folder.path(), &["check", "job.yaml", "--format", "json"]);
    assert_eq!(err(&ran), "");
    let found = json(&ran);
    let operation = &found["jobs"][0]["operations"][0];
    let number = |value: &Value| value.as_f64().unwrap();
    let (probability, std_error) =
        (number(&operation["probability"]), number(&operation["probability_std_error"]));
    assert!((probability - 0.396_769_29).abs() < 3.0 * std_error, "{probability} ± {std_error}");
    assert!(std_error < 1e-3, "{std_error}");
    // One operation, one line, one mode: the same for the job and for the crossing.
    assert_eq!(number(&found["jobs"][0]["probability"]), probability);
    let crossing = &operation["crossings"][0];
    assert_eq!(crossing["certainty"], "uncertain");
    assert_eq!(crossing["driver"]["parameter"], "stiffness of j1");
    assert_eq!(number(&crossing["driver"]["share"]), 1.0);
    // f e^±(1.95996 · 0.05).
    let ends = operation["samples"][0]["natural_frequencies_ci95_hz"][0].as_array().unwrap();
    for (end, expected) in ends.iter().zip([38.351_318, 46.655_245]) {
        assert!((number(end) - expected).abs() < 1e-4, "{end}");
    }
    for (gate, expected) in [("probability=0.35", 1), ("probability=0.45", 0), ("resonance", 0)] {
        let ran = run(folder.path(), &["check", "job.yaml", "--fail-on", gate]);
        assert_eq!(code(&ran), expected, "{gate}: {}", err(&ran));
    }
}

/// What a diagnosis found at the tip is what the robot's file carries: whoever states a payload replaces it.
/// f = √(k/I)/2π with I = 1.001 + 10 x² + m (x + 0.1)², m at the origin of tool0, which is
/// welded to the tip b, 0.1 m farther out.
#[test]
fn a_stated_payload_replaces_what_a_diagnosis_found_at_the_tip() {
    let folder = tempfile::tempdir().unwrap();
    sliding(folder.path());
    let [robot, job] = ["robot.yaml", "job.yaml"].map(|name| folder.path().join(name));
    let plain = fs::read_to_string(&robot).unwrap();
    let stated_none = fs::read_to_string(&job).unwrap();
    let x = ((1e5 / (2.0 * std::f64::consts::PI * 42.3_f64).powi(2) - 1.001) / 10.0).sqrt();
    let hz = |mass: f64| {
        let inertia = 1.001 + 10.0 * x * x + mass * (x + 0.1).powi(2);
        (1e5 / inertia).sqrt() / (2.0 * std::f64::consts::PI)
    };
    let correction = "corrections:\n  - {cause: payload, at: tool0, parameters: {mass_kg: 5}}\n";
    let factor = 0.25_f64;
    let learned = format!(
        "calibration: {{poses: 5, heldout_rms_percent: 1, posterior: {{parameters: [{{spring: j1, ln: 0, ln_std: \
         0.03}}, {{link: tool0, ln: {factor}, ln_std: 0.2}}, {{link: a, ln: 0, ln_std: 0.01}}], correlation: [[], \
         [0.5], [0.2, 0.1]], near_ln_std: [0.004], far_ln_std: [0.004], reach: 0.8, joints: [[0, 0]]}}}}\n"
    );
    let at_tip_and_file =
        format!("payload: {{link: b, mass_kg: 1, com_m: [0.1, 0, 0]}}\n{correction}");
    for (robot_keys, found_kg) in [
        (correction.to_owned(), 5.0),
        (format!("{correction}{learned}"), 5.0 * factor.exp()),
        (at_tip_and_file, 6.0),
    ] {
        fs::write(&robot, format!("{plain}{robot_keys}")).unwrap();
        for (payload, mass, source) in [
            ("", found_kg, "robot"),
            ("payload: none\n", 0.0, "none"),
            ("payload: {mass_kg: 3, com_m: [0.1, 0, 0]}\n", 3.0, "job"),
            ("payload: {mass_kg: 5, com_m: [0.1, 0, 0]}\n", 5.0, "job"),
        ] {
            fs::write(&job, stated_none.replace("payload: none\n", payload)).unwrap();
            let found = json(&run(folder.path(), &["check", "job.yaml", "--format", "json"]));
            let operation = &found["jobs"][0]["operations"][0];
            let carried = &operation["payload"];
            assert_eq!(carried["source"], source, "{robot_keys}{payload}");
            let kg = carried["mass_kg"].as_f64().unwrap();
            assert!((kg - mass).abs() < 1e-9, "{robot_keys}{payload}: {kg} kg");
            let first = operation["samples"][0]["natural_frequencies_hz"][0].as_f64().unwrap();
            assert!((first / hz(mass) - 1.0).abs() < 1e-6, "{robot_keys}{payload}: {first} Hz");
            assert!(!found.to_string().contains("payload_unknown"), "{found}");
        }
    }
    // On another link than the tip's it is no payload of a job.
    fs::write(&robot, format!("{plain}{}", correction.replace("tool0", "a"))).unwrap();
    fs::write(&job, stated_none.replace("payload: none\n", "")).unwrap();
    let found = json(&run(folder.path(), &["check", "job.yaml", "--format", "json"]));
    let operation = &found["jobs"][0]["operations"][0];
    assert_eq!(operation["payload"]["source"], "unknown");
}

/// What is accepted has its own probability, but no part in that of the operation, of the job, and of the gate.
#[test]
fn what_is_accepted_has_no_part_in_the_probability() {
    let folder = tempfile::tempdir().unwrap();
    sliding(folder.path());
    let file = folder.path().join("job.yaml");
    let job = fs::read_to_string(&file).unwrap();
    let check = |accept: &str, arguments: &[&str]| {
        fs::write(&file, format!("{job}{accept}")).unwrap();
        run(folder.path(), &[&["check", "job.yaml"], arguments].concat())
    };
    let gate = ["--fail-on", "probability=0.01"];
    assert_eq!(code(&check("", &gate)), 1);
    let entry = |mode: usize| {
        format!(
            "accept: [{{code: crossing, mode: {mode}, reason: ran without marks, until: 2999-12-31}}]\n"
        )
    };
    let accepted = check(&entry(1), &gate);
    assert_eq!(code(&accepted), 0, "{}", err(&accepted));
    let found = json(&check(&entry(1), &["--format", "json"]));
    let operation = &found["jobs"][0]["operations"][0];
    // Below one in 4096.
    assert_eq!(operation["probability"].as_f64(), Some(1.0 / 4096.0));
    assert_eq!(found["jobs"][0]["probability"], operation["probability"]);
    let own = operation["crossings"][0]["probability"].as_f64().unwrap();
    assert!((own - 0.396_769_29).abs() < 3e-3, "{own}");
    // Another mode is another matter.
    assert_eq!(code(&check(&entry(2), &gate)), 1);
    // Advice keeps clear of it all the same, and says so.
    fs::write(&file, format!("{job}{}", entry(1))).unwrap();
    let advised = run(folder.path(), &["advise", "job.yaml"]);
    let said = "accepted until 2999-12-31: ran without marks; crossings of mode 1, which advice avoids all the same";
    assert!(flat(&advised).contains(said), "{}", flat(&advised));
    let safe = |accept: &str| {
        fs::write(&file, format!("{job}{accept}")).unwrap();
        let found = json(&run(folder.path(), &["advise", "job.yaml", "--format", "json"]));
        found["operations"][0]["safe_speeds_rpm"].clone()
    };
    assert_eq!(safe(&entry(1)), safe(""));
}

/// A stated deviation of one number makes no other number exact: where the links say nothing, the interval is not
/// narrower than f (1 ± 10 %).
#[test]
fn what_is_not_stated_is_not_exact() {
    let folder = tempfile::tempdir().unwrap();
    sliding(folder.path());
    let half = |from: &str, to: &str| -> f64 {
        let file = folder.path().join("robot.yaml");
        let text = fs::read_to_string(&file).unwrap();
        assert!(text.contains(from), "{text}");
        fs::write(&file, text.replace(from, to)).unwrap();
        let ran = run(folder.path(), &["check", "job.yaml", "--format", "json"]);
        let sample = &json(&ran)["jobs"][0]["operations"][0]["samples"][0];
        let ends = &sample["natural_frequencies_ci95_hz"][0];
        0.5 * (ends[1].as_f64().unwrap() / ends[0].as_f64().unwrap()).ln()
    };
    // All stated: 1.95996 · 0.5 · 1 %.
    assert!((half("std_percent: 10", "std_percent: 1") - 0.0098).abs() < 1e-4);
    assert!((half("  b: {std_percent: 0}\n", "") - 0.1).abs() < 1e-9);
    // All exact: no width, whether one number less exact stands beside them or not.
    half("  a: {std_percent: 0}\n", "  a: {std_percent: 0}\n  b: {std_percent: 0}\n");
    assert_eq!(half("std_percent: 1}", "std_percent: 0}"), 0.0);
}

/// Modes 1 to 3 measured at twelve poses of an arm whose joint 5 is softer than its file says: the calibration knows
/// nothing of mode 5, and a line on it is not clear.
#[test]
fn what_was_not_measured_is_not_better_known() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let robot = repository().join("robots/irb1600");
    let nominal = fs::read_to_string(robot.join("robot.yaml")).unwrap();
    let urdf = format!("urdf: {}", robot.join("irb1600.urdf").display());
    let nominal = nominal.replace("urdf: irb1600.urdf", &urdf);
    let truth = nominal
        .replace("joint_5: {stiffness_nm_per_rad: 50000", "joint_5: {stiffness_nm_per_rad: 39500");
    assert_ne!(nominal, truth);
    fs::write(path("nominal.yaml"), nominal).unwrap();
    fs::write(path("truth.yaml"), truth).unwrap();
    let map = run(folder.path(), &["map", "truth.yaml", "--random", "12", "--seed", "3"]);
    let mut table = String::new();
    for line in out(&map).lines() {
        // Six joints, β2, three of six modes.
        let cells: Vec<&str> = line.split(',').collect();
        let kept: Vec<&str> = cells[..6].iter().chain(&cells[7..10]).copied().collect();
        table += &(kept.join(",") + "\n");
    }
    fs::write(path("measured.csv"), table).unwrap();
    let arguments = ["diagnose", "nominal.yaml", "measured.csv", "--write", "calibrated.yaml"];
    let ran = run(folder.path(), &arguments);
    assert_eq!(code(&ran), 0, "{}", err(&ran));

    let at = ["--at", "joint_2=20", "--at", "joint_3=-10", "--at", "joint_5=60"];
    let sweep = ["--joint", "joint_1", "--from-deg", "0", "--to-deg", "2", "--steps", "2"];
    let five = |robot: &str| -> f64 {
        let ran = run(folder.path(), &[&["map", robot][..], &sweep, &at].concat());
        let row = out(&ran).lines().nth(1).unwrap_or_else(|| panic!("{}", err(&ran)));
        row.split(',').nth(7 + 4).unwrap().parse().unwrap()
    };
    // Half a per cent off mode 5 as it is.
    let rpm = 1.005 * five("truth.yaml") * 60.0 / 2.0;
    fs::write(
        path("job.yaml"),
        format!(
            "name: a\nrobot: calibrated.yaml\ntool: {{teeth: 2}}\npayload: none\nspindle: {{min_rpm: 500, max_rpm: \
             20000}}\noperations:\n  - name: a\n    spindle_rpm: {rpm}\n    feed_mm_per_min: 400\n    path: \
             {{joints_deg: [[0, 20, -10, 0, 60, 0], [2, 20, -10, 0, 60, 0]]}}\npolicy: {{tooth_passing_harmonics: 1, \
             spindle_harmonics: 0, separation_percent: 5, min_tip_response_um_per_n: 0}}\n"
        ),
    )
    .unwrap();
    let ran = run(folder.path(), &["check", "job.yaml", "--format", "json", "--fail-on", "never"]);
    let found = json(&ran);
    assert_ne!(found["verdict"], "clear", "{}", found["jobs"][0]["model"]);
    let sample = &found["jobs"][0]["operations"][0]["samples"][0];
    let share = |mode: usize| -> f64 {
        let ends = &sample["natural_frequencies_ci95_hz"][mode];
        let [low, high] = [0, 1].map(|end| ends[end].as_f64().unwrap());
        0.5 * (high - low) / sample["natural_frequencies_hz"][mode].as_f64().unwrap()
    };
    // What was measured is known to some per mille; mode 5 no better than before.
    assert!(share(0) < 0.02, "{}", share(0));
    assert!(share(4) > 0.07, "{}", share(4));
}

/// Mode 6 turns the flange about its own axis: that it hardly moves the tool holds for a tool of no length alone,
/// and is told where the verdict is read. A tcp that is stated, or a limit, settles it.
#[test]
fn a_mode_that_is_left_out_for_want_of_a_tcp_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let robot = repository().join("robots/irb1600/robot.yaml");
    let shown = |more: &str, rpm: u32| {
        let job = format!(
            "name: a\nrobot: {}\ntool: {{teeth: 2}}\npayload: none\nspindle: {{min_rpm: 500, max_rpm: 30000}}\n{more}\
             operations:\n  - name: a\n    spindle_rpm: {rpm}\n    feed_mm_per_min: 600\n    path: {{joints_deg: \
             [[0, 20, -10, 0, 60, 0], [10, 25, -12, 0, 60, 0]]}}\n",
            robot.display()
        );
        fs::write(folder.path().join("job.yaml"), job).unwrap();
        let ran = run(folder.path(), &["check", "job.yaml", "--fail-on", "never"]);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        flat(&ran)
    };
    let told = "left out mode 6 (below 0.705 µm/N); no tcp is stated: mode 6 hardly moves the robot's tip, at which \
                the tool is taken to end, and is left out; a line of 1200.0 Hz meets it";
    let found = shown("", 18000);
    assert!(found.contains(told), "{found}");
    for (more, rpm) in [
        ("tcp: {xyz_m: [0, 0, 0]}\n", 18000),
        ("policy: {min_tip_response_um_per_n: 0.7}\n", 18000),
        ("", 9000),
    ] {
        let found = shown(more, rpm);
        assert!(found.contains("left out mode 6") && !found.contains("no tcp"), "{found}");
    }
}
