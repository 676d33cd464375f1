//! A part of a reduced map as its file: JSON on one line, every number with all its digits.

use crate::report::json::{NotFinite, laid_out};
use crate::study::map::Sketch;

/// What `detune map --format sketch` writes and `detune merge` reads.
///
/// # Errors
/// If a number is not finite, which would be an internal error.
pub fn sketch_json(sketch: &Sketch) -> Result<String, NotFinite> {
    laid_out(sketch, 1)
}
