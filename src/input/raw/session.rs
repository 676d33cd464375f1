//! session.yaml as it is written. So far only its schema is used.
#![expect(dead_code, reason = "the schema is published before the reader")]

use schemars::JsonSchema;
use serde::Deserialize;

/// Raw records of vibration, to be turned into measured modes.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune session.yaml")]
pub(in crate::input) struct Session {
    /// Free text.
    note: Option<String>,
    /// Sampling rate, Hz, where the files themselves do not tell.
    #[schemars(extend("exclusiveMinimum" = 0, "examples" = [140]))]
    sample_rate_hz: Option<f64>,
    /// The records.
    #[schemars(required, extend("minItems" = 1))]
    records: Option<Vec<Record>>,
}

/// One file of raw data.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("x-noun" = "record"))]
struct Record {
    /// CSV with a header, UFF 58 (.uff, .unv) or WAV, relative to this file.
    #[schemars(required, extend("examples" = ["pose01.csv"]))]
    file: Option<String>,
    /// Where the robot stood: beta2_rad alone, or joints_deg.
    #[schemars(required)]
    pose: Option<Pose>,
    /// Channel that holds the excitation, or its UFF reference; absent for free decay, output only.
    #[schemars(extend("examples" = ["hammer"]))]
    excitation: Option<String>,
    /// Channels that hold the responses; all but the excitation if absent.
    #[schemars(extend("minItems" = 1, "examples" = [["x_mm", "y_mm"]]))]
    responses: Option<Vec<String>>,
}

/// A pose: exactly one of its keys.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Pose {
    /// The angle of the two-link model, rad.
    #[schemars(extend("examples" = [1.571]))]
    beta2_rad: Option<f64>,
    /// One value for each moving joint from base to tip: degrees, millimetres for a prismatic joint.
    #[schemars(extend("minItems" = 1))]
    joints_deg: Option<Vec<f64>>,
}
