//! Tables as text: comma-separated, a header, `#` for comment lines, and the true line of every
//! row.
//!
//! The csv crate counts comment and blank lines to the row after them, so rows are separated here,
//! and the crate takes the cells apart where a row has quotes. A quoted cell may not run over
//! lines.

use crate::notes::{Code, Note, Place};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// Rows longer than this are no rows.
pub(crate) const MAX_ROW_BYTES: usize = 1 << 20;

/// A table that streams in.
#[derive(Debug)]
pub(crate) struct Table<R> {
    file: PathBuf,
    reader: BufReader<R>,
    /// Line of the row that was read last, counted from 1.
    line: usize,
    bytes: Vec<u8>,
    /// The line that the piece read last has begun but not ended.
    begun: Vec<u8>,
    header: Vec<String>,
}

impl<R: Read> Table<R> {
    /// Opens a table and reads its header; `file` stands for it in faults.
    pub(crate) fn open(file: &Path, reader: R) -> Result<Self, Note> {
        let reader = BufReader::new(reader);
        let mut table = Self {
            file: file.to_owned(),
            reader,
            line: 0,
            bytes: Vec::new(),
            begun: Vec::new(),
            header: Vec::new(),
        };
        let mut header = Vec::new();
        if !table.row(&mut header)? {
            let what = "is empty, must begin with a header";
            return Err(Note::error(Code::TooLittleData, Place::file(&table.file), what));
        }
        if header.len() == 1 && header[0].contains([';', '\t']) {
            let mark = if header[0].contains(';') { "semicolons" } else { "tabs" };
            let what = format!(
                "must be separated by commas, not {mark} (and numbers have decimal points)"
            );
            return Err(table.error(Code::Syntax, what));
        }
        table.header = header;
        Ok(table)
    }

    /// Titles of the columns.
    pub(crate) fn header(&self) -> &[String] {
        &self.header
    }

    /// The line of the row that was read last.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// Reads the next row's cells, trimmed; `false` at the end.
    pub(crate) fn row(&mut self, cells: &mut Vec<String>) -> Result<bool, Note> {
        loop {
            self.bytes.clear();
            self.line += 1;
            let most = MAX_ROW_BYTES as u64 + 1;
            let read = self.reader.by_ref().take(most).read_until(b'\n', &mut self.bytes);
            match read {
                Ok(0) => return Ok(false),
                Ok(_) => {}
                Err(error) => {
                    return Err(self.error(Code::Unreadable, format!("cannot be read: {error}")));
                }
            }
            let bytes = match (self.line, self.bytes.as_slice()) {
                (1, [0xEF, 0xBB, 0xBF, rest @ ..]) => rest,
                (_, bytes) => bytes,
            };
            let of_line = bytes.strip_suffix(b"\n").unwrap_or(bytes);
            if memchr::memchr(b'\r', of_line).is_some_and(|at| at + 1 < of_line.len()) {
                let what = "its lines end with a carriage return alone; save it with line feeds \
                            (LF or CRLF)";
                return Err(self.error(Code::Syntax, what));
            }
            match cells_of(bytes, cells) {
                Ok(true) => match beyond(&self.header, cells) {
                    Some(what) if !self.header.is_empty() => {
                        return Err(self.error(Code::Syntax, what));
                    }
                    _ => return Ok(true),
                },
                Ok(false) => {}
                Err(what) => return Err(self.error(Code::Syntax, what)),
            }
        }
    }

    /// Takes the next rows as they stand into `bytes`, in place of what it holds: whole lines,
    /// about `length` bytes of them; nothing at the end. The same table gives the same pieces
    /// however it arrives.
    pub(crate) fn lines(&mut self, length: usize, bytes: &mut Vec<u8>) -> Result<(), Note> {
        bytes.clear();
        bytes.append(&mut self.begun);
        let mut ended = false;
        loop {
            if bytes.len() >= length {
                let within = memchr::memrchr(b'\n', &bytes[..length]);
                let behind = || memchr::memchr(b'\n', &bytes[length..]).map(|at| length + at);
                if let Some(end) = within.or_else(behind) {
                    self.begun.extend_from_slice(&bytes[end + 1..]);
                    bytes.truncate(end + 1);
                    return Ok(());
                }
                if bytes.len() > MAX_ROW_BYTES {
                    // Not a row: the decoder will say so, and will not ask for more.
                    return Ok(());
                }
            }
            if ended {
                return Ok(());
            }
            let wanted = length.saturating_sub(bytes.len()).max(4096) as u64;
            let read = self.reader.by_ref().take(wanted).read_to_end(bytes);
            let read = read.map_err(|error| {
                let what = format!("cannot be read: {error}");
                Note::error(Code::Unreadable, Place::file(&self.file), what)
            })?;
            ended = (read as u64) < wanted;
        }
    }

    /// An error in the row that was read last.
    pub(crate) fn error(&self, code: Code, what: impl Into<String>) -> Note {
        Note::error(code, Place::line(&self.file, self.line), what)
    }

    /// The finite number in a column of a row.
    pub(crate) fn number(&self, cells: &[String], column: usize) -> Result<f64, Note> {
        number(&self.header, cells, column).map_err(|what| self.error(Code::Value, what))
    }
}

