//! The state of a mode over a record's samples, with or without drift, and its spectrum.

use std::cell::RefCell;

use realfft::RealFftPlanner;

use super::block::{Block, C64, ForceSample, Origin, Pole};

/// What drift adds to the spectrum of a pole, and its changes with λ and with each rate: at λ, at
/// its conjugate.
pub(super) struct Drifted {
    pub(super) value: [Vec<C64>; 2],
    pub(super) by_lambda: [Vec<C64>; 2],
    pub(super) by_rates: Vec<[Vec<C64>; 2]>,
}

/// The states of a mode, and their changes.
#[derive(Debug, Clone, Default)]
pub(super) struct States {
    pub(super) value: Vec<C64>,
    by_lambda: Vec<C64>,
    by_rates: Vec<Vec<C64>>,
}

/// What drives a mode, on its samples.
fn input(lambda: C64, step_s: f64, samples: usize, force: Option<&[ForceSample]>) -> Vec<C64> {
    let mut input = vec![C64::default(); samples];
    match force {
        None => input.iter_mut().take(1).for_each(|first| *first = C64::new(1.0, 0.0)),
        Some(force) => {
            for sample in force {
                let at = sample.at.ceil().max(0.0);
                if let Some(sum) = input.get_mut(at as usize) {
                    *sum += (lambda * (at - sample.at) * step_s).exp() * sample.value;
                }
            }
        }
    }
    input
}

/// Steps the mode through the record; envelopes of no rate are left out.
pub(super) fn states(
    lambda: C64,
    rates: &[(C64, &[f64])],
    step_s: f64,
    samples: usize,
    force: Option<&[ForceSample]>,
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
    for (k, input) in input.iter().enumerate() {
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
        now += input;
        states.value.push(now);
        states.by_lambda.push(slope);
        for (all, slope) in states.by_rates.iter_mut().zip(&slopes) {
            all.push(*slope);
        }
    }
    states
}

/// What the drift of a pole adds to its spectrum; `None` where it has none.
pub(super) fn drifted(block: &Block, pole: &Pole, is_driven: bool) -> Option<Drifted> {
    /// What drift adds begins at zero with each impact, so that little of it lies above the lines.
    const PER_PERIOD: usize = 4;
    let steps = Steps::of(block, PER_PERIOD)?;
    let rates = block.rates_of(pole);
    if rates.is_empty() || !is_driven {
        return None;
    }
    let moved = steps.states(block, pole.lambda, &rates);
    let steady = steps.states(block, pole.lambda, &[]);
    let less =
        |a: Vec<C64>, b: &[C64]| -> Vec<C64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    Some(Drifted {
        value: steps.spectra(block, &less(moved.value, &steady.value)),
        by_lambda: steps.spectra(block, &less(moved.by_lambda, &steady.by_lambda)),
        by_rates: moved.by_rates.iter().map(|slope| steps.spectra(block, slope)).collect(),
    })
}

/// Steps through a record, which may be longer than those between its samples where the lines lie
/// far below half the sampling rate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    step_s: f64,
    count: usize,
    /// Samples of the record in a step.
    samples: f64,
}

impl Steps {
    /// So many steps to a period of the highest line, at least; `None` where a block has no
    /// samples.
    pub(super) fn of(block: &Block, per_period: usize) -> Option<Self> {
        let Origin::Sampled { step_s, samples, .. } = block.origin else { return None };
        let duration_s = samples as f64 * step_s;
        let last = (block.highest() * duration_s / std::f64::consts::TAU).round() as usize;
        let count = without_large_factors(last.saturating_mul(per_period).max(1));
        // Half of the steps is worth it.
        let count = if 2 * count <= samples { count } else { samples };
        let step_s = if count == samples { step_s } else { duration_s / count as f64 };
        Some(Self { step_s, count, samples: samples as f64 / count as f64 })
    }

    /// The states of a mode; `rates` have the record's samples.
    pub(super) fn states(self, block: &Block, lambda: C64, rates: &[(C64, &[f64])]) -> States {
        let Origin::Sampled { force, .. } = &block.origin else { return States::default() };
        let force: Option<Vec<ForceSample>> = force.as_ref().map(|force| {
            force.iter().map(|own| ForceSample { at: own.at / self.samples, ..*own }).collect()
        });
        let middle = |k: usize| ((k as f64 + 0.5) * self.samples) as usize;
        let rates: Vec<(C64, Vec<f64>)> = rates
            .iter()
            .map(|(rate, own)| {
                let at = |k: usize| own.get(middle(k)).copied().unwrap_or(0.0);
                (*rate, (0..self.count).map(at).collect())
            })
            .collect();
        let rates: Vec<(C64, &[f64])> =
            rates.iter().map(|(rate, own)| (*rate, own.as_slice())).collect();
        states(lambda, &rates, self.step_s, self.count, force.as_deref())
    }

    /// Spectrum of complex states on the block's lines, as of so many samples as the record has,
    /// and that of their conjugates.
    pub(super) fn spectra(self, block: &Block, states: &[C64]) -> [Vec<C64>; 2] {
        let parts = [|z: &C64| z.re, |z: &C64| z.im];
        let [re, im] = parts.map(|part| transform(states.iter().map(part).collect()));
        let turns = self.count as f64 * self.step_s / std::f64::consts::TAU;
        let first = block.omega.first().map_or(0, |omega| (omega * turns).round() as usize);
        let i = C64::new(0.0, 1.0);
        let lines = || re.iter().zip(&im).skip(first).take(block.omega.len());
        let scaled = |value: C64| value * self.samples;
        [
            lines().map(|(re, im)| scaled(re + i * im)).collect(),
            lines().map(|(re, im)| scaled(re - i * im)).collect(),
        ]
    }
}

/// The next number that a Fourier transform divides well.
fn without_large_factors(least: usize) -> usize {
    let is_even = |mut number: usize| {
        for factor in [2, 3, 5] {
            while number.is_multiple_of(factor) {
                number /= factor;
            }
        }
        number == 1
    };
    (least.max(1)..).find(|number| is_even(*number)).unwrap_or(least)
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
