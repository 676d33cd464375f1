//! A video and its marks → displacements over time, as `identify` reads them.

use std::io::Read as Source;
use std::path::Path;

use super::Read;
use crate::input::{Between, Side, Wanted, open_video, read_marks, read_times};
pub use crate::input::{Pictures, TraceSetup};
use crate::notes::{Code, Note, Place};
use crate::progress::{Done, Progress};
use crate::statistics::median;
pub use crate::trace::Position;
use crate::trace::{Area, Band, Picture, Resampled, Sample, Track, Tracker, find_round, resample};
use crate::wording::counted;

/// Fewest frames.
const MIN_FRAMES: usize = 8;

/// Most places, frames times marks: hours of a few marks at hundreds a second.
const MAX_PLACES: usize = 10_000_000;

/// Rows of a table for each frame, where times have gaps.
const MAX_ROWS: f64 = 4.0;

/// Frames this even, in steps, are taken as they are.
const EVEN: f64 = 1e-3;

/// What is interpolated fills this band, and errors are told below, in cycles a frame.
const BAND: Band = Band { filled: 0.44, told: 0.36 };

/// A value that interpolation may miss by more than this share of the amplitude is left blank.
const MAX_ERROR: f64 = 0.02;

/// Rows at either end whose values have fewer samples on one side than on the other.
const END: usize = 12;

/// What came of a video.
#[derive(Debug, Clone, PartialEq)]
pub struct Traced {
    /// Columns and rows of a picture.
    pub size_px: [usize; 2],
    /// When frames begin, s.
    pub frame_times_s: Vec<f64>,
    /// Rows of the table a second.
    pub rate_hz: f64,
    /// The scale.
    pub m_per_px: f64,
    /// Time from the first to the last row of a frame, s.
    pub readout_s: f64,
    /// Times of the rows of the table, s.
    pub times_s: Vec<f64>,
    /// How values were brought to these times, if they are not those of the frames.
    pub interpolation: Option<Interpolation>,
    /// The marks in the order of the file, or from left to right.
    pub marks: Vec<TracedMark>,
    /// What should be known.
    pub warnings: Vec<Note>,
}

/// How far interpolated values hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interpolation {
    /// Below this frequency, Hz.
    pub below_hz: f64,
    /// Largest error of a sinusoid there, over its amplitude.
    pub error: f64,
}

/// A mark.
#[derive(Debug, Clone, PartialEq)]
pub struct TracedMark {
    /// Its name.
    pub name: String,
    /// Its middle in the first frame, from the lower left corner of the picture, m.
    pub at_m: [f64; 2],
    /// Where it was in each frame.
    pub positions: Vec<Option<Position>>,
    /// When its row was read, s.
    pub seen_s: Vec<Option<f64>>,
    /// Displacements from the first frame at the rows of the table, to the right and up, m.
    pub displacements_m: Vec<Option<[f64; 2]>>,
    /// Median of the standard deviations of a frame, m.
    pub deviation_m: Option<[f64; 2]>,
    /// First and last frame of each stretch in which it is lost, counted from 1.
    pub lost: Vec<[usize; 2]>,
    /// Share of its box that moves with it.
    pub moving: f64,
}

/// Reads marks.yaml and, where there is one, the table of the times of frames.
pub fn read(marks: &Path, times: Option<&Path>) -> Read<(TraceSetup, Option<Vec<f64>>)> {
    Read::of(|reading| {
        let setup = read_marks(marks, reading);
        let times = times.map(|times| read_times(times, reading)).transpose();
        match (setup, times) {
            (Ok(setup), Ok(times)) => Ok((setup, times)),
            (setup, times) => {
                let mut errors = setup.err().unwrap_or_default();
                errors.extend(times.err().unwrap_or_default());
                Err(errors)
            }
        }
    })
}

/// Opens a video; `standard` gives standard input, which is called `-`.
pub fn open(video: &Path, standard: impl FnOnce() -> Box<dyn Source + Send>) -> Read<Pictures> {
    Read::of(|reading| open_video(video, standard, reading))
}

