//! The diagnosis as a whole: choose, question, say how sure, measure the gain, say what to do next.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::arm::Arm;
use super::candidate::Candidate;
use super::causes::candidates;
use super::choose::{Choice, SearchWidth, choose};
use super::data::{Data, MIN_POINTS, MIN_POSES};
use super::findings::{corrections, findings, next, ranking, widened};
use super::fit::Fit;
use super::gain::{HeldOut, gain_interval, held_out};
use super::outcome::{Diagnosis, Errors, Gain, ResidualRow, Verdict};
use super::posterior::{Calibrated, posterior};
use super::problem::{Evaluation, Problem};
use super::screen::Screen;
use super::statistics::{relative_error, rms};
use super::symmetry::symmetry;
use super::table::{check_rows, unit_hint, within_the_model};
use super::unstated::{Stated, stated};
use super::verdict::Judged;
use crate::identify::ModeTable;
use crate::model::{Description, Robot};
use crate::notes::{Code, Note, Place};
use crate::progress::{Done, Progress};
use crate::uncertainty;
use crate::units::percent_from_ratio;

/// How to diagnose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Of the folds and resamples.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { seed: 1 }
    }
}

/// Diagnoses a robot by a table of measured modes.
///
/// # Errors
/// Too little data, a row that this robot cannot have, or a model without modes at a pose of the
/// table.
pub fn diagnose(
    description: &Description,
    table: &ModeTable,
    settings: Settings,
    progress: Progress<'_>,
) -> Result<Diagnosis, Note> {
    let robot = Robot::new(description).map_err(|_| no_modes())?;
    check_rows(&robot, table)?;
    let (table, beyond) = within_the_model(table, robot.coordinates().len());
    let data = measured(&table, description)?;
    let arm = Arm::new(description, &robot, &data).ok_or_else(no_modes)?;
    let Stated { candidates, untested, note: assumed } =
        stated(description, &robot, &data, &table.unstated, candidates(&arm));
    let problem = Problem { description, data: &data };
    let screen = Screen::new(&problem, &candidates).ok_or_else(no_modes)?;
    progress(Done::Share(0.1));
    let choice = choose(&problem, &candidates, &screen, SearchWidth::FULL).ok_or_else(no_modes)?;
    progress(Done::Share(0.4));
    let judged = Judged::of(&problem, &choice);
    let verdict = judged.verdict;
    let chosen = match verdict {
        Verdict::Explained => widened(&problem, &candidates, &choice.best.fit),
        Verdict::Consistent | Verdict::Unexplained => choice.baseline.clone(),
    };
    let held_out = match verdict {
        Verdict::Explained => {
            let seed = settings.seed;
            cross_validated(&problem, &candidates, &screen, seed, progress)
        }
        // Nothing was fitted: every pose is held out.
        Verdict::Consistent | Verdict::Unexplained => {
            HeldOut::unchanged(&choice.baseline.evaluation)
        }
    };
    let (findings, (next_poses, next_tests)) = match verdict {
        Verdict::Explained => (
            findings(&problem, candidates.len(), &choice, &chosen),
            next(&problem, &robot, &choice),
        ),
        Verdict::Consistent | Verdict::Unexplained => Default::default(),
    };
    let calibrated = posterior(&problem, &chosen).ok_or_else(no_modes)?;
    let causes = chosen.hypothesis.inner().len();
    let alone = (causes > 0 && uncertainty::stated(&robot).is_some())
        .then(|| posterior(&problem, &choice.baseline))
        .flatten()
        .filter(|alone| {
            // What a parameter costs in BIC, and the choice of its cause.
            let cost = 0.5 * (data.points.len() as f64).ln() + (candidates.len() as f64).ln();
            alone.ln_evidence > calibrated.ln_evidence - cost * causes as f64
        });
    let is_alone = alone.is_some();
    let Calibrated { posterior, ln_hz, .. } = alone.unwrap_or(calibrated);
    progress(Done::Share(1.0));
    let [before, after] = [&held_out.before, &held_out.after].map(|errors| rms(errors.iter()));
    let residuals = residual_rows(&data, &choice, &chosen, &ln_hz);
    Ok(Diagnosis {
        verdict,
        poses: data.test_count(),
        gain: Gain {
            percent_points: percent_from_ratio(before - after),
            ci95: gain_interval(&data, &held_out, settings.seed).map(percent_from_ratio),
        },
        baseline: errors(&data, &choice.baseline.evaluation, before),
        extended: errors(&data, &chosen.evaluation, after),
        noise_floor_percent: percent_from_ratio(noise_floor(&data, &chosen)),
        posterior,
        structure_before: judged.before,
        structure_after: judged.after,
        symmetry: symmetry(&robot, &data, &residuals, &candidates),
        untested,
        next_poses,
        next_tests,
        ranking: ranking(&choice),
        corrections: if is_alone { Vec::new() } else { corrections(&data, &chosen) },
        coordinates: robot.coordinates().iter().map(|c| c.name.clone()).collect(),
        joints: arm.joints,
        findings,
        notes: [beyond, assumed, unit_hint(&residuals), is_alone.then(stated_suffice)]
            .into_iter()
            .flatten()
            .collect(),
        residuals,
    })
}

