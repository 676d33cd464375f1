//! Causes put into the model → the frequencies that the table would hold, with their sensitivities.

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

/// Predicted frequencies of every row, ascending, before the instrument has its say, with slopes by
/// the first `parameters`; `None` if there is no such robot or an arm would fall over.
pub(super) fn predict(
    description: &Description,
    hypothesis: &Hypothesis<'_>,
    data: &Data,
    parameters: usize,
) -> Option<Vec<Vec<Frequency>>> {
    let mechanics = |hypothesis: &Hypothesis<'_>| {
        Mechanics::new(description, &hypothesis.corrections(), &data.rows)
    };
    let mut here = mechanics(hypothesis)?;
    let inner = hypothesis.inner();
    // By parameter; the instrument's change nothing in the robot.
    let mut changes: Vec<Option<Change>> = Vec::new();
    let of_instrument = hypothesis.effects.iter().flat_map(|(candidate, inner)| {
        inner.iter().map(|_| candidate.cause.is_of_the_instrument())
    });
    for (i, of_instrument) in of_instrument.enumerate().take(parameters) {
        if of_instrument {
            changes.push(None);
            continue;
        }
        let mut inner = inner.clone();
        inner[i] += STEP;
        changes.push(Some(Change::new(&here, mechanics(&hypothesis.with(&inner))?)));
    }
    let n = here.mass().nrows();
    let mut pencils = Pencils::new(n);
    // Where it stands at each row that something more is asked of.
    let mut stands: Vec<Option<Placed>> = Vec::with_capacity(data.rows.len());
    for row in &data.rows {
        here.place(row)?;
        pencils.push(here.mass(), here.stiffness());
        let is_asked = !changes.is_empty() || row.rotations.iter().any(|own| !own.is_empty());
        stands.push(is_asked.then(|| here.stand()));
    }
    if !pencils.solve() {
        return None;
    }
    let mut rows = Vec::with_capacity(data.rows.len());
    for (i, (row, stands)) in data.rows.iter().zip(stands).enumerate() {
        let measured = row.rotations.iter().flatten();
        if let Some(stands) = stands {
            here.put_back(stands);
        }
        let turns: Vec<Vec<f64>> =
            measured.map(|own| here.turns(row, own).unwrap_or_else(|| vec![0.0; n])).collect();
        for change in changes.iter_mut().flatten() {
            change.place(&here, row)?;
        }
        let finite = pencils.omega_squared(i).iter().take_while(|o| o.is_finite());
        let frequencies = finite.enumerate().map(|(r, &omega_squared)| {
            let slope = |change: &Option<Change>| {
                // d ln f = d(ω²) / 2ω².
                change.as_ref().map_or(0.0, |change| {
                    change.of_omega_squared(pencils.shape(i, r), omega_squared)
                        / STEP
                        / (2.0 * omega_squared)
                })
            };
            let along = |turns: &[f64], shape: &[f64]| -> f64 {
                turns.iter().zip(shape).map(|(turn, part)| turn * part).sum()
            };
            // dφ = Σ φ_s φ_sᵀ (dK − ω² dM) φ / (ω² − ω_s²) over the other modes s.
            let turned = |change: &Option<Change>| -> Vec<f64> {
                let Some(change) = change else { return vec![0.0; turns.len()] };
                let force = change.force(pencils.shape(i, r), omega_squared);
                let mut moved = vec![0.0; n];
                for (s, &other) in pencils.omega_squared(i).iter().enumerate() {
                    let apart = omega_squared - other;
                    if s == r || !other.is_finite() || apart.abs() < 1e-6 * omega_squared {
                        continue;
                    }
                    let shape = pencils.shape(i, s);
                    let share = along(&force, shape);
                    moved.iter_mut().zip(shape).for_each(|(m, part)| *m += share / apart * part);
                }
                turns.iter().map(|turns| along(turns, &moved) / STEP).collect()
            };
            Frequency {
                ln_hz: hz_from_rad_per_s(omega_squared.sqrt()).ln(),
                slope: changes.iter().map(slope).collect(),
                rotations: turns.iter().map(|own| along(own, pencils.shape(i, r))).collect(),
                rotation_slopes: if turns.is_empty() {
                    Vec::new()
                } else {
                    changes.iter().map(turned).collect()
                },
            }
        });
        rows.push(frequencies.collect());
    }
    Some(rows)
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
