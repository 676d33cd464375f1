//! Responses to a measured force: impacts of a hammer, or a force that goes on.

use std::borrow::Cow;
use std::ops::Range;

use super::coupling::without_high_pass;
use super::lines::{
    MAX_LINES, band, lines, most_samples, omega, on_lines, rounding_noise, warn_of_break,
    warn_of_edge, warn_of_part,
};
use super::{
    NO_LINES, Prepared, RecordKind, Sampling, SpectraOnLines, responses_of, without_offset,
};
use crate::identify::estimate::{Block, C64, ForceSample, Origin};
use crate::identify::impacts::{Decay, Impact, compared, guard, impacts_in_force};
use crate::identify::innovations::Departures;
use crate::identify::quality::{rounding_step, without_spikes};
use crate::identify::record::Channel;
use crate::identify::spectra::{Averaged, Window, over_impacts, over_stretches, transform};
use crate::notes::{Code, Notes};
use crate::statistics::{deviation_about_zero, upper_median};
use crate::units::rad_per_s_from_hz;

pub(super) fn forced(
    sampling: Sampling,
    excitation: &Channel,
    channels: &[&Channel],
    notes: &mut Notes,
) -> Option<Prepared> {
    let excitation = &*without_high_pass(excitation, sampling.rate_hz, notes);
    let steps = (sampling.delay_s * sampling.rate_hz).round();
    if steps == 0.0 {
        return in_step(sampling, excitation, channels, notes);
    }
    // By whole samples the record is put in step; the fit takes what is left of the delay.
    let left_s = sampling.delay_s - steps / sampling.rate_hz;
    let (late, samples) = (steps.abs() as usize, excitation.samples.len());
    if late >= samples {
        let what = "is shorter than response_delay_s";
        notes.warning(Code::NoModes, None, what);
        return None;
    }
    let (first, last) = (late..samples, 0..samples - late);
    let (of_force, of_responses) = if steps > 0.0 { (last, first) } else { (first, last) };
    let excitation = part_of(excitation, of_force);
    let channels: Vec<Channel> =
        channels.iter().map(|channel| part_of(channel, of_responses.clone())).collect();
    let sampling = Sampling { delay_s: left_s, ..sampling };
    in_step(sampling, &excitation, &channels.iter().collect::<Vec<_>>(), notes)
}

/// A record whose responses are late by half a step at most.
fn in_step(
    sampling: Sampling,
    excitation: &Channel,
    channels: &[&Channel],
    notes: &mut Notes,
) -> Option<Prepared> {
    let Some(part) = part(sampling, excitation, channels) else {
        return unbroken(sampling, excitation, channels, 0, notes);
    };
    warn_of_part(part.len(), sampling.rate_hz, "are fitted", notes);
    let from = part.start;
    let (excitation, channels) = cut(excitation, channels, part);
    unbroken(sampling, &excitation, &channels.iter().collect::<Vec<_>>(), from, notes)
}

fn cut(excitation: &Channel, channels: &[&Channel], part: Range<usize>) -> (Channel, Vec<Channel>) {
    let own = |channel: &&Channel| part_of(channel, part.clone());
    (part_of(excitation, part.clone()), channels.iter().map(own).collect())
}

fn part_of(channel: &Channel, part: Range<usize>) -> Channel {
    Channel {
        samples: channel.samples[part].to_vec(),
        name: channel.name.clone(),
        quantity: channel.quantity,
    }
}

/// Of a hammer record, what comes before a moment at which the free vibration does not go on; the
/// first sample is the record's own `from`.
fn unbroken(
    sampling: Sampling,
    excitation: &Channel,
    channels: &[&Channel],
    from: usize,
    notes: &mut Notes,
) -> Option<Prepared> {
    let rate_hz = sampling.rate_hz;
    let force = about_middle(excitation);
    let impacts = impacts_in_force(&force, rate_hz);
    let Some(at) = first_break(&impacts, channels, rate_hz) else {
        return whole(sampling, excitation, channels, notes);
    };
    let first = impacts.first().map_or(0, |impact| reach(impact)[1]);
    // Of a short stretch the blow takes so much that it is no hammer's.
    if at < first + compared(rate_hz) || impacts_in_force(&force[..at], rate_hz).is_empty() {
        let done = "what comes before it is too short to be used alone: do not trust the modes";
        warn_of_break(from + at, rate_hz, done, notes);
        return whole(sampling, excitation, channels, notes);
    }
    warn_of_break(from + at, rate_hz, "what comes before it is used", notes);
    let (excitation, channels) = cut(excitation, channels, 0..at);
    whole(sampling, &excitation, &channels.iter().collect::<Vec<_>>(), notes)
}

