//! Linear least squares by orthonormal columns (modified Gram–Schmidt, twice where much is lost:
//! Björck, Numerical Methods for Least Squares Problems, §2.4.5).

/// Orthonormal columns that span the given ones.
#[derive(Debug, Clone, Default)]
pub(super) struct Projection {
    /// Orthonormal columns; empty where the given column depends on those before it.
    q: Vec<Vec<f64>>,
    /// Upper triangle, by columns.
    r: Vec<Vec<f64>>,
}

/// Sums that run side by side, so that the processor need not wait for each.
const SUMS: usize = 8;

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a_parts, b_parts) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest: f64 = a_parts.remainder().iter().zip(b_parts.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; SUMS];
    for (a, b) in a_parts.zip(b_parts) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

fn subtract(from: &mut [f64], factor: f64, column: &[f64]) {
    from.iter_mut().zip(column).for_each(|(f, c)| *f -= factor * c);
}

impl Projection {
    /// Adds a column to those that are spanned.
    pub(super) fn push(&mut self, mut column: Vec<f64>) {
        let before = dot(&column, &column).sqrt();
        let mut r = vec![0.0; self.q.len() + 1];
        for pass in 0..2 {
            let norm = dot(&column, &column).sqrt();
            for (q, r) in self.q.iter().zip(&mut r).filter(|(q, _)| !q.is_empty()) {
                let share = dot(q, &column);
                subtract(&mut column, share, q);
                *r += share;
            }
            // Once is enough where little was taken away.
            if pass == 0 && dot(&column, &column).sqrt() > 0.7 * norm {
                break;
            }
        }
        let left = dot(&column, &column).sqrt();
        // Else it depends on those before it.
        if left > 1e-9 * before && left.is_finite() {
            column.iter_mut().for_each(|c| *c /= left);
            r[self.q.len()] = left;
            self.q.push(column);
        } else {
            self.q.push(Vec::new());
        }
        self.r.push(r);
    }

    /// Number of columns given.
    pub(super) fn len(&self) -> usize {
        self.q.len()
    }

    /// What of `column` lies outside of the span; in place.
    pub(super) fn remove(&self, column: &mut [f64]) {
        for q in self.q.iter().filter(|q| !q.is_empty()) {
            let share = dot(q, column);
            subtract(column, share, q);
        }
    }

    /// The share of `target` in each orthonormal column.
    pub(super) fn shares(&self, target: &[f64]) -> Vec<f64> {
        self.q.iter().map(|q| if q.is_empty() { 0.0 } else { dot(q, target) }).collect()
    }

    /// R⁻¹ · shares: the factors of the columns whose sum is nearest to what has these shares; zero
    /// for dependent columns.
    pub(super) fn back(&self, mut shares: Vec<f64>) -> Vec<f64> {
        for i in (0..shares.len()).rev() {
            let diagonal = self.r[i][i];
            shares[i] = if diagonal > 0.0 { shares[i] / diagonal } else { 0.0 };
            for j in 0..i {
                shares[j] -= self.r[i][j] * shares[i];
            }
        }
        shares
    }

    /// Columns of R⁻¹: the inverse of the normal matrix is their product with their transpose.
    pub(super) fn inverse_triangle(&self) -> Vec<Vec<f64>> {
        (0..self.len())
            .map(|i| {
                let mut unit = vec![0.0; self.len()];
                unit[i] = if self.q[i].is_empty() { 0.0 } else { 1.0 };
                self.back(unit)
            })
            .collect()
    }

    /// Leverage of each row: the fraction of its noise that the columns absorb.
    pub(super) fn leverages(&self, rows: usize) -> Vec<f64> {
        let mut sums = vec![0.0; rows];
        for q in &self.q {
            sums.iter_mut().zip(q).for_each(|(sum, q)| *sum += q * q);
        }
        sums
    }
}
