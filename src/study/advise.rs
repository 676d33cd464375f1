//! One job → what to run instead, and the job and program that say so.

use std::path::{Path, PathBuf};

use crate::advice::{self, JobAdvice, OperationAdvice, Remedy};
pub use crate::advice::{FeedRule, Objective, Options};
use crate::input::{OperationEdit, confirm_rewritten, read_job, rewritten_job, rewritten_program};
use crate::job::{Job, Levers, Operation, Spindle, SpindleSpeed};
use crate::notes::{Code, Note, Part, Place};
use crate::program::Rewrite;
use crate::progress::Progress;
use crate::units::mm_per_min_from_m_per_s;

use super::{Output, Read};

/// A job and what to do about it: all that a renderer needs, without the model.
#[derive(Debug, Clone, PartialEq)]
pub struct AdvisedJob {
    /// What the job is called.
    pub name: String,
    /// The job file, as it was named by the caller.
    pub file: PathBuf,
    /// The spindle.
    pub spindle: Spindle,
    /// What the job offers to be changed.
    pub levers: Levers,
    /// Per operation, whether its path is one of poses alone, which can be turned and moved.
    pub has_poses: Vec<bool>,
    /// What to do.
    pub advice: JobAdvice,
    /// The job as advised, where it was asked for and can be run.
    pub written_job: Option<PathBuf>,
    /// The program as advised, where it was asked for and can be rewritten.
    pub written_program: Option<PathBuf>,
}

impl AdvisedJob {
    /// Puts together what was asked and what was found.
    pub fn new(job: &Job, advice: JobAdvice) -> Self {
        Self {
            name: job.name.clone(),
            file: job.file.clone(),
            spindle: job.spindle,
            levers: job.levers.clone(),
            has_poses: job.operations.iter().map(Operation::has_poses).collect(),
            advice,
            written_job: None,
            written_program: None,
        }
    }
}

/// Files that shall say what is advised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WriteTo<'a> {
    /// For the job.
    pub job: Option<&'a Path>,
    /// For the program that the job runs.
    pub program: Option<&'a Path>,
}

/// Advice, and what is to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Advised {
    /// What was found.
    pub job: AdvisedJob,
    /// The files that were asked for, those of them that can be written.
    pub outputs: Vec<Output>,
    /// Warnings of the advice, and why a file is not written.
    pub warnings: Vec<Note>,
}

/// Reads a job file and what it names.
pub fn read(file: &Path) -> Read<Job> {
    Read::of(|reading| read_job(file, reading))
}

/// Advises a job of which `files` were read.
///
/// # Errors
/// What cannot be run; an objective that cannot be evaluated; a file that cannot be rewritten so that it reads as
/// advised.
pub fn advise(
    job: &Job,
    files: &[PathBuf],
    options: &Options,
    to: WriteTo,
    progress: Progress,
) -> Result<Advised, Vec<Note>> {
    let found = advice::advise(job, options, progress)?;
    if options.objective == Objective::Vibration {
        refuse_unknown_vibration(job, &found.operations)?;
    }
    // What stops the writing comes behind what was to be known before.
    let warnings = found.warnings.clone();
    let stopped = |error: Note| warnings.iter().cloned().chain([error]).collect::<Vec<_>>();
    let mut advised = Advised {
        warnings: warnings.clone(),
        job: AdvisedJob::new(job, found),
        outputs: Vec::new(),
    };
    let operations = &advised.job.advice.operations;
    if let Some(path) = to.program {
        match program_rewrite(job, operations) {
            Ok((program, rewrite)) => {
                let file = job.beside(program);
                match rewritten_program(&file, &rewrite).map_err(stopped)? {
                    Ok(rewritten) => {
                        advised.outputs.push(Output::new(path, rewritten.bytes));
                        advised.job.written_program = Some(path.to_owned());
                    }
                    Err(why) => advised.warnings.push(why),
                }
            }
            Err(why) => advised.warnings.push(not_written(path, &why)),
        }
    }
    if let Some(path) = to.job {
        match operations.iter().find(|operation| !operation.remedy.is_clear()) {
            Some(operation) => {
                let why =
                    format!("operation '{}' has no speed clear of every band", operation.name);
                advised.warnings.push(not_written(path, &why));
            }
            None => {
                let text = job_text(job, files, &advised.job.advice, path, advised.outputs.first())
                    .map_err(stopped)?;
                advised.outputs.push(Output::new(path, text.into_bytes()));
                advised.job.written_job = Some(path.to_owned());
            }
        }
    }
    Ok(advised)
}