fn about_middle(excitation: &Channel) -> Vec<f64> {
    let middle = upper_median(&excitation.samples).unwrap_or(0.0);
    excitation.samples.iter().map(|f| f - middle).collect()
}

/// The first moment between or after impacts at which the responses depart from free vibration.
fn first_break(impacts: &[Impact], channels: &[&Channel], rate_hz: f64) -> Option<usize> {
    let protected = protected(impacts);
    let blank = |channel: &&Channel| {
        let channel = without_spikes(channel, rate_hz, &protected, &mut Notes::default());
        without_offset(&channel.samples)
    };
    let moves: Vec<Vec<f64>> = channels.iter().map(blank).collect();
    let moves: Vec<&[f64]> = moves.iter().map(Vec::as_slice).collect();
    let samples = moves.first()?.len();
    let ends = impacts.iter().skip(1).map(|next| reach(next)[0]).chain([samples]);
    let between = impacts.iter().zip(ends).map(|(impact, to)| {
        let from = (reach(impact)[1] + guard(rate_hz)).min(to);
        Decay { from, to: to.saturating_sub(guard(rate_hz)).max(from) }
    });
    let moments = between.flat_map(|stretch| {
        let Departures { hits, breaks } = Departures::of(&moves, stretch, rate_hz);
        hits.into_iter().chain(breaks)
    });
    moments.min()
}

/// The part of a long record that has as many lines as are fitted, from just before the first
/// impact on; `None` of others.
fn part(sampling: Sampling, excitation: &Channel, channels: &[&Channel]) -> Option<Range<usize>> {
    let samples = excitation.samples.len();
    if samples <= 2 * MAX_LINES {
        return None;
    }
    let spectra = channels.iter().map(|c| transform(&without_offset(&c.samples))).collect();
    let band = band(sampling, &[(samples, spectra)], &mut Notes::default());
    let most = most_samples(sampling.rate_hz, band);
    if samples <= most {
        return None;
    }
    let force = about_middle(excitation);
    let first = impacts_in_force(&force, sampling.rate_hz).first().map_or(0, |i| reach(i)[0]);
    let from = first.saturating_sub(most / 50).min(samples - most);
    Some(from..from + most)
}

fn whole(
    sampling: Sampling,
    excitation: &Channel,
    channels: &[&Channel],
    notes: &mut Notes,
) -> Option<Prepared> {
    let rate_hz = sampling.rate_hz;
    let responses = responses_of(channels);
    let mut force = about_middle(excitation);
    let samples = force.len();
    let impacts = impacts_in_force(&force, rate_hz);
    warn_of_bounces(&impacts, excitation, rate_hz, notes);
    let protected = protected(&impacts);
    let min_noise: Vec<f64> = channels
        .iter()
        .map(|channel| rounding_noise(rounding_step(&channel.samples), samples))
        .collect();
    // A force that goes on may be made of short pulses that look like spikes.
    let channels: Vec<Cow<'_, Channel>> = channels
        .iter()
        .map(|channel| match impacts.is_empty() {
            true => Cow::Borrowed(*channel),
            false => without_spikes(channel, rate_hz, &protected, notes),
        })
        .collect();
    let moves: Vec<Vec<f64>> = channels.iter().map(|c| without_offset(&c.samples)).collect();
    let moves: Vec<&[f64]> = moves.iter().map(Vec::as_slice).collect();
    let (force_noise, averaged) = if impacts.is_empty() {
        (None, over_stretches(&force, &moves, rate_hz))
    } else {
        let noise = silence_outside(&mut force, &impacts);
        (Some(noise), over_impacts(&force, &moves, &impacts, rate_hz))
    };
    let spectra: Vec<Vec<C64>> = moves.iter().map(|m| transform(m)).collect();
    let cut = [(samples, spectra)];
    let band = band(sampling, &cut, notes);
    warn_of_edge(&cut, rate_hz, band[1], notes);
    let lines = lines(samples, rate_hz, band, notes);
    if lines.is_empty() {
        notes.warning(Code::NoModes, None, NO_LINES);
        return None;
    }
    let [(_, spectra)] = cut;
    // As late as the responses are.
    let late = sampling.delay_s * rate_hz;
    let pulses = force_samples(&force, &impacts, late);
    let omega = omega(&lines, samples, rate_hz);
    let in_time = |(f, omega): (&C64, &f64)| f * C64::from_polar(1.0, -omega * sampling.delay_s);
    let drive: Vec<C64> =
        transform(&force)[lines.clone()].iter().zip(&omega).map(in_time).collect();
    let drive_error = force_noise.map_or_else(Vec::new, |noise| {
        let variance = noise.powi(2) * pulses.len() as f64;
        drive.iter().map(|f| drive_error(variance, f.norm_sqr())).collect()
    });
    let origin = Origin::Sampled { step_s: rate_hz.recip(), samples, force: Some(pulses) };
    let block = Block {
        is_cut_out: sampling.band_hz.is_some(),
        drive,
        drive_error,
        min_noise,
        begins_moving: impacts.is_empty(),
        ..Block::new(origin, omega, on_lines(&spectra, &lines))
    };
    let averaged = averaged.map(|averaged| averaged.in_time(sampling.delay_s));
    let window_decay = match averaged.as_ref().map(|averaged| averaged.window) {
        Some(Window::ForceExponential { decay_per_s }) => decay_per_s,
        _ => 0.0,
    };
    Some(Prepared {
        responses,
        blocks: vec![block],
        starts_from: averaged.iter().map(|averaged| within_band(averaged, band)).collect(),
        window_decay,
        nyquist_hz: Some(0.5 * rate_hz),
        averaged,
        stationary: None,
        pairs: None,
        kind: if impacts.is_empty() { RecordKind::Steady } else { RecordKind::Hammer },
    })
}

