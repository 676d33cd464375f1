//! Closed forms, properties and plain scans: model, path, crossings, advice, identification, programs.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests stop where they fail"
)]

#[path = "../common/planar_arm.rs"]
mod planar_arm;
#[path = "../common/random_robot.rs"]
mod random_robot;
#[path = "../common/share.rs"]
mod share;
#[path = "../common/two_link.rs"]
mod two_link;
#[path = "../common/vibration.rs"]
mod vibration;

mod advice;
mod advice_schedule;
mod allocation;
mod arms;
mod assumed_mass;
mod beam;
mod crossings;
mod free_vibration;
mod identify;
mod identify_bands;
mod identify_friction;
mod identify_given;
mod identify_instrument;
mod identify_notices;
mod identify_random;
mod identify_recorders;
mod identify_traps;
mod maps;
mod model_properties;
mod paper;
mod path;
mod programs;
mod stability;
mod stability_along;
mod surface;
mod survey;
mod tracking;
