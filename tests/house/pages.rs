//! What the README and the pages of the guide say the program prints is what it prints.
//!
//! A block `console` holds commands of detune, `$ detune …` each, perhaps with a remark behind ` #`. A block
//! `text` right behind it is what the last of them prints: standard output, or standard error where there
//! is no output; a line `...` stands for any number of lines. In the README the first command is one of
//! cargo. Every page runs in a folder of its own, so that commands may read what earlier ones wrote.
//! `DETUNE_WRITE_PAGES=1 cargo test --test house pages` writes what is printed into the pages.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};
use std::thread;

use detune::diagnosis::cause_text;
use detune::job::Acceptable;
use detune::model::Cause;
use detune::notes::Code;
use detune::report::schema;
use serde_json::Value;

use crate::source::root;

/// Numbers are printed with all digits; the last of them depend on the machine's mathematical library.
const RELATIVE: f64 = 1e-9;

/// Figures that are rounding noise themselves, such as an energy drift.
const NOISE: f64 = 1e-7;

/// A fenced block of a page.
struct Block {
    language: String,
    line: usize,
    text: String,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut is_open = false;
    for (i, line) in page.lines().enumerate() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            is_open = !is_open;
            if is_open {
                blocks.push(Block { language: language.into(), line: i + 1, text: String::new() });
            }
        } else if is_open {
            let text = &mut blocks.last_mut().unwrap().text;
            *text += line;
            *text += "\n";
        }
    }
    blocks
}

/// The commands of a block, as `detune …`.
fn commands(block: &Block, page: &str) -> Vec<String> {
    let of_cargo = "cargo run --release --quiet -- ";
    match block.language.as_str() {
        "console" => block
            .text
            .lines()
            .map(|line| {
                let command =
                    line.strip_prefix("$ ").filter(|command| command.starts_with("detune "));
                let command = command.unwrap_or_else(|| panic!("{page}:{}: '{line}'", block.line));
                command.split(" #").next().unwrap().trim_end().to_owned()
            })
            .collect(),
        "sh" => {
            let commands = block.text.lines().filter_map(|line| line.strip_prefix(of_cargo));
            commands.map(|arguments| format!("detune {arguments}")).collect()
        }
        _ => vec![],
    }
}

#[derive(Debug, Clone)]
struct Answer {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Answer {
    fn shown(&self) -> &str {
        if self.out.is_empty() { &self.err } else { &self.out }
    }
}

/// Runs a command as a shell does.
fn run(folder: &Path, command: &str) -> Answer {
    let program = Path::new(env!("CARGO_BIN_EXE_detune")).parent().unwrap();
    let rest = std::env::var("PATH").unwrap_or_default();
    let output = Command::new("sh")
        .args(["-c", command])
        .env("PATH", format!("{}:{rest}", program.display()))
        .current_dir(folder)
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap().trim_end().to_owned();
    Answer { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

/// Files that a command is asked to write.
fn written(command: &str) -> Vec<&str> {
    let words: Vec<&str> = command.split_whitespace().collect();
    let options = ["--output", "--write", "--write-program", ">"];
    words.windows(2).filter(|pair| options.contains(&pair[0])).map(|pair| pair[1]).collect()
}

/// A diagnosis of which a page shows nothing is one of the table's first poses: that it runs and writes its
/// file is seen as well, in a tenth of the time.
fn of_few_poses(folder: &Path, command: &str) -> String {
    const POSES: usize = 4;
    let words: Vec<&str> = command.split_whitespace().collect();
    let ["detune", "diagnose", _, table, ..] = words[..] else { return command.to_owned() };
    // The program itself tells what is wrong with a table that cannot be read.
    let Ok(whole) = fs::read_to_string(folder.join(table)) else { return command.to_owned() };
    let rows = whole.lines().filter(|line| !line.starts_with('#')).take(1 + POSES);
    let few = format!("first-poses-of-{}", table.replace('/', "-"));
    fs::write(folder.join(&few), rows.map(|row| format!("{row}\n")).collect::<String>()).unwrap();
    command.replacen(table, &few, 1)
}

/// Answers of commands that read the repository alone: pages share commands.
fn answer(folder: &Path, command: &str, is_untouched: bool) -> Answer {
    type Cell = &'static OnceLock<Answer>;
    static ANSWERS: Mutex<BTreeMap<String, Cell>> = Mutex::new(BTreeMap::new());
    if !is_untouched || !written(command).is_empty() {
        return run(folder, command);
    }
    let cell: Cell = {
        let mut answers = ANSWERS.lock().unwrap();
        answers.entry(command.to_owned()).or_insert_with(|| Box::leak(Box::default()))
    };
    cell.get_or_init(|| run(folder, command)).clone()
}

fn same_words(a: &str, b: &str) -> bool {
    let split = |text: &str| -> Vec<String> { text.split([' ', ',']).map(str::to_owned).collect() };
    let (a, b) = (split(a), split(b));
    a.len() == b.len()
        && a.iter().zip(&b).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(x), Ok(y)) => {
                (x - y).abs() <= RELATIVE * x.abs().max(y.abs()) || x.abs().max(y.abs()) < NOISE
            }
            _ => a == b,
        })
}

