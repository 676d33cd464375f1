//! job.yaml as it is written.

use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use super::robot::Body;
use crate::formats::yaml::Apart;

/// A job: a robot, a cutter, a spindle and operations.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune job.yaml")]
pub(in crate::input) struct Job {
    /// What the job is called in reports; the file's name if absent.
    #[schemars(extend("examples" = ["Pocket, roughing"]))]
    pub(in crate::input) name: Option<String>,
    /// Free text.
    #[expect(dead_code, reason = "for people")]
    pub(in crate::input) note: Option<String>,
    /// robot.yaml, relative to this file; that of detune.toml if absent.
    #[schemars(extend("examples" = ["../robots/irb1600/robot.yaml"]))]
    pub(in crate::input) robot: Option<String>,
    /// The cutter; with tools, that of paths that name no tool by number.
    pub(in crate::input) tool: Option<Tool>,
    /// The cutters of programs, by the number that the program gives them.
    #[schemars(extend("examples" = [{"1": {"teeth": 3}, "2": {"teeth": 2}}]))]
    pub(in crate::input) tools: Option<BTreeMap<String, Tool>>,
    /// What the arm's tip carries, spindle and tool, or none. The program's own tool data and the
    /// payload of a tool win over it; it wins over the robot file.
    #[serde(default)]
    #[schemars(schema_with = "payload_schema")]
    pub(in crate::input) payload: Option<Payload>,
    /// Whose spindle speed and feed hold where program and job contradict each other: program or
    /// job. Without it a contradiction is an error.
    pub(in crate::input) speeds_from: Option<SpeedsFrom>,
    /// Tool centre point in the frame of the robot's tip link; identity if absent.
    pub(in crate::input) tcp: Option<Frame>,
    /// Work object in the frame of the robot's base link; identity if absent. Poses are relative to
    /// it.
    pub(in crate::input) work_object: Option<Frame>,
    /// Joints of the robot that programs move as external axes, by the program's name of the axis.
    #[schemars(extend("examples" = [{"eax_a": "rail_joint"}]))]
    pub(in crate::input) external_axes: Option<BTreeMap<String, String>>,
    /// What programs read and only the run shows, by name: signals, registers, speeds in mm/s.
    #[schemars(extend("examples" = [{"di_more": false, "R[5]": 100}]))]
    pub(in crate::input) assume: Option<BTreeMap<String, Assumed>>,
    /// The spindle.
    #[schemars(required)]
    pub(in crate::input) spindle: Option<Spindle>,
    /// What is machined, in order.
    #[schemars(required, extend("minItems" = 1))]
    pub(in crate::input) operations: Option<Vec<Operation>>,
    /// When an excitation line near a natural frequency counts.
    pub(in crate::input) policy: Option<Policy>,
    /// Other cutters that are on hand: detune advise says what they would change.
    pub(in crate::input) tools_on_hand: Option<Vec<Tool>>,
    /// How far the work object may be moved in the base frame: detune advise says what that would
    /// change.
    pub(in crate::input) work_object_shift: Option<Shift>,
    /// Findings that somebody has looked at: they count no more until a day, and are shown as
    /// accepted.
    pub(in crate::input) accept: Option<Vec<Acceptance>>,
}

/// A value that a program is taken to find.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(in crate::input) enum Assumed {
    /// TRUE or FALSE.
    Truth(bool),
    /// A number.
    Number(f64),
}

/// A finding that is accepted.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Acceptance {
    /// Code of a warning, or crossing: that a line lies in a mode's band.
    #[schemars(required, extend("examples" = ["axis_ignored"]))]
    pub(in crate::input) code: Option<String>,
    /// With crossing: the mode, counted from 1; any if absent.
    #[schemars(extend("minimum" = 1, "x-narrows" = true))]
    pub(in crate::input) mode: Option<u32>,
    /// In detune.toml: the job, relative to that file; any if absent, but for a crossing.
    #[schemars(extend("examples" = ["jobs/pocket.yaml"], "x-narrows" = true))]
    pub(in crate::input) job: Option<String>,
    /// Name of the operation; any if absent.
    #[schemars(extend("examples" = ["rough"], "x-narrows" = true))]
    pub(in crate::input) operation: Option<String>,
    /// Why it is accepted.
    #[schemars(required, extend("examples" = ["rail stands still in this cell"]))]
    pub(in crate::input) reason: Option<String>,
    /// The last day on which it is, as YYYY-MM-DD.
    #[schemars(required, extend("examples" = ["2027-06-30"]))]
    pub(in crate::input) until: Option<String>,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum SpeedsFrom {
    Program,
    Job,
}

