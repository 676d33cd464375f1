//! `detune advise` as a user runs it: jobs that are written pass a check, nothing else of them changes, and
//! exit codes and formats keep apart. DETUNE_RANDOM_JOBS sets how many random jobs are written.

use std::fs;
use std::path::{Path, PathBuf};

use crate::two_link::TABLE_1;
use detune::input::{self, OperationEdit, Reading};
use detune::job::SpindleSpeed;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{code, err, json, out, repository, run};

const RANDOM_JOBS: usize = 40;

fn robot(name: &str) -> String {
    repository().join("robots").join(name).join("robot.yaml").display().to_string()
}

/// The facts of one name in the text of an advice, their wrapped lines joined.
fn facts(text: &str, name: &str) -> Vec<String> {
    let mut facts: Vec<String> = Vec::new();
    let mut is_open = false;
    for line in text.lines() {
        let is_continued = line.starts_with("             ");
        match facts.last_mut().filter(|_| is_open && is_continued) {
            Some(fact) => *fact += &format!(" {}", line.trim()),
            None => {
                is_open = line.starts_with(&format!("    {name} "));
                facts.extend(is_open.then(|| line.trim().to_owned()));
            }
        }
    }
    facts
}

struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(tempfile::tempdir().unwrap());
        for folder in ["jobs", "elsewhere/deep"] {
            fs::create_dir_all(bench.path().join(folder)).unwrap();
        }
        bench
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn add(&self, file: &str, text: &str) -> PathBuf {
        let path = self.path().join(file);
        fs::write(&path, text).unwrap();
        path
    }
}

/// A job for one of the robots here, with one or two operations.
fn random_job(rng: &mut ChaCha8Rng) -> String {
    let which = rng.random_range(0..3);
    let (name, teeth) = (["two-link", "irb1600", "irb1600"][which], rng.random_range(1..5));
    let (min, max): (f64, f64) = (rng.random_range(300.0..900.0), rng.random_range(2500.0..9000.0));
    let mut text = format!(
        "# a random job\nname: random\nrobot: {}\ntool: {{teeth: {teeth}, diameter_mm: 10, payload: none}}\n\
         tcp: {{xyz_m: [0, 0, 0.12]}}\nwork_object: {{xyz_m: [0.75, -0.1, 0.45]}}\n\
         spindle: {{min_rpm: {min:.1}, max_rpm: {max:.1}, max_acceleration_rpm_per_s: {:.0}}}\noperations:\n",
        robot(name),
        rng.random_range(50.0..900.0)
    );
    for index in 0..rng.random_range(1..3) {
        text.push_str(&format!(
            "  - name: op {index}   # number {index}\n    spindle_rpm: {:.1} # programmed\n    feed_mm_per_min: {:.0}\n    path:\n",
            rng.random_range(min + 0.1..max - 0.1),
            rng.random_range(200.0..2000.0),
        ));
        let mut near = |middle: f64, reach: f64| middle + rng.random_range(-reach..reach);
        match which {
            0 => {
                text.push_str("      joints_deg:\n");
                for _ in 0..3 {
                    text.push_str(&format!(
                        "        - [{:.1}, {:.1}]\n",
                        near(20.0, 30.0),
                        near(80.0, 60.0)
                    ));
                }
            }
            1 => {
                text.push_str("      joints_deg:\n");
                for _ in 0..3 {
                    let q = [
                        (0.0, 20.0),
                        (20.0, 12.0),
                        (-10.0, 15.0),
                        (0.0, 10.0),
                        (60.0, 15.0),
                        (0.0, 30.0),
                    ]
                    .map(|(middle, reach)| format!("{:.1}", near(middle, reach)));
                    text.push_str(&format!("        - [{}]\n", q.join(", ")));
                }
            }
            _ => {
                text.push_str("      poses:\n");
                for _ in 0..3 {
                    text.push_str(&format!(
                        "        - {{xyz_mm: [{:.0}, {:.0}, {:.0}], rpy_deg: [0, 180, 0]}}\n",
                        near(120.0, 120.0),
                        near(100.0, 100.0),
                        near(0.0, 30.0)
                    ));
                }
            }
        }
    }
    let separation = rng.random_range(2.0..9.0);
    let uncertainty = rng.random_range(0.0..5.0);
    text.push_str(&format!(
        "policy:\n  separation_percent: {separation:.1}\n  model_uncertainty_percent: {uncertainty:.1}\n"
    ));
    if rng.random_bool(0.3) {
        let f = rng.random_range(15.0..80.0);
        text.push_str(&format!("  ignore_hz: [[{f:.1}, {:.1}]]\n", f * 1.2));
    }
    if rng.random_bool(0.3) {
        text.push_str(&format!("  min_tip_response_um_per_n: {:.2}\n", rng.random_range(0.1..8.0)));
    }
    text
}

/// Lines of a job without those that advice may change.
fn kept(text: &str) -> Vec<&str> {
    let changes = ["spindle_rpm:", "spindle_schedule:", "- {s: ", "feed_mm_per_min:"];
    text.lines().filter(|line| !changes.iter().any(|c| line.trim_start().starts_with(c))).collect()
}

