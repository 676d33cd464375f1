//! A first robot, what changed, and what CI runs.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::program::{code, err, json, out, repository, run, tested};

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn urdf(name: &str) -> String {
    fs::read_to_string(repository().join(name)).unwrap()
}

#[test]
fn a_first_robot_is_checked_and_uncertain_until_its_springs_are_known() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("arm.urdf"), urdf("tests/data/reference/ur10.urdf")).unwrap();
    let output = run(folder.path(), &["init", "arm.urdf"]);
    assert_eq!(code(&output), 0, "{}", err(&output));
    assert!(
        out(&output).contains("guessed  shoulder_pan_joint, shoulder_lift_joint, elbow_joint: "),
        "{}",
        out(&output)
    );
    assert!(folder.path().join(".github/workflows/detune.yml").exists());
    // What hangs fixed behind the last joint is the frame of the tool, not the last link that moves.
    let robot = fs::read_to_string(folder.path().join("robot.yaml")).unwrap();
    assert!(robot.contains("\ntip: tool0\n"), "{robot}");
    let check = |fail_on: &str| {
        let arguments = ["check", "jobs", "--format", "json", "--fail-on", fail_on];
        run(folder.path(), &arguments)
    };
    let checked = json(&check("uncertain"));
    assert!(["uncertain", "resonance"].contains(&checked["verdict"].as_str().unwrap()));
    // The text names what explains its doubts.
    let text = run(folder.path(), &["check", "jobs"]);
    let explain = "  explain  detune explain assumed_spring payload_unknown\n";
    assert!(out(&text).contains(explain), "{}", out(&text));
    // Also where no line comes near any mode and the payload is known.
    let job = folder.path().join("jobs/first.yaml");
    let text = fs::read_to_string(&job).unwrap();
    let quiet = text
        .replace(
            "tcp:",
            "payload: none\npolicy: {spindle_harmonics: 0, tooth_passing_harmonics: 1}\ntcp:",
        )
        .replace("spindle_rpm: 6000", "spindle_rpm: 24000");
    fs::write(&job, quiet).unwrap();
    let checked = json(&check("uncertain"));
    assert_eq!(checked["verdict"], "uncertain", "{checked}");
    let robot = folder.path().join("robot.yaml");
    let own = fs::read_to_string(&robot).unwrap().replace("      assumed: true\n", "");
    fs::write(&robot, own).unwrap();
    let checked = json(&check("never"));
    assert!(!checked.to_string().contains("assumed_spring"), "{checked}");
    // Nothing is written over.
    let before = names(folder.path());
    let output = run(folder.path(), &["init", "arm.urdf"]);
    assert_eq!(code(&output), 2);
    assert!(err(&output).contains("robot.yaml: is there already"), "{}", err(&output));
    assert_eq!(names(folder.path()), before);
}

/// The URDF is named as from the folder of robot.yaml, wherever the files go.
#[test]
fn the_files_of_a_first_robot_name_the_urdf_from_their_folder() {
    let bench = tempfile::tempdir().unwrap();
    for folder in ["models", "there", "other"] {
        fs::create_dir_all(bench.path().join(folder)).unwrap();
    }
    fs::write(bench.path().join("models/arm.urdf"), urdf("tests/data/reference/ur10.urdf"))
        .unwrap();
    let whole = bench.path().join("whole").display().to_string();
    for (from, file, output, named) in [
        (".", "models/arm.urdf", "cells/3", "../../models/arm.urdf"),
        ("models", "arm.urdf", "../there", "../models/arm.urdf"),
        ("other", "../models/arm.urdf", ".", "../models/arm.urdf"),
        (".", "models/arm.urdf", &whole, "../models/arm.urdf"),
        (".", "models/arm.urdf", "models/new/../a", "../arm.urdf"),
    ] {
        let folder = bench.path().join(from);
        let made = run(&folder, &["init", file, "--output", output]);
        assert_eq!(code(&made), 0, "{output}: {}", err(&made));
        let robot = fs::read_to_string(folder.join(output).join("robot.yaml")).unwrap();
        assert!(robot.contains(&format!("\nurdf: {named}\n")), "{output}: {robot}");
    }
}

