//! Where the excitation lines of a job meet the modes of its arm, and what that means.

mod assess;
mod bands;
mod crossings;
mod left_out;
mod margin;
mod notices;
mod turning;
mod verdict;

pub use assess::{assess, crossings_under, detail, plan};
pub use margin::{Approach, closest_approach};
pub use notices::{Counted, about_operation, in_operation, nothing_checked};
pub use turning::Turning;
pub use verdict::{
    Certainty, Crossing, Exchange, JobRisk, LeftOut, OperationRisk, Sample, Verdict,
};
