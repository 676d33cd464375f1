//! Measurements, by methods that never see a prediction.
//!
//! ```text
//! record → checked (quality) → hits and decays (hits) → spectra in the band that is filled (prepare, spectra)
//!        → poles and residues with covariances (estimate) → modes, shapes, rotations of links (identify, links)
//!        → what must be known (suspicions) → one row a pose (session)
//! ```

mod estimate;
mod hits;
pub mod links;
pub mod notice;
mod prepare;
mod quality;
pub mod record;
pub mod record_modes;
pub mod session;
pub mod spectra;
pub mod stiffness;
mod suspicions;
mod table;

pub use estimate::lscf::{StabilisationPoint, Stability};
pub use prepare::Kind;
pub use table::{ModeRow, ModeTable};
