//! JSON Schemas (draft 2020-12) of the outputs.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// Schema of what `detune check --format json` writes.
pub fn check() -> Value {
    of::<super::check::json::Check<'static>>()
}

/// Schema of what `detune advise --format json` writes.
pub fn advice() -> Value {
    of::<super::advise::json::Advice<'static>>()
}

/// Schema of what `detune identify --format json` writes.
pub fn identification() -> Value {
    of::<super::identify::Identification<'static>>()
}

/// Schema of what `detune diagnose --format json` writes.
pub fn diagnosis() -> Value {
    of::<super::diagnosis::json::Document>()
}

fn of<T: JsonSchema>() -> Value {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    generator.into_root_schema_for::<T>().to_value()
}
