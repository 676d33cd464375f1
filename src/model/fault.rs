//! What is wrong with a robot, and where: places are symbolic, so that whoever read the files can
//! turn them into file and line.

use std::fmt;

/// Where in a robot's description a fault lies.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The robot as a whole.
    Robot,
    /// The choice of base link.
    Base,
    /// The choice of tip link.
    Tip,
    /// A link of the URDF, by name.
    Link(String),
    /// A joint of the URDF, by name.
    Joint(String),
    /// The spring of a joint, by the joint's name.
    ElasticJoint(String),
    /// An extra elastic coordinate, by its place in the list.
    Extra(usize),
    /// Default damping.
    Damping,
    /// The direction or size of gravity.
    Gravity,
    /// A reflected rotor inertia, by the joint's name.
    Drive(String),
    /// The payload.
    Payload,
    /// One of the angles of the two-link model: `beta1` or `beta2`.
    ArmAngle(&'static str),
    /// A correction, by its place in the list.
    Correction(usize),
}

/// One fault (or, from [`super::Robot::notices`], one remark) about a robot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModelFault {
    /// Where it lies.
    pub place: Place,
    /// The key within the place, as the file spells it; empty for the place as a whole.
    pub key: &'static str,
    /// What was read and what was expected, as a lower-case fragment.
    pub what: String,
}

impl ModelFault {
    /// A fault at a place.
    pub fn new(place: Place, key: &'static str, what: impl Into<String>) -> Self {
        Self { place, key, what: what.into() }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Robot => write!(f, "robot"),
            Self::Base => write!(f, "base"),
            Self::Tip => write!(f, "tip"),
            Self::Link(name) => write!(f, "link '{name}'"),
            Self::Joint(name) | Self::ElasticJoint(name) => write!(f, "joint '{name}'"),
            Self::Extra(index) => write!(f, "extra coordinate {}", index + 1),
            Self::Damping => write!(f, "damping"),
            Self::Gravity => write!(f, "gravity"),
            Self::Drive(name) => write!(f, "drive of joint '{name}'"),
            Self::Payload => write!(f, "payload"),
            Self::ArmAngle(angle) => write!(f, "arm angle {angle}"),
            Self::Correction(index) => write!(f, "correction {}", index + 1),
        }
    }
}

impl fmt::Display for ModelFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.what)
    }
}

impl std::error::Error for ModelFault {}

/// Why a robot has no modes at a pose.
#[derive(Debug, Clone, PartialEq)]
pub enum PoseFault {
    /// The pose has another number of values than the robot has moving joints.
    Length {
        /// Values given.
        given: usize,
        /// Moving joints of the robot.
        expected: usize,
    },
    /// A joint position is not a finite number.
    NotFinite {
        /// URDF name of the joint.
        joint: String,
    },
    /// The mass matrix is singular or indefinite: `coordinate` moves nothing that has inertia which the
    /// coordinates before it do not move just as well.
    MassNotPositive {
        /// Name of the elastic coordinate.
        coordinate: String,
    },
    /// The stiffness matrix is singular or indefinite: gravity pulls harder than the spring holds.
    StiffnessNotPositive {
        /// Name of the elastic coordinate.
        coordinate: String,
    },
}

impl fmt::Display for PoseFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { given, expected } => {
                write!(f, "pose has {given} values, must have {expected}, one per moving joint")
            }
            Self::NotFinite { joint } => {
                write!(f, "joint '{joint}': position is not a finite number")
            }
            Self::MassNotPositive { coordinate } => write!(
                f,
                "elastic coordinate '{coordinate}': the mass matrix is singular here, as nothing with \
                 inertia moves with it alone; give the links behind it mass and inertia, or leave it rigid"
            ),
            Self::StiffnessNotPositive { coordinate } => write!(
                f,
                "elastic coordinate '{coordinate}': stiffness minus the pull of gravity is not positive, \
                 so the arm would fall over; check its stiffness and the masses behind it"
            ),
        }
    }
}

impl std::error::Error for PoseFault {}
