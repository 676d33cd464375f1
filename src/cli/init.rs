//! `detune init`: a URDF in, the first files for it out.

use std::io::{self, BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::{Args, ValueEnum};

use super::output::{Sink, write_all};
use super::staged::Passing;
use super::{Failure, Outcome, Warnings};
use crate::notes::{Code, Note, Place};
use crate::paths::folder_of;
use crate::progress::silent;
use crate::report::init::report;
use crate::study::check::{Checked, ReadJobs};
use crate::study::init::{self as study, Scaffold, read, scaffold};
use crate::study::{Output, Read};
use crate::units::Date;

const AFTER_HELP: &str = "\
Examples:
  detune init arm.urdf --total-mass-kg 250
  detune init arm.urdf --output cell-3 --ci gitlab

Springs are guessed from arms of similar reach and marked so; no verdict is better than uncertain \
until they are replaced. A mass is never guessed. No file is written over.";

/// Write the first files for a robot: robot.yaml, a job, and a CI workflow.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct InitArgs {
    /// URDF of the arm (expanded, if it is xacro).
    #[arg(value_name = "ROBOT.urdf")]
    urdf: PathBuf,
    /// Mass of the whole arm, kg, from its data sheet, where the URDF has no masses.
    #[arg(long, value_name = "M")]
    total_mass_kg: Option<f64>,
    /// Folder for the files; that of the URDF if not given.
    #[arg(long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Which CI to write a workflow for.
    #[arg(long, value_enum, default_value_t = Ci::Github)]
    ci: Ci,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Ci {
    /// .github/workflows/detune.yml
    Github,
    /// detune.gitlab-ci.yml
    Gitlab,
    /// No file.
    None,
}

/// Writes the files, reads them back and checks the job; if that fails, none of them stays.
pub(super) fn run(
    args: &InitArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let Read { value: urdf, warnings, .. } = read(&args.urdf);
    shown.show(&warnings);
    let urdf = urdf?;
    let folder = args.output.as_deref().unwrap_or_else(|| folder_of(&args.urdf));
    let ci = match args.ci {
        Ci::Github => study::Ci::Github,
        Ci::Gitlab => study::Ci::Gitlab,
        Ci::None => study::Ci::None,
    };
    let total_mass_kg = match args.total_mass_kg {
        None if urdf.lacks_mass() => asked_mass()?,
        given => given,
    };
    let scaffold = scaffold(&urdf, folder, total_mass_kg, ci).map_err(|error| vec![error])?;
    refuse_to_replace(&scaffold)?;
    let files: Vec<&Output> = scaffold.files.iter().chain(&scaffold.ci).collect();
    // They go again unless all of them are good.
    let mut made = Passing::default();
    for file in &files {
        let folder = folder_of(&file.path);
        made.make_folders(folder).map_err(|error| {
            let what = format!("this folder cannot be made: {error}");
            vec![Note::error(Code::Unwritable, Place::file(folder), what)]
        })?;
        made.add(&file.path);
    }
    let sinks: Vec<Sink> = files.iter().map(|file| Sink::File(file.path.clone())).collect();
    let outputs: Vec<(&Sink, &[u8])> =
        sinks.iter().zip(&files).map(|(sink, file)| (sink, file.bytes.as_slice())).collect();
    write_all(&outputs, &mut io::sink())?;
    let job = folder.join("jobs/first.yaml");
    let today = Date::of(SystemTime::now());
    let Checked { jobs, warnings, errors } = ReadJobs::read(&[job], today).check(&silent);
    if !errors.is_empty() {
        return Err(errors.into());
    }
    shown.show_of_jobs(&warnings);
    made.keep();
    let written: Vec<&Path> = files.iter().map(|file| file.path.as_path()).collect();
    Sink::Standard.write(&report(&written, &scaffold.guessed, &jobs), out)?;
    Ok(Outcome::Pass)
}

/// No file is written over.
fn refuse_to_replace(scaffold: &Scaffold) -> Result<(), Vec<Note>> {
    let is_there = |file: &&Output| file.path.symlink_metadata().is_ok();
    let taken = |file: &Output, what: &str| {
        let what = format!("is there already, so nothing is written; {what}");
        Note::error(Code::Unwritable, Place::file(&file.path), what)
    };
    let files = scaffold.files.iter().filter(is_there);
    let mut errors: Vec<Note> =
        files.map(|file| taken(file, "name another folder with --output")).collect();
    if let Some(file) = scaffold.ci.as_ref().filter(is_there) {
        let jobs = scaffold.jobs.display();
        errors.push(taken(file, &format!("give --ci none, and let it check '{jobs}', too")));
    }
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

/// Asks for the mass of the arm where somebody can answer.
fn asked_mass() -> Result<Option<f64>, Vec<Note>> {
    if !(io::stdin().is_terminal() && io::stderr().is_terminal()) {
        return Ok(None);
    }
    let mut err = io::stderr().lock();
    let _ = write!(err, "The URDF has no masses. Mass of the whole arm, kg, from its data sheet: ");
    let _ = err.flush();
    let mut answer = String::new();
    // What cannot be read is no answer.
    let _ = io::stdin().lock().read_line(&mut answer);
    match answer.trim() {
        "" => Ok(None),
        text => text
            .parse()
            .map(Some)
            .map_err(|_| vec![Note::usage(format!("'{text}' is not a mass in kg"))]),
    }
}
