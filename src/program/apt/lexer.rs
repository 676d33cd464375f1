//! APT text → statements: names, numbers with their places, and the symbols between them.

use super::words::{BEGINS, MOVES};
use crate::program::span::Span;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind<'t> {
    /// As the text has it, blanks at its ends gone.
    Name(&'t str),
    Number(f64),
    /// `/`, `,`, `(`, `)` or `=`.
    Symbol(u8),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Token<'t> {
    pub(super) kind: Kind<'t>,
    pub(super) span: Span,
}

/// What stands between commas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Word<'t> {
    Name(&'t str),
    Number(f64, Span),
}

/// A statement, its continued lines joined.
#[derive(Debug, Default)]
pub(super) struct Statement<'t> {
    /// Line on which it starts.
    pub(super) line: usize,
    pub(super) tokens: Vec<Token<'t>>,
    /// Whether a `$` may be the first letter of a name, or may end the line.
    pub(super) is_unclear: bool,
}

impl<'t> Statement<'t> {
    /// The word that says what it is.
    pub(super) fn major(&self) -> &'t str {
        match self.tokens.first() {
            Some(Token { kind: Kind::Name(name), .. }) => name,
            _ => "",
        }
    }

    /// What stands behind the first `/`, between further ones and commas.
    pub(super) fn minor(&self) -> Vec<Word<'t>> {
        let slash = |token: &Token<'_>| token.kind == Kind::Symbol(b'/');
        let behind = self.tokens.iter().position(slash).map_or(self.tokens.len(), |at| at + 1);
        let words = self.tokens.get(behind..).unwrap_or_default().iter();
        let words = words.filter_map(|token| match token.kind {
            Kind::Name(name) => Some(Word::Name(name)),
            Kind::Number(number) => Some(Word::Number(number, token.span)),
            Kind::Symbol(_) => None,
        });
        words.collect()
    }

    /// A word that begins another statement behind this one, as `RAPID,GOTO/1,2,3` or
    /// `COOLNT/OFF;GOTO/1,2,3` have it.
    pub(super) fn second(&self) -> Option<&'t str> {
        let begins = |word: &str| BEGINS.iter().chain(&MOVES).any(|own| is(word, own));
        let is_slash =
            |at: usize| self.tokens.get(at).is_some_and(|token| token.kind == Kind::Symbol(b'/'));
        let is_rapid = self.major().split_whitespace().next().is_some_and(|own| is(own, "RAPID"));
        let mut depth = 0_usize;
        for (at, token) in self.tokens.iter().enumerate() {
            match token.kind {
                Kind::Symbol(b'(') => depth += 1,
                Kind::Symbol(b')') => depth = depth.saturating_sub(1),
                Kind::Name(name) if depth == 0 => {
                    let words = name.split(|c: char| c.is_whitespace() || c == ';');
                    let last = words.skip(usize::from(at == 0)).last();
                    // A value may have such a name, too.
                    let may_begin = at == 0 || is_rapid || is_slash(at + 1);
                    if let Some(second) = last.filter(|last| may_begin && begins(last)) {
                        return Some(second);
                    }
                }
                _ => {}
            }
        }
        None
    }

    /// The numbers in the parentheses of `(NAME/…)`, the first with this name.
    pub(super) fn inside(&self, name: &str) -> Option<Vec<f64>> {
        let named = |token: &Token<'_>| matches!(token.kind, Kind::Name(found) if is(found, name));
        let from = self.tokens.iter().position(named)?;
        let rest = self.tokens.get(from + 1..)?.iter();
        let inside = rest.take_while(|token| token.kind != Kind::Symbol(b')'));
        let numbers = inside.filter_map(|token| match token.kind {
            Kind::Number(number) => Some(number),
            _ => None,
        });
        Some(numbers.collect())
    }
}

pub(super) fn is(name: &str, word: &str) -> bool {
    name.eq_ignore_ascii_case(word)
}

/// Statements that are text to the end of the line, `$` included.
const FREE_TEXT: [&str; 6] = ["PARTNO", "PPRINT", "REMARK", "INSERT", "TPRINT", "PPWORD"];

/// Longest chain of continued lines, so that a file of `$` ends.
const MAX_TOKENS: usize = 100_000;

