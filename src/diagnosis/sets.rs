//! Sets of causes that promise most together. One cause after another misses sets whose members
//! only explain much together; fitting every set takes too long. So all sets are first tried by
//! linear least squares on what each cause does near a model that is fitted already (best subsets:
//! Furnival & Wilson, Technometrics 16, 1974).

mod triangle;

use std::borrow::Cow;
use std::ops::Range;
use std::ptr;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use self::triangle::Triangle;
use super::candidate::{Candidate, Parameter, Scale};
use super::fit::Fit;
use super::hypothesis::Hypothesis;
use super::problem::{NONE, Problem};
use super::screen::Screen;

/// Smaller sets that are carried on to larger ones, for each set that is asked for.
const CARRIED: usize = 5;

/// Standard deviation of a cause's effect over that of a typical start: causes that are huge and
/// cancel each other are no likely set.
const MAX_TYPICAL: f64 = 2.0;

/// A linear effect this far below zero is none where it cannot be negative.
const MIN_SHARE: f64 = 1e-3;

/// A candidate near the model: what it does as a whole, and what each further parameter does to
/// that.
struct Member<'c> {
    candidate: &'c Candidate,
    /// Parameters at which the columns hold, as the fit measures them.
    at: Vec<f64>,
    /// The first of its columns; the others belong to all parameters but the first.
    first_column: usize,
    columns: usize,
}

impl Member<'_> {
    fn columns(&self) -> Range<usize> {
        self.first_column..self.first_column + self.columns
    }
}

/// The linear problem: weighted columns as their products with one another.
struct Linear<'c> {
    members: Vec<Member<'c>>,
    /// By member: the first one of the same cause at the same place.
    places: Vec<usize>,
    products: DMatrix<f64>,
    /// 1/variance of what is expected of each column's coefficient, 0 where nothing is, and the
    /// value.
    expected: Vec<[f64; 2]>,
    /// Products of the columns with what has to be explained.
    along: DVector<f64>,
    square: f64,
    count: f64,
}

/// A set with what the linear problem says of it.
#[derive(Clone)]
struct TrialSet {
    /// Places in [`Linear::members`], ascending.
    members: Vec<usize>,
    log_evidence: f64,
}

impl TrialSet {
    /// Not tried yet.
    fn of(members: Vec<usize>) -> Self {
        Self { members, log_evidence: f64::NEG_INFINITY }
    }
}

/// The most promising sets of `size` causes near `model`, best first, each with parameters from
/// which a fit may start; of the same causes at the same places only the most promising forms.
/// Causes that put another mode into a column stay as `model` has them.
pub(super) fn sets<'c>(
    problem: &Problem<'_>,
    candidates: &'c [Candidate],
    screen: &Screen,
    model: &Fit<'c>,
    size: usize,
    count: usize,
) -> Vec<Hypothesis<'c>> {
    let given = model.hypothesis.that_move_columns();
    let Some(size) = size.checked_sub(given.effects.len()).filter(|&size| size > 0) else {
        return Vec::new();
    };
    let linear = Linear::near(problem, candidates, screen, model);
    let mut carried = vec![TrialSet::of(Vec::new())];
    for have in 0..size {
        let last = have + 1 == size;
        let mut next: Vec<TrialSet> =
            carried.par_iter().flat_map_iter(|set| linear.with_one_more(set)).collect();
        next.sort_by(|a, b| {
            b.log_evidence.total_cmp(&a.log_evidence).then_with(|| a.members.cmp(&b.members))
        });
        next.dedup_by(|a, b| a.members == b.members);
        // The pairs of few candidates are tried one and all.
        let most = if last {
            count
        } else {
            (CARRIED * count).max(linear.members.len() * usize::from(have == 0))
        };
        let mut kept: Vec<TrialSet> = Vec::new();
        for set in next {
            if kept.len() == most {
                break;
            }
            let known = |other: &TrialSet| last && linear.same_places(&set, other);
            if !kept.iter().any(known) {
                kept.push(set);
            }
        }
        carried = kept;
    }
    carried.iter().filter_map(|set| linear.beside(&given, set)).collect()
}

