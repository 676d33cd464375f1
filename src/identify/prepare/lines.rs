//! Which lines of a spectrum are fitted.

use std::ops::Range;

use super::Sampling;
use crate::identify::estimate::{Block, C64};
use crate::notes::{Code, Notes};
use crate::statistics::upper_median;
use crate::units::{hz_from_rad_per_s, rad_per_s_from_hz};

/// Lines below this are offset and drift.
const FIRST_LINE: usize = 2;

/// Above this share of half the sampling rate, filters and aliasing dominate.
const EDGE: f64 = 0.97;

/// Most lines of one spectrum that are fitted.
pub(super) const MAX_LINES: usize = 12_000;

pub(super) fn omega(lines: &Range<usize>, samples: usize, rate_hz: f64) -> Vec<f64> {
    lines.clone().map(|k| rad_per_s_from_hz(k as f64 * rate_hz / samples as f64)).collect()
}

pub(super) fn on_lines(spectra: &[Vec<C64>], lines: &Range<usize>) -> Vec<Vec<C64>> {
    spectra.iter().map(|spectrum| spectrum[lines.clone()].to_vec()).collect()
}

/// The lines of a band.
pub(super) fn lines(
    samples: usize,
    rate_hz: f64,
    [low_hz, high_hz]: [f64; 2],
    notes: &mut Notes,
) -> Range<usize> {
    let bin_hz = rate_hz / samples as f64;
    let last = (EDGE * 0.5 * samples as f64).floor() as usize;
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

/// Most samples whose band has so many lines at most.
pub(super) fn most_samples(rate_hz: f64, [low_hz, high_hz]: [f64; 2]) -> usize {
    let width = (high_hz.min(0.5 * rate_hz) - low_hz).max(f64::MIN_POSITIVE);
    (MAX_LINES as f64 * rate_hz / width) as usize
}

/// Shorter decays are left out.
pub(super) const MIN_DECAY_SAMPLES: usize = 24;

/// Tells that a part of a record must do.
pub(super) fn warn_of_part(samples: usize, rate_hz: f64, what: &str, notes: &mut Notes) {
    let what = format!(
        "is so long that its band has more than {MAX_LINES} lines: {:.1} s {what}; set band_hz for \
         more of a narrower band",
        samples as f64 / rate_hz
    );
    notes.warning(Code::Remark, None, what);
}

/// Tells where a free vibration does not go on as it did.
pub(super) fn warn_of_break(at: usize, rate_hz: f64, done: &str, notes: &mut Notes) {
    let what = format!(
        "at {:.3} s the responses do not go on as free vibration does: samples were lost there, or \
         something struck the arm that no force channel has; {done}; record again",
        at as f64 / rate_hz
    );
    notes.warning(Code::Discontinuity, None, what);
}

/// Tells a peak so near half the sampling rate that its lines are left out.
pub(super) fn warn_of_edge(
    cut: &[(usize, Vec<Vec<C64>>)],
    rate_hz: f64,
    highest_hz: f64,
    notes: &mut Notes,
) {
    /// Power over the mean below: of noise the loudest of a thousand lines has 7.
    const FAR: f64 = 20.0;
    let mut found: Option<f64> = None;
    for (_, spectra) in cut {
        for spectrum in spectra {
            let lines = spectrum.len().saturating_sub(1);
            let at = |share: f64| (share * lines as f64) as usize;
            let power = |k: usize| spectrum[k].norm_sqr();
            let below = at(0.8)..at(0.88);
            let mean = below.clone().map(power).sum::<f64>() / below.len().max(1) as f64;
            let loudest = (at(0.965)..lines).max_by(|a, b| power(*a).total_cmp(&power(*b)));
            if let Some(k) = loudest.filter(|k| below.len() >= 8 && power(*k) > FAR * mean) {
                found = found.or(Some(0.5 * rate_hz * k as f64 / lines as f64));
            }
        }
    }
    if let Some(hz) = found.filter(|hz| *hz <= highest_hz) {
        let what = format!(
            "a peak at {hz:.2} Hz lies within 4 % of half the sampling rate, where no modes are \
             looked for: sample faster"
        );
        notes.warning(Code::MayBeFolded, None, what);
    }
}

/// Variance that rounding to steps brings to a line.
pub(super) fn rounding_noise(step: Option<f64>, samples: usize) -> f64 {
    step.map_or(0.0, |step| samples as f64 * step * step / 12.0)
}

/// The band that is asked for, or the one that the spectra fill, Hz.
pub(super) fn band(
    sampling: Sampling,
    cut: &[(usize, Vec<Vec<C64>>)],
    notes: &mut Notes,
) -> [f64; 2] {
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
pub(in crate::identify) fn lines_hz(block: &Block) -> Vec<f64> {
    block.omega.iter().map(|w| hz_from_rad_per_s(*w)).collect()
}
