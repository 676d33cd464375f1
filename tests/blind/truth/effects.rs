//! Every cause of the vocabulary, and some beyond it, as a change of a world with one size.

use nalgebra::{Matrix3, Vector3};

use super::arm::{Body, Kind};
use super::dynamics::rotation;
use super::world::{Bend, Law, ModeLaw, World, extra};

/// The causes that a diagnosis may name.
pub(crate) const VOCABULARY: [&str; 16] = [
    "joint_stiffness",
    "link_inertia",
    "com_offset",
    "joint_zero_offset",
    "payload",
    "base_compliance",
    "transverse_compliance",
    "link_flexibility",
    "drive_inertia",
    "load_dependent_stiffness",
    "amplitude_dependence",
    "temperature_drift",
    "gravity_stiffness",
    "aliased_mode",
    "missed_mode",
    "position_dependent_stiffness",
];

/// Effects beyond the vocabulary.
pub(crate) const BEYOND: [&str; 5] = ["absorber", "jump", "smooth", "hysteresis", "scatter"];

/// How a spring's constant follows the load.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LoadLaw {
    Stiffens,
    Softens,
    Saturates,
}

/// A change of the world. Joints, modes and columns count from 0; links from 1, 0 being the base.
#[derive(Debug, Clone)]
pub(crate) enum Change {
    /// Factor 1 + size or its inverse.
    JointStiffness {
        joint: usize,
        softer: bool,
    },
    /// Factor 1 + size on the tensor about the centre of mass, or its inverse; on the mass, too, if asked.
    LinkInertia {
        link: usize,
        larger: bool,
        with_mass: bool,
    },
    /// The centre of mass moved by `size` m.
    ComShift {
        link: usize,
        direction: Vector3<f64>,
    },
    /// The centre of mass turned about the link's joint by `size` rad.
    ComTurn {
        link: usize,
        sign: f64,
    },
    /// `size` rad.
    ZeroOffset {
        joint: usize,
        sign: f64,
    },
    /// `size` kg at a point of a link; `tool` says that it hangs at the tool frame.
    Payload {
        link: usize,
        com_m: Vector3<f64>,
        /// Radius of gyration about any axis.
        gyration_m: f64,
        tool: bool,
    },
    /// An extra coordinate of compliance `size` / `stiff`.
    Compliance {
        what: Compliance,
        link: usize,
        kind: Kind,
        axis: Vector3<f64>,
        origin_m: Vector3<f64>,
        stiff: f64,
    },
    /// The link's outer part bends, compliance `size` / `stiff`.
    Bend {
        link: usize,
        fraction: f64,
        axis: Vector3<f64>,
        stiff: f64,
    },
    /// `size` times `unit_kgm2`.
    Drive {
        joint: usize,
        unit_kgm2: f64,
    },
    Load {
        joint: usize,
        law: LoadLaw,
        reference_nm: f64,
    },
    Amplitude {
        joint: usize,
        power: bool,
        reference_nm: f64,
    },
    /// `size` per kelvin.
    Temperature {
        joint: usize,
    },
    /// Gravity acts, and the model does not know; no size.
    Gravity,
    /// No size.
    Aliased {
        mode: usize,
        sample_rate_hz: f64,
    },
    /// No size.
    Missed {
        mode: usize,
    },
    Wave {
        joint: usize,
        phase_rad: f64,
    },
    Absorber {
        mode: usize,
        frequency_hz: f64,
    },
    Jump {
        joint: usize,
        sign: f64,
    },
    Smooth {
        waves: Vec<Vec<(Vec<f64>, f64)>>,
        means: Vec<f64>,
    },
    Hysteresis {
        joint: usize,
    },
    /// All modes of a pose off together, nobody knows why.
    Scatter,
}

/// What an extra coordinate stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Compliance {
    Base,
    Transverse,
    Link,
}

/// A number of the truth that an estimate may be compared with: the ending of the parameter's name, what the
/// model had, and what is true.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Known {
    pub(crate) ending: &'static str,
    pub(crate) nominal: f64,
    pub(crate) value: f64,
}

fn known(ending: &'static str, nominal: f64, value: f64) -> Known {
    Known { ending, nominal, value }
}

