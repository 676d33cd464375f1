//! The stiffness of joints from a load test, as text and JSON.

use std::fmt::Write;

use serde::Serialize;

use crate::identify::stiffness::StiffnessFit;
use crate::report::words::{number, trimmed};
use crate::units::percent_from_ratio;
use crate::wording::printable;

/// Name of the JSON format.
const SCHEMA: &str = "stiffness/1";

/// The fit of one joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFit {
    /// Name, where the table has one.
    pub joint: Option<String>,
    /// What was found.
    pub fit: StiffnessFit,
}

/// `value` with as many decimals as `of` needs for six digits; with a power of ten where that is of no
/// everyday size.
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

/// For people.
pub fn stiffness_text(fits: &[JointFit]) -> String {
    let mut out = String::new();
    for JointFit { joint, fit } in fits {
        let name = printable(joint.as_deref().unwrap_or("joint"));
        let shown = |value| six_digits(value, fit.stiffness);
        let [low, high] = fit.interval.map(shown);
        // Writing to a string does not fail.
        let _ = writeln!(
            out,
            "{name}: k = {} N·m/rad, standard error {}, {} % interval {low} to {high} \
             (R² {:.6}, {} rows, offset {} N·m, residuals {} N·m)",
            shown(fit.stiffness),
            shown(fit.standard_error),
            trimmed(percent_from_ratio(fit.confidence), 6),
            fit.r_squared,
            fit.rows,
            number(fit.intercept, 3),
            number(fit.residual_deviation, 3)
        );
        for hint in hints(fit) {
            let _ = writeln!(out, "  hint: {hint}");
        }
    }
    out
}

/// What the numbers alone do not say.
fn hints(fit: &StiffnessFit) -> Vec<String> {
    let mut hints = Vec::new();
    if let Some(curvature) = fit.curvature.filter(|curvature| curvature.is_significant()) {
        let how = if curvature.stiffens { "stiffens" } else { "softens" };
        hints.push(format!(
            "the joint {how} with load (p = {:.1e}), so one k holds only near these loads; test near the \
             loads of the job",
            curvature.p_value
        ));
    }
    if fit.interval[0] <= 0.0 {
        hints.push(
            "the interval reaches zero or below, so this is no stiffness; check signs and columns, or \
             load in more steps"
                .to_owned(),
        );
    }
    hints
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

/// For programs.
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub fn stiffness_json(fits: &[JointFit]) -> serde_json::Result<String> {
    let joints = fits
        .iter()
        .map(|JointFit { joint, fit }| JsonFit {
            joint: joint.as_deref(),
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
            hints: hints(fit),
        })
        .collect();
    Ok(serde_json::to_string_pretty(&JsonFits { schema: SCHEMA, joints })? + "\n")
}
