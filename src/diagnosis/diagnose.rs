//! The diagnosis as a whole: choose, question, say how sure, measure the gain, say what to do next.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::arm::Arm;
use super::causes::candidates;
use super::choose::{Choice, Means, SearchWidth};
use super::damping::damping;
use super::data::{Data, MIN_POINTS, MIN_STATES, Point};
use super::findings::{corrections, findings, next, only, ranking, widened};
use super::fit::Fit;
use super::gain::{HeldOut, gain_interval, held_out, surely_gaining};
use super::hypothesis::Hypothesis;
use super::known::Known;
use super::outcome::{Diagnosis, Errors, Gain, NoiseFound, ResidualRow, Verdict, WithoutCause};
use super::posterior::{Calibrated, cost, posterior};
use super::problem::{Evaluation, Problem};
use super::rivals::widened_by_rivals;
use super::screen::Screen;
use super::settle::{ALONE_WRONG, Settled, settled};
use super::statistics::{relative_error, rms};
use super::symmetry::symmetry;
use super::table::{check_rows, unit_hint, within_the_model};
use super::unexplained::{
    as_far_off_as_held_out, as_far_off_as_seen, as_far_off_as_the_middle, as_hinges_stand_for_beams,
};
use super::unstated::{Stated, inert, stated};
use super::verdict::{
    Judged, MAX_NOISE, Worth, drift_of, drift_with_temperature, offset_of_drift, significant,
};
use super::without_cause::without_cause;
use crate::identify::ModeTable;
use crate::model::{Cause, Description, Robot};
use crate::notes::{Code, Note, Place};
use crate::progress::{Done, Progress};
use crate::statistics::rank_with_order;
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
    let mut data = measured(&table, description)?;
    data.inert = inert(description, &Hypothesis::default(), &data);
    let arm = Arm::new(description, &robot, &data).ok_or_else(no_modes)?;
    let Stated { candidates, untested, note: assumed } =
        stated(description, &robot, &data, &table.unstated, candidates(&arm));
    let screen =
        Screen::new(&Problem { description, data: &data }, &candidates).ok_or_else(no_modes)?;
    progress(Done::Share(0.1));
    let known = Known::default();
    let Settled { mut data, choice, suspects } =
        settled(description, data, &candidates, &screen, &known).ok_or_else(no_modes)?;
    // A cause may make a state of what was none.
    data.inert = inert(description, &choice.best.fit.hypothesis, &data);
    let problem = Problem { description, data: &data };
    progress(Done::Share(0.4));
    let judged = Judged::of(&problem, &choice);
    let Judgement { verdict, choice, held_out, predicts } =
        judgement(&problem, &judged, choice, settings.seed, |causes| {
            let width = SearchWidth::of_fold(causes);
            let means = Means { candidates: &candidates, screen: &screen, width, known: &known };
            cross_validated(&problem, means, settings.seed, progress)
        });
    let names_causes = matches!(verdict, Verdict::Explained | Verdict::PartlyExplained);
    let chosen = if names_causes {
        widened(&problem, &candidates, &choice.best.fit)
    } else {
        choice.baseline.clone()
    };
    let (findings, (next_poses, next_tests)) = if names_causes {
        (findings(&problem, candidates.len(), &choice, &chosen), next(&problem, &robot, &choice))
    } else {
        Default::default()
    };
    let calibrated = posterior(&problem, &chosen).ok_or_else(no_modes)?;
    let has_causes = !chosen.hypothesis.effects.is_empty();
    let alone = (has_causes && uncertainty::stated(&robot).is_some_and(|of| !of.is_empty()))
        .then(|| posterior(&problem, &choice.baseline))
        .flatten()
        .filter(|alone| {
            alone.ln_evidence > calibrated.ln_evidence - cost(&data, &chosen, candidates.len())
        });
    let is_alone = alone.is_some();
    let mut calibrated = alone.unwrap_or(calibrated);
    if names_causes && !is_alone && data.test_count() >= MIN_STATES {
        as_far_off_as_held_out(&data, &held_out.after, &mut calibrated);
    }
    let Calibrated { mut posterior, ln_hz, .. } = calibrated;
    let of_posterior = if is_alone { &choice.baseline } else { &chosen };
    let unexplained = &mut posterior.unexplained;
    widened_by_rivals(&problem, &robot, of_posterior, &choice.seen, candidates.len(), unexplained)
        .ok_or_else(no_modes)?;
    let modes = robot.coordinates().len();
    as_hinges_stand_for_beams(&data, of_posterior, modes, unexplained);
    as_far_off_as_the_middle(offset_of_drift(&data, &chosen), unexplained);
    if verdict == Verdict::Unexplained {
        as_far_off_as_seen(&data, &choice.baseline, unexplained);
    }
    progress(Done::Share(1.0));
    let [before, after] = [&held_out.before, &held_out.after].map(|errors| rms(errors.iter()));
    let without_cause = (verdict == Verdict::Unexplained)
        .then(|| without_cause(&data, &choice.baseline, &arm.joints, settings.seed))
        .flatten();
    let residuals = residual_rows(&data, &choice, &chosen, (&ln_hz, without_cause.as_ref()));
    let leaves_noise = matches!(verdict, Verdict::Explained | Verdict::Consistent);
    Ok(Diagnosis {
        verdict,
        poses: data.test_count(),
        gain: Gain {
            percent_points: percent_from_ratio(before - after),
            ci95: gain_interval(&data, &held_out, settings.seed).map(percent_from_ratio),
        },
        predicts,
        without_cause,
        baseline: errors(&data, &choice.baseline, before, judged.is_noise),
        extended: errors(&data, &chosen, after, leaves_noise),
        noise: noise_found(&data, &chosen),
        damping: damping(&problem, &chosen),
        suspect_rows: suspects.iter().map(|row| row + 1).collect(),
        noise_floor_percent: percent_from_ratio(noise_floor(&data, &chosen)),
        posterior,
        structure_before: judged.before.clone(),
        structure_after: match verdict {
            Verdict::Explained => judged.after,
            // Of what was kept of the causes.
            Verdict::PartlyExplained => significant(&problem, &choice.best.fit),
            Verdict::Consistent | Verdict::Unexplained => judged.before,
        },
        symmetry: symmetry(&robot, &data, &residuals, &candidates),
        untested,
        next_poses,
        next_tests,
        ranking: ranking(&choice),
        corrections: if is_alone { Vec::new() } else { corrections(&data, &chosen) },
        findings,
        notes: [
            beyond,
            assumed,
            unit_hint(&residuals),
            is_alone.then(stated_suffice),
            set_aside(&suspects),
            (verdict == Verdict::Unexplained)
                .then(|| stands_alone(&data, &choice.baseline, judged.wrong_row?))
                .flatten(),
            names_causes.then(|| far_off(&data, &chosen)).flatten(),
            out_of_rank(&data, &chosen),
            few_states(&data),
            one_joint_alone(&data, &arm, &chosen),
            drifts_as_temperature(&data, &chosen),
        ]
        .into_iter()
        .flatten()
        .collect(),
        joints: arm.joints,
        residuals,
    })
}

