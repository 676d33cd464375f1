//! Records of a session → modes with their uncertainties, and the table of modes that a diagnosis
//! takes.

use std::path::Path;

use super::Read;
use crate::identify::ModeTable;
use crate::identify::record::Session;
pub use crate::identify::session::{IdentifiedSession, identify_session as identify};
use crate::input::{mode_table_on, read_session};
use crate::model::Robot;
use crate::notes::Note;

/// Reads a session and its records.
pub fn read(file: &Path) -> Read<Session> {
    Read::of(|reading| read_session(file, reading))
}

/// The session's table of modes at a robot's joints: what reading the table gives that `identify
/// --write` writes, with warnings on what does not fit the robot.
///
/// # Errors
/// Joints whose names or number are not the robot's, poses outside of its limits, no modes.
pub fn table_on(
    robot: &Robot,
    found: &IdentifiedSession,
) -> Result<(ModeTable, Vec<Note>), Vec<Note>> {
    mode_table_on(robot, found.joint_columns.as_deref(), &found.table())
}
