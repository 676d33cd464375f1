//! How far the cutting force moves the tool tip along a path.
//!
//! At each point the modes, taken as those of an arm at rest there, answer each harmonic of the
//! force:
//!
//! ```text
//! u_k = Σ_r φt_r (φt_rᵀ F_k) / (ω_r² − ω_k² + 2 i ζ_r ω_r ω_k),   ω_k = k Ω
//! ```
//!
//! with φt_r = J φ_r. The amplitude of several harmonics is √(Σ_k |u_k|²), which is √2 times the
//! root mean square of the vibration. The static deflection is left out, and so is regeneration:
//! this is forced vibration, no statement on chatter.

use std::cell::RefCell;

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Serialize;

use super::speeds::{SafeSet, Speeds};
use crate::excitation::{ForceHarmonic, ForceModel};
use crate::job::{Operation, Tool};
use crate::notes::Note;
use crate::path::Path;
use crate::process::{NoForce, TipMode, TipPlace, force_of, orders_of, sure_ones, tip_places};
use crate::risk::SpindleProfile;
use crate::stability::{ToolMode, displacement_m};
use crate::units::{hz_from_rpm, rad_per_s_from_hz, written};

/// Points of the path that are looked at.
const POINTS: usize = 200;

/// Speeds that are tried over the spindle's range.
const TRIED: usize = 400;

/// The tool tip at one spindle speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Tip")]
pub struct TipVibration {
    /// Spindle speed.
    pub rpm: f64,
    /// The largest amplitude along the path.
    #[serde(rename = "amplitude_um", serialize_with = "written::um")]
    pub amplitude_m: f64,
    /// Where it is largest.
    pub s: f64,
}

/// What the arm's tip answers along a path.
#[derive(Debug, Clone)]
pub(super) struct TipModel {
    force: ForceModel,
    tool: Tool,
    /// Each with the place of its feed in `feed_ratios`.
    points: Vec<(usize, TipPlace)>,
    /// The feeds along the path over that of the operation, each once.
    feed_ratios: Vec<f64>,
    /// Forces that were worked out before, by the place of their feed.
    known: RefCell<Vec<Known>>,
}

/// The lowest harmonics of the force at one feed per tooth.
#[derive(Debug, Clone, Default)]
struct Known {
    feed_per_tooth_m: f64,
    harmonics: Vec<ForceHarmonic>,
}

/// How fast the tool goes through the work, with the spindle.
#[derive(Debug, Clone, Copy)]
pub(super) enum Chip {
    /// The feed per tooth stays this, m.
    PerTooth(f64),
    /// The feed stays this, m/s.
    Feed(f64),
}

impl TipModel {
    /// Looks at a path; `Ok(Err)` says why there is nothing to say.
    ///
    /// # Errors
    /// The arm has no modes somewhere.
    pub(super) fn new(operation: &Operation, path: &Path) -> Result<Result<Self, NoForce>, Note> {
        let force = match force_of(operation) {
            Ok(force) => force,
            Err(why) => return Ok(Err(why)),
        };
        if force.drilling().is_some_and(|force| force.orders().is_empty()) {
            return Ok(Err(NoForce::Steady));
        }
        let turning = SpindleProfile::new(&operation.speed, path);
        let s: Vec<f64> = (0..=POINTS).map(|i| i as f64 / POINTS as f64).collect();
        let points = sure_ones(tip_places(operation, path, &s, |s| !turning.is_stopped_at(s))?);
        if points.is_empty() {
            return Ok(Err(NoForce::OnlyAir));
        }
        let mut feed_ratios: Vec<f64> = Vec::new();
        let with_feed = |place: TipPlace| {
            let ratio = path.feed_m_per_s_at(place.s) / operation.feed_m_per_s;
            let known = feed_ratios.iter().position(|known| *known == ratio);
            let at = known.unwrap_or_else(|| {
                feed_ratios.push(ratio);
                feed_ratios.len() - 1
            });
            (at, place)
        };
        let points = points.into_iter().map(with_feed).collect();
        let known = RefCell::new(vec![Known::default(); feed_ratios.len()]);
        Ok(Ok(Self { force, tool: operation.tool.clone(), points, feed_ratios, known }))
    }

