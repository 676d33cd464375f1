//! Records of vibration: CSV, universal files, WAV, NumPy's arrays and MATLAB's variables →
//! channels as they are in the file.

mod clock;
mod csv;
mod mat;
mod npy;
mod responses;
mod uff;
mod wav;

use std::path::Path;

use nalgebra::Complex;

use crate::notes::{Code, Note, Place};

pub(crate) use self::clock::time as seconds_of;

/// Largest file of raw data that is read.
const MAX_RECORD_BYTES: u64 = 512 << 20;

/// Fewest samples of a record.
const MIN_SAMPLES: usize = 8;

/// What a file says of a channel or function beside its numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Label {
    pub(crate) name: String,
    /// Another name that means it, such as the identification line of a data set.
    pub(crate) alias: String,
    /// Unit as it is written; empty where it is not.
    pub(crate) unit: String,
    /// Specific data type of data set 58.
    pub(crate) data_type: Option<i64>,
}

/// A channel over time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Channel {
    pub(crate) label: Label,
    pub(crate) samples: Vec<f64>,
}

/// A frequency response.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Function {
    pub(crate) label: Label,
    /// Empty where the file does not name it.
    pub(crate) reference: String,
    pub(crate) frequencies_hz: Vec<f64>,
    pub(crate) values: Vec<Complex<f64>>,
    /// Line where its data set starts; 0 where the file has no lines.
    pub(crate) line: usize,
}

/// What is in a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Recording {
    /// Samples per second, where the file states them.
    pub(crate) sample_rate_hz: Option<f64>,
    /// When the samples were taken, s, where that is not in even steps.
    pub(crate) times_s: Option<Vec<f64>>,
    /// What the file calls its time.
    pub(crate) time: Option<String>,
    pub(crate) channels: Vec<Channel>,
    pub(crate) functions: Vec<Function>,
    /// Whether names of channels were chosen by people, who may have put units into them.
    pub(crate) is_titled: bool,
    /// Line of the header of a table, of which all columns but time are channels.
    pub(crate) header_line: Option<usize>,
    /// Remarks that do not stop the work.
    pub(crate) warnings: Vec<Note>,
}

impl Recording {
    /// The name of the channel or function that `wanted` means; itself where it means none.
    pub(crate) fn full_name<'n>(&'n self, wanted: &'n str) -> &'n str {
        let names = || self.both_names();
        let is_full = names().any(|(name, _)| name == wanted);
        let by_alias = || names().find(|(_, alias)| *alias == wanted).map(|(name, _)| name);
        if is_full { wanted } else { by_alias().unwrap_or(wanted) }
    }

    /// Names and aliases of the channels or functions of these names.
    pub(crate) fn names_of(&self, of: &[String]) -> Vec<String> {
        let wanted = self.both_names().filter(|(name, _)| of.iter().any(|of| of == name));
        wanted.flat_map(|(name, alias)| [name.to_owned(), alias.to_owned()]).collect()
    }

    fn both_names(&self) -> impl Iterator<Item = (&str, &str)> {
        let channels = self.channels.iter().map(|channel| &channel.label);
        let labels = channels.chain(self.functions.iter().map(|function| &function.label));
        labels.map(|label| (label.name.as_str(), label.alias.as_str()))
    }
}

/// Channels that have no names: `ch1`, `ch2`, …
fn numbered(columns: impl Iterator<Item = Vec<f64>>) -> Vec<Channel> {
    let channel = |(at, samples)| {
        let name = format!("ch{}", at + 1);
        Channel { label: Label { alias: name.clone(), name, ..Label::default() }, samples }
    };
    columns.enumerate().map(channel).collect()
}

/// Reads a file by its ending: `.csv` (or `.txt`), `.uff`, `.unv`, `.uf`, `.wav`,
/// `.npy`, `.mat`. `time` is what the session says that time is called, in files that do not say it
/// themselves.
///
/// # Errors
/// Every fault of the file with its line, or an ending that is not known.
pub(crate) fn read_record(path: &Path, time: Option<&str>) -> Result<Recording, Vec<Note>> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match ending.as_str() {
        "csv" | "txt" => csv::read(path, time),
        "uff" | "unv" | "uf" => uff::read(path),
        "wav" | "wave" => wav::read(path),
        "npy" => npy::read(path),
        "mat" => mat::read(path, time),
        _ => {
            let what =
                format!("ends in '.{ending}', must end in .csv, .uff, .unv, .wav, .npy or .mat");
            Err(vec![Note::error(Code::Unreadable, Place::file(path), what)])
        }
    }
}
