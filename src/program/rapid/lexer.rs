//! RAPID text → tokens with their lines. Comments, white space and the `%%% … %%%` header vanish.

use crate::program::span::Span;

/// A token and the line it starts on, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Token<'a> {
    pub(super) kind: Kind<'a>,
    pub(super) line: usize,
    pub(super) span: Span,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind<'a> {
    /// Identifier or keyword, in the case of the file.
    Word(&'a str),
    /// Finite, not negative.
    Number(f64),
    /// What stands between the quotes.
    Text(&'a str),
    Symbol(&'static str),
    /// Nothing of RAPID; reported where it matters.
    Stray(&'a str),
}

const HEADER: &str = "%%%";

/// The tokens of a text one after the other: a long program never stands in memory as tokens.
#[derive(Debug, Clone)]
pub(super) struct Lexer<'a> {
    rest: &'a str,
    /// Of the whole text.
    length: usize,
    line: usize,
    last: Option<Kind<'a>>,
    /// Whether something stands between the last token and the rest.
    apart: bool,
}

impl<'a> Lexer<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { rest: text, length: text.len(), line: 1, last: None, apart: false }
    }

    /// How much of the rest the next token or gap takes, and the token.
    fn step(&self, first: char) -> (usize, Option<Kind<'a>>) {
        let rest = self.rest;
        match first {
            '!' => (until_line_end(rest), None),
            c if c.is_whitespace() || c.is_control() => (c.len_utf8(), None),
            '"' => string(rest),
            c if is_word_start(c) => {
                let length = rest.find(|c: char| !is_word(c)).unwrap_or(rest.len());
                (length, rest.get(..length).map(Kind::Word))
            }
            c if c.is_ascii_digit() || (c == '.' && starts_fraction(rest, self)) => number(rest),
            _ if rest.starts_with(HEADER) => (header(rest), None),
            c => match symbol(rest, c) {
                Some(symbol) => (symbol.len(), Some(Kind::Symbol(symbol))),
                None => (c.len_utf8(), rest.get(..c.len_utf8()).map(Kind::Stray)),
            },
        }
    }
}

impl<'a> Iterator for Lexer<'a> {
    type Item = Token<'a>;

    fn next(&mut self) -> Option<Token<'a>> {
        loop {
            let first = self.rest.chars().next()?;
            let (length, kind) = self.step(first);
            let line = self.line;
            let (taken, left) = self.rest.split_at_checked(length).unwrap_or((self.rest, ""));
            self.line += taken.bytes().filter(|&byte| byte == b'\n').count();
            self.rest = left;
            self.apart = kind.is_none();
            if let Some(kind) = kind {
                self.last = Some(kind);
                let end = self.length - self.rest.len();
                let span = Span::new(end - taken.len(), end);
                return Some(Token { kind, line, span });
            }
        }
    }
}

fn symbol(rest: &str, first: char) -> Option<&'static str> {
    let second = rest.as_bytes().get(1).copied();
    let symbol = match (first, second) {
        (':', Some(b'=')) => ":=",
        ('<', Some(b'>')) => "<>",
        ('<', Some(b'=')) => "<=",
        ('>', Some(b'=')) => ">=",
        ('=', _) => "=",
        ('<', _) => "<",
        ('>', _) => ">",
        ('+', _) => "+",
        ('-', _) => "-",
        ('*', _) => "*",
        ('/', _) => "/",
        ('(', _) => "(",
        (')', _) => ")",
        ('[', _) => "[",
        (']', _) => "]",
        ('{', _) => "{",
        ('}', _) => "}",
        (',', _) => ",",
        (';', _) => ";",
        (':', _) => ":",
        ('\\', _) => "\\",
        ('.', _) => ".",
        ('?', _) => "?",
        ('%', _) => "%",
        ('|', _) => "|",
        _ => return None,
    };
    Some(symbol)
}

