//! detune.toml: what jobs share, what wins over it, and that nothing in it is passed over.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::{Value, json as value};
use tempfile::TempDir;

use crate::program::{code, err, flat, json, out, repository, run};

const JOB: &str = "tool: {teeth: 2}
payload: none
spindle: {min_rpm: 500, max_rpm: 6000}
operations:
  - {name: rough, spindle_rpm: 780, feed_mm_per_min: 400, path: {joints_deg: [[0, 90], [0, 150]]}}
";

const POLICY: &str =
    "policy: {separation_percent: 4, spindle_harmonics: 0, ignore_hz: [[30, 31], [60, 61]]}\n";

/// A repository with jobs two folders down.
struct Bench(TempDir);

impl Bench {
    fn new(settings: &str) -> Self {
        let bench = Self(tempfile::tempdir().unwrap());
        fs::create_dir_all(bench.0.path().join("cell/jobs")).unwrap();
        fs::create_dir(bench.0.path().join(".git")).unwrap();
        bench.add("detune.toml", settings);
        bench.add("cell/jobs/a.yaml", JOB);
        bench
    }

    fn add(&self, file: &str, text: &str) {
        fs::write(self.0.path().join(file), text).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        run(self.0.path(), arguments)
    }

    fn check(&self) -> Value {
        let ran =
            self.run(&["check", "cell/jobs/a.yaml", "--format", "json", "--fail-on", "never"]);
        json(&ran)["jobs"][0].clone()
    }
}

fn robot() -> String {
    repository().join("robots/two-link/robot.yaml").display().to_string()
}

/// Robot and policy of [`POLICY`], in TOML.
fn shared() -> String {
    format!(
        "robot = \"{}\" # the cell's\n\n[policy]\nseparation_percent = 4\nspindle_harmonics = 0\nignore_hz = \
         [[30, 31], [60.0, 61]]\n",
        robot()
    )
}

#[test]
fn a_job_takes_what_it_does_not_say_and_says_so_in_every_output() {
    let bench = Bench::new(&shared());
    let found = bench.check();
    let keys =
        ["robot", "policy.ignore_hz", "policy.separation_percent", "policy.spindle_harmonics"];
    assert_eq!(found["settings"], value!({"file": "detune.toml", "keys": keys}));
    // The same as if the job said it all.
    let whole = Bench::new("");
    whole.add("cell/jobs/a.yaml", &format!("robot: {}\n{JOB}{POLICY}", robot()));
    let other = whole.check();
    assert_eq!(other["settings"], Value::Null);
    assert!(!found["operations"][0]["crossings"].as_array().unwrap().is_empty());
    let facts = |job: &Value| {
        let mut job = job.clone();
        job["settings"] = Value::Null;
        // The entry of the operation lies one line lower.
        let crossings = job["operations"][0]["crossings"].as_array_mut().unwrap();
        crossings.iter_mut().for_each(|crossing| crossing["from_line"] = Value::Null);
        crossings.iter_mut().for_each(|crossing| crossing["to_line"] = Value::Null);
        job
    };
    assert_eq!(facts(&found), facts(&other));

    let told = format!("detune.toml gives {}", keys.join(", "));
    for format in ["text", "sarif", "junit", "github"] {
        let ran = bench.run(&["check", "cell/jobs/a.yaml", "--format", format]);
        assert_eq!((code(&ran), err(&ran)), (1, ""), "{format}");
        assert!(flat(&ran).contains(&told), "{format}: {}", flat(&ran));
    }
    let advised = bench.run(&["advise", "cell/jobs/a.yaml"]);
    assert!(flat(&advised).contains(&told), "{}", flat(&advised));
    let advised = json(&bench.run(&["advise", "cell/jobs/a.yaml", "--format", "json"]));
    assert_eq!(advised["settings"], found["settings"]);
}

#[test]
fn the_job_wins_key_by_key() {
    let bench = Bench::new(&shared());
    bench.add(
        "cell/jobs/a.yaml",
        &format!("robot: {}\n{JOB}policy: {{separation_percent: 8}}\n", robot()),
    );
    let found = bench.check();
    assert_eq!(found["separation_percent"], 8.0);
    let keys = ["policy.ignore_hz", "policy.spindle_harmonics"];
    assert_eq!(found["settings"], value!({"file": "detune.toml", "keys": keys}));
    let lines = found["operations"][0]["lines"].as_array().unwrap();
    assert!(lines.iter().all(|line| line["source"] == "tooth_passing"), "{lines:?}");
    // A key without a value says nothing.
    bench.add(
        "cell/jobs/a.yaml",
        &format!("robot: {}\n{JOB}policy: {{separation_percent: ~}}\n", robot()),
    );
    assert_eq!(bench.check()["separation_percent"], 4.0);
    bench.add("cell/jobs/a.yaml", &format!("robot: {}\n{JOB}{POLICY}", robot()));
    assert_eq!(bench.check()["settings"], Value::Null);
}

