//! Impacts as the arm felt them. A pulse of a few samples is more than its samples show: what lies
//! between them makes each impact a little stronger or weaker, earlier or later than the sampled
//! force says. With several impacts in a record these differences would show as combs of false
//! modes. So, where the residual shows it, each impact gets a strength and an instant of its own;
//! all modes and responses share them.

use nalgebra::{DMatrix, DVector};

use super::block::{Block, C64, ForceSample, Origin};
use super::fit::{Evaluation, Fit, rows, weights};
use super::projection::dot;
use crate::statistics::chi_squared_bound;

/// The blocks with each impact at the strength and instant that the residual shows; `None` where
/// that is not significant, or where impacts cannot be compared.
pub(super) fn corrected(blocks: &[Block], fit: &Fit) -> Option<Vec<Block>> {
    let mut all = blocks.to_vec();
    let mut is_corrected = false;
    for (at, block) in all.iter_mut().enumerate() {
        let Origin::Sampled { step_s, force: Some(force), .. } = &block.origin else { continue };
        let impacts = force.iter().map(|sample| sample.impact + 1).max().unwrap_or(0);
        if impacts < 2 || fit.poles.is_empty() {
            continue;
        }
        let Some(changes) = changes(block, &fit.evaluation, at, fit, impacts) else { continue };
        let moved: Vec<ForceSample> = force
            .iter()
            .map(|sample| ForceSample {
                at: sample.at + changes[2 * sample.impact + 1].clamp(-1.0, 1.0),
                value: sample.value * (1.0 + changes[2 * sample.impact].clamp(-0.9, 0.9)),
                ..*sample
            })
            .collect();
        block.drive = total(&drives(block, &moved, *step_s, impacts));
        if let Origin::Sampled { force, .. } = &mut block.origin {
            *force = Some(moved);
        }
        is_corrected = true;
    }
    is_corrected.then_some(all)
}

/// Relative change of strength and change of instant, in steps, of each impact in turn.
fn changes(
    block: &Block,
    evaluation: &Evaluation,
    at: usize,
    fit: &Fit,
    impacts: usize,
) -> Option<DVector<f64>> {
    /// Standard deviations before the residual is seen: of the relative strength, of the instant in
    /// steps.
    const STRENGTH: f64 = 0.3;
    const INSTANT_STEPS: f64 = 0.5;
    /// −ln of the probability that noise alone makes a change, about one in a thousand.
    const FALSE_ALARM: f64 = 7.0;
    /// How much surer than of anything else it is that the changes of instants sum up to nothing.
    const TOGETHER: f64 = 1e3;
    let Origin::Sampled { step_s, samples, force: Some(force) } = &block.origin else {
        return None;
    };
    let (count, columns) = (2 * impacts, block.columns_of(&fit.poles));
    let drives = drives(block, force, *step_s, impacts);
    let shares = shares(block, fit, force, &drives, *step_s, *samples);
    let mut normal = DMatrix::from_diagonal(&DVector::from_fn(count, |i, _| {
        let expected = if i % 2 == 0 { STRENGTH } else { INSTANT_STEPS };
        expected.powi(-2)
    }));
    let mut right = DVector::zeros(count);
    for part in evaluation.parts.iter().filter(|part| part.block == at) {
        let weights = weights(&fit.noise[at][part.response]);
        let slopes: Vec<Vec<f64>> = (0..count)
            .map(|i| {
                let mut slope = vec![C64::default(); block.omega.len()];
                for (pole, &(place, _)) in columns.iter().enumerate() {
                    let residue = C64::new(part.factors[place], part.factors[place + 1]);
                    let [own, conjugate] = &shares[pole][i];
                    for (sum, (own, conjugate)) in slope.iter_mut().zip(own.iter().zip(conjugate)) {
                        *sum += residue * own + residue.conj() * conjugate;
                    }
                }
                let mut slope = rows(&slope, &weights);
                part.projection.remove(&mut slope);
                slope
            })
            .collect();
        for i in 0..count {
            right[i] += dot(&slopes[i], &part.residual);
            for j in 0..=i {
                let product = dot(&slopes[i], &slopes[j]);
                normal[(i, j)] += product;
                if i != j {
                    normal[(j, i)] += product;
                }
            }
        }
    }
    // Later or earlier all together they cannot be: that is a delay between force and responses,
    // which the phases of the modes tell.
    let together = TOGETHER * normal.diagonal().max();
    for i in (1..count).step_by(2) {
        for j in (1..count).step_by(2) {
            normal[(i, j)] += together;
        }
    }
    let changes = normal.cholesky()?.solve(&right);
    let gain = changes.dot(&right);
    let required = chi_squared_bound(count as f64, FALSE_ALARM);
    (gain > required && changes.iter().all(|c| c.is_finite())).then_some(changes)
}

/// How a unit residue's spectrum changes with each impact's strength and instant: by pole, at λ and
/// at its conjugate. With F_i the spectrum of impact i and E_i what it leaves in the mode at the
/// record's end, the mode is (ΣF_i − ΣE_i)/(1 − μz⁻¹); later by τ, F_i turns by e^{−iωτ} and E_i by
/// e^{−λτ}.
fn shares(
    block: &Block,
    fit: &Fit,
    force: &[ForceSample],
    drives: &[Vec<C64>],
    step_s: f64,
    samples: usize,
) -> Vec<Vec<[Vec<C64>; 2]>> {
    let of = |lambda: C64, impact: usize, is_instant: bool| -> Vec<C64> {
        let mu = (lambda * step_s).exp();
        let left: C64 = force
            .iter()
            .filter(|sample| sample.impact == impact)
            .map(|sample| (lambda * (samples as f64 - sample.at) * step_s).exp() * sample.value)
            .sum();
        block
            .omega
            .iter()
            .zip(&drives[impact])
            .map(|(omega, drive)| {
                let below = 1.0 - mu * C64::from_polar(1.0, -omega * step_s);
                let change = if is_instant {
                    (lambda * left - C64::new(0.0, *omega) * drive) * step_s
                } else {
                    drive - left
                };
                if below.norm_sqr() < 1e-24 { C64::default() } else { change / below }
            })
            .collect()
    };
    fit.poles
        .iter()
        .map(|pole| {
            (0..2 * drives.len())
                .map(|i| {
                    if !pole.is_driven {
                        let nothing = vec![C64::default(); block.omega.len()];
                        return [nothing.clone(), nothing];
                    }
                    [pole.lambda, pole.lambda.conj()].map(|lambda| of(lambda, i / 2, i % 2 == 1))
                })
                .collect()
        })
        .collect()
}

/// Spectrum of each impact on the block's lines, which lie evenly.
fn drives(block: &Block, force: &[ForceSample], step_s: f64, impacts: usize) -> Vec<Vec<C64>> {
    let first = block.omega.first().copied().unwrap_or(0.0);
    let apart = block.omega.get(1).map_or(0.0, |second| second - first);
    let mut drives = vec![vec![C64::default(); block.omega.len()]; impacts];
    for sample in force {
        let turn = C64::from_polar(1.0, -apart * sample.at * step_s);
        let mut now = C64::from_polar(sample.value, -first * sample.at * step_s);
        for sum in &mut drives[sample.impact] {
            *sum += now;
            now *= turn;
        }
    }
    drives
}

fn total(drives: &[Vec<C64>]) -> Vec<C64> {
    let lines = drives.first().map_or(0, Vec::len);
    (0..lines).map(|k| drives.iter().map(|drive| drive[k]).sum()).collect()
}
