//! Vibrations whose poles are known exactly: sums of damped modes, sampled; hammer tests with a force that is
//! linear between samples, integrated exactly. Nothing here is shared with `src/`.

#![allow(dead_code, reason = "each test uses a part")]

use nalgebra::Complex;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) type C64 = Complex<f64>;

/// A mode: natural frequency, damping ratio, and its displacement shape over the responses.
#[derive(Debug, Clone)]
pub(crate) struct TrueMode {
    pub(crate) hz: f64,
    pub(crate) ratio: f64,
    pub(crate) shape: Vec<f64>,
}

impl TrueMode {
    pub(crate) fn new(hz: f64, ratio: f64, shape: &[f64]) -> Self {
        Self { hz, ratio, shape: shape.to_vec() }
    }

    pub(crate) fn lambda(&self) -> C64 {
        let omega = std::f64::consts::TAU * self.hz;
        C64::new(-self.ratio * omega, omega * (1.0 - self.ratio * self.ratio).sqrt())
    }
}

/// Samples of a free decay by response: Σ Re(2·shape·phase·λ^derivatives·e^{λt}), begun at sample `quiet`.
pub(crate) fn free_decay(
    modes: &[TrueMode],
    derivatives: i32,
    rate: f64,
    samples: usize,
    quiet: usize,
) -> Vec<Vec<f64>> {
    let responses = modes[0].shape.len();
    (0..responses)
        .map(|response| {
            (0..samples)
                .map(|k| {
                    if k < quiet {
                        return 0.0;
                    }
                    let t = (k - quiet) as f64 / rate;
                    modes
                        .iter()
                        .map(|mode| {
                            let lambda = mode.lambda();
                            let phase = C64::from_polar(mode.shape[response], -0.9);
                            2.0 * (phase * lambda.powi(derivatives) * (lambda * t).exp()).re
                        })
                        .sum()
                })
                .collect()
        })
        .collect()
}

/// Responses of q̈ + 2ζω q̇ + ω² q = φ_drive f per mode to a force that is linear between samples.
pub(crate) fn hammered(
    modes: &[TrueMode],
    drive: usize,
    derivatives: i32,
    rate: f64,
    force: &[f64],
) -> Vec<Vec<f64>> {
    let responses = modes[0].shape.len();
    let mut all = vec![vec![0.0; force.len()]; responses];
    let step = 1.0 / rate;
    for mode in modes {
        let lambda = mode.lambda();
        let omega = std::f64::consts::TAU * mode.hz;
        let mu = (lambda * step).exp();
        // ∫ e^{λ(h−τ)} (a + b τ/h) dτ over a step.
        let constant = (mu - 1.0) / lambda;
        let ramp = (constant - step) / lambda / step;
        let mut state = C64::default();
        for (k, f) in force.iter().enumerate() {
            if k > 0 {
                let before = force[k - 1];
                state = mu * state + constant * before + ramp * (f - before);
            }
            let q = state.im / lambda.im;
            let speed = (lambda * state).im / lambda.im;
            let value = match derivatives {
                0 => q,
                1 => speed,
                _ => f - 2.0 * mode.ratio * omega * speed - omega * omega * q,
            };
            for (response, samples) in all.iter_mut().enumerate() {
                samples[k] += mode.shape[response] * mode.shape[drive] * value;
            }
        }
    }
    all
}

/// A half-sine pulse of `width` samples at each of `starts`.
pub(crate) fn pulses(samples: usize, starts: &[usize], width: usize, height: f64) -> Vec<f64> {
    let mut force = vec![0.0; samples];
    for &start in starts {
        for k in 1..width {
            force[start + k] += height * (std::f64::consts::PI * k as f64 / width as f64).sin();
        }
    }
    force
}

pub(crate) fn seeded(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// A standard normal number (Box & Muller).
pub(crate) fn gauss(rng: &mut ChaCha8Rng) -> f64 {
    let (a, b): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

pub(crate) fn rms(samples: &[f64]) -> f64 {
    (samples.iter().map(|s| s * s).sum::<f64>() / samples.len() as f64).sqrt()
}

/// With white noise of `share` of each response's root mean square: 0.1 is 20 dB.
pub(crate) fn noisy(samples: &[Vec<f64>], share: f64, rng: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
    samples
        .iter()
        .map(|samples| {
            let deviation = share * rms(samples);
            samples.iter().map(|s| s + deviation * gauss(rng)).collect()
        })
        .collect()
}

/// The channel that a note is about.
pub(crate) fn channel_of(note: &detune::notes::Note) -> Option<&str> {
    match &note.place.part {
        Some(detune::notes::Part::Channel { channel, .. }) => Some(channel),
        _ => None,
    }
}

/// Responses to white forces at every response's place that go on all the time: each mode's force is held over a
/// quarter of a step and integrated exactly; the record begins when the arm has forgotten how it stood.
pub(crate) fn random_response(
    modes: &[TrueMode],
    rate: f64,
    samples: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<Vec<f64>> {
    const OVER: usize = 4;
    let responses = modes[0].shape.len();
    let mut all = vec![vec![0.0; samples]; responses];
    let slowest = modes.iter().map(|mode| mode.lambda().re.abs()).fold(f64::INFINITY, f64::min);
    let before = (6.0 / slowest * rate).ceil() as usize;
    let step = 1.0 / (rate * OVER as f64);
    let mu: Vec<C64> = modes.iter().map(|mode| (mode.lambda() * step).exp()).collect();
    let mut states = vec![C64::default(); modes.len()];
    for k in 0..before + samples {
        for _ in 0..OVER {
            let force: Vec<f64> = (0..responses).map(|_| gauss(rng)).collect();
            for ((mode, mu), state) in modes.iter().zip(&mu).zip(&mut states) {
                let own: f64 = mode.shape.iter().zip(&force).map(|(s, f)| s * f).sum();
                *state = *state * mu + (*mu - 1.0) / mode.lambda() * own;
            }
        }
        if k >= before {
            for (mode, state) in modes.iter().zip(&states) {
                let q = state.im / mode.lambda().im;
                for (samples, shape) in all.iter_mut().zip(&mode.shape) {
                    samples[k - before] += shape * q;
                }
            }
        }
    }
    all
}