fn not_written(path: &Path, why: &str) -> Note {
    Note::warning(Code::NotWritten, Place::file(path), format!("is not written: {why}"))
}

/// The text of the job as advised, read again, with the program that is about to be written, and
/// found to be that.
fn job_text(
    job: &Job,
    files: &[PathBuf],
    advice: &JobAdvice,
    path: &Path,
    program: Option<&Output>,
) -> Result<String, Note> {
    let program = program.map(|output| (output.path.as_path(), output.bytes.as_slice()));
    let edits: Vec<OperationEdit> = job
        .operations
        .iter()
        .zip(&advice.operations)
        .map(|(operation, advice)| OperationEdit {
            program: program
                .filter(|_| operation.program.is_some())
                .map(|(path, _)| path.to_owned()),
            ..edit(advice)
        })
        .collect();
    let text = rewritten_job(&job.file, path, &edits)?;
    confirm_rewritten(job, files, &text, path, &edits, program)?;
    Ok(text)
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

/// mm/min with three decimals, or all digits where that would leave nothing.
fn written_feed(feed_m_per_s: f64) -> f64 {
    let feed = mm_per_min_from_m_per_s(feed_m_per_s);
    let rounded = (feed * 1e3).round() / 1e3;
    if rounded > 0.0 { rounded } else { feed }
}

/// The one program of the job, and the one constant speed that its operations are to run at; or why
/// there is none.
fn program_rewrite<'j>(
    job: &'j Job,
    advice: &[OperationAdvice],
) -> Result<(&'j Path, Rewrite), String> {
    let mut wanted: Option<(&Path, Rewrite)> = None;
    for (operation, advice) in job.operations.iter().zip(advice) {
        let Some(program) = &operation.program else { continue };
        let name = &operation.name;
        let constant = match &advice.remedy {
            Remedy::Constant(constant) => constant,
            Remedy::Kept(_) => {
                return Err(format!(
                    "operation '{name}' keeps its spindle_schedule, which no program can state"
                ));
            }
            Remedy::Scheduled(_) | Remedy::Infeasible => {
                return Err(format!("operation '{name}' has no safe constant speed"));
            }
        };
        let feed_ratio = constant.feed_m_per_s / advice.programmed_feed_m_per_s;
        let this = (program.as_path(), Rewrite { rpm: constant.rpm, feed_ratio });
        if wanted.is_some_and(|before| before != this) {
            return Err(
                "the operations run several programs, or one program at several speeds; split the job"
                    .to_owned(),
            );
        }
        wanted = Some(this);
    }
    wanted.ok_or_else(|| "the job runs no program".to_owned())
}

/// Vibration cannot be made least where it is not known.
fn refuse_unknown_vibration(job: &Job, advice: &[OperationAdvice]) -> Result<(), Vec<Note>> {
    let unknown = job.operations.iter().zip(advice).filter_map(|(operation, advice)| {
        let why = advice.vibration.as_ref().err()?;
        let place = Place {
            part: Some(Part::Operation(operation.name.clone())),
            key: "objective",
            ..Place::line(&job.file, operation.line)
        };
        let what = format!("the vibration of the tool tip is not known: {why}");
        Some(Note::error(Code::MissingKey, place, what))
    });
    let errors: Vec<Note> = unknown.collect();
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}
