//! Causes, the shape of the noise and rows that are wrong, each in the light of the others: a drift
//! looks like a cause to who knows of no drift, and a cause like common noise to who knows of none.

use super::candidate::Candidate;
use super::choose::{Choice, Means, SearchWidth, choose};
use super::data::Data;
use super::decorrelation::NoiseShape;
use super::fit::Fit;
use super::hypothesis::Hypothesis;
use super::known::Known;
use super::likelihood::noise;
use super::noise::shape_of;
use super::problem::{Evaluation, Problem};
use super::screen::Screen;
use crate::model::Description;

/// Log evidence that a cause costs against another shape of the noise: there are many to choose
/// from.
const PER_CAUSE: f64 = 4.0;

/// What a law of conditions costs beyond that: conditions follow the hours as a drift does, and a
/// law promises figures where nothing was measured.
const PER_LAW_OF_CONDITIONS: f64 = 3.0;

/// Noise of another shape without any cause that is further behind than this is not tried with
/// causes.
const WITHIN: f64 = 15.0;

/// Log evidence by which a shape must be better than noise of each frequency alone.
const SHAPE_BETTER_BY: f64 = 5.0;

/// A shape that was improved by less than this is not tried again.
const IMPROVED: f64 = 2.0;

/// A row is wrong where its frequencies are off by this many times the noise, root mean square,
const WRONG: f64 = 6.0;

/// and a second one of them by this many,
const SECOND_WRONG: f64 = 4.0;

/// or, where it has just one, that by this many.
pub(super) const ALONE_WRONG: f64 = 12.0;

/// More rows than one in so many are no slips.
const ROWS_PER_SLIP: usize = 10;

/// What a table says in all.
pub(super) struct Settled<'c> {
    /// Without the rows that are wrong, with the shape of its noise.
    pub(super) data: Data,
    pub(super) choice: Choice<'c>,
    /// Rows set aside, as the table counts them, from 0.
    pub(super) suspects: Vec<usize>,
}

/// What is asked.
struct Question<'q, 'c> {
    description: &'q Description,
    candidates: &'c [Candidate],
    screen: &'q Screen,
    known: &'q Known<'c>,
}

/// Chooses causes, noise and rows; `None` if the model has no modes.
pub(super) fn settled<'c>(
    description: &Description,
    data: Data,
    candidates: &'c [Candidate],
    screen: &Screen,
    known: &Known<'c>,
) -> Option<Settled<'c>> {
    let question = Question { description, candidates, screen, known };
    let first = question.choose(&data)?;
    let (data, choice, suspects) = question.without_wrong_rows(data, first)?;
    let (data, choice) = question.with_noise(data, choice)?;
    Some(Settled { data, choice, suspects })
}

impl<'c> Question<'_, 'c> {
    fn choose(&self, data: &Data) -> Option<Choice<'c>> {
        let problem = Problem { description: self.description, data };
        let Self { candidates, screen, known, .. } = *self;
        choose(&problem, Means { candidates, screen, width: SearchWidth::FULL, known })
    }

    /// Sets wrong rows aside, the worst first, as long as each is as wrong without it.
    fn without_wrong_rows(
        &self,
        all: Data,
        first: Choice<'c>,
    ) -> Option<(Data, Choice<'c>, Vec<usize>)> {
        let most = (all.rows.len() / ROWS_PER_SLIP).max(1);
        let mut aside: Vec<usize> = Vec::new();
        let (mut data, mut choice) = (all.clone(), first.clone());
        while let Some(row) = worst(&data, &choice.best.fit.evaluation, is_wrong) {
            let index = data.rows[row].index;
            if aside.len() == most {
                // So many are no slips but something that nobody knows.
                return Some((all, first, Vec::new()));
            }
            let less = data.only(|other| other != row);
            let again = self.choose(&less)?;
            if !self.is_wrong_by(&all, &less, &again.best.fit, index) {
                break;
            }
            aside.push(index);
            (data, choice) = (less, again);
        }
        aside.sort_unstable();
        Some((data, choice, aside))
    }

    /// Whether the row `index` is wrong by a fit to `less`, which lacks it.
    fn is_wrong_by(&self, all: &Data, less: &Data, fit: &Fit<'_>, index: usize) -> bool {
        let problem = Problem { description: self.description, data: all };
        let scale = fit.evaluation.noise.scale;
        let Some(evaluation) = problem.compare(&fit.hypothesis) else { return false };
        let off = all.points.iter().zip(&evaluation.left.residuals);
        let off = off.filter(|(point, _)| all.rows[point.row].index == index);
        let off: Vec<f64> = off
            .filter_map(|(p, r)| Some(r.as_ref()? / (scale * p.unit).hypot(p.rounding.sqrt())))
            .collect();
        less.points.len() > fit.hypothesis.inner().len() + 2 && is_wrong(&off)
    }

    /// The causes under the noise that the table shows: as residuals of the model as it is show
    /// it, or of the model with the causes that were found so far.
    fn with_noise(&self, data: Data, plain: Choice<'c>) -> Option<(Data, Choice<'c>)> {
        let evidence = |data: &Data, choice: &Choice<'_>| {
            choice.best.log_evidence - data.shape.cost - price(&choice.best.fit.hypothesis)
        };
        let mut best = (evidence(&data, &plain), data.clone(), plain.clone());
        let mut tried: Vec<NoiseShape> = vec![NoiseShape::plain()];
        for round in 0..4 {
            let from: Fit<'c> = match round {
                0 => plain.baseline.clone(),
                3 => match self.without_laws_of_conditions(&best.1, &best.2) {
                    Some(from) => from,
                    None => continue,
                },
                _ => best.2.best.fit.clone(),
            };
            // A shape that takes the place of a cause is held against the cause alone.
            let takes_a_place = from.hypothesis.effects.len() < best.2.best.causes();
            let better_by = if takes_a_place { 0.0 } else { SHAPE_BETTER_BY };
            let shape = shape_of(&data, &from.evaluation.left.residuals, better_by);
            let Some(shape) = shape else { continue };
            if tried.contains(&shape) || round == 3 && shape.drift == 0.0 {
                continue;
            }
            tried.push(shape.clone());
            let shaped = data.shaped(shape);
            let problem = Problem { description: self.description, data: &shaped };
            let alone = problem.compare(&from.hypothesis)?;
            let plausibility: f64 =
                from.hypothesis.effects.iter().map(|(c, _)| c.plausibility).sum();
            let of_freedom = 0.5 * from.freedom * (data.points.len() as f64).ln();
            let promised = alone.score + plausibility
                - of_freedom
                - shaped.shape.cost
                - price(&from.hypothesis);
            let least = match round {
                0 | 3 => best.0 - WITHIN,
                _ => best.0 + IMPROVED,
            };
            if promised < least {
                continue;
            }
            let choice = self.choose(&shaped)?;
            let found = evidence(&shaped, &choice);
            if found > best.0 {
                best = (found, shaped, choice);
            }
        }
        Some((best.1, best.2))
    }
}

