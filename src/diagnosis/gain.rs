//! What the causes gain at poses that they were not fitted to: cross-validation in which the whole choice
//! is repeated in each fold.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::candidate::Candidate;
use super::choose::{Effort, choose};
use super::data::Data;
use super::hypothesis::Hypothesis;
use super::problem::{Evaluation, Problem};
use super::screen::Screen;
use crate::model::Description;

/// Folds of the cross-validation.
const FOLDS: usize = 8;

/// Resamples of the poses for the interval of the gain.
const RESAMPLES: usize = 1000;

/// Relative errors, one a point, without and with the causes, at poses left out.
#[derive(Debug, Clone)]
pub(super) struct HeldOut {
    pub(super) before: Vec<Option<f64>>,
    pub(super) after: Vec<Option<f64>>,
}

impl HeldOut {
    /// Of a model without causes.
    pub(super) fn unchanged(nothing: &Evaluation) -> Self {
        let errors: Vec<_> = nothing.residuals.iter().map(|r| r.map(relative_error)).collect();
        Self { before: errors.clone(), after: errors }
    }
}

/// ln(measured/predicted) → (predicted − measured)/measured.
pub(super) fn relative_error(residual: f64) -> f64 {
    (-residual).exp_m1()
}

/// Root mean square of what is there; 0 of nothing.
pub(super) fn rms<'e>(errors: impl Iterator<Item = &'e Option<f64>>) -> f64 {
    let (sum, count) = errors.flatten().fold((0.0, 0.0), |(s, n), e| (s + e * e, n + 1.0));
    if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
}

/// Errors of the model and of the model with the causes that each fold chooses, at the poses that the fold
/// leaves out. `done` is called once a fold.
pub(super) fn held_out(
    description: &Description,
    data: &Data,
    candidates: &[Candidate],
    screen: &Screen,
    seed: u64,
    done: &(dyn Fn() + Sync),
) -> HeldOut {
    // A repeated test is left out as a whole: a pose that was seen is no pose left out.
    let tests = data.tests();
    let count = tests.iter().max().map_or(0, |last| last + 1);
    let folds = FOLDS.min(count);
    let mut order: Vec<usize> = (0..count).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let mut fold_of_test = vec![0; count];
    order.iter().enumerate().for_each(|(i, &test)| fold_of_test[test] = i % folds);
    let fold_of: Vec<usize> = tests.iter().map(|&test| fold_of_test[test]).collect();
    let errors_of = |data: &Data, hypothesis: &Hypothesis<'_>| -> Vec<Option<f64>> {
        let problem = Problem { description, data };
        problem.evaluate(hypothesis, false).map_or_else(
            || vec![None; data.points.len()],
            |evaluation| evaluation.residuals.iter().map(|r| r.map(relative_error)).collect(),
        )
    };
    let chosen: Vec<Vec<Option<f64>>> = (0..folds)
        .into_par_iter()
        .map(|fold| {
            let train = data.only(|row| fold_of[row] != fold);
            let test = data.only(|row| fold_of[row] == fold);
            let choice =
                choose(&Problem { description, data: &train }, candidates, screen, Effort::FOLD);
            let hypothesis =
                choice.map_or_else(Hypothesis::default, |choice| choice.best.fit.hypothesis);
            let errors = errors_of(&test, &hypothesis);
            done();
            errors
        })
        .collect();
    let before = errors_of(data, &Hypothesis::default());
    let mut next = vec![0; folds];
    let after = data
        .points
        .iter()
        .zip(&before)
        .map(|(point, before)| {
            let fold = fold_of[point.row];
            next[fold] += 1;
            // Where the causes leave no such mode, nothing is gained.
            chosen[fold][next[fold] - 1].or(*before)
        })
        .collect();
    HeldOut { before, after }
}

/// 95 % interval of rms before − rms after, as shares, over resampled poses.
pub(super) fn gain_interval(data: &Data, held_out: &HeldOut, seed: u64) -> [f64; 2] {
    let rows = data.rows.len();
    let mut sums = vec![[0.0; 4]; rows];
    for ((point, before), after) in data.points.iter().zip(&held_out.before).zip(&held_out.after) {
        let sum = &mut sums[point.row];
        if let Some(before) = before {
            sum[0] += before * before;
            sum[1] += 1.0;
        }
        if let Some(after) = after {
            sum[2] += after * after;
            sum[3] += 1.0;
        }
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x9e37_79b9);
    let mut gains: Vec<f64> = (0..RESAMPLES)
        .map(|_| {
            let mut total = [0.0; 4];
            for _ in 0..rows {
                let drawn = sums[rng.random_range(0..rows)];
                total.iter_mut().zip(drawn).for_each(|(t, d)| *t += d);
            }
            let [before, count_before, after, count_after] = total;
            f64::sqrt(before / count_before.max(1.0)) - f64::sqrt(after / count_after.max(1.0))
        })
        .collect();
    gains.sort_by(f64::total_cmp);
    let at = |share: f64| gains[((share * RESAMPLES as f64) as usize).min(RESAMPLES - 1)];
    [at(0.025), at(0.975)]
}
