//! Warnings on a job: what each does to the verdict, and which of them the job accepts.

use super::verdict::{OperationRisk, Warning};
use crate::job::{Acceptance, Job, Operation};
use crate::notes::{Code, Note};
use crate::paths::tidied;

/// Notes on a job as warnings, each at its operation, with what the job says to them.
pub fn warnings(job: &Job, notes: impl IntoIterator<Item = Note>) -> Vec<Warning> {
    let mut all: Vec<Warning> = notes.into_iter().flat_map(|note| located(job, note)).collect();
    for warning in &mut all {
        let entry = job.review.accept.iter().find(|entry| covers(job, entry, warning));
        warning.accepted = entry.map(|entry| entry.terms.clone());
    }
    all
}

fn covers(job: &Job, entry: &Acceptance, warning: &Warning) -> bool {
    let operations = job.operations.iter().map(|operation| operation.name.as_str());
    let own = operations.filter(|name| warning.is_about(name));
    entry.covers_warning(warning.note.code, own)
}

/// A note on a program is about the operations that run it, one on what is carried about those that
/// carry it.
fn located(job: &Job, note: Note) -> Vec<Warning> {
    let warning = Warning::from(note);
    if warning.operation.is_some() {
        return vec![warning];
    }
    let file = warning.note.place.file.as_deref().map(tidied);
    let is_of = |operation: &&Operation| match warning.note.code {
        Code::PayloadUnknown => !operation.carried.is_known(),
        _ => operation.program.is_some() && file == Some(tidied(&job.file_of_moves(operation))),
    };
    let own: Vec<_> = job.operations.iter().filter(is_of).collect();
    if own.is_empty() || own.len() == job.operations.len() {
        return vec![warning];
    }
    let at = |name: &String| Warning { operation: Some(name.clone()), ..warning.clone() };
    own.iter().map(|operation| at(&operation.name)).collect()
}

/// Entries of `accept` that meet nothing.
pub(super) fn unused(job: &Job, warnings: &[Warning], operations: &[OperationRisk]) -> Vec<Note> {
    let meets = |entry: &Acceptance| {
        let of_crossing = |risk: &OperationRisk| {
            risk.crossings.iter().any(|c| entry.covers_crossing(&risk.name, c.mode))
        };
        warnings.iter().any(|warning| covers(job, entry, warning))
            || operations.iter().any(of_crossing)
    };
    let idle = job.review.accept.iter().filter(|entry| !entry.is_shared && !meets(entry));
    idle.map(|entry| {
        let operation = entry.operation.as_ref();
        let within = operation.map_or(String::new(), |name| format!(" in operation '{name}'"));
        let what = format!(
            "accept: there is no '{}'{within} to accept; delete the entry",
            entry.kind.code()
        );
        Note::warning(Code::Unused, entry.place.clone(), what)
    })
    .collect()
}
