//! Linear least squares by orthonormal columns: twice by the Cholesky factor of their products
//! (Yamamoto, Nakatsukasa, Yanagisawa & Fukaya, Roundoff error analysis of the CholeskyQR2
//! algorithm, ETNA 44, 2015), which are products of matrices; where columns are nearly dependent by
//! modified Gram–Schmidt, twice where much is lost (Björck, Numerical Methods for Least Squares
//! Problems, §2.4.5).

use std::borrow::Cow;

use nalgebra::{Const, DMatrix, DMatrixView, DMatrixViewMut, DVectorView, Dyn, MatrixView};

/// Orthonormal columns Q that span the given ones.
#[derive(Debug, Clone)]
pub(super) struct Projection {
    /// Q, or columns near it: one for each that was given, rows × columns; zero where it depends on
    /// those before it.
    near: DMatrix<f64>,
    /// Upper triangle U, columns × columns, of Q = `near`·U; Q itself is not needed, as nothing is
    /// lost where U is applied to products with `near`.
    last: Option<DMatrix<f64>>,
    /// Upper triangle, columns × columns: the given columns are Q·R.
    r: DMatrix<f64>,
}

/// One step towards orthonormal columns: those of A are Q·R.
struct Step {
    r: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// What rounding leaves of the columns of A·R⁻¹ in one another.
    lost: f64,
}

impl Step {
    /// `None` where the columns are nearly dependent.
    fn of(columns: &DMatrix<f64>) -> Option<Self> {
        /// What each column, of length one, has beside those before it: with less, digits are lost.
        const INDEPENDENT: f64 = 1e-6;
        let mut gram = products(columns);
        let norms = gram.diagonal().map(f64::sqrt);
        gram.column_iter_mut().zip(&norms).for_each(|(mut column, norm)| column /= *norm);
        gram.row_iter_mut().zip(&norms).for_each(|(mut row, norm)| row /= *norm);
        let upper = gram.cholesky()?.l().transpose();
        // Not less, so that what is no number fails, too.
        if !upper.diagonal().iter().all(|left| *left > INDEPENDENT) {
            return None;
        }
        let identity = DMatrix::identity(upper.nrows(), upper.ncols());
        let mut inverse = upper.solve_upper_triangular(&identity)?;
        // It grows with the square of R⁻¹.
        let lost = f64::EPSILON * inverse.norm_squared();
        inverse.row_iter_mut().zip(&norms).for_each(|(mut row, norm)| row /= *norm);
        Some(Self { r: upper * DMatrix::from_diagonal(&norms), inverse, lost })
    }
}

/// Sums that run side by side, so that the processor need not wait for each.
const SUMS: usize = 8;

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a_parts, a_rest), (b_parts, b_rest)) = (a.as_chunks::<SUMS>(), b.as_chunks::<SUMS>());
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; SUMS];
    for (a, b) in a_parts.iter().zip(b_parts) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Columns that are multiplied together: products of matrices are fast from so many on, and what a
/// triangle does not need is left out in steps of as many.
const STEP: usize = 16;

/// `to` = AᵀB with the first columns of A, as many as `to` has rows.
fn transposed_times(a: &DMatrix<f64>, b: DMatrixView<f64>, mut to: DMatrixViewMut<f64>) {
    /// From so many on nalgebra multiplies by blocks that stay in the cache.
    const LARGE: usize = 6;
    let (rows, columns) = (a.nrows(), to.nrows());
    if rows.min(columns).min(b.ncols()) < LARGE {
        return to.gemm_tr(1.0, &a.columns(0, columns), &b, 0.0);
    }
    // `gemm_tr` multiplies large ones column by column, too.
    let of_a = &a.as_slice()[..rows * columns];
    let transposed = MatrixView::<f64, Dyn, Dyn, Dyn, Const<1>>::from_slice_with_strides_generic(
        of_a,
        Dyn(columns),
        Dyn(rows),
        Dyn(rows),
        Const,
    );
    to.gemm(1.0, &transposed, &b, 0.0);
}

/// AᵀA.
pub(super) fn products(a: &DMatrix<f64>) -> DMatrix<f64> {
    let count = a.ncols();
    let mut products = DMatrix::zeros(count, count);
    for first in (0..count).step_by(STEP) {
        let own = STEP.min(count - first);
        // With all up to these.
        let rows = first + own;
        let to = products.view_mut((0, first), (rows, own));
        transposed_times(a, a.columns(first, own), to);
    }
    products.fill_lower_triangle_with_upper_triangle();
    products
}

/// A U of an upper triangle U.
fn times_triangle(a: &DMatrix<f64>, upper: &DMatrix<f64>) -> DMatrix<f64> {
    let count = a.ncols();
    let mut product = DMatrix::zeros(a.nrows(), count);
    for first in (0..count).step_by(STEP) {
        let own = STEP.min(count - first);
        let rows = first + own;
        product.columns_mut(first, own).gemm(
            1.0,
            &a.columns(0, rows),
            &upper.view((0, first), (rows, own)),
            0.0,
        );
    }
    product
}

