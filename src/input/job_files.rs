//! The job files that arguments mean: files, folders, and patterns that no shell has expanded.

use std::collections::{HashSet, VecDeque};
use std::path::{Path, PathBuf};

use super::files::MAX_FILE_BYTES;
use crate::formats::text::{lower_first, read_bytes};
use crate::formats::yaml::parse;
use crate::notes::{Code, Note, Notes, Place};

/// Keys that every job has, and no other file that lies about.
const OF_A_JOB: [&str; 3] = ["operations", "spindle", "robot:"];

/// Folders below folders, at most.
const MAX_DEPTH: usize = 64;

/// The files that `arguments` mean, in their order: a file stands for itself, whether or not it is
/// there; a folder for the jobs in it and below it, also in folders that links there lead to; a
/// pattern of `*`, `?`, `[…]` and `**` for all that it fits. Files that are no job (robots,
/// sessions, what other programs read) are left out, hidden ones too. What a folder or pattern
/// names comes once, by whatever names; a file that is named itself comes as often.
///
/// # Errors
/// Folders and patterns that hold no job or that cannot be read.
pub fn job_files(arguments: &[PathBuf]) -> Result<Vec<PathBuf>, Vec<Note>> {
    let (mut files, mut errors) = (Vec::new(), Vec::new());
    let (mut named, mut found_in) = (HashSet::new(), HashSet::new());
    let whole = |file: &PathBuf| file.canonicalize().unwrap_or_else(|_| file.clone());
    for argument in arguments {
        let found = if argument.is_dir() {
            below(argument)
        } else {
            match argument.to_str().filter(|text| is_pattern(text) && !argument.exists()) {
                Some(pattern) => fitting(pattern),
                None => {
                    if !found_in.contains(&whole(argument)) {
                        named.insert(whole(argument));
                        files.push(argument.clone());
                    }
                    continue;
                }
            }
        };
        match found {
            Ok(found) => files.extend(
                found
                    .into_iter()
                    .filter(|file| found_in.insert(whole(file)) && !named.contains(&whole(file))),
            ),
            Err(error) => errors.push(error),
        }
    }
    if errors.is_empty() { Ok(files) } else { Err(errors) }
}

/// Whether arguments mean what they name, one file.
pub fn is_one_file(arguments: &[PathBuf]) -> bool {
    let [one] = arguments else { return false };
    let fits_many = one.to_str().is_some_and(is_pattern) && !one.exists();
    !(one.is_dir() || fits_many)
}

fn is_pattern(text: &str) -> bool {
    text.contains(['*', '?', '['])
}

/// The jobs that a pattern fits, by name.
fn fitting(pattern: &str) -> Result<Vec<PathBuf>, Note> {
    let fault = |what: String| Note::error(Code::Unreadable, Place::file(pattern), what);
    let found = glob::glob(pattern)
        .map_err(|error| fault(format!("is no pattern of file names: {}", error.msg)))?;
    let mut files = Vec::new();
    for path in found {
        let path = path.map_err(|error| unreadable(error.path(), error.error()))?;
        if path.is_dir() {
            continue;
        }
        if is_job(&path) {
            files.push(path);
        }
    }
    if files.is_empty() { Err(fault("no such job file".to_owned())) } else { Ok(files) }
}

/// The jobs in a folder and below it, by name, those of the folder itself first; then those in
/// the folders that links lead to.
fn below(folder: &Path) -> Result<Vec<PathBuf>, Note> {
    let mut search = Search::default();
    search.walk(folder, MAX_DEPTH)?;
    while let Some((link, depth)) = search.links.pop_front() {
        search.walk(&link, depth)?;
    }
    if search.files.is_empty() {
        let what = "is a folder without job files (.yaml or .yml)";
        return Err(Note::error(Code::Unreadable, Place::file(folder), what));
    }
    Ok(search.files)
}

#[derive(Debug, Default)]
struct Search {
    files: Vec<PathBuf>,
    /// Links to folders, and how many folders may lie below each.
    links: VecDeque<(PathBuf, usize)>,
    /// Folders without links in their paths: a link may lead back to one.
    seen: HashSet<PathBuf>,
}

