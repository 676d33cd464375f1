//! Files of raw data → channels as they are in the file.

mod csv;
mod quantity;
mod uff;
mod wav;

use std::path::Path;

use nalgebra::Complex;

use crate::notes::{Code, Note, Place};
use quantity::meaning_of_name;
pub(super) use quantity::{Meaning, meaning_of_unit};

/// Largest file of raw data that is read.
pub(super) const MAX_RECORD_BYTES: u64 = 512 << 20;

/// A channel as the file has it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RawChannel {
    /// Name by which a session refers to it.
    pub(super) name: String,
    /// Another name that means it, such as the identification line of a data set.
    pub(super) alias: String,
    /// What the file itself says of its unit.
    pub(super) meaning: Option<Meaning>,
    pub(super) samples: Vec<f64>,
}

/// A frequency response as the file has it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RawFunction {
    pub(super) name: String,
    pub(super) alias: String,
    pub(super) reference: String,
    pub(super) meaning: Option<Meaning>,
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) values: Vec<Complex<f64>>,
    /// Line where its data set starts.
    pub(super) line: usize,
}

/// What is in a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct RawFile {
    /// Samples per second, where the file states them.
    pub(super) sample_rate_hz: Option<f64>,
    pub(super) channels: Vec<RawChannel>,
    pub(super) functions: Vec<RawFunction>,
    /// Remarks that do not stop the work.
    pub(super) warnings: Vec<Note>,
}

impl RawFile {
    /// The name of the channel or function that `wanted` means; itself where it means none.
    pub(super) fn full_name<'n>(&'n self, wanted: &'n str) -> &'n str {
        let names = || self.both_names();
        let is_full = names().any(|(name, _)| name == wanted);
        let by_alias = || names().find(|(_, alias)| *alias == wanted).map(|(name, _)| name);
        if is_full { wanted } else { by_alias().unwrap_or(wanted) }
    }

    /// Names and aliases of the channels or functions of these names.
    pub(super) fn names_of(&self, of: &[String]) -> Vec<String> {
        let wanted = self.both_names().filter(|(name, _)| of.iter().any(|of| of == name));
        wanted.flat_map(|(name, alias)| [name.to_owned(), alias.to_owned()]).collect()
    }

    fn both_names(&self) -> impl Iterator<Item = (&str, &str)> {
        let channels = self.channels.iter().map(|c| (c.name.as_str(), c.alias.as_str()));
        channels.chain(self.functions.iter().map(|f| (f.name.as_str(), f.alias.as_str())))
    }
}

/// Reads a file by its ending: `.csv` (or `.txt`), `.uff`, `.unv`, `.uf`, `.wav`.
///
/// # Errors
/// Every fault of the file with its line, or an ending that is not known.
pub(super) fn read_record(path: &Path) -> Result<RawFile, Vec<Note>> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match ending.as_str() {
        "csv" | "txt" => csv::read(path),
        "uff" | "unv" | "uf" => uff::read(path),
        "wav" | "wave" => wav::read(path),
        _ => {
            let what = format!("ends in '.{ending}', must end in .csv, .uff, .unv or .wav");
            Err(vec![Note::error(Code::Unreadable, Place::file(path), what)])
        }
    }
}
