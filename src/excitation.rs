//! The frequencies at which spindle and cutter shake the arm.

use std::f64::consts::TAU;

use crate::job::{Policy, Tool};
use crate::units::hz_from_rpm;

/// A line of a cutter with uneven pitch counts if the pitch lets through at least this share of what
/// evenly pitched teeth would put on the tooth-passing line.
const LEAST_PITCH_WEIGHT: f64 = 0.05;

/// Where an excitation line comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// Teeth entering the work: multiples of z·n/60.
    ToothPassing,
    /// The spindle's own turn: multiples of n/60, from runout, unbalance or uneven pitch.
    Spindle,
}

/// One excitation line: a fixed multiple of the spindle's frequency.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExcitationLine {
    /// Teeth or spindle.
    pub source: Source,
    /// Which multiple of the source's own frequency, counted from 1.
    pub harmonic: u32,
    /// The same as a multiple of n/60.
    pub order: u32,
}

impl ExcitationLine {
    /// Frequency at a spindle speed, Hz.
    pub fn frequency_hz(&self, rpm: f64) -> f64 {
        f64::from(self.order) * hz_from_rpm(rpm)
    }
}

/// The lines that a policy asks about, ascending in frequency. Where a spindle line coincides with a
/// tooth-passing line, it is listed once, as tooth passing.
///
/// Teeth with uneven pitch repeat only once a turn, so their force has lines at every multiple of n/60,
/// weighted by |Σ_j exp(i k θ_j)| / z with θ_j the teeth's angles. Up to the highest tooth-passing harmonic
/// asked for, those that weigh at least 5 % are listed as multiples of the spindle's frequency.
pub fn lines(tool: &Tool, policy: &Policy) -> Vec<ExcitationLine> {
    let z = tool.teeth;
    let top = z * policy.tooth_passing_harmonics;
    let mut lines: Vec<ExcitationLine> = (1..=policy.tooth_passing_harmonics)
        .map(|harmonic| ExcitationLine {
            source: Source::ToothPassing,
            harmonic,
            order: harmonic * z,
        })
        .collect();
    let uneven = |k: u32| {
        tool.pitch_rad
            .as_ref()
            .is_some_and(|pitch| k <= top && pitch_weight(pitch, k) >= LEAST_PITCH_WEIGHT)
    };
    lines.extend(
        (1..=policy.spindle_harmonics.max(top))
            .filter(|&k| k <= policy.spindle_harmonics || uneven(k))
            .filter(|&k| !(k % z == 0 && k <= top))
            .map(|k| ExcitationLine { source: Source::Spindle, harmonic: k, order: k }),
    );
    lines.sort_by_key(|line| line.order);
    lines
}

/// |Σ_j exp(i k θ_j)| / z: one at multiples of z and zero between for evenly pitched teeth.
fn pitch_weight(pitch_rad: &[f64], k: u32) -> f64 {
    let mut angle = 0.0;
    let (mut re, mut im) = (0.0, 0.0);
    for pitch in pitch_rad {
        let (sin, cos) = (f64::from(k) * angle % TAU).sin_cos();
        re += cos;
        im += sin;
        angle += pitch;
    }
    f64::hypot(re, im) / pitch_rad.len() as f64
}
