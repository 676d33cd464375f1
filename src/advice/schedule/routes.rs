//! The search over corridors: which gap between the bands to take where, and where to cross a band
//! if it must be.
//!
//! A dynamic programme over the sides of the cells. A state is what a spindle can have reached by a
//! corridor: an interval of speeds, since corridors are convex and acceleration is bounded. It
//! carries a bound below the objective of every speed that goes this way: the squared distance from
//! the target to what can be reached, over time. States that are worse in every respect than
//! another are dropped; so the ways come out in the order of their bounds, and none that can be the
//! best is lost (but for the cap on states kept at one place).
//!
//! A ramp through a band starts at a side of a cell, on the edge of a corridor, and ends where its
//! straight line comes into the next corridor, wherever in a cell that is: however fast the
//! spindle, it is in the band for as long as the band is wide at full acceleration, and no longer.

use super::cells::{Plane, Trapezium};
use crate::advice::speeds::Speeds;
use crate::excitation::ExcitationLine;

/// States kept at one side of a cell.
const MAX_STATES: usize = 48;

/// Ramps through bands are looked for from the best states only.
const MAX_STARTS: usize = 6;

/// What the search goes by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Speeds are given as a share of it.
    pub(super) programmed_rpm: f64,
    /// The speed to stay near to.
    pub(super) target_rpm: f64,
    /// Largest change of speed over the whole path, rev/min.
    pub(super) slope_rpm: f64,
    /// The spindle's own.
    pub(super) min_rpm: f64,
    pub(super) max_rpm: f64,
}

/// A way through the plane.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Route {
    /// The sides of the cells, and the places where ramps end.
    pub(super) s: Vec<f64>,
    /// At each, the speeds that the way leaves open.
    pub(super) bounds: Vec<Speeds>,
    /// No speed on this way has a smaller sum of squared relative distances to the target.
    pub(super) at_least: f64,
    /// Ramps through bands: where they start and end.
    pub(super) ramps: Vec<[f64; 2]>,
}

/// Per cell, what it costs to be in the band of a line and mode there, over the whole path.
pub(super) type Bands = Vec<(Speeds, ExcitationLine, f64)>;

/// What a ramp through bands costs.
pub(super) struct ExposureCost<'a> {
    cells: Vec<Bands>,
    ignores: &'a dyn Fn(ExcitationLine, f64) -> bool,
}

impl<'a> ExposureCost<'a> {
    /// `ignores` says whether the policy ignores a line at a speed.
    pub(super) fn new(cells: Vec<Bands>, ignores: &'a dyn Fn(ExcitationLine, f64) -> bool) -> Self {
        Self { cells, ignores }
    }

    /// In one cell at one speed: the worst of the bands around it.
    fn at(&self, cell: usize, rpm: f64) -> f64 {
        self.cells[cell]
            .iter()
            .filter(|(speeds, line, _)| speeds.contains(rpm) && !(self.ignores)(*line, rpm))
            .fold(0.0, |worst, (_, _, exposure)| worst.max(*exposure))
    }

    /// On a piece of a ramp in one cell, looked at in so many places.
    fn along(&self, cell: usize, ramp: &Ramp, [from_s, to_s]: [f64; 2], places: usize) -> f64 {
        let step = (to_s - from_s) / places as f64;
        let rpm = |i: usize| ramp.rpm_at(from_s + (i as f64 + 0.5) * step);
        (0..places).map(|i| self.at(cell, rpm(i)) * step).sum()
    }
}

/// A straight line at full acceleration.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    from_s: f64,
    from_rpm: f64,
    slope_rpm: f64,
}

impl Ramp {
    fn rpm_at(&self, s: f64) -> f64 {
        self.from_rpm + self.slope_rpm * (s - self.from_s)
    }

    /// Where in a cell the line comes into a corridor out of a band: through its edge, or through
    /// the cell's left side if the line `comes` from another cell.
    fn enters(
        &self,
        [left_s, right_s]: [f64; 2],
        corridor: &Trapezium,
        comes: bool,
    ) -> Option<f64> {
        let [left, right] = [left_s, right_s].map(|s| self.rpm_at(s));
        if comes && corridor.left.contains(left) {
            return Some(left_s);
        }
        let [before, after, beyond] = if self.slope_rpm > 0.0 {
            let Trapezium { left: l, right: r } = corridor;
            [left - l.low_rpm, right - r.low_rpm, r.high_rpm - r.low_rpm]
        } else {
            let Trapezium { left: l, right: r } = corridor;
            [l.high_rpm - left, r.high_rpm - right, r.high_rpm - r.low_rpm]
        };
        let crosses = before < 0.0 && after >= 0.0 && beyond >= 0.0;
        crosses.then(|| left_s + (right_s - left_s) * before / (before - after))
    }
}

