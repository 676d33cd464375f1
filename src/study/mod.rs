//! One module a verb: from valid inputs to a result that holds everything that any renderer shows, and what is to
//! be written back. What a command line, a Python module or a server needs of detune, and nothing of how it is shown.

pub mod advise;
mod calibration;
pub mod check;
pub mod diagnose;
pub mod identify;
pub mod map;
pub mod stiffness;

use std::path::{Path, PathBuf};

/// JSON Schemas of the files that people write.
pub use crate::input::schema as input_schema;

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
