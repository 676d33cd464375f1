//! Corrections of a robot's description: each names its cause, its place and its parameters, and is
//! applied before the model is built. What depends on the pose or on the conditions of a measurement
//! becomes a law of the spring.

use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};

use super::cause::Cause;
use super::description::{
    CoordinateKind, Description, Drive, ExtraCoordinate, Inertial, Joint, JointKind, Link,
};
use super::fault::{ModelFault, Place};

/// Temperature at which springs have their nominal constant, °C.
pub const REFERENCE_TEMPERATURE_C: f64 = 20.0;

/// A law never takes a spring below this share of its constant.
const SOFTEST_SHARE: f64 = 0.02;

/// One correction.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// What was wrong.
    pub cause: Cause,
    /// The joint, link or mode; `None` where the cause has no place.
    pub at: Option<String>,
    /// Values by name, in SI.
    pub parameters: Vec<(String, f64)>,
    /// Where and how something gives, for the three causes that add an elastic coordinate.
    pub hinge: Option<Hinge>,
}

/// Where and how a foundation, a joint or a link gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Hinge {
    /// Rotation or translation.
    pub kind: CoordinateKind,
    /// One elastic coordinate along or about each, in the link's frame; all have the same stiffness.
    pub axes: Vec<Vector3<f64>>,
    /// A point of the axes, in the link's frame, m.
    pub origin_m: Vector3<f64>,
    /// Whether the link itself stays and only what it carries moves.
    pub beyond: bool,
}

impl Hinge {
    /// Whether it turns.
    pub fn turns(&self) -> bool {
        self.kind == CoordinateKind::Rotation
    }
}

/// How a spring's constant departs from its nominal value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StiffnessLaw {
    /// k (1 + c |τ|), τ the gravity torque that the spring carries at the pose, N·m.
    Load {
        /// c, 1/(N·m).
        change_per_nm: f64,
    },
    /// k (factor + c A), A the level of excitation, N·m; A = 0 where none is told.
    Amplitude {
        /// Share of k that is left at rest.
        factor: f64,
        /// c, 1/(N·m).
        change_per_nm: f64,
    },
    /// k (factor + c (T − 20 °C)); 20 °C where no temperature is told.
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
    pub(super) fn share(&self, gravity_torque_nm: f64, conditions: &Conditions) -> f64 {
        let share = match *self {
            Self::Load { change_per_nm } => 1.0 + change_per_nm * gravity_torque_nm.abs(),
            Self::Amplitude { factor, change_per_nm } => {
                factor + change_per_nm * conditions.amplitude_nm.unwrap_or(0.0)
            }
            Self::Temperature { factor, change_per_k } => {
                let temperature_c = conditions.temperature_c.unwrap_or(REFERENCE_TEMPERATURE_C);
                factor + change_per_k * (temperature_c - REFERENCE_TEMPERATURE_C)
            }
        };
        share.max(SOFTEST_SHARE)
    }
}

