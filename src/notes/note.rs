//! One error or warning, and where it stands.

use std::fmt;
use std::path::{Path, PathBuf};

use super::Code;
use crate::wording::printable;

/// Whether a note stops the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The work cannot be done.
    Error,
    /// The work goes on; the reader should know.
    Warning,
}

/// An error or a warning. Shown as "robot.yaml:14: joint 'joint_3': stiffness_nm_per_rad is -1,
/// must be positive".
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Note {
    /// Where it stands.
    pub place: Place,
    /// Of what kind.
    pub code: Code,
    /// Whether it stops the work.
    pub severity: Severity,
    /// What was read, what was expected, what to do: a lower-case fragment.
    pub what: String,
}

/// Where a note stands: a place in a file, a part of what is worked on, or both. A room that knows
/// no file names the part; whoever read the file adds file and line.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Place {
    /// The file, as the caller or the file that refers to it names it.
    pub file: Option<PathBuf>,
    /// Counted from 1; `None` where the note is about the file as a whole.
    pub line: Option<usize>,
    /// The part of the robot, job or measurement.
    pub part: Option<Part>,
    /// The key within the part, as the file spells it; empty for the part as a whole.
    pub key: &'static str,
}

/// A part of what is worked on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Part {
    /// The robot as a whole.
    Robot,
    /// The choice of base link.
    Base,
    /// The choice of tip link.
    Tip,
    /// A link of the URDF, by name.
    Link(String),
    /// A joint of the URDF, by name.
    Joint(String),
    /// The spring of a joint, by the joint's name.
    ElasticJoint(String),
    /// An extra elastic coordinate, by its index.
    Extra(usize),
    /// Default damping.
    Damping,
    /// The direction or size of gravity.
    Gravity,
    /// A reflected rotor inertia, by the joint's name.
    Drive(String),
    /// The payload.
    Payload,
    /// One of the angles of the two-link model: `beta1` or `beta2`.
    ArmAngle(&'static str),
    /// A correction, by its index.
    Correction(usize),
    /// An operation of a job, by name.
    Operation(String),
    /// A waypoint of a path, by its index.
    Waypoint(usize),
    /// A pose of a table, by its index.
    Pose(usize),
    /// A record of a session, by name.
    Record(String),
    /// A channel, and the record that it belongs to.
    Channel {
        /// Name of the record; `None` where there is but one.
        record: Option<String>,
        /// Name of the channel.
        channel: String,
    },
}

impl From<Note> for Vec<Note> {
    fn from(note: Note) -> Self {
        vec![note]
    }
}

impl Note {
    /// An error at a place.
    pub fn error(code: Code, place: Place, what: impl Into<String>) -> Self {
        Self { place, code, severity: Severity::Error, what: what.into() }
    }

    /// A warning at a place.
    pub fn warning(code: Code, place: Place, what: impl Into<String>) -> Self {
        Self { place, code, severity: Severity::Warning, what: what.into() }
    }

    /// An error of the command line.
    pub fn usage(what: impl Into<String>) -> Self {
        Self::error(Code::Usage, Place::default(), what)
    }

    /// What it says, with the part that it is about and without its place in a file.
    pub fn message(&self) -> String {
        match &self.place.part {
            Some(part) => format!("{part}: {}", self.what),
            None => self.what.clone(),
        }
    }

    /// The same note within a larger part: the part that it named until now goes to the head of the
    /// text.
    #[must_use]
    pub fn within(mut self, whole: Part) -> Self {
        if let Some(part) = self.place.part.replace(whole) {
            self.what = format!("{part}: {}", self.what);
        }
        self
    }
}

impl Place {
    /// A file as a whole.
    pub fn file(file: impl AsRef<Path>) -> Self {
        Self { file: Some(file.as_ref().to_owned()), ..Self::default() }
    }

    /// A line of a file, counted from 1; `None` for the file as a whole.
    pub fn line(file: impl AsRef<Path>, line: impl Into<Option<usize>>) -> Self {
        Self { line: line.into(), ..Self::file(file) }
    }

    /// A part of what is worked on.
    pub fn part(part: Part) -> Self {
        Self { part: Some(part), ..Self::default() }
    }

    /// A key of a part.
    pub fn key(part: Part, key: &'static str) -> Self {
        Self { key, ..Self::part(part) }
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Robot => write!(f, "robot"),
            Self::Base => write!(f, "base"),
            Self::Tip => write!(f, "tip"),
            Self::Link(name) => write!(f, "link '{name}'"),
            Self::Joint(name) | Self::ElasticJoint(name) => write!(f, "joint '{name}'"),
            Self::Extra(index) => write!(f, "extra coordinate {}", index + 1),
            Self::Damping => write!(f, "damping"),
            Self::Gravity => write!(f, "gravity"),
            Self::Drive(name) => write!(f, "drive of joint '{name}'"),
            Self::Payload => write!(f, "payload"),
            Self::ArmAngle(angle) => write!(f, "arm angle {angle}"),
            Self::Correction(index) => write!(f, "correction {}", index + 1),
            Self::Operation(name) => write!(f, "operation '{name}'"),
            Self::Waypoint(index) => write!(f, "waypoint {}", index + 1),
            Self::Pose(index) => write!(f, "pose {}", index + 1),
            Self::Record(name) => write!(f, "record '{name}'"),
            Self::Channel { record: Some(record), channel } => {
                write!(f, "record '{record}', channel '{channel}'")
            }
            Self::Channel { record: None, channel } => write!(f, "channel '{channel}'"),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.file, self.line) {
            (Some(file), Some(line)) => {
                write!(f, "{}:{line}", printable(&file.to_string_lossy()))
            }
            (Some(file), None) => write!(f, "{}", printable(&file.to_string_lossy())),
            (None, Some(line)) => write!(f, "line {line}"),
            (None, None) => Ok(()),
        }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.place.file.is_some() || self.place.line.is_some() {
            write!(f, "{}: ", self.place)?;
        }
        // Values and names of the user's stand in the text.
        f.write_str(&printable(&self.message()))
    }
}

impl std::error::Error for Note {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_says_where_it_stands() {
        let at = |place| Note::error(Code::Value, place, "bad").to_string();
        assert_eq!(at(Place::default()), "bad");
        assert_eq!(at(Place::file("a.yaml")), "a.yaml: bad");
        assert_eq!(at(Place::line("a.yaml", 3)), "a.yaml:3: bad");
        assert_eq!(at(Place::part(Part::Link("l".into()))), "link 'l': bad");
        let waypoint = Note::error(Code::Value, Place::part(Part::Waypoint(2)), "bad");
        let within = waypoint.within(Part::Operation("rough".into()));
        assert_eq!(within.to_string(), "operation 'rough': waypoint 3: bad");
    }
}
