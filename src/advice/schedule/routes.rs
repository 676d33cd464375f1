//! The search over corridors: which gap between the bands to take where, and where to cross a band if it
//! must be.
//!
//! A dynamic programme over the sides of the cells. A state is what a spindle can have reached by a
//! corridor: an interval of speeds, since corridors are convex and acceleration is bounded. It carries a
//! bound below the objective of every speed that goes this way: the squared distance from the programmed
//! speed to what can be reached, over time. States that are worse in every respect than another are
//! dropped; so the ways come out in the order of their bounds, and none that can be the best is lost
//! (but for the cap on states kept at one place).

use super::super::speeds::Speeds;
use super::cells::{Plane, Trapezium};
use crate::excitation::ExcitationLine;

/// States kept at one side of a cell.
const MOST_STATES: usize = 48;

/// Ways that are told.
const MOST_ROUTES: usize = 24;

/// Ramps through bands are looked for from the best states only.
const MOST_STARTS: usize = 6;

/// What the search goes by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub(super) programmed_rpm: f64,
    /// Largest change of speed from one side of a cell to the next, rev/min.
    pub(super) step_rpm: f64,
    /// The spindle's own.
    pub(super) min_rpm: f64,
    pub(super) max_rpm: f64,
}

/// A way through the plane.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Route {
    /// Per side of a cell, the speeds that the way leaves open.
    pub(super) bounds: Vec<Speeds>,
    /// No speed on this way has a smaller sum of squared relative distances to the programmed one.
    pub(super) at_least: f64,
    /// Ramps through bands: first and last side.
    pub(super) ramps: Vec<(usize, usize)>,
}

/// Per cell, how much it hurts to be in the band of a line and mode there.
pub(super) type Bands = Vec<(Speeds, ExcitationLine, f64)>;

/// What a ramp through bands costs.
pub(super) struct Hurt<'a> {
    cells: Vec<Bands>,
    ignores: &'a dyn Fn(ExcitationLine, f64) -> bool,
}

impl<'a> Hurt<'a> {
    /// `ignores` tells whether a line at a speed is somebody else's business.
    pub(super) fn new(cells: Vec<Bands>, ignores: &'a dyn Fn(ExcitationLine, f64) -> bool) -> Self {
        Self { cells, ignores }
    }

    /// In one cell at one speed: the worst of the bands around it.
    fn at(&self, cell: usize, rpm: f64) -> f64 {
        self.cells[cell]
            .iter()
            .filter(|(speeds, line, _)| speeds.contains(rpm) && !(self.ignores)(*line, rpm))
            .fold(0.0, |worst, (_, _, hurt)| worst.max(*hurt))
    }
}

#[derive(Debug, Clone, Copy)]
enum Step {
    Corridor {
        cell: usize,
        index: usize,
    },
    /// At full acceleration from one side to another, ending at a speed that may be held back.
    Ramp {
        from: usize,
        to: usize,
        start_rpm: f64,
        end_rpm: f64,
        rises: bool,
    },
}

#[derive(Debug, Clone, Copy)]
struct State {
    crossings: usize,
    hurt: f64,
    cost: f64,
    reach: Speeds,
    /// Place of its last step in the list of all steps.
    step: Option<usize>,
}

