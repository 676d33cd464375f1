//! What one pole contributes to a spectrum, and how that changes as the pole moves.
//!
//! A sampled mode e^{λt} at rest before sample 0 and driven by f has, over a record of N samples,
//! the discrete Fourier transform
//!
//! ```text
//! b(ω) = (F(ω) − E) / (1 − μ z⁻¹),   μ = e^{λT},  z = e^{iωT},  E = Σ_m f[m] μ^{N−m}
//! ```
//!
//! exactly: E is what is left in the mode at the record's end, the leakage (Pintelon & Schoukens,
//! System Identification, 2nd ed., §6.3). A free decay is the case f = unit impulse at sample 0. So
//! no window is needed, and a record that ends before its decay biases nothing. Where a frequency
//! response function is all there is, b(ω) = 1/(iω − λ).

use super::block::{Block, C64, ForceSample, Origin, Pole};
use super::hann;
use super::states::{Drifted, drifted};

/// b on the lines and its derivatives by λ and by each rate, each at λ and at its conjugate.
#[derive(Debug, Clone)]
pub(in crate::identify) struct Contribution {
    pub(in crate::identify) value: [Vec<C64>; 2],
    pub(in crate::identify) slopes: Vec<[Vec<C64>; 2]>,
}

impl Contribution {
    fn with(mut self, drift: Drifted) -> Self {
        let add = |to: &mut [Vec<C64>; 2], from: &[Vec<C64>; 2]| {
            for (to, from) in to.iter_mut().flatten().zip(from.iter().flatten()) {
                *to += from;
            }
        };
        add(&mut self.value, &drift.value);
        self.slopes.iter_mut().for_each(|by_lambda| add(by_lambda, &drift.by_lambda));
        self.slopes.extend(drift.by_rates);
        self
    }
}

impl Block {
    /// What a pole contributes; `is_driven` false gives the vibration from before the record, which
    /// is too weak to drift.
    pub(in crate::identify) fn contribution(&self, pole: &Pole, is_driven: bool) -> Contribution {
        let steady = self.steady(pole.lambda, is_driven);
        match drifted(self, pole, is_driven) {
            Some(drift) => steady.with(drift),
            None => steady,
        }
    }

    fn steady(&self, lambda: C64, is_driven: bool) -> Contribution {
        match &self.origin {
            Origin::Responses { hann_s } => {
                let at = |lambda: C64| -> (Vec<C64>, Vec<C64>) {
                    self.omega
                        .iter()
                        .map(|w| {
                            if let Some(length_s) = hann_s {
                                return hann::response(lambda - C64::new(0.0, *w), *length_s);
                            }
                            let g = (C64::new(0.0, *w) - lambda).inv();
                            (g, g * g)
                        })
                        .unzip()
                };
                let ((value, slope), (conjugate_value, conjugate_slope)) =
                    (at(lambda), at(lambda.conj()));
                Contribution {
                    value: [value, conjugate_value],
                    slopes: vec![[slope, conjugate_slope]],
                }
            }
            Origin::Sampled { step_s, samples, force } => {
                let drive = if is_driven { force.as_deref() } else { None };
                let (end, end_slope) = at_end(lambda, *step_s, *samples, drive);
                let delays = self.delays(*step_s);
                let at = |lambda: C64, end: C64, end_slope: C64| -> (Vec<C64>, Vec<C64>) {
                    let mu = (lambda * *step_s).exp();
                    (0..self.omega.len())
                        .map(|k| {
                            let delay = delays[k];
                            let below = 1.0 - mu * delay;
                            let below =
                                if below.norm_sqr() < 1e-24 { C64::new(1e-12, 0.0) } else { below };
                            let g = below.inv();
                            let left = match drive {
                                Some(_) => self.drive[k] - end,
                                None => 1.0 - end,
                            };
                            (g * left, mu * delay * *step_s * g * g * left - g * end_slope)
                        })
                        .unzip()
                };
                let (value, slope) = at(lambda, end, end_slope);
                let (conjugate_value, conjugate_slope) =
                    at(lambda.conj(), end.conj(), end_slope.conj());
                Contribution {
                    value: [value, conjugate_value],
                    slopes: vec![[slope, conjugate_slope]],
                }
            }
        }
    }

    /// z⁻¹ on each line. Lines of a transform lie evenly, so each is the one before it, turned.
    fn delays(&self, step_s: f64) -> Vec<C64> {
        let first = self.omega.first().copied().unwrap_or(0.0);
        let apart = self.omega.get(1).map_or(0.0, |second| second - first);
        let turn = C64::from_polar(1.0, -apart * step_s);
        let start = C64::from_polar(1.0, -first * step_s);
        std::iter::successors(Some(start), |z| Some(z * turn)).take(self.omega.len()).collect()
    }

    /// Columns with real factors that stand for what lies outside the band, and for drift.
    pub(in crate::identify) fn background(&self) -> Vec<Vec<C64>> {
        if self.bend > 0 {
            return self.bent_background();
        }
        let highest = self.highest();
        let mut columns = Vec::new();
        let degree = match &self.origin {
            Origin::Sampled { force: None, .. } => 2,
            Origin::Sampled { force: Some(_), .. } | Origin::Responses { .. } => 3,
        };
        for power in 0..degree {
            let column = |(k, w): (usize, &f64)| {
                C64::new(0.0, w / highest).powi(power)
                    * self.drive.get(k).copied().unwrap_or(C64::new(1.0, 0.0))
            };
            columns.push(self.omega.iter().enumerate().map(column).collect());
        }
        match &self.origin {
            // The spectrum of a straight line.
            Origin::Sampled { step_s, .. } => columns.push(
                self.omega
                    .iter()
                    .map(|w| (1.0 - C64::from_polar(1.0, -w * step_s)).inv())
                    .collect(),
            ),
            // Modes below the band.
            Origin::Responses { .. } => columns
                .push(self.omega.iter().map(|w| C64::new(-(highest / w).powi(2), 0.0)).collect()),
        }
        columns
    }

