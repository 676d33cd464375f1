//! Measurements, by methods that never see a prediction.

pub mod stiffness;
mod table;

pub use table::{ModeRow, ModeTable};
