//! Peaks of spectra: where modes are that the least squares over a wide band do not reach, and
//! where a wide band with many modes can be divided.

use super::block::{C64, Pole};
use crate::statistics::mean;

/// Peaks of the power of all responses, each response about as loud as the others, as poles by
/// ascending frequency. `shallow` ones count where modes near by may fill the gaps between peaks.
pub(in crate::identify) fn peaks(omega: &[f64], spectra: &[Vec<C64>], shallow: bool) -> Vec<Pole> {
    /// Share of the frequency that counts as one line where the lines lie closer: no mode of an arm
    /// is much narrower.
    const FINEST: f64 = 0.002;
    /// Such lines to either side that a peak is above, and those within which it falls.
    const TOP: usize = 3;
    const REACH: usize = 16;
    /// By how much the power falls to either side of a peak; less, where the peak is so many times
    /// as high as a quarter of all lines, as noise is not.
    const FALL: f64 = 4.0;
    const SHALLOW: f64 = 2.0;
    const OUT_OF_NOISE: f64 = 30.0;
    /// Relative to the loudest line: lower ones are noise or feet.
    const LEAST: f64 = 1e-5;
    let sizes = spectra.iter().map(|own| own.iter().map(C64::norm_sqr).fold(0.0, f64::max));
    let sizes: Vec<f64> = sizes.map(|size| size.max(f64::MIN_POSITIVE)).collect();
    let raw: Vec<f64> = (0..omega.len())
        .map(|k| spectra.iter().zip(&sizes).map(|(own, size)| own[k].norm_sqr() / size).sum())
        .collect();
    let lines = raw.len();
    let line = if lines < 2 { 1.0 } else { (omega[lines - 1] - omega[0]) / (lines - 1) as f64 };
    let finest = |k: usize| (FINEST * omega[k] / line).round().max(1.0) as usize;
    let power: Vec<f64> = (0..lines)
        .map(|k| {
            let near = finest(k) - 1;
            mean(&raw[k.saturating_sub(near)..(k + near + 1).min(lines)])
        })
        .collect();
    let least = |from: usize, to: usize| power[from..to].iter().copied().fold(f64::MAX, f64::min);
    let mut sorted = power.clone();
    let quarter = sorted.len() / 4;
    let quiet = if sorted.is_empty() {
        f64::INFINITY
    } else {
        *sorted.select_nth_unstable_by(quarter, f64::total_cmp).1
    };
    let fall = |k: usize| if shallow && power[k] > OUT_OF_NOISE * quiet { SHALLOW } else { FALL };
    let is_peak = |&k: &usize| {
        let (top, reach) = (TOP * finest(k), REACH * finest(k));
        let near = &power[k.saturating_sub(top)..(k + top + 1).min(lines)];
        power[k] > LEAST
            && near.iter().all(|other| *other <= power[k])
            && power[k] > fall(k) * least(k.saturating_sub(reach), k.max(1))
            && power[k] > fall(k) * least((k + 1).min(lines - 1), (k + 1 + reach).min(lines))
    };
    let half_width = |k: usize| {
        let below = |other: &f64| *other < 0.5 * power[k];
        let after = power[k..].iter().position(below).unwrap_or(TOP).max(1);
        let before = power[..k].iter().rev().position(below).unwrap_or(TOP) + 1;
        after.min(before) as f64 * line
    };
    let pole = |k: usize| Pole::new(C64::new(-half_width(k).min(0.1 * omega[k]), omega[k]));
    if lines < 2 { Vec::new() } else { (0..lines).filter(is_peak).map(pole).collect() }
}

/// Where to divide a band with many poles, rad/s, ascending: the ends of stretches of `count` poles
/// or more, from zero to infinity, each at least `lines` lines wide where these lie evenly.
pub(in crate::identify) fn divisions(
    poles: &[Pole],
    omega: &[f64],
    count: usize,
    lines: usize,
) -> Vec<f64> {
    /// Poles this many times their decay rates apart can be in different stretches.
    const FAR: f64 = 2.0;
    let mut ends = vec![0.0_f64];
    if let [first, .., last] = omega {
        let line = (last - first) / (omega.len() - 1) as f64;
        let mut sorted: Vec<&Pole> = poles.iter().collect();
        sorted.sort_by(|a, b| a.omega().total_cmp(&b.omega()));
        let mut held = 0;
        for pair in sorted.windows(2) {
            held += 1;
            let [a, b] = [pair[0], pair[1]].map(|p| (p.omega(), p.lambda.re.abs() + line));
            let end = a.0 + (b.0 - a.0) * a.1 / (a.1 + b.1);
            let from = ends.last().copied().unwrap_or(0.0).max(*first);
            let is_wide = |from: f64, to: f64| to - from > lines as f64 * line;
            let is_far = b.0 - a.0 > FAR * (a.1 + b.1);
            if held >= count && is_far && is_wide(from, end) && is_wide(end, *last) {
                ends.push(end);
                held = 0;
            }
        }
    }
    ends.push(f64::INFINITY);
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten poles 10 rad/s apart: each is a peak, and five stretches of two part between them.
    #[test]
    fn each_mode_is_a_peak_and_stretches_part_between_them() {
        let truth: Vec<Pole> = (1..=10)
            .map(|i| Pole::from_modal(10.0 * f64::from(i), 0.5 / (10.0 * f64::from(i))))
            .collect();
        let omega: Vec<f64> = (1..600).map(|k| 0.2 * f64::from(k)).collect();
        let at = |w: &f64| truth.iter().map(|p| (C64::new(0.0, *w) - p.lambda).inv()).sum::<C64>();
        let found = peaks(&omega, &[omega.iter().map(at).collect()], true);
        assert_eq!(found.len(), 10);
        for (found, truth) in found.iter().zip(&truth) {
            assert!((found.lambda.im - truth.lambda.im).abs() < 0.3, "{found:?}");
            assert!((0.3..1.0).contains(&-found.lambda.re), "{found:?}");
        }
        let ends = divisions(&found, &omega, 2, 20);
        assert_eq!(ends.len(), 6, "{ends:?}");
        assert!(ends[1] > 22.0 && ends[1] < 28.0, "{ends:?}");
        // With 1 % of damping, on lines ten times as close: from 5 to 50 of them to a half width.
        let truth: Vec<Pole> =
            (1..=10).map(|i| Pole::from_modal(10.0 * f64::from(i), 0.01)).collect();
        let at = |w: &f64| truth.iter().map(|p| (C64::new(0.0, *w) - p.lambda).inv()).sum::<C64>();
        let omega: Vec<f64> = (1..6000).map(|k| 0.02 * f64::from(k)).collect();
        let noise = |k: usize| C64::from_polar(0.02, 1e3 * (k as f64).sin());
        let noisy = omega.iter().enumerate().map(|(k, w)| at(w) + noise(k)).collect();
        assert_eq!(peaks(&omega, &[noisy], true).len(), 10);
        assert!(
            peaks(&[], &[], true).is_empty()
                && peaks(&[1.0], &[vec![C64::default()]], true).is_empty()
        );
        assert_eq!(divisions(&[], &[], 4, 9).len(), 2);
    }
}
