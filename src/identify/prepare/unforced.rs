//! Responses whose force nobody measured: free decays, or responses to a force that goes on.

use std::borrow::Cow;
use std::ops::Range;

use super::lines::{
    MIN_DECAY_SAMPLES, band, lines, most_samples, omega, on_lines, rounding_noise, warn_of_break,
    warn_of_edge, warn_of_part,
};
use super::{NO_LINES, Prepared, RecordKind, Sampling, responses_of, without_offset};
use crate::identify::estimate::subspace::Stationary;
use crate::identify::estimate::{Block, C64, Origin};
use crate::identify::impacts::{Decay, decays, guard};
use crate::identify::innovations::Departures;
use crate::identify::quality::{rounding_step, without_spikes};
use crate::identify::record::Channel;
use crate::identify::spectra::{resampled, transform};
use crate::notes::{Code, Notes};
use crate::statistics::{median, rank_with_order, rms, upper_median};

pub(super) fn free(
    sampling: Sampling,
    channels: &[&Channel],
    notes: &mut Notes,
) -> Option<Prepared> {
    let rate_hz = sampling.rate_hz;
    let responses = responses_of(channels);
    let steps: Vec<Option<f64>> =
        channels.iter().map(|channel| rounding_step(&channel.samples)).collect();
    let channels: Vec<Cow<'_, Channel>> =
        channels.iter().map(|channel| without_spikes(channel, rate_hz, &[], notes)).collect();
    let moving = moving(&channels);
    let lively: Vec<&[f64]> = channels.iter().map(|c| &c.samples[moving.clone()]).collect();
    if goes_on(&lively, rate_hz) {
        warn_of_padding(&moving, channels.first().map_or(0, |c| c.samples.len()), rate_hz, notes);
        let whole: Vec<Vec<f64>> = lively.iter().map(|own| without_offset(own)).collect();
        let samples = whole.first().map_or(0, Vec::len);
        let cut = [(samples, whole.iter().map(|samples| transform(samples)).collect())];
        let band_hz = band(sampling, &cut, notes);
        warn_of_edge(&cut, rate_hz, band_hz[1], notes);
        let prepared = Prepared::of(RecordKind::RandomResponse, responses, Vec::new());
        return Some(Prepared {
            nyquist_hz: Some(0.5 * rate_hz),
            stationary: Some(stationary(rate_hz, band_hz, whole)),
            ..prepared
        });
    }
    let mut decays = long_decays(&channels, rate_hz, notes)?;
    let spectra_of = |decay: &Decay| -> (usize, Vec<Vec<C64>>) {
        let of = |channel: &Cow<'_, Channel>| {
            transform(&without_offset(&channel.samples[decay.from..decay.to]))
        };
        (decay.to - decay.from, channels.iter().map(of).collect())
    };
    let mut cut: Vec<(usize, Vec<Vec<C64>>)> = decays.iter().map(spectra_of).collect();
    let band = band(sampling, &cut, notes);
    let most = most_samples(rate_hz, band);
    if decays.iter().any(|decay| decay.to - decay.from > most) {
        warn_of_part(most, rate_hz, "of each decay are fitted", notes);
        decays.iter_mut().for_each(|decay| decay.to = decay.to.min(decay.from + most));
        cut = decays.iter().map(spectra_of).collect();
    }
    warn_of_edge(&cut, rate_hz, band[1], notes);
    let mut blocks = Vec::new();
    for (samples, spectra) in cut {
        let lines = lines(samples, rate_hz, band, notes);
        let origin = Origin::Sampled { step_s: rate_hz.recip(), samples, force: None };
        blocks.push(Block {
            is_cut_out: sampling.band_hz.is_some(),
            min_noise: steps.iter().map(|step| rounding_noise(*step, samples)).collect(),
            ..Block::new(origin, omega(&lines, samples, rate_hz), on_lines(&spectra, &lines))
        });
    }
    blocks.retain(|block| !block.omega.is_empty());
    if blocks.is_empty() {
        notes.warning(Code::NoModes, None, NO_LINES);
        return None;
    }
    let prepared = Prepared::of(RecordKind::FreeDecay, responses, blocks);
    Some(Prepared { nyquist_hz: Some(0.5 * rate_hz), ..prepared })
}

