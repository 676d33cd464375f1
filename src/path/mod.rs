//! Motions → poses in time, as the controller interpolates them, and what the arm is like along
//! them.
//!
//! s runs from 0 to 1 over an operation, in proportion to time. Joint moves are straight in the
//! joints; lines and arcs are straight or round in the tool centre point and go through inverse
//! kinematics.

mod batch;
mod configuration;
mod curve;
mod families;
mod grid;
mod plan;
mod refinement;
mod survey;
mod surveyor;
mod timed_path;
mod timing;
mod tip_modes;

pub use families::{Families, ModalPose, ModeExchange, follow};
pub use grid::{MAX_GAP, MAX_STEP, grid};
pub use survey::{Detail, Station, Survey};
pub use surveyor::Surveyor;
pub use timed_path::{JointOverspeed, MoveKind, Path, PathReader};
pub use tip_modes::{
    Feed, TipModes, ToolFrame, tcp_poses, tip_modes, tip_modes_of_tool, tool_frames,
};
