//! Chips whose thickness is no multiple of sin φ: runout moves each tooth outwards by its own ρ_j,
//! and a tooth cuts what the lowest of those ahead of it has left,
//!
//! ```text
//! h_j(φ) = max(0, min_k (c_jk sin φ + ρ_j − ρ_{j+k})),   k = 1..z
//! ρ_j = ρ cos(θ_j − ψ − λ)
//! ```
//!
//! with c_jk the feed since tooth j + k was here, ρ and λ the runout, and ψ by how much the edge
//! lags behind its tip at a height: the helix winds an edge about an axis that does not turn with
//! it, so ρ_j changes along the edge. Kienzle's law makes the force F = a (K h^(1−m) + K_e), with h
//! in mm.
//!
//! ```text
//! C_k = a/2π · 1/χ ∫ S_k(ψ) exp(−i k ψ) dψ
//! S_k(ψ) = Σ_j exp(i k θ_j) ∫ F_j(φ, ψ)/a exp(−i k φ) dφ
//! ```
//!
//! The inner integral is by the rule of Gauss and Legendre, divided where the least of the lines in
//! sin φ changes. S_k changes with ρ_j alone, as slowly for high orders as for low ones: the outer
//! integral takes it for a polynomial of the seventh degree on stretches of ψ (Filon).

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::engagement::{Engagement, ForceHarmonic, Tooth};
use crate::job::{CuttingCoefficients, Runout};
use crate::units::mm_from_m;

/// Nodes and weights of Gauss and Legendre on −1..1, those above zero (Abramowitz & Stegun, Table
/// 25.4, n = 8).
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// Widest panels of the angle and of the lag, rad: corners in the lag are not looked for.
const WIDEST_ANGLE: f64 = 0.1;
const WIDEST_LAG: f64 = 0.2;

/// The highest order turns at most this far in a panel, rad: the rule is good to 1e-8 there.
const MAX_TURNED: f64 = 8.0;

/// The teeth of a cutter and what each may cut.
#[derive(Debug)]
pub(super) struct Chips<'a> {
    pub(super) teeth: &'a [Tooth],
    pub(super) engagement: Engagement,
    pub(super) coefficients: &'a CuttingCoefficients,
    pub(super) runout: Option<Runout>,
    /// S_k exp(−i k ψ) repeats after this angle: the pitch, or a turn where pitches differ.
    pub(super) repeats_rad: f64,
}

/// slope · sin φ + height, m.
type Line = [f64; 2];

/// One for each order: along the feed, across it and out of the work.
type Sums = Vec<[Complex<f64>; 3]>;

