//! Bytes of a program → text whose lines end in `\n`, numbered as an editor numbers them.

use crate::notes::{Code, Note, Place};

const BYTE_ORDER_MARK: [u8; 3] = [0xEF, 0xBB, 0xBF];

/// UTF-8 where the bytes are valid as such, Latin-1 (one byte, one character) where they are not.
/// A text without any `\n` has its lines ended by `\r` alone.
pub(super) fn decode(bytes: &[u8]) -> Result<String, Note> {
    let bytes = bytes.strip_prefix(&BYTE_ORDER_MARK).unwrap_or(bytes);
    if let Some(at) = bytes.iter().position(|&byte| byte == 0) {
        let line = 1 + bytes.iter().take(at).filter(|&&byte| byte == b'\n').count();
        let place = Place { line: Some(line), ..Place::default() };
        let what = "not a text (a zero byte); save the program as UTF-8 or Latin-1";
        return Err(Note::error(Code::Unreadable, place, what));
    }
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    };
    Ok(if text.contains('\n') { text } else { text.replace('\r', "\n") })
}

#[cfg(test)]
mod tests {
    use super::decode;

    #[test]
    fn reads_latin_1_utf_8_and_old_line_ends() {
        assert_eq!(decode(b"fr\xE4sen"), Ok("fr\u{e4}sen".to_owned()));
        assert_eq!(decode("\u{feff}fr\u{e4}sen".as_bytes()), Ok("fr\u{e4}sen".to_owned()));
        assert_eq!(decode(b"a\rb"), Ok("a\nb".to_owned()));
        assert_eq!(decode(b"a\r\nb"), Ok("a\r\nb".to_owned()));
        assert_eq!(decode(b"a\nb\0").map_err(|note| note.place.line), Err(Some(2)));
    }
}