fn subtract(from: &mut [f64], factor: f64, column: &[f64]) {
    from.iter_mut().zip(column).for_each(|(f, c)| *f -= factor * c);
}

impl Projection {
    /// Of the columns of a matrix.
    pub(super) fn of(columns: DMatrix<f64>) -> Self {
        /// From so many columns on products of matrices are faster.
        const MIN_COLUMNS: usize = 4;
        if columns.ncols() < MIN_COLUMNS {
            return Self::one_by_one(columns);
        }
        Self::by_products(columns).unwrap_or_else(Self::one_by_one)
    }

    /// The columns themselves where they are nearly dependent.
    fn by_products(columns: DMatrix<f64>) -> Result<Self, DMatrix<f64>> {
        /// What is left of columns in one another is as nothing, and once is enough.
        const ORTHOGONAL: f64 = 1e-12;
        let Some(first) = Step::of(&columns) else { return Err(columns) };
        if first.lost < ORTHOGONAL {
            return Ok(Self { near: columns, last: Some(first.inverse), r: first.r });
        }
        let near = times_triangle(&columns, &first.inverse);
        let Some(second) = Step::of(&near) else { return Err(columns) };
        Ok(Self { near, last: Some(second.inverse), r: second.r * first.r })
    }

    fn one_by_one(mut q: DMatrix<f64>) -> Self {
        let (rows, count) = q.shape();
        let mut r = DMatrix::zeros(count, count);
        for at in 0..count {
            let (before, rest) = q.as_mut_slice().split_at_mut(at * rows);
            let column = &mut rest[..rows];
            let whole = dot(column, column).sqrt();
            for pass in 0..2 {
                let norm = dot(column, column).sqrt();
                for (i, q) in before.chunks_exact(rows.max(1)).enumerate() {
                    let share = dot(q, column);
                    subtract(column, share, q);
                    r[(i, at)] += share;
                }
                // Once is enough where little was taken away.
                if pass == 0 && dot(column, column).sqrt() > 0.7 * norm {
                    break;
                }
            }
            let left = dot(column, column).sqrt();
            // Else it depends on those before it.
            if left > 1e-9 * whole && left.is_finite() {
                column.iter_mut().for_each(|c| *c /= left);
                r[(at, at)] = left;
            } else {
                column.fill(0.0);
            }
        }
        Self { near: q, last: None, r }
    }

    /// What of `column` lies outside of the span; in place.
    pub(super) fn remove(&self, column: &mut [f64]) {
        let shares = self.shares(DMatrixView::from_slice(column, column.len(), 1));
        self.remove_shares(column, shares.as_slice());
    }

    /// A column without its shares in the orthonormal ones; in place.
    pub(super) fn remove_shares(&self, column: &mut [f64], shares: &[f64]) {
        let shares = DVectorView::from_slice(shares, shares.len());
        let factors = self.last.as_ref().map_or_else(|| shares.into_owned(), |last| last * shares);
        for (near, factor) in self.near.column_iter().zip(&factors) {
            subtract(column, *factor, near.as_slice());
        }
    }

    /// What of each column lies outside of the span; in place.
    pub(super) fn remove_from_all(&self, columns: &mut DMatrix<f64>) {
        let shares = self.shares(columns.as_view());
        let factors = self.last.as_ref().map_or_else(|| shares.clone(), |last| last * &shares);
        columns.gemm(-1.0, &self.near, &factors, 1.0);
    }

    /// The share of each target (rows × targets) in each orthonormal column, columns × targets.
    pub(super) fn shares(&self, targets: DMatrixView<f64>) -> DMatrix<f64> {
        let mut shares = DMatrix::zeros(self.near.ncols(), targets.ncols());
        transposed_times(&self.near, targets, shares.as_view_mut());
        self.last.as_ref().map_or_else(|| shares.clone(), |last| last.tr_mul(&shares))
    }

    /// R⁻¹ · shares: the factors of the columns whose sum is nearest to what has these shares; zero
    /// for dependent columns.
    pub(super) fn back(&self, shares: &[f64]) -> Vec<f64> {
        let mut shares = shares.to_vec();
        for i in (0..shares.len()).rev() {
            let diagonal = self.r[(i, i)];
            shares[i] = if diagonal > 0.0 { shares[i] / diagonal } else { 0.0 };
            for j in 0..i {
                shares[j] -= self.r[(j, i)] * shares[i];
            }
        }
        shares
    }

