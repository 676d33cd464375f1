//! Long tables of waypoints, one row on each line, read past the YAML parser, which takes its time
//! over every number.
//!
//! The parser is given the text without the rows, but for the first of each table, and the rows are
//! put back behind what it makes of that one. Only rows of the plainest form are taken out, and
//! only if all goes well is the tree used; else the whole text is parsed, so faults are the same.

use std::sync::Arc;

use super::node::{Entry, Kind, Node};
use super::number::number_of;

/// Rows of one list, on lines that follow each other.
pub(super) struct Table {
    /// With their lines in the whole text. Never empty: the first one is left in the text.
    pub(super) rows: Vec<Node>,
}

/// A text without the rows of its tables.
pub(super) struct Shortened {
    pub(super) text: String,
    /// In the order of the text.
    pub(super) tables: Vec<Table>,
}

/// Takes the long tables out of `text`; `None` where there are none.
pub(super) fn shortened(text: &str) -> Option<Shortened> {
    let mut keys = Vec::new();
    let mut short = Shortened { text: String::new(), tables: Vec::new() };
    // Up to where `text` was looked at and dealt with.
    let (mut at, mut copied) = (0, 0);
    let mut run = Run::default();
    for (line, content) in (1..).zip(text.split_inclusive('\n')) {
        let row = row(content, line, &mut keys);
        if row.as_ref().is_none_or(|(indent, _)| *indent != run.indent) {
            run.close(text, at, &mut copied, &mut short);
        }
        at += content.len();
        if let Some((indent, node)) = row {
            if run.rows.is_empty() {
                run = Run { indent, rows_from: at, rows: Vec::new() };
            }
            run.rows.push(node);
        }
    }
    run.close(text, at, &mut copied, &mut short);
    short.text.push_str(&text[copied..]);
    (!short.tables.is_empty()).then_some(short)
}

/// Rows one below the other, at one indentation.
#[derive(Default)]
struct Run {
    indent: usize,
    /// Where the second row begins.
    rows_from: usize,
    rows: Vec<Node>,
}

impl Run {
    /// Takes the rows out of the text, if there are enough; they end at `end`.
    fn close(&mut self, text: &str, end: usize, copied: &mut usize, short: &mut Shortened) {
        let rows = std::mem::take(&mut self.rows);
        // Shorter tables do not pay.
        if rows.len() >= 32 {
            short.text.push_str(&text[*copied..self.rows_from]);
            *copied = end;
            short.tables.push(Table { rows });
        }
    }
}

/// `- [1, 2.5]` or `- {key: [1, 2.5], other: [3]}` with its indentation.
fn row(content: &str, line: u32, keys: &mut Vec<Arc<str>>) -> Option<(usize, Node)> {
    let content = content.strip_suffix('\n').unwrap_or(content);
    let content = content.strip_suffix('\r').unwrap_or(content).trim_end_matches(' ');
    let item = content.trim_start_matches(' ');
    let indent = content.len() - item.len();
    let item = item.strip_prefix("- ")?;
    let (kind, rest) = match item.strip_prefix('{') {
        Some(entries) => mapping(entries, line, keys)?,
        None => numbers(item)?,
    };
    rest.is_empty().then(|| (indent, Node::new(line, kind)))
}

/// A list of numbers, and what stands behind it.
fn numbers(text: &str) -> Option<(Kind, &str)> {
    let (inside, rest) = text.strip_prefix('[')?.split_once(']')?;
    let mut numbers = Vec::with_capacity(1 + inside.bytes().filter(|byte| *byte == b',').count());
    for number in inside.split(',') {
        numbers.push(number_of(number.trim_matches(' '))?);
    }
    Some((Kind::Numbers(numbers.into_boxed_slice()), rest))
}

/// The entries of a mapping of lists of numbers, and what stands behind it.
fn mapping<'t>(mut text: &'t str, line: u32, keys: &mut Vec<Arc<str>>) -> Option<(Kind, &'t str)> {
    let mut entries: Vec<Entry> = Vec::with_capacity(2);
    loop {
        let (key, value) = text.trim_start_matches(' ').split_once(": ")?;
        let key = shared(key, keys)?;
        if entries.iter().any(|entry| entry.key == key) {
            return None;
        }
        let (kind, rest) = numbers(value.trim_start_matches(' '))?;
        entries.push(Entry { key, line, value: Node::new(line, kind) });
        let rest = rest.trim_start_matches(' ');
        match rest.strip_prefix(',') {
            Some(next) => text = next,
            None => return Some((Kind::Mapping(entries), rest.strip_prefix('}')?)),
        }
    }
}

