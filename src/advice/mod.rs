//! What to run instead: constant speeds that stay clear of every mode along the whole path, the
//! best of them, and where there is none, what blocks them.
//!
//! # Safe
//! A constant speed is safe if no excitation line lies in any mode's band, widened by what the
//! model may be wrong by, at any point of the path: if [`crate::risk`] would call it clear. The
//! poses of a path do not depend on the feed, nor do the frequencies along it; so a mode that
//! covers f_low..f_high bars a line of order k from all speeds between f_low (1 − w) · 60/k and
//! f_high (1 + w) · 60/k, and the safe speeds are what these blocks leave over. Excitation that the
//! policy ignores and stretches on which a mode hardly moves the tool tip are left out of the
//! blocks.
//!
//! # Feed
//! The feed follows the speed, so that the chip load stays what it was; see [`FeedRule`].

mod choice;
mod depth;
mod levers;
mod limits;
mod operation;
mod options;
mod outcome;
mod ranges;
mod ribbons;
mod schedule;
mod speeds;
mod vibration;

pub use crate::process::NoForce;
pub use depth::DepthAt;
pub use levers::{Change, Lever};
pub use operation::advise;
pub use options::{FeedRule, Objective, Options};
pub use outcome::{Depth, JobAdvice, OperationAdvice, Remedy, Vibration};
pub use ranges::ModeRange;
pub use ribbons::Ribbon;
pub use schedule::{Coupling, Exposure, KeptSchedule, NoSchedule, Passage, Schedule, SolverEnd};
pub use speeds::{Binding, Block, ClosedRange, Constant, Pair, SafeSet, Speeds};
pub use vibration::TipVibration;