impl<'c> Question<'_, 'c> {
    /// The best model without laws of conditions, which may rise with the rows as a hall warms up:
    /// a drift may be all that there is. `None` if it has no such law.
    fn without_laws_of_conditions(&self, data: &Data, choice: &Choice<'c>) -> Option<Fit<'c>> {
        let mut hypothesis = choice.best.fit.hypothesis.clone();
        let count = hypothesis.effects.len();
        hypothesis.effects.retain(|(candidate, _)| !candidate.cause.is_of_conditions());
        let problem = Problem { description: self.description, data };
        (hypothesis.effects.len() < count).then(|| problem.optimise(hypothesis)).flatten()
    }
}

/// What causes cost against another shape of the noise.
fn price(hypothesis: &Hypothesis<'_>) -> f64 {
    let laws = hypothesis.effects.iter().filter(|(c, _)| c.cause.is_of_conditions()).count();
    PER_CAUSE * hypothesis.effects.len() as f64 + PER_LAW_OF_CONDITIONS * laws as f64
}

/// The row that is most off, if `is_wrong` says of one by how many times the noise of the others
/// its frequencies are off that it is wrong.
pub(super) fn worst(
    data: &Data,
    evaluation: &Evaluation,
    is_wrong: impl Fn(&[f64]) -> bool,
) -> Option<usize> {
    /// No row of a table of some size has more of its noise than this.
    const SHARE_OF_ONE: f64 = 0.5;
    let off = |row: usize, scale: f64| -> Vec<f64> {
        let points =
            data.points.iter().zip(&evaluation.left.residuals).filter(|(p, _)| p.row == row);
        points
            .filter_map(|(p, r)| Some(r.as_ref()? / (scale * p.unit).hypot(p.rounding.sqrt())))
            .collect()
    };
    let of_row = |row: usize| -> Option<(f64, usize)> {
        let others: Vec<Option<f64>> = data
            .points
            .iter()
            .zip(&evaluation.left.residuals)
            .map(|(point, r)| r.filter(|_| point.row != row))
            .collect();
        let off = off(row, noise(&data.points, &others).scale);
        is_wrong(&off).then(|| (crate::statistics::rms(off), row))
    };
    let is_large = data.rows.len() > 50;
    let least_scale = SHARE_OF_ONE * evaluation.noise.scale;
    let may_be_wrong = |row: &usize| !is_large || is_wrong(&off(*row, least_scale));
    let wrong = (0..data.rows.len()).filter(may_be_wrong).filter_map(of_row);
    wrong.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, row)| row)
}

/// Whether frequencies of one row that are off by these many times the noise make it wrong.
fn is_wrong(off: &[f64]) -> bool {
    let mut sizes: Vec<f64> = off.iter().map(|z| z.abs()).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    match sizes[..] {
        [] => false,
        [one] => one > ALONE_WRONG,
        [_, second, ..] => {
            second > SECOND_WRONG && crate::statistics::rms(sizes.iter().copied()) > WRONG
        }
    }
}

/// Whether a row is no noise: it is wrong, or one of its frequencies is far off, as where a mode
/// enters that the model lacks. Such a row is not set aside.
pub(super) fn is_no_noise(off: &[f64]) -> bool {
    is_wrong(off) || off.iter().any(|z| z.abs() > ALONE_WRONG)
}
