//! Closed form for arms with two parallel axes below a spherical wrist, from the axes at q = 0.
//!
//! With the tip at T(q) = e^{S₁q₁}…e^{S₆q₆} T(0), where S_i turns about the line through p_i along
//! u_i (product of exponentials; Murray, Li & Sastry 1994, §3.2), the wrist centre c, in which axes
//! 4, 5 and 6 meet, moves with the first three joints only: e^{S₁q₁}e^{S₂q₂}e^{S₃q₃} c = w. As axes
//! 2 and 3 are parallel, neither changes u₂·x, which gives q₁; the distance of w from axis 2 gives
//! q₃; the angle about axis 2 gives q₂. The rotation that remains, R₄R₅R₆ = N, gives q₅ by u₄·R₅u₆
//! = u₄·N u₆, then q₄ and q₆ as angles about their axes.

use nalgebra::{Isometry3, Matrix3, Rotation3, Unit, Vector3};

use crate::model::placement::Axis;

/// Axes may miss being parallel (rad) or meeting in one point (share of the arm's length) by this:
/// URDF files print right angles as 1.57 and lengths to the millimetre. What is found is then
/// refined on the robot as it is.
const STRUCTURE_SLACK: f64 = 1e-3;

/// Axes that must not be parallel have at least this sine between them.
const MIN_SINE: f64 = 0.1;

/// How far beyond its range a cosine is still taken for a double root, in the scale of the
/// equation, where the axes are as they should be.
const ROOT_SLACK: f64 = 1e-6;

/// What is added to that, as a multiple of what the axes miss the ideal by.
const MISMATCH_GAIN: f64 = 20.0;

/// Up to two angles, the first one always filled first.
type Roots = [Option<f64>; 2];

/// Number of branches of the closed form.
pub(super) const BRANCHES: usize = 8;

/// A six-axis arm whose inverse kinematics has a closed form. All vectors in the base frame at q =
/// 0.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SphericalWrist {
    directions: [Unit<Vector3<f64>>; 6],
    /// A point of each of the first three axes.
    points: [Vector3<f64>; 3],
    /// Where axes 4, 5 and 6 meet.
    wrist: Vector3<f64>,
    /// The same point in the tip frame.
    wrist_in_tip: Vector3<f64>,
    zero_rotation: Matrix3<f64>,
    length_m: f64,
    /// How far beyond its range a cosine is taken for a double root.
    slack: f64,
}

impl SphericalWrist {
    /// The closed form for the joint axes and tip frame at q = 0, if the arm is of that kind.
    pub(super) fn new(axes: &[Axis; 6], zero_tip: &Isometry3<f64>, length_m: f64) -> Option<Self> {
        let directions = axes.map(|axis| Unit::new_normalize(axis.direction));
        let sine = |i: usize, j: usize| directions[i].cross(&directions[j]).norm();
        let apart = [(0, 1), (3, 4), (4, 5)];
        if !apart.iter().all(|&(i, j)| sine(i, j) > MIN_SINE) {
            return None;
        }
        let wrist = nearest_point(&axes[3..])?;
        let off_wrist = axes[3..].iter().map(|axis| distance(axis, &wrist)).fold(0.0, f64::max);
        let mismatch = sine(1, 2).max(off_wrist / length_m);
        let upper_arm = distance(&axes[1], &axes[2].point);
        let forearm = distance(&axes[2], &wrist);
        let folds = upper_arm.min(forearm) > STRUCTURE_SLACK * length_m;
        if !folds || mismatch.is_nan() || mismatch > STRUCTURE_SLACK {
            return None;
        }
        Some(Self {
            directions,
            points: [axes[0].point, axes[1].point, axes[2].point],
            wrist,
            wrist_in_tip: zero_tip.inverse_transform_point(&wrist.into()).coords,
            zero_rotation: *zero_tip.rotation.to_rotation_matrix().matrix(),
            length_m,
            slack: ROOT_SLACK + MISMATCH_GAIN * mismatch,
        })
    }

    /// The joint positions on `branch` that bring the tip to `target`, as angles of one turn;
    /// limits are not looked at. Bits 2, 1 and 0 of `branch` choose the root of joints 1, 3 and 5;
    /// two roots may be the same. A joint that is free (two axes in line) is at zero, on one branch
    /// only. Exact but for what the axes miss the ideal by.
    pub(super) fn solution(&self, target: &Isometry3<f64>, branch: usize) -> Option<[f64; 6]> {
        let choose = |roots: Roots, bit: usize| roots[branch >> bit & 1];
        let rotation = *target.rotation.to_rotation_matrix().matrix();
        let wrist = target.translation.vector + rotation * self.wrist_in_tip;
        let q1 = choose(self.first(&wrist), 2)?;
        let turned = self.points[0] + self.turn(0, -q1) * (wrist - self.points[0]);
        let q3 = choose(self.third(&turned), 1)?;
        let q2 = self.second(&turned, q3);
        let arm = self.turn(0, q1) * self.turn(1, q2) * self.turn(2, q3);
        let rest = arm.transpose() * rotation * self.zero_rotation.transpose();
        let q5 = choose(self.fifth(&rest), 0)?;
        let (q4, q6) = self.fourth_and_sixth(&rest, q5);
        Some([q1, q2, q3, q4, q5, q6])
    }

