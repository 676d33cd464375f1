//! What is written about jobs and maps that nobody would call usual: numbers of any size, schedules, many
//! harmonics, many jobs, names with control characters, and maps of very large vibrations.
//!
//! The arm is the paper's, `robots/two-link`: over β2 from 90° to 150° its modes stay within 25–29 Hz and
//! 83–145 Hz.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{self, command, err, repository, run};

/// No line of a report for people is longer than this, characters.
const LONGEST_LINE: usize = 140;

/// No word of a report with short names, and so no number, is longer than this, characters: the longest is the
/// rule below a drawing.
const MAX_WORD_BYTES: usize = 80;

const PATH: &str = "path: {joints_deg: [[0, 90], [0, 120], [0, 150]]}";

fn out(output: &Output) -> &str {
    let text = program::out(output);
    assert!(!text.is_empty(), "nothing printed: {}", err(output));
    text
}

/// A job of the two-link arm with these operations and this policy, both as YAML flow.
fn add(folder: &TempDir, file: &str, name: &str, operations: &[String], policy: &str) -> PathBuf {
    let robot = repository().join("robots/two-link/robot.yaml");
    let operations: String = operations.iter().map(|o| format!("  - {o}\n")).collect();
    let text = format!(
        "name: {name}\nrobot: {}\ntool: {{teeth: 2, payload: none}}\nspindle: {{min_rpm: 1, max_rpm: 60000}}\n\
         operations:\n{operations}policy: {{{policy}}}\n",
        robot.display()
    );
    let path = folder.path().join(file);
    fs::write(&path, text).unwrap();
    path
}

fn operation(name: &str, speed: &str, feed: &str) -> String {
    format!("{{name: {name}, {speed}, feed_mm_per_min: {feed}, {PATH}}}")
}

fn names(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).unwrap();
    names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// Frequencies at the axis of the first drawing, from the top.
fn ticks(text: &str) -> Vec<f64> {
    text.lines()
        .filter_map(|line| line.split_once(" ┤"))
        .map(|(tick, _)| tick.trim().parse().unwrap())
        .collect()
}

#[test]
fn numbers_of_any_size_stay_short() {
    let folder = tempfile::tempdir().unwrap();
    for feed in ["1e-200", "1e+9", "1e+200"] {
        let operations = [operation("a", "spindle_rpm: 780", feed)];
        add(&folder, "job.yaml", "Job", &operations, "separation_percent: 1e-12");
        if feed == "1e+200" {
            let refused = run(folder.path(), &["check", "job.yaml"]);
            assert_eq!(refused.status.code(), Some(2), "{refused:?}");
            assert!(String::from_utf8_lossy(&refused.stderr).contains("must be at most 1e9"));
            continue;
        }
        for format in ["text", "junit", "github"] {
            let text =
                out(&run(folder.path(), &["check", "job.yaml", "--format", format])).to_owned();
            let longest = text.split_whitespace().map(|word| word.chars().count()).max();
            assert!(longest.unwrap() <= MAX_WORD_BYTES, "{format}, feed {feed}:\n{text}");
        }
    }
}

/// 20 harmonics of up to 6000 rpm reach 4000 Hz; the modes end at 145 Hz.
#[test]
fn a_drawing_keeps_to_the_modes() {
    let folder = tempfile::tempdir().unwrap();
    let speed = "spindle_schedule: [{s: 0, rpm: 500}, {s: 0.33337, rpm: 6000}, {s: 1, rpm: 700}]";
    let harmonics = "tooth_passing_harmonics: 20, spindle_harmonics: 3";
    add(&folder, "job.yaml", "Job", &[operation("a", speed, "400")], harmonics);
    let text = out(&run(folder.path(), &["check", "job.yaml"])).to_owned();
    let ticks = ticks(&text);
    assert!(ticks.iter().all(|&tick| (0.0..180.0).contains(&tick)), "{ticks:?}\n{text}");
    let longest = text.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(longest <= LONGEST_LINE, "{longest}\n{text}");
    assert!(text.contains("lines are drawn"), "{text}");
}

#[test]
fn many_operations_are_summed_up() {
    let folder = tempfile::tempdir().unwrap();
    let operations: Vec<String> = (0..100)
        .map(|i| {
            let rpm = if i % 40 == 39 { 780 } else { 1400 };
            operation(&format!("op{i}"), &format!("spindle_rpm: {rpm}"), "400")
        })
        .collect();
    add(
        &folder,
        "job.yaml",
        "Job",
        &operations,
        "tooth_passing_harmonics: 1, spindle_harmonics: 0",
    );
    let text = out(&run(folder.path(), &["check", "job.yaml"])).to_owned();
    assert!(text.lines().count() < 200, "{} lines", text.lines().count());
    assert!(text.contains("op39  RESONANCE") && text.contains("op79  RESONANCE"), "{text}");
    assert!(text.contains("… and 80 more operations: 80 clear; --format json lists all"), "{text}");
}

