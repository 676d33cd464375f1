//! A fault in a file, or a remark on it.

use std::fmt;
use std::path::PathBuf;

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
            (Some(file), Some(line)) => write!(f, "{}:{line}: {}", file.display(), self.what),
            (Some(file), None) => write!(f, "{}: {}", file.display(), self.what),
            (None, _) => write!(f, "{}", self.what),
        }
    }
}

impl std::error::Error for Fault {}
