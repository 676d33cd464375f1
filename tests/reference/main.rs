//! Against what others computed: Pinocchio, mpmath, another inverse kinematics, robots' data sheets.

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

mod batch;
mod exact;
mod inverse_kinematics;
mod pinocchio;
mod robots;
