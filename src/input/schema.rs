//! JSON Schemas (draft 2020-12) of the files that people write. The reader checks files against the
//! same schemas, so what an editor accepts is what is read.

use schemars::generate::SchemaSettings;
use schemars::transform::{RecursiveTransform, Transform};
use schemars::{JsonSchema, Schema};
use serde_json::Value;

use super::raw;

/// The schema of robot.yaml.
pub fn robot() -> Value {
    published(of::<raw::robot::Robot>())
}

/// The schema of job.yaml.
pub fn job() -> Value {
    published(of::<raw::job::Job>())
}

/// The schema of session.yaml.
pub fn session() -> Value {
    published(of::<raw::session::Session>())
}

/// The schema of marks.yaml.
pub fn marks() -> Value {
    published(of::<raw::marks::Marks>())
}

/// The schema of a file of modes.
pub fn modes() -> Value {
    published(of::<raw::lobes::Lobes>())
}

/// The schema of detune.toml.
pub fn settings() -> Value {
    published(of::<raw::settings::Settings>())
}

/// With the marks that only the reader understands; in one piece, without references, so that it
/// need not follow any.
pub(super) fn of<T: JsonSchema>() -> Value {
    let settings =
        SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

fn published(schema: Value) -> Value {
    let Ok(mut schema) = Schema::try_from(schema) else { return Value::Bool(true) };
    RecursiveTransform(|schema: &mut Schema| {
        if let Some(object) = schema.as_object_mut() {
            object.retain(|keyword, _| !keyword.starts_with("x-"));
            // Line ends of the source have no meaning.
            if let Some(Value::String(description)) = object.get_mut("description") {
                *description = description.replace('\n', " ");
            }
        }
    })
    .transform(&mut schema);
    schema.to_value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::yaml::KEYWORDS;

    /// Every keyword of a schema, by walking all places where schemas stand.
    fn keywords(schema: &Value, found: &mut Vec<String>) {
        let Some(object) = schema.as_object() else { return };
        for (keyword, value) in object {
            found.push(keyword.clone());
            match keyword.as_str() {
                "properties" => {
                    value.as_object().unwrap().values().for_each(|inner| keywords(inner, found));
                }
                "items" | "additionalProperties" => keywords(value, found),
                "anyOf" => {
                    value.as_array().unwrap().iter().for_each(|inner| keywords(inner, found))
                }
                _ => {}
            }
        }
    }

    #[test]
    fn the_reader_understands_every_keyword_of_every_schema() {
        for schema in [
            of::<raw::robot::Robot>(),
            of::<raw::job::Job>(),
            of::<raw::session::Session>(),
            of::<raw::marks::Marks>(),
            of::<raw::lobes::Lobes>(),
            of::<raw::settings::Settings>(),
        ] {
            let mut found = Vec::new();
            keywords(&schema, &mut found);
            assert!(found.len() > 30);
            for keyword in found {
                assert!(KEYWORDS.contains(&keyword.as_str()), "{keyword}");
            }
        }
    }

    #[test]
    fn published_schemas_hold_no_marks_of_ours_and_the_contract_s_keys() {
        for (schema, required) in [
            (robot(), vec!["urdf", "elasticity"]),
            (job(), vec!["spindle", "operations"]),
            (session(), vec!["records"]),
            (marks(), vec!["scale"]),
            (modes(), vec!["modes", "tool", "cutting"]),
        ] {
            assert!(!schema.to_string().contains("\"x-"));
            assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
            assert_eq!(schema["additionalProperties"], false);
            assert_eq!(schema["required"], serde_json::json!(required));
        }
        let operation = &job()["properties"]["operations"]["items"];
        assert_eq!(operation["required"], serde_json::json!(["name", "path"]));
        assert_eq!(operation["properties"]["feed_mm_per_min"]["exclusiveMinimum"], 0);
    }
}