/// A verdict with the causes that it names, and errors at states left out.
struct Judgement<'c> {
    verdict: Verdict,
    choice: Choice<'c>,
    held_out: HeldOut,
    predicts: bool,
}

/// Causes are named where they surely gain at states left out.
fn judgement<'c>(
    problem: &Problem<'_>,
    judged: &Judged,
    mut choice: Choice<'c>,
    seed: u64,
    cross_validated: impl FnOnce(usize) -> HeldOut,
) -> Judgement<'c> {
    let data = problem.data;
    let unchanged = HeldOut::unchanged(&choice.baseline.evaluation);
    let without = if judged.is_noise { Verdict::Consistent } else { Verdict::Unexplained };
    let unexplained =
        |choice, held_out| Judgement { verdict: without, choice, held_out, predicts: true };
    let worth = judged.causes.filter(|worth| *worth != Worth::Nothing);
    let Some(worth) = worth else {
        return unexplained(choice, unchanged);
    };
    if data.test_count() < MIN_STATES {
        // Nothing can be left out, so nothing is gained that anybody knows of.
        let verdict = Verdict::PartlyExplained;
        return Judgement { verdict, choice, held_out: unchanged, predicts: true };
    }
    let sure_alone = |choice: &Choice<'c>| {
        let sure = surely_gaining(problem, &choice.best.fit.hypothesis, seed);
        only(problem, choice, &sure)
    };
    let causes = choice.best.causes();
    if worth == Worth::Part {
        match sure_alone(&choice) {
            Some(kept) => choice = kept,
            None => return unexplained(choice, unchanged),
        }
    }
    let held_out = cross_validated(causes);
    if gain_interval(data, &held_out, seed)[0] <= 0.0 {
        return unexplained(choice, unchanged);
    }
    let predicts = predicts_left_out(data, &choice.best.fit, &held_out);
    if worth == Worth::All && predicts {
        return Judgement { verdict: Verdict::Explained, choice, held_out, predicts };
    }
    // Together the causes surely gain; where each can stand in for another, none does by itself.
    if worth == Worth::All
        && let Some(kept) = sure_alone(&choice)
    {
        choice = kept;
    }
    Judgement { verdict: Verdict::PartlyExplained, choice, held_out, predicts }
}

