//! Poles and shapes of the state matrices that the Hankel matrix of correlations realises, with
//! deviations.

use nalgebra::{DMatrix, DVector, Schur};

use super::super::block::C64;
use super::correlations::Correlations;

/// A pole of one order.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub(super) order: usize,
    /// rad/s, with positive imaginary part.
    pub(super) lambda: C64,
    /// Standard deviations of |λ|, rad/s, and of the damping ratio.
    pub(super) omega_std: f64,
    pub(super) ratio_std: f64,
    /// By response, each with the mean variance of its real and imaginary part.
    pub(super) shape: Vec<(C64, f64)>,
}

impl Found {
    pub(super) fn omega(&self) -> f64 {
        self.lambda.norm()
    }

    pub(super) fn ratio(&self) -> f64 {
        -self.lambda.re / self.omega()
    }
}

/// H = U S Vᵀ of the correlations.
pub(super) struct Realisation<'c> {
    correlations: &'c Correlations,
    /// Time from one sample to the next, s.
    step_s: f64,
    responses: usize,
    /// Columns by descending singular value.
    u: DMatrix<f64>,
    /// V S⁻¹.
    v_over_s: DMatrix<f64>,
}

impl<'c> Realisation<'c> {
    /// With singular vectors for orders up to `highest`.
    pub(super) fn new(
        correlations: &'c Correlations,
        step_s: f64,
        responses: usize,
        highest: usize,
    ) -> Self {
        let hankel = correlations.hankel();
        let eigen = (&hankel * hankel.transpose()).symmetric_eigen();
        let mut by_size: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
        by_size.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        let largest = by_size.first().map_or(0.0, |&i| eigen.eigenvalues[i]);
        // Squares of singular values: smaller ones are rounding.
        by_size.retain(|&i| eigen.eigenvalues[i] > 1e-13 * largest);
        by_size.truncate(highest);
        let u = eigen.eigenvectors.select_columns(&by_size);
        let mut v_over_s = hankel.transpose() * &u;
        for (mut column, &i) in v_over_s.column_iter_mut().zip(&by_size) {
            column /= eigen.eigenvalues[i];
        }
        Self { correlations, step_s, responses, u, v_over_s }
    }

    /// Largest order.
    pub(super) fn highest(&self) -> usize {
        self.u.ncols()
    }

    /// The poles of an order that `is_asked` for.
    pub(super) fn poles(&self, order: usize, is_asked: &impl Fn(C64) -> bool) -> Vec<Found> {
        let l = self.responses;
        let u = self.u.columns(0, order).into_owned();
        let rows = u.nrows() - l;
        let (up, down) = (u.rows(0, rows).into_owned(), u.rows(l, rows).into_owned());
        let Some(factor) = (up.transpose() * &up).cholesky() else { return Vec::new() };
        // A = U↑⁺ U↓.
        let inverse = factor.solve(&up.transpose());
        let state = &inverse * &down;
        let Some(schur) = Schur::try_new(state.clone(), 1e-12, 10_000) else { return Vec::new() };
        let values = schur.complex_eigenvalues();
        let asked = values.iter().filter(|mu| mu.im > 0.0 && is_asked(mu.ln() / self.step_s));
        asked.filter_map(|mu| self.found(order, *mu, &u, &state, &inverse)).collect()
    }

    fn found(
        &self,
        order: usize,
        mu: C64,
        u: &DMatrix<f64>,
        state: &DMatrix<f64>,
        inverse: &DMatrix<f64>,
    ) -> Option<Found> {
        let l = self.responses;
        let complex = |m: &DMatrix<f64>| m.map(|x| C64::new(x, 0.0));
        let right = eigenvector(state, mu)?;
        let mut left = eigenvector(&state.transpose(), mu)?;
        let scale = left.dot(&right);
        left /= scale;
        // Change of μ with H: aᵀ ΔH w, where ΔU = (1 − UUᵀ) ΔH V S⁻¹, as changes within the span of
        // U change no eigenvalue.
        let w = complex(&self.v_over_s.columns(0, order).into_owned()) * &right;
        let row = complex(&inverse.transpose()) * &left;
        let mut a = DVector::<C64>::zeros(u.nrows());
        a.rows_mut(l, row.len()).copy_from(&row);
        let shifted = &row * mu;
        let mut head = a.rows_mut(0, row.len());
        head -= shifted;
        let within = complex(u) * (complex(&u.transpose()) * &a);
        a -= within;
        let lambda = mu.ln() / self.step_s;
        let slope = (mu * self.step_s).inv();
        let changes: Vec<C64> =
            self.correlations.products(&a, &w).into_iter().map(|by| by * slope).collect();
        let omega = lambda.norm();
        let of_omega: Vec<f64> = changes.iter().map(|by| (lambda.conj() * by).re / omega).collect();
        let of_ratio: Vec<f64> = changes
            .iter()
            .zip(&of_omega)
            .map(|(by, of_omega)| (lambda.re * of_omega / omega - by.re) / omega)
            .collect();
        let shape = complex(&u.rows(0, l).into_owned()) * &right;
        let apart = self.correlations.first_rows(&w);
        let variance = |i: usize| {
            let parts = |part: fn(&C64) -> f64| {
                let values: Vec<f64> = apart.iter().map(|own| part(&own[i])).collect();
                std_of_mean(&values).powi(2)
            };
            0.5 * (parts(|z| z.re) + parts(|z| z.im))
        };
        Some(Found {
            order,
            lambda,
            omega_std: std_of_mean(&of_omega),
            ratio_std: std_of_mean(&of_ratio),
            shape: shape.iter().enumerate().map(|(i, value)| (*value, variance(i))).collect(),
        })
    }
}

/// Standard deviation of the mean of independent values, such that ±1.96 of it hold the mean in
/// 95 % of all cases (Student), however few values there are.
fn std_of_mean(values: &[f64]) -> f64 {
    use statrs::distribution::{ContinuousCDF, StudentsT};
    const REACH: f64 = 1.959_963_985;
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let student = StudentsT::new(0.0, 1.0, n - 1.0).map_or(f64::NAN, |t| t.inverse_cdf(0.975));
    (square / (n * (n - 1.0))).sqrt() * student / REACH
}

/// By inverse iteration; `None` where the matrix cannot be solved near its eigenvalue.
fn eigenvector(matrix: &DMatrix<f64>, value: C64) -> Option<DVector<C64>> {
    let n = matrix.nrows();
    let near = value * (1.0 + 1e-10);
    let shifted = DMatrix::from_fn(n, n, |i, j| {
        let own = if i == j { near } else { C64::default() };
        C64::new(matrix[(i, j)], 0.0) - own
    });
    let factor = shifted.lu();
    let mut vector = DVector::from_fn(n, |i, _| C64::new(1.0, 0.3 * (i as f64).sin()));
    for _ in 0..3 {
        vector = factor.solve(&vector)?;
        let norm = vector.norm();
        vector /= C64::new(norm, 0.0);
    }
    vector.iter().all(|z| z.re.is_finite() && z.im.is_finite()).then_some(vector)
}
