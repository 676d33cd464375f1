//! Poses as NumPy's .npy, versions 1 to 3 of the format: an array of one row a pose and one column
//! a joint, `float64` or `float32` in either order of bytes, row after row or (from a file) column
//! after column.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use super::{DecodedPoses, MAX_ERRORS};

/// What every .npy begins with.
pub(super) const MAGIC: &[u8] = b"\x93NUMPY";

/// Headers longer than this are no headers of an array of numbers.
const MAX_HEADER_BYTES: u64 = 1 << 16;

/// How a number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    F64Little,
    F64Big,
    F32Little,
    F32Big,
}

impl Scalar {
    fn bytes(self) -> usize {
        match self {
            Self::F64Little | Self::F64Big => 8,
            Self::F32Little | Self::F32Big => 4,
        }
    }
}

/// What the header of an array says.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    scalar: Scalar,
    is_by_column: bool,
    pub(super) rows: usize,
    joints: Vec<String>,
}

impl Layout {
    /// Reads what follows the magic bytes; `joints` are the columns that the array must have.
    pub(super) fn read(reader: &mut impl Read, joints: Vec<String>) -> Result<(Self, u64), String> {
        let cut = |error: io::Error| match error.kind() {
            io::ErrorKind::UnexpectedEof => "ends within its header".to_owned(),
            _ => format!("cannot be read: {error}"),
        };
        let mut version = [0; 2];
        reader.read_exact(&mut version).map_err(cut)?;
        let (length, length_bytes) = match version[0] {
            1 => {
                let mut bytes = [0; 2];
                reader.read_exact(&mut bytes).map_err(cut)?;
                (u64::from(u16::from_le_bytes(bytes)), 2)
            }
            2 | 3 => {
                let mut bytes = [0; 4];
                reader.read_exact(&mut bytes).map_err(cut)?;
                (u64::from(u32::from_le_bytes(bytes)), 4)
            }
            other => return Err(format!("is .npy of version {other}, must be 1, 2 or 3")),
        };
        if length > MAX_HEADER_BYTES {
            return Err(format!(
                "has a header of {length} bytes, must be an array of float64 or float32"
            ));
        }
        let mut header = vec![0; length as usize];
        reader.read_exact(&mut header).map_err(cut)?;
        let header = String::from_utf8_lossy(&header);
        let start = MAGIC.len() as u64 + 2 + length_bytes + length;
        Ok((Self::parse(&header, joints)?, start))
    }

    fn parse(header: &str, joints: Vec<String>) -> Result<Self, String> {
        let broken = |key: &str| format!("has a header without a valid '{key}': {header:.80}");
        let descr = after(header, "descr").ok_or_else(|| broken("descr"))?;
        let name = quoted(descr).unwrap_or("a structure");
        let scalar = match name {
            "<f8" => Scalar::F64Little,
            ">f8" => Scalar::F64Big,
            "<f4" => Scalar::F32Little,
            ">f4" => Scalar::F32Big,
            other => {
                return Err(format!(
                    "has dtype '{other}', must be float64 or float32; save it with \
                     .astype(numpy.float64)"
                ));
            }
        };
        let order = after(header, "fortran_order").ok_or_else(|| broken("fortran_order"))?;
        let is_by_column = match (order.starts_with("True"), order.starts_with("False")) {
            (true, false) => true,
            (false, true) => false,
            _ => return Err(broken("fortran_order")),
        };
        let shape = after(header, "shape")
            .and_then(|text| text.strip_prefix('('))
            .and_then(|text| Some(&text[..text.find(')')?]))
            .ok_or_else(|| broken("shape"))?;
        let lengths: Vec<usize> = shape
            .split(',')
            .map(str::trim)
            .filter(|text| !text.is_empty())
            .map(|text| text.trim_end_matches('L').parse().map_err(|_| broken("shape")))
            .collect::<Result<_, _>>()?;
        let rows = match lengths.as_slice() {
            [rows, columns] if *columns == joints.len() => *rows,
            [rows] if joints.len() == 1 => *rows,
            _ => {
                return Err(format!(
                    "has shape ({shape}), must be (poses, {}), one column per moving joint in this \
                     order: {}",
                    joints.len(),
                    joints.join(", ")
                ));
            }
        };
        // Places in the file are counted in bytes.
        if rows.checked_mul(joints.len()).and_then(|n| n.checked_mul(scalar.bytes())).is_none() {
            return Err(format!("has shape ({shape}), more than any file holds"));
        }
        Ok(Self { scalar, is_by_column: is_by_column && joints.len() > 1, rows, joints })
    }

