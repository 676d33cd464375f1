//! A hypothesis held against a table: residuals as the instrument shows them, sensitivities,
//! likelihood.

use std::ops::Range;

use super::candidate::Candidate;
use super::data::Data;
use super::hypothesis::Hypothesis;
use super::likelihood::{MIN_NOISE, Noise, noise};
use super::predict::{Frequency, Solved};
use super::shapes::{ShapeTerm, paired, terms};
use crate::model::{Cause, Description};
use crate::units::aliased_hz;

/// Scale of the noise with which missed modes are first separated from seen ones.
const FIRST_SCALE: f64 = 0.01;

/// Of parameters with slopes.
pub(super) const ALL: Range<usize> = 0..usize::MAX;
pub(super) const NONE: Range<usize> = 0..0;

/// The problem: a robot's description and a table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Problem<'p> {
    pub(super) description: &'p Description,
    pub(super) data: &'p Data,
}

/// What a hypothesis leaves of the table.
#[derive(Debug, Clone)]
pub(super) struct Left {
    /// ln(measured / predicted), one a point; `None` where the model has no such mode.
    pub(super) residuals: Vec<Option<f64>>,
    /// The same without what noise has in common.
    pub(super) innovations: Vec<Option<f64>>,
    /// d ln(predicted) by each parameter, one row a point, likewise.
    pub(super) slopes: Vec<Vec<f64>>,
    /// How links turn in the modes.
    pub(super) shapes: Vec<ShapeTerm>,
    /// Rows whose modes, by their shapes, are not those of their rank.
    pub(super) out_of_rank: Vec<usize>,
    /// ln likelihood of the shapes and of the modes that were missed.
    ln_of_modes: f64,
}

/// A hypothesis held against the table.
#[derive(Debug, Clone)]
pub(super) struct Evaluation {
    pub(super) left: Left,
    pub(super) noise: Noise,
    /// ln likelihood, with what is expected of the parameters.
    pub(super) score: f64,
}

impl<'p> Problem<'p> {
    /// Residuals, slopes and likelihood of a hypothesis; `None` if it is impossible.
    pub(super) fn evaluate(&self, hypothesis: &Hypothesis<'_>) -> Option<Evaluation> {
        self.evaluate_by(hypothesis, ALL)
    }

    /// The same without slopes.
    pub(super) fn compare(&self, hypothesis: &Hypothesis<'_>) -> Option<Evaluation> {
        self.evaluate_by(hypothesis, NONE)
    }

    /// The same with slopes by some of its parameters.
    fn evaluate_by(
        &self,
        hypothesis: &Hypothesis<'_>,
        parameters: Range<usize>,
    ) -> Option<Evaluation> {
        let left = self.left_by(hypothesis, parameters)?;
        self.judged(hypothesis, left)
    }

    /// A hypothesis that is better than `score`, with slopes; where it is not, none are computed.
    pub(super) fn evaluate_if_better(
        &self,
        hypothesis: &Hypothesis<'_>,
        score: f64,
    ) -> Option<Evaluation> {
        let mut solved = Solved::new(self.description, hypothesis, self.data, ALL)?;
        let compared = self.judged(hypothesis, self.left_of(hypothesis, &mut solved, NONE)?)?;
        if compared.score <= score {
            return None;
        }
        let left = self.left_of(hypothesis, &mut solved, ALL)?;
        Some(Evaluation { left, ..compared })
    }

    fn judged(&self, hypothesis: &Hypothesis<'_>, left: Left) -> Option<Evaluation> {
        let noise = noise(&self.data.points, &left.innovations);
        let score = noise.ln_likelihood
            + left.ln_of_modes
            + self.data.decorrelation.ln_determinant
            + expectation(hypothesis);
        score.is_finite().then_some(Evaluation { left, noise, score })
    }

    /// Residuals of a hypothesis, whatever the noise is, with slopes by some of its parameters;
    /// `None` if it is impossible.
    pub(super) fn left_by(
        &self,
        hypothesis: &Hypothesis<'_>,
        parameters: Range<usize>,
    ) -> Option<Left> {
        let mut solved = Solved::new(self.description, hypothesis, self.data, parameters.clone())?;
        self.left_of(hypothesis, &mut solved, parameters)
    }

    fn left_of(
        &self,
        hypothesis: &Hypothesis<'_>,
        solved: &mut Solved<'_, '_>,
        parameters: Range<usize>,
    ) -> Option<Left> {
        let with_slopes = !parameters.is_empty();
        let rows = solved.frequencies(parameters)?;
        let mut rows = self.seen(hypothesis, rows)?;
        let out_of_rank = paired(self.data, &mut rows);
        let (shapes, of_shapes) = terms(self.data, &rows);
        let missed: Vec<usize> = hypothesis
            .effects
            .iter()
            .filter(|(candidate, _)| candidate.cause == Cause::MissedMode)
            .filter_map(|(candidate, _)| mode_of(candidate))
            .collect();
        let (residuals, mut slopes, prior) = if missed.is_empty() {
            let (residuals, slopes) = self.compared(&mut rows, with_slopes);
            (residuals, slopes, 0.0)
        } else {
            self.compared_with_misses(rows, &missed, with_slopes)
        };
        if residuals.iter().flatten().any(|residual| !residual.is_finite()) {
            return None;
        }
        let decorrelation = &self.data.decorrelation;
        let innovations = decorrelation.of_residuals(&residuals);
        decorrelation.of_slopes(&mut slopes);
        let ln_of_modes = of_shapes + prior;
        Some(Left { residuals, innovations, slopes, shapes, out_of_rank, ln_of_modes })
    }