impl Search {
    fn walk(&mut self, folder: &Path, depth: usize) -> Result<(), Note> {
        let of_folder = |error: std::io::Error| unreadable(folder, &error);
        if !self.seen.insert(folder.canonicalize().map_err(of_folder)?) {
            return Ok(());
        }
        let mut entries = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(of_folder)? {
            let entry = entry.map_err(of_folder)?;
            let kind = entry.file_type().map_err(of_folder)?;
            let is_hidden = entry.file_name().to_string_lossy().starts_with('.');
            if !is_hidden {
                let (path, is_link) = (entry.path(), kind.is_symlink());
                let is_folder = kind.is_dir() || is_link && path.is_dir();
                entries.push((is_folder, path, is_link));
            }
        }
        entries.sort();
        for (is_folder, path, is_link) in entries {
            if is_folder && depth == 0 {
                let what = "lies too deep below the folder that was named";
                return Err(Note::error(Code::TooLong, Place::file(&path), what));
            }
            match (is_folder, is_link) {
                (true, false) => self.walk(&path, depth - 1)?,
                (true, true) => self.links.push_back((path, depth - 1)),
                _ if is_job(&path) => self.files.push(path),
                _ => {}
            }
        }
        Ok(())
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> Note {
    let what = format!("cannot be read: {}", lower_first(&error.to_string()));
    Note::error(Code::Unreadable, Place::file(path), what)
}

/// Whether a file is YAML that has, or tries to have, what every job has. What cannot be read, is
/// written in braces or in UTF-16 is taken for one: reading it says why.
fn is_job(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    if !extension.is_some_and(|e| e.eq_ignore_ascii_case("yaml") || e.eq_ignore_ascii_case("yml")) {
        return false;
    }
    // A pipe would wait for somebody who writes into it.
    if std::fs::metadata(path).is_ok_and(|own| !own.is_file()) {
        return false;
    }
    let Ok(bytes) = read_bytes(path, MAX_FILE_BYTES) else { return true };
    let lines: Vec<&[u8]> =
        bytes.split(|byte| matches!(byte, b'\n' | b'\r')).map(without_starts).collect();
    let is_key = |line: &&[u8]| OF_A_JOB.iter().any(|own| line.starts_with(own.as_bytes()));
    let first = lines.iter().find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let in_braces = first.is_some_and(|line| line.starts_with(b"{"))
        && OF_A_JOB.iter().any(|own| memchr::memmem::find(&bytes, own.as_bytes()).is_some());
    let is_utf_16 = bytes.contains(&0);
    is_utf_16 || in_braces || lines.iter().any(is_key) || is_broken(path, &bytes)
}

/// Whether a file is empty or no YAML: what it was to be nobody knows.
fn is_broken(path: &Path, bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return true };
    let mut notes = Notes::about(Place::file(path));
    parse(text, &mut notes).is_none() || notes.errors() > 0
}

/// A line without the start of a document, of a key, of a string.
fn without_starts(line: &[u8]) -> &[u8] {
    [&b"---"[..], b"?", b"\"", b"'"].into_iter().fold(line.trim_ascii_start(), |line, start| {
        line.strip_prefix(start).unwrap_or(line).trim_ascii_start()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_and_patterns_stand_for_the_jobs_in_them() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["b/deep", ".hidden", "empty"] {
            std::fs::create_dir_all(at(name)).unwrap();
        }
        for (name, text) in [
            ("b.yaml", "operations: []\n"),
            ("a.yml", "{operations: []}"),
            ("robot.yaml", "name: arm\nurdf: arm.urdf\n"),
            ("odd.yaml", "# broken\n  \"spindle\" []\n"),
            ("compose.yaml", "services: {}\n"),
            ("action.yml", "runs:\n  - with:\n      {a: 1}\n"),
            ("notes.txt", "operations:\n"),
            ("b/deep/c.YAML", "operations: []\n"),
            (".hidden/d.yaml", "operations: []\n"),
            ("cr.yaml", "name: old\roperations: []\r"),
            ("doc.yaml", "--- {operations: []}\n"),
            ("utf16.yaml", "o\0p\0e\0"),
            // Jobs once: cut off, emptied, with a tab.
            ("b/cut.yaml", "name: a\nrobot: r.yaml\n"),
            ("b/empty.yaml", "# nothing\n"),
            ("b/tab.yaml", "name: a\n\tteeth: [2\n"),
        ] {
            std::fs::write(at(name), text).unwrap();
        }
        let found = |arguments: &[PathBuf]| job_files(arguments).unwrap();
        let all = [
            "a.yml",
            "b.yaml",
            "cr.yaml",
            "doc.yaml",
            "odd.yaml",
            "utf16.yaml",
            "b/cut.yaml",
            "b/empty.yaml",
            "b/tab.yaml",
            "b/deep/c.YAML",
        ]
        .map(at);
        assert_eq!(found(&[folder.path().to_owned()]), all);
        assert_eq!(found(&[at("*.yaml")]), all[1..6]);
        assert_eq!(found(&[at("b.yaml"), folder.path().to_owned()])[0], at("b.yaml"));
        assert_eq!(found(&[at("b.yaml"), folder.path().to_owned()]).len(), all.len());
        let by_other_names = [at("b/../b.yaml"), folder.path().join("."), at("b.yaml")];
        assert_eq!(found(&by_other_names).len(), all.len());
        let twice = [at("b.yaml"), at("b.yaml")];
        assert_eq!(found(&twice), twice);
        assert_eq!(found(&[at("**/*.YAML")]), [at("b/deep/c.YAML")]);
        #[cfg(unix)]
        {
            // Nobody writes into it.
            let made = std::process::Command::new("mkfifo").arg(at("pipe.yaml")).status();
            assert!(made.unwrap().success());
            assert_eq!(found(&[folder.path().to_owned()]), all);
        }
        // A file that is not there is somebody else's to tell.
        assert_eq!(found(&[at("gone.yaml")]), [at("gone.yaml")]);
        // A name with brackets that is there is no pattern.
        std::fs::write(at("[b].yaml"), "operations: []\n").unwrap();
        assert_eq!(found(&[at("[b].yaml")]), [at("[b].yaml")]);
        for (wrong, told) in
            [(at("empty"), "without job files"), (at("x*.yaml"), "no such job file")]
        {
            let errors = job_files(&[wrong]).unwrap_err();
            assert!(errors[0].what.contains(told), "{errors:?}");
        }
        assert!(is_one_file(&[at("[b].yaml")]) && !is_one_file(&[at("*.yaml")]));
    }
}
