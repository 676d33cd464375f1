//! Many poses → natural frequencies, modes and tip participation: the batch kernel.
//!
//! One pose a lane of the machine's vectors, as many as it has: eight with AVX-512, four with AVX2,
//! two with SSE2 or NEON, chosen when the [`Kernel`] is made. What does not depend on the pose is
//! worked out once, in a plan of the robot; M(q) and J(q) follow by composite bodies in the bodies'
//! own frames, and the eigenproblem A y = λ y, A = K^-½ M K^-½, λ = 1/ω², by Jacobi rotations
//! without divisions.
//!
//! A pose's result depends on the pose alone: not on its neighbours, not on how many poses there
//! are, not on the number of threads. It does depend on the instruction set in the last digits, as
//! multiplications and additions are fused where the machine can.
//!
//! [`super::ModalSolver`] is the readable reference; it also has the last word on every pose that
//! this code is not made for, such as one with a singular mass matrix or springs that follow the
//! load, so that faults are the same.

mod block;
mod inertia;
mod lanes;
mod pencils;
mod plan;
mod rotations;

use std::fmt;

use fearless_simd::{Simd, SimdBase, dispatch};
use nalgebra::{Matrix6xX, Point3};
use rayon::prelude::*;

use self::block::{Block, Results, Wanted};
pub use self::pencils::Pencils;
use self::plan::Plan;
use super::{ModalSolver, peak_tip_compliances_m_per_n};
use crate::model::{PoseFault, Robot, elastic_jacobian};

/// Poses that one thread takes at a time: a multiple of every number of lanes.
const CHUNK: usize = 1024;

/// Which of the machine's vector instructions to use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum InstructionSet {
    /// What every machine of the build's target has: SSE2 on x86-64, NEON on ARM.
    Baseline,
    /// AVX2 with fused multiplication and addition, four poses at a time.
    Avx2,
    /// AVX-512 (of Ice Lake and later, Zen 4 and later), eight poses at a time.
    Avx512,
    /// The best that the machine has.
    #[default]
    Best,
}

impl InstructionSet {
    /// The sets that this machine has, weakest first.
    pub fn available() -> Vec<Self> {
        [Self::Baseline, Self::Avx2, Self::Avx512]
            .into_iter()
            .filter(|set| set.level().is_some())
            .collect()
    }

    /// Proof that the machine has the set.
    fn level(self) -> Option<fearless_simd::Level> {
        #[cfg(target_arch = "x86_64")]
        {
            use fearless_simd::Level;
            let best = Level::new();
            match self {
                Self::Baseline => Some(Level::baseline()),
                Self::Avx2 => best.as_avx2().map(Level::Avx2),
                Self::Avx512 => best.as_avx512().map(Level::Avx512),
                Self::Best => Some(best),
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        match self {
            Self::Avx2 | Self::Avx512 => None,
            Self::Baseline | Self::Best => Some(fearless_simd::Level::baseline()),
        }
    }
}

/// Why a batch was not solved.
#[derive(Debug, Clone, PartialEq)]
pub enum BatchFault {
    /// The values given are no whole number of poses.
    Poses {
        /// Values given.
        given: usize,
        /// Values in one pose.
        joints: usize,
    },
    /// The room for results does not fit the poses.
    Room {
        /// Values that an output holds.
        given: usize,
        /// Values that it must hold.
        expected: usize,
    },
    /// A pose has no modes: the first one of the batch that has none.
    Pose {
        /// Its place in the batch, from zero.
        pose: usize,
        /// The fault of the scalar path.
        fault: PoseFault,
    },
}

impl fmt::Display for BatchFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Poses { given, joints } => write!(
                f,
                "{given} joint positions given, must be a multiple of {joints}, one per moving \
                 joint"
            ),
            Self::Room { given, expected } => {
                write!(f, "room for {given} results given, must be {expected}")
            }
            Self::Pose { pose, fault } => write!(f, "pose {}: {fault}", pose + 1),
        }
    }
}

impl std::error::Error for BatchFault {}

/// Where [`Kernel::modes`] puts its results, n elastic coordinates.
#[derive(Debug)]
pub struct ModesOut<'a> {
    /// f_r, Hz, ascending: n a pose.
    pub natural_frequencies_hz: &'a mut [f64],
    /// φ_r, mass-normalised and signed as [`super::Modes::shapes`], mode after mode: n × n a pose.
    pub shapes: &'a mut [f64],
    /// ζ_r: n a pose.
    pub damping_ratios: &'a mut [f64],
}

/// Where [`Kernel::tip`] puts its results, n elastic coordinates.
#[derive(Debug)]
pub struct TipOut<'a> {
    /// f_r, Hz, ascending: n a pose.
    pub natural_frequencies_hz: &'a mut [f64],
    /// |J φ_r|² / 2 ζ_r ω_r² ([`peak_tip_compliances_m_per_n`]): n a pose.
    pub peak_compliances_m_per_n: &'a mut [f64],
}

