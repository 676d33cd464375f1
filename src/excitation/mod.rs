//! The frequencies at which spindle and cutter shake the arm, and how hard the cutter does.

mod cutting;
mod lines;

pub use cutting::{
    Engagement, ForceHarmonic, ForceModel, MATERIALS, Material, coefficients, material,
};
pub use lines::{ExcitationLine, Source, WithoutOrder, lines};
