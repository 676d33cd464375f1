//! A robot as its files describe it: plain data in SI, not yet checked. [`super::Robot::new`]
//! checks it and turns it into the immutable model.

use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::cause::Cause;
use super::posterior::Posterior;

/// A robot before it is checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// What the robot is called in reports.
    pub name: String,
    /// The URDF's links, in file order.
    pub links: Vec<Link>,
    /// The URDF's joints, in file order.
    pub joints: Vec<Joint>,
    /// The link that stands on the ground; the root of the tree if `None`.
    pub base: Option<String>,
    /// The link whose frame carries the tool; the child of the last moving joint if `None`.
    pub tip: Option<String>,
    /// The elastic joints; a moving joint that is not listed is rigid.
    pub elastic_joints: Vec<ElasticJoint>,
    /// Further elastic coordinates: foundation, transverse compliance, link flexibility.
    pub extra: Vec<ExtraCoordinate>,
    /// Damping where a coordinate gives none.
    pub default_damping_ratio: f64,
    /// Acceleration of gravity in the base frame, m/s². It acts only where `gravity_stiffness` is
    /// set.
    pub gravity_m_per_s2: Vector3<f64>,
    /// Whether the geometric stiffness of gravity is part of K.
    pub gravity_stiffness: bool,
    /// Reflected rotor inertias.
    pub drives: Vec<Drive>,
    /// What the robot carries beside its own links.
    pub payload: Option<Payload>,
    /// How β1 of the two-link model reads from the joints.
    pub beta1: Option<ArmAngle>,
    /// How β2 of the two-link model reads from the joints.
    pub beta2: Option<ArmAngle>,
    /// How well the model was found to predict measured frequencies; `None` if it never was
    /// compared.
    pub calibration: Option<Calibration>,
    /// What is wrong in all of the above, put right when the model is built, each in turn.
    pub corrections: Vec<Correction>,
}

impl Description {
    /// From a link's frame to the farthest joint on it, m.
    pub(super) fn reach_of(&self, link: &str) -> Vector3<f64> {
        let joints = self.joints.iter().filter(|joint| joint.parent == link);
        let ends = joints.map(|joint| joint.origin.translation.vector);
        ends.fold(Vector3::zeros(), |far, end| if end.norm() > far.norm() { end } else { far })
    }
}

/// One link of the tree.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Link {
    /// Unique name.
    pub name: String,
    /// Mass properties; `None` where the file has no `<inertial>` block.
    pub inertial: Option<Inertial>,
    /// What mass and inertia may be off by, together; see [`ElasticJoint::std`].
    pub std: Option<f64>,
    /// Whether the mass properties are distributed from the mass of the whole arm.
    pub assumed: bool,
    /// Whether it is a part that a correction hangs on the arm, on a spring of its own.
    pub is_hung: bool,
    /// Whether the link has visual or collision geometry (and so ought to have a mass).
    pub has_geometry: bool,
    /// That geometry as a body of density 1 kg/m³, where it is boxes, cylinders and spheres alone.
    pub shape: Option<Inertial>,
    /// The meshes by which it is shown.
    pub meshes: Arc<[Mesh]>,
}

/// A mesh that shows a link: where it is to be found. No number of the model depends on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// As the URDF names it: a path, or `package://name/path`.
    pub file: String,
    /// The folder of the URDF.
    pub beside: PathBuf,
    /// Its frame in the link's.
    pub frame: Isometry3<f64>,
    /// Factors along its own axes.
    pub scale: [f64; 3],
}

/// Mass properties of one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertial {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass in the body's frame, m.
    pub com_m: Vector3<f64>,
    /// Rotary inertia about the centre of mass, in the axes of the body's frame, kg·m².
    pub inertia_kgm2: Matrix3<f64>,
}

/// What a URDF joint lets its child do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about the axis, with limits.
    Revolute,
    /// Turns about the axis, without limits.
    Continuous,
    /// Slides along the axis.
    Prismatic,
    /// Does not move.
    Fixed,
    /// Six free coordinates: not part of a serial arm.
    Floating,
    /// Moves in a plane: not part of a serial arm.
    Planar,
}

impl JointKind {
    /// Whether the joint has one coordinate that a pose sets.
    pub fn moves(self) -> bool {
        matches!(self, Self::Revolute | Self::Continuous | Self::Prismatic)
    }
}

