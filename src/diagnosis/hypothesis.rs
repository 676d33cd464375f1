//! A hypothesis: causes with their parameters.

use super::candidate::Candidate;
use crate::model::{Cause, Correction};

/// Causes with their parameters, as the fit measures them.
#[derive(Debug, Clone, Default)]
pub(super) struct Hypothesis<'c> {
    pub(super) effects: Vec<(&'c Candidate, Vec<f64>)>,
}

impl<'c> Hypothesis<'c> {
    /// All parameters in a row.
    pub(super) fn inner(&self) -> Vec<f64> {
        self.effects.iter().flat_map(|(_, inner)| inner.iter().copied()).collect()
    }

    /// The same causes with other parameters.
    pub(super) fn with(&self, inner: &[f64]) -> Self {
        let mut at = 0;
        let effects = self
            .effects
            .iter()
            .map(|(candidate, old)| {
                let own = inner[at..at + old.len()].to_vec();
                at += old.len();
                (*candidate, own)
            })
            .collect();
        Self { effects }
    }

    /// Those of its causes that `cause` is not.
    pub(super) fn without(&self, cause: Cause) -> Self {
        let others = self.effects.iter().filter(|(candidate, _)| candidate.cause != cause);
        Self { effects: others.cloned().collect() }
    }

    /// Its causes that put another mode into a column.
    pub(super) fn that_move_columns(&self) -> Self {
        let own = self.effects.iter().filter(|(candidate, _)| candidate.moves_columns());
        Self { effects: own.cloned().collect() }
    }

    /// What the causes put into the model.
    pub(super) fn corrections(&self) -> Vec<Correction> {
        self.effects.iter().map(|(candidate, inner)| candidate.correction(inner)).collect()
    }
}
