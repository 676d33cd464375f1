//! `diagnose` as a user meets it: the paper's own data, a hidden effect of each kind, faults, files.

use std::process::Output;
use std::sync::OnceLock;

use detune::input::{Reading, read_robot};
use detune::notes::Code;
use serde_json::Value;

use crate::program::{self, code, err, out, repository};
use crate::two_link::TABLE_1;

fn detune(arguments: &[&str]) -> Output {
    program::run(repository(), arguments)
}

fn json(arguments: &[&str]) -> Value {
    let output = detune(arguments);
    assert!(output.status.success(), "{}", err(&output));
    program::json(&output)
}

/// The paper's measured columns diagnosed, and the robot that is written.
fn measured() -> &'static (Value, String) {
    static RUN: OnceLock<(Value, String)> = OnceLock::new();
    RUN.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let robot = folder.path().join("arm.yaml");
        let table = "robots/two-link/measured.csv";
        let arguments = ["diagnose", "robots/two-link", table, "--format", "json", "--write"];
        let found = json(&[&arguments[..], &[robot.to_str().unwrap()]].concat());
        (found, std::fs::read_to_string(robot).unwrap())
    })
}

/// The bytes of a diagnosis of the paper's simulated columns.
fn simulated(threads: &str) -> Vec<u8> {
    let table = "robots/two-link/simulated.csv";
    let arguments = ["diagnose", "robots/two-link", table, "--format", "json", "--seed", "1"];
    let mut command = program::command(repository(), &arguments);
    let output = command.env("RAYON_NUM_THREADS", threads).output().unwrap();
    assert!(output.status.success(), "{}", err(&output));
    output.stdout
}

/// The same on three threads.
fn simulated_on_three() -> &'static [u8] {
    static RUN: OnceLock<Vec<u8>> = OnceLock::new();
    RUN.get_or_init(|| simulated("3"))
}

/// Table 1 as printed is off by 171 % from the measured columns of Table 2; what the diagnosis finds brings
/// poses left out to 4.8 %, the simulated columns to 2.3 %. At the paper's β1 the foundation's compliance shows.
#[test]
fn the_papers_own_data() {
    let simulated = serde_json::from_slice(simulated_on_three()).unwrap();
    for (table, found, before, after) in [
        ("measured", &measured().0, [150.0, 190.0], 4.8),
        ("simulated", &simulated, [150.0, 190.0], 2.3),
    ] {
        assert_eq!(found["schema"], "diagnosis/1");
        assert_eq!(found["verdict"], "explained", "{table}");
        let error = |of: &str| found[of]["heldout_rms_percent"].as_f64().unwrap();
        assert!(
            (before[0]..before[1]).contains(&error("baseline")),
            "{table} {}",
            error("baseline")
        );
        assert!(error("extended") <= after, "{table} {}", error("extended"));
    }
    let measured = &measured().0;
    assert_eq!(causes(measured), ["link_inertia", "base_compliance"]);
    let inertia = &measured["findings"][0]["parameters"][0]["ci95"];
    let [low, high] = [0, 1].map(|end| inertia[end].as_f64().unwrap());
    // Which other models the search meets moves with the last place of a root, as without fused multiplication.
    let is_near = |end: f64, expected: f64| (end / expected - 1.0).abs() < 2e-3;
    assert!(is_near(low, 1481.0) && is_near(high, 2072.0), "{low} {high}");
}

/// The paper moves its second joint alone. Its causes are named all the same, with the doubt beside the verdict.
#[test]
fn several_causes_by_a_table_along_one_joint_are_doubtful_together() {
    let notices = measured().0["notices"].as_array().unwrap();
    let doubt = "only joint_2 moves in the rows that are used";
    assert!(notices.iter().any(|notice| notice.as_str().unwrap().starts_with(doubt)));
    let text = detune(&["diagnose", "robots/two-link", "robots/two-link/measured.csv"]);
    assert!(out(&text).contains(&format!("But {doubt}")), "{}", out(&text));
}

fn causes(found: &Value) -> Vec<&str> {
    let findings = found["findings"].as_array().unwrap();
    findings.iter().map(|finding| finding["cause"].as_str().unwrap()).collect()
}