/// One joint of the tree.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// Kind of motion.
    pub kind: JointKind,
    /// Name of the parent link.
    pub parent: String,
    /// Name of the child link.
    pub child: String,
    /// Joint frame in the parent link's frame; the child's frame at q = 0.
    pub origin: Isometry3<f64>,
    /// Axis in the joint frame; any length but zero.
    pub axis: Vector3<f64>,
    /// Limits of position; `None` where the file has none.
    pub position_limit: Option<[f64; 2]>,
    /// Largest speed, rad/s or m/s; `None` where the file has none or zero.
    pub velocity_limit: Option<f64>,
    /// The joint that this one mimics.
    pub mimics: Option<String>,
}

/// How a coordinate loses energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Damping {
    /// Share of critical damping of a mode whose strain energy sits all in this coordinate.
    Ratio(f64),
    /// Viscous coefficient, N·m·s/rad or N·s/m.
    Viscous(f64),
}

/// The spring in a moving joint.
#[derive(Debug, Clone, PartialEq)]
pub struct ElasticJoint {
    /// URDF name of the joint.
    pub joint: String,
    /// Spring constant, N·m/rad (revolute, continuous) or N/m (prismatic).
    pub stiffness: f64,
    /// Whether `stiffness` was given in N/m.
    pub is_linear: bool,
    /// What the stiffness may be off by: one standard deviation of its natural logarithm; `None`
    /// where nobody has said.
    pub std: Option<f64>,
    /// `None` takes the default.
    pub damping: Option<Damping>,
}

/// Whether an elastic coordinate turns or shifts what it carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoordinateKind {
    /// Angle about an axis; stiffness in N·m/rad.
    Rotation,
    /// Displacement along an axis; stiffness in N/m.
    Translation,
}

/// An elastic coordinate beside the joints: it moves a link and all that the link carries.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraCoordinate {
    /// Unique among all elastic coordinates.
    pub name: String,
    /// The link that moves.
    pub link: String,
    /// Rotation or translation.
    pub kind: CoordinateKind,
    /// Direction in the link's frame; any length but zero.
    pub axis: Vector3<f64>,
    /// A point of the axis in the link's frame, m.
    pub origin_m: Vector3<f64>,
    /// Spring constant, N·m/rad or N/m by `kind`.
    pub stiffness: f64,
    /// What the stiffness may be off by; see [`ElasticJoint::std`].
    pub std: Option<f64>,
    /// `None` takes the default.
    pub damping: Option<Damping>,
}

/// Rotor inertia seen through the gear.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// URDF name of the joint.
    pub joint: String,
    /// J·G², kg·m² (kg for a prismatic joint).
    pub reflected_inertia_kgm2: f64,
    /// What it may be off by; see [`ElasticJoint::std`].
    pub std: Option<f64>,
}

/// A body fixed to a link.
#[derive(Debug, Clone, PartialEq)]
pub struct Payload {
    /// The link that carries it.
    pub link: String,
    /// Its mass properties in that link's frame.
    pub inertial: Inertial,
}

/// An angle of the two-link model as a linear form of the joint positions.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmAngle {
    /// (URDF joint name, factor).
    pub terms: Vec<(String, f64)>,
    /// Constant part, rad.
    pub offset_rad: f64,
}

/// How well the model predicted measured frequencies on poses that it was not fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Number of poses.
    pub poses: usize,
    /// Root mean square of the relative error of the frequencies, %.
    pub heldout_rms_percent: f64,
    /// Its causes fit the table far better than they predicted poses left out.
    pub is_doubtful: bool,
    /// What was learned of the model's numbers; older files have none.
    pub posterior: Option<Posterior>,
}

impl Calibration {
    /// A calibration never claims less than this: no instrument does better, % of the frequency.
    pub const MIN_HELDOUT_PERCENT: f64 = 0.03;

    /// What a model that nobody measured is off by, one standard deviation, % of the frequency:
    /// half of the 10 % that it is taken to be off by with 95 % confidence.
    pub const UNCALIBRATED_PERCENT: f64 = 5.1;

    /// Of fewer poses, none can be left out and predicted from the others.
    pub const MIN_POSES: usize = 5;
}

