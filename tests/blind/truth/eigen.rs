//! The lowest frequencies of K φ = λ M φ by bisection: by Sylvester's law of inertia K − λ M has as many
//! negative pivots as there are eigenvalues below λ.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

/// Eigenvalues below `lambda`.
fn count_below(k: &DMatrix<f64>, m: &DMatrix<f64>, lambda: f64) -> usize {
    let n = k.nrows();
    let mut a = k - m * lambda;
    let mut negative = 0;
    for p in 0..n {
        let tiny = f64::EPSILON * k[(p, p)].abs() * 1e-3;
        let pivot = if a[(p, p)].abs() < tiny { -tiny } else { a[(p, p)] };
        negative += usize::from(pivot < 0.0);
        for i in p + 1..n {
            let factor = a[(i, p)] / pivot;
            for j in p + 1..n {
                a[(i, j)] -= factor * a[(p, j)];
            }
        }
    }
    negative
}

/// The `wanted` lowest frequencies, Hz, ascending; fewer where M is singular and the rest are infinite.
/// K must be symmetric, M symmetric and not negative.
pub(crate) fn lowest_hz(k: &DMatrix<f64>, m: &DMatrix<f64>, wanted: usize) -> Vec<f64> {
    // Of λ: 1e-4 Hz to 1e6 Hz.
    let (floor, ceiling) = ((1e-4 * TAU).powi(2), (1e6 * TAU).powi(2));
    let mut found = Vec::with_capacity(wanted);
    let mut from = floor;
    for r in 0..wanted.min(k.nrows()) {
        if count_below(k, m, ceiling) <= r {
            break;
        }
        let (mut low, mut high) = (from, ceiling);
        // In the logarithm down to a factor of two, then plainly to the last bit.
        while high / low > 2.0 {
            let middle = (low * high).sqrt();
            if count_below(k, m, middle) > r { high = middle } else { low = middle }
        }
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high || high - low < 1e-14 * high {
                break;
            }
            if count_below(k, m, middle) > r { high = middle } else { low = middle }
        }
        found.push((0.5 * (low + high)).sqrt() / TAU);
        from = low;
    }
    found
}
