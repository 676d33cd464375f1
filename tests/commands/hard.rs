//! What must hold when things go wrong around the program: signals, full disks, files that are protected,
//! names that would steer a terminal or a build server.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use crate::program::{code, command, err, first_rows, out, repository, run};

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn two_link() -> String {
    repository().join("robots/two-link/robot.yaml").display().to_string()
}

fn job(name: &str, operation: &str) -> String {
    format!(
        "name: {name}\nrobot: {}\ntool: {{teeth: 2}}\nspindle: {{min_rpm: 500, max_rpm: 6000}}\n\
         operations:\n  - name: {operation}\n    spindle_rpm: 780\n    feed_mm_per_min: 400\n    \
         path: {{joints_deg: [[0, 90], [0, 150]]}}\n",
        two_link()
    )
}

/// Sends a signal as `kill` does.
#[cfg(unix)]
fn signal(process: u32, name: &str) {
    let sent = std::process::Command::new("kill")
        .args([format!("-{name}"), process.to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
}

/// The program is ended while its file stands beside its place, unnamed.
#[cfg(unix)]
#[test]
fn a_signal_leaves_nothing_behind() {
    use std::os::unix::process::ExitStatusExt;
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        let mut hits = 0;
        for _ in 0..20 {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join("map.csv"), "old").unwrap();
            let robot = two_link();
            let arguments = ["map", &robot, "--random", "400000", "--output", "map.csv", "--quiet"];
            let mut child =
                command(folder.path(), &arguments).stderr(Stdio::null()).spawn().unwrap();
            let start = Instant::now();
            while names(folder.path()).len() < 2
                && child.try_wait().unwrap().is_none()
                && start.elapsed() < Duration::from_secs(60)
            {
                thread::sleep(Duration::from_micros(200));
            }
            if child.try_wait().unwrap().is_none() {
                signal(child.id(), name);
            }
            let status = child.wait().unwrap();
            assert_eq!(names(folder.path()), ["map.csv"], "{name}");
            if status.signal() == Some(number) {
                let text = fs::read_to_string(folder.path().join("map.csv")).unwrap();
                // The old file or the new one, whole.
                assert!(text == "old" || text.lines().count() == 400_001, "{name}");
                hits += 1;
                if hits == 2 {
                    break;
                }
            }
        }
        assert!(hits > 0, "no run was met by SIG{name}");
    }
}

#[cfg(unix)]
#[test]
fn a_protected_file_is_not_replaced() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.json");
    fs::write(folder.path().join("job.yaml"), job("a", "rough")).unwrap();
    fs::write(&path, "mine").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
    for verb in ["check", "advise"] {
        let output =
            run(folder.path(), &[verb, "job.yaml", "--format", "json", "--output", "out.json"]);
        assert_eq!(code(&output), 2);
        assert!(err(&output).contains("out.json: is write-protected"), "{}", err(&output));
    }
    assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
    assert_eq!(names(folder.path()), ["job.yaml", "out.json"]);
}

/// Two at once: one file is there at the end, whole.
#[test]
fn two_writers_leave_one_whole_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("job.yaml"), job("a", "rough")).unwrap();
    let arguments = ["check", "job.yaml", "--format", "json", "--output", "out.json"];
    let mut children: Vec<_> = (0..6)
        .map(|_| command(folder.path(), &arguments).stderr(Stdio::null()).spawn().unwrap())
        .collect();
    for child in &mut children {
        assert_eq!(child.wait().unwrap().code(), Some(1));
    }
    assert_eq!(names(folder.path()), ["job.yaml", "out.json"]);
    let alone = run(folder.path(), &["check", "job.yaml", "--format", "json"]);
    assert_eq!(fs::read_to_string(folder.path().join("out.json")).unwrap(), out(&alone));
}

/// `/dev/full` is a disk without room.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_of_every_verb() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("job.yaml"), job("a", "rough")).unwrap();
    let robot = two_link();
    let measured = poses_in(folder.path(), 4);
    for arguments in [
        vec!["check", "job.yaml"],
        vec!["advise", "job.yaml"],
        vec!["explain"],
        vec!["diagnose", &robot, &measured],
        vec!["map", &robot, "--random", "10"],
        vec!["map", &robot, "--random", "10", "--format", "sketch"],
        vec!["schema", "job"],
    ] {
        for to_option in [false, true] {
            let mut all = arguments.clone();
            if to_option {
                if ["explain", "schema"].contains(&all[0]) {
                    continue;
                }
                all.extend(["--output", "/dev/full"]);
            }
            let mut child = command(folder.path(), &all);
            if !to_option {
                let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
                child.stdout(full);
            }
            let output = child.stderr(Stdio::piped()).output().unwrap();
            assert_eq!(code(&output), 2, "{all:?}: {}", err(&output));
            assert!(err(&output).contains("No space left"), "{all:?}: {}", err(&output));
        }
    }
}

