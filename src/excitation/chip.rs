//! Chips whose thickness is no multiple of sin φ: runout moves each tooth outwards by its own ρ_j,
//! and a tooth cuts what the lowest of those ahead of it has left,
//!
//! ```text
//! h_j(φ) = max(0, min_k (c_jk sin φ + ρ_j − ρ_{j+k})),   k = 1..z
//! ```
//!
//! with c_jk the feed since tooth j + k was here. Kienzle's law makes the force F = a (K h^(1−m) +
//! K_e), with h in mm. The harmonics are integrals over the engagement, divided where the least of
//! the lines in sin φ changes, by the rule of Gauss and Legendre.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::engagement::{Engagement, ForceHarmonic, Tooth};
use crate::job::CuttingCoefficients;
use crate::units::mm_from_m;

/// Nodes and weights of Gauss and Legendre on −1..1, those above zero (Abramowitz & Stegun, Table
/// 25.4, n = 8).
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// Widest panel, rad; narrower for high orders.
const WIDEST: f64 = 0.1;

/// The teeth of a cutter and what each may cut.
#[derive(Debug)]
pub(super) struct Chips<'a> {
    teeth: &'a [Tooth],
    engagement: Engagement,
    coefficients: &'a CuttingCoefficients,
}

/// slope · sin φ + height, m.
type Line = [f64; 2];

impl<'a> Chips<'a> {
    pub(super) fn new(
        teeth: &'a [Tooth],
        engagement: Engagement,
        coefficients: &'a CuttingCoefficients,
    ) -> Self {
        Self { teeth, engagement, coefficients }
    }

    /// What tooth `j` finds before it: a line for each tooth ahead, itself last, a turn ago.
    fn lines(&self, j: usize, feed_per_tooth_m: f64) -> Vec<Line> {
        let z = self.teeth.len();
        let mut slope = 0.0;
        (1..=z)
            .map(|k| {
                slope += self.teeth[(j + k - 1) % z].share * feed_per_tooth_m;
                [slope, self.teeth[j].outwards_m - self.teeth[(j + k) % z].outwards_m]
            })
            .collect()
    }

    /// Angles between which the chip is smooth, from entry to exit.
    fn corners(&self, lines: &[Line]) -> Vec<f64> {
        let Engagement { entry_rad, exit_rad } = self.engagement;
        let mut corners = vec![entry_rad, exit_rad];
        let zero = [[0.0, 0.0]];
        for (i, a) in lines.iter().enumerate() {
            for b in lines[i + 1..].iter().chain(&zero) {
                let sin = (b[1] - a[1]) / (a[0] - b[0]);
                if (0.0..=1.0).contains(&sin) {
                    corners.extend([sin.asin(), PI - sin.asin()]);
                }
            }
        }
        corners.retain(|phi| (entry_rad..=exit_rad).contains(phi));
        corners.sort_by(f64::total_cmp);
        corners.dedup();
        corners
    }

    pub(super) fn harmonics(
        &self,
        orders: &[u32],
        feed_per_tooth_m: f64,
        axial_depth_m: f64,
    ) -> Vec<ForceHarmonic> {
        let highest = f64::from(orders.iter().copied().max().unwrap_or(0));
        let widest = WIDEST.min(2.0 / highest.max(1.0));
        let mut sums = vec![[Complex::from(0.0); 3]; orders.len()];
        for (j, tooth) in self.teeth.iter().enumerate() {
            let lines = self.lines(j, feed_per_tooth_m);
            let mut add = |phi: f64, weight: f64| {
                let chip_m = thickness(&lines, phi);
                if chip_m <= 0.0 {
                    return;
                }
                let force = in_axes(self.coefficients, phi, chip_m);
                for (sum, &order) in sums.iter_mut().zip(orders) {
                    let turn = Complex::cis(f64::from(order) * (tooth.angle_rad - phi)) * weight;
                    (0..3).for_each(|i| sum[i] += turn * force[i]);
                }
            };
            for ends in self.corners(&lines).windows(2) {
                integrate([ends[0], ends[1]], widest, &mut add);
            }
        }
        // Twice, as F is real: C_k and its conjugate make one cosine.
        let scale = 2.0 * axial_depth_m / TAU;
        let told = |(sum, &order): ([Complex<f64>; 3], &u32)| ForceHarmonic {
            order,
            amplitude_n: sum.map(|c| c * scale),
        };
        sums.into_iter().zip(orders).map(told).collect()
    }
}

/// The least of the lines, and none below zero.
fn thickness(lines: &[Line], phi: f64) -> f64 {
    let sin = phi.sin();
    let least = lines.iter().map(|[slope, height]| slope * sin + height);
    least.fold(f64::INFINITY, f64::min).max(0.0)
}

fn integrate([from, to]: [f64; 2], widest: f64, add: &mut impl FnMut(f64, f64)) {
    let panels = ((to - from) / widest).ceil().max(1.0);
    let half = 0.5 * (to - from) / panels;
    for panel in 0..panels as usize {
        let middle = from + half * (2.0 * panel as f64 + 1.0);
        for (x, weight) in GAUSS {
            add(middle - half * x, half * weight);
            add(middle + half * x, half * weight);
        }
    }
}

/// Force of a tooth at φ per axial depth, along the feed, across it and out of the work, N/m.
pub(super) fn in_axes(k: &CuttingCoefficients, phi: f64, chip_m: f64) -> [f64; 3] {
    let (sin, cos) = phi.sin_cos();
    let (cutting, edge) = (k.cutting_n_per_m2(), k.edge_n_per_m());
    let force = |i: usize| {
        let thinner = if k.exponents[i] == 0.0 { 1.0 } else { law(chip_m, k.exponents[i]) };
        cutting[i] * thinner * chip_m + edge[i]
    };
    let [tangential, radial, axial] = [0, 1, 2].map(force);
    [-tangential * cos - radial * sin, tangential * sin - radial * cos, -axial]
}

/// (h / 1 mm)^−m.
fn law(chip_m: f64, exponent: f64) -> f64 {
    mm_from_m(chip_m).powf(-exponent)
}

/// Coefficients that are linear in the chip: the slope of the force at the mean chip of the
/// engagement, (1 − m) K h^−m, and the edges as they are.
pub fn linear_about(
    coefficients: &CuttingCoefficients,
    engagement: Engagement,
    feed_per_tooth_m: f64,
) -> CuttingCoefficients {
    if coefficients.is_linear() {
        return *coefficients;
    }
    let Engagement { entry_rad, exit_rad } = engagement;
    let mean = feed_per_tooth_m * (entry_rad.cos() - exit_rad.cos()) / (exit_rad - entry_rad);
    let [t, r, a] = coefficients.exponents.map(|m| (1.0 - m) * law(mean, m));
    CuttingCoefficients {
        tangential_n_per_m2: t * coefficients.tangential_n_per_m2,
        radial_n_per_m2: r * coefficients.radial_n_per_m2,
        axial: coefficients.axial.map(|[cutting, edge]| [a * cutting, edge]),
        exponents: [0.0; 3],
        ..*coefficients
    }
}
