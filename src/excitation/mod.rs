//! The frequencies at which spindle and cutter shake the arm, and how hard the cutter does.

mod chip;
mod cutting;
mod engagement;
mod lines;
mod material;

pub use chip::linear_about;
pub use cutting::ForceModel;
pub use engagement::{Engagement, ForceHarmonic};
pub use lines::{ExcitationLine, Source, WithoutOrder, lines};
pub use material::{MATERIALS, Material, coefficient_corners, coefficients, material};
