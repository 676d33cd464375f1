//! The path of an operation → moves, of whichever kind it is.

use super::program::program_moves;
use super::raw::job as raw;
use super::waypoints::{FromPrograms, OperationContext, PathMoves, joint_moves, pose_moves};
use crate::formats::yaml::{Apart, Node, Step};
use crate::motion::Move;
use crate::notes::{Code, Notes};

/// The moves of a path; `None` where there are faults.
pub(super) fn moves_of(
    context: &OperationContext<'_>,
    raw: &raw::Path,
    operation: &Node,
    notes: &mut Notes,
    programs: &mut FromPrograms,
) -> Option<PathMoves> {
    const KEYS: [&str; 3] = ["joints_deg", "poses", "program"];
    let node = operation.get("path")?;
    let given: Vec<&str> = KEYS.into_iter().filter(|key| node.get(key).is_some()).collect();
    let called = context.called;
    match given.as_slice() {
        [] => {
            let what = "path has no waypoints, must have one of joints_deg, poses, program";
            notes.error(
                Code::MissingKey,
                operation.line_at(&[Step::Key("path")]),
                format!("{called}: {what}"),
            );
            None
        }
        [_, second, ..] => {
            let line = node.line_at(&[Step::Key(second)]);
            let what = format!("path has {}, must have one of them", given.join(" and "));
            notes.error(Code::Conflict, line, format!("{called}: {what}"));
            None
        }
        ["joints_deg"] => raw
            .joints_deg
            .and_then(|Apart| joint_moves(context, node.get("joints_deg")?, notes))
            .map(without_program),
        ["poses"] => raw
            .poses
            .and_then(|Apart| pose_moves(context, node.get("poses")?, notes))
            .map(without_program),
        [_] => program_moves(context, raw.program.as_ref()?, node, notes, programs),
    }
}

fn without_program(moves: Vec<Move>) -> PathMoves {
    PathMoves { moves, program: None }
}
