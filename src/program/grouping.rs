//! Errors that say the same of several lines → one, with their number.

use std::collections::HashMap;

use crate::notes::{Code, Note};

/// The first of each kind, with how many more there are.
pub(super) fn grouped(errors: Vec<Note>) -> Vec<Note> {
    /// Lines that are named beside the first.
    const NAMED: usize = 4;
    let mut kept: Vec<Note> = Vec::new();
    let mut others: Vec<Vec<usize>> = Vec::new();
    let mut first: HashMap<(Code, String), usize> = HashMap::new();
    for error in errors {
        let key = (error.code, error.what.clone());
        match (first.get(&key), error.place.line) {
            (Some(&index), Some(line)) => others[index].push(line),
            _ => {
                first.insert(key, kept.len());
                kept.push(error);
                others.push(Vec::new());
            }
        }
    }
    for (note, lines) in kept.iter_mut().zip(others) {
        let named: Vec<String> = lines.iter().take(NAMED).map(usize::to_string).collect();
        let more = match (lines.len(), lines.last()) {
            (0, _) => continue,
            (1, _) => format!("; line {} likewise", named.join(", ")),
            (count, _) if count <= NAMED => format!("; lines {} likewise", named.join(", ")),
            (count, Some(last)) => {
                format!("; {count} more lines likewise ({}, …, {last})", named.join(", "))
            }
            (_, None) => continue,
        };
        note.what.push_str(&more);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notes::Place;

    #[test]
    fn lines_that_are_wrong_alike_are_one_error() {
        let at = |line, what: &str| {
            Note::error(Code::Motion, Place { line: Some(line), ..Place::default() }, what)
        };
        let found = grouped(vec![at(1, "a"), at(2, "b"), at(3, "a"), at(4, "b"), at(5, "b")]);
        let told: Vec<(usize, &str)> =
            found.iter().map(|note| (note.place.line.unwrap(), note.what.as_str())).collect();
        assert_eq!(told, [(1, "a; line 3 likewise"), (2, "b; lines 4, 5 likewise")]);
        let fifty = grouped((1..=50).map(|line| at(line, "a")).collect());
        assert_eq!(fifty.len(), 1);
        assert_eq!(fifty[0].what, "a; 49 more lines likewise (2, 3, 4, 5, …, 50)");
    }
}