/// Solves poses of one robot by the batch; immutable, and shared between threads as it is.
#[derive(Debug, Clone)]
pub struct Kernel<'a> {
    robot: &'a Robot,
    plan: Plan,
    level: fearless_simd::Level,
}

impl<'a> Kernel<'a> {
    /// A kernel for `robot` with the machine's best instructions.
    pub fn new(robot: &'a Robot) -> Self {
        Self { robot, plan: Plan::new(robot), level: fearless_simd::Level::new() }
    }

    /// A kernel for `robot` with the instructions that are asked for; `None` where the machine
    /// lacks them.
    pub fn with_instructions(robot: &'a Robot, set: InstructionSet) -> Option<Self> {
        Some(Self { robot, plan: Plan::new(robot), level: set.level()? })
    }

    /// Poses that are solved side by side.
    pub fn lanes(&self) -> usize {
        dispatch!(self.level, simd => lanes_of(simd))
    }

    /// Natural frequencies, Hz, ascending: n values a pose into `out`.
    ///
    /// `poses` has one value per moving joint (rad or m, base to tip), pose after pose.
    ///
    /// # Errors
    /// The first pose that has no modes, as [`ModalSolver::frequencies_hz`]; [`BatchFault::Poses`]
    /// and [`BatchFault::Room`] where the length of `poses` or `out` does not fit. `out` holds
    /// nothing of use then.
    pub fn frequencies_hz(&self, poses: &[f64], out: &mut [f64]) -> Result<(), BatchFault> {
        self.run(poses, Wanted::Frequencies, frequencies_of(out))
    }

    /// [`Self::frequencies_hz`] on all threads of rayon's pool, to the same bits.
    ///
    /// # Errors
    /// As [`Self::frequencies_hz`].
    pub fn par_frequencies_hz(&self, poses: &[f64], out: &mut [f64]) -> Result<(), BatchFault> {
        self.par_run(poses, Wanted::Frequencies, frequencies_of(out))
    }

    /// Natural frequencies, mode shapes and damping ratios.
    ///
    /// # Errors
    /// As [`Self::frequencies_hz`].
    pub fn modes(&self, poses: &[f64], out: ModesOut) -> Result<(), BatchFault> {
        self.run(poses, Wanted::Modes, modes_of(out))
    }

    /// [`Self::modes`] on all threads of rayon's pool, to the same bits.
    ///
    /// # Errors
    /// As [`Self::frequencies_hz`].
    pub fn par_modes(&self, poses: &[f64], out: ModesOut) -> Result<(), BatchFault> {
        self.par_run(poses, Wanted::Modes, modes_of(out))
    }

    /// Natural frequencies, and what each mode moves the point `tcp_m` of the tip frame at its
    /// resonance.
    ///
    /// # Errors
    /// As [`Self::frequencies_hz`].
    pub fn tip(&self, poses: &[f64], tcp_m: &Point3<f64>, out: TipOut) -> Result<(), BatchFault> {
        self.run(poses, self.wanted_at(tcp_m), tip_of(out))
    }

    /// [`Self::tip`] on all threads of rayon's pool, to the same bits.
    ///
    /// # Errors
    /// As [`Self::frequencies_hz`].
    pub fn par_tip(
        &self,
        poses: &[f64],
        tcp_m: &Point3<f64>,
        out: TipOut,
    ) -> Result<(), BatchFault> {
        self.par_run(poses, self.wanted_at(tcp_m), tip_of(out))
    }

    fn wanted_at(&self, tcp_m: &Point3<f64>) -> Wanted {
        Wanted::Tip { tool: self.plan.tool_point(tcp_m), tcp_m: *tcp_m }
    }

    fn run(&self, poses: &[f64], wanted: Wanted, mut results: Results) -> Result<(), BatchFault> {
        let count = self.count(poses, wanted, &results)?;
        self.run_piece(poses, count, wanted, &mut results)
    }

    fn par_run(&self, poses: &[f64], wanted: Wanted, results: Results) -> Result<(), BatchFault> {
        let count = self.count(poses, wanted, &results)?;
        let joints = self.plan.joints;
        let faults: Vec<BatchFault> = results
            .chunks(CHUNK, self.n())
            .into_par_iter()
            .enumerate()
            .filter_map(|(i, mut results)| {
                let (from, to) = (i * CHUNK, count.min((i + 1) * CHUNK));
                let poses = &poses[from * joints..to * joints];
                let outcome = self.run_piece(poses, to - from, wanted, &mut results);
                outcome.err().map(|fault| fault.after(from))
            })
            .collect();
        faults.into_iter().next().map_or(Ok(()), Err)
    }

    fn n(&self) -> usize {
        self.plan.coordinates.len()
    }

