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
    let Origin::Sampled { step_s, samples, force } = &block.origin else { return None };
    let rates = block.rates_of(pole);
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
pub(super) fn spectra(block: &Block, step_s: f64, samples: &[C64]) -> [Vec<C64>; 2] {
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