#[test]
fn the_nearest_file_counts_alone_and_the_repository_ends_the_search() {
    let bench = Bench::new("[policy]\nseparation_percent = 3\ntooth_passing_harmonics = 5\n");
    bench.add("cell/jobs/a.yaml", &format!("robot: {}\n{JOB}", robot()));
    let separation = || bench.check()["separation_percent"].clone();
    assert_eq!(separation(), 3.0);
    bench.add("cell/detune.toml", "[policy]\nseparation_percent = 6\n");
    let found = bench.check();
    assert_eq!(found["separation_percent"], 6.0);
    let keys = ["policy.separation_percent"];
    assert_eq!(found["settings"], value!({"file": "cell/detune.toml", "keys": keys}));
    // Wherever it is called from, and however the job is named.
    let from = |folder: &str, job: &str| {
        let ran = run(&bench.0.path().join(folder), &["check", job, "--format", "json"]);
        json(&ran)["jobs"][0]["settings"]["file"].clone()
    };
    assert_eq!(from("cell/jobs", "a.yaml"), "../detune.toml");
    assert_eq!(from("cell", "jobs/../jobs/a.yaml"), "detune.toml");
    let absolute = bench.0.path().join("cell/jobs/a.yaml").display().to_string();
    let expected = bench.0.path().join("cell/detune.toml").display().to_string();
    assert_eq!(from(".", &absolute), expected.as_str());
    fs::remove_file(bench.0.path().join("cell/detune.toml")).unwrap();
    fs::create_dir(bench.0.path().join("cell/.git")).unwrap();
    assert_eq!(separation(), 10.0);
    // The root itself belongs to the repository.
    bench.add("cell/detune.toml", "[policy]\nseparation_percent = 6\n");
    assert_eq!(separation(), 6.0);
}

#[test]
fn what_is_wrong_in_it_stops_every_job() {
    let whole = format!("robot: {}\n{JOB}{POLICY}", robot());
    let rows: [(&str, &[&str]); 8] = [
        ("[policy\n", &["detune.toml:1: not valid TOML: "]),
        ("a = \nb = 'x\n", &["detune.toml:1: not valid TOML: ", "detune.toml:2: not valid TOML: "]),
        (
            "robto = 'x'\n[policy]\nseperation_percent = 3\nconfidence_percent = 120\n",
            &[
                "detune.toml:1: unknown key 'robto'; did you mean 'robot'?",
                "detune.toml:3: policy: unknown key 'seperation_percent'; did you mean 'separation_percent'?",
                "detune.toml:4: policy.confidence_percent is 120, must be a number from 50 to 99.99",
            ],
        ),
        (
            "[policy]\n\nignore_hz = [[1, 2],\n  [4, 3]]\n",
            &["detune.toml:4: policy.ignore_hz[1] is [4, 3]"],
        ),
        ("policy = 3\n", &["detune.toml:1: policy is 3, must be a mapping"]),
        (
            "[[accept]]\ncode = 'crossing'\nreason = ' '\nuntil = 2999-12-31\n",
            &[
                "detune.toml:2: accept[0]: a crossing is accepted in one job",
                "detune.toml:3: accept[0].reason is empty",
            ],
        ),
        (
            "[[accept]]\ncode = 'axis_ignord'\nreason = ' '\nuntil = '2999-02-30'\n[[accept]]\njob = 'b.yaml'\n\
             code = 'axis_ignored'\nreason = 'a'\nuntil = 2999-12-31\n[[accept]]\njob = 'cell/jobs/a.yaml'\n\
             operation = 'ruogh'\ncode = 'crossing'\nreason = 'a'\nuntil = 2999-12-31\n[[accept]]\ncode = 'value'\n",
            &[
                "detune.toml:2: accept[0].code is 'axis_ignord'",
                "detune.toml:3: accept[0].reason is empty",
                "detune.toml:4: accept[0].until is '2999-02-30'",
                "detune.toml:6: accept[1].job 'b.yaml': no such file",
                "detune.toml:12: accept[2].operation is 'ruogh', which does not exist; did you mean 'rough'?",
                "detune.toml:16: accept[3]: missing key 'reason'",
            ],
        ),
        ("robot = 3\n", &["detune.toml:1: robot is 3, must be text; put it in quotes"]),
    ];
    for (settings, told) in rows {
        let bench = Bench::new(settings);
        // The job alone is sound.
        bench.add("cell/jobs/a.yaml", &whole);
        for verb in ["check", "advise"] {
            let ran = bench.run(&[verb, "cell/jobs/a.yaml"]);
            assert_eq!((code(&ran), out(&ran)), (2, ""), "{settings}");
            for told in told {
                assert!(err(&ran).contains(told), "{told}\n{}", err(&ran));
            }
        }
    }
    // Both files' faults, each once.
    let bench = Bench::new("robto = 'x'\n");
    bench.add("cell/jobs/a.yaml", &JOB.replace("teeth: 2", "teeth: 0"));
    bench.add("cell/jobs/b.yaml", &whole);
    let ran = bench.run(&["check", "cell/jobs/a.yaml", "cell/jobs/b.yaml"]);
    let errors: Vec<&str> = err(&ran).lines().filter(|line| line.starts_with("error: ")).collect();
    assert_eq!(errors.len(), 2, "{}", err(&ran));
}

