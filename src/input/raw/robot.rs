//! robot.yaml as it is written.

use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema};
use serde::Deserialize;

use crate::model::Cause;

/// A robot: its URDF, and what a URDF does not state.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune robot.yaml")]
pub(in crate::input) struct Robot {
    /// What the robot is called in reports; the URDF's name if absent.
    #[schemars(extend("examples" = ["Two-link section of the IRB 1600"]))]
    pub(in crate::input) name: Option<String>,
    /// Free text: where the numbers come from, what they hold for.
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) note: Option<String>,
    /// URDF file, relative to this file.
    #[schemars(required, extend("examples" = ["two-link.urdf"]))]
    pub(in crate::input) urdf: Option<String>,
    /// Link that stands on the ground; the root of the tree if absent.
    #[schemars(extend("examples" = ["base_link"]))]
    pub(in crate::input) base: Option<String>,
    /// Link whose frame carries the tool; the child of the last moving joint if absent.
    #[schemars(extend("examples" = ["tool0"]))]
    pub(in crate::input) tip: Option<String>,
    /// The springs.
    #[schemars(required)]
    pub(in crate::input) elasticity: Option<Elasticity>,
    /// By URDF link name: mass properties in place of the URDF's.
    pub(in crate::input) inertials: Option<BTreeMap<String, LinkInertial>>,
    /// Mass of the whole arm, kg: what the inertials leave of it is shared out to the links that
    /// have geometry and no inertial.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [250]))]
    pub(in crate::input) total_mass_kg: Option<f64>,
    /// By joint name: reflected rotor inertia that takes part in the joint's own elastic motion.
    pub(in crate::input) drives: Option<BTreeMap<String, Drive>>,
    /// A body fixed to a link, beside the URDF's own.
    pub(in crate::input) payload: Option<Payload>,
    /// How beta1 and beta2 of the two-link model read from the joints.
    pub(in crate::input) arm_angles: Option<ArmAngles>,
    /// What is wrong in the above and how to put it right, each in turn: what `detune diagnose
    /// --write` adds.
    pub(in crate::input) corrections: Option<Vec<Correction>>,
    /// How well the model predicts measured frequencies; absent means that it never was compared.
    pub(in crate::input) calibration: Option<Calibration>,
}

/// The elastic coordinates and their damping.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Elasticity {
    /// Damping ratio where a joint or extra coordinate gives no damping; 0.02 if absent.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 0.99, "default" = 0.02))]
    pub(in crate::input) damping_ratio: Option<f64>,
    /// By URDF joint name; a moving joint that is not listed is rigid.
    pub(in crate::input) joints: Option<BTreeMap<String, JointSpring>>,
    /// Moving joints that are meant to be rigid: those not listed anywhere are taken as rigid with
    /// a warning.
    #[schemars(extend("examples" = [["joint_1"]]))]
    pub(in crate::input) rigid: Option<Vec<String>>,
    /// Further elastic coordinates: foundation, transverse compliance, link flexibility.
    pub(in crate::input) extra: Option<Vec<Extra>>,
    /// Whether gravity's geometric stiffness is part of K; false if absent.
    #[schemars(extend("default" = false))]
    pub(in crate::input) gravity: Option<bool>,
    /// Acceleration of gravity in the base frame, m/s²; [0, 0, -9.80665] if absent.
    #[schemars(extend("default" = [0, 0, -9.80665]))]
    pub(in crate::input) gravity_m_per_s2: Option<[f64; 3]>,
}

/// The spring in a moving joint: exactly one stiffness, at most one damping.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "joint"))]
pub(in crate::input) struct JointSpring {
    /// Spring constant of a joint that turns, N·m/rad.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [555000]))]
    pub(in crate::input) stiffness_nm_per_rad: Option<f64>,
    /// Spring constant of a prismatic joint, N/m.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::input) stiffness_n_per_m: Option<f64>,
    /// What the stiffness may be off by: one standard deviation of its natural logarithm, %.
    #[schemars(extend("minimum" = 0, "maximum" = 100, "examples" = [10]))]
    pub(in crate::input) std_percent: Option<f64>,
    /// Whether the stiffness is a guess: no verdict is better than uncertain then.
    pub(in crate::input) assumed: Option<bool>,
    /// Share of critical damping.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 0.99, "examples" = [0.02]))]
    pub(in crate::input) damping_ratio: Option<f64>,
    /// Viscous damping of a joint that turns, N·m·s/rad.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::input) damping_nms_per_rad: Option<f64>,
    /// Viscous damping of a prismatic joint, N·s/m.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::input) damping_ns_per_m: Option<f64>,
    /// Where the numbers come from; `assumed` or `guess` alone counts as `assumed: true`.
    pub(in crate::input) source: Option<String>,
}

