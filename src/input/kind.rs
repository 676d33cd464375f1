//! Which of detune's files a YAML file is.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::files::MAX_FILE_BYTES;
use crate::formats::text::read_text;
use crate::formats::yaml::{Node, parse, spelled};
use crate::notes::{Code, Note, Notes, Place};

/// What a YAML file is, by its keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// It has `operations`.
    Job,
    /// It has `urdf` or `elasticity`.
    Robot,
    /// It has `records`.
    Session,
    /// It has `modes` of a tool tip.
    Modes,
    /// Nothing that is known.
    Other,
}

impl FileKind {
    fn of(tree: &Node) -> Self {
        let has = |key| tree.get(key).is_some();
        if has("operations") {
            Self::Job
        } else if has("urdf") || has("elasticity") {
            Self::Robot
        } else if has("records") {
            Self::Session
        } else if tree.get("modes").is_some_and(|modes| !modes.items().is_empty()) {
            Self::Modes
        } else {
            Self::Other
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Job => "a job (it has 'operations')",
            Self::Robot => "a robot (it has 'urdf' or 'elasticity')",
            Self::Session => "a session (it has 'records')",
            Self::Modes => "a file of modes (it has 'modes')",
            Self::Other => "none of detune's files",
        }
    }

    /// What reads it, or where its name is written.
    fn place(self) -> &'static str {
        match self {
            Self::Job => "detune check, advise, report, deflection and lobes read jobs",
            Self::Robot => {
                "a job names it under 'robot'; detune map, doctor, diagnose and deflection read \
                 robots"
            }
            Self::Session => "detune identify reads sessions",
            Self::Modes | Self::Other => "detune lobes reads modes",
        }
    }
}

/// What a file is.
///
/// # Errors
/// A file that cannot be read.
pub fn file_kind(path: &Path) -> Result<FileKind, Vec<Note>> {
    let text = read_text(path, MAX_FILE_BYTES)?;
    let mut notes = Notes::about(Place::file(path));
    Ok(parse(&text, &mut notes).map_or(FileKind::Other, |tree| FileKind::of(&tree)))
}

/// The tree of a file that must be of a kind, and the raw type that it spells. A file of another
/// kind has that one fault.
pub(super) fn document_of<T: DeserializeOwned>(
    kind: FileKind,
    text: &str,
    schema: &Value,
    notes: &mut Notes,
) -> Option<(Node, T)> {
    let tree = parse(text, notes)?;
    let found = FileKind::of(&tree);
    if found != kind && found != FileKind::Other {
        let what = format!("this is {}, must be {}; {}", found.name(), kind.name(), found.place());
        notes.error(Code::Unreadable, tree.line as usize, what);
        return None;
    }
    spelled(tree, schema, notes)
}
