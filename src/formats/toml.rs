//! TOML as the tree that YAML is read into, so that both are held against schemas alike.

use serde::de::DeserializeOwned;
use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::text::lower_first;
use super::yaml::{Entry, Kind, Node, spelled};
use crate::notes::{Code, Notes};

/// The tree of a file and the raw type that it spells, as
/// [`yaml::document`](super::yaml::document). `None` where nothing can be read.
pub(crate) fn document<T: DeserializeOwned>(
    text: &str,
    schema: &Value,
    notes: &mut Notes,
) -> Option<(Node, T)> {
    spelled(parse(text, notes)?, schema, notes)
}

/// An empty file is an empty mapping.
fn parse(text: &str, notes: &mut Notes) -> Option<Node> {
    let (table, errors) = DeTable::parse_recoverable(text);
    let starts = Lines::of(text);
    for error in &errors {
        let line = error.span().map(|span| starts.line(span.start) as usize);
        let what = format!("not valid TOML: {}", lower_first(error.message()));
        notes.error(Code::Syntax, line, what);
    }
    errors.is_empty().then(|| Node::new(1, Kind::Mapping(starts.entries(table.get_ref()))))
}

/// Where the lines of a text start, in bytes.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1)).collect())
    }

    /// Counted from 1.
    fn line(&self, byte: usize) -> u32 {
        u32::try_from(self.0.partition_point(|start| *start <= byte)).unwrap_or(u32::MAX)
    }

    fn entries(&self, table: &DeTable) -> Vec<Entry> {
        let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue>)| Entry {
            key: AsRef::<str>::as_ref(key.get_ref()).into(),
            line: self.line(key.span().start),
            value: self.node(value),
        };
        table.iter().map(entry).collect()
    }

    fn node(&self, value: &Spanned<DeValue>) -> Node {
        let plain = |text: String| Kind::Scalar { text: text.into(), quoted: false };
        let kind = match value.get_ref() {
            DeValue::String(text) => Kind::Scalar { text: (&**text).into(), quoted: true },
            DeValue::Integer(number) => plain(number.to_string()),
            // As YAML spells what is not finite.
            DeValue::Float(number) => {
                plain(number.as_str().replace("inf", ".inf").replace("nan", ".nan"))
            }
            DeValue::Boolean(truth) => plain(truth.to_string()),
            DeValue::Datetime(date) => plain(date.to_string()),
            DeValue::Array(items) => {
                Kind::Sequence(items.iter().map(|item| self.node(item)).collect())
            }
            DeValue::Table(table) => Kind::Mapping(self.entries(table)),
        };
        Node::new(self.line(value.span().start), kind)
    }
}

#[cfg(test)]
mod tests {
    use super::super::yaml::Step::{Index, Key};
    use super::*;
    use crate::notes::{Note, Place};

    fn read(text: &str) -> (Option<Node>, Vec<String>) {
        let mut notes = Notes::about(Place::file("f"));
        let tree = parse(text, &mut notes);
        (tree, notes.finish().0.iter().map(Note::to_string).collect())
    }

    #[test]
    fn values_know_their_lines_and_kinds() {
        let (tree, errors) = read(
            "robot = \"a.yaml\" # arm\n[policy]\nseparation_percent = 1_0.5\r\nignore_hz = \
             [\n  [49, 0x33],\n]\n\n[[accept]]\nuntil = 2027-06-30\n[[accept]]\nmode = \
             2\nx.y = true\n",
        );
        assert!(errors.is_empty(), "{errors:?}");
        let tree = tree.unwrap();
        let at = |steps: &[_]| tree.at(steps).unwrap();
        assert_eq!(at(&[Key("robot")]).text(), Some("a.yaml"));
        assert_eq!(at(&[Key("policy"), Key("separation_percent")]).number(), Some(10.5));
        let band = [Key("policy"), Key("ignore_hz"), Index(0), Index(1)];
        assert_eq!((at(&band).number(), tree.line_at(&band)), (Some(51.0), 5));
        assert_eq!(at(&[Key("accept"), Index(0), Key("until")]).text(), Some("2027-06-30"));
        assert_eq!(tree.line_at(&[Key("accept"), Index(1)]), 10);
        assert_eq!(at(&[Key("accept"), Index(1), Key("x"), Key("y")]).boolean(), Some(true));
        assert_eq!(tree.line_at(&[Key("accept"), Index(1), Key("x"), Key("y")]), 12);
        for text in ["x = inf", "x = -nan", "x = \"1\"", "x = true"] {
            assert_eq!(read(text).0.unwrap().get("x").unwrap().number(), None, "{text}");
        }
        assert_eq!(read("").0.unwrap().kind, Kind::Mapping(Vec::new()));
    }

    #[test]
    fn every_fault_of_the_syntax_is_told_with_its_line() {
        let (tree, errors) = read("a = 1\nb = \nc = 2\na = 3\n[d\n");
        assert!(tree.is_none());
        for told in ["f:2: not valid TOML: ", "f:4: not valid TOML: ", "f:5: not valid TOML: "] {
            assert!(errors.iter().any(|error| error.starts_with(told)), "{told}: {errors:?}");
        }
        assert!(read(&"[".repeat(100_000)).0.is_none());
        assert!(read(&format!("a = {}", "[".repeat(100_000))).0.is_none());
    }
}
