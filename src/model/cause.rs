//! The vocabulary of what a model of a robot can get wrong.

use std::fmt;

/// One kind of error of a model, as robot.yaml and the diagnosis name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Cause {
    /// The spring constant of a joint.
    JointStiffness,
    /// The rotary inertia of a link about its centre of mass, or the mass that it implies.
    LinkInertia,
    /// The centre of mass of a link lies elsewhere.
    ComOffset,
    /// The angle that the model takes for zero is not zero.
    JointZeroOffset,
    /// Mass on a link that the model does not know.
    Payload,
    /// The foundation gives.
    BaseCompliance,
    /// A joint also bends across its axis.
    TransverseCompliance,
    /// A link itself bends.
    LinkFlexibility,
    /// A part on a link (gripper, dress pack) has a natural frequency of its own.
    LocalMode,
    /// The rotor's reflected inertia takes part.
    DriveInertia,
    /// A spring stiffens or softens with the gravity torque that it carries.
    LoadDependentStiffness,
    /// A spring changes with the level of excitation.
    AmplitudeDependence,
    /// A spring changes with temperature.
    TemperatureDrift,
    /// The geometric stiffness of gravity was left out.
    GravityStiffness,
    /// A frequency is aliased.
    AliasedMode,
    /// At some poses a mode was not seen and the next one took its column.
    MissedMode,
    /// A spring varies with the joint's own position.
    PositionDependentStiffness,
    /// A joint's spring also feels the joint before.
    JointCoupling,
}

impl Cause {
    /// All causes, in the order of the documentation.
    pub const ALL: [Self; 18] = [
        Self::JointStiffness,
        Self::LinkInertia,
        Self::ComOffset,
        Self::JointZeroOffset,
        Self::Payload,
        Self::BaseCompliance,
        Self::TransverseCompliance,
        Self::LinkFlexibility,
        Self::LocalMode,
        Self::DriveInertia,
        Self::LoadDependentStiffness,
        Self::AmplitudeDependence,
        Self::TemperatureDrift,
        Self::GravityStiffness,
        Self::AliasedMode,
        Self::MissedMode,
        Self::PositionDependentStiffness,
        Self::JointCoupling,
    ];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::JointStiffness => "joint_stiffness",
            Self::LinkInertia => "link_inertia",
            Self::ComOffset => "com_offset",
            Self::JointZeroOffset => "joint_zero_offset",
            Self::Payload => "payload",
            Self::BaseCompliance => "base_compliance",
            Self::TransverseCompliance => "transverse_compliance",
            Self::LinkFlexibility => "link_flexibility",
            Self::LocalMode => "local_mode",
            Self::DriveInertia => "drive_inertia",
            Self::LoadDependentStiffness => "load_dependent_stiffness",
            Self::AmplitudeDependence => "amplitude_dependence",
            Self::TemperatureDrift => "temperature_drift",
            Self::GravityStiffness => "gravity_stiffness",
            Self::AliasedMode => "aliased_mode",
            Self::MissedMode => "missed_mode",
            Self::PositionDependentStiffness => "position_dependent_stiffness",
            Self::JointCoupling => "joint_coupling",
        }
    }

    /// The cause of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|cause| cause.name() == name)
    }

    /// What it changes: what a new cause needs beside its parameters follows from that.
    pub fn changes(self) -> Changes {
        match self {
            Self::JointStiffness
            | Self::LinkInertia
            | Self::ComOffset
            | Self::JointZeroOffset
            | Self::Payload
            | Self::BaseCompliance
            | Self::TransverseCompliance
            | Self::LinkFlexibility
            | Self::LocalMode
            | Self::DriveInertia
            | Self::GravityStiffness
            | Self::JointCoupling => Changes::Arm,
            Self::LoadDependentStiffness | Self::PositionDependentStiffness => {
                Changes::SpringByPose
            }
            Self::AmplitudeDependence | Self::TemperatureDrift => Changes::SpringByConditions,
            Self::AliasedMode | Self::MissedMode => Changes::Instrument,
        }
    }

    /// Whether the instrument is at fault and not the robot's model.
    pub fn is_of_the_instrument(self) -> bool {
        self.changes() == Changes::Instrument
    }

    /// Whether it depends on what a measurement was made under, beside the pose.
    pub fn is_of_conditions(self) -> bool {
        self.changes() == Changes::SpringByConditions
    }
}

/// What a cause changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Changes {
    /// The arm as it is described.
    Arm,
    /// A spring, by a law of the pose ([`super::Correction`] makes it).
    SpringByPose,
    /// A spring, by a law of what a measurement was made under; a diagnosis centres it on the
    /// table.
    SpringByConditions,
    /// What the instrument shows, and nothing of the arm.
    Instrument,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