/// Follows the marks through a video. Given times of frames replace the frame rate.
///
/// # Errors
/// Pictures that cannot be read, marks that are not there, times that do not fit.
pub fn trace(
    setup: &TraceSetup,
    times: Option<&[f64]>,
    pictures: &mut Pictures,
    progress: Progress,
) -> Result<Traced, Vec<Note>> {
    let about_marks =
        |code, line, what: String| vec![Note::error(code, Place::line(&setup.file, line), what)];
    let name = pictures.name().to_owned();
    let stated = pictures.frame_rate_hz();
    let mut warnings = Vec::new();
    let rate = match (setup.frame_rate_hz, stated) {
        (Some(rate), Some(stated)) if (rate / stated - 1.0).abs() > 1e-3 && times.is_none() => {
            let what = format!("states {stated} frames/s; {rate} of frame_rate_hz are used");
            warnings.push(Note::warning(Code::Remark, Place::file(&name), what));
            Some(rate)
        }
        (rate, stated) => rate.or(stated),
    };
    if rate.is_none() && times.is_none() {
        let what = "no 'frame_rate_hz': the pictures do not state when they were taken";
        return Err(about_marks(Code::MissingKey, None, what.to_owned()));
    }
    let too_short = |frames: usize| {
        let what = format!("has {frames} frames, must have at least {MIN_FRAMES}");
        vec![Note::error(Code::TooLittleData, Place::file(&name), what)]
    };
    let Some(first) = pictures.next_picture()? else { return Err(too_short(0)) };
    let size_px = [first.width, first.height];
    let (names, areas) = areas(setup, &first)?;
    let mut tracker = Tracker::new(&areas, &first).map_err(|faint| {
        let name = names.get(faint.index).map_or("", String::as_str);
        let line = line_of(setup, faint.index);
        let what = format!(
            "mark '{name}': its box holds no detail in both directions that a place could be told \
             from"
        );
        about_marks(Code::Value, Some(line), what)
    })?;
    tracker.take(&first);
    let mut frames = 1;
    while let Some(picture) = pictures.next_picture()? {
        tracker.take(&picture);
        frames += 1;
        progress(Done::More(1));
        if frames * areas.len() > MAX_PLACES {
            let what = format!("has more than {} frames", MAX_PLACES / areas.len());
            return Err(vec![Note::error(Code::TooLong, Place::file(&name), what)]);
        }
    }
    if frames < MIN_FRAMES {
        return Err(too_short(frames));
    }
    let frame_times_s: Vec<f64> = match (times, rate) {
        (Some(times), _) if times.len() != frames => {
            let what = format!(
                "{} has {frames} frames, and the table of times has {}; must be the same",
                name.display(),
                times.len()
            );
            return Err(vec![Note::error(Code::Conflict, Place::default(), what)]);
        }
        (Some(times), _) => times.to_vec(),
        (None, rate) => {
            let rate = rate.unwrap_or(1.0);
            (0..frames).map(|k| k as f64 / rate).collect()
        }
    };
    let m_per_px = scale(setup, &names, &areas).ok_or_else(|| {
        let what = "scale: the two marks lie on each other".to_owned();
        about_marks(Code::Value, Some(setup.scale.line), what)
    })?;
    let tracks = tracker.finish();
    let mut traced = Traced {
        size_px,
        rate_hz: step(&frame_times_s).recip(),
        frame_times_s,
        m_per_px,
        readout_s: setup.readout_s,
        times_s: Vec::new(),
        interpolation: None,
        marks: Vec::new(),
        warnings,
    };
    for ((name, area), track) in names.into_iter().zip(&areas).zip(tracks) {
        traced.marks.push(mark(name, *area, track, setup, &traced));
    }
    fill_table(&mut traced)
        .map_err(|what| vec![Note::error(Code::TooLittleData, Place::file(&name), what)])?;
    for mark in traced.marks.iter().filter(|mark| !mark.lost.is_empty()) {
        let what = format!(
            "mark '{}' is lost in {} of {frames} frames ({}); its cells are blank there",
            mark.name,
            mark.lost.iter().map(|[from, to]| to + 1 - from).sum::<usize>(),
            stretches(&mark.lost)
        );
        traced.warnings.push(Note::warning(Code::LostMark, Place::file(&name), what));
    }
    Ok(traced)
}

/// Frame numbers as people write them.
pub fn stretches(lost: &[[usize; 2]]) -> String {
    const SHOWN: usize = 12;
    let one = |&[from, to]: &[usize; 2]| match from == to {
        true => from.to_string(),
        false => format!("{from}-{to}"),
    };
    let mut text = lost.iter().take(SHOWN).map(one).collect::<Vec<_>>().join(", ");
    if lost.len() > SHOWN {
        text += ", …";
    }
    text
}

fn line_of(setup: &TraceSetup, index: usize) -> usize {
    match &setup.marks {
        Wanted::Boxes(marks) => marks.get(index).map_or(1, |mark| mark.line),
        Wanted::Round { line, .. } => *line,
    }
}

