//! The lines of a KRL file with their tokens.

use super::lexer::{Kind, tokens};

/// A line, comments aside.
pub(super) struct Line {
    pub(super) number: usize,
    pub(super) tokens: Result<Vec<Kind>, String>,
    /// As written, for names.
    pub(super) text: String,
}

impl Line {
    pub(super) fn tokens(&self) -> &[Kind] {
        self.tokens.as_deref().unwrap_or_default()
    }

    /// The first word, `global` before a routine or a declaration skipped.
    pub(super) fn first(&self) -> &str {
        let word = |index: usize| match self.tokens().get(index) {
            Some(Kind::Word(word)) => word.as_str(),
            _ => "",
        };
        let second = word(1);
        if word(0) == "global"
            && matches!(second, "def" | "deffct" | "decl" | "interrupt" | "signal")
        {
            second
        } else {
            word(0)
        }
    }
}

/// The lines of a file that hold anything.
pub(super) fn lines(text: &str, is_main: bool) -> Vec<Line> {
    let mut offset = 0;
    let mut found = Vec::new();
    for (index, whole) in text.split_inclusive('\n').enumerate() {
        let content = whole.trim_end_matches(['\n', '\r']);
        let start = content.trim_start();
        if !start.is_empty() && !start.starts_with([';', '&']) {
            let tokens = tokens(content, is_main.then_some(offset));
            if !tokens.as_ref().is_ok_and(Vec::is_empty) {
                found.push(Line { number: index + 1, tokens, text: start.to_owned() });
            }
        }
        offset += whole.len();
    }
    found
}