/// Without β1 nothing is said of what depends on it: gravity and the foundation.
#[test]
fn causes_that_depend_on_a_joint_that_is_not_stated_are_not_tested() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("t.csv");
    let whole = program::first_rows("measured.csv", 6);
    let rows = whole.lines().map(|row| format!("{}\n", row.split_once(',').unwrap().1));
    let rows: String = rows.collect();
    std::fs::write(&table, rows).unwrap();
    let table = table.to_str().unwrap();
    let output = detune(&["diagnose", "robots/two-link", table, "--format", "json"]);
    let told = err(&output);
    assert!(told.contains("t.csv:1: joint_1 is not stated: it is taken as 0"), "{told}");
    assert!(told.contains("give beta1_rad"), "{told}");
    let found = program::json(&output);
    let untested: Vec<(&str, bool)> = found["untested"]
        .as_array()
        .unwrap()
        .iter()
        .inspect(|untested| assert_eq!(untested["joints"], serde_json::json!(["joint_1"])))
        .map(|u| (u["cause"].as_str().unwrap(), u["in_part"].as_bool().unwrap()))
        .collect();
    assert_eq!(
        untested,
        [
            // A foundation that turns about the upright or gives alike to all sides.
            ("base_compliance", true),
            ("load_dependent_stiffness", false),
            ("load_dependent_stiffness", false),
            ("gravity_stiffness", false),
        ]
    );
    assert!(!causes(&found).contains(&"load_dependent_stiffness"), "{found}");
    assert!(measured().0.get("untested").is_none());
    // The wrist's angles move the frequencies of the whole arm.
    let output = detune(&["diagnose", "robots/irb1600", table]);
    assert!(err(&output).contains("own frequencies depend on"), "{}", err(&output));
}

/// The interval of the angle about which frequencies mirror, in degrees.
fn mirror(found: &Value, of: &str) -> [f64; 2] {
    let ci95 = &found["symmetry"][of]["ci95_rad"];
    [0, 1].map(|end| ci95[end].as_f64().unwrap().to_degrees())
}

/// The paper's model depends on cos β2 alone, yet its simulated columns repeat from 1.571 and 1.920 rad to −1.920
/// and −2.269 rad: about −10°.
#[test]
fn the_papers_columns_mirror_about_another_angle_than_zero() {
    let simulated = serde_json::from_slice(simulated_on_three()).unwrap();
    for (found, width) in [(&simulated, 3.0), (&measured().0, 9.0)] {
        assert_eq!(found["symmetry"]["angle"], "beta2");
        assert_eq!(found["symmetry"]["differ"], true);
        let [low, high] = mirror(found, "measured");
        assert!(low < -10.0 && high > -10.0 && high - low < width, "{low} {high}");
        let [low, high] = mirror(found, "model");
        assert!(low < 0.0 && high > 0.0 && high - low < 2.0, "{low} {high}");
        let offset = found["symmetry"]["zero_offset_rad"].as_f64().unwrap().to_degrees();
        assert!((offset - 11.0).abs() < 1.0, "{offset}");
    }
}

/// Frequencies in closed form of an arm whose second zero is off by 8°, rounded to 0.01 Hz; and with no offset.
#[test]
fn a_joint_whose_zero_is_off_mirrors_about_another_angle() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("t.csv");
    let found = |offset_deg: f64| {
        let mut rows = "beta1_rad,beta2_rad,f1_hz,f2_hz\n".to_owned();
        for i in -10..=12 {
            let beta2 = 0.2 * f64::from(i);
            let [f1, f2] = TABLE_1.natural_frequencies_hz(beta2 + offset_deg.to_radians());
            rows += &format!("0.3,{beta2},{f1:.2},{f2:.2}\n");
        }
        std::fs::write(&table, rows).unwrap();
        json(&["diagnose", "robots/two-link", table.to_str().unwrap(), "--format", "json"])
    };
    let shifted = found(8.0);
    let [low, high] = mirror(&shifted, "measured");
    assert!(low < -8.0 && high > -8.0 && high - low < 2.0, "{low} {high}");
    let offset = shifted["symmetry"]["zero_offset_rad"].as_f64().unwrap().to_degrees();
    assert!((offset - 8.0).abs() < 0.5, "{offset}");
    assert_eq!(causes(&shifted), ["joint_zero_offset"]);
    let straight = found(0.0);
    assert_eq!(straight["symmetry"]["differ"], false);
    assert_eq!(straight["symmetry"]["zero_offset_rad"], Value::Null);
}

