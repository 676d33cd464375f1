//! What is wrong with a channel before anything is fitted.

use std::borrow::Cow;
use std::ops::Range;

use super::record::Channel;
use crate::notes::{Code, Notes, Part};

/// Warns of channels that do not move, are clipped, or move in few steps; whether it can be used.
pub(super) fn check_channel(channel: &Channel, is_force: bool, notes: &mut Notes) -> bool {
    let (low, high) = range(&channel.samples);
    if high - low <= 1e-12 * high.abs().max(low.abs()) {
        let what = format!("has the same value {low:e} all the time; the channel is left out");
        notes.channel_warning(Code::DeadChannel, &channel.name, what);
        return false;
    }
    let steps = steps(&channel.samples, high - low);
    // A force has but a few samples in each pulse.
    if !is_force && steps < 24.0 {
        let what = format!(
            "moves in {steps:.0} steps from end to end; quantisation adds noise, and clipping \
             cannot be detected; use a finer range or hit harder"
        );
        notes.channel_warning(Code::CoarseSteps, &channel.name, what);
        return true;
    }
    warn_of_clipping(channel, is_force, 1e-9, notes);
    true
}

/// Warns of a response that was clipped before a window was laid over it; `grown` is without that
/// window, so that numbers of a file with few digits are nearly equal.
pub(super) fn check_flat(grown: &Channel, notes: &mut Notes) {
    if !is_clipping_told(grown, notes) {
        warn_of_clipping(grown, false, 1e-5, notes);
    }
}

/// Warns of a channel that stays at its highest or lowest value, to a share of it. Slow motion in
/// coarse steps turns round there in a run of equal samples, too, but comes and goes by single
/// steps.
fn warn_of_clipping(channel: &Channel, is_force: bool, share: f64, notes: &mut Notes) {
    /// Steps to a neighbour of the run.
    const CORNER: f64 = 2.5;
    let (low, high) = range(&channel.samples);
    let step = (high - low) / steps(&channel.samples, high - low);
    for (limit, name) in [(high, "highest"), (low, "lowest")] {
        // A force rests at one of its ends.
        let rests = is_force && limit.abs() < 0.5 * high.abs().max(low.abs());
        let runs = runs_at(&channel.samples, limit, share, CORNER * step);
        if !rests && is_clipped(&runs, is_force) {
            let what = format!(
                "{} samples lie at the {name} value {limit:.4e}, up to {} in a row: it seems \
                 clipped, which distorts damping and shapes; lower the gain or hit less hard",
                runs.iter().sum::<usize>(),
                runs.iter().max().unwrap_or(&0)
            );
            notes.channel_warning(Code::Clipping, &channel.name, what);
        }
    }
}

/// Whether a channel that stays at its limit for these numbers of samples in a row is clipped: one
/// long run, or several peaks that reach exactly the same value.
fn is_clipped(runs: &[usize], is_force: bool) -> bool {
    let longest = runs.iter().copied().max().unwrap_or(0);
    let flat_peaks = runs.iter().filter(|run| **run >= 2).count();
    if is_force { longest >= 3 } else { longest >= 4 || flat_peaks >= 2 }
}

/// The channel with lone outliers, as glitches of the instrument leave them, put in line with their
/// neighbours, with a warning; not within the `protected` stretches, where an impact may look like
/// that.
pub(super) fn without_spikes<'c>(
    channel: &'c Channel,
    sample_rate_hz: f64,
    protected: &[Range<usize>],
    notes: &mut Notes,
) -> Cow<'c, Channel> {
    let mut spikes = spikes(&channel.samples);
    spikes.retain(|k| !protected.iter().any(|range| range.contains(k)));
    let Some(&first) = spikes.first() else { return Cow::Borrowed(channel) };
    let mut repaired = channel.clone();
    for &k in &spikes {
        repaired.samples[k] = from_neighbours(&channel.samples, k);
    }
    let others = match spikes.len() - 1 {
        0 => String::new(),
        more => format!(" and {more} more like it"),
    };
    let what = format!(
        "the sample at {:.4} s{others} is a lone outlier: {:.3e} where its neighbours suggest \
         {:.3e}; treated as an instrument glitch and interpolated",
        first as f64 / sample_rate_hz,
        channel.samples[first],
        repaired.samples[first]
    );
    notes.channel_warning(Code::Spike, &channel.name, what);
    Cow::Owned(repaired)
}