/// The deviations that the file states explain the table as well as the causes do.
fn stated_suffice() -> Note {
    let what = "what the robot's file says that its numbers may be off by (std_percent) explains \
                this table without any cause: the calibration fits these numbers and adds no \
                correction; the causes are named as if all other numbers were exact";
    Note::warning(Code::Calibration, Place::default(), what)
}

fn no_modes() -> Note {
    let what = "the model has no modes at a pose of the table; check its stiffness and masses with \
                detune map";
    Note::error(Code::Singular, Place::default(), what)
}

/// The rows of the table that have a frequency.
fn measured(table: &ModeTable, description: &Description) -> Result<Data, Note> {
    let data = Data::of(table, description.payload.as_ref());
    let mut rows: Vec<usize> = data.points.iter().map(|point| point.row).collect();
    rows.dedup();
    let data = data.only(|row| rows.binary_search(&row).is_ok());
    let (poses, frequencies) = (data.test_count(), data.points.len());
    if poses >= MIN_POSES && frequencies >= MIN_POINTS {
        return Ok(data);
    }
    let counted = |count: usize, one: &str, many: &str| {
        format!("{count} {}", if count == 1 { one } else { many })
    };
    let what = format!(
        "too little data for a diagnosis: {} at {}, must be at least {MIN_POINTS} at {MIN_POSES}; \
         measure more poses",
        counted(frequencies, "frequency", "frequencies"),
        counted(poses, "pose", "poses"),
    );
    Err(Note::error(Code::TooLittleData, Place::default(), what))
}

fn cross_validated(
    problem: &Problem<'_>,
    candidates: &[Candidate],
    screen: &Screen,
    seed: u64,
    progress: Progress<'_>,
) -> HeldOut {
    let folds = AtomicUsize::new(0);
    held_out(problem, candidates, screen, seed, &|| {
        let done = folds.fetch_add(1, Ordering::Relaxed) + 1;
        progress(Done::Share(0.4 + 0.06 * done as f64));
    })
}

/// Root mean square of the residuals for the degrees of freedom that remain.
fn noise_floor(data: &Data, fit: &Fit<'_>) -> f64 {
    let frequencies = data.points.len() as f64;
    let left = (frequencies - fit.freedom).max(1.0);
    rms(fit.evaluation.residuals.iter()) * (frequencies / left).sqrt()
}

fn errors(data: &Data, evaluation: &Evaluation, heldout: f64) -> Errors {
    let errors: Vec<Option<f64>> =
        evaluation.residuals.iter().map(|r| r.map(relative_error)).collect();
    let of_mode = |mode: usize| {
        let own = data.points.iter().zip(&errors).filter(move |(p, _)| p.column == mode);
        percent_from_ratio(rms(own.map(|(_, e)| e)))
    };
    Errors {
        rms_percent: percent_from_ratio(rms(errors.iter())),
        heldout_rms_percent: percent_from_ratio(heldout),
        per_mode_rms_percent: (0..data.columns).map(of_mode).collect(),
    }
}

fn residual_rows(
    data: &Data,
    choice: &Choice<'_>,
    chosen: &Fit<'_>,
    calibrated_ln_hz: &[Option<f64>],
) -> Vec<ResidualRow> {
    let (before, after) = (&choice.baseline.evaluation, &chosen.evaluation);
    data.points
        .iter()
        .enumerate()
        .map(|(i, point)| {
            let predicted = |evaluation: &Evaluation| {
                evaluation.residuals[i].map(|residual| (point.ln_f - residual).exp())
            };
            let row = &data.rows[point.row];
            ResidualRow {
                row: row.index,
                joints: row.q.clone(),
                temperature_c: row.conditions.temperature_c,
                amplitude_nm: row.conditions.amplitude_nm,
                mode: point.column,
                measured_hz: point.ln_f.exp(),
                before_hz: predicted(before),
                after_hz: predicted(after),
                calibrated_hz: calibrated_ln_hz[i].map(f64::exp),
            }
        })
        .collect()
}
