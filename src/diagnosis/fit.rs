//! Causes fitted to a table: weighted least squares in a trust region (Levenberg–Marquardt) with
//! the weights of the noise, from several starts.

use nalgebra::{DMatrix, DVector};

use super::candidate::Candidate;
use super::hypothesis::Hypothesis;
use super::problem::{ALL, Evaluation, Left, Problem};
use super::shapes::ShapeTerm;

/// Rounds after which one of several starts is chosen.
const FIRST_ROUNDS: usize = 4;

/// The least that a step leaves of the damping. The rule is Nielsen's (Damping Parameter in
/// Marquardt's Method, Technical University of Denmark, 1999), who leaves a third.
const MIN_DAMPING_RATIO: f64 = 0.1;

/// Trust region: no parameter moves further in one step than by a factor of four, or by 1.4 of its
/// units.
const MAX_STEP: f64 = 1.4;

/// A fit ends where the next step is expected to gain less of ln likelihood.
const MIN_GAIN: f64 = 2e-3;

/// The same of fits whose digits are reported.
const NO_GAIN: f64 = 1e-9;

/// A fitted hypothesis.
#[derive(Debug, Clone)]
pub(super) struct Fit<'c> {
    pub(super) hypothesis: Hypothesis<'c>,
    pub(super) evaluation: Evaluation,
    /// Degrees of freedom that the parameters take: less than their number where the data say
    /// little.
    pub(super) freedom: f64,
    /// Whether no further step gains anything worth it.
    pub(super) is_converged: bool,
}

impl Fit<'_> {
    /// Puts the causes in another order, their parameters with them: first the one at `order[0]`.
    pub(super) fn arrange(&mut self, order: &[usize]) {
        let effects = &self.hypothesis.effects;
        let mut starts = vec![0];
        starts.extend(effects.iter().scan(0, |at, (_, inner)| {
            *at += inner.len();
            Some(*at)
        }));
        let columns: Vec<usize> = order.iter().flat_map(|&i| starts[i]..starts[i + 1]).collect();
        self.hypothesis.effects = order.iter().map(|&i| effects[i].clone()).collect();
        let of_shapes = self.evaluation.left.shapes.iter_mut().map(|shape| &mut shape.slope);
        let slopes = self.evaluation.left.slopes.iter_mut().chain(of_shapes);
        // A point without prediction has no slopes.
        for slopes in slopes.filter(|s| !s.is_empty()) {
            *slopes = columns.iter().map(|&column| slopes[column]).collect();
        }
    }

    /// Puts the cause that came last at place `i`, its parameters with it.
    pub(super) fn move_last_to(&mut self, i: usize) {
        let effects = &mut self.hypothesis.effects;
        let Some(last) = effects.pop() else { return };
        let at: usize = effects[..i].iter().map(|(_, inner)| inner.len()).sum();
        let count = last.1.len();
        effects.insert(i, last);
        let of_shapes = self.evaluation.left.shapes.iter_mut().map(|shape| &mut shape.slope);
        let slopes = self.evaluation.left.slopes.iter_mut().chain(of_shapes);
        // A point without prediction has no slopes.
        for slopes in slopes.filter(|s| s.len() >= at + count) {
            slopes[at..].rotate_right(count);
        }
    }
}

