//! detune predicts whether a job will excite a resonance of the robot arm that runs it: where along
//! the path, in which mode, and at which spindle speeds it will not.
//!
//! # The problem
//!
//! A pose q freezes the joints of an arm; its elastic coordinates α move about the pose:
//!
//! ```text
//! M(q) α̈ + C α̇ + (K + K_g(q)) α = f          K φ_r = ω_r² M φ_r,   f_r = ω_r / 2π
//! ```
//!
//! As the arm runs along a path, the natural frequencies f_r move. A spindle at n rev/min with a
//! cutter of z teeth excites the arm at multiples of n/60 and of z·n/60. A **crossing** is where
//! such a line lies inside a mode's band, |f_exc − f_r| < f_r · separation; it is certain there,
//! and uncertain where the line lies outside that band but inside the one widened by what the model
//! may be wrong by.
//!
//! # Notation
//!
//! | symbol | name | unit | shape | frame |
//! |---|---|---|---|---|
//! | q | joint positions, base to tip | rad, m | number of moving joints | |
//! | α | elastic coordinates | rad, m | n | |
//! | M | mass matrix over α | kg·m², kg | n × n | |
//! | K, K_g | stiffness of the springs (diagonal), of gravity | N·m/rad, N/m | n × n | |
//! | C | damping matrix | N·m·s/rad | n × n | |
//! | ω_r, f_r | natural frequency of mode r | rad/s, Hz | n | |
//! | φ_r, Φ | mass-normalised mode shapes, as columns | | n × n | |
//! | ζ_r | damping ratio of mode r | 1 | n | |
//! | J | Jacobian of the tool centre point over α (or q) | m, 1 | 6 × n, linear above angular | base |
//! | G(ω) | receptance at the tool centre point | m/N | scalar along d | base |
//! | β1, β2 | angles of the two-link model | rad | | |
//! | s | share of an operation's time | 1 | 0..=1 | |
//! | z, n | teeth; spindle speed | 1; rev/min | | |
//!
//! Identification:
//!
//! | symbol | name | unit | shape |
//! |---|---|---|---|
//! | T, N | sampling interval, samples of a record | s, 1 | |
//! | F(ω), X(ω) | spectra of force and response | | lines |
//! | H(ω) | frequency response function X/F | response/N | lines |
//! | γ²(ω) | coherence of force and response, 0..=1 | 1 | lines |
//! | λ_r | pole of mode r, −ζ_r ω_r + i ω_r √(1 − ζ_r²) | rad/s | complex |
//! | A_r | residue of mode r: X(ω) = Σ_r A_r b_r(ω) + conjugate | | complex, one per response |
//! | b_r(ω) | spectrum of mode r with residue 1; of an FRF 1/(iω − λ_r) | | complex, lines |
//! | z, μ | e^{iωT}, e^{λT} | 1 | complex |
//! | E_j(t), β_rj | envelope of mode j against its largest, drift of pole r with it | 1, rad/s | |
//!
//! Diagnosis:
//!
//! | symbol | name | unit | shape |
//! |---|---|---|---|
//! | θ | parameters of the causes of a hypothesis | as their names say | p |
//! | r | residuals ln(f_measured / f_predicted(θ)) | 1 | n measured frequencies |
//! | s, ν | scale of the noise of r; degrees of freedom of its Student t distribution, 8 | 1 | |
//! | L | likelihood of θ and s, with what is expected of θ | 1 | |
//! | BIC | −2 ln L + p ln n | 1 | |
//! | c | relative change of a spring per N·m of excitation or gravity torque, or per K | 1/(N·m), 1/K | |
//!
//! Everything is SI inside; [`units`] converts at the edge. Poses are right-handed; roll, pitch and
//! yaw are those of URDF (fixed axes x, y, z in turn).
//!
//! # Code map
//!
//! Numbers flow one way: a module imports only modules that stand below it, and the files of a
//! module do not import each other in a circle. Only `cli`, `input` and `formats` touch files; only
//! `cli` prints. `tests/house` reads this list and holds the code against it.
//!
//! - [`cli`]: one file a verb: arguments, files, progress. May import `study`, `report`. Must
//!   never decide anything that a library user would miss.
//! - [`report`]: text, JSON, tables, pages, plots and what build servers read: pure functions
//!   from results. May import `study`, `advice`, `risk`, `diagnosis`, `map`, `process`,
//!   `identify`, `free_vibration`, `stability`, `excitation`, `job`, `formats`. Must never call
//!   a function of another module.
//! - [`study`]: one function a verb: valid inputs → a result that holds all that is shown, and
//!   what is written back. May import `input`, `advice`, `risk`, `diagnosis`, `map`, `process`,
//!   `path`, `free_vibration`, `trace`, `identify`, `stability`, `excitation`, `job`,
//!   `uncertainty`, `modes`, `program`, `model`, `motion`. Must never print, read or write
//!   files.
//! - [`input`]: YAML, URDF, tables, records, videos → valid types, all faults with file and
//!   line. May import `job`, `program`, `trace`, `identify`, `model`, `motion`, `formats`. Must
//!   never compute.
//! - [`advice`]: safe speeds, the best of them, schedules, other levers, vibration of the tool
//!   tip. May import `risk`, `process`, `path`, `stability`, `excitation`, `job`,
//!   `uncertainty`, `modes`, `model`, `motion`. Must never print.
//! - [`risk`]: bands, crossings, limits on the tool tip, certainty, verdict. May import
//!   `process`, `path`, `excitation`, `job`, `uncertainty`, `modes`, `model`, `motion`. Must
//!   never choose a remedy.
//! - [`diagnosis`]: where prediction and measurement meet: residuals, causes (one a file),
//!   fits, choice, gain, next poses. May import `uncertainty`, `modes`, `identify`, `model`.
//!   Must never name a cause that it has not compared with its rivals.
//! - [`map`]: frequencies over given poses, grids and random poses, linear or nonlinear; their
//!   figures. May import `free_vibration`, `uncertainty`, `modes`, `model`. Must never know a
//!   `job`.
//! - [`process`]: what the cut does at the tool tip along a path: deflection, vibration,
//!   chatter. May import `path`, `stability`, `excitation`, `job`, `uncertainty`, `modes`,
//!   `model`. Must never judge it.
//! - [`path`]: moves → poses in time; the arm surveyed and its modes followed along them. May
//!   import `modes`, `model`, `motion`. Must never know an `excitation`.
//! - [`free_vibration`]: the nonlinear equation of motion in time, and its spectrum: the check
//!   on `modes`. May import `modes`, `model`. Must never be used for a verdict.
//! - [`stability`]: modes of a tool tip and a cut → the depth at which it chatters. May import
//!   `excitation`, `job`. Must never know a robot: `model`, `modes`, `path`.
//! - [`excitation`]: spindle and tooth-passing lines; the cutting force and its spectrum. May
//!   import `job`. Must never know a `model`.
//! - [`job`]: what is asked for, as plain valid data. May import `model`, `motion`.
//! - [`uncertainty`]: what the parameters may be off by → intervals of frequencies, draws of
//!   the arm. May import `modes`, `model`. Must never know a `job`.
//! - [`modes`]: one pose → natural frequencies, shapes, damping, receptance; MAC. May import
//!   `model`. Must never know why it is asked.
//! - [`program`]: robot and CAM programs → moves, each with its line; programs with new speeds
//!   and feeds. May import `motion`. Must never know the robot's dynamics: `model`, `modes`.
//! - [`trace`]: video → tracks of marks, in pixels and frames. Must never know a robot or a
//!   millimetre.
//! - [`identify`]: records → spectra → modes with uncertainty; load tests → stiffness. Must
//!   never see a prediction: `model`, `modes`.
//! - [`model`]: the robot as built: M, K, kinematics; immutable. Must never know a `job` or a
//!   measurement.
//! - [`motion`]: moves, as plain valid data.
//! - [`formats`]: YAML and TOML as a tree with lines, edits that keep every other byte, tables,
//!   NPY, MAT, UFF, WAV, videos, bounded reading. Must never know a robot.
//! - [`guide`]: the guide, as pages of this documentation. Must never hold code.
//! - [`notes`]: errors and warnings: one type, one collector, every code. Everybody may import
//!   it.
//! - [`paths`]: folders and detours of paths, by their names. Everybody may import it.
//! - [`progress`]: how far long work has come. Everybody may import it.
//! - [`statistics`]: means, medians and bounds that several modules need. Everybody may import
//!   it.
//! - [`units`]: conversions. Everybody may import it.
//! - [`wording`]: what messages have in common. Everybody may import it.
//!
//! [`guide::library`] shows a whole check.

