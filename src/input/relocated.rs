//! Names of files as other files must spell them.

use std::path::{Component, Path, PathBuf};

use crate::paths::folder_of;

/// `named` in the file `from`, as the file `to` must name it; `None` where nothing changes.
pub(super) fn relocated(named: &str, from: &Path, to: &Path) -> Option<String> {
    if Path::new(named).is_absolute() || resolved(folder_of(from)) == resolved(folder_of(to)) {
        return None;
    }
    named_from(to, &resolved(&folder_of(from).join(named)))
}

/// An absolute file as the file `by` names it: relative where the two have anything in common.
pub(super) fn named_from(by: &Path, file: &Path) -> Option<String> {
    let folder = resolved(folder_of(by));
    let shared = folder.components().zip(file.components()).take_while(|(a, b)| a == b).count();
    let is_rooted = |c: &Component| matches!(c, Component::Normal(_));
    let name = if folder.components().take(shared).any(|c| is_rooted(&c)) || shared > 0 {
        let up = folder.components().skip(shared).map(|_| "..".to_owned());
        let down = file.components().skip(shared);
        let down = down.map(|part| part.as_os_str().to_str().map(str::to_owned));
        let parts: Option<Vec<String>> = up.map(Some).chain(down).collect();
        parts?.join("/")
    } else {
        file.to_str()?.to_owned()
    };
    Some(name)
}

/// Absolute, with links followed where the file is there; a file that is not yet there, in its
/// folder.
pub(super) fn resolved(path: &Path) -> PathBuf {
    path.canonicalize()
        .or_else(|error| match path.file_name() {
            Some(name) => folder_of(path).canonicalize().map(|folder| folder.join(name)),
            None => Err(error),
        })
        .or_else(|_| std::path::absolute(path))
        .unwrap_or_else(|_| path.to_owned())
}