/// Responses at the rate that the band needs, and at lower ones that its slow modes need.
fn stationary(rate_hz: f64, band_hz: [f64; 2], responses: Vec<Vec<f64>>) -> Stationary {
    /// Samples per period of the highest frequency.
    const PER_PERIOD: f64 = 2.5;
    /// A band reaches so far beyond the modes that count in it.
    const BEYOND: f64 = 1.6;
    /// A band as slow as that holds no more modes, relative to its highest frequency.
    const NARROW: f64 = 4.0;
    let samples = responses.first().map_or(0, Vec::len);
    let spectra = responses.iter().map(|own| transform(&under_hann(own))).collect();
    let share = PER_PERIOD * band_hz[1] / rate_hz;
    let mut own = if share > 0.8 {
        Stationary { rate_hz, band_hz, responses, spectra, below: None }
    } else {
        let count = (share * samples as f64).ceil() as usize;
        let responses = responses.iter().map(|own| resampled(own, count)).collect();
        let rate_hz = rate_hz * count as f64 / samples as f64;
        Stationary { rate_hz, band_hz, responses, spectra, below: None }
    };
    let high_hz = BEYOND * own.slowest_hz();
    let is_lower = high_hz < 0.5 * band_hz[1] && high_hz > NARROW * band_hz[0];
    if is_lower && own.is_enough(PER_PERIOD * high_hz * own.duration_s()) {
        let below = stationary(own.rate_hz, [band_hz[0], high_hz], own.responses.clone());
        own.below = Some(Box::new(below));
    }
    own
}

fn under_hann(samples: &[f64]) -> Vec<f64> {
    let turn = std::f64::consts::TAU / samples.len().max(1) as f64;
    samples.iter().enumerate().map(|(k, y)| y * (1.0 - (turn * k as f64).cos())).collect()
}

