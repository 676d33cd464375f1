//! The planar two-link arm of Pietruś & Gierlak, "Influence of the manipulator configuration on
//! vibration effects", acta mechanica et automatica 17 (2023), doi 10.2478/ama-2023-0060, in closed form.
//!
//! Two rigid links in a vertical plane on two torsional springs; β1 from the horizontal, β2 from link 1,
//! both counter-clockwise. It shares nothing with `model` and `modes` and so serves as a
//! check on both.
//!
//! Where the printed text is not right, this module follows the mechanics:
//! - Eqs. (24) and (25) give the first term of the energy as ½ [… + m2 l1 lc2 cos(β2 + α2)] α̇1²; from
//!   Eq. (23) it must be 2 m2 l1 lc2, as Eqs. (27) and (30) have it again.
//! - Eqs. (12)–(13) are right, but Eq. (14) does not follow from "omitting α_st²": the terms linear in α
//!   cancel, the constants are dropped, and the curvature of gravity was lost already in (7)–(8). It is
//!   kept in [`TwoLink::gravity_stiffness_nm_per_rad`], and with it frequencies depend on β1.
//! - The second line of Eq. (19) must read q̇2.
//! - Table 1 put into Eq. (45) does not give Fig. 3 or Table 2. At β2 = 0.174, 1.571, 2.618 rad it gives
//!   f1 = 21.88, 25.76, 28.77 Hz and f2 = 413.24, 84.18, 144.68 Hz, where Table 2 has 19.84, 23.33,
//!   26.58 Hz and 58.77, 41.60, 41.14 Hz. With Table 1 f2 falls only as far as |β2| = 99.2°, where M12 = 0,
//!   and then rises again; the text after Fig. 3 says that it falls all the way.
//! - "The first mode turns the links in the same direction, the second in opposite directions" (Fig. 4):
//!   see [`TwoLink::modes`] for what holds with Table 1.

#![allow(dead_code, reason = "each test uses a part")]

use std::f64::consts::PI;

use nalgebra::{Matrix2, Vector2};

use detune::units::hz_from_rad_per_s;

/// Parameters of the arm: Table 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TwoLink {
    /// I_A of link 1 about joint A, kg·m².
    pub(crate) link1_inertia_kgm2: f64,
    /// I_S2 of link 2 about its centre of mass, kg·m².
    pub(crate) link2_inertia_kgm2: f64,
    /// m2, kg.
    pub(crate) link2_mass_kg: f64,
    /// l1, from joint A to joint B, m.
    pub(crate) link1_length_m: f64,
    /// lc2, from joint B to the centre of mass of link 2, m.
    pub(crate) link2_com_m: f64,
    /// k1, k2, N·m/rad.
    pub(crate) stiffness_nm_per_rad: [f64; 2],
}

/// What gravity adds, and Table 1 does not tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TwoLinkGravity {
    /// m1 lc1 of link 1, kg·m.
    pub(crate) link1_first_moment_kgm: f64,
    /// g, m/s².
    pub(crate) gravity_m_per_s2: f64,
}

/// Table 1 of the paper: joints 2 and 3 of an ABB IRB 1600.
pub(crate) const TABLE_1: TwoLink = TwoLink {
    link1_inertia_kgm2: 0.55,
    link2_inertia_kgm2: 0.0009,
    link2_mass_kg: 50.58,
    link1_length_m: 0.63,
    link2_com_m: 0.1,
    stiffness_nm_per_rad: [555_000.0, 138_000.0],
};

/// β1 of Table 1, rad.
pub(crate) const TABLE_1_BETA1_RAD: f64 = 2.0 * PI / 3.0;

/// The two modes of the arm at one β2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TwoLinkModes {
    /// f1, f2 of Eq. (45), Hz, ascending.
    pub(crate) natural_frequencies_hz: [f64; 2],
    /// Amplitudes (A1, A2) of Eq. (42) for either mode, scaled to the larger being 1 in size and positive.
    pub(crate) shapes: [Vector2<f64>; 2],
}

impl TwoLink {
    /// a1, a2, a3 of Eq. (33), kg·m².
    pub(crate) fn inertia_terms_kgm2(&self) -> [f64; 3] {
        let Self { link2_mass_kg: m2, link1_length_m: l1, link2_com_m: lc2, .. } = *self;
        let a3 = self.link2_inertia_kgm2 + m2 * lc2 * lc2;
        [self.link1_inertia_kgm2 + a3 + m2 * l1 * l1, m2 * l1 * lc2, a3]
    }

