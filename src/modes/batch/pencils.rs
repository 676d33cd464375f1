//! Pencils of given matrices on lanes, for those who change M and K themselves.

use fearless_simd::{Level, Simd, SimdBase, dispatch, prelude::*};
use nalgebra::DMatrix;

use super::inertia::packed;
use super::lanes::{Lanes, Mask, splat};
use super::rotations::{Eigenproblem, diagonalise, sort};
use crate::modes::pencil::{NO_INERTIA, Pencil};

/// Pencils K φ = ω² M φ of one size, solved side by side. [`Pencil`] is the readable reference, and
/// has the last word on those that this code is not made for: a K that is not diagonal, an M of
/// zeros.
#[derive(Debug, Clone)]
pub struct Pencils {
    n: usize,
    level: Level,
    /// Column by column, one n × n after the other.
    mass: Vec<f64>,
    stiffness: Vec<f64>,
    omega_squared: Vec<f64>,
    shapes: Vec<f64>,
}

impl Pencils {
    /// None yet, of n × n matrices.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            level: portable(),
            mass: Vec::new(),
            stiffness: Vec::new(),
            omega_squared: Vec::new(),
            shapes: Vec::new(),
        }
    }

    /// Adds a pencil of a symmetric M, positive semidefinite, and K, positive definite, both n × n.
    ///
    /// # Panics
    /// If they are not n × n.
    pub fn push(&mut self, mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) {
        assert_eq!([mass.shape(), stiffness.shape()], [(self.n, self.n); 2]);
        self.mass.extend_from_slice(mass.as_slice());
        self.stiffness.extend_from_slice(stiffness.as_slice());
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.mass.len() / (self.n * self.n).max(1)
    }

    /// Solves them all. `false` if one has no solution, as [`Pencil::solve`]; results are of no use
    /// then.
    pub fn solve(&mut self) -> bool {
        self.solve_with(self.n)
    }

    /// The same for [`Self::omega_squared`] alone, which is faster; no pencil has a
    /// [`Self::shape`] then.
    pub fn solve_values(&mut self) -> bool {
        self.solve_with(0)
    }

    /// With so many rows of the eigenvectors: all or none.
    fn solve_with(&mut self, rows: usize) -> bool {
        let (n, count) = (self.n, self.count());
        self.omega_squared.resize(count * n, 0.0);
        self.shapes.resize(count * n * rows, 0.0);
        let level = self.level;
        dispatch!(level, simd => self.solve_on(simd, rows))
    }

    /// ω_r² of pencil `i`, (rad/s)², ascending; infinite where a coordinate carries no inertia of
    /// its own.
    pub fn omega_squared(&self, i: usize) -> &[f64] {
        &self.omega_squared[i * self.n..(i + 1) * self.n]
    }

    /// φ_r of pencil `i`, mass-normalised; zero where ω_r² is infinite.
    pub fn shape(&self, i: usize, r: usize) -> &[f64] {
        let at = (i * self.n + r) * self.n;
        &self.shapes[at..at + self.n]
    }

    #[inline(always)]
    fn solve_on<S: Simd>(&mut self, simd: S, rows: usize) -> bool {
        let (n, count, lanes) = (self.n, self.count(), S::f64s::LEN);
        let mut block = Block::new(simd, n, rows);
        // Made only if a pencil needs it.
        let mut alone = None;
        for from in (0..count).step_by(lanes) {
            let here = lanes.min(count - from);
            let square = from * n * n..(from + here) * n * n;
            let doubtful = block.solve(&self.mass[square.clone()], &self.stiffness[square]);
            let mut doubtful = doubtful & (u64::MAX >> (64 - here));
            block.store(
                &mut self.omega_squared[from * n..(from + here) * n],
                &mut self.shapes[from * n * rows..(from + here) * n * rows],
            );
            while doubtful != 0 {
                let lane = doubtful.trailing_zeros() as usize;
                doubtful &= doubtful - 1;
                if !self.solve_alone(from + lane, &mut alone) {
                    return false;
                }
            }
        }
        true
    }

    /// One pencil by the scalar path.
    #[cold]
    #[inline(never)]
    fn solve_alone(&mut self, i: usize, pencil: &mut Option<Pencil>) -> bool {
        let n = self.n;
        let square = i * n * n..(i + 1) * n * n;
        let mass = DMatrix::from_column_slice(n, n, &self.mass[square.clone()]);
        let stiffness = DMatrix::from_column_slice(n, n, &self.stiffness[square.clone()]);
        let pencil = pencil.get_or_insert_with(|| Pencil::new(n));
        if !pencil.solve(&mass, &stiffness) {
            return false;
        }
        self.omega_squared[i * n..(i + 1) * n].copy_from_slice(&pencil.omega_squared);
        if let Some(shapes) = self.shapes.get_mut(square) {
            shapes.copy_from_slice(pencil.shapes.as_slice());
        }
        true
    }
}

