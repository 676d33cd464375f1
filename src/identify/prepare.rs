//! Records → spectra ready for the estimation, in the band that the record fills.

use std::borrow::Cow;

use super::estimate::{Block, C64, Origin, Push};
use super::hits::{Decay, Hit, decays, deviation, hits_in_force, median};
use super::notice::{NoticeKind, Notices};
use super::quality::{check_channel, rounding_step, without_gaps, without_spikes};
use super::record::{Channel, Data, Frf, Quantity, Record};
use super::spectra::{Averaged, Window, over_hits, over_stretches, transform};
use crate::units::{hz_from_rad_per_s, rad_per_s_from_hz};

/// Lines below this are offset and drift.
const LOWEST_LINE: usize = 2;

/// Share of half the sampling rate up to which lines are used: above, filters and folding rule.
const NYQUIST_SHARE: f64 = 0.97;

/// Most lines of one spectrum that are fitted.
const MOST_LINES: usize = 12_000;

/// Shorter decays are passed over.
const SHORTEST_DECAY: usize = 24;

/// The band ends where the smoothed power stays below this share of its peak or this multiple of the floor.
const BAND_SHARE: f64 = 1e-5;
const BAND_ABOVE_FLOOR: f64 = 4.0;

/// Room above the last peak.
const BAND_ROOM: f64 = 1.3;

/// The lowest share of the lines that the band has, however low the peaks.
const LEAST_BAND: f64 = 0.1;

/// The samples of a short pulse tell its spectrum no better than this, as a share.
const SAMPLED_PULSE: f64 = 2e-3;

/// Lines on which the force is lost in noise are no worse than this, against its power.
const MOST_DRIVE_ERROR: f64 = 1.0;

/// A response that the estimation sees.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Response {
    pub(super) name: String,
    pub(super) quantity: Quantity,
}

/// A record ready for the estimation.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    pub(super) responses: Vec<Response>,
    pub(super) blocks: Vec<Block>,
    /// What the linear least squares start from: lines and spectra of each set, and what their window adds
    /// to the decay, 1/s.
    pub(super) starts_from: Vec<(Vec<f64>, Vec<Vec<C64>>)>,
    pub(super) window_decay: f64,
    /// Half the sampling rate, Hz, where there is one.
    pub(super) nyquist_hz: Option<f64>,
    /// Averaged frequency responses of records with force.
    pub(super) averaged: Option<Averaged>,
    /// How the record was taken.
    pub(super) kind: Kind,
}

/// How the arm was excited, as far as the record shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Force pulses.
    Hammer,
    /// A force that goes on.
    Steady,
    /// No force channel.
    FreeDecay,
    /// Frequency responses as the instrument made them.
    GivenResponses,
}

/// Cuts and transforms a record; `None` (with a notice) where there is nothing to fit.
pub(super) fn prepare(
    record: &Record,
    band_hz: Option<[f64; 2]>,
    notices: &mut Notices,
) -> Option<Prepared> {
    match &record.data {
        Data::Responses(functions) => given(functions, band_hz, notices),
        Data::Time { sample_rate_hz, excitation, responses } => {
            let usable: Vec<&Channel> =
                responses.iter().filter(|channel| check_channel(channel, false, notices)).collect();
            let usable = without_gaps(usable, *sample_rate_hz, notices);
            if usable.is_empty() {
                notices.add(NoticeKind::NoModes, None, "has no response that moves".to_owned());
                return None;
            }
            let named = usable
                .iter()
                .map(|c| Response { name: c.name.clone(), quantity: c.quantity })
                .collect();
            match excitation {
                Some(force) if check_channel(force, true, notices) => {
                    forced(*sample_rate_hz, force, &usable, named, band_hz, notices)
                }
                Some(_) => {
                    let what =
                        "the excitation does not move, so nothing is known of the force".to_owned();
                    notices.add(NoticeKind::NoModes, None, what);
                    None
                }
                None => free(*sample_rate_hz, &usable, named, band_hz, notices),
            }
        }
    }
}

fn without_offset(samples: &[f64]) -> Vec<f64> {
    let mean = samples.iter().sum::<f64>() / samples.len().max(1) as f64;
    samples.iter().map(|s| s - mean).collect()
}

