//! Cutting forces of an end mill, by the mechanistic model (Altintas, Manufacturing Automation, 2nd
//! ed., 2012, section 2.8).
//!
//! A tooth at angle φ, counted with the turning of the spindle from where an up-milling tooth
//! enters, takes a chip of thickness h = c sin φ between entry and exit:
//!
//! ```text
//! F_t = a (K_tc h + K_te),   F_r = a (K_rc h + K_re),   F_a = a (K_ac h + K_ae)
//! F_x = −F_t cos φ − F_r sin φ,    F_y = F_t sin φ − F_r cos φ,    F_z = −F_a
//! ```
//!
//! x runs with the feed, z along the spindle out of the work, y = z × x. The forces of all teeth
//! repeat with the spindle's turn; the coefficient of order k is
//!
//! ```text
//! F(t) = Σ_k C_k exp(i k Ω t),   C_k = 1/2π Σ_j exp(i k θ_j) ∫ F_j(φ) exp(−i k φ) dφ
//! ```
//!
//! with θ_j the angle of tooth j; the integrals have a closed form. A helix of angle β spreads each
//! tooth over the lag χ = 2 a tan β / D, which multiplies C_k by sinc(kχ/2) exp(−ikχ/2). With
//! runout or Kienzle's exponents the integrals are computed ([`super::chip`]); with runout and a
//! helix over the height, too, as the chip changes along an edge: no factor holds there. Left out:
//! the nose radius, and what the vibration itself does to the chip (regeneration).

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::chip::Chips;
use super::engagement::{Engagement, ForceHarmonic, Tooth, teeth};
#[cfg(test)]
use super::material::coefficients;
use crate::job::{Cutting, CuttingCoefficients, Runout, Tool};

/// The force of one cutter in one cut.
#[derive(Debug, Clone, PartialEq)]
pub struct MillingForce {
    coefficients: CuttingCoefficients,
    engagement: Engagement,
    axial_depth_m: f64,
    /// χ: by how much the highest point of an edge in the cut lags behind its tip, rad.
    lag_rad: f64,
    teeth: Vec<Tooth>,
    runout: Option<Runout>,
    has_even_teeth: bool,
}

impl MillingForce {
    #[cfg(test)]
    fn new(tool: &Tool, cutting: &Cutting) -> Option<Self> {
        Self::with(tool, cutting, coefficients(cutting)?)
    }

    /// `None` where the cutter's diameter is wanted and missing, or it drills.
    pub fn with(tool: &Tool, cutting: &Cutting, coefficients: CuttingCoefficients) -> Option<Self> {
        let lag_rad = match tool.helix_rad.tan() {
            0.0 => 0.0,
            slope => 2.0 * cutting.axial_depth_m * slope / tool.diameter_m?,
        };
        Some(Self {
            coefficients,
            engagement: Engagement::new(cutting, tool.diameter_m)?,
            axial_depth_m: cutting.axial_depth_m,
            lag_rad,
            teeth: teeth(tool),
            runout: tool.runout,
            has_even_teeth: tool.pitch_rad.is_none(),
        })
    }

    /// χ: by how much the highest point of an edge in the cut lags behind its tip, rad.
    pub fn lag_rad(&self) -> f64 {
        self.lag_rad
    }