impl Problem<'_> {
    /// The best fit of the causes of `given`, from their parameters, and of `added`, if given, from
    /// the most candidates of its starts.
    pub(super) fn fit<'c>(
        &self,
        given: &Hypothesis<'c>,
        added: Option<&'c Candidate>,
        starts: usize,
    ) -> Option<Fit<'c>> {
        let hypotheses: Vec<Hypothesis<'c>> = match added {
            None => vec![given.clone()],
            Some(candidate) => candidate
                .starts()
                .into_iter()
                .map(|inner| {
                    let mut hypothesis = given.clone();
                    hypothesis.effects.push((candidate, inner));
                    hypothesis
                })
                .collect(),
        };
        let mut candidates: Vec<(f64, Hypothesis<'c>)> = if hypotheses.len() == 1 {
            hypotheses.into_iter().map(|hypothesis| (0.0, hypothesis)).collect()
        } else {
            let without = self.left_by(given, ALL)?;
            let score = |hypothesis: Hypothesis<'c>| {
                Some((self.first_order_score(given, &without, &hypothesis)?, hypothesis))
            };
            hypotheses.into_iter().filter_map(score).collect()
        };
        candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
        candidates.truncate(starts);
        if candidates.len() > 1 {
            // A few rounds show which start leads further.
            let begun = candidates
                .into_iter()
                .filter_map(|(_, start)| self.levenberg_marquardt(start, FIRST_ROUNDS, MIN_GAIN));
            let best = begun.max_by(|a, b| a.evaluation.score.total_cmp(&b.evaluation.score))?;
            return self.optimise(best.hypothesis);
        }
        self.optimise(candidates.pop()?.1)
    }

    /// ln likelihood of a hypothesis once the parameters of the causes of `given` have given way to
    /// the one beside them, to first order: a cause that takes from another looks bad until the
    /// other has given way. What the parameters do is taken from where that one is not: `without`.
    fn first_order_score(
        &self,
        given: &Hypothesis<'_>,
        without: &Left,
        hypothesis: &Hypothesis<'_>,
    ) -> Option<f64> {
        let evaluation = self.compare(hypothesis)?;
        let (information, gradient) = normal_equations_by(given, &evaluation, without);
        let damping = (information.diagonal() * 1e-3).add_scalar(1e-12);
        let damped = information + DMatrix::from_diagonal(&damping);
        let gain = damped.cholesky().map_or(0.0, |c| 0.5 * gradient.dot(&c.solve(&gradient)));
        Some(evaluation.score + gain)
    }

    /// Levenberg–Marquardt from a start.
    pub(super) fn optimise<'c>(&self, start: Hypothesis<'c>) -> Option<Fit<'c>> {
        self.levenberg_marquardt(start, 25, MIN_GAIN)
    }

    /// The same until nothing is left to gain: digits that are reported must not depend on where a
    /// fit began.
    pub(super) fn converged<'c>(&self, start: Hypothesis<'c>) -> Option<Fit<'c>> {
        self.levenberg_marquardt(start, 25, NO_GAIN)
    }

    fn levenberg_marquardt<'c>(
        &self,
        start: Hypothesis<'c>,
        max_rounds: usize,
        min_gain: f64,
    ) -> Option<Fit<'c>> {
        let mut hypothesis = start;
        let mut evaluation = self.evaluate(&hypothesis)?;
        // As a share of the information's diagonal.
        let (mut damping, mut growth) = (1e-3_f64, 2.0);
        let mut is_converged = false;
        'rounds: for _ in 0..max_rounds {
            let inner = hypothesis.inner();
            let (information, gradient) = normal_equations(&hypothesis, &evaluation);
            // Each step that fails is followed by one that is damped more.
            for _ in 0..8 {
                let next = step(&hypothesis, &inner, &information, &gradient, damping);
                let moved = DVector::from_vec(next.inner()) - DVector::from_column_slice(&inner);
                let predicted = gradient.dot(&moved) - 0.5 * moved.dot(&(&information * &moved));
                // Also where nothing can move.
                if predicted.is_nan() || predicted <= min_gain {
                    is_converged = true;
                    break 'rounds;
                }
                match self.evaluate_if_better(&next, evaluation.score) {
                    Some(better) => {
                        let kept = (better.score - evaluation.score) / predicted;
                        damping *= (1.0 - (2.0 * kept - 1.0).powi(3)).max(MIN_DAMPING_RATIO);
                        damping = damping.max(1e-9);
                        growth = 2.0;
                        hypothesis = next;
                        evaluation = better;
                        continue 'rounds;
                    }
                    None => {
                        damping *= growth;
                        growth *= 2.0;
                    }
                }
            }
            is_converged = true;
            break;
        }
        let freedom = freedom(&hypothesis, &evaluation);
        Some(Fit { hypothesis, evaluation, freedom, is_converged })
    }
}

/// Fisher information with what is expected, and the gradient of the score.
pub(super) fn normal_equations(
    hypothesis: &Hypothesis<'_>,
    evaluation: &Evaluation,
) -> (DMatrix<f64>, DVector<f64>) {
    normal_equations_by(hypothesis, evaluation, &evaluation.left)
}

