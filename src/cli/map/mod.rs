//! `detune map`: natural frequencies over poses.

mod args;
mod progress;

use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

use self::args::{Format, MethodName};
pub(super) use self::args::{MapArgs, StatisticName, grid_range, named_value, statistics};
use self::progress::bar;
use super::output::Sink;
use super::{Failure, Outcome, Warnings, of_option};
use crate::notes::Note;
use crate::progress::Done;
use crate::report::map::{
    MapFormat, MapWriter, map_drawing, map_html, reduced_csv, reduced_drawing, reduced_html,
    reduced_json, sketch_json,
};
use crate::study::Read;
use crate::study::arm::arm_at_poses;
use crate::study::map::{
    self as study, Block, FrequencyMap, Head, MapError, Method, Part, Reduction, Robot, Sampling,
    Source, Started, Summary, Target,
};
use crate::study::report::Meshes;

impl From<MapError> for Failure {
    fn from(error: MapError) -> Self {
        match error {
            MapError::Input(notes) => Self::from(notes),
            MapError::Output(error) => Self::from(error),
        }
    }
}

/// Writes the map of `args` to `out` or to its file.
pub(super) fn run(
    args: &MapArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let method = check_options(args)?;
    let sink = Sink::open(args.output.as_deref())?;
    let Read { value: robot, warnings, mut files } =
        study::read_robot(&super::robot_file(&args.robot));
    shown.show(&warnings);
    let robot = robot?;
    // Standard input may be a file, too.
    files.extend(args.poses.iter().map(|poses| match poses {
        dash if dash == Path::new("-") => PathBuf::from("/dev/stdin"),
        file => file.clone(),
    }));
    sink.refuse_inputs(&files)?;
    let source = source(args, &robot)?;
    let map = FrequencyMap::new(&robot, method);
    let map = if args.intervals { map.with_intervals() } else { map };
    let map = if args.shapes { map.with_shapes() } else { map };
    let colour = sink.shows_colour();
    sink.stream(out, |out| {
        let summary = if args.format == Format::Sketch {
            write_sketch(args, &map, source, out, shown)?
        } else if !args.reduce.is_empty() {
            write_statistics((args, colour), &map, source, out, shown)?
        } else {
            match args.series.then_some(MapFormat::Series).or_else(|| args.format.of_rows()) {
                Some(format) => write_rows(format, &map, source, out, shown)?,
                None => write_drawing((args.format, colour), (&robot, &map), source, out, shown)?,
            }
        };
        out.flush()?;
        let warnings = summary.warnings(&robot).into_iter().map(with_option);
        shown.show(&warnings.collect::<Vec<_>>());
        Ok(())
    })?;
    Ok(Outcome::Pass)
}