/// What the arm's tip carries: a body, or nothing.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub(in crate::input) enum Payload {
    Nothing(Nothing),
    Body(Body),
}

#[derive(Debug, Deserialize)]
pub(in crate::input) enum Nothing {
    #[serde(rename = "none")]
    None,
}

fn payload_schema(generator: &mut SchemaGenerator) -> Schema {
    let body = generator.subschema_for::<Body>();
    json_schema!({
        "description": "What the arm's tip carries, spindle and tool: a body, or none.",
        "anyOf": [body, {"type": "string", "enum": ["none"]}, {"type": "null"}]
    })
}

/// How far something may be moved.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Shift {
    /// Least and most along x, m; [0, 0] if absent.
    #[schemars(extend("examples" = [[-0.1, 0.1]]))]
    pub(in crate::input) x_m: Option<[f64; 2]>,
    /// Least and most along y, m; [0, 0] if absent.
    pub(in crate::input) y_m: Option<[f64; 2]>,
    /// Least and most along z, m; [0, 0] if absent.
    pub(in crate::input) z_m: Option<[f64; 2]>,
}

/// The cutter.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Tool {
    /// What it is called.
    #[schemars(extend("examples" = ["12 mm 2-flute"]))]
    pub(in crate::input) name: Option<String>,
    /// Number of teeth.
    #[schemars(required, extend("minimum" = 1, "maximum" = 1000))]
    pub(in crate::input) teeth: Option<u32>,
    /// Diameter, mm.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [12]))]
    pub(in crate::input) diameter_mm: Option<f64>,
    /// For uneven pitch: the angle from each tooth to the next, degrees, adding up to 360.
    #[schemars(extend(
        "items" = {"type": "number", "exclusiveMinimum": 0},
        "examples" = [[170, 190]]
    ))]
    pub(in crate::input) pitch_deg: Option<Vec<f64>>,
    /// Angle of the flutes to the axis, degrees; 0, straight flutes, if absent.
    #[schemars(extend("minimum" = 0, "maximum" = 80, "default" = 0, "examples" = [30]))]
    pub(in crate::input) helix_deg: Option<f64>,
    /// Of a drill: the whole angle of its point, degrees; 118, a guess, if absent.
    #[schemars(extend("minimum" = 10, "maximum" = 180, "default" = 118, "examples" = [140]))]
    pub(in crate::input) point_angle_deg: Option<f64>,
    /// Where the spindle turns the cutter about another axis than its own.
    pub(in crate::input) runout: Option<Runout>,
    /// How the tool itself vibrates in its holder, as measured at its tip.
    #[schemars(extend("minItems" = 1))]
    pub(in crate::input) modes: Option<Vec<TipMode>>,
    /// What the tip carries with this cutter, spindle included, or none; the job's payload if
    /// absent.
    #[serde(default)]
    #[schemars(schema_with = "payload_schema")]
    pub(in crate::input) payload: Option<Payload>,
}

/// The axis about which a cutter turns lies beside its own.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Runout {
    /// How far, mm: half of what a dial gauge shows over a turn.
    #[schemars(required, extend("minimum" = 0, "maximum" = 1, "examples" = [0.01]))]
    pub(in crate::input) offset_mm: Option<f64>,
    /// Towards which angle of the cutter, counted from its first tooth to the next, degrees; 0 if
    /// absent.
    #[schemars(extend("minimum" = -360, "maximum" = 360, "default" = 0))]
    pub(in crate::input) angle_deg: Option<f64>,
}

