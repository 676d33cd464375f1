//! Numbers as bytes.

/// How a number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scalar {
    F64Little,
    F64Big,
    F32Little,
    F32Big,
}

impl Scalar {
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::F64Little | Self::F64Big => 8,
            Self::F32Little | Self::F32Big => 4,
        }
    }

    /// The values of all whole numbers in `bytes`, appended to `out`.
    pub(crate) fn decode(self, bytes: &[u8], out: &mut Vec<f64>) {
        // Where there is no remainder to a chunk, the loop is a copy.
        let (wide, narrow) = (bytes.as_chunks::<8>().0.iter(), bytes.as_chunks::<4>().0.iter());
        match self {
            Self::F64Little => out.extend(wide.map(|&b| f64::from_le_bytes(b))),
            Self::F64Big => out.extend(wide.map(|&b| f64::from_be_bytes(b))),
            Self::F32Little => out.extend(narrow.map(|&b| f64::from(f32::from_le_bytes(b)))),
            Self::F32Big => out.extend(narrow.map(|&b| f64::from(f32::from_be_bytes(b)))),
        }
    }
}