#[test]
fn a_schedule_is_told_in_json_and_in_text() {
    let folder = tempfile::tempdir().unwrap();
    let speed = "spindle_schedule: [{s: 0.2, rpm: 2000}, {s: 0.5, rpm: 900}, {s: 0.7, rpm: 2400}]";
    let operations = [operation("a", speed, "400"), operation("b", "spindle_rpm: 800", "400")];
    add(&folder, "job.yaml", "Job", &operations, "");
    let output = run(folder.path(), &["check", "job.yaml", "--format", "json"]);
    let json: Value = serde_json::from_str(out(&output)).unwrap();
    let [a, b] = [0, 1].map(|i| &json["jobs"][0]["operations"][i]);
    assert_eq!(a["spindle_rpm"], 2000.0);
    assert_eq!([&a["spindle_min_rpm"], &a["spindle_max_rpm"]], [900.0, 2400.0]);
    assert_eq!(a["spindle_schedule"][1], serde_json::json!({"s": 0.5, "rpm": 900.0}));
    assert_eq!(a["spindle_schedule"].as_array().unwrap().len(), 3);
    assert_eq!([&b["spindle_min_rpm"], &b["spindle_max_rpm"]], [800.0, 800.0]);
    assert!(b["spindle_schedule"].is_null() && b.get("spindle_schedule").is_some());
    let text = out(&run(folder.path(), &["check", "job.yaml"])).to_owned();
    assert!(text.contains("  900–2400 rpm, "), "{text}");
}

#[test]
fn many_jobs_end_with_what_is_not_clear() {
    let folder = tempfile::tempdir().unwrap();
    let policy = "tooth_passing_harmonics: 1, spindle_harmonics: 0";
    let files: Vec<String> = (0..40)
        .map(|i| {
            let rpm = if i < 15 { 780 } else { 1400 };
            let file = format!("job{i:02}.yaml");
            let speed = format!("spindle_rpm: {rpm}");
            add(&folder, &file, "Job", &[operation("a", &speed, "400")], policy);
            file
        })
        .collect();
    let mut arguments = vec!["check"];
    arguments.extend(files.iter().map(String::as_str));
    let page = out(&run(folder.path(), &arguments)).to_owned();
    assert!(
        page.starts_with("40 jobs: 15 resonance, 25 clear\n  RESONANCE  job00.yaml\n    why "),
        "{page}"
    );
    assert!(page.lines().count() <= 60, "{page}");
    arguments.push("--summary=never");
    let text = out(&run(folder.path(), &arguments)).to_owned();
    let last: Vec<&str> = text.lines().rev().take(13).collect();
    assert!(
        text.contains("\n40 jobs: 15 resonance, 25 clear\n  RESONANCE  job00.yaml\n"),
        "{text}"
    );
    assert_eq!(last[0], "  … and 5 more; --format json lists all");
    arguments.extend(["--format", "github"]);
    let github = out(&run(folder.path(), &arguments)).to_owned();
    let summary = github.lines().last().unwrap();
    assert!(summary.starts_with("detune check: 40 jobs: 15 resonance, 25 clear; "), "{summary}");
    assert!(summary.len() < 400 && summary.ends_with("… and 5 more"), "{summary}");
}

/// 780 rpm and two teeth meet mode 1 (26 Hz) exactly; a band of 1e-12 % is a band all the same.
#[test]
fn small_separations_are_not_called_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let policy = "tooth_passing_harmonics: 1, spindle_harmonics: 0, separation_percent: 1e-12";
    add(&folder, "job.yaml", "Job", &[operation("a", "spindle_rpm: 780", "400")], policy);
    let text = out(&run(folder.path(), &["check", "job.yaml"])).to_owned();
    assert!(text.contains("apart    less than 1e-6 %, outside"), "{text}");
    assert!(text.contains("the band of ±1.00e-12 %"), "{text}");
    assert!(!text.contains("apart    0.0 %") && !text.contains("±0 %"), "{text}");
}

/// An escape sequence that would switch a terminal's colours, a bell, and U+FFFE, which XML forbids.
#[test]
fn control_characters_of_names_are_escaped() {
    let folder = tempfile::tempdir().unwrap();
    let odd = r#""a\e[31m\a\uFFFE\u202Eb""#;
    let operations = [operation(odd, "spindle_rpm: 780", "400")];
    add(&folder, "job.yaml", odd, &operations, "tooth_passing_harmonics: 1");
    for format in ["text", "junit", "github", "sarif"] {
        let text = out(&run(folder.path(), &["check", "job.yaml", "--format", format])).to_owned();
        let bad = |c: char| (c.is_control() && c != '\n') || ['\u{fffe}', '\u{202e}'].contains(&c);
        assert!(!text.contains(bad), "{format}: {text:?}");
        let told = if format == "sarif" { r"a\\u{1b}[31m" } else { r"a\u{1b}[31m" };
        assert!(text.contains(told), "{format}: {text}");
    }
    // JSON keeps the name as it is, in its own spelling.
    let output = run(folder.path(), &["check", "job.yaml", "--format", "json"]);
    let json: Value = serde_json::from_str(out(&output)).unwrap();
    assert_eq!(json["jobs"][0]["name"], "a\u{1b}[31m\u{7}\u{fffe}\u{202e}b");

    let robot = fs::read_to_string(repository().join("robots/two-link/robot.yaml")).unwrap();
    let name = robot.lines().find(|line| line.starts_with("name:")).unwrap();
    fs::write(folder.path().join("robot.yaml"), robot.replace(name, &format!("name: {odd}")))
        .unwrap();
    let urdf = "two-link.urdf";
    fs::copy(repository().join("robots/two-link").join(urdf), folder.path().join(urdf)).unwrap();
    let map = "map robot.yaml --joint joint_2 --from-deg 0 --to-deg 9 --steps 3 --format svg";
    let svg = out(&run(folder.path(), &map.split(' ').collect::<Vec<_>>())).to_owned();
    assert!(svg.contains(r"a\u{1b}[31m\u{7}\u{fffe}\u{202e}b"), "{svg}");
}

