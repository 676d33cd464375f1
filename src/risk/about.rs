//! Notes with the place of an operation.

use crate::job::{Job, Operation};
use crate::notes::{Code, Note, Part, Place};

/// A note about moves of an operation, in the file that its line stands in: the program or the job.
pub fn in_operation(job: &Job, operation: &Operation, mut note: Note) -> Note {
    note.place.file = Some(job.file_of_moves(operation));
    note.within(Part::Operation(operation.name.clone()))
}

/// A warning about an operation as a whole, where it starts in the job.
pub fn about_operation(job: &Job, operation: &Operation, code: Code, what: String) -> Note {
    let part = Some(Part::Operation(operation.name.clone()));
    let place = Place { part, ..Place::line(&job.file, operation.line) };
    Note::warning(code, place, what)
}
