//! The command line: one file a verb. The only place that names clap, prints, writes files and shows
//! progress.

use std::io;

use crate::input::Fault;

/// How a verb ended, if nothing was wrong with what it was given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Pass,
    /// Exit code 1: the job fails its policy.
    Fail,
}

/// Why a verb could not do its work.
#[derive(Debug)]
pub enum Failure {
    /// Exit code 2: files or command line are wrong.
    Input(Vec<Fault>),
    /// Exit code 2: an output could not be written (a closed pipe on standard output ends quietly).
    Output(io::Error),
    /// Exit code 3: a fault of the program itself.
    Internal(String),
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

impl From<Vec<Fault>> for Failure {
    fn from(faults: Vec<Fault>) -> Self {
        Self::Input(faults)
    }
}
