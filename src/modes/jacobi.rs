//! Eigenvalues and vectors of a small symmetric matrix by cyclic Jacobi rotations (Golub & Van
//! Loan, Matrix Computations, 4th ed., §8.5), in place.

use nalgebra::DMatrix;

/// Off-diagonal entries below this share of the geometric mean of their diagonal entries count as
/// zero.
const CONVERGED: f64 = f64::EPSILON * 0.5;

/// Jacobi converges quadratically; the worst 24 × 24 case was seen to need five sweeps.
const MAX_SWEEPS: usize = 30;

/// Turns `a` (symmetric) into its eigenvalues on the diagonal. Where `vectors` is given, it becomes
/// the orthonormal eigenvectors, column for column. The eigenvalues are not sorted.
pub(super) fn diagonalise(a: &mut DMatrix<f64>, mut vectors: Option<&mut DMatrix<f64>>) {
    let n = a.nrows();
    if let Some(v) = vectors.as_deref_mut() {
        v.fill_with_identity();
    }
    for _ in 0..MAX_SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                let apq = a[(p, q)];
                let (app, aqq) = (a[(p, p)], a[(q, q)]);
                if apq == 0.0 || apq.abs() <= CONVERGED * (app * aqq).abs().sqrt() {
                    continue;
                }
                rotated = true;
                let tau = (aqq - app) / (2.0 * apq);
                // τ² may overflow: then t is zero, and a_pq was nothing beside the diagonal.
                let t = tau.signum() / (tau.abs() + (tau * tau + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                a[(p, p)] = app - t * apq;
                a[(q, q)] = aqq + t * apq;
                a[(p, q)] = 0.0;
                a[(q, p)] = 0.0;
                for k in (0..n).filter(|&k| k != p && k != q) {
                    let (akp, akq) = (a[(k, p)], a[(k, q)]);
                    let (new_p, new_q) = (c * akp - s * akq, s * akp + c * akq);
                    a[(k, p)] = new_p;
                    a[(p, k)] = new_p;
                    a[(k, q)] = new_q;
                    a[(q, k)] = new_q;
                }
                if let Some(v) = vectors.as_deref_mut() {
                    for k in 0..n {
                        let (vkp, vkq) = (v[(k, p)], v[(k, q)]);
                        v[(k, p)] = c * vkp - s * vkq;
                        v[(k, q)] = s * vkp + c * vkq;
                    }
                }
            }
        }
        if !rotated {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DVector, SymmetricEigen};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Against nalgebra's tridiagonal QR on random symmetric matrices of every size up to 24.
    #[test]
    fn agrees_with_tridiagonal_qr() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        for n in 1..=24 {
            let b = DMatrix::from_fn(n, n, |_, _| rng.random_range(-1.0..1.0));
            let a = &b * b.transpose();
            let mut expected = SymmetricEigen::new(a.clone()).eigenvalues.as_slice().to_vec();
            expected.sort_by(f64::total_cmp);
            let mut d = a.clone();
            let mut v = DMatrix::zeros(n, n);
            diagonalise(&mut d, Some(&mut v));
            let mut found = d.diagonal().as_slice().to_vec();
            found.sort_by(f64::total_cmp);
            let scale = expected[n - 1];
            for (f, e) in found.iter().zip(&expected) {
                assert!((f - e).abs() < 1e-13 * scale, "n = {n}: {f} against {e}");
            }
            let residual = &a * &v - &v * DMatrix::from_diagonal(&DVector::from(d.diagonal()));
            assert!(residual.amax() < 1e-13 * scale, "n = {n}: residual {}", residual.amax());
            let orthonormal = v.transpose() * &v - DMatrix::identity(n, n);
            assert!(orthonormal.amax() < 1e-13, "n = {n}");
        }
    }

    /// A graded matrix D B D with known scaling: the smallest eigenvalue keeps its digits, which a
    /// method that works to an absolute error loses. Expected: 2 × 2 closed form, evaluated without
    /// cancellation.
    #[test]
    fn keeps_the_small_eigenvalue_of_a_graded_matrix() {
        let (a, b, c) = (1.0, 1e-7, 4e-14);
        let mut m = DMatrix::from_row_slice(2, 2, &[a, b, b, c]);
        diagonalise(&mut m, None);
        let largest = 0.5 * ((a + c) + ((a - c) * (a - c) + 4.0 * b * b).sqrt());
        let smallest = (a * c - b * b) / largest;
        let found = m[(0, 0)].min(m[(1, 1)]);
        assert!((found / smallest - 1.0).abs() < 1e-12, "{found} against {smallest}");
    }
}
