//! Damped least squares from a starting pose (Levenberg–Marquardt with damping in proportion to the
//! squared error, which keeps convergence quadratic even where the Jacobian is singular: Yamashita
//! & Fukushima 2001; for arms, Sugihara, IEEE T-RO 27 (2011) 984). The step of a redundant arm is
//! the shortest one.

use nalgebra::{Isometry3, Matrix6, Matrix6xX, Point3, Vector3, Vector6};

use crate::model::placement::Placement;
use crate::model::robot::Robot;
use crate::model::tip::{forward_kinematics, joint_jacobian};

/// A pose is reached when position (m, for an arm up to one metre; longer arms in proportion) and
/// orientation (rad) are off by no more: a thousand times the rounding of one evaluation.
const REACHED: f64 = 1e-12;

/// Iteration ends below this, as rounding allows little better.
const EXACT: f64 = 2e-14;

/// Damping never falls below this: the rounding of J Jᵀ where it is singular.
const MIN_DAMPING: f64 = 1e-14;

/// No joint turns farther in one step (rad, or as a share of the arm's length), so that the
/// linearisation means something.
const MAX_STEP: f64 = 1.0;

/// A start is given up after so many steps that each took away less than `SLOW` of the error.
const SLOW_STEPS: usize = 4;
const SLOW: f64 = 1e-3;

/// What makes the rows and columns of J comparable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    /// Unit of position errors and of sliding joints, m.
    pub(super) length_m: f64,
    /// One unit of each joint: 1 rad or `length_m`.
    pub(super) joints: Vec<f64>,
}

/// How far the tip is from where it should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Residual {
    pub(super) distance_m: f64,
    pub(super) angle_rad: f64,
}

impl Residual {
    pub(super) fn is_reached(&self, scale: &Scale) -> bool {
        self.distance_m <= REACHED * scale.length_m.max(1.0) && self.angle_rad <= REACHED
    }

    /// Size without unit.
    pub(super) fn norm(&self, scale: &Scale) -> f64 {
        (self.distance_m / scale.length_m).hypot(self.angle_rad)
    }
}

/// Buffers of the iteration.
#[derive(Debug, Clone)]
pub(super) struct Descent<'a> {
    robot: &'a Robot,
    scale: &'a Scale,
    placement: Placement,
    /// Where the robot is placed.
    placed: Vec<f64>,
    jacobian: Matrix6xX<f64>,
    trial: Vec<f64>,
    step: Vec<f64>,
}

impl<'a> Descent<'a> {
    pub(super) fn new(robot: &'a Robot, scale: &'a Scale) -> Self {
        let n = robot.joints().len();
        let (mut placement, placed) = (Placement::new(robot), vec![0.0; n]);
        placement.place_joints(robot, &placed);
        Self {
            robot,
            scale,
            placement,
            placed,
            jacobian: Matrix6xX::zeros(n),
            trial: vec![0.0; n],
            step: vec![0.0; n],
        }
    }

    /// Moves `q` until the tip is at `target`, or as near to it as this start leads within
    /// `iterations`. Joints marked in `held` stay; none are if it is empty.
    pub(super) fn run(
        &mut self,
        target: &Isometry3<f64>,
        q: &mut [f64],
        held: &[bool],
        iterations: usize,
    ) -> Residual {
        let mut error = self.error(target, q);
        let mut is_linear_here = false;
        let mut caution = 0.1;
        let mut slow = 0;
        for _ in 0..iterations {
            let size = error.norm();
            if size <= EXACT || slow >= SLOW_STEPS {
                break;
            }
            if !is_linear_here {
                self.linearise(held);
                is_linear_here = true;
            }
            let damping = caution * size * size + MIN_DAMPING;
            let next = self.solve(&error, damping).map(|()| {
                for (i, trial) in self.trial.iter_mut().enumerate() {
                    *trial = q[i] + self.step[i];
                }
                let trial = std::mem::take(&mut self.trial);
                let next = self.error(target, &trial);
                self.trial = trial;
                next
            });
            match next {
                Some(next) if next.norm() < size => {
                    slow = if next.norm() > (1.0 - SLOW) * size { slow + 1 } else { 0 };
                    q.copy_from_slice(&self.trial);
                    error = next;
                    caution = (caution / 5.0).max(1e-3);
                    is_linear_here = false;
                }
                // At the bottom of the valley rounding decides.
                _ if self.residual(&error).is_reached(self.scale) => break,
                _ if caution > 1e10 => break,
                _ => caution *= 10.0,
            }
        }
        self.residual(&error)
    }

