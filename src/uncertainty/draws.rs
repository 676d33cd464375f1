//! Quasi-random draws of everything that may be wrong, and shares of them with their error.

use statrs::distribution::{ContinuousCDF, Normal};

/// Sequences that are scrambled independently of each other: their spread is the error of a share.
const REPLICATES: usize = 16;

/// Standard normal draws: points of Sobol sequences with Owen's scrambling, through the inverse of
/// the normal distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Draws {
    dimensions: usize,
    /// One row a draw, sequence after sequence.
    rows: Vec<f64>,
}

/// A share of the draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The share; never below one over the number of draws.
    pub probability: f64,
    /// Its standard error.
    pub std_error: f64,
    /// Whether no draw at all is in it: the probability is below the one that stands here.
    pub is_bound: bool,
}

impl Draws {
    /// Sixteen sequences of so many draws each, at most 65 536; the same for the same seed.
    /// Dimensions beyond the 256 that the sequence has repeat the first ones with another
    /// scrambling.
    pub fn new(dimensions: usize, per_sequence: usize, seed: u32) -> Self {
        /// As many as the sequence has.
        const POINTS: usize = 1 << 16;
        let normal = Normal::standard();
        let value = |sequence: usize, index: usize, dimension: usize| {
            let block = (dimension as u32) / sobol_burley::NUM_DIMENSIONS;
            let seed = seed
                .wrapping_mul(0x9E37_79B9)
                .wrapping_add((sequence as u32) << 8)
                .wrapping_add(block);
            let dimension = dimension as u32 % sobol_burley::NUM_DIMENSIONS;
            let uniform = f64::from(sobol_burley::sample(index as u32, dimension, seed));
            // The points are those of a grid of 2⁻²⁴; zero has no normal value.
            normal.inverse_cdf(uniform.clamp(2.0_f64.powi(-25), 1.0 - 2.0_f64.powi(-25)))
        };
        let per_sequence = per_sequence.clamp(1, POINTS);
        let mut rows = Vec::with_capacity(REPLICATES * per_sequence * dimensions);
        for sequence in 0..REPLICATES {
            for index in 0..per_sequence {
                rows.extend((0..dimensions).map(|k| value(sequence, index, k)));
            }
        }
        Self { dimensions, rows }
    }

    /// How many values one has.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.rows.len() / self.dimensions.max(1)
    }

    /// One draw.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.rows[i * self.dimensions..][..self.dimensions]
    }

    /// The share of draws that are in a set.
    pub fn share(hits: &[bool]) -> Estimate {
        let count = hits.len().max(1);
        let share = |part: &[bool]| {
            part.iter().filter(|hit| **hit).count() as f64 / part.len().max(1) as f64
        };
        let of_sequences: Vec<f64> = hits.chunks(count.div_ceil(REPLICATES)).map(share).collect();
        let (k, mean) = (of_sequences.len() as f64, share(hits));
        let spread: f64 = of_sequences.iter().map(|p| (p - mean).powi(2)).sum();
        let least = 1.0 / count as f64;
        Estimate {
            probability: mean.max(least),
            std_error: (spread / (k * (k - 1.0).max(1.0))).sqrt().max(0.5 * least),
            is_bound: mean == 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_are_normal_and_independent() {
        let draws = Draws::new(5, 256, 3);
        let count = draws.count() as f64;
        assert_eq!(draws.count(), 4096);
        for a in 0..5 {
            let mean = (0..4096).map(|i| draws.row(i)[a]).sum::<f64>() / count;
            assert!(mean.abs() < 2e-3, "{mean}");
            for b in 0..5 {
                let product = (0..4096).map(|i| draws.row(i)[a] * draws.row(i)[b]).sum::<f64>();
                let expected = f64::from(u8::from(a == b));
                assert!((product / count - expected).abs() < 0.03, "{a} {b}: {product}");
            }
        }
        assert_eq!(draws, Draws::new(5, 256, 3));
        assert_ne!(draws, Draws::new(5, 256, 4));
    }

    #[test]
    fn a_share_has_the_error_that_its_sequences_show() {
        let draws = Draws::new(1, 64, 1);
        let hits: Vec<bool> = (0..draws.count()).map(|i| draws.row(i)[0] > 1.0).collect();
        let found = Draws::share(&hits);
        // 1 − Φ(1).
        assert!((found.probability - 0.158655).abs() < 4.0 * found.std_error, "{found:?}");
        assert!(!found.is_bound && found.std_error < 0.004);
        let none = Draws::share(&vec![false; 1024]);
        assert!(none.is_bound && none.probability == 1.0 / 1024.0, "{none:?}");
    }
}