/// Names and boxes of the marks in the first picture.
fn areas(setup: &TraceSetup, first: &Picture<'_>) -> Result<(Vec<String>, Vec<Area>), Vec<Note>> {
    let error = |line: usize, code, what| Note::error(code, Place::line(&setup.file, line), what);
    match &setup.marks {
        Wanted::Boxes(marks) => {
            let outside = marks.iter().filter(|mark| {
                let Area { left, top, width, height } = mark.area;
                left + width > first.width || top + height > first.height
            });
            let errors: Vec<Note> = outside
                .map(|mark| {
                    let what = format!(
                        "mark '{}': box_px reaches out of the picture of {} × {} px",
                        mark.name, first.width, first.height
                    );
                    error(mark.line, Code::Value, what)
                })
                .collect();
            if !errors.is_empty() {
                return Err(errors);
            }
            Ok(marks.iter().map(|mark| (mark.name.clone(), mark.area)).unzip())
        }
        Wanted::Round { names, line } => {
            let found = find_round(first);
            if found.len() != names.len() {
                let places: Vec<String> = found
                    .iter()
                    .take(20)
                    .map(|mark| format!("[{:.0}, {:.0}]", mark.middle[0], mark.middle[1]))
                    .collect();
                let what = format!(
                    "round_marks asks for {}, but the first frame shows {}{}{}; give \
                     marks with box_px instead",
                    names.len(),
                    counted(found.len(), "round mark"),
                    if places.is_empty() { "" } else { ", at px " },
                    places.join(", ")
                );
                return Err(vec![error(*line, Code::Value, what)]);
            }
            Ok((names.clone(), found.iter().map(|mark| mark.area).collect()))
        }
    }
}

/// Metres a pixel; `None` where the two places are one.
fn scale(setup: &TraceSetup, names: &[String], areas: &[Area]) -> Option<f64> {
    let middle =
        |name: &String| Some(areas[names.iter().position(|other| other == name)?].middle());
    let [a, b] = match &setup.scale.between {
        Between::Points(points) => *points,
        Between::Marks([a, b]) => [middle(a)?, middle(b)?],
    };
    let distance_px = f64::hypot(a[0] - b[0], a[1] - b[1]);
    (distance_px >= 1.0).then(|| setup.scale.distance_m / distance_px)
}

/// The time between frames such that it fits all of them, those included that are missing.
fn step(times: &[f64]) -> f64 {
    let steps = || times.windows(2).map(|pair| pair[1] - pair[0]);
    let usual = median(steps().collect()).unwrap_or(1.0);
    let count: f64 = steps().map(|step| (step / usual).round().max(1.0)).sum();
    steps().sum::<f64>() / count
}

/// A mark without its column of the table.
fn mark(name: String, area: Area, track: Track, setup: &TraceSetup, traced: &Traced) -> TracedMark {
    let [width, height] = traced.size_px.map(|side| side as f64);
    let share = |at: [f64; 2]| match setup.readout_from {
        Side::Top => at[1] / height,
        Side::Bottom => 1.0 - at[1] / height,
        Side::Left => at[0] / width,
        Side::Right => 1.0 - at[0] / width,
    };
    let seen_s = track
        .positions
        .iter()
        .zip(&traced.frame_times_s)
        .map(|(at, time)| Some(time + share(at.as_ref()?.at) * setup.readout_s))
        .collect();
    let deviation = |axis: usize| {
        let all = track.positions.iter().flatten().map(|at| at.deviation[axis]).collect();
        median(all).map(|px| px * traced.m_per_px)
    };
    let mut lost: Vec<[usize; 2]> = Vec::new();
    for frame in
        track.positions.iter().enumerate().filter(|(_, at)| at.is_none()).map(|(k, _)| k + 1)
    {
        match lost.last_mut() {
            Some([_, to]) if *to + 1 == frame => *to = frame,
            _ => lost.push([frame, frame]),
        }
    }
    let [x, y] = area.middle();
    TracedMark {
        name,
        at_m: [x * traced.m_per_px, (height - y) * traced.m_per_px],
        seen_s,
        displacements_m: Vec::new(),
        deviation_m: deviation(0).zip(deviation(1)).map(|(x, y)| [x, y]),
        lost,
        moving: track.moving,
        positions: track.positions,
    }
}

