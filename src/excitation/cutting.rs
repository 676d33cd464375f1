//! Cutting forces of a straight-fluted end mill, by the mechanistic model (Altintas, Manufacturing
//! Automation, 2nd ed., 2012, section 2.8).
//!
//! A tooth at angle φ, counted with the turning of the spindle from where an up-milling tooth
//! enters, takes a chip of thickness c sin φ between entry and exit:
//!
//! ```text
//! F_t = a (K_tc c sin φ + K_te),   F_r = a (K_rc c sin φ + K_re)
//! F_x = −F_t cos φ − F_r sin φ,    F_y = F_t sin φ − F_r cos φ
//! ```
//!
//! x runs with the feed, z along the spindle out of the work, y = z × x. The forces of all teeth
//! repeat with the spindle's turn; the coefficient of order k is
//!
//! ```text
//! F(t) = Σ_k C_k exp(i k Ω t),   C_k = 1/2π Σ_j exp(i k θ_j) ∫ F_j(φ) exp(−i k φ) dφ
//! ```
//!
//! with θ_j the angle of tooth j; the integrals have a closed form. Left out: helix, runout, the
//! nose radius, forces along the axis, and what the vibration itself does to the chip
//! (regeneration).

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use crate::job::{Cutting, CuttingCoefficients, CuttingDirection, Tool};
use crate::units::{n_per_m_from_n_per_mm, n_per_m2_from_n_per_mm2};

/// A material by name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// As jobs spell it.
    pub name: &'static str,
    /// Its coefficients.
    pub coefficients: CuttingCoefficients,
}

const fn of(name: &'static str, [tc, rc, te, re]: [f64; 4], axial: Option<[f64; 2]>) -> Material {
    Material {
        name,
        coefficients: CuttingCoefficients {
            tangential_n_per_m2: n_per_m2_from_n_per_mm2(tc),
            radial_n_per_m2: n_per_m2_from_n_per_mm2(rc),
            tangential_edge_n_per_m: n_per_m_from_n_per_mm(te),
            radial_edge_n_per_m: n_per_m_from_n_per_mm(re),
            axial: match axial {
                Some([ac, ae]) => Some([n_per_m2_from_n_per_mm2(ac), n_per_m_from_n_per_mm(ae)]),
                None => None,
            },
        },
    }
}

/// K_tc, K_rc in N/mm² and K_te, K_re in N/mm, then K_ac and K_ae, from the review in Chin. J.
/// Mech. Eng. 2021, DOI 10.1186/s10033-021-00536-9, Table 5.
pub const MATERIALS: [Material; 3] = [
    of("al-6082", [631.0, 99.0, 13.0, 10.0], Some([273.0, 2.8])),
    of("al-7075", [767.0, 169.0, 27.7, 26.6], Some([222.0, 0.7])),
    of("al-6061", [244.0, 113.5, 7.53, 7.83], None),
];

/// The material that jobs call `name`, temper and case aside: `al-6082-T6` is `al-6082`.
pub fn material(name: &str) -> Option<&'static Material> {
    let name = name.trim().to_ascii_lowercase().replace([' ', '_'], "-");
    MATERIALS.iter().find(|material| {
        name.strip_prefix(material.name)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
    })
}

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
    /// Along the feed and across it, N.
    pub amplitude_n: [Complex<f64>; 2],
}

/// The force of one cutter in one cut.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceModel {
    coefficients: CuttingCoefficients,
    engagement: Engagement,
    axial_depth_m: f64,
    /// Per tooth, its angle θ_j and its share of the mean chip.
    teeth: Vec<(f64, f64)>,
}

/// The coefficients that hold for a cut: its own, else those of its material.
pub fn coefficients(cutting: &Cutting) -> Option<CuttingCoefficients> {
    cutting.coefficients.or_else(|| Some(material(&cutting.material)?.coefficients))
}

impl ForceModel {
    /// `None` where the material is not known and the job gives no coefficients, or the cutter's
    /// diameter is missing.
    pub fn new(tool: &Tool, cutting: &Cutting) -> Option<Self> {
        let coefficients = coefficients(cutting)?;
        let z = f64::from(tool.teeth);
        let even = vec![TAU / z; tool.teeth as usize];
        let pitch = tool.pitch_rad.as_ref().unwrap_or(&even);
        let mut angle = 0.0;
        let teeth = pitch
            .iter()
            .map(|next| {
                let here = angle;
                angle += next;
                // It cuts what the tooth ahead of it has left: the farther ahead, the thicker.
                (here, next * z / TAU)
            })
            .collect();
        Some(Self {
            coefficients,
            engagement: Engagement::new(cutting, tool.diameter_m)?,
            axial_depth_m: cutting.axial_depth_m,
            teeth,
        })
    }