fn is_clipping_told(channel: &Channel, notes: &Notes) -> bool {
    let names = |part: &Part| match part {
        Part::Channel { channel: name, .. } => *name == channel.name,
        _ => false,
    };
    let mut of = notes.list().iter().filter(|note| note.code == Code::Clipping);
    of.any(|note| note.place.part.as_ref().is_some_and(names))
}

/// The channels that are not clipped; if all are, all are kept.
pub(super) fn without_clipped<'c>(
    channels: Vec<&'c Channel>,
    notes: &mut Notes,
) -> Vec<&'c Channel> {
    let clipped: Vec<bool> =
        channels.iter().map(|channel| is_clipping_told(channel, notes)).collect();
    if clipped.iter().all(|is| *is) {
        return channels;
    }
    for (channel, _) in channels.iter().zip(&clipped).filter(|(_, is)| **is) {
        let what = "is left out, as other channels are whole";
        notes.channel_warning(Code::Clipping, &channel.name, what);
    }
    channels.into_iter().zip(clipped).filter(|(_, is)| !is).map(|(channel, _)| channel).collect()
}

/// The channels that do not stand still in the middle of their motion, as a lost connection or a
/// full buffer leaves them; warns of the others. If all stand still, all are kept.
pub(super) fn without_gaps<'c>(
    channels: Vec<&'c Channel>,
    sample_rate_hz: f64,
    notes: &mut Notes,
) -> Vec<&'c Channel> {
    let gaps: Vec<Option<Range<usize>>> =
        channels.iter().map(|channel| gap(&channel.samples)).collect();
    let all = gaps.iter().all(Option::is_some);
    for (channel, gap) in channels.iter().zip(&gaps) {
        let Some(gap) = gap else { continue };
        let done = if all {
            "every channel has such a gap, so it is used, but do not trust the results"
        } else {
            "the channel is left out"
        };
        let what = format!(
            "has the same value {:.3e} for {} samples from {:.4} s on, in the middle of its \
             motion: samples seem to be lost; {done}; record again",
            channel.samples[gap.start],
            gap.len(),
            gap.start as f64 / sample_rate_hz
        );
        notes.channel_warning(Code::Dropout, &channel.name, what);
    }
    let kept = channels.into_iter().zip(gaps).filter(|(_, gap)| all || gap.is_none());
    kept.map(|(channel, _)| channel).collect()
}

/// The longest run of one value with far more motion just before and after it than the channel's
/// steps, and a jump into it or out of it: slow motion in coarse steps turns round in a long run,
/// too. Not at the ends of the range, where channels are clipped.
fn gap(samples: &[f64]) -> Option<Range<usize>> {
    /// Fewer equal samples may be chance, or slow motion in coarse steps.
    const MIN_SAMPLES: usize = 6;
    /// Samples on either side that are looked at.
    const AROUND: usize = 24;
    /// Steps of a jump.
    const JUMP: f64 = 3.5;
    let (low, high) = range(samples);
    let step = (high - low) / steps(samples, high - low);
    let moves = |stretch: &[f64]| {
        let (low, high) = range(stretch);
        stretch.len() >= 4 && high - low > 12.0 * step
    };
    let jumps = |from: usize, to: usize| {
        let into = from.checked_sub(1).map_or(0.0, |before| samples[before] - samples[from]);
        let out = samples.get(to).map_or(0.0, |after| after - samples[from]);
        into.abs().max(out.abs()) > JUMP * step
    };
    let mut longest: Option<Range<usize>> = None;
    let mut from = 0;
    for to in 1..=samples.len() {
        if to < samples.len() && samples[to] == samples[from] {
            continue;
        }
        let is_longer = to - from > longest.as_ref().map_or(MIN_SAMPLES - 1, Range::len);
        if is_longer
            && samples[from] != low
            && samples[from] != high
            && jumps(from, to)
            && moves(&samples[from.saturating_sub(AROUND)..from])
            && moves(&samples[to..(to + AROUND).min(samples.len())])
        {
            longest = Some(from..to);
        }
        from = to;
    }
    longest
}

/// The sample at `k` by the cubic through the two on either side.
fn from_neighbours(samples: &[f64], k: usize) -> f64 {
    (4.0 * (samples[k - 1] + samples[k + 1]) - samples[k - 2] - samples[k + 2]) / 6.0
}

