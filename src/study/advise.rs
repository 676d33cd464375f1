//! One job → what to run instead, and the job and program that say so.

use std::path::{Path, PathBuf};

use crate::advice::{self, JobAdvice, NoForce, OperationAdvice, Remedy};
pub use crate::advice::{FeedRule, Objective, Options};
use crate::input::{
    Advised as AdvisedOperation, OperationEdit, confirm_rewritten, read_job, rewritten_job,
    rewritten_program,
};
use crate::job::{
    Acceptance, Carried, Drill, Job, Levers, MeasuredAt, Operation, Settings, Spindle, SpindleSpeed,
};
use crate::notes::{Code, Note, Part, Place};
use crate::program::{NewSpeed, Rewrite};
use crate::progress::Progress;
use crate::risk::{Warning, warnings};
use crate::units::{Date, m_per_s_from_mm_per_min, mm_from_m, mm_per_min_from_m_per_s};

use super::{Output, PolicyOverrides, Read};

/// A job and what to do about it: all that a renderer needs, without the model.
#[derive(Debug, Clone, PartialEq)]
pub struct AdvisedJob {
    /// What the job is called.
    pub name: String,
    /// The job file, as it was named by the caller.
    pub file: PathBuf,
    /// The spindle.
    pub spindle: Spindle,
    /// What the tip carries: in the first operation, or in one of which nobody says it.
    pub carried: Carried,
    /// Whether the program states a spindle speed, not the job.
    pub is_speed_of_program: bool,
    /// What comes from the settings that jobs share.
    pub settings: Option<Settings>,
    /// Keys of the policy that the run sets: `separation_percent=8`.
    pub overrides: Vec<String>,
    /// What the job offers to be changed.
    pub levers: Levers,
    /// Per operation, whether its path is one of poses alone, which can be turned and moved.
    pub has_poses: Vec<bool>,
    /// What to do.
    pub advice: JobAdvice,
    /// Crossings that are accepted: advice keeps clear of them all the same.
    pub accepted_crossings: Vec<Acceptance>,
    /// On the files that were read, then on the operations.
    pub warnings: Vec<Warning>,
    /// The job as advised, where it was asked for and can be run.
    pub written_job: Option<PathBuf>,
    /// The program as advised, where it was asked for and can be rewritten.
    pub written_program: Option<PathBuf>,
}

impl AdvisedJob {
    /// Whether every operation can be run clear of every band, and within the limits of the policy.
    pub fn can_be_run(&self) -> bool {
        self.advice.is_clear() && !self.exceeds_a_limit()
    }

    /// Whether what is advised exceeds a limit of the policy, which the job does not accept.
    pub fn exceeds_a_limit(&self) -> bool {
        self.warnings.iter().any(Warning::is_open_breach)
    }

