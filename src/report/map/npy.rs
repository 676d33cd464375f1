//! The frequencies of a linear map as NumPy's .npy.

use crate::map::Block;

/// .npy pads its header so that the numbers start at a multiple of this.
const NPY_ALIGNMENT: usize = 64;

/// The beginning of a map as .npy, version 1.0: an array of float64 with `poses` rows and a column
/// per mode.
pub(super) fn header(poses: usize, modes: usize) -> Vec<u8> {
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
pub(super) fn append(block: &Block, out: &mut Vec<u8>) {
    out.extend(block.frequencies_hz.iter().flat_map(|f| f.to_le_bytes()));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `numpy.save(f, numpy.array([[20.5, 88.0, 123456.789], [1e-5, 1/3, 2e16]]))`, NumPy 2.4, byte
    /// for byte.
    #[test]
    fn arrays_are_as_numpy_writes_them() {
        let mut bytes = header(2, 3);
        let frequencies_hz = vec![20.5, 88.0, 123456.789, 1e-5, 1.0 / 3.0, 2e16];
        append(&Block { count: 2, frequencies_hz, ..Block::default() }, &mut bytes);
        let expected = include_bytes!("../../../tests/data/npy/frequencies.npy");
        assert_eq!(bytes, expected);
        for poses in [0, 9, 99, 12_345_678, usize::MAX] {
            assert!(header(poses, 24).len().is_multiple_of(NPY_ALIGNMENT));
        }
    }
}
