//! Stability lobes as CSV, JSON and a picture.

pub(super) mod json;
mod svg;
mod table;

pub use json::lobes_json;
pub use svg::lobes_drawing;
pub use table::lobes_csv;
