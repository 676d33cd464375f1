//! One module a verb: from valid inputs to a result that holds everything that any renderer shows,
//! and what is to be written back. What a command line, a Python module or a server needs of
//! detune, and nothing of how it is shown.

pub mod advise;
pub mod affected;
pub mod arm;
mod calibration;
pub mod check;
pub mod cutting;
pub mod deflection;
pub mod diagnose;
pub mod doctor;
pub mod explain;
pub mod identify;
pub mod init;
pub mod lobes;
pub mod map;
pub mod report;
pub mod stiffness;
pub mod trace;

use std::path::{Path, PathBuf};

use crate::input::Reading;
/// JSON Schemas of the files that people write.
pub use crate::input::schema as input_schema;
/// Keys of the policy that a run sets, and the job files that its arguments name.
pub use crate::input::{PolicyOverrides, is_one_file, job_files};
use crate::notes::{Code, Note, Place};

/// What is said where a file was refused without an error.
const NO_REASON: &str = "a file was refused, and detune does not know why: please report this";

/// What came of reading files.
#[derive(Debug)]
pub struct Read<T> {
    /// The valid value, or every error in the files.
    pub value: Result<T, Vec<Note>>,
    /// Warnings, also where there are errors.
    pub warnings: Vec<Note>,
    /// The files that were read, or were to be read: nothing may be written over them.
    pub files: Vec<PathBuf>,
}

impl<T> Read<T> {
    fn of(read: impl FnOnce(&mut Reading) -> Result<T, Vec<Note>>) -> Self {
        let mut reading = Reading::default();
        let value = read(&mut reading).map_err(|errors| match errors.is_empty() {
            // An empty list would pass for success where errors are counted.
            true => vec![Note::error(Code::Unreadable, Place::default(), NO_REASON)],
            false => errors,
        });
        Self { value, warnings: reading.warnings, files: reading.files }
    }
}

/// A file that is to be written: complete, read back and compared with what was asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Output {
    /// Where.
    pub path: PathBuf,
    /// All of it.
    pub bytes: Vec<u8>,
}

impl Output {
    /// Some bytes for a file.
    pub fn new(path: &Path, bytes: Vec<u8>) -> Self {
        Self { path: path.to_owned(), bytes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_refused_has_a_reason() {
        let read = Read::<()>::of(|_| Err(Vec::new()));
        assert_eq!(read.value.unwrap_err().len(), 1);
    }
}