#[test]
fn every_job_that_is_written_passes_a_check() {
    let count = std::env::var("DETUNE_RANDOM_JOBS").ok().and_then(|n| n.parse().ok());
    let count = count.unwrap_or(RANDOM_JOBS);
    let mut rng = ChaCha8Rng::seed_from_u64(300);
    let bench = Bench::new();
    let (mut constant, mut scheduled, mut refused) = (0, 0, 0);
    for index in 0..count {
        let text = random_job(&mut rng);
        bench.add("jobs/job.yaml", &text);
        let target = ["jobs/job2.yaml", "elsewhere/deep/job2.yaml"][index % 2];
        let mut arguments = vec!["advise", "jobs/job.yaml", "--format", "json", "--write", target];
        if index % 3 == 0 {
            arguments.push("--schedule");
        }
        if index % 5 == 0 {
            arguments.extend(["--feed", "programmed"]);
        }
        let ran = run(bench.path(), &arguments);
        assert!([0, 1].contains(&code(&ran)), "job {index}: {}\n{text}", err(&ran));
        let advice = json(&ran);
        if code(&ran) == 1 {
            refused += 1;
            assert!(!bench.path().join(target).exists(), "job {index}");
            assert!(err(&ran).contains("is not written"), "job {index}: {}", err(&ran));
            continue;
        }
        let new = fs::read_to_string(bench.path().join(target)).unwrap();
        assert_eq!(kept(&new), kept(&text), "job {index}");
        let check =
            run(bench.path(), &["check", target, "--format", "json", "--fail-on", "uncertain"]);
        assert_eq!(code(&check), 0, "job {index}: {}\n{text}\n{new}", err(&check));
        let check = json(&check);
        assert_eq!(check["verdict"], "clear", "job {index}");
        for (operation, checked) in advice["operations"]
            .as_array()
            .unwrap()
            .iter()
            .zip(check["jobs"][0]["operations"].as_array().unwrap())
        {
            match operation["status"].as_str().unwrap() {
                "constant" => {
                    constant += 1;
                    assert_eq!(operation["recommended_rpm"], checked["spindle_rpm"], "job {index}");
                    assert!(operation["schedule"].is_null());
                }
                "scheduled" => {
                    scheduled += 1;
                    let duration = operation["schedule_facts"]["duration_s"].as_f64().unwrap();
                    let told = checked["duration_s"].as_f64().unwrap();
                    // The feed in the file has three decimals.
                    assert!((duration / told - 1.0).abs() < 1e-5, "job {index}: {duration} {told}");
                    let limit =
                        operation["schedule_facts"]["acceleration_rpm_per_s"].as_f64().unwrap();
                    let points = operation["schedule"].as_array().unwrap();
                    for pair in points.windows(2) {
                        let of = |i: usize, key: &str| pair[i][key].as_f64().unwrap();
                        let rate = (of(1, "rpm") - of(0, "rpm")) / (of(1, "s") - of(0, "s")) / told;
                        assert!(rate.abs() <= limit, "job {index}: {rate} over {limit}");
                    }
                }
                other => panic!("job {index}: {other}"),
            }
        }
        fs::remove_file(bench.path().join(target)).unwrap();
    }
    println!("{constant} constant, {scheduled} scheduled, {refused} jobs refused");
    assert!(constant > count / 4 && scheduled > count / 8, "{constant} {scheduled} {refused}");
}

const TWO_LINK: &str = "
tool: {teeth: 2, diameter_mm: 12, payload: none}
spindle: {min_rpm: 500, max_rpm: 6000}
operations:
  - name: rough
    spindle_rpm: 780
    feed_mm_per_min: 400
    cutting: {radial_depth_mm: 6, axial_depth_mm: 2, direction: climb, material: al-6061}
    path:
      joints_deg:
        - [0, 90]
        - [0, 120]
        - [0, 150]
policy:
  tooth_passing_harmonics: 1
  spindle_harmonics: 0
";

fn two_link() -> String {
    format!("robot: {}\n{TWO_LINK}", robot("two-link"))
}

/// f1 runs from 25.76 to 28.77 Hz (Eq. 45 of the paper with its Table 1): with ±20 % and two teeth the speeds
/// between 25.76 · 0.8 · 30 = 618.2 and 28.77 · 1.2 · 30 = 1035.9 rpm are closed. f2 falls from 84.18 Hz to its
/// minimum where M12 = 0 and rises to 144.68 Hz: 5208.6 rpm is the upper end.
#[test]
fn safe_speeds_are_those_of_the_closed_form() {
    let bench = Bench::new();
    bench.add("jobs/job.yaml", &two_link());
    let ran = run(bench.path(), &["advise", "jobs/job.yaml", "--format", "json"]);
    assert_eq!(code(&ran), 0);
    let advice = json(&ran);
    assert_eq!(advice["schema"], "advice/1");
    let operation = &advice["operations"][0];
    let found: Vec<f64> = operation["safe_speeds_rpm"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|gap| gap.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()))
        .collect();
    let lowest_f2 = (0..=60_000)
        .map(|i| TABLE_1.natural_frequencies_hz((90.0 + f64::from(i) / 1000.0).to_radians())[1])
        .fold(f64::INFINITY, f64::min);
    let ends = [500.0, 618.2, 1035.9, 24.0 * lowest_f2, 5208.6, 6000.0];
    for (found, expected) in found.iter().zip(ends) {
        assert!((found - expected).abs() < 0.2, "{found} {expected}");
    }
    assert_eq!(found.len(), 6);
    assert_eq!(operation["recommended_rpm"], 618.0);
    let feed = operation["recommended_feed_mm_per_min"].as_f64().unwrap();
    assert!((feed - 400.0 * 618.0 / 780.0).abs() < 1e-9);
    let highest = run(
        bench.path(),
        &["advise", "jobs/job.yaml", "--format", "json", "--objective", "highest"],
    );
    assert_eq!(json(&highest)["operations"][0]["recommended_rpm"], 6000.0);
}

