//! Whether causes explain what a model gets wrong, whether the model is consistent, or the error is
//! unexplained.

use super::choose::Choice;
use super::fit::Fit;
use super::outcome::{Structure, Verdict};
use super::problem::Problem;
use super::statistics::rms;
use super::structure::{self, structure};

/// An error without structure is noise up to here, share of the frequency: hammer tests of arms
/// repeat within a per cent,
const MAX_NOISE: f64 = 0.017;

/// or up to this multiple of the deviations that the table states.
const MAX_TIMES_STATED: f64 = 2.0;

/// A shape without a cause explains better than the causes do if its log evidence is higher by
/// this.
const SHAPE_BETTER_BY: f64 = 4.0;

/// The structure of the remaining residual is immaterial where the causes explain this share of the
/// squared error,
const OVERWHELMING: f64 = 0.985;

/// or where it has less than this share of the square of that residual: 0.6 of the noise.
const MIN_SHARE: f64 = 0.26;

/// The verdict and what it rests on.
pub(super) struct Judged {
    pub(super) verdict: Verdict,
    pub(super) before: Option<Structure>,
    pub(super) after: Option<Structure>,
}

impl Judged {
    pub(super) fn of(problem: &Problem<'_>, choice: &Choice<'_>) -> Self {
        let baseline = structure(problem, &choice.baseline);
        let significant = |s: &Structure| s.p_value < structure::SIGNIFICANCE;
        let before = baseline.as_ref().map(|s| s.clearest.clone()).filter(significant);
        if choice.best.fit.hypothesis.effects.is_empty() {
            let most = MAX_NOISE.max(MAX_TIMES_STATED * problem.data.stated_noise.unwrap_or(0.0));
            let is_noise = before.is_none() && choice.baseline.evaluation.noise.scale <= most;
            let verdict = if is_noise { Verdict::Consistent } else { Verdict::Unexplained };
            return Self { verdict, after: before.clone(), before };
        }
        let left = structure(problem, &choice.best.fit);
        let after = left.as_ref().map(|s| s.clearest.clone()).filter(significant);
        let log_evidence_before = choice.baseline.evaluation.score;
        let shape_is_better = baseline.as_ref().is_some_and(|s| {
            log_evidence_before + s.best_log_evidence > choice.best.log_evidence + SHAPE_BETTER_BY
        });
        let square = |fit: &Fit<'_>| rms(fit.evaluation.residuals.iter()).powi(2);
        let explained = 1.0 - square(&choice.best.fit) / square(&choice.baseline).max(1e-300);
        let is_left = after.as_ref().is_some_and(|s| s.share >= MIN_SHARE);
        let verdict = if (is_left || shape_is_better) && explained < OVERWHELMING {
            Verdict::Unexplained
        } else {
            Verdict::Explained
        };
        Self { verdict, before, after }
    }
}
