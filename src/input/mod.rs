//! Files → valid types: YAML, URDF, CSV, NPY, MAT, UFF, WAV. Raw input and valid input are
//! different types; all faults of a file are reported in one go, each with file and line. The only
//! place that names urdf_rs.

mod advised;
mod calibration;
mod carriers;
mod changes;
mod edit;
mod files;
mod frame;
mod inertials;
mod job;
mod job_files;
mod joint_columns;
mod kind;
mod load_test;
mod lobes;
mod marks;
mod measured;
mod meshes;
mod moves;
mod new_robot;
mod policy;
mod poses;
mod posterior;
mod program;
mod program_files;
mod raw;
mod records;
mod relocated;
mod robot;
mod robot_edit;
pub mod schema;
mod session;
mod settings;
mod slots;
mod urdf;
mod video;
mod waypoints;

use std::path::{Path, PathBuf};

use crate::notes::{Note, Notes};
use crate::program::Settings;

pub use advised::{Advised, confirm_rewritten};
pub use calibration::{CalibrationRecord, FittedCorrection, FittedTable, TableName};
pub use changes::Changes;
pub use edit::{OperationEdit, rewritten_job, rewritten_program};
pub use files::{repository_of, sketch_text, whole_place};
pub use job::read_job;
pub use job_files::{is_one_file, job_files};
pub use kind::{FileKind, file_kind};
pub use load_test::{LoadTestRow, read_load_test};
pub use lobes::read_tip_cut;
pub use marks::{Between, MarkBox, Side, TraceSetup, Wanted, read_marks, read_times};
pub use measured::{mode_table_on, read_measured};
pub use meshes::{MAX_MESHES, Meshes, Surface};
pub use new_robot::{
    GuessedSpring, NewRobot, UrdfParts, new_job_text, new_robot_text, read_urdf_alone,
};
pub use policy::PolicyOverrides;
pub use poses::{DecodedPoses, PoseDecoder, PoseTable, RawPoses};
pub use robot::{DescribedRobot, read_described_robot, read_robot};
pub use robot_edit::corrected_robot;
pub use session::read_session;
pub use slots::read_slots;
pub use video::{Pictures, open_video};

/// What comes up while files are read, whether or not they are valid.
#[derive(Debug, Clone, Default)]
pub struct Reading {
    /// What does not stop the work: settings without effect, values that were assumed.
    pub warnings: Vec<Note>,
    /// The files that were read, or were to be read: nothing may be written over them.
    pub files: Vec<PathBuf>,
    /// A file that this run is about to write, read as if it were there already.
    pub pending: Option<(PathBuf, Vec<u8>)>,
    /// Keys of the policy that win over those of jobs and of detune.toml.
    pub policy: PolicyOverrides,
    /// The programs that were read, with what the job says beside them.
    programs: Vec<(PathBuf, Settings)>,
}

impl Reading {
    /// Takes in the warnings; gives the errors.
    fn settle(&mut self, notes: Notes) -> Vec<Note> {
        let (errors, warnings) = notes.finish();
        self.warnings.extend(warnings);
        errors
    }

    /// What this run is about to write to `path`.
    fn pending_at(&self, path: &Path) -> Option<&[u8]> {
        let (file, bytes) = self.pending.as_ref()?;
        files::is_one_place(file, path).then_some(bytes)
    }

    fn append(&mut self, mut other: Self) {
        self.warnings.append(&mut other.warnings);
        self.files.append(&mut other.files);
        self.programs.append(&mut other.programs);
    }
}