/// A mode of the tool tip.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "mode"))]
pub(in crate::input) struct TipMode {
    /// Natural frequency, Hz.
    #[schemars(required, extend("exclusiveMinimum" = 0, "maximum" = 1000000, "examples" = [922]))]
    pub(in crate::input) frequency_hz: Option<f64>,
    /// Share of critical damping.
    #[schemars(required, extend("exclusiveMinimum" = 0, "maximum" = 0.99, "examples" = [0.011]))]
    pub(in crate::input) damping_ratio: Option<f64>,
    /// Mass that vibrates, as seen at the tip, kg; one of this and stiffness_n_per_m.
    #[schemars(extend("minimum" = 1e-9, "maximum" = 1e12, "examples" = [0.03993]))]
    pub(in crate::input) mass_kg: Option<f64>,
    /// Stiffness as seen at the tip, N/m; one of this and mass_kg.
    #[schemars(extend("minimum" = 0.001, "maximum" = 1e18, "examples" = [1340000]))]
    pub(in crate::input) stiffness_n_per_m: Option<f64>,
    /// The direction in which the tip moves: x along the feed, z along the spindle out of the work,
    /// y = z × x.
    #[schemars(required, extend("examples" = [[1, 0, 0]]))]
    pub(in crate::input) axis: Option<[f64; 3]>,
}

/// A frame in another one.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Frame {
    /// Origin, m; [0, 0, 0] if absent.
    #[schemars(extend("default" = [0, 0, 0]))]
    pub(in crate::input) xyz_m: Option<[f64; 3]>,
    /// Roll, pitch and yaw about fixed axes as in URDF, R = Rz Ry Rx, rad; [0, 0, 0] if absent.
    #[schemars(extend("default" = [0, 0, 0]))]
    pub(in crate::input) rpy_rad: Option<[f64; 3]>,
}

/// The spindle's abilities.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Spindle {
    /// Lowest speed, rev/min.
    #[schemars(required, extend("exclusiveMinimum" = 0, "maximum" = 10000000, "examples" = [500]))]
    pub(in crate::input) min_rpm: Option<f64>,
    /// Highest speed, rev/min.
    #[schemars(required, extend("exclusiveMinimum" = 0, "maximum" = 10000000, "examples" = [6000]))]
    pub(in crate::input) max_rpm: Option<f64>,
    /// Fastest change of speed, rev/min per second.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [500]))]
    pub(in crate::input) max_acceleration_rpm_per_s: Option<f64>,
}

/// One operation: a path under a spindle speed. One of spindle_rpm and spindle_schedule where the
/// path is not a program that states its speeds.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "operation"))]
pub(in crate::input) struct Operation {
    /// Unique within the job.
    #[schemars(required, extend("examples" = ["rough"]))]
    pub(in crate::input) name: Option<String>,
    /// Constant spindle speed, rev/min.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [1100]))]
    pub(in crate::input) spindle_rpm: Option<f64>,
    /// Spindle speed over s, which runs from 0 to 1 in proportion to time; linear between the
    /// points, constant before the first and after the last.
    #[schemars(extend("minItems" = 1))]
    pub(in crate::input) spindle_schedule: Option<Vec<SchedulePoint>>,
    /// Feed of the tool centre point, mm/min; required where the path is not a program that states
    /// its feeds.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [400]))]
    pub(in crate::input) feed_mm_per_min: Option<f64>,
    /// How the tool cuts.
    pub(in crate::input) cutting: Option<Cutting>,
    /// Joint positions near which the first target of a path of poses is sought, one for each
    /// moving joint from base to tip: degrees, millimetres for a prismatic joint. Zero if absent.
    pub(in crate::input) start_near_deg: Option<Vec<f64>>,
    /// How far the tool may be turned about its own axis, degrees, from and to: detune advise says
    /// what that would change.
    #[schemars(extend("examples" = [[-90, 90]]))]
    pub(in crate::input) free_axis_deg: Option<[f64; 2]>,
    /// Where the tool goes: exactly one of the keys.
    #[schemars(required)]
    pub(in crate::input) path: Option<Path>,
}

/// A corner of a spindle schedule.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct SchedulePoint {
    /// Share of the operation's time, 0 to 1.
    #[schemars(required, extend("minimum" = 0, "maximum" = 1))]
    pub(in crate::input) s: Option<f64>,
    /// Spindle speed, rev/min.
    #[schemars(required, extend("exclusiveMinimum" = 0))]
    pub(in crate::input) rpm: Option<f64>,
}