impl Correction {
    /// The value of a parameter.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|(of, _)| of == name).map(|&(_, value)| value)
    }

    /// The names of parameters that `cause` knows; those before the bar must be given, except that one of
    /// several alternatives suffices.
    pub fn parameter_names(cause: Cause) -> &'static [&'static str] {
        match cause {
            Cause::JointStiffness | Cause::BaseCompliance => {
                &["stiffness_nm_per_rad", "stiffness_n_per_m"]
            }
            Cause::LinkInertia => &["inertia_factor", "mass_factor"],
            Cause::ComOffset => &["dx_m", "dy_m", "dz_m"],
            Cause::JointZeroOffset => &["offset_rad", "offset_m"],
            Cause::Payload => &["mass_kg", "com_x_m", "com_y_m", "com_z_m"],
            Cause::TransverseCompliance | Cause::LinkFlexibility => &["stiffness_nm_per_rad"],
            Cause::DriveInertia => &["reflected_inertia_kgm2"],
            Cause::LoadDependentStiffness => &["change_per_nm"],
            Cause::AmplitudeDependence => &["change_per_nm", "factor"],
            Cause::TemperatureDrift => &["change_per_k", "factor"],
            Cause::GravityStiffness => &[],
            Cause::AliasedMode => &["sample_rate_hz"],
            Cause::MissedMode => &["share"],
        }
    }

    /// Puts the correction into a description.
    fn apply(&self, description: &mut Description) -> Result<(), String> {
        let at = self.at.as_deref().unwrap_or("");
        let value = |name: &str| self.value(name);
        let needed =
            |name: &str| value(name).ok_or_else(|| format!("parameter '{name}' is missing"));
        match self.cause {
            Cause::JointStiffness => {
                let stiffness = value("stiffness_nm_per_rad").or(value("stiffness_n_per_m"));
                let stiffness = stiffness.ok_or("parameter 'stiffness_nm_per_rad' is missing")?;
                spring(description, at)?.stiffness = stiffness;
            }
            Cause::LinkInertia => {
                let body = body(description, at)?;
                let mass_factor = value("mass_factor").unwrap_or(1.0);
                body.mass_kg *= mass_factor;
                body.inertia_kgm2 *= value("inertia_factor").unwrap_or(1.0) * mass_factor;
            }
            Cause::ComOffset => {
                let offset = vector(["dx_m", "dy_m", "dz_m"].map(value));
                body(description, at)?.com_m += offset;
            }
            Cause::JointZeroOffset => {
                let offset = value("offset_rad").or(value("offset_m"));
                let offset = offset.ok_or("parameter 'offset_rad' is missing")?;
                let joint = joint(description, at)?;
                joint.origin *= moved(joint, offset);
            }
            Cause::Payload => {
                let carried = Inertial {
                    mass_kg: needed("mass_kg")?,
                    com_m: vector(["com_x_m", "com_y_m", "com_z_m"].map(value)),
                    inertia_kgm2: Matrix3::zeros(),
                };
                let link = link(description, at)?;
                link.inertial = Some(link.inertial.map_or(carried, |own| own.combined(&carried)));
            }
            Cause::BaseCompliance | Cause::TransverseCompliance | Cause::LinkFlexibility => {
                let stiffness = value("stiffness_nm_per_rad").or(value("stiffness_n_per_m"));
                let stiffness = stiffness.ok_or("parameter 'stiffness_nm_per_rad' is missing")?;
                self.give(description, at, stiffness)?;
            }
            Cause::DriveInertia => {
                joint(description, at)?;
                let reflected_inertia_kgm2 = needed("reflected_inertia_kgm2")?;
                match description.drives.iter_mut().find(|drive| drive.joint == at) {
                    Some(drive) => drive.reflected_inertia_kgm2 = reflected_inertia_kgm2,
                    None => description
                        .drives
                        .push(Drive { joint: at.to_owned(), reflected_inertia_kgm2 }),
                }
            }
            Cause::LoadDependentStiffness
            | Cause::AmplitudeDependence
            | Cause::TemperatureDrift => {
                spring(description, at)?;
            }
            Cause::GravityStiffness => description.gravity_stiffness = true,
            Cause::AliasedMode | Cause::MissedMode => {}
        }
        Ok(())
    }

    /// The law that the correction makes of a spring, with the spring's joint.
    pub(super) fn law(&self) -> Option<(&str, StiffnessLaw)> {
        let at = self.at.as_deref()?;
        let factor = self.value("factor").unwrap_or(1.0);
        let law = match self.cause {
            Cause::LoadDependentStiffness => {
                StiffnessLaw::Load { change_per_nm: self.value("change_per_nm")? }
            }
            Cause::AmplitudeDependence => {
                StiffnessLaw::Amplitude { factor, change_per_nm: self.value("change_per_nm")? }
            }
            Cause::TemperatureDrift => {
                StiffnessLaw::Temperature { factor, change_per_k: self.value("change_per_k")? }
            }
            _ => return None,
        };
        Some((at, law))
    }

    /// Adds the elastic coordinates of a hinge.
    fn give(&self, description: &mut Description, at: &str, stiffness: f64) -> Result<(), String> {
        let hinge = self.hinge.as_ref().ok_or("axis is missing")?;
        let mut moved = match self.cause {
            Cause::TransverseCompliance => joint(description, at)?.child.clone(),
            _ => link(description, at)?.name.clone(),
        };
        let name = format!("{} at {at}", self.cause);
        if hinge.beyond {
            let rest = format!("{at}, beyond its hinge");
            for joint in description.joints.iter_mut().filter(|joint| joint.parent == at) {
                joint.parent.clone_from(&rest);
            }
            description.links.push(Link {
                name: rest.clone(),
                inertial: None,
                has_geometry: false,
            });
            description.joints.push(Joint {
                name: format!("{at}, its hinge"),
                kind: JointKind::Fixed,
                parent: moved,
                child: rest.clone(),
                origin: Isometry3::identity(),
                axis: Vector3::x(),
                position_limit: None,
                velocity_limit: None,
                mimics: None,
            });
            moved = rest;
        }
        for (i, axis) in hinge.axes.iter().enumerate() {
            description.extra.push(ExtraCoordinate {
                name: if i == 0 { name.clone() } else { format!("{name}, {}", i + 1) },
                link: moved.clone(),
                kind: hinge.kind,
                axis: *axis,
                origin_m: hinge.origin_m,
                stiffness,
                damping: None,
            });
        }
        Ok(())
    }
}

