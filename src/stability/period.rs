//! The motion over one period as a linear map: of the modes' states, and of where the tip was at
//! the nodes of the elements in which there is force.
//!
//! The state and the tip's places of the period before give those of this one. Where a delay is
//! not the period, the place then is interpolated within the element that it lies in. What damps
//! takes the rate of the tip from the polynomial through its places at the nodes.

use nalgebra::{Const, DVector, LU, Matrix2, Matrix3x2, SMatrix, Vector2, Vector3};

use super::element::{AtNodes, Element, NODES, Nodes, State, free};
use super::milling::{Process, Term};
use super::mode::ToolMode;

/// The fastest mode turns at most this far in an element, rad; so does the force.
const MAX_OF_MODE_RAD: f64 = 3.0;
const MAX_OF_FORCE_RAD: f64 = 1.6;

/// More elements with force than this are refused: their cost grows with the square.
const MAX_ELEMENTS: usize = 500;

/// Corners nearer than this share of the period are one.
const ONE: f64 = 1e-10;

/// Cells of the map of one element.
const SIZE: usize = 2 * NODES;

type Factor = LU<f64, Const<SIZE>, Const<SIZE>>;

/// Where the tip was a delay ago.
#[derive(Debug, Clone)]
enum Source {
    /// At the same node, the period before.
    Same,
    /// In an element of this period or of the one before.
    Within { slot: usize, is_before: bool, weights: [f64; NODES] },
}

/// One term of the force at one node.
#[derive(Debug, Clone)]
struct Force {
    node: usize,
    before: Matrix3x2<f64>,
    source: Source,
}

#[derive(Debug, Clone)]
struct Cutting {
    slot: usize,
    element: usize,
    now: [Matrix3x2<f64>; NODES],
    /// What damps at the nodes, if anything does.
    rate: Option<[Matrix3x2<f64>; NODES]>,
    before: Vec<Force>,
    factor: Factor,
}

#[derive(Debug, Clone)]
enum Stretch {
    Free(Vec<Matrix2<f64>>),
    Cutting(Box<Cutting>),
}

/// Elements by their lengths, which many share.
#[derive(Debug, Clone)]
pub(super) struct Elements {
    pub(super) nodes: Nodes,
    all: Vec<Element>,
}

impl Elements {
    pub(super) fn new() -> Self {
        Self { nodes: Nodes::new(), all: Vec::new() }
    }

    fn of_length(&mut self, modes: &[ToolMode], length_s: f64) -> usize {
        let is_near = |e: &Element| (e.length_s / length_s - 1.0).abs() < 1e-12;
        self.all.iter().position(is_near).unwrap_or_else(|| {
            self.all.push(Element::new(modes, &self.nodes, length_s));
            self.all.len() - 1
        })
    }
}

/// The map of one period at one depth.
#[derive(Debug)]
pub(super) struct Period<'a> {
    modes: &'a [ToolMode],
    elements: &'a Elements,
    stretches: Vec<Stretch>,
    slots: usize,
}

/// A stretch before its map is known.
struct Plan {
    from_s: f64,
    length_s: f64,
    slot: Option<usize>,
}

/// Times at which elements end: the corners of the coefficients, and where a delay brings them.
fn corners(process: &dyn Process, depth_m: f64) -> Vec<f64> {
    let period = process.period_s();
    let own = process.corners_s(depth_m);
    let mut all = own.clone();
    for delay in process.delays_s() {
        all.extend(own.iter().map(|corner| (corner + delay).rem_euclid(period)));
    }
    all.retain(|&time| time > ONE * period && time < (1.0 - ONE) * period);
    all.extend([0.0, period]);
    all.sort_by(f64::total_cmp);
    all.dedup_by(|b, a| *b - *a < ONE * period);
    all
}

/// Stretches with force in elements short enough, those without it whole; `None` where that makes
/// too many.
fn plan(modes: &[ToolMode], process: &dyn Process, depth_m: f64) -> Option<(Vec<Plan>, usize)> {
    let delays = process.delays_s();
    let fastest = modes.iter().map(|mode| mode.omega_rad_per_s).fold(0.0, f64::max);
    let longest = (MAX_OF_MODE_RAD / fastest)
        .min(MAX_OF_FORCE_RAD / process.fastest_rad_per_s())
        .min(delays.iter().copied().fold(f64::INFINITY, f64::min));
    let (mut plans, mut slots) = (Vec::new(), 0);
    for pair in corners(process, depth_m).windows(2) {
        let (from_s, whole) = (pair[0], pair[1] - pair[0]);
        let middle = from_s + 0.5 * whole;
        let has_force = (0..delays.len()).any(|d| process.term(d, middle, depth_m).is_some());
        if !has_force {
            plans.push(Plan { from_s, length_s: whole, slot: None });
            continue;
        }
        let parts = (whole / longest).ceil().max(1.0);
        if slots as f64 + parts > MAX_ELEMENTS as f64 {
            return None;
        }
        let length_s = whole / parts;
        for i in 0..parts as usize {
            let from_s = from_s + i as f64 * length_s;
            plans.push(Plan { from_s, length_s, slot: Some(slots) });
            slots += 1;
        }
    }
    Some((plans, slots))
}

/// Where the tip was at a time of this period, below zero for the one before.
fn source(plans: &[Plan], nodes: &Nodes, period_s: f64, time_s: f64) -> Option<Source> {
    let is_before = time_s < 0.0;
    let at = if is_before { time_s + period_s } else { time_s };
    let distance = |p: &Plan| (p.from_s - at).max(at - p.from_s - p.length_s).max(0.0);
    let nearest = plans
        .iter()
        .filter(|plan| plan.slot.is_some())
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let share = ((at - nearest.from_s) / nearest.length_s).clamp(0.0, 1.0);
    Some(Source::Within { slot: nearest.slot?, is_before, weights: nodes.weights(share) })
}

