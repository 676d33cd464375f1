//! Values of a YAML text, each with its line; scalars mean what the core schema of YAML 1.2 says.

use std::sync::Arc;

use super::number::{is_not_finite, number_of};

/// A value and where it starts.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Node {
    /// Counted from 1.
    pub(crate) line: u32,
    pub(crate) kind: Kind,
    /// An error is about it: reading goes on without it.
    pub(crate) faulty: bool,
    /// Read from the tree itself, not through serde.
    pub(crate) apart: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Kind {
    /// Anything but a collection, not yet interpreted.
    Scalar { text: Box<str>, quoted: bool },
    /// A list of finite numbers on one line: the bulk of large files, kept small.
    Numbers(Box<[f64]>),
    /// Any other list.
    Sequence(Vec<Node>),
    /// Keys and values in the order of the file; no key twice.
    Mapping(Vec<Entry>),
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    pub(crate) key: Arc<str>,
    /// Line of the key.
    pub(crate) line: u32,
    pub(crate) value: Node,
}

/// One step from a value to one inside it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

impl Node {
    pub(crate) fn new(line: u32, kind: Kind) -> Self {
        Self { line, kind, faulty: false, apart: false }
    }

    /// The value under a key.
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        self.entry(key).map(|entry| &entry.value)
    }

    pub(crate) fn entry(&self, key: &str) -> Option<&Entry> {
        match &self.kind {
            Kind::Mapping(entries) => entries.iter().find(|entry| &*entry.key == key),
            _ => None,
        }
    }

    /// The keys of a mapping.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &str> {
        let entries: &[Entry] = match &self.kind {
            Kind::Mapping(entries) => entries,
            _ => &[],
        };
        entries.iter().map(|entry| &*entry.key)
    }

    /// The items of a list other than of numbers.
    pub(crate) fn items(&self) -> &[Node] {
        match &self.kind {
            Kind::Sequence(items) => items,
            _ => &[],
        }
    }

    /// The value at the end of `steps`.
    pub(crate) fn at(&self, steps: &[Step<'_>]) -> Option<&Node> {
        steps.iter().try_fold(self, |node, step| match step {
            Step::Key(key) => node.get(key),
            Step::Index(index) => node.items().get(*index),
        })
    }

    /// The line of the value at the end of `steps`, or of the last one on the way that exists.
    pub(crate) fn line_at(&self, steps: &[Step<'_>]) -> usize {
        let (mut node, mut line) = (self, self.line);
        for step in steps {
            match step {
                Step::Key(key) => match node.entry(key) {
                    Some(entry) => (node, line) = (&entry.value, entry.line),
                    None => break,
                },
                Step::Index(index) => match node.items().get(*index) {
                    Some(item) => (node, line) = (item, item.line),
                    None => break,
                },
            }
        }
        line as usize
    }
}

impl Node {
    /// Nothing: an empty value, `~` or `null`.
    pub(crate) fn is_null(&self) -> bool {
        match &self.kind {
            Kind::Scalar { text, quoted: false } => {
                matches!(&**text, "" | "~" | "null" | "Null" | "NULL")
            }
            _ => false,
        }
    }

    /// A finite number.
    pub(crate) fn number(&self) -> Option<f64> {
        match &self.kind {
            Kind::Scalar { text, quoted: false } => number_of(text),
            _ => None,
        }
    }

    /// `true` or `false`.
    pub(crate) fn boolean(&self) -> Option<bool> {
        match &self.kind {
            Kind::Scalar { text, quoted: false } => match &**text {
                "true" | "True" | "TRUE" => Some(true),
                "false" | "False" | "FALSE" => Some(false),
                _ => None,
            },
            _ => None,
        }
    }

    /// Text: quoted, or plain and nothing else.
    pub(crate) fn text(&self) -> Option<&str> {
        match &self.kind {
            Kind::Scalar { text, quoted: true } => Some(text),
            Kind::Scalar { text, quoted: false }
                if !self.is_null()
                    && self.boolean().is_none()
                    && number_of(text).is_none()
                    && !is_not_finite(text) =>
            {
                Some(text)
            }
            _ => None,
        }
    }

    /// The value as a message shows it.
    pub(crate) fn shown(&self) -> String {
        match &self.kind {
            _ if self.is_null() => "empty".to_owned(),
            Kind::Scalar { text, quoted } => {
                let short: String = text.chars().take(60).collect();
                let dots = if short.len() < text.len() { "…" } else { "" };
                let mark = if *quoted { "\"" } else { "" };
                format!("{mark}{}{dots}{mark}", short.escape_debug())
            }
            Kind::Numbers(numbers) if numbers.len() <= 6 => format!("{numbers:?}"),
            Kind::Numbers(numbers) => format!("a list of {}", numbers.len()),
            Kind::Sequence(items) => format!("a list of {}", items.len()),
            Kind::Mapping(_) => "a mapping".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotes_make_text_of_anything() {
        let scalar = |text: &str, quoted| Node::new(1, Kind::Scalar { text: text.into(), quoted });
        for text in ["12", "true", "~", "", ".nan", "1e999"] {
            assert_eq!(scalar(text, true).text(), Some(text));
            assert_eq!(scalar(text, false).text(), None, "{text:?}");
        }
        assert_eq!(scalar("2026-11-21", false).text(), Some("2026-11-21"));
        assert_eq!(scalar("yes", false).boolean(), None);
        assert_eq!(scalar("", false).shown(), "empty");
    }
}
