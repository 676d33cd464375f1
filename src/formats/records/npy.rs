//! A record as an array of NumPy, samples × channels: its channels are called `ch1`, `ch2`, …; it
//! states no sampling rate.

use std::path::Path;

use super::{MAX_RECORD_BYTES, MIN_SAMPLES, Recording, numbered};
use crate::formats::npy::{Layout, MAGIC};
use crate::formats::text::read_bytes;
use crate::notes::{Code, Note, Place};

/// The shape that is read.
const SHAPE: &str = "(samples,) or (samples, channels)";

pub(super) fn read(path: &Path) -> Result<Recording, Vec<Note>> {
    let fault = |code, what: String| vec![Note::error(code, Place::file(path), what)];
    let syntax = |what: String| fault(Code::Syntax, what);
    let bytes = read_bytes(path, MAX_RECORD_BYTES)?;
    let Some(mut rest) = bytes.strip_prefix(MAGIC) else {
        return Err(syntax("does not begin as .npy does (\\x93NUMPY)".to_owned()));
    };
    let layout = Layout::read(&mut rest, None, SHAPE).map_err(syntax)?;
    let Layout { rows, columns, .. } = layout;
    if columns > rows.max(1) {
        return Err(syntax(format!("has shape ({rows}, {columns}), must be {SHAPE}; save its .T")));
    }
    if columns == 0 || rows < MIN_SAMPLES {
        let what = format!(
            "has {rows} samples of {columns} channel(s), must have at least {MIN_SAMPLES} of one"
        );
        return Err(fault(Code::TooLittleData, what));
    }
    let columns = layout.columns_in(rest).map_err(syntax)?;
    let channels = numbered(columns.into_iter());
    for channel in &channels {
        if let Some(at) = channel.samples.iter().position(|value| !value.is_finite()) {
            let what = format!("{}: sample {} is not finite", channel.label.name, at + 1);
            return Err(fault(Code::Value, what));
        }
    }
    Ok(Recording { channels, ..Recording::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(bytes: &[u8]) -> Result<Recording, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        std::fs::write(&path, bytes).unwrap();
        read(&path).map_err(|notes| notes[0].what.clone())
    }

    fn array(descr: &str, by_column: &str, shape: &str, numbers: &[u8]) -> Vec<u8> {
        let header =
            format!("{{'descr': '{descr}', 'fortran_order': {by_column}, 'shape': ({shape}), }}\n");
        let length = u16::try_from(header.len()).unwrap().to_le_bytes();
        [MAGIC, &[1, 0], &length, header.as_bytes(), numbers].concat()
    }

    #[test]
    fn columns_are_channels_in_either_order_and_one_column_is_one() {
        let by_row: Vec<u8> = (0..20).flat_map(|k| f64::from(k).to_le_bytes()).collect();
        let by_column: Vec<u8> = (0..2)
            .flat_map(|c| (0..10_u8).map(move |r| 2 * r + c))
            .flat_map(|value| f32::from(value).to_be_bytes())
            .collect();
        for bytes in
            [array("<f8", "False", "10, 2", &by_row), array(">f4", "True", "10, 2", &by_column)]
        {
            let found = told(&bytes).unwrap();
            assert_eq!((found.channels.len(), found.sample_rate_hz), (2, None));
            assert_eq!(found.channels[1].label.name, "ch2");
            assert_eq!(found.channels[1].samples[3], 7.0);
        }
        let one = told(&array("<f8", "False", "20,", &by_row)).unwrap();
        assert_eq!((one.channels.len(), one.channels[0].samples.len()), (1, 20));
    }

    #[test]
    fn what_is_no_record_is_a_fault() {
        let numbers: Vec<u8> = (0..20).flat_map(|k| f64::from(k).to_le_bytes()).collect();
        let mut broken = numbers.clone();
        broken[8 * 7..8 * 8].copy_from_slice(&f64::NAN.to_le_bytes());
        for (bytes, expected) in [
            (b"PK\x03\x04".to_vec(), "does not begin as .npy does"),
            (array("<f8", "False", "2, 10", &numbers), "has shape (2, 10), must be (samples,) or"),
            (array("<f8", "False", "2, 5, 2", &numbers), "has shape (2, 5, 2), must be (samples,)"),
            (array("<f8", "False", "", &numbers), "has shape (), must be"),
            (array("<f8", "False", "0,", &[]), "has 0 samples of 1 channel(s)"),
            (array("<f8", "False", "10, 0", &[]), "has 10 samples of 0 channel(s)"),
            (array("<f8", "False", "10, 3", &numbers), "its header states 10 rows, but it ends"),
            (array("<f8", "False", "99999999999, 2", &numbers), "it ends within row 11"),
            (array("<f8", "True", "10, 3", &numbers), "it ends within row 1"),
            (array("<f8", "False", "10, 2", &broken), "ch2: sample 4 is not finite"),
            (array("<i2", "False", "10, 2", &numbers), "has dtype '<i2', must be float64"),
        ] {
            let told = told(&bytes).unwrap_err();
            assert!(told.contains(expected), "{expected}: {told}");
        }
        let whole = array("<f8", "False", "10, 2", &numbers);
        for cut in 0..whole.len() {
            assert!(told(&whole[..cut]).is_err(), "{cut}");
        }
    }
}
