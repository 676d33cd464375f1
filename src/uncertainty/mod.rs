//! What the model may be wrong by: parameters with standard deviations → how far each natural
//! frequency may lie off, and draws of the whole arm.
//!
//! A parameter is θ = ln(true value / value in the model) of a spring, of a body (mass and inertia
//! together) or of a drive; θ is normal with covariance Σ. At a pose
//!
//! ```text
//! ∂ln f_r/∂θ_k = ½ · share of spring k in the strain energy of mode r
//! ∂ln f_r/∂θ_b = −½ · share of body (or drive) b in its kinetic energy
//! σ²(ln f_r) = aᵀ Σ a + d_r²(q)
//! ```
//!
//! with a the column of these sensitivities and d_r what the model does not explain. First order is
//! enough for intervals; probabilities come from [`Draws`], each a whole arm that is the same along
//! the whole path.

mod arm;
mod belief;
mod draws;
mod parameters;

pub use arm::ArmAtPose;
pub use belief::{
    Belief, HalfWidth, Trust, UNCALIBRATED, largest_by_mode, reach_of, uncalibrated_std_ln,
};
pub use draws::{Draws, Estimate};
pub use parameters::{ASSUMED_STD, Parameter, Scales, all, lacking, scales_of, stated, states_all};
