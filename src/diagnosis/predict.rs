//! Causes put into the model → the frequencies that the table would hold, with their sensitivities.

use std::ops::Range;

use super::data::Data;
use super::hypothesis::Hypothesis;
use super::mechanics::{Change, Mechanics, Placed};
use crate::model::Description;
use crate::modes::Pencil;
use crate::modes::batch::Pencils;
use crate::units::hz_from_rad_per_s;

/// Step of the differences of M and K, as the fit measures parameters: M and K are smooth, and the
/// step leaves an error of 5e-7 of their curvature, and 1e-9 of themselves from rounding.
const STEP: f64 = 1e-6;

/// A predicted frequency: ln of it, in Hz, and the derivative by each parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frequency {
    pub(super) ln_hz: f64,
    pub(super) slope: Vec<f64>,
    /// How each link turns in the mode that the row has a rotation of, mode after mode of the row.
    pub(super) rotations: Vec<f64>,
    /// Their derivatives by each parameter, but for what scales the whole mode; empty where the row
    /// has no rotation.
    pub(super) rotation_slopes: Vec<Vec<f64>>,
}

/// Predicted frequencies of every row, ascending, before the instrument has its say; `None` if
/// there is no such robot or an arm would fall over.
pub(super) fn predict(
    description: &Description,
    hypothesis: &Hypothesis<'_>,
    data: &Data,
) -> Option<Vec<Vec<Frequency>>> {
    Solved::new(description, hypothesis, data, 0..0)?.frequencies(0..0)
}

/// A robot with causes, its modes solved at every row of a table: with their sensitivities to as
/// many parameters as are asked for.
pub(super) struct Solved<'h, 'c> {
    description: &'h Description,
    hypothesis: &'h Hypothesis<'c>,
    data: &'h Data,
    here: Mechanics,
    pencils: Pencils,
    /// Where it stands at each row, if that was to be kept.
    stands: Vec<Option<Placed>>,
}

impl<'h, 'c> Solved<'h, 'c> {
    /// `parameters` are those whose slopes may be asked for: where none are, nothing is kept for
    /// them.
    pub(super) fn new(
        description: &'h Description,
        hypothesis: &'h Hypothesis<'c>,
        data: &'h Data,
        parameters: Range<usize>,
    ) -> Option<Self> {
        let mut here = Mechanics::new(description, &hypothesis.corrections(), &data.rows)?;
        let mut pencils = Pencils::new(here.mass().nrows());
        let mut stands = Vec::with_capacity(data.rows.len());
        for row in &data.rows {
            here.place(row)?;
            pencils.push(here.mass(), here.stiffness());
            let is_asked = !parameters.is_empty() || row.has_rotations();
            stands.push(is_asked.then(|| here.stand()));
        }
        let is_solved = pencils.solve();
        is_solved.then_some(Self { description, hypothesis, data, here, pencils, stands })
    }

    /// What moving each parameter a little does: `None` of the instrument's, which change nothing
    /// in the robot, and of those that are not among `parameters`.
    fn changes(&self, parameters: &Range<usize>) -> Option<Vec<Option<Change>>> {
        if parameters.is_empty() {
            return Some(Vec::new());
        }
        let inner = self.hypothesis.inner();
        let of_instrument = self.hypothesis.effects.iter().flat_map(|(candidate, inner)| {
            inner.iter().map(|_| candidate.cause.is_of_the_instrument())
        });
        let change = |(i, of_instrument): (usize, bool)| {
            if of_instrument || !parameters.contains(&i) {
                return Some(None);
            }
            let mut inner = inner.clone();
            inner[i] += STEP;
            let corrections = self.hypothesis.with(&inner).corrections();
            let moved = Mechanics::new(self.description, &corrections, &self.data.rows)?;
            Some(Some(Change::new(&self.here, moved)))
        };
        of_instrument.take(parameters.end).enumerate().map(change).collect()
    }

