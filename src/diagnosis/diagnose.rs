//! The diagnosis as a whole: choose, question, say how sure, measure the gain, say what to do next.

use super::arm::Arm;
use super::causes::candidates;
use super::choose::{Effort, choose};
use super::data::{Data, FEWEST_POINTS, FEWEST_ROWS};
use super::findings::{corrections, findings, next, ranking, widened};
use super::fit::Fit;
use super::gain::{HeldOut, gain_interval, held_out, relative_error, rms};
use super::outcome::{Diagnosis, DiagnosisFault, Errors, Gain, ResidualRow, Verdict};
use super::problem::{Evaluation, Problem};
use super::screen::Screen;
use super::verdict::Judged;
use crate::identify::ModeTable;
use crate::model::{Description, Robot};
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

/// Diagnoses a robot by a table of measured modes. `progress` is called with the share of the work done.
///
/// # Errors
/// Too little data, a row that is none of this robot's, or a model without modes at a pose of the table.
pub fn diagnose(
    description: &Description,
    table: &ModeTable,
    settings: Settings,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Diagnosis, DiagnosisFault> {
    let robot = Robot::new(description).map_err(|_| DiagnosisFault::NoModes)?;
    check_rows(&robot, table)?;
    let data = Data::of(table, description.payload.as_ref());
    let mut rows: Vec<usize> = data.points.iter().map(|point| point.row).collect();
    rows.dedup();
    let frequencies = data.points.len();
    let data = data.only(|row| rows.binary_search(&row).is_ok());
    let poses = data.tests().into_iter().max().map_or(0, |last| last + 1);
    if poses < FEWEST_ROWS || frequencies < FEWEST_POINTS {
        return Err(DiagnosisFault::TooLittle { poses, frequencies });
    }
    let arm = Arm::new(description, &robot, &data).ok_or(DiagnosisFault::NoModes)?;
    let candidates = candidates(&arm);
    let problem = Problem { description, data: &data };
    let screen = Screen::new(&problem, &candidates).ok_or(DiagnosisFault::NoModes)?;
    progress(0.1);
    let choice =
        choose(&problem, &candidates, &screen, Effort::FULL).ok_or(DiagnosisFault::NoModes)?;
    progress(0.4);
    let judged = Judged::of(&problem, &choice);
    let chosen: Fit<'_> = match judged.verdict {
        Verdict::Explained => widened(&problem, &candidates, &choice.best.fit),
        Verdict::Consistent | Verdict::Unexplained => choice.nothing.clone(),
    };
    let folds = std::sync::atomic::AtomicUsize::new(0);
    let held_out = match judged.verdict {
        Verdict::Explained => {
            held_out(description, &data, &candidates, &screen, settings.seed, &|| {
                let done = folds.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
                progress(0.4 + 0.06 * done as f64);
            })
        }
        // Nothing was fitted: every pose is one left out.
        Verdict::Consistent | Verdict::Unexplained => {
            HeldOut::unchanged(&choice.nothing.evaluation)
        }
    };
    let [held_out_before, held_out_after] =
        [&held_out.before, &held_out.after].map(|errors| rms(errors.iter()));
    let interval = gain_interval(&data, &held_out, settings.seed);
    let baseline = errors(&data, &choice.nothing.evaluation, held_out_before);
    let extended = errors(&data, &chosen.evaluation, held_out_after);
    let findings = if judged.verdict == Verdict::Explained {
        findings(&problem, candidates.len(), &choice, &chosen)
    } else {
        Vec::new()
    };
    let (next_poses, next_tests) = if judged.verdict == Verdict::Explained {
        next(&problem, &robot, &choice)
    } else {
        Default::default()
    };
    progress(1.0);
    let noise_left = (frequencies as f64 - chosen.freedom).max(1.0);
    let floor = rms(chosen.evaluation.residuals.iter()) * (frequencies as f64 / noise_left).sqrt();
    Ok(Diagnosis {
        verdict: judged.verdict,
        poses,
        gain: Gain {
            percent_points: percent_from_ratio(held_out_before - held_out_after),
            ci95: interval.map(percent_from_ratio),
        },
        baseline,
        extended,
        noise_floor_percent: percent_from_ratio(floor),
        structure_before: judged.before,
        structure_after: judged.after,
        next_poses,
        next_tests,
        ranking: ranking(&choice),
        residuals: residual_rows(&data, &choice.nothing.evaluation, &chosen.evaluation),
        corrections: corrections(&data, &chosen),
        coordinates: robot.coordinates().iter().map(|c| c.name.clone()).collect(),
        joints: arm.joints,
        findings,
    })
}

/// What reading a file makes sure of, for tables that were made otherwise.
fn check_rows(robot: &Robot, table: &ModeTable) -> Result<(), DiagnosisFault> {
    let positive = |value: &Option<f64>| value.is_none_or(|f| f.is_finite() && f > 0.0);
    for (row, measured) in table.rows.iter().enumerate() {
        let fault = |what: String| Err(DiagnosisFault::Row { row, what });
        if let Err(bad) = robot.check_pose(&measured.pose) {
            return fault(bad.to_string());
        }
        let numbers = measured.frequencies_hz.iter().chain(&measured.deviations_hz);
        if !numbers.into_iter().all(positive) || measured.frequencies_hz.len() != table.modes {
            return fault(format!(
                "frequencies are {:?} Hz and deviations {:?} Hz, must be {} and positive",
                measured.frequencies_hz, measured.deviations_hz, table.modes
            ));
        }
    }
    Ok(())
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

fn residual_rows(data: &Data, before: &Evaluation, after: &Evaluation) -> Vec<ResidualRow> {
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
            }
        })
        .collect()
}
