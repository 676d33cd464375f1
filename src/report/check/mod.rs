//! What a check found, as text, JSON, SARIF, JUnit XML and GitHub annotations.

pub(super) mod findings;
pub mod github;
pub mod json;
pub mod junit;
pub(super) mod operation;
pub mod plot_text;
pub mod sarif;
pub(super) mod sentences;
pub mod text;
