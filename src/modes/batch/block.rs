//! One block of poses, one a lane: from joint positions to frequencies, shapes, damping and what
//! the tool does.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, prelude::*};

use nalgebra::Point3;

use super::inertia::{Assembly, packed};
use super::lanes::{Lanes, MAX_ANGLE_RAD, Mask, inverse_root, splat};
use super::plan::Plan;
use super::rotations::{Eigenproblem, MAX_UNROLLED, diagonalise, sort};
use crate::units::hz_from_rad_per_s;

/// A pivot of the scaled mass or stiffness matrix below this share of its diagonal entry sends a
/// pose to the scalar path, which decides: ten times the share at which that calls the matrix
/// singular.
const SUSPECT_PIVOT: f64 = 1e-12;

/// The determinant of M over the product of its diagonal above which no pivot is suspect.
const SURE_DETERMINANT: f64 = 1e-11;

/// What is asked of the poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Wanted {
    Frequencies,
    /// With shapes and damping.
    Modes,
    /// With the compliance of a point: of the tip's node, and the same of the tip frame.
    Tip {
        tool: [f64; 3],
        tcp_m: Point3<f64>,
    },
}

/// Where the results of some poses go; rows of what is not wanted are empty.
pub(super) struct Results<'a> {
    /// n a pose.
    pub(super) frequencies_hz: &'a mut [f64],
    /// n × n a pose, mode by mode.
    pub(super) shapes: &'a mut [f64],
    /// n a pose.
    pub(super) damping_ratios: &'a mut [f64],
    /// n a pose.
    pub(super) compliances_m_per_n: &'a mut [f64],
}

impl Results<'_> {
    /// Those of `count` poses from `from` on, n coordinates.
    #[inline(always)]
    pub(super) fn part(&mut self, from: usize, count: usize, n: usize) -> Results<'_> {
        Results {
            frequencies_hz: part(self.frequencies_hz, from, count, n),
            shapes: part(self.shapes, from, count, n * n),
            damping_ratios: part(self.damping_ratios, from, count, n),
            compliances_m_per_n: part(self.compliances_m_per_n, from, count, n),
        }
    }
}

impl<'a> Results<'a> {
    /// Pieces of `poses` poses, the last one shorter.
    pub(super) fn chunks(self, poses: usize, n: usize) -> Vec<Results<'a>> {
        let count = self.frequencies_hz.len().div_ceil(poses * n);
        let mut frequencies = self.frequencies_hz.chunks_mut(poses * n);
        let mut shapes = self.shapes.chunks_mut(poses * n * n);
        let mut damping = self.damping_ratios.chunks_mut(poses * n);
        let mut compliances = self.compliances_m_per_n.chunks_mut(poses * n);
        (0..count)
            .map(|_| Results {
                frequencies_hz: frequencies.next().unwrap_or_default(),
                shapes: shapes.next().unwrap_or_default(),
                damping_ratios: damping.next().unwrap_or_default(),
                compliances_m_per_n: compliances.next().unwrap_or_default(),
            })
            .collect()
    }
}

#[inline(always)]
fn part(rows: &mut [f64], from: usize, count: usize, width: usize) -> &mut [f64] {
    if rows.is_empty() { rows } else { &mut rows[from * width..(from + count) * width] }
}

/// Buffers for blocks of poses.
pub(super) struct Block<'a, S: Simd> {
    simd: S,
    plan: &'a Plan,
    n: usize,
    assembly: Assembly<S>,
    q: Vec<Lanes<S>>,
    /// The matrix to be diagonalised.
    a: Vec<Lanes<S>>,
    lambda: Vec<Lanes<S>>,
    /// What is turned along with A, column by column.
    w: Vec<Lanes<S>>,
    /// The same, turned.
    v: Vec<Lanes<S>>,
    t: Vec<Lanes<S>>,
    /// R of K = Rᵀ R.
    r: Vec<Lanes<S>>,
    damping: Vec<Lanes<S>>,
    compliance: Vec<Lanes<S>>,
}

impl<'a, S: Simd> Block<'a, S> {
    pub(super) fn new(simd: S, plan: &'a Plan) -> Self {
        let zero = splat(simd, 0.0);
        let n = plan.coordinates.len();
        let triangle = n * (n + 1) / 2;
        Self {
            simd,
            plan,
            n,
            assembly: Assembly::new(simd, plan),
            q: vec![zero; plan.joints],
            a: vec![zero; triangle],
            lambda: vec![zero; n],
            w: vec![zero; n * n.max(3)],
            v: vec![zero; n * n.max(3)],
            t: vec![zero; triangle],
            r: vec![zero; triangle],
            damping: vec![zero; n],
            compliance: vec![zero; n],
        }
    }