#[test]
fn the_quietest_speed_is_no_louder_than_any_other() {
    let bench = Bench::new();
    bench.add("jobs/job.yaml", &two_link());
    let tip = |objective: &str| {
        let arguments = ["advise", "jobs/job.yaml", "--format", "json", "--objective", objective];
        let advice = json(&run(bench.path(), &arguments));
        advice["operations"][0]["vibration"]["recommended"]["amplitude_um"].as_f64().unwrap()
    };
    let quiet = tip("vibration");
    for other in ["nearest", "margin", "highest"] {
        assert!(
            quiet > 0.0 && quiet <= tip(other) * (1.0 + 1e-6),
            "{other}: {quiet} {}",
            tip(other)
        );
    }
    bench.add("jobs/job.yaml", &two_link().replace("al-6061", "cheese"));
    let ran = run(bench.path(), &["advise", "jobs/job.yaml", "--objective", "vibration"]);
    assert_eq!(code(&ran), 2);
    assert!(
        err(&ran).contains(
            "jobs/job.yaml:6: operation 'rough': --objective: the vibration of the tool tip"
        ),
        "{}",
        err(&ran)
    );
    let own = "cheese, coefficients: {ktc_n_per_mm2: 20, krc_n_per_mm2: 5}";
    bench.add("jobs/job.yaml", &two_link().replace("al-6061", own));
    assert_eq!(
        code(&run(bench.path(), &["advise", "jobs/job.yaml", "--objective", "vibration"])),
        0
    );
}

#[test]
fn an_infeasible_job_has_no_number_and_names_pair_and_lever() {
    let bench = Bench::new();
    let closed = two_link()
        .replace("max_rpm: 6000", "max_rpm: 1000")
        .replace("min_rpm: 500", "min_rpm: 750")
        .replace("\n  tooth_passing", "\n  separation_percent: 30\n  tooth_passing")
        + "tools_on_hand: [{teeth: 5}, {name: slow, teeth: 1}]\n";
    bench.add("jobs/job.yaml", &closed);
    for format in ["json", "text", "svg"] {
        let ran = run(
            bench.path(),
            &["advise", "jobs/job.yaml", "--format", format, "--write", "jobs/new.yaml"],
        );
        assert_eq!(code(&ran), 1, "{format}: {}", err(&ran));
        assert!(!bench.path().join("jobs/new.yaml").exists());
        if format != "json" {
            continue;
        }
        let advice = json(&ran);
        let operation = &advice["operations"][0];
        assert_eq!(operation["status"], "infeasible");
        assert!(operation["recommended_rpm"].is_null() && operation["schedule"].is_null());
        assert!(operation["separation_percent"].is_null());
        let reason = operation["reason"].as_str().unwrap();
        assert!(reason.contains("mode 1 with tooth passing × 1"), "{reason}");
        let levers = operation["levers"].as_array().unwrap();
        // One tooth doubles all speeds, five put the line above mode 1.
        assert_eq!(levers[0]["opens"], true);
        let teeth: Vec<_> = levers
            .iter()
            .filter(|l| l["lever"] == "tool")
            .map(|l| (&l["teeth"], &l["opens"]))
            .collect();
        assert_eq!(teeth.len(), 2);
        assert!(levers.iter().any(|l| l["lever"] == "separation"));
    }
}