/// The best level whose roots are those of every machine with fused multiplication. AVX-512 starts
/// them from an estimate of its own, and the last place decides which cause a diagnosis tries next.
fn portable() -> Level {
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = best.as_avx2() {
        return Level::Avx2(avx2);
    }
    best
}

/// Buffers for one pencil a lane.
struct Block<S: Simd> {
    simd: S,
    n: usize,
    /// Rows of the eigenvectors that are worked out: n or none.
    rows: usize,
    /// A = K^-½ M K^-½, upper triangle row by row.
    a: Vec<Lanes<S>>,
    t: Vec<Lanes<S>>,
    /// K^-½.
    scale: Vec<Lanes<S>>,
    identity: Vec<Lanes<S>>,
    /// What is turned along with A.
    turned: Vec<Lanes<S>>,
    vectors: Vec<Lanes<S>>,
    lambda: Vec<Lanes<S>>,
}

impl<S: Simd> Block<S> {
    fn new(simd: S, n: usize, rows: usize) -> Self {
        let zero = splat(simd, 0.0);
        let triangle = n * (n + 1) / 2;
        let mut identity = vec![zero; rows * n];
        for i in 0..rows {
            identity[i * n + i] = splat(simd, 1.0);
        }
        Self {
            simd,
            n,
            rows,
            a: vec![zero; triangle],
            t: vec![zero; triangle],
            scale: vec![zero; n],
            turned: identity.clone(),
            vectors: identity.clone(),
            identity,
            lambda: vec![zero; n],
        }
    }

    /// Solves at most one pencil a lane. The bits that are set mark those that the scalar path must
    /// look at.
    #[inline(always)]
    fn solve(&mut self, mass: &[f64], stiffness: &[f64]) -> u64 {
        let (simd, n) = (self.simd, self.n);
        let mut doubtful = self.load(mass, stiffness);
        self.turned.copy_from_slice(&self.identity);
        let mut problem = Eigenproblem {
            a: &mut self.a,
            v: &mut self.turned,
            rows: self.rows,
            t: &mut self.t,
            eigenvalues: &mut self.lambda,
            vectors: &mut self.vectors,
        };
        let none = Mask::<S>::splat(simd, false);
        doubtful |= !diagonalise(simd, n, &mut problem, none).to_bitmask();
        sort::<S>(&mut self.lambda, &mut self.vectors, self.rows);
        doubtful | !self.lambda[0].simd_gt(splat(simd, 0.0)).to_bitmask()
    }

    /// A by lane; lanes without a pencil, or with one that this code is not made for, have the
    /// identity. Gives the latter.
    #[inline(always)]
    fn load(&mut self, mass: &[f64], stiffness: &[f64]) -> u64 {
        let n = self.n;
        let mut doubtful = 0;
        for lane in 0..Lanes::<S>::LEN {
            let own = lane * n * n..(lane + 1) * n * n;
            let given = mass.get(own.clone()).zip(stiffness.get(own));
            let fit = given.filter(|(mass, stiffness)| is_plain(n, mass, stiffness));
            if given.is_some() && fit.is_none() {
                doubtful |= 1 << lane;
            }
            for i in 0..n {
                let scale = fit.map_or(1.0, |(_, stiffness)| 1.0 / stiffness[i * n + i].sqrt());
                self.scale[i].as_mut_slice()[lane] = scale;
            }
            for i in 0..n {
                for j in i..n {
                    let entry = match fit {
                        None => f64::from(u8::from(i == j)),
                        Some((mass, _)) => {
                            let [a, b] = [i, j].map(|i| self.scale[i].as_slice()[lane]);
                            mass[i * n + j] * a * b
                        }
                    };
                    self.a[packed(n, i, j)].as_mut_slice()[lane] = entry;
                }
            }
        }
        doubtful
    }

    /// ω² = 1/λ and φ = ω K^-½ y, pencil by pencil.
    #[inline(always)]
    fn store(&self, omega_squared: &mut [f64], shapes: &mut [f64]) {
        let n = self.n;
        for (lane, omega_squared) in omega_squared.chunks_exact_mut(n).enumerate() {
            let least = self.lambda[0].as_slice()[lane] * NO_INERTIA;
            for (omega_squared, lambda) in omega_squared.iter_mut().zip(&self.lambda) {
                let lambda = lambda.as_slice()[lane];
                *omega_squared = if lambda > least { 1.0 / lambda } else { f64::INFINITY };
            }
        }
        let pencils = omega_squared.chunks_exact(n).zip(shapes.chunks_exact_mut(n * n));
        for (lane, (omega_squared, shapes)) in pencils.enumerate() {
            for (r, shape) in shapes.chunks_exact_mut(n).enumerate() {
                if omega_squared[r].is_infinite() {
                    shape.fill(0.0);
                    continue;
                }
                let omega = omega_squared[r].sqrt();
                for (i, x) in shape.iter_mut().enumerate() {
                    let y = self.vectors[r * n + i].as_slice()[lane];
                    *x = y * self.scale[i].as_slice()[lane] * omega;
                }
            }
        }
    }
}

