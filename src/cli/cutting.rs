//! `detune cutting`: cutting coefficients from slot tests.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Failure, Outcome, Warnings};
use crate::report::cutting::{cutting_json, cutting_text};
use crate::study::Read;
use crate::study::cutting::{cutting, read};

/// Fit cutting coefficients to the mean forces of slot tests.
#[derive(Debug, Args)]
#[command(
    after_help = "The table has the columns feed_mm_per_tooth, axial_depth_mm, teeth, fx_n, fy_n \
                  and optionally fz_n: mean forces along the feed, across it (y = z × x) and out \
                  of the tool's holder.\n\nExample:\n  detune cutting slots.csv"
)]
pub(super) struct CuttingArgs {
    /// Table of the slot tests.
    #[arg(value_name = "SLOTS.csv")]
    slots: PathBuf,
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Readable text.
    Text,
    /// JSON.
    Json,
}

/// Fits the coefficients of the table.
pub(super) fn run(
    args: &CuttingArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let Read { value: slots, warnings, .. } = read(&args.slots);
    shown.show(&warnings);
    let fit = cutting(&args.slots, &slots?)?;
    let text = match args.format {
        Format::Text => cutting_text(&fit),
        Format::Json => cutting_json(&fit).map_err(|error| Failure::Internal(error.to_string()))?,
    };
    out.write_all(text.as_bytes())?;
    Ok(Outcome::Pass)
}