#[test]
fn turning_the_tool_and_moving_the_work_are_levers() {
    let bench = Bench::new();
    let job = format!(
        "robot: {}\ntool: {{teeth: 2, payload: none}}\ntcp: {{xyz_m: [0, 0, 0.15]}}\nwork_object: {{xyz_m: [0.72, -0.12, 0.42]}}\n\
         spindle: {{min_rpm: 500, max_rpm: 24000}}\nwork_object_shift: {{x_m: [-0.1, 0.1], z_m: [0, 0.2]}}\n\
         operations:\n  - name: a\n    spindle_rpm: 1100\n    feed_mm_per_min: 400\n    free_axis_deg: [-60, 60]\n    path:\n      \
         poses:\n        - {{xyz_mm: [0, 0, 0], rpy_deg: [0, 180, 0]}}\n        - {{xyz_mm: [240, 0, 0], rpy_deg: [0, 180, 0]}}\n        \
         - {{xyz_mm: [240, 120, 0], rpy_deg: [0, 180, 0]}}\n",
        robot("irb1600")
    );
    bench.add("jobs/job.yaml", &job);
    let ran = run(bench.path(), &["advise", "jobs/job.yaml", "--format", "json"]);
    let advice = json(&ran);
    let operation = &advice["operations"][0];
    if operation["status"] == "constant" {
        panic!("the job is meant to have no safe constant speed");
    }
    let levers = operation["levers"].as_array().unwrap();
    let own = operation["binding"]["separation_percent"].as_f64().unwrap();
    for name in ["turn_tool", "move_work_object"] {
        let lever = levers.iter().find(|l| l["lever"] == name).unwrap();
        // Not to turn and not to move are among what was tried.
        assert!(lever["margin_percent"].as_f64().unwrap() >= own - 1e-9, "{name}: {lever} {own}");
    }
    // The margin of the turned tool is what the job turned so reaches.
    let turned = levers.iter().find(|l| l["lever"] == "turn_tool").unwrap();
    let angle = turned["angle_deg"].as_f64().unwrap();
    let job = job.replace("rpy_deg: [0, 180, 0]", &format!("rpy_deg: [0, 180, {}]", -angle));
    bench.add("jobs/turned.yaml", &job);
    let again = json(&run(
        bench.path(),
        &["advise", "jobs/turned.yaml", "--format", "json", "--objective", "margin"],
    ));
    let operation = &again["operations"][0];
    let reached = match operation["binding"]["separation_percent"].as_f64() {
        Some(margin) => margin,
        None => operation["separation_percent"].as_f64().unwrap(),
    };
    let told = turned["margin_percent"].as_f64().unwrap();
    assert!((reached - told).abs() < 0.02 * told, "{reached} {told}");
}

#[test]
fn programs_are_rewritten_and_the_new_job_names_them() {
    let bench = Bench::new();
    bench.add(
        "jobs/p.nc",
        "(pocket)\nS780 M3\nG0 X800 Y0 Z600\nG1 X900 F400 (cut)\nX950\nM5\nM30\n",
    );
    let job = format!(
        "robot: {}\ntool: {{teeth: 2, payload: none}}\nspindle: {{min_rpm: 500, max_rpm: 24000}}\noperations:\n  - name: a\n    \
         spindle_rpm: 780\n    feed_mm_per_min: 400\n    path: {{program: {{file: p.nc}}}}\npolicy: {{separation_percent: 3, model_uncertainty_percent: 2}}\n",
        robot("irb1600")
    );
    bench.add("jobs/job.yaml", &job);
    let ran = run(
        bench.path(),
        &[
            "advise",
            "jobs/job.yaml",
            "--format",
            "json",
            "--objective",
            "margin",
            "--write",
            "elsewhere/new.yaml",
            "--write-program",
            "elsewhere/new.nc",
        ],
    );
    assert_eq!(code(&ran), 0, "{}", err(&ran));
    let operation = &json(&ran)["operations"][0];
    let rpm = operation["recommended_rpm"].as_f64().unwrap();
    let program = fs::read_to_string(bench.path().join("elsewhere/new.nc")).unwrap();
    assert!(program.contains(&format!("S{rpm} M3")), "{program}");
    assert!(
        program.starts_with("(pocket)\n") && program.contains("(cut)\nX950\nM5\n"),
        "{program}"
    );
    let new = fs::read_to_string(bench.path().join("elsewhere/new.yaml")).unwrap();
    assert!(new.contains("file: new.nc"), "{new}");
    let check = run(bench.path(), &["check", "elsewhere/new.yaml", "--fail-on", "uncertain"]);
    assert_eq!(code(&check), 0, "{}{}", out(&check), err(&check));
    // Program and job agree, so there is nothing to remark but the rapid move's speed.
    assert!(!err(&check).contains("commands"), "{}", err(&check));
}

/// What was written is named, and the next step is not to write it again; a job that is kept is written as well.
#[test]
fn what_was_written_is_named_and_the_next_step_follows() {
    let bench = Bench::new();
    bench.add("jobs/p.nc", "S780 M3\nG0 X800 Y0 Z600\nG1 X900 F400\nX950\nM5\nM30\n");
    let job = format!(
        "robot: {}\ntool: {{teeth: 2, payload: none}}\nspindle: {{min_rpm: 500, max_rpm: 24000}}\noperations:\n  - name: a\n    \
         spindle_rpm: 780\n    feed_mm_per_min: 400\n    path: {{program: {{file: p.nc}}}}\npolicy: {{separation_percent: 3, model_uncertainty_percent: 2}}\n",
        robot("irb1600")
    );
    bench.add("jobs/job.yaml", &job);
    let facts = |arguments: &[&str]| {
        let ran = run(bench.path(), arguments);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        let facts =
            out(&ran).lines().filter(|l| l.starts_with("  next") || l.starts_with("  written"));
        facts.map(str::to_owned).collect::<Vec<_>>().join("\n")
    };
    let asked = facts(&["advise", "jobs/job.yaml"]);
    assert!(asked.contains("--write JOB2.yaml") && !asked.contains("written"), "{asked}");
    let files = ["--write", "new.yaml", "--write-program", "new.nc"];
    let changed = facts(&[&["advise", "jobs/job.yaml"], &files[..]].concat());
    for expected in
        ["job as advised, new.yaml", "program as advised, new.nc", "detune check new.yaml"]
    {
        assert!(changed.contains(expected), "{changed}");
    }
    assert!(!changed.contains("--write"), "{changed}");
    let files = ["--write", "kept.yaml", "--write-program", "kept.nc"];
    let kept = facts(&[&["advise", "new.yaml"], &files[..]].concat());
    assert!(kept.contains("kept.yaml") && kept.contains("program as advised, kept.nc"), "{kept}");
    let text = |file: &str| fs::read_to_string(bench.path().join(file)).unwrap();
    assert_eq!(text("new.nc"), text("kept.nc"));
}

