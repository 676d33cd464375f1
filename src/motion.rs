//! What a robot is told to do: moves to targets, each with the line of the file that asks for it.

use nalgebra::Isometry3;

/// One move: from wherever the robot stands to a target. The first move of an operation is where the
/// operation starts.
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
    /// Whether the spindle turns on the way; where a program has stopped it, nothing excites the arm.
    pub spindle_turns: bool,
}

/// Where a move goes and how the controller interpolates on the way.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// Joint interpolation to joint positions, rad or m, one per moving joint.
    Joints(Vec<f64>),
    /// Joint interpolation to a pose of the tool centre point in the base frame.
    JointsTo(Isometry3<f64>),
    /// A straight line of the tool centre point to a pose in the base frame; the orientation turns about
    /// one fixed axis at a constant rate.
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
