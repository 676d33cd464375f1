//! `detune deflection`: how far the tool tip gives way at rest.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::{Args, ValueEnum};

use super::map::{grid_range, named_value};
use super::output::Sink;
use super::{Failure, Outcome, Warnings, of_option, robot_file};
use crate::notes::Note;
use crate::report::deflection::{deflection_csv, deflection_json, deflection_text};
use crate::study::Read;
use crate::study::deflection::{Load, Subject, of_job, of_robot, read};
use crate::study::map::{Positions, Request, Robot, Source};
use crate::units::Date;

/// Compute the static deflection of the tool tip under gravity and under a force.
#[derive(Debug, Args)]
#[command(
    after_help = "Of a job, along its paths, the force is the mean cutting force, with the torque \
                  of a drill, unless --force-n or --moment-nm is given.\n\nExamples:\n  \
                  detune deflection robots/irb1600 --at joint_2=20 --force-n 0,0,-500\n  \
                  detune deflection robot.yaml --grid joint_2=-60:90:16 --force-n 100,0,0 \
                  --format csv\n  detune deflection jobs/pocket.yaml"
)]
pub(super) struct DeflectionArgs {
    /// A robot.yaml, the folder that holds one, or a job.
    #[arg(value_name = "ROBOT|JOB")]
    subject: PathBuf,
    /// Force on the tool tip in the base frame, N.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = force)]
    force_n: Option<[f64; 3]>,
    /// Moment on the tool in the base frame, N m.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = moment)]
    moment_nm: Option<[f64; 3]>,
    /// Of a robot: the tool tip in the frame of its tip link, m; its origin if absent.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = tip)]
    tcp_m: Option<[f64; 3]>,
    /// Of a robot: N positions of a joint from A to B, both included, degrees (mm for a sliding
    /// joint); repeat it for all combinations with other joints.
    #[arg(long, value_name = "NAME=A:B:N", value_parser = grid_range, conflicts_with = "poses")]
    grid: Vec<Positions>,
    /// Of a robot: position of a joint that stands, degrees (mm for a sliding joint); zero if
    /// absent.
    #[arg(long, value_name = "NAME=DEG", value_parser = named_value, conflicts_with = "poses")]
    at: Vec<(String, f64)>,
    /// Of a robot: poses as CSV or .npy, as `map` takes them; `-` is standard input.
    #[arg(long, value_name = "FILE")]
    poses: Option<PathBuf>,
    /// Output format.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Write to this file instead of standard output (`-`); a run that fails leaves it unchanged.
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Readable text: of several poses the one that moves most.
    Text,
    /// JSON, all poses.
    Json,
    /// CSV, one row a pose.
    Csv,
}

/// Three numbers of at most `most`, in `unit`.
fn three(text: &str, most: f64, unit: &str) -> Result<[f64; 3], String> {
    let wrong = || "must be three numbers, X,Y,Z".to_owned();
    let parts: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let parts: [f64; 3] = parts.map_err(|_| wrong())?.try_into().map_err(|_| wrong())?;
    match parts.iter().all(|part| part.abs() <= most) {
        true => Ok(parts),
        false => Err(format!("each must be from -{most} to {most} {unit}")),
    }
}

fn force(text: &str) -> Result<[f64; 3], String> {
    three(text, 1e6, "N")
}

fn moment(text: &str) -> Result<[f64; 3], String> {
    three(text, 1e6, "N m")
}

fn tip(text: &str) -> Result<[f64; 3], String> {
    three(text, 10.0, "m")
}

/// Writes the deflections.
pub(super) fn run(
    args: &DeflectionArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let Read { value: subject, warnings, files } =
        read(&robot_file(&args.subject), Date::of(SystemTime::now()));
    sink.refuse_inputs(files.iter().chain(&args.poses))?;
    shown.show(&warnings);
    let load = Load {
        force_n: args.force_n,
        moment_nm: args.moment_nm,
        tcp_m: args.tcp_m.unwrap_or_default(),
    };
    let found = match &subject? {
        Subject::Job(job) => {
            for (name, is_given) in [
                ("--tcp-m", args.tcp_m.is_some()),
                ("--grid", !args.grid.is_empty()),
                ("--at", !args.at.is_empty()),
                ("--poses", args.poses.is_some()),
            ] {
                if is_given {
                    let what = format!("{name} has no effect on a job, which has its own");
                    return Err(vec![Note::usage(what)].into());
                }
            }
            of_job(job, &load)?
        }
        Subject::Robot(robot) => of_robot(robot, source(args, robot)?, &load)?,
    };
    shown.show(&found.warnings);
    let text = match args.format {
        Format::Text => deflection_text(&found),
        Format::Json => {
            deflection_json(&found).map_err(|error| Failure::Internal(error.to_string()))?
        }
        Format::Csv => deflection_csv(&found),
    };
    sink.write(&text, out)?;
    Ok(Outcome::Pass)
}

fn source(args: &DeflectionArgs, robot: &Robot) -> Result<Source, Vec<Note>> {
    match &args.poses {
        Some(path) if path == Path::new("-") => {
            Source::from_reader(Box::new(io::stdin().lock()), path, robot)
        }
        Some(path) => Source::open(path, robot),
        None => {
            let request = Request::Grid { axes: args.grid.clone(), at: args.at.clone() };
            Source::new(&request, robot)
                .map_err(|errors| errors.into_iter().map(of_option).collect())
        }
    }
}
