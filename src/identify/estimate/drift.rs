//! Modes whose frequency and damping move with amplitude, as springs that stiffen, joints with play and
//! friction make them. To first order of averaging (Nayfeh & Mook, Nonlinear Oscillations, §6.2) the state of such
//! a mode obeys
//!
//! ```text
//! ṡ_r = (λ_r + Σ_j β_rj E_j(t)) s_r + f(t),      E_j = |s_j|² against its largest value
//! ```
//!
//! with λ_r the pole at small amplitude: its own amplitude and that of other modes shift it. In a linear model the
//! same record asks for a row of further poles at λ_r + 2n Re λ_j, all of the same shape. The envelopes E_j are
//! taken from the last fit and held while the poles and their rates β are refined.

use std::cell::RefCell;

use realfft::RealFftPlanner;

use super::basis::{Block, C64, MOST_DRIFTS, Origin, Pole, Push};
use super::fit::{Fit, GLANCE, USUAL, columns_of};

/// Chance with which noise alone makes a mode drift.
const FALSE_ALARM: f64 = 1e-3;

/// Poles damped more than this do not drift, nor does another with them.
const MOST_DAMPING: f64 = 0.1;

/// A drift beyond this share of the frequency is none.
const MOST_DRIFT: f64 = 0.25;

/// An envelope serves poles this near, as a share.
const SAME_MODE: f64 = 0.1;

/// Damping ratios below this are no better known.
const LEAST_DAMPING: f64 = 1e-3;

/// Times that envelopes and poles are brought into line with each other.
const ROUNDS: usize = 3;

/// How the amplitude of one mode goes in a block.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) struct Envelope {
    /// Natural frequency of the mode, rad/s.
    pub(in crate::identify) omega: f64,
    /// Square of its amplitude at each sample, against the largest of all blocks.
    pub(in crate::identify) values: Vec<f64>,
}

/// What drift adds to the spectrum of a pole, and its changes with λ and with each rate: at λ, at its
/// conjugate.
pub(super) struct Drifted {
    pub(super) value: [Vec<C64>; 2],
    pub(super) by_lambda: [Vec<C64>; 2],
    pub(super) by_rates: Vec<[Vec<C64>; 2]>,
}

/// The states of a mode, and their changes.
struct States {
    value: Vec<C64>,
    by_lambda: Vec<C64>,
    by_rates: Vec<Vec<C64>>,
}

/// What drives a mode, on its samples.
fn input(lambda: C64, step_s: f64, samples: usize, force: Option<&[Push]>) -> Vec<C64> {
    let mut input = vec![C64::default(); samples];
    match force {
        None => input.iter_mut().take(1).for_each(|first| *first = C64::new(1.0, 0.0)),
        Some(force) => {
            for push in force {
                let at = push.at.ceil().max(0.0);
                if let Some(sum) = input.get_mut(at as usize) {
                    *sum += (lambda * (at - push.at) * step_s).exp() * push.value;
                }
            }
        }
    }
    input
}

/// Steps the mode through the record; envelopes of no rate are left out.
fn states(
    lambda: C64,
    rates: &[(C64, &[f64])],
    step_s: f64,
    samples: usize,
    force: Option<&[Push]>,
) -> States {
    let input = input(lambda, step_s, samples, force);
    let steady = (lambda * step_s).exp();
    let mut now = C64::default();
    let mut slope = C64::default();
    let mut slopes = vec![C64::default(); rates.len()];
    let mut states = States {
        value: Vec::with_capacity(samples),
        by_lambda: Vec::with_capacity(samples),
        by_rates: vec![Vec::with_capacity(samples); rates.len()],
    };
    for (k, push) in input.iter().enumerate() {
        if now != C64::default() && k > 0 {
            let mut mu = steady;
            if !rates.is_empty() {
                let shift: C64 = rates.iter().map(|(rate, e)| rate * e[k - 1]).sum();
                mu *= (shift * step_s).exp();
            }
            for (slope, (_, envelope)) in slopes.iter_mut().zip(rates) {
                *slope = mu * (*slope + now * envelope[k - 1] * step_s);
            }
            slope = mu * (slope + now * step_s);
            now *= mu;
        }
        now += push;
        states.value.push(now);
        states.by_lambda.push(slope);
        for (all, slope) in states.by_rates.iter_mut().zip(&slopes) {
            all.push(*slope);
        }
    }
    states
}

