//! The command as a user runs it: exit codes, streams, files, and what happens when something is wrong.
//!
//! The arm is the paper's, `robots/two-link`. Over β2 from 90° to 150° its first mode rises from 25.76 Hz to
//! 28.77 Hz and its second lies above 84 Hz, so one tooth-passing line decides the verdict:
//! 26 Hz (780 rpm, two teeth) lies on mode 1; 33 Hz (990 rpm) lies 14.7 % above it at the end of the path,
//! outside the band of 10 % and inside the wider one of 20 %; 40 Hz (1200 rpm) stays 39 % away.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{FORMATS, code, command, err, out, repository, run};

const RESONANT_RPM: f64 = 780.0;
const UNCERTAIN_RPM: f64 = 990.0;
const CLEAR_RPM: f64 = 1200.0;

/// A folder with jobs for the two-link arm.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        let bench = Self { folder: tempfile::tempdir().unwrap() };
        bench.add("resonant.yaml", RESONANT_RPM);
        bench.add("uncertain.yaml", UNCERTAIN_RPM);
        bench.add("clear.yaml", CLEAR_RPM);
        bench
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn add(&self, file: &str, rpm: f64) {
        let robot = repository().join("robots/two-link/robot.yaml");
        let text = format!(
            "name: Job of {rpm} rpm
robot: {}
tool: {{teeth: 2, payload: none}}
spindle: {{min_rpm: 500, max_rpm: 6000}}
operations:
  - name: rough
    spindle_rpm: {rpm}
    feed_mm_per_min: 400
    path:
      joints_deg:
        - [0, 90]
        - [0, 120]
        - [0, 150]
policy:
  tooth_passing_harmonics: 1
  spindle_harmonics: 0
",
            robot.display()
        );
        fs::write(self.path().join(file), text).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        run(self.path(), arguments)
    }

    fn names(&self) -> Vec<PathBuf> {
        let mut names: Vec<_> =
            fs::read_dir(self.path()).unwrap().map(|e| e.unwrap().file_name().into()).collect();
        names.sort();
        names
    }
}

#[test]
fn the_exit_code_follows_verdict_and_fail_on_alone() {
    let bench = Bench::new();
    let table =
        [("clear.yaml", [0, 0, 0]), ("uncertain.yaml", [0, 1, 0]), ("resonant.yaml", [1, 1, 0])];
    for (job, codes) in table {
        for (fail_on, expected) in ["resonance", "uncertain", "never"].iter().zip(codes) {
            for format in FORMATS {
                let ran = bench.run(&["check", job, "--format", format, "--fail-on", fail_on]);
                assert_eq!(code(&ran), expected, "{job} {fail_on} {format}: {}", err(&ran));
                assert!(!ran.stdout.is_empty());
            }
        }
        assert_eq!(code(&bench.run(&["check", job])), codes[0], "the default is resonance");
    }
}

#[test]
fn a_crossing_is_where_the_closed_form_puts_it() {
    let bench = Bench::new();
    let ran = bench.run(&["check", "resonant.yaml", "--format", "json"]);
    let output: Value = serde_json::from_str(out(&ran)).unwrap();
    assert_eq!(output["schema"], "check/1");
    let job = &output["jobs"][0];
    assert_eq!(job["job"], "resonant.yaml");
    assert_eq!(job["model"]["calibrated"], false);
    assert_eq!(job["model"]["uncertainty_percent"], 10.0);
    let operation = &job["operations"][0];
    let samples = operation["samples"].as_array().unwrap();
    let f1 = |sample: &Value| sample["natural_frequencies_hz"][0].as_f64().unwrap();
    // Eq. (45) of the paper with its Table 1; the second figure is that of β2 = 2.618 rad = 150°.
    assert!((f1(&samples[0]) - 25.76).abs() < 0.005, "{}", f1(&samples[0]));
    assert!((f1(samples.last().unwrap()) - 28.77).abs() < 0.005);
    let certain = operation["crossings"]
        .as_array()
        .unwrap()
        .iter()
        .find(|crossing| crossing["certainty"] == "certain")
        .unwrap();
    assert_eq!(certain["mode"], 1);
    assert_eq!(certain["source"], "tooth_passing");
    assert_eq!(certain["harmonic"], 1);
    assert_eq!(certain["excitation_hz"], 26.0);
    assert_eq!(certain["from_s"], 0.0);
    assert_eq!(certain["file"], "resonant.yaml");
    // The band ends where f1 (1 − 10 %) = 26 Hz, f1 = 28.89 Hz: beyond the end of the path.
    assert_eq!(certain["to_s"], 1.0);
    assert_eq!(certain["from_line"], 12, "the move to [0, 120] stands there");
    assert_eq!(certain["to_line"], 13);
}

