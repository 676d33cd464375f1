//! What the repository says about itself: the code map and the printed examples.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests stop where they fail"
)]

mod architecture;
mod circles;
mod code_map;
mod pages;
mod source;
