//! Corrections of a robot's description: each names its cause, its place and its parameters, and is
//! applied before the model is built. What depends on the pose or on the conditions of a
//! measurement becomes a law of the spring.

mod hinge;
mod law;
mod learned;

use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};

pub use self::law::{Conditions, REFERENCE_TEMPERATURE_C, StiffnessLaw};
use super::cause::Cause;
use super::description::{
    Correction, Description, Drive, ElasticJoint, Inertial, Joint, JointKind, Link,
};
use crate::notes::{Code, Note, Part, Place};

impl Correction {
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
                let mass_kg = needed("mass_kg")?;
                let gyration_m = value("gyration_m").unwrap_or(0.0);
                let carried = Inertial {
                    mass_kg,
                    com_m: vector(["com_x_m", "com_y_m", "com_z_m"].map(value)),
                    inertia_kgm2: Matrix3::identity() * (mass_kg * gyration_m * gyration_m),
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
                    None => description.drives.push(Drive {
                        joint: at.to_owned(),
                        reflected_inertia_kgm2,
                        std: None,
                    }),
                }
            }
            Cause::LoadDependentStiffness
            | Cause::AmplitudeDependence
            | Cause::TemperatureDrift => {
                spring(description, at)?;
                match self.cause {
                    Cause::TemperatureDrift => needed("change_per_k")?,
                    Cause::AmplitudeDependence if value("exponent").is_some() => 0.0,
                    _ => needed("change_per_nm")?,
                };
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
                let saturation_nm = self.value("saturation_nm").unwrap_or(f64::INFINITY);
                StiffnessLaw::Load { change_per_nm: self.value("change_per_nm")?, saturation_nm }
            }
            Cause::AmplitudeDependence => match self.value("exponent") {
                Some(exponent) => StiffnessLaw::AmplitudePower { factor, exponent },
                None => {
                    StiffnessLaw::Amplitude { factor, change_per_nm: self.value("change_per_nm")? }
                }
            },
            Cause::TemperatureDrift => {
                StiffnessLaw::Temperature { factor, change_per_k: self.value("change_per_k")? }
            }
            _ => return None,
        };
        Some((at, law))
    }

    /// Adds the elastic coordinates of a hinge, where the parameters say that it is.
    fn give(&self, description: &mut Description, at: &str, stiffness: f64) -> Result<(), String> {
        let mut hinge = self.hinge.clone().ok_or("axes are missing")?;
        hinge.origin_m.z -= self.value("depth_m").unwrap_or(0.0);
        let link = match self.cause {
            Cause::TransverseCompliance => joint(description, at)?.child.clone(),
            _ => link(description, at)?.name.clone(),
        };
        if let Some(position) = self.value("position") {
            hinge.moved_along(description, &link, position);
        }
        hinge.add(description, &link, &format!("{} at {at}", self.cause), stiffness);
        Ok(())
    }
}

impl Description {
    /// With its corrections put in, each in turn, and the means that a calibration learned; the
    /// laws of springs stay in the list.
    ///
    /// # Errors
    /// A correction or a learned parameter whose place does not exist, or parameters that are
    /// missing.
    pub fn corrected(&self) -> Result<Self, Vec<Note>> {
        let mut corrected = self.clone();
        let mut errors = Vec::new();
        for (index, correction) in self.corrections.iter().enumerate() {
            if let Err(what) = correction.apply(&mut corrected) {
                let place = Place::part(Part::Correction(index));
                errors.push(Note::error(Code::Value, place, what));
            }
        }
        let posterior = self.calibration.as_ref().and_then(|own| own.posterior.as_ref());
        errors.extend(posterior.and_then(|posterior| posterior.apply(&mut corrected).err()));
        if errors.is_empty() { Ok(corrected) } else { Err(errors) }
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
) -> Result<&'d mut ElasticJoint, String> {
    let found = description.elastic_joints.iter_mut().find(|spring| spring.joint == name);
    found.ok_or_else(|| format!("at is '{name}', must be an elastic joint"))
}