fn map(more: &str) -> Vec<String> {
    let line = format!("map robots/two-link --joint joint_2 {more}");
    line.split(' ').map(str::to_owned).collect()
}

fn mapped(more: &str) -> Output {
    let arguments = map(more);
    run(repository(), &arguments.iter().map(String::as_str).collect::<Vec<_>>())
}

#[test]
fn options_of_the_nonlinear_method_need_it() {
    for option in ["--amplitude-deg 2", "--sample-rate-hz 140 --duration-s 5"] {
        let output = mapped(&format!("--from-deg 0 --to-deg 9 --steps 3 {option}"));
        assert_eq!(output.status.code(), Some(2), "{option}");
        assert!(output.stdout.is_empty());
        let told = err(&output);
        let name = option.split(' ').next().unwrap();
        assert!(told.contains(name) && told.contains("--method nonlinear"), "{told}");
    }
}

#[test]
fn a_nonlinear_map_has_the_same_bytes_for_any_number_of_threads() {
    let line = map("--from-deg 60 --to-deg 140 --steps 7 --method nonlinear --format json");
    let arguments: Vec<&str> = line.iter().map(String::as_str).collect();
    let bytes = |threads: &str| {
        let mut command = command(repository(), &arguments);
        command.env("RAYON_NUM_THREADS", threads).output().unwrap().stdout
    };
    let one = bytes("1");
    assert!(one.len() > 500);
    assert!(one == bytes("2") && one == bytes("5"));
}

/// At 20° all peaks are near the modes. At 60° and β2 = 90° the peak of mode 2 has gone from 84 to 114 Hz and its
/// side bands stand beside it, and at 90° every pose has peaks far from its modes.
#[test]
fn peaks_that_may_be_no_modes_are_told() {
    let sweep = "--from-deg 30 --to-deg 150 --steps 3 --method nonlinear --format json";
    let doubts = |degrees: &str| {
        let output = mapped(&format!("{sweep} --amplitude-deg {degrees}"));
        let json: Value = serde_json::from_str(out(&output)).unwrap();
        let rows = json["rows"].as_array().unwrap().iter();
        let doubts: Vec<Value> = rows.map(|row| row["nonlinear"]["doubtful"].clone()).collect();
        (doubts, err(&output).to_owned())
    };
    let far = serde_json::json!([{"mode": 2, "reason": "far_from_linear"}]);
    let none = serde_json::json!([]);
    let (small, told) = doubts("20");
    assert!(small.iter().all(|doubts| *doubts == none) && told.is_empty(), "{small:?} {told}");
    let (large, told) = doubts("60");
    assert_eq!(large, [none.clone(), far.clone(), none]);
    assert!(
        told.contains("1 frequency may not be of modes") && told.contains("--amplitude-deg"),
        "{told}"
    );
    let (huge, _) = doubts("90");
    assert_eq!(huge[..2], [far.clone(), far]);
}

#[test]
fn poses_beyond_the_joint_limits_are_told() {
    let line = "map robots/irb1600 --joint joint_2 --from-deg -300 --to-deg 0 --steps 4";
    let output = run(repository(), &line.split(' ').collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(0));
    let told = err(&output);
    assert!(told.contains("3 of 4 poses lie outside the joint limits"), "{told}");
    assert!(told.contains("joint_2") && told.contains("-300"), "{told}");
}

/// A map that is interrupted leaves its folder as it was.
#[cfg(unix)]
#[test]
fn an_interrupted_map_leaves_no_debris() {
    for method in ["nonlinear", "linear"] {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("map.csv");
        let line = map(&format!(
            "--from-deg 60 --to-deg 140 --steps 40000000 --method {method} --output {}",
            file.display()
        ));
        let mut child = command(repository(), &line.iter().map(String::as_str).collect::<Vec<_>>())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(500));
        assert_eq!(child.try_wait().unwrap(), None, "{method}: it ended before it was interrupted");
        let pid = child.id().to_string();
        // Not SIGINT, which programs that are started in the background of a shell do not hear.
        assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
        assert!(!child.wait().unwrap().success());
        assert_eq!(names(folder.path()), [""; 0], "{method}");
    }
}
