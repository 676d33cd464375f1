//! Fitted models compared: evidence, significance, alternatives.

use super::candidate::Candidate;
use super::data::Data;
use super::fit::Fit;
use super::problem::Problem;
use super::statistics::p_value_of_gain;

/// A cause is justified if its p-value, corrected for the number of candidates, is below this.
pub(super) const SIGNIFICANCE: f64 = 0.005;

/// A cause that moves the frequencies by less than this share of the noise (root mean square) is
/// not reported: no spring follows its law exactly, and many poses show that.
pub(super) const MIN_MATERIAL: f64 = 0.5;

/// Models whose log evidence is lower than the best by more than this are no alternatives: e^-6 is
/// one in four hundred.
pub(super) const ALTERNATIVE_WITHIN: f64 = 6.0;

/// Log evidence that an alternative loses for each other cause that has to change with it.
const WITH_OTHERS: f64 = 2.0;

/// Candidates that overlap count as fewer: their signatures have cosines of 0.9 and more in groups.
const INDEPENDENT_SHARE: f64 = 0.5;

/// A fitted model on its way.
#[derive(Debug, Clone)]
pub(super) struct Model<'c> {
    pub(super) fit: Fit<'c>,
    /// See [`log_evidence`].
    pub(super) log_evidence: f64,
}

impl Model<'_> {
    pub(super) fn causes(&self) -> usize {
        self.fit.hypothesis.effects.len()
    }

    /// How many causes it has in common with another.
    pub(super) fn shared(&self, other: &Self) -> usize {
        let theirs = &other.fit.hypothesis.effects;
        let is_theirs = |candidate: &Candidate| theirs.iter().any(|(c, _)| c.same_place(candidate));
        self.fit.hypothesis.effects.iter().filter(|(c, _)| is_theirs(c)).count()
    }
}

/// ln likelihood of a fit less what its parameters cost (Schwarz), and how plausible its causes
/// are.
pub(super) fn log_evidence(data: &Data, fit: &Fit<'_>) -> f64 {
    let n = data.points.len() as f64;
    let plausibility: f64 = fit.hypothesis.effects.iter().map(|(c, _)| c.plausibility).sum();
    fit.evaluation.score - 0.5 * fit.freedom * n.ln() + plausibility
}

/// Log evidence that an alternative to a cause of `best` loses: who names more causes has more to
/// prove, and a cause that needs others to change with it is less of an alternative than one that
/// does not.
pub(super) fn handicap(best: &Model<'_>, alternative: &Model<'_>) -> f64 {
    let more = alternative.causes().saturating_sub(best.causes());
    let others = (alternative.causes() - alternative.shared(best)).saturating_sub(1);
    ALTERNATIVE_WITHIN * more as f64 + WITH_OTHERS * others as f64
}

/// Whether a model has about the log evidence of the best.
pub(super) fn within_reach(model: &Model<'_>, best: &Model<'_>) -> bool {
    model.log_evidence >= best.log_evidence - ALTERNATIVE_WITHIN
}

/// `other` with one of the causes that `best` lacks in the place of the cause `i` of `best`, and
/// what both have where `best` has it: once for each such cause; none if `other` has the cause `i`,
/// too.
pub(super) fn substitutes<'c>(best: &Model<'c>, i: usize, other: &Model<'c>) -> Vec<Model<'c>> {
    let (ours, theirs) = (&best.fit.hypothesis.effects, &other.fit.hypothesis.effects);
    let of_ours = |candidate: &Candidate| ours.iter().position(|(c, _)| c.same_place(candidate));
    let shared: Vec<Option<usize>> = theirs.iter().map(|(c, _)| of_ours(c)).collect();
    if shared.contains(&Some(i)) {
        return Vec::new();
    }
    let new: Vec<usize> = (0..theirs.len()).filter(|&n| shared[n].is_none()).collect();
    new.iter()
        .filter(|_| theirs.len() >= ours.len())
        .map(|&n| {
            let mut others = new.iter().copied().filter(|&other| other != n);
            let mut order: Vec<usize> = (0..ours.len())
                .filter_map(|j| match j {
                    _ if j == i => Some(n),
                    _ => shared.iter().position(|s| *s == Some(j)).or_else(|| others.next()),
                })
                .collect();
            order.extend(others);
            let mut model = other.clone();
            model.fit.arrange(&order);
            model
        })
        .collect()
}

/// Whether what `after` has more than `before` moves the frequencies by more than a part of the
/// noise.
pub(super) fn is_material(problem: &Problem<'_>, before: &Fit<'_>, after: &Fit<'_>) -> bool {
    let n = problem.data.points.len() as f64;
    // A likelihood falls by n ln of the noise: the squares of noise and effect add.
    let gain = after.evaluation.score - before.evaluation.score;
    (2.0 * gain / n).exp_m1() >= MIN_MATERIAL * MIN_MATERIAL
}

/// p-value of the gain of `after` on `before`, corrected for the number of candidates, or of sets
/// of as many candidates as `after` has more.
pub(super) fn p_value(
    problem: &Problem<'_>,
    candidates: usize,
    before: &Fit<'_>,
    after: &Fit<'_>,
) -> f64 {
    let n = problem.data.points.len() as f64;
    let gain = after.evaluation.score - before.evaluation.score;
    let freedom = (after.freedom - before.freedom).max(1.0);
    let causes = |fit: &Fit<'_>| fit.hypothesis.effects.len();
    let more = causes(after).saturating_sub(causes(before)).max(1);
    let independent = INDEPENDENT_SHARE * candidates as f64;
    let tries: f64 = (1..=more).map(|i| (independent / i as f64).max(1.0)).product();
    (tries * p_value_of_gain(gain, freedom, n - after.freedom, n)).min(1.0)
}

pub(super) fn sort(models: &mut [Model<'_>]) {
    models.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
}

/// The first of each set of causes, places and forms, at most `count`.
pub(super) fn distinct(models: &mut Vec<Model<'_>>, count: usize) {
    let mut seen: Vec<Vec<&Candidate>> = Vec::new();
    models.retain(|model| {
        let causes: Vec<&Candidate> =
            model.fit.hypothesis.effects.iter().map(|(c, _)| *c).collect();
        let same = seen.iter().any(|other| {
            other.len() == causes.len()
                && causes.iter().all(|c| other.iter().any(|o| std::ptr::eq(*o, *c)))
        });
        if same || seen.len() == count {
            return false;
        }
        seen.push(causes);
        true
    });
}
