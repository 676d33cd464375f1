//! Where the excitation lines of a job meet the modes of its arm, and what that means.

mod about;
mod assess;
mod bands;
mod certainty;
mod crossings;
mod left_out;
mod margin;
mod operation_notes;
mod probability;
mod rules;
mod speed_change;
mod spindle_profile;
mod tool_tip;
mod verdict;
mod warnings;

pub use about::{about_operation, in_operation};
pub use assess::{Paths, assess, crossings_under, detail, probabilities_under};
pub use certainty::Certainty;
pub use margin::closest_approach;
pub use operation_notes::{Counted, FIRST_FREQUENCY_HZ, chosen_joints, nothing_checked};
pub use probability::{ArmDraws, JobDraws, Probabilities};
pub use rules::Rules;
pub use spindle_profile::SpindleProfile;
pub use tool_tip::{
    Drilling, Excess, Harmonic, Largest, Quantity, SurfaceError, TipAt, ToolTip, assumed_point,
    exceeded_at_speed, limits_at_speed,
};
pub use verdict::{
    Approach, Crossing, Driver, JobRisk, LeftOut, ModeExchange, Move, OperationRisk, Sample,
    SpeedPoint, Verdict, Warning,
};
pub use warnings::warnings;
