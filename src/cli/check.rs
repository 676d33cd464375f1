//! `detune check`: jobs in, verdict out.

use std::env;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::SystemTime;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use super::output::{Sink, write_all};
use super::plots::{PlotsArgs, in_characters};
use super::repository;
use super::{Failure, Outcome, Warnings};
use crate::notes::Note;
use crate::progress::Done;
use crate::report;
use crate::report::check::github::note_annotation;
use crate::report::job::JobPage;
use crate::study::arm::{MovingArm, moving_arm};
use crate::study::check::{self as study, Checked, CheckedJob, Gate, ReadJobs, Verdict};
use crate::study::report::Meshes;
use crate::study::{PolicyOverrides, job_files};
use crate::units::Date;

const AFTER_HELP: &str = "\
Examples:
  detune check jobs/pocket.yaml
  detune check --format json --samples none jobs | jq .verdict
  detune check jobs --policy separation_percent=8 --summary
  detune check --format junit --output detune.xml --fail-on uncertain jobs/*.yaml

Exit codes: 0 passes, 1 fails, 2 a file or the command line is wrong, 3 an internal error.
The format of the output never changes the exit code.";

/// Predict whether jobs excite resonances of the arm that runs them, where, and by what.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct CheckArgs {
    /// Job files; folders, for the jobs in and below them; patterns such as 'jobs/**/*.yaml'.
    #[arg(value_name = "JOB", required = true)]
    jobs: Vec<PathBuf>,
    #[command(flatten)]
    how: CheckOptions,
}

/// What fails, and what is written where; `affected --check` takes the same.
#[derive(Debug, Args)]
pub(super) struct CheckOptions {
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Write to this file instead of standard output (`-`); a run that fails leaves it unchanged.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    plots: PlotsArgs,
    /// What fails (exit code 1): resonance (and unchecked), uncertain, probability=P (from 0 to 1)
    /// or never.
    #[arg(long, value_name = "WHAT", value_parser = gate, default_value = "resonance")]
    fail_on: Gate,
    /// A key of the policy, which wins over the job and detune.toml; may be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    policy: Vec<String>,
    /// Text: one page, with the worst jobs, instead of each job in full.
    #[arg(long, value_enum, value_name = "WHEN", num_args = 0..=1, require_equals = true,
        default_value_t = Summary::Auto, default_missing_value = "always")]
    summary: Summary,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Summary {
    /// Of more than 8 jobs.
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Readable text.
    Text,
    /// JSON; `detune schema check` describes it.
    Json,
    /// SARIF 2.1.0, for code scanners and editors.
    Sarif,
    /// JUnit XML, for build servers.
    Junit,
    /// Workflow commands, which GitHub shows as annotations.
    Github,
    /// A page to look at: the arm with its modes along the path, plots, tables.
    Html,
    /// GitLab's code quality report.
    Gitlab,
    /// Plots with characters, for a terminal.
    Plot,
}

/// Checks the jobs that the arguments mean.
pub(super) fn run(
    args: &CheckArgs,
    samples: super::Samples,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    check(&job_files(&args.jobs)?, &args.how, samples, out, shown)
}

/// Checks all jobs and writes one report; if some file is wrong, reports all errors of all jobs and
/// writes nothing.
pub(super) fn check(
    files: &[PathBuf],
    args: &CheckOptions,
    samples: super::Samples,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let policy = PolicyOverrides::parse(&args.policy)?;
    sink.refuse_inputs(files)?;
    let jobs = ReadJobs::read_under(files, Date::of(SystemTime::now()), &policy);
    sink.refuse_inputs(jobs.files())?;
    let bar = progress(shown);
    let progress = count_on(&bar);
    let (checked, arms) = match args.format {
        Format::Html => {
            let meshes = Meshes::default();
            jobs.check_with(&progress, |job, checked| moving_arm(job, checked, &meshes))
        }
        _ => (jobs.check(&progress), Vec::new()),
    };
    let Checked { mut jobs, warnings, errors } = checked;
    bar.finish_and_clear();
    shown.show_of_jobs(&warnings);
    if args.format == Format::Github {
        // The output has those that take part in a verdict.
        let remarks = warnings.iter().filter(|w| w.accepted.is_none());
        let remarks = remarks.filter(|w| w.best_verdict() == Verdict::Clear || !errors.is_empty());
        annotate(remarks.map(|warning| &warning.note));
        annotate(&errors);
    }
    if !errors.is_empty() {
        return Err(errors.into());
    }
    let has_failed = args.fail_on.fails_any(&jobs);
    let plots = args.plots.files(|| report::job::check_plots(&jobs))?;
    if args.format == Format::Json {
        samples.kept().keep(&mut jobs);
    }
    let text = rendered(&jobs, &arms, args, &sink)?;
    let mut outputs: Vec<(&Sink, &[u8])> = vec![(&sink, text.as_bytes())];
    outputs.extend(plots.iter().map(|(sink, svg)| (sink, svg.as_bytes())));
    write_all(&outputs, out)?;
    Ok(if has_failed { Outcome::Fail } else { Outcome::Pass })
}

