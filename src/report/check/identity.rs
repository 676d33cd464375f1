//! What makes a finding the same finding in the next run, wherever that runs and however the
//! program was edited in between: no line and no number.

use std::path::{Path, PathBuf};

use super::findings::Finding;
use super::operation::CheckedOperation;
use crate::notes::Code;
use crate::report::{paths, words};
use crate::risk::Warning;
use crate::study::check::CheckedJob;
use crate::wording::printable;

/// Of what one mode and one line do in an operation.
pub(super) fn of_finding(
    operation: &CheckedOperation<'_>,
    finding: &Finding<'_>,
    home: &dyn Fn(&Path) -> PathBuf,
) -> String {
    [
        finding.rule().to_owned(),
        paths::uri(&home(&operation.job.file)),
        printable(&operation.risk.name),
        format!("mode {}", finding.mode),
        format!("{} {}", words::spelled(finding.line.source), finding.line.harmonic),
    ]
    .join("|")
}

/// Of a warning in which a resonance may hide.
pub(super) fn of_doubt(
    job: &CheckedJob,
    warning: &Warning,
    home: &dyn Fn(&Path) -> PathBuf,
) -> String {
    let rule = if warning.note.code == Code::NothingChecked { "unchecked" } else { "doubt" };
    let about = printable(warning.operation.as_deref().unwrap_or_default());
    [rule, &paths::uri(&home(&job.file)), &about, warning.note.code.name()].join("|")
}

/// Of what the run sets of the policy.
pub(super) fn of_policy(job: &CheckedJob, home: &dyn Fn(&Path) -> PathBuf) -> String {
    ["policy", &paths::uri(&home(&job.file))].join("|")
}

/// FNV-1a with 64 bits (Fowler, Noll, Vo): short, the same on every machine and in every version.
pub(super) fn digest(identity: &str) -> String {
    let hash = identity.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    format!("{hash:016x}")
}