fn free(
    sample_rate_hz: f64,
    channels: &[&Channel],
    responses: Vec<Response>,
    band_hz: Option<[f64; 2]>,
    notices: &mut Notices,
) -> Option<Prepared> {
    let steps: Vec<Option<f64>> =
        channels.iter().map(|channel| rounding_step(&channel.samples)).collect();
    let channels: Vec<Cow<'_, Channel>> = channels
        .iter()
        .map(|channel| without_spikes(channel, sample_rate_hz, &[], notices))
        .collect();
    let level: Vec<Vec<f64>> = channels
        .iter()
        .map(|channel| {
            let middle = median(&channel.samples);
            channel.samples.iter().map(|s| s - middle).collect()
        })
        .collect();
    let level: Vec<&[f64]> = level.iter().map(Vec::as_slice).collect();
    let found = decays(&level, sample_rate_hz);
    let long: Vec<Decay> =
        found.iter().copied().filter(|decay| decay.to - decay.from >= SHORTEST_DECAY).collect();
    tell_of_short_decays(&found, &long, sample_rate_hz, notices);
    if long.is_empty() {
        let what = format!(
            "holds no free decay of {SHORTEST_DECAY} samples or more; is the record cut before the hit?"
        );
        notices.add(NoticeKind::NoModes, None, what);
        return None;
    }
    let cut: Vec<(usize, Vec<Vec<C64>>)> = long
        .iter()
        .map(|decay| {
            let of = |channel: &Cow<'_, Channel>| {
                transform(&without_offset(&channel.samples[decay.from..decay.to]))
            };
            (decay.to - decay.from, channels.iter().map(of).collect())
        })
        .collect();
    let [low, high] = band(band_hz, &cut, sample_rate_hz, notices);
    let step_s = sample_rate_hz.recip();
    let mut blocks = Vec::new();
    for (samples, spectra) in cut {
        let lines = lines(samples, sample_rate_hz, low, high, notices);
        blocks.push(Block {
            origin: Origin::Sampled { step_s, samples, force: None },
            omega: omega(&lines, samples, sample_rate_hz),
            drive: Vec::new(),
            drive_error: Vec::new(),
            least_noise: steps.iter().map(|step| rounding(*step, samples)).collect(),
            begins_moving: false,
            envelopes: Vec::new(),
            spectra: spectra.iter().map(|s| s[lines.clone()].to_vec()).collect(),
        });
    }
    blocks.retain(|block| !block.omega.is_empty());
    if blocks.is_empty() {
        notices.add(NoticeKind::NoModes, None, "is too short for any line in the band".to_owned());
        return None;
    }
    let starts_from =
        blocks.iter().map(|block| (block.omega.clone(), block.spectra.clone())).collect();
    Some(Prepared {
        responses,
        blocks,
        starts_from,
        window_decay: 0.0,
        nyquist_hz: Some(0.5 * sample_rate_hz),
        averaged: None,
        kind: Kind::FreeDecay,
    })
}

/// A decay that another hit cuts short is a double hit.
fn tell_of_short_decays(
    found: &[Decay],
    long: &[Decay],
    sample_rate_hz: f64,
    notices: &mut Notices,
) {
    let longest = long.iter().map(|decay| decay.to - decay.from).max().unwrap_or(0);
    for decay in &found[..found.len().saturating_sub(1)] {
        if 4 * (decay.to - decay.from) < longest {
            let what = format!(
                "the decay that begins at {:.3} s is cut short by a second hit at {:.3} s; hit once and wait",
                decay.from as f64 / sample_rate_hz,
                decay.to as f64 / sample_rate_hz
            );
            notices.add(NoticeKind::DoubleHit, None, what);
        }
    }
}

