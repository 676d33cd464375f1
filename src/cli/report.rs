//! `detune report`: a job in, a page to look at out.

use std::io::Write;
use std::path::PathBuf;
use std::time::SystemTime;

use clap::{Args, ValueEnum};

use super::check::{count_on, progress};
use super::output::Sink;
use super::{Failure, Outcome, Warnings};
use crate::report::job::{JobPage, jobs, jobs_json};
use crate::study::Read;
use crate::study::advise::read;
use crate::study::report::report;
use crate::units::Date;

const AFTER_HELP: &str = "\
Examples:
  detune report jobs/pocket.yaml --output report.html
  detune report jobs/pocket.yaml --format json --output report.json

The page needs no other file and no network. Exit codes: 0 written, 2 a file or the command \
line is wrong, 3 an internal error; the verdict does not change the exit code.";

/// Show a job as a page: verdict, advice, and the arm with its modes along the path.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct ReportArgs {
    /// Job file.
    #[arg(value_name = "JOB")]
    job: PathBuf,
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Html)]
    format: Format,
    /// Write to this file instead of standard output (`-`); a run that fails leaves it unchanged.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A page to look at.
    Html,
    /// The numbers of the page that check and advice do not have: the arm, and at places of each
    /// operation the shapes, the damping, the margin and the tool.
    Json,
}

/// Checks and advises one job; if some file is wrong, reports all errors and writes nothing.
pub(super) fn run(
    args: &ReportArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let Read { value: job, warnings, files } = read(&args.job, Date::of(SystemTime::now()));
    let job = job.inspect_err(|_| shown.show(&warnings))?;
    sink.refuse_inputs([&args.job])?;
    sink.refuse_inputs(&files)?;
    let bar = progress(shown);
    let reported = report(&job, &files, &count_on(&bar));
    bar.finish_and_clear();
    let reported = reported.inspect_err(|_| shown.show(&warnings))?;
    shown.show_of_jobs(&reported.advised.warnings);
    let page = [JobPage::from(&reported)];
    let text = match args.format {
        Format::Html => jobs(&page),
        Format::Json => jobs_json(&page),
    };
    let text = text.map_err(|error| Failure::Internal(error.to_string()))?;
    sink.write(&text, out)?;
    Ok(Outcome::Pass)
}
