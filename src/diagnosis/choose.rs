//! Which causes earn their place: one at a time, each held against all others, with those before it
//! questioned again whenever one is added.

use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::candidate::Candidate;
use super::fit::Fit;
use super::predict::Hypothesis;
use super::problem::Problem;
use super::screen::Screen;

/// How thorough a choice is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Candidates that are fitted as the first cause, after all were tried.
    pub(super) first: usize,
    /// Candidates that are fitted as a further cause of one model.
    pub(super) further: usize,
    /// Starts from which a candidate is fitted.
    pub(super) starts: usize,
    /// Models that are carried on to the next cause.
    pub(super) kept: usize,
}

impl Effort {
    pub(super) const FULL: Self = Self { first: 40, further: 14, starts: 2, kept: 5 };
    /// Inside a fold.
    pub(super) const FOLD: Self = Self { first: 16, further: 8, starts: 1, kept: 3 };
}

/// Most causes that are looked for.
const MOST_CAUSES: usize = 4;

/// A cause earns its place if chance does as well with any candidate less often than this.
pub(super) const SIGNIFICANCE: f64 = 0.005;

/// A cause that moves the frequencies by less than this share of the noise (root mean square) is not worth
/// telling: laws are never quite as straight as causes have them, and many poses show that.
pub(super) const LEAST_MATERIAL: f64 = 0.7;

/// Candidates that overlap count as fewer: their signatures have cosines of 0.9 and more in groups.
const INDEPENDENT_SHARE: f64 = 0.5;

/// A fitted model on its way.
#[derive(Debug, Clone)]
pub(super) struct Model<'c> {
    pub(super) fit: Fit<'c>,
    /// ln likelihood less what its parameters cost (Schwarz), and how plausible its causes are.
    pub(super) worth: f64,
}

/// A choice.
#[derive(Debug, Clone)]
pub(super) struct Choice<'c> {
    pub(super) nothing: Fit<'c>,
    /// The best model; no cause if none earned its place.
    pub(super) best: Model<'c>,
    /// For each cause of the best model: the same model with a rival in its place, and models of as many other
    /// causes throughout, best first.
    pub(super) rivals: Vec<Vec<Model<'c>>>,
}

/// Chooses among `candidates`.
pub(super) fn choose<'c>(
    problem: &Problem<'_>,
    candidates: &'c [Candidate],
    screen: &Screen,
    effort: Effort,
) -> Option<Choice<'c>> {
    let nothing = problem.climb(Hypothesis::default())?;
    let search = Search { problem, candidates, screen, effort };
    let mut best = search.model(nothing.clone());
    let mut kept = vec![best.clone()];
    let mut singles: Vec<Model<'c>> = Vec::new();
    let mut others: Vec<Model<'c>> = Vec::new();
    while best.fit.hypothesis.effects.len() < MOST_CAUSES {
        let mut next: Vec<Model<'c>> = Vec::new();
        for parent in &kept {
            next.extend(search.with_one_more(parent));
        }
        sort(&mut next);
        if best.fit.hypothesis.effects.is_empty() {
            singles.clone_from(&next);
        }
        let Some(first) = next.first() else { break };
        let first = if first.fit.hypothesis.effects.len() > 1 {
            search.refined(first.clone())
        } else {
            first.clone()
        };
        let p = p_value(problem, candidates.len(), &best.fit, &first.fit);
        if p > SIGNIFICANCE
            || first.worth <= best.worth
            || !is_material(problem, &best.fit, &first.fit)
        {
            break;
        }
        best = first.clone();
        others.clone_from(&next);
        kept = std::iter::once(first).chain(next).collect();
        distinct(&mut kept, effort.kept);
    }
    while let Some(better) = search.fewer(&best) {
        best = better;
    }
    let rivals = match best.fit.hypothesis.effects.len() {
        0 => Vec::new(),
        1 => vec![singles],
        count => {
            others.retain(|other| are_apart(other, &best));
            (0..count)
                .map(|i| {
                    let mut rivals = search.replaced(&best, i);
                    rivals.extend(others.iter().cloned());
                    sort(&mut rivals);
                    rivals
                })
                .collect()
        }
    };
    Some(Choice { nothing, best, rivals })
}

struct Search<'s, 'p, 'c> {
    problem: &'s Problem<'p>,
    candidates: &'c [Candidate],
    screen: &'s Screen,
    effort: Effort,
}