fn forced(
    sample_rate_hz: f64,
    excitation: &Channel,
    channels: &[&Channel],
    responses: Vec<Response>,
    band_hz: Option<[f64; 2]>,
    notices: &mut Notices,
) -> Option<Prepared> {
    let middle = median(&excitation.samples);
    let mut force: Vec<f64> = excitation.samples.iter().map(|f| f - middle).collect();
    let hits = hits_in_force(&force, sample_rate_hz);
    for hit in hits.iter().filter(|hit| hit.pulses > 1) {
        let what = format!(
            "{} pulses within one blow at {:.3} s: the hammer bounced; all of them are taken into account, but \
             a clean hit is better",
            hit.pulses,
            hit.first as f64 / sample_rate_hz
        );
        notices.add(NoticeKind::DoubleHit, Some(&excitation.name), what);
    }
    let blows: Vec<_> = hits.iter().map(reach).map(|[from, to]| from..to + 2).collect();
    let samples = force.len();
    let least_noise: Vec<f64> =
        channels.iter().map(|channel| rounding(rounding_step(&channel.samples), samples)).collect();
    // An excitation that goes on may be made of blows.
    let channels: Vec<Cow<'_, Channel>> = channels
        .iter()
        .map(|channel| match hits.is_empty() {
            true => Cow::Borrowed(*channel),
            false => without_spikes(channel, sample_rate_hz, &blows, notices),
        })
        .collect();
    let moves: Vec<Vec<f64>> = channels.iter().map(|c| without_offset(&c.samples)).collect();
    let moves: Vec<&[f64]> = moves.iter().map(Vec::as_slice).collect();
    let mut force_noise = 0.0;
    let averaged = if hits.is_empty() {
        over_stretches(&force, &moves, sample_rate_hz)
    } else {
        let mut inside = vec![false; force.len()];
        for hit in &hits {
            let [from, to] = reach(hit);
            inside[from..to.min(force.len())].fill(true);
        }
        let outside = force.iter().zip(&inside).filter(|(_, inside)| !**inside);
        force_noise = deviation(&outside.map(|(f, _)| *f).collect::<Vec<_>>());
        force.iter_mut().zip(&inside).filter(|(_, inside)| !**inside).for_each(|(f, _)| *f = 0.0);
        over_hits(&force, &moves, &hits, sample_rate_hz)
    };
    let spectra: Vec<Vec<C64>> = moves.iter().map(|m| transform(m)).collect();
    let cut = [(samples, spectra)];
    let [low, high] = band(band_hz, &cut, sample_rate_hz, notices);
    let lines = lines(samples, sample_rate_hz, low, high, notices);
    if lines.is_empty() {
        notices.add(NoticeKind::NoModes, None, "is too short for any line in the band".to_owned());
        return None;
    }
    let [(_, spectra)] = cut;
    let push = |(at, &value): (usize, &f64)| {
        let blow = hits.iter().position(|hit| at < reach(hit)[1]).unwrap_or(0);
        Push { at: at as f64, value, blow }
    };
    let nonzero: Vec<Push> =
        force.iter().enumerate().filter(|(_, f)| **f != 0.0).map(push).collect();
    let drive = transform(&force)[lines.clone()].to_vec();
    let drive_error = if hits.is_empty() {
        Vec::new()
    } else {
        let variance = force_noise.powi(2) * nonzero.len() as f64;
        drive.iter().map(|f| drive_error(variance, f.norm_sqr())).collect()
    };
    let block = Block {
        origin: Origin::Sampled { step_s: sample_rate_hz.recip(), samples, force: Some(nonzero) },
        omega: omega(&lines, samples, sample_rate_hz),
        drive,
        drive_error,
        least_noise,
        begins_moving: hits.is_empty(),
        envelopes: Vec::new(),
        spectra: spectra.iter().map(|s| s[lines.clone()].to_vec()).collect(),
    };
    let mut starts_from = Vec::new();
    let mut window_decay = 0.0;
    if let Some(averaged) = &averaged {
        let within: Vec<usize> = (0..averaged.frequencies_hz.len())
            .filter(|&k| {
                k > 0 && averaged.frequencies_hz[k] >= low && averaged.frequencies_hz[k] <= high
            })
            .collect();
        let pick = |h: &Vec<C64>| within.iter().map(|&k| h[k]).collect();
        starts_from.push((
            within.iter().map(|&k| rad_per_s_from_hz(averaged.frequencies_hz[k])).collect(),
            averaged.h1.iter().map(pick).collect(),
        ));
        if let Window::ForceExponential { decay_per_s } = averaged.window {
            window_decay = decay_per_s;
        }
    }
    Some(Prepared {
        responses,
        blocks: vec![block],
        starts_from,
        window_decay,
        nyquist_hz: Some(0.5 * sample_rate_hz),
        averaged,
        kind: if hits.is_empty() { Kind::Steady } else { Kind::Hammer },
    })
}

/// Variance of a line of the force against its power: noise in the samples of the pulses, and what the
/// samples miss of a short pulse.
fn drive_error(variance: f64, power: f64) -> f64 {
    (variance / power.max(f64::MIN_POSITIVE)).min(MOST_DRIVE_ERROR) + SAMPLED_PULSE.powi(2)
}

/// First sample of a hit and one past its last, with some room.
fn reach(hit: &Hit) -> [usize; 2] {
    let margin = ((hit.end - hit.first) / 2).max(1);
    [hit.first.saturating_sub(margin), hit.end + margin]
}