/// The rates of a pole with the envelopes that they go with.
fn rates<'a>(block: &'a Block, pole: &Pole) -> Vec<(C64, &'a [f64])> {
    pole.rates
        .iter()
        .zip(&block.envelopes)
        .filter_map(|(rate, envelope)| Some(((*rate)?, envelope.values.as_slice())))
        .collect()
}

/// What the drift of a pole adds to its spectrum; `None` where it has none.
pub(super) fn drifted(block: &Block, pole: &Pole, is_driven: bool) -> Option<Drifted> {
    let Origin::Sampled { step_s, samples, force } = &block.origin else { return None };
    let rates = rates(block, pole);
    if rates.is_empty() || !is_driven {
        return None;
    }
    let force = force.as_deref();
    let moved = states(pole.lambda, &rates, *step_s, *samples, force);
    let steady = states(pole.lambda, &[], *step_s, *samples, force);
    let less =
        |a: Vec<C64>, b: &[C64]| -> Vec<C64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    Some(Drifted {
        value: spectra(block, *step_s, &less(moved.value, &steady.value)),
        by_lambda: spectra(block, *step_s, &less(moved.by_lambda, &steady.by_lambda)),
        by_rates: moved.by_rates.iter().map(|slope| spectra(block, *step_s, slope)).collect(),
    })
}

/// Spectrum of complex samples on the block's lines, and that of their conjugates.
fn spectra(block: &Block, step_s: f64, samples: &[C64]) -> [Vec<C64>; 2] {
    let parts = [|z: &C64| z.re, |z: &C64| z.im];
    let [re, im] = parts.map(|part| transform(samples.iter().map(part).collect()));
    let turns = samples.len() as f64 * step_s / std::f64::consts::TAU;
    let first = block.omega.first().map_or(0, |omega| (omega * turns).round() as usize);
    let i = C64::new(0.0, 1.0);
    let lines = || re.iter().zip(&im).skip(first).take(block.omega.len());
    [lines().map(|(re, im)| re + i * im).collect(), lines().map(|(re, im)| re - i * im).collect()]
}

thread_local! {
    static PLANNER: RefCell<RealFftPlanner<f64>> = RefCell::new(RealFftPlanner::new());
}

fn transform(mut samples: Vec<f64>) -> Vec<C64> {
    let plan = PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(samples.len()));
    let mut lines = plan.make_output_vec();
    // Buffers are of the plan's own lengths, so it cannot fail.
    let _ = plan.process(&mut samples, &mut lines);
    lines
}

/// Sets the envelopes to those of the poles of the fit that are nearest to them.
fn envelop(blocks: &mut [Block], fit: &Fit) {
    let count = blocks.first().map_or(0, |block| block.envelopes.len());
    for j in 0..count {
        let omega = blocks[0].envelopes[j].omega;
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
                values: values.into_iter().map(|e| e / largest).collect(),
            };
        }
    }
}

/// Square of the amplitude of a mode of unit residue.
fn envelope(block: &Block, pole: &Pole) -> Vec<f64> {
    let Origin::Sampled { step_s, samples, force } = &block.origin else { return Vec::new() };
    let rates = rates(block, pole);
    let states = states(pole.lambda, &rates, *step_s, *samples, force.as_deref());
    states.value.iter().map(|s| s.norm_sqr()).collect()
}

/// The largest residue of a pole in a block: blocks without force begin as loud as they are.
fn amplitude(block: &Block, at: usize, fit: &Fit, pole: usize) -> f64 {
    if matches!(block.origin, Origin::Sampled { force: Some(_), .. }) {
        return 1.0;
    }
    let (place, _) = columns_of(block, &fit.poles)[pole];
    fit.evaluation
        .parts
        .iter()
        .filter(|part| part.block == at)
        .map(|part| part.factors[place].hypot(part.factors[place + 1]))
        .fold(0.0, f64::max)
}

fn may_drift(pole: &Pole) -> bool {
    pole.is_driven && (0.0..MOST_DAMPING).contains(&pole.ratio())
}