/// GitHub reads workflows at the top of a repository alone, and runs them there.
#[test]
fn the_ci_of_a_first_robot_works_from_the_top_of_its_repository() {
    let bench = tempfile::tempdir().unwrap();
    fs::create_dir_all(bench.path().join(".git")).unwrap();
    let cell = "cells/3 \"a\"";
    fs::create_dir_all(bench.path().join(cell)).unwrap();
    fs::write(bench.path().join(cell).join("arm.urdf"), urdf("tests/data/reference/ur10.urdf"))
        .unwrap();
    let folder = bench.path().join(cell);
    let made = run(&folder, &["init", "arm.urdf"]);
    assert_eq!(code(&made), 0, "{}", err(&made));
    assert!(!folder.join(".github").exists());
    let workflow = fs::read_to_string(bench.path().join(".github/workflows/detune.yml")).unwrap();
    assert!(workflow.contains("  JOBS: \"cells/3 \\\"a\\\"/jobs\"\n"), "{workflow}");
    assert!(workflow.contains("run: detune check --format github -- \"$JOBS\"\n"), "{workflow}");
    let jobs = format!("{cell}/jobs");
    let checked = run(bench.path(), &["check", "--format", "github", "--", &jobs]);
    assert_eq!(code(&checked), 0, "{}", err(&checked));
    // A second robot finds the workflow there.
    let again = ["init", "arm.urdf", "--output", "b"];
    let made = run(&folder, &again);
    assert_eq!(code(&made), 2);
    let told = "give --ci none, and let it check 'cells/3 \"a\"/b/jobs', too";
    assert!(err(&made).contains(told), "{}", err(&made));
    assert!(!folder.join("b").exists());
    let made = run(&folder, &[&again[..], &["--ci", "gitlab"]].concat());
    assert_eq!(code(&made), 0, "{}", err(&made));
    let ci = fs::read_to_string(folder.join("b/detune.gitlab-ci.yml")).unwrap();
    assert!(ci.contains("    JOBS: \"cells/3 \\\"a\\\"/b/jobs\"\n"), "{ci}");
}

#[test]
fn a_mass_is_never_guessed() {
    let folder = tempfile::tempdir().unwrap();
    let text = urdf("robots/irb1600/irb1600.urdf");
    let mut bare = String::new();
    let mut rest = text.as_str();
    while let Some(start) = rest.find("<inertial>") {
        bare += &rest[..start];
        rest = &rest[start + rest[start..].find("</inertial>").unwrap() + "</inertial>".len()..];
    }
    bare += rest;
    fs::write(folder.path().join("arm.urdf"), bare).unwrap();
    let output = run(folder.path(), &["init", "arm.urdf"]);
    assert_eq!(code(&output), 2);
    assert!(err(&output).contains("give that of the whole arm"), "{}", err(&output));
    assert_eq!(names(folder.path()), ["arm.urdf"]);
    for wrong in ["0", "-3", "NaN"] {
        let output = run(folder.path(), &["init", "arm.urdf", &format!("--total-mass-kg={wrong}")]);
        assert_eq!(code(&output), 2, "{wrong}");
        assert_eq!(names(folder.path()), ["arm.urdf"]);
    }
    let arguments =
        ["init", "arm.urdf", "--total-mass-kg", "250", "--output", "cell 3", "--ci", "gitlab"];
    let output = run(folder.path(), &arguments);
    // Links without any shape cannot share a mass: then nothing stays.
    if code(&output) == 2 {
        assert_eq!(names(folder.path()), ["arm.urdf"], "{}", err(&output));
    } else {
        assert_eq!(code(&output), 0, "{}", err(&output));
        let of_cell = names(&folder.path().join("cell 3"));
        assert_eq!(of_cell, ["detune.gitlab-ci.yml", "jobs", "robot.yaml"]);
        // The sum of the angles that the paper's arm has: β1 = π/2 − q2, β2 = −q3 − π/2.
        let robot = fs::read_to_string(folder.path().join("cell 3/robot.yaml")).unwrap();
        assert!(robot.contains("joint_2: -1.0}, offset_rad: 1.57079632"), "{robot}");
        assert!(robot.contains("joint_3: -1.0}, offset_rad: -1.57079632"), "{robot}");
    }
    // One that has masses takes no other.
    fs::write(folder.path().join("b.urdf"), urdf("tests/data/reference/ur10.urdf")).unwrap();
    let output = run(folder.path(), &["init", "b.urdf", "--total-mass-kg", "30", "--output", "b"]);
    assert_eq!(code(&output), 2);
    assert!(err(&output).contains("the URDF has masses"), "{}", err(&output));
}

