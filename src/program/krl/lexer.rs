//! A line of KRL → tokens with their places. Comments and the fold texts in them vanish.

use crate::program::span::Span;

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    /// An identifier or keyword in lower case, `$` included.
    Word(String),
    /// Finite, not negative; where it stands in the text of the main file; whether it is an INT.
    Number(f64, Option<Span>, bool),
    Text(String),
    /// `#CONSTANT`, in lower case without the sign.
    Enum(String),
    Symbol(&'static str),
}

const SYMBOLS: [&str; 25] = [
    "==", "<>", "<=", ">=", ":=", "=", "<", ">", "+", "-", "*", "/", "(", ")", "[", "]", "{", "}",
    ",", ".", ":", "?", "!", "'", "&",
];

/// The tokens of one line, which begins at `offset` of the text of the main file, if it is in it.
///
/// # Errors
/// What is nothing of KRL.
pub(super) fn tokens(line: &str, offset: Option<usize>) -> Result<Vec<Kind>, String> {
    let bytes = line.as_bytes();
    let span = |from: usize, to: usize| offset.map(|at| Span::new(at + from, at + to));
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let rest = line.get(at..).unwrap_or("");
        match byte {
            b';' => break,
            b' ' | b'\t' | b'\r' => at += 1,
            b'"' => {
                let end = rest.get(1..).and_then(|tail| tail.find('"'));
                let end = end.ok_or("a text is not closed")? + 1;
                found.push(Kind::Text(rest.get(1..end).unwrap_or("").to_owned()));
                at += end + 1;
            }
            b'0'..=b'9' => {
                let length = number_length(rest);
                let text = rest.get(..length).unwrap_or("");
                let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
                let value = value.ok_or_else(|| format!("'{text}' is no number"))?;
                let is_whole = text.bytes().all(|byte| byte.is_ascii_digit());
                found.push(Kind::Number(value, span(at, at + length), is_whole));
                at += length;
            }
            b'.' if bytes.get(at + 1).is_some_and(u8::is_ascii_digit)
                && (!matches!(found.last(), Some(Kind::Word(_) | Kind::Symbol("]")))
                    || at.checked_sub(1).is_some_and(|at| matches!(bytes[at], b' ' | b'\t'))) =>
            {
                let length = number_length(rest);
                let value = rest.get(..length).and_then(|text| text.parse::<f64>().ok());
                let value = value.ok_or("a point without a number")?;
                found.push(Kind::Number(value, span(at, at + length), false));
                at += length;
            }
            b'\'' => {
                // 'B1010', 'B 110', 'HFF'.
                let end = rest.get(1..).and_then(|tail| tail.find('\''));
                let end = end.ok_or("a number in quotes is not closed")? + 1;
                let text = rest.get(1..end).unwrap_or("").to_ascii_uppercase();
                let digits = text.get(1..).unwrap_or("").trim_start();
                let radix = if text.starts_with('B') { 2 } else { 16 };
                let value = u32::from_str_radix(digits, radix);
                let value = value.map_err(|_| format!("'{text}' is no number"))?;
                found.push(Kind::Number(f64::from(value), None, true));
                at += end + 1;
            }
            b'#' => {
                let length = word_length(rest.get(1..).unwrap_or(""));
                let name = rest.get(1..=length).unwrap_or("");
                found.push(Kind::Enum(name.to_lowercase()));
                at += length + 1;
            }
            b'$' => {
                let length = word_length(rest.get(1..).unwrap_or("")) + 1;
                found.push(Kind::Word(rest.get(..length).unwrap_or("").to_lowercase()));
                at += length;
            }
            _ if word_length(rest) > 0 => {
                let length = word_length(rest);
                found.push(Kind::Word(rest.get(..length).unwrap_or("").to_lowercase()));
                at += length;
            }
            _ => {
                let symbol = SYMBOLS.into_iter().find(|symbol| rest.starts_with(symbol));
                let symbol = symbol.ok_or_else(|| {
                    format!("'{}' is not understood", rest.chars().next().unwrap_or(' '))
                })?;
                found.push(Kind::Symbol(symbol));
                at += symbol.len();
            }
        }
    }
    Ok(found)
}

/// A name: letters, digits and `_`, `$` within; the first no digit.
fn word_length(text: &str) -> usize {
    let first = text.chars().next();
    if !first.is_some_and(|c| c.is_alphabetic() || c == '_') {
        return 0;
    }
    text.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == '$')).unwrap_or(text.len())
}

fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        bytes.iter().skip(from).take_while(|byte| byte.is_ascii_digit()).count() + from
    };
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(end + 1 + sign);
        if exponent > end + 1 + sign {
            end = exponent;
        }
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_names_and_symbols() {
        let line = "$VEL.CP=0.20 ; m/s";
        let found = tokens(line, Some(100)).unwrap();
        assert_eq!(found[0], Kind::Word("$vel".to_owned()));
        assert_eq!(
            found[1..4],
            [Kind::Symbol("."), Kind::Word("cp".to_owned()), Kind::Symbol("=")]
        );
        assert_eq!(found[4], Kind::Number(0.2, Some(Span::new(108, 112)), false));
        let found = tokens("{X 1,E1 -1.5E-3} #BASE 'HFF'", None).unwrap();
        assert_eq!(found.len(), 10);
        assert!(matches!(found[8], Kind::Enum(ref name) if name == "base"));
        assert!(matches!(found[9], Kind::Number(255.0, None, true)));
        let found = tokens("S 'B 110',T 'B 1 1'", None);
        assert!(found.unwrap_err().contains("'B 1 1' is no number"));
        assert_eq!(tokens("'B 110'", None).unwrap(), [Kind::Number(6.0, None, true)]);
    }
}
