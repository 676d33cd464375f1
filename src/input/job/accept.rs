//! The findings that are accepted, by a job or by settings that jobs share.

use std::path::Path;

use super::super::files::{is_one_place, named_file};
use super::super::raw::job as raw;
use crate::formats::yaml::{Node, Step};
use crate::job::{Acceptable, Acceptance, Accepted};
use crate::notes::{Class, Code, Notes, Place};
use crate::units::Date;
use crate::wording::hint;

/// Where entries of `accept` stand, and for which job they are read.
pub(super) struct Entries<'j> {
    /// The file that they stand in.
    pub(super) file: &'j Path,
    pub(super) tree: &'j Node,
    pub(super) raw: Option<&'j [raw::Acceptance]>,
    /// The job file; where it is not `file`, other jobs share them.
    pub(super) job: &'j Path,
    /// Names of its operations.
    pub(super) operations: Vec<&'j str>,
}

impl Entries<'_> {
    /// What is accepted in the job; entries with faults are left out.
    pub(super) fn acceptances(&self, notes: &mut Notes) -> Vec<Acceptance> {
        let entries = self.raw.into_iter().flatten().enumerate();
        entries.filter_map(|(index, raw)| self.acceptance(index, raw, notes)).collect()
    }

    fn acceptance(
        &self,
        index: usize,
        raw: &raw::Acceptance,
        notes: &mut Notes,
    ) -> Option<Acceptance> {
        let line =
            |key| self.tree.line_at(&[Step::Key("accept"), Step::Index(index), Step::Key(key)]);
        let kind =
            raw.code.as_deref().and_then(|code| self.acceptable(code, raw.mode, index, notes));
        let is_meant = self.is_meant(index, raw, notes);
        let is_known = |name: &&str| self.operations.contains(name);
        let names_job = !self.is_shared() || raw.job.is_some() && is_meant == Some(true);
        let unknown = raw.operation.as_deref().filter(|name| names_job && !is_known(name));
        if let Some(name) = unknown {
            let hint = hint(name, self.operations.iter().copied());
            let what = format!("accept[{index}].operation is '{name}', which does not exist{hint}");
            notes.error(Code::Reference, line("operation"), what);
        }
        let reason = raw.reason.clone()?;
        if reason.trim().is_empty() {
            let what = format!("accept[{index}].reason is empty, must say why");
            notes.error(Code::Value, line("reason"), what);
        }
        let until = raw.until.as_deref()?;
        let Some(until) = Date::read(until) else {
            let what = format!("accept[{index}].until is '{until}', must be a day as YYYY-MM-DD");
            notes.error(Code::Value, line("until"), what);
            return None;
        };
        let line = self.tree.line_at(&[Step::Key("accept"), Step::Index(index)]);
        let entry = Acceptance {
            kind: kind?,
            operation: raw.operation.clone(),
            terms: Accepted { reason, until },
            place: Place::line(self.file, line),
            is_shared: self.is_shared() && raw.job.is_none(),
        };
        is_meant?.then_some(entry)
    }

    /// Whether an entry is for the job; a fault is reported.
    fn is_meant(&self, index: usize, raw: &raw::Acceptance, notes: &mut Notes) -> Option<bool> {
        let line =
            |key| self.tree.line_at(&[Step::Key("accept"), Step::Index(index), Step::Key(key)]);
        match &raw.job {
            // Else jobs that nobody has written yet would ring unseen.
            None if self.is_shared() && raw.code.as_deref() == Some(Acceptable::CROSSING) => {
                let what = format!(
                    "accept[{index}]: a crossing is accepted in one job: write job, or accept it \
                     in the job itself"
                );
                notes.error(Code::MissingKey, line("code"), what);
                None
            }
            None => Some(true),
            Some(_) if !self.is_shared() => {
                let what = format!("accept[{index}].job has no effect in a job; delete it");
                notes.error(Code::Unused, line("job"), what);
                None
            }
            Some(name) => {
                let key = format!("accept[{index}].job");
                let job = named_file(self.file, &key, name, line("job"), notes)?;
                Some(is_one_place(&job, self.job))
            }
        }
    }

    fn is_shared(&self) -> bool {
        self.file != self.job
    }

    fn acceptable(
        &self,
        code: &str,
        mode: Option<u32>,
        index: usize,
        notes: &mut Notes,
    ) -> Option<Acceptable> {
        let line =
            |key| self.tree.line_at(&[Step::Key("accept"), Step::Index(index), Step::Key(key)]);
        if code == Acceptable::CROSSING {
            return Some(Acceptable::Crossing { mode: mode.map(|mode| mode as usize) });
        }
        let found = Code::named(code).filter(|code| code.class() != Class::Error);
        if found.is_none() {
            let all = Code::ALL.iter().filter(|code| code.class() != Class::Error);
            let names = all.map(|code| code.name()).chain([Acceptable::CROSSING]);
            let hint = hint(code, names);
            let what = format!(
                "accept[{index}].code is '{code}', must be crossing or the code of a warning{hint}"
            );
            notes.error(Code::Reference, line("code"), what);
        } else if mode.is_some() {
            let what = format!("accept[{index}].mode has no effect on warnings");
            notes.error(Code::Unused, line("mode"), what);
        }
        found.map(Acceptable::Warning)
    }
}
