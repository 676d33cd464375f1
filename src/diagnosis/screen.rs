//! What each candidate does to the frequencies, once and for all: to be tried on what a model
//! leaves without solving an eigenproblem again.

use nalgebra::{DMatrix, DVectorView};
use rayon::prelude::*;

use super::candidate::Candidate;
use super::fit::{Fit, normal_equations};
use super::hypothesis::Hypothesis;
use super::likelihood::ln_likelihood_near;
use super::problem::{Evaluation, NONE, Problem};
use super::statistics::rms;

/// Starts of a candidate that are tried: all of a new spring's, and some of its other parameters.
const MOST_STARTS: usize = 24;

/// Typical effect of a cause on the frequencies, root mean square.
const TYPICAL: f64 = 0.05;

/// ln f as predicted, one a point of the whole table; `None` where there is no such mode.
type Prediction = Vec<Option<f64>>;

/// What every candidate does from each of its starts.
#[derive(Debug)]
pub(super) struct Screen {
    plain: Prediction,
    /// By candidate: parameters from which a fit may start, and what they do.
    moved: Vec<Vec<(Vec<f64>, Prediction)>>,
}

impl Screen {
    /// Tries every candidate on the whole table.
    pub(super) fn new(problem: &Problem<'_>, candidates: &[Candidate]) -> Option<Self> {
        let predicted = |hypothesis: &Hypothesis<'_>| -> Option<Prediction> {
            let left = problem.left_by(hypothesis, NONE)?;
            let points = problem.data.points.iter();
            Some(points.zip(left.residuals).map(|(p, r)| Some(p.ln_f - r?)).collect())
        };
        let moved = candidates
            .par_iter()
            .map(|candidate| {
                if candidate.cause.is_of_the_instrument() {
                    return Vec::new();
                }
                let mut starts = candidate.starts();
                thin(&mut starts, MOST_STARTS);
                starts
                    .into_iter()
                    .filter_map(|inner| {
                        let moved =
                            predicted(&Hypothesis { effects: vec![(candidate, inner.clone())] })?;
                        Some((inner, moved))
                    })
                    .collect()
            })
            .collect();
        Some(Self { plain: predicted(&Hypothesis::default())?, moved })
    }

    /// The start of the candidate `which` that moves the frequencies by about a typical cause's
    /// share of them; of the instrument none does.
    pub(super) fn typical_start(&self, which: usize) -> Option<Vec<f64>> {
        let size = |moved: &Prediction| {
            let both = moved.iter().zip(&self.plain);
            rms(both.map(|(moved, plain)| Some((*moved)? - (*plain)?)).collect::<Vec<_>>().iter())
        };
        self.moved[which]
            .iter()
            .map(|(inner, moved)| (inner, size(moved)))
            .filter(|(inner, size)| *size > 1e-9 || inner.is_empty())
            .min_by(|a, b| {
                let far = |size: f64| (size / TYPICAL).ln().abs();
                far(a.1).total_cmp(&far(b.1))
            })
            .map(|(inner, _)| inner.clone())
    }

    /// What candidates may add to a fit.
    pub(super) fn beside<'s, 'c>(
        &'s self,
        problem: &'s Problem<'s>,
        parent: &'s Fit<'c>,
    ) -> Beside<'s, 'c> {
        let (information, _) = normal_equations(&parent.hypothesis, &parent.evaluation);
        let p = information.nrows();
        let inverse = (information + DMatrix::from_diagonal_element(p, p, 1e-9)).try_inverse();
        let Evaluation { left, noise, .. } = &parent.evaluation;
        let mut rows = Vec::with_capacity(left.innovations.len() * (2 + p));
        let both = left.innovations.iter().zip(&noise.weights).zip(&left.slopes);
        for ((r, weight), slopes) in both {
            let weight = if r.is_some() { *weight } else { 0.0 };
            rows.extend([weight, weight * r.unwrap_or(0.0)]);
            rows.extend((0..p).map(|k| weight * slopes.get(k).unwrap_or(&0.0)));
        }
        Beside { screen: self, problem, parent, inverse, rows }
    }
}

