//! Which causes earn their place: one at a time, each held against all others, with those before it
//! questioned again whenever one is added.

use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::candidate::Candidate;
use super::data::Data;
use super::findings::RIVAL_WITHIN;
use super::fit::Fit;
use super::predict::Hypothesis;
use super::problem::Problem;
use super::screen::Screen;
use super::sets::sets;

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
    /// Sets of causes that are fitted whole, each time that sets are tried.
    pub(super) sets: usize,
}

impl Effort {
    pub(super) const FULL: Self = Self { first: 40, further: 14, starts: 2, kept: 5, sets: 24 };
    /// Inside a fold.
    pub(super) const FOLD: Self = Self { first: 16, further: 8, starts: 1, kept: 3, sets: 10 };
}

/// Most causes that are looked for.
const MOST_CAUSES: usize = 4;

/// Causes beyond the last that earned its place among which one more is looked for: some show only together.
const LOOKED_AHEAD: usize = 3;

/// A cause earns its place if chance does as well with any candidate less often than this.
pub(super) const SIGNIFICANCE: f64 = 0.005;

/// A cause that moves the frequencies by less than this share of the noise (root mean square) is not worth
/// telling: laws are never quite as straight as causes have them, and many poses show that.
pub(super) const LEAST_MATERIAL: f64 = 0.5;

/// Candidates that overlap count as fewer: their signatures have cosines of 0.9 and more in groups.
const INDEPENDENT_SHARE: f64 = 0.5;

/// A fitted model on its way.
#[derive(Debug, Clone)]
pub(super) struct Model<'c> {
    pub(super) fit: Fit<'c>,
    /// See [`worth`].
    pub(super) worth: f64,
}

impl Model<'_> {
    fn causes(&self) -> usize {
        self.fit.hypothesis.effects.len()
    }

    /// How many causes it has in common with another.
    fn shared(&self, other: &Self) -> usize {
        let theirs = &other.fit.hypothesis.effects;
        let is_theirs = |candidate: &Candidate| theirs.iter().any(|(c, _)| c.same_place(candidate));
        self.fit.hypothesis.effects.iter().filter(|(c, _)| is_theirs(c)).count()
    }
}

/// A choice.
#[derive(Debug, Clone)]
pub(super) struct Choice<'c> {
    pub(super) nothing: Fit<'c>,
    /// The best model; no cause if none earned its place.
    pub(super) best: Model<'c>,
    /// For each cause of the best model: models that have another in its place, and may have more than that
    /// otherwise, best first.
    pub(super) rivals: Vec<Vec<Model<'c>>>,
    /// Every model that was met and is worth about as much as the best.
    pub(super) seen: Vec<Model<'c>>,
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
    let mut front = best.clone();
    let mut kept = vec![best.clone()];
    let mut singles: Vec<Model<'c>> = Vec::new();
    let mut seen: Vec<Model<'c>> = Vec::new();
    while front.causes() < (best.causes() + LOOKED_AHEAD).min(MOST_CAUSES) {
        let mut next: Vec<Model<'c>> = Vec::new();
        for parent in &kept {
            next.extend(search.with_one_more(parent));
        }
        sort(&mut next);
        if front.causes() == 0 {
            singles.clone_from(&next);
        } else {
            search.add_sets(&front, &mut next);
        }
        let Some(first) = next.first() else { break };
        front = first.clone();
        if search.earns_its_place(&best, &front) {
            best = front.clone();
        }
        seen.extend(next.iter().filter(|model| within_reach(model, &best)).cloned());
        kept = next;
        distinct(&mut kept, effort.kept);
    }
    while let Some(better) = search.fewer(&best) {
        best = better;
    }
    let count = best.fit.hypothesis.effects.len();
    seen.retain(|model| within_reach(model, &best));
    seen.push(best.clone());
    let mut rivals: Vec<Vec<Model<'c>>> = Vec::new();
    for i in 0..count {
        let mut replaced = if count == 1 { singles.clone() } else { search.replaced(&best, i) };
        let others: Vec<Model<'c>> =
            seen.iter().flat_map(|other| instead_of(&best, i, other)).collect();
        let near = replaced.iter().filter(|model| within_reach(model, &best));
        seen.extend(near.cloned());
        replaced.extend(others);
        // Who names more causes has more to prove.
        for model in &mut replaced {
            let more = model.fit.hypothesis.effects.len().saturating_sub(count);
            model.worth -= RIVAL_WITHIN * more as f64;
        }
        sort(&mut replaced);
        rivals.push(replaced);
    }
    Some(Choice { nothing, best, rivals, seen })
}

