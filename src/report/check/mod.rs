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