/// Reads the next statement that has tokens; false at the end of the text.
pub(super) struct Lexer<'t> {
    text: &'t str,
    at: usize,
    line: usize,
    /// Whether the last statement asked for a line that is not there.
    pub(super) is_cut: bool,
    in_comment: bool,
    /// Creo's `$$-> CSYS` and CATIA's `$$*CATIA0`: line and numbers of the one that is read,
    /// numbers of the first.
    system: Option<(usize, Vec<f64>)>,
    first_system: Option<Vec<f64>>,
    /// The line of one that is not the first again.
    pub(super) other_system: Option<usize>,
    /// Whether Creo's header, `$$* Pro/CLfile Version …`, stands before what is read.
    pub(super) is_creo: bool,
}

impl<'t> Lexer<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        Self {
            text,
            at: 0,
            line: 0,
            is_cut: false,
            in_comment: false,
            system: None,
            first_system: None,
            other_system: None,
            is_creo: false,
        }
    }

    pub(super) fn line(&self) -> usize {
        self.line.max(1)
    }

    pub(super) fn next_into(&mut self, statement: &mut Statement<'t>) -> bool {
        statement.tokens.clear();
        statement.is_unclear = false;
        loop {
            let Some(rest) = self.text.get(self.at..).filter(|rest| !rest.is_empty()) else {
                self.is_cut = !statement.tokens.is_empty();
                return !statement.tokens.is_empty();
            };
            let length = memchr::memchr(b'\n', rest.as_bytes()).map_or(rest.len(), |end| end + 1);
            let (start, whole) = (self.at, rest.get(..length).unwrap_or(rest));
            self.at += length;
            self.line += 1;
            if statement.tokens.is_empty() {
                statement.line = self.line;
            }
            // Creo's comments go on by `$`, too.
            let trimmed = whole.trim();
            let is_comment = trimmed.starts_with("$$->") || self.in_comment;
            self.in_comment = is_comment && trimmed.ends_with('$');
            if is_comment {
                self.comment(trimmed);
                continue;
            }
            if trimmed.starts_with("$$") {
                self.is_creo |= is_header_of_creo(trimmed);
                self.row(trimmed);
            }
            let continued = tokens(whole, start, statement);
            if !continued && !statement.tokens.is_empty() || statement.tokens.len() > MAX_TOKENS {
                return true;
            }
        }
    }

    /// A line of Creo's comments: `$$-> CSYS / …`, or what continues it.
    fn comment(&mut self, line: &str) {
        let content = match line.strip_prefix("$$->").map(str::trim_start) {
            Some(content) => {
                let word = content.split(['/', ' ']).next().unwrap_or("");
                self.system = is(word, "CSYS").then(|| (self.line, Vec::new()));
                content
            }
            None => line,
        };
        let Some((_, numbers)) = &mut self.system else { return };
        let words = content.split(|c: char| c.is_whitespace() || matches!(c, ',' | '/' | '$'));
        numbers.extend(words.filter_map(|word| word.parse::<f64>().ok()));
        if self.in_comment && numbers.len() <= MAX_TOKENS {
            return;
        }
        self.end_system();
    }

    /// CATIA's comments: `$$*CATIA0`, the name of a part operation, three rows of its system.
    fn row(&mut self, line: &str) {
        if line.starts_with("$$*CATIA0") {
            self.system = Some((self.line, Vec::new()));
            return;
        }
        let Some((_, numbers)) = &mut self.system else { return };
        let words = line.trim_start_matches('$').split_whitespace();
        let row: Result<Vec<f64>, _> = words.map(str::parse).collect();
        if let Ok(row) = row
            && row.len() == 4
        {
            numbers.extend(row);
            if numbers.len() >= 12 {
                self.end_system();
            }
        }
    }

    fn end_system(&mut self) {
        const SAME: f64 = 1e-9;
        let Some((line, system)) = self.system.take().filter(|(_, own)| !own.is_empty()) else {
            return;
        };
        let Some(first) = &self.first_system else {
            self.first_system = Some(system);
            return;
        };
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME;
        if first.len() != system.len() || !first.iter().zip(&system).all(near) {
            self.other_system.get_or_insert(line);
        }
    }
}

fn is_header_of_creo(comment: &str) -> bool {
    const HEADER: &str = "Pro/CLfile";
    let title = comment.strip_prefix("$$*").map_or("", str::trim_start);
    title.get(..HEADER.len()).is_some_and(|start| is(start, HEADER))
}

