//! What a robot is to do: moves to targets, each with the line of the file that asks for it.

mod work;

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Rotation3, Unit, Vector3};

pub use work::{MechanicalUnit, UnitAxis, UnitMove, Work};

/// One move: from wherever the robot stands to a target. The first move of an operation is where
/// the operation starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Move {
    /// Where to and how.
    pub to: Target,
    /// Speed of the tool centre point, m/s; positive and finite.
    pub feed_m_per_s: f64,
    /// What sets how long it takes.
    pub timing: Timing,
    /// Tool centre point in the tip frame; in the base frame where the arm holds the work.
    pub tcp: Isometry3<f64>,
    /// Where the work is.
    pub work: Work,
    /// Line of the file (job or program) that asks for this move, counted from 1.
    pub line: usize,
    /// Whether the spindle turns on the way; where a program has stopped it, nothing excites the
    /// arm.
    pub spindle_turns: bool,
    /// What the program states for this move; moves under the same statements share it.
    pub stated: Arc<Stated>,
}

impl Move {
    /// The pose of the tip in the base frame where the tool is at `pose` behind the share `u` of
    /// the move.
    pub(crate) fn tip(&self, u: f64, pose: &Isometry3<f64>) -> Isometry3<f64> {
        self.work.tip(u, pose, &self.tcp)
    }

    /// The pose of the tool, as targets have it, where the move starts with the tip at `tip`.
    pub(crate) fn start(&self, tip: &Isometry3<f64>) -> Isometry3<f64> {
        self.work.pose(0.0, tip, &self.tcp)
    }
}

/// What sets how long a move takes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Timing {
    /// The way of the tool centre point and [`Move::feed_m_per_s`]; where the tool turns, no faster
    /// than [`Stated::turning_rad_per_s`].
    #[default]
    Feed,
    /// The same at a feed that is assumed: the move is a rapid one, and cuts nothing.
    Rapid,
    /// So many seconds, whatever the way; where nothing moves the arm stands so long.
    Seconds(f64),
    /// The slowest joint, at this share of its velocity limit; in 0..=1, not zero.
    Joints(f64),
}

/// What a program states beside the motion; what it is silent on is `None`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stated {
    /// What the spindle does.
    pub spindle: Option<Spindle>,
    /// Whether a spindle that turns does so the other way round: M4, or a negative speed.
    pub is_reversed: bool,
    /// Number of the tool that is loaded.
    pub tool: Option<u32>,
    /// What the tip carries.
    pub load: Option<Arc<Load>>,
    /// Where joints of the robot are at the end of the move that the program places as external
    /// axes: index from base to tip, and position, rad or m.
    pub external: Vec<(usize, f64)>,
    /// How fast the tool may turn, rad/s.
    pub turning_rad_per_s: Option<f64>,
    /// What external axes need for the move at the speed that the program has for them, s.
    pub external_s: f64,
    /// The arm configuration at the end of the move.
    pub configuration: Option<Arc<Configuration>>,
    /// What the program says of the arm configuration where the path starts, if that cannot be
    /// compared with joint positions.
    pub uncompared: Option<Arc<str>>,
}

/// An arm configuration that a program asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration {
    /// As the program has it.
    pub shown: String,
    /// Where joints must be: index from base to tip, lowest and highest position, rad.
    pub joints: Vec<(usize, [f64; 2])>,
    /// Where shoulder, elbow and wrist must be.
    pub sides: Option<Sides>,
}

/// Where shoulder, elbow and wrist are, as a program names it: the same at all targets of one name.
#[derive(Debug, Clone, PartialEq)]
pub struct Sides {
    /// As the program has it.
    pub name: String,
    /// Whether shoulder and elbow are as they are where all joints are at zero, where the name says
    /// so.
    pub as_at_zero: [Option<bool>; 2],
}

/// What a command makes the spindle do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spindle {
    /// To stand still.
    Stands,
    /// To turn, at this speed in rev/min (positive) or at one that the program does not give.
    Turns(Option<f64>),
}

impl Spindle {
    /// Turns at `rpm` where that is known; at zero it stands.
    pub fn at(rpm: Option<f64>) -> Self {
        if rpm == Some(0.0) { Self::Stands } else { Self::Turns(rpm) }
    }

