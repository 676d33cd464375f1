//! What a program does not say and its reader needs to know.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use nalgebra::{Isometry3, Unit, Vector3};

use super::{RAPID_M_PER_S, text};
use crate::motion::MechanicalUnit;
use crate::notes::Note;

/// What a program does not say and its reader needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// RAPID, KRL: the procedure where the program starts; `None` takes `main`, or the only
    /// procedure.
    pub procedure: Option<String>,
    /// The job's tool centre point in the tip frame, if the job gives one.
    pub tcp: Option<Isometry3<f64>>,
    /// The job's work object in the base frame, if the job gives one.
    pub work_object: Option<Isometry3<f64>>,
    /// Feed where the program gives none, m/s; `None` makes that a fault.
    pub feed_m_per_s: Option<f64>,
    /// Speed of rapid moves of APT (`RAPID`) and G-code (`G0`), which give none, m/s.
    pub rapid_m_per_s: f64,
    /// Number of moving joints of the robot.
    pub joint_count: usize,
    /// Those that slide, by index from base to tip: a program gives their positions in mm.
    pub sliding: Vec<usize>,
    /// Where the robot has its tip; Fanuc's lines and arcs to positions in joints need it.
    pub tip_at: Option<TipAt>,
    /// RAPID: where the program sets the spindle's speed, which the language has no word for.
    pub spindle_from: Option<SetBy>,
    /// Spindle speed that the job states for the whole program, rev/min.
    pub spindle_rpm: Option<f64>,
    /// RAPID: where the program sets the number of the tool.
    pub tool_from: Option<SetBy>,
    /// G-code: what axes A, B and C turn, from the base to the tool.
    pub rotary_axes: Vec<RotaryAxis>,
    /// APT: in which coordinate system coordinates are behind a second one.
    pub coordinates: Option<Coordinates>,
    /// G-code, APT: the unit of lengths where the program does not say it.
    pub unit: Option<LengthUnit>,
    /// G-code: the unit of a dwell's P, X or U without a decimal point.
    pub dwell_unit: Option<DwellUnit>,
    /// Whether the job's spindle speed follows the program's time.
    pub is_scheduled: bool,
    /// Fanuc: what J3 is counted from.
    pub j3_from: Option<J3From>,
    /// RAPID: the arguments of the procedure, as the program would write them.
    pub arguments: Vec<String>,
    /// All but RAPID: frames of tools in the tip frame, by number.
    pub tool_frames: BTreeMap<u32, Isometry3<f64>>,
    /// Heidenhain, Sinumerik: numbers of tools that the program calls by these names.
    pub tool_names: BTreeMap<String, u32>,
    /// G-code: diameters of tools by number, mm; `None` is the job's only tool.
    pub tool_diameters_mm: BTreeMap<Option<u32>, f64>,
    /// KRL, Fanuc: bases and user frames in the robot's base frame, by number.
    pub base_frames: BTreeMap<u32, Isometry3<f64>>,
    /// Joints of the robot that the program moves as external axes, by the axis's name in lower
    /// case: indices from base to tip.
    pub external_axes: BTreeMap<String, ExternalAxis>,
    /// RAPID: units that carry the work, by name in lower case.
    pub mechanical_units: BTreeMap<String, Arc<MechanicalUnit>>,
    /// Other files of the program: modules, data lists.
    pub companions: Vec<Companion>,
    /// Values of signals, registers and the like, by name in lower case, that are known only at run
    /// time.
    pub assume: BTreeMap<String, Assumed>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            procedure: None,
            tcp: None,
            work_object: None,
            feed_m_per_s: None,
            rapid_m_per_s: RAPID_M_PER_S,
            joint_count: 0,
            sliding: Vec::new(),
            tip_at: None,
            spindle_from: None,
            spindle_rpm: None,
            tool_from: None,
            rotary_axes: Vec::new(),
            coordinates: None,
            unit: None,
            dwell_unit: None,
            is_scheduled: false,
            j3_from: None,
            arguments: Vec::new(),
            tool_frames: BTreeMap::new(),
            tool_names: BTreeMap::new(),
            tool_diameters_mm: BTreeMap::new(),
            base_frames: BTreeMap::new(),
            external_axes: BTreeMap::new(),
            mechanical_units: BTreeMap::new(),
            companions: Vec::new(),
            assume: BTreeMap::new(),
        }
    }
}

