//! Impacts of a hammer: in the force where it was measured, in the responses where it was not.

use crate::statistics::deviation_about_zero;

/// An impact raises the responses at least by this factor. The beats of two modes raise them less:
/// they pass through zero on a straight line.
const MIN_RISE: f64 = 4.0;

/// A record whose first moments reach this fraction of its loudest begins in a decay.
const BEGINS_LOUD: f64 = 0.3;

/// An impact makes at least this fraction of the loudest response of the record.
const MIN_LOUDNESS: f64 = 0.1;

/// One impact.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Impact {
    /// First sample of its first pulse.
    pub(super) first: usize,
    /// One past the last sample of its last pulse.
    pub(super) end: usize,
    /// Where the force of each pulse stands out of its noise, with a margin, one past the end:
    /// more than one if the hammer bounced.
    pub(super) pulses: Vec<(usize, usize)>,
}

/// The impacts in a force without offset; empty for an excitation that goes on all the time.
pub(super) fn impacts_in_force(force: &[f64], sample_rate_hz: f64) -> Vec<Impact> {
    /// Parts of the force below this fraction of the highest are no impact.
    const MIN_FORCE: f64 = 0.1;
    /// A force that is this loud for more than this fraction of the time is no hammer.
    const MAX_TIME: f64 = 0.1;
    /// A signal exceeds the noise by this many of its standard deviations.
    const OUT_OF_NOISE: f64 = 6.0;
    let size: Vec<f64> = force.iter().map(|f| f.abs()).collect();
    let highest = maximum(&size);
    let noise = deviation_about_zero(force);
    let loud = size.iter().filter(|f| **f > MIN_FORCE * highest).count();
    if highest <= 0.0 || loud as f64 > MAX_TIME * force.len() as f64 {
        return Vec::new();
    }
    let threshold = (MIN_FORCE * highest).max(OUT_OF_NOISE * noise);
    // Pulses closer than this come from one impact that bounced.
    let bounce = 0.25 * sample_rate_hz;
    let mut impacts: Vec<Impact> = Vec::new();
    for (first, end) in pulses(&size, threshold, noise) {
        let felt = felt(&size, (first, end), noise);
        match impacts.last_mut() {
            Some(impact) if (first - impact.first) as f64 <= bounce => {
                impact.end = end;
                impact.pulses.push(felt);
            }
            _ => impacts.push(Impact { first, end, pulses: vec![felt] }),
        }
    }
    impacts
}

/// A pulse with half its length on either side, and as far as it rings above the noise: filters
/// against aliasing make short pulses ring.
fn felt(size: &[f64], (first, end): (usize, usize), noise: f64) -> (usize, usize) {
    const OUT_OF_NOISE: f64 = 4.0;
    /// Samples of which one must stand out: what rings passes through zero.
    const SOME: usize = 4;
    /// Lengths of the pulse.
    const FARTHEST: usize = 6;
    let length = end - first;
    let rings = |range: std::ops::Range<usize>| maximum(&size[range]) > OUT_OF_NOISE * noise;
    let mut from = first.saturating_sub((length / 2).max(1));
    let farthest = first.saturating_sub(FARTHEST * length);
    while from > farthest && rings(from.saturating_sub(SOME)..from) {
        from -= 1;
    }
    let mut to = (end + (length / 2).max(1)).min(size.len());
    let farthest = (end + FARTHEST * length).min(size.len());
    while to < farthest && rings(to..(to + SOME).min(size.len())) {
        to += 1;
    }
    (from, to)
}

/// First sample of each pulse above a threshold and one past its last, both at its foot.
fn pulses(size: &[f64], threshold: f64, noise: f64) -> Vec<(usize, usize)> {
    let mut pulses: Vec<(usize, usize)> = Vec::new();
    let mut at = 0;
    while at < size.len() {
        if size[at] <= threshold {
            at += 1;
            continue;
        }
        let above = size[at..].iter().take_while(|f| **f > threshold).count();
        let foot = (0.02 * maximum(&size[at..at + above])).max(3.0 * noise);
        let before = size[..at].iter().rev().take_while(|f| **f > foot).count();
        let after = size[at + above..].iter().take_while(|f| **f > foot).count();
        let (first, end) = (at - before, at + above + after);
        match pulses.last_mut() {
            Some(last) if first <= last.1 => last.1 = last.1.max(end),
            _ => pulses.push((first, end)),
        }
        at = end.max(at + above);
    }
    pulses
}

/// A stretch of free decay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Decay {
    /// First sample after the hammer has left.
    pub(super) from: usize,
    /// One past the last sample.
    pub(super) to: usize,
}

/// Samples before and after an impact that are compared.
pub(super) fn compared(sample_rate_hz: f64) -> usize {
    ((0.3 * sample_rate_hz).round() as usize).max(4)
}

/// Samples after the onset of an impact in which the hammer may touch: a soft tip does for no
/// longer.
pub(super) fn guard(sample_rate_hz: f64) -> usize {
    ((0.02 * sample_rate_hz).ceil() as usize).max(2)
}

