//! The force as it was before an amplifier without direct current. Such a high-pass makes x of f so
//! that f = x + a ∫x + b ∬x: of first order with the corner a and b = 0, of second order with the
//! corner √b. After each pulse x lies on the other side of zero, which would count as force, or be
//! cut off; f is zero there, and a and b follow from that by least squares.

use std::borrow::Cow;

use super::without_offset;
use crate::identify::impacts::impacts_in_force;
use crate::identify::record::Channel;
use crate::notes::{Code, Notes};
use crate::statistics::{mean, upper_median};
use crate::units::hz_from_rad_per_s;

/// A pulse is looked at for so long, in parts of that length, s: a filter against aliasing rings
/// within a part.
const REACH_S: f64 = 1.0;
const PART_S: f64 = 0.02;

/// The corner is one of these, Hz.
const CORNERS_HZ: [f64; 2] = [0.05, 10.0];

/// Of the power after pulses, what a high-pass leaves unexplained; and of what one of first order
/// leaves, what one of second order does.
const LEFT: f64 = 0.25;

/// The force without what such an amplifier did, with a warning.
pub(super) fn without_high_pass<'c>(
    force: &'c Channel,
    rate_hz: f64,
    notes: &mut Notes,
) -> Cow<'c, Channel> {
    let middle = upper_median(&force.samples).unwrap_or(0.0);
    let about: Vec<f64> = force.samples.iter().map(|f| f - middle).collect();
    let stretches = stretches(&about, rate_hz);
    let integrals: Vec<[Vec<f64>; 2]> = stretches
        .iter()
        .map(|own| {
            let once = integral(&about[own.from..own.to], rate_hz);
            let twice = integral(&once, rate_hz);
            [once, twice]
        })
        .collect();
    let part = ((PART_S * rate_hz) as usize).max(1);
    // By part: the means of x, ∫x and ∬x.
    let mut means: Vec<[f64; 3]> = Vec::new();
    for (own, [once, twice]) in stretches.iter().zip(&integrals) {
        for from in (own.from..own.to.saturating_sub(part)).step_by(part) {
            if !(from..from + part).any(|k| own.is_in_pulse(k)) {
                let within = from - own.from..from - own.from + part;
                let own = &about[from..from + part];
                means.push([mean(own), mean(&once[within.clone()]), mean(&twice[within])]);
            }
        }
    }
    let Some((factors, corner_hz)) = high_pass(&means) else { return Cow::Borrowed(force) };
    let mut restored = force.clone();
    for (own, [once, twice]) in stretches.iter().zip(&integrals) {
        let integrals = once.iter().zip(twice);
        for (sample, (once, twice)) in restored.samples[own.from..own.to].iter_mut().zip(integrals)
        {
            *sample += factors[0] * once + factors[1] * twice;
        }
    }
    let what = format!(
        "swings to the other side after each pulse, as an amplifier without direct current (AC \
         coupling) makes it; a high-pass of {corner_hz:.2} Hz was taken off; couple it DC"
    );
    notes.channel_warning(Code::Remark, &force.name, what);
    Cow::Owned(restored)
}

/// The factors a and b of f = x + a ∫x + b ∬x that leave nothing after pulses, and the corner, Hz;
/// `None` where neither a first nor a second order does.
fn high_pass(means: &[[f64; 3]]) -> Option<([f64; 2], f64)> {
    let sum = |i: usize, j: usize| means.iter().map(|own| own[i] * own[j]).sum::<f64>();
    let is_corner = |corner: f64| (CORNERS_HZ[0]..CORNERS_HZ[1]).contains(&corner);
    let power = sum(0, 0);
    let first = -sum(0, 1) / sum(1, 1);
    let left_by_first = power + first * sum(0, 1);
    let determinant = sum(1, 1) * sum(2, 2) - sum(1, 2).powi(2);
    let a = (sum(1, 2) * sum(0, 2) - sum(2, 2) * sum(0, 1)) / determinant;
    let b = (sum(1, 2) * sum(0, 1) - sum(1, 1) * sum(0, 2)) / determinant;
    let left = power + a * sum(0, 1) + b * sum(0, 2);
    let corners_hz = [first, b.max(0.0).sqrt()].map(hz_from_rad_per_s);
    let is_second = a > 0.0 && is_corner(corners_hz[1]) && left < LEFT * power;
    if is_second && left < LEFT * left_by_first {
        return Some(([a, b], corners_hz[1]));
    }
    let is_first = is_corner(corners_hz[0]) && left_by_first < LEFT * power;
    is_first.then_some(([first, 0.0], corners_hz[0]))
}

/// Pulses and what follows them.
struct Stretch {
    from: usize,
    to: usize,
    pulses: Vec<(usize, usize)>,
}

impl Stretch {
    fn is_in_pulse(&self, at: usize) -> bool {
        self.pulses.iter().any(|(from, to)| (*from..*to).contains(&at))
    }
}

fn stretches(force: &[f64], rate_hz: f64) -> Vec<Stretch> {
    let reach = (REACH_S * rate_hz) as usize;
    let mut all: Vec<Stretch> = Vec::new();
    let impacts = impacts_in_force(&without_offset(force), rate_hz);
    for &(from, to) in impacts.iter().flat_map(|impact| &impact.pulses) {
        let peak = (from..to).max_by(|&a, &b| force[a].abs().total_cmp(&force[b].abs()));
        let Some(peak) = peak else { continue };
        let is_same = |f: &&f64| **f * force[peak] > 0.0;
        let before = force[..peak].iter().rev().take_while(is_same).count();
        // What a filter against aliasing makes of the end of a pulse is part of it.
        let after = 2 * force[peak..].iter().take_while(is_same).count();
        let pulse = (peak - before, (peak + after).min(force.len()));
        let end = (pulse.1 + reach).min(force.len());
        match all.last_mut() {
            Some(last) if last.to > pulse.0 => {
                last.to = end;
                last.pulses.push(pulse);
            }
            _ => all.push(Stretch { from: pulse.0, to: end, pulses: vec![pulse] }),
        }
    }
    all
}

/// Up to each sample, by trapezoids.
fn integral(samples: &[f64], rate_hz: f64) -> Vec<f64> {
    let mut sum = 0.0;
    let mut before = 0.0;
    let up_to = |f: &f64| {
        sum += 0.5 * (before + f) / rate_hz;
        before = *f;
        sum
    };
    samples.iter().map(up_to).collect()
}