/// What --write writes is what check and map read, from another folder: the frequencies that the diagnosis
/// promised, twice the held-out error for an uncertainty, and the comments of the file.
#[test]
fn the_written_robot_is_what_check_uses() {
    let folder = tempfile::tempdir().unwrap();
    let written = folder.path().join("arm.yaml");
    let (found, file) = measured();
    std::fs::write(&written, file).unwrap();
    let heldout = found["extended"]["heldout_rms_percent"].as_f64().unwrap();
    let job = folder.path().join("job.yaml");
    std::fs::write(
        &job,
        "name: a\nrobot: arm.yaml\ntool: {teeth: 2, payload: none}\nspindle: {min_rpm: 500, max_rpm: 6000}\noperations:\n  \
         - name: a\n    spindle_rpm: 1100\n    feed_mm_per_min: 400\n    path: {joints_deg: [[120, 20], [120, 90]]}\n",
    )
    .unwrap();
    let checked = json(&["check", job.to_str().unwrap(), "--format", "json", "--fail-on", "never"]);
    let model = &checked["jobs"][0]["model"];
    assert_eq!(model["calibrated"], true);
    // The two modes that were measured, and not the foundation's own, which no row has: 95 % intervals, of an
    // error that contains the noise.
    let samples = checked["jobs"][0]["operations"][0]["samples"].as_array().unwrap();
    let half_width = |sample: &Value, mode: usize| {
        let interval = &sample["natural_frequencies_ci95_hz"][mode];
        let [low, high] = [0, 1].map(|end| interval[end].as_f64().unwrap());
        50.0 * (high / low).ln()
    };
    let uncertainty =
        samples.iter().flat_map(|s| [0, 1].map(|mode| half_width(s, mode))).fold(0.0, f64::max);
    assert!((heldout..2.5 * heldout).contains(&uncertainty), "{uncertainty} {heldout}");
    // Less than the 10 % either way of a robot that was never measured.
    let never_measured = 50.0 * (1.1_f64 / 0.9).ln();
    assert!(uncertainty < never_measured, "{uncertainty} {never_measured}");
    let table = std::fs::read_to_string("robots/two-link/measured.csv").unwrap();
    let poses = table.lines().filter(|line| !line.starts_with(['#', 'b'])).map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        format!("{},{}\n", cells[0], cells[1])
    });
    let rows: String = poses.collect();
    let table = folder.path().join("poses.csv");
    std::fs::write(&table, format!("joint_1_rad,joint_2_rad\n{rows}")).unwrap();
    let arguments = ["map", written.to_str().unwrap(), "--poses", table.to_str().unwrap()];
    let map = detune(&arguments);
    let mapped: Vec<Vec<f64>> = out(&map)
        .lines()
        .skip(1)
        .map(|line| line.split(',').skip(3).map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let residuals = found["residuals"].as_array().unwrap();
    assert_eq!(residuals.len(), 40);
    for residual in residuals {
        let index = |key: &str| residual[key].as_u64().unwrap() as usize;
        let promised = residual["calibrated_hz"].as_f64().unwrap();
        let mapped = mapped[index("row")][index("mode") - 1];
        assert!(
            (mapped / promised - 1.0).abs() < 1e-6,
            "{mapped} Hz mapped, {promised} Hz promised"
        );
    }
    assert!(file.contains("# The paper's arm with its Table 1 as printed"), "{file}");
    assert!(
        file.contains("\n    ci95: {") && file.contains("\ncalibration: {poses: 20, "),
        "{file}"
    );
    let cause = found["findings"][0]["cause"].as_str().unwrap();
    assert!(file.contains(&format!("  - cause: {cause}\n")), "{file}");
}

