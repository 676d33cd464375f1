//! What a Hann window makes of a frequency response that an analyser averaged over stretches of a
//! random excitation: its impulse response times the window's autocorrelation,
//!
//! ```text
//! r(t) = (1 − t/T)(⅔ + ⅓ cos Ωt) + sin(Ωt)/2π,   Ω = 2π/T,   0 ≤ t ≤ T
//! b(ω) = ∫ r(t) e^{(λ − iω)t} dt
//! ```
//!
//! for stretches of T seconds (Bendat & Piersol, Random Data, 4th ed., §5.3 and 11.5: averaged
//! spectra are those of the windowed correlations).

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use super::block::C64;
use crate::statistics::upper_median;

/// b and its derivative by λ, with s = λ − iω, over stretches of `length_s`.
pub(super) fn response(s: C64, length_s: f64) -> (C64, C64) {
    let turn = C64::new(0.0, TAU / length_s);
    // A whole turn leaves it as it is.
    let e = (s * length_s).exp();
    let [(_, ramp), (up, ramp_up), (down, ramp_down)] =
        [s, s + turn, s - turn].map(|s| integrals(s, e, length_s));
    let sine = C64::new(0.0, -0.25 / PI);
    let sum = |part: fn((C64, C64)) -> C64| {
        part(ramp) * (2.0 / 3.0)
            + (part(ramp_up) + part(ramp_down)) / 6.0
            + sine * (part(up) - part(down))
    };
    (sum(|own| own.0), sum(|own| own.1))
}

/// ∫ e^{st} dt and ∫ (1 − t/T) e^{st} dt over 0 … T with e = e^{sT}, each with its derivative by s.
fn integrals(s: C64, e: C64, length_s: f64) -> ((C64, C64), (C64, C64)) {
    let x = s * length_s;
    if x.norm_sqr() < NEAR * NEAR {
        let value = 1.0 + x * (0.5 + x * (1.0 / 6.0 + x / 24.0));
        let slope = 0.5 + x * (1.0 / 3.0 + x * (0.125 + x / 30.0));
        let ramp = 0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x / 120.0));
        let ramp_slope = 1.0 / 6.0 + x * (1.0 / 12.0 + x * (0.025 + x / 180.0));
        let [first, second] = [length_s, length_s.powi(2)];
        return ((value * first, slope * second), (ramp * first, ramp_slope * second));
    }
    let over = s.inv();
    let value = (e - 1.0) * over;
    let whole = value / length_s;
    let constant = (value, (e * length_s - value) * over);
    (constant, ((whole - 1.0) * over, (1.0 + e - whole * 2.0) * over * over))
}

/// Below it the series are exact to 1e-10.
const NEAR: f64 = 5e-3;

/// How long the stretches of an analyser are by its lines, s; `None` where these do not lie evenly.
/// Some may be left out.
pub(super) fn length_s(omega: &[f64]) -> Option<f64> {
    let steps = || omega.windows(2).map(|pair| pair[1] - pair[0]);
    let apart = steps().reduce(f64::min).filter(|apart| *apart > 0.0)?;
    let is_even = |step: f64| (step / apart - (step / apart).round()).abs() < 1e-3 * step / apart;
    steps().all(is_even).then_some(TAU / apart)
}

