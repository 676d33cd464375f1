//! A map as CSV, JSON and SVG.

#[cfg(feature = "arrow")]
mod arrow;
mod block;
mod plot;
mod reduced;
mod reduced_plot;

use serde::Serialize;

#[cfg(feature = "arrow")]
pub use arrow::{map_arrow_block, map_arrow_end, map_arrow_schema, map_arrow_start};
pub use block::{map_csv_block, map_json_block, map_json_parting, map_npy_block, map_npy_header};
pub use plot::map_svg;
pub use reduced::{reduced_csv, reduced_json};
pub use reduced_plot::reduced_svg;

use crate::free_vibration::{Doubt, DoubtReason};
use crate::map::{Head, JointColumn, Row};
use crate::units::percent_from_ratio;

/// Name of the JSON format.
const SCHEMA: &str = "map/1";

/// The header line of a map as CSV.
pub fn map_csv_header(head: &Head, is_nonlinear: bool) -> String {
    let mut columns: Vec<String> = titles(head).iter().map(|title| quoted(title)).collect();
    if is_nonlinear {
        for r in 1..=head.coordinates.len() {
            columns.push(format!("f{r}_linear_hz"));
            columns.push(format!("f{r}_departure_percent"));
        }
        columns.push("energy_drift".into());
    }
    columns.join(",") + "\n"
}

/// Titles of the columns of a linear map: pose and frequencies.
fn titles(head: &Head) -> Vec<String> {
    let modes = (1..=head.coordinates.len()).map(|r| format!("f{r}_hz"));
    pose_titles(head).chain(modes).collect()
}

/// Titles of the columns that tell the pose.
fn pose_titles(head: &Head) -> impl Iterator<Item = String> {
    let title =
        |joint: &JointColumn| format!("{}_{}", joint.name, if joint.turns { "rad" } else { "m" });
    let beta2 = head.has_beta2.then(|| "beta2_rad".to_owned());
    head.joints.iter().map(title).chain(beta2)
}

/// Rows of a map as CSV, each number with as many digits as bring it back exactly; what a record does not
/// show is blank.
pub fn map_csv_rows(rows: &[Row], out: &mut String) {
    for row in rows {
        let mut line = Line { out: &mut *out, is_first: true };
        row.joints.iter().chain(&row.beta2_rad).for_each(|&v| line.number(Some(v)));
        row.frequencies_hz.iter().for_each(|&f| line.number(f));
        if let Some(nonlinear) = &row.nonlinear {
            for (&linear, departure) in nonlinear.linear_hz.iter().zip(nonlinear.departures()) {
                line.number(Some(linear));
                line.number(departure.map(percent_from_ratio));
            }
            line.number(Some(nonlinear.energy_drift));
        }
        out.push('\n');
    }
}

/// One row of a map as JSON.
#[derive(Debug, Serialize)]
struct JsonRow<'a> {
    joints: &'a [f64],
    #[serde(skip_serializing_if = "Option::is_none")]
    beta2_rad: Option<f64>,
    natural_frequencies_hz: &'a [Option<f64>],
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

/// A frequency that may be no mode's, and why.
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

#[derive(Debug, Serialize)]
struct JsonHead<'a> {
    schema: &'static str,
    robot: &'a str,
    method: &'static str,
    joints: Vec<JsonJoint<'a>>,
    coordinates: &'a [String],
}

#[derive(Debug, Serialize)]
struct JsonJoint<'a> {
    name: &'a str,
    unit: &'static str,
}

fn json_joints(head: &Head) -> Vec<JsonJoint<'_>> {
    let unit = |turns: bool| if turns { "rad" } else { "m" };
    head.joints
        .iter()
        .map(|joint| JsonJoint { name: &joint.name, unit: unit(joint.turns) })
        .collect()
}

/// The beginning of a map as JSON, up to the first row.
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub fn map_json_start(head: &Head, is_nonlinear: bool) -> serde_json::Result<String> {
    let text = serde_json::to_string(&JsonHead {
        schema: SCHEMA,
        robot: &head.robot,
        method: if is_nonlinear { "nonlinear" } else { "linear" },
        joints: json_joints(head),
        coordinates: &head.coordinates,
    })?;
    Ok(format!("{},\"rows\":[\n", text.trim_end_matches('}')))
}

