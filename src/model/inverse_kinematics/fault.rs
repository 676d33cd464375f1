//! Why a pose of the tip has no joint positions.

use std::fmt;

use crate::model::pose_fault::PoseFault;
use crate::units::{deg_from_rad, mm_from_m};
use crate::wording::distinguishable;

/// Why a pose of the tip has no joint positions.
#[derive(Debug, Clone, PartialEq)]
pub enum IkFault {
    /// The pose asked for holds a number that is not finite.
    TargetNotFinite,
    /// The seed is not a pose of the robot.
    Seed(PoseFault),
    /// No joint positions bring the tip to the pose.
    OutOfReach {
        /// How far off the tip remains at the nearest pose found, m.
        distance_m: f64,
        /// How far its orientation remains off there, rad.
        angle_rad: f64,
    },
    /// The pose can be reached only with a joint outside its limits.
    OverLimit {
        /// URDF name of the joint that goes farthest over its limit.
        joint: String,
        /// Whether the joint slides: then `value` and `limit` are m, otherwise rad.
        slides: bool,
        /// Where the joint would have to be.
        value: f64,
        /// The limit that it passes.
        limit: f64,
    },
}

impl fmt::Display for IkFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TargetNotFinite => write!(f, "pose of the tip must be finite"),
            Self::Seed(fault) => write!(f, "starting {fault}"),
            Self::OutOfReach { distance_m, angle_rad } => write!(
                f,
                "out of reach: the nearest pose found is {:.3} mm and {:.3}° away",
                mm_from_m(*distance_m),
                deg_from_rad(*angle_rad)
            ),
            Self::OverLimit { joint, slides, value, limit } => {
                let (value, limit, unit) = if *slides {
                    (mm_from_m(*value), mm_from_m(*limit), " mm")
                } else {
                    (deg_from_rad(*value), deg_from_rad(*limit), "°")
                };
                let [value, limit] = distinguishable(value, limit, 3);
                write!(
                    f,
                    "joint '{joint}' would have to be at {value}{unit}, over its limit of \
                     {limit}{unit}"
                )
            }
        }
    }
}

impl std::error::Error for IkFault {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::rad_from_deg;

    #[test]
    fn a_limit_passed_by_a_hair_shows_the_hair() {
        let fault = IkFault::OverLimit {
            joint: "a".into(),
            slides: false,
            value: rad_from_deg(65.000_02),
            limit: rad_from_deg(65.0),
        };
        let expected = "joint 'a' would have to be at 65.00002°, over its limit of 65.00000°";
        assert_eq!(fault.to_string(), expected);
    }
}
