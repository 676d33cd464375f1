//! Notes as they come up.

use std::collections::HashSet;

use super::{Code, Note, Part, Place, Severity};

/// More errors than this from one source help nobody; the rest are counted.
const MAX_ERRORS: usize = 200;

/// Errors and warnings from one source, each once.
#[derive(Debug, Clone, Default)]
pub struct Notes {
    origin: Place,
    list: Vec<Note>,
    seen: HashSet<Note>,
    errors: usize,
}

impl Notes {
    /// Notes that stand in a file, or are about a part, unless they say otherwise.
    pub fn about(origin: Place) -> Self {
        Self { origin, ..Self::default() }
    }

    /// A note at a line of the origin, without keeping it.
    pub fn make(
        &self,
        severity: Severity,
        code: Code,
        line: impl Into<Option<usize>>,
        what: impl Into<String>,
    ) -> Note {
        let place = Place { line: line.into(), ..self.origin.clone() };
        Note { place, code, severity, what: what.into() }
    }

    /// Something is wrong at a line of the origin. The same error of the same line is kept once.
    pub fn error(&mut self, code: Code, line: impl Into<Option<usize>>, what: impl Into<String>) {
        let note = self.make(Severity::Error, code, line, what);
        self.push(note);
    }

    /// Something at a line of the origin should be known.
    pub fn warning(&mut self, code: Code, line: impl Into<Option<usize>>, what: impl Into<String>) {
        let note = self.make(Severity::Warning, code, line, what);
        self.push(note);
    }

    /// Something about a channel of the record that these notes are about should be known.
    pub fn channel_warning(&mut self, code: Code, channel: &str, what: impl Into<String>) {
        let record = match &self.origin.part {
            Some(Part::Record(name)) => Some(name.clone()),
            _ => None,
        };
        let channel = Part::Channel { record, channel: channel.to_owned() };
        let place = Place { part: Some(channel), ..self.origin.clone() };
        self.push(Note::warning(code, place, what));
    }

    /// Keeps a note, unless it is here already; errors beyond a limit are only counted.
    pub fn push(&mut self, note: Note) {
        if note.severity == Severity::Error {
            if self.is_full() {
                self.errors += 1;
                return;
            }
            self.errors += usize::from(!self.seen.contains(&note));
        }
        if self.seen.insert(note.clone()) {
            self.list.push(note);
        }
    }

    /// Number of errors, those included that are only counted.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// Whether further errors are only counted.
    pub fn is_full(&self) -> bool {
        self.errors >= MAX_ERRORS
    }

    /// What was kept, in the order found.
    pub fn list(&self) -> &[Note] {
        &self.list
    }

    /// Errors and warnings apart, each by line; the last error counts those that were not kept.
    pub fn finish(mut self) -> (Vec<Note>, Vec<Note>) {
        self.list.sort_by_key(|note| note.place.line);
        if self.errors > MAX_ERRORS {
            let what = format!("and {} more", self.errors - MAX_ERRORS);
            let rest = self.make(Severity::Error, Code::More, None, what);
            self.list.push(rest);
        }
        self.list.into_iter().partition(|note| note.severity == Severity::Error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_come_by_line_each_once_and_the_flood_is_counted() {
        let mut notes = Notes::about(Place::file("x.yaml"));
        notes.error(Code::Value, 7, "second");
        notes.warning(Code::Unused, 5, "beside");
        notes.error(Code::Value, 3, "first");
        notes.error(Code::Value, 7, "second");
        assert_eq!(notes.errors(), 2);
        let (errors, warnings) = notes.finish();
        let shown = |notes: &[Note]| notes.iter().map(Note::to_string).collect::<Vec<_>>();
        assert_eq!(shown(&errors), ["x.yaml:3: first", "x.yaml:7: second"]);
        assert_eq!(shown(&warnings), ["x.yaml:5: beside"]);

        let mut flood = Notes::about(Place::file("x.yaml"));
        (1..=MAX_ERRORS + 5).for_each(|line| flood.error(Code::Value, line, "bad"));
        let (errors, _) = flood.finish();
        assert_eq!(errors.len(), MAX_ERRORS + 1);
        assert_eq!(errors[MAX_ERRORS].to_string(), "x.yaml: and 5 more");
    }
}