struct Search<'s, 'p, 'c> {
    problem: &'s Problem<'p>,
    candidates: &'c [Candidate],
    screen: &'s Screen,
    effort: Effort,
}

impl<'c> Search<'_, '_, 'c> {
    fn model(&self, fit: Fit<'c>) -> Model<'c> {
        let worth = worth(self.problem.data, &fit);
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

    /// Adds models of one cause more than `front` to `next`, sorted: sets of causes that promise most together, near
    /// the best model that is known as long as that gets better, and near the best that is quite another.
    fn add_sets(&self, front: &Model<'c>, next: &mut Vec<Model<'c>>) {
        /// Each round starts from a better model.
        const ROUNDS: usize = 3;
        let size = front.causes() + 1;
        let mut near = front.clone();
        for _ in 0..ROUNDS {
            self.add_sets_near(&near, size, next);
            let Some(first) = next.first() else { return };
            let refined = self.refined(first.clone());
            if refined.worth > first.worth {
                next.insert(0, refined);
            }
            if next[0].worth <= near.worth + 0.01 && near.causes() == size {
                break;
            }
            near = next[0].clone();
        }
        let other = next.iter().find(|model| model.shared(&next[0]) + 2 <= size);
        if let Some(other) = other.cloned() {
            self.add_sets_near(&other, size, next);
        }
    }

    fn add_sets_near(&self, near: &Model<'c>, size: usize, next: &mut Vec<Model<'c>>) {
        let count = self.effort.sets;
        let sets = sets(self.problem, self.candidates, self.screen, &near.fit, size, count);
        let fitted =
            sets.into_par_iter().filter_map(|set| Some(self.model(self.problem.climb(set)?)));
        next.extend(fitted.collect::<Vec<_>>());
        sort(next);
    }

    /// Whether what `after` has more than `before` is worth telling.
    fn earns_its_place(&self, before: &Model<'c>, after: &Model<'c>) -> bool {
        if after.worth <= before.worth {
            return false;
        }
        if after.fit.freedom <= before.fit.freedom + 0.05 {
            // More causes, but no more parameters: they stand on their likelihood alone.
            return after.worth > before.worth + RIVAL_WITHIN;
        }
        p_value(self.problem, self.candidates.len(), &before.fit, &after.fit) <= SIGNIFICANCE
            && is_material(self.problem, &before.fit, &after.fit)
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

/// ln likelihood of a fit less what its parameters cost (Schwarz), and how plausible its causes are.
pub(super) fn worth(data: &Data, fit: &Fit<'_>) -> f64 {
    let n = data.points.len() as f64;
    let plausibility: f64 = fit.hypothesis.effects.iter().map(|(c, _)| c.plausibility).sum();
    fit.evaluation.score - 0.5 * fit.freedom * n.ln() + plausibility
}

/// Whether a model is worth about as much as the best.
fn within_reach(model: &Model<'_>, best: &Model<'_>) -> bool {
    model.worth >= best.worth - RIVAL_WITHIN
}

/// `other` with one of the causes that `best` lacks in the place of the cause `i` of `best`, and what both have
/// where `best` has it: once for each such cause; none if `other` has the cause `i`, too.
fn instead_of<'c>(best: &Model<'c>, i: usize, other: &Model<'c>) -> Vec<Model<'c>> {
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
            let mut spare = new.iter().copied().filter(|&other| other != n);
            let mut order: Vec<usize> = (0..ours.len())
                .filter_map(|j| match j {
                    _ if j == i => Some(n),
                    _ => shared.iter().position(|s| *s == Some(j)).or_else(|| spare.next()),
                })
                .collect();
            order.extend(spare);
            let mut model = other.clone();
            model.fit.arrange(&order);
            model
        })
        .collect()
}

/// Whether what `after` has more than `before` moves the frequencies by more than a part of the noise.
fn is_material(problem: &Problem<'_>, before: &Fit<'_>, after: &Fit<'_>) -> bool {
    let n = problem.data.points.len() as f64;
    // A likelihood falls by n ln of the noise: the squares of noise and effect add.
    let gain = after.evaluation.score - before.evaluation.score;
    (2.0 * gain / n).exp_m1() >= LEAST_MATERIAL * LEAST_MATERIAL
}

/// How often chance gains as much as `after` on `before` with any of so many candidates, or with any set of as many
/// as `after` has more.
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
    let tries: f64 = (1..=more).map(|i| independent / i as f64).product();
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

/// The first of each set of causes, places and forms, at most `count`.
fn distinct(models: &mut Vec<Model<'_>>, count: usize) {
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
