//! Files that SciPy wrote (`tests/data/mat/make.py`), and damaged ones.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use nalgebra::Complex;

use super::*;

const PLAIN: &[u8] = include_bytes!("../../../../tests/data/mat/plain.mat");
const COMPRESSED: &[u8] = include_bytes!("../../../../tests/data/mat/compressed.mat");
const RATE: &[u8] = include_bytes!("../../../../tests/data/mat/rate.mat");
const CLOCK: &[u8] = include_bytes!("../../../../tests/data/mat/clock.mat");
const LEVEL_4: &[u8] = include_bytes!("../../../../tests/data/mat/level_4.mat");
const STRUCTURE: &[u8] = include_bytes!("../../../../tests/data/mat/structure.mat");
const NOT_FINITE: &[u8] = include_bytes!("../../../../tests/data/mat/not_finite.mat");
const STEP: &[u8] = include_bytes!("../../../../tests/data/mat/step.mat");
const RESPONSES: &[u8] = include_bytes!("../../../../tests/data/mat/responses.mat");
const FEW_LINES: &[u8] = include_bytes!("../../../../tests/data/mat/few_lines.mat");

fn told(bytes: &[u8], time: Option<&str>) -> Result<Recording, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mat");
    std::fs::write(&path, bytes).unwrap();
    read(&path, time).map_err(|notes| notes[0].what.clone())
}

/// A variable of class `class` with numbers of type 9 (`f64`), in the order of bytes of other
/// machines where `big`.
fn matrix(class: u32, dimensions: &[u32], values: &[f64], big: bool) -> Vec<u8> {
    let word = |value: u32| if big { value.to_be_bytes() } else { value.to_le_bytes() };
    let words = |values: &[u32]| values.iter().flat_map(|value| word(*value)).collect::<Vec<_>>();
    let mut body = words(&[6, 8, class, 0, 5, 4 * dimensions.len() as u32]);
    body.extend(words(dimensions));
    body.resize(body.len().next_multiple_of(8), 0);
    body.extend(words(&[(1 << 16) | 1]));
    body.extend(b"y\0\0\0");
    body.extend(words(&[9, 8 * values.len() as u32]));
    body.extend(values.iter().flat_map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() }));
    [words(&[14, body.len() as u32]), body].concat()
}

fn file(elements: &[u8], big: bool) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend(if big { b"\x01\0MI" } else { b"\0\x01IM" });
    bytes.extend(elements);
    bytes
}

fn packed(element: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(element).unwrap();
    let data = encoder.finish().unwrap();
    [15_u32.to_le_bytes().to_vec(), (data.len() as u32).to_le_bytes().to_vec(), data].concat()
}

#[test]
fn vectors_and_columns_are_channels_packed_or_not() {
    for bytes in [PLAIN, COMPRESSED] {
        let found = told(bytes, None).unwrap();
        let names: Vec<_> = found
            .channels
            .iter()
            .map(|c| (c.label.name.as_str(), c.label.alias.as_str(), c.samples[3]))
            .collect();
        let expected = [
            ("x_mm", "x_mm", 1.5),
            ("acc_1", "acc", 3.0),
            ("acc_2", "acc", -3.0),
            ("acc_3", "acc", 9.0),
            ("hammer_n", "hammer_n", 0.75),
        ];
        assert_eq!(names, expected);
        assert!(found.channels.iter().all(|channel| channel.samples.len() == 16));
        assert_eq!((found.sample_rate_hz, found.time.as_deref()), (Some(128.0), Some("t")));
        let what = &found.warnings[0].what;
        for other in [
            "mass_kg (a single value)",
            "is_on (logical)",
            "spectrum (complex)",
            "wide (2 × 16, must be samples × channels; save it transposed)",
            "note (text)",
            "rig (a structure)",
            "cells (cells)",
            "shaker (4 samples, not 16)",
        ] {
            assert!(what.contains(other), "{other}: {what}");
        }
    }
}

#[test]
fn time_is_named_by_the_session_or_stands_as_a_rate() {
    let found = told(RATE, None).unwrap();
    assert_eq!((found.sample_rate_hz, found.channels.len()), (Some(128.0), 1));
    assert_eq!(found.channels[0].samples[15], 15.0);
    let found = told(STEP, None).unwrap();
    assert_eq!((found.sample_rate_hz, found.channels.len()), (Some(128.0), 1));
    let found = told(CLOCK, Some("stamp_ms")).unwrap();
    assert_eq!((found.sample_rate_hz, found.channels.len()), (Some(200.0), 1));
    let found = told(CLOCK, None).unwrap();
    assert_eq!((found.sample_rate_hz, found.channels.len()), (None, 2));
}

