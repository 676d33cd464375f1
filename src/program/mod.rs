//! Robot and CAM programs → motions, each with the line that asks for it.
//!
//! A dialect is a lexer and a table of words; what motion means is in one place: `log` (moves,
//! time, speeds, words of the text), `cutter` (frames, feeds and holes of CAM programs), `arc`. A
//! reader follows the program as the controller would, from the first instruction to the last, and
//! writes down every motion. What it does not understand it never passes over in silence. Where
//! motion that the program asks for would be lost or wrong, the program is refused with an error at
//! its line. The program carries a warning where something beside the motion is left out, and where
//! only the cell knows whether anything is:
//!
//! - calls of RAPID procedures that stand in no file that is read (if they name a target or sound
//!   like motion, they are refused), M codes that are not known: taken not to move;
//! - work offsets of G-code after the first, heads after the first: the job has one frame and TCP
//!   for all;
//! - ways to places that are not in the program (`GOHOME`, `G28`, `G53`): left out before the first
//!   move and behind the last; the way back from them is taken straight in the joints where it is
//!   rapid, and refused at feed.
//!
//! Frames: a target is the pose of the tool centre point (TCP) in the base frame of the robot, or
//! in the frame of work that is carried; the TCP is given in the tip frame, which for an ABB arm is
//! its `tool0`, or in the base frame where the arm carries the work. Where robot and program could
//! both give a frame:
//!
//! | | in the program | in the job | used |
//! |---|---|---|---|
//! | RAPID, tool declared in the file | yes | any | the program's `tframe` |
//! | RAPID, `tool0`, or a tool declared elsewhere | no | yes | the job's TCP |
//! | RAPID, `tool0` | no | no | the tip frame |
//! | RAPID, tool declared elsewhere | no | no | a fault |
//! | RAPID, work object | | | as for tools, with `uframe`·`oframe` and `wobj0` = the base frame |
//! | RAPID, tool that stands | yes | never | the program's, in the base frame |
//! | RAPID, work object that the arm holds | yes | never | the program's, in the tip frame |
//! | RAPID, work object on a mechanical unit | `oframe` | the unit | both |
//! | APT, G-code | never | any | the job's, otherwise the identity |
//!
//! Tool axis: APT gives a direction and G-code none (it is +z). The TCP's z axis points from the
//! spindle into the work, as that of ABB's `tool0` does, so it is the opposite of the tool axis.
//! How the tool is turned about its own axis does not matter to a cutter: the first target's x axis
//! is the work object's x axis projected across the tool (its y axis where that vanishes), and each
//! further target is the one turned least from the target before.
//!
//! Left out on purpose: rounding of corners (zones, G64) and the controller's limits of
//! acceleration.

mod apt;
mod arc;
mod beside;
mod cell;
mod corner;
mod cutter;
mod fanuc;
mod functions;
mod gcode;
mod grouping;
mod heidenhain;
mod krl;
mod log;
mod rapid;
mod rewrite;
mod settings;
mod single;
mod span;
mod spindle_names;
mod standing;
mod text;
mod tool_axis;
mod unit_watch;
mod unread;

pub use crate::motion::{MechanicalUnit, UnitAxis};
pub use rewrite::{NewSpeed, Rewrite, Rewritten, rewrite, rewrite_all};
pub use settings::{
    Assumed, Companion, Coordinates, DwellUnit, ExternalAxis, J3From, LengthUnit, RotaryAxis,
    SetBy, Setter, Settings, TipAt,
};

use std::fmt;
use std::path::Path;

pub use crate::motion::Spindle;
use crate::motion::{Move, StatedFeeds};
use crate::notes::Note;

/// The language of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dialect {
    /// ABB RAPID, a module or several in one file.
    Rapid,
    /// APT source or cutter location file.
    Apt,
    /// G-code (RS-274 as LinuxCNC and Fanuc write it, Sinumerik's words).
    GCode,
    /// Main programs and subprograms of Sinumerik: G-code in which some words mean something else.
    Sinumerik,
    /// KUKA KRL, a source file.
    Krl,
    /// Fanuc TP, a program as text.
    Fanuc,
    /// Heidenhain's conversational language.
    Heidenhain,
}

impl Dialect {
    /// The dialect that files with this extension (without the dot, any case) hold, or `None`.
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "mod" | "modx" | "prg" | "sys" | "sysx" => Some(Self::Rapid),
            "apt" | "aptsource" | "cl" | "cls" | "clsf" | "ncl" => Some(Self::Apt),
            "nc" | "ngc" | "gcode" | "tap" | "cnc" | "eia" | "ncc" => Some(Self::GCode),
            "mpf" | "spf" => Some(Self::Sinumerik),
            "src" => Some(Self::Krl),
            "ls" => Some(Self::Fanuc),
            "h" | "hnc" => Some(Self::Heidenhain),
            _ => None,
        }
    }

    /// The dialect that a file holds by its name, where Creo's `part.ncl.3` is an `.ncl`.
    pub fn of_file(file: &Path) -> Option<Self> {
        let extension = |file: &Path| file.extension()?.to_str().map(str::to_owned);
        let own = extension(file)?;
        let is_version = own.bytes().all(|byte| byte.is_ascii_digit());
        Self::from_extension(&if is_version { extension(file.file_stem()?.as_ref())? } else { own })
    }
}

impl fmt::Display for Dialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Rapid => "RAPID",
            Self::Apt => "APT",
            Self::GCode => "G-code",
            Self::Sinumerik => "Sinumerik",
            Self::Krl => "KRL",
            Self::Fanuc => "Fanuc TP",
            Self::Heidenhain => "Heidenhain",
        })
    }
}

