//! What a check found, as text, JSON, SARIF, JUnit XML and GitHub annotations.

mod findings;
pub mod github;
pub mod json;
pub mod junit;
mod operation;
pub mod plot_text;
pub mod sarif;
mod sentences;
pub mod text;

use super::CheckedJob;
use crate::risk::Verdict;

/// The worst verdict of several jobs; clear if there is none.
pub fn verdict(jobs: &[CheckedJob]) -> Verdict {
    jobs.iter().map(|job| job.risk.verdict).max().unwrap_or(Verdict::Clear)
}
