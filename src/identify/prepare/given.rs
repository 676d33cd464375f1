//! Frequency responses that the measuring instrument made.

use super::lines::MAX_LINES;
use super::{Prepared, RecordKind, Response};
use crate::identify::estimate::hann::is_windowed;
use crate::identify::estimate::{Block, C64, Origin};
use crate::identify::record::Frf;
use crate::identify::references::Pairs;
use crate::notes::{Code, Notes};
use crate::units::{percent_from_ratio, rad_per_s_from_hz};

pub(super) fn given(
    functions: &[Frf],
    band_hz: Option<[f64; 2]>,
    delay_s: f64,
    notes: &mut Notes,
) -> Option<Prepared> {
    let [low, high] = band_hz.unwrap_or([0.0, f64::INFINITY]);
    // One block, so that every response has its place in it.
    let (mut block, mut responses, mut kept) = (None::<Block>, Vec::new(), Vec::new());
    for function in functions {
        let within: Vec<usize> = (0..function.frequencies_hz.len())
            .filter(|&k| {
                let f = function.frequencies_hz[k];
                f > 0.0 && f >= low && f <= high
            })
            .collect();
        let left_out = within.get(MAX_LINES).map(|&k| function.frequencies_hz[k]);
        let within = &within[..within.len().min(MAX_LINES)];
        if let Some(from_hz) = left_out.filter(|_| block.is_none()) {
            let what = format!(
                "has more than {MAX_LINES} lines; those from {from_hz:.1} Hz on are left out; set \
                 band_hz to choose the band"
            );
            notes.warning(Code::Remark, None, what);
        }
        let in_time = |&k: &usize| {
            let turn = rad_per_s_from_hz(function.frequencies_hz[k]) * delay_s;
            function.values[k] * C64::from_polar(1.0, turn)
        };
        let values: Vec<C64> = within.iter().map(in_time).collect();
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
        kept.push((function.name.as_str(), function.reference.as_str()));
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
    block.is_cut_out = band_hz.is_some();
    block.drive_error = given_error(&block.spectra);
    let pairs = Pairs::of(kept.iter().copied());
    if let Some(pairs) = &pairs {
        for (response, (_, reference)) in responses.iter_mut().zip(&kept) {
            response.name = format!("{}/{reference}", response.name);
        }
        warn_of_irreciprocal(pairs, &responses, &block.spectra, notes);
    }
    let prepared = Prepared::of(RecordKind::GivenResponses, responses, vec![block]);
    Some(Prepared { pairs, ..prepared })
}

/// Warns of responses that exchanging hammer and sensor should not change, and does.
fn warn_of_irreciprocal(
    pairs: &Pairs,
    responses: &[Response],
    spectra: &[Vec<C64>],
    notes: &mut Notes,
) {
    /// Root mean square of the difference relative to that of both.
    const MOST: f64 = 0.15;
    for (a, b, sign) in pairs.reciprocal() {
        if responses[a].quantity != responses[b].quantity {
            continue;
        }
        let both = || spectra[a].iter().zip(&spectra[b]);
        let apart: f64 = both().map(|(a, b)| (a - b * sign).norm_sqr()).sum();
        let size: f64 = both().map(|(a, b)| 0.5 * (a.norm_sqr() + b.norm_sqr())).sum();
        let share = (apart / size.max(f64::MIN_POSITIVE)).sqrt();
        if share > MOST {
            let what = format!(
                "differs by {:.0} % from {}, which must be equal (reciprocity): check directions, \
                 sensitivities and where the hammer hit",
                percent_from_ratio(share),
                responses[b].name
            );
            notes.channel_warning(Code::Disagreement, &responses[a].name, what);
        }
    }
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