impl super::Samples {
    fn kept(self) -> study::Samples {
        match self {
            Self::All => study::Samples::All,
            Self::Thin => study::Samples::Thin,
            Self::None => study::Samples::None,
        }
    }
}

/// What `--fail-on` says.
fn gate(text: &str) -> Result<Gate, String> {
    match text {
        // What was not checked is worse than what is uncertain.
        "resonance" => Ok(Gate::From(Verdict::Unchecked)),
        "uncertain" => Ok(Gate::From(Verdict::Uncertain)),
        "never" => Ok(Gate::Never),
        _ => text
            .strip_prefix("probability=")
            .and_then(|p| p.parse().ok())
            .filter(|p| *p > 0.0 && *p <= 1.0)
            .map(Gate::Probability)
            .ok_or_else(|| {
                "must be resonance, uncertain, never or probability=P with P above 0 and at most 1"
                    .to_owned()
            }),
    }
}

fn rendered(
    jobs: &[CheckedJob],
    arms: &[MovingArm],
    args: &CheckOptions,
    sink: &Sink,
) -> Result<String, Failure> {
    let internal = |error: &dyn std::fmt::Display| Failure::Internal(error.to_string());
    let root = env::current_dir().unwrap_or_default();
    match args.format {
        Format::Text => {
            let is_page = match args.summary {
                Summary::Auto => jobs.len() > report::check::page::MAX_IN_FULL,
                Summary::Always => true,
                Summary::Never => false,
            };
            let renderer =
                if is_page { report::check::page::page } else { report::check::text::check };
            Ok(renderer(jobs, sink.shows_colour()))
        }
        Format::Json => report::check::json::check(jobs).map_err(|error| internal(&error)),
        Format::Sarif => report::check::sarif::check(jobs, &root, &repository::named)
            .map_err(|error| internal(&error)),
        Format::Gitlab => {
            report::check::gitlab::check(jobs, &repository::named).map_err(|error| internal(&error))
        }
        Format::Junit => {
            report::check::junit::check(jobs, args.fail_on).map_err(|error| internal(&error))
        }
        Format::Github => Ok(report::check::github::check(jobs, &root)),
        Format::Html => {
            let page = |(checked, moving)| JobPage { checked, advised: None, moving };
            let pages: Vec<JobPage> = jobs.iter().zip(arms).map(page).collect();
            report::job::jobs(&pages).map_err(|error| internal(&error))
        }
        Format::Plot => {
            let plots = in_characters(&report::job::check_plots(jobs), sink);
            Ok(report::job::head_of_plots(jobs) + &plots)
        }
    }
}

/// Counts poses on standard error while it is a terminal, and shows nothing elsewhere.
pub(super) fn progress(shown: &Warnings) -> ProgressBar {
    let progress = shown.bar(ProgressBar::new_spinner());
    if let Ok(style) =
        ProgressStyle::with_template("{spinner} {human_pos} poses checked, {elapsed}")
    {
        progress.set_style(style);
    }
    progress
}

/// Counts the poses of a study on a progress bar.
pub(super) fn count_on(bar: &ProgressBar) -> impl Fn(Done) + Sync {
    |done| {
        if let Done::More(poses) = done {
            bar.inc(u64::try_from(poses).unwrap_or(u64::MAX));
        }
    }
}

/// Workflow commands for what is on standard error in words, too: GitHub reads them there as well.
fn annotate<'n>(notes: impl IntoIterator<Item = &'n Note>) {
    let root = env::current_dir().unwrap_or_default();
    let mut lines: Vec<String> = Vec::new();
    for note in notes {
        let line = note_annotation(note, &root);
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    let mut err = io::stderr().lock();
    for line in lines {
        // If standard error is closed, nobody reads it.
        let _ = writeln!(err, "{line}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fails_is_what_was_asked_for() {
        use Verdict::{Clear, Resonance, Uncertain, Unchecked};
        for (text, fails) in [
            ("resonance", [false, false, true, true]),
            ("uncertain", [false, true, true, true]),
            ("never", [false; 4]),
            // Where a line rings with a probability of 0.04.
            ("probability=0.05", [false, false, true, false]),
            ("probability=0.04", [true; 4]),
        ] {
            let gate = gate(text).unwrap();
            let verdicts = [Clear, Uncertain, Unchecked, Resonance];
            assert_eq!(verdicts.map(|verdict| gate.fails(verdict, 0.04, false)), fails, "{text}");
            // A limit that is exceeded counts like a resonance, whatever the probability.
            assert_eq!(gate.fails(Resonance, 0.0, true), text != "never", "{text}");
        }
        for wrong in ["probability=0", "probability=1.5", "probability=NaN", "clear"] {
            assert!(gate(wrong).is_err(), "{wrong}");
        }
    }
}
