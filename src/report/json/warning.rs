//! Warnings on jobs, as check and advise have them.

use schemars::JsonSchema;
use serde::Serialize;

use crate::job::Accepted;
use crate::risk;

/// A warning on a job.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub(in crate::report) struct Warning<'a> {
    /// Of what kind; the guide lists them.
    code: &'static str,
    /// Whether a resonance may hide in it and nobody accepts that: the verdict is at best
    /// uncertain.
    hides_clear: bool,
    /// What is to be known, and where it stands.
    text: String,
    /// The operation that it is about; null for the job as a whole.
    operation: Option<&'a str>,
    /// Why it counts no more, where the job accepts it; else null.
    accepted: Option<&'a Accepted>,
}

impl<'a> From<&'a risk::Warning> for Warning<'a> {
    fn from(warning: &'a risk::Warning) -> Self {
        Self {
            code: warning.note.code.name(),
            hides_clear: warning.leaves_doubt(),
            text: warning.note.to_string(),
            operation: warning.operation.as_deref(),
            accepted: warning.accepted.as_ref(),
        }
    }
}

/// Their texts, each once.
pub(in crate::report) fn notices(warnings: &[risk::Warning]) -> Vec<String> {
    let mut texts: Vec<String> = warnings.iter().map(|warning| warning.note.to_string()).collect();
    texts.dedup();
    texts
}