    /// M of Eq. (30) at q2 = β2 + α2, kg·m².
    pub(crate) fn mass_matrix_kgm2(&self, q2_rad: f64) -> Matrix2<f64> {
        let [a1, a2, a3] = self.inertia_terms_kgm2();
        let cos = q2_rad.cos();
        let coupled = a3 + a2 * cos;
        Matrix2::new(a1 + 2.0 * a2 * cos, coupled, coupled, a3)
    }

    /// C of Eq. (31) at q2 = β2 + α2 and the rates α̇: C α̇ are the centrifugal and Coriolis torques.
    pub(crate) fn velocity_matrix_nms(
        &self,
        q2_rad: f64,
        rates_rad_per_s: &Vector2<f64>,
    ) -> Matrix2<f64> {
        let [_, a2, _] = self.inertia_terms_kgm2();
        let s = a2 * q2_rad.sin();
        let (r1, r2) = (rates_rad_per_s[0], rates_rad_per_s[1]);
        Matrix2::new(-s * r2, -s * (r1 + r2), s * r1, 0.0)
    }

    /// K of Eq. (32), N·m/rad.
    pub(crate) fn stiffness_matrix_nm_per_rad(&self) -> Matrix2<f64> {
        Matrix2::from_diagonal(&Vector2::from(self.stiffness_nm_per_rad))
    }

    /// α̈ of Eq. (46), rad/s².
    pub(crate) fn acceleration_rad_per_s2(
        &self,
        beta2_rad: f64,
        alpha_rad: &Vector2<f64>,
        rates_rad_per_s: &Vector2<f64>,
    ) -> Vector2<f64> {
        let q2 = beta2_rad + alpha_rad[1];
        let m = self.mass_matrix_kgm2(q2);
        let torque = -(self.velocity_matrix_nms(q2, rates_rad_per_s) * rates_rad_per_s
            + self.stiffness_matrix_nm_per_rad() * alpha_rad);
        let determinant = self.determinant(q2);
        Vector2::new(
            (m[(1, 1)] * torque[0] - m[(0, 1)] * torque[1]) / determinant,
            (m[(0, 0)] * torque[1] - m[(0, 1)] * torque[0]) / determinant,
        )
    }

    /// f1, f2 of Eq. (45), Hz, ascending.
    ///
    /// The equation is written as sums of positive terms, so that no digit is lost where the printed
    /// form subtracts nearly equal numbers: d2 = I_A a3 + m2 l1² (I_S2 + m2 lc2² sin² β2), the
    /// discriminant d1² − 4 d2 k1 k2 = (M11 k2 − a3 k1)² + 4 k1 k2 M12², and the smaller root from the
    /// product of the two, k1 k2 / d2.
    pub(crate) fn natural_frequencies_hz(&self, beta2_rad: f64) -> [f64; 2] {
        self.squared_frequencies(beta2_rad).map(|squared| hz_from_rad_per_s(squared.sqrt()))
    }

    /// Frequencies and shapes at β2, Eqs. (42) and (45).
    ///
    /// "Same direction" has two readings. For the relative angles α1, α2 the product A1 A2 has the sign of
    /// M12 = a3 + a2 cos β2 in the first mode and the opposite sign in the second: with Table 1 the
    /// first mode has them together and the second opposed where |β2| < 99.2°, and the reverse beyond. For the
    /// turns of the links in space, α1 and α1 + α2, which is what a camera sees, Table 1 has the first mode
    /// together at every β2, and the second opposed where |β2| < 99.2° and together beyond.
    pub(crate) fn modes(&self, beta2_rad: f64) -> TwoLinkModes {
        let squared = self.squared_frequencies(beta2_rad);
        let m = self.mass_matrix_kgm2(beta2_rad);
        let [k1, k2] = self.stiffness_nm_per_rad;
        let (p, q, c) = (self.first_diagonal(beta2_rad) * k2, m[(1, 1)] * k1, m[(0, 1)]);
        // In y = K^½ A the problem is that of the symmetric matrix [p, s; s, q] / (k1 k2): one angle.
        let angle = 0.5 * f64::atan2(2.0 * c * (k1 * k2).sqrt(), p - q);
        let (sin, cos) = angle.sin_cos();
        let shape = |y1: f64, y2: f64| {
            let a = Vector2::new(y1 / k1.sqrt(), y2 / k2.sqrt());
            let largest = if a[0].abs() >= a[1].abs() { a[0] } else { a[1] };
            a / largest
        };
        TwoLinkModes {
            natural_frequencies_hz: squared.map(|s| hz_from_rad_per_s(s.sqrt())),
            shapes: [shape(cos, sin), shape(-sin, cos)],
        }
    }

