//! What is wrong with a channel before anything is fitted.

use super::notice::{NoticeKind, Notices};
use super::record::Channel;

/// A channel with fewer steps than this from end to end is coarse.
const FEWEST_STEPS: f64 = 24.0;

/// A peak that stays at its limit for this many samples is cut off.
const FLAT_SAMPLES: usize = 4;

/// So is a pulse of force that stays for this many.
const FLAT_SAMPLES_OF_FORCE: usize = 3;

/// So are several peaks that reach exactly the same value for two samples or more.
const FLAT_PEAKS: usize = 2;

/// Tells of channels that do not move, are cut off, or move in few steps; whether it can be used.
pub(super) fn check_channel(channel: &Channel, is_force: bool, notices: &mut Notices) -> bool {
    let (low, high) = range(&channel.samples);
    if high - low <= 1e-12 * high.abs().max(low.abs()) {
        let what = format!("has the same value {low:e} all the time; the channel is left out");
        notices.add(NoticeKind::DeadChannel, Some(&channel.name), what);
        return false;
    }
    let steps = steps(&channel.samples, high - low);
    // A force has but a few samples in each pulse.
    if !is_force && steps < FEWEST_STEPS {
        let what = format!(
            "moves in {:.0} steps from end to end; rounding adds noise, and clipping cannot be told; use a \
             finer range or a harder hit",
            steps
        );
        notices.add(NoticeKind::CoarseSteps, Some(&channel.name), what);
        return true;
    }
    for (limit, name) in [(high, "highest"), (low, "lowest")] {
        // A force rests at one of its ends.
        let rests = is_force && limit.abs() < 0.5 * high.abs().max(low.abs());
        let runs = runs_at(&channel.samples, limit);
        let longest = runs.iter().copied().max().unwrap_or(0);
        let peaks = runs.iter().filter(|run| **run >= 2).count();
        let is_flat = if is_force {
            longest >= FLAT_SAMPLES_OF_FORCE
        } else {
            longest >= FLAT_SAMPLES || peaks >= FLAT_PEAKS
        };
        if !rests && is_flat {
            let samples: usize = runs.iter().sum();
            let what = format!(
                "{samples} samples lie exactly at the {name} value {limit:.4e}, up to {longest} in a row: it \
                 seems clipped, which bends damping and shapes; lower the gain or hit less hard"
            );
            notices.add(NoticeKind::Clipping, Some(&channel.name), what);
        }
    }
    true
}

fn range(samples: &[f64]) -> (f64, f64) {
    let fold = |start: f64, by: fn(f64, f64) -> f64| samples.iter().copied().fold(start, by);
    let (low, high) = (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// Smallest steps of the values that fit into their range.
fn steps(samples: &[f64], range: f64) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let smallest = sorted
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|step| *step > 1e-9 * range)
        .fold(range, f64::min);
    range / smallest
}

/// The step that all values are multiples of, as a converter with few bits makes them; `None` where none is
/// seen.
pub(super) fn rounding_step(samples: &[f64]) -> Option<f64> {
    /// Mean distance of the gaps from whole steps, as a share; gaps without a grid have a quarter.
    const MOST_OFF: f64 = 0.1;
    let (low, high) = range(samples);
    let range = high - low;
    let smallest = range / steps(samples, range);
    if !(smallest > 0.0 && smallest.is_finite()) {
        return None;
    }
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let gaps: Vec<f64> = sorted
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|gap| *gap >= 0.5 * smallest)
        .collect();
    let count: f64 = gaps.iter().map(|gap| (gap / smallest).round()).sum();
    let step = range / count.max(1.0);
    let off = |gap: &f64| (gap / step - (gap / step).round()).abs();
    let mean = gaps.iter().map(off).sum::<f64>() / gaps.len().max(1) as f64;
    (mean < MOST_OFF).then_some(step)
}

/// Lengths of the runs of samples at one value.
fn runs_at(samples: &[f64], value: f64) -> Vec<usize> {
    let mut runs = Vec::new();
    let mut run = 0;
    for sample in samples.iter().copied().chain([f64::NAN]) {
        if (sample - value).abs() <= 1e-9 * value.abs() {
            run += 1;
        } else if run > 0 {
            runs.push(run);
            run = 0;
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measured::record::Quantity;

    fn told(samples: Vec<f64>, is_force: bool) -> Vec<NoticeKind> {
        let channel = Channel { name: "a".into(), quantity: Quantity::Unknown, samples };
        let mut notices = Notices::about("r");
        check_channel(&channel, is_force, &mut notices);
        notices.list.iter().map(|notice| notice.kind).collect()
    }

    #[test]
    fn the_step_of_rounded_values_is_seen_and_none_in_others() {
        let decay = |k: i32| 10.0 * (-0.01 * f64::from(k)).exp() * (0.3 * f64::from(k)).cos();
        let sound: Vec<f64> = (0..900).map(decay).collect();
        assert_eq!(rounding_step(&sound), None);
        let rounded: Vec<f64> = sound.iter().map(|v| (v / 0.01).round() * 0.01).collect();
        assert!((rounding_step(&rounded).unwrap() - 0.01).abs() < 1e-9);
        assert_eq!(rounding_step(&[]), None);
        assert_eq!(rounding_step(&[1.0; 5]), None);
    }

    #[test]
    fn channels_that_cannot_be_trusted_are_told() {
        let decay = |k: i32| 10.0 * (-0.01 * f64::from(k)).exp() * (0.3 * f64::from(k)).cos();
        let sound: Vec<f64> = (0..500).map(decay).collect();
        assert_eq!(told(sound.clone(), false), []);
        let clipped: Vec<f64> = sound.iter().map(|v| v.clamp(-6.0, 6.0)).collect();
        assert_eq!(told(clipped, false), [NoticeKind::Clipping; 2]);
        let coarse: Vec<f64> = sound.iter().map(|v| v.round()).collect();
        assert_eq!(told(coarse, false), [NoticeKind::CoarseSteps]);
        assert_eq!(told(vec![3.0; 9], false), [NoticeKind::DeadChannel]);
        let mut force = vec![0.0; 500];
        for (k, f) in [1.0, 2.2, 3.1, 2.9, 1.4].into_iter().enumerate() {
            force[100 + k] = f + 1e-3;
        }
        force[300] = 0.01;
        assert_eq!(told(force.clone(), true), []);
        force[101..104].fill(2.0);
        assert_eq!(told(force, true), [NoticeKind::Clipping]);
    }
}
