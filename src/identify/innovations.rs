//! Hits that come before the last decay is over: they raise the responses too little to be seen in
//! their level. What a vibration does next follows from what it did before, beats included; a hit
//! does not (linear prediction: Makhoul, Proc. IEEE 63(4), 1975).

use nalgebra::{DMatrix, DVector};

use super::impacts::{Decay, compared, guard, sliding_maximum};
use crate::statistics::deviation_about_zero;

/// Samples that the next one is predicted from.
const ORDER: usize = 32;

/// The decays that a stretch consists of: it is divided where a hit begins another.
pub(super) fn hits(responses: &[&[f64]], decay: Decay, rate_hz: f64) -> Vec<Decay> {
    let own: Vec<&[f64]> = responses.iter().map(|r| &r[decay.from..decay.to]).collect();
    let mut onsets: Vec<usize> = own.iter().flat_map(|y| onsets(y, rate_hz)).collect();
    onsets.sort_unstable();
    let (guard, mut all, mut from) = (guard(rate_hz), Vec::new(), decay.from);
    // Responses show one hit a few samples apart.
    onsets.dedup_by(|next, last| *next - *last < compared(rate_hz));
    for onset in onsets {
        all.push(Decay { from, to: decay.from + onset });
        from = decay.from + onset + guard;
    }
    all.push(Decay { from, to: decay.to });
    all.retain(|decay| decay.from < decay.to);
    all
}

/// Where one response departs from what its past predicts, and is louder from there on.
fn onsets(samples: &[f64], rate_hz: f64) -> Vec<usize> {
    /// Standard deviations of the samples before.
    const OUT_OF_NOISE: f64 = 12.0;
    /// Of the loudest sample that follows.
    const SHARE: f64 = 0.03;
    /// Beside that, the response must rise by this factor: a loose joint departs, too.
    const RISE: f64 = 1.2;
    let window = compared(rate_hz);
    let Some(errors) = errors(samples) else { return Vec::new() };
    let sizes: Vec<f64> = samples.iter().map(|y| y.abs()).collect();
    let ahead = sliding_maximum(&sizes, window);
    let mut found = Vec::new();
    let mut at = 3 * ORDER;
    while at + ORDER < samples.len() {
        let before = at.saturating_sub(window).max(ORDER)..at;
        let loudest = || sizes[before.clone()].iter().copied().fold(0.0, f64::max);
        if errors[at].abs() > SHARE * ahead[at]
            && ahead[at] > RISE * loudest()
            && errors[at].abs() > OUT_OF_NOISE * deviation_about_zero(&errors[before.clone()])
        {
            found.push(at);
            at += window;
        } else {
            at += 1;
        }
    }
    found
}

/// What is left of each sample by least squares on those before it; `None` of too few.
fn errors(samples: &[f64]) -> Option<Vec<f64>> {
    if samples.len() < 6 * ORDER {
        return None;
    }
    let rows = samples.len() - ORDER;
    // Σ y(t − i) y(t − j) over t by recursion along the diagonals.
    let product = |i: usize, j: usize| -> f64 {
        (0..rows).map(|t| samples[t + ORDER - i] * samples[t + ORDER - j]).sum()
    };
    let mut sums = DMatrix::<f64>::zeros(ORDER + 1, ORDER + 1);
    for j in 0..=ORDER {
        sums[(0, j)] = product(0, j);
        sums[(j, 0)] = sums[(0, j)];
    }
    for i in 1..=ORDER {
        for j in i..=ORDER {
            let (first, last) = (ORDER - i, samples.len() - i);
            let (other_first, other_last) = (ORDER - j, samples.len() - j);
            sums[(i, j)] = sums[(i - 1, j - 1)] + samples[first] * samples[other_first]
                - samples[last] * samples[other_last];
            sums[(j, i)] = sums[(i, j)];
        }
    }
    let mut normal = sums.view((1, 1), (ORDER, ORDER)).into_owned();
    let ridge = 1e-12 * normal.trace();
    (0..ORDER).for_each(|i| normal[(i, i)] += ridge);
    let right = DVector::from_fn(ORDER, |i, _| sums[(0, i + 1)]);
    let factors = normal.cholesky()?.solve(&right);
    let mut errors = vec![0.0; samples.len()];
    for t in ORDER..samples.len() {
        let predicted: f64 = (0..ORDER).map(|i| factors[i] * samples[t - 1 - i]).sum();
        errors[t] = samples[t] - predicted;
    }
    Some(errors)
}
