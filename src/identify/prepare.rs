//! Records → spectra ready for the estimation, in the band that the record fills.

use std::borrow::Cow;
use std::ops::Range;

use super::estimate::hann::is_windowed;
use super::estimate::subspace::Stationary;
use super::estimate::{Block, C64, ForceSample, Origin};
use super::impacts::{Decay, Impact, decays, impacts_in_force};
use super::quality::{check_channel, rounding_step, without_gaps, without_spikes};
use super::record::{Channel, Data, Frf, Quantity, Record};
use super::spectra::{Averaged, Window, over_impacts, over_stretches, resampled, transform};
use crate::notes::{Code, Notes};
use crate::statistics::{deviation_about_zero, mean, median, rank_with_order, rms, upper_median};
use crate::units::{hz_from_rad_per_s, rad_per_s_from_hz};

/// Lines below this are offset and drift.
const FIRST_LINE: usize = 2;

/// Most lines of one spectrum that are fitted.
const MAX_LINES: usize = 12_000;

/// Shorter decays are left out.
const MIN_DECAY_SAMPLES: usize = 24;

const NO_LINES: &str = "is too short for any line in the band";

/// A response that the estimation sees.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Response {
    pub(super) name: String,
    pub(super) quantity: Quantity,
}

/// Lines, rad/s, and the spectra of all responses on them.
pub(super) type SpectraOnLines = (Vec<f64>, Vec<Vec<C64>>);

/// A record ready for the estimation.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    pub(super) responses: Vec<Response>,
    pub(super) blocks: Vec<Block>,
    /// What the linear least squares start from, and what its window adds to the decay, 1/s.
    pub(super) starts_from: Vec<SpectraOnLines>,
    pub(super) window_decay: f64,
    /// Half the sampling rate, Hz, where there is one.
    pub(super) nyquist_hz: Option<f64>,
    /// Averaged frequency responses of records with force.
    pub(super) averaged: Option<Averaged>,
    /// How the record was taken.
    pub(super) kind: RecordKind,
    /// Responses to a force that goes on and that nobody measured; there are no blocks then.
    pub(super) stationary: Option<Stationary>,
}

/// How the arm was excited, as far as the record shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordKind {
    /// Force pulses.
    Hammer,
    /// A force that goes on.
    Steady,
    /// No force channel, and the response decays.
    FreeDecay,
    /// No force channel, and the response goes on.
    RandomResponse,
    /// Frequency responses as the instrument made them.
    GivenResponses,
}

impl Prepared {
    /// Without windows or averages; the linear least squares start from the blocks themselves.
    fn of(kind: RecordKind, responses: Vec<Response>, blocks: Vec<Block>) -> Self {
        let starts_from =
            blocks.iter().map(|block| (block.omega.clone(), block.spectra.clone())).collect();
        Self {
            responses,
            blocks,
            starts_from,
            window_decay: 0.0,
            nyquist_hz: None,
            averaged: None,
            kind,
            stationary: None,
        }
    }
}

/// What is asked of a record beside its samples.
#[derive(Debug, Clone, Copy)]
struct Sampling {
    rate_hz: f64,
    band_hz: Option<[f64; 2]>,
}

/// Cuts and transforms a record; `None` (with a warning) where there is nothing to fit.
pub(super) fn prepare(
    record: &Record,
    band_hz: Option<[f64; 2]>,
    notes: &mut Notes,
) -> Option<Prepared> {
    match &record.data {
        Data::Responses(functions) => given(functions, band_hz, notes),
        Data::Time { sample_rate_hz, excitation, responses } => {
            let usable: Vec<&Channel> =
                responses.iter().filter(|channel| check_channel(channel, false, notes)).collect();
            let usable = without_gaps(usable, *sample_rate_hz, notes);
            if usable.is_empty() {
                notes.warning(Code::NoModes, None, "has no response that moves");
                return None;
            }
            let sampling = Sampling { rate_hz: *sample_rate_hz, band_hz };
            match excitation {
                Some(force) if check_channel(force, true, notes) => {
                    forced(sampling, force, &usable, notes)
                }
                Some(_) => {
                    let what = "the excitation does not move, so the force is unknown";
                    notes.warning(Code::NoModes, None, what);
                    None
                }
                None => free(sampling, &usable, notes),
            }
        }
    }
}

