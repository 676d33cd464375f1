//! What somebody has looked at and accepts, with a reason and until a day.

use std::fmt;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use super::Job;
use crate::notes::{Code, Note, Place};
use crate::units::{Date, written};

/// Warnings on the files of a job, what it takes from settings that jobs share, and which findings
/// are accepted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Review {
    /// Warnings that came up while the files were read.
    pub warnings: Vec<Note>,
    /// What comes from a detune.toml; `None` where there is none, or nothing in it counts here.
    pub settings: Option<Settings>,
    /// Keys of the policy that the run sets, which no file says: `separation_percent=8`.
    pub overrides: Vec<String>,
    /// What is accepted: by the job, then by the settings.
    pub accept: Vec<Acceptance>,
}

/// What a job takes from the settings that it shares with others.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Settings {
    /// The detune.toml, as seen from where the job was named.
    #[serde(serialize_with = "written::path")]
    pub file: PathBuf,
    /// Its keys that count for the job.
    pub keys: Vec<String>,
}

/// One entry of `accept`.
#[derive(Debug, Clone, PartialEq)]
pub struct Acceptance {
    /// Of what kind.
    pub kind: Acceptable,
    /// In which operation, or anywhere.
    pub operation: Option<String>,
    /// Why, and how long.
    pub terms: Accepted,
    /// Where it stands.
    pub place: Place,
    /// Whether it may be meant for other jobs, too.
    pub is_shared: bool,
}

/// What can be accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Acceptable {
    /// Warnings with this code.
    Warning(Code),
    /// That a line lies in the band of this mode, or of any.
    Crossing {
        /// Counted from 1.
        mode: Option<usize>,
    },
}

/// Why something is accepted, and how long.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct Accepted {
    /// Why.
    pub reason: String,
    /// The last day.
    pub until: Date,
}

impl fmt::Display for Accepted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "until {}: {}", self.until, self.reason)
    }
}

impl Acceptable {
    /// The code of a crossing in `accept`.
    pub const CROSSING: &'static str = "crossing";

    /// Its code in `accept`.
    pub fn code(self) -> &'static str {
        match self {
            Self::Warning(code) => code.name(),
            Self::Crossing { .. } => Self::CROSSING,
        }
    }
}

/// The operation of which a program makes `operation`, if that is the name of a stretch: rough/2,
/// rough/3 of rough.
pub fn stretch_of(operation: &str) -> Option<&str> {
    let (whole, number) = operation.rsplit_once('/')?;
    let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then_some(whole)
}

impl Acceptance {
    /// Whether it is about an operation of this name.
    pub fn is_about(&self, operation: &str) -> bool {
        self.operation
            .as_deref()
            .is_none_or(|name| operation == name || stretch_of(operation) == Some(name))
    }

    /// Whether it covers a crossing of a mode, counted from 1.
    pub fn covers_crossing(&self, operation: &str, mode: usize) -> bool {
        let Acceptable::Crossing { mode: of } = self.kind else { return false };
        of.is_none_or(|of| of == mode) && self.is_about(operation)
    }

    /// Whether it covers warnings with a code on some operations.
    pub fn covers_warning<'o>(
        &self,
        code: Code,
        mut operations: impl Iterator<Item = &'o str>,
    ) -> bool {
        self.kind == Acceptable::Warning(code) && operations.all(|name| self.is_about(name))
    }
}

impl Review {
    /// Crossings that are accepted.
    pub fn crossings(&self) -> impl Iterator<Item = &Acceptance> {
        self.accept.iter().filter(|entry| matches!(entry.kind, Acceptable::Crossing { .. }))
    }

    /// What accepts that a line lies in the band of a mode, counted from 1, in an operation.
    pub fn of_crossing(&self, operation: &str, mode: usize) -> Option<&Acceptance> {
        self.accept.iter().find(|entry| entry.covers_crossing(operation, mode))
    }
}

impl Job {
    /// Drops what is accepted no longer, each with a warning.
    pub fn expire(&mut self, today: Date) {
        let Review { warnings, accept, .. } = &mut self.review;
        accept.retain(|entry| {
            let holds = today <= entry.terms.until;
            if !holds {
                let what = format!(
                    "accept: '{}' was accepted until {} and counts again; look at it once more, \
                     then set a later date or delete the entry",
                    entry.kind.code(),
                    entry.terms.until
                );
                warnings.push(Note::warning(Code::Unused, entry.place.clone(), what));
            }
            holds
        });
    }
}
