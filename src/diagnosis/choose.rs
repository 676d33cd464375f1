//! Which causes the data justify: one after another and in sets, each held against all others, with
//! those before it questioned again whenever one is added or taken away.

use rayon::prelude::*;

use super::candidate::Candidate;
use super::extrapolation::least_extrapolating;
use super::fit::Fit;
use super::hypothesis::Hypothesis;
use super::known::{Asked, Converged, Known};
use super::models::{
    ALTERNATIVE_WITHIN, Model, SIGNIFICANCE, distinct, handicap, is_material, log_evidence,
    p_value, sort, substitutes, within_reach,
};
use super::problem::Problem;
use super::screen::Screen;
use super::sets::{sets, swaps};
use crate::model::Cause;

/// How thorough a choice is.
#[derive(Debug, Clone, Copy)]
pub(super) struct SearchWidth {
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
    /// Most causes that are looked for.
    pub(super) causes: usize,
}

impl SearchWidth {
    pub(super) const FULL: Self =
        Self { first: 40, further: 14, starts: 3, kept: 6, sets: 32, causes: 4 };

    /// Inside a fold of a table of which the whole has so many causes: a part does not justify
    /// many more.
    pub(super) fn of_fold(causes: usize) -> Self {
        let causes = (causes + 1).min(Self::FULL.causes);
        Self { first: 24, further: 10, starts: 1, kept: 4, sets: 16, causes }
    }
}

/// Local modes that are fitted beside the other candidates as a further cause. As the first one,
/// all are in their plain forms: each moves a column wherever it starts.
const LOCAL_MODES: usize = 3;

/// Places of the best fits of one cause at which every form is fitted: a start of a form that gives
/// in many directions at once promises little.
const WHOLE_PLACES: usize = 3;

/// How many causes are looked for at once beyond those that are justified: some show only together,
/// and most where nothing is known yet.
const fn lookahead(causes: usize) -> usize {
    if causes == 0 { 3 } else { 2 }
}

/// A choice.
#[derive(Debug, Clone)]
pub(super) struct Choice<'c> {
    pub(super) baseline: Fit<'c>,
    /// Models of one cause, best first.
    pub(super) singles: Vec<Model<'c>>,
    /// The best model; no cause if none is justified.
    pub(super) best: Model<'c>,
    /// For each cause of the best model: models that have another in its place, and may have more
    /// than that otherwise, best first.
    pub(super) alternatives: Vec<Vec<Model<'c>>>,
    /// Every model that was met and has about the log evidence of the best.
    pub(super) seen: Vec<Model<'c>>,
}

/// What there is to choose from, and how.
#[derive(Clone, Copy)]
pub(super) struct Means<'m, 'c> {
    pub(super) candidates: &'c [Candidate],
    pub(super) screen: &'m Screen,
    pub(super) width: SearchWidth,
    /// Fits start where these ended.
    pub(super) known: &'m Known<'c>,
}

/// Chooses among candidates. Of a large table a part chooses, and all of it fits what the part
/// finds.
pub(super) fn choose<'c>(problem: &Problem<'_>, means: Means<'_, 'c>) -> Option<Choice<'c>> {
    let search = Search::new(problem, means);
    match problem.data.thinned() {
        None => search.choice(),
        Some(few) => {
            let part = Problem { data: &few, ..*problem };
            search.fitted(Search::new(&part, means).choice()?)
        }
    }
}

/// The causes that [`choose`] finds, without what else it says of them.
pub(super) fn best_of<'c>(problem: &Problem<'_>, means: Means<'_, 'c>) -> Option<Hypothesis<'c>> {
    let few = problem.data.thinned();
    let part = Problem { data: few.as_ref().unwrap_or(problem.data), ..*problem };
    let search = Search::new(&part, means);
    let best = search.searched(part.optimise(Hypothesis::default())?)?.best.fit.hypothesis;
    match few {
        Some(_) => Some(problem.optimise(best)?.hypothesis),
        None => Some(best),
    }
}

/// What a search met.
struct Searched<'c> {
    singles: Vec<Model<'c>>,
    best: Model<'c>,
    seen: Vec<Model<'c>>,
}

struct Search<'s, 'p, 'c> {
    problem: &'s Problem<'p>,
    means: Means<'s, 'c>,
    converged: Converged<'c>,
}