/// For each cause of `model` the `count` most promising sets that have another in its place, with
/// parameters from which a fit may start.
pub(super) fn swaps<'c>(
    problem: &Problem<'_>,
    candidates: &'c [Candidate],
    screen: &Screen,
    model: &Fit<'c>,
    count: usize,
) -> Vec<Hypothesis<'c>> {
    let linear = Linear::near(problem, candidates, screen, model);
    let effects = &model.hypothesis.effects;
    let is_one = |i: usize| effects.iter().any(|(c, _)| ptr::eq(*c, linear.members[i].candidate));
    let own: Vec<usize> = (0..linear.members.len()).filter(|&i| is_one(i)).collect();
    let given = model.hypothesis.that_move_columns();
    let mut swaps = Vec::new();
    for &without in &own {
        let members = own.iter().copied().filter(|&i| i != without).collect();
        let mut tried = linear.with_one_more(&TrialSet::of(members));
        // Not what was taken out, in this form or another.
        let is_taken = |&i: &usize| linear.places[i] == linear.places[without];
        tried.retain(|set| !set.members.iter().any(is_taken));
        tried.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
        swaps.extend(tried.iter().take(count).filter_map(|set| linear.beside(&given, set)));
    }
    swaps
}

/// What `candidate` does near `model`, one entry a point: as a whole against the model without any
/// form of it, and by each parameter but the first; with the parameters where that holds. `None` if
/// nobody can say.
fn effect_near(
    problem: &Problem<'_>,
    screen: &Screen,
    model: &Fit<'_>,
    which: usize,
    candidate: &Candidate,
) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    if candidate.moves_columns() {
        return None;
    }
    let effects = &model.hypothesis.effects;
    let mut hypothesis = model.hypothesis.clone();
    hypothesis.effects.retain(|(other, _)| !other.same_place(candidate));
    let without = if hypothesis.effects.len() == effects.len() {
        Cow::Borrowed(&model.evaluation.left)
    } else {
        Cow::Owned(problem.left_by(&hypothesis, NONE)?)
    };
    let (at, with, first) = match effects.iter().position(|(other, _)| ptr::eq(*other, candidate)) {
        Some(i) => {
            let first = effects[..i].iter().map(|(_, inner)| inner.len()).sum::<usize>();
            (effects[i].1.clone(), Cow::Borrowed(&model.evaluation.left), first)
        }
        None => {
            let at = screen.typical_start(which)?;
            let first = hypothesis.inner().len();
            hypothesis.effects.push((candidate, at.clone()));
            // Of what the candidate does as a whole no slope is needed.
            let left = problem.left_by(&hypothesis, first + 1..hypothesis.inner().len())?;
            (at, Cow::Owned(left), first)
        }
    };
    let both = without.innovations.iter().zip(&with.innovations);
    // A residual falls where a prediction rises.
    let whole = both.map(|(without, with)| without.zip(*with).map_or(0.0, |(a, b)| a - b));
    let mut columns = vec![whole.collect()];
    for k in 1..candidate.parameters.len() {
        let slope = |slopes: &Vec<f64>| slopes.get(first + k).copied().unwrap_or(0.0);
        columns.push(with.slopes.iter().map(slope).collect());
    }
    Some((at, columns))
}

