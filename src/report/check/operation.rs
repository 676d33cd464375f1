//! One operation of a checked job, with the job.

use std::path::PathBuf;

use crate::report::paths;
use crate::risk::OperationRisk;
use crate::study::check::CheckedJob;

/// One operation of a checked job.
#[derive(Debug, Clone, Copy)]
pub(in crate::report) struct CheckedOperation<'a> {
    pub(in crate::report) job: &'a CheckedJob,
    pub(in crate::report) risk: &'a OperationRisk,
}

impl CheckedOperation<'_> {
    /// The file that the lines of the crossings refer to, seen from where the caller stands.
    pub(in crate::report) fn lines_file(&self) -> PathBuf {
        match &self.risk.program {
            Some(program) => paths::beside(&self.job.file, program),
            None => crate::paths::tidied(&self.job.file),
        }
    }
}

/// The operations of a job in order.
pub(in crate::report) fn operations(
    job: &CheckedJob,
) -> impl Iterator<Item = CheckedOperation<'_>> {
    job.risk.operations.iter().map(move |risk| CheckedOperation { job, risk })
}