/// Gives each driven pole an envelope, as far as there is room.
fn add_envelopes(blocks: &mut [Block], fit: &Fit) {
    for pole in fit.poles.iter().filter(|pole| may_drift(pole)) {
        let envelopes = &blocks[0].envelopes;
        let is_new = envelopes.iter().all(|e| (e.omega / pole.omega() - 1.0).abs() > SAME_MODE);
        if is_new && envelopes.len() < MOST_DRIFTS {
            for block in blocks.iter_mut() {
                block.envelopes.push(Envelope { omega: pole.omega(), values: Vec::new() });
            }
        }
    }
    envelop(blocks, fit);
}

/// How far a pole is from its place at small amplitudes where that is farthest, against its frequency.
pub(super) fn drift_of(blocks: &[Block], pole: &Pole) -> C64 {
    let shift = |block: &Block| {
        let rates = rates(block, pole);
        let at = |k: usize| rates.iter().map(|(rate, e)| rate * e[k]).sum::<C64>();
        let samples = rates.first().map_or(0, |(_, e)| e.len());
        (0..samples).map(at).max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()))
    };
    blocks
        .iter()
        .filter_map(shift)
        .max_by(|a, b| a.norm_sqr().total_cmp(&b.norm_sqr()))
        .map_or_else(C64::default, |shift| shift / pole.omega())
}

/// What the model of a pole's drift may be wrong by, as a share of its frequency: simulated arms with cubic springs
/// of known linear limit are off by up to this share of the drift.
pub(super) fn beyond(drift: C64) -> f64 {
    const SHARE: f64 = 0.03;
    SHARE * drift.norm()
}

/// The width of a pole that drifts: what another pole explains there may be what the model of drift does not.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    omega: f64,
    width: f64,
}

impl Reach {
    pub(super) fn holds(&self, pole: &Pole) -> bool {
        (self.omega - pole.omega()).abs() < self.width + pole.lambda.re.abs()
    }
}

/// The widths of all poles that drift.
pub(super) fn reaches(blocks: &[Block], poles: &[Pole]) -> Vec<Reach> {
    let reach = |pole: &Pole| {
        let omega = pole.omega();
        Reach { omega, width: pole.lambda.re.abs() + drift_of(blocks, pole).norm() * omega }
    };
    poles.iter().filter(|pole| pole.drifts()).map(reach).collect()
}

/// Whether a pole is what the model of drift leaves: weak within the width of a pole that drifts, or where the
/// springs answer at sums and differences of the modes' frequencies, and as weak as such answers are. `peaks` are
/// the loudest lines of all poles.
pub(super) fn is_remainder(blocks: &[Block], poles: &[Pole], peaks: &[f64], at: usize) -> bool {
    /// A mode within the width of another is this loud at least.
    const LEAST_SHARE: f64 = 0.35;
    let pole = &poles[at];
    let mut others = poles.iter().zip(peaks).filter(|(other, _)| other.drifts());
    let is_under = |(other, peak): (&Pole, &f64)| {
        let reach = reaches(blocks, std::slice::from_ref(other));
        peaks[at] < LEAST_SHARE * peak && reach.iter().any(|reach| reach.holds(pole))
    };
    if others.any(is_under) {
        return true;
    }
    let drift = poles.iter().map(|pole| drift_of(blocks, pole).norm()).fold(0.0, f64::max);
    let loudest = peaks.iter().copied().fold(0.0, f64::max);
    if pole.drifts() || peaks[at] > drift * loudest {
        return false;
    }
    let sources: Vec<&Pole> = poles
        .iter()
        .enumerate()
        .filter(|(i, source)| {
            *i != at
                && peaks[*i] > peaks[at]
                && (source.drifts() || blocks.iter().any(|block| is_envelope(block, poles, source)))
        })
        .map(|(_, source)| source)
        .collect();
    let signed = |sign: f64| sources.iter().map(move |s| (sign * s.omega(), s.lambda.re.abs()));
    let terms: Vec<(f64, f64)> = signed(1.0).chain(signed(-1.0)).collect();
    let third: Vec<(f64, f64)> = terms.iter().copied().chain([(0.0, 0.0)]).collect();
    terms.iter().any(|a| {
        terms.iter().any(|b| {
            third.iter().any(|c| {
                let (omega, decay) = (a.0 + b.0 + c.0, a.1 + b.1 + c.1);
                let widths = decay + pole.lambda.re.abs() + drift * omega.abs();
                omega > 0.0 && (omega - pole.omega()).abs() < widths
            })
        })
    })
}