    /// Skirts of modes outside of a band that was cut out: polynomials with complex factors
    /// (Legendre's, over the band), times the force; and that of drift.
    fn bent_background(&self) -> Vec<Vec<C64>> {
        let (first, last) = (self.omega.first().copied().unwrap_or(0.0), self.highest());
        let place = |w: f64| (2.0 * w - first - last) / (last - first).max(f64::MIN_POSITIVE);
        let drive = |k: usize| self.drive.get(k).copied().unwrap_or(C64::new(1.0, 0.0));
        let (mut before, mut now) = (vec![0.0; self.omega.len()], vec![1.0; self.omega.len()]);
        let mut columns = Vec::new();
        for degree in 0..=2 + 2 * self.bend {
            for factor in [C64::new(1.0, 0.0), C64::new(0.0, 1.0)] {
                let column = now.iter().enumerate().map(|(k, p)| drive(k) * factor * *p);
                columns.push(column.collect());
            }
            let n = degree as f64;
            let next = self.omega.iter().zip(now.iter().zip(&before)).map(|(w, (now, before))| {
                ((2.0 * n + 1.0) * place(*w) * now - n * before) / (n + 1.0)
            });
            let next = next.collect();
            before = std::mem::replace(&mut now, next);
        }
        if let Origin::Sampled { step_s, .. } = &self.origin {
            let drift = |w: &f64| (1.0 - C64::from_polar(1.0, -w * step_s)).inv();
            columns.push(self.omega.iter().map(drift).collect());
        }
        columns
    }
}

/// E and dE/dλ: what the record leaves in the mode.
fn at_end(lambda: C64, step_s: f64, samples: usize, force: Option<&[ForceSample]>) -> (C64, C64) {
    let one = |start: f64| {
        let time = (samples as f64 - start) * step_s;
        let left = (lambda * time).exp();
        (left, left * time)
    };
    match force {
        None => one(0.0),
        Some(force) => {
            let mut sums = (C64::default(), C64::default());
            for sample in force {
                let (left, slope) = one(sample.at);
                sums = (sums.0 + left * sample.value, sums.1 + slope * sample.value);
            }
            sums
        }
    }
}

#[cfg(test)]
mod tests {
    use realfft::RealFftPlanner;

    use super::*;

    fn transform(samples: &[f64]) -> Vec<C64> {
        let plan = RealFftPlanner::new().plan_fft_forward(samples.len());
        let mut input = samples.to_vec();
        let mut output = plan.make_output_vec();
        plan.process(&mut input, &mut output).unwrap();
        output
    }

    /// The basis against the transform of the samples themselves: a mode driven by a force of two
    /// pulses, one of them near the end, and a free decay; both still ringing when the record ends.
    #[test]
    fn a_record_that_ends_early_is_described_exactly() {
        let (step_s, samples) = (0.01, 300);
        let pole = Pole::from_modal(40.0, 0.01);
        let mut force = vec![0.0; samples];
        for (at, value) in [(5, 1.0), (6, 0.4), (280, -0.7)] {
            force[at] = value;
        }
        let samples_of =
            |(at, &value): (usize, &f64)| ForceSample { at: at as f64, value, impact: 0 };
        let nonzero: Vec<ForceSample> =
            force.iter().enumerate().filter(|(_, f)| **f != 0.0).map(samples_of).collect();
        let amplitude = C64::new(0.3, -0.8);
        let mu = (pole.lambda * step_s).exp();
        let mut state = C64::default();
        let driven: Vec<f64> = force
            .iter()
            .map(|f| {
                state = mu * state + f;
                2.0 * (amplitude * state).re
            })
            .collect();
        let free: Vec<f64> =
            (0..samples).map(|k| 2.0 * (amplitude * mu.powi(k as i32)).re).collect();
        let omega: Vec<f64> = (1..samples / 2)
            .map(|k| std::f64::consts::TAU * k as f64 / (samples as f64 * step_s))
            .collect();
        for (record, force, drive) in [
            (&driven, Some(nonzero), transform(&force)[1..samples / 2].to_vec()),
            (&free, None, Vec::new()),
        ] {
            let origin = Origin::Sampled { step_s, samples, force };
            let block = Block { drive, ..Block::new(origin, omega.clone(), Vec::new()) };
            let of = block.contribution(&pole, true);
            for (k, measured) in transform(record)[1..samples / 2].iter().enumerate() {
                let model = amplitude * of.value[0][k] + amplitude.conj() * of.value[1][k];
                assert!((model - measured).norm() < 1e-9, "line {k}: {model} {measured}");
            }
            // The slope against differences, in both directions of the complex plane.
            for step in [C64::new(1e-6, 0.0), C64::new(0.0, 1e-6)] {
                let (up, down) = (
                    block.contribution(&Pole::new(pole.lambda + step), true),
                    block.contribution(&Pole::new(pole.lambda - step), true),
                );
                for k in 0..omega.len() {
                    let slope = (up.value[0][k] - down.value[0][k]) / (step * 2.0);
                    let error = (slope - of.slopes[0][0][k]).norm();
                    assert!(
                        error < 1e-6 * (1.0 + of.slopes[0][0][k].norm()),
                        "{slope} {}",
                        of.slopes[0][0][k]
                    );
                }
            }
        }
    }
}