/// The pose of a robot's tip in the base frame by its joint positions, rad or m, from base to tip;
/// `None` where these are no pose of it.
#[derive(Clone)]
pub struct TipAt(Arc<Tip>);

type Tip = dyn Fn(&[f64]) -> Option<Isometry3<f64>> + Send + Sync;

impl TipAt {
    /// By a function.
    pub fn new(tip: impl Fn(&[f64]) -> Option<Isometry3<f64>> + Send + Sync + 'static) -> Self {
        Self(Arc::new(tip))
    }

    /// The tip at `q`.
    pub fn at(&self, q: &[f64]) -> Option<Isometry3<f64>> {
        (self.0)(q)
    }
}

impl fmt::Debug for TipAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("TipAt")
    }
}

/// Two are equal if they are of one robot.
impl PartialEq for TipAt {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// A joint of the robot that the program moves as an external axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExternalAxis {
    /// Its index among the moving joints, from base to tip.
    pub joint: usize,
    /// Whether it slides: positions are in mm, else in degrees.
    pub slides: bool,
}

/// Another file of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Companion {
    /// As messages name it.
    pub name: String,
    /// Its text.
    pub text: String,
}

impl Companion {
    /// A file from its bytes: UTF-8 or Latin-1, any line ends.
    ///
    /// # Errors
    /// It is no text.
    pub fn new(name: String, bytes: &[u8]) -> Result<Self, Note> {
        Ok(Self { name, text: text::decode(bytes)?.text })
    }
}

/// A value that the job assumes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Assumed {
    /// TRUE or FALSE.
    Truth(bool),
    /// A number.
    Number(f64),
}

impl Assumed {
    /// Datum and name in `$mode_op==#ex`, with or without blanks.
    pub(crate) fn enumeration(said: &str) -> Option<(&str, &str)> {
        let (datum, name) = said.split_once("==")?;
        Some((datum.trim(), name.trim_start().strip_prefix('#')?.trim()))
    }
}

/// What an axis of rotation of G-code turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotaryAxis {
    /// Its letter, in upper case: `b'A'`, `b'B'` or `b'C'`.
    pub letter: u8,
    /// What it turns about, in the work object.
    pub axis: Unit<Vector3<f64>>,
    /// Whether it turns the work, not the tool.
    pub turns_work: bool,
    /// A point on it in the work object, mm; where it turns the tool, places are of the tool tip.
    pub origin_mm: Vector3<f64>,
}

/// In which coordinate system the coordinates of a program are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinates {
    /// In the one that the program named last.
    Local,
    /// In the first.
    World,
}

/// The unit of a length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetres.
    Mm,
    /// Inches.
    Inch,
}

/// The unit of a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DwellUnit {
    /// Seconds, as LinuxCNC has it.
    Seconds,
    /// Milliseconds, as Fanuc and Haas have it.
    Milliseconds,
}

/// What the third joint of a Fanuc arm is counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum J3From {
    /// The horizontal: J2 does not change J3, and the robot's third joint is J3 + J2.
    Horizontal,
    /// The upper arm, as the robot's own joint.
    UpperArm,
}

/// How a RAPID program of this cell sets a number beside the motion.
#[derive(Debug, Clone, PartialEq)]
pub struct SetBy {
    /// The instruction or comment.
    pub what: Setter,
    /// What one unit of its value stands for.
    pub per_unit: f64,
}

/// An instruction or comment of RAPID that carries a number.
#[derive(Debug, Clone, PartialEq)]
pub enum Setter {
    /// `SetAO` or `SetGO` of this signal.
    Signal(String),
    /// A call of this procedure, and which of its arguments, from 1.
    Procedure(String, usize),
    /// A comment that starts with this text, before the instruction that it holds from.
    Comment(String),
}
