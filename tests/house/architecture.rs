//! Holds the code map of `src/lib.rs`: which module may import which, and which crates are named where.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What each module may import of the crate, beside itself.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("guide", &[]),
    ("units", &[]),
    ("wording", &[]),
    ("notes", &["wording"]),
    ("motion", &[]),
    ("progress", &[]),
    ("model", &["units", "wording"]),
    ("two_link", &["units"]),
    ("modes", &["model", "units"]),
    ("free_vibration", &["model", "modes", "units"]),
    ("job", &["model", "motion"]),
    ("excitation", &["job", "units"]),
    ("program", &["motion", "units"]),
    ("identify", &["units"]),
    ("diagnosis", &["model", "modes", "identify", "units"]),
    ("path", &["model", "modes", "motion", "notes", "progress", "units", "wording"]),
    ("map", &["model", "modes", "free_vibration", "units"]),
    ("risk", &["excitation", "job", "path", "modes", "model", "notes", "progress", "units"]),
    (
        "advice",
        &[
            "risk",
            "excitation",
            "job",
            "path",
            "modes",
            "model",
            "motion",
            "notes",
            "progress",
            "units",
        ],
    ),
    ("input", &["job", "model", "motion", "program", "identify", "units", "wording"]),
    (
        "study",
        &[
            "advice",
            "risk",
            "map",
            "diagnosis",
            "identify",
            "input",
            "program",
            "job",
            "model",
            "free_vibration",
            "notes",
            "progress",
            "units",
            "wording",
        ],
    ),
    (
        "report",
        &[
            "study",
            "notes",
            "advice",
            "risk",
            "map",
            "diagnosis",
            "job",
            "excitation",
            "identify",
            "free_vibration",
            "units",
            "wording",
        ],
    ),
    (
        "cli",
        &[
            "study",
            "notes",
            "progress",
            "advice",
            "input",
            "program",
            "report",
            "risk",
            "map",
            "diagnosis",
            "job",
            "identify",
            "model",
            "free_vibration",
            "units",
            "wording",
        ],
    ),
];

/// Crates that one module alone may name.
const NAMED_ONLY_IN: &[(&str, &str)] = &[
    ("urdf_rs", "input"),
    ("serde_yaml", "input"),
    ("roxmltree", "input"),
    ("saphyr_parser", "input"),
    ("clarabel", "advice"),
    ("clap", "cli"),
    ("indicatif", "cli"),
    ("quick_junit", "report"),
    ("hound", "input"),
];

/// Every source file with the module that it belongs to.
fn sources() -> Vec<(String, PathBuf, String)> {
    fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, found);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    walk(&root, &mut files);
    files.sort();
    files
        .into_iter()
        .map(|file| {
            let first = file.strip_prefix(&root).unwrap().components().next().unwrap();
            let module = first.as_os_str().to_string_lossy().trim_end_matches(".rs").to_owned();
            let text = fs::read_to_string(&file).unwrap();
            (module, file, text)
        })
        .collect()
}

/// Code without comments, doc comments and the module of tests at its end: what is compiled into the
/// library, and single items that only tests use.
fn code(text: &str) -> String {
    let tests = ["#[cfg(test)]\nmod tests", "#[cfg(test)]\npub(super) mod tests"];
    let end = tests.iter().filter_map(|start| text.find(start)).min().unwrap_or(text.len());
    let library = &text[..end];
    library
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n")
}

/// Modules named as `crate::module` or within `crate::{…}`.
fn imports(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        if let Some(group) = rest.strip_prefix('{') {
            let mut depth = 1;
            let mut item = String::new();
            for c in group.chars() {
                match c {
                    '{' => depth += 1,
                    '}' => depth -= 1,
                    _ => {}
                }
                if depth == 0 {
                    break;
                }
                item.push(c);
            }
            found.extend(
                item.split(',')
                    .map(|part| part.trim().split("::").next().unwrap_or_default().to_owned()),
            );
        } else {
            let name: String =
                rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            found.push(name);
        }
    }
    found
}

#[test]
fn modules_import_only_what_lies_below_them() {
    let allowed: BTreeMap<&str, &[&str]> = MAY_IMPORT.iter().copied().collect();
    let mut edges = 0;
    for (module, file, text) in sources() {
        if module == "lib" || module == "main" {
            continue;
        }
        let Some(allowed_here) = allowed.get(module.as_str()) else {
            panic!("module '{module}' is not in the table: say what it may import")
        };
        for import in imports(&code(&text)) {
            if !allowed.contains_key(import.as_str()) || import == module {
                continue;
            }
            edges += 1;
            assert!(
                allowed_here.contains(&import.as_str()),
                "{}: {module} must not import {import}",
                file.display()
            );
        }
    }
    assert!(edges > 20, "the walk saw only {edges} imports: it reads the wrong thing");
}

/// The table itself has no circle: every module imports only modules that stand above it in the table.
#[test]
fn the_table_runs_one_way() {
    for (i, (module, imports)) in MAY_IMPORT.iter().enumerate() {
        for import in *imports {
            let at = MAY_IMPORT.iter().position(|(name, _)| name == import);
            assert!(at.is_some_and(|at| at < i), "{module} → {import} runs upwards");
        }
    }
}

#[test]
fn crates_are_named_where_they_belong() {
    for (module, file, text) in sources() {
        let code = code(&text);
        for (name, home) in NAMED_ONLY_IN {
            let named =
                code.contains(&format!("{name}::")) || code.contains(&format!("use {name}"));
            assert!(!named || module == *home, "{}: names {name}", file.display());
        }
    }
}

/// An item for tests alone does not hide the code behind it.
#[test]
fn code_ends_where_the_tests_begin() {
    let text = "a\n#[cfg(test)]\nconst B: u8 = 0;\n// c\nd\n#[cfg(test)]\nmod tests {\ne\n}\n";
    assert_eq!(code(text), "a\n#[cfg(test)]\nconst B: u8 = 0;\nd");
    for (_, file, text) in sources() {
        let modules = text.matches("mod tests {").count();
        let code = code(&text);
        assert!(
            modules == 0 || !code.contains("mod tests {"),
            "{}: its module of tests is dressed otherwise",
            file.display()
        );
    }
}

/// Conversions live in one file: nobody else multiplies by 2π, divides by sixty or makes percent.
#[test]
fn units_are_converted_in_one_place() {
    for (module, file, text) in sources() {
        if module == "units" {
            continue;
        }
        for (i, line) in code(&text).lines().enumerate() {
            let line = line.replace('_', "");
            for constant in [
                "/ 60.0",
                "* 60.0",
                "60.0 *",
                "/ 100.0",
                "* 100.0",
                "100.0 *",
                "PI / 180.0",
                "180.0 / PI",
                "0.0174532",
                "57.29577",
                "0.1047197",
                "9.549296",
                "todegrees()",
                "toradians()",
            ] {
                assert!(
                    !line.contains(constant),
                    "{}: line {} of its code converts units: {line}",
                    file.display(),
                    i + 1
                );
            }
        }
    }
}

/// `lib.rs` lists every module in its code map.
#[test]
fn the_code_map_is_complete() {
    let lib = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs")).unwrap();
    for line in lib.lines() {
        if let Some(module) = line.strip_prefix("pub mod ").and_then(|l| l.strip_suffix(';')) {
            assert!(
                lib.contains(&format!("[`{module}`]")),
                "{module} is missing from the code map"
            );
        }
    }
}