    /// The frequencies of every row, ascending, with slopes by `parameters`; by those before them
    /// slopes are 0. `None` if moving a parameter leaves no robot.
    pub(super) fn frequencies(&mut self, parameters: Range<usize>) -> Option<Vec<Vec<Frequency>>> {
        let mut changes = self.changes(&parameters)?;
        let Self { data, here, pencils, stands, .. } = self;
        let n = here.mass().nrows();
        let has_changes = changes.iter().any(Option::is_some);
        let mut rows = Vec::with_capacity(data.rows.len());
        for (i, (row, stands)) in data.rows.iter().zip(stands).enumerate() {
            let measured = row.rotations.iter().flatten();
            if let Some(stands) = stands.as_ref().filter(|_| has_changes || row.has_rotations()) {
                here.put_back(stands);
            }
            let turns: Vec<Vec<f64>> =
                measured.map(|own| here.turns(row, own).unwrap_or_else(|| vec![0.0; n])).collect();
            for change in changes.iter_mut().flatten() {
                change.place(here, row)?;
            }
            let omegas_squared = pencils.omega_squared(i);
            let of_mode = |(r, &omega_squared): (usize, &f64)| {
                let shape = pencils.shape(i, r);
                let turned = |change: &Option<Change>| -> Vec<f64> {
                    let Some(change) = change else { return vec![0.0; turns.len()] };
                    let moved = moved(change, pencils, i, r);
                    turns.iter().map(|turns| along(turns, &moved) / STEP).collect()
                };
                // d ln f = d(ω²) / 2ω².
                let slope = |change: &Change| {
                    change.of_omega_squared(shape, omega_squared) / STEP / (2.0 * omega_squared)
                };
                let slopes = changes.iter().map(|change| change.as_ref().map_or(0.0, slope));
                Frequency {
                    ln_hz: hz_from_rad_per_s(omega_squared.sqrt()).ln(),
                    slope: slopes.collect(),
                    rotations: turns.iter().map(|own| along(own, shape)).collect(),
                    rotation_slopes: if turns.is_empty() {
                        Vec::new()
                    } else {
                        changes.iter().map(turned).collect()
                    },
                }
            };
            let finite = omegas_squared.iter().take_while(|o| o.is_finite());
            rows.push(finite.enumerate().map(of_mode).collect());
        }
        Some(rows)
    }
}

/// dφ = Σ φ_s φ_sᵀ (dK − ω² dM) φ / (ω² − ω_s²) of the mode `r` at row `i` over the other modes s.
fn moved(change: &Change, pencils: &Pencils, i: usize, r: usize) -> Vec<f64> {
    let omega_squared = pencils.omega_squared(i)[r];
    let force = change.force(pencils.shape(i, r), omega_squared);
    let mut moved = vec![0.0; force.len()];
    for (s, &other) in pencils.omega_squared(i).iter().enumerate() {
        let apart = omega_squared - other;
        if s == r || !other.is_finite() || apart.abs() < 1e-6 * omega_squared {
            continue;
        }
        let shape = pencils.shape(i, s);
        let share = along(&force, shape);
        moved.iter_mut().zip(shape).for_each(|(m, part)| *m += share / apart * part);
    }
    moved
}

fn along(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// How much of each mode's energy is in each elastic coordinate of a model at the rows of a table,
/// by row, mode and coordinate: d ln f by ln of the spring (half the share of the strain energy),
/// and by the coordinate's own inertia.
pub(super) fn participation(here: &mut Mechanics, data: &Data) -> Option<Vec<Vec<Vec<[f64; 2]>>>> {
    let n = here.mass().nrows();
    let mut rows = Vec::new();
    let mut pencil = Pencil::new(n);
    for row in &data.rows {
        here.place(row)?;
        let (m, k) = (here.mass(), here.stiffness());
        if !pencil.solve(m, k) {
            return None;
        }
        let modes = (0..n).take_while(|&r| pencil.omega_squared[r].is_finite()).map(|r| {
            (0..n)
                .map(|i| {
                    let phi2 = pencil.shapes[(i, r)].powi(2);
                    [0.5 * k[(i, i)] * phi2 / pencil.omega_squared[r], -0.5 * m[(i, i)] * phi2]
                })
                .collect()
        });
        rows.push(modes.collect());
    }
    Some(rows)
}
