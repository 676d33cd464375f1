//! What the arm holds, tool or work, and what carries the work.

use std::sync::Arc;

use nalgebra::Isometry3;

use crate::motion::MechanicalUnit;

/// What the arm holds; the other stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Holds {
    Tool,
    Work,
}

/// A tool centre point: in the tip frame where the arm holds the tool, else in the base frame.
pub(super) type ToolFrame = (Isometry3<f64>, Holds);

/// A work object: its frame in that of what carries it.
#[derive(Debug, Clone, Default)]
pub(super) struct WorkObject {
    pub(super) on: Carrier,
    pub(super) frame: Isometry3<f64>,
}

/// What carries the work.
#[derive(Debug, Clone, Default)]
pub(super) enum Carrier {
    #[default]
    Ground,
    Arm,
    Unit(Arc<MechanicalUnit>),
}

/// A mechanical unit that `DeactUnit` has switched off.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct UnitOff {
    /// Its name in lower case.
    pub(super) key: String,
    pub(super) shown: String,
    /// Its external axes, where the job says them.
    pub(super) axes: Option<Vec<String>>,
    /// Whether no condition that only the run knows decides about it.
    pub(super) is_sure: bool,
}

impl WorkObject {
    /// One that stands still.
    pub(super) fn fixed(frame: Isometry3<f64>) -> Self {
        Self { on: Carrier::Ground, frame }
    }
}