/// Whether causes predict states that were left out about as well as they fit the others, or to
/// what is noise anyway.
fn predicts_left_out(data: &Data, fit: &Fit<'_>, held_out: &HeldOut) -> bool {
    /// Of the error that remains where nothing is left out.
    const MOST: f64 = 2.0;
    rms(held_out.after.iter()) <= (MOST * noise_floor(data, fit)).max(MAX_NOISE)
}

fn set_aside(suspects: &[usize]) -> Option<Note> {
    let rows: Vec<String> = suspects.iter().map(|row| (row + 1).to_string()).collect();
    let [_, others @ ..] = &rows[..] else { return None };
    let (noun, verb) = if others.is_empty() { ("row", "fits") } else { ("rows", "fit") };
    let what = format!(
        "{noun} {} of the table {verb} neither the model nor any cause that fits the others: set \
         aside; check the angles and frequencies written there",
        rows.join(", ")
    );
    Some(Note::warning(Code::LeftOut, Place::default(), what))
}

/// One row that is far off, where other poses do not bear out what may explain it.
fn stands_alone(data: &Data, baseline: &Fit<'_>, row: usize) -> Option<Note> {
    let points = data.points.iter().zip(&baseline.evaluation.left.residuals);
    let own = points.filter(|(point, _)| point.row == row).filter_map(|(p, r)| Some((p, (*r)?)));
    let (point, residual) = own.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let what = format!(
        "row {} of the table is off by far more than the others (f{}: {:.2} Hz, in the model \
         {:.2} Hz), and no other pose bears out what may explain it: a slip, or something that \
         shows only near this pose; measure it again, and poses near it",
        data.rows[row].index + 1,
        point.column + 1,
        point.ln_f.exp(),
        (point.ln_f - residual).exp()
    );
    Some(Note::warning(Code::Outlier, Place::default(), what))
}

/// Frequencies that causes leave far beyond the scatter of the others: slips, which widen what the
/// calibration says of their modes.
fn far_off(data: &Data, chosen: &Fit<'_>) -> Option<Note> {
    /// Less of a frequency is no slip.
    const LEAST: f64 = 0.02;
    const SHOWN: usize = 5;
    let scale = chosen.evaluation.noise.scale;
    let points = data.points.iter().zip(&chosen.evaluation.left.residuals);
    let all = points.filter_map(|(point, residual)| {
        let (r, std) = ((*residual)?, (scale * point.unit).hypot(point.rounding.sqrt()));
        (r.abs() > (ALONE_WRONG * std).max(LEAST)).then_some((point, r))
    });
    let mut all: Vec<_> = all.collect();
    all.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let of = |(point, residual): &(&Point, f64)| {
        format!(
            "row {}, f{}: {:.2} Hz, with the causes {:.2} Hz",
            data.rows[point.row].index + 1,
            point.column + 1,
            point.ln_f.exp(),
            (point.ln_f - residual).exp()
        )
    };
    let mut shown: Vec<String> = all.iter().take(SHOWN).map(of).collect();
    if all.len() > SHOWN {
        shown.push(format!("and {} more", all.len() - SHOWN));
    }
    (!all.is_empty()).then(|| {
        let what = format!(
            "off by more than {ALONE_WRONG:.0} times the scatter of the others: {}; check what is \
             written there, and measure it again: the intervals of these modes are wider for it",
            shown.join("; ")
        );
        Note::warning(Code::Outlier, Place::default(), what)
    })
}

