//! Products of 3 × 3 matrices, written out: nalgebra's go through the routine for any size, which
//! takes a fifth of a diagnosis. The sums are in the same order, so the digits are the same.

use nalgebra::{Matrix3, Vector3};

/// A v.
#[inline]
pub(super) fn turned(a: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let row = |i: usize| a[(i, 0)] * v[0] + a[(i, 1)] * v[1] + a[(i, 2)] * v[2];
    Vector3::new(row(0), row(1), row(2))
}

/// A B.
#[inline]
pub(super) fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    let column = |j: usize| turned(a, &Vector3::new(b[(0, j)], b[(1, j)], b[(2, j)]));
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}

/// R I Rᵀ.
#[inline]
pub(super) fn rotated(inertia: &Matrix3<f64>, r: &Matrix3<f64>) -> Matrix3<f64> {
    product(&product(r, inertia), &r.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_are_those_of_nalgebra() {
        let a = Matrix3::new(0.3, -1.7, 2.9, 4.1, 0.6, -0.2, 7.7, 1.3, -5.5);
        let b = Matrix3::new(1.1, 2.3, -0.7, 0.9, -3.1, 0.4, 2.2, 0.8, 6.3);
        let v = Vector3::new(0.7, -1.9, 2.4);
        assert!((turned(&a, &v) - a * v).norm() < 1e-14);
        assert!((product(&a, &b) - a * b).norm() < 1e-13);
        assert!((rotated(&b, &a) - a * b * a.transpose()).norm() < 1e-11);
    }
}
