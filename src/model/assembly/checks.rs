//! Checks of a description that need no tree: mass properties, axes, springs, drives.

use std::collections::BTreeSet;

use nalgebra::{Matrix3, Vector3};

use super::{Builder, listed};
use crate::model::description::{Damping, Inertial, JointKind};
use crate::notes::{Code, Part};
use crate::units::percent_from_ratio;
use crate::wording::hint;

/// Slack in the triangle inequality of principal moments, as a share of the largest: CAD exports
/// and data sheets print three digits.
const TRIANGLE_SLACK: f64 = 1e-3;

/// Slack of the smallest principal moment below zero, as a share of the largest: rounding only.
const POSITIVITY_SLACK: f64 = 1e-9;

/// Beyond these no body belongs to a robot, and sums over bodies would overflow.
const MAX_MASS_KG: f64 = 1e7;
const MAX_DISTANCE_M: f64 = 1e5;
const MAX_INERTIA_KGM2: f64 = 1e12;

/// A joint slower than this (rad/s or m/s) takes months for a turn: no limit of a real drive.
const MIN_VELOCITY_LIMIT: f64 = 1e-6;

/// An axis shorter than this has no direction.
const MIN_AXIS: f64 = 1e-9;

impl<'d> Builder<'d> {
    pub(super) fn check_inertias(&mut self) {
        for link in &self.description.links {
            if let Some(inertial) = &link.inertial {
                for (key, what) in inertial_faults(inertial) {
                    self.error(Code::Inertia, Part::Link(link.name.clone()), key, what);
                }
            }
            self.check_std(link.std, || Part::Link(link.name.clone()));
        }
        if let Some(payload) = &self.description.payload {
            for (key, what) in inertial_faults(&payload.inertial) {
                self.error(Code::Inertia, Part::Payload, key, what);
            }
        }
    }

    pub(super) fn check_axes(&mut self) {
        for joint in &self.description.joints {
            let part = || Part::Joint(joint.name.clone());
            if joint.kind.moves() && !has_direction(&joint.axis) {
                let axis = triple(&joint.axis);
                self.error(
                    Code::Value,
                    part(),
                    "axis",
                    format!("axis is {axis}, must have a direction"),
                );
            }
            let origin = joint.origin.translation.vector;
            let rotation = joint.origin.rotation;
            if !is_finite(&origin) || !rotation.coords.iter().all(|c| c.is_finite()) {
                self.error(Code::Value, part(), "origin", "origin must be finite");
            }
            if let Some([lower, upper]) = joint.position_limit
                && !(lower.is_finite() && upper.is_finite() && lower <= upper)
            {
                let what = format!("limits are {lower}..{upper}, must be finite and ascending");
                self.error(Code::Value, part(), "limit", what);
            }
            if let Some(speed) = joint.velocity_limit
                && !(speed.is_finite() && speed >= MIN_VELOCITY_LIMIT)
            {
                let what = format!(
                    "velocity limit is {speed}, must be finite and at least {MIN_VELOCITY_LIMIT}"
                );
                self.error(Code::Value, part(), "limit", what);
            }
        }
    }

    pub(super) fn check_springs(&mut self) {
        let default = self.description.default_damping_ratio;
        if let Some(what) = damping_fault(Some(Damping::Ratio(default))) {
            self.error(Code::Value, Part::Damping, "damping_ratio", what);
        }
        self.check_elastic_joints();
        self.check_extra_coordinates();
        self.check_names();
        self.check_drives();
        let gravity = self.description.gravity_m_per_s2;
        if !is_finite(&gravity) {
            let what = format!("gravity_m_per_s2 is {}, must be finite", triple(&gravity));
            self.error(Code::Value, Part::Gravity, "gravity_m_per_s2", what);
        }
    }

