//! Spectra of records: whole, and averaged over impacts or stretches as frequency responses with
//! coherence (Bendat & Piersol, Random Data, 4th ed., ch. 5 and 6).

use realfft::RealFftPlanner;

use super::estimate::C64;
use super::impacts::Impact;
use crate::units::rad_per_s_from_hz;

/// The transform of real samples, lines 0 to half their number.
pub(super) fn transform(samples: &[f64]) -> Vec<C64> {
    if samples.is_empty() {
        return Vec::new();
    }
    let plan = RealFftPlanner::new().plan_fft_forward(samples.len());
    let (mut input, mut output) = (samples.to_vec(), plan.make_output_vec());
    match plan.process(&mut input, &mut output) {
        Ok(()) => output,
        // Only for buffers of wrong length, which these are not.
        Err(_) => Vec::new(),
    }
}

/// The samples at another, lower rate: `count` of them over the same time, what lies above half
/// that rate taken off.
pub(super) fn resampled(samples: &[f64], count: usize) -> Vec<f64> {
    if count < 2 || count >= samples.len() {
        return samples.to_vec();
    }
    let plan = RealFftPlanner::new().plan_fft_inverse(count);
    let mut spectrum = transform(samples);
    spectrum.truncate(count / 2 + 1);
    let last = spectrum.len() - 1;
    spectrum[0].im = 0.0;
    spectrum[last] = C64::default();
    let mut output = plan.make_output_vec();
    match plan.process(&mut spectrum, &mut output) {
        Ok(()) => output.iter().map(|y| y / samples.len() as f64).collect(),
        // Only for buffers of wrong length, which these are not.
        Err(_) => samples.to_vec(),
    }
}

/// How the stretches that were averaged were windowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Window {
    /// Force outside of the pulses set to zero, and both channels times e^{−at}: that adds a/ω to
    /// each damping ratio, which is taken off again.
    ForceExponential {
        /// a, 1/s.
        decay_per_s: f64,
    },
    /// Hann, half overlapping.
    Hann,
}

/// Frequency responses averaged over impacts or stretches.
#[derive(Debug, Clone, PartialEq)]
pub struct Averaged {
    /// Hz.
    pub frequencies_hz: Vec<f64>,
    /// How many were averaged.
    pub averages: usize,
    /// How each was windowed.
    pub window: Window,
    /// By response: S_xf/S_ff, right where noise is in the response.
    pub h1: Vec<Vec<C64>>,
    /// By response: S_xx/S_fx, right where noise is in the force.
    pub h2: Vec<Vec<C64>>,
    /// By response: H1/H2; empty where only one was averaged.
    pub coherence: Vec<Vec<f64>>,
}

impl Averaged {
    /// Of responses that are late by `delay_s`, as if they were not.
    pub(super) fn in_time(mut self, delay_s: f64) -> Self {
        let turns: Vec<C64> = self
            .frequencies_hz
            .iter()
            .map(|hz| C64::from_polar(1.0, rad_per_s_from_hz(*hz) * delay_s))
            .collect();
        for of_response in self.h1.iter_mut().chain(&mut self.h2) {
            of_response.iter_mut().zip(&turns).for_each(|(value, turn)| *value *= turn);
        }
        self
    }
}

/// Averages over impacts, each to the next impact's start. `force` is zero outside of the pulses.
pub(super) fn over_impacts(
    force: &[f64],
    responses: &[&[f64]],
    impacts: &[Impact],
    sample_rate_hz: f64,
) -> Option<Averaged> {
    let spacing = impacts.windows(2).map(|pair| pair[1].first - pair[0].first).min();
    let lead = spacing.unwrap_or(usize::MAX).min(impacts.first()?.first).min(4);
    let longest = impacts.iter().map(|impact| force.len() - impact.first + lead).max()?;
    // The last impact may have less room than the others; it is left out if it has much less.
    let last = force.len() - impacts.last()?.first + lead;
    let length = match spacing {
        // A last impact with more room than this share of the others' shortens them all.
        Some(spacing) if last as f64 > 0.8 * spacing as f64 => spacing.min(last),
        Some(spacing) => spacing.min(longest),
        None => longest,
    };
    let starts: Vec<usize> = impacts
        .iter()
        .map(|impact| impact.first - lead.min(impact.first))
        .filter(|s| s + length <= force.len())
        .collect();
    // The window leaves a fiftieth at its end.
    let decay_per_s = -0.02_f64.ln() * sample_rate_hz / length.max(1) as f64;
    let window: Vec<f64> =
        (0..length).map(|k| (-decay_per_s * k as f64 / sample_rate_hz).exp()).collect();
    let window_kind = Window::ForceExponential { decay_per_s };
    averaged(force, responses, &starts, &window, window_kind, sample_rate_hz)
}