    /// Frequencies as the instrument shows them: aliased where they are.
    fn seen(
        &self,
        hypothesis: &Hypothesis<'_>,
        mut rows: Vec<Vec<Frequency>>,
    ) -> Option<Vec<Vec<Frequency>>> {
        let mut at = 0;
        for (candidate, inner) in &hypothesis.effects {
            let own = at;
            at += inner.len();
            if candidate.cause != Cause::AliasedMode {
                continue;
            }
            let mode = mode_of(candidate)?;
            let fitted = candidate.parameters.first().map(|p| p.value(inner[0]));
            for (frequencies, row) in rows.iter_mut().zip(&self.data.rows) {
                let Some(rate) = fitted.or(row.sample_rate_hz) else { continue };
                let Some(frequency) = frequencies.get_mut(mode) else { continue };
                let true_hz = frequency.ln_hz.exp();
                if true_hz <= 0.5 * rate {
                    continue;
                }
                let seen_hz = aliased_hz(true_hz, rate).max(1e-3);
                let turns = (true_hz / rate).round();
                let sign = if true_hz >= turns * rate { 1.0 } else { -1.0 };
                for slope in &mut frequency.slope {
                    *slope *= sign * true_hz / seen_hz;
                }
                if let (Some(_), Some(slope)) = (fitted, frequency.slope.get_mut(own)) {
                    // seen = ±(true − turns · rate), and the rate is measured by its logarithm.
                    *slope = -sign * turns * rate / seen_hz;
                }
                frequency.ln_hz = seen_hz.ln();
            }
        }
        for frequencies in &mut rows {
            frequencies.sort_by(|a, b| a.ln_hz.total_cmp(&b.ln_hz));
        }
        Some(rows)
    }

    /// Residuals and, taken out of the rows, slopes.
    fn compared(
        &self,
        rows: &mut [Vec<Frequency>],
        with_slopes: bool,
    ) -> (Vec<Option<f64>>, Vec<Vec<f64>>) {
        let mut residuals = Vec::with_capacity(self.data.points.len());
        let mut slopes = Vec::new();
        for point in &self.data.points {
            let predicted = rows[point.row].get_mut(point.column);
            residuals.push(predicted.as_ref().map(|predicted| point.ln_f - predicted.ln_hz));
            if with_slopes {
                let slope = predicted.map(|predicted| std::mem::take(&mut predicted.slope));
                slopes.push(slope.unwrap_or_default());
            }
        }
        (residuals, slopes)
    }

    /// Row by row, the likelier of a mode seen and a mode missed; with ln of how likely so many
    /// misses are.
    fn compared_with_misses(
        &self,
        mut rows: Vec<Vec<Frequency>>,
        missed: &[usize],
        with_slopes: bool,
    ) -> (Vec<Option<f64>>, Vec<Vec<f64>>, f64) {
        let mut prior = 0.0;
        for &mode in missed {
            let mut shifted: Vec<Vec<Frequency>> = rows
                .iter()
                .map(|row| {
                    let mut row = row.clone();
                    if mode < row.len() {
                        row.remove(mode);
                    }
                    row
                })
                .collect();
            let (as_seen, _) = self.compared(&mut rows, false);
            let (as_missed, _) = self.compared(&mut shifted, false);
            let mut scale = FIRST_SCALE;
            let mut is_missed = vec![false; rows.len()];
            for _ in 0..3 {
                let mut gain = vec![0.0; rows.len()];
                for (i, point) in self.data.points.iter().enumerate() {
                    let cost = |r: Option<f64>| match r {
                        Some(r) => 4.5 * (r * r / (8.0 * scale * scale)).ln_1p(),
                        None => -(scale.ln()) - 0.2,
                    };
                    gain[point.row] += cost(as_seen[i]) - cost(as_missed[i]);
                }
                let price = (rows.len() as f64).ln();
                is_missed = gain.iter().map(|&gain| gain > price).collect();
                let chosen: Vec<Option<f64>> = self
                    .data
                    .points
                    .iter()
                    .enumerate()
                    .map(|(i, p)| if is_missed[p.row] { as_missed[i] } else { as_seen[i] })
                    .collect();
                scale = noise(&self.data.points, &chosen).scale.max(MIN_NOISE);
            }
            let count = is_missed.iter().filter(|&&m| m).count();
            prior += ln_binomial(count, rows.len());
            for ((row, shifted), missed) in rows.iter_mut().zip(shifted).zip(is_missed) {
                if missed {
                    *row = shifted;
                }
            }
        }
        let (residuals, slopes) = self.compared(&mut rows, with_slopes);
        (residuals, slopes, prior)
    }
}

/// The mode, from 0, that a candidate of the instrument is about.
pub(super) fn mode_of(candidate: &Candidate) -> Option<usize> {
    candidate.at.as_deref()?.parse::<usize>().ok()?.checked_sub(1)
}

/// ln of the likeliest binomial probability of `count` in `of`, each row on its own.
fn ln_binomial(count: usize, of: usize) -> f64 {
    let share = |n: usize| {
        let p = n as f64 / of as f64;
        if n == 0 { 0.0 } else { n as f64 * p.ln() }
    };
    share(count) + share(of - count)
}

/// ln of how well the parameters agree with what is expected of them.
fn expectation(hypothesis: &Hypothesis<'_>) -> f64 {
    let mut sum = 0.0;
    for (candidate, inner) in &hypothesis.effects {
        for (parameter, &inner) in candidate.parameters.iter().zip(inner) {
            if let Some((nominal, precision)) = parameter.expectation() {
                sum -= 0.5 * precision * (inner - nominal).powi(2);
            }
        }
    }
    sum
}
