//! Holds the code map of `src/lib.rs` against the code, and what a module must never, where a text
//! can show it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;

use crate::code_map::rooms;
use crate::source::{File, Kind, Library, root, tokens, without_tests};

/// Imports that the code map does not allow and that have not been removed yet.
const NOT_YET: &[(&str, &str)] = &[];

/// Functions of other rooms that reports still call.
const REPORTS_CALL: &[&str] = &[];

/// Methods of other rooms that reports still call and that compute.
const REPORTS_COMPUTE: &[&str] = &["excitation::frequency_hz"];

/// Crates that these rooms alone may name.
const NAMED_ONLY_IN: &[(&str, &[&str])] = &[
    ("urdf_rs", &["input"]),
    ("serde_yaml", &["formats"]),
    ("roxmltree", &["formats", "input"]),
    ("saphyr_parser", &["formats"]),
    ("toml", &["formats"]),
    ("flate2", &["formats"]),
    ("hound", &["formats"]),
    ("png", &["formats"]),
    ("zune_jpeg", &["formats"]),
    ("clarabel", &["advice"]),
    ("clap", &["cli"]),
    ("indicatif", &["cli"]),
    ("anstream", &["cli"]),
    ("quick_junit", &["report"]),
];

/// The rooms that read or write files.
const FILES_IN: &[&str] = &["cli", "formats", "input"];

/// The room that prints and asks the environment.
const PRINTS_IN: &[&str] = &["cli"];

/// Found and expected exceptions are the same: one that is no longer needed is to be deleted.
fn same<T: Ord + Debug>(found: &BTreeSet<T>, expected: BTreeSet<T>, what: &str) {
    let new: Vec<_> = found.difference(&expected).collect();
    let gone: Vec<_> = expected.difference(found).collect();
    assert!(new.is_empty(), "{what}: {new:#?}");
    assert!(gone.is_empty(), "{what}: delete these exceptions, nothing needs them: {gone:#?}");
}

#[test]
fn rooms_import_what_the_code_map_says() {
    let (map, library) = (rooms(), Library::get());
    let (mut found, mut used) = (BTreeSet::new(), BTreeSet::new());
    for file in library.files().filter(|file| file.path != "lib.rs") {
        let here = map.iter().find(|room| room.name == file.room());
        let here = here.unwrap_or_else(|| panic!("src/{}: not in the code map", file.path));
        for import in library.rooms(file) {
            let there = map.iter().find(|room| room.name == import).expect("a room of the map");
            if !there.is_ground && !here.imports.contains(&import) {
                found.insert((here.name.clone(), import.clone()));
            }
            assert!(!here.never.contains(&import), "src/{}: imports {import}", file.path);
            used.insert((here.name.clone(), import));
        }
    }
    assert!(used.len() > 40, "only {} imports: this reads the wrong thing", used.len());
    let owned = |&(a, b): &(&str, &str)| (a.to_owned(), b.to_owned());
    same(&found, NOT_YET.iter().map(owned).collect(), "imports that the code map does not allow");
}

/// Every room imports only rooms that stand below it, and the map lists every module.
#[test]
fn the_code_map_runs_one_way_and_is_complete() {
    let map = rooms();
    for (i, room) in map.iter().enumerate() {
        for import in &room.imports {
            let at = map.iter().position(|other| other.name == *import);
            assert!(at.is_some_and(|at| at > i), "{} → {import} runs upwards", room.name);
            assert!(!room.never.contains(import), "{} both may and must not: {import}", room.name);
        }
        let below = map[i..].iter().all(|other| other.is_ground);
        assert!(!room.is_ground || below, "{} is not at the ground", room.name);
    }
    let library = Library::get();
    let modules: BTreeSet<&str> =
        library.files().map(File::room).filter(|room| *room != "lib").collect();
    assert_eq!(map.iter().map(|room| room.name.as_str()).collect::<BTreeSet<_>>(), modules);
}

