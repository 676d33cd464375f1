//! Thrust and torque of a drill (Altintas, Manufacturing Automation, 2nd ed., 2012, chapter 2).
//!
//! Each of z straight lips runs at half the point angle κ to the axis, from the hole that is there
//! before, of diameter d, to the diameter D:
//!
//! ```text
//! b = (D − d) / (2 sin κ),   h = c sin κ
//! thrust = Σ_j b (K_rc h_j + K_re) sin κ,   torque = Σ_j b (K_tc h_j + K_te) (D + d) / 4
//! ```
//!
//! with c the feed per lip. K_rc acts along the normal of the lip in the plane that holds the axis,
//! K_tc along the cut. The chisel edge is not in this model: without a hole before it, it carries
//! half of the thrust or more (50 to 60 %: J. P. Davim, ed., Modern Machining Technology, 2011, p.
//! 145), so what is computed then is a lower bound. Left out, too: the
//! force along a lip, and that the rake changes with the radius.
//!
//! All lips cut all the time, so thrust and torque are steady, also where lips are unlike: what
//! one takes more the others take less, and with K linear in h nothing of it is left in the sum.
//! What runout (each lip further out by ρ_j, ahead by ρ_j cos κ along its normal) or uneven pitch
//! leaves is a force to the side that turns with the drill, at the first order of the spindle:
//!
//! ```text
//! F_x = Σ_j −T_j cos φ_j − R_j sin φ_j,   F_y = Σ_j T_j sin φ_j − R_j cos φ_j,   φ_j = Ωt + θ_j
//! T_j = b (K_tc h_j + K_te),   R_j = b (K_rc h_j + K_re) cos κ
//! ```
//!
//! The wall of the hole, which holds the drill against it, is left out.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::chip::per_width;
use super::engagement::{ForceHarmonic, Tooth, teeth};
use crate::job::{CuttingCoefficients, Drill, MeasuredAt, Runout, Tool};
use crate::units::rad_from_deg;

/// The point angle of a drill of which nobody says it, as general-purpose drills have it, degrees.
const USUAL_POINT_DEG: f64 = 118.0;

/// A hole of this share of the diameter takes the chisel edge away: it is about as long as the web
/// is thick, and that is 0.1 to 0.2 of the diameter.
const MIN_PILOT_SHARE: f64 = 0.25;

/// The lips of a drill.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lips {
    /// κ: half of the point angle, rad.
    pub half_point_rad: f64,
    /// Whether that is a guess.
    pub is_point_assumed: bool,
    /// (D − d) / 2: what a lip takes across the axis, m.
    pub width_m: f64,
    /// (D + d) / 4: mean radius, m.
    pub mean_radius_m: f64,
    /// Whether the chisel edge cuts.
    pub has_chisel_edge: bool,
}

impl Lips {
    /// `None` where the diameter is missing.
    pub fn new(tool: &Tool, drill: Drill) -> Option<Self> {
        let (diameter_m, pilot_m) = (tool.diameter_m?, drill.pilot_diameter_m);
        let point_rad = tool.point_angle_rad.unwrap_or(rad_from_deg(USUAL_POINT_DEG));
        Some(Self {
            half_point_rad: 0.5 * point_rad,
            is_point_assumed: tool.point_angle_rad.is_none(),
            width_m: 0.5 * (diameter_m - pilot_m),
            mean_radius_m: 0.25 * (diameter_m + pilot_m),
            has_chisel_edge: pilot_m < MIN_PILOT_SHARE * diameter_m,
        })
    }

    /// Thickness of an even chip, m.
    pub fn chip_m(&self, feed_per_lip_m: f64) -> f64 {
        feed_per_lip_m * self.half_point_rad.sin()
    }

    /// What the thrust of a lip grows by with how far the tip moves along the axis, per width that
    /// the lip takes: K_rc sin κ, N/m².
    pub fn stiffness_n_per_m2(&self, coefficients: &CuttingCoefficients) -> f64 {
        coefficients.radial_n_per_m2 * self.half_point_rad.sin()
    }
}

/// The force of a drill.
#[derive(Debug, Clone, PartialEq)]
pub struct DrillingForce {
    lips: Lips,
    drill: Drill,
    coefficients: Option<CuttingCoefficients>,
    teeth: Vec<Tooth>,
    runout: Option<Runout>,
    is_unlike: bool,
}

impl DrillingForce {
    /// `None` where the diameter is missing, or there are neither coefficients nor a thrust, or the
    /// lips are unlike ([`is_unlike`]) and there are no coefficients.
    pub fn new(
        tool: &Tool,
        drill: Drill,
        coefficients: Option<CuttingCoefficients>,
    ) -> Option<Self> {
        let is_known = coefficients.is_some() || (drill.thrust_n.is_some() && !is_unlike(tool));
        is_known.then_some(Self {
            lips: Lips::new(tool, drill)?,
            drill,
            coefficients,
            teeth: teeth(tool),
            runout: tool.runout,
            is_unlike: is_unlike(tool),
        })
    }

