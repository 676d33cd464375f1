//! Where the fit of a record starts, and how many orders of the least squares support a mode.

use super::estimate::lscf::{
    PolesByOrder, StabilisationPoint, candidates, poles_by_order, stabilisation,
};
use super::estimate::peaks::{divisions, peaks};
use super::estimate::{Block, C64, Pole};
use super::prepare::{Prepared, SpectraOnLines};
use crate::units::rad_per_s_from_hz;

/// A stretch of frequencies with a stabilisation diagram of its own.
pub(super) struct Stretch {
    /// rad/s, the end not included.
    pub(super) own: [f64; 2],
    /// How many orders were tried.
    pub(super) orders: usize,
}

/// The poles that the linear least squares of rising order agree on, and peaks beside them. Where
/// there are many peaks, a few at a time.
pub(super) fn starts(
    prepared: &Prepared,
    highest: usize,
    points: &mut Vec<StabilisationPoint>,
) -> (Vec<Stretch>, Vec<Pole>) {
    /// From so many peaks on, stretches of so many; each with so many lines.
    const MANY: usize = 8;
    const PEAKS: usize = 4;
    const LINES: usize = 100;
    let widest = prepared.starts_from.iter().max_by_key(|(omega, _)| omega.len());
    let is_given = prepared.blocks.iter().any(Block::is_given);
    // Errors of an analyser make shallow peaks.
    let peaks = widest.map_or_else(Vec::new, |(omega, spectra)| peaks(omega, spectra, !is_given));
    let ends = match widest {
        Some((omega, _)) if peaks.len() >= MANY => divisions(&peaks, omega, PEAKS, LINES),
        _ => vec![0.0, f64::INFINITY],
    };
    let mut stretches = Vec::new();
    for pair in ends.windows(2) {
        stretches.push(diagram(prepared, [pair[0], pair[1]], highest, points));
    }
    let mut starts = candidates(points);
    let is_new = |peak: &Pole, starts: &[Pole]| {
        starts.iter().all(|start| {
            (start.omega() - peak.omega()).abs() > peak.lambda.re.abs() + start.lambda.re.abs()
        })
    };
    // Their widths are those of the window, at least.
    let peaks: Vec<Pole> = peaks.into_iter().filter(|peak| is_new(peak, &starts)).collect();
    if stretches.len() > 1 || is_given {
        starts.extend(peaks);
    }
    (stretches, starts)
}

/// The same of one stretch alone, without peaks.
pub(super) fn starts_within(
    prepared: &Prepared,
    own: [f64; 2],
    highest: usize,
    points: &mut Vec<StabilisationPoint>,
) -> (Stretch, Vec<Pole>) {
    let mut of_own = Vec::new();
    let stretch = diagram(prepared, own, highest, &mut of_own);
    let starts = candidates(&of_own);
    points.extend(of_own);
    (stretch, starts)
}

/// The stabilisation diagram of a stretch.
fn diagram(
    prepared: &Prepared,
    own: [f64; 2],
    highest: usize,
    points: &mut Vec<StabilisationPoint>,
) -> Stretch {
    let unwindowed = |pole: Pole| Pole { lambda: pole.lambda + prepared.window_decay, ..pole };
    let is_given = prepared.blocks.iter().any(Block::is_given);
    let sets = within(prepared, own);
    let sets: Vec<(&[f64], &[Vec<C64>])> =
        sets.iter().map(|(omega, spectra)| (&omega[..], &spectra[..])).collect();
    let by_order: PolesByOrder = poles_by_order(&sets, highest, is_given)
        .into_iter()
        .map(|(order, poles)| {
            let poles = poles.into_iter().map(unwindowed);
            let is_own =
                |pole: &Pole| pole.lambda.re < 0.0 && (own[0]..own[1]).contains(&pole.omega());
            (order, poles.filter(is_own).collect())
        })
        .collect();
    points.extend(stabilisation(&by_order));
    Stretch { own, orders: by_order.len() }
}

/// What the least squares start from, within a stretch and a little beyond.
fn within(prepared: &Prepared, [from, to]: [f64; 2]) -> Vec<SpectraOnLines> {
    const MARGIN: f64 = 0.1;
    let cut = |(omega, spectra): &SpectraOnLines| {
        let last = omega.last().copied().unwrap_or(0.0);
        let margin = MARGIN * (to.min(last) - from);
        let lines = omega.partition_point(|w| *w < from - margin)
            ..omega.partition_point(|w| *w < to + margin);
        let spectra = spectra.iter().map(|own| own[lines.clone()].to_vec()).collect();
        (omega[lines].to_vec(), spectra)
    };
    prepared.starts_from.iter().map(cut).collect()
}

/// Fraction of the orders that have a stable pole near the mode, of about its damping: beside a
/// light mode, the light mode's poles do not support a heavily damped one.
pub(super) fn support(
    (hz, ratio, ratio_std): (f64, f64, f64),
    points: &[StabilisationPoint],
    stretches: &[Stretch],
) -> f64 {
    /// Of frequencies, relative.
    const NEAR: f64 = 0.01;
    /// Of damping ratios, where their deviation is not larger: least squares are biased in noise.
    const FACTOR: f64 = 3.0;
    let omega = rad_per_s_from_hz(hz);
    let is_there = |stretch: &&Stretch| (stretch.own[0]..stretch.own[1]).contains(&omega);
    let orders = stretches.iter().find(is_there).map_or(0, |stretch| stretch.orders);
    let mut having: Vec<usize> = points
        .iter()
        .filter(|point| {
            let times = point.damping_ratio / ratio;
            let apart = (point.damping_ratio - ratio).abs();
            (point.frequency_hz / hz - 1.0).abs() < NEAR
                && ((FACTOR.recip()..FACTOR).contains(&times) || apart < 3.0 * ratio_std)
        })
        .map(|point| point.order)
        .collect();
    having.sort_unstable();
    having.dedup();
    (having.len() as f64 / orders.max(1) as f64).min(1.0)
}