/// A robot that was calibrated with a table and is diagnosed by it again starts without what was fitted to that table:
/// the same figures and the same file, whatever comments the table has got, and no error at fitted poses is called
/// held out.
#[test]
fn the_same_table_twice_gives_the_same_robot() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let measured = program::every_other_row("measured.csv");
    std::fs::create_dir(folder.path().join("before")).unwrap();
    std::fs::write(path("before/measured.csv"), &measured).unwrap();
    std::fs::write(path("measured.csv"), format!("# again\r\n{}", measured.replace('\n', "\r\n")))
        .unwrap();
    let run = |robot: &str, table: &str, written: &str| -> (Value, String, String) {
        let arguments = ["diagnose", robot, table, "--format", "json", "--write", written];
        let output = detune(&arguments);
        assert!(output.status.success(), "{}", err(&output));
        let file = std::fs::read_to_string(written).unwrap();
        (serde_json::from_slice(&output.stdout).unwrap(), err(&output).to_owned(), file)
    };
    let (mut first, told, once) =
        run("robots/two-link", &path("before/measured.csv"), &path("a.yaml"));
    assert!(!told.contains("fitted"), "{told}");
    assert!(once.contains("\n  fitted_to: [\n    {file: measured.csv, digest: fnv1a-"), "{once}");
    let (mut second, told, twice) = run(&path("a.yaml"), &path("measured.csv"), &path("b.yaml"));
    assert!(told.contains("were fitted to poses of this table"), "{told}");
    let fitted_again = second.as_object_mut().unwrap().remove("fitted_again").unwrap();
    assert_eq!(fitted_again.as_array().unwrap().len(), 2);
    let again = second["notices"].as_array_mut().unwrap().remove(0);
    assert!(again.as_str().unwrap().contains("fitted to poses of this table"), "{again}");
    assert!(first.as_object_mut().unwrap().remove("fitted_again").is_none());
    assert!(first == second, "{first}\n{second}");
    let undated = |file: &str| -> String {
        let lines = file.lines().map(|line| line.split(", date: ").next().unwrap());
        lines.collect::<Vec<_>>().join("\n")
    };
    assert_eq!(undated(&once), undated(&twice));
    // Where nothing says what the corrections were fitted to, the calibration claims no less than
    // before, however often it is written.
    let unnamed: String = once
        .split_inclusive('\n')
        .filter(|line| !line.trim_start().starts_with("table:"))
        .collect();
    let end = unnamed.find("calibration:").unwrap();
    let old = "calibration: {poses: 20, heldout_rms_percent: 4.6, date: 2026-11-01}\n";
    std::fs::write(path("old.yaml"), format!("{}{old}", &unnamed[..end])).unwrap();
    let (_, _, third) = run(&path("old.yaml"), &path("measured.csv"), &path("c.yaml"));
    let (_, told, fourth) = run(&path("c.yaml"), &path("measured.csv"), &path("d.yaml"));
    assert!(told.contains("does not say which poses"), "{told}");
    for file in [third, fourth] {
        assert!(file.contains("heldout_rms_percent: 4.6,"), "{file}");
    }
}

/// What `map` writes is what the model says: nothing is wrong with it, to the last digit.
#[test]
fn a_table_of_the_models_own_frequencies_is_consistent() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("map.csv");
    let table = table.to_str().unwrap();
    for robot in ["robots/two-link", "robots/irb1600"] {
        let range = ["--joint", "joint_2", "--from-deg", "-20", "--to-deg", "60", "--steps", "12"];
        let mapped = detune(&[&["map", robot, "--output", table][..], &range[..]].concat());
        assert!(mapped.status.success(), "{}", err(&mapped));
        let found = json(&["diagnose", robot, table, "--format", "json"]);
        assert_eq!(found["verdict"], "consistent", "{robot}: {found}");
        assert!(
            found["gain"]["percent_points"] == 0.0 && found["findings"] == serde_json::json!([])
        );
    }
}

/// A digit that slipped in one frequency is no noise: the row is named where the verdict is read.
#[test]
fn one_frequency_that_is_far_off_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("map.csv");
    let table = table.to_str().unwrap();
    let range = ["--joint", "joint_2", "--from-deg", "-20", "--to-deg", "60", "--steps", "16"];
    let mapped = detune(&[&["map", "robots/irb1600", "--output", table][..], &range[..]].concat());
    assert!(mapped.status.success(), "{}", err(&mapped));
    let text = std::fs::read_to_string(table).unwrap();
    let column = text.lines().next().unwrap().split(',').position(|name| name == "f3_hz").unwrap();
    let slipped = |(at, line): (usize, &str)| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if at == 6 {
            cells[column] = format!("{:.3}", 0.9 * cells[column].parse::<f64>().unwrap());
        }
        cells.join(",") + "\n"
    };
    std::fs::write(table, text.lines().enumerate().map(slipped).collect::<String>()).unwrap();
    let output = detune(&["diagnose", "robots/irb1600", table]);
    let (shown, told) = (out(&output), err(&output));
    assert!(shown.starts_with("UNEXPLAINED") && !shown.contains("\n1. "), "{shown}");
    assert!(shown.replace('\n', " ").contains("row 6 of the table"), "{shown}");
    assert!(!shown.contains("set aside") && !told.contains("set aside"), "{shown}{told}");
}