// Fuzzers compile the readers and what these import alone: a fifth of the work.
#[cfg(not(fuzzing))]
pub mod advice;
#[cfg(not(fuzzing))]
#[doc(hidden)]
pub mod cli;
#[cfg(not(fuzzing))]
pub mod diagnosis;
#[cfg(not(fuzzing))]
pub mod excitation;
#[cfg(not(fuzzing))]
pub mod formats;
#[cfg(not(fuzzing))]
pub mod free_vibration;
#[cfg(not(fuzzing))]
pub mod guide;
#[cfg(not(fuzzing))]
pub mod identify;
#[cfg(not(fuzzing))]
pub mod input;
#[cfg(not(fuzzing))]
pub mod job;
#[cfg(not(fuzzing))]
pub mod map;
#[cfg(not(fuzzing))]
pub mod model;
#[cfg(not(fuzzing))]
pub mod modes;
pub mod motion;
pub mod notes;
#[cfg(not(fuzzing))]
pub mod path;
#[cfg(not(fuzzing))]
pub mod paths;
#[cfg(not(fuzzing))]
pub mod process;
pub mod program;
pub mod progress;
#[cfg(not(fuzzing))]
pub mod report;
#[cfg(not(fuzzing))]
pub mod risk;
#[cfg(not(fuzzing))]
pub mod stability;
#[cfg(not(fuzzing))]
pub mod statistics;
#[cfg(not(fuzzing))]
pub mod study;
#[cfg(not(fuzzing))]
pub mod trace;
#[cfg(not(fuzzing))]
pub mod uncertainty;
pub mod units;
pub mod wording;
