//! One function a verb, each with its result as JSON.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use detune::advice::{FeedRule, Objective, Options};
use detune::notes::{Code, Note, Place};
use detune::progress::silent;
use detune::report;
use detune::study::advise::WriteTo;
use detune::study::check::{ReadJobs, Samples};
use detune::study::map::{self as maps, FrequencyMap, Head, MapError, Positions, Request, Source};
use detune::study::{self, PolicyOverrides, Read};
use detune::units::Date;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::fault::{internal, raised};

/// The job files that files, folders and patterns name, as on the command line.
#[pyfunction]
pub(crate) fn job_files(py: Python<'_>, jobs: Vec<PathBuf>) -> PyResult<Vec<PathBuf>> {
    // What checks nothing would be clear.
    if jobs.is_empty() {
        let what = "no job is given: name job files, folders or patterns";
        return Err(raised(py, &[Note::usage(what.to_owned())]));
    }
    study::job_files(&jobs).map_err(|notes| raised(py, &notes))
}

#[pyfunction]
pub(crate) fn check(
    py: Python<'_>,
    jobs: Vec<PathBuf>,
    policy: Vec<String>,
    samples: &str,
) -> PyResult<String> {
    let samples = match samples {
        "none" => Samples::None,
        "thin" => Samples::Thin,
        "all" => Samples::All,
        other => return Err(unknown("samples", other, "none, thin, all")),
    };
    let policy = PolicyOverrides::parse(&policy).map_err(|notes| raised(py, &notes))?;
    let files = job_files(py, jobs)?;
    let today = Date::of(SystemTime::now());
    let mut checked = py.detach(|| ReadJobs::read_under(&files, today, &policy).check(&silent));
    if !checked.errors.is_empty() {
        return Err(raised(py, &checked.errors));
    }
    samples.keep(&mut checked.jobs);
    report::check::json::check(&checked.jobs).map_err(internal)
}

/// Advice on one job, or on several as a list.
#[pyfunction]
pub(crate) fn advise(
    py: Python<'_>,
    jobs: Vec<PathBuf>,
    is_list: bool,
    objective: &str,
    feed: &str,
    schedule: bool,
    policy: Vec<String>,
) -> PyResult<String> {
    let options = Options {
        objective: match objective {
            "nearest" => Objective::Nearest,
            "margin" => Objective::Margin,
            "highest" => Objective::Highest,
            "vibration" => Objective::Vibration,
            "depth" => Objective::Depth,
            other => {
                let all = "nearest, margin, highest, vibration, depth";
                return Err(unknown("objective", other, all));
            }
        },
        feed: match feed {
            "chip-load" => FeedRule::ChipLoad,
            "programmed" => FeedRule::Programmed,
            other => return Err(unknown("feed", other, "chip-load, programmed")),
        },
        schedule,
    };
    let policy = PolicyOverrides::parse(&policy).map_err(|notes| raised(py, &notes))?;
    if !is_list && !study::is_one_file(&jobs) {
        let what = "names several jobs: detune.advise_all takes folders and patterns";
        let place = Place::file(jobs.first().cloned().unwrap_or_default());
        return Err(raised(py, &[Note::error(Code::Usage, place, what)]));
    }
    let files = job_files(py, jobs)?;
    let today = Date::of(SystemTime::now());
    let (mut all, mut errors) = (Vec::new(), Vec::new());
    py.detach(|| {
        for file in &files {
            let Read { value, files, .. } = study::advise::read_under(file, today, &policy);
            let to = WriteTo { job: None, program: None };
            let one = |job| study::advise::advise(&job, &files, &options, to, &silent);
            match value.and_then(one) {
                Ok(advised) => all.push(advised.job),
                Err(own) => errors.extend(own),
            }
        }
    });
    if !errors.is_empty() {
        return Err(raised(py, &errors));
    }
    match all.as_slice() {
        [one] if !is_list => report::advise::json::advice(one).map_err(internal),
        all => report::advise::json::advice_list(&all.iter().collect::<Vec<_>>()).map_err(internal),
    }
}

