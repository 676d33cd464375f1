//! How noisy each line of a spectrum is, from the residual of a fit.

use crate::statistics::upper_median;

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
    let lines = powers.len();
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
    let power = sums(&mut powers.iter().copied());
    let free = sums(&mut taken.iter().map(|taken| 1.0 - taken));
    (0..lines)
        .map(|line| {
            let (from, to) = (line.saturating_sub(reach), (line + reach + 1).min(lines));
            let free = (free[to] - free[from]).max(0.5);
            ((power[to] - power[from]) / free).max(ROUNDING * strongest)
        })
        .collect()
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
