//! What the README says the program prints is what it prints.

use std::fs;
use std::path::Path;
use std::process::Command;

/// Numbers are printed with all digits; the last of them depend on the machine's mathematical library.
const RELATIVE: f64 = 1e-9;

/// Figures that are rounding noise themselves, such as an energy drift.
const NOISE: f64 = 1e-7;

fn readme() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap()
}

/// The fenced blocks of one language.
fn blocks(readme: &str, language: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut open: Option<(bool, String)> = None;
    for line in readme.lines() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(name)) => open = Some((name == language, String::new())),
            (Some((wanted, text)), Some(_)) => {
                if *wanted {
                    blocks.push(text.trim_end().to_owned());
                }
                open = None;
            }
            (Some((_, text)), None) => {
                text.push_str(line);
                text.push('\n');
            }
            (None, None) => {}
        }
    }
    blocks
}

/// Standard output and standard error of the command, run where the README's reader stands.
fn run(arguments: &str) -> (String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_detune"))
        .args(arguments.split_whitespace())
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap().trim_end().to_owned();
    (text(output.stdout), text(output.stderr))
}

fn same(a: &str, b: &str) -> bool {
    let split =
        |text: &str| -> Vec<String> { text.split([' ', ',', '\n']).map(str::to_owned).collect() };
    let (a, b) = (split(a), split(b));
    a.len() == b.len()
        && a.iter().zip(&b).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(x), Ok(y)) => {
                (x - y).abs() <= RELATIVE * x.abs().max(y.abs()) || x.abs().max(y.abs()) < NOISE
            }
            _ => a == b,
        })
}

#[test]
fn the_readme_shows_what_is_printed() {
    let readme = readme();
    let mut shown = blocks(&readme, "text").into_iter();
    let mut must_show = |expected: &str, what: &str| {
        let block = shown.next().unwrap_or_default();
        assert!(
            same(&block, expected),
            "{what}: the README shows\n{block}\nprinted is\n{expected}"
        );
    };
    let first = blocks(&readme, "sh").remove(0);
    let check = first.strip_prefix("cargo run --release --quiet -- ").expect("the first command");
    must_show(&run(check).0, &first);
    must_show(&run("check jobs/contour.yaml --format github").0, "annotations");
    must_show(&run("check tests/data/readme/typo.yaml").1, "mistakes");
    let commands = blocks(&readme, "console");
    for command in commands.iter().filter(|c| !c.contains('#')) {
        let arguments = command.strip_prefix("$ detune ").expect("a command of detune");
        must_show(&run(arguments).0, command);
    }
    assert_eq!(shown.next(), None, "a block of output belongs to no command");
}

/// Every command of the README's lists runs and ends with the exit code that it must; the files that it
/// writes go to a folder of its own.
fn list_runs(list: &str, codes: &[i32], files: usize) {
    let folder = tempfile::tempdir().unwrap();
    let to_folder = |option: &str| format!("{option} {}/", folder.path().display());
    for (line, code) in list.lines().zip(codes) {
        let command = line.split('#').next().unwrap();
        let command = command.strip_prefix("$ detune ").expect("a command of detune");
        let jobs = "jobs/contour.yaml jobs/pocket.yaml jobs/rail.yaml";
        let command = command
            .replace("jobs/*.yaml", jobs)
            .replace("--output ", &to_folder("--output"))
            .replace("--write ", &to_folder("--write"));
        let output = Command::new(env!("CARGO_BIN_EXE_detune"))
            .args(command.split_whitespace())
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{command}: {told}");
    }
    assert_eq!(list.lines().count(), codes.len());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), files);
}

#[test]
fn the_readmes_lists_of_commands_run() {
    let lists = blocks(&readme(), "console");
    list_runs(&lists[0], &[1; 6], 2);
    list_runs(&lists[1], &[0, 0, 0, 0, 1], 2);
    let diagnoses =
        lists.iter().find(|list| list.contains("diagnose") && list.contains('#')).unwrap();
    list_runs(diagnoses, &[0; 3], 2);
}
