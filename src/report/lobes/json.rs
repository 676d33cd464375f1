//! The output `lobes/1`.

use schemars::JsonSchema;
use serde::Serialize;

use crate::report::json::{NotFinite, laid_out};
use crate::study::lobes::{LimitOf, Lobes, Method, Rows, SeenMode};

/// Objects nested deeper than this stand on one line: a mode, a row.
const DEEPEST_SPREAD: usize = 3;

/// What `detune lobes --format json` writes.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "detune lobes/1")]
pub(in crate::report) struct Document<'a> {
    schema: SchemaName,
    /// What was asked.
    title: &'a str,
    method: Method,
    limit_of: LimitOf,
    /// Whether a mode of the tool is among the modes; without it this stands for the arm's modes
    /// alone.
    has_tool_modes: bool,
    /// The modes as the tool tip sees them, those of the arm first.
    modes: &'a [SeenMode],
    /// One entry a speed.
    rows: &'a Rows,
}

#[derive(Debug, Serialize, JsonSchema)]
enum SchemaName {
    #[serde(rename = "lobes/1")]
    Lobes1,
}

/// As JSON.
///
/// # Errors
/// If a number is not finite, which would be an internal error.
pub fn lobes_json(lobes: &Lobes) -> Result<String, NotFinite> {
    let document = Document {
        schema: SchemaName::Lobes1,
        title: &lobes.title,
        method: lobes.method,
        limit_of: lobes.limit_of,
        has_tool_modes: lobes.has_tool_modes,
        modes: &lobes.modes,
        rows: &lobes.rows,
    };
    laid_out(&document, DEEPEST_SPREAD)
}