impl Chips<'_> {
    /// ρ_j, m.
    fn outwards_m(&self, j: usize, lag_rad: f64) -> f64 {
        let of = |Runout { offset_m, angle_rad }| {
            offset_m * (self.teeth[j].angle_rad - lag_rad - angle_rad).cos()
        };
        self.runout.map_or(0.0, of)
    }

    /// What tooth `j` finds before it: a line for each tooth ahead, itself last, a turn ago.
    fn lines(&self, j: usize, lag_rad: f64, feed_per_tooth_m: f64) -> Vec<Line> {
        let z = self.teeth.len();
        let own = self.outwards_m(j, lag_rad);
        let mut slope = 0.0;
        (1..=z)
            .map(|k| {
                slope += self.teeth[(j + k - 1) % z].share * feed_per_tooth_m;
                [slope, own - self.outwards_m((j + k) % z, lag_rad)]
            })
            .collect()
    }

    /// Angles between which the chip is smooth, from entry to exit.
    fn corners(&self, lines: &[Line]) -> Vec<f64> {
        let Engagement { entry_rad, exit_rad } = self.engagement;
        let corner = |sin: f64| [sin.asin(), PI - sin.asin()];
        let mut corners: Vec<f64> = sines(lines).into_iter().flat_map(corner).collect();
        corners.retain(|phi| (entry_rad..exit_rad).contains(phi));
        corners.extend([entry_rad, exit_rad]);
        corners.sort_by(f64::total_cmp);
        corners.dedup();
        corners
    }

    /// S_k, N/m.
    fn at_height(&self, orders: &[u32], feed_per_tooth_m: f64, lag_rad: f64) -> Sums {
        let widest = WIDEST_ANGLE.min(turned(orders));
        let mut sums = vec![[Complex::from(0.0); 3]; orders.len()];
        for (j, tooth) in self.teeth.iter().enumerate() {
            let lines = self.lines(j, lag_rad, feed_per_tooth_m);
            let mut add = |phi: f64, weight: f64| {
                let chip_m = thickness(&lines, phi);
                if chip_m <= 0.0 {
                    return;
                }
                let force = in_axes(self.coefficients, phi, chip_m).map(|f| f * weight);
                let turn = Complex::cis(tooth.angle_rad - phi);
                // Each power from the one before: a sine for each would cost ten times as much.
                let (mut power, mut last) = (Complex::from(1.0), 0);
                for (sum, &order) in sums.iter_mut().zip(orders) {
                    power *= turn.powi(order as i32 - last);
                    last = order as i32;
                    (0..3).for_each(|i| sum[i] += power * force[i]);
                }
            };
            for ends in self.corners(&lines).windows(2) {
                integrate([ends[0], ends[1]], widest, &mut add);
            }
        }
        sums
    }

    /// The mean of S_k exp(−i k ψ) over a helix that lags by `lag_rad` at the top.
    fn over_heights(&self, orders: &[u32], feed_per_tooth_m: f64, lag_rad: f64) -> Sums {
        let mut sums = vec![[Complex::from(0.0); 3]; orders.len()];
        let mut add = |[from, to]: [f64; 2], times: f64| {
            let panels = ((to - from) / WIDEST_LAG).ceil().max(1.0);
            let half = 0.5 * (to - from) / panels;
            let of_orders: Vec<[Complex<f64>; 8]> =
                orders.iter().map(|&order| filon(f64::from(order) * half)).collect();
            for panel in 0..panels as usize {
                let middle = from + half * (2.0 * panel as f64 + 1.0);
                for (m, x) in nodes().into_iter().enumerate() {
                    let here = self.at_height(orders, feed_per_tooth_m, middle + half * x);
                    let each = sums.iter_mut().zip(here).zip(orders).zip(&of_orders);
                    for (((sum, here), &order), weights) in each {
                        let turn = Complex::cis(-f64::from(order) * middle);
                        let weight = turn * weights[m] * (half * times / lag_rad);
                        (0..3).for_each(|i| sum[i] += here[i] * weight);
                    }
                }
            }
        };
        // So often a whole, and a rest.
        let whole = (lag_rad / self.repeats_rad).floor();
        let rest = lag_rad - whole * self.repeats_rad;
        add([0.0, rest], whole + 1.0);
        if whole > 0.0 {
            add([rest, self.repeats_rad], whole);
        }
        sums
    }

    /// The harmonics of edges that lag by `lag_rad` at the top; none for straight ones.
    pub(super) fn harmonics(
        &self,
        orders: &[u32],
        feed_per_tooth_m: f64,
        axial_depth_m: f64,
        lag_rad: f64,
    ) -> Vec<ForceHarmonic> {
        let sums = if lag_rad == 0.0 {
            self.at_height(orders, feed_per_tooth_m, 0.0)
        } else {
            self.over_heights(orders, feed_per_tooth_m, lag_rad)
        };
        // Twice, as F is real: C_k and its conjugate make one cosine.
        let scale = 2.0 * axial_depth_m / TAU;
        let told = |(sum, &order): ([Complex<f64>; 3], &u32)| ForceHarmonic {
            order,
            amplitude_n: sum.map(|c| c * scale),
        };
        sums.into_iter().zip(orders).map(told).collect()
    }
}

