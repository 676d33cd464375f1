//! The arm configuration that a program asks for at a target: kept or refused.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, TAU};

use super::timed_path::{Beside, Knots, Segment, shown_joints};
use crate::model::{InverseKinematics, JointKind, Robot};
use crate::motion::{Configuration, Move, Sides, Target};
use crate::notes::Code;

/// Targets for which other joint positions are searched.
const MAX_SEARCHED: usize = 300;

/// Joints this far beyond the edge of an arm configuration are in it: a target is taught at its
/// edge as often as not, rad.
const SAME_CONFIGURATION: f64 = 0.02;

/// Angles below this are rounding of targets with their three digits, rad.
const ROUNDING: f64 = 2e-4;

/// How far beside an arm configuration a move may end, rad: a quadrant, as the controller compares
/// them; beside stated joint positions nothing, as another elbow may be no quadrant off.
fn slack(lowest: f64, highest: f64) -> f64 {
    SAME_CONFIGURATION + if lowest < highest { FRAC_PI_2 } else { 0.0 }
}

/// Where shoulder, elbow and wrist are at the targets that have been reached, by the names that the
/// program has for it.
#[derive(Debug, Default)]
pub(super) struct KnownSides {
    by_name: HashMap<String, [Option<bool>; 3]>,
}

impl KnownSides {
    /// A move has ended at `q`.
    pub(super) fn note(&mut self, kinematics: &InverseKinematics, a_move: &Move, q: &[f64]) {
        let Some(asked) = sides_of(a_move) else { return };
        if !self.by_name.contains_key(&asked.name) {
            self.by_name.insert(asked.name.clone(), [None; 3]);
        }
        let Some(known) = self.by_name.get_mut(&asked.name) else { return };
        for (known, own) in known.iter_mut().zip(kinematics.sides(q)) {
            *known = known.or(own);
        }
    }

    /// Where they are to be at the end of a move; `None` where that is not known.
    fn at(&self, a_move: &Move) -> [Option<bool>; 3] {
        let known = sides_of(a_move).and_then(|asked| self.by_name.get(&asked.name));
        known.copied().unwrap_or_default()
    }

    /// Whether other joint positions than the nearest of those that reach the target of a move may
    /// be meant: no target before has told what its name means, and the nearest have another
    /// shoulder or elbow than the name seems to say, or, where it says nothing, than before.
    pub(super) fn are_open(
        &self,
        kinematics: &InverseKinematics,
        a_move: &Move,
        from: &[f64],
        found: &[Vec<f64>],
    ) -> bool {
        /// Of an arm of which these are not known others are meant if they are not this many times
        /// as far.
        const FAR: f64 = 3.0;
        let ([nearest, other, ..], Some(asked)) = (found, sides_of(a_move)) else { return false };
        if self.at(a_move)[..2].iter().all(Option::is_some) {
            return false;
        }
        let zero = vec![0.0; from.len()];
        let [before, there, zero] = [from, nearest, &zero].map(|q| kinematics.sides(q));
        if before[..2].iter().chain(&there[..2]).any(Option::is_none) {
            let far = |q: &[f64]| q.iter().zip(from).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            return far(other) < FAR * FAR * far(nearest);
        }
        let is_said = |at: usize| match (zero[at], asked.as_at_zero[at]) {
            (Some(zero), Some(is_same)) => there[at] == Some(zero == is_same),
            _ => there[at] == before[at],
        };
        !(is_said(0) && is_said(1))
    }
}

fn sides_of(a_move: &Move) -> Option<&Sides> {
    a_move.stated.configuration.as_ref()?.sides.as_ref()
}

/// Whether two may be the same, as far as they are known.
fn are_alike(a: [Option<bool>; 3], b: [Option<bool>; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.zip(b).is_none_or(|(a, b)| a == b))
}

