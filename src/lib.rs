//! x

pub mod cli;
pub mod excitation;
pub mod free_vibration;
pub mod input;
pub mod job;
pub mod measured;
pub mod model;
pub mod modes;
pub mod motion;
pub mod path;
pub mod program;
pub mod report;
pub mod risk;
pub mod units;
