//! How a spring's constant departs from its nominal value with the pose and the conditions of a
//! test.

use crate::wording::rounded;

/// Temperature at which springs have their nominal constant, °C.
pub const REFERENCE_TEMPERATURE_C: f64 = 20.0;

/// A law never takes a spring below this share of its constant.
const MIN_SHARE: f64 = 0.02;

/// Levels of excitation below this are this one, N·m: a power law has no bounds of its own.
const MIN_AMPLITUDE_NM: f64 = 1e-3;

/// The steps of a gear's stiffness are rounded over this share of their torque.
const STEP_WIDTH: f64 = 0.05;

/// How a spring's constant departs from its nominal value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StiffnessLaw {
    /// k (factor + c (g(|τ|) − g(τ_0))), g(τ) = τ / (1 + τ/τ_s), τ the gravity torque that the
    /// spring carries at the pose, N·m.
    Load {
        /// Share of k at τ_0.
        factor: f64,
        /// c, 1/(N·m).
        change_per_nm: f64,
        /// τ_s, N·m; infinite where the law is straight.
        saturation_nm: f64,
        /// τ_0, N·m.
        reference_nm: f64,
    },
    /// The three slopes of a gear: k · factor between τ_1 and τ_2, times a ratio below and another
    /// above; rounded over a twentieth of these torques.
    LoadSteps {
        /// Share of k between the torques.
        factor: f64,
        /// Stiffness below τ_1 and above τ_2 over that between.
        ratios: [f64; 2],
        /// τ_1 and τ_2, N·m.
        torques_nm: [f64; 2],
    },
    /// k (factor + c (A − A_0)), A the level of excitation, N·m; A = A_0 where none is given.
    Amplitude {
        /// Share of k at A_0.
        factor: f64,
        /// c, 1/(N·m).
        change_per_nm: f64,
        /// A_0, N·m.
        reference_nm: f64,
    },
    /// k · factor · (A / A_0)^exponent; A = A_0 where none is given.
    AmplitudePower {
        /// Share of k at A_0.
        factor: f64,
        /// Of the level.
        exponent: f64,
        /// A_0, N·m.
        reference_nm: f64,
    },
    /// k (factor + c (T − T_0)); T_0 where no temperature is given.
    Temperature {
        /// Share of k at T_0.
        factor: f64,
        /// c, 1/K.
        change_per_k: f64,
        /// T_0, °C.
        reference_c: f64,
    },
    /// k (factor + Σ a_n cos n q + b_n sin n q), n = 1 to 3, q the joint's own position, rad.
    Position {
        /// Mean share of k.
        factor: f64,
        /// a_n and b_n.
        harmonics: [[f64; 2]; 3],
    },
}