/// How the tool cuts.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Cutting {
    /// Radial depth of cut, mm; a slot and a drill need none.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1000, "examples" = [6]))]
    pub(in crate::input) radial_depth_mm: Option<f64>,
    /// Axial depth of cut, mm; a drill needs none.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1000, "examples" = [2]))]
    pub(in crate::input) axial_depth_mm: Option<f64>,
    /// On which side of the cut the chip is thick: climb (down-milling), conventional (up-milling)
    /// or slot; or drill, along the tool's axis into the work.
    #[schemars(required)]
    pub(in crate::input) direction: Option<Direction>,
    /// Name of the work's material; needed unless coefficients or, of a drill, thrust_n are given.
    #[schemars(extend("examples" = ["al-6061"]))]
    pub(in crate::input) material: Option<String>,
    /// Your own cutting coefficients; those of the material if absent (al-6061, al-6082 and al-7075
    /// are known).
    pub(in crate::input) coefficients: Option<Coefficients>,
    /// Of a drill: diameter of the hole that is there before, mm; 0, none, if absent.
    #[schemars(extend("minimum" = 0, "maximum" = 1000, "default" = 0, "examples" = [4]))]
    pub(in crate::input) pilot_diameter_mm: Option<f64>,
    /// Of a drill: thrust, measured or from a handbook, N; by the coefficients if absent, which
    /// leave out the chisel edge.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1000000, "examples" = [450]))]
    pub(in crate::input) thrust_n: Option<f64>,
    /// Of a drill: torque, likewise, N m; by the coefficients if absent.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 100000, "examples" = [2.5]))]
    pub(in crate::input) torque_nm: Option<f64>,
    /// Of a drill: the feed at which thrust_n and torque_nm were measured, mm per revolution; the
    /// least of the operation at its programmed speeds if absent.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1000, "examples" = [0.1]))]
    pub(in crate::input) measured_at_mm_per_rev: Option<f64>,
    /// For stability: whether a tooth cuts what the one ahead of it has left (true), or meets fresh
    /// material, so that modes can only feed each other; true if absent.
    #[schemars(extend("default" = true))]
    pub(in crate::input) regeneration: Option<bool>,
    /// For stability: process damping C, N/mm, of the flank that rubs on the waves of the surface:
    /// the force against the motion normal to it is C times the depth times the speed of that
    /// motion over the cutting speed; 0, none, if absent.
    #[schemars(extend("minimum" = 0, "maximum" = 1000000, "default" = 0, "examples" = [250]))]
    pub(in crate::input) process_damping_n_per_mm: Option<f64>,
}

/// Coefficients of the mechanistic force model.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Coefficients {
    /// Tangential, N/mm².
    #[schemars(required, extend("exclusiveMinimum" = 0, "maximum" = 100000, "examples" = [631]))]
    pub(in crate::input) ktc_n_per_mm2: Option<f64>,
    /// Radial, N/mm².
    #[schemars(required, extend("minimum" = 0, "maximum" = 100000, "examples" = [99]))]
    pub(in crate::input) krc_n_per_mm2: Option<f64>,
    /// Tangential at the edge, N/mm; 0 if absent.
    #[schemars(extend("minimum" = 0, "maximum" = 10000, "default" = 0))]
    pub(in crate::input) kte_n_per_mm: Option<f64>,
    /// Radial at the edge, N/mm; 0 if absent.
    #[schemars(extend("minimum" = 0, "maximum" = 10000, "default" = 0))]
    pub(in crate::input) kre_n_per_mm: Option<f64>,
    /// Axial, out of the holder, N/mm²; the force along the axis is not known if absent.
    #[schemars(extend("minimum" = -100000, "maximum" = 100000))]
    pub(in crate::input) kac_n_per_mm2: Option<f64>,
    /// Axial at the edge, N/mm; 0 if absent.
    #[schemars(extend("minimum" = -10000, "maximum" = 10000, "default" = 0))]
    pub(in crate::input) kae_n_per_mm: Option<f64>,
    /// Kienzle's exponent m: the tangential coefficient is ktc h^-m with h the chip's thickness in
    /// mm; 0, the same for all chips, if absent.
    #[schemars(extend("minimum" = 0, "maximum" = 0.9, "default" = 0, "examples" = [0.25]))]
    pub(in crate::input) tangential_exponent: Option<f64>,
    /// The same of the radial coefficient.
    #[schemars(extend("minimum" = 0, "maximum" = 0.9, "default" = 0))]
    pub(in crate::input) radial_exponent: Option<f64>,
    /// The same of the axial coefficient.
    #[schemars(extend("minimum" = 0, "maximum" = 0.9, "default" = 0))]
    pub(in crate::input) axial_exponent: Option<f64>,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum Direction {
    Climb,
    Conventional,
    Slot,
    Drill,
}