#[test]
fn outputs_are_the_same_twice_and_the_schema_is_printed() {
    let bench = Bench::new();
    bench.add("jobs/job.yaml", &two_link());
    for format in ["text", "json", "svg"] {
        let arguments = ["advise", "jobs/job.yaml", "--schedule", "--format", format];
        let (a, b) = (run(bench.path(), &arguments), run(bench.path(), &arguments));
        assert_eq!(code(&a), 0, "{format}: {}", err(&a));
        assert_eq!(a.stdout, b.stdout, "{format}");
        assert!(!out(&a).contains("NaN") && !out(&a).contains("inf,"), "{format}");
    }
    let schema = json(&run(bench.path(), &["schema", "advice"]));
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(schema["properties"]["operations"]["type"], "array");
}

#[test]
fn two_outputs_of_one_run_are_two_files() {
    let bench = Bench::new();
    bench.add("jobs/job.yaml", &two_link());
    let clashes: [&[&str]; 4] = [
        &["--output", "q", "--write", "q"],
        &["--output", "elsewhere/../q", "--write-program", "q"],
        &["--write", "q", "--write-program", "q"],
        &["--write", "-"],
    ];
    for clash in clashes {
        let ran = run(bench.path(), &[&["advise", "jobs/job.yaml"], clash].concat());
        assert_eq!(code(&ran), 2, "{clash:?}");
        assert!(ran.stdout.is_empty() && !bench.path().join("q").exists(), "{clash:?}");
    }
    let apart = ["advise", "jobs/job.yaml", "--output", "q", "--write", "-"];
    let ran = run(bench.path(), &apart);
    assert_eq!(code(&ran), 0, "{}", err(&ran));
    assert!(out(&ran).contains("operations:"), "{}", out(&ran));
}

#[test]
fn a_job_that_cannot_be_edited_is_refused_and_a_safe_schedule_is_kept() {
    let bench = Bench::new();
    let job = |speed: &str| {
        format!(
            "robot: {}\ntool: {{teeth: 2, payload: none}}\nspindle: {{min_rpm: 500, max_rpm: 24000}}\npolicy: \
             {{separation_percent: 3, model_uncertainty_percent: 2}}\noperations:\n  - name: a\n    {speed}\n    \
             feed_mm_per_min: 400\n    path: {{joints_deg: [[0, 20, -10, 0, 60, 0], [10, 25, -12, 0, 60, 0]]}}\n",
            robot("irb1600")
        )
    };
    // An explicit key with a number behind it is edited; a schedule cannot take its place.
    bench.add("jobs/job.yaml", &job("? spindle_rpm\n    : 780"));
    let highest = ["advise", "jobs/job.yaml", "--objective", "highest", "--write", "n.yaml"];
    let ran = run(bench.path(), &highest);
    assert_eq!(code(&ran), 0, "{}", err(&ran));
    let new = fs::read_to_string(bench.path().join("n.yaml")).unwrap();
    let feed = "feed_mm_per_min: 12307.692";
    let expected = job("? spindle_rpm\n    : 24000").replace("feed_mm_per_min: 400", feed);
    assert_eq!(new, expected);
    assert_eq!(code(&run(bench.path(), &["check", "n.yaml", "--fail-on", "uncertain"])), 0);
    fs::remove_file(bench.path().join("n.yaml")).unwrap();

    bench.add("jobs/job.yaml", &job("? spindle_rpm\n    : 700"));
    let ran = run(bench.path(), &["advise", "jobs/job.yaml", "--schedule", "--write", "n.yaml"]);
    assert_eq!(code(&ran), 2, "{}", err(&ran));
    assert!(!bench.path().join("n.yaml").exists() && ran.stdout.is_empty());
    assert_eq!(
        err(&ran).lines().next().unwrap(),
        "error: n.yaml: is not written: read again, a list or mapping is used as a key, must be plain text; \
         jobs/job.yaml is written in a manner that cannot be edited, so change it by hand"
    );

    let safe = "spindle_schedule: [{s: 0, rpm: 16500}, {s: 1, rpm: 16700}]";
    bench.add("jobs/job.yaml", &job(safe));
    for extra in [&[][..], &["--schedule"]] {
        let all = [&["advise", "jobs/job.yaml", "--format", "json", "--write", "k.yaml"], extra];
        let ran = run(bench.path(), &all.concat());
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        let operation = &json(&ran)["operations"][0];
        assert_eq!(operation["status"], "scheduled");
        assert_eq!(operation["schedule"][1]["rpm"], 16700.0);
        let kept = fs::read_to_string(bench.path().join("k.yaml")).unwrap();
        assert!(kept.contains(safe), "{kept}");
    }

    let deaf = job(safe).replace("policy: {", "policy: {ignore_hz: [[0, 100000]], ");
    bench.add("jobs/job.yaml", &deaf);
    let ran = run(bench.path(), &["advise", "jobs/job.yaml"]);
    assert!(err(&ran).contains("nothing was checked"), "{}", err(&ran));

    // No speed is known to be safe, whatever the programmed one is.
    for speed in [safe, "spindle_rpm: 16600"] {
        for deaf in ["ignore_hz: [[0, 100000]], ", "min_tip_response_um_per_n: 100000, "] {
            let policy = format!("policy: {{{deaf}");
            bench.add("jobs/job.yaml", &job(speed).replace("policy: {", &policy));
            let all = ["advise", "jobs/job.yaml", "--format", "json", "--write", "w.yaml"];
            let ran = run(bench.path(), &all);
            assert_eq!(code(&ran), 1, "{}", err(&ran));
            let operation = &json(&ran)["operations"][0];
            assert_eq!(operation["status"], "infeasible", "{operation}");
            assert_eq!(operation["safe_speeds_rpm"], serde_json::json!([]), "{operation}");
            assert_eq!(operation["recommended_rpm"], serde_json::Value::Null, "{operation}");
            let reason = operation["reason"].as_str().unwrap();
            assert!(reason.contains("no speed is known to be safe"), "{reason}");
            assert!(!bench.path().join("w.yaml").exists());
            let accept =
                "accept: [{code: nothing_checked, reason: transport, until: 2999-12-31}]\n";
            let accepted = job(speed).replace("policy: {", &policy) + accept;
            bench.add("jobs/job.yaml", &accepted);
            let ran = run(bench.path(), &["advise", "jobs/job.yaml"]);
            assert_eq!(code(&ran), 0, "{}", err(&ran));
        }
    }
}

