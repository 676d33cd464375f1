//! Where the excitation lines of a job meet the modes of its arm, and what that means.

mod verdict;

pub use verdict::{Certainty, Crossing, Exchange, JobRisk, OperationRisk, Sample, Verdict};
