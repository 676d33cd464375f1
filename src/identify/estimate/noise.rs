//! How noisy each line of a spectrum is, from the residual of a fit.

use crate::statistics::upper_median;

/// Variance of the complex value of every line, by block and response.
pub(super) type Noise = Vec<Vec<Vec<f64>>>;

/// Noise below this fraction of the strongest line's power is rounding.
const ROUNDING: f64 = 1e-24;

/// Lines to either side that a level of noise is taken from.
fn reach(lines: usize) -> usize {
    30.max(lines / 14)
}

/// Variance of the complex value of each line by local medians of its power: peaks that stand out
/// count as signal. The power of circular Gaussian noise is exponentially distributed, its median
/// ln 2 of its mean.
pub(super) fn floor(powers: &[f64], strongest: f64) -> Vec<f64> {
    let lines = powers.len();
    let reach = reach(lines);
    let median = |at: usize| {
        let near = &powers[at.saturating_sub(reach)..(at + reach + 1).min(lines)];
        upper_median(near).unwrap_or(0.0) / std::f64::consts::LN_2
    };
    let step = (reach / 2).max(1);
    let knots: Vec<f64> = (0..=lines / step).map(|i| median(i * step)).collect();
    let at = |line: usize| {
        let (left, part) = (line / step, (line % step) as f64 / step as f64);
        let right = (left + 1).min(knots.len() - 1);
        knots[left] + part * (knots[right] - knots[left])
    };
    (0..lines).map(|line| at(line).max(ROUNDING * strongest)).collect()
}

/// Variance of the complex value of each line by local means; `taken` is the fraction of each
/// line's noise that the fit has absorbed.
pub(super) fn smooth(powers: &[f64], taken: &[f64], strongest: f64) -> Vec<f64> {
    let free = taken.iter().map(|taken| 1.0 - taken);
    local_means(powers.iter().copied(), free, 0.5)
        .into_iter()
        .map(|level| level.max(ROUNDING * strongest))
        .collect()
}

/// The same of the noise beside a `known` one: lines count as far as they tell of it, at the level
/// that it had before.
pub(super) fn beside(
    powers: &[f64],
    taken: &[f64],
    known: &[f64],
    before: &[f64],
    strongest: f64,
) -> Vec<f64> {
    /// Most that the level falls or rises by in a step, so that it stays above zero and finite.
    const MOST: f64 = 10.0;
    let weight: Vec<f64> = known
        .iter()
        .zip(before)
        .map(|(known, before)| (before / (before + known).max(f64::MIN_POSITIVE)).powi(2))
        .collect();
    let lines = || powers.iter().zip(taken).zip(known).zip(&weight);
    let own =
        lines().map(|(((power, taken), known), weight)| weight * (power - (1.0 - taken) * known));
    let free = lines().map(|(((_, taken), _), weight)| weight * (1.0 - taken));
    local_means(own, free, f64::MIN_POSITIVE)
        .iter()
        .zip(before)
        .map(|(level, before)| {
            level.max(before / MOST).min(before * MOST).max(ROUNDING * strongest)
        })
        .collect()
}

/// Sums of values over sums of weights, which are `least` or more, about each line.
fn local_means(
    values: impl ExactSizeIterator<Item = f64>,
    weights: impl Iterator<Item = f64>,
    least: f64,
) -> Vec<f64> {
    let lines = values.len();
    let reach = reach(lines);
    let sums = |values: &mut dyn Iterator<Item = f64>| {
        let mut sums = vec![0.0];
        let mut sum = 0.0;
        for value in values {
            sum += value;
            sums.push(sum);
        }
        sums
    };
    let (mut values, mut weights) = (values, weights);
    let (values, weights) = (sums(&mut values), sums(&mut weights));
    (0..lines)
        .map(|line| {
            let (from, to) = (line.saturating_sub(reach), (line + reach + 1).min(lines));
            (values[to] - values[from]) / (weights[to] - weights[from]).max(least)
        })
        .collect()
}

/// How many neighbouring lines share one error: the integrated autocorrelation of residuals of unit
/// variance, real parts of all lines before imaginary ones, up to five times itself (Sokal, Monte
/// Carlo methods in statistical mechanics, 1989, §3). White noise has 1, a Hann window makes 8/3 of
/// it, and what a model does not describe bends over many lines.
pub(super) fn shared_lines(residuals: impl Iterator<Item = Vec<f64>>) -> f64 {
    /// Lines that stand out are signal: they count as so many deviations.
    const MOST: f64 = 2.0;
    const WINDOW: f64 = 5.0;
    let clipped = |residual: &[f64]| -> Vec<[f64; 2]> {
        let (re, im) = residual.split_at(residual.len() / 2);
        let value = |(re, im): (&f64, &f64)| {
            let shrink = MOST / re.hypot(*im).max(MOST);
            [re * shrink, im * shrink]
        };
        re.iter().zip(im).map(value).collect()
    };
    let all: Vec<Vec<[f64; 2]>> = residuals.map(|residual| clipped(&residual)).collect();
    let product = |lag: usize| -> f64 {
        let own = |e: &Vec<[f64; 2]>| -> f64 {
            e.iter().zip(e.iter().skip(lag)).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum()
        };
        all.iter().map(own).sum()
    };
    let power = product(0);
    let lines = all.iter().map(Vec::len).max().unwrap_or(0);
    let mut sum = 1.0;
    for lag in 1..lines {
        if power <= 0.0 || lag as f64 > WINDOW * sum {
            break;
        }
        sum = (sum + 2.0 * product(lag) / power).max(1.0);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_is_no_noise_for_the_median_and_what_was_taken_counts_for_the_mean() {
        let mut powers = vec![std::f64::consts::LN_2; 500];
        powers[250] = 1e6;
        assert!(floor(&powers, 1e6).iter().all(|level| (level - 1.0).abs() < 1e-12));
        assert!(floor(&[], 1.0).is_empty() && smooth(&[], &[], 1.0).is_empty());
        let taken = vec![0.25; 40];
        assert!(smooth(&[3.0; 40], &taken, 3.0).iter().all(|level| (level - 4.0).abs() < 1e-12));
        assert!(smooth(&[0.0; 40], &taken, 1.0).iter().all(|level| *level > 0.0));
    }
}
