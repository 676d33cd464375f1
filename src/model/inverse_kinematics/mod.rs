//! Inverse kinematics: from a pose of the tip to joint positions.
//!
//! Two methods, chosen once a robot. Six turning joints, of which 2 and 3 are parallel and 4, 5 and
//! 6 meet in one point, have a closed form ([`spherical`]); everything else is solved from several
//! fixed starting poses ([`descent`]). Either way each solution is refined on the robot's own
//! forward kinematics and kept only if that reproduces the pose, so the closed form need not be
//! trusted; it is tried on a few poses when it is made, and dropped for the numeric method should
//! it miss one.
//!
//! The closed form works on the joint axes as they lie in space at q = 0, not on the lengths,
//! offsets and signs of the OPW convention (Brandstötter, Angerer & Hofbaur 2014). Those would have
//! to be read from the axes first, with a case for each zero position and sense of turning that a
//! URDF may choose, and they leave out oblique wrists and bases that are not upright.
//! `rs-opw-kinematics` serves as the independent check in the tests instead.

mod descent;
mod fault;
mod holding;
mod solver;
mod spherical;

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Matrix6xX, Point3};

use self::descent::{Descent, Residual, Scale};
use self::spherical::{BRANCHES, SphericalWrist};
use super::description::JointKind;
use super::placement::{Axis, Placement};
use super::pose_fault::PoseFault;
use super::robot::{LIMIT_SLACK, MovingJoint, Robot};
use super::tip::{forward_kinematics, joint_jacobian};

pub use self::fault::IkFault;
pub use self::solver::Solver;

/// An arm whose joint frames all lie within this has no length to scale by, m.
const NO_LENGTH_M: f64 = 1e-9;

/// Poses closer than this (root of the sum of squares, rad, sliding joints as a share of the
/// length) are one solution.
const SAME: f64 = 1e-6;

/// A solution that has moved no farther than this from the seed (rad, as above) is on the seed's
/// branch: far below the angle between branches but near a singularity, where they meet.
const ON_BRANCH: f64 = 0.5;

/// Where the axes miss the ideal, the closed form is aimed anew at the target plus what it missed
/// by, until it misses by no more than this (m or rad). So it settles on either side of a
/// singularity, on which least squares from afar would creep.
const AIMED: f64 = 1e-10;
const MAX_AIMS: usize = 8;

/// Steps from a seed or a starting pose.
const SEARCHING_STEPS: usize = 60;

/// Starting poses of the numeric method: it stops after so many, or after so many in a row that led
/// to nothing new.
const MAX_STARTS: usize = 400;
const MAX_FRUITLESS_STARTS: usize = 60;

/// A redundant arm has a continuum of solutions: so many of them are enough.
const ENOUGH_OF_MANY: usize = 8;

/// Starting poses tried for the nearest pose to one that is out of reach.
const STARTS_FOR_MISS: usize = 8;

/// Poses on which a closed form is tried before it is used.
const TRIAL_POSES: usize = 8;

/// How a robot's inverse kinematics is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IkMethod {
    /// In closed form: all branches are found.
    SphericalWrist,
    /// From several starting poses: branches may be missed.
    Numeric,
}

/// How near a pose is to a singularity.
#[derive(Debug, Clone, PartialEq)]
pub struct Singularity {
    /// Smallest singular value of the joint Jacobian at the tip, with translations divided by
    /// [`InverseKinematics::length_m`] and sliding joints counted in that length. Its inverse is
    /// the joint speed (rad/s) for the worst motion of the tip at 1 rad/s, or one length a second.
    /// Zero at a singularity.
    pub smallest_singular_value: f64,
    /// The joints (by index) whose motions undo each other there, in ascending order.
    pub joints: Vec<usize>,
    /// On which side of the singularities an arm of six joints is: the sign of det J. `None` for
    /// other arms and at a singularity.
    pub is_right_handed: Option<bool>,
}

/// Inverse kinematics of one robot. Its functions take the robot that it was made for.
#[derive(Debug, Clone, PartialEq)]
pub struct InverseKinematics {
    scale: Scale,
    /// The last six joints, if their axes are of that kind.
    arm: Option<SphericalWrist>,
}