fn given(functions: &[Frf], band_hz: Option<[f64; 2]>, notices: &mut Notices) -> Option<Prepared> {
    let (mut blocks, mut responses) = (Vec::<Block>::new(), Vec::new());
    for function in functions {
        let [low, high] = band_hz.unwrap_or([0.0, f64::INFINITY]);
        let within: Vec<usize> = (0..function.frequencies_hz.len())
            .filter(|&k| {
                let f = function.frequencies_hz[k];
                f > 0.0 && f >= low && f <= high
            })
            .take(MOST_LINES)
            .collect();
        let values: Vec<C64> = within.iter().map(|&k| function.values[k]).collect();
        if values.iter().all(|v| v.norm() == 0.0) {
            let what = "is zero on all lines of the band; the function is left out".to_owned();
            notices.add(NoticeKind::DeadChannel, Some(&function.name), what);
            continue;
        }
        let omega: Vec<f64> =
            within.iter().map(|&k| rad_per_s_from_hz(function.frequencies_hz[k])).collect();
        responses.push(Response { name: function.name.clone(), quantity: function.quantity });
        // One block, so that every response has its place in it.
        match blocks.first_mut() {
            None => blocks.push(Block {
                origin: Origin::Responses,
                omega,
                drive: Vec::new(),
                drive_error: Vec::new(),
                least_noise: Vec::new(),
                begins_moving: false,
                envelopes: Vec::new(),
                spectra: vec![values],
            }),
            Some(block) if block.omega == omega => block.spectra.push(values),
            Some(_) => {
                responses.pop();
                let what = "has other lines than the first function; it is left out".to_owned();
                notices.add(NoticeKind::Remark, Some(&function.name), what);
            }
        }
    }
    if blocks.is_empty() {
        notices.add(
            NoticeKind::NoModes,
            None,
            "has no response function with lines in the band".to_owned(),
        );
        return None;
    }
    let starts_from =
        blocks.iter().map(|block| (block.omega.clone(), block.spectra.clone())).collect();
    Some(Prepared {
        responses,
        blocks,
        starts_from,
        window_decay: 0.0,
        nyquist_hz: None,
        averaged: None,
        kind: Kind::GivenResponses,
    })
}

fn omega(lines: &std::ops::Range<usize>, samples: usize, sample_rate_hz: f64) -> Vec<f64> {
    lines.clone().map(|k| rad_per_s_from_hz(k as f64 * sample_rate_hz / samples as f64)).collect()
}

/// The lines of a band.
fn lines(
    samples: usize,
    sample_rate_hz: f64,
    low_hz: f64,
    high_hz: f64,
    notices: &mut Notices,
) -> std::ops::Range<usize> {
    let bin_hz = sample_rate_hz / samples as f64;
    let last = (NYQUIST_SHARE * 0.5 * samples as f64).floor() as usize;
    let from = ((low_hz / bin_hz).ceil() as usize).max(LOWEST_LINE).min(last + 1);
    let to = ((high_hz / bin_hz).floor() as usize).min(last);
    let most = from + MOST_LINES;
    if to > most {
        let what = format!(
            "has more than {MOST_LINES} lines; those above {:.1} Hz are left out; give band_hz to choose",
            most as f64 * bin_hz
        );
        notices.add(NoticeKind::Remark, None, what);
    }
    from..(to + 1).min(most).max(from)
}

/// Variance that rounding to steps brings to a line.
fn rounding(step: Option<f64>, samples: usize) -> f64 {
    step.map_or(0.0, |step| samples as f64 * step * step / 12.0)
}

/// The band that is asked for, or the one that the spectra fill.
fn band(
    asked: Option<[f64; 2]>,
    cut: &[(usize, Vec<Vec<C64>>)],
    sample_rate_hz: f64,
    notices: &mut Notices,
) -> [f64; 2] {
    let Some(band) = asked else { return filled_band(cut, sample_rate_hz) };
    let nyquist = 0.5 * sample_rate_hz;
    if band[1] > nyquist {
        let what = format!(
            "band_hz reaches up to {} Hz, above half the sampling rate, {nyquist:.1} Hz: it is cut there",
            band[1]
        );
        notices.add(NoticeKind::Remark, None, what);
    }
    band
}

/// The band below the last frequency at which any response stands out.
fn filled_band(cut: &[(usize, Vec<Vec<C64>>)], sample_rate_hz: f64) -> [f64; 2] {
    const CELLS: usize = 400;
    let nyquist = 0.5 * sample_rate_hz;
    let mut highest: f64 = 0.0;
    for (_, spectra) in cut {
        for spectrum in spectra {
            let lines = spectrum.len().saturating_sub(1);
            let per_cell = (lines / CELLS).max(1);
            let powers: Vec<f64> = spectrum[LOWEST_LINE.min(lines)..lines]
                .chunks(per_cell)
                .map(|chunk| chunk.iter().map(C64::norm_sqr).fold(0.0, f64::max))
                .collect();
            let floor = median(&powers);
            let peak = powers.iter().copied().fold(0.0, f64::max);
            let stands_out = |p: &f64| {
                *p > BAND_SHARE * peak
                    && *p > BAND_ABOVE_FLOOR * floor * (per_cell as f64).ln().max(1.0)
            };
            if let Some(last) = powers.iter().rposition(stands_out) {
                highest = highest.max((last + 1) as f64 / powers.len() as f64);
            }
        }
    }
    let share = (BAND_ROOM * highest).max(LEAST_BAND);
    // A band that nearly fills the lines takes them all.
    let share = if share > 0.6 { 1.0 } else { share };
    [0.0, share * nyquist]
}

/// The frequencies of a block's lines, Hz.
pub(super) fn lines_hz(block: &Block) -> Vec<f64> {
    block.omega.iter().map(|w| hz_from_rad_per_s(*w)).collect()
}
