//! One operation of a checked job, with the job.

use std::path::PathBuf;

use crate::report::paths;
use crate::risk::OperationRisk;
use crate::study::check::CheckedJob;

/// One operation of a checked job.
#[derive(Debug, Clone, Copy)]
pub(super) struct CheckedOperation<'a> {
    pub(super) job: &'a CheckedJob,
    pub(super) risk: &'a OperationRisk,
}

impl CheckedOperation<'_> {
    /// The file that the lines of the crossings refer to, seen from where the caller stands.
    pub(super) fn lines_file(&self) -> PathBuf {
        match &self.risk.program {
            Some(program) => paths::beside(&self.job.file, program),
            None => crate::paths::tidied(&self.job.file),
        }
    }
}

/// The operations of a job in order.
pub(super) fn operations(job: &CheckedJob) -> impl Iterator<Item = CheckedOperation<'_>> {
    job.risk.operations.iter().map(move |risk| CheckedOperation { job, risk })
}
