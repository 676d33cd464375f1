//! Eigenvalues and vectors of small symmetric matrices on lanes, by Jacobi rotations without
//! divisions.
//!
//! Sizes up to [`MAX_UNROLLED`] run unrolled, in an order in which neighbouring rotations touch
//! different rows (round robin) so that they overlap in time; larger ones in loops, row by row.
//!
//! A lane stops by its own measure: once every rotation left to it is small, they are all made at
//! once by second-order perturbation, and its results are taken down; later sweeps, which other
//! lanes may need, do not touch them. So a pose has the same result to the last bit whoever its
//! neighbours are.

use fearless_simd::{Simd, SimdBase, SimdFloat, prelude::*};

use super::inertia::packed;
use super::lanes::{Lanes, Mask, inverse_root, rough_inverse, splat, turn_sign};

/// Matrices up to this size are solved by unrolled code.
pub(super) const MAX_UNROLLED: usize = 7;

/// Most values in the triangle and in the vectors of a matrix that is solved unrolled.
const UNROLLED_TRIANGLE: usize = MAX_UNROLLED * (MAX_UNROLLED + 1) / 2;
const UNROLLED_VECTORS: usize = MAX_UNROLLED * MAX_UNROLLED;

/// Sweeps before a lane is first asked whether it is done: enough for nearly all poses of six-axis
/// arms.
const SWEEPS_UNASKED: usize = 2;

/// The worst 24 × 24 case was seen to need five; a lane that is not done after these goes to the
/// scalar path.
const MAX_SWEEPS: usize = 30;

/// A rotation of this angle or less is small where only eigenvalues are asked for: what
/// second-order perturbation leaves out is its square times n² times an off-diagonal entry, below
/// the last place.
const SMALL_ANGLE: f64 = 3e-6;

/// Likewise where vectors are asked for, which come to the square of this.
const SMALL_ANGLE_OF_VECTORS: f64 = 1e-7;

/// Off-diagonal entries below this share of the geometric mean of their diagonal entries count as
/// zero.
const NEGLIGIBLE: f64 = f64::EPSILON * 0.25;

/// Keeps the root of a zero matrix from dividing by zero; far below any square that matters.
const TINY: f64 = 1e-290;

/// A rotation in one plane.
#[derive(Clone, Copy)]
struct Rotation<S: Simd> {
    cosine: Lanes<S>,
    sine: Lanes<S>,
    minus_sine: Lanes<S>,
    /// What the two diagonal entries exchange.
    exchange: Lanes<S>,
}

/// The rotation by at most 45° that annuls `apq` (Golub & Van Loan, Matrix Computations, 4th ed.,
/// §8.5.2), from two reciprocal roots: with d = aqq − app, b = 2 apq, h = √(d² + b²), p = |d| + h
/// it has cosine p/√(p² + b²), sine ±b/√(p² + b²), and ±b²/2p = sine² h is exchanged.
#[inline(always)]
fn annul<S: Simd>(simd: S, app: Lanes<S>, aqq: Lanes<S>, apq: Lanes<S>) -> Rotation<S> {
    let d = aqq - app;
    let b = apq + apq;
    let square = d.mul_add(d, b.mul_add(b, splat(simd, TINY)));
    let h = square * inverse_root(simd, square);
    let p = d.abs() + h;
    let g = inverse_root(simd, p.mul_add(p, b * b));
    let unsigned = b * g;
    let sine = turn_sign(simd, unsigned, d);
    Rotation { cosine: p * g, sine, minus_sine: -sine, exchange: sine * (unsigned * h) }
}

#[inline(always)]
fn turned<S: Simd>(r: &Rotation<S>, p: Lanes<S>, q: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    (r.minus_sine.mul_add(q, r.cosine * p), r.sine.mul_add(p, r.cosine * q))
}

/// t = apq / (aqq − app) where that is small, and whether it is: the angle itself, and the coupling
/// as a share of the geometric mean of the diagonal entries, which next to a far larger entry is
/// not small at a small angle.
#[inline(always)]
fn small_angle<S: Simd>(
    simd: S,
    app: Lanes<S>,
    aqq: Lanes<S>,
    apq: Lanes<S>,
    limit: f64,
) -> (Lanes<S>, Mask<S>) {
    let d = aqq - app;
    // An eigenvalue that is zero may be a little less.
    let (square, product) = (apq * apq, (app * aqq).abs());
    let weak = square.simd_le(product * splat(simd, limit * limit));
    let small = apq.abs().simd_le(d.abs() * splat(simd, limit));
    let nothing = square.simd_le(product * splat(simd, NEGLIGIBLE * NEGLIGIBLE));
    let t = nothing.select(splat(simd, 0.0), apq * rough_inverse(simd, d));
    (t, (small & weak) | nothing)
}