/// A path: exactly one of its keys. The first waypoint is where the operation starts.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Path {
    /// Joint-interpolated waypoints: rows of one value for each moving joint from base to tip,
    /// degrees for a joint that turns, millimetres for a prismatic joint.
    #[schemars(
        with = "Option<Vec<Vec<f64>>>",
        extend(
            "minItems" = 1, "x-apart" = true,
            "examples" = [[[0, 20, -10, 0, 60, 0], [10, 25, -12, 0, 60, 0]]]
        )
    )]
    pub(in crate::input) joints_deg: Option<Apart>,
    /// Poses of the tool centre point in the work object, joined by straight lines.
    #[schemars(with = "Option<Vec<Pose>>", extend("minItems" = 1, "x-apart" = true))]
    pub(in crate::input) poses: Option<Apart>,
    /// A robot or CAM program.
    pub(in crate::input) program: Option<Program>,
}

/// A pose of the tool centre point in the work object. Only its schema is used: poses are read from
/// the tree.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "read from the tree, as there may be a million")]
pub(in crate::input) struct Pose {
    /// Position, mm.
    #[schemars(extend("examples" = [[0, 0, 0]]))]
    xyz_mm: [f64; 3],
    /// Roll, pitch and yaw about fixed axes as in URDF, R = Rz Ry Rx, degrees; [0, 0, 0] if absent.
    #[schemars(extend("examples" = [[0, 180, 0]]))]
    rpy_deg: Option<[f64; 3]>,
}