/// An elastic coordinate that moves a link and all it carries. For the root link it is the
/// foundation; at a joint's child link it is the transverse (bending) compliance of that joint; at
/// a point inside a link it is link flexibility.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "extra coordinate"))]
pub(in crate::input) struct Extra {
    /// Unique among all elastic coordinates.
    #[schemars(required, extend("examples" = ["base_tilt_y"]))]
    pub(in crate::input) name: Option<String>,
    /// The URDF link that moves.
    #[schemars(required, extend("examples" = ["base_link"]))]
    pub(in crate::input) link: Option<String>,
    /// Whether it turns about the axis or shifts along it.
    #[schemars(required)]
    pub(in crate::input) kind: Option<ExtraKind>,
    /// Direction in the link's frame, any length but zero.
    #[schemars(required, extend("examples" = [[0, 1, 0]]))]
    pub(in crate::input) axis: Option<[f64; 3]>,
    /// A point of the axis in the link's frame, m; [0, 0, 0] if absent.
    #[schemars(extend("default" = [0, 0, 0]))]
    pub(in crate::input) origin_m: Option<[f64; 3]>,
    /// Spring constant: N·m/rad for a rotation, N/m for a translation.
    #[schemars(required, extend("exclusiveMinimum" = 0, "examples" = [2.0e6]))]
    pub(in crate::input) stiffness: Option<f64>,
    /// What the stiffness may be off by: one standard deviation of its natural logarithm, %.
    #[schemars(extend("minimum" = 0, "maximum" = 100, "examples" = [10]))]
    pub(in crate::input) std_percent: Option<f64>,
    /// Share of critical damping.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 0.99))]
    pub(in crate::input) damping_ratio: Option<f64>,
    /// Viscous damping of a rotation, N·m·s/rad.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::input) damping_nms_per_rad: Option<f64>,
    /// Viscous damping of a translation, N·s/m.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(in crate::input) damping_ns_per_m: Option<f64>,
    /// Where the numbers come from.
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) source: Option<String>,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum ExtraKind {
    Rotation,
    Translation,
}

/// Rotor inertia seen through the gear.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "drive of joint"))]
pub(in crate::input) struct Drive {
    /// Rotor inertia times the gear ratio squared, kg·m² (kg at a prismatic joint). Adds to the
    /// joint's own diagonal entry of M and nowhere else.
    #[schemars(required, extend("minimum" = 0))]
    pub(in crate::input) reflected_inertia_kgm2: Option<f64>,
    /// What it may be off by: one standard deviation of its natural logarithm, %.
    #[schemars(extend("minimum" = 0, "maximum" = 100, "examples" = [10]))]
    pub(in crate::input) std_percent: Option<f64>,
    /// Where the number comes from.
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) source: Option<String>,
}

/// Mass properties of a link. What is absent is the URDF's.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "link"))]
pub(in crate::input) struct LinkInertial {
    /// Mass, kg.
    #[schemars(extend("minimum" = 0, "examples" = [42]))]
    pub(in crate::input) mass_kg: Option<f64>,
    /// Centre of mass in the link's frame, m.
    #[schemars(extend("examples" = [[0, 0, 0.2]]))]
    pub(in crate::input) com_m: Option<[f64; 3]>,
    /// Rotary inertia about the centre of mass, in the axes of the link's frame, kg·m².
    pub(in crate::input) inertia_kgm2: Option<Inertia>,
    /// What mass and inertia may be off by, together: one standard deviation of their natural
    /// logarithm, %.
    #[schemars(extend("minimum" = 0, "maximum" = 100, "examples" = [10]))]
    pub(in crate::input) std_percent: Option<f64>,
    /// Where the numbers come from.
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) source: Option<String>,
}

/// A body fixed to a link.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::input) struct Payload {
    /// The URDF link that carries it.
    #[schemars(required, extend("examples" = ["tool0"]))]
    pub(in crate::input) link: Option<String>,
    #[serde(flatten)]
    pub(in crate::input) body: Body,
}

/// A body in the frame of the link that carries it; in a job that is the tip.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in crate::input) struct Body {
    /// Mass, kg.
    #[schemars(required, extend("minimum" = 0, "examples" = [4.2]))]
    pub(in crate::input) mass_kg: Option<f64>,
    /// Centre of mass in the link's frame, m; [0, 0, 0] if absent.
    #[schemars(extend("default" = [0, 0, 0]))]
    pub(in crate::input) com_m: Option<[f64; 3]>,
    /// Rotary inertia about the centre of mass, in the axes of the link's frame, kg·m²; a point
    /// mass if absent.
    pub(in crate::input) inertia_kgm2: Option<Inertia>,
    /// Where the numbers come from.
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) source: Option<String>,
}

