//! A frequency is folded about half the sampling rate: |f − n f_s|.

use super::{Arm, Candidate, Cause, Parameter, Scale, Words};

pub(super) const WORDS: Words = Words {
    what: "the frequency is folded about half the sampling rate",
    rivals: "a missed mode",
    test: "measure one pose at another sampling rate",
};

/// Starts over the possible sampling rates where none is told.
const STARTS: i32 = 60;

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    (1..=arm.modes)
        .map(|mode| {
            let parameters = if arm.has_sample_rate {
                Vec::new()
            } else {
                // What is measured lies below half the rate.
                let bounds = [2.0 * arm.highest_hz, 40.0 * arm.highest_hz];
                let step = (bounds[1] / bounds[0]).powf(1.0 / f64::from(STARTS));
                vec![Parameter {
                    name: "sample_rate_hz",
                    scale: Scale::Log,
                    nominal: None,
                    bounds,
                    starts: (0..=STARTS).map(|i| bounds[0] * step.powi(i)).collect(),
                    spread: None,
                }]
            };
            Candidate::new(Cause::AliasedMode, &mode.to_string(), parameters)
        })
        .collect()
}