impl<'a> Period<'a> {
    /// `None` where the period is too long for the fastest mode, or a map is singular, which no cut
    /// of a finite depth is.
    pub(super) fn new(
        modes: &'a [ToolMode],
        process: &dyn Process,
        depth_m: f64,
        elements: &'a mut Elements,
    ) -> Option<Self> {
        let (plans, slots) = plan(modes, process, depth_m)?;
        let lengths: Vec<Option<usize>> =
            plans.iter().map(|p| p.slot.map(|_| elements.of_length(modes, p.length_s))).collect();
        let elements: &'a Elements = elements;
        let period_s = process.period_s();
        let delays = process.delays_s();
        let mut stretches = Vec::with_capacity(plans.len());
        for (plan, element) in plans.iter().zip(lengths) {
            let (Some(slot), Some(element)) = (plan.slot, element) else {
                let through = modes.iter().map(|mode| free(mode, plan.length_s)).collect();
                stretches.push(Stretch::Free(through));
                continue;
            };
            let mut now = [Matrix3x2::zeros(); NODES];
            let mut rate: Option<[Matrix3x2<f64>; NODES]> = None;
            let mut before = Vec::new();
            for (node, share) in elements.nodes.shares.iter().enumerate() {
                let time = plan.from_s + share * plan.length_s;
                for (d, delay) in delays.iter().enumerate() {
                    let Some(term) = process.term(d, time, depth_m) else { continue };
                    let Term { now: of_now, before: of_before, rate: of_rate } = term;
                    now[node] += of_now;
                    if let Some(of_rate) = of_rate {
                        rate.get_or_insert([Matrix3x2::zeros(); NODES])[node] += of_rate;
                    }
                    let source = if (delay / period_s - 1.0).abs() < ONE {
                        Source::Same
                    } else {
                        source(&plans, &elements.nodes, period_s, time - delay)?
                    };
                    before.push(Force { node, before: of_before, source });
                }
            }
            let answer = &elements.all.get(element)?.answer;
            let mut map = SMatrix::<f64, SIZE, SIZE>::identity();
            for (node, now) in now.iter().enumerate() {
                let of_node = answer.fixed_columns::<3>(3 * node) * now;
                let mut columns = map.fixed_columns_mut::<2>(2 * node);
                columns -= of_node;
            }
            for (node, rate) in rate.iter().flatten().enumerate() {
                let of_node = answer.fixed_columns::<3>(3 * node) * rate / plan.length_s;
                for (other, slope) in elements.nodes.slopes[node].iter().enumerate() {
                    let mut columns = map.fixed_columns_mut::<2>(2 * other);
                    columns -= of_node * *slope;
                }
            }
            let factor = map.lu();
            if !factor.is_invertible() {
                return None;
            }
            stretches.push(Stretch::Cutting(Box::new(Cutting {
                slot,
                element,
                now,
                rate,
                before,
                factor,
            })));
        }
        Some(Self { modes, elements, stretches, slots })
    }

    /// Length of the vectors that it maps.
    pub(super) fn size(&self) -> usize {
        2 * self.modes.len() + SIZE * self.slots
    }

    /// One period on.
    pub(super) fn map(&self, from: &DVector<f64>) -> DVector<f64> {
        let of_states = 2 * self.modes.len();
        let mut to = DVector::zeros(from.len());
        let mut states: Vec<State> =
            (0..self.modes.len()).map(|r| Vector2::new(from[2 * r], from[2 * r + 1])).collect();
        for stretch in &self.stretches {
            let cutting = match stretch {
                Stretch::Free(through) => {
                    for (state, through) in states.iter_mut().zip(through) {
                        *state = through * *state;
                    }
                    continue;
                }
                Stretch::Cutting(cutting) => cutting,
            };
            let Some(element) = self.elements.all.get(cutting.element) else { continue };
            let mut forces = [Vector3::zeros(); NODES];
            for force in &cutting.before {
                let place = |slot: usize, node: usize, all: &DVector<f64>| {
                    let at = of_states + SIZE * slot + 2 * node;
                    Vector2::new(all[at], all[at + 1])
                };
                let was = match &force.source {
                    Source::Same => place(cutting.slot, force.node, from),
                    Source::Within { slot, is_before, weights } => {
                        let all = if *is_before { from } else { &to };
                        let parts = weights.iter().enumerate();
                        parts.map(|(node, weight)| place(*slot, node, all) * *weight).sum()
                    }
                };
                forces[force.node] -= force.before * was;
            }
            let mut tip: AtNodes = element.free_at_nodes(self.modes, &states);
            for (node, force) in forces.iter().enumerate() {
                tip += element.answer.fixed_columns::<3>(3 * node) * force;
            }
            cutting.factor.solve_mut(&mut tip);
            for (node, force) in forces.iter_mut().enumerate() {
                *force += cutting.now[node] * Vector2::new(tip[2 * node], tip[2 * node + 1]);
            }
            for ((force, rate), slopes) in forces
                .iter_mut()
                .zip(cutting.rate.iter().flatten())
                .zip(&self.elements.nodes.slopes)
            {
                let moved = slopes.iter().enumerate();
                let moved: Vector2<f64> = moved
                    .map(|(other, slope)| Vector2::new(tip[2 * other], tip[2 * other + 1]) * *slope)
                    .sum();
                *force += rate * moved / element.length_s;
            }
            element.move_on(self.modes, &mut states, &forces);
            to.rows_mut(of_states + SIZE * cutting.slot, SIZE).copy_from(&tip);
        }
        for (r, state) in states.iter().enumerate() {
            to[2 * r] = state[0];
            to[2 * r + 1] = state[1];
        }
        to
    }
}
