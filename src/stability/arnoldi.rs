//! The eigenvalue of largest modulus of a linear map, by Arnoldi's iteration.

use nalgebra::{Complex, DMatrix, DVector, Schur};

/// Steps between two looks at the eigenvalues.
const LOOK_EVERY: usize = 10;

/// Most steps: the maps here have a few eigenvalues near the largest and many near zero.
const MAX_STEPS: usize = 200;

/// Two looks agree where the largest moduli differ by less than this share.
const CONVERGED: f64 = 1e-11;

/// Cap of nalgebra's QR iteration, which would not end by itself on some matrices.
const MAX_QR_STEPS: usize = 10_000;

/// An eigenvalue and its vector.
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
    fn step(&mut self, map: &mut impl FnMut(&DVector<f64>) -> DVector<f64>) -> bool {
        let k = self.basis.len() - 1;
        let mut next = map(&self.basis[k]);
        let before = next.norm();
        // Twice: once loses orthogonality.
        for _ in 0..2 {
            for (i, vector) in self.basis.iter().enumerate() {
                let part = vector.dot(&next);
                self.hessenberg[(i, k)] += part;
                next.axpy(-part, vector, 1.0);
            }
        }
        let rest = next.norm();
        if rest.is_nan() || rest <= 1e-14 * before {
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

/// The eigenvalue of largest modulus of a map of vectors of `size`; `None` where there is none.
/// `wants_vector` asks for its vector, too, which is empty otherwise.
pub(super) fn dominant(
    size: usize,
    mut map: impl FnMut(&DVector<f64>) -> DVector<f64>,
    wants_vector: bool,
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
        if !is_end && k % LOOK_EVERY != 0 && k != most {
            continue;
        }
        let value = krylov.largest(k)?;
        let agrees = last.is_some_and(|last| {
            (value.norm() - last).abs() <= CONVERGED * last.max(f64::MIN_POSITIVE)
        });
        if is_end || agrees || k == most {
            let vector = match wants_vector {
                true => krylov.vector(k, value)?,
                false => DVector::zeros(0),
            };
            return Some(Dominant { value, is_sure: is_end || agrees, vector });
        }
        last = Some(value.norm());
    }
    None
}
