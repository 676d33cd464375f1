//! Which mode at the next pose is which mode of this one: by the modal assurance criterion,
//! weighted with the mass matrix so that rotations and translations compare.

use nalgebra::{DMatrix, DVectorView};

/// Below this MAC a mode has no successor among the next pose's modes.
const MIN_MAC: f64 = 0.5;

/// What becomes of a mode from one pose to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Follow {
    /// It is the mode with this index (ascending frequency) at the next pose.
    Mode(usize),
    /// No mode of the next pose resembles it enough: the step is too long, or modes turn into each
    /// other.
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

/// Follows modes from pose to pose, in buffers of its own.
#[derive(Debug, Clone)]
pub struct Tracker {
    weighted: DMatrix<f64>,
    cross: DMatrix<f64>,
    taken: Vec<bool>,
    successors: Vec<Follow>,
    least_mac: f64,
}

impl Tracker {
    /// Buffers for `modes` modes.
    pub fn new(modes: usize) -> Self {
        Self {
            weighted: DMatrix::zeros(modes, modes),
            cross: DMatrix::zeros(modes, modes),
            taken: vec![false; modes],
            successors: vec![Follow::Lost; modes],
            least_mac: 1.0,
        }
    }

    /// For each mode of `here` the mode of `next` that it becomes. `mass` is M at `next`; shapes
    /// are n × n, columns in ascending frequency, those of `next` mass-normalised. A mode of `next`
    /// is given to one mode of `here` only; with a MAC above one half the choice is unique.
    pub fn follow(
        &mut self,
        mass: &DMatrix<f64>,
        here: &DMatrix<f64>,
        next: &DMatrix<f64>,
    ) -> &[Follow] {
        let n = here.ncols();
        // Written out: the library's product of small dynamic matrices allocates.
        for s in 0..n {
            for i in 0..n {
                self.weighted[(i, s)] = (0..n).map(|k| mass[(i, k)] * next[(k, s)]).sum();
            }
            for r in 0..n {
                self.cross[(r, s)] = (0..n).map(|k| here[(k, r)] * self.weighted[(k, s)]).sum();
            }
        }
        self.taken.fill(false);
        self.least_mac = 1.0;
        for r in 0..n {
            // next is an orthonormal basis under M, so the squares of a row add up to the norm of
            // `here`.
            let (mut norm, mut best, mut at) = (0.0, 0.0, 0);
            for s in 0..n {
                let square = self.cross[(r, s)] * self.cross[(r, s)];
                norm += square;
                if square > best {
                    (best, at) = (square, s);
                }
            }
            let mac = best / norm;
            self.least_mac = self.least_mac.min(mac);
            self.successors[r] = if mac > MIN_MAC && !self.taken[at] {
                self.taken[at] = true;
                Follow::Mode(at)
            } else {
                Follow::Lost
            };
        }
        &self.successors
    }

    /// The smallest MAC by which a mode was followed in the last [`Self::follow`].
    pub fn least_mac(&self) -> f64 {
        self.least_mac
    }
}