#[test]
fn reports_call_no_function_of_another_room() {
    let (map, library) = (rooms(), Library::get());
    let is_ground = |room: &str| map.iter().any(|other| other.name == room && other.is_ground);
    let mut found = BTreeSet::new();
    for file in library.files().filter(|file| file.room() == "report") {
        for (_, target) in library.named(file) {
            let room = target.file.room();
            if target.kind == Some(Kind::Function) && room != "report" && !is_ground(room) {
                found.insert(format!("{room}::{}", target.name));
            }
        }
    }
    let expected = REPORTS_CALL.iter().map(|&name| name.to_owned()).collect();
    same(&found, expected, "functions that reports call");
}

/// The methods of a file, and whether each is public and computes: its body has arithmetic, a loop or
/// a variable that changes. What only picks and arranges is an accessor.
fn methods(file: &File) -> Vec<(&str, bool)> {
    let words: Vec<&str> = file.tokens.iter().map(|token| token.text.as_str()).collect();
    let is_value = |word: &str| {
        let is_name = word.starts_with(|c: char| c.is_alphanumeric() || c == '_');
        (is_name && !["match", "return", "in", "if", "else"].contains(&word))
            || [")", "]"].contains(&word)
    };
    let computes = |body: &[&str]| {
        body.windows(3).any(|w| {
            let is_operator = ["+", "-", "*", "/"].contains(&w[1]) && w[2] != ">";
            is_operator && is_value(w[0]) || w[0] == "let" && w[1] == "mut"
        }) || body.iter().any(|word| ["for", "while", "loop"].contains(word))
    };
    let mut found = Vec::new();
    for at in (1..words.len()).filter(|&at| words[at] == "fn") {
        let after = |from: usize, mark: &str| (from..words.len()).find(|&i| words[i] == mark);
        let Some(open) = after(at, "(") else { continue };
        let takes_self = words[open..].iter().take(5).any(|word| *word == "self");
        let Some(start) = after(open, "{").filter(|_| takes_self) else { continue };
        let mut depth = 0;
        let end = (start..words.len()).find(|&i| {
            depth += i32::from(words[i] == "{") - i32::from(words[i] == "}");
            depth == 0
        });
        let body = &words[start..end.unwrap_or(words.len())];
        found.push((words[at + 1], words[at - 1] == "pub" && computes(body)));
    }
    found
}

/// By name alone, as a text has no types: a method that reports define themselves is theirs.
#[test]
fn reports_call_no_method_that_computes() {
    let (map, library) = (rooms(), Library::get());
    let report = map.iter().find(|room| room.name == "report").expect("an item for report");
    let mut computing: BTreeMap<&str, &str> = BTreeMap::new();
    for file in library.files().filter(|file| report.imports.contains(file.room())) {
        let of_file = methods(file).into_iter().filter(|(_, computes)| *computes);
        computing.extend(of_file.map(|(name, _)| (name, file.room())));
    }
    assert!(computing.len() > 10, "only {computing:?}: this reads the wrong thing");
    let (mut own, mut called) = (BTreeSet::new(), BTreeSet::new());
    for file in library.files().filter(|file| file.room() == "report") {
        let words: Vec<&str> = file.tokens.iter().map(|token| token.text.as_str()).collect();
        own.extend(methods(file).into_iter().map(|(name, _)| name));
        let is_call = |w: &&[&str]| w[0] == "." && ["(", "::"].contains(&w[2]);
        called.extend(words.windows(3).filter(is_call).map(|w| w[1]));
    }
    let found = called
        .difference(&own)
        .filter_map(|name| computing.get(name).map(|room| format!("{room}::{name}")));
    let expected = REPORTS_COMPUTE.iter().map(|&name| name.to_owned()).collect();
    same(&found.collect(), expected, "methods that compute and that reports call");
}

#[test]
fn files_and_printing_are_left_to_few() {
    for file in Library::get().files() {
        let text: Vec<&str> = file.tokens.iter().map(|token| token.text.as_str()).collect();
        let prints = |w: &[&str]| {
            w[1] == "!" && ["println", "eprintln", "print", "eprint", "dbg"].contains(&w[0])
        };
        let names = |module: &str| {
            let named = |path: &[String]| path.len() > 1 && path[0] == "std" && path[1] == module;
            file.imports.iter().any(|import| named(&import.path)) || file.paths().any(named)
        };
        let room = file.room();
        let files = names("fs");
        let outside = text.windows(2).any(prints) || names("env") || names("process");
        assert!(!files || FILES_IN.contains(&room), "src/{}: opens files", file.path);
        assert!(!outside || PRINTS_IN.contains(&room), "src/{}: prints, or asks about", file.path);
    }
}

