//! The limit by the growth of a small motion over one period.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::arnoldi::{Dominant, Wanted, dominant};
use super::chart::Chart;
use super::cut::Cut;
use super::limit::{DEEPEST_M, Kind, Limit};
use super::milling::{Milling, Process};
use super::mode::ToolMode;
use super::period::{Elements, Period};
use crate::units::hz_from_rad_per_s;

/// The search starts at this share of the smallest limit of the zeroth order: beyond, flips of
/// short cuts have their limits, too.
const FROM: f64 = 0.2;

/// And at no more than this share of so many times the depth at which nothing grows whatever the
/// cut does: the smallest limit of the zeroth order is 2 to 20 times that depth, mostly.
const FAR: f64 = 20.0;

/// Steps of the search, below and above the smallest limit of the zeroth order.
const COARSE: f64 = 1.25;
const FINE: f64 = 1.1;

/// The depth of the limit is found to this share of it.
const DIGITS: f64 = 1e-10;

/// A motion that shrinks to this share in a period is stable, also where the multiplier is not
/// known to its last digits.
const SMALL: f64 = 0.9;

/// At the limit the modulus is 1 within this: else the side of 1 was not what it seemed.
const AT_LIMIT: f64 = 1e-6;

/// A multiplier this near to the negative real axis is a flip, rad.
const FLIP_RAD: f64 = 1e-5;

/// Modes and a process, with what the depths share.
#[allow(missing_debug_implementations, reason = "a process need not have one")]
pub struct Exact<'a> {
    modes: Vec<ToolMode>,
    process: &'a dyn Process,
    elements: Elements,
}

impl<'a> Exact<'a> {
    /// Modes that do not move the tip are left out.
    pub fn new(modes: &[ToolMode], process: &'a dyn Process) -> Self {
        let modes = modes.iter().filter(|mode| mode.motion.norm() > 0.0).copied().collect();
        Self { modes, process, elements: Elements::new() }
    }

    fn dominant(&mut self, depth_m: f64, wanted: Wanted) -> Option<Dominant> {
        let period = Period::new(&self.modes, self.process, depth_m, &mut self.elements)?;
        dominant(period.size(), |from, to| period.map(from, to), wanted)
    }

    /// The multiplier of largest modulus over one period of the process; `None` where it is not
    /// found.
    pub fn multiplier(&mut self, depth_m: f64) -> Option<Complex<f64>> {
        self.dominant(depth_m, Wanted::Value).filter(|found| found.is_sure).map(|found| found.value)
    }

    /// How far the largest modulus is above 1, about; its sign by two looks that agree.
    ///
    /// # Errors
    /// The depth, where the multiplier is not found.
    fn growth(&mut self, depth_m: f64) -> Result<f64, f64> {
        let found = self.dominant(depth_m, Wanted::Side).ok_or(depth_m)?;
        let radius = found.value.norm();
        // Far below the limit all multipliers are small and much alike.
        if found.is_sure || radius < SMALL { Ok(radius - 1.0) } else { Err(depth_m) }
    }

