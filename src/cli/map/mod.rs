//! `detune map`: natural frequencies over poses.

mod source;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use self::source::{Source, fault, named_value};
use super::output::Sink;
use super::{Failure, Outcome};
use crate::free_vibration::{Sampling, Settings};
use crate::input::{Fault, load_robot};
use crate::map::{Head, Method, Row, is_outside_limits, rows};
use crate::model::Robot;
use crate::report::map::{
    map_csv_header, map_csv_rows, map_json_end, map_json_rows, map_json_start, map_svg,
};
use crate::units::rad_from_deg;

/// Poses that are held in memory at once: enough for all processors, little enough to forget.
const LINEAR_CHUNK: usize = 16_384;

/// The same for nonlinear maps, whose rows take long and hold spectra.
const NONLINEAR_CHUNK: usize = 64;

/// Most poses in a picture.
const MOST_DRAWN: usize = 100_000;

/// Natural frequencies over poses.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    detune map robots/two-link --joint joint_2 --from-deg -130 --to-deg 150 --steps 281\n  \
    detune map robot.yaml --poses poses.csv --format json\n  \
    detune map robot.yaml --joint joint_3 --from-deg -90 --to-deg 45 --steps 41 \\\n      \
    --method nonlinear --amplitude-deg 0.5 --format svg --output map.svg")]
pub(super) struct MapArgs {
    /// A robot.yaml, or the folder that holds one.
    robot: PathBuf,
    /// The joint to sweep; the others stay at zero or at --at.
    #[arg(long, value_name = "NAME", required_unless_present = "poses", conflicts_with = "poses")]
    joint: Option<String>,
    /// Where the sweep of a turning joint starts, degrees.
    #[arg(long, value_name = "A", allow_negative_numbers = true, requires = "joint")]
    from_deg: Option<f64>,
    /// Where the sweep of a turning joint ends, degrees.
    #[arg(long, value_name = "B", allow_negative_numbers = true, requires = "joint")]
    to_deg: Option<f64>,
    /// Where the sweep of a sliding joint starts, mm.
    #[arg(long, value_name = "A", allow_negative_numbers = true, requires = "joint")]
    from_mm: Option<f64>,
    /// Where the sweep of a sliding joint ends, mm.
    #[arg(long, value_name = "B", allow_negative_numbers = true, requires = "joint")]
    to_mm: Option<f64>,
    /// Number of poses of the sweep, both ends included.
    #[arg(long, value_name = "N", requires = "joint",
        value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    steps: Option<u32>,
    /// Another joint's position during the sweep, degrees (mm for a sliding joint); may be repeated.
    #[arg(long, value_name = "NAME=DEG", requires = "joint", value_parser = named_value)]
    at: Vec<(String, f64)>,
    /// Poses as CSV, one column `<joint>_rad` or `_deg` (`_m` or `_mm`) per moving joint; `-` is standard input.
    #[arg(long, value_name = "FILE")]
    poses: Option<PathBuf>,
    /// Eigenvalues, or spectra of a large free vibration.
    #[arg(long, value_enum, default_value_t = MethodName::Linear)]
    method: MethodName,
    /// Nonlinear: largest deflection of any turning spring, degrees.
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    amplitude_deg: f64,
    /// Nonlinear: samples per second; chosen to show every mode if not given.
    #[arg(long, value_name = "HZ", requires = "duration_s")]
    sample_rate_hz: Option<f64>,
    /// Nonlinear: length of the record, s.
    #[arg(long, value_name = "S", requires = "sample_rate_hz")]
    duration_s: Option<f64>,
    /// How to write the map.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,
    /// Where to write it; standard output if not given.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodName {
    Linear,
    Nonlinear,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    Csv,
    Json,
    Svg,
}

/// Writes the map of `args` to `out` or to its file.
pub(super) fn run(args: &MapArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let loaded = load_robot(&robot_file(&args.robot))?;
    let mut notices: Vec<String> = loaded.notices.iter().map(Fault::to_string).collect();
    let robot = loaded.value;
    let method = method(args);
    sink.stream(out, |out| write_map(args, &robot, &method, out, &mut notices))?;
    let mut stderr = io::stderr().lock();
    for notice in notices {
        // If standard error is closed, there is nobody to tell.
        let _ = writeln!(stderr, "warning: {notice}");
    }
    Ok(Outcome::Pass)
}

/// A folder stands for the robot.yaml in it.
fn robot_file(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("robot.yaml") } else { path.to_owned() }
}

