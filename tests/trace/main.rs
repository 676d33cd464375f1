//! Videos with known motion: rendered analytically, traced, identified.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests stop where they fail"
)]

#[path = "../common/vibration.rs"]
mod vibration;

mod accuracy;
mod arm;
mod command;
mod film;