/// A symmetric tensor of inertia, kg·m², with products as in URDF (ixy is the entry of the matrix).
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Inertia {
    /// About x, kg·m².
    #[schemars(required)]
    pub(in crate::input) ixx: Option<f64>,
    /// About y, kg·m².
    #[schemars(required)]
    pub(in crate::input) iyy: Option<f64>,
    /// About z, kg·m².
    #[schemars(required)]
    pub(in crate::input) izz: Option<f64>,
    /// Entry xy of the matrix, kg·m²; 0 if absent.
    pub(in crate::input) ixy: Option<f64>,
    /// Entry xz of the matrix, kg·m²; 0 if absent.
    pub(in crate::input) ixz: Option<f64>,
    /// Entry yz of the matrix, kg·m²; 0 if absent.
    pub(in crate::input) iyz: Option<f64>,
}

/// A correction of the model, with its cause.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "correction"))]
pub(in crate::input) struct Correction {
    /// What was wrong
    #[schemars(required, extend("examples" = ["payload"]), transform = with_causes)]
    pub(in crate::input) cause: Option<String>,
    /// The joint, link or mode that it is about; absent for gravity_stiffness.
    #[schemars(extend("examples" = ["tool0"]))]
    pub(in crate::input) at: Option<String>,
    /// Values by name, in SI.
    #[schemars(extend("examples" = [{"mass_kg": 4.9}]))]
    pub(in crate::input) parameters: Option<BTreeMap<String, f64>>,
    /// 95 % interval of each value.
    pub(in crate::input) ci95: Option<BTreeMap<String, [f64; 2]>>,
    /// For base_compliance, transverse_compliance, link_flexibility and local_mode (which shifts):
    /// turns or shifts.
    pub(in crate::input) kind: Option<ExtraKind>,
    /// For these four: about or along which axes, in the link's frame (for a joint, its child
    /// link's).
    pub(in crate::input) axes: Option<Vec<[f64; 3]>>,
    /// For these four: a point of the axes in that frame, m; [0, 0, 0] if absent.
    #[schemars(extend("default" = [0, 0, 0]))]
    pub(in crate::input) origin_m: Option<[f64; 3]>,
    /// For link_flexibility: what of the link's own body moves; all of it if absent. For
    /// local_mode, part: the link's mass, or the payload's there, has the part's already.
    #[schemars(extend("default" = "link"))]
    pub(in crate::input) carries: Option<HingeCarries>,
    /// Digest of the table that it was fitted to, see calibration.fitted_to; absent for what was
    /// written by hand.
    #[schemars(extend("examples" = ["fnv1a-8c1f0e5b7d2a9346"]))]
    pub(in crate::input) table: Option<String>,
    /// Where it comes from.
    pub(in crate::input) note: Option<String>,
}

/// The names of all causes behind a description.
fn with_causes(schema: &mut Schema) {
    let names = Cause::ALL.map(Cause::name);
    let [others @ .., last] = &names;
    let head = schema.get("description").and_then(|text| text.as_str()).unwrap_or_default();
    let text = format!("{head}: {} or {last}.", others.join(", "));
    schema.insert("description".to_owned(), text.into());
}

/// Angles of the two-link model.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct ArmAngles {
    /// Angle of the lower arm.
    pub(in crate::input) beta1: Option<ArmAngle>,
    /// Angle of the upper arm against the lower.
    pub(in crate::input) beta2: Option<ArmAngle>,
}

/// An angle: the sum of factor times joint position, plus an offset.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct ArmAngle {
    /// Factor by joint name.
    #[schemars(required, extend("examples" = [{"joint_2": 1.0}]))]
    pub(in crate::input) terms: Option<BTreeMap<String, f64>>,
    /// Offset, rad; 0 if absent.
    #[schemars(extend("default" = 0))]
    pub(in crate::input) offset_rad: Option<f64>,
}