    /// The largest amplitude along the path at a constant speed.
    pub(super) fn at(&self, rpm: f64, chip: Chip) -> TipVibration {
        let forces: Vec<Vec<ForceHarmonic>> =
            (0..self.feed_ratios.len()).map(|feed| self.forces(rpm, chip, feed)).collect();
        let mut worst = TipVibration { rpm, amplitude_m: 0.0, s: 0.0 };
        for (feed, point) in &self.points {
            let amplitude_m = amplitude(&point.modes, &forces[*feed], rpm);
            if amplitude_m > worst.amplitude_m {
                worst = TipVibration { amplitude_m, s: point.s, ..worst };
            }
        }
        worst
    }

    /// The amplitude at the point of the path nearest to `s`, m.
    pub(super) fn amplitude_near(&self, s: f64, rpm: f64, chip: Chip) -> f64 {
        let apart = |(_, place): &(usize, TipPlace)| (place.s - s).abs();
        let nearest = self.points.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        nearest.map_or(0.0, |(feed, place)| {
            amplitude(&place.modes, &self.forces(rpm, chip, *feed), rpm)
        })
    }

    /// The best speed of each gap.
    pub(super) fn quietest(&self, set: &SafeSet, chip: Chip) -> Vec<TipVibration> {
        let range: f64 = set.safe.iter().map(|gap| gap.high_rpm - gap.low_rpm).sum();
        set.safe.iter().map(|gap| self.quietest_in(*gap, range, chip)).collect()
    }

    fn quietest_in(&self, gap: Speeds, range_rpm: f64, chip: Chip) -> TipVibration {
        let width = gap.high_rpm - gap.low_rpm;
        let share = if range_rpm > 0.0 { width / range_rpm } else { 1.0 };
        let tried = ((TRIED as f64 * share).ceil() as usize).max(12);
        let step = width / tried as f64;
        let speeds = (0..=tried).map(|i| gap.low_rpm + step * i as f64);
        let least = |a: TipVibration, b: TipVibration| {
            if b.amplitude_m < a.amplitude_m { b } else { a }
        };
        let first = self.at(gap.low_rpm, chip);
        let mut best = speeds.fold(first, |best, rpm| least(best, self.at(rpm, chip)));
        // Closer and closer about the best one.
        let mut reach = step;
        for _ in 0..40 {
            reach *= 0.7;
            for rpm in [best.rpm - reach, best.rpm + reach] {
                if gap.contains(rpm) {
                    best = least(best, self.at(rpm, chip));
                }
            }
        }
        best
    }

    /// At one of `feed_ratios`. What was worked out for other speeds at the same chip serves again.
    fn forces(&self, rpm: f64, chip: Chip, feed: usize) -> Vec<ForceHarmonic> {
        let feed_per_tooth_m = self.feed_ratios[feed]
            * match chip {
                Chip::PerTooth(feed_per_tooth_m) => feed_per_tooth_m,
                Chip::Feed(feed_m_per_s) => {
                    feed_m_per_s / (f64::from(self.tool.teeth) * hz_from_rpm(rpm))
                }
            };
        let orders = orders_of(&self.force, &self.tool, rpm);
        let known = &mut self.known.borrow_mut()[feed];
        if known.feed_per_tooth_m != feed_per_tooth_m {
            *known = Known { feed_per_tooth_m, harmonics: Vec::new() };
        }
        let more = orders.get(known.harmonics.len()..).unwrap_or_default();
        known.harmonics.extend(self.force.harmonics(more, feed_per_tooth_m));
        known.harmonics[..orders.len()].to_vec()
    }
}

