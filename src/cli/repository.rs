//! Files by the names that their repository has for them.

use std::path::{Path, PathBuf};

use crate::paths::{folder_of, tidied};

/// What marks the root of a repository.
const ROOTS: [&str; 2] = [".git", ".hg"];

/// A file as seen from the root of its repository; without one, as seen from the root of the disk.
/// In both cases the same wherever the command runs.
pub(super) fn named(file: &Path) -> PathBuf {
    let Ok(folder) = folder_of(file).canonicalize() else { return tidied(file) };
    let whole = folder.join(file.file_name().unwrap_or_default());
    let root = folder.ancestors().find(|up| ROOTS.iter().any(|root| up.join(root).exists()));
    let within = root.and_then(|root| whole.strip_prefix(root).ok());
    within.map_or_else(|| whole.clone(), Path::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_one_name_from_everywhere() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().canonicalize().unwrap();
        std::fs::create_dir_all(root.join("jobs/deep")).unwrap();
        let named_from = |path: &str| named(&root.join(path));
        assert_eq!(named_from("jobs/a.yaml"), root.join("jobs/a.yaml"));
        std::fs::create_dir(root.join(".git")).unwrap();
        for path in ["jobs/a.yaml", "jobs/deep/../a.yaml", "./jobs/a.yaml"] {
            assert_eq!(named_from(path), Path::new("jobs/a.yaml"), "{path}");
        }
    }
}
