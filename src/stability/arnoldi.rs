//! The eigenvalue of largest modulus of a linear map, by Arnoldi's iteration.

use nalgebra::{Complex, DMatrix, DVector, Schur};

/// Steps before the first look at the eigenvalues, and between two looks.
const FIRST_LOOK: usize = 10;
const LOOK_EVERY: usize = 5;

/// Most steps: the maps here have a few eigenvalues near the largest and many near zero.
const MAX_STEPS: usize = 200;

/// Two looks agree where the largest moduli differ by less than this share.
const CONVERGED: f64 = 1e-11;

/// Where only the side of 1 is asked for, they may differ by this share of how far that is, behind
/// so many steps.
const OF_MARGIN: f64 = 1e-3;
const LEAST_STEPS: usize = 20;

/// A second pass restores orthogonality where the first takes off all but this share.
const CANCELLED: f64 = 0.7;

/// Cap of nalgebra's QR iteration, which would not end by itself on some matrices.
const MAX_QR_STEPS: usize = 10_000;

/// What is asked for of an eigenvalue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    /// On which side of 1 its modulus is, and about how far.
    Side,
    /// All its digits.
    Value,
    /// Its vector, too.
    Vector,
}

/// An eigenvalue and its vector, which is empty where it was not asked for.
#[derive(Debug, Clone)]
pub(super) struct Dominant {
    pub(super) value: Complex<f64>,
    /// Whether two looks agreed on it.
    pub(super) is_sure: bool,
    pub(super) vector: DVector<Complex<f64>>,
}

/// The basis of a Krylov space and what the map does in it.
struct Krylov {
    basis: Vec<DVector<f64>>,
    hessenberg: DMatrix<f64>,
}

impl Krylov {
    /// One more step; `false` where the space is closed.
    fn step(&mut self, map: &mut impl FnMut(&[f64], &mut [f64])) -> bool {
        let k = self.basis.len() - 1;
        let mut next = DVector::zeros(self.basis[k].len());
        map(self.basis[k].as_slice(), next.as_mut_slice());
        let mut before = next.norm();
        let first = before;
        // Twice at most: once may lose orthogonality.
        for _ in 0..2 {
            for (i, vector) in self.basis.iter().enumerate() {
                let part = vector.dot(&next);
                self.hessenberg[(i, k)] += part;
                next.axpy(-part, vector, 1.0);
            }
            let left = next.norm();
            if left > CANCELLED * before {
                break;
            }
            before = left;
        }
        let rest = next.norm();
        if rest.is_nan() || rest <= 1e-14 * first {
            return false;
        }
        self.hessenberg[(k + 1, k)] = rest;
        self.basis.push(next / rest);
        true
    }

    fn largest(&self, k: usize) -> Option<Complex<f64>> {
        let inner = self.hessenberg.view((0, 0), (k, k)).into_owned();
        let schur = Schur::try_new(inner, f64::EPSILON, MAX_QR_STEPS)?;
        let all = schur.complex_eigenvalues();
        all.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm()))
    }

    /// The vector of an eigenvalue, by inverse iteration.
    fn vector(&self, k: usize, value: Complex<f64>) -> Option<DVector<Complex<f64>>> {
        let near = value * (1.0 + 1e-9) + Complex::new(1e-14, 0.0);
        let inner = self.hessenberg.view((0, 0), (k, k)).map(Complex::from);
        let lu = (inner - DMatrix::identity(k, k) * near).lu();
        let mut inside = DVector::from_element(k, Complex::new(1.0, 0.5));
        for _ in 0..3 {
            inside = lu.solve(&inside)?;
            let norm = inside.norm();
            if !(norm.is_finite() && norm > 0.0) {
                return None;
            }
            inside.unscale_mut(norm);
        }
        let mut sum = DVector::zeros(self.basis.first()?.len());
        for (vector, part) in self.basis.iter().zip(inside.iter()) {
            sum += vector.map(|x| *part * x);
        }
        Some(sum)
    }
}

/// The eigenvalue of largest modulus of a map of vectors of `size`, which it maps from the first to
/// the second, full of zeros; `None` where there is none.
pub(super) fn dominant(
    size: usize,
    mut map: impl FnMut(&[f64], &mut [f64]),
    wanted: Wanted,
) -> Option<Dominant> {
    // Any start that no symmetry is blind to.
    let start = DVector::from_fn(size, |i, _| 1.0 + 0.7 * (1.3 * i as f64 + 0.4).sin());
    let norm = start.norm();
    let most = size.min(MAX_STEPS);
    let mut krylov =
        Krylov { basis: vec![start / norm], hessenberg: DMatrix::zeros(most + 1, most) };
    let mut last: Option<f64> = None;
    for k in 1..=most {
        let is_open = krylov.step(&mut map);
        let is_end = !is_open || k == size;
        let is_look = k >= FIRST_LOOK && k % LOOK_EVERY == 0;
        if !is_end && !is_look && k != most {
            continue;
        }
        let value = krylov.largest(k)?;
        let modulus = value.norm();
        let agrees = last.is_some_and(|last| {
            let apart = (modulus - last).abs();
            let is_clear = apart <= OF_MARGIN * (modulus - 1.0).abs();
            wanted == Wanted::Side && is_clear && k >= LEAST_STEPS
                || apart <= CONVERGED * last.max(f64::MIN_POSITIVE)
        });
        if is_end || agrees || k == most {
            let vector = match wanted {
                Wanted::Vector => krylov.vector(k, value)?,
                Wanted::Side | Wanted::Value => DVector::zeros(0),
            };
            return Some(Dominant { value, is_sure: is_end || agrees, vector });
        }
        last = Some(modulus);
    }
    None
}