impl Description {
    /// With its corrections put in, each in turn; the laws of springs stay in the list.
    ///
    /// # Errors
    /// A correction whose place does not exist or whose parameters are missing.
    pub fn corrected(&self) -> Result<Self, Vec<ModelFault>> {
        let mut corrected = self.clone();
        let mut faults = Vec::new();
        for (index, correction) in self.corrections.iter().enumerate() {
            if let Err(what) = correction.apply(&mut corrected) {
                faults.push(ModelFault::new(Place::Correction(index), "", what));
            }
        }
        if faults.is_empty() { Ok(corrected) } else { Err(faults) }
    }
}

fn vector(parts: [Option<f64>; 3]) -> Vector3<f64> {
    parts.map(|part| part.unwrap_or(0.0)).into()
}

/// The motion of a joint's child when the joint moves by `by`, rad or m.
fn moved(joint: &Joint, by: f64) -> Isometry3<f64> {
    let axis = Unit::new_normalize(joint.axis);
    match joint.kind {
        JointKind::Prismatic => Isometry3::from_parts(
            Translation3::from(axis.into_inner() * by),
            UnitQuaternion::identity(),
        ),
        _ => Isometry3::from_parts(
            Translation3::identity(),
            UnitQuaternion::from_axis_angle(&axis, by),
        ),
    }
}

fn link<'d>(description: &'d mut Description, name: &str) -> Result<&'d mut Link, String> {
    let found = description.links.iter_mut().find(|link| link.name == name);
    found.ok_or_else(|| format!("at is '{name}', must be a link of the URDF"))
}

fn body<'d>(description: &'d mut Description, name: &str) -> Result<&'d mut Inertial, String> {
    let inertial = link(description, name)?.inertial.as_mut();
    inertial.ok_or_else(|| format!("at is '{name}', a link without mass"))
}

fn joint<'d>(description: &'d mut Description, name: &str) -> Result<&'d mut Joint, String> {
    let mut joints = description.joints.iter_mut();
    let found = joints.find(|joint| joint.name == name && joint.kind.moves());
    found.ok_or_else(|| format!("at is '{name}', must be a moving joint of the URDF"))
}

fn spring<'d>(
    description: &'d mut Description,
    name: &str,
) -> Result<&'d mut super::description::ElasticJoint, String> {
    let found = description.elastic_joints.iter_mut().find(|spring| spring.joint == name);
    found.ok_or_else(|| format!("at is '{name}', must be an elastic joint"))
}
