//! What the tool tip does: receptance, and each mode's part in it.

use nalgebra::{Complex, Matrix6xX, Unit, Vector3};

use super::solver::Modes;
use crate::model::Robot;
use crate::units::rad_per_s_from_hz;

/// G(ω) = Σ_r (dᵀ J φ_r)² / (ω_r² − ω² + 2 i ζ_r ω_r ω) at the point of `tip_jacobian`, m/N:
/// displacement along `direction` for a unit force along it, at `frequency_hz`.
///
/// `tip_jacobian` is 6 × n ([`crate::model::elastic_jacobian`]), at the pose of `modes`.
pub fn tip_receptance_m_per_n(
    modes: &Modes,
    tip_jacobian: &Matrix6xX<f64>,
    direction: &Unit<Vector3<f64>>,
    frequency_hz: f64,
) -> Complex<f64> {
    let omega = rad_per_s_from_hz(frequency_hz);
    (0..modes.natural_frequencies_hz.len())
        .map(|r| {
            let omega_r = rad_per_s_from_hz(modes.natural_frequencies_hz[r]);
            let moved = direction.dot(&tip_motion(modes, tip_jacobian, r));
            let dynamic = Complex::new(
                omega_r * omega_r - omega * omega,
                2.0 * modes.damping_ratios[r] * omega_r * omega,
            );
            Complex::from(moved * moved) / dynamic
        })
        .sum()
}

/// |J φ_r|² / (2 ζ_r ω_r²), m/N: what mode `r` alone moves the tool tip at its own resonance,
/// in the direction in which it moves it most, for a unit force along that direction.
///
/// `tip_jacobian` is 6 × n, at the pose of `modes`.
pub fn peak_tip_compliance_m_per_n(modes: &Modes, tip_jacobian: &Matrix6xX<f64>, r: usize) -> f64 {
    let omega_r = rad_per_s_from_hz(modes.natural_frequencies_hz[r]);
    tip_motion(modes, tip_jacobian, r).norm_squared()
        / (2.0 * modes.damping_ratios[r] * omega_r * omega_r)
}

/// The same of every mode of `robot`. What the mode of a part that hangs on the arm does to the
/// tool tip nobody measured, and its mass is the least known: as much as the mode that moves it
/// most.
pub fn peak_tip_compliances_m_per_n(
    robot: &Robot,
    modes: &Modes,
    tip_jacobian: &Matrix6xX<f64>,
    out: &mut [f64],
) {
    for (r, of_mode) in out.iter_mut().enumerate() {
        *of_mode = peak_tip_compliance_m_per_n(modes, tip_jacobian, r);
    }
    if !robot.has_hung_parts() {
        return;
    }
    let loudest = out.iter().copied().fold(0.0, f64::max);
    for (r, of_mode) in out.iter_mut().enumerate() {
        // φᵀ K φ = ω².
        let omega_r = rad_per_s_from_hz(modes.natural_frequencies_hz[r]);
        let hung = robot.coordinates().iter().enumerate().filter(|(_, own)| own.is_hung);
        let of_parts: f64 = hung.map(|(i, own)| own.stiffness * modes.shapes[(i, r)].powi(2)).sum();
        if of_parts > 0.5 * omega_r * omega_r {
            *of_mode = loudest;
        }
    }
}

/// J φ_r, the translational part.
fn tip_motion(modes: &Modes, tip_jacobian: &Matrix6xX<f64>, r: usize) -> Vector3<f64> {
    let shape = modes.shapes.column(r);
    (0..shape.len())
        .fold(Vector3::zeros(), |sum, i| sum + tip_jacobian.fixed_view::<3, 1>(0, i) * shape[i])
}
