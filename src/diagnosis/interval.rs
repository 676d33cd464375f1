//! How sure a parameter is: from the curvature of the fit, for noise whose tails need not be Gaussian
//! (Huber, Robust Statistics, 1981, §7.6).

use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::data::Data;
use super::fit::Fit;
use super::likelihood::NOISE_FREEDOM;

/// Covariance of the parameters, as the fit measures them; `None` if the data do not hold them all.
pub(super) fn covariance(data: &Data, fit: &Fit<'_>) -> Option<DMatrix<f64>> {
    let p = fit.hypothesis.inner().len();
    let evaluation = &fit.evaluation;
    let nu = NOISE_FREEDOM;
    let mut information = DMatrix::zeros(p, p);
    let (mut square, mut curvature, mut count) = (0.0, 0.0, 0.0);
    for ((point, residual), slope) in
        data.points.iter().zip(&evaluation.residuals).zip(&evaluation.slopes)
    {
        let Some(residual) = residual else { continue };
        let variance = (evaluation.noise.scale * point.unit).powi(2) + point.rounding;
        let z2 = residual * residual / variance;
        square += (nu + 1.0).powi(2) * z2 / (nu + z2).powi(2);
        curvature += (nu + 1.0) * (nu - z2) / (nu + z2).powi(2);
        count += 1.0;
        for i in 0..p {
            for j in 0..p {
                information[(i, j)] += slope[i] * slope[j] / variance;
            }
        }
    }
    let parameters = fit.hypothesis.effects.iter().flat_map(|(candidate, _)| &candidate.parameters);
    for (i, parameter) in parameters.enumerate() {
        if let Some((_, precision)) = parameter.expectation() {
            information[(i, i)] += precision;
        }
    }
    let left: f64 = count - fit.freedom - 1.0;
    if left < 1.0 || curvature <= 0.0 {
        return None;
    }
    let inflation = (square / left) / (curvature / count).powi(2);
    information.try_inverse().map(|inverse| inverse * inflation)
}

/// What the data say of one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Certainty {
    /// Half the 95 % interval, as the fit measures the parameter; `None` if the data do not hold it.
    pub(super) half: Option<f64>,
    /// Whether the data say anything: more than what was expected, or other than that.
    pub(super) is_told: bool,
}

/// Of each parameter of a fit.
pub(super) fn certainties(data: &Data, fit: &Fit<'_>) -> Vec<Certainty> {
    /// Share of the expected variance above which the data have said nothing.
    const NOTHING_SAID: f64 = 0.8;
    let covariance = covariance(data, fit);
    let left = (data.points.len() as f64 - fit.freedom - 1.0).max(1.0);
    let quantile = StudentsT::new(0.0, 1.0, left).map_or(1.96, |t| t.inverse_cdf(0.975));
    /// A value nearer to what was expected, in its standard deviations, is just that.
    const AS_EXPECTED: f64 = 1e-3;
    let parameters = fit.hypothesis.effects.iter().flat_map(|(candidate, _)| &candidate.parameters);
    parameters
        .zip(fit.hypothesis.inner())
        .enumerate()
        .map(|(i, (parameter, inner))| {
            let variance =
                covariance.as_ref().map(|c| c[(i, i)].max(0.0)).filter(|v| v.is_finite());
            let (mean, precision) = parameter.expectation().unwrap_or((0.0, 0.0));
            let departs = (inner - mean).abs() * precision.sqrt() > AS_EXPECTED;
            Certainty {
                half: variance.map(|variance| quantile * variance.sqrt()),
                is_told: departs || precision * variance.unwrap_or(0.0) < NOTHING_SAID,
            }
        })
        .collect()
}