    /// On which branch the arm is at joints 1, 3 and 5: the signs of the derivatives of the three
    /// equations by their angles, which change where two roots meet. `None` near such a place.
    pub(super) fn sides(&self, q: &[f64; 6]) -> [Option<bool>; 3] {
        /// Nearer to a double root than this, in the scale of the equation, it may be either:
        /// programs print angles to a thousandth of a degree and lengths to a micrometre.
        const MIN_SLOPE: f64 = 1e-3;
        let [u1, u2, u3, u4, u5, u6] = &self.directions;
        let bent = self.turn(2, q[2]) * (self.wrist - self.points[2]);
        let from_second = self.turn(1, q[1]) * (self.points[2] + bent - self.points[1]);
        let from_first = self.points[1] + from_second - self.points[0];
        let upper_arm = self.across(&(self.points[2] - self.points[1]));
        let slopes = [
            u2.dot(&u1.cross(&from_first)) / self.length_m,
            upper_arm.dot(&u3.cross(&bent)) / (self.length_m * self.length_m),
            u4.dot(&u5.cross(&(self.turn(4, q[4]) * u6.into_inner()))),
        ];
        slopes.map(|slope| (slope.abs() > MIN_SLOPE).then_some(slope > 0.0))
    }

    fn turn(&self, joint: usize, q: f64) -> Matrix3<f64> {
        *Rotation3::from_axis_angle(&self.directions[joint], q).matrix()
    }

    /// u₂·(R₁(−q₁)(w − p₁)) = u₂·(c − p₁).
    fn first(&self, wrist: &Vector3<f64>) -> Roots {
        let [u1, u2, ..] = &self.directions;
        let v = wrist - self.points[0];
        let along = u1.into_inner() * u1.dot(&v);
        self.roots(
            u2.dot(&(v - along)),
            -u2.dot(&u1.cross(&v)),
            u2.dot(&(self.wrist - self.points[0])) - u2.dot(&along),
            self.length_m,
        )
    }

    /// |d + R₃v| = |w − p₂| in the plane across axis 2, with d from axis 2 to 3 and v from 3 to c.
    fn third(&self, turned: &Vector3<f64>) -> Roots {
        let u3 = &self.directions[2];
        let d = self.across(&(self.points[2] - self.points[1]));
        let v = self.across(&(self.wrist - self.points[2]));
        let reach = self.across(&(turned - self.points[1]));
        self.roots(
            d.dot(&v),
            d.dot(&u3.cross(&v)),
            (reach.norm_squared() - d.norm_squared() - v.norm_squared()) / 2.0,
            self.length_m * self.length_m,
        )
    }

    fn second(&self, turned: &Vector3<f64>, q3: f64) -> f64 {
        let bent = self.points[2] + self.turn(2, q3) * (self.wrist - self.points[2]);
        let from = self.across(&(bent - self.points[1]));
        let to = self.across(&(turned - self.points[1]));
        angle_about(&self.directions[1], &from, &to, self.slack * self.length_m)
    }

    /// u₄·R₅(q₅)u₆ = u₄·N u₆.
    fn fifth(&self, rest: &Matrix3<f64>) -> Roots {
        let [.., u4, u5, u6] = &self.directions;
        let along = u5.into_inner() * u5.dot(u6);
        self.roots(
            u4.dot(&(u6.into_inner() - along)),
            u4.dot(&u5.cross(u6)),
            u4.dot(&(rest * u6.into_inner())) - u4.dot(&along),
            1.0,
        )
    }

    fn fourth_and_sixth(&self, rest: &Matrix3<f64>, q5: f64) -> (f64, f64) {
        let [.., u4, _, u6] = &self.directions;
        let bend = self.turn(4, q5);
        let q4 = angle_about(u4, &(bend * u6.into_inner()), &(rest * u6.into_inner()), ROOT_SLACK);
        let roll = (self.turn(3, q4) * bend).transpose() * rest;
        let mark = perpendicular(u6);
        (q4, angle_about(u6, &mark, &(roll * mark), ROOT_SLACK))
    }

    /// Roots of a cos q + b sin q = c, which is of size `scale`; zero where any angle will do.
    fn roots(&self, a: f64, b: f64, c: f64, scale: f64) -> Roots {
        let slack = self.slack * scale;
        let amplitude = a.hypot(b);
        if amplitude <= slack {
            return [(c.abs() <= 2.0 * slack).then_some(0.0), None];
        }
        if c.is_nan() || c.abs() > amplitude + slack {
            return [None, None];
        }
        let middle = b.atan2(a);
        let spread = (c / amplitude).clamp(-1.0, 1.0).acos();
        [Some(middle + spread), Some(middle - spread)]
    }

    fn across(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let u2 = &self.directions[1];
        v - u2.into_inner() * u2.dot(v)
    }
}

/// Angle that turns `from` to `to` about `axis`; zero where either lies along the axis.
fn angle_about(
    axis: &Unit<Vector3<f64>>,
    from: &Vector3<f64>,
    to: &Vector3<f64>,
    slack: f64,
) -> f64 {
    let from = from - axis.into_inner() * axis.dot(from);
    let to = to - axis.into_inner() * axis.dot(to);
    if from.norm().min(to.norm()) <= slack {
        return 0.0;
    }
    axis.dot(&from.cross(&to)).atan2(from.dot(&to))
}

/// Some unit vector across `axis`.
fn perpendicular(axis: &Unit<Vector3<f64>>) -> Vector3<f64> {
    axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize()
}

fn distance(axis: &Axis, point: &Vector3<f64>) -> f64 {
    axis.direction.cross(&(point - axis.point)).norm()
}

/// The point with the least sum of squared distances from the lines.
fn nearest_point(lines: &[Axis]) -> Option<Vector3<f64>> {
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for line in lines {
        let across = Matrix3::identity() - line.direction * line.direction.transpose();
        normal += across;
        right += across * line.point;
    }
    Some(normal.cholesky()?.solve(&right))
}
