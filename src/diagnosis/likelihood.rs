//! How likely residuals are, the level of the noise being unknown: Student's t with a common scale,
//! so that a slip of the instrument counts for little (Lange, Little & Taylor, J. Am. Stat. Assoc.
//! 84, 1989).

use statrs::function::gamma::ln_gamma;

use super::data::Point;

/// Degrees of freedom of the noise: 8 loses 3 % where the noise is Gaussian and shrugs off slips.
pub(super) const NOISE_FREEDOM: f64 = 8.0;

/// No instrument does better than this, as a share of the frequency.
pub(super) const MIN_NOISE: f64 = 3e-4;

/// ln of the density of a measured mode that the model has no mode for: anywhere within a factor
/// e².
pub(super) const UNPREDICTED: f64 = -std::f64::consts::LN_2;

/// A step of ln s² after which the next would be less than 1e-7, and one after which ln likelihood
/// is known to a thousandth: it is flat there.
const NO_STEP: f64 = 1e-4;
const SMALL_STEP: f64 = 1e-2;

/// The noise as the residuals show it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Noise {
    /// ln of the likelihood at the best scale.
    pub(super) ln_likelihood: f64,
    /// Scale of t, share of the frequency.
    pub(super) scale: f64,
    /// Weight over variance of each point; 0 where there is no prediction.
    pub(super) weights: Vec<f64>,
}

/// The likeliest noise for residuals of ln f, one a point; `None` where the model has no such mode.
pub(super) fn noise(points: &[Point], residuals: &[Option<f64>]) -> Noise {
    let s2 = likeliest_variance(points, residuals, f64::INFINITY, NO_STEP);
    let mut weights = Vec::with_capacity(points.len());
    let ln_likelihood = ln_likelihood_at(s2, points, residuals, |weight| weights.push(weight));
    Noise { ln_likelihood, scale: s2.sqrt(), weights }
}

/// ln likelihood at the likeliest scale, about: the scale is sought from another model's on.
pub(super) fn ln_likelihood_near(scale: f64, points: &[Point], residuals: &[Option<f64>]) -> f64 {
    let s2 = likeliest_variance(points, residuals, scale * scale, SMALL_STEP);
    ln_likelihood_at(s2, points, residuals, |_| ())
}

/// Scale² of t, sought from `from` on or from the mean square where that is less, until a step of
/// its logarithm is less than `no_step`.
fn likeliest_variance(points: &[Point], residuals: &[Option<f64>], from: f64, no_step: f64) -> f64 {
    let nu = NOISE_FREEDOM;
    let known = points.iter().zip(residuals).filter_map(|(point, r)| Some((point, (*r)?)));
    // r² and rounding over u² of each point, in fours; zeros behind the last count for nothing.
    let mut fours: Vec<[[f64; 4]; 2]> = Vec::with_capacity(points.len().div_ceil(4));
    let mut count = 0;
    for (point, r) in known {
        if count % 4 == 0 {
            fours.push([[0.0; 4]; 2]);
        }
        let u2 = point.unit.powi(2);
        if let Some([r2, rounding]) = fours.last_mut() {
            r2[count % 4] = r * r / u2;
            rounding[count % 4] = point.rounding / u2;
        }
        count += 1;
    }
    let count = count as f64;
    let mean = fours.iter().flat_map(|[r2, _]| r2).sum::<f64>() / count.max(1.0);
    let floor = MIN_NOISE * MIN_NOISE;
    // The variance of a point is v = s²u² + rounding. The part that is ours to find follows from
    // its expected share in the residual: s² = mean of part · s² / (v (νv + r²)), on one
    // denominator. That mean, and its derivative by s².
    let expected = |s2: f64| -> [f64; 2] {
        let mut sums = [[0.0; 4]; 2];
        for [r2, rounding] in &fours {
            for k in 0..4 {
                let variance = s2 + rounding[k];
                let spread = nu * variance + r2[k];
                let from_residual = (nu + 1.0) * r2[k];
                let part = s2 * from_residual + rounding[k] * spread;
                let inverse = 1.0 / (variance * spread);
                let own = s2 * part * inverse;
                sums[0][k] += own;
                sums[1][k] += inverse
                    * (part + s2 * (from_residual + nu * rounding[k])
                        - own * (spread + nu * variance));
            }
        }
        sums.map(|sum| sum.iter().sum::<f64>() / count.max(1.0))
    };
    // Newton's method on ln s² = ln mean(s²).
    let mut s2 = mean.min(from).max(floor);
    // A handful of rounds is enough.
    for _ in 0..30 {
        let [next, slope] = expected(s2);
        let plain = (next / s2).ln();
        let further = plain / (1.0 - s2 * slope / next);
        // Far from the top the likelihood may have little to say: then the plain iteration goes on.
        let leaps = further.abs() < 3.0 && (further > 0.0) == (plain > 0.0);
        let step = if leaps { further } else { plain };
        let before = s2;
        s2 = (s2 * step.exp()).max(floor);
        // What is left is of the order of the square of the step; also where nothing scatters.
        if step.abs() < no_step || s2 == before || !step.is_finite() {
            break;
        }
    }
    s2
}

