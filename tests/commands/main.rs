//! The program as a user meets it: every verb, bad input, formats, schemas.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests stop where they fail"
)]

#[path = "../common/two_link.rs"]
mod two_link;
#[path = "../common/vibration.rs"]
mod vibration;

mod added_masses;
mod advise;
mod bad_input;
mod calibrated;
mod check;
mod corrections;
mod deflection;
mod diagnose;
mod doubts;
mod drilling;
mod first;
mod hard;
mod identify;
mod identify_records;
mod left_open;
mod lobes;
mod many;
mod map;
mod map_arrow;
mod map_command;
mod map_npy;
mod map_stream;
mod mode_shapes;
mod outside;
mod page;
mod parts;
mod plausibility;
mod program;
mod programs;
mod report;
mod report_odd;
mod schemas;
mod settings;
mod speed_change;
mod tool_tip;
mod uncertainty;