fn is_word_start(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn until_line_end(rest: &str) -> usize {
    rest.find('\n').unwrap_or(rest.len())
}

fn header(rest: &str) -> usize {
    rest.get(HEADER.len()..)
        .and_then(|body| body.find(HEADER))
        .map_or(HEADER.len(), |end| end + 2 * HEADER.len())
}

/// `.5` is a number, but not in `p10.5` or `p{1}.5`; it is in `WaitTime .5`.
fn starts_fraction(rest: &str, before: &Lexer<'_>) -> bool {
    let is_name = matches!(before.last, Some(Kind::Word(_) | Kind::Symbol("}" | ")" | "]")));
    let after_a_name = is_name && !before.apart;
    !after_a_name && rest.as_bytes().get(1).is_some_and(u8::is_ascii_digit)
}

fn string(rest: &str) -> (usize, Option<Kind<'_>>) {
    let mut at = 1;
    while let Some(found) = rest.get(at..).and_then(|tail| tail.find(['"', '\n'])) {
        let end = at + found;
        if rest.get(end..).is_some_and(|tail| tail.starts_with("\"\"")) {
            at = end + 2;
        } else if rest.as_bytes().get(end) == Some(&b'"') {
            return (end + 1, rest.get(1..end).map(Kind::Text));
        } else {
            // Strings do not span lines: the quote was never closed.
            return (end, rest.get(..end).map(Kind::Stray));
        }
    }
    (rest.len(), Some(Kind::Stray(rest)))
}

/// What a string in the text stands for: a quote and a backslash are written twice, and `\0A` is
/// the character of that code (ABB, Technical reference manual, RAPID kernel, "Strings").
pub(super) fn unescaped(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let code = rest.get(1..3).filter(|_| first == '\\');
        let code = code.filter(|code| code.bytes().all(|byte| byte.is_ascii_hexdigit()));
        let (own, length) = match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(code) => (char::from(code), 3),
            None if rest.starts_with("\"\"") || rest.starts_with("\\\\") => (first, 2),
            None => (first, first.len_utf8()),
        };
        plain.push(own);
        rest = rest.get(length..).unwrap_or("");
    }
    plain
}

fn number(rest: &str) -> (usize, Option<Kind<'_>>) {
    let bytes = rest.as_bytes();
    let digits = |from: usize| {
        bytes.iter().skip(from).take_while(|byte| byte.is_ascii_digit()).count() + from
    };
    let radix = match bytes.get(..2) {
        Some(b"0x" | b"0X") => Some(16),
        Some(b"0b" | b"0B") => Some(2),
        Some(b"0o" | b"0O") => Some(8),
        _ => None,
    };
    if let Some(radix) = radix {
        let end = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let value = rest.get(2..end).and_then(|digits| u32::from_str_radix(digits, radix).ok());
        let stray = rest.get(..end).map(Kind::Stray);
        return (end, value.map(|value| Kind::Number(f64::from(value))).or(stray));
    }
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let signed = matches!(bytes.get(end + 1), Some(b'+' | b'-'));
        let exponent = end + 1 + usize::from(signed);
        if digits(exponent) > exponent {
            end = digits(exponent);
        }
    }
    if rest.get(end..).and_then(|tail| tail.chars().next()).is_some_and(is_word) {
        let end = rest.find(|c: char| !is_word(c) && c != '.').unwrap_or(rest.len());
        return (end, rest.get(..end).map(Kind::Stray));
    }
    let value = rest.get(..end).and_then(|digits| digits.parse::<f64>().ok());
    let kind = match value.filter(|value| value.is_finite()) {
        Some(value) => Some(Kind::Number(value)),
        None => rest.get(..end).map(Kind::Stray),
    };
    (end, kind)
}

#[cfg(test)]
mod tests {
    use super::Kind::{Number, Stray, Symbol, Text, Word};
    use super::*;

    fn kinds(text: &str) -> Vec<Kind<'_>> {
        Lexer::new(text).map(|token| token.kind).collect()
    }

    #[test]
    fn numbers_take_every_form_that_programs_use() {
        assert_eq!(
            kinds("9E9 9E+09 1.5e-3 .5 2. 0x1F 0b101"),
            [
                Number(9e9),
                Number(9e9),
                Number(1.5e-3),
                Number(0.5),
                Number(2.0),
                Number(31.0),
                Number(5.0),
            ]
        );
        assert_eq!(
            kinds("p10.trans 12abc 1E999"),
            [Word("p10"), Symbol("."), Word("trans"), Stray("12abc"), Stray("1E999"),]
        );
    }

    #[test]
    fn comments_strings_and_headers_keep_the_lines() {
        let text = "%%%\n  VERSION:1\n%%%\nTPWrite \"a ! \"\"b\"\"\"; ! MoveL\r\nSt\u{f6}rung;";
        let lines: Vec<_> = Lexer::new(text).map(|token| token.line).collect();
        assert_eq!(
            kinds(text),
            [
                Word("TPWrite"),
                Text("a ! \"\"b\"\""),
                Symbol(";"),
                Word("St\u{f6}rung"),
                Symbol(";"),
            ]
        );
        assert_eq!(lines, [4, 4, 4, 5, 5]);
        assert_eq!(kinds("\"open\n;"), [Stray("\"open"), Symbol(";")]);
    }

    #[test]
    fn strings_have_quotes_backslashes_and_codes() {
        let text = r#"say ""x"" C:\\cut\41\0D \z \4"#;
        assert_eq!(unescaped(text), "say \"x\" C:\\cutA\r \\z \\4");
    }
}
