//! Measurements, by methods that never see a prediction.

pub mod stiffness;