    /// Finite values of `bytes`, as [`Rows::take`] gave them.
    pub(super) fn decode(&self, rows: usize, bytes: &[u8], out: &mut DecodedPoses) {
        match self.scalar {
            Scalar::F64Little => self.values(rows, bytes, out, f64::from_le_bytes),
            Scalar::F64Big => self.values(rows, bytes, out, f64::from_be_bytes),
            Scalar::F32Little => self.values(rows, bytes, out, |b| f32::from_le_bytes(b).into()),
            Scalar::F32Big => self.values(rows, bytes, out, |b| f32::from_be_bytes(b).into()),
        }
        out.count = rows;
        out.places = rows;
        if out.values.iter().all(|value| value.is_finite()) {
            return;
        }
        let joints = self.joints.len();
        let bad = out.values.iter().enumerate().filter(|(_, value)| !value.is_finite());
        out.faults.extend(bad.take(MAX_ERRORS).map(|(i, value)| {
            (i / joints, format!("{} is {value}, must be a finite number", self.joints[i % joints]))
        }));
    }

    fn values<const N: usize>(
        &self,
        rows: usize,
        bytes: &[u8],
        out: &mut DecodedPoses,
        value: impl Fn([u8; N]) -> f64,
    ) {
        // Where there is no remainder to a chunk, the loop is a copy.
        let values = bytes.as_chunks::<N>().0.iter().map(|&b| value(b));
        if self.is_by_column {
            let joints = self.joints.len();
            out.values.resize(rows * joints, 0.0);
            for (i, value) in values.enumerate() {
                out.values[i % rows * joints + i / rows] = value;
            }
        } else {
            out.values.extend(values);
        }
    }
}

/// The text after a key of a Python dictionary.
fn after<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let at = [format!("'{key}'"), format!("\"{key}\"")]
        .iter()
        .find_map(|key| Some(header.find(key.as_str())? + key.len()))?;
    Some(header[at..].trim_start().strip_prefix(':')?.trim_start())
}

fn quoted(text: &str) -> Option<&str> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    let rest = &text[1..];
    Some(&rest[..rest.find(quote)?])
}

/// The rows of an array as they are read.
pub(super) struct Rows<R> {
    pub(super) layout: Layout,
    reader: R,
    /// Where column after column can be picked up, and where the numbers start.
    file: Option<File>,
    start: u64,
    done: usize,
}

impl<R: Read> Rows<R> {
    pub(super) fn new(
        layout: Layout,
        start: u64,
        reader: R,
        file: Option<File>,
    ) -> Result<Self, String> {
        let file = if layout.is_by_column {
            // A pipe cannot be wound back.
            let file = file.filter(|mut file| file.stream_position().is_ok());
            Some(file.ok_or(
                "is stored in column-major order (fortran_order), which cannot be streamed; save it \
                 with numpy.ascontiguousarray",
            )?)
        } else {
            None
        };
        Ok(Self { layout, reader, file, start, done: 0 })
    }

    /// Takes up to `most` rows as they stand into `bytes`, in place of what it holds; gives how
    /// many. A piece of an array stored by columns is stored by columns.
    pub(super) fn take(&mut self, most: usize, bytes: &mut Vec<u8>) -> Result<usize, String> {
        bytes.clear();
        let all = self.layout.rows;
        let rows = most.min(all - self.done);
        let (joints, size) = (self.layout.joints.len(), self.layout.scalar.bytes());
        let columns = if self.layout.is_by_column { joints } else { 1 };
        let wanted = rows * joints * size / columns;
        for column in 0..columns {
            let read = match &mut self.file {
                Some(file) => {
                    let place = (column as u64 * all as u64 + self.done as u64) * size as u64;
                    file.seek(SeekFrom::Start(self.start + place))
                        .and_then(|_| file.take(wanted as u64).read_to_end(bytes))
                }
                None => self.reader.by_ref().take(wanted as u64).read_to_end(bytes),
            };
            let read = read.map_err(|error| format!("cannot be read: {error}"))?;
            if read < wanted {
                let whole = self.done + if columns == 1 { read / (joints * size) } else { 0 };
                return Err(format!(
                    "is cut off: its header promises {all} rows, and it ends within row {}",
                    whole + 1
                ));
            }
        }
        self.done += rows;
        Ok(rows)
    }
}