#[derive(Debug, Clone, Copy)]
enum Step {
    Corridor {
        cell: usize,
        index: usize,
    },
    /// At full acceleration from a side of a cell to where it comes into a corridor.
    Ramp {
        from: usize,
        ramp: Ramp,
        cell: usize,
        index: usize,
        end_s: f64,
    },
}

#[derive(Debug, Clone, Copy)]
struct State {
    crossings: usize,
    exposure: f64,
    cost: f64,
    reach: Speeds,
    /// Place of its last step in the list of all steps.
    step: Option<usize>,
}

impl State {
    fn key(&self, other: &Self) -> std::cmp::Ordering {
        self.crossings
            .cmp(&other.crossings)
            .then(self.exposure.total_cmp(&other.exposure))
            .then(self.cost.total_cmp(&other.cost))
    }

    /// At least as good in every respect.
    fn covers(&self, other: &Self) -> bool {
        self.key(other).is_le()
            && self.cost <= other.cost
            && self.reach.low_rpm <= other.reach.low_rpm
            && self.reach.high_rpm >= other.reach.high_rpm
    }
}

/// Ways through the plane, the most promising first: those with the fewest ramps through bands, of
/// these the ones with the least exposure, of these the ones nearest to the target. Ramps are
/// sought only with `exposure`.
pub(super) fn routes(
    plane: &Plane,
    limits: &Limits,
    exposure: Option<&ExposureCost>,
) -> Vec<Route> {
    let cells = plane.corridors.len();
    let mut steps: Vec<(Option<usize>, Step)> = Vec::new();
    let mut at: Vec<Vec<State>> = vec![Vec::new(); cells + 1];
    let everything = Speeds { low_rpm: f64::NEG_INFINITY, high_rpm: f64::INFINITY };
    at[0].push(State { crossings: 0, exposure: 0.0, cost: 0.0, reach: everything, step: None });
    for cell in 0..cells {
        let states = prune(std::mem::take(&mut at[cell]), MAX_STATES);
        let width = plane.s[cell + 1] - plane.s[cell];
        let (weight, step_rpm) = (0.5 * width, limits.slope_rpm * width);
        for state in &states {
            for (index, corridor) in plane.corridors[cell].iter().enumerate() {
                let Some((from, reach)) = run(&state.reach, corridor, step_rpm) else {
                    continue;
                };
                let cost = state.cost + weight * (away(from, limits) + away(reach, limits));
                steps.push((state.step, Step::Corridor { cell, index }));
                at[cell + 1].push(State { cost, reach, step: Some(steps.len() - 1), ..*state });
            }
        }
        if let Some(exposure) = exposure.filter(|_| cell > 0) {
            for state in states.iter().take(MAX_STARTS) {
                for rises in [true, false] {
                    let Some((to, next, step)) = ramp(plane, limits, exposure, state, cell, rises)
                    else {
                        continue;
                    };
                    steps.push((state.step, step));
                    at[to].push(State { step: Some(steps.len() - 1), ..next });
                }
            }
        }
    }
    let mut ends = std::mem::take(&mut at[cells]);
    ends.sort_by(State::key);
    ends.truncate(24);
    ends.iter().map(|end| trace(plane, &steps, end)).collect()
}

/// What can be reached at the right side of a corridor, and from where at its left.
fn run(reach: &Speeds, corridor: &Trapezium, step_rpm: f64) -> Option<(Speeds, Speeds)> {
    let from = shared(*reach, corridor.left)?;
    let spread = Speeds { low_rpm: from.low_rpm - step_rpm, high_rpm: from.high_rpm + step_rpm };
    Some((from, shared(spread, corridor.right)?))
}

fn shared(a: Speeds, b: Speeds) -> Option<Speeds> {
    let both = Speeds { low_rpm: a.low_rpm.max(b.low_rpm), high_rpm: a.high_rpm.min(b.high_rpm) };
    (both.low_rpm <= both.high_rpm).then_some(both)
}

/// Squared relative distance from the target.
fn away(reach: Speeds, limits: &Limits) -> f64 {
    let target = limits.target_rpm;
    ((target.clamp(reach.low_rpm, reach.high_rpm) - target) / limits.programmed_rpm).powi(2)
}

/// The best states, without those that another one covers.
fn prune(mut states: Vec<State>, most: usize) -> Vec<State> {
    states.sort_by(State::key);
    let mut kept: Vec<State> = Vec::new();
    for state in states {
        if kept.len() < most && !kept.iter().any(|better| better.covers(&state)) {
            kept.push(state);
        }
    }
    kept
}

