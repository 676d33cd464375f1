//! A reduced map as CSV and JSON.

use serde::Serialize;

use super::table::pose_titles;
use crate::map::{Bin, Extreme, Head, JointColumn, Reduced, ReducedMode, SHARES, Statistic};
use crate::report::json::{WHOLE, spread};
use crate::report::words::csv_field;
use crate::units::percent_from_ratio;

/// A reduced map as CSV, one figure a row: `min` and `max` with their pose (counted from 1),
/// `mean`, `q5` … `q95`, and `bin` with its upper end and how many poses lie in it. Cells that a
/// figure has no use for are blank.
pub fn reduced_csv(head: &Head, reduced: &Reduced, statistics: &[Statistic]) -> String {
    let columns: Vec<String> = pose_titles(head).map(|title| csv_field(&title)).collect();
    let mut out = format!("mode,statistic,frequency_hz,to_hz,poses,pose,{}\n", columns.join(","));
    let no_pose = ",".repeat(columns.len());
    let number = |value: f64| zmij::Buffer::new().format(value).to_owned();
    let at = |extreme: &Extreme| {
        let values = extreme.joints.iter().chain(&extreme.beta2_rad);
        let values: String = values.map(|v| format!(",{}", number(*v))).collect();
        format!("{},,,{}{values}", number(extreme.frequency_hz), extreme.pose + 1)
    };
    let alone = |value: f64| format!("{},,,{no_pose}", number(value));
    for (i, mode) in reduced.modes.iter().enumerate() {
        let mut row = |name: &str, cells: String| {
            out.push_str(&format!("{},{name},{cells}\n", i + 1));
        };
        for statistic in statistics {
            match statistic {
                Statistic::Min => row("min", at(&mode.min)),
                Statistic::Max => row("max", at(&mode.max)),
                Statistic::Mean => row("mean", alone(mode.mean_hz)),
                Statistic::Quantiles => {
                    for (share, value) in SHARES.iter().zip(mode.quantiles_hz) {
                        row(&format!("q{}", percent_from_ratio(*share)), alone(value));
                    }
                }
                Statistic::Histogram => {
                    for bin in &mode.histogram {
                        let (from, to) = (number(bin.from_hz), number(bin.to_hz));
                        row("bin", format!("{from},{to},{},{no_pose}", bin.poses));
                    }
                }
            }
        }
    }
    out
}

#[derive(Debug, Serialize)]
struct JsonReduced<'a> {
    schema: &'static str,
    robot: &'a str,
    poses: usize,
    quantile_resolution_percent: f64,
    joints: &'a [JointColumn],
    coordinates: &'a [String],
    modes: Vec<JsonMode<'a>>,
}

#[derive(Debug, Serialize)]
struct JsonMode<'a> {
    mode: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    min: Option<&'a Extreme>,
    #[serde(skip_serializing_if = "Option::is_none")]
    max: Option<&'a Extreme>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mean_hz: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    quantiles: Option<Vec<JsonQuantile>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    histogram: Option<&'a [Bin]>,
}

#[derive(Debug, Serialize)]
struct JsonQuantile {
    percent: f64,
    frequency_hz: f64,
}

/// A reduced map as JSON; `pose` counts from 1.
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub fn reduced_json(
    head: &Head,
    reduced: &Reduced,
    statistics: &[Statistic],
) -> serde_json::Result<String> {
    let modes = reduced.modes.iter().enumerate();
    let json = JsonReduced {
        schema: "map-reduced/1",
        robot: &head.robot,
        poses: reduced.poses,
        quantile_resolution_percent: percent_from_ratio(reduced.quantile_resolution),
        joints: &head.joints,
        coordinates: &head.coordinates,
        modes: modes.map(|(i, mode)| json_mode(i + 1, mode, statistics)).collect(),
    };
    spread(&json, WHOLE)
}

fn json_mode<'a>(number: usize, mode: &'a ReducedMode, statistics: &[Statistic]) -> JsonMode<'a> {
    let has = |statistic| statistics.contains(&statistic);
    let quantile = |(&share, frequency_hz): (&f64, f64)| JsonQuantile {
        percent: percent_from_ratio(share),
        frequency_hz,
    };
    JsonMode {
        mode: number,
        min: has(Statistic::Min).then_some(&mode.min),
        max: has(Statistic::Max).then_some(&mode.max),
        mean_hz: has(Statistic::Mean).then_some(mode.mean_hz),
        quantiles: has(Statistic::Quantiles)
            .then(|| SHARES.iter().zip(mode.quantiles_hz).map(quantile).collect()),
        histogram: has(Statistic::Histogram).then_some(&mode.histogram),
    }
}
