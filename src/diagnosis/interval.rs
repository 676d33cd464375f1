//! How sure a parameter is: from the curvature of the fit, for noise whose tails need not be
//! Gaussian (Huber, Robust Statistics, 1981, §7.6), and from what models with other causes beside
//! make of it.

use std::ptr;

use nalgebra::DMatrix;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};
use statrs::function::erf::erfc;

use super::candidate::{Candidate, Parameter};
use super::data::Data;
use super::fit::Fit;
use super::likelihood::NOISE_FREEDOM;
use super::models::{ALTERNATIVE_WITHIN, Model, log_evidence};
use super::problem::Problem;

/// Covariance of the parameters, as the fit measures them; `None` if the data do not hold them all.
pub(super) fn covariance(data: &Data, fit: &Fit<'_>) -> Option<DMatrix<f64>> {
    let p = fit.hypothesis.inner().len();
    let evaluation = &fit.evaluation;
    let nu = NOISE_FREEDOM;
    let mut information = DMatrix::zeros(p, p);
    let (mut square, mut curvature, mut count) = (0.0, 0.0, 0.0);
    for ((point, residual), slope) in
        data.points.iter().zip(&evaluation.left.innovations).zip(&evaluation.left.slopes)
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
    for shape in &evaluation.left.shapes {
        for (i, own) in shape.slope.iter().enumerate() {
            for (j, other) in shape.slope.iter().enumerate() {
                information[(i, j)] += own * other;
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
    /// Its 95 % interval, as the fit measures the parameter; `None` if the data do not hold it.
    pub(super) interval: Option<[f64; 2]>,
    /// Whether the data say anything: more than what was expected, or other than that.
    pub(super) is_informed: bool,
}

/// A parameter as one model has it: Gaussian, with the weight of the model.
#[derive(Debug, Clone, Copy)]
struct Share {
    weight: f64,
    mean: f64,
    deviation: f64,
}

/// Of each parameter of a fit, as if its causes were sure.
pub(super) fn certainties(data: &Data, fit: &Fit<'_>) -> Vec<Certainty> {
    /// Share of the expected variance above which the data have said nothing.
    const UNINFORMED: f64 = 0.8;
    /// A value nearer to what was expected, in its standard deviations, is just that.
    const AS_EXPECTED: f64 = 1e-3;
    let covariance = covariance(data, fit);
    let quantile = quantile(data, fit);
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
                interval: variance.map(|variance| {
                    let half = quantile * variance.sqrt();
                    [inner - half, inner + half]
                }),
                is_informed: departs || precision * variance.unwrap_or(0.0) < UNINFORMED,
            }
        })
        .collect()
}