    /// α1st, α2st of Eqs. (12)–(13), rad: how far gravity bends the joints at rest.
    pub(crate) fn static_deflections_rad(
        &self,
        gravity: &TwoLinkGravity,
        beta1_rad: f64,
        beta2_rad: f64,
    ) -> [f64; 2] {
        let [upper, fore] = self.gravity_moments_nm(gravity);
        let [k1, k2] = self.stiffness_nm_per_rad;
        let fore_moment = fore * (beta1_rad + beta2_rad).cos();
        [-(upper * beta1_rad.cos() + fore_moment) / k1, -fore_moment / k2]
    }

    /// V_g1 + V_g2 of Eqs. (5)–(6) at the angles q1 = β1 + α1, q2 = β2 + α2, J; exact, not linearised.
    pub(crate) fn gravity_potential_j(
        &self,
        gravity: &TwoLinkGravity,
        q1_rad: f64,
        q2_rad: f64,
    ) -> f64 {
        let [upper, fore] = self.gravity_moments_nm(gravity);
        upper * q1_rad.sin() + fore * (q1_rad + q2_rad).sin()
    }

    /// K_g, N·m/rad: the second derivatives of Eqs. (5)–(6), which the linearisation (7)–(8) drops. It
    /// adds to K.
    pub(crate) fn gravity_stiffness_nm_per_rad(
        &self,
        gravity: &TwoLinkGravity,
        beta1_rad: f64,
        beta2_rad: f64,
    ) -> Matrix2<f64> {
        let [upper, fore] = self.gravity_moments_nm(gravity);
        let outer = -fore * (beta1_rad + beta2_rad).sin();
        Matrix2::new(outer - upper * beta1_rad.sin(), outer, outer, outer)
    }

    /// (m1 lc1 + m2 l1) g and m2 lc2 g.
    fn gravity_moments_nm(&self, gravity: &TwoLinkGravity) -> [f64; 2] {
        let Self { link2_mass_kg: m2, link1_length_m: l1, link2_com_m: lc2, .. } = *self;
        let g = gravity.gravity_m_per_s2;
        [(gravity.link1_first_moment_kgm + m2 * l1) * g, m2 * lc2 * g]
    }

    /// M11 = a1 + 2 a2 cos q2 as a sum of positive terms.
    fn first_diagonal(&self, q2_rad: f64) -> f64 {
        let (sin, cos) = q2_rad.sin_cos();
        let along = self.link1_length_m + self.link2_com_m * cos;
        let across = self.link2_com_m * sin;
        self.link1_inertia_kgm2
            + self.link2_inertia_kgm2
            + self.link2_mass_kg * (along * along + across * across)
    }

    /// d2 = det M as a sum of positive terms.
    fn determinant(&self, q2_rad: f64) -> f64 {
        let [_, _, a3] = self.inertia_terms_kgm2();
        let Self { link2_mass_kg: m2, link1_length_m: l1, link2_com_m: lc2, .. } = *self;
        let across = lc2 * q2_rad.sin();
        self.link1_inertia_kgm2 * a3
            + m2 * l1 * l1 * (self.link2_inertia_kgm2 + m2 * across * across)
    }

    /// ω1², ω2², the roots of Eq. (44).
    fn squared_frequencies(&self, beta2_rad: f64) -> [f64; 2] {
        let [k1, k2] = self.stiffness_nm_per_rad;
        let [_, _, a3] = self.inertia_terms_kgm2();
        let (p, q) = (self.first_diagonal(beta2_rad) * k2, a3 * k1);
        let coupled = self.mass_matrix_kgm2(beta2_rad)[(0, 1)];
        let root = f64::hypot(p - q, 2.0 * (k1 * k2).sqrt() * coupled);
        let sum = p + q + root;
        [2.0 * k1 * k2 / sum, 0.5 * sum / self.determinant(beta2_rad)]
    }
}
