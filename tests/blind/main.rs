//! Effects that a truth of its own hides from the diagnosis, and that truth against itself.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests stop where they fail"
)]

#[path = "../common/share.rs"]
mod share;

mod coverage;
mod hidden_chain;
mod hidden_effects;
mod real;
mod truth;
mod truth_effects;
mod truth_itself;
