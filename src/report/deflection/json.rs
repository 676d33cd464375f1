//! The output `deflection/1`.

use schemars::JsonSchema;
use serde::Serialize;

use crate::report::json::{NotFinite, laid_out};
use crate::study::deflection::{Deflection, Deflections};

/// Objects nested deeper than this stand on one line: a pose.
const DEEPEST_SPREAD: usize = 2;

/// What `detune deflection --format json` writes.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune deflection/1")]
pub(in crate::report) struct Document<'a> {
    schema: SchemaName,
    /// The robot or the job.
    name: &'a str,
    /// Joints, base to tip.
    joints: Vec<&'a str>,
    /// Elastic coordinates, in the order of `sag`.
    coordinates: &'a [String],
    /// Pose after pose.
    poses: &'a [Deflection],
}

#[derive(Debug, Serialize, JsonSchema)]
enum SchemaName {
    #[serde(rename = "deflection/1")]
    Deflection1,
}

/// As JSON.
///
/// # Errors
/// If a number is not finite, which would be an internal error.
pub fn deflection_json(found: &Deflections) -> Result<String, NotFinite> {
    let document = Document {
        schema: SchemaName::Deflection1,
        name: &found.name,
        joints: found.joints.iter().map(|(name, _)| name.as_str()).collect(),
        coordinates: &found.coordinates,
        poses: &found.rows,
    };
    laid_out(&document, DEEPEST_SPREAD)
}
