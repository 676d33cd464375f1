//! Poles of rising order by linear least squares on a common denominator in z = e^{iωT} (LSCF:
//! Guillaume, Verboven, Vanlanduit, Van der Auweraer & Peeters, IMAC 2003), for the stabilisation
//! diagram and as starts of the fit. Each response has its own numerator, which is eliminated; so a
//! record with one reference has the matrix fraction of the poly-reference method. The highest
//! coefficient is held at one: then the poles of vibrations decay, and those of noise grow
//! (Cauberghe, Guillaume, Verboven, Vanlanduit & Parloo, Mech. Syst. Signal Process. 19, 2005) and
//! are left out.

use nalgebra::{DMatrix, DVector, Schur};
use schemars::JsonSchema;
use serde::Serialize;

use super::block::{C64, Pole};
use crate::statistics::upper_median;
use crate::units::{hz_from_rad_per_s, rad_per_s_from_hz};

/// Poles of neighbouring orders within this relative distance of frequency count as one.
const SAME_FREQUENCY: f64 = 0.01;

/// How a pole compares with those of the next lower order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stability {
    /// Nothing like it.
    New,
    /// The frequency is the same.
    Frequency,
    /// Frequency and damping are the same.
    Pole,
}

/// A point of a stabilisation diagram.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "JsonPoint")]
pub struct StabilisationPoint {
    /// Order of the denominator.
    pub order: usize,
    /// Natural frequency, Hz.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Compared with the next lower order: new, frequency, pole.
    #[serde(rename = "stable")]
    #[schemars(with = "String")]
    pub stability: Stability,
}

/// Orders with their poles, ascending.
pub(in crate::identify) type PolesByOrder = Vec<(usize, Vec<Pole>)>;

/// Poles of all even orders up to the highest, by order. A band that begins far above zero is
/// moved down to zero, as its lines would fill but a small part of the unit circle. Where the
/// errors are `relative` to the responses, each line counts as much as the others, and a light mode
/// is not drowned by loud ones.
pub(in crate::identify) fn poles_by_order(
    sets: &[(&[f64], &[Vec<C64>])],
    highest: usize,
    relative: bool,
) -> PolesByOrder {
    /// Lines for each coefficient.
    const LINES: usize = 5;
    /// Of the highest line: a gap around zero of so much of the circle leaves the coefficients of
    /// the highest orders without a determination.
    const FAR_ABOVE_ZERO: f64 = 0.05;
    let lines = sets.iter().map(|(omega, _)| omega.len()).min().unwrap_or(0);
    let highest = highest.min(lines / LINES);
    let top = sets.iter().filter_map(|(omega, _)| omega.last()).fold(0.0_f64, |a, b| a.max(*b));
    let low = sets.iter().filter_map(|(omega, _)| omega.first()).fold(top, |a, b| a.min(*b));
    if highest < 2 || top <= 0.0 {
        return Vec::new();
    }
    let shift = if low > FAR_ABOVE_ZERO * top { low - (top - low) / lines as f64 } else { 0.0 };
    let step = std::f64::consts::PI / (top - shift);
    let mut normal = DMatrix::zeros(highest + 1, highest + 1);
    for (omega, spectra) in sets {
        let weights = if relative { inverse_powers(spectra) } else { vec![1.0; omega.len()] };
        let omega: Vec<f64> = omega.iter().map(|w| w - shift).collect();
        for spectrum in *spectra {
            if let Some(reduced) = reduced((&omega, &weights), spectrum, step, highest) {
                normal += reduced;
            }
        }
    }
    (2..=highest)
        .step_by(2)
        .map(|order| (order, roots(&normal, order, step, shift).unwrap_or_default()))
        .collect()
}

/// One over each line's power in all responses, each response about as loud as the others.
fn inverse_powers(spectra: &[Vec<C64>]) -> Vec<f64> {
    /// Relative to the loudest line: below it there is noise alone.
    const LEAST: f64 = 1e-6;
    let mut powers = vec![0.0; spectra.first().map_or(0, Vec::len)];
    for spectrum in spectra {
        let own: Vec<f64> = spectrum.iter().map(C64::norm_sqr).collect();
        let mean = own.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        powers.iter_mut().zip(&own).for_each(|(sum, own)| *sum += own / mean);
    }
    let loudest = powers.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    powers.iter().map(|power| loudest / power.max(LEAST * loudest)).collect()
}