/// The tokens of a line; true where it goes on.
fn tokens<'t>(line: &'t str, offset: usize, statement: &mut Statement<'t>) -> bool {
    let content = match line.find("$$") {
        Some(at) => line.get(..at).unwrap_or(line),
        None => line,
    };
    let start = content.trim_start();
    let is_free = statement.tokens.is_empty()
        && FREE_TEXT.iter().any(|word| {
            start.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
        });
    let mut at = content.len() - start.len();
    if is_free {
        let end = at + start.bytes().take_while(u8::is_ascii_alphabetic).count();
        push(content, at, end, offset, statement);
        return false;
    }
    // What stands behind the `$` is a remark.
    let is_between = |at| content.get(..at).unwrap_or("").trim_end().ends_with([',', '/']);
    let is_end = |&(at, _): &(usize, &str)| {
        let behind = content.get(at + 1..).unwrap_or("");
        behind.trim().is_empty() || is_between(at) && behind.starts_with(char::is_whitespace)
    };
    let (content, continued) = match content.match_indices('$').find(is_end) {
        Some((at, _)) => (content.get(..at).unwrap_or(content), true),
        None => (content.trim_end(), false),
    };
    statement.is_unclear |= content.match_indices('$').any(|(at, _)| is_between(at));
    let bytes = content.as_bytes();
    let mut from = at;
    while at < bytes.len() {
        if matches!(bytes[at], b'/' | b',' | b'(' | b')' | b'=') {
            push(content, from, at, offset, statement);
            let span = Span::new(offset + at, offset + at + 1);
            statement.tokens.push(Token { kind: Kind::Symbol(bytes[at]), span });
            from = at + 1;
        }
        at += 1;
    }
    push(content, from, bytes.len(), offset, statement);
    continued
}

/// What stands between two symbols, if it is anything.
fn push<'t>(line: &'t str, from: usize, to: usize, offset: usize, into: &mut Statement<'t>) {
    let field = line.get(from..to).unwrap_or("");
    let text = field.trim_matches(|c: char| c.is_whitespace() || c.is_control());
    if text.is_empty() {
        return;
    }
    let start = offset + from + (text.as_ptr() as usize - field.as_ptr() as usize);
    let span = Span::new(start, start + text.len());
    // `parse` takes "inf" and "nan", which are names here.
    let first = text.as_bytes().first().copied().unwrap_or_default();
    let may = first.is_ascii_digit() || matches!(first, b'+' | b'-' | b'.');
    let number = may.then(|| text.parse::<f64>().ok()).flatten().filter(|n| n.is_finite());
    let kind = number.map_or(Kind::Name(text), Kind::Number);
    into.tokens.push(Token { kind, span });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str) -> Vec<(usize, String, usize)> {
        let mut lexer = Lexer::new(text);
        let mut statement = Statement::default();
        let mut found = Vec::new();
        while lexer.next_into(&mut statement) {
            let major = statement.major().to_owned();
            found.push((statement.line, major, statement.minor().len()));
        }
        found
    }

    #[test]
    fn statements_with_their_lines() {
        let text =
            "PARTNO a/b $\n\n$$ x\nGOTO/ 1 , 2,$\n 3 $$ c\nTLON,GOFWD/(CIRCLE/1,2,3,$\n4),ON\n";
        let found = all(text);
        assert_eq!(found[0], (1, "PARTNO".to_owned(), 0));
        assert_eq!(found[1], (4, "GOTO".to_owned(), 3));
        assert_eq!((found[2].0, found[2].1.as_str()), (6, "TLON"));
        let mut lexer = Lexer::new("GOTO/1,$\n");
        let mut statement = Statement::default();
        assert!(lexer.next_into(&mut statement) && lexer.is_cut);
    }

    #[test]
    fn numbers_know_where_they_stand() {
        let text = "FEDRAT/ 300.50 ,MMPM\n";
        let mut lexer = Lexer::new(text);
        let mut statement = Statement::default();
        assert!(lexer.next_into(&mut statement));
        let Word::Number(value, span) = statement.minor()[0] else { panic!() };
        assert_eq!((value, &text[span.start..span.end]), (300.5, "300.50"));
    }
}
