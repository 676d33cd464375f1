//! `detune identify`: raw records in, modes with their uncertainties out.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::output::Sink;
use super::{Failure, Outcome};
use crate::input::load_session;
use crate::measured::session::identify_session;
use crate::report::identify::{
    identification_json, identification_svg, identification_text, measured_csv,
};

const AFTER_HELP: &str = "\
A session names files of raw data (CSV with a header, UFF 58 as text or binary, WAV) with the pose of each;
`detune schema session` lists its keys.

Examples:
  detune identify session.yaml
  detune identify session.yaml --write measured.csv
  detune identify session.yaml --format svg --output modes.svg

A record in which no mode is found is told and does not change the exit code.";

/// Find natural frequencies, damping and mode shapes in raw records of vibration.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct IdentifyArgs {
    /// The session.
    #[arg(value_name = "SESSION.yaml")]
    session: PathBuf,
    /// What to write.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Write to this file, whole or not at all, instead of standard output (`-`).
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Also write the table of modes that `detune diagnose` reads, whole or not at all.
    #[arg(long, value_name = "MEASURED.csv")]
    write: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For people.
    Text,
    /// For programs.
    Json,
    /// Spectrum, fit and stabilisation diagram of each record.
    Svg,
}

/// Identifies a session; if some file is wrong, tells all faults and writes nothing.
pub(super) fn run(args: &IdentifyArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let table = args.write.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    let loaded = load_session(&args.session)?;
    let mut err = std::io::stderr().lock();
    for notice in &loaded.notices {
        // If standard error is closed, there is nobody to tell.
        let _ = writeln!(err, "warning: {notice}");
    }
    drop(err);
    let found = identify_session(&loaded.value);
    let text = match args.format {
        Format::Text => identification_text(&found),
        Format::Json => {
            identification_json(&found).map_err(|error| Failure::Internal(error.to_string()))?
        }
        Format::Svg => identification_svg(&found),
    };
    if let Some(table) = table {
        table.write(&measured_csv(&found, loaded.value.joint_names.as_deref()), out)?;
    }
    sink.write(&text, out)?;
    Ok(Outcome::Pass)
}
