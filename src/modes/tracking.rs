//! Which mode at the next pose is which mode of this one: by the modal assurance criterion, weighted
//! with the mass matrix so that rotations and translations compare.

use nalgebra::{DMatrix, DVectorView};

/// Below this MAC a mode has no successor among the next pose's modes.
const LEAST_MAC: f64 = 0.5;

/// What becomes of a mode from one pose to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Follow {
    /// It is the mode with this index (ascending frequency) at the next pose.
    Mode(usize),
    /// No mode of the next pose resembles it enough: the step is too long, or modes turn into each other.
    Lost,
}

/// MAC of two shapes under the mass matrix `m`: (aᵀMb)² / ((aᵀMa)(bᵀMb)), in [0, 1].
pub fn mac(m: &DMatrix<f64>, a: DVectorView<f64>, b: DVectorView<f64>) -> f64 {
    let inner = |x: &DVectorView<f64>, y: &DVectorView<f64>| {
        let mut sum = 0.0;
        for j in 0..m.ncols() {
            let mut column = 0.0;
            for i in 0..m.nrows() {
                column += x[i] * m[(i, j)];
            }
            sum += column * y[j];
        }
        sum
    };
    let cross = inner(&a, &b);
    (cross * cross / (inner(&a, &a) * inner(&b, &b))).min(1.0)
}

/// For each mode of `here` the mode of `next` that it becomes. `mass` is M halfway or at either pose;
/// shapes are n × n, columns in ascending frequency. A mode of `next` is given to one mode of `here`
/// only; with a MAC above one half the choice is unique.
pub fn follow(mass: &DMatrix<f64>, here: &DMatrix<f64>, next: &DMatrix<f64>) -> Vec<Follow> {
    let n = here.ncols();
    let mut taken = vec![false; n];
    (0..n)
        .map(|r| {
            let best = (0..n)
                .map(|s| (s, mac(mass, here.column(r), next.column(s))))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            match best {
                Some((s, value)) if value > LEAST_MAC && !taken[s] => {
                    taken[s] = true;
                    Follow::Mode(s)
                }
                Some(_) | None => Follow::Lost,
            }
        })
        .collect()
}
