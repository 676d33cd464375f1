//! NumPy's .npy, versions 1 to 3 of the format: arrays of rows and columns, `float64` or `float32`
//! in either order of bytes, row after row or (from a file) column after column.
//!
//! Not by the crate npyz 0.9: a thousand `[` in a header keep its parser busy for more than twenty
//! seconds, a shape beyond 2⁶⁴ overflows, and rows cannot be taken as bytes for other threads.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use super::scalar::Scalar;

/// What every .npy begins with.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// A header is padded so that the numbers start at a multiple of this.
const ALIGNMENT: usize = 64;

/// What the header of an array says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layout {
    scalar: Scalar,
    is_by_column: bool,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    /// Where the numbers start.
    start: u64,
}

impl Layout {
    /// `float64`, row after row.
    pub(crate) fn of_rows(rows: usize, columns: usize) -> Self {
        Self { scalar: Scalar::F64Little, is_by_column: false, rows, columns, start: 0 }
    }

    /// The bytes before the rows of an array [`Self::of_rows`], as NumPy writes them, version 1.0.
    pub(crate) fn header(&self) -> Vec<u8> {
        let Self { rows, columns, .. } = self;
        let mut header =
            format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
        // Magic, version and length stand before it, a line's end behind it.
        let length = 10 + header.len() + 1;
        let padding = length.next_multiple_of(ALIGNMENT) - length;
        header.extend(std::iter::repeat_n(' ', padding));
        header.push('\n');
        // Two numbers of twenty digits do not fill a line of 65535.
        let length = (header.len() as u16).to_le_bytes();
        [MAGIC, &[1, 0], &length, header.as_bytes()].concat()
    }

    /// Reads what follows the magic bytes. An array of other than `columns` columns is refused,
    /// where they are given; `expected` is what its shape must be.
    pub(crate) fn read(
        reader: &mut impl Read,
        columns: Option<usize>,
        expected: &str,
    ) -> Result<Self, String> {
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
        // Longer ones are no headers of an array of numbers.
        if length > 1 << 16 {
            return Err(format!(
                "has a header of {length} bytes, must be an array of float64 or float32"
            ));
        }
        let mut header = vec![0; length as usize];
        reader.read_exact(&mut header).map_err(cut)?;
        let header = String::from_utf8_lossy(&header);
        let start = MAGIC.len() as u64 + 2 + length_bytes + length;
        Self::parse(&header, start, columns, expected)
    }

    fn parse(
        header: &str,
        start: u64,
        columns: Option<usize>,
        expected: &str,
    ) -> Result<Self, String> {
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
        let is_asked = |found| columns.is_none_or(|columns| columns == found);
        let (rows, columns) = match lengths.as_slice() {
            [rows, found] if is_asked(*found) => (*rows, *found),
            [rows] if is_asked(1) => (*rows, 1),
            _ => return Err(format!("has shape ({shape}), must be {expected}")),
        };
        // Places in the file are counted in bytes.
        if rows.checked_mul(columns).and_then(|n| n.checked_mul(scalar.bytes())).is_none() {
            return Err(format!("has shape ({shape}), more than any file holds"));
        }
        Ok(Self { scalar, is_by_column: is_by_column && columns > 1, rows, columns, start })
    }

    /// The columns of the array, of which `bytes` are the numbers.
    pub(crate) fn columns_in(&self, bytes: &[u8]) -> Result<Vec<Vec<f64>>, String> {
        let row = self.columns * self.scalar.bytes();
        let wanted = self.rows * row;
        let Some(numbers) = bytes.get(..wanted) else {
            let whole = if self.is_by_column { 0 } else { bytes.len() / row };
            return Err(self.cut_off_after(whole));
        };
        let mut values = Vec::new();
        self.decode(self.rows, numbers, &mut values);
        let column = |at| values.iter().skip(at).step_by(self.columns).copied().collect();
        Ok((0..self.columns).map(column).collect())
    }