/// The finite number in a column of a row.
pub(crate) fn number(header: &[String], cells: &[String], column: usize) -> Result<f64, String> {
    let text = cells.get(column).map_or("", String::as_str);
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => {
            let title = header.get(column).map_or("", String::as_str);
            Err(format!("{title} is {}, must be a finite number", shown(text)))
        }
    }
}

/// What to say of a row that goes on behind the last column; blank cells there are nothing.
pub(crate) fn beyond(header: &[String], cells: &[String]) -> Option<String> {
    let used = cells.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
    (used > header.len()).then(|| {
        format!(
            "has {used} cells, the header has {}; cells are separated by commas, numbers have \
             decimal points",
            header.len()
        )
    })
}

/// The cells of a line, trimmed; `false` if it holds none, being blank or a comment.
pub(crate) fn cells_of(line: &[u8], cells: &mut Vec<String>) -> Result<bool, &'static str> {
    if line.len() > MAX_ROW_BYTES {
        return Err("is longer than 1 MiB, must be one row of a table");
    }
    let Ok(text) = std::str::from_utf8(line) else {
        return Err("is not UTF-8; save the file as UTF-8");
    };
    let text = text.trim();
    if text.is_empty() || text.starts_with('#') {
        return Ok(false);
    }
    if split(text, cells) { Ok(true) } else { Err("has a quoted cell that does not end") }
}

/// Takes a row apart, using the strings again that are there; `false` if a quote does not end.
fn split(row: &str, cells: &mut Vec<String>) -> bool {
    let mut count = 0;
    let mut push = |cell: &str| {
        match cells.get_mut(count) {
            Some(old) => {
                old.clear();
                old.push_str(cell);
            }
            None => cells.push(cell.to_owned()),
        }
        count += 1;
    };
    if row.contains('"') {
        if !row.matches('"').count().is_multiple_of(2) {
            return false;
        }
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .trim(csv::Trim::All)
            .from_reader(row.as_bytes());
        if let Some(Ok(record)) = reader.records().next() {
            record.iter().for_each(push);
        }
    } else {
        row.split(',').map(str::trim).for_each(&mut push);
    }
    cells.truncate(count);
    true
}

/// A cell as a message shows it.
fn shown(cell: &str) -> String {
    if cell.is_empty() {
        return "empty".to_owned();
    }
    let short: String = cell.chars().take(40).collect();
    format!("'{}'", short.escape_debug())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_know_their_line_past_comments_and_blank_lines() {
        let text = "\u{FEFF}# a\r\n\r\na,\"b,c\" ,d\r\n1,,3\r\n  # c\n\n4";
        let mut table = Table::open(Path::new("t"), text.as_bytes()).unwrap();
        assert_eq!(table.header(), ["a", "b,c", "d"]);
        let mut cells = Vec::new();
        assert!(table.row(&mut cells).unwrap());
        assert_eq!((table.line(), &cells[..]), (4, &["1", "", "3"].map(String::from)[..]));
        assert!(table.row(&mut cells).unwrap());
        assert_eq!((table.line(), &cells[..]), (7, &["4".to_owned()][..]));
        assert!(!table.row(&mut cells).unwrap());
    }

    #[test]
    fn other_separators_are_named() {
        for (text, mark) in [("a;b\n1;2\n", "semicolons"), ("a\tb\n1\t2\n", "tabs")] {
            let fault = Table::open(Path::new("t"), text.as_bytes()).unwrap_err().to_string();
            assert!(
                fault.starts_with(&format!("t:1: must be separated by commas, not {mark}")),
                "{fault}"
            );
        }
        assert!(Table::open(Path::new("t"), &b"a\n1\n"[..]).is_ok());
    }

    #[test]
    fn a_row_without_end_is_refused_in_bounded_memory() {
        let endless = std::io::repeat(b'1');
        let fault = Table::open(Path::new("t"), endless).unwrap_err();
        assert_eq!(fault.to_string(), "t:1: is longer than 1 MiB, must be one row of a table");
        assert!(Table::open(Path::new("t"), &b"\"a,b\n"[..]).unwrap_err().what.contains("quoted"));
    }

    /// Whole lines, none lost, whatever the length asked for and however the file ends.
    #[test]
    fn pieces_of_any_length_are_the_same_table() {
        for end in ["", "\n"] {
            let rows: Vec<String> =
                (0..3000).map(|i| format!("{i},{}", "7".repeat(i % 40))).collect();
            let rows = rows.join("\n") + end;
            let text = format!("a,b\n{rows}");
            for length in [1, 7, 128, 5000, 1 << 20] {
                let mut table = Table::open(Path::new("t"), text.as_bytes()).unwrap();
                let (mut all, mut piece, mut longest) = (Vec::new(), Vec::new(), 0);
                while {
                    table.lines(length, &mut piece).unwrap();
                    !piece.is_empty()
                } {
                    assert!(all.is_empty() || all.ends_with(b"\n"));
                    longest = longest.max(piece.len());
                    all.extend_from_slice(&piece);
                }
                assert_eq!(String::from_utf8(all).unwrap(), rows, "{length}");
                assert!(longest <= length.max(60), "{length}: {longest}");
            }
        }
    }
}