/// The joint positions, out of all that reach a target, in the arm configuration that the program
/// asks for there.
pub(super) fn configured(
    robot: &Robot,
    kinematics: &InverseKinematics,
    a_move: &Move,
    known: &KnownSides,
    mut found: Vec<Vec<f64>>,
) -> Result<Vec<Vec<f64>>, (Code, String)> {
    let Some(asked) = &a_move.stated.configuration else { return Ok(found) };
    let nearest = found.first().map_or_else(String::new, |q| shown_joints(robot, q));
    let none = || {
        let what = format!(
            "the program asks for {} here, and no joint positions in it reach the pose; the \
             nearest in another are {nearest}",
            asked.shown
        );
        Err((Code::Unreachable, what))
    };
    let sides = known.at(a_move);
    found.retain(|q| are_alike(sides, kinematics.sides(q)));
    if found.is_empty() {
        return none();
    }
    let into = |slack: fn(f64, f64) -> f64| -> Vec<Vec<f64>> {
        found.iter().filter_map(|q| turned_into(robot, q, asked, slack)).collect()
    };
    let mut fitting = into(|_, _| SAME_CONFIGURATION);
    if fitting.is_empty() {
        fitting = into(slack);
    }
    // Where none is in it, the nearest one is as good, up to a quadrant beside as at the end of a
    // line: frames that were measured anew move a joint across zero.
    let is_in = |q: &Vec<f64>| beyond(asked, q) <= SAME_CONFIGURATION;
    if fitting.iter().any(is_in) {
        fitting.retain(is_in);
    } else {
        let least = fitting.iter().map(|q| beyond_in_all(asked, q)).fold(f64::INFINITY, f64::min);
        fitting.retain(|q| beyond_in_all(asked, q) <= least);
    }
    if fitting.is_empty() { none() } else { Ok(fitting) }
}

/// Where a planned path ends its moves beside the configurations that `moves` ask for.
pub(super) fn beside_configurations(
    robot: &Robot,
    kinematics: &InverseKinematics,
    moves: &[Move],
    knots: &Knots,
    segments: &[Segment],
) -> Vec<Beside> {
    let n = robot.joints().len();
    let mut found = Vec::new();
    for (index, a_move) in moves.iter().enumerate() {
        let Some(asked) = &a_move.stated.configuration else { continue };
        // At the end of a line a quadrant beside is as good.
        if index > 0 && !matches!(a_move.to, Target::JointsTo(_)) {
            continue;
        }
        let behind = segments.partition_point(|segment| segment.index <= index);
        let knot = knots.segment_of.partition_point(|&of| of < behind);
        let q = knots.q.get(knot * n..).and_then(|rest| rest.get(..n));
        let Some(q) = q.filter(|q| beyond(asked, q) > SAME_CONFIGURATION) else { continue };
        let what = format!("{}: {}", asked.shown, shown_joints(robot, q));
        // A search each; beyond that, others may be as near to what is far off.
        let is_open = match found.len() < MAX_SEARCHED {
            true => has_another(robot, kinematics, a_move, q),
            false => beyond_in_all(asked, q) > FRAC_PI_2,
        };
        let is_missed = misses(asked, q);
        found.push(Beside { index, line: a_move.line, what, is_open, is_missed });
    }
    found
}

/// Whether joints lie beside a range that is wider than a quadrant: such a one is the sign or the
/// turn of an axis, which the controller keeps.
fn misses(asked: &Configuration, q: &[f64]) -> bool {
    asked.joints.iter().any(|&(joint, [lowest, highest])| {
        let is_beside = |at: &f64| (lowest - at).max(at - highest) > SAME_CONFIGURATION;
        highest - lowest > FRAC_PI_2 + ROUNDING && q.get(joint).is_some_and(is_beside)
    })
}

