//! `detune map`: natural frequencies over poses.

mod args;
mod progress;
mod remarks;
mod source;
mod stream;

use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

pub(super) use self::args::MapArgs;
use self::args::{Format, MethodName};
use self::progress::progress;
use self::remarks::Remarks;
use self::source::{RowByRow, Source, usage};
use self::stream::{Aim, Passed, Render};
use super::output::Sink;
use super::{Failure, Outcome};
use crate::free_vibration::{Sampling, Settings};
use crate::input::{Reading, read_robot};
use crate::map::{Block, Head, LinearMap, Method, Reduction, rows_with_progress};
use crate::model::Robot;
use crate::notes::Note;
#[cfg(feature = "arrow")]
use crate::report::map::{map_arrow_block, map_arrow_end, map_arrow_schema, map_arrow_start};
use crate::report::map::{
    map_csv_block, map_csv_header, map_csv_rows, map_json_block, map_json_end, map_json_parting,
    map_json_rows, map_json_start, map_npy_block, map_npy_header, map_svg, reduced_csv,
    reduced_json, reduced_svg,
};
use crate::units::rad_from_deg;

/// Poses of a picture that are solved at once: enough for all processors, little enough to forget.
const LINEAR_CHUNK: usize = 16_384;

/// The same for nonlinear maps, whose rows take long and hold spectra.
const NONLINEAR_CHUNK: usize = 64;

/// Springs that turn further than this are none, degrees.
const LARGEST_DEG: f64 = 90.0;

/// Most poses in a picture.
const MOST_DRAWN: usize = 100_000;

/// Writes the map of `args` to `out` or to its file.
pub(super) fn run(args: &MapArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    unless_at_odds(args)?;
    let sink = Sink::open(args.output.as_deref())?;
    let mut reading = Reading::default();
    let robot = read_robot(&super::robot_file(&args.robot), &mut reading)?;
    // Standard input may be a file, too.
    reading.files.extend(args.poses.iter().map(|poses| match poses {
        dash if dash == Path::new("-") => PathBuf::from("/dev/stdin"),
        file => file.clone(),
    }));
    sink.spare(&reading.files)?;
    let mut notices: Vec<String> = reading.warnings.iter().map(Note::to_string).collect();
    let method = method(args);
    sink.stream(out, |out| {
        if !args.reduce.is_empty() {
            write_reduced(args, &robot, out, &mut notices)
        } else if args.method == MethodName::Linear && args.format != Format::Svg {
            write_linear(args, &robot, out, &mut notices)
        } else {
            write_map(args, &robot, &method, out, &mut notices)
        }
    })?;
    let mut stderr = io::stderr().lock();
    for notice in notices {
        // If standard error is closed, there is nobody to tell.
        let _ = writeln!(stderr, "warning: {notice}");
    }
    Ok(Outcome::Pass)
}

fn method(args: &MapArgs) -> Method {
    match args.method {
        MethodName::Linear => Method::Linear,
        MethodName::Nonlinear => Method::Nonlinear(Settings {
            amplitude_rad: args
                .amplitude_deg
                .map_or(Settings::default().amplitude_rad, rad_from_deg),
            sampling: match (args.sample_rate_hz, args.duration_s) {
                (Some(sample_rate_hz), Some(duration_s)) => {
                    Sampling::Fixed { sample_rate_hz, duration_s }
                }
                (Some(_), None) | (None, Some(_)) | (None, None) => Sampling::Automatic,
            },
            ..Settings::default()
        }),
    }
}