/// A robot or CAM program.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Program {
    /// The program, relative to this file.
    #[schemars(required, extend("examples" = ["pocket.mod"]))]
    pub(in crate::input) file: Option<String>,
    /// Where it starts; main if absent.
    #[schemars(extend("examples" = ["main"]))]
    pub(in crate::input) procedure: Option<String>,
    /// RAPID: what sets the spindle's speed. One of signal, procedure and comment.
    #[schemars(extend("examples" = [{"signal": "aoSpindle", "rpm_per_unit": 1}]))]
    pub(in crate::input) spindle_from: Option<SpindleFrom>,
    /// RAPID: what sets the number of the tool. One of signal, procedure and comment.
    #[schemars(extend("examples" = [{"procedure": "LoadTool"}]))]
    pub(in crate::input) tool_from: Option<ToolFrom>,
    /// RAPID, KRL, TP, G-code: further files of the program, relative to this file: modules, data
    /// lists, subprograms by their name.
    #[schemars(extend("examples" = [["targets.mod"], ["pocket.dat", "config.dat"], ["L100.SPF"]]))]
    pub(in crate::input) files: Option<Vec<String>>,
    /// RAPID: the arguments of the procedure, each as the program would write it.
    #[schemars(extend("examples" = [["2", "TRUE"]]))]
    pub(in crate::input) arguments: Option<Vec<String>>,
    /// All but RAPID: tool centre points in the frame of the tip link, by the number of the tool;
    /// tcp where a number is absent.
    #[schemars(extend("examples" = [{"1": {"xyz_m": [0, 0, 0.15]}}]))]
    pub(in crate::input) tool_frames: Option<BTreeMap<String, Frame>>,
    /// KRL, Fanuc: bases and user frames in the frame of the base link, by number; work_object
    /// where a number is absent.
    #[schemars(extend("examples" = [{"1": {"xyz_m": [0.9, 0, 0.4]}}]))]
    pub(in crate::input) base_frames: Option<BTreeMap<String, Frame>>,
    /// G-code: what axes A, B and C turn, from the base to the tool; places are of the tool tip.
    pub(in crate::input) rotary_axes: Option<Vec<RotaryAxis>>,
    /// RAPID: positioners and tracks that carry the work (ufprog FALSE), by the name of the
    /// mechanical unit (ufmec).
    #[schemars(extend("examples" = [{"STN1": {"axes": [{"name": "eax_b", "axis": [0, 0, 1],
        "origin_m": [1.2, 0, 0.5]}],
        "user_frame": {"xyz_m": [1.2, 0, 0.6]}}}]))]
    pub(in crate::input) mechanical_units: Option<BTreeMap<String, MechanicalUnit>>,
    /// APT: whether coordinates behind a second coordinate system (MSYS, CSYS) are in it (local) or
    /// in the first (world).
    pub(in crate::input) coordinates: Option<Coordinates>,
    /// G-code, APT: the unit of lengths and feeds where the program does not say it; mm if absent.
    pub(in crate::input) unit: Option<LengthUnit>,
    /// G-code: the unit of a dwell's P without a decimal point: s (LinuxCNC) or ms (Fanuc, Haas).
    pub(in crate::input) dwell_unit: Option<DwellUnit>,
    /// Fanuc: what J3 is counted from: the horizontal, as most arms show it, or the upper arm.
    pub(in crate::input) j3_from: Option<J3From>,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum LengthUnit {
    Mm,
    Inch,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum DwellUnit {
    S,
    Ms,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum J3From {
    Horizontal,
    UpperArm,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum Coordinates {
    Local,
    World,
}

/// A rotary axis of G-code.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct RotaryAxis {
    /// Its letter: A, B or C.
    #[schemars(required, extend("enum" = ["A", "B", "C"]))]
    pub(in crate::input) letter: Option<String>,
    /// What it turns about, in the work object.
    #[schemars(required, extend("examples" = [[1, 0, 0]]))]
    pub(in crate::input) axis: Option<[f64; 3]>,
    /// Whether it turns the tool or the work; the tool if absent.
    pub(in crate::input) turns: Option<Turns>,
    /// A point on it in the work object, mm; [0, 0, 0] if absent.
    #[schemars(extend("default" = [0, 0, 0]))]
    pub(in crate::input) origin_mm: Option<[f64; 3]>,
}

/// A mechanical unit of RAPID that carries the work: its axes, and its user frame in the base frame
/// of the robot where all axes are at zero. It is taken as rigid.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct MechanicalUnit {
    /// Its axes, from the ground to the work.
    #[schemars(required, extend("minItems" = 1))]
    pub(in crate::input) axes: Option<Vec<UnitAxis>>,
    /// Its user frame; the base frame if absent.
    pub(in crate::input) user_frame: Option<Frame>,
}

/// An axis of a mechanical unit, in the base frame of the robot where all axes are at zero.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct UnitAxis {
    /// The external axis that it is.
    #[schemars(required, extend("enum" = ["eax_a", "eax_b", "eax_c", "eax_d", "eax_e", "eax_f"]))]
    pub(in crate::input) name: Option<String>,
    /// Its direction.
    #[schemars(required, extend("examples" = [[0, 0, 1]]))]
    pub(in crate::input) axis: Option<[f64; 3]>,
    /// A point on it, m; [0, 0, 0] if absent.
    #[schemars(extend("default" = [0, 0, 0]))]
    pub(in crate::input) origin_m: Option<[f64; 3]>,
    /// Whether it turns (positions in degrees) or slides (mm); turns if absent.
    pub(in crate::input) moves: Option<AxisMoves>,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum AxisMoves {
    Turns,
    Slides,
}

// Variants without doc comments: schemars then writes a plain `enum`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in crate::input) enum Turns {
    Tool,
    Work,
}

/// What sets the spindle's speed in a RAPID program.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct SpindleFrom {
    /// The signal of SetAO or SetGO.
    #[schemars(extend("examples" = ["aoSpindle"]))]
    pub(in crate::input) signal: Option<String>,
    /// The procedure that is called.
    #[schemars(extend("examples" = ["SpindleOn"]))]
    pub(in crate::input) procedure: Option<String>,
    /// Which of the procedure's arguments is the speed, from 1; 1 if absent.
    #[schemars(extend("minimum" = 1, "maximum" = 100, "default" = 1))]
    pub(in crate::input) argument: Option<u32>,
    /// How the comment begins, before its number.
    #[schemars(extend("examples" = ["SPINDLE"]))]
    pub(in crate::input) comment: Option<String>,
    /// rev/min for each unit of the value; 1 if absent.
    #[schemars(extend("exclusiveMinimum" = 0, "default" = 1))]
    pub(in crate::input) rpm_per_unit: Option<f64>,
}