/// What is to be written is read again, and held against what was read and what was advised.
#[test]
fn a_job_that_would_not_be_as_advised_is_not_written() {
    let bench = Bench::new();
    let file = bench.add("jobs/job.yaml", &two_link());
    bench.add("jobs/other.yaml", &fs::read_to_string(robot("two-link")).unwrap());
    let mut reading = Reading::default();
    let job = input::read_job(&file, &mut reading).unwrap();
    let edit = OperationEdit {
        speed: Some(SpindleSpeed::Constant(618.0)),
        feed_mm_per_min: Some(316.923),
        ..OperationEdit::default()
    };
    let to = bench.path().join("jobs/new.yaml");
    let text = input::rewritten_job(&file, &to, std::slice::from_ref(&edit)).unwrap();
    let confirmed = |text: &str| {
        let advised = input::Advised {
            speed: SpindleSpeed::Constant(618.0),
            feed_m_per_s: edit.feed_mm_per_min.map(|feed| feed / 60_000.0),
        };
        input::confirm_rewritten(&job, &reading.files, text, &to, &[advised], None)
            .map_err(|fault| fault.what)
    };
    assert_eq!(confirmed(&text), Ok(()));
    for (from, into, told) in [
        (
            "spindle_rpm: 618",
            "spindle_rpm: 619",
            "operation 'rough': speed would differ from the advice",
        ),
        ("316.923", "316.922", "operation 'rough': feed would differ from the advice"),
        ("name: rough", "name: fine", "name would differ from the advice"),
        ("- [0, 120]", "- [0, 121]", "path would differ from the advice"),
        ("axial_depth_mm: 2", "axial_depth_mm: 3", "cutting would differ from the advice"),
        ("harmonics: 0", "harmonics: 1", "policy would differ from the advice"),
        ("max_rpm: 6000", "max_rpm: 6001", "spindle would differ from the advice"),
        ("teeth: 2", "teeth: 3", "tool would differ from the advice"),
        ("spindle_rpm: 618", "spindle_rpm: ~", "spindle_rpm"),
        ("policy:", "policy", "read again"),
    ] {
        let other = text.replacen(from, into, 1);
        assert_ne!(other, text, "{from}");
        let what = confirmed(&other).unwrap_err();
        assert!(what.contains(told), "{into}: {what}");
        assert!(what.starts_with("is not written: read again"), "{what}");
    }
    let elsewhere = text.replace(&robot("two-link"), "other.yaml");
    assert_ne!(elsewhere, text);
    assert!(confirmed(&elsewhere).is_err());
}

