//! Tracks of marks as tables and as a picture.

mod svg;
mod table;

pub use svg::tracks_drawing;
pub use table::{frames_csv, traces_csv};