/// What sets the number of the tool in a RAPID program.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct ToolFrom {
    /// The signal of SetAO or SetGO.
    #[schemars(extend("examples" = ["goTool"]))]
    pub(in crate::input) signal: Option<String>,
    /// The procedure that is called.
    #[schemars(extend("examples" = ["LoadTool"]))]
    pub(in crate::input) procedure: Option<String>,
    /// Which of the procedure's arguments is the number, from 1; 1 if absent.
    #[schemars(extend("minimum" = 1, "maximum" = 100, "default" = 1))]
    pub(in crate::input) argument: Option<u32>,
    /// How the comment begins, before its number.
    #[schemars(extend("examples" = ["TOOL"]))]
    pub(in crate::input) comment: Option<String>,
}

/// When an excitation line near a natural frequency counts.
#[derive(Debug, Clone, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in crate::input) struct Policy {
    /// Multiples of the tooth-passing frequency, 1 to this; 2 if absent.
    #[schemars(extend("minimum" = 0, "maximum" = 1000, "default" = 2))]
    pub(in crate::input) tooth_passing_harmonics: Option<u32>,
    /// Multiples of the spindle's frequency, 1 to this; 1 if absent, 0 switches them off.
    #[schemars(extend("minimum" = 0, "maximum" = 1000, "default" = 1))]
    pub(in crate::input) spindle_harmonics: Option<u32>,
    /// Half width of the band about a natural frequency, % of it; 10 if absent.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 100, "default" = 10))]
    pub(in crate::input) separation_percent: Option<f64>,
    /// What every frequency may be wrong by, % of it. If absent the robot says it: by what a
    /// calibration learned, else by the std_percent of springs, links and drives, else 10.
    #[schemars(extend("minimum" = 0, "maximum" = 100))]
    pub(in crate::input) model_uncertainty_percent: Option<f64>,
    /// With which frequencies lie within their intervals, %; 95 if absent.
    #[schemars(extend("minimum" = 50, "maximum" = 99.99, "default" = 95))]
    pub(in crate::input) confidence_percent: Option<f64>,
    /// Bands, Hz, in which excitation does not count; ascending.
    #[schemars(extend("examples" = [[[49, 51]]]))]
    pub(in crate::input) ignore_hz: Option<Vec<[f64; 2]>>,
    /// A mode that moves the tool tip less than this at resonance does not count, µm/N; 1 % of the
    /// operation's largest if absent, 0 counts all.
    #[schemars(extend("minimum" = 0))]
    pub(in crate::input) min_tip_response_um_per_n: Option<f64>,
    /// How far the mean cutting force may move the tool tip, µm; needs cutting with coefficients
    /// or, of a drill, with its thrust.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [200]))]
    pub(in crate::input) max_deflection_um: Option<f64>,
    /// How far the tool tip may vibrate under the cutting force, µm: the root of the sum of the
    /// squared amplitudes of its harmonics; needs cutting with coefficients.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [50]))]
    pub(in crate::input) max_vibration_um: Option<f64>,
}

impl Policy {
    /// Each key as it stands here, else as in another policy.
    pub(in crate::input) fn or(&self, other: &Self) -> Self {
        Self {
            tooth_passing_harmonics: self.tooth_passing_harmonics.or(other.tooth_passing_harmonics),
            spindle_harmonics: self.spindle_harmonics.or(other.spindle_harmonics),
            separation_percent: self.separation_percent.or(other.separation_percent),
            model_uncertainty_percent: self
                .model_uncertainty_percent
                .or(other.model_uncertainty_percent),
            confidence_percent: self.confidence_percent.or(other.confidence_percent),
            ignore_hz: self.ignore_hz.clone().or_else(|| other.ignore_hz.clone()),
            min_tip_response_um_per_n: self
                .min_tip_response_um_per_n
                .or(other.min_tip_response_um_per_n),
            max_deflection_um: self.max_deflection_um.or(other.max_deflection_um),
            max_vibration_um: self.max_vibration_um.or(other.max_vibration_um),
        }
    }
}
