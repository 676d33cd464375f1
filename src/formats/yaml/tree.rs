//! YAML text → a tree in which every value knows its line.

use std::iter::Peekable;
use std::path::Path;
use std::sync::Arc;
use std::vec::IntoIter;

use saphyr_parser::{Event, Parser, ScalarStyle};

use super::node::{Entry, Kind, Node};
use super::number::number_of;
use super::rows::{Shortened, Table, shortened};
use crate::notes::{Code, Notes, Place};

/// Files nest six deep at most; deeper ones are not ours, and would exhaust the stack.
const MAX_DEPTH: usize = 40;

/// Bounds the memory (about 60 bytes a value). A row of numbers on one line counts as one value.
const MAX_VALUES: usize = 6_000_000;

/// Reads the one document of `text`. Faults that leave the rest readable (a key given twice, an
/// alias, a tag) go to `faults`; the first that does not is the error.
pub(crate) fn parse(text: &str, notes: &mut Notes) -> Option<Node> {
    match shortened(text).and_then(parse_shortened) {
        Some(tree) => Some(tree),
        None => parse_whole(text, notes),
    }
}

/// The tree of a text whose tables were taken out of it; `None` where anything is not as it should
/// be.
fn parse_shortened(short: Shortened) -> Option<Node> {
    let mut notes = Notes::about(Place::file(Path::new("")));
    let mut builder = Builder::new(&mut notes, short.tables);
    builder.read(&short.text)?;
    let root = builder.root.take().filter(|root| !root.is_null());
    let all_back = builder.tables.next().is_none();
    root.filter(|_| all_back && notes.errors() == 0)
}

/// [`parse`] by the YAML parser alone.
pub(super) fn parse_whole(text: &str, notes: &mut Notes) -> Option<Node> {
    let mut builder = Builder::new(notes, Vec::new());
    builder.read(text)?;
    match builder.root {
        Some(root) if !root.is_null() => Some(root),
        _ => {
            let what = "is empty, must hold keys and values";
            builder.notes.error(Code::MissingKey, None, what);
            None
        }
    }
}

/// A collection that has begun.
enum Open {
    Sequence { line: u32, items: Vec<Node>, numbers: Vec<f64> },
    Mapping { line: u32, entries: Vec<Entry>, key: Option<(Arc<str>, u32)> },
}

struct Builder<'f> {
    notes: &'f mut Notes,
    open: Vec<Open>,
    root: Option<Node>,
    values: usize,
    /// Rows of mappings repeat their keys: the last few are shared.
    last_key: Option<[Arc<str>; 2]>,
    /// Tables that are not in the text and were not put back yet.
    tables: Peekable<IntoIter<Table>>,
    /// Lines of those that were.
    lines_put_back: usize,
}

impl<'f> Builder<'f> {
    fn new(notes: &'f mut Notes, tables: Vec<Table>) -> Self {
        Self {
            notes,
            open: Vec::new(),
            root: None,
            values: 0,
            last_key: None,
            tables: tables.into_iter().peekable(),
            lines_put_back: 0,
        }
    }

    fn read(&mut self, text: &str) -> Option<()> {
        let mut documents = 0;
        for event in Parser::new_from_str(text) {
            let event = event.map_err(|error| {
                let hint = if error.info().contains("tab") { "; indent with spaces" } else { "" };
                let what = format!("not valid YAML: {}{hint}", error.info());
                self.notes.error(Code::Syntax, error.marker().line().max(1), what);
            });
            let (event, span) = event.ok()?;
            let line = span.start.line() + self.lines_put_back;
            let line = u32::try_from(line).unwrap_or(u32::MAX);
            if matches!(event, Event::DocumentStart(_)) {
                documents += 1;
                if documents > 1 {
                    let what = "a second document starts here, must be one document in a file";
                    self.notes.error(Code::Syntax, line as usize, what);
                    return None;
                }
            }
            self.take(event, line)?;
            if self.values > MAX_VALUES {
                let what = format!("more than {MAX_VALUES} values; split the file");
                self.notes.error(Code::TooLong, line as usize, what);
                return None;
            }
        }
        Some(())
    }