/// The rows of the table: the frames as they are, or even times that all marks have samples about.
fn fill_table(traced: &mut Traced) -> Result<(), String> {
    let times = &traced.frame_times_s;
    let (start, step) = (times.first().copied().unwrap_or(0.0), traced.rate_hz.recip());
    let is_even = |(k, time): (usize, &f64)| ((time - start) / step - k as f64).abs() < EVEN;
    let metres = |px: [f64; 2]| [px[0] * traced.m_per_px, -px[1] * traced.m_per_px];
    let of_first = |mark: &TracedMark| mark.positions.iter().flatten().next().map(|at| at.at);
    if traced.readout_s == 0.0 && times.iter().enumerate().all(is_even) {
        let columns: Vec<Vec<_>> = traced
            .marks
            .iter()
            .map(|mark| {
                let first = of_first(mark).unwrap_or_default();
                let moved = |at: &Position| metres([at.at[0] - first[0], at.at[1] - first[1]]);
                mark.positions.iter().map(|at| at.as_ref().map(moved)).collect()
            })
            .collect();
        traced.times_s = times.clone();
        for (mark, column) in traced.marks.iter_mut().zip(columns) {
            mark.displacements_m = column;
        }
        return Ok(());
    }
    let last = times.last().map_or(0.0, |last| (last - start) / step).round();
    if last.is_nan() || last > MAX_ROWS * times.len() as f64 {
        let frames = times.len();
        return Err(format!(
            "{frames} frames lie in {last} usual steps of time: too many are lost"
        ));
    }
    let last = last as usize;
    let grid: Vec<f64> = (0..=last).map(|k| k as f64).collect();
    let columns: Vec<Vec<Option<Resampled>>> = traced
        .marks
        .iter()
        .map(|mark| {
            let first = of_first(mark).unwrap_or_default();
            let seen = mark.positions.iter().zip(&mark.seen_s).enumerate();
            let samples: Vec<Sample> = seen
                .filter_map(|(frame, (at, seen_s))| {
                    let at = at.as_ref()?.at;
                    let moved = [at[0] - first[0], at[1] - first[1]];
                    Some((frame, ((*seen_s)? - start) / step, moved))
                })
                .collect();
            resample(&samples, &grid, BAND)
        })
        .collect();
    // At either end, the rows in which all marks that are seen are well known.
    let is_lost = |mark: &TracedMark, row: usize| {
        let ends = [mark.positions.first(), mark.positions.last()];
        matches!(ends[usize::from(2 * row >= grid.len())], Some(None))
    };
    let is_known = |row: &usize| {
        columns.iter().zip(&traced.marks).all(|(column, mark)| match column[*row] {
            Some(value) => value.error <= MAX_ERROR || !value.is_between,
            None => is_lost(mark, *row),
        })
    };
    // Near an end single rows may be known between others that are not: at a frame, for one.
    let mut rows = 0..grid.len();
    let known = rows.clone().find(is_known).zip(rows.rfind(is_known)).map(|(from, to)| {
        let first = (from..=to).take(END).filter(|row| !is_known(row)).last();
        let last = (from..=to).rev().take(END).filter(|row| !is_known(row)).last();
        (first.map_or(from, |row| row + 1), last.map_or(to, |row| row.saturating_sub(1)))
    });
    let (from, to) = known.filter(|(from, to)| *to + 1 >= from + MIN_FRAMES).ok_or_else(|| {
        format!("the marks are not seen together in {MIN_FRAMES} frames that could be aligned")
    })?;
    let is_written = |value: &Resampled| value.is_between && value.error <= MAX_ERROR;
    let mut error: f64 = 0.0;
    for (mark, column) in traced.marks.iter_mut().zip(&columns) {
        let column = column[from..=to].iter().map(|value| value.filter(is_written));
        let m_per_px = traced.m_per_px;
        mark.displacements_m = column
            .map(|value| {
                let Resampled { values: [x, y], error: own, .. } = value?;
                error = error.max(own);
                Some([x * m_per_px, -y * m_per_px])
            })
            .collect();
    }
    traced.times_s = (from..=to).map(|k| start + k as f64 * step).collect();
    traced.interpolation = Some(Interpolation { below_hz: BAND.told * traced.rate_hz, error });
    let blank = |k: usize| traced.marks.iter().any(|mark| mark.displacements_m[k].is_none());
    let in_gap = |k: &usize| {
        let row = k + from;
        blank(*k)
            && columns.iter().any(|c| c[row].is_some_and(|v| v.is_between && v.error > MAX_ERROR))
    };
    let gaps = (0..traced.times_s.len()).filter(in_gap).count();
    if gaps > 0 {
        let what = format!(
            "{gaps} rows lie in gaps of the frame times that are too long to interpolate; their \
             cells are blank"
        );
        traced.warnings.push(Note::warning(Code::Dropout, Place::default(), what));
    }
    Ok(())
}