#[test]
fn a_robot_is_looked_over() {
    let robot = repository().join("robots/irb1600");
    let output = run(repository(), &["doctor", robot.to_str().unwrap()]);
    assert_eq!(code(&output), 0, "{}", err(&output));
    for told in
        ["natural frequencies, Hz\n    zero ", "softest", "stiffest", "measured arms, Hz", "next"]
    {
        assert!(out(&output).contains(told), "{told}: {}", out(&output));
    }
    // What the map says of the same pose.
    let map = run(
        repository(),
        &[
            "map",
            "robots/irb1600",
            "--joint",
            "joint_1",
            "--from-deg",
            "0",
            "--to-deg",
            "0",
            "--steps",
            "1",
        ],
    );
    let titles = out(&map).lines().next().unwrap().split(',');
    let cells = out(&map).lines().nth(1).unwrap().split(',');
    let (_, f1) = titles.zip(cells).find(|(title, _)| *title == "f1_hz").unwrap();
    let f1: f64 = f1.parse().unwrap();
    assert!(out(&output).contains(&format!("zero      {f1:.1}, ")), "{f1}: {}", out(&output));
    assert_eq!(code(&run(repository(), &["doctor", "robots/gone"])), 2);
}

/// A folder with two jobs of two robots, one of which runs a program.
fn bench() -> tempfile::TempDir {
    let bench = tempfile::tempdir().unwrap();
    let put = |file: &str, text: String| {
        let path = bench.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    for arm in ["a", "b"] {
        put(&format!("arms/{arm}.urdf"), urdf("robots/two-link/two-link.urdf"));
        let robot =
            urdf("robots/two-link/robot.yaml").replace("two-link.urdf", &format!("{arm}.urdf"));
        put(&format!("arms/{arm}.yaml"), robot);
        put(
            &format!("jobs/{arm}.yaml"),
            format!(
                "robot: ../arms/{arm}.yaml\ntool: {{teeth: 2, payload: none}}\n\
                 spindle: {{min_rpm: 500, max_rpm: 6000}}\noperations:\n  - name: rough\n    \
                 spindle_rpm: 780\n    feed_mm_per_min: 400\n    path: {{joints_deg: [[0, 90], [0, 150]]}}\n"
            ),
        );
    }
    bench
}

#[test]
fn the_jobs_of_a_change_are_listed_and_checked() {
    let bench = bench();
    let affected = |files: &[&str]| -> Vec<String> {
        let mut arguments = vec!["affected"];
        arguments.extend(files);
        let output = run(bench.path(), &arguments);
        assert_eq!(code(&output), 0, "{}", err(&output));
        out(&output).lines().map(str::to_owned).collect()
    };
    assert_eq!(affected(&["arms/a.yaml"]), ["./jobs/a.yaml"]);
    assert_eq!(affected(&["arms/../arms/b.urdf"]), ["./jobs/b.yaml"]);
    assert_eq!(affected(&["jobs/b.yaml", "README.md"]), ["./jobs/b.yaml"]);
    assert!(affected(&["README.md", "arms/c.yaml.bak"]).len() <= 2);
    assert_eq!(affected(&["detune.toml"]).len(), 2);
    assert_eq!(affected(&["jobs/detune.toml"]).len(), 2);
    // A name relative to another folder, or in quotes, may be any file.
    for nowhere in ["main/arms/b.urdf", "\"jobs/\\303\\244.mod\""] {
        assert_eq!(affected(&[nowhere]).len(), 2);
        let output = run(bench.path(), &["affected", nowhere]);
        assert!(err(&output).contains("there is no such folder"), "{}", err(&output));
    }
    let checked = run(bench.path(), &["affected", "--check", "arms/a.yaml"]);
    assert_eq!(code(&checked), 1);
    assert!(out(&checked).contains("RESONANCE  ./jobs/a.yaml"), "{}", out(&checked));
    // With the options of check.
    for (options, ends) in [
        (&["--fail-on", "never"][..], 0),
        (&["--policy", "separation_percent=0.01", "--fail-on", "probability=1"], 0),
        (&["--summary", "--quiet"], 1),
        (&["--format", "sarif", "--output", "detune.sarif"], 1),
    ] {
        let checked =
            run(bench.path(), &[&["affected", "--check"], options, &["arms/a.yaml"]].concat());
        let alone = run(bench.path(), &[&["check", "./jobs/a.yaml"], options].concat());
        assert_eq!(code(&checked), ends, "{options:?}: {}", err(&checked));
        assert_eq!((code(&alone), out(&alone)), (ends, out(&checked)), "{options:?}");
        assert_eq!(err(&alone), err(&checked));
        if !options.contains(&"--quiet") {
            let listed = run(bench.path(), &[&["affected"], options, &["arms/a.yaml"]].concat());
            assert_eq!(code(&listed), 2, "{options:?}");
            assert!(err(&listed).contains("--check"), "{}", err(&listed));
        }
    }
    assert!(bench.path().join("detune.sarif").exists());
    fs::write(bench.path().join("README.md"), "").unwrap();
    let checked = run(bench.path(), &["affected", "--check", "README.md"]);
    assert_eq!((code(&checked), out(&checked)), (0, ""));
    let null = run(bench.path(), &["affected", "-0", "arms/a.yaml", "arms/b.yaml"]);
    assert_eq!(out(&null), "./jobs/a.yaml\0./jobs/b.yaml\0");
    // A robot that is gone is a job that cannot be read.
    fs::remove_file(bench.path().join("arms/a.yaml")).unwrap();
    assert_eq!(affected(&["arms/a.yaml"])[0], "./jobs/a.yaml");
}

/// Runs a step of the action as a runner does: its script by bash, its inputs by the environment.
#[cfg(unix)]
fn act(folder: &Path, step: &serde_json::Value, inputs: &[(&str, &str)]) -> Output {
    let files = tempfile::tempdir().unwrap();
    let program = tested();
    let program = program.parent().unwrap();
    let mut command = Command::new("bash");
    command.args(["--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"].as_str().unwrap()]);
    command.current_dir(folder).env("GITHUB_ACTION_PATH", repository());
    command.env("PATH", format!("{}:{}", program.display(), std::env::var("PATH").unwrap()));
    for name in ["GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY"] {
        command.env(name, folder.join(name));
    }
    for (variable, value) in step["env"].as_object().into_iter().flatten() {
        let input =
            value.as_str().unwrap().trim_start_matches("${{ inputs.").trim_end_matches(" }}");
        let given = inputs.iter().find(|(name, _)| *name == input);
        command.env(variable, given.unwrap_or_else(|| panic!("no input {input}")).1);
    }
    drop(files);
    command.output().unwrap()
}