    /// Force along the feed and across it, N, with tooth 0 at angle `turned_rad`, at a mean feed
    /// per tooth.
    pub fn force_n(&self, turned_rad: f64, feed_per_tooth_m: f64) -> [f64; 2] {
        let mut force = [0.0, 0.0];
        for &(theta, share) in &self.teeth {
            let phi = (turned_rad + theta).rem_euclid(TAU);
            if (self.engagement.entry_rad..self.engagement.exit_rad).contains(&phi) {
                let [x, y] = self.tooth_force_n(phi, share * feed_per_tooth_m);
                force = [force[0] + x, force[1] + y];
            }
        }
        force
    }

    fn tooth_force_n(&self, phi: f64, chip_m: f64) -> [f64; 2] {
        let k = &self.coefficients;
        let (sin, cos) = phi.sin_cos();
        let a = self.axial_depth_m;
        let tangential = a * (k.tangential_n_per_m2 * chip_m * sin + k.tangential_edge_n_per_m);
        let radial = a * (k.radial_n_per_m2 * chip_m * sin + k.radial_edge_n_per_m);
        [-tangential * cos - radial * sin, tangential * sin - radial * cos]
    }

    /// The mean of the force along the feed, across it and out of the work, N; along the axis it is
    /// zero where the axial coefficients are not known.
    pub fn mean_n(&self, feed_per_tooth_m: f64) -> [f64; 3] {
        // The harmonic of order zero counts twice, as all harmonics do.
        let [x, y] = self.harmonic(0, feed_per_tooth_m).amplitude_n.map(|c| 0.5 * c.re);
        let Engagement { entry_rad, exit_rad } = self.engagement;
        let [cutting, edge] = self.coefficients.axial.unwrap_or_default();
        let chip = feed_per_tooth_m * (entry_rad.cos() - exit_rad.cos());
        let per_turn = cutting * chip + edge * (exit_rad - entry_rad);
        [x, y, -self.axial_depth_m * self.teeth.len() as f64 / TAU * per_turn]
    }