/// Whether a page shows a text, but for what it leaves out by lines of `...`.
fn shows(shown: &str, printed: &str) -> bool {
    fn lines(shown: &[&str], printed: &[&str]) -> bool {
        match (shown, printed) {
            ([], []) => true,
            ([line, rest @ ..], _) if line.trim() == "..." => {
                (0..=printed.len()).any(|skip| lines(rest, &printed[skip..]))
            }
            ([line, rest @ ..], [first, printed @ ..]) => {
                same_words(line, first) && lines(rest, printed)
            }
            _ => false,
        }
    }
    lines(&shown.lines().collect::<Vec<_>>(), &printed.lines().collect::<Vec<_>>())
}

/// What puts right what is shown.
const WRITES: &str = "`DETUNE_WRITE_PAGES=1 cargo test --test house pages` writes";

/// The lines that only one of two texts has, between what they have in common at both ends.
fn differing(shown: &str, printed: &str) -> String {
    const MOST: usize = 20;
    let texts = [shown, printed].map(|text| text.lines().collect::<Vec<_>>());
    let [shown, printed] = &texts;
    let pairs = shown.iter().zip(printed);
    let head = pairs.take_while(|(a, b)| same_words(a, b)).count();
    let pairs = shown[head..].iter().rev().zip(printed[head..].iter().rev());
    let tail = pairs.take_while(|(a, b)| same_words(a, b)).count();
    let part = |sign: &str, text: &[&str]| {
        let own = &text[head..text.len() - tail];
        let lines = own.iter().take(MOST).map(|line| format!("{sign} {line}\n"));
        let more = own.len().saturating_sub(MOST);
        let more = (more > 0).then(|| format!("{sign} … and {more} lines more\n"));
        lines.chain(more).collect::<String>()
    };
    part("-", shown) + &part("+", printed)
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// The README and the pages of the guide, by path.
fn pages() -> Vec<(String, String)> {
    let guide = fs::read_dir(root().join("src/guide"));
    let names = guide.into_iter().flatten().map(|entry| entry.unwrap().file_name());
    let names = names.map(|name| format!("src/guide/{}", name.to_string_lossy()));
    let pages = names.filter(|name| name.ends_with(".md")).chain(["README.md".to_owned()]);
    pages.map(|name| (name.clone(), fs::read_to_string(root().join(name)).unwrap())).collect()
}

/// What running a page found.
#[derive(Default)]
struct Checked {
    wrong: Vec<String>,
    /// Outputs that are not as shown: what is printed, by the line where the block opens.
    stale: BTreeMap<usize, String>,
    /// Number of outputs that are shown.
    shown: usize,
}

/// Runs what a page shows.
fn check(name: &str, page: &str) -> Checked {
    let folder = tempfile::tempdir().unwrap();
    for part in ["robots", "jobs", "tests/data"] {
        copy(&root().join(part), &folder.path().join(part));
    }
    let (mut found, mut is_untouched) = (Checked::default(), true);
    let blocks = blocks(page);
    for (i, block) in blocks.iter().enumerate() {
        let commands = commands(block, name);
        let output = blocks.get(i + 1).filter(|next| next.language == "text");
        for (k, command) in commands.iter().enumerate() {
            let place = format!("{name}:{}: {command}", block.line + k + 1);
            let output = output.filter(|_| k + 1 == commands.len());
            let command = &match output {
                Some(_) => command.clone(),
                None => of_few_poses(folder.path(), command),
            };
            let answer = answer(folder.path(), command, is_untouched);
            let files = written(command);
            is_untouched &= files.is_empty();
            for file in files.iter().filter(|file| !folder.path().join(file).exists()) {
                found.wrong.push(format!("{place}: does not write {file}"));
            }
            let codes: &[i32] = match output {
                Some(_) if answer.out.is_empty() => &[2],
                _ if command.contains(" check ") || command.contains(" advise ") => &[0, 1],
                _ => &[0],
            };
            if !answer.code.is_some_and(|code| codes.contains(&code)) {
                found.wrong.push(format!("{place}: ends with {:?}: {}", answer.code, answer.err));
            }
            if let Some(output) = output {
                found.shown += 1;
                if !shows(output.text.trim_end(), answer.shown()) {
                    found.stale.insert(output.line, answer.shown().to_owned());
                }
            }
        }
        let is_output = i
            .checked_sub(1)
            .is_some_and(|before| !self::commands(&blocks[before], name).is_empty());
        if block.language == "text" && !is_output {
            found.wrong.push(format!("{name}:{}: this output belongs to no command", block.line));
        }
    }
    found
}

/// A page with other text in the blocks that open at these lines.
fn with_outputs(page: &str, outputs: &BTreeMap<usize, String>) -> String {
    let (mut text, mut skips) = (String::new(), false);
    for (i, line) in page.lines().enumerate() {
        skips &= !line.starts_with("```");
        if !skips {
            text += &format!("{line}\n");
        }
        if let Some(output) = outputs.get(&(i + 1)) {
            text += &format!("{output}\n");
            skips = true;
        }
    }
    text
}

#[test]
fn pages_show_what_is_printed() {
    let pages = pages();
    let (next, all) = (AtomicUsize::new(0), Mutex::new((Vec::new(), 0)));
    let is_to_be_written = std::env::var_os("DETUNE_WRITE_PAGES").is_some();
    let workers = thread::available_parallelism().map_or(2, usize::from);
    thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some((name, page)) = pages.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let Checked { mut wrong, stale, shown } = check(name, page);
                    if is_to_be_written {
                        fs::write(root().join(name), with_outputs(page, &stale)).unwrap();
                    } else {
                        let shown = |line: &usize| {
                            let mut blocks = blocks(page).into_iter();
                            blocks.find(|block| block.line == *line).unwrap().text
                        };
                        wrong.extend(stale.iter().map(|(line, printed)| {
                            let lines = differing(shown(line).trim_end(), printed);
                            format!("{name}:{line}: not what is printed; {WRITES} it\n{lines}")
                        }));
                    }
                    let mut all = all.lock().unwrap();
                    all.0.extend(wrong);
                    all.1 += shown;
                }
            });
        }
    });
    let (wrong, shown) = all.into_inner().unwrap();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    assert!(shown >= 8, "pages show only {shown} outputs: this reads the wrong thing");
}