    fn take(&mut self, event: Event<'_>, line: u32) -> Option<()> {
        let tag = match &event {
            Event::Scalar(_, _, _, tag)
            | Event::SequenceStart(_, tag)
            | Event::MappingStart(_, tag) => tag.as_ref(),
            _ => None,
        };
        if let Some(tag) = tag {
            let what = format!("tag '{}{}' is not read; leave it out", tag.handle, tag.suffix);
            self.notes.error(Code::Syntax, line as usize, what);
        }
        match event {
            Event::Scalar(text, style, ..) => self.scalar(&text, style != ScalarStyle::Plain, line),
            Event::Alias(_) => {
                self.notes.error(
                    Code::Syntax,
                    line as usize,
                    "aliases (*name) are not read; write the value out",
                );
                let mut node = Node::new(line, Kind::Scalar { text: "".into(), quoted: false });
                node.faulty = true;
                self.place(node)
            }
            Event::SequenceStart(..) => {
                self.begin(Open::Sequence { line, items: Vec::new(), numbers: Vec::new() }, line)
            }
            Event::MappingStart(..) => {
                self.begin(Open::Mapping { line, entries: Vec::new(), key: None }, line)
            }
            Event::SequenceEnd | Event::MappingEnd => self.end(),
            _ => Some(()),
        }
    }

    fn begin(&mut self, open: Open, line: u32) -> Option<()> {
        if self.expects_key() {
            let what = "a list or mapping is used as a key, must be plain text";
            self.notes.error(Code::Syntax, line as usize, what);
            return None;
        }
        if self.open.len() >= MAX_DEPTH {
            let what = format!("nested more than {MAX_DEPTH} deep");
            self.notes.error(Code::Syntax, line as usize, what);
            return None;
        }
        self.open.push(open);
        Some(())
    }

    fn expects_key(&self) -> bool {
        matches!(self.open.last(), Some(Open::Mapping { key: None, .. }))
    }

    fn scalar(&mut self, text: &str, quoted: bool, line: u32) -> Option<()> {
        if self.expects_key() {
            let shared = self.shared(text);
            if let Some(Open::Mapping { key, .. }) = self.open.last_mut() {
                *key = Some((shared, line));
            }
            return Some(());
        }
        if let Some(Open::Sequence { line: start, items, numbers }) = self.open.last_mut()
            && items.is_empty()
            && *start == line
            && !quoted
            && let Some(number) = number_of(text)
        {
            numbers.push(number);
            return Some(());
        }
        self.place(Node::new(line, Kind::Scalar { text: text.into(), quoted }))
    }

    fn shared(&mut self, text: &str) -> Arc<str> {
        if let Some(found) = self.last_key.iter().flatten().find(|key| &***key == text) {
            return Arc::clone(found);
        }
        let key: Arc<str> = text.into();
        let before = self.last_key.take().map_or_else(|| Arc::clone(&key), |[newest, _]| newest);
        self.last_key = Some([Arc::clone(&key), before]);
        key
    }

    /// Puts a finished value where it belongs.
    fn place(&mut self, node: Node) -> Option<()> {
        self.values += 1;
        match self.open.last_mut() {
            None => self.root = Some(node),
            Some(Open::Sequence { line, items, numbers }) => {
                spill(*line, items, numbers);
                items.push(node);
            }
            Some(Open::Mapping { entries, key, .. }) => match key.take() {
                Some((key, line)) => entries.push(Entry { key, line, value: node }),
                None => {
                    let what = "an alias is used as a key, must be plain text";
                    self.notes.error(Code::Syntax, node.line as usize, what);
                    return None;
                }
            },
        }
        Some(())
    }

    fn end(&mut self) -> Option<()> {
        match self.open.pop() {
            Some(Open::Sequence { line, items, numbers }) => {
                let kind = if numbers.is_empty() {
                    Kind::Sequence(items)
                } else {
                    Kind::Numbers(numbers.into_boxed_slice())
                };
                self.place(Node::new(line, kind))?;
            }
            Some(Open::Mapping { line, entries, .. }) => {
                let entries = self.without_repeats(entries);
                self.place(Node::new(line, Kind::Mapping(entries)))?;
            }
            None => {}
        }
        self.put_back();
        Some(())
    }

    /// Puts the rows of a table behind its first one, if that is what was placed last.
    fn put_back(&mut self) {
        let Some(Open::Sequence { items, .. }) = self.open.last_mut() else { return };
        let is_first = |table: &Table| items.last().is_some_and(|row| *row == table.rows[0]);
        let Some(Table { rows }) = self.tables.next_if(is_first) else { return };
        self.lines_put_back += rows.len() - 1;
        items.reserve(rows.len() - 1);
        for row in rows.into_iter().skip(1) {
            self.values += match &row.kind {
                Kind::Mapping(entries) => 1 + entries.len(),
                _ => 1,
            };
            items.push(row);
        }
    }