    /// Names of the joints that move.
    fn moving(&self) -> Vec<&'d str> {
        let moving = self.description.joints.iter().filter(|joint| joint.kind.moves());
        moving.map(|joint| joint.name.as_str()).collect()
    }

    fn check_elastic_joints(&mut self) {
        let description = self.description;
        let kind_of = |name: &str| {
            let found = description.joints.iter().find(|joint| joint.name == name);
            found.map(|joint| joint.kind)
        };
        for spring in &description.elastic_joints {
            let part = || Part::ElasticJoint(spring.joint.clone());
            match kind_of(&spring.joint) {
                None => {
                    let moving = self.moving();
                    let hint = hint(&spring.joint, moving.iter().copied());
                    let moving = listed(&moving);
                    let what = format!("the URDF has no such joint; it has {moving}{hint}");
                    self.error(Code::Reference, part(), "", what);
                }
                Some(kind) if !kind.moves() => {
                    let what = "the joint does not move in the URDF; give the compliance as an \
                                extra coordinate";
                    self.error(Code::Reference, part(), "", what);
                }
                Some(kind) => {
                    let slides = kind == JointKind::Prismatic;
                    if slides != spring.is_linear {
                        let (has, needs) = if slides {
                            ("stiffness_nm_per_rad", "stiffness_n_per_m, as the joint is prismatic")
                        } else {
                            ("stiffness_n_per_m", "stiffness_nm_per_rad, as the joint turns")
                        };
                        self.error(
                            Code::Value,
                            part(),
                            has,
                            format!("{has} given, must be {needs}"),
                        );
                    }
                }
            }
            let key = if spring.is_linear { "stiffness_n_per_m" } else { "stiffness_nm_per_rad" };
            if let Some(what) = stiffness_fault(key, spring.stiffness) {
                self.error(Code::Value, part(), key, what);
            }
            if let Some(what) = damping_fault(spring.damping) {
                self.error(Code::Value, part(), "damping_ratio", what);
            }
            self.check_std(spring.std, part);
        }
    }

    fn check_extra_coordinates(&mut self) {
        for (index, extra) in self.description.extra.iter().enumerate() {
            let part = || Part::Extra(index);
            if !has_direction(&extra.axis) {
                let what = format!("axis is {}, must have a direction", triple(&extra.axis));
                self.error(Code::Value, part(), "axis", what);
            }
            if !is_finite(&extra.origin_m) {
                let what = format!("origin_m is {}, must be finite", triple(&extra.origin_m));
                self.error(Code::Value, part(), "origin_m", what);
            }
            if let Some(what) = stiffness_fault("stiffness", extra.stiffness) {
                self.error(Code::Value, part(), "stiffness", what);
            }
            if let Some(what) = damping_fault(extra.damping) {
                self.error(Code::Value, part(), "damping_ratio", what);
            }
            self.check_std(extra.std, part);
        }
    }

    /// A standard deviation of a logarithm beyond 1 says that nothing is known.
    fn check_std(&mut self, std: Option<f64>, part: impl FnOnce() -> Part) {
        if let Some(std) = std.filter(|std| !(0.0..=1.0).contains(std)) {
            let percent = percent_from_ratio(std);
            let what = format!("std_percent is {percent}, must lie between 0 (exact) and 100");
            self.error(Code::Value, part(), "std_percent", what);
        }
    }

    /// Elastic coordinates have names of their own.
    fn check_names(&mut self) {
        let description = self.description;
        let springs = description.elastic_joints.iter().map(|spring| &spring.joint);
        let names: Vec<&String> =
            springs.chain(description.extra.iter().map(|extra| &extra.name)).collect();
        // There are no more than a hundred.
        for (i, name) in names.iter().enumerate().filter(|(i, name)| names[..*i].contains(name)) {
            let part = match i.checked_sub(description.elastic_joints.len()) {
                None => Part::ElasticJoint((*name).clone()),
                Some(extra) => Part::Extra(extra),
            };
            let what = format!("name '{name}' is taken by another elastic coordinate");
            self.error(Code::Conflict, part, "name", what);
        }
    }

    fn check_drives(&mut self) {
        let description = self.description;
        let mut driven = BTreeSet::new();
        for drive in &description.drives {
            let part = || Part::Drive(drive.joint.clone());
            let mut moving = description.joints.iter().filter(|joint| joint.kind.moves());
            if !moving.any(|joint| joint.name == drive.joint) {
                let moving = listed(&self.moving());
                let what = format!("the URDF has no such moving joint; it has {moving}");
                self.error(Code::Reference, part(), "", what);
            }
            if !driven.insert(&drive.joint) {
                self.error(Code::Conflict, part(), "", "given twice");
            }
            let inertia = drive.reflected_inertia_kgm2;
            if !(inertia.is_finite() && inertia >= 0.0) {
                let what = format!(
                    "reflected_inertia_kgm2 is {inertia}, must not be negative and must be finite"
                );
                self.error(Code::Value, part(), "reflected_inertia_kgm2", what);
            } else if inertia > 0.0
                && !description.elastic_joints.iter().any(|s| s.joint == drive.joint)
            {
                let what = "has no effect, as the joint is rigid";
                self.warning(Code::Unused, part(), "reflected_inertia_kgm2", what);
            }
            self.check_std(drive.std, part);
        }
    }
}

pub(super) fn has_direction(axis: &Vector3<f64>) -> bool {
    is_finite(axis) && axis.norm() > MIN_AXIS
}

