//! Why a robot has no modes at a pose.

use std::fmt;

use crate::notes::{Code, Note, Place};

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
    /// The mass matrix is singular or indefinite: `coordinate` moves nothing that has inertia which
    /// the coordinates before it do not move just as well.
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
                "elastic coordinate '{coordinate}': the mass matrix is singular here, as nothing \
                 with inertia moves with it alone; give the links behind it mass and inertia, or \
                 leave it rigid"
            ),
            Self::StiffnessNotPositive { coordinate } => write!(
                f,
                "elastic coordinate '{coordinate}': stiffness minus the pull of gravity is not \
                 positive, so the arm would fall over; check its stiffness and the masses behind it"
            ),
        }
    }
}

impl std::error::Error for PoseFault {}

impl From<PoseFault> for Note {
    fn from(fault: PoseFault) -> Self {
        let code = match fault {
            PoseFault::Length { .. } | PoseFault::NotFinite { .. } => Code::Value,
            PoseFault::MassNotPositive { .. } | PoseFault::StiffnessNotPositive { .. } => {
                Code::Singular
            }
        };
        Self::error(code, Place::default(), fault.to_string())
    }
}
