//! `detune advise`: a job in, what to run instead out.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::{Args, ValueEnum};

use super::check::{count_on, progress, shows_colour};
use super::output::{Sink, keep_apart, write_all};
use super::plots::PlotsArgs;
use super::{Failure, Outcome, Warnings, of_option};
use crate::notes::Note;
use crate::report;
use crate::report::job::{JobPage, jobs};
use crate::study::Read;
use crate::study::advise::{Advised, FeedRule, Objective, Options, WriteTo, advise, read};
use crate::study::report::about;
use crate::units::Date;

const AFTER_HELP: &str = "\
Examples:
  detune advise jobs/pocket.yaml
  detune advise jobs/pocket.yaml --objective margin --format json
  detune advise jobs/pocket.yaml --write jobs/pocket-quiet.yaml
  detune check jobs/pocket-quiet.yaml

Exit codes: 0 every operation can be run clear of every band, 1 one cannot, 2 a file or the \
command line is wrong, 3 an internal error. The format of the output never changes the exit code.";

/// Find the spindle speeds at which a job excites no resonance of the arm, and the best of them.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct AdviseArgs {
    /// Job file.
    #[arg(value_name = "JOB")]
    job: PathBuf,
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Write to this file instead of standard output (`-`); a run that fails leaves it unchanged.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    plots: PlotsArgs,
    /// Which of the safe speeds to recommend.
    #[arg(long, value_enum, default_value_t = By::Nearest)]
    objective: By,
    /// How the feed follows the spindle speed.
    #[arg(long, value_enum, default_value_t = Feed::ChipLoad)]
    feed: Feed,
    /// Plan a speed that varies along the path even where a constant one is safe.
    #[arg(long)]
    schedule: bool,
    /// Write the job as advised to this file, unless an operation cannot be run clear of every
    /// band.
    #[arg(long, value_name = "JOB2")]
    write: Option<PathBuf>,
    /// Write the program that the job runs with the advised speed and feeds to this file; with
    /// --write, the job written names it.
    #[arg(long, value_name = "FILE")]
    write_program: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Readable text.
    Text,
    /// JSON; `detune schema advice` describes it.
    Json,
    /// A map of path and spindle speed: bands as areas, programmed and advised speeds as lines.
    Svg,
    /// A page to look at: verdict, advice, and the arm with its modes along the path.
    Html,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    /// Nearest to the programmed speed.
    Nearest,
    /// The largest margin to every mode and line.
    Margin,
    /// The highest speed.
    Highest,
    /// The smallest forced vibration of the tool tip; needs `cutting` in the job.
    Vibration,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Feed {
    /// The feed is scaled with the speed: the feed per tooth stays.
    ChipLoad,
    /// The feed stays as programmed.
    Programmed,
}

/// Advises one job; if some file is wrong, reports all errors and writes nothing.
pub(super) fn run(
    args: &AdviseArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let write = args.write.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    let program = args.write_program.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    let Read { value: job, warnings, files } = read(&args.job, Date::of(SystemTime::now()));
    let job = job.inspect_err(|_| shown.show(&warnings))?;
    keep_apart(&[
        ("--output", Some(&sink), args.output.as_deref()),
        ("--write", write.as_ref(), args.write.as_deref()),
        ("--write-program", program.as_ref(), args.write_program.as_deref()),
    ])?;
    for sink in [Some(&sink), write.as_ref(), program.as_ref()].into_iter().flatten() {
        sink.refuse_inputs([&args.job])?;
        sink.refuse_inputs(&files)?;
    }
    let to = WriteTo { job: args.write.as_deref(), program: args.write_program.as_deref() };
    let bar = progress();
    let advised = advise(&job, &files, &options(args), to, &count_on(&bar));
    bar.finish_and_clear();
    let advised = advised.inspect_err(|_| shown.show(&warnings)).map_err(at_option)?;
    let Advised { job: advised, outputs, not_written } = advised;
    shown.show_of_jobs(&advised.warnings);
    shown.show(&not_written);
    let text = match args.format {
        Format::Text => {
            report::advise::text::advice(&advised, sink.is_standard() && shows_colour())
        }
        Format::Json => report::advise::json::advice(&advised)
            .map_err(|error| Failure::Internal(error.to_string()))?,
        Format::Svg => report::advise::svg::advice(&advised),
        Format::Html => {
            let reported = about(&job, advised.clone(), &|_| ())?;
            jobs(&[JobPage::from(&reported)])
                .map_err(|error| Failure::Internal(error.to_string()))?
        }
    };
    let sink_of = |path: &Path| match args.write.as_deref() {
        Some(job) if job == path => write.as_ref(),
        _ => program.as_ref(),
    };
    let mut all: Vec<(&Sink, &[u8])> = vec![(&sink, text.as_bytes())];
    for output in &outputs {
        all.extend(sink_of(&output.path).map(|sink| (sink, output.bytes.as_slice())));
    }
    let plots = args.plots.files(|| report::advise::svg::plots(&advised))?;
    all.extend(plots.iter().map(|(sink, svg)| (sink, svg.as_bytes())));
    write_all(&all, out)?;
    Ok(if advised.advice.is_clear() { Outcome::Pass } else { Outcome::Fail })
}

/// Errors of the request, at the option that asked for it.
fn at_option(errors: Vec<Note>) -> Vec<Note> {
    let at = |note: Note| if note.place.key == "objective" { of_option(note) } else { note };
    errors.into_iter().map(at).collect()
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
