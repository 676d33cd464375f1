//! Programs read as a planner's tools write them: exact poses, lines, refusals.
//!
//! Expected poses are worked out by hand from the frames in the programs, never by the reader.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests stop where they fail"
)]

#[cfg(test)]
mod programs {
    mod apt;
    mod fuzz;
    mod gcode;
    mod rapid;
    mod refusals;
    mod support;
}
