//! Where prediction and measurement meet: what a model gets wrong, and why.
//!
//! Measured frequencies over poses are held against the model's. Each [`Cause`](crate::model::Cause) of the vocabulary is a
//! candidate at every place where it can sit; candidates are fitted, held against all their rivals, and
//! earn their place alone or together ([`diagnose`]). What the data cannot tell apart is told as a group; what
//! no cause explains is told as unexplained.

mod arm;
mod candidate;
mod causes;
mod choose;
mod data;
mod diagnose;
mod findings;
mod fit;
mod gain;
mod hypothesis;
mod interval;
mod likelihood;
mod mechanics;
mod next_poses;
mod outcome;
mod predict;
mod problem;
mod screen;
mod sets;
mod unknown;
mod verdict;

pub use causes::{Words, words};
pub use diagnose::{Settings, diagnose};
pub use next_poses::NextPose;
pub use outcome::{
    Diagnosis, DiagnosisFault, Errors, Estimate, Evidence, Finding, Gain, NextTest, ResidualRow,
    Suspect, Verdict,
};
pub use unknown::{Shape, Structure};
