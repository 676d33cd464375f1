//! A truth that shares no code with the crate: arms drawn at random, what their frequencies really are,
//! what the model of them does not know, and tables of what an experimenter would write down.
//!
//! Everything here stands apart from `src/` on purpose. The kinetic energy is that of homogeneous matrices,
//! T = ½ Σ tr(Ṫ J Ṫᵀ) with the 4 × 4 pseudo-inertia J of each body; the frequencies are found by counting
//! the negative pivots of K − λ M. Only `nalgebra`'s matrices are shared, as containers.
//!
//! | file | what lives there |
//! |---|---|
//! | [`arm`] | an arm as a model knows it |
//! | [`robots`] | arms drawn at random |
//! | [`dynamics`] | M, gravity's torques and stiffness |
//! | [`eigen`] | K φ = λ M φ |
//! | [`world`] | the arm as it really is: springs, laws and faults that the model lacks |
//! | [`effects`] | every cause of the vocabulary, and some beyond it, as a change of a world |
//! | [`drawing`] | where an effect may sit, and which one is drawn |
//! | [`case`] | poses, size, noise, table: one blind case |
//! | [`write`] | URDF, robot.yaml, measured.csv, truth.json |
//! | [`score`] | what a diagnosis said against what was hidden |
//! | [`confusion`] | many scores as tables |
//! | [`run`] | the program as a black box, over many cases |
//! | [`records`] | hammer tests in the time domain |

#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "each test uses a part of it, and tests stop where they fail"
)]

pub(crate) mod arm;
pub(crate) mod case;
pub(crate) mod confusion;
pub(crate) mod dice;
pub(crate) mod drawing;
pub(crate) mod dynamics;
pub(crate) mod effects;
pub(crate) mod eigen;
pub(crate) mod records;
pub(crate) mod robots;
pub(crate) mod run;
pub(crate) mod score;
pub(crate) mod world;
pub(crate) mod write;
