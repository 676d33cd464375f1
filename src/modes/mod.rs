//! One pose → natural frequencies and mode shapes.
//!
//! K φ_r = ω_r² M φ_r, solved as A y = λ y with K = L Lᵀ, A = L⁻¹ M L⁻ᵀ, λ = 1/ω², φ = ω L⁻ᵀ y. K
//! is diagonal unless gravity is asked for, so L⁻¹ is a scaling and a stiff coordinate next to a
//! soft one costs no digits. Jacobi's method keeps the small eigenvalues of such a scaled matrix as
//! exact as the large ones (Demmel & Veselić, SIAM J. Matrix Anal. Appl. 13, 1992).

pub mod batch;
mod jacobi;
mod pencil;
mod receptance;
mod solver;
mod statics;
mod tracking;

pub use pencil::Pencil;
pub use receptance::{
    peak_tip_compliance_m_per_n, peak_tip_compliances_m_per_n, tip_receptance_m_per_n,
};
pub use solver::{ModalSolver, Modes};
pub use statics::{Principal, Statics};
pub use tracking::{Follow, Tracker, mac};
