//! `detune lobes`: the depth at which a cut chatters, over spindle speeds.

use std::io::Write;
use std::path::PathBuf;
use std::time::SystemTime;

use clap::{Args, ValueEnum};

use super::output::Sink;
use super::{Failure, Outcome, Warnings, of_option};
use crate::report::lobes::{lobes_csv, lobes_drawing, lobes_json};
use crate::study::Read;
use crate::study::lobes::{Method, Request, lobes, read};
use crate::units::Date;

/// Most speeds of a diagram.
const MAX_SPEEDS: usize = 100_000;

const AFTER_HELP: &str = "\
A file of modes stands for itself:
  modes: [{frequency_hz: 922, damping_ratio: 0.011, mass_kg: 0.03993, axis: [1, 0, 0]}]
  tool: {teeth: 2, diameter_mm: 12}
  cutting:
    direction: slot
    coefficients: {ktc_n_per_mm2: 600, krc_n_per_mm2: 200}
`detune schema modes` lists its keys.

Examples:
  detune lobes modes.yaml --rpm 3000:12000:181
  detune lobes modes.yaml --rpm 5000:5000:1 --depth-mm 0.5
  detune lobes jobs/pocket.yaml --at 0.4 --rpm 500:24000:400 --method zeroth --format svg";

/// Compute stability lobes: the smallest axial depth at which a cut chatters.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct LobesArgs {
    /// A file of modes, or a job.
    #[arg(value_name = "MODES.yaml|JOB")]
    subject: PathBuf,
    /// N spindle speeds from A to B, both included, rpm.
    #[arg(long, value_name = "A:B:N", value_parser = speeds)]
    rpm: Speeds,
    /// Tell by which factor a small motion grows over a tooth period at this axial depth, mm.
    #[arg(long, value_name = "D", value_parser = positive)]
    depth_mm: Option<f64>,
    /// Of a job: the place of the path, 0 to 1 in proportion to time; its start if absent.
    #[arg(long, value_name = "S")]
    at: Option<f64>,
    /// Of a job: the operation; the first with `cutting` if absent.
    #[arg(long, value_name = "NAME")]
    operation: Option<String>,
    /// How limits are computed.
    #[arg(long, value_enum, default_value_t = How::Exact)]
    method: How,
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,
    /// Write to this file instead of standard output (`-`); a run that fails leaves it unchanged.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum How {
    /// The cut replaced by its mean: fast, wrong for narrow cuts.
    Zeroth,
    /// The growth of a small motion over one tooth period.
    Exact,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// One row a speed.
    Csv,
    /// JSON.
    Json,
    /// Depth and frequency over the speed.
    Svg,
    /// The same with characters, for a terminal.
    Plot,
}

#[derive(Debug, Clone)]
struct Speeds(Vec<f64>);

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse().ok().filter(|value: &f64| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "must be a number above zero".to_owned())
}

/// What `--rpm` says.
fn speeds(text: &str) -> Result<Speeds, String> {
    let wrong =
        || format!("must be A:B:N with speeds A and B above zero and N from 1 to {MAX_SPEEDS}");
    let parts: Vec<&str> = text.split(':').collect();
    let [from, to, count] = parts.as_slice() else { return Err(wrong()) };
    let (from, to) = (positive(from).map_err(|_| wrong())?, positive(to).map_err(|_| wrong())?);
    let count: usize = count.parse().map_err(|_| wrong())?;
    if !(1..=MAX_SPEEDS).contains(&count) || from > 1e7 || to > 1e7 {
        return Err(wrong());
    }
    let last = count - 1;
    let at = |i: usize| match i {
        0 => from,
        _ if i == last => to,
        _ => from + (to - from) * i as f64 / last as f64,
    };
    Ok(Speeds((0..count).map(at).collect()))
}

/// Writes the lobes.
pub(super) fn run(
    args: &LobesArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let Read { value: subject, warnings, files } = read(&args.subject, Date::of(SystemTime::now()));
    sink.refuse_inputs(&files)?;
    shown.show(&warnings);
    let request = Request {
        speeds_rpm: args.rpm.0.clone(),
        depth_mm: args.depth_mm,
        at_s: args.at,
        operation: args.operation.clone(),
        method: match args.method {
            How::Zeroth => Method::Zeroth,
            How::Exact => Method::Exact,
        },
    };
    let found = lobes(&subject?, &request)
        .map_err(|errors| errors.into_iter().map(of_option).collect::<Vec<_>>())?;
    shown.show(&found.warnings);
    let text = match args.format {
        Format::Csv => lobes_csv(&found),
        Format::Json => lobes_json(&found).map_err(|error| Failure::Internal(error.to_string()))?,
        Format::Svg => lobes_drawing(&found).svg(),
        Format::Plot => lobes_drawing(&found).characters(sink.shows_colour()),
    };
    sink.write(&text, out)?;
    Ok(Outcome::Pass)
}