fn responses_of(channels: &[&Channel]) -> Vec<Response> {
    let response = |c: &&Channel| Response { name: c.name.clone(), quantity: c.quantity };
    channels.iter().map(response).collect()
}

fn without_offset(samples: &[f64]) -> Vec<f64> {
    let offset = if samples.is_empty() { 0.0 } else { mean(samples) };
    samples.iter().map(|s| s - offset).collect()
}

fn free(sampling: Sampling, channels: &[&Channel], notes: &mut Notes) -> Option<Prepared> {
    let rate_hz = sampling.rate_hz;
    let responses = responses_of(channels);
    let steps: Vec<Option<f64>> =
        channels.iter().map(|channel| rounding_step(&channel.samples)).collect();
    let channels: Vec<Cow<'_, Channel>> =
        channels.iter().map(|channel| without_spikes(channel, rate_hz, &[], notes)).collect();
    if goes_on(&channels, rate_hz) {
        let whole: Vec<Vec<f64>> = channels.iter().map(|c| without_offset(&c.samples)).collect();
        let samples = whole.first().map_or(0, Vec::len);
        let cut = [(samples, whole.iter().map(|samples| transform(samples)).collect())];
        let band_hz = band(sampling, &cut, notes);
        let prepared = Prepared::of(RecordKind::RandomResponse, responses, Vec::new());
        return Some(Prepared {
            nyquist_hz: Some(0.5 * rate_hz),
            stationary: Some(stationary(rate_hz, band_hz, whole)),
            ..prepared
        });
    }
    let decays = long_decays(&channels, rate_hz, notes)?;
    let cut: Vec<(usize, Vec<Vec<C64>>)> = decays
        .iter()
        .map(|decay| {
            let of = |channel: &Cow<'_, Channel>| {
                transform(&without_offset(&channel.samples[decay.from..decay.to]))
            };
            (decay.to - decay.from, channels.iter().map(of).collect())
        })
        .collect();
    let band = band(sampling, &cut, notes);
    let mut blocks = Vec::new();
    for (samples, spectra) in cut {
        let lines = lines(samples, rate_hz, band, notes);
        let origin = Origin::Sampled { step_s: rate_hz.recip(), samples, force: None };
        blocks.push(Block {
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

/// Responses at the rate that the band needs.
fn stationary(rate_hz: f64, band_hz: [f64; 2], responses: Vec<Vec<f64>>) -> Stationary {
    /// Samples per period of the highest frequency.
    const PER_PERIOD: f64 = 2.5;
    let samples = responses.first().map_or(0, Vec::len);
    let share = PER_PERIOD * band_hz[1] / rate_hz;
    if share > 0.8 {
        return Stationary { rate_hz, band_hz, responses };
    }
    let count = (share * samples as f64).ceil() as usize;
    let responses = responses.iter().map(|own| resampled(own, count)).collect();
    Stationary { rate_hz: rate_hz * count as f64 / samples as f64, band_hz, responses }
}

/// Responses about their middle.
fn level(channels: &[Cow<'_, Channel>]) -> Vec<Vec<f64>> {
    let about = |channel: &Cow<'_, Channel>| {
        let middle = upper_median(&channel.samples).unwrap_or(0.0);
        channel.samples.iter().map(|s| s - middle).collect()
    };
    channels.iter().map(about).collect()
}

/// Whether the responses go on all the time, as under a random force, instead of decaying: their
/// values spread like Gaussian noise, and their energy does not fall from one impact to the next.
fn goes_on(channels: &[Cow<'_, Channel>], rate_hz: f64) -> bool {
    /// Kurtosis: 3 for Gaussian noise, 1.5 for a tone; decays have many small values.
    const KURTOSIS: [f64; 2] = [2.0, 5.0];
    /// Energy of the last third of a decay against the first.
    const MIN_REMAINING: f64 = 0.25;
    /// Rank correlation of energy with time, over parts of a decay.
    const MIN_RANK: f64 = -0.8;
    const PARTS: usize = 12;
    let level = level(channels);
    let borrowed: Vec<&[f64]> = level.iter().map(Vec::as_slice).collect();
    let kurtosis = |y: &Vec<f64>| {
        let square = rms(y.iter().copied()).powi(2);
        y.iter().map(|y| y.powi(4)).sum::<f64>() / y.len() as f64 / square.powi(2)
    };
    let spread = median(level.iter().map(kurtosis).collect()).unwrap_or(0.0);
    if !(KURTOSIS[0]..=KURTOSIS[1]).contains(&spread) {
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

/// The decays that are long enough; `None` (with a warning) where there is none.
fn long_decays(
    channels: &[Cow<'_, Channel>],
    rate_hz: f64,
    notes: &mut Notes,
) -> Option<Vec<Decay>> {
    let level = level(channels);
    let level: Vec<&[f64]> = level.iter().map(Vec::as_slice).collect();
    let found = decays(&level, rate_hz);
    let is_long = |decay: &Decay| decay.to - decay.from >= MIN_DECAY_SAMPLES;
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
        if 4 * (decay.to - decay.from) < longest {
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

fn forced(
    sampling: Sampling,
    excitation: &Channel,
    channels: &[&Channel],
    notes: &mut Notes,
) -> Option<Prepared> {
    let rate_hz = sampling.rate_hz;
    let responses = responses_of(channels);
    let middle = upper_median(&excitation.samples).unwrap_or(0.0);
    let mut force: Vec<f64> = excitation.samples.iter().map(|f| f - middle).collect();
    let samples = force.len();
    let impacts = impacts_in_force(&force, rate_hz);
    warn_of_bounces(&impacts, excitation, rate_hz, notes);
    let protected: Vec<_> = impacts.iter().map(reach).map(|[from, to]| from..to + 2).collect();
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
    let lines = lines(samples, rate_hz, band, notes);
    if lines.is_empty() {
        notes.warning(Code::NoModes, None, NO_LINES);
        return None;
    }
    let [(_, spectra)] = cut;
    let pulses = force_samples(&force, &impacts);
    let drive = transform(&force)[lines.clone()].to_vec();
    let drive_error = force_noise.map_or_else(Vec::new, |noise| {
        let variance = noise.powi(2) * pulses.len() as f64;
        drive.iter().map(|f| drive_error(variance, f.norm_sqr())).collect()
    });
    let origin = Origin::Sampled { step_s: rate_hz.recip(), samples, force: Some(pulses) };
    let block = Block {
        drive,
        drive_error,
        min_noise,
        begins_moving: impacts.is_empty(),
        ..Block::new(origin, omega(&lines, samples, rate_hz), on_lines(&spectra, &lines))
    };
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
        kind: if impacts.is_empty() { RecordKind::Steady } else { RecordKind::Hammer },
    })
}

fn warn_of_bounces(impacts: &[Impact], excitation: &Channel, rate_hz: f64, notes: &mut Notes) {
    for impact in impacts.iter().filter(|impact| impact.pulses > 1) {
        let what = format!(
            "{} pulses within one impact at {:.3} s: the hammer bounced; all of them are taken \
             into account, but a clean impact is better",
            impact.pulses,
            impact.first as f64 / rate_hz
        );
        notes.channel_warning(Code::DoubleHit, &excitation.name, what);
    }
}

/// Sets the force outside of the impacts to zero; the standard deviation of its noise there.
fn silence_outside(force: &mut [f64], impacts: &[Impact]) -> f64 {
    let mut inside = vec![false; force.len()];
    for impact in impacts {
        let [from, to] = reach(impact);
        inside[from..to.min(force.len())].fill(true);
    }
    let mut outside = Vec::new();
    for (f, _) in force.iter_mut().zip(&inside).filter(|(_, inside)| !**inside) {
        outside.push(*f);
        *f = 0.0;
    }
    deviation_about_zero(&outside)
}

/// The samples of the force that are not zero, each with its impact.
fn force_samples(force: &[f64], impacts: &[Impact]) -> Vec<ForceSample> {
    let sample = |(at, &value): (usize, &f64)| {
        let impact = impacts.iter().position(|impact| at < reach(impact)[1]).unwrap_or(0);
        ForceSample { at: at as f64, value, impact }
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

/// First sample of an impact and one past its last, with a margin.
fn reach(impact: &Impact) -> [usize; 2] {
    let margin = ((impact.end - impact.first) / 2).max(1);
    [impact.first.saturating_sub(margin), impact.end + margin]
}

fn given(functions: &[Frf], band_hz: Option<[f64; 2]>, notes: &mut Notes) -> Option<Prepared> {
    let [low, high] = band_hz.unwrap_or([0.0, f64::INFINITY]);
    // One block, so that every response has its place in it.
    let (mut block, mut responses) = (None::<Block>, Vec::new());
    for function in functions {
        let within: Vec<usize> = (0..function.frequencies_hz.len())
            .filter(|&k| {
                let f = function.frequencies_hz[k];
                f > 0.0 && f >= low && f <= high
            })
            .take(MAX_LINES)
            .collect();
        let values: Vec<C64> = within.iter().map(|&k| function.values[k]).collect();
        if values.iter().all(|v| v.norm() == 0.0) {
            let what = "is zero on all lines of the band; the function is left out";
            notes.channel_warning(Code::DeadChannel, &function.name, what);
            continue;
        }
        let omega: Vec<f64> =
            within.iter().map(|&k| rad_per_s_from_hz(function.frequencies_hz[k])).collect();
        match &mut block {
            None => {
                block = Some(Block::new(Origin::Responses { hann_s: None }, omega, vec![values]))
            }
            Some(block) if block.omega == omega => block.spectra.push(values),
            Some(_) => {
                let what = "its lines differ from those of the first function; it is left out";
                notes.channel_warning(Code::Remark, &function.name, what);
                continue;
            }
        }
        responses.push(Response { name: function.name.clone(), quantity: function.quantity });
    }
    let Some(mut block) = block else {
        notes.warning(Code::NoModes, None, "has no response function with lines in the band");
        return None;
    };
    if let Some(length_s) = is_windowed(&block.omega, &block.spectra) {
        let what = format!(
            "the peaks are as wide as a Hann window over {length_s:.4} s makes them, which the fit \
             takes into account; damping is surer from raw records"
        );
        notes.warning(Code::Remark, None, what);
        block.origin = Origin::Responses { hann_s: Some(length_s) };
    }
    block.drive_error = given_error(&block.spectra);
    Some(Prepared::of(RecordKind::GivenResponses, responses, vec![block]))
}

/// Variance of each line of frequency responses that an analyser made, relative to its power.
fn given_error(spectra: &[Vec<C64>]) -> Vec<f64> {
    /// Sensors' gain and phase vary over frequency by this share.
    const OF_SENSORS: f64 = 0.01;
    /// Averages of stretches shorter than a decay scatter where the response bends from line to
    /// line, by this share of its second difference.
    const OF_LEAKAGE: f64 = 0.3;
    /// Lines next to it that the same leakage reaches.
    const REACH: usize = 2;
    let lines = spectra.first().map_or(0, Vec::len);
    let bend = |k: usize| -> f64 {
        let own = |h: &Vec<C64>| (h[k + 1] - h[k] * 2.0 + h[k - 1]).norm_sqr();
        if k == 0 || k + 1 >= lines { 0.0 } else { spectra.iter().map(own).sum() }
    };
    let bends: Vec<f64> = (0..lines).map(bend).collect();
    let relative = |k: usize| {
        let near = &bends[k.saturating_sub(REACH)..(k + REACH + 1).min(lines)];
        let most = near.iter().copied().fold(0.0, f64::max);
        let power: f64 = spectra.iter().map(|h| h[k].norm_sqr()).sum();
        (OF_SENSORS.powi(2) + OF_LEAKAGE.powi(2) * most / power.max(f64::MIN_POSITIVE)).min(1.0)
    };
    (0..lines).map(relative).collect()
}

fn omega(lines: &Range<usize>, samples: usize, rate_hz: f64) -> Vec<f64> {
    lines.clone().map(|k| rad_per_s_from_hz(k as f64 * rate_hz / samples as f64)).collect()
}

fn on_lines(spectra: &[Vec<C64>], lines: &Range<usize>) -> Vec<Vec<C64>> {
    spectra.iter().map(|spectrum| spectrum[lines.clone()].to_vec()).collect()
}

/// The lines of a band.
fn lines(
    samples: usize,
    rate_hz: f64,
    [low_hz, high_hz]: [f64; 2],
    notes: &mut Notes,
) -> Range<usize> {
    let bin_hz = rate_hz / samples as f64;
    // Above it, filters and aliasing dominate.
    let last = (0.97 * 0.5 * samples as f64).floor() as usize;
    let from = ((low_hz / bin_hz).ceil() as usize).max(FIRST_LINE).min(last + 1);
    let to = ((high_hz / bin_hz).floor() as usize).min(last);
    let most = from + MAX_LINES;
    if to > most {
        let what = format!(
            "has more than {MAX_LINES} lines; those above {:.1} Hz are left out; set band_hz to \
             choose the band",
            most as f64 * bin_hz
        );
        notes.warning(Code::Remark, None, what);
    }
    from..(to + 1).min(most).max(from)
}

/// Variance that rounding to steps brings to a line.
fn rounding_noise(step: Option<f64>, samples: usize) -> f64 {
    step.map_or(0.0, |step| samples as f64 * step * step / 12.0)
}

/// The band that is asked for, or the one that the spectra fill, Hz.
fn band(sampling: Sampling, cut: &[(usize, Vec<Vec<C64>>)], notes: &mut Notes) -> [f64; 2] {
    let Some(band) = sampling.band_hz else { return filled_band(cut, sampling.rate_hz) };
    let nyquist = 0.5 * sampling.rate_hz;
    if band[1] > nyquist {
        let what = format!(
            "band_hz reaches up to {} Hz, above half the sampling rate, {nyquist:.1} Hz: it is cut \
             there",
            band[1]
        );
        notes.warning(Code::Remark, None, what);
    }
    band
}

/// The band below the last frequency at which any response stands out.
fn filled_band(cut: &[(usize, Vec<Vec<C64>>)], rate_hz: f64) -> [f64; 2] {
    let nyquist = 0.5 * rate_hz;
    let mut highest: f64 = 0.0;
    for (_, spectra) in cut {
        for spectrum in spectra {
            let lines = spectrum.len().saturating_sub(1);
            let per_cell = (lines / 400).max(1);
            let powers: Vec<f64> = spectrum[FIRST_LINE.min(lines)..lines]
                .chunks(per_cell)
                .map(|chunk| chunk.iter().map(C64::norm_sqr).fold(0.0, f64::max))
                .collect();
            let floor = upper_median(&powers).unwrap_or(0.0);
            let peak = powers.iter().copied().fold(0.0, f64::max);
            let stands_out =
                |p: &f64| *p > 1e-5 * peak && *p > 4.0 * floor * (per_cell as f64).ln().max(1.0);
            if let Some(last) = powers.iter().rposition(stands_out) {
                highest = highest.max((last + 1) as f64 / powers.len() as f64);
            }
        }
    }
    // With room above the last peak; at least a tenth of the lines, however low the peaks.
    let filled = (1.3 * highest).max(0.1);
    // A band that nearly fills the lines takes them all.
    let filled = if filled > 0.6 { 1.0 } else { filled };
    [0.0, filled * nyquist]
}

/// The frequencies of a block's lines, Hz.
pub(super) fn lines_hz(block: &Block) -> Vec<f64> {
    block.omega.iter().map(|w| hz_from_rad_per_s(*w)).collect()
}
