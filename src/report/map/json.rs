//! A map as JSON.

use serde::Serialize;

use crate::free_vibration::{Doubt, DoubtReason, Measurement};
use crate::map::{Block, Head};
use crate::units::percent_from_ratio;

/// Name of the format.
const SCHEMA: &str = "map/1";

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
    nonlinear: Option<JsonNonlinear<'a>>,
}

#[derive(Debug, Serialize)]
struct JsonNonlinear<'a> {
    linear_hz: &'a [f64],
    departure_percent: Vec<Option<f64>>,
    energy_drift: f64,
    folded: Vec<JsonFolded>,
    doubtful: Vec<JsonDoubt>,
}

/// A peak that may not be the mode, and why.
#[derive(Debug, Serialize)]
struct JsonDoubt {
    mode: usize,
    reason: &'static str,
}

impl From<&Doubt> for JsonDoubt {
    fn from(doubt: &Doubt) -> Self {
        let reason = match doubt.reason {
            DoubtReason::FarFromLinear => "far_from_linear",
            DoubtReason::NearerToAnotherMode => "nearer_to_another_mode",
            DoubtReason::RivalPeak => "rival_peak",
        };
        Self { mode: doubt.mode + 1, reason }
    }
}

#[derive(Debug, Serialize)]
struct JsonFolded {
    mode: usize,
    frequency_hz: f64,
    seen_at_hz: f64,
}

impl<'a> From<&'a Measurement> for JsonNonlinear<'a> {
    fn from(found: &'a Measurement) -> Self {
        let folded = found.folded.iter().map(|folded| JsonFolded {
            mode: folded.mode + 1,
            frequency_hz: folded.frequency_hz,
            seen_at_hz: folded.seen_at_hz,
        });
        Self {
            linear_hz: &found.linear_hz,
            departure_percent: found
                .departures()
                .map(|departure| departure.map(percent_from_ratio))
                .collect(),
            energy_drift: found.energy_drift,
            folded: folded.collect(),
            doubtful: found.doubts.iter().map(JsonDoubt::from).collect(),
        }
    }
}

#[derive(Debug, Serialize)]
struct JsonHead<'a> {
    schema: &'static str,
    robot: &'a str,
    method: &'static str,
    joints: Vec<JsonJoint<'a>>,
    coordinates: &'a [String],
}

#[derive(Debug, Serialize)]
pub(super) struct JsonJoint<'a> {
    name: &'a str,
    unit: &'static str,
}

pub(super) fn json_joints(head: &Head) -> Vec<JsonJoint<'_>> {
    let unit = |turns: bool| if turns { "rad" } else { "m" };
    head.joints
        .iter()
        .map(|joint| JsonJoint { name: &joint.name, unit: unit(joint.turns) })
        .collect()
}

/// The beginning, up to the first row.
pub(super) fn start(head: &Head, is_nonlinear: bool) -> serde_json::Result<String> {
    let text = serde_json::to_string(&JsonHead {
        schema: SCHEMA,
        robot: &head.robot,
        method: if is_nonlinear { "nonlinear" } else { "linear" },
        joints: json_joints(head),
        coordinates: &head.coordinates,
    })?;
    Ok(format!("{},\"rows\":[\n", text.trim_end_matches('}')))
}

/// The rows of a block, appended to `out`, each behind a separator.
pub(super) fn append(block: &Block, out: &mut Vec<u8>) -> serde_json::Result<()> {
    for row in block.rows() {
        out.extend_from_slice(SEPARATOR.as_bytes());
        let row = JsonRow {
            joints: row.joints,
            beta2_rad: row.beta2_rad.first().copied(),
            natural_frequencies_hz: row.frequencies_hz,
            nonlinear: row.nonlinear.map(JsonNonlinear::from),
        };
        serde_json::to_writer(&mut *out, &row)?;
    }
    Ok(())
}
