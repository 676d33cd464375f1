//! `detune advise`: a job in, what to run instead out.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::check::{located, progress, shows_colour, tell};
use super::output::Sink;
use super::{Failure, Outcome};
use crate::advice::{self, FeedRule, Objective, OperationAdvice, Options, Remedy};
use crate::input::{self, Fault, OperationEdit};
use crate::job::{Job, SpindleSpeed};
use crate::report::{self, AdvisedJob};
use crate::units::mm_per_min_from_m_per_s;

const AFTER_HELP: &str = "\
Examples:
  detune advise jobs/pocket.yaml
  detune advise jobs/pocket.yaml --objective margin --format json | jq '.operations[].recommended_rpm'
  detune advise jobs/pocket.yaml --write jobs/pocket-quiet.yaml && detune check jobs/pocket-quiet.yaml

Exit codes: 0 every operation can be run clear of every band, 1 one cannot, 2 a file or the command line is
wrong, 3 a fault of the program itself. The format of the output never changes the exit code.";

/// Tell at which spindle speeds a job does not shake the arm, and the best of them.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct AdviseArgs {
    /// Job file.
    #[arg(value_name = "JOB")]
    job: PathBuf,
    /// What to write.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Write to this file, whole or not at all, instead of standard output (`-`).
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// What makes one safe speed better than another.
    #[arg(long, value_enum, default_value_t = By::Nearest)]
    objective: By,
    /// What becomes of the feed when the speed changes.
    #[arg(long, value_enum, default_value_t = Feed::ChipLoad)]
    feed: Feed,
    /// Plan a speed that varies along the path even where a constant one is safe.
    #[arg(long)]
    schedule: bool,
    /// Write the job as advised to this file; nothing is written where an operation cannot be run clear.
    #[arg(long, value_name = "JOB2")]
    write: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For people.
    Text,
    /// For programs; `detune schema advice` describes it.
    Json,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    /// Nearest to the programmed one.
    Nearest,
    /// Farthest from every mode and line.
    Margin,
    /// The highest.
    Highest,
    /// The one at which the cutting force moves the tool tip least; needs `cutting`.
    Vibration,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Feed {
    /// The feed follows the speed: the feed per tooth stays what it was.
    ChipLoad,
    /// The feed stays as programmed.
    Programmed,
}

/// Advises one job; if some file is wrong, tells all faults and writes nothing.
pub(super) fn run(args: &AdviseArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let write = args.write.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    let loaded = input::load_job(&args.job)?;
    let job = loaded.value;
    let bar = progress();
    let poses = |more: usize| bar.inc(u64::try_from(more).unwrap_or(u64::MAX));
    let found = advice::advise_with_progress(&job, &options(args), &poses);
    bar.finish_and_clear();
    tell(&loaded.notices);
    let found = found.map_err(|faults| {
        faults.into_iter().map(|fault| located(fault, &job)).collect::<Vec<_>>()
    })?;
    let advised = AdvisedJob::new(&job, found);
    let text = match args.format {
        Format::Text => {
            report::advice::text::advice(&advised, sink.is_standard() && shows_colour())
        }
        Format::Json => report::advice::json::advice(&advised)
            .map_err(|error| Failure::Internal(error.to_string()))?,
    };
    if let (Some(sink), Some(path)) = (write, args.write.as_deref()) {
        write_job(&job, &advised, &sink, path, out)?;
    }
    sink.write(&text, out)?;
    Ok(if advised.advice.is_clear() { Outcome::Pass } else { Outcome::Fail })
}

fn options(args: &AdviseArgs) -> Options {
    Options {
        objective: match args.objective {
            By::Nearest => Objective::Nearest,
            By::Margin => Objective::Margin,
            By::Highest => Objective::Highest,
            By::Vibration => Objective::Vibration,
        },
        feed: match args.feed {
            Feed::ChipLoad => FeedRule::ChipLoad,
            Feed::Programmed => FeedRule::Programmed,
        },
        schedule: args.schedule,
    }
}

/// Writes the job as advised, unless a check would not pass it.
fn write_job(
    job: &Job,
    advised: &AdvisedJob,
    sink: &Sink,
    path: &Path,
    out: &mut dyn Write,
) -> Result<(), Failure> {
    let unclear = advised.advice.operations.iter().find(|o| !o.remedy.is_clear());
    if let Some(operation) = unclear {
        let what = format!(
            "is not written: operation '{}' cannot be run clear of every band",
            operation.name
        );
        tell(&[Fault { file: Some(path.to_owned()), line: None, what }]);
        return Ok(());
    }
    let edits: Vec<OperationEdit> = advised.advice.operations.iter().map(edit).collect();
    let text = input::rewritten_job(&job.file, path, &edits).map_err(|fault| vec![fault])?;
    sink.write(&text, out)?;
    Ok(())
}

fn edit(operation: &OperationAdvice) -> OperationEdit {
    let (speed, feed_m_per_s) = match &operation.remedy {
        Remedy::Constant(constant) if !constant.is_programmed => {
            (Some(SpindleSpeed::Constant(constant.rpm)), constant.feed_m_per_s)
        }
        Remedy::Scheduled(schedule) => {
            (Some(SpindleSpeed::Schedule(schedule.points.clone())), schedule.feed_m_per_s)
        }
        Remedy::Constant(_) | Remedy::Infeasible => (None, operation.programmed_feed_m_per_s),
    };
    let has_other_feed = feed_m_per_s != operation.programmed_feed_m_per_s;
    OperationEdit {
        speed,
        feed_mm_per_min: has_other_feed.then(|| written_feed(feed_m_per_s)),
        program: None,
    }
}

/// mm/min with three decimals, or all digits where that would leave nothing.
fn written_feed(feed_m_per_s: f64) -> f64 {
    let feed = mm_per_min_from_m_per_s(feed_m_per_s);
    let rounded = (feed * 1e3).round() / 1e3;
    if rounded > 0.0 { rounded } else { feed }
}
