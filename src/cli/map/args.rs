//! The command line of `detune map`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::notes::Note;
use crate::report::map::MapFormat;
use crate::study::map::{Part, Positions, Request, Statistic, Unit};

/// Compute natural frequencies over poses.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    detune map robots/two-link --joint joint_2 --from-deg 10 --to-deg 150 --steps 71\n  \
    detune map robot.yaml --poses poses.csv --format json\n  \
    detune map robot.yaml --poses poses.npy --format npy --output frequencies.npy\n  \
    detune map robot.yaml --grid joint_2=-60:90:151 --grid joint_3=-90:60:151\n  \
    detune map robot.yaml --random 100000000 --seed 1 --reduce min,max,quantiles\n  \
    detune map robot.yaml --random 1000000000 --part 3/64 --format sketch --output 3.json\n  \
    detune map robot.yaml --grid joint_3=-90:45:41 --method nonlinear --format svg")]
#[command(group = clap::ArgGroup::new("source")
    .required(true)
    .args(["joint", "grid", "random", "poses"]))]
pub(in crate::cli) struct MapArgs {
    /// A robot.yaml, or the folder that holds one.
    pub(super) robot: PathBuf,
    /// The joint to sweep; the others stay at zero or at --at.
    #[arg(long, value_name = "NAME")]
    pub(super) joint: Option<String>,
    /// Where the sweep of a turning joint starts, degrees.
    #[arg(long, value_name = "A", allow_negative_numbers = true, requires = "joint",
        conflicts_with_all = ["grid", "random", "poses"])]
    pub(super) from_deg: Option<f64>,
    /// Where the sweep of a turning joint ends, degrees.
    #[arg(long, value_name = "B", allow_negative_numbers = true, requires = "joint",
        conflicts_with_all = ["grid", "random", "poses"])]
    pub(super) to_deg: Option<f64>,
    /// Where the sweep of a sliding joint starts, mm.
    #[arg(long, value_name = "A", allow_negative_numbers = true, requires = "joint",
        conflicts_with_all = ["grid", "random", "poses"])]
    pub(super) from_mm: Option<f64>,
    /// Where the sweep of a sliding joint ends, mm.
    #[arg(long, value_name = "B", allow_negative_numbers = true, requires = "joint",
        conflicts_with_all = ["grid", "random", "poses"])]
    pub(super) to_mm: Option<f64>,
    /// Number of poses of the sweep, both ends included.
    #[arg(long, value_name = "N", requires = "joint",
        conflicts_with_all = ["grid", "random", "poses"],
        value_parser = clap::value_parser!(u32).range(1..=100_000_000))]
    pub(super) steps: Option<u32>,
    /// N positions of a joint from A to B, both included, degrees (mm for a sliding joint); repeat
    /// it for all combinations with other joints, the last running fastest.
    #[arg(long, value_name = "NAME=A:B:N", value_parser = grid_range)]
    pub(super) grid: Vec<Positions>,
    /// N poses at random within the joints' limits (a continuous joint: -180 to 180 degrees).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) random: Option<u32>,
    /// The same seed gives the same random poses.
    #[arg(long, value_name = "S", default_value_t = 0, requires = "random",
        conflicts_with_all = ["joint", "grid", "poses"])]
    pub(super) seed: u64,
    /// Position of a joint that is not swept, degrees (mm for a sliding joint); may be repeated.
    #[arg(long, value_name = "NAME=DEG", conflicts_with = "poses", value_parser = named_value)]
    pub(super) at: Vec<(String, f64)>,
    /// Poses as CSV, one column `<joint>_rad` or `_deg` (`_m` or `_mm`) per moving joint, or as
    /// NumPy's .npy, an array of one row per pose and one column per moving joint, rad or m; `-` is
    /// standard input.
    #[arg(long, value_name = "FILE")]
    pub(super) poses: Option<PathBuf>,
    /// Eigenvalues, or the spectrum of a large free vibration.
    #[arg(long, value_enum, default_value_t = MethodName::Linear)]
    pub(super) method: MethodName,
    /// Also the 95 % interval of every frequency: columns f1_lo95_hz, f1_hi95_hz, …
    #[arg(long)]
    pub(super) intervals: bool,
    /// Also the mode shapes: columns `phi1_<coordinate>` (mass-normalised), `phi1_<link>_x`, _y, _z
    /// (how the link turns, base frame) and `strain1_<coordinate>` (share of the strain energy), …
    #[arg(long)]
    pub(super) shapes: bool,
    /// Nonlinear: largest deflection of any turning spring, degrees; 1 if not given.
    #[arg(long, value_name = "X")]
    pub(super) amplitude_deg: Option<f64>,
    /// Nonlinear: samples per second; chosen to show every mode if not given.
    #[arg(long, value_name = "HZ", requires = "duration_s")]
    pub(super) sample_rate_hz: Option<f64>,
    /// Nonlinear: length of the record, s.
    #[arg(long, value_name = "S", requires = "sample_rate_hz")]
    pub(super) duration_s: Option<f64>,
    /// Nonlinear: write the vibrations instead, as csv: one row per sample, with t_s and
    /// `alpha_<coordinate>_rad`.
    #[arg(long)]
    pub(super) series: bool,
    /// Write these statistics of each mode instead of every pose: the lowest and highest frequency
    /// and where they are, the mean, the quantiles at 5, 25, 50, 75 and 95 %, a histogram.
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',')]
    pub(super) reduce: Vec<StatisticName>,
    /// Make only part I of N of the poses, for `detune merge`; needs --format sketch.
    #[arg(long, value_name = "I/N", value_parser = part)]
    pub(super) part: Option<Part>,
    /// Output format; npy is an array of the frequencies alone, one row per pose; arrow is an
    /// Apache Arrow stream with the columns of the CSV, where detune was built with it.
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    pub(super) format: Format,
    /// Write to this file instead of standard output (`-`).
    #[arg(long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodName {
    Linear,
    Nonlinear,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    Csv,
    Json,
    Svg,
    /// A page to look at: curves with intervals and shapes where they are asked for, a table.
    Html,
    /// Plots with characters, for a terminal.
    Plot,
    Npy,
    Arrow,
    /// The statistics of a part, exact, for `detune merge`.
    Sketch,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum StatisticName {
    Min,
    Max,
    Mean,
    Quantiles,
    Histogram,
}

