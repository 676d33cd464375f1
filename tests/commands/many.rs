//! Many jobs, and what the command line sets for all of them.
//!
//! The arm and its jobs are those of `check.rs`: with two teeth 780 rpm lies on mode 1 (26 Hz against 25.76 Hz
//! to 28.77 Hz), 990 rpm (33 Hz) 14.7 % above it at the end of the path, 1200 rpm (40 Hz) 39 % away.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{FORMATS, code, err, json, out, repository, run};

struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn add(&self, file: &str, rpm: f64, policy: &str) {
        let path = self.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let robot = repository().join("robots/two-link/robot.yaml");
        let text = format!(
            "robot: {}
tool: {{teeth: 2, payload: none}}
spindle: {{min_rpm: 500, max_rpm: 6000}}
operations:
  - name: rough
    spindle_rpm: {rpm}
    feed_mm_per_min: 400
    path: {{joints_deg: [[0, 90], [0, 120], [0, 150]]}}
policy: {{tooth_passing_harmonics: 1, spindle_harmonics: 0{policy}}}
",
            robot.display()
        );
        fs::write(path, text).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        run(self.path(), arguments)
    }
}

fn files_of(checked: &Value) -> Vec<&str> {
    checked["jobs"].as_array().unwrap().iter().map(|job| job["job"].as_str().unwrap()).collect()
}

#[test]
fn folders_and_patterns_are_jobs_without_a_shell() {
    let bench = Bench::new();
    bench.add("jobs/b.yaml", 1200.0, "");
    bench.add("jobs/a/deep.yaml", 780.0, "");
    bench.add("jobs/my job.yml", 1200.0, "");
    fs::write(bench.path().join("jobs/robot.yaml"), "name: arm\nurdf: arm.urdf\n").unwrap();
    let check = |of: &[&str]| {
        let mut arguments = vec!["check", "--format", "json", "--samples", "none"];
        arguments.extend(of);
        bench.run(&arguments)
    };
    let output = check(&["jobs"]);
    assert_eq!(code(&output), 1, "{}", err(&output));
    let files = ["jobs/b.yaml", "jobs/my job.yml", "jobs/a/deep.yaml"];
    assert_eq!(files_of(&json(&output)), files);
    assert_eq!(files_of(&json(&check(&["jobs/*.yml", "jobs/**/*.yaml"]))).len(), 3);
    assert_eq!(files_of(&json(&check(&["jobs/b.yaml", "jobs"]))).len(), 3);
    let output = check(&["nothing/*.yaml"]);
    assert_eq!(code(&output), 2);
    assert!(err(&output).contains("nothing/*.yaml: no such job file"), "{}", err(&output));
    // A job that is broken is not passed over.
    fs::write(bench.path().join("jobs/broken.yaml"), "operations: [\n").unwrap();
    assert_eq!(code(&check(&["jobs"])), 2);
}

/// A link's folder counts once, also where links lead back, or two to one folder.
#[cfg(unix)]
#[test]
fn a_folder_that_a_link_leads_to_is_not_passed_over() {
    use std::os::unix::fs::symlink;
    let bench = Bench::new();
    bench.add("jobs/a.yaml", 1200.0, "");
    bench.add("jobs/z/c.yaml", 1200.0, "");
    bench.add("shared/deep/b.yaml", 780.0, "");
    let jobs = bench.path().join("jobs");
    symlink("../shared", jobs.join("shared")).unwrap();
    symlink("shared", jobs.join("twice")).unwrap();
    symlink("z", jobs.join("before")).unwrap();
    symlink("..", jobs.join("z/up")).unwrap();
    symlink("self", jobs.join("self")).unwrap();
    symlink("../jobs", bench.path().join("shared/back")).unwrap();
    let output = bench.run(&["check", "jobs", "--format", "json", "--samples", "none"]);
    assert_eq!(code(&output), 1, "{}", err(&output));
    let files = ["jobs/a.yaml", "jobs/z/c.yaml", "jobs/shared/deep/b.yaml"];
    assert_eq!(files_of(&json(&output)), files);
    // A folder may hold nothing but a link.
    fs::create_dir(bench.path().join("linked")).unwrap();
    symlink("../shared/deep", bench.path().join("linked/here")).unwrap();
    let output = bench.run(&["check", "linked", "--format", "json", "--samples", "none"]);
    assert_eq!(files_of(&json(&output)), ["linked/here/b.yaml"], "{}", err(&output));
}

