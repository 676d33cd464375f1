//! A frequency is aliased: |f − n f_s|.

use super::{Arm, Candidate, Cause, CauseText, Parameter, Scale};

pub(super) const TEXT: CauseText = CauseText {
    description: "the frequency is aliased (above half the sampling rate)",
    confounded_with: "a missed mode",
    test: "measure one pose at another sampling rate",
};

/// The model may be wrong by this factor before the alias is known.
const MODEL_ERROR: f64 = 1.3;

/// Ratio of neighbouring starts over the possible sampling rates where the table states none.
const STEP: f64 = 1.03;

pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    // What is measured lies below half the rate.
    let least_rate = arm.min_sample_rate_hz.unwrap_or(2.0 * arm.highest_hz);
    let may_fold = |mode: &usize| {
        let highest = arm.highest_of_mode_hz.get(mode - 1).copied().unwrap_or(0.0);
        MODEL_ERROR * highest > 0.5 * least_rate
    };
    (1..=arm.modes)
        .filter(may_fold)
        .map(|mode| {
            let parameters = if arm.min_sample_rate_hz.is_some() {
                Vec::new()
            } else {
                let highest = MODEL_ERROR * arm.highest_of_mode_hz[mode - 1];
                let bounds = [least_rate, (2.0 * highest).max(1.01 * least_rate)];
                let starts = (0..60).map(|i| bounds[0] * STEP.powi(i));
                vec![Parameter {
                    name: "sample_rate_hz",
                    scale: Scale::Log,
                    nominal: None,
                    bounds,
                    starts: starts.take_while(|rate| *rate <= bounds[1]).collect(),
                    expected: None,
                }]
            };
            Candidate::new(Cause::AliasedMode, &mode.to_string(), parameters)
        })
        .collect()
}