    /// Puts together what was asked and what was found.
    pub fn new(job: &Job, advice: JobAdvice) -> Self {
        Self {
            name: job.name.clone(),
            file: job.file.clone(),
            spindle: job.spindle,
            carried: job.carried(),
            is_speed_of_program: job.operations.iter().any(|each| each.is_speed_of_program),
            settings: job.review.settings.clone(),
            overrides: job.review.overrides.clone(),
            levers: job.levers.clone(),
            accepted_crossings: job.review.crossings().cloned().collect(),
            has_poses: job.operations.iter().map(Operation::has_poses).collect(),
            warnings: warnings(job, job.review.warnings.iter().chain(&advice.warnings).cloned()),
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
    /// Why a file is not written.
    pub not_written: Vec<Note>,
}

/// Reads a job file and what it names, with what it accepts on a day.
pub fn read(file: &Path, today: Date) -> Read<Job> {
    read_under(file, today, &PolicyOverrides::default())
}

/// The same with keys of the policy that win over those of the files.
pub fn read_under(file: &Path, today: Date, policy: &PolicyOverrides) -> Read<Job> {
    let mut read = Read::of(|reading| {
        reading.policy = policy.clone();
        read_job(file, reading)
    });
    if let Ok(job) = &mut read.value {
        job.expire(today);
        read.warnings.clone_from(&job.review.warnings);
    }
    read
}

/// Advises a job of which `files` were read.
///
/// # Errors
/// What cannot be run; an objective that cannot be evaluated; a file that cannot be rewritten so
/// that it reads as advised.
pub fn advise(
    job: &Job,
    files: &[PathBuf],
    options: &Options,
    to: WriteTo,
    progress: Progress,
) -> Result<Advised, Vec<Note>> {
    refuse_stopped(job)?;
    let found = advice::advise(job, options, progress)?;
    match options.objective {
        Objective::Vibration => {
            refuse_unknown_force(job, &found.operations, Objective::Vibration)?;
        }
        Objective::Depth => {
            refuse_unknown_force(job, &found.operations, Objective::Depth)?;
            refuse_without_depth(job, &found.operations)?;
        }
        Objective::Nearest | Objective::Margin | Objective::Highest => {}
    }
    // What stops the writing comes behind what was to be known before.
    let before = found.warnings.clone();
    let stopped = |error: Note| before.iter().cloned().chain([error]).collect::<Vec<_>>();
    let mut advised =
        Advised { not_written: Vec::new(), job: AdvisedJob::new(job, found), outputs: Vec::new() };
    let operations = &advised.job.advice.operations;
    let unsafe_one = operations.iter().find(|operation| !operation.remedy.is_clear());
    let no_speed = unsafe_one.map(|operation| match &operation.unchecked {
        Some(why) => format!("operation '{}': {why}", operation.name),
        None => format!("operation '{}' has no speed clear of every band", operation.name),
    });
    let exceeding = advised.job.warnings.iter().find(|warning| warning.is_open_breach());
    let why = no_speed.or_else(|| exceeding.map(|warning| warning.note.what.clone()));
    if let Some(path) = to.program {
        match &why {
            Some(why) => advised.not_written.push(not_written(path, why)),
            None => {
                let lost = lost_with_program(job, operations, options.feed);
                let lost = lost.filter(|_| to.job.is_none());
                let rewrite = lost
                    .map_or_else(|| program_rewrite(job, operations, options.feed), Err)
                    .map_err(|why| stopped(refused(path, &why)))?;
                let file = job.beside(rewrite.0);
                let rewritten = rewritten_program(&job.file, &file, &rewrite.1).map_err(stopped)?;
                advised.outputs.push(Output::new(path, rewritten.bytes));
                let shared = rewritten.beside.into_iter().map(|(line, what)| {
                    Note::warning(Code::SharedNumber, Place::line(&file, line), what)
                });
                advised.job.warnings.extend(warnings(job, shared));
                advised.job.written_program = Some(path.to_owned());
            }
        }
    }
    if let Some(path) = to.job {
        match &why {
            Some(why) => advised.not_written.push(not_written(path, why)),
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

/// A program that never starts the spindle has no speed that another could be near to.
fn refuse_stopped(job: &Job) -> Result<(), Vec<Note>> {
    let stopped = |each: &&Operation| each.speed == SpindleSpeed::Constant(0.0);
    let Some(operation) = job.operations.iter().find(stopped) else { return Ok(()) };
    let what = format!(
        "operation '{}': the program has stopped the spindle on the whole path, so there is no \
         speed to advise; let the program start it",
        operation.name
    );
    let place = Place { line: Some(operation.line), ..Place::file(&job.file) };
    Err(vec![Note::error(Code::Conflict, place, what)])
}

fn refused(path: &Path, why: &str) -> Note {
    Note::error(Code::NotWritten, Place::file(path), format!("is not written: {why}"))
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
    let both: Vec<(&Operation, &OperationAdvice)> =
        job.operations.iter().zip(&advice.operations).collect();
    let mut edits = Vec::new();
    for entry in both.chunk_by(|(a, _), (b, _)| a.entry == b.entry) {
        let edit = entry_edit(entry, program.is_some()).map_err(|why| refused(path, &why))?;
        let rewritten = program.filter(|_| entry.iter().any(|(o, _)| o.program.is_some()));
        edits.push(OperationEdit { program: rewritten.map(|(path, _)| path.to_owned()), ..edit });
    }
    let advised: Vec<AdvisedOperation> = both
        .iter()
        .map(|(operation, advice)| {
            let feed = edits.get(operation.entry).and_then(|edit| edit.feed_mm_per_min);
            let feed = feed.map_or(operation.feed_m_per_s, m_per_s_from_mm_per_min);
            AdvisedOperation {
                speed: new_speed(advice).unwrap_or_else(|| operation.speed.clone()),
                feed_m_per_s: operation.is_feed_of_job.then_some(feed),
            }
        })
        .collect();
    let text = rewritten_job(&job.file, path, &edits)?;
    confirm_rewritten(job, files, &text, path, &advised, program)?;
    Ok(text)
}

/// The speed that an operation is to have instead of its own.
fn new_speed(advice: &OperationAdvice) -> Option<SpindleSpeed> {
    match &advice.remedy {
        Remedy::Constant(constant) if !constant.is_programmed => {
            Some(SpindleSpeed::Constant(constant.rpm))
        }
        Remedy::Scheduled(schedule) => Some(SpindleSpeed::Schedule(schedule.points.clone())),
        Remedy::Constant(_) | Remedy::Kept(_) | Remedy::Infeasible => None,
    }
}

fn new_feed_m_per_s(advice: &OperationAdvice) -> f64 {
    match &advice.remedy {
        Remedy::Constant(constant) if !constant.is_programmed => constant.feed_m_per_s,
        Remedy::Scheduled(schedule) => schedule.feed_m_per_s,
        Remedy::Constant(_) | Remedy::Kept(_) | Remedy::Infeasible => {
            advice.programmed_feed_m_per_s
        }
    }
}

/// What changes in an entry of the job, which the program may have divided.
fn entry_edit(
    stretches: &[(&Operation, &OperationAdvice)],
    is_program_written: bool,
) -> Result<OperationEdit, String> {
    let changed = |of_program: bool| {
        let own = stretches.iter().filter(move |(o, _)| o.is_speed_of_program == of_program);
        own.filter_map(|(operation, advice)| Some((operation, new_speed(advice)?)))
    };
    if let (Some((operation, _)), false) = (changed(true).next(), is_program_written) {
        return Err(format!(
            "operation '{}': its speed stands in the program; write it with --write-program FILE",
            operation.name
        ));
    }
    if let Some((operation, SpindleSpeed::Schedule(_))) = changed(true).next() {
        return Err(format!(
            "operation '{}' needs a spindle_schedule, which no program can state",
            operation.name
        ));
    }
    let of_job: Vec<_> =
        stretches.iter().filter(|(operation, _)| !operation.is_speed_of_program).collect();
    // The job's number is that of the stretches on which the program is silent, else of all.
    let said: Vec<_> = if of_job.is_empty() { stretches.iter().collect() } else { of_job };
    let speeds: Vec<SpindleSpeed> = said
        .iter()
        .map(|(operation, advice)| new_speed(advice).unwrap_or_else(|| operation.speed.clone()))
        .collect();
    let is_one = speeds.windows(2).all(|pair| pair[0] == pair[1]);
    let changes = said.iter().any(|(_, advice)| new_speed(advice).is_some());
    if let (false, true, [(operation, _), ..]) = (is_one, changes, said.as_slice())
        && !operation.is_speed_of_program
    {
        return Err(format!(
            "operation '{}' needs a speed for each of its tools; state them in the program",
            operation.name
        ));
    }
    let first = said.first();
    let feed = first.map(|(_, advice)| (new_feed_m_per_s(advice), advice.programmed_feed_m_per_s));
    // Feeds that the program states stay there, and a feed of the job must not contradict them.
    let stays = !is_program_written && said.iter().any(|(o, _)| o.program_feeds.any());
    let feed = feed.filter(|(new, old)| new != old && !stays).map(|(new, _)| written_feed(new));
    let edit = OperationEdit {
        speed: speeds.into_iter().next().filter(|_| changes && is_one),
        feed_mm_per_min: feed,
        ..OperationEdit::default()
    };
    let rewritten = is_program_written && stretches.iter().any(|(o, _)| o.program.is_some());
    let has_other_chip = rewritten || edit != OperationEdit::default();
    let measured = first.and_then(|(operation, _)| programmed_at_m_per_rev(operation));
    let measured = measured.filter(|_| has_other_chip).map(mm_from_m);
    Ok(OperationEdit { measured_at_mm_per_rev: measured, ..edit })
}

/// The feed at which thrust or torque of a drill are taken as measured, as nobody says it.
fn programmed_at_m_per_rev(operation: &Operation) -> Option<f64> {
    let drill = operation.cutting.as_ref()?.drill().filter(Drill::is_measured)?;
    match drill.measured_at? {
        MeasuredAt::Programmed(m_per_rev) => Some(m_per_rev),
        MeasuredAt::Stated(_) => None,
    }
}

/// mm/min with three decimals, or all digits where that would leave nothing.
fn written_feed(feed_m_per_s: f64) -> f64 {
    let feed = mm_per_min_from_m_per_s(feed_m_per_s);
    let rounded = (feed * 1e3).round() / 1e3;
    if rounded > 0.0 { rounded } else { feed }
}

/// The one program of the job and the speeds that its stretches are to run at, by the operations
/// that run it; or why there is none.
fn program_rewrite<'j>(
    job: &'j Job,
    advice: &[OperationAdvice],
    feed: FeedRule,
) -> Result<(&'j Path, Vec<Rewrite>), String> {
    let mut wanted: Option<(&Path, Vec<Rewrite>)> = None;
    let both: Vec<(&Operation, &OperationAdvice)> = job.operations.iter().zip(advice).collect();
    for entry in both.chunk_by(|(a, _), (b, _)| a.entry == b.entry) {
        let Some((Operation { program: Some(program), .. }, _)) = entry.first() else { continue };
        let mut speeds = Vec::with_capacity(entry.len());
        for (operation, advice) in entry {
            let name = &operation.name;
            let rpm = match &advice.remedy {
                Remedy::Constant(constant) => constant.rpm,
                Remedy::Kept(_) => {
                    return Err(format!(
                        "operation '{name}' keeps its spindle_schedule, which no program can state"
                    ));
                }
                Remedy::Scheduled(_) => {
                    return Err(format!(
                        "operation '{name}' is to vary its speed along the path, which no program \
                         can state; leave out --schedule where a constant speed is safe"
                    ));
                }
                Remedy::Infeasible => {
                    return Err(format!("operation '{name}' has no safe constant speed"));
                }
            };
            speeds.push(NewSpeed {
                end: operation.stretch.end,
                rpm,
                job_rpm: (!operation.is_speed_of_program).then_some(advice.programmed_rpm),
            });
        }
        let this = Rewrite { speeds, keeps_chip_load: feed == FeedRule::ChipLoad };
        let (first, all) = wanted.get_or_insert_with(|| (program.as_path(), Vec::new()));
        if *first != program.as_path() {
            return Err("the operations run several programs; split the job".to_owned());
        }
        all.push(this);
    }
    wanted.ok_or_else(|| "the job runs no program".to_owned())
}

/// What the job no longer says once its program runs at another feed per tooth: where nobody says
/// at which feed a drill was measured, that is the program's.
fn lost_with_program(job: &Job, advice: &[OperationAdvice], feed: FeedRule) -> Option<String> {
    let lost = |(operation, advice): (&Operation, &OperationAdvice)| {
        let has_other_chip = feed != FeedRule::ChipLoad || operation.is_feed_of_job;
        let is_lost = operation.program.is_some() && new_speed(advice).is_some() && has_other_chip;
        programmed_at_m_per_rev(operation).filter(|_| is_lost)
    };
    let at = job.operations.iter().zip(advice).find_map(lost)?;
    Some(format!(
        "thrust and torque of the drill would be taken as measured at the program's new feed per \
         revolution: write the job, too, with --write, or state cutting.measured_at_mm_per_rev: {}",
        mm_from_m(at)
    ))
}

/// What the cut does cannot be made best where it is not known.
fn refuse_unknown_force(
    job: &Job,
    advice: &[OperationAdvice],
    objective: Objective,
) -> Result<(), Vec<Note>> {
    let unknown = job.operations.iter().zip(advice).filter_map(|(operation, advice)| {
        let why = *advice.vibration.as_ref().err()?;
        // It has no vibration, and a limit of chatter.
        if why == NoForce::Steady && objective == Objective::Depth {
            return None;
        }
        let place = Place {
            part: Some(Part::Operation(operation.name.clone())),
            key: "objective",
            ..Place::line(&job.file, operation.line)
        };
        let what = match (why, objective) {
            (NoForce::Steady, _) => format!("{why}, so none is quieter"),
            (_, Objective::Depth) => {
                format!("the depth at which the cut chatters is not known: {why}")
            }
            _ => format!("the vibration of the tool tip is not known: {why}"),
        };
        Some(Note::error(Code::MissingKey, place, what))
    });
    let errors: Vec<Note> = unknown.collect();
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

/// A cut that does not regenerate chatters at one depth, whatever the speed.
fn refuse_without_depth(job: &Job, advice: &[OperationAdvice]) -> Result<(), Vec<Note>> {
    let all = job.operations.iter().zip(advice).filter(|(_, advice)| advice.depth.is_none());
    let errors: Vec<Note> = all
        .map(|(operation, _)| {
            let place = Place {
                part: Some(Part::Operation(operation.name.clone())),
                key: "objective",
                ..Place::line(&job.file, operation.line)
            };
            let what = "the depth at which the cut chatters does not depend on the speed, or is \
                        not known: 'cutting' says regeneration: false or has no coefficients, or \
                        nothing cuts";
            Note::error(Code::Conflict, place, what)
        })
        .collect();
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}
