//! Edits of YAML that keep every other byte: comments, order, line ends.
//!
//! The parser says where each entry stands; what changes is cut out of the text and written anew.

use std::ops::Range;

use saphyr_parser::{Event, Parser};

use super::node::Step;

/// An entry of a mapping. Ranges count characters of the text.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    /// The key.
    pub(crate) key: Range<usize>,
    /// Characters before the key on its line.
    pub(crate) column: usize,
    /// The value.
    pub(crate) value: Range<usize>,
    /// The value, if it is a scalar.
    pub(crate) text: String,
    /// Whether it stands within braces or brackets.
    pub(crate) in_braces: bool,
}

impl Entry {
    /// From the key to the end of the value.
    pub(crate) fn whole(&self) -> Range<usize> {
        self.key.start..self.value.end
    }
}

/// A collection that has begun.
struct Open {
    is_mapping: bool,
    in_braces: bool,
    /// Key (text, place, column) that waits for its value, or that the finished value had.
    key: Option<(String, Range<usize>, usize)>,
    awaits_value: bool,
    index: usize,
    start: usize,
}

/// Shows `visit` every entry of every mapping with its path from the root; `None` if the text is
/// not YAML.
pub(crate) fn entries(
    text: &str,
    mut visit: impl FnMut(&[Step<'_>], &dyn Fn() -> Entry),
) -> Option<()> {
    let mut open: Vec<Open> = Vec::new();
    let mut last_end = 0;
    // Places count characters.
    let wide: Vec<char> = if text.is_ascii() { Vec::new() } else { text.chars().collect() };
    let char_at = |index: usize| {
        if wide.is_empty() {
            text.as_bytes().get(index).map(|&byte| char::from(byte))
        } else {
            wide.get(index).copied()
        }
    };
    for event in Parser::new_from_str(text) {
        let (event, span) = event.ok()?;
        let (start, end) = (span.start.index(), span.end.index());
        match event {
            Event::Scalar(value, ..) => {
                last_end = end;
                if let Some(top) = open.last_mut().filter(|o| o.is_mapping && !o.awaits_value) {
                    top.key = Some((value.into_owned(), start..end, span.start.col()));
                    top.awaits_value = true;
                } else {
                    // An empty value stands behind the colon.
                    let start = if end > start { start } else { behind_colon(start, char_at) };
                    show(&mut visit, &open, start..end.max(start), &value);
                    value_done(&mut open);
                }
            }
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                let is_mapping = matches!(event, Event::MappingStart(..));
                // In braces or brackets the start is a token of its own.
                let in_braces =
                    char_at(start) == Some(if is_mapping { '{' } else { '[' }) && end > start;
                let top =
                    Open { is_mapping, in_braces, key: None, awaits_value: false, index: 0, start };
                open.push(top);
            }
            Event::SequenceEnd | Event::MappingEnd => {
                if end > start {
                    last_end = end;
                }
                let ended = open.pop()?;
                show(&mut visit, &open, ended.start..last_end, "");
                value_done(&mut open);
            }
            _ => {}
        }
    }
    Some(())
}

/// Where the colon ends that stands at `at` or after blanks behind it; else `at`.
fn behind_colon(at: usize, char_at: impl Fn(usize) -> Option<char>) -> usize {
    let colon = (at..).find(|&index| char_at(index) != Some(' ')).unwrap_or(at);
    if char_at(colon) == Some(':') { colon + 1 } else { at }
}

fn value_done(open: &mut [Open]) {
    if let Some(top) = open.last_mut() {
        top.awaits_value = false;
        top.index += 1;
    }
}

/// Shows a finished value if it is that of a key.
fn show(
    visit: &mut impl FnMut(&[Step<'_>], &dyn Fn() -> Entry),
    open: &[Open],
    value: Range<usize>,
    text: &str,
) {
    let Some(Open { is_mapping: true, key: Some((_, key, column)), .. }) = open.last() else {
        return;
    };
    let path: Vec<Step<'_>> = open.iter().map(step).collect();
    visit(&path, &|| Entry {
        key: key.clone(),
        column: *column,
        value: value.clone(),
        text: text.to_owned(),
        in_braces: open.iter().any(|open| open.in_braces),
    });
}

/// The step from a collection to the value in it that is being read.
fn step(open: &Open) -> Step<'_> {
    match open {
        Open { is_mapping: true, key: Some((key, ..)), .. } => Step::Key(key),
        Open { index, .. } => Step::Index(*index),
    }
}

/// A text and what changes in it.
pub(crate) struct Splice<'t> {
    text: &'t str,
    changes: Vec<(Range<usize>, String)>,
}

impl<'t> Splice<'t> {
    pub(crate) fn of(text: &'t str) -> Self {
        Self { text, changes: Vec::new() }
    }

    /// How lines of the text end.
    pub(crate) fn line_end(&self) -> &'static str {
        if self.text.contains("\r\n") { "\r\n" } else { "\n" }
    }

    /// What stands in a range.
    pub(crate) fn slice(&self, range: Range<usize>) -> String {
        self.text.chars().skip(range.start).take(range.len()).collect()
    }

    /// Whether the value of an entry is null.
    pub(crate) fn is_null(&self, entry: &Entry) -> bool {
        let value = self.slice(entry.value.clone());
        matches!(value.trim(), "" | "~" | "null" | "Null" | "NULL")
    }

    /// What stands between an entry and the next one of its mapping.
    pub(crate) fn between(&self, entry: &Entry) -> String {
        match entry.in_braces {
            true => ", ".to_owned(),
            false => format!("{}{}", self.line_end(), " ".repeat(entry.column)),
        }
    }

    /// Text in the place of a value: in double quotes if that is, as in JSON.
    pub(crate) fn text_like(&self, value: &Range<usize>, text: &str) -> String {
        match self.slice(value.clone()).starts_with('"') {
            true => format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"")),
            false => quoted(text),
        }
    }

    /// Puts `new` in the place of a range; white space at its end stays, as a block scalar ends
    /// with its line.
    pub(crate) fn replace(&mut self, range: Range<usize>, mut new: String) {
        let old = self.slice(range.clone());
        if range.is_empty() && self.slice(range.start.saturating_sub(1)..range.start) == ":" {
            new.insert(0, ' ');
        }
        let blank = old.chars().rev().take_while(|c| c.is_whitespace()).count();
        let end = range.end - blank.min(range.len());
        self.changes.push((range.start..end, new));
    }

    /// Puts lines in the place of a whole entry in a block: key and value, the lines after the
    /// first indented as they are to stand. Comments that stood inside the entry come before it.
    pub(crate) fn replace_entry(&mut self, entry: &Entry, lines: &str) {
        let old = self.slice(entry.whole());
        let (end, indent) = (self.line_end(), " ".repeat(entry.column));
        let mut new: String =
            comments(&old).iter().map(|comment| format!("{comment}{end}{indent}")).collect();
        new.push_str(&lines.trim_end().replace('\n', end));
        self.replace(entry.whole(), new);
    }

    /// Adds lines at the end of the text.
    pub(crate) fn append(&mut self, lines: &str) {
        let (end, length) = (self.line_end(), self.text.chars().count());
        let first = if self.text.is_empty() || self.text.ends_with('\n') { "" } else { end };
        self.changes.push((length..length, format!("{first}{}", lines.replace('\n', end))));
    }

    /// The text with all changes, which must not overlap.
    pub(crate) fn finish(mut self) -> String {
        self.changes.sort_by_key(|(range, _)| range.start);
        let mut out = String::with_capacity(self.text.len());
        let mut chars = self.text.chars();
        let mut at = 0;
        for (range, new) in self.changes {
            out.extend(chars.by_ref().take(range.start.saturating_sub(at)));
            out.push_str(&new);
            at = at.max(range.start);
            chars.by_ref().take(range.end.saturating_sub(at)).for_each(drop);
            at = at.max(range.end);
        }
        out.extend(chars);
        out
    }
}

