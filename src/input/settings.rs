//! detune.toml: what the jobs in a folder, and in those below it, share.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::files::{MAX_ROBOT_BYTES, relative_to};
use super::raw::settings as raw;
use super::{Reading, schema};
use crate::formats::text::read_text;
use crate::formats::toml::document;
use crate::formats::yaml::Node;
use crate::notes::{Notes, Place};
use crate::paths::folder_of;

pub(super) const NAME: &str = "detune.toml";

/// What marks the root of a repository, beyond which nothing is looked for.
const ROOTS: [&str; 2] = [".git", ".hg"];

/// A detune.toml as it is written.
pub(super) struct Shared {
    pub(super) file: PathBuf,
    pub(super) tree: Node,
    pub(super) raw: raw::Settings,
}

/// What a job shares with others.
#[derive(Default)]
pub(super) struct Settings {
    /// `None` where there is no detune.toml, or it cannot be read.
    pub(super) shared: Option<Shared>,
    /// About the detune.toml.
    pub(super) notes: Notes,
}

impl Settings {
    /// Reads the detune.toml that counts for a job.
    pub(super) fn of(job: &Path, reading: &mut Reading) -> Self {
        let Some(file) = nearest(job) else { return Self::default() };
        reading.files.push(file.clone());
        let mut notes = Notes::about(Place::file(&file));
        let shared = match read_text(&file, MAX_ROBOT_BYTES) {
            Ok(text) => document(&text, &schema::of::<raw::Settings>(), &mut notes)
                .map(|(tree, raw)| Shared { file, tree, raw }),
            Err(error) => {
                notes.push(error);
                None
            }
        };
        Self { shared, notes }
    }
}

/// The detune.toml that is nearest to a job: in its folder, else in the next one above, up to the
/// root of the repository. `None` where there is none.
fn nearest(job: &Path) -> Option<PathBuf> {
    // Where the folder does not exist, neither does the job.
    let folder = folder_of(job).canonicalize().ok()?;
    let mut up = PathBuf::new();
    for folder in folder.ancestors() {
        // What cannot be looked at is not passed over: reading it says why.
        let is_there = |error: std::io::Error| error.kind() != ErrorKind::NotFound;
        if folder.join(NAME).symlink_metadata().map_or_else(is_there, |_| true) {
            return Some(relative_to(job, &up.join(NAME).to_string_lossy()));
        }
        if ROOTS.iter().any(|root| folder.join(root).exists()) {
            return None;
        }
        up.push("..");
    }
    None
}
