//! Records → spectra ready for the estimation, in the band that the record fills.

mod coupling;
mod forced;
mod given;
mod lines;
mod uneven;
mod unforced;

use forced::forced;
use given::given;
pub(super) use lines::lines_hz;
use uneven::resampled_evenly;
use unforced::free;

use super::estimate::subspace::Stationary;
use super::estimate::{Block, C64};
use super::quality::{check_channel, check_flat, without_clipped, without_gaps};
use super::record::{Channel, Data, Instrument, Quantity, Record};
use super::references::Pairs;
use super::spectra::Averaged;
use crate::notes::{Code, Notes};
use crate::statistics::mean;

/// Sampling rates below this are a wrong unit of time rather than a record of an arm.
const SLOW_HZ: f64 = 5.0;

/// Sampling rates above this, in records that are shorter than that, s, are so too: no mode of an
/// arm rings so briefly.
const FAST_HZ: f64 = 2e4;
const BRIEF_S: f64 = 0.1;

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
    /// Which response and reference each function is of, where there are several references.
    pub(super) pairs: Option<Pairs>,
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
            pairs: None,
        }
    }
}

/// What is asked of a record beside its samples.
#[derive(Debug, Clone, Copy)]
struct Sampling {
    rate_hz: f64,
    band_hz: Option<[f64; 2]>,
    /// By how much the responses are late against the force.
    delay_s: f64,
    /// Time constant of the exponential window over the responses.
    window_s: Option<f64>,
}

/// Cuts and transforms a record; `None` (with a warning) where there is nothing to fit.
pub(super) fn prepare(
    record: &Record,
    band_hz: Option<[f64; 2]>,
    notes: &mut Notes,
) -> Option<Prepared> {
    let Instrument { exponential_window_s: window_s, response_delay_s: delay_s } =
        record.instrument;
    match &record.data {
        Data::Responses(functions) => given(functions, band_hz, delay_s, notes),
        Data::Time { sample_rate_hz, excitation, responses } => {
            let sampling = Sampling { rate_hz: *sample_rate_hz, band_hz, delay_s, window_s };
            sampled(sampling, excitation.as_ref(), responses, notes)
        }
        Data::Uneven { times_s, excitation, responses } => {
            let Some(resampled) = resampled_evenly(times_s, notes) else {
                notes.warning(Code::NoModes, None, "has times that do not rise");
                return None;
            };
            let excitation = excitation.as_ref().map(|channel| resampled.channel(channel));
            let responses: Vec<Channel> =
                responses.iter().map(|channel| resampled.channel(channel)).collect();
            let band_hz = band_hz.or(Some([0.0, resampled.highest_hz()]));
            let sampling = Sampling { rate_hz: resampled.rate_hz, band_hz, delay_s, window_s };
            sampled(sampling, excitation.as_ref(), &responses, notes)
        }
    }
}

/// What an exponential window over a record is divided by: noise that was windowed is white again,
/// while the poles of a windowed record lie in noise that is not.
struct Growth {
    /// The window's time constant in steps of the record.
    steps: f64,
}

impl Growth {
    /// Where the window leaves less than a hundredth, rounding is louder than the arm.
    const MOST: f64 = 100.0;

    fn cut(&self, channel: &Channel) -> Channel {
        let kept = (self.steps * Self::MOST.ln()).ceil() as usize;
        let samples = channel.samples.iter().take(kept.max(1)).copied().collect();
        Channel { samples, ..channel.clone() }
    }

    fn of(&self, channel: &Channel) -> Channel {
        let mut grown = self.cut(channel);
        for (k, sample) in grown.samples.iter_mut().enumerate() {
            *sample *= (k as f64 / self.steps).exp();
        }
        grown
    }
}

fn sampled(
    sampling: Sampling,
    excitation: Option<&Channel>,
    responses: &[Channel],
    notes: &mut Notes,
) -> Option<Prepared> {
    let usable: Vec<&Channel> =
        responses.iter().filter(|channel| check_channel(channel, false, notes)).collect();
    let growth = sampling.window_s.map(|window_s| Growth { steps: window_s * sampling.rate_hz });
    if let Some(growth) = &growth {
        // What was clipped before the window was laid over it is flat where that is taken off.
        usable.iter().for_each(|channel| check_flat(&growth.of(channel), notes));
    }
    let usable = without_gaps(without_clipped(usable, notes), sampling.rate_hz, notes);
    if sampling.rate_hz < SLOW_HZ {
        let what = format!(
            "has {:.3} samples/s, too few for modes of an arm: check sample_rate_hz, or the unit \
             of the times",
            sampling.rate_hz
        );
        notes.warning(Code::Remark, None, what);
    }
    if sampling.rate_hz > FAST_HZ && samples_of(&usable) < BRIEF_S * sampling.rate_hz {
        let what = format!(
            "lasts {:.3} ms at {:.0} samples/s, too short and too fast for modes of an arm: check \
             sample_rate_hz, or the unit of the times",
            1e3 * samples_of(&usable) / sampling.rate_hz,
            sampling.rate_hz
        );
        notes.warning(Code::Units, None, what);
    }
    if usable.is_empty() {
        notes.warning(Code::NoModes, None, "has no response that moves");
        return None;
    }
    let Some(growth) = growth else { return excited(sampling, excitation, &usable, notes) };
    let grown: Vec<Channel> = usable.iter().map(|channel| growth.of(channel)).collect();
    let grown: Vec<&Channel> = grown.iter().collect();
    if samples_of(&grown) < samples_of(&usable) {
        let what = format!(
            "samples from {:.3} s on are left out: exponential_window_s leaves less than 1 % there",
            samples_of(&grown) / sampling.rate_hz
        );
        notes.warning(Code::Remark, None, what);
    }
    let force = excitation.map(|channel| growth.cut(channel));
    excited(sampling, force.as_ref(), &grown, notes)
}

/// Samples of each channel.
fn samples_of(channels: &[&Channel]) -> f64 {
    channels.first().map_or(0, |channel| channel.samples.len()) as f64
}

fn excited(
    sampling: Sampling,
    excitation: Option<&Channel>,
    responses: &[&Channel],
    notes: &mut Notes,
) -> Option<Prepared> {
    match excitation {
        Some(force) if check_channel(force, true, notes) => {
            forced(sampling, force, responses, notes)
        }
        Some(_) => {
            let what = "the excitation does not move, so the force is unknown";
            notes.warning(Code::NoModes, None, what);
            None
        }
        None => free(sampling, responses, notes),
    }
}

fn responses_of(channels: &[&Channel]) -> Vec<Response> {
    let response = |c: &&Channel| Response { name: c.name.clone(), quantity: c.quantity };
    channels.iter().map(response).collect()
}

pub(super) fn without_offset(samples: &[f64]) -> Vec<f64> {
    let offset = if samples.is_empty() { 0.0 } else { mean(samples) };
    samples.iter().map(|s| s - offset).collect()
}
