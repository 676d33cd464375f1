//! Modes as the tool tip sees them.

use nalgebra::{Complex, Matrix2x3, Vector3};

use crate::job::TipMode;
use crate::units::rad_per_s_from_hz;

/// A mode in the tool's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolMode {
    /// ω_r, rad/s.
    pub omega_rad_per_s: f64,
    /// ζ_r.
    pub damping_ratio: f64,
    /// φ_r: how the tip moves for a unit of the modal coordinate, 1/√kg.
    pub motion: Vector3<f64>,
}

impl From<&TipMode> for ToolMode {
    fn from(mode: &TipMode) -> Self {
        Self {
            omega_rad_per_s: rad_per_s_from_hz(mode.frequency_hz),
            damping_ratio: mode.damping_ratio,
            motion: mode.axis / mode.mass_kg.sqrt(),
        }
    }
}

impl ToolMode {
    /// 1 / (ω_r² − ω² + 2 i ζ_r ω_r ω).
    pub(crate) fn dynamic(&self, omega: f64) -> Complex<f64> {
        let w = self.omega_rad_per_s;
        Complex::new(w * w - omega * omega, 2.0 * self.damping_ratio * w * omega).inv()
    }

    /// How the tip moves in it at ω, rad/s, where a load pushes its coordinate by `pushed`, N/√kg.
    pub fn moved_m(&self, pushed: Complex<f64>, omega_rad_per_s: f64) -> Vector3<Complex<f64>> {
        let answer = pushed * self.dynamic(omega_rad_per_s);
        self.motion.map(|moved| answer * moved)
    }

    /// What a force on the tip pushes its coordinate by: φ · F, N/√kg.
    pub fn pushed(&self, force_n: &Vector3<Complex<f64>>) -> Complex<f64> {
        let [x, y, z] = self.motion.into();
        force_n.x * x + force_n.y * y + force_n.z * z
    }
}

/// G(iω): displacement of the tip along x and y for a unit force along x, y and z, m/N.
pub fn receptance_m_per_n(modes: &[ToolMode], omega_rad_per_s: f64) -> Matrix2x3<Complex<f64>> {
    let mut sum = Matrix2x3::zeros();
    for mode in modes {
        let dynamic = mode.dynamic(omega_rad_per_s);
        for i in 0..2 {
            for j in 0..3 {
                sum[(i, j)] += dynamic * (mode.motion[i] * mode.motion[j]);
            }
        }
    }
    sum
}

/// G(iω) F: displacement of the tip in x, y and z under a force, m.
pub fn displacement_m(
    modes: &[ToolMode],
    force_n: &Vector3<Complex<f64>>,
    omega_rad_per_s: f64,
) -> Vector3<Complex<f64>> {
    modes.iter().map(|mode| mode.moved_m(mode.pushed(force_n), omega_rad_per_s)).sum()
}