    /// The harmonic of order `order` (1 or more), in closed form.
    pub fn harmonic(&self, order: u32, feed_per_tooth_m: f64) -> ForceHarmonic {
        let k = &self.coefficients;
        let m = f64::from(order);
        let i = Complex::<f64>::i();
        let Engagement { entry_rad, exit_rad } = self.engagement;
        // ∫ exp(i p φ) dφ over the engagement.
        let whole = |p: f64| {
            if p == 0.0 {
                Complex::from(exit_rad - entry_rad)
            } else {
                ((i * p * exit_rad).exp() - (i * p * entry_rad).exp()) / (i * p)
            }
        };
        let sin = (whole(1.0 - m) - whole(-1.0 - m)) / (2.0 * i);
        let cos = (whole(1.0 - m) + whole(-1.0 - m)) * 0.5;
        let sin_cos = (whole(2.0 - m) - whole(-2.0 - m)) / (4.0 * i);
        let sin_sin = whole(-m) * 0.5 - (whole(2.0 - m) + whole(-2.0 - m)) * 0.25;
        let (mut edge, mut chip) = (Complex::from(0.0), Complex::from(0.0));
        for &(theta, share) in &self.teeth {
            let turn = (i * m * theta).exp();
            edge += turn;
            chip += turn * share;
        }
        // Twice, as F is real: C_k and its conjugate make one cosine.
        let scale = 2.0 * self.axial_depth_m / TAU;
        let c = feed_per_tooth_m;
        let (tc, rc) = (k.tangential_n_per_m2 * c, k.radial_n_per_m2 * c);
        let (te, re) = (k.tangential_edge_n_per_m, k.radial_edge_n_per_m);
        let x = -(chip * (sin_cos * tc + sin_sin * rc) + edge * (cos * te + sin * re));
        let y = chip * (sin_sin * tc - sin_cos * rc) + edge * (sin * te - cos * re);
        ForceHarmonic { order, amplitude_n: [x * scale, y * scale] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::rad_from_deg;

    fn models() -> Vec<(ForceModel, u32)> {
        let mut models = Vec::new();
        for (teeth, pitch_deg) in [
            (1, None),
            (2, None),
            (3, None),
            (4, None),
            (2, Some(vec![170.0, 190.0])),
            (4, Some(vec![80.0, 95.0, 85.0, 100.0])),
        ] {
            for direction in
                [CuttingDirection::Climb, CuttingDirection::Conventional, CuttingDirection::Slot]
            {
                for (radial_depth_m, material) in [(0.0012, "al-6061"), (0.006, "al-7075-T6")] {
                    let tool = Tool {
                        name: None,
                        teeth,
                        diameter_m: Some(0.012),
                        pitch_rad: pitch_deg.as_ref().map(|pitch: &Vec<f64>| {
                            pitch.iter().map(|&p| rad_from_deg(p)).collect()
                        }),
                        ..Tool::default()
                    };
                    let cutting = Cutting {
                        radial_depth_m,
                        axial_depth_m: 0.002,
                        direction,
                        material: material.to_owned(),
                        coefficients: None,
                        regenerates: true,
                    };
                    let first = if pitch_deg.is_some() { 1 } else { teeth };
                    models.push((ForceModel::new(&tool, &cutting).unwrap(), first));
                }
            }
        }
        models
    }

    /// The midpoint rule over a whole turn: harmonics against the force itself. The
    /// first six of the force's own period, to 0.1 % of the largest.
    #[test]
    fn the_spectrum_agrees_with_direct_integration() {
        let points = 200_000;
        let mut worst = 0.0_f64;
        for (model, first) in models() {
            let chip = 0.08e-3;
            let samples: Vec<[f64; 2]> = (0..points)
                .map(|p| model.force_n((f64::from(p) + 0.5) / f64::from(points) * TAU, chip))
                .collect();
            let direct = |order: u32| {
                let mut sum = [Complex::from(0.0); 2];
                for (p, force) in samples.iter().enumerate() {
                    let angle = (p as f64 + 0.5) / f64::from(points) * TAU;
                    let turn =
                        Complex::from_polar(2.0 / f64::from(points), -f64::from(order) * angle);
                    sum = [sum[0] + turn * force[0], sum[1] + turn * force[1]];
                }
                sum
            };
            let orders: Vec<u32> = (1..=6).map(|h| h * first).collect();
            let exact: Vec<[Complex<f64>; 2]> = orders.iter().map(|&o| direct(o)).collect();
            let largest = exact.iter().flatten().map(|c| c.norm()).fold(0.0, f64::max);
            for (&order, exact) in orders.iter().zip(&exact) {
                let found = model.harmonic(order, chip).amplitude_n;
                for axis in 0..2 {
                    let error = (found[axis] - exact[axis]).norm();
                    worst = worst.max(error / exact[axis].norm().max(0.01 * largest));
                }
            }
        }
        println!("largest error of six harmonics {worst:.1e}");
        assert!(worst < 1e-3, "{worst}");
    }

    /// Mean forces of a slot in closed form (Altintas, Manufacturing Automation, 2nd ed., section
    /// 2.8.1, on the tool): F̄x = −(Nb/4) K_rc f − (Nb/π) K_re, F̄y = (Nb/4) K_tc f + (Nb/π) K_te,
    /// and along the axis, out of the holder, (Nb/π) K_ac f + (Nb/2) K_ae.
    #[test]
    fn mean_forces_of_a_slot_have_their_closed_form() {
        let tool = Tool { teeth: 3, ..Tool::default() };
        let cutting = Cutting {
            radial_depth_m: 0.0,
            axial_depth_m: 0.002,
            direction: CuttingDirection::Slot,
            material: "al-6082".to_owned(),
            coefficients: None,
            regenerates: true,
        };
        let (f, nb) = (0.05e-3, 3.0 * 0.002);
        let [x, y, z] = ForceModel::new(&tool, &cutting).unwrap().mean_n(f);
        let expected = [
            -nb / 4.0 * 99e6 * f - nb / PI * 10e3,
            nb / 4.0 * 631e6 * f + nb / PI * 13e3,
            -(nb / PI * 273e6 * f + nb / 2.0 * 2.8e3),
        ];
        for (found, expected) in [x, y, z].into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
    }

    #[test]
    fn even_teeth_leave_nothing_between_their_harmonics() {
        let (model, _) = models().swap_remove(12);
        assert_eq!(model.teeth.len(), 3);
        let of = |order| model.harmonic(order, 1e-4).amplitude_n[0].norm();
        assert!(of(3) > 1.0 && of(1) < 1e-12 * of(3) && of(2) < 1e-12 * of(3));
    }

    #[test]
    fn materials_are_found_by_name_and_engagement_by_depth() {
        assert_eq!(material("AL-6082-T6").unwrap().name, "al-6082");
        assert_eq!(material("al 6061").unwrap().name, "al-6061");
        assert!(material("al-60617").is_none() && material("steel").is_none());
        let cutting = |direction| Cutting {
            radial_depth_m: 0.003,
            axial_depth_m: 0.001,
            direction,
            material: "al-6061".to_owned(),
            coefficients: None,
            regenerates: true,
        };
        // A quarter of the diameter: 60°.
        let climb = Engagement::new(&cutting(CuttingDirection::Climb), Some(0.012)).unwrap();
        assert!((climb.entry_rad - PI * 2.0 / 3.0).abs() < 1e-12 && climb.exit_rad == PI);
        let up = Engagement::new(&cutting(CuttingDirection::Conventional), Some(0.012)).unwrap();
        assert!(up.entry_rad == 0.0 && (up.exit_rad - PI / 3.0).abs() < 1e-12);
        assert!(Engagement::new(&cutting(CuttingDirection::Climb), None).is_none());
        assert!(Engagement::new(&cutting(CuttingDirection::Slot), None).is_some());
    }
}