    fn cut_off_after(&self, rows: usize) -> String {
        let (all, row) = (self.rows, rows + 1);
        format!("is cut off: its header states {all} rows, but it ends within row {row}")
    }

    /// The values of `rows` rows, as [`Rows::take`] gave their `bytes`, row after row in place of
    /// what `out` holds.
    pub(crate) fn decode(&self, rows: usize, bytes: &[u8], out: &mut Vec<f64>) {
        out.clear();
        if !self.is_by_column {
            return self.scalar.decode(bytes, out);
        }
        let mut stored = Vec::new();
        self.scalar.decode(bytes, &mut stored);
        out.resize(rows * self.columns, 0.0);
        for (i, value) in stored.into_iter().enumerate() {
            out[i % rows * self.columns + i / rows] = value;
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
pub(crate) struct Rows<R> {
    pub(crate) layout: Layout,
    reader: R,
    /// Where column after column can be picked up.
    file: Option<File>,
    done: usize,
}

impl<R: Read> Rows<R> {
    /// `reader` stands at the first number; `file` is the same file, if it is one.
    pub(crate) fn new(layout: Layout, reader: R, file: Option<File>) -> Result<Self, String> {
        let file = if layout.is_by_column {
            // A pipe cannot be wound back.
            let file = file.filter(|mut file| file.stream_position().is_ok());
            Some(file.ok_or(
                "is stored in column-major order (fortran_order), which cannot be streamed; save \
                 it with numpy.ascontiguousarray",
            )?)
        } else {
            None
        };
        Ok(Self { layout, reader, file, done: 0 })
    }

    /// Takes up to `most` rows as they stand into `bytes`, in place of what it holds; gives how
    /// many. A piece of an array stored by columns is stored by columns.
    pub(crate) fn take(&mut self, most: usize, bytes: &mut Vec<u8>) -> Result<usize, String> {
        bytes.clear();
        let Layout { rows: all, columns, start, is_by_column, .. } = self.layout;
        let (rows, size) = (most.min(all - self.done), self.layout.scalar.bytes());
        let pieces = if is_by_column { columns } else { 1 };
        let wanted = rows * columns * size / pieces;
        for piece in 0..pieces {
            let read = match &mut self.file {
                Some(file) => {
                    let place = (piece as u64 * all as u64 + self.done as u64) * size as u64;
                    file.seek(SeekFrom::Start(start + place))
                        .and_then(|_| file.take(wanted as u64).read_to_end(bytes))
                }
                None => self.reader.by_ref().take(wanted as u64).read_to_end(bytes),
            };
            let read = read.map_err(|error| format!("cannot be read: {error}"))?;
            if read < wanted {
                let whole = self.done + if is_by_column { 0 } else { read / (columns * size) };
                return Err(self.layout.cut_off_after(whole));
            }
        }
        self.done += rows;
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `numpy.save(f, numpy.array([[20.5, 88.0, 123456.789], [1e-5, 1/3, 2e16]]))`, NumPy 2.4, byte
    /// for byte.
    #[test]
    fn arrays_are_as_numpy_writes_them_and_read_again() {
        let values = [20.5_f64, 88.0, 123456.789, 1e-5, 1.0 / 3.0, 2e16];
        let mut bytes = Layout::of_rows(2, 3).header();
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        let expected = include_bytes!("../../tests/data/npy/frequencies.npy");
        assert_eq!(bytes, expected);
        for rows in [0, 9, 99, 12_345_678, usize::MAX] {
            assert!(Layout::of_rows(rows, 24).header().len().is_multiple_of(ALIGNMENT));
        }
        let mut reader = &bytes[MAGIC.len()..];
        let layout = Layout::read(&mut reader, Some(3), "").unwrap();
        let mut rows = Rows::new(layout.clone(), reader, None).unwrap();
        let (mut raw, mut read) = (Vec::new(), Vec::new());
        assert_eq!(rows.take(9, &mut raw), Ok(2));
        layout.decode(2, &raw, &mut read);
        assert_eq!(read, values);
    }
}
