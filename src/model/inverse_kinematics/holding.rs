//! Joint positions with some joints held: external axes that a program places itself.

use nalgebra::Isometry3;

use super::descent::Descent;
use super::{
    IkFault, InverseKinematics, SAME, SEARCHING_STEPS, start, turn_towards, within_limits,
    worst_excess,
};
use crate::model::Robot;

/// Starting poses that are tried for a first target.
const MAX_STARTS: usize = 60;

impl InverseKinematics {
    /// As [`Self::near`], with the joints marked in `held` as they are in `seed`.
    ///
    /// # Errors
    /// [`IkFault`]: the seed's own branch does not lead to the pose, or leads past a limit.
    pub fn near_holding(
        &self,
        robot: &Robot,
        tip_pose: &Isometry3<f64>,
        seed: &[f64],
        held: &[bool],
    ) -> Result<Vec<f64>, IkFault> {
        robot.check_pose(seed).and_then(|()| self.check_robot(robot)).map_err(IkFault::Seed)?;
        let mut descent = Descent::new(robot, &self.scale);
        let mut q = seed.to_vec();
        let miss = descent.run(tip_pose, &mut q, held, SEARCHING_STEPS);
        if miss.is_reached(&self.scale) {
            return within_limits(robot, q);
        }
        Err(IkFault::OutOfReach { distance_m: miss.distance_m, angle_rad: miss.angle_rad })
    }

    /// Joint positions within limits that bring the tip frame to `tip_pose` in the base frame with
    /// the joints marked in `held` as they are in `seed`; the nearest to it first. One may be
    /// missed.
    pub fn solutions_holding(
        &self,
        robot: &Robot,
        tip_pose: &Isometry3<f64>,
        seed: &[f64],
        held: &[bool],
    ) -> Vec<Vec<f64>> {
        if robot.check_pose(seed).is_err() || self.check_robot(robot).is_err() {
            return Vec::new();
        }
        let mut descent = Descent::new(robot, &self.scale);
        let mut found: Vec<Vec<f64>> = Vec::new();
        for index in 0..=MAX_STARTS {
            let mut q = match index.checked_sub(1) {
                None => seed.to_vec(),
                Some(index) => start(robot, &self.scale, index),
            };
            for ((q, seed), _) in q.iter_mut().zip(seed).zip(held).filter(|(_, held)| **held) {
                *q = *seed;
            }
            if !descent.run(tip_pose, &mut q, held, SEARCHING_STEPS).is_reached(&self.scale) {
                continue;
            }
            turn_towards(robot, &mut q, seed);
            let is_new = !found.iter().any(|other| self.distance(other, &q) < SAME);
            if is_new && worst_excess(robot, &q).is_none() {
                found.push(q);
            }
        }
        found.sort_by(|a, b| self.distance(a, seed).total_cmp(&self.distance(b, seed)));
        found
    }
}