    /// Solves the poses of `rows` (at most one a lane) into `results`. The bits that are set mark
    /// the poses that the scalar path must look at; their results are not to be used.
    #[inline(always)]
    pub(super) fn solve(
        &mut self,
        rows: &[f64],
        count: usize,
        wanted: Wanted,
        results: &mut Results,
    ) -> u64 {
        let simd = self.simd;
        let mut bad = self.load(rows, count);
        simd.vectorize(
            #[inline(always)]
            || self.assembly.place(simd, self.plan, &self.q),
        );
        let plan = self.plan;
        let wants_all = match wanted {
            Wanted::Frequencies => false,
            Wanted::Modes => true,
            Wanted::Tip { tool, .. } => {
                simd.vectorize(
                    #[inline(always)]
                    || self.assembly.tip(simd, plan, &self.q, &tool),
                );
                plan.one_damping_ratio.is_none()
            }
        };
        self.a.copy_from_slice(&self.assembly.mass);
        if plan.gravity.is_some() {
            bad |= self.scale_by_stiffness();
        }
        let rows = match wanted {
            Wanted::Frequencies => 0,
            Wanted::Tip { .. } if !wants_all => 3,
            Wanted::Modes | Wanted::Tip { .. } => self.n,
        };
        if wants_all {
            self.w[..self.n * self.n].fill(splat(simd, 0.0));
            for i in 0..self.n {
                self.w[i * self.n + i] = splat(simd, 1.0);
            }
        } else {
            self.w[..rows * self.n].copy_from_slice(&self.assembly.jacobian[..rows * self.n]);
        }
        bad |= self.diagonalise(rows, bad);
        bad |= self.suspects();
        match (wanted, plan.one_damping_ratio) {
            (Wanted::Frequencies, _) => sort::<S>(&mut self.lambda, &mut [], 0),
            (Wanted::Modes, _) => {
                sort::<S>(&mut self.lambda, &mut self.v, self.n);
                self.shape();
            }
            (Wanted::Tip { .. }, one_damping_ratio) => {
                match one_damping_ratio {
                    Some(zeta) => self.comply_alike(zeta),
                    None => self.comply(),
                }
                sort::<S>(&mut self.lambda, &mut self.compliance, 1);
            }
        }
        self.store(count, wanted, results);
        bad.to_bitmask()
    }

    /// Joint positions by lane; lanes without a pose repeat the last one. Gives the lanes whose
    /// pose this code is not made for.
    #[inline(always)]
    fn load(&mut self, rows: &[f64], count: usize) -> Mask<S> {
        let simd = self.simd;
        let joints = self.plan.joints;
        let (zero, limit) = (splat(simd, 0.0), splat(simd, MAX_ANGLE_RAD));
        let mut good = Mask::<S>::splat(simd, true);
        for (j, q) in self.q.iter_mut().enumerate() {
            let mut x = zero;
            for (lane, x) in x.as_mut_slice().iter_mut().enumerate() {
                *x = rows[lane.min(count - 1) * joints + j];
            }
            good &= x.abs().simd_le(limit);
            *q = x;
        }
        if !good.all_true() {
            for q in &mut self.q {
                *q = good.select(*q, zero);
            }
        }
        !good
    }

    /// A ← R⁻ᵀ A R⁻¹ with K = Rᵀ R. Gives the lanes whose K is not surely positive definite.
    #[inline(always)]
    fn scale_by_stiffness(&mut self) -> Mask<S> {
        let (simd, n) = (self.simd, self.n);
        self.r.copy_from_slice(&self.assembly.stiffness);
        let bad = cholesky(simd, n, &mut self.r);
        congruence(simd, n, &mut self.a, &self.r);
        bad
    }

