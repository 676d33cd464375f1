//! The elements of a .mat of level 5 → its variables.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::super::MAX_RECORD_BYTES;
use crate::notes::Code;

/// Text, place of a subsystem's data, version, order of bytes.
const HEADER_BYTES: usize = 128;

/// Where a file of level 7.3 has its text, and what HDF5 begins with behind it.
const TEXT_OF_7_3: &[u8] = b"MATLAB 7.3";
const HDF5: &[u8] = b"\x89HDF";
const HDF5_BEHIND: usize = 512;

/// Numbers of all variables together, at most: as many as a file of `f64` may hold.
const MAX_VALUES: u64 = MAX_RECORD_BYTES / 8;

/// Types of elements that are no numbers.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// Types of the parts of a variable.
const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;

/// Flags of a variable.
const COMPLEX: u32 = 0x800;
const LOGICAL: u32 = 0x200;

/// A class whose variables have no dimensions, such as MATLAB's tables and strings.
const OPAQUE: u32 = 17;

/// What is told of an array that is no matrix.
pub(super) const DEEP: &str = "more than two dimensions";

type Bad = (Code, String);

/// A variable with its name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Variable {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    /// Column after column.
    Numbers {
        rows: usize,
        columns: usize,
        values: Vec<f64>,
        /// Imaginary parts of complex ones.
        imaginary: Option<Vec<f64>>,
    },
    /// What it is that it is no channel.
    Other(&'static str),
}

fn damaged(what: impl Into<String>) -> Bad {
    (Code::Syntax, what.into())
}

/// All variables that have a name.
pub(super) fn variables(bytes: &[u8]) -> Result<Vec<Variable>, Bad> {
    let is_big = is_big_endian(bytes)?;
    let mut top = Elements { bytes, at: HEADER_BYTES, is_big };
    let mut found: Vec<Variable> = Vec::new();
    let (mut left_bytes, mut left_values) = (MAX_RECORD_BYTES, MAX_VALUES);
    while let Some((kind, data)) = top.next()? {
        let unpacked;
        let variable = match kind {
            MATRIX => variable(data, is_big, &mut left_values)?,
            COMPRESSED => {
                unpacked = inflated(data, &mut left_bytes)?;
                let mut inner = Elements { bytes: &unpacked, at: 0, is_big };
                match inner.next()? {
                    Some((MATRIX, data)) => variable(data, is_big, &mut left_values)?,
                    _ => continue,
                }
            }
            _ => continue,
        };
        // A part of the file that belongs to objects has no name.
        if !variable.name.is_empty() {
            found.push(variable);
        }
    }
    Ok(found)
}

/// Whether the file is in the order of bytes of other machines; a fault where it is none of level
/// 5.
fn is_big_endian(bytes: &[u8]) -> Result<bool, Bad> {
    let is_hdf5 = [0, HDF5_BEHIND]
        .iter()
        .any(|at| bytes.get(*at..).is_some_and(|rest| rest.starts_with(HDF5)));
    if is_hdf5 || bytes.starts_with(TEXT_OF_7_3) {
        let what = "is a .mat of version 7.3 (HDF5), which is not read; save it in MATLAB with \
                    save -v7";
        return Err((Code::Unreadable, what.to_owned()));
    }
    // Four bytes of text, where level 4 has a small number.
    if bytes.iter().take(4).any(|byte| *byte == 0) {
        let what = "is no .mat of version 5 to 7, or one of version 4; save it in MATLAB with \
                    save -v7";
        return Err((Code::Unreadable, what.to_owned()));
    }
    match bytes.get(HEADER_BYTES - 4..HEADER_BYTES) {
        Some([0, 1, b'I', b'M']) => Ok(false),
        Some([1, 0, b'M', b'I']) => Ok(true),
        Some(_) => Err(damaged("is no .mat of version 5 to 7")),
        None => Err(damaged(format!("ends within the {HEADER_BYTES} bytes of its header"))),
    }
}

/// The bytes of a compressed element, as far as the file may still unpack.
fn inflated(data: &[u8], left: &mut u64) -> Result<Vec<u8>, Bad> {
    let mut unpacked = Vec::new();
    let read = ZlibDecoder::new(data).take(*left + 1).read_to_end(&mut unpacked);
    read.map_err(|error| damaged(format!("holds a compressed variable that is damaged: {error}")))?;
    *left = left.checked_sub(unpacked.len() as u64).ok_or_else(|| {
        let what = format!("unpacks to more than {} MiB, the limit", MAX_RECORD_BYTES >> 20);
        (Code::TooLong, what)
    })?;
    Ok(unpacked)
}

/// Elements that follow each other: each has a type and its bytes.
struct Elements<'b> {
    bytes: &'b [u8],
    at: usize,
    is_big: bool,
}

impl<'b> Elements<'b> {
    fn u32_at(&self, at: usize) -> Option<u32> {
        let bytes = self.bytes.get(at..)?.first_chunk::<4>()?;
        Some(if self.is_big { u32::from_be_bytes(*bytes) } else { u32::from_le_bytes(*bytes) })
    }