#[test]
fn a_settings_file_that_cannot_be_read_is_not_passed_over() {
    let bench = Bench::new("");
    bench.add("cell/jobs/a.yaml", &format!("robot: {}\n{JOB}", robot()));
    assert_eq!(code(&bench.run(&["check", "cell/jobs/a.yaml", "--fail-on", "never"])), 0);
    fs::create_dir(bench.0.path().join("cell/detune.toml")).unwrap();
    let ran = bench.run(&["check", "cell/jobs/a.yaml"]);
    assert_eq!(code(&ran), 2);
    assert!(err(&ran).contains("cell/detune.toml: is a folder, must be a file"), "{}", err(&ran));
    #[cfg(unix)]
    {
        let link = bench.0.path().join("cell/jobs/detune.toml");
        std::os::unix::fs::symlink("nowhere.toml", link).unwrap();
        let ran = bench.run(&["check", "cell/jobs/a.yaml"]);
        assert_eq!(code(&ran), 2);
        assert!(err(&ran).contains("cell/jobs/detune.toml: no such file"), "{}", err(&ran));
    }
    // Nor is it written over.
    let bench = Bench::new(&shared());
    let ran = bench.run(&["check", "cell/jobs/a.yaml", "--output", "detune.toml"]);
    assert_eq!(code(&ran), 2);
    assert_eq!(fs::read_to_string(bench.0.path().join("detune.toml")).unwrap(), shared());
}

#[test]
fn a_robot_that_nobody_names_and_one_that_is_not_there_are_errors() {
    let bench = Bench::new("[policy]\nseparation_percent = 3\n");
    let ran = bench.run(&["check", "cell/jobs/a.yaml"]);
    assert_eq!(code(&ran), 2);
    assert!(err(&ran).contains("cell/jobs/a.yaml:1: missing key 'robot'"), "{}", err(&ran));
    bench.add("detune.toml", "\nrobot = 'r.yaml'\n");
    let ran = bench.run(&["check", "cell/jobs/a.yaml"]);
    assert_eq!(code(&ran), 2);
    assert!(err(&ran).contains("detune.toml:2: robot 'r.yaml': no such file"), "{}", err(&ran));
    // Both files say of the harmonics that there are none.
    bench.add(
        "detune.toml",
        &format!("robot = '{}'\n[policy]\ntooth_passing_harmonics = 0\n", robot()),
    );
    bench.add("cell/jobs/a.yaml", &format!("{JOB}policy: {{spindle_harmonics: 0}}\n"));
    let ran = bench.run(&["check", "cell/jobs/a.yaml"]);
    assert_eq!(code(&ran), 2);
    let told = "detune.toml:3: policy: tooth_passing_harmonics and spindle_harmonics are both 0";
    assert!(err(&ran).contains(told), "{}", err(&ran));
}

fn accept(keys: &str) -> String {
    format!("{}\n[[accept]]\n{keys}reason = 'ran without marks'\n", shared())
}

