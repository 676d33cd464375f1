//! In which the limit of depth at a place lies, with the arm's frequencies as uncertain as they
//! are.
//!
//! A draw moves every frequency of the arm by a multiple of its own standard deviation; a
//! mass-normalised shape stays, so that the stiffness goes with ω². Damping, the tool's modes and
//! the coefficients stay as they are given.

use super::place_limit::{depth_m, exact, grows, zeroth};
use super::tip::{Owner, TipPlace};
use crate::stability::{Cut, DEEPEST_M, Method};
use crate::uncertainty::Draws;

/// Draws of each of the sixteen sequences, at most.
const MAX_PER_SEQUENCE: f64 = 64.0;

/// What is known of the arm's frequencies.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "a function has none")]
pub struct Spread<'a> {
    /// The share of draws that an interval holds.
    pub confidence: f64,
    /// Standard deviation of ln f at a place, 0..=1, of a mode counted from 1.
    pub std_ln: &'a (dyn Fn(f64, usize) -> f64 + Sync),
}

impl Spread<'_> {
    /// The frequencies are those of the model.
    pub const NONE: Self = Self { confidence: 0.95, std_ln: &|_, _| 0.0 };

    /// A place with every frequency of the arm z standard deviations off; z by mode.
    fn drawn(&self, place: &TipPlace, z: &[f64]) -> TipPlace {
        let mut place = place.clone();
        for one in &mut place.modes {
            if let Owner::Arm(number) = one.of {
                let std_ln = (self.std_ln)(place.s, number);
                one.mode.omega_rad_per_s *= (std_ln * z[number - 1]).exp();
            }
        }
        place
    }
}

/// The smallest and the largest limit, m, that few draws lie beyond, `limit_m` by `method` being
/// the one of the model; infinite where there is none below 1 m.
pub(super) fn interval_m(
    (place, cut, regenerates): (&TipPlace, &Cut, bool),
    (limit_m, method): (f64, Method),
    spread: Spread<'_>,
) -> [f64; 2] {
    let of_arm = place.modes.iter().filter_map(|one| match one.of {
        Owner::Arm(number) => Some(number),
        Owner::Tool => None,
    });
    let count = of_arm.max().unwrap_or(0);
    if !(1..=count).any(|number| (spread.std_ln)(place.s, number) > 0.0) {
        return [limit_m; 2];
    }
    // So many that one lies beyond each end.
    let per_sequence = (1.0 / (8.0 * (1.0 - spread.confidence))).ceil().min(MAX_PER_SEQUENCE);
    let draws = Draws::new(count, per_sequence as usize, 1);
    let drawn = (0..draws.count()).map(|i| spread.drawn(place, draws.row(i)));
    let mut all: Vec<(f64, TipPlace)> =
        drawn.map(|place| (depth_m(zeroth(&place, cut, regenerates)), place)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let outside = (0.5 * (1.0 - spread.confidence) * all.len() as f64) as usize;
    let [low, high] = match method {
        Method::Zeroth => [all[outside].0, all[all.len() - 1 - outside].0],
        Method::Exact => {
            let low = || limit_at(End::Low, all.iter(), cut, outside);
            let high = || limit_at(End::High, all.iter().rev(), cut, outside);
            <[f64; 2]>::from(rayon::join(low, high))
        }
    };
    [low.min(limit_m), high.max(limit_m)]
}

/// Which end of the interval.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Low,
    High,
}

/// The limit beyond which `outside` of the draws lie. `draws` come with their limits by the zeroth
/// order, those first that it holds for farthest out: whether another lies farther out than those
/// so far takes one multiplier, where its limit takes thirty.
fn limit_at<'a>(
    end: End,
    draws: impl Iterator<Item = &'a (f64, TipPlace)>,
    cut: &Cut,
    outside: usize,
) -> f64 {
    let mut farthest: Vec<f64> = Vec::new();
    for (nearly_m, place) in draws {
        let solved = || exact(place, cut).map_or(*nearly_m, depth_m);
        let own = match farthest.get(outside) {
            None => solved(),
            Some(&last) if last.is_infinite() && end == End::High => break,
            Some(&last) if last.is_infinite() => solved(),
            Some(&last) => match grows(place, cut, last) {
                Some(grows) if grows == (end == End::High) => continue,
                Some(_) => limit_near(end, place, cut, last).unwrap_or_else(solved),
                None => solved(),
            },
        };
        let is_behind = |other: &f64| match end {
            End::Low => own < *other,
            End::High => own > *other,
        };
        let at = farthest.iter().position(is_behind).unwrap_or(farthest.len());
        farthest.insert(at, own);
        farthest.truncate(outside + 1);
    }
    farthest.last().copied().unwrap_or(f64::INFINITY)
}

/// A limit that lies beyond `from_m`, to a hundredth; `None` where a multiplier is not found.
fn limit_near(end: End, place: &TipPlace, cut: &Cut, from_m: f64) -> Option<f64> {
    const STEP: f64 = 1.1;
    const HALVINGS: usize = 3;
    let [mut stable, mut unstable] = [from_m; 2];
    match end {
        End::Low => loop {
            stable /= STEP;
            if !grows(place, cut, stable)? {
                break;
            }
            unstable = stable;
        },
        End::High => loop {
            unstable *= STEP;
            if unstable > DEEPEST_M {
                return Some(f64::INFINITY);
            }
            if grows(place, cut, unstable)? {
                break;
            }
            stable = unstable;
        },
    }
    for _ in 0..HALVINGS {
        let middle = (stable * unstable).sqrt();
        if grows(place, cut, middle)? { unstable = middle } else { stable = middle }
    }
    Some((stable * unstable).sqrt())
}