/// Rows of a map as JSON; `is_first` where no row stands before them.
///
/// # Errors
/// As [`map_json_start`].
pub fn map_json_rows(rows: &[Row], is_first: bool, out: &mut String) -> serde_json::Result<()> {
    for (index, row) in rows.iter().enumerate() {
        if !(is_first && index == 0) {
            out.push_str(",\n");
        }
        out.push_str(&serde_json::to_string(&JsonRow {
            joints: &row.joints,
            beta2_rad: row.beta2_rad,
            natural_frequencies_hz: &row.frequencies_hz,
            nonlinear: row.nonlinear.as_ref().map(|nonlinear| JsonNonlinear {
                linear_hz: &nonlinear.linear_hz,
                departure_percent: nonlinear
                    .departures()
                    .map(|departure| departure.map(percent_from_ratio))
                    .collect(),
                energy_drift: nonlinear.energy_drift,
                folded: nonlinear
                    .folded
                    .iter()
                    .map(|folded| JsonFolded {
                        mode: folded.mode + 1,
                        frequency_hz: folded.frequency_hz,
                        seen_at_hz: folded.seen_at_hz,
                    })
                    .collect(),
                doubtful: nonlinear.doubts.iter().map(JsonDoubt::from).collect(),
            }),
        })?);
    }
    Ok(())
}

/// The end of a map as JSON.
pub fn map_json_end() -> &'static str {
    "\n]}\n"
}

struct Line<'a> {
    out: &'a mut String,
    is_first: bool,
}

impl Line<'_> {
    fn number(&mut self, value: Option<f64>) {
        if !self.is_first {
            self.out.push(',');
        }
        self.is_first = false;
        if let Some(value) = value {
            // Shortest digits that read back as the same number.
            self.out.push_str(zmij::Buffer::new().format(value));
        }
    }
}

/// A CSV field, in quotes where it must be.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_vibration::{Folded, Measurement, Spectrum};

    fn head() -> Head {
        Head {
            robot: "arm".into(),
            joints: vec![
                JointColumn { name: "a".into(), turns: true },
                JointColumn { name: "b,c".into(), turns: false },
            ],
            has_beta2: true,
            coordinates: vec!["a".into(), "b,c".into()],
        }
    }

    fn nonlinear_row() -> Row {
        Row {
            joints: vec![0.1, -1e-12],
            beta2_rad: Some(0.30000000000000004),
            frequencies_hz: vec![Some(25.5), None],
            nonlinear: Some(Measurement {
                frequencies_hz: vec![Some(25.5), None],
                linear_hz: vec![25.0, 84.0],
                folded: vec![Folded { mode: 1, frequency_hz: 84.0, seen_at_hz: 56.0 }],
                doubts: vec![Doubt { mode: 0, reason: DoubtReason::RivalPeak }],
                energy_drift: 1e-9,
                spectrum: Spectrum { bin_hz: 0.2, amplitudes: vec![] },
            }),
        }
    }

    #[test]
    fn csv_reads_back_exactly() {
        let mut text = map_csv_header(&head(), true);
        map_csv_rows(&[nonlinear_row()], &mut text);
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
        assert_eq!(
            names.join(" "),
            "a_rad b,c_m beta2_rad f1_hz f2_hz f1_linear_hz f1_departure_percent f2_linear_hz \
             f2_departure_percent energy_drift"
        );
        let record = reader.records().next().unwrap().unwrap();
        let values: Vec<Option<f64>> = record.iter().map(|v| v.parse().ok()).collect();
        let expected = [
            Some(0.1),
            Some(-1e-12),
            Some(0.30000000000000004),
            Some(25.5),
            None,
            Some(25.0),
            Some(percent_from_ratio(25.5 / 25.0 - 1.0)),
            Some(84.0),
            None,
            Some(1e-9),
        ];
        assert_eq!(values, expected);
    }

    #[test]
    fn json_has_the_same_numbers() {
        let mut text = map_json_start(&head(), true).unwrap();
        map_json_rows(&[nonlinear_row(), nonlinear_row()], true, &mut text).unwrap();
        map_json_rows(&[nonlinear_row()], false, &mut text).unwrap();
        text.push_str(map_json_end());
        let json: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(json["schema"], "map/1");
        assert_eq!(json["joints"][1]["unit"], "m");
        assert_eq!(json["rows"].as_array().unwrap().len(), 3);
        let row = &json["rows"][2];
        assert_eq!(row["joints"][1], -1e-12);
        assert_eq!(row["natural_frequencies_hz"][0], 25.5);
        assert!(row["natural_frequencies_hz"][1].is_null());
        assert_eq!(row["nonlinear"]["folded"][0]["mode"], 2);
        let doubt = serde_json::json!({"mode": 1, "reason": "rival_peak"});
        assert_eq!(row["nonlinear"]["doubtful"], serde_json::json!([doubt]));
    }
}
