//! Whether causes explain what a model gets wrong, nothing is wrong, or nobody knows.

use super::choose::Choice;
use super::fit::Fit;
use super::gain::rms;
use super::outcome::Verdict;
use super::problem::Problem;
use super::unknown::{self, Structure, structure};

/// What follows nothing at all is noise up to here, share of the frequency: hammer tests of arms repeat within
/// a per cent.
const NOISIEST: f64 = 0.017;

/// ... or up to this multiple of the deviations that the table tells.
const TIMES_TOLD: f64 = 2.0;

/// A shape without a cause explains better than the causes do if it is worth more by this.
const UNKNOWN_BETTER_BY: f64 = 4.0;

/// Structure that is left is immaterial where the causes take this share of the squared error away ...
const OVERWHELMING: f64 = 0.985;

/// ... or where it has less than this share of the square of what is left: 0.6 of the noise.
const LEAST_SHARE: f64 = 0.26;

/// The verdict and what it rests on.
pub(super) struct Judged {
    pub(super) verdict: Verdict,
    pub(super) before: Option<Structure>,
    pub(super) after: Option<Structure>,
}

impl Judged {
    pub(super) fn of(problem: &Problem<'_>, choice: &Choice<'_>) -> Self {
        let nothing = structure(problem, &choice.nothing);
        let significant = |s: &Structure| s.p_value < unknown::SIGNIFICANCE;
        let before = nothing.as_ref().map(|s| s.clearest.clone()).filter(significant);
        if choice.best.fit.hypothesis.effects.is_empty() {
            let most = NOISIEST.max(TIMES_TOLD * problem.data.told_noise.unwrap_or(0.0));
            let is_noise = before.is_none() && choice.nothing.evaluation.noise.scale <= most;
            let verdict = if is_noise { Verdict::Consistent } else { Verdict::Unexplained };
            return Self { verdict, after: before.clone(), before };
        }
        let left = structure(problem, &choice.best.fit);
        let after = left.as_ref().map(|s| s.clearest.clone()).filter(significant);
        let worth_of_nothing = choice.nothing.evaluation.score;
        let unknown_is_better = nothing.as_ref().is_some_and(|s| {
            worth_of_nothing + s.best_worth > choice.best.worth + UNKNOWN_BETTER_BY
        });
        let square = |fit: &Fit<'_>| rms(fit.evaluation.residuals.iter()).powi(2);
        let explained = 1.0 - square(&choice.best.fit) / square(&choice.nothing).max(1e-300);
        let is_left = after.as_ref().is_some_and(|s| s.share >= LEAST_SHARE);
        let verdict = if (is_left || unknown_is_better) && explained < OVERWHELMING {
            Verdict::Unexplained
        } else {
            Verdict::Explained
        };
        Self { verdict, before, after }
    }
}