/// Samples that are off the line of their neighbours by far more than all others around, which look
/// alike before and after: those around an impact do not. Two that lie close together hide each
/// other.
fn spikes(samples: &[f64]) -> Vec<usize> {
    /// Samples on either side that are looked at.
    const AROUND: usize = 48;
    /// How far off the largest of those a spike is.
    const FAR_OFF: f64 = 8.0;
    /// An impact raises what follows by more than this.
    const ALIKE: f64 = 3.0;
    /// The cubic through a spike's neighbours is off, too.
    const TOUCHED: usize = 3;
    let n = samples.len();
    if n < 2 * AROUND {
        return Vec::new();
    }
    // A bit that flickers in a quiet stretch is no spike.
    let (low, high) = range(samples);
    let step = (high - low) / steps(samples, high - low);
    let off = |k: usize| (samples[k] - from_neighbours(samples, k)).abs();
    let off: Vec<f64> = (0..n).map(|k| if k < 2 || k + 2 >= n { 0.0 } else { off(k) }).collect();
    let largest = |range: Range<usize>| off[range].iter().copied().fold(0.0, f64::max);
    let moves = |stretch: Range<usize>| {
        let (low, high) = range(&samples[stretch]);
        high - low
    };
    // In line with its neighbours it leaves them in line: an edge does not.
    let fits_in = |k: usize, far: f64| {
        let (from, to) = (k.saturating_sub(2 * TOUCHED), (k + 2 * TOUCHED).min(n));
        let mut around = samples[from..to].to_vec();
        around[k - from] = from_neighbours(samples, k);
        let off = |i: usize| (around[i] - from_neighbours(&around, i)).abs();
        (2..around.len() - 2).all(|i| off(i) <= far)
    };
    (2..n - 2)
        .filter(|&k| off[k] >= off[k - 1] && off[k] >= off[k + 1])
        .filter(|&k| {
            let before = k.saturating_sub(AROUND)..k.saturating_sub(TOUCHED - 1);
            let after = (k + TOUCHED).min(n)..(k + AROUND).min(n);
            let others = largest(before.clone()).max(largest(after.clone()));
            let far = FAR_OFF * others.max(step);
            off[k] > far && moves(after) <= ALIKE * moves(before).max(step) && fits_in(k, far)
        })
        .collect()
}

/// Lowest and highest value; 0 of none.
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

/// The step that all values are multiples of, as a converter with few bits makes them; `None` where
/// there is none.
pub(super) fn rounding_step(samples: &[f64]) -> Option<f64> {
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
    // In steps; gaps without a grid are off by a quarter.
    (mean < 0.1).then_some(step)
}

