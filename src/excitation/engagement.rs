//! Teeth in the work, and the harmonics of the force on them.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use crate::job::{Cutting, CuttingDirection, Tool};

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
    /// diameter is wanted and missing, or the tool drills.
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
            CuttingDirection::Drill(_) => return None,
        })
    }

    /// The mean thickness of the chip, m.
    pub fn mean_chip_m(&self, feed_per_tooth_m: f64) -> f64 {
        let Self { entry_rad, exit_rad } = self;
        feed_per_tooth_m * (entry_rad.cos() - exit_rad.cos()) / (exit_rad - entry_rad)
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

/// The teeth of a cutter, each ahead of the one before it.
pub(super) fn teeth(tool: &Tool) -> Vec<Tooth> {
    let z = f64::from(tool.teeth);
    let even = vec![TAU / z; tool.teeth as usize];
    let pitch = tool.pitch_rad.as_ref().unwrap_or(&even);
    let mut angle_rad = 0.0;
    pitch
        .iter()
        .map(|next| {
            let here = angle_rad;
            angle_rad += next;
            // It cuts what the tooth ahead of it has left: the farther ahead, the thicker.
            let share = next * z / TAU;
            Tooth { angle_rad: here, share }
        })
        .collect()
}