/// The method, or the options that do not go together and those that would have no effect.
fn check_options(args: &MapArgs) -> Result<Method, Vec<Note>> {
    let mut errors = Vec::new();
    let mut method = Method::Linear;
    if args.method == MethodName::Nonlinear {
        let sampling = match (args.sample_rate_hz, args.duration_s) {
            (Some(sample_rate_hz), Some(duration_s)) => {
                Sampling::Fixed { sample_rate_hz, duration_s }
            }
            _ => Sampling::Automatic,
        };
        match study::nonlinear(args.amplitude_deg, sampling) {
            Ok(nonlinear) => method = nonlinear,
            Err(error) => errors.push(of_option(error)),
        }
    } else {
        let only_nonlinear = [
            ("--amplitude-deg", args.amplitude_deg),
            ("--sample-rate-hz", args.sample_rate_hz),
            ("--duration-s", args.duration_s),
        ];
        for (name, _) in only_nonlinear.iter().filter(|(_, value)| value.is_some()) {
            errors.push(Note::usage(format!("{name} has no effect without --method nonlinear")));
        }
    }
    if args.part.is_some() && args.format != Format::Sketch {
        errors.push(Note::usage("--part: has no effect without --format sketch"));
    }
    let conflict = match (args.method, args.format, args.reduce.is_empty()) {
        (MethodName::Nonlinear, Format::Sketch, _) => {
            Some("--format sketch: takes linear maps only; leave out --method nonlinear")
        }
        (MethodName::Nonlinear, _, false) => {
            Some("--reduce: takes linear maps only; leave out --method nonlinear")
        }
        (MethodName::Nonlinear, Format::Npy | Format::Arrow, true) => Some(
            "--format npy and arrow: hold the frequencies of linear maps only; use csv, or leave \
             out --method nonlinear",
        ),
        (MethodName::Linear, Format::Npy | Format::Arrow, false) => Some(
            "--format npy and arrow: cannot hold the statistics of --reduce; use csv, json, svg or \
             html",
        ),
        (MethodName::Linear, Format::Arrow, true) if !cfg!(feature = "arrow") => Some(
            "--format arrow: this detune was built without Apache Arrow; build it with the feature \
             arrow, or use csv or npy",
        ),
        _ => None,
    };
    errors.extend(conflict.map(Note::usage));
    if args.series && (args.method == MethodName::Linear || args.format != Format::Csv) {
        let what = "--series: takes --method nonlinear and csv only";
        errors.push(Note::usage(what));
    }
    let is_full = args.method == MethodName::Linear && args.reduce.is_empty();
    let shows = |drawn: bool| {
        is_full && (drawn || matches!(args.format, Format::Csv | Format::Json | Format::Html))
    };
    if args.intervals && !shows(args.format == Format::Svg) {
        let what = "--intervals: takes linear maps as csv, json, svg or html only";
        errors.push(Note::usage(what));
    }
    if args.shapes && !shows(false) {
        let what = "--shapes: takes linear maps as csv, json or html only";
        errors.push(Note::usage(what));
    }
    if errors.is_empty() { Ok(method) } else { Err(errors) }
}

fn source(args: &MapArgs, robot: &Robot) -> Result<Source, Vec<Note>> {
    if let Some(path) = &args.poses {
        return if path == Path::new("-") {
            Source::from_reader(Box::new(io::stdin().lock()), path, robot)
        } else {
            Source::open(path, robot)
        };
    }
    let request = args.request().map_err(|error| vec![error])?;
    Source::new(&request, robot)
        .map_err(|errors| errors.into_iter().map(|error| of_source(error, args)).collect())
}

/// An error of a request, at the option that asked for it.
fn of_source(mut error: Note, args: &MapArgs) -> Note {
    match error.place.key {
        "grid" if args.joint.is_some() => error.place.key = "joint",
        "random" => error.what.push_str(" (--at NAME=MM)"),
        _ => {}
    }
    of_option(error)
}

/// A warning about the map, with the option by which to change what it is about.
fn with_option(mut warning: Note) -> Note {
    match std::mem::take(&mut warning.place.key) {
        "" => {}
        key => warning.what.push_str(&format!(" (--{key})")),
    }
    warning
}

/// Sends all poses to `target`, and shows how many.
fn pass(
    map: &FrequencyMap,
    source: Source,
    target: Target,
    bar: &ProgressBar,
) -> Result<Summary, MapError> {
    let passed = study::run(source, map, target, &|done| {
        if let Done::More(poses) = done {
            bar.inc(poses as u64);
        }
    });
    bar.finish_and_clear();
    passed
}