/// Calls `$step!(p, q)` for every pair p < q < `$n`. Where `$unrolled`, the constant size, is not
/// zero: one by one, in an order in which neighbours share no row.
macro_rules! every_pair {
    ($unrolled:expr, $n:expr, $step:ident) => {
        match $unrolled {
            1 => {}
            2 => {
                $step!(0, 1);
            }
            3 => {
                $step!(1, 2);
                $step!(0, 2);
                $step!(0, 1);
            }
            4 => {
                $step!(0, 3);
                $step!(1, 2);
                $step!(0, 2);
                $step!(1, 3);
                $step!(0, 1);
                $step!(2, 3);
            }
            5 => {
                $step!(1, 4);
                $step!(2, 3);
                $step!(0, 4);
                $step!(1, 2);
                $step!(0, 3);
                $step!(2, 4);
                $step!(0, 2);
                $step!(1, 3);
                $step!(0, 1);
                $step!(3, 4);
            }
            6 => {
                $step!(0, 5);
                $step!(1, 4);
                $step!(2, 3);
                $step!(0, 4);
                $step!(3, 5);
                $step!(1, 2);
                $step!(0, 3);
                $step!(2, 4);
                $step!(1, 5);
                $step!(0, 2);
                $step!(1, 3);
                $step!(4, 5);
                $step!(0, 1);
                $step!(2, 5);
                $step!(3, 4);
            }
            7 => {
                $step!(1, 6);
                $step!(2, 5);
                $step!(3, 4);
                $step!(0, 6);
                $step!(1, 4);
                $step!(2, 3);
                $step!(0, 5);
                $step!(4, 6);
                $step!(1, 2);
                $step!(0, 4);
                $step!(3, 5);
                $step!(2, 6);
                $step!(0, 3);
                $step!(2, 4);
                $step!(1, 5);
                $step!(0, 2);
                $step!(1, 3);
                $step!(5, 6);
                $step!(0, 1);
                $step!(3, 6);
                $step!(4, 5);
            }
            _ => {
                for p in 0..$n {
                    for q in p + 1..$n {
                        $step!(p, q);
                    }
                }
            }
        }
    };
}

/// A symmetric matrix on its way to its eigenvalues. N is its size where the code is unrolled, and
/// zero where the size is only known as `n`.
struct System<'a, S: Simd, const N: usize> {
    simd: S,
    n: usize,
    /// Rows of `v`.
    rows: usize,
    /// Upper triangle, row by row.
    a: &'a mut [Lanes<S>],
    /// Turned along with the matrix, column by column.
    v: &'a mut [Lanes<S>],
    /// Angles of the last small rotations, as `a`.
    t: &'a mut [Lanes<S>],
    eigenvalues: &'a mut [Lanes<S>],
    vectors: &'a mut [Lanes<S>],
}

