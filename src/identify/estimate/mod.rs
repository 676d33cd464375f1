//! Spectra → poles and residues with covariances.
//!
//! One method serves hammer tests, steady excitation, given frequency responses and free decays: a rational
//! function with common denominator in the frequency domain, first by linear least squares of rising order
//! ([`lscf`]), which gives the stabilisation diagram and starts, then by maximum likelihood ([`fit`]) with the
//! order chosen by significance ([`select`]).
//!
//! Why not a subspace or eigensystem realisation for the decays: the discrete Fourier transform of a free
//! decay is a rational function exactly ([`basis`]), so decays and hammer records differ by one term; a band
//! is cut out by taking its lines, where a realisation would need filters whose own poles disturb it; and
//! the last step reaches the Cramér–Rao bound and states it, while realisations and LSCF alone are biased in
//! damping at low signal-to-noise ratio and need a perturbation analysis of their own for deviations.

pub(super) mod basis;
mod blows;
pub(super) mod drift;
mod fit;
pub(super) mod lscf;
mod noise;
mod projection;
mod select;

use nalgebra::Matrix2;

pub(super) use basis::{Block, C64, Origin, Pole, Push};
use fit::{Fit, columns_of, parameters_of, weights};

/// A residue with what is known about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Residue {
    /// Factor of b(ω) at λ.
    pub(super) value: C64,
    /// Mean variance of its real and imaginary part.
    pub(super) variance: f64,
}

/// A pole as it was estimated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PoleEstimate {
    /// The pole.
    pub(super) pole: Pole,
    /// Standard deviation of the natural frequency |λ|, rad/s; of a pole that drifts, with what the model of drift
    /// may be wrong by.
    pub(super) omega_std: f64,
    /// Standard deviation of the damping ratio.
    pub(super) ratio_std: f64,
    /// By block and response.
    pub(super) residues: Vec<Vec<Residue>>,
    /// The pole's loudest line against the spectrum's, at the response where that is largest.
    pub(super) prominence: f64,
    /// How far the frequency is from that at small amplitudes where it is farthest, as a share; `None` where it does
    /// not depend on amplitude.
    pub(super) drift: Option<f64>,
    /// Whether it is what the model of drift leaves of other modes.
    pub(super) is_remainder: bool,
}

/// All poles of a record.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Estimate {
    /// By ascending frequency.
    pub(super) poles: Vec<PoleEstimate>,
    /// The fit on the lines of each spectrum, by block and response.
    pub(super) fitted: Vec<Vec<Vec<C64>>>,
    /// Standard deviation of each line's noise, by block and response.
    pub(super) noise: Vec<Vec<Vec<f64>>>,
    /// Whether the arm was moving when the records began.
    pub(super) begins_moving: bool,
}

/// Finds the poles. `None` where the spectra are empty or hold nothing that can be fitted.
pub(super) fn estimate(blocks: &mut [Block], starts: &[Pole]) -> Option<Estimate> {
    if blocks.iter().all(|block| block.spectra.is_empty() || block.omega.is_empty()) {
        return None;
    }
    let mut fit = select::select(blocks, starts)?.weighed(blocks);
    if let Some(moving) = moving(blocks, &fit) {
        fit = moving;
    }
    drop_strangers(blocks, &mut fit);
    report(blocks, &fit)
}

/// With vibration from before the records, where they show more of it than noise would.
fn moving(blocks: &mut [Block], fit: &Fit) -> Option<Fit> {
    let before: Vec<bool> = blocks.iter().map(|block| block.begins_moving).collect();
    let waits: Vec<bool> = blocks.iter().map(waits_for_its_force).collect();
    if !waits.contains(&true) {
        return None;
    }
    for (block, waits) in blocks.iter_mut().zip(&waits) {
        block.begins_moving |= waits;
    }
    let trial = Fit::at(blocks, fit.noise.clone(), fit.poles.clone())
        .map(|fit| fit.refined(blocks, fit::FULL));
    let freedom: usize =
        blocks.iter().zip(&waits).filter(|(_, w)| **w).map(|(b, _)| 2 * b.spectra.len()).sum();
    let freedom = (freedom * fit.poles.len()) as f64;
    let chance = 7.0;
    let required = freedom + 2.0 * (freedom * chance).sqrt() + 2.0 * chance;
    match trial {
        Some(trial)
            if fit.evaluation.sum_of_squares - trial.evaluation.sum_of_squares > required =>
        {
            Some(trial.weighed(blocks))
        }
        _ => {
            blocks.iter_mut().zip(before).for_each(|(block, before)| block.begins_moving = before);
            None
        }
    }
}

