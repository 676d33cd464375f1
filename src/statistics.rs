//! Small statistics that several rooms share. Distributions are statrs's.

use statrs::statistics::{Data, OrderStatistics};

/// Arithmetic mean; NaN of nothing.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Median, the mean of the two in the middle of an even number; `None` of nothing.
pub fn median(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| Data::new(values).median())
}

/// Median that is one of the values: the upper of the two in the middle of an even number.
pub fn upper_median(values: &[f64]) -> Option<f64> {
    let mut values = values.to_vec();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Root mean square; 0 of nothing.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(s, n), v| (s + v * v, n + 1.0));
    if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
}

/// Spearman's rank correlation of values with their order, −1 where they fall all the time.
pub fn rank_with_order(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let rank = |v: &f64| values.iter().filter(|other| *other < v).count() as f64;
    let square: f64 = values.iter().enumerate().map(|(i, v)| (rank(v) - i as f64).powi(2)).sum();
    1.0 - 6.0 * square / (n * (n * n - 1.0))
}

/// Wilcoxon's signed ranks of values over their deviation where the values lie about zero, with the
/// normal approximation, ties in any order; 0 of fewer than eight.
pub fn signed_rank(values: &[f64]) -> f64 {
    let mut values: Vec<f64> = values.iter().copied().filter(|v| *v != 0.0).collect();
    values.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let n = values.len() as f64;
    if n < 8.0 {
        return 0.0;
    }
    let sum: f64 = values.iter().zip(1..).map(|(v, rank)| v.signum() * f64::from(rank)).sum();
    sum / (n * (n + 1.0) * (2.0 * n + 1.0) / 6.0).sqrt()
}

/// Pearson's correlation of pairs; `None` where one of both does not vary.
pub fn correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    let n = pairs.len() as f64;
    let [a, b] = pairs.iter().fold([0.0, 0.0], |[a, b], pair| [a + pair.0 / n, b + pair.1 / n]);
    let sum = |of: fn(f64, f64) -> f64| -> f64 {
        pairs.iter().map(|pair| of(pair.0 - a, pair.1 - b)).sum()
    };
    let size = (sum(|a, _| a * a) * sum(|_, b| b * b)).sqrt();
    (size > 0.0).then(|| sum(|a, b| a * b) / size)
}

/// Robust standard deviation of Gaussian noise about zero: from the median of its size, so that
/// what rises above the noise does not count. 0 of nothing.
pub fn deviation_about_zero(noise: &[f64]) -> f64 {
    /// Standard deviation over median absolute deviation of a Gaussian distribution.
    const DEVIATION_PER_MEDIAN: f64 = 1.4826;
    let sizes: Vec<f64> = noise.iter().map(|v| v.abs()).collect();
    DEVIATION_PER_MEDIAN * upper_median(&sizes).unwrap_or(0.0)
}

/// What a χ² variable of `freedom` degrees exceeds with a probability of at most e^(−x): the bound
/// of Laurent & Massart, Ann. Statist. 28, 2000, Lemma 1.
pub fn chi_squared_bound(freedom: f64, x: f64) -> f64 {
    freedom + 2.0 * (freedom * x).sqrt() + 2.0 * x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of ten with ranks 1 and 3 above zero: W = 4 − 51, deviation √385 (Wilcoxon, Biometrics
    /// Bulletin 1, 1945).
    #[test]
    fn signed_ranks_tell_a_side() {
        let values = [0.1, -0.2, 0.3, -0.4, -0.5, -0.6, -0.7, -0.8, -0.9, -1.0];
        assert!((signed_rank(&values) + 47.0 / 385_f64.sqrt()).abs() < 1e-12);
        assert_eq!(signed_rank(&[1.0; 7]), 0.0);
    }

    #[test]
    fn middles_and_means_are_those_of_hand_calculation() {
        assert_eq!(mean(&[1.0, 2.0, 6.0]), 3.0);
        assert_eq!(median(vec![5.0, 1.0, 2.0, 4.0]), Some(3.0));
        assert_eq!(median(vec![5.0, 1.0, 2.0]), Some(2.0));
        assert_eq!((median(Vec::new()), upper_median(&[])), (None, None));
        assert_eq!(upper_median(&[5.0, 1.0, 2.0, 4.0]), Some(4.0));
        assert_eq!(rms([3.0, -4.0]), 12.5_f64.sqrt());
        assert_eq!(rms([]), 0.0);
        let ranks = [rank_with_order(&[9.0, 4.0, 1.0]), rank_with_order(&[1.0, 4.0, 9.0])];
        assert_eq!((ranks, rank_with_order(&[2.0, 3.0, 1.0])), ([-1.0, 1.0], -0.5));
        // Deviations (-1, 0, 1) and (-2, 1, 1): 3/√(2·6).
        let pairs = [(1.0, 5.0), (2.0, 8.0), (3.0, 8.0)];
        assert!((correlation(&pairs).unwrap() - 0.75_f64.sqrt()).abs() < 1e-12);
        assert_eq!((correlation(&[(1.0, 2.0), (1.0, 3.0)]), correlation(&[])), (None, None));
        assert_eq!(deviation_about_zero(&[-1.0, 2.0, -900.0]), 2.0 * 1.4826);
    }

    /// χ² with 4 degrees exceeds 18.47 with a probability of 10⁻³: the bound is above, by less than
    /// half.
    #[test]
    fn the_bound_lies_above_the_quantile() {
        let bound = chi_squared_bound(4.0, 1000_f64.ln());
        assert!(bound > 18.47 && bound < 1.7 * 18.47, "{bound}");
    }
}