/// The ramp at full acceleration that leaves free space at side `from`, to the first corridor that
/// it meets, and the side after it.
fn ramp(
    plane: &Plane,
    limits: &Limits,
    exposure: &ExposureCost,
    state: &State,
    from: usize,
    rises: bool,
) -> Option<(usize, State, Step)> {
    let (from_rpm, slope_rpm) = if rises {
        (state.reach.high_rpm, limits.slope_rpm)
    } else {
        (state.reach.low_rpm, -limits.slope_rpm)
    };
    let ramp = Ramp { from_s: plane.s[from], from_rpm, slope_rpm };
    let first = ramp.rpm_at(plane.s[from + 1]);
    let is_free = plane.corridors[from]
        .iter()
        .any(|corridor| corridor.left.contains(from_rpm) && corridor.right.contains(first));
    if is_free {
        return None;
    }
    let mut exposed = 0.0;
    for cell in from..plane.corridors.len() {
        let sides = [plane.s[cell], plane.s[cell + 1]];
        // A fast spindle is through a band within the first cell: eight places there.
        let looks = if cell == from { 8 } else { 1 };
        let landing = plane.corridors[cell]
            .iter()
            .enumerate()
            .filter_map(|(index, gap)| Some((index, ramp.enters(sides, gap, cell > from)?)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, end_s)) = landing {
            let end_rpm = ramp.rpm_at(end_s);
            let point = Speeds { low_rpm: end_rpm, high_rpm: end_rpm };
            let step_rpm = limits.slope_rpm * (sides[1] - end_s);
            let (_, reach) =
                run(&point, &plane.corridors[cell][index].from(sides, end_s), step_rpm)?;
            exposed += exposure.along(cell, &ramp, [sides[0], end_s], looks);
            let next = State {
                crossings: state.crossings + 1,
                exposure: state.exposure + exposed,
                cost: state.cost,
                reach,
                step: None,
            };
            return Some((cell + 1, next, Step::Ramp { from, ramp, cell, index, end_s }));
        }
        exposed += exposure.along(cell, &ramp, sides, looks);
        if !(limits.min_rpm..=limits.max_rpm).contains(&ramp.rpm_at(sides[1])) {
            return None;
        }
    }
    None
}

impl Trapezium {
    /// What of it lies behind `s`, between the sides of its cell; never empty at `s` but for
    /// rounding.
    fn from(&self, [left_s, right_s]: [f64; 2], s: f64) -> Self {
        /// rev/min: what rounding may take from a place on an edge.
        const NEGLIGIBLE_MOTION: f64 = 1e-6;
        let u = (s - left_s) / (right_s - left_s);
        let at = |a: f64, b: f64| a + (b - a) * u;
        let left = Speeds {
            low_rpm: at(self.left.low_rpm, self.right.low_rpm) - NEGLIGIBLE_MOTION,
            high_rpm: at(self.left.high_rpm, self.right.high_rpm) + NEGLIGIBLE_MOTION,
        };
        Self { left, right: self.right }
    }
}

/// The bounds that a way leaves, from its steps.
fn trace(plane: &Plane, steps: &[(Option<usize>, Step)], end: &State) -> Route {
    let everything = Speeds { low_rpm: f64::NEG_INFINITY, high_rpm: f64::INFINITY };
    let mut bounds = vec![everything; plane.s.len()];
    let mut landings: Vec<(f64, Speeds)> = Vec::new();
    let mut ramps = Vec::new();
    let narrow = |bound: &mut Speeds, by: Speeds| {
        bound.low_rpm = bound.low_rpm.max(by.low_rpm);
        bound.high_rpm = bound.high_rpm.min(by.high_rpm);
    };
    let mut at = end.step;
    while let Some((before, step)) = at.and_then(|at| steps.get(at)) {
        match *step {
            Step::Corridor { cell, index } => {
                let corridor = plane.corridors[cell][index];
                narrow(&mut bounds[cell], corridor.left);
                narrow(&mut bounds[cell + 1], corridor.right);
            }
            Step::Ramp { from, ramp, cell, index, end_s } => {
                let given = |s: f64| Speeds { low_rpm: ramp.rpm_at(s), high_rpm: ramp.rpm_at(s) };
                for (bound, &s) in bounds.iter_mut().zip(plane.s).take(cell + 1).skip(from) {
                    *bound = given(s);
                }
                if end_s >= plane.s[cell + 1] {
                    bounds[cell + 1] = given(end_s);
                } else if end_s > plane.s[cell] {
                    landings.push((end_s, given(end_s)));
                }
                narrow(&mut bounds[cell + 1], plane.corridors[cell][index].right);
                ramps.push([ramp.from_s, end_s]);
            }
        }
        at = *before;
    }
    ramps.reverse();
    let sides = plane.s.iter().copied().zip(bounds);
    let mut all: Vec<(f64, Speeds)> = sides.chain(landings).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (s, bounds) = all.into_iter().unzip();
    Route { s, bounds, at_least: end.cost, ramps }
}