impl<'s, 'p, 'c> Search<'s, 'p, 'c> {
    fn new(problem: &'s Problem<'p>, means: Means<'s, 'c>) -> Self {
        Self { problem, means, converged: Converged::default() }
    }

    /// From the model without causes to larger ones, as long as the data justify them.
    fn searched(&self, baseline: Fit<'c>) -> Option<Searched<'c>> {
        let mut best = self.model(baseline);
        // The best model of each number of causes.
        let mut fronts = vec![best.clone()];
        let mut kept = vec![best.clone()];
        let mut singles: Vec<Model<'c>> = Vec::new();
        let mut seen: Vec<Model<'c>> = Vec::new();
        while fronts.len()
            <= (best.causes() + lookahead(best.causes())).min(self.means.width.causes)
        {
            let mut next: Vec<Model<'c>> = Vec::new();
            for parent in &kept {
                next.extend(self.with_one_more(parent));
            }
            sort(&mut next);
            match fronts.last() {
                Some(front) if front.causes() > 0 => self.add_sets(front, &mut next),
                _ => singles.clone_from(&next),
            }
            let Some(first) = next.first() else { break };
            fronts.push(first.clone());
            let fewer = self.with_one_less(&next);
            if let (Some(known), Some(first)) = (fronts.iter_mut().rev().nth(1), fewer.first())
                && first.log_evidence > known.log_evidence
            {
                *known = first.clone();
            }
            if next.first().is_some_and(|model| model.causes() == 2) {
                singles.extend(fewer.iter().cloned());
                sort(&mut singles);
                distinct(&mut singles, usize::MAX);
            }
            best = self.largest_justified(&fronts);
            let met = next.iter().chain(&fewer);
            seen.extend(met.filter(|model| within_reach(model, &best)).cloned());
            kept = next;
            distinct(&mut kept, self.means.width.kept);
        }
        while let Some(better) = self.fewer(&best) {
            best = better;
        }
        let other = least_extrapolating(self.problem, &best, &seen);
        if let Some(other) = other.filter(|other| self.is_justified(&fronts[0], other)) {
            best = other.clone();
        }
        Some(Searched { singles, best, seen })
    }

    /// The best model with its rivals.
    fn choice(&self) -> Option<Choice<'c>> {
        let baseline = self.problem.optimise(Hypothesis::default())?;
        let Searched { singles, best, seen } = self.searched(baseline.clone())?;
        self.among(baseline, singles, best, seen)
    }