impl Change {
    /// The largest size that a machine could have.
    pub(crate) fn most(&self) -> f64 {
        match self {
            Self::JointStiffness { .. } => 1.5,
            Self::LinkInertia { .. } => 2.5,
            Self::ComShift { .. } => 0.3,
            Self::ComTurn { .. } => 0.8,
            Self::ZeroOffset { .. } => 0.35,
            Self::Payload { .. } => 60.0,
            Self::Compliance { .. } | Self::Bend { .. } => 20.0,
            Self::Drive { .. } => 4.0,
            Self::Load { law: LoadLaw::Softens, .. } => 2.5,
            Self::Load { .. } => 1.5,
            Self::Amplitude { power: true, .. } => 0.4,
            Self::Amplitude { .. } => 0.6,
            Self::Temperature { .. } => 0.015,
            Self::Gravity | Self::Aliased { .. } | Self::Missed { .. } => 1.0,
            Self::Wave { .. } | Self::Hysteresis { .. } => 0.6,
            Self::Absorber { .. } => 0.3,
            Self::Jump { .. } => 0.7,
            Self::Scatter => 0.2,
            Self::Smooth { .. } => 0.3,
        }
    }

    /// Whether the size may be chosen.
    pub(crate) fn has_size(&self) -> bool {
        !matches!(self, Self::Gravity | Self::Aliased { .. } | Self::Missed { .. })
    }

    /// Puts the change into a world.
    pub(crate) fn apply(&self, world: &mut World, size: f64) {
        match self {
            Self::JointStiffness { joint, softer } => {
                let factor = if *softer { 1.0 / (1.0 + size) } else { 1.0 + size };
                world.arm.joints[*joint].stiffness_nm_per_rad *= factor;
            }
            Self::LinkInertia { link, larger, with_mass } => {
                let factor = if *larger { 1.0 + size } else { 1.0 / (1.0 + size) };
                let body = &mut world.arm.joints[link - 1].body;
                body.inertia_kgm2 *= factor;
                if *with_mass {
                    body.mass_kg *= factor;
                }
            }
            Self::ComShift { link, direction } => {
                world.arm.joints[link - 1].body.com_m += direction * size;
            }
            Self::ComTurn { link, sign } => {
                let joint = &mut world.arm.joints[link - 1];
                joint.body.com_m = rotation(&joint.axis, sign * size) * joint.body.com_m;
            }
            Self::ZeroOffset { joint, sign } => world.zero_rad[*joint] += sign * size,
            Self::Payload { link, com_m, gyration_m, .. } => {
                let mut body = Body::point(size, *com_m);
                body.inertia_kgm2 = Matrix3::identity() * (size * gyration_m * gyration_m);
                world.carried.push((*link, body));
            }
            Self::Compliance { link, kind, axis, origin_m, stiff, .. } => {
                world.arm.extras.push(extra(*link, *kind, *axis, *origin_m, stiff / size));
            }
            Self::Bend { link, fraction, axis, stiff } => world.bends.push(Bend {
                link: *link,
                fraction: *fraction,
                axis: *axis,
                stiffness_nm_per_rad: stiff / size,
            }),
            Self::Drive { joint, unit_kgm2 } => {
                world.arm.joints[*joint].drive_kgm2 += size * unit_kgm2;
            }
            Self::Load { joint, law, reference_nm } => {
                let (a, reference_nm) = (size, *reference_nm);
                let law = match law {
                    LoadLaw::Stiffens => Law::LoadStiffens { a, reference_nm },
                    LoadLaw::Softens => Law::LoadSoftens { a, reference_nm },
                    LoadLaw::Saturates => Law::LoadSaturates { a, reference_nm },
                };
                world.laws.push((*joint, law));
            }
            Self::Amplitude { joint, power, reference_nm } => {
                let (a, reference_nm) = (size, *reference_nm);
                let law = if *power {
                    Law::AmplitudePower { a, reference_nm }
                } else {
                    Law::AmplitudeSoftens { a, reference_nm }
                };
                world.laws.push((*joint, law));
            }
            Self::Temperature { joint } => world.laws.push((*joint, Law::Warms { per_k: size })),
            Self::Gravity => world.arm.gravity_stiffness = true,
            Self::Aliased { sample_rate_hz, .. } => {
                world.instrument.sample_rate_hz = Some(*sample_rate_hz);
            }
            Self::Missed { mode } => world.instrument.missed_mode = Some(*mode),
            Self::Wave { joint, phase_rad } => {
                world.laws.push((*joint, Law::Wave { a: size, phase_rad: *phase_rad }));
            }
            Self::Absorber { mode, frequency_hz } => world.mode_laws.push(ModeLaw::Absorber {
                mode: *mode,
                frequency_hz: *frequency_hz,
                coupling: size,
            }),
            Self::Jump { joint, sign } => {
                world.laws.push((*joint, Law::Jump { a: sign * size }));
            }
            Self::Smooth { waves, means } => world.mode_laws.push(ModeLaw::Smooth {
                a: size,
                waves: waves.clone(),
                means: means.clone(),
            }),
            Self::Scatter => world.mode_laws.push(ModeLaw::Scatter { a: size }),
            Self::Hysteresis { joint } => world.laws.push((*joint, Law::Hysteresis { a: size })),
        }
    }