/// What the model of drift does not explain, as noise that the lines are weighed with: a further pole must
/// explain more than that.
pub(super) struct Unexplained {
    /// First columns of the modes that take part, and the largest amplitude of each for a residue of one.
    modes: Vec<(usize, f64)>,
    /// Against the loudest of them.
    share: f64,
    /// Power of each line for an amplitude of one.
    powers: Vec<f64>,
}

impl Unexplained {
    pub(super) fn add_to(&self, noise: &mut [f64], factors: &[f64]) {
        let amplitude =
            |&(place, peak): &(usize, f64)| peak * factors[place].hypot(factors[place + 1]);
        let size = self.share * self.modes.iter().map(amplitude).fold(0.0, f64::max);
        noise.iter_mut().zip(&self.powers).for_each(|(noise, power)| *noise += size * size * power);
    }
}

/// A mode that drifts or that others drift with.
struct Part {
    place: usize,
    peak: f64,
    /// Its states against their peak.
    states: Vec<C64>,
}

/// What is left near the poles that drift: an error of the second order in frequency adds up over the decay. And
/// what goes round at other frequencies: springs of second and third order answer at sums and differences of two
/// and three of the modes' frequencies.
pub(super) fn unexplained(blocks: &[Block], at: usize, poles: &[Pole]) -> Vec<Unexplained> {
    /// Of the drift: what goes round near a mode and elsewhere; modes near by make it louder.
    const NEAR: f64 = 0.1;
    const ELSEWHERE: f64 = 0.5;
    /// Modes whose sums and differences are looked at.
    const MOST_MODES: usize = 3;
    let block = &blocks[at];
    let Origin::Sampled { step_s, samples, force } = &block.origin else { return Vec::new() };
    if !poles.iter().any(Pole::drifts) {
        return Vec::new();
    }
    let drift_of = |pole: &Pole| drift_of(blocks, pole).norm();
    let most = poles.iter().map(drift_of).fold(0.0, f64::max);
    let places = columns_of(block, poles);
    let mut all = Vec::new();
    let mut parts = Vec::new();
    for (pole, (place, _)) in poles.iter().zip(places) {
        let is_source = pole.drifts() || is_envelope(block, poles, pole);
        if !is_source || parts.len() == MOST_MODES {
            continue;
        }
        let states =
            states(pole.lambda, &rates(block, pole), *step_s, *samples, force.as_deref()).value;
        let peak = states.iter().map(|s| s.norm()).fold(f64::MIN_POSITIVE, f64::max);
        let states: Vec<C64> = states.iter().map(|s| s / peak).collect();
        let drift = drift_of(pole);
        let added_up = 0.5 * drift.powi(2) / pole.ratio().max(LEAST_DAMPING);
        all.push(Unexplained {
            modes: vec![(place, peak)],
            share: (added_up + NEAR * drift).min(1.0),
            powers: spectra(block, *step_s, &states)[0].iter().map(C64::norm_sqr).collect(),
        });
        parts.push(Part { place, peak, states });
    }
    for (which, product) in products(&parts) {
        let [own, conjugate] = spectra(block, *step_s, &product);
        all.push(Unexplained {
            modes: which.iter().map(|&i| (parts[i].place, parts[i].peak)).collect(),
            share: ELSEWHERE * most,
            powers: own.iter().zip(&conjugate).map(|(a, b)| a.norm_sqr() + b.norm_sqr()).collect(),
        });
    }
    all
}

/// Whether another pole drifts with the amplitude of this one.
fn is_envelope(block: &Block, poles: &[Pole], pole: &Pole) -> bool {
    may_drift(pole)
        && block.envelopes.iter().enumerate().any(|(j, envelope)| {
            (envelope.omega / pole.omega() - 1.0).abs() < SAME_MODE
                && poles.iter().any(|pole| pole.rates[j].is_some())
        })
}