    /// The next one; `None` at the end.
    fn next(&mut self) -> Result<Option<(u32, &'b [u8])>, Bad> {
        if self.at >= self.bytes.len() {
            return Ok(None);
        }
        let cut = || damaged("is cut off within a variable, or damaged");
        let first = self.u32_at(self.at).ok_or_else(cut)?;
        // Up to four bytes stand in place of their own length.
        let (kind, start, length) = match first >> 16 {
            0 => (first, self.at + 8, self.u32_at(self.at + 4).ok_or_else(cut)? as usize),
            length => (first & 0xFFFF, self.at + 4, (length as usize).min(4)),
        };
        let end = start.checked_add(length).ok_or_else(cut)?;
        let data = self.bytes.get(start..end).ok_or_else(cut)?;
        self.at = if kind == COMPRESSED { end } else { end.next_multiple_of(8) };
        Ok(Some((kind, data)))
    }

    /// The next one, which must be of this type.
    fn part(&mut self, kind: u32) -> Result<&'b [u8], Bad> {
        match self.next()? {
            Some((found, data)) if found == kind => Ok(data),
            _ => Err(damaged("holds a variable that is damaged")),
        }
    }
}

fn variable(data: &[u8], is_big: bool, left_values: &mut u64) -> Result<Variable, Bad> {
    let mut parts = Elements { bytes: data, at: 0, is_big };
    if data.is_empty() {
        return Ok(Variable { name: String::new(), kind: Kind::Other("empty") });
    }
    let flags = parts.part(UINT32)?;
    let flags = Elements { bytes: flags, at: 0, is_big }.u32_at(0).unwrap_or(0);
    let class = flags & 0xFF;
    let dimensions = if class == OPAQUE { &[][..] } else { parts.part(INT32)? };
    let name = String::from_utf8_lossy(parts.part(INT8)?).into_owned();
    let other = match class {
        1 => Some("cells"),
        2 => Some("a structure"),
        4 => Some("text"),
        5 => Some("sparse"),
        6..=15 if flags & LOGICAL != 0 => Some("logical"),
        6..=15 => None,
        _ => Some("an object"),
    };
    if let Some(other) = other {
        return Ok(Variable { name, kind: Kind::Other(other) });
    }
    let lengths: Vec<u32> = Numbers { kind: INT32, is_big }
        .decode(dimensions)
        .unwrap_or_default()
        .into_iter()
        .map(|length| if length >= 0.0 { length as u32 } else { 0 })
        .collect();
    let &[rows, columns, ref more @ ..] = lengths.as_slice() else {
        return Err(damaged(format!("variable '{name}' has no dimensions")));
    };
    if more.iter().any(|length| *length != 1) {
        return Ok(Variable { name, kind: Kind::Other(DEEP) });
    }
    let (rows, columns) = (rows as usize, columns as usize);
    let stated = rows as u64 * columns as u64;
    let unlike = |held: usize| {
        damaged(format!("variable '{name}' states {rows} × {columns} values, but holds {held}"))
    };
    // An empty variable may end here.
    let Some((kind, numbers)) = parts.next()? else {
        let kind = Kind::Numbers { rows, columns, values: Vec::new(), imaginary: None };
        return if stated == 0 { Ok(Variable { name, kind }) } else { Err(unlike(0)) };
    };
    let mut decoded = |kind: u32, numbers: &[u8]| {
        let numbers_of = Numbers { kind, is_big };
        let held = numbers_of.size().map(|size| numbers.len() / size);
        let held = held.ok_or_else(|| damaged(format!("variable '{name}' holds no numbers")))?;
        if held as u64 != stated {
            return Err(unlike(held));
        }
        *left_values = left_values.checked_sub(stated).ok_or_else(|| {
            (Code::TooLong, format!("holds more than {MAX_VALUES} numbers; divide the file"))
        })?;
        Ok(numbers_of.decode(numbers).unwrap_or_default())
    };
    let values = decoded(kind, numbers)?;
    let imaginary = match flags & COMPLEX {
        0 => None,
        _ => {
            let (kind, numbers) = parts.next()?.ok_or_else(|| unlike(0))?;
            Some(decoded(kind, numbers)?)
        }
    };
    Ok(Variable { name, kind: Kind::Numbers { rows, columns, values, imaginary } })
}

/// How numbers are stored.
struct Numbers {
    kind: u32,
    is_big: bool,
}

impl Numbers {
    /// Bytes of a number; `None` for what is no number.
    fn size(&self) -> Option<usize> {
        match self.kind {
            INT8 | 2 => Some(1),
            3 | 4 => Some(2),
            INT32 | UINT32 | 7 => Some(4),
            9 | 12 | 13 => Some(8),
            _ => None,
        }
    }

    fn decode(&self, bytes: &[u8]) -> Option<Vec<f64>> {
        let size = self.size()?;
        let one = |chunk: &[u8]| {
            let mut little = [0; 8];
            for (to, from) in little.iter_mut().zip(0..size) {
                *to = chunk[if self.is_big { size - 1 - from } else { from }];
            }
            let bits = u64::from_le_bytes(little);
            match self.kind {
                INT8 => f64::from(bits as i8),
                3 => f64::from(bits as i16),
                INT32 => f64::from(bits as i32),
                7 => f64::from(f32::from_bits(bits as u32)),
                9 => f64::from_bits(bits),
                12 => bits as i64 as f64,
                _ => bits as f64,
            }
        };
        Some(bytes.chunks_exact(size).map(one).collect())
    }
}