    /// The smallest depth from `from_m` on at which the motion grows; `near_m` is the least that is
    /// expected. `Ok(None)` where there is none below 1 m, an error where it is not found.
    ///
    /// # Errors
    /// The depth at which the multiplier is not found.
    fn limit(&mut self, from_m: f64, near_m: f64) -> Result<Option<Limit>, f64> {
        let mut low = from_m.min(DEEPEST_M);
        let mut off_low = self.growth(low)?;
        while off_low >= 0.0 {
            low *= 0.25;
            if low < 1e-12 {
                return Err(low);
            }
            off_low = self.growth(low)?;
        }
        let (mut high, mut off_high) = (low, off_low);
        while off_high < 0.0 {
            if high >= DEEPEST_M {
                return Ok(None);
            }
            (low, off_low) = (high, off_high);
            high = (high * if high < 0.8 * near_m { COARSE } else { FINE }).min(DEEPEST_M);
            off_high = self.growth(high)?;
        }
        // The Illinois form of the rule of false position.
        let mut side = 0;
        while high - low > DIGITS * high {
            let secant = (off_low * high - off_high * low) / (off_low - off_high);
            let margin = 0.25 * DIGITS * high;
            let depth = secant.clamp(low + margin, high - margin);
            let off = self.growth(depth)?;
            if off < 0.0 {
                (low, off_low) = (depth, off);
                if side == -1 {
                    off_high *= 0.5;
                }
                side = -1;
            } else {
                (high, off_high) = (depth, off);
                if side == 1 {
                    off_low *= 0.5;
                }
                side = 1;
            }
            if off == 0.0 {
                break;
            }
        }
        let found =
            self.dominant(high, Wanted::Vector).filter(|found| found.is_sure).ok_or(high)?;
        if (found.value.norm() - 1.0).abs() > AT_LIMIT {
            return Err(high);
        }
        Ok(Some(self.told(high, &found)))
    }

    /// A limit with its kind, and the frequency of the mode that moves most in it.
    fn told(&self, depth_m: f64, found: &Dominant) -> Limit {
        let turned = found.value.arg();
        let is_flip = turned.abs() > PI - FLIP_RAD;
        let kind = if is_flip { Kind::Flip } else { Kind::Hopf };
        let parts = |r: usize| (found.vector[2 * r], found.vector[2 * r + 1]);
        let size = |r: usize| parts(r).0.norm() + parts(r).1.norm();
        let strongest =
            (0..self.modes.len()).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(0);
        let omega = self.modes.get(strongest).map_or(0.0, |mode| mode.omega_rad_per_s);
        // The motion is known up to whole turns a period, and in the direction in which the
        // vector turns: q̇/ω leads q by a quarter.
        let (place, rate) = parts(strongest);
        let leads = (rate - place * Complex::i()).norm() < (rate + place * Complex::i()).norm();
        let turned = if leads { turned } else { -turned };
        let period = self.process.period_s();
        let whole = ((omega * period - turned) / TAU).round();
        let frequency_hz = hz_from_rad_per_s((turned + TAU * whole).abs() / period);
        Limit { depth_m, frequency_hz, kind }
    }
}

/// The limit of a cut at a spindle speed; `Ok(None)` where there is none below 1 m.
///
/// # Errors
/// The depth at which the iteration for the multiplier does not converge.
pub fn milling_limit(
    modes: &[ToolMode],
    cut: &Cut,
    chart: &Chart,
    rpm: f64,
) -> Result<Option<Limit>, f64> {
    let milling = Milling::new(cut, rpm);
    let mut exact = Exact::new(&cut.in_axes(modes), &milling);
    if exact.modes.is_empty() {
        return Ok(None);
    }
    // Where the mean of the cut lets nothing grow, or hardly, its change over the turn still may.
    let lowest = chart.lowest_m().unwrap_or(DEEPEST_M).min(DEEPEST_M);
    let from = lowest.min(FAR * cut.surely_stable_m(&exact.modes));
    exact.limit(FROM * from, lowest)
}

/// The spectral radius over one mean tooth period; `None` where it is not found.
pub fn milling_radius(modes: &[ToolMode], cut: &Cut, rpm: f64, depth_m: f64) -> Option<f64> {
    let milling = Milling::new(cut, rpm);
    let radius = Exact::new(&cut.in_axes(modes), &milling).multiplier(depth_m)?.norm();
    Some(radius.powf((milling.teeth_per_period() as f64).recip()))
}

/// Whether a small motion grows at a depth; `None` where that is not found.
pub fn milling_grows(modes: &[ToolMode], cut: &Cut, rpm: f64, depth_m: f64) -> Option<bool> {
    let milling = Milling::new(cut, rpm);
    let found = Exact::new(&cut.in_axes(modes), &milling).dominant(depth_m, Wanted::Side);
    found.filter(|found| found.is_sure).map(|found| found.value.norm() > 1.0)
}
