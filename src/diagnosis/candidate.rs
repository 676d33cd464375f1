//! A candidate: one cause at one place, with the parameters that a fit may move.

use crate::model::{Cause, Correction, Hinge};

/// How a parameter is measured inside a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scale {
    /// By its logarithm: it is positive.
    Log,
    /// By its value over this unit.
    Linear(f64),
}

/// A parameter of a candidate, with physical bounds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parameter {
    pub(super) name: &'static str,
    pub(super) scale: Scale,
    /// The value in the robot's file; `None` where no finite value means "no effect".
    pub(super) nominal: Option<f64>,
    /// Smallest and largest value.
    pub(super) bounds: [f64; 2],
    /// Values from which a fit starts.
    pub(super) starts: Vec<f64>,
    /// Where it is expected before looking, and with what standard deviation, in value; `None`
    /// where the bounds say all.
    pub(super) expected: Option<[f64; 2]>,
}

impl Parameter {
    /// The value as the fit measures it.
    pub(super) fn inner(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Log => value.max(f64::MIN_POSITIVE).ln(),
            Scale::Linear(unit) => value / unit,
        }
    }

    /// The value from what the fit measures.
    pub(super) fn value(&self, inner: f64) -> f64 {
        match self.scale {
            Scale::Log => inner.exp(),
            Scale::Linear(unit) => inner * unit,
        }
    }

    /// Within the bounds.
    pub(super) fn clamp(&self, inner: f64) -> f64 {
        let [low, high] = self.bounds.map(|bound| self.inner(bound));
        inner.clamp(low, high)
    }

    /// Whether a fit ended where the search does, and not where physics does: nothing below zero,
    /// and no more mass taken off than there is.
    pub(super) fn is_at_bound(&self, inner: f64) -> bool {
        let [low, high] = self.bounds.map(|bound| self.inner(bound));
        let is_at = |bound: f64| (inner - bound).abs() <= 1e-9 * (1.0 + bound.abs());
        is_at(high) || is_at(low) && self.bounds[0] != 0.0 && self.name != "mass_kg"
    }

    /// What is expected: (as the fit measures it, 1/variance).
    pub(super) fn expectation(&self) -> Option<(f64, f64)> {
        let [mean, spread] = self.expected?;
        let deviation = match self.scale {
            Scale::Log => spread / mean,
            Scale::Linear(unit) => spread / unit,
        };
        Some((self.inner(mean), deviation.powi(-2)))
    }
}

/// One cause at one place in one form.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    pub(super) cause: Cause,
    pub(super) at: Option<String>,
    /// Other names of the same place.
    pub(super) also: Vec<String>,
    pub(super) parameters: Vec<Parameter>,
    /// Values that a correction needs and that no fit moves.
    pub(super) fixed: Vec<(&'static str, f64)>,
    pub(super) hinge: Option<Hinge>,
    /// Whether it is a form that has to earn its place against plainer ones of the same place.
    pub(super) is_refinement: bool,
    /// ln of how much less likely the cause is there than others, before looking: 0 for the usual
    /// ones.
    pub(super) plausibility: f64,
    /// How many degrees of freedom it takes beside its parameters.
    pub(super) hidden_freedom: f64,
}

impl Candidate {
    /// A candidate with nothing special about it.
    pub(super) fn new(cause: Cause, at: &str, parameters: Vec<Parameter>) -> Self {
        Self {
            cause,
            at: Some(at.to_owned()),
            also: Vec::new(),
            parameters,
            fixed: Vec::new(),
            hinge: None,
            is_refinement: false,
            plausibility: 0.0,
            hidden_freedom: 0.0,
        }
    }

    /// The same as a form that has to earn its place.
    pub(super) fn refining(self) -> Self {
        Self { is_refinement: true, ..self }
    }

    /// Whether it puts another mode into a column of the table: no small change, of which a linear
    /// problem says nothing.
    pub(super) fn moves_columns(&self) -> bool {
        self.cause.is_of_the_instrument() || self.cause == Cause::LocalMode
    }

    /// Whether both name the same cause at the same place.
    pub(super) fn same_place(&self, other: &Self) -> bool {
        self.cause == other.cause && self.at == other.at
    }

    /// Whether it says what else the stiffness depends on that `plain` is.
    pub(super) fn is_law_over(&self, plain: &Self) -> bool {
        let is_law = matches!(
            self.cause,
            Cause::LoadDependentStiffness
                | Cause::PositionDependentStiffness
                | Cause::AmplitudeDependence
                | Cause::TemperatureDrift
        );
        is_law && plain.cause == Cause::JointStiffness && plain.at == self.at
    }

    /// Whether it is `other` with further parameters of which something is expected.
    pub(super) fn widens(&self, other: &Self) -> bool {
        let has = |of: &Self, name: &str| of.parameters.iter().any(|p| p.name == name);
        self.same_place(other)
            && !self.is_refinement
            && !other.is_refinement
            && self.hinge == other.hinge
            && self.fixed == other.fixed
            && self.parameters.len() > other.parameters.len()
            && other.parameters.iter().all(|p| has(self, p.name))
            && self.parameters.iter().all(|p| has(other, p.name) || p.expected.is_some())
    }

    /// The correction for parameters as the fit measures them.
    pub(super) fn correction(&self, inner: &[f64]) -> Correction {
        Correction {
            cause: self.cause,
            at: self.at.clone(),
            parameters: self
                .parameters
                .iter()
                .zip(inner)
                .map(|(parameter, &inner)| (parameter.name, parameter.value(inner)))
                .chain(self.fixed.iter().copied())
                .map(|(name, value)| (name.to_owned(), value))
                .collect(),
            hinge: self.hinge.clone(),
        }
    }

    /// Where fits start: every combination of one parameter's starts with the others at their
    /// first.
    pub(super) fn starts(&self) -> Vec<Vec<f64>> {
        let first: Vec<f64> = self
            .parameters
            .iter()
            .map(|p| p.inner(p.starts.first().copied().unwrap_or(0.0)))
            .collect();
        if self.parameters.is_empty() {
            return vec![Vec::new()];
        }
        let mut starts = Vec::new();
        for (i, parameter) in self.parameters.iter().enumerate() {
            for (n, &start) in parameter.starts.iter().enumerate() {
                if n == 0 && i > 0 {
                    continue;
                }
                let mut inner = first.clone();
                inner[i] = parameter.clamp(parameter.inner(start));
                starts.push(inner);
            }
        }
        starts
    }
}