/// Comments within an entry: `#` after white space and outside quotes and block scalars, to the end
/// of the line.
fn comments(old: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut block_indent = None;
    for line in old.lines() {
        let content = line.trim_start();
        let indent = line.len() - content.len();
        if block_indent.is_some_and(|block| content.is_empty() || indent > block) {
            continue;
        }
        let at = comment_start(line).unwrap_or(line.len());
        let (value, comment) = line.split_at(at);
        let value =
            value.trim_end().trim_end_matches(|c: char| c.is_ascii_digit() || "+-".contains(c));
        block_indent = value.ends_with(['|', '>']).then_some(indent);
        found.extend(Some(comment.trim_end()).filter(|comment| !comment.is_empty()));
    }
    found
}

/// Where the comment of a line starts.
fn comment_start(line: &str) -> Option<usize> {
    let (mut quote, mut before) = (None, ' ');
    for (at, c) in line.char_indices() {
        match (quote, c) {
            (None, '#') if before.is_whitespace() => return Some(at),
            (None, '"' | '\'') if before.is_whitespace() || "[{,".contains(before) => {
                quote = Some(c)
            }
            (Some(open), c) if c == open => quote = None,
            _ => {}
        }
        before = c;
    }
    None
}

/// A scalar that is text whatever it holds: plain where that is beyond doubt, else in quotes.
pub(crate) fn quoted(name: &str) -> String {
    let begins = name.starts_with(|c: char| c.is_ascii_alphabetic())
        || ["/", "./", "../"].iter().any(|start| name.starts_with(start));
    let plain = begins
        && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-./".contains(c))
        && !matches!(
            name.to_ascii_lowercase().as_str(),
            "true" | "false" | "null" | "yes" | "no" | "on" | "off" | "y" | "n"
        );
    if plain {
        name.to_owned()
    } else if name.contains(char::is_control) {
        // A string of JSON is one of YAML.
        serde_json::Value::from(name).to_string()
    } else {
        format!("'{}'", name.replace('\'', "''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_yaml_reads_as_something_else_are_quoted() {
        for name in ["True", "null", "Yes", "n", ".5", ".inf", "1e3", "a b", "x: y", "", "12"] {
            assert!(quoted(name).starts_with('\''), "{name}");
        }
        for name in ["link_1", "../a-b/c.urdf", "./a", "/abs/a.urdf"] {
            assert_eq!(quoted(name), name);
        }
    }

    #[test]
    fn comments_are_told_from_text() {
        let old = "a: it's mine # one\n# two\nb: 'x # y' # three\nc: |\n  # text\n  more # \
            text\nd: >-2 # four\n   # text\ne: x#y";
        assert_eq!(comments(old), ["# one", "# two", "# three", "# four"]);
    }

    #[test]
    fn empty_values_are_filled_behind_their_colon() {
        let text = "a:\n# of b\nb : # none\nc:\n";
        let mut splice = Splice::of(text);
        entries(text, |path, entry| match path {
            [Step::Key("a")] => splice.replace_entry(&entry(), "a:\n  - x\n"),
            [Step::Key(_)] => splice.replace(entry().value, "1".into()),
            _ => {}
        })
        .unwrap();
        assert_eq!(splice.finish(), "a:\n  - x\n# of b\nb : 1 # none\nc: 1\n");
    }

    #[test]
    fn entries_are_replaced_where_they_stand() {
        let text =
            "# ä\r\na: 1 # one\r\nb:\r\n  - x\r\n# between\r\n  - y # end\r\nc: {d: 'it''s'}\r\n";
        let mut splice = Splice::of(text);
        entries(text, |path, entry| match path {
            [Step::Key("a")] => splice.replace(entry().value, "2".into()),
            [Step::Key("b")] => splice.replace_entry(&entry(), "b:\n  - z\n"),
            [Step::Key("c"), Step::Key("d")] => {
                assert!(entry().in_braces && entry().text == "it's");
                splice.replace(entry().value, "e".into());
            }
            _ => {}
        })
        .unwrap();
        splice.append("f: 3\n");
        let expected =
            "# ä\r\na: 2 # one\r\n# between\r\nb:\r\n  - z # end\r\nc: {d: e}\r\nf: 3\r\n";
        assert_eq!(splice.finish(), expected);
    }
}
