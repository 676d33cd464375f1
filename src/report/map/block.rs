//! Many poses of a linear map at once, as bytes: CSV, JSON, and NumPy's .npy.

use serde::Serialize;

use crate::map::Block;

/// What parts two rows in JSON.
const PARTING: &str = ",\n";

/// .npy pads its header so that the numbers start at a multiple of this.
const NPY_ALIGNMENT: usize = 64;

/// Poses as [`super::map_csv_rows`] writes them, appended to `out`.
pub fn map_csv_block(block: &Block, out: &mut Vec<u8>) {
    let mut buffer = zmij::Buffer::new();
    for (poses, beta2_rad, frequencies_hz) in rows(block) {
        let mut is_first = true;
        for &value in poses.iter().chain(beta2_rad).chain(frequencies_hz) {
            if !is_first {
                out.push(b',');
            }
            is_first = false;
            out.extend_from_slice(buffer.format(value).as_bytes());
        }
        out.push(b'\n');
    }
}

#[derive(Debug, Serialize)]
struct JsonRow<'a> {
    joints: &'a [f64],
    #[serde(skip_serializing_if = "Option::is_none")]
    beta2_rad: Option<f64>,
    natural_frequencies_hz: &'a [f64],
}

/// Poses as [`super::map_json_rows`] writes them, appended to `out`; every row, the first too, begins with
/// [`map_json_parting`].
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub fn map_json_block(block: &Block, out: &mut Vec<u8>) -> serde_json::Result<()> {
    for (joints, beta2_rad, natural_frequencies_hz) in rows(block) {
        out.extend_from_slice(PARTING.as_bytes());
        let beta2_rad = beta2_rad.first().copied();
        serde_json::to_writer(&mut *out, &JsonRow { joints, beta2_rad, natural_frequencies_hz })?;
    }
    Ok(())
}

/// What parts two rows in JSON.
pub fn map_json_parting() -> &'static str {
    PARTING
}

/// The beginning of a map as .npy, version 1.0: an array of float64 with `poses` rows and a column per mode.
pub fn map_npy_header(poses: usize, modes: usize) -> Vec<u8> {
    let mut header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({poses}, {modes}), }}");
    // Magic, version and length stand before it, a line's end behind it.
    let length = 10 + header.len() + 1;
    let padding = length.next_multiple_of(NPY_ALIGNMENT) - length;
    header.extend(std::iter::repeat_n(' ', padding));
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    // Two numbers of twenty digits do not fill a line of 65535.
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes
}

/// Natural frequencies of poses (Hz, ascending) as rows of that array, appended to `out`.
pub fn map_npy_block(block: &Block, out: &mut Vec<u8>) {
    out.extend(block.frequencies_hz.iter().flat_map(|f| f.to_le_bytes()));
}

/// Joints, β2 (one value or none) and frequencies of each pose.
fn rows<'a>(block: &'a Block) -> impl Iterator<Item = (&'a [f64], &'a [f64], &'a [f64])> {
    let part = |values: &'a [f64]| {
        let width = values.len() / block.count.max(1);
        move |pose: usize| &values[pose * width..(pose + 1) * width]
    };
    let (joints, beta2, frequencies) =
        (part(block.poses), part(block.beta2_rad), part(block.frequencies_hz));
    (0..block.count).map(move |pose| (joints(pose), beta2(pose), frequencies(pose)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Row;
    use crate::report::map::{map_csv_rows, map_json_rows};

    const POSES: [f64; 4] = [0.1, -1e-12, 0.30000000000000004, 1e300];
    const FREQUENCIES: [f64; 6] = [20.5, 88.0, 123456.789, 1e-5, 1.0 / 3.0, 2e16];

    fn block() -> Block<'static> {
        Block { count: 2, poses: &POSES, beta2_rad: &[0.25, -0.5], frequencies_hz: &FREQUENCIES }
    }

    fn row_by_row() -> Vec<Row> {
        (0..2)
            .map(|i| Row {
                joints: POSES[2 * i..2 * i + 2].to_vec(),
                beta2_rad: Some([0.25, -0.5][i]),
                frequencies_hz: FREQUENCIES[3 * i..3 * i + 3].iter().map(|&f| Some(f)).collect(),
                nonlinear: None,
            })
            .collect()
    }

    #[test]
    fn blocks_and_rows_are_written_alike() {
        let (mut bytes, mut text) = (Vec::new(), String::new());
        map_csv_block(&block(), &mut bytes);
        map_csv_rows(&row_by_row(), &mut text);
        assert_eq!(String::from_utf8(bytes).unwrap(), text);
        let read: Vec<f64> = text.split([',', '\n']).filter_map(|v| v.parse().ok()).collect();
        assert_eq!(read[..6], [0.1, -1e-12, 0.25, 20.5, 88.0, 123456.789]);
        assert_eq!(read[6..], [0.30000000000000004, 1e300, -0.5, 1e-5, 1.0 / 3.0, 2e16]);

        let (mut bytes, mut text) = (Vec::new(), String::new());
        map_json_block(&block(), &mut bytes).unwrap();
        map_json_rows(&row_by_row(), false, &mut text).unwrap();
        assert_eq!(String::from_utf8(bytes).unwrap(), text);
    }

    /// `numpy.save(f, numpy.array([[20.5, 88.0, 123456.789], [1e-5, 1/3, 2e16]]))`, NumPy 2.4, byte for byte.
    #[test]
    fn arrays_are_as_numpy_writes_them() {
        let mut bytes = map_npy_header(2, 3);
        map_npy_block(&block(), &mut bytes);
        let expected = include_bytes!("../../../tests/data/npy/frequencies.npy");
        assert_eq!(bytes, expected);
        for poses in [0, 9, 99, 12_345_678, usize::MAX] {
            assert!(map_npy_header(poses, 24).len().is_multiple_of(NPY_ALIGNMENT));
        }
    }
}
