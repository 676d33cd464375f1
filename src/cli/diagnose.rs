//! `detune diagnose`: what a model gets wrong, and why.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use super::output::{Sink, keep_apart};
use super::{Failure, Outcome};
use crate::diagnosis::{Diagnosis, Settings, Verdict, diagnose};
use crate::identify::ModeTable;
use crate::input::{
    Calibrated, DescribedRobot, FittedCorrection, Reading, corrected_robot, read_described_robot,
    read_measured,
};
use crate::notes::{Code, Note, Place};
use crate::report;

/// Steps of the progress bar.
const STEPS: u64 = 100;

/// Tell what the model gets wrong, why, how sure that is, and what to measure next.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    detune diagnose robots/two-link robots/two-link/measured.csv\n  \
    detune diagnose robot.yaml measured.csv --write calibrated.yaml\n  \
    detune diagnose robot.yaml measured.csv --format html --output diagnosis.html\n\n\
    The verdict never changes the exit code: 0 unless a file is wrong or holds too little data (2).")]
pub(super) struct DiagnoseArgs {
    /// A robot.yaml, or the folder that holds one.
    robot: PathBuf,
    /// Table of measured modes, one row a pose.
    #[arg(value_name = "MEASURED.csv")]
    measured: PathBuf,
    /// What to write.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Write to this file, whole or not at all, instead of standard output (`-`).
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write the robot's file with the findings as corrections, and the calibration.
    #[arg(long, value_name = "ROBOT2.yaml")]
    write: Option<PathBuf>,
    /// Of the folds and resamples: the same seed gives the same bytes, on the same kind of machine.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For people.
    Text,
    /// For programs; `detune schema diagnosis` describes it.
    Json,
    /// A page with plots.
    Html,
}

/// A model that is off by more says nothing about which speeds are safe, % of the frequency.
const WORTHLESS_PERCENT: f64 = 25.0;

/// No instrument does better: what a calibration claims at the least, % of the frequency.
const FINEST_PERCENT: f64 = 0.03;

/// Diagnoses, writes the result, then the robot's file.
pub(super) fn run(args: &DiagnoseArgs, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let sink = Sink::open(args.output.as_deref())?;
    let robot_sink = args.write.as_deref().map(|path| Sink::open(Some(path))).transpose()?;
    keep_apart(&[
        ("--output", Some(&sink), args.output.as_deref()),
        ("--write", robot_sink.as_ref(), args.write.as_deref()),
    ])?;
    let robot_file = super::robot_file(&args.robot);
    let mut reading = Reading::default();
    let read = read(&robot_file, &args.measured, &mut reading);
    for sink in std::iter::once(&sink).chain(&robot_sink) {
        sink.refuse_inputs(&reading.files)?;
    }
    reading.warnings.iter().for_each(|notice| warn(&notice.to_string()));
    let (loaded, table) = read?;
    let DescribedRobot { robot, description } = &loaded;
    let bar = progress();
    let diagnosed = diagnose(description, &table, Settings { seed: args.seed }, &|share| {
        bar.set_position((share * STEPS as f64) as u64);
    });
    bar.finish_and_clear();
    let diagnosis = diagnosed.map_err(|fault| {
        vec![Note::error(Code::Value, Place::file(&args.measured), fault.to_string())]
    })?;
    if let Some(hint) = unit_hint(&diagnosis) {
        warn(&format!("{}: {hint}", args.measured.display()));
    }
    let internal = |error: &dyn std::fmt::Display| Failure::Internal(error.to_string());
    let text = match args.format {
        Format::Text => {
            report::diagnosis::text::diagnosis(&diagnosis, robot.name(), &args.measured)
        }
        Format::Json => {
            report::diagnosis::json::diagnosis(&diagnosis).map_err(|error| internal(&error))?
        }
        Format::Html => {
            report::diagnosis::html::diagnosis(&diagnosis, robot.name(), &args.measured)
        }
    };
    let edited = match &args.write {
        Some(path) => Some(edited(&robot_file, path, &loaded, &diagnosis)?),
        None => None,
    };
    sink.write(&text, out)?;
    if let (Some(sink), Some(edited), Some(path)) = (robot_sink, edited, &args.write) {
        let left = diagnosis.extended.heldout_rms_percent;
        if left > WORTHLESS_PERCENT {
            let what = format!(
                "the model is still off by {left:.0} % at poses left out: with that calibration check can tell nothing"
            );
            warn(&format!("{}: {what}", path.display()));
        }
        if diagnosis.verdict == Verdict::Unexplained {
            let what = "nothing explains the error, so the file has no new correction, only the calibration";
            warn(&format!("{}: {what}", path.display()));
        }
        sink.write(&edited, out)?;
    }
    Ok(Outcome::Pass)
}

