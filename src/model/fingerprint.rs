//! By what a calibration knows the model that it was written for.

use nalgebra::DMatrix;

use super::correction::Conditions;
use super::inertia::{mass_matrix, stiffness_matrix};
use super::placement::Placement;
use super::posterior::Fingerprint;
use super::robot::Robot;
use crate::wording::rounded;

impl Fingerprint {
    /// At joint positions `q`, rad or m; `None` where a figure is not positive.
    pub fn of(robot: &Robot, q: &[f64]) -> Option<Self> {
        /// More than a change by hand leaves alone.
        const DIGITS: i32 = 8;
        let n = robot.coordinates().len();
        let mut placement = Placement::new(robot);
        placement.place(robot, q);
        let (mut mass, mut stiffness) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        mass_matrix(robot, &placement, &mut mass);
        stiffness_matrix(robot, &placement, &Conditions::default(), &mut stiffness);
        let diagonal =
            |matrix: DMatrix<f64>| -> Option<Vec<f64>> {
                let is_sound = |value: &f64| value.is_finite() && *value > 0.0;
                matrix.diagonal().iter().all(is_sound).then(|| {
                    matrix.diagonal().iter().map(|value| rounded(*value, DIGITS)).collect()
                })
            };
        Some(Self { mass_diagonal: diagonal(mass)?, stiffness_diagonal: diagonal(stiffness)? })
    }
}