/// What a spring carries and where its joint stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::model) struct SpringState {
    /// N·m or N.
    pub(in crate::model) gravity_torque_nm: f64,
    /// rad or m.
    pub(in crate::model) position: f64,
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
    /// The temperature or level of excitation at which a spring that varies with it counts, where
    /// none is given.
    pub(in crate::model) fn taken_at(&self) -> Option<String> {
        match *self {
            Self::Temperature { change_per_k, reference_c, .. } => {
                (change_per_k != 0.0).then(|| format!("{} °C", rounded(reference_c, 1)))
            }
            Self::Amplitude { change_per_nm, reference_nm, .. } => {
                (change_per_nm != 0.0).then(|| format!("{} N·m", rounded(reference_nm, 1)))
            }
            Self::AmplitudePower { exponent, reference_nm, .. } => {
                (exponent != 0.0).then(|| format!("{} N·m", rounded(reference_nm, 1)))
            }
            Self::Load { .. } | Self::LoadSteps { .. } | Self::Position { .. } => None,
        }
    }

    /// k over its nominal value.
    pub(in crate::model) fn share(&self, state: SpringState, conditions: &Conditions) -> f64 {
        let torque = state.gravity_torque_nm.abs();
        let share = match *self {
            Self::Load { factor, change_per_nm, saturation_nm, reference_nm } => {
                let bent = |torque: f64| torque / (1.0 + torque / saturation_nm);
                factor + change_per_nm * (bent(torque) - bent(reference_nm))
            }
            Self::LoadSteps { factor, ratios: [below, above], torques_nm: [first, second] } => {
                let beyond = |at: f64| {
                    let width = (STEP_WIDTH * at.abs()).max(MIN_AMPLITUDE_NM);
                    1.0 / (1.0 + (-(torque - at) / width).exp())
                };
                factor * (below + (1.0 - below) * beyond(first) + (above - 1.0) * beyond(second))
            }
            Self::Amplitude { factor, change_per_nm, reference_nm } => {
                let level_nm = conditions.amplitude_nm.unwrap_or(reference_nm);
                factor + change_per_nm * (level_nm - reference_nm)
            }
            Self::AmplitudePower { factor, exponent, reference_nm } => {
                let level_nm = conditions.amplitude_nm.unwrap_or(reference_nm);
                let [level_nm, reference_nm] =
                    [level_nm, reference_nm].map(|nm| nm.max(MIN_AMPLITUDE_NM));
                factor * (level_nm / reference_nm).powf(exponent)
            }
            Self::Temperature { factor, change_per_k, reference_c } => {
                let temperature_c = conditions.temperature_c.unwrap_or(reference_c);
                factor + change_per_k * (temperature_c - reference_c)
            }
            Self::Position { factor, harmonics } => {
                let q = state.position;
                let waves = harmonics
                    .iter()
                    .zip([1.0, 2.0, 3.0])
                    .map(|([cos, sin], n)| cos * f64::cos(n * q) + sin * f64::sin(n * q));
                factor + waves.sum::<f64>()
            }
        };
        share.max(MIN_SHARE)
    }

    /// Whether it depends on the pose.
    pub(in crate::model) fn follows_pose(&self) -> bool {
        match self {
            Self::Load { .. } | Self::LoadSteps { .. } | Self::Position { .. } => true,
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
        let load = |change_per_nm, saturation_nm| StiffnessLaw::Load {
            factor: 1.0,
            change_per_nm,
            saturation_nm,
            reference_nm: 0.0,
        };
        let power = StiffnessLaw::AmplitudePower { factor: 2.0, exponent: -0.5, reference_nm: 1.0 };
        let warm =
            StiffnessLaw::Temperature { factor: 0.9, change_per_k: -0.004, reference_c: 20.0 };
        let centred =
            StiffnessLaw::Temperature { factor: 0.9, change_per_k: -0.004, reference_c: 35.0 };
        let level =
            StiffnessLaw::Amplitude { factor: 1.0, change_per_nm: -0.01, reference_nm: 0.0 };
        // At half a turn the first and the third wave are −1, the second 1.
        let mesh = StiffnessLaw::Position {
            factor: 1.0,
            harmonics: [[0.1, 7.0], [0.02, 7.0], [0.03, 7.0]],
        };
        // Far below, between and above.
        let steps = |first, second| StiffnessLaw::LoadSteps {
            factor: 1.1,
            ratios: [0.5, 1.5],
            torques_nm: [first, second],
        };
        for (law, share, nominal) in [
            (load(0.001, f64::INFINITY), 1.2, 1.2),
            // 1 / (1 + τ/τ_s) is c = −1/τ_s.
            (load(-0.005, 200.0), 0.5, 0.5),
            (power, 0.5, 2.0),
            (warm, 0.86, 0.9),
            (centred, 0.92, 0.9),
            (mesh, 0.89, 0.89),
            (steps(4000.0, 8000.0), 0.55, 0.55),
            (steps(20.0, 8000.0), 1.1, 1.1),
            (steps(10.0, 20.0), 1.65, 1.65),
            (level, 0.84, 1.0),
            (load(-1.0, f64::INFINITY), MIN_SHARE, MIN_SHARE),
        ] {
            let state = |gravity_torque_nm| SpringState {
                gravity_torque_nm,
                position: std::f64::consts::PI,
            };
            let (left, right) = (state(-200.0), state(200.0));
            assert!((law.share(left, &here) - share).abs() < 1e-7, "{law:?}");
            assert!((law.share(right, &Conditions::default()) - nominal).abs() < 1e-7, "{law:?}");
        }
    }
}