    /// Its lips.
    pub fn lips(&self) -> &Lips {
        &self.lips
    }

    /// Whether the thrust is one that somebody measured.
    pub fn is_thrust_stated(&self) -> bool {
        self.drill.thrust_n.is_some()
    }

    /// Whether the torque is.
    pub fn is_torque_stated(&self) -> bool {
        self.drill.torque_nm.is_some()
    }

    /// By how much a thrust and a torque that were measured may be larger at a feed: they grow no
    /// faster than the chip.
    pub fn thrust_and_torque_up_to(&self, feed_per_lip_m: f64) -> [f64; 2] {
        let m_per_rev = feed_per_lip_m * self.teeth.len() as f64;
        let measured = self.drill.measured_at.map(MeasuredAt::m_per_rev);
        let more = measured.map_or(f64::INFINITY, |measured| (m_per_rev / measured).max(1.0));
        [self.is_thrust_stated(), self.is_torque_stated()]
            .map(|is_stated| if is_stated { more } else { 1.0 })
    }

    /// Whether the thrust leaves out a chisel edge that cuts.
    pub fn is_lower_bound(&self) -> bool {
        self.lips.has_chisel_edge && !self.is_thrust_stated()
    }

    /// Whether a point angle that nobody gave makes a difference: with coefficients it does.
    pub fn rests_on_assumed_point(&self) -> bool {
        self.lips.is_point_assumed && self.coefficients.is_some()
    }

    /// Thrust, out of the work, N.
    pub fn thrust_n(&self, feed_per_lip_m: f64) -> f64 {
        let of_lips = || {
            let sum: f64 = self.of_lips(feed_per_lip_m).iter().map(|[_, normal]| normal).sum();
            sum * self.lips.half_point_rad.sin()
        };
        self.drill.thrust_n.unwrap_or_else(of_lips)
    }

    /// Torque, N m; `None` where nobody says it and there are no coefficients.
    pub fn torque_nm(&self, feed_per_lip_m: f64) -> Option<f64> {
        let of_lips = || {
            let sum: f64 = self.of_lips(feed_per_lip_m).iter().map(|[cut, _]| cut).sum();
            sum * self.lips.mean_radius_m
        };
        self.drill.torque_nm.or_else(|| self.coefficients.map(|_| of_lips()))
    }

    /// The orders of the spindle at which there is a force: the first where lips are unlike.
    pub fn orders(&self) -> Vec<u32> {
        self.is_unlike.then_some(1).into_iter().collect()
    }

    pub(super) fn harmonics(&self, orders: &[u32], feed_per_lip_m: f64) -> Vec<ForceHarmonic> {
        let of = |&order: &u32| ForceHarmonic {
            order,
            amplitude_n: match order {
                0 => [0.0, 0.0, 2.0 * self.thrust_n(feed_per_lip_m)].map(Complex::from),
                1 => self.sideways_n(feed_per_lip_m),
                _ => Default::default(),
            },
        };
        orders.iter().map(of).collect()
    }

    /// What turns with the drill.
    fn sideways_n(&self, feed_per_lip_m: f64) -> [Complex<f64>; 3] {
        let cos = self.lips.half_point_rad.cos();
        let mut sum = [Complex::from(0.0); 3];
        for (tooth, [cut, normal]) in self.teeth.iter().zip(self.of_lips(feed_per_lip_m)) {
            let turn = Complex::cis(tooth.angle_rad);
            sum[0] += turn * Complex::new(-cut, normal * cos);
            sum[1] += turn * Complex::new(-normal * cos, -cut);
        }
        sum
    }

    /// Of each lip the force along the cut and along its normal, N; none without coefficients.
    fn of_lips(&self, feed_per_lip_m: f64) -> Vec<[f64; 2]> {
        let Some(k) = &self.coefficients else { return Vec::new() };
        let (sin, cos) = self.lips.half_point_rad.sin_cos();
        let ahead = |j: usize| {
            let of = |Runout { offset_m, angle_rad }| {
                offset_m * (self.teeth[j].angle_rad - angle_rad).cos()
            };
            self.runout.map_or(0.0, of) * cos
        };
        let z = self.teeth.len();
        let chip = |j: usize| {
            // A lip cuts what the lowest of those before it has left.
            let mut feed_m = 0.0;
            let left = (1..=z).map(|k| {
                feed_m += self.teeth[(j + k - 1) % z].share * feed_per_lip_m;
                feed_m * sin + ahead(j) - ahead((j + k) % z)
            });
            left.fold(f64::INFINITY, f64::min)
        };
        let force = |chip_m: f64| match chip_m > 0.0 {
            true => {
                let [cut, normal, _] = per_width(k, chip_m);
                [cut, normal].map(|n_per_m| n_per_m * self.lips.width_m / sin)
            }
            false => [0.0; 2],
        };
        (0..z).map(chip).map(force).collect()
    }
}