impl<S: Simd, const N: usize> System<'_, S, N> {
    #[inline(always)]
    fn size(&self) -> usize {
        if N == 0 { self.n } else { N }
    }

    /// Where entry (i, j) of the triangle lies, in either order.
    #[inline(always)]
    fn at(&self, i: usize, j: usize) -> usize {
        packed(self.size(), i.min(j), i.max(j))
    }

    #[inline(always)]
    fn rotate(&mut self, p: usize, q: usize) {
        let (pp, qq, pq) = (self.at(p, p), self.at(q, q), self.at(p, q));
        let r = annul(self.simd, self.a[pp], self.a[qq], self.a[pq]);
        self.a[pp] -= r.exchange;
        self.a[qq] += r.exchange;
        self.a[pq] = splat(self.simd, 0.0);
        for k in 0..self.size() {
            if k != p && k != q {
                let (kp, kq) = (self.at(k, p), self.at(k, q));
                (self.a[kp], self.a[kq]) = turned(&r, self.a[kp], self.a[kq]);
            }
        }
        for k in 0..self.rows {
            let (kp, kq) = (p * self.rows + k, q * self.rows + k);
            (self.v[kp], self.v[kq]) = turned(&r, self.v[kp], self.v[kq]);
        }
    }

    #[inline(always)]
    fn sweep(&mut self) {
        macro_rules! step {
            ($p:expr, $q:expr) => {
                self.rotate($p, $q)
            };
        }
        every_pair!(N, self.n, step);
    }

    /// Makes the rotations of lanes that have only small ones left and takes down what comes of
    /// them, but for lanes that are `done` already. Gives the lanes that are done now.
    #[inline(always)]
    fn finish(&mut self, done: Mask<S>) -> Mask<S> {
        let simd = self.simd;
        let limit = if self.rows == 0 { SMALL_ANGLE } else { SMALL_ANGLE_OF_VECTORS };
        let mut small_all = Mask::<S>::splat(simd, true);
        macro_rules! look {
            ($p:expr, $q:expr) => {{
                let (pp, qq, pq) = (self.at($p, $p), self.at($q, $q), self.at($p, $q));
                let (t, small) = small_angle(simd, self.a[pp], self.a[qq], self.a[pq], limit);
                self.t[pq] = t;
                small_all &= small;
            }};
        }
        every_pair!(N, self.n, look);
        let now = small_all & !done;
        let zero = splat(simd, 0.0);
        macro_rules! exchange {
            ($p:expr, $q:expr) => {{
                let (pp, qq, pq) = (self.at($p, $p), self.at($q, $q), self.at($p, $q));
                let t = now.select(self.t[pq], zero);
                // apq tan θ, to second order in the angle.
                let exchange = self.a[pq] * (-(t * t)).mul_add(t, t);
                self.a[pp] -= exchange;
                self.a[qq] += exchange;
                for k in 0..self.rows {
                    let (kp, kq) = ($p * self.rows + k, $q * self.rows + k);
                    let (at_p, at_q) = (self.v[kp], self.v[kq]);
                    self.v[kp] = (-t).mul_add(at_q, at_p);
                    self.v[kq] = t.mul_add(at_p, at_q);
                }
            }};
        }
        every_pair!(N, self.n, exchange);
        for i in 0..self.size() {
            self.eigenvalues[i] = now.select(self.a[self.at(i, i)], self.eigenvalues[i]);
        }
        for k in 0..self.size() * self.rows {
            self.vectors[k] = now.select(self.v[k], self.vectors[k]);
        }
        done | small_all
    }

    /// Sweeps until every lane is done, `bad` lanes apart. Gives the lanes that are done, or bad.
    #[inline(always)]
    fn solve(&mut self, bad: Mask<S>) -> Mask<S> {
        let mut done = bad;
        for sweep in 1..=MAX_SWEEPS {
            self.sweep();
            if sweep >= SWEEPS_UNASKED {
                done = self.finish(done);
                if done.all_true() {
                    break;
                }
            }
        }
        done
    }
}

/// A matrix to be diagonalised, what is turned along with it, and where the results go.
pub(super) struct Eigenproblem<'a, S: Simd> {
    /// Upper triangle, row by row.
    pub(super) a: &'a mut [Lanes<S>],
    /// Column by column, `rows` entries each.
    pub(super) v: &'a mut [Lanes<S>],
    pub(super) rows: usize,
    /// Room for a triangle.
    pub(super) t: &'a mut [Lanes<S>],
    /// In no order.
    pub(super) eigenvalues: &'a mut [Lanes<S>],
    /// `v`, turned: the eigenvectors where it was the identity.
    pub(super) vectors: &'a mut [Lanes<S>],
}

/// Solves N × N problems in registers as far as these go. Gives the lanes that are done, `bad` ones
/// among them.
#[inline(always)]
fn solve_unrolled<S: Simd, const N: usize, const ROWS: usize>(
    simd: S,
    problem: &mut Eigenproblem<S>,
    bad: Mask<S>,
) -> Mask<S> {
    let zero = splat(simd, 0.0);
    let mut a = [zero; UNROLLED_TRIANGLE];
    let mut v = [zero; UNROLLED_VECTORS];
    let mut t = [zero; UNROLLED_TRIANGLE];
    let (triangle, square) = (N * (N + 1) / 2, N * ROWS);
    a[..triangle].copy_from_slice(&problem.a[..triangle]);
    v[..square].copy_from_slice(&problem.v[..square]);
    let eigenvalues = &mut problem.eigenvalues[..N];
    let vectors = &mut problem.vectors[..square];
    System::<S, N> { simd, n: N, rows: ROWS, a: &mut a, v: &mut v, t: &mut t, eigenvalues, vectors }
        .solve(bad)
}

