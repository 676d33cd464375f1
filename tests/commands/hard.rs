//! What must hold when things go wrong around the program: signals, full disks, files that are protected,
//! names that would steer a terminal or a build server.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use crate::program::{code, command, err, first_rows, json, out, repository, run};

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

/// Files that belong together: a signal meets the run as soon as the first of them is there.
#[cfg(unix)]
#[test]
fn files_land_together_or_not_at_all() {
    use std::os::unix::process::ExitStatusExt;
    let urdf = repository().join("tests/data/reference/ur10.urdf");
    let cases: [(&[&str], &[&str]); 2] = [
        (
            &["init", "arm.urdf", "--output", "cell"],
            &["cell/robot.yaml", "cell/jobs/first.yaml", "cell/.github/workflows/detune.yml"],
        ),
        (
            &["advise", "job.yaml", "--write", "new.yaml", "--output", "out.txt"],
            &["new.yaml", "out.txt"],
        ),
    ];
    for (arguments, files) in cases {
        let mut hits = 0;
        for _ in 0..40 {
            let folder = tempfile::tempdir().unwrap();
            fs::copy(&urdf, folder.path().join("arm.urdf")).unwrap();
            fs::write(folder.path().join("job.yaml"), job("a", "rough")).unwrap();
            let whole = |path: &str| folder.path().join(path).exists();
            let mut child = command(folder.path(), arguments)
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            while !files.iter().any(|file| whole(file)) && child.try_wait().unwrap().is_none() {}
            if child.try_wait().unwrap().is_none() {
                signal(child.id(), "TERM");
            }
            let is_met = child.wait().unwrap().signal() == Some(15);
            let there: Vec<bool> = files.iter().map(|file| whole(file)).collect();
            assert!(there.windows(2).all(|pair| pair[0] == pair[1]), "{arguments:?}: {there:?}");
            // Not even a folder.
            assert!(there[0] || !folder.path().join("cell").exists());
            hits += usize::from(is_met);
            if hits == 3 {
                break;
            }
        }
        assert!(hits > 0, "{arguments:?}: no run was met by the signal");
    }
}

/// Closed from the start, and, for what is no verb's output, a disk without room.
#[cfg(target_os = "linux")]
#[test]
fn nothing_is_printed_to_nowhere_without_an_error() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("job.yaml"), job("a", "rough")).unwrap();
    let closed = |arguments: &str| {
        let mut shell = std::process::Command::new("sh");
        let program = crate::program::tested();
        shell.args(["-c", &format!("\"$0\" {arguments} >&-")]).arg(program);
        shell.current_dir(folder.path()).stdin(Stdio::null()).output().unwrap()
    };
    for arguments in
        ["check job.yaml", "advise job.yaml --write new.yaml", "explain", "--help", "-V", "-V -v"]
    {
        let output = closed(arguments);
        assert_eq!(code(&output), 2, "{arguments}: {}", err(&output));
        let told = "error: output cannot be written: standard output is closed";
        assert!(err(&output).contains(told), "{arguments}: {}", err(&output));
    }
    assert_eq!(names(folder.path()), ["job.yaml"]);
    // What prints nothing needs none.
    let output = closed("check job.yaml --output out.txt --fail-on never");
    assert_eq!(code(&output), 0, "{}", err(&output));
    for arguments in [&["--help"][..], &["check", "-h"], &["--version"], &["-V", "-v"]] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut child = command(folder.path(), arguments);
        let output = child.stdout(full).stderr(Stdio::piped()).output().unwrap();
        assert_eq!(code(&output), 2, "{arguments:?}");
        assert!(err(&output).contains("No space left"), "{arguments:?}: {}", err(&output));
    }
    // The null device is no closed file, however it was opened.
    let null = fs::OpenOptions::new().read(true).write(true).open("/dev/null").unwrap();
    let output = command(folder.path(), &["explain"]).stdout(null).output().unwrap();
    assert_eq!(code(&output), 0, "{}", err(&output));
}

/// Names with what clears a screen, turns writing round, or is a command to a build server.
const HOSTILE: [&str; 7] = [
    "a\u{1b}[2J\u{7}b",
    "::error file=x::pwned",
    "a\n::stop-commands::x",
    "a\u{9b}31m\u{202e}b",
    "x ##vso[task.setvariable variable=a]b ##[add-path]c",
    "words words words words words words words words words words words words words words ::warning::x",
    "a\u{2028}::error::z\u{85} ::error::q\u{2066}\u{2069}\u{7f}",
];

fn quoted(text: &str) -> String {
    serde_json::to_string(text).unwrap()
}

/// What a terminal or a build server would act on.
fn commands_in(text: &str) -> Vec<String> {
    let is_bad = |line: &&str| {
        line.trim_start().starts_with("::")
            || line.contains("##")
            || line.chars().any(|c| {
                c.is_control() || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
            })
    };
    text.split('\n').filter(is_bad).map(str::to_owned).collect()
}

/// Whether a text stands anywhere in JSON.
fn has_text(json: &serde_json::Value, text: &str) -> bool {
    match json {
        serde_json::Value::String(own) => own == text,
        serde_json::Value::Array(all) => all.iter().any(|own| has_text(own, text)),
        serde_json::Value::Object(all) => all.values().any(|own| has_text(own, text)),
        _ => false,
    }
}

