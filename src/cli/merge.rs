//! `detune merge`: the parts of a map in, the map out.

use std::io::Write;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::map::{StatisticName, statistics};
use super::output::Sink;
use super::{Failure, Outcome, Warnings};
use crate::notes::Note;
use crate::report::map::{reduced_csv, reduced_drawing, reduced_json};
use crate::study::Read;
use crate::study::map::{Statistic, merge};

const AFTER_HELP: &str = "\
Examples:
  for i in 1 2 3 4; do
    detune map robot.yaml --random 100000000 --reduce min,max,quantiles --part $i/4 \\
      --format sketch --output $i.json
  done
  detune merge 1.json 2.json 3.json 4.json

The output is that of the undivided run, to the byte, on the same kind of machine.";

/// Merge the parts of a map that `detune map --part I/N --format sketch` wrote.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct MergeArgs {
    /// All parts of a map, in any order.
    #[arg(value_name = "SKETCH", required = true)]
    sketches: Vec<PathBuf>,
    /// Write these statistics; those that the parts were made for if not given, and all if they
    /// were made for none.
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    reduce: Vec<StatisticName>,
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,
    /// Write to this file instead of standard output (`-`).
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Csv,
    Json,
    Svg,
}

/// Writes the whole map; if a part is wrong or missing, reports all errors and writes nothing.
pub(super) fn run(
    args: &MergeArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    sink.refuse_inputs(&args.sketches)?;
    let Read { value: merged, .. } = merge(&args.sketches);
    let merged = merged?;
    shown.show(&merged.warnings);
    let statistics = match (statistics(&args.reduce), merged.statistics) {
        (asked, _) if !asked.is_empty() => asked,
        (_, of_parts) if !of_parts.is_empty() => of_parts,
        _ => Statistic::ALL.to_vec(),
    };
    let Some(reduced) = merged.reduction.finish() else {
        return Err(vec![Note::usage("the parts hold no poses, must hold one or more")].into());
    };
    let text = match args.format {
        Format::Csv => reduced_csv(&merged.head, &reduced, &statistics),
        Format::Json => reduced_json(&merged.head, &reduced, &statistics)
            .map_err(|error| Failure::Internal(error.to_string()))?,
        Format::Svg => reduced_drawing(&merged.head, &reduced).svg(),
    };
    sink.write(&text, out)?;
    Ok(Outcome::Pass)
}
