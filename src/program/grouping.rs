//! Errors that say the same of several lines, or of one line with other numbers → one, with their
//! number.

use std::collections::HashMap;

use crate::notes::{Code, Note};

/// The first of each kind, with how many more there are.
pub(super) fn grouped(errors: Vec<Note>) -> Vec<Note> {
    /// Lines that are named beside the first.
    const NAMED: usize = 4;
    let mut kept: Vec<Note> = Vec::new();
    let mut others: Vec<Vec<usize>> = Vec::new();
    let mut alike: Vec<usize> = Vec::new();
    let mut first: HashMap<(Code, String), usize> = HashMap::new();
    let mut of_line: HashMap<(Code, usize, String), usize> = HashMap::new();
    for error in errors {
        let key = (error.code, error.what.clone());
        if let (Some(&index), Some(line)) = (first.get(&key), error.place.line) {
            others[index].push(line);
            continue;
        }
        if let Some(line) = error.place.line {
            let key = (error.code, line, without_numbers(&error.what));
            if let Some(&index) = of_line.get(&key) {
                alike[index] += 1;
                continue;
            }
            of_line.insert(key, kept.len());
        }
        first.insert(key, kept.len());
        kept.push(error);
        others.push(Vec::new());
        alike.push(0);
    }
    for (note, more) in kept.iter_mut().zip(alike).filter(|(_, more)| *more > 0) {
        let differ = if more == 1 { "differs" } else { "differ" };
        let more = format!("; {more} more of this line {differ} from it in numbers alone");
        note.what.push_str(&more);
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

/// A text with one mark for every row of digits.
fn without_numbers(text: &str) -> String {
    let mut found = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '0'..='9' if found.ends_with('#') => {}
            '0'..='9' => found.push('#'),
            c => found.push(c),
        }
    }
    found
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
        let found = grouped(vec![at(1, "x is 10"), at(1, "x is 9"), at(2, "x is 9"), at(1, "y")]);
        let told: Vec<&str> = found.iter().map(|note| note.what.as_str()).collect();
        let first = "x is 10; 1 more of this line differs from it in numbers alone";
        assert_eq!(told, [first, "x is 9", "y"]);
        let fifty = grouped((1..=50).map(|line| at(line, "a")).collect());
        assert_eq!(fifty.len(), 1);
        assert_eq!(fifty[0].what, "a; 49 more lines likewise (2, 3, 4, 5, …, 50)");
    }
}