#[test]
fn several_jobs_come_in_the_order_given() {
    let bench = Bench::new();
    let jobs = ["clear.yaml", "resonant.yaml", "uncertain.yaml", "clear.yaml"];
    let mut arguments = vec!["check", "--format", "json"];
    arguments.extend(jobs);
    let first = bench.run(&arguments);
    assert_eq!(code(&first), 1);
    let output: Value = serde_json::from_str(out(&first)).unwrap();
    let names: Vec<_> =
        output["jobs"].as_array().unwrap().iter().map(|job| job["job"].as_str().unwrap()).collect();
    assert_eq!(names, jobs);
    let verdicts: Vec<_> =
        output["jobs"].as_array().unwrap().iter().map(|j| &j["verdict"]).collect();
    assert_eq!(verdicts, ["clear", "resonance", "uncertain", "clear"]);
    assert_eq!(output["verdict"], "resonance");
    for format in FORMATS {
        arguments[2] = format;
        assert_eq!(bench.run(&arguments).stdout, bench.run(&arguments).stdout, "{format}");
    }
}

#[test]
fn the_tests_know_every_format() {
    let ran = Bench::new().run(&["check", "clear.yaml", "--format", "none"]);
    let listed = format!("[possible values: {}]", FORMATS.join(", "));
    assert!(err(&ran).contains(&listed), "FORMATS of program.rs lacks one: {}", err(&ran));
}

#[test]
fn no_colour_and_no_progress_where_there_is_no_terminal() {
    let bench = Bench::new();
    for format in FORMATS {
        let ran = bench.run(&["check", "resonant.yaml", "--format", format]);
        assert!(!ran.stdout.contains(&0x1b), "{format}");
        assert_eq!(err(&ran), "", "{format}");
    }
}

#[test]
fn an_output_file_is_written_whole() {
    let bench = Bench::new();
    let direct = bench.run(&["check", "resonant.yaml", "--format", "json"]);
    let ran = bench.run(&["check", "resonant.yaml", "--format", "json", "--output", "out.json"]);
    assert_eq!(code(&ran), 1);
    assert_eq!(out(&ran), "");
    assert_eq!(fs::read(bench.path().join("out.json")).unwrap(), direct.stdout);
    let dash = bench.run(&["check", "resonant.yaml", "--format", "json", "--output", "-"]);
    assert_eq!(dash.stdout, direct.stdout);
    let mut names = bench.names();
    names.retain(|name| name != Path::new("out.json"));
    assert_eq!(names, ["clear.yaml", "resonant.yaml", "uncertain.yaml"].map(PathBuf::from));
}

#[test]
fn a_wrong_job_writes_nothing_and_tells_all_faults_of_all_jobs() {
    let bench = Bench::new();
    let good = fs::read_to_string(bench.path().join("clear.yaml")).unwrap();
    fs::write(bench.path().join("a.yaml"), good.replace("teeth: 2", "teeth: 0")).unwrap();
    fs::write(bench.path().join("b.yaml"), good.replace("spindle_rpm", "spindel_rpm")).unwrap();
    fs::write(bench.path().join("old.json"), "old").unwrap();
    let before = bench.names();
    let arguments =
        ["check", "a.yaml", "clear.yaml", "b.yaml", "missing.yaml", "--output", "old.json"];
    let ran = bench.run(&arguments);
    assert_eq!(code(&ran), 2);
    assert_eq!(out(&ran), "");
    let told = err(&ran);
    for file in ["a.yaml:3: ", "b.yaml:", "missing.yaml: "] {
        assert!(told.lines().any(|line| line.starts_with(&format!("error: {file}"))), "{told}");
    }
    assert!(told.contains("did you mean 'spindle_rpm'?"), "{told}");
    assert!(told.lines().last().unwrap().starts_with("nothing was done: fix these "), "{told}");
    assert_eq!(bench.names(), before);
    assert_eq!(fs::read_to_string(bench.path().join("old.json")).unwrap(), "old");
}