/// The same with slopes that were computed elsewhere; a point that has none there counts for
/// nothing.
fn normal_equations_by(
    hypothesis: &Hypothesis<'_>,
    evaluation: &Evaluation,
    by: &Left,
) -> (DMatrix<f64>, DVector<f64>) {
    let inner = hypothesis.inner();
    let p = inner.len();
    let mut information = DMatrix::zeros(p, p);
    let mut gradient = DVector::zeros(p);
    let innovations = evaluation.left.innovations.iter();
    for ((residual, slope), weight) in innovations.zip(&by.slopes).zip(&evaluation.noise.weights) {
        let Some(residual) = residual.filter(|_| slope.len() == p) else { continue };
        for i in 0..p {
            gradient[i] += weight * slope[i] * residual;
            for j in 0..p {
                information[(i, j)] += weight * slope[i] * slope[j];
            }
        }
    }
    let shapes = &evaluation.left.shapes;
    let both = shapes.iter().zip(&by.shapes).filter(|_| shapes.len() == by.shapes.len());
    for (shape, ShapeTerm { slope, .. }) in both {
        for (i, own) in slope.iter().enumerate() {
            gradient[i] += shape.weight * own * shape.residual;
            for (j, other) in slope.iter().enumerate() {
                information[(i, j)] += shape.weight * own * other;
            }
        }
    }
    let parameters = hypothesis.effects.iter().flat_map(|(candidate, _)| &candidate.parameters);
    for (i, parameter) in parameters.enumerate() {
        if let Some((nominal, precision)) = parameter.expectation() {
            information[(i, i)] += precision;
            gradient[i] -= precision * (inner[i] - nominal);
        }
    }
    (information, gradient)
}

/// tr[J'WJ (J'WJ + P)⁻¹], with what hidden choices the candidates take.
fn freedom(hypothesis: &Hypothesis<'_>, evaluation: &Evaluation) -> f64 {
    let (information, _) = normal_equations(hypothesis, evaluation);
    let p = information.nrows();
    let mut freedom: f64 =
        hypothesis.effects.iter().map(|(candidate, _)| candidate.hidden_freedom).sum();
    freedom += p as f64;
    let parameters = hypothesis.effects.iter().flat_map(|(candidate, _)| &candidate.parameters);
    let precision: Vec<f64> =
        parameters.map(|parameter| parameter.expectation().map_or(0.0, |e| e.1)).collect();
    if let Some(inverse) = (information + DMatrix::from_diagonal_element(p, p, 1e-12)).try_inverse()
    {
        for (i, precision) in precision.iter().enumerate() {
            freedom -= (precision * inverse[(i, i)]).clamp(0.0, 1.0);
        }
    }
    freedom
}

/// One damped step from the parameters `inner`: the least of the quadratic model, held within the
/// bounds and within [`MAX_STEP`] by an active set. What would pass furthest stops at its limit,
/// and the rest is solved again.
fn step<'c>(
    hypothesis: &Hypothesis<'c>,
    inner: &[f64],
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> Hypothesis<'c> {
    let parameters = hypothesis.effects.iter().flat_map(|(candidate, _)| &candidate.parameters);
    let limits: Vec<[f64; 2]> = parameters
        .zip(inner)
        .map(|(parameter, &at)| {
            let reach = |by: f64| parameter.clamp(at + by) - at;
            [reach(-MAX_STEP), reach(MAX_STEP)]
        })
        .collect();
    let p = inner.len();
    let mut damped = information.clone();
    for i in 0..p {
        damped[(i, i)] += damping * information[(i, i)].max(1e-12) + 1e-12;
    }
    let mut moved = DVector::zeros(p);
    let mut free: Vec<usize> = (0..p).collect();
    while !free.is_empty() {
        // What the parameters that have stopped leave of the gradient; free ones have not moved
        // yet.
        let left = (gradient - &damped * &moved).select_rows(&free);
        let Some(cholesky) = damped.select_rows(&free).select_columns(&free).cholesky() else {
            break;
        };
        let own = cholesky.solve(&left);
        let beyond = |k: usize| {
            let [low, high] = limits[free[k]];
            (low - own[k]).max(own[k] - high)
        };
        let worst = (0..free.len()).max_by(|&a, &b| beyond(a).total_cmp(&beyond(b))).unwrap_or(0);
        if beyond(worst) > 0.0 {
            let i = free.remove(worst);
            moved[i] = own[worst].clamp(limits[i][0], limits[i][1]);
            continue;
        }
        for (&i, step) in free.iter().zip(own.iter()) {
            moved[i] = *step;
        }
        break;
    }
    let next: Vec<f64> = inner.iter().zip(moved.iter()).map(|(at, by)| at + by).collect();
    hypothesis.with(&next)
}

#[cfg(test)]
pub(super) mod tests;
