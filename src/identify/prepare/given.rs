//! Frequency responses that the measuring instrument made.

use super::lines::MAX_LINES;
use super::{Prepared, RecordKind, Response};
use crate::identify::estimate::hann::is_windowed;
use crate::identify::estimate::{Block, C64, OF_SENSORS, Origin};
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
    let turned = turned(functions, notes);
    let functions = turned.as_deref().unwrap_or(functions);
    let blank = blank_lines(functions, notes);
    // One block, so that every response has its place in it.
    let (mut block, mut responses, mut kept) = (None::<Block>, Vec::new(), Vec::new());
    let mut is_cut_out = band_hz.is_some();
    for function in functions {
        let within: Vec<usize> = (0..function.frequencies_hz.len())
            .filter(|&k| {
                let f = function.frequencies_hz[k];
                f > 0.0 && f >= low && f <= high && !blank.contains(&k)
            })
            .collect();
        let left_out = within.get(MAX_LINES).map(|&k| function.frequencies_hz[k]);
        is_cut_out |= left_out.is_some();
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
        block.origin = Origin::Responses { hann_s: Some(length_s) };
    }
    block.is_cut_out = is_cut_out;
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

/// Responses with the other sign of phase as their conjugates, with a warning: what a force
/// causes comes after it, so that the phase falls where the response is loud.
fn turned(functions: &[Frf], notes: &mut Notes) -> Option<Vec<Frf>> {
    /// Mean turn of the phase from line to line, weighted with the power; noise makes less.
    const RISES: f64 = 0.02;
    let (mut turn, mut power) = (0.0, 0.0);
    for function in functions {
        let own: f64 = function.values.iter().map(C64::norm_sqr).sum();
        let pairs = function.values.windows(2).map(|pair| (pair[0].conj() * pair[1]).im);
        // Responses count alike, whatever their units.
        turn += pairs.sum::<f64>() / own.max(f64::MIN_POSITIVE);
        power += 1.0;
    }
    if turn <= RISES * power {
        return None;
    }
    let what = "the phase rises where the responses are loud, as if they came before the force: \
                real and imaginary part follow the other convention (e^-iωt); they are read as \
                conjugates; export them with the phase falling through a resonance";
    notes.warning(Code::Disagreement, None, what);
    let conjugated = |function: &Frf| Frf {
        values: function.values.iter().map(C64::conj).collect(),
        ..function.clone()
    };
    Some(functions.iter().map(conjugated).collect())
}

/// Lines on which all functions are exactly zero, as analysers blank those of the mains; they are
/// left out, with a warning.
fn blank_lines(functions: &[Frf], notes: &mut Notes) -> Vec<usize> {
    let moves = |function: &&Frf| function.values.iter().any(|value| value.norm() > 0.0);
    let moving: Vec<&Frf> = functions.iter().filter(moves).collect();
    let Some(first) = moving.first() else { return Vec::new() };
    let is_blank = |k: &usize| {
        moving.iter().all(|own| own.values.get(*k).is_some_and(|value| value.norm() == 0.0))
    };
    let blank: Vec<usize> = (0..first.values.len()).filter(is_blank).collect();
    let hz: Vec<String> = blank
        .iter()
        .map(|&k| first.frequencies_hz[k])
        .filter(|hz| *hz > 0.0)
        .map(|hz| format!("{hz:.2}"))
        .collect();
    if !hz.is_empty() {
        let shown = hz.iter().take(6).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = if hz.len() > 6 { format!(" and {} more", hz.len() - 6) } else { String::new() };
        let what =
            format!("all responses are exactly zero at {shown}{more} Hz: these lines are left out");
        notes.warning(Code::Remark, None, what);
    }
    blank
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