impl<'c> Search<'_, '_, 'c> {
    fn model(&self, fit: Fit<'c>) -> Model<'c> {
        let n = self.problem.data.points.len() as f64;
        let plausibility: f64 = fit.hypothesis.effects.iter().map(|(c, _)| c.plausibility).sum();
        let worth = fit.evaluation.score - 0.5 * fit.freedom * n.ln() + plausibility;
        Model { fit, worth }
    }

    /// Every promising model with one cause more.
    fn with_one_more(&self, parent: &Model<'c>) -> Vec<Model<'c>> {
        let taken = &parent.fit.hypothesis.effects;
        let mut tried: Vec<(f64, usize)> = self
            .candidates
            .par_iter()
            .enumerate()
            .filter(|(_, candidate)| !taken.iter().any(|(other, _)| other.same_place(candidate)))
            .map(|(i, candidate)| (self.screen.promise(self.problem, &parent.fit, i, candidate), i))
            .collect();
        tried.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        tried.truncate(if taken.is_empty() { self.effort.first } else { self.effort.further });
        tried
            .par_iter()
            .filter_map(|&(_, i)| {
                let added = Some(&self.candidates[i]);
                let fit = self.problem.fit(&parent.fit.hypothesis, added, self.effort.starts)?;
                Some(self.model(fit))
            })
            .collect()
    }

    /// The model with each cause questioned again, until no replacement is better.
    fn refined(&self, mut model: Model<'c>) -> Model<'c> {
        for _ in 0..3 {
            let count = model.fit.hypothesis.effects.len();
            let better = (0..count)
                .flat_map(|i| self.replaced(&model, i))
                .max_by(|a, b| a.worth.total_cmp(&b.worth));
            match better {
                Some(better) if better.worth > model.worth + 0.01 => model = better,
                _ => break,
            }
        }
        model
    }

    /// The model with one cause taken out, if that is better.
    fn fewer(&self, model: &Model<'c>) -> Option<Model<'c>> {
        let count = model.fit.hypothesis.effects.len();
        if count < 2 {
            return None;
        }
        let without = (0..count).filter_map(|i| {
            let mut hypothesis = model.fit.hypothesis.clone();
            hypothesis.effects.remove(i);
            let without = self.model(self.problem.climb(hypothesis)?);
            let count = self.candidates.len();
            let earns_its_place = p_value(self.problem, count, &without.fit, &model.fit)
                <= SIGNIFICANCE
                && is_material(self.problem, &without.fit, &model.fit);
            (!earns_its_place).then_some(without)
        });
        without.max_by(|a, b| a.worth.total_cmp(&b.worth))
    }

    /// The model with the cause `i` replaced by every promising rival, best first.
    fn replaced(&self, model: &Model<'c>, i: usize) -> Vec<Model<'c>> {
        let mut rest = model.fit.hypothesis.clone();
        rest.effects.remove(i);
        let Some(parent) = self.problem.climb(rest) else { return Vec::new() };
        let parent = self.model(parent);
        let mut models = self.with_one_more(&parent);
        // The new cause comes last; put it where the old one was.
        for model in &mut models {
            model.fit.move_last_to(i);
        }
        sort(&mut models);
        models
    }
}

/// Whether two models of as many causes have none in common.
fn are_apart(a: &Model<'_>, b: &Model<'_>) -> bool {
    let (a, b) = (&a.fit.hypothesis.effects, &b.fit.hypothesis.effects);
    a.len() == b.len() && !a.iter().any(|(one, _)| b.iter().any(|(other, _)| one.same_place(other)))
}

/// Whether what `after` has more than `before` moves the frequencies by more than a part of the noise.
fn is_material(problem: &Problem<'_>, before: &Fit<'_>, after: &Fit<'_>) -> bool {
    let n = problem.data.points.len() as f64;
    // A likelihood falls by n ln of the noise: the squares of noise and effect add.
    let gain = after.evaluation.score - before.evaluation.score;
    (2.0 * gain / n).exp_m1() >= LEAST_MATERIAL * LEAST_MATERIAL
}

/// How often chance gains as much as `after` on `before` with any of so many candidates.
pub(super) fn p_value(
    problem: &Problem<'_>,
    candidates: usize,
    before: &Fit<'_>,
    after: &Fit<'_>,
) -> f64 {
    let n = problem.data.points.len() as f64;
    let gain = after.evaluation.score - before.evaluation.score;
    let freedom = (after.freedom - before.freedom).max(1.0);
    let tries = INDEPENDENT_SHARE * candidates as f64;
    (tries * p_value_of_gain(gain, freedom, n - after.freedom, n)).min(1.0)
}

/// How often chance gains `gain` of ln likelihood from `freedom` parameters where `left` degrees of freedom
/// of `n` points remain: the F test of the residual sums of squares that the likelihoods stand for.
pub(super) fn p_value_of_gain(gain: f64, freedom: f64, left: f64, n: f64) -> f64 {
    if gain <= 0.0 || left < 1.0 {
        return 1.0;
    }
    let ratio = ((2.0 * gain / n).exp() - 1.0) * left / freedom;
    match FisherSnedecor::new(freedom, left) {
        Ok(f) if ratio.is_finite() => f.sf(ratio),
        Ok(_) => 0.0,
        Err(_) => 1.0,
    }
}

fn sort(models: &mut [Model<'_>]) {
    models.sort_by(|a, b| b.worth.total_cmp(&a.worth));
}

/// The first of each set of causes and places, at most `count`.
fn distinct(models: &mut Vec<Model<'_>>, count: usize) {
    let mut seen: Vec<Vec<&Candidate>> = Vec::new();
    models.retain(|model| {
        let causes: Vec<&Candidate> =
            model.fit.hypothesis.effects.iter().map(|(c, _)| *c).collect();
        let same = seen.iter().any(|other| {
            other.len() == causes.len()
                && causes.iter().all(|c| other.iter().any(|o| o.same_place(c)))
        });
        if same || seen.len() == count {
            return false;
        }
        seen.push(causes);
        true
    });
}
