//! Mode shapes of a pose, as plain numbers.

use nalgebra::Vector3;
use serde::Serialize;

use crate::model::{PoseFault, Robot, link_rotation};
use crate::modes::ModalSolver;

/// The shape of one mode at one pose, mass-normalised: φᵀ M φ = 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ModeShape<'a> {
    /// Amplitude of each elastic coordinate: 1/√(kg·m²) where it turns, 1/√kg where it slides.
    pub phi: &'a [f64],
    /// How far each link turns with it against the ground, about x, y and z of the base,
    /// 1/√(kg·m²).
    pub link_rotations: &'a [[f64; 3]],
    /// Share of each elastic coordinate in the strain energy; they add up to one.
    pub strain_energy_shares: &'a [f64],
}

/// The links that have rotations: those with mass, base to tip.
pub(super) fn links(robot: &Robot) -> Vec<String> {
    let own = robot.bodies().iter().filter(|body| !body.is_payload);
    own.map(|body| body.link.clone()).collect()
}

/// Appends the shapes of all modes at a pose to `out`, each with its largest share of the strain
/// energy in a positive amplitude.
pub(super) fn append(
    robot: &Robot,
    links: &[String],
    solver: &mut ModalSolver,
    q: &[f64],
    out: &mut Vec<f64>,
) -> Result<(), PoseFault> {
    solver.solve(q)?;
    let (modes, placement) = (solver.modes(), solver.placement());
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    // One row per link and axis, over the elastic coordinates.
    let turns: Vec<Vec<f64>> = links
        .iter()
        .flat_map(|link| axes.map(|axis| link_rotation(robot, placement, link, Some(axis))))
        .map(|turns| turns.unwrap_or_else(|| vec![0.0; robot.coordinates().len()]))
        .collect();
    for (r, phi) in modes.shapes.column_iter().enumerate() {
        let shares = solver.strain_energy_shares(r);
        let largest = shares.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let sign = largest.map_or(1.0, |(i, _)| phi[i].signum());
        // No negative zero.
        out.extend(phi.iter().map(|value| value * sign + 0.0));
        let turned = |row: &Vec<f64>| {
            row.iter().zip(phi.iter()).map(|(turn, value)| turn * value * sign).sum::<f64>() + 0.0
        };
        out.extend(turns.iter().map(turned));
        out.extend(shares);
    }
    Ok(())
}

/// The shapes of a pose, mode by mode, of as many modes as coordinates.
pub(super) fn read(values: &[f64], coordinates: usize) -> impl Iterator<Item = ModeShape<'_>> {
    values.chunks_exact((values.len() / coordinates.max(1)).max(1)).map(move |mode| {
        let (phi, rest) = mode.split_at(coordinates);
        let (turns, strain_energy_shares) = rest.split_at(rest.len() - coordinates);
        ModeShape { phi, link_rotations: turns.as_chunks().0, strain_energy_shares }
    })
}