fn warn_of_bounces(impacts: &[Impact], excitation: &Channel, rate_hz: f64, notes: &mut Notes) {
    for impact in impacts.iter().filter(|impact| impact.pulses.len() > 1) {
        let what = format!(
            "{} pulses within one impact at {:.3} s: the hammer bounced; all of them are taken \
             into account, but a clean impact is better",
            impact.pulses.len(),
            impact.first as f64 / rate_hz
        );
        notes.channel_warning(Code::DoubleHit, &excitation.name, what);
    }
}

/// Sets the force outside of the pulses to zero, between those of one impact, too: noise there
/// would count as force. The standard deviation of its noise.
fn silence_outside(force: &mut [f64], impacts: &[Impact]) -> f64 {
    let mut inside = vec![false; force.len()];
    for &(from, to) in impacts.iter().flat_map(|impact| &impact.pulses) {
        inside[from..to].fill(true);
    }
    let mut outside = Vec::new();
    for (f, _) in force.iter_mut().zip(&inside).filter(|(_, inside)| !**inside) {
        outside.push(*f);
        *f = 0.0;
    }
    deviation_about_zero(&outside)
}

/// The samples of the force that are not zero, `late` by so many, each with its pulse: noise and
/// what the samples miss make each pulse a little stronger or weaker, also where the hammer
/// bounced.
fn force_samples(force: &[f64], impacts: &[Impact], late: f64) -> Vec<ForceSample> {
    let ends: Vec<usize> = impacts.iter().flat_map(|i| &i.pulses).map(|pulse| pulse.1).collect();
    let sample = |(at, &value): (usize, &f64)| {
        let impact = ends.iter().position(|end| at < *end).unwrap_or(0);
        ForceSample { at: at as f64 + late, value, impact }
    };
    force.iter().enumerate().filter(|(_, f)| **f != 0.0).map(sample).collect()
}

/// Averaged frequency responses within a band, without the offset.
fn within_band(averaged: &Averaged, [low, high]: [f64; 2]) -> SpectraOnLines {
    let is_within = |hz: f64| hz >= low && hz <= high;
    let within: Vec<usize> = (1..averaged.frequencies_hz.len())
        .filter(|&k| is_within(averaged.frequencies_hz[k]))
        .collect();
    let omega = within.iter().map(|&k| rad_per_s_from_hz(averaged.frequencies_hz[k])).collect();
    let pick = |h: &Vec<C64>| within.iter().map(|&k| h[k]).collect();
    (omega, averaged.h1.iter().map(pick).collect())
}

/// Variance of a line of the force relative to its power: noise in the samples of the pulses, and
/// what the samples miss of a short pulse.
fn drive_error(variance: f64, power: f64) -> f64 {
    // At most 1, where the force is lost in noise; sampling misses 0.2 % of a short pulse.
    (variance / power.max(f64::MIN_POSITIVE)).min(1.0) + 2e-3_f64.powi(2)
}

/// Where a response may look like a glitch.
fn protected(impacts: &[Impact]) -> Vec<Range<usize>> {
    impacts.iter().map(reach).map(|[from, to]| from..to + 2).collect()
}

/// First sample of an impact and one past its last, with what it rings.
fn reach(impact: &Impact) -> [usize; 2] {
    let first = impact.pulses.first().map_or(impact.first, |pulse| pulse.0);
    [first, impact.pulses.last().map_or(impact.end, |pulse| pulse.1)]
}
