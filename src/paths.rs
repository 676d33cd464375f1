//! Paths by their names alone, whether or not anything is there.

use std::path::{Component, Path, PathBuf};

/// Where a file lies: `.` for a bare name.
pub fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The path without `.`, and without `folder/..`, judged by the names alone.
pub fn tidied(path: &Path) -> PathBuf {
    let mut tidy = PathBuf::new();
    for component in path.components() {
        match (component, tidy.components().next_back()) {
            (Component::CurDir, _) => {}
            (Component::ParentDir, Some(Component::Normal(_))) => {
                tidy.pop();
            }
            (Component::ParentDir, Some(Component::RootDir)) => {}
            _ => tidy.push(component),
        }
    }
    tidy
}

/// How a file is named from a folder. Both are whole and without `..`; `None` where they share no
/// root.
pub fn from_folder(folder: &Path, file: &Path) -> Option<PathBuf> {
    let of_root = |path: &Path| path.components().next().map(|first| first.as_os_str().to_owned());
    if of_root(folder) != of_root(file) || !folder.is_absolute() {
        return None;
    }
    let shared = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    Some(up.chain(file.components().skip(shared)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_named_from_any_folder() {
        for (folder, file, named) in [
            ("/a/b", "/a/b/c", "c"),
            ("/a/b", "/a/c/d", "../c/d"),
            ("/a/bc", "/a/b", "../b"),
            ("/", "/a", "a"),
        ] {
            let found = from_folder(Path::new(folder), Path::new(file));
            assert_eq!(found.as_deref(), Some(Path::new(named)), "{folder} {file}");
        }
        assert_eq!(from_folder(Path::new("a"), Path::new("/a/b")), None);
    }

    #[test]
    fn detours_are_left_out() {
        assert_eq!(tidied(Path::new("../a/./b/../c")), Path::new("../a/c"));
        assert_eq!(tidied(Path::new("/../a")), Path::new("/a"));
        assert_eq!(folder_of(Path::new("a")), Path::new("."));
        assert_eq!(folder_of(Path::new("a/b")), Path::new("a"));
    }
}
