//! Where the excitation lines of a job meet the modes of its arm, and what that means.

mod assess;
mod bands;
mod crossings;
mod left_out;
mod margin;
mod notices;
mod turning;
mod verdict;

pub use assess::{
    AssessFault, assess, assess_with_progress, crossings_under, detail, located, plan,
};
pub use margin::{Approach, closest_approach};
pub use notices::{Counted, nothing_checked};
pub use turning::Turning;
pub use verdict::{
    Certainty, Crossing, Exchange, JobRisk, LeftOut, OperationRisk, Sample, Verdict,
};
