//! What no cause explains, as a function of the pose: a Gaussian process of the residual of each
//! mode, if that surely predicts states left out.

use rayon::prelude::*;

use super::data::Data;
use super::fit::Fit;
use super::gain::{HeldOut, folds_of, gain_interval};
use super::gaussian_process::{Axis, Process, Value};
use super::likelihood::MIN_NOISE;
use super::outcome::{Gain, WithoutCause};
use super::statistics::{relative_error, rms};
use crate::units::percent_from_ratio;

/// Of many tests, more than a choice of causes has: of a fifth fewer poses a process knows much
/// less.
const FOLDS: usize = 8;

/// The correction of a model whose error no cause explains; `None` where it does not surely gain at
/// states left out.
pub(super) fn without_cause(
    data: &Data,
    baseline: &Fit<'_>,
    joints: &[(String, bool)],
    seed: u64,
) -> Option<WithoutCause> {
    let residuals = &baseline.evaluation.left.residuals;
    let axes = axes(data, joints);
    let (fold_of, folds) = folds_of(data, FOLDS, seed);
    let fitted = |keep: &(dyn Fn(usize) -> bool + Sync)| -> Vec<Option<Process>> {
        let of_mode = |mode| Process::fit(&values(data, residuals, mode, keep), &axes, MIN_NOISE);
        (0..data.columns).into_par_iter().map(of_mode).collect()
    };
    let of_folds: Vec<Vec<Option<Process>>> =
        (0..folds).map(|fold| fitted(&|row| fold_of[row] != fold)).collect();
    let after = data.points.iter().zip(residuals).map(|(point, residual)| {
        let process = of_folds[fold_of[point.row]][point.column].as_ref();
        let predicted = process.map_or(0.0, |own| own.at(&data.rows[point.row].q).mean);
        Some(relative_error((*residual)? - predicted))
    });
    let held_out = HeldOut { after: after.collect(), ..HeldOut::unchanged(&baseline.evaluation) };
    let ci95 = gain_interval(data, &held_out, seed).map(percent_from_ratio);
    if ci95[0] <= 0.0 {
        return None;
    }
    let [before, after] =
        [&held_out.before, &held_out.after].map(|errors| percent_from_ratio(rms(errors.iter())));
    Some(WithoutCause {
        heldout_rms_percent: after,
        gain: Gain { percent_points: before - after, ci95 },
        processes: fitted(&|_| true),
    })
}

/// The joints that frequencies depend on.
fn axes(data: &Data, joints: &[(String, bool)]) -> Vec<Axis> {
    let is_inert = |joint: usize| data.inert.get(joint).copied().unwrap_or(false);
    let axis = |(joint, (_, slides)): (usize, &(String, bool))| {
        let positions = || data.rows.iter().filter_map(move |row| row.q.get(joint).copied());
        let range = positions().fold(f64::NEG_INFINITY, f64::max)
            - positions().fold(f64::INFINITY, f64::min);
        let is_seen = range > 0.0;
        // A joint that never slides has no range of its own: a millimetre off is elsewhere.
        let slides_over = slides.then_some(if is_seen { range } else { 1e-3 });
        Axis { joint, slides_over, is_seen }
    };
    let used = joints.iter().enumerate().filter(|(joint, _)| !is_inert(*joint));
    used.map(axis).collect()
}

/// Residuals of a mode in the rows that `keep` holds; of a large table every so many.
fn values(
    data: &Data,
    residuals: &[Option<f64>],
    mode: usize,
    keep: &dyn Fn(usize) -> bool,
) -> Vec<Value> {
    /// The cost grows with the cube.
    const MOST: usize = 200;
    let own = data.points.iter().zip(residuals);
    let own = own.filter(|(point, _)| point.column == mode && keep(point.row));
    let values: Vec<Value> = own
        .filter_map(|(point, residual)| {
            let q = data.rows[point.row].q.clone();
            Some(Value { q, value: (*residual)?, unit: point.unit })
        })
        .collect();
    let every = values.len().div_ceil(MOST).max(1);
    values.into_iter().step_by(every).collect()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::fit::tests::{arm, data};
    use super::super::hypothesis::Hypothesis;
    use super::super::problem::Problem;
    use super::*;

    /// A sum of uniform deviates.
    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random_range(-0.5..0.5)).sum()
    }

    /// ln of what no cause of the vocabulary does to a mode: a wave, a kink, an offset.
    fn effect(mode: usize, q: &[f64]) -> f64 {
        let share = 1.0 - 0.3 * mode as f64;
        0.02 + share * (0.04 * (2.0 * q[1] + 0.5).sin() + 0.02 * q[2].abs())
    }

    /// The correction of a table with that effect, or with noise alone, and the residuals.
    fn corrected(poses: usize, size: f64, noise: f64, seed: u64) -> Option<WithoutCause> {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let description = arm();
        let mut data = data(poses);
        for row in &mut data.rows {
            row.q = (0..3).map(|_| rng.random_range(-2.0..2.0)).collect();
        }
        let plain = Problem { description: &description, data: &data };
        let plain = plain.compare(&Hypothesis::default()).unwrap();
        for (point, residual) in data.points.iter_mut().zip(plain.left.residuals) {
            point.ln_f += size * effect(point.column, &data.rows[point.row].q)
                + noise * normal(rng)
                - residual.unwrap();
        }
        let baseline = Problem { description: &description, data: &data };
        let baseline = baseline.optimise(Hypothesis::default()).unwrap();
        let joints: Vec<_> = ["j1", "j2", "j3"].map(|name| (name.to_owned(), false)).into();
        without_cause(&data, &baseline, &joints, seed)
    }

    /// Poses that nothing was fitted to: the intervals hold what was hidden, and the error there is
    /// that of the states left out without its noise.
    #[test]
    fn intervals_hold_what_was_hidden_at_fresh_poses() {
        let (mut held, mut all) = (0, 0);
        let noise = 0.005;
        for seed in 0..20 {
            let found = corrected(30, 1.0, noise, seed).expect("a wave of 4 % in noise of 0.5 %");
            let rng = &mut ChaCha8Rng::seed_from_u64(100 + seed);
            let (mut square, mut count) = (0.0, 0.0);
            for _ in 0..20 {
                let q: Vec<f64> = (0..3).map(|_| rng.random_range(-2.0..2.0)).collect();
                for mode in 0..3 {
                    let own = found.corrected(mode, &q, 40.0).unwrap();
                    let truth = 40.0 * effect(mode, &q).exp();
                    held += usize::from((own.ci95_hz[0]..own.ci95_hz[1]).contains(&truth));
                    all += 1;
                    square += (own.hz / truth - 1.0).powi(2);
                    count += 1.0;
                }
            }
            let (fresh, said) = (f64::sqrt(square / count), 0.01 * found.heldout_rms_percent);
            let expected = fresh.hypot(noise);
            assert!((0.6..1.6).contains(&(said / expected)), "{seed}: {said} {fresh}");
            assert!(found.gain.ci95[0] > 0.0 && fresh < 0.02, "{seed}: {fresh}");
        }
        let share = f64::from(held as u32) / f64::from(all as u32);
        println!("intervals hold {share:.3} of {all}");
        assert!((0.90..0.99).contains(&share), "{share}");
    }

    #[test]
    fn noise_has_no_correction() {
        let found = (0..20).filter(|&seed| corrected(18, 0.0, 0.01, seed).is_some()).count();
        assert!(found <= 1, "{found} of 20");
    }
}
