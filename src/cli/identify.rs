//! `detune identify`: raw records in, modes with their uncertainties out.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use super::output::{Sink, keep_apart, write_all};
use super::plots::{PlotsArgs, in_characters};
use super::{Failure, Outcome, Warnings};
use crate::progress::Done;
use crate::report::identify::{
    identification_drawing, identification_html, identification_json, identification_plots,
    identification_text, identification_uff, measured_csv,
};
use crate::study::Read;
use crate::study::identify::{identify, read};

const AFTER_HELP: &str = "\
A session names files of raw data (tables with a header, UFF 58 as text or binary, WAV, NPY, \
MAT) with the pose of each; `detune schema session` lists its keys.

Examples:
  detune identify session.yaml
  detune identify session.yaml --write measured.csv
  detune identify session.yaml --format svg --output modes.svg

A record without modes gets a warning, which does not change the exit code.";

/// Find natural frequencies, damping and mode shapes in vibration records.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct IdentifyArgs {
    /// Session file: the records and their poses.
    #[arg(value_name = "SESSION.yaml")]
    session: PathBuf,
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Write to this file instead of standard output (`-`); a run that fails leaves it unchanged.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    plots: PlotsArgs,
    /// Also write the table of modes that `detune diagnose` reads to this file.
    #[arg(long, value_name = "MEASURED.csv")]
    write: Option<PathBuf>,
    /// Also write shapes (data set 55) and, where a force was measured, the frequency responses
    /// that the modes make (58) to this universal file.
    #[arg(long, value_name = "FILE.uff")]
    write_uff: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Readable text.
    Text,
    /// JSON.
    Json,
    /// Spectrum, fit and stabilisation diagram of each record.
    Svg,
    /// A page to look at: the modes of all poses, and the sheets of all records.
    Html,
    /// Plots with characters, for a terminal.
    Plot,
}

/// Identifies a session; if a file is invalid, reports all errors and writes nothing.
pub(super) fn run(
    args: &IdentifyArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let table = args.write.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    let shapes = args.write_uff.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    keep_apart(&[
        ("--output", Some(&sink), args.output.as_deref()),
        ("--write", table.as_ref(), args.write.as_deref()),
        ("--write-uff", shapes.as_ref(), args.write_uff.as_deref()),
    ])?;
    let Read { value: session, warnings, files } = read(&args.session);
    shown.show(&warnings);
    let session = session?;
    for sink in [&sink].into_iter().chain(&table).chain(&shapes) {
        sink.refuse_inputs(&files)?;
    }
    let progress = shown.bar(progress(session.records.len()));
    let found = identify(&session, &|done| {
        if let Done::More(records) = done {
            progress.inc(records as u64);
        }
    });
    progress.finish_and_clear();
    shown.shown_elsewhere(&found.warnings);
    found.records.iter().for_each(|record| shown.shown_elsewhere(&record.warnings));
    let text = match args.format {
        Format::Text => identification_text(&found),
        Format::Json => {
            identification_json(&found).map_err(|error| Failure::Internal(error.to_string()))?
        }
        Format::Svg => identification_drawing(&found).svg(),
        Format::Plot => in_characters(&identification_plots(&found), &sink),
        Format::Html => {
            identification_html(&found).map_err(|error| Failure::Internal(error.to_string()))?
        }
    };
    let csv = table.as_ref().map(|table| (table, measured_csv(&found)));
    let mut outputs: Vec<(&Sink, &[u8])> = vec![(&sink, text.as_bytes())];
    outputs.extend(csv.iter().map(|(table, csv)| (*table, csv.as_bytes())));
    let uff = shapes.as_ref().map(|shapes| (shapes, identification_uff(&found)));
    outputs.extend(uff.iter().map(|(shapes, uff)| (*shapes, uff.as_bytes())));
    let plots = args.plots.files(|| identification_plots(&found))?;
    outputs.extend(plots.iter().map(|(sink, svg)| (sink, svg.as_bytes())));
    write_all(&outputs, out)?;
    Ok(Outcome::Pass)
}

/// Counts records on standard error while it is a terminal, and shows nothing elsewhere.
fn progress(records: usize) -> ProgressBar {
    let bar = ProgressBar::new(records as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos} of {len} records, {elapsed}") {
        bar.set_style(style);
    }
    bar
}
