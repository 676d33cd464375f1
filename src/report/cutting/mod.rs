//! Cutting coefficients as text and JSON.

use schemars::JsonSchema;
use serde::Serialize;

use crate::report::json::{NotFinite, laid_out};
use crate::report::words::number;
use crate::study::cutting::{Coefficient, CuttingFit, Direction};
use crate::wording::wrapped;

/// Objects nested deeper than this stand on one line: a coefficient.
const DEEPEST_SPREAD: usize = 2;

/// As text, with a line to paste into a job.
pub fn cutting_text(fit: &CuttingFit) -> String {
    let mut out = String::new();
    let line = |out: &mut String, name: &str, unit: &str, k: &Coefficient| {
        let [low, high] = k.interval95.map(|value| number(value, 1));
        let (value, std) = (number(k.value, 1), number(k.std, 1));
        let text = format!("{value} {unit}, deviation {std}, 95 % interval {low} to {high}");
        wrapped(out, &format!("{name}  "), &text);
    };
    let directions: [(&str, Option<&Direction>); 3] =
        [("t", Some(&fit.tangential)), ("r", Some(&fit.radial)), ("a", fit.axial.as_ref())];
    let mut keys = Vec::new();
    for (name, direction) in directions {
        let Some(direction) = direction else { continue };
        line(&mut out, &format!("k{name}c"), "N/mm²", &direction.cutting_n_per_mm2);
        line(&mut out, &format!("k{name}e"), "N/mm", &direction.edge_n_per_mm);
        // What is below zero by its scatter alone is none.
        let [cutting, edge] =
            [direction.cutting_n_per_mm2, direction.edge_n_per_mm].map(|k| k.value.max(0.0));
        keys.push(format!("k{name}c_n_per_mm2: {cutting:.1}"));
        keys.push(format!("k{name}e_n_per_mm: {edge:.2}"));
    }
    let residuals: Vec<String> = directions
        .iter()
        .filter_map(|(_, direction)| Some(number(direction.as_ref()?.residual_n, 1)))
        .collect();
    let signs = if fit.is_turned { "; forces on the work, turned" } else { "" };
    wrapped(
        &mut out,
        "",
        &format!("{} slots, residuals {} N{signs}", fit.slots, residuals.join(", ")),
    );
    out += &format!("coefficients: {{{}}}\n", keys.join(", "));
    out
}

/// What `detune cutting --format json` writes.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune cutting/1")]
pub(in crate::report) struct Document<'a> {
    schema: SchemaName,
    /// What was found.
    fit: &'a CuttingFit,
}

#[derive(Debug, Serialize, JsonSchema)]
enum SchemaName {
    #[serde(rename = "cutting/1")]
    Cutting1,
}

/// As JSON.
///
/// # Errors
/// If a number is not finite, which would be an internal error.
pub fn cutting_json(fit: &CuttingFit) -> Result<String, NotFinite> {
    laid_out(&Document { schema: SchemaName::Cutting1, fit }, DEEPEST_SPREAD)
}
