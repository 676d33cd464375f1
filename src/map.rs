//! Frequencies over poses: by the modal kernel, or from the spectrum of a large free vibration.

use std::fmt;
use std::ops::Range;

use rayon::prelude::*;

use crate::free_vibration::{FreeVibrationFault, Measurement, Settings, measure};
use crate::model::{JointKind, MovingJoint, Robot};
use crate::modes::ModalSolver;

/// How frequencies are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// Eigenvalues of (M, K): small vibrations.
    Linear,
    /// Peaks in the spectrum of the nonlinear free vibration: the paper's Fig. 5.
    Nonlinear(Settings),
}

/// What the columns of a map are.
#[derive(Debug, Clone, PartialEq)]
pub struct Head {
    /// The robot's name.
    pub robot: String,
    /// The moving joints, base to tip.
    pub joints: Vec<JointColumn>,
    /// Whether rows have β2.
    pub has_beta2: bool,
    /// Names of the elastic coordinates, base first; there are as many modes.
    pub coordinates: Vec<String>,
}

/// A joint as a column of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct JointColumn {
    /// URDF name.
    pub name: String,
    /// Whether it turns (rad) or slides (m).
    pub turns: bool,
}

impl Head {
    /// The columns of a map of `robot`.
    pub fn of(robot: &Robot) -> Self {
        let column = |joint: &MovingJoint| JointColumn {
            name: joint.name.clone(),
            turns: joint.kind != JointKind::Prismatic,
        };
        Self {
            robot: robot.name().to_owned(),
            joints: robot.joints().iter().map(column).collect(),
            has_beta2: robot.beta2().is_some(),
            coordinates: robot.coordinates().iter().map(|c| c.name.clone()).collect(),
        }
    }
}

/// The frequencies at one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Joint positions, rad or m, base to tip.
    pub joints: Vec<f64>,
    /// β2 of the two-link model, where the robot defines it, rad.
    pub beta2_rad: Option<f64>,
    /// One per elastic coordinate, ascending, Hz; `None` where a nonlinear record does not show the mode.
    pub frequencies_hz: Vec<Option<f64>>,
    /// What else a nonlinear method found.
    pub nonlinear: Option<Measurement>,
}

/// Which pose has no frequencies, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct MapFault {
    /// Place of the pose in the list, from 0.
    pub index: usize,
    /// Why.
    pub fault: FreeVibrationFault,
}

impl fmt::Display for MapFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "pose {}: {}", self.index + 1, self.fault)
    }
}

impl std::error::Error for MapFault {}

/// Frequencies of `robot` at each of `poses`, in their order; all processors take part.
///
/// # Errors
/// The first pose that has none.
pub fn rows(robot: &Robot, poses: &[Vec<f64>], method: &Method) -> Result<Vec<Row>, MapFault> {
    rows_with_progress(robot, poses, method, &|_| {})
}

/// As [`rows`]; `progress` is told how many more poses are done, from any thread.
///
/// # Errors
/// As [`rows`].
pub fn rows_with_progress(
    robot: &Robot,
    poses: &[Vec<f64>],
    method: &Method,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Vec<Row>, MapFault> {
    let done = |row| {
        progress(1);
        row
    };
    let found: Vec<Result<Row, FreeVibrationFault>> = match method {
        Method::Linear => poses
            .par_iter()
            .map_init(|| ModalSolver::new(robot), |solver, q| done(linear_row(robot, solver, q)))
            .collect(),
        Method::Nonlinear(settings) => {
            poses.par_iter().map(|q| done(nonlinear_row(robot, q, settings))).collect()
        }
    };
    found
        .into_iter()
        .enumerate()
        .map(|(index, row)| row.map_err(|fault| MapFault { index, fault }))
        .collect()
}

/// Poses with the places `range` of a sweep of `steps` poses: joint number `joint` goes from `from` to
/// `to` (rad or m), both included, and the other joints stay as in `at`. One step stays at `from`.
pub fn sweep(
    at: &[f64],
    joint: usize,
    from: f64,
    to: f64,
    steps: usize,
    range: Range<usize>,
) -> Vec<Vec<f64>> {
    let last = steps.saturating_sub(1);
    let position = |step: usize| match step {
        0 => from,
        // Exactly, not as a rounded sum.
        step if step == last => to,
        step => from + (to - from) * (step as f64 / last as f64),
    };
    range
        .map(|step| {
            let mut q = at.to_vec();
            if let Some(value) = q.get_mut(joint) {
                *value = position(step);
            }
            q
        })
        .collect()
}

/// The first joint of the pose that is outside its limits, by place.
pub fn outside_limits(robot: &Robot, q: &[f64]) -> Option<usize> {
    robot.joints().iter().zip(q).position(|(joint, value)| {
        joint.limit.is_some_and(|[lower, upper]| !(lower..=upper).contains(value))
    })
}

fn linear_row(
    robot: &Robot,
    solver: &mut ModalSolver,
    q: &[f64],
) -> Result<Row, FreeVibrationFault> {
    let frequencies_hz = solver.frequencies_hz(q)?.iter().map(|&f| Some(f)).collect();
    Ok(Row {
        joints: q.to_vec(),
        beta2_rad: robot.beta2().map(|beta2| beta2.at(q)),
        frequencies_hz,
        nonlinear: None,
    })
}

fn nonlinear_row(robot: &Robot, q: &[f64], settings: &Settings) -> Result<Row, FreeVibrationFault> {
    let measurement = measure(robot, q, settings)?;
    Ok(Row {
        joints: q.to_vec(),
        beta2_rad: robot.beta2().map(|beta2| beta2.at(q)),
        frequencies_hz: measurement.frequencies_hz.clone(),
        nonlinear: Some(measurement),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_holds_both_ends_exactly() {
        let poses = sweep(&[0.5, 0.0], 1, -0.1, 0.7, 4, 0..4);
        assert_eq!(poses.len(), 4);
        assert_eq!((poses[0][1], poses[3][1]), (-0.1, 0.7));
        assert!(poses.iter().all(|q| q[0] == 0.5));
        assert!((poses[1][1] - (-0.1 + 0.8 / 3.0)).abs() < 1e-15);
        assert_eq!(sweep(&[0.0], 0, 1.0, 2.0, 1, 0..1), [[1.0]]);
        assert_eq!(sweep(&[0.5, 0.0], 1, -0.1, 0.7, 4, 2..4), poses[2..]);
    }
}
