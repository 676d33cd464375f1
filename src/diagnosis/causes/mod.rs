//! The vocabulary: one cause a file. Each says where it can sit, which parameters with which
//! physical bounds it has, how it enters the model, and what it may be mistaken for.

mod aliased_mode;
mod amplitude_dependence;
mod base_compliance;
mod com_offset;
mod drive_inertia;
mod gravity_stiffness;
mod joint_coupling;
mod joint_stiffness;
mod joint_zero_offset;
mod link_flexibility;
mod link_inertia;
mod load_dependent_stiffness;
mod local_mode;
mod missed_mode;
mod payload;
mod position_dependent_stiffness;
mod temperature_drift;
mod transverse_compliance;

use nalgebra::Vector3;

use super::arm::Arm;
use super::candidate::{Candidate, Parameter, Scale};
use crate::model::Cause;

/// What people read about a cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CauseText {
    /// What is wrong, as a clause without its place.
    pub description: &'static str,
    /// What has similar effects.
    pub confounded_with: &'static str,
    /// A test that separates it from these, other than further poses.
    pub test: &'static str,
}

/// ln plausibility that a motion which the file does not know loses: a softer spring and another
/// one in series with it are the same, and then the one in the file is named.
const NEW_MOTION: f64 = -0.1;

/// Every candidate of every cause for an arm.
pub(super) fn candidates(arm: &Arm<'_>) -> Vec<Candidate> {
    let mut all: Vec<Candidate> =
        Cause::ALL.into_iter().flat_map(|cause| of(cause).1(arm)).collect();
    for candidate in all.iter_mut().filter(|candidate| candidate.hinge.is_some()) {
        candidate.plausibility += NEW_MOTION;
    }
    all
}

/// The text for `cause`.
pub fn cause_text(cause: Cause) -> CauseText {
    of(cause).0
}

/// What people read about a cause, and where it can sit in an arm.
fn of(cause: Cause) -> (CauseText, fn(&Arm<'_>) -> Vec<Candidate>) {
    match cause {
        Cause::JointStiffness => (joint_stiffness::TEXT, joint_stiffness::candidates),
        Cause::LinkInertia => (link_inertia::TEXT, link_inertia::candidates),
        Cause::ComOffset => (com_offset::TEXT, com_offset::candidates),
        Cause::JointZeroOffset => (joint_zero_offset::TEXT, joint_zero_offset::candidates),
        Cause::Payload => (payload::TEXT, payload::candidates),
        Cause::BaseCompliance => (base_compliance::TEXT, base_compliance::candidates),
        Cause::TransverseCompliance => {
            (transverse_compliance::TEXT, transverse_compliance::candidates)
        }
        Cause::LinkFlexibility => (link_flexibility::TEXT, link_flexibility::candidates),
        Cause::LocalMode => (local_mode::TEXT, local_mode::candidates),
        Cause::DriveInertia => (drive_inertia::TEXT, drive_inertia::candidates),
        Cause::LoadDependentStiffness => {
            (load_dependent_stiffness::TEXT, load_dependent_stiffness::candidates)
        }
        Cause::AmplitudeDependence => {
            (amplitude_dependence::TEXT, amplitude_dependence::candidates)
        }
        Cause::TemperatureDrift => (temperature_drift::TEXT, temperature_drift::candidates),
        Cause::GravityStiffness => (gravity_stiffness::TEXT, gravity_stiffness::candidates),
        Cause::AliasedMode => (aliased_mode::TEXT, aliased_mode::candidates),
        Cause::MissedMode => (missed_mode::TEXT, missed_mode::candidates),
        Cause::PositionDependentStiffness => {
            (position_dependent_stiffness::TEXT, position_dependent_stiffness::candidates)
        }
        Cause::JointCoupling => (joint_coupling::TEXT, joint_coupling::candidates),
    }
}

/// Shares of a joint's stiffness from which a new spring starts; the first is that beside which its
/// other parameters start. Where its mode crosses another at some poses, the likelihood has a
/// narrow peak for each crossing: steps are about twofold at most.
const SPRING_STARTS: [f64; 20] = [
    3.0, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 4.5, 6.5, 9.0, 13.0, 20.0, 30.0, 60.0, 120.0,
    250.0, 500.0, 1000.0,
];

/// A spring that nothing in the file mentions: by its logarithm, from one that is as soft as `soft`
/// to one a thousand times as stiff, which nothing measures.
fn new_spring(name: &'static str, soft: f64) -> Parameter {
    Parameter {
        name,
        scale: Scale::Log,
        nominal: None,
        bounds: [0.02 * soft, 2000.0 * soft],
        starts: SPRING_STARTS.iter().map(|share| share * soft).collect(),
        expected: None,
    }
}

/// A ratio to what it refines: about 1, by its logarithm.
fn ratio(name: &'static str, spread: f64) -> Parameter {
    Parameter {
        name,
        scale: Scale::Log,
        nominal: Some(1.0),
        bounds: [0.02, 50.0],
        starts: vec![1.0, 0.3, 3.0],
        expected: Some([1.0, spread]),
    }
}

/// A law with a factor holds the plain stiffness as a special case, as a part that the arm feels
/// does one that it does not, so it is an alternative of that only where the law itself shows.
const CONTAINS_PLAIN: f64 = -2.0;

/// The share of a spring where its law is centred.
fn factor() -> Parameter {
    Parameter {
        name: "factor",
        scale: Scale::Linear(0.2),
        nominal: Some(1.0),
        bounds: [0.1, 4.0],
        starts: vec![1.0, 0.75, 1.3],
        expected: Some([1.0, 0.25]),
    }
}

/// The frame's own axes that lie across `direction`.
fn across(direction: &Vector3<f64>) -> Vec<Vector3<f64>> {
    /// Axes within forty-five degrees of the direction do not count as across.
    const ALONG: f64 = 0.7072;
    let length = direction.norm();
    [Vector3::x(), Vector3::y(), Vector3::z()]
        .into_iter()
        .filter(|axis| length == 0.0 || (axis.dot(direction) / length).abs() < ALONG)
        .collect()
}