/// A key of small letters, digits and underscores.
fn shared(key: &str, keys: &mut Vec<Arc<str>>) -> Option<Arc<str>> {
    if let Some(known) = keys.iter().find(|known| &***known == key) {
        return Some(Arc::clone(known));
    }
    let plain = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
    if !key.starts_with(|c: char| c.is_ascii_lowercase()) || !key.bytes().all(plain) {
        return None;
    }
    let key: Arc<str> = key.into();
    // Tables have few keys; others are not kept.
    if keys.len() < 8 {
        keys.push(Arc::clone(&key));
    }
    Some(key)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use crate::notes::{Notes, Place};

    use super::super::tree::{parse, parse_whole};
    use super::*;

    /// The tree or the fault, and what was reported on the way.
    fn reported(read: impl Fn(&str, &mut Notes) -> Option<Node>) -> impl Fn(&str) -> String {
        move |text| {
            let mut notes = Notes::about(Place::file(Path::new("f")));
            let tree = read(text, &mut notes);
            format!("{tree:?} {:?}", notes.finish())
        }
    }

    fn lists(count: usize) -> String {
        (0..count).map(|i| format!("    - [{i}, -2.5e1,3 , .5]\n")).collect()
    }

    fn mappings(count: usize) -> String {
        (0..count)
            .map(|i| format!("    - {{xyz_mm: [{i}, 0, 7], rpy_deg: [0, 1e2, {i}]}}\r\n"))
            .collect()
    }

    #[test]
    fn tables_are_taken_out_and_put_back() {
        let (lists, mappings) = (lists(100), mappings(50));
        let text = format!("# top\na:\n  b:\n{lists}  c:\n{mappings}d: 1\n");
        let short = shortened(&text).unwrap();
        assert_eq!(short.text.lines().count(), 7);
        assert_eq!(short.tables.iter().map(|t| t.rows.len()).collect::<Vec<_>>(), [100, 50]);
        assert_eq!(reported(parse)(&text), reported(parse_whole)(&text));
        let mut notes = Notes::about(Place::file(Path::new("f")));
        let tree = parse(&text, &mut notes).unwrap();
        let c = tree.get("a").unwrap().get("c").unwrap();
        assert_eq!((c.items().len(), c.items()[49].line), (50, 154));
        assert_eq!(tree.entry("d").unwrap().line, 155);
    }

    #[test]
    fn where_rows_are_no_rows_the_whole_text_is_read() {
        let rows = lists(40);
        for text in [
            format!("a: |\n{rows}b: 1\n"),
            format!("a: x\n{rows}b: 1\n"),
            format!("a: \"x\n{rows}  y\"\nb: 1\n"),
            format!("a:\n  b: !tag\n{rows}"),
            format!("a:\n  b:\n{rows}  b: 2\nc: 1\nc: 2\n"),
            format!("a:\n  b:\n{rows}    c: 1\n"),
            format!("a:\n  b:\n{rows}    - [1, 2\n"),
            format!("a:\n  b:\n{rows}   - [1, 2]\n{rows}"),
            format!("a:\n  b:\n    - - [0, 0]\n{}", rows.replace("    -", "      -")),
            format!("a:\n  b: [\n{rows}]\n"),
            format!("a:\r  b:\n{rows}"),
            format!("{}{rows}", rows.replace("    -", "-")),
            rows.trim_end().to_owned(),
            format!("---\n{rows}...\n"),
            format!("a:\n{rows}---\nb: 1\n"),
            format!("a:\n{rows}{}{rows}", "    - {x: [1], x: [2]}\n"),
            format!("a:\n{rows}{}", "    - {x: [1], no: [2]}\n".repeat(40)),
        ] {
            assert_eq!(reported(parse)(&text), reported(parse_whole)(&text), "{text}");
        }
    }

    /// Whatever is wrong with a file, wherever: the tree and the faults are those of the parser
    /// alone.
    #[test]
    fn slips_of_the_pen_are_read_as_the_parser_reads_them() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let whole = format!("a:\n  b:\n{}  c:\n{}d: 1\n", lists(40), mappings(40));
        let pieces = [
            "\n", "\r", " ", "  ", "\t", "-", "- ", "[", "]", "{", "}", ",", ":", ": ", "#", " #",
            "\"", "'", "&a ", "*a", "!t ", "|\n", "1", "x", "0x", "~", "é", "? ", "---\n",
        ];
        let mut shortened_read = 0;
        for _ in 0..4000 {
            let mut text = whole.clone();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..=text.len());
                let Some(at) = (at..=text.len()).find(|&at| text.is_char_boundary(at)) else {
                    continue;
                };
                if rng.random_bool(0.3) {
                    let end = (at + rng.random_range(0..4)).min(text.len());
                    if text.is_char_boundary(end) {
                        text.replace_range(at..end, "");
                    }
                } else {
                    text.insert_str(at, pieces[rng.random_range(0..pieces.len())]);
                }
            }
            shortened_read += usize::from(shortened(&text).is_some());
            assert_eq!(reported(parse)(&text), reported(parse_whole)(&text), "{text}");
        }
        assert!(shortened_read > 1000);
    }
}
