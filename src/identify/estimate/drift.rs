//! Modes whose frequency and damping move with amplitude, as springs that stiffen, joints with play
//! and friction make them. To first order of averaging (Nayfeh & Mook, Nonlinear Oscillations,
//! §6.2) the state of such a mode obeys
//!
//! ```text
//! ṡ_r = (λ_r + Σ_j β_rj E_j(t)) s_r + f(t),      E_j = g(|s_j|), 1 at its largest value
//! ```
//!
//! with λ_r the pole at small amplitude: its own amplitude and that of other modes shift it. The
//! law g is the square for springs with a cubic part, and proportion for friction in a joint
//! below its slip (Dahl, Solid friction damping of mechanical vibrations, AIAA J. 14, 1976): the
//! loop of its force over deflection is lens-shaped, by which stiffness falls and damping rises
//! in proportion to amplitude. Where a joint slips through, no more stiffness is lost. In a
//! linear model the same record needs a row of further poles at λ_r + 2n Re λ_j, all of the same
//! shape. The envelopes E_j are taken from the last fit and held while the poles and their rates
//! β are refined.

use super::block::{Block, C64, Envelope, Law, MAX_ENVELOPES, Origin, Pole};
use super::fit::{COARSE, Fit, NORMAL, parameters_of};
use super::states::states;
use super::unexplained::{SAME_MODE, drift_of, may_drift};
use crate::statistics::chi_squared_bound;

/// Sets the envelopes to those of the poles of the fit that are nearest to them.
fn update_envelopes(blocks: &mut [Block], fit: &Fit) {
    let count = blocks.first().map_or(0, |block| block.envelopes.len());
    for j in 0..count {
        let Envelope { omega, law, .. } = blocks[0].envelopes[j];
        let far = |pole: &Pole| (pole.omega() / omega).ln().abs();
        let nearest = fit
            .poles
            .iter()
            .enumerate()
            .filter(|(_, pole)| pole.is_driven)
            .min_by(|(_, a), (_, b)| far(a).total_cmp(&far(b)));
        let Some((at, pole)) = nearest else { continue };
        let all: Vec<Vec<f64>> = blocks
            .iter()
            .enumerate()
            .map(|(b, block)| {
                let size = amplitude(block, b, fit, at).powi(2);
                envelope(block, pole).into_iter().map(|e| e * size).collect()
            })
            .collect();
        let largest = all.iter().flatten().fold(f64::MIN_POSITIVE, |a, b| a.max(*b));
        for (block, values) in blocks.iter_mut().zip(all) {
            block.envelopes[j] = Envelope {
                omega: pole.omega(),
                law,
                values: values.into_iter().map(|e| law.at((e / largest).sqrt())).collect(),
            };
        }
    }
}

/// Square of the amplitude of a mode of unit residue.
fn envelope(block: &Block, pole: &Pole) -> Vec<f64> {
    let Origin::Sampled { step_s, samples, force } = &block.origin else { return Vec::new() };
    let rates = block.rates_of(pole);
    let states = states(pole.lambda, &rates, *step_s, *samples, force.as_deref());
    states.value.iter().map(|s| s.norm_sqr()).collect()
}

/// The largest residue of a pole in a block: blocks without force begin as loud as they are.
fn amplitude(block: &Block, at: usize, fit: &Fit, pole: usize) -> f64 {
    if block.is_forced() {
        return 1.0;
    }
    let (place, _) = block.columns_of(&fit.poles)[pole];
    fit.evaluation
        .parts
        .iter()
        .filter(|part| part.block == at)
        .map(|part| part.factors[place].hypot(part.factors[place + 1]))
        .fold(0.0, f64::max)
}

/// Gives each driven pole an envelope, as far as there is room.
fn add_envelopes(blocks: &mut [Block], fit: &Fit, law: Law) {
    for pole in fit.poles.iter().filter(|pole| may_drift(pole)) {
        let envelopes = &blocks[0].envelopes;
        let is_new = envelopes.iter().all(|e| (e.omega / pole.omega() - 1.0).abs() > SAME_MODE);
        if is_new && envelopes.len() < MAX_ENVELOPES {
            for block in blocks.iter_mut() {
                let values = Vec::new();
                block.envelopes.push(Envelope { omega: pole.omega(), law, values });
            }
        }
    }
    update_envelopes(blocks, fit);
}