/// Angle in which the highest order turns as far as it may, rad.
fn turned(orders: &[u32]) -> f64 {
    let highest = orders.iter().copied().max().unwrap_or(0);
    MAX_TURNED / f64::from(highest.max(1))
}

/// Sines within 0..1 at which another line becomes the least, or the least one rises above zero.
fn sines(lines: &[Line]) -> Vec<f64> {
    let lowest = |a: &&Line, b: &&Line| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0]));
    let mut least = lines.iter().min_by(lowest);
    let mut sines = Vec::new();
    // As sin φ grows, flatter and flatter lines are the least.
    while let Some([slope, height]) = least {
        sines.push(-height / slope);
        let crossing = |line: &Line| (line[1] - height) / (slope - line[0]);
        let flatter = lines.iter().filter(|line| line[0] < *slope);
        least = flatter.min_by(|a, b| crossing(a).total_cmp(&crossing(b)));
        sines.extend(least.map(crossing));
    }
    sines.retain(|sin| (0.0..=1.0).contains(sin));
    sines
}

/// The least of the lines, and none below zero.
fn thickness(lines: &[Line], phi: f64) -> f64 {
    let sin = phi.sin();
    let least = lines.iter().map(|[slope, height]| slope * sin + height);
    least.fold(f64::INFINITY, f64::min).max(0.0)
}

/// Nodes of Gauss and Legendre on −1..1, ascending.
fn nodes() -> [f64; 8] {
    std::array::from_fn(|m| if m < 4 { -GAUSS[3 - m].0 } else { GAUSS[m - 4].0 })
}

/// Weights of the nodes in ∫ f(x) exp(−i κ x) dx on −1..1, for the polynomial through them.
fn filon(kappa: f64) -> [Complex<f64>; 8] {
    let nodes = nodes();
    let lagrange = |m: usize, x: f64| -> f64 {
        let others = nodes.iter().enumerate().filter(|&(n, _)| n != m);
        others.map(|(_, node)| (x - node) / (nodes[m] - node)).product()
    };
    let mut weights = [Complex::from(0.0); 8];
    integrate([-1.0, 1.0], kappa.max(1.0).recip(), &mut |x, weight| {
        let turn = Complex::cis(-kappa * x) * weight;
        weights.iter_mut().enumerate().for_each(|(m, sum)| *sum += turn * lagrange(m, x));
    });
    weights
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
    let [tangential, radial, axial] = per_width(k, chip_m);
    [-tangential * cos - radial * sin, tangential * sin - radial * cos, -axial]
}

/// Tangential, radial and axial force on an edge per width of a chip, N/m.
pub(super) fn per_width(k: &CuttingCoefficients, chip_m: f64) -> [f64; 3] {
    let (cutting, edge) = (k.cutting_n_per_m2(), k.edge_n_per_m());
    [0, 1, 2].map(|i| {
        let thinner = if k.exponents[i] == 0.0 { 1.0 } else { law(chip_m, k.exponents[i]) };
        cutting[i] * thinner * chip_m + edge[i]
    })
}

/// (h / 1 mm)^−m.
fn law(chip_m: f64, exponent: f64) -> f64 {
    mm_from_m(chip_m).powf(-exponent)
}

/// Coefficients that are linear in the chip: the slope of the force at a mean chip,
/// (1 − m) K h^−m, and the edges as they are.
pub fn linear_about(coefficients: &CuttingCoefficients, mean_chip_m: f64) -> CuttingCoefficients {
    if coefficients.is_linear() {
        return *coefficients;
    }
    let [t, r, a] = coefficients.exponents.map(|m| (1.0 - m) * law(mean_chip_m, m));
    CuttingCoefficients {
        tangential_n_per_m2: t * coefficients.tangential_n_per_m2,
        radial_n_per_m2: r * coefficients.radial_n_per_m2,
        axial: coefficients.axial.map(|[cutting, edge]| [a * cutting, edge]),
        exponents: [0.0; 3],
        ..*coefficients
    }
}