    /// Angles of the teeth when the first is at zero, rad.
    pub fn angles_rad(&self) -> impl Iterator<Item = f64> + '_ {
        self.teeth.iter().map(|tooth| tooth.angle_rad)
    }

    /// The force repeats this many times a turn: only multiples of it have harmonics.
    pub fn repeats(&self) -> u32 {
        if self.has_even_teeth && self.runout.is_none() { self.teeth.len() as u32 } else { 1 }
    }

    /// Whether its harmonics are integrals that are computed, at a cost.
    pub fn is_computed(&self) -> bool {
        self.runout.is_some() || !self.coefficients.is_linear()
    }

    /// The mean of the force along the feed, across it and out of the work, N; along the axis it is
    /// zero where the axial coefficients are not known.
    pub fn mean_n(&self, feed_per_tooth_m: f64) -> [f64; 3] {
        // The harmonic of order zero counts twice, as all harmonics do.
        self.harmonic(0, feed_per_tooth_m).amplitude_n.map(|c| 0.5 * c.re)
    }

    /// The harmonic of an order.
    pub fn harmonic(&self, order: u32, feed_per_tooth_m: f64) -> ForceHarmonic {
        let found = self.harmonics(&[order], feed_per_tooth_m).pop();
        found.unwrap_or(ForceHarmonic { order, amplitude_n: Default::default() })
    }

    /// The harmonics of some orders at a mean feed per tooth; order 0 is twice the mean.
    pub fn harmonics(&self, orders: &[u32], feed_per_tooth_m: f64) -> Vec<ForceHarmonic> {
        if self.runout.is_some() {
            return self.computed(orders, feed_per_tooth_m, self.lag_rad);
        }
        let mut found: Vec<ForceHarmonic> = if self.is_computed() {
            self.computed(orders, feed_per_tooth_m, 0.0)
        } else {
            orders.iter().map(|&order| self.of_straight_flutes(order, feed_per_tooth_m)).collect()
        };
        for harmonic in &mut found {
            let half = 0.5 * f64::from(harmonic.order) * self.lag_rad;
            let sinc = if half == 0.0 { 1.0 } else { half.sin() / half };
            let spread = Complex::from_polar(sinc, -half);
            harmonic.amplitude_n = harmonic.amplitude_n.map(|c| c * spread);
        }
        found
    }

    fn computed(&self, orders: &[u32], feed_per_tooth_m: f64, lag_rad: f64) -> Vec<ForceHarmonic> {
        let repeats = if self.has_even_teeth { self.teeth.len() } else { 1 };
        let chips = Chips {
            teeth: &self.teeth,
            engagement: self.engagement,
            coefficients: &self.coefficients,
            runout: self.runout,
            repeats_rad: TAU / repeats as f64,
        };
        chips.harmonics(orders, feed_per_tooth_m, self.axial_depth_m, lag_rad)
    }

    /// In closed form, the chip of each tooth c sin φ.
    fn of_straight_flutes(&self, order: u32, feed_per_tooth_m: f64) -> ForceHarmonic {
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
        for tooth in &self.teeth {
            let turn = (i * m * tooth.angle_rad).exp();
            edge += turn;
            chip += turn * tooth.share;
        }
        // Twice, as F is real: C_k and its conjugate make one cosine.
        let scale = 2.0 * self.axial_depth_m / TAU;
        let [tc, rc, ac] = self.coefficients.cutting_n_per_m2().map(|k| k * feed_per_tooth_m);
        let [te, re, ae] = self.coefficients.edge_n_per_m();
        let x = -(chip * (sin_cos * tc + sin_sin * rc) + edge * (cos * te + sin * re));
        let y = chip * (sin_sin * tc - sin_cos * rc) + edge * (sin * te - cos * re);
        let z = -(chip * sin * ac + edge * whole(-m) * ae);
        ForceHarmonic { order, amplitude_n: [x * scale, y * scale, z * scale] }
    }

    /// Force along the feed, across it and out of the work, N, of straight flutes with an even
    /// chip, with tooth 0 at angle `turned_rad`.
    #[cfg(test)]
    pub(crate) fn force_n(&self, turned_rad: f64, feed_per_tooth_m: f64) -> [f64; 3] {
        let mut force = [0.0; 3];
        for tooth in &self.teeth {
            let phi = (turned_rad + tooth.angle_rad).rem_euclid(TAU);
            if (self.engagement.entry_rad..self.engagement.exit_rad).contains(&phi) {
                let chip_m = tooth.share * feed_per_tooth_m * phi.sin();
                let own = super::chip::in_axes(&self.coefficients, phi, chip_m);
                (0..3).for_each(|i| force[i] += self.axial_depth_m * own[i]);
            }
        }
        force
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::excitation::material;
    use crate::job::CuttingDirection;
    use crate::units::rad_from_deg;

    fn models() -> Vec<(MillingForce, u32)> {
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
                        process_damping_n_per_m: 0.0,
                    };
                    let first = if pitch_deg.is_some() { 1 } else { teeth };
                    models.push((MillingForce::new(&tool, &cutting).unwrap(), first));
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
            let samples: Vec<[f64; 3]> = (0..points)
                .map(|p| model.force_n((f64::from(p) + 0.5) / f64::from(points) * TAU, chip))
                .collect();
            let direct = |order: u32| {
                let mut sum = [Complex::from(0.0); 3];
                for (p, force) in samples.iter().enumerate() {
                    let angle = (p as f64 + 0.5) / f64::from(points) * TAU;
                    let turn =
                        Complex::from_polar(2.0 / f64::from(points), -f64::from(order) * angle);
                    (0..3).for_each(|i| sum[i] += turn * force[i]);
                }
                sum
            };
            let orders: Vec<u32> = (1..=6).map(|h| h * first).collect();
            let exact: Vec<[Complex<f64>; 3]> = orders.iter().map(|&o| direct(o)).collect();
            let largest = exact.iter().flatten().map(|c| c.norm()).fold(0.0, f64::max);
            for (&order, exact) in orders.iter().zip(&exact) {
                let found = model.harmonic(order, chip).amplitude_n;
                for axis in 0..3 {
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
            process_damping_n_per_m: 0.0,
        };
        let (f, nb) = (0.05e-3, 3.0 * 0.002);
        let [x, y, z] = MillingForce::new(&tool, &cutting).unwrap().mean_n(f);
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
            process_damping_n_per_m: 0.0,
        };
        // A quarter of the diameter: 60°.
        let climb = Engagement::new(&cutting(CuttingDirection::Climb), Some(0.012)).unwrap();
        assert!((climb.entry_rad - PI * 2.0 / 3.0).abs() < 1e-12 && climb.exit_rad == PI);
        let up = Engagement::new(&cutting(CuttingDirection::Conventional), Some(0.012)).unwrap();
        assert!(up.entry_rad == 0.0 && (up.exit_rad - PI / 3.0).abs() < 1e-12);
        assert!(Engagement::new(&cutting(CuttingDirection::Climb), None).is_none());
        assert!(Engagement::new(&cutting(CuttingDirection::Slot), None).is_some());
    }

    /// A cutter against a work that remembers its surface: at each height and each angle how far
    /// out any tooth has been, in steps of a turn. It knows no lines, no closed form and no
    /// harmonics.
    fn simulated(
        tool: &Tool,
        cutting: &Cutting,
        feed_m: f64,
        orders: &[u32],
    ) -> Vec<[Complex<f64>; 3]> {
        let (steps, discs, turns) = (2880_usize, 96_usize, 4_usize);
        let k = coefficients(cutting).unwrap();
        let z = tool.teeth as usize;
        let Engagement { entry_rad, exit_rad } = Engagement::new(cutting, tool.diameter_m).unwrap();
        let pitch = tool.pitch_rad.clone().unwrap_or(vec![TAU / z as f64; z]);
        let angles: Vec<f64> = (0..z).map(|j| pitch[..j].iter().sum()).collect();
        let per_step = feed_m * z as f64 / steps as f64;
        let height = cutting.axial_depth_m / discs as f64;
        let mut sums = vec![[Complex::from(0.0); 3]; orders.len()];
        for disc in 0..discs {
            let up = (disc as f64 + 0.5) * height;
            let lag = 2.0 * up * tool.helix_rad.tan() / tool.diameter_m.unwrap();
            let mut surface = vec![f64::NEG_INFINITY; steps];
            for step in 0..turns * steps {
                let moved = per_step * step as f64;
                let mut force = [0.0; 3];
                for theta in &angles {
                    let turned = TAU * step as f64 / steps as f64;
                    let phi = (turned + theta - lag).rem_euclid(TAU);
                    if !(entry_rad..exit_rad).contains(&phi) {
                        continue;
                    }
                    // The edge at this height is where its tip was a lag ago.
                    let runout =
                        tool.runout.map_or(0.0, |r| r.offset_m * (theta - lag - r.angle_rad).cos());
                    let out = runout + moved * phi.sin();
                    let before = &mut surface[(phi / TAU * steps as f64).round() as usize % steps];
                    let chip = out - before.max(out - 1e-3);
                    *before = before.max(out);
                    if chip <= 0.0 {
                        continue;
                    }
                    let h = chip * 1e3;
                    let (c, e) = (k.cutting_n_per_m2(), k.edge_n_per_m());
                    let f = |i: usize| height * (c[i] * chip * h.powf(-k.exponents[i]) + e[i]);
                    let (sin, cos) = phi.sin_cos();
                    force[0] += -f(0) * cos - f(1) * sin;
                    force[1] += f(0) * sin - f(1) * cos;
                    force[2] -= f(2);
                }
                if step < (turns - 1) * steps {
                    continue;
                }
                for (sum, &order) in sums.iter_mut().zip(orders) {
                    let angle = TAU * step as f64 / steps as f64 * f64::from(order);
                    let turn = Complex::from_polar(2.0 / steps as f64, -angle);
                    (0..3).for_each(|i| sum[i] += turn * force[i]);
                }
            }
        }
        sums
    }

    fn mill(teeth: u32, helix_deg: f64, runout: Option<(f64, f64)>) -> Tool {
        Tool {
            teeth,
            diameter_m: Some(0.012),
            helix_rad: rad_from_deg(helix_deg),
            runout: runout.map(|(offset_m, angle_rad)| Runout { offset_m, angle_rad }),
            ..Tool::default()
        }
    }

    fn cut(direction: CuttingDirection, exponents: [f64; 3]) -> Cutting {
        let al = material("al-7075").unwrap().coefficients;
        Cutting {
            radial_depth_m: 0.005,
            axial_depth_m: 0.004,
            direction,
            material: String::new(),
            coefficients: Some(CuttingCoefficients { exponents, ..al }),
            regenerates: true,
            process_damping_n_per_m: 0.0,
        }
    }

    /// The grid of the simulation is 1/2880 of a turn: edges jump in it, to some per mille.
    #[test]
    fn helix_runout_and_exponents_agree_with_a_work_that_remembers_its_surface() {
        use CuttingDirection::{Climb, Conventional, Slot};
        let uneven = Tool { pitch_rad: Some(vec![1.9, 2.2, TAU - 4.1]), ..mill(3, 20.0, None) };
        let uneven_out = Tool { runout: mill(3, 0.0, Some((9e-6, 0.8))).runout, ..uneven.clone() };
        let mut worst = 0.0_f64;
        for (tool, direction, exponents, axial_depth_m) in [
            (mill(2, 30.0, None), Climb, [0.0; 3], 0.004),
            (mill(4, 40.0, None), Conventional, [0.0; 3], 0.004),
            (uneven, Slot, [0.0; 3], 0.004),
            (mill(3, 0.0, None), Climb, [0.25, 0.35, 0.2], 0.004),
            (mill(2, 0.0, Some((8e-6, 0.4))), Conventional, [0.0; 3], 0.004),
            (mill(3, 30.0, Some((20e-6, 1.9))), Climb, [0.0; 3], 0.004),
            // One of four teeth never cuts.
            (mill(4, 30.0, Some((90e-6, -0.7))), Slot, [0.25, 0.25, 0.3], 0.004),
            // Edges that wind through more than a pitch, and less of one.
            (mill(4, 40.0, Some((5e-6, 0.0))), Climb, [0.0; 3], 0.012),
            (mill(4, 40.0, Some((5e-6, 0.0))), Climb, [0.0; 3], 0.024),
            (uneven_out, Conventional, [0.2, 0.3, 0.0], 0.02),
        ] {
            let cutting = Cutting { axial_depth_m, ..cut(direction, exponents) };
            let model = MillingForce::new(&tool, &cutting).unwrap();
            let orders: Vec<u32> = (0..=2 * tool.teeth).collect();
            let found = model.harmonics(&orders, 60e-6);
            let expected = simulated(&tool, &cutting, 60e-6, &orders);
            let largest = expected.iter().flatten().map(|c| c.norm()).fold(0.0, f64::max);
            for (found, expected) in found.iter().zip(&expected) {
                for (found_n, expected_n) in found.amplitude_n.iter().zip(expected) {
                    let off = (found_n - expected_n).norm() / largest;
                    worst = worst.max(off);
                    assert!(off < 3e-3, "{tool:?} {axial_depth_m} m order {}: {off}", found.order);
                }
            }
        }
        println!("largest error {worst:.1e} of the largest harmonic");
    }

    /// At b tan β = π D / N an edge leaves as the next enters: the force stands still (Altintas,
    /// Manufacturing Automation, 2nd ed., section 2.8).
    #[test]
    fn one_pitch_of_helix_takes_all_tooth_harmonics_away() {
        for teeth in [2, 3, 4] {
            let mut cutting = cut(CuttingDirection::Climb, [0.0; 3]);
            let tool = mill(teeth, 35.0, None);
            let lead = PI * 0.012 / f64::from(teeth) / tool.helix_rad.tan();
            let of = |depth_m: f64, cutting: &mut Cutting| {
                cutting.axial_depth_m = depth_m;
                MillingForce::new(&tool, cutting).unwrap()
            };
            let (whole, half) = (of(lead, &mut cutting), of(0.5 * lead, &mut cutting));
            for h in 1..=4 {
                let size =
                    |model: &MillingForce| model.harmonic(h * teeth, 5e-5).amplitude_n[1].norm();
                assert!(size(&whole) < 1e-12 * whole.mean_n(5e-5)[1], "{teeth} {h}");
                assert!(h % 2 == 0 || size(&half) > 1e-3 * half.mean_n(5e-5)[1], "{teeth} {h}");
            }
        }
    }

    /// The offsets of the teeth add up to zero: while all cut all the time, tooth harmonics stay as
    /// they are and order k gets K a / 2π times the sum of the offsets, turned. A cut from 60° to
    /// 120°, where the chip of 50 µm is nowhere below 43 µm.
    #[test]
    fn runout_adds_spindle_lines_alone_while_every_tooth_cuts() {
        let model = |runout| {
            let tool = mill(4, 0.0, runout);
            let mut model =
                MillingForce::new(&tool, &cut(CuttingDirection::Slot, [0.0; 3])).unwrap();
            model.engagement = Engagement { entry_rad: PI / 3.0, exit_rad: 2.0 * PI / 3.0 };
            model
        };
        let (straight, small, large) =
            (model(None), model(Some((5e-6, 0.3))), model(Some((60e-6, 0.3))));
        let size = |model: &MillingForce, order| model.harmonic(order, 50e-6).amplitude_n[1];
        let tooth = size(&straight, 4).norm();
        for h in 0..=3 {
            let off = (size(&small, 4 * h) - size(&straight, 4 * h)).norm();
            assert!(off < 1e-9 * tooth, "{h}: {off}");
        }
        assert!(size(&straight, 1).norm() < 1e-12 * tooth);
        assert!(size(&small, 1).norm() > 0.05 * tooth);
        // Order 1 of F_y, by the rule of rectangles.
        let k = coefficients(&cut(CuttingDirection::Slot, [0.0; 3])).unwrap();
        let mut expected = Complex::from(0.0);
        for j in 0..4 {
            let theta = f64::from(j) * PI / 2.0;
            let delta = 5e-6 * ((theta - 0.3).cos() - (theta + PI / 2.0 - 0.3).cos());
            for p in 0..20_000 {
                let phi = PI / 3.0 * (1.0 + (f64::from(p) + 0.5) / 20_000.0);
                let force = k.tangential_n_per_m2 * phi.sin() - k.radial_n_per_m2 * phi.cos();
                let turn = Complex::cis(theta - phi) * (PI / 3.0 / 20_000.0);
                expected += turn * force * delta * 0.004 / PI;
            }
        }
        let off = (size(&small, 1) - expected).norm();
        assert!(off < 1e-6 * expected.norm(), "{off}");
        // A tooth that never cuts leaves its chip to the next: the tooth harmonics change.
        assert!((size(&large, 4) - size(&straight, 4)).norm() > 0.05 * tooth);
    }

    /// With every tooth in the cut Σ_j exp(i (θ_j − ψ)) cos(θ_j − ψ − λ) = z/2 exp(iλ) at every lag
    /// ψ: a helix leaves the spindle line as it is, per depth.
    #[test]
    fn a_helix_does_not_take_the_spindle_line_down() {
        let of = |axial_depth_m: f64, helix_deg: f64| {
            let cutting = Cutting { axial_depth_m, ..cut(CuttingDirection::Slot, [0.0; 3]) };
            let tool = mill(4, helix_deg, Some((5e-6, 0.3)));
            let mut model = MillingForce::new(&tool, &cutting).unwrap();
            model.engagement = Engagement { entry_rad: PI / 3.0, exit_rad: 2.0 * PI / 3.0 };
            model.harmonic(1, 50e-6).amplitude_n.map(|c| c / axial_depth_m)
        };
        let straight = of(0.004, 0.0);
        for depth_m in [0.004, 0.012, 0.024] {
            for (helix, straight) in of(depth_m, 40.0).into_iter().zip(straight) {
                let off = (helix - straight).norm() / straight.norm();
                assert!(off < 1e-9, "{depth_m} m: {off}");
            }
        }
    }

    /// The slope of the force at the mean chip, by differences.
    #[test]
    fn linear_coefficients_have_the_slope_of_the_law() {
        let whole = Engagement { entry_rad: 0.0, exit_rad: PI };
        let k = coefficients(&cut(CuttingDirection::Slot, [0.25, 0.35, 0.2])).unwrap();
        let linear = crate::excitation::linear_about(&k, whole.mean_chip_m(80e-6));
        let mean = 80e-6 * 2.0 / PI;
        let force =
            |h: f64, i: usize| k.cutting_n_per_m2()[i] * h * (h * 1e3).powf(-k.exponents[i]);
        for i in 0..3 {
            let slope = (force(1.001 * mean, i) - force(0.999 * mean, i)) / (0.002 * mean);
            assert!((linear.cutting_n_per_m2()[i] / slope - 1.0).abs() < 1e-6, "{i}");
        }
        assert!(linear.is_linear() && linear.edge_n_per_m() == k.edge_n_per_m());
    }
}