/// Cargo.toml forbids it elsewhere, but for what allows it by itself.
#[test]
fn code_without_the_compiler_s_guarantees_is_in_one_file() {
    let allows = |file: &&File| file.text.contains("(unsafe_code)");
    let files: Vec<&str> =
        Library::get().files().filter(allows).map(|file| file.path.as_str()).collect();
    assert_eq!(files, ["cli/started.rs"]);
}

#[test]
fn crates_are_named_where_they_belong() {
    let mut homes: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for file in Library::get().files() {
        for (name, _) in NAMED_ONLY_IN {
            let paths = file.imports.iter().map(|import| import.path.as_slice());
            if paths.chain(file.paths()).any(|path| path[0] == *name) {
                homes.entry(name).or_default().insert(file.room().to_owned());
            }
        }
    }
    for (name, rooms) in NAMED_ONLY_IN {
        let expected = rooms.iter().map(|&room| room.to_owned()).collect();
        same(&homes.remove(name).unwrap_or_default(), expected, name);
    }
}

/// Conversions live in one file: nobody else multiplies by 2π, divides by sixty or makes percent.
#[test]
fn units_are_converted_in_one_place() {
    for file in Library::get().files().filter(|file| file.room() != "units") {
        let words: Vec<&str> = file.tokens.iter().map(|token| token.text.as_str()).collect();
        for (i, word) in words.iter().enumerate() {
            let number = word.replace('_', "");
            let next = |step: isize| {
                let at = i.checked_add_signed(step);
                at.and_then(|at| words.get(at)).copied().unwrap_or_default()
            };
            let factor = ["60.0", "100.0"].contains(&number.as_str())
                && (["*", "/"].contains(&next(-1)) || next(1) == "*");
            let half_turn = number == "180.0" && (next(1) == "/" || next(-2) == "PI");
            let digits = ["0.0174532", "57.29577", "0.1047197", "9.549296"];
            let converts = factor
                || half_turn
                || digits.iter().any(|digits| number.starts_with(digits))
                || ["to_degrees", "to_radians"].contains(word);
            let line = file.tokens[i].line;
            assert!(!converts, "src/{}:{line}: converts units: {word}", file.path);
        }
    }
}

const WIDTH: usize = 100;
const MAX_LINES: usize = 700;

/// Lines fit the formatter's width, comments included; rows of tables and addresses cannot be broken.
#[test]
fn files_are_short_and_lines_too() {
    for file in Library::get().files() {
        let lines = file.text.lines().count();
        assert!(lines <= MAX_LINES, "src/{}: {lines} lines", file.path);
        for (i, line) in file.text.lines().enumerate() {
            let text = line.trim_start_matches(|c: char| c.is_whitespace() || "/!".contains(c));
            let may_be_long = text.starts_with('|') || text.contains("http");
            let is_long = line.chars().count() > WIDTH && !may_be_long;
            assert!(!is_long, "src/{}:{}: more than {WIDTH} columns", file.path, i + 1);
        }
    }
}

/// The reader of sources reads what the tests above rely on.
#[test]
fn sources_are_read_as_rust_is_written() {
    let text = "a\n#[cfg(test)]\nconst B: [u8; 1] = [0];\n// c\nd /* e /* f */ */ \"g\\\"\" r#\"h\"# 'i' &'j k\n\
                #[cfg(test)]\nuse l::{m, n};\n#[cfg(test)]\npub(super) mod tests {\n fn o() { p; }\n}\nq 1_000.5::r\n#[cfg(test)]\nmod only;\n";
    let (kept, modules) = without_tests(&tokens(text));
    let words: Vec<&str> = kept.iter().map(|token| token.text.as_str()).collect();
    assert_eq!(words, ["a", "d", "&", "'", "j", "k", "q", "1_000.5", "::", "r"]);
    assert_eq!(kept[6].line, 12);
    assert_eq!(modules, ["tests", "only"]);
    assert!(root().join("src/lib.rs").exists());
}