/// ln likelihood under a scale²; hands on the weight over variance of each point.
fn ln_likelihood_at(
    s2: f64,
    points: &[Point],
    residuals: &[Option<f64>],
    mut weigh: impl FnMut(f64),
) -> f64 {
    let nu = NOISE_FREEDOM;
    let constant =
        ln_gamma(0.5 * (nu + 1.0)) - ln_gamma(0.5 * nu) - 0.5 * (nu * std::f64::consts::PI).ln();
    let mut ln_likelihood = 0.0;
    let mut count = 0;
    // Products of some variances and of 1 + z²/ν: one logarithm for all.
    let mut product = [1.0; 2];
    let of_product =
        |[variance, spread]: [f64; 2]| -0.5 * variance.ln() - 0.5 * (nu + 1.0) * spread.ln();
    for (point, r) in points.iter().zip(residuals) {
        let Some(r) = r else {
            ln_likelihood += UNPREDICTED;
            weigh(0.0);
            continue;
        };
        let variance = s2 * point.unit.powi(2) + point.rounding;
        let z2 = r * r / variance;
        product = [product[0] * variance, product[1] * (1.0 + z2 / nu)];
        count += 1;
        if count % 4 == 0 {
            ln_likelihood += of_product(product);
            product = [1.0; 2];
        }
        weigh((nu + 1.0) / (nu + z2) / variance);
    }
    ln_likelihood + f64::from(count) * constant + of_product(product)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(n: usize) -> Vec<Point> {
        let point = |row| Point {
            row,
            column: 0,
            ln_f: 3.0,
            unit: 1.0,
            stated: 1.0,
            rounding: 1e-7,
            index: row,
        };
        (0..n).map(point).collect()
    }

    /// Against a scan of the scale.
    #[test]
    fn the_scale_is_the_likeliest() {
        let points = points(40);
        let residuals: Vec<Option<f64>> =
            (0..40).map(|i| Some(0.01 * (1.7 * f64::from(i)).sin())).collect();
        let found = noise(&points, &residuals);
        let nu = NOISE_FREEDOM;
        let at = |s: f64| -> f64 {
            residuals
                .iter()
                .flatten()
                .map(|r| {
                    let v = s * s + 1e-7;
                    -0.5 * v.ln() - 0.5 * (nu + 1.0) * (r * r / v / nu).ln_1p()
                })
                .sum()
        };
        let best = (1..2000)
            .map(|i| 1e-5 * f64::from(i))
            .max_by(|a, b| at(*a).total_cmp(&at(*b)))
            .unwrap();
        assert!((found.scale - best).abs() < 2e-5, "{} {best}", found.scale);
    }

    /// From above, from below, and from a scale that is nobody's.
    #[test]
    fn the_likelihood_is_about_the_same_from_wherever_the_scale_is_sought() {
        let points = points(40);
        let mut residuals: Vec<Option<f64>> =
            (0..40).map(|i| Some(0.01 * (1.7 * f64::from(i)).sin())).collect();
        residuals[7] = None;
        residuals[9] = Some(0.2);
        let whole = noise(&points, &residuals);
        for share in [1e-2, 0.5, 1.0, 3.0, 1e3] {
            let near = ln_likelihood_near(share * whole.scale, &points, &residuals);
            assert!((near - whole.ln_likelihood).abs() < 2e-3, "{share}: {near}");
        }
    }

    #[test]
    fn one_slip_moves_the_scale_little() {
        let points = points(40);
        let mut residuals: Vec<Option<f64>> =
            (0..40).map(|i| Some(0.01 * (1.7 * f64::from(i)).sin())).collect();
        let before = noise(&points, &residuals).scale;
        residuals[3] = Some(0.5);
        let after = noise(&points, &residuals).scale;
        assert!(after < 1.3 * before, "{before} {after}");
    }
}
