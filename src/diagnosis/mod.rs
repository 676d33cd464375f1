//! Where prediction and measurement meet: what a model gets wrong, and why.
//!
//! Measured frequencies over poses are held against the model's. Each
//! [`Cause`](crate::model::Cause) of the vocabulary is a candidate at every place where it is
//! possible. Candidates are fitted alone and together, compared with all alternatives, and kept if
//! the data justify them ([`diagnose`]). Causes that the data cannot separate are reported as a
//! group; an error that no cause explains is reported as unexplained.

mod arm;
mod candidate;
mod causes;
mod centred;
mod choose;
mod damping;
mod data;
mod decorrelation;
mod diagnose;
mod extrapolation;
mod findings;
mod fit;
mod gain;
mod gaussian_process;
mod hypothesis;
mod interval;
mod known;
mod likelihood;
mod mechanics;
mod models;
mod next_poses;
mod noise;
mod outcome;
mod posterior;
mod predict;
mod problem;
mod rivals;
mod screen;
mod sets;
mod settle;
mod shapes;
mod statistics;
mod structure;
mod symmetry;
mod table;
mod unexplained;
mod unstated;
mod verdict;
mod without_cause;

pub use causes::{CauseText, cause_text};
pub use diagnose::{Settings, diagnose};
pub use outcome::{
    CorrectedFrequency, Diagnosis, Errors, Estimate, Evidence, Finding, Gain, LearnedDamping,
    Mirror, NextPose, NextTest, NoiseFound, ResidualRow, Shape, Structure, Suspect, Symmetry,
    Untested, Verdict, WithoutCause, label,
};
