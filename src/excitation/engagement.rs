//! Teeth in the work, and the harmonics of the force on them.

use std::f64::consts::PI;

use nalgebra::Complex;

use crate::job::{Cutting, CuttingDirection};

/// Where a tooth is in the work, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Engagement {
    /// φ at which it enters.
    pub entry_rad: f64,
    /// φ at which it leaves.
    pub exit_rad: f64,
}

impl Engagement {
    /// From the radial depth and the side on which the chip is thick. `None` where the cutter's
    /// diameter is wanted and missing.
    pub fn new(cutting: &Cutting, diameter_m: Option<f64>) -> Option<Self> {
        let whole = Self { entry_rad: 0.0, exit_rad: PI };
        let arc = || {
            let share = (cutting.radial_depth_m / diameter_m?).min(1.0);
            Some((1.0 - 2.0 * share).acos())
        };
        Some(match cutting.direction {
            CuttingDirection::Slot => whole,
            CuttingDirection::Conventional => Self { exit_rad: arc()?, ..whole },
            CuttingDirection::Climb => Self { entry_rad: PI - arc()?, ..whole },
        })
    }
}

/// A harmonic of the cutting force: F(t) = Re (amplitude · exp(i k Ω t)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceHarmonic {
    /// k: multiple of the spindle's frequency.
    pub order: u32,
    /// Along the feed, across it and along the spindle out of the work, N.
    pub amplitude_n: [Complex<f64>; 3],
}

/// One tooth of a cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Tooth {
    /// θ_j, rad.
    pub(super) angle_rad: f64,
    /// Its share of the mean chip, as its distance from the tooth ahead has it.
    pub(super) share: f64,
}
