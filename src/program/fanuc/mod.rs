//! Fanuc TP programs (.ls) → motions.
//!
//! Read: J, L, C and A to P[] and PR[], positions in both layouts as poses or joints, speeds in
//! mm/sec, cm/min, inch/min, deg/sec, %, sec and registers, WAIT, R[] and PR[] with arithmetic,
//! LPOS and JPOS, numbers that registers give, FOR, IF, SELECT, JMP, CALL by name. User frames and
//! tools are the job's, by number; frame 0 is the robot's base frame. The third joint of most Fanuc
//! arms counts from the horizontal, so it is J3 + J2 in the robot's description; the job says so.
//! The arm configuration follows from the start of the path; a J that asks for another one by
//! CONFIG is an error.

mod arcs;
mod assign;
mod examine;
mod expressions;
mod flow;
mod frames;
mod hints;
mod motion;
mod open;
mod others;
mod pace;
mod position;
mod programs;
mod registers;
mod run;
mod shifts;
mod text;
mod vision;
mod why;
mod words;

use self::examine::examine;
use self::programs::Programs;
use super::Settings;
use super::log::Log;

/// Reads a TP program into the log.
pub(super) fn read(text: &str, settings: &Settings, log: &mut Log) {
    let programs = Programs::of(text, &settings.companions);
    if examine(programs.main(), |line| line, settings, log) {
        let mut run = run::Run::new(&programs, settings, log);
        run.given_on = hints::given_on(&programs, settings);
        run.run();
    }
}
