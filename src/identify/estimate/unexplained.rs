//! What the model of drift leaves unexplained: near the poles that drift, and at sums and
//! differences of their frequencies. It counts as noise, and no pole there is taken for a mode.

use super::block::{Block, C64, Law, Pole};
use super::states::Steps;

/// An envelope serves poles within this relative distance.
pub(super) const SAME_MODE: f64 = 0.1;

/// Whether the force drives a pole and its damping is low enough to see it drift.
pub(super) fn may_drift(pole: &Pole) -> bool {
    pole.is_driven && (0.0..0.1).contains(&pole.ratio())
}

/// Largest shift of a pole from its place at small amplitudes, relative to its frequency.
pub(super) fn drift_of(blocks: &[Block], pole: &Pole) -> C64 {
    let shift = |block: &Block| {
        let rates = block.rates_of(pole);
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

/// Error of the model of a pole's drift: of its frequency, relative to that, and of its damping
/// ratio. Of simulated arms with cubic springs of known linear limit it is up to 3 % of the drift.
/// With friction in the joints it is more: the nearer a joint comes to slipping, the less its
/// stiffness falls in proportion.
pub(super) fn model_error(blocks: &[Block], drift: C64) -> [f64; 2] {
    let law = blocks.first().and_then(|block| block.envelopes.first()).map(|e| e.law);
    let shares = match law {
        None | Some(Law::Square) => [0.03, 0.03],
        Some(Law::Proportional) => [0.15, 0.3],
        Some(Law::Saturating) => [0.3, 0.3],
    };
    shares.map(|share| share * drift.norm())
}

/// The width of a pole that drifts: another pole there may describe what the model of drift does
/// not.
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

/// Whether a pole is an effect of drift rather than a mode: weak within the width of a pole that
/// drifts, or where springs respond at sums and differences of the modes' frequencies, and as weak
/// as such responses are. `peaks` are the loudest lines of all poles.
pub(super) fn is_artefact(blocks: &[Block], poles: &[Pole], peaks: &[f64], at: usize) -> bool {
    is_under_another(blocks, poles, peaks, at) || is_combination(blocks, poles, peaks, at)
}

fn is_under_another(blocks: &[Block], poles: &[Pole], peaks: &[f64], at: usize) -> bool {
    let mut others = poles.iter().zip(peaks).filter(|(other, _)| other.drifts());
    let is_under = |(other, peak): (&Pole, &f64)| {
        let reach = reaches(blocks, std::slice::from_ref(other));
        // A mode within the width of another is so loud, relative to it.
        peaks[at] < 0.35 * peak && reach.iter().any(|reach| reach.holds(&poles[at]))
    };
    others.any(is_under)
}

/// Whether a pole lies at a sum or difference of the frequencies of two or three modes that drift.
fn is_combination(blocks: &[Block], poles: &[Pole], peaks: &[f64], at: usize) -> bool {
    let pole = &poles[at];
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

/// What the model of drift does not explain, as noise by which the lines are weighted: a further
/// pole must explain more than that.
pub(super) struct Unexplained {
    /// First columns of the modes that take part, and the largest amplitude of each for a residue
    /// of one.
    modes: Vec<(usize, f64)>,
    /// Relative to the loudest of them.
    size: f64,
    /// Power of each line for an amplitude of one.
    powers: Vec<f64>,
}

impl Unexplained {
    pub(super) fn add_to(&self, noise: &mut [f64], factors: &[f64]) {
        let amplitude =
            |&(place, peak): &(usize, f64)| peak * factors[place].hypot(factors[place + 1]);
        let size = self.size * self.modes.iter().map(amplitude).fold(0.0, f64::max);
        noise.iter_mut().zip(&self.powers).for_each(|(noise, power)| *noise += size * size * power);
    }
}

/// A mode that drifts or that others drift with.
struct Part {
    place: usize,
    peak: f64,
    /// Its states relative to their peak.
    states: Vec<C64>,
}

/// What remains near the poles that drift: an error of the second order in frequency adds up over
/// the decay. And what oscillates at other frequencies: springs of second and third order respond
/// at sums and differences of two and three of the modes' frequencies.
pub(super) fn unexplained(blocks: &[Block], at: usize, poles: &[Pole]) -> Vec<Unexplained> {
    /// Relative to the drift: what oscillates near a mode and elsewhere; modes near by make it
    /// louder.
    const NEAR: f64 = 0.1;
    const ELSEWHERE: f64 = 0.5;
    let block = &blocks[at];
    /// Sums of three frequencies of modes lie above the lines.
    const PER_PERIOD: usize = 8;
    let Some(steps) = Steps::of(block, PER_PERIOD) else { return Vec::new() };
    if !poles.iter().any(Pole::drifts) {
        return Vec::new();
    }
    let drift_of = |pole: &Pole| drift_of(blocks, pole).norm();
    let most = poles.iter().map(drift_of).fold(0.0, f64::max);
    let places = block.columns_of(poles);
    let mut all = Vec::new();
    let mut parts = Vec::new();
    for (pole, (place, _)) in poles.iter().zip(places) {
        let is_source = pole.drifts() || is_envelope(block, poles, pole);
        if !is_source || parts.len() == 3 {
            continue;
        }
        let states = steps.states(block, pole.lambda, &block.rates_of(pole)).value;
        let peak = states.iter().map(|s| s.norm()).fold(f64::MIN_POSITIVE, f64::max);
        let states: Vec<C64> = states.iter().map(|s| s / peak).collect();
        let drift = drift_of(pole);
        // The error does not add up for longer than at this damping ratio.
        let added_up = 0.5 * drift.powi(2) / pole.ratio().max(1e-3);
        all.push(Unexplained {
            modes: vec![(place, peak)],
            size: (added_up + NEAR * drift).min(1.0),
            powers: steps.spectra(block, &states)[0].iter().map(C64::norm_sqr).collect(),
        });
        parts.push(Part { place, peak, states });
    }
    for (which, product) in products(&parts) {
        let [own, conjugate] = steps.spectra(block, &product);
        all.push(Unexplained {
            modes: which.iter().map(|&i| (parts[i].place, parts[i].peak)).collect(),
            size: ELSEWHERE * most,
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

/// Products of two and three states, conjugate or not, each with the modes that take part; those
/// that oscillate as one of the modes are left out, as they make it drift.
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