    /// Tells of keys given twice, and keeps the first.
    fn without_repeats(&mut self, entries: Vec<Entry>) -> Vec<Entry> {
        let mut order: Vec<usize> = (0..entries.len()).collect();
        order.sort_by(|&a, &b| entries[a].key.cmp(&entries[b].key).then(a.cmp(&b)));
        let mut repeated = vec![false; entries.len()];
        for same in order.chunk_by(|&a, &b| entries[a].key == entries[b].key) {
            for &again in &same[1..] {
                let (first, entry) = (&entries[same[0]], &entries[again]);
                let what =
                    format!("key '{}' is given twice; first at line {}", entry.key, first.line);
                self.notes.error(Code::Conflict, entry.line as usize, what);
                repeated[again] = true;
            }
        }
        let kept = entries.into_iter().enumerate().filter(|(i, _)| !repeated[*i]);
        kept.map(|(_, entry)| entry).collect()
    }
}

/// A list that began with numbers and goes on with something else is an ordinary one.
fn spill(line: u32, items: &mut Vec<Node>, numbers: &mut Vec<f64>) {
    items.extend(numbers.drain(..).map(|number| {
        Node::new(line, Kind::Scalar { text: number.to_string().into(), quoted: false })
    }));
}

#[cfg(test)]
mod tests {
    use super::super::node::Step;
    use super::*;
    use crate::notes::Note;

    fn read(text: &str) -> (Option<Node>, Vec<String>) {
        let mut notes = Notes::about(Place::file(Path::new("f")));
        let tree = parse(text, &mut notes);
        (tree, notes.finish().0.iter().map(Note::to_string).collect())
    }

    #[test]
    fn lines_are_known_at_every_depth() {
        let (tree, notes) =
            read("a: 1\r\nb:\r\n  - c: [1, 2]\r\n    d: x\r\n  - e: {f: 1,\r\n      g: 2}\r\n");
        let tree = tree.unwrap();
        assert!(notes.is_empty());
        use Step::{Index, Key};
        assert_eq!(tree.line_at(&[Key("a")]), 1);
        assert_eq!(tree.line_at(&[Key("b"), Index(0)]), 3);
        assert_eq!(tree.line_at(&[Key("b"), Index(0), Key("d")]), 4);
        assert_eq!(tree.line_at(&[Key("b"), Index(1), Key("e"), Key("g")]), 6);
        assert_eq!(tree.line_at(&[Key("b"), Index(1), Key("absent"), Key("g")]), 5);
        let numbers = tree.get("b").unwrap().items()[0].get("c").unwrap();
        assert_eq!(numbers.kind, Kind::Numbers([1.0, 2.0].into()));
    }

    #[test]
    fn a_list_that_is_not_all_numbers_keeps_every_item() {
        let (tree, _) = read("[1, -2.5, x]");
        let texts: Vec<String> = tree
            .unwrap()
            .items()
            .iter()
            .map(|item| match &item.kind {
                Kind::Scalar { text, .. } => text.to_string(),
                other => format!("{other:?}"),
            })
            .collect();
        assert_eq!(texts, ["1", "-2.5", "x"]);
    }

    #[test]
    fn what_yaml_allows_and_we_do_not_is_told_with_its_line() {
        for (text, expected) in [
            ("a: 1\nb: 2\na: 3\n", "f:3: key 'a' is given twice; first at line 1"),
            ("a: &x 1\nb: *x\n", "f:2: aliases (*name) are not read; write the value out"),
            ("a: 1\nb: !size 2\n", "f:2: tag '!size' is not read; leave it out"),
        ] {
            let (tree, notes) = read(text);
            assert!(tree.is_some(), "{text:?}");
            assert_eq!(notes, [expected], "{text:?}");
        }
        for (text, expected) in [
            ("", "f: is empty, must hold keys and values"),
            ("# nothing\n", "f: is empty, must hold keys and values"),
            ("a: 1\n---\nb: 1\n", "f:2: a second document starts here"),
            ("a: 1\n\tb: 2\n", "f:1: not valid YAML"),
            ("a: [1, 2\nb: 3\n", "f:2: not valid YAML"),
            ("? [a]\n: 1\n", "f:1: a list or mapping is used as a key"),
        ] {
            let (tree, notes) = read(text);
            assert!(tree.is_none() && notes[0].starts_with(expected), "{text:?}: {notes:?}");
        }
        for deep in ["[".repeat(100_000), "- ".repeat(100_000), "{a: ".repeat(100_000)] {
            assert!(read(&deep).0.is_none());
        }
    }
}
