//! Files that other files name, and how large a file may be.

use std::path::{Path, PathBuf};

use crate::formats::text::{lower_first, read_text};
use crate::notes::{Code, Note, Notes};
use crate::paths::{folder_of, tidied};

/// Largest job, table or program that is read: a job of a million waypoints has about 60 MB.
pub(super) const MAX_FILE_BYTES: u64 = 64 << 20;

/// Largest robot or session that is read: real ones have a few kB.
pub(super) const MAX_ROBOT_BYTES: u64 = 1 << 20;

/// The text of a part of a map, which `detune map` has written.
pub fn sketch_text(path: &Path) -> Result<String, Note> {
    read_text(path, MAX_FILE_BYTES)
}

/// `named` as seen from the folder of the file `by` that names it.
///
/// `jobs/../robots/a.yaml` is shown as `robots/a.yaml` where that is the same file.
pub(super) fn relative_to(by: &Path, named: &str) -> PathBuf {
    let joined = by.parent().unwrap_or(Path::new("")).join(named);
    let short = tidied(&joined);
    // `a/..` is not the folder itself where `a` is a symbolic link.
    match (joined.canonicalize(), short.canonicalize()) {
        (Ok(long), Ok(same)) if long == same => short,
        _ => joined,
    }
}

/// Where a file is, or was: without links and detours, as far as its folders are there.
pub fn whole_place(file: &Path) -> PathBuf {
    if let Ok(place) = file.canonicalize() {
        return place;
    }
    let whole = tidied(&std::path::absolute(file).unwrap_or_else(|_| file.to_owned()));
    let there = whole.ancestors().skip(1).find_map(|folder| {
        let rest = whole.strip_prefix(folder).ok()?;
        Some(folder.canonicalize().ok()?.join(rest))
    });
    there.unwrap_or(whole)
}

/// The top of the Git repository that a place lies in.
pub fn repository_of(place: &Path) -> Option<PathBuf> {
    place.ancestors().find(|up| up.join(".git").exists()).map(Path::to_owned)
}

/// Whether two paths lead to one place, also where no file stands there yet.
pub(super) fn is_one_place(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = folder_of(path).canonicalize().ok()?;
        let file = folder.join(path.file_name()?);
        Some(file.canonicalize().unwrap_or(file))
    };
    matches!((place(a), place(b)), (Some(a), Some(b)) if a == b)
}

/// The file that `name` under `key` of the file `by` means, if it is there.
pub(super) fn named_file(
    by: &Path,
    key: &str,
    name: &str,
    line: usize,
    notes: &mut Notes,
) -> Option<PathBuf> {
    let path = relative_to(by, name);
    let what = match std::fs::metadata(&path) {
        Ok(metadata) if metadata.is_dir() => {
            let robot = path.join("robot.yaml");
            if key == "robot" && robot.is_file() {
                return Some(robot);
            }
            "is a folder, must be a file".to_owned()
        }
        Ok(_) => return Some(path),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            // Said once where the name says it all.
            if path == Path::new(name) {
                "no such file".to_owned()
            } else {
                format!("no such file: looked for {}", path.display())
            }
        }
        Err(error) => format!("cannot be read: {}", lower_first(&error.to_string())),
    };
    notes.error(Code::Unreadable, line, format!("{key} '{name}': {what}"));
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detours_are_left_out_where_the_file_is_the_same() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("jobs")).unwrap();
        std::fs::write(folder.path().join("r.yaml"), "").unwrap();
        let named = relative_to(&folder.path().join("jobs/j.yaml"), "../r.yaml");
        assert_eq!(named, folder.path().join("r.yaml"));
    }
}
