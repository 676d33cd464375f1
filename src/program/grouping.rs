//! Errors that say the same of several lines, or of one line with other numbers → one, with their
//! number.

use std::collections::hash_map::{DefaultHasher, Entry};
use std::collections::{HashMap, HashSet};
use std::hash::{Hash, Hasher};

use crate::notes::{Code, Note};

/// Errors of lines by their texts without numbers: a loop may make thousands of one kind.
#[derive(Debug, Default)]
pub(super) struct Kinds(HashMap<(Code, usize, String), Kind>);

/// The first of a kind, and hashes of the others.
#[derive(Debug)]
struct Kind {
    first: String,
    others: HashSet<u64>,
}

impl Kinds {
    /// Whether an error is the first of its kind, or the same again.
    pub(super) fn is_first(&mut self, code: Code, line: usize, what: &str) -> bool {
        match self.0.entry((code, line, without_numbers(what))) {
            Entry::Vacant(open) => {
                open.insert(Kind { first: what.to_owned(), others: HashSet::new() });
                true
            }
            Entry::Occupied(mut kind) if kind.get().first != what => {
                let mut hasher = DefaultHasher::new();
                what.hash(&mut hasher);
                kind.get_mut().others.insert(hasher.finish());
                false
            }
            Entry::Occupied(_) => true,
        }
    }

    /// How many others there are of the kind of a note.
    fn others_of(&self, note: &Note) -> usize {
        let line = note.place.line.unwrap_or(0);
        let kind = self.0.get(&(note.code, line, without_numbers(&note.what)));
        kind.map_or(0, |kind| kind.others.len())
    }
}

/// The first of each kind, with how many more there are.
pub(super) fn grouped(errors: Vec<Note>, kinds: &Kinds) -> Vec<Note> {
    /// Lines that are named beside the first.
    const NAMED: usize = 4;
    let mut kept: Vec<Note> = Vec::new();
    let mut others: Vec<Vec<usize>> = Vec::new();
    let mut alike: Vec<usize> = Vec::new();
    let mut first: HashMap<(Code, String, String), usize> = HashMap::new();
    for error in errors {
        // Of another file its own lines are named.
        let (file, line, what) = match placed(&error.what) {
            Some((file, line, what)) => (file, Some(line), what),
            None => ("", error.place.line, error.what.as_str()),
        };
        let key = (error.code, file.to_owned(), what.to_owned());
        if let (Some(&index), Some(line)) = (first.get(&key), line) {
            let is_same = |(_, own, _): (&str, usize, &str)| own == line;
            let is_told = !file.is_empty()
                && (placed(&kept[index].what).is_some_and(is_same)
                    || others[index].contains(&line));
            if !is_told {
                others[index].push(line);
            }
            continue;
        }
        first.insert(key, kept.len());
        alike.push(kinds.others_of(&error));
        kept.push(error);
        others.push(Vec::new());
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

/// The place in another file with which a text may begin, and what is told of it.
fn placed(text: &str) -> Option<(&str, usize, &str)> {
    let (place, what) = text.split_once(": ")?;
    let (file, line) = place.rsplit_once(':')?;
    Some((file, line.parse().ok()?, what))
}

/// A text with one mark for every row of digits behind its place.
fn without_numbers(text: &str) -> String {
    let what = placed(text).map_or(text, |(_, _, what)| what);
    let (place, what) = text.split_at(text.len() - what.len());
    let mut found = String::with_capacity(text.len());
    found.push_str(place);
    for c in what.chars() {
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
        let none = Kinds::default();
        let found =
            grouped(vec![at(1, "a"), at(2, "b"), at(3, "a"), at(4, "b"), at(5, "b")], &none);
        let told: Vec<(usize, &str)> =
            found.iter().map(|note| (note.place.line.unwrap(), note.what.as_str())).collect();
        assert_eq!(told, [(1, "a; line 3 likewise"), (2, "b; lines 4, 5 likewise")]);
        let mut kinds = Kinds::default();
        let all = [(1, "x is 10"), (1, "x is 9"), (2, "x is 9"), (1, "x is 9"), (1, "y")];
        let firsts = all.iter().filter(|(line, what)| kinds.is_first(Code::Motion, *line, what));
        let firsts = firsts.map(|(line, what)| at(*line, what)).collect();
        let found = grouped(firsts, &kinds);
        let told: Vec<&str> = found.iter().map(|note| note.what.as_str()).collect();
        let first = "x is 10; 1 more of this line differs from it in numbers alone";
        assert_eq!(told, [first, "x is 9", "y"]);
        let fifty = grouped((1..=50).map(|line| at(line, "a")).collect(), &none);
        assert_eq!(fifty.len(), 1);
        assert_eq!(fifty[0].what, "a; 49 more lines likewise (2, 3, 4, 5, …, 50)");
        // Of another file, which two lines of the main one lead to.
        let mut kinds = Kinds::default();
        let all = [(1, "b.mod:3: a"), (1, "b.mod:4: a"), (2, "b.mod:3: a"), (2, "b.mod:4: a")];
        let firsts = all.iter().filter(|(line, what)| kinds.is_first(Code::Motion, *line, what));
        let firsts = firsts.map(|(line, what)| at(*line, what)).collect();
        let found = grouped(firsts, &kinds);
        let told: Vec<&str> = found.iter().map(|note| note.what.as_str()).collect();
        assert_eq!(told, ["b.mod:3: a; line 4 likewise"]);
    }
}
