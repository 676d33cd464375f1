//! What a robot is to do: moves to targets, each with the line of the file that asks for it.

use nalgebra::{Isometry3, Rotation3, Unit, Vector3};

/// One move: from wherever the robot stands to a target. The first move of an operation is where
/// the operation starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Move {
    /// Where to and how.
    pub to: Target,
    /// Speed of the tool centre point, m/s; positive and finite.
    pub feed_m_per_s: f64,
    /// Tool centre point in the tip frame.
    pub tcp: Isometry3<f64>,
    /// Line of the file (job or program) that asks for this move, counted from 1.
    pub line: usize,
    /// Whether the spindle turns on the way; where a program has stopped it, nothing excites the
    /// arm.
    pub spindle_turns: bool,
}

/// Where a move goes and how the controller interpolates on the way.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// Joint interpolation to joint positions, rad or m, one per moving joint.
    Joints(Vec<f64>),
    /// Joint interpolation to a pose of the tool centre point in the base frame.
    JointsTo(Isometry3<f64>),
    /// A straight line of the tool centre point to a pose in the base frame; the orientation turns
    /// about one fixed axis at a constant rate.
    Line(Isometry3<f64>),
    /// An arc of a circle of the tool centre point through `via` to `end`, in the base frame; the
    /// orientation turns as on a line, by way of `via`.
    Arc {
        /// A pose on the arc.
        via: Isometry3<f64>,
        /// The end of the arc.
        end: Isometry3<f64>,
    },
}

/// Three points closer to one line than this share of their distance do not make an arc.
const MIN_ARC_CURVATURE: f64 = 1e-9;

/// The part of a circle from one point through another to a third.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Circle {
    centre: Vector3<f64>,
    /// From the centre to the first point.
    start: Vector3<f64>,
    axis: Unit<Vector3<f64>>,
    /// To the second and to the third point, rad, positive about `axis`.
    angles: [f64; 2],
}

impl Circle {
    /// The arc from `a` through `b` to `c`; `None` if the three points lie on one line.
    pub(crate) fn through(a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) -> Option<Self> {
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(&ac);
        if normal.norm() <= MIN_ARC_CURVATURE * ab.norm().max(ac.norm()).powi(2) {
            return None;
        }
        // Circumcentre of a triangle, from one of its corners.
        let to_centre = (normal.cross(&ab) * ac.norm_squared()
            + ac.cross(&normal) * ab.norm_squared())
            / (2.0 * normal.norm_squared());
        let centre = a + to_centre;
        let axis = Unit::new_normalize(normal);
        let start = a - centre;
        let angle_to = |p: Vector3<f64>| {
            let r = p - centre;
            let angle = f64::atan2(axis.dot(&start.cross(&r)), start.dot(&r));
            if angle > 0.0 { angle } else { angle + std::f64::consts::TAU }
        };
        Some(Self { centre, start, axis, angles: [angle_to(b), angle_to(c)] })
    }

    /// Length of the arc, in the unit of the points.
    pub(crate) fn length(&self) -> f64 {
        self.angles[1] * self.start.norm()
    }

    /// Share of the arc that lies before the second point.
    pub(crate) fn via_at(&self) -> f64 {
        self.angles[0] / self.angles[1]
    }

    /// The point behind the share `u` of the arc, 0..=1.
    pub(crate) fn at(&self, u: f64) -> Vector3<f64> {
        self.centre + Rotation3::from_axis_angle(&self.axis, self.angles[1] * u) * self.start
    }
}

/// What feeds a program states itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StatedFeeds {
    /// Some in length per time.
    pub per_time: bool,
    /// Some in length per revolution of the spindle, at the speed that the program states.
    pub per_revolution: bool,
}

impl StatedFeeds {
    /// Whether there are any.
    pub fn any(self) -> bool {
        self.per_time || self.per_revolution
    }
}
