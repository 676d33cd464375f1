//! Paths as they stand in reports: tidy, with forward slashes where a format asks for a URI.

use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

use crate::paths::tidied;

/// `named`, a path that the file `beside` names, seen from where `beside` is seen.
pub(super) fn beside(beside: &Path, named: &Path) -> PathBuf {
    tidied(&beside.parent().unwrap_or(Path::new("")).join(named))
}

/// The path relative to `root` if it lies inside, else tidied as it is.
pub(super) fn within(root: &Path, path: &Path) -> PathBuf {
    let tidy = tidied(path);
    match tidy.strip_prefix(root) {
        Ok(inside) if !inside.as_os_str().is_empty() => inside.to_owned(),
        _ => tidy,
    }
}

/// The path with forward slashes.
pub(super) fn slashed(path: &Path) -> String {
    let mut text = String::new();
    for component in path.components() {
        match component {
            Component::RootDir => text.push('/'),
            other => {
                if !(text.is_empty() || text.ends_with('/')) {
                    text.push('/');
                }
                text.push_str(&other.as_os_str().to_string_lossy());
            }
        }
    }
    text
}

/// A URI reference: relative for a relative path, `file://` for an absolute one.
pub(super) fn uri(path: &Path) -> String {
    let slashed = slashed(path);
    let mut uri = String::new();
    if path.is_absolute() {
        uri.push_str(if slashed.starts_with('/') { "file://" } else { "file:///" });
    }
    for byte in slashed.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                uri.push(char::from(byte));
            }
            other => {
                // Writing to a string cannot fail.
                let _ = write!(uri, "%{other:02X}");
            }
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_is_sought_beside_its_job() {
        let found = |job: &str, program: &str| beside(Path::new(job), Path::new(program));
        assert_eq!(found("jobs/a.yaml", "a.mod"), Path::new("jobs/a.mod"));
        assert_eq!(found("a.yaml", "a.mod"), Path::new("a.mod"));
        assert_eq!(found("./jobs/a.yaml", "../nc/./a.mod"), Path::new("nc/a.mod"));
        assert_eq!(found("a.yaml", "../../a.mod"), Path::new("../../a.mod"));
        assert_eq!(found("/jobs/a.yaml", "../../a.mod"), Path::new("/a.mod"));
        assert_eq!(found("jobs/a.yaml", "/nc/a.mod"), Path::new("/nc/a.mod"));
    }

    #[test]
    fn an_absolute_path_inside_the_root_becomes_relative() {
        let root = Path::new("/work piece");
        assert_eq!(within(root, Path::new("/work piece/jobs/../a.yaml")), Path::new("a.yaml"));
        assert_eq!(within(root, Path::new("/elsewhere/a.yaml")), Path::new("/elsewhere/a.yaml"));
        assert_eq!(within(root, Path::new("jobs/a.yaml")), Path::new("jobs/a.yaml"));
    }

    #[test]
    fn uris_are_escaped() {
        assert_eq!(uri(Path::new("jobs/my job#1.yaml")), "jobs/my%20job%231.yaml");
        assert_eq!(uri(Path::new("jobs/Tür:a.yaml")), "jobs/T%C3%BCr%3Aa.yaml");
        assert_eq!(uri(Path::new("/a/b%.yaml")), "file:///a/b%25.yaml");
        assert_eq!(uri(Path::new("../a.yaml")), "../a.yaml");
    }
}