/// The first poses of the paper's table: a diagnosis of six takes a sixth of the time of all and has findings, one of
/// four is over at once.
fn poses_in(folder: &Path, count: usize) -> String {
    let path = folder.join("few.csv");
    fs::write(&path, first_rows("measured.csv", count)).unwrap();
    path.display().to_string()
}

/// Names with what clears a screen, turns writing round, or is a command to a build server.
const HOSTILE: [&str; 6] = [
    "a\u{1b}[2J\u{7}b",
    "::error file=x::pwned",
    "a\n::stop-commands::x",
    "a\u{9b}31m\u{202e}b",
    "x ##vso[task.setvariable variable=a]b ##[add-path]c",
    "words words words words words words words words words words words words words words ::warning::x",
];

fn quoted(text: &str) -> String {
    serde_json::to_string(text).unwrap()
}

/// What a terminal or a build server would act on.
fn commands_in(text: &str) -> Vec<String> {
    let is_bad = |line: &&str| {
        line.trim_start().starts_with("::")
            || line.contains("##")
            || line.chars().any(|c| c.is_control() || ('\u{202a}'..='\u{202e}').contains(&c))
    };
    text.split('\n').filter(is_bad).map(str::to_owned).collect()
}

#[test]
fn no_name_of_a_user_reaches_a_terminal_or_a_build_server() {
    for (index, name) in HOSTILE.iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        let put = |file: &str, text: String| fs::write(folder.path().join(file), text).unwrap();
        let xml = name.replace('\n', "&#10;").replace(['\u{1b}', '\u{7}'], "");
        let urdf = repository().join("robots/two-link/two-link.urdf");
        let urdf = fs::read_to_string(urdf)
            .unwrap()
            .replace("joint_2", &xml)
            .replace("link_2", &format!("l {xml}"));
        put("arm.urdf", urdf);
        let joint = xml.replace("&#10;", "\n");
        let robot = fs::read_to_string(repository().join("robots/two-link/robot.yaml")).unwrap();
        let robot = robot
            .replace("two-link.urdf", "arm.urdf")
            .replace("joint_2", &quoted(&joint))
            .replace("link_2", &quoted(&format!("l {joint}")));
        put("robot.yaml", robot);
        let text = job(&quoted(name), &quoted(name)).replace(&two_link(), "robot.yaml");
        put("job.yaml", text);
        let job_file = "job.yaml";
        let measured = poses_in(folder.path(), 6);
        let mut ends = Vec::new();
        let mut all = vec![
            vec!["check", job_file],
            vec!["check", job_file, "--summary"],
            vec!["check", job_file, "--format", "junit"],
            vec!["advise", job_file],
            vec!["doctor", "robot.yaml"],
            vec!["map", "robot.yaml", "--random", "3", "--reduce", "mean"],
        ];
        // It takes its time: a name that clears the screen and one that is wrapped.
        if index == 0 || index == 5 {
            all.push(vec!["diagnose", "robot.yaml", &measured]);
        }
        for arguments in all {
            let output = run(folder.path(), &arguments);
            ends.push(code(&output));
            for text in [out(&output), err(&output)] {
                let bad = commands_in(text);
                // A table keeps the names of its columns, in quotes.
                let is_table = arguments[0] == "map";
                assert!(bad.is_empty() || is_table, "{index}: {arguments:?}: {bad:?}");
            }
        }
        // Workflow commands are the format's own: one a line, all of them detune's.
        let output = run(folder.path(), &["check", job_file, "--format", "github"]);
        for line in out(&output).lines().chain(err(&output).lines()) {
            let own =
                ["::error file=", "::warning file=", "::notice file=", "::error::", "::warning::"];
            let is_own =
                !line.trim_start().starts_with("::") || own.iter().any(|own| line.starts_with(own));
            assert!(is_own && !line.contains('\u{1b}'), "{index}: {line}");
        }
        assert!(ends[0] != 3 && ends.iter().all(|end| *end <= 2), "{index}: {ends:?}");
    }
}

