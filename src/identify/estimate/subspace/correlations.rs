//! Correlations of the responses over stretches of a record, and their Hankel matrix.

use nalgebra::{DMatrix, DVector, DVectorView};

use super::super::block::C64;

/// Fewer stretches say too little of how much the correlations scatter.
const MIN_STRETCHES: usize = 6;

/// More of them make the deviations hardly surer.
const MAX_STRETCHES: usize = 40;

/// A stretch is so many times as long as the longest lag.
const LENGTH_PER_LAG: usize = 4;

/// Correlations at the lags 0 … 2p, each l × l for l responses.
pub(super) struct Correlations {
    /// Block rows p of the Hankel matrix.
    pub(super) rows: usize,
    /// Over the whole record, by lag.
    mean: Vec<DMatrix<f64>>,
    /// By stretch: how far its own lie from the mean.
    apart: Vec<Vec<DMatrix<f64>>>,
}

impl Correlations {
    /// How many samples so many block rows take.
    pub(super) fn samples_for(rows: usize) -> usize {
        MIN_STRETCHES * LENGTH_PER_LAG * 2 * rows
    }

    /// Of responses of equal length and about equal size, their means taken off. `None` where the
    /// record is too short for so many block rows.
    pub(super) fn of(responses: &[Vec<f64>], rows: usize) -> Option<Self> {
        let samples = responses.first()?.len();
        let lags = 2 * rows;
        let count = (samples / (LENGTH_PER_LAG * lags)).min(MAX_STRETCHES);
        if count < MIN_STRETCHES {
            return None;
        }
        let length = (samples - lags) / count;
        let own: Vec<Vec<DMatrix<f64>>> =
            (0..count).map(|i| of_stretch(responses, i * length, length, lags)).collect();
        let mean = (0..=lags).map(|k| {
            let sum = own.iter().skip(1).fold(own[0][k].clone(), |sum, one| sum + &one[k]);
            sum / count as f64
        });
        let mean: Vec<DMatrix<f64>> = mean.collect();
        let apart = own.into_iter().map(|own| own.into_iter().zip(&mean).map(|(a, b)| a - b));
        Some(Self { rows, apart: apart.map(Iterator::collect).collect(), mean })
    }

    /// Block i, j is the correlation at the lag i + j + 1: pl × pl.
    pub(super) fn hankel(&self) -> DMatrix<f64> {
        let l = self.mean[0].nrows();
        let size = self.rows * l;
        DMatrix::from_fn(size, size, |i, j| self.mean[i / l + j / l + 1][(i % l, j % l)])
    }

    /// aᵀ ΔH w of every stretch, ΔH being the Hankel matrix of how far it lies from the mean.
    pub(super) fn products(&self, a: &DVector<C64>, w: &DVector<C64>) -> Vec<C64> {
        let l = self.mean[0].nrows();
        let mut weights = vec![DMatrix::<C64>::zeros(l, l); self.mean.len()];
        for i in 0..self.rows {
            for j in 0..self.rows {
                let (a, w) = (a.rows(i * l, l), w.rows(j * l, l));
                weights[i + j + 1].ger(C64::new(1.0, 0.0), &a, &w, C64::new(1.0, 0.0));
            }
        }
        let product = |own: &Vec<DMatrix<f64>>| {
            let lags = own.iter().zip(&weights);
            lags.flat_map(|(r, weight)| r.iter().zip(weight).map(|(r, w)| w * *r)).sum()
        };
        self.apart.iter().map(product).collect()
    }

    /// The first block row of ΔH times w, by stretch.
    pub(super) fn first_rows(&self, w: &DVector<C64>) -> Vec<DVector<C64>> {
        let l = self.mean[0].nrows();
        let product = |own: &Vec<DMatrix<f64>>| {
            let mut sum = DVector::<C64>::zeros(l);
            for j in 0..self.rows {
                sum += own[j + 1].map(|r| C64::new(r, 0.0)) * w.rows(j * l, l);
            }
            sum
        };
        self.apart.iter().map(product).collect()
    }
}

/// R_k = 1/m Σ y(t + k) y(t)ᵀ over the samples t of a stretch; t + k may lie behind it.
fn of_stretch(
    responses: &[Vec<f64>],
    from: usize,
    length: usize,
    lags: usize,
) -> Vec<DMatrix<f64>> {
    let l = responses.len();
    let of = |i: usize, at: usize| DVectorView::from_slice(&responses[i][at..at + length], length);
    (0..=lags)
        .map(|k| DMatrix::from_fn(l, l, |i, j| of(i, from + k).dot(&of(j, from)) / length as f64))
        .collect()
}
