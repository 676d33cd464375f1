//! From states along the path to crossings with ends and a closest point.

use super::bands::LineBands;
use super::certainty::Certainty;
use super::verdict::{Crossing, Move};
use crate::notes::Note;
use crate::path::{Path, Survey, Surveyor};

/// The closest point of a crossing is found to within this share of the path, and of where it is
/// sought: a band that is passed fast is narrow.
const CLOSEST_TOLERANCE: f64 = 1e-9;
const CLOSEST_SHARE: f64 = 1e-4;

/// A stretch of stations in one state.
struct Run {
    certainty: Certainty,
    /// Indices of the first and last station.
    first: usize,
    last: usize,
    from_s: f64,
    to_s: f64,
}

/// All crossings of a line with the modes of a refined survey.
///
/// # Errors
/// The arm has no modes somewhere near a closest point.
pub(super) fn find(
    bands: &LineBands,
    path: &Path,
    survey: &Survey,
    surveyor: &mut Surveyor,
) -> Result<Vec<Crossing>, Note> {
    let mut crossings = Vec::new();
    for r in 0..path.robot().coordinates().len() {
        for run in runs(bands, survey, r) {
            crossings.push(crossing(bands, path, survey, surveyor, r, &run)?);
        }
    }
    Ok(crossings)
}

/// Maximal stretches of one certainty. An end lies halfway between the two stations that disagree,
/// or where the spindle stops or starts.
fn runs(bands: &LineBands, survey: &Survey, r: usize) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut open: Option<Run> = None;
    let mut before_s = 0.0;
    for (i, station) in survey.stations().enumerate() {
        let state = bands.state(&station, r);
        if open.as_ref().map(|run| run.certainty) != state {
            let edge = if i == 0 { station.s } else { bands.edge(before_s, station.s) };
            if let Some(run) = open.take() {
                runs.push(Run { to_s: edge, ..run });
            }
            open = state.map(|certainty| Run {
                certainty,
                first: i,
                last: i,
                from_s: edge,
                to_s: station.s,
            });
        } else if let Some(run) = &mut open {
            run.last = i;
            run.to_s = station.s;
        }
        before_s = station.s;
    }
    runs.extend(open);
    runs
}

fn crossing(
    bands: &LineBands,
    path: &Path,
    survey: &Survey,
    surveyor: &mut Surveyor,
    r: usize,
    run: &Run,
) -> Result<Crossing, Note> {
    let closest_s = closest(bands, survey, surveyor, r, run)?;
    surveyor.modes(closest_s)?;
    let (modes, placement) = (surveyor.solver().modes(), surveyor.solver().placement());
    let natural_frequency_hz = modes.natural_frequencies_hz[r];
    let shares = surveyor.solver().strain_energy_shares(r);
    let mut order: Vec<usize> = (0..shares.len()).collect();
    order.sort_by(|&a, &b| shares[b].total_cmp(&shares[a]));
    let leading_turn_together = match order.as_slice() {
        [first, second, ..] => modes.turn_together(placement, r, *first, *second),
        [] | [_] => None,
    };
    let coordinates = path.robot().coordinates();
    let moves = |i: usize| Move { coordinate: coordinates[i].name.clone(), share: shares[i] };
    let excitation_hz = bands.excitation_hz(closest_s);
    let (from_line, to_line) = path.lines_between(run.from_s, run.to_s);
    Ok(Crossing {
        mode: r + 1,
        certainty: run.certainty,
        line: bands.line,
        excitation_hz,
        natural_frequency_hz,
        from_s: run.from_s,
        to_s: run.to_s,
        closest_s,
        natural_frequency_ci95_hz: bands.rules.interval_hz(closest_s, r, natural_frequency_hz),
        probability: None,
        driver: None,
        accepted: None,
        separation: (excitation_hz - natural_frequency_hz).abs() / natural_frequency_hz,
        tip_response_m_per_n: surveyor.tip_response_m_per_n()[r],
        moves: order.into_iter().map(moves).collect(),
        leading_turn_together,
        file: bands.file.to_owned(),
        from_line,
        to_line,
    })
}

/// Where line and mode are closest within a run: where they meet, if they do.
fn closest(
    bands: &LineBands,
    survey: &Survey,
    surveyor: &mut Surveyor,
    r: usize,
    run: &Run,
) -> Result<f64, Note> {
    let offset = |i: usize| {
        let station = survey.station(i);
        bands.excitation_hz(station.s) / station.frequencies_hz[r] - 1.0
    };
    let meeting = (run.first..run.last).find(|&i| {
        offset(i) == 0.0 || offset(i).is_sign_positive() != offset(i + 1).is_sign_positive()
    });
    if let Some(i) = meeting {
        let (a, b) = (survey.station(i).s, survey.station(i + 1).s);
        if offset(i) == 0.0 {
            return Ok(a);
        }
        return meet(bands, surveyor, r, (a, offset(i)), (b, offset(i + 1)));
    }
    let least = (run.first..=run.last)
        .min_by(|&a, &b| offset(a).abs().total_cmp(&offset(b).abs()))
        .unwrap_or(run.first);
    // Between two certain stretches both ends lie on the band's edge: the last digits must not
    // choose.
    let starts_closest = offset(run.first).abs() <= offset(least).abs() * (1.0 + 1e-6);
    let nearest = if starts_closest { run.first } else { least };
    // Not beyond the run's own stations: there the crossing is of another certainty.
    let left = survey.station(nearest.saturating_sub(1).max(run.first)).s;
    let right = survey.station((nearest + 1).min(run.last)).s;
    narrow(bands, surveyor, r, left, survey.station(nearest).s, right)
}

/// Bisection for line = mode between two points of opposite sign.
fn meet(
    bands: &LineBands,
    surveyor: &mut Surveyor,
    r: usize,
    mut left: (f64, f64),
    mut right: (f64, f64),
) -> Result<f64, Note> {
    let tolerance = CLOSEST_TOLERANCE.min(CLOSEST_SHARE * (right.0 - left.0));
    while right.0 - left.0 > tolerance.max(f64::EPSILON * right.0) {
        let s = 0.5 * (left.0 + right.0);
        let offset = bands.excitation_hz(s) / surveyor.frequencies_hz(s)?[r] - 1.0;
        if offset.is_sign_positive() == left.1.is_sign_positive() {
            left = (s, offset);
        } else {
            right = (s, offset);
        }
    }
    Ok(if left.1.abs() <= right.1.abs() { left.0 } else { right.0 })
}

/// Golden-section search for the least distance about the best station.
fn narrow(
    bands: &LineBands,
    surveyor: &mut Surveyor,
    r: usize,
    mut left: f64,
    best: f64,
    mut right: f64,
) -> Result<f64, Note> {
    const GOLDEN: f64 = 0.381_966_011_250_105_1;
    let mut distance = |s: f64| -> Result<f64, Note> {
        Ok((bands.excitation_hz(s) / surveyor.frequencies_hz(s)?[r] - 1.0).abs())
    };
    let (mut best, mut least) = (best, distance(best)?);
    let tolerance = CLOSEST_TOLERANCE.min(CLOSEST_SHARE * (right - left));
    while right - left > tolerance.max(f64::EPSILON * right) {
        let s = if best - left > right - best {
            best - GOLDEN * (best - left)
        } else {
            best + GOLDEN * (right - best)
        };
        let found = distance(s)?;
        if found < least {
            if s < best {
                right = best;
            } else {
                left = best;
            }
            (best, least) = (s, found);
        } else if s < best {
            left = s;
        } else {
            right = s;
        }
    }
    Ok(best)
}
