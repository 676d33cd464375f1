//! Samples at uneven times → values on a grid, by the linear predictor of least error for signals
//! that fill a band evenly (simple kriging with the covariance of band-limited noise).

use nalgebra::{DMatrix, DVector};

/// Samples about a time that its value is found from.
const ABOUT: usize = 24;

/// Noise that the predictor reckons with, over the power of the signal.
const NUGGET: f64 = 1e-7;

/// Frequencies at which the error is computed.
const TESTED: usize = 12;

/// Frequencies, as cycles a step of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// The band that signals are taken to fill.
    pub filled: f64,
    /// Up to here errors are told.
    pub told: f64,
}

/// A value on the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resampled {
    /// Along both axes.
    pub values: [f64; 2],
    /// Largest error of a sinusoid in the band, over its amplitude.
    pub error: f64,
    /// Whether the samples on either side are neighbours.
    pub is_between: bool,
}

/// A sample: its number, its time in steps of the grid, its values.
pub type Sample = (usize, f64, [f64; 2]);

/// Values at the times `grid`, in steps; times of samples rise. `None` outside of all samples.
pub fn resample(samples: &[Sample], grid: &[f64], band: Band) -> Vec<Option<Resampled>> {
    grid.iter().map(|&time| at(samples, time, band)).collect()
}

fn at(samples: &[Sample], time: f64, band: Band) -> Option<Resampled> {
    /// A sample this near, in steps, is at the time.
    const SAME: f64 = 1e-6;
    let after = samples.partition_point(|sample| sample.1 < time - SAME);
    let first = after.saturating_sub(ABOUT / 2).min(samples.len().saturating_sub(ABOUT));
    let near = &samples[first..samples.len().min(first + ABOUT)];
    let next = samples.get(after)?;
    if next.1 - time <= SAME {
        return Some(Resampled { values: next.2, error: 0.0, is_between: true });
    }
    let before = samples.get(after.checked_sub(1)?)?;
    let covariance = |lag: f64| {
        let x = std::f64::consts::TAU * band.filled * lag;
        if x.abs() < 1e-9 { 1.0 } else { x.sin() / x }
    };
    let count = near.len();
    let matrix = DMatrix::from_fn(count, count, |i, j| {
        covariance(near[i].1 - near[j].1) + if i == j { NUGGET } else { 0.0 }
    });
    let to = DVector::from_fn(count, |i, _| covariance(near[i].1 - time));
    let weights = matrix.cholesky()?.solve(&to);
    let values = [0, 1].map(|axis| {
        let mean = near.iter().map(|sample| sample.2[axis]).sum::<f64>() / count as f64;
        mean + near.iter().zip(&weights).map(|(s, w)| w * (s.2[axis] - mean)).sum::<f64>()
    });
    let error = (1..=TESTED)
        .map(|k| {
            let omega = std::f64::consts::TAU * band.told * k as f64 / TESTED as f64;
            let (mut re, mut im) = (-1.0, 0.0);
            for (sample, weight) in near.iter().zip(&weights) {
                let (sin, cos) = (omega * (sample.1 - time)).sin_cos();
                re += weight * cos;
                im += weight * sin;
            }
            f64::hypot(re, im)
        })
        .fold(0.0, f64::max);
    Some(Resampled { values, error, is_between: next.0 == before.0 + 1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAND: Band = Band { filled: 0.44, told: 0.36 };

    /// Two sinusoids at jittered times: the error stays below what is told, and that is small.
    #[test]
    fn what_is_told_of_the_error_holds() {
        let of = |t: f64| [(std::f64::consts::TAU * 0.31 * t + 0.4).sin(), 5.0 + (0.9 * t).cos()];
        for (delay, jitter) in [(0.0, 0.0), (0.37, 0.0), (0.5, 0.02), (0.2, 0.2)] {
            let time = |k: usize| k as f64 + delay + jitter * (k as f64 * 1.7).sin();
            let samples: Vec<Sample> = (0..200).map(|k| (k, time(k), of(time(k)))).collect();
            let grid: Vec<f64> = (0..200).map(|k| k as f64).collect();
            let found = resample(&samples, &grid, BAND);
            let mut told: f64 = 0.0;
            for (t, found) in grid.iter().zip(&found).skip(14).take(170) {
                let found = found.unwrap();
                told = told.max(found.error);
                let expected = of(*t);
                for (value, expected) in found.values.iter().zip(expected) {
                    let off = (value - expected).abs();
                    assert!(off <= found.error + 2e-3, "{delay} {jitter} {t}: {off} {found:?}");
                }
            }
            println!("{delay} {jitter}: {told}, at the start {:?}", found[1]);
            assert!(told < 0.01, "{delay} {jitter}: {told}");
        }
    }

    #[test]
    fn nothing_is_told_outside_and_gaps_are_known() {
        let samples: Vec<Sample> =
            [0, 1, 2, 5, 6].map(|k| (k, k as f64 + 0.5, [1.0, 2.0])).to_vec();
        let found = resample(&samples, &[0.0, 1.0, 3.5, 6.5, 7.0], BAND);
        assert!(found[0].is_none() && found[4].is_none());
        assert!(found[1].unwrap().is_between && !found[2].unwrap().is_between);
        assert_eq!(found[3].unwrap().values, [1.0, 2.0]);
    }
}
