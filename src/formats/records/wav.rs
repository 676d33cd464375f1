//! A record as WAV: its channels are called `ch1`, `ch2`, …; whole numbers become shares of full
//! scale.

use std::io::Cursor;
use std::path::Path;

use super::{MAX_RECORD_BYTES, Recording, numbered};
use crate::formats::text::read_bytes;
use crate::notes::{Code, Note, Place};

pub(super) fn read(path: &Path) -> Result<Recording, Vec<Note>> {
    let fault = |what: String| vec![Note::error(Code::Syntax, Place::file(path), what)];
    let bytes = read_bytes(path, MAX_RECORD_BYTES)?;
    let bad = |error: hound::Error| fault(format!("is no WAV file that can be read: {error}"));
    let mut reader = hound::WavReader::new(Cursor::new(bytes)).map_err(bad)?;
    let spec = reader.spec();
    if spec.channels == 0 || spec.sample_rate == 0 {
        return Err(fault("has no channels or no sampling rate".to_owned()));
    }
    let samples: Vec<f64> = match spec.sample_format {
        hound::SampleFormat::Float => reader
            .samples::<f32>()
            .map(|s| s.map(f64::from))
            .collect::<Result<_, _>>()
            .map_err(bad)?,
        hound::SampleFormat::Int => {
            let full = 2.0_f64.powi(i32::from(spec.bits_per_sample) - 1);
            let read = reader.samples::<i32>().map(|s| s.map(|s| f64::from(s) / full));
            read.collect::<Result<_, _>>().map_err(bad)?
        }
    };
    if let Some(at) = samples.iter().position(|s| !s.is_finite()) {
        return Err(fault(format!("sample {} is not finite", at / usize::from(spec.channels) + 1)));
    }
    let count = usize::from(spec.channels);
    let of = |channel| samples.iter().skip(channel).step_by(count).copied().collect();
    let channels = numbered((0..count).map(of));
    let sample_rate_hz = Some(f64::from(spec.sample_rate));
    Ok(Recording { sample_rate_hz, channels, ..Recording::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_channels_of_16_bits_come_back_and_garbage_is_a_fault() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.wav");
        let spec = hound::WavSpec {
            channels: 2,
            sample_rate: 8000,
            bits_per_sample: 16,
            sample_format: hound::SampleFormat::Int,
        };
        let mut writer = hound::WavWriter::create(&path, spec).unwrap();
        for k in 0..100_i16 {
            writer.write_sample(k * 100).unwrap();
            writer.write_sample(-k).unwrap();
        }
        writer.finalize().unwrap();
        let found = read(&path).unwrap();
        assert_eq!(found.sample_rate_hz, Some(8000.0));
        assert_eq!(found.channels[0].samples[10], 1000.0 / 32768.0);
        assert_eq!(found.channels[1].samples[99], -99.0 / 32768.0);
        let bytes = std::fs::read(&path).unwrap();
        for cut in [0, 3, 20, 40, 45, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..cut]).unwrap();
            assert!(read(&path).unwrap_err()[0].what.contains("no WAV file"), "{cut}");
        }
        for at in 0..44 {
            for value in [0, 0xFF] {
                let mut broken = bytes.clone();
                broken[at] = value;
                std::fs::write(&path, &broken).unwrap();
                let _ = read(&path);
            }
        }
    }
}