#[test]
fn no_name_of_a_user_reaches_a_terminal_or_a_build_server() {
    for (index, name) in HOSTILE.iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        let put = |file: &str, text: String| fs::write(folder.path().join(file), text).unwrap();
        // A URDF whose names hold control characters is refused: they stand in the other files.
        let joint = name.replace(char::is_control, "");
        let urdf = repository().join("robots/two-link/two-link.urdf");
        let urdf = fs::read_to_string(urdf)
            .unwrap()
            .replace("joint_2", &joint)
            .replace("link_2", &format!("l {joint}"));
        put("arm.urdf", urdf);
        let robot = fs::read_to_string(repository().join("robots/two-link/robot.yaml")).unwrap();
        let robot = robot
            .replace("two-link.urdf", "arm.urdf")
            .replace("joint_2", &quoted(&joint))
            .replace("link_2", &quoted(&format!("l {joint}")));
        put("robot.yaml", robot);
        let text = job(&quoted(name), &quoted(name)).replace(&two_link(), "robot.yaml");
        put("job.yaml", text);
        let job_file = "job.yaml";
        let session = fs::read_to_string(repository().join("robots/two-link/session.yaml"));
        let records = repository().join("robots/two-link/session").display().to_string();
        let session = session
            .unwrap()
            .replace("id: decay-1", &format!("id: {}", quoted(&name.replace('\n', " "))))
            .replace("file: session", &format!("file: {records}"));
        put("session.yaml", session);
        let measured = poses_in(folder.path(), 6);
        let mut all = vec![
            vec!["check", job_file],
            vec!["check", job_file, "--summary"],
            vec!["check", job_file, "--format", "junit"],
            vec!["check", job_file, "--format", "json"],
            vec!["check", job_file, "--format", "sarif"],
            vec!["check", job_file, "--format", "gitlab"],
            vec!["check", job_file, "--format", "html"],
            vec!["advise", job_file],
            vec!["advise", job_file, "--format", "json"],
            vec!["advise", job_file, "--format", "html"],
            vec!["report", job_file],
            vec!["report", job_file, "--format", "json"],
            vec!["identify", "session.yaml"],
            vec!["identify", "session.yaml", "--format", "json"],
            vec!["identify", "session.yaml", "--format", "html"],
            vec!["doctor", "robot.yaml"],
            vec!["map", "robot.yaml", "--random", "3"],
            vec!["map", "robot.yaml", "--random", "3", "--format", "json"],
            vec!["map", "robot.yaml", "--random", "3", "--reduce", "mean"],
        ];
        // It takes its time: a name that clears the screen and one that is wrapped.
        if index == 0 || index == 5 {
            all.push(vec!["diagnose", "robot.yaml", &measured]);
            all.push(vec!["diagnose", "robot.yaml", &measured, "--format", "json"]);
        }
        for arguments in all {
            let output = run(folder.path(), &arguments);
            assert!(code(&output) < 2, "{index}: {arguments:?}: {}", err(&output));
            for text in [out(&output), err(&output)] {
                let bad = commands_in(text);
                assert!(bad.is_empty(), "{index}: {arguments:?}: {bad:?}");
            }
            if arguments.contains(&"json") && ["check", "report"].contains(&arguments[0]) {
                // Spelled out, it is the same name.
                assert!(has_text(&json(&output), name), "{index}: {arguments:?}");
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
    // What a reader of XML, or of a tree, takes time with the square of.
    let many =
        |count: usize, one: &dyn Fn(usize) -> String| (0..count).map(one).collect::<String>();
    let chain = |i: usize| {
        format!(
            "<link name=\"l{i}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" \
             izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint name=\"j{i}\" \
             type=\"continuous\"><parent link=\"l{i}\"/><child link=\"l{}\"/></joint>",
            i + 1
        )
    };
    let robot = |inside: String| format!("<robot name=\"r\">{inside}</robot>");
    let last = "<link name=\"l12000\"/>";
    for (text, fault) in [
        (
            robot(format!("<link {}/>", many(250_000, &|i| format!(" a{i}=\"1\"")))),
            "an element has 200 attributes or more",
        ),
        (
            robot(many(60_000, &|i| format!("<r xmlns:a{i}=\"x{i}\">")) + &"</r>".repeat(60_000)),
            "has more than 100 namespaces",
        ),
        (robot(many(12_000, &chain) + last), "has more than 1000 joints"),
    ] {
        put("arm.urdf", text);
        for arguments in [&map[..], &["init", "arm.urdf", "--output", "first"]] {
            let (time, code, told) = seconds(folder.path(), arguments);
            assert!(code == 2 && time < 20.0, "{time} s: {told}");
            assert!(told.contains(fault), "{fault}: {told}");
        }
    }
    // The longest that is read.
    let whole = many(1000, &chain) + "<link name=\"l1000\"/>";
    put("arm.urdf", robot(whole));
    let (time, _, told) = seconds(folder.path(), &["init", "arm.urdf", "--output", "first"]);
    assert!(time < 20.0, "{time} s: {told}");
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
