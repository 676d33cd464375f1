//! `detune advise`: a job in, what to run instead out.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::check::{counted_on, progress, shows_colour};
use super::output::Sink;
use super::tell;
use super::{Failure, Outcome};
use crate::advice::{self, FeedRule, Objective, OperationAdvice, Options, Remedy};
use crate::input::{self, OperationEdit, Reading};
use crate::job::{Job, SpindleSpeed};
use crate::notes::{Code, Note, Place};
use crate::program::Rewrite;
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
    /// Write the program that the job runs with the advised speed and feeds to this file; with --write, the job
    /// written names it.
    #[arg(long, value_name = "FILE")]
    write_program: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For people.
    Text,
    /// For programs; `detune schema advice` describes it.
    Json,
    /// A map of path and spindle speed: bands as areas, programmed and advised speeds as lines.
    Svg,
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
    let program = args.write_program.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    let mut reading = Reading::default();
    let read = input::read_job(&args.job, &mut reading);
    tell(&reading.warnings);
    let job = read?;
    keep_apart(args, &sink, write.as_ref(), program.as_ref())?;
    let written = [Some(&sink), write.as_ref(), program.as_ref()];
    for sink in written.into_iter().flatten() {
        sink.spare(std::slice::from_ref(&args.job))?;
        sink.spare(&reading.files)?;
    }
    let bar = progress();
    let found = advice::advise(&job, &options(args), &counted_on(&bar));
    bar.finish_and_clear();
    let found = found?;
    if args.objective == By::Vibration {
        refuse_unknown_vibration(&job, &found.operations)?;
    }
    tell(&found.notices);
    let advised = AdvisedJob::new(&job, found);
    let text = match args.format {
        Format::Text => {
            report::advise::text::advice(&advised, sink.is_standard() && shows_colour())
        }
        Format::Json => report::advise::json::advice(&advised)
            .map_err(|error| Failure::Internal(error.to_string()))?,
        Format::Svg => report::advise::svg::advice(&advised),
    };
    let source = Source { job: &job, files: &reading.files };
    if let Some(path) = args.write.as_deref().filter(|_| advised.advice.is_clear()) {
        // Before anything is written.
        job_text(&source, &advised, path, None)?;
    }
    let new_program = match (program, args.write_program.as_deref()) {
        (Some(sink), Some(path)) => write_program(&job, &advised, &sink, path, out)?,
        _ => None,
    };
    if let (Some(sink), Some(path)) = (write, args.write.as_deref()) {
        write_job(&source, &advised, &sink, path, new_program, out)?;
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

/// Two outputs of one run are two files, or one of them would be lost.
fn keep_apart(
    args: &AdviseArgs,
    sink: &Sink,
    write: Option<&Sink>,
    program: Option<&Sink>,
) -> Result<(), Vec<Note>> {
    let named = |path: &Option<PathBuf>| path.clone();
    let all = [
        ("--output", Some(sink), named(&args.output)),
        ("--write", write, named(&args.write)),
        ("--write-program", program, named(&args.write_program)),
    ];
    for (index, (name, sink, path)) in all.iter().enumerate() {
        for (earlier, other, _) in &all[..index] {
            let (Some(sink), Some(other)) = (sink, other) else { continue };
            if sink.is_same(other) {
                let what = if sink.is_standard() {
                    format!("{name} and {earlier} both go to standard output; name a file for one")
                } else {
                    format!("{name} and {earlier} name the same file; name two")
                };
                let place = path.as_ref().map_or_else(Place::default, Place::file);
                return Err(vec![Note::error(Code::Usage, place, what)]);
            }
        }
    }
    Ok(())
}

/// A job with the files that were read for it.
struct Source<'a> {
    job: &'a Job,
    files: &'a [PathBuf],
}

/// The text of the job as advised, read again and found to be that.
fn job_text(
    source: &Source,
    advised: &AdvisedJob,
    path: &Path,
    new_program: Option<&Path>,
) -> Result<String, Vec<Note>> {
    let job = source.job;
    let operations = job.operations.iter().zip(&advised.advice.operations);
    let edits: Vec<OperationEdit> = operations
        .map(|(operation, advice)| OperationEdit {
            program: new_program.filter(|_| operation.program.is_some()).map(Path::to_owned),
            ..edit(advice)
        })
        .collect();
    let text = input::rewritten_job(&job.file, path, &edits).map_err(|fault| vec![fault])?;
    input::confirm_rewritten(job, source.files, &text, path, &edits)
        .map_err(|fault| vec![fault])?;
    Ok(text)
}

