//! Poses outside the joint limits.

use crate::model::Robot;

/// The first joint of the pose that is outside its limits, by place.
fn outside_limits(robot: &Robot, q: &[f64]) -> Option<usize> {
    robot.joints().iter().zip(q).position(|(joint, &value)| !joint.allows(value))
}

/// Poses outside the joint limits, out of many.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct OutsideLimits {
    /// How many poses.
    pub poses: usize,
    /// The first joint, by place, that is outside at the first of them, and where it stands, rad or
    /// m.
    pub first: Option<(usize, f64)>,
}

impl OutsideLimits {
    /// Counts a pose (rad or m, base to tip) if it is one.
    pub fn look_at(&mut self, robot: &Robot, q: &[f64]) {
        if let Some(joint) = outside_limits(robot, q) {
            self.add(Self { poses: 1, first: Some((joint, q[joint])) });
        }
    }

    /// Counts those of poses that come after.
    pub fn add(&mut self, later: Self) {
        self.poses += later.poses;
        self.first = self.first.or(later.first);
    }
}
