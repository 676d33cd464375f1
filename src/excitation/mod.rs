//! The frequencies at which spindle and cutter shake the arm, and how hard the cutter does.

mod chip;
mod cutting;
mod drilling;
mod engagement;
mod force;
mod lines;
mod material;

pub use chip::linear_about;
pub use cutting::MillingForce;
pub use drilling::{DrillingForce, Lips, is_unlike};
pub use engagement::{Engagement, ForceHarmonic};
pub use force::{ForceModel, linear_at};
pub use lines::{ExcitationLine, Source, WithoutOrder, lines};
pub use material::{MATERIALS, Material, coefficient_corners, coefficients, material};