impl InverseKinematics {
    /// Chooses the method for `robot`.
    pub fn new(robot: &Robot) -> Self {
        let mut placement = Placement::new(robot);
        placement.place_joints(robot, &vec![0.0; robot.joints().len()]);
        let zero_tip = forward_kinematics(robot, &placement);
        let length_m = chain_length(&placement.joint_axes, &zero_tip);
        let unit = |joint: &MovingJoint| if slides(joint) { length_m } else { 1.0 };
        let scale = Scale { length_m, joints: robot.joints().iter().map(unit).collect() };
        let turn = |joints: &[MovingJoint; 6]| !joints.iter().any(slides);
        let axes = placement.joint_axes.last_chunk();
        let arm = axes
            .filter(|_| robot.joints().last_chunk().is_some_and(turn))
            .and_then(|axes| SphericalWrist::new(axes, &zero_tip, length_m));
        let chosen = Self { scale, arm };
        if chosen.finds_trial_poses(robot) { chosen } else { Self { arm: None, ..chosen } }
    }

    /// Of an arm without further joints.
    fn closed_form(&self) -> Option<&SphericalWrist> {
        self.arm.as_ref().filter(|_| self.scale.joints.len() == 6)
    }

    /// How this robot is solved.
    pub fn method(&self) -> IkMethod {
        match self.closed_form() {
            Some(_) => IkMethod::SphericalWrist,
            None => IkMethod::Numeric,
        }
    }

    /// The length that makes translations and rotations comparable, m: from joint frame to joint
    /// frame to the tip at q = 0, summed up (the arm's reach, about).
    pub fn length_m(&self) -> f64 {
        self.scale.length_m
    }

    /// On which side of its singularities shoulder, elbow and wrist of the last six joints are at
    /// `q` (rad or m): joint positions that reach one pose, the joints before as they are, differ
    /// in one of them at least, or in whole turns. `None` at a singularity, and of an arm with
    /// another wrist.
    pub fn sides(&self, q: &[f64]) -> [Option<bool>; 3] {
        let own = self.arm.as_ref().zip(q.last_chunk());
        own.map_or([None; 3], |(arm, q)| arm.sides(q))
    }

    /// The joint positions (rad or m, within limits) that bring the tip frame to `tip_pose` in the
    /// base frame, one for each branch, turning joints by the turn nearest to zero; always in the
    /// same order. In closed form these are all branches, up to eight (where a URDF rounds its
    /// right angles, two that are about to meet at a singularity may come out as one); the numeric
    /// method may miss one, and gives a few examples for a redundant arm. Empty where there are
    /// none, and for a pose that is not finite.
    pub fn solutions(&self, robot: &Robot, tip_pose: &Isometry3<f64>) -> Vec<Vec<f64>> {
        if self.check_robot(robot).is_err() || !is_finite(tip_pose) {
            return Vec::new();
        }
        let zero = vec![0.0; robot.joints().len()];
        let (mut found, _) = self.branches(robot, tip_pose, &mut Descent::new(robot, &self.scale));
        for q in &mut found {
            turn_towards(robot, q, &zero);
        }
        found.retain(|q| worst_excess(robot, q).is_none());
        found
    }

    /// All [`Self::solutions`] and the one of [`Self::near`], each by the turns nearest to `seed`
    /// (rad or m, one value per moving joint), the nearest to it first; sliding joints count as a
    /// share of [`Self::length_m`]. For a redundant arm the first is the one that moves least from
    /// the seed.
    pub fn solutions_near(
        &self,
        robot: &Robot,
        tip_pose: &Isometry3<f64>,
        seed: &[f64],
    ) -> Vec<Vec<f64>> {
        if robot.check_pose(seed).is_err() {
            return Vec::new();
        }
        let mut found = self.solutions(robot, tip_pose);
        for q in &mut found {
            turn_towards(robot, q, seed);
        }
        if let Ok(near) = self.near(robot, tip_pose, seed)
            && !found.iter().any(|q| self.distance(q, &near) < SAME)
        {
            found.push(near);
        }
        found.sort_by(|a, b| self.distance(a, seed).total_cmp(&self.distance(b, seed)));
        found
    }

    /// The joint positions that bring the tip frame to `tip_pose` in the base frame, nearest to
    /// `seed` (rad or m, one value per moving joint).
    ///
    /// Where the seed's own branch leads there without a turn of more than about half a radian,
    /// that branch is followed, and its limits count. Otherwise the nearest of all
    /// [`Self::solutions`] is taken, each by the turns nearest to the seed. A redundant arm takes
    /// the shortest way, as far as its limits let it. Exact to 1e-12 m (longer arms than a metre:
    /// in proportion to [`Self::length_m`]) and 1e-12 rad.
    ///
    /// # Errors
    /// [`IkFault`]: the input is not finite or has the wrong length, the pose is out of reach (for
    /// fewer than six joints: not among those that the arm can take), or a joint would pass its
    /// limit.
    pub fn near(
        &self,
        robot: &Robot,
        tip_pose: &Isometry3<f64>,
        seed: &[f64],
    ) -> Result<Vec<f64>, IkFault> {
        self.solver(robot).near(tip_pose, seed)
    }

