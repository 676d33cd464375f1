//! Frequencies over poses: by the modal kernel, or from the spectrum of a large free vibration.

mod bins;
mod block;
mod frequencies;
mod generate;
mod limits;
mod reduce;
mod shapes;

pub use bins::Bin;
pub use block::{Block, Row};
pub use frequencies::FrequencyMap;
pub use generate::{Generator, Grid, GridAxis, RandomPoses};
pub use limits::OutsideLimits;
pub use reduce::{
    EXACT_UP_TO, Extreme, RESOLUTION, Reduced, ReducedMode, Reduction, SHARES, Statistic,
};
pub use shapes::ModeShape;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::free_vibration::Settings;
use crate::model::{CoordinateKind, JointKind, MovingJoint};

/// How frequencies are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// Eigenvalues of (M, K): small vibrations.
    Linear,
    /// Peaks in the spectrum of the nonlinear free vibration: the paper's Fig. 5.
    Nonlinear(Settings),
}

/// What the columns of a map are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// The robot's name.
    pub robot: String,
    /// The moving joints, base to tip.
    pub joints: Vec<JointColumn>,
    /// Whether rows have β2.
    pub has_beta2: bool,
    /// Names of the elastic coordinates, base first; there are as many modes.
    pub coordinates: Vec<String>,
    /// Their units: rad or m.
    #[serde(deserialize_with = "units")]
    pub coordinate_units: Vec<&'static str>,
    /// Whether every frequency has its interval.
    pub has_intervals: bool,
    /// The links whose rotations the mode shapes have; `None` where there are no shapes.
    pub shape_links: Option<Vec<String>>,
}

/// A joint as a column of a map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointColumn {
    /// URDF name.
    pub name: String,
    /// Whether it turns (rad) or slides (m).
    #[serde(rename = "unit", serialize_with = "unit", deserialize_with = "turns")]
    pub turns: bool,
}

fn unit<S: Serializer>(turns: &bool, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(if *turns { "rad" } else { "m" })
}

fn turns<'de, D: Deserializer<'de>>(from: D) -> Result<bool, D::Error> {
    is_angle(&String::deserialize(from)?)
}

fn units<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<&'static str>, D::Error> {
    let units = Vec::<String>::deserialize(from)?;
    units.iter().map(|unit| Ok(if is_angle(unit)? { "rad" } else { "m" })).collect()
}

fn is_angle<E: serde::de::Error>(unit: &str) -> Result<bool, E> {
    match unit {
        "rad" => Ok(true),
        "m" => Ok(false),
        other => Err(E::custom(format!("unit is '{other}', must be rad or m"))),
    }
}

impl Head {
    /// The columns of a map.
    pub fn of(map: &FrequencyMap) -> Self {
        let robot = map.robot();
        let column = |joint: &MovingJoint| JointColumn {
            name: joint.name.clone(),
            turns: joint.kind != JointKind::Prismatic,
        };
        Self {
            robot: robot.name().to_owned(),
            joints: robot.joints().iter().map(column).collect(),
            has_beta2: robot.beta2().is_some(),
            coordinates: robot.coordinates().iter().map(|c| c.name.clone()).collect(),
            coordinate_units: robot
                .coordinates()
                .iter()
                .map(|c| if c.kind == CoordinateKind::Rotation { "rad" } else { "m" })
                .collect(),
            has_intervals: map.has_intervals(),
            shape_links: map.shape_links().map(<[String]>::to_vec),
        }
    }
}
