//! Gaussian process regression of one quantity over the joints (Rasmussen & Williams, Gaussian
//! Processes for Machine Learning, 2006, chapters 2 and 5).
//!
//! ```text
//! y(q) = μ + g(q) + e,   cov(g(a), g(b)) = ρ s² exp(−½ Σ_j d_j(a, b)² / ℓ_j²),   var(e) = s² u²
//! ```
//!
//! d_j is the chord 2 |sin(Δq_j / 2)| of a turning joint and Δq_j over the range of the table of a
//! sliding one. ρ and ℓ_j maximise the restricted likelihood of the values, from which μ and s² are
//! integrated out, times weak priors: few poses say little about how far a joint reaches.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Fewest values that a process is fitted to.
const MIN_VALUES: usize = 6;

/// ln ℓ before the values are seen, and its deviation: a chord is 2 at most.
const LN_LENGTH: [f64; 2] = [0.7, 1.0];

/// ln ρ, the same.
const LN_RATIO: [f64; 2] = [1.0, 3.0];

/// Steps of ln ρ and ln ℓ above this choose the best start, which goes on with shorter ones.
const COARSE: f64 = 0.25;

/// No shorter steps than this.
const FINE: f64 = 0.05;

/// Length of a joint that the table does not vary: what it does away from there is not known.
const LENGTH_UNSEEN: f64 = 0.5;

/// A turning joint by the sine and cosine of its angle, a sliding one by its place in the range.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    /// Into the pose.
    pub(super) joint: usize,
    /// The range of the table, m; `None` of a turning joint.
    pub(super) slides_over: Option<f64>,
    /// Whether the table varies it.
    pub(super) is_seen: bool,
}

impl Axis {
    fn square(&self, a: &[f64], b: &[f64]) -> f64 {
        let apart = a[self.joint] - b[self.joint];
        match self.slides_over {
            Some(range) => (apart / range).powi(2),
            None => (2.0 * (0.5 * apart).sin()).powi(2),
        }
    }
}

/// A value at a pose.
#[derive(Debug, Clone)]
pub(super) struct Value {
    pub(super) q: Vec<f64>,
    pub(super) value: f64,
    /// Deviation of its noise over that of the others.
    pub(super) unit: f64,
}

/// A fitted process.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Process {
    axes: Vec<Axis>,
    /// ℓ of each axis.
    lengths: Vec<f64>,
    /// ρ.
    ratio: f64,
    /// s².
    noise_variance: f64,
    mean: f64,
    /// 1/(1ᵀC⁻¹1), C the covariance over s².
    variance_of_mean: f64,
    poses: Vec<Vec<f64>>,
    /// C⁻¹, C⁻¹(y − μ) and C⁻¹1.
    inverse: DMatrix<f64>,
    weights: DVector<f64>,
    ones: DVector<f64>,
}

/// What a process says of a pose, without the noise of a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Predicted {
    pub(super) mean: f64,
    pub(super) deviation: f64,
    /// Of the deviation: s² follows from the values.
    pub(super) freedom: f64,
}

/// Everything that follows from ρ and the lengths.
struct Solved {
    root: Cholesky<f64, Dyn>,
    weights: DVector<f64>,
    ones: DVector<f64>,
    mean: f64,
    variance_of_mean: f64,
    noise_variance: f64,
    /// −ln of the restricted likelihood.
    cost: f64,
}

/// Values with the squares of the distances along each axis.
struct Values<'v> {
    values: &'v [Value],
    squares: Vec<DMatrix<f64>>,
    floor: f64,
}

impl<'v> Values<'v> {
    fn new(values: &'v [Value], axes: &[Axis], floor: f64) -> Self {
        let n = values.len();
        let squares = axes
            .iter()
            .map(|axis| DMatrix::from_fn(n, n, |i, j| axis.square(&values[i].q, &values[j].q)));
        Self { values, squares: squares.collect(), floor }
    }

