//! Slow motion that the hits do not cause, as of a floor or stand that sways, or of offsets that
//! drift: a fit of modes makes a row of poles of it, none of them certain, which bend the modes
//! above them. Where that is so, the spectra are fitted from above it on.

use super::estimate::lscf::StabilisationPoint;
use super::estimate::{Estimate, PoleEstimate};
use super::prepare::{Prepared, RecordKind};
use crate::notes::{Code, Notes};
use crate::units::hz_from_rad_per_s;

/// Uncertain poles from which on they are no modes.
const MIN_POLES: usize = 3;

/// Weaker ones bend nothing.
const MIN_PROMINENCE: f64 = 1e-3;

/// Of the lowest certain pole's frequency, what such motion stays below.
const MOST: f64 = 0.75;

/// Where the band above slow motion begins, Hz; `None` where there is none.
pub(super) fn end(
    prepared: &Prepared,
    found: &Estimate,
    points: &[StabilisationPoint],
) -> Option<f64> {
    if !matches!(prepared.kind, RecordKind::Hammer | RecordKind::FreeDecay) {
        return None;
    }
    let hz = |pole: &PoleEstimate| hz_from_rad_per_s(pole.pole.omega());
    let lowest = found.poles.iter().filter(|pole| is_certain(pole, points)).map(hz).next()?;
    let below = found.poles.iter().take_while(|pole| hz(pole) < MOST * lowest);
    let slow: Vec<f64> = below.filter(|pole| pole.prominence >= MIN_PROMINENCE).map(hz).collect();
    let highest = slow.iter().copied().reduce(f64::max).filter(|_| slow.len() >= MIN_POLES)?;
    Some((highest * lowest).sqrt().min(MOST * lowest))
}

/// Whether a fit from above such motion on has no certain pole less, and fewer that are not.
pub(super) fn is_better(
    (cut, cut_points): (&Estimate, &[StabilisationPoint]),
    (all, all_points): (&Estimate, &[StabilisationPoint]),
) -> bool {
    let count = |found: &Estimate, points: &[StabilisationPoint]| {
        let certain = found.poles.iter().filter(|pole| is_certain(pole, points)).count();
        (certain, found.poles.len() - certain)
    };
    let (certain, others) = count(cut, cut_points);
    let (before, others_before) = count(all, all_points);
    certain >= before && others < others_before
}

/// Whether a pole is a mode beyond doubt.
fn is_certain(pole: &PoleEstimate, points: &[StabilisationPoint]) -> bool {
    /// Standard deviations of the damping ratio that it is from none; most of it; and that of the
    /// frequency, relative.
    const DECAYS: f64 = 3.0;
    const MAX_RATIO: f64 = 0.3;
    const MAX_STD: f64 = 3e-3;
    /// Of the frequency, to a pole of the stabilisation diagram.
    const NEAR: f64 = 0.01;
    /// Relative deviations of damping and frequency that the fit alone is believed with.
    const KNOWN: [f64; 2] = [0.1, 5e-4];
    /// And the least of its loudest line, relative to the spectrum's.
    const LOUD: f64 = 0.02;
    let (omega, ratio) = (pole.pole.omega(), pole.pole.ratio());
    let hz = hz_from_rad_per_s(omega);
    let is_known = pole.prominence > LOUD
        && pole.ratio_std < KNOWN[0] * ratio
        && pole.omega_std < KNOWN[1] * omega;
    let has_support = || points.iter().any(|point| (point.frequency_hz / hz - 1.0).abs() < NEAR);
    pole.pole.is_driven
        && ratio > DECAYS * pole.ratio_std
        && ratio < MAX_RATIO
        && pole.omega_std < MAX_STD * omega
        && (is_known || has_support())
}

pub(super) fn warn(low_hz: f64, notes: &mut Notes) {
    let what = format!(
        "what the responses do below {low_hz:.2} Hz does not follow the hits and does not decay, \
         as of a floor or stand that sways, or a drifting offset: the spectra were fitted from \
         there on; if a mode may lie below, stop that motion and record again, or set band_hz"
    );
    notes.warning(Code::Remark, None, what);
}
