//! The robot as built: a tree of rigid bodies on elastic coordinates, and what follows from it at a
//! pose. Everything here is a pure function of (robot, pose); nothing reads files, knows a job or
//! knows a measurement.
//!
//! A pose q freezes the moving joints; the elastic coordinates α move about it:
//! M(q) α̈ + C α̇ + (K + K_g(q)) α = f.

mod assembly;
mod assumed_mass;
mod body;
mod cause;
mod correction;
mod description;
mod dynamics;
mod fingerprint;
mod frame;
mod inertia;
mod inverse_kinematics;
mod placement;
mod plausibility;
mod pose_fault;
mod posterior;
mod products;
mod robot;
mod tip;

pub use cause::{Cause, Changes};
pub use correction::{
    ALL_JOINTS, Conditions, REFERENCE_TEMPERATURE_C, SPRING_RATIOS, StiffnessLaw,
};
pub use description::{
    ArmAngle, Calibration, Carries, CoordinateKind, Correction, Damping, Description, Drive,
    ElasticJoint, ExtraCoordinate, Hinge, Inertial, Joint, JointKind, Link, Mesh, Payload,
};
pub use dynamics::{inverse_dynamics, potential, potential_gradient};
pub use inertia::{
    body_mass_matrix, gravity_stiffness, lacking_rotations, mass_matrix, spring_constant,
    stiffness_matrix,
};
pub use inverse_kinematics::{
    IkFault, IkMethod, InverseKinematics, Singularity, Solver, turn_towards,
};
pub use placement::Placement;
pub use plausibility::doubts;
pub use pose_fault::PoseFault;
pub(crate) use posterior::distance;
pub use posterior::{Fingerprint, LearnedParameter, ParameterKind, Posterior, Unexplained, beyond};
pub(crate) use robot::Coupling;
pub(crate) use robot::NodeMotion;
pub use robot::{
    AngleForm, Coordinate, LimitViolation, MovingJoint, PlacedMesh, Robot, UncertainBody,
};
pub use tip::{elastic_jacobian, forward_kinematics, joint_jacobian, link_rotation};
