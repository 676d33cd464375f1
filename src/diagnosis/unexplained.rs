//! What a calibrated model may be off by beyond its parameters, widened to what was seen.

use super::data::Data;
use super::fit::Fit;
use super::posterior::{Calibrated, rounded};
use crate::model::Unexplained;

/// No mode is better known, near the table or far from it, than the model with the causes that each
/// fold chooses predicted it at the states that the fold left out: `errors` relative to the
/// measured frequencies, one a point. The parameters' own variance is taken off, and the noise that
/// the table states.
pub(super) fn as_far_off_as_held_out(
    data: &Data,
    errors: &[Option<f64>],
    calibrated: &mut Calibrated,
) {
    let Calibrated { posterior, variance, .. } = calibrated;
    let Unexplained { near, far, .. } = &mut posterior.unexplained;
    let stated = data.stated_noise.unwrap_or(0.0);
    let of_mode = |mode: usize| {
        let points = data.points.iter().zip(errors).zip(variance.iter());
        let own = points.filter(|((point, _), _)| point.column == mode);
        let excess = own.filter_map(|((point, error), variance)| {
            let noise = (stated * point.stated).powi(2) + point.rounding;
            Some((*error)?.ln_1p().powi(2) - (*variance)? - noise)
        });
        let excess: Vec<f64> = excess.collect();
        let mean = excess.iter().sum::<f64>() / excess.len() as f64;
        (!excess.is_empty()).then(|| rounded(mean.max(0.0).sqrt()))
    };
    let held_out: Vec<Option<f64>> = (0..near.len()).map(of_mode).collect();
    // What was not measured is not better known than the worst that was.
    let worst = held_out.iter().flatten().copied().fold(0.0, f64::max);
    for ((near, far), own) in near.iter_mut().zip(far).zip(held_out) {
        let own = own.unwrap_or(worst);
        *near = near.max(own);
        *far = far.max(own);
    }
}

/// Far from the table no mode is better known than the model's error scatters over it, where
/// nothing explains that error: what springs and masses took of it says nothing elsewhere.
pub(super) fn as_far_off_as_seen(data: &Data, baseline: &Fit<'_>, unexplained: &mut Unexplained) {
    let scatter = |mode: usize| {
        let points = data.points.iter().zip(&baseline.evaluation.residuals);
        let own = points.filter(|(point, _)| point.column == mode).filter_map(|(_, r)| *r);
        let own: Vec<f64> = own.collect();
        let mean = own.iter().sum::<f64>() / own.len().max(1) as f64;
        let square: f64 = own.iter().map(|r| (r - mean).powi(2)).sum();
        (own.len() > 1).then(|| (square / (own.len() - 1) as f64).sqrt())
    };
    let modes = unexplained.far.len();
    let seen: Vec<Option<f64>> = (0..modes).map(scatter).collect();
    let largest = seen.iter().flatten().copied().fold(0.0, f64::max);
    let Unexplained { near, far, .. } = unexplained;
    for ((near, far), seen) in near.iter_mut().zip(far).zip(seen) {
        if seen.is_none() {
            *near = near.max(rounded(largest));
        }
        *far = far.max(rounded(seen.unwrap_or(largest)));
    }
}