/// A robot of the repository in a folder, with every spring by a factor.
fn scaled(folder: &std::path::Path, of: &str, factor: f64) -> String {
    let from = repository().join("robots/irb1600");
    let to = folder.join(format!("{of}-{factor}"));
    std::fs::create_dir(&to).unwrap();
    std::fs::copy(from.join("irb1600.urdf"), to.join("irb1600.urdf")).unwrap();
    let yaml = std::fs::read_to_string(from.join("robot.yaml")).unwrap();
    let line = |line: &str| match line.split_once("stiffness_nm_per_rad: ") {
        Some((key, rest)) if of == "all" || key.contains(of) => {
            let (k, rest) = rest.split_at(rest.find([',', '}']).unwrap());
            format!("{key}stiffness_nm_per_rad: {}{rest}\n", factor * k.parse::<f64>().unwrap())
        }
        _ => format!("{line}\n"),
    };
    std::fs::write(to.join("robot.yaml"), yaml.lines().map(line).collect::<String>()).unwrap();
    to.join("robot.yaml").to_str().unwrap().to_owned()
}

fn mapped(robot: &str, count: &str, seed: &str, folder: &std::path::Path) -> String {
    let table = folder.join("map.csv");
    let table = table.to_str().unwrap();
    let random = ["--random", count, "--seed", seed, "--output", table];
    let ran = detune(&[&["map", robot][..], &random[..]].concat());
    assert!(ran.status.success(), "{}", err(&ran));
    std::fs::read_to_string(table).unwrap()
}

/// A soft joint is found, and the slip beside it is named.
#[test]
fn a_slip_beside_a_cause_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let soft = scaled(folder.path(), "joint_3", 0.75);
    let text = mapped(&soft, "20", "3", folder.path());
    let column = text.lines().next().unwrap().split(',').position(|name| name == "f2_hz").unwrap();
    let with = |factor: f64| {
        let line = |(at, line): (usize, &str)| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if at == 12 {
                cells[column] = format!("{:.3}", factor * cells[column].parse::<f64>().unwrap());
            }
            cells.join(",") + "\n"
        };
        let path = folder.path().join("table.csv");
        std::fs::write(&path, text.lines().enumerate().map(line).collect::<String>()).unwrap();
        detune(&["diagnose", "robots/irb1600", path.to_str().unwrap()])
    };
    let (sound, slipped) = (with(1.0), with(1.15));
    for ran in [&sound, &slipped] {
        assert!(out(ran).contains("joint_stiffness at joint_3"), "{}", out(ran));
    }
    let names = |ran: &Output| {
        let told =
            format!("{}{}", out(ran), err(ran)).split_whitespace().collect::<Vec<_>>().join(" ");
        told.contains("row 12, f2:") && told.contains("times the scatter of the others")
    };
    assert!(names(&slipped), "{}{}", out(&slipped), err(&slipped));
    assert!(!names(&sound), "{}", err(&sound));
}

/// The file states the springs at the table's own temperature: that is no change of them.
#[test]
fn a_law_of_temperature_is_no_change_after_the_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = String::new();
    for (i, t) in [21.0, 24.0, 27.0, 30.0, 33.0, 36.0].into_iter().enumerate() {
        let robot = scaled(folder.path(), "all", 1.0 - 0.008 * (t - 20.0));
        let text = mapped(&robot, "4", &i.to_string(), folder.path());
        let mut lines = text.lines();
        let head = lines.next().unwrap();
        if table.is_empty() {
            table = format!("{head},temperature_c\n");
        }
        lines.for_each(|line| table.push_str(&format!("{line},{t}\n")));
    }
    let path = folder.path().join("table.csv");
    std::fs::write(&path, table).unwrap();
    let written = folder.path().join("calibrated.yaml");
    let [path, written] = [&path, &written].map(|path| path.to_str().unwrap());
    let ran = detune(&["diagnose", "robots/irb1600", path, "--write", written]);
    assert!(out(&ran).contains("temperature_drift at all"), "{}", out(&ran));
    let mut reading = Reading::default();
    read_robot(std::path::Path::new(written), &mut reading).unwrap();
    // A job does not state its temperature: that is a doubt, and the only one.
    let told: Vec<_> = reading.warnings.iter().filter(|w| w.code == Code::Calibration).collect();
    let [one] = &told[..] else { panic!("{told:?}") };
    assert!(one.what.contains("vary with temperature") && one.what.contains(" °C"), "{one}");
}