/// Whether the force begins late enough that an earlier vibration can be told from the one it causes.
fn waits_for_its_force(block: &Block) -> bool {
    const FEWEST_SAMPLES: f64 = 8.0;
    match &block.origin {
        Origin::Sampled { force: Some(force), .. } if !block.begins_moving => {
            force.first().is_some_and(|push| push.at >= FEWEST_SAMPLES)
        }
        _ => false,
    }
}

/// Leaves out what has run out of the band.
fn drop_strangers(blocks: &[Block], fit: &mut Fit) {
    let kept: Vec<Pole> =
        fit.poles.iter().copied().filter(|pole| select::in_band(blocks, pole)).collect();
    if kept.len() < fit.poles.len()
        && let Some(smaller) = Fit::at(blocks, fit.noise.clone(), kept)
    {
        *fit = smaller.refined(blocks, fit::FULL);
    }
}

fn report(blocks: &[Block], fit: &Fit) -> Option<Estimate> {
    let covariance = fit.covariance()?;
    let mut fitted: Vec<Vec<Vec<C64>>> = blocks.iter().map(|_| Vec::new()).collect();
    for part in &fit.evaluation.parts {
        let spectrum = &blocks[part.block].spectra[part.response];
        let weights = weights(&fit.noise[part.block][part.response]);
        let lines = spectrum.len();
        let left = |k: usize| C64::new(part.residual[k], part.residual[lines + k]) / weights[k];
        fitted[part.block].push(spectrum.iter().enumerate().map(|(k, v)| v - left(k)).collect());
    }
    let mut poles = Vec::new();
    let (firsts, _) = parameters_of(&fit.poles);
    for (at, pole) in fit.poles.iter().enumerate() {
        let first = firsts[at];
        let own = Matrix2::from_fn(|i, j| covariance[(first + i, first + j)]);
        let (omega, s, w) = (pole.omega(), pole.lambda.re, pole.lambda.im);
        let by_omega = nalgebra::Vector2::new(s, w) / omega;
        let by_ratio = nalgebra::Vector2::new(-w * w, s * w) / omega.powi(3);
        let deviation = |by: nalgebra::Vector2<f64>| by.dot(&(own * by)).max(0.0).sqrt();
        let mut residues: Vec<Vec<Residue>> = blocks.iter().map(|_| Vec::new()).collect();
        let mut prominence: f64 = 0.0;
        for part in &fit.evaluation.parts {
            let block = &blocks[part.block];
            let (place, _) = columns_of(block, &fit.poles)[at];
            let value = C64::new(part.factors[place], part.factors[place + 1]);
            let inverse = part.projection.inverse_triangle();
            // R⁻¹ is kept by columns: row i of it meets every column.
            let own_noise = |i: usize| inverse.iter().map(|column| column[i].powi(2)).sum::<f64>();
            let from_poles = |i: usize| {
                let row = nalgebra::DVector::from_iterator(
                    part.sensitivities.len(),
                    part.sensitivities.iter().map(|by| by[i]),
                );
                row.dot(&(&covariance * &row)).max(0.0)
            };
            let variance = |i: usize| own_noise(i) + from_poles(i);
            residues[part.block]
                .push(Residue { value, variance: 0.5 * (variance(place) + variance(place + 1)) });
            let own = block.contribution(pole, pole.is_driven);
            // Its loudest line: the nearest one may lie where the force has none.
            let loudest = own.value[0].iter().map(|b| b.norm()).fold(0.0, f64::max);
            let peak = value.norm() * loudest;
            let strongest = fit::strongest(&block.spectra[part.response]).sqrt();
            prominence = prominence.max(peak / strongest);
        }
        let drift = drift::drift_of(blocks, pole);
        let beyond = drift::beyond(drift);
        poles.push(PoleEstimate {
            pole: *pole,
            omega_std: deviation(by_omega).hypot(omega * beyond),
            ratio_std: deviation(by_ratio).hypot(beyond),
            residues,
            prominence,
            drift: pole.drifts().then_some(drift.im),
            is_remainder: false,
        });
    }
    let peaks: Vec<f64> = poles.iter().map(|pole| pole.prominence).collect();
    for (at, pole) in poles.iter_mut().enumerate() {
        pole.is_remainder = drift::is_remainder(blocks, &fit.poles, &peaks, at);
    }
    poles.sort_by(|a, b| a.pole.omega().total_cmp(&b.pole.omega()));
    let deviations = |variances: &Vec<f64>| variances.iter().map(|v| v.sqrt()).collect();
    let noise = fit.noise.iter().map(|block| block.iter().map(deviations).collect()).collect();
    Some(Estimate {
        poles,
        fitted,
        noise,
        begins_moving: blocks.iter().any(|block| block.begins_moving),
    })
}