    /// How near pose `q` (rad or m) is to a singularity of the arm.
    ///
    /// # Errors
    /// [`PoseFault`] where `q` is not a pose of the robot.
    pub fn singularity(&self, robot: &Robot, q: &[f64]) -> Result<Singularity, PoseFault> {
        /// A joint takes part with this share of the largest part.
        const SHARE: f64 = 0.2;
        robot.check_pose(q)?;
        self.check_robot(robot)?;
        let (jacobian, scaled) = self.jacobians(robot, q);
        let none =
            Singularity { smallest_singular_value: 0.0, joints: Vec::new(), is_right_handed: None };
        if q.is_empty() {
            return Ok(none);
        }
        let svd = scaled.svd(false, true);
        let (Some(directions), Some(weakest)) = (svd.v_t, argmin(svd.singular_values.as_slice()))
        else {
            return Ok(none);
        };
        let direction = directions.row(weakest);
        let largest = direction.amax();
        Ok(Singularity {
            smallest_singular_value: svd.singular_values[weakest],
            joints: (0..q.len()).filter(|&i| direction[i].abs() >= SHARE * largest).collect(),
            is_right_handed: side(&jacobian),
        })
    }

    /// [`Singularity::is_right_handed`] of an arm of six joints whose smallest singular value at
    /// `q` is surely above `least`; `None` where that takes a closer look by [`Self::singularity`].
    pub fn side_if_regular(&self, robot: &Robot, q: &[f64], least: f64) -> Option<bool> {
        self.solver(robot).side_if_regular(q, least)
    }

    /// J of the joints at the tip, and the same with comparable rows and columns.
    fn jacobians(&self, robot: &Robot, q: &[f64]) -> (Matrix6xX<f64>, Matrix6xX<f64>) {
        let mut placement = Placement::new(robot);
        placement.place_joints(robot, q);
        let mut jacobian = Matrix6xX::zeros(q.len());
        joint_jacobian(robot, &placement, &Point3::origin(), &mut jacobian);
        let scaled = Matrix6xX::from_fn(q.len(), |row, i| {
            let unit = self.scale.joints[i];
            jacobian[(row, i)] * if row < 3 { unit / self.scale.length_m } else { unit }
        });
        (jacobian, scaled)
    }

    fn check_robot(&self, robot: &Robot) -> Result<(), PoseFault> {
        let (given, expected) = (robot.joints().len(), self.scale.joints.len());
        if given == expected { Ok(()) } else { Err(PoseFault::Length { given, expected }) }
    }

    /// Whether the closed form, if there is one, finds the way back to a few poses that it is
    /// given.
    fn finds_trial_poses(&self, robot: &Robot) -> bool {
        /// A pose nearer to a singularity than this says nothing, as branches meet there.
        const REGULAR: f64 = 1e-3;
        let mut placement = Placement::new(robot);
        let mut descent = Descent::new(robot, &self.scale);
        (0..TRIAL_POSES).all(|index| {
            let q = start(robot, &self.scale, index);
            let is_regular = self
                .singularity(robot, &q)
                .is_ok_and(|measure| measure.smallest_singular_value > REGULAR);
            placement.place_joints(robot, &q);
            let target = forward_kinematics(robot, &placement);
            !is_regular
                || self.closed_branches(&target, &mut descent).is_none_or(|found| {
                    found.iter().any(|found| self.turned_distance(robot, found, &q) < SAME)
                })
        })
    }

    /// All solutions, limits aside, angles by any turn; with the nearest miss where they were
    /// sought from starting poses.
    fn branches(
        &self,
        robot: &Robot,
        target: &Isometry3<f64>,
        descent: &mut Descent<'_>,
    ) -> (Vec<Vec<f64>>, Option<Residual>) {
        match self.closed_branches(target, descent) {
            Some(found) => (self.distinct(robot, found), None),
            None => self.searched_branches(robot, target, descent),
        }
    }

    fn closed_branches(
        &self,
        target: &Isometry3<f64>,
        descent: &mut Descent<'_>,
    ) -> Option<Vec<Vec<f64>>> {
        let closed_form = self.closed_form()?;
        let mut found = Vec::with_capacity(BRANCHES);
        for branch in 0..BRANCHES {
            let Some(mut q) = closed_form.solution(target, branch) else { continue };
            let mut aim = *target;
            for _ in 0..MAX_AIMS {
                let miss = target * descent.tip(&q).inverse();
                if miss.translation.vector.norm().max(miss.rotation.angle()) <= AIMED {
                    break;
                }
                aim = miss * aim;
                match closed_form.solution(&aim, branch) {
                    Some(better) => q = better,
                    None => break,
                }
            }
            let residual = descent.run(target, &mut q, &[], SEARCHING_STEPS);
            if residual.is_reached(&self.scale) {
                found.push(q.to_vec());
            }
        }
        Some(found)
    }

