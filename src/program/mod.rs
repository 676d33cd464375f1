//! Robot and CAM programs → motions, each with the line that asks for it.
//!
//! Three dialects: RAPID (ABB), APT / cutter location files, and G-code. A reader follows the program as
//! the controller would, from the first instruction to the last, and writes down every motion. What
//! it does not understand it never passes over in silence: where motion may be lost or wrong the
//! program is refused with a [`ProgramFault`]; where only something beside the motion is left out, the
//! program carries a notice.
//!
//! Frames: a target is the pose of the tool centre point (TCP) in the base frame of the robot; the TCP
//! is given in the tip frame, which for an ABB arm is its `tool0`. Where robot and program could both
//! tell a frame:
//!
//! | | the program tells | the job tells | taken |
//! |---|---|---|---|
//! | RAPID, tool declared in the file | yes | any | the program's `tframe` |
//! | RAPID, `tool0`, or a tool declared elsewhere | no | yes | the job's TCP |
//! | RAPID, `tool0` | no | no | the tip frame |
//! | RAPID, tool declared elsewhere | no | no | a fault |
//! | RAPID, work object | | | as for tools, with `uframe`·`oframe` and `wobj0` = the base frame |
//! | APT, G-code | never | any | the job's, or else the identity |
//!
//! Tool axis: APT gives a direction and G-code none (it is +z). The TCP's z axis points from the
//! spindle into the work, as that of ABB's `tool0` does, so it is the opposite of the tool axis. How
//! the tool is turned about its own axis does not matter to a cutter: the first target's x axis is
//! the work object's x axis projected across the tool (its y axis where that vanishes), and each
//! further target is the one turned least from the target before.
//!
//! Left out on purpose: rounding of corners (zones, G64), the controller's limits of acceleration, and
//! external axes.

mod apt;
mod gcode;
mod log;
mod rapid;
mod text;
mod tool_axis;

use std::fmt;

use nalgebra::Isometry3;

use crate::motion::Move;

/// The language of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// ABB RAPID, a module or several in one file.
    Rapid,
    /// APT source or cutter location file.
    Apt,
    /// G-code (RS-274 as LinuxCNC and Fanuc write it) for three axes.
    GCode,
}

impl Dialect {
    /// The dialect that files with this extension (without the dot, any case) hold, or `None`.
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "mod" | "modx" | "prg" | "sys" | "sysx" => Some(Self::Rapid),
            "apt" | "aptsource" | "cl" | "cls" => Some(Self::Apt),
            "nc" | "ngc" | "gcode" | "tap" | "cnc" => Some(Self::GCode),
            _ => None,
        }
    }
}

/// What a program does not tell and its reader needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// RAPID: the procedure where the program starts; `None` takes `main`, or the only procedure.
    pub procedure: Option<String>,
    /// The job's tool centre point in the tip frame, if the job gives one.
    pub tcp: Option<Isometry3<f64>>,
    /// The job's work object in the base frame, if the job gives one.
    pub work_object: Option<Isometry3<f64>>,
    /// Feed where the program gives none, m/s.
    pub feed_m_per_s: f64,
    /// Speed of rapid moves of APT (`RAPID`) and G-code (`G0`), which give none, m/s.
    pub rapid_m_per_s: f64,
    /// Number of moving joints of the robot.
    pub joint_count: usize,
}

/// Speed of rapid moves where nobody gives one, m/s: an assumption, not a figure of any robot.
pub const RAPID_M_PER_S: f64 = 0.5;

/// What a program asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// The moves in the order in which they run; at least one. The first goes to where the path starts.
    pub moves: Vec<Move>,
    /// Spindle speeds in the order in which they run. RAPID has no instruction for the spindle: there
    /// this is empty, and a notice names what looks like one.
    pub spindle: Vec<SpindleCommand>,
    /// What was left out or assumed without loss of motion, by line.
    pub notices: Vec<ProgramFault>,
}

/// A command to the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleCommand {
    /// Line of the program, counted from 1.
    pub line: usize,
    /// Speed from here on, rev/min; zero is a stop.
    pub rpm: f64,
    /// Index in [`Program::moves`] of the first move under this speed (their number, if none follows).
    pub from_move: usize,
}

/// What is wrong or left out, and where.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct ProgramFault {
    /// Line of the program, counted from 1.
    pub line: usize,
    /// What was read and what was expected: a lower-case fragment.
    pub what: String,
}

impl fmt::Display for ProgramFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.line, self.what)
    }
}

/// Reads a program: UTF-8 or Latin-1, any line ends, with or without byte-order mark.
///
/// # Errors
/// Every fault that was found, by line: motion that is not understood, that depends on what is known
/// only at run time, or that is impossible; a text that moves nothing.
pub fn read(
    bytes: &[u8],
    dialect: Dialect,
    settings: &Settings,
) -> Result<Program, Vec<ProgramFault>> {
    let text = text::decode(bytes).map_err(|fault| vec![fault])?;
    let mut log = log::Log::default();
    match dialect {
        Dialect::Rapid => rapid::read(&text, settings, &mut log),
        Dialect::Apt => apt::read(&text, settings, &mut log),
        Dialect::GCode => gcode::read(&text, settings, &mut log),
    }
    log.finish()
}