impl<'c> Linear<'c> {
    /// The linear problem near a model.
    fn near(
        problem: &Problem<'_>,
        candidates: &'c [Candidate],
        screen: &Screen,
        model: &Fit<'c>,
    ) -> Self {
        let effects: Vec<_> = candidates
            .par_iter()
            .enumerate()
            .map(|(which, candidate)| effect_near(problem, screen, model, which, candidate))
            .collect();
        let evaluation = &model.evaluation;
        let mut members = Vec::new();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut expected = Vec::new();
        // What has to be explained: what the model leaves, and what its causes do.
        let mut rest: Vec<f64> =
            evaluation.left.innovations.iter().map(|r| r.unwrap_or(0.0)).collect();
        for (candidate, effect) in candidates.iter().zip(effects) {
            let Some((at, own)) = effect else { continue };
            if model.hypothesis.effects.iter().any(|(other, _)| ptr::eq(*other, candidate)) {
                rest.iter_mut().zip(&own[0]).for_each(|(rest, own)| *rest += own);
            }
            expected.push([MAX_TYPICAL.powi(-2), 0.0]);
            for (parameter, at) in candidate.parameters.iter().zip(&at).skip(1) {
                let (mean, precision) = parameter.expectation().unwrap_or((*at, 0.0));
                expected.push([precision, mean - at]);
            }
            members.push(Member { candidate, at, first_column: columns.len(), columns: own.len() });
            columns.extend(own);
        }
        // A point without prediction has no weight.
        Self::of(members, &columns, expected, &rest, &evaluation.noise.weights)
    }

