//! What the lines of a Sinumerik program name, open and close.

use std::collections::HashMap;
use std::ops::Range;

use super::files::Files;

/// What the lines of a program open and close.
#[derive(Debug, Default)]
pub(super) struct Structure {
    /// Lines by their label, in order.
    labels: HashMap<String, Vec<usize>>,
    /// By line: where a beginning ends, an ELSE in between, and where an end began.
    end_of: HashMap<usize, usize>,
    pub(super) else_of: HashMap<usize, usize>,
    start_of: HashMap<usize, usize>,
}

/// The words of control; a line that begins with none of these is a block.
const WORDS: [&str; 17] = [
    "IF", "ELSE", "ENDIF", "FOR", "ENDFOR", "WHILE", "ENDWHILE", "LOOP", "ENDLOOP", "REPEAT",
    "UNTIL", "GOTOF", "GOTOB", "GOTO", "GOTOC", "CASE", "REPEATB",
];

/// The word of control that a text begins with, and what stands behind it.
pub(super) fn split(text: &str) -> Option<(&'static str, &str)> {
    let is_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let length = text.bytes().take_while(is_name).count();
    let word = text.get(..length)?;
    let word = WORDS.into_iter().find(|known| known.eq_ignore_ascii_case(word))?;
    let rest = text.get(length..)?;
    // `LOOP = 5` sets a variable, `LOOP:` is a label.
    (!rest.trim_start().starts_with(['=', ':'])).then_some((word, rest))
}

/// A label at the beginning of a line, in upper case, and what stands behind it.
pub(super) fn labelled(text: &str) -> (Option<String>, &str) {
    let is_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let length = text.bytes().take_while(is_name).count();
    let begins = text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    match text.get(length..).and_then(|rest| rest.strip_prefix(':')) {
        Some(rest) if begins && length > 1 => {
            (text.get(..length).map(str::to_uppercase), rest.trim_start())
        }
        _ => (None, text),
    }
}

/// Whether a text has a synchronized action: `ID=1 WHENEVER $A_IN[1] DO OVR=0` (Siemens, SINUMERIK
/// 840D sl Synchronized Actions).
pub(super) fn is_synchronized(text: &str) -> bool {
    const FIRST: [&str; 7] = ["ID", "IDS", "WHEN", "WHENEVER", "EVERY", "FROM", "DO"];
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let code = text.split('"').next().unwrap_or_default();
    let mut words = code.split(|c| !is_part(c));
    words.any(|word| FIRST.iter().any(|own| own.eq_ignore_ascii_case(word)))
        && words.any(|word| word.eq_ignore_ascii_case("DO"))
}

/// Without the comment.
pub(super) fn code(line: &str) -> &str {
    line.split(';').next().unwrap_or("").trim()
}

/// REPEAT alone, which UNTIL ends.
pub(super) fn is_block(rest: &str) -> bool {
    rest.trim().is_empty()
}

impl Structure {
    pub(super) fn of(files: &Files<'_>) -> Self {
        let mut found = Self::default();
        let mut open: Vec<(&str, usize)> = Vec::new();
        for (line, (_, content)) in files.lines.iter().enumerate() {
            if files.is_end(line) {
                open.clear();
            }
            let (label, text) = labelled(code(stripped(content)));
            if let Some(label) = label {
                found.labels.entry(label).or_default().push(line);
            }
            let Some((word, rest)) = split(text) else { continue };
            match word {
                "IF" if !rest.to_uppercase().contains("GOTO") => open.push(("ENDIF", line)),
                "FOR" => open.push(("ENDFOR", line)),
                "WHILE" => open.push(("ENDWHILE", line)),
                "LOOP" => open.push(("ENDLOOP", line)),
                "REPEAT" if is_block(rest) => open.push(("UNTIL", line)),
                "ELSE" => {
                    if let Some((_, start)) = open.last().filter(|(end, _)| *end == "ENDIF") {
                        found.else_of.insert(*start, line);
                        found.start_of.insert(line, *start);
                    }
                }
                "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDLOOP" | "UNTIL" => {
                    if let Some((_, start)) = open.pop_if(|(end, _)| *end == word) {
                        found.end_of.insert(start, line);
                        found.start_of.insert(line, start);
                    }
                }
                _ => {}
            }
        }
        found
    }

    /// The lines with this label, in upper case, in order.
    pub(super) fn labelled(&self, label: &str) -> &[usize] {
        self.labels.get(label).map_or(&[], Vec::as_slice)
    }

    pub(super) fn end(&self, line: usize, word: &str) -> Result<usize, String> {
        let end = self.end_of.get(&line).copied();
        end.ok_or_else(|| format!("{word} is not closed, or closes in another one"))
    }

    pub(super) fn start(&self, line: usize, word: &str) -> Result<usize, String> {
        let start = self.start_of.get(&line).copied();
        start.ok_or_else(|| format!("{word} closes nothing"))
    }
}

/// Of lines in order, the part that lies in a range.
pub(super) fn within(lines: &[usize], range: Range<usize>) -> &[usize] {
    let [from, to] = [range.start, range.end].map(|end| lines.partition_point(|own| *own < end));
    lines.get(from..to).unwrap_or_default()
}

/// A line without the blanks, the `/` and the N word that it begins with.
pub(super) fn stripped(line: &str) -> &str {
    let line = line.trim_start();
    let line = line.strip_prefix('/').unwrap_or(line).trim_start();
    match line.strip_prefix(['N', 'n']) {
        Some(rest) if rest.trim_start().starts_with(|c: char| c.is_ascii_digit()) => rest
            .trim_start()
            .trim_start_matches(|c: char| c.is_ascii_digit() || c == '.')
            .trim_start(),
        _ => line,
    }
}
