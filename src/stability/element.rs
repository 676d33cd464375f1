//! The modes over a short time under a force that is a polynomial in it.
//!
//! The force is known at the nodes of Gauss and Legendre, and the modes answer the polynomial
//! through them exactly (Duhamel's integral), however stiff they are.

use nalgebra::{Matrix2, SMatrix, Vector2, Vector3};

use super::mode::ToolMode;

/// Nodes of an element.
pub(super) const NODES: usize = 12;

/// Points of the quadrature of Duhamel's integral: the kernel times the polynomial.
const POINTS: usize = 20;

/// Displacement along x and y at all nodes.
pub(super) type AtNodes = nalgebra::SVector<f64, { 2 * NODES }>;

/// Linear from forces along x, y and z at all nodes to displacements there.
type Answer = SMatrix<f64, { 2 * NODES }, { 3 * NODES }>;

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
    /// Per mode, the free motion up to each node: rows of coordinate over state.
    up_to: Vec<[[f64; 2]; NODES]>,
    /// Per mode, the free motion up to the end.
    pub(super) through: Vec<Matrix2<f64>>,
    /// Per mode, its state at the end for a unit of modal force at each node.
    gained: Vec<[State; NODES]>,
    pub(super) answer: Answer,
}

impl Element {
    pub(super) fn new(modes: &[ToolMode], nodes: &Nodes, length_s: f64) -> Self {
        let mut answer = Answer::zeros();
        let (mut up_to, mut through, mut gained) = (Vec::new(), Vec::new(), Vec::new());
        for mode in modes {
            up_to.push(nodes.shares.map(|share| {
                let free = free(mode, share * length_s);
                [free[(0, 0)], free[(0, 1)]]
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
            gained.push(duhamel(mode, nodes, length_s, 1.0).map(|row| row * scale));
        }
        Self { length_s, up_to, through, gained, answer }
    }

    /// The tip at the nodes without force.
    pub(super) fn free_at_nodes(&self, modes: &[ToolMode], states: &[State]) -> AtNodes {
        let mut sum = AtNodes::zeros();
        for ((mode, state), up_to) in modes.iter().zip(states).zip(&self.up_to) {
            let direction = mode.motion / mode.motion.norm();
            for (i, [of_place, of_rate]) in up_to.iter().enumerate() {
                let coordinate = of_place * state[0] + of_rate * state[1];
                sum[2 * i] += direction[0] * coordinate;
                sum[2 * i + 1] += direction[1] * coordinate;
            }
        }
        sum
    }

    /// Moves the states to the end under the forces at the nodes.
    pub(super) fn move_on(
        &self,
        modes: &[ToolMode],
        states: &mut [State],
        forces: &[Vector3<f64>; NODES],
    ) {
        for (r, (mode, state)) in modes.iter().zip(states).enumerate() {
            let mut end = self.through[r] * *state;
            for (gained, force) in self.gained[r].iter().zip(forces) {
                end += gained * mode.motion.dot(force);
            }
            *state = end;
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