    /// A path asks for a pose again and again: where it ends, where it goes on, and beside
    /// singularities.
    fn place(&mut self, q: &[f64]) {
        if self.placed != q {
            self.placement.place_joints(self.robot, q);
            self.placed.copy_from_slice(q);
        }
    }

    /// Pose of the tip at `q`.
    pub(super) fn tip(&mut self, q: &[f64]) -> Isometry3<f64> {
        self.place(q);
        forward_kinematics(self.robot, &self.placement)
    }

    /// Scaled J at `q`.
    pub(super) fn jacobian_at(&mut self, q: &[f64]) -> &Matrix6xX<f64> {
        self.place(q);
        self.linearise(&[]);
        &self.jacobian
    }

    /// Position error over the length, and rotation vector, in the base frame; the robot is left
    /// placed at `q`.
    fn error(&mut self, target: &Isometry3<f64>, q: &[f64]) -> Vector6<f64> {
        let tip = self.tip(q);
        let shift: Vector3<f64> =
            (target.translation.vector - tip.translation.vector) / self.scale.length_m;
        let turn = (target.rotation * tip.rotation.inverse()).scaled_axis();
        Vector6::new(shift.x, shift.y, shift.z, turn.x, turn.y, turn.z)
    }

    fn residual(&self, error: &Vector6<f64>) -> Residual {
        Residual {
            distance_m: error.fixed_rows::<3>(0).norm() * self.scale.length_m,
            angle_rad: error.fixed_rows::<3>(3).norm(),
        }
    }

    /// Scaled J where the robot stands.
    fn linearise(&mut self, held: &[bool]) {
        joint_jacobian(self.robot, &self.placement, &Point3::origin(), &mut self.jacobian);
        for (i, mut column) in self.jacobian.column_iter_mut().enumerate() {
            if held.get(i).copied().unwrap_or(false) {
                column.fill(0.0);
                continue;
            }
            let unit = self.scale.joints[i];
            for row in 0..3 {
                column[row] *= unit / self.scale.length_m;
            }
            for row in 3..6 {
                column[row] *= unit;
            }
        }
    }

    /// Fills the step with the damped least-squares solution of J·step = error; `None` where the
    /// system cannot be solved.
    fn solve(&mut self, error: &Vector6<f64>, damping: f64) -> Option<()> {
        let n = self.jacobian.ncols();
        let shift = Matrix6::from_diagonal_element(damping);
        if n >= 6 {
            let mut normal = shift;
            for column in self.jacobian.column_iter() {
                // The lower half is all that Cholesky reads.
                for i in 0..6 {
                    for j in 0..=i {
                        normal[(i, j)] += column[i] * column[j];
                    }
                }
            }
            let x = normal.cholesky()?.solve(error);
            for (step, column) in self.step.iter_mut().zip(self.jacobian.column_iter()) {
                *step = column.dot(&x);
            }
        } else {
            // Padded to six, so that nothing is allocated.
            let mut normal = Matrix6::identity();
            let mut right = Vector6::zeros();
            for i in 0..n {
                let column = self.jacobian.column(i);
                right[i] = column.dot(error);
                for j in 0..n {
                    normal[(i, j)] = column.dot(&self.jacobian.column(j));
                }
            }
            let x = (normal + shift).cholesky()?.solve(&right);
            self.step.copy_from_slice(&x.as_slice()[..n]);
        }
        let longest = self.step.iter().fold(0.0_f64, |longest, step| longest.max(step.abs()));
        let shrink = if longest > MAX_STEP { MAX_STEP / longest } else { 1.0 };
        for (step, unit) in self.step.iter_mut().zip(&self.scale.joints) {
            *step *= shrink * unit;
        }
        longest.is_finite().then_some(())
    }
}
