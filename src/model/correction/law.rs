//! How a spring's constant departs from its nominal value with the pose and the conditions of a
//! test.

/// Temperature at which springs have their nominal constant, °C.
pub const REFERENCE_TEMPERATURE_C: f64 = 20.0;

/// A law never takes a spring below this share of its constant.
const MIN_SHARE: f64 = 0.02;

/// Levels of excitation below this are this one, N·m: a power law has no bounds of its own.
const MIN_AMPLITUDE_NM: f64 = 1e-3;

/// How a spring's constant departs from its nominal value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StiffnessLaw {
    /// k (1 + c |τ| / (1 + |τ|/τ_s)), τ the gravity torque that the spring carries at the pose,
    /// N·m.
    Load {
        /// c, 1/(N·m).
        change_per_nm: f64,
        /// τ_s, N·m; infinite where the law is straight.
        saturation_nm: f64,
    },
    /// k (factor + c A), A the level of excitation, N·m; A = 0 where none is given.
    Amplitude {
        /// Share of k that is left at rest.
        factor: f64,
        /// c, 1/(N·m).
        change_per_nm: f64,
    },
    /// k · factor · (A / 1 N·m)^exponent; A = 1 N·m where none is given.
    AmplitudePower {
        /// Share of k at 1 N·m.
        factor: f64,
        /// Of the level.
        exponent: f64,
    },
    /// k (factor + c (T − 20 °C)); 20 °C where no temperature is given.
    Temperature {
        /// Share of k at 20 °C.
        factor: f64,
        /// c, 1/K.
        change_per_k: f64,
    },
}

/// What a measurement was made under, beside the pose.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Conditions {
    /// °C.
    pub temperature_c: Option<f64>,
    /// Joint torque of the excitation, N·m.
    pub amplitude_nm: Option<f64>,
}

impl StiffnessLaw {
    /// k over its nominal value.
    pub(in crate::model) fn share(&self, gravity_torque_nm: f64, conditions: &Conditions) -> f64 {
        let share = match *self {
            Self::Load { change_per_nm, saturation_nm } => {
                let torque = gravity_torque_nm.abs();
                1.0 + change_per_nm * torque / (1.0 + torque / saturation_nm)
            }
            Self::Amplitude { factor, change_per_nm } => {
                factor + change_per_nm * conditions.amplitude_nm.unwrap_or(0.0)
            }
            Self::AmplitudePower { factor, exponent } => {
                let level_nm = conditions.amplitude_nm.unwrap_or(1.0).max(MIN_AMPLITUDE_NM);
                factor * level_nm.powf(exponent)
            }
            Self::Temperature { factor, change_per_k } => {
                let temperature_c = conditions.temperature_c.unwrap_or(REFERENCE_TEMPERATURE_C);
                factor + change_per_k * (temperature_c - REFERENCE_TEMPERATURE_C)
            }
        };
        share.max(MIN_SHARE)
    }

    /// Whether it depends on the pose.
    pub(in crate::model) fn follows_pose(&self) -> bool {
        match self {
            Self::Load { .. } => true,
            Self::Amplitude { .. } | Self::AmplitudePower { .. } | Self::Temperature { .. } => {
                false
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand, at values where the share is plain.
    #[test]
    fn laws_give_the_shares_that_they_state() {
        let at = |temperature_c, amplitude_nm| Conditions {
            temperature_c: Some(temperature_c),
            amplitude_nm: Some(amplitude_nm),
        };
        let here = at(30.0, 16.0);
        let load =
            |change_per_nm, saturation_nm| StiffnessLaw::Load { change_per_nm, saturation_nm };
        let power = StiffnessLaw::AmplitudePower { factor: 2.0, exponent: -0.5 };
        let warm = StiffnessLaw::Temperature { factor: 0.9, change_per_k: -0.004 };
        let level = StiffnessLaw::Amplitude { factor: 1.0, change_per_nm: -0.01 };
        for (law, share, nominal) in [
            (load(0.001, f64::INFINITY), 1.2, 1.2),
            // 1 / (1 + τ/τ_s) is c = −1/τ_s.
            (load(-0.005, 200.0), 0.5, 0.5),
            (power, 0.5, 2.0),
            (warm, 0.86, 0.9),
            (level, 0.84, 1.0),
            (load(-1.0, f64::INFINITY), MIN_SHARE, MIN_SHARE),
        ] {
            assert!((law.share(-200.0, &here) - share).abs() < 1e-12, "{law:?}");
            assert!((law.share(200.0, &Conditions::default()) - nominal).abs() < 1e-12, "{law:?}");
        }
    }
}
