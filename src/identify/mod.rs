//! Measurements, by methods that never see a prediction.
//!
//! ```text
//! record → checked (quality) → impacts and decays (impacts, innovations)
//!        → spectra in the band that is filled (prepare, spectra)
//!        → poles and residues with covariances (estimate)
//!        → modes, shapes, rotations of links (mode, links), held against the second half of the
//!          decay (late) → warnings (suspicions)
//!        → one row a pose, modes of its records joined, shapes put together (session, pairing,
//!          shapes) → a table of modes (table)
//! ```

mod clocks;
pub mod cutting;
mod estimate;
mod harmonics;
mod hum;
mod impacts;
mod innovations;
mod late;
pub mod links;
mod misfit;
pub mod mode;
mod pairing;
pub mod pose;
mod prepare;
mod quality;
pub mod record;
pub mod record_modes;
mod references;
pub mod session;
mod shapes;
pub mod spectra;
mod starts;
pub mod stiffness;
mod suspicions;
mod sway;
mod table;

pub use estimate::lscf::{StabilisationPoint, Stability};
pub use prepare::RecordKind;
pub use table::{MeasuredRotation, ModeRow, ModeTable, RotationAxis};
