//! Samples at uneven times → samples at even ones, by the cubic spline through them (second
//! derivative zero at both ends: Press et al., Numerical Recipes, 3rd ed., §3.3).

use crate::identify::record::{Channel, mean_rate_hz};
use crate::notes::{Code, Notes};
use crate::units::ms_from_s;

/// Even times in place of uneven ones.
pub(super) struct Resampled<'t> {
    times_s: &'t [f64],
    pub(super) rate_hz: f64,
}

/// At the mean rate, with a note on what that does; `None` where the times do not rise.
pub(super) fn resampled_evenly<'t>(times_s: &'t [f64], notes: &mut Notes) -> Option<Resampled<'t>> {
    let rate_hz = mean_rate_hz(times_s)?;
    if !times_s.windows(2).all(|pair| pair[1] > pair[0]) {
        return None;
    }
    let steps = || times_s.windows(2).map(|pair| pair[1] - pair[0]);
    let resampled = Resampled { times_s, rate_hz };
    let what = format!(
        "its times are uneven, {:.2} to {:.2} ms apart: it was resampled at {rate_hz:.3} samples/s \
         by a cubic spline, which is right up to {:.1} Hz",
        ms_from_s(steps().fold(f64::INFINITY, f64::min)),
        ms_from_s(steps().fold(0.0, f64::max)),
        resampled.highest_hz()
    );
    notes.warning(Code::Remark, None, what);
    Some(resampled)
}

impl Resampled<'_> {
    /// Up to here the spline keeps amplitudes within some per cent.
    pub(super) fn highest_hz(&self) -> f64 {
        const SHARE_OF_RATE: f64 = 0.3;
        SHARE_OF_RATE * self.rate_hz
    }

    /// A channel at the even times.
    pub(super) fn channel(&self, channel: &Channel) -> Channel {
        let (times, values) = (self.times_s, &channel.samples[..]);
        let bends = bends(times, values);
        let first = times.first().copied().unwrap_or(0.0);
        let mut before = 0;
        let at = |k: usize| {
            let time = first + k as f64 / self.rate_hz;
            while before + 2 < times.len() && times[before + 1] < time {
                before += 1;
            }
            between(times, values, &bends, before, time)
        };
        Channel { samples: (0..values.len()).map(at).collect(), ..channel.clone() }
    }
}

/// Second derivatives of the spline at its points, by elimination in a tridiagonal matrix.
fn bends(times: &[f64], values: &[f64]) -> Vec<f64> {
    let count = times.len();
    let (mut ratio, mut right) = (vec![0.0; count], vec![0.0; count]);
    for k in 1..count.saturating_sub(1) {
        let (left_step, right_step) = (times[k] - times[k - 1], times[k + 1] - times[k]);
        let slopes =
            (values[k + 1] - values[k]) / right_step - (values[k] - values[k - 1]) / left_step;
        let diagonal = 2.0 * (left_step + right_step) - left_step * ratio[k - 1];
        ratio[k] = right_step / diagonal;
        right[k] = (6.0 * slopes - left_step * right[k - 1]) / diagonal;
    }
    let mut bends = vec![0.0; count];
    for k in (1..count.saturating_sub(1)).rev() {
        bends[k] = right[k] - ratio[k] * bends[k + 1];
    }
    bends
}

/// The spline at a time between two of its points.
fn between(times: &[f64], values: &[f64], bends: &[f64], before: usize, time: f64) -> f64 {
    let after = before + 1;
    let step = times[after] - times[before];
    let a = (times[after] - time) / step;
    let b = 1.0 - a;
    a * values[before]
        + b * values[after]
        + ((a.powi(3) - a) * bends[before] + (b.powi(3) - b) * bends[after]) * step * step / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::record::Quantity;

    /// A tone at a fifth of the rate, its samples off by up to a third of a step.
    #[test]
    fn a_tone_at_uneven_times_comes_back() {
        let mut state = 3_u64;
        let mut shift = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_041);
            0.6 * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5)
        };
        let times: Vec<f64> = (0..400).map(|k| 0.01 * (f64::from(k) + shift())).collect();
        let tone = |t: f64| (std::f64::consts::TAU * 20.0 * t + 0.3).sin();
        let samples = times.iter().map(|t| tone(*t)).collect();
        let channel = Channel { name: "x".into(), quantity: Quantity::Unknown, samples };
        let mut notes = Notes::default();
        let resampled = resampled_evenly(&times, &mut notes).unwrap();
        assert!(notes.list()[0].what.contains("cubic spline"), "{:?}", notes.list());
        let even = resampled.channel(&channel);
        let error = |k: usize| even.samples[k] - tone(times[0] + k as f64 / resampled.rate_hz);
        let inner = (20..380).map(|k| error(k).powi(2)).sum::<f64>() / 360.0;
        assert!(inner.sqrt() < 0.03, "{}", inner.sqrt());
        // Without the spline's bends it is a straight line, four times as far off.
        let straight = (20..380).map(|k| {
            let t = times[0] + k as f64 / resampled.rate_hz;
            let at = times.partition_point(|own| *own < t).clamp(1, 399) - 1;
            between(&times, &channel.samples, &vec![0.0; 400], at, t) - tone(t)
        });
        let straight = straight.map(|e| e * e).sum::<f64>() / 360.0;
        assert!(inner < straight / 9.0, "{inner} {straight}");
        assert!(resampled_evenly(&[0.0, 1.0, 1.0], &mut notes).is_none());
        assert!(resampled_evenly(&[], &mut notes).is_none());
    }
}
