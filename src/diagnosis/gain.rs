//! What the causes gain at poses that they were not fitted to: cross-validation in which the whole
//! choice is repeated in each fold.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::choose::{Means, best_of};
use super::data::Data;
use super::hypothesis::Hypothesis;
use super::problem::{Evaluation, Problem};
use super::statistics::relative_error;

/// Folds of the cross-validation of a table of many tests: five or ten are a good compromise of
/// bias and scatter (Hastie, Tibshirani & Friedman, The Elements of Statistical Learning, 2nd ed.,
/// 7.10.1).
const FOLDS: usize = 5;

/// And of so few tests: of a fifth fewer a model learns much less.
const FEW: usize = 24;
const FOLDS_OF_FEW: usize = 8;

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
    pub(super) fn unchanged(baseline: &Evaluation) -> Self {
        let errors: Vec<_> =
            baseline.left.residuals.iter().map(|r| r.map(relative_error)).collect();
        Self { before: errors.clone(), after: errors }
    }
}

/// Errors of the model and of the model with the causes that each fold chooses, at the poses that
/// the fold leaves out. `done` is called once a fold, with their number.
pub(super) fn held_out(
    problem: &Problem<'_>,
    means: Means<'_, '_>,
    seed: u64,
    done: &(dyn Fn(usize) + Sync),
) -> HeldOut {
    let Problem { description, data } = *problem;
    let (fold_of, folds) = folds_of(data, FOLDS, seed);
    let errors_of = |data: &Data, hypothesis: &Hypothesis<'_>| {
        errors(&Problem { description, data }, hypothesis)
    };
    let chosen: Vec<Vec<Option<f64>>> = (0..folds)
        .into_par_iter()
        .map(|fold| {
            let train = data.only(|row| fold_of[row] != fold);
            let test = data.only(|row| fold_of[row] == fold);
            let means = Means { known: &means.known.clone(), ..means };
            let chosen = best_of(&Problem { description, data: &train }, means);
            let errors = errors_of(&test, &chosen.unwrap_or_default());
            done(folds);
            errors
        })
        .collect();
    let before = errors_of(data, &Hypothesis::default());
    let after = gathered(data, &fold_of, &chosen, &before);
    HeldOut { before, after }
}

/// By row the fold that leaves it out, and how many folds there are, `of_many` where there are many
/// tests: a state is left out as a whole, and where the noise drifts, what was measured in
/// succession is.
pub(super) fn folds_of(data: &Data, of_many: usize, seed: u64) -> (Vec<usize>, usize) {
    let tests = data.tests();
    let count = data.test_count();
    let folds = if count > FEW { of_many } else { FOLDS_OF_FEW.min(count) };
    let mut order: Vec<usize> = (0..count).collect();
    let mut fold_of_test = vec![0; count];
    if data.shape.drift > 0.0 {
        // Tests are counted as they come.
        order.iter().for_each(|&test| fold_of_test[test] = test * folds / count.max(1));
    } else {
        order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
        order.iter().enumerate().for_each(|(i, &test)| fold_of_test[test] = i % folds);
    }
    (tests.iter().map(|&test| fold_of_test[test]).collect(), folds)
}

/// Relative errors of a hypothesis, one a point.
fn errors(problem: &Problem<'_>, hypothesis: &Hypothesis<'_>) -> Vec<Option<f64>> {
    problem.compare(hypothesis).map_or_else(
        || vec![None; problem.data.points.len()],
        |evaluation| evaluation.left.residuals.iter().map(|r| r.map(relative_error)).collect(),
    )
}

/// The errors of each fold in the order of the points; `before` where a model has no such mode:
/// nothing is gained there.
fn gathered(
    data: &Data,
    fold_of: &[usize],
    of_folds: &[Vec<Option<f64>>],
    before: &[Option<f64>],
) -> Vec<Option<f64>> {
    let mut next = vec![0; of_folds.len()];
    let points = data.points.iter().zip(before);
    points
        .map(|(point, before)| {
            let fold = fold_of[point.row];
            next[fold] += 1;
            of_folds[fold][next[fold] - 1].or(*before)
        })
        .collect()
}

/// Which causes of a hypothesis surely gain something at states left out, beside the others: each
/// is taken out in turn, and the rest is fitted again.
pub(super) fn surely_gaining(
    problem: &Problem<'_>,
    hypothesis: &Hypothesis<'_>,
    seed: u64,
) -> Vec<bool> {
    let Problem { description, data } = *problem;
    let (fold_of, folds) = folds_of(data, FOLDS, seed);
    let before = errors(problem, &Hypothesis::default());
    let left_out = |hypothesis: &Hypothesis<'_>| {
        let of_folds: Vec<Vec<Option<f64>>> = (0..folds)
            .into_par_iter()
            .map(|fold| {
                let train = data.only(|row| fold_of[row] != fold);
                let test = data.only(|row| fold_of[row] == fold);
                let fit = Problem { description, data: &train }.optimise(hypothesis.clone());
                let fitted = fit.map_or_else(Hypothesis::default, |fit| fit.hypothesis);
                errors(&Problem { description, data: &test }, &fitted)
            })
            .collect();
        gathered(data, &fold_of, &of_folds, &before)
    };
    let after = left_out(hypothesis);
    (0..hypothesis.effects.len())
        .map(|i| {
            let mut without = hypothesis.clone();
            without.effects.remove(i);
            let held_out = HeldOut { before: left_out(&without), after: after.clone() };
            gain_interval(data, &held_out, seed)[0] > 0.0
        })
        .collect()
}

/// 95 % interval of rms before − rms after, as shares, over resampled tests: rows that repeat one
/// test are drawn together, as the folds leave them out together.
pub(super) fn gain_interval(data: &Data, held_out: &HeldOut, seed: u64) -> [f64; 2] {
    let test_of_row = data.tests();
    let tests = data.test_count();
    let mut sums = vec![[0.0; 4]; tests];
    for ((point, before), after) in data.points.iter().zip(&held_out.before).zip(&held_out.after) {
        let sum = &mut sums[test_of_row[point.row]];
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
            for _ in 0..tests {
                let drawn = sums[rng.random_range(0..tests)];
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

#[cfg(test)]
mod tests {
    use super::super::data::Point;
    use super::super::fit::tests::data;
    use super::*;

    /// A table whose rows all stand there four times knows no more poses than the table itself.
    #[test]
    fn repeated_rows_do_not_narrow_the_interval_of_the_gain() {
        let once = data(9);
        let errors = |scale: f64| -> Vec<Option<f64>> {
            (0..once.points.len()).map(|i| Some(scale * (1.7 * i as f64).sin())).collect()
        };
        let held_out = HeldOut { before: errors(0.3), after: errors(0.1) };
        let alone = gain_interval(&once, &held_out, 1);
        let mut copies = once.clone();
        for copy in 1..4 {
            copies.rows.extend(once.rows.iter().cloned());
            let shift = copy * once.rows.len();
            copies.points.extend(once.points.iter().map(|p| Point { row: p.row + shift, ..*p }));
        }
        let HeldOut { before, after } = held_out;
        let repeated = HeldOut { before: before.repeat(4), after: after.repeat(4) };
        let together = gain_interval(&copies, &repeated, 1);
        for (alone, together) in alone.iter().zip(together) {
            assert!((alone - together).abs() < 1e-12, "{alone} {together}");
        }
    }
}
