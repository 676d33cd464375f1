//! JSON Schemas (draft 2020-12) of the files that people write. The reader checks files against the
//! same schemas, so what an editor accepts is what is read.

use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, Transform};
use schemars::{JsonSchema, Schema};
use serde_json::Value;

use super::raw;

/// The schema of robot.yaml.
pub fn robot() -> Value {
    published(robot_to_check())
}

/// The schema of job.yaml.
pub fn job() -> Value {
    published(job_to_check())
}

/// The schema of session.yaml.
pub fn session() -> Value {
    published(of::<raw::session::Session>())
}

/// With the marks that only the reader understands.
pub(super) fn robot_to_check() -> Value {
    of::<raw::robot::Robot>()
}

/// With the marks that only the reader understands.
pub(super) fn job_to_check() -> Value {
    of::<raw::job::Job>()
}

/// In one piece, without references, so that the reader need not follow any.
fn of<T: JsonSchema>() -> Value {
    let settings =
        SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

fn published(schema: Value) -> Value {
    let Ok(mut schema) = Schema::try_from(schema) else { return Value::Bool(true) };
    RecursiveTransform(|schema: &mut Schema| {
        if let Some(object) = schema.as_object_mut() {
            object.retain(|keyword, _| !keyword.starts_with("x-"));
        }
    })
    .transform(&mut schema);
    schema.to_value()
}
