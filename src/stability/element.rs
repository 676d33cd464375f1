//! The modes over a short time under a force that is a polynomial in it.
//!
//! The force is known at the nodes of Gauss and Legendre, and the modes answer the polynomial
//! through them exactly (Duhamel's integral), however stiff they are.

use nalgebra::{Matrix2, SMatrix, Vector2};

use super::mode::ToolMode;

/// Nodes of an element.
pub(super) const NODES: usize = 12;

/// Points of the quadrature of Duhamel's integral: the kernel times the polynomial.
const POINTS: usize = 20;

/// Places of the tip in an element: along x and y at all nodes.
pub(super) const PLACES: usize = 2 * NODES;

/// Forces in an element: along x, y and z at all nodes.
pub(super) const FORCES: usize = 3 * NODES;

/// Displacement along x and y at all nodes.
pub(super) type AtNodes = [f64; PLACES];

/// Linear from forces along x, y and z at all nodes to displacements there.
type Answer = SMatrix<f64, PLACES, FORCES>;

/// Adds a column times a factor.
#[inline(always)]
#[allow(
    clippy::needless_range_loop,
    reason = "becomes vector instructions, which iterators do not"
)]
pub(super) fn add<const N: usize>(sum: &mut [f64; N], column: &[f64; N], by: f64) {
    for i in 0..N {
        sum[i] += column[i] * by;
    }
}