/// Writes the job as advised, unless a check would not pass it.
fn write_job(
    source: &Source,
    advised: &AdvisedJob,
    sink: &Sink,
    path: &Path,
    new_program: Option<&Path>,
    out: &mut dyn Write,
) -> Result<(), Failure> {
    let unclear = advised.advice.operations.iter().find(|o| !o.remedy.is_clear());
    if let Some(operation) = unclear {
        let what = format!(
            "is not written: operation '{}' cannot be run clear of every band",
            operation.name
        );
        tell(&[Note::warning(Code::NotWritten, Place::file(path), what)]);
        return Ok(());
    }
    let text = job_text(source, advised, path, new_program)?;
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
        Remedy::Constant(_) | Remedy::Kept(_) | Remedy::Infeasible => {
            (None, operation.programmed_feed_m_per_s)
        }
    };
    let has_other_feed = feed_m_per_s != operation.programmed_feed_m_per_s;
    OperationEdit {
        speed,
        feed_mm_per_min: has_other_feed.then(|| written_feed(feed_m_per_s)),
        program: None,
    }
}

/// Vibration cannot be made least where it is not known.
fn refuse_unknown_vibration(job: &Job, advice: &[OperationAdvice]) -> Result<(), Vec<Note>> {
    let faults: Vec<Note> = job
        .operations
        .iter()
        .zip(advice)
        .filter_map(|(operation, advice)| {
            let why = advice.vibration.as_ref().err()?;
            let why = report::advise::no_vibration(*why);
            let what = format!("operation '{}': --objective vibration: {why}", operation.name);
            Some(Note::error(Code::MissingKey, Place::line(&job.file, operation.line), what))
        })
        .collect();
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Writes the one program of the job with the one constant speed that its operations are to run at, and
/// gives its place; tells why where that is not possible.
fn write_program<'p>(
    job: &Job,
    advised: &AdvisedJob,
    sink: &Sink,
    path: &'p Path,
    out: &mut dyn Write,
) -> Result<Option<&'p Path>, Failure> {
    let refused = |what: String| Note::warning(Code::NotWritten, Place::file(path), what);
    let mut wanted: Option<(&Path, Rewrite)> = None;
    for (operation, advice) in job.operations.iter().zip(&advised.advice.operations) {
        let Some(program) = &operation.program else { continue };
        let name = &operation.name;
        if let Remedy::Kept(_) = &advice.remedy {
            let what = format!(
                "is not written: operation '{name}' keeps its spindle_schedule, which no program states"
            );
            tell(&[refused(what)]);
            return Ok(None);
        }
        let Remedy::Constant(constant) = &advice.remedy else {
            let what = format!("is not written: operation '{name}' has no safe constant speed");
            tell(&[refused(what)]);
            return Ok(None);
        };
        let feed_ratio = constant.feed_m_per_s / advice.programmed_feed_m_per_s;
        let this = (program.as_path(), Rewrite { rpm: constant.rpm, feed_ratio });
        if wanted.is_some_and(|before| before != this) {
            let what = "is not written: the operations run several programs, or one at several speeds; split \
                        the job";
            tell(&[refused(what.to_owned())]);
            return Ok(None);
        }
        wanted = Some(this);
    }
    let Some((program, to)) = wanted else {
        tell(&[refused("is not written: the job runs no program".to_owned())]);
        return Ok(None);
    };
    let file = job.file.parent().unwrap_or(Path::new("")).join(program);
    match input::rewritten_program(&file, &to).map_err(|fault| vec![fault])? {
        Ok(rewritten) => {
            sink.write_bytes(&rewritten.bytes, out)?;
            Ok(Some(path))
        }
        Err(why) => {
            tell(&[why]);
            Ok(None)
        }
    }
}

/// mm/min with three decimals, or all digits where that would leave nothing.
fn written_feed(feed_m_per_s: f64) -> f64 {
    let feed = mm_per_min_from_m_per_s(feed_m_per_s);
    let rounded = (feed * 1e3).round() / 1e3;
    if rounded > 0.0 { rounded } else { feed }
}
