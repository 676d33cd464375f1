//! Corrections of a robot's description: each names its cause, its place and its parameters, and is
//! applied before the model is built. What depends on the pose or on the conditions of a
//! measurement becomes a law of the spring.

mod checks;
mod hinge;
mod law;
mod learned;

use nalgebra::{Isometry3, Matrix3, Translation3, Unit, UnitQuaternion, Vector3};

pub(super) use self::law::SpringState;
pub use self::law::{Conditions, REFERENCE_TEMPERATURE_C, StiffnessLaw};
use super::cause::Cause;
use super::description::{
    Carries, CoordinateKind, Correction, Description, Drive, ElasticJoint, Hinge, Inertial, Joint,
    JointKind, Link,
};
use crate::notes::{Code, Note, Part, Place};
use crate::units::rad_per_s_from_hz;

/// The place of a cause that all elastic joints have in common.
pub const ALL_JOINTS: &str = "all";

/// How much more than by the factor of all springs each changes, in the order of the file.
pub const SPRING_RATIOS: [&str; 9] = [
    "ratio_1", "ratio_2", "ratio_3", "ratio_4", "ratio_5", "ratio_6", "ratio_7", "ratio_8",
    "ratio_9",
];

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
                match (stiffness, value("factor")) {
                    (Some(stiffness), _) => stiffen(description, at, stiffness)?,
                    (None, Some(factor)) => {
                        springs(description, at)?.for_each(|spring| spring.stiffness *= factor);
                        for (spring, name) in
                            description.elastic_joints.iter_mut().zip(SPRING_RATIOS)
                        {
                            spring.stiffness *= value(name).unwrap_or(1.0);
                        }
                    }
                    (None, None) => {
                        let own = match joint(description, at).map(|joint| joint.kind) {
                            Ok(JointKind::Prismatic) => "'stiffness_n_per_m' or 'factor'",
                            Ok(_) => "'stiffness_nm_per_rad' or 'factor'",
                            Err(_) if at == ALL_JOINTS => "'factor'",
                            Err(what) => return Err(what),
                        };
                        return Err(format!("parameter {own} is missing"));
                    }
                }
            }
            Cause::LinkInertia => {
                let body = body(description, at)?;
                let mass_factor = value("mass_factor").unwrap_or(1.0);
                body.mass_kg *= mass_factor;
                body.inertia_kgm2 *= value("inertia_factor").unwrap_or(1.0) * mass_factor;
                let factors = ["x_factor", "y_factor", "z_factor"].map(value);
                if factors.iter().any(Option::is_some) {
                    // ∫ r rᵀ dm about the centre of mass stays positive, whatever the factors.
                    let roots = factors.map(|factor| factor.unwrap_or(1.0).max(0.0).sqrt());
                    let roots = Matrix3::from_diagonal(&roots.into());
                    let second =
                        Matrix3::identity() * (0.5 * body.inertia_kgm2.trace()) - body.inertia_kgm2;
                    let second = roots * second * roots;
                    body.inertia_kgm2 = Matrix3::identity() * second.trace() - second;
                }
            }
            Cause::ComOffset => {
                let offset = vector(["dx_m", "dy_m", "dz_m"].map(value));
                body(description, at)?.com_m += offset;
            }
            Cause::JointZeroOffset => {
                let offset = value("offset_rad").or(value("offset_m"));
                let joint = joint(description, at)?;
                let own =
                    if joint.kind == JointKind::Prismatic { "offset_m" } else { "offset_rad" };
                let offset = offset.ok_or_else(|| format!("parameter '{own}' is missing"))?;
                joint.origin *= moved(joint, offset);
            }
            Cause::Payload => {
                let mass_kg = needed("mass_kg")?;
                if mass_kg < 0.0 {
                    return take_off(description, at, -mass_kg);
                }
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
                self.give(description, at)?;
            }
            Cause::LocalMode => self.hang(description)?,
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
            Cause::LoadDependentStiffness => {
                let _ = springs(description, at)?;
                let has_steps = value("torque_1_nm").is_some();
                needed(if has_steps { "torque_2_nm" } else { "change_per_nm" })?;
            }
            Cause::AmplitudeDependence => {
                let _ = springs(description, at)?;
                if value("exponent").is_none() {
                    needed("change_per_nm")?;
                }
            }
            Cause::TemperatureDrift => {
                let _ = springs(description, at)?;
                needed("change_per_k")?;
            }
            Cause::PositionDependentStiffness => {
                let _ = springs(description, at)?;
            }
            Cause::JointCoupling => {
                let _ = springs(description, at)?;
                needed("ratio")?;
            }
            Cause::GravityStiffness => description.gravity_stiffness = true,
            Cause::AliasedMode | Cause::MissedMode => {}
        }
        Ok(())
    }

    /// Whether it is about the spring of `joint`.
    pub(super) fn is_about(&self, joint: &str) -> bool {
        self.at.as_deref().is_some_and(|at| at == joint || at == ALL_JOINTS)
    }

    /// The law that the correction makes of a spring.
    pub(super) fn law(&self) -> Option<StiffnessLaw> {
        let factor = self.value("factor").unwrap_or(1.0);
        let law = match self.cause {
            Cause::LoadDependentStiffness => {
                let saturation_nm = self.value("saturation_nm").unwrap_or(f64::INFINITY);
                let ratio = |name: &str| self.value(name).unwrap_or(1.0);
                match self.value("torque_1_nm").zip(self.value("torque_2_nm")) {
                    Some((first, second)) => StiffnessLaw::LoadSteps {
                        factor,
                        ratios: [ratio("ratio_1"), ratio("ratio_3")],
                        torques_nm: [first, second],
                    },
                    None => StiffnessLaw::Load {
                        factor,
                        change_per_nm: self.value("change_per_nm")?,
                        saturation_nm,
                        reference_nm: self.value("reference_nm").unwrap_or(0.0),
                    },
                }
            }
            Cause::AmplitudeDependence => match self.value("exponent") {
                Some(exponent) => StiffnessLaw::AmplitudePower {
                    factor,
                    exponent,
                    reference_nm: self.value("reference_nm").unwrap_or(1.0),
                },
                None => StiffnessLaw::Amplitude {
                    factor,
                    change_per_nm: self.value("change_per_nm")?,
                    reference_nm: self.value("reference_nm").unwrap_or(0.0),
                },
            },
            Cause::TemperatureDrift => StiffnessLaw::Temperature {
                factor,
                change_per_k: self.value("change_per_k")?,
                reference_c: self.value("reference_c").unwrap_or(REFERENCE_TEMPERATURE_C),
            },
            Cause::PositionDependentStiffness => {
                let of = |name: &str| self.value(name).unwrap_or(0.0);
                StiffnessLaw::Position {
                    factor,
                    harmonics: [
                        [of("cos_1"), of("sin_1")],
                        [of("cos_2"), of("sin_2")],
                        [of("cos_3"), of("sin_3")],
                    ],
                }
            }
            Cause::JointStiffness
            | Cause::LinkInertia
            | Cause::ComOffset
            | Cause::JointZeroOffset
            | Cause::Payload
            | Cause::BaseCompliance
            | Cause::TransverseCompliance
            | Cause::LinkFlexibility
            | Cause::LocalMode
            | Cause::DriveInertia
            | Cause::GravityStiffness
            | Cause::AliasedMode
            | Cause::MissedMode
            | Cause::JointCoupling => return None,
        };
        Some(law)
    }

    /// Adds the elastic coordinates of a hinge, where the parameters say that it is.
    fn give(&self, description: &mut Description, at: &str) -> Result<(), String> {
        let [turning, shifting] =
            ["stiffness_nm_per_rad", "stiffness_n_per_m"].map(|name| self.value(name));
        let stiffness = turning.or(shifting);
        let stiffness = stiffness.ok_or("parameter 'stiffness_nm_per_rad' is missing")?;
        let ratio = |name: &str| self.value(name).unwrap_or(1.0);
        let stiffnesses = [1.0, ratio("ratio_2"), ratio("ratio_3")].map(|ratio| ratio * stiffness);
        let mut hinge = self.hinge.clone().ok_or("axes are missing")?;
        hinge.origin_m.z -= self.value("depth_m").unwrap_or(0.0);
        if let Some(angle) = self.value("turn_rad") {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
            hinge.axes.iter_mut().for_each(|axis| *axis = turn * *axis);
        }
        let link = match self.cause {
            Cause::TransverseCompliance => joint(description, at)?.child.clone(),
            _ => link(description, at)?.name.clone(),
        };
        let name = format!("{} at {at}", self.cause);
        let positions = self.positions();
        hinge.add(description, &link, &name, &stiffnesses, &positions);
        // What turns may also shift.
        if let (Some(_), Some(shifting)) = (turning, shifting) {
            let unlike = [1.0, ratio("shift_ratio_2"), ratio("shift_ratio_3")];
            let axes = vec![Vector3::x(), Vector3::y(), Vector3::z()];
            let shift = Hinge { kind: CoordinateKind::Translation, axes, ..hinge };
            let name = format!("{name}, shift");
            shift.add(description, &link, &name, &unlike.map(|of| of * shifting), &positions);
        }
        Ok(())
    }

    /// Where along the link hinges are, as shares of its reach, ascending: one at `position`, or
    /// two where the link bends over a `length` about its middle. The compliance then changes
    /// linearly over that length so that its centre is `position`; two hinges with its mean and
    /// variance are as soft under any force and moment on the link's end, as the bending moment is
    /// linear between (Gauss's rule is exact for what is quadratic).
    fn positions(&self) -> Vec<f64> {
        let Some(length) = self.value("length") else {
            return vec![self.value("position").unwrap_or(0.0)];
        };
        let position = self.value("position").unwrap_or(0.5);
        let variance = length * length / 12.0 - (position - 0.5).powi(2);
        let apart = variance.max(0.0).sqrt();
        vec![position - apart, position + apart]
    }

    /// Hangs a part on a link, on a spring of its own: on a rigid link it has the frequency given.
    /// Without a place it is too light for the arm to feel it.
    fn hang(&self, description: &mut Description) -> Result<(), String> {
        /// What no arm feels, as a share of the mass of its links.
        const LIGHT: f64 = 1e-8;
        let frequency_hz =
            self.value("frequency_hz").ok_or("parameter 'frequency_hz' is missing")?;
        let (at, mass_kg, mut hinge) = match &self.at {
            Some(at) => (
                link(description, at)?.name.clone(),
                self.value("mass_kg").ok_or("parameter 'mass_kg' is missing")?,
                self.hinge.clone().ok_or("axes are missing")?,
            ),
            None => {
                let last = description.joints.iter().rfind(|joint| joint.kind.moves());
                let links = description.links.iter().filter_map(|link| link.inertial);
                let total_kg: f64 = links.map(|body| body.mass_kg).sum();
                let at = last.ok_or("the arm has no joint that moves")?.child.clone();
                (at, LIGHT * total_kg, Hinge::shift(Vector3::z()))
            }
        };
        hinge.origin_m += vector(["com_x_m", "com_y_m", "com_z_m"].map(|name| self.value(name)));
        let stiffness = mass_kg * rad_per_s_from_hz(frequency_hz).powi(2);
        let name = match &self.at {
            Some(at) => format!("{} at {at}", self.cause),
            None => self.cause.to_string(),
        };
        let is_taken = |name: &str| description.links.iter().any(|link| link.name == name);
        let more = (2..).map(|n| format!("{name}, part {n}"));
        let mut names = std::iter::once(name.clone()).chain(more);
        let name = names.find(|name| !is_taken(name)).unwrap_or_default();
        if hinge.carries == Carries::Part {
            hinge.take(description, &at, mass_kg)?;
        }
        hinge.hang(description, &at, &name, mass_kg, stiffness);
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
        self.clone().into_corrected()
    }

    /// The same of one that nobody needs any more.
    pub(super) fn into_corrected(mut self) -> Result<Self, Vec<Note>> {
        let mut errors = Vec::new();
        let corrections = std::mem::take(&mut self.corrections);
        for (index, correction) in corrections.iter().enumerate() {
            if let Err(what) = correction.apply(&mut self) {
                let place = Place::part(Part::Correction(index));
                errors.push(Note::error(Code::Value, place, what));
            }
        }
        self.corrections = corrections;
        let calibration = self.calibration.take();
        let posterior = calibration.as_ref().and_then(|own| own.posterior.as_ref());
        errors.extend(posterior.and_then(|posterior| posterior.apply(&mut self).err()));
        self.calibration = calibration;
        if errors.is_empty() { Ok(self) } else { Err(errors) }
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

/// Gives a joint's spring this constant; a rigid joint gets a spring.
fn stiffen(description: &mut Description, name: &str, stiffness: f64) -> Result<(), String> {
    if let Some(known) = description.elastic_joints.iter_mut().find(|spring| spring.joint == name) {
        known.stiffness = stiffness;
        return Ok(());
    }
    let is_linear = joint(description, name)?.kind == JointKind::Prismatic;
    let joint = name.to_owned();
    let damping = None;
    description.elastic_joints.push(ElasticJoint {
        joint,
        stiffness,
        is_linear,
        std: None,
        damping,
    });
    Ok(())
}

/// Takes mass off the payload, down to none.
fn take_off(description: &mut Description, at: &str, mass_kg: f64) -> Result<(), String> {
    link(description, at)?;
    // A row that was measured without the payload has nothing to take off.
    let Some(payload) = &mut description.payload else { return Ok(()) };
    let own_kg = payload.inertial.mass_kg;
    let left = if own_kg > 0.0 { (1.0 - mass_kg / own_kg).max(0.0) } else { 1.0 };
    payload.inertial.mass_kg *= left;
    payload.inertial.inertia_kgm2 *= left;
    Ok(())
}

/// The springs of a joint, or of all.
fn springs<'d>(
    description: &'d mut Description,
    name: &str,
) -> Result<impl Iterator<Item = &'d mut ElasticJoint>, String> {
    let is_one = move |spring: &ElasticJoint| name == ALL_JOINTS || spring.joint == name;
    if !description.elastic_joints.iter().any(is_one) {
        return Err(format!("at is '{name}', must be an elastic joint"));
    }
    let name = name.to_owned();
    let is_one = move |spring: &&mut ElasticJoint| name == ALL_JOINTS || spring.joint == name;
    Ok(description.elastic_joints.iter_mut().filter(is_one))
}