fn method(args: &MapArgs) -> Method {
    match args.method {
        MethodName::Linear => Method::Linear,
        MethodName::Nonlinear => Method::Nonlinear(Settings {
            amplitude_rad: rad_from_deg(args.amplitude_deg),
            sampling: match (args.sample_rate_hz, args.duration_s) {
                (Some(sample_rate_hz), Some(duration_s)) => {
                    Sampling::Fixed { sample_rate_hz, duration_s }
                }
                (Some(_), None) | (None, Some(_)) | (None, None) => Sampling::Automatic,
            },
            ..Settings::default()
        }),
    }
}

/// What is told once at the end rather than pose by pose.
#[derive(Default)]
struct Remarks {
    poses: usize,
    outside_limits: usize,
    folded: usize,
    first_folded: Option<String>,
    unresolved: usize,
}

impl Remarks {
    fn note(&mut self, robot: &Robot, rows: &[Row]) {
        self.poses += rows.len();
        for row in rows {
            self.outside_limits += usize::from(is_outside_limits(robot, &row.joints));
            let Some(nonlinear) = &row.nonlinear else { continue };
            self.folded += nonlinear.folded.len();
            if let (None, Some(folded)) = (&self.first_folded, nonlinear.folded.first()) {
                self.first_folded = Some(format!(
                    "mode {} at {:.2} Hz would show at {:.2} Hz",
                    folded.mode + 1,
                    folded.frequency_hz,
                    folded.seen_at_hz
                ));
            }
            let blank = row.frequencies_hz.iter().filter(|f| f.is_none()).count();
            self.unresolved += blank - nonlinear.folded.len();
        }
    }

    fn tell(self, notices: &mut Vec<String>) {
        let all = self.poses;
        if self.outside_limits > 0 {
            let count = self.outside_limits;
            notices.push(format!("{count} of {all} poses lie outside the joint limits"));
        }
        if let Some(first) = self.first_folded {
            notices.push(format!(
                "{} frequencies lie above half the sample rate and are left blank ({first}); \
                 raise --sample-rate-hz",
                self.folded
            ));
        }
        if self.unresolved > 0 {
            notices.push(format!(
                "{} frequencies are blank, as two modes lie too close for the record to part \
                 them; lengthen --duration-s",
                self.unresolved
            ));
        }
    }
}

fn write_map(
    args: &MapArgs,
    robot: &Robot,
    method: &Method,
    out: &mut dyn Write,
    notices: &mut Vec<String>,
) -> Result<(), Failure> {
    let mut source = Source::new(args, robot)?;
    let is_nonlinear = args.method == MethodName::Nonlinear;
    let chunk = if is_nonlinear { NONLINEAR_CHUNK } else { LINEAR_CHUNK };
    let head = Head::of(robot);
    let internal = |error: serde_json::Error| Failure::Internal(error.to_string());
    let mut remarks = Remarks::default();
    let mut drawn = Vec::new();
    let mut text = match args.format {
        Format::Csv => map_csv_header(&head, is_nonlinear),
        Format::Json => map_json_start(&head, is_nonlinear).map_err(internal)?,
        Format::Svg => String::new(),
    };
    loop {
        let (poses, lines) = source.next(chunk)?;
        if poses.is_empty() {
            break;
        }
        let found = rows(robot, &poses, method).map_err(|bad| match lines.get(bad.index) {
            Some(&line) => fault(args.poses.as_deref(), Some(line), bad.fault.to_string()),
            None => {
                let number = remarks.poses + bad.index + 1;
                fault(None, None, format!("pose {number}: {}", bad.fault))
            }
        })?;
        match args.format {
            Format::Csv => map_csv_rows(&found, &mut text),
            Format::Json => {
                map_json_rows(&found, remarks.poses == 0, &mut text).map_err(internal)?;
            }
            Format::Svg => {}
        }
        remarks.note(robot, &found);
        if args.format == Format::Svg {
            drawn.extend(found);
            if drawn.len() > MOST_DRAWN {
                let what = format!("more than {MOST_DRAWN} poses, too many to draw; use csv");
                return Err(fault(None, None, format!("--format svg: {what}")).into());
            }
        }
        out.write_all(text.as_bytes())?;
        text.clear();
    }
    match args.format {
        Format::Csv => {}
        Format::Json => text.push_str(map_json_end()),
        Format::Svg => text = map_svg(&head, &drawn, source.swept()),
    }
    out.write_all(text.as_bytes())?;
    out.flush()?;
    remarks.tell(notices);
    Ok(())
}