#[test]
fn five_hundred_jobs_are_a_page_and_a_few_megabytes() {
    let bench = Bench::new();
    for i in 0..500 {
        bench.add(&format!("jobs/{i:03}.yaml"), if i % 100 == 7 { 780.0 } else { 1200.0 }, "");
    }
    let output = bench.run(&["check", "jobs"]);
    assert_eq!(code(&output), 1);
    let text = out(&output);
    assert!(text.lines().count() <= 60, "{text}");
    assert!(text.starts_with("500 jobs: 5 resonance, 495 clear\n"), "{text}");
    assert!(text.contains("RESONANCE  jobs/007.yaml\n    why      rough: mode 1 ("), "{text}");
    let of = |jobs: &str, how: &str| {
        let ran = bench.run(&["check", jobs, "--format", "json", "--samples", how]);
        assert_eq!(files_of(&json(&ran)).len(), if jobs == "jobs" { 500 } else { 10 });
        ran.stdout.len()
    };
    assert!(of("jobs", "none") < 3_000_000);
    // What every job adds is seen on ten of them.
    let ten = "jobs/00*.yaml";
    let full = bench.run(&["check", ten, "--summary=never"]);
    assert!(out(&full).lines().count() > 100, "{}", out(&full));
    let sizes = ["none", "thin", "all"].map(|how| of(ten, how));
    assert!(sizes[0] < sizes[1] && sizes[1] <= sizes[2], "{sizes:?}");
}

#[test]
fn fewer_samples_change_nothing_else() {
    let bench = Bench::new();
    bench.add("a.yaml", 780.0, "");
    let of =
        |how: &str| json(&bench.run(&["check", "a.yaml", "--format", "json", "--samples", how]));
    let (all, thin, none) = (of("all"), of("thin"), of("none"));
    assert_eq!(all, json(&bench.run(&["check", "a.yaml", "--format", "json"])));
    let samples = |checked: &Value| {
        checked["jobs"][0]["operations"][0]["samples"].as_array().unwrap().clone()
    };
    assert!(samples(&none).is_empty());
    assert!(samples(&thin).iter().all(|sample| samples(&all).contains(sample)));
    let places = |checked: &Value| -> Vec<f64> {
        samples(checked).iter().map(|sample| sample["s"].as_f64().unwrap()).collect()
    };
    let (all_s, thin_s) = (places(&all), places(&thin));
    assert_eq!((thin_s[0], thin_s[thin_s.len() - 1]), (0.0, 1.0));
    // No gap of more than a hundredth that was not there before.
    let widest = |s: &[f64]| s.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(widest(&thin_s) <= widest(&all_s).max(0.01) + 1e-12, "{thin_s:?}");
    let without = |mut checked: Value| {
        checked["jobs"][0]["operations"][0]["samples"] = Value::Null;
        checked
    };
    assert_eq!(without(all.clone()), without(thin));
    assert_eq!(without(all), without(none));
}

#[test]
fn the_command_line_s_policy_wins_and_every_output_says_so() {
    let bench = Bench::new();
    bench.add("a.yaml", 990.0, ", separation_percent: 5, model_uncertainty_percent: 5");
    assert_eq!(json(&bench.run(&["check", "a.yaml", "--format", "json"]))["verdict"], "clear");
    let policy = ["--policy", "separation_percent=20", "--policy", "model_uncertainty_percent=0"];
    let check = |format: &str| {
        let mut arguments = vec!["check", "a.yaml", "--format", format];
        arguments.extend(policy);
        bench.run(&arguments)
    };
    let checked = json(&check("json"));
    assert_eq!(checked["verdict"], "resonance");
    assert_eq!(checked["jobs"][0]["separation_percent"], 20.0);
    let set = serde_json::json!(["separation_percent=20", "model_uncertainty_percent=0"]);
    assert_eq!(checked["jobs"][0]["policy_overrides"], set);
    for format in FORMATS.into_iter().filter(|format| *format != "json") {
        let told = "--policy sets separation_percent=20, model_uncertainty_percent=0";
        assert_eq!(out(&check(format)).matches(told).count(), 1, "{format}");
        let plain = bench.run(&["check", "a.yaml", "--format", format]);
        assert!(!out(&plain).contains("--policy"), "{format}");
    }
    // As it is the same for all jobs, an entry of its own says it once, where nothing is found, too.
    let clear = ["--policy", "separation_percent=1", "--policy", "model_uncertainty_percent=0"];
    let clear = [&["check", "a.yaml", "a.yaml", "--format", "gitlab"][..], &clear].concat();
    let entries = json(&bench.run(&clear));
    assert_eq!(entries.as_array().map(Vec::len), Some(1), "{entries}");
    assert_eq!(
        (&entries[0]["check_name"], &entries[0]["severity"]),
        (&"policy".into(), &"info".into())
    );
    let advised = bench.run(&["advise", "a.yaml", "--policy", "separation_percent=20"]);
    assert!(out(&advised).contains("--policy sets separation_percent=20"), "{}", out(&advised));
    for wrong in ["separation_percent", "separation=5", "separation_percent=-1"] {
        let output = bench.run(&["check", "a.yaml", "--policy", wrong]);
        assert_eq!(code(&output), 2, "{wrong}");
        assert!(err(&output).contains("--policy"), "{}", err(&output));
    }
    let write = ["advise", "a.yaml", "--policy", "separation_percent=6", "--write", "b.yaml"];
    assert_eq!(code(&bench.run(&write)), 2);
    assert!(!bench.path().join("b.yaml").exists());
}