    fn searched_branches(
        &self,
        robot: &Robot,
        target: &Isometry3<f64>,
        descent: &mut Descent<'_>,
    ) -> (Vec<Vec<f64>>, Option<Residual>) {
        let zero = vec![0.0; robot.joints().len()];
        let is_redundant = zero.len() > 6;
        let mut found: Vec<Vec<f64>> = Vec::new();
        let mut miss: Option<Residual> = None;
        let mut fruitless = 0;
        for index in 0..MAX_STARTS {
            if fruitless >= MAX_FRUITLESS_STARTS || (is_redundant && found.len() >= ENOUGH_OF_MANY)
            {
                break;
            }
            fruitless += 1;
            let mut q = start(robot, &self.scale, index);
            let residual = descent.run(target, &mut q, &[], SEARCHING_STEPS);
            if !residual.is_reached(&self.scale) {
                if miss.is_none_or(|miss| residual.norm(&self.scale) < miss.norm(&self.scale)) {
                    miss = Some(residual);
                }
                continue;
            }
            turn_towards(robot, &mut q, &zero);
            self.keep_limits(robot, target, descent, &mut q);
            if !found.iter().any(|other| self.turned_distance(robot, other, &q) < SAME) {
                // A redundant arm goes on as long as what is found breaks limits.
                let counts = !is_redundant || worst_excess(robot, &q).is_none();
                if counts || found.is_empty() {
                    found.push(q);
                }
                if counts {
                    fruitless = 0;
                }
            }
        }
        (found, miss)
    }

    /// The nearest that a few starting poses come to a pose out of reach.
    fn nearest_miss(
        &self,
        robot: &Robot,
        target: &Isometry3<f64>,
        descent: &mut Descent<'_>,
    ) -> Residual {
        let mut nearest = Residual { distance_m: f64::INFINITY, angle_rad: PI };
        for index in 0..STARTS_FOR_MISS {
            let mut q = start(robot, &self.scale, index);
            let residual = descent.run(target, &mut q, &[], SEARCHING_STEPS);
            if residual.norm(&self.scale) < nearest.norm(&self.scale) {
                nearest = residual;
            }
        }
        nearest
    }

    /// Has a redundant arm stop at the limits that it passes and reach the target with the joints
    /// that are left; leaves `q` as it is where they do not suffice.
    fn keep_limits(
        &self,
        robot: &Robot,
        target: &Isometry3<f64>,
        descent: &mut Descent<'_>,
        q: &mut [f64],
    ) {
        let mut held = vec![false; q.len()];
        let mut trial = q.to_vec();
        for _ in 6..q.len() {
            let Some(excess) = worst_excess(robot, &trial) else { break };
            trial[excess.joint] = excess.limit;
            held[excess.joint] = true;
            let residual = descent.run(target, &mut trial, &held, SEARCHING_STEPS);
            if !residual.is_reached(&self.scale) {
                return;
            }
        }
        if worst_excess(robot, &trial).is_none() {
            q.copy_from_slice(&trial);
        }
    }

    fn distinct(&self, robot: &Robot, all: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let mut distinct: Vec<Vec<f64>> = Vec::with_capacity(all.len());
        for q in all {
            if !distinct.iter().any(|other| self.turned_distance(robot, other, &q) < SAME) {
                distinct.push(q);
            }
        }
        distinct
    }

    /// Distance of two poses, rad.
    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let square = |((a, b), unit): ((&f64, &f64), &f64)| ((a - b) / unit).powi(2);
        a.iter().zip(b).zip(&self.scale.joints).map(square).sum::<f64>().sqrt()
    }

    /// Distance of two poses, rad, whole turns aside.
    fn turned_distance(&self, robot: &Robot, a: &[f64], b: &[f64]) -> f64 {
        let square = |(((a, b), unit), joint): (((&f64, &f64), &f64), &MovingJoint)| {
            let apart = a - b;
            let apart =
                if slides(joint) { apart / unit } else { apart - TAU * (apart / TAU).round() };
            apart * apart
        };
        let pairs = a.iter().zip(b).zip(&self.scale.joints).zip(robot.joints());
        pairs.map(square).sum::<f64>().sqrt()
    }
}

