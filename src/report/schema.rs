//! JSON Schemas (draft 2020-12) of the outputs.

use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::{JsonSchema, Schema};
use serde_json::Value;

/// Schema of what `detune check --format json` writes.
pub fn check() -> Value {
    of::<super::check::json::Check<'static>>(plain)
}

/// Schema of what `detune advise --format json` writes.
pub fn advice() -> Value {
    of::<super::advise::json::Advice<'static>>(plain)
}

/// Schema of what `detune identify --format json` writes.
pub fn identification() -> Value {
    of::<super::identify::Identification<'static>>(plain)
}

/// Schema of what `detune diagnose --format json` writes.
pub fn diagnosis() -> Value {
    of::<super::diagnosis::json::Document<'static>>(|_| ())
}

/// Schema of what `detune cutting --format json` writes.
pub fn cutting() -> Value {
    of::<super::cutting::Document<'static>>(plain)
}

/// Schema of what `detune deflection --format json` writes.
pub fn deflection() -> Value {
    of::<super::deflection::json::Document<'static>>(plain)
}

/// Schema of what `detune lobes --format json` writes.
pub fn lobes() -> Value {
    of::<super::lobes::json::Document<'static>>(plain)
}

fn of<T: JsonSchema>(numbers: fn(&mut Schema)) -> Value {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let settings = settings
        .with_transform(RecursiveTransform(listed))
        .with_transform(RecursiveTransform(numbers));
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

/// Words that are each described are listed instead: the description of the whole says what they
/// mean.
fn listed(schema: &mut Schema) {
    let word = |option: &Value| option.get("const").filter(|word| word.is_string()).cloned();
    let words = schema.get("oneOf").and_then(Value::as_array);
    let words: Option<Vec<Value>> = words.and_then(|words| words.iter().map(word).collect());
    if let Some(words) = words {
        schema.remove("oneOf");
        schema.insert("enum".to_owned(), Value::Array(words));
        schema.insert("type".to_owned(), "string".into());
    }
}

/// A number is any number of JSON.
fn plain(schema: &mut Schema) {
    if schema.get("format").is_some_and(|format| format == "double") {
        schema.remove("format");
    }
}