#[test]
fn quiet_leaves_errors_alone() {
    let bench = Bench::new();
    bench.add("a.yaml", 1200.0, ", ignore_hz: [[1, 500]]");
    let loud = bench.run(&["check", "a.yaml"]);
    let quiet = bench.run(&["check", "a.yaml", "--quiet"]);
    assert!(err(&loud).contains("warning: "), "{}", err(&loud));
    assert_eq!((out(&quiet), code(&quiet), err(&quiet)), (out(&loud), code(&loud), ""));
    assert!(err(&bench.run(&["check", "gone.yaml", "--quiet"])).starts_with("error: "));
    // Warnings that are not shown are there all the same.
    bench.add("b.yaml", 1200.0, "");
    fs::write(
        bench.path().join("b.yaml"),
        fs::read_to_string(bench.path().join("b.yaml")).unwrap().replace(", payload: none", ""),
    )
    .unwrap();
    let denied = bench.run(&["check", "b.yaml", "--quiet", "--deny-warnings"]);
    assert_eq!(code(&denied), 1);
}

#[test]
fn several_jobs_are_advised_at_once() {
    let bench = Bench::new();
    bench.add("jobs/a.yaml", 780.0, "");
    bench.add("jobs/b.yaml", 1200.0, "");
    let alone = |file: &str| json(&bench.run(&["advise", file, "--format", "json"]));
    let output = bench.run(&["advise", "jobs", "--format", "json"]);
    assert_eq!(code(&output), 0, "{}", err(&output));
    let list = json(&output);
    assert_eq!(list["schema"], "advice-list/1");
    assert_eq!(list["jobs"], serde_json::json!([alone("jobs/a.yaml"), alone("jobs/b.yaml")]));
    let output = bench.run(&["advise", "jobs/a.yaml", "jobs/b.yaml"]);
    assert!(out(&output).ends_with("2 jobs: 2 can be run clear of every band, 0 cannot\n"));
    for option in [&["--write", "c.yaml"][..], &["--format", "svg"]] {
        let mut arguments = vec!["advise", "jobs"];
        arguments.extend(option);
        let output = bench.run(&arguments);
        assert_eq!(code(&output), 2);
        assert!(err(&output).contains("takes one job"), "{}", err(&output));
    }
}

#[test]
fn what_outputs_say_is_explained() {
    let bench = Bench::new();
    let output = bench.run(&["explain", "payload_unknown", "joint_coupling", "unchecked"]);
    assert_eq!(code(&output), 0);
    for told in ["payload_unknown  warning: the verdict is at best uncertain", "joint_coupling"] {
        assert!(out(&output).contains(told), "{}", out(&output));
    }
    // The names that SARIF and GitLab's report have for findings, too.
    for name in ["doubt", "limit", "policy"] {
        let output = bench.run(&["explain", name]);
        assert!(out(&output).starts_with(&format!("{name}  ")), "{}", err(&output));
    }
    let all = bench.run(&["explain"]);
    for name in ["usage", "crossing", "partly_explained", "infeasible", "missed_mode"] {
        assert!(out(&all).contains(&format!("\n  {name} ")), "{name}");
    }
    let output = bench.run(&["explain", "paylod_unknown"]);
    assert_eq!(code(&output), 2);
    assert!(err(&output).contains("did you mean 'payload_unknown'"), "{}", err(&output));
}
