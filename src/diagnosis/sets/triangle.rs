//! Normal equations that grow by columns: the Cholesky factor of what is there already stays
//! (Golub & Van Loan, Matrix Computations, 4th ed., 4.2.9).

/// L of A = L Lᵀ, row after row, with L⁻¹ b.
#[derive(Debug, Default)]
pub(super) struct Triangle {
    columns: Vec<usize>,
    /// Rows of L up to their diagonals, one behind the other.
    lower: Vec<f64>,
    forward: Vec<f64>,
}

/// Where row `row` of a packed triangle begins.
fn start(row: usize) -> usize {
    row * (row + 1) / 2
}

impl Triangle {
    /// The columns that were added, in this order.
    pub(super) fn columns(&self) -> &[usize] {
        &self.columns
    }

    /// Adds a column: its products with those that are there and with itself, what is added to the
    /// latter, and its entry of b. `false`, and nothing changes, if A would not be positive
    /// definite.
    pub(super) fn push(
        &mut self,
        column: usize,
        product: impl Fn(usize) -> f64,
        slack: f64,
        along: f64,
    ) -> bool {
        let begin = self.lower.len();
        let mut diagonal = product(column) + slack;
        let mut forward = along;
        for (a, &other) in self.columns.iter().enumerate() {
            let (above, own) = self.lower.split_at(begin);
            let row = &above[start(a)..start(a + 1)];
            let dot: f64 = row.iter().zip(own).map(|(l, own)| l * own).sum();
            let entry = (product(other) - dot) / row[a];
            diagonal -= entry * entry;
            forward -= entry * self.forward[a];
            self.lower.push(entry);
        }
        if diagonal > 0.0 {
            let root = diagonal.sqrt();
            self.lower.push(root);
            self.forward.push(forward / root);
            self.columns.push(column);
            true
        } else {
            self.lower.truncate(begin);
            false
        }
    }

    /// Takes away all columns but the first `count`.
    pub(super) fn truncate(&mut self, count: usize) {
        self.columns.truncate(count);
        self.forward.truncate(count);
        self.lower.truncate(start(count));
    }

    /// x of A x = b.
    pub(super) fn solve(&self, x: &mut Vec<f64>) {
        x.clone_from(&self.forward);
        for a in (0..x.len()).rev() {
            let row = &self.lower[start(a)..start(a + 1)];
            x[a] /= row[a];
            let own = x[a];
            x.iter_mut().zip(&row[..a]).for_each(|(x, l)| *x -= l * own);
        }
    }
}
