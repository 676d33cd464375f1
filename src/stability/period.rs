//! The motion over one period as a linear map: of the modes' states, and of where the tip was at
//! the nodes of the elements in which there is force.
//!
//! The state and the tip's places of the period before give those of this one. Where a delay is
//! not the period, the place then is interpolated within the element that it lies in. What damps
//! takes the rate of the tip from the polynomial through its places at the nodes.

use nalgebra::{Const, LU, Matrix2, Matrix3x2, SMatrix, Vector2};

use super::element::{AtNodes, Element, FORCES, NODES, Nodes, PLACES, State, add, free};
use super::milling::{Process, Term};
use super::mode::ToolMode;

/// The fastest mode turns at most this far in an element, rad; so does the force.
const MAX_OF_MODE_RAD: f64 = 3.0;
const MAX_OF_FORCE_RAD: f64 = 1.6;

/// More elements with force than this are refused: their cost grows with the square.
const MAX_ELEMENTS: usize = 500;

/// Corners nearer than this share of the period are one.
const ONE: f64 = 1e-10;

/// The triangles of L·U, columns by columns, zeros beside them so that all are of one length.
#[derive(Debug, Clone)]
struct Factor {
    /// Row of the given vector that comes to each place.
    from: [usize; PLACES],
    lower: [[f64; PLACES]; PLACES],
    upper: [[f64; PLACES]; PLACES],
    /// 1 over the diagonal of U.
    over: [f64; PLACES],
}

impl Factor {
    /// `None` of a singular matrix.
    fn new(matrix: SMatrix<f64, PLACES, PLACES>) -> Option<Self> {
        let factor: LU<f64, Const<PLACES>, Const<PLACES>> = matrix.lu();
        if !factor.is_invertible() {
            return None;
        }
        let mut from = SMatrix::<usize, PLACES, 1>::from_fn(|i, _| i);
        factor.p().permute_rows(&mut from);
        let both = factor.lu_internal();
        Some(Self {
            from: from.data.0[0],
            lower: both.map_with_location(|i, j, x| if i > j { x } else { 0.0 }).data.0,
            upper: both.map_with_location(|i, j, x| if i < j { x } else { 0.0 }).data.0,
            over: std::array::from_fn(|i| both[(i, i)].recip()),
        })
    }

    fn solve(&self, right: &AtNodes) -> AtNodes {
        let mut left = self.from.map(|row| right[row]);
        for (j, column) in self.lower.iter().enumerate() {
            let x = -left[j];
            add(&mut left, column, x);
        }
        for (j, column) in self.upper.iter().enumerate().rev() {
            left[j] *= self.over[j];
            let x = -left[j];
            add(&mut left, column, x);
        }
        left
    }
}

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
    modes: usize,
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
            let mut map = SMatrix::<f64, PLACES, PLACES>::identity();
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
            let factor = Factor::new(map)?;
            stretches.push(Stretch::Cutting(Box::new(Cutting {
                slot,
                element,
                now,
                rate,
                before,
                factor,
            })));
        }
        Some(Self { modes: modes.len(), elements, stretches, slots })
    }

    /// Length of the vectors that it maps.
    pub(super) fn size(&self) -> usize {
        2 * self.modes + PLACES * self.slots
    }

    /// One period on, from one vector to another.
    pub(super) fn map(&self, from: &[f64], to: &mut [f64]) {
        let of_states = 2 * self.modes;
        let mut states = from[..of_states].to_vec();
        for stretch in &self.stretches {
            let cutting = match stretch {
                Stretch::Free(through) => {
                    for (state, through) in states.chunks_exact_mut(2).zip(through) {
                        let end = through * State::new(state[0], state[1]);
                        state.copy_from_slice(end.as_slice());
                    }
                    continue;
                }
                Stretch::Cutting(cutting) => cutting,
            };
            let Some(element) = self.elements.all.get(cutting.element) else { continue };
            let mut forces = [0.0; FORCES];
            for force in &cutting.before {
                let place = |slot: usize, node: usize, all: &[f64]| {
                    let at = of_states + PLACES * slot + 2 * node;
                    Vector2::new(all[at], all[at + 1])
                };
                let was = match &force.source {
                    Source::Same => place(cutting.slot, force.node, from),
                    Source::Within { slot, is_before, weights } => {
                        let all = if *is_before { from } else { &*to };
                        let parts = weights.iter().enumerate();
                        parts.map(|(node, weight)| place(*slot, node, all) * *weight).sum()
                    }
                };
                press(&mut forces, force.node, &-force.before, was);
            }
            let mut tip: AtNodes = element.free_at_nodes(&states);
            for (column, &force) in element.answer.data.0.iter().zip(&forces) {
                add(&mut tip, column, force);
            }
            let tip = cutting.factor.solve(&tip);
            let at = |node: usize| Vector2::new(tip[2 * node], tip[2 * node + 1]);
            for (node, now) in cutting.now.iter().enumerate() {
                press(&mut forces, node, now, at(node));
            }
            let slopes = &self.elements.nodes.slopes;
            for (node, rate) in cutting.rate.iter().flatten().enumerate() {
                let moved: Vector2<f64> =
                    slopes[node].iter().enumerate().map(|(other, slope)| at(other) * *slope).sum();
                press(&mut forces, node, rate, moved / element.length_s);
            }
            element.move_on(&mut states, &forces);
            to[of_states + PLACES * cutting.slot..][..PLACES].copy_from_slice(&tip);
        }
        to[..of_states].copy_from_slice(&states);
    }
}

/// Adds the force at a node that a motion there makes.
fn press(forces: &mut [f64; FORCES], node: usize, by: &Matrix3x2<f64>, moved: Vector2<f64>) {
    for (force, of_moved) in forces[3 * node..].iter_mut().zip((by * moved).iter()) {
        *force += of_moved;
    }
}