impl Format {
    /// The format of a map's rows; `None` for a drawing.
    pub(super) fn of_rows(self) -> Option<MapFormat> {
        match self {
            Self::Csv => Some(MapFormat::Csv),
            Self::Json => Some(MapFormat::Json),
            Self::Npy => Some(MapFormat::Npy),
            #[cfg(feature = "arrow")]
            Self::Arrow => Some(MapFormat::Arrow),
            #[cfg(not(feature = "arrow"))]
            Self::Arrow => None,
            Self::Svg | Self::Plot | Self::Html | Self::Sketch => None,
        }
    }
}

impl MapArgs {
    /// The poses that are asked for, where they do not come from a table.
    pub(super) fn request(&self) -> Result<Request, Note> {
        let at = self.at.clone();
        if let Some(count) = self.random {
            return Ok(Request::Random { count: count as usize, seed: self.seed, at });
        }
        let sweep = self.joint.as_ref().map(|joint| self.sweep(joint)).transpose()?;
        Ok(Request::Grid { axes: sweep.into_iter().chain(self.grid.iter().cloned()).collect(), at })
    }

    fn sweep(&self, joint: &str) -> Result<Positions, Note> {
        let (from, to, unit) = match (self.from_deg, self.to_deg, self.from_mm, self.to_mm) {
            (Some(from), Some(to), None, None) => (from, to, Unit::Deg),
            (None, None, Some(from), Some(to)) => (from, to, Unit::Mm),
            _ => {
                return Err(Note::usage(
                    "--joint: give --from-deg and --to-deg, or --from-mm and --to-mm for a joint \
                     that slides",
                ));
            }
        };
        let Some(steps) = self.steps else {
            return Err(Note::usage("--joint: --steps is missing"));
        };
        Ok(Positions { joint: joint.to_owned(), from, to, steps: steps as usize, unit })
    }

    /// What is asked of a reduced map, in a fixed order.
    pub(super) fn statistics(&self) -> Vec<Statistic> {
        statistics(&self.reduce)
    }
}

/// In a fixed order.
pub(in crate::cli) fn statistics(of: &[StatisticName]) -> Vec<Statistic> {
    let all = [
        (StatisticName::Min, Statistic::Min),
        (StatisticName::Max, Statistic::Max),
        (StatisticName::Mean, Statistic::Mean),
        (StatisticName::Quantiles, Statistic::Quantiles),
        (StatisticName::Histogram, Statistic::Histogram),
    ];
    all.iter().filter(|(name, _)| of.contains(name)).map(|(_, s)| *s).collect()
}

pub(in crate::cli) fn grid_range(text: &str) -> Result<Positions, String> {
    const EXPECTED: &str = "must be NAME=FROM:TO:STEPS, e.g. joint_2=-60:90:151";
    let (joint, range) = text.rsplit_once('=').ok_or(EXPECTED)?;
    let [from, to, steps] = range.split(':').collect::<Vec<_>>()[..] else {
        return Err(EXPECTED.to_owned());
    };
    let steps = match steps.trim().parse::<usize>() {
        Ok(steps) if steps > 0 => steps,
        _ => return Err(format!("'{steps}' is not a number of steps, must be 1 or more")),
    };
    let (from, to) = (finite(from)?, finite(to)?);
    if steps == 1 && from != to {
        return Err(format!(
            "one position has one end; give {from}:{from}:1, or 2 positions and more"
        ));
    }
    Ok(Positions { joint: joint.trim().to_owned(), from, to, steps, unit: Unit::DegOrMm })
}

fn part(text: &str) -> Result<Part, String> {
    let number = |text: &str| text.parse::<usize>().ok().filter(|number| *number <= MAX_PARTS);
    text.split_once('/')
        .and_then(|(i, n)| Some(Part { number: number(i)?, of: number(n)? }))
        .filter(|part| (1..=part.of).contains(&part.number))
        .ok_or_else(|| format!("must be I/N with I from 1 to N and N at most {MAX_PARTS}"))
}

/// Parts of a map, at most.
const MAX_PARTS: usize = 1_000_000;

pub(in crate::cli) fn named_value(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.rsplit_once('=').ok_or("must be NAME=VALUE, e.g. joint_2=45")?;
    Ok((name.trim().to_owned(), finite(value)?))
}

fn finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) | Err(_) => Err(format!("'{text}' is not a finite number")),
    }
}