/// Products of two and three states, conjugate or not; those that go round as one of the modes are left out, as
/// they make it drift. Each comes with the modes that take part.
fn products(parts: &[Part]) -> Vec<(Vec<usize>, Vec<C64>)> {
    let product = |which: &[usize], is_turned: bool| -> (Vec<usize>, Vec<C64>) {
        let last = which.len() - 1;
        let of = |k: usize| -> C64 {
            which
                .iter()
                .enumerate()
                .map(|(n, &i)| {
                    let state = parts[i].states[k];
                    if n == last && is_turned { state.conj() } else { state }
                })
                .product()
        };
        (which.to_vec(), (0..parts[0].states.len()).map(of).collect())
    };
    let mut all = Vec::new();
    for a in 0..parts.len() {
        for b in a..parts.len() {
            all.push(product(&[a, b], false));
            if a != b {
                all.push(product(&[a, b], true));
            }
            for c in 0..parts.len() {
                if c >= b {
                    all.push(product(&[a, b, c], false));
                }
                if c != a && c != b {
                    all.push(product(&[a, b, c], true));
                }
            }
        }
    }
    all
}

/// What the sum of squares must fall by for a rate: two parameters among as many as could drift.
pub(super) fn required_gain(poles: usize) -> f64 {
    let freedom = 2.0;
    let chance = ((poles * poles).max(1) as f64 / FALSE_ALARM).ln();
    freedom + 2.0 * (freedom * chance).sqrt() + 2.0 * chance
}

/// The fit with envelopes and poles in line with each other.
pub(super) fn settled(blocks: &mut [Block], fit: Fit) -> Fit {
    let mut best = fit;
    for _ in 0..ROUNDS {
        let mut trial = blocks.to_vec();
        envelop(&mut trial, &best);
        let Some(fit) = Fit::at(&trial, best.noise.clone(), best.poles.clone()) else { break };
        let fit = fit.refined(&trial, USUAL);
        let gained = best.evaluation.sum_of_squares - fit.evaluation.sum_of_squares;
        blocks.clone_from_slice(&trial);
        best = fit;
        if gained.abs() < 0.1 {
            break;
        }
    }
    best
}

/// With drift where it earns its place; `None` where nothing drifts. Also how many rates are new.
pub(super) fn drifting(blocks: &[Block], fit: &Fit) -> Option<(Vec<Block>, Fit, usize)> {
    if !blocks.iter().all(|block| matches!(block.origin, Origin::Sampled { .. })) {
        return None;
    }
    let mut blocks = blocks.to_vec();
    add_envelopes(&mut blocks, fit);
    let mut fit = Fit::at(&blocks, fit.noise.clone(), fit.poles.clone())?;
    let required = required_gain(fit.poles.len());
    let mut new = 0;
    while let Some((pole, envelope)) = most_promising(&blocks, &fit, required) {
        let mut poles = fit.poles.clone();
        poles[pole].rates[envelope] = Some(C64::default());
        let Some(trial) = Fit::at(&blocks, fit.noise.clone(), poles) else { break };
        let trial = trial.refined(&blocks, GLANCE);
        if fit.evaluation.sum_of_squares - trial.evaluation.sum_of_squares < required
            || trial.poles.iter().any(|pole| drift_of(&blocks, pole).norm() > MOST_DRIFT)
        {
            break;
        }
        new += 1;
        fit = trial;
        envelop(&mut blocks, &fit);
        fit = Fit::at(&blocks, fit.noise.clone(), fit.poles.clone())?;
    }
    (new > 0).then(|| {
        let fit = settled(&mut blocks, fit);
        (blocks, fit, new)
    })
}

/// The rate that a step of Gauss and Newton gains most by, beyond what the poles themselves gain.
fn most_promising(blocks: &[Block], fit: &Fit, required: f64) -> Option<(usize, usize)> {
    let count = blocks.first()?.envelopes.len();
    let base = fit.evaluation.predicted_gain()?;
    let mut best: Option<(f64, usize, usize)> = None;
    for (at, pole) in fit.poles.iter().enumerate().filter(|(_, pole)| may_drift(pole)) {
        for j in (0..count).filter(|&j| pole.rates[j].is_none()) {
            let mut poles = fit.poles.clone();
            poles[at].rates[j] = Some(C64::default());
            let Some(trial) = Fit::at(blocks, fit.noise.clone(), poles) else { continue };
            let Some(gain) = trial.evaluation.predicted_gain() else { continue };
            let gain = gain - base;
            if gain > required && best.is_none_or(|(most, _, _)| gain > most) {
                best = Some((gain, at, j));
            }
        }
    }
    best.map(|(_, pole, envelope)| (pole, envelope))
}