/// √(Σ_k |u_k|²), m.
fn amplitude(modes: &[TipMode], forces: &[ForceHarmonic], rpm: f64) -> f64 {
    let turning = rad_per_s_from_hz(hz_from_rpm(rpm));
    let modes: Vec<ToolMode> = modes.iter().map(|one| one.mode).collect();
    let squared = |force: &ForceHarmonic| {
        let omega = f64::from(force.order) * turning;
        displacement_m(&modes, &Vector3::from(force.amplitude_n), omega).norm_squared()
    };
    forces.iter().map(squared).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{Cutting, CuttingDirection};
    use crate::process::Owner;
    use std::f64::consts::TAU;

    /// The modal equations under the cutting force itself, integrated by the classic Runge–Kutta
    /// method until they are steady: √2 times the root mean square about the mean.
    fn integrated(force: &ForceModel, modes: &[ToolMode], rpm: f64, chip_m: f64) -> f64 {
        let turning = rad_per_s_from_hz(hz_from_rpm(rpm));
        let per_turn = 4000;
        let h = TAU / turning / f64::from(per_turn);
        let slowest =
            modes.iter().map(|m| m.damping_ratio * m.omega_rad_per_s).fold(f64::INFINITY, f64::min);
        let settling = (12.0 / slowest / (TAU / turning)).ceil() as u32;
        let mut state: Vec<[f64; 2]> = vec![[0.0; 2]; modes.len()];
        let (mut sum, mut square, mut count) = ([0.0; 3], [0.0; 3], 0.0);
        for turn in 0..settling + 20 {
            for i in 0..per_turn {
                let angle = |part: f64| (f64::from(i) + part) / f64::from(per_turn) * TAU;
                let f = [0.0, 0.5, 1.0].map(|part| force.force_n(angle(part), chip_m));
                for (mode, y) in modes.iter().zip(&mut state) {
                    let w = mode.omega_rad_per_s;
                    let rate = |y: [f64; 2], f: [f64; 3]| {
                        let push = mode.motion.dot(&Vector3::from(f));
                        [y[1], push - 2.0 * mode.damping_ratio * w * y[1] - w * w * y[0]]
                    };
                    let step = |k: [f64; 2], by: f64| [y[0] + by * k[0], y[1] + by * k[1]];
                    let k1 = rate(*y, f[0]);
                    let k2 = rate(step(k1, 0.5 * h), f[1]);
                    let k3 = rate(step(k2, 0.5 * h), f[1]);
                    let k4 = rate(step(k3, h), f[2]);
                    for j in 0..2 {
                        y[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
                    }
                }
                if turn >= settling {
                    count += 1.0;
                    for axis in 0..3 {
                        let u: f64 =
                            modes.iter().zip(&state).map(|(m, y)| m.motion[axis] * y[0]).sum();
                        sum[axis] += u;
                        square[axis] += u * u;
                    }
                }
            }
        }
        let variance = |axis: usize| square[axis] / count - (sum[axis] / count).powi(2);
        (2.0 * (0..3).map(variance).sum::<f64>()).sqrt()
    }

    #[test]
    fn the_amplitude_agrees_with_time_integration() {
        let mode = |hz: f64, damping_ratio, motion: [f64; 3]| ToolMode {
            omega_rad_per_s: rad_per_s_from_hz(hz),
            damping_ratio,
            motion: Vector3::from(motion),
        };
        let modes = [
            mode(14.0, 0.03, [0.12, -0.05, 0.08]),
            mode(23.0, 0.05, [-0.07, 0.15, 0.02]),
            mode(61.0, 0.02, [0.2, 0.1, -0.1]),
        ];
        for (teeth, pitch, direction, rpm) in [
            (2, None, CuttingDirection::Climb, 500.0),
            (3, None, CuttingDirection::Slot, 433.0),
            (2, Some(vec![2.9, TAU - 2.9]), CuttingDirection::Conventional, 820.0),
            (1, None, CuttingDirection::Climb, 1370.0),
        ] {
            let tool = Tool { teeth, diameter_m: Some(0.012), pitch_rad: pitch, ..Tool::default() };
            let cutting = Cutting {
                radial_depth_m: 0.004,
                axial_depth_m: 0.002,
                direction,
                material: "al-7075".to_owned(),
                coefficients: None,
                regenerates: true,
                process_damping_n_per_m: 0.0,
            };
            let force = ForceModel::new(&tool, &cutting).unwrap();
            let harmonics = force.harmonics(&orders_of(&force, &tool, rpm), 5e-5);
            let seen = modes.map(|mode| TipMode { of: Owner::Tool, mode, turning: 0.0 });
            let found = amplitude(&seen, &harmonics, rpm);
            let expected = integrated(&force, &modes, rpm, 5e-5);
            let error = (found / expected - 1.0).abs();
            println!("{teeth} teeth at {rpm} rpm: {error:.1e} off");
            assert!(error < 0.01, "{teeth} {rpm}: {found} {expected}");
        }
    }
}