/// Lengths of the runs of samples at one value, to a share of it, of which a neighbour is farther
/// than `corner` from it.
fn runs_at(samples: &[f64], value: f64, share: f64, corner: f64) -> Vec<usize> {
    let is_there = |sample: &f64| (sample - value).abs() <= share * value.abs();
    let mut runs = Vec::new();
    let mut from = 0;
    while from < samples.len() {
        let run = samples[from..].iter().take_while(|sample| is_there(sample)).count();
        let before = from.checked_sub(1).and_then(|before| samples.get(before));
        let mut around = [before, samples.get(from + run)].into_iter().flatten();
        if run > 0 && around.any(|sample| (sample - value).abs() > corner) {
            runs.push(run);
        }
        from += run + 1;
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::record::Quantity;

    fn codes(samples: Vec<f64>, is_force: bool) -> Vec<Code> {
        let channel = Channel { name: "a".into(), quantity: Quantity::Unknown, samples };
        let mut notes = Notes::default();
        check_channel(&channel, is_force, &mut notes);
        notes.list().iter().map(|note| note.code).collect()
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

    /// A lone sample in noise and in a decay is a spike; an impact, a step and the noise itself are
    /// not.
    #[test]
    fn samples_that_stand_alone_are_distinguished_from_impacts() {
        let noise = |k: usize| 0.1 * ((k * k) as f64 * 0.7).sin();
        let decay = |k: usize| {
            let t = k as f64 - 300.0;
            if t < 0.0 { 0.0 } else { 5.0 * (-0.01 * t).exp() * (0.9 * t).sin() }
        };
        let sound: Vec<f64> = (0..1000).map(|k| noise(k) + decay(k)).collect();
        assert!(spikes(&sound).is_empty());
        let mut spiked = sound.clone();
        spiked[150] += 9.0;
        spiked[500] -= 40.0;
        spiked[501] += 0.1;
        assert_eq!(spikes(&spiked), [150, 500]);
        // The impact itself: one sample, and all after it is loud.
        let mut impact = sound.clone();
        impact[300] += 60.0;
        assert!(spikes(&impact).is_empty());
        let step: Vec<f64> =
            (0..1000).map(|k| noise(k) + if k < 400 { 0.0 } else { 50.0 }).collect();
        assert!(spikes(&step).is_empty());
        let channel = Channel { name: "a".into(), quantity: Quantity::Unknown, samples: spiked };
        let mut notes = Notes::default();
        let repaired =
            without_spikes(&channel, 100.0, std::slice::from_ref(&(140..160)), &mut notes);
        assert_eq!(repaired.samples[150], channel.samples[150]);
        assert!((repaired.samples[500] - sound[500]).abs() < 1.5, "{}", repaired.samples[500]);
        assert_eq!(notes.list().len(), 1);
        assert!(notes.list()[0].what.contains("5.0000 s"), "{}", notes.list()[0].what);
    }

    /// A run of one value in the middle of motion is a gap; quiet before a hit, the end of a decay
    /// in coarse steps and clipped peaks are none.
    #[test]
    fn samples_that_were_lost_are_distinguished_from_rest() {
        let decay = |k: usize| {
            let t = k as f64 - 100.0;
            if t < 0.0 { 0.0 } else { 5.0 * (-0.01 * t).exp() * (0.9 * t).sin() }
        };
        let sound: Vec<f64> = (0..1000).map(decay).collect();
        let rounded: Vec<f64> = sound.iter().map(|x| (x / 0.02).round() * 0.02).collect();
        let clipped: Vec<f64> = sound.iter().map(|x| x.clamp(-1.0, 1.0)).collect();
        // Two impacts, and rest in coarse steps between them.
        let twice: Vec<f64> = (0..2000)
            .map(|k| decay(k) + if k < 1000 { 0.0 } else { decay(k - 1000) })
            .map(|x| (x / 0.02).round() * 0.02)
            .collect();
        for channel in [&sound, &rounded, &clipped, &twice] {
            assert_eq!(gap(channel), None);
        }
        for (channel, value) in [(&sound, 0.0), (&rounded, 0.0), (&sound, sound[149])] {
            let mut lost = channel.clone();
            lost[150..170].fill(value);
            let found = gap(&lost).unwrap();
            assert!(found.end == 170 && (149..=150).contains(&found.start), "{found:?}");
        }
    }

    #[test]
    fn a_bit_that_flickers_is_no_spike() {
        let mut quiet = vec![0.0; 400];
        quiet[100] = 0.01;
        quiet[250] = -0.01;
        assert!(spikes(&quiet).is_empty());
        quiet[300] = 5.0;
        assert_eq!(spikes(&quiet), [300]);
    }

    #[test]
    fn channels_that_cannot_be_trusted_are_codes() {
        let decay = |k: i32| 10.0 * (-0.01 * f64::from(k)).exp() * (0.3 * f64::from(k)).cos();
        let sound: Vec<f64> = (0..500).map(decay).collect();
        assert_eq!(codes(sound.clone(), false), []);
        let clipped: Vec<f64> = sound.iter().map(|v| v.clamp(-6.0, 6.0)).collect();
        assert_eq!(codes(clipped, false), [Code::Clipping; 2]);
        let coarse: Vec<f64> = sound.iter().map(|v| v.round()).collect();
        assert_eq!(codes(coarse, false), [Code::CoarseSteps]);
        assert_eq!(codes(vec![3.0; 9], false), [Code::DeadChannel]);
        let mut force = vec![0.0; 500];
        for (k, f) in [1.0, 2.2, 3.1, 2.9, 1.4].into_iter().enumerate() {
            force[100 + k] = f + 1e-3;
        }
        force[300] = 0.01;
        assert_eq!(codes(force.clone(), true), []);
        force[101..104].fill(2.0);
        assert_eq!(codes(force, true), [Code::Clipping]);
    }
}