/// A fit to which a candidate is to be added.
pub(super) struct Beside<'s, 'c> {
    screen: &'s Screen,
    problem: &'s Problem<'s>,
    parent: &'s Fit<'c>,
    /// Covariance of the fit's parameters; `None` where the data do not part them.
    inverse: Option<DMatrix<f64>>,
    /// By point: its weight, and that times what the fit leaves and times each slope.
    rows: Vec<f64>,
}

impl<'c> Beside<'_, 'c> {
    /// What ln likelihood the candidate `which` may gain on the fit, at its starts and along the
    /// way to them.
    pub(super) fn expected_gain(&self, which: usize, candidate: &'c Candidate) -> f64 {
        let Self { screen, problem, parent, inverse, rows } = self;
        let before = &parent.evaluation;
        let cost = 0.5 * candidate.parameters.len() as f64;
        if candidate.cause.is_of_the_instrument() {
            // Aliased and missed modes are no small changes, and there are few of them.
            let mut hypothesis = parent.hypothesis.clone();
            let best = candidate.starts().into_iter().filter_map(|inner| {
                hypothesis.effects.truncate(parent.hypothesis.effects.len());
                hypothesis.effects.push((candidate, inner));
                Some(problem.compare(&hypothesis)?.score - before.score)
            });
            return best.fold(f64::NEG_INFINITY, f64::max) - cost;
        }
        let points = &problem.data.points;
        let decorrelation = &problem.data.decorrelation;
        let left = &before.left;
        let p = parent.hypothesis.inner().len();
        let mut best = f64::NEG_INFINITY;
        let mut effect = Vec::with_capacity(points.len());
        let mut residuals = Vec::with_capacity(points.len());
        let mut sums = vec![0.0; 2 + p];
        for (_, moved) in &screen.moved[which] {
            effect.clear();
            let mut is_known = true;
            effect.extend(points.iter().zip(&left.residuals).map(|(point, residual)| {
                match (screen.plain[point.index], moved[point.index], residual) {
                    (Some(plain), Some(moved), Some(_)) => moved - plain,
                    _ => {
                        is_known = false;
                        0.0
                    }
                }
            }));
            residuals.clear();
            if !is_known {
                residuals = decorrelation.of_residuals(&self.residuals_with(moved));
            }
            decorrelation.apply(&mut effect);
            if is_known {
                let both = left.innovations.iter().zip(&effect);
                residuals.extend(both.map(|(r, s)| Some((*r)? - s)));
            }
            let with = ln_likelihood_near(before.noise.scale, points, &residuals);
            best = best.max(with - before.noise.ln_likelihood);
            sums.fill(0.0);
            for (&s, row) in effect.iter().zip(rows.chunks_exact(2 + p)) {
                sums[0] += row[0] * s * s;
                for (sum, own) in sums[1..].iter_mut().zip(&row[1..]) {
                    *sum += s * own;
                }
            }
            let (mut square, product) = (sums[0], sums[1]);
            if let Some(inverse) = inverse {
                let along = DVectorView::from_slice(&sums[2..], p);
                square -= along.dot(&(inverse * along));
            }
            if square > 1e-9 {
                best = best.max(0.5 * product * product / square);
            }
        }
        best - cost
    }

    /// What would be left with a candidate at a start, whose modes are not all those of the fit.
    fn residuals_with(&self, moved: &Prediction) -> Vec<Option<f64>> {
        let both = self.problem.data.points.iter().zip(&self.parent.evaluation.left.residuals);
        let with = both.map(|(point, residual)| {
            match (self.screen.plain[point.index], moved[point.index], residual) {
                (Some(plain), Some(moved), Some(r)) => Some(r - (moved - plain)),
                (_, Some(moved), None) => Some(point.ln_f - moved),
                (_, _, r) => *r,
            }
        });
        with.collect()
    }
}

/// At most `count` of the starts, evenly.
fn thin(starts: &mut Vec<Vec<f64>>, count: usize) {
    if starts.len() <= count {
        return;
    }
    let of = starts.len();
    *starts = (0..count).map(|i| starts[i * (of - 1) / (count - 1).max(1)].clone()).collect();
}