    /// Columns of R⁻¹: the inverse of the normal matrix is their product with their transpose.
    pub(super) fn inverse_triangle(&self) -> Vec<Vec<f64>> {
        let count = self.r.ncols();
        let column = |i: usize| {
            let mut unit = vec![0.0; count];
            unit[i] = if self.r[(i, i)] > 0.0 { 1.0 } else { 0.0 };
            self.back(&unit)
        };
        (0..count).map(column).collect()
    }

    /// Orthonormal columns that span what is projected on.
    pub(super) fn span(&self) -> Cow<'_, DMatrix<f64>> {
        match &self.last {
            Some(last) => Cow::Owned(times_triangle(&self.near, last)),
            None => Cow::Borrowed(&self.near),
        }
    }

    /// Leverage of each of so many rows: the fraction of its noise that the columns absorb.
    pub(super) fn leverages(&self, rows: usize) -> Vec<f64> {
        let mut sums = vec![0.0; rows];
        for q in self.span().column_iter() {
            sums.iter_mut().zip(q.iter()).for_each(|(sum, q)| *sum += q * q);
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;

    fn column(rows: usize, of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..rows).map(|k| of(k as f64 / rows as f64)).collect()
    }

    /// Both ways span the same, with the same factors, and a column that depends on others changes
    /// nothing.
    #[test]
    fn products_and_gram_schmidt_span_the_same() {
        const ROWS: usize = 400;
        let given: Vec<Vec<f64>> = (1..8_u8)
            .map(|i| column(ROWS, |x| 1e3 * (f64::from(i) * 2.0 * x).cos() + f64::from(i)))
            .collect();
        let target = column(ROWS, |x| (9.0 * x).sin() + x);
        let matrix =
            |columns: &[Vec<f64>]| DMatrix::from_vec(ROWS, columns.len(), columns.concat());
        let fast = Projection::by_products(matrix(&given)).unwrap();
        let slow = Projection::one_by_one(matrix(&given));
        let mut dependent = given.clone();
        dependent.push(given[2].iter().zip(&given[5]).map(|(a, b)| 2.0 * a - b).collect());
        assert!(Projection::by_products(matrix(&dependent)).is_err());
        let more = Projection::of(matrix(&dependent));
        let factors = |of: &Projection| {
            of.back(of.shares(DMatrixView::from_slice(&target, ROWS, 1)).as_slice())
        };
        let expected = factors(&slow);
        for found in [factors(&fast), factors(&more)] {
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found / expected - 1.0).abs() < 1e-7, "{found} {expected}");
            }
        }
        let left = |of: &Projection| {
            let mut left = target.clone();
            of.remove(&mut left);
            dot(&left, &left)
        };
        let sum: Vec<f64> = (0..ROWS)
            .map(|k| target[k] - given.iter().zip(&expected).map(|(c, f)| c[k] * f).sum::<f64>())
            .collect();
        for of in [&fast, &slow, &more] {
            assert!((left(of) / dot(&sum, &sum) - 1.0).abs() < 1e-9);
            let absorbed: f64 = of.leverages(ROWS).iter().sum();
            assert!((absorbed - 7.0).abs() < 1e-9, "{absorbed}");
        }
        assert_eq!(more.inverse_triangle()[7], vec![0.0; 8]);
    }

    /// More columns than are taken at once, some of which depend on others by far.
    #[test]
    fn many_columns_are_orthonormal_and_give_the_given_ones_back() {
        const ROWS: usize = 300;
        const COUNT: usize = 3 * STEP + 5;
        let at = |i: usize, k: usize| (0.05 * (i * k) as f64).cos() + 1e-3 * (i + k) as f64;
        let mut given = DMatrix::from_fn(ROWS, COUNT, |k, i| at(i, k));
        // One depends on others, and one nearly.
        let sum = given.column(3) - 2.0 * given.column(20);
        given.set_column(STEP + 1, &sum);
        let other = DVector::from_fn(ROWS, |k, _| 1e-6 * (0.7 * (k * k) as f64).sin());
        let near = given.column(5) + other;
        given.set_column(2 * STEP + 3, &near);
        for of in [Projection::one_by_one(given.clone()), Projection::of(given.clone())] {
            let is_own = |i: usize| f64::from(u8::from(of.r[(i, i)] > 0.0));
            let unit = DMatrix::from_fn(COUNT, COUNT, |i, j| if i == j { is_own(i) } else { 0.0 });
            let q = of.span();
            assert!((products(&q) - &unit).amax() < 1e-12);
            assert!((&*q * &of.r - &given).amax() < 1e-8);
            assert_eq!(unit.trace(), (COUNT - 1) as f64);
        }
        let upper = given.rows(0, COUNT).upper_triangle();
        assert!((times_triangle(&given, &upper) - &given * &upper).amax() < 1e-9);
        assert!((products(&given) - given.transpose() * &given).amax() < 1e-9);
    }
}