/// What the sum of squares must fall by for a rate: two parameters among as many as could drift.
pub(super) fn required_gain(poles: usize) -> f64 {
    /// Probability that noise alone makes a mode drift.
    const FALSE_ALARM: f64 = 1e-3;
    chi_squared_bound(2.0, ((poles * poles).max(1) as f64 / FALSE_ALARM).ln())
}

/// The fit with envelopes and poles consistent with each other.
fn settled(blocks: &mut [Block], fit: Fit) -> Fit {
    let mut best = fit;
    for _ in 0..3 {
        let mut trial = blocks.to_vec();
        update_envelopes(&mut trial, &best);
        let Some(fit) = Fit::at(&trial, best.noise.clone(), best.poles.clone()) else { break };
        let fit = fit.refined(&trial, NORMAL);
        let gained = best.evaluation.sum_of_squares - fit.evaluation.sum_of_squares;
        blocks.clone_from_slice(&trial);
        best = fit;
        if gained.abs() < 0.1 {
            break;
        }
    }
    best
}

/// With drift where it is significant, and how many rates are new; `None` where nothing drifts. All
/// modes drift by one law, the one that explains most; friction lowers frequencies, so what rises
/// goes by the square.
pub(super) fn drifting(blocks: &[Block], fit: &Fit) -> Option<(Vec<Block>, Fit, usize)> {
    if !blocks.iter().all(|block| matches!(block.origin, Origin::Sampled { .. })) {
        return None;
    }
    let required = required_gain(fit.poles.len());
    let score =
        |(_, fit, new): &(_, Fit, usize)| fit.evaluation.sum_of_squares + required * *new as f64;
    // A law that was given up is not taken up again: the search ends.
    let laws = Law::ALL.into_iter().filter(|law| law_of(blocks).is_none_or(|now| now <= *law));
    let trials = laws.filter_map(|law| drifting_by(law, blocks, fit));
    let trials =
        trials.filter(|(blocks, fit, _)| law_of(blocks) == Some(Law::Square) || falls(blocks, fit));
    trials.min_by(|a, b| score(a).total_cmp(&score(b)))
}

/// Whether frequencies fall with amplitude, as friction in joints makes them: none rises by more
/// than a small part of the largest fall.
fn falls(blocks: &[Block], fit: &Fit) -> bool {
    const MAX_RISE: f64 = 0.2;
    let drifts = fit.poles.iter().map(|pole| drift_of(blocks, pole).im);
    let (fall, rise) =
        drifts.fold((0.0_f64, 0.0_f64), |(fall, rise), drift| (fall.max(-drift), rise.max(drift)));
    rise <= MAX_RISE * fall
}

/// The law by which the poles drift; `None` where none may.
pub(super) fn law_of(blocks: &[Block]) -> Option<Law> {
    blocks.first()?.envelopes.first().map(|envelope| envelope.law)
}

/// With drift by a law.
fn drifting_by(law: Law, blocks: &[Block], fit: &Fit) -> Option<(Vec<Block>, Fit, usize)> {
    let required = required_gain(fit.poles.len());
    let is_other =
        fit.poles.iter().any(Pole::drifts) && law_of(blocks).is_some_and(|now| now != law);
    let before = fit.evaluation.sum_of_squares;
    let mut blocks = blocks.to_vec();
    for envelope in blocks.iter_mut().flat_map(|block| &mut block.envelopes) {
        envelope.law = law;
    }
    add_envelopes(&mut blocks, fit, law);
    let mut fit = Fit::at(&blocks, fit.noise.clone(), fit.poles.clone())?;
    if is_other {
        fit = fit.refined(&blocks, NORMAL);
    }
    let mut new = 0;
    while let Some((pole, envelope)) = most_promising(&blocks, &fit, required) {
        let mut poles = fit.poles.clone();
        poles[pole].rates[envelope] = Some(C64::default());
        let Some(trial) = Fit::at(&blocks, fit.noise.clone(), poles) else { break };
        let trial = trial.refined(&blocks, COARSE);
        if fit.evaluation.sum_of_squares - trial.evaluation.sum_of_squares < required
            || trial.poles.iter().any(|pole| drift_of(&blocks, pole).norm() > 0.25)
        {
            break;
        }
        new += 1;
        fit = trial;
        update_envelopes(&mut blocks, &fit);
        fit = Fit::at(&blocks, fit.noise.clone(), fit.poles.clone())?;
    }
    if new == 0 && !is_other {
        return None;
    }
    let fit = settled(&mut blocks, fit);
    // Another law in place of the one so far must explain as much more as a rate.
    let new = new + usize::from(is_other);
    let gained = before - fit.evaluation.sum_of_squares;
    (!is_other || gained > required * new as f64).then_some((blocks, fit, new))
}