/// One pose that is measured twelve times is one state: no other can be left out, so nothing is gained and the
/// error is no smaller than before.
#[test]
fn repeated_rows_are_no_poses() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("same.csv");
    let rows = "0.3,0.6,12.5,50.1\n".repeat(12);
    std::fs::write(&table, format!("joint_1_rad,joint_2_rad,f1_hz,f2_hz\n{rows}")).unwrap();
    let table = table.to_str().unwrap();
    let output = detune(&["diagnose", "robots/two-link", table, "--format", "json"]);
    assert_eq!(code(&output), 0);
    let told = err(&output);
    assert!(told.contains("the table has 1 state (poses, loads, conditions"), "{told}");
    let found = program::json(&output);
    assert!(found["verdict"] != "explained", "{found}");
    assert_eq!(found["gain"]["percent_points"], 0.0);
    let held_out = |of: &str| found[of]["heldout_rms_percent"].as_f64().unwrap();
    assert_eq!(held_out("extended"), held_out("baseline"));
}

#[test]
fn report_and_robot_do_not_share_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.yaml");
    let file = file.to_str().unwrap();
    let measured = "robots/two-link/measured.csv";
    let output =
        detune(&["diagnose", "robots/two-link", measured, "--write", file, "--output", file]);
    assert_eq!(code(&output), 2);
    assert!(err(&output).contains("--write and --output name the same file"));
    assert!(!std::path::Path::new(file).exists());
}

/// Nothing is written over what the run reads.
#[test]
fn the_robots_own_file_is_spared() {
    let robot = "robots/two-link/robot.yaml";
    let measured = "robots/two-link/measured.csv";
    for output in ["--write", "--output"] {
        let ended = detune(&["diagnose", robot, measured, output, robot]);
        assert_eq!(code(&ended), 2);
        assert!(err(&ended).contains("is read by this run"), "{}", err(&ended));
    }
}

/// The same seed gives the same bytes, whatever the number of threads.
#[test]
fn the_same_seed_gives_the_same_bytes() {
    assert!(simulated("1") == simulated_on_three());
}

#[test]
fn bad_tables_are_told_and_nothing_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("t.csv");
    for (content, told) in [
        ("beta2_rad\n1\n", "no column 'f1_hz'"),
        ("beta2_rad,f1_hz,f2_hz\n1,30,20\n", "f2_hz is 20, must not be less than f1_hz"),
        ("beta2_rad,f1_hz\n1,-3\n", "f1_hz is -3, must be positive"),
        ("beta2_rad,f1_hz\n1,x\n", "f1_hz is 'x', must be a finite number"),
        (
            "beta2_rad,f1_hz,f2_hz\n1,20,40\n",
            "too little data for a diagnosis: 2 frequencies, must be at least 5",
        ),
        (
            "beta2_rad,f1_hz\n0,20\n1,21\n2,22\n3,23\n",
            "too little data for a diagnosis: 4 frequencies, must be at least 5",
        ),
        ("beta2_rad,f1_hz\n1,\n", "t.csv: has no frequency in any row"),
        ("beta2_rad,f1_hz\n1,nan\n", "f1_hz is 'nan', must be a finite number"),
        ("beta2_rad,f1_hz\n1,20,3\n", "t.csv:2: has 3 cells, the header has 2"),
        ("joint_1_deg,f1_hz\n1,20\n", "t.csv:1: no column 'joint_2_rad' or 'joint_2_deg'"),
        ("beta1_rad,f1_hz\n1,20\n", "t.csv:1: no column 'joint_1_rad'"),
        ("beta2_rad;f1_hz\n1;20\n", "t.csv:1: must be separated by commas, not semicolons"),
        ("", "t.csv: is empty, must begin with a header"),
    ] {
        std::fs::write(&table, content).unwrap();
        let output = detune(&["diagnose", "robots/two-link", table.to_str().unwrap()]);
        assert_eq!(code(&output), 2, "{content}");
        assert!(err(&output).contains(told), "{}", err(&output));
        assert!(output.stdout.is_empty());
    }
}

