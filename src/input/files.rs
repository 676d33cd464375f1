//! Files that other files name, and how large a file may be.

use std::path::{Component, Path, PathBuf};

use crate::formats::text::{folder_of, lower_first};
use crate::notes::{Code, Notes};

/// Largest job that is read: one of a million waypoints has about 60 MB.
pub(super) const MAX_JOB_BYTES: u64 = 64 << 20;

/// Largest robot.yaml that is read: real ones have a few kB.
pub(super) const MAX_ROBOT_BYTES: u64 = 1 << 20;

/// Largest URDF that is read: meshes lie in files of their own, so real ones stay below 1 MB.
pub(super) const MAX_URDF_BYTES: u64 = 4 << 20;

/// Largest table of load tests that is read.
pub(super) const MAX_TABLE_BYTES: u64 = 64 << 20;

/// Largest robot or CAM program that is read.
pub(super) const MAX_PROGRAM_BYTES: u64 = 64 << 20;

/// `named` as seen from the folder of the file `by` that names it.
///
/// `jobs/../robots/a.yaml` is shown as `robots/a.yaml` where that is the same file.
pub(super) fn relative_to(by: &Path, named: &str) -> PathBuf {
    let joined = by.parent().unwrap_or(Path::new("")).join(named);
    let short = without_detours(&joined);
    // `a/..` is not the folder itself where `a` is a symbolic link.
    match (joined.canonicalize(), short.canonicalize()) {
        (Ok(long), Ok(same)) if long == same => short,
        _ => joined,
    }
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
        Ok(metadata) if metadata.is_dir() => match file_in(&path, key) {
            Some(inside) => {
                let meant = Path::new(name).join(inside);
                format!("is a folder, must be a file; did you mean '{}'?", meant.display())
            }
            None => "is a folder, must be a file".to_owned(),
        },
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

/// The file in a folder that a key for a file is likely to mean.
fn file_in(folder: &Path, key: &str) -> Option<String> {
    let names = |wanted: &str| folder.join(wanted).is_file().then(|| wanted.to_owned());
    match key {
        "robot" => names("robot.yaml"),
        _ => None,
    }
}

pub(super) fn without_detours(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir
                if matches!(short.components().next_back(), Some(Component::Normal(_))) =>
            {
                short.pop();
            }
            other => short.push(other),
        }
    }
    short
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
        assert_eq!(without_detours(Path::new("../a/./b/../c")), Path::new("../a/c"));
    }
}