/// The same for problems of any size.
#[inline(always)]
fn solve_looped<S: Simd>(
    simd: S,
    n: usize,
    problem: &mut Eigenproblem<S>,
    bad: Mask<S>,
) -> Mask<S> {
    let Eigenproblem { a, v, rows, t, eigenvalues, vectors } = problem;
    System::<S, 0> { simd, n, rows: *rows, a, v, t, eigenvalues, vectors }.solve(bad)
}

/// Eigenvalues of A, with v turned along, n the size. Gives the lanes that are done, `bad` ones
/// among them.
#[inline(always)]
pub(super) fn diagonalise<S: Simd>(
    simd: S,
    n: usize,
    problem: &mut Eigenproblem<S>,
    bad: Mask<S>,
) -> Mask<S> {
    if const { unrolls::<S>() } && (2..=MAX_UNROLLED).contains(&n) {
        match n {
            2 => unrolled::<S, 2>(simd, problem, bad),
            3 => unrolled::<S, 3>(simd, problem, bad),
            4 => unrolled::<S, 4>(simd, problem, bad),
            5 => unrolled::<S, 5>(simd, problem, bad),
            6 => unrolled::<S, 6>(simd, problem, bad),
            _ => unrolled::<S, 7>(simd, problem, bad),
        }
    } else {
        looped(simd, n, problem, bad)
    }
}

/// Unrolled code takes minutes to compile: not worth it in builds for debugging, nor for two lanes
/// on x86-64, which are for machines without AVX2.
#[inline(always)]
const fn unrolls<S: Simd>() -> bool {
    !cfg!(debug_assertions) && (Lanes::<S>::LEN > 2 || !cfg!(target_arch = "x86_64"))
}

/// The number of coordinates of most arms: whole eigenvectors of others are worked out by loops, as
/// unrolled code for each would take as long to compile as everything else.
const COMMON: usize = 6;

/// One function for each number of rows that occurs, so that each is a constant to it.
#[inline(always)]
fn unrolled<S: Simd, const N: usize>(
    simd: S,
    problem: &mut Eigenproblem<S>,
    bad: Mask<S>,
) -> Mask<S> {
    match problem.rows {
        0 => simd.vectorize(
            #[inline(always)]
            || solve_unrolled::<S, N, 0>(simd, problem, bad),
        ),
        3 => simd.vectorize(
            #[inline(always)]
            || solve_unrolled::<S, N, 3>(simd, problem, bad),
        ),
        _ if N == COMMON => simd.vectorize(
            #[inline(always)]
            || solve_unrolled::<S, N, N>(simd, problem, bad),
        ),
        _ => looped(simd, N, problem, bad),
    }
}

#[inline(always)]
fn looped<S: Simd>(simd: S, n: usize, problem: &mut Eigenproblem<S>, bad: Mask<S>) -> Mask<S> {
    simd.vectorize(
        #[inline(always)]
        || solve_looped(simd, n, problem, bad),
    )
}

/// Ascending frequencies: descending eigenvalues, each with its `width` entries of `rows`.
#[inline(always)]
pub(super) fn sort<S: Simd>(lambda: &mut [Lanes<S>], rows: &mut [Lanes<S>], width: usize) {
    for i in 1..lambda.len() {
        for j in (1..=i).rev() {
            let wrong = lambda[j].simd_gt(lambda[j - 1]);
            exchange::<S>(wrong, lambda, j - 1, j);
            for k in 0..width {
                exchange::<S>(wrong, rows, (j - 1) * width + k, j * width + k);
            }
        }
    }
}

/// Exchanges two values in the lanes that are set.
#[inline(always)]
fn exchange<S: Simd>(lanes: Mask<S>, values: &mut [Lanes<S>], a: usize, b: usize) {
    let (at_a, at_b) = (values[a], values[b]);
    values[a] = lanes.select(at_b, at_a);
    values[b] = lanes.select(at_a, at_b);
}