/// A pose that the robot cannot take is a slip of the table.
#[test]
fn poses_beyond_limits_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("t.csv");
    std::fs::write(
        &table,
        "joint_1_deg,joint_2_deg,joint_3_deg,joint_4_deg,joint_5_deg,joint_6_deg,f1_hz\n0,200,0,0,0,0,20\n",
    )
    .unwrap();
    let output = detune(&["diagnose", "robots/irb1600", table.to_str().unwrap()]);
    assert_eq!(code(&output), 2);
    let told = err(&output);
    assert!(
        told.contains("t.csv:2: joint 'joint_2' is 200.000 deg, must lie in -90.000"),
        "{told}"
    );
}

/// The text fits a terminal of 100 columns.
#[test]
fn the_text_fits_a_hundred_columns() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("measured.csv");
    std::fs::write(&table, program::first_rows("measured.csv", 6)).unwrap();
    let output = detune(&["diagnose", "robots/two-link", table.to_str().unwrap()]);
    let shown = out(&output);
    assert!(shown.starts_with("EXPLAINED") && shown.contains("\n     alternatives  "), "{shown}");
    let longest = shown.lines().max_by_key(|line| line.chars().count()).unwrap();
    assert!(longest.chars().count() <= 100, "{longest}");
}

/// A page holds its plots and nothing from elsewhere; the text says what to do next.
#[test]
fn the_page_stands_alone() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("simulated.csv");
    std::fs::write(&table, program::every_other_row("simulated.csv")).unwrap();
    let table = table.to_str().unwrap();
    let output = detune(&["diagnose", "robots/two-link", table, "--format", "html"]);
    let page = out(&output);
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    // Each mode over the joint, twice measured against predicted, twice over what the residual follows, and
    // over each of the others.
    let plots = page.matches("<svg").count();
    assert!(plots == 8 && page.contains("next"), "{plots}");
    assert!(page.contains("Mode 2 over joint_2: measured, and the model before and after"));
    assert!(page.contains("Residual over joint_2: with the findings"));
    assert!(page.contains("joint_2 [°]") && page.contains("residual [%]"));
    // The namespace of SVG is a name; nothing is fetched.
    let page = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!page.contains("://") && !page.contains("NaN"));
}

/// Springs 39 times as stiff are no finding that a verdict may rest on: nothing is written.
#[test]
fn a_table_in_another_unit_is_not_written_into_the_robot() {
    let folder = tempfile::tempdir().unwrap();
    let robot = "robots/two-link";
    let map = detune(&["map", robot, "--random", "16"]);
    assert_eq!(code(&map), 0, "{}", err(&map));
    let text = out(&map);
    let (head, rows) = text.split_once('\n').unwrap();
    let kept: Vec<usize> = (head.split(',').enumerate())
        .filter(|(_, name)| name.starts_with("joint_") || name.ends_with("_hz"))
        .map(|(column, _)| column)
        .collect();
    let names: Vec<&str> = kept.iter().map(|&k| head.split(',').nth(k).unwrap()).collect();
    let table = |factor: f64| {
        let row = |line: &str| {
            let cell = |(&k, name): (&usize, &&str)| {
                let value: f64 = line.split(',').nth(k).unwrap().parse().unwrap();
                format!("{}", if name.ends_with("_hz") { factor * value } else { value })
            };
            kept.iter().zip(&names).map(cell).collect::<Vec<_>>().join(",")
        };
        let rows: Vec<String> = rows.lines().map(row).collect();
        let file = folder.path().join("measured.csv");
        std::fs::write(&file, format!("{}\n{}\n", names.join(","), rows.join("\n"))).unwrap();
        file.to_str().unwrap().to_owned()
    };
    let written = folder.path().join("written.yaml");
    let to = written.to_str().unwrap();
    let output = detune(&["diagnose", robot, &table(std::f64::consts::TAU), "--write", to]);
    assert_eq!(code(&output), 2, "{}", out(&output));
    assert!(err(&output).contains("nothing is written: the frequencies are about 6.28 times"));
    assert!(out(&output).is_empty() && !written.exists());
    // What is found is shown all the same; in Hz it is written, too.
    let output = detune(&["diagnose", robot, &table(std::f64::consts::TAU)]);
    assert_eq!(code(&output), 0, "{}", err(&output));
    assert!(err(&output).contains("are they in rad/s?"));
    let output = detune(&["diagnose", robot, &table(1.0), "--write", to]);
    assert!(code(&output) == 0 && written.exists(), "{}", err(&output));
}
