//! Noise of a shape: a scale for each mode, a part that all modes of a row have in common, and a
//! drift over the rows. What is common is taken out of residuals and of all that is held against
//! them by one linear map, so that the rest is noise of each frequency alone.
//!
//! With U the scales and s the level, the covariance of the residuals is s² U (I + Z Zᵀ) U: one
//! column of Z for each row, and one for each power of the rows' order. The map is
//! U (I + Z Zᵀ)^(−½) U⁻¹, rows first and drift after them (Harville, J. Am. Stat. Assoc. 72, 1977).

use nalgebra::DMatrix;

/// Highest power of the order of the rows that a drift has.
const POWERS: usize = 3;

/// The shape of the noise, over the scale of single frequencies.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NoiseShape {
    /// By column of the table; 1 beyond the end.
    pub(super) scales: Vec<f64>,
    /// Standard deviation of what a row's modes have in common.
    pub(super) common: f64,
    /// Standard deviation of each power of the drift.
    pub(super) drift: f64,
    /// Log evidence that its parameters cost.
    pub(super) cost: f64,
}

impl NoiseShape {
    /// Each frequency alone, and all alike.
    pub(super) const fn plain() -> Self {
        Self { scales: Vec::new(), common: 0.0, drift: 0.0, cost: 0.0 }
    }

    pub(super) fn scale(&self, column: usize) -> f64 {
        self.scales.get(column).copied().unwrap_or(1.0)
    }

    fn is_correlated(&self) -> bool {
        self.common > 0.0 || self.drift > 0.0
    }
}

/// The linear map that takes out what is common.
#[derive(Debug, Clone, Default)]
pub(super) struct Decorrelation {
    /// Scale of each point.
    units: Vec<f64>,
    /// By row: its points, the unit vector of what they have in common, and how much of it goes.
    rows: Vec<(std::ops::Range<usize>, Vec<f64>, f64)>,
    /// Orthonormal columns of the drift, each with how much of it goes.
    drift: Vec<(Vec<f64>, f64)>,
    /// ln of the map's determinant.
    pub(super) ln_determinant: f64,
    /// What of it the drift's constant part costs.
    pub(super) ln_constant: f64,
}

/// Where a frequency stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct Standing {
    pub(super) row: usize,
    /// From −1, the first row of the table, to 1, the last.
    pub(super) order: f64,
    /// Scale of its noise.
    pub(super) unit: f64,
}

impl Decorrelation {
    /// Of frequencies, row by row, under a shape.
    pub(super) fn of(points: &[Standing], shape: &NoiseShape) -> Self {
        if !shape.is_correlated() {
            return Self::default();
        }
        let mut map = Self { units: points.iter().map(|p| p.unit).collect(), ..Self::default() };
        if shape.common > 0.0 {
            let mut start = 0;
            while start < points.len() {
                let row = points[start].row;
                let end = start + points[start..].iter().take_while(|p| p.row == row).count();
                let along: Vec<f64> =
                    map.units[start..end].iter().map(|unit| shape.common / unit).collect();
                let square: f64 = along.iter().map(|a| a * a).sum();
                let taken = 1.0 - 1.0 / (1.0 + square).sqrt();
                let unit = along.iter().map(|a| a / square.sqrt()).collect();
                map.ln_determinant -= 0.5 * square.ln_1p();
                map.rows.push((start..end, unit, taken));
                start = end;
            }
        }
        if shape.drift > 0.0 {
            map.take_drift(points, shape.drift);
        }
        map
    }

    fn take_drift(&mut self, points: &[Standing], drift: f64) {
        let column = |power: usize| {
            let own = points.iter().map(|p| drift * legendre(power, p.order) / p.unit);
            let mut column: Vec<f64> = own.collect();
            self.rows_out_of(&mut column);
            column
        };
        // What drifts by so much may have been off by as much before the first row.
        let columns: Vec<Vec<f64>> = (0..=POWERS).map(column).collect();
        self.ln_constant = -0.5 * columns[0].iter().map(|own| own * own).sum::<f64>().ln_1p();
        let z = DMatrix::from_fn(points.len(), columns.len(), |i, k| columns[k][i]);
        let eigen = z.tr_mul(&z).symmetric_eigen();
        for (k, &square) in eigen.eigenvalues.iter().enumerate() {
            if square <= 1e-12 {
                continue;
            }
            let direction = &z * eigen.eigenvectors.column(k) / square.sqrt();
            self.ln_determinant -= 0.5 * square.ln_1p();
            let taken = 1.0 - 1.0 / (1.0 + square).sqrt();
            self.drift.push((direction.iter().copied().collect(), taken));
        }
    }

