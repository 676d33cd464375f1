//! The stiffness of joints from a load test, as text and JSON.

use serde::Serialize;

use crate::report::words::{number, trimmed};
use crate::study::stiffness::JointStiffness;
use crate::units::percent_from_ratio;
use crate::wording::{printable, wrapped};

/// Name of the JSON format.
const SCHEMA: &str = "stiffness/1";

/// `value` with as many decimals as `of` needs for six digits; with a power of ten where `of` is
/// very large or small.
fn six_digits(value: f64, of: f64) -> String {
    let magnitude = of.abs().log10().floor();
    if !(-9.0..9.0).contains(&magnitude) {
        return format!("{value:.5e}");
    }
    let text = format!("{value:.0$}", (5.0 - magnitude).max(0.0) as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// As text.
pub fn stiffness_text(joints: &[JointStiffness]) -> String {
    let mut out = String::new();
    for found in joints {
        let fit = &found.fit;
        let name = printable(found.joint.as_deref().unwrap_or("joint"));
        let shown = |value| six_digits(value, fit.stiffness);
        let [low, high] = fit.interval.map(shown);
        let stiffness = format!(
            "k = {} N·m/rad, standard error {}, {} % interval {low} to {high}",
            shown(fit.stiffness),
            shown(fit.standard_error),
            trimmed(percent_from_ratio(fit.confidence), 6),
        );
        wrapped(&mut out, &format!("{name}: "), &stiffness);
        let line = format!(
            "R² {:.6}, {} rows, offset {} N·m, residuals {} N·m",
            fit.r_squared,
            fit.rows,
            number(fit.intercept, 3),
            number(fit.residual_deviation, 3)
        );
        wrapped(&mut out, "  ", &line);
        for note in found.notes() {
            wrapped(&mut out, "  warning: ", &note.what);
        }
    }
    out
}

#[derive(Debug, Serialize)]
struct JsonFits<'a> {
    schema: &'static str,
    joints: Vec<JsonFit<'a>>,
}

#[derive(Debug, Serialize)]
struct JsonFit<'a> {
    joint: Option<&'a str>,
    rows: usize,
    stiffness_nm_per_rad: f64,
    standard_error_nm_per_rad: f64,
    confidence_percent: f64,
    interval_nm_per_rad: [f64; 2],
    intercept_nm: f64,
    intercept_standard_error_nm: f64,
    residual_deviation_nm: f64,
    r_squared: f64,
    curvature: Option<JsonCurvature>,
    hints: Vec<String>,
}

#[derive(Debug, Serialize)]
struct JsonCurvature {
    p_value: f64,
    stiffens: bool,
    significant: bool,
}

/// As JSON.
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub fn stiffness_json(joints: &[JointStiffness]) -> serde_json::Result<String> {
    let joints = joints.iter().map(json_fit).collect();
    Ok(serde_json::to_string_pretty(&JsonFits { schema: SCHEMA, joints })? + "\n")
}

fn json_fit(found: &JointStiffness) -> JsonFit<'_> {
    let fit = &found.fit;
    JsonFit {
        joint: found.joint.as_deref(),
        rows: fit.rows,
        stiffness_nm_per_rad: fit.stiffness,
        standard_error_nm_per_rad: fit.standard_error,
        confidence_percent: percent_from_ratio(fit.confidence),
        interval_nm_per_rad: fit.interval,
        intercept_nm: fit.intercept,
        intercept_standard_error_nm: fit.intercept_standard_error,
        residual_deviation_nm: fit.residual_deviation,
        r_squared: fit.r_squared,
        curvature: fit.curvature.map(|curvature| JsonCurvature {
            p_value: curvature.p_value,
            stiffens: curvature.stiffens,
            significant: curvature.is_significant(),
        }),
        hints: found.notes().into_iter().map(|note| note.what).collect(),
    }
}
