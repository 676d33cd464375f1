//! Files that changed, and whether a job has to do with them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::files::whole_place;
use super::settings::NAME;
use crate::notes::{Code, Note, Place};
use crate::paths::folder_of;

/// Files that were changed, added or deleted.
#[derive(Debug, Clone, Default)]
pub struct Changes {
    /// Files by their place on the disk.
    places: HashSet<PathBuf>,
    /// Folders from which a file is gone: who reads a folder may have read that, too.
    bereft: HashSet<PathBuf>,
    /// Folders with a settings file that counts, or counted, for all jobs below them.
    settings: HashSet<PathBuf>,
    /// Files in folders that are not there: what they were to a job nobody can tell.
    nowhere: Vec<PathBuf>,
}

impl Changes {
    /// Of these files, whether or not they are still there.
    pub fn of(files: &[PathBuf]) -> Self {
        let mut changes = Self::default();
        for file in files {
            let place = whole_place(file);
            let folder = folder_of(&place).to_owned();
            if !folder.is_dir() {
                changes.nowhere.push(file.clone());
            }
            if place.file_name().is_some_and(|name| name == NAME) {
                changes.settings.insert(folder);
            } else if !file.exists() {
                changes.bereft.insert(folder);
            }
            changes.places.insert(place);
        }
        changes
    }

    /// A warning of files in folders that are not there, where there are any.
    pub fn nowhere(&self) -> Option<Note> {
        let first = self.nowhere.first()?;
        let more = match self.nowhere.len() - 1 {
            0 => String::new(),
            more => format!(" (and {more} more)"),
        };
        let what = format!(
            "there is no such folder{more}, so every job counts as affected: names must be \
             relative to the current folder and unquoted (git diff --name-only --relative -z)"
        );
        Some(Note::warning(Code::Assumed, Place::file(first), what))
    }

    /// Whether a job that reads these files may be another one by the change.
    pub fn touch(&self, job: &Path, read: &[PathBuf]) -> bool {
        if !self.nowhere.is_empty() {
            return true;
        }
        let of_settings =
            || whole_place(job).ancestors().any(|folder| self.settings.contains(folder));
        let is_touched = |file: &PathBuf| {
            let place = whole_place(file);
            self.bereft.contains(folder_of(&place)) || self.places.contains(&place)
        };
        of_settings() || is_touched(&job.to_owned()) || read.iter().any(is_touched)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deleted_files_and_settings_reach_who_may_have_read_them() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("jobs/nc")).unwrap();
        for name in ["jobs/a.yaml", "jobs/nc/a.mod", "arm.yaml"] {
            std::fs::write(at(name), "").unwrap();
        }
        let read = [at("jobs/a.yaml"), at("jobs/nc/../nc/a.mod"), at("arm.yaml")];
        let touch = |file: &str| Changes::of(&[at(file)]).touch(&at("jobs/a.yaml"), &read);
        for file in
            ["jobs/a.yaml", "jobs/./nc/a.mod", "arm.yaml", "jobs/nc/gone.sys", "detune.toml"]
        {
            assert!(touch(file), "{file}");
        }
        std::fs::write(at("README.md"), "").unwrap();
        std::fs::write(at("jobs/b.yaml"), "").unwrap();
        for file in ["README.md", "jobs/b.yaml", "jobs/nc/detune.toml"] {
            assert!(!touch(file), "{file}");
        }
        assert!(touch("elsewhere/x.mod"));
        let nowhere = |file: &str| Changes::of(&[at(file)]).nowhere();
        assert!(nowhere("elsewhere/x.mod").is_some() && nowhere("jobs/gone.mod").is_none());
    }
}
