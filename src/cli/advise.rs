//! `detune advise`: a job in, what to run instead out.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::{Args, ValueEnum};

use super::check::{count_on, progress};
use super::output::{Sink, keep_apart, write_all};
use super::plots::PlotsArgs;
use super::{Failure, Outcome, Warnings, of_option};
use crate::notes::Note;
use crate::report;
use crate::report::job::{JobPage, jobs as pages};
use crate::study::advise::{AdvisedJob, FeedRule, Objective, Options, WriteTo, advise, read_under};
use crate::study::report::{Meshes, about};
use crate::study::{PolicyOverrides, Read, is_one_file, job_files};
use crate::units::Date;

const AFTER_HELP: &str = "\
Examples:
  detune advise jobs/pocket.yaml
  detune advise jobs/pocket.yaml --objective margin --format json
  detune advise jobs --policy separation_percent=8
  detune advise jobs/pocket.yaml --write jobs/pocket-quiet.yaml
  detune check jobs/pocket-quiet.yaml

Exit codes: 0 every operation can be run clear of every band, 1 one cannot, 2 a file or the \
command line is wrong, 3 an internal error. The format of the output never changes the exit code.";

/// Find the spindle speeds at which a job excites no resonance of the arm, and the best of them.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct AdviseArgs {
    /// Job files; folders, for the jobs in and below them; patterns such as 'jobs/**/*.yaml'.
    #[arg(value_name = "JOB", required = true)]
    jobs: Vec<PathBuf>,
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
    /// A key of the policy, which wins over the job and detune.toml; may be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    policy: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Readable text.
    Text,
    /// JSON; `detune schema advice` describes it. Of several jobs a list of the same.
    Json,
    /// A map of path and spindle speed: bands as areas, programmed and advised speeds as lines.
    Svg,
    /// A page to look at: verdict, advice, and the arm with its modes along the path.
    Html,
    /// Plots with characters, for a terminal.
    Plot,
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
    /// The largest depth before the cut chatters; needs `cutting` in the job.
    Depth,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Feed {
    /// The feed is scaled with the speed: the feed per tooth stays.
    ChipLoad,
    /// The feed stays as programmed.
    Programmed,
}