/// Normal matrix of the denominator of one response on weighted lines, its numerator eliminated.
fn reduced(
    (omega, weights): (&[f64], &[f64]),
    spectrum: &[C64],
    step: f64,
    order: usize,
) -> Option<DMatrix<f64>> {
    let powers = spectrum.iter().zip(weights).map(|(value, weight)| weight * value.norm_sqr());
    let mean = powers.sum::<f64>() / weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    if mean <= 0.0 || !mean.is_finite() {
        return None;
    }
    let (mut ones, mut mixed, mut squares) =
        (vec![0.0; order + 1], vec![0.0; 2 * order + 1], vec![0.0; order + 1]);
    for ((w, value), weight) in omega.iter().zip(spectrum).zip(weights) {
        let turn = C64::from_polar(1.0, -w * step);
        let back = turn.conj().powi(order as i32);
        let power = weight * value.norm_sqr() / mean;
        let scaled = value * (weight / mean.sqrt());
        let mut z = C64::new(1.0, 0.0);
        for d in 0..=order {
            ones[d] += weight * z.re;
            squares[d] += power * z.re;
            z *= turn;
        }
        let mut z = back;
        for sum in &mut mixed {
            *sum += (scaled * z).re;
            z *= turn;
        }
    }
    let size = order + 1;
    // Re (z^i)* z^j H = Re H z^(j−i).
    let r = DMatrix::from_fn(size, size, |i, j| ones[i.abs_diff(j)]);
    let s = DMatrix::from_fn(size, size, |i, j| -mixed[order + j - i]);
    let t = DMatrix::from_fn(size, size, |i, j| squares[i.abs_diff(j)]);
    let solved = r.cholesky()?.solve(&s);
    let reduced = t - s.transpose() * solved;
    reduced.iter().all(|v| v.is_finite()).then_some(reduced)
}

/// Poles that decay, from the denominator of one order; frequencies were moved down by `shift`.
fn roots(normal: &DMatrix<f64>, order: usize, step: f64, shift: f64) -> Option<Vec<Pole>> {
    let matrix = normal.view((0, 0), (order, order)).into_owned();
    let right = DVector::from_fn(order, |i, _| -normal[(i, order)]);
    let low = matrix.lu().solve(&right)?;
    if !low.iter().all(|v| v.is_finite()) {
        return None;
    }
    let mut companion = DMatrix::zeros(order, order);
    for i in 0..order {
        companion[(i, order - 1)] = -low[i];
        if i > 0 {
            companion[(i, i - 1)] = 1.0;
        }
    }
    let values = Schur::try_new(companion, 1e-12, 10_000)?.complex_eigenvalues();
    let poles = values
        .iter()
        .filter(|delay| delay.norm() > 1e-12)
        .map(|delay| -delay.ln() / step)
        .filter(|lambda| lambda.im > 0.0 && lambda.im < 0.999 * std::f64::consts::PI / step)
        .map(|lambda| Pole::new(lambda + C64::new(0.0, shift)))
        .filter(|pole| {
            let ratio = pole.ratio();
            ratio > 0.0
                // More damping is no vibration worth showing.
                && ratio < 0.25
        });
    Some(poles.collect())
}

/// The poles of all orders, each against those of the order before it.
pub(in crate::identify) fn stabilisation(
    by_order: &[(usize, Vec<Pole>)],
) -> Vec<StabilisationPoint> {
    let mut points = Vec::new();
    for (at, (order, poles)) in by_order.iter().enumerate() {
        let before: &[Pole] = at.checked_sub(1).map_or(&[], |before| &by_order[before].1);
        for pole in poles {
            let is_near = |old: &&Pole| (old.omega() / pole.omega() - 1.0).abs() < 0.01;
            let stability = if before
                .iter()
                .filter(is_near)
                .any(|old| (old.ratio() / pole.ratio() - 1.0).abs() < 0.1)
            {
                Stability::Pole
            } else if before.iter().any(|old| is_near(&old)) {
                Stability::Frequency
            } else {
                Stability::New
            };
            points.push(StabilisationPoint {
                order: *order,
                frequency_hz: hz_from_rad_per_s(pole.omega()),
                damping_ratio: pole.ratio(),
                stability,
            });
        }
    }
    points
}