    fn solve(&self, ratio: f64, lengths: &[f64]) -> Option<Solved> {
        let n = self.values.len();
        let inverse_squares: Vec<f64> = lengths.iter().map(|own| (own * own).recip()).collect();
        let mut covariance = DMatrix::zeros(n, n);
        let columns = covariance.as_mut_slice().chunks_exact_mut(n.max(1));
        for (j, column) in columns.enumerate() {
            // Cholesky's factor is of the lower triangle.
            for (i, to) in column.iter_mut().enumerate().skip(j) {
                let mut exponent = 0.0;
                for (square, inverse) in self.squares.iter().zip(&inverse_squares) {
                    exponent += square.as_slice()[j * n + i] * inverse;
                }
                *to = ratio * (-0.5 * exponent).exp();
            }
            column[j] += self.values[j].unit.powi(2);
        }
        let root = covariance.cholesky()?;
        let y = DVector::from_iterator(n, self.values.iter().map(|value| value.value));
        let ones = root.solve(&DVector::from_element(n, 1.0));
        let variance_of_mean = ones.sum().recip();
        let mean = ones.dot(&y) * variance_of_mean;
        let rest = y.add_scalar(-mean);
        let weights = root.solve(&rest);
        let freedom = (n - 1) as f64;
        let noise_variance = (rest.dot(&weights) / freedom).max(self.floor * self.floor);
        let ln_determinant = 2.0 * root.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let square = rest.dot(&weights) / noise_variance;
        let cost =
            0.5 * (freedom * noise_variance.ln() + square + ln_determinant - variance_of_mean.ln());
        cost.is_finite().then_some(Solved {
            root,
            weights,
            ones,
            mean,
            variance_of_mean,
            noise_variance,
            cost,
        })
    }
}

impl Process {
    /// The process that the values make most likely; `None` of too few. `floor` is the least
    /// deviation of the noise.
    pub(super) fn fit(values: &[Value], axes: &[Axis], floor: f64) -> Option<Self> {
        if values.len() < MIN_VALUES {
            return None;
        }
        let of = Values::new(values, axes, floor);
        let seen: Vec<usize> = (0..axes.len()).filter(|&a| axes[a].is_seen).collect();
        let lengths = |at: &[f64]| {
            let mut lengths = vec![LENGTH_UNSEEN; axes.len()];
            seen.iter().zip(&at[1..]).for_each(|(&axis, ln)| lengths[axis] = ln.exp());
            lengths
        };
        let cost = |at: &[f64]| -> f64 {
            let expected = std::iter::once(LN_RATIO).chain(std::iter::repeat(LN_LENGTH));
            let prior: f64 =
                at.iter().zip(expected).map(|(x, [mean, std])| ((x - mean) / std).powi(2)).sum();
            let solved = of.solve(at[0].exp(), &lengths(at));
            solved.map_or(f64::INFINITY, |solved| solved.cost + 0.5 * prior)
        };
        let mut best = (f64::INFINITY, Vec::new());
        for ln_ratio in [-1.0, 3.0] {
            for ln_length in [0.0, 1.2] {
                let mut start = vec![ln_length; seen.len() + 1];
                start[0] = ln_ratio;
                let found = lowest(start, [1.0, COARSE], &cost);
                if found.0 < best.0 {
                    best = found;
                }
            }
        }
        if !best.0.is_finite() {
            return None;
        }
        let (_, at) = lowest(best.1, [COARSE, FINE], &cost);
        let ratio = at[0].exp();
        Self::with(&of, axes, ratio, lengths(&at))
    }

    fn with(of: &Values<'_>, axes: &[Axis], ratio: f64, lengths: Vec<f64>) -> Option<Self> {
        let Solved { root, weights, ones, mean, variance_of_mean, noise_variance, .. } =
            of.solve(ratio, &lengths)?;
        Some(Self {
            axes: axes.to_vec(),
            lengths,
            ratio,
            noise_variance,
            mean,
            variance_of_mean,
            poses: of.values.iter().map(|value| value.q.clone()).collect(),
            inverse: root.inverse(),
            weights,
            ones,
        })
    }

    /// At a pose; the deviation counts in that the mean is not known.
    pub(super) fn at(&self, q: &[f64]) -> Predicted {
        let covariance = |pose: &Vec<f64>| {
            let exponent = self.axes.iter().zip(&self.lengths);
            let exponent: f64 =
                exponent.map(|(axis, length)| axis.square(q, pose) / (length * length)).sum();
            self.ratio * (-0.5 * exponent).exp()
        };
        let own = DVector::from_iterator(self.poses.len(), self.poses.iter().map(covariance));
        let shared = 1.0 - own.dot(&self.ones);
        let variance =
            self.ratio - own.dot(&(&self.inverse * &own)) + shared * shared * self.variance_of_mean;
        Predicted {
            mean: self.mean + own.dot(&self.weights),
            deviation: (variance.max(0.0) * self.noise_variance).sqrt(),
            freedom: (self.poses.len() - 1) as f64,
        }
    }
}

