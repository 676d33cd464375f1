//! Motions → poses in time, as the controller interpolates them, and what the arm is like along them.
//!
//! s runs from 0 to 1 over an operation, in proportion to time. Joint moves are straight in the joints;
//! lines and arcs are straight or round in the tool centre point and go through inverse kinematics.

mod curve;
mod families;
mod grid;
mod lookout;
mod plan;
mod survey;
mod surveyor;
mod timing;
mod tip_modes;
mod waves;

pub use families::{Families, FamilyExchange, follow};
pub use grid::{LARGEST_STEP, LONGEST_GAP, grid};
pub use plan::{Haste, Path, Walker};
pub use survey::{Detail, Station, Survey};
pub use surveyor::Surveyor;
pub use tip_modes::{TipModes, tip_modes};