/// Whether other joint positions reach the target of a move about as near to the arm configuration
/// that it asks for as `q`.
fn has_another(robot: &Robot, kinematics: &InverseKinematics, a_move: &Move, q: &[f64]) -> bool {
    /// Positions that are no nearer to each other are others, rad.
    const OTHER: f64 = 0.1;
    /// As near: no further off than this many times as far.
    const AS_NEAR: f64 = 1.5;
    let (Some(asked), Target::JointsTo(pose) | Target::Line(pose) | Target::Arc { end: pose, .. }) =
        (&a_move.stated.configuration, &a_move.to)
    else {
        return false;
    };
    let found = kinematics.solutions_near(robot, &a_move.tip(1.0, pose), q);
    let mut fitting = found.iter().filter_map(|q| turned_into(robot, q, asked, slack));
    let own = beyond_in_all(asked, q);
    fitting.any(|other| {
        let is_other = other.iter().zip(q).any(|(a, b)| (a - b).abs() > OTHER);
        is_other && beyond_in_all(asked, &other) <= AS_NEAR * own
    })
}

/// How far the joints are from an arm configuration all together, rad.
fn beyond_in_all(asked: &Configuration, q: &[f64]) -> f64 {
    let own = asked.joints.iter().filter_map(|&(joint, [low, high])| {
        let at = *q.get(joint)?;
        Some((low - at).max(at - high).max(0.0))
    });
    own.sum()
}

/// How far the joints are from an arm configuration, rad; 0 and less within it.
fn beyond(asked: &Configuration, q: &[f64]) -> f64 {
    let own = asked.joints.iter().filter_map(|&(joint, [low, high])| {
        let at = *q.get(joint)?;
        Some((low - at).max(at - high))
    });
    own.fold(0.0, f64::max)
}

/// Joint positions by whole turns in an arm configuration, if they can be.
fn turned_into(
    robot: &Robot,
    q: &[f64],
    asked: &Configuration,
    slack: impl Fn(f64, f64) -> f64,
) -> Option<Vec<f64>> {
    let mut turned = q.to_vec();
    for &(joint, [lowest, highest]) in &asked.joints {
        let own = *q.get(joint)?;
        let moving = robot.joints().get(joint)?;
        let (limit, slides) = (moving.limit, moving.kind == JointKind::Prismatic);
        let whole: &[f64] = if slides { &[0.0] } else { &[0.0, 1.0, -1.0, 2.0, -2.0] };
        let slack = slack(lowest, highest);
        let fits = |at: &f64| {
            let in_limits = limit.is_none_or(|[lower, upper]| (lower..=upper).contains(at));
            (*at == own || in_limits) && (lowest - slack..=highest + slack).contains(at)
        };
        // A joint that rounding puts beside an edge makes no whole turn.
        let beyond = |at: &f64| (lowest - at).max(at - highest).max(ROUNDING) - ROUNDING;
        let fitting = whole.iter().map(|turns| own + turns * TAU).filter(fits);
        let nearest = fitting.min_by(|a, b| beyond(a).total_cmp(&beyond(b)));
        *turned.get_mut(joint)? = nearest?;
    }
    Some(turned)
}

/// Where a line or an arc ends, the controller compares.
pub(super) fn compared(robot: &Robot, a_move: &Move, q: &[f64]) -> Result<(), (Code, String)> {
    let Some(asked) = &a_move.stated.configuration else { return Ok(()) };
    let is_off = asked.joints.iter().find(|(joint, [lowest, highest])| {
        let slack = slack(*lowest, *highest);
        q.get(*joint).is_some_and(|at| !(lowest - slack..=highest + slack).contains(at))
    });
    let Some(&(joint, [lowest, highest])) = is_off else { return Ok(()) };
    let by = if lowest < highest { "more than a quadrant beside it, " } else { "" };
    let what = format!(
        "the program asks for {} here, and the arm comes with joint '{}' {by}at {}",
        asked.shown,
        robot.joints()[joint].name,
        shown_joints(robot, q)
    );
    Err((Code::Unreachable, what))
}
