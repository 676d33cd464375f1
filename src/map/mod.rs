//! Frequencies over poses: by the modal kernel, or from the spectrum of a large free vibration.

mod generate;
mod limits;
mod linear;
mod reduce;

use std::fmt;

use rayon::prelude::*;

pub use generate::{Generator, Grid, GridAxis, RandomPoses};
pub use limits::OutsideLimits;
pub use linear::{Block, LinearMap};
pub use reduce::{
    Bin, EXACT_UP_TO, Extreme, RESOLUTION, Reduced, ReducedMode, Reduction, SHARES, Statistic,
};

use crate::free_vibration::{FreeVibrationFault, Measurement, Settings, measure};
use crate::model::{JointKind, MovingJoint, PoseFault, Robot};

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
    match method {
        Method::Linear => linear_rows(robot, poses).inspect(|rows| progress(rows.len())),
        Method::Nonlinear(settings) => {
            let row = |q: &Vec<f64>| {
                let row = nonlinear_row(robot, q, settings);
                progress(1);
                row
            };
            let found: Vec<Result<Row, FreeVibrationFault>> = poses.par_iter().map(row).collect();
            found
                .into_iter()
                .enumerate()
                .map(|(index, row)| row.map_err(|fault| MapFault { index, fault }))
                .collect()
        }
    }
}

fn linear_rows(robot: &Robot, poses: &[Vec<f64>]) -> Result<Vec<Row>, MapFault> {
    let map = LinearMap::new(robot);
    let expected = map.joints();
    if let Some(index) = poses.iter().position(|q| q.len() != expected) {
        let fault = PoseFault::Length { given: poses[index].len(), expected };
        return Err(MapFault { index, fault: fault.into() });
    }
    let mut frequencies_hz = Vec::new();
    map.par_solve(poses.len(), &poses.concat(), &mut frequencies_hz)?;
    let rows = poses.iter().zip(frequencies_hz.chunks_exact(map.modes()));
    Ok(rows
        .map(|(q, frequencies_hz)| Row {
            joints: q.clone(),
            beta2_rad: robot.beta2().map(|beta2| beta2.at(q)),
            frequencies_hz: frequencies_hz.iter().map(|&f| Some(f)).collect(),
            nonlinear: None,
        })
        .collect())
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