/// Averages over half-overlapping stretches of a steady excitation.
pub(super) fn over_stretches(
    force: &[f64],
    responses: &[&[f64]],
    sample_rate_hz: f64,
) -> Option<Averaged> {
    // Eight stretches, not counting those that overlap.
    let length = force.len() / 8;
    let starts: Vec<usize> =
        (0..).map(|i| i * (length / 2).max(1)).take_while(|s| s + length <= force.len()).collect();
    let window: Vec<f64> = (0..length)
        .map(|k| 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / length as f64).cos())
        .collect();
    averaged(force, responses, &starts, &window, Window::Hann, sample_rate_hz)
}

fn averaged(
    force: &[f64],
    responses: &[&[f64]],
    starts: &[usize],
    window: &[f64],
    kind: Window,
    sample_rate_hz: f64,
) -> Option<Averaged> {
    let length = window.len();
    if length < 32 || starts.is_empty() {
        return None;
    }
    let windowed = |samples: &[f64], start: usize| -> Vec<C64> {
        let cut: Vec<f64> =
            samples[start..start + length].iter().zip(window).map(|(s, w)| s * w).collect();
        transform(&cut)
    };
    let lines = length / 2 + 1;
    let mut force_power = vec![0.0; lines];
    let mut power = vec![vec![0.0; lines]; responses.len()];
    let mut cross = vec![vec![C64::default(); lines]; responses.len()];
    for &start in starts {
        let f = windowed(force, start);
        force_power.iter_mut().zip(&f).for_each(|(sum, f)| *sum += f.norm_sqr());
        for (i, response) in responses.iter().enumerate() {
            for (k, x) in windowed(response, start).iter().enumerate() {
                power[i][k] += x.norm_sqr();
                cross[i][k] += x * f[k].conj();
            }
        }
    }
    let safe = |value: f64| value.max(f64::MIN_POSITIVE);
    let per_response = |of: &dyn Fn(usize, usize) -> C64| -> Vec<Vec<C64>> {
        (0..responses.len()).map(|i| (0..lines).map(|k| of(i, k)).collect()).collect()
    };
    let coherence =
        |i: usize, k: usize| (cross[i][k].norm_sqr() / safe(force_power[k] * power[i][k])).min(1.0);
    Some(Averaged {
        frequencies_hz: (0..lines).map(|k| k as f64 * sample_rate_hz / length as f64).collect(),
        averages: starts.len(),
        window: kind,
        h1: per_response(&|i, k| cross[i][k] / safe(force_power[k])),
        h2: per_response(&|i, k| cross[i][k] * (power[i][k] / safe(cross[i][k].norm_sqr()))),
        coherence: if starts.len() < 2 {
            Vec::new()
        } else {
            (0..responses.len()).map(|i| (0..lines).map(|k| coherence(i, k)).collect()).collect()
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A response that is 3 times the force, and one that has nothing to do with it.
    #[test]
    fn averages_give_gain_and_coherence() {
        let mut state = 1_u64;
        let mut noise = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let force: Vec<f64> = (0..4096).map(|_| noise()).collect();
        let tripled: Vec<f64> = force.iter().map(|f| 3.0 * f).collect();
        let stranger: Vec<f64> = (0..4096).map(|_| noise()).collect();
        let found = over_stretches(&force, &[&tripled, &stranger], 100.0).unwrap();
        assert_eq!((found.averages, found.frequencies_hz.len()), (15, 257));
        for k in 1..256 {
            assert!((found.h1[0][k] - 3.0).norm() < 1e-9 && (found.h2[0][k] - 3.0).norm() < 1e-9);
            assert!((found.coherence[0][k] - 1.0).abs() < 1e-9);
        }
        let mean = found.coherence[1].iter().sum::<f64>() / 257.0;
        assert!(mean < 0.2, "{mean}");
        assert!(over_stretches(&force[..100], &[&tripled[..100]], 100.0).is_none());
    }

    /// The exponential window adds a to the decay of a mode and nothing else.
    #[test]
    fn the_window_of_a_hit_only_moves_the_poles() {
        let rate = 200.0;
        let lambda = C64::new(-1.0, 100.0);
        let mut force = vec![0.0; 1000];
        force[4] = 2.0;
        let response: Vec<f64> = (0..1000)
            .map(|k| {
                let t = (f64::from(k) - 4.0) / rate;
                if t < 0.0 { 0.0 } else { 2.0 * 2.0 * (lambda * t).exp().re }
            })
            .collect();
        let impacts = [Impact { first: 4, end: 5, pulses: vec![(4, 5)] }];
        let found = over_impacts(&force, &[&response], &impacts, rate).unwrap();
        let Window::ForceExponential { decay_per_s } = found.window else { panic!() };
        let mu = ((lambda - decay_per_s) / rate).exp();
        for k in [20, 80, 81, 200] {
            let delay =
                C64::from_polar(1.0, -std::f64::consts::TAU * found.frequencies_hz[k] / rate);
            let exact = (1.0 - mu * delay).inv() + (1.0 - mu.conj() * delay).inv();
            assert!((found.h1[0][k] - exact).norm() < 0.01 * exact.norm());
        }
        assert!(found.coherence.is_empty());
    }
}
