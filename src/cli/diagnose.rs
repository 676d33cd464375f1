//! `detune diagnose`: what a model gets wrong, and why.

use std::io::Write;
use std::path::PathBuf;
use std::time::SystemTime;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use super::output::{Sink, keep_apart, write_all};
use super::plots::{PlotsArgs, in_characters};
use super::{Failure, Outcome, Warnings};
use crate::notes::{Note, Place};
use crate::progress::Done;
use crate::report;
use crate::report::diagnosis::html::plots;
use crate::study::Read;
use crate::study::diagnose::{Settings, diagnose, read};
use crate::units::Date;

/// Steps of the progress bar.
const STEPS: u64 = 100;

/// Find what is wrong in a robot model, with the evidence, and what to measure next.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    detune diagnose robots/two-link robots/two-link/measured.csv\n  \
    detune diagnose robot.yaml measured.csv --write calibrated.yaml\n  \
    detune diagnose robot.yaml measured.csv --format html --output diagnosis.html\n\n\
    The verdict never changes the exit code: 0 unless a file is wrong or holds too little data \
    (2).")]
pub(super) struct DiagnoseArgs {
    /// A robot.yaml, or the folder that holds one.
    robot: PathBuf,
    /// Table of measured natural frequencies, one row per pose.
    #[arg(value_name = "MEASURED.csv")]
    measured: PathBuf,
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Write to this file instead of standard output (`-`); a run that fails leaves it unchanged.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    plots: PlotsArgs,
    /// Write the robot's file with the findings as corrections, and the calibration.
    #[arg(long, value_name = "ROBOT2.yaml")]
    write: Option<PathBuf>,
    /// Seed of cross-validation and resampling: the same seed gives the same output on the same
    /// kind of machine.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Readable text.
    Text,
    /// JSON; `detune schema diagnosis` describes it.
    Json,
    /// HTML page with plots.
    Html,
    /// Plots with characters, for a terminal.
    Plot,
}

/// Diagnoses, writes the result, then the robot's file.
pub(super) fn run(
    args: &DiagnoseArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let robot_sink = args.write.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    keep_apart(&[
        ("--output", Some(&sink), args.output.as_deref()),
        ("--write", robot_sink.as_ref(), args.write.as_deref()),
    ])?;
    let robot_file = super::robot_file(&args.robot);
    let Read { value: measured, warnings, files } = read(&robot_file, &args.measured);
    for sink in std::iter::once(&sink).chain(&robot_sink) {
        sink.refuse_inputs(&files)?;
    }
    shown.show(&warnings);
    let measured = measured?;
    let bar = shown.bar(progress());
    let settings = Settings { seed: args.seed };
    let diagnosed = diagnose(&measured, &args.measured, settings, &|done| {
        if let Done::Share(share) = done {
            bar.set_position((share * STEPS as f64) as u64);
        }
    });
    bar.finish_and_clear();
    let diagnosed = diagnosed?;
    shown.show(&diagnosed.notes);
    let text = match args.format {
        Format::Text => report::diagnosis::text::diagnosis(&diagnosed),
        Format::Json => report::diagnosis::json::diagnosis(&diagnosed)
            .map_err(|error| Failure::Internal(error.to_string()))?,
        Format::Plot => in_characters(&plots(&diagnosed.diagnosis), &sink),
        Format::Html => report::diagnosis::html::diagnosis(&diagnosed)
            .map_err(|error| Failure::Internal(error.to_string()))?,
    };
    let update = &diagnosed.update;
    let date = Date::of(SystemTime::now()).to_string();
    let written = match &args.write {
        Some(path) => Some(update.output(&robot_file, path, &date)?),
        None => None,
    };
    let mut outputs: Vec<(&Sink, &[u8])> = vec![(&sink, text.as_bytes())];
    if let (Some(sink), Some(written)) = (&robot_sink, &written) {
        let in_file = |note: &Note| Note { place: Place::file(&written.path), ..note.clone() };
        shown.show(&update.notes.iter().map(in_file).collect::<Vec<_>>());
        outputs.push((sink, &written.bytes));
    }
    let plots = args.plots.files(|| plots(&diagnosed.diagnosis))?;
    outputs.extend(plots.iter().map(|(sink, svg)| (sink, svg.as_bytes())));
    write_all(&outputs, out)?;
    Ok(Outcome::Pass)
}

/// Shown on standard error while that is a terminal, and nowhere else.
fn progress() -> ProgressBar {
    let bar = ProgressBar::new(STEPS);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent} % diagnosed, {elapsed}") {
        bar.set_style(style);
    }
    bar
}