fn is_finite(v: &Vector3<f64>) -> bool {
    v.iter().all(|x| x.is_finite())
}

fn triple(v: &Vector3<f64>) -> String {
    format!("[{}, {}, {}]", v.x, v.y, v.z)
}

fn stiffness_fault(key: &str, stiffness: f64) -> Option<String> {
    (!(stiffness.is_finite() && stiffness > 0.0))
        .then(|| format!("{key} is {stiffness}, must be positive and finite"))
}

fn damping_fault(damping: Option<Damping>) -> Option<String> {
    match damping? {
        Damping::Ratio(zeta) if !(zeta.is_finite() && zeta > 0.0 && zeta < 1.0) => {
            Some(format!("damping_ratio is {zeta}, must lie between 0 and 1"))
        }
        Damping::Viscous(c) if !(c.is_finite() && c > 0.0) => {
            Some(format!("damping is {c}, must be positive and finite"))
        }
        Damping::Ratio(_) | Damping::Viscous(_) => None,
    }
}

/// What makes mass properties impossible: (key, fragment).
fn inertial_faults(inertial: &Inertial) -> Vec<(&'static str, String)> {
    let mut faults = Vec::new();
    let m = inertial.mass_kg;
    let com = inertial.com_m;
    let inertia = inertial.inertia_kgm2;
    if !m.is_finite() || m < 0.0 {
        faults.push(("mass", format!("mass is {m} kg, must not be negative and must be finite")));
    }
    if m.is_finite() && m > MAX_MASS_KG {
        faults.push(("mass", format!("mass is {m} kg, must be at most {MAX_MASS_KG} kg")));
    }
    if !is_finite(&com) {
        let what = format!("centre of mass is {}, must be finite", triple(&com));
        faults.push(("com", what));
    } else if com.amax() > MAX_DISTANCE_M {
        let what =
            format!("centre of mass is {}, must lie within {MAX_DISTANCE_M} m", triple(&com));
        faults.push(("com", what));
    }
    if !inertia.iter().all(|x| x.is_finite()) {
        faults.push(("inertia", "inertia must be finite".to_owned()));
        return faults;
    }
    if inertia.amax() > MAX_INERTIA_KGM2 {
        let what = format!("inertia is above {MAX_INERTIA_KGM2} kg·m²; check its units");
        faults.push(("inertia", what));
        return faults;
    }
    if m > 0.0 && is_of_a_body(&inertia) {
        return faults;
    }
    let mut moments: [f64; 3] = inertia.symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    let [smallest, middle, largest] = moments;
    if m == 0.0 && largest.abs().max(smallest.abs()) > 0.0 {
        faults.push(("mass", "mass is 0 but the inertia is not".to_owned()));
    }
    if smallest < -POSITIVITY_SLACK * largest.abs() {
        let what = format!(
            "inertia is not positive: principal moments {smallest:.4e}, {middle:.4e}, \
             {largest:.4e} kg·m²"
        );
        faults.push(("inertia", what));
    } else if smallest + middle < largest * (1.0 - TRIANGLE_SLACK) {
        let (ixx, iyy, izz) = (inertia[(0, 0)], inertia[(1, 1)], inertia[(2, 2)]);
        let diagonal = inertia == Matrix3::from_diagonal(&inertia.diagonal());
        let sum = if diagonal {
            triangle_by_axis([ixx, iyy, izz])
        } else {
            format!("principal moments {smallest:.4} + {middle:.4} < {largest:.4} kg·m²")
        };
        let what = format!(
            "inertia fails the triangle inequality ({sum}); check the units of the CAD export"
        );
        faults.push(("inertia", what));
    }
    faults
}

/// Whether principal moments are surely positive and fulfil the triangle inequality: the second
/// moments of the mass, ½ tr(I)·1 − I, are positive definite (Traversaro et al., IROS 2016, eq.
/// 11).
fn is_of_a_body(inertia: &Matrix3<f64>) -> bool {
    let moments = Matrix3::from_diagonal_element(0.5 * inertia.trace()) - inertia;
    moments.cholesky().is_some()
}

fn triangle_by_axis(diagonal: [f64; 3]) -> String {
    let names = ["ixx", "iyy", "izz"];
    let largest = if diagonal[0] > diagonal[1].max(diagonal[2]) {
        0
    } else if diagonal[1] > diagonal[2] {
        1
    } else {
        2
    };
    let (a, b) = ((largest + 1) % 3, (largest + 2) % 3);
    let (a, b) = (a.min(b), a.max(b));
    format!(
        "{} {} + {} {} < {} {} kg·m²",
        names[a], diagonal[a], names[b], diagonal[b], names[largest], diagonal[largest]
    )
}