fn out_of_rank(data: &Data, chosen: &Fit<'_>) -> Option<Note> {
    let rows = chosen.evaluation.left.out_of_rank.iter();
    let rows: Vec<String> = rows.map(|&row| (data.rows[row].index + 1).to_string()).collect();
    let [_, others @ ..] = &rows[..] else { return None };
    let (noun, verb) = if others.is_empty() { ("row", "has") } else { ("rows", "have") };
    let what = format!(
        "{noun} {} of the table, by the mode shapes, {verb} modes exchanged or missed against the \
         model: frequencies there are compared with the modes that the shapes name",
        rows.join(", ")
    );
    Some(Note::warning(Code::Remark, Place::default(), what))
}

fn few_states(data: &Data) -> Option<Note> {
    let count = data.test_count();
    let what = format!(
        "the table has {count} state{} (poses, loads, conditions that predict something new): with \
         fewer than {MIN_STATES} none can be left out, so no gain is known and the calibration \
         claims no less than the error before",
        if count == 1 { "" } else { "s" }
    );
    (count < MIN_STATES).then(|| Note::warning(Code::TooLittleData, Place::default(), what))
}

/// Several causes by a table along one joint: other sets of causes may be about as good.
fn one_joint_alone(data: &Data, arm: &Arm<'_>, chosen: &Fit<'_>) -> Option<Note> {
    /// What a joint that stands is read at varies by less, rad or m; so little tells no causes
    /// apart.
    const STILL: f64 = 0.02;
    let (joint, _) = arm.joints.get(data.swept_joint(STILL)?)?;
    let of_the_arm = chosen.hypothesis.effects.iter().filter(|(candidate, _)| {
        !candidate.cause.is_of_the_instrument() && !candidate.cause.is_of_conditions()
    });
    let what = format!(
        "only {joint} moves in the rows that are used: along one joint, other sets of causes can \
         fit nearly as well, so together the causes are less certain than each looks; measure \
         poses at which other joints differ, or with a mass added, before you replace a part"
    );
    (of_the_arm.count() > 1 && arm.joints.len() > 1)
        .then(|| Note::warning(Code::Remark, Place::default(), what))
}

/// A drift that goes with the temperature, or a temperature that rises or falls with the rows as a
/// drift would, whichever of both it is.
fn drifts_as_temperature(data: &Data, chosen: &Fit<'_>) -> Option<Note> {
    const ALIKE: f64 = 0.7;
    const IN_ORDER: f64 = 0.9;
    let mut effects = chosen.hypothesis.effects.iter();
    let has_law = effects.any(|(candidate, _)| candidate.cause == Cause::TemperatureDrift);
    let what = if has_law {
        let rows: Option<Vec<f64>> =
            data.rows.iter().map(|row| row.conditions.temperature_c).collect();
        let in_order = rows.map(|rows| rank_with_order(&rows)).filter(|r| r.abs() >= IN_ORDER)?;
        format!(
            "the temperature follows the order of the rows (rank correlation {in_order:.2}): a \
             drift of instrument or clamping looks like a law of temperature here"
        )
    } else {
        let found = drift_with_temperature(data, chosen).filter(|found| found.abs() >= ALIKE)?;
        format!(
            "the frequencies drift over the rows, and the temperature with them (correlation \
             {found:.2}): the table does not tell a drift from a law of temperature, and the \
             calibration has none, so frequencies at other temperatures are not checked"
        )
    };
    let what = format!(
        "{what}; measure one pose cold and warm, in an order that does not follow the hours"
    );
    Some(Note::warning(Code::Calibration, Place::default(), what))
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
    let frequencies = data.points.len();
    if frequencies >= MIN_POINTS {
        return Ok(data);
    }
    let noun = if frequencies == 1 { "frequency" } else { "frequencies" };
    let what = format!(
        "too little data for a diagnosis: {frequencies} {noun}, must be at least {MIN_POINTS}; \
         measure more poses",
    );
    Err(Note::error(Code::TooLittleData, Place::default(), what))
}