/// A remark on standard error; if that is closed, there is nobody to tell.
fn warn(what: &str) {
    let _ = writeln!(io::stderr().lock(), "warning: {what}");
}

/// Frequencies that are all off by the factor between two units.
fn unit_hint(diagnosis: &Diagnosis) -> Option<String> {
    /// A model is seldom this near by chance, and all modes at once.
    const NEAR: f64 = 0.15;
    let mut ratios: Vec<f64> = diagnosis
        .residuals
        .iter()
        .filter_map(|row| Some(row.measured_hz / row.before_hz?))
        .collect();
    ratios.sort_by(f64::total_cmp);
    let at = |share: f64| ratios.get((share * ratios.len() as f64) as usize).copied();
    let (low, middle, high) = (at(0.1)?, at(0.5)?, at(0.9)?);
    let units = [(std::f64::consts::TAU, "rad/s"), (60.0, "1/min")];
    units.into_iter().find(|(factor, _)| {
        [low, middle, high].iter().all(|ratio| (ratio / factor - 1.0).abs() < NEAR)
    }).map(|(factor, unit)| {
        format!(
            "the frequencies are about {factor:.2} times the model's: are they in {unit}? Columns f1_hz and so on are in Hz"
        )
    })
}

/// The robot and the table of modes.
fn read(
    robot_file: &Path,
    measured: &Path,
    reading: &mut Reading,
) -> Result<(DescribedRobot, ModeTable), Vec<Note>> {
    let described = read_described_robot(robot_file, reading)?;
    let table = read_measured(measured, &described.robot, reading)?;
    Ok((described, table))
}

/// The robot's file with what was found.
fn edited(
    robot_file: &Path,
    output: &Path,
    robot: &DescribedRobot,
    diagnosis: &Diagnosis,
) -> Result<String, Vec<Note>> {
    let old = robot
        .description
        .corrections
        .iter()
        .map(|correction| FittedCorrection { correction: correction.clone(), ci95: Vec::new() });
    let new = diagnosis.corrections.iter().map(|correction| FittedCorrection {
        correction: correction.clone(),
        ci95: diagnosis
            .findings
            .iter()
            .filter(|finding| finding.cause == correction.cause && finding.at == correction.at)
            .flat_map(|finding| finding.parameters.iter().map(|p| (p.name.clone(), p.ci95)))
            .collect(),
    });
    let calibration = Calibrated {
        poses: diagnosis.poses,
        heldout_rms_percent: diagnosis.extended.heldout_rms_percent.max(FINEST_PERCENT),
        date: today(),
    };
    let corrections: Vec<FittedCorrection> = old.chain(new).collect();
    corrected_robot(robot_file, output, &corrections, &calibration)
}

/// The day in UTC, as YYYY-MM-DD (Howard Hinnant, "chrono-compatible low-level date algorithms").
fn today() -> String {
    const SECONDS_PER_DAY: u64 = 86_400;
    let since = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (year, month, day) = civil(since / SECONDS_PER_DAY);
    format!("{year:04}-{month:02}-{day:02}")
}

/// Year, month and day of a number of days since 1970-01-01.
fn civil(days: u64) -> (u64, u64, u64) {
    let shifted = days + 719_468;
    let era = shifted / 146_097;
    let of_era = shifted % 146_097;
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    (year_of_era + era * 400 + u64::from(month <= 2), month, day)
}

/// Shown on standard error while that is a terminal, and nowhere else.
fn progress() -> ProgressBar {
    let bar = ProgressBar::new(STEPS);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent} % diagnosed, {elapsed}") {
        bar.set_style(style);
    }
    bar
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_counted_as_the_calendar_does() {
        assert_eq!(civil(0), (1970, 1, 1));
        assert_eq!(civil(11_016), (2000, 2, 29));
        assert_eq!(civil(20_778), (2026, 11, 21));
    }
}