/// Whether the forces of the lips to the side leave something: one lip, unequal angles, or an axis
/// that is not the spindle's.
pub fn is_unlike(tool: &Tool) -> bool {
    let even = TAU / f64::from(tool.teeth);
    let mut pitch = tool.pitch_rad.iter().flatten();
    tool.teeth == 1 || tool.runout.is_some() || pitch.any(|own| (own - even).abs() > 1e-9)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const K: CuttingCoefficients = CuttingCoefficients {
        tangential_n_per_m2: 800e6,
        radial_n_per_m2: 300e6,
        tangential_edge_n_per_m: 20e3,
        radial_edge_n_per_m: 25e3,
        axial: None,
        exponents: [0.0; 3],
    };

    fn drill(teeth: u32) -> Tool {
        Tool {
            teeth,
            diameter_m: Some(0.010),
            point_angle_rad: Some(rad_from_deg(140.0)),
            ..Tool::default()
        }
    }

    fn force(tool: &Tool) -> DrillingForce {
        let drill = Drill { pilot_diameter_m: 0.004, ..Drill::default() };
        DrillingForce::new(tool, drill, Some(K)).unwrap()
    }

    /// By hand: κ = 70°, sin κ = 0.939693, b = 3 mm / 0.939693 = 3.192533 mm, h = 0.1 · 0.939693
    /// mm. Thrust 2 b (300 h + 25) sin κ = 2 · 3 · (28.1908 + 25) = 319.145 N; torque 2 b (800 h +
    /// 20) · 3.5 mm = 2 · 3.192533 · (75.1754 + 20) · 3.5 mm = 2126.95 N mm.
    #[test]
    fn thrust_and_torque_are_those_worked_out_by_hand() {
        let force = force(&drill(2));
        assert!((force.thrust_n(1e-4) - 319.145).abs() < 0.001, "{}", force.thrust_n(1e-4));
        let torque_nm = force.torque_nm(1e-4).unwrap();
        assert!((torque_nm - 2.12695).abs() < 1e-5, "{torque_nm}");
        assert!(!force.is_lower_bound() && force.orders().is_empty());
        let none = DrillingForce::new(&drill(2), Drill::default(), Some(K)).unwrap();
        assert!(none.is_lower_bound());
    }

    /// Lip by lip at each angle of the spindle: the sum along the axis stands still, the sum to the
    /// side is the first harmonic alone.
    #[test]
    fn unlike_lips_leave_a_steady_thrust_and_a_force_that_turns() {
        let runout = Some(Runout { offset_m: 10e-6, angle_rad: 0.4 });
        let uneven = Some(vec![3.0, TAU - 3.0]);
        for tool in [
            Tool { runout, ..drill(2) },
            Tool { runout, ..drill(3) },
            Tool { pitch_rad: uneven, ..drill(2) },
            drill(1),
        ] {
            let (force, even) = (force(&tool), force(&drill(tool.teeth)));
            assert_eq!(force.orders(), [1]);
            let thrust = force.thrust_n(1e-4);
            assert!((thrust / even.thrust_n(1e-4) - 1.0).abs() < 1e-12, "{thrust}");
            let [x, y, z] = force.harmonics(&[1], 1e-4)[0].amplitude_n;
            assert!(z.norm() == 0.0 && x.norm() > 1.0);
            let pitch = tool.pitch_rad.clone().unwrap_or(vec![TAU / f64::from(tool.teeth); 3]);
            let kappa = PI * 70.0 / 180.0;
            for step in 0..7 {
                let turned = f64::from(step);
                let (mut expected, mut theta) = ([0.0; 2], 0.0);
                for (j, own) in pitch.iter().enumerate().take(tool.teeth as usize) {
                    let out = |angle: f64| {
                        tool.runout.map_or(0.0, |r| r.offset_m * (angle - r.angle_rad).cos())
                    };
                    let share = own * f64::from(tool.teeth) / TAU;
                    let chip =
                        share * 1e-4 * kappa.sin() + (out(theta) - out(theta + own)) * kappa.cos();
                    let b = 0.003 / kappa.sin();
                    let (t, r) = (b * (800e6 * chip + 20e3), b * (300e6 * chip + 25e3));
                    let (sin, cos) = (turned + theta).sin_cos();
                    expected[0] += -t * cos - r * kappa.cos() * sin;
                    expected[1] += t * sin - r * kappa.cos() * cos;
                    theta += own;
                    assert!(j < 3);
                }
                for (found, expected) in [x, y].into_iter().zip(expected) {
                    let found = (found * Complex::cis(turned)).re;
                    assert!((found - expected).abs() < 1e-9 * thrust, "{found} {expected}");
                }
            }
        }
    }
}