fn cross_validated(
    problem: &Problem<'_>,
    means: Means<'_, '_>,
    seed: u64,
    progress: Progress<'_>,
) -> HeldOut {
    let ended = AtomicUsize::new(0);
    held_out(problem, means, seed, &|folds| {
        let done = ended.fetch_add(1, Ordering::Relaxed) + 1;
        progress(Done::Share(0.4 + 0.5 * done as f64 / folds as f64));
    })
}

/// Root mean square of the residuals for the degrees of freedom that remain.
fn noise_floor(data: &Data, fit: &Fit<'_>) -> f64 {
    let frequencies = data.points.len() as f64;
    let left = (frequencies - fit.freedom).max(1.0);
    rms(fit.evaluation.left.residuals.iter()) * (frequencies / left).sqrt()
}

fn errors(data: &Data, fit: &Fit<'_>, heldout: f64, leaves_noise: bool) -> Errors {
    let errors: Vec<Option<f64>> =
        fit.evaluation.left.residuals.iter().map(|r| r.map(relative_error)).collect();
    let of_mode = |mode: usize| {
        let own = data.points.iter().zip(&errors).filter(move |(p, _)| p.column == mode);
        percent_from_ratio(rms(own.map(|(_, e)| e)))
    };
    // Where structure is left, what remains is no noise: only what the table says of it is known.
    let known = data.repeatability().or(data.stated_noise).unwrap_or(0.0);
    let noise = if leaves_noise { noise_floor(data, fit).max(known) } else { known };
    let model = (heldout * heldout - noise * noise).max(0.0).sqrt();
    Errors {
        rms_percent: percent_from_ratio(rms(errors.iter())),
        heldout_rms_percent: percent_from_ratio(heldout),
        model_error_percent: percent_from_ratio(model),
        per_mode_rms_percent: (0..data.columns).map(of_mode).collect(),
    }
}

/// How the noise of the table is made, as a fit leaves it.
fn noise_found(data: &Data, fit: &Fit<'_>) -> NoiseFound {
    let level = fit.evaluation.noise.scale;
    let of_mode = |mode: usize| percent_from_ratio(level * data.shape.scale(mode));
    NoiseFound {
        per_mode_percent: (0..data.columns).map(of_mode).collect(),
        common_percent: percent_from_ratio(level * data.shape.common),
        drift_percent: percent_from_ratio(drift_of(data, fit)),
        stated_percent: data.stated_noise.map(percent_from_ratio),
    }
}

fn residual_rows(
    data: &Data,
    choice: &Choice<'_>,
    chosen: &Fit<'_>,
    (calibrated_ln_hz, without_cause): (&[Option<f64>], Option<&WithoutCause>),
) -> Vec<ResidualRow> {
    let (before, after) = (&choice.baseline.evaluation, &chosen.evaluation);
    data.points
        .iter()
        .enumerate()
        .map(|(i, point)| {
            let predicted = |evaluation: &Evaluation| {
                evaluation.left.residuals[i].map(|residual| (point.ln_f - residual).exp())
            };
            let row = &data.rows[point.row];
            let before_hz = predicted(before);
            let corrected = without_cause
                .zip(before_hz)
                .and_then(|(own, hz)| own.corrected(point.column, &row.q, hz));
            ResidualRow {
                row: row.index,
                joints: row.q.clone(),
                temperature_c: row.conditions.temperature_c,
                amplitude_nm: row.conditions.amplitude_nm,
                mode: point.column,
                measured_hz: point.ln_f.exp(),
                before_hz,
                after_hz: predicted(after),
                calibrated_hz: calibrated_ln_hz[i].map(f64::exp),
                without_cause_hz: corrected.map(|own| own.hz),
                without_cause_ci95_hz: corrected.map(|own| own.ci95_hz),
            }
        })
        .collect()
}