/// Writes every pose, however many there are.
fn write_rows(
    format: MapFormat,
    map: &FrequencyMap,
    source: Source,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Summary, Failure> {
    let head = Head::of(map);
    let writer = MapWriter::new(format, &head, map.method() != Method::Linear);
    match source.count() {
        None if format == MapFormat::Npy => {
            // The header of an array states the number of rows; a CSV table does not.
            let mut held = tempfile::tempfile()?;
            let summary = write_blocks(&writer, map, source, &mut held, shown)?;
            held.rewind()?;
            out.write_all(&writer.start(summary.poses)?)?;
            io::copy(&mut held, out)?;
            Ok(summary)
        }
        count => {
            out.write_all(&writer.start(count.unwrap_or(0))?)?;
            let summary = write_blocks(&writer, map, source, out, shown)?;
            out.write_all(writer.end())?;
            Ok(summary)
        }
    }
}

fn write_blocks(
    writer: &MapWriter,
    map: &FrequencyMap,
    source: Source,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Summary, MapError> {
    let bar = shown.bar(bar(source.count()));
    let mut skip = writer.separator();
    let mut take = |blocks: &[&[u8]]| {
        // Both may stand on one terminal.
        bar.suspend(|| {
            for bytes in blocks {
                let skipped = skip.min(bytes.len());
                skip -= skipped;
                out.write_all(&bytes[skipped..])?;
            }
            out.flush()
        })
    };
    let render = |block: &Block, bytes: &mut Vec<u8>| writer.block(block, bytes);
    pass(map, source, Target::Bytes { render: &render, take: &mut take }, &bar)
}

fn write_drawing(
    (format, colour): (Format, bool),
    (robot, map): (&Robot, &FrequencyMap),
    source: Source,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Summary, Failure> {
    let (swept, bar) = (source.swept(), shown.bar(bar(source.count())));
    let mut block = Block::default();
    let target = Target::Kept { block: &mut block, max_poses: 100_000 };
    let summary = pass(map, source, target, &bar)?;
    let head = Head::of(map);
    let drawing = || map_drawing(&head, &block, swept);
    let text = match format {
        Format::Html => {
            let moving = arm_at_poses(robot, &block, &Meshes::default())
                .map_err(|fault| vec![Note::usage(fault.to_string())])?;
            map_html(&head, &block, swept, &moving)
                .map_err(|error| Failure::Internal(error.to_string()))?
        }
        Format::Plot => drawing().characters(colour),
        _ => drawing().svg(),
    };
    out.write_all(text.as_bytes())?;
    Ok(summary)
}

/// Writes the statistics of a linear map.
fn write_statistics(
    (args, colour): (&MapArgs, bool),
    map: &FrequencyMap,
    source: Source,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Summary, Failure> {
    let (head, bar) = (Head::of(map), shown.bar(bar(source.count())));
    let mut reduction = Reduction::new(map.joints(), map.modes());
    let summary = pass(map, source, Target::Statistics(&mut reduction), &bar)?;
    let Some(reduced) = reduction.finish() else {
        return Err(
            vec![Note::usage("--reduce: the table holds no poses, must hold one or more")].into()
        );
    };
    let statistics = args.statistics();
    let text = match args.format {
        Format::Csv | Format::Npy | Format::Arrow | Format::Sketch => {
            reduced_csv(&head, &reduced, &statistics)
        }
        Format::Json => reduced_json(&head, &reduced, &statistics)
            .map_err(|error| Failure::Internal(error.to_string()))?,
        Format::Svg => reduced_drawing(&head, &reduced).svg(),
        Format::Plot => reduced_drawing(&head, &reduced).characters(colour),
        Format::Html => {
            reduced_html(&head, &reduced).map_err(|error| Failure::Internal(error.to_string()))?
        }
    };
    out.write_all(text.as_bytes())?;
    Ok(summary)
}

/// Writes the statistics of a part of a linear map, or of all of it, so that they can be put
/// together with those of other parts.
fn write_sketch(
    args: &MapArgs,
    map: &FrequencyMap,
    source: Source,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Summary, Failure> {
    let part = args.part.unwrap_or(Part::WHOLE);
    let started = Started::new(map, source, part, &args.statistics());
    let (source, mut sketch) = started.map_err(|error| vec![of_option(error)])?.parts();
    let bar = shown.bar(bar(source.count()));
    let summary = pass(map, source, Target::Statistics(sketch.reduction()), &bar)?;
    let text = sketch_json(&sketch.finished(map, &summary));
    let text = text.map_err(|error| Failure::Internal(error.to_string()))?;
    out.write_all(text.as_bytes())?;
    Ok(summary)
}
