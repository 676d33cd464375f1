//! Whether causes explain what a model gets wrong, whether the model is consistent, or the error is
//! unexplained.

use std::f64::consts::SQRT_2;

use statrs::function::erf::erfc;

use super::choose::Choice;
use super::data::Data;
use super::decorrelation::NoiseShape;
use super::fit::Fit;
use super::outcome::Structure;
use super::problem::Problem;
use super::settle::{is_no_noise, worst};
use super::statistics::rms;
use super::structure::{self, structure};
use crate::statistics::{correlation, signed_rank};
use crate::uncertainty::uncalibrated_std_ln;

/// An error without structure is noise up to here, share of the frequency: hammer tests of arms
/// repeat within a per cent,
pub(super) const MAX_NOISE: f64 = 0.017;

/// one mode that is hard to excite within more,
const MAX_NOISE_OF_MODE: f64 = 0.025;

/// or up to this multiple of the deviations that the table states.
const MAX_TIMES_STATED: f64 = 2.0;

/// A shape without a cause explains better than the causes do if its log evidence is higher by
/// this.
const SHAPE_BETTER_BY: f64 = 4.0;

/// The structure of the remaining residual is immaterial where the causes explain this share of the
/// squared error, and what is left is no more than an uncalibrated model is off by,
const OVERWHELMING: f64 = 0.985;

/// or where it has less than this share of the square of that residual: 0.6 of the noise.
const MIN_SHARE: f64 = 0.26;

/// Causes that explain less than this share of the squared error, where structure remains, are
/// not worth naming.
const MIN_EXPLAINED: f64 = 0.6;

/// What the residuals say; what causes gain at states left out has a say, too.
pub(super) struct Judged {
    /// Whether the model as it is agrees with the table but for noise.
    pub(super) is_noise: bool,
    /// What the causes are worth, if there are any.
    pub(super) causes: Option<Worth>,
    /// The row that the model as it is misses by far more than the others, if there is one.
    pub(super) wrong_row: Option<usize>,
    pub(super) before: Option<Structure>,
    pub(super) after: Option<Structure>,
}

/// What causes are worth by the residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Worth {
    /// They leave noise, or what is immaterial.
    All,
    /// They leave structure.
    Part,
    /// A shape without a cause explains as much, or they explain little.
    Nothing,
}

impl Judged {
    pub(super) fn of(problem: &Problem<'_>, choice: &Choice<'_>) -> Self {
        let data = problem.data;
        let baseline = structure(problem, &choice.baseline);
        let before = baseline.as_ref().map(|s| s.clearest.clone()).filter(is_significant);
        let most = MAX_NOISE.max(MAX_TIMES_STATED * data.stated_noise.unwrap_or(0.0));
        let is_small = |fit: &Fit<'_>| {
            let level = fit.evaluation.noise.scale;
            let common = level * data.shape.common.max(1.0);
            let worst = (0..data.columns).map(|mode| level * data.shape.scale(mode));
            common.hypot(rms_about_mean(&taken_by_drift(data, fit))) <= most
                && worst.fold(0.0, f64::max) <= MAX_NOISE_OF_MODE.max(most)
        };
        // A robust level knows nothing of the frequencies that are far off.
        let largest = 2.0 * MAX_NOISE_OF_MODE.max(most);
        let of_mode = |mode: usize| {
            let own = data.points.iter().zip(&choice.baseline.evaluation.left.innovations);
            own.filter(move |(point, _)| point.column == mode).map(|(_, r)| r)
        };
        let is_far_off = |mode: usize| rms(of_mode(mode)) > largest;
        // As a wide noise of one mode passes for what another mode beside it does at some poses.
        let is_one_sided = |mode: usize| {
            let own: Vec<f64> = of_mode(mode).flatten().copied().collect();
            let p_value = erfc(signed_rank(&own).abs() / SQRT_2);
            rms(of_mode(mode)) > most && p_value * (data.columns as f64) < structure::SIGNIFICANCE
        };
        let wrong_row = worst(data, &choice.baseline.evaluation, is_no_noise);
        let is_noise = before.is_none()
            && wrong_row.is_none()
            && is_small(&choice.baseline)
            && !(0..data.columns).any(|mode| is_far_off(mode) || is_one_sided(mode));
        if choice.best.fit.hypothesis.effects.is_empty() {
            return Self { is_noise, causes: None, wrong_row, after: before.clone(), before };
        }
        let after = significant(problem, &choice.best.fit);
        let log_evidence_before = choice.baseline.evaluation.score;
        let shape_is_better = baseline.as_ref().is_some_and(|s| {
            log_evidence_before + s.best_log_evidence > choice.best.log_evidence + SHAPE_BETTER_BY
        });
        let square = |fit: &Fit<'_>| rms(fit.evaluation.left.innovations.iter()).powi(2);
        let explained = 1.0 - square(&choice.best.fit) / square(&choice.baseline).max(1e-300);
        // What is too large for noise is not explained, whether it shows a shape or none.
        let is_left =
            after.as_ref().is_some_and(|s| s.share >= MIN_SHARE) || !is_small(&choice.best.fit);
        let is_overwhelming =
            explained >= OVERWHELMING && square(&choice.best.fit).sqrt() <= uncalibrated_std_ln();
        let worth = if is_overwhelming || !(is_left || shape_is_better) {
            if is_at_bound(&choice.best.fit) { Worth::Part } else { Worth::All }
        } else if shape_is_better || explained < MIN_EXPLAINED {
            Worth::Nothing
        } else {
            Worth::Part
        };
        Self { is_noise, causes: Some(worth), wrong_row, before, after }
    }
}