/// A fingerprint is that of the finding, wherever the command runs.
#[test]
fn fingerprints_do_not_depend_on_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("repository/.git")).unwrap();
    fs::create_dir_all(folder.path().join("repository/jobs")).unwrap();
    fs::write(folder.path().join("repository/jobs/a.yaml"), job("a", "rough")).unwrap();
    let prints = |from: &str, file: &str, format: &str| -> Vec<String> {
        let output = run(&folder.path().join(from), &["check", file, "--format", format]);
        let log: serde_json::Value = serde_json::from_str(out(&output)).unwrap();
        let own = match format {
            "sarif" => log["runs"][0]["results"]
                .as_array()
                .unwrap()
                .iter()
                .map(|result| result["partialFingerprints"].to_string())
                .collect::<Vec<_>>(),
            _ => log
                .as_array()
                .unwrap()
                .iter()
                .map(|entry| entry["fingerprint"].to_string() + &entry["location"].to_string())
                .collect(),
        };
        assert!(!own.is_empty());
        own
    };
    for format in ["sarif", "gitlab"] {
        let of_root = prints("repository", "jobs/a.yaml", format);
        assert!(of_root.iter().any(|print| print.contains("jobs/a.yaml")), "{of_root:?}");
        assert_eq!(prints("repository/jobs", "a.yaml", format), of_root);
        assert_eq!(prints(".", "repository/jobs/a.yaml", format), of_root);
    }
}

/// Time in seconds that a command takes.
fn seconds(folder: &Path, arguments: &[&str]) -> (f64, i32, String) {
    let start = Instant::now();
    let output = run(folder, arguments);
    (start.elapsed().as_secs_f64(), code(&output), err(&output).to_owned())
}

#[test]
fn hostile_files_take_no_time() {
    let folder = tempfile::tempdir().unwrap();
    let put = |file: &str, text: String| -> PathBuf {
        let path = folder.path().join(file);
        fs::write(&path, text).unwrap();
        path
    };
    let yaml = "urdf: arm.urdf\nelasticity: {joints: {a: {stiffness_nm_per_rad: 1}}}\n";
    put("robot.yaml", yaml.to_owned());
    let map = ["map", "robot.yaml", "--random", "1"];
    // A million elements in one another, left open or closed.
    for text in ["<v>".repeat(1_000_000), "<v>".repeat(500_000) + &"</v>".repeat(500_000)] {
        put("arm.urdf", format!("<robot name=\"r\">{text}"));
        let (time, code, told) = seconds(folder.path(), &map);
        assert!(code == 2 && time < 20.0, "{time} s: {told}");
    }
    // Twenty thousand data sets of one point.
    let set = |node: usize| {
        format!(
            "    -1\n    58\n{}{:5}{:10}{:5}{:10} {:>10}{node:10}{:4} {:>10}{:10}{:4}\n         2         \
             4         1  0.0 0.1 0.0\n        17    0    0    0 NONE NONE\n         8    0    0    0 \
             NONE m\n         0    0    0    0 NONE NONE\n         0    0    0    0 NONE NONE\n \
             1.0 2.0 1.5 0.5\n    -1\n",
            "NONE\n".repeat(5),
            1,
            0,
            0,
            0,
            "NONE",
            3,
            "NONE",
            0,
            0
        )
    };
    put("many.uff", (1..=20_000).map(set).collect());
    put("session.yaml", "records: [{file: many.uff, pose: {beta2_rad: 1}}]\n".to_owned());
    let (time, code, told) = seconds(folder.path(), &["identify", "session.yaml"]);
    assert!(code == 2 && time < 20.0, "{time} s: {told}");
    assert!(told.contains("more than 4096 data sets"), "{told}");
    // Thousands of springs.
    let robot = fs::read_to_string(repository().join("robots/two-link/robot.yaml")).unwrap();
    let urdf = repository().join("robots/two-link/two-link.urdf").display().to_string();
    let extra: String = (0..3000)
        .map(|i| format!("    - {{name: e{i}, link: link_1, kind: rotation, axis: [0, 0, 1], stiffness: 1e6}}\n"))
        .collect();
    let robot = robot.replace("two-link.urdf", &urdf);
    put(
        "robot.yaml",
        robot.replacen("elasticity:\n", &format!("elasticity:\n  extra:\n{extra}"), 1),
    );
    let (time, code, told) = seconds(folder.path(), &map);
    assert!(code == 2 && time < 20.0, "{time} s: {told}");
    assert!(told.contains("elastic coordinates, must be at most 100"), "{told}");
}
