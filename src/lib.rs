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
//! `cli` prints. `tests/house` reads this table and holds the code against it.
//!
//! | module | what lives there | may import | must never |
//! |---|---|---|---|
//! | [`cli`] | one file a verb: arguments, files, progress | `study`, `report` | decide anything that a library user would miss |
//! | [`report`] | text, JSON, tables, pages, plots and what build servers read: pure functions from results | `study`, `advice`, `risk`, `diagnosis`, `map`, `process`, `identify`, `free_vibration`, `stability`, `excitation`, `job`, `formats` | call a function of another module |
//! | [`study`] | one function a verb: valid inputs → a result that holds all that is shown, and what is written back | `input`, `advice`, `risk`, `diagnosis`, `map`, `process`, `path`, `free_vibration`, `trace`, `identify`, `stability`, `excitation`, `job`, `uncertainty`, `modes`, `program`, `model`, `motion` | print, read or write files |
//! | [`input`] | YAML, URDF, tables, records, videos → valid types, all faults with file and line | `job`, `program`, `trace`, `identify`, `model`, `motion`, `formats` | compute |
//! | [`advice`] | safe speeds, the best of them, schedules, other levers, vibration of the tool tip | `risk`, `process`, `path`, `stability`, `excitation`, `job`, `uncertainty`, `modes`, `model`, `motion` | print |
//! | [`risk`] | bands, crossings, limits on the tool tip, certainty, verdict | `process`, `path`, `excitation`, `job`, `uncertainty`, `modes`, `model`, `motion` | choose a remedy |
//! | [`diagnosis`] | where prediction and measurement meet: residuals, causes (one a file), fits, choice, gain, next poses | `uncertainty`, `modes`, `identify`, `model` | name a cause that it has not compared with its rivals |
//! | [`map`] | frequencies over given poses, grids and random poses, linear or nonlinear; their figures | `free_vibration`, `uncertainty`, `modes`, `model` | know a `job` |
//! | [`process`] | what the cut does at the tool tip along a path: deflection, vibration, chatter | `path`, `stability`, `excitation`, `job`, `uncertainty`, `modes`, `model` | judge it |
//! | [`path`] | moves → poses in time; the arm surveyed and its modes followed along them | `modes`, `model`, `motion` | know an `excitation` |
//! | [`free_vibration`] | the nonlinear equation of motion in time, and its spectrum: the check on `modes` | `modes`, `model` | be used for a verdict |
//! | [`stability`] | modes of a tool tip and a cut → the depth at which it chatters | `excitation`, `job` | know a robot: `model`, `modes`, `path` |
//! | [`excitation`] | spindle and tooth-passing lines; the cutting force and its spectrum | `job` | know a `model` |
//! | [`job`] | what is asked for, as plain valid data | `model`, `motion` | |
//! | [`uncertainty`] | what the parameters may be off by → intervals of frequencies, draws of the arm | `modes`, `model` | know a `job` |
//! | [`modes`] | one pose → natural frequencies, shapes, damping, receptance; MAC | `model` | know why it is asked |
//! | [`program`] | robot and CAM programs → moves, each with its line; programs with new speeds and feeds | `motion` | know the robot's dynamics: `model`, `modes` |
//! | [`trace`] | video → tracks of marks, in pixels and frames | | know a robot or a millimetre |
//! | [`identify`] | records → spectra → modes with uncertainty; load tests → stiffness | | see a prediction: `model`, `modes` |
//! | [`model`] | the robot as built: M, K, kinematics; immutable | | know a `job` or a measurement |
//! | [`motion`] | moves, as plain valid data | | |
//! | [`formats`] | YAML and TOML as a tree with lines, edits that keep every other byte, tables, NPY, MAT, UFF, WAV, videos, bounded reading | | know a robot |
//! | [`guide`] | the guide, as pages of this documentation | | hold code |
//! | [`notes`] | errors and warnings: one type, one collector, every code | *ground* | |
//! | [`paths`] | folders and detours of paths, by their names | *ground* | |
//! | [`progress`] | how far long work has come | *ground* | |
//! | [`statistics`] | means, medians and bounds that several modules need | *ground* | |
//! | [`units`] | conversions | *ground* | |
//! | [`wording`] | what messages have in common | *ground* | |
//!
//! What stands at the ground may be imported by all.
//!
//! [`guide::library`] shows a whole check.

pub mod advice;
#[doc(hidden)]
pub mod cli;
pub mod diagnosis;
pub mod excitation;
pub mod formats;
pub mod free_vibration;
pub mod guide;
pub mod identify;
pub mod input;
pub mod job;
pub mod map;
pub mod model;
pub mod modes;
pub mod motion;
pub mod notes;
pub mod path;
pub mod paths;
pub mod process;
pub mod program;
pub mod progress;
pub mod report;
pub mod risk;
pub mod stability;
pub mod statistics;
pub mod study;
pub mod trace;
pub mod uncertainty;
pub mod units;
pub mod wording;
