//! The eigenproblem K φ = ω² M φ of given matrices, for those who change M and K themselves.

use nalgebra::{DMatrix, DVector};

use super::jacobi::diagonalise;

/// An eigenvalue 1/ω² below this share of the largest counts as zero: the coordinate carries no
/// inertia of its own, and its frequency is beyond all others.
pub(super) const NO_INERTIA: f64 = 1e-12;

/// Solves one pencil after the other in buffers of its own.
#[derive(Debug, Clone)]
pub struct Pencil {
    scaled: DMatrix<f64>,
    vectors: DMatrix<f64>,
    scale: DVector<f64>,
    order: Vec<usize>,
    /// ω_r², (rad/s)², ascending; infinite where a coordinate carries no inertia of its own.
    pub omega_squared: Vec<f64>,
    /// φ_r as columns, mass-normalised; zero where ω_r² is infinite.
    pub shapes: DMatrix<f64>,
}

impl Pencil {
    /// Buffers for n × n matrices.
    pub fn new(n: usize) -> Self {
        Self {
            scaled: DMatrix::zeros(n, n),
            vectors: DMatrix::zeros(n, n),
            scale: DVector::zeros(n),
            order: (0..n).collect(),
            omega_squared: vec![0.0; n],
            shapes: DMatrix::zeros(n, n),
        }
    }

    /// Solves for symmetric M, positive semidefinite, and K, positive definite, both n × n. `false`
    /// if K is not, or if something is not finite.
    pub fn solve(&mut self, mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> bool {
        let n = self.order.len();
        let mut diagonal = true;
        for i in 0..n {
            let k = stiffness[(i, i)];
            if !(k.is_finite() && k > 0.0) {
                return false;
            }
            self.scale[i] = 1.0 / k.sqrt();
            diagonal &= (0..i).all(|j| stiffness[(i, j)] == 0.0);
        }
        let factor = if diagonal { None } else { Some(stiffness.clone().cholesky()) };
        match &factor {
            None => {
                for j in 0..n {
                    for i in 0..n {
                        self.scaled[(i, j)] = mass[(i, j)] * self.scale[i] * self.scale[j];
                    }
                }
            }
            Some(None) => return false,
            Some(Some(cholesky)) => {
                let l = cholesky.l();
                let Some(left) = l.solve_lower_triangular(mass) else { return false };
                let Some(both) = l.solve_lower_triangular(&left.transpose()) else { return false };
                self.scaled.copy_from(&((&both + both.transpose()) * 0.5));
            }
        }
        if !self.scaled.iter().all(|x| x.is_finite()) {
            return false;
        }
        diagonalise(&mut self.scaled, Some(&mut self.vectors));
        let scaled = &self.scaled;
        self.order.sort_unstable_by(|&a, &b| scaled[(b, b)].total_cmp(&scaled[(a, a)]));
        let largest = self.order.first().map_or(0.0, |&i| self.scaled[(i, i)]);
        if largest <= 0.0 {
            return false;
        }
        for (r, &from) in self.order.iter().enumerate() {
            let lambda = self.scaled[(from, from)];
            let mut shape = self.shapes.column_mut(r);
            if lambda <= NO_INERTIA * largest {
                self.omega_squared[r] = f64::INFINITY;
                shape.fill(0.0);
                continue;
            }
            self.omega_squared[r] = 1.0 / lambda;
            let omega = self.omega_squared[r].sqrt();
            match &factor {
                Some(Some(cholesky)) => {
                    let y: DVector<f64> = self.vectors.column(from).into_owned();
                    let Some(x) = cholesky.l().tr_solve_lower_triangular(&y) else { return false };
                    shape.copy_from(&x);
                    shape *= omega;
                }
                _ => {
                    for i in 0..n {
                        shape[i] = self.vectors[(i, from)] * self.scale[i] * omega;
                    }
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, SymmetricEigen};

    /// Against nalgebra's eigenvalues of L⁻¹ K L⁻ᵀ with M = L Lᵀ, K diagonal and full.
    #[test]
    fn agrees_with_the_pencil_turned_round() {
        let n = 4;
        let make = |seed: f64, ridge: f64| {
            let a = DMatrix::from_fn(n, n, |i, j| (seed * (1 + i * n + j) as f64).sin());
            &a * a.transpose() + DMatrix::from_diagonal_element(n, n, ridge)
        };
        let mass = make(1.7, 0.5);
        let full = make(0.9, 2.0);
        for stiffness in [full.clone(), DMatrix::from_diagonal(&full.diagonal())] {
            let mut pencil = Pencil::new(n);
            assert!(pencil.solve(&mass, &stiffness));
            let inverse = mass.clone().cholesky().unwrap().l().try_inverse().unwrap();
            let turned = &inverse * &stiffness * inverse.transpose();
            let mut expected: Vec<f64> =
                SymmetricEigen::new(turned).eigenvalues.iter().copied().collect();
            expected.sort_by(f64::total_cmp);
            for (found, expected) in pencil.omega_squared.iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-10);
            }
            let unit = pencil.shapes.transpose() * &mass * &pencil.shapes;
            assert!((unit - DMatrix::identity(n, n)).amax() < 1e-10);
        }
    }

    #[test]
    fn a_coordinate_without_inertia_of_its_own_is_beyond_all_frequencies() {
        let mass = DMatrix::from_row_slice(2, 2, &[2.0, 2.0, 2.0, 2.0]);
        let stiffness = DMatrix::from_diagonal_element(2, 2, 8.0);
        let mut pencil = Pencil::new(2);
        assert!(pencil.solve(&mass, &stiffness));
        // Two springs in series: k = 4, m = 2.
        assert!((pencil.omega_squared[0] - 2.0).abs() < 1e-12);
        assert!(pencil.omega_squared[1].is_infinite());
        assert!(!pencil.solve(&mass, &DMatrix::from_diagonal_element(2, 2, -1.0)));
    }
}