/// One correction.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// What was wrong.
    pub cause: Cause,
    /// The joint, link or mode; `None` where the cause has no place.
    pub at: Option<String>,
    /// Values by name, in SI.
    pub parameters: Vec<(String, f64)>,
    /// Where and how something gives, for the causes that add an elastic coordinate.
    pub hinge: Option<Hinge>,
}

impl Correction {
    /// The value of a parameter.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|(of, _)| of == name).map(|&(_, value)| value)
    }

    /// The names of parameters that `cause` knows; those before the bar must be given, except that
    /// one of several alternatives suffices.
    pub fn parameter_names(cause: Cause) -> &'static [&'static str] {
        match cause {
            Cause::JointStiffness => &[
                "stiffness_nm_per_rad",
                "stiffness_n_per_m",
                "factor",
                "ratio_1",
                "ratio_2",
                "ratio_3",
                "ratio_4",
                "ratio_5",
                "ratio_6",
                "ratio_7",
                "ratio_8",
                "ratio_9",
            ],
            Cause::BaseCompliance => &[
                "stiffness_nm_per_rad",
                "stiffness_n_per_m",
                "depth_m",
                "turn_rad",
                "ratio_2",
                "ratio_3",
                "shift_ratio_2",
                "shift_ratio_3",
            ],
            Cause::LinkInertia => {
                &["inertia_factor", "mass_factor", "x_factor", "y_factor", "z_factor"]
            }
            Cause::ComOffset => &["dx_m", "dy_m", "dz_m"],
            Cause::JointZeroOffset => &["offset_rad", "offset_m"],
            Cause::Payload => &["mass_kg", "com_x_m", "com_y_m", "com_z_m", "gyration_m"],
            Cause::TransverseCompliance => &["stiffness_nm_per_rad", "ratio_2"],
            Cause::LinkFlexibility => {
                &["stiffness_nm_per_rad", "position", "length", "ratio_2", "ratio_3"]
            }
            Cause::LocalMode => &["frequency_hz", "mass_kg", "com_x_m", "com_y_m", "com_z_m"],
            Cause::DriveInertia => &["reflected_inertia_kgm2"],
            Cause::LoadDependentStiffness => &[
                "change_per_nm",
                "saturation_nm",
                "factor",
                "reference_nm",
                "ratio_1",
                "ratio_3",
                "torque_1_nm",
                "torque_2_nm",
            ],
            Cause::AmplitudeDependence => &["change_per_nm", "exponent", "factor", "reference_nm"],
            Cause::TemperatureDrift => &["change_per_k", "factor", "reference_c"],
            Cause::GravityStiffness => &[],
            Cause::AliasedMode => &["sample_rate_hz"],
            Cause::MissedMode => &["share"],
            Cause::PositionDependentStiffness => {
                &["cos_1", "sin_1", "cos_2", "sin_2", "cos_3", "sin_3", "factor"]
            }
            Cause::JointCoupling => &["ratio"],
        }
    }
}

/// Where and how a foundation, a joint or a link gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Hinge {
    /// Rotation or translation.
    pub kind: CoordinateKind,
    /// One elastic coordinate along or about each, in the link's frame; all have the same
    /// stiffness, but for the ratios of a correction's parameters.
    pub axes: Vec<Vector3<f64>>,
    /// A point of the axes, in the link's frame, m.
    pub origin_m: Vector3<f64>,
    /// What of the link's own body moves; all that the link carries does.
    pub carries: Carries,
}

/// What of a link's own body moves with a hinge in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carries {
    /// All of it.
    Link,
    /// The outer part: the body is cut at the hinge.
    Part,
    /// Nothing.
    Rest,
}

impl Carries {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Link => "link",
            Self::Part => "part",
            Self::Rest => "rest",
        }
    }
}

impl Hinge {
    /// Along `axis`, at the origin of the link's frame.
    pub fn shift(axis: Vector3<f64>) -> Self {
        Self {
            kind: CoordinateKind::Translation,
            axes: vec![axis],
            origin_m: Vector3::zeros(),
            carries: Carries::Link,
        }
    }

    /// Whether it turns.
    pub fn turns(&self) -> bool {
        self.kind == CoordinateKind::Rotation
    }
}