    /// Takes what the rows have in common out of a column in units of the noise.
    fn rows_out_of(&self, column: &mut [f64]) {
        for (range, unit, taken) in &self.rows {
            let own = &mut column[range.clone()];
            let along: f64 = own.iter().zip(unit).map(|(c, u)| c * u).sum();
            own.iter_mut().zip(unit).for_each(|(c, u)| *c -= taken * along * u);
        }
    }

    pub(super) fn is_none(&self) -> bool {
        self.rows.is_empty() && self.drift.is_empty()
    }

    /// Maps a column, one entry a point.
    pub(super) fn apply(&self, column: &mut [f64]) {
        if self.is_none() {
            return;
        }
        column.iter_mut().zip(&self.units).for_each(|(c, unit)| *c /= unit);
        self.rows_out_of(column);
        for (direction, taken) in &self.drift {
            let along: f64 = column.iter().zip(direction).map(|(c, d)| c * d).sum();
            column.iter_mut().zip(direction).for_each(|(c, d)| *c -= taken * along * d);
        }
        column.iter_mut().zip(&self.units).for_each(|(c, unit)| *c *= unit);
    }

    /// Maps residuals; what has no prediction says nothing.
    pub(super) fn of_residuals(&self, residuals: &[Option<f64>]) -> Vec<Option<f64>> {
        if self.is_none() {
            return residuals.to_vec();
        }
        let mut column: Vec<f64> = residuals.iter().map(|r| r.unwrap_or(0.0)).collect();
        self.apply(&mut column);
        residuals.iter().zip(column).map(|(r, mapped)| r.map(|_| mapped)).collect()
    }

    /// Maps slopes, one row a point.
    pub(super) fn of_slopes(&self, slopes: &mut [Vec<f64>]) {
        if self.is_none() {
            return;
        }
        let parameters = slopes.iter().map(Vec::len).max().unwrap_or(0);
        for k in 0..parameters {
            let mut column: Vec<f64> =
                slopes.iter().map(|slope| slope.get(k).copied().unwrap_or(0.0)).collect();
            self.apply(&mut column);
            for (slope, mapped) in slopes.iter_mut().zip(column) {
                if let Some(slope) = slope.get_mut(k) {
                    *slope = mapped;
                }
            }
        }
    }
}

fn legendre(power: usize, x: f64) -> f64 {
    match power {
        0 => 1.0,
        1 => x,
        2 => 0.5 * (3.0 * x * x - 1.0),
        _ => 0.5 * (5.0 * x * x * x - 3.0 * x),
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::tests::data;
    use super::*;

    /// The map squared is the inverse of the covariance, by a dense inverse.
    #[test]
    fn the_map_is_the_root_of_the_inverse_covariance() {
        let shape =
            NoiseShape { scales: vec![0.5, 2.0], common: 1.5, drift: 3.0, ..NoiseShape::plain() };
        let plain = data(9);
        let shaped = plain.shaped(shape.clone());
        let n = shaped.points.len();
        let unit = |i: usize| shaped.points[i].unit;
        let place = |i: usize| {
            let last = shaped.order_of_last as f64;
            2.0 * shaped.rows[shaped.points[i].row].index as f64 / last - 1.0
        };
        let covariance = DMatrix::from_fn(n, n, |i, j| {
            let same_row = f64::from(u8::from(shaped.points[i].row == shaped.points[j].row));
            let own = if i == j { unit(i) * unit(i) } else { 0.0 };
            let drift: f64 =
                (0..=POWERS).map(|k| legendre(k, place(i)) * legendre(k, place(j))).sum();
            own + same_row * 2.25 + 9.0 * drift
        });
        // |C r|² in units of the noise must be rᵀ Σ⁻¹ r.
        let r: Vec<f64> = (0..n).map(|i| (1.7 * i as f64).sin()).collect();
        let mut mapped = r.clone();
        shaped.decorrelation.apply(&mut mapped);
        let square: f64 = (0..n).map(|i| (mapped[i] / unit(i)).powi(2)).sum();
        let r = nalgebra::DVector::from_vec(r);
        let inverse = covariance.clone().try_inverse().unwrap();
        let expected = r.dot(&(&inverse * &r));
        assert!((square / expected - 1.0).abs() < 1e-9, "{square} {expected}");
        let ln_det: f64 =
            covariance.cholesky().unwrap().l().diagonal().iter().map(|l| l.ln()).sum();
        let own: f64 = (0..n).map(|i| unit(i).ln()).sum();
        assert!((shaped.decorrelation.ln_determinant + ln_det - own).abs() < 1e-9);
    }
}
