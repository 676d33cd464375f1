//! Inverse kinematics of one pose after the other: the buffers are made once.

use nalgebra::Isometry3;

use super::descent::Descent;
use super::{
    IkFault, InverseKinematics, ON_BRANCH, SEARCHING_STEPS, turn_towards, within_limits,
    worst_excess,
};
use crate::model::robot::Robot;

/// Solves pose after pose of one robot.
#[derive(Debug, Clone)]
pub struct Solver<'a> {
    kinematics: &'a InverseKinematics,
    robot: &'a Robot,
    descent: Descent<'a>,
}

impl InverseKinematics {
    /// For many poses of `robot`, each as [`Self::near`] and [`Self::side_if_regular`] have it.
    pub fn solver<'a>(&'a self, robot: &'a Robot) -> Solver<'a> {
        Solver { kinematics: self, robot, descent: Descent::new(robot, &self.scale) }
    }
}

impl Solver<'_> {
    /// Pose of the tip at `q`, a pose of the robot.
    pub fn tip(&mut self, q: &[f64]) -> Isometry3<f64> {
        self.descent.tip(q)
    }

    /// See [`InverseKinematics::near`].
    ///
    /// # Errors
    /// As there.
    pub fn near(&mut self, tip_pose: &Isometry3<f64>, seed: &[f64]) -> Result<Vec<f64>, IkFault> {
        let Self { kinematics, robot, descent } = self;
        let (kinematics, robot, scale) = (*kinematics, *robot, &kinematics.scale);
        robot
            .check_pose(seed)
            .and_then(|()| kinematics.check_robot(robot))
            .map_err(IkFault::Seed)?;
        if !super::is_finite(tip_pose) {
            return Err(IkFault::TargetNotFinite);
        }
        let mut q = seed.to_vec();
        let miss = descent.run(tip_pose, &mut q, &[], SEARCHING_STEPS);
        let is_reached = miss.is_reached(scale);
        if is_reached {
            kinematics.keep_limits(robot, tip_pose, descent, &mut q);
            if kinematics.distance(&q, seed) <= ON_BRANCH {
                return within_limits(robot, q);
            }
        }
        let (mut candidates, other_miss) = kinematics.branches(robot, tip_pose, descent);
        if is_reached {
            candidates.push(q);
        }
        for q in &mut candidates {
            turn_towards(robot, q, seed);
        }
        let distance = |q: &[f64]| kinematics.distance(q, seed);
        candidates.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        let inside = candidates.iter().position(|q| worst_excess(robot, q).is_none());
        match candidates.into_iter().nth(inside.unwrap_or(0)) {
            Some(q) => within_limits(robot, q),
            None => {
                let other =
                    other_miss.unwrap_or_else(|| kinematics.nearest_miss(robot, tip_pose, descent));
                let nearest = if other.norm(scale) < miss.norm(scale) { other } else { miss };
                Err(IkFault::OutOfReach {
                    distance_m: nearest.distance_m,
                    angle_rad: nearest.angle_rad,
                })
            }
        }
    }

    /// See [`InverseKinematics::side_if_regular`].
    ///
    /// The other five singular values multiply to no more than (‖J‖² / 5)^(5/2), ‖J‖ of Frobenius.
    pub fn side_if_regular(&mut self, q: &[f64], least: f64) -> Option<bool> {
        /// Far more than the rounding of determinant and norm.
        const SURE: f64 = 2.0;
        let checked = self.robot.check_pose(q);
        checked.and_then(|()| self.kinematics.check_robot(self.robot)).ok()?;
        if q.len() != 6 {
            return None;
        }
        let scaled = self.descent.jacobian_at(q);
        let others = (scaled.norm_squared() / 5.0).powf(2.5);
        let determinant = scaled.fixed_columns::<6>(0).into_owned().determinant();
        // The scales are positive.
        (determinant.abs() > SURE * least * others).then_some(determinant > 0.0)
    }
}
