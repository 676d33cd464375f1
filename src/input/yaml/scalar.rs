//! What a scalar means: the core schema of YAML 1.2.

use super::number::{is_not_finite, number_of};
use super::tree::{Kind, Node};

impl Node {
    /// Nothing: an empty value, `~` or `null`.
    pub(in crate::input) fn is_null(&self) -> bool {
        match &self.kind {
            Kind::Scalar { text, quoted: false } => {
                matches!(&**text, "" | "~" | "null" | "Null" | "NULL")
            }
            _ => false,
        }
    }

    /// A finite number.
    pub(in crate::input) fn number(&self) -> Option<f64> {
        match &self.kind {
            Kind::Scalar { text, quoted: false } => number_of(text),
            _ => None,
        }
    }

    /// `true` or `false`.
    pub(in crate::input) fn boolean(&self) -> Option<bool> {
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
    pub(in crate::input) fn text(&self) -> Option<&str> {
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
    pub(in crate::input) fn shown(&self) -> String {
        const LONGEST: usize = 60;
        match &self.kind {
            _ if self.is_null() => "empty".to_owned(),
            Kind::Scalar { text, quoted } => {
                let short: String = text.chars().take(LONGEST).collect();
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