/// Whether K is diagonal and positive, and everything finite.
#[inline(always)]
fn is_plain(n: usize, mass: &[f64], stiffness: &[f64]) -> bool {
    let plain = |(k, &entry): (usize, &f64)| {
        if k % (n + 1) == 0 { entry > 0.0 && entry.is_finite() } else { entry == 0.0 }
    };
    mass.iter().all(|m| m.is_finite()) && stiffness.iter().enumerate().all(plain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Against the scalar path, of every size and for any number of pencils: some with a full K,
    /// some with a coordinate without inertia, some with two that are one.
    #[test]
    fn agree_with_the_scalar_path() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for n in 1..=12 {
            for count in [1, 7, 8, 19] {
                let mut pencils = Pencils::new(n);
                let mut expected = Vec::new();
                for i in 0..count {
                    let b = DMatrix::from_fn(n, n, |_, _| rng.random_range(-1.0..1.0));
                    let mut mass = &b * b.transpose() + DMatrix::from_diagonal_element(n, n, 0.1);
                    let mut stiffness =
                        DMatrix::from_fn(
                            n,
                            n,
                            |i, j| if i == j { 10f64.powi(i as i32) } else { 0.0 },
                        );
                    if i % 5 == 3 {
                        stiffness += &mass * 0.3;
                    }
                    if i % 5 == 2 && n > 1 {
                        // Two coordinates about one axis, of which one carries the other.
                        let own = mass.row(1).into_owned();
                        mass.row_mut(0).copy_from(&own);
                        let own = mass.column(1).into_owned();
                        mass.column_mut(0).copy_from(&own);
                    }
                    if i % 5 == 4 && n > 1 {
                        mass.row_mut(0).fill(0.0);
                        mass.column_mut(0).fill(0.0);
                    }
                    pencils.push(&mass, &stiffness);
                    let mut pencil = Pencil::new(n);
                    assert!(pencil.solve(&mass, &stiffness));
                    expected.push((mass, pencil));
                }
                let mut values = pencils.clone();
                assert!(pencils.solve() && values.solve_values());
                for (i, (mass, pencil)) in expected.iter().enumerate() {
                    for r in 0..n {
                        let (one, other) =
                            (values.omega_squared(i)[r], pencils.omega_squared(i)[r]);
                        assert!(one == other || (one / other - 1.0).abs() < 1e-11, "{one} {other}");
                        let (found, expected) =
                            (pencils.omega_squared(i)[r], pencil.omega_squared[r]);
                        if expected.is_infinite() {
                            assert!(found.is_infinite() && pencils.shape(i, r) == vec![0.0; n]);
                            continue;
                        }
                        assert!((found / expected - 1.0).abs() < 1e-11, "{n} {found} {expected}");
                        let shape = nalgebra::DVector::from_column_slice(pencils.shape(i, r));
                        let along = shape.dot(&(mass * pencil.shapes.column(r)));
                        assert!((along.abs() - 1.0).abs() < 1e-9, "{n}: {along}");
                        assert!((shape.dot(&(mass * &shape)) - 1.0).abs() < 1e-11);
                    }
                }
            }
        }
    }

    #[test]
    fn one_that_has_no_solution_is_told() {
        let one = DMatrix::from_element(1, 1, 1.0);
        for (mass, stiffness) in [(1.0, -1.0), (f64::NAN, 1.0), (1.0, f64::INFINITY), (0.0, 1.0)] {
            let mut pencils = Pencils::new(1);
            pencils.push(&one, &one);
            pencils.push(&(&one * mass), &(&one * stiffness));
            assert!(!pencils.solve(), "{mass} {stiffness}");
        }
    }

    /// The bits of machines with and without AVX-512, as one without gave them. Loops, which builds
    /// for debugging take, go through the pairs in another order.
    #[cfg(all(target_arch = "x86_64", not(debug_assertions)))]
    #[test]
    fn the_bits_are_those_of_every_machine_with_avx2() {
        if Level::new().as_avx2().is_none() {
            return;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut pencils = Pencils::new(3);
        for _ in 0..500 {
            let [a, b, c] = [0; 3].map(|_| rng.random_range(-1.0..1.0));
            let mass = DMatrix::from_row_slice(3, 3, &[3.0, a, b, a, 4.0, c, b, c, 5.0]);
            pencils.push(&mass, &DMatrix::from_diagonal_element(3, 3, rng.random_range(1.0..9.0)));
        }
        assert!(pencils.solve());
        let digest =
            |values: &[f64]| values.iter().fold(0, |sum: u64, x| sum.rotate_left(7) ^ x.to_bits());
        let found = [digest(&pencils.omega_squared), digest(&pencils.shapes)];
        assert_eq!(found, [0x0aa7_29e0_7214_bc3b, 0x8aa7_8a83_1d76_354a], "{found:#x?}");
    }
}