    /// Lanes whose M may be singular: the scalar path asks whether a pivot of its Cholesky factor
    /// is lost. Every pivot is at least the determinant, both as shares of the diagonal; only where
    /// that does not settle it are the pivots worked out.
    #[inline(always)]
    fn suspects(&mut self) -> Mask<S> {
        let (simd, n) = (self.simd, self.n);
        let mut sure = Mask::<S>::splat(simd, false);
        if n <= MAX_UNROLLED && self.plan.gravity.is_none() {
            let mut determinant = self.lambda[0];
            let mut diagonal = self.assembly.mass[0] * splat(simd, SURE_DETERMINANT);
            for i in 1..n {
                determinant *= self.lambda[i];
                diagonal *= self.assembly.mass[packed(n, i, i)];
            }
            sure = determinant.simd_gt(diagonal);
            if sure.all_true() {
                return !sure;
            }
        }
        self.t.copy_from_slice(&self.assembly.mass);
        !sure & cholesky(simd, n, &mut self.t)
    }

    /// Eigenvalues of A, with `rows` rows of v turned along. Gives the lanes that did not converge,
    /// and `bad` ones.
    #[inline(always)]
    fn diagonalise(&mut self, rows: usize, bad: Mask<S>) -> Mask<S> {
        let (simd, n) = (self.simd, self.n);
        let mut problem = Eigenproblem {
            a: &mut self.a,
            v: &mut self.w[..rows * n],
            rows,
            t: &mut self.t,
            eigenvalues: &mut self.lambda,
            vectors: &mut self.v[..rows * n],
        };
        let done = diagonalise(simd, n, &mut problem, bad);
        bad | !done
    }

    /// Eigenvectors y of A become x = R⁻¹ y, if there is gravity: φ = ω x, but for the springs'
    /// scale.
    #[inline(always)]
    fn unscale(&mut self) {
        if self.plan.gravity.is_none() {
            return;
        }
        let n = self.n;
        for x in self.v[..n * n].chunks_exact_mut(n) {
            for i in (0..n).rev() {
                let mut sum = x[i];
                for (j, x) in x.iter().enumerate().skip(i + 1) {
                    sum = (-self.r[packed(n, i, j)]).mul_add(*x, sum);
                }
                x[i] = sum * self.r[packed(n, i, i)];
            }
        }
    }

    /// ζ_r of every mode, from x: each spring's loss in proportion to its share of the strain
    /// energy, each dashpot's as φᵀ C φ / 2ω.
    #[inline(always)]
    fn damp(&mut self) {
        let (simd, n) = (self.simd, self.n);
        for r in 0..n {
            let omega = inverse_root(simd, self.lambda[r]);
            let zero = splat(simd, 0.0);
            let (mut strain, mut lost, mut viscous) = (zero, zero, zero);
            for (x, c) in self.v[r * n..].iter().zip(&self.plan.coordinates) {
                let energy = *x * *x;
                strain += energy;
                lost = energy.mul_add(splat(simd, c.loss_ratio), lost);
                viscous = energy.mul_add(splat(simd, 0.5 * c.viscous * c.scale * c.scale), viscous);
            }
            self.damping[r] = lost / strain + viscous * omega;
        }
    }

    /// Shapes φ in place of the eigenvectors, with the scalar path's signs.
    #[inline(always)]
    fn shape(&mut self) {
        let (simd, n) = (self.simd, self.n);
        let zero = splat(simd, 0.0);
        for r in 0..n {
            let (mut size, mut leading) = (splat(simd, -1.0), zero);
            for (y, c) in self.v[r * n..].iter().zip(&self.plan.coordinates) {
                let larger = y.abs().simd_gt(size);
                size = larger.select(y.abs(), size);
                leading = larger.select(*y * splat(simd, c.scale.signum()), leading);
            }
            // Kept until the shapes are scaled.
            self.compliance[r] = leading.simd_lt(zero).select(splat(simd, -1.0), splat(simd, 1.0));
        }
        self.unscale();
        self.damp();
        for r in 0..n {
            let omega = inverse_root(simd, self.lambda[r]) * self.compliance[r];
            for (x, c) in self.v[r * n..].iter_mut().zip(&self.plan.coordinates) {
                *x = *x * omega * splat(simd, c.scale);
            }
        }
    }

    /// |J φ_r|² / 2 ζ_r ω_r² from J K^-½ y_r, which v holds, where all modes have one ζ.
    #[inline(always)]
    fn comply_alike(&mut self, zeta: f64) {
        let half = splat(self.simd, 0.5 / zeta);
        for (c, w) in self.compliance.iter_mut().zip(self.v.chunks_exact(3)) {
            *c = square::<S>(w) * half;
        }
    }

