//! When a cut becomes unstable: what the tool tip does feeds back into the chip.
//!
//! A tooth cuts what the one ahead of it has left, so the force depends on where the tip is and on
//! where it was a tooth period τ ago:
//!
//! ```text
//! q̈_r + 2 ζ_r ω_r q̇_r + ω_r² q_r = φ_rᵀ F,   u = Σ_r φ_r q_r,   F(t) = a H(t) (u(t) − u(t − τ))
//! ```
//!
//! with a the axial depth and H(t) the directional matrix of the teeth in the cut, from the
//! coefficients K_tc, K_rc, K_ac. Everything is in the tool's frame: x along the feed, z out of
//! the work, y = z × x. The limit is the smallest a at which a small motion grows.
//!
//! A drill is fed along its axis, and its lips cut all the time. With w what a lip takes across the
//! axis and κ half the point angle,
//!
//! ```text
//! F_z(t) = −w K_rc sin κ Σ_j (u_z(t) − u_z(t − τ_j))
//! ```
//!
//! whose coefficients are constant: the zeroth order is exact, and the limit is a w. Its motion to
//! the side and its twist are left out.
//!
//! - [`Chart`]: zeroth order (Altintas & Budak 1995): H(t) replaced by its mean, all cross terms.
//!   Wrong where a tooth is in the cut for a short time only.
//! - [`Exact`]: the spectral radius of the motion over one period, by collocation of the force.
//! - [`coupling_limit`]: without regeneration, as where a tooth cuts fresh material.
//!
//! Process damping, where a coefficient C is given: the flank of a tooth rubs on the wave of the
//! surface, with a force against the speed ṙ of its tip along the direction of the chip,
//! −C a ṙ / v, v the cutting speed (Tyler, Troutman & Schmitz, Precision Engineering 46, 2016, 65;
//! so, too, Altintas, Eynian & Onozuka, CIRP Annals 57, 2008, 371). Its friction along the cut
//! is left out.
//!
//! Left out: runout, and where the tool leaves the cut.

mod arnoldi;
mod chart;
mod cut;
mod element;
mod exact;
mod limit;
mod milling;
mod mode;
mod period;

pub use chart::{Chart, coupling_limit};
pub use cut::{Cut, is_misled, is_narrow};
pub use exact::{Exact, milling_grows, milling_limit, milling_radius};
pub use limit::{DEEPEST_M, Kind, Limit, LimitOf, Method};
pub use milling::{Milling, Process, Term};
pub use mode::{ToolMode, displacement_m, receptance_m_per_n};