/// A program without feeds runs at the job's; feeds per revolution follow the speed by themselves.
#[test]
fn feeds_of_programs_are_told_as_they_are() {
    let bench = Bench::new();
    let job = format!(
        "robot: {}\ntool: {{teeth: 2, payload: none}}\nspindle: {{min_rpm: 500, max_rpm: 24000}}\noperations:\n  - name: a\n    \
         spindle_rpm: 780\n    feed_mm_per_min: 400\n    path: {{program: {{file: p.nc}}}}\npolicy: {{separation_percent: 3, model_uncertainty_percent: 2}}\n",
        robot("irb1600")
    );
    bench.add("jobs/job.yaml", &job);
    let advised = |program: &str, more: &[&str]| {
        bench.add("jobs/p.nc", &format!("S780 M3\nG0 X800 Y0 Z600\n{program}M5\nM30\n"));
        // The job gives the feed where the program states none.
        let silent = !program.contains('F');
        let own = if silent { job.clone() } else { job.replace("    feed_mm_per_min: 400\n", "") };
        bench.add("jobs/job.yaml", &own);
        let all = [&["advise", "jobs/job.yaml", "--objective", "margin"], more].concat();
        let ran = run(bench.path(), &all);
        assert_eq!(code(&ran), 0, "{}", err(&ran));
        out(&ran).to_owned()
    };
    for (program, own, per_revolution, told, coupling) in [
        ("G1 X900\nX950\n", false, false, None, "mean_chip_load"),
        ("G1 X900\nG0 X920\nG1 X950\n", false, false, None, "rapids"),
        ("G1 X900 F300\nX950\n", true, false, Some("own feeds at"), "own_feeds"),
        ("G95 G1 X900 F0.5\nX950\n", false, true, Some("all per revolution"), "own_feeds"),
        ("G1 X900 F300\nG95 X950 F0.5\n", true, true, Some("those per revolution"), "own_feeds"),
    ] {
        let text = advised(program, &[]);
        let feed = facts(&text, "feed");
        match told {
            Some(told) => assert!(feed[0].contains(told), "{program}: {text}"),
            None => assert!(feed.is_empty(), "{program}: {text}"),
        }
        let advice: Value =
            serde_json::from_str(&advised(program, &["--format", "json", "--schedule"])).unwrap();
        let operation = &advice["operations"][0];
        assert_eq!(operation["program_has_own_feeds"], own, "{program}");
        assert_eq!(operation["program_has_feeds_per_revolution"], per_revolution, "{program}");
        assert_eq!(advice["objective"], "margin");
        assert_eq!(operation["schedule_facts"]["follows"], "margin", "{program}");
        assert_eq!(operation["schedule_facts"]["feed"], coupling, "{program}");
    }
    // The speed is rewritten, the feed per revolution is not.
    advised("G95 G1 X900 F0.5\nX950\n", &["--write-program", "new.nc"]);
    let program = fs::read_to_string(bench.path().join("new.nc")).unwrap();
    assert!(program.contains("F0.5") && !program.contains("S780"), "{program}");
}

/// Coefficients of no material and feeds of no robot would end in amplitudes without bound.
#[test]
fn coefficients_have_bounds() {
    let bench = Bench::new();
    for (key, most) in [("ktc", 100_000), ("krc", 100_000), ("kte", 10_000), ("kre", 10_000)] {
        let name = if key.ends_with("tc") || key.ends_with("rc") {
            format!("{key}_n_per_mm2")
        } else {
            format!("{key}_n_per_mm")
        };
        let with = |value: &str| {
            let all = ["ktc_n_per_mm2", "krc_n_per_mm2", "kte_n_per_mm", "kre_n_per_mm"];
            let all = all.map(|each| format!("{each}: {}", if each == name { value } else { "5" }));
            let own = format!("cheese, coefficients: {{{}}}", all.join(", "));
            bench.add("jobs/job.yaml", &two_link().replace("al-6061", &own));
            run(bench.path(), &["advise", "jobs/job.yaml", "--format", "json"])
        };
        assert_eq!(code(&with(&most.to_string())), 0, "{key}");
        let ran = with("1e300");
        assert_eq!(code(&ran), 2, "{key}");
        let told = format!("cutting.coefficients.{name} is 1e300, must be a number");
        assert!(err(&ran).contains(&told), "{}", err(&ran));
        let told = if key == "ktc" { "above 0 and at most" } else { "from 0 to" };
        assert!(err(&ran).contains(&format!("{told} {most}")), "{}", err(&ran));
    }
}

/// Nor is there a feed of 1e300, and a spindle that is faster than any other is taken for one of a thousand million.
#[test]
fn feeds_and_spindles_beyond_all_measure_make_no_infinities() {
    let bench = Bench::new();
    bench.add("jobs/job.yaml", &two_link().replace("min: 400", "min: 1e300"));
    let ran = run(bench.path(), &["advise", "jobs/job.yaml"]);
    assert_eq!(code(&ran), 2);
    assert!(err(&ran).contains("feed_mm_per_min is 1e300, must be at most 1e9"), "{}", err(&ran));
    bench.add(
        "jobs/job.yaml",
        &two_link().replace("max_rpm: 6000", "max_rpm: 6000, max_acceleration_rpm_per_s: 1e300"),
    );
    let ran = run(bench.path(), &["advise", "jobs/job.yaml", "--schedule", "--format", "json"]);
    assert_eq!(code(&ran), 0, "{}", err(&ran));
    let facts = &json(&ran)["operations"][0]["schedule_facts"];
    assert_eq!(facts["acceleration_rpm_per_s"], 1e9);
}