    fn of(
        members: Vec<Member<'c>>,
        columns: &[Vec<f64>],
        expected: Vec<[f64; 2]>,
        rest: &[f64],
        weights: &[f64],
    ) -> Self {
        let roots = DVector::from_iterator(weights.len(), weights.iter().map(|w| w.sqrt()));
        let weighted = |column: &[f64]| DVector::from_column_slice(column).component_mul(&roots);
        let rest = weighted(rest);
        let mut flat = DMatrix::zeros(rest.len(), columns.len());
        for (i, column) in columns.iter().enumerate() {
            flat.set_column(i, &weighted(column));
        }
        let first = |own: &Member<'_>| {
            members.iter().position(|other| other.candidate.same_place(own.candidate))
        };
        Self {
            places: members.iter().filter_map(first).collect(),
            members,
            products: flat.tr_mul(&flat),
            along: flat.tr_mul(&rest),
            square: rest.norm_squared(),
            expected,
            count: weights.iter().filter(|w| **w > 0.0).count() as f64,
        }
    }

    fn same_places(&self, a: &TrialSet, b: &TrialSet) -> bool {
        let places = |set: &TrialSet| set.members.iter().map(|&i| self.places[i]).collect();
        let [a, b]: [Vec<usize>; 2] = [places(a), places(b)];
        a.iter().all(|place| b.contains(place))
    }

    /// The set with each further member in turn, unless one of them had to be what it cannot be.
    fn with_one_more(&self, set: &TrialSet) -> Vec<TrialSet> {
        let mut triangle = Triangle::default();
        if !set.members.iter().all(|&i| self.extend(&mut triangle, i)) {
            return Vec::new();
        }
        let own = triangle.columns().len();
        let taken: Vec<usize> = set.members.iter().map(|&i| self.places[i]).collect();
        let mut further = Vec::new();
        let mut solved = Vec::new();
        for i in (0..self.members.len()).filter(|&i| !taken.contains(&self.places[i])) {
            if self.extend(&mut triangle, i) {
                triangle.solve(&mut solved);
                further.extend(self.trial(set, i, triangle.columns(), &solved));
            }
            triangle.truncate(own);
        }
        further
    }

    /// Adds the columns of a member; `false` if they depend on those that are there.
    fn extend(&self, triangle: &mut Triangle, member: usize) -> bool {
        self.members[member].columns().all(|i| {
            let [precision, mean] = self.expected[i];
            let product = |j: usize| self.products[(i, j)];
            triangle.push(i, product, self.slack(i), self.along[i] + precision * mean)
        })
    }

    /// What is added to a column's product with itself: what is expected of it, and a little
    /// against columns that depend on each other.
    fn slack(&self, column: usize) -> f64 {
        self.expected[column][0] + 1e-9 * self.products[(column, column)] + 1e-12
    }

    /// What least squares says of `set` with the member `new`, whose columns, in this order, have
    /// these coefficients; `None` if one of them had to be what it cannot be.
    fn trial(
        &self,
        set: &TrialSet,
        new: usize,
        columns: &[usize],
        solved: &[f64],
    ) -> Option<TrialSet> {
        let mut plausibility = 0.0;
        let mut freedom = columns.len() as f64;
        let mut at = 0;
        for &i in set.members.iter().chain([&new]) {
            let member = &self.members[i];
            let first = member.candidate.parameters.first();
            if first.is_some_and(|first| !may_be_negative(first)) && solved[at] < MIN_SHARE {
                return None;
            }
            plausibility += member.candidate.plausibility;
            freedom += member.candidate.hidden_freedom;
            at += member.columns;
        }
        // With A x = b: xᵀ P x = xᵀ b − Σ slack x².
        let mut square = self.square;
        let mut penalty = 0.0;
        for (&i, x) in columns.iter().zip(solved) {
            let [precision, mean] = self.expected[i];
            square += x * (precision * mean - self.along[i] - self.slack(i) * x);
            penalty += precision * (x - mean).powi(2);
            let own = self.products[(i, i)];
            freedom -= precision / (precision + own).max(f64::MIN_POSITIVE);
        }
        let square = square.max(1e-9 * self.square).max(f64::MIN_POSITIVE);
        let log_evidence = -0.5 * self.count * (square / self.count).ln()
            - 0.5 * penalty
            - 0.5 * freedom * self.count.ln()
            + plausibility;
        if !log_evidence.is_finite() {
            return None;
        }
        let (before, behind) = set.members.split_at(set.members.partition_point(|&i| i < new));
        Some(TrialSet { members: [before, &[new], behind].concat(), log_evidence })
    }

    /// Coefficients of the columns of a set; `None` where they depend on each other.
    fn coefficients(&self, set: &TrialSet) -> Option<Vec<f64>> {
        let mut triangle = Triangle::default();
        if !set.members.iter().all(|&i| self.extend(&mut triangle, i)) {
            return None;
        }
        let mut solved = Vec::new();
        triangle.solve(&mut solved);
        Some(solved)
    }

    /// The causes of a set beside those that are given.
    fn beside(&self, given: &Hypothesis<'c>, set: &TrialSet) -> Option<Hypothesis<'c>> {
        let mut hypothesis = given.clone();
        hypothesis.effects.extend(self.effects(set, &self.coefficients(set)?));
        Some(hypothesis)
    }

    /// The causes of a set with their parameters.
    fn effects(&self, set: &TrialSet, coefficients: &[f64]) -> Vec<(&'c Candidate, Vec<f64>)> {
        let mut at = 0;
        set.members
            .iter()
            .map(|&i| {
                let member = &self.members[i];
                let own = &coefficients[at..at + member.columns];
                at += member.columns;
                let parameters = member.candidate.parameters.iter().zip(&member.at);
                let inner = parameters
                    .enumerate()
                    .map(|(k, (parameter, &at))| {
                        let moved = match k {
                            0 => scaled(parameter, at, own[0]),
                            _ => at + own[k],
                        };
                        parameter.clamp(moved)
                    })
                    .collect();
                (member.candidate, inner)
            })
            .collect()
    }
}

/// Whether a parameter may lie on either side of "no effect".
fn may_be_negative(parameter: &Parameter) -> bool {
    match parameter.nominal {
        None => false,
        Some(nominal) => parameter.bounds[0] < nominal,
    }
}

/// The parameter, as the fit measures it, whose effect is `share` of that at `at`.
fn scaled(parameter: &Parameter, at: f64, share: f64) -> f64 {
    match (parameter.nominal, parameter.scale) {
        (Some(nominal), _) => {
            let nominal = parameter.inner(nominal);
            nominal + share * (at - nominal)
        }
        // A spring that is absent where it is infinitely stiff: its compliance has the effect.
        (None, Scale::Log) => at - share.ln(),
        (None, Scale::Linear(_)) => at,
    }
}

#[cfg(test)]
mod tests;