/// What the residual of a fit follows, if that is no chance.
pub(super) fn significant(problem: &Problem<'_>, fit: &Fit<'_>) -> Option<Structure> {
    structure(problem, fit).map(|found| found.clearest).filter(is_significant)
}

/// Whether the size of a cause ended where the search does: no cause of that size was meant.
fn is_at_bound(fit: &Fit<'_>) -> bool {
    fit.hypothesis.effects.iter().any(|(candidate, inner)| {
        let size = candidate.parameters.first().zip(inner.first());
        size.is_some_and(|(parameter, &inner)| parameter.is_at_bound(inner))
    })
}

fn is_significant(structure: &Structure) -> bool {
    structure.p_value < structure::SIGNIFICANCE
}

/// The drift over the rows that a fit leaves, root mean square, share of the frequency.
pub(super) fn drift_of(data: &Data, fit: &Fit<'_>) -> f64 {
    rms(taken_by_drift(data, fit).iter())
}

/// How far the model is off on average over the rows for a drift, share of the frequency.
pub(super) fn offset_of_drift(data: &Data, fit: &Fit<'_>) -> f64 {
    mean(&taken_by_drift(data, fit)).abs()
}

/// Correlation of the drift that a fit leaves with the temperature; `None` without either.
pub(super) fn drift_with_temperature(data: &Data, fit: &Fit<'_>) -> Option<f64> {
    let temperature = |row: usize| data.rows[row].conditions.temperature_c;
    let points = data.points.iter().zip(taken_by_drift(data, fit));
    let pairs: Vec<(f64, f64)> =
        points.filter_map(|(point, taken)| temperature(point.row).zip(taken)).collect();
    correlation(&pairs)
}

/// How far the drift moves over the rows, whatever it was at the first.
fn rms_about_mean(taken: &[Option<f64>]) -> f64 {
    let mean = mean(taken);
    let about: Vec<Option<f64>> = taken.iter().map(|own| own.map(|own| own - mean)).collect();
    rms(about.iter())
}

fn mean(taken: &[Option<f64>]) -> f64 {
    let known: Vec<f64> = taken.iter().flatten().copied().collect();
    known.iter().sum::<f64>() / known.len().max(1) as f64
}

/// What the drift takes of the residuals that a fit leaves.
fn taken_by_drift(data: &Data, fit: &Fit<'_>) -> Vec<Option<f64>> {
    if data.shape.drift == 0.0 {
        return Vec::new();
    }
    // What the map takes out beyond that of the same shape without drift.
    let still = data.shaped(NoiseShape { drift: 0.0, ..data.shape.clone() });
    let residuals = &fit.evaluation.left.residuals;
    let kept = still.decorrelation.of_residuals(residuals);
    let both = kept.iter().zip(&fit.evaluation.left.innovations);
    both.map(|(kept, left)| Some((*kept)? - (*left)?)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::choose::{Means, SearchWidth, choose};
    use super::super::fit::tests::{arm, data};
    use super::super::hypothesis::Hypothesis;
    use super::super::known::Known;
    use super::super::screen::Screen;
    use super::*;

    /// One mode at every third pose is off by 4 %: to both sides that is a mode that is hard to
    /// excite, to one side it is something else.
    #[test]
    fn a_mode_that_is_off_to_one_side_is_no_noise() {
        let description = arm();
        let is_noise = |sides: [f64; 2]| {
            let mut table = data(60);
            let problem = Problem { description: &description, data: &table };
            let off = problem.compare(&Hypothesis::default()).unwrap().left.residuals;
            for (point, off) in table.points.iter_mut().zip(off) {
                let (row, column) = (point.row, point.column);
                // Golden ratio: as good as random, and even.
                let u = (0.618_034 * (3 * row + column + 1) as f64).fract() - 0.5;
                let is_far = column == 2 && row % 3 == 1;
                let far = if is_far { 0.04 * sides[(row / 5 + row % 5 / 2) % 2] } else { 0.0 };
                point.ln_f += 0.012 * u + far - off.unwrap();
            }
            let scales = vec![1.0, 1.0, 4.0];
            let table = table.shaped(NoiseShape { scales, ..NoiseShape::plain() });
            let problem = Problem { description: &description, data: &table };
            let screen = Screen::new(&problem, &[]).unwrap();
            let known = Known::default();
            let (screen, known, width) = (&screen, &known, SearchWidth::of_fold(3));
            let means = Means { candidates: &[], screen, width, known };
            Judged::of(&problem, &choose(&problem, means).unwrap()).is_noise
        };
        assert!(is_noise([1.0, -1.0]));
        assert!(!is_noise([1.0, 1.0]));
    }
}