/// A minimum by steps along one coordinate after another, from the one length on; where none helps,
/// half of it, until it is not above the other.
fn lowest(
    mut at: Vec<f64>,
    [mut step, last]: [f64; 2],
    cost: &dyn Fn(&[f64]) -> f64,
) -> (f64, Vec<f64>) {
    const BOUND: f64 = 9.0;
    let mut least = cost(&at);
    while step > last {
        let before = least;
        for i in 0..at.len() {
            for change in [step, -step] {
                let old = at[i];
                at[i] = (old + change).clamp(-BOUND, BOUND);
                let here = cost(&at);
                if here < least {
                    least = here;
                    break;
                }
                at[i] = old;
            }
        }
        if least > before - 1e-3 {
            step *= 0.5;
        }
    }
    (least, at)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn turning(joint: usize) -> Axis {
        Axis { joint, slides_over: None, is_seen: true }
    }

    fn values(count: usize) -> Vec<Value> {
        let value = |i: usize| {
            let q = TAU * (0.618 * i as f64).fract();
            let value = 0.02 + 0.01 * (q - 0.4).sin() + 0.003 * (7.1 * i as f64).sin();
            Value { q: vec![q, 0.3], value, unit: 1.0 + 0.5 * f64::from(i as u8 % 2) }
        };
        (0..count).map(value).collect()
    }

    /// exp(−(1 − cos Δ)/ℓ²) = e^{−z} (I_0(z) + 2 Σ I_k(z) cos kΔ), z = 1/ℓ² (Abramowitz & Stegun,
    /// 9.6.34): the process is a linear regression on sines and cosines with these variances, and
    /// on a constant of which nothing is known. Mean and deviation by normal equations.
    #[test]
    fn it_is_a_regression_on_sines_and_cosines() {
        const HARMONICS: usize = 14;
        let values = values(17);
        let axes = [turning(0)];
        let (ratio, length, floor) = (2.5, 0.8_f64, 1e-6);
        let of = Values::new(&values, &axes, floor);
        let process = Process::with(&of, &axes, ratio, vec![length]).unwrap();
        let z = 1.0 / (length * length);
        let bessel = |k: usize| {
            let mut term = (1..=k).fold(1.0, |term, i| term * 0.5 * z / i as f64);
            let mut sum = 0.0;
            for m in 1..60 {
                sum += term;
                term *= 0.25 * z * z / (m * (m + k)) as f64;
            }
            sum
        };
        let features = |q: f64| {
            let mut features = vec![1.0];
            for k in 1..=HARMONICS {
                features.extend([(k as f64 * q).sin(), (k as f64 * q).cos()]);
            }
            DVector::from_vec(features)
        };
        let n = 2 * HARMONICS + 1;
        let mut information = DMatrix::zeros(n, n);
        let mut along = DVector::zeros(n);
        // The constant takes the process's own constant part, too.
        for k in 1..=HARMONICS {
            let variance = ratio * (-z).exp() * 2.0 * bessel(k);
            information[(2 * k - 1, 2 * k - 1)] = variance.recip();
            information[(2 * k, 2 * k)] = variance.recip();
        }
        for value in &values {
            let row = features(value.q[0]) / value.unit;
            information += &row * row.transpose();
            along += row * (value.value / value.unit);
        }
        let root = information.cholesky().unwrap();
        let coefficients = root.solve(&along);
        for q in [0.0, 0.7, 2.0, 4.4, 6.0] {
            let row = features(q);
            let found = process.at(&[q, 0.3]);
            let mean = row.dot(&coefficients);
            let deviation = (row.dot(&root.solve(&row)) * process.noise_variance).sqrt();
            assert!((found.mean - mean).abs() < 1e-9, "{q}: {} {mean}", found.mean);
            assert!((found.deviation / deviation - 1.0).abs() < 1e-6, "{q}: {found:?} {deviation}");
        }
    }

    /// Far from all poses of a joint that was never moved, nothing is known.
    #[test]
    fn a_joint_that_the_table_does_not_move_widens_the_band() {
        let axes = [turning(0), Axis { is_seen: false, ..turning(1) }];
        let process = Process::fit(&values(30), &axes, 1e-4).unwrap();
        let own = (process.ratio * process.noise_variance).sqrt();
        let (near, far) = (process.at(&[1.0, 0.3]), process.at(&[1.0, 2.8]));
        assert!(near.deviation < 0.4 * own, "{near:?} {own}");
        assert!(far.deviation > 0.95 * own, "{far:?} {own}");
    }

    /// What was put in comes out, at poses that were not measured.
    #[test]
    fn a_smooth_residual_is_found_again() {
        let process = Process::fit(&values(40), &[turning(0), turning(1)], 1e-4).unwrap();
        for q in [0.5, 1.5, 3.1, 5.0] {
            let found = process.at(&[q, 0.3]);
            let truth = 0.02 + 0.01 * f64::sin(q - 0.4);
            assert!((found.mean - truth).abs() < 3.0 * found.deviation, "{q}: {found:?} {truth}");
            assert!((found.mean - truth).abs() < 0.002, "{q}: {found:?} {truth}");
        }
    }
}
