//! Bytes of a program → text whose lines end in `\n`, numbered as an editor numbers them.

use crate::notes::{Code, Note, Place};

const BYTE_ORDER_MARK: [u8; 3] = [0xEF, 0xBB, 0xBF];

/// A text, and where it stands in the file.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Decoded {
    pub(super) text: String,
    /// Bytes before the text.
    skipped: usize,
    /// One byte of the file is one character.
    is_latin_1: bool,
}

impl Decoded {
    /// Bytes of the file for places of the text, which are to ascend.
    pub(super) fn in_file(&self, places: &[usize]) -> Vec<usize> {
        let (mut at, mut bytes) = (0, self.skipped);
        let in_file = places.iter().map(|&place| {
            let between = self.text.get(at..place).unwrap_or("");
            bytes += if self.is_latin_1 { between.chars().count() } else { between.len() };
            at = place;
            bytes
        });
        in_file.collect()
    }
}

/// UTF-8 where the bytes are valid as such, Latin-1 (one byte, one character) where they are not.
/// A text without any `\n` has its lines ended by `\r` alone.
pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, Note> {
    let text = bytes.strip_prefix(&BYTE_ORDER_MARK).unwrap_or(bytes);
    let skipped = bytes.len() - text.len();
    if let Some(at) = memchr::memchr(0, text) {
        let line = 1 + memchr::memchr_iter(b'\n', &text[..at]).count();
        let place = Place { line: Some(line), ..Place::default() };
        let what = "not a text (a zero byte); save the program as UTF-8 or Latin-1";
        return Err(Note::error(Code::Unreadable, place, what));
    }
    let (text, is_latin_1) = match std::str::from_utf8(text) {
        Ok(text) => (text.to_owned(), false),
        Err(_) => (text.iter().map(|&byte| char::from(byte)).collect(), true),
    };
    let text = if text.contains('\n') { text } else { text.replace('\r', "\n") };
    Ok(Decoded { text, skipped, is_latin_1 })
}

#[cfg(test)]
mod tests {
    use super::decode;

    #[test]
    fn reads_latin_1_utf_8_and_old_line_ends() {
        let decode = |bytes: &[u8]| decode(bytes).map(|decoded| decoded.text);
        assert_eq!(decode(b"fr\xE4sen"), Ok("fr\u{e4}sen".to_owned()));
        assert_eq!(decode("\u{feff}fr\u{e4}sen".as_bytes()), Ok("fr\u{e4}sen".to_owned()));
        assert_eq!(decode(b"a\rb"), Ok("a\nb".to_owned()));
        assert_eq!(decode(b"a\r\nb"), Ok("a\r\nb".to_owned()));
        assert_eq!(decode(b"a\nb\0").map_err(|note| note.place.line), Err(Some(2)));
    }

    #[test]
    fn places_of_the_text_are_places_of_the_file() {
        let places = |bytes: &[u8]| {
            let decoded = decode(bytes).unwrap();
            let all: Vec<usize> = decoded.text.char_indices().map(|(at, _)| at).collect();
            decoded.in_file(&all)
        };
        assert_eq!(places(b"a\xE4b"), [0, 1, 2]);
        assert_eq!(places("\u{feff}a\u{e4}b".as_bytes()), [3, 4, 6]);
    }
}
