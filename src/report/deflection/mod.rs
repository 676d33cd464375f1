//! Static deflections as text, CSV and JSON.

pub(super) mod json;
mod table;
mod text;

pub use json::deflection_json;
pub use table::deflection_csv;
pub use text::deflection_text;