    fn among(
        &self,
        baseline: Fit<'c>,
        singles: Vec<Model<'c>>,
        best: Model<'c>,
        mut seen: Vec<Model<'c>>,
    ) -> Option<Choice<'c>> {
        seen.retain(|model| within_reach(model, &best));
        seen.push(best.clone());
        let alternatives = self.alternatives(&best, &singles, &mut seen);
        Some(Choice { baseline, singles, best, alternatives, seen })
    }

    /// What a part of the table chose, fitted to all of it. Where all of it likes another of these
    /// models better, the rivals are looked for once more.
    fn fitted(&self, of_part: Choice<'c>) -> Option<Choice<'c>> {
        /// Models of a kind that are fitted to all rows.
        const MOST: usize = 12;
        let again = |mut models: Vec<Model<'c>>| {
            sort(&mut models);
            distinct(&mut models, MOST);
            let mut models = self.models_of(models.into_iter().map(|model| model.fit.hypothesis));
            sort(&mut models);
            models
        };
        let baseline = self.problem.optimise(Hypothesis::default())?;
        let (singles, best) = (again(of_part.singles), again(vec![of_part.best]).pop()?);
        let mut seen = again(of_part.seen);
        let mut alternatives: Vec<_> = of_part.alternatives.into_iter().map(again).collect();
        let is_better = |model: &&Model<'c>| {
            model.causes() <= best.causes() && model.log_evidence > best.log_evidence + 0.01
        };
        let met = seen.iter().chain(alternatives.iter().flatten());
        let better = met.filter(is_better).max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence));
        if let Some(better) = better.cloned() {
            seen.extend(alternatives.into_iter().flatten());
            return self.among(baseline, singles, better, seen);
        }
        for rival in alternatives.iter_mut().flatten() {
            rival.log_evidence -= handicap(&best, rival);
        }
        alternatives.iter_mut().for_each(|rivals| sort(rivals));
        seen.retain(|model| within_reach(model, &best));
        seen.push(best.clone());
        Some(Choice { baseline, singles, best, alternatives, seen })
    }

    fn model(&self, fit: Fit<'c>) -> Model<'c> {
        let log_evidence = log_evidence(self.problem.data, &fit);
        Model { fit, log_evidence }
    }

    /// The models of all that have a fit, in the order in which they are asked for.
    fn models(&self, asked: Vec<Asked<'c>>) -> Vec<Model<'c>> {
        let Means { known, width, .. } = self.means;
        let fits = known.fits(self.problem, asked, width.starts, &self.converged);
        fits.into_iter().map(|fit| self.model(fit)).collect()
    }

    /// The models of hypotheses, from their own parameters.
    fn models_of(&self, hypotheses: impl IntoIterator<Item = Hypothesis<'c>>) -> Vec<Model<'c>> {
        self.models(hypotheses.into_iter().map(Asked::from).collect())
    }

    /// Every promising model with one cause more.
    fn with_one_more(&self, parent: &Model<'c>) -> Vec<Model<'c>> {
        let taken = &parent.fit.hypothesis.effects;
        let is_first = taken.is_empty();
        let beside = self.means.screen.beside(self.problem, &parent.fit);
        let mut tried: Vec<(f64, usize)> = self
            .means
            .candidates
            .par_iter()
            .enumerate()
            .filter(|(_, candidate)| !taken.iter().any(|(other, _)| other.same_place(candidate)))
            .map(|(i, candidate)| (beside.expected_gain(i, candidate), i))
            .collect();
        tried.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let most = if is_first { self.means.width.first } else { self.means.width.further };
        // Local modes promise much wherever a column is far off, and take no other's turn.
        let is_local = |&(_, i): &(f64, usize)| self.means.candidates[i].cause == Cause::LocalMode;
        let is_plain = |&(_, i): &(f64, usize)| self.means.candidates[i].parameters.len() < 3;
        let local = tried.iter().filter(|t| is_local(t) && (!is_first || is_plain(t))).copied();
        let local: Vec<_> = local.take(if is_first { usize::MAX } else { LOCAL_MODES }).collect();
        tried.retain(|t| !is_local(t));
        tried.truncate(most);
        tried.extend(local);
        self.add_plain(parent, &mut tried);
        let given = &parent.fit.hypothesis;
        let asked = |&(_, i): &(f64, usize)| Asked::with(given.clone(), &self.means.candidates[i]);
        let mut models = self.models(tried.iter().map(asked).collect());
        sort(&mut models);
        let most = if is_first { WHOLE_PLACES } else { 1 };
        let further = self.other_forms(&models, &tried, most);
        models.extend(self.models(further.iter().map(asked).collect()));
        models
    }

    /// The candidates that were not tried at the `most` places of the best of `models`, sorted,
    /// that came last.
    fn other_forms(
        &self,
        models: &[Model<'c>],
        tried: &[(f64, usize)],
        most: usize,
    ) -> Vec<(f64, usize)> {
        let mut places: Vec<&Candidate> = Vec::new();
        for (candidate, _) in models.iter().filter_map(|model| model.fit.hypothesis.effects.last())
        {
            if !places.iter().any(|place| place.same_place(candidate)) {
                places.push(candidate);
            }
        }
        places.truncate(most);
        let is_other = |(i, candidate): &(usize, &Candidate)| {
            places.iter().any(|place| place.same_place(candidate))
                && tried.iter().all(|(_, other)| other != i)
        };
        let all = self.means.candidates.iter().enumerate();
        all.filter(is_other).map(|(i, _)| (0.0, i)).collect()
    }

    /// Adds the plain stiffness of each joint of which a law is tried: a law has to beat what it
    /// contains, which promises a little less.
    fn add_plain(&self, parent: &Model<'c>, tried: &mut Vec<(f64, usize)>) {
        let (all, taken) = (self.means.candidates, &parent.fit.hypothesis.effects);
        let is_plain = |plain: &Candidate| {
            tried.iter().any(|&(_, law)| all[law].is_law_over(plain))
                && !taken.iter().any(|(other, _)| other.same_place(plain))
        };
        let is_new = |i: &usize| tried.iter().all(|(_, other)| other != i);
        let plain: Vec<usize> = (0..all.len()).filter(|&i| is_plain(&all[i])).collect();
        let plain: Vec<usize> = plain.into_iter().filter(is_new).collect();
        tried.extend(plain.into_iter().map(|i| (0.0, i)));
    }

    /// Adds models of one cause more than `front` to `next`, sorted: sets of causes that promise
    /// most together, near the best model that is known as long as that gets better, and near the
    /// best that is quite another.
    fn add_sets(&self, front: &Model<'c>, next: &mut Vec<Model<'c>>) {
        let size = front.causes() + 1;
        let mut near = front.clone();
        // Each round starts from a better model.
        for _ in 0..3 {
            self.add_sets_near(&near, size, next);
            let Some(first) = next.first() else { return };
            let refined = self.refined(first.clone());
            if refined.log_evidence > first.log_evidence {
                next.insert(0, refined);
            }
            if next[0].log_evidence <= near.log_evidence + 0.01 && near.causes() == size {
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
        let count = self.means.width.sets;
        let sets =
            sets(self.problem, self.means.candidates, self.means.screen, &near.fit, size, count);
        next.extend(self.models_of(sets));
        sort(next);
    }

    /// The best of the models, sorted, each with one cause taken out, best first: a larger set may
    /// show what a smaller one should have been (floating search: Pudil, Novovičová & Kittler,
    /// Pattern Recognition Letters 15, 1994).
    fn with_one_less(&self, models: &[Model<'c>]) -> Vec<Model<'c>> {
        let mut best: Vec<Model<'c>> =
            models.iter().take(4 * self.means.width.kept).cloned().collect();
        distinct(&mut best, self.means.width.kept);
        let large = best.iter().filter(|model| model.causes() > 1);
        let fewer = large.flat_map(|model| {
            let without = |i: usize| {
                let mut hypothesis = model.fit.hypothesis.clone();
                hypothesis.effects.remove(i);
                hypothesis
            };
            (0..model.causes()).map(without).collect::<Vec<_>>()
        });
        let mut fewer = self.models_of(fewer);
        sort(&mut fewer);
        fewer
    }

    /// Of the best models of no cause, one, two and so on, the largest of which each is justified
    /// against the one before.
    fn largest_justified(&self, fronts: &[Model<'c>]) -> Model<'c> {
        let mut best = &fronts[0];
        for front in &fronts[1..] {
            if self.is_justified(best, front) {
                best = front;
            }
        }
        best.clone()
    }

    /// Whether the data justify what `after` has more than `before`.
    fn is_justified(&self, before: &Model<'c>, after: &Model<'c>) -> bool {
        if after.log_evidence <= before.log_evidence {
            return false;
        }
        if after.fit.freedom <= before.fit.freedom + 0.05 {
            // More causes, but no more parameters: they stand on their likelihood alone.
            return after.log_evidence > before.log_evidence + ALTERNATIVE_WITHIN;
        }
        let at_once = after.causes().saturating_sub(before.causes());
        // Causes of which none is justified alone each need the log evidence of one that is.
        let is_enough = at_once < 2
            || after.log_evidence > before.log_evidence + ALTERNATIVE_WITHIN * at_once as f64;
        is_enough
            && p_value(self.problem, self.means.candidates.len(), &before.fit, &after.fit)
                <= SIGNIFICANCE
            && is_material(self.problem, &before.fit, &after.fit)
    }

    /// For each cause of the best model, the models that have another in its place; adds to `seen`
    /// what is found on the way and within reach.
    fn alternatives(
        &self,
        best: &Model<'c>,
        singles: &[Model<'c>],
        seen: &mut Vec<Model<'c>>,
    ) -> Vec<Vec<Model<'c>>> {
        if best.causes() > 1 {
            seen.extend(self.swapped(best).into_iter().filter(|model| within_reach(model, best)));
        }
        let alternatives_to = |i: usize| {
            let others: Vec<Model<'c>> =
                seen.iter().flat_map(|other| substitutes(best, i, other)).collect();
            let mut alternatives =
                if best.causes() == 1 { singles.to_vec() } else { self.replaced(best, i) };
            seen.extend(alternatives.iter().filter(|model| within_reach(model, best)).cloned());
            alternatives.extend(others);
            for alternative in &mut alternatives {
                alternative.log_evidence -= handicap(best, alternative);
            }
            sort(&mut alternatives);
            alternatives
        };
        (0..best.causes()).map(alternatives_to).collect()
    }

    /// The model with each cause questioned again, until no replacement is better.
    fn refined(&self, mut model: Model<'c>) -> Model<'c> {
        for _ in 0..3 {
            let count = model.fit.hypothesis.effects.len();
            let better = (0..count)
                .flat_map(|i| self.replaced(&model, i))
                .max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence));
            match better {
                Some(better) if better.log_evidence > model.log_evidence + 0.01 => model = better,
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
        let without = |i: usize| {
            let mut hypothesis = model.fit.hypothesis.clone();
            hypothesis.effects.remove(i);
            hypothesis
        };
        let without = self.models_of((0..count).map(without)).into_iter().filter_map(|without| {
            let count = self.means.candidates.len();
            let is_justified = p_value(self.problem, count, &without.fit, &model.fit)
                <= SIGNIFICANCE
                && is_material(self.problem, &without.fit, &model.fit);
            (!is_justified).then_some(without)
        });
        without.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence))
    }

    /// The model with the cause `i` replaced by every promising alternative, best first: of what
    /// the others leave once they have done what they can.
    fn replaced(&self, model: &Model<'c>, i: usize) -> Vec<Model<'c>> {
        let mut rest = model.fit.hypothesis.clone();
        rest.effects.remove(i);
        let parent = self.models_of([rest]).pop();
        parent.map_or_else(Vec::new, |parent| self.put_in(&parent, i))
    }

    /// The model with each cause in turn given up for another that looks most like it near the
    /// model.
    fn swapped(&self, model: &Model<'c>) -> Vec<Model<'c>> {
        let swaps = swaps(
            self.problem,
            self.means.candidates,
            self.means.screen,
            &model.fit,
            self.means.width.sets,
        );
        self.models_of(swaps)
    }

    /// Every promising model with one cause more than `parent`, at place `i`, best first.
    fn put_in(&self, parent: &Model<'c>, i: usize) -> Vec<Model<'c>> {
        let mut models = self.with_one_more(parent);
        // The new cause comes last.
        for model in &mut models {
            model.fit.move_last_to(i);
        }
        sort(&mut models);
        models
    }
}

#[cfg(test)]
mod tests {
    use super::super::candidate::{Parameter, Scale};
    use super::super::fit::tests::{arm, data};
    use super::*;

    /// A part of the table preferred a cause to its rival by chance.
    #[test]
    fn of_what_a_part_could_not_tell_apart_the_whole_table_chooses() {
        let description = arm();
        let offset = Parameter {
            name: "dx_m",
            scale: Scale::Linear(0.1),
            nominal: Some(0.0),
            bounds: [-1.0, 1.0],
            starts: vec![0.1],
            expected: None,
        };
        // As many that are no better fill a list.
        let at = ["l2", "l3"].into_iter().chain(["l2"; 12]);
        let candidates: Vec<Candidate> =
            at.map(|at| Candidate::new(Cause::ComOffset, at, vec![offset.clone()])).collect();
        let of = |i: usize, at: f64| Hypothesis { effects: vec![(&candidates[i], vec![at])] };
        let mut table = data(12);
        let problem = Problem { description: &description, data: &table };
        let without = problem.compare(&of(1, 1.5)).unwrap().left.residuals;
        for (i, (point, off)) in table.points.iter_mut().zip(without).enumerate() {
            point.ln_f += 0.002 * (7.0 * i as f64).sin() - off.unwrap();
        }
        let problem = Problem { description: &description, data: &table };
        let screen = Screen::new(&problem, &candidates).unwrap();
        let known = Known::default();
        let (candidates, screen, known) = (&candidates[..], &screen, &known);
        let means = Means { candidates, screen, width: SearchWidth::of_fold(1), known };
        let search = Search::new(&problem, means);
        let model = |i| search.models_of([of(i, 0.5)]).remove(0);
        let baseline = problem.optimise(Hypothesis::default()).unwrap();
        let ahead = |i| Model { log_evidence: 1e3, ..model(i) };
        let seen: Vec<Model<'_>> = (2..candidates.len()).map(ahead).collect();
        let (singles, best, alternatives) = (Vec::new(), model(0), vec![vec![model(1)]]);
        assert!(model(1).log_evidence > best.log_evidence + 5.0);
        let of_part = Choice { baseline, singles, best, alternatives, seen };
        let chosen = search.fitted(of_part).unwrap();
        assert_eq!(chosen.best.fit.hypothesis.effects[0].0.at.as_deref(), Some("l3"));
    }
}
