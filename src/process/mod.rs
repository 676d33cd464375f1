//! What the cut does at the tool tip along a path: static deflection, forced vibration, the error
//! that they leave on the surface, and the depth at which the cut chatters. All in the tool's
//! frame, which turns with the feed: x along the feed, z along the spindle out of the work, y = z ×
//! x.
//!
//! The arm's modes and those of the tool itself add up to one receptance,
//!
//! ```text
//! G(ω) = Σ_r φ_r φ_rᵀ / (ω_r² − ω² + 2 i ζ_r ω_r ω),   u_k = G(k Ω) F_k,   u_0 = G(0) F̄
//! ```
//!
//! with F_k the harmonics of the cutting force ([`crate::excitation::ForceModel`]) and φ_r what
//! mode r moves the tip. Of a drill F̄ is the thrust, out of the work, and what it moves across the
//! axis is the skid; torque and twist are left out, as G has no rotations. Left out of u_k: what
//! the vibration does to the chip. [`Chatter`] has that.

mod air_cuts;
mod chatter;
mod effects;
mod limit_interval;
mod place_limit;
mod tip;

pub use air_cuts::{DrillMove, InWork, drills, in_work, is_air_cut};
pub use chatter::{Chatter, LimitAt, Seen, chart_at, chatter};
pub use effects::{AtPlace, Doubtful, DrillingAt, Effects, NoForce, force_of, orders_of};
pub use limit_interval::Spread;
pub use tip::{Owner, TipMode, TipPlace, arm_modes, sure_ones, tip_places};