/// The picture of the README is what the command above it draws.
#[test]
fn the_picture_is_what_is_drawn() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let (before, after) = readme.split_once("](src/guide/speeds.svg)").unwrap();
    let command = "detune advise jobs/contour.yaml --format svg";
    assert!(before.contains(command) && after.contains("```sh"));
    let drawn = run(root(), command);
    assert!(matches!(drawn.code, Some(0 | 1)), "{}", drawn.err);
    let file = root().join("src/guide/speeds.svg");
    if std::env::var_os("DETUNE_WRITE_PAGES").is_some() {
        fs::write(&file, format!("{}\n", drawn.out)).unwrap();
    }
    let shown = fs::read_to_string(&file).unwrap();
    assert!(shows(shown.trim_end(), &drawn.out), "{} is not what is drawn", file.display());
}

/// Every code of a note is a row of the guide's tables, and every row is a code.
#[test]
fn the_guide_lists_every_code() {
    let page = fs::read_to_string(root().join("src/guide/messages.md")).unwrap();
    let rows = page.lines().filter_map(|line| line.strip_prefix("| `"));
    let listed: Vec<(&str, &str)> = rows
        .map(|row| {
            let (code, rest) = row.split_once("` |").unwrap();
            (code, rest.split('|').next().unwrap().trim())
        })
        .collect();
    let codes: BTreeSet<_> = Code::ALL.iter().map(|code| (code.name(), code.meaning())).collect();
    let verdicts = verdicts();
    let is_verdict = |row: &(&str, &str)| verdicts.contains(row.0);
    let set: BTreeSet<_> = listed.iter().copied().filter(|row| !is_verdict(row)).collect();
    let difference: Vec<_> = set.symmetric_difference(&codes).collect();
    assert!(difference.is_empty(), "on the page or in the code alone: {difference:#?}");
    assert_eq!(listed.len(), set.len() + verdicts.len(), "a row is listed twice or is missing");
}

/// Every verdict and status of an output, as its schema has them, what a job may accept of them, and the other names
/// that SARIF and GitLab's report have for findings.
fn verdicts() -> BTreeSet<String> {
    let mut names =
        BTreeSet::from([Acceptable::CROSSING, "doubt", "limit", "policy"].map(str::to_owned));
    for (schema, key) in [
        (schema::check(), "verdict"),
        (schema::diagnosis(), "verdict"),
        (schema::advice(), "status"),
    ] {
        let before = names.len();
        words(&schema, &schema, key, &mut names);
        assert!(names.len() > before, "no {key} in a schema");
    }
    names
}

