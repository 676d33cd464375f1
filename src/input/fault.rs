//! A fault in a file, or a remark on it.

use std::fmt;
use std::path::PathBuf;

use crate::wording::printable;

/// What is wrong, and where.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fault {
    /// The file, as the caller or the file that refers to it names it; `None` for the command line.
    pub file: Option<PathBuf>,
    /// Counted from 1; `None` where the fault is the file's as a whole.
    pub line: Option<usize>,
    /// Key path, what was read, what was expected, what to do: a lower-case fragment.
    pub what: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.file, self.line) {
            (Some(file), Some(line)) => {
                write!(f, "{}:{line}: ", printable(&file.to_string_lossy()))?
            }
            (Some(file), None) => write!(f, "{}: ", printable(&file.to_string_lossy()))?,
            (None, _) => {}
        }
        // Values and names of the user's stand in the text.
        f.write_str(&printable(&self.what))
    }
}

impl std::error::Error for Fault {}
