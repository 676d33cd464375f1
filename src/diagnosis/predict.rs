//! Causes put into the model → the frequencies that the table would hold, with their sensitivities.

use nalgebra::DMatrix;

use super::candidate::Candidate;
use super::data::{Data, Load, Row};
use crate::model::{
    Cause, Correction, Description, Placement, Robot, mass_matrix, stiffness_matrix,
};
use crate::modes::Pencil;
use crate::units::hz_from_rad_per_s;

/// Step of the differences of M and K, as the fit measures parameters: M and K are smooth, and the step leaves
/// an error of 5e-7 of their curvature, and 1e-9 of themselves from rounding.
const STEP: f64 = 1e-6;

/// M and K of each row.
#[derive(Debug, Clone)]
pub(super) struct Matrices {
    pub(super) mass: Vec<DMatrix<f64>>,
    pub(super) stiffness: Vec<DMatrix<f64>>,
}

/// A predicted frequency: ln of it, in Hz, and the derivative by each parameter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Frequency {
    pub(super) ln_hz: f64,
    pub(super) slope: Vec<f64>,
}

/// The robot with `corrections` beside its own, and `load` at the tip.
pub(super) fn robot(
    description: &Description,
    corrections: &[Correction],
    load: Load,
) -> Option<Robot> {
    let mut description = description.clone();
    description.corrections.extend_from_slice(corrections);
    if load.share == 0.0 {
        description.payload = None;
    } else if let Some(payload) = &mut description.payload {
        payload.inertial.mass_kg *= load.share;
        payload.inertial.inertia_kgm2 *= load.share;
    }
    if load.more_kg > 0.0 {
        let tip = match &description.tip {
            Some(tip) => tip.clone(),
            None => Robot::new(&description).ok()?.tip_link().to_owned(),
        };
        description.corrections.push(Correction {
            cause: Cause::Payload,
            at: Some(tip),
            parameters: vec![("mass_kg".to_owned(), load.more_kg)],
            hinge: None,
        });
    }
    Robot::new(&description).ok()
}

/// M and K of every row; `None` if there is no such robot.
pub(super) fn assemble(
    description: &Description,
    corrections: &[Correction],
    rows: &[Row],
) -> Option<Matrices> {
    let mut known: Vec<(Load, Robot, Placement)> = Vec::new();
    let mut matrices = Matrices { mass: Vec::new(), stiffness: Vec::new() };
    for row in rows {
        let at = match known.iter().position(|(load, ..)| *load == row.load) {
            Some(at) => at,
            None => {
                let robot = robot(description, corrections, row.load)?;
                let placement = Placement::new(&robot);
                known.push((row.load, robot, placement));
                known.len() - 1
            }
        };
        let (_, robot, placement) = &mut known[at];
        let n = robot.coordinates().len();
        let (mut m, mut k) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        placement.place(robot, &row.q);
        mass_matrix(robot, placement, &mut m);
        stiffness_matrix(robot, placement, &row.conditions, &mut k);
        matrices.mass.push(m);
        matrices.stiffness.push(k);
    }
    Some(matrices)
}

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

    /// What the causes put into the model.
    pub(super) fn corrections(&self) -> Vec<Correction> {
        self.effects.iter().map(|(candidate, inner)| candidate.correction(inner)).collect()
    }
}

/// Predicted frequencies of every row, ascending, before the instrument has its say; `None` if there is no
/// such robot or an arm would fall over.
pub(super) fn predict(
    description: &Description,
    hypothesis: &Hypothesis<'_>,
    data: &Data,
    with_slopes: bool,
) -> Option<Vec<Vec<Frequency>>> {
    let corrections = hypothesis.corrections();
    let here = assemble(description, &corrections, &data.rows)?;
    let inner = hypothesis.inner();
    let mut changes = Vec::new();
    if with_slopes {
        for (i, parameter) in parameters(hypothesis).enumerate() {
            if parameter.is_of_the_instrument {
                changes.push(None);
                continue;
            }
            let mut inner = inner.clone();
            inner[i] += STEP;
            let there = assemble(description, &hypothesis.with(&inner).corrections(), &data.rows)?;
            changes.push(Some(there));
        }
    }
    let mut pencil: Option<Pencil> = None;
    let mut rows = Vec::with_capacity(data.rows.len());
    for row in 0..data.rows.len() {
        let (m, k) = (&here.mass[row], &here.stiffness[row]);
        let n = m.nrows();
        let pencil = pencil.get_or_insert_with(|| Pencil::new(n));
        if !pencil.solve(m, k) {
            return None;
        }
        let mut frequencies = Vec::with_capacity(n);
        for (r, &omega_squared) in pencil.omega_squared.iter().enumerate() {
            if !omega_squared.is_finite() {
                break;
            }
            let shape = pencil.shapes.column(r);
            let slope = changes
                .iter()
                .map(|change| {
                    let Some(there) = change else { return 0.0 };
                    let mut sum = 0.0;
                    for j in 0..n {
                        for i in 0..n {
                            let dk = there.stiffness[row][(i, j)] - k[(i, j)];
                            let dm = there.mass[row][(i, j)] - m[(i, j)];
                            sum += shape[i] * (dk - omega_squared * dm) * shape[j];
                        }
                    }
                    // d(ω²) = φᵀ (dK − ω² dM) φ, and d ln f = d(ω²) / 2ω².
                    sum / STEP / (2.0 * omega_squared)
                })
                .collect();
            frequencies
                .push(Frequency { ln_hz: hz_from_rad_per_s(omega_squared.sqrt()).ln(), slope });
        }
        rows.push(frequencies);
    }
    Some(rows)
}

struct Which {
    is_of_the_instrument: bool,
}

fn parameters<'h>(hypothesis: &'h Hypothesis<'_>) -> impl Iterator<Item = Which> + 'h {
    hypothesis.effects.iter().flat_map(|(candidate, inner)| {
        inner.iter().map(|_| Which { is_of_the_instrument: candidate.cause.is_of_the_instrument() })
    })
}

/// `frequency` folded about half the sampling rate.
pub(super) fn folded(frequency_hz: f64, sample_rate_hz: f64) -> f64 {
    (frequency_hz - sample_rate_hz * (frequency_hz / sample_rate_hz).round()).abs()
}

/// How much of each mode's energy is in each elastic coordinate, by row, mode and coordinate: d ln f by ln
/// of the spring (half the share of the strain energy), and by the coordinate's own inertia.
pub(super) fn participation(
    description: &Description,
    hypothesis: &Hypothesis<'_>,
    data: &Data,
) -> Option<Vec<Vec<Vec<[f64; 2]>>>> {
    let matrices = assemble(description, &hypothesis.corrections(), &data.rows)?;
    let mut pencil: Option<Pencil> = None;
    let mut rows = Vec::new();
    for (m, k) in matrices.mass.iter().zip(&matrices.stiffness) {
        let n = m.nrows();
        let pencil = pencil.get_or_insert_with(|| Pencil::new(n));
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