/// How fast a move is to run.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Pace {
    /// m/s.
    Feed(f64),
    /// At the job's feed: the program gives none.
    Unstated,
    /// As fast as it goes: the program gives no speed.
    Rapid,
    /// In so many seconds.
    Seconds(f64),
    /// At this share of the joints' speeds.
    Joints(f64),
}

/// Speed of rapid moves where nobody gives one, m/s: an assumption, not a figure of any robot.
pub const RAPID_M_PER_S: f64 = 0.5;

/// Moves of a program. Cycles, arcs and loops multiply: a short line may ask for a thousand
/// million.
const MAX_MOVES: usize = 2_000_000;

/// What a program asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// The moves in the order in which they run; at least one. The first goes to where the path
    /// starts.
    pub moves: Vec<Move>,
    /// Commands to the spindle in the order in which they run. RAPID has no instruction for the
    /// spindle: there it is what [`Settings::spindle_from`] says, and a warning names what looks
    /// like one.
    pub spindle: Vec<SpindleCommand>,
    /// Whether it states feeds of its own.
    pub feeds: StatedFeeds,
    /// What was left out or assumed without loss of motion, by line.
    pub warnings: Vec<Note>,
    /// Where the text states speeds and feeds.
    words: Vec<log::Word>,
}

impl Program {
    /// The steps, rev/min, in which what sets the spindle takes its speed, where it takes whole
    /// numbers alone.
    pub fn speed_step_rpm(&self) -> Option<f64> {
        let steps = self.words.iter().filter_map(|word| match word.states {
            log::States::Spindle { rpm_per_unit, whole: true, .. } => Some(rpm_per_unit),
            _ => None,
        });
        steps.reduce(f64::max)
    }
}

/// A command to the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleCommand {
    /// Line of the program, counted from 1.
    pub line: usize,
    /// What it does from here on.
    pub spindle: Spindle,
    /// Index in [`Program::moves`] of the first move under this speed (their number, if none
    /// follows).
    pub from_move: usize,
}

/// A tool's number as controllers count them.
fn tool_number(number: f64) -> Result<u32, String> {
    if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) {
        Ok(number as u32)
    } else {
        Err(format!("the tool's number is {number}, must be a whole number from 0 on"))
    }
}

/// Reads a program: UTF-8 or Latin-1, any line ends, with or without byte-order mark.
///
/// # Errors
/// Every error that was found, by line: motion that is not understood, that depends on what is
/// known only at run time, or that is impossible; a text that contains no motion, or more than two
/// million moves.
pub fn read(bytes: &[u8], dialect: Dialect, settings: &Settings) -> Result<Program, Vec<Note>> {
    read_up_to(MAX_MOVES, bytes, dialect, settings)
}

fn read_up_to(
    max_moves: usize,
    bytes: &[u8],
    dialect: Dialect,
    settings: &Settings,
) -> Result<Program, Vec<Note>> {
    let text = text::decode(bytes)?.text;
    let mut log = log::Log::new(max_moves, settings);
    match dialect {
        Dialect::Rapid => rapid::read(&text, settings, &mut log),
        Dialect::Apt => apt::read(&text, settings, &mut log),
        Dialect::GCode => gcode::read(&text, settings, &mut log, false),
        Dialect::Sinumerik => gcode::read(&text, settings, &mut log, true),
        Dialect::Krl => krl::read(&text, settings, &mut log),
        Dialect::Fanuc => fanuc::read(&text, settings, &mut log),
        Dialect::Heidenhain => heidenhain::read(&text, settings, &mut log),
    }
    if matches!(dialect, Dialect::Krl | Dialect::Fanuc) {
        unread::setters(&text, dialect, settings, &[], &mut log);
    }
    log.finish(dialect)
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn settings() -> Settings {
        Settings { feed_m_per_s: Some(0.01), joint_count: 6, ..Settings::default() }
    }

    #[test]
    fn too_many_moves_are_a_fault_where_the_reader_stops() {
        let rapid = "MODULE m\nPROC main()\nFOR i FROM 1 TO 400000 DO\n\
                     MoveL [[i,0,0],[1,0,0,0],[0,0,0,0],\
                     [9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;\nENDFOR\nGluePath;\n\
                     ENDPROC\nENDMODULE\n";
        let apt = "GOTO/0,0,1\nCYCLE/DRILL,DEPTH,5,CLEAR,2\n".to_owned()
            + &"GOTO/1,0,0\nGOTO/2,0,0\n".repeat(50)
            + "GOFWD/1\n";
        let repeats = "G0 X0 Y0 Z0\nG91 G83 X0.001 Y0 Z-10 R-1 Q0.001 L10000\nG5 X1\n";
        let helix = "G0 X10 Y0 Z0\nG2 X10 Y0 Z-9 I-10 P1000 F100\nG5 X1\n";
        for (text, dialect, line) in [
            (rapid, Dialect::Rapid, 4),
            // The first point and three moves a hole: the 34th hole is one too many.
            (&apt, Dialect::Apt, 36),
            (repeats, Dialect::GCode, 2),
            (helix, Dialect::GCode, 2),
        ] {
            let found = read_up_to(100, text.as_bytes(), dialect, &settings()).unwrap_err();
            // What follows, which is wrong, too, is not read.
            let [only] = found.as_slice() else { panic!("{found:?}") };
            assert_eq!(only.place.line, Some(line), "{only}");
            assert!(only.what.contains("more than 100 moves"), "{only}");
        }
    }

    #[test]
    fn as_many_moves_as_are_taken_are_read() {
        let text = "G0 X0 Y0 Z0\nX1\nX2\nM2\n";
        let read = |most| read_up_to(most, text.as_bytes(), Dialect::GCode, &settings());
        assert_eq!(read(3).unwrap().moves.len(), 3);
        assert_eq!(read(2).unwrap_err()[0].place.line, Some(3));
    }
}