/// A mode of 12 Hz: (12² − f² + 2i·0.02·12·f)⁻¹ at 12 Hz is 1/(5.76i).
#[test]
fn complex_variables_beside_frequencies_are_responses() {
    let found = told(RESPONSES, None).unwrap();
    let names = found.functions.iter().map(|f| (f.label.name.as_str(), f.values[24]));
    let at = |re: f64, im: f64| Complex::new(re, im) / 5.76;
    let expected = [
        ("tip", at(0.0, -1.0)),
        ("H_1", at(0.0, -0.5)),
        ("H_2", at(-2.0, 0.0)),
        ("elbow", at(0.0, -1.0)),
    ];
    for ((name, value), (own, expected)) in names.clone().zip(expected) {
        assert_eq!(name, own);
        assert!((value - expected).norm() < 1e-12, "{name}: {value}");
    }
    assert_eq!((names.count(), found.channels.len()), (4, 0));
    assert!(found.functions.iter().all(|f| f.frequencies_hz.len() == 64));
    assert_eq!(found.functions[0].frequencies_hz[24], 12.0);
    let told: String = found.warnings.iter().map(|note| format!("{}\n", note.what)).collect();
    for other in [
        "'coh_tip' is no part of a frequency response",
        "wide (2 × 64, must be lines × responses",
        "window (7 values, not 64)",
    ] {
        assert!(told.contains(other), "{other}: {told}");
    }
}

#[test]
fn either_order_of_bytes_is_read() {
    let values: Vec<f64> = (0..20).map(f64::from).collect();
    for big in [false, true] {
        let found = told(&file(&matrix(6, &[10, 2], &values, big), big), None).unwrap();
        assert_eq!((found.channels.len(), found.channels[1].samples[3]), (2, 13.0));
    }
}

#[test]
fn what_is_no_record_is_a_fault_in_words() {
    let values: Vec<f64> = (0..20).map(f64::from).collect();
    let mut hdf5 = file(&[0; 384], false);
    hdf5.extend(b"\x89HDF\r\n\x1a\n");
    let of = |dimensions: &[u32]| file(&matrix(6, dimensions, &values, false), false);
    let twice = [matrix(6, &[20, 1], &values, false), matrix(6, &[1, 20], &values, false)].concat();
    for (bytes, expected) in [
        (hdf5, "is a .mat of version 7.3 (HDF5), which is not read; save it in MATLAB with save"),
        (b"MATLAB 7.3 MAT-file, Platform".to_vec(), "of version 7.3 (HDF5)"),
        (LEVEL_4.to_vec(), "or one of version 4; save it in MATLAB with save -v7"),
        (Vec::new(), "ends within the 128 bytes of its header"),
        (vec![b'x'; 200], "is no .mat of version 5 to 7"),
        (file(&[], false), "holds no variable that is a channel"),
        (STRUCTURE.to_vec(), "a channel, but rig (a structure); save vectors of numbers"),
        (NOT_FINITE.to_vec(), "y: sample 4 is not finite"),
        (FEW_LINES.to_vec(), "has 4 lines, must have at least 8"),
        (of(&[10, 3]), "variable 'y' states 10 × 3 values, but holds 20"),
        (of(&[u32::MAX / 2, u32::MAX / 2]), "states 2147483647 × 2147483647 values"),
        (of(&[u32::MAX, 20]), "states 0 × 20 values, but holds 20"),
        (of(&[20]), "variable 'y' has no dimensions"),
        (of(&[20, 1, 5]), "y (more than two dimensions)"),
        (file(&matrix(6, &[4, 1], &values[..4], false), false), "has 4 samples, must have"),
        (file(&twice, false), "two channels are called 'y'"),
        (file(&[15, 0, 0, 0, 4, 0, 0, 0, 1, 2, 3, 4], false), "compressed variable that is"),
    ] {
        let told = told(&bytes, None).unwrap_err();
        assert!(told.contains(expected), "{expected}: {told}");
    }
}

/// Responses over several references in one array, as MATLAB keeps them, beside their frequencies.
#[test]
fn responses_in_an_array_of_three_dimensions_are_told_as_such() {
    let values: Vec<f64> = (0..120).map(f64::from).collect();
    let named = |name: u8, dimensions: &[u32], values: &[f64]| {
        let mut own = matrix(6, dimensions, values, false);
        let at = own.windows(4).position(|word| word == b"y\0\0\0").unwrap();
        own[at] = name;
        own
    };
    let both = [named(b'f', &[20, 1], &values[..20]), named(b'H', &[20, 3, 2], &values)].concat();
    let told = told(&file(&both, false), None).unwrap_err();
    assert!(told.contains("H (more than two dimensions), must be lines × responses"), "{told}");
}

/// Cut off anywhere but between two variables, the file is refused; with any byte changed, nothing
/// but a fault or a record comes of it.
#[test]
fn damaged_files_never_panic() {
    let whole = file(&matrix(6, &[20, 1], &[1.0; 20], false), false);
    for cut in 0..whole.len() {
        assert!(told(&whole[..cut], None).is_err(), "{cut}");
    }
    for bytes in [PLAIN, COMPRESSED, RESPONSES] {
        for cut in 0..bytes.len() {
            let _ = variables(&bytes[..cut]);
        }
        for at in 0..bytes.len() {
            for value in [0, 1, 0x7F, 0xFF] {
                let mut broken = bytes.to_vec();
                broken[at] = value;
                let found = variables(&broken).unwrap_or_default();
                let _ = recording(found, None, &mut Notes::about(Place::default()));
            }
        }
    }
}

/// 64 KiB that unpack to zeros without end are refused before they fill the memory.
#[test]
fn what_unpacks_beyond_the_limit_is_refused() {
    let bomb = packed(&vec![0; 48 << 20]);
    assert!(bomb.len() < 64 << 10);
    let many: Vec<u8> = std::iter::repeat_n(bomb, 11).flatten().collect();
    let told = told(&file(&many, false), None).unwrap_err();
    assert!(told.contains("unpacks to more than 512 MiB"), "{told}");
}