#[cfg(unix)]
#[test]
fn the_action_checks_whatever_files_are_called() {
    let text = fs::read_to_string(repository().join("action.yml")).unwrap();
    let action: serde_json::Value = serde_yaml::from_str(&text).unwrap();
    let steps = action["runs"]["steps"].as_array().unwrap();
    // No expression stands in a script, and what others wrote is pinned.
    for step in steps {
        assert!(!step["run"].as_str().unwrap_or_default().contains("${{"), "{step}");
        if let Some(uses) = step["uses"].as_str() {
            let (_, pin) = uses.split_once('@').unwrap();
            assert!(pin.len() == 40 && pin.bytes().all(|b| b.is_ascii_hexdigit()), "{uses}");
        }
    }
    let bench = bench();
    let odd = "jobs/it's $(touch pwned) \"`x`\" ;.yaml";
    fs::rename(bench.path().join("jobs/a.yaml"), bench.path().join(odd)).unwrap();
    let mut inputs = vec![
        ("jobs", "jobs\n"),
        ("fail-on", "resonance"),
        ("policy", "separation_percent=9\nspindle_harmonics=0"),
        ("deny-warnings", "false"),
        ("working-directory", "."),
        ("sarif", "out $(touch pwned).sarif"),
    ];
    let output = act(bench.path(), &steps[0], &inputs);
    assert_eq!(code(&output), 0, "{}", err(&output));
    let output = act(bench.path(), &steps[1], &inputs);
    assert_eq!(code(&output), 1, "{}", err(&output));
    assert!(out(&output).contains("::error file=jobs/it's $(touch pwned)"), "{}", out(&output));
    let read = |file: &str| fs::read_to_string(bench.path().join(file)).unwrap();
    let sarif: serde_json::Value = serde_json::from_str(&read("out $(touch pwned).sarif")).unwrap();
    assert_eq!(sarif["version"], "2.1.0");
    assert!(!sarif["runs"][0]["results"].as_array().unwrap().is_empty());
    assert_eq!(read("GITHUB_OUTPUT"), "sarif=out $(touch pwned).sarif\n");
    let summary = read("GITHUB_STEP_SUMMARY");
    assert!(
        summary.contains("2 jobs: 2 resonance") && summary.contains("separation_percent=9"),
        "{summary}"
    );
    inputs[0].1 = odd;
    inputs[1].1 = "never";
    assert_eq!(code(&act(bench.path(), &steps[1], &inputs)), 0);
    inputs[1].1 = "$(touch pwned)";
    assert_eq!(code(&act(bench.path(), &steps[1], &inputs)), 2);
    inputs[1].1 = "resonance";
    inputs[0].1 = "jobs/gone.yaml";
    assert_eq!(code(&act(bench.path(), &steps[1], &inputs)), 2);
    inputs[5].1 = "a\nsarif=/etc/passwd";
    assert_eq!(code(&act(bench.path(), &steps[1], &inputs)), 2);
    // What stands in another folder is told by its place in the repository.
    (inputs[0].1, inputs[4].1, inputs[5].1) = ("b.yaml", "jobs", "b.sarif");
    let output = act(bench.path(), &steps[1], &inputs);
    assert_eq!(code(&output), 1, "{}", err(&output));
    assert!(out(&output).contains("::error file=jobs/b.yaml"), "{}", out(&output));
    let sarif: serde_json::Value = serde_json::from_str(&read("jobs/b.sarif")).unwrap();
    let place = &sarif["runs"][0]["results"][0]["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "jobs/b.yaml");
    assert!(read("GITHUB_OUTPUT").ends_with("sarif=jobs/b.sarif\n"));
    inputs[3].1 = "True";
    assert_eq!(code(&act(bench.path(), &steps[1], &inputs)), 2);
    assert!(!bench.path().join("pwned").exists());
}

/// The hook names a command that this program has, and its pattern meets the files of jobs.
#[test]
fn the_hook_is_a_command_of_the_program() {
    let text = fs::read_to_string(repository().join(".pre-commit-hooks.yaml")).unwrap();
    let hooks: serde_json::Value = serde_yaml::from_str(&text).unwrap();
    // The files that jobs read, by their extensions.
    let pattern = hooks[0]["files"].as_str().unwrap();
    let known = pattern.split_once("(\\.(").unwrap().1.split(')').next().unwrap();
    let known: Vec<&str> = known.split('|').collect();
    for extension in [
        "yaml",
        "yml",
        "urdf",
        "mod",
        "modx",
        "prg",
        "sys",
        "sysx",
        "pgf",
        "apt",
        "aptsource",
        "cl",
        "cls",
        "ncl",
        "nc",
        "ngc",
        "gcode",
        "tap",
        "cnc",
        "eia",
        "ncc",
        "mpf",
        "spf",
        "src",
        "dat",
        "ls",
        "h",
        "hnc",
    ] {
        let fits = |own: &&str| match own.split_once('?') {
            Some((own, _)) => own == extension || own.get(..own.len() - 1) == Some(extension),
            None => *own == extension,
        };
        let is_yaml = extension.starts_with('y') && known.contains(&"ya?ml");
        assert!(is_yaml || known.iter().any(fits), "{extension}");
    }
    let entry = hooks[0]["entry"].as_str().unwrap().split_whitespace().skip(1);
    let bench = bench();
    let mut arguments: Vec<&str> = entry.collect();
    arguments.push("arms/b.urdf");
    let output = run(bench.path(), &arguments);
    assert_eq!(code(&output), 1, "{}", err(&output));
    assert!(out(&output).contains("RESONANCE  ./jobs/b.yaml"), "{}", out(&output));
}

#[test]
fn the_program_says_how_it_was_built_and_has_manual_pages() {
    for arguments in [["--version", "--verbose"], ["-v", "-V"]] {
        let output = run(repository(), &arguments);
        assert_eq!(code(&output), 0, "{}", err(&output));
        let version = format!("detune {}\ntarget: ", env!("CARGO_PKG_VERSION"));
        assert!(out(&output).starts_with(&version), "{}", out(&output));
        assert!(out(&output).contains("\ninstructions: "), "{}", out(&output));
    }
    assert_eq!(code(&run(repository(), &["--verbose"])), 2);
    let page = run(repository(), &["man"]);
    assert!(out(&page).contains(".TH detune") && out(&page).contains("check"), "{}", out(&page));
    let page = run(repository(), &["man", "check"]);
    assert!(out(&page).contains("fail\\-on"), "{}", out(&page));
    assert_eq!(code(&run(repository(), &["man", "chekc"])), 2);
}

/// A flange without an inertial: its joint cannot be elastic, and the file says what to do.
#[test]
fn a_joint_without_a_mass_behind_it_is_rigid_in_a_first_robot() {
    let folder = tempfile::tempdir().unwrap();
    let whole = urdf("tests/data/reference/ur10.urdf");
    let link = whole.find("<link name=\"wrist_3_link\"").unwrap();
    let from = link + whole[link..].find("<inertial").unwrap();
    let to = from + whole[from..].find("</inertial>").unwrap() + "</inertial>".len();
    fs::write(folder.path().join("arm.urdf"), format!("{}{}", &whole[..from], &whole[to..]))
        .unwrap();
    let output = run(folder.path(), &["init", "arm.urdf"]);
    assert_eq!(code(&output), 0, "{}", err(&output));
    let told = "rigid    wrist_3_joint: nothing behind it has a mass";
    assert!(out(&output).contains(told), "{}", out(&output));
    let robot = fs::read_to_string(folder.path().join("robot.yaml")).unwrap();
    assert!(robot.contains("    # wrist_3_joint: nothing behind it has a mass"), "{robot}");
    assert!(!robot.contains("    wrist_3_joint:"), "{robot}");
    let checked = run(folder.path(), &["check", "jobs", "--fail-on", "never"]);
    assert_eq!(code(&checked), 0, "{}", err(&checked));
}
