//! Where a free vibration does not go on as it did: a hit that comes before the last decay is over,
//! which raises the responses too little to be seen in their level, or samples that were lost. What
//! a vibration does next follows from what it did before, beats included; what such a moment brings
//! does not (linear prediction: Makhoul, Proc. IEEE 63(4), 1975).

use nalgebra::{DMatrix, DVector};

use super::impacts::{Decay, compared, guard, sliding_maximum};
use super::quality::rounding_step;
use crate::statistics::deviation_about_zero;

/// Samples that the next one is predicted from.
const ORDER: usize = 32;

/// Moments at which responses depart from what their past predicts.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Departures {
    /// They are louder from there on.
    pub(super) hits: Vec<usize>,
    /// They are no louder.
    pub(super) breaks: Vec<usize>,
}

impl Departures {
    /// Those of responses within a stretch without a force.
    pub(super) fn of(responses: &[&[f64]], stretch: Decay, rate_hz: f64) -> Self {
        /// A loose joint departs often.
        const MOST_BREAKS: usize = 2;
        let own = responses.iter().map(|y| &y[stretch.from..stretch.to]);
        let found: Vec<(usize, bool)> = own.flat_map(|y| departures(y, rate_hz)).collect();
        let moments = |is_hit: bool| {
            let own = found.iter().filter(|(_, is)| *is == is_hit);
            let mut all: Vec<usize> = own.map(|(at, _)| stretch.from + at).collect();
            all.sort_unstable();
            // Responses show one moment a few samples apart.
            all.dedup_by(|next, last| *next - *last < compared(rate_hz));
            all
        };
        let (hits, mut breaks) = (moments(true), moments(false));
        breaks.retain(|at| hits.iter().all(|hit| hit.abs_diff(*at) >= compared(rate_hz)));
        if breaks.len() > MOST_BREAKS {
            breaks.clear();
        }
        Self { hits, breaks }
    }

    /// The decays that a stretch consists of.
    pub(super) fn decays(&self, stretch: Decay, rate_hz: f64) -> Vec<Decay> {
        let mut moments = [&self.hits[..], &self.breaks[..]].concat();
        moments.sort_unstable();
        let (mut all, mut from) = (Vec::new(), stretch.from);
        for moment in moments {
            all.push(Decay { from, to: moment });
            from = moment + guard(rate_hz);
        }
        all.push(Decay { from, to: stretch.to });
        all.retain(|decay| decay.from < decay.to);
        all
    }
}

/// Where one response departs from what its past predicts, and whether it is louder from there on.
fn departures(samples: &[f64], rate_hz: f64) -> Vec<(usize, bool)> {
    /// Standard deviations of the samples before.
    const OUT_OF_NOISE: f64 = 12.0;
    /// Of the loudest sample that follows,
    const SHARE: f64 = 0.03;
    /// and of the loudest of all: what happens where next to nothing moves does no harm.
    const SHARE_OF_ALL: f64 = 0.01;
    /// A hit raises the response by this factor.
    const RISE: f64 = 1.2;
    let window = compared(rate_hz);
    let Some(errors) = errors(samples) else { return Vec::new() };
    let first = 3 * ORDER;
    let sizes: Vec<f64> = samples.iter().map(|y| y.abs()).collect();
    let ahead = sliding_maximum(&sizes, window);
    let loudest = sizes.iter().copied().fold(0.0, f64::max);
    // Below one step of the converter nothing is predicted too well.
    let step = rounding_step(samples).unwrap_or(0.0);
    let mut found = Vec::new();
    let stands_out =
        |error: f64, others: &[f64]| error > OUT_OF_NOISE * deviation_about_zero(others).max(step);
    // What is too early to be predicted from its past is predicted from what follows.
    let backwards: Vec<f64> = samples.iter().rev().copied().collect();
    let back = self::errors(&backwards).map(|errors| errors.into_iter().rev().collect::<Vec<_>>());
    let early = |back: &Vec<f64>| {
        (0..first.min(samples.len() - ORDER)).rev().find(|&at| {
            let error = back[at].abs();
            let behind = at + 1..(at + 1 + window).min(samples.len() - ORDER);
            error > (SHARE * ahead[at + 1]).max(SHARE_OF_ALL * loudest)
                && stands_out(error, &back[behind])
        })
    };
    if let Some(last) = back.as_ref().and_then(early) {
        let past = sizes[..=last].iter().copied().fold(0.0, f64::max);
        found.push((last + 1, ahead[last + 1] > RISE * past));
    }
    let mut at = first;
    while at + ORDER < samples.len() {
        let before = at.saturating_sub(window).max(ORDER)..at;
        let error = errors[at].abs();
        if error > (SHARE * ahead[at]).max(SHARE_OF_ALL * loudest)
            && stands_out(error, &errors[before.clone()])
        {
            let past = sizes[before].iter().copied().fold(0.0, f64::max);
            found.push((at, ahead[at] > RISE * past));
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