impl State {
    fn key(&self, other: &Self) -> std::cmp::Ordering {
        self.crossings
            .cmp(&other.crossings)
            .then(self.hurt.total_cmp(&other.hurt))
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

/// Ways through the plane, the most promising first: those with the fewest ramps through bands, of these
/// the ones that hurt least, of these the ones nearest to the programmed speed. Ramps are sought only
/// with `hurt`.
pub(super) fn routes(plane: &Plane, limits: &Limits, hurt: Option<&Hurt>) -> Vec<Route> {
    let cells = plane.corridors.len();
    let mut steps: Vec<(Option<usize>, Step)> = Vec::new();
    let mut at: Vec<Vec<State>> = vec![Vec::new(); cells + 1];
    let everything = Speeds { low_rpm: f64::NEG_INFINITY, high_rpm: f64::INFINITY };
    at[0].push(State { crossings: 0, hurt: 0.0, cost: 0.0, reach: everything, step: None });
    for cell in 0..cells {
        let states = prune(std::mem::take(&mut at[cell]), MOST_STATES);
        let weight = 0.5 * (plane.s[cell + 1] - plane.s[cell]);
        for state in &states {
            for (index, corridor) in plane.corridors[cell].iter().enumerate() {
                let Some((from, reach)) = run(&state.reach, corridor, limits.step_rpm) else {
                    continue;
                };
                let cost = state.cost + weight * (away(from, limits) + away(reach, limits));
                steps.push((state.step, Step::Corridor { cell, index }));
                at[cell + 1].push(State { cost, reach, step: Some(steps.len() - 1), ..*state });
            }
        }
        if let Some(hurt) = hurt.filter(|_| cell > 0) {
            for state in states.iter().take(MOST_STARTS) {
                for rises in [true, false] {
                    let Some((to, next, step)) = ramp(plane, limits, hurt, state, cell, rises)
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
    ends.truncate(MOST_ROUTES);
    ends.iter().map(|end| trace(plane, limits, &steps, end)).collect()
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

/// Squared relative distance from the programmed speed.
fn away(reach: Speeds, limits: &Limits) -> f64 {
    let p = limits.programmed_rpm;
    ((p.clamp(reach.low_rpm, reach.high_rpm) - p) / p).powi(2)
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

/// The ramp at full acceleration that leaves free space at side `from`, to the first corridor that it meets.
fn ramp(
    plane: &Plane,
    limits: &Limits,
    hurt: &Hurt,
    state: &State,
    from: usize,
    rises: bool,
) -> Option<(usize, State, Step)> {
    let (start_rpm, slope) = if rises {
        (state.reach.high_rpm, limits.step_rpm)
    } else {
        (state.reach.low_rpm, -limits.step_rpm)
    };
    let speed = |side: usize| start_rpm + slope * (side - from) as f64;
    let first = Speeds { low_rpm: speed(from + 1), high_rpm: speed(from + 1) };
    let is_free = plane.corridors[from].iter().any(|corridor| {
        corridor.left.contains(start_rpm) && shared(first, corridor.right).is_some()
    });
    if is_free {
        return None;
    }
    let mut hurts = 0.0;
    for to in from + 1..=plane.corridors.len() {
        let rpm = speed(to);
        hurts += hurt.at(to - 1, 0.5 * (speed(to - 1) + rpm));
        // Where the ramp is inside a corridor, or would have passed through it since the side before.
        let side = |corridor: &Trapezium, to: usize| {
            if to < plane.corridors.len() { corridor.left } else { corridor.right }
        };
        let cell = to.min(plane.corridors.len() - 1);
        let before = speed(to - 1);
        let landing = plane.corridors[cell].iter().map(|corridor| side(corridor, to)).find(|gap| {
            if rises {
                gap.high_rpm > before && gap.low_rpm <= rpm
            } else {
                gap.low_rpm < before && gap.high_rpm >= rpm
            }
        });
        if let Some(gap) = landing {
            let end_rpm = rpm.clamp(gap.low_rpm, gap.high_rpm);
            let next = State {
                crossings: state.crossings + 1,
                hurt: state.hurt + hurts,
                cost: state.cost,
                reach: Speeds { low_rpm: end_rpm, high_rpm: end_rpm },
                step: None,
            };
            return Some((to, next, Step::Ramp { from, to, start_rpm, end_rpm, rises }));
        }
        if !(limits.min_rpm..=limits.max_rpm).contains(&rpm) {
            return None;
        }
    }
    None
}

/// The bounds that a way leaves, from its steps.
fn trace(plane: &Plane, limits: &Limits, steps: &[(Option<usize>, Step)], end: &State) -> Route {
    let everything = Speeds { low_rpm: f64::NEG_INFINITY, high_rpm: f64::INFINITY };
    let mut bounds = vec![everything; plane.s.len()];
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
            Step::Ramp { from, to, start_rpm, end_rpm, rises } => {
                let slope = if rises { limits.step_rpm } else { -limits.step_rpm };
                let sides = bounds.iter_mut().enumerate().take(to + 1).skip(from);
                for (side, bound) in sides {
                    let rpm = start_rpm + slope * (side - from) as f64;
                    let rpm = if side == to { end_rpm } else { rpm };
                    *bound = Speeds { low_rpm: rpm, high_rpm: rpm };
                }
                ramps.push((from, to));
            }
        }
        at = *before;
    }
    ramps.reverse();
    Route { bounds, at_least: end.cost, ramps }
}
