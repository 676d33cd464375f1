//! JSON Schemas (draft 2020-12) of the outputs.

use schemars::generate::SchemaSettings;
use serde_json::Value;

/// Schema of what `detune check --format json` writes.
pub fn check() -> Value {
    SchemaSettings::draft2020_12()
        .for_serialize()
        .into_generator()
        .into_root_schema_for::<super::json::Check<'static>>()
        .to_value()
}