/// A fault that shows only when the path is planned names the job, the operation and the line.
#[test]
fn a_path_that_cannot_be_run_is_a_fault_of_the_input() {
    let bench = Bench::new();
    let good = fs::read_to_string(bench.path().join("clear.yaml")).unwrap();
    let poses = good.replace(
        "joints_deg:
        - [0, 90]
        - [0, 120]
        - [0, 150]",
        "poses:
        - {xyz_mm: [900, 0, 0], rpy_deg: [0, 0, 0]}
        - {xyz_mm: [99000, 0, 0], rpy_deg: [0, 0, 0]}",
    );
    fs::write(bench.path().join("far.yaml"), poses).unwrap();
    let ran = bench.run(&["check", "far.yaml"]);
    assert_eq!(code(&ran), 2, "{}", out(&ran));
    let told = err(&ran);
    assert!(told.starts_with("error: far.yaml:1"), "{told}");
    assert!(told.contains("operation 'rough'"), "{told}");
    assert_eq!(out(&ran), "");
}

#[test]
fn a_place_that_cannot_be_written_is_told_before_the_work() {
    let bench = Bench::new();
    for place in ["no/such/folder/out.json", "."] {
        let ran = bench.run(&["check", "clear.yaml", "--output", place]);
        assert_eq!(code(&ran), 2, "{place}");
        assert!(err(&ran).starts_with(&format!("error: {place}: ")), "{}", err(&ran));
        assert_eq!(out(&ran), "");
    }
}

/// The reader leaves before anything is written; the verdict still counts.
#[cfg(unix)]
#[test]
fn a_closed_pipe_ends_quietly_with_the_code_of_the_verdict() {
    let bench = Bench::new();
    for (job, expected) in [("resonant.yaml", 1), ("clear.yaml", 0)] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let ran = command(bench.path(), &["check", job, "--format", "json"])
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        assert_eq!(code(&ran), expected, "{job}");
        assert_eq!(err(&ran), "", "{job}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let bench = Bench::new();
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let ran = command(bench.path(), &["check", "clear.yaml"])
        .stdout(full)
        .stderr(Stdio::piped())
        .output()
        .unwrap();
    assert_eq!(code(&ran), 2);
    assert!(err(&ran).starts_with("error: output cannot be written: "), "{}", err(&ran));
}

#[test]
fn a_wrong_command_line_exits_with_2_and_help_with_0() {
    let bench = Bench::new();
    let wrong: [&[&str]; 7] = [
        &[],
        &["chek", "clear.yaml"],
        &["check"],
        &["check", "clear.yaml", "--format", "yaml"],
        &["check", "clear.yaml", "--fail-on", "sometimes"],
        &["schema", "advise"],
        &["schema", "map"],
    ];
    for arguments in wrong {
        let ran = bench.run(arguments);
        assert_eq!(code(&ran), 2, "{arguments:?}");
        assert_eq!(out(&ran), "", "{arguments:?}");
        assert!(!ran.stderr.is_empty());
    }
    let ran = bench.run(&["schema", "map"]);
    let expected = "the output of map has no schema; there is one of robot, job, session, settings";
    assert!(err(&ran).contains(expected), "{}", err(&ran));
    for arguments in [&["--help"][..], &["check", "--help"], &["--version"]] {
        let ran = bench.run(arguments);
        assert_eq!(code(&ran), 0, "{arguments:?}");
        assert_eq!(err(&ran), "");
    }
    let help = bench.run(&["--help"]);
    for word in ["check", "schema", "completions", "Examples:", "Exit codes:"] {
        assert!(out(&help).contains(word), "{word}");
    }
}

#[test]
fn every_schema_is_json_with_a_dialect() {
    let bench = Bench::new();
    for name in ["robot", "job", "session", "settings", "check"] {
        let ran = bench.run(&["schema", name]);
        assert_eq!(code(&ran), 0);
        let schema: Value = serde_json::from_str(out(&ran)).unwrap();
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema", "{name}");
        assert_eq!(schema["type"], "object", "{name}");
    }
}

#[test]
fn completions_know_the_verbs() {
    let bench = Bench::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let ran = bench.run(&["completions", shell]);
        assert_eq!(code(&ran), 0);
        assert!(out(&ran).contains("fail-on"), "{shell}");
    }
}