/// The rate by which a Gauss–Newton step gains most, beyond what the poles themselves gain.
fn most_promising(blocks: &[Block], fit: &Fit, required: f64) -> Option<(usize, usize)> {
    let count = blocks.first()?.envelopes.len();
    let base = fit.evaluation.predicted_gain()?;
    // What a model of drift leaves unexplained counts as noise: beside it little seems left.
    let drifts = fit.poles.iter().any(Pole::drifts);
    let may_move = |pole: &Pole| {
        !pole.is_held && may_drift(pole) && (drifts || is_left(blocks, fit, pole, required))
    };
    // All rates at once, as each needs but its own rows of the normal matrix.
    let mut poles = fit.poles.clone();
    let mut candidates = Vec::new();
    for (at, pole) in fit.poles.iter().enumerate().filter(|(_, pole)| may_move(pole)) {
        for j in (0..count).filter(|&j| pole.rates[j].is_none()) {
            poles[at].rates[j] = Some(C64::default());
            candidates.push((at, j));
        }
    }
    if candidates.is_empty() {
        return None;
    }
    let (firsts, parameters) = parameters_of(&poles);
    let row = |&(at, j): &(usize, usize)| {
        firsts[at] + 2 * (1 + poles[at].rates[..j].iter().flatten().count())
    };
    let rows: Vec<usize> = candidates.iter().map(row).collect();
    let is_own = |i: &usize| !rows.contains(i) && !rows.contains(&i.wrapping_sub(1));
    let own: Vec<usize> = (0..parameters).filter(is_own).collect();
    let trial = Fit::at(blocks, fit.noise.clone(), poles.clone())?;
    let gain = |first: usize| {
        let with: Vec<usize> = own.iter().copied().chain([first, first + 1]).collect();
        Some(trial.evaluation.predicted_gain_of(&with)? - base)
    };
    let gains = candidates.iter().zip(&rows).filter_map(|(at, &row)| Some((gain(row)?, at)));
    let best = gains.filter(|(gain, _)| *gain > required).max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, at)| *at)
}

/// Whether the lines around a pole hold more residual than noise would leave there, so that drift
/// may explain it.
fn is_left(blocks: &[Block], fit: &Fit, pole: &Pole, required: f64) -> bool {
    /// Lines and decay rates to either side that a drifting pole's residual reaches.
    const LINES: f64 = 6.0;
    const RATES: f64 = 12.0;
    /// Of the gain that is required, as residual beyond that of noise.
    const MIN_SHARE: f64 = 0.25;
    let mut beyond = 0.0;
    for part in &fit.evaluation.parts {
        let omega = &blocks[part.block].omega;
        let line = omega.get(1).map_or(0.0, |second| second - omega[0]);
        let reach = LINES * line + RATES * pole.lambda.re.abs();
        let from = omega.partition_point(|w| *w < pole.omega() - reach);
        let to = omega.partition_point(|w| *w <= pole.omega() + reach);
        let own = |k: usize| part.residual[k].powi(2) + part.residual[omega.len() + k].powi(2);
        beyond += (from..to).map(|k| own(k) - 2.0).sum::<f64>();
    }
    beyond > MIN_SHARE * required
}
