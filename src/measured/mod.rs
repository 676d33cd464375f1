//! Measurements, by methods that never see a prediction.

mod estimate;
mod hits;
pub mod identify;
pub mod links;
pub mod notice;
mod prepare;
mod quality;
pub mod record;
pub mod session;
pub mod spectra;
pub mod stiffness;
mod suspicions;

pub use estimate::lscf::{StabilisationPoint, Stability};
pub use prepare::Kind;
