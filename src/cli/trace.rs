//! `detune trace`: a video of marks in, their displacements over time out.

use std::io::{self, Read as Source, Write};
use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::output::{Sink, keep_apart, write_all};
use super::{Failure, Outcome, Warnings};
use crate::progress::Done;
use crate::report::trace::{frames_csv, traces_csv, tracks_drawing};
use crate::study::Read;
use crate::study::trace::{open, read, trace};

const AFTER_HELP: &str = "\
Marks are boxes in the first frame, or round marks that are found; `detune schema marks` lists the \
keys of the file:
  frame_rate_hz: 240
  readout_ms: 16                    # rolling shutter; without it, shapes are wrong
  scale: {marks: [base, tip], distance_mm: 630}
  marks:
    - {name: base, box_px: [96, 604, 28, 28]}
    - {name: tip, box_px: [612, 240, 28, 28]}

Examples:
  detune trace frames/ --marks marks.yaml --output traces.csv
  detune trace clip.y4m --marks marks.yaml --picture tracks.svg --output traces.csv
  ffmpeg -i clip.mov -fps_mode passthrough -pix_fmt gray -f yuv4mpegpipe - | \\
    detune trace - --marks marks.yaml --times times.csv --output traces.csv

Cells are blank where a mark is lost: a warning names the frames.";

/// Follow marks in a video: the displacements that `detune identify` reads.
#[derive(Debug, Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct TraceArgs {
    /// A folder of PNG or JPEG pictures, a file of YUV4MPEG (.y4m), or `-` for standard input.
    #[arg(value_name = "VIDEO")]
    video: PathBuf,
    /// The marks, the scale, and what is known of the camera.
    #[arg(long, value_name = "MARKS.yaml")]
    marks: PathBuf,
    /// Table of the times of frames, in a column `time_s`: for videos of uneven rate.
    #[arg(long, value_name = "TIMES.csv")]
    times: Option<PathBuf>,
    /// Write the table to this file instead of standard output (`-`); a run that fails leaves it
    /// unchanged.
    #[arg(long, value_name = "TRACES.csv")]
    output: Option<PathBuf>,
    /// Also draw the tracks into this file.
    #[arg(long, value_name = "TRACKS.svg")]
    picture: Option<PathBuf>,
    /// Also write to this file when and where marks were seen in each frame, in pixels with
    /// standard deviations.
    #[arg(long, value_name = "FRAMES.csv")]
    frames: Option<PathBuf>,
}

/// Follows the marks; where a file is invalid, reports all errors and writes nothing.
pub(super) fn run(
    args: &TraceArgs,
    out: &mut dyn Write,
    shown: &Warnings,
) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let opened =
        |path: &Option<PathBuf>| path.as_deref().map(|path| Sink::open(Some(path))).transpose();
    let (picture, frames) = (opened(&args.picture)?, opened(&args.frames)?);
    keep_apart(&[
        ("--output", Some(&sink), args.output.as_deref()),
        ("--picture", picture.as_ref(), args.picture.as_deref()),
        ("--frames", frames.as_ref(), args.frames.as_deref()),
    ])?;
    let Read { value: setup, warnings, mut files } = read(&args.marks, args.times.as_deref());
    shown.show(&warnings);
    let (setup, times) = setup?;
    let standard = || -> Box<dyn Source + Send> { Box::new(io::stdin()) };
    let Read { value: video, warnings, files: of_video } = open(&args.video, standard);
    shown.show(&warnings);
    let mut video = video?;
    files.extend(of_video);
    for sink in [&sink].into_iter().chain(&picture).chain(&frames) {
        sink.refuse_inputs(&files)?;
    }
    let bar = shown.bar(ProgressBar::new_spinner());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {pos} frames, {elapsed}") {
        bar.set_style(style);
    }
    let traced = trace(&setup, times.as_deref(), &mut video, &|done| {
        if let Done::More(frames) = done {
            bar.inc(frames as u64);
        }
    });
    bar.finish_and_clear();
    let traced = traced?;
    shown.show(&traced.warnings);
    let table = traces_csv(&traced);
    let picture = picture.as_ref().map(|sink| (sink, tracks_drawing(&traced).svg()));
    let frames = frames.as_ref().map(|sink| (sink, frames_csv(&traced)));
    let mut outputs: Vec<(&Sink, &[u8])> = vec![(&sink, table.as_bytes())];
    let others = picture.iter().chain(&frames);
    outputs.extend(others.map(|(sink, text)| (*sink, text.as_bytes())));
    write_all(&outputs, out)?;
    Ok(Outcome::Pass)
}