/// The decays between the impacts that the responses show. Each response is scaled by its own
/// loudest sample; offsets are removed before.
pub(super) fn decays(responses: &[&[f64]], sample_rate_hz: f64) -> Vec<Decay> {
    let samples = responses.first().map_or(0, |response| response.len());
    let mut level = vec![0.0_f64; samples];
    for response in responses {
        let loudest = response.iter().fold(0.0_f64, |a, &b| a.max(b.abs()));
        if loudest > 0.0 {
            level.iter_mut().zip(*response).for_each(|(l, r)| *l = l.max(r.abs() / loudest));
        }
    }
    let (compared, guard) = (compared(sample_rate_hz), guard(sample_rate_hz));
    let ahead = sliding_maximum(&level, compared);
    // Loudest of the samples before k.
    let behind = |k: usize| if k >= compared { ahead[k - compared] } else { maximum(&level[..k]) };
    let mut starts = Vec::new();
    let mut k = 0;
    if samples > 0 && ahead[0] > BEGINS_LOUD {
        // Either the record begins in a decay or the impact comes within the first moments.
        let within = compared.min(samples);
        let loudest = level[..within].iter().scan(0.0_f64, |most, l| {
            *most = most.max(*l);
            Some(*most)
        });
        let loudest: Vec<f64> = loudest.collect();
        // At a high rate a hit takes many samples to rise: the last quarter of the quiet is for
        // that. A decay that begins at zero has no such quiet, at any rate.
        let onset = (4..within).find(|&k| {
            level[k] > BEGINS_LOUD * ahead[0] && MIN_RISE * loudest[k - 1 - k / 4] < level[k]
        });
        starts.push(onset.map_or(0, |onset| onset + guard));
        k = onset.unwrap_or(0) + compared;
    }
    while k < samples {
        if ahead[k] > MIN_LOUDNESS && ahead[k] > MIN_RISE * behind(k) {
            let rest = behind(k);
            // The window has but reached the hit: it becomes louder yet.
            let loudest = ahead[k].max(ahead[(k + compared / 2).min(samples - 1)]);
            let onset = (k..samples.min(k + compared + compared / 2))
                .find(|&i| level[i] > (2.0 * rest).max(0.25 * loudest))
                .unwrap_or(k);
            starts.push(onset + guard);
            k = onset + compared;
        } else {
            k += 1;
        }
    }
    let ends = starts.iter().skip(1).map(|next| next - guard.min(*next)).chain([samples]);
    starts
        .iter()
        .zip(ends)
        .filter(|(from, to)| **from < *to)
        .map(|(&from, to)| Decay { from, to })
        .collect()
}

fn maximum(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |a, &b| a.max(b))
}

/// Loudest of `width` samples from each on.
pub(super) fn sliding_maximum(values: &[f64], width: usize) -> Vec<f64> {
    let mut candidates = std::collections::VecDeque::new();
    let mut maxima = vec![0.0; values.len()];
    for k in (0..values.len()).rev() {
        while candidates.back().is_some_and(|&last: &usize| values[last] <= values[k]) {
            candidates.pop_back();
        }
        candidates.push_back(k);
        while candidates.front().is_some_and(|&first| first >= k + width) {
            candidates.pop_front();
        }
        maxima[k] = candidates.front().map_or(0.0, |&first| values[first]);
    }
    maxima
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pulse(force: &mut [f64], at: usize, height: f64) {
        for (offset, share) in [0.5, 1.0, 0.5].into_iter().enumerate() {
            force[at + offset] += share * height;
        }
    }

    #[test]
    fn impacts_and_bounces_are_distinguished() {
        let mut force = vec![0.0; 4000];
        for (at, height) in [(300, 10.0), (1500, 8.0), (1600, 3.0), (2800, 9.0)] {
            pulse(&mut force, at, height);
        }
        let impacts = impacts_in_force(&force, 1000.0);
        assert_eq!(
            impacts.iter().map(|i| (i.first, i.end, i.pulses.len())).collect::<Vec<_>>(),
            [(300, 303, 1), (1500, 1603, 2), (2800, 2803, 1)]
        );
        let steady: Vec<f64> = (0..4000).map(|k| (f64::from(k) * 0.37).sin()).collect();
        assert!(impacts_in_force(&steady, 1000.0).is_empty());
        assert!(
            impacts_in_force(&[], 1000.0).is_empty() && impacts_in_force(&[0.0; 9], 1.0).is_empty()
        );
    }

    #[test]
    fn decays_begin_after_each_impact_and_beats_are_no_impacts() {
        let rate = 140.0;
        let decay = |k: usize, f: f64, rate_of_decay: f64| {
            let t = k as f64 / rate;
            (-rate_of_decay * t).exp() * (std::f64::consts::TAU * f * t).sin()
        };
        let mut record = vec![0.0; 2100];
        for start in [70, 770, 1470] {
            for (k, sample) in record.iter_mut().enumerate().skip(start) {
                *sample += decay(k - start, 23.0, 2.0);
            }
        }
        let found = decays(&[&record], rate);
        assert_eq!(found.len(), 3, "{found:?}");
        for (decay, start) in found.iter().zip([70, 770, 1470]) {
            assert!((start + 2..start + 8).contains(&decay.from), "{found:?}");
        }
        // Two equal modes 3 % apart, lightly damped, from the first sample on.
        let beats: Vec<f64> =
            (0..1400).map(|k| decay(k, 25.0, 0.3) + decay(k, 25.75, 0.3)).collect();
        assert_eq!(decays(&[&beats], rate), [Decay { from: 0, to: 1400 }]);
        assert!(decays(&[&[]], rate).is_empty() && decays(&[], rate).is_empty());
    }
}