/// The words that a schema lists for a key, wherever it stands.
fn words(root: &Value, schema: &Value, key: &str, names: &mut BTreeSet<String>) {
    let own = &schema["properties"][key];
    let target = own["$ref"].as_str().and_then(|to| root.pointer(to.trim_start_matches('#')));
    let listed = target.unwrap_or(own)["enum"].as_array().into_iter().flatten();
    names.extend(listed.filter_map(Value::as_str).map(str::to_owned));
    let inner: Vec<&Value> = match schema {
        Value::Object(object) => object.values().collect(),
        Value::Array(items) => items.iter().collect(),
        _ => Vec::new(),
    };
    inner.into_iter().for_each(|inner| words(root, inner, key, names));
}

/// Every cause is a row of the guide's table, with what it is confounded with, and the README has
/// their number.
#[test]
fn the_guide_lists_every_cause() {
    let page = fs::read_to_string(root().join("src/guide/diagnosis.md")).unwrap();
    let (_, causes) = page.split_once("\n## Causes\n").unwrap();
    let rows =
        causes.lines().skip_while(|line| line.is_empty()).take_while(|line| !line.is_empty());
    let cells = |row: &str| -> Vec<String> {
        row.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    let listed: Vec<[String; 2]> = rows
        .skip(2)
        .map(|row| <[String; 4]>::try_from(cells(row)).unwrap())
        .map(|[cause, _, _, confounded]| [cause, confounded])
        .collect();
    let known = |cause: Cause| [format!("`{cause}`"), cause_text(cause).confounded_with.to_owned()];
    let known = Cause::ALL.map(known);
    for (row, cause) in listed.iter().zip(&known) {
        assert_eq!(row, cause, "a row of diagnosis.md and a cause, in the order of Cause::ALL");
    }
    assert_eq!(listed.len(), known.len(), "rows of diagnosis.md, and causes");
    let numbers = ["sixteen", "seventeen", "eighteen", "nineteen", "twenty"];
    let number = numbers.get(known.len() - 16).unwrap();
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.contains(&format!("which of {number} causes")), "README.md: {number} causes");
}

#[test]
fn outputs_are_compared_line_by_line() {
    assert_eq!(differing("a\nb\nc\nd", "a\nx\nc\nd"), "- b\n+ x\n");
    assert_eq!(differing("a\nd", "a\nb\nd 1.0"), "- d\n+ b\n+ d 1.0\n");
    assert!(shows("a 1.0\nb", "a 1.00000000001\nb"));
    assert!(!shows("a 1.0", "a 1.1"));
    assert!(!shows("a", "a\nb"));
    assert!(shows("a\n...\nd", "a\nb\nc\nd"));
    assert!(!shows("a\n...\nd", "a\nb"));
    let outputs = BTreeMap::from([(2, "new\nlines".to_owned())]);
    let page = "a\n```text\nold\n```\nb\n";
    assert_eq!(with_outputs(page, &outputs), "a\n```text\nnew\nlines\n```\nb\n");
}

/// Jobs and robots that pages show, with paths of this repository in place of the reader's.
#[test]
fn files_shown_are_valid() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("shown.yaml");
    let paths = [
        ("../robots/irb1600/robot.yaml", "robots/irb1600/robot.yaml"),
        ("../reference/ur10.urdf", "tests/data/reference/ur10.urdf"),
        ("robot: my-arm.yaml", "tests/data/readme/my-arm.yaml"),
        ("urdf: my-arm.urdf", "robots/irb1600/irb1600.urdf"),
    ];
    let mut seen = 0;
    for (name, page) in pages() {
        for block in blocks(&page) {
            let command = match block.text.lines().next().unwrap_or_default() {
                head if head.ends_with("job.schema.json") => "detune check --fail-on never",
                head if head.ends_with("robot.schema.json") => "detune map --random 1",
                _ => continue,
            };
            let mut text = block.text.clone();
            for (shown, here) in paths {
                let key =
                    shown.split_once(": ").map_or(String::new(), |(key, _)| key.to_owned() + ": ");
                text = text.replace(shown, &format!("{key}{}", root().join(here).display()));
            }
            fs::write(&file, text).unwrap();
            let answer = run(folder.path(), &format!("{command} shown.yaml"));
            assert_eq!(answer.code, Some(0), "{name}:{}: {}", block.line, answer.err);
            seen += 1;
        }
    }
    assert!(seen >= 4, "pages show only {seen} files");
}

#[test]
fn links_lead_somewhere() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    for (name, page) in pages() {
        assert!(
            name == "README.md" || readme.contains(&format!("({name})")),
            "README.md has no link to {name}"
        );
        let here = root().join(&name);
        let inline = page.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        let lines = page.lines().filter(|line| line.starts_with('['));
        let defined = lines.filter_map(|line| line.split_once("]: ").map(|(_, target)| target));
        for target in inline.chain(defined).filter(|target| !target.contains("://")) {
            let file = here.parent().unwrap().join(target);
            assert!(file.exists(), "{name}: {target} does not exist");
        }
    }
}