/// Whether frequency responses on equal lines have peaks as a Hann window makes them: the sharpest
/// of them are fitted with one pole each, with the window and without.
pub(in crate::identify) fn is_windowed(omega: &[f64], spectra: &[Vec<C64>]) -> Option<f64> {
    /// Lines to either side of a peak.
    const REACH: usize = 6;
    /// Most peaks that are looked at, and how high they must be above the median line and the lines
    /// next but one: wide peaks say nothing of a window.
    const PEAKS: usize = 6;
    const MIN_HEIGHT: f64 = 100.0;
    const MIN_SHARPNESS: f64 = 2.0;
    /// Sum of ln of the sums of squares, with the window over without.
    const MAX_LN_RATIO: f64 = -0.2;
    let length_s = length_s(omega).filter(|_| omega.len() > 2 * REACH)?;
    let power: Vec<f64> =
        (0..omega.len()).map(|k| spectra.iter().map(|own| own[k].norm_sqr()).sum()).collect();
    let sharpness = |k: usize| power[k] / (power[k - 2] + power[k + 2]).max(f64::MIN_POSITIVE);
    let floor = MIN_HEIGHT * upper_median(&power)?;
    let mut peaks: Vec<usize> = (REACH..omega.len() - REACH)
        .filter(|&k| power[k] >= power[k - 1] && power[k] > power[k + 1])
        .filter(|&k| power[k] > floor && sharpness(k) > MIN_SHARPNESS)
        .collect();
    peaks.sort_by(|&a, &b| power[b].total_cmp(&power[a]));
    let ln_ratio = |&k: &usize| {
        let lines = k - REACH..=k + REACH;
        let cut: Vec<&[C64]> = spectra.iter().map(|own| &own[lines.clone()]).collect();
        let own = &omega[lines];
        let with = misfit(own, &cut, |s| response(s, length_s).0);
        (with / misfit(own, &cut, |s| -s.inv()).max(f64::MIN_POSITIVE)).ln()
    };
    let sum: f64 = peaks.iter().take(PEAKS).map(ln_ratio).sum();
    (sum < MAX_LN_RATIO).then_some(length_s)
}

/// Least sum of squares of one pole near the middle of the lines, and a straight background.
fn misfit(omega: &[f64], spectra: &[&[C64]], basis: impl Fn(C64) -> C64) -> f64 {
    let n = omega.len();
    let (middle, apart) = (omega[n / 2], (omega[n - 1] - omega[0]) / (n - 1) as f64);
    let mut least = f64::INFINITY;
    for place in -10..=10 {
        for step in 0..16 {
            // From a hundredth of a line to several lines wide.
            let decay = 0.01 * apart * 1.6_f64.powi(step);
            let lambda = C64::new(-decay, middle + 0.1 * f64::from(place) * apart);
            let columns = DMatrix::from_fn(n, 3, |k, column| match column {
                0 => basis(lambda - C64::new(0.0, omega[k])) * apart,
                1 => C64::new(1.0, 0.0),
                _ => C64::new((omega[k] - middle) / apart / n as f64, 0.0),
            });
            let Some(factor) = (columns.adjoint() * &columns).cholesky() else { continue };
            let left = |own: &&[C64]| {
                let own = DVector::from_column_slice(own);
                let shares = factor.solve(&(columns.adjoint() * &own));
                (own - &columns * shares).norm_squared()
            };
            least = least.min(spectra.iter().map(left).sum());
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against sums over the window itself.
    #[test]
    fn the_response_is_the_integral_with_the_windows_autocorrelation() {
        const STEPS: usize = 4000;
        let length_s = 0.8;
        let dt = length_s / STEPS as f64;
        let hann: Vec<f64> =
            (0..STEPS).map(|k| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / STEPS as f64).cos()).collect();
        let correlation =
            |lag: usize| -> f64 { (0..STEPS - lag).map(|k| hann[k] * hann[k + lag]).sum::<f64>() };
        let whole = correlation(0);
        for s in [C64::new(-0.3, 2.0), C64::new(-4.0, -30.0), C64::new(-1e-4, 1e-4)] {
            let mut sum = C64::default();
            for lag in 0..STEPS {
                let weight = if lag == 0 { 0.5 } else { 1.0 };
                sum += (s * (lag as f64 * dt)).exp() * (weight * correlation(lag) / whole * dt);
            }
            let (value, slope) = response(s, length_s);
            assert!((value - sum).norm() < 1e-5 * sum.norm(), "{s}: {value} {sum}");
            let step = 1e-6;
            let by =
                (response(s + step, length_s).0 - response(s - step, length_s).0) / (2.0 * step);
            assert!((slope - by).norm() < 1e-5 * by.norm(), "{s}: {slope} {by}");
        }
    }
}
