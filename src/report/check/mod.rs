//! What a check found, as text, JSON, SARIF, JUnit XML, GitHub annotations and GitLab's report.

pub(super) mod cut;
pub(super) mod findings;
pub mod github;
pub mod gitlab;
mod identity;
pub mod json;
pub mod junit;
pub(super) mod operation;
pub mod page;
pub mod plot_text;
pub mod sarif;
pub(super) mod sentences;
pub mod text;
