//! Linear maps by the batch kernel: poses and results as plain numbers, pose after pose.

use super::{MapFault, OutsideLimits};
use crate::model::{PoseFault, Robot};
use crate::modes::batch::{BatchFault, Kernel};

/// Finds natural frequencies of one robot at many poses; shared between threads as it is.
#[derive(Debug, Clone)]
pub struct LinearMap<'a> {
    robot: &'a Robot,
    kernel: Kernel<'a>,
}

/// Poses with their frequencies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block<'a> {
    /// How many poses.
    pub count: usize,
    /// Joint positions, rad or m, base to tip, pose after pose.
    pub poses: &'a [f64],
    /// β2 of the two-link model, rad, one a pose; empty where the robot does not define it.
    pub beta2_rad: &'a [f64],
    /// Natural frequencies, Hz, ascending, pose after pose.
    pub frequencies_hz: &'a [f64],
}

impl<'a> LinearMap<'a> {
    /// A map of `robot` with the machine's best instructions.
    pub fn new(robot: &'a Robot) -> Self {
        Self { robot, kernel: Kernel::new(robot) }
    }

    /// Values of a pose.
    pub fn joints(&self) -> usize {
        self.robot.joints().len()
    }

    /// Frequencies of a pose.
    pub fn modes(&self) -> usize {
        self.robot.coordinates().len()
    }

    /// Natural frequencies of `count` poses (rad or m, base to tip, pose after pose) on this thread: they
    /// take the place of what `frequencies_hz` holds.
    ///
    /// # Errors
    /// The first pose that has none.
    pub fn solve(
        &self,
        count: usize,
        poses: &[f64],
        frequencies_hz: &mut Vec<f64>,
    ) -> Result<(), MapFault> {
        frequencies_hz.resize(count * self.modes(), 0.0);
        self.told(self.kernel.frequencies_hz(poses, frequencies_hz))
    }

    /// [`Self::solve`] on all threads of rayon's pool, to the same bits.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn par_solve(
        &self,
        count: usize,
        poses: &[f64],
        frequencies_hz: &mut Vec<f64>,
    ) -> Result<(), MapFault> {
        frequencies_hz.resize(count * self.modes(), 0.0);
        self.told(self.kernel.par_frequencies_hz(poses, frequencies_hz))
    }

    fn told(&self, result: Result<(), BatchFault>) -> Result<(), MapFault> {
        let length = |given| PoseFault::Length { given, expected: self.joints() };
        result.map_err(|fault| match fault {
            BatchFault::Pose { pose, fault } => MapFault { index: pose, fault: fault.into() },
            BatchFault::Poses { given, .. } | BatchFault::Room { given, .. } => {
                MapFault { index: 0, fault: length(given).into() }
            }
        })
    }

    /// β2 of each pose into `beta2_rad`, in place of what it holds; nothing where the robot does not define it.
    pub fn beta2(&self, poses: &[f64], beta2_rad: &mut Vec<f64>) {
        beta2_rad.clear();
        if let Some(beta2) = self.robot.beta2() {
            beta2_rad.extend(poses.chunks_exact(self.joints().max(1)).map(|q| beta2.at(q)));
        }
    }

    /// Which of the poses lie outside the joint limits.
    pub fn outside_limits(&self, poses: &[f64]) -> OutsideLimits {
        let mut outside = OutsideLimits::default();
        poses.chunks_exact(self.joints().max(1)).for_each(|q| outside.look_at(self.robot, q));
        outside
    }
}
