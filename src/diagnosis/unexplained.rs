//! What a calibrated model may be off by beyond its parameters, widened to what was seen.

use super::data::Data;
use super::fit::Fit;
use super::posterior::{Calibrated, rounded};
use crate::model::{Cause, Unexplained};

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

/// Of a link that bends the model has one hinge: it is fitted to the modes that were measured, and
/// above these a real link has others. `modes` are those of the model without it.
pub(super) fn as_hinges_stand_for_beams(
    data: &Data,
    chosen: &Fit<'_>,
    modes: usize,
    unexplained: &mut Unexplained,
) {
    /// Of ln f; beams of own mass differed by up to 0.67 in f from hinges that fit their lower
    /// modes.
    const OF_HINGES: f64 = 0.35;
    /// Elastic coordinates that a cause adds at most.
    const OF_CAUSE: usize = 6;
    let effects = &chosen.hypothesis.effects;
    if effects.iter().all(|(candidate, _)| candidate.cause != Cause::LinkFlexibility) {
        return;
    }
    let measured = data.points.iter().map(|point| point.column + 1).max().unwrap_or(0);
    for own in [&mut unexplained.near, &mut unexplained.far] {
        own.resize(own.len().max(modes + OF_CAUSE * effects.len()), 0.0);
        own.iter_mut().skip(measured).for_each(|ln| *ln = ln.max(OF_HINGES));
    }
}

/// Where the table drifts, springs and masses were learned at its middle, and nobody knows at what
/// moment of the drift a job finds the arm: how the drift scatters is in the errors, how far the
/// middle is from where the model was right is not.
pub(super) fn as_far_off_as_the_middle(offset: f64, unexplained: &mut Unexplained) {
    for own in unexplained.near.iter_mut().chain(&mut unexplained.far) {
        *own = rounded(own.hypot(offset));
    }
}

/// Far from the table no mode is better known than the model's error scatters over it, where
/// nothing explains that error: what springs and masses took of it says nothing elsewhere.
pub(super) fn as_far_off_as_seen(data: &Data, baseline: &Fit<'_>, unexplained: &mut Unexplained) {
    let scatter = |mode: usize| {
        let points = data.points.iter().zip(&baseline.evaluation.left.residuals);
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
