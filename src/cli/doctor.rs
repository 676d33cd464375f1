//! `detune doctor`: a robot in, its doubts and frequencies out.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;

use super::output::Sink;
use super::{Failure, Outcome, Warnings};
use crate::report::doctor::examination;
use crate::study::Read;
use crate::study::doctor::examine;

/// Examine a robot model: doubts, and its natural frequencies beside those of measured arms.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  detune doctor robots/irb1600\n\n\
    Exit codes: 0 the robot can be read, 1 with --deny-warnings where there are warnings, 2 a file \
    is wrong, 3 an internal error.")]
pub(super) struct DoctorArgs {
    /// A robot.yaml, or the folder that holds one.
    robot: PathBuf,
}

/// Writes the examination; where a file is wrong, reports all errors.
pub(super) fn run(
    args: &DoctorArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let Read { value, warnings, .. } = examine(&super::robot_file(&args.robot));
    let found = value.inspect_err(|_| shown.show(&warnings))?;
    shown.shown_elsewhere(&found.warnings);
    Sink::Standard.write(&examination(&found), out)?;
    Ok(Outcome::Pass)
}