    /// The same from the eigenvectors.
    #[inline(always)]
    fn comply(&mut self) {
        let (simd, n) = (self.simd, self.n);
        self.unscale();
        self.damp();
        for r in 0..n {
            let mut w = [splat(simd, 0.0); 3];
            for (i, x) in self.v[r * n..(r + 1) * n].iter().enumerate() {
                for (k, w) in w.iter_mut().enumerate() {
                    *w = self.assembly.jacobian[3 * i + k].mul_add(*x, *w);
                }
            }
            self.compliance[r] = square::<S>(&w) * splat(simd, 0.5) / self.damping[r];
        }
    }

    #[inline(always)]
    fn store(&mut self, count: usize, wanted: Wanted, results: &mut Results) {
        let (simd, n) = (self.simd, self.n);
        for lambda in &mut self.lambda {
            *lambda = inverse_root(simd, *lambda) * splat(simd, hz_from_rad_per_s(1.0));
        }
        scatter::<S>(&self.lambda, count, results.frequencies_hz);
        match wanted {
            Wanted::Frequencies => {}
            Wanted::Modes => {
                scatter::<S>(&self.damping, count, results.damping_ratios);
                scatter::<S>(&self.v[..n * n], count, results.shapes);
            }
            Wanted::Tip { .. } => {
                scatter::<S>(&self.compliance, count, results.compliances_m_per_n)
            }
        }
    }
}

/// The square of the length of a vector of three entries.
#[inline(always)]
fn square<S: Simd>(w: &[Lanes<S>]) -> Lanes<S> {
    w[2].mul_add(w[2], w[1].mul_add(w[1], w[0] * w[0]))
}

/// Lane by lane, the values of one pose beside each other.
#[inline(always)]
fn scatter<S: Simd>(values: &[Lanes<S>], count: usize, rows: &mut [f64]) {
    for (k, value) in values.iter().enumerate() {
        let lanes = value.as_slice();
        for (row, lane) in rows.chunks_exact_mut(values.len()).zip(lanes).take(count) {
            row[k] = *lane;
        }
    }
}

/// R of A = Rᵀ R in the upper triangle, with the reciprocals of its diagonal in place of the
/// diagonal. Gives the lanes with a pivot that may be lost.
#[inline(always)]
fn cholesky<S: Simd>(simd: S, n: usize, a: &mut [Lanes<S>]) -> Mask<S> {
    let mut good = Mask::<S>::splat(simd, true);
    // A pivot is its diagonal entry less what the rows above took: the sum restores it.
    for i in 0..n {
        let pivot = a[packed(n, i, i)];
        let mut taken = splat(simd, 0.0);
        for k in 0..i {
            let r = a[packed(n, k, i)];
            taken = r.mul_add(r, taken);
        }
        good &= pivot.simd_gt((pivot + taken) * splat(simd, SUSPECT_PIVOT));
        let g = inverse_root(simd, pivot);
        a[packed(n, i, i)] = g;
        for j in i + 1..n {
            a[packed(n, i, j)] = a[packed(n, i, j)] * g;
        }
        for p in i + 1..n {
            let minus = -a[packed(n, i, p)];
            for j in p..n {
                a[packed(n, p, j)] = minus.mul_add(a[packed(n, i, j)], a[packed(n, p, j)]);
            }
        }
    }
    !good
}

/// A ← R⁻ᵀ A R⁻¹ on upper triangles, R with reciprocals on its diagonal (LAPACK's dsygs2, itype 1).
#[inline(always)]
fn congruence<S: Simd>(simd: S, n: usize, a: &mut [Lanes<S>], r: &[Lanes<S>]) {
    for k in 0..n {
        let g = r[packed(n, k, k)];
        let akk = a[packed(n, k, k)] * g * g;
        a[packed(n, k, k)] = akk;
        let half = akk * splat(simd, -0.5);
        for j in k + 1..n {
            let kj = packed(n, k, j);
            a[kj] = half.mul_add(r[kj], a[kj] * g);
        }
        for p in k + 1..n {
            let (minus_a, minus_r) = (-a[packed(n, k, p)], -r[packed(n, k, p)]);
            for j in p..n {
                let (kj, pj) = (packed(n, k, j), packed(n, p, j));
                a[pj] = minus_r.mul_add(a[kj], minus_a.mul_add(r[kj], a[pj]));
            }
        }
        for j in k + 1..n {
            let kj = packed(n, k, j);
            let mut sum = half.mul_add(r[kj], a[kj]);
            for m in k + 1..j {
                sum = (-a[packed(n, k, m)]).mul_add(r[packed(n, m, j)], sum);
            }
            a[kj] = sum * r[packed(n, j, j)];
        }
    }
}