    /// How many poses there are, if everything fits.
    fn count(&self, poses: &[f64], wanted: Wanted, out: &Results) -> Result<usize, BatchFault> {
        let (n, joints) = (self.n(), self.plan.joints);
        let count = match joints {
            // Nothing but extra coordinates: the room alone says how many.
            0 => out.frequencies_hz.len() / n,
            _ => poses.len() / joints,
        };
        if poses.len() != count * joints {
            return Err(BatchFault::Poses { given: poses.len(), joints });
        }
        let is_wanted = |yes: bool| if yes { count } else { 0 };
        let (modes, tip) =
            (is_wanted(wanted == Wanted::Modes), is_wanted(matches!(wanted, Wanted::Tip { .. })));
        for (given, expected) in [
            (out.frequencies_hz.len(), count * n),
            (out.shapes.len(), modes * n * n),
            (out.damping_ratios.len(), modes * n),
            (out.compliances_m_per_n.len(), tip * n),
        ] {
            if given != expected {
                return Err(BatchFault::Room { given, expected });
            }
        }
        Ok(count)
    }

    /// The one place where the code for a robot is made for each instruction set: it takes long to
    /// compile.
    #[inline(never)]
    fn run_piece(
        &self,
        poses: &[f64],
        count: usize,
        wanted: Wanted,
        results: &mut Results,
    ) -> Result<(), BatchFault> {
        dispatch!(self.level, simd => self.run_on(simd, poses, count, wanted, results))
    }

    #[inline(always)]
    fn run_on<S: Simd>(
        &self,
        simd: S,
        poses: &[f64],
        count: usize,
        wanted: Wanted,
        results: &mut Results,
    ) -> Result<(), BatchFault> {
        let (n, joints, lanes) = (self.n(), self.plan.joints, S::f64s::LEN);
        let mut block = Block::new(simd, &self.plan);
        // Made only if a pose needs it.
        let mut scalar = None;
        let is_tip = matches!(wanted, Wanted::Tip { .. });
        let is_scalar = self.plan.has_varying_springs || is_tip && self.plan.has_hung_parts;
        for from in (0..count).step_by(lanes) {
            let here = lanes.min(count - from);
            let rows = &poses[from * joints..(from + here) * joints];
            let mut results = results.part(from, here, n);
            let mut doubtful =
                if is_scalar { !0 } else { block.solve(rows, here, wanted, &mut results) };
            while doubtful != 0 {
                let lane = doubtful.trailing_zeros() as usize;
                doubtful &= doubtful - 1;
                if lane < here {
                    let solver = scalar.get_or_insert_with(|| ModalSolver::new(self.robot));
                    let q = &rows[lane * joints..(lane + 1) * joints];
                    solve_alone(self.robot, solver, q, wanted, &mut results.part(lane, 1, n))
                        .map_err(|fault| BatchFault::Pose { pose: from + lane, fault })?;
                }
            }
        }
        Ok(())
    }
}

impl BatchFault {
    /// The same of a batch that has `poses` more before it.
    fn after(self, poses: usize) -> Self {
        match self {
            Self::Pose { pose, fault } => Self::Pose { pose: pose + poses, fault },
            Self::Poses { .. } | Self::Room { .. } => self,
        }
    }
}

/// One pose by the scalar path.
#[cold]
#[inline(never)]
fn solve_alone(
    robot: &Robot,
    solver: &mut ModalSolver,
    q: &[f64],
    wanted: Wanted,
    results: &mut Results,
) -> Result<(), PoseFault> {
    if wanted == Wanted::Frequencies {
        results.frequencies_hz.copy_from_slice(solver.frequencies_hz(q)?);
        return Ok(());
    }
    solver.solve(q)?;
    let modes = solver.modes();
    results.frequencies_hz.copy_from_slice(&modes.natural_frequencies_hz);
    if let Wanted::Tip { tcp_m, .. } = wanted {
        let mut jacobian = Matrix6xX::zeros(modes.natural_frequencies_hz.len());
        elastic_jacobian(robot, solver.placement(), &tcp_m, &mut jacobian);
        let out = &mut results.compliances_m_per_n;
        peak_tip_compliances_m_per_n(robot, modes, &jacobian, out);
    } else {
        results.shapes.copy_from_slice(modes.shapes.as_slice());
        results.damping_ratios.copy_from_slice(&modes.damping_ratios);
    }
    Ok(())
}

#[inline(always)]
fn lanes_of<S: Simd>(_: S) -> usize {
    S::f64s::LEN
}

fn frequencies_of(frequencies_hz: &mut [f64]) -> Results<'_> {
    Results {
        frequencies_hz,
        shapes: &mut [],
        damping_ratios: &mut [],
        compliances_m_per_n: &mut [],
    }
}

fn modes_of(out: ModesOut<'_>) -> Results<'_> {
    Results {
        frequencies_hz: out.natural_frequencies_hz,
        shapes: out.shapes,
        damping_ratios: out.damping_ratios,
        compliances_m_per_n: &mut [],
    }
}

fn tip_of(out: TipOut<'_>) -> Results<'_> {
    Results {
        frequencies_hz: out.natural_frequencies_hz,
        shapes: &mut [],
        damping_ratios: &mut [],
        compliances_m_per_n: out.peak_compliances_m_per_n,
    }
}