#[test]
fn findings_are_accepted_for_a_job_and_shown() {
    let of_a = "code = 'crossing'\njob = 'cell/jobs/a.yaml'\nmode = 1\n";
    let bench = Bench::new(&accept(&format!("{of_a}until = 2999-12-31\n")));
    bench.add("cell/jobs/b.yaml", JOB);
    let ran = bench.run(&["check", "cell/jobs/a.yaml", "cell/jobs/b.yaml", "--format", "json"]);
    let found = json(&ran);
    let verdict = |i: usize| found["jobs"][i]["verdict"].as_str().unwrap();
    assert_eq!((verdict(0), verdict(1)), ("clear", "resonance"));
    let accepted = &found["jobs"][0]["operations"][0]["crossings"][0]["accepted"];
    assert_eq!(*accepted, value!({"reason": "ran without marks", "until": "2999-12-31"}));
    let keys = found["jobs"][0]["settings"]["keys"].as_array().unwrap();
    assert_eq!(keys.last().unwrap(), "accept");
    assert!(!found["jobs"][1]["settings"]["keys"].as_array().unwrap().contains(&"accept".into()));
    let text = bench.run(&["check", "cell/jobs/a.yaml"]);
    let terms = "accepted until 2999-12-31: ran without marks";
    assert!(
        out(&text).starts_with("CLEAR (1 accepted) ") && flat(&text).contains(terms),
        "{}",
        out(&text)
    );

    // The day after, it counts, with a word where it stands.
    let bench = Bench::new(&accept(&format!("{of_a}until = 2020-01-31\n")));
    let ran = bench.run(&["check", "cell/jobs/a.yaml"]);
    assert_eq!(code(&ran), 1);
    let told = "detune.toml:8: accept: 'crossing' was accepted until 2020-01-31 and counts again";
    assert!(err(&ran).contains(told), "{}", err(&ran));
    // In vain, it is told; meant for all jobs, it may be for another one.
    let other = of_a.replace("mode = 1", "mode = 2");
    let bench = Bench::new(&accept(&format!("{other}until = 2999-12-31\n")));
    let ran = bench.run(&["check", "cell/jobs/a.yaml"]);
    assert!(err(&ran).contains("detune.toml:8: accept: there is no 'crossing'"), "{}", err(&ran));
    let bench = Bench::new(&accept("code = 'axis_ignored'\nuntil = 2999-12-31\n"));
    assert_eq!(err(&bench.run(&["check", "cell/jobs/a.yaml"])), "");
    // A job names no other.
    bench.add(
        "cell/jobs/a.yaml",
        &format!("{JOB}accept: [{{code: crossing, job: b.yaml, reason: a, until: 2999-12-31}}]\n"),
    );
    let ran = bench.run(&["check", "cell/jobs/a.yaml"]);
    let told = "a.yaml:6: accept[0].job has no effect in a job";
    assert!(code(&ran) == 2 && err(&ran).contains(told), "{}", err(&ran));
}

#[test]
fn warnings_are_accepted_for_all_jobs() {
    let program = "G0 X0 Y0 Z0\nG1 X240 F400\nY40 E100\nX0\nM30\n";
    let job = "tool: {teeth: 2, payload: none}\ntcp: {xyz_m: [0, 0, 0.15]}\nwork_object: {xyz_m: [0.72, -0.12, \
               0.42]}\nspindle: {min_rpm: 500, max_rpm: 24000}\noperations:\n  - {name: rough, spindle_rpm: \
               24000, feed_mm_per_min: 400, path: {program: {file: rough.nc}}}\npolicy: {tooth_passing_harmonics: \
               1, spindle_harmonics: 0}\n";
    let robot = repository().join("robots/irb1600/robot.yaml");
    let settings = format!("robot = '{}'\n", robot.display());
    let bench = Bench::new(&settings);
    bench.add("cell/jobs/rough.nc", program);
    bench.add("cell/jobs/a.yaml", job);
    assert_eq!(bench.check()["verdict"], "uncertain");
    let entry = "[[accept]]\ncode = 'axis_ignored'\noperation = 'rough'\nreason = 'stands'\nuntil = 2999-12-31\n";
    bench.add("detune.toml", &format!("{settings}{entry}"));
    let found = bench.check();
    assert_eq!(found["verdict"], "clear");
    assert_eq!(found["warnings"][0]["accepted"]["reason"], "stands");
    bench.add("detune.toml", &format!("{settings}{}", entry.replace("rough", "finish")));
    assert_eq!(bench.check()["verdict"], "uncertain");
}

/// A job that is written where other settings count is not the job that was advised.
#[test]
fn a_job_is_not_written_where_it_would_read_other_settings() {
    let bench = Bench::new(&shared());
    let to = |file: &str| bench.run(&["advise", "cell/jobs/a.yaml", "--write", file]);
    let ran = to("cell/jobs/b.yaml");
    assert_eq!(code(&ran), 0, "{}", err(&ran));
    let checked = bench.run(&["check", "cell/jobs/b.yaml", "--fail-on", "uncertain"]);
    assert_eq!(code(&checked), 0, "{}", out(&checked));
    fs::create_dir(bench.0.path().join("other")).unwrap();
    bench.add("other/detune.toml", &shared().replace("= 4", "= 3"));
    let ran = to("other/b.yaml");
    assert_eq!(code(&ran), 2);
    assert!(err(&ran).contains("policy would differ from the advice"), "{}", err(&ran));
    bench.add("other/detune.toml", &shared());
    let ran = to("other/b.yaml");
    assert_eq!(code(&ran), 2);
    assert!(err(&ran).contains("it would read a different file"), "{}", err(&ran));
    assert!(!Path::new(&bench.0.path().join("other/b.yaml")).exists());
}
