//! Many poses of a linear map at once as an Apache Arrow stream: the columns of the CSV, one record
//! batch a block.

use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_ipc::writer::{
    DictionaryTracker, IpcDataGenerator, IpcWriteContext, IpcWriteOptions, write_message,
};
use arrow_schema::{ArrowError, DataType, Field, Schema, SchemaRef};

use super::table::titles;
use crate::map::{Block, Head};

/// A message of no length ends a stream (Arrow columnar format 1.5, "IPC Streaming Format").
pub(super) const END: [u8; 8] = [0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0];

/// Columns of the stream: the joints (rad or m), β2 where the robot has it, the frequencies, Hz,
/// ascending.
pub(super) fn schema(head: &Head) -> SchemaRef {
    let fields = titles(head).into_iter().map(|title| Field::new(title, DataType::Float64, false));
    Arc::new(Schema::new(fields.collect::<Vec<_>>()))
}

/// The beginning of the stream.
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub(super) fn start(schema: &Schema) -> Result<Vec<u8>, ArrowError> {
    let options = IpcWriteOptions::default();
    let mut out = Vec::new();
    let message = IpcDataGenerator::default().schema_to_bytes_with_dictionary_tracker(
        schema,
        &mut DictionaryTracker::new(false),
        &options,
    );
    write_message(&mut out, message, &options)?;
    Ok(out)
}

/// The poses of a block as a record batch, appended to `out`.
///
/// # Errors
/// A block that has other columns than `schema`.
pub(super) fn append(
    schema: &SchemaRef,
    block: &Block,
    out: &mut Vec<u8>,
) -> Result<(), ArrowError> {
    if block.count == 0 {
        return Ok(());
    }
    let parts = [&block.poses, &block.beta2_rad, &block.frequencies_hz];
    let columns: Vec<ArrayRef> = parts
        .iter()
        .flat_map(|values| {
            let width = values.len() / block.count;
            (0..width).map(move |column| {
                let column = values.iter().copied().skip(column).step_by(width);
                Arc::new(Float64Array::from_iter_values(column)) as ArrayRef
            })
        })
        .collect();
    let batch = RecordBatch::try_new(schema.clone(), columns)?;
    let options = IpcWriteOptions::default();
    let (_, message) = IpcDataGenerator::default().encode(
        &batch,
        &mut DictionaryTracker::new(false),
        &options,
        &mut IpcWriteContext::default(),
    )?;
    write_message(&mut *out, message, &options)?;
    Ok(())
}
