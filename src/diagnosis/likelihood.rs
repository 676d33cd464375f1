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
    let nu = NOISE_FREEDOM;
    let known: Vec<(f64, f64, f64)> = points
        .iter()
        .zip(residuals)
        .filter_map(|(point, r)| Some((r.as_ref()?.powi(2), point.unit.powi(2), point.rounding)))
        .collect();
    let count = known.len() as f64;
    let mean = known.iter().map(|(r2, u2, _)| r2 / u2).sum::<f64>() / count.max(1.0);
    let floor = MIN_NOISE * MIN_NOISE;
    // The variance of a point is s²u² + rounding; the part that is ours to find follows from the
    // expected share of it in the residual.
    let expected = |s2: f64| -> f64 {
        let sum: f64 = known
            .iter()
            .map(|&(r2, u2, rounding)| {
                let variance = s2 * u2 + rounding;
                let weight = (nu + 1.0) / (nu + r2 / variance);
                let share = s2 * u2 / variance;
                (share * share * weight * r2 + s2 * u2 * (1.0 - share)) / u2
            })
            .sum();
        (sum / count.max(1.0)).max(floor)
    };
    // Steffensen's method on ln s².
    let mut s2 = mean.max(floor);
    // A handful of rounds is enough.
    for _ in 0..30 {
        let once = expected(s2);
        let twice = expected(once);
        let [step, next] = [(once / s2).ln(), (twice / once).ln()];
        let further = step * step / (step - next);
        // The likelihood may have little to say far from its top: then the plain iteration goes on.
        let leaps = step != next && further.abs() < 3.0 && (further > 0.0) == (step > 0.0);
        s2 = if leaps { (s2 * further.exp()).max(floor) } else { twice };
        if step.abs() < 1e-6 {
            break;
        }
    }
    let constant =
        ln_gamma(0.5 * (nu + 1.0)) - ln_gamma(0.5 * nu) - 0.5 * (nu * std::f64::consts::PI).ln();
    let mut ln_likelihood = 0.0;
    let weights = points
        .iter()
        .zip(residuals)
        .map(|(point, r)| match r {
            None => {
                ln_likelihood += UNPREDICTED;
                0.0
            }
            Some(r) => {
                let variance = s2 * point.unit.powi(2) + point.rounding;
                let z2 = r * r / variance;
                ln_likelihood +=
                    constant - 0.5 * variance.ln() - 0.5 * (nu + 1.0) * (z2 / nu).ln_1p();
                (nu + 1.0) / (nu + z2) / variance
            }
        })
        .collect();
    Noise { ln_likelihood, scale: s2.sqrt(), weights }
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