    /// Speed, rev/min, of a spindle that turns, if it is known.
    pub fn rpm(self) -> Option<f64> {
        match self {
            Self::Stands => None,
            Self::Turns(rpm) => rpm,
        }
    }
}

/// What a program says that the tip carries with a tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    /// The tool, as the program spells it.
    pub name: String,
    /// Line of the declaration, counted from 1.
    pub line: usize,
    /// Mass, kg; positive.
    pub mass_kg: f64,
    /// Centre of mass in the tip frame, m.
    pub com_m: Vector3<f64>,
    /// Rotary inertia about the centre of mass in the axes of the tip frame, kg·m².
    pub inertia_kgm2: Matrix3<f64>,
    /// Whether it is what RobotStudio enters for a new tool: nobody stated it, so that the
    /// payload of job or robot file counts.
    pub is_placeholder: bool,
}

impl Load {
    /// Whether it is the same body, under whatever name.
    pub fn is_same_body(&self, other: &Self) -> bool {
        self.mass_kg == other.mass_kg
            && self.com_m == other.com_m
            && self.inertia_kgm2 == other.inertia_kgm2
    }

    /// The same body where `frame` has the one that it is given in.
    pub(crate) fn placed(&self, frame: &Isometry3<f64>) -> Self {
        let turn = frame.rotation.to_rotation_matrix();
        Self {
            com_m: frame.rotation * self.com_m + frame.translation.vector,
            inertia_kgm2: turn * self.inertia_kgm2 * turn.transpose(),
            ..self.clone()
        }
    }

    /// Both bodies as one, called after both.
    pub(crate) fn with(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        let com_m = (self.com_m * self.mass_kg + other.com_m * other.mass_kg) / mass_kg;
        let about = |body: &Self| {
            let r = body.com_m - com_m;
            let moved = Matrix3::identity() * r.norm_squared() - r * r.transpose();
            body.inertia_kgm2 + moved * body.mass_kg
        };
        Self {
            name: format!("{} with {}", self.name, other.name),
            line: self.line,
            mass_kg,
            com_m,
            is_placeholder: false,
            inertia_kgm2: about(self) + about(other),
        }
    }
}

/// Where a move goes and how the controller interpolates on the way.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// Joint interpolation to joint positions, rad or m, one per moving joint.
    Joints(Vec<f64>),
    /// Joint interpolation to a pose of the tool centre point in the frame of the work.
    JointsTo(Isometry3<f64>),
    /// A straight line of the tool centre point to a pose in the frame of the work; the orientation
    /// turns about one fixed axis at a constant rate.
    Line(Isometry3<f64>),
    /// An arc of a circle of the tool centre point through `via` to `end`, in the frame of the
    /// work.
    Arc {
        /// A pose on the arc.
        via: Isometry3<f64>,
        /// The end of the arc.
        end: Isometry3<f64>,
        /// How the tool turns on it.
        turning: Turning,
    },
}

/// How the tool turns on an arc, at a constant rate over its length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Turning {
    /// As on a line to the orientation of the pose on the arc, and as on another from there.
    #[default]
    ByWay,
    /// As on one line from start to end; the pose on the arc tells which way round.
    ToEnd,
    /// With the arc, and against it as on one line from start to end; the pose on the arc tells
    /// which way round.
    WithArc,
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

    /// Angle of the arc, rad, positive.
    pub(crate) fn angle(&self) -> f64 {
        self.angles[1]
    }

    /// Share of the arc that lies before the second point.
    pub(crate) fn via_at(&self) -> f64 {
        self.angles[0] / self.angles[1]
    }

    /// The point behind the share `u` of the arc, 0..=1.
    pub(crate) fn at(&self, u: f64) -> Vector3<f64> {
        self.centre + self.turn(u) * self.start
    }

    /// What has turned with the arc behind the share `u` of it.
    pub(crate) fn turn(&self, u: f64) -> Rotation3<f64> {
        Rotation3::from_axis_angle(&self.axis, self.angles[1] * u)
    }
}

/// What feeds a program states itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StatedFeeds {
    /// Some in length per time.
    pub per_time: bool,
    /// Some in length per revolution of the spindle, at the speed that the program states.
    pub per_revolution: bool,
    /// Some moves have none and run at the feed of the job.
    pub incomplete: bool,
}

impl StatedFeeds {
    /// Whether there are any.
    pub fn any(self) -> bool {
        self.per_time || self.per_revolution
    }
}
