//! The stiffness of joints from a load test, as text and JSON.

use serde::Serialize;

use crate::report::json::{WHOLE, spread};
use crate::report::words::{number, trimmed};
use crate::study::stiffness::JointStiffness;
use crate::units::percent_from_ratio;
use crate::wording::{printable, wrapped};

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
        for note in &found.warnings {
            wrapped(&mut out, "  warning: ", &note.what);
        }
    }
    out
}

#[derive(Debug, Serialize)]
struct JsonFits<'a> {
    schema: &'static str,
    joints: &'a [JointStiffness],
}

/// As JSON.
///
/// # Errors
/// The serialiser's, which has no cause of its own to fail.
pub fn stiffness_json(joints: &[JointStiffness]) -> serde_json::Result<String> {
    spread(&JsonFits { schema: "stiffness/1", joints }, WHOLE)
}
