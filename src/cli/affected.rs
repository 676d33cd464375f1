//! `detune affected`: changed files in, the jobs that they are about out.

use std::io::Write;
use std::path::PathBuf;
use std::time::SystemTime;

use clap::{Arg, Args};

use super::check::{CheckOptions, check};
use super::output::Sink;
use super::{Failure, Outcome, Samples, Warnings};
use crate::study::affected::affected;
use crate::study::job_files;
use crate::units::Date;
use crate::wording::printable;

const AFTER_HELP: &str = "\
Examples:
  detune affected robots/irb1600/robot.yaml jobs/contour.mod --jobs jobs
  git diff --name-only --relative -z main | xargs -0 -r detune affected --check
  detune affected jobs/contour.mod --check --fail-on uncertain --format github

A job is affected by its own file, by its robot and URDF, its programs and its detune.toml, also \
where one of them is gone; by any file while it cannot be read, and by a file in a folder that is \
not there.";

/// List the jobs that changed files affect, or check them.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP, mut_args(of_check))]
pub(super) struct AffectedArgs {
    /// Files that were changed, added or deleted.
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Where the jobs are: files, folders or patterns; may be repeated.
    #[arg(long, value_name = "JOB", default_value = ".")]
    jobs: Vec<PathBuf>,
    /// End each name with a NUL byte instead of a line end, as `xargs -0` reads them.
    #[arg(long, short = '0', conflicts_with = "check")]
    null: bool,
    /// Check the jobs, as `detune check` does, instead of listing them.
    #[arg(long)]
    check: bool,
    #[command(flatten, next_help_heading = "Options of --check")]
    how: CheckOptions,
}

/// What `check` takes is for `--check` alone.
fn of_check(arg: Arg) -> Arg {
    match arg.get_id().as_str() {
        "files" | "jobs" | "null" | "check" => arg,
        _ => arg.requires("check"),
    }
}

/// Writes the names of the jobs, or checks them.
pub(super) fn run(
    args: &AffectedArgs,
    samples: Samples,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let jobs = job_files(&args.jobs)?;
    let (jobs, nowhere) = affected(&jobs, &args.files, Date::of(SystemTime::now()));
    shown.show(&nowhere);
    if args.check {
        return match jobs.is_empty() {
            true => Ok(Outcome::Pass),
            false => check(&jobs, &args.how, samples, out, shown),
        };
    }
    let mut text = Vec::new();
    for job in &jobs {
        if args.null {
            text.extend(job.as_os_str().as_encoded_bytes());
            text.push(0);
        } else {
            text.extend(printable(&job.to_string_lossy()).bytes());
            text.push(b'\n');
        }
    }
    Sink::Standard.write_bytes(&text, out)?;
    Ok(Outcome::Pass)
}
