//! Whether an analyser averaged its frequency responses under a Hann window: the spectra are fitted
//! both ways, with as many parameters, and the likelier way counts. Where lines are wide and modes
//! are not narrow, noise hides the difference: then the poles of the other way are as good, and the
//! deviations say so.

use super::block::{Block, Origin, Pole};
use super::fit::{Fit, NORMAL};
use super::{PoleEstimate, leaves, shared_lines};

/// The other way.
pub(super) struct Rival {
    /// How the spectra then came about.
    pub(super) origin: Origin,
    /// By pole of the fit.
    pub(super) poles: Vec<Pole>,
    /// By how much it is likelier, in ln.
    pub(super) gain: f64,
}

impl Rival {
    /// `None` for records, and for lines that do not lie evenly.
    pub(super) fn of(blocks: &[Block], fit: &Fit) -> Option<Self> {
        /// What leaks is one error for all lines near a mode and for all responses: in simulated
        /// averages of few short stretches the wrong way is likelier by up to 7 in ln where each
        /// line counts as an error of its own.
        const ERRORS_IN_ONE: f64 = 5.0;
        let [block @ Block { origin: Origin::Responses { hann_s }, .. }] = blocks else {
            return None;
        };
        if fit.poles.is_empty() {
            return None;
        }
        let hann_s = match hann_s {
            Some(_) => None,
            None => Some(super::hann::length_s(&block.omega)?),
        };
        let other = [Block { origin: Origin::Responses { hann_s }, ..block.clone() }];
        let rival = Fit::near(&other, fit.noise.clone(), fit.poles.clone(), NORMAL)?;
        let [own, others] = [fit, &rival].map(|of| of.evaluation.sum_of_squares);
        // What is left near the modes, over what the noise is taken for.
        let left = |(blocks, fit): (&[Block], &Fit)| -> f64 {
            let near = fit.poles.iter().map(|pole| leaves(blocks, fit, pole));
            let (left, values) =
                near.fold((0.0, 0.0), |sum, own| (sum.0 + own.left, sum.1 + own.values));
            left / f64::max(values, 1.0)
        };
        let left = left((blocks, fit)).min(left((&other, &rival))).max(f64::MIN_POSITIVE);
        let gain = 0.5 * (own - others) / (left * shared_lines(blocks, fit) * ERRORS_IN_ONE);
        let [Block { origin, .. }] = other;
        Some(Self { origin, poles: rival.poles, gain })
    }

    /// The fit with lines weighted as without leakage; as it is where there may be a window.
    pub(super) fn without_leakage(&self, blocks: &[Block], fit: Fit) -> Fit {
        /// ln of how much likelier that is.
        const BEYOND_DOUBT: f64 = 2.0;
        match blocks {
            [Block { origin: Origin::Responses { hann_s: None }, .. }]
                if self.gain < -BEYOND_DOUBT =>
            {
                fit.reweighted_without_window(blocks)
            }
            _ => fit,
        }
    }
}

/// Probability of a rival that is so much likelier.
pub(super) fn share_of_rival(gain: f64) -> f64 {
    (1.0 + (-gain).exp()).recip()
}

/// Poles that may as well be the right ones.
pub(super) struct Doubt {
    pub(super) share: f64,
    pub(super) poles: Vec<Pole>,
}

impl Doubt {
    pub(super) fn widen(&self, own: &PoleEstimate, at: usize) -> PoleEstimate {
        let Some(other) = self.poles.get(at) else { return own.clone() };
        let apart = |of: fn(&Pole) -> f64| self.share.sqrt() * (of(other) - of(&own.pole));
        PoleEstimate {
            omega_std: own.omega_std.hypot(apart(Pole::omega)),
            ratio_std: own.ratio_std.hypot(apart(Pole::ratio)),
            ..own.clone()
        }
    }
}
