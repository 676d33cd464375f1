//! Fits that were made already: the same causes are fitted again and again, on the way to other
//! sets, beside other noise, without a row, in a fold. Each fit starts where the last one of its
//! causes ended.

use std::collections::HashMap;
use std::ptr;
use std::sync::Mutex;

use rayon::prelude::*;

use super::candidate::Candidate;
use super::fit::Fit;
use super::hypothesis::Hypothesis;
use super::problem::Problem;

/// A fit that is asked for: of some causes from their parameters, and of one more from its starts.
pub(super) struct Asked<'c> {
    given: Hypothesis<'c>,
    added: Option<&'c Candidate>,
}

impl<'c> From<Hypothesis<'c>> for Asked<'c> {
    fn from(given: Hypothesis<'c>) -> Self {
        Self { given, added: None }
    }
}

impl<'c> Asked<'c> {
    pub(super) fn with(given: Hypothesis<'c>, added: &'c Candidate) -> Self {
        Self { given, added: Some(added) }
    }

    fn key(&self) -> Vec<usize> {
        let mut key: Vec<usize> = self.causes().map(place).collect();
        key.sort_unstable();
        key
    }

    fn causes(&self) -> impl Iterator<Item = &'c Candidate> {
        self.given.effects.iter().map(|(candidate, _)| *candidate).chain(self.added)
    }
}

/// By where the candidates of a set lie in memory, ascending, the parameters of each.
type Parameters = HashMap<Vec<usize>, Vec<Vec<f64>>>;

/// What fits found; the same for any number of threads.
#[derive(Debug, Default)]
pub(super) struct Known<'c> {
    parameters: Mutex<Parameters>,
    candidates: std::marker::PhantomData<&'c Candidate>,
}

/// Fits to one table that have converged, by their causes as [`Parameters`] are: asked for again,
/// they are what they were.
#[derive(Debug, Default)]
pub(super) struct Converged<'c>(Mutex<HashMap<Vec<usize>, Fit<'c>>>);

impl<'c> Converged<'c> {
    fn locked(&self) -> std::sync::MutexGuard<'_, HashMap<Vec<usize>, Fit<'c>>> {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// The fit of these causes, in their order.
    fn of(&self, asked: &Asked<'c>) -> Option<Fit<'c>> {
        let mut fit = self.locked().get(&asked.key())?.clone();
        let place_of = |candidate: &Candidate| {
            fit.hypothesis.effects.iter().position(|(own, _)| ptr::eq(*own, candidate))
        };
        let order: Vec<usize> = asked.causes().map(place_of).collect::<Option<_>>()?;
        fit.arrange(&order);
        Some(fit)
    }

    fn keep(&self, key: Vec<usize>, fit: &Fit<'c>) {
        if fit.is_converged {
            self.locked().insert(key, fit.clone());
        }
    }
}

impl Clone for Known<'_> {
    fn clone(&self) -> Self {
        Self { parameters: Mutex::new(self.locked().clone()), ..Self::default() }
    }
}

impl<'c> Known<'c> {
    /// All fits that there are, in the order in which they are asked for.
    pub(super) fn fits(
        &self,
        problem: &Problem<'_>,
        asked: Vec<Asked<'c>>,
        starts: usize,
        converged: &Converged<'c>,
    ) -> Vec<Fit<'c>> {
        // What one fit of these finds must not reach another before all are done.
        let begun: Vec<Option<Hypothesis<'c>>> = {
            let parameters = self.locked();
            asked.iter().map(|asked| from_known(&parameters, asked)).collect()
        };
        let fits: Vec<Option<Fit<'c>>> = asked
            .into_par_iter()
            .zip(begun)
            .map(|(asked, begun)| match (converged.of(&asked), begun) {
                (Some(fit), _) if asked.added.is_some() => Some(fit),
                (Some(fit), _) => {
                    let given = problem.compare(&asked.given);
                    let is_better = given.is_some_and(|own| own.score > fit.evaluation.score);
                    if is_better { problem.optimise(asked.given) } else { Some(fit) }
                }
                (None, Some(begun)) if asked.added.is_some() => problem.optimise(begun),
                (None, Some(begun)) => problem.optimise(better_start(problem, begun, asked.given)),
                (None, None) => problem.fit(&asked.given, asked.added, starts),
            })
            .collect();
        let fits: Vec<Fit<'c>> = fits.into_iter().flatten().collect();
        let mut parameters = self.locked();
        // Of the same causes from several starts the best.
        let mut scores: HashMap<Vec<usize>, f64> = HashMap::new();
        for fit in &fits {
            let mut effects: Vec<(usize, &Vec<f64>)> =
                fit.hypothesis.effects.iter().map(|(c, inner)| (place(c), inner)).collect();
            effects.sort_by_key(|(place, _)| *place);
            let (key, inner): (Vec<usize>, Vec<Vec<f64>>) =
                effects.into_iter().map(|(k, inner)| (k, inner.clone())).unzip();
            let score = fit.evaluation.score;
            if scores.get(&key).is_none_or(|best| score > *best) {
                scores.insert(key.clone(), score);
                converged.keep(key.clone(), fit);
                parameters.insert(key, inner);
            }
        }
        fits
    }

    fn locked(&self) -> std::sync::MutexGuard<'_, Parameters> {
        self.parameters.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// Of two starts of the same causes the one that fits better before anything moves: what was
/// taken from a larger set may stand in a better valley than the last fit of these causes alone.
fn better_start<'c>(problem: &Problem<'_>, a: Hypothesis<'c>, b: Hypothesis<'c>) -> Hypothesis<'c> {
    if a.inner() == b.inner() {
        return a;
    }
    let score = |of: &Hypothesis<'_>| problem.compare(of).map(|found| found.score);
    if score(&b) > score(&a) { b } else { a }
}

fn place(candidate: &Candidate) -> usize {
    ptr::from_ref(candidate).addr()
}

/// The causes with the parameters of their last fit; `None` if there was none.
fn from_known<'c>(parameters: &Parameters, asked: &Asked<'c>) -> Option<Hypothesis<'c>> {
    let key = asked.key();
    let known = parameters.get(&key)?;
    let own = |candidate: &'c Candidate| {
        let at = key.binary_search(&place(candidate)).ok()?;
        Some((candidate, known[at].clone()))
    };
    Some(Hypothesis { effects: asked.causes().map(own).collect::<Option<_>>()? })
}
