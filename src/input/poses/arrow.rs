//! Poses as Apache Arrow: a stream or a file (Feather) of record batches, one column a joint, found
//! by its title.

use std::fs::File;
use std::io::{BufReader, Read, Seek};

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type};
use arrow_array::{Array, RecordBatch};
use arrow_ipc::reader::{FileReader, StreamReader};
use arrow_schema::{ArrowError, DataType, SchemaRef};

use super::DecodedPoses;
use super::csv::Columns;

enum Reader<R> {
    Stream(StreamReader<R>),
    File(FileReader<BufReader<File>>),
}

/// Record batches as they are read, cut to size.
pub(super) struct Batches<R> {
    reader: Reader<R>,
    schema: SchemaRef,
    rest: Option<RecordBatch>,
}

impl<R: Read> Batches<R> {
    /// A stream, from its first byte on.
    pub(super) fn stream(reader: R) -> Result<Self, String> {
        let reader = StreamReader::try_new(reader, None).map_err(|e| unreadable(&e))?;
        let schema = reader.schema();
        Ok(Self { reader: Reader::Stream(reader), schema, rest: None })
    }

    /// A file, whose table of contents stands at its end.
    pub(super) fn file(file: Option<File>) -> Result<Self, String> {
        // A pipe cannot be wound back.
        let file = file.and_then(|mut file| file.rewind().is_ok().then_some(file)).ok_or(
            "is an Arrow file, which cannot be read from a pipe; write an Arrow stream into it",
        )?;
        let reader = FileReader::try_new(BufReader::new(file), None).map_err(|e| unreadable(&e))?;
        let schema = reader.schema();
        Ok(Self { reader: Reader::File(reader), schema, rest: None })
    }

    /// Titles of the columns.
    pub(super) fn titles(&self) -> Vec<String> {
        self.schema.fields().iter().map(|field| field.name().clone()).collect()
    }

    /// What keeps the joints' columns from being read, one line a column.
    pub(super) fn faults(&self, columns: &Columns) -> Vec<String> {
        let fields = columns.places().map(|(index, _)| self.schema.field(index));
        fields
            .filter(|field| !matches!(field.data_type(), DataType::Float64 | DataType::Float32))
            .map(|field| {
                format!("{} is {}, must be float64 or float32", field.name(), field.data_type())
            })
            .collect()
    }

    /// Up to `most` rows; `None` at the end.
    pub(super) fn take(&mut self, most: usize) -> Result<Option<RecordBatch>, String> {
        let mut batch = match self.rest.take() {
            Some(rest) => rest,
            None => loop {
                let next = match &mut self.reader {
                    Reader::Stream(stream) => stream.next(),
                    Reader::File(file) => file.next(),
                };
                match next.transpose().map_err(|e| unreadable(&e))? {
                    None => return Ok(None),
                    Some(batch) if batch.num_rows() > 0 => break batch,
                    Some(_) => {}
                }
            },
        };
        if batch.num_rows() > most {
            self.rest = Some(batch.slice(most, batch.num_rows() - most));
            batch = batch.slice(0, most);
        }
        Ok(Some(batch))
    }
}

fn unreadable(error: &ArrowError) -> String {
    format!("cannot be read as Arrow: {error}")
}

/// Finite values of the joints' columns, in place of what `out` holds.
pub(super) fn decode(batch: &RecordBatch, columns: &Columns, out: &mut DecodedPoses) {
    let (rows, joints) = (batch.num_rows(), columns.places().count());
    out.values.resize(rows * joints, 0.0);
    for (joint, (index, to_si)) in columns.places().enumerate() {
        let column = batch.column(index);
        let values = out.values.iter_mut().skip(joint).step_by(joints);
        if let Some(column) = column.as_primitive_opt::<Float64Type>() {
            values.zip(column.values()).for_each(|(value, &stored)| *value = to_si(stored));
        } else if let Some(column) = column.as_primitive_opt::<Float32Type>() {
            values.zip(column.values()).for_each(|(value, &stored)| *value = to_si(stored.into()));
        }
        if column.null_count() > 0 {
            for row in (0..rows).filter(|&row| column.is_null(row)) {
                out.values[row * joints + joint] = f64::NAN;
            }
        }
    }
    let places: Vec<usize> = columns.places().map(|(index, _)| index).collect();
    let titles: Vec<String> =
        places.iter().map(|&place| batch.schema_ref().field(place).name().clone()).collect();
    out.all_rows(rows, &titles, |i, value| {
        let is_null = batch.column(places[i % joints]).is_null(i / joints);
        if is_null { "empty".into() } else { value.to_string() }
    });
}
