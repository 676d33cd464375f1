//! Tones of mains and spindle in a random response, taken off before its modes are looked for: a
//! tone within the width of a mode is no pole of its own there, but pulls that of the mode.

use std::f64::consts::TAU;

use super::estimate::C64;
use super::harmonics::Harmonics;
use super::prepare::without_offset;
use super::record::{Channel, Data, Record};
use super::spectra::transform;
use crate::notes::Notes;
use crate::statistics::upper_median;

/// A frequency that wanders spreads a tone so far, Hz: powers are summed over as many lines.
const WANDERS_HZ: f64 = 0.02;

/// Least power of a tone on one line, and on many together, as a multiple of that around: noise on
/// one line exceeds 40 times the median once in 10¹² lines.
const LOUD: f64 = 40.0;
const LOUD_TOGETHER: f64 = 10.0;

/// Where the power around is taken, in lines or sums of lines from the tone; that is narrower than
/// any mode of which the record holds enough decays.
const AROUND: [usize; 2] = [3, 10];

/// Lines next to the loudest with more than this multiple of the power around belong to the tone,
/// up to so many to either side.
const ABOVE: f64 = 4.0;
const MOST_SPREAD: usize = 40;

/// A record without the tones that the session states, where it holds any; they are told.
pub(super) fn taken_off(record: &Record, mains_hz: &[f64], notes: &mut Notes) -> Option<Record> {
    let Data::Time { sample_rate_hz, excitation, responses } = &record.data else { return None };
    let samples = responses.first().map_or(0, |own| own.samples.len());
    let mut spectra: Vec<Vec<C64>> =
        responses.iter().map(|own| transform(&without_offset(&own.samples))).collect();
    let sums: Vec<Vec<f64>> = spectra.iter().map(|own| sums_under_hann(own)).collect();
    let line_hz = sample_rate_hz / samples.max(1) as f64;
    let width = ((WANDERS_HZ / line_hz) as usize).max(1);
    let mut found: Vec<(usize, Vec<C64>)> = Vec::new();
    for source in Harmonics::all(mains_hz, record.spindle_rpm) {
        for own in source.seen(Some(0.5 * sample_rate_hz)) {
            let [low, high] = [own.seen_hz - own.within_hz, own.seen_hz + own.within_hz]
                .map(|hz| (hz / line_hz).round().max(0.0) as usize);
            let tone = Tone::within((&spectra, &sums), [low, high], width);
            // Two multiples may be folded to one place.
            let is_new = |tone: &Tone| found.iter().all(|(line, _)| *line != tone.loudest);
            let Some(tone) = tone.filter(is_new) else { continue };
            let what = format!(
                "a steady tone at {:.3} Hz, {} times the {} frequency of {:.3} Hz{}, was taken off \
                 the responses before modes were looked for",
                tone.loudest as f64 * line_hz,
                own.order,
                source.name(),
                source.base_hz,
                if own.is_alias { ", aliased" } else { "" }
            );
            notes.warning(source.code, None, what);
            found.extend(tone.taken_off(&mut spectra));
        }
    }
    if found.is_empty() {
        return None;
    }
    let without = |(at, channel): (usize, &Channel)| {
        let mut own = channel.clone();
        for (line, removed) in &found {
            subtract(&mut own.samples, *line, removed[at]);
        }
        own
    };
    let data = Data::Time {
        sample_rate_hz: *sample_rate_hz,
        excitation: excitation.clone(),
        responses: responses.iter().enumerate().map(without).collect(),
    };
    Some(Record { data, ..record.clone() })
}

/// Takes one line of a transform off the samples.
fn subtract(samples: &mut [f64], line: usize, value: C64) {
    /// Samples after which the turn is computed anew: products lose digits.
    const ANEW: usize = 256;
    let count = samples.len().max(1);
    let turn = |at: usize| {
        // Whole circles would cost digits, too.
        let rest = (line as u64 * at as u64 % count as u64) as f64;
        C64::from_polar(1.0, TAU * rest / count as f64)
    };
    for (place, part) in samples.chunks_mut(ANEW).enumerate() {
        let mut own = value * turn(place * ANEW) * (2.0 / count as f64);
        for sample in part {
            *sample -= own.re;
            own *= turn(1);
        }
    }
}

