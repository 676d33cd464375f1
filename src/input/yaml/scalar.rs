//! What a scalar means: the core schema of YAML 1.2.

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

/// The finite number that a plain scalar spells.
pub(super) fn number_of(text: &str) -> Option<f64> {
    let first = *text.as_bytes().first()?;
    if !(first.is_ascii_digit() || matches!(first, b'+' | b'-' | b'.')) {
        return None;
    }
    if let Some(digits) = text.strip_prefix("0x") {
        return u32::from_str_radix(digits, 16).ok().map(f64::from);
    }
    if let Some(digits) = text.strip_prefix("0o") {
        return u32::from_str_radix(digits, 8).ok().map(f64::from);
    }
    let spelled = text
        .bytes()
        .all(|byte| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'e' | b'E'));
    if !spelled {
        return None;
    }
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// `.nan`, `.inf`, and decimal numbers too large for a double.
fn is_not_finite(text: &str) -> bool {
    let unsigned = text.strip_prefix(['+', '-']).unwrap_or(text);
    matches!(unsigned, ".inf" | ".Inf" | ".INF" | ".nan" | ".NaN" | ".NAN")
        || (unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.')
            && unsigned.parse::<f64>().is_ok_and(f64::is_infinite))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_core_schema_and_finite() {
        for (text, number) in [
            ("0", 0.0),
            ("-1.2e5", -1.2e5),
            ("+.5", 0.5),
            ("5.", 5.0),
            ("0x1F", 31.0),
            ("0o17", 15.0),
            ("007", 7.0),
        ] {
            assert_eq!(number_of(text), Some(number), "{text}");
        }
        for text in [
            "", "-", ".", "+.e3", "1e", "1_000", "1,5", ".nan", ".inf", "nan", "inf", "1e999",
            "0x", "1 2", "e5",
        ] {
            assert_eq!(number_of(text), None, "{text}");
        }
    }

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
