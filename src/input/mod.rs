//! Files → valid types: YAML, URDF, CSV, NPY, UFF, WAV. Raw input and valid input are different types; all faults of a
//! file are reported in one go, each with file and line. The only place that names urdf_rs and serde_yaml.

mod advised;
mod edit;
mod fault;
mod faults;
mod frame;
mod job;
mod load_test;
mod measured;
mod poses;
mod raw;
mod records;
mod robot;
mod robot_edit;
pub mod schema;
mod session;
mod table;
mod text;
mod urdf;
mod waypoints;
mod yaml;

use std::path::PathBuf;

pub use advised::confirm_rewritten;
pub use edit::{OperationEdit, rewritten_job, rewritten_program};
pub use fault::Fault;
pub use job::{load_job, read_job};
pub use load_test::{LoadTestRow, load_load_test};
pub use measured::read_measured;
pub use poses::{DecodedPoses, PoseDecoder, PoseTable, RawPoses};
pub use robot::{DescribedRobot, load_robot, read_described_robot, read_robot};
pub use robot_edit::{Calibrated, FittedCorrection, corrected_robot};
pub use session::{load_session, read_session};

/// What was read, and remarks on it that do not stop the work.
#[derive(Debug, Clone)]
pub struct Loaded<T> {
    /// The valid value.
    pub value: T,
    /// Settings without effect, blocks that are missing and may be forgotten.
    pub notices: Vec<Fault>,
}

/// What is noted while files are read, whether or not something valid comes of them.
#[derive(Debug, Clone, Default)]
pub struct Reading {
    /// Remarks that do not stop the work.
    pub notices: Vec<Fault>,
    /// The files that were read, or were to be read: nothing may be written over them.
    pub files: Vec<PathBuf>,
}

impl Reading {
    /// What came of reading, with the remarks on it.
    fn of<T>(
        read: impl FnOnce(&mut Self) -> Result<T, Vec<Fault>>,
    ) -> Result<Loaded<T>, Vec<Fault>> {
        let mut reading = Self::default();
        read(&mut reading).map(|value| Loaded { value, notices: reading.notices })
    }

    fn append(&mut self, mut other: Self) {
        self.notices.append(&mut other.notices);
        self.files.append(&mut other.files);
    }
}