/// Options that do not go together, and options that would be passed over in silence.
fn unless_at_odds(args: &MapArgs) -> Result<(), Vec<Note>> {
    let only_nonlinear = [
        ("--amplitude-deg", args.amplitude_deg),
        ("--sample-rate-hz", args.sample_rate_hz),
        ("--duration-s", args.duration_s),
    ];
    let mut faults = Vec::new();
    for (name, value) in only_nonlinear {
        if args.method == MethodName::Linear && value.is_some() {
            faults.push(usage(format!("{name} is of no effect here; it needs --method nonlinear")));
        }
    }
    if let Some(amplitude) = args.amplitude_deg.filter(|x| !(*x > 0.0 && *x <= LARGEST_DEG)) {
        let what =
            format!("--amplitude-deg is {amplitude}, must be above 0 and at most {LARGEST_DEG}");
        faults.push(usage(what));
    }
    let at_odds = match (args.method, args.format, args.reduce.is_empty()) {
        (MethodName::Nonlinear, _, false) => {
            Some("--reduce: gathers linear maps only; leave out --method nonlinear")
        }
        (MethodName::Nonlinear, Format::Npy | Format::Arrow, true) => Some(
            "--format npy and arrow: hold the frequencies of linear maps only; use csv, or leave out \
             --method nonlinear",
        ),
        (MethodName::Linear, Format::Npy | Format::Arrow, false) => Some(
            "--format npy and arrow: cannot hold the figures of --reduce; use csv, json or svg",
        ),
        (MethodName::Linear, Format::Arrow, true) if !cfg!(feature = "arrow") => Some(
            "--format arrow: this detune was built without Apache Arrow; build it with --features \
             arrow, or use csv or npy",
        ),
        _ => None,
    };
    faults.extend(at_odds.map(|what| usage(what.to_owned())));
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Writes every pose of a linear map, however many there are.
fn write_linear(
    args: &MapArgs,
    robot: &Robot,
    out: &mut dyn Write,
    notices: &mut Vec<String>,
) -> Result<(), Failure> {
    let source = Source::new(args, robot)?;
    let (head, map) = (Head::of(robot), LinearMap::new(robot));
    let csv = |block: &Block, text: &mut Vec<u8>| {
        map_csv_block(block, text);
        Ok(())
    };
    let json = |block: &Block, text: &mut Vec<u8>| {
        map_json_block(block, text).map_err(|error| error.to_string())
    };
    let npy = |block: &Block, text: &mut Vec<u8>| {
        map_npy_block(block, text);
        Ok(())
    };
    #[cfg(feature = "arrow")]
    let schema = map_arrow_schema(&head);
    #[cfg(feature = "arrow")]
    let arrow = |block: &Block, text: &mut Vec<u8>| {
        map_arrow_block(&schema, block, text).map_err(|error| error.to_string())
    };
    let (start, render, skip): (Vec<u8>, Render, usize) = match args.format {
        Format::Json => {
            let start = map_json_start(&head, false);
            let start = start.map_err(|error| Failure::Internal(error.to_string()))?;
            // Every row begins with what parts it from the row before.
            (start.into_bytes(), &json, map_json_parting().len())
        }
        Format::Npy => match source.count() {
            Some(count) => (map_npy_header(count, map.modes()), &npy, 0),
            None => {
                let passed = write_npy_by_way_of_a_file(source, &map, &npy, out)?;
                Remarks::from(passed).tell(robot, notices);
                return Ok(());
            }
        },
        #[cfg(feature = "arrow")]
        Format::Arrow => {
            let start = map_arrow_start(&schema);
            (start.map_err(|error| Failure::Internal(error.to_string()))?, &arrow, 0)
        }
        _ => (map_csv_header(&head, false).into_bytes(), &csv, 0),
    };
    out.write_all(&start)?;
    let passed = stream::run(source, &map, Aim::Write { render, skip, out })?;
    if args.format == Format::Json {
        out.write_all(map_json_end().as_bytes())?;
    }
    #[cfg(feature = "arrow")]
    if args.format == Format::Arrow {
        out.write_all(map_arrow_end())?;
    }
    out.flush()?;
    Remarks::from(passed).tell(robot, notices);
    Ok(())
}

/// The header of an array says how many rows there are; a CSV table does not.
fn write_npy_by_way_of_a_file(
    source: Source,
    map: &LinearMap,
    render: Render,
    out: &mut dyn Write,
) -> Result<Passed, Failure> {
    let mut held = tempfile::tempfile()?;
    let passed = stream::run(source, map, Aim::Write { render, skip: 0, out: &mut held })?;
    held.rewind()?;
    out.write_all(&map_npy_header(passed.poses, map.modes()))?;
    io::copy(&mut held, out)?;
    out.flush()?;
    Ok(passed)
}

/// Writes the figures of a linear map.
fn write_reduced(
    args: &MapArgs,
    robot: &Robot,
    out: &mut dyn Write,
    notices: &mut Vec<String>,
) -> Result<(), Failure> {
    let source = Source::new(args, robot)?;
    let (head, map) = (Head::of(robot), LinearMap::new(robot));
    let mut reduction = Reduction::new(map.joints(), map.modes());
    let passed = stream::run(source, &map, Aim::Reduce(&mut reduction))?;
    let Some(reduced) = reduction.finish() else {
        return Err(vec![usage("--reduce: there are no poses, must be one or more".into())].into());
    };
    let statistics = args.statistics();
    let text = match args.format {
        Format::Csv | Format::Npy | Format::Arrow => reduced_csv(&head, &reduced, &statistics),
        Format::Json => reduced_json(&head, &reduced, &statistics)
            .map_err(|error| Failure::Internal(error.to_string()))?,
        Format::Svg => reduced_svg(&head, &reduced),
    };
    out.write_all(text.as_bytes())?;
    out.flush()?;
    Remarks::from(passed).tell(robot, notices);
    Ok(())
}

fn write_map(
    args: &MapArgs,
    robot: &Robot,
    method: &Method,
    out: &mut dyn Write,
    notices: &mut Vec<String>,
) -> Result<(), Failure> {
    let mut source = RowByRow::new(Source::new(args, robot)?, robot);
    let is_nonlinear = args.method == MethodName::Nonlinear;
    let chunk = if is_nonlinear { NONLINEAR_CHUNK } else { LINEAR_CHUNK };
    let head = Head::of(robot);
    let internal = |error: serde_json::Error| Failure::Internal(error.to_string());
    let mut remarks = Remarks::default();
    let progress = progress(source.count());
    let more = |poses: usize| progress.inc(poses as u64);
    let mut drawn = Vec::new();
    let mut text = match args.format {
        Format::Csv => map_csv_header(&head, is_nonlinear),
        Format::Json => map_json_start(&head, is_nonlinear).map_err(internal)?,
        Format::Svg | Format::Npy | Format::Arrow => String::new(),
    };
    loop {
        let (poses, places) = source.next(chunk)?;
        if poses.is_empty() {
            break;
        }
        let found = rows_with_progress(robot, &poses, method, &more)
            .map_err(|bad| vec![source.fault(places[bad.index], &bad.fault.to_string())])?;
        match args.format {
            Format::Csv => map_csv_rows(&found, &mut text),
            Format::Json => {
                map_json_rows(&found, remarks.poses == 0, &mut text).map_err(internal)?;
            }
            Format::Svg | Format::Npy | Format::Arrow => {}
        }
        remarks.note(robot, &found);
        if args.format == Format::Svg {
            drawn.extend(found);
            if drawn.len() > MOST_DRAWN {
                return Err(vec![usage(format!(
                    "--format svg: more than {MOST_DRAWN} poses, too many to draw; use csv, or \
                     --reduce"
                ))]
                .into());
            }
        }
        // Both may stand on one terminal.
        progress.suspend(|| out.write_all(text.as_bytes()).and_then(|()| out.flush()))?;
        text.clear();
    }
    progress.finish_and_clear();
    match args.format {
        Format::Csv | Format::Npy | Format::Arrow => {}
        Format::Json => text.push_str(map_json_end()),
        Format::Svg => text = map_svg(&head, &drawn, source.swept()),
    }
    out.write_all(text.as_bytes())?;
    out.flush()?;
    remarks.tell(robot, notices);
    Ok(())
}