/// The samples between stretches at the ends in which no channel moves, as recorders fill them.
fn moving(channels: &[Cow<'_, Channel>]) -> Range<usize> {
    let all = channels.first().map_or(0, |channel| channel.samples.len());
    let still = |own: &mut dyn Iterator<Item = f64>| -> usize {
        let first = own.next();
        // One value alone is not held.
        match own.take_while(|value| Some(*value) == first).count() {
            0 => 0,
            more => 1 + more,
        }
    };
    let before = channels.iter().map(|channel| still(&mut channel.samples.iter().copied()));
    let after = channels.iter().map(|channel| still(&mut channel.samples.iter().rev().copied()));
    let (from, to) = (before.min().unwrap_or(0), all - after.min().unwrap_or(0));
    if from < to { from..to } else { 0..all }
}

/// Tells what of a record does not move.
fn warn_of_padding(moving: &Range<usize>, samples: usize, rate_hz: f64, notes: &mut Notes) {
    /// A share of the record that is worth a word.
    const MIN_SHARE: f64 = 0.001;
    let still = samples - moving.len();
    if still as f64 > MIN_SHARE * samples as f64 {
        let what = format!(
            "no channel moves in {:.1} s at the record's ends, which were left out: the recorder \
             was not running there",
            still as f64 / rate_hz
        );
        notes.warning(Code::Remark, None, what);
    }
}

/// Responses about their middle.
fn level(channels: &[&[f64]]) -> Vec<Vec<f64>> {
    let about = |samples: &&[f64]| {
        let middle = upper_median(samples).unwrap_or(0.0);
        samples.iter().map(|s| s - middle).collect()
    };
    channels.iter().map(about).collect()
}

/// Whether the responses go on all the time, as under a random force, instead of decaying: their
/// values spread like Gaussian noise, or as gusts of it that never die down, and their energy does
/// not fall from one impact to the next.
fn goes_on(channels: &[&[f64]], rate_hz: f64) -> bool {
    /// Kurtosis: 3 for Gaussian noise, 1.5 for a tone; decays have many small values.
    const KURTOSIS: [f64; 2] = [2.0, 5.0];
    /// Energy of the last third of a decay against the first.
    const MIN_REMAINING: f64 = 0.25;
    /// Rank correlation of energy with time, over parts of a decay.
    const MIN_RANK: f64 = -0.8;
    const PARTS: usize = 12;
    /// Between gusts and in them.
    const MIN_EVENNESS: f64 = 0.15;
    let level = level(channels);
    let borrowed: Vec<&[f64]> = level.iter().map(Vec::as_slice).collect();
    let kurtosis = |y: &Vec<f64>| {
        let square = rms(y.iter().copied()).powi(2);
        y.iter().map(|y| y.powi(4)).sum::<f64>() / y.len() as f64 / square.powi(2)
    };
    let spread = median(level.iter().map(kurtosis).collect()).unwrap_or(0.0);
    let is_steady = || median(level.iter().map(|y| evenness(y)).collect()) > Some(MIN_EVENNESS);
    if spread < KURTOSIS[0] || spread > KURTOSIS[1] && !is_steady() {
        return false;
    }
    let sizes: Vec<f64> = level.iter().map(|y| rms(y.iter().copied())).collect();
    let energy = |from: usize, to: usize| -> f64 {
        let own = level.iter().zip(&sizes);
        own.map(|(y, size)| y[from..to].iter().map(|y| (y / size).powi(2)).sum::<f64>()).sum()
    };
    let samples = level.first().map_or(0, Vec::len);
    let mut stretches = decays(&borrowed, rate_hz);
    stretches.retain(|decay| decay.to - decay.from >= PARTS * MIN_DECAY_SAMPLES);
    if stretches.is_empty() && samples >= PARTS * MIN_DECAY_SAMPLES {
        stretches.push(Decay { from: 0, to: samples });
    }
    let (mut first, mut last, mut rank, mut whole) = (0.0, 0.0, 0.0, 0.0);
    for Decay { from, to } in stretches {
        let part = (to - from) / PARTS;
        let parts: Vec<f64> =
            (0..PARTS).map(|i| energy(from + i * part, from + (i + 1) * part)).collect();
        first += parts[..PARTS / 3].iter().sum::<f64>();
        last += parts[PARTS - PARTS / 3..].iter().sum::<f64>();
        rank += rank_with_order(&parts) * (to - from) as f64;
        whole += (to - from) as f64;
    }
    whole > 0.0 && last > MIN_REMAINING * first && rank > MIN_RANK * whole
}

/// Size of a quiet part of a response against a loud one, where the response is long enough for
/// gusts to come and go.
fn evenness(samples: &[f64]) -> f64 {
    const PARTS: usize = 40;
    const MIN_SAMPLES: usize = 250;
    let length = samples.len().div_ceil(PARTS);
    if length < MIN_SAMPLES {
        return 0.0;
    }
    let mut sizes: Vec<f64> =
        samples.chunks(length).map(|part| rms(part.iter().copied())).collect();
    sizes.sort_by(f64::total_cmp);
    let tenth = sizes.len() / 10;
    match (sizes.get(tenth), sizes.get(sizes.len().saturating_sub(tenth + 1))) {
        (Some(quiet), Some(loud)) if *loud > 0.0 => quiet / loud,
        _ => 0.0,
    }
}

/// The decays that are long enough; `None` (with a warning) where there is none.
fn long_decays(
    channels: &[Cow<'_, Channel>],
    rate_hz: f64,
    notes: &mut Notes,
) -> Option<Vec<Decay>> {
    let whole: Vec<&[f64]> = channels.iter().map(|channel| &channel.samples[..]).collect();
    let level = level(&whole);
    let level: Vec<&[f64]> = level.iter().map(Vec::as_slice).collect();
    let found = decays(&level, rate_hz);
    let departures: Vec<Departures> =
        found.iter().map(|decay| Departures::of(&level, *decay, rate_hz)).collect();
    // What departs right behind the beginning is the end of its impact.
    let begins =
        |at: usize| found.iter().any(|own| (own.from..own.from + guard(rate_hz)).contains(&at));
    let breaks = departures.iter().flat_map(|own| &own.breaks).filter(|at| !begins(**at));
    breaks.for_each(|at| warn_of_break(*at, rate_hz, "the decay is divided there", notes));
    let both = found.iter().zip(&departures);
    let found: Vec<Decay> = both.flat_map(|(own, at)| at.decays(*own, rate_hz)).collect();
    /// A decay counts beside one that is up to so many times as long.
    const MAX_SHORTER: usize = 15;
    // Beside a long decay the lines of a short one are too wide to tell its modes apart.
    let longest = found.iter().map(|decay| decay.to - decay.from).max().unwrap_or(0);
    let least = MIN_DECAY_SAMPLES.max(longest / MAX_SHORTER);
    let is_long = |decay: &Decay| decay.to - decay.from >= least;
    let long: Vec<Decay> = found.iter().copied().filter(is_long).collect();
    warn_of_cut_decays(&found, &long, rate_hz, notes);
    if long.is_empty() {
        let what = format!(
            "has no free decay of {MIN_DECAY_SAMPLES} samples or more; was the record cut before \
             the impact?"
        );
        notes.warning(Code::NoModes, None, what);
        return None;
    }
    Some(long)
}

/// A decay that another impact cuts short is a double hit.
fn warn_of_cut_decays(found: &[Decay], long: &[Decay], rate_hz: f64, notes: &mut Notes) {
    let longest = long.iter().map(|decay| decay.to - decay.from).max().unwrap_or(0);
    for decay in &found[..found.len().saturating_sub(1)] {
        if decay.to - decay.from > guard(rate_hz) && 4 * (decay.to - decay.from) < longest {
            let what = format!(
                "the decay that begins at {:.3} s is cut short by a second impact at {:.3} s; hit \
                 once and wait",
                decay.from as f64 / rate_hz,
                decay.to as f64 / rate_hz
            );
            notes.warning(Code::DoubleHit, None, what);
        }
    }
}