/// A band that must be crossed is told in one line, and what the job already offers is not asked for again.
#[test]
fn a_crossing_is_one_fact() {
    let bench = Bench::new();
    let job = two_link()
        .replace(
            "min_rpm: 500, max_rpm: 6000",
            "min_rpm: 730, max_rpm: 850, max_acceleration_rpm_per_s: 50000",
        )
        .replace("- [0, 90]", "- [0, 70]")
        + "  separation_percent: 2\n  model_uncertainty_percent: 1\n";
    bench.add("jobs/job.yaml", &job);
    let ran = run(bench.path(), &["advise", "jobs/job.yaml", "--write", "n.yaml"]);
    assert_eq!(code(&ran), 1, "{}", err(&ran));
    assert!(!bench.path().join("n.yaml").exists());
    let text = out(&ran);
    let crossings = facts(text, "crosses");
    let [crossing] = crossings.as_slice() else { panic!("{text}") };
    for part in
        ["mode 1 with tooth passing × 1", "enters the band at", "leaves it at", "in the cut"]
    {
        assert!(crossing.contains(part), "{crossing}");
    }
    assert!(!text.contains("    margin"), "{text}");
    // Joint positions are neither turned nor moved, so these are not offered.
    assert!(text.ends_with("the job could also allow tools_on_hand\n"), "{text}");
    bench.add("jobs/job.yaml", &(job + "tools_on_hand: [{teeth: 3}]\n"));
    let again = run(bench.path(), &["advise", "jobs/job.yaml"]);
    assert!(
        out(&again).ends_with("apply one of the remedies, then run advise again\n"),
        "{}",
        out(&again)
    );

    let advice = json(&run(bench.path(), &["advise", "jobs/job.yaml", "--format", "json"]));
    let facts = &advice["operations"][0]["schedule_facts"];
    let passages = facts["passages"].as_array().unwrap();
    assert_eq!((passages.len(), facts["exposures"].as_array().unwrap().len()), (1, 3));
    let of = |key: &str| passages[0][key].as_f64().unwrap();
    let least = (of("to_rpm") - of("from_rpm")).abs() / 50_000.0;
    assert!((of("seconds") / least - 1.0).abs() < 0.005, "{} {least}", of("seconds"));
}

/// The IRB 1600 about a pose at which modes 1 to 3 lie from 19 to 35 Hz, 4 and 5 from 143 to 151 Hz; modes 4 and 5
/// move the tool tip by 0.9 and 0.4 µm/N, mode 1 by 85.
fn blocked(folder: &Path, spindle: &str, policy: &str) -> Value {
    let rpm = spindle.split([' ', ',']).nth(1).unwrap();
    let job = format!(
        "robot: {}\ntool: {{teeth: 3}}\npayload: {{mass_kg: 4.2, com_m: [0, 0, 0.07]}}\nspindle: {{{spindle}}}\n\
         operations:\n  - {{name: a, spindle_rpm: {rpm}, feed_mm_per_min: 600, path: {{joints_deg: [[0, 20, -10, 0, 60, 0], [5, 22, -12, 0, 55, 0]]}}}}\npolicy: \
         {{model_uncertainty_percent: 5, tooth_passing_harmonics: 1, spindle_harmonics: 0, {policy}}}\n",
        repository().join("robots/irb1600/robot.yaml").display()
    );
    fs::write(folder.join("job.yaml"), job).unwrap();
    let ran = run(folder, &["advise", "job.yaml", "--format", "json"]);
    json(&ran)["operations"][0].clone()
}

/// What cannot be bought is not offered: no spindle below 0.8 times the lowest or above twice the highest speed.
/// With bands of ±45 % modes 1 to 3 close 209 to 1015 rpm.
#[test]
fn only_spindles_of_the_kind_are_offered() {
    let folder = tempfile::tempdir().unwrap();
    let policy = "separation_percent: 40, min_tip_response_um_per_n: 0";
    for (spindle, offered) in [
        ("min_rpm: 300, max_rpm: 500", None),
        ("min_rpm: 300, max_rpm: 520", Some(1015.0)),
        ("min_rpm: 250, max_rpm: 500", Some(209.0)),
    ] {
        let found = blocked(folder.path(), spindle, policy);
        assert_eq!(found["status"], "infeasible");
        let levers = found["levers"].as_array().unwrap();
        assert!(!levers.is_empty());
        let of_spindle = levers.iter().find(|lever| lever["lever"] == "spindle");
        match (of_spindle, offered) {
            (None, None) => {}
            (Some(lever), Some(rpm)) => {
                assert!((lever["rpm"].as_f64().unwrap() - rpm).abs() < 2.0, "{lever}");
            }
            other => panic!("{spindle}: {other:?}"),
        }
    }
}

/// Where faint modes close all speeds, the threshold that leaves them out is offered: here modes 4 and 5 must both go.
#[test]
fn a_threshold_that_decides_is_offered() {
    let folder = tempfile::tempdir().unwrap();
    let spindle = "min_rpm: 2700, max_rpm: 3200";
    let with = |threshold: f64| {
        let policy = format!("separation_percent: 5, min_tip_response_um_per_n: {threshold}");
        blocked(folder.path(), spindle, &policy)
    };
    let found = with(0.0);
    assert_eq!(found["status"], "infeasible");
    let levers = found["levers"].as_array().unwrap();
    let lever = levers.iter().find(|lever| lever["lever"] == "min_tip_response").unwrap();
    assert_eq!((&lever["opens"], &lever["mode"]), (&true.into(), &4.into()));
    let [response, threshold] = ["tip_response_um_per_n", "min_tip_response_um_per_n"]
        .map(|key| lever[key].as_f64().unwrap());
    assert!(response < threshold && threshold < 1.05 * response, "{response} {threshold}");
    // What it promises holds; one that leaves out mode 5 alone would not do.
    let applied = with(threshold);
    assert_eq!(applied["status"], "constant");
    assert_eq!(applied["recommended_rpm"], lever["rpm"]);
    assert_eq!(with(0.8 * response)["status"], "infeasible");
}
