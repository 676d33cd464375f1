//! What a move does to the work.

use crate::job::Operation;
use crate::path::{Feed, MoveKind, Path};

/// A move faster than this many times the operation's feed is taken for one in the air.
const MIN_AIR_CUT_FEED_RATIO: f64 = 2.0;

/// Whether the tool is in the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InWork {
    /// It may cut.
    Cuts,
    /// The tool centre point stands: no feed, no chip.
    Stands,
    /// A rapid move, or a fast one by the joints.
    Air,
    /// A move along a line or an arc that is taken to run in the air for its feed alone.
    TakenForAir,
}

/// What the move run at `s` does, by its kind and its feed.
pub fn in_work(operation: &Operation, path: &Path, s: f64) -> InWork {
    let is_fast = path.feed_m_per_s_at(s) > MIN_AIR_CUT_FEED_RATIO * operation.feed_m_per_s;
    match path.kind_at(s) {
        MoveKind::Still => InWork::Stands,
        MoveKind::Rapid => InWork::Air,
        MoveKind::Joints if is_fast => InWork::Air,
        MoveKind::Led if is_fast => InWork::TakenForAir,
        MoveKind::Joints | MoveKind::Led => InWork::Cuts,
    }
}

/// A drill that moves within a degree of its axis drills: the cosine of that.
const MIN_INTO_WORK: f64 = 0.999_847_7;

/// How the drill of an operation moves; `None` of one that mills.
pub fn drills(operation: &Operation, feed: &Feed) -> Option<DrillMove> {
    operation.cutting.as_ref()?.drill()?;
    Some(match feed.into_work {
        into if into >= MIN_INTO_WORK => DrillMove::Into,
        into if into <= -MIN_INTO_WORK => DrillMove::OutOf,
        _ => DrillMove::Across,
    })
}

/// How a drill moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrillMove {
    /// Along its axis into the work.
    Into,
    /// Along its axis out of the work: nothing cuts.
    OutOf,
    /// Any other way, which is not drilling.
    Across,
}

/// Whether the move run at `s` is an air cut.
pub fn is_air_cut(operation: &Operation, path: &Path, s: f64) -> bool {
    matches!(in_work(operation, path, s), InWork::Air | InWork::TakenForAir)
}
