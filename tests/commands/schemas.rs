//! The schema files beside the example robots, sessions and jobs are what `detune schema` prints.

use std::fs;
use std::path::Path;

use detune::input::schema;
use serde_json::Value;

/// Regenerate with `detune schema robot > robots/robot.schema.json`,
/// `detune schema session > robots/session.schema.json` and `detune schema job > jobs/job.schema.json`.
#[test]
fn schema_files_are_up_to_date() {
    for (file, current) in [
        ("robots/robot.schema.json", schema::robot()),
        ("robots/session.schema.json", schema::session()),
        ("jobs/job.schema.json", schema::job()),
    ] {
        let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap();
        let kept: Value = serde_json::from_str(&text).unwrap();
        assert!(kept == current, "{file} is out of date");
    }
}
