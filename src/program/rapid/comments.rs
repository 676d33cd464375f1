//! Numbers in comments that set the speed of the spindle or the number of the tool.

use std::collections::HashMap;

use crate::program::{SetBy, Setter, Settings};

/// What a number sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sets {
    Spindle,
    Tool,
}

/// Numbers in comments, by the line of the instruction that follows.
pub(super) type Comments = HashMap<usize, Vec<(usize, Sets, f64)>>;

pub(super) fn all(settings: &Settings) -> impl Iterator<Item = (Sets, &SetBy)> {
    let spindle = settings.spindle_from.as_ref().map(|by| (Sets::Spindle, by));
    spindle.into_iter().chain(settings.tool_from.as_ref().map(|by| (Sets::Tool, by)))
}

/// The comments of a program that set something.
pub(super) fn comments(text: &str, settings: &Settings) -> Comments {
    let mut found = Comments::new();
    let mut open = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some(comment) = line.strip_prefix('!') {
            open.extend(all(settings).filter_map(|(sets, by)| {
                let Setter::Comment(start) = &by.what else { return None };
                let value = number(comment.trim_start().strip_prefix(start.as_str())?)?;
                Some((index + 1, sets, value * by.per_unit))
            }));
        } else if !line.is_empty() && !open.is_empty() {
            found.insert(index + 1, std::mem::take(&mut open));
        }
    }
    found
}

/// The number at the start of a text, behind blanks and `=` or `:`.
fn number(text: &str) -> Option<f64> {
    let text = text.trim_start_matches([' ', '\t', '=', ':']);
    let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    text.get(..end)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::number;

    #[test]
    fn numbers_behind_the_start_of_a_comment() {
        for (text, expected) in
            [(" 12000 rpm", Some(12000.0)), ("=800.5;", Some(800.5)), (" off", None), ("", None)]
        {
            assert_eq!(number(text), expected, "{text}");
        }
    }
}