#[test]
fn annotations_and_sarif_point_at_lines_of_the_job() {
    let bench = Bench::new();
    let sarif = bench.run(&["check", "resonant.yaml", "--format", "sarif"]);
    let log: Value = serde_json::from_str(out(&sarif)).unwrap();
    let place = &log["runs"][0]["results"][0]["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "resonant.yaml");
    assert_eq!(place["region"], serde_json::json!({"startLine": 12, "endLine": 13}));
    let github = bench.run(&["check", "resonant.yaml", "--format", "github"]);
    assert!(out(&github).starts_with("::error file=resonant.yaml,line=12,endLine=13,title="));
    // The same job named by its full path: the report names it as seen from the folder.
    let full = bench.path().canonicalize().unwrap().join("resonant.yaml");
    let named = bench.run(&["check", full.to_str().unwrap(), "--format", "sarif"]);
    let log: Value = serde_json::from_str(out(&named)).unwrap();
    let place = &log["runs"][0]["results"][0]["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "resonant.yaml");
}

/// No file that a run reads is written over, by whatever name.
#[cfg(unix)]
#[test]
fn an_input_is_not_written_over() {
    let bench = Bench::new();
    let here = bench.path();
    let robots = repository().join("robots/two-link");
    fs::copy(robots.join("robot.yaml"), here.join("robot.yaml")).unwrap();
    fs::copy(robots.join("two-link.urdf"), here.join("two-link.urdf")).unwrap();
    fs::create_dir(here.join("sub")).unwrap();
    std::os::unix::fs::symlink(here.join("robot.yaml"), here.join("link")).unwrap();
    let job = fs::read_to_string(here.join("clear.yaml")).unwrap();
    let named = robots.join("robot.yaml").display().to_string();
    let path = "      joints_deg:\n        - [0, 90]\n        - [0, 120]\n        - [0, 150]\n";
    fs::write(here.join("own.yaml"), job.replace(&named, "robot.yaml")).unwrap();
    let run = job.replace(&named, "robot.yaml").replace(path, "      program: {file: a.nc}\n");
    fs::write(
        here.join("run.yaml"),
        run.replace("    path", "    start_near_deg: [0, 90]\n    path"),
    )
    .unwrap();
    fs::write(here.join("a.nc"), "G1 X900 Y0 Z0\nM30\n").unwrap();
    fs::write(here.join("p.csv"), "joint_1_rad,joint_2_rad\n0,1\n").unwrap();
    let files = ["own.yaml", "clear.yaml", "robot.yaml", "two-link.urdf", "p.csv", "a.nc"];
    let texts = || files.map(|file| fs::read_to_string(here.join(file)).unwrap());
    let before = texts();
    let map = ["map", "robot.yaml", "--poses", "p.csv"];
    let check = ["check", "clear.yaml", "own.yaml"];
    for (command, output) in [
        (&check[..], "own.yaml"),
        (&check, "sub/../clear.yaml"),
        (&check, "robot.yaml"),
        (&check, "link"),
        (&check, "two-link.urdf"),
        (&["check", "run.yaml"], "a.nc"),
        (&map, "p.csv"),
        (&map, "link"),
        (&map, "two-link.urdf"),
    ] {
        let ran = bench.run(&[command, &["--output", output]].concat());
        assert_eq!(code(&ran), 2, "{output}: {}", err(&ran));
        assert!(err(&ran).contains("is read by this run as"), "{output}: {}", err(&ran));
        assert_eq!(texts(), before, "{output}");
    }
}

/// What the policy leaves out is told, and a verdict about nothing warns.
#[test]
fn what_is_left_out_is_told() {
    let bench = Bench::new();
    let job = fs::read_to_string(bench.path().join("resonant.yaml")).unwrap();
    let told = |policy: &str| {
        fs::write(bench.path().join("part.yaml"), format!("{job}{policy}\n")).unwrap();
        let json = bench.run(&["check", "part.yaml", "--format", "json"]);
        let value: Value = serde_json::from_str(out(&json)).unwrap();
        let text = out(&bench.run(&["check", "part.yaml"])).to_owned();
        (value["jobs"][0]["operations"][0]["left_out"].clone(), text, err(&json).to_owned())
    };
    let (left_out, text, warned) = told("  ignore_hz: [[20, 26], [26, 30]]");
    assert_eq!(left_out["lines"][0]["source"], "tooth_passing");
    assert_eq!(left_out["modes"], serde_json::json!([]));
    assert!(text.contains("left out tooth passing × 1 (ignored 20–26, 26–30 Hz)"), "{text}");
    assert!(
        warned
            .contains("part.yaml:6: operation 'rough': nothing was checked: every excitation line"),
        "{warned}"
    );
    // The first mode moves the tip by at most 42 µm/N on this path, the second by at least 75.
    let (left_out, text, warned) = told("  min_tip_response_um_per_n: 60");
    assert_eq!(left_out, serde_json::json!({"lines": [], "modes": [1]}), "{text}");
    assert!(text.contains("left out mode 1 (below 60.0 µm/N)"), "{text}");
    assert_eq!(warned, "");
    let (left_out, _, warned) = told("  min_tip_response_um_per_n: 100000");
    assert_eq!(left_out["modes"], serde_json::json!([1, 2]));
    assert!(
        warned.contains("nothing was checked: every mode moves the tool tip less than"),
        "{warned}"
    );
    let (left_out, text, _) = told("  ignore_hz: [[20, 25]]");
    assert_eq!(left_out, serde_json::json!({"lines": [], "modes": []}));
    assert!(!text.contains("left out"));
}

/// 60° in the 0.3 s or so that the feed leaves it is more than the URDF's 3.14 rad/s.
#[test]
fn a_feed_that_the_joints_cannot_keep_is_told() {
    let bench = Bench::new();
    let job = fs::read_to_string(bench.path().join("clear.yaml")).unwrap();
    fs::write(bench.path().join("fast.yaml"), job.replace("min: 400", "min: 400000")).unwrap();
    let ran = bench.run(&["check", "fast.yaml"]);
    let told = err(&ran);
    assert_eq!(told.lines().count(), 1, "{told}");
    assert!(told.starts_with("warning: fast.yaml:1"), "{told}");
    assert!(told.contains("operation 'rough': joint 'joint_2' would have to turn at"), "{told}");
    assert!(told.contains("its velocity limit in the URDF is"), "{told}");
    assert_eq!(err(&bench.run(&["check", "clear.yaml"])), "");
}

#[test]
fn a_schedule_that_the_spindle_cannot_follow_is_told() {
    let bench = Bench::new();
    let job = fs::read_to_string(bench.path().join("clear.yaml")).unwrap().replace(
        "spindle_rpm: 1200",
        "spindle_schedule: [{s: 0, rpm: 1200}, {s: 0.5, rpm: 1210}, {s: 0.5001, rpm: 1310}, {s: 1, rpm: 1310}]",
    );
    for (most, warns) in [("5", true), ("1e6", false)] {
        let limited = job.replace(
            "max_rpm: 6000",
            &format!("max_rpm: 6000, max_acceleration_rpm_per_s: {most}"),
        );
        fs::write(bench.path().join("s.yaml"), limited).unwrap();
        let ran = bench.run(&["check", "s.yaml"]);
        let told = err(&ran);
        assert_eq!(
            told.contains("spindle_schedule[1] to [2], from 1210 to 1310 rpm, requires"),
            warns,
            "{told}"
        );
        assert_eq!(told.is_empty(), !warns, "{told}");
    }
}

#[test]
fn notices_are_told_beside_faults_and_control_characters_do_nothing() {
    let bench = Bench::new();
    let job = fs::read_to_string(bench.path().join("clear.yaml")).unwrap();
    let faulty = job
        .replace("teeth: 2", "teeth: 0")
        .replace("    path", "    start_near_deg: [0, 90]\n    path")
        .replace("name: rough", "name: \"a\\e[31m\\ab\"");
    fs::write(bench.path().join("faulty.yaml"), &faulty).unwrap();
    let ran = bench.run(&["check", "faulty.yaml"]);
    assert_eq!(code(&ran), 2);
    let told = err(&ran);
    assert!(
        told.contains("warning: faulty.yaml:") && told.contains("start_near_deg has no effect"),
        "{told}"
    );
    assert!(told.contains("error: faulty.yaml:3: tool.teeth is 0"), "{told}");
    assert!(told.contains("a\\u{1b}[31m\\u{7}b"), "{told}");
    fs::write(bench.path().join("named.yaml"), faulty.replace("teeth: 0", "teeth: 2")).unwrap();
    let ran = bench.run(&["check", "named.yaml"]);
    for stream in [&ran.stdout, &ran.stderr] {
        assert!(!stream.iter().any(|&byte| byte == 0x1b || byte == 7));
    }
    assert!(out(&ran).contains("a\\u{1b}[31m\\u{7}b"), "{}", out(&ran));
    // Where GitHub listens, it is told in its own words, too, and standard output stays empty.
    let ran = bench.run(&["check", "faulty.yaml", "--format", "github"]);
    assert_eq!(code(&ran), 2);
    assert_eq!(out(&ran), "");
    assert!(
        err(&ran)
            .lines()
            .any(|line| line.starts_with("::error file=faulty.yaml,line=3::tool.teeth is 0")),
        "{}",
        err(&ran)
    );
    assert!(err(&ran).lines().any(|line| line.starts_with("::warning file=faulty.yaml,line=")));
}

#[test]
fn all_waypoints_out_of_reach_are_counted() {
    let bench = Bench::new();
    let job = fs::read_to_string(bench.path().join("clear.yaml")).unwrap();
    let mut poses = String::from("poses:\n        - {xyz_mm: [900, 0, 0], rpy_deg: [0, 0, 0]}\n");
    for i in 0..30 {
        poses.push_str(&format!(
            "        - {{xyz_mm: [{}, 0, 0], rpy_deg: [0, 0, 0]}}\n",
            99_000 + i
        ));
    }
    let (head, tail) = job.split_once("joints_deg:").unwrap();
    let (_, tail) = tail.split_once("policy").unwrap();
    fs::write(bench.path().join("far.yaml"), format!("{head}{poses}policy{tail}")).unwrap();
    let ran = bench.run(&["check", "far.yaml"]);
    let told = err(&ran);
    assert_eq!(code(&ran), 2);
    assert_eq!(told.lines().count(), 6, "{told}");
    assert!(
        told.lines().nth(4).unwrap().ends_with("; and 26 more waypoints are out of reach"),
        "{told}"
    );
}

/// A check of a program in the folder, milled at a speed that resonates.
fn check_program(bench: &Bench, file: &str, program: &str) -> Output {
    let robot = repository().join("robots/irb1600/robot.yaml");
    fs::write(bench.path().join(file), program).unwrap();
    let job = format!(
        "robot: {}
tool: {{teeth: 2, payload: none}}
tcp: {{xyz_m: [0, 0, 0.15]}}
work_object: {{xyz_m: [0.72, -0.12, 0.42]}}
spindle: {{min_rpm: 500, max_rpm: 6000}}
operations:
  - {{name: rough, spindle_rpm: 1100, feed_mm_per_min: 400, path: {{program: {{file: {file}}}}}}}
",
        robot.display()
    );
    fs::write(bench.path().join("program.yaml"), job).unwrap();
    bench.run(&["check", "program.yaml"])
}

/// A stop as a safety line is no stop of what follows its start, whether or not the start tells a speed.
#[test]
fn a_spindle_that_is_started_without_a_speed_is_checked() {
    let bench = Bench::new();
    let gcode = "M5\nG0 X0 Y0 Z0\nM3\nG1 X240 F400\nY40\nX0\nM30\n";
    let apt =
        "SPINDL/OFF\nGOTO/0,0,0\nSPINDL/CLW\nGOTO/240,0,0\nGOTO/240,40,0\nGOTO/0,40,0\nFINI\n";
    for (file, program) in [("pocket.nc", gcode), ("pocket.apt", apt)] {
        let ran = check_program(&bench, file, program);
        assert_eq!(code(&ran), 1, "{file}: {}{}", out(&ran), err(&ran));
        let always = program.split_once('\n').unwrap().1;
        let without = check_program(&bench, file, always);
        assert_eq!(code(&without), 1, "{file}: {}{}", out(&without), err(&without));
        assert!(!err(&ran).contains("nothing was checked"), "{}", err(&ran));
    }
}

#[test]
fn a_verdict_without_a_turning_spindle_is_told() {
    let bench = Bench::new();
    let stopped = "M5\nG0 X0 Y0 Z0\nG1 X240 F400\nY40\nX0\nM30\n";
    let ran = check_program(&bench, "stopped.nc", stopped);
    let told = "program.yaml:7: operation 'rough': nothing was checked: the program has stopped the spindle";
    assert_eq!(code(&ran), 1, "{}{}", out(&ran), err(&ran));
    assert!(out(&ran).starts_with("UNCHECKED "), "{}", out(&ran));
    assert!(err(&ran).contains(told), "{}", err(&ran));
    // One move of the three is enough.
    let ran = check_program(&bench, "stopped.nc", &stopped.replace("X0\n", "M3\nX0\n"));
    assert!(!err(&ran).contains("nothing was checked"), "{}", err(&ran));
}

/// A spindle so fast that it is through a band between two stations of the first look, in a thousandth and in a
/// millionth of the time between them: the band is met all the same, in the middle of the jump.
#[test]
fn a_band_that_is_passed_in_no_time_is_met() {
    let bench = Bench::new();
    let text = fs::read_to_string(bench.path().join("resonant.yaml")).unwrap();
    for width in [1e-5, 1e-7, 1e-9] {
        let speed = format!(
            "spindle_schedule: [{{s: 0, rpm: 560}}, {{s: 0.40003, rpm: 560}}, {{s: {}, rpm: 1200}}, {{s: 1, rpm: 1200}}]",
            0.40003 + width
        );
        let job = text.replace("spindle_rpm: 780", &speed);
        assert_ne!(job, text);
        fs::write(bench.path().join("steep.yaml"), job).unwrap();
        let ran = bench.run(&["check", "steep.yaml", "--format", "json"]);
        let told: Value = serde_json::from_slice(&ran.stdout).unwrap();
        assert_eq!(told["verdict"], "resonance", "{width}");
        let crossings = told["jobs"][0]["operations"][0]["crossings"].as_array().unwrap();
        assert_eq!(crossings.len(), 3, "{width}: {crossings:?}");
        let of = |i: usize, key: &str| crossings[i][key].as_f64().unwrap();
        // Linear in s: the bands of mode 1 at s = 0.4 are so wide in rpm, and with them in s. Bands of ±20 %.
        let natural_hz = of(1, "excitation_hz");
        let expected = width * (0.4 * natural_hz * 30.0) / 640.0;
        let found = of(2, "to_s") - of(0, "from_s");
        assert!((found / expected - 1.0).abs() < 1e-3, "{width}: {found} {expected}");
        assert!(of(1, "separation_percent") < 0.01, "{width}");
    }
}
