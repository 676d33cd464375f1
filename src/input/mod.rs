//! Files → valid types: YAML, URDF, CSV. Raw input and valid input are different types; all faults of a
//! file are reported in one go, each with file and line. The only place that names urdf_rs and serde_yaml.

mod fault;
mod faults;
mod frame;
mod job;
mod load_test;
mod measured;
mod poses;
mod raw;
mod robot;
mod robot_edit;
pub mod schema;
mod table;
mod text;
mod urdf;
mod waypoints;
mod yaml;

pub use fault::Fault;
pub use job::load_job;
pub use load_test::{LoadTestRow, load_load_test};
pub use measured::load_measured;
pub use poses::{Poses, load_poses};
pub use robot::{DescribedRobot, load_described_robot, load_robot};
pub use robot_edit::{Calibrated, FittedCorrection, corrected_robot};

/// What was read, and remarks on it that do not stop the work.
#[derive(Debug, Clone)]
pub struct Loaded<T> {
    /// The valid value.
    pub value: T,
    /// Settings without effect, blocks that are missing and may be forgotten.
    pub notices: Vec<Fault>,
}