    /// Parameters under which an estimate may be compared with the truth, in a nominal world.
    pub(crate) fn known(&self, nominal: &World, size: f64) -> Vec<Known> {
        let mut after = nominal.clone();
        self.apply(&mut after, size);
        let (before, after) = (&nominal.arm, &after.arm);
        match self {
            Self::JointStiffness { joint, .. } => {
                let k0 = before.joints[*joint].stiffness_nm_per_rad;
                let k = after.joints[*joint].stiffness_nm_per_rad;
                let mut all = vec![known("nm_per_rad", k0, k)];
                all.extend(ratios(k / k0));
                all
            }
            Self::LinkInertia { link, with_mass: true, .. } => {
                let m0 = before.joints[link - 1].body.mass_kg;
                let m = after.joints[link - 1].body.mass_kg;
                vec![known("mass_factor", 1.0, m / m0)]
            }
            Self::LinkInertia { link, .. } => {
                let i0 = &before.joints[link - 1].body.inertia_kgm2;
                let i = &after.joints[link - 1].body.inertia_kgm2;
                let mut all = ratios(i[(1, 1)] / i0[(1, 1)]);
                all.push(known("xx_kgm2", i0[(0, 0)], i[(0, 0)]));
                all.push(known("yy_kgm2", i0[(1, 1)], i[(1, 1)]));
                all.push(known("zz_kgm2", i0[(2, 2)], i[(2, 2)]));
                all
            }
            Self::ComShift { link, .. } | Self::ComTurn { link, .. } => {
                let c0 = before.joints[link - 1].body.com_m;
                let c = after.joints[link - 1].body.com_m;
                let mut all = Vec::new();
                for (i, ending) in ["x_m", "y_m", "z_m"].into_iter().enumerate() {
                    all.push(known(ending, c0[i], c[i]));
                    all.push(known(ending, 0.0, c[i] - c0[i]));
                }
                if let Self::ComTurn { sign, .. } = self {
                    all.push(known("angle_rad", 0.0, sign * size));
                }
                all
            }
            Self::ZeroOffset { sign, .. } => {
                vec![known("rad", 0.0, sign * size), known("deg", 0.0, (sign * size).to_degrees())]
            }
            Self::Payload { tool, .. } => {
                let carried = before.payload.as_ref().filter(|_| *tool).map_or(0.0, |p| p.mass_kg);
                vec![known("mass_kg", carried, carried + size), known("mass_kg", 0.0, size)]
            }
            Self::Compliance { what: Compliance::Base, kind, origin_m, stiff, .. }
                if *origin_m == Vector3::zeros() =>
            {
                let ending = match kind {
                    Kind::Rotation => "nm_per_rad",
                    Kind::Translation => "n_per_m",
                };
                vec![known(ending, f64::INFINITY, stiff / size)]
            }
            Self::Compliance { what: Compliance::Transverse, stiff, .. } => {
                vec![known("nm_per_rad", f64::INFINITY, stiff / size)]
            }
            Self::Drive { joint, .. } => {
                let d0 = before.joints[*joint].drive_kgm2;
                let d = after.joints[*joint].drive_kgm2;
                vec![known("kgm2", d0, d), known("kgm2", 0.0, d - d0)]
            }
            Self::Compliance { .. }
            | Self::Bend { .. }
            | Self::Load { .. }
            | Self::Amplitude { .. }
            | Self::Temperature { .. }
            | Self::Gravity
            | Self::Aliased { .. }
            | Self::Missed { .. }
            | Self::Wave { .. }
            | Self::Absorber { .. }
            | Self::Jump { .. }
            | Self::Smooth { .. }
            | Self::Scatter
            | Self::Hysteresis { .. } => Vec::new(),
        }
    }
}

/// A ratio under the names that it may have.
fn ratios(ratio: f64) -> Vec<Known> {
    let mut all: Vec<Known> =
        ["factor", "ratio", "scale"].map(|ending| known(ending, 1.0, ratio)).to_vec();
    all.push(known("percent", 0.0, 100.0 * (ratio - 1.0)));
    all
}

/// A change with its name in the vocabulary and its place.
#[derive(Debug, Clone)]
pub(crate) struct Effect {
    pub(crate) cause: &'static str,
    /// Names of the place that are right: the first is the truth's own, others are rigidly one with it.
    pub(crate) at: Vec<String>,
    pub(crate) change: Change,
}