/// How well the model predicted frequencies at poses that it was not fitted to.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Calibration {
    /// Number of poses.
    #[schemars(required, extend("minimum" = 1))]
    pub(in crate::input) poses: Option<u32>,
    /// Root mean square of the relative error of the frequencies, %.
    #[schemars(required, extend("minimum" = 0, "maximum" = 100))]
    pub(in crate::input) heldout_rms_percent: Option<f64>,
    /// Its causes fit the table far better than they predicted poses left out: no verdict is better
    /// than uncertain.
    pub(in crate::input) doubtful: Option<bool>,
    /// Day of the comparison.
    #[schemars(extend("examples" = ["2026-11-21"]))]
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) date: Option<String>,
    /// The table of measured modes that the error was measured with.
    pub(in crate::input) table: Option<TableName>,
    /// The tables that the corrections were fitted to, with their poses: an error at these poses is
    /// not held out.
    pub(in crate::input) fitted_to: Option<Vec<FittedTable>>,
    /// What was learned of the model's numbers, as diagnose writes it.
    pub(in crate::input) posterior: Option<Posterior>,
}

/// What a calibration learned of the numbers of the model, with corrections.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Posterior {
    /// Springs, links and drives, each with the mean of ln(true value / value in the file).
    #[schemars(required)]
    pub(in crate::input) parameters: Option<Vec<LearnedParameter>>,
    /// Correlation of each parameter with those before it.
    #[schemars(required)]
    pub(in crate::input) correlation: Option<Vec<Vec<f64>>>,
    /// Per mode, what stays unexplained at poses like the measured ones: one standard deviation of
    /// ln of the frequency.
    #[schemars(required)]
    pub(in crate::input) near_ln_std: Option<Vec<f64>>,
    /// The same far from the measured poses.
    #[schemars(required)]
    pub(in crate::input) far_ln_std: Option<Vec<f64>>,
    /// Distance of joint positions within which poses inform about each other, rad or m.
    #[schemars(required, extend("exclusiveMinimum" = 0))]
    pub(in crate::input) reach: Option<f64>,
    /// The measured poses: joint positions from base to tip, rad or m.
    #[schemars(required)]
    pub(in crate::input) joints: Option<Vec<Vec<f64>>>,
    /// The model that was calibrated, at the first of these poses.
    pub(in crate::input) fingerprint: Option<Fingerprint>,
}

/// A model at a pose: a figure a coordinate for masses and lengths, and one for springs.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Fingerprint {
    /// Diagonal of M, kg·m² or kg.
    #[schemars(required)]
    pub(in crate::input) mass_diagonal: Option<Vec<f64>>,
    /// Diagonal of K, N·m/rad or N/m.
    #[schemars(required)]
    pub(in crate::input) stiffness_diagonal: Option<Vec<f64>>,
}

/// A learned parameter: one of spring, link, drive, foundation and bending says what it is.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct LearnedParameter {
    /// The joint or extra coordinate of a spring.
    pub(in crate::input) spring: Option<String>,
    /// The link of a mass and its inertia.
    pub(in crate::input) link: Option<String>,
    /// The joint of a drive.
    pub(in crate::input) drive: Option<String>,
    /// A compliance of the foundation that the model lacks, against the softest joint's; `base`.
    pub(in crate::input) foundation: Option<String>,
    /// The joint across whose axis the model lacks a compliance, against the joint's own.
    pub(in crate::input) bending: Option<String>,
    /// Mean of ln(true value / value in the file); 0 of a compliance that the model lacks.
    #[schemars(required, extend("minimum" = -20, "maximum" = 20))]
    pub(in crate::input) ln: Option<f64>,
    /// One standard deviation of the same; of a compliance that the model lacks, its own.
    #[schemars(required, extend("minimum" = 0, "maximum" = 10))]
    pub(in crate::input) ln_std: Option<f64>,
}

/// A table of measured modes.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct TableName {
    /// File name.
    #[schemars(extend("examples" = ["measured.csv"]))]
    pub(in crate::input) file: Option<String>,
    /// Digest of its poses, frequencies and covariates.
    #[schemars(required, extend("examples" = ["fnv1a-8c1f0e5b7d2a9346"]))]
    pub(in crate::input) digest: Option<String>,
}

/// A table that corrections were fitted to.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct FittedTable {
    /// File name.
    #[schemars(extend("examples" = ["measured.csv"]))]
    pub(in crate::input) file: Option<String>,
    /// Digest of its poses, frequencies and covariates.
    #[schemars(required, extend("examples" = ["fnv1a-8c1f0e5b7d2a9346"]))]
    pub(in crate::input) digest: Option<String>,
    /// Its poses: joint positions from base to tip, rad or m.
    #[schemars(required, extend("examples" = [[[0.0, 0.174]]]))]
    pub(in crate::input) joints: Option<Vec<Vec<f64>>>,
}

// All of it, the part beyond the hinge, or nothing: only what the link carries.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum HingeCarries {
    Link,
    Part,
    Rest,
}