/// Advises jobs; if some file is wrong, reports all errors of all jobs and writes nothing.
pub(super) fn run(
    args: &AdviseArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let write = args.write.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    let program = args.write_program.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    let policy = PolicyOverrides::parse(&args.policy)?;
    let files = job_files(&args.jobs)?;
    let is_list = !is_one_file(&args.jobs);
    refuse_for_several(args, is_list)?;
    let today = Date::of(SystemTime::now());
    let read: Vec<_> = files.iter().map(|file| read_under(file, today, &policy)).collect();
    keep_apart(&[
        ("--output", Some(&sink), args.output.as_deref()),
        ("--write", write.as_ref(), args.write.as_deref()),
        ("--write-program", program.as_ref(), args.write_program.as_deref()),
    ])?;
    for sink in [Some(&sink), write.as_ref(), program.as_ref()].into_iter().flatten() {
        sink.refuse_inputs(&files)?;
        sink.refuse_inputs(read.iter().flat_map(|read| &read.files))?;
    }
    let to = WriteTo { job: args.write.as_deref(), program: args.write_program.as_deref() };
    let bar = progress(shown);
    let (mut all, mut errors) = (Vec::new(), Vec::new());
    for Read { value: job, warnings, files } in read {
        let advised = job.and_then(|job| {
            let advised = advise(&job, &files, &options(args), to, &count_on(&bar))?;
            Ok((job, advised))
        });
        match advised {
            Ok((job, advised)) => {
                bar.suspend(|| {
                    shown.show_of_jobs(&advised.job.warnings);
                    shown.show(&advised.not_written);
                });
                all.push((job, advised));
            }
            Err(own) => {
                bar.suspend(|| shown.show(&warnings));
                errors.extend(own);
            }
        }
    }
    bar.finish_and_clear();
    if !errors.is_empty() {
        return Err(at_option(errors).into());
    }
    let jobs: Vec<&AdvisedJob> = all.iter().map(|(_, advised)| &advised.job).collect();
    let colour = sink.shows_colour();
    let text = match args.format {
        Format::Html => {
            let meshes = Meshes::default();
            let about =
                all.iter().map(|(job, found)| about(job, found.job.clone(), &meshes, &|_| ()));
            let reported = about.collect::<Result<Vec<_>, _>>()?;
            pages(&reported.iter().map(JobPage::from).collect::<Vec<_>>())
                .map_err(|error| Failure::Internal(error.to_string()))?
        }
        _ => rendered(&jobs, args.format, is_list, colour)?,
    };
    let plots = args
        .plots
        .files(|| jobs.iter().flat_map(|job| report::advise::svg::plots(job)).collect())?;
    let sink_of = |path: &Path| match args.write.as_deref() {
        Some(job) if job == path => write.as_ref(),
        _ => program.as_ref(),
    };
    let mut outputs: Vec<(&Sink, &[u8])> = vec![(&sink, text.as_bytes())];
    outputs.extend(plots.iter().map(|(sink, svg)| (sink, svg.as_bytes())));
    for output in all.iter().flat_map(|(_, advised)| &advised.outputs) {
        outputs.extend(sink_of(&output.path).map(|sink| (sink, output.bytes.as_slice())));
    }
    write_all(&outputs, out)?;
    let is_clear = jobs.iter().all(|job| job.can_be_run());
    Ok(if is_clear { Outcome::Pass } else { Outcome::Fail })
}

/// What is about one job cannot be asked of several; what only the command line says cannot be
/// written into a job that is then read without it.
fn refuse_for_several(args: &AdviseArgs, is_list: bool) -> Result<(), Vec<Note>> {
    let options: [(&str, bool, bool); 5] = [
        ("--write", args.write.is_some(), true),
        ("--write-program", args.write_program.is_some(), true),
        ("--format svg", args.format == Format::Svg, false),
        ("--format plot", args.format == Format::Plot, false),
        ("--plots", args.plots.is_asked(), false),
    ];
    let mut errors = Vec::new();
    for (name, _, writes) in options.into_iter().filter(|(_, is_given, _)| *is_given) {
        if is_list {
            errors.push(Note::usage(format!("{name} takes one job; name one file")));
        }
        if writes && !args.policy.is_empty() {
            let what = "the written file would not say what --policy sets; put it into the job";
            errors.push(Note::usage(format!("{name}: {what}")));
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

fn rendered(
    jobs: &[&AdvisedJob],
    format: Format,
    is_list: bool,
    colour: bool,
) -> Result<String, Failure> {
    use report::advise::{json, svg, text};
    let internal = |error: &dyn std::fmt::Display| Failure::Internal(error.to_string());
    match (format, jobs) {
        (Format::Text, [job]) if !is_list => Ok(text::advice(job, colour)),
        (Format::Text, _) => Ok(text::advice_list(jobs, colour)),
        (Format::Json, [job]) if !is_list => json::advice(job).map_err(|error| internal(&error)),
        (Format::Json, _) => json::advice_list(jobs).map_err(|error| internal(&error)),
        (Format::Plot, _) => {
            Ok(jobs.iter().map(|job| svg::advice(job).characters(colour)).collect())
        }
        (Format::Svg | Format::Html, _) => {
            Ok(jobs.iter().map(|job| svg::advice(job).svg()).collect())
        }
    }
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
            By::Depth => Objective::Depth,
        },
        feed: match args.feed {
            Feed::ChipLoad => FeedRule::ChipLoad,
            Feed::Programmed => FeedRule::Programmed,
        },
        schedule: args.schedule,
    }
}