#[pyfunction]
pub(crate) fn identify(py: Python<'_>, session: PathBuf) -> PyResult<(String, String)> {
    let found = py.detach(|| {
        let session = study::identify::read(&session).value?;
        Ok::<_, Vec<Note>>(study::identify::identify(&session, &silent))
    });
    let found = found.map_err(|notes| raised(py, &notes))?;
    let json = report::identify::identification_json(&found).map_err(internal)?;
    Ok((json, report::identify::measured_csv(&found)))
}

#[pyfunction]
pub(crate) fn diagnose(
    py: Python<'_>,
    robot: PathBuf,
    measured: PathBuf,
    seed: u64,
) -> PyResult<(String, String)> {
    let robot = if robot.is_dir() { robot.join("robot.yaml") } else { robot };
    let found = py.detach(|| {
        let read = study::diagnose::read(&robot, &measured).value?;
        let settings = study::diagnose::Settings { seed };
        let found = study::diagnose::diagnose(&read, &measured, settings, &silent)?;
        let date = Date::of(SystemTime::now()).to_string();
        // Beside the robot's file its relative paths hold.
        let beside = robot.with_file_name("calibrated.yaml");
        let written = found.update.output(&robot, &beside, &date)?;
        Ok::<_, Vec<Note>>((found, written))
    });
    let (found, written) = found.map_err(|notes| raised(py, &notes))?;
    let json = report::diagnosis::json::diagnosis(&found).map_err(internal)?;
    Ok((json, String::from_utf8(written.bytes).map_err(internal)?))
}

/// A map as `map/1`; axes are (joint, from, to, steps) in degrees or mm.
#[pyfunction]
pub(crate) fn map(
    py: Python<'_>,
    robot: PathBuf,
    axes: Vec<(String, f64, f64, usize)>,
    at: Vec<(String, f64)>,
    intervals: bool,
    shapes: bool,
) -> PyResult<String> {
    let robot = if robot.is_dir() { robot.join("robot.yaml") } else { robot };
    let axes = axes.into_iter().map(|(joint, from, to, steps)| Positions {
        joint,
        from,
        to,
        steps,
        unit: maps::Unit::DegOrMm,
    });
    let request = Request::Grid { axes: axes.collect(), at };
    let bytes = py.detach(|| mapped(&robot, &request, intervals, shapes));
    let bytes = bytes.map_err(|notes| raised(py, &notes))?;
    String::from_utf8(bytes).map_err(internal)
}

fn mapped(
    robot: &Path,
    request: &Request,
    intervals: bool,
    shapes: bool,
) -> Result<Vec<u8>, Vec<Note>> {
    let robot = maps::read_robot(robot).value?;
    let source = Source::new(request, &robot)?;
    let map = FrequencyMap::new(&robot, maps::Method::Linear);
    let map = if intervals { map.with_intervals() } else { map };
    let map = if shapes { map.with_shapes() } else { map };
    let head = Head::of(&map);
    let writer = report::map::MapWriter::new(report::map::MapFormat::Json, &head, false);
    let unwritten = |error: io::Error| vec![Note::usage(error.to_string())];
    let mut bytes = writer.start(source.count().unwrap_or(0)).map_err(unwritten)?;
    let mut skip = writer.separator();
    let mut take = |blocks: &[&[u8]]| {
        for block in blocks {
            let skipped = skip.min(block.len());
            skip -= skipped;
            bytes.extend_from_slice(&block[skipped..]);
        }
        Ok(())
    };
    let render = |block: &maps::Block, out: &mut Vec<u8>| writer.block(block, out);
    let target = maps::Target::Bytes { render: &render, take: &mut take };
    maps::run(source, &map, target, &silent).map_err(|error| match error {
        MapError::Input(notes) => notes,
        MapError::Output(error) => unwritten(error),
    })?;
    bytes.extend_from_slice(writer.end());
    Ok(bytes)
}

/// Runs the command with these arguments; its exit code.
#[pyfunction]
pub(crate) fn run(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| detune::cli::run_with(arguments))
}

fn unknown(name: &str, given: &str, expected: &str) -> PyErr {
    PyValueError::new_err(format!("{name} is '{given}', must be one of {expected}"))
}