/// The power of all lines before each under a Hann window, which is one over neighbouring lines
/// here.
fn sums_under_hann(spectrum: &[C64]) -> Vec<f64> {
    let own = spectrum.windows(3).map(|lines| (lines[1] - (lines[0] + lines[2]) * 0.5).norm_sqr());
    let mut sum = 0.0;
    let before = own.map(|power| {
        sum += power;
        sum
    });
    // The first line and the second are those before which there is nothing.
    [0.0, 0.0].into_iter().chain(before).collect()
}

/// A tone in the spectra of all responses.
struct Tone {
    loudest: usize,
    /// The first line and the last.
    lines: [usize; 2],
    /// By response, the median power of a line around.
    around: Vec<f64>,
}

impl Tone {
    /// The loudest on some lines, where `width` of them stand out together under a Hann window,
    /// which keeps a tone off the lines around.
    fn within(
        (spectra, sums): (&[Vec<C64>], &[Vec<f64>]),
        [low, high]: [usize; 2],
        width: usize,
    ) -> Option<Self> {
        let lines = spectra.first()?.len();
        let reach = AROUND[1] * width + width + 2;
        let (low, high) = (low.max(reach + 1), high.min(lines.checked_sub(reach + 2)?));
        let half = width / 2;
        let sum = |sums: &Vec<f64>, k: usize| sums[k - half + width] - sums[k - half];
        let median_about = |k: usize, of: &dyn Fn(usize) -> f64| {
            let from = (AROUND[0] * width..=AROUND[1] * width).step_by(width);
            let powers: Vec<f64> = from.flat_map(|away| [k - away, k + away]).map(of).collect();
            upper_median(&powers).unwrap_or(0.0).max(f64::MIN_POSITIVE)
        };
        let ratio = |k: usize| -> f64 {
            let of = |own: &Vec<f64>| {
                // Differences of sums know no more digits.
                let least = 1e-12 * own.last().copied().unwrap_or(0.0);
                sum(own, k) / median_about(k, &|k| sum(own, k)).max(least)
            };
            sums.iter().map(of).sum::<f64>() / sums.len() as f64
        };
        let (loud, middle) =
            (low..=high).map(|k| (ratio(k), k)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        if loud < (LOUD / width as f64).max(LOUD_TOGETHER) {
            return None;
        }
        let plain =
            |own: &Vec<C64>| median_about(middle, &|k| own.get(k).map_or(0.0, C64::norm_sqr));
        let around: Vec<f64> = spectra.iter().map(plain).collect();
        let power = |k: usize| relative(spectra, &around, k);
        let near = middle - half..=middle + half;
        let loudest = near.max_by(|&a, &b| power(a).total_cmp(&power(b)))?;
        // A frequency that swings has lines with gaps between them.
        let reach_of = |lines: &mut dyn Iterator<Item = usize>| {
            let mut last = loudest;
            for k in lines {
                if power(k) > ABOVE {
                    last = k;
                } else if k.abs_diff(last) > half {
                    break;
                }
            }
            last
        };
        let mut below = (loudest.saturating_sub(MOST_SPREAD).max(1)..loudest).rev();
        let mut above = loudest + 1..=(loudest + MOST_SPREAD).min(lines - 1);
        let (below, above) = (reach_of(&mut below), reach_of(&mut above));
        Some(Self { loudest, lines: [below, above], around })
    }

    /// What it is on each of its lines above the level around, by response, which the spectra then
    /// lack.
    fn taken_off(&self, spectra: &mut [Vec<C64>]) -> Vec<(usize, Vec<C64>)> {
        let mut own = |k: usize| {
            let of = |(spectrum, around): (&mut Vec<C64>, &f64)| {
                let Some(value) = spectrum.get_mut(k) else { return C64::default() };
                let share = (around / value.norm_sqr().max(f64::MIN_POSITIVE)).sqrt().min(1.0);
                let removed = *value * (1.0 - share);
                *value -= removed;
                removed
            };
            (k, spectra.iter_mut().zip(&self.around).map(of).collect())
        };
        (self.lines[0]..=self.lines[1]).map(&mut own).collect()
    }
}

/// Mean power of a line relative to those around.
fn relative(spectra: &[Vec<C64>], around: &[f64], line: usize) -> f64 {
    let of = |(spectrum, around): (&Vec<C64>, &f64)| {
        let power = spectrum.get(line).map_or(0.0, C64::norm_sqr);
        power / around.max(f64::MIN_POSITIVE)
    };
    spectra.iter().zip(around).map(of).sum::<f64>() / spectra.len().max(1) as f64
}
