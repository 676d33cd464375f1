//! Files → text: bounded in size, UTF-8, without byte-order mark.

use crate::notes::{Code, Note, Place};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The text of a file, without byte-order mark.
pub(crate) fn read_text(path: &Path, largest_bytes: u64) -> Result<String, Note> {
    decode(read_bytes(path, largest_bytes)?)
        .map_err(|(line, what)| Note::error(Code::Syntax, Place::line(path, line), what))
}

/// The bytes of a file, whatever they mean.
pub(crate) fn read_bytes(path: &Path, largest_bytes: u64) -> Result<Vec<u8>, Note> {
    let fault = |what: String| Note::error(Code::Unreadable, Place::file(path), what);
    let too_large = || fault(format!("is larger than {} MiB, the limit", largest_bytes >> 20));
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
    // A pipe or a device has no length, so the reading itself is bounded, too.
    File::open(path)
        .and_then(|file| file.take(largest_bytes + 1).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    if bytes.len() as u64 > largest_bytes {
        return Err(too_large());
    }
    Ok(bytes)
}

/// UTF-8 bytes as text without byte-order mark; otherwise the line of the first bad byte.
pub(crate) fn decode(mut bytes: Vec<u8>) -> Result<String, (usize, String)> {
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

pub(crate) fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_lowercase().chain(chars).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAX_BYTES: u64 = 64 << 20;

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
        File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
        let fault = read_text(&path, MAX_BYTES).unwrap_err();
        assert!(fault.what.contains("larger than 64 MiB"), "{fault}");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "12345");
        assert!(read_text(&path, 4).is_err());
        assert_eq!(read_text(folder.path(), 5).unwrap_err().what, "is a folder, must be a file");
    }
}
