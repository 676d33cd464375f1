//! A map as JSON.

use serde::Serialize;

use crate::free_vibration::Measurement;
use crate::map::{Block, Head, JointColumn, ModeShape};
use crate::report::json::spread;

/// What separates two rows.
pub(super) const SEPARATOR: &str = ",\n";

/// One row; a frequency that a record does not show is NaN here and null there.
#[derive(Debug, Serialize)]
struct JsonRow<'a> {
    joints: &'a [f64],
    #[serde(skip_serializing_if = "Option::is_none")]
    beta2_rad: Option<f64>,
    natural_frequencies_hz: &'a [f64],
    #[serde(skip_serializing_if = "Option::is_none")]
    natural_frequencies_ci95_hz: Option<&'a [[f64; 2]]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    mode_shapes: Vec<ModeShape<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nonlinear: Option<&'a Measurement>,
}

#[derive(Debug, Serialize)]
struct JsonHead<'a> {
    schema: &'static str,
    robot: &'a str,
    method: &'static str,
    joints: &'a [JointColumn],
    coordinates: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    shape_links: Option<&'a [String]>,
}

/// The beginning, up to the first row.
pub(super) fn start(head: &Head, is_nonlinear: bool) -> serde_json::Result<String> {
    let text = spread(
        &JsonHead {
            schema: "map/1",
            robot: &head.robot,
            method: if is_nonlinear { "nonlinear" } else { "linear" },
            joints: &head.joints,
            coordinates: &head.coordinates,
            shape_links: head.shape_links.as_deref(),
        },
        0,
    )?;
    Ok(format!("{},\"rows\":[\n", text.trim_end().trim_end_matches('}')))
}

/// The rows of a block, appended to `out`, each behind a separator.
pub(super) fn append(block: &Block, out: &mut Vec<u8>) -> serde_json::Result<()> {
    for row in block.rows() {
        out.extend_from_slice(SEPARATOR.as_bytes());
        let row = JsonRow {
            joints: row.joints,
            beta2_rad: row.beta2_rad.first().copied(),
            natural_frequencies_hz: row.frequencies_hz,
            natural_frequencies_ci95_hz: Some(row.intervals_hz.as_chunks().0)
                .filter(|pairs| !pairs.is_empty()),
            mode_shapes: row.mode_shapes().collect(),
            nonlinear: row.nonlinear,
        };
        serde_json::to_writer(&mut *out, &row)?;
    }
    Ok(())
}