/// The sum of the products, four side by side.
#[inline(always)]
fn dot(a: &[f64; FORCES], b: &[f64; FORCES]) -> f64 {
    let mut sums = [0.0; 4];
    for i in 0..FORCES / 4 {
        for (lane, sum) in sums.iter_mut().enumerate() {
            *sum += a[4 * i + lane] * b[4 * i + lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3])
}

/// Nodes and weights of Gauss and Legendre on −1..1.
fn gauss<const N: usize>() -> [(f64, f64); N] {
    std::array::from_fn(|i| {
        let n = N as f64;
        let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        // Newton's iteration on the Legendre polynomial.
        for _ in 0..50 {
            let (mut before, mut here) = (1.0, x);
            for k in 2..=N {
                let k = k as f64;
                (before, here) = (here, ((2.0 * k - 1.0) * x * here - (k - 1.0) * before) / k);
            }
            slope = n * (x * here - before) / (x * x - 1.0);
            let step = here / slope;
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    })
}

/// Places of the nodes as shares of an element, and the weights that interpolate between them.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    pub(super) shares: [f64; NODES],
    barycentric: [f64; NODES],
    quadrature: [(f64, f64); POINTS],
    /// The slopes at the nodes of the polynomials that are 1 at one node, per length.
    pub(super) slopes: [[f64; NODES]; NODES],
}

impl Nodes {
    pub(super) fn new() -> Self {
        let shares = gauss::<NODES>().map(|(x, _)| 0.5 * (x + 1.0));
        let barycentric: [f64; NODES] = std::array::from_fn(|j| {
            let others = (0..NODES).filter(|&k| k != j);
            others.map(|k| shares[j] - shares[k]).product::<f64>().recip()
        });
        let quadrature = gauss::<POINTS>().map(|(x, weight)| (0.5 * (x + 1.0), 0.5 * weight));
        let slope = |i: usize, j: usize| barycentric[j] / barycentric[i] / (shares[i] - shares[j]);
        let slopes = std::array::from_fn(|i| {
            let others = (0..NODES).filter(|&j| j != i);
            let own = -others.map(|j| slope(i, j)).sum::<f64>();
            std::array::from_fn(|j| if i == j { own } else { slope(i, j) })
        });
        Self { shares, barycentric, quadrature, slopes }
    }

    /// The weights of the nodes' values in the polynomial through them, at a share of the element.
    pub(super) fn weights(&self, share: f64) -> [f64; NODES] {
        if let Some(at) = self.shares.iter().position(|&node| (node - share).abs() < 1e-14) {
            return std::array::from_fn(|j| if j == at { 1.0 } else { 0.0 });
        }
        let parts: [f64; NODES] =
            std::array::from_fn(|j| self.barycentric[j] / (share - self.shares[j]));
        let sum: f64 = parts.iter().sum();
        parts.map(|part| part / sum)
    }
}

/// A mode's coordinate, scaled to the motion of the tip, and its rate over ω_r: both in metres.
pub(super) type State = Vector2<f64>;

/// The free motion of a mode over a time.
pub(super) fn free(mode: &ToolMode, time_s: f64) -> Matrix2<f64> {
    let (w, zeta) = (mode.omega_rad_per_s, mode.damping_ratio);
    let share = (1.0 - zeta * zeta).sqrt();
    let decay = (-zeta * w * time_s).exp();
    let (sin, cos) = (w * share * time_s).sin_cos();
    let (sin, cos) = (decay * sin / share, decay * cos);
    Matrix2::new(cos + zeta * sin, sin, -sin, cos - zeta * sin)
}

/// What all modes do over an element of some length.
#[derive(Debug, Clone)]
pub(super) struct Element {
    pub(super) length_s: f64,
    /// The tip at the nodes without force, by component of the modes' states.
    up_to: Vec<AtNodes>,
    /// Per mode, the free motion up to the end.
    through: Vec<Matrix2<f64>>,
    /// Per mode and component of its state at the end, what each force adds to it.
    gained: Vec<[[f64; FORCES]; 2]>,
    pub(super) answer: Answer,
}

impl Element {
    pub(super) fn new(modes: &[ToolMode], nodes: &Nodes, length_s: f64) -> Self {
        let mut answer = Answer::zeros();
        let (mut up_to, mut through, mut gained) = (Vec::new(), Vec::new(), Vec::new());
        for mode in modes {
            let direction = mode.motion / mode.motion.norm();
            let free_at = nodes.shares.map(|share| free(mode, share * length_s));
            up_to.extend([0, 1].map(|component| -> AtNodes {
                std::array::from_fn(|i| direction[i % 2] * free_at[i / 2][(0, component)])
            }));
            through.push(free(mode, length_s));
            let scale = mode.motion.norm();
            for (i, &share) in nodes.shares.iter().enumerate() {
                let rows = duhamel(mode, nodes, length_s, share);
                for (j, row) in rows.iter().enumerate() {
                    for a in 0..2 {
                        for b in 0..3 {
                            answer[(2 * i + a, 3 * j + b)] +=
                                mode.motion[a] * mode.motion[b] * row[0];
                        }
                    }
                }
            }
            let rows = duhamel(mode, nodes, length_s, 1.0);
            gained.push([0, 1].map(|component| {
                std::array::from_fn(|i| scale * rows[i / 3][component] * mode.motion[i % 3])
            }));
        }
        Self { length_s, up_to, through, gained, answer }
    }

    /// The tip at the nodes without force; `states` of all modes one behind the other.
    pub(super) fn free_at_nodes(&self, states: &[f64]) -> AtNodes {
        let mut sum = [0.0; PLACES];
        for (column, &state) in self.up_to.iter().zip(states) {
            add(&mut sum, column, state);
        }
        sum
    }

    /// Moves the states to the end under the forces at the nodes.
    pub(super) fn move_on(&self, states: &mut [f64], forces: &[f64; FORCES]) {
        let modes = self.through.iter().zip(&self.gained);
        for ((through, [of_place, of_rate]), state) in modes.zip(states.chunks_exact_mut(2)) {
            let end = through * State::new(state[0], state[1]);
            state[0] = end[0] + dot(of_place, forces);
            state[1] = end[1] + dot(of_rate, forces);
        }
    }
}

/// The state (coordinate and rate over ω) at a share of an element for a unit of modal force at
/// each node, the mode at rest before.
fn duhamel(mode: &ToolMode, nodes: &Nodes, length_s: f64, share: f64) -> [State; NODES] {
    let mut sum = [State::zeros(); NODES];
    for &(at, weight) in &nodes.quadrature {
        let at = at * share;
        let kernel = free(mode, (share - at) * length_s);
        let kernel = Vector2::new(kernel[(0, 1)], kernel[(1, 1)]);
        let kernel = kernel * (weight * share * length_s / mode.omega_rad_per_s);
        for (sum, part) in sum.iter_mut().zip(nodes.weights(at)) {
            *sum += kernel * part;
        }
    }
    sum
}