/// The same where other models are about as plausible: intervals reach as far as the parameter does
/// in all models seen that have its cause, each with the weight of its evidence (Hoeting, Madigan,
/// Raftery & Volinsky, Statistical Science 14, 1999), and never less far than in `fit`.
///
/// `fit` is a fit to the last digit ([`Problem::converged`]); the others are made so here.
pub(super) fn averaged(
    problem: &Problem<'_>,
    fit: &Fit<'_>,
    seen: &[Model<'_>],
    best_evidence: f64,
) -> Vec<Certainty> {
    let data = problem.data;
    let own_evidence = log_evidence(data, fit);
    let others: Vec<Model<'_>> = distinct_from(fit, seen)
        .into_par_iter()
        .filter_map(|model| {
            let fit = problem.converged(model.fit.hypothesis.clone())?;
            let log_evidence = log_evidence(data, &fit);
            Some(Model { fit, log_evidence })
        })
        .collect();
    let deviations: Vec<Option<Vec<f64>>> =
        others.iter().map(|model| deviations(data, &model.fit)).collect();
    let mut certainties = certainties(data, fit);
    let effects = &fit.hypothesis.effects;
    let parameters = effects.iter().flat_map(|(candidate, inner)| {
        candidate.parameters.iter().zip(inner).map(move |(p, inner)| (candidate, p, *inner))
    });
    for ((candidate, parameter, inner), certainty) in parameters.zip(&mut certainties) {
        let Some([low, high]) = certainty.interval else { continue };
        let own = Share { weight: 1.0, mean: inner, deviation: (high - low) / (2.0 * GAUSSIAN) };
        let mut shares = vec![own];
        for (model, deviations) in others.iter().zip(&deviations) {
            let Some(deviations) = deviations else { continue };
            // However much better a model is, two counts of evidence are never compared to the last
            // digit.
            let weight = (model.log_evidence - own_evidence).clamp(-MAX_LN_ODDS, MAX_LN_ODDS).exp();
            // Nothing at the end of reach: which models there were met is chance.
            let within = model.log_evidence - (best_evidence - ALTERNATIVE_WITHIN);
            let weight = weight * -(-within.max(0.0)).exp_m1();
            shares.extend(share_in(&model.fit, deviations, candidate, parameter, weight));
        }
        certainty.interval =
            Some([low.min(quantile_of(&shares, 0.025)), high.max(quantile_of(&shares, 0.975))]);
    }
    certainties
}

/// Largest ln of the odds between two models.
const MAX_LN_ODDS: f64 = 30.0;

/// 97.5 % of a Gaussian lies below this many standard deviations.
const GAUSSIAN: f64 = 1.959_964;

fn quantile(data: &Data, fit: &Fit<'_>) -> f64 {
    let left = (data.points.len() as f64 - fit.freedom - 1.0).max(1.0);
    StudentsT::new(0.0, 1.0, left).map_or(GAUSSIAN, |t| t.inverse_cdf(0.975))
}

/// Standard deviations of all parameters, widened for what few data leave open.
fn deviations(data: &Data, fit: &Fit<'_>) -> Option<Vec<f64>> {
    let covariance = covariance(data, fit)?;
    let wider = quantile(data, fit) / GAUSSIAN;
    let deviations =
        covariance.diagonal().iter().map(|v| wider * v.max(0.0).sqrt()).collect::<Vec<_>>();
    deviations.iter().all(|d| d.is_finite()).then_some(deviations)
}

/// Each model once, but not that of `fit`.
pub(super) fn distinct_from<'m, 'c>(fit: &Fit<'c>, models: &'m [Model<'c>]) -> Vec<&'m Model<'c>> {
    let alike = |a: &Fit<'_>, b: &Fit<'_>| {
        let (a, b) = (&a.hypothesis.effects, &b.hypothesis.effects);
        a.len() == b.len() && a.iter().all(|(a, _)| b.iter().any(|(b, _)| ptr::eq(*a, *b)))
    };
    let mut sorted: Vec<&Model<'c>> = models.iter().collect();
    sorted.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    let mut distinct: Vec<&Model<'c>> = Vec::new();
    for model in sorted {
        if !alike(fit, &model.fit) && !distinct.iter().any(|other| alike(&other.fit, &model.fit)) {
            distinct.push(model);
        }
    }
    distinct
}

/// A parameter of a cause as a model has it: where it is expected if that model holds it there;
/// `None` if the model lacks the cause.
fn share_in(
    fit: &Fit<'_>,
    deviations: &[f64],
    cause: &Candidate,
    parameter: &Parameter,
    weight: f64,
) -> Option<Share> {
    let mut at = 0;
    for (candidate, inner) in &fit.hypothesis.effects {
        // A refinement means something else by the same name, and so does a beam beside a hinge.
        let is_alike = candidate.hinge == cause.hinge
            && candidate.is_refinement == cause.is_refinement
            && (cause.hinge.is_none() || candidate.fixed == cause.fixed);
        if candidate.same_place(cause) && is_alike {
            return match candidate.parameters.iter().position(|p| p.name == parameter.name) {
                Some(k) => Some(Share { weight, mean: inner[k], deviation: deviations[at + k] }),
                None => {
                    let (mean, _) = parameter.expectation()?;
                    Some(Share { weight, mean, deviation: 0.0 })
                }
            };
        }
        at += inner.len();
    }
    None
}

/// Where a mixture of Gaussians reaches `share`: by bisection.
fn quantile_of(shares: &[Share], share: f64) -> f64 {
    let total: f64 = shares.iter().map(|s| s.weight).sum();
    let below = |x: f64| -> f64 {
        let sum: f64 = shares
            .iter()
            .map(|s| {
                // What a model holds fixed is a step.
                if s.deviation <= 0.0 {
                    return if x >= s.mean { s.weight } else { 0.0 };
                }
                let z = (x - s.mean) / s.deviation;
                s.weight * 0.5 * erfc(-z / std::f64::consts::SQRT_2)
            })
            .sum();
        sum / total
    };
    let reach = |sign: f64| shares.iter().map(move |s| s.mean + sign * 10.0 * s.deviation);
    let mut low = reach(-1.0).fold(f64::INFINITY, f64::min);
    let mut high = reach(1.0).fold(f64::NEG_INFINITY, f64::max);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if below(middle) < share { low = middle } else { high = middle }
    }
    let x = 0.5 * (low + high);
    // The value that a model holds fixed, to the last digit.
    let mut fixed = shares.iter().filter(|s| s.deviation <= 0.0).map(|s| s.mean);
    fixed.find(|mean| (x - mean).abs() <= 1e-12 * (1.0 + mean.abs())).unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_gaussian_has_its_own_quantiles() {
        let shares = [Share { weight: 0.3, mean: 2.0, deviation: 0.5 }];
        assert!((quantile_of(&shares, 0.975) - (2.0 + 0.5 * GAUSSIAN)).abs() < 1e-6);
        assert!((quantile_of(&shares, 0.025) - (2.0 - 0.5 * GAUSSIAN)).abs() < 1e-6);
    }

    #[test]
    fn what_a_model_holds_fixed_is_a_step() {
        let shares = [
            Share { weight: 1.0, mean: 0.0, deviation: 0.0 },
            Share { weight: 1.0, mean: 5.0, deviation: 1.0 },
        ];
        assert!(quantile_of(&shares, 0.025) == 0.0);
        // 95 % of the Gaussian's own half.
        assert!((quantile_of(&shares, 0.975) - (5.0 + 1.644_854)).abs() < 1e-5);
    }

    /// Against a sum over a fine grid.
    #[test]
    fn quantiles_of_a_mixture_are_those_of_its_density() {
        let shares = [
            Share { weight: 1.0, mean: 0.0, deviation: 1.0 },
            Share { weight: 0.2, mean: 6.0, deviation: 0.3 },
        ];
        for share in [0.025, 0.5, 0.9, 0.975] {
            let x = quantile_of(&shares, share);
            let (mut below, mut all) = (0.0, 0.0);
            for i in -100_000..100_000 {
                let at = 1e-4 * f64::from(i) + 5e-5;
                let density: f64 = shares
                    .iter()
                    .map(|s| {
                        s.weight / s.deviation
                            * (-0.5 * ((at - s.mean) / s.deviation).powi(2)).exp()
                    })
                    .sum();
                all += density;
                below += if at < x { density } else { 0.0 };
            }
            assert!((below / all - share).abs() < 1e-4, "{share} {x} {}", below / all);
        }
    }
}