/// One pole for each column of a stabilisation diagram: the median of those that keep their
/// frequency.
pub(in crate::identify) fn candidates(points: &[StabilisationPoint]) -> Vec<Pole> {
    let mut steady: Vec<&StabilisationPoint> =
        points.iter().filter(|point| point.stability >= Stability::Frequency).collect();
    steady.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let mut found = Vec::new();
    let mut from = 0;
    for to in 1..=steady.len() {
        let breaks = to == steady.len()
            || steady[to].frequency_hz > steady[to - 1].frequency_hz * (1.0 + 0.2 * SAME_FREQUENCY)
            || steady[to].frequency_hz > steady[from].frequency_hz * (1.0 + 2.0 * SAME_FREQUENCY);
        if breaks {
            let group = &steady[from..to];
            if group.len() >= 3 {
                let dampings: Vec<f64> = group.iter().map(|p| p.damping_ratio).collect();
                let omega = rad_per_s_from_hz(group[group.len() / 2].frequency_hz);
                found.extend(upper_median(&dampings).map(|ratio| Pole::from_modal(omega, ratio)));
            }
            from = to;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three modes, two of them 3 % apart, without noise: all orders from 12 on hold them.
    #[test]
    fn poles_of_an_exact_response_are_found_at_every_order() {
        let truth = [
            Pole::from_modal(130.0, 0.01),
            Pole::from_modal(133.9, 0.015),
            Pole::from_modal(300.0, 0.02),
        ];
        let omega: Vec<f64> = (1..350).map(|k| f64::from(k) * 1.2566).collect();
        let spectrum: Vec<C64> = omega
            .iter()
            .map(|w| {
                let one = |p: &Pole| {
                    (C64::new(0.0, *w) - p.lambda).inv()
                        + (C64::new(0.0, *w) - p.lambda.conj()).inv()
                };
                truth.iter().map(one).sum()
            })
            .collect();
        let by_order = poles_by_order(&[(&omega, &[spectrum])], 48, false);
        for (order, poles) in by_order.iter().filter(|(order, _)| (16..=40).contains(order)) {
            for pole in &truth {
                let error = poles
                    .iter()
                    .map(|found| (found.lambda - pole.lambda).norm() / pole.omega())
                    .fold(f64::INFINITY, f64::min);
                assert!(error < 1e-3, "order {order}: {error}");
            }
        }
        let found = candidates(&stabilisation(&by_order));
        assert!(
            truth.iter().all(|p| found.iter().any(|f| (f.omega() / p.omega() - 1.0).abs() < 1e-3))
        );
    }

    /// Lines from a quarter of the highest on: what is not covered of the circle takes the poles of
    /// no order away.
    #[test]
    fn poles_of_a_band_above_zero_are_found_at_every_order() {
        let truth = [Pole::from_modal(160.0, 0.01), Pole::from_modal(300.0, 0.02)];
        let omega: Vec<f64> = (98..350).map(|k| f64::from(k) * 1.2566).collect();
        let at =
            |w: &f64| -> C64 { truth.iter().map(|p| (C64::new(0.0, *w) - p.lambda).inv()).sum() };
        let spectrum: Vec<C64> = omega.iter().map(at).collect();
        for relative in [false, true] {
            let by_order =
                poles_by_order(&[(&omega, std::slice::from_ref(&spectrum))], 48, relative);
            for (order, poles) in by_order.iter().filter(|(order, _)| *order >= 16) {
                let is_found = |pole: &Pole| {
                    poles.iter().any(|p| (p.lambda - pole.lambda).norm() < 1e-3 * pole.omega())
                };
                assert!(truth.iter().all(is_found), "order {order}, {relative}: {poles:?}");
            }
        }
    }
}
