//! Files → text: bounded in size, UTF-8, without byte-order mark.

use crate::notes::{Code, Note, Notes, Place};
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Largest job that is read: one of a million waypoints has about 60 MB.
pub(super) const LARGEST_JOB_BYTES: u64 = 64 << 20;

/// Largest robot.yaml that is read: real ones have a few kB.
pub(super) const LARGEST_ROBOT_BYTES: u64 = 1 << 20;

/// Largest URDF that is read: meshes lie in files of their own, so real ones stay below 1 MB.
pub(super) const LARGEST_URDF_BYTES: u64 = 4 << 20;

/// Largest table of load tests that is read.
pub(super) const LARGEST_TABLE_BYTES: u64 = 64 << 20;

const BYTES_PER_MIB: u64 = 1 << 20;

/// Largest robot or CAM program that is read.
pub(super) const LARGEST_PROGRAM_BYTES: u64 = 64 << 20;

/// The text of a file, without byte-order mark.
pub(super) fn read_text(path: &Path, largest_bytes: u64) -> Result<String, Note> {
    decode(read_bytes(path, largest_bytes)?)
        .map_err(|(line, what)| Note::error(Code::Syntax, Place::line(path, line), what))
}

/// The bytes of a file, whatever they mean.
pub(super) fn read_bytes(path: &Path, largest_bytes: u64) -> Result<Vec<u8>, Note> {
    let fault = |what: String| Note::error(Code::Unreadable, Place::file(path), what);
    let too_large = || {
        fault(format!(
            "is larger than {} MiB, which is the most that is read",
            largest_bytes / BYTES_PER_MIB
        ))
    };
    let unreadable = |error: std::io::Error| {
        let what = match error.kind() {
            std::io::ErrorKind::NotFound => "no such file".to_owned(),
            _ => format!("cannot be read: {}", lower_first(&error.to_string())),
        };
        fault(what)
    };
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(fault("is a folder, must be a file".to_owned()));
    }
    if metadata.len() > largest_bytes {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    // A pipe or a device tells no length, so the reading itself is bounded, too.
    File::open(path)
        .and_then(|file| file.take(largest_bytes + 1).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    if bytes.len() as u64 > largest_bytes {
        return Err(too_large());
    }
    Ok(bytes)
}

/// UTF-8 bytes as text without byte-order mark; otherwise the line of the first bad byte.
fn decode(mut bytes: Vec<u8>) -> Result<String, (usize, String)> {
    if bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF]) {
        return Err((1, "is UTF-16, must be UTF-8".to_owned()));
    }
    if bytes.starts_with(&[0xEF, 0xBB, 0xBF]) {
        bytes.drain(..3);
    }
    if let Some(at) = bytes.iter().position(|&byte| byte == 0) {
        let what = "holds a NUL byte, which no text does; is this the right file?";
        return Err((line_at(&bytes, at), what.to_owned()));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let byte = error.as_bytes()[at];
        (
            line_at(error.as_bytes(), at),
            format!("byte 0x{byte:02X} is not UTF-8; save the file as UTF-8"),
        )
    })
}

/// The line of the byte at `at`, counted from 1.
fn line_at(bytes: &[u8], at: usize) -> usize {
    1 + bytes[..at].iter().filter(|&&byte| byte == b'\n').count()
}

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_lowercase().chain(chars).collect())
}

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
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
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
    fn decoding_drops_the_mark_and_tells_the_line_of_a_bad_byte() {
        assert_eq!(decode(b"\xEF\xBB\xBFa: 1".to_vec()).unwrap(), "a: 1");
        let (line, what) = decode(b"a: 1\nb: \xFF\n".to_vec()).unwrap_err();
        assert_eq!((line, what.contains("0xFF")), (2, true));
        assert!(decode(b"\xFF\xFEa\0".to_vec()).unwrap_err().1.contains("UTF-16"));
    }

    #[test]
    fn a_file_above_the_cap_is_refused_before_it_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("big");
        File::create(&path).unwrap().set_len(LARGEST_JOB_BYTES + 1).unwrap();
        let fault = read_text(&path, LARGEST_JOB_BYTES).unwrap_err();
        assert!(fault.what.contains("larger than 64 MiB"), "{fault}");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "12345");
        assert!(read_text(&path, 4).is_err());
        assert_eq!(read_text(folder.path(), 5).unwrap_err().what, "is a folder, must be a file");
    }

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