/// A joint beyond its limit.
struct Excess {
    joint: usize,
    limit: f64,
    by: f64,
}

/// The joint that is farthest beyond its limit.
fn worst_excess(robot: &Robot, q: &[f64]) -> Option<Excess> {
    let mut worst: Option<Excess> = None;
    for (joint, (moving, &value)) in robot.joints().iter().zip(q).enumerate() {
        let Some([lower, upper]) = moving.limit else { continue };
        let limit = if value < lower { lower } else { upper };
        let by = (lower - value).max(value - upper);
        if by > worst.as_ref().map_or(LIMIT_SLACK, |worst| worst.by) {
            worst = Some(Excess { joint, limit, by });
        }
    }
    worst
}

fn within_limits(robot: &Robot, q: Vec<f64>) -> Result<Vec<f64>, IkFault> {
    match worst_excess(robot, &q) {
        None => Ok(q),
        Some(excess) => {
            let joint = &robot.joints()[excess.joint];
            Err(IkFault::OverLimit {
                joint: joint.name.clone(),
                slides: slides(joint),
                value: q[excess.joint],
                limit: excess.limit,
            })
        }
    }
}

/// Turns each joint by whole turns to where it is nearest to `goal`, or to the turn next to that
/// which its limits allow.
pub fn turn_towards(robot: &Robot, q: &mut [f64], goal: &[f64]) {
    for ((q, goal), joint) in q.iter_mut().zip(goal).zip(robot.joints()) {
        if slides(joint) {
            continue;
        }
        let turned = *q + TAU * ((goal - *q) / TAU).round();
        *q = turned;
        let Some([lower, upper]) = joint.limit else { continue };
        let allowed = if turned < lower - LIMIT_SLACK {
            turned + TAU * ((lower - LIMIT_SLACK - turned) / TAU).ceil()
        } else if turned > upper + LIMIT_SLACK {
            turned - TAU * ((turned - upper - LIMIT_SLACK) / TAU).ceil()
        } else {
            continue;
        };
        if (lower - LIMIT_SLACK..=upper + LIMIT_SLACK).contains(&allowed) {
            *q = allowed;
        }
    }
}

/// The index-th starting pose: evenly spread over the range of the joints, one turn at most, by an
/// additive recurrence with the powers of the generalised golden ratio (the root of
/// x^(n+1) = x + 1), which fills any number of dimensions evenly and is the same on every run.
fn start(robot: &Robot, scale: &Scale, index: usize) -> Vec<f64> {
    let exponent = 1.0 / (robot.joints().len() as f64 + 1.0);
    let ratio = (0..64).fold(2.0_f64, |x, _| (1.0 + x).powf(exponent));
    let mut power = 1.0;
    let joints = robot.joints().iter().zip(&scale.joints);
    joints
        .map(|(joint, unit)| {
            power /= ratio;
            let share = (0.5 + (index + 1) as f64 * power).fract();
            let most = if slides(joint) { *unit } else { PI };
            let [lower, upper] = joint.limit.unwrap_or([-most, most]);
            let (lower, upper) =
                if !slides(joint) && upper - lower > TAU { (-PI, PI) } else { (lower, upper) };
            lower + share * (upper - lower)
        })
        .collect()
}

fn slides(joint: &MovingJoint) -> bool {
    joint.kind == JointKind::Prismatic
}

/// Length from joint frame to joint frame to the tip; one metre where all lie in one point.
fn chain_length(axes: &[Axis], tip: &Isometry3<f64>) -> f64 {
    let points: Vec<_> =
        axes.iter().map(|axis| axis.point).chain([tip.translation.vector]).collect();
    let length: f64 = points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum();
    if length > NO_LENGTH_M { length } else { 1.0 }
}

/// Whether a pose holds finite numbers only, and none so large that its square is not.
fn is_finite(pose: &Isometry3<f64>) -> bool {
    pose.translation.vector.norm_squared().is_finite()
        && pose.rotation.coords.iter().all(|x| x.is_finite())
}

/// Whether det J is positive; `None` where it is zero, or there are not six joints.
fn side(jacobian: &Matrix6xX<f64>) -> Option<bool> {
    (jacobian.ncols() == 6)
        .then(|| jacobian.fixed_columns::<6>(0).into_owned().determinant())
        .filter(|determinant| *determinant != 0.0)
        .map(|determinant| determinant > 0.0)
}

fn argmin(values: &[f64]) -> Option<usize> {
    (0..values.len()).min_by(|&i, &j| values[i].total_cmp(&values[j]))
}
